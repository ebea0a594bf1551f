//! What the link to a device counts: reports, times between them, latency, and its rate against that of the loop.

use super::{PanelContext, finger_title};
use crate::app::hardware::InUse;
use crate::app::theme::Theme;
use crate::app::widgets::grouped;
use crate::device::Found;
use crate::device::hid::vitals::{BIN_US, Histogram, N_BINS};
use egui::RichText;
use egui_plot::{Bar, BarChart, Plot, VLine};
use std::time::Duration;

/// Rates are found over at least this long, s.
const OVER_S: f64 = 1.0;
/// Longest time on the axis, ms. The last bin holds what is longer.
const END_MS: f64 = BIN_US * 1.0e-3 * N_BINS as f64;

/// Counts of two looks, and the rates between them.
#[derive(Debug, Default)]
pub struct Rate {
    of: Option<Found>,
    /// Time of the last look, s; reports of the device and ticks of the loop then.
    last: Option<(f64, [u64; 2])>,
    rates_hz: Option<[f64; 2]>,
}

impl Rate {
    /// Takes counts in; a count that fell begins anew.
    fn look(&mut self, time_s: f64, counts: [u64; 2]) {
        let Some((then_s, before)) = self.last else {
            self.last = Some((time_s, counts));
            return;
        };
        let fell = counts.iter().zip(before).any(|(now, then)| *now < then);
        if fell || time_s < then_s {
            (self.last, self.rates_hz) = (Some((time_s, counts)), None);
        } else if time_s - then_s >= OVER_S {
            let rate = |i: usize| (counts[i] - before[i]) as f64 / (time_s - then_s);
            self.rates_hz = Some([rate(0), rate(1)]);
            self.last = Some((time_s, counts));
        }
    }

    /// Draws it.
    pub fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>, finger: usize, device: &InUse) {
        let Some(vitals) = &device.vitals else {
            ui.weak("This device is reached through its maker's library or service, which tells nothing of its link");
            return;
        };
        if self.of.as_ref() != Some(&device.found) {
            *self = Self {
                of: Some(device.found.clone()),
                ..Self::default()
            };
        }
        let theme = &cx.view.theme;
        let counts = vitals.counts();
        let time_s = ui.input(|i| i.time);
        self.look(time_s, [counts.reports, cx.view.live.timing.ticks]);
        ui.request_repaint_after(Duration::from_millis(250));
        let hz = |i: usize| {
            self.rates_hz.map_or_else(
                || format!("{:>12} Hz", "—"),
                |r| format!("{:>12.0} Hz", r[i]),
            )
        };
        let nominal = device.capabilities.report_rate_hz;
        let states = if nominal > 0.0 {
            format!(" of {nominal:.0} stated")
        } else {
            String::new()
        };
        let rows: [(&str, String, &str, bool); 8] = [
            (
                "Device",
                hz(0) + &states,
                "Reports that came in the last second",
                false,
            ),
            (
                "Loop",
                hz(1),
                "Ticks of the servo in the last second: it reads the newest report",
                false,
            ),
            (
                "Reports",
                whole(counts.reports),
                "Reports that were understood",
                false,
            ),
            (
                "Lost",
                whole(counts.lost),
                "Reports that the device says it sent and that never came",
                counts.lost > 0,
            ),
            (
                "Skipped",
                whole(counts.skipped),
                "Reports passed over because a newer one was there",
                false,
            ),
            (
                "Not understood",
                whole(counts.not_understood),
                "Reports of a wrong length or kind",
                counts.not_understood > 0,
            ),
            (
                "Written",
                whole(counts.written),
                "Reports sent to the device",
                false,
            ),
            (
                "Force taken off",
                whole(counts.taken_off),
                "Times that force was taken off because the device was silent, frozen or did what it should not",
                counts.taken_off > 0,
            ),
        ];
        egui::Grid::new("counts")
            .num_columns(2)
            .spacing([16.0, 2.0])
            .show(ui, |ui| {
                for (name, value, why, bad) in rows {
                    ui.label(RichText::new(name).weak()).on_hover_text(why);
                    let text = RichText::new(value).monospace();
                    let text = if bad { text.color(theme.warning) } else { text };
                    ui.label(text).on_hover_text(why);
                    ui.end_row();
                }
            });
        ui.add_space(6.0);
        let title = finger_title(finger);
        histogram_ui(ui, theme, title, "Time between reports", &vitals.interval);
        histogram_ui(
            ui,
            theme,
            title,
            "Latency, report to current",
            &vitals.latency,
        );
    }
}

fn whole(n: u64) -> String {
    let text = grouped(usize::try_from(n).unwrap_or(usize::MAX));
    format!("{text:>12}")
}

/// Median and 99th percentile in words.
fn quantiles(histogram: &Histogram) -> Option<[f64; 2]> {
    let ms = |share| histogram.quantile_us(share).map(|us| us * 1.0e-3);
    Some([ms(0.5)?, ms(0.99)?])
}

