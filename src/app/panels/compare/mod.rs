//! The Compare panel: recordings side by side, in numbers, over time, over the back and as groups.
//!
//! | file | answers |
//! |---|---|
//! | `work` | what the recordings told, read on a thread of its own |
//! | `measures` | tables |
//! | `figures` | curves |
//! | `dwell` | where the fingers dwelt |
//! | `choices` | which recordings, and how they are aligned |

mod choices;
mod dwell;
mod figures;
mod measures;
mod work;

use super::lab::chart::{self, ChartContext};
use super::lab::table::Tables;
use super::partition::wake;
use super::{Panel, PanelContext};
use crate::app::dock::Home;
use crate::app::state::{Compared, PartCost, View};
use crate::app::widgets::empty_ui;
use crate::scenario::Item;
use crate::study::compare::CompareOptions;
use crate::study::stats::BlandAltman;
use choices::Choices;
use egui::RichText;
use egui_material_icons::icons as icon;
use figures::Beside;
use measures::{Group, Named, Part};
use std::sync::Arc;
use work::{Told, Work};

/// Key of the panel.
pub const KEY: &str = "compare";

/// What is shown of the recordings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Page {
    #[default]
    Measures,
    Traces,
    Difference,
    Dwell,
    Agreement,
    Learning,
    Groups,
}

impl Page {
    const ALL: [Self; 7] = [
        Self::Measures,
        Self::Traces,
        Self::Difference,
        Self::Dwell,
        Self::Agreement,
        Self::Learning,
        Self::Groups,
    ];

    fn words(self) -> &'static str {
        match self {
            Self::Measures => "Measures",
            Self::Traces => "Traces",
            Self::Difference => "Difference",
            Self::Dwell => "Dwell",
            Self::Agreement => "Agreement",
            Self::Learning => "Learning",
            Self::Groups => "Groups",
        }
    }

    fn why(self) -> &'static str {
        match self {
            Self::Measures => "Each measure of each recording, and the stiffness felt at each site",
            Self::Traces => "Force and depth over time, overlaid",
            Self::Difference => "How far the others are from A, over time",
            Self::Dwell => "How long the fingers were where on the back",
            Self::Agreement => "Difference against mean with its limits (Bland and Altman)",
            Self::Learning => "A measure over the sessions of each participant",
            Self::Groups => "Two groups: means, difference and effect size with their intervals",
        }
    }
}

/// The Compare panel.
#[derive(Default)]
pub struct ComparePanel {
    page: Page,
    part: Part,
    choices: Choices,
    /// Key of the measure on the Learning page.
    metric: Option<&'static str>,
    groups: [Option<Group>; 2],
    tables: Tables,
    held: Option<Box<Held>>,
}

