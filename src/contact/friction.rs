//! Friction as METHOD reads Ji 2008, 4.2 and 4.6: the cone as a ratio of lengths, and the anchor of a device that
//! reports only its force.

use super::Friction;
use crate::geom::Vec3;

/// Largest coefficient and looseness, and one over the smallest looseness: beyond, the cone or the stiffness along the skin
/// would overflow.
const MOST: f64 = 1.0e9;

/// The friction cone in lengths: slip starts where |P − A| exceeds `starting` times the depth and goes on at `moving`
/// times the depth. Both zero without friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cone {
    pub(super) starting: f64,
    pub(super) moving: f64,
    /// f_adj: normal over tangential stiffness.
    pub(super) looseness: f64,
}

impl Cone {
    pub(super) fn of(friction: Option<&Friction>) -> Self {
        let Some(f) = friction else {
            return Self {
                starting: 0.0,
                moving: 0.0,
                looseness: 1.0,
            };
        };
        let looseness = positive_or(f.skin_looseness, 1.0).clamp(1.0 / MOST, MOST);
        let coefficient = |x: f64| positive_or(x, 0.0).min(MOST);
        let moving = coefficient(f.dynamic_coefficient) * looseness;
        Self {
            starting: (coefficient(f.static_coefficient) * looseness).max(moving),
            moving,
            looseness,
        }
    }
}

/// The anchor A, mm, of a device that reports only its proxy `foot_mm` (P), its position `hip_mm` (D) and its force (F).
///
/// The line through D along F meets the plane through P at right angles to `normal` in A′ (Ji 2008, 2.6, as METHOD reads
/// it). There A′ − P is F's tangential part over its normal part, times the depth. Tangential stiffness is F(d)/d over
/// `skin_looseness`, f_adj, so A′ is P + (A − P)/f_adj: A is f_adj times as far from P. This holds for every force
/// model, damped or not, and for a force that was scaled down to what a device can do. Without an f_adj of its own (a
/// device's own friction) it is 1; what is not positive and finite counts as 1.
///
/// Agrees with [`Contact::anchor_mm`](super::Contact::anchor_mm). `None` without contact: no force, a force that does not
/// push outward, or anything not finite.
pub fn anchor_from(
    foot_mm: Vec3,
    hip_mm: Vec3,
    force_n: Vec3,
    normal: Vec3,
    skin_looseness: f64,
) -> Option<Vec3> {
    let outward_n = force_n.dot(normal);
    let depth_mm = (foot_mm - hip_mm).dot(normal);
    if !(outward_n > 0.0 && depth_mm >= 0.0) {
        return None;
    }
    let met = hip_mm + force_n * (depth_mm / outward_n);
    let anchor = foot_mm + (met - foot_mm) * positive_or(skin_looseness, 1.0);
    anchor.is_finite().then_some(anchor)
}

fn positive_or(v: f64, or: f64) -> f64 {
    if v.is_finite() && v > 0.0 { v } else { or }
}
