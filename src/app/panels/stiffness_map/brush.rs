//! The brush in the hand and the strokes it left.

use super::State;
use super::doc::Brush;
use crate::app::editor::cells::{self, Cell};
use crate::app::editor::parts::{pick, row};
use crate::app::widgets::{icon_button, named};
use crate::geom::curve;
use crate::maps::stiffness::STROKE_CHANGES;
use egui::{RichText, vec2};
use egui_material_icons::icons as icon;

/// Height of a row, points.
const ROW: f32 = 22.0;

/// Shows its settings and the list of strokes.
pub fn show(ui: &mut egui::Ui, state: &mut State) {
    let brush = &mut state.brush;
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut brush.on, "Paint with the brush").on_hover_text(
            "Drag over the canvas to raise or lower the stiffness; Alt does the other. The middle button moves the map",
        );
        for (lowers, text, why) in [
            (false, "Raise", "Make it stiffer; with Alt softer"),
            (true, "Lower", "Make it softer; with Alt stiffer"),
        ] {
            if pick(ui, brush.lowers == lowers, text, &format!("Brush: {text}"), why) {
                brush.lowers = lowers;
            }
        }
    });
    let mut told = None;
    row(
        ui,
        "Radius, change",
        "Size of the brush, and what it does at its centre",
        |ui| {
            let radius = Cell {
                name: "Radius of the brush, mm",
                tooltip: "Radius of the brush: beyond it nothing changes",
                range: Brush::RADII_MM,
                decimals: 1,
                unit: "mm",
                speed: 0.3,
                width: 84.0,
            };
            let edit = cells::number(ui, &radius, brush.radius_mm);
            brush.radius_mm = edit.value.unwrap_or(brush.radius_mm);
            told = told.take().or(edit.told);
            let percent = Cell {
                name: "Change by the brush, percent",
                tooltip: "Change of the stiffness at the centre of the brush; strokes over each other multiply",
                range: 1.0..=100.0 * STROKE_CHANGES.end(),
                decimals: 0,
                unit: "%",
                speed: 0.3,
                width: 70.0,
            };
            let edit = cells::number(ui, &percent, brush.percent);
            brush.percent = edit.value.unwrap_or(brush.percent);
            told = told.take().or(edit.told);
        },
    );
    row(
        ui,
        "Falloff",
        "How the change falls off towards the edge of the brush",
        |ui| {
            let combo = egui::ComboBox::from_id_salt("falloff")
                .selected_text(brush.falloff)
                .show_ui(ui, |ui| {
                    for (name, _) in curve::all() {
                        ui.selectable_value(&mut brush.falloff, name, *name);
                    }
                });
            combo
                .response
                .on_hover_text("The curve from the centre to the edge")
                .widget_info(|| {
                    egui::WidgetInfo::labeled(
                        egui::accesskit::Role::ComboBox,
                        ui.is_enabled(),
                        "Falloff of the brush",
                    )
                });
        },
    );
    if told.is_some() {
        state.editing.told = told;
    }
    strokes(ui, state);
}

fn strokes(ui: &mut egui::Ui, state: &mut State) {
    let strokes = state.editing.doc().strokes.clone();
    if strokes.is_empty() {
        ui.label(RichText::new("No strokes yet").size(12.0).weak());
        return;
    }
    ui.spacing_mut().item_spacing = vec2(4.0, 1.0);
    let mut remove = None;
    egui::ScrollArea::vertical()
        .id_salt("strokes")
        .max_height(ROW * 5.0)
        .show_rows(ui, ROW, strokes.len(), |ui, rows| {
            for i in rows {
                let Some(stroke) = strokes.get(i) else {
                    continue;
                };
                let n = i + 1;
                ui.horizontal(|ui| {
                    let on = state.stroke == Some(i);
                    let text = RichText::new(format!("Stroke {n}")).size(12.0);
                    let choose = ui
                        .selectable_label(on, text)
                        .on_hover_text("Show where it went");
                    named(ui, &choose, &format!("Choose stroke {n}"));
                    if choose.clicked() {
                        state.stroke = if on { None } else { Some(i) };
                    }
                    let said = format!("Change of stroke {n}, percent");
                    let change = Cell {
                        name: &said,
                        tooltip: "Change of the stiffness on its path; negative is softer",
                        range: 100.0 * STROKE_CHANGES.start()..=100.0 * STROKE_CHANGES.end(),
                        decimals: 0,
                        unit: "%",
                        speed: 0.3,
                        width: 62.0,
                    };
                    let edit = cells::number(ui, &change, 100.0 * stroke.change);
                    state.editing.take(edit, "Change stroke", |doc, v| {
                        doc.with_changed_stroke(i, |s| s.change = v / 100.0)
                    });
                    let said = format!("Radius of stroke {n}, mm");
                    let radius = Cell {
                        name: &said,
                        tooltip: "How far the stroke reaches",
                        range: Brush::RADII_MM,
                        decimals: 1,
                        unit: "mm",
                        speed: 0.3,
                        width: 72.0,
                    };
                    let edit = cells::number(ui, &radius, stroke.radius_mm);
                    state.editing.take(edit, "Change stroke", |doc, v| {
                        doc.with_changed_stroke(i, |s| s.radius_mm = v)
                    });
                    let name = format!("Remove stroke {n}");
                    if icon_button(ui, icon::ICON_DELETE, &name, "Remove this stroke").clicked() {
                        remove = Some(i);
                    }
                });
            }
        });
    if let Some(i) = remove {
        let doc = state.editing.doc().without_stroke(i);
        state.editing.set("Remove stroke", doc);
        state.stroke = None;
    }
}
