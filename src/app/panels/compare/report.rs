//! All that the panel shows as one page, written in a file of its own.

use super::groups::{self, Group};
use super::measures::{Named, Share};
use super::work::{Told, Work};
use crate::app::bench::job::Job;
use crate::app::command::Command;
use crate::app::dialogs;
use crate::app::messages::Level;
use crate::app::panels::PanelContext;
use crate::app::panels::partition::wake;
use crate::app::state::{BuildStatus, Compared};
use crate::app::widgets::named;
use crate::figure::write_files;
use crate::session::Session;
use crate::study::compare::{CompareOptions, Comparison};
use crate::study::groups::{Grouped, Row};
use crate::study::report::{MOST_DRAWN, Outline, Report, page};
use egui::containers::menu::{MenuButton, MenuConfig};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// What the file is called unless it is called otherwise.
const FILE: &str = "comparison.html";

/// What the panel shows.
pub struct Shown<'a> {
    /// The recordings that are compared.
    pub wanted: &'a [Compared],
    /// Those that are read.
    pub told: &'a [(Compared, Named)],
    /// What is known of them.
    pub work: &'a Work,
    /// How they are aligned.
    pub options: &'a CompareOptions,
    /// The groups that are chosen.
    pub groups: &'a [Option<Group>; 2],
    /// By what share they are compared.
    pub share: Share,
}

/// The path as it is typed or chosen, and the writing.
#[derive(Default)]
pub struct Saving {
    path: Option<String>,
    inbox: Arc<Mutex<Option<PathBuf>>>,
    job: Option<Job<()>>,
}

/// Everything that a page is made of, to be made on another thread.
struct Gathered {
    told: Vec<Arc<Told>>,
    groups_of: Vec<Option<String>>,
    beside: Vec<Arc<Comparison>>,
    finger: usize,
    grouped: Option<Grouped>,
    groups_by: String,
    notes: Vec<String>,
}

impl Shown<'_> {
    /// Why it cannot be written now.
    fn hindrance(&self) -> Option<String> {
        let refused = self
            .wanted
            .iter()
            .find_map(|c| self.work.of(&c.path)?.as_ref().err());
        if let Some(why) = refused {
            return Some(format!(
                "{why}. Take it out of the comparison to save a report"
            ));
        }
        let unread = self.told.len() < self.wanted.len() || self.work.progress().is_some();
        unread.then(|| "The recordings are being read".to_owned())
    }

    fn gathered(&self) -> Gathered {
        let two = groups::chosen(self.groups);
        let group_of = |(c, named): &(Compared, Named)| groups::group_of(two?, c, named);
        let mut gathered = Gathered {
            told: Vec::new(),
            groups_of: Vec::new(),
            beside: Vec::new(),
            finger: self.options.finger.into(),
            grouped: two.map(|two| groups::between(self.told, two, self.share)),
            groups_by: self.share.words(),
            notes: Vec::new(),
        };
        let put = |of: &mut Gathered, one: &(Compared, Named)| {
            of.told.push(one.1.1.clone());
            of.groups_of.push(group_of(one));
        };
        let Some((first, others)) = self.told.split_first() else {
            return gathered;
        };
        put(&mut gathered, first);
        // Those that are set beside the first come next, in the order of what is set beside.
        let mut alone = Vec::new();
        for one in others {
            match self.work.pair(&first.0.path, &one.0.path, self.options) {
                Some(Ok(pair)) => {
                    put(&mut gathered, one);
                    gathered.beside.push(pair.clone());
                }
                Some(Err(why)) => {
                    gathered.notes.push(format!("{why}."));
                    alone.push(one);
                }
                None => alone.push(one),
            }
        }
        for one in alone {
            put(&mut gathered, one);
        }
        gathered
    }
}

impl Gathered {
    fn page(self) -> Result<String, String> {
        let drawn = self.told.iter().take(MOST_DRAWN);
        let traced = match self.beside.len() {
            0 => 0,
            n => (n + 1).min(MOST_DRAWN),
        };
        let traces = self.told.iter().take(traced);
        let outline = drawn
            .clone()
            .flat_map(|t| Session::open(&t.analysis.about.file))
            .find_map(|s| Outline::of(&s));
        let rows = self.told.iter().zip(&self.groups_of);
        let report = Report {
            rows: rows
                .map(|(t, group)| Row::of(&t.analysis, group.clone()))
                .collect(),
            dwell: drawn.map(|t| t.analysis.dwell.clone()).collect(),
            traces: traces
                .filter_map(|t| t.traces.get(self.finger).cloned())
                .collect(),
            comparisons: self.beside.iter().map(|c| (**c).clone()).collect(),
            groups: self.grouped.into_iter().collect(),
            groups_by: self.groups_by,
            notes: self.notes,
            outline,
        };
        page(&report).map_err(|e| e.to_string())
    }
}

