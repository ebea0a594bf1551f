//! Where a dysfunction lies on the map plane and how large it is there.

use super::site::lateral;
use super::{Dysfunction, Patch, Place, Site, Tender};
use crate::geom::Vec2;
use crate::geom::curve::{self, Curve};
use crate::maps::Spot;
use std::sync::OnceLock;

/// Most that a seed moves a dysfunction to each side and up or down, mm.
pub const VARIES_MM: f64 = 2.0;
/// Most that it makes it larger or smaller, as a share.
pub const VARIES_SHARE: f64 = 0.1;
/// Most that it turns it, degrees.
pub const VARIES_DEG: f64 = 10.0;

/// One of the places of a dysfunction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    /// The site, where it has one.
    pub site: Option<Site>,
    /// Centre with its offset, mm.
    pub at_mm: Vec2,
    /// Half axes, mm.
    pub half_axes_mm: [f64; 2],
    /// Direction of the first, radians from x towards y.
    pub angle_rad: f64,
}

/// Its places in order; with a seed each varies by itself: the centre by up to [`VARIES_MM`] in x and y, the extent by up to
/// [`VARIES_SHARE`], the angle by up to [`VARIES_DEG`], all evenly distributed.
pub(super) fn places(d: &Dysfunction) -> Vec<Placed> {
    match &d.place {
        Place::At(at) => {
            let side = if at.x < 0.0 { -1.0 } else { 1.0 };
            vec![placed(d, 0, None, *at, side)]
        }
        Place::Sites(sites) => sites
            .iter()
            .enumerate()
            .map(|(i, site)| {
                let side = if lateral(site.side) < 0.0 { -1.0 } else { 1.0 };
                placed(d, i as u64, Some(*site), site.at_mm(), side)
            })
            .collect(),
    }
}

fn placed(d: &Dysfunction, n: u64, site: Option<Site>, at: Vec2, side: f64) -> Placed {
    let draw = |what: u64| d.seed.map_or(0.0, |seed| symmetric(seed, 4 * n + what));
    let shift = Vec2::new(draw(0), draw(1)) * VARIES_MM;
    let larger = 1.0 + draw(2) * VARIES_SHARE;
    let offset = Vec2::new(d.offset_mm.x * side, d.offset_mm.y);
    let angle = (d.angle_deg + draw(3) * VARIES_DEG).to_radians();
    Placed {
        site,
        at_mm: at + offset + shift,
        half_axes_mm: d.radius_mm.map(|r| r * larger),
        angle_rad: if side < 0.0 {
            std::f64::consts::PI - angle
        } else {
            angle
        },
    }
}

impl Placed {
    pub fn spot(&self, d: &Dysfunction) -> Spot {
        self.spot_of(d, self.at_mm, self.half_axes_mm, self.angle_rad)
    }

    pub fn spot_of(&self, d: &Dysfunction, at_mm: Vec2, axes: [f64; 2], angle_rad: f64) -> Spot {
        Spot {
            at_mm,
            half_axes_mm: axes,
            angle_rad,
            profile: profile(&d.profile),
        }
    }

    /// The patch with the dysfunction's whole strength.
    pub fn patch(&self, d: &Dysfunction) -> Patch {
        let strength = d.strength();
        Patch {
            spot: self.spot(d),
            stiffness_factor: strength.stiffness_factor(),
            drag_factor: strength.skin_drag.unwrap_or(1.0),
            bump_mm: strength.bump_mm.unwrap_or(0.0),
            tender: strength.tender_above_n.map(|above_n| Tender {
                above_n,
                shown: d.tender_shown,
            }),
        }
    }
}

/// The curve with this name, its samples shared by all who ask; the Gaussian for a name that is in no list.
fn profile(name: &str) -> Curve {
    static CURVES: OnceLock<Vec<(&str, Curve)>> = OnceLock::new();
    let curves = CURVES.get_or_init(|| {
        let all = curve::all().iter();
        all.map(|(name, curve)| (*name, curve())).collect()
    });
    let found = curves.iter().find(|(n, _)| *n == name);
    found.map_or_else(Curve::gaussian, |(_, curve)| curve.clone())
}

/// The patches of a kind that is one ellipse at each place.
pub(super) fn one_each(d: &Dysfunction) -> Vec<Patch> {
    places(d).iter().map(|place| place.patch(d)).collect()
}

/// Number `n` of the stream of `seed`, all bits (SplitMix64, Steele et al. 2014).
pub(super) fn bits(seed: u64, n: u64) -> u64 {
    let mut z = seed.wrapping_add(n.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// The same as a number in −1 … 1.
fn symmetric(seed: u64, n: u64) -> f64 {
    // 53 bits are a number exactly.
    let unit = (bits(seed, n) >> 11) as f64 / (1_u64 << 53) as f64;
    2.0 * unit - 1.0
}
