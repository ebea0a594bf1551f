//! Reading a device file: TOML with units in the key names, checked down to line and value.

use super::mechanics::MechanicsTable;
use super::{Calibration, FORMAT, Orientation};
use crate::device::MAX_FINGERS;
use crate::device::hid::arm::Gravity;
use crate::device::hid::models::{self, ARMS};
use crate::geom::Vec3;
use serde::Deserialize;
use std::ops::{Range, RangeInclusive};
use toml::Spanned;

/// Why a device file is refused: file, line, key, value and what is allowed, in one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CalibrationError(pub(super) String);

pub(super) type Number = Spanned<f64>;
type Three = Spanned<[f64; 3]>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: Spanned<i64>,
    family: Spanned<String>,
    serial: Option<Spanned<String>>,
    name: Option<Spanned<String>>,
    rated_force_n: Option<Number>,
    max_stiffness_n_per_mm: Option<Number>,
    arm: Option<Spanned<ArmTable>>,
    gravity: Option<Spanned<GravityTable>>,
    rate: Option<Spanned<RateTable>>,
    mechanics: Option<MechanicsTable>,
    guards: Option<GuardsTable>,
    mapping: Option<MappingTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ArmTable {
    model: Option<Spanned<String>>,
    length_a_mm: Option<Number>,
    length_b_mm: Option<Number>,
    length_c_mm: Option<Number>,
    capstan_diameter_mm: Option<Three>,
    body_diameter_mm: Option<Three>,
    origin_mm: Option<Three>,
    workspace_radius_mm: Option<Number>,
    counts_per_turn: Option<Three>,
    encoder_sign: Option<Three>,
    encoder_offset_counts: Option<Three>,
    motor_direction: Option<Three>,
    torque_constant_n_m_per_a: Option<Three>,
    current_limit_a: Option<Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GravityTable {
    mass_b_kg: Number,
    mass_c_kg: Number,
    centre_b_mm: Number,
    centre_c_mm: Number,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RateTable {
    speed_mm_s: Option<Number>,
    dead_zone: Option<Number>,
    exponent: Option<Number>,
    reach_mm: Option<Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GuardsTable {
    command_timeout_ms: Option<Number>,
    silence_ms: Option<Number>,
    frozen_ms: Option<Number>,
    jump_mm: Option<Number>,
    max_speed_mm_s: Option<Number>,
    against_force_mm_s: Option<Number>,
    max_distance_mm: Option<Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MappingTable {
    finger: Option<Spanned<i64>>,
    scale: Option<Number>,
    orientation: Option<Spanned<String>>,
    turn_deg: Option<Three>,
    offset_mm: Option<Three>,
    clutch_button: Option<Spanned<i64>>,
}

const LENGTH_MM: RangeInclusive<f64> = 1.0..=2000.0;
const SHIFT_MM: RangeInclusive<f64> = -2000.0..=2000.0;
const MOST_COUNTS: f64 = 1.0e6;

impl Calibration {
    /// Reads `text`; `origin` names it in errors, and `defaults` tells what a family starts from, `None` for one that there
    /// is not.
    ///
    /// # Errors
    /// The first thing wrong with it.
    pub fn parse(
        text: &str,
        origin: &str,
        defaults: impl Fn(&str) -> Option<Self>,
    ) -> Result<Self, CalibrationError> {
        let check = Check { text, origin };
        let file: File = toml::from_str(text).map_err(|e| check.syntax(&e))?;
        let format = *file.format.get_ref();
        if format != FORMAT {
            let what = format!("format = {format}; this program reads format = {FORMAT}");
            return Err(check.fail(&file.format.span(), what));
        }
        let key = file.family.get_ref();
        let Some(mut out) = defaults(key) else {
            let what = format!("family = {key:?}; \"dorsum devices\" lists those that there are");
            return Err(check.fail(&file.family.span(), what));
        };
        out.serial = check.words("serial", file.serial.as_ref())?;
        out.name = check.words("name", file.name.as_ref())?;
        check.set(
            "rated_force_n",
            &file.rated_force_n,
            0.0..=50.0,
            &mut out.rated_force_n,
        )?;
        let k = &mut out.max_stiffness_n_per_mm;
        check.set(
            "max_stiffness_n_per_mm",
            &file.max_stiffness_n_per_mm,
            0.0..=100.0,
            k,
        )?;
        if let Some(table) = &file.arm {
            check.arm(table, &mut out)?;
        }
        if let Some(table) = &file.gravity {
            check.gravity(table, &mut out)?;
        }
        if let Some(table) = &file.rate {
            check.rate(table, &mut out)?;
        }
        if let Some(table) = &file.mechanics {
            table.read(&check, &mut out.mechanics)?;
        }
        if let Some(table) = &file.guards {
            check.guards(table, &mut out)?;
        }
        if let Some(table) = &file.mapping {
            check.mapping(table, &mut out)?;
        }
        Ok(out)
    }
}

/// Turns what is wrong into one line with file and line number.
pub(super) struct Check<'a> {
    text: &'a str,
    origin: &'a str,
}

type Checked = Result<(), CalibrationError>;

impl Check<'_> {
    fn fail(&self, span: &Range<usize>, what: impl AsRef<str>) -> CalibrationError {
        let before = self.text.bytes().take(span.start);
        let line = 1 + before.filter(|&b| b == b'\n').count();
        let words: Vec<&str> = what.as_ref().split_whitespace().collect();
        CalibrationError(format!("{}: line {line}: {}", self.origin, words.join(" ")))
    }

    /// An error of the TOML reader: syntax, an unknown or missing key, a wrong type.
    fn syntax(&self, e: &toml::de::Error) -> CalibrationError {
        let message = e
            .message()
            .replace("unknown field", "unknown key")
            .replace("missing field", "missing key")
            .replace("expected one of", "allowed are");
        self.fail(&e.span().unwrap_or(0..0), message)
    }

    fn words(
        &self,
        key: &str,
        value: Option<&Spanned<String>>,
    ) -> Result<Option<String>, CalibrationError> {
        let Some(value) = value else { return Ok(None) };
        let text = value.get_ref().trim();
        if text.is_empty() || text.chars().count() > 120 || text.chars().any(char::is_control) {
            let what =
                format!("{key} = {text:?}; 1 to 120 characters without line breaks are allowed");
            return Err(self.fail(&value.span(), what));
        }
        Ok(Some(text.to_owned()))
    }

    pub(super) fn set(
        &self,
        key: &str,
        value: &Option<Number>,
        allowed: RangeInclusive<f64>,
        into: &mut f64,
    ) -> Checked {
        let Some(value) = value else { return Ok(()) };
        *into = self.within(key, *value.get_ref(), &value.span(), &allowed)?;
        Ok(())
    }

    fn set_three(
        &self,
        key: &str,
        value: &Option<Three>,
        allowed: RangeInclusive<f64>,
        into: &mut [f64; 3],
    ) -> Checked {
        let Some(value) = value else { return Ok(()) };
        for (i, &x) in value.get_ref().iter().enumerate() {
            into[i] = self.within(&format!("{key}[{i}]"), x, &value.span(), &allowed)?;
        }
        Ok(())
    }

    fn within(
        &self,
        key: &str,
        x: f64,
        span: &Range<usize>,
        allowed: &RangeInclusive<f64>,
    ) -> Result<f64, CalibrationError> {
        if allowed.contains(&x) {
            return Ok(x);
        }
        let (low, high) = (allowed.start(), allowed.end());
        Err(self.fail(span, format!("{key} = {x}; {low} to {high} is allowed")))
    }

    /// +1 or −1, three times.
    fn signs(&self, key: &str, value: &Option<Three>, into: &mut [f64; 3]) -> Checked {
        let Some(value) = value else { return Ok(()) };
        for (i, &x) in value.get_ref().iter().enumerate() {
            if x != 1.0 && x != -1.0 {
                let what = format!("{key}[{i}] = {x}; allowed are 1 and -1");
                return Err(self.fail(&value.span(), what));
            }
            into[i] = x;
        }
        Ok(())
    }

    fn not_for(&self, span: &Range<usize>, table: &str, family: &str) -> CalibrationError {
        self.fail(
            span,
            format!("[{table}] does not belong to family = {family:?}"),
        )
    }

    fn arm(&self, table: &Spanned<ArmTable>, out: &mut Calibration) -> Checked {
        if out.arm.is_none() {
            return Err(self.not_for(&table.span(), "arm", &out.family));
        }
        let table = table.get_ref();
        if let Some(key) = &table.model {
            let Some(model) = models::by_key(key.get_ref()) else {
                let names: Vec<_> = ARMS.iter().map(|m| format!("{:?}", m.key)).collect();
                let given = key.get_ref();
                let what = format!("model = {given:?}; allowed are {}", names.join(", "));
                return Err(self.fail(&key.span(), what));
            };
            out.arm = Some(model.arm());
        }
        let Some(arm) = &mut out.arm else {
            return Ok(());
        };
        self.set(
            "length_a_mm",
            &table.length_a_mm,
            0.0..=2000.0,
            &mut arm.length_a_mm,
        )?;
        self.set(
            "length_b_mm",
            &table.length_b_mm,
            LENGTH_MM,
            &mut arm.length_b_mm,
        )?;
        self.set(
            "length_c_mm",
            &table.length_c_mm,
            LENGTH_MM,
            &mut arm.length_c_mm,
        )?;
        let diameter = 0.5..=1000.0;
        let (t, a) = (table, arm);
        self.set_three(
            "capstan_diameter_mm",
            &t.capstan_diameter_mm,
            diameter.clone(),
            &mut a.capstan_diameter_mm,
        )?;
        self.set_three(
            "body_diameter_mm",
            &t.body_diameter_mm,
            diameter,
            &mut a.body_diameter_mm,
        )?;
        let mut origin = a.origin_mm.to_array();
        self.set_three("origin_mm", &t.origin_mm, SHIFT_MM, &mut origin)?;
        a.origin_mm = Vec3::from_array(origin);
        self.set(
            "workspace_radius_mm",
            &t.workspace_radius_mm,
            LENGTH_MM,
            &mut a.workspace_radius_mm,
        )?;
        self.set_three(
            "counts_per_turn",
            &t.counts_per_turn,
            1.0..=MOST_COUNTS,
            &mut a.counts_per_turn,
        )?;
        self.signs("encoder_sign", &t.encoder_sign, &mut a.encoder_sign)?;
        let mut offset = a.encoder_offset_counts.map(f64::from);
        self.set_three(
            "encoder_offset_counts",
            &t.encoder_offset_counts,
            -MOST_COUNTS..=MOST_COUNTS,
            &mut offset,
        )?;
        a.encoder_offset_counts = offset.map(|x| libm::round(x) as i32);
        self.signs(
            "motor_direction",
            &t.motor_direction,
            &mut a.motor_direction,
        )?;
        self.set_three(
            "torque_constant_n_m_per_a",
            &t.torque_constant_n_m_per_a,
            1.0e-4..=10.0,
            &mut a.torque_constant_n_m_per_a,
        )?;
        self.set(
            "current_limit_a",
            &t.current_limit_a,
            0.0..=6.0,
            &mut a.current_limit_a,
        )
    }

    fn gravity(&self, table: &Spanned<GravityTable>, out: &mut Calibration) -> Checked {
        if out.arm.is_none() {
            return Err(self.not_for(&table.span(), "gravity", &out.family));
        }
        let t = table.get_ref();
        let number = |key: &str, value: &Number, most: f64| {
            self.within(key, *value.get_ref(), &value.span(), &(0.0..=most))
        };
        out.gravity = Some(Gravity {
            mass_b_kg: number("mass_b_kg", &t.mass_b_kg, 5.0)?,
            mass_c_kg: number("mass_c_kg", &t.mass_c_kg, 5.0)?,
            centre_b_mm: number("centre_b_mm", &t.centre_b_mm, 2000.0)?,
            centre_c_mm: number("centre_c_mm", &t.centre_c_mm, 2000.0)?,
        });
        Ok(())
    }

    fn rate(&self, table: &Spanned<RateTable>, out: &mut Calibration) -> Checked {
        let Some(rate) = &mut out.rate else {
            return Err(self.not_for(&table.span(), "rate", &out.family));
        };
        let t = table.get_ref();
        self.set(
            "speed_mm_s",
            &t.speed_mm_s,
            1.0..=1000.0,
            &mut rate.speed_mm_s,
        )?;
        self.set("dead_zone", &t.dead_zone, 0.0..=0.9, &mut rate.dead_zone)?;
        self.set("exponent", &t.exponent, 1.0..=4.0, &mut rate.exponent)?;
        self.set("reach_mm", &t.reach_mm, LENGTH_MM, &mut rate.reach_mm)
    }

    fn guards(&self, t: &GuardsTable, out: &mut Calibration) -> Checked {
        let g = &mut out.guards;
        let ms = 2.0..=100.0;
        self.set(
            "command_timeout_ms",
            &t.command_timeout_ms,
            ms.clone(),
            &mut g.command_timeout_ms,
        )?;
        self.set("silence_ms", &t.silence_ms, ms.clone(), &mut g.silence_ms)?;
        self.set("frozen_ms", &t.frozen_ms, ms, &mut g.frozen_ms)?;
        self.set("jump_mm", &t.jump_mm, 0.5..=50.0, &mut g.jump_mm)?;
        self.set(
            "max_speed_mm_s",
            &t.max_speed_mm_s,
            100.0..=10_000.0,
            &mut g.max_speed_mm_s,
        )?;
        self.set(
            "against_force_mm_s",
            &t.against_force_mm_s,
            50.0..=10_000.0,
            &mut g.against_force_mm_s,
        )?;
        self.set(
            "max_distance_mm",
            &t.max_distance_mm,
            10.0..=5000.0,
            &mut g.max_distance_mm,
        )
    }

    fn mapping(&self, t: &MappingTable, out: &mut Calibration) -> Checked {
        let m = &mut out.mapping;
        if let Some(finger) = &t.finger {
            let last = MAX_FINGERS as i64 - 1;
            m.finger = self.whole("finger", finger, 0..=last)?;
        }
        self.set("scale", &t.scale, 0.05..=20.0, &mut m.scale)?;
        if let Some(name) = &t.orientation {
            let given = name.get_ref();
            let known = Orientation::ALL.into_iter().find(|o| o.name() == given);
            m.orientation = known.ok_or_else(|| {
                let what = format!("orientation = {given:?}; allowed are \"lying\", \"upright\"");
                self.fail(&name.span(), what)
            })?;
        }
        self.set_three("turn_deg", &t.turn_deg, -360.0..=360.0, &mut m.turn_deg)?;
        let mut offset = m.offset_mm.to_array();
        self.set_three("offset_mm", &t.offset_mm, SHIFT_MM, &mut offset)?;
        m.offset_mm = Vec3::from_array(offset);
        if let Some(button) = &t.clutch_button {
            m.clutch_button = Some(self.whole("clutch_button", button, 1..=32)?);
        }
        Ok(())
    }

    fn whole(
        &self,
        key: &str,
        value: &Spanned<i64>,
        allowed: RangeInclusive<i64>,
    ) -> Result<u8, CalibrationError> {
        let x = *value.get_ref();
        let small = u8::try_from(x).ok().filter(|_| allowed.contains(&x));
        small.ok_or_else(|| {
            let what = format!(
                "{key} = {x}; {} to {} is allowed",
                allowed.start(),
                allowed.end()
            );
            self.fail(&value.span(), what)
        })
    }
}
