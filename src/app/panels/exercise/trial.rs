//! The trial at hand: ready, palpated, answered, told.

use super::answer::Replying;
use super::{PanelContext, send, step_button};
use crate::app::bench::Wish;
use crate::app::command::Command;
use crate::app::messages::clock;
use crate::app::state::ExerciseView;
use crate::app::widgets::named;
use crate::training::{Input, Phase, Shown, Told};
use egui::RichText;
use egui_material_icons::icons as icon;

pub fn ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, exercise: &ExerciseView, reply: &mut Replying) {
    let shown = &exercise.shown;
    header_ui(ui, cx, shown);
    ui.separator();
    if shown.paused {
        ui.label("Paused. Nothing is felt, and no time is counted.");
        if step_button(ui, cx, true, "Go on", "Let the exercise go on") {
            send(cx, Input::Pause(false));
        }
    } else {
        match shown.phase {
            Phase::Ready => ready_ui(ui, cx, exercise),
            Phase::Palpating => {
                ui.label(RichText::new(&shown.prompt).size(15.0));
                pointed_ui(ui, shown);
                reply.ui(ui, cx, shown);
            }
            Phase::Answering => {
                ui.label("The time to palpate is over. Answer now.");
                reply.ui(ui, cx, shown);
            }
            Phase::Feedback => feedback_ui(ui, cx, exercise),
            Phase::Done(why) => {
                done_ui(ui, cx, exercise, why.words());
                return;
            }
        }
    }
    ui.add_space(10.0);
    footer_ui(ui, cx, shown);
}

fn header_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, shown: &Shown) {
    ui.horizontal(|ui| {
        ui.heading(shown.title);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if let Some(left_s) = shown.trial_left_s {
                let colour = if left_s < 10.0 && shown.phase == Phase::Palpating {
                    cx.view.theme.warning
                } else {
                    cx.view.theme.text
                };
                ui.label(RichText::new(clock(left_s)).monospace().color(colour))
                    .on_hover_text("Time left to palpate in this trial");
            }
        });
    });
    if matches!(shown.phase, Phase::Done(_)) {
        return;
    }
    ui.horizontal(|ui| {
        let practice = if shown.practice { "Practice" } else { "Trial" };
        ui.label(format!("{practice} {} of {}", shown.trial, shown.of));
        if let Some((right, of)) = shown.right_so_far
            && of > 0
        {
            ui.label(RichText::new(format!("· {right} of {of} right")).weak());
        }
        if let Some(left_s) = shown.exercise_left_s {
            ui.label(RichText::new(format!("· {} left", clock(left_s))).weak());
        }
    });
    let share = f32::from(u16::try_from(shown.trial.saturating_sub(1)).unwrap_or(u16::MAX))
        / f32::from(u16::try_from(shown.of.max(1)).unwrap_or(u16::MAX));
    ui.add(
        egui::ProgressBar::new(share)
            .desired_height(4.0)
            .fill(cx.view.theme.accent),
    );
}

fn ready_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, exercise: &ExerciseView) {
    ui.label(RichText::new(&exercise.shown.prompt).size(15.0));
    pointed_ui(ui, &exercise.shown);
    ui.add_space(4.0);
    ui.label(
        RichText::new(
            "Lift your fingers off the skin, then start. The back changes with every trial.",
        )
        .weak(),
    );
    let (text, tooltip) = if exercise.prepared {
        ("Start the trial", "From then on the hidden place is felt")
    } else {
        ("Preparing…", "The next trial is being made ready")
    };
    if step_button(ui, cx, exercise.prepared, text, tooltip) {
        send(cx, Input::Start);
    }
}

fn pointed_ui(ui: &mut egui::Ui, shown: &Shown) {
    if shown.pointed.is_empty() {
        return;
    }
    let names: Vec<&str> = shown.pointed.iter().map(|p| p.name.as_str()).collect();
    let text = format!("Marked on the back: {}", names.join(" and "));
    ui.label(RichText::new(text).weak());
}

fn feedback_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, exercise: &ExerciseView) {
    match &exercise.shown.feedback {
        Some(told) => told_ui(ui, cx, told),
        None => {
            ui.label("Your answer is noted.");
        }
    }
    ui.add_space(6.0);
    if step_button(ui, cx, true, "Next trial", "Go on to the next trial") {
        send(cx, Input::Next);
    }
}

fn told_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, told: &Told) {
    let theme = &cx.view.theme;
    let (mark, colour) = if told.right {
        (icon::ICON_CHECK_CIRCLE, theme.good)
    } else {
        (icon::ICON_CANCEL, theme.warning)
    };
    ui.horizontal_wrapped(|ui| {
        ui.label(mark.rich_text().size(22.0).color(colour));
        ui.label(RichText::new(&told.text).size(15.0));
    });
    if told.can_feel_again {
        let mut again = told.feeling_again;
        let response = ui
            .checkbox(&mut again, "Feel it again")
            .on_hover_text("The hidden place is felt again until you go on; nothing is counted");
        if response.changed() {
            send(cx, Input::FeelAgain(again));
        }
    }
}

fn done_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, exercise: &ExerciseView, why: &str) {
    ui.label(RichText::new(why).size(15.0));
    let scored = exercise.settled.iter().filter(|t| !t.practice);
    let (n, right) = (scored.clone().count(), scored.filter(|t| t.right).count());
    if n > 0 {
        let share = 100.0 * right as f64 / n as f64;
        ui.label(format!("{right} of {n} right ({share:.0} %)"));
    }
    if let Some(threshold) = &exercise.threshold {
        ui.label(format!("Threshold: {threshold}"));
    }
    let folder = exercise.folder.display().to_string();
    ui.label(RichText::new(format!("Kept in {folder}")).weak());
    ui.add_space(6.0);
    ui.horizontal(|ui| {
        let sheet = ui
            .add_enabled(n > 0, egui::Button::new("Write score sheet"))
            .on_hover_text("Write a page to print and tables beside the answers");
        named(ui, &sheet, "Write score sheet");
        if sheet.clicked() {
            cx.send.send(Command::Exercise(Wish::Sheet));
        }
        let close = ui
            .button("Close")
            .on_hover_text("Put the exercise away; it can be begun anew");
        named(ui, &close, "Close exercise");
        if close.clicked() {
            cx.send.send(Command::Exercise(Wish::Close));
        }
    });
}

fn footer_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, shown: &Shown) {
    ui.horizontal(|ui| {
        if !shown.paused && shown.phase != Phase::Feedback {
            let pause = ui
                .button((icon::ICON_PAUSE.rich_text(), "Pause"))
                .on_hover_text("Stop the clock; nothing is felt until you go on");
            named(ui, &pause, "Pause exercise");
            if pause.clicked() {
                send(cx, Input::Pause(true));
            }
        }
        let end = ui
            .button((icon::ICON_STOP.rich_text(), "End"))
            .on_hover_text(
                "Break the exercise off. Answers so far are kept, and one can go on later",
            );
        named(ui, &end, "End exercise");
        if end.clicked() {
            send(cx, Input::Abort);
        }
    });
}
