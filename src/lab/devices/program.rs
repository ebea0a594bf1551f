//! The program that presses a device and fails, or whose device fails: a process of its own, so that it can be stopped and
//! killed like one.

use super::input;
use super::press::{Run, laid, scene};
use crate::device::hid::emulator::process::{Wire, family};
use crate::device::hid::emulator::truth::now_s;
use crate::device::{Capabilities, Device, Family as _, Reading, Vitals};
use crate::geom::Vec3;
use crate::lab::LabError;
use crate::servo::halted;
use serde::{Deserialize, Serialize};
use std::io::Write as _;
use std::os::fd::AsFd as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// What the process is asked for.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Order {
    pub(super) family: String,
    pub(super) wire: Wire,
    pub(super) recording: PathBuf,
    /// What goes wrong in it.
    pub(super) trouble: Option<Trouble>,
    /// How long it goes on once it has pressed for a while, s.
    pub(super) after_s: f64,
    /// Longest that it waits for a press, s.
    pub(super) patience_s: f64,
}

/// What can go wrong in the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Trouble {
    /// Reading the device takes 50 ms.
    Stalls,
    /// Reading the device panics.
    Panics,
}

/// What it came to.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Told {
    /// Whether the device was pressed at all.
    pub(super) pressed: bool,
    /// When the trouble came, s of the clock of the truth.
    pub(super) trouble_at_s: Option<f64>,
    /// What the window would say, most pressing first.
    pub(super) said: Vec<String>,
    /// Ticks too late for force.
    pub(super) late_ticks: u64,
    /// Longest time between two ticks, ms.
    pub(super) longest_ms: f64,
    /// Ticks that the recorder lost.
    pub(super) lost_ticks: u64,
    /// Reports that the link knows to be lost.
    pub(super) lost_reports: u64,
}

/// What counts as pressed, N, and for how long, s: as the emulator has it.
const PRESSED_N: f64 = 1.0;
const PRESSED_S: f64 = 0.1;
/// How long a stalled read takes.
pub(super) const STALL: Duration = Duration::from_millis(50);
/// What it says when its device has been pressed for a while.
pub(super) const PRESSED: &str = "pressed";

/// A device whose driver fails while it is pressed.
struct Troubled<D> {
    device: D,
    trouble: Option<Trouble>,
    pressed_since: Option<Instant>,
    /// When it failed, bits of s; 0: not yet.
    failed_at: Arc<AtomicU64>,
}

impl<D: Device> Device for Troubled<D> {
    fn capabilities(&self) -> &Capabilities {
        self.device.capabilities()
    }

    fn read(&mut self, dt_s: f64) -> Reading {
        let due = self
            .pressed_since
            .is_some_and(|t| t.elapsed().as_secs_f64() >= PRESSED_S);
        if due && let Some(trouble) = self.trouble.take() {
            self.failed_at.store(now_s().to_bits(), Ordering::Release);
            match trouble {
                Trouble::Stalls => std::thread::sleep(STALL),
                Trouble::Panics => panic!("the device of this experiment panics"),
            }
        }
        self.device.read(dt_s)
    }

    fn write(&mut self, force_n: Vec3) {
        if force_n.length() < PRESSED_N {
            self.pressed_since = None;
        } else {
            self.pressed_since.get_or_insert_with(Instant::now);
        }
        self.device.write(force_n);
    }

    fn enable(&mut self, on: bool) {
        self.device.enable(on);
    }

    fn close(&mut self) {
        self.device.close();
    }

    fn vitals(&self) -> Option<Arc<Vitals>> {
        self.device.vitals()
    }
}

/// Presses the device on standard input as `order`, JSON, asks. Says `pressed` once it has been for a while, and at the end
/// what it came to, as JSON.
///
/// # Errors
/// The order is wrong, or something that the press needs is refused.
pub fn press_stdin(order: &str) -> Result<(), LabError> {
    let order: Order = serde_json::from_str(order).map_err(input)?;
    let arms = family(&order.family).map_err(input)?;
    let scene = scene()?;
    let fd = std::io::stdin().as_fd().try_clone_to_owned();
    let port = fd.and_then(|fd| order.wire.port(fd)).map_err(input)?;
    let device = arms
        .open_port(port, &laid(&scene, arms.defaults()))
        .map_err(input)?;
    let failed_at = Arc::new(AtomicU64::new(0));
    let device = Troubled {
        device,
        trouble: order.trouble,
        pressed_since: None,
        failed_at: Arc::clone(&failed_at),
    };
    let vitals = device.vitals();
    let mut run = Run::start(&scene, Box::new(device), Some(&order.recording))?;
    let mut told = Told::default();
    let began = Instant::now();
    let mut pressed: Option<Instant> = None;
    loop {
        std::thread::sleep(Duration::from_millis(1));
        let force_n = run.snapshot.read().record.fingers[0].sent_force_n.length();
        if !told.pressed {
            pressed = pressed
                .filter(|_| force_n >= PRESSED_N)
                .or_else(|| (force_n >= PRESSED_N).then(Instant::now));
        }
        let since_s = pressed.map_or(0.0, |t| t.elapsed().as_secs_f64());
        if since_s >= PRESSED_S && !told.pressed {
            told.pressed = true;
            say(PRESSED);
        }
        let over = told.pressed && since_s >= PRESSED_S + order.after_s;
        if over || began.elapsed().as_secs_f64() > order.patience_s || ended(&run) {
            break;
        }
    }
    let newest = *run.snapshot.read();
    told.said = said(&run, vitals.as_deref(), &newest);
    told.late_ticks = newest.timing.late_ticks;
    told.longest_ms = newest.timing.longest_period_us / 1e3;
    told.lost_reports = vitals.map_or(0, |v| v.counts().lost);
    let failed_at = f64::from_bits(failed_at.load(Ordering::Acquire));
    told.trouble_at_s = (failed_at > 0.0).then_some(failed_at);
    drop(run.servo);
    told.lost_ticks = run.recorder.stop().map_err(input)?.lost;
    say(&serde_json::to_string(&told).map_err(input)?);
    Ok(())
}

/// Whether there is nothing more to wait for: the servo has ended, or all force was.
fn ended(run: &Run) -> bool {
    run.servo.has_ended() || halted().is_some()
}

fn said(run: &Run, vitals: Option<&Vitals>, newest: &crate::servo::Snapshot) -> Vec<String> {
    use crate::device::hid::guard::Condition;
    let mut said = Vec::new();
    if let Some(halt) = halted() {
        said.push(halt.title().to_owned());
    }
    if let Some(fault) = run.servo.fault() {
        said.push(
            match fault {
                crate::servo::Fault::Hung => "the servo hangs",
                crate::servo::Fault::Panicked => "the servo's device panicked",
            }
            .to_owned(),
        );
    }
    if let Some(condition) = vitals.map(Vitals::condition)
        && condition != Condition::Good
    {
        said.push(condition.title().to_owned());
    }
    if newest.timing.late_ticks > 0 {
        let n = newest.timing.late_ticks;
        let ticks = if n == 1 { "tick" } else { "ticks" };
        said.push(format!("{n} {ticks} later than the watchdog allows"));
    }
    said
}

fn say(line: &str) {
    let mut out = std::io::stdout().lock();
    // Whoever listened may be gone; the press goes on.
    let _ = writeln!(out, "{line}").and_then(|()| out.flush());
}
