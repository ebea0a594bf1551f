//! Timing: how well the servo keeps time, and what frames cost.

use super::{Panel, PanelContext};
use crate::app::command::Action;
use crate::app::theme::Theme;
use crate::app::widgets::{action_button, empty_ui};
use crate::servo::{DURATION_BIN_US, Health, N_BINS, PERIOD_BIN_US};
use egui_material_icons::icons as icon;
use egui_plot::{Bar, BarChart, Plot};

/// The Timing panel.
#[derive(Debug, Default)]
pub struct Timing {}

impl Panel for Timing {
    fn key(&self) -> &'static str {
        "timing"
    }

    fn title(&self) -> &'static str {
        "Timing"
    }

    fn tooltip(&self) -> &'static str {
        "Whether the servo keeps its rate: late ticks, histograms, frame time"
    }

    fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        let live = &cx.view.live;
        let theme = &cx.view.theme;
        if live.health == Health::Stopped && live.timing.ticks == 0 {
            empty_ui(
                ui,
                icon::ICON_TIMER,
                "The servo is not running",
                "It starts with the first scene",
            );
            return;
        }
        egui::ScrollArea::vertical()
            .auto_shrink(false)
            .show(ui, |ui| {
                ui.horizontal(|ui| {
                    let (text, colour) = health(live.health, theme);
                    ui.label(egui::RichText::new(text).color(colour).strong());
                    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                        action_button(ui, cx.send, Action::ResetTiming, "Reset");
                    });
                });
                numbers_ui(ui, cx);
                ui.add_space(6.0);
                let height = ((ui.available_height() - 64.0) / 2.0).clamp(80.0, 220.0);
                histogram_ui(
                    ui,
                    "Time between ticks (µs)",
                    &live.timing.period_histogram,
                    PERIOD_BIN_US,
                    height,
                    theme,
                );
                histogram_ui(
                    ui,
                    "Duration of a tick (µs)",
                    &live.timing.duration_histogram,
                    DURATION_BIN_US,
                    height,
                    theme,
                );
            });
    }
}

/// A state of health in words, and its colour.
pub fn health(health: Health, theme: &Theme) -> (&'static str, egui::Color32) {
    match health {
        Health::Stopped => ("Servo stopped", theme.weak_text),
        Health::Good => ("Servo on time", theme.good),
        Health::Late => ("Servo late", theme.warning),
        Health::Fault => ("Servo fault", theme.fault),
    }
}

fn numbers_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>) {
    let t = &cx.view.live.timing;
    let f = &cx.view.frame;
    let rows: [(&str, String, &str); 7] = [
        (
            "Ticks",
            t.ticks.to_string(),
            "Ticks since the start or the last reset",
        ),
        (
            "Late ticks",
            t.late_ticks.to_string(),
            "Ticks that came too late: no force was sent in them",
        ),
        (
            "Lost records",
            t.lost_records.to_string(),
            "Records that found the ring full; they are missing in plots and recordings",
        ),
        (
            "Longest period",
            format!("{:.0} µs", t.longest_period_us),
            "Longest time between the start of two ticks",
        ),
        (
            "Mean tick",
            format!("{:.2} µs", t.mean_tick_us()),
            "What one tick of all fingers costs on average",
        ),
        (
            "Longest tick",
            format!("{:.1} µs", t.longest_tick_us),
            "The dearest tick",
        ),
        (
            "Frame",
            format!("{:.1} ms, longest {:.1} ms", f.last_ms, f.longest_ms),
            "Work per frame of the main window",
        ),
    ];
    egui::Grid::new("timing")
        .num_columns(2)
        .spacing([16.0, 2.0])
        .show(ui, |ui| {
            for (name, value, tooltip) in rows {
                ui.label(egui::RichText::new(name).weak())
                    .on_hover_text(tooltip);
                ui.monospace(value).on_hover_text(tooltip);
                ui.end_row();
            }
        });
}

/// Bars of log₁₀(1 + count), so that one late tick in a million is seen.
fn bars(histogram: &[u32; N_BINS], bin_us: f64) -> Vec<Bar> {
    histogram
        .iter()
        .enumerate()
        .filter(|(_, count)| **count > 0)
        .map(|(i, count)| {
            Bar::new(
                (i as f64 + 0.5) * bin_us,
                libm::log10(1.0 + f64::from(*count)),
            )
            .width(bin_us * 0.9)
        })
        .collect()
}

fn histogram_ui(
    ui: &mut egui::Ui,
    title: &str,
    histogram: &[u32; N_BINS],
    bin_us: f64,
    height: f32,
    theme: &Theme,
) {
    ui.label(egui::RichText::new(title).weak());
    let end_us = bin_us * N_BINS as f64;
    let top = histogram
        .iter()
        .map(|c| libm::log10(1.0 + f64::from(*c)))
        .fold(1.0, f64::max)
        .ceil();
    let chart = BarChart::new(title, bars(histogram, bin_us))
        .color(theme.accent)
        .element_formatter(Box::new(|bar, _| {
            format!(
                "{:.1} µs: {:.0} ticks",
                bar.argument,
                libm::pow(10.0, bar.value) - 1.0
            )
        }));
    Plot::new(title)
        .height(height)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .show_crosshair(false)
        .set_margin_fraction(egui::Vec2::ZERO)
        .y_axis_formatter(|mark, _| power_of_ten(mark.value))
        .x_grid_spacer(move |_| marks(end_us, end_us / 5.0))
        .x_axis_formatter(move |mark, _| {
            // The last would be cut off.
            if mark.value < 0.97 * end_us {
                format!("{:.0}", mark.value)
            } else {
                String::new()
            }
        })
        .y_grid_spacer(move |_| marks(top, (top / 3.0).ceil()))
        .y_axis_min_width(44.0)
        .grid_color(theme.line)
        .show(ui, |plot| {
            plot.set_plot_bounds_x(0.0..=end_us);
            plot.set_plot_bounds_y(0.0..=1.08 * top);
            plot.bar_chart(chart);
        });
}

/// Marks from zero to `top`, `step` apart.
fn marks(top: f64, step: f64) -> Vec<egui_plot::GridMark> {
    (0..16)
        .map(|i| f64::from(i) * step)
        .take_while(|value| *value <= top)
        .map(|value| egui_plot::GridMark {
            value,
            step_size: top,
        })
        .collect()
}

/// The count at a mark of a logarithmic axis.
fn power_of_ten(exponent: f64) -> String {
    let k = exponent.round();
    if (exponent - k).abs() > 1e-6 || !(0.0..=12.0).contains(&k) {
        return String::new();
    }
    match k as u32 {
        0 => "0".into(),
        1..=3 => 10_u64.pow(k as u32).to_string(),
        4..=5 => format!("{} k", 10_u64.pow(k as u32 - 3)),
        _ => format!("{} M", 10_u64.pow(k as u32 - 6)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_tick_among_millions_still_has_a_bar() {
        let mut histogram = [0; N_BINS];
        histogram[40] = 5_000_000;
        histogram[99] = 1;
        let bars = bars(&histogram, PERIOD_BIN_US);
        assert_eq!(bars.len(), 2);
        assert!(bars[1].value > 0.3);
        assert_eq!(bars[0].argument, 40.5 * PERIOD_BIN_US);
    }

    #[test]
    fn marks_of_the_count_axis_are_round() {
        assert_eq!(power_of_ten(3.0), "1000");
        assert_eq!(power_of_ten(5.0), "100 k");
        assert_eq!(power_of_ten(6.0), "1 M");
        assert_eq!(power_of_ten(0.5), "");
    }
}
