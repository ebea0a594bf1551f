//! Small pieces that the sides of the editors are made of.

use egui::{RichText, vec2};

/// A part that can be folded away, at first `open` or not; true when it is open.
pub fn fold(ui: &mut egui::Ui, name: &str, open: bool, add: impl FnOnce(&mut egui::Ui)) -> bool {
    fold_as(ui, name, open, None, add)
}

/// The same, opened or closed now where `now` says so.
pub fn fold_as(
    ui: &mut egui::Ui,
    name: &str,
    open: bool,
    now: Option<bool>,
    add: impl FnOnce(&mut egui::Ui),
) -> bool {
    let head = egui::CollapsingHeader::new(RichText::new(name).strong())
        .id_salt(name)
        .default_open(open)
        .open(now)
        .show_unindented(ui, add);
    now.unwrap_or(head.body_returned.is_some())
}

/// A row with its name before it.
pub fn row<R>(ui: &mut egui::Ui, name: &str, why: &str, add: impl FnOnce(&mut egui::Ui) -> R) -> R {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        ui.allocate_ui_with_layout(
            vec2(92.0, 20.0),
            egui::Layout::left_to_right(egui::Align::Center),
            |ui| {
                ui.set_min_width(92.0);
                ui.label(RichText::new(name).weak()).on_hover_text(why);
            },
        );
        add(ui)
    })
    .inner
}

/// One of several; true when it was picked.
pub fn pick(ui: &mut egui::Ui, on: bool, text: &str, name: &str, why: &str) -> bool {
    let response = ui.selectable_label(on, text);
    response.widget_info(|| {
        egui::WidgetInfo::selected(
            egui::accesskit::Role::RadioButton,
            ui.is_enabled(),
            on,
            name,
        )
    });
    response.on_hover_text(why).clicked()
}

/// The head of a column of numbers.
pub fn head(ui: &mut egui::Ui, text: &str, why: &str, width: f32) {
    ui.allocate_ui_with_layout(
        vec2(width, 18.0),
        egui::Layout::right_to_left(egui::Align::Center),
        |ui| {
            ui.set_min_width(width);
            ui.label(RichText::new(text).size(11.0).weak())
                .on_hover_text(why);
        },
    );
}

/// A list that drops down and shows `now`; what was picked of `items`, if anything. `name` is what a screen reader says.
pub fn choose<T>(
    ui: &mut egui::Ui,
    name: &str,
    why: &str,
    now: &str,
    width: f32,
    items: impl IntoIterator<Item = (String, bool, T)>,
) -> Option<T> {
    let mut picked = None;
    let combo = egui::ComboBox::from_id_salt(name)
        .selected_text(now)
        .width(width)
        .height(520.0)
        .show_ui(ui, |ui| {
            for (text, on, value) in items {
                if ui.selectable_label(on, text).clicked() && !on {
                    picked = Some(value);
                }
            }
        });
    combo.response.widget_info(|| {
        let role = egui::accesskit::Role::ComboBox;
        egui::WidgetInfo::labeled(role, ui.is_enabled(), name)
    });
    combo.response.on_hover_text(why);
    picked
}
