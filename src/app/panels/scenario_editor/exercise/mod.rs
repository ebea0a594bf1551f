//! `[exercise]` as a form: what is asked, what is hidden, how many trials, and how the strength goes.

mod stairs;

use super::{State, add, wording};
use crate::app::editor::cells::{self, Cell};
use crate::app::editor::parts::{choose, pick, row};
use crate::app::panels::PanelContext;
use crate::app::widgets::named;
use crate::scenario::exercise::{Exercise, Feedback, Hides};
use crate::scenario::{Change, SurfaceChoice, dysfunction, edit, sites};
use crate::training;
use egui::RichText;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Shows it.
pub fn show(ui: &mut egui::Ui, cx: &PanelContext<'_>, state: &mut State) {
    let Some(e) = state.editing.doc().exercise.clone() else {
        ui.weak("None: whoever palpates does so freely");
        let button = ui
            .button("Add exercise")
            .on_hover_text("Hide something, let it be found, and score it");
        if button.clicked() {
            let on_back =
                cx.view.scene.as_ref().is_some_and(|s| {
                    matches!(s.scenario.surface, SurfaceChoice::BuiltinBack { .. })
                });
            let mut e = Exercise::default();
            if !on_back {
                (e.hides, e.candidates) = (Hides::Stated, Vec::new());
            }
            put(state, "Add exercise", Some(e));
        }
        return;
    };
    asked(ui, cx, state, &e);
    hidden(ui, state, &e);
    trials(ui, state, &e);
    answers(ui, state, &e);
    stairs::show(ui, state, &e);
    let button = ui
        .button("Remove exercise")
        .on_hover_text("Back to free palpation; undo brings the exercise back");
    if button.clicked() {
        put(state, "Remove exercise", None);
    }
}

fn put(state: &mut State, what: &'static str, e: Option<Exercise>) {
    let mut doc = state.editing.doc().clone();
    doc.exercise = e.map(Arc::new);
    state.editing.set(what, doc);
}

/// Does `change` to the exercise in one step.
fn set(state: &mut State, change: impl FnOnce(&mut Exercise)) {
    let doc = state.editing.doc().with_exercise(change);
    state.editing.set("Change exercise", doc);
}

/// A number of the exercise: name, reason, what is allowed, decimals and unit.
struct Number<'a>(&'a str, &'a str, RangeInclusive<f64>, usize, &'a str);

fn number(
    ui: &mut egui::Ui,
    state: &mut State,
    of: &Number<'_>,
    value: f64,
    change: impl FnOnce(&mut Exercise, f64),
) {
    let Number(what, why, range, decimals, unit) = of;
    let name = if unit.is_empty() {
        (*what).to_owned()
    } else {
        format!("{what}, {unit}")
    };
    let tooltip = format!("{why}; {} to {} is allowed", range.start(), range.end());
    let cell = Cell {
        name: &name,
        tooltip: &tooltip,
        range: range.clone(),
        decimals: *decimals,
        unit,
        speed: if *decimals == 0 { 0.2 } else { 0.1 },
        width: 76.0,
    };
    let edit = cells::number(ui, &cell, value);
    state.editing.take(edit, "Change exercise", |doc, v| {
        doc.with_exercise(|e| change(e, v))
    });
}

/// A whole number of it.
fn whole(v: f64) -> u32 {
    v.round().clamp(0.0, f64::from(u32::MAX)) as u32
}

/// A value that may be left out: a check box, and the number where it is there.
fn maybe(
    ui: &mut egui::Ui,
    state: &mut State,
    of: &Number<'_>,
    value: Option<f64>,
    or: f64,
    change: impl Fn(&mut Exercise, Option<f64>),
) {
    let mut on = value.is_some();
    let toggle = ui.checkbox(&mut on, "").on_hover_text(of.1);
    super::form::named_box(ui, &toggle, on, &format!("{} is set", of.0));
    if toggle.changed() {
        set(state, |e| change(e, on.then_some(or)));
    }
    match value {
        Some(value) => number(ui, state, of, value, |e, v| change(e, Some(v))),
        None => {
            ui.weak("none");
        }
    }
}

