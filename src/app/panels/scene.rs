//! Scene: which back, and the ledger of what it needs.

use super::{Panel, PanelContext};
use crate::app::command::{Action, Command};
use crate::app::widgets::{action_button, bytes, empty_ui};
use crate::scenario::{self, LedgerRow, Scene};
use egui_material_icons::icons as icon;
use std::path::PathBuf;

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
                    .show(ui, |ui| scene_ui(ui, scene));
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
                        .desired_width((ui.available_width() - 70.0).max(60.0)),
                )
                .labelled_by(label.id)
                .on_hover_text("A scenario file by its path, where there is no file dialog");
            let entered = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            let button = ui
                .add_enabled(!self.path.trim().is_empty(), egui::Button::new("Open"))
                .on_hover_text("Open the scenario at this path");
            crate::app::widgets::named(ui, &button, "Open scenario path");
            if (entered || button.clicked()) && !self.path.trim().is_empty() {
                cx.send
                    .send(Command::OpenScenario(PathBuf::from(self.path.trim())));
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

fn scene_ui(ui: &mut egui::Ui, scene: &Scene) {
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
    ledger_ui(ui, &scene.ledger.rows);
}

fn ledger_ui(ui: &mut egui::Ui, rows: &[LedgerRow]) {
    let number_width = 84.0;
    let text_width = (ui.available_width() - 2.0 * number_width - 24.0).max(120.0);
    let header = |ui: &mut egui::Ui, text: &str, tooltip: &str| {
        ui.label(egui::RichText::new(text).weak())
            .on_hover_text(tooltip);
    };
    egui::Grid::new("ledger")
        .num_columns(3)
        .striped(true)
        .spacing([8.0, 4.0])
        .show(ui, |ui| {
            header(ui, "Part", "Needed by whom, or why it was left out");
            right(ui, number_width, |ui| {
                header(ui, "Memory", "What it holds");
            });
            right(ui, number_width, |ui| {
                header(ui, "Cost (µs)", "Time it takes, and how often");
            });
            ui.end_row();
            for row in rows {
                ui.vertical(|ui| {
                    ui.set_width(text_width);
                    let name = egui::RichText::new(row.item);
                    ui.label(if row.built { name } else { name.weak() });
                    ui.add(
                        egui::Label::new(egui::RichText::new(&row.reason).small().weak()).wrap(),
                    );
                });
                let memory = if row.built && row.bytes > 0 {
                    bytes(row.bytes as u64)
                } else {
                    "–".into()
                };
                right(ui, number_width, |ui| {
                    ui.monospace(memory);
                });
                right(ui, number_width, |ui| {
                    ui.vertical(|ui| {
                        ui.with_layout(egui::Layout::top_down(egui::Align::Max), |ui| {
                            match row.cost_us {
                                Some(cost) => {
                                    ui.monospace(micros(cost));
                                    ui.label(
                                        egui::RichText::new(format!("per {}", row.cost_per))
                                            .small()
                                            .weak(),
                                    );
                                }
                                None => {
                                    ui.monospace("–");
                                }
                            }
                        });
                    });
                });
                ui.end_row();
            }
        });
    let total: usize = rows.iter().filter(|r| r.built).map(|r| r.bytes).sum();
    ui.add_space(4.0);
    ui.label(egui::RichText::new(format!("Together {}", bytes(total as u64))).weak());
}

fn right(ui: &mut egui::Ui, width: f32, add: impl FnOnce(&mut egui::Ui)) {
    ui.allocate_ui_with_layout(
        egui::vec2(width, ui.spacing().interact_size.y),
        egui::Layout::right_to_left(egui::Align::Min),
        add,
    );
}

/// Microseconds with three figures.
fn micros(us: f64) -> String {
    if us < 10.0 {
        format!("{us:.2}")
    } else if us < 100.0 {
        format!("{us:.1}")
    } else {
        grouped(us.round() as usize)
    }
}

/// A count with thin gaps between thousands.
fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(c);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(grouped(2_000_000), "2,000,000");
        assert_eq!(grouped(962), "962");
        assert_eq!(micros(0.523), "0.52");
        assert_eq!(micros(12345.6), "12,346");
        assert_eq!(
            example_name("t5_right-hypertonic.toml"),
            "T5 right hypertonic"
        );
    }
}
