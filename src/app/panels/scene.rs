//! Scene: which back, and the ledger of what it needs.

use super::{Panel, PanelContext};
use crate::app::command::{Action, Command};
use crate::app::history::History;
use crate::app::state::View;
use crate::app::widgets::{action_button, bytes, empty_ui, grouped, time};
use crate::scenario::{self, Item, Ledger, LedgerRow, Scene};
use egui_material_icons::icons as icon;
use std::path::PathBuf;
use std::sync::PoisonError;

/// The Scene panel.
#[derive(Debug, Default)]
pub struct ScenePanel {
    path: String,
}

impl Panel for ScenePanel {
    fn key(&self) -> &'static str {
        "scene"
    }

    fn title(&self) -> &'static str {
        "Scene"
    }

    fn tooltip(&self) -> &'static str {
        "Choose a back, and see what it needs: memory and time, and what is left out"
    }

    fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        self.picker_ui(ui, cx);
        if let Some(build) = &cx.view.build {
            ui.horizontal(|ui| {
                let width = (ui.available_width() - 80.0).max(60.0);
                ui.add(
                    egui::ProgressBar::new(build.fraction as _)
                        .desired_width(width)
                        .text(format!("{}: {}", build.scenario, build.part)),
                );
                let cancel = ui
                    .button("Cancel")
                    .on_hover_text("Stop building and keep the scene that is open");
                if cancel.clicked() {
                    cx.send.send(Command::CancelBuild);
                }
            });
        }
        ui.separator();
        match &cx.view.scene {
            Some(scene) => {
                egui::ScrollArea::vertical()
                    .auto_shrink(false)
                    .show(ui, |ui| scene_ui(ui, scene, cx.view));
            }
            None => empty_ui(
                ui,
                icon::ICON_LAYERS,
                "No scene is open",
                "Choose an example above or open a scenario file",
            ),
        }
    }
}

impl ScenePanel {
    fn picker_ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        let open = cx.view.scene.as_ref().map(|s| s.scenario.name.clone());
        ui.horizontal(|ui| {
            let label = ui.label("Example");
            egui::ComboBox::from_id_salt("example")
                .selected_text(open.unwrap_or_else(|| "Choose…".into()))
                .width((ui.available_width() - 130.0).clamp(80.0, 260.0))
                .show_ui(ui, |ui| {
                    for example in scenario::examples() {
                        let name = example_name(example.file);
                        if ui.selectable_label(false, name).clicked() {
                            cx.send.send(Command::OpenExample(example.file));
                        }
                    }
                })
                .response
                .labelled_by(label.id)
                .on_hover_text("Scenarios that come with the program");
            action_button(ui, cx.send, Action::OpenScenario, "Open file…");
        });
        ui.horizontal(|ui| {
            let label = ui.label("Path");
            let field = ui
                .add(
                    egui::TextEdit::singleline(&mut self.path)
                        .hint_text("folder/scenario.toml")
                        .desired_width((ui.available_width() - 120.0).max(60.0)),
                )
                .labelled_by(label.id)
                .on_hover_text("A scenario file by its path, where there is no file dialog");
            let named = !self.path.trim().is_empty();
            let entered = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            let button = ui
                .add_enabled(named, egui::Button::new("Open"))
                .on_hover_text("Open the scenario at this path");
            crate::app::widgets::named(ui, &button, "Open scenario path");
            let path = || PathBuf::from(self.path.trim());
            if (entered || button.clicked()) && named {
                cx.send.send(Command::OpenScenario(path()));
            }
            let live = cx.view.scene.is_some() && cx.view.playback.is_none();
            let button = ui
                .add_enabled(named && live, egui::Button::new("Save"))
                .on_hover_text("Write the open scene, as edited, to this path");
            crate::app::widgets::named(ui, &button, "Save scenario to path");
            if button.clicked() {
                let replace = false;
                cx.send.send(Command::SaveScenarioAs {
                    path: path(),
                    replace,
                });
            }
        });
    }
}

/// An example's file name as people read it.
fn example_name(file: &str) -> String {
    let stem = file.strip_suffix(".toml").unwrap_or(file);
    let text = stem.replace(['_', '-'], " ");
    let mut letters = text.chars();
    letters
        .next()
        .map(|first| first.to_uppercase().chain(letters).collect())
        .unwrap_or_default()
}

fn scene_ui(ui: &mut egui::Ui, scene: &Scene, view: &View) {
    ui.label(egui::RichText::new(&scene.scenario.name).strong());
    if !scene.scenario.description.is_empty() {
        ui.add(egui::Label::new(&scene.scenario.description).wrap());
    }
    let (vertices, triangles) = (
        scene.surface.positions().len(),
        scene.surface.triangles().len(),
    );
    ui.label(
        egui::RichText::new(format!(
            "{} · {} triangles · {} vertices",
            scene.mesh_origin,
            grouped(triangles),
            grouped(vertices)
        ))
        .weak(),
    );
    ui.add_space(6.0);
    ledger_ui(ui, &ledger_now(scene, view), view);
}

