//! What panels may read: one plain value per frame.

use super::hardware::Hardware;
use super::history::History;
use super::messages::Message;
use super::roles::Role;
use super::study::SharedStudy;
use super::theme::Theme;
use crate::device::mouse::MouseHandle;
use crate::geom::{Vec2, Vec3};
use crate::scenario::{Item, Scene, Use};
use crate::servo::{FingerRecord, Snapshot};
use crate::training::{Shown, TrialRecord};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// The state of the workbench at one frame. Cheap to clone: large parts are shared.
#[derive(Clone)]
pub struct View {
    /// The open scene; `None` while the first one is built.
    pub scene: Option<Arc<Scene>>,
    /// Counts scenes opened; changes whenever `scene` becomes another one. An edited scene is the same one: see `edit`.
    pub scene_generation: u64,
    /// Counts edits of the open scene: while `scene_generation` stays, `scene` changes with it. Surface and search structure
    /// are then the same ones; maps, fields and settings of the deformation may be others.
    pub edit: u64,
    /// Whether the open scene was edited since it was opened or saved.
    pub unsaved: bool,
    /// The open scene's text as in its file, or as it was opened where it has none.
    pub saved: Option<Arc<str>>,
    /// Whether the truth is kept from whoever looks: `scene` is then one without it, and panels leave out what fingers tell of
    /// stiffness.
    pub blind: bool,
    /// What the scene is used for at the moment: it decides what must exist beside it.
    pub purpose: Use,
    /// What panels built for it.
    pub parts: Parts,
    /// The tree of cells under study, for the panels that show it.
    pub study: SharedStudy,
    /// The scene being built.
    pub build: Option<BuildStatus>,
    /// The fingers shown now: the newest tick, or the replayed instant.
    pub fingers: Vec<FingerRecord>,
    /// The live servo, also while a recording is replayed.
    pub live: Snapshot,
    /// The recording on show; `None` while live.
    pub playback: Option<PlaybackStatus>,
    /// Recordings overlaid on the one on show.
    pub ghosts: Vec<GhostView>,
    /// How they are aligned with it.
    pub alignment: Alignment,
    /// The recordings that are compared.
    pub compared: Arc<Vec<Compared>>,
    /// What the recorder does.
    pub recorder: RecorderStatus,
    /// Memory of the servo's ring and of what drains it, bytes; 0 while no servo runs.
    pub ring_bytes: usize,
    /// The plotted past.
    pub history: Arc<Mutex<History>>,
    /// Moves the mouse fingers: one per finger that is moved by the mouse, in the order of the fingers.
    pub hands: Vec<MouseHandle>,
    /// Names of the devices, one per finger.
    pub devices: Vec<String>,
    /// What is attached, and what moves each finger.
    pub hardware: Arc<Hardware>,
    /// Whether devices may render force; off after an emergency stop.
    pub force_enabled: bool,
    /// What the workbench had to say, oldest first.
    pub messages: Arc<Vec<Message>>,
    /// Whose workspace it is shown in.
    pub role: Role,
    /// Whether the trainee has a window of its own.
    pub trainee_window: bool,
    /// The exercise that runs, as far as the reader may know it.
    pub exercise: Option<ExerciseView>,
    /// The window's GL context; `None` without one (tests).
    pub gl: Option<Arc<eframe::glow::Context>>,
    /// How long frames take.
    pub frame: FrameTiming,
    /// The colours.
    pub theme: Theme,
}

impl Default for View {
    /// An empty bench: no scene, no finger, nothing recorded.
    fn default() -> Self {
        Self {
            scene: None,
            scene_generation: 0,
            edit: 0,
            unsaved: false,
            saved: None,
            purpose: Use::default(),
            parts: Parts::default(),
            study: SharedStudy::default(),
            build: None,
            fingers: Vec::new(),
            live: Snapshot::default(),
            playback: None,
            ghosts: Vec::new(),
            alignment: Alignment::default(),
            compared: Arc::default(),
            recorder: RecorderStatus::default(),
            ring_bytes: 0,
            history: Arc::default(),
            hands: Vec::new(),
            devices: Vec::new(),
            hardware: Arc::default(),
            force_enabled: true,
            messages: Arc::default(),
            role: Role::default(),
            trainee_window: false,
            blind: false,
            exercise: None,
            gl: None,
            frame: FrameTiming::default(),
            theme: super::theme::DARK,
        }
    }
}

/// An exercise that runs, as far as its reader may know it.
#[derive(Clone, Debug, PartialEq)]
pub struct ExerciseView {
    /// What may be shown of the trial at hand.
    pub shown: Shown,
    /// Whether the next trial can start: its scene is built, and the recording of the one before is finished.
    pub prepared: bool,
    /// What is hidden in the trial at hand, in words; `None` for who may not know, or while it is built.
    pub truth: Option<Vec<String>>,
    /// Where that is on the map plane, mm.
    pub truth_mm: Vec<Vec2>,
    /// Where the threshold is by now, in words; `None` for who may not know.
    pub threshold: Option<String>,
    /// Trials settled so far; none of them for the trainee before the end.
    pub settled: Vec<TrialRecord>,
    /// Where answers and recordings are kept.
    pub folder: PathBuf,
}

