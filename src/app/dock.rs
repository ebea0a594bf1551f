//! Where the panels are: a tree of tabs and splits, the closed ones, the ones in windows of their own.
//!
//! Every panel is always in the tree; closed and popped-out ones are hidden there, so that they come back where they were.

use super::command::{Command, CommandSender};
use super::panels::Panel;
use super::widgets::icon_button;
use egui_material_icons::icons as icon;
use egui_tiles::{Container, Linear, LinearDir, Tile, TileId, Tiles, Tree};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};

/// Where a panel belongs at first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Home {
    /// The left two thirds.
    Main,
    /// The right column, above.
    RightTop,
    /// The right column, below.
    RightBottom,
}

/// A listed panel.
pub struct PanelSlot {
    /// Its key.
    pub key: &'static str,
    /// Its title.
    pub title: &'static str,
    /// Why one would open it.
    pub tooltip: &'static str,
    /// Where it belongs.
    pub home: Home,
    /// Whether it is open at the first launch.
    pub opens_at_first: bool,
    /// The panel itself. Locked only while it is drawn.
    pub panel: Mutex<Box<dyn Panel>>,
}

/// The listed panels, shared with their own windows.
pub type Panels = Arc<[PanelSlot]>;

/// Puts panels into slots.
pub fn slots(panels: Vec<Box<dyn Panel>>) -> Panels {
    panels
        .into_iter()
        .map(|panel| PanelSlot {
            key: panel.key(),
            title: panel.title(),
            tooltip: panel.tooltip(),
            home: panel.home(),
            opens_at_first: panel.opens_at_first(),
            panel: Mutex::new(panel),
        })
        .collect()
}

/// The arrangement; stored between runs.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Layout {
    /// 1. Another version is not read.
    format: u32,
    tree: Tree<String>,
    closed: BTreeSet<String>,
    popped: BTreeSet<String>,
}

const FORMAT: u32 = 1;
/// Share of the width that the main place gets at first.
const MAIN_SHARE: f32 = 2.0 / 3.0;
/// Share of the right column's height that its upper half gets at first.
const TOP_SHARE: f32 = 0.62;

impl Layout {
    /// The arrangement of a first launch.
    pub fn first(panels: &[PanelSlot]) -> Self {
        let mut tiles = Tiles::default();
        let mut at_home = |home: Home| {
            let ids: Vec<TileId> = panels
                .iter()
                .filter(|p| p.home == home)
                .map(|p| tiles.insert_pane(p.key.to_owned()))
                .collect();
            let first = ids.first().copied();
            let id = tiles.insert_tab_tile(ids);
            if let (Some(first), Some(Tile::Container(Container::Tabs(tabs)))) =
                (first, tiles.get_mut(id))
            {
                tabs.set_active(first);
            }
            id
        };
        let (main, top, bottom) = (
            at_home(Home::Main),
            at_home(Home::RightTop),
            at_home(Home::RightBottom),
        );
        let right = tiles.insert_container(Linear::new_binary(
            LinearDir::Vertical,
            [top, bottom],
            TOP_SHARE,
        ));
        let root = tiles.insert_container(Linear::new_binary(
            LinearDir::Horizontal,
            [main, right],
            MAIN_SHARE,
        ));
        let mut layout = Self {
            format: FORMAT,
            tree: Tree::new(egui::Id::unique("dock"), root, tiles),
            closed: BTreeSet::new(),
            popped: BTreeSet::new(),
        };
        for panel in panels.iter().filter(|p| !p.opens_at_first) {
            layout.close(panel.key);
        }
        layout
    }

    /// Whether this stored arrangement fits the panels there are: each exactly once.
    pub fn fits(&self, panels: &[PanelSlot]) -> bool {
        let mut stored: Vec<&str> = self
            .tree
            .tiles
            .tiles()
            .filter_map(|tile| match tile {
                Tile::Pane(key) => Some(key.as_str()),
                Tile::Container(_) => None,
            })
            .collect();
        let mut known: Vec<&str> = panels.iter().map(|p| p.key).collect();
        stored.sort_unstable();
        known.sort_unstable();
        self.format == FORMAT && self.tree.root().is_some() && stored == known
    }

    /// Whether a panel is closed.
    pub fn is_closed(&self, key: &str) -> bool {
        self.closed.contains(key)
    }

    /// Whether a panel has a window of its own.
    pub fn is_popped(&self, key: &str) -> bool {
        self.popped.contains(key)
    }

    /// The panels with windows of their own.
    pub fn popped(&self) -> impl Iterator<Item = &str> {
        self.popped.iter().map(String::as_str)
    }

    /// Whether a panel is on screen: not closed, and the front tab or in its own window.
    pub fn is_shown(&self, key: &str) -> bool {
        if self.is_closed(key) {
            return false;
        }
        self.is_popped(key)
            || self
                .tile(key)
                .is_some_and(|id| self.tree.active_tiles().contains(&id))
    }

