//! A recording against itself, felt otherwise: in another scenario, with another model, engine or rate.

use super::choices::letter;
use crate::app::bench::file_name;
use crate::app::bench::job::Job;
use crate::app::panels::PanelContext;
use crate::app::panels::lab::chart::{self, ChartContext};
use crate::app::panels::lab::choices::together;
use crate::app::panels::lab::table::Tables;
use crate::app::panels::partition::wake;
use crate::app::state::{BuildStatus, Compared};
use crate::app::theme::Theme;
use crate::app::widgets::named;
use crate::contact::ForceModel;
use crate::contact::published::KINDS;
use crate::figure::{LinePlot, Mark, Series};
use crate::lab::{Table, Value};
use crate::scenario::examples;
use crate::session::Session;
use crate::study::finger_name;
use crate::study::otherwise::{Changes, Off, OtherScenario, Repeated, Thinned, repeat};
use egui::RichText;
use std::path::{Path, PathBuf};

/// Servo rates on offer, Hz.
const RATES_HZ: [u32; 7] = [100, 250, 500, 1000, 2000, 4000, 10_000];

/// In which scenario.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Scene {
    #[default]
    Recorded,
    Open,
    Example(usize),
}

/// What is to be other.
#[derive(Default)]
pub struct Choice {
    recording: Option<PathBuf>,
    scene: Scene,
    model: Option<&'static str>,
    engine: Option<&'static str>,
    rate_hz: Option<u32>,
}

/// What the page is drawn with.
pub struct Context<'a> {
    /// The panel's.
    pub cx: &'a PanelContext<'a>,
    /// The recordings that are compared.
    pub wanted: &'a [Compared],
}

type Outcome = Result<Repeated, String>;

/// The repetition under way, and what the last one came to.
#[derive(Default)]
pub struct Work {
    job: Option<Job<Outcome>>,
    found: Option<Outcome>,
    number: u64,
}

impl Work {
    /// Changes with each outcome.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let found = self.found.as_ref().and_then(|f| f.as_ref().ok());
        found.map_or(0, Repeated::bytes)
    }

    fn take(&mut self) {
        let lost = || Err("the repetition broke off".to_owned());
        let Some(found) = self.job.as_ref().and_then(|job| job.poll(lost)) else {
            return;
        };
        let was_stopped = self.job.take().is_some_and(|job| job.is_cancelled());
        if !was_stopped {
            self.found = Some(found);
            self.number += 1;
        }
    }

    fn start(&mut self, path: PathBuf, changes: Changes, ctx: &egui::Context) {
        let work = move |progress: crate::app::bench::job::Progress<'_>| {
            let session = Session::open(&path).map_err(|e| e.to_string())?;
            repeat(&session, &changes, progress).map_err(|e| e.to_string())
        };
        match Job::start("repetition", BuildStatus::default(), wake(ctx), work) {
            Ok(job) => self.job = Some(job),
            Err(e) => self.found = Some(Err(format!("the repetition cannot start: {e}"))),
        }
    }
}

impl Choice {
    /// Draws the page.
    pub fn ui(
        &mut self,
        ui: &mut egui::Ui,
        context: &Context<'_>,
        work: &mut Work,
        tables: &mut Tables,
    ) {
        work.take();
        let theme = &context.cx.view.theme;
        let Some(path) = self.choices_ui(ui, context) else {
            return;
        };
        ui.horizontal_wrapped(|ui| {
            if let Some(job) = &work.job {
                let status = job.status();
                let bar = egui::ProgressBar::new(status.fraction as f32)
                    .desired_width(160.0)
                    .desired_height(8.0);
                ui.add(bar).on_hover_text(&status.part);
                let stop = ui
                    .small_button("Stop")
                    .on_hover_text("Stop repeating; what was found before stays");
                named(ui, &stop, "Stop repeating");
                if stop.clicked() {
                    job.cancel();
                }
            } else {
                let button = ui.button("Repeat").on_hover_text(
                    "Feel the recorded motion otherwise, and tell how far that is off",
                );
                named(ui, &button, "Repeat recording otherwise");
                if button.clicked() {
                    work.start(path, self.changes(context), ui.ctx());
                }
            }
        });
        match &work.found {
            None if work.job.is_none() => {
                ui.weak("Choose what is to be other and press Repeat; nothing other tells whether it comes out as recorded");
            }
            None => {}
            Some(Err(why)) => {
                ui.add(egui::Label::new(RichText::new(why).color(theme.warning)).wrap());
            }
            Some(Ok(found)) => found_ui(ui, theme, found, tables, work.number),
        }
    }

