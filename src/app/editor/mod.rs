//! What the map editors share: a canvas over the map plane, undo, numbers in a table, files, and the way to the scene.
//!
//! | file | answers |
//! |---|---|
//! | [`frame`] | where bar, canvas and side go |
//! | [`canvas`] | how the plane is drawn, moved and magnified |
//! | [`backdrop`], [`ink`] | what lies under the hands, and what is written with over it |
//! | [`plane`] | where a place of the map is on the screen |
//! | [`silhouette`] | the outline of the back under the map |
//! | [`field`], [`grid`], [`contour`] | a number over the plane, as colour and lines |
//! | [`scale`] | which colour stands for which number |
//! | [`section`] | values along a drawn line |
//! | [`handles`] | things on the canvas that are moved by hand or keys |
//! | [`parts`] | small pieces of the sides |
//! | [`cells`] | a table of numbers that can be edited |
//! | [`editing`] | the map under the hands: its value, the chosen key, what is wrong |
//! | [`undo`] | steps back and forth |
//! | [`csv`], [`files`] | keys from files and to files |
//! | [`sync`] | edits go to the scene, its changes come in |
//! | [`worker`] | work off the window's thread |

pub mod backdrop;
pub mod canvas;
pub mod cells;
pub mod contour;
pub mod editing;

pub mod csv;
pub mod field;
pub mod files;
pub mod frame;
pub mod grid;
pub mod handles;
pub mod ink;
pub mod parts;
pub mod plane;
pub mod scale;
pub mod section;
pub mod silhouette;
pub mod sync;
pub mod undo;
pub mod worker;
