//! A map under the hands: its value with undo, the key that is chosen, what is wrong, and the way to the scene.

use super::cells::Edit;
use super::handles::Gripped;
use super::sync::{Seen, Sync};
use super::undo::History;
use crate::app::panels::PanelContext;
use crate::app::theme::Theme;
use crate::app::widgets::icon_button;
use crate::geom::Vec2;
use crate::scenario::Scenario;
use egui::{Key, Modifiers};
use egui_material_icons::icons as icon;
use std::time::Instant;

/// What an editor edits: one map of a scenario.
pub trait Document: Clone + PartialEq {
    /// The map of a scenario.
    fn of(scenario: &Scenario) -> Self;
    /// The scenario's source with this map in place of its own.
    ///
    /// # Errors
    /// What the scenario says of it, in one line.
    fn write(&self, source: &str) -> Result<String, String>;
    /// What is wrong with it, in one line.
    ///
    /// # Errors
    /// The first thing that is not allowed.
    fn check(&self) -> Result<(), String>;
    /// How many keys it has.
    fn keys(&self) -> usize;
}

/// A document being edited.
pub struct Editing<D> {
    history: History<D>,
    sync: Sync,
    /// The key that is chosen.
    pub selected: Option<usize>,
    /// Nothing can be changed, as while a recording is on show.
    pub locked: bool,
    state: u64,
    fault: Option<String>,
    /// What was wrong with the last thing typed.
    pub told: Option<String>,
    last: D,
}

impl<D: Document> Editing<D> {
    /// The map of `scenario`, without a past.
    pub fn new(scenario: &Scenario) -> Self {
        let doc = D::of(scenario);
        Self {
            history: History::new(doc.clone()),
            sync: Sync::default(),
            selected: None,
            locked: false,
            state: 0,
            fault: None,
            told: None,
            last: doc,
        }
    }

    /// The map as it is.
    pub fn doc(&self) -> &D {
        self.history.now()
    }

    /// Another number for each state of the map.
    pub fn state(&self) -> u64 {
        self.state
    }

