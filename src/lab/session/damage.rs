//! Sessions killed at any instant, cut at any byte, flipped at any byte: what is saved, and whether what is not is counted.

use crate::device::Reading;
use crate::geom::Vec3;
use crate::lab::{Choice, Experiment, LabError, Report, Setup, Table, Value, Verdict, Watch};
use crate::servo::{FingerRecord, Limits};
use crate::session::{
    DeviceInfo, Extras, Header, IfExists, MeshSource, RecorderThread, RecoverOptions,
    RecoverReport, Session, SessionError, SessionWriter, Strictness, build_id, recover, utc_now,
};
use std::io::{BufRead, BufReader, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Name of the hidden subcommand that records until it is killed.
pub const SUBCOMMAND: &str = "record-until-killed";

/// Fingers, ticks of a second, ticks between two flushes of a live recorder.
const FINGERS: u8 = 2;
const RATE: u64 = 1000;
const FLUSH_TICKS: u64 = 250;
/// Longest life of a killed recorder, ticks.
const LONGEST_LIFE: u64 = 1500;

static PROGRAM: OnceLock<PathBuf> = OnceLock::new();

/// Says which program can be killed: one whose subcommand [`SUBCOMMAND`] calls [`record_until_killed`]. Without it nothing is
/// killed. Only the first call counts.
pub fn killed_in(program: PathBuf) {
    let _ = PROGRAM.set(program);
}

/// What sessions survive.
pub struct SessionDamage;

impl Experiment for SessionDamage {
    fn name(&self) -> &'static str {
        "session-damage"
    }

    fn about(&self) -> &'static str {
        "Sessions killed, cut and flipped at random: what recover saves, what is lost, and whether the loss is counted"
    }

    fn takes(&self) -> &'static [Choice] {
        &[Choice::Seed]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let (kills, cases, ticks) = if setup.quick {
            (4, 40, 1500)
        } else {
            (200, 1000, 6000)
        };
        let folder = tempfile::tempdir().map_err(input)?;
        let mut random = Random(setup.seed.wrapping_add(1));
        let mut table = Table::new(
            "damage",
            "Sessions damaged at random and saved by recover; two fingers at 1 kHz",
            &[
                "damage",
                "sessions",
                "readable",
                "held nothing yet",
                "lost (ticks)",
                "most lost (s)",
                "uncounted",
                "other than recorded",
            ],
        );
        let mut report = Report::default();
        report.set("recording", format!("{ticks} ticks of {FINGERS} fingers"));
        let whole = Whole::make(folder.path(), ticks)?;
        let mut cut = Outcome::default();
        for i in 0..cases {
            watch.at("cutting", 0.4 * f64::from(i) / f64::from(cases))?;
            cut.add(whole.cut(random.below(whole.bytes.len() as u64))?);
        }
        let mut flipped = Outcome::default();
        for i in 0..cases {
            watch.at("flipping", 0.4 + 0.3 * f64::from(i) / f64::from(cases))?;
            let at = random.below(whole.bytes.len() as u64);
            let bits = 1 << random.below(8);
            flipped.add(whole.flip(at as usize, bits)?);
        }
        let mut killed = Outcome::default();
        if let Some(program) = PROGRAM.get() {
            for i in 0..kills {
                watch.at("killing", 0.7 + 0.3 * f64::from(i) / f64::from(kills))?;
                let life = 1 + random.below(LONGEST_LIFE);
                let path = folder.path().join(format!("killed-{i}.mcap"));
                killed.add(kill(program, &path, life)?);
            }
        } else {
            watch.at("killing", 0.7)?;
            report.note("Nothing was killed: only the program itself can be.");
        }
        for (name, outcome) in [
            ("cut at a byte", &cut),
            ("a flipped bit", &flipped),
            ("kill -9", &killed),
        ] {
            if outcome.n > 0 {
                table.push(outcome.row(name));
                outcome.judge(name, &mut report);
            }
        }
        report.verdicts.push(Verdict::must(
            "a flipped bit: chunks lost",
            flipped.most_chunks,
            "at most the one that it hits",
            flipped.most_chunks <= 1,
        ));
        report.tables.push(table);
        report.note(
            "Lost are ticks that were in the file before the cut, in it before the flip, or handed to the recorder before the kill. \
             Uncounted: something is lost, and neither the report of recover nor the new session says so. Held nothing yet: cut or \
             killed before the first chunk, so that there is no session to read.",
        );
        Ok(report)
    }
}

