//! How stiff a skin a device renders without shaking: four answers side by side.
//!
//! A skin is a spring of stiffness k, read every T seconds; its force is held until the next reading and comes t_d seconds
//! after its own. The device has the damping b and Coulomb friction f, resolves Δ, and its link adds the damping B.
//!
//! | answer | bound | source |
//! |---|---|---|
//! | told | as stated at 1 kHz, in proportion to the rate below it | the maker |
//! | passive | k < (b − \|B\|) / (T/2 + t_d) | Colgate & Schenkel 1997; t_d adds to T/2 in their general condition |
//! | coupled | k < (b + b_hand + B) / (T/2 + t_d) | Gil, Sánchez, Hulin, Preusche & Hirzinger 2009, their linear condition |
//! | quantised | k ≤ min(2b/T, 2f/Δ) | Abbott & Okamura 2005 |
//!
//! A passive device is stable in whatever hand, also in none. The coupled bound needs the damping of a hand; it is that of
//! the loosest one, [`HAND_DAMPING_N_S_PER_MM`]. Its stiffness and mass are left out: the condition holds where k is small
//! beside m/T², as palpation is. Devices that are stable and not passive are many (METHOD 7), so a scene is held against
//! the lower of *told* and *coupled*.

use super::calibration::Calibration;
use super::figures::quantised_stiffness_n_per_mm;
use super::{Capabilities, mapped};
use crate::units::MS_PER_S;

/// Damping of a hand that hardly holds the device, N·s/mm: the lower end for an index finger (Hajian & Howe 1997: a few
/// N·s/m) and for hands on a stylus (Kuchenbecker, Park & Niemeyer 2003), rounded down.
pub const HAND_DAMPING_N_S_PER_MM: f64 = 1.0e-3;

/// The rate that makers state their stiffness at, Hz.
const STATED_AT_HZ: f64 = 1000.0;

/// Highest stiffness on the subject's skin that a device renders, N/mm, by four answers; infinite where nothing bounds it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Stable {
    /// What its maker says, or its device file.
    pub told_n_per_mm: f64,
    /// Passive in any hand (Colgate & Schenkel 1997).
    pub passive_n_per_mm: f64,
    /// Stable with a hand on it (Gil et al. 2009).
    pub coupled_n_per_mm: f64,
    /// Neither sampling nor encoder steps feed energy in (Abbott & Okamura 2005).
    pub quantised_n_per_mm: f64,
}

impl Stable {
    /// The answers for a device whose capabilities are those on the subject ([`mapped::on_subject`], which an open device
    /// states by itself), calibrated so, in a loop of `rate_hz`. A device that reports more slowly is read at its own rate.
    /// Without force, or without a rate, nothing bounds it.
    pub fn of(capabilities: &Capabilities, calibration: &Calibration, rate_hz: f64) -> Self {
        let reports_hz = capabilities.report_rate_hz;
        let rate_hz = if reports_hz > 0.0 {
            rate_hz.min(reports_hz)
        } else {
            rate_hz
        };
        let renders = capabilities.force_axes > 0 && capabilities.rated_force_n > 0.0;
        if !renders || !rate_hz.is_finite() || rate_hz <= 0.0 {
            return Self {
                told_n_per_mm: f64::INFINITY,
                passive_n_per_mm: f64::INFINITY,
                coupled_n_per_mm: f64::INFINITY,
                quantised_n_per_mm: f64::INFINITY,
            };
        }
        let m = &calibration.mechanics;
        let (b, added) = (m.damping_n_s_per_mm, m.virtual_damping_n_s_per_mm);
        let interval_s = 1.0 / rate_hz;
        let lag_s = 0.5 * interval_s + m.delay_ms.max(0.0) / MS_PER_S;
        let bound = |damping: f64| (damping / lag_s).max(0.0);
        let scale = mapped::scale(&calibration.mapping);
        let step_mm = capabilities.resolution_mm / scale;
        let quantised = quantised_stiffness_n_per_mm(b, m.coulomb_n, interval_s, step_mm);
        Self {
            told_n_per_mm: capabilities.max_stiffness_n_per_mm * (rate_hz / STATED_AT_HZ).min(1.0),
            passive_n_per_mm: bound(b - added.abs()) / scale,
            coupled_n_per_mm: bound(b + added + HAND_DAMPING_N_S_PER_MM) / scale,
            quantised_n_per_mm: quantised / scale,
        }
    }

