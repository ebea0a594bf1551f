//! Devices: what moves each finger, what is attached, how well it speaks, and how it is set.
//!
//! | file | answers |
//! |---|---|
//! | `state` | how a finger's device is, in words |
//! | `fingers` | a card for each finger |
//! | `attached` | what is attached, which kinds there are, devices without hardware |
//! | `live` | axes, buttons, encoders and currents now |
//! | `trace` | the last seconds of them |
//! | `push` | the force test |
//! | `stiffness` | how stiff a skin the device renders, beside that of the scene |
//! | `form` | the calibration, as a draft |
//! | `draft` | the numbers of a calibration, with what is allowed |
//! | `wire` | counts and times of the link |

mod attached;
mod draft;
mod fingers;
mod form;
mod live;
mod push;
pub mod state;
mod stiffness;
mod trace;
mod wire;

use super::{Panel, PanelContext};
use crate::app::command::Command;
use crate::app::dock::Home;
use crate::app::hardware::{Attached, DeviceWish, FingerDevice, Hardware, InUse};
use crate::app::state::View;
use crate::device::MAX_FINGERS;
use egui::RichText;
use egui_material_icons::icons as icon;
use std::sync::Arc;

/// Key of the panel.
pub const KEY: &str = "devices";

/// From this width on there are two columns, points.
const WIDE: f32 = 780.0;

/// What a finger is called.
pub fn finger_title(finger: usize) -> &'static str {
    const TITLES: [&str; MAX_FINGERS] = ["Left", "Right", "Second left", "Second right"];
    TITLES[finger % TITLES.len()]
}

/// What is shown beside the fingers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Page {
    #[default]
    Attached,
    Live,
    Push,
    Stiffness,
    Calibration,
    Wire,
}

impl Page {
    const ALL: [Self; 6] = [
        Self::Attached,
        Self::Live,
        Self::Push,
        Self::Stiffness,
        Self::Calibration,
        Self::Wire,
    ];

    fn words(self) -> &'static str {
        match self {
            Self::Attached => "Attached",
            Self::Live => "Live",
            Self::Push => "Force test",
            Self::Stiffness => "Stiffness",
            Self::Calibration => "Calibration",
            Self::Wire => "Link",
        }
    }

    fn why(self) -> &'static str {
        match self {
            Self::Attached => {
                "What is attached, which kinds of devices there are, and how to try one without hardware"
            }
            Self::Live => {
                "Where the device is, what it renders and what its encoders and motors say"
            }
            Self::Push => {
                "Let the device push slowly along one axis, to see that its motors do as they are told"
            }
            Self::Stiffness => {
                "How stiff a skin it renders without shaking, beside that of the scene"
            }
            Self::Calibration => "Its force, its guards and how it is laid over the subject",
            Self::Wire => "Time between reports, latency, and what was lost",
        }
    }
}

/// The Devices panel.
#[derive(Default)]
pub struct DevicesPanel {
    page: Page,
    /// The finger that the pages are about.
    finger: usize,
    attached: attached::Choices,
    live: live::Live,
    push: push::Choices,
    form: Option<form::Form>,
    stiffest: stiffness::Stiffest,
    rate: wire::Rate,
}

impl Panel for DevicesPanel {
    fn key(&self) -> &'static str {
        KEY
    }

    fn title(&self) -> &'static str {
        "Devices"
    }

    fn tooltip(&self) -> &'static str {
        "What moves each finger: choose, test and calibrate haptic devices"
    }

    fn home(&self) -> Home {
        Home::RightTop
    }

    fn opens_at_first(&self) -> bool {
        false
    }

    fn release(&mut self, _view: &View) {
        self.live.release();
    }

    fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        let hardware = &*cx.view.hardware;
        self.finger = self.finger.min(hardware.fingers.len().saturating_sub(1));
        let wide = ui.available_width() >= WIDE;
        if wide && self.page == Page::Attached {
            self.page = Page::Live;
        }
        self.notices_ui(ui, cx, hardware);
        if wide {
            ui.columns_const(|[left, right]| {
                scrolled(left, "left", |ui| {
                    fingers::ui(ui, cx, &mut self.finger);
                    attached::ui(ui, cx, &mut self.attached);
                });
                scrolled(right, "right", |ui| {
                    self.pages_ui(ui, true);
                    self.page_ui(ui, cx);
                });
            });
        } else {
            scrolled(ui, "all", |ui| {
                fingers::ui(ui, cx, &mut self.finger);
                self.pages_ui(ui, false);
                self.page_ui(ui, cx);
            });
        }
    }
}

fn scrolled(ui: &mut egui::Ui, name: &str, add: impl FnOnce(&mut egui::Ui)) {
    egui::ScrollArea::vertical()
        .id_salt(name)
        .auto_shrink(false)
        .show(ui, |ui| {
            // The bar floats over the content.
            ui.set_max_width((ui.available_width() - 8.0).max(80.0));
            add(ui);
        });
}

impl DevicesPanel {
    /// What matters whatever is shown: a test that pushes, what is being done, what may not be.
    fn notices_ui(&self, ui: &mut egui::Ui, cx: &PanelContext<'_>, hardware: &Hardware) {
        let theme = &cx.view.theme;
        for (finger, one) in hardware.fingers.iter().enumerate() {
            let shown = self.page == Page::Push && self.finger == finger;
            if let Some((force_n, _)) = one.test.filter(|_| !shown) {
                ui.horizontal(|ui| {
                    let text = format!("{} pushes, {force_n:>6.2} N", finger_title(finger));
                    ui.label(RichText::new(text).color(theme.warning).strong());
                    let name = format!("Stop push of {}", finger_title(finger));
                    if button(ui, None, "Stop", &name, "End the force test now") {
                        wish(cx, DeviceWish::StopTest { finger });
                    }
                });
            }
        }
        if let Some(working) = &hardware.working {
            ui.horizontal_wrapped(|ui| {
                ui.label(icon::ICON_HOURGLASS_EMPTY.rich_text().color(theme.accent));
                ui.label(working);
            });
        }
        if let Some(locked) = hardware.locked {
            ui.horizontal_wrapped(|ui| {
                ui.label(icon::ICON_LOCK.rich_text().color(theme.warning));
                ui.label(RichText::new(locked).color(theme.warning));
            });
        }
    }