/// A time with its unit; what the last bin holds is at least that.
fn at_most(ms: f64) -> String {
    if ms >= END_MS - 1.0e-9 {
        format!("over {:.1} ms", END_MS - BIN_US * 1.0e-3)
    } else {
        format!("{ms:.1} ms")
    }
}

/// Bars of log₁₀(1 + count) over ms.
fn bars(bins: &[u64; N_BINS]) -> Vec<Bar> {
    let width = BIN_US * 1.0e-3;
    let counted = bins.iter().enumerate().filter(|(_, n)| **n > 0);
    counted
        .map(|(i, n)| {
            Bar::new((i as f64 + 0.5) * width, libm::log10(1.0 + *n as f64)).width(0.9 * width)
        })
        .collect()
}

fn histogram_ui(
    ui: &mut egui::Ui,
    theme: &Theme,
    finger: &str,
    title: &str,
    histogram: &Histogram,
) {
    let Some(quantiles) = quantiles(histogram) else {
        ui.weak(format!("{title}: nothing was counted yet"));
        return;
    };
    ui.label(RichText::new(format!("{title} (ms)")).weak());
    let text = format!(
        "median {}, 99 % within {}",
        at_most(quantiles[0]),
        at_most(quantiles[1])
    );
    ui.label(&text)
        .on_hover_text("Upper edges of bins of 0.1 ms");
    let bars = bars(&histogram.bins());
    let top = bars.iter().map(|b| b.value).fold(1.0, f64::max).ceil();
    let chart = BarChart::new(title, bars)
        .color(theme.accent)
        .element_formatter(Box::new(|bar, _| {
            let n = libm::pow(10.0, bar.value) - 1.0;
            format!("{:.2} ms: {n:.0} times", bar.argument)
        }));
    let response = Plot::new(title)
        .height(110.0)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .show_crosshair(false)
        .set_margin_fraction(egui::Vec2::ZERO)
        .y_axis_min_width(44.0)
        .y_axis_formatter(|mark, _| count_at(mark.value))
        .y_grid_spacer(move |_| {
            (0..=top as i32)
                .map(|i| egui_plot::GridMark {
                    value: f64::from(i),
                    step_size: 1.0,
                })
                .collect()
        })
        .x_axis_formatter(|mark, _| {
            // The last would be cut off.
            if mark.value < 0.97 * END_MS {
                format!("{:.0}", mark.value)
            } else {
                String::new()
            }
        })
        .grid_color(theme.line)
        .show(ui, |plot| {
            plot.set_plot_bounds_x(0.0..=END_MS);
            plot.set_plot_bounds_y(0.0..=1.08 * top);
            plot.bar_chart(chart);
            for (name, ms) in [("median", quantiles[0]), ("99 %", quantiles[1])] {
                plot.vline(VLine::new(name, ms).color(theme.text).width(1.0));
            }
        });
    let name = format!("Figure: {title} of {finger}, {text}");
    response
        .response
        .widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::Figure, true, &name));
}

/// The count at a mark of the logarithmic axis.
fn count_at(exponent: f64) -> String {
    let k = exponent.round();
    if (exponent - k).abs() > 1e-6 || !(0.0..=18.0).contains(&k) {
        return String::new();
    }
    match k as u32 {
        0 => "0".into(),
        k @ 1..=3 => 10_u64.pow(k).to_string(),
        k @ 4..=5 => format!("{} k", 10_u64.pow(k - 3)),
        k => format!("{} M", 10_u64.pow(k - 6)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_found_over_a_second_and_anew_when_counts_fall() {
        let mut rate = Rate::default();
        rate.look(10.0, [100, 5000]);
        rate.look(10.5, [600, 5500]);
        assert_eq!(rate.rates_hz, None);
        rate.look(12.0, [2100, 7000]);
        assert_eq!(rate.rates_hz, Some([1000.0, 1000.0]));
        rate.look(12.1, [3, 7100]);
        assert_eq!(rate.rates_hz, None);
        rate.look(14.1, [1003, 9100]);
        assert_eq!(rate.rates_hz, Some([500.0, 1000.0]));
    }

    #[test]
    fn a_single_long_wait_among_millions_has_a_bar_and_words() {
        let mut bins = [0; N_BINS];
        (bins[9], bins[N_BINS - 1]) = (5_000_000, 1);
        let bars = bars(&bins);
        assert_eq!(bars.len(), 2);
        assert!(bars[1].value > 0.3);
        assert_eq!(at_most(1.0), "1.0 ms");
        assert_eq!(at_most(END_MS), "over 9.9 ms");
        assert_eq!(count_at(3.0), "1000");
        assert_eq!(count_at(4.0), "10 k");
        assert_eq!(count_at(6.0), "1 M");
        assert_eq!(count_at(0.5), "");
    }
}
