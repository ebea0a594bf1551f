//! The built-in back: a life-size human back at any requested triangle count.
//!
//! A height field over the map plane ([`Heights`]) inside a smooth closed rim, filled with triangles that are near
//! equilateral on the surface. Same options, same bits, on every machine.

pub mod bones;
mod fill;
mod heights;
mod landmarks;
mod rim;

use super::RawMesh;
use crate::geom::Vec3;

pub use bones::{Bone, BoneKind, Skeleton};
pub use heights::Heights;
pub use landmarks::{Kind, LEVELS, Landmark, Side, landmark, landmarks};

/// How the back is made. Lengths mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BackOptions {
    /// Number of triangles; brought within [`FEWEST`] and [`MOST`].
    pub triangles: usize,
    /// Height of the thoracic spinous processes over the furrow; T1 stands half as high again.
    pub thoracic_bump_mm: f64,
    /// Height of the lumbar spinous processes over the furrow.
    pub lumbar_bump_mm: f64,
    /// Depth of the dimples over the posterior superior iliac spines.
    pub psis_dimple_mm: f64,
    /// Lateral shift of the midline at the height of the upper curve of an S, to the right; the lower curve goes left.
    pub scoliosis_mm: f64,
    /// Scale of the whole back; 1 is life-size.
    pub size: f64,
    /// Scale of width and depth against length.
    pub girth: f64,
}

/// Fewest triangles made: with fewer the rim is no longer a back's.
pub const FEWEST: usize = 200;
/// Most triangles made.
pub const MOST: usize = 4_000_000;

impl Default for BackOptions {
    fn default() -> Self {
        Self {
            triangles: 2962,
            thoracic_bump_mm: 1.2,
            lumbar_bump_mm: 1.5,
            psis_dimple_mm: 2.0,
            scoliosis_mm: 0.0,
            size: 1.0,
            girth: 1.0,
        }
    }
}

impl BackOptions {
    /// The default back with this many triangles.
    pub fn with_triangles(triangles: usize) -> Self {
        Self {
            triangles,
            ..Self::default()
        }
    }

    /// From the unscaled map plane and height to the subject's size.
    fn scaled(&self, p: Vec3) -> Vec3 {
        let (size, girth) = (factor(self.size), factor(self.girth));
        Vec3::new(p.x * size * girth, p.y * size, p.z * size * girth)
    }
}

/// A scale that is not a number, or absurd, is brought back to what a body can have.
fn factor(scale: f64) -> f64 {
    if scale.is_finite() {
        scale.clamp(0.2, 5.0)
    } else {
        1.0
    }
}

/// Makes the built-in back: counter-clockwise seen from behind, exactly `options.triangles` triangles wherever the rim
/// can take up the difference between rows of the filling, within 1 % otherwise.
pub fn make(options: &BackOptions) -> RawMesh {
    let heights = Heights::new(options);
    let rim = rim::Rim::new(&heights);
    let flat = fill::fill(&heights, &rim, options.triangles.clamp(FEWEST, MOST));
    let positions = flat
        .places
        .iter()
        .map(|&(x, y)| options.scaled(Vec3::new(x, y, heights.at(x, y))))
        .collect();
    RawMesh {
        positions,
        triangles: flat.triangles,
    }
}
