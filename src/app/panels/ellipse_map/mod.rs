//! The Ellipse map panel: measured ellipses over the back, moved and typed, and the map that comes of them.
//!
//! | file | answers |
//! |---|---|
//! | [`doc`] | what the map is and what can be done to it |
//! | [`show`] | which value of it is on show, in which colours |
//! | [`figures`] | the printed figures as views |
//! | `keys` | the keys on the canvas |
//! | `table`, `side` | every number, settings, section, files |
//! | [`ratio`] | the printed location ratio against the true ellipse |

pub mod doc;
pub mod figures;
mod keys;
pub mod ratio;
pub mod show;
mod side;
mod table;

use super::{Panel, PanelContext};
use crate::app::bench::Wake;
use crate::app::dock::Home;
use crate::app::editor::canvas::{Canvas, Look};
use crate::app::editor::editing::Editing;
use crate::app::editor::field::Field;
use crate::app::editor::files::Files;
use crate::app::editor::frame;
use crate::app::editor::scale;
use crate::app::editor::section::Section;
use crate::app::panels::partition::wake;
use crate::app::state::{PartCost, View};
use crate::app::widgets::{empty_ui, icon_button};
use crate::geom::Vec2;
use crate::scenario::{Item, Scenario};
use doc::Doc;
use egui_material_icons::icons as icon;
use ratio::LocationRatio;
use show::{Maps, Show};

/// Key of the panel.
pub const KEY: &str = "ellipse_map";

/// The Ellipse map panel.
#[derive(Default)]
pub struct EllipseMapPanel {
    state: Option<Box<State>>,
}

/// What it holds while it is open.
pub struct State {
    editing: Editing<Doc>,
    canvas: Canvas,
    field: Field<Maps>,
    show: Show,
    section: Section,
    files: Files,
    ratio: LocationRatio,
    /// The printed figure that was loaded last, and what to see in it.
    figure: Option<(&'static str, &'static str)>,
    /// The section is to be opened or closed.
    open_section: Option<bool>,
    /// Whether the section has a place that fits this back.
    placed: bool,
}

impl State {
    fn new(scenario: &Scenario) -> Self {
        Self {
            editing: Editing::new(scenario),
            canvas: Canvas::default(),
            field: Field::default(),
            show: Show::default(),
            section: Section::default(),
            files: Files::default(),
            ratio: LocationRatio::default(),
            figure: None,
            open_section: None,
            placed: false,
        }
    }
}

impl Panel for EllipseMapPanel {
    fn key(&self) -> &'static str {
        KEY
    }

    fn title(&self) -> &'static str {
        "Ellipse map"
    }

    fn tooltip(&self) -> &'static str {
        "How far and which way a drag carries the skin, over the whole back: place and shape the measured ellipses"
    }

    fn home(&self) -> Home {
        Home::Main
    }

    fn opens_at_first(&self) -> bool {
        false
    }

    fn release(&mut self, view: &View) {
        if self.state.take().is_some() {
            view.parts.remove(Item::EllipseEditor);
        }
    }

    fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        let Some(scene) = &cx.view.scene else {
            let next = if cx.view.build.is_some() {
                "The scene is being built; its map comes next"
            } else {
                "Open a scene: its map is laid over the outline of its skin"
            };
            empty_ui(ui, icon::ICON_LENS_BLUR, "No map yet", next);
            return;
        };
        let wake = wake(ui.ctx());
        let state = self
            .state
            .get_or_insert_with(|| Box::new(State::new(&scene.scenario)));
        if state.editing.follow(cx) {
            state.field.clear();
            state.figure = None;
            state.placed = false;
            state.canvas.fit(None);
        }
        state.canvas.follow(scene, &wake);
        if let Some(silhouette) = state.canvas.silhouette().filter(|_| !state.placed) {
            state.section.ends = Section::across(&silhouette.area);
            state.placed = true;
        }
        let editable = cx.view.playback.is_none();
        state.editing.locked = !editable;
        let whole = ui.available_rect_before_wrap();
        state.editing.keys(ui, whole);
        let parts = frame::split(whole);
        frame::bar(ui, parts.bar, |ui| bar(ui, state, editable));
        canvas_ui(ui, parts.canvas, cx, state, &wake, editable);
        frame::side(ui, parts.side, |ui| {
            if !editable {
                frame::locked(ui, &cx.view.theme);
            }
            side::show(ui, cx, state, &wake, editable);
        });
        ui.advance_cursor_after_rect(whole);
        state.editing.send(ui.ctx(), cx);
        let cost = PartCost {
            bytes: state.canvas.bytes() + state.field.bytes(),
            cost_us: None,
        };
        cx.view.parts.report(Item::EllipseEditor, cost);
    }
}

