//! An arm in a hand, simulated: what the motors do to it, what the encoders say of it.

use crate::device::hid::arm::Arm;
use crate::geom::{Vec3, unit_or};

/// Mechanics of the arm and the hand that holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mechanics {
    /// Moving mass at the tip, kg.
    pub mass_kg: f64,
    /// Viscous friction, N·s/mm.
    pub damping_n_s_per_mm: f64,
    /// Coulomb friction, N.
    pub coulomb_n: f64,
    /// Time constant of the current loop, s.
    pub current_loop_s: f64,
    /// Spring of the hand, N/mm.
    pub hand_n_per_mm: f64,
    /// Damping of the hand, N·s/mm.
    pub hand_n_s_per_mm: f64,
}

impl Default for Mechanics {
    /// The arm as assumed for WoodenHaptics in the studies of stability, in a firm hand.
    fn default() -> Self {
        Self {
            mass_kg: 0.15,
            damping_n_s_per_mm: 1.0e-3,
            coulomb_n: 0.15,
            current_loop_s: 0.5e-3,
            hand_n_per_mm: 0.5,
            hand_n_s_per_mm: 0.01,
        }
    }
}

/// Speed below which Coulomb friction fades, mm/s: a sign would chatter.
const CREEP_MM_S: f64 = 1.0;
/// Longest step of the integration, s.
const STEP_S: f64 = 1.0e-4;
/// Lever that the tip's position has on an axis that is mounted the wrong way round.
const REVERSED: f64 = -1.0;

/// The simulated arm.
#[derive(Clone, Debug)]
pub struct Plant {
    /// Geometry and motors.
    pub arm: Arm,
    /// Mass, friction, hand.
    pub mechanics: Mechanics,
    /// Where the hand wants the tip, mm.
    pub target_mm: Vec3,
    /// Where the tip is, mm.
    pub position_mm: Vec3,
    /// Its velocity, mm/s.
    pub velocity_mm_s: Vec3,
    /// Currents that flow, A.
    pub currents_a: [f64; 3],
    /// Which motor turns against its command; `None`: none.
    pub reversed: Option<usize>,
}

impl Plant {
    /// An arm at rest at `at_mm`, held there.
    pub fn new(arm: Arm, mechanics: Mechanics, at_mm: Vec3) -> Self {
        Self {
            arm,
            mechanics,
            target_mm: at_mm,
            position_mm: at_mm,
            velocity_mm_s: Vec3::ZERO,
            currents_a: [0.0; 3],
            reversed: None,
        }
    }

    /// Angles of the bodies, rad. Out of reach the arm is taken to be in the middle of its workspace.
    pub fn angles_rad(&self) -> [f64; 3] {
        let reached = self.arm.angles_at(self.position_mm);
        reached
            .or_else(|| self.arm.angles_at(Vec3::ZERO))
            .unwrap_or_default()
    }

    /// What the encoders say.
    pub fn encoders(&self) -> [i32; 3] {
        self.arm.encoders_at(self.angles_rad())
    }

    /// The force that the currents that flow make at the tip, N.
    pub fn force_n(&self) -> Vec3 {
        self.force_of_n(self.currents_a)
    }

    /// The force that these currents, A, would make at the tip, N.
    pub fn force_of_n(&self, mut currents: [f64; 3]) -> Vec3 {
        if let Some(a) = self.reversed.and_then(|i| currents.get_mut(i)) {
            *a *= REVERSED;
        }
        let torques = self.arm.torques_of(currents);
        self.arm
            .force_n(self.angles_rad(), torques)
            .unwrap_or(Vec3::ZERO)
    }

