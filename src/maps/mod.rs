//! Fields over the map plane (x–y): how stiff the skin is at a point, and which ellipse it gives way in.
//!
//! A map is a list of keys, checked at the door, and a continuous function through them. One file per map (what the keys
//! mean, which values are allowed, what is refused) and one per function (how values between keys come about; it knows
//! places and numbers only, so any map may use it):
//!
//! | file | holds |
//! |---|---|
//! | [`stiffness`] | the stiffness map: N/mm |
//! | [`ellipse`] | the ellipse map: how far and which way a drag carries the skin (Ji 2008, 5.1–5.3) |
//! | [`bone`] | how deep bone lies under the skin (Ji 2008, future work 1) |
//! | [`printed`] | the dissertation's worked example and the figures to meet |
//! | [`appendix`] | the measured ellipses of appendix C, their means and the seven keys |
//! | [`fit`] | the functions that a stiffness map may choose from, one file each |
//! | [`Spot`] | a place that differs from its surroundings: an ellipse with a falloff |
//! | [`gri`] | Gaussian radial interpolation (Ji 2008, 5.2), as published and corrected: for ellipses, and one of the fits |
//!
//! Values are the same bits on every machine and for any number of threads.

pub mod appendix;
pub mod bone;
pub mod ellipse;
mod error;
pub mod fit;
pub mod gri;
mod parallel;
mod places;
pub mod printed;
mod spot;
pub mod stiffness;

use crate::geom::Vec2;

pub use bone::{BoneError, BoneKey, BoneMap};
pub use ellipse::{AngleRule, EllipseField, EllipseKey, EllipseMap, EllipseSettings, Oval};
pub use error::MapError;
pub use fit::Fit;
pub use gri::{Form, Level};
pub use spot::{Spot, SpotReader};
pub use stiffness::{StiffnessKey, StiffnessMap, Stroke, leave_one_out};

/// Largest coordinate of a key, mm.
pub const MAX_COORDINATE_MM: f64 = 1.0e6;

/// A place that a map can answer for: a coordinate that is not a number counts as 0, one beyond 1e6 mm as 1e6 mm.
fn on_map(place: Vec2) -> Vec2 {
    let limited = |x: f64| {
        if x.is_nan() {
            0.0
        } else {
            x.clamp(-MAX_COORDINATE_MM, MAX_COORDINATE_MM)
        }
    };
    Vec2::new(limited(place.x), limited(place.y))
}

fn on_the_map(at: Vec2) -> bool {
    at.is_finite() && at.abs().max_element() <= MAX_COORDINATE_MM
}
