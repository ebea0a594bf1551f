//! The trainee's own window: the back and the exercise, full screen on the second screen where there is one.
//!
//! Its panels are others than those of the main window, so that each shows what its reader may see.

use super::{Shared, menu};
use crate::app::command::Command;
use crate::app::dock;
use crate::app::panels::BACK_VIEW_KEY;
use crate::app::roles::Role;
use crate::app::state::View;
use std::sync::Arc;

/// The screen it takes, counted as the system lists them. With one screen only it is a window there.
const SCREEN: usize = 1;

/// Share of the width that the exercise takes, and its bounds, points.
const SIDE_SHARE: f32 = 0.3;
const SIDE: std::ops::RangeInclusive<f32> = 300.0..=460.0;

/// The window.
pub fn viewport_id() -> egui::ViewportId {
    egui::ViewportId::from_hash_of("trainee")
}

/// Keeps the window open while it is wanted.
pub fn show(ctx: &egui::Context, shared: &Arc<Shared>, view: &View) {
    if !view.trainee_window {
        return;
    }
    let builder = egui::ViewportBuilder::default()
        .with_title("Dorsum — trainee")
        .with_app_id("dorsum")
        .with_inner_size([1100.0, 760.0])
        .with_min_inner_size([640.0, 420.0])
        .with_monitor(SCREEN);
    let shared = shared.clone();
    ctx.show_viewport_deferred(viewport_id(), builder, move |ui, class| {
        if ui.input(|input| input.viewport().close_requested()) {
            shared.send.send(Command::ShowTraineeWindow(false));
        }
        let view = shared.view_of(Role::Trainee);
        if class != egui::ViewportClass::EmbeddedWindow {
            menu::stop_key(ui.ctx(), &shared);
        }
        window_ui(ui, &shared, &view);
    });
}

fn window_ui(ui: &mut egui::Ui, shared: &Shared, view: &View) {
    let theme = view.theme;
    egui::Panel::top("trainee bar")
        .frame(
            egui::Frame::new()
                .fill(theme.panel)
                .inner_margin(egui::Margin::symmetric(8, 4)),
        )
        .show(ui, |ui| {
            ui.horizontal(|ui| {
                let name = view.scene.as_ref().map_or("", |s| &s.scenario.name);
                ui.strong(name);
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    menu::force_ui(ui, shared, view.force_enabled);
                });
            });
        });
    let width = (ui.available_width() * SIDE_SHARE).clamp(*SIDE.start(), *SIDE.end());
    for slot in shared.trainee.iter().filter(|s| s.key != BACK_VIEW_KEY) {
        egui::Panel::right(egui::Id::unique(("trainee", slot.key)))
            .exact_size(width)
            .resizable(false)
            .frame(
                egui::Frame::new()
                    .fill(theme.panel)
                    .inner_margin(dock::margin(slot)),
            )
            .show(ui, |ui| shared.draw(ui, slot, view));
    }
    egui::CentralPanel::no_frame().show(ui, |ui| {
        ui.painter()
            .rect_filled(ui.max_rect(), 0.0, theme.background);
        for slot in shared.trainee.iter().filter(|s| s.key == BACK_VIEW_KEY) {
            shared.draw(ui, slot, view);
        }
    });
}
