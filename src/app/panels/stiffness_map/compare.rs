//! Which fit foretells best what was measured: each key from all the others.

use super::doc::Doc;
use crate::app::bench::Wake;
use crate::app::editor::worker::Worker;
use crate::app::theme::Theme;
use crate::app::widgets::icon_button;
use crate::maps::{Fit, StiffnessKey, leave_one_out};
use egui::RichText;
use egui_material_icons::icons as icon;
use std::sync::Arc;

/// How far a fit is off at keys it does not know.
#[derive(Clone, Debug, PartialEq)]
pub struct Errors {
    /// The fit.
    pub fit: Fit,
    /// For each key what the others say less what it states, N/mm; or why there is nothing to say.
    pub of_keys: Result<Vec<f64>, String>,
}

impl Errors {
    /// Root of the mean square, N/mm.
    pub fn rms(&self) -> Option<f64> {
        let errors = self.of_keys.as_ref().ok().filter(|e| !e.is_empty())?;
        let sum: f64 = errors.iter().map(|e| e * e).sum();
        Some((sum / errors.len() as f64).sqrt())
    }

    /// The largest in size, N/mm, and at which key.
    pub fn largest(&self) -> Option<(f64, usize)> {
        let errors = self.of_keys.as_ref().ok()?;
        let indexed = errors.iter().copied().zip(0..);
        indexed.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
    }
}

/// The comparison, kept up to date while it is on show.
pub struct Comparison {
    worker: Worker<(Arc<Vec<StiffnessKey>>, Vec<Errors>)>,
    asked: Option<Arc<Vec<StiffnessKey>>>,
    found: Option<(Arc<Vec<StiffnessKey>>, Vec<Errors>)>,
}

impl Default for Comparison {
    fn default() -> Self {
        Self {
            worker: Worker::new("comparison of fits"),
            asked: None,
            found: None,
        }
    }
}

/// Errors of every fit; `go_on` is asked between them.
pub fn compare(keys: &[StiffnessKey], go_on: &dyn Fn() -> bool) -> Option<Vec<Errors>> {
    let mut out = Vec::new();
    for &fit in Fit::all() {
        if !go_on() {
            return None;
        }
        out.push(Errors {
            fit,
            of_keys: leave_one_out(keys, fit).map_err(|e| e.to_string()),
        });
    }
    Some(out)
}

/// The fit with the smallest root mean square.
pub fn best(errors: &[Errors]) -> Option<Fit> {
    let known = errors.iter().filter_map(|e| Some((e.rms()?, e.fit)));
    known.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, fit)| fit)
}

impl Comparison {
    /// Takes what came and asks for what is missing.
    pub fn follow(&mut self, doc: &Doc, wake: &Wake) {
        if let Some(found) = self.worker.poll(wake) {
            self.found = Some(found);
        }
        if self.asked.as_ref() != Some(&doc.keys) {
            self.asked = Some(doc.keys.clone());
            let keys = doc.keys.clone();
            let work = move |go_on: &dyn Fn() -> bool| {
                let errors = compare(&keys, go_on)?;
                Some((keys, errors))
            };
            self.worker.ask(true, work, wake);
        }
    }

    /// Errors of a fit, if they are those of these keys.
    pub fn of(&self, doc: &Doc, fit: Fit) -> Option<&[f64]> {
        let (keys, errors) = self.found.as_ref()?;
        let errors = errors.iter().find(|e| e.fit == fit && *keys == doc.keys)?;
        errors.of_keys.as_deref().ok()
    }

    /// The table; a click on a fit chooses it. `selected` is the chosen key.
    pub fn show(
        &self,
        ui: &mut egui::Ui,
        theme: &Theme,
        doc: &Doc,
        selected: &mut Option<usize>,
    ) -> Option<Fit> {
        let mut picked = None;
        ui.label(
            RichText::new(
                "Each key is left out and foretold from all the others; the error is what comes out less what it states.",
            )
            .size(12.0)
            .weak(),
        );
        let Some((keys, errors)) = &self.found else {
            ui.weak("Leaving out one key after another…");
            return None;
        };
        let best = best(errors);
        egui::Grid::new("comparison of fits")
            .num_columns(4)
            .spacing([14.0, 3.0])
            .striped(true)
            .show(ui, |ui| {
                for (head, why) in [
                    ("fit", "Choose a fit by its name"),
                    ("RMS N/mm", "Root of the mean square of all errors"),
                    ("largest N/mm", "Largest error in size"),
                    ("at key", "Where it is; click to choose the key"),
                ] {
                    ui.label(RichText::new(head).size(11.5).weak())
                        .on_hover_text(why);
                }
                ui.end_row();
                for e in errors {
                    let name = e.fit.name();
                    let text = RichText::new(name).size(12.5);
                    let on = doc.fit == e.fit;
                    let choose = ui
                        .selectable_label(on, text)
                        .on_hover_text(format!("Use this fit: {}", e.fit.about()));
                    crate::app::widgets::named(ui, &choose, &format!("Use fit {name}"));
                    if choose.clicked() {
                        picked = Some(e.fit);
                    }
                    let (Some(rms), Some((largest, at))) = (e.rms(), e.largest()) else {
                        let why = e.of_keys.as_ref().err().cloned().unwrap_or_default();
                        ui.label(RichText::new("–").weak()).on_hover_text(why);
                        ui.end_row();
                        continue;
                    };
                    let is_best = best == Some(e.fit);
                    let number = RichText::new(format!("{rms:>7.4}")).monospace().size(12.0);
                    ui.horizontal(|ui| {
                        ui.spacing_mut().item_spacing.x = 3.0;
                        ui.label(if is_best {
                            number.strong().color(theme.good)
                        } else {
                            number
                        });
                        if is_best {
                            ui.label(icon::ICON_CHECK.rich_text().color(theme.good))
                                .on_hover_text("The smallest");
                            ui.label(RichText::new("best").size(11.5).color(theme.good));
                        }
                    });
                    ui.label(
                        RichText::new(format!("{largest:>+8.4}"))
                            .monospace()
                            .size(12.0),
                    );
                    let go = ui
                        .add(
                            egui::Button::new(RichText::new(format!("{}", at + 1)).size(12.0))
                                .frame(false),
                        )
                        .on_hover_text("Choose this key");
                    crate::app::widgets::named(ui, &go, &format!("Choose worst key of {name}"));
                    if go.clicked() {
                        *selected = Some(at);
                    }
                    ui.end_row();
                }
            });
        if *keys != doc.keys || self.worker.is_busy() {
            ui.weak("Being worked out anew…");
        }
        self.per_key(ui, theme, keys, errors, selected);
        picked
    }

