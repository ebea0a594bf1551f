//! Every number of every key, to be read and typed.

use super::State;
use super::doc::KEY_N_PER_MM;
use crate::app::editor::cells::{self, Cell};
use crate::app::editor::parts::head;
use crate::app::theme::Theme;
use crate::app::widgets::named;
use crate::maps::MAX_COORDINATE_MM;
use egui::{RichText, vec2};

/// Height of a row, points.
const ROW: f32 = 23.0;
/// Rows on show at most.
const ROWS: usize = 8;

/// Shows the table; a click on a number chooses the key.
pub fn show(ui: &mut egui::Ui, theme: &Theme, state: &mut State) {
    let editing = &mut state.editing;
    let keys = editing.doc().keys.clone();
    let fit = editing.doc().fit;
    let errors = state
        .comparing
        .then(|| state.comparison.of(editing.doc(), fit).map(<[f64]>::to_vec))
        .flatten();
    let columns = if errors.is_some() { 4.0 } else { 3.0 };
    let width = ((ui.available_width() - 42.0) / columns - 3.0).clamp(44.0, 86.0);
    ui.spacing_mut().item_spacing = vec2(3.0, 1.0);
    ui.spacing_mut().interact_size.y = ROW - 3.0;
    ui.spacing_mut().button_padding.x = 3.0;
    ui.horizontal(|ui| {
        head(ui, "Key", "Click a number to choose the key", 36.0);
        head(ui, "x mm", "To the subject's right of the midline", width);
        head(ui, "y mm", "Towards the head", width);
        head(ui, "N/mm", "Stiffness at the key", width);
        if errors.is_some() {
            head(
                ui,
                "error",
                "What the other keys say by this fit, less what it states, N/mm",
                width,
            );
        }
    });
    let height = ROW * keys.len().clamp(1, ROWS) as f32;
    let mut area = egui::ScrollArea::vertical()
        .id_salt("table")
        .max_height(height + 2.0);
    // A key chosen on the canvas is brought into view.
    if editing.selected != state.scrolled_to
        && let Some(i) = editing.selected
    {
        let top = (i as f32 * ROW - 0.5 * height + 0.5 * ROW).max(0.0);
        area = area.vertical_scroll_offset(top);
    }
    state.scrolled_to = editing.selected;
    area.show_rows(ui, ROW - 1.0, keys.len(), |ui, rows| {
        for i in rows {
            let Some(key) = keys.get(i).copied() else {
                continue;
            };
            ui.horizontal(|ui| {
                let on = editing.selected == Some(i);
                let n = i + 1;
                let text = RichText::new(format!("{n}")).size(12.0);
                let choose = ui
                    .add_sized(vec2(36.0, ROW - 3.0), egui::Button::selectable(on, text))
                    .on_hover_text("Choose this key");
                named(ui, &choose, &format!("Choose key {n}"));
                if choose.clicked() {
                    editing.selected = Some(i);
                    state.scrolled_to = Some(i);
                }
                let places = -MAX_COORDINATE_MM..=MAX_COORDINATE_MM;
                for (what, value, range, unit, speed, decimals) in [
                    ("x", key.at.x, places.clone(), "mm", 0.5, 1),
                    ("y", key.at.y, places.clone(), "mm", 0.5, 1),
                    (
                        "Stiffness",
                        key.stiffness_n_per_mm,
                        KEY_N_PER_MM,
                        "N/mm",
                        0.005,
                        3,
                    ),
                ] {
                    let said = format!("{what} of key {n}, {unit}");
                    let tooltip = format!(
                        "{said}: drag or type; {} to {} is allowed",
                        range.start(),
                        range.end()
                    );
                    let cell = Cell {
                        name: &said,
                        tooltip: &tooltip,
                        range,
                        decimals,
                        unit: "",
                        speed,
                        width,
                    };
                    let edit = cells::number(ui, &cell, value);
                    if edit.chosen {
                        editing.selected = Some(i);
                        state.scrolled_to = Some(i);
                    }
                    editing.take(edit, "Change key", |doc, v| {
                        doc.with_key(i, |k| match what {
                            "x" => k.at.x = v,
                            "y" => k.at.y = v,
                            _ => k.stiffness_n_per_mm = v,
                        })
                    });
                }
                if let Some(error) = errors.as_ref().and_then(|e| e.get(i)) {
                    let text = RichText::new(format!("{error:>+7.3}"))
                        .monospace()
                        .size(12.0);
                    ui.label(text.color(theme.weak_text));
                }
            });
        }
    });
}
