//! The Sessions panel: the recordings of a folder, to be found, tagged, replayed and compared.
//!
//! | file | answers |
//! |---|---|
//! | [`entry`] | what there is to know of a recording without opening it |
//! | [`shelf`] | the recordings of a folder, read on a thread of their own |
//! | [`filter`] | which are shown, and in which order |
//! | `list` | how they are shown |
//! | `controls` | filters, sorting, progress, and what can be done with the ticked ones |
//! | `detail` | what is told of the current one, and what can be done with it |
//! | `picture` | its thumbnail |

mod controls;
mod detail;
pub mod entry;
pub mod filter;
mod list;
mod picture;
pub mod shelf;

use super::folder::{FolderChoice, Words};
use super::library::picture::Silhouettes;
use super::partition::wake;
use super::{Panel, PanelContext};
use crate::app::command::Command;
use crate::app::dock::Home;
use crate::app::state::{Compared, PartCost, View};
use crate::app::theme::Theme;
use crate::app::widgets::{empty_ui, icon_button};
use crate::scenario::Item;
use crate::study::index::Thumbnail;
use controls::{choice_ui, named_combo, sorting_ui, status_ui, ticked_ui};
use egui::{TextureHandle, TextureOptions};
use egui_material_icons::icons as icon;
use entry::Entry;
use filter::{Filter, Since, Sorting};
use list::{Asked, List};
use shelf::Shelf;
use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// Key of the panel.
pub const KEY: &str = "sessions";
/// Thumbnails kept on the graphics card.
const PICTURES: usize = 256;
/// Thumbnails made in a frame: each takes about a millisecond.
const MADE_PER_FRAME: usize = 4;

/// The Sessions panel.
#[derive(Default)]
pub struct SessionsPanel {
    filter: Filter,
    sorting: Sorting,
    /// A folder that was chosen; without one that of the recorder.
    folder: FolderChoice,
    list: List,
    tags: detail::Typed,
    held: Option<Box<Held>>,
}

/// What it holds while it is open.
struct Held {
    shelf: Shelf,
    /// How many recordings had been finished when the folder was read.
    finished: u64,
    pictures: HashMap<PathBuf, Picture>,
    silhouettes: Silhouettes,
    /// The order on show, and what it was made of.
    order: Vec<usize>,
    made_of: Option<(u64, Filter, Sorting)>,
    /// What the filters offer.
    offers: Offers,
}

/// A thumbnail.
struct Picture {
    of: Arc<Thumbnail>,
    dark: bool,
    /// `None`: there is nothing to be seen.
    texture: Option<TextureHandle>,
}

/// Values that occur among the recordings.
#[derive(Default)]
struct Offers {
    participants: BTreeSet<String>,
    scenarios: BTreeSet<String>,
    tags: BTreeSet<String>,
}

impl Offers {
    fn of(entries: &[Entry]) -> Self {
        let mut offers = Self::default();
        for e in entries {
            offers.participants.extend(e.participant.clone());
            if !e.scenario.is_empty() {
                offers.scenarios.insert(e.scenario.clone());
            }
            offers.tags.extend(e.tags.iter().cloned());
        }
        offers
    }
}

impl Panel for SessionsPanel {
    fn key(&self) -> &'static str {
        KEY
    }

    fn title(&self) -> &'static str {
        "Sessions"
    }

    fn tooltip(&self) -> &'static str {
        "Find a recording by participant, scenario, date or tag; replay it, compare it"
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
            view.parts.remove(Item::SessionPictures);
        }
    }

    fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        if cx.view.blind {
            empty_ui(
                ui,
                icon::ICON_VISIBILITY_OFF,
                "Hidden while the exercise runs",
                "Earlier recordings would tell where to look",
            );
            return;
        }
        let chosen = self.folder.get().cloned();
        let folder = chosen.unwrap_or_else(|| cx.view.recorder.folder.clone());
        self.follow(ui.ctx(), cx.view, &folder);
        self.head_ui(ui, cx, &folder);
        self.filters_ui(ui);
        self.body_ui(ui, cx);
        self.report(cx.view);
    }
}

