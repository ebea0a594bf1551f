//! The arm of WoodenHaptics and its kin: three bodies turned by motors over cables on capstans.
//!
//! Body A turns about the vertical; B stands on it, C hangs from the end of B. Both are turned by motors that ride on A, so
//! that the angle of C does not depend on that of B:
//!
//! ```text
//! θ = direction · 2π (sign · count + offset) / counts per turn · capstan / body
//! x = cos A (Lb sin B + Lc sin C) − ox
//! y = sin A (Lb sin B + Lc sin C) − oy
//! z = Ln + Lb cos B − Lc cos C − oz
//! ```
//!
//! Lengths mm, angles rad, in the device's own frame: x towards the user, y to the user's right, z up (Forsslund, Yip and
//! Sallnäs 2015, and the constants of the published drivers). Polhem v2 has another chain of bodies whose kinematics is not
//! published; it is treated as this arm, which its positions and forces are then wrong for, until somebody measures it.

use crate::geom::Vec3;
use std::f64::consts::{PI, TAU};

/// Geometry, encoders and motors of an arm.
#[derive(Clone, Debug, PartialEq)]
pub struct Arm {
    /// Height of the axis of B over the base, Ln, mm.
    pub length_a_mm: f64,
    /// Length of B, mm.
    pub length_b_mm: f64,
    /// Length of C, mm.
    pub length_c_mm: f64,
    /// Diameters of the capstans on the motors, mm.
    pub capstan_diameter_mm: [f64; 3],
    /// Diameters of the bodies that the cables run on, mm.
    pub body_diameter_mm: [f64; 3],
    /// Middle of the workspace, mm.
    pub origin_mm: Vec3,
    /// Radius of the workspace, mm.
    pub workspace_radius_mm: f64,
    /// Encoder counts in a turn of the motor, all four edges counted.
    pub counts_per_turn: [f64; 3],
    /// +1 or −1: the encoder counts up as the motor turns, or down.
    pub encoder_sign: [f64; 3],
    /// Count of each motor, sign applied, where the encoder says 0.
    pub encoder_offset_counts: [i32; 3],
    /// +1 or −1: the body turns as its motor does, or against it.
    pub motor_direction: [f64; 3],
    /// Torque for a current, N·m/A.
    pub torque_constant_n_m_per_a: [f64; 3],
    /// Largest current of a motor, A.
    pub current_limit_a: f64,
}

/// Currents for the motors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Currents {
    /// Of motors a, b, c, A.
    pub a: [f64; 3],
    /// What share of the wanted force they render, 0 … 1: 1 unless a motor reached its limit.
    pub share: f64,
}

impl Arm {
    /// Counts of the motors for those of the encoders.
    pub fn counts(&self, encoders: [i32; 3]) -> [f64; 3] {
        std::array::from_fn(|i| {
            self.encoder_sign[i] * f64::from(encoders[i]) + f64::from(self.encoder_offset_counts[i])
        })
    }

    /// Angles of the bodies, rad, for counts of the encoders.
    pub fn angles_rad(&self, encoders: [i32; 3]) -> [f64; 3] {
        let counts = self.counts(encoders);
        std::array::from_fn(|i| self.rad_per_count(i) * counts[i])
    }

    /// Counts of the encoders, rounded, at angles of the bodies, rad. The inverse of [`Arm::angles_rad`], for emulators.
    pub fn encoders_at(&self, angles_rad: [f64; 3]) -> [i32; 3] {
        std::array::from_fn(|i| {
            let count = angles_rad[i] / self.rad_per_count(i);
            let raw = (count - f64::from(self.encoder_offset_counts[i])) * self.encoder_sign[i];
            // A cast saturates, and NaN is 0.
            libm::round(raw) as i32
        })
    }

    /// Angle of a body for one count, rad, its sign being that of the direction.
    fn rad_per_count(&self, i: usize) -> f64 {
        self.gear(i) * TAU / self.counts_per_turn[i]
    }

    /// Angle of a body for an angle of its motor.
    fn gear(&self, i: usize) -> f64 {
        self.motor_direction[i] * self.capstan_diameter_mm[i] / self.body_diameter_mm[i]
    }