fn input(error: impl std::fmt::Display) -> LabError {
    LabError::Input(error.to_string())
}

/// A multiplicative congruential generator (Knuth, MMIX).
struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 20) % n.max(1)
    }
}

/// What became of one session.
#[derive(Default)]
struct Fate {
    readable: bool,
    empty: bool,
    lost: u64,
    chunks: u64,
    uncounted: bool,
    other: bool,
}

/// What became of all.
#[derive(Default)]
struct Outcome {
    n: u64,
    readable: u64,
    empty: u64,
    lost: u64,
    most_lost: u64,
    most_chunks: u64,
    uncounted: u64,
    other: u64,
}

impl Outcome {
    fn add(&mut self, fate: Fate) {
        self.n += 1;
        self.readable += u64::from(fate.readable);
        self.empty += u64::from(fate.empty);
        self.lost += fate.lost;
        self.most_lost = self.most_lost.max(fate.lost);
        self.most_chunks = self.most_chunks.max(fate.chunks);
        self.uncounted += u64::from(fate.uncounted);
        self.other += u64::from(fate.other);
    }

    fn most_lost_s(&self) -> f64 {
        self.most_lost as f64 / RATE as f64
    }

    fn row(&self, name: &str) -> [Value; 8] {
        let count = |n: u64| Value::from(n as usize);
        [
            name.into(),
            count(self.n),
            count(self.readable),
            count(self.empty),
            count(self.lost),
            self.most_lost_s().into(),
            count(self.uncounted),
            count(self.other),
        ]
    }

    fn judge(&self, name: &str, report: &mut Report) {
        let with_ticks = self.n - self.empty;
        for (what, measured, goal, holds) in [
            (
                "readable after recover",
                format!("{} of {with_ticks}", self.readable),
                "all that held a tick".to_owned(),
                self.readable == with_ticks,
            ),
            (
                "most lost",
                format!("{:.3} s", self.most_lost_s()),
                "at most 1 s".to_owned(),
                self.most_lost <= RATE,
            ),
            (
                "loss not counted",
                self.uncounted.to_string(),
                "0".to_owned(),
                self.uncounted == 0,
            ),
            (
                "records other than recorded",
                self.other.to_string(),
                "0".to_owned(),
                self.other == 0,
            ),
        ] {
            let what = format!("{name}: {what}");
            report
                .verdicts
                .push(Verdict::must(what, measured, goal, holds));
        }
    }
}

/// A record whose every value follows from tick and finger.
fn record(tick: u64, finger: u8) -> FingerRecord {
    let t = tick as f64 * 1e-3 + f64::from(finger);
    FingerRecord {
        tick,
        finger,
        time_ns: tick * 1_000_000,
        reading: Reading {
            position_mm: Vec3::new(
                40.0 * libm::sin(t),
                30.0 * libm::cos(0.7 * t),
                8.0 * libm::sin(3.1 * t),
            ),
            connected: true,
            ..Reading::default()
        },
        ..FingerRecord::default()
    }
}

fn header() -> Header {
    Header {
        scenario_toml: "format = 1\nname = \"Damage\"\n".into(),
        scenario_name: "Damage".into(),
        mesh: MeshSource {
            hash: "00".repeat(32),
            origin: "builtin:back".into(),
            triangles: 2962,
        },
        devices: vec![DeviceInfo::new("Scripted", &Limits::default()); usize::from(FINGERS)],
        rate_hz: RATE as f64,
        build: build_id(),
        started_utc: utc_now(),
        participant: None,
        edit: 0,
        sealed: false,
    }
}

