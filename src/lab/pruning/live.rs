//! Needs that change while a finger is felt: does the servo keep time, allocate nothing, and can it all be repeated?

use super::scenes::{EDITED, OTHER};
use super::slider::Slider;
use super::{Case, Finger, Of, Uncounted, count};
use crate::deform::models::fsmd::Fsmd;
use crate::deform::{Displacement, Model as _};
use crate::device::Device;
use crate::geom::Vec2;
use crate::lab::{Choice, Experiment, LabError, Report, Setup, Table, Value, Verdict, Watch};
use crate::maps::Stroke;
use crate::scenario::{self, Scenario, Scene, Use, edit};
use crate::servo::{
    self, Command, Limits, MAX_FINGERS, Retired, Rig, Servo, ServoConfig, Snapshot, TimingStats,
};
use crate::session::recorder::{RecorderHandle, RecorderThread};
use crate::session::{
    self, DeviceInfo, Edit, Header, MeshSource, Session, Strictness, check_edited,
};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Panels, strokes, recordings and scenes come and go under a running servo.
pub struct Live;

/// A window looks at the servo this often.
const FRAME: Duration = Duration::from_millis(16);
/// How long things are left as they are between two changes.
const SETTLED: Duration = Duration::from_millis(60);
/// How long the servo may take to go over to an edit.
const PATIENCE: Duration = Duration::from_secs(20);
/// Triangles of the two backs.
const TRIANGLES: [usize; 2] = [20_389, 2_962];

/// What changes, again and again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Change {
    /// A Back view opens: bones, ellipses and the deformation are built.
    OpenSkin,
    /// It closes, and they go.
    CloseSkin,
    /// A hard spot is painted.
    HardSpot,
    /// The map is made softer, key by key.
    SoftKeys,
    /// All spots are taken away.
    NoSpots,
    /// A recording begins.
    Record,
    /// It ends.
    StopRecording,
    /// Another scene is built and felt.
    OtherScene,
}

const CYCLE: [Change; 12] = [
    Change::OpenSkin,
    Change::HardSpot,
    Change::Record,
    Change::HardSpot,
    Change::CloseSkin,
    Change::SoftKeys,
    Change::OpenSkin,
    Change::NoSpots,
    Change::StopRecording,
    Change::HardSpot,
    Change::CloseSkin,
    Change::OtherScene,
];

impl Experiment for Live {
    fn name(&self) -> &'static str {
        "pruning-live"
    }

    fn about(&self) -> &'static str {
        "Whether the servo keeps time while panels open and close, spots are painted, recordings begin and scenes change"
    }

    fn takes(&self) -> &'static [Choice] {
        &[Choice::Triangles]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let cycles = if setup.quick { 1 } else { 24 };
        let mut triangles = TRIANGLES;
        for (own, asked) in triangles.iter_mut().zip(&setup.triangles) {
            *own = *asked;
        }
        let folder = tempfile::tempdir().map_err(fault)?;
        let mut report = Report::default();
        report.set(
            "backs",
            format!("{} and {} triangles", triangles[0], triangles[1]),
        );
        report.set("finger", "5 mm deep, sliding 120 mm up and down, 1 kHz");
        report.set("changes", cycles * CYCLE.len());
        let mut table = Table::new(
            "servo",
            "The servo while needs change, and before and after that while nothing does",
            &[
                "while",
                "ticks",
                "changes",
                "late ticks",
                "longest tick (µs)",
                "99 % of ticks within (µs)",
                "mean tick (µs)",
                "longest between ticks (ms)",
                "records lost",
            ],
        );
        let texts = [EDITED.on_back(triangles[0]), OTHER.on_back(triangles[1])];
        let mut bench = Bench::start(texts, folder.path())?;
        watch.at("nothing changes", 0.0)?;
        let n = cycles * CYCLE.len();
        let quiet_for = SETTLED * n as u32;
        let first = bench.watched("nothing changes", |b| {
            b.stay(quiet_for, &mut watch.part(0.0, 0.1))
        })?;
        let changing = bench.watched("needs change", |b| {
            for (i, change) in (0..cycles).flat_map(|_| CYCLE).enumerate() {
                watch.at("needs change", 0.1 + 0.6 * i as f64 / n as f64)?;
                b.change(change)?;
                b.pump_for(SETTLED);
            }
            Ok(())
        })?;
        let last = bench.watched("nothing changes any more", |b| {
            b.stay(quiet_for, &mut watch.part(0.7, 0.8))
        })?;
        for run in [&first, &changing, &last] {
            run.row(&mut table);
        }
        report.tables.push(table);
        let ended = bench.end();
        let repeated = repeat(&ended.recordings, &mut watch.part(0.8, 0.95))?;
        watch.at("counting in a process of its own", 0.95)?;
        let counted = quiet_heap(&mut || watch.at("counting", 0.95).is_ok())?;
        conclude(
            &mut report,
            [&first, &changing, &last],
            &ended,
            &repeated,
            &counted,
        );
        Ok(report)
    }
}

