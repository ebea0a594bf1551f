//! Many sessions at once: how fast they are analysed and handed on, and whether memory grows with their number.

use super::{Choice, Experiment, LabError, Report, Setup, Stopwatch, Table, Value, Verdict, Watch};
use crate::device::Device;
use crate::device::scripted::{Scripted, Trajectory, TrajectoryError, Waypoint};
use crate::geom::Vec3;
use crate::scenario::{self, Scenario, Scene, Use, default_example};
use crate::servo::{Limits, MAX_FINGERS, Rig, run_offline};
use crate::session::{DeviceInfo, Header, IfExists, MeshSource, SessionWriter, build_id};
use crate::study::export::{self, Format, Settings};
use crate::study::{Options, StudyError, cohort};
use crate::training::random::Random;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Synthetic sessions: analysed, their groups compared, handed on.
pub struct SessionCohort;

/// Sessions of the small and the large cohort.
const SIZES: [usize; 2] = [200, 1000];
/// At a look.
const QUICK: [usize; 2] = [4, 12];
/// Fingers of each.
const FINGERS: usize = 2;
/// Ticks per second.
const RATE_HZ: f64 = 1000.0;
/// Time of a session, s.
const SECONDS: f64 = 2.0;
/// Sessions of a participant.
const EACH: usize = 5;
/// Peak memory of the large cohort over that of the small one that counts as not growing.
const GROWTH: f64 = 1.25;

impl Experiment for SessionCohort {
    fn name(&self) -> &'static str {
        "session-cohort"
    }

    fn about(&self) -> &'static str {
        "Synthetic sessions of two fingers analysed and handed on: time, sessions a second, peak memory at two sizes"
    }

    fn takes(&self) -> &'static [Choice] {
        &[Choice::Seed]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let [small, large] = if setup.quick { QUICK } else { SIZES };
        let jobs = cohort::default_jobs();
        let mut report = Report::default();
        report.set("fingers of a session", FINGERS);
        report.set("time of a session", format!("{SECONDS} s at {RATE_HZ} Hz"));
        report.set("sessions of a participant", EACH);
        report.set("threads", jobs);
        let folder = tempfile::tempdir().map_err(|e| failed(Path::new("temporary folder"), &e))?;
        let files = made(folder.path(), large, setup, &mut watch.part(0.0, 0.3))?;
        let mut table = Table::new(
            "cohort",
            "What is done with the sessions",
            &[
                "work",
                "sessions",
                "time (s)",
                "rate (1/s)",
                "peak memory (MB)",
                "written (MB)",
            ],
        );
        let mut peaks = [None; 2];
        for (i, n) in [small, large].into_iter().enumerate() {
            let (from, to) = [(0.3, 0.45), (0.45, 1.0)][i];
            let done = Done::of(&files[..n], jobs, folder.path(), &mut watch.part(from, to))?;
            peaks[i] = done.peak_bytes;
            done.tell(&mut table);
            let what = format!("{n} sessions, every one handed on");
            let whole = (done.sessions, done.rows) == (n, n * rows_of_a_session());
            let measured = format!("{} with {} rows", done.sessions, done.rows);
            let goal = format!("{n} with {} rows", n * rows_of_a_session());
            report
                .verdicts
                .push(Verdict::must(what, measured, goal, whole));
            let found = done.analysed == n && done.finite;
            let measured = format!("{} analysed", done.analysed);
            let what = format!("{n} sessions, every one analysed, no measure that is not finite");
            report
                .verdicts
                .push(Verdict::must(what, measured, n, found));
        }
        report.tables.push(table);
        if let [Some(few), Some(many)] = peaks {
            let ratio = many as f64 / few as f64;
            report.verdicts.push(Verdict::told(
                format!("peak memory of {large} sessions over that of {small}"),
                format!("{ratio:.2}"),
                format!("at most {GROWTH}"),
                ratio <= GROWTH,
            ));
        }
        report.note(
            "Peak memory is the largest resident set of the process while the sessions were analysed and handed on, which Linux \
             counts; elsewhere it is empty. Fingers of participants with an even number press a third deeper.",
        );
        Ok(report)
    }
}

