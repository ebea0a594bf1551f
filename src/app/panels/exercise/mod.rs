//! Exercise: do one, or watch one being done.
//!
//! | file | draws |
//! |---|---|
//! | `before` | what the exercise of the scene asks, and its beginning |
//! | `trial` | the trial at hand, from its start to what is told of the answer |
//! | `answer` | the answers to choose from |
//! | `watch` | what only the instructor may see |

mod answer;
mod before;
mod trial;
mod watch;

use super::{Panel, PanelContext};
use crate::app::bench::Wish;
use crate::app::command::Command;
use crate::app::widgets::empty_ui;
use crate::training::Input;
use egui_material_icons::icons as icon;

/// The panel's key.
pub const KEY: &str = "exercise";

/// The Exercise panel.
#[derive(Default)]
pub struct ExercisePanel {
    before: before::Before,
    reply: answer::Replying,
    watch: watch::Watch,
    /// Number of the trial that the reply is about, and whether it is practice.
    trial: Option<(u32, bool)>,
}

impl Panel for ExercisePanel {
    fn key(&self) -> &'static str {
        KEY
    }

    fn title(&self) -> &'static str {
        "Exercise"
    }

    fn tooltip(&self) -> &'static str {
        "Find what is hidden in the back, answer, and see the score"
    }

    fn opens_at_first(&self) -> bool {
        false
    }

    fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        egui::ScrollArea::vertical()
            .auto_shrink(false)
            .show(ui, |ui| self.contents(ui, cx));
    }

    fn keep(&self) -> Option<String> {
        Some(self.before.participant.clone())
    }

    fn recall(&mut self, kept: &str) {
        kept.trim().clone_into(&mut self.before.participant);
    }
}

impl ExercisePanel {
    fn contents(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        let view = cx.view;
        if let Some(exercise) = &view.exercise {
            let trial = Some((exercise.shown.trial, exercise.shown.practice));
            if std::mem::replace(&mut self.trial, trial) != trial {
                self.reply = answer::Replying::default();
            }
            self.before.look_again();
            trial::ui(ui, cx, exercise, &mut self.reply);
            if view.role.sees_truth() {
                self.watch.ui(ui, cx, exercise);
            }
            return;
        }
        self.trial = None;
        match &view.scene {
            None => empty_ui(
                ui,
                icon::ICON_SCHOOL,
                "No exercise yet",
                "It appears as soon as the scene is built",
            ),
            Some(scene) => self.before.ui(ui, cx, scene),
        }
    }
}

/// Sends something of the exercise that runs.
fn send(cx: &PanelContext<'_>, input: Input) {
    cx.send.send(Command::Exercise(Wish::Do(input)));
}

/// Whether a key of the exercise was pressed that no text field or button takes.
fn pressed(ui: &egui::Ui, keys: &[egui::Key]) -> bool {
    let ctx = ui.ctx();
    let here = ui.clip_rect();
    let focus = ctx.memory(|m| m.focused());
    let taken = focus
        .and_then(|id| ctx.read_response(id))
        .is_some_and(|r| here.contains(r.rect.center()));
    !taken
        && !ctx.text_edit_focused()
        && ctx.input_mut(|i| {
            keys.iter()
                .any(|key| i.consume_key(egui::Modifiers::NONE, *key))
        })
}

/// Keys that go on: the second is what many foot switches send.
const ON: [egui::Key; 2] = [egui::Key::Space, egui::Key::PageDown];

/// A wide button that goes on to the next step, in the accent colour.
fn step_button(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    enabled: bool,
    text: &str,
    tooltip: &str,
) -> bool {
    let theme = &cx.view.theme;
    let words = egui::RichText::new(text).strong().color(theme.on_accent);
    let size = egui::vec2(ui.available_width().min(280.0), 32.0);
    let button = egui::Button::new(words).fill(theme.accent);
    let response = ui
        .add_enabled_ui(enabled, |ui| ui.add_sized(size, button))
        .inner
        .on_hover_text(format!("{tooltip} (Space, Page Down or a foot switch)"));
    crate::app::widgets::named(ui, &response, text);
    response.clicked() || enabled && pressed(ui, &ON)
}
