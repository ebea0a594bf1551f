//! The thread that calls the tick, and the loop that does without one.

use super::halt::{Running, halted};
use super::limiter::Limits;
use super::record::{FingerRecord, TickInput, TickRecord};
use super::tick::{Rig, tick};
use super::timing::{Health, TimingStats};
use crate::contact::TouchScene;
use crate::device::{Device, MAX_FINGERS};
use crate::geom::Vec3;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Newest state outward: everything the window shows of the live servo, in physical units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snapshot {
    /// The last tick.
    pub record: TickRecord,
    /// Timing since the start.
    pub timing: TimingStats,
    /// Whether the servo runs as it should.
    pub health: Health,
    /// Whether force output is switched on.
    pub force_enabled: bool,
    /// Counts the scenes handed in, so that the window knows which one a record belongs to.
    pub scene_generation: u64,
    /// Number of the newest edit of the scene; 0 before the first.
    pub edit: u32,
    /// Share of that edit that is felt, 0 … 1. The next edit can begin when it is 1.
    pub fade: f64,
}

impl Default for Snapshot {
    /// Nothing felt yet, in a scene that was never edited.
    fn default() -> Self {
        Self {
            record: TickRecord::default(),
            timing: TimingStats::default(),
            health: Health::default(),
            force_enabled: false,
            scene_generation: 0,
            edit: 0,
            fade: 1.0,
        }
    }
}

/// Inward: what the window asks of the servo.
pub enum Command {
    /// Feel another scene. The old one comes back through [`Lines::retired`] to be freed outside. Proxies are placed anew.
    SetScene(Box<TouchScene>),
    /// Go over to an edit of the scene, which has the same surface: contacts and devices stay, the force does not jump
    /// ([`Rig::edit_scene`]). The old scene comes back through [`Lines::retired`]. To be sent when the edit before it is wholly
    /// felt ([`Snapshot::fade`]); one that comes earlier is handed back unfelt.
    EditScene {
        /// Number of the edit, one more than that of the edit before.
        number: u32,
        /// The scene as edited.
        scene: Box<TouchScene>,
    },
    /// Use another device for a finger; the old one is sent zero force, switched off and comes back through
    /// [`Lines::retired`]: closing may wait for its thread. Ignored (and handed back) for a finger that there is not.
    SetDevice(usize, Box<dyn Device>),
    /// Bound the force on a finger otherwise; ignored for a finger that there is not. Not while its ticks are recorded: a
    /// recording says at its beginning what bounds it has.
    SetLimits(usize, Limits),
    /// Switch force output on or off (emergency stop): the tick sends zero, and every device is told ([`Device::enable`]).
    EnableForce(bool),
    /// Start the timing statistics anew.
    ResetTiming,
}

/// Something the servo is done with, to be freed outside.
pub enum Retired {
    /// A scene.
    Scene(Box<TouchScene>),
    /// A device, switched off, to be closed.
    Device(Box<dyn Device>),
}

/// How the thread runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoConfig {
    /// Ticks per second; brought within 100 to 10,000.
    pub rate_hz: f64,
    /// A tick that starts later than this after its due time sends no force, ms.
    pub late_bound_ms: f64,
    /// Records the ring holds.
    pub ring_records: usize,
    /// Whether force output is on from the start.
    pub force_enabled: bool,
}

impl Default for ServoConfig {
    fn default() -> Self {
        Self {
            rate_hz: 1000.0,
            late_bound_ms: 5.0,
            ring_records: 16 * 1024,
            force_enabled: true,
        }
    }
}

impl ServoConfig {
    /// Memory of the ring, bytes.
    pub fn ring_bytes(&self) -> usize {
        self.ring_records.max(MAX_FINGERS) * size_of::<FingerRecord>()
    }

    /// Nominal time step, s.
    pub fn dt_s(&self) -> f64 {
        1.0 / if self.rate_hz.is_finite() {
            self.rate_hz.clamp(100.0, 10_000.0)
        } else {
            1000.0
        }
    }
}

