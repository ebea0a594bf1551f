//! What runs behind the window: scene, servo, recorder, replay. Knows no GUI library.
//!
//! [`Bench::poll`] is called by the pump thread at display rate; the window only reads ([`Bench::fill`]) and asks.

mod blind;
mod builder;
mod demo;
mod devices;
mod document;
mod edit;
mod exercise;
mod ghosts;
pub(in crate::app) mod job;
mod live;
mod past;
mod playing;
mod recorded;
mod recording;
mod replay;
mod rewriting;
mod rumbling;
mod scenes;

pub use builder::{Source, file_name};
pub use exercise::{Unfinished, Wish, unfinished};
pub use live::FINGERS;

use super::history::History;
use super::messages::{Level, Messages};
use super::state::{Compared, View};
use crate::contact::Touch;
use crate::scenario::{Scene, Use};
use crate::servo::{Fault, FingerRecord, Health, Snapshot};
use builder::{Build, Built};
use demo::Demo;
use devices::Devices;
use document::{Document, Saving};
use edit::Edits;
use exercise::Exercising;
use ghosts::Ghosts;
use job::Job;
use live::Live;
use recording::Recordings;
use replay::{Opening, Replay};
use rewriting::Rewriting;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// A finger that moved less than this since the last frame stands still, mm.
const STILL_MM: f64 = 1e-3;

/// What scenes are built for while a Back view is open.
const PURPOSE: Use = Use {
    fingers: FINGERS,
    live: true,
    drawn: true,
    deformed: true,
    recorded: true,
    plotted: true,
    // Built by its panel, on its own.
    partitioned: false,
    ellipse_edited: false,
    stiffness_edited: false,
    scenario_edited: false,
    listed: false,
    browsed: false,
    ghosts: false,
    compared: false,
    passivity: false,
    bones_drawn: false,
    named: false,
    hands_drawn: false,
    two_eyes: false,
    coloured: false,
};

/// Counts are looked at this often.
const COUNTS: Duration = Duration::from_secs(1);

/// Called when something is new to show.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// A scene that is built and not yet open.
struct Ready {
    built: Built,
    /// Its file, where it was opened; none where the open scene was edited.
    opened: Option<Option<PathBuf>>,
}

/// The bench.
pub struct Bench {
    wake: Wake,
    messages: Messages,
    scene: Option<Arc<Scene>>,
    /// The open scene without what its exercise hides, where that is stated in it.
    blind: Option<Arc<Scene>>,
    /// Whether that is kept from everyone at the window.
    conceals: bool,
    exercise: Option<Exercising>,
    /// A score sheet being written: the page.
    sheet: Option<Job<Result<PathBuf, String>>>,
    generation: u64,
    build: Option<Build>,
    /// The file that the scene being built comes from.
    building_from: Option<PathBuf>,
    /// Built, and waiting for the recording of the scene before it to be finished.
    ready: Option<Ready>,
    edits: Edits,
    document: Document,
    saving: Option<Saving>,
    live: Option<Live>,
    devices: Devices,
    /// Shown until there is a servo.
    no_history: Arc<Mutex<History>>,
    /// A gamepad that tells of force; absent until there was some.
    indicator: Option<crate::device::rumble::Indicator>,
    recordings: Recordings,
    /// The recorder's last failure, told once.
    failure: Option<String>,
    opening: Option<Opening>,
    replay: Option<Replay>,
    /// Overlaid on it, or wished for while it is being opened.
    ghosts: Ghosts,
    rewriting: Rewriting,
    last_poll: Instant,
    demo: Option<Demo>,
    /// The recordings that are compared, in the order in which they were added.
    compared: Arc<Vec<Compared>>,
    force_enabled: bool,
    /// Whether a Back view is open.
    drawn: bool,
    /// Messages told and scene when last looked at, to know whether there is anything new.
    shown: (u64, u64),
    /// Health, late ticks and lost records when last looked at, and when that was.
    counts: (Health, u64, u64),
    counted: Instant,
}