    fn changes(&self, context: &Context<'_>) -> Changes {
        let scenario = match self.scene {
            Scene::Recorded => None,
            Scene::Open => context.cx.view.scene.as_ref().map(|scene| OtherScenario {
                origin: format!("the open scene {}", scene.scenario.name),
                toml: scene.scenario.source.as_str().into(),
                folder: scene.scenario.folder.clone(),
            }),
            Scene::Example(i) => examples().get(i).map(|example| OtherScenario {
                origin: example.file.to_owned(),
                toml: example.text.into(),
                folder: None,
            }),
        };
        Changes {
            scenario,
            force_model: self.model.map(str::to_owned),
            engine: self.engine.map(str::to_owned),
            rate_hz: self.rate_hz.map(f64::from),
        }
    }

    /// The recording, and what is to be other.
    fn choices_ui(&mut self, ui: &mut egui::Ui, context: &Context<'_>) -> Option<PathBuf> {
        let wanted = context.wanted;
        let called = |path: &Path| {
            let place = wanted.iter().position(|c| c.path == path)?;
            Some(format!("{} {}", letter(place), file_name(path)))
        };
        let current = self.recording.clone().filter(|p| called(p).is_some());
        let mut current = current.or_else(|| Some(wanted.first()?.path.clone()))?;
        ui.horizontal_wrapped(|ui| {
            let text = called(&current).unwrap_or_default();
            let why = "Which recording is repeated";
            combo(ui, "Recording", &text, 190.0, why, |ui| {
                for c in wanted {
                    let text = called(&c.path).unwrap_or_default();
                    ui.selectable_value(&mut current, c.path.clone(), text);
                }
            });
            self.scene_ui(ui, context);
            let why = "How force follows from depth; with the model's default settings";
            let text = self.model.unwrap_or("as in the scenario");
            combo(ui, "Force model", text, 140.0, why, |ui| {
                ui.selectable_value(&mut self.model, None, "as in the scenario");
                for model in ForceModel::all() {
                    ui.selectable_value(&mut self.model, Some(model.name()), model.name());
                }
            });
            let why = "What finds the contact: the production engine, or the published pass with one of its partitions";
            let text = self.engine.unwrap_or("as in the scenario");
            combo(ui, "Engine", text, 140.0, why, |ui| {
                ui.selectable_value(&mut self.engine, None, "as in the scenario");
                for name in ["production", "published"] {
                    ui.selectable_value(&mut self.engine, Some(name), name);
                }
                for kind in KINDS {
                    let text = format!("published, {kind}");
                    ui.selectable_value(&mut self.engine, Some(kind), text);
                }
            });
            let why = "Ticks per second; motion between the recorded ticks is interpolated";
            let words = |rate: Option<u32>| {
                rate.map_or("as recorded".to_owned(), |rate| format!("{rate} Hz"))
            };
            combo(ui, "Rate", &words(self.rate_hz), 100.0, why, |ui| {
                ui.selectable_value(&mut self.rate_hz, None, words(None));
                for rate in RATES_HZ {
                    ui.selectable_value(&mut self.rate_hz, Some(rate), words(Some(rate)));
                }
            });
        });
        self.recording = Some(current.clone());
        Some(current)
    }

    fn scene_ui(&mut self, ui: &mut egui::Ui, context: &Context<'_>) {
        let open = context.cx.view.scene.as_ref();
        if open.is_none() && self.scene == Scene::Open {
            self.scene = Scene::Recorded;
        }
        let words = |scene: Scene| match scene {
            Scene::Recorded => "as recorded".to_owned(),
            Scene::Open => open.map_or(String::new(), |s| format!("open: {}", s.scenario.name)),
            Scene::Example(i) => examples().get(i).map_or("", |e| e.file).to_owned(),
        };
        let why = "The scene that is felt; edits made while it was recorded count only in its own";
        combo(ui, "Scenario", &words(self.scene), 170.0, why, |ui| {
            let open = open.map(|_| Scene::Open);
            let offers = [Scene::Recorded].into_iter().chain(open);
            for offer in offers.chain((0..examples().len()).map(Scene::Example)) {
                ui.selectable_value(&mut self.scene, offer, words(offer));
            }
        });
    }
}

