//! Where a device is now, what it renders, and what its encoders and motors say; the last seconds of it as lines.

use super::trace::{SPAN_S, Sample, Trace};
use super::{PanelContext, figure, is_same};
use crate::app::editor::parts::pick;
use crate::app::hardware::{FingerDevice, InUse};
use crate::app::theme::Theme;
use crate::device::{MAX_FINGERS, Reading};
use egui::RichText;
use egui_plot::{Line, Plot};
use std::sync::Arc;
use std::time::Duration;

/// A device is looked at this often while nothing else wakes the window.
const LOOK_EVERY: Duration = Duration::from_millis(66);
/// Names of the axes of the subject.
const AXES: [&str; 3] = ["x", "y", "z"];

/// What is plotted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Plotted {
    #[default]
    Force,
    Position,
}

/// What the page keeps.
#[derive(Default)]
pub struct Live {
    traces: [Trace; MAX_FINGERS],
    /// What moved each finger when it was last looked at.
    devices: [Option<Arc<InUse>>; MAX_FINGERS],
    plotted: Plotted,
}

impl Live {
    /// Forgets the last seconds.
    pub fn release(&mut self) {
        self.traces.iter_mut().for_each(Trace::clear);
        self.devices = Default::default();
    }

    /// Draws it.
    pub fn ui(
        &mut self,
        ui: &mut egui::Ui,
        cx: &PanelContext<'_>,
        finger: usize,
        one: &FingerDevice,
    ) {
        let Some(record) = cx.view.live.record.fingers().get(finger) else {
            ui.weak("Nothing was read yet");
            return;
        };
        let reading = &record.reading;
        // Force over place is stiffness, and a place below known skin is depth.
        if cx.view.blind {
            self.release();
            ui.weak("Place, force, encoders and currents are hidden while the exercise runs");
            told_ui(ui, &cx.view.theme, one, reading);
            return;
        }
        let time_s = ui.input(|i| i.time);
        let trace = &mut self.traces[finger % MAX_FINGERS];
        let before = &mut self.devices[finger % MAX_FINGERS];
        let same = match (before.as_ref(), &one.device) {
            (Some(a), Some(b)) => is_same(a, b),
            (None, None) => true,
            _ => false,
        };
        if !same {
            trace.clear();
        }
        before.clone_from(&one.device);
        trace.push(Sample {
            time_s,
            position_mm: reading.position_mm,
            force_n: record.sent_force_n,
        });
        if one.device.is_some() {
            ui.request_repaint_after(LOOK_EVERY);
        }
        egui::Grid::new("axes")
            .num_columns(4)
            .spacing([8.0, 3.0])
            .show(ui, |ui| {
                ui.label("");
                let why = "To the subject's right, towards the head, out of the back";
                for axis in AXES {
                    head(ui, axis, why);
                }
                ui.end_row();
                let rows = [
                    (
                        "Position, mm",
                        "Where the finger is on the subject",
                        reading.position_mm,
                        2,
                    ),
                    (
                        "Velocity, mm/s",
                        "How fast it moves",
                        reading.velocity_mm_s,
                        1,
                    ),
                    (
                        "Force, N",
                        "What was sent to the device in the last tick",
                        record.sent_force_n,
                        2,
                    ),
                ];
                for (name, why, value, decimals) in rows {
                    ui.label(RichText::new(name).weak()).on_hover_text(why);
                    for x in value.to_array() {
                        ui.monospace(figure(x, 9, decimals));
                    }
                    ui.end_row();
                }
                if let Some(device) = &one.device {
                    wire_ui(ui, device);
                }
            });
        told_ui(ui, &cx.view.theme, one, reading);
        ui.add_space(4.0);
        let shown = self.plotted;
        ui.horizontal(|ui| {
            for (which, text) in [(Plotted::Force, "Force"), (Plotted::Position, "Position")] {
                let why = "Which of both is plotted over the last seconds";
                if pick(ui, shown == which, text, &format!("Plot {text}"), why) {
                    self.plotted = which;
                }
            }
            let colours = axis_colours(&cx.view.theme);
            for (axis, colour) in AXES.into_iter().zip(colours) {
                ui.label(RichText::new(format!("— {axis}")).color(colour));
            }
        });
        plot_ui(
            ui,
            &cx.view.theme,
            &self.traces[finger % MAX_FINGERS],
            shown,
        );
    }
}

fn head(ui: &mut egui::Ui, text: &str, why: &str) {
    let text = RichText::new(format!("{text:>9}")).monospace().weak();
    ui.label(text).on_hover_text(why);
}

