//! The loop that turns: how far position and force are off what the emulated arm knows of itself, and what gets lost.

use super::press::{Run, laid, scene};
use super::{input, program};
use crate::device::hid::arm::Arm;
use crate::device::hid::arms::Arms;
use crate::device::hid::driver::ArmDriver;
use crate::device::hid::emulator::process::{Emulated, Request, Wire, families};
use crate::device::hid::emulator::truth::{self, Truth, now_s};
use crate::device::hid::emulator::{Hand, Outcome};
use crate::device::hid::link::{Driver, Linked, Seen};
use crate::device::hid::transport::REPORT;
use crate::device::mapped::Mapped;
use crate::device::{Calibration, Device as _, Family as _, Reading, Vitals};
use crate::geom::Vec3;
use crate::lab::{
    Choice, Experiment, LabError, Report, Samples, Setup, Table, Value, Verdict, Watch,
};
use crate::scenario::Scene;
use crate::servo::{Limits, MAX_FINGERS, Rig, TickInput, tick};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The loop with every emulated arm, over each wire.
pub struct DeviceLoop;

/// How long each is watched unless asked otherwise, s.
const SECONDS: f64 = 60.0;
const QUICK_S: f64 = 2.0;
/// Rows between link and experiment: four seconds of them.
const RING: usize = 16 * 1024;
/// A late tick spoils what was felt this long before it was seen, s.
const SEEN_LATE_S: f64 = 0.02;
/// A force below this is none, N.
const NONE_N: f64 = 1.0e-9;

impl Experiment for DeviceLoop {
    fn name(&self) -> &'static str {
        "device-loop"
    }

    fn about(&self) -> &'static str {
        "The whole loop with every emulated arm at 1 kHz, over a socket and a pseudo-terminal: error of position and force, losses, latency"
    }

    fn takes(&self) -> &'static [Choice] {
        &[Choice::Seconds]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        let Some(program) = program(&mut report, watch)? else {
            return Ok(report);
        };
        let usual_s = if setup.quick { QUICK_S } else { SECONDS };
        let seconds = setup.seconds.unwrap_or(usual_s).max(1.0);
        let folder = tempfile::tempdir().map_err(input)?;
        let scene = scene()?;
        report.set("each", format!("{seconds} s"));
        report.set(
            "hand",
            "simulated, presses 8 mm deep and leaves 0.7 times a second while it wanders sideways",
        );
        let mut tables = tables();
        let n = (families().len() * Wire::ALL.len()) as f64;
        let mut done = 0.0;
        for arms in families() {
            for wire in Wire::ALL {
                let mut part = watch.part(done / n, (done + 1.0) / n);
                done += 1.0;
                let what = format!("{}, {}", arms.title(), wire.title());
                part.at(&what, 0.0)?;
                let case = Case {
                    program,
                    folder: folder.path(),
                    scene: &scene,
                    arms,
                    wire,
                    seconds,
                };
                case.turned(&mut part)?
                    .tell(&case, &mut tables, &mut report);
            }
        }
        report.tables.extend(tables);
        report.note(
            "Position: where the link says the tip is, report by report, against where it was when the report was made. Rendering: the force \
             that the servo asked for, command by command, against that of the currents that the board heard. Loop: the force that flowed, \
             millisecond by millisecond, against what the model feels at the true place at that instant: delay, quantisation, current loop \
             and whatever the machine held up are in it. Undisturbed leaves out all from a tick without force (late, or a silence) to the \
             next time that the finger is out of the skin.",
        );
        Ok(report)
    }
}

fn tables() -> [Table; 3] {
    [
        Table::new(
            "loop",
            "The loop at 1 kHz: losses, rates, latencies",
            &[
                "device",
                "wire",
                "reports",
                "lost",
                "not understood",
                "reports a second (Hz)",
                "late ticks",
                "milliseconds disturbed (%)",
                "report under way, median (ms)",
                "report under way, p99 (ms)",
                "answered after, median (ms)",
                "answered after, p99 (ms)",
                "command under way, median (ms)",
                "command under way, p99 (ms)",
            ],
        ),
        Table::new(
            "position",
            "What the link says of the place, off the truth",
            &[
                "device",
                "wire",
                "rms (mm)",
                "p99 (mm)",
                "highest (mm)",
                "encoder step (mm)",
                "rms in steps",
                "p99 in steps",
                "highest in steps",
            ],
        ),
        Table::new(
            "force",
            "Force off the truth",
            &[
                "device",
                "wire",
                "of",
                "highest force (N)",
                "rms (N)",
                "p99 (N)",
                "highest (N)",
            ],
        ),
    ]
}

