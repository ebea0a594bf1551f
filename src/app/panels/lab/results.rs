//! What was found: verdicts first, then notes, figures, tables, settings; and the report as files.

use super::PanelContext;
use super::chart::{self, ChartContext};
use super::choices::together;
use super::experiments::capitalised;
use super::table::Tables;
use crate::app::command::CommandSender;
use crate::app::dialogs;
use crate::app::laboratory::{Found, Laboratory, report};
use crate::app::theme::Theme;
use crate::app::widgets::{empty_ui, named};
use crate::lab::{Drawing, Report, Verdict};
use egui::{RichText, vec2};
use egui_material_icons::icons as icon;
use std::path::PathBuf;

/// Width of the word before a verdict, points.
const WORD: f32 = 112.0;

/// How results are shown.
#[derive(Default)]
pub struct Results {
    tables: Tables,
    folder: String,
    /// The section to scroll to.
    asked: Option<&'static str>,
}

impl Results {
    /// Shows what was last found for the experiment on show.
    pub fn show(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>, laboratory: &Laboratory) {
        let theme = &cx.view.theme;
        let Some(found) = laboratory.found() else {
            let next = if laboratory.progress().is_some() {
                "What it finds is shown here when it is done"
            } else {
                "Run it: verdicts, figures and tables are shown here"
            };
            empty_ui(ui, icon::ICON_SCIENCE, "No results yet", next);
            return;
        };
        let [report] = &found.document.experiments[..] else {
            return;
        };
        self.head_ui(ui, cx, laboratory, found, report);
        if !report.verdicts.is_empty() {
            heading(ui, "What holds", &mut self.asked);
            for verdict in &report.verdicts {
                verdict_ui(ui, theme, verdict);
            }
        }
        if !report.notes.is_empty() {
            heading(ui, "Notes", &mut self.asked);
            for note in &report.notes {
                ui.label(note);
            }
        }
        if !report.figures.is_empty() {
            heading(ui, "Figures", &mut self.asked);
        }
        let context = ChartContext {
            theme,
            tables: &report.tables,
        };
        for figure in &report.figures {
            ui.push_id((found.number, "figure", &figure.name), |ui| {
                match &figure.drawing {
                    Drawing::Plots(plots) => chart::plots_ui(ui, &context, plots),
                    Drawing::Map(map) => chart::map_ui(ui, &context, map),
                }
            });
        }
        if !report.tables.is_empty() {
            heading(ui, "Tables", &mut self.asked);
        }
        for table in &report.tables {
            let key = (report.experiment.clone(), table.name.clone());
            self.tables.show(ui, key, found.number, table, theme);
        }
        if !report.settings.is_empty() {
            heading(ui, "Settings", &mut self.asked);
            settings_ui(ui, report);
        }
        ui.add_space(10.0);
        ui.label(RichText::new(found.document.caption()).weak().size(11.5));
        ui.add_space(6.0);
    }

