//! What a device does to a motion by itself, and what its link adds: what decides how stiff a skin it renders.

use super::CalibrationError;
use super::file::{Check, Number};
use serde::Deserialize;

/// Damping, friction and delay of a device, at its tip.
///
/// Data sheets name friction for some devices and damping for none: what families start from is assumed, to one digit or
/// two, and the same as `dorsum lab stability` holds its devices to. A device file states what was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mechanics {
    /// Viscous damping of the device by itself, N·s/mm.
    pub damping_n_s_per_mm: f64,
    /// Coulomb friction, N.
    pub coulomb_n: f64,
    /// From a reading to the force that answers it, beyond the hold of a tick, ms.
    pub delay_ms: f64,
    /// Damping that the link adds by the motors while force is on, N·s/mm.
    pub virtual_damping_n_s_per_mm: f64,
}

impl Default for Mechanics {
    /// A light arm on a desk, a report away, without damping by its motors.
    fn default() -> Self {
        Self::assumed(5.0e-4, 0.1)
    }
}

impl Mechanics {
    /// A device with this damping, N·s/mm, and Coulomb friction, N; its force comes one report after the reading.
    pub const fn assumed(damping_n_s_per_mm: f64, coulomb_n: f64) -> Self {
        Self {
            damping_n_s_per_mm,
            coulomb_n,
            delay_ms: 1.0,
            virtual_damping_n_s_per_mm: 0.0,
        }
    }
}

/// `[mechanics]` of a device file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MechanicsTable {
    damping_n_s_per_mm: Option<Number>,
    coulomb_n: Option<Number>,
    delay_ms: Option<Number>,
    virtual_damping_n_s_per_mm: Option<Number>,
}

impl MechanicsTable {
    pub(super) fn read(
        &self,
        check: &Check<'_>,
        out: &mut Mechanics,
    ) -> Result<(), CalibrationError> {
        let b = &mut out.damping_n_s_per_mm;
        check.set("damping_n_s_per_mm", &self.damping_n_s_per_mm, 0.0..=0.1, b)?;
        check.set("coulomb_n", &self.coulomb_n, 0.0..=10.0, &mut out.coulomb_n)?;
        check.set("delay_ms", &self.delay_ms, 0.0..=100.0, &mut out.delay_ms)?;
        check.set(
            "virtual_damping_n_s_per_mm",
            &self.virtual_damping_n_s_per_mm,
            0.0..=0.02,
            &mut out.virtual_damping_n_s_per_mm,
        )
    }
}
