//! Hours of recording: bit-exact through pause, edit and change of device; what it costs beside a busy program and a slow disk.

use super::long::{FINGERS, Long, RATE_HZ, Scenes, input, limits};
use crate::lab::{Choice, Experiment, LabError, Report, Samples, Setup, Table, Verdict, Watch};
use crate::scenario::Scene;
use crate::servo::{FingerRecord, Rig};
use crate::session::writer::Store;
use crate::session::{
    CheckReport, Edit, RecorderThread, Session, SessionError, Strictness, Timeline, check_edited,
    compress,
};
use std::fs::{File, OpenOptions};
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Builder;
use std::time::{Duration, Instant};

/// Re-simulation is to be this many times faster than the run was.
const GOAL_TIMES: f64 = 200.0;
/// Random instants that are shown.
const SEEKS: u64 = 2000;
/// Each append to the slow disk takes so long.
const SLOW: Duration = Duration::from_millis(120);
/// Records that the servo's ring holds.
const RING: usize = 16 * 1024;

/// What long sessions cost.
pub struct SessionEndurance;

impl Experiment for SessionEndurance {
    fn name(&self) -> &'static str {
        "session-endurance"
    }

    fn about(&self) -> &'static str {
        "Hours of two fingers at 1 kHz: repeated bit for bit; CPU, size, opening, scrubbing; a slow disk and a busy program"
    }

    fn takes(&self) -> &'static [Choice] {
        &[Choice::Triangles, Choice::Seconds]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        let triangles = setup.triangles.last().copied().unwrap_or(20_389);
        report.set("surface", format!("built-in back, {triangles} triangles"));
        report.set("fingers", format!("{FINGERS}, scripted, {RATE_HZ} Hz"));
        let scenes = Scenes::build(triangles, &mut watch.part(0.0, 0.02))?;
        let folder = tempfile::tempdir().map_err(input)?;
        // Hours are recorded in files of an hour each, so that eight need no more disk than one.
        let (part_s, runs): (f64, &[(&str, u32)]) = if setup.quick {
            (4.0, &[("4 s", 1), ("8 s", 2)])
        } else {
            (3600.0, &[("1 h", 1), ("8 h", 8)])
        };
        let parts: u32 = runs.iter().map(|(_, n)| n).sum();
        let mut hours = Hours::default();
        let mut table = Table::new(
            "hours",
            "Simulated hours, recorded through a pause, an edit and a change of device, then repeated; files of one hour each",
            &[
                "run",
                "ticks",
                "size (MB)",
                "compared",
                "edits",
                "gaps",
                "bit-exact",
                "re-simulated (× real time)",
                "recorded (× real time)",
            ],
        );
        let mut done = 0;
        for (name, n) in runs {
            let mut sum = Repeated::default();
            let mut long = Long::new(&scenes);
            for i in 0..*n {
                let share = |k: u32| 0.02 + 0.78 * f64::from(k) / f64::from(parts);
                let mut part = watch.part(share(done), share(done + 1));
                done += 1;
                let path = folder.path().join("part.mcap");
                sum.part(&mut long, &scenes, &path, part_s, &mut part)?;
                if (*name, i) == (runs[0].0, 0) {
                    hours.look_at(&path, &scenes, &mut part)?;
                }
                std::fs::remove_file(&path).map_err(input)?;
            }
            table.push([
                (*name).into(),
                (sum.ticks as usize).into(),
                (sum.bytes as f64 / 1e6).into(),
                (sum.compared as usize).into(),
                (sum.edits as usize).into(),
                (sum.gaps as usize).into(),
                if sum.exact { "yes" } else { "no" }.into(),
                sum.times().into(),
                (sum.run_s / sum.record_s.max(1e-9)).into(),
            ]);
            report.verdicts.push(Verdict::must(
                format!("{name}: repeated"),
                format!("{} of {} ticks; {}", sum.compared, sum.ticks, sum.first),
                "all but those behind a gap, bit for bit",
                sum.exact && sum.compared + sum.gaps + u64::from(*n) == sum.ticks && sum.edits == 1,
            ));
            report.verdicts.push(Verdict::told(
                format!("{name}: re-simulation"),
                format!("{:.0} × real time", sum.times()),
                format!("at least {GOAL_TIMES} ×"),
                sum.times() >= GOAL_TIMES,
            ));
        }
        report.tables.push(table);
        hours.tell(&mut report);
        let short_s = if setup.quick { 1.0 } else { 60.0 };
        let slow_s = setup.seconds.unwrap_or(short_s);
        let mut live = Table::new(
            "live",
            "Recorded in real time, a disk that takes 120 ms for each append or not, another thread that never rests",
            &[
                "disk",
                "seconds (s)",
                "ticks",
                "lost",
                "recorder (% of a core)",
                "per hour (MB)",
            ],
        );
        for (slow, live_s, from, to) in [(false, short_s, 0.84, 0.86), (true, slow_s, 0.86, 1.0)] {
            let mut part = watch.part(from, to);
            let header = Long::new(&scenes).header();
            let path = folder.path().join("live.mcap");
            let run = Live::run(&path, header, slow, live_s, &mut part)?;
            let disk = if slow { "slow" } else { "as it is" };
            live.push([
                disk.into(),
                live_s.into(),
                (run.ticks as usize).into(),
                (run.lost as usize).into(),
                run.cpu_percent.into(),
                (run.bytes as f64 / live_s * 3600.0 / 1e6).into(),
            ]);
            report.verdicts.push(Verdict::must(
                format!("disk {disk}: lost"),
                format!("{} of {} ticks", run.lost, run.ticks),
                "none",
                run.lost == 0 && run.ticks > 0,
            ));
        }
        report.tables.push(live);
        Ok(report)
    }
}

