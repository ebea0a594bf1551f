//! Fields over the map plane (x–y): how stiff the skin is at a point.
//!
//! A map is a list of keys, checked at the door, and a continuous function through them. One file per map (what the keys
//! mean, which values are allowed, what is refused) and one per function (how values between keys come about; it knows
//! places and numbers only, so any map may use it):
//!
//! | file | holds |
//! |---|---|
//! | [`stiffness`] | the stiffness map: N/mm |
//! | `natural` | natural neighbour interpolation (Sibson 1981), with its extension beyond the hull of the keys |
//!
//! Values are the same bits on every machine and for any number of threads.

mod natural;
pub mod stiffness;

pub use stiffness::{Fit, MapError, StiffnessKey, StiffnessMap};
