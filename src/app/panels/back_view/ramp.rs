//! The legend of a surface colour, in a strip beside the picture: colours with numbers, and which values they span.

use super::colour::SurfaceColour;
use crate::app::colours::Quantity;
use crate::app::colours::map::Map;
use crate::app::colours::range::{Range, Span};
use crate::app::render::pixels;
use crate::app::theme::Theme;
use crate::app::widgets::{icon_button, named};
use crate::deform::Displacement;
use egui::{Align2, FontId, Rect, RichText, Stroke, pos2, vec2};
use egui_material_icons::icons as icon;

/// Width of the strip, points.
const WIDTH: f32 = 104.0;
/// A picture narrower or lower than this, points, is left whole: it says more than a legend.
const LEAST: egui::Vec2 = vec2(330.0, 300.0);
/// Width of the ramp itself, points.
const RAMP: f32 = 20.0;
/// Quads that the ramp is drawn with.
const STEPS: usize = 128;
/// Points between two numbers, at least.
const BETWEEN: f64 = 42.0;

/// Cuts the strip off the right of `whole`: the picture's place, and the strip's where there is room for one.
pub fn split(whole: Rect) -> (Rect, Option<Rect>) {
    if whole.width() < LEAST.x + WIDTH || whole.height() < LEAST.y {
        return (whole, None);
    }
    let x = whole.right() - WIDTH;
    let (picture, strip) = whole.split_left_right_at_x(x);
    (picture, Some(strip))
}

/// Draws the strip into `place`, and takes the range that the user sets.
pub fn show(
    ui: &mut egui::Ui,
    place: Rect,
    theme: &Theme,
    colour: &mut SurfaceColour,
    displacement: &Displacement,
) {
    let Some(quantity) = colour.quantity() else {
        return;
    };
    let (same, working) = (colour.why_same(), colour.is_working());
    let contour_step = colour.contour_step();
    let mut contours = colour.contours();
    let Some(range) = colour.range() else { return };
    ui.painter().rect_filled(place, 0.0, theme.panel);
    let builder = egui::UiBuilder::new()
        .max_rect(place.shrink2(vec2(8.0, 8.0)))
        .layout(egui::Layout::top_down(egui::Align::Min));
    let mut reset = false;
    ui.scope_builder(builder, |ui| {
        ui.spacing_mut().item_spacing = vec2(4.0, 4.0);
        ui.spacing_mut().interact_size.x = 58.0;
        ui.add(egui::Label::new(RichText::new(quantity.name).strong()).wrap())
            .on_hover_text(quantity.about);
        let unit = match quantity.unit {
            "" => "no unit",
            "°" => "degrees",
            unit => unit,
        };
        ui.label(RichText::new(unit).weak());
        ui.add_space(2.0);
        if range.can_be_fixed() {
            end_ui(ui, range, 1);
        }
        let below = footer_height(range, quantity, same.is_some() || working);
        let height = (ui.available_height() - below).max(60.0);
        let (ramp, _) =
            ui.allocate_exact_size(vec2(ui.available_width(), height), egui::Sense::hover());
        ramp_ui(
            ui,
            ramp.shrink2(vec2(0.0, 7.0)),
            theme,
            quantity,
            range,
            contour_step,
        );
        if range.can_be_fixed() {
            end_ui(ui, range, 0);
            reset = range_ui(ui, range);
        }
        if quantity.has_contours() && same.is_none() {
            let words = "Contours";
            let step = contour_step.unwrap_or_else(|| range.step(12));
            let why = format!(
                "Level lines every {}",
                quantity.written(step, Range::digits(step))
            );
            let check = ui.checkbox(&mut contours, words).on_hover_text(why);
            check.widget_info(|| {
                egui::WidgetInfo::selected(
                    egui::accesskit::Role::CheckBox,
                    ui.is_enabled(),
                    contours,
                    words,
                )
            });
        }
        if working {
            ui.add(egui::Label::new(RichText::new("working…").size(11.0).weak()).wrap());
        } else if let Some(why) = same {
            ui.add(egui::Label::new(RichText::new(why).size(11.0).weak()).wrap());
        }
    });
    colour.set_contours(contours);
    if reset {
        colour.reset_range(displacement);
    }
}