impl Saving {
    /// The button, and under it where to.
    pub fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>, shown: &Shown<'_>) {
        if self
            .job
            .as_ref()
            .is_some_and(|job| job.poll(|| ()).is_some())
        {
            self.job = None;
        }
        let picked = self
            .inbox
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        if let Some(path) = picked {
            // The dialog asks before it names a file that is there.
            self.start(ui.ctx(), cx, shown, path, true);
        }
        let hindrance = shown.hindrance();
        let is_ready = hindrance.is_none() && self.job.is_none();
        let why = "One page to read, print and send on: measures, curves, maps, agreement and groups, with all its figures inside";
        let behaviour = egui::PopupCloseBehavior::CloseOnClickOutside;
        let button = ui.add_enabled_ui(is_ready, |ui| {
            let config = MenuConfig::new().close_behavior(behaviour);
            let menu = MenuButton::new("Save report…").config(config);
            menu.ui(ui, |ui| self.menu_ui(ui, cx, shown)).0
        });
        let button = button.inner.on_hover_text(why);
        let button =
            button.on_disabled_hover_text(hindrance.as_deref().unwrap_or("It is being written"));
        named(ui, &button, "Save report…");
    }

    fn menu_ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>, shown: &Shown<'_>) {
        let folder = cx.view.recorder.folder.clone();
        ui.horizontal(|ui| {
            let label = ui.label("File");
            let usual = || folder.join(FILE).display().to_string();
            let path = self.path.get_or_insert_with(usual);
            let field = ui
                .add(
                    egui::TextEdit::singleline(path)
                        .background_color(cx.view.theme.inset)
                        .desired_width(420.0),
                )
                .labelled_by(label.id)
                .on_hover_text("Where the page is written; Enter writes it");
            let entered = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            let some = !path.trim().is_empty();
            let path = PathBuf::from(path.trim());
            let save = ui
                .add_enabled(some, egui::Button::new("Save"))
                .on_hover_text("Write the page to this file");
            named(ui, &save, "Save report to file");
            let choose = ui
                .button("Choose…")
                .on_hover_text("Choose where the page is written");
            named(ui, &choose, "Choose file of report…");
            if choose.clicked() {
                let (inbox, ctx) = (self.inbox.clone(), ui.ctx().clone());
                let here = ctx.viewport_id();
                dialogs::save_page(cx.send, "the report", folder, FILE, move |path| {
                    *inbox.lock().unwrap_or_else(PoisonError::into_inner) = Some(path);
                    ctx.request_repaint_of(here);
                });
                ui.close();
            }
            if some && (entered || save.clicked()) {
                self.start(ui.ctx(), cx, shown, path, false);
                ui.close();
            }
        });
    }

    fn start(
        &mut self,
        ctx: &egui::Context,
        cx: &PanelContext<'_>,
        shown: &Shown<'_>,
        path: PathBuf,
        replace: bool,
    ) {
        let tell = |level, text| cx.send.send(Command::Tell(level, text));
        if let Some(why) = shown.hindrance() {
            tell(Level::Warning, format!("no report was written: {why}"));
            return;
        }
        let (gathered, send) = (shown.gathered(), cx.send.clone());
        let work = move |_: crate::app::bench::job::Progress<'_>| {
            let (level, text) = match write(gathered, &path, replace) {
                Ok(()) => (Level::Info, format!("report written to {}", path.display())),
                Err(why) => (Level::Error, format!("{}: {why}", path.display())),
            };
            send.send(Command::Tell(level, text));
        };
        match Job::start("report", BuildStatus::default(), wake(ctx), work) {
            Ok(job) => self.job = Some(job),
            Err(e) => tell(Level::Error, format!("the report cannot be written: {e}")),
        }
    }
}

fn write(gathered: Gathered, path: &Path, replace: bool) -> Result<(), String> {
    if !replace && path.exists() {
        return Err("is already there; choose another name".to_owned());
    }
    let text = gathered.page()?;
    let files = [(path.to_owned(), text.into_bytes())];
    write_files(&files).map_err(|e| format!("cannot be written: {e}"))
}
