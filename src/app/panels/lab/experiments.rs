//! Which experiments there are, by group.

use crate::app::laboratory::Laboratory;
use crate::lab::{self, group_of};
use egui::RichText;

/// Shows the list; a click chooses.
pub fn show(ui: &mut egui::Ui, laboratory: &mut Laboratory) {
    let running = laboratory.progress().map(|p| p.experiment);
    let chosen = laboratory.chosen().map(|e| e.name());
    egui::ScrollArea::vertical()
        .id_salt("experiments")
        .auto_shrink(false)
        .show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            let mut group = "";
            for experiment in lab::all() {
                let name = experiment.name();
                if group_of(name) != group {
                    if !group.is_empty() {
                        ui.add_space(7.0);
                    }
                    group = group_of(name);
                    ui.label(RichText::new(sentence(group)).strong());
                }
                let on = chosen == Some(name);
                let mut text = sentence(rest_of(name));
                if running == Some(name) {
                    text += " …";
                }
                let button = egui::Button::selectable(on, text)
                    .truncate()
                    .min_size(egui::vec2(ui.available_width() - 8.0, 20.0));
                let response = ui.add(button).on_hover_text(experiment.about());
                response.widget_info(|| {
                    egui::WidgetInfo::selected(
                        egui::accesskit::Role::RadioButton,
                        ui.is_enabled(),
                        on,
                        name,
                    )
                });
                if response.clicked() {
                    laboratory.choose(name);
                }
            }
        });
}

/// What an experiment is called within its group; its whole name where that is all.
fn rest_of(name: &str) -> &str {
    name.split_once('-').map_or(name, |(_, rest)| rest)
}

/// A name in file names as words: `box-size` is "Box size".
fn sentence(name: &str) -> String {
    capitalised(&name.replace('-', " "))
}

/// The same with its first letter in upper case.
pub fn capitalised(text: &str) -> String {
    let mut chars = text.chars();
    match chars.next() {
        Some(first) => first.to_uppercase().chain(chars).collect(),
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_as_words() {
        assert_eq!(sentence(rest_of("error-vs-time")), "Vs time");
        assert_eq!(sentence(rest_of("stability")), "Stability");
        assert_eq!(sentence(""), "");
    }
}
