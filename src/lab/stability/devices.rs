//! Which devices are held against the limits.

use super::plant::{Hand, Plant};
use crate::servo::Limits;

/// A device: what its maker says, and what is assumed of its mechanics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Haptic {
    /// Name.
    pub name: &'static str,
    /// Highest force, N, as the maker says.
    pub rated_force_n: f64,
    /// Highest stiffness at 1 kHz, N/mm, as the maker says.
    pub stiffness_n_per_mm: f64,
    /// Apparent mass at the tip, kg. Assumed.
    pub mass_kg: f64,
    /// Viscous damping, N·s/mm. Assumed.
    pub damping_n_s_per_mm: f64,
    /// Coulomb friction, N. Assumed.
    pub coulomb_n: f64,
    /// Encoder step at the tip, mm. Assumed.
    pub quantum_mm: f64,
}

impl Haptic {
    const fn new(name: &'static str, told: [f64; 2], assumed: [f64; 4]) -> Self {
        Self {
            name,
            rated_force_n: told[0],
            stiffness_n_per_mm: told[1],
            mass_kg: assumed[0],
            damping_n_s_per_mm: assumed[1],
            coulomb_n: assumed[2],
            quantum_mm: assumed[3],
        }
    }

    /// The device in a hand that wants to be `AIM_MM` within the skin; one that nobody holds is pushed in by
    /// `PUSH_N`.
    pub fn held_by(&self, hand: &Hand) -> Plant {
        let push_n = if hand.stiffness_n_per_mm > 0.0 {
            -hand.stiffness_n_per_mm * AIM_MM
        } else {
            -PUSH_N
        };
        Plant {
            mass_kg: self.mass_kg + hand.mass_kg,
            damping_n_s_per_mm: self.damping_n_s_per_mm + hand.damping_n_s_per_mm,
            stiffness_n_per_mm: hand.stiffness_n_per_mm,
            push_n,
            coulomb_n: self.coulomb_n,
        }
    }

    /// The limits that the servo gives it.
    pub fn limits(&self) -> Limits {
        Limits {
            rated_force_n: self.rated_force_n,
            rise_n_per_s: self.rated_force_n / 0.005,
            ..Limits::default()
        }
    }
}

/// How deep within the skin a hand wants to be, mm.
const AIM_MM: f64 = 5.0;
/// What pushes a device that nobody holds, N.
const PUSH_N: f64 = 1.0;

/// A device without Coulomb friction, encoder steps and limits, in size one that sits on a desk: the linear one that theory
/// speaks of.
pub const LINEAR: Haptic = Haptic::new(
    "linear device",
    [f64::INFINITY, f64::INFINITY],
    [0.075, 2.0e-3, 0.0, 0.0],
);

/// Devices of the field. Force and stiffness are the makers'; mass, damping, friction and encoder step are assumed, to one
/// digit or two: data sheets name some of them for some devices, and damping for none.
pub const DEVICES: [Haptic; 8] = [
    Haptic::new("Touch", [3.3, 0.4], [0.045, 5.0e-4, 0.26, 0.055]),
    Haptic::new("Omni", [3.3, 0.7], [0.045, 5.0e-4, 0.26, 0.055]),
    Haptic::new("Premium 1.5", [8.5, 0.8], [0.075, 5.0e-4, 0.04, 0.03]),
    Haptic::new("Premium 3.0", [22.0, 1.0], [0.15, 1.0e-3, 0.2, 0.02]),
    Haptic::new("Falcon", [8.0, 3.0], [0.2, 3.0e-3, 0.4, 0.06]),
    Haptic::new("omega.3", [12.0, 5.0], [0.2, 3.0e-3, 0.1, 0.01]),
    Haptic::new("delta.3", [20.0, 5.0], [0.25, 3.0e-3, 0.2, 0.02]),
    Haptic::new("WoodenHaptics", [5.0, 1.0], [0.15, 1.0e-3, 0.15, 0.02]),
];
