//! The Compare panel: recordings side by side, in numbers, over time, over the back and as groups.
//!
//! | file | answers |
//! |---|---|
//! | `work` | what the recordings told, read on a thread of its own |
//! | `choices` | which recordings, and how they are aligned |
//! | `pages` | what can be shown of them |
//! | `measures` | tables, of all of a recording or a share of it |
//! | `beside` | all beside the first: traces, differences, agreement |
//! | `figures` | curves |
//! | `dwell` | where the fingers dwelt |
//! | `groups` | two groups |
//! | `repeat` | a recording against itself, felt otherwise |
//! | `report` | all of it as one page |

mod beside;
mod choices;
mod dwell;
mod figures;
mod groups;
mod measures;
mod pages;
mod repeat;
mod report;
mod work;

use super::lab::chart::{self, ChartContext};
use super::lab::table::Tables;
use super::partition::wake;
use super::{Panel, PanelContext};
use crate::app::command::Command;
use crate::app::dock::Home;
use crate::app::state::{Compared, PartCost, View};
use crate::app::widgets::empty_ui;
use crate::scenario::Item;
use crate::study::compare::CompareOptions;
use choices::Choices;
use egui_material_icons::icons as icon;
use groups::Group;
use measures::{Named, Share};
use pages::Page;
use work::{Told, Work};

/// Key of the panel.
pub const KEY: &str = "compare";

/// The Compare panel.
#[derive(Default)]
pub struct ComparePanel {
    page: Page,
    share: Share,
    choices: Choices,
    /// Key of the measure on the Learning page.
    metric: Option<&'static str>,
    groups: [Option<Group>; 2],
    tables: Tables,
    repeat: repeat::Choice,
    report: report::Saving,
    held: Option<Box<Held>>,
}

/// What it holds while it is open.
#[derive(Default)]
struct Held {
    work: Work,
    pictures: dwell::Pictures,
    repeat: repeat::Work,
}

impl Panel for ComparePanel {
    fn key(&self) -> &'static str {
        KEY
    }

    fn title(&self) -> &'static str {
        "Compare"
    }

    fn tooltip(&self) -> &'static str {
        "Set recordings side by side: measures, traces, dwell maps, agreement, learning, groups"
    }

    fn home(&self) -> Home {
        Home::Main
    }

    fn opens_at_first(&self) -> bool {
        false
    }

    fn release(&mut self, view: &View) {
        if self.held.take().is_some() {
            view.parts.remove(Item::Comparison);
        }
    }

    fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        egui::Frame::new()
            .fill(cx.view.theme.panel)
            .inner_margin(8.0)
            .show(ui, |ui| {
                ui.set_min_size(ui.available_size());
                self.whole_ui(ui, cx);
            });
    }
}