fn fault(e: impl std::fmt::Display) -> LabError {
    LabError::Input(e.to_string())
}

/// One stretch of time.
struct Stretch {
    what: &'static str,
    changes: usize,
    timing: TimingStats,
}

impl Stretch {
    fn row(&self, table: &mut Table) {
        let t = &self.timing;
        table.push([
            self.what.into(),
            (t.ticks as usize).into(),
            self.changes.into(),
            (t.late_ticks as usize).into(),
            t.longest_tick_us.into(),
            t.duration_quantile_us(0.99).into(),
            t.mean_tick_us().into(),
            Value::from(t.longest_period_us / 1e3),
            (t.lost_records as usize).into(),
        ]);
    }
}

/// What the workbench does around a servo, without its window.
struct Bench<'a> {
    servo: Servo,
    newest: triple_buffer::Output<Snapshot>,
    retired: rtrb::Consumer<Retired>,
    commands: rtrb::Producer<Command>,
    recorder: RecorderHandle,
    folder: &'a Path,
    texts: [String; 2],
    on: usize,
    scene: Arc<Scene>,
    /// The drawn skin, while there is one.
    skin: Option<(Fsmd, Displacement)>,
    drawn: bool,
    /// Number of the newest edit, and scenes handed to the servo and come back from it.
    edit: u32,
    handed: u64,
    back: u64,
    scenes: u64,
    spots: u32,
    changes: usize,
    recording: Option<PathBuf>,
    recordings: Vec<PathBuf>,
}

/// What was left when all was over.
struct Ended {
    handed: u64,
    back: u64,
    edits: u32,
    recordings: Vec<PathBuf>,
}

impl<'a> Bench<'a> {
    fn start(texts: [String; 2], folder: &'a Path) -> Result<Self, LabError> {
        let scene = built(&texts[0])?;
        let rig = Rig::new(
            Box::new(scene.touch.clone()),
            [Limits::default(); MAX_FINGERS],
        );
        let device: Box<dyn Device> = Box::new(Slider::over(&scene));
        let (servo, lines) =
            servo::start(ServoConfig::default(), rig, vec![device]).map_err(fault)?;
        let recorder = RecorderThread::spawn(lines.records, None).map_err(fault)?;
        Ok(Self {
            servo,
            newest: lines.snapshot,
            retired: lines.retired,
            commands: lines.commands,
            recorder,
            folder,
            texts,
            on: 0,
            scene: Arc::new(scene),
            skin: None,
            drawn: false,
            edit: 0,
            handed: 0,
            back: 0,
            scenes: 0,
            spots: 0,
            changes: 0,
            recording: None,
            recordings: Vec::new(),
        })
    }

    fn purpose(&self) -> Use {
        Use {
            fingers: 1,
            live: true,
            drawn: self.drawn,
            deformed: self.drawn,
            recorded: self.recording.is_some(),
            ..Use::default()
        }
    }

    /// Times the servo over `work`.
    fn watched(
        &mut self,
        what: &'static str,
        work: impl FnOnce(&mut Self) -> Result<(), LabError>,
    ) -> Result<Stretch, LabError> {
        self.send(Command::ResetTiming)?;
        self.pump_for(SETTLED);
        let changes = self.changes;
        work(self)?;
        self.pump();
        Ok(Stretch {
            what,
            changes: self.changes - changes,
            timing: self.newest.read().timing,
        })
    }

    fn stay(&mut self, time: Duration, watch: &mut Watch<'_>) -> Result<(), LabError> {
        let parts = 8;
        for i in 0..parts {
            watch.at("nothing changes", f64::from(i) / f64::from(parts))?;
            self.pump_for(time / parts);
        }
        Ok(())
    }