/// What passed through the link.
#[derive(Clone, Copy, Debug)]
enum Passed {
    /// A report: when, and where it says the tip is.
    Took { at_s: f64, position_mm: Vec3 },
    /// A command: when, and the force asked for; none: the force was off.
    Rendered { at_s: f64, force_n: Option<Vec3> },
}

/// A driver that is listened to.
struct Tapped {
    driver: ArmDriver,
    tap: rtrb::Producer<Passed>,
}

impl Driver for Tapped {
    fn take(&mut self, report: &[u8]) -> bool {
        let took = self.driver.take(report);
        if took {
            let position_mm = self.driver.seen().position_mm;
            let at_s = now_s();
            let _ = self.tap.push(Passed::Took { at_s, position_mm });
        }
        took
    }

    fn seen(&self) -> Seen {
        self.driver.seen()
    }

    fn render(&mut self, force_n: Option<Vec3>, out: &mut [u8; REPORT]) -> (usize, [i32; 3]) {
        let at_s = now_s();
        let _ = self.tap.push(Passed::Rendered { at_s, force_n });
        self.driver.render(force_n, out)
    }
}

/// One arm over one wire.
struct Case<'a> {
    program: &'a Path,
    folder: &'a Path,
    scene: &'a Scene,
    arms: &'static Arms,
    wire: Wire,
    seconds: f64,
}

impl Case<'_> {
    fn calibration(&self) -> Result<(Calibration, Arm), LabError> {
        let calibration = laid(self.scene, self.arms.defaults());
        let arm = calibration.arm.clone().ok_or_else(|| input("no arm"))?;
        Ok((calibration, arm))
    }

    fn turned(&self, watch: &mut Watch<'_>) -> Result<Turned, LabError> {
        let truth_file = self.folder.join("truth");
        let request = Request {
            wire: self.wire,
            seconds: self.seconds + 60.0,
            hand: Hand::Palpate { depth_mm: 8.0 },
            truth: Some(truth_file.clone()),
            ..Request::press(self.arms.key())
        };
        let (emulator, port) = Emulated::spawn(self.program, &request).map_err(input)?;
        let (calibration, arm) = self.calibration()?;
        let (tap, mut passed) = rtrb::RingBuffer::new(RING);
        let driver = Tapped {
            driver: ArmDriver::new(self.arms.protocol, arm, calibration.gravity),
            tap,
        };
        let can = self.arms.capabilities(&calibration);
        let linked = Linked::start(can, port, Box::new(driver), &calibration).map_err(input)?;
        let device = Mapped::new(linked, calibration.mapping);
        let vitals = device.vitals();
        let recording = self.folder.join("loop.mcap");
        let mut run = Run::start(self.scene, Box::new(device), Some(&recording))?;
        let mut turned = Turned {
            vitals,
            ..Turned::default()
        };
        let began = Instant::now();
        let mut told = 0;
        while began.elapsed().as_secs_f64() < self.seconds && !run.servo.has_ended() {
            std::thread::sleep(Duration::from_millis(2));
            turned.listen(&mut passed);
            let late = run.snapshot.read().timing.late_ticks;
            if late > turned.late_ticks {
                turned.late_ticks = late;
                turned.late_at_s.push(now_s());
            }
            let second = began.elapsed().as_secs();
            if second > told {
                told = second;
                let what = format!("{}, {}", self.arms.title(), self.wire.title());
                watch.at(&what, began.elapsed().as_secs_f64() / self.seconds)?;
            }
        }
        turned.ran_s = began.elapsed().as_secs_f64();
        drop(run.servo);
        turned.listen(&mut passed);
        turned.recorder_lost = run.recorder.stop().map_err(input)?.lost;
        let _ = std::fs::remove_file(&recording);
        turned.outcome = emulator.outcome().map_err(input)?;
        turned.truths = truth::read(&truth_file).map_err(input)?;
        // Behind the last command the device is on its own.
        let last_s = turned.rendered.last().map_or(0.0, |(at_s, _)| *at_s);
        turned.truths.retain(|t| t.at_s <= last_s);
        let _ = std::fs::remove_file(&truth_file);
        Ok(turned)
    }
}

/// What was heard on both sides.
#[derive(Default)]
struct Turned {
    ran_s: f64,
    took: Vec<(f64, Vec3)>,
    rendered: Vec<(f64, Option<Vec3>)>,
    late_ticks: u64,
    /// When late ticks were seen, s.
    late_at_s: Vec<f64>,
    recorder_lost: u64,
    vitals: Option<Arc<Vitals>>,
    outcome: Outcome,
    truths: Vec<Truth>,
}

