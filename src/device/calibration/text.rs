//! Writing a device file: every key, with what it is for.

use super::{Calibration, FORMAT};
use crate::geom::Vec3;
use std::fmt::Write as _;

impl Calibration {
    /// The file as text. [`Calibration::parse`] reads the same back.
    pub fn to_toml(&self) -> String {
        let mut out = String::new();
        let mut line = |text: String| {
            // Writing into a string cannot fail.
            let _ = writeln!(out, "{text}");
        };
        line("# One haptic device. Keys left out are as published for its family.".into());
        line(format!("format = {FORMAT}"));
        line(format!("family = {}", quoted(&self.family)));
        if let Some(serial) = &self.serial {
            line(format!("serial = {}", quoted(serial)));
        }
        if let Some(name) = &self.name {
            line(format!("name = {}", quoted(name)));
        }
        line(format!("rated_force_n = {:?}", self.rated_force_n));
        // One that its maker tells nothing of has no bound, and no line.
        if self.max_stiffness_n_per_mm != f64::INFINITY {
            let k = self.max_stiffness_n_per_mm;
            line(format!("max_stiffness_n_per_mm = {k:?}  # at 1 kHz"));
        }
        if let Some(arm) = &self.arm {
            line("\n[arm]  # a: base, b: upright link, c: hanging link".into());
            line(format!("length_a_mm = {:?}", arm.length_a_mm));
            line(format!("length_b_mm = {:?}", arm.length_b_mm));
            line(format!("length_c_mm = {:?}", arm.length_c_mm));
            line(format!(
                "capstan_diameter_mm = {:?}",
                arm.capstan_diameter_mm
            ));
            line(format!("body_diameter_mm = {:?}", arm.body_diameter_mm));
            line(format!(
                "origin_mm = {}  # middle of the workspace",
                three(arm.origin_mm)
            ));
            line(format!(
                "workspace_radius_mm = {:?}",
                arm.workspace_radius_mm
            ));
            line(format!(
                "counts_per_turn = {:?}  # of the motor, four edges",
                arm.counts_per_turn
            ));
            line(format!("encoder_sign = {:?}", arm.encoder_sign));
            let offset = arm.encoder_offset_counts.map(f64::from);
            line(format!(
                "encoder_offset_counts = {offset:?}  # where the encoder says 0"
            ));
            line(format!("motor_direction = {:?}", arm.motor_direction));
            line(format!(
                "torque_constant_n_m_per_a = {:?}",
                arm.torque_constant_n_m_per_a
            ));
            line(format!("current_limit_a = {:?}", arm.current_limit_a));
        }
        if let Some(g) = &self.gravity {
            line("\n[gravity]  # the motors hold these masses up".into());
            line(format!("mass_b_kg = {:?}", g.mass_b_kg));
            line(format!("mass_c_kg = {:?}", g.mass_c_kg));
            line(format!("centre_b_mm = {:?}", g.centre_b_mm));
            line(format!("centre_c_mm = {:?}", g.centre_c_mm));
        }
        if let Some(r) = &self.rate {
            line("\n[rate]".into());
            line(format!(
                "speed_mm_s = {:?}  # at full deflection",
                r.speed_mm_s
            ));
            line(format!(
                "dead_zone = {:?}  # share of the deflection",
                r.dead_zone
            ));
            line(format!("exponent = {:?}", r.exponent));
            line(format!("reach_mm = {:?}", r.reach_mm));
        }
        let d = &self.mechanics;
        line("\n[mechanics]  # at the tip; assumed until measured".into());
        line(format!("damping_n_s_per_mm = {:?}", d.damping_n_s_per_mm));
        line(format!("coulomb_n = {:?}", d.coulomb_n));
        line(format!(
            "delay_ms = {:?}  # from a reading to its force",
            d.delay_ms
        ));
        line(format!(
            "virtual_damping_n_s_per_mm = {:?}  # by the motors, while force is on",
            d.virtual_damping_n_s_per_mm
        ));
        let g = &self.guards;
        line("\n[guards]  # beyond these the force is taken off".into());
        line(format!("command_timeout_ms = {:?}", g.command_timeout_ms));
        line(format!("silence_ms = {:?}", g.silence_ms));
        line(format!("frozen_ms = {:?}", g.frozen_ms));
        line(format!("jump_mm = {:?}", g.jump_mm));
        line(format!("max_speed_mm_s = {:?}", g.max_speed_mm_s));
        line(format!("against_force_mm_s = {:?}", g.against_force_mm_s));
        line(format!("max_distance_mm = {:?}", g.max_distance_mm));
        let m = &self.mapping;
        line("\n[mapping]  # how it is laid over the subject".into());
        line(format!("finger = {}", m.finger));
        line(format!("scale = {:?}", m.scale));
        line(format!(
            "orientation = {}  # or \"upright\", as on the screen",
            quoted(m.orientation.name())
        ));
        line(format!(
            "turn_deg = {:?}  # about the subject's x, y, z",
            m.turn_deg
        ));
        line(format!("offset_mm = {}", three(m.offset_mm)));
        if let Some(button) = m.clutch_button {
            line(format!("clutch_button = {button}"));
        }
        out
    }
}

fn three(v: Vec3) -> String {
    format!("{:?}", v.to_array())
}

fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::calibration::{Orientation, RateControl};
    use crate::device::hid::models::ARMS;
    use proptest::prelude::*;

    fn arm() -> Calibration {
        let mut c = Calibration::plain("woodenhaptics", 5.0, 1.0);
        c.arm = Some(ARMS[0].arm());
        c
    }

    fn defaults(key: &str) -> Option<Calibration> {
        match key {
            "woodenhaptics" => Some(arm()),
            "spacemouse" => {
                let mut c = Calibration::plain("spacemouse", 0.0, f64::INFINITY);
                c.rate = Some(RateControl::default());
                Some(c)
            }
            _ => None,
        }
    }

    fn parse(text: &str) -> Result<Calibration, String> {
        Calibration::parse(text, "arm.toml", defaults).map_err(|e| e.to_string())
    }

    #[test]
    fn every_family_comes_back_as_it_was_written() {
        let mut full = arm();
        full.serial = Some("A \"7\" \\".into());
        full.name = Some("Left arm".into());
        full.gravity = Some(ARMS[0].gravity);
        full.mechanics.damping_n_s_per_mm = 2.5e-3;
        full.mechanics.virtual_damping_n_s_per_mm = 1.0e-3;
        full.mapping.clutch_button = Some(2);
        full.mapping.orientation = Orientation::Upright;
        full.mapping.turn_deg = [1.5, -2.0, 90.0];
        if let Some(arm) = &mut full.arm {
            arm.encoder_offset_counts = [-17, 0, 6000];
        }
        let space = defaults("spacemouse").expect("known");
        for c in [arm(), full, space] {
            assert_eq!(parse(&c.to_toml()), Ok(c));
        }
    }

    #[test]
    fn keys_left_out_are_as_published() {
        assert_eq!(parse("format = 1\nfamily = \"woodenhaptics\"\n"), Ok(arm()));
        let polhem =
            parse("format = 1\nfamily = \"woodenhaptics\"\n[arm]\nmodel = \"polhem-v1\"\n")
                .expect("valid");
        assert_eq!(polhem.arm, Some(ARMS[2].arm()));
    }

    #[test]
    fn each_fault_is_told_with_file_line_key_value_and_what_is_allowed() {
        let head = "format = 1\nfamily = \"woodenhaptics\"\n";
        for (rest, told) in [
            (
                "[arm]\nlength_b = 205.0\n",
                "line 4: unknown key `length_b`, allowed are `model`, `length_a_mm`",
            ),
            (
                "[arm]\nlength_b_mm = 0.0\n",
                "line 4: length_b_mm = 0; 1 to 2000 is allowed",
            ),
            (
                "[arm]\nlength_b_mm = nan\n",
                "line 4: length_b_mm = NaN; 1 to 2000 is allowed",
            ),
            (
                "[arm]\nencoder_sign = [1.0, 2.0, 1.0]\n",
                "line 4: encoder_sign[1] = 2; allowed are 1 and -1",
            ),
            ("[arm]\ncapstan_diameter_mm = [10.0, 10.0]\n", "line 4: "),
            (
                "[arm]\nmodel = \"x\"\n",
                "line 4: model = \"x\"; allowed are \"woodenhaptics\", \"aluhaptics\"",
            ),
            (
                "[arm]\ncurrent_limit_a = 7.0\n",
                "line 4: current_limit_a = 7; 0 to 6 is allowed",
            ),
            (
                "[rate]\nspeed_mm_s = 5.0\n",
                "[rate] does not belong to family = \"woodenhaptics\"",
            ),
            (
                "[mapping]\nfinger = 4\n",
                "line 4: finger = 4; 0 to 3 is allowed",
            ),
            (
                "[mapping]\nclutch_button = 0\n",
                "line 4: clutch_button = 0; 1 to 32 is allowed",
            ),
            (
                "[mapping]\norientation = \"prone\"\n",
                "allowed are \"lying\", \"upright\"",
            ),
            (
                "serial = \"\"\n",
                "line 3: serial = \"\"; 1 to 120 characters",
            ),
            (
                "[mechanics]\ndamping_n_s_per_mm = -1.0\n",
                "line 4: damping_n_s_per_mm = -1; 0 to 0.1 is allowed",
            ),
            (
                "[mechanics]\nfriction_n = 1.0\n",
                "line 4: unknown key `friction_n`, allowed are `damping_n_s_per_mm`",
            ),
            (
                "[guards]\nsilence_ms = 5000.0\n",
                "line 4: silence_ms = 5000; 2 to 100 is allowed",
            ),
        ] {
            let error = parse(&format!("{head}{rest}")).expect_err(rest);
            assert!(
                error.starts_with("arm.toml: line ") && error.contains(told),
                "{error}"
            );
            assert!(!error.contains('\n'), "{error}");
        }
        let error = parse("format = 2\nfamily = \"woodenhaptics\"\n").expect_err("format");
        assert!(
            error.contains("format = 2; this program reads format = 1"),
            "{error}"
        );
        let error = parse("format = 1\nfamily = \"theremin\"\n").expect_err("family");
        assert!(error.contains("line 2: family = \"theremin\""), "{error}");
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused_in_one_line(rest in "[\\[\\]a-z_=\\. 0-9\"\n-]{0,80}") {
            if let Err(e) = parse(&format!("format = 1\nfamily = \"woodenhaptics\"\n{rest}")) {
                prop_assert!(!e.contains('\n'));
            }
        }
    }
}
