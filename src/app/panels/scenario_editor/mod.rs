//! The Scenario editor panel: dysfunctions placed on the labelled back, seen and cut through before they are felt.
//!
//! | file | answers |
//! |---|---|
//! | [`doc`] | what is written here and what can be done to it |
//! | [`snap`] | the sites that a click adds at |
//! | [`preview`] | what the dysfunctions make of the stiffness, as colour and along a line |
//! | `canvas` | the back under the hands |
//! | `add`, `list`, `form`, `place`, `strength` | a new one, all of them, and the chosen one in numbers |
//! | `draw` | some drawn at random |
//! | `exercise` | what is asked, hidden and scored |
//! | `text` | name, description, and what differs from the file |
//! | [`wording`] | numbers and changes in words |

mod add;
mod canvas;
pub mod doc;
mod draw;
mod exercise;
mod form;
mod list;
mod place;
pub mod preview;
pub mod snap;
mod strength;
mod text;
pub mod wording;

use super::{Panel, PanelContext};
use crate::app::dock::Home;
use crate::app::editor::canvas::Canvas;
use crate::app::editor::editing::Editing;
use crate::app::editor::field::Field;
use crate::app::editor::frame;
use crate::app::editor::parts::fold;
use crate::app::editor::section::Section;
use crate::app::panels::partition::wake;
use crate::app::state::{PartCost, View};
use crate::app::widgets::empty_ui;
use crate::scenario::{Item, Place, Scenario};
use doc::Doc;
use egui_material_icons::icons as icon;
use preview::{Ground, Maps, Show};
use std::sync::Arc;

/// Key of the panel.
pub const KEY: &str = "scenario_editor";

/// The Scenario editor panel.
#[derive(Default)]
pub struct ScenarioEditorPanel {
    state: Option<Box<State>>,
}

/// What it holds while it is open.
pub struct State {
    editing: Editing<Doc>,
    ground: Ground,
    canvas: Canvas,
    field: Field<Maps>,
    show: Show,
    section: Section,
    add: add::Add,
    draw: draw::Draw,
    /// The text of the place while it is typed: of which dysfunction, and what.
    typed: Option<(usize, String)>,
    diff: text::Diff,
    /// The exercise's candidates and constant strengths while they are typed.
    candidates: Option<String>,
    constants: Option<String>,
}

impl State {
    fn new(scenario: &Arc<Scenario>) -> Self {
        Self {
            editing: Editing::new(scenario),
            ground: Ground::new(scenario),
            canvas: Canvas::default(),
            field: Field::default(),
            show: Show::default(),
            section: Section {
                on: true,
                ..Section::default()
            },
            add: add::Add::default(),
            draw: draw::Draw::default(),
            typed: None,
            diff: text::Diff::default(),
            candidates: None,
            constants: None,
        }
    }

    /// Checks what was last done, before it is shown and sent.
    fn check(&mut self, scenario: &Arc<Scenario>) {
        let state = self.editing.state();
        if let Err(fault) = self.ground.follow(scenario, self.editing.doc(), state) {
            self.editing.refuse(fault);
        }
    }
}

/// What is chosen when a scene is opened.
fn first(doc: &Doc) -> Option<usize> {
    (!doc.list.is_empty()).then_some(0)
}

/// Adds one of the chosen kind and chooses it.
fn add(state: &mut State, place: Place) {
    let Some(kind) = state.add.kind() else {
        return;
    };
    let doc = state.editing.doc();
    let doc = doc.with_new(kind, place, state.add.severity);
    state.editing.set("Add dysfunction", doc);
    state.editing.selected = state.editing.doc().list.len().checked_sub(1);
}

fn remove(state: &mut State, index: usize) {
    let doc = state.editing.doc().without(index);
    let left = doc.list.len();
    state.editing.set("Remove dysfunction", doc);
    state.editing.selected = left.checked_sub(1).map(|last| last.min(index));
}