impl ComparePanel {
    fn whole_ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        if cx.view.blind {
            let next = "Earlier recordings would tell where to look";
            let what = "Hidden while the exercise runs";
            empty_ui(ui, icon::ICON_VISIBILITY_OFF, what, next);
            return;
        }
        self.choices.add_ui(ui, cx);
        let wanted = cx.view.compared.clone();
        if wanted.is_empty() {
            let next =
                "Tick two recordings in the Sessions panel and press Compare, or add files above";
            empty_ui(ui, icon::ICON_DIFFERENCE, "Nothing to compare yet", next);
            self.release(cx.view);
            return;
        }
        let mut held = self.held.take().unwrap_or_default();
        let options = self.choices.options();
        held.work.follow(&wanted, &options, &wake(ui.ctx()));
        for read in held.work.take_read() {
            // Whoever added it by its path knew of no tags.
            let unknown = |c: &Compared| c.path == read.path && c.tags.is_empty();
            if !read.tags.is_empty() && wanted.iter().any(unknown) {
                cx.send.send(Command::Retag(read));
            }
        }
        self.choices.list_ui(ui, cx, &mut held.work);
        let told = told_of(&wanted, &held.work);
        ui.horizontal_wrapped(|ui| {
            pages::tabs_ui(ui, &mut self.page);
            let shown = report::Shown {
                wanted: &wanted,
                told: &told,
                work: &held.work,
                options: &options,
                groups: &self.groups,
                share: self.share,
            };
            self.report.ui(ui, cx, &shown);
        });
        ui.separator();
        egui::ScrollArea::vertical()
            .id_salt(self.page.words())
            .auto_shrink(false)
            .show(ui, |ui| {
                // A plot keeps its bounds as long as its id: other curves are framed anew.
                let shown = (self.page.words(), self.share.words(), self.metric);
                let known = (held.work.number(), held.repeat.number());
                let of = (shown, format!("{options:?}"), known);
                ui.push_id(of, |ui| {
                    self.page_ui(ui, cx, &mut held, &told, &options);
                });
            });
        let cost = PartCost {
            bytes: held.work.bytes() + held.repeat.bytes(),
            cost_us: None,
        };
        cx.view.parts.report(Item::Comparison, cost);
        self.held = Some(held);
    }

    fn page_ui(
        &mut self,
        ui: &mut egui::Ui,
        cx: &PanelContext<'_>,
        held: &mut Held,
        told: &[(Compared, Named)],
        options: &CompareOptions,
    ) {
        if self.page == Page::Repeat {
            let context = repeat::Context {
                cx,
                wanted: &cx.view.compared,
            };
            self.repeat
                .ui(ui, &context, &mut held.repeat, &mut self.tables);
            return;
        }
        let names: Vec<Named> = told.iter().map(|(_, named)| named.clone()).collect();
        if names.is_empty() {
            if held.work.progress().is_some() {
                ui.weak("The recordings are being read");
            } else {
                ui.weak("None of these recordings can be compared: see above");
            }
            return;
        }
        let theme = &cx.view.theme;
        let chart = ChartContext { theme, tables: &[] };
        let number = held.work.number();
        match self.page {
            Page::Measures => self.measures_ui(ui, cx, &names, number),
            Page::Learning => self.learning_ui(ui, &chart, &names),
            Page::Groups => {
                self.share.ui(ui, &names);
                let tables = &mut self.tables;
                groups::ui(ui, cx, told, &mut self.groups, self.share, tables, number);
            }
            Page::Dwell => held.pictures.ui(ui, theme, &names, number),
            Page::Repeat => {}
            Page::Traces | Page::Difference | Page::Agreement => {
                let Some(beside) = beside::of(ui, cx, &held.work, told, options) else {
                    return;
                };
                let finger = usize::from(options.finger);
                match self.page {
                    Page::Traces => {
                        chart::plots_ui(
                            ui,
                            &chart,
                            &figures::traces(&names, &beside, finger, theme),
                        );
                    }
                    Page::Difference => {
                        beside::spreads_ui(ui, &names, &beside);
                        chart::plots_ui(ui, &chart, &figures::differences(&names, &beside, theme));
                    }
                    _ => beside::agreement_ui(ui, &chart, &names, &beside),
                }
            }
        }
    }

    fn measures_ui(
        &mut self,
        ui: &mut egui::Ui,
        cx: &PanelContext<'_>,
        names: &[Named],
        number: u64,
    ) {
        self.share.ui(ui, names);
        let theme = &cx.view.theme;
        let table = measures::side_by_side(names, self.share);
        let key = |name: &str| ("compare".to_owned(), name.to_owned());
        let measures = key(&format!("measures {}", self.share.words()));
        self.tables.show(ui, measures, number + 1, &table, theme);
        if let Some(felt) = measures::felt(names, self.share.finger) {
            let felt_key = key(&format!("stiffness {:?}", self.share.finger));
            self.tables.show(ui, felt_key, number + 1, &felt, theme);
        }
    }

    fn learning_ui(&mut self, ui: &mut egui::Ui, chart: &ChartContext<'_>, names: &[Named]) {
        self.share.ui(ui, names);
        let metric = measures::metric(self.metric.unwrap_or_default());
        let combo = egui::ComboBox::from_id_salt("measure")
            .selected_text(metric.title_at(measures::edges_n(names)))
            .width(220.0)
            .show_ui(ui, |ui| {
                for choice in crate::study::METRICS {
                    let on = choice.key == metric.key;
                    let label = ui.selectable_label(on, choice.title_at(measures::edges_n(names)));
                    if label.on_hover_text(choice.about).clicked() {
                        self.metric = Some(choice.key);
                    }
                }
            });
        combo.response.on_hover_text(metric.about).widget_info(|| {
            egui::WidgetInfo::labeled(egui::accesskit::Role::ComboBox, true, "Measure")
        });
        let plot = figures::learning(names, metric, self.share, chart.theme);
        chart::plots_ui(ui, chart, &[plot]);
    }
}

/// Letter and name of each recording that is read.
fn told_of(wanted: &[Compared], work: &Work) -> Vec<(Compared, Named)> {
    let told = |(i, c): (usize, &Compared)| {
        let told = work.of(&c.path)?.as_ref().ok()?.clone();
        Some((c.clone(), (called(i, &told), told)))
    };
    wanted.iter().enumerate().filter_map(told).collect()
}

/// Letter of a recording, and whose it is.
fn called(i: usize, told: &Told) -> String {
    let about = &told.analysis.about;
    let who = about.participant.as_deref().unwrap_or(&about.scenario);
    format!("{} {who}", choices::letter(i))
}
