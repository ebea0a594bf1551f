//! The workbench: window, dock, panels. The only module that knows a GUI library.
//!
//! | file | answers |
//! |---|---|
//! | [`state`] | what panels may read |
//! | [`command`] | what a user can ask for, and how panels ask for it |
//! | [`panels`] | which panels there are |
//! | [`history`] | the plotted past, in bounded memory |
//! | [`camera`] | where the back is looked at from |
//! | [`stereo`] | two pictures for two eyes |
//! | [`theme`] | every colour of the window |
//! | [`colours`] | colours that stand for numbers, and quantities shown by them |
//! | [`mod@bench`] | what runs behind the window: scene, servo, recorder, replay |
//! | [`shell`] | menu, dock, own windows, status bar, keys |
//! | [`dock`] | where the panels are |
//! | [`roles`] | who sits before the window, and which workspace is ready for them |
//! | [`editor`] | what the map editors share |
//! | [`study`] | the tree of cells that is looked at |
//! | [`messages`] | what the workbench had to say |
//! | [`render`] | the skin on the graphics card; the only place for `f32` |

pub mod bench;
pub mod camera;
pub mod colours;
pub mod command;
mod dialogs;
pub mod dock;
pub mod editor;
pub mod hardware;
pub mod history;
pub mod laboratory;
mod launch;
mod libraries;
pub mod messages;
pub mod panels;
pub mod render;
pub mod roles;
pub mod shell;
pub mod state;
pub mod stereo;
pub mod study;
pub mod theme;
pub mod widgets;

pub use bench::Source;
pub use launch::{Options, Screenshot, run};
pub use libraries::can_open;