/// What a part that a panel built holds and costs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartCost {
    /// Bytes held.
    pub bytes: usize,
    /// Measured cost, µs, and what it is paid per: "frame" or "build".
    pub cost_us: Option<(f64, &'static str)>,
}

/// What panels built for the scene, for the ledger. Panels write, the Scene panel reads.
#[derive(Clone, Debug, Default)]
pub struct Parts(Arc<Mutex<BTreeMap<Item, PartCost>>>);

impl Parts {
    /// Notes what `item` holds and costs now.
    pub fn report(&self, item: Item, cost: PartCost) {
        self.lock().insert(item, cost);
    }

    /// Notes that `item` is gone.
    pub fn remove(&self, item: Item) {
        self.lock().remove(&item);
    }

    /// Whether `item` is there.
    pub fn has(&self, item: Item) -> bool {
        self.lock().contains_key(&item)
    }

    /// What was reported.
    pub fn list(&self) -> Vec<(Item, PartCost)> {
        self.lock().iter().map(|(i, c)| (*i, *c)).collect()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, BTreeMap<Item, PartCost>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// How far the building of a scene is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BuildStatus {
    /// The scenario's name or file.
    pub scenario: String,
    /// The part being built.
    pub part: String,
    /// Done, 0 to 1.
    pub fraction: f64,
}

/// Where a replayed recording stands.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaybackStatus {
    /// The file.
    pub path: PathBuf,
    /// Time from its start, s.
    pub time_s: f64,
    /// Its length, s.
    pub duration_s: f64,
    /// Whether time runs.
    pub playing: bool,
    /// Speed, 1 is real time.
    pub speed: f64,
    /// Whether it starts over at the end.
    pub looped: bool,
    /// Whether playing pauses at each event.
    pub following: bool,
    /// What happened in it, in the order written.
    pub events: Arc<[RecordedEvent]>,
    /// Share of it that the plots have, 0 to 1; `None` once they have all.
    pub plotted: Option<f64>,
    /// What is wrong with the file.
    pub damage: Option<String>,
}

impl Default for PlaybackStatus {
    /// At the start of a recording without a name and without length.
    fn default() -> Self {
        Self {
            path: PathBuf::new(),
            time_s: 0.0,
            duration_s: 0.0,
            playing: false,
            speed: 1.0,
            looped: false,
            following: false,
            events: Arc::default(),
            plotted: None,
            damage: None,
        }
    }
}

/// Something that happened while a recording was made.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedEvent {
    /// Time from the start of the recording, s.
    pub time_s: f64,
    /// What it is: a mark, an answer, lost ticks …
    pub kind: String,
    /// More of it.
    pub text: String,
}

/// A recording that is compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Compared {
    /// The file.
    pub path: PathBuf,
    /// What the user wrote on it: groups are made by that.
    pub tags: Vec<String>,
}

/// What makes the times of two recordings one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Alignment {
    /// Their starts.
    #[default]
    Start,
    /// The first touch of the skin in each.
    FirstContact,
}

/// A recording that is overlaid on the one on show.
#[derive(Clone, Debug)]
pub struct GhostView {
    /// The file.
    pub path: PathBuf,
    /// Whose it is.
    pub name: String,
    /// Which of [`Theme::ghosts`] it wears.
    pub colour: usize,
    /// How much later the user has it shown, s.
    pub offset_s: f64,
    /// How much later it is shown in all, s: its own time is that of the recording on show less this.
    pub shift_s: f64,
    /// Its fingers; none before its start and after its end.
    pub trails: Arc<[Trail]>,
    /// Its plotted past, in its own time.
    pub history: Arc<Mutex<History>>,
    /// Share of it that the plots have, 0 to 1; `None` once they have all.
    pub plotted: Option<f64>,
}

/// A finger of a ghost, and where it was of late.
#[derive(Clone, Debug, PartialEq)]
pub struct Trail {
    /// The finger now.
    pub now: FingerRecord,
    /// Where it was within the last second, mm, oldest first; ends where it is.
    pub places_mm: Vec<Vec3>,
}

/// What the recorder does.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecorderStatus {
    /// The file being written.
    pub recording: Option<PathBuf>,
    /// Time recorded, s.
    pub time_s: f64,
    /// Bytes written.
    pub bytes: u64,
    /// Ticks that were lost to it.
    pub lost: u64,
    /// Why the last recording broke off.
    pub failed: Option<String>,
    /// Whether recordings are compressed when they are finished.
    pub compresses: bool,
    /// Pseudonym that new recordings are given.
    pub participant: String,
    /// Memory it holds while it records, bytes.
    pub held_bytes: usize,
    /// Counts recordings that were finished or came otherwise into the folder.
    pub finished: u64,
    /// Finished recordings, newest first.
    pub recent: Vec<RecentFile>,
    /// Where new recordings go.
    pub folder: PathBuf,
}

/// A recording in the user's folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecentFile {
    /// The file.
    pub path: PathBuf,
    /// Its size.
    pub bytes: u64,
}

/// How long frames of the main window take.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameTiming {
    /// Work of the last frame on the processor, ms.
    pub last_ms: f64,
    /// Longest in the last second, ms.
    pub longest_ms: f64,
    /// Frames drawn in the last second.
    pub frames_per_s: f64,
}