/// The outside ends of the three lines.
pub struct Lines {
    /// Newest state.
    pub snapshot: triple_buffer::Output<Snapshot>,
    /// Every tick of every finger.
    pub records: rtrb::Consumer<FingerRecord>,
    /// What is to be freed.
    pub retired: rtrb::Consumer<Retired>,
    /// Commands inward.
    pub commands: rtrb::Producer<Command>,
}

/// Why a servo no longer serves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// No tick for [`HANG_BOUND`]: a device call does not return.
    Hung,
    /// A device panicked. Its force was zeroed and it was closed.
    Panicked,
}

/// A servo without a tick for this long counts as hung.
pub const HANG_BOUND: Duration = Duration::from_millis(250);

/// The running servo; it ends by itself when everything is [halted](super::halt()). Dropping it zeroes the force, closes the devices and joins the thread; a hung thread is left behind.
#[derive(Debug)]
pub struct Servo {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    watchdog: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Shared {
    stop: AtomicBool,
    ended: AtomicBool,
    panicked: AtomicBool,
    hung: AtomicBool,
    ticks: AtomicU64,
}

impl Servo {
    /// What is wrong with it, if anything.
    pub fn fault(&self) -> Option<Fault> {
        if self.shared.panicked.load(Ordering::Acquire) {
            Some(Fault::Panicked)
        } else if self.shared.hung.load(Ordering::Acquire) {
            Some(Fault::Hung)
        } else {
            None
        }
    }

    /// Whether the thread has ended, by itself or by a panic.
    pub fn has_ended(&self) -> bool {
        self.shared.ended.load(Ordering::Acquire)
    }
}

impl Drop for Servo {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Release);
        if let Some(watchdog) = self.watchdog.take() {
            watchdog.thread().unpark();
            drop(watchdog.join());
        }
        if let Some(thread) = self.thread.take()
            && !self.shared.hung.load(Ordering::Acquire)
        {
            drop(thread.join());
        }
    }
}

/// Devices that are closed, force zeroed, however their owner goes: at the end, by a swap, by a panic.
struct Devices(Vec<Box<dyn Device>>);

impl Devices {
    fn enable(&mut self, on: bool) {
        for device in &mut self.0 {
            device.enable(on);
        }
    }

    fn read(&mut self, dt_s: f64) -> TickInput {
        let mut input = TickInput {
            n_fingers: self.0.len(),
            ..TickInput::default()
        };
        for (device, reading) in self.0.iter_mut().zip(&mut input.readings) {
            *reading = device.read(dt_s);
        }
        input
    }

    fn write(&mut self, out: &TickRecord) {
        for (device, record) in self.0.iter_mut().zip(out.fingers()) {
            device.write(record.sent_force_n);
        }
    }
}

impl Drop for Devices {
    fn drop(&mut self) {
        for device in &mut self.0 {
            // One device that panics on closing must not keep the others from being closed.
            let _ = catch_unwind(AssertUnwindSafe(|| {
                device.enable(false);
                device.close();
            }));
        }
    }
}

/// Runs ticks one after the other as fast as they go, on the calling thread, until `each` answers `false` or everything is
/// [halted](super::halt()).
///
/// The same tick and the same order of calls as the live servo: what a scripted device feels here it feels there.
pub fn run_offline(
    rig: &mut Rig,
    devices: Vec<Box<dyn Device>>,
    dt_s: f64,
    mut each: impl FnMut(&TickRecord) -> bool,
) {
    let mut devices = Devices(devices);
    devices.0.truncate(MAX_FINGERS);
    let _running = Running::new();
    devices.enable(true);
    while halted().is_none() {
        let mut input = devices.read(dt_s);
        input.force_enabled = true;
        let out = tick(rig, &input, dt_s);
        devices.write(&out);
        if !each(&out) {
            return;
        }
    }
}