/// The row of buttons above the canvas.
fn bar(ui: &mut egui::Ui, state: &mut State, editable: bool) {
    ui.add_enabled_ui(editable, |ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        state.editing.buttons(ui);
        ui.separator();
        let chosen = state.editing.selected;
        if icon_button(
            ui,
            icon::ICON_ADD_CIRCLE,
            "Add key",
            "Add a key in the middle of the view; a double click adds one under the pointer",
        )
        .clicked()
        {
            let at = state.canvas.middle();
            add(state, at);
        }
        ui.add_enabled_ui(chosen.is_some(), |ui| {
            if icon_button(
                ui,
                icon::ICON_CONTENT_COPY,
                "Duplicate key",
                "Add a copy of the chosen key beside it",
            )
            .clicked()
                && let Some(i) = chosen
            {
                let doc = state.editing.doc().with_copy(i);
                state.editing.set("Duplicate key", doc);
                state.editing.selected = state.editing.doc().keys.len().checked_sub(1);
            }
            if icon_button(
                ui,
                icon::ICON_DELETE,
                "Remove key",
                "Remove the chosen key (Delete)",
            )
            .clicked()
                && let Some(i) = chosen
            {
                let doc = state.editing.doc().without(i);
                state.editing.set("Remove key", doc);
                state.editing.selected = None;
            }
        });
        let menu = ui.menu_button("Mirror", |ui| {
            for (text, why, all, copy) in [
                (
                    "Chosen key",
                    "Move it to the other side: x becomes −x, the direction 180° less it",
                    false,
                    false,
                ),
                ("All keys", "Exchange left and right", true, false),
                (
                    "Copy chosen key",
                    "Add its mirror image on the other side",
                    false,
                    true,
                ),
                (
                    "Copy all keys",
                    "Add a mirror image of each key whose other side has none",
                    true,
                    true,
                ),
            ] {
                let item = ui
                    .add_enabled(all || chosen.is_some(), egui::Button::new(text))
                    .on_hover_text(why);
                if item.clicked() {
                    let only = if all { None } else { chosen };
                    let doc = state.editing.doc();
                    let doc = if copy {
                        doc.with_mirrored(only)
                    } else {
                        doc.mirrored(only)
                    };
                    state.editing.set("Mirror", doc);
                    ui.close();
                }
            }
        });
        menu.response
            .on_hover_text("Exchange left and right, or complete one side from the other");
    });
    ui.separator();
    side::figures_menu(ui, state, editable);
}

fn add(state: &mut State, at: Vec2) {
    let doc = state.editing.doc().with_new_key(at);
    state.editing.set("Add key", doc);
    state.editing.selected = state.editing.doc().keys.len().checked_sub(1);
}

fn canvas_ui(
    ui: &mut egui::Ui,
    rect: egui::Rect,
    cx: &PanelContext<'_>,
    state: &mut State,
    wake: &Wake,
    editable: bool,
) {
    if rect.width() < 40.0 || rect.height() < 40.0 {
        return;
    }
    let theme = &cx.view.theme;
    let name = "Ellipse map. Arrow keys move it, plus and minus zoom, Tab goes to the keys";
    let handled = state.canvas.place(ui, rect, name, true);
    if editable
        && handled.response.double_clicked()
        && let Some(at) = handled.cursor_mm
    {
        add(state, at);
    } else if handled.response.clicked() {
        state.editing.selected = None;
    }
    let spec = show::spec(state.editing.doc(), state.editing.state(), &state.show);
    let area = state.canvas.visible(rect);
    state.field.follow(&spec, area, wake);
    let picture = state.field.picture().cloned();
    let shown = picture.as_ref().filter(|p| p.quantity == spec.quantity);
    let scale = shown.map(|p| show::scale(state.editing.doc(), &state.show, p));
    let painter = ui.painter().with_clip_rect(rect);
    let look = Look {
        colour: state.show.colour,
        lines: state.show.lines && spec.lines,
        veiled: state.show.veiled,
        outline: state.show.outline,
    };
    let made = state.field.made();
    let field = shown.zip(scale).map(|(p, s)| (p.as_ref(), made, s));
    state.canvas.paint(&painter, rect, theme, field, look);
    let lay = state.canvas.lay(rect);
    let inks = state.canvas.inks(theme, field, look);
    if state.show.ellipses
        && let Some(p) = &picture
    {
        let silhouette = state.canvas.silhouette().cloned();
        let within = state.show.outline && state.show.veiled;
        let covers = |at: Vec2| !within || silhouette.as_ref().is_none_or(|s| s.covers(at));
        let map = &p.map.map;
        let basic_mm = map.settings().basic_radius_mm;
        let longest_mm = map.keys().iter().map(|k| k.half_major_mm);
        let longest_mm = longest_mm.fold(basic_mm, f64::max);
        keys::grid(&painter, lay, &inks, longest_mm, covers, |at| map.at(at));
    }
    state.section.on_canvas(ui, lay, theme);
    keys::show(
        ui,
        lay,
        theme,
        &inks,
        &state.show,
        &mut state.editing,
        editable,
    );
    let told = side::told(&state.show, picture.as_deref(), handled.cursor_mm);
    state.canvas.paint_front(&painter, rect, theme, &told);
    if let Some(scale) = scale.filter(|_| state.show.colour) {
        let quantity = state.show.quantity;
        let unit = match quantity.unit() {
            "" => String::new(),
            unit => format!(", {unit}"),
        };
        let (title, note) = if state.show.difference {
            let largest = picture.as_ref().and_then(|p| p.grid.largest());
            let note =
                largest.map(|(v, at)| format!("largest {v:+.2} at ({:.0}, {:.0})", at.x, at.y));
            (format!("Published − corrected{unit}"), note)
        } else {
            (format!("{}{unit}", quantity.text()), None)
        };
        let legend = scale::Legend {
            title: &title,
            scale,
            decimals: if state.show.difference {
                2
            } else {
                quantity.legend_decimals()
            },
            note: note.as_deref(),
        };
        let place = rect.shrink2(egui::vec2(8.0, 24.0));
        scale::legend(&painter, place, theme, &legend);
    }
    frame::view_buttons(ui, rect, &mut state.canvas);
}
