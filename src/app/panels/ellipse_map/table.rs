//! Every number of every key, to be read and typed.

use super::doc::Doc;
use super::keys::{label, set_degrees, set_half_axis, tidy_length};
use crate::app::editor::cells::{self, Cell};
use crate::app::editor::editing::Editing;
use crate::app::editor::parts::head;
use crate::app::theme::Theme;
use crate::app::widgets::named;
use crate::maps::MAX_COORDINATE_MM;
use crate::maps::ellipse::HALF_AXES_MM;
use egui::{RichText, vec2};

/// Width of the first column, points.
const NAME: f32 = 44.0;
/// Height of a row, points.
const ROW: f32 = 23.0;
/// Rows on show at most; the others are scrolled to.
const ROWS: usize = 9;

/// The heads: text, tooltip.
const HEADS: [(&str, &str); 6] = [
    ("x mm", "To the subject's right of the midline"),
    ("y mm", "Towards the head"),
    ("a mm", "Half the major axis"),
    ("b mm", "Half the minor axis, at most the major one"),
    (
        "angle °",
        "Direction of the major axis from x; 0 and 180 are the same",
    ),
    ("ratio", "Major over minor axis; follows from them"),
];

/// Shows the table; a click on a name chooses the key.
pub fn show(ui: &mut egui::Ui, theme: &Theme, editing: &mut Editing<Doc>, editable: bool) {
    let keys = editing.doc().keys.clone();
    let width = ((ui.available_width() - NAME - 8.0) / 6.0 - 3.0).clamp(40.0, 64.0);
    egui::ScrollArea::horizontal()
        .id_salt("table across")
        .show(ui, |ui| {
            ui.spacing_mut().item_spacing = vec2(3.0, 1.0);
            ui.spacing_mut().interact_size.y = ROW - 3.0;
            ui.spacing_mut().button_padding.x = 3.0;
            ui.horizontal(|ui| {
                head(ui, "Key", "Click a name to choose the key", NAME);
                for (text, why) in HEADS {
                    head(ui, text, why, width);
                }
            });
            let height = ROW * keys.len().min(ROWS) as f32;
            egui::ScrollArea::vertical()
                .id_salt("table")
                .max_height(height.max(ROW) + 2.0)
                .show_rows(ui, ROW - 1.0, keys.len(), |ui, rows| {
                    for i in rows {
                        ui.add_enabled_ui(editable, |ui| row(ui, theme, editing, i, width));
                    }
                });
        });
}

fn row(ui: &mut egui::Ui, theme: &Theme, editing: &mut Editing<Doc>, i: usize, width: f32) {
    let Some(key) = editing.doc().keys.get(i).cloned() else {
        return;
    };
    let name = label(&key, i);
    ui.horizontal(|ui| {
        let on = editing.selected == Some(i);
        let text = RichText::new(&name).size(12.0);
        let choose = ui
            .add_sized(vec2(NAME, ROW - 3.0), egui::Button::selectable(on, text))
            .on_hover_text("Choose this key");
        named(ui, &choose, &format!("Choose key {name}"));
        if choose.clicked() {
            editing.selected = Some(i);
        }
        let degrees = key.angle_rad.to_degrees();
        let places = -MAX_COORDINATE_MM..=MAX_COORDINATE_MM;
        for (what, value, range, unit, which) in [
            ("x", key.at.x, places.clone(), "mm", 0),
            ("y", key.at.y, places, "mm", 1),
            ("Half major axis", key.half_major_mm, HALF_AXES_MM, "mm", 2),
            ("Half minor axis", key.half_minor_mm, HALF_AXES_MM, "mm", 3),
            ("Direction", degrees, -360.0..=360.0, "°", 4),
        ] {
            let said = format!("{what} of {name}, {unit}");
            let tooltip = format!(
                "{said}: drag or type; {} to {} is allowed",
                range.start(),
                range.end()
            );
            let cell = Cell {
                name: &said,
                tooltip: &tooltip,
                range,
                decimals: 1,
                unit: "",
                speed: 0.5,
                width,
            };
            let edit = cells::number(ui, &cell, value);
            if edit.chosen {
                editing.selected = Some(i);
            }
            editing.take(edit, "Change key", |doc, v| {
                doc.with_key(i, |k| match which {
                    0 => k.at.x = v,
                    1 => k.at.y = v,
                    2 => set_half_axis(k, true, v),
                    3 => set_half_axis(k, false, v),
                    _ => set_degrees(k, v),
                })
            });
        }
        ui.allocate_ui_with_layout(
            vec2(width, ROW - 3.0),
            egui::Layout::right_to_left(egui::Align::Center),
            |ui| {
                let ratio = key.oval().major_over_minor();
                let text = RichText::new(format!("{ratio:.3}")).monospace().size(12.0);
                ui.label(text.color(theme.weak_text));
            },
        );
    });
}

