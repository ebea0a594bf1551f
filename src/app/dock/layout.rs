//! Which panel is where, what is closed, what has a window of its own.

use super::behavior::Behavior;
use super::{Home, PanelSlot};
use crate::app::command::CommandSender;
use crate::app::roles::Role;
use crate::app::widgets::empty_ui;
use egui_material_icons::icons as icon;
use egui_tiles::{Container, Linear, LinearDir, Tile, TileId, Tiles, Tree};
use std::collections::BTreeSet;

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

impl Layout {
    /// The workspace that is ready for `role`.
    pub fn of(role: Role, panels: &[PanelSlot]) -> Self {
        let mut tiles = Tiles::default();
        let mut at_home = |home: Home| -> Option<TileId> {
            let mut here: Vec<&PanelSlot> = (panels.iter())
                .filter(|p| role.place(p).home == home)
                .collect();
            here.sort_by_key(|p| role.rank(p));
            let ids: Vec<TileId> = (here.iter())
                .map(|p| tiles.insert_pane(p.key.to_owned()))
                .collect();
            let first = *ids.first()?;
            let id = tiles.insert_tab_tile(ids);
            if let Some(Tile::Container(Container::Tabs(tabs))) = tiles.get_mut(id) {
                tabs.set_active(first);
            }
            Some(id)
        };
        let [main, top, bottom] = [Home::Main, Home::RightTop, Home::RightBottom].map(&mut at_home);
        let shares = role.shares();
        let right = divided(&mut tiles, LinearDir::Vertical, [top, bottom], shares.top);
        let root = divided(
            &mut tiles,
            LinearDir::Horizontal,
            [main, right],
            shares.main,
        );
        let tree = match root {
            Some(root) => Tree::new(egui::Id::unique("dock"), root, tiles),
            None => Tree::empty(egui::Id::unique("dock")),
        };
        let mut layout = Self {
            format: FORMAT,
            tree,
            closed: BTreeSet::new(),
            popped: BTreeSet::new(),
        };
        for panel in panels.iter().filter(|p| !role.place(p).open) {
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
            empty_ui(
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

/// Two places beside each other, the first with its share; one by itself where the other has no panel.
fn divided(
    tiles: &mut Tiles<String>,
    direction: LinearDir,
    places: [Option<TileId>; 2],
    first_share: f32,
) -> Option<TileId> {
    match places {
        [Some(first), Some(second)] => {
            let pair = Linear::new_binary(direction, [first, second], first_share);
            Some(tiles.insert_container(pair))
        }
        [first, second] => first.or(second),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::dock::{Panels, slots};

    fn panels() -> Panels {
        slots(crate::app::panels::all())
    }

    #[test]
    fn the_first_layout_has_every_panel_once_and_those_open_that_cost_nothing() {
        let panels = panels();
        let layout = Layout::of(Role::Researcher, &panels);
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
                crate::app::panels::exercise::KEY,
                crate::app::panels::scenario_editor::KEY,
                crate::app::panels::library::KEY,
                crate::app::panels::sessions::KEY,
                crate::app::panels::compare::KEY,
                crate::app::panels::devices::KEY,
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
    fn a_trainee_has_the_back_and_the_exercise_and_an_instructor_what_makes_and_watches_it() {
        use crate::app::panels::{BACK_VIEW_KEY, PLOTS_KEY, exercise, library, scenario_editor};
        let panels = panels();
        let open = |role: Role| {
            let layout = Layout::of(role, &panels);
            assert!(layout.fits(&panels));
            let open = panels.iter().filter(|p| !layout.is_closed(p.key));
            let shown = panels.iter().filter(|p| layout.is_shown(p.key));
            let keys = |of: Vec<&PanelSlot>| {
                let mut keys: Vec<_> = of.iter().map(|p| p.key).collect();
                keys.sort_unstable();
                keys
            };
            (keys(open.collect()), keys(shown.collect()))
        };
        let (trainee, shown) = open(Role::Trainee);
        assert_eq!(trainee, [BACK_VIEW_KEY, exercise::KEY]);
        assert_eq!(shown, trainee);
        let (instructor, shown) = open(Role::Instructor);
        assert_eq!(shown, [BACK_VIEW_KEY, exercise::KEY, PLOTS_KEY]);
        for key in [scenario_editor::KEY, library::KEY] {
            assert!(instructor.contains(&key), "{key}");
        }
    }

    #[test]
    fn a_layout_survives_storage_with_its_closed_and_popped_panels() {
        let panels = panels();
        let mut layout = Layout::of(Role::Researcher, &panels);
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
        let mut layout = Layout::of(Role::Researcher, &panels);
        assert!(!layout.fits(&panels[1..]));
        layout.format = 0;
        assert!(!layout.fits(&panels));
    }

    #[test]
    fn a_panel_pops_out_and_comes_back_to_the_front() {
        let panels = panels();
        let mut layout = Layout::of(Role::Researcher, &panels);
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
        let mut layout = Layout::of(Role::Researcher, &panels);
        layout.pop_out("scene");
        layout.close("scene");
        assert_eq!(layout.popped().count(), 0);
        layout.show("scene");
        assert!(!layout.is_popped("scene") && layout.is_shown("scene"));
    }
}
