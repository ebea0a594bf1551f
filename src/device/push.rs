//! A force test: a device pushes along one axis, slowly up, a while, and down again.

use super::hid::vitals::Vitals;
use super::place::Place;
use super::{Capabilities, Device, Reading};
use crate::geom::Vec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Time in which the force rises, s.
pub const RISE_S: f64 = 3.0;
/// Time for which it stays, s.
pub const HOLD_S: f64 = 2.0;
/// Time in which it falls, s.
pub const FALL_S: f64 = 1.0;
/// Share of the force that a device holds without end which a test may reach.
pub const MOST_SHARE: f64 = 0.5;

/// Share of the test's force `time_s` after its start, 0 … 1; 0 before and after.
pub fn level(time_s: f64) -> f64 {
    if !time_s.is_finite() {
        return 0.0;
    }
    let falls_s = RISE_S + HOLD_S;
    if time_s < falls_s {
        (time_s / RISE_S).clamp(0.0, 1.0)
    } else {
        (1.0 - (time_s - falls_s) / FALL_S).max(0.0)
    }
}

/// Where a test is asked for and seen. Cheap to clone; any thread may use it.
#[derive(Clone, Debug, Default)]
pub struct Push {
    force_n: Place,
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    /// Tests asked for; each call for an end counts too, so that an odd number is a test and an even one none.
    asked: AtomicU64,
    /// The number whose test the device has ended by itself.
    ended: AtomicU64,
    /// Share of the force rendered now, and of the time that is over, as bits.
    level: AtomicU64,
    done: AtomicU64,
}

impl Push {
    /// Begins a test up to `force_n` on the subject, N; not finite: none begins. One that runs is ended first.
    pub fn begin(&self, force_n: Vec3) {
        if force_n.is_finite() {
            self.end();
            self.force_n.set(force_n);
            self.shared.asked.fetch_add(1, Ordering::AcqRel);
        }
    }

    /// Ends the test that runs: no force from the next tick on.
    pub fn end(&self) {
        let asked = self.shared.asked.load(Ordering::Acquire);
        if asked % 2 == 1 {
            let _ = self.shared.asked.compare_exchange(
                asked,
                asked + 1,
                Ordering::AcqRel,
                Ordering::Acquire,
            );
        }
    }

    /// The share of the force rendered now, and of the time that is over, 0 … 1; `None` while no test runs.
    pub fn state(&self) -> Option<(f64, f64)> {
        let s = &self.shared;
        let asked = s.asked.load(Ordering::Acquire);
        let runs = asked % 2 == 1 && s.ended.load(Ordering::Acquire) != asked;
        let bits = |n: &AtomicU64| f64::from_bits(n.load(Ordering::Relaxed));
        runs.then(|| (bits(&s.level), bits(&s.done)))
    }
}

/// A device that can be tested.
///
/// The test's force takes the place of the skin's, which must be none: a finger that touches the skin, a device that does
/// not answer, a button, force switched off or the device closed end the test.
pub struct Pushed {
    device: Box<dyn Device>,
    push: Push,
    most_n: f64,
    /// The number of the test that runs and its time, s.
    running: Option<(u64, f64)>,
    /// The force at its top, N.
    top_n: Vec3,
    /// Whether force is switched on.
    on: bool,
}

impl Pushed {
    /// `device`, tested when `push` asks for it.
    pub fn new(device: Box<dyn Device>, push: &Push) -> Self {
        let c = device.capabilities();
        let most_n = MOST_SHARE * c.continuous_force_n.min(c.rated_force_n);
        Self {
            most_n: if most_n.is_finite() {
                most_n.max(0.0)
            } else {
                0.0
            },
            device,
            push: push.clone(),
            running: None,
            top_n: Vec3::ZERO,
            on: false,
        }
    }

    fn end(&mut self) {
        if let Some((number, _)) = self.running.take() {
            self.push.shared.ended.store(number, Ordering::Release);
        }
    }

    fn obey(&mut self) {
        let asked = self.push.shared.asked.load(Ordering::Acquire);
        if self.running.is_some_and(|(number, _)| number != asked) {
            self.end();
        }
        let new = asked % 2 == 1 && self.push.shared.ended.load(Ordering::Acquire) != asked;
        if new && !self.on {
            self.push.shared.ended.store(asked, Ordering::Release);
            return;
        }
        if self.running.is_none()
            && new
            && let Some(force_n) = self.push.force_n.try_get()
        {
            let length_n = force_n.length();
            self.top_n = if length_n > self.most_n {
                force_n * (self.most_n / length_n)
            } else {
                force_n
            };
            self.running = Some((asked, 0.0));
        }
    }
}

impl Device for Pushed {
    fn capabilities(&self) -> &Capabilities {
        self.device.capabilities()
    }

    fn read(&mut self, dt_s: f64) -> Reading {
        let reading = self.device.read(dt_s);
        self.obey();
        let ends_s = RISE_S + HOLD_S + FALL_S;
        let over = match &mut self.running {
            Some((_, time_s)) => {
                *time_s += dt_s;
                let s = &self.push.shared;
                s.level.store(level(*time_s).to_bits(), Ordering::Relaxed);
                s.done
                    .store((*time_s / ends_s).to_bits(), Ordering::Relaxed);
                *time_s >= ends_s
            }
            None => false,
        };
        if over || !reading.is_usable() || reading.buttons != 0 {
            self.end();
        }
        reading
    }

    fn write(&mut self, force_n: Vec3) {
        if force_n != Vec3::ZERO {
            self.end();
        }
        let force_n = match self.running {
            Some((_, time_s)) => self.top_n * level(time_s),
            None => force_n,
        };
        self.device.write(force_n);
    }

