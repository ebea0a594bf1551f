//! Where the chosen dysfunction is: levels, side and target, or a point of the map.

use super::State;
use super::doc::{centres, tidy_place};
use super::form::{Number, number, set};
use crate::app::editor::parts::{choose, pick, row};
use crate::app::panels::PanelContext;
use crate::geom::Vec2;
use crate::scenario::{
    Dysfunction, Place, Side, Site, SurfaceChoice, Target, VertebralLevel, sites,
};

/// The words that name its sites, as far as the same words name all of them.
struct Words {
    first: VertebralLevel,
    last: VertebralLevel,
    side: &'static str,
    target: Target,
}

const SIDES: [&str; 4] = ["left", "middle", "right", "both"];

impl Words {
    fn of(of: &[Site]) -> Option<Self> {
        let has = |side: Side| of.iter().any(|s| s.side == side);
        let side = match (has(Side::Left), has(Side::Middle), has(Side::Right)) {
            (true, _, true) => "both",
            (true, _, false) => "left",
            (false, _, true) => "right",
            (false, true, false) => "middle",
            (false, false, false) => return None,
        };
        Some(Self {
            first: of.iter().map(|s| s.level).min()?,
            last: of.iter().map(|s| s.level).max()?,
            side,
            target: of.first()?.target,
        })
    }

    /// The sites that the words name: what does not go together is left out.
    fn sites(&self) -> Result<Vec<Site>, String> {
        let side = match (self.side, self.target) {
            ("middle", target) if target != Target::Spinous => "right",
            (side, _) => side,
        };
        let levels = format!("{}-{}", self.first, self.last);
        let text = format!("{levels} {side} {}", self.target.name());
        sites(&text).map_err(|e| e.to_string())
    }
}

/// Shows it.
pub fn show(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    state: &mut State,
    d: &Dysfunction,
    index: usize,
    of: &str,
) {
    let on_back = cx
        .view
        .scene
        .as_ref()
        .is_some_and(|s| matches!(s.scenario.surface, SurfaceChoice::BuiltinBack { .. }));
    let is_point = matches!(d.place, Place::At(_));
    if on_back {
        row(
            ui,
            "Place",
            "At named sites of the back, or at a point of the map",
            |ui| {
                let why = "By level, side and target";
                if pick(ui, !is_point, "Site", &format!("Site for {of}"), why) && is_point {
                    let at = centres(d).first().copied().unwrap_or_default();
                    if let Some(site) = super::snap::nearest(at, f64::INFINITY) {
                        set(state, index, "Change place", |d| {
                            d.place = Place::from(site);
                            d.offset_mm = Vec2::ZERO;
                        });
                    }
                }
                let why = "By x and y on the map, as on any mesh";
                if pick(ui, is_point, "Point", &format!("Point for {of}"), why) && !is_point {
                    let at = centres(d).first().copied().unwrap_or_default();
                    set(state, index, "Change place", |d| {
                        d.place = Place::At(tidy_place(at));
                        d.offset_mm = Vec2::ZERO;
                    });
                }
            },
        );
    }
    match &d.place {
        Place::Sites(list) => {
            by_words(ui, state, list, index, of);
            by_text(ui, state, d, index, of);
        }
        Place::At(at) => {
            row(
                ui,
                "At",
                "Place on the map: x to the subject's right, y to the head",
                |ui| {
                    for (which, what) in ["x", "y"].into_iter().enumerate() {
                        let cell = Number {
                            what,
                            why: "Place on the map",
                            range: -2000.0..=2000.0,
                            decimals: 1,
                            unit: "mm",
                            speed: 0.5,
                        };
                        number(ui, state, index, of, &cell, at[which], |d, v| {
                            if let Place::At(at) = &mut d.place {
                                at[which] = v;
                            }
                        });
                    }
                },
            );
        }
    }
    row(
        ui,
        "Offset",
        "Beside the place: away from the midline, and to the head",
        |ui| {
            let both = [
                (
                    "Offset outwards",
                    "Away from the midline; in the middle to the subject's right",
                ),
                ("Offset upwards", "To the head"),
            ];
            for (which, (what, why)) in both.into_iter().enumerate() {
                let cell = Number {
                    what,
                    why,
                    range: -100.0..=100.0,
                    decimals: 1,
                    unit: "mm",
                    speed: 0.3,
                };
                number(ui, state, index, of, &cell, d.offset_mm[which], |d, v| {
                    d.offset_mm[which] = v;
                });
            }
        },
    );
}