/// A run that was repeated, part by part.
struct Repeated {
    ticks: u64,
    bytes: u64,
    compared: u64,
    edits: u64,
    gaps: u64,
    exact: bool,
    first: String,
    run_s: f64,
    record_s: f64,
    check_s: f64,
}

impl Default for Repeated {
    fn default() -> Self {
        Self {
            ticks: 0,
            bytes: 0,
            compared: 0,
            edits: 0,
            gaps: 0,
            exact: true,
            first: "no difference".into(),
            run_s: 0.0,
            record_s: 0.0,
            check_s: 0.0,
        }
    }
}

impl Repeated {
    fn times(&self) -> f64 {
        self.run_s / self.check_s.max(1e-9)
    }

    fn part(
        &mut self,
        long: &mut Long<'_>,
        scenes: &Scenes,
        path: &Path,
        part_s: f64,
        watch: &mut Watch<'_>,
    ) -> Result<(), LabError> {
        let before = long.header().edit;
        let began = Instant::now();
        let ticks = (part_s * RATE_HZ) as u64;
        let written = long.record(path, ticks, &mut watch.part(0.0, 0.5))?;
        self.record_s += began.elapsed().as_secs_f64();
        let began = Instant::now();
        let scene = if before == 0 {
            &scenes.first
        } else {
            &scenes.edited
        };
        let found = repeated(path, scene, scenes, &mut watch.part(0.5, 0.95))?;
        self.check_s += began.elapsed().as_secs_f64();
        self.run_s += part_s;
        self.ticks += written.ticks;
        self.bytes += written.bytes;
        self.compared += found.compared;
        self.edits += found.passed.edits;
        self.gaps += found.passed.gaps;
        self.exact &= found.is_bit_exact() && found.damage.is_none() && written.lost == 0;
        if let Some(first) = found.first_difference {
            self.first = first.to_string();
        }
        Ok(())
    }
}

fn repeated(
    path: &Path,
    scene: &Scene,
    scenes: &Scenes,
    watch: &mut Watch<'_>,
) -> Result<CheckReport, LabError> {
    let session = Session::open(path).map_err(input)?;
    let rig = Rig::new(Box::new(scene.touch.clone()), limits());
    let rebuild = |_: &Edit| Ok(scenes.edited.touch.clone());
    let mut n = 0_u32;
    let mut stopped = false;
    let found = check_edited(
        &session,
        rig,
        Box::new(rebuild),
        Strictness::Strict,
        |_, done| {
            n += 1;
            if n.is_multiple_of(10_000) && !stopped {
                stopped = watch.at("repeating", done).is_err();
            }
        },
    );
    if stopped {
        return Err(LabError::Stopped);
    }
    found.map_err(input)
}

