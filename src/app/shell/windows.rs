//! Panels in native windows of their own.

use super::Shared;
use super::menu;
use crate::app::command::Command;
use crate::app::dock::{self, Layout, PanelSlot};
use crate::app::widgets::named;
use egui_material_icons::icons as icon;
use std::sync::Arc;

/// The window of a popped-out panel.
pub fn viewport_id(key: &str) -> egui::ViewportId {
    egui::ViewportId::from_hash_of(("panel", key))
}

/// Keeps the windows of popped-out panels open. Each draws by itself, at its own time.
pub fn show(ctx: &egui::Context, shared: &Arc<Shared>, layout: &Layout) {
    for (i, slot) in shared.panels.iter().enumerate() {
        if !layout.is_popped(slot.key) {
            continue;
        }
        let builder = egui::ViewportBuilder::default()
            .with_title(format!("Dorsum — {}", slot.title))
            .with_app_id("dorsum")
            .with_inner_size([720.0, 520.0])
            .with_min_inner_size([280.0, 200.0]);
        let shared = shared.clone();
        ctx.show_viewport_deferred(viewport_id(slot.key), builder, move |ui, class| {
            let slot = &shared.panels[i];
            if ui.input(|input| input.viewport().close_requested()) {
                shared.send.send(Command::DockBack(slot.key));
            }
            window_ui(ui, &shared, slot, class);
        });
    }
}

fn window_ui(ui: &mut egui::Ui, shared: &Shared, slot: &PanelSlot, class: egui::ViewportClass) {
    let view = shared.view();
    let theme = view.theme;
    if class != egui::ViewportClass::EmbeddedWindow {
        menu::keys(ui.ctx(), shared, view.playback.is_some());
    }
    egui::Panel::top(egui::Id::unique(("dock back", slot.key)))
        .frame(
            egui::Frame::new()
                .fill(theme.background)
                .inner_margin(egui::Margin::symmetric(8, 4)),
        )
        .show(ui, |ui| {
            ui.horizontal(|ui| {
                let button = ui
                    .button((icon::ICON_DOCK_TO_RIGHT.rich_text(), "Dock back"))
                    .on_hover_text("Put this panel back where it was in the main window");
                named(ui, &button, &format!("Dock back {}", slot.title));
                if button.clicked() {
                    shared.send.send(Command::DockBack(slot.key));
                }
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    menu::force_ui(ui, shared, view.force_enabled);
                });
            });
        });
    egui::CentralPanel::no_frame().show(ui, |ui| {
        egui::Frame::new()
            .fill(theme.panel)
            .inner_margin(dock::margin(slot))
            .show(ui, |ui| {
                ui.expand_to_include_rect(ui.max_rect());
                shared.draw(ui, slot, &view);
            });
    });
}