/// Root mean square, 99th percentile and highest of a difference.
struct Off {
    rms: f64,
    p99: f64,
    most: f64,
}

impl Off {
    fn of(values: &Samples, sum_of_squares: f64) -> Self {
        Self {
            rms: (sum_of_squares / values.len() as f64).sqrt(),
            p99: values.quantile(0.99),
            most: values.quantile(1.0),
        }
    }

    fn collect(values: impl Iterator<Item = f64>) -> Self {
        let mut squares = 0.0;
        let samples: Samples = values.inspect(|x| squares += x * x).collect();
        Self::of(&samples, squares)
    }
}

impl Turned {
    fn listen(&mut self, passed: &mut rtrb::Consumer<Passed>) {
        while let Ok(one) = passed.pop() {
            match one {
                Passed::Took { at_s, position_mm } => self.took.push((at_s, position_mm)),
                Passed::Rendered { at_s, force_n } => self.rendered.push((at_s, force_n)),
            }
        }
    }

    /// The row that made each report, the first report first.
    fn by_report(&self) -> Vec<Truth> {
        let mut rows: Vec<Truth> = Vec::with_capacity(self.truths.len());
        for truth in &self.truths {
            let at = truth.report.saturating_sub(1) as usize;
            rows.truncate(at);
            if rows.len() == at {
                rows.push(*truth);
            }
        }
        rows
    }

    /// The force that command `heard`, counted by the board from 1, was to render, N, and when it was written. The first that
    /// the driver renders is the farewell, which is made before anything is written.
    fn command(&self, heard: u64) -> Option<(f64, Option<Vec3>)> {
        self.rendered.get(usize::try_from(heard).ok()?).copied()
    }

    /// Reports that the board made before the last that was taken, and that were not; what is under way counts as taken.
    fn lost(&self) -> u64 {
        let counted = self.vitals.as_ref().map_or(0, |v| v.counts().lost);
        let Some((last_s, _)) = self.took.last() else {
            return self.outcome.sent;
        };
        let made = self.truths.partition_point(|t| t.at_s <= *last_s);
        let made = self.truths[..made].last().map_or(0, |t| t.report);
        let missing = made.saturating_sub(self.took.len() as u64 + 1);
        counted.max(missing)
    }

    /// Each millisecond's force as the model feels it at the true place, N, and whether it was undisturbed.
    fn ideal(&self, case: &Case<'_>) -> Result<Vec<(Vec3, bool)>, LabError> {
        let (calibration, _) = case.calibration()?;
        let turn = calibration.mapping.subject_from_device();
        let limits = Limits::of(&case.arms.capabilities(&calibration));
        let touch = Box::new(case.scene.touch.clone());
        let mut rig = Rig::new(touch, [limits; MAX_FINGERS]);
        let (mut at, mut late, mut spoilt) = (0, 0, true);
        let mut out = Vec::with_capacity(self.truths.len());
        for truth in &self.truths {
            let mut tick_input = TickInput {
                n_fingers: 1,
                force_enabled: true,
                ..TickInput::default()
            };
            tick_input.readings[0] = Reading {
                position_mm: turn * truth.position_mm + calibration.mapping.offset_mm,
                connected: true,
                ..Reading::default()
            };
            let felt = tick(&mut rig, &tick_input, 1.0e-3).fingers[0].sent_force_n;
            let mut off = false;
            while let Some((at_s, force_n)) = self.rendered.get(at)
                && *at_s <= truth.at_s
            {
                off |= force_n.is_none();
                at += 1;
            }
            while let Some(late_s) = self.late_at_s.get(late)
                && late_s - SEEN_LATE_S <= truth.at_s
            {
                off = true;
                late += 1;
            }
            if felt.length() <= NONE_N {
                spoilt = false;
            }
            spoilt |= off;
            out.push((turn.transpose() * felt, !spoilt));
        }
        Ok(out)
    }

