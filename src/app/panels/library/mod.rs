//! The Scenarios panel: the examples and the files of a folder, each with a small picture and what it is for.
//!
//! | file | answers |
//! |---|---|
//! | [`entry`] | what there is to know of a scenario without opening it |
//! | [`picture`] | its small picture |
//! | `cards` | how they are shown |

mod cards;
pub mod entry;
pub mod picture;

use super::folder::{FolderChoice, Words};
use super::{Panel, PanelContext};
use crate::app::bench::Wake;
use crate::app::dock::Home;
use crate::app::editor::worker::Worker;
use crate::app::panels::partition::wake;
use crate::app::roles::Role;
use crate::app::state::{PartCost, View};
use crate::app::widgets::icon_button;
use crate::scenario::Item;
use egui::{ColorImage, TextureHandle, TextureOptions};
use egui_material_icons::icons as icon;
use entry::{Entry, Listing};
use picture::Silhouettes;
use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::sync::Arc;

/// Key of the panel.
pub const KEY: &str = "library";
/// Folder of the user's scenarios, beside that of the recordings.
const SCENARIOS: &str = "scenarios";

/// The Scenarios panel.
#[derive(Default)]
pub struct LibraryPanel {
    filter: String,
    /// A folder that was chosen; without one that of the open scenario, or the user's.
    folder: FolderChoice,
    held: Option<Box<Held>>,
}

/// What it holds while it is open.
struct Held {
    listing: Option<Arc<Listing>>,
    lister: Worker<Listing>,
    /// What the list is of: the folder, the scene, whether that is saved, and how often it was asked for.
    asked: Option<(PathBuf, u64, bool, u64)>,
    again: u64,
    painter: Worker<(u64, Option<ColorImage>)>,
    /// Pictures by the content that they show; `None`: there is none.
    pictures: HashMap<u64, Option<TextureHandle>>,
    silhouettes: Arc<Silhouettes>,
}

impl Default for Held {
    fn default() -> Self {
        Self {
            listing: None,
            lister: Worker::new("list of scenarios"),
            asked: None,
            again: 0,
            painter: Worker::new("picture of a scenario"),
            pictures: HashMap::new(),
            silhouettes: Arc::default(),
        }
    }
}

/// Whether what a scenario hides may be told here.
fn tells(view: &View) -> bool {
    !view.blind && view.role != Role::Trainee
}

impl Panel for LibraryPanel {
    fn key(&self) -> &'static str {
        KEY
    }

    fn title(&self) -> &'static str {
        "Scenarios"
    }

    fn tooltip(&self) -> &'static str {
        "Find a scenario: the examples and the files of a folder, each with a picture and what it is for"
    }

    fn home(&self) -> Home {
        Home::RightTop
    }

    fn opens_at_first(&self) -> bool {
        false
    }

    fn keep(&self) -> Option<String> {
        self.folder.keep()
    }

    fn recall(&mut self, kept: &str) {
        self.folder.recall(kept);
    }

    fn release(&mut self, view: &View) {
        if self.held.take().is_some() {
            view.parts.remove(Item::Thumbnails);
        }
    }

    fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        let wake = wake(ui.ctx());
        let folder = self.listed(cx.view);
        let held = self.held.get_or_insert_with(Box::default);
        held.list(&folder, cx.view, &wake);
        held.paint(ui.ctx(), tells(cx.view), &wake);
        let again = self.head(ui, cx, &folder);
        let Some(held) = &mut self.held else {
            return;
        };
        if again {
            held.again += 1;
        }
        cards::show(
            ui,
            cx,
            held.listing.as_deref(),
            &self.filter,
            &folder,
            &|hash| held.pictures.get(&hash).cloned().flatten(),
        );
        let bytes = |t: &TextureHandle| t.size()[0] * t.size()[1] * 4;
        let cost = PartCost {
            bytes: held.pictures.values().flatten().map(bytes).sum(),
            cost_us: None,
        };
        cx.view.parts.report(Item::Thumbnails, cost);
    }
}

impl LibraryPanel {
    fn listed(&mut self, view: &View) -> PathBuf {
        let of_scene = || view.scene.as_ref()?.scenario.folder.clone();
        let own = || {
            let beside = view.recorder.folder.parent();
            beside.map_or_else(|| PathBuf::from(SCENARIOS), |beside| beside.join(SCENARIOS))
        };
        let chosen = self.folder.get().cloned();
        chosen.or_else(of_scene).unwrap_or_else(own)
    }

    /// Filter and folder; true when the list is to be made anew.
    fn head(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>, folder: &std::path::Path) -> bool {
        let mut again = false;
        ui.horizontal(|ui| {
            let label = ui.label("Filter");
            ui.add(
                egui::TextEdit::singleline(&mut self.filter)
                    .hint_text("Part of a name or of what it is for")
                    .desired_width((ui.available_width() - 40.0).max(60.0)),
            )
            .labelled_by(label.id)
            .on_hover_text(
                "Only scenarios that have this in name, description, file or dysfunctions",
            );
            let why = "Look at the folder again";
            again = icon_button(ui, icon::ICON_REFRESH, "List again", why).clicked();
        });
        let words = Words {
            what: "scenarios",
            field: "Whose scenario files are listed; Enter takes it. Empty: that of the open scenario",
            button: "Choose the folder whose scenario files are listed",
        };
        ui.horizontal(|ui| self.folder.ui(ui, cx.send, folder, &words, 0.0));
        again
    }
}

impl Held {
    /// Keeps the list up to date.
    fn list(&mut self, folder: &std::path::Path, view: &View, wake: &Wake) {
        if let Some(listing) = self.lister.poll(wake) {
            self.listing = Some(Arc::new(listing));
        }
        let asked = (
            folder.to_owned(),
            view.scene_generation,
            view.unsaved,
            self.again,
        );
        if self.asked.as_ref() == Some(&asked) {
            return;
        }
        self.asked = Some(asked);
        let folder = folder.to_owned();
        self.lister
            .ask(true, move |go_on| Listing::of(&folder, go_on), wake);
    }

    /// Makes the pictures that are missing, one after the other.
    fn paint(&mut self, ctx: &egui::Context, tells: bool, wake: &Wake) {
        if let Some((hash, image)) = self.painter.poll(wake) {
            let texture =
                image.map(|image| ctx.load_texture("scenario", image, TextureOptions::LINEAR));
            self.pictures.insert(hash, texture);
        }
        let Some(listing) = &self.listing else {
            return;
        };
        let wanted: HashSet<u64> = listing.entries.iter().map(|e| e.picture(tells)).collect();
        self.pictures.retain(|hash, _| wanted.contains(hash));
        if self.painter.is_busy() {
            return;
        }
        let missing = |e: &&Entry| !self.pictures.contains_key(&e.picture(tells));
        let Some(entry) = listing.entries.iter().find(missing) else {
            return;
        };
        let hash = entry.picture(tells);
        let Some(scenario) = entry.scenario.clone() else {
            self.pictures.insert(hash, None);
            ctx.request_repaint();
            return;
        };
        let silhouettes = self.silhouettes.clone();
        let work = move |go_on: &dyn Fn() -> bool| {
            Some((hash, picture::paint(&scenario, tells, &silhouettes, go_on)))
        };
        self.painter.ask(false, work, wake);
    }
}