    /// Where the tip is, mm, in the device's frame about the middle of its workspace.
    pub fn position_mm(&self, [a, b, c]: [f64; 3]) -> Vec3 {
        let out = self.length_b_mm * libm::sin(b) + self.length_c_mm * libm::sin(c);
        let up =
            self.length_a_mm + self.length_b_mm * libm::cos(b) - self.length_c_mm * libm::cos(c);
        Vec3::new(libm::cos(a) * out, libm::sin(a) * out, up) - self.origin_mm
    }

    /// How the tip moves with each angle, mm/rad.
    pub fn jacobian_mm(&self, [a, b, c]: [f64; 3]) -> [Vec3; 3] {
        let ahead = Vec3::new(libm::cos(a), libm::sin(a), 0.0);
        let aside = Vec3::new(-libm::sin(a), libm::cos(a), 0.0);
        let (lb, lc) = (self.length_b_mm, self.length_c_mm);
        [
            aside * (lb * libm::sin(b) + lc * libm::sin(c)),
            (ahead * libm::cos(b) - Vec3::Z * libm::sin(b)) * lb,
            (ahead * libm::cos(c) + Vec3::Z * libm::sin(c)) * lc,
        ]
    }

    /// Torques of the bodies that render a force at the tip, N·mm: Jᵀ F.
    pub fn torques_n_mm(&self, angles_rad: [f64; 3], force_n: Vec3) -> [f64; 3] {
        self.jacobian_mm(angles_rad).map(|j| j.dot(force_n))
    }

    /// The force at the tip that torques of the bodies, N·mm, render, N; `None` where the arm is stretched, folded or upright
    /// over its base and cannot render every direction.
    pub fn force_n(&self, angles_rad: [f64; 3], torques_n_mm: [f64; 3]) -> Option<Vec3> {
        // The rows of Jᵀ are the columns of J: F = (τ0 j1×j2 + τ1 j2×j0 + τ2 j0×j1) / det.
        let [j0, j1, j2] = self.jacobian_mm(angles_rad);
        let det = j0.dot(j1.cross(j2));
        let scale = self.length_b_mm * self.length_c_mm * (self.length_b_mm + self.length_c_mm);
        if det.is_nan() || det.abs() <= 1.0e-9 * scale {
            return None;
        }
        let [t0, t1, t2] = torques_n_mm;
        Some((j1.cross(j2) * t0 + j2.cross(j0) * t1 + j0.cross(j1) * t2) / det)
    }

    /// Currents of the motors for torques of the bodies, N·mm: τ · d_capstan / d_body / k_t.
    ///
    /// Where a motor would exceed the limit all are scaled down together, so that the direction of the force is kept. What
    /// is not finite gives no current at all.
    pub fn currents_a(&self, torques_n_mm: [f64; 3]) -> Currents {
        let wanted: [f64; 3] = std::array::from_fn(|i| {
            torques_n_mm[i] / 1000.0 * self.gear(i) / self.torque_constant_n_m_per_a[i]
        });
        if wanted.iter().any(|a| !a.is_finite()) {
            return Currents::default();
        }
        let limit_a = self.current_limit_a.max(0.0);
        let most = wanted.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
        let share = if most > limit_a { limit_a / most } else { 1.0 };
        Currents {
            a: wanted.map(|a| a * share),
            share,
        }
    }

    /// Torques of the bodies, N·mm, that currents of the motors, A, make. The inverse of [`Arm::currents_a`] below the limit.
    pub fn torques_of(&self, currents_a: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| {
            currents_a[i] * self.torque_constant_n_m_per_a[i] / self.gear(i) * 1000.0
        })
    }

    /// Angles of the bodies, rad, with the tip at `position_mm` and the elbow towards the user's far side; `None` out of
    /// reach. For emulators.
    pub fn angles_at(&self, position_mm: Vec3) -> Option<[f64; 3]> {
        let p = position_mm + self.origin_mm;
        let (lb, lc) = (self.length_b_mm, self.length_c_mm);
        let out = libm::hypot(p.x, p.y);
        let up = p.z - self.length_a_mm;
        let reach = libm::hypot(out, up);
        let cos_elbow = (lb * lb + reach * reach - lc * lc) / (2.0 * lb * reach);
        if cos_elbow.is_nan() || cos_elbow.abs() > 1.0 {
            return None;
        }
        // Both links seen from the vertical: B at b, and C, which hangs, at π − c.
        let b = libm::atan2(out, up) - libm::acos(cos_elbow);
        let hanging = libm::atan2(out - lb * libm::sin(b), up - lb * libm::cos(b));
        Some([libm::atan2(p.y, p.x), b, PI - hanging])
    }

    /// How far the tip moves for one count of the coarsest encoder in the middle of the workspace, mm.
    pub fn resolution_mm(&self) -> f64 {
        let Some(angles) = self.angles_at(Vec3::ZERO) else {
            return 0.0;
        };
        let jacobian = self.jacobian_mm(angles);
        (0..3).fold(0.0, |most: f64, i| {
            most.max(jacobian[i].length() * self.rad_per_count(i).abs())
        })
    }
}

