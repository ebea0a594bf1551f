//! Filters, sorting, progress, and what can be done with the ticked ones.

use super::detail;
use super::entry::Entry;
use super::filter::{By, Sorting};
use super::shelf::Shelf;
use crate::app::command::Command;
use crate::app::panels::PanelContext;
use crate::app::state::Compared;
use crate::app::widgets::{grouped, icon_button, named};
use egui::RichText;
use egui_material_icons::icons as icon;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// How many there are, or how far their reading is.
pub fn status_ui(
    ui: &mut egui::Ui,
    shelf: &Shelf,
    progress: Option<f64>,
    shown: usize,
    all: usize,
) {
    ui.horizontal(|ui| {
        let count = if shown == all {
            let word = if all == 1 { "recording" } else { "recordings" };
            format!("{} {word}", grouped(all))
        } else {
            format!("{} of {} recordings", grouped(shown), grouped(all))
        };
        ui.label(RichText::new(count).size(12.0).weak());
        if let Some(share) = progress {
            let bar = egui::ProgressBar::new(share as f32)
                .desired_width((ui.available_width() - 70.0).clamp(40.0, 160.0))
                .desired_height(8.0);
            ui.add(bar)
                .on_hover_text("Recordings that are new or changed are looked into once");
            let stop = ui
                .small_button("Stop")
                .on_hover_text("Stop looking into the recordings; what is known stays");
            named(ui, &stop, "Stop reading recordings");
            if stop.clicked() {
                shelf.cancel();
            }
        }
    });
}

/// What can be done with those that are ticked.
pub fn ticked_ui(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    entries: &[Entry],
    ticked: &mut BTreeSet<PathBuf>,
) {
    if ticked.is_empty() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.label(format!("{} ticked", ticked.len()));
        let paths = || ticked.iter().cloned().collect::<Vec<_>>();
        let compare = ui
            .button((icon::ICON_DIFFERENCE.rich_text(), "Compare"))
            .on_hover_text("Set the ticked recordings side by side in the Compare panel");
        named(ui, &compare, "Compare ticked");
        if compare.clicked() {
            let tagged = |path: &PathBuf| Compared {
                path: path.clone(),
                tags: (entries.iter().find(|e| e.path == *path))
                    .map(|e| e.tags.clone())
                    .unwrap_or_default(),
            };
            let recordings = ticked.iter().map(tagged).collect();
            cx.send.send(Command::Compare(recordings));
        }
        let ghosts = ui
            .button((icon::ICON_LAYERS.rich_text(), "Overlay"))
            .on_hover_text(
                "Show the fingers of the ticked recordings together in the Back view: where none is replayed yet, the first is, and the others are its ghosts",
            );
        named(ui, &ghosts, "Overlay ticked as ghosts");
        if ghosts.clicked() {
            let mut paths = paths();
            if cx.view.playback.is_none() {
                detail::replay(cx, paths.remove(0));
            }
            cx.send.send(Command::AddGhosts(paths));
        }
        let clear = ui.button("Clear").on_hover_text("Tick none");
        named(ui, &clear, "Clear ticks");
        if clear.clicked() {
            ticked.clear();
        }
    });
}

/// A list of values to filter by, or none; `what` it is stands there while all pass.
pub fn choice_ui(
    ui: &mut egui::Ui,
    what: &str,
    offers: &BTreeSet<String>,
    chosen: &mut Option<String>,
    width: f32,
) {
    let text = chosen.as_deref().unwrap_or(what).to_owned();
    let lower = what.to_lowercase();
    let combo = egui::ComboBox::from_id_salt(what)
        .selected_text(text)
        .width(width)
        .truncate()
        .show_ui(ui, |ui| {
            ui.selectable_value(chosen, None, format!("Any {lower}"));
            for offer in offers {
                ui.selectable_value(chosen, Some(offer.clone()), offer);
            }
        });
    let why = format!("Only recordings with this {lower}");
    named_combo(combo.response.on_hover_text(why), &format!("{what} filter"));
}

/// Names a combo for a screen reader.
pub fn named_combo(response: egui::Response, name: &str) {
    response.widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::ComboBox, true, name));
}

/// By what the list is sorted, and which way.
pub fn sorting_ui(ui: &mut egui::Ui, sorting: &mut Sorting) {
    let combo = egui::ComboBox::from_id_salt("sorting")
        .selected_text(sorting.by.words())
        .width(104.0)
        .show_ui(ui, |ui| {
            for by in By::ALL {
                ui.selectable_value(&mut sorting.by, by, by.words());
            }
        });
    named_combo(
        combo.response.on_hover_text("What the list is sorted by"),
        "Sort by",
    );
    let (sign, name) = if sorting.descending {
        (icon::ICON_ARROW_DOWNWARD, "Descending order")
    } else {
        (icon::ICON_ARROW_UPWARD, "Ascending order")
    };
    if icon_button(ui, sign, name, "Turn the order round").clicked() {
        sorting.descending = !sorting.descending;
    }
}
