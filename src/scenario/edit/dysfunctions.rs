//! `[[dysfunction]]` written: what is as it was stays as somebody wrote it.

use super::cells::number;
use super::rows::{NewRows, set_rows};
use super::{ORIGIN, checked, parsed};
use crate::scenario::dysfunction::{
    Change, DEFAULT_SEVERITY, Dysfunction, Place, Side, Target, side_name, sites_words,
};
use crate::scenario::{Scenario, ScenarioError};
use toml_edit::{Array, InlineTable, Item, TableLike, Value};

/// `source` with these dysfunctions as its `[[dysfunction]]`s.
///
/// A dysfunction that is in the file already stays as written, with its comments; of one that changed only the keys that
/// changed are written anew. A new one states what is not the default of its kind. Parsed again, the result gives the same
/// dysfunctions.
///
/// # Errors
/// `source` is no scenario; a dysfunction has a value that is not allowed, or they cannot be together.
pub fn set_dysfunctions(source: &str, list: &[Dysfunction]) -> Result<String, ScenarioError> {
    let mut document = parsed(source)?;
    let old = Scenario::parse(source, ORIGIN, None)?.dysfunctions;
    // What a file cannot state would be lost in it.
    for (i, d) in list.iter().enumerate() {
        d.patches().map_err(|fault| {
            let what = format!("{ORIGIN}: dysfunction {} ({d}): {fault}", i + 1);
            ScenarioError(what)
        })?;
    }
    if list.is_empty() {
        document.remove("dysfunction");
    } else {
        let rows = Rows {
            old: &old,
            new: list,
        };
        set_rows(document.as_table_mut(), "dysfunction", &rows, false);
    }
    checked(&document)
}

struct Rows<'a> {
    old: &'a [Dysfunction],
    new: &'a [Dysfunction],
}

impl NewRows for Rows<'_> {
    fn len(&self) -> usize {
        self.new.len()
    }

    fn says(&self, old: usize, _: &dyn TableLike, new: usize) -> bool {
        self.old.get(old) == Some(&self.new[new])
    }

    fn write(&self, old: Option<usize>, table: &mut dyn TableLike, new: usize) {
        let old = old.and_then(|i| self.old.get(i));
        let new = &self.new[new];
        if old == Some(new) {
            return;
        }
        let same_place = old.is_some_and(|old| old.place == new.place);
        for key in KEYS {
            if same_place && PLACE.contains(&key) {
                continue;
            }
            let value = value(new, key);
            let was = old.map(|old| self::value(old, key).map(|v| v.to_string()));
            let there = table.contains_key(key);
            match value {
                None => {
                    table.remove(key);
                }
                Some(value) if there && was != Some(Some(value.to_string())) => {
                    put(table, key, value);
                }
                Some(value) if !there && !is_default(new, key) => put(table, key, value),
                Some(_) => {}
            }
        }
    }
}

/// The keys that tell the place.
const PLACE: [&str; 6] = ["sites", "level", "levels", "side", "target", "at_mm"];

/// Every key in the order of a new table.
const KEYS: [&str; 19] = [
    "kind",
    "preset",
    "sites",
    "level",
    "levels",
    "side",
    "target",
    "at_mm",
    "offset_mm",
    "radius_mm",
    "angle_deg",
    "profile",
    "severity",
    "stiffness_change",
    "bump_mm",
    "skin_drag",
    "tender_above_n",
    "tender_shown",
    "seed",
];

/// In place of what is there, whose comments stay.
pub(super) fn put(table: &mut dyn TableLike, key: &str, mut value: Value) {
    if let Some(Item::Value(old)) = table.get(key) {
        *value.decor_mut() = old.decor().clone();
    }
    match table.get_mut(key) {
        Some(item) => *item = Item::Value(value),
        None => {
            table.insert(key, Item::Value(value));
        }
    }
}

/// What `key` is in a file; `None` where it is not to be there.
fn value(d: &Dysfunction, key: &str) -> Option<Value> {
    let pair = |[a, b]: [f64; 2]| Value::Array(Array::from_iter([number(a), number(b)]));
    let words = match &d.place {
        Place::Sites(sites) => sites_words(sites),
        Place::At(_) => None,
    };
    let several = |text: &str| text.contains(['-', ',']);
    Some(match key {
        "kind" => Value::from(d.kind),
        "preset" => Value::from(d.preset?),
        "sites" => match &d.place {
            Place::Sites(sites) if words.is_none() => {
                let names: Vec<String> = sites
                    .iter()
                    .map(|s| format!("{} {} {}", s.level, side_name(s.side), s.target.name()))
                    .collect();
                Value::from(names.join("; "))
            }
            _ => return None,
        },
        "level" => Value::from(words.map(|w| w.0).filter(|text| !several(text))?),
        "levels" => Value::from(words.map(|w| w.0).filter(|text| several(text))?),
        "side" => Value::from(words?.1),
        "target" => Value::from(words?.2.name()),
        "at_mm" => match d.place {
            Place::At(at) => pair(at.to_array()),
            Place::Sites(_) => return None,
        },
        "offset_mm" => pair(d.offset_mm.to_array()),
        "radius_mm" => pair(d.radius_mm),
        "angle_deg" => number(d.angle_deg),
        "profile" => Value::from(d.profile.as_str()),
        "severity" => Value::from(i64::from(d.severity)),
        "stiffness_change" => {
            let (key, percent) = match d.change? {
                Change::CompliancePercent(c) => ("compliance_percent", c),
                Change::StiffnessPercent(s) => ("stiffness_percent", s),
            };
            let mut table = InlineTable::new();
            table.insert(key, number(percent));
            Value::InlineTable(table)
        }
        "bump_mm" => number(d.bump_mm?),
        "skin_drag" => number(d.skin_drag?),
        "tender_above_n" => number(d.tender_above_n?),
        "tender_shown" => Value::from(d.tender_shown),
        "seed" => Value::from(i64::try_from(d.seed?).ok()?),
        _ => return None,
    })
}

/// Whether the file may leave `key` out.
fn is_default(d: &Dysfunction, key: &str) -> bool {
    match key {
        "target" => match &d.place {
            Place::Sites(sites) => sites.iter().all(|s| {
                let middle = s.side == Side::Middle;
                s.target
                    == if middle {
                        Target::Spinous
                    } else {
                        Target::Transverse
                    }
            }),
            Place::At(_) => true,
        },
        "severity" => d.severity == DEFAULT_SEVERITY,
        "offset_mm" | "radius_mm" | "angle_deg" | "profile" | "tender_shown" => {
            let Some(kind) = d.kind() else { return false };
            let default = kind.default_at(d.place.clone(), d.severity);
            let text = |d: &Dysfunction| value(d, key).map(|v| v.to_string());
            text(&default) == text(d)
        }
        _ => false,
    }
}
