//! A card for each finger: what moves it, how that is, and the first help.

use super::{PanelContext, button, finger_title, in_use, opening, state, told, wish};
use crate::app::editor::parts::choose;
use crate::app::hardware::{Attached, DeviceWish, FingerDevice, Hardware};
use egui::{RichText, vec2};
use egui_material_icons::icons as icon;

/// Draws the cards; a click on a name chooses the finger that the pages are about.
pub fn ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, chosen: &mut usize) {
    let hardware = &*cx.view.hardware;
    if hardware.fingers.is_empty() {
        ui.weak("Fingers come with the first scene");
    }
    for (index, finger) in hardware.fingers.iter().enumerate() {
        let on = *chosen == index;
        let theme = &cx.view.theme;
        let edge = if on { theme.accent } else { theme.line };
        egui::Frame::new()
            .fill(theme.inset)
            .stroke(egui::Stroke::new(1.0, edge))
            .corner_radius(4.0)
            .inner_margin(egui::Margin::symmetric(8, 6))
            .show(ui, |ui| {
                ui.set_width(ui.available_width());
                if card_ui(ui, cx, hardware, index, finger, on) {
                    *chosen = index;
                }
            });
    }
}

/// One card; whether its name was clicked.
fn card_ui(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    hardware: &Hardware,
    index: usize,
    finger: &FingerDevice,
    on: bool,
) -> bool {
    let theme = &cx.view.theme;
    let title = finger_title(index);
    let mut clicked = false;
    ui.horizontal(|ui| {
        let (dot, _) = ui.allocate_exact_size(vec2(12.0, 12.0), egui::Sense::hover());
        ui.painter()
            .circle_filled(dot.center(), 5.0, theme.finger(index));
        let why = "Show this finger on the pages below";
        let label = ui.selectable_label(on, title);
        label.widget_info(|| {
            let role = egui::accesskit::Role::RadioButton;
            egui::WidgetInfo::selected(role, true, on, format!("Finger {title}"))
        });
        clicked = label.on_hover_text(why).clicked();
        let width = (ui.available_width() - 12.0).clamp(80.0, 320.0);
        chooser_ui(ui, cx, hardware, index, finger, width);
    });
    let opening = opening(hardware, index).is_some();
    let mut state = state::of(finger);
    if opening {
        state.title = "Being opened".into();
    }
    let colour = state.severity.colour(theme);
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 6.0;
        ui.label(icon::ICON_CIRCLE.rich_text().size(10.0).color(colour));
        ui.label(RichText::new(&state.title).color(colour));
        if finger.device.is_none() && !opening {
            return;
        }
        let latched = (!state.is_latched).then_some("No fault is latched");
        let name = format!("Release {title}");
        let why =
            "Let a latched fault go: force comes back with the next report. Hold the device first";
        let text = RichText::new("Release");
        let text = if state.is_latched {
            text.strong().color(theme.fault)
        } else {
            text
        };
        if button(ui, latched, text, &name, why) {
            wish(cx, DeviceWish::Release { finger: index });
        }
        let name = format!("Recentre {title}");
        let why = "Take where the device stands now for the middle of its workspace over the back";
        let barred = hardware.locked.or(opening.then_some("It is being opened"));
        if button(ui, barred, "Recentre", &name, why) {
            wish(cx, DeviceWish::Recentre { finger: index });
        }
    });
    clicked
}

fn chooser_ui(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    hardware: &Hardware,
    index: usize,
    finger: &FingerDevice,
    width: f32,
) {
    let now = match (&finger.device, opening(hardware, index)) {
        (Some(device), _) => in_use(device),
        (None, Some(a)) => told(&a.found.title, a.emulated),
        (None, None) => "Mouse".into(),
    };
    let mouse = ("Mouse".to_owned(), now == "Mouse", None);
    let attached = hardware.attached.iter().map(|a| {
        let on = a.finger == Some(index);
        (
            offer(a, index, &hardware.attached),
            on,
            Some(a.found.clone()),
        )
    });
    let name = format!("Device of {}", finger_title(index));
    let why = hardware
        .locked
        .unwrap_or("What moves this finger: the mouse, or a device that is attached");
    let items: Vec<_> = std::iter::once(mouse).chain(attached).collect();
    let picked = ui.add_enabled_ui(hardware.locked.is_none(), |ui| {
        choose(ui, &name, why, &now, width, items)
    });
    if let Some(found) = picked.inner {
        wish(
            cx,
            DeviceWish::Assign {
                finger: index,
                found,
            },
        );
    }
}

/// An attached device in the list of a finger: enough to tell it from the others.
fn offer(device: &Attached, finger: usize, all: &[Attached]) -> String {
    let found = &device.found;
    let mut text = told(&found.title, device.emulated);
    let alike = all.iter().filter(|a| a.found.title == found.title).count();
    if alike > 1 {
        let which = found.serial.as_deref().unwrap_or(&found.place);
        text += &format!(" · {which}");
    }
    if let Some(other) = device.finger.filter(|f| *f != finger) {
        text += &format!(" · moves {} now", finger_title(other));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::Found;

    fn attached(title: &str, serial: Option<&str>, finger: Option<usize>) -> Attached {
        Attached {
            found: Found {
                family: "woodenhaptics",
                place: "/dev/hidraw3".into(),
                title: title.into(),
                serial: serial.map(Into::into),
                note: None,
            },
            emulated: false,
            finger,
            trouble: None,
        }
    }

    #[test]
    fn devices_that_look_alike_are_told_apart() {
        let alone = [attached("Arm", Some("7"), None)];
        assert_eq!(offer(&alone[0], 0, &alone), "Arm");
        let mut two = [
            attached("Arm", Some("7"), Some(1)),
            attached("Arm", None, None),
        ];
        two[1].emulated = true;
        assert_eq!(offer(&two[0], 0, &two), "Arm · 7 · moves Right now");
        assert_eq!(offer(&two[0], 1, &two), "Arm · 7");
        assert_eq!(offer(&two[1], 0, &two), "Arm (emulated) · /dev/hidraw3");
    }
}