    /// What a window does at every frame: frees what came back, and draws the skin where it is open.
    fn pump(&mut self) -> Snapshot {
        while self.retired.pop().is_ok() {
            self.back += 1;
        }
        let snapshot = *self.newest.read();
        if let Some((model, skin)) = &mut self.skin {
            let press = self.scene.press(&snapshot.record.fingers[0].contact);
            model.update(&self.scene.surface, press.as_slice(), skin);
        }
        snapshot
    }

    fn pump_for(&mut self, time: Duration) {
        let until = Instant::now() + time;
        while Instant::now() < until {
            self.pump();
            std::thread::sleep(FRAME);
        }
    }

    fn pump_until(&mut self, what: &str, done: impl Fn(&Snapshot) -> bool) -> Result<(), LabError> {
        let until = Instant::now() + PATIENCE;
        loop {
            let snapshot = self.pump();
            if done(&snapshot) {
                return Ok(());
            }
            if Instant::now() > until {
                return Err(fault(format_args!("{what} did not come in {PATIENCE:?}")));
            }
            std::thread::sleep(FRAME);
        }
    }

    /// Builds on a thread of its own, as the workbench does, while frames go on.
    fn beside<T: Send>(&mut self, work: impl FnOnce() -> T + Send) -> Result<T, LabError> {
        std::thread::scope(|scope| {
            let builder = std::thread::Builder::new().name("builder".into());
            let job = builder.spawn_scoped(scope, work).map_err(fault)?;
            while !job.is_finished() {
                self.pump();
                std::thread::sleep(FRAME);
            }
            job.join().map_err(|_| fault("the builder broke off"))
        })
    }

    fn send(&mut self, command: Command) -> Result<(), LabError> {
        self.handed += u64::from(matches!(
            command,
            Command::SetScene(_) | Command::EditScene { .. }
        ));
        let mut waiting = Some(command);
        let until = Instant::now() + PATIENCE;
        while let Some(command) = waiting.take() {
            if let Err(rtrb::PushError::Full(command)) = self.commands.push(command) {
                if Instant::now() > until {
                    return Err(fault("the servo takes no commands"));
                }
                waiting = Some(command);
                self.pump();
                std::thread::sleep(FRAME);
            }
        }
        Ok(())
    }

    fn change(&mut self, change: Change) -> Result<(), LabError> {
        self.changes += 1;
        match change {
            Change::OpenSkin => self.show(true),
            Change::CloseSkin => self.show(false),
            Change::HardSpot => {
                self.spots += 1;
                // Now under the finger, now beside it.
                let (x, y) = self.scene.default_place_mm();
                let along = 25.0 * f64::from(self.spots % 5) - 50.0;
                let spot = Stroke {
                    path: vec![Vec2::new(x, y + along)],
                    radius_mm: 18.0,
                    change: 0.4,
                    falloff: "gaussian".into(),
                };
                let mut spots = self.scene.scenario.strokes.clone();
                spots.push(spot);
                self.edit_map(1.0, spots)
            }
            Change::SoftKeys => self.edit_map(0.9, self.scene.scenario.strokes.clone()),
            Change::NoSpots => self.edit_map(1.0, Vec::new()),
            Change::Record => {
                let name = format!("{}.mcap", self.recordings.len());
                let path = self.folder.join(name);
                self.recorder.start(&path, self.header()).map_err(fault)?;
                self.recording = Some(path);
                Ok(())
            }
            Change::StopRecording => {
                self.recorder.stop().map_err(fault)?;
                self.recordings.extend(self.recording.take());
                Ok(())
            }
            Change::OtherScene => {
                self.on = 1 - self.on;
                let text = self.texts[self.on].clone();
                let scene = self.beside(move || built(&text))??;
                (self.drawn, self.skin) = (false, None);
                self.send(Command::SetScene(Box::new(scene.touch.clone())))?;
                self.scene = Arc::new(scene);
                self.scenes += 1;
                let scenes = self.scenes;
                self.pump_until("the scene", move |s| s.scene_generation == scenes)
            }
        }
    }