    fn per_key(
        &self,
        ui: &mut egui::Ui,
        theme: &Theme,
        keys: &[StiffnessKey],
        errors: &[Errors],
        selected: &mut Option<usize>,
    ) {
        egui::CollapsingHeader::new("Errors per key")
            .id_salt("errors per key")
            .show_unindented(ui, |ui| {
                let row_height = 18.0;
                let cell = |ui: &mut egui::Ui, text: RichText| {
                    ui.allocate_ui_with_layout(
                        egui::vec2(54.0, row_height),
                        egui::Layout::right_to_left(egui::Align::Center),
                        |ui| {
                            ui.set_min_width(54.0);
                            ui.label(text);
                        },
                    );
                };
                ui.spacing_mut().item_spacing = egui::vec2(2.0, 1.0);
                ui.horizontal(|ui| {
                    ui.add_space(30.0);
                    for e in errors {
                        cell(ui, RichText::new(e.fit.name()).size(11.5).weak());
                    }
                });
                egui::ScrollArea::vertical()
                    .id_salt("errors")
                    .max_height(160.0)
                    .show_rows(ui, row_height, keys.len(), |ui, rows| {
                        for i in rows {
                            ui.horizontal(|ui| {
                                let on = *selected == Some(i);
                                let name = format!("Choose key {} in the comparison", i + 1);
                                let mark = if on {
                                    icon::ICON_RADIO_BUTTON_CHECKED
                                } else {
                                    icon::ICON_RADIO_BUTTON_UNCHECKED
                                };
                                if icon_button(ui, mark, &name, &format!("Choose key {}", i + 1))
                                    .clicked()
                                {
                                    *selected = Some(i);
                                }
                                for e in errors {
                                    let value = e.of_keys.as_ref().ok().and_then(|v| v.get(i));
                                    let text = match value {
                                        Some(v) => format!("{v:>+7.3}"),
                                        None => "–".into(),
                                    };
                                    let text = RichText::new(text).monospace().size(11.5);
                                    let ink = if on { theme.text } else { theme.weak_text };
                                    cell(ui, text.color(ink));
                                }
                            });
                        }
                    });
            });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Vec2;

    fn key(x: f64, y: f64, k: f64) -> StiffnessKey {
        StiffnessKey {
            at: Vec2::new(x, y),
            stiffness_n_per_mm: k,
        }
    }

    #[test]
    fn a_slope_is_foretold_by_the_fits_that_can_and_the_best_is_marked() {
        let keys: Vec<_> = (0..25)
            .map(|i| (f64::from(i % 5) * 40.0, f64::from(i / 5) * 40.0))
            .map(|(x, y)| key(x, y, 0.5 + 0.002 * x + 0.001 * y))
            .collect();
        let errors = compare(&keys, &|| true).expect("compared");
        assert_eq!(errors.len(), Fit::all().len());
        for e in &errors {
            let of_keys = e.of_keys.as_ref().expect("two places and more");
            assert_eq!(of_keys.len(), keys.len());
            let (largest, at) = e.largest().expect("some");
            assert_eq!(of_keys[at], largest);
            assert!(e.rms().expect("some") <= largest.abs());
        }
        let best = best(&errors).expect("one");
        let rms = |fit| errors.iter().find(|e| e.fit == fit).and_then(Errors::rms);
        assert!(Fit::all().iter().all(|f| rms(best) <= rms(*f)));
        assert_ne!(best, Fit::Constant);
    }

    #[test]
    fn one_key_alone_tells_nothing() {
        let errors = compare(&[key(0.0, 0.0, 0.5)], &|| true).expect("compared");
        assert!(
            errors
                .iter()
                .all(|e| e.of_keys.is_err() && e.rms().is_none())
        );
        assert_eq!(best(&errors), None);
        assert!(compare(&[], &|| false).is_none());
    }
}
