//! Fields over the map plane (x–y): how stiff the skin is at a point.

pub mod stiffness;

pub use stiffness::{Fit, MapError, StiffnessKey, StiffnessMap};