/// A labelled choice.
fn combo(
    ui: &mut egui::Ui,
    name: &str,
    text: &str,
    width: f32,
    why: &str,
    add: impl FnOnce(&mut egui::Ui),
) {
    together(ui, name, width + 8.0, |ui| {
        ui.label(name);
        let combo = egui::ComboBox::from_id_salt(name)
            .selected_text(text)
            .width(width)
            .truncate()
            .show_ui(ui, add);
        combo.response.on_hover_text(why).widget_info(|| {
            let name = format!("{name} of the repetition");
            egui::WidgetInfo::labeled(egui::accesskit::Role::ComboBox, true, name)
        });
    });
}

fn found_ui(ui: &mut egui::Ui, theme: &Theme, found: &Repeated, tables: &mut Tables, number: u64) {
    let d = &found.divergence;
    let anew = match d.gaps {
        0 => String::new(),
        1 => ", begun anew once".to_owned(),
        n => format!(", begun anew {n} times"),
    };
    let text = format!(
        "{}, {}: {} recorded ticks compared, {} computed{anew}",
        found.name, found.changes, d.compared, d.computed
    );
    ui.add(egui::Label::new(RichText::new(text).strong()).wrap());
    if !found.is_same_surface {
        ui.weak("Felt on another surface than the recorded one: the fingers begin where the devices were");
    }
    let is_off = |f: &crate::session::FingerOff| {
        f.proxy_mm.max + f.force_n.max + f.sent_force_n.max + f.depth_mm.max > 0.0
    };
    if !d.fingers.iter().any(is_off) {
        ui.label("Every tick came out as recorded");
    }
    let table = summary(found);
    let key = ("compare".to_owned(), "repeated".to_owned());
    tables.show(ui, key, number, &table, theme);
    let chart = ChartContext { theme, tables: &[] };
    ui.push_id(number, |ui| {
        chart::plots_ui(ui, &chart, &plots(found, theme))
    });
}

fn summary(found: &Repeated) -> Table {
    let columns = ["finger", "quantity", "unit", "RMS", "greatest", "at (s)"];
    let title = format!("How far it is off: {}", found.changes);
    let mut table = Table::new("repeated", title, &columns);
    for f in &found.divergence.fingers {
        let rows = [
            ("distance of the proxies", "mm", &f.proxy_mm),
            ("difference of the forces", "N", &f.force_n),
            ("difference of the forces sent", "N", &f.sent_force_n),
            ("difference of the depths", "mm", &f.depth_mm),
        ];
        for (what, unit, spread) in rows {
            let at_s = (spread.max > 0.0).then(|| found.time_s(spread.max_tick));
            table.push([
                Value::from(finger_name(f.finger)),
                Value::from(what),
                Value::from(unit),
                Value::from(spread.rms),
                Value::from(spread.max),
                at_s.map_or(Value::Empty, Value::from),
            ]);
        }
    }
    table
}

/// Force, depth and position over time, finger by finger; of each stretch the least and the greatest.
fn plots(found: &Repeated, theme: &Theme) -> Vec<LinePlot> {
    let plot = |title: &str, label: &str, of: fn(&Off) -> &Thinned| {
        let series = found.fingers.iter().map(|off| {
            let [r, g, b, _] = theme.finger(off.finger.into()).to_array();
            Series {
                name: finger_name(off.finger).to_owned(),
                colour: [r, g, b],
                mark: Mark::Line,
                points: of(off).points(),
            }
        });
        LinePlot {
            title: title.to_owned(),
            x_label: "time since the first tick (s)".into(),
            y_label: label.to_owned(),
            series: series.collect(),
            ..LinePlot::default()
        }
    };
    vec![
        plot(
            "Size of the difference of the forces",
            "difference (N)",
            |o| &o.force_n,
        ),
        plot("Depth less that recorded", "difference (mm)", |o| {
            &o.depth_mm
        }),
        plot("Distance of the proxies", "distance (mm)", |o| {
            &o.position_mm
        }),
    ]
}
