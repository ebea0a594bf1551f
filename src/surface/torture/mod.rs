//! Surfaces that break contact engines, each with a path for a finger and the truth about it: for tests and the lab.
//!
//! All are some 10 mm in size about the origin; who wants another scale or place maps mesh and path, and maps the proxy back.

mod cases;
mod shapes;

use super::RawMesh;
use crate::geom::{Vec3, unit_or};

pub use cases::all;
pub use shapes::{band_place, block, grid, patch, planes, steps, together, turned, twisted_band};

/// One surface, where a finger goes on it, and where the proxy must then be.
pub struct Case {
    /// Name in tables.
    pub name: &'static str,
    /// The surface, mm.
    pub mesh: RawMesh,
    /// What is known of it.
    pub truth: Truth,
    /// Corners of the finger's path, mm. The first is free; the path goes from the last back to the first.
    pub path: Vec<Vec3>,
    /// Whether another sheet meets the one that the finger is on, so that a resting proxy may be held by triangles that are
    /// no neighbours.
    pub crossed: bool,
}

/// The side of a plane that its normal points to: `normal` · p ≥ `offset_mm`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// Unit normal, into the free space.
    pub normal: Vec3,
    /// Distance of the plane from the origin along the normal, mm.
    pub offset_mm: f64,
}

impl HalfSpace {
    /// The half-space above the plane through `point`.
    pub fn new(point: Vec3, normal: Vec3) -> Self {
        let normal = unit_or(normal, Vec3::Z);
        Self {
            normal,
            offset_mm: normal.dot(point),
        }
    }

    /// Height of `p` above the plane, mm.
    pub fn height_mm(&self, p: Vec3) -> f64 {
        self.normal.dot(p) - self.offset_mm
    }
}

/// What is known of a surface without asking its triangles.
pub enum Truth {
    /// Wherever the path leads, the free space is what these half-spaces share: it is convex, and the frictionless proxy is
    /// the closest point of it.
    Cell(Vec<HalfSpace>),
    /// The body lies below z = height(x, y) and no steeper than `slope`, nowhere higher than `top_mm`.
    Height {
        /// Height of the surface at (x, y), mm.
        height: Box<dyn Fn(f64, f64) -> f64 + Send + Sync>,
        /// Steepest rise per run.
        slope: f64,
        /// Highest place, mm.
        top_mm: f64,
    },
    /// Convex bodies, each the points below all its planes, all within `radius_mm` of the origin.
    Bodies {
        /// The planes of each, normals outward.
        bodies: Vec<Vec<HalfSpace>>,
        /// Farthest point from the origin, mm.
        radius_mm: f64,
    },
    /// The rectangle |x| ≤ `half_mm`, |y| ≤ `half_mm` in z = 0, open all round.
    Plate {
        /// Half the edge, mm.
        half_mm: f64,
    },
}

impl Truth {
    /// How deep `p` is where nothing may be that came from outside, mm; ≤ 0 outside. A plate has no inside.
    pub fn depth_mm(&self, p: Vec3) -> f64 {
        match self {
            Self::Cell(cell) => {
                (cell.iter()).fold(f64::NEG_INFINITY, |d, h| d.max(-h.height_mm(p)))
            }
            Self::Height { height, .. } => height(p.x, p.y) - p.z,
            Self::Bodies { bodies, .. } => {
                let inside = |planes: &Vec<HalfSpace>| {
                    (planes.iter()).fold(f64::INFINITY, |d, h| d.min(-h.height_mm(p)))
                };
                bodies.iter().map(inside).fold(f64::NEG_INFINITY, f64::max)
            }
            Self::Plate { .. } => f64::NEG_INFINITY,
        }
    }

    /// How much the depth can change per mm of motion.
    pub fn steepness(&self) -> f64 {
        match self {
            Self::Height { slope, .. } => 1.0 + slope,
            _ => 1.0,
        }
    }

