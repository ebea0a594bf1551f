//! The thread beside the servo that speaks with one device.
//!
//! ```text
//! servo ── newest force (triple buffer) ──► link ── report ──► device
//!       ◄── newest reading (triple buffer) ──      ◄── report ──
//! ```
//!
//! The servo never waits for the wire, and the wire never for the servo: each takes the newest the other has left. Force
//! flows only while it is switched on, the guard finds the device good and the servo has given a force lately ([`Output`]);
//! everything else is zero.

use super::guard::{Condition, Guard, Sighting};
use super::output::{Asked, Output};
use super::transport::{Gone, Port, REPORT};
use super::velocity::{Clock, Window};
use super::vitals::Vitals;
use crate::device::Calibration;
use crate::device::{Capabilities, Device, DeviceError, Reading};
use crate::geom::Vec3;
use crate::units::MS_PER_S;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Where a device is, as its last report says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Its place, mm, in its own frame; for a device without one its deflection, −1 to 1.
    pub position_mm: Vec3,
    /// Pressed buttons, bit by bit.
    pub buttons: u32,
    /// Encoders or deflections as they came.
    pub raw: [i32; 6],
    /// Its counter, if it has one.
    pub counter: Option<u16>,
}

/// What a protocol and the mechanics behind it come to: no clock, no wire.
pub trait Driver: Send {
    /// Takes a report; whether it was one.
    fn take(&mut self, report: &[u8]) -> bool;

    /// What was heard last.
    fn seen(&self) -> Seen;

    /// Writes the report that renders a force, N, in the device's frame; `None`: no current at all, whatever else the motors
    /// would do. How many bytes, 0 for a device that takes none, and the currents, mA.
    fn render(&mut self, force_n: Option<Vec3>, out: &mut [u8; REPORT]) -> (usize, [i32; 3]);

    /// How much of what the motors do besides rendering is wanted from now on, 0 … 1: gravity compensation.
    fn hold(&mut self, _share: f64) {}

    /// Writes what is said on opening (`true`) and on closing; how many bytes, 0 for nothing.
    fn greet(&mut self, _opening: bool, _out: &mut [u8; REPORT]) -> usize {
        0
    }

    /// Whether it reports all the time, so that silence means trouble.
    fn is_periodic(&self) -> bool {
        true
    }
}

/// How often zero is sent at the end: reports get lost.
const FAREWELLS: usize = 5;
/// Most reports taken before the link looks at the servo again.
const MOST_AT_ONCE: u64 = 256;
/// Longest that closing waits for the thread: one whose write does not return is left behind.
const CLOSING: Duration = Duration::from_millis(100);

#[derive(Clone, Copy, Debug, Default)]
struct Heard {
    /// Counts readings; 0 before the first.
    number: u64,
    time_s: f64,
    reading: Reading,
}

#[derive(Clone, Copy, Debug, Default)]
struct Order {
    /// Counts orders; 0 before the first.
    number: u64,
    time_s: f64,
    /// The reading that it answers.
    answers: u64,
    /// Force output is switched on.
    on: bool,
    force_n: Vec3,
}

#[derive(Debug)]
struct Shared {
    vitals: Arc<Vitals>,
    stop: AtomicBool,
    ended: AtomicBool,
    started: Instant,
}

impl Shared {
    fn now_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}

