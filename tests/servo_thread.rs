//! The servo thread: its three lines, its devices, its faults.

use dorsum::contact::{Stiffness, TouchScene};
use dorsum::device::{Capabilities, Device, MAX_FINGERS, Reading, null::Null};
use dorsum::geom::Vec3;
use dorsum::partition::bvh::Bvh;
use dorsum::servo::{self, Command, Fault, Health, LimitFlags, Limits, Retired, Rig, ServoConfig};
use dorsum::surface::{RawMesh, Surface};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

fn scene() -> TouchScene {
    let raw = RawMesh {
        positions: vec![Vec3::ZERO, Vec3::X * 10.0, Vec3::Y * 10.0],
        triangles: vec![[0, 1, 2]],
    };
    let surface = Arc::new(Surface::new(raw).expect("a triangle").0);
    let search = Arc::new(Bvh::new(&surface));
    TouchScene::new(surface, search, Stiffness::Uniform(1.0))
}

fn rig() -> Rig {
    Rig::new(Box::new(scene()), [Limits::default(); MAX_FINGERS])
}

/// What happened to a [`Probe`].
#[derive(Default)]
struct Log {
    reads: AtomicU64,
    closed: AtomicBool,
    last_was_zero: AtomicBool,
    misbehave: AtomicBool,
}

/// A device that tells what is done to it, and misbehaves when asked.
struct Probe {
    capabilities: Capabilities,
    log: Arc<Log>,
    trouble: fn(),
}

impl Probe {
    fn with_log(trouble: fn()) -> (Box<dyn Device>, Arc<Log>) {
        let log = Arc::new(Log::default());
        let capabilities = Null::new(Vec3::ZERO).capabilities().clone();
        (
            Box::new(Self {
                capabilities,
                log: Arc::clone(&log),
                trouble,
            }),
            log,
        )
    }
}

impl Device for Probe {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self, _dt_s: f64) -> Reading {
        self.log.reads.fetch_add(1, Ordering::SeqCst);
        if self.log.misbehave.swap(false, Ordering::SeqCst) {
            (self.trouble)();
        }
        Reading {
            position_mm: Vec3::Z * 50.0,
            connected: true,
            ..Reading::default()
        }
    }

    fn write(&mut self, force_n: Vec3) {
        self.log
            .last_was_zero
            .store(force_n == Vec3::ZERO, Ordering::SeqCst);
    }

    fn close(&mut self) {
        self.write(Vec3::ZERO);
        self.log.closed.store(true, Ordering::SeqCst);
    }
}

