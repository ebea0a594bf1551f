//! Many sessions at once: how fast they are analysed and handed on, and whether memory grows with their number.

mod compared;
mod made;

use super::{Choice, Experiment, LabError, Report, Setup, Stopwatch, Table, Value, Verdict, Watch};
use crate::study::export::{self, Format, Settings};
use crate::study::{METRICS, Options, StudyError, cohort};
use compared::Compared;
use made::made;
use std::path::{Path, PathBuf};

/// Synthetic sessions: analysed, their groups compared, handed on.
pub struct SessionCohort;

/// Sessions of the small and the large cohort.
const SIZES: [usize; 2] = [200, 1000];
/// At a look.
const QUICK: [usize; 2] = [20, 40];
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
        "Synthetic sessions of two fingers analysed, compared and handed on: time, sessions a second, peak memory at two sizes"
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
            peaks[i] = done.steps.iter().map(|s| s.peak_bytes).max().flatten();
            done.tell(n, &mut table);
            let what = format!("{n} sessions, every one handed on");
            let whole = (done.sessions, done.rows) == (n, n * rows_of_a_session());
            let measured = format!("{} with {} rows", done.sessions, done.rows);
            let goal = format!("{n} with {} rows", n * rows_of_a_session());
            report
                .verdicts
                .push(Verdict::must(what, measured, goal, whole));
            if n == large {
                done.compared.tell(n, &mut report);
            }
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
            "Peak memory is the largest resident set of the process during the work, which Linux counts; elsewhere it is empty. \
             Compared means: analysed, and set beside the first session by time and by warping. Fingers of participants with an \
             even number press a third deeper: the group \"deep\".",
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

/// One kind of work on a cohort.
struct Step {
    work: &'static str,
    seconds: f64,
    peak_bytes: Option<u64>,
    written_bytes: Option<u64>,
}

/// What became of a cohort.
struct Done {
    analysed: usize,
    finite: bool,
    compared: Compared,
    sessions: usize,
    rows: usize,
    steps: Vec<Step>,
}

/// Does some work; what it took and the most memory meanwhile.
fn step<T>(
    work: &'static str,
    clock: &Stopwatch,
    steps: &mut Vec<Step>,
    mut each: impl FnMut() -> Result<T, LabError>,
) -> Result<T, LabError> {
    let watched = forget_peak();
    let (result, took_us) = clock.time(&mut each);
    steps.push(Step {
        work,
        seconds: took_us / 1e6,
        peak_bytes: peak_bytes().filter(|_| watched),
        written_bytes: None,
    });
    result
}

impl Done {
    fn of(
        files: &[PathBuf],
        jobs: usize,
        folder: &Path,
        watch: &mut Watch<'_>,
    ) -> Result<Self, LabError> {
        let clock = Stopwatch::new();
        let mut steps = Vec::new();
        let (analysed, finite) = step("analysed", &clock, &mut steps, || {
            analyse_all(files, jobs, &mut watch.part(0.0, 0.25))
        })?;
        let compared = step("compared", &clock, &mut steps, || {
            Compared::of(files, jobs, &mut watch.part(0.25, 0.6))
        })?;
        let out = folder.join(format!("parquet-{}", files.len()));
        let (sessions, rows, bytes) = step("handed on as Parquet", &clock, &mut steps, || {
            hand_on(files, jobs, &out, &mut watch.part(0.6, 1.0))
        })?;
        if let Some(last) = steps.last_mut() {
            last.written_bytes = Some(bytes);
        }
        Ok(Self {
            analysed,
            finite,
            compared,
            sessions,
            rows,
            steps,
        })
    }

    fn tell(&self, n: usize, table: &mut Table) {
        let in_megabytes = |bytes: Option<u64>| bytes.map_or(Value::Empty, |b| megabytes(b).into());
        for step in &self.steps {
            table.push([
                step.work.into(),
                n.into(),
                step.seconds.into(),
                (n as f64 / step.seconds.max(1e-9)).into(),
                in_megabytes(step.peak_bytes),
                in_megabytes(step.written_bytes),
            ]);
        }
    }
}

/// How many could be analysed, and whether all of their measures are finite.
fn analyse_all(
    files: &[PathBuf],
    jobs: usize,
    watch: &mut Watch<'_>,
) -> Result<(usize, bool), LabError> {
    let (mut analysed, mut finite) = (0, true);
    let n = files.len() as f64;
    // Words come with results, not with time: whoever watches hears the same each time.
    let mut heard = Ok(());
    let stop = std::cell::Cell::new(false);
    let ended = cohort::run(
        files,
        jobs,
        &Options::default(),
        &mut |_| !stop.get(),
        &mut |i, result| {
            if let Ok(analysis) = result {
                analysed += 1;
                let mut values = METRICS.iter().filter_map(|m| (m.get)(&analysis.whole));
                finite &= values.all(f64::is_finite);
            }
            heard = watch.at("analysing sessions", i as f64 / n);
            stop.set(heard.is_err());
        },
    );
    heard?;
    ended.map_err(told)?;
    Ok((analysed, finite))
}

/// Sessions, rows and bytes written.
fn hand_on(
    files: &[PathBuf],
    jobs: usize,
    out: &Path,
    watch: &mut Watch<'_>,
) -> Result<(usize, usize, u64), LabError> {
    let settings = Settings {
        format: Format::Parquet,
        folder: out.to_owned(),
        force: false,
        options: Options::default(),
    };
    let (mut sessions, mut rows, mut bytes) = (0, 0, 0);
    let n = files.len() as f64;
    let mut heard = Ok(());
    let stop = std::cell::Cell::new(false);
    let ended = export::cohort(
        files,
        jobs,
        &settings,
        &mut |_| !stop.get(),
        &mut |i, result| {
            if let Ok(exported) = result {
                sessions += 1;
                rows += exported.rows as usize;
                bytes += exported.bytes;
            }
            heard = watch.at("handing sessions on", i as f64 / n);
            stop.set(heard.is_err());
        },
    );
    heard?;
    ended
        .and_then(|()| export::finish(&settings))
        .map_err(told)?;
    Ok((sessions, rows, bytes))
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
