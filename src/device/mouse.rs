//! The mouse finger: a spring-and-damper hand between the cursor and the HIP.
//!
//! The window says where the finger is wanted; a hand of some mass follows through a spring and a damper, and is pushed
//! back by the force the skin sends. So motion and force are a finger's, not the teleports of a cursor.

use super::place::{FAR_MM, Place};
use super::{Capabilities, Device, Reading};
use crate::geom::Vec3;

/// The hand. Unforced it is critically damped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// Moving mass of fingers and hand, kg.
    pub mass_kg: f64,
    /// Spring towards the wanted place, N/mm.
    pub stiffness_n_per_mm: f64,
    /// Damping, N·s/mm.
    pub damping_n_s_per_mm: f64,
}

impl Hand {
    /// A hand of `mass_kg` and `stiffness_n_per_mm` with the damping that is just critical.
    pub fn critical(mass_kg: f64, stiffness_n_per_mm: f64) -> Self {
        // 1 N/mm = 1000 N/m; 1 N·s/m = 0.001 N·s/mm.
        let damping_n_s_per_m = 2.0 * (mass_kg * stiffness_n_per_mm * 1000.0).max(0.0).sqrt();
        Self {
            mass_kg,
            stiffness_n_per_mm,
            damping_n_s_per_mm: damping_n_s_per_m / 1000.0,
        }
    }

    /// One step of `dt_s` by the implicit Euler method: stable for any stiffness, damping and step.
    ///
    /// Returns the new position (mm) and velocity (mm/s).
    fn step(
        &self,
        position: Vec3,
        velocity: Vec3,
        target: Vec3,
        force_n: Vec3,
        dt_s: f64,
    ) -> (Vec3, Vec3) {
        // 1 N is 1000 kg mm/s². Over the whole, not over the mass, so that a hand without mass is one too.
        let (k, b) = (self.stiffness_n_per_mm, self.damping_n_s_per_mm);
        let pull = (target - position) * k + force_n;
        let held = self.mass_kg + 1000.0 * dt_s * (b + k * dt_s);
        let velocity = (velocity * self.mass_kg + pull * (1000.0 * dt_s)) / held;
        let there = position + velocity * dt_s;
        // Nothing holds it at all, or numbers ran out: it stays.
        if there.is_finite() && velocity.is_finite() {
            (there, velocity)
        } else {
            (position, Vec3::ZERO)
        }
    }

    /// The same hand; what is no mass, stiffness or damping counts as that of the default.
    fn sound(self) -> Self {
        let or = Self::default();
        let sound = |x: f64, or: f64| if x >= 0.0 && x.is_finite() { x } else { or };
        Self {
            mass_kg: sound(self.mass_kg, or.mass_kg),
            stiffness_n_per_mm: sound(self.stiffness_n_per_mm, or.stiffness_n_per_mm),
            damping_n_s_per_mm: sound(self.damping_n_s_per_mm, or.damping_n_s_per_mm),
        }
    }
}

impl Default for Hand {
    /// 0.15 kg on 1.5 N/mm: settles in about 50 ms and gives way by a few mm against a hard spot, as a finger does.
    fn default() -> Self {
        Self::critical(0.15, 1.5)
    }
}

/// Where the window wants a mouse finger to be. Cheap to clone; any thread may set it, the servo reads the newest.
#[derive(Clone, Debug, Default)]
pub struct MouseHandle {
    shared: Place,
}

impl MouseHandle {
    /// Says where the finger is wanted, mm, as [`Place::set`] does.
    pub fn set(&self, target_mm: Vec3) {
        self.shared.set(target_mm);
    }

    /// The last place set, mm.
    pub fn target_mm(&self) -> Vec3 {
        self.shared.get()
    }

    /// The last place set, or `None` while another thread is writing it.
    fn try_target(&self) -> Option<Vec3> {
        self.shared.try_get()
    }
}

/// The servo's end of a mouse finger.
#[derive(Clone, Debug)]
pub struct Mouse {
    capabilities: Capabilities,
    shared: MouseHandle,
    hand: Hand,
    target_mm: Vec3,
    position_mm: Vec3,
    velocity_mm_s: Vec3,
    force_n: Vec3,
}

impl Mouse {
    /// A mouse finger resting at `start_mm`, and the handle that moves it. What is no place counts as the origin, what is no
    /// mass, stiffness or damping as that of the default hand.
    pub fn new(start_mm: Vec3, hand: Hand) -> (Self, MouseHandle) {
        let start_mm = if start_mm.is_finite() {
            start_mm.clamp(Vec3::splat(-FAR_MM), Vec3::splat(FAR_MM))
        } else {
            Vec3::ZERO
        };
        let handle = MouseHandle {
            shared: Place::default(),
        };
        handle.set(start_mm);
        let capabilities = Capabilities::ideal("Mouse", 22.0);
        let mouse = Self {
            capabilities,
            shared: handle.clone(),
            hand: hand.sound(),
            target_mm: start_mm,
            position_mm: start_mm,
            velocity_mm_s: Vec3::ZERO,
            force_n: Vec3::ZERO,
        };
        (mouse, handle)
    }
}

