//! What a dysfunction does to the map plane.

use crate::maps::Spot;

/// A place where something is different. What is not different is 1 or 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// Where, how far, and how it fades.
    pub spot: Spot,
    /// What the stiffness is multiplied by at the centre.
    pub stiffness_factor: f64,
    /// What the friction coefficients are multiplied by at the centre.
    pub drag_factor: f64,
    /// How far the skin stands out at the centre, mm; negative for a hollow.
    pub bump_mm: f64,
    /// It hurts anywhere in the ellipse.
    pub tender: Option<Tender>,
}

/// How tender a place is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tender {
    /// Force from which on it hurts, N.
    pub above_n: f64,
    /// Whether the patient shows it; else it is only counted.
    pub shown: bool,
}

impl Patch {
    /// A patch that changes nothing yet.
    pub fn plain(spot: Spot) -> Self {
        Self {
            spot,
            stiffness_factor: 1.0,
            drag_factor: 1.0,
            bump_mm: 0.0,
            tender: None,
        }
    }

    /// Whether it changes anything at all.
    pub fn does_nothing(&self) -> bool {
        self.stiffness_factor == 1.0
            && self.drag_factor == 1.0
            && self.bump_mm == 0.0
            && self.tender.is_none()
    }
}

/// `patch` so stiff that with `others` over it its centre has the factor that it has alone.
pub(super) fn amid<'a>(patch: Patch, others: impl IntoIterator<Item = &'a Patch>) -> Patch {
    let at = patch.spot.at_mm;
    let there = others.into_iter().fold(1.0, |factor, other| {
        factor * share_of(other.stiffness_factor, other.spot.weight(at))
    });
    Patch {
        stiffness_factor: patch.stiffness_factor / there,
        ..patch
    }
}

/// A share of a factor's way from 1.
pub(super) fn share_of(factor: f64, share: f64) -> f64 {
    1.0 + (factor - 1.0) * share
}
