//! Recorder: record, stop, open, replay, save.

use super::{Panel, PanelContext};
use crate::app::command::{Action, Command};
use crate::app::dock::Home;
use crate::app::messages::clock;
use crate::app::state::{PlaybackStatus, RecorderStatus};
use crate::app::widgets::{action_button, bytes, icon_button, named, with_key};
use egui_material_icons::icons as icon;
use std::path::{Path, PathBuf};

/// Speeds on offer.
const SPEEDS: [f64; 6] = [0.1, 0.25, 0.5, 1.0, 2.0, 4.0];

/// The Recorder panel.
#[derive(Debug, Default)]
pub struct Recorder {
    path: String,
}

impl Panel for Recorder {
    fn key(&self) -> &'static str {
        "recorder"
    }

    fn title(&self) -> &'static str {
        "Recorder"
    }

    fn tooltip(&self) -> &'static str {
        "Record what the fingers feel, and replay it"
    }

    fn home(&self) -> Home {
        Home::RightBottom
    }

    fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        match &cx.view.playback {
            Some(playback) => playback_ui(ui, cx, playback),
            None => record_ui(ui, cx, &cx.view.recorder),
        }
        ui.separator();
        self.open_ui(ui, cx);
        recent_ui(ui, cx, &cx.view.recorder);
    }
}

impl Recorder {
    fn open_ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        ui.horizontal(|ui| {
            let label = ui.label("Path");
            let field = ui
                .add(
                    egui::TextEdit::singleline(&mut self.path)
                        .hint_text("folder/recording.mcap")
                        .desired_width((ui.available_width() - 148.0).max(60.0)),
                )
                .labelled_by(label.id)
                .on_hover_text("A recording by its path, where there is no file dialog");
            let entered = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            let some = !self.path.trim().is_empty();
            let button = ui
                .add_enabled(some, egui::Button::new("Open"))
                .on_hover_text("Replay the recording at this path");
            named(ui, &button, "Open recording path");
            if some && (entered || button.clicked()) {
                cx.send
                    .send(Command::OpenRecording(PathBuf::from(self.path.trim())));
            }
            let browse = ui
                .button("Browse…")
                .on_hover_text(Action::OpenRecording.spec().tooltip);
            named(ui, &browse, "Browse for a recording…");
            if browse.clicked() {
                cx.send.act(Action::OpenRecording);
            }
        });
    }
}

fn record_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, recorder: &RecorderStatus) {
    match &recorder.recording {
        Some(path) => {
            ui.horizontal(|ui| {
                action_button_as(ui, cx, Action::Record, icon::ICON_STOP, "Stop");
                ui.label(
                    icon::ICON_FIBER_MANUAL_RECORD
                        .rich_text()
                        .color(cx.view.theme.accent),
                );
                ui.monospace(clock(recorder.time_s));
                ui.monospace(format!("{:>9}", bytes(recorder.bytes)));
                if recorder.lost > 0 {
                    ui.colored_label(
                        cx.view.theme.warning,
                        format!("{} ticks lost", recorder.lost),
                    );
                }
            });
            ui.label(egui::RichText::new(file_name(path)).weak())
                .on_hover_text(path.display().to_string());
        }
        None => {
            ui.horizontal(|ui| {
                let ready = cx.view.scene.is_some();
                ui.add_enabled_ui(ready, |ui| {
                    action_button_as(
                        ui,
                        cx,
                        Action::Record,
                        icon::ICON_FIBER_MANUAL_RECORD,
                        "Record",
                    );
                });
                if !recorder.recent.is_empty() {
                    action_button(ui, cx.send, Action::SaveRecordingAs, "Save last as…");
                }
            });
            let next = if recorder.recent.is_empty() {
                "Press Record and touch the back: every tick of every finger is written, and can be replayed here"
            } else {
                "Record another session, or replay one of these"
            };
            ui.add(egui::Label::new(egui::RichText::new(next).weak()).wrap());
        }
    }
}

fn action_button_as(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    action: Action,
    icon: egui_material_icons::MaterialIcon,
    text: &str,
) {
    let button = ui.button((icon.rich_text(), text)).on_hover_text(with_key(
        ui.ctx(),
        action.spec().tooltip,
        action,
    ));
    named(ui, &button, text);
    if button.clicked() {
        cx.send.act(action);
    }
}

