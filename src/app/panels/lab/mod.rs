//! The Lab panel: experiments, their progress and what they found.
//!
//! | file | answers |
//! |---|---|
//! | `experiments` | which there are |
//! | `choices` | under which choices, run and cancel |
//! | `results` | verdicts, notes, settings, the report |
//! | `chart` | figures |
//! | `table` | tables |

pub(super) mod chart;
pub(super) mod choices;
mod experiments;
mod results;
pub(super) mod table;

use super::{Panel, PanelContext};
use crate::app::dock::Home;
use crate::app::laboratory::Laboratory;
use crate::app::panels::partition::wake;
use crate::app::state::View;
use crate::app::widgets::empty_ui;
use crate::lab::Shelf;
use egui_material_icons::icons as icon;
use results::Results;

/// Key of the panel.
pub const KEY: &str = "lab";
/// Width of the list of experiments, points.
const LIST: f32 = 186.0;
/// From this width on the list stands beside the results, points.
const WIDE: f32 = 560.0;

/// The Lab panel.
#[derive(Default)]
pub struct LabPanel {
    laboratory: Laboratory,
    /// A choice that could not be used when it was asked for.
    refused: Option<String>,
    results: Results,
}

impl LabPanel {
    /// A panel that keeps its results on `shelf` instead of in the user's cache.
    pub fn keeping_on(shelf: Shelf) -> Self {
        Self {
            laboratory: Laboratory::new(shelf),
            ..Self::default()
        }
    }

    /// What it shows.
    pub fn laboratory(&self) -> &Laboratory {
        &self.laboratory
    }
}

impl Panel for LabPanel {
    fn key(&self) -> &'static str {
        KEY
    }

    fn title(&self) -> &'static str {
        "Lab"
    }

    fn tooltip(&self) -> &'static str {
        "Run experiments: error against run time, stability, what a scene leaves out; figures, tables and what holds"
    }

    fn home(&self) -> Home {
        Home::Main
    }

    fn opens_at_first(&self) -> bool {
        false
    }

    fn keep(&self) -> Option<String> {
        let chosen = self.laboratory.chosen()?;
        let quick = self.laboratory.choices.quick;
        Some(format!("experiment={} quick={quick}", chosen.name()))
    }

    fn recall(&mut self, kept: &str) {
        for part in kept.split_whitespace() {
            match part.split_once('=') {
                Some(("experiment", name)) => self.laboratory.choose(name),
                Some(("quick", on)) => self.laboratory.choices.quick = on == "true",
                _ => {}
            }
        }
    }

    fn release(&mut self, _view: &View) {
        self.laboratory.release();
        self.refused = None;
        self.results = Results::default();
    }

    fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        let wake = wake(ui.ctx());
        self.laboratory.follow(cx.view, &wake);
        let whole = ui.available_rect_before_wrap();
        let (list, main) = if whole.width() >= WIDE {
            whole.split_left_right_at_x(whole.left() + LIST)
        } else {
            whole.split_top_bottom_at_y(whole.top() + (whole.height() * 0.3).clamp(40.0, 150.0))
        };
        ui.painter().rect_filled(list, 0.0, cx.view.theme.inset);
        place(ui, list, |ui| experiments::show(ui, &mut self.laboratory));
        place(ui, main, |ui| {
            if self.laboratory.chosen().is_none() {
                empty_ui(
                    ui,
                    icon::ICON_SCIENCE,
                    "No experiment is chosen",
                    "Choose one from the list to see what it answers, and run it",
                );
                return;
            }
            // Choices and results scroll together: in a low panel neither leaves the other without room.
            let chosen = self.laboratory.chosen().map(|e| e.name());
            egui::ScrollArea::vertical()
                .id_salt(("main", chosen))
                .auto_shrink(false)
                .show(ui, |ui| {
                    // The bar of the scroll area lies over the right end of what it scrolls.
                    ui.set_max_width(ui.available_width() - 10.0);
                    choices::show(ui, cx, &mut self.laboratory, &mut self.refused, &wake);
                    ui.separator();
                    self.results.show(ui, cx, &self.laboratory);
                });
        });
        ui.advance_cursor_after_rect(whole);
        if self.laboratory.progress().is_some() {
            // The clock runs.
            let next = std::time::Duration::from_millis(250);
            ui.ctx().request_repaint_after(next);
        }
    }
}

fn place(ui: &mut egui::Ui, rect: egui::Rect, add: impl FnOnce(&mut egui::Ui)) {
    let builder = egui::UiBuilder::new()
        .max_rect(rect.shrink2(egui::vec2(10.0, 8.0)))
        .layout(egui::Layout::top_down(egui::Align::Min));
    ui.scope_builder(builder, |ui| {
        ui.set_clip_rect(ui.clip_rect().intersect(rect));
        add(ui);
    });
}