impl Panel for ScenarioEditorPanel {
    fn key(&self) -> &'static str {
        KEY
    }

    fn title(&self) -> &'static str {
        "Scenario editor"
    }

    fn tooltip(&self) -> &'static str {
        "Build a scenario: put dysfunctions on the labelled back, shape them, see what is felt, draw some at random"
    }

    fn home(&self) -> Home {
        Home::Main
    }

    fn opens_at_first(&self) -> bool {
        false
    }

    fn release(&mut self, view: &View) {
        if self.state.take().is_some() {
            view.parts.remove(Item::ScenarioEditor);
        }
    }

    fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        if cx.view.blind {
            self.release(cx.view);
            let next = "An exercise is under way: what it hides is shown after the answer";
            empty_ui(ui, icon::ICON_VISIBILITY_OFF, "Hidden for now", next);
            return;
        }
        let Some(scene) = &cx.view.scene else {
            let next = if cx.view.build.is_some() {
                "The scene is being built; its dysfunctions come next"
            } else {
                "Open a scene: its dysfunctions are laid over the outline of its skin"
            };
            empty_ui(ui, icon::ICON_EDIT_LOCATION, "No scenario yet", next);
            return;
        };
        let wake = wake(ui.ctx());
        let state = self
            .state
            .get_or_insert_with(|| Box::new(State::new(&scene.scenario)));
        if state.editing.follow(cx) {
            state.ground = Ground::new(&scene.scenario);
            state.editing.selected = first(state.editing.doc());
            state.field.clear();
            (state.typed, state.candidates, state.constants) = (None, None, None);
            state.diff.opened(&scene.scenario.source);
            state.canvas.fit(None);
        }
        state.canvas.follow(scene, &wake);
        let editable = cx.view.playback.is_none();
        state.editing.locked = !editable;
        let whole = ui.available_rect_before_wrap();
        state.editing.keys(ui, whole);
        let parts = frame::split(whole);
        frame::bar(ui, parts.bar, |ui| list::bar(ui, state, editable));
        state.check(&scene.scenario);
        canvas::show(ui, parts.canvas, cx, state, &wake, editable);
        state.check(&scene.scenario);
        frame::side(ui, parts.side, |ui| {
            if !editable {
                frame::locked(ui, &cx.view.theme);
            }
            side(ui, cx, state, editable);
        });
        state.check(&scene.scenario);
        ui.advance_cursor_after_rect(whole);
        state.editing.send(ui.ctx(), cx);
        let cost = PartCost {
            bytes: state.canvas.bytes() + state.field.bytes(),
            cost_us: None,
        };
        cx.view.parts.report(Item::ScenarioEditor, cost);
    }
}

/// Everything beside the canvas.
fn side(ui: &mut egui::Ui, cx: &PanelContext<'_>, state: &mut State, editable: bool) {
    let theme = &cx.view.theme;
    ui.spacing_mut().item_spacing.y = 4.0;
    state.editing.fault_ui(ui, theme);
    let empty = state.editing.doc().list.is_empty();
    fold(ui, "Add", empty, |ui| {
        ui.add_enabled_ui(editable, |ui| add::show(ui, cx, state));
    });
    fold(ui, "Dysfunctions", true, |ui| {
        list::show(ui, theme, state, editable);
    });
    if let Some(index) = state.editing.selected {
        let name = format!("Dysfunction {}", index + 1);
        fold(ui, &name, true, |ui| {
            ui.add_enabled_ui(editable, |ui| form::show(ui, cx, state, index));
        });
    }
    state.section.on = fold(ui, "Felt cross-section", state.section.on, |ui| {
        preview::section(ui, theme, state);
    });
    fold(ui, "Show", false, |ui| preview::shown(ui, &mut state.show));
    fold(ui, "Draw at random", false, |ui| {
        ui.add_enabled_ui(editable, |ui| draw::show(ui, cx, state));
    });
    fold(ui, "Exercise", false, |ui| {
        ui.add_enabled_ui(editable, |ui| exercise::show(ui, cx, state));
    });
    fold(ui, "Name and description", false, |ui| {
        ui.add_enabled_ui(editable, |ui| text::about(ui, state));
    });
    fold(ui, "Differences from the file", false, |ui| {
        text::differences(ui, cx, state);
    });
}