impl SessionsPanel {
    /// Reads the folder when it is another one, and looks again when a recording was finished since.
    fn follow(&mut self, ctx: &egui::Context, view: &View, folder: &Path) {
        let finished = view.recorder.finished;
        let held = match self.held.take() {
            Some(held) if held.shelf.folder() == folder => held,
            before => {
                let (pictures, silhouettes) = before
                    .map(|held| (held.pictures, held.silhouettes))
                    .unwrap_or_default();
                Box::new(Held {
                    shelf: Shelf::of(folder, wake(ctx)),
                    finished,
                    pictures,
                    silhouettes,
                    order: Vec::new(),
                    made_of: None,
                    offers: Offers::default(),
                })
            }
        };
        let held = self.held.insert(held);
        // Asked while a reading is under way, it would not be heard.
        if held.finished != finished && held.shelf.progress().is_none() {
            held.finished = finished;
            held.shelf.look_again();
        }
        held.shelf.poll();
        held.follow(&self.filter, self.sorting);
    }

    fn head_ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>, folder: &Path) {
        ui.horizontal(|ui| {
            let words = Words {
                what: "recordings",
                field: "Whose recordings are listed; Enter takes it. Empty: that of the recorder",
                button: "Choose the folder whose recordings are listed",
            };
            self.folder.ui(ui, cx.send, folder, &words, 28.0);
            let why = "Look at the folder again";
            if icon_button(ui, icon::ICON_REFRESH, "Read folder again", why).clicked()
                && let Some(held) = &mut self.held
            {
                held.shelf.look_again();
            }
        });
    }

    fn filters_ui(&mut self, ui: &mut egui::Ui) {
        let Some(held) = &self.held else { return };
        let narrow = ui.available_width() < list::WIDE;
        ui.horizontal(|ui| {
            let label = ui.label("Find");
            let room = if narrow { 150.0 } else { 8.0 };
            ui.add(
                egui::TextEdit::singleline(&mut self.filter.text)
                    .hint_text("Scenario, participant, tag or file")
                    .desired_width((ui.available_width() - room).max(60.0)),
            )
            .labelled_by(label.id)
            .on_hover_text("Only recordings in which every one of these words is found");
            if narrow {
                sorting_ui(ui, &mut self.sorting);
            }
        });
        let (offers, filter) = (&held.offers, &mut self.filter);
        ui.horizontal(|ui| {
            // Arrow and edges of each, and the room between.
            let width = ((ui.available_width() - 24.0) / 4.0 - 30.0).clamp(36.0, 160.0);
            let who = &mut filter.participant;
            choice_ui(ui, "Participant", &offers.participants, who, width);
            let what = &mut filter.scenario;
            choice_ui(ui, "Scenario", &offers.scenarios, what, width);
            choice_ui(ui, "Tag", &offers.tags, &mut filter.tag, width);
            let text = match filter.since {
                Since::Any => "Date",
                since => since.words(),
            };
            let combo = egui::ComboBox::from_id_salt("since")
                .selected_text(text)
                .width(width)
                .truncate()
                .show_ui(ui, |ui| {
                    for choice in Since::ALL {
                        ui.selectable_value(&mut filter.since, choice, choice.words());
                    }
                });
            let why = "How long ago it may have been recorded";
            named_combo(combo.response.on_hover_text(why), "Date filter");
        });
    }

    fn body_ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        let theme = cx.view.theme;
        let Some(held) = &mut self.held else { return };
        let (entries, _) = held.shelf.entries();
        let progress = held.shelf.progress();
        if let Some(note) = held.shelf.note() {
            ui.colored_label(theme.warning, note);
        }
        let known = |p: &PathBuf| entries.iter().any(|e| e.path == *p && e.can_open());
        self.list.ticked.retain(known);
        let current =
            (self.list.current.as_ref()).and_then(|path| entries.iter().find(|e| e.path == *path));
        egui::Panel::bottom("chosen")
            .resizable(false)
            .frame(egui::Frame::new().inner_margin(egui::Margin {
                top: 6,
                ..egui::Margin::ZERO
            }))
            .show(ui, |ui| {
                status_ui(ui, &held.shelf, progress, held.order.len(), entries.len());
                ticked_ui(ui, cx, &entries, &mut self.list.ticked);
                let Some(entry) = current else {
                    if !entries.is_empty() {
                        ui.weak("Click a recording for more of it; tick several to compare them");
                    }
                    return;
                };
                if let Some(tags) = detail::ui(ui, cx, entry, &mut self.tags) {
                    held.shelf.tag(&entry.path, tags.clone());
                    let path = entry.path.clone();
                    cx.send.send(Command::Retag(Compared { path, tags }));
                }
            });
        if entries.is_empty() && progress.is_none() {
            let next = "Record one with the Recorder, or choose another folder above";
            empty_ui(ui, icon::ICON_VIDEO_LIBRARY, "No recording here", next);
            return;
        }
        if held.order.is_empty() && !self.filter.is_open() {
            let next = "No recording passes: take a filter away";
            empty_ui(ui, icon::ICON_FILTER_ALT_OFF, "None found", next);
            return;
        }
        let shown = list::Shown {
            entries: &entries,
            places: &held.order,
            theme: &theme,
            replayed: cx.view.playback.as_ref().map(|p| p.path.as_path()),
        };
        let ctx = ui.ctx().clone();
        let mut room = MADE_PER_FRAME;
        let (pictures, silhouettes) = (&mut held.pictures, &held.silhouettes);
        let mut picture =
            |entry: &Entry| picture_of(entry, &theme, &ctx, pictures, silhouettes, &mut room);
        let asked = self.list.ui(ui, &shown, &mut self.sorting, &mut picture);
        if let Some(Asked::Open(path)) = asked {
            detail::replay(cx, path);
        }
    }

    fn report(&self, view: &View) {
        let Some(held) = &self.held else { return };
        let bytes = |t: &TextureHandle| t.size()[0] * t.size()[1] * 4;
        let pictures = held.pictures.values().filter_map(|p| p.texture.as_ref());
        let cost = PartCost {
            bytes: held.shelf.bytes() + pictures.map(bytes).sum::<usize>(),
            cost_us: None,
        };
        view.parts.report(Item::SessionPictures, cost);
    }
}