/// Starts the servo thread on `rig` with one device per finger; devices past [`MAX_FINGERS`] are closed unused.
///
/// # Errors
/// When the system refuses another thread.
pub fn start(
    config: ServoConfig,
    rig: Rig,
    devices: Vec<Box<dyn Device>>,
) -> std::io::Result<(Servo, Lines)> {
    let (snapshot_in, snapshot) = triple_buffer::triple_buffer(&Snapshot::default());
    let (records_in, records) = rtrb::RingBuffer::new(config.ring_records.max(MAX_FINGERS));
    let (retired_in, retired) = rtrb::RingBuffer::new(64);
    let (commands, commands_out) = rtrb::RingBuffer::new(64);
    let shared = Arc::new(Shared::default());
    let mut devices = Devices(devices);
    devices.0.truncate(MAX_FINGERS);
    let mut servo = Loop {
        config,
        rig,
        devices,
        snapshot: snapshot_in,
        records: records_in,
        retired: retired_in,
        commands: commands_out,
        state: Snapshot {
            force_enabled: config.force_enabled,
            ..Snapshot::default()
        },
        last_late: None,
        place_anew: [false; MAX_FINGERS],
        _running: Running::new(),
    };
    let in_thread = Arc::clone(&shared);
    let thread = std::thread::Builder::new()
        .name("servo".into())
        .spawn(move || {
            // Granted only to privileged users on most systems; without it the thread runs at normal priority.
            let _ =
                thread_priority::set_current_thread_priority(thread_priority::ThreadPriority::Max);
            let outcome = catch_unwind(AssertUnwindSafe(|| servo.run(&in_thread)));
            if outcome.is_err() {
                in_thread.panicked.store(true, Ordering::Release);
                servo.state.health = Health::Fault;
            } else {
                servo.state.health = Health::Stopped;
            }
            servo.state.record = TickRecord::default();
            servo.snapshot.write(servo.state);
            drop(servo);
            in_thread.ended.store(true, Ordering::Release);
        })?;
    let in_watchdog = Arc::clone(&shared);
    let watchdog = std::thread::Builder::new()
        .name("servo watchdog".into())
        .spawn(move || watch(&in_watchdog))?;
    let servo = Servo {
        shared,
        thread: Some(thread),
        watchdog: Some(watchdog),
    };
    Ok((
        servo,
        Lines {
            snapshot,
            records,
            retired,
            commands,
        },
    ))
}

/// Marks the servo hung while its tick count stands still.
fn watch(shared: &Shared) {
    let mut seen = (shared.ticks.load(Ordering::Acquire), Instant::now());
    while !shared.stop.load(Ordering::Acquire) && !shared.ended.load(Ordering::Acquire) {
        std::thread::park_timeout(HANG_BOUND / 5);
        let ticks = shared.ticks.load(Ordering::Acquire);
        if ticks != seen.0 {
            seen = (ticks, Instant::now());
        }
        shared
            .hung
            .store(seen.1.elapsed() > HANG_BOUND, Ordering::Release);
    }
}

/// Everything the servo thread owns.
struct Loop {
    config: ServoConfig,
    rig: Rig,
    devices: Devices,
    snapshot: triple_buffer::Input<Snapshot>,
    records: rtrb::Producer<FingerRecord>,
    retired: rtrb::Producer<Retired>,
    commands: rtrb::Consumer<Command>,
    state: Snapshot,
    last_late: Option<Instant>,
    place_anew: [bool; MAX_FINGERS],
    _running: Running,
}

