//! Numbers laid on a colour map, and the bar that says which is which.

use crate::app::colours::map::Map;
use crate::app::theme::Theme;
use egui::{Color32, FontId, Rect, pos2, vec2};

/// Height of the bar, points.
const BAR: f32 = 9.0;
/// Width of the legend, points.
pub const WIDTH: f32 = 196.0;
/// Height of the legend, points.
pub const HEIGHT: f32 = 46.0;

/// Numbers laid on a colour map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The map.
    pub map: Map,
    /// The number at its start.
    pub low: f64,
    /// The number at its end.
    pub high: f64,
}

impl Scale {
    /// From `low` to `high`. An empty or unusable range becomes a small one, so that the legend reads well.
    pub fn new(map: Map, low: f64, high: f64) -> Self {
        let low = if low.is_finite() { low } else { 0.0 };
        let high = if high.is_finite() { high } else { low };
        if low < high {
            return Self { map, low, high };
        }
        let half = (0.01 * low.abs().max(high.abs())).max(1e-6);
        Self {
            map,
            low: low.min(high) - half,
            high: low.max(high) + half,
        }
    }

    /// As far below `middle` as above it.
    pub fn about(map: Map, middle: f64, reach: f64) -> Self {
        let reach = if reach.is_finite() { reach.abs() } else { 0.0 };
        Self::new(map, middle - reach, middle + reach)
    }

    /// The colour of a number; beyond the range that of its nearer end. What is no number is grey.
    pub fn colour(&self, value: f64) -> Color32 {
        if value.is_nan() {
            return Color32::GRAY;
        }
        let part = (value - self.low) / (self.high - self.low);
        let part = match self.map {
            Map::Cyclic => part,
            _ => part.clamp(0.0, 1.0),
        };
        let [r, g, b] = self.map.at(part);
        Color32::from_rgb(r, g, b)
    }
}

/// What a legend says.
pub struct Legend<'a> {
    /// What is shown, with its unit.
    pub title: &'a str,
    /// The colours.
    pub scale: Scale,
    /// Decimals of the numbers.
    pub decimals: usize,
    /// A line below, such as the largest value.
    pub note: Option<&'a str>,
}

/// Draws the legend with its lower right corner at that of `rect`.
pub fn legend(painter: &egui::Painter, rect: Rect, theme: &Theme, legend: &Legend<'_>) {
    let height = HEIGHT + if legend.note.is_some() { 14.0 } else { 0.0 };
    if rect.width() < WIDTH + 90.0 || rect.height() < height + 120.0 {
        return;
    }
    let place = Rect::from_min_size(
        rect.right_bottom() - vec2(WIDTH, height),
        vec2(WIDTH, height),
    );
    painter.rect_filled(place, 4.0, theme.panel.gamma_multiply(0.88));
    let inner = place.shrink2(vec2(8.0, 5.0));
    let font = FontId::proportional(11.5);
    painter.text(
        inner.left_top(),
        egui::Align2::LEFT_TOP,
        legend.title,
        font.clone(),
        theme.text,
    );
    let bar = Rect::from_min_size(
        pos2(inner.left(), inner.top() + 15.0),
        vec2(inner.width(), BAR),
    );
    let scale = &legend.scale;
    let mut mesh = egui::Mesh::default();
    let parts = 48;
    for i in 0..=parts {
        let part = f64::from(i) / f64::from(parts);
        let colour = scale.colour(scale.low + (scale.high - scale.low) * part);
        let x = bar.left() + bar.width() * part as f32;
        mesh.colored_vertex(pos2(x, bar.top()), colour);
        mesh.colored_vertex(pos2(x, bar.bottom()), colour);
        if i > 0 {
            let v = 2 * i as u32;
            mesh.add_triangle(v - 2, v - 1, v);
            mesh.add_triangle(v - 1, v + 1, v);
        }
    }
    painter.add(egui::Shape::mesh(mesh));
    let numbers = FontId::monospace(10.5);
    for (part, align) in [
        (0.0, egui::Align2::LEFT_TOP),
        (0.5, egui::Align2::CENTER_TOP),
        (1.0, egui::Align2::RIGHT_TOP),
    ] {
        let value = scale.low + (scale.high - scale.low) * part;
        // Adding zero after rounding turns −0 into 0.
        let text = format!("{:.*}", legend.decimals, value).replace("-0.0", "0.0");
        let text = if text == "-0" { "0".to_owned() } else { text };
        painter.text(
            pos2(bar.left() + bar.width() * part as f32, bar.bottom() + 1.0),
            align,
            text,
            numbers.clone(),
            theme.text,
        );
    }
    if let Some(note) = legend.note {
        painter.text(
            inner.left_bottom(),
            egui::Align2::LEFT_BOTTOM,
            note,
            font,
            theme.text,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_range_has_colours_and_the_ends_are_those_of_the_map() {
        for map in Map::ALL {
            for (low, high) in [
                (0.0, 1.0),
                (3.0, 3.0),
                (f64::NAN, 1.0),
                (5.0, -5.0),
                (0.0, f64::INFINITY),
            ] {
                let scale = Scale::new(map, low, high);
                assert!(scale.low < scale.high && scale.low.is_finite() && scale.high.is_finite());
                for value in [f64::NAN, f64::INFINITY, -1e300, 0.5] {
                    let _ = scale.colour(value);
                }
            }
        }
        let scale = Scale::about(Map::Diverging, 140.0, 20.0);
        assert_eq!(scale.colour(1e9), scale.colour(160.0));
        assert_eq!(scale.colour(-1e9), scale.colour(120.0));
        assert_ne!(scale.colour(160.0), scale.colour(120.0));
    }
}
