//! What only the instructor may see: what is hidden, where the threshold is, how the answers went.

use super::PanelContext;
use crate::app::state::ExerciseView;
use crate::training::TrialRecord;
use egui::RichText;
use egui_material_icons::icons as icon;
use egui_plot::{Line, MarkerShape, Plot, Points};

/// Answers listed.
const LISTED: usize = 40;

/// The instructor's part.
#[derive(Default)]
pub struct Watch;

impl Watch {
    pub fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>, exercise: &ExerciseView) {
        ui.add_space(8.0);
        ui.separator();
        ui.label(RichText::new("For the instructor").strong());
        match &exercise.truth {
            Some(truth) if !truth.is_empty() => {
                for line in truth {
                    ui.label(format!("Hidden: {line}"));
                }
            }
            Some(_) => {
                ui.label("Nothing is hidden in this trial");
            }
            None => {
                ui.label(RichText::new("Hidden: being built").weak());
            }
        }
        if let Some(threshold) = &exercise.threshold {
            ui.label(format!("Threshold by now: {threshold}"));
        }
        let scored: Vec<&TrialRecord> = exercise.settled.iter().filter(|t| !t.practice).collect();
        if scored.is_empty() {
            ui.label(RichText::new("No trial is answered yet").weak());
            return;
        }
        if scored.iter().any(|t| t.compliance_percent.is_some()) {
            strengths_ui(ui, cx, &scored);
        }
        answers_ui(ui, cx, &scored);
    }
}

/// Strength of each trial, filled where the answer was right.
fn strengths_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, scored: &[&TrialRecord]) {
    let theme = &cx.view.theme;
    let point = |t: &&TrialRecord| {
        let percent = t.compliance_percent?.abs();
        Some(([f64::from(t.trial), percent], t.right))
    };
    let points: Vec<([f64; 2], bool)> = scored.iter().filter_map(point).collect();
    let of = |right: bool| -> Vec<[f64; 2]> {
        let these = points.iter().filter(|(_, r)| *r == right);
        these.map(|(at, _)| *at).collect()
    };
    let all: Vec<[f64; 2]> = points.iter().map(|(at, _)| *at).collect();
    ui.label(RichText::new("Change of compliance, %, over the trials").weak());
    Plot::new("strengths")
        .height(130.0)
        .include_y(0.0)
        .allow_scroll(false)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_boxed_zoom(false)
        .show(ui, |plot| {
            plot.line(Line::new("", all).color(theme.line).width(1.5));
            plot.points(
                Points::new("right", of(true))
                    .radius(4.0)
                    .shape(MarkerShape::Circle)
                    .color(theme.accent),
            );
            plot.points(
                Points::new("wrong", of(false))
                    .radius(4.0)
                    .shape(MarkerShape::Cross)
                    .color(theme.warning),
            );
        });
}

fn answers_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, scored: &[&TrialRecord]) {
    let theme = &cx.view.theme;
    egui::Grid::new("answers")
        .num_columns(4)
        .striped(true)
        .show(ui, |ui| {
            for name in ["Trial", "Hidden", "Answered", "Time, s"] {
                ui.label(RichText::new(name).weak());
            }
            ui.end_row();
            for trial in scored.iter().rev().take(LISTED) {
                ui.monospace(format!("{:>3}", trial.trial));
                ui.label(&trial.truth);
                let colour = if trial.right {
                    theme.good
                } else {
                    theme.warning
                };
                let (mark, word) = if trial.right {
                    (icon::ICON_CHECK, "Right")
                } else {
                    (icon::ICON_CLOSE, "Wrong")
                };
                ui.horizontal(|ui| {
                    ui.label(mark.rich_text().color(colour)).on_hover_text(word);
                    ui.label(&trial.answer);
                });
                ui.monospace(format!("{:>6.1}", trial.search_s));
                ui.end_row();
            }
        });
}
