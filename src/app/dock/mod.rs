//! Where the panels are: a tree of tabs and splits, the closed ones, the ones in windows of their own.
//!
//! Every panel is always in the tree; closed and popped-out ones are hidden there, so that they come back where they were.

mod behavior;
mod layout;

pub use layout::Layout;

use super::panels::Panel;
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