    /// Goes on by `dt_s` with these currents commanded, A.
    pub fn advance(&mut self, commanded_a: [f64; 3], dt_s: f64) {
        let n = libm::ceil(dt_s / STEP_S).clamp(1.0, 1.0e4) as usize;
        let h = dt_s / n as f64;
        let m = self.mechanics;
        let follow = 1.0 - libm::exp(-h / m.current_loop_s.max(1.0e-6));
        for _ in 0..n {
            for (flows, wanted) in self.currents_a.iter_mut().zip(commanded_a) {
                *flows += (wanted - *flows) * follow;
            }
            let v = self.velocity_mm_s;
            let pull = (self.target_mm - self.position_mm) * m.hand_n_per_mm;
            let drag = v * (m.damping_n_s_per_mm + m.hand_n_s_per_mm);
            let rub = unit_or(v, Vec3::ZERO) * m.coulomb_n * (v.length() / CREEP_MM_S).min(1.0);
            // 1 N is 1000 kg mm/s².
            let push = (self.force_n() + pull - drag - rub) * 1000.0;
            self.velocity_mm_s += push * (h / m.mass_kg);
            let next = self.position_mm + self.velocity_mm_s * h;
            if self.arm.angles_at(next).is_some() {
                self.position_mm = next;
            } else {
                // The end of its reach.
                self.velocity_mm_s = Vec3::ZERO;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::hid::driver::{ArmDriver, Protocol};
    use crate::device::hid::link::Driver as _;
    use crate::device::hid::models::ARMS;
    use crate::device::hid::report::{polhem, teensy, wooden};
    use crate::device::hid::transport::REPORT;

    /// Both ends of a protocol without a wire: what the driver reads and renders, step by step, against the truth.
    fn rig(protocol: Protocol, model: usize) -> (ArmDriver, Plant) {
        let arm = ARMS[model].arm();
        let driver = ArmDriver::new(protocol, arm.clone(), None);
        (
            driver,
            Plant::new(arm, Mechanics::default(), Vec3::Z * 20.0),
        )
    }

    fn tell(protocol: Protocol, plant: &Plant, driver: &mut ArmDriver) -> bool {
        let [a, b, c] = plant.encoders().map(|e| e as i16);
        let wrist = polhem::In {
            encoders: [a, b, c, 0, 0, 0],
            ..Default::default()
        };
        match protocol {
            Protocol::Wooden => driver.take(
                &wooden::In {
                    encoders: [a, b, c],
                    counter: 1,
                }
                .encode(),
            ),
            Protocol::Polhem => driver.take(&wrist.encode()),
            Protocol::Teensy => driver.take(&teensy::encode(&wrist)),
        }
    }

    fn currents(protocol: Protocol, bytes: &[u8]) -> [f64; 3] {
        let ma = |out: polhem::Out| match out {
            polhem::Out::Currents(ma) => ma,
            polhem::Out::Preset(_) => [0; 3],
        };
        let ma = match protocol {
            Protocol::Wooden => wooden::Out::decode(bytes).expect("a report").current_ma,
            Protocol::Polhem => ma(polhem::Out::decode(bytes).expect("a report")),
            Protocol::Teensy => ma(teensy::decode_out(bytes).expect("a report")),
        };
        ma.map(|ma| f64::from(ma) / 1000.0)
    }

    #[test]
    fn a_press_is_read_and_rendered_as_the_model_has_it() {
        for (protocol, model) in [
            (Protocol::Wooden, 0),
            (Protocol::Polhem, 2),
            (Protocol::Teensy, 1),
        ] {
            let (mut driver, mut plant) = rig(protocol, model);
            let mut out = [0; REPORT];
            let step_mm = plant.arm.resolution_mm();
            let (mut worst_mm, mut worst_n, mut deepest_n) = (0.0_f64, 0.0_f64, 0.0_f64);
            for tick in 0..3000 {
                let t = f64::from(tick) * 0.001;
                plant.target_mm = Vec3::new(
                    10.0 * libm::sin(2.0 * t),
                    10.0 * libm::cos(3.0 * t),
                    20.0 - 30.0 * (t - 0.5).clamp(0.0, 1.0),
                );
                assert!(tell(protocol, &plant, &mut driver));
                let read = driver.seen().position_mm;
                worst_mm = worst_mm.max(read.distance(plant.position_mm));
                // A skin at z = 0.
                let force_n = Vec3::Z * (0.5 * (-read.z).max(0.0)).min(5.0);
                let (n, _) = driver.render(Some(force_n), &mut out);
                let commanded = currents(protocol, &out[..n]);
                let torques = plant.arm.torques_of(commanded);
                let at = plant.angles_rad();
                let rendered = plant.arm.force_n(at, torques).expect("within reach");
                worst_n = worst_n.max(rendered.distance(force_n));
                deepest_n = deepest_n.max(force_n.z);
                plant.advance(commanded, 0.001);
            }
            // Half a count on each of three axes; half a milliampere on each of three motors, and the arm's turn within half
            // a count, which bends 5 N by a thousandth.
            assert!(worst_mm <= step_mm, "{protocol:?}: {worst_mm} mm off");
            assert!(worst_n <= 0.02, "{protocol:?}: {worst_n} N off");
            assert!(deepest_n > 1.0, "{protocol:?}: pressed {deepest_n} N only");
        }
    }

    #[test]
    fn a_held_arm_rests_where_hand_and_force_balance() {
        let (_, mut plant) = rig(Protocol::Wooden, 0);
        plant.mechanics.coulomb_n = 0.0;
        let force_n = Vec3::new(0.0, 0.5, 2.0);
        for _ in 0..5000 {
            let at = plant.angles_rad();
            let currents = plant.arm.currents_a(plant.arm.torques_n_mm(at, force_n));
            plant.advance(currents.a, 0.001);
        }
        let expected = Vec3::Z * 20.0 + force_n / plant.mechanics.hand_n_per_mm;
        let off = plant.position_mm.distance(expected);
        assert!(off < 0.01, "{off} mm off");
    }

    #[test]
    fn a_reversed_motor_pulls_where_it_should_push() {
        let (_, mut plant) = rig(Protocol::Wooden, 0);
        let at = plant.angles_rad();
        plant.currents_a = plant.arm.currents_a(plant.arm.torques_n_mm(at, Vec3::Y)).a;
        assert!(plant.force_n().distance(Vec3::Y) < 1e-9);
        plant.reversed = Some(0);
        assert!(plant.force_n().distance(Vec3::NEG_Y) < 1e-9);
    }
}
