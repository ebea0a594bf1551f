//! One triangle: its normal, its closest point, its crossing with a segment.

use super::{Aabb, Vec3, unit_or};

/// Three corners, mm. Counter-clockwise seen from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// First corner, mm.
    pub a: Vec3,
    /// Second corner, mm.
    pub b: Vec3,
    /// Third corner, mm.
    pub c: Vec3,
}

/// Which part of a triangle a point lies on. Edge `i` joins corner `i` to corner `i + 1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// Strictly inside.
    Face,
    /// On edge 0 (a–b), 1 (b–c) or 2 (c–a).
    Edge(u8),
    /// On corner 0, 1 or 2.
    Vertex(u8),
}

/// A point on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrianglePoint {
    /// Where it is, mm.
    pub point: Vec3,
    /// Its weights for the three corners; each in 0…1, sum 1.
    pub barycentric: [f64; 3],
    /// Which part of the triangle it lies on.
    pub feature: Feature,
}

/// Where a segment crosses a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Fraction of the segment, 0…1.
    pub t: f64,
    /// Weights of the three corners.
    pub barycentric: [f64; 3],
    /// Whether the segment goes against the normal, that is from outside to inside.
    pub inward: bool,
}

impl Triangle {
    /// Twice the area times the unit normal, mm². Zero for a degenerate triangle.
    pub fn area_normal(&self) -> Vec3 {
        (self.b - self.a).cross(self.c - self.a)
    }

    /// Outward unit normal; +z for a degenerate triangle.
    pub fn normal(&self) -> Vec3 {
        unit_or(self.area_normal(), Vec3::Z)
    }

    /// Area, mm².
    pub fn area_mm2(&self) -> f64 {
        self.area_normal().length() / 2.0
    }

    /// The mean of the corners, mm.
    pub fn centroid(&self) -> Vec3 {
        (self.a + self.b + self.c) / 3.0
    }

    /// The smallest box around it.
    pub fn aabb(&self) -> Aabb {
        Aabb {
            min: self.a.min(self.b).min(self.c),
            max: self.a.max(self.b).max(self.c),
        }
    }

    /// The point with the given corner weights, mm.
    pub fn at(&self, barycentric: [f64; 3]) -> Vec3 {
        self.a * barycentric[0] + self.b * barycentric[1] + self.c * barycentric[2]
    }

    /// The point of the triangle closest to `p` (Ericson 2005, Real-Time Collision Detection, 5.1.5).
    ///
    /// A degenerate triangle answers with the closest point of its edges or corners.
    pub fn closest_point(&self, p: Vec3) -> TrianglePoint {
        let (ab, ac, ap) = (self.b - self.a, self.c - self.a, p - self.a);
        let (d1, d2) = (ab.dot(ap), ac.dot(ap));
        if d1 <= 0.0 && d2 <= 0.0 {
            return self.corner(0);
        }
        let bp = p - self.b;
        let (d3, d4) = (ab.dot(bp), ac.dot(bp));
        if d3 >= 0.0 && d4 <= d3 {
            return self.corner(1);
        }
        let vc = d1 * d4 - d3 * d2;
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return self.on_edge(0, d1 / (d1 - d3));
        }
        let cp = p - self.c;
        let (d5, d6) = (ab.dot(cp), ac.dot(cp));
        if d6 >= 0.0 && d5 <= d6 {
            return self.corner(2);
        }
        let vb = d5 * d2 - d1 * d6;
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return self.on_edge(2, 1.0 - d2 / (d2 - d6));
        }
        let va = d3 * d6 - d5 * d4;
        if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
            return self.on_edge(1, (d4 - d3) / ((d4 - d3) + (d5 - d6)));
        }
        let sum = va + vb + vc;
        let barycentric = [va / sum, vb / sum, vc / sum];
        TrianglePoint {
            point: self.at(barycentric),
            barycentric,
            feature: Feature::Face,
        }
    }

    fn corner(&self, i: u8) -> TrianglePoint {
        let mut barycentric = [0.0; 3];
        barycentric[i as usize] = 1.0;
        TrianglePoint {
            point: [self.a, self.b, self.c][i as usize],
            barycentric,
            feature: Feature::Vertex(i),
        }
    }

    /// The point a fraction `t` along edge `i` from its first corner; a zero-length edge gives that corner.
    fn on_edge(&self, i: u8, t: f64) -> TrianglePoint {
        if !t.is_finite() {
            return self.corner(i);
        }
        let corners = [self.a, self.b, self.c];
        let (i0, i1) = (i as usize, (i as usize + 1) % 3);
        let mut barycentric = [0.0; 3];
        barycentric[i0] = 1.0 - t;
        barycentric[i1] = t;
        TrianglePoint {
            point: corners[i0] + (corners[i1] - corners[i0]) * t,
            barycentric,
            feature: Feature::Edge(i),
        }
    }

    /// Where the segment from `from` to `to` first crosses the triangle.
    ///
    /// Watertight: the side of each edge is decided by the sign of one triple product that two triangles sharing the
    /// edge compute alike, so a segment through an edge or a corner hits at least one of them. A segment in the plane
    /// of the triangle does not cross it.
    pub fn crossing(&self, from: Vec3, to: Vec3) -> Option<Crossing> {
        let dir = to - from;
        let (a, b, c) = (self.a - from, self.b - from, self.c - from);
        let (u, v, w) = (side(b, c, dir), side(c, a, dir), side(a, b, dir));
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let det = u + v + w;
        if det == 0.0 {
            return None;
        }
        let n = self.area_normal();
        let along = n.dot(dir);
        if along == 0.0 {
            return None;
        }
        let t = n.dot(a) / along;
        if !(0.0..=1.0).contains(&t) {
            return None;
        }
        let barycentric = [u / det, v / det, w / det];
        Some(Crossing {
            t,
            barycentric,
            inward: along < 0.0,
        })
    }
}

/// Signed volume of the edge p→q seen along `dir`, computed in one order for p→q and q→p so that the two exactly cancel.
fn side(p: Vec3, q: Vec3, dir: Vec3) -> f64 {
    let swap = (p.x, p.y, p.z) > (q.x, q.y, q.z);
    let (s, t) = if swap { (q, p) } else { (p, q) };
    let volume = s.cross(t).dot(dir);
    if swap { -volume } else { volume }
}
