//! Recorder: record, mark, stop, open, replay, save.

mod ghosts;
mod playback;

use super::{Panel, PanelContext};
use crate::app::command::{Action, Command};
use crate::app::dock::Home;
use crate::app::messages::clock;
use crate::app::state::RecorderStatus;
use crate::app::widgets::{action_button, bytes, named, with_key};
use egui_material_icons::icons as icon;
use std::path::{Path, PathBuf};

/// Key of the panel.
pub const KEY: &str = "recorder";
/// The Recorder panel.
#[derive(Debug, Default)]
pub struct Recorder {
    path: String,
    /// What the next mark says.
    mark: String,
}

impl Panel for Recorder {
    fn key(&self) -> &'static str {
        KEY
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
            Some(playback) => {
                playback::ui(ui, cx, playback);
                ghosts::ui(ui, cx);
                ui.separator();
                if playback.events.is_empty() {
                    ui.weak("No event in this recording: marks, answers and edits are listed here");
                    recent_ui(ui, cx, &cx.view.recorder);
                } else {
                    playback::events_ui(ui, cx, playback);
                }
            }
            None => {
                self.record_ui(ui, cx, &cx.view.recorder);
                ui.separator();
                self.open_ui(ui, cx);
                recent_ui(ui, cx, &cx.view.recorder);
            }
        }
    }
}

impl Recorder {
    fn record_ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>, recorder: &RecorderStatus) {
        let theme = &cx.view.theme;
        match &recorder.recording {
            Some(path) => {
                ui.horizontal(|ui| {
                    action_button_as(ui, cx, Action::Record, icon::ICON_STOP, "Stop");
                    ui.label(
                        icon::ICON_FIBER_MANUAL_RECORD
                            .rich_text()
                            .color(theme.accent),
                    );
                    ui.monospace(clock(recorder.time_s));
                    ui.monospace(format!("{:>9}", bytes(recorder.bytes)));
                    if recorder.lost > 0 {
                        ui.colored_label(theme.warning, format!("{} ticks lost", recorder.lost))
                            .on_hover_text(
                                "The disk was slower than the servo: the gap is noted in the file",
                            );
                    }
                });
                self.mark_ui(ui, cx);
                ui.add(egui::Label::new(egui::RichText::new(file_name(path)).weak()).truncate())
                    .on_hover_text(path.display().to_string());
            }
            None => {
                ui.horizontal(|ui| {
                    let ready = cx.view.scene.is_some();
                    ui.add_enabled_ui(ready, |ui| {
                        let sign = icon::ICON_FIBER_MANUAL_RECORD;
                        action_button_as(ui, cx, Action::Record, sign, "Record");
                    });
                    if !recorder.recent.is_empty() {
                        action_button(ui, cx.send, Action::SaveRecordingAs, "Save last as…");
                    }
                });
                if let Some(reason) = &recorder.failed {
                    let text = format!(
                        "The last recording broke off: {reason}. What was written until then can be read"
                    );
                    let text = egui::RichText::new(text).color(theme.fault);
                    ui.add(egui::Label::new(text).wrap());
                }
                participant_ui(ui, cx, recorder);
                compress_ui(ui, cx, recorder);
                if recorder.recent.is_empty() {
                    let next = "Press Record and touch the back: every tick of every finger is written, and can be replayed here";
                    ui.add(egui::Label::new(egui::RichText::new(next).weak()).wrap());
                }
            }
        }
    }

    /// A note in the recording, to find the instant again.
    fn mark_ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        ui.horizontal(|ui| {
            let label = ui.label("Mark");
            let field = ui
                .add(
                    egui::TextEdit::singleline(&mut self.mark)
                        .hint_text("what happens now")
                        .desired_width((ui.available_width() - 96.0).max(60.0)),
                )
                .labelled_by(label.id)
                .on_hover_text("What the mark says; it may stay empty");
            let entered = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            let action = Action::Mark;
            let tooltip = with_key(ui.ctx(), action.spec().tooltip, action);
            let button = ui
                .button((icon::ICON_BOOKMARK_ADD.rich_text(), "Mark"))
                .on_hover_text(tooltip);
            named(ui, &button, "Mark this instant");
            if entered || button.clicked() {
                cx.send.send(Command::Mark(std::mem::take(&mut self.mark)));
            }
        });
    }

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

/// Whether recordings are compressed when they are finished.
fn compress_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, recorder: &RecorderStatus) {
    let mut on = recorder.compresses;
    let words = "Compress when finished";
    let check = ui.checkbox(&mut on, words).on_hover_text(
        "Half the size: the finished file is written anew beside itself, compared and renamed. While it records nothing is compressed",
    );
    check.widget_info(|| {
        egui::WidgetInfo::selected(
            egui::accesskit::Role::CheckBox,
            true,
            recorder.compresses,
            words,
        )
    });
    if on != recorder.compresses {
        cx.send.send(Command::SetCompressed(on));
    }
}

/// Whose recordings are made from now on.
fn participant_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, recorder: &RecorderStatus) {
    ui.horizontal(|ui| {
        let label = ui.label("Participant");
        let mut name = recorder.participant.clone();
        let field = ui
            .add(
                egui::TextEdit::singleline(&mut name)
                    .hint_text("a pseudonym, or nobody")
                    .char_limit(64)
                    .desired_width((ui.available_width() - 8.0).max(60.0)),
            )
            .labelled_by(label.id)
            .on_hover_text("Written into new recordings, to find and group them by. No names: nothing else personal is kept");
        if field.changed() {
            cx.send.send(Command::SetParticipant(name));
        }
    });
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
    fn a_file_is_called_by_its_last_part() {
        assert_eq!(file_name(Path::new("a/b.mcap")), "b.mcap");
    }
}
