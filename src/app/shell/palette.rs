//! Find a command: every action and every panel by part of its name.

use super::Shared;
use crate::app::command::{Action, Command, panel_shortcut};
use egui::KeyboardShortcut;

/// The open palette.
#[derive(Debug, Default)]
pub struct Palette {
    text: String,
    chosen: usize,
}

struct Entry {
    text: String,
    tooltip: &'static str,
    shortcut: Option<KeyboardShortcut>,
    command: Command,
}

impl Palette {
    /// Draws it; answers whether it is to be closed.
    pub fn ui(&mut self, ctx: &egui::Context, shared: &Shared) -> bool {
        let mut done = false;
        let modal = egui::Modal::new(egui::Id::unique("palette")).show(ctx, |ui| {
            ui.set_width(420.0);
            let field = ui.add(
                egui::TextEdit::singleline(&mut self.text)
                    .hint_text("Find a command or a panel")
                    .desired_width(f32::INFINITY),
            );
            field.request_focus();
            let found: Vec<Entry> = entries(shared)
                .into_iter()
                .filter(|e| matches(&e.text, &self.text))
                .collect();
            let (up, down, enter) = ui.input(|i| {
                (
                    i.key_pressed(egui::Key::ArrowUp),
                    i.key_pressed(egui::Key::ArrowDown),
                    i.key_pressed(egui::Key::Enter),
                )
            });
            if field.changed() {
                self.chosen = 0;
            }
            self.chosen = (self.chosen + usize::from(down))
                .saturating_sub(usize::from(up))
                .min(found.len().saturating_sub(1));
            if found.is_empty() {
                ui.label(egui::RichText::new("Nothing has that name").weak());
            }
            egui::ScrollArea::vertical()
                .max_height(320.0)
                .show(ui, |ui| {
                    ui.set_width(ui.available_width());
                    for (i, entry) in found.iter().enumerate() {
                        let mut button = egui::Button::selectable(i == self.chosen, &entry.text);
                        if let Some(shortcut) = &entry.shortcut {
                            let mut text = egui::RichText::new(ui.ctx().format_shortcut(shortcut));
                            if i == self.chosen {
                                text = text.color(ui.visuals().selection.stroke.color);
                            }
                            button = button.shortcut_text(text);
                        }
                        let response = ui
                            .add_sized([ui.available_width(), 22.0], button)
                            .on_hover_text(entry.tooltip);
                        if i == self.chosen && (up || down) {
                            response.scroll_to_me(None);
                        }
                        if response.clicked() || enter && i == self.chosen {
                            shared.send.send(entry.command.clone());
                            done = true;
                        }
                    }
                });
        });
        done || modal.should_close()
    }
}

fn entries(shared: &Shared) -> Vec<Entry> {
    let actions = Action::ALL
        .into_iter()
        .filter(|a| *a != Action::Palette)
        .map(|action| {
            let spec = action.spec();
            Entry {
                text: spec.text.into(),
                tooltip: spec.tooltip,
                shortcut: spec.shortcut,
                command: Command::Do(action),
            }
        });
    let panels = shared.panels.iter().enumerate().map(|(i, slot)| Entry {
        text: format!("Panel {}", slot.title),
        tooltip: slot.tooltip,
        shortcut: panel_shortcut(i),
        command: Command::ShowPanel(slot.key),
    });
    actions.chain(panels).collect()
}

/// Whether every word of `query` begins somewhere in `text`, whatever the case.
fn matches(text: &str, query: &str) -> bool {
    let text = text.to_lowercase();
    query
        .to_lowercase()
        .split_whitespace()
        .all(|word| text.contains(word))
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn parts_of_words_in_any_order_find_a_command() {
        assert!(matches("Save recording as…", "rec save"));
        assert!(matches("Panel Plots", "PLO"));
        assert!(matches("Quit", ""));
        assert!(!matches("Quit", "plots"));
    }
}
