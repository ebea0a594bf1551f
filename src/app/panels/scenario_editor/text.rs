//! Name, description, and what differs from the file.

use super::State;
use super::doc::Doc;
use crate::app::command::Action;
use crate::app::editor::parts::row;
use crate::app::panels::PanelContext;
use crate::app::widgets::action_button;
use egui::{RichText, TextEdit};
use similar::{ChangeTag, TextDiff};
use std::sync::Arc;

/// Lines around a difference that are shown with it.
const AROUND: usize = 2;
/// Most lines shown.
const MOST_LINES: usize = 400;

/// Name and description.
pub fn about(ui: &mut egui::Ui, state: &mut State) {
    let width = (ui.available_width() - 110.0).max(80.0);
    let name = state.editing.doc().name.clone();
    row(ui, "Name", "What people see; 1 to 120 characters", |ui| {
        let mut text = name.clone();
        let field = ui
            .add(TextEdit::singleline(&mut text).desired_width(width))
            .on_hover_text("What people see; 1 to 120 characters");
        typed(
            ui,
            state,
            &field,
            "Rename scenario",
            "Name of the scenario",
            |doc| {
                doc.name.clone_from(&text);
            },
        );
    });
    let description = state.editing.doc().description.clone();
    row(
        ui,
        "Description",
        "One or two sentences on what it is for",
        |ui| {
            let mut text = description.clone();
            let field = ui
                .add(
                    TextEdit::multiline(&mut text)
                        .desired_width(width)
                        .desired_rows(3),
                )
                .on_hover_text("One or two sentences on what it is for");
            typed(
                ui,
                state,
                &field,
                "Describe scenario",
                "Description of the scenario",
                |doc| {
                    doc.description.clone_from(&text);
                },
            );
        },
    );
}

/// Takes what is typed: from focus to focus it is one step.
fn typed(
    ui: &egui::Ui,
    state: &mut State,
    field: &egui::Response,
    what: &'static str,
    name: &str,
    change: impl FnOnce(&mut Doc),
) {
    ui.ctx().accesskit_node_builder(field.id, |node| {
        node.set_label(name.to_owned());
    });
    if field.gained_focus() {
        state.editing.hold(what);
    }
    if field.changed() {
        let mut doc = state.editing.doc().clone();
        change(&mut doc);
        state.editing.set(what, doc);
    }
    if field.lost_focus() {
        state.editing.release();
    }
}

/// The lines that differ, worked out once for each pair of texts.
#[derive(Default)]
pub struct Diff {
    /// The text when the scene was opened, where the bench does not know its file.
    opened: String,
    of: Option<(Arc<str>, String)>,
    lines: Vec<Line>,
    more: usize,
}

/// A line of the difference.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Line {
    Same(String),
    Gone(String),
    New(String),
    Gap,
}

impl Diff {
    /// A scene with this text was opened.
    pub fn opened(&mut self, source: &str) {
        *self = Self {
            opened: source.to_owned(),
            ..Self::default()
        };
    }

    fn follow(&mut self, saved: Option<&Arc<str>>, now: &str) {
        let before: Arc<str> = match saved {
            Some(saved) => saved.clone(),
            None => self.opened.as_str().into(),
        };
        if self
            .of
            .as_ref()
            .is_some_and(|(a, b)| *a == before && b == now)
        {
            return;
        }
        (self.lines, self.more) = lines(&before, now);
        self.of = Some((before, now.to_owned()));
    }
}

fn lines(before: &str, now: &str) -> (Vec<Line>, usize) {
    let diff = TextDiff::from_lines(before, now);
    let mut out = Vec::new();
    for group in diff.grouped_ops(AROUND) {
        if !out.is_empty() {
            out.push(Line::Gap);
        }
        for op in group {
            for change in diff.iter_changes(&op) {
                let text = change.value().trim_end_matches(['\n', '\r']).to_owned();
                out.push(match change.tag() {
                    ChangeTag::Equal => Line::Same(text),
                    ChangeTag::Delete => Line::Gone(text),
                    ChangeTag::Insert => Line::New(text),
                });
            }
        }
    }
    let more = out.len().saturating_sub(MOST_LINES);
    out.truncate(MOST_LINES);
    (out, more)
}

/// What differs from the file, line by line.
pub fn differences(ui: &mut egui::Ui, cx: &PanelContext<'_>, state: &mut State) {
    let Some(scene) = &cx.view.scene else {
        return;
    };
    let theme = &cx.view.theme;
    let diff = &mut state.diff;
    diff.follow(cx.view.saved.as_ref(), &scene.scenario.source);
    if diff.lines.is_empty() {
        ui.weak("Nothing: the scene is as in its file");
        return;
    }
    ui.horizontal_wrapped(|ui| {
        action_button(ui, cx.send, Action::SaveScenario, "Save");
        action_button(ui, cx.send, Action::SaveScenarioAs, "Save as…");
    });
    egui::ScrollArea::horizontal()
        .id_salt("differences")
        .show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            for line in &diff.lines {
                let (sign, text, colour) = match line {
                    Line::Same(text) => (' ', text.as_str(), theme.weak_text),
                    Line::Gone(text) => ('−', text.as_str(), theme.warning),
                    Line::New(text) => ('+', text.as_str(), theme.good),
                    Line::Gap => ('⋯', "", theme.weak_text),
                };
                let text = RichText::new(format!("{sign} {text}"))
                    .monospace()
                    .size(11.5)
                    .color(colour);
                ui.add(egui::Label::new(text).extend());
            }
            if diff.more > 0 {
                ui.weak(format!("and {} more lines", diff.more));
            }
        });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_differs_is_listed_with_lines_around_it() {
        let before: String = (0..30).map(|i| format!("line {i}\n")).collect();
        let now = before.replace("line 10\n", "line ten\nand more\n");
        let (found, more) = lines(&before, &now);
        assert_eq!(more, 0);
        let text = |s: &str| s.to_owned();
        assert_eq!(
            found,
            [
                Line::Same(text("line 8")),
                Line::Same(text("line 9")),
                Line::Gone(text("line 10")),
                Line::New(text("line ten")),
                Line::New(text("and more")),
                Line::Same(text("line 11")),
                Line::Same(text("line 12")),
            ]
        );
        assert_eq!(lines(&before, &before).0, []);
        let two = now.replace("line 25\n", "");
        assert!(lines(&before, &two).0.contains(&Line::Gap));
    }
}
