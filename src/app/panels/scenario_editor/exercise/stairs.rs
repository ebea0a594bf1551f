//! The staircase: how the strength goes from trial to trial.

use super::{Number, State, maybe, number, pressed, set, whole};
use crate::app::editor::parts::{choose, pick, row};
use crate::scenario::exercise::{Exercise, Measure, Staircase, Step};
use crate::training::staircase;

/// Shows it.
pub fn show(ui: &mut egui::Ui, state: &mut State, e: &Exercise) {
    let Some(s) = &e.staircase else {
        row(
            ui,
            "Staircase",
            "How the strength goes from trial to trial",
            |ui| {
                ui.weak("none: the strength stays");
                let button = ui
                    .button("Add")
                    .on_hover_text("Harder after right answers, easier after wrong ones");
                if pressed(ui, &button, "Add staircase") {
                    set(state, |e| e.staircase = Some(Staircase::default()));
                }
            },
        );
        return;
    };
    row(
        ui,
        "Staircase",
        "How the strength goes from trial to trial",
        |ui| {
            let items = staircase::all().iter();
            let items =
                items.map(|rule| (rule.title().to_owned(), rule.key() == s.rule, rule.key()));
            let now = staircase::by_key(s.rule).map_or(s.rule, |rule| rule.title());
            let why = rule_text(s.rule);
            if let Some(rule) = choose(ui, "Rule of the staircase", why, now, 160.0, items) {
                change(state, |s| s.rule = rule);
            }
            let button = ui
                .button("Remove")
                .on_hover_text("The strength stays the same in every trial");
            if pressed(ui, &button, "Remove staircase") {
                set(state, |e| e.staircase = None);
            }
        },
    );
    ui.label(egui::RichText::new(rule_text(s.rule)).size(12.0).weak());
    row(ui, "Percent of", "Of what the percentages are", |ui| {
        for measure in Measure::ALL {
            let name = format!("Staircase of {}", measure.name());
            let why = "Of what the percentages are";
            if pick(ui, s.measure == measure, measure.name(), &name, why) && s.measure != measure {
                change(state, |s| s.measure = measure);
            }
        }
    });
    row(ui, "Step", "Steps up", |ui| {
        let decibel = matches!(s.step, Step::Decibel(_));
        let why = "On a logarithmic scale of the percentage: 20 dB are a factor of 10";
        if pick(ui, decibel, "dB", "Step in decibel", why) && !decibel {
            change(state, |s| s.step = Step::Decibel(2.0));
        }
        let why = "Points of percent";
        if pick(ui, !decibel, "%", "Step in percent", why) && decibel {
            change(state, |s| s.step = Step::Percent(2.0));
        }
        match s.step {
            Step::Decibel(step) => {
                let of = Number("Step", "Steps up", 0.01..=20.0, 2, "dB");
                percent(ui, state, &of, step, |s, v| s.step = Step::Decibel(v));
            }
            Step::Percent(step) => {
                let of = Number("Step", "Steps up", 0.01..=50.0, 2, "%");
                percent(ui, state, &of, step, |s, v| s.step = Step::Percent(v));
            }
        }
    });
    let most = match s.measure {
        Measure::Compliance => 90.0,
        Measure::Stiffness => 900.0,
    };
    row(ui, "Start", "Strength of the first trial", |ui| {
        let of = Number(
            "Start",
            "Strength of the first trial",
            s.least_percent..=s.most_percent,
            1,
            "%",
        );
        percent(ui, state, &of, s.start_percent, |s, v| s.start_percent = v);
    });
    row(ui, "From, to", "Weakest and strongest", |ui| {
        let of = Number("Weakest", "Weakest", 0.1..=s.start_percent, 1, "%");
        percent(ui, state, &of, s.least_percent, |s, v| s.least_percent = v);
        let of = Number("Strongest", "Strongest", s.start_percent..=most, 1, "%");
        percent(ui, state, &of, s.most_percent, |s, v| s.most_percent = v);
    });
    if s.rule == "weighted-up-down" {
        row(
            ui,
            "Goes to",
            "Share of right answers that it goes to",
            |ui| {
                let of = Number(
                    "Right answers",
                    "Share of right answers that it goes to",
                    10.0..=99.0,
                    0,
                    "%",
                );
                percent(ui, state, &of, 100.0 * s.target, |s, v| {
                    s.target = v / 100.0
                });
            },
        );
    }
    if s.rule == "constant" {
        constant(ui, state, s);
        return;
    }
    row(
        ui,
        "Ends after",
        "Reversals after which the exercise ends; none: after its trials",
        |ui| {
            let of = Number(
                "Reversals",
                "The exercise ends after as many",
                2.0..=1000.0,
                0,
                "",
            );
            maybe(ui, state, &of, s.reversals.map(f64::from), 12.0, |e, v| {
                if let Some(s) = &mut e.staircase {
                    s.reversals = v.map(whole);
                }
            });
            ui.weak("left out");
            let of = Number(
                "Reversals left out",
                "First ones that the estimate leaves out",
                0.0..=100.0,
                0,
                "",
            );
            percent(ui, state, &of, f64::from(s.skipped_reversals), |s, v| {
                s.skipped_reversals = whole(v);
            });
        },
    );
}

fn change(state: &mut State, change: impl FnOnce(&mut Staircase)) {
    set(state, |e| {
        if let Some(s) = &mut e.staircase {
            change(s);
        }
    });
}

fn percent(
    ui: &mut egui::Ui,
    state: &mut State,
    of: &Number<'_>,
    value: f64,
    change: impl FnOnce(&mut Staircase, f64),
) {
    number(ui, state, of, value, |e, v| {
        if let Some(s) = &mut e.staircase {
            change(s, v);
        }
    });
}

/// Strengths of the method of constant stimuli.
fn constant(ui: &mut egui::Ui, state: &mut State, s: &Staircase) {
    let said = s.constant_percent.iter().map(f64::to_string);
    let said = said.collect::<Vec<_>>().join(" ");
    let why = "Strengths in percent, with spaces between them. Enter takes them";
    row(ui, "Strengths", why, |ui| {
        let mut text = state.constants.clone().unwrap_or_else(|| said.clone());
        let width = (ui.available_width() - 8.0).max(60.0);
        let field = ui
            .add(egui::TextEdit::singleline(&mut text).desired_width(width))
            .on_hover_text(why);
        ui.ctx().accesskit_node_builder(field.id, |node| {
            node.set_label("Constant strengths, percent");
        });
        if field.changed() {
            state.constants = Some(text.clone());
        }
        if field.lost_focus() && state.constants.take().is_some() && text != said {
            let read = text.split_whitespace().map(str::parse::<f64>);
            let inside = |x: &f64| (s.least_percent..=s.most_percent).contains(x);
            match read.collect::<Result<Vec<_>, _>>() {
                Ok(list) if !list.is_empty() && list.iter().all(inside) => {
                    change(state, |s| s.constant_percent = list);
                }
                _ => {
                    let (least, most) = (s.least_percent, s.most_percent);
                    let told = format!("{text:?}: numbers from {least} to {most} are allowed");
                    state.editing.told = Some(told);
                }
            }
        }
    });
}

/// What a rule does.
fn rule_text(rule: &str) -> &'static str {
    staircase::by_key(rule).map_or("", |rule| rule.about())
}