/// A device spoken with by a link. Neither reading nor writing waits, allocates or locks.
#[derive(Debug)]
pub struct Linked {
    capabilities: Capabilities,
    heard: triple_buffer::Output<Heard>,
    orders: triple_buffer::Input<Order>,
    order: Order,
    silence_s: f64,
    periodic: bool,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Linked {
    /// Speaks with the device at `port` through `driver` on a thread of its own. Its force is off until it is switched on
    /// ([`Device::enable`]).
    ///
    /// # Errors
    /// The system refuses another thread.
    pub fn start(
        capabilities: Capabilities,
        port: Box<dyn Port>,
        driver: Box<dyn Driver>,
        calibration: &Calibration,
    ) -> Result<Self, DeviceError> {
        let guards = calibration.guards;
        let damping = calibration.mechanics.virtual_damping_n_s_per_mm;
        let (heard_in, heard) = triple_buffer::triple_buffer(&Heard::default());
        let (orders, orders_out) = triple_buffer::triple_buffer(&Order::default());
        let shared = Arc::new(Shared {
            vitals: Arc::default(),
            stop: AtomicBool::new(false),
            ended: AtomicBool::new(false),
            started: Instant::now(),
        });
        let periodic = driver.is_periodic();
        let rated_force_n = capabilities.rated_force_n;
        let talk = Talk {
            port,
            driver,
            guard: Guard::new(guards, rated_force_n, periodic),
            window: Window::new(capabilities.resolution_mm),
            clock: Clock::new(capabilities.report_rate_hz),
            heard: heard_in,
            orders: orders_out,
            output: Output::new(rated_force_n, guards.command_timeout_ms / MS_PER_S, damping),
            on: false,
            last: Heard::default(),
            last_counter: None,
            answered: 0,
            sent_n: Vec3::ZERO,
            zero: ([0; REPORT], 0),
        };
        let in_thread = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("device link".into())
            .spawn(move || talk.live(&in_thread))
            .map_err(|e| DeviceError::new(format!("no thread for the device: {e}")))?;
        Ok(Self {
            capabilities,
            heard,
            orders,
            order: Order::default(),
            silence_s: guards.silence_ms / MS_PER_S,
            periodic,
            shared,
            thread: Some(thread),
        })
    }

    /// What it tells about itself.
    pub fn vitals(&self) -> Arc<Vitals> {
        Arc::clone(&self.shared.vitals)
    }
}

impl Device for Linked {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self, _dt_s: f64) -> Reading {
        let heard = *self.heard.read();
        let mut reading = heard.reading;
        // Also when the link itself hangs, in a write that does not return.
        let stale = self.periodic && self.shared.now_s() - heard.time_s > 2.0 * self.silence_s;
        if stale || self.shared.ended.load(Ordering::Acquire) {
            reading.connected = false;
        }
        if !reading.connected {
            reading.velocity_mm_s = Vec3::ZERO;
        }
        self.order.answers = heard.number;
        reading
    }

    fn write(&mut self, force_n: Vec3) {
        self.order = Order {
            number: self.order.number + 1,
            time_s: self.shared.now_s(),
            force_n,
            ..self.order
        };
        self.orders.write(self.order);
    }

    fn enable(&mut self, on: bool) {
        self.order.on = on;
        self.write(Vec3::ZERO);
    }

    fn close(&mut self) {
        self.enable(false);
        self.shared.stop.store(true, Ordering::Release);
        let until = Instant::now() + CLOSING;
        while !self.shared.ended.load(Ordering::Acquire) && Instant::now() < until {
            std::thread::sleep(Duration::from_micros(200));
        }
        if let Some(thread) = self.thread.take()
            && self.shared.ended.load(Ordering::Acquire)
        {
            drop(thread.join());
        }
    }

    fn vitals(&self) -> Option<Arc<Vitals>> {
        Some(Self::vitals(self))
    }
}

impl Drop for Linked {
    fn drop(&mut self) {
        if self.thread.is_some() {
            self.close();
        }
    }
}

/// Everything the link's thread owns.
struct Talk {
    port: Box<dyn Port>,
    driver: Box<dyn Driver>,
    guard: Guard,
    window: Window,
    clock: Clock,
    heard: triple_buffer::Input<Heard>,
    orders: triple_buffer::Output<Order>,
    output: Output,
    /// Whether the device was told that force is on.
    on: bool,
    last: Heard,
    last_counter: Option<u16>,
    /// Newest reading whose answer was timed.
    answered: u64,
    sent_n: Vec3,
    /// The report of no current and its length, made before anything can go wrong.
    zero: ([u8; REPORT], usize),
}

impl Talk {
    fn live(mut self, shared: &Shared) {
        // Granted only to privileged users on most systems; without it the thread runs at normal priority.
        let _ = thread_priority::set_current_thread_priority(thread_priority::ThreadPriority::Max);
        let outcome = catch_unwind(AssertUnwindSafe(|| self.run(shared)));
        self.guard.end(match outcome {
            Ok(Ok(())) => Condition::Closed,
            Ok(Err(Gone)) => Condition::Unplugged,
            Err(_) => Condition::Ended,
        });
        let _ = catch_unwind(AssertUnwindSafe(|| self.part()));
        self.publish(shared);
        shared.ended.store(true, Ordering::Release);
    }

    fn run(&mut self, shared: &Shared) -> Result<(), Gone> {
        let mut out = [0; REPORT];
        self.zero.1 = self.driver.render(None, &mut self.zero.0).0;
        let n = self.driver.greet(true, &mut out);
        if n > 0 {
            self.port.write(&out[..n])?;
        }
        while !shared.stop.load(Ordering::Acquire) {
            let came = self.listen(shared)?;
            if shared.vitals.take_release() {
                self.guard.release();
                self.window.clear();
            }
            let before = self.guard.condition();
            self.guard.look(shared.now_s());
            if came || self.guard.condition() != before {
                self.publish(shared);
            }
            self.speak(shared, &mut out)?;
        }
        Ok(())
    }