/// The ledger as things stand: who needs what depends on the panels that are open and on the recorder.
fn ledger_now(scene: &Scene, view: &View) -> Ledger {
    let mut now = Ledger::of(&scene.scenario, view.purpose);
    for (row, built) in now.rows.iter_mut().zip(&scene.ledger.rows) {
        if built.built {
            row.clone_from(built);
        }
    }
    let needed = scenario::Needs::of(&scene.scenario, view.purpose);
    for (item, cost) in view.parts.list() {
        if needed.has(item) {
            now.built(item, cost.bytes);
            if let Some((us, per)) = cost.cost_us {
                now.cost(item, us, per);
            }
        }
    }
    if view.purpose.plotted {
        let history = view.history.lock().unwrap_or_else(PoisonError::into_inner);
        now.built(Item::PlotHistory, History::bytes(&history));
    }
    if view.purpose.recorded {
        now.built(Item::Recorder, view.recorder.held_bytes);
    }
    if view.purpose.live {
        now.built(Item::Ring, view.ring_bytes);
    }
    now
}

const NUMBER_WIDTH: f32 = 92.0;

fn ledger_ui(ui: &mut egui::Ui, ledger: &Ledger, view: &View) {
    let text_width = (ui.available_width() - 2.0 * NUMBER_WIDTH - 24.0).max(100.0);
    let weak = |text: &str| egui::RichText::new(text).weak();
    egui::Grid::new("ledger")
        .num_columns(3)
        .striped(true)
        .spacing([8.0, 5.0])
        .show(ui, |ui| {
            ui.vertical(|ui| {
                ui.set_width(text_width);
                ui.label(weak("Part"))
                    .on_hover_text("Needed by whom, or why it is left out");
            });
            right(ui, |ui| {
                ui.label(weak("Memory")).on_hover_text("What it holds");
            });
            right(ui, |ui| {
                ui.label(weak("Cost"))
                    .on_hover_text("Measured time, and how often it is paid");
            });
            ui.end_row();
            let needs = view
                .scene
                .as_ref()
                .map(|scene| scenario::Needs::of(&scene.scenario, view.purpose));
            for (item, row) in Item::ALL.into_iter().zip(&ledger.rows) {
                let needed = needs.as_ref().is_some_and(|n| n.has(item));
                row_ui(ui, row, needed, text_width);
                ui.end_row();
            }
            ui.label(weak("Together"));
            right(ui, |ui| {
                ui.monospace(bytes(ledger.total_bytes() as u64));
            });
            right(ui, |ui| {
                let mean_us = view.live.timing.mean_tick_us();
                if mean_us > 0.0 {
                    ui.monospace(time(mean_us))
                        .on_hover_text("Mean of one tick of all fingers");
                    ui.label(egui::RichText::new("per tick").size(11.0).weak());
                }
            });
            ui.end_row();
        });
}

fn row_ui(ui: &mut egui::Ui, row: &LedgerRow, needed: bool, text_width: f32) {
    let small = |text: String| egui::RichText::new(text).size(11.0).weak();
    ui.vertical(|ui| {
        ui.set_width(text_width);
        ui.spacing_mut().item_spacing.y = 1.0;
        let name = egui::RichText::new(row.item);
        ui.label(if needed { name } else { name.weak() });
        let reason = if needed {
            format!("needed by {}", row.reason)
        } else {
            format!("left out: {}", row.reason)
        };
        ui.add(egui::Label::new(small(reason)).wrap());
    });
    right(ui, |ui| {
        let held = row.built && row.bytes > 0;
        ui.monospace(if held {
            bytes(row.bytes as u64)
        } else {
            "–".into()
        });
    });
    right(ui, |ui| match row.cost_us {
        Some(cost_us) => {
            ui.monospace(time(cost_us));
            ui.label(small(format!("per {}", row.cost_per)));
        }
        None => {
            ui.monospace("–");
        }
    });
}

/// A cell of numbers, flush right, top aligned.
fn right(ui: &mut egui::Ui, add: impl FnOnce(&mut egui::Ui)) {
    ui.vertical(|ui| {
        ui.set_width(NUMBER_WIDTH);
        ui.spacing_mut().item_spacing.y = 1.0;
        ui.with_layout(egui::Layout::top_down(egui::Align::Max), add);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_example_is_named_by_its_file() {
        assert_eq!(
            example_name("t5_right-hypertonic.toml"),
            "T5 right hypertonic"
        );
    }
}