fn asked(ui: &mut egui::Ui, cx: &PanelContext<'_>, state: &mut State, e: &Exercise) {
    let task = training::exercise::by_key(e.task);
    let (now, why) = task.map_or((e.task, ""), |task| (task.title(), task.about()));
    row(ui, "Task", why, |ui| {
        let items = training::exercise::all().iter();
        let items = items.map(|task| (task.title().to_owned(), task.key() == e.task, task.key()));
        if let Some(task) = choose(ui, "Task of the exercise", why, now, 140.0, items) {
            set(state, |e| e.task = task);
        }
    });
    ui.label(RichText::new(why).size(12.0).weak());
    if let Some(fault) = task.and_then(|task| task.fault(e)) {
        ui.colored_label(cx.view.theme.warning, fault);
    }
    let why = "Where it may be, or what may be pointed at: T1-T12 both sides; L3 left muscle. Enter takes it";
    row(ui, "Candidates", why, |ui| {
        let said = edit::sites_text(&e.candidates);
        let mut text = state.candidates.clone().unwrap_or_else(|| said.clone());
        let width = (ui.available_width() - 8.0).max(60.0);
        let field = ui
            .add(egui::TextEdit::singleline(&mut text).desired_width(width))
            .on_hover_text(why);
        ui.ctx().accesskit_node_builder(field.id, |node| {
            node.set_label("Candidates of the exercise");
        });
        if field.changed() {
            state.candidates = Some(text.clone());
        }
        if field.lost_focus() && state.candidates.take().is_some() && text != said {
            match sites(&text) {
                Ok(list) => set(state, |e| e.candidates = list),
                Err(fault) => state.editing.told = Some(fault.to_string()),
            }
        }
    });
}

fn hidden(ui: &mut egui::Ui, state: &mut State, e: &Exercise) {
    let drawn = matches!(e.hides, Hides::Drawn { .. });
    row(ui, "Hides", "What is not shown until the answer", |ui| {
        let why = "A dysfunction drawn anew in every trial; those listed above are felt and shown";
        if pick(ui, drawn, "Drawn anew", "Hide what is drawn anew", why) && !drawn {
            set(state, |e| {
                let default = Exercise::default();
                e.hides = default.hides;
                if e.candidates.is_empty() {
                    e.candidates = default.candidates;
                }
            });
        }
        let why = "The dysfunctions listed above, the same in every trial";
        if pick(ui, !drawn, "Those above", "Hide those listed", why) && drawn {
            set(state, |e| e.hides = Hides::Stated);
        }
    });
    let Hides::Drawn { kind, change, most } = &e.hides else {
        return;
    };
    row(ui, "Kind", "What is hidden", |ui| {
        let now = dysfunction::named(kind).map_or("", |k| k.title());
        let items = add::kinds(kind);
        let width = (ui.available_width() - 20.0).clamp(90.0, 240.0);
        if let Some(next) = choose(
            ui,
            "Kind that is hidden",
            "What is hidden",
            now,
            width,
            items,
        ) {
            set(state, |e| {
                if let Hides::Drawn { kind, .. } = &mut e.hides {
                    *kind = next.key();
                }
            });
        }
    });
    let to = |change: Change| {
        move |e: &mut Exercise| {
            if let Hides::Drawn { change: old, .. } = &mut e.hides {
                *old = change;
            }
        }
    };
    row(
        ui,
        "Strength",
        "Without a staircase the strength; with one, whether it is harder or softer",
        |ui| {
            let tenth = |x: f64| (x * 10.0).round() / 10.0;
            let compliance = matches!(change, Change::CompliancePercent(_));
            if pick(
                ui,
                compliance,
                "Compliance",
                "Hidden strength as compliance",
                "mm/N",
            ) && !compliance
            {
                set(
                    state,
                    to(Change::CompliancePercent(tenth(
                        change.compliance_percent(),
                    ))),
                );
            }
            if pick(
                ui,
                !compliance,
                "Stiffness",
                "Hidden strength as stiffness",
                "N/mm",
            ) && compliance
            {
                set(
                    state,
                    to(Change::StiffnessPercent(tenth(change.stiffness_percent()))),
                );
            }
            let value = match change {
                Change::CompliancePercent(x) | Change::StiffnessPercent(x) => *x,
            };
            let of = Number(
                "Hidden strength",
                "Change at the centre",
                -90.0..=900.0,
                1,
                "%",
            );
            number(ui, state, &of, value, |e, v| {
                let change = if compliance {
                    Change::CompliancePercent(v)
                } else {
                    Change::StiffnessPercent(v)
                };
                to(change)(e);
            });
        },
    );
    row(ui, "", "The same change as both", |ui| {
        ui.label(RichText::new(wording::both(*change)).weak());
    });
    if e.task == "search" {
        row(
            ui,
            "At most",
            "How many there are at most in one trial",
            |ui| {
                let of = Number(
                    "Most that are hidden",
                    "In one trial of a free search",
                    1.0..=20.0,
                    0,
                    "",
                );
                number(ui, state, &of, *most as f64, |e, v| {
                    if let Hides::Drawn { most, .. } = &mut e.hides {
                        *most = whole(v) as usize;
                    }
                });
            },
        );
    }
}