/// A finished session, chunked as a live recorder does, and what is where in it.
struct Whole {
    folder: PathBuf,
    header: Header,
    bytes: Vec<u8>,
    /// Bytes handed over and ticks in them, after each flush.
    flushed: Vec<(u64, u64)>,
}

impl Whole {
    fn make(folder: &Path, ticks: u64) -> Result<Self, LabError> {
        let path = folder.join("whole.mcap");
        let header = header();
        let mut writer = SessionWriter::create_with(
            &path,
            &header,
            &Extras::of_this_machine(),
            IfExists::Refuse,
        )
        .map_err(input)?;
        let mut flushed = Vec::new();
        for tick in 0..ticks {
            for finger in 0..FINGERS {
                writer.write(&record(tick, finger)).map_err(input)?;
            }
            if (tick + 1) % FLUSH_TICKS == 0 {
                writer.flush().map_err(input)?;
                flushed.push((writer.summary().bytes, tick + 1));
            }
        }
        writer.finish().map_err(input)?;
        let bytes = std::fs::read(&path).map_err(input)?;
        flushed.push((bytes.len() as u64, ticks));
        Ok(Self {
            folder: folder.to_owned(),
            header,
            bytes,
            flushed,
        })
    }

    fn cut(&self, length: u64) -> Result<Fate, LabError> {
        let (saved, empty) = self.saved(&self.bytes[..length as usize])?;
        // Ticks of the chunk that is cut count as if all of them had been there.
        let there = self.flushed.iter().find(|(bytes, _)| *bytes >= length);
        let there = there.map_or(0, |(_, ticks)| *ticks);
        Ok(self.fate(saved, empty, there))
    }

    fn flip(&self, at: usize, bits: u8) -> Result<Fate, LabError> {
        let mut bytes = self.bytes.clone();
        bytes[at] ^= bits;
        let (saved, empty) = self.saved(&bytes)?;
        let there = self.flushed.last().map_or(0, |(_, ticks)| *ticks);
        Ok(self.fate(saved, empty, there))
    }

    /// Saves a damaged session; nothing, and whether there was nothing in it, where it cannot be.
    fn saved(&self, bytes: &[u8]) -> Result<(Option<Saved>, bool), LabError> {
        let broken = self.folder.join("broken.mcap");
        std::fs::write(&broken, bytes).map_err(input)?;
        let first_flush = self.flushed.first().map_or(0, |(bytes, _)| *bytes);
        let before_all = (bytes.len() as u64) < first_flush.min(10_000);
        let saved = Saved::of(&broken, &self.folder.join("saved.mcap"))?;
        Ok(match saved {
            Some(saved) => (Some(saved), false),
            None => (None, before_all),
        })
    }

    fn fate(&self, saved: Option<Saved>, empty: bool, there: u64) -> Fate {
        let Some(saved) = saved else {
            return Fate {
                empty,
                lost: if empty { 0 } else { there },
                ..Fate::default()
            };
        };
        let least = saved.ticks.iter().map(Vec::len).min().unwrap_or(0) as u64;
        let lost = there.saturating_sub(least);
        let d = &saved.report.damage;
        let told = d.unfinished || d.chunks > 0 || d.bytes > 0 || !saved.report.is_whole();
        Fate {
            readable: true,
            empty: false,
            lost,
            chunks: d.chunks,
            uncounted: lost > 0 && !(told && saved.says_so),
            other: saved.other || saved.header != self.header,
        }
    }
}

/// A session that was saved.
struct Saved {
    report: RecoverReport,
    header: Header,
    ticks: Vec<Vec<u64>>,
    /// Something in it is not what was recorded.
    other: bool,
    /// It says in itself that something is missing.
    says_so: bool,
}

