//! A slab of soft tissue under the skin round a place: its skin follows the surface, its bone lies a thickness below.

use super::fem::mesh::{Slab, SlabError};
use super::spread::Plane;
use crate::geom::{Vec2, Vec3};
use crate::partition::{Partition, Sides};
use crate::surface::Surface;

/// How a patch is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchOptions {
    /// Half its width, mm.
    pub half_width_mm: f64,
    /// Bricks along the half width.
    pub n_half: usize,
    /// Bricks from skin to bone.
    pub layers: usize,
    /// How much longer the outermost bricks are than those in the middle; 1 for even ones.
    pub growth: f64,
    /// Depth of the bone, mm.
    pub thickness_mm: f64,
}

impl Default for PatchOptions {
    fn default() -> Self {
        Self {
            half_width_mm: 60.0,
            n_half: 14,
            layers: 6,
            growth: 5.0,
            thickness_mm: 20.0,
        }
    }
}

/// Why there is no patch.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PatchError {
    /// The skin ends.
    #[error(
        "the skin ends {along_mm:.0} mm and {across_mm:.0} mm from the place pressed; a patch of {half_width_mm} mm to each side needs skin there"
    )]
    Leaves {
        /// Along the first axis of the tangent plane, mm.
        along_mm: f64,
        /// Along the second, mm.
        across_mm: f64,
        /// Half the width asked for, mm.
        half_width_mm: f64,
    },
    /// The slab.
    #[error(transparent)]
    Slab(#[from] SlabError),
}

/// A slab under the skin, and where it lies.
#[derive(Clone, Debug)]
pub struct Patch {
    /// The tangent plane its grid is laid on.
    pub plane: Plane,
    /// Places of the grid's lines along both axes of the plane, mm.
    pub lines_mm: Vec<f64>,
    /// The slab.
    pub slab: Slab,
}

impl Patch {
    /// The slab round a place on the skin with outward unit `normal`: a grid on the tangent plane, dropped on the skin along
    /// the normal.
    ///
    /// # Errors
    /// The skin ends or turns away within the patch; too many bricks.
    pub fn new(
        surface: &Surface,
        search: &dyn Partition,
        at_mm: Vec3,
        normal: Vec3,
        options: PatchOptions,
    ) -> Result<Self, PatchError> {
        let plane = Plane::at(at_mm, normal);
        let half = super::fem::graded(options.n_half, options.half_width_mm, options.growth);
        let lines_mm: Vec<f64> = half
            .iter()
            .skip(1)
            .rev()
            .map(|x| -x)
            .chain(half.iter().copied())
            .collect();
        // Up and down by the half width: a slope of 45° all the way is followed.
        let reach = plane.normal * options.half_width_mm;
        let mut skin = Vec::with_capacity(lines_mm.len() * lines_mm.len());
        for across_mm in &lines_mm {
            for along_mm in &lines_mm {
                let over = at_mm + plane.x * *along_mm + plane.y * *across_mm;
                let hit = search.sweep(surface, over + reach, over - reach, Sides::Front);
                let hit = hit.ok_or(PatchError::Leaves {
                    along_mm: *along_mm,
                    across_mm: *across_mm,
                    half_width_mm: options.half_width_mm,
                })?;
                skin.push(hit.point);
            }
        }
        let depths: Vec<f64> = (0..=options.layers)
            .map(|i| i as f64 / options.layers.max(1) as f64)
            .collect();
        let down = vec![plane.normal * -options.thickness_mm; skin.len()];
        let slab = Slab::new(lines_mm.len(), lines_mm.len(), &skin, &down, &depths)?;
        Ok(Self {
            plane,
            lines_mm,
            slab,
        })
    }

    /// The value at a place of the plane of a field given at the skin's nodes, bilinear; `None` outside.
    pub fn between(&self, place_mm: Vec2, at_nodes: &[Vec3]) -> Option<Vec3> {
        let (i, u) = self.cell(place_mm.x)?;
        let (j, v) = self.cell(place_mm.y)?;
        let at = |c: usize, r: usize| at_nodes.get(self.slab.node(i + c, j + r, 0)).copied();
        let near = at(0, 0)? * (1.0 - u) + at(1, 0)? * u;
        let far = at(0, 1)? * (1.0 - u) + at(1, 1)? * u;
        Some(near * (1.0 - v) + far * v)
    }

    fn cell(&self, x: f64) -> Option<(usize, f64)> {
        let last = self.lines_mm.len() - 1;
        let inside = x >= self.lines_mm[0] && x <= self.lines_mm[last];
        inside.then(|| {
            let i = self
                .lines_mm
                .partition_point(|line| *line <= x)
                .clamp(1, last)
                - 1;
            (
                i,
                (x - self.lines_mm[i]) / (self.lines_mm[i + 1] - self.lines_mm[i]),
            )
        })
    }
}
