//! The back, drawn.

use super::{Panel, PanelContext};

/// The Back view.
#[derive(Debug, Default)]
pub struct BackView {}

impl Panel for BackView {
    fn key(&self) -> &'static str {
        "back_view"
    }

    fn title(&self) -> &'static str {
        "Back view"
    }

    fn tooltip(&self) -> &'static str {
        "The back under the fingers, drawn as it deforms"
    }

    fn home(&self) -> crate::app::dock::Home {
        crate::app::dock::Home::Main
    }

    fn ui(&mut self, ui: &mut egui::Ui, _cx: &PanelContext<'_>) {
        ui.centered_and_justified(|ui| ui.label("Nothing to draw on yet"));
    }
}