impl Saved {
    fn of(broken: &Path, out: &Path) -> Result<Option<Self>, LabError> {
        let options = RecoverOptions {
            if_exists: IfExists::Replace,
            ..RecoverOptions::default()
        };
        let report = match recover(broken, out, &options, &mut |_| true) {
            Ok(report) => report,
            Err(SessionError::Damaged { .. }) => return Ok(None),
            Err(e) => return Err(input(e)),
        };
        let session = Session::open(out).map_err(input)?;
        let read = session.load(Strictness::Strict).map_err(input)?;
        let records = read.fingers.iter().flatten();
        let other = records.clone().any(|r| *r != record(r.tick, r.finger))
            || read.fingers.iter().any(|f| !f.is_sorted_by_key(|r| r.tick));
        Ok(Some(Self {
            report,
            header: session.header().clone(),
            ticks: read
                .fingers
                .iter()
                .map(|f| f.iter().map(|r| r.tick).collect())
                .collect(),
            other,
            says_so: read.events.iter().any(|e| e.kind == "recovered"),
        }))
    }
}

/// A child that does not outlive whoever started it.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Lets a recorder live for so many ticks, kills it, and saves what it wrote.
fn kill(program: &Path, path: &Path, life: u64) -> Result<Fate, LabError> {
    let child = Command::new(program)
        .arg(SUBCOMMAND)
        .arg(path)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn();
    let mut child = Running(child.map_err(input)?);
    let mut pushed = 0;
    // Kept open until it is dead: it is to be killed, not to end.
    let mut out = child.0.stdout.take().map(BufReader::new);
    if let Some(out) = &mut out {
        for line in out.lines() {
            pushed = line.map_err(input)?.trim().parse().map_err(input)?;
            if pushed >= life {
                break;
            }
        }
    }
    drop(child);
    drop(out);
    let out = path.with_extension("saved.mcap");
    let saved = Saved::of(path, &out);
    for file in [path, &out] {
        let _ = std::fs::remove_file(file);
    }
    let Some(saved) = saved? else {
        return Ok(Fate {
            empty: pushed == 0,
            lost: pushed,
            ..Fate::default()
        });
    };
    let least = saved.ticks.iter().map(Vec::len).min().unwrap_or(0) as u64;
    let lost = pushed.saturating_sub(least);
    Ok(Fate {
        readable: true,
        lost,
        chunks: saved.report.damage.chunks,
        uncounted: lost > 0 && !(saved.report.damage.unfinished && saved.says_so),
        other: saved.other,
        ..Fate::default()
    })
}

/// Records to `path` in real time until it is killed, or for a minute. Says on stdout how many ticks were handed over.
///
/// # Errors
/// The recorder cannot be started.
pub fn record_until_killed(path: &Path) -> Result<(), SessionError> {
    let io = |source| SessionError::Io {
        path: path.to_owned(),
        source,
    };
    let (mut ring, records) = rtrb::RingBuffer::new(16 * 1024);
    let recorder = RecorderThread::spawn(records, None).map_err(io)?;
    recorder.start(path, header())?;
    let began = Instant::now();
    let push = |ring: &mut rtrb::Producer<FingerRecord>, ticks: Range<u64>| {
        for tick in ticks {
            for finger in 0..FINGERS {
                let _ = ring.push(record(tick, finger));
            }
        }
    };
    let mut pushed = 0;
    while began.elapsed() < Duration::from_secs(60) {
        let due = began.elapsed().as_millis() as u64;
        push(&mut ring, pushed..due.max(pushed));
        pushed = due.max(pushed);
        let mut out = std::io::stdout().lock();
        if writeln!(out, "{pushed}")
            .and_then(|()| out.flush())
            .is_err()
        {
            break;
        }
        drop(out);
        std::thread::sleep(Duration::from_millis(2));
    }
    recorder.stop().map(drop)
}
