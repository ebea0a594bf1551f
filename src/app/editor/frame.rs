//! Where bar, canvas and side go, and the buttons over the canvas.

use super::canvas::Canvas;
use crate::app::theme::Theme;
use crate::app::widgets::icon_button;
use egui::{Rect, pos2, vec2};
use egui_material_icons::icons as icon;

/// Width of what is beside the canvas, points.
const SIDE: f32 = 356.0;
/// From this width on the canvas has its place beside the side, points.
const WIDE: f32 = 700.0;
/// Height of the bar, points.
const BAR: f32 = 30.0;

/// The places of an editor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts {
    /// Buttons.
    pub bar: Rect,
    /// The map.
    pub canvas: Rect,
    /// Everything else.
    pub side: Rect,
}

/// Side by side where there is room, else one above the other.
pub fn split(whole: Rect) -> Parts {
    let below = |place: Rect| place.split_top_bottom_at_y(place.top() + BAR.min(place.height()));
    if whole.width() >= WIDE {
        let (left, side) = whole.split_left_right_at_x(whole.right() - SIDE);
        let (bar, canvas) = below(left);
        return Parts { bar, canvas, side };
    }
    let (bar, rest) = below(whole);
    let (canvas, side) = if rest.height() >= 240.0 {
        rest.split_top_bottom_at_y(rest.top() + (rest.height() * 0.5).max(120.0))
    } else {
        // No room for a map: numbers alone.
        rest.split_top_bottom_at_y(rest.top())
    };
    Parts { bar, canvas, side }
}

/// Lays the bar out; what does not fit is scrolled to.
pub fn bar(ui: &mut egui::Ui, rect: Rect, add: impl FnOnce(&mut egui::Ui)) {
    let builder = egui::UiBuilder::new()
        .max_rect(rect.shrink2(vec2(6.0, 2.0)))
        .layout(egui::Layout::left_to_right(egui::Align::Center));
    ui.scope_builder(builder, |ui| {
        ui.set_clip_rect(ui.clip_rect().intersect(rect));
        egui::ScrollArea::horizontal()
            .scroll_bar_visibility(egui::scroll_area::ScrollBarVisibility::AlwaysHidden)
            .show(ui, |ui| {
                ui.horizontal_centered(add);
            });
    });
}

/// Lays the side out; it scrolls.
pub fn side(ui: &mut egui::Ui, rect: Rect, add: impl FnOnce(&mut egui::Ui)) {
    let builder = egui::UiBuilder::new()
        .max_rect(rect.shrink2(vec2(8.0, 4.0)))
        .layout(egui::Layout::top_down(egui::Align::Min));
    ui.scope_builder(builder, |ui| {
        ui.set_clip_rect(ui.clip_rect().intersect(rect));
        egui::ScrollArea::vertical()
            .id_salt("side")
            .auto_shrink(false)
            .show(ui, |ui| {
                // The bar of the scroll area lies over the right end of what it scrolls.
                ui.set_max_width(ui.available_width() - 8.0);
                add(ui);
            });
    });
}

/// Says why nothing can be edited.
pub fn locked(ui: &mut egui::Ui, theme: &Theme) {
    let text = "A recording is on show: go back to live to edit";
    ui.label(egui::RichText::new(text).color(theme.warning));
}

/// Fit and zoom, over the upper right corner of the canvas, below the line that tells the value under the pointer.
pub fn view_buttons(ui: &mut egui::Ui, rect: Rect, canvas: &mut Canvas) {
    if rect.width() < 160.0 {
        return;
    }
    let size = vec2(62.0, 26.0);
    let place = Rect::from_min_size(pos2(rect.right() - size.x - 6.0, rect.top() + 32.0), size);
    let fill = ui.visuals().panel_fill.gamma_multiply(0.88);
    ui.painter().rect_filled(place, 5.0, fill);
    let builder = egui::UiBuilder::new()
        .max_rect(place.shrink2(vec2(4.0, 0.0)))
        .layout(egui::Layout::left_to_right(egui::Align::Center));
    ui.scope_builder(builder, |ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        ui.spacing_mut().button_padding.x = 2.0;
        if icon_button(
            ui,
            icon::ICON_FIT_SCREEN,
            "Fit the map",
            "Show all of the back",
        )
        .clicked()
        {
            canvas.fit(None);
        }
        if icon_button(
            ui,
            icon::ICON_ZOOM_IN,
            "Zoom in",
            "Magnify; the wheel does so at the pointer",
        )
        .clicked()
        {
            canvas.zoom(1.25);
        }
        if icon_button(ui, icon::ICON_ZOOM_OUT, "Zoom out", "See more of the map").clicked() {
            canvas.zoom(0.8);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_lie_in_the_panel_and_do_not_overlap_whatever_its_size() {
        for (w, h) in [(1000.0, 700.0), (420.0, 480.0), (200.0, 120.0), (10.0, 5.0)] {
            let whole = Rect::from_min_size(pos2(3.0, 4.0), vec2(w, h));
            let p = split(whole);
            for part in [p.bar, p.canvas, p.side] {
                assert!(whole.expand(1e-3).contains_rect(part), "{w}×{h}: {part:?}");
            }
            let area = |r: Rect| r.width() * r.height();
            let sum = area(p.bar) + area(p.canvas) + area(p.side);
            assert!((sum - area(whole)).abs() < 0.5);
        }
    }
}
