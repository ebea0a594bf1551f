//! Before an exercise: what it asks, who does it, and what was broken off.

use super::{PanelContext, step_button};
use crate::app::bench::{Unfinished, Wish, unfinished};
use crate::app::command::Command;
use crate::app::messages::clock;
use crate::app::widgets::{empty_ui, named};
use crate::scenario::exercise::Hides;
use crate::scenario::{self, Exercise, Scenario, Scene};
use crate::training::exercise;
use egui_material_icons::icons as icon;
use std::path::PathBuf;
use std::sync::Arc;

/// What is typed and found before an exercise.
#[derive(Default)]
pub struct Before {
    /// Pseudonym of the trainee.
    pub participant: String,
    /// Examples with an exercise: file and name; looked for once.
    examples: Option<Vec<(&'static str, String)>>,
    /// What was broken off in the exercise of the scene looked at last.
    unfinished: Option<(Arc<Scene>, Vec<Unfinished>)>,
}

impl Before {
    pub fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>, scene: &Arc<Scene>) {
        let scenario = &scene.scenario;
        match &scenario.exercise {
            None => self.without(ui, cx),
            Some(_) if cx.view.playback.is_some() => empty_ui(
                ui,
                icon::ICON_HISTORY,
                "A recording is on show",
                "Go back to live to exercise",
            ),
            Some(exercise) => self.with(ui, cx, scene, exercise),
        }
    }

    fn without(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        let next = if cx.view.role.sees_truth() {
            "Add one in the scenario editor, or open an example"
        } else {
            "Open a scenario with an exercise, or an example"
        };
        empty_ui(ui, icon::ICON_SCHOOL, "This scene has no exercise", next);
        let examples = self.examples.get_or_insert_with(examples);
        ui.add_space(8.0);
        ui.vertical_centered(|ui| {
            for (file, name) in examples.iter() {
                let button = ui
                    .button(name)
                    .on_hover_text("Open this example and its exercise");
                named(ui, &button, &format!("Open example {name}"));
                if button.clicked() {
                    cx.send.send(Command::OpenExample(file));
                }
            }
        });
    }

    fn with(
        &mut self,
        ui: &mut egui::Ui,
        cx: &PanelContext<'_>,
        scene: &Arc<Scene>,
        asked: &Exercise,
    ) {
        let task = exercise::by_key(asked.task);
        ui.heading(task.map_or(asked.task, |t| t.title()));
        if let Some(task) = task {
            ui.label(task.prompt(asked));
        }
        ui.add_space(4.0);
        egui::Grid::new("facts").num_columns(2).show(ui, |ui| {
            for (name, fact) in facts(asked) {
                ui.label(egui::RichText::new(name).weak());
                ui.label(fact);
                ui.end_row();
            }
        });
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            let label = ui.label("Trainee");
            ui.add(
                egui::TextEdit::singleline(&mut self.participant)
                    .hint_text("pseudonym, such as P07")
                    .char_limit(40)
                    .desired_width(180.0),
            )
            .labelled_by(label.id)
            .on_hover_text("Under which pseudonym answers are kept; no names");
        });
        ui.add_space(4.0);
        let text = "Begin";
        if step_button(ui, cx, true, text, "Begin with the first trial") {
            let participant = self.participant.trim().to_owned();
            cx.send.send(Command::Exercise(Wish::Begin { participant }));
        }
        self.unfinished_ui(ui, cx, scene);
    }

    fn unfinished_ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>, scene: &Arc<Scene>) {
        let known = (self.unfinished.as_ref()).is_some_and(|(of, _)| Arc::ptr_eq(of, scene));
        if !known {
            let found = unfinished(&cx.view.recorder.folder, &scene.scenario);
            self.unfinished = Some((Arc::clone(scene), found));
        }
        let Some((_, found)) = &self.unfinished else {
            return;
        };
        let mut wanted: Option<PathBuf> = None;
        if !found.is_empty() {
            ui.add_space(12.0);
            ui.label(egui::RichText::new("Broken off").strong());
        }
        for run in found {
            ui.horizontal(|ui| {
                let who = run.participant.as_deref().unwrap_or("nobody named");
                let (scored, of) = run.scored;
                let done = format!("{scored} of {of} answered");
                let button = ui
                    .button("Go on")
                    .on_hover_text(format!("Go on with trial {}", scored + 1));
                named(ui, &button, &format!("Go on with {who}, {done}"));
                if button.clicked() {
                    wanted = Some(run.folder.clone());
                }
                ui.label(format!("{who} · {done}"))
                    .on_hover_text(run.folder.display().to_string());
            });
        }
        if let Some(folder) = wanted {
            cx.send.send(Command::Exercise(Wish::Resume(folder)));
            self.unfinished = None;
        }
    }

    /// Looks again for what was broken off.
    pub fn look_again(&mut self) {
        self.unfinished = None;
    }
}

fn examples() -> Vec<(&'static str, String)> {
    let parsed = scenario::examples().iter().filter_map(|example| {
        let scenario = Scenario::parse(example.text, example.file, None).ok()?;
        scenario
            .exercise
            .is_some()
            .then_some((example.file, scenario.name))
    });
    parsed.collect()
}

/// What is worth knowing of an exercise before it begins.
fn facts(exercise: &Exercise) -> Vec<(&'static str, String)> {
    let mut facts = Vec::new();
    let practice = match exercise.practice {
        0 => String::new(),
        n => format!(", after {n} for practice"),
    };
    facts.push(("Trials", format!("{}{practice}", exercise.trials)));
    if let Hides::Drawn { kind, .. } = exercise.hides {
        let title = scenario::dysfunction::named(kind).map_or(kind, |k| k.title());
        facts.push(("Hidden", title.to_owned()));
        let n = exercise.candidates.len();
        facts.push(("Where", format!("one of {n} places")));
    }
    let limit = |s: Option<f64>| s.map_or("none".into(), clock);
    facts.push(("Time for a trial", limit(exercise.trial_limit_s)));
    if exercise.limit_s.is_some() {
        facts.push(("Time for all", limit(exercise.limit_s)));
    }
    facts.push((
        "Difficulty",
        match &exercise.staircase {
            Some(_) => "follows the answers".into(),
            None => "the same in every trial".into(),
        },
    ));
    facts
}