impl Loop {
    fn run(&mut self, shared: &Shared) {
        self.devices.enable(self.state.force_enabled);
        let dt_s = self.config.dt_s();
        let period = Duration::from_secs_f64(dt_s);
        let late_bound =
            Duration::from_secs_f64(self.config.late_bound_ms.clamp(0.1, 1000.0) / 1000.0);
        let started = Instant::now();
        let mut due = started;
        let mut last_start: Option<Instant> = None;
        while !shared.stop.load(Ordering::Acquire) && halted().is_none() {
            let now = Instant::now();
            if now < due {
                std::thread::sleep(due - now);
            }
            // It may have come while this slept: then no other tick is sent.
            if halted().is_some() {
                return;
            }
            let start = Instant::now();
            let late = start.saturating_duration_since(due) > late_bound;
            self.obey();
            let out = self.step(dt_s, late, start - started);
            let duration_us = start.elapsed().as_secs_f64() * 1.0e6;
            let period_us = last_start.map(|t| (start - t).as_secs_f64() * 1.0e6);
            self.publish(out, period_us, duration_us, late, start);
            last_start = Some(start);
            shared.ticks.fetch_add(1, Ordering::AcqRel);
            // Ticks missed are gone: running them in a burst would give the hand its past instead of its present.
            due = (due + period).max(start);
        }
    }

    fn step(&mut self, dt_s: f64, late: bool, since_start: Duration) -> TickRecord {
        let mut input = self.devices.read(dt_s);
        input.place_anew = std::mem::take(&mut self.place_anew);
        input.late = late;
        input.force_enabled = self.state.force_enabled;
        let mut out = tick(&mut self.rig, &input, dt_s);
        self.devices.write(&out);
        for record in &mut out.fingers[..out.n_fingers] {
            record.time_ns = since_start.as_nanos() as u64;
        }
        out
    }

    fn publish(
        &mut self,
        mut out: TickRecord,
        period_us: Option<f64>,
        duration_us: f64,
        late: bool,
        now: Instant,
    ) {
        for record in &mut out.fingers[..out.n_fingers] {
            record.duration_us = duration_us as f32;
        }
        // All fingers of a tick or none: a record must be a restart point for the whole rig.
        if self.records.slots() >= out.n_fingers {
            for record in out.fingers() {
                let _ = self.records.push(*record);
            }
        } else {
            self.state.timing.lost_records += out.n_fingers as u64;
        }
        self.state.timing.count(period_us, duration_us, late);
        if late {
            self.last_late = Some(now);
        }
        let lately = self
            .last_late
            .is_some_and(|t| now.duration_since(t) < Duration::from_secs(1));
        self.state.health = if out.fingers().iter().any(|f| !f.reading.is_usable()) {
            Health::Fault
        } else if lately {
            Health::Late
        } else {
            Health::Good
        };
        self.state.record = out;
        (self.state.edit, self.state.fade) = (self.rig.edit, self.rig.scene.share());
        self.snapshot.write(self.state);
    }

    /// Carries out what the window asked, as far as there is room to hand back what becomes free.
    fn obey(&mut self) {
        while self.retired.slots() > 0 {
            let Ok(command) = self.commands.pop() else {
                return;
            };
            match command {
                Command::SetScene(scene) => {
                    let old = std::mem::replace(&mut self.rig.scene, scene);
                    self.place_anew = [true; MAX_FINGERS];
                    self.state.scene_generation += 1;
                    let _ = self.retired.push(Retired::Scene(old));
                }
                Command::EditScene { number, scene } => {
                    let back = if self.rig.is_fading() {
                        scene
                    } else {
                        self.rig.edit_scene(number, scene)
                    };
                    let _ = self.retired.push(Retired::Scene(back));
                }
                Command::SetDevice(finger, mut device) => {
                    if let Some(slot) = self.devices.0.get_mut(finger) {
                        device.enable(self.state.force_enabled);
                        std::mem::swap(slot, &mut device);
                        device.enable(false);
                        device.write(Vec3::ZERO);
                        self.place_anew[finger] = true;
                    }
                    let _ = self.retired.push(Retired::Device(device));
                }
                Command::SetLimits(finger, limits) => {
                    if let Some(slot) = self.rig.limits.get_mut(finger) {
                        *slot = limits;
                    }
                }
                Command::EnableForce(on) => {
                    // Off is said again: whoever presses the emergency stop twice means it.
                    if on != self.state.force_enabled || !on {
                        self.devices.enable(on);
                    }
                    self.state.force_enabled = on;
                }
                Command::ResetTiming => self.state.timing = TimingStats::default(),
            }
        }
    }
}