impl Bench {
    /// An empty bench that keeps recordings in `folder`.
    pub fn new(wake: Wake, folder: PathBuf) -> Self {
        Self {
            wake,
            messages: Messages::default(),
            scene: None,
            blind: None,
            conceals: false,
            exercise: None,
            sheet: None,
            generation: 0,
            build: None,
            building_from: None,
            ready: None,
            edits: Edits::default(),
            document: Document::default(),
            saving: None,
            live: None,
            devices: Devices::default(),
            no_history: Arc::default(),
            indicator: None,
            recordings: Recordings::new(folder),
            failure: None,
            opening: None,
            replay: None,
            ghosts: Ghosts::default(),
            rewriting: Rewriting::default(),
            last_poll: Instant::now(),
            demo: None,
            compared: Arc::default(),
            force_enabled: true,
            drawn: true,
            shown: (0, 0),
            counts: Default::default(),
            counted: Instant::now(),
        }
    }

    /// Adds a message.
    pub fn tell(&mut self, level: Level, text: impl Into<String>) {
        self.messages.tell(level, text);
        (self.wake)();
    }

    /// Forgets all messages.
    pub fn clear_messages(&mut self) {
        self.messages.clear();
    }

    /// Switches force output: off is the emergency stop.
    pub fn enable_force(&mut self, on: bool) {
        if let Some(live) = &mut self.live {
            live.enable_force(on);
        }
        if on != self.force_enabled {
            self.force_enabled = on;
            if on {
                self.tell(Level::Info, "Force is on");
            } else {
                self.tell(
                    Level::Warning,
                    "Force is off: every device is at zero force",
                );
            }
        }
    }

    /// Starts the servo's timing statistics anew.
    pub fn reset_timing(&mut self) {
        if let Some(live) = &mut self.live {
            live.reset_timing();
        }
    }

    /// Takes in what is new and answers whether there is anything to draw.
    pub fn poll(&mut self) -> bool {
        let now = Instant::now();
        let dt_s = now.duration_since(self.last_poll).as_secs_f64();
        self.last_poll = now;
        let mut changed = self.poll_build();
        changed |= self.poll_ready();
        changed |= self.poll_opening();
        changed |= self.poll_ghosts();
        changed |= self.poll_rewriting();
        changed |= self.poll_saving();
        changed |= self.poll_live();
        self.rumble();
        changed |= self.poll_devices();
        changed |= self.poll_halt();
        changed |= self.poll_edits();
        changed |= self.poll_exercise();
        changed |= self.poll_sheet();
        changed |= self.poll_recorder();
        if let Some(replay) = &mut self.replay {
            changed |= replay.playback().advance(dt_s);
            changed |= replay.follow_past();
            let first_s = replay.first_contact_s();
            changed |= self.ghosts.follow(replay.playback().at_s(), first_s);
            let (moved_on, remark) = replay.follow_edits(&self.wake);
            changed |= moved_on;
            if let Some(remark) = remark {
                self.tell(Level::Warning, remark);
            }
        }
        if let (Some(demo), Some(live), Some(scene)) = (&mut self.demo, &self.live, &self.scene) {
            demo.advance(dt_s, scene, live.hands());
        }
        changed |= self.anything_told();
        changed |= now.duration_since(self.counted) >= COUNTS && self.any_count_changed(now);
        changed
    }

    fn anything_told(&mut self) -> bool {
        let shown = (self.messages.told(), self.generation);
        std::mem::replace(&mut self.shown, shown) != shown
    }

    /// Counts and health of the servo: on a busy machine they change all the time, which is not worth a frame each.
    fn any_count_changed(&mut self, now: Instant) -> bool {
        self.counted = now;
        let counts = self.live.as_ref().map_or_else(Default::default, |live| {
            let s = live.snapshot();
            (s.health, s.timing.late_ticks, s.timing.lost_records)
        });
        std::mem::replace(&mut self.counts, counts) != counts
    }

