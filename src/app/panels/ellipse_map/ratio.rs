//! How far the printed location ratio is off the ellipse it means, over the ratio of its axes.

use crate::app::bench::Wake;
use crate::app::editor::worker::Worker;
use crate::app::theme::Theme;
use crate::lab::deform::{Excess, boundary_excess, excess_at};
use egui::RichText;
use egui_plot::{HLine, Line, Plot, PlotPoints, Points, VLine};

/// Axis ratios of the table; the second to the fourth are those of appendix C.
const RATIOS: [f64; 9] = [1.0, 1.049, 1.231, 1.357, 1.5, 2.0, 3.0, 4.0, 5.0];
/// The largest of appendix C.
const LARGEST: f64 = 1.357;

/// The table, worked out once, off the window's thread, when it is first looked at.
pub struct LocationRatio {
    worker: Worker<Vec<Excess>>,
    rows: Option<Vec<Excess>>,
}

impl Default for LocationRatio {
    fn default() -> Self {
        Self {
            worker: Worker::new("location ratio"),
            rows: None,
        }
    }
}

impl LocationRatio {
    /// The plot and the table.
    pub fn show(&mut self, ui: &mut egui::Ui, theme: &Theme, wake: &Wake) {
        if let Some(rows) = self.worker.poll(wake) {
            self.rows = Some(rows);
        }
        if self.rows.is_none() && !self.worker.is_busy() {
            let work = |_: &dyn Fn() -> bool| Some(RATIOS.into_iter().map(excess_at).collect());
            self.worker.ask(false, work, wake);
        }
        ui.label(
            RichText::new(
                "The printed location ratio (4.13) takes the polar angle for the parametric one: its boundary lies \
                 outside the ellipse it means.",
            )
            .size(12.0)
            .weak(),
        );
        self.plot(ui, theme);
        ui.horizontal_wrapped(|ui| {
            ui.label(
                RichText::new("boundary too far out")
                    .size(12.0)
                    .color(theme.accent),
            );
            ui.label(
                RichText::new("displacement off")
                    .size(12.0)
                    .color(theme.warning),
            );
            ui.label(
                RichText::new("line at 1.357: largest of appendix C")
                    .size(12.0)
                    .weak(),
            );
        });
        match &self.rows {
            Some(rows) => table(ui, rows),
            None => {
                ui.weak("Being worked out…");
            }
        }
    }

    fn plot(&self, ui: &mut egui::Ui, theme: &Theme) {
        let boundary: PlotPoints<'_> = (0..=160)
            .map(|i| 1.0 + f64::from(i) / 40.0)
            .map(|ratio| [ratio, 100.0 * boundary_excess(ratio)])
            .collect();
        let marks = |of: fn(&Excess) -> f64| -> Vec<[f64; 2]> {
            let rows = self.rows.iter().flatten();
            rows.map(|e| [e.axis_ratio, 100.0 * of(e)]).collect()
        };
        Plot::new("Location ratio: printed form against true ellipse")
            .height(150.0)
            .allow_drag(false)
            .allow_zoom(false)
            .allow_scroll(false)
            .allow_boxed_zoom(false)
            .allow_double_click_reset(false)
            .show_crosshair(false)
            .label_formatter(|_| None)
            .y_axis_min_width(36.0)
            .grid_color(theme.line)
            .x_axis_label("major ÷ minor axis")
            .y_axis_label("%")
            .show(ui, |plot| {
                plot.set_plot_bounds_x(0.95..=5.05);
                plot.set_plot_bounds_y(-8.0..=172.0);
                plot.hline(HLine::new("true ellipse", 0.0).color(theme.weak_text));
                plot.vline(VLine::new("largest of appendix C", LARGEST).color(theme.weak_text));
                plot.line(
                    Line::new("boundary", boundary)
                        .color(theme.accent)
                        .width(2.0)
                        .allow_hover(false),
                );
                plot.points(
                    Points::new("boundary, found", marks(|e| e.boundary))
                        .color(theme.accent)
                        .radius(3.0)
                        .allow_hover(false),
                );
                plot.points(
                    Points::new("displacement", marks(|e| e.displacement))
                        .color(theme.warning)
                        .radius(3.0)
                        .allow_hover(false),
                );
            });
    }
}

fn table(ui: &mut egui::Ui, rows: &[Excess]) {
    egui::Grid::new("location ratio")
        .num_columns(5)
        .spacing([12.0, 2.0])
        .striped(true)
        .show(ui, |ui| {
            for (head, why) in [
                ("ratio", "Major over minor axis"),
                ("boundary", "How much too far out it is where it is worst"),
                ("at", "Where that is, from the major axis"),
                ("area", "How much more it holds"),
                (
                    "off",
                    "Largest difference of the displacement, part of that at the centre",
                ),
            ] {
                ui.label(RichText::new(head).size(11.5).weak())
                    .on_hover_text(why);
            }
            ui.end_row();
            for e in rows {
                let worst = if e.boundary > 1e-9 {
                    format!("{:>4.0}°", e.direction_rad.to_degrees())
                } else {
                    format!("{:>5}", "–")
                };
                for text in [
                    format!("{:.3}", e.axis_ratio),
                    format!("{:>6.1} %", 100.0 * e.boundary),
                    worst,
                    format!("{:>6.1} %", 100.0 * e.area),
                    format!("{:>5.1} %", 100.0 * e.displacement),
                ] {
                    ui.label(RichText::new(text).monospace().size(12.0));
                }
                ui.end_row();
            }
        });
}