    /// Builds or drops what only the drawn skin needs; what is felt stays as it is.
    fn show(&mut self, drawn: bool) -> Result<(), LabError> {
        self.drawn = drawn;
        let (old, purpose) = (Arc::clone(&self.scene), self.purpose());
        let (scene, skin) = self.beside(move || {
            let scene = scenario::rebuild(&old, old.scenario.clone(), purpose).map_err(fault)?;
            let skin = drawn.then(|| {
                let mut model = Fsmd::new(scene.deform.clone());
                model.prepare(&scene.surface);
                (model, Displacement::at_rest(&scene.surface))
            });
            Ok::<_, LabError>((scene, skin))
        })??;
        (self.scene, self.skin) = (Arc::new(scene), skin);
        Ok(())
    }

    /// As an editor does: the text with its new map, the scene rebuilt from it, told to the recorder, handed to the servo.
    fn edit_map(&mut self, stiffer: f64, spots: Vec<Stroke>) -> Result<(), LabError> {
        let (old, purpose) = (Arc::clone(&self.scene), self.purpose());
        let scene = self.beside(move || {
            let was = &old.scenario;
            let mut keys = was.stiffness_keys.clone();
            for key in &mut keys {
                key.stiffness_n_per_mm *= stiffer;
            }
            let text = edit::with_stiffness(&was.source, &keys, was.stiffness_fit, &spots)
                .map_err(fault)?;
            let scenario = Scenario::parse(&text, "edited", None).map_err(fault)?;
            scenario::rebuild(&old, Arc::new(scenario), purpose).map_err(fault)
        })??;
        let number = self.edit + 1;
        let text: Arc<str> = scene.scenario.source.as_str().into();
        let until = Instant::now() + PATIENCE;
        while !self.recorder.edit(number, Arc::clone(&text)) {
            if Instant::now() > until {
                return Err(fault("the recorder takes no edits"));
            }
            self.pump();
            std::thread::sleep(FRAME);
        }
        let touch = Box::new(scene.touch.clone());
        self.scene = Arc::new(scene);
        self.send(Command::EditScene {
            number,
            scene: touch,
        })?;
        self.edit = number;
        self.pump_until("the edit", move |s| s.edit == number && s.fade >= 1.0)
    }

    fn header(&self) -> Header {
        Header {
            scenario_toml: self.scene.scenario.source.clone(),
            scenario_name: self.scene.scenario.name.clone(),
            mesh: MeshSource::new(&self.scene.surface, &self.scene.mesh_origin),
            devices: vec![DeviceInfo::new("Scripted", &Limits::default())],
            rate_hz: 1.0 / ServoConfig::default().dt_s(),
            build: session::build_id(),
            started_utc: session::utc_now(),
            participant: None,
            edit: self.edit,
            sealed: false,
        }
    }

    /// Stops the servo and takes what it gave back.
    fn end(mut self) -> Ended {
        self.pump_for(2 * SETTLED);
        drop(self.servo);
        while self.retired.pop().is_ok() {
            self.back += 1;
        }
        Ended {
            handed: self.handed,
            back: self.back,
            edits: self.edit,
            recordings: self.recordings,
        }
    }
}

fn built(text: &str) -> Result<Scene, LabError> {
    let scenario = Scenario::parse(text, "lab", None).map_err(fault)?;
    scenario::build(Arc::new(scenario), Use::default(), &mut |_, _| true).map_err(fault)
}

/// Recordings repeated.
#[derive(Default)]
struct Repeated {
    recordings: usize,
    exact: usize,
    ticks: u64,
    edits: u64,
    first: Option<String>,
}

fn repeat(paths: &[PathBuf], watch: &mut Watch<'_>) -> Result<Repeated, LabError> {
    let mut all = Repeated::default();
    for (i, path) in paths.iter().enumerate() {
        watch.at("repeating the recordings", i as f64 / paths.len() as f64)?;
        let session = Session::open(path).map_err(fault)?;
        let header = session.header();
        let first = built(&header.scenario_toml)?;
        let rig = Rig::new(Box::new(first.touch.clone()), header.limits());
        let rebuild = |e: &Edit| -> Result<_, String> {
            built(&e.scenario_toml)
                .map(|s| s.touch)
                .map_err(|e| e.to_string())
        };
        let rebuild = Box::new(rebuild);
        let report = check_edited(&session, rig, rebuild, Strictness::Strict, |_, _| ());
        let report = report.map_err(fault)?;
        all.recordings += 1;
        all.exact += usize::from(report.is_bit_exact());
        all.ticks += report.compared;
        all.edits += report.passed.edits;
        if all.first.is_none() && !report.is_bit_exact() {
            all.first = Some(format!("{:?}", report.first_difference));
        }
    }
    Ok(all)
}

