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
mod recording;
mod replay;
mod rewriting;
mod rumbling;

pub use builder::{Source, file_name};
pub use exercise::{Unfinished, Wish, unfinished};
pub use live::FINGERS;

use super::history::History;
use super::messages::{Level, Messages};
use super::state::{Alignment, Compared, View};
use crate::contact::Touch;
use crate::scenario::{self, BuildError, Scene, Use};
use crate::servo::{Fault, FingerRecord, Health, Snapshot};
use crate::session::RecorderState;
use builder::{Build, Built};
use demo::Demo;
use devices::Devices;
use document::{Document, Saving};
use edit::Edits;
use exercise::Exercising;
use ghosts::Ghosts;
use job::Job;
use live::Live;
use recording::{Done, Recordings};
use replay::{Opening, Replay};
use rewriting::Rewriting;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// A finger that moved less than this since the last frame stands still, mm.
const STILL_MM: f64 = 1e-3;

/// Defects of a mesh that are told one by one.
const DEFECTS_TOLD: usize = 5;

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

    /// Starts building a scene; one that is being built is cancelled.
    pub fn open(&mut self, source: Source) {
        if self.is_blind() {
            let text = "An exercise runs: end it before you open another scene";
            self.tell(Level::Warning, text);
            return;
        }
        let path = match &source {
            Source::File(path) => Some(path.clone()),
            Source::Example(_) | Source::Text { .. } => None,
        };
        match builder::build(source, self.purpose(), self.wake.clone()) {
            Ok(build) => (self.build, self.building_from) = (Some(build), path),
            Err(e) => self.tell(Level::Error, format!("the builder cannot start: {e}")),
        }
    }

    /// What a scene is built for at this moment: what is open and what is asked for.
    fn purpose(&self) -> Use {
        Use {
            drawn: self.drawn,
            deformed: self.drawn,
            ..PURPOSE
        }
    }

    /// Opens an embedded example by its file name.
    pub fn open_example(&mut self, file: &str) {
        match scenario::examples().iter().find(|e| e.file == file) {
            Some(example) => self.open(Source::Example(*example)),
            None => self.tell(Level::Error, format!("there is no example named {file}")),
        }
    }

    /// Stops building.
    pub fn cancel_build(&mut self) {
        if let Some(build) = &self.build {
            build.cancel();
        }
        if let Some(opening) = &self.opening {
            opening.cancel();
        }
        self.rewriting.cancel();
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

    fn poll_build(&mut self) -> bool {
        let Some(build) = &self.build else {
            return false;
        };
        let Some(result) =
            build.poll(|| Err(BuildError("the builder stopped unexpectedly".into())))
        else {
            return false;
        };
        let cancelled = build.is_cancelled();
        self.build = None;
        match result {
            Ok(built) => {
                let opened = Some(self.building_from.take());
                self.ready = Some(Ready { built, opened });
            }
            Err(e) if cancelled || e.0 == BuildError::CANCELLED => {
                self.tell(Level::Info, "Building was cancelled");
            }
            Err(e) => self.tell(Level::Error, e.0),
        }
        true
    }

    /// A recording holds one scene, or it could not be repeated: it is finished before the next scene is felt.
    fn poll_ready(&mut self) -> bool {
        if self.ready.is_none() {
            return false;
        }
        if self.is_recording() && !self.recordings.is_busy() {
            self.tell(Level::Info, "The recording ends with its scene");
            self.toggle_recording();
        }
        if !self.is_recording()
            && !self.recordings.is_busy()
            && self.saving.is_none()
            && let Some(ready) = self.ready.take()
        {
            match ready.opened {
                Some(path) if self.keep_unsaved() => {
                    self.document = Document::opened(path, &ready.built.scene.scenario.source);
                    self.generation += 1;
                    self.set_scene(ready.built);
                }
                Some(_) => {}
                // The same document: who edits it goes on.
                None => self.set_scene(ready.built),
            }
        }
        true
    }

    fn set_scene(&mut self, built: Built) {
        self.close_exercise();
        let Built { scene, blind } = built;
        if let Some(units) = &scene.mesh_units {
            self.tell(Level::Info, format!("{}: {units}", scene.mesh_origin));
        }
        let defects = &scene.report.defects;
        for defect in defects.iter().take(DEFECTS_TOLD) {
            self.tell(Level::Warning, format!("{}: {defect}", scene.mesh_origin));
        }
        if let Some(more) = defects.len().checked_sub(DEFECTS_TOLD + 1) {
            let text = format!("{}: and {} more defects", scene.mesh_origin, more + 1);
            self.tell(Level::Warning, text);
        }
        let felt = blind.as_ref().filter(|_| self.conceals).unwrap_or(&scene);
        match &mut self.live {
            Some(live) => live.set_scene(felt),
            None => match Live::start(felt, self.force_enabled) {
                Ok(live) => self.live = Some(live),
                Err(e) => self.tell(Level::Error, format!("the servo cannot start: {e}")),
            },
        }
        self.edits.begin(&scene);
        (self.scene, self.blind) = (Some(scene), blind);
        // A view may have opened or closed while it was built.
        self.start_edit();
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

    fn poll_opening(&mut self) -> bool {
        let Some(opened) = self
            .opening
            .as_ref()
            .and_then(|o| o.poll(|| Err("the recording could not be read".into())))
        else {
            return false;
        };
        self.opening = None;
        match opened {
            Ok((replay, remarks)) => {
                for remark in remarks {
                    self.tell(Level::Warning, remark);
                }
                self.ghosts.remove(replay.path());
                self.replay = Some(replay);
                self.generation += 1;
            }
            Err(e) => {
                if self.replay.is_none() {
                    self.ghosts.clear();
                }
                self.tell(Level::Error, e);
            }
        }
        true
    }

    fn poll_ghosts(&mut self) -> bool {
        if self.ghosts.is_empty() {
            return false;
        }
        let told = self.ghosts.poll(&self.wake);
        for opened in &told {
            match opened {
                Ok(name) => self.tell(Level::Info, format!("{name} is overlaid")),
                Err(e) => self.tell(Level::Error, e.as_str()),
            }
        }
        !told.is_empty()
    }

    fn poll_recorder(&mut self) -> bool {
        let state = self.live.as_ref().map(|l| l.recorder().status().state);
        let failure = match &state {
            Some(RecorderState::Failed { reason }) => Some(reason.clone()),
            _ => None,
        };
        if failure != self.failure {
            self.failure.clone_from(&failure);
            if let Some(reason) = failure {
                self.tell(Level::Error, format!("recording stopped: {reason}"));
            }
        }
        match self.recordings.poll() {
            Some(Done::Started(path)) => {
                self.tell(Level::Info, format!("Recording to {}", path.display()));
            }
            Some(Done::Finished(summary)) => {
                self.tell(
                    Level::Info,
                    format!(
                        "Recorded {:.1} s, {} ticks, to {}",
                        summary.seconds,
                        summary.ticks,
                        summary.path.display()
                    ),
                );
                self.compress_finished(summary.path.clone());
                if summary.lost > 0 {
                    self.tell(
                        Level::Warning,
                        format!("{} records were lost", summary.lost),
                    );
                }
            }
            Some(Done::Quiet) => {}
            Some(Done::Copied(path)) => {
                self.tell(Level::Info, format!("Saved {}", path.display()));
            }
            Some(Done::Failed(text)) => self.tell(Level::Error, text),
            None => return matches!(state, Some(RecorderState::Recording { .. })),
        }
        true
    }

    /// Whether ticks are written to a file.
    pub fn is_recording(&self) -> bool {
        self.live
            .as_ref()
            .is_some_and(|l| matches!(l.recorder().status().state, RecorderState::Recording { .. }))
    }

    /// Begins a recording, or finishes the one that runs.
    pub fn toggle_recording(&mut self) {
        if self.exercise.is_some() {
            let text = "An exercise runs: each of its trials is recorded by itself";
            self.tell(Level::Warning, text);
            return;
        }
        if self.recordings.is_busy() {
            return;
        }
        let recording = self.is_recording();
        let (Some(live), Some(scene)) = (&self.live, &self.scene) else {
            self.tell(
                Level::Warning,
                "there is nothing to record yet: open a scene first",
            );
            return;
        };
        let recorder = live.recorder().clone();
        let started = if recording {
            self.recordings.stop(recorder).map_err(|e| e.to_string())
        } else {
            let header = recording::header(scene, live, self.edits.settled());
            self.recordings
                .start(recorder, header, scene.scenario.folder.clone())
                .map_err(|e| e.to_string())
        };
        if let Err(e) = started {
            self.tell(Level::Error, format!("cannot record: {e}"));
        }
    }

    /// Reads a recording and replays it.
    pub fn open_recording(&mut self, path: PathBuf) {
        if self.is_blind() {
            let text = "An exercise runs: end it before you open a recording";
            self.tell(Level::Warning, text);
            return;
        }
        let opening = replay::open(path, self.scene.clone(), PURPOSE, self.wake.clone());
        match opening {
            Ok(opening) => self.opening = Some(opening),
            Err(e) => self.tell(Level::Error, format!("the reader cannot start: {e}")),
        }
    }

    /// Shows the fingers as they are now.
    pub fn close_recording(&mut self) {
        self.ghosts.clear();
        if self.replay.take().is_some() {
            self.generation += 1;
        }
    }

    /// Overlays recordings on the one that is replayed.
    pub fn add_ghosts(&mut self, paths: Vec<PathBuf>) {
        if self.replay.is_none() && self.opening.is_none() {
            let text = "Open a recording first: ghosts move with its time";
            self.tell(Level::Warning, text);
            return;
        }
        for path in paths {
            if let Err(e) = self.ghosts.add(path, &self.wake) {
                self.tell(Level::Warning, e);
                return;
            }
        }
    }

    /// Takes a ghost away.
    pub fn remove_ghost(&mut self, path: &Path) {
        self.ghosts.remove(path);
    }

    /// Shows a ghost later, s, or earlier.
    pub fn set_ghost_offset(&mut self, path: &Path, offset_s: f64) {
        self.ghosts.set_offset(path, offset_s);
    }

    /// What makes the times of the ghosts that of the open recording.
    pub fn align_ghosts(&mut self, alignment: Alignment) {
        self.ghosts.align(alignment);
    }

    /// Notes something in the recording that is being written.
    pub fn mark(&mut self, text: &str) {
        let noted = match &self.live {
            Some(live) if self.is_recording() => live.recorder().mark("mark", text.trim()),
            _ => {
                self.tell(
                    Level::Warning,
                    "There is no recording to mark: start one first",
                );
                return;
            }
        };
        if noted {
            self.tell(Level::Info, "Marked");
        } else {
            self.tell(
                Level::Warning,
                "The mark was not written: the recorder is behind",
            );
        }
    }

    /// Gives new recordings a pseudonym; none when empty.
    pub fn set_participant(&mut self, name: String) {
        self.recordings.set_participant(name);
    }

    /// Pauses at each event of the open recording, or plays past them.
    pub fn set_following(&mut self, on: bool) {
        if let Some(replay) = &mut self.replay {
            replay.playback().set_follow(on);
        }
    }

    /// Goes to the next event of the open recording, or to the one before.
    pub fn seek_event(&mut self, next: bool) {
        if let Some(replay) = &mut self.replay {
            let playback = replay.playback();
            playback.pause();
            let _ = if next {
                playback.seek_next_event()
            } else {
                playback.seek_previous_event()
            };
        }
    }

    /// The recording that "save as" means: the open one, else the newest.
    pub fn recording_to_save(&self) -> Option<PathBuf> {
        match &self.replay {
            Some(replay) => Some(replay.path().to_owned()),
            None => self.recordings.newest().map(Path::to_owned),
        }
    }

    /// Copies a recording.
    pub fn copy_recording(&mut self, from: &Path, to: &Path) {
        if let Err(e) = self.recordings.copy(from, to) {
            self.tell(
                Level::Error,
                format!("{}: cannot be written: {e}", to.display()),
            );
        }
    }

    /// Adds recordings to those that are compared; one that is there already has its tags anew.
    pub fn compare(&mut self, recordings: Vec<Compared>) {
        let compared = Arc::make_mut(&mut self.compared);
        for recording in recordings {
            match compared.iter_mut().find(|c| c.path == recording.path) {
                Some(there) => *there = recording,
                None => compared.push(recording),
            }
        }
    }

    /// Gives a recording its tags anew where it is compared.
    pub fn retag(&mut self, recording: Compared) {
        if self.compared.iter().any(|c| c.path == recording.path) {
            self.compare(vec![recording]);
        }
    }

    /// Takes a recording out of those that are compared.
    pub fn uncompare(&mut self, path: &Path) {
        Arc::make_mut(&mut self.compared).retain(|c| c.path != path);
    }

    /// Where recordings are kept.
    pub fn folder(&self) -> &Path {
        self.recordings.folder()
    }

    /// Goes to a time of the open recording, s.
    pub fn seek(&mut self, time_s: f64) {
        if let Some(replay) = &mut self.replay {
            replay.playback().seek_s(time_s);
        }
    }

    /// Lets time of the open recording run or stand.
    pub fn set_playing(&mut self, on: bool) {
        if let Some(replay) = &mut self.replay {
            let playback = replay.playback();
            if on {
                playback.play();
            } else {
                playback.pause();
            }
        }
    }

    /// Lets time of the open recording run, or stand if it runs.
    pub fn play_or_pause(&mut self) {
        if let Some(replay) = &mut self.replay {
            replay.playback().toggle();
        }
    }

    /// Replays at this speed, 1 is real time.
    pub fn set_speed(&mut self, speed: f64) {
        if let Some(replay) = &mut self.replay {
            replay.playback().set_speed(speed);
        }
    }

    /// Starts over at the end, or stays there.
    pub fn set_looped(&mut self, on: bool) {
        if let Some(replay) = &mut self.replay {
            replay.playback().set_looping(on);
        }
    }

    /// Goes some ticks on, or back.
    pub fn step(&mut self, ticks: i64) {
        if let Some(replay) = &mut self.replay {
            replay.playback().step(ticks);
        }
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
