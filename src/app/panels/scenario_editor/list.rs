//! All dysfunctions in order, and what can be done to the chosen one.

use super::doc::title;
use super::{State, remove, wording};
use crate::app::theme::Theme;
use crate::app::widgets::{icon_button, named};
use crate::scenario::Dysfunction;
use egui::{Key, RichText};
use egui_material_icons::icons as icon;

/// The row of buttons above the canvas.
pub fn bar(ui: &mut egui::Ui, state: &mut State, editable: bool) {
    ui.add_enabled_ui(editable, |ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        state.editing.buttons(ui);
        ui.separator();
        let count = state.editing.doc().list.len();
        let chosen = state.editing.selected.filter(|i| *i < count);
        let i = chosen.unwrap_or(usize::MAX);
        ui.add_enabled_ui(chosen.is_some(), |ui| {
            let why = "Add a copy of the chosen dysfunction a level below it";
            if icon_button(ui, icon::ICON_CONTENT_COPY, "Duplicate dysfunction", why).clicked() {
                let doc = state.editing.doc().with_copy(i);
                state.editing.set("Duplicate dysfunction", doc);
                state.editing.selected = Some(i + 1);
            }
            let why = "Remove the chosen dysfunction (Delete)";
            if icon_button(ui, icon::ICON_DELETE, "Remove dysfunction", why).clicked() {
                remove(state, i);
            }
            let why = "Move the chosen dysfunction to the other side";
            if icon_button(ui, icon::ICON_FLIP, "Mirror dysfunction", why).clicked() {
                let doc = state.editing.doc().with_mirrored(i);
                state.editing.set("Mirror dysfunction", doc);
            }
            let copy = ui
                .button("Both sides")
                .on_hover_text("Add a mirror image of the chosen dysfunction on the other side");
            named(ui, &copy, "Copy dysfunction to the other side");
            if copy.clicked() {
                let doc = state.editing.doc().with_mirror_copy(i);
                state.editing.set("Copy to the other side", doc);
                state.editing.selected = Some(i + 1);
            }
        });
        ui.separator();
        for (by, picture, name, why, can) in [
            (
                -1,
                icon::ICON_ARROW_UPWARD,
                "Earlier in the order",
                "Lay the chosen dysfunction on before the one above it (Alt+Up)",
                chosen.is_some_and(|i| i > 0),
            ),
            (
                1,
                icon::ICON_ARROW_DOWNWARD,
                "Later in the order",
                "Lay the chosen dysfunction on after the one below it (Alt+Down)",
                chosen.is_some_and(|i| i + 1 < count),
            ),
        ] {
            ui.add_enabled_ui(can, |ui| {
                if icon_button(ui, picture, name, why).clicked() {
                    reorder(state, i, by);
                }
            });
        }
    });
}

fn reorder(state: &mut State, index: usize, by: isize) {
    let doc = state.editing.doc().with_moved(index, by);
    if doc != *state.editing.doc() {
        state.editing.set("Change order", doc);
        state.editing.selected = index.checked_add_signed(by);
    }
}

/// The list.
pub fn show(ui: &mut egui::Ui, theme: &Theme, state: &mut State, editable: bool) {
    let list = state.editing.doc().list.clone();
    if list.is_empty() {
        let text = "None yet: click a site on the back, or choose one above";
        ui.label(RichText::new(text).color(theme.weak_text));
        return;
    }
    let mut done = None;
    for (i, d) in list.iter().enumerate() {
        let on = state.editing.selected == Some(i);
        let text = format!("{}  {}", i + 1, title(d));
        let width = ui.available_width();
        let response = ui
            .add_sized(
                [width, 20.0],
                egui::Button::selectable(on, text).truncate().right_text(""),
            )
            .on_hover_text(strengths(d));
        let name = format!("Choose dysfunction {}", i + 1);
        response.widget_info(|| {
            let role = egui::accesskit::Role::RadioButton;
            egui::WidgetInfo::selected(role, ui.is_enabled(), on, &name)
        });
        if response.clicked() || response.gained_focus() {
            state.editing.selected = Some(i);
        }
        if response.has_focus() && editable {
            let (up, down, delete) = ui.input_mut(|i| {
                (
                    i.consume_key(egui::Modifiers::ALT, Key::ArrowUp),
                    i.consume_key(egui::Modifiers::ALT, Key::ArrowDown),
                    i.key_pressed(Key::Delete) || i.key_pressed(Key::Backspace),
                )
            });
            done = done
                .or(up.then_some((i, -1)))
                .or(down.then_some((i, 1)))
                .or(delete.then_some((i, 0)));
        }
        ui.indent(("strength", i), |ui| {
            let text = RichText::new(strengths(d)).size(11.5).weak();
            ui.add(egui::Label::new(text).truncate());
        });
    }
    match done {
        Some((i, 0)) => remove(state, i),
        Some((i, by)) => reorder(state, i, by),
        None => {}
    }
}

/// How strong it is, in one line.
fn strengths(d: &Dysfunction) -> String {
    let strength = d.strength();
    let mut out = Vec::new();
    if let Some(change) = strength.change {
        out.push(wording::both(change));
    }
    if let Some(drag) = strength.skin_drag {
        out.push(format!("skin drag × {drag}"));
    }
    if let Some(bump) = strength.bump_mm {
        out.push(format!("bump {} mm", wording::signed(bump)));
    }
    if let Some(above) = strength.tender_above_n {
        out.push(format!("tender above {above} N"));
    }
    if out.is_empty() {
        return format!("severity {}: nothing is felt", d.severity);
    }
    out.join(", ")
}