/// What the bodies weigh, for holding them up by the motors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gravity {
    /// Mass of B, kg.
    pub mass_b_kg: f64,
    /// Mass of C, kg.
    pub mass_c_kg: f64,
    /// From the axis of B to its centre of mass, mm.
    pub centre_b_mm: f64,
    /// From the axis of C to its centre of mass, mm.
    pub centre_c_mm: f64,
}

/// Standard gravity, m/s².
const G_M_S2: f64 = 9.806_65;

impl Gravity {
    /// Potential energy, N·mm, up to a constant: g (mB (Ln + cB cos B) + mC (Ln + Lb cos B − cC cos C)).
    pub fn energy_n_mm(&self, arm: &Arm, [_, b, c]: [f64; 3]) -> f64 {
        let (cos_b, cos_c) = (libm::cos(b), libm::cos(c));
        let height_b = arm.length_a_mm + self.centre_b_mm * cos_b;
        let height_c = arm.length_a_mm + arm.length_b_mm * cos_b - self.centre_c_mm * cos_c;
        G_M_S2 * (self.mass_b_kg * height_b + self.mass_c_kg * height_c)
    }

    /// Torques of the bodies that hold the arm up, N·mm: the derivative of [`Gravity::energy_n_mm`],
    /// (0, −g (mB cB + mC Lb) sin B, g mC cC sin C).
    ///
    /// Derived from the masses. The published drivers have another term for B, of the other sign and with C's own lever in
    /// place of Lb, and keep it off.
    pub fn torques_n_mm(&self, arm: &Arm, [_, b, c]: [f64; 3]) -> [f64; 3] {
        let lever_b = self.mass_b_kg * self.centre_b_mm + self.mass_c_kg * arm.length_b_mm;
        [
            0.0,
            -G_M_S2 * lever_b * libm::sin(b),
            G_M_S2 * self.mass_c_kg * self.centre_c_mm * libm::sin(c),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::hid::models::{ARMS, Model};
    use proptest::prelude::*;

    fn angles() -> impl Strategy<Value = [f64; 3]> {
        [-1.2..1.2_f64, -0.5..1.2_f64, 0.3..2.2_f64]
    }

    fn arms() -> impl Iterator<Item = Arm> {
        ARMS.iter().map(Model::arm)
    }

    #[test]
    fn the_rest_of_the_published_arm_is_where_its_drawing_has_it() {
        let arm = ARMS[0].arm();
        // B upright, C level: 245 mm ahead of the base and 285 mm over it, less the origin.
        let rest = arm.position_mm([0.0, 0.0, PI / 2.0]);
        assert!((rest - Vec3::new(25.0, 0.0, 205.0)).length() < 1e-12);
        // 6000 counts of motor c, three turns over a gear of 12, are the quarter turn its driver calibrates it at.
        let at = arm.angles_rad([0, 0, 6000]);
        assert!((at[2] - PI / 2.0).abs() < 1e-12, "{at:?}");
        // Encoder a counts down.
        assert!((arm.angles_rad([-2000, 0, 0])[0] - TAU / 16.0).abs() < 1e-12);
    }

    #[test]
    fn an_arm_resolves_a_tenth_of_a_millimetre_or_better() {
        for arm in arms() {
            let step_mm = arm.resolution_mm();
            assert!((0.005..0.1).contains(&step_mm), "{step_mm} mm");
        }
    }

    proptest! {
        #[test]
        fn jacobian_is_the_derivative_of_the_position(q in angles()) {
            for arm in arms() {
                let h = 1e-6;
                for (i, column) in arm.jacobian_mm(q).into_iter().enumerate() {
                    let (mut up, mut down) = (q, q);
                    up[i] += h;
                    down[i] -= h;
                    let slope = (arm.position_mm(up) - arm.position_mm(down)) / (2.0 * h);
                    // Central differences of 300 mm: 1e-10 of rounding and of curvature.
                    prop_assert!((slope - column).length() < 1e-6, "{} {}", slope, column);
                }
            }
        }

        #[test]
        fn gravity_is_the_derivative_of_the_energy(q in angles()) {
            let gravity = ARMS[0].gravity;
            for arm in arms() {
                let h = 1e-5;
                for (i, torque) in gravity.torques_n_mm(&arm, q).into_iter().enumerate() {
                    let (mut up, mut down) = (q, q);
                    up[i] += h;
                    down[i] -= h;
                    let slope = (gravity.energy_n_mm(&arm, up) - gravity.energy_n_mm(&arm, down)) / (2.0 * h);
                    prop_assert!((slope - torque).abs() < 1e-6);
                }
            }
        }

        #[test]
        fn inverse_kinematics_undoes_the_kinematics(q in angles()) {
            for arm in arms() {
                // The elbow is behind the line from the axis to the tip.
                prop_assume!(q[1] + q[2] < PI && q[1] + q[2] > 0.05);
                let p = arm.position_mm(q);
                prop_assume!((p + arm.origin_mm).truncate().length() > 1.0);
                let back = arm.angles_at(p).map(|q| arm.position_mm(q));
                prop_assert!(back.is_some_and(|b| (b - p).length() < 1e-6), "{:?} {}", back, p);
            }
        }

        #[test]
        fn power_of_the_motors_is_power_at_the_tip(
            q in angles(), f in prop::array::uniform3(-5.0..5.0_f64), rate in prop::array::uniform3(-2.0..2.0_f64),
        ) {
            for arm in arms() {
                let f = Vec3::from(f);
                let tip: Vec3 = arm.jacobian_mm(q).into_iter().zip(rate).map(|(j, w)| j * w).sum();
                let torques: f64 = arm.torques_n_mm(q, f).into_iter().zip(rate).map(|(t, w)| t * w).sum();
                prop_assert!((torques - f.dot(tip)).abs() < 1e-8 * (1.0 + f.length() * tip.length()));
            }
        }

        #[test]
        fn currents_render_the_force_or_a_share_of_it_in_its_direction(
            q in angles(), f in prop::array::uniform3(-60.0..60.0_f64),
        ) {
            for arm in arms() {
                let f = Vec3::from(f);
                let currents = arm.currents_a(arm.torques_n_mm(q, f));
                prop_assert!(currents.a.iter().all(|a| a.abs() <= arm.current_limit_a * (1.0 + 1e-12)));
                prop_assert!((0.0..=1.0).contains(&currents.share));
                let Some(got) = arm.force_n(q, arm.torques_of(currents.a)) else { continue };
                prop_assert!((got - f * currents.share).length() < 1e-6 * (1.0 + f.length()), "{} {}", got, f);
            }
        }

        #[test]
        fn counts_come_back_as_they_went(counts in prop::array::uniform3(-30_000..30_000_i32)) {
            for arm in arms() {
                prop_assert_eq!(arm.encoders_at(arm.angles_rad(counts)), counts);
            }
        }

        #[test]
        fn no_number_makes_a_current_beyond_the_limit(t in prop::array::uniform3(prop::num::f64::ANY)) {
            for arm in arms() {
                let got = arm.currents_a(t).a;
                prop_assert!(got.iter().all(|a| a.is_finite() && a.abs() <= arm.current_limit_a * (1.0 + 1e-12)));
            }
        }
    }

    #[test]
    fn where_the_arm_is_stretched_no_force_is_made_up() {
        let arm = ARMS[0].arm();
        assert_eq!(arm.force_n([0.0, 0.5, PI - 0.5], [1.0; 3]), None);
        assert_eq!(arm.angles_at(Vec3::X * 1e6), None);
        assert_eq!(arm.angles_at(Vec3::NAN), None);
    }
}