    /// Takes all reports that are there, waiting a millisecond for the first; whether one was understood.
    fn listen(&mut self, shared: &Shared) -> Result<bool, Gone> {
        let mut into = [0; REPORT];
        let (mut understood, mut other) = (0, 0);
        let mut wait_ms = 1;
        while understood + other < MOST_AT_ONCE {
            let n = self.port.read(&mut into, wait_ms)?;
            if n == 0 {
                break;
            }
            wait_ms = 0;
            if self.driver.take(&into[..n.min(REPORT)]) {
                understood += 1;
            } else {
                other += 1;
            }
        }
        if understood + other > 0 {
            shared.vitals.count_reports(understood, other);
        }
        if understood == 0 {
            return Ok(false);
        }
        let (now_s, seen) = (shared.now_s(), self.driver.seen());
        if let (Some(counter), Some(last)) = (seen.counter, self.last_counter) {
            let sent = u64::from(counter.wrapping_sub(last));
            // More than the counter can tell apart is another device, not a loss.
            if sent < 0x8000 {
                shared.vitals.count_lost(sent.saturating_sub(understood));
            }
        }
        self.last_counter = seen.counter;
        if self.last.number > 0 {
            let interval_s = (now_s - self.last.time_s).max(0.0);
            shared
                .vitals
                .count_interval(Duration::from_secs_f64(interval_s));
        }
        if !self.guard.may_push() {
            self.window.clear();
        }
        let left_s = self.clock.left_s(now_s, understood);
        let velocity_mm_s = self.window.take(left_s, seen.position_mm);
        self.guard.hear(Sighting {
            time_s: now_s,
            position_mm: seen.position_mm,
            velocity_mm_s,
            raw: seen.raw,
            counter: seen.counter,
            force_n: self.sent_n,
        });
        shared.vitals.show_raw(seen.raw);
        self.last.number += 1;
        self.last.time_s = now_s;
        self.last.reading = Reading {
            position_mm: seen.position_mm,
            velocity_mm_s,
            buttons: seen.buttons,
            connected: false,
        };
        Ok(true)
    }

    fn publish(&mut self, shared: &Shared) {
        self.last.reading.connected = self.guard.may_push();
        shared.vitals.set_condition(self.guard.condition());
        self.heard.write(self.last);
    }

    fn speak(&mut self, shared: &Shared, out: &mut [u8; REPORT]) -> Result<(), Gone> {
        let order = *self.orders.read();
        let now_s = shared.now_s();
        let asked = Asked {
            on: order.on,
            age_s: if order.number > 0 {
                now_s - order.time_s
            } else {
                f64::INFINITY
            },
            force_n: order.force_n,
        };
        let velocity_mm_s = self.last.reading.velocity_mm_s;
        let sent = (self.output).at(now_s, &asked, self.guard.may_push(), velocity_mm_s);
        self.driver.hold(sent.map_or(0.0, |s| s.share));
        let (n, current_ma) = self.driver.render(sent.map(|s| s.force_n), out);
        self.sent_n = sent.map_or(Vec3::ZERO, |s| s.force_n);
        // On before the first force, off after the last.
        if order.on && !self.on {
            self.port.enable(true)?;
        }
        if n > 0 {
            self.port.write(&out[..n])?;
        }
        if self.on && !order.on {
            self.port.enable(false)?;
        }
        self.on = order.on;
        if n == 0 {
            return Ok(());
        }
        shared.vitals.count_written(current_ma);
        if order.answers > self.answered {
            self.answered = order.answers;
            // Only the newest reading's arrival is known.
            if order.answers == self.last.number {
                let latency_s = (shared.now_s() - self.last.time_s).max(0.0);
                shared
                    .vitals
                    .count_latency(Duration::from_secs_f64(latency_s));
            }
        }
        Ok(())
    }

    /// No current, several times, and good-bye.
    fn part(&mut self) {
        for _ in 0..FAREWELLS {
            if self.zero.1 == 0 || self.port.write(&self.zero.0[..self.zero.1]).is_err() {
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        let mut out = [0; REPORT];
        let n = self.driver.greet(false, &mut out);
        if n > 0 {
            let _ = self.port.write(&out[..n]);
        }
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests;
