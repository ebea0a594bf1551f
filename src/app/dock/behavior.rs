//! How the dock looks and what its tabs do.

use super::{PanelSlot, margin};
use crate::app::command::{Command, CommandSender};
use crate::app::theme::Theme;
use crate::app::widgets::icon_button;
use egui_material_icons::icons as icon;
use egui_tiles::{TileId, Tiles};

pub(super) struct Behavior<'a> {
    pub panels: &'a [PanelSlot],
    pub send: &'a CommandSender,
    pub draw: &'a mut dyn FnMut(&mut egui::Ui, &PanelSlot),
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
        Theme::of(visuals.dark_mode).background
    }

    fn resize_stroke(&self, style: &egui::Style, state: egui_tiles::ResizeState) -> egui::Stroke {
        let theme = Theme::of(style.visuals.dark_mode);
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
        let theme = Theme::of(visuals.dark_mode);
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