fn playback_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, playback: &PlaybackStatus) {
    ui.horizontal(|ui| {
        ui.label(egui::RichText::new(file_name(&playback.path)).strong())
            .on_hover_text(playback.path.display().to_string());
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            action_button_as(
                ui,
                cx,
                Action::BackToLive,
                icon::ICON_SENSORS,
                "Back to live",
            );
        });
    });
    let mut time_s = playback.time_s;
    ui.spacing_mut().slider_width = (ui.available_width() - 8.0).max(80.0);
    let slider = ui
        .add(
            egui::Slider::new(&mut time_s, 0.0..=playback.duration_s.max(1e-3))
                .show_value(false)
                .trailing_fill(true),
        )
        .on_hover_text("Drag to go to any instant of the recording");
    slider.widget_info(|| egui::WidgetInfo::slider(true, playback.time_s, "Time in the recording"));
    if slider.changed() {
        cx.send.send(Command::Seek(time_s));
    }
    ui.horizontal(|ui| {
        let act = |ui: &mut egui::Ui, action: Action, icon, name: &str| {
            let tooltip = with_key(ui.ctx(), action.spec().tooltip, action);
            if icon_button(ui, icon, name, &tooltip).clicked() {
                cx.send.act(action);
            }
        };
        act(ui, Action::StepBack, icon::ICON_SKIP_PREVIOUS, "Step back");
        let (icon, name) = if playback.playing {
            (icon::ICON_PAUSE, "Pause recording")
        } else {
            (icon::ICON_PLAY_ARROW, "Play recording")
        };
        act(ui, Action::PlayPause, icon, name);
        act(
            ui,
            Action::StepForward,
            icon::ICON_SKIP_NEXT,
            "Step forward",
        );
        loop_ui(ui, cx, playback.looped);
        speed_ui(ui, cx, playback.speed);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.monospace(format!(
                "{} / {}",
                precise(playback.time_s),
                precise(playback.duration_s)
            ));
        });
    });
    ui.horizontal(|ui| {
        action_button(ui, cx.send, Action::SaveRecordingAs, "Save as…");
    });
}

fn loop_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, looped: bool) {
    let theme = &cx.view.theme;
    let colour = if looped {
        theme.accent
    } else {
        theme.weak_text
    };
    let icon = icon::ICON_REPEAT.rich_text().size(16.0).color(colour);
    let toggle = ui
        .add(egui::Button::new(icon).frame(false))
        .on_hover_text("Start over at the end");
    toggle.widget_info(|| {
        egui::WidgetInfo::selected(egui::accesskit::Role::CheckBox, true, looped, "Loop")
    });
    if toggle.clicked() {
        cx.send.send(Command::SetLooped(!looped));
    }
}

fn speed_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, speed: f64) {
    let response = egui::ComboBox::from_id_salt("speed")
        .selected_text(speed_name(speed))
        .width(56.0)
        .show_ui(ui, |ui| {
            for choice in SPEEDS {
                if ui
                    .selectable_label(choice == speed, speed_name(choice))
                    .clicked()
                {
                    cx.send.send(Command::SetSpeed(choice));
                }
            }
        })
        .response
        .on_hover_text("How fast time runs; 1× is as it was");
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::accesskit::Role::ComboBox, true, "Replay speed")
    });
}

fn speed_name(speed: f64) -> String {
    format!("{speed}×")
}

fn precise(time_s: f64) -> String {
    let s = time_s.max(0.0);
    format!("{}.{:02}", clock(s), (s.fract() * 100.0) as u32)
}

fn recent_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, recorder: &RecorderStatus) {
    if recorder.recent.is_empty() {
        return;
    }
    ui.label(egui::RichText::new("Recent recordings").weak())
        .on_hover_text(recorder.folder.display().to_string());
    egui::ScrollArea::vertical()
        .auto_shrink(false)
        .show(ui, |ui| {
            for file in &recorder.recent {
                ui.horizontal(|ui| {
                    let name = file_name(&file.path);
                    let button = ui
                        .add(egui::Button::new(name.as_str()).frame(false))
                        .on_hover_text(format!("Replay {}", file.path.display()));
                    named(ui, &button, &format!("Replay {name}"));
                    if button.clicked() {
                        cx.send.send(Command::OpenRecording(file.path.clone()));
                    }
                    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                        ui.label(egui::RichText::new(bytes(file.bytes)).monospace().weak());
                    });
                });
            }
        });
}

fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(
        || path.display().to_string(),
        |n| n.to_string_lossy().into(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_speeds_read_well() {
        assert_eq!(precise(61.256), "01:01.25");
        assert_eq!(speed_name(0.25), "0.25×");
        assert_eq!(speed_name(1.0), "1×");
        assert_eq!(file_name(Path::new("a/b.mcap")), "b.mcap");
    }
}