    fn pages_ui(&mut self, ui: &mut egui::Ui, wide: bool) {
        ui.add_space(2.0);
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = egui::vec2(2.0, 2.0);
            let pages = Page::ALL.into_iter().skip(usize::from(wide));
            for page in pages {
                let on = self.page == page;
                let label = ui
                    .selectable_label(on, page.words())
                    .on_hover_text(page.why());
                let name = format!("Page {}", page.words());
                label.widget_info(|| {
                    egui::WidgetInfo::selected(egui::accesskit::Role::Tab, true, on, &name)
                });
                if label.clicked() {
                    self.page = page;
                }
            }
        });
        ui.separator();
    }

    fn page_ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        if self.page == Page::Attached {
            attached::ui(ui, cx, &mut self.attached);
            return;
        }
        let hardware = &*cx.view.hardware;
        let Some(one) = hardware.fingers.get(self.finger) else {
            ui.weak("Fingers come with the first scene");
            return;
        };
        let finger = self.finger;
        let (title, device) = (finger_title(finger), device_title(one));
        ui.label(RichText::new(format!("{title}: {device}")).strong());
        match (self.page, &one.device) {
            (Page::Live, _) => self.live.ui(ui, cx, finger, one),
            (_, None) if opening(hardware, finger).is_some() => {
                ui.weak("The device is being opened");
            }
            (_, None) => {
                ui.weak("The mouse has nothing to set here: choose a device for this finger above");
            }
            (Page::Push, Some(device)) => self.push.ui(ui, cx, finger, one, device),
            (Page::Stiffness, Some(device)) => self.stiffest.ui(ui, cx, finger, one, device),
            (Page::Calibration, Some(device)) => {
                let form = form::Form::of(&mut self.form, finger, device);
                form.ui(ui, cx, device);
            }
            (Page::Wire, Some(device)) => self.rate.ui(ui, cx, finger, device),
            (Page::Attached, _) => {}
        }
    }
}

/// What moves a finger, in a word or two.
fn device_title(finger: &FingerDevice) -> String {
    finger.device.as_deref().map_or("mouse".into(), in_use)
}

/// A device's name; a simulated one says so.
pub fn in_use(device: &InUse) -> String {
    let name = &device.capabilities.name;
    let name = if name.is_empty() {
        &device.found.title
    } else {
        name
    };
    told(name, device.emulated)
}

/// A name; that of a simulated device says so.
fn told(name: &str, emulated: bool) -> String {
    if emulated && !name.contains("emulated") {
        format!("{name} (emulated)")
    } else {
        name.to_owned()
    }
}

/// The device that is being opened for a finger.
fn opening(hardware: &Hardware, finger: usize) -> Option<&Attached> {
    let one = hardware.fingers.get(finger)?;
    let waits = one.device.is_none() && !one.gone;
    let for_it = |a: &&Attached| a.finger == Some(finger) && a.trouble.is_none();
    hardware.attached.iter().find(for_it).filter(|_| waits)
}

/// Sends a wish.
fn wish(cx: &PanelContext<'_>, wish: DeviceWish) {
    cx.send.send(Command::Device(wish));
}

/// A button that cannot be pressed while `barred` says why; whether it was pressed.
fn button(
    ui: &mut egui::Ui,
    barred: Option<&str>,
    text: impl Into<egui::WidgetText>,
    name: &str,
    tooltip: &str,
) -> bool {
    let button = egui::Button::new(text.into());
    add_button(ui, barred, button, name, tooltip)
}

/// The same for any button.
fn add_button(
    ui: &mut egui::Ui,
    barred: Option<&str>,
    button: impl egui::Widget,
    name: &str,
    tooltip: &str,
) -> bool {
    let response = ui.add_enabled(barred.is_none(), button);
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::accesskit::Role::Button, barred.is_none(), name)
    });
    response
        .on_hover_text(tooltip)
        .on_disabled_hover_text(barred.unwrap_or_default())
        .clicked()
}

/// A number of steady width; what is none or absurd is a dash.
fn figure(value: f64, width: usize, decimals: usize) -> String {
    if value.is_finite() && value.abs() < 1.0e5 {
        // No minus before a zero.
        let text = format!("{value:.decimals$}");
        let zero = text
            .trim_start_matches('-')
            .chars()
            .all(|c| "0.".contains(c));
        let text = if zero {
            text.trim_start_matches('-')
        } else {
            &text
        };
        format!("{text:>width$}")
    } else {
        format!("{:>width$}", "—")
    }
}

/// Whether two frames show the same device.
fn is_same(a: &Arc<InUse>, b: &Arc<InUse>) -> bool {
    a.found == b.found
}

#[cfg(test)]
mod tests {
    use super::figure;

    #[test]
    fn numbers_keep_their_width() {
        for value in [0.0, -0.001, 12.3456, -999.99, f64::NAN, f64::INFINITY, 1e9] {
            assert_eq!(figure(value, 8, 2).chars().count(), 8, "{value}");
        }
        assert_eq!(figure(-0.001, 6, 2), "  0.00");
        assert_eq!(figure(-0.01, 6, 2), " -0.01");
    }
}