    /// The farthest that a frictionless proxy can lag behind `hip` for geometric reasons, mm.
    ///
    /// Of a cell it is the distance to the cell. On a height field a proxy rests where the pull is in the cone of the normals
    /// about it, so its drop to the finger is at least lag · cos(steepest). In a convex body it is on the body.
    pub fn lag_bound_mm(&self, hip: Vec3) -> f64 {
        match self {
            Self::Cell(cell) => closest_in(cell, hip).distance(hip),
            Self::Height { slope, top_mm, .. } => {
                (top_mm - hip.z).max(0.0) * (1.0 + slope * slope).sqrt()
            }
            Self::Bodies { radius_mm, .. } => hip.length() + radius_mm,
            Self::Plate { .. } => hip.z.abs(),
        }
    }
}

/// The point of a convex cell closest to `p`: the closest of those projections onto up to three of its planes that lie in
/// the cell. Cost grows with the cube of the planes.
pub fn closest_in(cell: &[HalfSpace], p: Vec3) -> Vec3 {
    let slack = 1e-9 * (1.0 + p.length());
    let fits = |q: Vec3| cell.iter().all(|h| h.height_mm(q) >= -slack);
    if cell.iter().all(|h| h.height_mm(p) >= 0.0) {
        return p;
    }
    let mut best: Option<Vec3> = None;
    let mut offer = |q: Vec3| {
        let closer = best.is_none_or(|b| q.distance_squared(p) < b.distance_squared(p));
        if q.is_finite() && closer && fits(q) {
            best = Some(q);
        }
    };
    for (i, a) in cell.iter().enumerate() {
        offer(p - a.normal * a.height_mm(p));
        for (j, b) in cell.iter().enumerate().skip(i + 1) {
            // p + s a + t b on both planes.
            let c = a.normal.dot(b.normal);
            let sin_sq = a.normal.cross(b.normal).length_squared();
            let (ha, hb) = (-a.height_mm(p), -b.height_mm(p));
            offer(p + (a.normal * (ha - c * hb) + b.normal * (hb - c * ha)) / sin_sq);
            for d in &cell[j + 1..] {
                let (bd, da, ab) = (
                    b.normal.cross(d.normal),
                    d.normal.cross(a.normal),
                    a.normal.cross(b.normal),
                );
                let det = a.normal.dot(bd);
                offer((bd * a.offset_mm + da * b.offset_mm + ab * d.offset_mm) / det);
            }
        }
    }
    best.unwrap_or(p)
}

/// A reproducible stream of numbers in −1…1 (SplitMix64, Steele et al. 2014).
#[derive(Clone, Debug)]
pub struct Stream(pub u64);

impl Stream {
    /// The next number.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// A vector of three numbers, each in −1…1.
    pub fn vector(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Surface;
    use crate::surface::primitives::cuboid;

    #[test]
    fn every_surface_is_let_in_and_the_finger_starts_outside() {
        for case in all(1) {
            let (surface, report) = Surface::new(case.mesh).expect(case.name);
            assert_eq!(surface.check(), Ok(()), "{}", case.name);
            assert!(case.truth.depth_mm(case.path[0]) < -0.01, "{}", case.name);
            let flat = |d: &crate::surface::Defect| {
                matches!(d, crate::surface::Defect::DegenerateTriangles(_))
            };
            assert!(!report.defects.iter().any(flat), "{}", case.name);
        }
    }

    #[test]
    fn the_truth_lies_on_the_triangles() {
        // Of the triangles below the path, each centre is on the border of the free space or beside it.
        for case in all(1) {
            let on = (case.mesh.triangles.iter())
                .map(|t| {
                    let [a, b, c] = t.map(|v| case.mesh.positions[v as usize]);
                    case.truth.depth_mm((a + b + c) / 3.0).abs()
                })
                .filter(|d| *d < 1e-9)
                .count();
            let plate = matches!(case.truth, Truth::Plate { .. });
            assert!(
                plate || on * 12 >= case.mesh.triangles.len(),
                "{}: {on}",
                case.name
            );
        }
    }

    #[test]
    fn the_closest_point_of_a_cell_is_the_clamped_one_in_a_box() {
        let planes = planes(&turned(cuboid(Vec3::splat(-1.0), Vec3::splat(2.0))));
        let mut s = Stream(1);
        for _ in 0..300 {
            let p = s.vector() * 4.0;
            let q = p.clamp(Vec3::splat(-1.0), Vec3::splat(2.0));
            assert!(closest_in(&planes, p).distance(q) < 1e-12);
        }
    }
}