    fn poll_live(&mut self) -> bool {
        let Some(live) = &mut self.live else {
            return false;
        };
        let before = *live.snapshot();
        let fault_before = before.health == Health::Fault;
        live.poll();
        let after = *live.snapshot();
        if after.health == Health::Fault && !fault_before {
            let text = match live.fault() {
                Some(Fault::Hung) => "The servo hangs: a device does not return. Force is zero",
                Some(Fault::Panicked) => "A device failed and was closed. Force is zero",
                None => "A device does not answer. Force is zero",
            };
            let mut fingers = after.record.fingers().iter().enumerate();
            let untold =
                fingers.any(|(i, f)| !f.reading.is_usable() && !self.devices.tells_itself(i));
            if live.fault().is_some() || untold {
                self.tell(Level::Error, text);
            }
        }
        something_happens(&before, &after)
    }

    /// Whether anyone plots: without, no history is kept.
    pub fn set_plotted(&mut self, on: bool) {
        if let Some(live) = &self.live {
            live.set_plotted(on);
        }
    }

    /// Lets the fingers press by themselves, for pictures.
    pub fn press(&mut self) {
        self.demo = Some(Demo::default());
    }

    /// Finishes a running recording and stops the servo.
    pub fn shut_down(&mut self) {
        self.build = None;
        self.opening = None;
        self.keep_unsaved();
        self.recordings.wait();
        self.close_exercise();
        self.recordings.wait();
        self.live = None;
    }

    /// Writes what panels may read into `view`: with what an exercise hides for somebody who may see it.
    pub fn fill(&self, view: &mut View, sees_truth: bool) {
        view.scene.clone_from(&self.scene);
        view.scene_generation = self.generation;
        view.edit = self.edits.applied();
        view.unsaved = self.is_edited();
        view.saved = self.saved_text();
        view.build = match (&self.build, &self.opening) {
            (Some(build), _) => Some(build.status()),
            (None, Some(opening)) => Some(opening.status()),
            (None, None) => self.ghosts.opening().or(self.rewriting.status()),
        };
        view.force_enabled = self.force_enabled;
        view.compared = self.compared.clone();
        view.ghosts = self.ghosts.view();
        view.alignment = self.ghosts.alignment();
        view.messages = self.messages.list();
        view.recorder = self.recordings.status(self.live.as_ref());
        view.recorder.failed.clone_from(&self.failure);
        view.recorder.compresses = self.rewriting.compresses;
        match &self.live {
            Some(live) => {
                view.live = *live.snapshot();
                view.fingers = view.live.record.fingers().to_vec();
                view.history = live.history().clone();
                view.hands = live.hands().cloned().collect();
                view.devices = live.devices().map(|(name, _)| name.to_owned()).collect();
                view.ring_bytes = live.ring_bytes();
            }
            None => {
                view.live = Snapshot::default();
                view.fingers.clear();
                view.history = self.no_history.clone();
                view.hands.clear();
                view.devices.clear();
                view.ring_bytes = 0;
            }
        }
        view.hardware = Arc::new(self.hardware());
        view.playback = self.replay.as_ref().map(Replay::status);
        if let Some(replay) = &self.replay {
            view.fingers = replay.fingers();
            view.history = replay.history().clone();
            if let Some(scene) = replay.scene() {
                view.scene = Some(scene.clone());
                view.edit = replay.scenes_shown();
            }
        }
        self.fill_exercise(view, sees_truth);
        if view.blind {
            // The text of the file has what is hidden.
            view.saved = None;
        }
    }

    /// How many messages were told so far.
    pub fn told(&self) -> u64 {
        self.messages.told()
    }
}

/// Whether a finger touches or moved, or force was switched.
fn something_happens(before: &Snapshot, after: &Snapshot) -> bool {
    let moved = |a: &FingerRecord, b: &FingerRecord| {
        let by = (a.reading.position_mm - b.reading.position_mm).length();
        by > STILL_MM || by.is_nan() || a.contact.touch != b.contact.touch
    };
    let touching = after
        .record
        .fingers()
        .iter()
        .any(|f| f.contact.touch != Touch::Free);
    let (a, b) = (before.record.fingers(), after.record.fingers());
    touching
        || before.force_enabled != after.force_enabled
        || a.len() != b.len()
        || a.iter().zip(b).any(|(a, b)| moved(a, b))
}