    /// Opens a panel where it was and brings it to the front.
    pub fn show(&mut self, key: &str) {
        self.closed.remove(key);
        self.sync(key);
        if let Some(id) = self.tile(key) {
            self.tree.make_active(|tile, _| tile == id);
        }
    }

    /// Closes a panel, also one with a window of its own.
    pub fn close(&mut self, key: &str) {
        self.popped.remove(key);
        self.closed.insert(key.to_owned());
        self.sync(key);
    }

    /// Gives a panel a window of its own.
    pub fn pop_out(&mut self, key: &str) {
        self.closed.remove(key);
        self.popped.insert(key.to_owned());
        self.sync(key);
    }

    /// Brings a panel back from its own window, to the front.
    pub fn dock_back(&mut self, key: &str) {
        self.popped.remove(key);
        self.show(key);
    }

    fn tile(&self, key: &str) -> Option<TileId> {
        self.tree.tiles.find_pane(&key.to_owned())
    }

    fn sync(&mut self, key: &str) {
        if let Some(id) = self.tile(key) {
            let visible = !self.is_closed(key) && !self.is_popped(key);
            self.tree.set_visible(id, visible);
        }
    }

    /// Draws the docked panels; `draw` draws one by key.
    pub fn ui(
        &mut self,
        ui: &mut egui::Ui,
        panels: &[PanelSlot],
        send: &CommandSender,
        draw: &mut dyn FnMut(&mut egui::Ui, &PanelSlot),
    ) {
        if panels
            .iter()
            .all(|p| self.is_closed(p.key) || self.is_popped(p.key))
        {
            super::widgets::empty_ui(
                ui,
                icon::ICON_DASHBOARD,
                "No panel is docked here",
                "Open one from the Panels menu",
            );
            return;
        }
        let mut behavior = Behavior { panels, send, draw };
        self.tree.ui(&mut behavior, ui);
    }
}

struct Behavior<'a> {
    panels: &'a [PanelSlot],
    send: &'a CommandSender,
    draw: &'a mut dyn FnMut(&mut egui::Ui, &PanelSlot),
}

impl Behavior<'_> {
    fn slot(&self, key: &str) -> Option<&PanelSlot> {
        self.panels.iter().find(|p| p.key == key)
    }
}

impl egui_tiles::Behavior<String> for Behavior<'_> {
    fn pane_ui(
        &mut self,
        ui: &mut egui::Ui,
        _tile: TileId,
        key: &mut String,
    ) -> egui_tiles::UiResponse {
        if let Some(slot) = self.panels.iter().find(|p| p.key == key) {
            egui::Frame::new()
                .fill(ui.visuals().panel_fill)
                .inner_margin(margin(slot))
                .show(ui, |ui| {
                    ui.expand_to_include_rect(ui.max_rect());
                    (self.draw)(ui, slot);
                });
        }
        egui_tiles::UiResponse::None
    }

    fn tab_title_for_pane(&mut self, key: &String) -> egui::WidgetText {
        self.slot(key).map_or("", |p| p.title).into()
    }

    fn tab_hover_cursor_icon(&self) -> egui::CursorIcon {
        egui::CursorIcon::Default
    }

    fn on_tab_button(
        &mut self,
        tiles: &mut Tiles<String>,
        tile: TileId,
        button: egui::Response,
    ) -> egui::Response {
        let tooltip = tiles
            .get_pane(&tile)
            .and_then(|key| self.slot(key))
            .map_or("", |p| p.tooltip);
        button.on_hover_text(tooltip)
    }

    fn top_bar_right_ui(
        &mut self,
        tiles: &Tiles<String>,
        ui: &mut egui::Ui,
        _tile: TileId,
        tabs: &egui_tiles::Tabs,
        _scroll: &mut f32,
    ) {
        let Some(slot) = tabs
            .active
            .and_then(|id| tiles.get_pane(&id))
            .and_then(|key| self.slot(key))
        else {
            return;
        };
        ui.spacing_mut().item_spacing.x = 2.0;
        ui.add_space(4.0);
        let name = format!("Close {}", slot.title);
        let tooltip = "Close this panel; the Panels menu opens it again";
        if icon_button(ui, icon::ICON_CLOSE, &name, tooltip).clicked() {
            self.send.send(Command::ClosePanel(slot.key));
        }
        let name = format!("Pop out {}", slot.title);
        let tooltip = "Give this panel a window of its own, for a second screen";
        if icon_button(ui, icon::ICON_OPEN_IN_NEW, &name, tooltip).clicked() {
            self.send.send(Command::PopOut(slot.key));
        }
    }

    fn tab_bar_height(&self, _style: &egui::Style) -> f32 {
        28.0
    }

    fn gap_width(&self, _style: &egui::Style) -> f32 {
        4.0
    }

    fn min_size(&self) -> f32 {
        120.0
    }

    fn tab_bar_color(&self, visuals: &egui::Visuals) -> egui::Color32 {
        super::theme::Theme::of(visuals.dark_mode).background
    }

    fn resize_stroke(&self, style: &egui::Style, state: egui_tiles::ResizeState) -> egui::Stroke {
        let theme = super::theme::Theme::of(style.visuals.dark_mode);
        let colour = match state {
            egui_tiles::ResizeState::Idle => theme.background,
            egui_tiles::ResizeState::Hovering => theme.line,
            egui_tiles::ResizeState::Dragging => theme.accent,
        };
        egui::Stroke::new(self.gap_width(style), colour)
    }

    fn tab_outline_stroke(
        &self,
        _visuals: &egui::Visuals,
        _tiles: &Tiles<String>,
        _tile: TileId,
        _state: &egui_tiles::TabState,
    ) -> egui::Stroke {
        egui::Stroke::NONE
    }

    fn tab_bar_hline_stroke(&self, _visuals: &egui::Visuals) -> egui::Stroke {
        egui::Stroke::NONE
    }

    fn tab_text_color(
        &self,
        visuals: &egui::Visuals,
        _tiles: &Tiles<String>,
        _tile: TileId,
        state: &egui_tiles::TabState,
    ) -> egui::Color32 {
        let theme = super::theme::Theme::of(visuals.dark_mode);
        if state.active {
            theme.text
        } else {
            theme.weak_text
        }
    }

    fn simplification_options(&self) -> egui_tiles::SimplificationOptions {
        egui_tiles::SimplificationOptions {
            all_panes_must_have_tabs: true,
            ..egui_tiles::SimplificationOptions::default()
        }
    }
}