/// What opening and scrubbing the first file takes.
#[derive(Default)]
struct Hours {
    rows: Vec<(&'static str, f64, Samples)>,
    megabytes: (f64, f64),
    compress_s: f64,
    one_bit: String,
    one_bit_found: bool,
}

impl Hours {
    fn look_at(
        &mut self,
        path: &Path,
        scenes: &Scenes,
        watch: &mut Watch<'_>,
    ) -> Result<(), LabError> {
        watch.at("one bit changed", 0.95)?;
        let session = Session::open(path).map_err(input)?;
        let rig = Rig::new(Box::new(scenes.one_bit_off.touch.clone()), limits());
        let edited = |_: &Edit| Ok(scenes.edited.touch.clone());
        let found = check_edited(
            &session,
            rig,
            Box::new(edited),
            Strictness::Strict,
            |_, _| (),
        );
        let found = found.map_err(input)?;
        self.one_bit_found = !found.is_bit_exact();
        self.one_bit = match &found.first_difference {
            Some(first) => {
                let most = found.differences.iter().find(|d| d.field == "force_n");
                let most = most.map_or(0.0, |d| d.max);
                format!("{first}; force off by at most {most:.1e} N")
            }
            None => "nothing".into(),
        };
        self.scrub("finished", path, &mut watch.part(0.96, 0.97))?;
        watch.at("compressing", 0.97)?;
        let began = Instant::now();
        let made = compress(path, &mut |_| true).map_err(input)?;
        self.compress_s = began.elapsed().as_secs_f64();
        self.megabytes = (made.before as f64 / 1e6, made.after as f64 / 1e6);
        self.scrub("compressed", path, &mut watch.part(0.98, 0.99))?;
        // Without its end, as a killed recording.
        let file = OpenOptions::new().write(true).open(path).map_err(input)?;
        file.set_len(made.after - 40).map_err(input)?;
        self.scrub("killed", path, &mut watch.part(0.99, 1.0))
    }

    fn scrub(
        &mut self,
        name: &'static str,
        path: &Path,
        watch: &mut Watch<'_>,
    ) -> Result<(), LabError> {
        watch.at("opening and scrubbing", 0.0)?;
        let began = Instant::now();
        let timeline = Timeline::open(path).map_err(input)?;
        let opened_ms = began.elapsed().as_secs_f64() * 1e3;
        let (first, last) = timeline.span_ns();
        let mut random = 1_u64;
        let mut times = Samples::default();
        for _ in 0..SEEKS {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let at = first + (random >> 11) % (last - first).max(1);
            let began = Instant::now();
            let shown = timeline.at_ns(at);
            times.push(began.elapsed().as_secs_f64() * 1e3);
            if shown.fingers[0].time_ns > at {
                return Err(input("a seek went past its instant"));
            }
        }
        self.rows.push((name, opened_ms, times));
        Ok(())
    }

    fn tell(self, report: &mut Report) {
        let mut table = Table::new(
            "opening",
            "The first file: opening it by its index (or, killed, by reading it through), and showing random instants",
            &["file", "opened (ms)", "seek, median (ms)", "seek, p99 (ms)"],
        );
        for (name, opened, seeks) in &self.rows {
            let (median, p99) = (seeks.median(), seeks.quantile(0.99));
            table.push([(*name).into(), (*opened).into(), median.into(), p99.into()]);
            if *name == "finished" {
                report.verdicts.push(Verdict::told(
                    "opening a finished file",
                    format!("{opened:.1} ms"),
                    "at most 200 ms",
                    *opened <= 200.0,
                ));
                report.verdicts.push(Verdict::told(
                    "scrubbing a finished file, 99 of 100 seeks",
                    format!("{p99:.2} ms"),
                    "at most 8 ms, half a frame",
                    p99 <= 8.0,
                ));
            }
        }
        report.tables.push(table);
        let mut table = Table::new(
            "size",
            "The first file before and after compression",
            &[
                "recorded (MB)",
                "compressed (MB)",
                "share (%)",
                "compressed in (s)",
            ],
        );
        let (before, after) = self.megabytes;
        table.push([
            before.into(),
            after.into(),
            (100.0 * after / before.max(1e-9)).into(),
            self.compress_s.into(),
        ]);
        report.tables.push(table);
        report.verdicts.push(Verdict::must(
            "one bit of the stiffness changed",
            self.one_bit,
            "found, with tick and size",
            self.one_bit_found,
        ));
    }
}

/// A file on a disk that takes its time.
struct SlowDisk {
    file: File,
    slow: bool,
}

impl Store for SlowDisk {
    fn append(&self, bytes: &[u8]) -> io::Result<()> {
        if self.slow {
            std::thread::sleep(SLOW);
        }
        self.file.append(bytes)
    }

