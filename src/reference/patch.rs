//! A slab of soft tissue under the skin round a place: its skin follows the surface, its bone lies a thickness below.

use super::fem::mesh::{Slab, SlabError};
use super::plane::Plane;
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
        let mut value = Vec3::ZERO;
        for (node, share) in self.round(place_mm)? {
            value += *at_nodes.get(node)? * share;
        }
        Some(value)
    }

    /// The four skin nodes round a place of the plane, with the share of each in it; `None` outside.
    pub fn round(&self, place_mm: Vec2) -> Option<[(usize, f64); 4]> {
        let (i, u) = self.cell(place_mm.x)?;
        let (j, v) = self.cell(place_mm.y)?;
        let of = |c: usize, r: usize, share: f64| (self.slab.node(i + c, j + r, 0), share);
        Some([
            of(0, 0, (1.0 - u) * (1.0 - v)),
            of(1, 0, u * (1.0 - v)),
            of(0, 1, (1.0 - u) * v),
            of(1, 1, u * v),
        ])
    }

    /// Skin nodes with their shares in a Gaussian pressure on the plane: what does the same work on every field that is
    /// bilinear between nodes, exactly. They add up to 1; none where the pressure lies beside the patch.
    pub fn shares(&self, place_mm: Vec2, deviation_mm: f64) -> Vec<(usize, f64)> {
        let across = hats(&self.lines_mm, place_mm.x, deviation_mm);
        let along = hats(&self.lines_mm, place_mm.y, deviation_mm);
        let mut shares = Vec::with_capacity(across.len() * along.len());
        for (row, v) in &along {
            for (column, u) in &across {
                shares.push((self.slab.node(*column, *row, 0), u * v));
            }
        }
        shares
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

/// Shares of the lines in a Gaussian round `x`, ∫ hat · Gaussian, scaled to add up to 1; those beyond six deviations left
/// out.
fn hats(lines_mm: &[f64], x: f64, deviation_mm: f64) -> Vec<(usize, f64)> {
    let s = deviation_mm;
    let below = |t: f64| 0.5 * libm::erf(t / std::f64::consts::SQRT_2);
    let density = |t: f64| libm::exp(-0.5 * t * t) / libm::sqrt(2.0 * std::f64::consts::PI);
    let mut shares = vec![0.0; lines_mm.len()];
    for (i, ends) in lines_mm.windows(2).enumerate() {
        let [a, b] = [(ends[0] - x) / s, (ends[1] - x) / s];
        if a < REACH && b > -REACH {
            let whole = below(b) - below(a);
            // ∫ t φ(t) dt = −φ.
            let moment = density(a) - density(b);
            let right = (moment - a * whole) / (b - a);
            shares[i] += whole - right;
            shares[i + 1] += right;
        }
    }
    let sum: f64 = shares.iter().sum();
    let positive = shares
        .into_iter()
        .enumerate()
        .filter(|(_, share)| *share > 0.0 && sum > 0.0);
    positive.map(|(i, share)| (i, share / sum)).collect()
}

/// Deviations beyond which a Gaussian is nothing.
const REACH: f64 = 6.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::fem::graded;

    /// Against plain sums over many small steps.
    #[test]
    fn shares_of_a_gaussian_are_its_integrals() {
        let lines = graded(9, 60.0, 5.0);
        for (x, s) in [(0.0, 3.5), (7.3, 3.5), (22.0, 1.0), (40.0, 12.0)] {
            let shares = hats(&lines, x, s);
            let step = 1.0e-3;
            let mut sums = vec![0.0; lines.len()];
            for i in 0..60_000 {
                let at = (f64::from(i) + 0.5) * step;
                let t = (at - x) / s;
                let w = (-0.5 * t * t).exp();
                let cell = lines
                    .partition_point(|l| *l <= at)
                    .clamp(1, lines.len() - 1)
                    - 1;
                let u = (at - lines[cell]) / (lines[cell + 1] - lines[cell]);
                sums[cell] += w * (1.0 - u);
                sums[cell + 1] += w * u;
            }
            let whole: f64 = sums.iter().sum();
            for (i, share) in &shares {
                assert!((share - sums[*i] / whole).abs() < 1.0e-6, "{x} {s} {i}");
            }
            assert!((shares.iter().map(|(_, w)| w).sum::<f64>() - 1.0).abs() < 1e-12);
        }
        assert!(hats(&lines, 500.0, 3.5).is_empty());
        assert!(hats(&lines, f64::NAN, 3.5).is_empty());
    }
}
