//! The panels: one file each, listed once.

pub mod back_view;
pub mod compare;
pub mod devices;
pub mod ellipse_map;
pub mod exercise;
mod folder;
pub mod lab;
mod legend;
pub mod library;
mod messages;
pub mod partition;
mod plots;
mod recorder;
pub mod scenario_editor;
mod scene;
pub mod sessions;
pub mod stiffness_map;
mod timing;

pub use plots::{FINGER_NAMES, KEY as PLOTS_KEY};
pub use recorder::KEY as RECORDER_KEY;
pub use timing::health as timing_health;

use super::command::CommandSender;
use super::dock::Home;
use super::state::View;

/// One panel of the workbench. It reads a [`View`], keeps its own display state and sends commands; it changes nothing
/// else.
pub trait Panel: Send {
    /// Stable name: stored in layouts, used by tests.
    fn key(&self) -> &'static str;
    /// Title of its tab, sentence case; also its name for a screen reader.
    fn title(&self) -> &'static str;
    /// Why one would open it.
    fn tooltip(&self) -> &'static str;
    /// Where it opens at first.
    fn home(&self) -> Home {
        Home::RightTop
    }
    /// Whether it is open at the first launch. One that costs memory or time while it is open is not.
    fn opens_at_first(&self) -> bool {
        true
    }
    /// Draws it into all of `ui`.
    fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>);
    /// What it chose to remember from one run to the next, as text.
    fn keep(&self) -> Option<String> {
        None
    }
    /// Takes back what [`Panel::keep`] gave in an earlier run. What it does not understand it leaves.
    fn recall(&mut self, _kept: &str) {}
    /// Frees what it holds only for being drawn. Called each frame while it is closed, with OpenGL current where there is
    /// one; does nothing when nothing is held.
    fn release(&mut self, _view: &View) {}
}

/// What a panel gets to see and to ask with.
#[derive(Clone, Copy)]
pub struct PanelContext<'a> {
    /// The state of the workbench at this frame.
    pub view: &'a View,
    /// Where its wishes go.
    pub send: &'a CommandSender,
}

/// Key of the panel that draws the back.
pub const BACK_VIEW_KEY: &str = "back_view";

/// Every panel, in the order of the menu.
pub fn all() -> Vec<Box<dyn Panel>> {
    vec![
        Box::new(back_view::BackView::default()),
        Box::new(plots::Plots::default()),
        Box::new(scene::ScenePanel::default()),
        Box::new(timing::Timing::default()),
        Box::new(partition::PartitionPanel::default()),
        Box::new(recorder::Recorder::default()),
        Box::new(messages::MessagesPanel::default()),
        Box::new(ellipse_map::EllipseMapPanel::default()),
        Box::new(stiffness_map::StiffnessMapPanel::default()),
        Box::new(lab::LabPanel::default()),
        Box::new(exercise::ExercisePanel::default()),
        Box::new(scenario_editor::ScenarioEditorPanel::default()),
        Box::new(library::LibraryPanel::default()),
        Box::new(sessions::SessionsPanel::default()),
        Box::new(compare::ComparePanel::default()),
        Box::new(devices::DevicesPanel::default()),
    ]
}

/// The panels of the trainee's own window.
pub fn trainee() -> Vec<Box<dyn Panel>> {
    vec![
        Box::new(back_view::BackView::default()),
        Box::new(exercise::ExercisePanel::default()),
    ]
}
