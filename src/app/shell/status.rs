//! The status bar: scenario, device, servo health, recording time. Numbers keep their width.

use crate::app::command::{Command, CommandSender};
use crate::app::hardware::FingerDevice;
use crate::app::messages::clock;
use crate::app::panels::devices::{self, state};
use crate::app::panels::timing_health;
use crate::app::state::View;
use egui::{Label, RichText};
use egui_material_icons::icons as icon;

/// Most of the width that the scenario's name takes, and a device's, as shares.
const SCENE_SHARE: f32 = 0.28;
const DEVICE_SHARE: f32 = 0.17;

/// Draws it.
pub fn ui(ui: &mut egui::Ui, view: &View, send: &CommandSender) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 6.0;
        let scene = match (&view.build, &view.scene) {
            (Some(build), _) => format!(
                "Building {} {:>3.0} %",
                build.scenario,
                build.fraction * 100.0
            ),
            (None, Some(scene)) if view.unsaved && view.playback.is_none() => {
                format!("{} · edited", scene.scenario.name)
            }
            (None, Some(scene)) => scene.scenario.name.clone(),
            (None, None) => "No scene".into(),
        };
        let whole = ui.available_width();
        shortened(ui, RichText::new(&scene), whole * SCENE_SHARE)
            .on_hover_text("The open scenario");
        ui.separator();
        devices_ui(ui, view, send, whole * DEVICE_SHARE);
        ui.separator();
        let (text, colour) = timing_health(view.live.health, &view.theme);
        ui.label(icon::ICON_CIRCLE.rich_text().size(10.0).color(colour));
        field(ui, text, "Whether the servo keeps its rate");
        let late = view.live.timing.late_ticks;
        let late = egui::RichText::new(format!("{late:>4} late")).monospace();
        let late = if view.live.timing.late_ticks > 0 {
            late.color(view.theme.warning)
        } else {
            late.weak()
        };
        ui.label(late)
            .on_hover_text("Ticks that came too late; no force was sent in them");
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            session_ui(ui, view);
        });
    });
}

fn session_ui(ui: &mut egui::Ui, view: &View) {
    if let Some(playback) = &view.playback {
        let time = format!(
            "{} / {}",
            clock(playback.time_s),
            clock(playback.duration_s)
        );
        ui.monospace(time).on_hover_text("Time in the recording");
        ui.label(icon::ICON_HISTORY.rich_text().color(view.theme.accent));
        ui.label("Replay");
    } else if view.recorder.recording.is_some() {
        ui.monospace(clock(view.recorder.time_s))
            .on_hover_text("Time recorded");
        ui.label(
            icon::ICON_FIBER_MANUAL_RECORD
                .rich_text()
                .color(view.theme.accent),
        );
        ui.label("Recording");
    } else {
        ui.label(egui::RichText::new("Not recording").weak());
    }
}

/// Text on one line that takes `most` points at most.
fn shortened(ui: &mut egui::Ui, text: RichText, most: f32) -> egui::Response {
    ui.scope(|ui| {
        ui.set_max_width(most);
        ui.add(Label::new(text).truncate())
    })
    .inner
}

/// What moves the fingers: the mouse in a word; devices one by one, each with how it is.
fn devices_ui(ui: &mut egui::Ui, view: &View, send: &CommandSender, most: f32) {
    let fingers = &view.hardware.fingers;
    let mut clicked = false;
    if fingers.iter().all(|f| f.device.is_none() && !f.gone) {
        let response = shortened(ui, RichText::new(devices(&view.devices)), most);
        clicked |= opens(ui, view, response, "What the fingers are moved by");
    } else {
        for (i, finger) in fingers.iter().enumerate() {
            let told = told(i, finger);
            let colour = told.severity.colour(&view.theme);
            ui.label(icon::ICON_CIRCLE.rich_text().size(10.0).color(colour));
            let text = RichText::new(&told.text);
            let text = if told.severity == state::Severity::Good || finger.device.is_none() {
                text
            } else {
                text.color(colour)
            };
            let response = shortened(ui, text, most);
            clicked |= opens(ui, view, response, &told.tooltip);
        }
    }
    if clicked {
        send.send(Command::ShowPanel(devices::KEY));
    }
}

/// A label that opens the Devices panel, for who has panels; whether it was clicked.
fn opens(ui: &egui::Ui, view: &View, label: egui::Response, tooltip: &str) -> bool {
    if !view.role.offers_panels() {
        label.on_hover_text(tooltip);
        return false;
    }
    ui.interact(label.rect, label.id.with("opens"), egui::Sense::CLICK)
        .on_hover_cursor(egui::CursorIcon::PointingHand)
        .on_hover_text(format!("{tooltip}. A click opens Devices"))
        .clicked()
}

/// What the bar says of a finger.
struct Told {
    text: String,
    tooltip: String,
    severity: state::Severity,
}

fn told(index: usize, finger: &FingerDevice) -> Told {
    let state = state::of(finger);
    let device = finger.device.as_deref();
    let name = device.map_or_else(|| finger.name.clone(), devices::in_use);
    let letter = crate::app::panels::FINGER_NAMES[index % crate::app::panels::FINGER_NAMES.len()];
    // How it is comes first: the name may be cut off.
    let text = match state.short {
        "" => format!("{letter} {name}"),
        short => format!("{letter} {short}: {name}"),
    };
    let title = devices::finger_title(index);
    Told {
        text,
        tooltip: format!("{title}: {name}. {}", state.title),
        severity: state.severity,
    }
}

fn field(ui: &mut egui::Ui, text: &str, tooltip: &str) {
    ui.label(text).on_hover_text(tooltip);
}

/// Names of devices, counted when they are the same.
fn devices(names: &[String]) -> String {
    match names {
        [] => "No device".into(),
        [first, rest @ ..] if !rest.is_empty() && rest.iter().all(|n| n == first) => {
            format!("{first} ×{}", names.len())
        }
        _ => names.join(", "),
    }
}

#[cfg(test)]
mod tests {
    use super::devices;

    #[test]
    fn equal_devices_are_counted() {
        let names = |n: &[&str]| n.iter().map(|s| s.to_string()).collect::<Vec<_>>();
        assert_eq!(devices(&[]), "No device");
        assert_eq!(devices(&names(&["Mouse"])), "Mouse");
        assert_eq!(devices(&names(&["Mouse", "Mouse"])), "Mouse ×2");
        assert_eq!(devices(&names(&["Mouse", "Falcon"])), "Mouse, Falcon");
    }
}
