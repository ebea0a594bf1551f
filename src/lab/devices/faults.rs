//! Everything that can fail in the middle of a press, tried on every emulated arm: how soon the force is gone, what is told,
//! what the recording is worth.

use super::judge::{File, Force};
use super::program::{Order, PRESSED, STALL, Told, Trouble};
use super::{SUBCOMMAND, input, program};
use crate::device::hid::arms::Arms;
use crate::device::hid::driver::Protocol;
use crate::device::hid::emulator::process::{Emulated, Request, Wire, families};
use crate::device::hid::emulator::{Fault, Hand, truth};
use crate::device::{Family as _, Found};
use crate::lab::{Experiment, LabError, Report, Setup, Table, Verdict, Watch};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::io::{BufRead as _, BufReader};
use std::os::fd::OwnedFd;
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// What becomes of a press in which something fails.
pub struct DeviceFaults;

/// Within this time the force is to be gone where nothing else bounds it, ms.
const BOUND_MS: f64 = 10.0;
/// The emulated board looks at its watchdog once a millisecond, and hears once a millisecond, ms.
const STEPS_MS: f64 = 2.0;
/// Runs of a case that the machine may spoil: the press ended before the fault came.
const TRIES: u32 = 4;

/// What fails.
#[derive(Clone, Copy, Debug, PartialEq)]
enum What {
    /// The device.
    Board(Fault),
    /// The program, inside.
    Program(Trouble),
    /// The whole program stands still for 50 ms.
    Stops,
    /// The program gets a signal.
    Signal(Signal),
}

impl What {
    const ALL: [Self; 13] = [
        Self::Board(Fault::Unplugged),
        Self::Board(Fault::Silent),
        Self::Board(Fault::Frozen),
        Self::Board(Fault::Jump),
        Self::Board(Fault::Extreme),
        Self::Board(Fault::Short),
        Self::Board(Fault::Slow),
        Self::Board(Fault::Reversed),
        Self::Program(Trouble::Stalls),
        Self::Program(Trouble::Panics),
        Self::Stops,
        Self::Signal(Signal::SIGTERM),
        Self::Signal(Signal::SIGKILL),
    ];

    fn title(self) -> &'static str {
        match self {
            Self::Board(Fault::Unplugged) => "unplugged",
            Self::Board(Fault::Frozen) => "reports frozen",
            Self::Board(Fault::Silent) => "silent",
            Self::Board(Fault::Jump) => "an encoder jumps",
            Self::Board(Fault::Extreme) => "encoders at their extremes",
            Self::Board(Fault::Short) => "short reports",
            Self::Board(Fault::Slow) => "a report every 50 ms",
            Self::Board(Fault::Reversed) => "a motor reversed, hand lets go",
            Self::Program(Trouble::Stalls) => "servo stalled for 50 ms",
            Self::Program(Trouble::Panics) => "panic in the servo's device",
            Self::Stops => "program stopped for 50 ms",
            Self::Signal(Signal::SIGTERM) => "SIGTERM",
            Self::Signal(_) => "SIGKILL",
        }
    }

    /// Whether the run may go on with force when it is over.
    fn passes(self) -> bool {
        matches!(self, Self::Stops | Self::Program(Trouble::Stalls))
    }

    /// How long the press is looked at afterwards, s.
    fn after_s(self, arms: &Arms) -> f64 {
        match self {
            Self::Board(Fault::Frozen) if !counts(arms) => 1.5,
            _ => 0.35,
        }
    }

    /// Within which time the force is to be gone, ms, and why it may take longer than 10; nothing where nothing bounds it.
    fn bound(self, arms: &Arms) -> (Option<f64>, &'static str) {
        let watchdog_ms = arms.protocol.board_watchdog_s().map(|s| s * 1000.0);
        match self {
            Self::Board(Fault::Reversed) => (Some(100.0), "it must have run to be found"),
            Self::Board(Fault::Frozen) if !counts(arms) => {
                (None, "no counter: not to be told from a still hand")
            }
            Self::Stops => match watchdog_ms {
                Some(ms) if ms < STALL.as_secs_f64() * 1e3 => {
                    (Some(ms + STEPS_MS), "the board's watchdog")
                }
                _ => (None, "the board holds its force until the program goes on"),
            },
            Self::Signal(Signal::SIGKILL) => match watchdog_ms {
                Some(ms) => (Some(ms + STEPS_MS), "the board's watchdog"),
                None => (None, "no watchdog of the board is known"),
            },
            _ => (Some(BOUND_MS), ""),
        }
    }
}

