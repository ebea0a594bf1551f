//! Bone under the skin limits and narrows a dent (Ji 2008, future work 1).
//!
//! With h the depth to bone:
//! - No vertex goes in deeper than c·h, c = 0.7 unless chosen otherwise: what lies between finger and bone is squeezed, not
//!   gone. The limit comes on softly from half of it on (see [`softly_limited`]), at each vertex by its own h, so that a dent
//!   beside a ridge does not dig into it, and after the presses of all fingers are added.
//! - The normal footprint is narrowed by 0.3 + 0.7·x·(2 − x) with x = h(A)/h₀ < 1 at the centre A of the dent. In a layer
//!   bonded to bone (METHOD 6: Gaussian pressure of SD 3.5 mm, ν = 0.45) the tenth-value radius at h = 3, 5, 10, 20, 30 mm is
//!   0.44, 0.47, 0.57, 0.75, 0.89 of that at 40 mm, the default of h₀; this gives 0.40, 0.46, 0.61, 0.83, 0.96.
//!
//! Both are exactly without effect where bone is deep: at h ≥ h₀ and c·h ≥ twice the depth pressed. The tangential field is
//! not concerned: skin slides over bone.

use crate::geom::Vec3;
use crate::maps::BoneMap;
use crate::surface::Surface;

/// Share of the normal footprint that is left over bone just under the skin: about the finger itself.
const NARROWEST: f64 = 0.3;

/// What may be chosen about the effect of bones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoneSettings {
    /// Deepest dent as a share of the depth to bone (c), in (0, 1].
    pub dent_share: f64,
    /// Depth of bone from which on it no longer narrows a dent (h₀), mm.
    pub reference_depth_mm: f64,
}

impl Default for BoneSettings {
    fn default() -> Self {
        Self {
            dent_share: 0.7,
            reference_depth_mm: 40.0,
        }
    }
}

/// Depth to bone under every vertex of one surface, and what it does to a dent.
#[derive(Clone, Debug, PartialEq)]
pub struct Bones {
    settings: BoneSettings,
    depth_mm: Vec<f64>,
}

impl Bones {
    /// The bones of `map` under `surface`. A setting that is not a number above 0 counts as the default; a share beyond 1
    /// as 1.
    pub fn new(map: &BoneMap, surface: &Surface, settings: BoneSettings) -> Self {
        let default = BoneSettings::default();
        let sound = |x: f64, or: f64| if x > 0.0 && x.is_finite() { x } else { or };
        Self {
            settings: BoneSettings {
                dent_share: sound(settings.dent_share, default.dent_share).min(1.0),
                reference_depth_mm: sound(settings.reference_depth_mm, default.reference_depth_mm),
            },
            depth_mm: map.per_vertex(surface),
        }
    }

    /// The settings in use.
    pub fn settings(&self) -> &BoneSettings {
        &self.settings
    }

    /// Depth to bone under every vertex, mm.
    pub fn depth_mm(&self) -> &[f64] {
        &self.depth_mm
    }

    /// Deepest dent at a vertex, mm; without end for one that the surface does not have.
    #[inline]
    pub fn limit_mm(&self, vertex: u32) -> f64 {
        let depth_mm = self.depth_mm.get(vertex as usize);
        depth_mm.map_or(f64::INFINITY, |h| h * self.settings.dent_share)
    }

    /// The normal part of a vertex's offset, shortened where bone is near.
    #[inline]
    pub fn limited(&self, vertex: u32, normal_part_mm: Vec3) -> Vec3 {
        let limit_mm = self.limit_mm(vertex);
        let length_sq = normal_part_mm.length_squared();
        if length_sq <= 0.25 * limit_mm * limit_mm {
            return normal_part_mm;
        }
        let length_mm = length_sq.sqrt();
        normal_part_mm * (softly_limited(length_mm, limit_mm) / length_mm)
    }

    /// What is left of the size of a normal footprint whose centre, mm, lies on triangle `t`: 0.3 … 1.
    ///
    /// The centre is first brought to the closest point of the triangle. A triangle that does not exist, or a centre that is
    /// not finite, is not narrowed.
    pub fn narrowing(&self, surface: &Surface, t: u32, centre_mm: Vec3) -> f64 {
        if t as usize >= surface.triangles().len() || !centre_mm.is_finite() {
            return 1.0;
        }
        let at = surface.triangle(t).closest_point(centre_mm);
        let depths_mm = surface.triangles()[t as usize].map(|v| self.depth_mm.get(v as usize));
        let depth_mm: f64 = (depths_mm.iter().zip(at.barycentric))
            .map(|(depth_mm, weight)| depth_mm.map_or(f64::INFINITY, |h| h * weight))
            .sum();
        let x = depth_mm / self.settings.reference_depth_mm;
        if x < 1.0 {
            NARROWEST + (1.0 - NARROWEST) * x * (2.0 - x)
        } else {
            1.0
        }
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        8 * self.depth_mm.capacity()
    }
}

/// A depth brought below `limit_mm`: itself up to half the limit, L − L²/(4 d) from there on.
///
/// Its slope is continuous, it rises with both depth and limit, and it stays below the limit. Nothing for a limit that is
/// not positive.
pub fn softly_limited(depth_mm: f64, limit_mm: f64) -> f64 {
    if depth_mm <= 0.5 * limit_mm {
        depth_mm
    } else if limit_mm > 0.0 && depth_mm > 0.0 {
        limit_mm * (1.0 - 0.25 * limit_mm / depth_mm)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_limit_is_soft_monotone_and_kept(d in 0.0..50.0_f64, l in 0.01..80.0_f64, more in 0.0..1.0_f64) {
            let s = softly_limited(d, l);
            prop_assert!(s <= d && s < l);
            prop_assert!(softly_limited(d + more, l) >= s && softly_limited(d, l + more) >= s);
            prop_assert!(softly_limited(d + more, l) - s <= more * (1.0 + 1e-12) + 1e-12);
            if d <= 0.5 * l {
                prop_assert_eq!(s, d);
            }
        }
    }
}