    fn tell(self, case: &Case<'_>, tables: &mut [Table; 3], report: &mut Report) {
        let [on_loop, on_position, on_force] = tables;
        let (device, wire) = (case.arms.title(), case.wire.title());
        let name = format!("{device}, {wire}");
        let step_mm = case.arms.capabilities(&case.arms.defaults()).resolution_mm;
        let by_report = self.by_report();
        let pairs = || self.took.iter().zip(&by_report);
        let place = Off::collect(pairs().map(|((_, p), t)| p.distance(t.position_mm)));
        on_position.push([
            device.into(),
            wire.into(),
            place.rms.into(),
            place.p99.into(),
            place.most.into(),
            step_mm.into(),
            (place.rms / step_mm).into(),
            (place.p99 / step_mm).into(),
            (place.most / step_mm).into(),
        ]);
        // The newest command of each millisecond; those that the board's own watchdog took off are no commands.
        let mut last = 0;
        let heard: Vec<(&Truth, f64, Vec3)> = self
            .truths
            .iter()
            .filter(|t| std::mem::replace(&mut last, t.heard) != t.heard)
            .filter_map(|t| {
                let (at_s, force_n) = self.command(t.heard)?;
                Some((t, at_s, force_n.unwrap_or(Vec3::ZERO)))
            })
            .collect();
        let rendering = Off::collect(heard.iter().map(|(t, _, f)| t.commanded_n.distance(*f)));
        let highest_n = self
            .truths
            .iter()
            .map(|t| t.flowing_n.length())
            .fold(0.0, f64::max);
        let mut force = |of: &str, off: &Off| {
            on_force.push([
                device.into(),
                wire.into(),
                of.into(),
                highest_n.into(),
                off.rms.into(),
                off.p99.into(),
                off.most.into(),
            ]);
        };
        force("rendering", &rendering);
        let ideal = self.ideal(case).unwrap_or_default();
        let errors = || {
            let flowing = self.truths.iter().map(|t| t.flowing_n);
            ideal
                .iter()
                .zip(flowing)
                .map(|((f, good), g)| (f.distance(g), *good))
        };
        let all = Off::collect(errors().map(|(e, _)| e));
        let good = Off::collect(errors().filter(|(_, good)| *good).map(|(e, _)| e));
        force("loop, undisturbed", &good);
        force("loop, all", &all);
        let disturbed = ideal.iter().filter(|(_, good)| !good).count();
        let lost = self.lost();
        let counts = self.vitals.as_ref().map(|v| v.counts()).unwrap_or_default();
        let under_way: Samples = pairs()
            .map(|((at_s, _), t)| (at_s - t.at_s) * 1e3)
            .collect();
        let back: Samples = heard
            .iter()
            .map(|(t, at_s, _)| (t.at_s - at_s) * 1e3)
            .collect();
        let answered = |share| {
            let us = self
                .vitals
                .as_ref()
                .and_then(|v| v.latency.quantile_us(share));
            us.map(|us| us / 1e3)
        };
        let rate_hz = counts.reports as f64 / self.ran_s;
        on_loop.push([
            device.into(),
            wire.into(),
            Value::from(counts.reports as usize),
            Value::from(lost as usize),
            Value::from((counts.not_understood + self.outcome.not_understood) as usize),
            rate_hz.into(),
            Value::from(self.late_ticks as usize),
            (100.0 * disturbed as f64 / ideal.len().max(1) as f64).into(),
            under_way.median().into(),
            under_way.quantile(0.99).into(),
            answered(0.5).into(),
            answered(0.99).into(),
            back.median().into(),
            back.quantile(0.99).into(),
        ]);
        let garbled = counts.not_understood + self.outcome.not_understood;
        for verdict in [
            Verdict::must(
                format!("{name}: lost"),
                format!(
                    "{lost} of {} reports, {garbled} garbled, {} ticks not recorded",
                    counts.reports, self.recorder_lost
                ),
                "none",
                lost == 0 && garbled == 0 && self.recorder_lost == 0 && counts.reports > 0,
            ),
            Verdict::must(
                format!("{name}: position"),
                format!("{:.2} encoder steps at most", place.most / step_mm),
                "1, half a count on each of three axes",
                place.most <= step_mm,
            ),
            Verdict::must(
                format!("{name}: force rendered"),
                format!("{:.4} N at most, up to {highest_n:.1} N", rendering.most),
                "0.05 N: half a milliampere on each motor, the turn of the arm within half a count and a millisecond",
                rendering.most <= 0.05,
            ),
            Verdict::told(
                format!("{name}: rate"),
                format!("{rate_hz:.0} reports a second"),
                "at least 950",
                rate_hz >= 950.0,
            ),
            Verdict::told(
                format!("{name}: force of the whole loop, undisturbed"),
                format!("{:.3} N rms, {:.3} N p99", good.rms, good.p99),
                "at most 0.1 N rms",
                good.rms <= 0.1,
            ),
        ] {
            report.verdicts.push(verdict);
        }
    }
}
