//! Arms as their makers published them: the constants that a device file starts from.

use super::arm::{Arm, Gravity};
use crate::geom::Vec3;

/// An arm as published.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// Name in device files.
    pub key: &'static str,
    /// Name shown to people.
    pub title: &'static str,
    /// Ln, Lb, Lc, mm.
    lengths_mm: [f64; 3],
    capstan_mm: [f64; 3],
    body_mm: [f64; 3],
    origin_mm: [f64; 3],
    torque_constant: [f64; 3],
    counts_per_turn: f64,
    encoder_sign: [f64; 3],
    motor_direction: [f64; 3],
    encoder_offset: [i32; 3],
    /// As stated; the smaller arms reach about half of it everywhere.
    workspace_radius_mm: f64,
    /// Highest force, N.
    pub rated_force_n: f64,
    /// Highest stiffness at 1 kHz, N/mm.
    pub max_stiffness_n_per_mm: f64,
    /// Masses and their levers. The drivers state them and do not use them unless asked.
    pub gravity: Gravity,
}

impl Model {
    /// Its geometry and motors.
    pub fn arm(&self) -> Arm {
        Arm {
            length_a_mm: self.lengths_mm[0],
            length_b_mm: self.lengths_mm[1],
            length_c_mm: self.lengths_mm[2],
            capstan_diameter_mm: self.capstan_mm,
            body_diameter_mm: self.body_mm,
            origin_mm: Vec3::from_array(self.origin_mm),
            workspace_radius_mm: self.workspace_radius_mm,
            counts_per_turn: [self.counts_per_turn; 3],
            encoder_sign: self.encoder_sign,
            encoder_offset_counts: self.encoder_offset,
            motor_direction: self.motor_direction,
            torque_constant_n_m_per_a: self.torque_constant,
            current_limit_a: 3.0,
        }
    }
}

const fn gravity(masses_kg: [f64; 2], centres_mm: [f64; 2]) -> Gravity {
    Gravity {
        mass_b_kg: masses_kg[0],
        mass_c_kg: masses_kg[1],
        centre_b_mm: centres_mm[0],
        centre_c_mm: centres_mm[1],
    }
}

/// The arms known, as the constants of the published drivers have them; mm where those have m.
pub static ARMS: [Model; 4] = [
    Model {
        key: "woodenhaptics",
        title: "WoodenHaptics",
        lengths_mm: [80.0, 205.0, 245.0],
        capstan_mm: [10.0; 3],
        body_mm: [160.0, 120.0, 120.0],
        origin_mm: [220.0, 0.0, 80.0],
        torque_constant: [0.0259; 3],
        counts_per_turn: 2000.0,
        encoder_sign: [-1.0, 1.0, 1.0],
        motor_direction: [1.0; 3],
        encoder_offset: [0; 3],
        workspace_radius_mm: 100.0,
        rated_force_n: 5.0,
        max_stiffness_n_per_mm: 1.0,
        gravity: gravity([0.170, 0.110], [51.0, 91.0]),
    },
    Model {
        key: "aluhaptics",
        title: "AluHaptics",
        lengths_mm: [111.0, 140.0, 111.0],
        capstan_mm: [13.8, 9.8, 9.8],
        body_mm: [116.0, 76.0, 76.0],
        origin_mm: [140.0, 0.0, 0.0],
        torque_constant: [0.0259; 3],
        counts_per_turn: 2000.0,
        encoder_sign: [1.0; 3],
        motor_direction: [1.0; 3],
        encoder_offset: [0; 3],
        workspace_radius_mm: 100.0,
        rated_force_n: 5.0,
        max_stiffness_n_per_mm: 1.0,
        gravity: gravity([0.170, 0.110], [51.0, 91.0]),
    },
    Model {
        key: "polhem-v1",
        title: "Polhem v1",
        lengths_mm: [58.0, 174.0, 133.0],
        capstan_mm: [10.0; 3],
        body_mm: [180.0, 100.0, 100.0],
        origin_mm: [140.0, 0.0, 100.0],
        torque_constant: [0.0538; 3],
        counts_per_turn: 2000.0,
        encoder_sign: [1.0; 3],
        motor_direction: [-1.0; 3],
        encoder_offset: [0; 3],
        workspace_radius_mm: 100.0,
        rated_force_n: 5.0,
        max_stiffness_n_per_mm: 0.8,
        gravity: gravity([0.080, 0.080], [40.0, 70.0]),
    },
    Model {
        key: "vintage",
        title: "WoodenHaptics vintage",
        lengths_mm: [56.0, 138.0, 112.0],
        capstan_mm: [13.0, 10.0, 10.0],
        body_mm: [117.0, 77.0, 77.0],
        origin_mm: [140.0, 0.0, 0.0],
        torque_constant: [0.0163; 3],
        counts_per_turn: 4000.0,
        encoder_sign: [1.0; 3],
        motor_direction: [1.0; 3],
        encoder_offset: [0; 3],
        workspace_radius_mm: 100.0,
        rated_force_n: 5.0,
        max_stiffness_n_per_mm: 0.8,
        gravity: gravity([0.170, 0.110], [51.0, 91.0]),
    },
];

/// The arm called `key`.
pub fn by_key(key: &str) -> Option<&'static Model> {
    ARMS.iter().find(|m| m.key == key)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::figures;

    /// The sphere of 100 mm that all state is wholly within reach of the largest only.
    #[test]
    fn every_arm_reaches_its_workspace_the_small_ones_half_of_it() {
        for (model, share) in ARMS.iter().zip([0.9, 0.5, 0.5, 0.5]) {
            let arm = model.arm();
            let r = model.workspace_radius_mm * share;
            for i in 0..26 {
                let at = |k: i32| f64::from(k % 3 - 1);
                let way = Vec3::new(at(i), at(i / 3), at(i / 9));
                let at_mm = crate::geom::unit_or(way, Vec3::X) * r;
                assert!(arm.angles_at(at_mm).is_some(), "{} at {at_mm}", model.key);
            }
        }
    }

    #[test]
    fn woodenhaptics_has_its_published_figures() {
        let figures = figures::of("WoodenHaptics").expect("in the table");
        let model = &ARMS[0];
        assert_eq!(model.rated_force_n, figures.rated_force_n);
        assert_eq!(model.max_stiffness_n_per_mm, figures.max_stiffness_n_per_mm);
        assert_eq!(model.arm().workspace_radius_mm, figures.workspace_radius_mm);
    }
}
