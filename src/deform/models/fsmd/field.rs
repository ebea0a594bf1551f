//! One half of one press: an outline, how far its centre goes, and the share of that at each vertex.

use crate::deform::blocks::{BLOCK, Block, Row};
use crate::deform::curve::Curve;
use crate::deform::footprint::{Ellipse, Outline, Polar, PrintedEllipse};
use crate::deform::patches::Patches;
use crate::deform::ring::RingSearch;
use crate::geom::Vec3;
use crate::surface::Surface;

/// One half of one press.
#[derive(Clone, Debug)]
pub(super) struct Field {
    pub centre_mm: Vec3,
    pub footprint: Footprint,
    pub tangential: bool,
}

/// An outline of any kind.
#[derive(Clone, Debug)]
pub(super) enum Footprint {
    Ellipse(Ellipse),
    Printed(PrintedEllipse),
    Polar(Polar),
}

impl Footprint {
    /// The same `scale` times as large; `None` when that is empty.
    pub fn scaled(&self, scale: f64) -> Option<Self> {
        match self {
            Self::Ellipse(o) => o.scaled(scale).map(Self::Ellipse),
            Self::Printed(o) => o.scaled(scale).map(Self::Printed),
            Self::Polar(o) => o.scaled(scale).map(Self::Polar),
        }
    }

    /// Finds the vertices inside that hang together with triangle `start`.
    pub fn search(
        &self,
        search: &mut RingSearch,
        surface: &Surface,
        patches: &Patches,
        start: u32,
    ) {
        match self {
            Self::Ellipse(o) => search.search(surface, patches, o, start),
            Self::Printed(o) => search.search(surface, patches, o, start),
            Self::Polar(o) => search.search(surface, patches, o, start),
        }
    }

    /// M(q) at each vertex of a patch; 0 outside.
    pub fn shares(&self, curve: &Curve, positions: &Block) -> Row {
        match self {
            Self::Ellipse(o) => shares(o, curve, positions),
            Self::Printed(o) => shares(o, curve, positions),
            Self::Polar(o) => shares(o, curve, positions),
        }
    }
}

#[inline(always)]
fn shares(outline: &impl Outline, curve: &Curve, positions: &Block) -> Row {
    let mut row = [0.0; BLOCK];
    for (i, q) in row.iter_mut().enumerate() {
        *q = outline.ratio(positions.get(i));
    }
    curve.apply(&mut row);
    row
}
