//! Beside the canvas: keys, fit, brush, what is shown, section, comparison of fits, files.

use super::doc::{Doc, KEY_N_PER_MM};
use super::show::{Maps, Show};
use super::{State, brush, keys, table};
use crate::app::editor::csv;
use crate::app::editor::field::Picture;
use crate::app::editor::files::{self, Wish};
use crate::app::editor::parts::{fold, pick};
use crate::app::editor::section::{Series, span_of};
use crate::app::panels::PanelContext;
use crate::app::theme::Theme;
use crate::app::widgets::{icon_button, named};
use crate::geom::Vec2;
use crate::maps::Fit;
use egui::RichText;
use egui_material_icons::icons as icon;

/// Shows it all.
pub fn show(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    state: &mut State,
    wake: &crate::app::bench::Wake,
    editable: bool,
) {
    let theme = &cx.view.theme;
    ui.spacing_mut().item_spacing.y = 4.0;
    state.editing.fault_ui(ui, theme);
    if let Some(fault) = state.field.fault() {
        ui.colored_label(theme.fault, fault);
    }
    fold(ui, "Fit", true, |ui| {
        ui.add_enabled_ui(editable, |ui| fit(ui, state));
    });
    fold(ui, "Keys", true, |ui| {
        ui.add_enabled_ui(editable, |ui| table::show(ui, theme, state));
    });
    fold(ui, "Brush", true, |ui| {
        ui.add_enabled_ui(editable, |ui| brush::show(ui, state));
    });
    fold(ui, "Show", true, |ui| shown(ui, &mut state.show));
    state.section.on = fold(ui, "Section", state.section.on, |ui| {
        section(ui, theme, state)
    });
    state.comparing = fold(ui, "Comparison of fits", false, |ui| {
        state.comparison.follow(state.editing.doc(), wake);
        let doc = state.editing.doc().clone();
        let selected = &mut state.editing.selected;
        let picked = state.comparison.show(ui, theme, &doc, selected);
        if let Some(fit) = picked.filter(|_| editable) {
            state.editing.set("Change fit", doc.with_fit(fit));
        }
    });
    fold(ui, "File", false, |ui| file(ui, cx, state, editable));
}

fn fit(ui: &mut egui::Ui, state: &mut State) {
    let now = state.editing.doc().fit;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for &fit in Fit::all() {
            let name = fit.name();
            if pick(ui, now == fit, name, &format!("Fit {name}"), fit.about()) && now != fit {
                let doc = state.editing.doc().with_fit(fit);
                state.editing.set("Change fit", doc);
            }
        }
    });
    ui.label(RichText::new(now.about()).size(12.0).weak());
}

fn shown(ui: &mut egui::Ui, show: &mut Show) {
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut show.colour, "Colour")
            .on_hover_text("The stiffness as colour");
        ui.checkbox(&mut show.lines, "Lines")
            .on_hover_text("Lines of equal stiffness");
        ui.checkbox(&mut show.keys, "Keys")
            .on_hover_text("The keys, with what they state in N/mm");
        ui.checkbox(&mut show.outline, "Back")
            .on_hover_text("Outline and landmarks of the back");
        ui.checkbox(&mut show.veiled, "Dim beside it")
            .on_hover_text("Dim the map where there is no skin");
    });
}

fn section(ui: &mut egui::Ui, theme: &Theme, state: &mut State) {
    ui.checkbox(&mut state.show.all_fits, "Every fit")
        .on_hover_text("Lay all fits over each other");
    let Some(picture) = state.field.picture().cloned() else {
        ui.weak("The map is being worked out");
        return;
    };
    let mut reader = picture.map.map.reader();
    let mut series = vec![Series {
        name: state.editing.doc().fit.name(),
        colour: theme.accent,
        dashed: false,
        values: state.section.values(&mut reader),
    }];
    let inks = [
        theme.warning,
        theme.good,
        theme.fault,
        theme.weak_text,
        theme.text,
    ];
    if state.show.all_fits {
        for ((fit, map), ink) in picture.map.others.iter().zip(inks) {
            let mut reader = map.reader();
            series.push(Series {
                name: fit.name(),
                colour: ink,
                dashed: true,
                values: state.section.values(&mut reader),
            });
        }
    }
    let (_, hi) = span_of(&series);
    let name = "Section of the stiffness map";
    let span = (0.0, hi.max(1e-3));
    state.section.plot(ui, theme, name, "N/mm", span, &series);
    ui.weak("Drag the ends A and B on the canvas");
}