fn counts(arms: &Arms) -> bool {
    arms.protocol == Protocol::Wooden
}

impl Experiment for DeviceFaults {
    fn name(&self) -> &'static str {
        "device-faults"
    }

    fn about(&self) -> &'static str {
        "Devices, servo and program that fail in the middle of a press: when the force is gone, what is told, what the file is worth"
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        let Some(program) = program(&mut report, watch)? else {
            twins(&mut report);
            return Ok(report);
        };
        let folder = tempfile::tempdir().map_err(input)?;
        report.set(
            "press",
            "8 mm deep into the built-in back, hand and arm simulated",
        );
        report.set("fault", "once 1 N was felt for 0.1 s");
        let repeats = if setup.quick { 1 } else { 5 };
        report.set("runs of each", repeats);
        // A look tries each fault on one board, and each board with the fault that it alone has trouble with.
        let cases: Vec<(&Arms, What)> = families()
            .into_iter()
            .flat_map(|arms| What::ALL.map(|what| (arms, what)))
            .filter(|(arms, what)| {
                !setup.quick
                    || counts(arms)
                    || matches!(
                        what,
                        What::Board(Fault::Frozen) | What::Signal(Signal::SIGKILL)
                    )
            })
            .collect();
        let mut table = Table::new(
            "faults",
            "What fails, and what becomes of it; the worst of all runs",
            &[
                "device",
                "fault",
                "runs",
                "force before (N)",
                "no force after, median (ms)",
                "no force after, worst (ms)",
                "bound (ms)",
                "highest since (N)",
                "force again (N)",
                "held up by the machine (ms)",
                "told",
                "recording",
                "fault event",
            ],
        );
        let n = cases.len() as f64;
        for (i, (arms, what)) in cases.into_iter().enumerate() {
            let mut sum = Sum::new(arms, what);
            for run in 0..repeats {
                let share = (i as f64 + f64::from(run) / f64::from(repeats)) / n;
                watch.at(&format!("{}: {}", arms.title(), what.title()), share)?;
                sum.add(pressed(program, folder.path(), arms, what)?);
            }
            sum.tell(&mut table, &mut report);
        }
        report.tables.push(table);
        twins(&mut report);
        report.note(
            "Times are from the fault to the first of 3 ms without a commanded current, as the emulator heard it. Held up: the longest \
             that the machine kept the emulator or the servo from running in the run; a time is held to its bound plus that. Told: what \
             the link and the servo say, which the window shows. A NaN has no place in the reports of these boards; encoders at their \
             extremes are the worst that they can carry.",
        );
        report.note(
            "Boards without a counter repeat a still hand's report exactly as a frozen board does: the tremor of a pressing hand, some \
             hundredths of a newton, is less than the Coulomb friction of such an arm, so that stillness is no proof, and the force that \
             frozen encoders ask for does not change by which it could be found. It stays what it was, and no more. Boards whose watchdog nobody \
             documents keep the last current when the program is killed: unplug them, or switch their amplifier off.",
        );
        Ok(report)
    }
}

/// One press that failed.
struct Run {
    force: Force,
    told: Option<Told>,
    file: File,
    /// Longest that the program itself was kept from running, ms; nothing where it cannot tell.
    held_up_ms: f64,
    zero_at_end: bool,
}

/// A child that does not outlive whoever started it.
struct Pressing(Child);

impl Drop for Pressing {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Pressing {
    fn start(program: &Path, order: &Order, wire: OwnedFd) -> Result<Self, LabError> {
        let words = serde_json::to_string(order).map_err(input)?;
        let child = Command::new(program)
            .args([SUBCOMMAND, &words])
            .stdin(Stdio::from(wire))
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        child.map(Self).map_err(input)
    }

    fn signal(&self, signal: Signal) -> Result<(), LabError> {
        let id = i32::try_from(self.0.id()).map_err(input)?;
        kill(Pid::from_raw(id), signal).map_err(input)
    }