/// Encoders and currents, as the wire has them.
fn wire_ui(ui: &mut egui::Ui, device: &InUse) {
    let Some(vitals) = &device.vitals else {
        return;
    };
    ui.label("");
    for axis in ["a", "b", "c"] {
        head(ui, axis, "Motors and encoders, as the device counts them");
    }
    ui.end_row();
    if device.capabilities.force_axes > 0 {
        ui.label(RichText::new("Current, mA").weak())
            .on_hover_text("Currents sent to the motors last");
        for ma in vitals.current_ma() {
            ui.monospace(format!("{ma:>9}"));
        }
        ui.end_row();
    }
    let raw = vitals.raw();
    for (name, part) in [("Encoders", &raw[..3]), ("", &raw[3..])] {
        if name.is_empty() && part.iter().all(|n| *n == 0) && device.calibration.rate.is_none() {
            // An arm without a wrist.
            continue;
        }
        let name = if name.is_empty() {
            "Wrist, turns"
        } else {
            name
        };
        ui.label(RichText::new(name).weak())
            .on_hover_text("Counts of the encoders, or deflections, as they came last");
        for n in part {
            ui.monospace(format!("{n:>9}"));
        }
        ui.end_row();
    }
}

/// Its buttons, and whether it answers.
fn told_ui(ui: &mut egui::Ui, theme: &Theme, one: &FingerDevice, reading: &Reading) {
    if let Some(device) = &one.device {
        buttons_ui(ui, theme, device, reading.buttons);
    }
    if !reading.connected {
        let text = RichText::new("The device does not answer: its last place is kept");
        ui.label(text.color(theme.warning));
    }
}

fn buttons_ui(ui: &mut egui::Ui, theme: &Theme, device: &InUse, pressed: u32) {
    let n = u32::from(device.capabilities.n_buttons).min(32);
    if n == 0 {
        return;
    }
    let clutch = device.calibration.mapping.clutch_button.map(u32::from);
    ui.horizontal_wrapped(|ui| {
        ui.weak("Buttons");
        for button in 1..=n {
            let on = pressed & (1 << (button - 1)) != 0;
            let colour = if on { theme.accent } else { theme.weak_text };
            let mark = if on { "●" } else { "○" };
            let kind = if clutch == Some(button) {
                " clutch"
            } else {
                ""
            };
            ui.label(RichText::new(format!("{mark} {button}{kind}")).color(colour));
        }
    });
}

/// Colours of the axes: none that a finger wears.
fn axis_colours(theme: &Theme) -> [egui::Color32; 3] {
    [theme.ghost(0), theme.ghost(1), theme.ghost(2)]
}

/// A round range around `low` and `high`, at least `least` wide, that does not jump with every digit.
fn frame(low: f64, high: f64, least: f64) -> (f64, f64) {
    let span = (high - low).max(least);
    let mut step = 1.0;
    while step * 8.0 < span && step < 1.0e6 {
        step *= 2.0;
    }
    let middle = 0.5 * (low + high);
    let (low, high) = (
        low.min(middle - 0.5 * least),
        high.max(middle + 0.5 * least),
    );
    ((low / step).floor() * step, (high / step).ceil() * step)
}

fn plot_ui(ui: &mut egui::Ui, theme: &Theme, trace: &Trace, plotted: Plotted) {
    let value = |s: &Sample| match plotted {
        Plotted::Force => s.force_n,
        Plotted::Position => s.position_mm,
    };
    let (low, high) = trace.range(value).unwrap_or((0.0, 0.0));
    let (low, high, title) = match plotted {
        // Zero stays in sight.
        Plotted::Force => {
            let (low, high) = frame(low.min(0.0), high.max(0.0), 2.0);
            (low, high, "Force (N)")
        }
        Plotted::Position => {
            let (low, high) = frame(low, high, 20.0);
            (low, high, "Position (mm)")
        }
    };
    ui.label(RichText::new(format!("{title}, last {SPAN_S:.0} s")).weak());
    let lines = (0..3).map(|axis| trace.line(|s| value(s)[axis]));
    let lines: Vec<_> = lines.zip(axis_colours(theme)).zip(AXES).collect();
    let response = Plot::new(title)
        .height(150.0)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .show_crosshair(false)
        .set_margin_fraction(egui::Vec2::ZERO)
        .y_axis_min_width(44.0)
        .x_axis_formatter(|mark, _| format!("{:.0} s", mark.value))
        .grid_color(theme.line)
        .show(ui, |plot| {
            plot.set_plot_bounds_x(-SPAN_S..=0.0);
            plot.set_plot_bounds_y(low..=high);
            for ((points, colour), name) in lines {
                plot.line(Line::new(name, points).color(colour).width(1.6));
            }
        });
    let name = format!("Figure: {title} over the last seconds");
    response
        .response
        .widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::Figure, true, &name));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_holds_what_it_is_around_and_is_never_flat() {
        for (low, high) in [(0.0, 0.0), (-3.2, 4.1), (100.0, 100.1), (-4e5, 7e5)] {
            let (a, b) = frame(low, high, 2.0);
            assert!(
                a <= low && b >= high && b - a >= 2.0,
                "{low} {high}: {a} {b}"
            );
        }
        assert_eq!(frame(0.0, 5.3, 2.0), frame(0.0, 5.9, 2.0));
    }
}
