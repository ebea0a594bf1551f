//! The list, one card each.

use super::entry::{Entry, Listing, Origin};
use super::picture::SIZE;
use crate::app::command::Command;
use crate::app::panels::PanelContext;
use crate::app::theme::Theme;
use crate::app::widgets::{empty_ui, named};
use egui::{Rect, RichText, TextureHandle, pos2, vec2};
use egui_material_icons::icons as icon;
use std::path::Path;

/// Size of a picture, points.
const PICTURE: egui::Vec2 = vec2(SIZE[0] as f32 / 2.0, SIZE[1] as f32 / 2.0);

/// Shows it; `picture` is that of a content, once it is painted.
pub fn show(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    listing: Option<&Listing>,
    filter: &str,
    folder: &Path,
    picture: &dyn Fn(u64) -> Option<TextureHandle>,
) {
    let theme = &cx.view.theme;
    let Some(listing) = listing else {
        let next = "The scenarios are being read";
        empty_ui(ui, icon::ICON_LIST, "One moment", next);
        return;
    };
    let tells = super::tells(cx.view);
    egui::ScrollArea::vertical()
        .auto_shrink(false)
        .show(ui, |ui| {
            if let Some(note) = &listing.note {
                ui.colored_label(theme.warning, note);
            }
            let shown = |e: &&Entry| e.fits(filter, tells);
            let is_example = |e: &Entry| matches!(e.origin, Origin::Example(_));
            let files: Vec<_> = (listing.entries.iter())
                .filter(|e| !is_example(e))
                .filter(shown)
                .collect();
            let examples: Vec<_> = (listing.entries.iter())
                .filter(|e| is_example(e))
                .filter(shown)
                .collect();
            if files.is_empty() && examples.is_empty() {
                ui.weak("None has this: shorten the filter");
                return;
            }
            let none = listing.entries.iter().all(is_example);
            heading(ui, &format!("In {}", folder.display()));
            if none {
                ui.weak("No scenario file here yet: save one, or choose another folder");
            } else if files.is_empty() {
                ui.weak("None of this folder has this");
            }
            for entry in files {
                card(ui, cx, theme, entry, tells, picture);
            }
            if !examples.is_empty() {
                heading(ui, "Examples");
            }
            for entry in examples {
                card(ui, cx, theme, entry, tells, picture);
            }
        });
}

fn heading(ui: &mut egui::Ui, text: &str) {
    ui.add_space(4.0);
    ui.add(egui::Label::new(RichText::new(text).strong()).truncate());
}

fn card(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    theme: &Theme,
    entry: &Entry,
    tells: bool,
    picture: &dyn Fn(u64) -> Option<TextureHandle>,
) {
    let is_open = is_open(cx, entry);
    let stroke = if is_open {
        egui::Stroke::new(1.5, theme.accent)
    } else {
        egui::Stroke::new(1.0, theme.line)
    };
    egui::Frame::new()
        .fill(theme.inset)
        .stroke(stroke)
        .corner_radius(5.0)
        .inner_margin(6.0)
        .show(ui, |ui| {
            ui.horizontal_top(|ui| {
                if entry.scenario.is_some() {
                    let (rect, _) = ui.allocate_exact_size(PICTURE, egui::Sense::hover());
                    if let Some(texture) = picture(entry.picture(tells)) {
                        let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                        ui.painter()
                            .image(texture.id(), rect, uv, egui::Color32::WHITE);
                    }
                }
                ui.vertical(|ui| {
                    ui.set_min_width(ui.available_width());
                    words(ui, cx, theme, entry, tells, is_open);
                });
            });
        });
}

fn words(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    theme: &Theme,
    entry: &Entry,
    tells: bool,
    is_open: bool,
) {
    ui.spacing_mut().item_spacing.y = 3.0;
    ui.add(egui::Label::new(RichText::new(&entry.name).strong()).wrap());
    let colour = if entry.scenario.is_some() {
        theme.text
    } else {
        theme.fault
    };
    let text = RichText::new(&entry.description).size(12.0).color(colour);
    ui.add(egui::Label::new(text).wrap());
    let told = [
        entry.asks.as_deref(),
        entry.hides.as_deref().filter(|_| tells),
    ];
    for text in told.into_iter().flatten() {
        ui.add(egui::Label::new(RichText::new(text).size(12.0).weak()).wrap());
    }
    ui.horizontal(|ui| {
        let (text, why) = match (is_open, entry.scenario.is_some()) {
            (true, _) => ("Open now", "The scene on show"),
            (false, true) => ("Open", "Build this scene and feel it"),
            (false, false) => ("Open", "It has a fault: mend the file first"),
        };
        let button = ui
            .add_enabled(
                entry.scenario.is_some() && !is_open,
                egui::Button::new(text),
            )
            .on_hover_text(why)
            .on_disabled_hover_text(why);
        named(ui, &button, &format!("Open {}", entry.name));
        if button.clicked() {
            cx.send.send(match &entry.origin {
                Origin::Example(file) => Command::OpenExample(file),
                Origin::File(path) => Command::OpenScenario(path.clone()),
            });
        }
        ui.add(egui::Label::new(RichText::new(entry.file()).size(11.5).weak()).truncate());
    });
}

/// Whether it is the scene on show, not edited.
fn is_open(cx: &PanelContext<'_>, entry: &Entry) -> bool {
    let (Some(open), Some(this)) = (&cx.view.scene, &entry.scenario) else {
        return false;
    };
    open.scenario.source == this.source && open.scenario.folder == this.folder
}