fn failed(path: &Path, error: &dyn std::fmt::Display) -> LabError {
    LabError::Input(format!("{}: {error}", path.display()))
}

fn ticks() -> u64 {
    (SECONDS * RATE_HZ) as u64
}

fn rows_of_a_session() -> usize {
    ticks() as usize * FINGERS
}

/// Records `n` sessions; each has its own seed.
fn made(
    folder: &Path,
    n: usize,
    setup: &Setup,
    watch: &mut Watch<'_>,
) -> Result<Vec<PathBuf>, LabError> {
    let example = default_example();
    let input = |e: &dyn std::fmt::Display| LabError::Input(e.to_string());
    let parsed = Scenario::parse(example.text, example.file, None).map_err(|e| input(&e))?;
    let purpose = Use {
        fingers: FINGERS,
        ..Use::default()
    };
    let built = scenario::build(Arc::new(parsed), purpose, &mut |_, _| true);
    let scene = built.map_err(|e| input(&e))?;
    let mut files = Vec::with_capacity(n);
    for i in 0..n {
        watch.at("recording sessions", i as f64 / n as f64)?;
        let path = folder.join(format!("{i:05}.mcap"));
        record(&path, &scene, i, setup.seed).map_err(|e| failed(&path, &e))?;
        files.push(path);
    }
    Ok(files)
}

fn record(
    path: &Path,
    scene: &Scene,
    i: usize,
    seed: u64,
) -> Result<(), Box<dyn std::error::Error>> {
    let limits = [Limits::default(); MAX_FINGERS];
    let person = i / EACH;
    let header = Header {
        scenario_toml: scene.scenario.source.clone(),
        scenario_name: scene.scenario.name.clone(),
        mesh: MeshSource::new(&scene.surface, &scene.mesh_origin),
        devices: vec![DeviceInfo::new("Scripted", &limits[0]); FINGERS],
        rate_hz: RATE_HZ,
        build: build_id(),
        started_utc: format!("2031-05-{:02}T09:{:02}:00.000Z", 1 + i % EACH, person % 60),
        participant: Some(format!("P{person:04}")),
        edit: 0,
        sealed: false,
    };
    let mut random = Random::new(seed ^ ((i as u64) << 20));
    let deep = if person.is_multiple_of(2) { 8.0 } else { 6.0 };
    let devices = (0..FINGERS).map(|finger| {
        let path = trajectory(scene, finger, deep, &mut random);
        path.map(|path| Box::new(Scripted::new(path)) as Box<dyn Device>)
    });
    let devices = devices.collect::<Result<_, _>>()?;
    let mut writer = SessionWriter::create(path, &header, IfExists::Refuse)?;
    let mut rig = Rig::new(Box::new(scene.touch.clone()), limits);
    let (mut n, mut wrong) = (0, None);
    run_offline(&mut rig, devices, 1.0 / RATE_HZ, |out| {
        wrong = out.fingers().iter().find_map(|r| writer.write(r).err());
        n += 1;
        wrong.is_none() && n < ticks()
    });
    match wrong {
        Some(error) => Err(error.into()),
        None => Ok(writer.finish().map(drop)?),
    }
}

/// Presses at places of chance, one after the other.
fn trajectory(
    scene: &Scene,
    finger: usize,
    deep_mm: f64,
    random: &mut Random,
) -> Result<Trajectory, TrajectoryError> {
    let (x, y) = scene.default_place_mm();
    let side = if finger == 0 { 1.0 } else { -1.0 };
    let mut waypoints = Vec::new();
    let mut time_s = 0.0;
    while time_s < SECONDS {
        let at = (
            side * x.abs().max(10.0) + 30.0 * random.unit(),
            y - 80.0 * random.unit(),
        );
        let skin_mm = scene.height_mm(at.0, at.1).unwrap_or_default();
        let depth_mm = deep_mm * (0.7 + 0.3 * random.unit());
        for (after_s, height_mm) in [(0.0, 5.0), (0.25, -depth_mm), (0.4, -depth_mm), (0.6, 5.0)] {
            waypoints.push(Waypoint {
                time_s: time_s + after_s,
                position_mm: Vec3::new(at.0, at.1, skin_mm + height_mm),
            });
        }
        time_s += 0.7;
    }
    Trajectory::new(waypoints)
}