    /// When the signal was sent that makes it fail, if any, and what it said at its end.
    fn watched(mut self, what: What) -> Result<(Option<f64>, Option<Told>), LabError> {
        let Some(out) = self.0.stdout.take() else {
            return Ok((None, None));
        };
        let (mut failed_at, mut told) = (None, None);
        for line in BufReader::new(out).lines() {
            let Ok(line) = line else { break };
            if line != PRESSED {
                told = serde_json::from_str(&line).ok();
                continue;
            }
            match what {
                What::Stops => {
                    failed_at = Some(truth::now_s());
                    self.signal(Signal::SIGSTOP)?;
                    std::thread::sleep(STALL);
                    self.signal(Signal::SIGCONT)?;
                }
                What::Signal(signal) => {
                    failed_at = Some(truth::now_s());
                    self.signal(signal)?;
                }
                What::Board(_) | What::Program(_) => {}
            }
        }
        Ok((failed_at, told))
    }
}

/// Presses until the fault came in the middle of it; a busy machine can end a press before.
fn pressed(program: &Path, folder: &Path, arms: &Arms, what: What) -> Result<Run, LabError> {
    for _ in 0..TRIES {
        if let Some(run) = once(program, folder, arms, what)? {
            return Ok(run);
        }
    }
    Err(input(format!(
        "{}, {}: the machine held the press up {TRIES} times before the fault came; try again when it has less to do",
        arms.title(),
        what.title()
    )))
}

fn once(program: &Path, folder: &Path, arms: &Arms, what: What) -> Result<Option<Run>, LabError> {
    let (recording, truth_file) = (folder.join("press.mcap"), folder.join("truth"));
    for file in [&recording, &truth_file] {
        let _ = std::fs::remove_file(file);
    }
    let request = Request {
        seconds: 30.0,
        hand: Hand::Insist { depth_mm: 8.0 },
        fault: match what {
            What::Board(fault) => Some(fault),
            _ => None,
        },
        truth: Some(truth_file.clone()),
        ..Request::press(arms.key())
    };
    let order = Order {
        family: arms.key().into(),
        wire: Wire::Socket,
        recording: recording.clone(),
        trouble: match what {
            What::Program(trouble) => Some(trouble),
            _ => None,
        },
        after_s: what.after_s(arms),
        patience_s: 15.0,
    };
    let (emulator, wire) = Emulated::spawn_raw(program, &request).map_err(input)?;
    let (signalled_at, told) = Pressing::start(program, &order, wire)?.watched(what)?;
    let outcome = emulator.outcome().map_err(input)?;
    let failed_at = match what {
        What::Board(_) => outcome.fault_at_s,
        What::Program(_) => told.as_ref().and_then(|t| t.trouble_at_s),
        What::Stops | What::Signal(_) => signalled_at,
    };
    let Some(failed_at) = failed_at else {
        return Ok(None);
    };
    let truths = truth::read(&truth_file).map_err(input)?;
    let force = Force::of(&truths, failed_at);
    if force.before_n < 0.5 {
        return Ok(None);
    }
    let meant = matches!(what, What::Stops | What::Program(_));
    let program_ms = told
        .as_ref()
        .filter(|_| !meant)
        .map_or(0.0, |t| t.longest_ms);
    Ok(Some(Run {
        held_up_ms: (force.held_up_ms - 1.0).max(0.0) + (program_ms - 1.0).max(0.0),
        force,
        told,
        file: File::of(&recording),
        zero_at_end: outcome.ended_at_zero,
    }))
}

/// All runs of a case.
struct Sum<'a> {
    arms: &'a Arms,
    what: What,
    runs: Vec<Run>,
}

impl<'a> Sum<'a> {
    fn new(arms: &'a Arms, what: What) -> Self {
        Self {
            arms,
            what,
            runs: Vec::new(),
        }
    }

    fn add(&mut self, run: Run) {
        self.runs.push(run);
    }

    fn most(&self, of: impl Fn(&Run) -> f64) -> f64 {
        self.runs.iter().map(of).fold(0.0, f64::max)
    }

    fn told(&self) -> String {
        let mut said: Vec<&str> = Vec::new();
        for run in &self.runs {
            let words = run.told.iter().flat_map(|t| &t.said);
            for word in words {
                if !said.contains(&word.as_str()) {
                    said.push(word);
                }
            }
        }
        match (said.is_empty(), self.runs.iter().any(|r| r.told.is_none())) {
            (true, true) => "nothing: it was killed".into(),
            (true, false) => "nothing".into(),
            (false, _) => said.join("; "),
        }
    }

