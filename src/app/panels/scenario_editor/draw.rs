//! Dysfunctions drawn at random: the same from the same seed.

use super::{State, add, wording};
use crate::app::editor::cells::{self, Cell};
use crate::app::editor::parts::{choose, pick, row};
use crate::app::panels::PanelContext;
use crate::app::widgets::named;
use crate::scenario::{Change, RandomSpec, SurfaceChoice, dysfunction, random, sites};
use egui::RichText;

/// What is drawn next.
pub struct Draw {
    kind: &'static str,
    candidates: String,
    strength: Change,
    count: usize,
    seed: u64,
}

impl Default for Draw {
    /// "One hypertonic site among T1–T12, both sides".
    fn default() -> Self {
        let first = dysfunction::all().first();
        Self {
            kind: first.map_or("", |kind| kind.key()),
            candidates: "T1-T12 both sides".into(),
            strength: Change::CompliancePercent(-28.0),
            count: 1,
            seed: 1,
        }
    }
}

impl Draw {
    fn spec(&self) -> Result<RandomSpec, String> {
        Ok(RandomSpec {
            kind: self.kind,
            candidates: sites(&self.candidates).map_err(|e| e.to_string())?,
            strength: self.strength,
            count: self.count,
            seed: self.seed,
        })
    }
}

/// Shows it.
pub fn show(ui: &mut egui::Ui, cx: &PanelContext<'_>, state: &mut State) {
    let on_back = cx
        .view
        .scene
        .as_ref()
        .is_some_and(|s| matches!(s.scenario.surface, SurfaceChoice::BuiltinBack { .. }));
    if !on_back {
        ui.weak("Sites are those of the built-in back: on a mesh nothing can be drawn");
        return;
    }
    let draw = &mut state.draw;
    let width = (ui.available_width() - 110.0).clamp(90.0, 240.0);
    row(ui, "Kind", "What is drawn", |ui| {
        let now = dysfunction::named(draw.kind).map_or("", |k| k.title());
        let items = add::kinds(draw.kind);
        if let Some(kind) = choose(ui, "Kind to draw", "What is drawn", now, width, items) {
            draw.kind = kind.key();
        }
    });
    row(ui, "Among", "Sites, each as likely as every other", |ui| {
        let field = ui
            .add(egui::TextEdit::singleline(&mut draw.candidates).desired_width(width))
            .on_hover_text("Such as T1-T12 both sides, or C7,T4-L5 right spinous");
        ui.ctx().accesskit_node_builder(field.id, |node| {
            node.set_label("Sites to draw from");
        });
    });
    strength(ui, draw);
    row(ui, "How many", "At different sites", |ui| {
        let count = Cell {
            name: "How many to draw",
            tooltip: "At different sites; 1 to 20 is allowed",
            range: 1.0..=20.0,
            decimals: 0,
            unit: "",
            speed: 0.05,
            width: 56.0,
        };
        if let Some(v) = cells::number(ui, &count, draw.count as f64).value {
            draw.count = v.round().max(1.0) as usize;
        }
        ui.weak("seed");
        let seed = Cell {
            name: "Seed to draw by",
            tooltip: "The same seed draws the same sites on every machine",
            range: 0.0..=1e9,
            decimals: 0,
            unit: "",
            speed: 1.0,
            width: 76.0,
        };
        if let Some(v) = cells::number(ui, &seed, draw.seed as f64).value {
            draw.seed = v.round().max(0.0) as u64;
        }
        let next = ui.button("Next seed").on_hover_text("Another draw");
        if next.clicked() {
            draw.seed = draw.seed.wrapping_add(1) % 1_000_000_000;
        }
    });
    let spec = draw.spec();
    match &spec {
        Ok(spec) => {
            let n = spec.candidates.len();
            let what = match spec.count {
                1 => format!("One among {n} sites"),
                count => format!("{count} among {n} sites"),
            };
            ui.label(RichText::new(what).size(12.0).weak());
        }
        Err(fault) => {
            ui.label(RichText::new(fault).size(12.0).color(cx.view.theme.fault));
        }
    }
    let mut drawn = None;
    ui.add_enabled_ui(spec.is_ok(), |ui| {
        ui.horizontal(|ui| {
            for (text, name, why, replaces) in [
                (
                    "Add",
                    "Add drawn dysfunctions",
                    "Add what is drawn to the list",
                    false,
                ),
                (
                    "Replace all",
                    "Replace dysfunctions by drawn ones",
                    "Put what is drawn in place of the whole list; undo brings it back",
                    true,
                ),
            ] {
                let button = ui.button(text).on_hover_text(why);
                named(ui, &button, name);
                if button.clicked() {
                    drawn = Some(replaces);
                }
            }
        });
    });
    let (Some(replaces), Ok(spec)) = (drawn, spec) else {
        return;
    };
    let more = random(&spec);
    let doc = state.editing.doc();
    let doc = if replaces {
        doc.with_list(more)
    } else {
        doc.with_more(more)
    };
    let last = doc.list.len().checked_sub(1);
    state.editing.set("Draw at random", doc);
    state.editing.selected = last;
}

fn strength(ui: &mut egui::Ui, draw: &mut Draw) {
    row(
        ui,
        "Strength",
        "Change of stiffness; means nothing to a kind that leaves it as it is",
        |ui| {
            let compliance = matches!(draw.strength, Change::CompliancePercent(_));
            let round = |x: f64| (x * 10.0).round() / 10.0;
            if pick(
                ui,
                compliance,
                "Compliance",
                "Drawn strength as compliance",
                "mm/N",
            ) {
                draw.strength =
                    Change::CompliancePercent(round(draw.strength.compliance_percent()));
            }
            if pick(
                ui,
                !compliance,
                "Stiffness",
                "Drawn strength as stiffness",
                "N/mm",
            ) {
                draw.strength = Change::StiffnessPercent(round(draw.strength.stiffness_percent()));
            }
            let (value, range) = match draw.strength {
                Change::CompliancePercent(c) => (c, -90.0..=900.0),
                Change::StiffnessPercent(s) => (s, -90.0..=900.0),
            };
            let cell = Cell {
                name: "Drawn strength, percent",
                tooltip: "Change at the centre",
                range,
                decimals: 1,
                unit: "%",
                speed: 0.2,
                width: 76.0,
            };
            if let Some(v) = cells::number(ui, &cell, value).value {
                draw.strength = match draw.strength {
                    Change::CompliancePercent(_) => Change::CompliancePercent(v),
                    Change::StiffnessPercent(_) => Change::StiffnessPercent(v),
                };
            }
        },
    );
    row(ui, "", "The same change as both", |ui| {
        ui.label(RichText::new(wording::both(draw.strength)).weak());
    });
}
