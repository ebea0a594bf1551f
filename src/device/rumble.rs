//! A gamepad that rumbles as a force *indicator*: it tells that there is force and how much of the rated one, not where to.
//!
//! Fed at display rate from the newest snapshot, never from the servo. The strong motor follows the force, the weak one
//! ticks where a finger begins to touch or to slip. Linux only, through the kernel's force feedback (evdev, `FF_RUMBLE`);
//! tested with a virtual gamepad at best, never with hardware.

/// How strongly both motors turn, 0 … 65,535 of their most.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rumble {
    /// The strong motor.
    pub strong: u16,
    /// The weak one.
    pub weak: u16,
}

/// Below this share of the rated force nothing turns: a motor that just hums tells nothing.
const LEAST_SHARE: f64 = 0.02;
/// The weak motor at a contact or a slip.
const TICK: u16 = 40_000;

impl Rumble {
    /// The rumble of a force, N, for a device rated so, N, of a finger that slips or not. A force that is not finite, and one
    /// without a rated force, is none.
    pub fn of(force_n: f64, rated_n: f64, slips: bool) -> Self {
        let share = force_n.abs() / rated_n;
        if !(share.is_finite() && rated_n > 0.0 && share >= LEAST_SHARE) {
            return Self::default();
        }
        Self {
            strong: (share.min(1.0) * f64::from(u16::MAX)) as u16,
            weak: if slips { TICK } else { 0 },
        }
    }
}

/// A gamepad that can rumble.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Gamepad {
    /// Where it is opened.
    pub place: String,
    /// What it calls itself.
    pub title: String,
}

#[cfg(target_os = "linux")]
pub use linux::{Indicator, find};

#[cfg(target_os = "linux")]
mod linux {
    use super::{Gamepad, Rumble};
    use evdev::{Device, FFEffect, FFEffectCode, FFEffectData, FFEffectKind, FFReplay, FFTrigger};
    use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
    use std::thread::JoinHandle;
    use std::time::{Duration, Instant};

    /// How long a rumble lasts that nobody renews, ms: who feeds it may hang.
    const LASTS_MS: u16 = 150;
    /// How often a gamepad is looked for while there is none.
    const LOOKED_FOR: Duration = Duration::from_secs(2);

    fn rumbles(device: &Device) -> bool {
        let kinds = device.supported_ff();
        kinds.is_some_and(|kinds| kinds.contains(FFEffectCode::FF_RUMBLE))
    }

    fn all() -> impl Iterator<Item = (Gamepad, Device)> {
        evdev::enumerate()
            .filter(|(_, d)| rumbles(d))
            .map(|(path, device)| {
                let name: String = device
                    .name()
                    .unwrap_or("gamepad")
                    .chars()
                    .take(120)
                    .collect();
                let gamepad = Gamepad {
                    place: path.display().to_string(),
                    title: name.chars().filter(|c| !c.is_control()).collect(),
                };
                (gamepad, device)
            })
    }

    /// The gamepads that can rumble and may be opened.
    pub fn find() -> Vec<Gamepad> {
        let mut found: Vec<Gamepad> = all().map(|(gamepad, _)| gamepad).collect();
        found.sort_by(|a, b| a.place.cmp(&b.place));
        found
    }

    /// A thread that lets the first gamepad rumble, whichever there is when something is felt. It sleeps while nothing is.
    /// Dropping it ends the rumble; should the program die, the kernel does.
    #[derive(Debug)]
    pub struct Indicator {
        tell: Option<SyncSender<Rumble>>,
        told: Rumble,
        thread: Option<JoinHandle<()>>,
    }

    impl Indicator {
        /// Starts the thread; nothing where the system gives none. Gamepads are looked for when there is something to
        /// feel, so that they may come and go.
        pub fn start() -> Option<Self> {
            let (tell, heard) = sync_channel(1);
            let thread = std::thread::Builder::new()
                .name("rumble".into())
                .spawn(move || live(&heard))
                .ok()?;
            Some(Self {
                tell: Some(tell),
                told: Rumble::default(),
                thread: Some(thread),
            })
        }

        /// Tells the newest force, N, of a device rated so, N, and whether the finger slips. Never waits. To be told again at
        /// least ten times a second while there is force: a rumble that nobody renews ends by itself.
        pub fn feel(&mut self, force_n: f64, rated_n: f64, slips: bool) {
            let rumble = Rumble::of(force_n, rated_n, slips);
            let still = rumble == Rumble::default();
            if still && self.told == Rumble::default() {
                return;
            }
            if let Some(tell) = &self.tell
                && tell.try_send(rumble).is_ok()
            {
                self.told = rumble;
            }
        }
    }