fn trials(ui: &mut egui::Ui, state: &mut State, e: &Exercise) {
    row(
        ui,
        "Trials",
        "Scored trials, and practice before them",
        |ui| {
            let of = Number("Scored trials", "Trials that count", 1.0..=10_000.0, 0, "");
            number(ui, state, &of, f64::from(e.trials), |e, v| {
                e.trials = whole(v)
            });
            ui.weak("practice");
            let of = Number(
                "Practice trials",
                "Trials before them that are not scored",
                0.0..=1000.0,
                0,
                "",
            );
            number(ui, state, &of, f64::from(e.practice), |e, v| {
                e.practice = whole(v)
            });
        },
    );
    row(
        ui,
        "Trial limit",
        "Longest time to palpate in one trial",
        |ui| {
            let of = Number(
                "Limit of a trial",
                "Then it must be answered",
                1.0..=3600.0,
                0,
                "s",
            );
            maybe(ui, state, &of, e.trial_limit_s, 60.0, |e, v| {
                e.trial_limit_s = v
            });
        },
    );
    row(
        ui,
        "Whole limit",
        "Longest time for all scored trials, pauses left out",
        |ui| {
            let of = Number(
                "Limit of the exercise",
                "Then it ends",
                1.0..=86_400.0,
                0,
                "s",
            );
            maybe(ui, state, &of, e.limit_s, 1800.0, |e, v| e.limit_s = v);
        },
    );
    let why = "Each trial's stiffness is multiplied by a random factor up to this, so that force or depth alone tells \
               nothing";
    row(ui, "Varies", why, |ui| {
        let of = Number("Stiffness varies by", why, 0.0..=100.0, 0, "%");
        number(ui, state, &of, e.vary_stiffness_percent, |e, v| {
            e.vary_stiffness_percent = v;
        });
        ui.weak("of stiffness");
    });
    row(
        ui,
        "Found within",
        "A mark this near to a hidden one has found it",
        |ui| {
            let of = Number(
                "Found within",
                "A mark this near has found it",
                1.0..=200.0,
                0,
                "mm",
            );
            number(ui, state, &of, e.tolerance_mm, |e, v| e.tolerance_mm = v);
        },
    );
    row(
        ui,
        "Seed",
        "Where chance starts; none: drawn anew for every run",
        |ui| {
            let of = Number(
                "Seed of the exercise",
                "The same seed, the same trials",
                0.0..=1e9,
                0,
                "",
            );
            maybe(ui, state, &of, e.seed.map(|s| s as f64), 1.0, |e, v| {
                e.seed = v.map(|v| v.round().max(0.0) as u64);
            });
        },
    );
}

fn answers(ui: &mut egui::Ui, state: &mut State, e: &Exercise) {
    row(ui, "Feedback", "What is told after an answer", |ui| {
        for feedback in Feedback::ALL {
            let (text, why) = match feedback {
                Feedback::None => ("Nothing", "Nothing is told"),
                Feedback::Right => ("Right or wrong", "Whether the answer was right"),
                Feedback::Truth => (
                    "The truth",
                    "Also what would have been right, with a chance to feel it again",
                ),
            };
            let name = format!("Feedback: {}", text.to_lowercase());
            if pick(ui, e.feedback == feedback, text, &name, why) && e.feedback != feedback {
                set(state, |e| e.feedback = feedback);
            }
        }
    });
    row(ui, "Also asks", "What is asked beside the place", |ui| {
        for (which, (now, text, why)) in [
            (e.asks_confidence, "confidence", "How sure the answer is"),
            (e.asks_kind, "kind", "Which kind of dysfunction it is"),
            (e.asks_severity, "severity", "How severe it is"),
        ]
        .into_iter()
        .enumerate()
        {
            let mut on = now;
            let toggle = ui.checkbox(&mut on, text).on_hover_text(why);
            super::form::named_box(ui, &toggle, on, &format!("Asks for {text}"));
            if toggle.changed() {
                set(state, |e| match which {
                    0 => e.asks_confidence = on,
                    1 => e.asks_kind = on,
                    _ => e.asks_severity = on,
                });
            }
        }
    });
}

/// Gives a button the name a screen reader says, and tells of a click.
fn pressed(ui: &egui::Ui, button: &egui::Response, name: &str) -> bool {
    named(ui, button, name);
    button.clicked()
}
