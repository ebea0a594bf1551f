//! What the colours over a picture mean.

use super::back_view::plate;
use crate::app::theme::Theme;
use egui::{Color32, RichText, vec2};

const ROW: f32 = 15.0;
const WIDTH: f32 = 140.0;

/// Draws the legend into the lower right corner of a picture in `rect`; nothing for no entry or where there is no room.
pub fn show(ui: &mut egui::Ui, rect: egui::Rect, theme: &Theme, entries: &[(Color32, &str)]) {
    let height = entries.len() as f32 * (ROW + 1.0) + 8.0;
    if entries.is_empty() || rect.height() < height + 80.0 || rect.width() < 240.0 {
        return;
    }
    let mut place = rect.shrink(8.0);
    place.min.y = place.max.y - height;
    place.min.x = place.max.x - WIDTH;
    let builder = egui::UiBuilder::new()
        .max_rect(place)
        .layout(egui::Layout::top_down(egui::Align::Min));
    ui.scope_builder(builder, |ui| {
        plate(theme).show(ui, |ui| {
            ui.spacing_mut().item_spacing = vec2(6.0, 1.0);
            ui.spacing_mut().interact_size.y = ROW;
            ui.set_width(WIDTH - 12.0);
            for &(color, text) in entries {
                ui.horizontal(|ui| {
                    swatch(ui, color);
                    ui.add(egui::Label::new(RichText::new(text).size(11.5)).truncate());
                });
            }
        });
    });
}

/// A small square of a colour.
pub fn swatch(ui: &mut egui::Ui, color: Color32) {
    let (rect, _) = ui.allocate_exact_size(vec2(11.0, ROW), egui::Sense::hover());
    let square = egui::Rect::from_center_size(rect.center(), vec2(11.0, 11.0));
    ui.painter().rect_filled(square, 2.0, color);
}