fn file(ui: &mut egui::Ui, cx: &PanelContext<'_>, state: &mut State, editable: bool) {
    let wish = state
        .files
        .ui(ui, cx, "stiffness keys", "stiffness_keys.csv", editable);
    match wish {
        Some((Wish::Export, path)) => {
            let text = csv::write_stiffness(&state.editing.doc().keys);
            files::export(cx, &path, &text, "Stiffness keys");
        }
        Some((Wish::Import, path)) if editable => {
            let origin = path.display().to_string();
            let read = csv::load(&path)
                .and_then(|text| csv::stiffness_keys(&text, &origin, &KEY_N_PER_MM));
            let checked = read.and_then(|keys| {
                let doc = state.editing.doc().with_keys(keys);
                let map = doc.map(Fit::Constant);
                map.map(|_| doc).map_err(|e| format!("{origin}: {e}"))
            });
            match checked {
                Ok(doc) => {
                    state.editing.set("Import keys", doc);
                    state.editing.selected = None;
                }
                Err(fault) => state.editing.told = Some(fault),
            }
        }
        _ => {}
    }
}

/// The value under the pointer.
pub fn told(picture: Option<&Picture<Maps>>, doc: &Doc, cursor_mm: Option<Vec2>) -> String {
    let Some(p) = cursor_mm else {
        return String::new();
    };
    let place = format!("x {:>6.1}  y {:>6.1} mm", p.x, p.y);
    match picture {
        Some(picture) => {
            let value = picture.map.map.at(p);
            format!("{place}  {value:>7.3} N/mm  {}", doc.fit.name())
        }
        None => place,
    }
}

/// The row of buttons above the canvas.
pub fn bar(ui: &mut egui::Ui, state: &mut State, editable: bool) {
    ui.add_enabled_ui(editable, |ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        state.editing.buttons(ui);
        ui.separator();
        let chosen = state.editing.selected;
        let why = "Add a key in the middle of the view; a double click adds one under the pointer";
        if icon_button(ui, icon::ICON_ADD_CIRCLE, "Add key", why).clicked() {
            let at = state.canvas.middle();
            add(state, at);
        }
        ui.add_enabled_ui(chosen.is_some(), |ui| {
            let why = "Add a copy of the chosen key beside it";
            if icon_button(ui, icon::ICON_CONTENT_COPY, "Duplicate key", why).clicked()
                && let Some(i) = chosen
            {
                let doc = state.editing.doc().with_copy(i);
                state.editing.set("Duplicate key", doc);
                state.editing.selected = state.editing.doc().keys.len().checked_sub(1);
            }
            let why = "Remove the chosen key (Delete)";
            if icon_button(ui, icon::ICON_DELETE, "Remove key", why).clicked()
                && let Some(i) = chosen
            {
                keys::remove(&mut state.editing, i);
            }
        });
        let mirror = ui
            .button("Mirror")
            .on_hover_text("Add a copy of each key on the other side, where there is none yet");
        named(ui, &mirror, "Copy all keys to the other side");
        if mirror.clicked() {
            let doc = state.editing.doc().with_mirrored();
            state.editing.set("Mirror", doc);
        }
        ui.separator();
        let brush = ui
            .selectable_label(state.brush.on, (icon::ICON_BRUSH.rich_text(), "Brush"))
            .on_hover_text(
                "Drag over the canvas to raise or lower the stiffness; Alt does the other",
            );
        named(ui, &brush, "Take the brush");
        if brush.clicked() {
            state.brush.on = !state.brush.on;
        }
    });
}

/// Adds a key and chooses it.
pub fn add(state: &mut State, at: Vec2) {
    let doc = state.editing.doc().with_new_key(at);
    state.editing.set("Add key", doc);
    state.editing.selected = state.editing.doc().keys.len().checked_sub(1);
}
