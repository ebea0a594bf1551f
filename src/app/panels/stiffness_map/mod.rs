//! The Stiffness map panel: measured stiffness over the back, moved, typed and painted, and the map that comes of it.
//!
//! | file | answers |
//! |---|---|
//! | [`doc`] | what the map is and what can be done to it |
//! | [`show`] | what of it is on show, in which colours |
//! | [`compare`] | which fit foretells best |
//! | `keys` | keys and brush on the canvas |
//! | `table`, `brush`, `side` | every number, strokes, fit, section, files |

mod brush;
pub mod compare;
pub mod doc;
mod keys;
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
use crate::app::widgets::empty_ui;
use crate::scenario::{Item, Scenario};
use compare::Comparison;
use doc::{Brush, Doc};
use egui_material_icons::icons as icon;
use show::{Maps, Show};

/// Key of the panel.
pub const KEY: &str = "stiffness_map";

/// The Stiffness map panel.
#[derive(Default)]
pub struct StiffnessMapPanel {
    state: Option<Box<State>>,
}

/// What it holds while it is open.
pub struct State {
    editing: Editing<Doc>,
    canvas: Canvas,
    field: Field<Maps>,
    show: Show,
    brush: Brush,
    section: Section,
    comparison: Comparison,
    /// Whether the comparison is open.
    comparing: bool,
    files: Files,
    /// The chosen stroke.
    stroke: Option<usize>,
    /// The key that the table was last brought to.
    scrolled_to: Option<usize>,
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
            brush: Brush::default(),
            section: Section::default(),
            comparison: Comparison::default(),
            comparing: false,
            files: Files::default(),
            stroke: None,
            scrolled_to: None,
            placed: false,
        }
    }
}

impl Panel for StiffnessMapPanel {
    fn key(&self) -> &'static str {
        KEY
    }

    fn title(&self) -> &'static str {
        "Stiffness map"
    }

    fn tooltip(&self) -> &'static str {
        "How stiff the skin is over the whole back: place and type measured values, choose a fit, paint with a brush"
    }

    fn home(&self) -> Home {
        Home::Main
    }

    fn opens_at_first(&self) -> bool {
        false
    }

    fn release(&mut self, view: &View) {
        if self.state.take().is_some() {
            view.parts.remove(Item::StiffnessEditor);
        }
    }

    fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        let Some(scene) = &cx.view.scene else {
            let next = if cx.view.build.is_some() {
                "The scene is being built; its map comes next"
            } else {
                "Open a scene: its map is laid over the outline of its skin"
            };
            empty_ui(ui, icon::ICON_GRADIENT, "No map yet", next);
            return;
        };
        let wake = wake(ui.ctx());
        let state = self
            .state
            .get_or_insert_with(|| Box::new(State::new(&scene.scenario)));
        if state.editing.follow(cx) {
            state.field.clear();
            state.stroke = None;
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
        frame::bar(ui, parts.bar, |ui| side::bar(ui, state, editable));
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
        cx.view.parts.report(Item::StiffnessEditor, cost);
    }
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
    let painting = state.brush.on && editable;
    let name = "Stiffness map. Arrow keys move it, plus and minus zoom, Tab goes to the keys";
    let handled = state.canvas.place(ui, rect, name, !painting);
    if painting {
        keys::paint(ui, &handled, &state.brush, &mut state.editing);
    } else if editable
        && handled.response.double_clicked()
        && let Some(at) = handled.cursor_mm
    {
        side::add(state, at);
    } else if handled.response.clicked() {
        state.editing.selected = None;
    }
    let spec = show::spec(state.editing.doc(), state.editing.state(), &state.show);
    let area = state.canvas.visible(rect);
    state.field.follow(&spec, area, wake);
    let picture = state.field.picture().cloned();
    let scale = picture
        .as_ref()
        .map(|p| show::scale(state.editing.doc(), p));
    let painter = ui.painter().with_clip_rect(rect);
    let look = Look {
        colour: state.show.colour,
        lines: state.show.lines,
        veiled: state.show.veiled,
        outline: state.show.outline,
    };
    let made = state.field.made();
    let field = picture
        .as_ref()
        .zip(scale)
        .map(|(p, s)| (p.as_ref(), made, s));
    state.canvas.paint(&painter, rect, theme, field, look);
    let lay = state.canvas.lay(rect);
    let inks = state.canvas.inks(theme, field, look);
    state.section.on_canvas(ui, lay, theme);
    if state.show.keys {
        let reachable = editable && !painting;
        ui.add_enabled_ui(!painting, |ui| {
            keys::show(ui, lay, theme, &inks, scale, &mut state.editing, reachable);
        });
    }
    let brush = painting.then_some((&state.brush, &handled));
    let doc = state.editing.doc();
    keys::strokes(ui, lay, theme, doc, state.stroke, brush);
    let told = side::told(picture.as_deref(), doc, handled.cursor_mm);
    state.canvas.paint_front(&painter, rect, theme, &told);
    if let Some(scale) = scale.filter(|_| state.show.colour) {
        let legend = scale::Legend {
            title: "Stiffness, N/mm",
            scale,
            decimals: 2,
            note: None,
        };
        let place = rect.shrink2(egui::vec2(8.0, 24.0));
        scale::legend(&painter, place, theme, &legend);
    }
    frame::view_buttons(ui, rect, &mut state.canvas);
}
