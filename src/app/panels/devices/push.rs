//! The force test: the device pushes slowly along one axis, holds, and lets go.

use super::{PanelContext, add_button, figure, finger_title, state, wish};
use crate::app::editor::cells::{self, Cell};
use crate::app::editor::parts::pick;
use crate::app::hardware::{DeviceWish, FingerDevice, Hardware, InUse};
use crate::device::push::{FALL_S, HOLD_S, MOST_SHARE, RISE_S};
use egui::{RichText, vec2};
use std::time::Duration;

/// Where to push: axis, sign and words.
const WAYS: [(usize, f64, &str, &str); 6] = [
    (0, 1.0, "Right", "Along x, to the subject's right"),
    (0, -1.0, "Left", "Against x, to the subject's left"),
    (1, 1.0, "Headward", "Along y, towards the subject's head"),
    (1, -1.0, "Footward", "Against y, towards the subject's feet"),
    (2, 1.0, "Out", "Along z, out of the back"),
    (2, -1.0, "In", "Against z, into the back"),
];

/// The least force that can be asked for, N: less than this is friction.
const LEAST_N: f64 = 0.1;

/// What is chosen.
#[derive(Debug)]
pub struct Choices {
    way: usize,
    force_n: f64,
    told: Option<String>,
}

impl Default for Choices {
    fn default() -> Self {
        Self {
            way: 4,
            force_n: 1.0,
            told: None,
        }
    }
}

/// The most that a test may ask for, N; `None` for a device that renders no force.
fn most_n(device: &InUse) -> Option<f64> {
    let c = &device.capabilities;
    let most_n = MOST_SHARE * c.continuous_force_n.min(c.rated_force_n);
    (c.force_axes > 0 && most_n.is_finite() && most_n > LEAST_N).then_some(most_n)
}

/// Why no test can begin now.
fn barred(hardware: &Hardware, finger: &FingerDevice, force_enabled: bool) -> Option<&'static str> {
    if finger.test.is_some() {
        return Some("A test runs");
    }
    if !force_enabled {
        return Some("Force is off: allow force first");
    }
    if finger.gone || state::of(finger).severity != state::Severity::Good {
        return Some("The device does not answer as it should: see above");
    }
    hardware.locked
}

impl Choices {
    /// Draws it.
    pub fn ui(
        &mut self,
        ui: &mut egui::Ui,
        cx: &PanelContext<'_>,
        finger: usize,
        one: &FingerDevice,
        device: &InUse,
    ) {
        let title = finger_title(finger);
        let theme = &cx.view.theme;
        let Some(most_n) = most_n(device) else {
            ui.weak("This device renders no force that could be tested");
            return;
        };
        self.force_n = self.force_n.clamp(LEAST_N, most_n);
        let hardware = &*cx.view.hardware;
        let barred = barred(hardware, one, cx.view.force_enabled);
        ui.label(format!(
            "The device will push by itself: force rises for {RISE_S:.0} s, stays for {HOLD_S:.0} s and falls within \
             {FALL_S:.0} s. Hold it loosely, clear of the skin, with nothing in its way."
        ));
        ui.label(
            RichText::new(
                "Stop, Escape, a button of the device, the skin or a fault ends it at once.",
            )
            .weak(),
        );
        ui.add_space(4.0);
        ui.add_enabled_ui(one.test.is_none(), |ui| {
            ui.horizontal_wrapped(|ui| {
                ui.spacing_mut().item_spacing.x = 4.0;
                for (i, (_, _, text, why)) in WAYS.iter().enumerate() {
                    if pick(ui, self.way == i, text, &format!("Push {text}"), why) {
                        self.way = i;
                    }
                }
            });
            ui.horizontal(|ui| {
                ui.weak("Force");
                let tooltip = format!(
                    "Force at the top; {LEAST_N} to {most_n:.2} N is allowed, half of what the device holds without end"
                );
                let cell = Cell {
                    name: "Force of the test, N",
                    tooltip: &tooltip,
                    range: LEAST_N..=most_n,
                    decimals: 2,
                    unit: "N",
                    speed: 0.02,
                    width: 84.0,
                };
                let edit = cells::number(ui, &cell, self.force_n);
                if let Some(force_n) = edit.value {
                    self.force_n = force_n;
                    self.told = None;
                }
                if edit.told.is_some() {
                    self.told = edit.told;
                }
                ui.label(RichText::new(format!("of at most {most_n:.2} N")).weak());
            });
        });
        if let Some(told) = &self.told {
            ui.label(RichText::new(told).color(theme.warning));
        }
        ui.add_space(4.0);
        let size = vec2(
            ((ui.available_width() - 8.0) / 2.0).clamp(90.0, 220.0),
            44.0,
        );
        ui.horizontal(|ui| {
            let colour = if barred.is_none() {
                theme.on_accent
            } else {
                theme.weak_text
            };
            let text = RichText::new("Push").strong().size(16.0).color(colour);
            let push = egui::Button::new(text).min_size(size);
            let push = if barred.is_none() {
                push.fill(theme.accent)
            } else {
                push
            };
            let name = format!("Push with {title}");
            if add_button(ui, barred, push, &name, "Begin the force test") {
                let (axis, sign, _, _) = WAYS[self.way % WAYS.len()];
                let force_n = sign * self.force_n;
                wish(
                    cx,
                    DeviceWish::Test {
                        finger,
                        axis,
                        force_n,
                    },
                );
            }
            // Never greyed: it must work whatever the window believes.
            let text = RichText::new("Stop").strong().size(16.0).color(theme.fault);
            let stop = egui::Button::new(text)
                .min_size(size)
                .stroke(egui::Stroke::new(1.5, theme.fault));
            let name = format!("Stop push of {title}");
            if add_button(ui, None, stop, &name, "End the force test now") {
                wish(cx, DeviceWish::StopTest { finger });
            }
        });
        ui.add_space(4.0);
        match one.test {
            Some((force_n, share)) => {
                ui.request_repaint_after(Duration::from_millis(33));
                progress_ui(ui, force_n, share);
            }
            None => {
                progress_ui(ui, 0.0, 0.0);
                if let Some(why) = barred {
                    ui.label(RichText::new(why).color(theme.warning));
                }
            }
        }
    }
}

fn progress_ui(ui: &mut egui::Ui, force_n: f64, share: f64) {
    let share = if share.is_finite() {
        share.clamp(0.0, 1.0)
    } else {
        0.0
    };
    let bar = ui.horizontal(|ui| {
        ui.monospace(format!("{} N", figure(force_n, 6, 2)))
            .on_hover_text("Force that the device is told to render now");
        ui.add(egui::ProgressBar::new(share as f32).desired_height(12.0))
    });
    let bar = bar.inner;
    bar.widget_info(|| {
        let name = "Progress of the force test";
        egui::WidgetInfo::labeled(egui::accesskit::Role::ProgressIndicator, true, name)
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_a_way_along_and_against_each_axis() {
        for axis in 0..3 {
            let signs: f64 = WAYS.iter().filter(|w| w.0 == axis).map(|w| w.1).sum();
            let n = WAYS.iter().filter(|w| w.0 == axis).count();
            assert!(signs == 0.0 && n == 2);
        }
        let way = WAYS[Choices::default().way];
        assert_eq!((way.0, way.1), (2, 1.0), "out of the back first");
    }
}