    fn tell(&self, table: &mut Table, report: &mut Report) {
        let mut gone: Vec<Option<f64>> = self.runs.iter().map(|r| r.force.gone_ms).collect();
        // None is never, and later than all.
        gone.sort_by(|a, b| match (a, b) {
            (Some(a), Some(b)) => a.total_cmp(b),
            (a, b) => b.is_some().cmp(&a.is_some()),
        });
        let median = gone.get(gone.len() / 2).copied().flatten();
        let worst = gone.last().copied().flatten();
        let (bound, why) = self.what.bound(self.arms);
        let killed = self.what == What::Signal(Signal::SIGKILL);
        let whole = self.runs.iter().filter(|r| r.file.clean).count();
        let readable = self.runs.iter().filter(|r| r.file.readable).count();
        let n = self.runs.len();
        let event = self.runs.iter().find_map(|r| r.file.faults.last());
        let again_n = self.most(|r| r.force.again_n);
        let held_up_ms = self.most(|r| r.held_up_ms);
        table.push([
            self.arms.title().into(),
            self.what.title().into(),
            n.into(),
            self.runs
                .iter()
                .map(|r| r.force.before_n)
                .fold(f64::INFINITY, f64::min)
                .into(),
            median.into(),
            worst.into(),
            bound.into(),
            self.most(|r| r.force.highest_n).into(),
            again_n.into(),
            held_up_ms.into(),
            self.told().into(),
            self.runs
                .iter()
                .find(|r| !r.file.clean)
                .or(self.runs.first())
                .map(|r| r.file.told.clone())
                .into(),
            event.cloned().into(),
        ]);
        let name = format!("{}, {}", self.arms.title(), self.what.title());
        let measured = match worst {
            Some(ms) => format!("{ms:.1} ms"),
            None => "never".into(),
        };
        let verdict = match bound {
            Some(bound_ms) => {
                let in_time = self.runs.iter().all(|r| {
                    let allowed_ms = bound_ms + r.held_up_ms;
                    r.force.gone_ms.is_some_and(|ms| ms <= allowed_ms)
                });
                let stays = self.what.passes() || again_n <= 0.05;
                let because = match why {
                    "" => String::new(),
                    why => format!(" ({why})"),
                };
                let goal = format!("within {bound_ms:.0} ms and what the machine held up{because}");
                Verdict::must(
                    format!("{name}: no force"),
                    measured,
                    goal,
                    in_time && stays,
                )
            }
            None => Verdict::told(
                format!("{name}: no force"),
                measured,
                format!("unbounded: {why}"),
                worst.is_some() || self.what.passes(),
            ),
        };
        report.verdicts.push(verdict);
        let highest_n = self.most(|r| r.force.highest_n);
        let most_n = self.arms.defaults().rated_force_n * 1.1;
        let recorded = if killed {
            readable == n
        } else {
            whole == n && self.runs.iter().all(|r| r.zero_at_end)
        };
        let said = killed
            || self
                .runs
                .iter()
                .all(|r| r.told.as_ref().is_some_and(|t| !t.said.is_empty()));
        report.verdicts.push(Verdict::must(
            format!("{name}: force bounded, recording, told"),
            format!(
                "{highest_n:.2} N; {whole} of {n} files whole, {readable} readable; {}",
                if said { "told" } else { "not told" }
            ),
            if killed {
                "rated force; readable"
            } else {
                "rated force; whole, no current at the end; told"
            },
            highest_n <= most_n && recorded && (said || bound.is_none()),
        ));
    }
}

/// Two devices that tell one serial number: nobody's calibration goes to the other.
fn twins(report: &mut Report) {
    let twin = |place: &str| Found {
        family: families()[0].key(),
        place: place.into(),
        title: "WoodenHaptics".into(),
        serial: Some("7".into()),
        note: None,
    };
    let mut found = [twin("a"), twin("b")];
    Found::tell_apart(&mut found);
    let apart = found.iter().all(|f| f.serial.is_none() && f.note.is_some());
    let told = found[0].note.clone().unwrap_or_default();
    report.verdicts.push(Verdict::must(
        "two devices with one serial number",
        told,
        "both listed, the calibration of the family for either, and told",
        apart,
    ));
}