impl Device for Mouse {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self, dt_s: f64) -> Reading {
        // A target caught half written is left for the next tick: the servo never waits.
        if let Some(target) = self.shared.try_target() {
            self.target_mm = target;
        }
        (self.position_mm, self.velocity_mm_s) = self.hand.step(
            self.position_mm,
            self.velocity_mm_s,
            self.target_mm,
            self.force_n,
            dt_s,
        );
        Reading {
            position_mm: self.position_mm,
            velocity_mm_s: self.velocity_mm_s,
            buttons: 0,
            connected: true,
        }
    }

    fn write(&mut self, force_n: Vec3) {
        self.force_n = force_n;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settle(mouse: &mut Mouse, skin_n_per_mm: f64, ticks: usize) -> Vec<Reading> {
        (0..ticks)
            .map(|_| {
                let reading = mouse.read(0.001);
                // Skin: a spring below z = 0.
                mouse.write(Vec3::Z * (-reading.position_mm.z).max(0.0) * skin_n_per_mm);
                reading
            })
            .collect()
    }

    #[test]
    fn free_hand_reaches_the_cursor_without_overshoot() {
        let (mut mouse, handle) = Mouse::new(Vec3::ZERO, Hand::default());
        handle.set(Vec3::new(30.0, 0.0, 5.0));
        let path = settle(&mut mouse, 0.0, 500);
        assert!(path.iter().all(|r| r.position_mm.x <= 30.0 + 1e-9));
        assert!(path[499].position_mm.distance(Vec3::new(30.0, 0.0, 5.0)) < 1e-3);
    }

    /// A hand without mass divided by it; from a target of 1e308 the hand never came back.
    #[test]
    fn no_hand_and_no_target_makes_a_place_that_is_none() {
        let bad = [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e-300, 1e300];
        let hand = |x: f64, i: usize| {
            let mut values = [0.15, 1.5, 0.03];
            values[i] = x;
            Hand {
                mass_kg: values[0],
                stiffness_n_per_mm: values[1],
                damping_n_s_per_mm: values[2],
            }
        };
        let hands = bad.iter().flat_map(|&x| (0..3).map(move |i| (x, i)));
        for hand in hands.map(|(x, i)| hand(x, i)).chain([hand(0.15, 0)]) {
            let (mut mouse, handle) = Mouse::new(Vec3::splat(f64::NAN), hand);
            for target in [1e308, -1e308, 5.0] {
                handle.set(Vec3::splat(target));
                for r in settle(&mut mouse, 0.5, 1500) {
                    assert!(
                        r.is_usable() && r.velocity_mm_s.is_finite(),
                        "{hand:?}: {r:?}"
                    );
                }
            }
        }
        let (mut mouse, handle) = Mouse::new(Vec3::ZERO, Hand::default());
        for target in [1e308, 5.0] {
            handle.set(Vec3::splat(target));
            settle(&mut mouse, 0.0, 1500);
        }
        assert!(mouse.position_mm.distance(Vec3::splat(5.0)) < 1e-3);
    }

    #[test]
    fn first_tick_after_a_jump_of_the_cursor_is_not_a_teleport() {
        let (mut mouse, handle) = Mouse::new(Vec3::ZERO, Hand::default());
        handle.set(Vec3::new(100.0, 0.0, 0.0));
        let moved_mm = mouse.read(0.001).position_mm.x;
        assert!(moved_mm > 0.0 && moved_mm < 2.0, "moved {moved_mm} mm");
    }

    #[test]
    fn pressed_hand_rests_where_its_spring_balances_the_skin() {
        let hand = Hand::default();
        let (mut mouse, handle) = Mouse::new(Vec3::ZERO, hand);
        handle.set(Vec3::new(0.0, 0.0, -8.0));
        let skin = 0.5;
        let z = settle(&mut mouse, skin, 2000)[1999].position_mm.z;
        let expected = -8.0 * hand.stiffness_n_per_mm / (hand.stiffness_n_per_mm + skin);
        assert!((z - expected).abs() < 1e-6, "{z} against {expected}");
    }

    #[test]
    fn hand_stays_bounded_against_skin_of_any_stiffness() {
        for skin in [0.01, 1.0, 100.0] {
            let (mut mouse, handle) = Mouse::new(Vec3::Z * 5.0, Hand::default());
            handle.set(Vec3::Z * -10.0);
            for _ in 0..5000 {
                let r = mouse.read(0.001);
                let force_n = (-r.position_mm.z).max(0.0) * skin;
                mouse.write(Vec3::Z * force_n.min(22.0));
                assert!(r.position_mm.length() < 100.0);
            }
        }
    }

    #[test]
    fn targets_that_are_not_finite_are_ignored() {
        let (mut mouse, handle) = Mouse::new(Vec3::ONE, Hand::default());
        handle.set(Vec3::new(f64::NAN, 0.0, 0.0));
        handle.set(Vec3::new(0.0, f64::INFINITY, 0.0));
        assert_eq!(handle.target_mm(), Vec3::ONE);
        assert!(mouse.read(0.001).position_mm.is_finite());
    }
}
