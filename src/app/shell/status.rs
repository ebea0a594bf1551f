//! The status bar: scenario, device, servo health, recording time. Numbers keep their width.

use crate::app::messages::clock;
use crate::app::panels::timing_health;
use crate::app::state::View;
use egui_material_icons::icons as icon;

/// Draws it.
pub fn ui(ui: &mut egui::Ui, view: &View) {
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
        field(ui, &scene, "The open scenario");
        ui.separator();
        field(ui, &devices(&view.devices), "What the fingers are moved by");
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
