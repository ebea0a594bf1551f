//! A cross-section: a line drawn over the map, and values along it.

use super::canvas::Lay;
use super::handles;
use super::ink::{Ink, halo_text};
use super::plane::Area;
use crate::app::theme::Theme;
use crate::geom::Vec2;
use egui::{Align2, FontId, Stroke};
use egui_plot::{Line, LineStyle, Plot, PlotPoints, VLine};

/// Samples along the line.
const SAMPLES: usize = 241;
/// Shortest line, mm.
const SHORTEST_MM: f64 = 1.0;

/// Where the map is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Whether it is on show.
    pub on: bool,
    /// Its ends A and B, mm.
    pub ends: [Vec2; 2],
    /// Where on it the pointer is, mm from A.
    pub cursor_mm: Option<f64>,
}

impl Default for Section {
    fn default() -> Self {
        Self {
            on: false,
            ends: [Vec2::new(-120.0, 300.0), Vec2::new(120.0, 300.0)],
            cursor_mm: None,
        }
    }
}

/// One line of the plot.
pub struct Series<'a> {
    /// What it is called.
    pub name: &'a str,
    /// Its colour.
    pub colour: egui::Color32,
    /// Dashed: beside what is in use.
    pub dashed: bool,
    /// Values along the section.
    pub values: Vec<f64>,
}

impl Section {
    /// Its length, mm.
    pub fn length_mm(&self) -> f64 {
        self.ends[0].distance(self.ends[1])
    }

    /// Across `area`, at two thirds of its height.
    pub fn across(area: &Area) -> [Vec2; 2] {
        let (lo, size) = (area.min, area.size());
        [
            lo + size * Vec2::new(0.08, 0.66),
            lo + size * Vec2::new(0.92, 0.66),
        ]
    }

    /// A place on it, mm from A.
    pub fn place(&self, at_mm: f64) -> Vec2 {
        let part = at_mm / self.length_mm().max(1e-12);
        self.ends[0].lerp(self.ends[1], part)
    }

    /// Distances from A of its samples, mm.
    pub fn distances(&self) -> impl Iterator<Item = f64> + use<> {
        let step = self.length_mm() / (SAMPLES - 1) as f64;
        (0..SAMPLES).map(move |i| i as f64 * step)
    }

    /// Values of `f` along it.
    pub fn values(&self, mut f: impl FnMut(Vec2) -> f64) -> Vec<f64> {
        self.distances().map(|d| f(self.place(d))).collect()
    }

    /// Draws the line with its ends, which can be dragged; true when one moved.
    pub fn on_canvas(&mut self, ui: &mut egui::Ui, lay: Lay, theme: &Theme) -> bool {
        if !self.on {
            return false;
        }
        let [a, b] = self.ends.map(|p| lay.at(p));
        let painter = ui.painter().with_clip_rect(lay.rect);
        painter.line_segment([a, b], Stroke::new(3.5, theme.inset.gamma_multiply(0.7)));
        painter.line_segment([a, b], Stroke::new(1.6, theme.text));
        let mut moved = false;
        for (i, name) in ["A", "B"].into_iter().enumerate() {
            let at = self.ends[i];
            let id = ui.scope_id().with(("section", i));
            let said = format!("End {name} of the section");
            let tooltip = "End of the section. Drag it, or push it with the arrow keys";
            let g = handles::grip(ui, lay, id, at, &said, tooltip);
            let to = g.to_mm.or(g.push_mm.map(|push| at + push));
            if let Some(to) = to.filter(|to| to.distance(self.ends[1 - i]) > SHORTEST_MM) {
                self.ends[i] = to;
                moved = true;
            }
            let p = lay.at(self.ends[i]);
            painter.circle_filled(p, 4.5, theme.inset);
            let ring = if g.response.has_focus() {
                Stroke::new(2.0, theme.accent)
            } else {
                Stroke::new(1.6, theme.text)
            };
            painter.circle_stroke(p, 4.5, ring);
            let font = FontId::proportional(12.0);
            let above = p - egui::vec2(0.0, 7.0);
            halo_text(
                &painter,
                above,
                Align2::CENTER_BOTTOM,
                name,
                &font,
                Ink::of(theme),
            );
        }
        if let Some(at_mm) = self.cursor_mm {
            painter.circle_filled(lay.at(self.place(at_mm)), 3.5, theme.accent);
        }
        moved
    }