    /// What a scene is held against, N/mm: the lower of what is told and what is stable with a hand on it.
    pub fn rendered_n_per_mm(&self) -> f64 {
        self.told_n_per_mm.min(self.coupled_n_per_mm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::calibration::{Mapping, Mechanics};
    use crate::device::figures::passive_stiffness_n_per_mm;

    fn device(told: f64, step_mm: f64) -> Capabilities {
        Capabilities {
            max_stiffness_n_per_mm: told,
            resolution_mm: step_mm,
            report_rate_hz: 1000.0,
            ..Capabilities::ideal("Device", 5.0)
        }
    }

    fn calibrated(mechanics: Mechanics) -> Calibration {
        Calibration {
            mechanics,
            ..Calibration::plain("woodenhaptics", 5.0, 1.0)
        }
    }

    fn prompt(damping_n_s_per_mm: f64, virtual_damping_n_s_per_mm: f64) -> Mechanics {
        Mechanics {
            delay_ms: 0.0,
            virtual_damping_n_s_per_mm,
            ..Mechanics::assumed(damping_n_s_per_mm, 0.2)
        }
    }

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1.0e-12 * b.abs()
    }

    /// METHOD, section 7: k = 0.5 N/mm at 1 kHz needs 0.25e-3 N·s/mm.
    #[test]
    fn without_a_delay_the_passive_bound_is_that_of_colgate_and_schenkel() {
        for (b, added) in [(0.25e-3, 0.0), (3.0e-3, 1.0e-3), (1.0e-3, 2.0e-3)] {
            let s = Stable::of(&device(9.0, 0.0), &calibrated(prompt(b, added)), 1000.0);
            let closed = passive_stiffness_n_per_mm(b, added, 0.001);
            assert!((s.passive_n_per_mm - closed).abs() < 1e-12, "{b} {added}");
        }
        let s = Stable::of(&device(9.0, 0.0), &calibrated(prompt(0.25e-3, 0.0)), 1000.0);
        assert!(near(s.passive_n_per_mm, 0.5));
    }

    #[test]
    fn a_hand_and_the_motors_damp_and_a_delay_costs() {
        let with = |mechanics| Stable::of(&device(9.0, 0.0), &calibrated(mechanics), 1000.0);
        assert!(near(with(prompt(1.0e-3, 0.0)).coupled_n_per_mm, 4.0));
        assert!(near(with(prompt(1.0e-3, 0.5e-3)).coupled_n_per_mm, 5.0));
        let late = with(Mechanics::assumed(1.0e-3, 0.2));
        assert!(near(late.coupled_n_per_mm, 2.0e-3 / 1.5e-3));
        assert!(near(late.passive_n_per_mm, 1.0e-3 / 1.5e-3));
        assert!(late.passive_n_per_mm < late.coupled_n_per_mm);
    }

    #[test]
    fn encoder_steps_bound_where_friction_is_small() {
        let s = Stable::of(&device(9.0, 0.5), &calibrated(prompt(1.0e-3, 0.0)), 1000.0);
        assert!(near(s.quantised_n_per_mm, 0.8), "2f/Δ");
        let s = Stable::of(&device(9.0, 0.02), &calibrated(prompt(1.0e-3, 0.0)), 1000.0);
        assert!(near(s.quantised_n_per_mm, 2.0), "2b/T");
    }

    #[test]
    fn a_scene_is_held_against_the_lower_of_the_maker_and_the_hand() {
        let c = calibrated(Mechanics::assumed(1.0e-3, 0.2));
        assert!(near(
            Stable::of(&device(1.0, 0.0), &c, 1000.0).rendered_n_per_mm(),
            1.0
        ));
        let high = Stable::of(&device(5.0, 0.0), &c, 1000.0);
        assert!(near(high.rendered_n_per_mm(), high.coupled_n_per_mm));
    }

    #[test]
    fn a_slower_loop_renders_less_and_a_faster_one_no_more_than_the_device_reports() {
        let c = calibrated(prompt(1.0e-3, 0.0));
        let slow = Stable::of(&device(1.0, 0.0), &c, 500.0);
        assert!(near(slow.told_n_per_mm, 0.5) && near(slow.passive_n_per_mm, 1.0));
        let fast = Stable::of(&device(1.0, 0.0), &c, 4000.0);
        assert_eq!(fast, Stable::of(&device(1.0, 0.0), &c, 1000.0));
    }

    /// k on the skin is s k at the device.
    #[test]
    fn a_scaled_finger_bears_less() {
        let plain = calibrated(Mechanics::assumed(1.0e-3, 0.2));
        let mapping = Mapping {
            scale: 2.0,
            ..Mapping::default()
        };
        let wide = Calibration {
            mapping,
            ..plain.clone()
        };
        let theirs = device(1.0, 0.5);
        let a = Stable::of(&theirs, &plain, 1000.0);
        let b = Stable::of(&mapped::on_subject(&theirs, &mapping), &wide, 1000.0);
        assert!(near(b.told_n_per_mm, a.told_n_per_mm / 2.0));
        assert!(near(b.passive_n_per_mm, a.passive_n_per_mm / 2.0));
        assert!(near(b.coupled_n_per_mm, a.coupled_n_per_mm / 2.0));
        assert!(near(b.quantised_n_per_mm, a.quantised_n_per_mm / 2.0));
    }

    #[test]
    fn what_renders_nothing_is_bounded_by_nothing() {
        let none = Capabilities::ideal("Mouse", 0.0);
        let s = Stable::of(&none, &calibrated(Mechanics::default()), 1000.0);
        assert_eq!(s.rendered_n_per_mm(), f64::INFINITY);
        for rate in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let s = Stable::of(&device(1.0, 0.1), &calibrated(Mechanics::default()), rate);
            assert!(!s.rendered_n_per_mm().is_nan(), "{rate}");
        }
    }

    #[test]
    fn every_family_that_renders_force_has_a_bound_of_each_kind() {
        for family in crate::device::all() {
            let c = family.defaults();
            let capabilities = mapped::on_subject(&family.capabilities(&c), &c.mapping);
            let s = Stable::of(&capabilities, &c, 1000.0);
            let answers = [
                s.told_n_per_mm,
                s.passive_n_per_mm,
                s.coupled_n_per_mm,
                s.quantised_n_per_mm,
            ];
            let bounded = answers.iter().all(|k| k.is_finite() && *k > 0.0);
            assert_eq!(bounded, capabilities.force_axes > 0, "{}", family.key());
        }
    }
}