/// What became of a cohort.
struct Done {
    analysed: usize,
    finite: bool,
    analysing_s: f64,
    sessions: usize,
    rows: usize,
    bytes: u64,
    writing_s: f64,
    peak_bytes: Option<u64>,
}

impl Done {
    fn of(
        files: &[PathBuf],
        jobs: usize,
        folder: &Path,
        watch: &mut Watch<'_>,
    ) -> Result<Self, LabError> {
        let mut done = Self {
            analysed: 0,
            finite: true,
            analysing_s: 0.0,
            sessions: 0,
            rows: 0,
            bytes: 0,
            writing_s: 0.0,
            peak_bytes: None,
        };
        let n = files.len() as f64;
        let watched = forget_peak();
        let clock = Stopwatch::new();
        let options = Options::default();
        // Words come with results, not with time: whoever watches hears the same each time.
        let mut heard = Ok(());
        let (ended, took_us) = clock.time(|| {
            let stop = std::cell::Cell::new(false);
            cohort::run(
                files,
                jobs,
                &options,
                &mut |_| !stop.get(),
                &mut |i, result| {
                    if let Ok(analysis) = result {
                        done.analysed += 1;
                        let values = crate::study::METRICS
                            .iter()
                            .filter_map(|m| (m.get)(&analysis.whole));
                        done.finite &= values.into_iter().all(f64::is_finite);
                    }
                    heard = watch.at("analysing sessions", 0.4 * i as f64 / n);
                    stop.set(heard.is_err());
                },
            )
        });
        heard?;
        ended.map_err(told)?;
        done.analysing_s = took_us / 1e6;
        let out = folder.join(format!("parquet-{}", files.len()));
        let settings = Settings {
            format: Format::Parquet,
            folder: out,
            force: false,
            options,
        };
        let (ended, took_us) = clock.time(|| {
            let stop = std::cell::Cell::new(false);
            let ended = export::cohort(
                files,
                jobs,
                &settings,
                &mut |_| !stop.get(),
                &mut |i, result| {
                    if let Ok(exported) = result {
                        done.sessions += 1;
                        done.rows += exported.rows as usize;
                        done.bytes += exported.bytes;
                    }
                    heard = watch.at("handing sessions on", 0.4 + 0.6 * i as f64 / n);
                    stop.set(heard.is_err());
                },
            );
            ended.and_then(|()| export::finish(&settings))
        });
        heard?;
        ended.map_err(told)?;
        done.writing_s = took_us / 1e6;
        done.peak_bytes = peak_bytes().filter(|_| watched);
        Ok(done)
    }

    fn tell(&self, table: &mut Table) {
        let peak = self
            .peak_bytes
            .map_or(Value::Empty, |b| megabytes(b).into());
        let rows = [
            (
                "analysed",
                self.analysed,
                self.analysing_s,
                Value::Empty,
                Value::Empty,
            ),
            (
                "handed on as Parquet",
                self.sessions,
                self.writing_s,
                peak,
                megabytes(self.bytes).into(),
            ),
        ];
        for (work, n, seconds, peak, written) in rows {
            table.push([
                work.into(),
                n.into(),
                seconds.into(),
                (n as f64 / seconds.max(1e-9)).into(),
                peak,
                written,
            ]);
        }
    }
}

fn megabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e6
}

fn told(error: StudyError) -> LabError {
    match error {
        StudyError::Stopped => LabError::Stopped,
        other => LabError::Input(other.to_string()),
    }
}

/// Has the system count the largest resident set anew; whether it does.
fn forget_peak() -> bool {
    std::fs::write("/proc/self/clear_refs", "5").is_ok()
}

/// The largest resident set since then, bytes.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024)
}