/// Height of what stands below the ramp, points.
fn footer_height(range: &Range, quantity: &Quantity, note: bool) -> f32 {
    let mut height = 4.0;
    if range.can_be_fixed() {
        height += 2.0 * 26.0;
    }
    // A note stands where the contours would.
    if note {
        height += 48.0;
    } else if quantity.has_contours() {
        height += 26.0;
    }
    height
}

/// The number at one end of the range, to be dragged or typed.
fn end_ui(ui: &mut egui::Ui, range: &mut Range, end: usize) {
    let [low, high] = range.bounds();
    let mut value = [low, high][end];
    let step = range.step(100);
    let name = ["Lower end of the range", "Upper end of the range"][end];
    let why = match range.span() {
        Span::Symmetric => "Drag or type; the range stays as far below 0 as above it",
        _ => "Drag or type to hold the range there",
    };
    let drag = ui.add(
        egui::DragValue::new(&mut value)
            .speed(step)
            .fixed_decimals(Range::digits(step))
            .custom_formatter(|value, digits| {
                format!("{value:.0$}", digits.start()).replace('-', "−")
            })
            .update_while_editing(false),
    );
    drag.widget_info(|| egui::WidgetInfo {
        label: Some(name.into()),
        ..egui::WidgetInfo::drag_value(ui.is_enabled(), value)
    });
    if drag.on_hover_text(format!("{name}. {why}")).changed() {
        range.fix(end, value);
    }
}

/// Whether the range follows, and a button that begins anew. True when that was clicked.
fn range_ui(ui: &mut egui::Ui, range: &mut Range) -> bool {
    ui.horizontal(|ui| {
        let mut auto = range.is_automatic();
        let why = match range.span() {
            Span::Data => "Span the smallest and the largest value",
            _ => "Follow the largest value seen; off holds the range as it is",
        };
        let button = ui.selectable_label(auto, "Auto").on_hover_text(why);
        button.widget_info(|| {
            egui::WidgetInfo::selected(
                egui::accesskit::Role::Button,
                ui.is_enabled(),
                auto,
                "Range follows the values",
            )
        });
        if button.clicked() {
            auto = !auto;
            range.set_automatic(auto);
        }
        let why = "Reset range: follow the values anew, from what is there now";
        icon_button(ui, icon::ICON_RESTART_ALT, "Reset range", why).clicked()
    })
    .inner
}

/// The colours with round numbers beside them.
fn ramp_ui(
    ui: &egui::Ui,
    place: Rect,
    theme: &Theme,
    quantity: &Quantity,
    range: &Range,
    contour_step: Option<f64>,
) {
    let painter = ui.painter();
    let ramp = Rect::from_min_size(place.min, vec2(RAMP, place.height()));
    let y_at = |share: f64| ramp.bottom() - pixels::points(share) * ramp.height();
    let mut mesh = egui::Mesh::default();
    for i in 0..=STEPS {
        let share = i as f64 / STEPS as f64;
        let color = quantity.map.color(share);
        let first = mesh.vertices.len() as u32;
        for x in [ramp.left(), ramp.right()] {
            mesh.colored_vertex(pos2(x, y_at(share)), color);
        }
        if i > 0 {
            mesh.add_triangle(first - 2, first - 1, first);
            mesh.add_triangle(first - 1, first, first + 1);
        }
    }
    painter.add(mesh);
    let [low, high] = range.bounds();
    let share = |value: f64| (value - low) / (high - low);
    if let Some(step) = contour_step {
        let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
        for i in (first..=last).take(64) {
            let at = share(i as f64 * step);
            let y = y_at(at);
            // Light on dark colours, as on the skin.
            let [r, g, b] = quantity.map.at(at).map(u32::from);
            let ink = if 2 * r + 7 * g + b > 1100 {
                egui::Color32::from_black_alpha(120)
            } else {
                egui::Color32::from_white_alpha(110)
            };
            let line = Stroke::new(1.0, ink);
            painter.hline(ramp.x_range(), y, line);
        }
    }
    painter.rect_stroke(
        ramp,
        0.0,
        Stroke::new(1.0, theme.line),
        egui::StrokeKind::Outside,
    );
    let most = (f64::from(ramp.height()) / BETWEEN).clamp(2.0, 10.0) as usize;
    let digits = Range::digits(range.step(most));
    for value in range.ticks(most) {
        let y = y_at(share(value));
        painter.hline(
            ramp.right()..=ramp.right() + 4.0,
            y,
            Stroke::new(1.0, theme.weak_text),
        );
        let mut x = ramp.right() + 8.0;
        if quantity.map == Map::Cyclic {
            direction(painter, pos2(x + 7.0, y), value, theme);
            x += 19.0;
        }
        let words = if quantity.unit == "°" {
            quantity.written(value, digits)
        } else {
            // The unit stands over the ramp.
            Quantity {
                unit: "",
                ..*quantity
            }
            .written(value, digits)
        };
        painter.text(
            pos2(x, y),
            Align2::LEFT_CENTER,
            words,
            FontId::proportional(12.0),
            theme.text,
        );
    }
}