    impl Drop for Indicator {
        fn drop(&mut self) {
            drop(self.tell.take());
            if let Some(thread) = self.thread.take() {
                drop(thread.join());
            }
        }
    }

    /// A gamepad that rumbles. It ends with the effect: the kernel takes it away when the file is closed.
    struct Turning {
        effect: FFEffect,
        _device: Device,
    }

    impl Turning {
        fn start() -> Option<Self> {
            all().find_map(|(_, mut device)| {
                let effect = device.upload_ff_effect(data(Rumble::default())).ok()?;
                Some(Self {
                    effect,
                    _device: device,
                })
            })
        }

        fn turn(&mut self, rumble: Rumble) -> std::io::Result<()> {
            if rumble == Rumble::default() {
                return self.effect.stop();
            }
            self.effect.update(data(rumble))?;
            self.effect.play(1)
        }
    }

    fn data(rumble: Rumble) -> FFEffectData {
        FFEffectData {
            direction: 0,
            trigger: FFTrigger::default(),
            replay: FFReplay {
                length: LASTS_MS,
                delay: 0,
            },
            kind: FFEffectKind::Rumble {
                strong_magnitude: rumble.strong,
                weak_magnitude: rumble.weak,
            },
        }
    }

    fn live(heard: &Receiver<Rumble>) {
        let mut turning: Option<Turning> = None;
        let mut looked: Option<Instant> = None;
        let mut rumble = Rumble::default();
        loop {
            rumble = if rumble == Rumble::default() {
                match heard.recv() {
                    Ok(rumble) => rumble,
                    Err(_) => break,
                }
            } else {
                match heard.recv_timeout(Duration::from_millis(LASTS_MS.into())) {
                    Ok(rumble) => rumble,
                    // Whoever fed it hangs, or has nothing more to tell.
                    Err(RecvTimeoutError::Timeout) => Rumble::default(),
                    Err(RecvTimeoutError::Disconnected) => break,
                }
            };
            if turning.is_none() && looked.is_none_or(|t| t.elapsed() >= LOOKED_FOR) {
                looked = Some(Instant::now());
                turning = Turning::start();
            }
            // One that was pulled out is looked for again.
            if turning.as_mut().is_some_and(|t| t.turn(rumble).is_err()) {
                turning = None;
            }
        }
        if let Some(mut gamepad) = turning {
            let _ = gamepad.turn(Rumble::default());
        }
    }
}

#[cfg(not(target_os = "linux"))]
pub use elsewhere::{Indicator, find};

#[cfg(not(target_os = "linux"))]
mod elsewhere {
    use super::Gamepad;

    /// None: rumble needs Linux.
    pub fn find() -> Vec<Gamepad> {
        Vec::new()
    }

    /// Rumble needs Linux: there is none here.
    #[derive(Debug)]
    pub enum Indicator {}

    impl Indicator {
        /// Nothing.
        pub fn start() -> Option<Self> {
            None
        }

        /// Never called: there is no value of this type.
        pub fn feel(&mut self, _force_n: f64, _rated_n: f64, _slips: bool) {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_strong_motor_follows_the_share_of_the_rated_force() {
        assert_eq!(Rumble::of(0.0, 5.0, true), Rumble::default());
        assert_eq!(Rumble::of(2.5, 5.0, false).strong, 32_767);
        assert_eq!(Rumble::of(9.0, 5.0, false).strong, u16::MAX);
        assert_eq!(
            Rumble::of(-5.0, 5.0, true),
            Rumble {
                strong: u16::MAX,
                weak: TICK
            }
        );
    }

    proptest! {
        #[test]
        fn no_number_is_a_rumble_that_it_should_not_be(force in prop::num::f64::ANY, rated in prop::num::f64::ANY) {
            let rumble = Rumble::of(force, rated, true);
            let sound = force.is_finite() && rated.is_finite() && rated > 0.0;
            prop_assert!(sound || (rated > 0.0 && rated.is_infinite()) || rumble == Rumble::default());
        }

        #[test]
        fn more_force_is_never_less_rumble(force in 0.0..20.0_f64, more in 0.0..5.0_f64) {
            let strong = |f| Rumble::of(f, 8.0, false).strong;
            prop_assert!(strong(force + more) >= strong(force));
        }
    }

    #[test]
    fn looking_for_gamepads_neither_fails_nor_hangs() {
        for gamepad in find() {
            assert!(!gamepad.place.is_empty());
        }
    }
}