    fn head_ui(
        &mut self,
        ui: &mut egui::Ui,
        cx: &PanelContext<'_>,
        laboratory: &Laboratory,
        found: &Found,
        report: &Report,
    ) {
        let theme = &cx.view.theme;
        let held = report.verdicts.iter().filter(|v| v.holds).count();
        ui.horizontal_wrapped(|ui| {
            let (mark, colour, text) = if report.holds() {
                (icon::ICON_CHECK_CIRCLE, theme.good, "All holds that must")
            } else {
                (icon::ICON_ERROR, theme.fault, "Something does not hold")
            };
            ui.label(mark.rich_text().color(colour).size(17.0));
            ui.label(RichText::new(text).strong().color(colour));
            ui.label(
                RichText::new(format!("{held} of {} verdicts hold", report.verdicts.len())).weak(),
            );
            let when: String = report.measured.chars().take(16).collect();
            let when = when.replace('T', " ");
            let quick = match found.document.quick {
                true => ", a quick look",
                false => "",
            };
            ui.label(RichText::new(format!("Measured {when} UTC{quick}")).weak())
                .on_hover_text(&report.measured);
        });
        if !laboratory.is_current(cx.view) && laboratory.progress().is_none() {
            ui.label(
                RichText::new("These results are of other choices than those above")
                    .color(theme.warning),
            );
        }
        self.save_ui(ui, cx.send, found, laboratory);
        let sections = [
            ("Notes", report.notes.len()),
            ("Figures", report.figures.len()),
            ("Tables", report.tables.len()),
            ("Settings", report.settings.len()),
        ];
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new("Go to").weak());
            for (name, _) in sections.into_iter().filter(|(_, n)| *n > 0) {
                let link = ui.link(name).on_hover_text("Scroll to this section");
                link.widget_info(|| {
                    let role = egui::accesskit::Role::Link;
                    egui::WidgetInfo::labeled(role, true, format!("Go to {name}"))
                });
                if link.clicked() {
                    self.asked = Some(name);
                    ui.ctx().request_repaint();
                }
            }
        });
    }

    fn save_ui(
        &mut self,
        ui: &mut egui::Ui,
        send: &CommandSender,
        found: &Found,
        laboratory: &Laboratory,
    ) {
        let Some(experiment) = laboratory.chosen() else {
            return;
        };
        let name = experiment.name();
        let why = "A page to read and print, tables as CSV, figures as SVG, everything as JSON: into a folder, all or none";
        ui.horizontal_wrapped(|ui| {
            let choose = ui
                .button((icon::ICON_SAVE_AS.rich_text(), "Save report…"))
                .on_hover_text(why);
            named(ui, &choose, "Save report…");
            if choose.clicked() {
                let (document, tell) = (found.document.clone(), send.clone());
                dialogs::open_folder(send, "the report", move |folder| {
                    report::save(document, name, folder, &tell);
                });
            }
            together(ui, "Folder", 190.0 + 60.0, |ui| {
                let label = ui.label(RichText::new("Folder").weak());
                let field = ui
                    .add(
                        egui::TextEdit::singleline(&mut self.folder)
                            .hint_text("folder/for/the/report")
                            .desired_width(190.0),
                    )
                    .labelled_by(label.id)
                    .on_hover_text("A folder by its path, where there is no dialog");
                let is_named = !self.folder.trim().is_empty();
                let entered = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
                let button = ui
                    .add_enabled(is_named, egui::Button::new("Save"))
                    .on_hover_text(why)
                    .on_disabled_hover_text("Name a folder first");
                named(ui, &button, "Save report to folder");
                if (entered || button.clicked()) && is_named {
                    let folder = PathBuf::from(self.folder.trim());
                    report::save(found.document.clone(), name, folder, send);
                }
            });
        });
    }
}

/// Begins a section; scrolls to it where it is asked for.
fn heading(ui: &mut egui::Ui, text: &'static str, asked: &mut Option<&'static str>) {
    ui.add_space(10.0);
    let heading = ui.label(RichText::new(text).strong().size(14.5));
    if *asked == Some(text) {
        heading.scroll_to_me(Some(egui::Align::TOP));
        *asked = None;
    }
    ui.add_space(1.0);
}

fn verdict_ui(ui: &mut egui::Ui, theme: &Theme, verdict: &Verdict) {
    let (mark, word, colour) = match (verdict.holds, verdict.required) {
        (true, _) => (icon::ICON_CHECK_CIRCLE, "Holds", theme.good),
        (false, true) => (icon::ICON_ERROR, "Does not hold", theme.fault),
        (false, false) => (icon::ICON_INFO, "Not reached", theme.warning),
    };
    let why = match verdict.required {
        true => "Must hold on any machine",
        false => "Good to know: a goal for a time, or a claim of the publication",
    };
    ui.horizontal_top(|ui| {
        let left = egui::Layout::left_to_right(egui::Align::Center);
        ui.allocate_ui_with_layout(vec2(WORD, 18.0), left, |ui| {
            ui.set_min_size(vec2(WORD, 18.0));
            ui.spacing_mut().item_spacing.x = 5.0;
            ui.label(mark.rich_text().color(colour).size(15.0));
            ui.label(RichText::new(word).color(colour).strong())
                .on_hover_text(why);
        });
        ui.horizontal_wrapped(|ui| {
            ui.label(format!("{}:", capitalised(&verdict.what)));
            ui.label(RichText::new(&verdict.measured).strong());
            ui.label(RichText::new(format!("goal: {}", verdict.goal)).weak());
        });
    });
}

fn settings_ui(ui: &mut egui::Ui, report: &Report) {
    egui::Grid::new("settings")
        .num_columns(2)
        .spacing(vec2(18.0, 3.0))
        .show(ui, |ui| {
            for setting in &report.settings {
                ui.label(RichText::new(capitalised(&setting.name)).weak());
                ui.add(egui::Label::new(&setting.value).wrap());
                ui.end_row();
            }
        });
}