/// A short line that lies as a direction does on the back, seen from behind.
fn direction(painter: &egui::Painter, at: egui::Pos2, degrees: f64, theme: &Theme) {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let half = vec2(pixels::points(cos), -pixels::points(sin)) * 6.0;
    painter.line_segment([at - half, at + half], Stroke::new(2.0, theme.text));
}

/// The menu of what can be shown, as a button with the name of what is. Answers with what was picked.
pub fn menu_ui(
    ui: &mut egui::Ui,
    colour: &SurfaceColour,
    remark: impl Fn(&Quantity) -> Option<&'static str>,
) -> Option<Option<&'static Quantity>> {
    let shown = colour.quantity();
    let mut picked = None;
    let words = shown.map_or("Skin", |q| q.name);
    let menu = ui.menu_button((icon::ICON_PALETTE.rich_text().size(15.0), words), |ui| {
        ui.set_min_width(200.0);
        let mut entry = |ui: &mut egui::Ui,
                         quantity: Option<&'static Quantity>,
                         name: &str,
                         why: &str,
                         remark: Option<&str>| {
            let on = shown == quantity;
            let mut button = egui::Button::selectable(on, name);
            if let Some(remark) = remark {
                button = button.right_text(RichText::new(remark).size(11.0).weak());
            }
            let response = ui.add(button).on_hover_text(why);
            let spoken = match remark {
                Some(remark) => format!("Colour by {name}: {remark}"),
                None => format!("Colour by {name}"),
            };
            response.widget_info(|| {
                egui::WidgetInfo::selected(
                    egui::accesskit::Role::MenuItemRadio,
                    ui.is_enabled(),
                    on,
                    &spoken,
                )
            });
            if response.clicked() {
                picked = Some(quantity);
                ui.close();
            }
        };
        entry(
            ui,
            None,
            "Skin",
            "The skin as it looks; nothing more is computed",
            None,
        );
        ui.separator();
        for quantity in crate::app::colours::all() {
            entry(
                ui,
                Some(quantity),
                quantity.name,
                quantity.about,
                remark(quantity),
            );
        }
    });
    let name = "Surface colour";
    named(ui, &menu.response, &format!("{name}: {words}"));
    menu.response.on_hover_text(
        "Surface colour: show strain, displacement or a map on the skin (C, Shift+C)",
    );
    picked
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_strip_takes_nothing_from_a_small_picture() {
        let rect = |w, h| Rect::from_min_size(pos2(10.0, 20.0), vec2(w, h));
        let (picture, strip) = split(rect(850.0, 700.0));
        let strip = strip.expect("there is room");
        assert_eq!(picture.right(), strip.left());
        assert_eq!(
            (picture.width() + strip.width(), strip.right()),
            (850.0, 860.0)
        );
        for small in [rect(300.0, 700.0), rect(850.0, 200.0)] {
            assert_eq!(split(small), (small, None));
        }
    }
}