    fn enable(&mut self, on: bool) {
        self.on = on;
        if !on {
            self.end();
        }
        self.device.enable(on);
    }

    fn close(&mut self) {
        self.end();
        self.device.close();
    }

    fn vitals(&self) -> Option<Arc<Vitals>> {
        self.device.vitals()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[derive(Debug, Default)]
    struct Told {
        reading: Reading,
        force_n: Vec3,
        closed: bool,
    }

    /// A device that says what it is told to, and tells what it was sent.
    struct Puppet(Capabilities, Arc<Mutex<Told>>);

    impl Device for Puppet {
        fn capabilities(&self) -> &Capabilities {
            &self.0
        }
        fn read(&mut self, _dt_s: f64) -> Reading {
            self.1.lock().expect("lock").reading
        }
        fn write(&mut self, force_n: Vec3) {
            self.1.lock().expect("lock").force_n = force_n;
        }
        fn close(&mut self) {
            self.write(Vec3::ZERO);
            self.1.lock().expect("lock").closed = true;
        }
    }

    fn puppet() -> (Pushed, Push, Arc<Mutex<Told>>) {
        let told = Arc::new(Mutex::new(Told::default()));
        told.lock().expect("lock").reading.connected = true;
        let device = Puppet(Capabilities::ideal("Puppet", 8.0), told.clone());
        let push = Push::default();
        let mut pushed = Pushed::new(Box::new(device), &push);
        pushed.enable(true);
        (pushed, push, told)
    }

    fn sent(device: &mut Pushed, told: &Mutex<Told>, skin_n: Vec3) -> Vec3 {
        device.read(0.001);
        device.write(skin_n);
        told.lock().expect("lock").force_n
    }

    #[test]
    fn the_force_rises_slowly_stays_and_falls_and_is_half_of_what_can_be_held_at_most() {
        let (mut device, push, told) = puppet();
        assert_eq!(push.state(), None);
        push.begin(Vec3::new(0.0, 0.0, 100.0));
        let mut forces = Vec::new();
        for _ in 0..7000 {
            forces.push(sent(&mut device, &told, Vec3::ZERO).z);
        }
        let most = forces.iter().copied().fold(0.0, f64::max);
        assert!((most - 4.0).abs() < 1e-12, "{most}");
        let steps = forces.windows(2).map(|w| w[1] - w[0]);
        let rise = steps.fold(0.0, f64::max);
        assert!(
            (rise - 4.0 * 0.001 / RISE_S).abs() < 1e-9,
            "{rise} N in a tick"
        );
        assert!(
            (forces[1499] - 2.0).abs() < 1e-9,
            "half way up: {}",
            forces[1499]
        );
        assert!(
            (forces[5499] - 2.0).abs() < 1e-9,
            "half way down: {}",
            forces[5499]
        );
        assert_eq!(forces[6500], 0.0);
        assert_eq!(push.state(), None);
    }

    #[test]
    fn whatever_is_not_as_it_should_be_ends_the_test() {
        type Disturb = fn(&mut Pushed, &Mutex<Told>) -> Vec3;
        let disturbed: [Disturb; 5] = [
            |_, told| {
                told.lock().expect("lock").reading.connected = false;
                Vec3::ZERO
            },
            |_, told| {
                told.lock().expect("lock").reading.buttons = 2;
                Vec3::ZERO
            },
            |_, _| Vec3::new(0.0, 0.0, 0.3),
            |device, _| {
                device.enable(false);
                Vec3::ZERO
            },
            |device, _| {
                device.close();
                Vec3::ZERO
            },
        ];
        for (i, disturb) in disturbed.into_iter().enumerate() {
            let (mut device, push, told) = puppet();
            push.begin(Vec3::Z);
            for _ in 0..1000 {
                sent(&mut device, &told, Vec3::ZERO);
            }
            assert!(push.state().is_some() && told.lock().expect("lock").force_n.z > 0.3);
            let skin_n = disturb(&mut device, &told);
            for _ in 0..3 {
                assert_eq!(sent(&mut device, &told, skin_n), skin_n, "{i}");
            }
            assert_eq!(push.state(), None, "{i}");
        }
    }

    #[test]
    fn a_test_asked_for_while_force_is_off_never_begins() {
        let (mut device, push, told) = puppet();
        device.enable(false);
        push.begin(Vec3::Z);
        for on in [false, true] {
            device.enable(on);
            for _ in 0..2000 {
                assert_eq!(sent(&mut device, &told, Vec3::ZERO), Vec3::ZERO);
            }
        }
        assert_eq!(push.state(), None);
    }

    #[test]
    fn a_test_can_be_ended_and_begun_again() {
        let (mut device, push, told) = puppet();
        push.end();
        assert_eq!(sent(&mut device, &told, Vec3::ZERO), Vec3::ZERO);
        push.begin(Vec3::NAN);
        assert_eq!(push.state(), None);
        for _ in 0..2 {
            push.begin(Vec3::X);
            for _ in 0..600 {
                sent(&mut device, &told, Vec3::ZERO);
            }
            let force_n = told.lock().expect("lock").force_n;
            assert!((force_n.x - 0.2).abs() < 1e-9, "{force_n}");
        }
        push.end();
        assert_eq!(push.state(), None);
        assert_eq!(sent(&mut device, &told, Vec3::ZERO), Vec3::ZERO);
    }

    #[test]
    fn the_level_is_within_one_whatever_the_time() {
        for t in [
            -1.0,
            0.0,
            f64::NAN,
            f64::INFINITY,
            1e9,
            RISE_S,
            RISE_S + HOLD_S,
        ] {
            assert!((0.0..=1.0).contains(&level(t)), "{t}");
        }
        assert_eq!((level(RISE_S), level(RISE_S + HOLD_S)), (1.0, 1.0));
    }
}