fn by_words(ui: &mut egui::Ui, state: &mut State, list: &[Site], index: usize, of: &str) {
    let Some(mut words) = Words::of(list) else {
        return;
    };
    let mut changed = false;
    row(
        ui,
        "Level",
        "Which vertebra, or the first and the last of several",
        |ui| {
            let levels = |now: VertebralLevel| {
                VertebralLevel::all().map(move |l| (l.name().to_owned(), l == now, l))
            };
            let (name, now) = (format!("Level of {of}"), words.first);
            if let Some(level) = choose(
                ui,
                &name,
                "The vertebra; the first of several",
                now.name(),
                44.0,
                levels(now),
            ) {
                // One level stays one.
                if words.first == words.last {
                    words.last = level;
                }
                (words.first, changed) = (level, true);
            }
            ui.weak("to");
            let (name, now) = (format!("Last level of {of}"), words.last);
            if let Some(level) = choose(
                ui,
                &name,
                "The last of several",
                now.name(),
                44.0,
                levels(now),
            ) {
                (words.last, changed) = (level, true);
            }
            if words.first > words.last {
                std::mem::swap(&mut words.first, &mut words.last);
            }
        },
    );
    row(
        ui,
        "Side",
        "Of the subject; the middle has the spinous process alone",
        |ui| {
            for side in SIDES {
                let name = format!("{side} side of {of}");
                let on = words.side == side;
                if pick(ui, on, side, &name, "Which side of the subject") && !on {
                    (words.side, changed) = (side, true);
                    if side == "middle" {
                        words.target = Target::Spinous;
                    }
                }
            }
        },
    );
    row(ui, "Target", "What of the vertebra", |ui| {
        let items = Target::all().iter();
        let items = items.map(|t| (t.title().to_owned(), *t == words.target, *t));
        let name = format!("Target of {of}");
        let now = words.target.title();
        if let Some(target) = choose(ui, &name, "What of the vertebra", now, 130.0, items) {
            (words.target, changed) = (target, true);
        }
    });
    if !changed {
        return;
    }
    match words.sites() {
        Ok(sites) => set(state, index, "Change place", |d| {
            d.place = Place::Sites(sites)
        }),
        Err(fault) => state.editing.told = Some(fault),
    }
    state.typed = None;
}

/// Any sites, as text.
fn by_text(ui: &mut egui::Ui, state: &mut State, d: &Dysfunction, index: usize, of: &str) {
    let why = "Any sites in words, such as T3 left muscle; L1-L3 right. Enter takes them";
    row(ui, "Sites", why, |ui| {
        let said = d.place.to_string();
        let mut text = match &state.typed {
            Some((i, text)) if *i == index => text.clone(),
            _ => said.clone(),
        };
        let width = (ui.available_width() - 8.0).max(60.0);
        let field = ui
            .add(egui::TextEdit::singleline(&mut text).desired_width(width))
            .on_hover_text(why);
        ui.ctx().accesskit_node_builder(field.id, |node| {
            node.set_label(format!("Sites of {of}"));
        });
        if field.changed() {
            state.typed = Some((index, text.clone()));
        }
        if field.lost_focus() && state.typed.take().is_some() && text != said {
            match sites(&text) {
                Ok(list) => set(state, index, "Change place", |d| {
                    d.place = Place::Sites(list)
                }),
                Err(e) => state.editing.told = Some(e.to_string()),
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_say_what_sites_there_are() {
        for text in [
            "T5 right transverse",
            "T3-T6 both muscle",
            "C7-L5 middle spinous",
            "T2 left rib angle",
        ] {
            let there = sites(text).expect("sites");
            let words = Words::of(&there).expect("words");
            assert_eq!(words.sites().as_deref(), Ok(&there[..]), "{text}");
        }
        assert!(Words::of(&[]).is_none());
    }
}