/// Name and boundary of the chosen key, and what can be done with it.
pub fn chosen(ui: &mut egui::Ui, theme: &Theme, editing: &mut Editing<Doc>, editable: bool) {
    ui.vertical(|ui| {
        ui.set_min_height(42.0);
        chosen_ui(ui, theme, editing, editable);
    });
}

fn chosen_ui(ui: &mut egui::Ui, theme: &Theme, editing: &mut Editing<Doc>, editable: bool) {
    let Some((i, key)) = editing
        .selected
        .and_then(|i| Some((i, editing.doc().keys.get(i)?.clone())))
    else {
        ui.label(
            RichText::new("No key is chosen: click one, or double-click the map to add one")
                .color(theme.weak_text),
        );
        return;
    };
    ui.add_enabled_ui(editable, |ui| {
        ui.horizontal_wrapped(|ui| {
            let text = ui.label("Name");
            let mut name = key.name.clone();
            let field = ui
                .add(egui::TextEdit::singleline(&mut name).desired_width(96.0))
                .labelled_by(text.id)
                .on_hover_text("What the key is called; may be empty");
            if field.gained_focus() {
                editing.hold("Rename key");
            }
            if field.changed() && name.chars().count() <= 60 && !name.chars().any(char::is_control)
            {
                let doc = editing.doc().with_key(i, |k| k.name = name);
                editing.set("Rename key", doc);
            }
            if field.lost_focus() {
                editing.release();
            }
            let mut on = key.boundary_mm.is_some();
            let toggle = ui.checkbox(&mut on, "Irregular boundary").on_hover_text(
                "Shape the footprint by hand: one radius every few degrees, as handles on the canvas. It is felt where the scenario says footprint = \"irregular\"",
            );
            if toggle.changed() {
                let doc = editing.doc().with_boundary(i, on);
                editing.set("Change boundary", doc);
            }
        });
        if let Some(radii) = &key.boundary_mm {
            ui.horizontal_wrapped(|ui| {
                ui.spacing_mut().item_spacing = vec2(3.0, 2.0);
                for (r, radius) in radii.iter().enumerate() {
                    let degrees = 360.0 * r as f64 / radii.len() as f64;
                    let said = format!("Radius at {degrees:.0}° of {}, mm", label(&key, i));
                    let cell = Cell {
                        name: &said,
                        tooltip: &said,
                        range: HALF_AXES_MM,
                        decimals: 1,
                        unit: "mm",
                        speed: 0.5,
                        width: 70.0,
                    };
                    let edit = cells::number(ui, &cell, *radius);
                    editing.take(edit, "Shape boundary", |doc, v| {
                        doc.with_key(i, |k| {
                            if let Some(r) = k.boundary_mm.as_mut().and_then(|b| b.get_mut(r)) {
                                *r = tidy_length(v);
                            }
                        })
                    });
                }
            });
        }
    });
}