/// What it holds while it is open.
#[derive(Default)]
struct Held {
    work: Work,
    pictures: dwell::Pictures,
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
        self.choices.list_ui(ui, cx, &mut held.work);
        let told = told_of(&wanted, &held.work);
        self.pages_ui(ui);
        ui.separator();
        egui::ScrollArea::vertical()
            .id_salt(self.page.words())
            .auto_shrink(false)
            .show(ui, |ui| {
                // A plot keeps its bounds as long as its id: other curves are framed anew.
                let shown = (self.page.words(), self.part.words(), self.metric);
                let of = (shown, format!("{options:?}"), held.work.number());
                ui.push_id(of, |ui| {
                    self.page_ui(ui, cx, &mut held, &told, &options);
                });
            });
        let cost = PartCost {
            bytes: held.work.bytes(),
            cost_us: None,
        };
        cx.view.parts.report(Item::Comparison, cost);
        self.held = Some(held);
    }

    fn pages_ui(&mut self, ui: &mut egui::Ui) {
        ui.horizontal_wrapped(|ui| {
            for page in Page::ALL {
                let on = self.page == page;
                let button = ui
                    .selectable_label(on, page.words())
                    .on_hover_text(page.why());
                let name = format!("Page {}", page.words());
                button.widget_info(|| {
                    egui::WidgetInfo::selected(egui::accesskit::Role::Tab, true, on, &name)
                });
                if button.clicked() {
                    self.page = page;
                }
            }
        });
    }

    fn page_ui(
        &mut self,
        ui: &mut egui::Ui,
        cx: &PanelContext<'_>,
        held: &mut Held,
        told: &[(Compared, Named)],
        options: &CompareOptions,
    ) {
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
            Page::Groups => self.groups_ui(ui, cx, told, number),
            Page::Dwell => held.pictures.ui(ui, theme, &names, number),
            Page::Traces | Page::Difference | Page::Agreement => {
                let Some(beside) = beside_ui(ui, cx, &held.work, told, options) else {
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
                        spreads_ui(ui, &names, &beside);
                        chart::plots_ui(ui, &chart, &figures::differences(&names, &beside, theme));
                    }
                    _ => agreement_ui(ui, &chart, &names, &beside),
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
        self.part_ui(ui);
        let theme = &cx.view.theme;
        let table = measures::side_by_side(names, self.part);
        let key = |name: &str, part: Part| ("compare".to_owned(), format!("{name} {part:?}"));
        let measures = key("measures", self.part);
        self.tables.show(ui, measures, number + 1, &table, theme);
        if let Some(felt) = measures::felt(names) {
            let felt_key = key("stiffness", Part::Whole);
            self.tables.show(ui, felt_key, number + 1, &felt, theme);
        }
    }

    fn part_ui(&mut self, ui: &mut egui::Ui) {
        ui.horizontal(|ui| {
            for part in Part::ALL {
                let on = self.part == part;
                let label = ui
                    .selectable_label(on, part.words())
                    .on_hover_text("Which part of each recording is measured");
                if label.clicked() {
                    self.part = part;
                }
            }
        });
    }

    fn learning_ui(&mut self, ui: &mut egui::Ui, chart: &ChartContext<'_>, names: &[Named]) {
        self.part_ui(ui);
        let metric = measures::metric(self.metric.unwrap_or_default());
        let combo = egui::ComboBox::from_id_salt("measure")
            .selected_text(metric.title)
            .width(220.0)
            .show_ui(ui, |ui| {
                for choice in crate::study::METRICS {
                    let on = choice.key == metric.key;
                    let label = ui.selectable_label(on, choice.title);
                    if label.on_hover_text(choice.about).clicked() {
                        self.metric = Some(choice.key);
                    }
                }
            });
        combo.response.on_hover_text(metric.about).widget_info(|| {
            egui::WidgetInfo::labeled(egui::accesskit::Role::ComboBox, true, "Measure")
        });
        let plot = figures::learning(names, metric, self.part, chart.theme);
        chart::plots_ui(ui, chart, &[plot]);
    }

    fn groups_ui(
        &mut self,
        ui: &mut egui::Ui,
        cx: &PanelContext<'_>,
        told: &[(Compared, Named)],
        number: u64,
    ) {
        self.part_ui(ui);
        let members: Vec<(Compared, Arc<Told>)> = (told.iter())
            .map(|(c, (_, t))| (c.clone(), t.clone()))
            .collect();
        let offers = measures::groups(&members);
        if members.len() < 2 || offers.len() < 2 {
            ui.weak("Groups are made by tags, such as before and after, or by participants: tag the recordings in the Sessions panel and add them again");
            return;
        }
        ui.horizontal_wrapped(|ui| {
            for (i, group) in self.groups.iter_mut().enumerate() {
                let name = format!("Group {}", i + 1);
                ui.label(&name);
                let text = group.as_ref().map_or("choose", Group::words).to_owned();
                let combo = egui::ComboBox::from_id_salt(&name)
                    .selected_text(text)
                    .width(140.0)
                    .truncate()
                    .show_ui(ui, |ui| {
                        for offer in &offers {
                            ui.selectable_value(group, Some(offer.clone()), offer.words());
                        }
                    });
                let why = "Recordings with this tag, or of this participant";
                combo.response.on_hover_text(why).widget_info(|| {
                    egui::WidgetInfo::labeled(egui::accesskit::Role::ComboBox, true, &name)
                });
            }
        });
        let [Some(first), Some(second)] = &self.groups else {
            ui.weak("Choose two groups");
            return;
        };
        let table = measures::between(&members, [first, second], self.part);
        if table.rows().is_empty() {
            ui.weak("There is too little in these groups: each takes two recordings or more");
            return;
        }
        let key = ("compare".to_owned(), table.title.clone());
        let theme = &cx.view.theme;
        self.tables.show(ui, key, number + 1, &table, theme);
        ui.weak("Hedges’ g is the difference over the common standard deviation, corrected for few recordings; intervals are of 95 %");
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

/// All beside the first; `None` while there is nothing to show, which is said.
fn beside_ui(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    work: &Work,
    told: &[(Compared, Named)],
    options: &CompareOptions,
) -> Option<Beside> {
    let (first, others) = told.split_first()?;
    if others.is_empty() {
        ui.weak("Add another recording: it is set beside this one");
        return None;
    }
    let mut beside = Beside::new();
    for (c, (name, _)) in others {
        let pair = work.pair(&first.0.path, &c.path, options);
        if let Some(Err(why)) = pair {
            let text = RichText::new(format!("{name}: {why}")).color(cx.view.theme.warning);
            ui.add(egui::Label::new(text).wrap());
        }
        beside.push(pair.and_then(|p| p.as_ref().ok().cloned()));
    }
    if beside.iter().all(Option::is_none) {
        if work.progress().is_some() {
            ui.weak("They are being set side by side");
        }
        return None;
    }
    Some(beside)
}

/// How far each is from the first, in a line.
fn spreads_ui(ui: &mut egui::Ui, names: &[Named], beside: &Beside) {
    for (pair, (name, _)) in beside.iter().zip(names.iter().skip(1)) {
        let Some(c) = pair else { continue };
        let text = format!(
            "{name} against A, {}: RMS {:.3} N, {:.3} mm in depth, {:.2} mm in place; largest {:.3} N at {:.2} s",
            c.aligned,
            c.force_n.rms,
            c.depth_mm.rms,
            c.position_mm.rms,
            c.force_n.max,
            c.force_n.max_at_s
        );
        ui.add(egui::Label::new(text).wrap());
    }
}

fn agreement_ui(ui: &mut egui::Ui, chart: &ChartContext<'_>, names: &[Named], beside: &Beside) {
    for (pair, (name, _)) in beside.iter().zip(names.iter().skip(1)) {
        let Some(c) = pair else { continue };
        let Some(found) = &c.force_agreement else {
            ui.weak(format!(
                "{name}: too little in common to tell agreement from"
            ));
            continue;
        };
        let title = format!("Mean force in windows of a second: {name} against A");
        let plot = figures::agreement(found, "force (N)", &title, chart.theme);
        ui.push_id(name, |ui| chart::plots_ui(ui, chart, &[plot]));
        ui.add(egui::Label::new(words_of(found)).wrap());
    }
    ui.weak("Windows that follow each other are not independent: the intervals are too narrow where motion is slow");
}

fn words_of(found: &BlandAltman) -> String {
    format!(
        "Bias {:.3} N (95 % {:.3} to {:.3}), limits {:.3} to {:.3} N, RMSE {:.3} N, {} windows",
        found.bias,
        found.bias_interval[0],
        found.bias_interval[1],
        found.limits[0],
        found.limits[1],
        found.rmse,
        found.n
    )
}
