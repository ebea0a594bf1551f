//! One triangle as the walk sees it: its plane and on which side of its edges a point lies.

use crate::geom::{Triangle, Vec3};
use crate::surface::Surface;

/// A triangle with a trustworthy normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    pub(super) triangle: u32,
    pub(super) vertices: [u32; 3],
    pub(super) corners: [Vec3; 3],
    /// Edge `i` from corner `i` to corner `i + 1`, mm.
    pub(super) edges: [Vec3; 3],
    /// Unit normal to the side that the proxy is on.
    pub(super) normal: Vec3,
    /// Twice the area times the outward normal, mm².
    area_normal: Vec3,
}

impl Face {
    /// `None` where the triangle is so thin that rounding of its corners decides its normal.
    pub(super) fn of(surface: &Surface, triangle: u32) -> Option<Self> {
        let vertices = *surface.triangles().get(triangle as usize)?;
        let Triangle { a, b, c } = surface.triangle(triangle);
        let edges = [b - a, c - b, a - c];
        let area_normal = edges[0].cross(-edges[2]);
        let area_sq = area_normal.length_squared();
        let longest_sq = edges[0]
            .length_squared()
            .max(edges[1].length_squared())
            .max(edges[2].length_squared());
        let rounding_mm = 64.0 * f64::EPSILON * a.abs().max_element();
        // Height over the longest edge against the rounding of a corner.
        if !(area_sq > longest_sq * rounding_mm * rounding_mm && area_sq >= f64::MIN_POSITIVE) {
            return None;
        }
        Some(Self {
            triangle,
            vertices,
            corners: [a, b, c],
            edges,
            normal: area_normal / area_sq.sqrt(),
            area_normal,
        })
    }

    /// Height of `p` above the plane, mm.
    pub(super) fn height(&self, p: Vec3) -> f64 {
        (p - self.corners[0]).dot(self.normal)
    }

    /// How far `p` lies on the inner side of edge `i`: positive inside, in units of mm⁴ that are the same for all edges
    /// (the weight of the opposite corner times the squared area).
    pub(super) fn inside(&self, i: usize, p: Vec3) -> f64 {
        self.area_normal
            .dot(self.edges[i].cross(p - self.corners[i]))
    }

    /// Whether the proxy is on the back.
    pub(super) fn behind(&self) -> bool {
        self.normal.dot(self.area_normal) < 0.0
    }

    /// The same face with its normal out of the back. Edges and corners stay in the order seen from the front.
    pub(super) fn seen_from_behind(self) -> Self {
        Self {
            normal: -self.normal,
            ..self
        }
    }

    /// How far a motion leads inward across edge `i`, mm; negative outward.
    pub(super) fn rate(&self, i: usize, motion: Vec3) -> f64 {
        let across = self.area_normal.cross(self.edges[i]);
        across.dot(motion) / across.length()
    }

    /// Whether a motion from `p` leads straight away over an edge that `p` lies on or beyond, to within `slack_mm`.
    pub(super) fn leaves(&self, p: Vec3, motion: Vec3, slack_mm: f64) -> bool {
        (0..3).any(|i| {
            self.rate(i, p - self.corners[i]) <= slack_mm
                && self.rate(i, motion) < -1e-9 * motion.length()
        })
    }

    /// The edge that starts at `vertex`, which must be one of the corners; edge 0 otherwise.
    pub(super) fn edge_from(&self, vertex: u32) -> usize {
        self.vertices.iter().position(|&v| v == vertex).unwrap_or(0)
    }

    /// Weights of the three corners at a point of the plane.
    pub(super) fn weights(&self, p: Vec3) -> [f64; 3] {
        let whole = self.area_normal.length_squared();
        [1, 2, 0].map(|i| self.inside(i, p) / whole)
    }

    /// How each corner's weight rises over the plane, 1/mm.
    pub(super) fn weight_slopes(&self) -> [Vec3; 3] {
        let whole = self.area_normal.length_squared();
        [1, 2, 0].map(|i| self.area_normal.cross(self.edges[i]) / whole)
    }
}