/// Room around a panel: none for the one that fills its place with a picture.
pub fn margin(slot: &PanelSlot) -> egui::Margin {
    match slot.home {
        Home::Main => egui::Margin::ZERO,
        Home::RightTop | Home::RightBottom => egui::Margin::same(8),
    }
}

/// Draws a panel, whichever window it is in.
pub fn draw(ui: &mut egui::Ui, slot: &PanelSlot, cx: &super::panels::PanelContext<'_>) {
    let mut panel = slot.panel.lock().unwrap_or_else(PoisonError::into_inner);
    ui.push_id(slot.key, |ui| panel.ui(ui, cx));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panels() -> Panels {
        slots(crate::app::panels::all())
    }

    #[test]
    fn the_first_layout_has_every_panel_once_and_those_open_that_cost_nothing() {
        let panels = panels();
        let layout = Layout::first(&panels);
        assert!(layout.fits(&panels));
        let closed = panels.iter().filter(|p| layout.is_closed(p.key));
        let closed: Vec<_> = closed.map(|p| p.key).collect();
        assert_eq!(
            closed,
            [
                crate::app::panels::partition::KEY,
                crate::app::panels::ellipse_map::KEY,
                crate::app::panels::stiffness_map::KEY,
                crate::app::panels::lab::KEY,
                crate::app::panels::scenario_editor::KEY,
                crate::app::panels::library::KEY,
            ]
        );
        let mut main = panels.iter().filter(|p| p.home == Home::Main);
        let open: Vec<_> = main.by_ref().filter(|p| p.opens_at_first).collect();
        assert_eq!(open.len(), 1, "one panel takes the left two thirds");
        assert_eq!(open[0].key, crate::app::panels::BACK_VIEW_KEY);
        assert!(
            panels
                .iter()
                .any(|p| p.key == crate::app::panels::PLOTS_KEY)
        );
    }

    #[test]
    fn a_layout_survives_storage_with_its_closed_and_popped_panels() {
        let panels = panels();
        let mut layout = Layout::first(&panels);
        layout.pop_out("plots");
        layout.close("timing");
        let text = serde_json::to_string(&layout).expect("serializes");
        let back: Layout = serde_json::from_str(&text).expect("reads");
        assert!(back.fits(&panels));
        assert!(back.is_popped("plots") && back.is_closed("timing"));
        assert_eq!(back.popped().collect::<Vec<_>>(), ["plots"]);
    }

    #[test]
    fn a_stored_layout_of_other_panels_is_not_used() {
        let panels = panels();
        let mut layout = Layout::first(&panels);
        assert!(!layout.fits(&panels[1..]));
        layout.format = 0;
        assert!(!layout.fits(&panels));
    }

    #[test]
    fn a_panel_pops_out_and_comes_back_to_the_front() {
        let panels = panels();
        let mut layout = Layout::first(&panels);
        layout.pop_out("recorder");
        assert!(layout.is_popped("recorder") && layout.is_shown("recorder"));
        layout.dock_back("recorder");
        assert!(!layout.is_popped("recorder") && layout.is_shown("recorder"));
        layout.close("recorder");
        assert!(!layout.is_shown("recorder"));
        layout.show("recorder");
        assert!(layout.is_shown("recorder"));
    }

    #[test]
    fn closing_a_popped_panel_leaves_no_window() {
        let panels = panels();
        let mut layout = Layout::first(&panels);
        layout.pop_out("scene");
        layout.close("scene");
        assert_eq!(layout.popped().count(), 0);
        layout.show("scene");
        assert!(!layout.is_popped("scene") && layout.is_shown("scene"));
    }
}
