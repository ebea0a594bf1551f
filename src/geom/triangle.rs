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

    /// Whether it shares a point with the box, by separating axes (Akenine-Möller 2001): the box's, its own normal, and
    /// each of their edges with each of its own. What only touches, to rounding, may be told either way.
    pub fn meets(&self, region: &Aabb) -> bool {
        if region.is_empty() || !self.aabb().overlaps(region) {
            return false;
        }
        let (centre, half) = (region.centre(), region.size() / 2.0);
        let corners = [self.a - centre, self.b - centre, self.c - centre];
        let parted_by = |axis: Vec3| {
            let along = corners.map(|p| p.dot(axis));
            let reach = half.dot(axis.abs());
            let low = along[0].min(along[1]).min(along[2]);
            let high = along[0].max(along[1]).max(along[2]);
            low > reach || high < -reach
        };
        let edges = [self.b - self.a, self.c - self.b, self.a - self.c];
        let axes = [Vec3::X, Vec3::Y, Vec3::Z];
        let across = edges
            .iter()
            .flat_map(|e| axes.iter().map(move |k| k.cross(*e)));
        !parted_by(self.area_normal()) && !across.into_iter().any(parted_by)
    }

    /// The point with the given corner weights, mm.
    pub fn at(&self, barycentric: [f64; 3]) -> Vec3 {
        self.a * barycentric[0] + self.b * barycentric[1] + self.c * barycentric[2]
    }

    /// The point of the triangle closest to `p` (Ericson 2005, Real-Time Collision Detection, 5.1.5).
    ///
    /// The weights come from cross products rather than Ericson's products of dot products, so that their error grows
    /// with the distance of `p` over the size of the triangle, not with its square. A degenerate triangle answers with the
    /// closest point of its edges or corners.
    pub fn closest_point(&self, p: Vec3) -> TrianglePoint {
        let (ab, ac, ap) = (self.b - self.a, self.c - self.a, p - self.a);
        let n = ab.cross(ac);
        let (d1, d2) = (ab.dot(ap), ac.dot(ap));
        if d1 <= 0.0 && d2 <= 0.0 {
            return self.corner(0);
        }
        let bp = p - self.b;
        let (d3, d4) = (ab.dot(bp), ac.dot(bp));
        if d3 >= 0.0 && d4 <= d3 {
            return self.corner(1);
        }
        let vc = n.dot(ab.cross(ap));
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return self.on_edge(0, d1 / (d1 - d3));
        }
        let cp = p - self.c;
        let (d5, d6) = (ab.dot(cp), ac.dot(cp));
        if d6 >= 0.0 && d5 <= d6 {
            return self.corner(2);
        }
        let vb = n.dot(cp.cross(ac));
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return self.on_edge(2, 1.0 - d2 / (d2 - d6));
        }
        let va = n.dot((self.c - self.b).cross(bp));
        if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
            return self.on_edge(1, (d4 - d3) / ((d4 - d3) + (d5 - d6)));
        }
        // Rounding can leave a sliver with no matching region above: its nearest edge or corner then.
        let (va, vb, vc) = (va.max(0.0), vb.max(0.0), vc.max(0.0));
        let sum = va + vb + vc;
        if !(sum > 0.0 && sum.is_finite()) {
            let to = [self.a, self.b, self.c].map(|q| q.distance_squared(p));
            let nearest = (0..3).fold(0, |m, i| if to[i] < to[m] { i } else { m });
            return self.corner(nearest as u8);
        }
        let barycentric = [va / sum, vb / sum, vc / sum];
        TrianglePoint {
            point: self.a + ab * barycentric[1] + ac * barycentric[2],
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
        let (u, v, w) = (
            side(self.b, self.c, from, dir),
            side(self.c, self.a, from, dir),
            side(self.a, self.b, from, dir),
        );
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let det = u + v + w;
        // A motion so long that its products overflow crosses nothing.
        if det == 0.0 || !det.is_finite() {
            return None;
        }
        let n = self.area_normal();
        let along = n.dot(dir);
        if along == 0.0 {
            return None;
        }
        // A segment that grazes the plane meets it anywhere, to rounding; but not before the first corner or after the last.
        let [a, b, c] = [self.a, self.b, self.c].map(|p| (p - from).dot(dir));
        let length_sq = dir.length_squared();
        let (first, last) = (a.min(b).min(c) / length_sq, a.max(b).max(c) / length_sq);
        let t = (n.dot(self.a - from) / along).max(first).min(last);
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

/// Signed volume spanned by the edge p→q and the line from `from` along `dir`, computed in one order for p→q and q→p so
/// that the two exactly cancel. Its rounding grows with the length of the edge times the distance of the line's start.
fn side(p: Vec3, q: Vec3, from: Vec3, dir: Vec3) -> f64 {
    let swap = (p.x, p.y, p.z) > (q.x, q.y, q.z);
    let (s, t) = if swap { (q, p) } else { (p, q) };
    let volume = (t - s).dot(dir.cross(s - from));
    if swap { -volume } else { volume }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vec3(range: f64) -> impl Strategy<Value = Vec3> {
        [-range..range, -range..range, -range..range].prop_map(Vec3::from_array)
    }

    fn triangle() -> impl Strategy<Value = Triangle> {
        (vec3(1.0), vec3(1.0), vec3(1.0)).prop_map(|(a, b, c)| Triangle { a, b, c })
    }

    fn moved(t: &Triangle, scale: f64, by: Vec3) -> Triangle {
        let [a, b, c] = [t.a, t.b, t.c].map(|p| p * scale + by);
        Triangle { a, b, c }
    }

    /// Smallest distance to `p` over a fine grid of weights: an upper bound that is nearly reached.
    fn sampled_distance(t: &Triangle, p: Vec3) -> f64 {
        let n = 60;
        let mut least = f64::INFINITY;
        for i in 0..=n {
            for j in 0..=n - i {
                let (u, v) = (i as f64 / n as f64, j as f64 / n as f64);
                least = least.min(t.at([u, v, 1.0 - u - v]).distance(p));
            }
        }
        least
    }

    /// Products that ran over made weights and places of NaN.
    #[test]
    fn from_farther_than_numbers_reach_the_closest_point_is_one_and_nothing_is_crossed() {
        let t = Triangle {
            a: Vec3::ZERO,
            b: Vec3::X * 1e7,
            c: Vec3::Y * 1e7,
        };
        for p in [1e308, 1e160, f64::INFINITY, f64::NAN].map(|x| Vec3::new(x, 1.0, x)) {
            let at = t.closest_point(p);
            assert!(at.point.is_finite() && at.barycentric.iter().all(|w| w.is_finite()));
            let hit = t.crossing(p, -p);
            assert!(
                hit.is_none_or(|h| h.t.is_finite() && h.barycentric.iter().all(|w| w.is_finite()))
            );
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]

        #[test]
        fn no_sampled_point_is_closer_than_the_closest(t in triangle(), p in vec3(2.0)) {
            let found = t.closest_point(p);
            let distance = found.point.distance(p);
            prop_assert!(distance <= sampled_distance(&t, p) + 1e-12);
            prop_assert!(sampled_distance(&t, p) <= distance + 0.06);
            prop_assert!((found.barycentric.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            prop_assert!(found.barycentric.iter().all(|w| (0.0..=1.0).contains(w)));
            prop_assert!(t.at(found.barycentric).distance(found.point) < 1e-12);
        }

        #[test]
        fn the_closest_point_keeps_its_place_at_any_scale_and_far_from_the_origin(
            t in triangle(), p in vec3(3.0), power in -20_i32..20, by in vec3(1e6),
        ) {
            let scale = libm::exp2(f64::from(power));
            let near = t.closest_point(p).point;
            let far = moved(&t, scale, by).closest_point(p * scale + by).point;
            let (d, e) = (near.distance(p), (far - by).distance(p * scale) / scale);
            let rounding = 1e-9 / scale + 1e-12;
            prop_assert!((d - e).abs() <= rounding, "{d} {e}");
        }

        #[test]
        fn from_far_away_the_closest_point_is_still_the_foot(
            t in triangle(), u in 0.1_f64..0.8, height in 1.0_f64..1e7,
        ) {
            prop_assume!(t.area_mm2() > 0.05);
            let w = [u, (1.0 - u) / 2.0, (1.0 - u) / 2.0];
            let found = t.closest_point(t.at(w) + t.normal() * height);
            prop_assert!(found.point.distance(t.at(w)) < 1e-14 * height + 1e-14);
            prop_assert_eq!(found.feature, Feature::Face);
        }

        #[test]
        fn a_segment_through_a_known_point_crosses_there(
            t in triangle(), u in 0.01_f64..0.98, v in 0.0_f64..1.0, d in vec3(1.0), part in 0.05_f64..0.95,
            power in -20_i32..20, by in vec3(1e3),
        ) {
            prop_assume!(t.area_mm2() > 0.05 && t.normal().dot(d).abs() > 0.1);
            let scale = libm::exp2(f64::from(power));
            let by = by * scale;
            let w = [u, (1.0 - u) * (0.01 + 0.98 * v), (1.0 - u) * (0.99 - 0.98 * v)];
            let t = moved(&t, scale, by);
            let q = t.at(w);
            let (from, to) = (q - d * (part * scale), q + d * ((1.0 - part) * scale));
            let c = t.crossing(from, to);
            let c = c.ok_or_else(|| TestCaseError::fail("missed"))?;
            prop_assert!((c.t - part).abs() < 1e-9);
            prop_assert!((0..3).all(|i| (c.barycentric[i] - w[i]).abs() < 1e-8));
            prop_assert_eq!(c.inward, t.normal().dot(d) < 0.0);
            let back = t.crossing(to, from).map(|c| c.inward);
            prop_assert_eq!(back, Some(!c.inward));
        }

        #[test]
        fn nothing_slips_between_triangles_that_share_an_edge_or_a_corner(
            centre in vec3(1.0), aim in 0.0_f64..1.0, spoke in 0_usize..6, d in vec3(1.0), by in vec3(1e4),
        ) {
            // A fan of six about `centre`; the segment aims at a point of a spoke, or at the centre itself.
            let rim = |i: usize| {
                let angle = i as f64 * std::f64::consts::TAU / 6.0;
                Vec3::new(libm::cos(angle), libm::sin(angle), 0.0) * 2.0 + by
            };
            let centre = centre * 0.3 + by;
            let target = centre + (rim(spoke) - centre) * if aim < 0.2 { 0.0 } else { aim * 0.9 };
            let d = Vec3::new(d.x * 0.3, d.y * 0.3, 1.0);
            let hits = (0..6)
                .filter(|&i| {
                    let t = Triangle { a: centre, b: rim(i), c: rim(i + 1) };
                    t.crossing(target + d, target - d).is_some_and(|c| c.inward)
                })
                .count();
            prop_assert!(hits >= 1);
        }
    }

    #[test]
    fn degenerate_triangles_answer_with_their_edges_and_corners() {
        let p = |x: f64| Vec3::new(x, 0.0, 0.0);
        for [a, b, c] in [
            [0.0, 1.0, 3.0],
            [0.0, 3.0, 1.0],
            [1.0, 0.0, 3.0],
            [3.0, 1.0, 0.0],
        ] {
            let t = Triangle {
                a: p(a),
                b: p(b),
                c: p(c),
            };
            for x in [-1.0, 0.0, 0.5, 2.0, 3.0, 5.0] {
                let found = t.closest_point(Vec3::new(x, 2.0, 0.0)).point;
                assert!(
                    found.distance(p(x.clamp(0.0, 3.0))) < 1e-15,
                    "{a} {b} {c}: {x}"
                );
            }
            assert_eq!(t.crossing(Vec3::Z, -Vec3::Z), None);
        }
        let point = Triangle {
            a: p(1.0),
            b: p(1.0),
            c: p(1.0),
        };
        assert_eq!(point.closest_point(Vec3::Y).point, p(1.0));
    }

    #[test]
    fn a_segment_in_the_plane_does_not_cross() {
        let t = Triangle {
            a: Vec3::ZERO,
            b: Vec3::X,
            c: Vec3::Y,
        };
        let (from, to) = (Vec3::new(-1.0, 0.2, 0.0), Vec3::new(2.0, 0.2, 0.0));
        assert_eq!(t.crossing(from, to), None);
        assert_eq!(t.crossing(Vec3::splat(0.1), Vec3::splat(0.1)), None);
        let nan = Vec3::new(0.1, f64::NAN, 0.1);
        assert_eq!(t.crossing(nan, to), None);
    }
}
