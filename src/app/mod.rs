//! The workbench: window, dock, panels. The only module that knows a GUI library.
//!
//! | file | answers |
//! |---|---|
//! | [`state`] | what panels may read |
//! | [`command`] | what a user can ask for, and how panels ask for it |
//! | [`panels`] | which panels there are |
//! | [`history`] | the plotted past, in bounded memory |
//! | [`camera`] | where the back is looked at from |
//! | [`theme`] | every colour |
//! | [`render`] | the skin on the graphics card; the only place for `f32` |

pub mod camera;
pub mod command;
pub mod dock;
pub mod history;
pub mod messages;
pub mod panels;
pub mod render;
pub mod state;
pub mod theme;
pub mod widgets;
