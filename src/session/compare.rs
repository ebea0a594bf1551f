//! Where two runs of the same inputs part, and by how much.

use super::format::{FIELDS, Role, Value};
use crate::servo::{FingerRecord, TickRecord};
use serde::Serialize;

/// The first place where two runs part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Tick number.
    pub tick: u64,
    /// Finger, from 0.
    pub finger: u8,
    /// Field as the format names it, with its axis: `force_n.z`.
    pub field: String,
    /// Its value in the recording.
    pub recorded: String,
    /// Its value now.
    pub got: String,
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (tick, finger, field) = (self.tick, self.finger, &self.field);
        let (recorded, got) = (&self.recorded, &self.got);
        write!(
            f,
            "tick {tick}, finger {finger}, {field}: recorded {recorded}, got {got}"
        )
    }
}

/// How far two runs are apart in one field.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldDifference {
    /// Field as the format names it.
    pub field: &'static str,
    /// Records in which it differs.
    pub records: u64,
    /// Greatest difference: of numbers and components of vectors; 1 for what is equal or not. Infinite where one side is not
    /// finite.
    pub max: f64,
}

/// Gathers differences over a run.
#[derive(Debug, Default)]
pub(super) struct Tally {
    pub(super) first: Option<Difference>,
    per_field: [(u64, f64); N_FIELDS],
}

const N_FIELDS: usize = 27;

impl Tally {
    /// Compares the outcomes of one tick bit for bit.
    pub(super) fn add(&mut self, recorded: &TickRecord, got: &TickRecord) {
        for (a, b) in recorded.fingers().iter().zip(got.fingers()) {
            if !a.same_outcome(b) {
                self.add_finger(a, b);
            }
        }
    }

    fn add_finger(&mut self, recorded: &FingerRecord, got: &FingerRecord) {
        for (field, (records, max)) in FIELDS.iter().zip(&mut self.per_field) {
            let (a, b) = ((field.get)(recorded), (field.get)(got));
            if field.role == Role::Measured || same_bits(a, b) {
                continue;
            }
            *records += 1;
            *max = max.max(distance(a, b));
            if self.first.is_none() {
                let (axis, recorded_value, got_value) = in_words(a, b);
                self.first = Some(Difference {
                    tick: recorded.tick,
                    finger: recorded.finger,
                    field: format!("{}{axis}", field.name),
                    recorded: recorded_value,
                    got: got_value,
                });
            }
        }
    }

    /// The fields that differ anywhere.
    pub(super) fn fields(&self) -> Vec<FieldDifference> {
        let fields = FIELDS.iter().zip(&self.per_field);
        let differing = fields.filter(|(_, (records, _))| *records > 0);
        differing
            .map(|(field, &(records, max))| FieldDifference {
                field: field.name,
                records,
                max,
            })
            .collect()
    }
}

fn same_bits(a: Value, b: Value) -> bool {
    match (a, b) {
        (Value::Vec3(a), Value::Vec3(b)) => {
            a.to_array().map(f64::to_bits) == b.to_array().map(f64::to_bits)
        }
        (Value::F64(a), Value::F64(b)) => a.to_bits() == b.to_bits(),
        (Value::F32(a), Value::F32(b)) => a.to_bits() == b.to_bits(),
        _ => a == b,
    }
}

fn distance(a: Value, b: Value) -> f64 {
    let apart = |a: f64, b: f64| {
        let apart = (a - b).abs();
        if apart.is_nan() { f64::INFINITY } else { apart }
    };
    match (a, b) {
        // By component: the length of a difference of a few last bits is zero, its squares being too small.
        (Value::Vec3(a), Value::Vec3(b)) => {
            let parts = a.to_array().into_iter().zip(b.to_array());
            parts.map(|(a, b)| apart(a, b)).fold(0.0, f64::max)
        }
        (Value::F64(a), Value::F64(b)) => apart(a, b),
        (Value::U64(a), Value::U64(b)) => a.abs_diff(b) as f64,
        _ => 1.0,
    }
}

/// Axis, and both values; numbers in their shortest form that tells all bits.
fn in_words(a: Value, b: Value) -> (&'static str, String, String) {
    match (a, b) {
        (Value::Vec3(a), Value::Vec3(b)) => {
            let parts = a.to_array().into_iter().zip(b.to_array());
            let mut parts = [".x", ".y", ".z"].into_iter().zip(parts);
            let differing = parts.find(|(_, (a, b))| a.to_bits() != b.to_bits());
            let (axis, (a, b)) = differing.unwrap_or(("", (a.x, b.x)));
            (axis, a.to_string(), b.to_string())
        }
        _ => ("", word(a), word(b)),
    }
}

fn word(value: Value) -> String {
    match value {
        Value::Vec3(v) => format!("{} {} {}", v.x, v.y, v.z),
        Value::F64(v) => v.to_string(),
        Value::F32(v) => v.to_string(),
        Value::U64(v) => v.to_string(),
        Value::U32(v) => v.to_string(),
        Value::Bool(v) => v.to_string(),
        Value::Touch(v) => super::format::touch_name(v).to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Vec3;

    #[test]
    fn there_is_a_tally_for_every_field() {
        assert_eq!(FIELDS.len(), N_FIELDS);
    }

    #[test]
    fn the_sign_of_zero_is_a_difference_and_measured_times_are_none() {
        let mut recorded = TickRecord {
            n_fingers: 1,
            ..TickRecord::default()
        };
        let mut got = recorded;
        recorded.fingers[0].duration_us = 3.0;
        recorded.fingers[0].time_ns = 12;
        let mut tally = Tally::default();
        tally.add(&recorded, &got);
        assert_eq!(tally.first, None);

        got.fingers[0].contact.force_n = Vec3::new(0.0, -0.0, 0.0);
        tally.add(&recorded, &got);
        let first = tally.first.as_ref().expect("differs");
        assert_eq!(first.field, "force_n.y");
        assert_eq!((first.recorded.as_str(), first.got.as_str()), ("0", "-0"));
        assert_eq!(tally.fields().len(), 1);
    }
}
