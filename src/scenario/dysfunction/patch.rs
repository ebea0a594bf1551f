//! What a dysfunction does to the map plane.

use crate::geom::Vec2;
use crate::maps::{Spot, SpotReader};

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

/// How far the bumps of patches lift the skin.
pub struct Bumps(Vec<(SpotReader, f64)>);

impl Bumps {
    /// Of those that have one.
    pub fn of<'a>(patches: impl IntoIterator<Item = &'a Patch>) -> Self {
        let with = patches.into_iter().filter(|p| p.bump_mm != 0.0);
        Self(
            with.map(|p| (SpotReader::new(&p.spot), p.bump_mm))
                .collect(),
        )
    }

    /// At a place, mm.
    pub fn at(&self, place: Vec2) -> f64 {
        self.0
            .iter()
            .map(|(spot, mm)| mm * spot.weight(place))
            .sum()
    }
}

/// What patches multiply the friction coefficients by.
pub struct Drag(Vec<(SpotReader, f64)>);

impl Drag {
    /// Of those that change them.
    pub fn of<'a>(patches: impl IntoIterator<Item = &'a Patch>) -> Self {
        let with = patches.into_iter().filter(|p| p.drag_factor != 1.0);
        Self(
            with.map(|p| (SpotReader::new(&p.spot), p.drag_factor))
                .collect(),
        )
    }

    /// At a place.
    pub fn at(&self, place: Vec2) -> f64 {
        (self.0.iter()).fold(1.0, |drag, (spot, factor)| {
            drag * share_of(*factor, spot.weight(place))
        })
    }
}

/// Where it hurts, and from which force on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tenderness(Vec<(Spot, Tender)>);

impl Tenderness {
    /// Of the patches that are tender.
    pub fn of<'a>(patches: impl IntoIterator<Item = &'a Patch>) -> Self {
        let tender = patches.into_iter();
        Self(
            tender
                .filter_map(|p| Some((p.spot.clone(), p.tender?)))
                .collect(),
        )
    }

    /// The most tender place that `at` lies in; of two alike, the one that shows it.
    pub fn at(&self, at: Vec2) -> Option<Tender> {
        let here = self.0.iter().filter(|(spot, _)| spot.ratio(at) < 1.0);
        here.map(|(_, tender)| *tender)
            .min_by(|a, b| a.above_n.total_cmp(&b.above_n).then(b.shown.cmp(&a.shown)))
    }

    /// Every tender place.
    pub fn places(&self) -> &[(Spot, Tender)] {
        &self.0
    }

    /// Memory held, bytes; curves are shared.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.0[..])
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
