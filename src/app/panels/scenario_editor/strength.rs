//! How strong the chosen dysfunction is: as its kind says of its severity, or stated.

use super::State;
use super::form::{Number, as_kind, named_box, number, set};
use super::wording;
use crate::app::editor::parts::{pick, row};
use crate::app::panels::PanelContext;
use crate::scenario::dysfunction::Strength;
use crate::scenario::{Change, Dysfunction};
use egui::RichText;

/// Shows it.
pub fn show(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    state: &mut State,
    d: &Dysfunction,
    index: usize,
    of: &str,
) {
    let default = d
        .kind()
        .map(|kind| kind.strength(d.preset, d.severity))
        .unwrap_or_default();
    change(ui, state, d, &default, index, of);
    let friction = cx
        .view
        .scene
        .as_ref()
        .is_some_and(|s| s.scenario.friction.is_some());
    if friction || d.skin_drag.is_some() {
        let why = "Factor on both friction coefficients at the centre";
        row(ui, "Skin drag", why, |ui| {
            let cell = Number {
                what: "Skin drag",
                why,
                range: 0.1..=10.0,
                decimals: 2,
                unit: "×",
                speed: 0.01,
            };
            let now = d.skin_drag.or(default.skin_drag).unwrap_or(1.0);
            number(ui, state, index, of, &cell, now, |d, v| {
                d.skin_drag = Some(v)
            });
            if as_kind(ui, "Skin drag", d.skin_drag.is_none()) {
                set(state, index, "Change skin drag", |d| d.skin_drag = None);
            }
        });
    } else {
        row(ui, "Skin drag", "Felt by friction alone", |ui| {
            ui.weak("the scenario has no friction");
        });
    }
    let why = "How far the skin stands out at the centre; negative for a hollow";
    row(ui, "Bump", why, |ui| {
        let cell = Number {
            what: "Bump",
            why,
            range: -20.0..=20.0,
            decimals: 1,
            unit: "mm",
            speed: 0.05,
        };
        let now = d.bump_mm.or(default.bump_mm).unwrap_or(0.0);
        number(ui, state, index, of, &cell, now, |d, v| d.bump_mm = Some(v));
        if as_kind(ui, "Bump", d.bump_mm.is_none()) {
            set(state, index, "Change bump", |d| d.bump_mm = None);
        }
    });
    tender(ui, state, d, &default, index, of);
}

/// What a change is stated as.
#[derive(Clone, Copy, PartialEq)]
enum As {
    Kind,
    Compliance,
    Stiffness,
}

fn change(
    ui: &mut egui::Ui,
    state: &mut State,
    d: &Dysfunction,
    default: &Strength,
    index: usize,
    of: &str,
) {
    let now = match d.change {
        None => As::Kind,
        Some(Change::CompliancePercent(_)) => As::Compliance,
        Some(Change::StiffnessPercent(_)) => As::Stiffness,
    };
    let felt = d.change.or(default.change);
    row(
        ui,
        "Stiffness",
        "Change of stiffness at the centre, and as what it is stated",
        |ui| {
            for (choice, text, why) in [
                (As::Kind, "By kind", "What the kind says of this severity"),
                (
                    As::Compliance,
                    "Compliance",
                    "Stated as a change of compliance, mm/N",
                ),
                (
                    As::Stiffness,
                    "Stiffness",
                    "Stated as a change of stiffness, N/mm",
                ),
            ] {
                let name = match choice {
                    As::Kind => format!("Stiffness of {of} as the kind says"),
                    _ => format!("Strength of {of} as {}", text.to_lowercase()),
                };
                if pick(ui, now == choice, text, &name, why) && now != choice {
                    let from = felt.unwrap_or(Change::CompliancePercent(-28.0));
                    let to = match choice {
                        As::Kind => None,
                        As::Compliance => {
                            Some(Change::CompliancePercent(tenth(from.compliance_percent())))
                        }
                        As::Stiffness => {
                            Some(Change::StiffnessPercent(tenth(from.stiffness_percent())))
                        }
                    };
                    set(state, index, "Change strength", |d| d.change = to);
                }
            }
        },
    );
    row(ui, "", "The same change as both", |ui| {
        let (what, value, range) = match d.change {
            Some(Change::CompliancePercent(c)) => ("Compliance change", c, -90.0..=9900.0),
            Some(Change::StiffnessPercent(s)) => ("Stiffness change", s, -99.0..=900.0),
            None => {
                let text = felt.map_or("no change of stiffness".to_owned(), wording::both);
                ui.label(RichText::new(text).weak());
                return;
            }
        };
        let cell = Number {
            what,
            why: "Change at the centre",
            range,
            decimals: 1,
            unit: "%",
            speed: 0.2,
        };
        number(ui, state, index, of, &cell, value, |d, v| {
            d.change = match d.change {
                Some(Change::StiffnessPercent(_)) => Some(Change::StiffnessPercent(v)),
                _ => Some(Change::CompliancePercent(v)),
            };
        });
    });
    if let Some(change) = d.change {
        row(ui, "", "The same change as both", |ui| {
            ui.label(RichText::new(wording::both(change)).weak());
        });
    }
}

fn tenth(x: f64) -> f64 {
    (x * 10.0).round() / 10.0
}

fn tender(
    ui: &mut egui::Ui,
    state: &mut State,
    d: &Dysfunction,
    default: &Strength,
    index: usize,
    of: &str,
) {
    let felt = d.tender_above_n.or(default.tender_above_n);
    let why = "Force from which on it hurts";
    row(ui, "Tender", why, |ui| match felt {
        Some(above) => {
            let cell = Number {
                what: "Tender above",
                why,
                range: 0.1..=50.0,
                decimals: 1,
                unit: "N",
                speed: 0.05,
            };
            number(ui, state, index, of, &cell, above, |d, v| {
                d.tender_above_n = Some(v);
            });
            if as_kind(ui, "Tenderness", d.tender_above_n.is_none()) {
                set(state, index, "Change tenderness", |d| {
                    d.tender_above_n = None
                });
            }
        }
        None => {
            ui.weak("no");
            let button = ui
                .button("State")
                .on_hover_text("Make it hurt from a force on");
            crate::app::widgets::named(ui, &button, &format!("Make {of} tender"));
            if button.clicked() {
                set(state, index, "Change tenderness", |d| {
                    d.tender_above_n = Some(3.0);
                });
            }
        }
    });
    if felt.is_some() {
        row(ui, "", "Whether the patient shows that it hurts", |ui| {
            let mut shown = d.tender_shown;
            let toggle = ui
                .checkbox(&mut shown, "The patient shows it")
                .on_hover_text("Else it is only counted, for the score sheet");
            named_box(ui, &toggle, shown, &format!("Tenderness of {of} is shown"));
            if toggle.changed() {
                set(state, index, "Change tenderness", |d| {
                    d.tender_shown = shown
                });
            }
        });
    }
}
