//! The numbers of a calibration with their units and what is allowed, and a calibration that is being edited.

use crate::device::{self, Calibration, calibration};
use crate::geom::Vec3;
use std::ops::RangeInclusive;

/// Which part of the form a number is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Force and stiffness.
    Force,
    /// How it is laid over the subject.
    Mapping,
    /// How a deflection becomes a speed.
    Rate,
    /// What takes the force off.
    Guards,
    /// What it does to a motion by itself.
    Mechanics,
    /// Encoders and motors of an arm.
    Arm,
}

/// A number of a calibration.
pub struct Field {
    /// Which part of the form it is in.
    pub group: Group,
    /// What it is.
    pub name: &'static str,
    /// What it is for.
    pub why: &'static str,
    /// Its unit; empty for a plain number.
    pub unit: &'static str,
    /// What the device file allows.
    pub range: RangeInclusive<f64>,
    /// Decimals shown.
    pub decimals: usize,
    /// Change per point of a drag.
    pub speed: f64,
    /// Reads it.
    pub get: fn(&Calibration) -> f64,
    /// Writes it.
    pub set: fn(&mut Calibration, f64),
}

/// A field whose place in the calibration is the same for reading and for writing.
macro_rules! field {
    ($group:ident, $name:literal, $why:literal, $unit:literal, $range:expr, $decimals:literal, $speed:literal, $($place:ident).+) => {
        Field {
            group: Group::$group,
            name: $name,
            why: $why,
            unit: $unit,
            range: $range,
            decimals: $decimals,
            speed: $speed,
            get: |c| c.$($place).+,
            set: |c, x| c.$($place).+ = x,
        }
    };
}

/// One of three numbers of an arm, which not every device has.
macro_rules! arm {
    ($name:literal, $why:literal, $i:literal) => {
        Field {
            group: Group::Arm,
            name: $name,
            why: $why,
            unit: "counts",
            range: -1.0e6..=1.0e6,
            decimals: 0,
            speed: 1.0,
            get: |c| {
                c.arm
                    .as_ref()
                    .map_or(0.0, |a| f64::from(a.encoder_offset_counts[$i]))
            },
            set: |c, x| {
                if let Some(arm) = &mut c.arm {
                    arm.encoder_offset_counts[$i] = libm::round(x) as i32;
                }
            },
        }
    };
}

macro_rules! rate {
    ($name:literal, $why:literal, $unit:literal, $range:expr, $decimals:literal, $speed:literal, $place:ident) => {
        Field {
            group: Group::Rate,
            name: $name,
            why: $why,
            unit: $unit,
            range: $range,
            decimals: $decimals,
            speed: $speed,
            get: |c| c.rate.map_or(0.0, |r| r.$place),
            set: |c, x| {
                if let Some(rate) = &mut c.rate {
                    rate.$place = x;
                }
            },
        }
    };
}

macro_rules! three {
    ($name:literal, $why:literal, $i:literal) => {
        Field {
            group: Group::Mapping,
            name: $name,
            why: $why,
            unit: "°",
            range: -360.0..=360.0,
            decimals: 1,
            speed: 0.5,
            get: |c| c.mapping.turn_deg[$i],
            set: |c, x| c.mapping.turn_deg[$i] = x,
        }
    };
}

macro_rules! offset {
    ($name:literal, $why:literal, $i:literal) => {
        Field {
            group: Group::Mapping,
            name: $name,
            why: $why,
            unit: "mm",
            range: -2000.0..=2000.0,
            decimals: 1,
            speed: 0.5,
            get: |c| c.mapping.offset_mm[$i],
            set: |c, x| {
                let mut offset: [f64; 3] = c.mapping.offset_mm.to_array();
                offset[$i] = x;
                c.mapping.offset_mm = Vec3::from_array(offset);
            },
        }
    };
}

