//! Scenario files changed in place: what is edited is written anew, comments and all else stay as they are.

mod about;
mod cells;
mod dysfunctions;
mod exercise;
mod rows;

use super::{Scenario, ScenarioError};
use crate::geom::Vec2;
use crate::maps::{AngleRule, EllipseKey, EllipseSettings, Fit, Form, Level, StiffnessKey, Stroke};
use cells::Cell;
use rows::{Row, set, set_rows};
use toml_edit::{DocumentMut, Item, Table, TableLike};

pub use about::set_about;
pub use dysfunctions::set_dysfunctions;
pub use exercise::{set_exercise, sites_text};

/// What errors call the text.
pub(super) const ORIGIN: &str = "scenario";

/// `source` with these keys, fit and strokes in its `[stiffness]`.
///
/// A key that the file states already stays as written, with its comment. Parsed again, the result gives the same keys, fit
/// and strokes; numbers to the bit, but for a change that no number of percent makes, which is off by a rounding.
///
/// # Errors
/// `source` is no scenario, or the map would be refused.
pub fn with_stiffness(
    source: &str,
    keys: &[StiffnessKey],
    fit: Fit,
    strokes: &[Stroke],
) -> Result<String, ScenarioError> {
    let mut document = parsed(source)?;
    let table = table_of(&mut document, "stiffness")?;
    set_choice(table, "fit", fit, fit.name());
    let rows: Vec<Row<'_>> = keys
        .iter()
        .map(|key| {
            vec![
                ("x", Cell::Number(key.at.x)),
                ("y", Cell::Number(key.at.y)),
                ("stiffness_n_per_mm", Cell::Number(key.stiffness_n_per_mm)),
            ]
        })
        .collect();
    const CONSTANT: &str = "constant_n_per_mm";
    match keys {
        [key] if table.contains_key(CONSTANT) && key.at == Vec2::ZERO => {
            set(table, CONSTANT, &Cell::Number(key.stiffness_n_per_mm));
        }
        [] => {
            return Err(ScenarioError(
                "the stiffness map has no keys; at least one is needed".into(),
            ));
        }
        _ => {
            let around = table.remove(CONSTANT);
            set_rows(table, "key", &rows[..], true);
            if let (Some(Item::Value(old)), Some(Item::Value(new))) = (around, table.get_mut("key"))
            {
                *new.decor_mut() = old.decor().clone();
            }
        }
    }
    let rows: Vec<Row<'_>> = strokes
        .iter()
        .map(|stroke| {
            vec![
                ("path", Cell::Points(&stroke.path)),
                ("radius_mm", Cell::Number(stroke.radius_mm)),
                ("change_percent", Cell::Percent(stroke.change)),
                ("falloff", Cell::Text(&stroke.falloff)),
            ]
        })
        .collect();
    if rows.is_empty() {
        table.remove("stroke");
    } else {
        set_rows(table, "stroke", &rows[..], false);
    }
    checked(&document)
}

/// `source` with this ellipse map as its `[ellipse]`, or without one.
///
/// As [`with_stiffness`]; keys named by `keys_from` stay so as long as they are the same, and are written out once they
/// differ.
///
/// # Errors
/// `source` is no scenario, or the map would be refused.
pub fn with_ellipse(
    source: &str,
    map: Option<(&[EllipseKey], &EllipseSettings)>,
) -> Result<String, ScenarioError> {
    let mut document = parsed(source)?;
    let Some((keys, settings)) = map else {
        document.remove("ellipse");
        return checked(&document);
    };
    let is_new = !document.contains_key("ellipse");
    let from_elsewhere = document
        .get("ellipse")
        .and_then(|t| t.get("keys_from"))
        .is_some();
    let same_from_elsewhere = from_elsewhere
        && Scenario::parse(source, ORIGIN, None)?
            .ellipse
            .is_some_and(|(old, _)| old == keys);
    let table = table_of(&mut document, "ellipse")?;
    let default = EllipseSettings::default();
    for (key, value, default) in [
        (
            "basic_radius_mm",
            settings.basic_radius_mm,
            default.basic_radius_mm,
        ),
        (
            "effect_radius_mm",
            settings.effect_radius_mm,
            default.effect_radius_mm,
        ),
    ] {
        if is_new || table.contains_key(key) || value != default {
            set(table, key, &Cell::Number(value));
        }
    }
    set_choice::<Form>(table, "form", settings.form, settings.form.name());
    set_choice::<AngleRule>(table, "angle", settings.angle, settings.angle.name());
    set_choice::<Level>(table, "level", settings.level, settings.level.name());
    if same_from_elsewhere {
        return checked(&document);
    }
    for key in ["keys_from", "force", "subject", "means"] {
        table.remove(key);
    }
    let rows: Vec<Row<'_>> = keys.iter().map(ellipse_row).collect();
    if rows.is_empty() {
        table.remove("key");
    } else {
        set_rows(table, "key", &rows[..], true);
    }
    checked(&document)
}

fn ellipse_row(key: &EllipseKey) -> Row<'_> {
    let mut row: Row<'_> = Vec::new();
    if !key.name.is_empty() {
        row.push(("name", Cell::Text(&key.name)));
    }
    row.extend([
        ("x", Cell::Number(key.at.x)),
        ("y", Cell::Number(key.at.y)),
        ("half_major_mm", Cell::Number(key.half_major_mm)),
        ("half_minor_mm", Cell::Number(key.half_minor_mm)),
        ("angle_deg", Cell::Degrees(key.angle_rad)),
    ]);
    if let Some(radii) = &key.boundary_mm {
        row.push(("boundary_mm", Cell::Numbers(radii)));
    }
    row
}

/// A named choice: written where the file has one, or where it is not the default.
fn set_choice<T: Default + PartialEq>(table: &mut dyn TableLike, key: &str, choice: T, name: &str) {
    if table.contains_key(key) || choice != T::default() {
        set(table, key, &Cell::Text(name));
    }
}

fn parsed(source: &str) -> Result<DocumentMut, ScenarioError> {
    source.parse().map_err(|e: toml_edit::TomlError| {
        let what = e.message().split_whitespace().collect::<Vec<_>>().join(" ");
        ScenarioError(format!("{ORIGIN}: {what}"))
    })
}

/// The table `name`, with a header of its own: one written inline or with dots cannot hold lists of tables.
fn table_of<'a>(document: &'a mut DocumentMut, name: &str) -> Result<&'a mut Table, ScenarioError> {
    let item = document.entry(name).or_insert_with(toml_edit::table);
    if let Some(inline) = item.as_inline_table() {
        *item = Item::Table(inline.clone().into_table());
    }
    let Some(table) = item.as_table_mut() else {
        return Err(ScenarioError(format!("{ORIGIN}: {name} is not a table")));
    };
    table.set_dotted(false);
    table.set_implicit(false);
    Ok(table)
}

fn checked(document: &DocumentMut) -> Result<String, ScenarioError> {
    let text = document.to_string();
    Scenario::parse(&text, ORIGIN, None)?;
    Ok(text)
}