    fn keep(&self) -> io::Result<()> {
        self.file.keep()
    }
}

/// A recording in real time.
struct Live {
    ticks: u64,
    lost: u64,
    bytes: u64,
    cpu_percent: Option<f64>,
}

impl Live {
    fn run(
        path: &Path,
        header: crate::session::Header,
        slow: bool,
        live_s: f64,
        watch: &mut Watch<'_>,
    ) -> Result<Self, LabError> {
        let (mut ring, records) = rtrb::RingBuffer::new(RING);
        let recorder = RecorderThread::spawn(records, None).map_err(input)?;
        let file = File::create(path).map_err(input)?;
        recorder
            .start_on(Box::new(SlowDisk { file, slow }), path, header)
            .map_err(input)?;
        let rest = Arc::new(AtomicBool::new(false));
        let busy = {
            let rest = Arc::clone(&rest);
            let spin = move || {
                let mut n = 0_u64;
                while !rest.load(Ordering::Relaxed) {
                    n = std::hint::black_box(n.wrapping_mul(3).wrapping_add(1));
                }
            };
            Builder::new()
                .name("busy".into())
                .spawn(spin)
                .map_err(input)?
        };
        let outcome = Self::push(&mut ring, live_s, watch);
        rest.store(true, Ordering::Relaxed);
        let _ = busy.join();
        let (pushed, dropped, cpu_percent) = outcome?;
        let summary = recorder.stop().map_err(|e: SessionError| input(e))?;
        let _ = std::fs::remove_file(path);
        Ok(Self {
            ticks: pushed,
            lost: dropped + summary.lost + pushed.saturating_sub(summary.ticks),
            bytes: summary.bytes,
            cpu_percent,
        })
    }

    /// Ticks pushed, records that the ring had no room for, and what the recorder took, % of a core.
    fn push(
        ring: &mut rtrb::Producer<FingerRecord>,
        live_s: f64,
        watch: &mut Watch<'_>,
    ) -> Result<(u64, u64, Option<f64>), LabError> {
        let (began, before) = (Instant::now(), recorder_ns());
        let (mut pushed, mut dropped) = (0, 0);
        while began.elapsed().as_secs_f64() < live_s {
            let due = began.elapsed().as_millis() as u64;
            for tick in pushed..due {
                for finger in 0..FINGERS as u8 {
                    let record = FingerRecord {
                        tick,
                        finger,
                        time_ns: tick * 1_000_000,
                        ..FingerRecord::default()
                    };
                    dropped += u64::from(ring.push(record).is_err());
                }
            }
            if pushed / 1000 < due / 1000 {
                watch.at("recording live", began.elapsed().as_secs_f64() / live_s)?;
            }
            pushed = due.max(pushed);
            std::thread::sleep(Duration::from_millis(1));
        }
        let took = before.zip(recorder_ns()).map(|(a, b)| b.saturating_sub(a));
        let cpu = took.map(|ns| 100.0 * ns as f64 / began.elapsed().as_nanos() as f64);
        Ok((pushed, dropped, cpu))
    }
}

/// Time that the recorder's thread has run, ns, where the system tells (Linux).
fn recorder_ns() -> Option<u64> {
    let threads = std::fs::read_dir("/proc/self/task").ok()?;
    let thread = threads.flatten().map(|t| t.path()).find(|t| {
        let name = std::fs::read_to_string(t.join("comm"));
        name.is_ok_and(|n| n.trim() == "recorder")
    })?;
    let times = std::fs::read_to_string(thread.join("schedstat")).ok()?;
    times.split_whitespace().next()?.parse().ok()
}