/// Every number, in the order of the form.
#[rustfmt::skip]
pub static FIELDS: [Field; 28] = [
    field!(Force, "Rated force", "Highest force that it is ever told to render", "N", 0.0..=50.0, 2, 0.02, rated_force_n),
    field!(Force, "Highest stiffness", "Highest stiffness that it renders at 1 kHz, as its maker says", "N/mm", 0.0..=100.0, 2, 0.01, max_stiffness_n_per_mm),
    field!(Mapping, "Scale", "Motion of the finger for motion of the device", "×", 0.05..=20.0, 2, 0.01, mapping.scale),
    three!("Turn about x", "After the orientation, first of three", 0),
    three!("Turn about y", "After the turn about x", 1),
    three!("Turn about z", "After the turn about y", 2),
    offset!("Middle x", "Where the middle of its workspace lies, to the subject's right", 0),
    offset!("Middle y", "Where the middle of its workspace lies, towards the head", 1),
    offset!("Middle z", "Where the middle of its workspace lies, out of the back", 2),
    rate!("Speed", "Speed of the finger at full deflection", "mm/s", 1.0..=1000.0, 0, 1.0, speed_mm_s),
    rate!("Dead zone", "Share of the deflection that is taken for rest", "", 0.0..=0.9, 2, 0.005, dead_zone),
    rate!("Exponent", "1 is proportional, 2 gentler near rest", "", 1.0..=4.0, 2, 0.01, exponent),
    rate!("Reach", "Farthest from the middle that the finger goes", "mm", 1.0..=2000.0, 0, 1.0, reach_mm),
    field!(Guards, "Command timeout", "No new force from the servo for this long: no current", "ms", 2.0..=100.0, 1, 0.2, guards.command_timeout_ms),
    field!(Guards, "Silence", "No report for this long: it does not answer", "ms", 2.0..=100.0, 1, 0.2, guards.silence_ms),
    field!(Guards, "Repetition", "Reports that stand still for this long: it repeats itself", "ms", 2.0..=100.0, 1, 0.2, guards.frozen_ms),
    field!(Guards, "Jump", "A step between two reports beyond this, and beyond what the highest speed allows, is a fault", "mm", 0.5..=50.0, 1, 0.1, guards.jump_mm),
    field!(Guards, "Highest speed", "Motion faster than this is a fault", "mm/s", 100.0..=10_000.0, 0, 10.0, guards.max_speed_mm_s),
    field!(Guards, "Speed against force", "Motion faster than this against half the rated force is a fault: an axis may be reversed", "mm/s", 50.0..=10_000.0, 0, 5.0, guards.against_force_mm_s),
    field!(Guards, "Farthest place", "A place farther from the middle of its workspace is a fault", "mm", 10.0..=5000.0, 0, 2.0, guards.max_distance_mm),
    field!(Mechanics, "Damping", "Viscous damping of the device by itself", "N·s/mm", 0.0..=0.1, 5, 0.00002, mechanics.damping_n_s_per_mm),
    field!(Mechanics, "Friction", "Coulomb friction at its tip", "N", 0.0..=10.0, 2, 0.01, mechanics.coulomb_n),
    field!(Mechanics, "Delay", "From a reading to the force that answers it, beyond the hold of a tick", "ms", 0.0..=100.0, 2, 0.02, mechanics.delay_ms),
    field!(Mechanics, "Virtual damping", "Damping that the motors add while force is on: calmer skin, heavier arm", "N·s/mm", 0.0..=0.02, 5, 0.00001, mechanics.virtual_damping_n_s_per_mm),
    arm!("Home of a", "Count of motor a where its encoder says 0", 0),
    arm!("Home of b", "Count of motor b where its encoder says 0", 1),
    arm!("Home of c", "Count of motor c where its encoder says 0", 2),
    Field {
        group: Group::Arm,
        name: "Current limit",
        why: "Largest current of a motor",
        unit: "A",
        range: 0.0..=6.0,
        decimals: 2,
        speed: 0.02,
        get: |c| c.arm.as_ref().map_or(0.0, |a| a.current_limit_a),
        set: |c, x| {
            if let Some(arm) = &mut c.arm {
                arm.current_limit_a = x;
            }
        },
    },
];

/// Whether a part of the form is there for this calibration.
pub fn applies(group: Group, c: &Calibration, has_force: bool) -> bool {
    match group {
        Group::Force | Group::Mechanics => has_force,
        Group::Rate => c.rate.is_some(),
        Group::Arm => c.arm.is_some(),
        Group::Mapping | Group::Guards => true,
    }
}

/// A calibration that is being edited.
#[derive(Clone, Debug, PartialEq)]
pub struct Draft {
    /// What the device has.
    base: Calibration,
    /// What it is to have.
    pub now: Calibration,
}

impl Draft {
    /// A draft that is not edited yet, for the one device that tells this serial number, if it tells one: its file may be
    /// that of its family so far.
    pub fn new(base: &Calibration, serial: Option<&str>) -> Self {
        let mut base = base.clone();
        base.serial = serial.map(Into::into);
        Self {
            now: base.clone(),
            base,
        }
    }

    /// Whether anything differs from what the device has.
    pub fn is_edited(&self) -> bool {
        self.now != self.base
    }

    /// What the device has by now; follows it unless edited.
    pub fn follow(&mut self, base: &Calibration) {
        let base = Self::new(base, self.base.serial.as_deref()).base;
        if base != self.base {
            if !self.is_edited() {
                self.now.clone_from(&base);
            }
            self.base = base;
        }
    }

