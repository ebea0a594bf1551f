//! Numbers that can be typed or dragged, held to what is allowed, with a name and a message each.

use egui::{DragValue, vec2};
use std::ops::RangeInclusive;

/// A number to edit.
#[derive(Clone, Debug)]
pub struct Cell<'a> {
    /// What a screen reader says: which number of what, with its unit.
    pub name: &'a str,
    /// Why it is there, and what is allowed.
    pub tooltip: &'a str,
    /// What is allowed.
    pub range: RangeInclusive<f64>,
    /// Decimals shown.
    pub decimals: usize,
    /// Unit behind the number; empty in a table with units in its heads.
    pub unit: &'a str,
    /// Change per point of a drag.
    pub speed: f64,
    /// Width, points.
    pub width: f32,
}

/// What a hand did to a number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Edit {
    /// A drag began.
    pub started: bool,
    /// The new value; allowed.
    pub value: Option<f64>,
    /// The drag ended.
    pub ended: bool,
    /// What was wrong with what was typed, and what became of it.
    pub told: Option<String>,
    /// It is being edited or dragged.
    pub chosen: bool,
}

/// Shows `cell` with `value`.
pub fn number(ui: &mut egui::Ui, cell: &Cell<'_>, value: f64) -> Edit {
    let mut shown = value;
    let suffix = if cell.unit.is_empty() {
        String::new()
    } else {
        format!(" {}", cell.unit)
    };
    let drag = DragValue::new(&mut shown)
        .speed(cell.speed)
        .max_decimals(cell.decimals.max(6))
        .custom_formatter(|n, _| format!("{:.*}", cell.decimals, n))
        .custom_parser(|text| parse(text, cell.unit))
        .suffix(suffix)
        .update_while_editing(false);
    let height = ui.spacing().interact_size.y;
    let response = ui.add_sized(vec2(cell.width, height), drag);
    ui.ctx().accesskit_node_builder(response.id, |node| {
        node.set_label(cell.name.to_owned());
    });
    let mut edit = Edit {
        started: response.drag_started(),
        ended: response.drag_stopped(),
        chosen: response.gained_focus() || response.dragged() || response.clicked(),
        ..Edit::default()
    };
    if response.changed() {
        let (allowed, told) = held(cell, value, shown);
        if allowed != value {
            edit.value = Some(allowed);
        }
        // A drag that goes on at the end of what is allowed needs no word.
        if !response.dragged() {
            edit.told = told;
        }
    }
    response.on_hover_text(cell.tooltip);
    edit
}

/// A number as people type it: with a comma, a unit, or a sign from a text.
fn parse(text: &str, unit: &str) -> Option<f64> {
    let text = text.trim().trim_end_matches(unit).trim_end_matches('°');
    let text = text.trim().replace(',', ".").replace('−', "-");
    text.parse().ok()
}

/// The value held to what is allowed, and what to say about it.
fn held(cell: &Cell<'_>, before: f64, typed: f64) -> (f64, Option<String>) {
    let (lo, hi) = (*cell.range.start(), *cell.range.end());
    let unit = if cell.unit.is_empty() {
        String::new()
    } else {
        format!(" {}", cell.unit)
    };
    if !typed.is_finite() {
        let told = format!(
            "{}: {typed} is no number that can be used; {before} is kept",
            cell.name
        );
        return (before, Some(told));
    }
    if typed < lo || typed > hi {
        let allowed = typed.clamp(lo, hi);
        let told = format!(
            "{}: {typed} is outside {lo} to {hi}{unit}; set to {allowed}",
            cell.name
        );
        return (allowed, Some(told));
    }
    (typed, None)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell() -> Cell<'static> {
        Cell {
            name: "Stiffness of key 1",
            tooltip: "",
            range: 0.001..=10_000.0,
            decimals: 2,
            unit: "N/mm",
            speed: 0.01,
            width: 60.0,
        }
    }

    #[test]
    fn what_is_not_allowed_is_held_and_told() {
        assert_eq!(held(&cell(), 0.5, 0.7), (0.7, None));
        let (value, told) = held(&cell(), 0.5, -3.0);
        assert_eq!(value, 0.001);
        assert_eq!(
            told.as_deref(),
            Some("Stiffness of key 1: -3 is outside 0.001 to 10000 N/mm; set to 0.001")
        );
        for typed in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let (value, told) = held(&cell(), 0.5, typed);
            assert_eq!(value, 0.5);
            assert!(told.is_some());
        }
    }

    #[test]
    fn people_type_commas_units_and_degrees() {
        assert_eq!(parse(" 0,55 N/mm ", "N/mm"), Some(0.55));
        assert_eq!(parse("−12.5 mm", "mm"), Some(-12.5));
        assert_eq!(parse("90°", "°"), Some(90.0));
        assert_eq!(parse("soft", "N/mm"), None);
    }
}