/// Calls to the heap while a servo ticks and takes edits, and bytes left when it has gone; why not, where nothing counts.
fn quiet_heap(go_on: &mut dyn FnMut() -> bool) -> Result<Result<(u64, i64), String>, LabError> {
    let case = Case {
        scenario: EDITED.on_back(TRIANGLES[1]),
        deformed: false,
        of: Of::Servo,
        finger: Finger::Slides,
        windows: 0,
        per_window: 0,
        most_steps: 0,
    };
    match count(&case, go_on) {
        Ok(counted) => {
            let counts = counted.counts;
            let both = counts.use_calls.zip(counts.used);
            Ok(both.ok_or_else(|| "the allocator does not count".into()))
        }
        Err(Uncounted::Here(why)) => Ok(Err(why)),
        Err(Uncounted::Stopped) => Err(LabError::Stopped),
    }
}

fn conclude(
    report: &mut Report,
    [first, changing, last]: [&Stretch; 3],
    ended: &Ended,
    repeated: &Repeated,
    counted: &Result<(u64, i64), String>,
) {
    let verdicts = &mut report.verdicts;
    verdicts.push(Verdict::told(
        format!("no tick is late over {} changes", changing.changes),
        format!(
            "{} of {} ticks late; with nothing changing {} and {}",
            changing.timing.late_ticks,
            changing.timing.ticks,
            first.timing.late_ticks,
            last.timing.late_ticks
        ),
        "0",
        changing.timing.late_ticks == 0,
    ));
    let share = |s: &Stretch| 1e4 * s.timing.late_ticks as f64 / s.timing.ticks.max(1) as f64;
    let quiet = f64::max(share(first), share(last));
    verdicts.push(Verdict::told(
        "changes make no more ticks late than are late without them",
        format!("{:.0} of 10,000; without {quiet:.0}", share(changing)),
        "as many",
        share(changing) <= quiet,
    ));
    let quiet_us = f64::max(first.timing.longest_tick_us, last.timing.longest_tick_us);
    verdicts.push(Verdict::told(
        "the longest tick is within one period",
        format!(
            "{:.0} µs; with nothing changing {quiet_us:.0} µs",
            changing.timing.longest_tick_us
        ),
        "1000 µs",
        changing.timing.longest_tick_us <= 1000.0,
    ));
    verdicts.push(Verdict::told(
        "no record is lost",
        format!("{} lost", changing.timing.lost_records),
        "0",
        changing.timing.lost_records == 0,
    ));
    verdicts.push(Verdict::must(
        "every scene handed to the servo comes back to be freed",
        format!("{} of {}", ended.back, ended.handed),
        "all",
        ended.back == ended.handed && ended.handed >= u64::from(ended.edits),
    ));
    let exact = format!(
        "{} of {} recordings, {} ticks, {} edits{}",
        repeated.exact,
        repeated.recordings,
        repeated.ticks,
        repeated.edits,
        repeated
            .first
            .as_deref()
            .map_or(String::new(), |d| format!("; {d}"))
    );
    verdicts.push(Verdict::must(
        "what was recorded meanwhile is repeated bit for bit",
        exact,
        "all",
        repeated.exact == repeated.recordings && repeated.ticks > 0 && repeated.edits > 0,
    ));
    let (calls, left) = match counted {
        Ok((calls, left)) => (Some(*calls), Some(*left)),
        Err(why) => {
            report.note(format!("The servo's heap is not counted here: {why}."));
            (None, None)
        }
    };
    const NOT: &str = "not counted here";
    report.verdicts.push(Verdict::must(
        "the servo thread asks nothing of the heap, edits and scenes coming in",
        calls.map_or(NOT.into(), |n| format!("{n} calls in half a second")),
        "0 calls",
        calls.is_none_or(|n| n == 0),
    ));
    report.verdicts.push(Verdict::must(
        "when it has gone nothing of it is left",
        left.map_or(NOT.into(), |n| format!("{n} bytes")),
        "0 bytes",
        left.is_none_or(|n| n <= 0),
    ));
    report.note(
        "A servo thread at 1 kHz with a scripted finger in touch; panels, editor, recorder and builder do what the workbench's \
         do, without its window. Late is later than 5 ms: force is then zero. Times are the machine's: other work on it shows.",
    );
}