impl Held {
    /// Brings the order up to date.
    fn follow(&mut self, filter: &Filter, sorting: Sorting) {
        let (entries, version) = self.shelf.entries();
        let made_of = (version, filter.clone(), sorting);
        if self.made_of.as_ref() == Some(&made_of) {
            return;
        }
        self.order = filter::shown(&entries, filter, sorting, SystemTime::now());
        if self.made_of.as_ref().is_none_or(|m| m.0 != version) {
            self.offers = Offers::of(&entries);
        }
        self.made_of = Some(made_of);
    }
}

/// The thumbnail of an entry; a few are made in each frame, and as many kept as a long list shows.
fn picture_of(
    entry: &Entry,
    theme: &Theme,
    ctx: &egui::Context,
    pictures: &mut HashMap<PathBuf, Picture>,
    silhouettes: &Silhouettes,
    room: &mut usize,
) -> Option<TextureHandle> {
    let dwell = entry.dwell.as_ref()?;
    if let Some(made) = pictures.get(&entry.path)
        && Arc::ptr_eq(&made.of, dwell)
        && made.dark == theme.dark
    {
        return made.texture.clone();
    }
    if *room == 0 {
        ctx.request_repaint();
        return None;
    }
    *room -= 1;
    if pictures.len() >= PICTURES {
        pictures.clear();
    }
    let image = picture::paint(dwell, silhouettes, theme);
    let texture = image.map(|image| ctx.load_texture("session", image, TextureOptions::LINEAR));
    let made = Picture {
        of: dwell.clone(),
        dark: theme.dark,
        texture: texture.clone(),
    };
    pictures.insert(entry.path.clone(), made);
    texture
}