    /// What is wrong with the map; it does not reach the scene then.
    pub fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }

    /// Holds the map back from the scene as it is now, because of `fault`.
    pub fn refuse(&mut self, fault: String) {
        self.fault = Some(fault);
        self.sync.drop_wish();
    }

    /// Whether a drag is under way.
    pub fn is_held(&self) -> bool {
        self.history.is_held()
    }

    /// Does `what` in one step.
    pub fn set(&mut self, what: &'static str, doc: D) {
        if self.locked {
            return;
        }
        self.history.set(what, doc);
        self.told = None;
        self.changed(true);
    }

    /// A drag that does `what` begins.
    pub fn hold(&mut self, what: &'static str) {
        self.history.hold(what);
    }

    /// The drag ends.
    pub fn release(&mut self) {
        self.history.release();
        self.changed(true);
    }

    /// Takes the last step back.
    pub fn undo(&mut self) {
        if !self.locked && self.history.undo() {
            self.told = None;
            self.changed(true);
        }
    }

    /// Takes the undone step again.
    pub fn redo(&mut self) {
        if !self.locked && self.history.redo() {
            self.told = None;
            self.changed(true);
        }
    }

    /// Takes what a hand did to a number: `change` is the document with the new value.
    pub fn take(&mut self, edit: Edit, what: &'static str, change: impl FnOnce(&D, f64) -> D) {
        if edit.started {
            self.hold(what);
        }
        if let Some(value) = edit.value {
            let doc = change(self.doc(), value);
            self.set(what, doc);
        }
        if edit.told.is_some() {
            self.told = edit.told;
        }
        if edit.ended {
            self.release();
        }
    }

    /// Takes what a hand did to a handle at `at_mm`: `change` is the document with it at another place.
    pub fn grip(
        &mut self,
        gripped: &Gripped,
        at_mm: Vec2,
        what: &'static str,
        change: impl FnOnce(&D, Vec2) -> D,
    ) {
        if gripped.started {
            self.hold(what);
        }
        if let Some(to) = gripped.to_mm.or(gripped.push_mm.map(|push| at_mm + push)) {
            let doc = change(self.doc(), to);
            self.set(what, doc);
        }
        if gripped.ended {
            self.release();
        }
    }

    fn changed(&mut self, by_hand: bool) {
        if *self.history.now() == self.last {
            return;
        }
        self.last = self.history.now().clone();
        self.state += 1;
        let keys = self.last.keys();
        self.selected = self.selected.filter(|&i| i < keys);
        self.fault = self.last.check().err();
        if by_hand && self.fault.is_none() {
            self.sync.want();
        } else {
            self.sync.drop_wish();
        }
    }

    /// Follows the scene on show; true when it is another one.
    pub fn follow(&mut self, cx: &PanelContext<'_>) -> bool {
        let Some(scene) = &cx.view.scene else {
            return false;
        };
        match self.sync.look(scene, cx.view.scene_generation) {
            Seen::Same => false,
            Seen::Edited => {
                // What waits to be sent is newer than what came.
                let doc = D::of(&scene.scenario);
                if !self.sync.is_waiting() && !self.is_held() && doc != *self.doc() {
                    self.history.set("Change made elsewhere", doc);
                    self.changed(false);
                }
                false
            }
            Seen::Another => {
                let state = self.state + 1;
                let sync = std::mem::take(&mut self.sync);
                *self = Self {
                    state,
                    sync,
                    ..Self::new(&scene.scenario)
                };
                true
            }
        }
    }

    /// Sends the newest state to the scene when it is time.
    pub fn send(&mut self, ctx: &egui::Context, cx: &PanelContext<'_>) {
        let doc = self.history.now();
        let sent = self
            .sync
            .send(ctx, cx, Instant::now(), |source| doc.write(source));
        if let Err(fault) = sent {
            self.fault = Some(fault);
        }
    }

    /// Undo and redo by key, where the panel in `rect` has the hand or the focus and no text is typed.
    pub fn keys(&mut self, ui: &egui::Ui, rect: egui::Rect) {
        let ctx = ui.ctx();
        let focus = ctx.memory(|m| m.focused());
        let focused_here = focus
            .and_then(|id| ctx.read_response(id))
            .is_some_and(|r| rect.contains(r.rect.center()));
        if !focused_here && !ui.rect_contains_pointer(rect) || ctx.text_edit_focused() {
            return;
        }
        let shift = Modifiers::COMMAND | Modifiers::SHIFT;
        let pressed = |modifiers, key| ctx.input_mut(|i| i.consume_key(modifiers, key));
        // The longer chord first: the shorter one would take it.
        if pressed(shift, Key::Z) || pressed(Modifiers::COMMAND, Key::Y) {
            self.redo();
        } else if pressed(Modifiers::COMMAND, Key::Z) {
            self.undo();
        }
    }

    /// Buttons to undo and to redo.
    pub fn buttons(&mut self, ui: &mut egui::Ui) {
        let undoes = self.history.undoes();
        let tooltip = match undoes {
            Some(what) => format!("Undo: {what} (Ctrl+Z)"),
            None => "Nothing to undo (Ctrl+Z)".into(),
        };
        ui.add_enabled_ui(undoes.is_some(), |ui| {
            if icon_button(ui, icon::ICON_UNDO, "Undo", &tooltip).clicked() {
                self.undo();
            }
        });
        let redoes = self.history.redoes();
        let tooltip = match redoes {
            Some(what) => format!("Redo: {what} (Ctrl+Shift+Z)"),
            None => "Nothing to redo (Ctrl+Shift+Z)".into(),
        };
        ui.add_enabled_ui(redoes.is_some(), |ui| {
            if icon_button(ui, icon::ICON_REDO, "Redo", &tooltip).clicked() {
                self.redo();
            }
        });
    }

    /// What is wrong, in a place of steady height.
    pub fn fault_ui(&self, ui: &mut egui::Ui, theme: &Theme) {
        let (text, colour) = match (&self.fault, &self.told) {
            (Some(fault), _) => (fault.as_str(), theme.fault),
            (None, Some(told)) => (told.as_str(), theme.warning),
            (None, None) => ("", theme.weak_text),
        };
        let height = ui.text_style_height(&egui::TextStyle::Body);
        ui.allocate_ui(egui::vec2(ui.available_width(), height), |ui| {
            ui.set_min_height(height);
            if !text.is_empty() {
                ui.add(egui::Label::new(egui::RichText::new(text).color(colour)).wrap());
            }
        });
    }
}