    /// Back to what the device has.
    pub fn revert(&mut self) {
        self.now = self.base.clone();
    }

    /// What its device file would be refused for, in a line.
    pub fn wrong(&self) -> Option<String> {
        let known = |key: &str| device::by_key(key).map(|f| f.defaults());
        let text = self.now.to_toml();
        let file = calibration::file_name(&self.now.family, self.now.serial.as_deref());
        let error = Calibration::parse(&text, &file, known).err()?;
        Some(error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arm() -> Calibration {
        device::by_key("woodenhaptics").expect("listed").defaults()
    }

    /// A calibration of a family that has this field.
    fn with(field: &Field) -> Calibration {
        let key = if field.group == Group::Rate {
            "spacemouse"
        } else {
            "woodenhaptics"
        };
        device::by_key(key).expect("listed").defaults()
    }

    #[test]
    fn the_form_allows_what_the_device_file_allows_and_no_more() {
        for field in &FIELDS {
            let mut draft = Draft::new(&with(field), None);
            let (low, high) = (*field.range.start(), *field.range.end());
            for x in [low, high] {
                (field.set)(&mut draft.now, x);
                assert_eq!((field.get)(&draft.now), x, "{}", field.name);
                assert_eq!(draft.wrong(), None, "{} = {x}", field.name);
            }
            let beyond = 1.0e-3 * (high - low).max(1000.0);
            for x in [low - beyond, high + beyond] {
                (field.set)(&mut draft.now, x);
                let wrong = draft.wrong().unwrap_or_default();
                assert!(
                    wrong.contains("is allowed"),
                    "{} = {x}: {wrong}",
                    field.name
                );
                assert!(!wrong.contains('\n'));
            }
        }
    }

    #[test]
    fn what_is_no_number_is_refused_in_one_line() {
        // Counts are whole numbers: they can be nothing else.
        for field in FIELDS.iter().filter(|f| f.unit != "counts") {
            for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                if x > 0.0 && field.name == "Highest stiffness" {
                    // Its maker tells none.
                    continue;
                }
                let mut draft = Draft::new(&with(field), None);
                (field.set)(&mut draft.now, x);
                let wrong = draft.wrong().unwrap_or_default();
                assert!(!wrong.is_empty(), "{} = {x}", field.name);
                assert!(!wrong.contains('\n'), "{wrong}");
            }
        }
    }

    #[test]
    fn every_number_has_a_name_of_its_own_and_moves_nothing_else() {
        for (i, field) in FIELDS.iter().enumerate() {
            assert!(FIELDS[..i].iter().all(|f| f.name != field.name));
            let base = with(field);
            let mut now = base.clone();
            let x = 0.5 * (field.range.start() + field.range.end()) + 1.0;
            let x = x.clamp(*field.range.start(), *field.range.end());
            (field.set)(&mut now, x);
            let moved = FIELDS.iter().filter(|f| (f.get)(&now) != (f.get)(&base));
            assert!(moved.count() <= 1, "{}", field.name);
            (field.set)(&mut now, (field.get)(&base));
            assert_eq!(now, base, "{}", field.name);
        }
    }

    #[test]
    fn a_draft_follows_its_device_until_it_is_edited() {
        let mut draft = Draft::new(&arm(), None);
        let mut other = arm();
        other.mapping.scale = 2.0;
        draft.follow(&other);
        assert!(!draft.is_edited() && draft.now.mapping.scale == 2.0);
        draft.now.rated_force_n = 3.0;
        let mut third = other.clone();
        third.mapping.scale = 4.0;
        draft.follow(&third);
        assert!(draft.is_edited() && draft.now.mapping.scale == 2.0);
        draft.revert();
        assert!(!draft.is_edited() && draft.now == third);
        // Saved, it comes back from the device.
        draft.now.rated_force_n = 2.0;
        let saved = draft.now.clone();
        draft.follow(&saved);
        assert!(!draft.is_edited() && draft.now == saved);
    }

    #[test]
    fn a_device_with_a_serial_number_gets_a_file_of_its_own() {
        let mut draft = Draft::new(&arm(), Some("7"));
        assert_eq!(draft.now.serial.as_deref(), Some("7"));
        draft.follow(&arm());
        assert!(!draft.is_edited() && draft.now.serial.as_deref() == Some("7"));
    }

    #[test]
    fn a_name_that_no_file_bears_is_told_in_a_line() {
        let mut draft = Draft::new(&arm(), None);
        draft.now.name = Some("x".repeat(200));
        let wrong = draft.wrong().expect("too long");
        assert!(wrong.contains("1 to 120 characters") && !wrong.contains('\n'));
    }
}
