//! What of the servo's order goes out to the device: no clock, no wire.

use crate::geom::Vec3;

/// How long gravity compensation and virtual damping take to come in once force flows, s: an arm is picked up, not thrown.
pub const COMING_IN_S: f64 = 0.2;

/// What the servo wants, as the link finds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// Force output is switched on.
    pub on: bool,
    /// How old the order is, s; infinite where there is none.
    pub age_s: f64,
    /// The force, N, in the device's frame.
    pub force_n: Vec3,
}

/// What goes out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sent {
    /// The force, N: finite, within the rated force.
    pub force_n: Vec3,
    /// Share of what the motors do besides, 0 … 1.
    pub share: f64,
}

/// The last step before the driver.
#[derive(Clone, Copy, Debug)]
pub struct Output {
    rated_force_n: f64,
    timeout_s: f64,
    damping_n_s_per_mm: f64,
    since_s: Option<f64>,
}

impl Output {
    /// For a device of this rated force, N, whose servo must speak at least every `timeout_s`, and whose motors add this
    /// damping, N·s/mm.
    pub fn new(rated_force_n: f64, timeout_s: f64, damping_n_s_per_mm: f64) -> Self {
        Self {
            rated_force_n: rated_force_n.max(0.0),
            timeout_s,
            damping_n_s_per_mm: damping_n_s_per_mm.max(0.0),
            since_s: None,
        }
    }

    /// What goes out at `now_s`; `None`: no current at all. That is so while force is switched off, while the guard does not
    /// let it, when the servo has not spoken lately, and for a force that is none.
    pub fn at(
        &mut self,
        now_s: f64,
        asked: &Asked,
        may_push: bool,
        velocity_mm_s: Vec3,
    ) -> Option<Sent> {
        let flows =
            asked.on && may_push && asked.age_s <= self.timeout_s && asked.force_n.is_finite();
        if !flows {
            self.since_s = None;
            return None;
        }
        let since_s = *self.since_s.get_or_insert(now_s);
        let share = (now_s - since_s) / COMING_IN_S;
        let share = if share.is_nan() {
            0.0
        } else {
            share.clamp(0.0, 1.0)
        };
        let braked_n = velocity_mm_s * (self.damping_n_s_per_mm * share);
        let braked_n = if braked_n.is_finite() {
            braked_n
        } else {
            Vec3::ZERO
        };
        let force_n = (asked.force_n - braked_n).clamp_length_max(self.rated_force_n);
        // So large that its length is none.
        let force_n = Some(force_n).filter(|f| f.is_finite())?;
        Some(Sent { force_n, share })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ASKED: Asked = Asked {
        on: true,
        age_s: 0.001,
        force_n: Vec3::new(1.0, 2.0, -2.0),
    };

    fn output() -> Output {
        Output::new(5.0, 0.010, 0.001)
    }

    #[test]
    fn an_order_of_a_good_device_goes_out_as_it_is() {
        let sent = output().at(3.0, &ASKED, true, Vec3::ZERO).expect("flows");
        assert_eq!(sent.force_n, ASKED.force_n);
    }

    #[test]
    fn each_reason_by_itself_takes_everything_off() {
        let asked = |change: fn(&mut Asked)| {
            let mut asked = ASKED;
            change(&mut asked);
            asked
        };
        for (what, asked, may_push) in [
            ("switched off", asked(|a| a.on = false), true),
            ("an order too old", asked(|a| a.age_s = 0.0101), true),
            ("no order", asked(|a| a.age_s = f64::INFINITY), true),
            ("no time", asked(|a| a.age_s = f64::NAN), true),
            ("no force", asked(|a| a.force_n = Vec3::NAN), true),
            ("infinite", asked(|a| a.force_n.x = f64::INFINITY), true),
            ("a guard that does not let it", ASKED, false),
        ] {
            assert_eq!(
                output().at(0.0, &asked, may_push, Vec3::ONE),
                None,
                "{what}"
            );
        }
    }

    #[test]
    fn what_the_motors_do_besides_comes_in_slowly_each_time() {
        let mut output = output();
        let mut share = |now_s: f64, on: bool| {
            let asked = Asked { on, ..ASKED };
            output.at(now_s, &asked, true, Vec3::ZERO).map(|s| s.share)
        };
        assert_eq!(share(1.0, true), Some(0.0));
        let half = share(1.1, true).expect("flows");
        assert!((half - 0.5).abs() < 1e-12);
        assert_eq!(share(1.3, true), Some(1.0));
        assert_eq!(share(1.4, false), None);
        assert_eq!(share(1.5, true), Some(0.0));
    }

    #[test]
    fn damping_is_against_the_motion_and_within_the_rated_force() {
        let mut output = output();
        let still = Asked {
            force_n: Vec3::ZERO,
            ..ASKED
        };
        output.at(0.0, &still, true, Vec3::ZERO);
        let sent = output
            .at(1.0, &still, true, Vec3::X * 200.0)
            .expect("flows");
        assert!((sent.force_n + Vec3::X * 0.2).length() < 1e-12);
        let sent = output
            .at(1.0, &still, true, Vec3::X * 2.0e9)
            .expect("flows");
        assert!((sent.force_n + Vec3::X * 5.0).length() < 1e-9);
        let sent = output.at(1.0, &ASKED, true, Vec3::NAN).expect("flows");
        assert_eq!(sent.force_n, ASKED.force_n);
    }

    proptest! {
        #[test]
        fn whatever_is_asked_what_goes_out_is_finite_and_within_the_rated_force(
            force in prop::array::uniform3(prop::num::f64::ANY), velocity in prop::array::uniform3(prop::num::f64::ANY),
            now in prop::num::f64::ANY, age in prop::num::f64::ANY, rated in 0.0..50.0_f64,
        ) {
            let mut output = Output::new(rated, 0.01, 0.02);
            output.at(0.0, &ASKED, true, Vec3::ZERO);
            let asked = Asked { on: true, age_s: age, force_n: Vec3::from(force) };
            if let Some(sent) = output.at(now, &asked, true, Vec3::from(velocity)) {
                prop_assert!(sent.force_n.is_finite() && sent.force_n.length() <= rated * (1.0 + 1e-12));
                prop_assert!((0.0..=1.0).contains(&sent.share));
            }
        }
    }
}