fn within(bound: Duration, mut holds: impl FnMut() -> bool) -> bool {
    let started = Instant::now();
    while started.elapsed() < bound {
        if holds() {
            return true;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    holds()
}

const SOON: Duration = Duration::from_secs(10);

#[test]
fn every_tick_reaches_the_ring_in_order_and_the_newest_the_snapshot() {
    let (device, log) = Probe::with_log(|| {});
    let (servo, mut lines) =
        servo::start(ServoConfig::default(), rig(), vec![device]).expect("a thread");
    let mut records = Vec::new();
    assert!(within(SOON, || {
        while let Ok(record) = lines.records.pop() {
            records.push(record);
        }
        records.len() >= 100
    }));
    assert!(records.iter().enumerate().all(|(i, r)| r.tick == i as u64));
    assert!(records.windows(2).all(|w| w[1].time_ns > w[0].time_ns));
    assert!(lines.snapshot.read().record.fingers()[0].tick >= 99);
    drop(servo);
    assert!(log.closed.load(Ordering::SeqCst) && log.last_was_zero.load(Ordering::SeqCst));
    assert_eq!(lines.snapshot.read().health, Health::Stopped);
}

#[test]
fn a_full_ring_is_counted_and_loses_whole_ticks() {
    let config = ServoConfig {
        ring_records: 9,
        ..ServoConfig::default()
    };
    let devices: Vec<Box<dyn Device>> = vec![Probe::with_log(|| {}).0, Probe::with_log(|| {}).0];
    let (_servo, mut lines) = servo::start(config, rig(), devices).expect("a thread");
    assert!(within(SOON, || lines.snapshot.read().timing.lost_records >= 20));
    let mut held = Vec::new();
    while let Ok(record) = lines.records.pop() {
        held.push((record.tick, record.finger));
    }
    assert_eq!(
        held[..8],
        [
            (0, 0),
            (0, 1),
            (1, 0),
            (1, 1),
            (2, 0),
            (2, 1),
            (3, 0),
            (3, 1)
        ]
    );
}

#[test]
fn scenes_and_devices_are_swapped_and_come_back_to_be_freed() {
    let (first, first_log) = Probe::with_log(|| {});
    let (second, second_log) = Probe::with_log(|| {});
    let (_servo, mut lines) =
        servo::start(ServoConfig::default(), rig(), vec![first]).expect("a thread");
    assert!(
        lines
            .commands
            .push(Command::SetScene(Box::new(scene())))
            .is_ok()
    );
    assert!(lines.commands.push(Command::SetDevice(0, second)).is_ok());
    let mut back = Vec::new();
    assert!(within(SOON, || {
        while let Ok(retired) = lines.retired.pop() {
            back.push(matches!(retired, Retired::Scene(_)));
            // Closing may wait: the servo leaves it to whoever takes the device back.
            if let Retired::Device(mut device) = retired {
                assert!(!first_log.closed.load(Ordering::SeqCst));
                device.close();
            }
        }
        back.len() == 2
    }));
    assert_eq!(back, [true, false]);
    assert!(first_log.closed.load(Ordering::SeqCst));
    assert!(within(SOON, || second_log.reads.load(Ordering::SeqCst) > 3));
    assert_eq!(lines.snapshot.read().scene_generation, 1);
    assert!(within(SOON, || {
        std::iter::from_fn(|| lines.records.pop().ok()).any(|r| r.placed_anew)
    }));
}

#[test]
fn switching_the_force_off_says_so_in_the_records() {
    let (device, _log) = Probe::with_log(|| {});
    let (_servo, mut lines) =
        servo::start(ServoConfig::default(), rig(), vec![device]).expect("a thread");
    assert!(lines.commands.push(Command::EnableForce(false)).is_ok());
    assert!(within(SOON, || {
        let snapshot = lines.snapshot.read();
        snapshot.record.n_fingers == 1
            && !snapshot.force_enabled
            && snapshot.record.fingers()[0]
                .limits
                .has(LimitFlags::DISABLED)
    }));
}

#[test]
fn a_stall_makes_one_late_tick_with_zero_force_and_no_burst_after_it() {
    let (device, log) = Probe::with_log(|| std::thread::sleep(Duration::from_millis(60)));
    let (_servo, mut lines) =
        servo::start(ServoConfig::default(), rig(), vec![device]).expect("a thread");
    assert!(within(SOON, || log.reads.load(Ordering::SeqCst) > 20));
    log.misbehave.store(true, Ordering::SeqCst);
    let mut records = Vec::new();
    assert!(within(SOON, || {
        while let Ok(record) = lines.records.pop() {
            records.push(record);
        }
        records
            .iter()
            .rposition(|r| r.duration_us > 50_000.0)
            .is_some_and(|i| i + 30 < records.len())
    }));
    let stalled = records
        .iter()
        .position(|r| r.duration_us > 50_000.0)
        .expect("a stall");
    let after = &records[stalled + 1];
    assert!(after.late && after.limits.has(LimitFlags::LATE) && after.sent_force_n == Vec3::ZERO);
    // 60 missed ticks made up in a burst would show as dozens of ticks within a few milliseconds.
    let thirty_ticks_ms = (records[stalled + 30].time_ns - after.time_ns) as f64 / 1.0e6;
    assert!(thirty_ticks_ms > 20.0, "30 ticks in {thirty_ticks_ms} ms");
}

#[test]
fn a_panicking_device_is_closed_and_told() {
    let (device, log) = Probe::with_log(|| panic!("a device fault made for this test"));
    let (servo, mut lines) =
        servo::start(ServoConfig::default(), rig(), vec![device]).expect("a thread");
    assert!(within(SOON, || log.reads.load(Ordering::SeqCst) > 5));
    log.misbehave.store(true, Ordering::SeqCst);
    assert!(within(SOON, || servo.has_ended()));
    assert_eq!(servo.fault(), Some(Fault::Panicked));
    assert!(log.closed.load(Ordering::SeqCst) && log.last_was_zero.load(Ordering::SeqCst));
    assert_eq!(lines.snapshot.read().health, Health::Fault);
}

#[test]
fn a_hanging_device_is_told_and_recovers() {
    let (device, log) = Probe::with_log(|| std::thread::sleep(servo::HANG_BOUND * 4));
    let (servo, _lines) =
        servo::start(ServoConfig::default(), rig(), vec![device]).expect("a thread");
    assert!(within(SOON, || log.reads.load(Ordering::SeqCst) > 5));
    log.misbehave.store(true, Ordering::SeqCst);
    assert!(within(SOON, || servo.fault() == Some(Fault::Hung)));
    assert!(within(SOON, || servo.fault().is_none()));
}
