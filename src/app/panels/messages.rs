//! Messages: what the workbench had to say.

use super::{Panel, PanelContext};
use crate::app::command::Action;
use crate::app::dock::Home;
use crate::app::messages::{Level, Message};
use crate::app::theme::Theme;
use crate::app::widgets::{empty_ui, named};
use egui_material_icons::MaterialIcon;
use egui_material_icons::icons as icon;

/// The Messages panel.
#[derive(Debug)]
pub struct MessagesPanel {
    from: Level,
}

impl Default for MessagesPanel {
    fn default() -> Self {
        Self { from: Level::Info }
    }
}

impl Panel for MessagesPanel {
    fn key(&self) -> &'static str {
        "messages"
    }

    fn title(&self) -> &'static str {
        "Messages"
    }

    fn tooltip(&self) -> &'static str {
        "Errors, warnings and notes, with the time they came"
    }

    fn home(&self) -> Home {
        Home::RightBottom
    }

    fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        if cx.view.messages.is_empty() {
            empty_ui(
                ui,
                icon::ICON_CHECK,
                "No messages",
                "Errors and warnings will be listed here",
            );
            return;
        }
        self.toolbar_ui(ui, cx);
        ui.separator();
        egui::ScrollArea::vertical()
            .auto_shrink(false)
            .stick_to_bottom(true)
            .show(ui, |ui| {
                for message in self.shown(&cx.view.messages) {
                    message_ui(ui, message, &cx.view.theme);
                }
            });
    }
}

impl MessagesPanel {
    fn shown<'a>(&self, messages: &'a [Message]) -> impl Iterator<Item = &'a Message> {
        let from = self.from;
        messages.iter().filter(move |m| m.level >= from)
    }

    fn toolbar_ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        ui.horizontal(|ui| {
            for (level, text, tooltip) in [
                (Level::Info, "All", "Show everything"),
                (Level::Warning, "Warnings", "Show warnings and errors"),
                (Level::Error, "Errors", "Show errors only"),
            ] {
                ui.selectable_value(&mut self.from, level, text)
                    .on_hover_text(tooltip);
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let clear = ui
                    .button("Clear")
                    .on_hover_text(Action::ClearMessages.spec().tooltip);
                named(ui, &clear, "Clear messages");
                if clear.clicked() {
                    cx.send.act(Action::ClearMessages);
                }
                let copy = ui
                    .button("Copy")
                    .on_hover_text("Copy the listed messages, to paste them into a report");
                named(ui, &copy, "Copy messages");
                if copy.clicked() {
                    let text: Vec<String> = self.shown(&cx.view.messages).map(line).collect();
                    ui.copy_text(text.join("\n"));
                }
            });
        });
    }
}

/// A message as one line of text.
fn line(message: &Message) -> String {
    let times = if message.times > 1 {
        format!(" ({} times)", message.times)
    } else {
        String::new()
    };
    format!(
        "{} {}: {}{times}",
        message.time(),
        message.level.word(),
        message.text
    )
}

fn message_ui(ui: &mut egui::Ui, message: &Message, theme: &Theme) {
    let (icon, colour) = look(message.level, theme);
    ui.horizontal_top(|ui| {
        ui.label(egui::RichText::new(message.time()).monospace().weak());
        ui.label(icon.rich_text().color(colour))
            .on_hover_text(message.level.word());
        let mut text = message.text.clone();
        if message.times > 1 {
            text = format!("{text}  ×{}", message.times);
        }
        ui.add(egui::Label::new(text).wrap());
    });
}

fn look(level: Level, theme: &Theme) -> (MaterialIcon, egui::Color32) {
    match level {
        Level::Info => (icon::ICON_INFO, theme.weak_text),
        Level::Warning => (icon::ICON_WARNING, theme.warning),
        Level::Error => (icon::ICON_ERROR, theme.fault),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copied_line_has_time_level_text_and_count() {
        let message = Message {
            level: Level::Error,
            since_start: std::time::Duration::from_secs(75),
            text: "disk full".into(),
            times: 3,
        };
        assert_eq!(line(&message), "01:15 Error: disk full (3 times)");
    }
}