    /// Plots `series` over the distance from A. `unit` is that of the values, `span` the values in view.
    pub fn plot(
        &mut self,
        ui: &mut egui::Ui,
        theme: &Theme,
        name: &str,
        unit: &str,
        span: (f64, f64),
        series: &[Series<'_>],
    ) {
        let length_mm = self.length_mm();
        let distances: Vec<f64> = self.distances().collect();
        let unit_owned = unit.to_owned();
        let room = 0.06 * (span.1 - span.0).max(1e-9);
        let plot = Plot::new(name)
            .height(150.0)
            .allow_drag(false)
            .allow_zoom(false)
            .allow_scroll(false)
            .allow_boxed_zoom(false)
            .allow_double_click_reset(false)
            .show_crosshair(false)
            .set_margin_fraction(egui::Vec2::ZERO)
            .y_axis_min_width(36.0)
            .grid_color(theme.line)
            .label_formatter(|_| None)
            .x_axis_formatter(|mark, _| format!("{:.0}", mark.value + 0.0))
            .x_axis_label("mm from A")
            .y_axis_label(unit_owned);
        let shown = plot.show(ui, |plot| {
            plot.set_plot_bounds_x(0.0..=length_mm);
            plot.set_plot_bounds_y(span.0 - room..=span.1 + room);
            for s in series {
                let points: Vec<[f64; 2]> = distances
                    .iter()
                    .zip(&s.values)
                    .filter(|(_, v)| v.is_finite())
                    .map(|(d, v)| [*d, *v])
                    .collect();
                let style = if s.dashed {
                    LineStyle::dashed_dense()
                } else {
                    LineStyle::Solid
                };
                plot.line(
                    Line::new(s.name, PlotPoints::from(points))
                        .color(s.colour)
                        .width(if s.dashed { 1.3 } else { 2.0 })
                        .style(style)
                        .allow_hover(false),
                );
            }
            if let Some(at_mm) = self.cursor_mm {
                plot.vline(VLine::new("cursor", at_mm).color(theme.accent).width(1.0));
            }
            plot.response()
                .hovered()
                .then(|| plot.pointer_coordinate())
                .flatten()
        });
        let before = self.cursor_mm;
        self.cursor_mm = shown
            .inner
            .map(|p| p.x)
            .filter(|x| (0.0..=length_mm).contains(x));
        if self.cursor_mm != before {
            ui.ctx().request_repaint();
        }
        // Which line is which, with the values under the pointer.
        let at = self.cursor_mm.unwrap_or(length_mm * 0.5);
        let index = (at / length_mm.max(1e-12) * (SAMPLES - 1) as f64).round() as usize;
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 10.0;
            for s in series {
                let value = s.values.get(index).copied().unwrap_or(f64::NAN);
                let decimals = super::backdrop::decimals_for((span.1 - span.0) / 300.0);
                ui.label(
                    egui::RichText::new(format!("{} {value:.decimals$}", s.name))
                        .size(12.0)
                        .color(s.colour),
                );
            }
            let from = match self.cursor_mm {
                Some(at) => format!("{unit} at {at:.0} mm"),
                None => format!("{unit} half way"),
            };
            ui.label(egui::RichText::new(from).size(12.0).weak());
        });
    }
}

/// Smallest and largest value of all series, not empty.
pub fn span_of(series: &[Series<'_>]) -> (f64, f64) {
    let all = series.iter().flat_map(|s| s.values.iter().copied());
    let (lo, hi) = all
        .filter(|v| v.is_finite())
        .fold((f64::MAX, f64::MIN), |(lo, hi), v| (lo.min(v), hi.max(v)));
    if lo > hi {
        return (0.0, 1.0);
    }
    let least = 1e-3 * lo.abs().max(hi.abs()).max(1e-3);
    if hi - lo < least {
        (lo - least, hi + least)
    } else {
        (lo, hi)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_run_from_end_to_end() {
        let section = Section {
            ends: [Vec2::new(0.0, 0.0), Vec2::new(30.0, 40.0)],
            ..Section::default()
        };
        assert_eq!(section.length_mm(), 50.0);
        let values = section.values(|p| p.length());
        for (d, v) in section.distances().zip(values) {
            assert!((d - v).abs() < 1e-9);
        }
        let none = Section {
            ends: [Vec2::ZERO; 2],
            ..section
        };
        assert!(none.values(|p| p.x).iter().all(|v| *v == 0.0));
    }
}
