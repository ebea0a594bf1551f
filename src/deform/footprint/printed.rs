//! The ellipse by the printed location ratio (Ji 2008, eq. 4.13).

use super::{Outline, major_axis_on_skin, nearest_sq};
use crate::geom::{Aabb, Vec3, unit_or};

/// Halvings that bring an interval of length 1 below the spacing of its numbers.
const HALVINGS: usize = 54;

/// The location ratio as printed, q = |OD|² / √((OD·OA)² (1 − t²) + |OD|² a² t²), with a = |OA| and t = b/a.
///
/// The derivation (eq. 4.10 to 4.13) takes the polar angle β of D for the parametric angle of the ellipse. So q = 1 is not
/// the ellipse but the curve at the distance √(a² cos²β + b² sin²β): outside of it everywhere but at the ends of the axes,
/// 25 % too far out where it is worst for an axis ratio of 2, and no longer convex beyond a ratio of √2. It is kept so that
/// published results can be reproduced; [`Ellipse`](super::Ellipse) is what the text means.
///
/// Where D = O the printed formula is 0/0. Here it is 0, its limit from every side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrintedEllipse {
    centre_mm: Vec3,
    major: Vec3,
    minor: Vec3,
    half_major_sq_mm2: f64,
    half_minor_sq_mm2: f64,
}

impl PrintedEllipse {
    /// The outline on the tangent plane at `centre_mm` with the outward unit `normal`.
    ///
    /// The half axes are lengths on the skin, mm; `angle_rad` is the direction of the major one on the map plane from x
    /// (axial; see [`major_axis_on_skin`]). `None` when it is empty: a half axis that is not positive, one whose square is
    /// no number, or anything not finite.
    pub fn new(
        centre_mm: Vec3,
        normal: Vec3,
        half_major_mm: f64,
        half_minor_mm: f64,
        angle_rad: f64,
    ) -> Option<Self> {
        let normal = unit_or(normal, Vec3::ZERO);
        let major = major_axis_on_skin(normal, angle_rad);
        let outline = Self {
            centre_mm,
            major,
            minor: normal.cross(major),
            half_major_sq_mm2: half_major_mm * half_major_mm,
            half_minor_sq_mm2: half_minor_mm * half_minor_mm,
        };
        let sound = half_major_mm > 0.0
            && half_minor_mm > 0.0
            && angle_rad.is_finite()
            && normal != Vec3::ZERO
            && centre_mm.is_finite();
        outline.with_axes().filter(|_| sound)
    }

    /// The same outline `scale` times as large; `None` when that is empty.
    pub fn scaled(&self, scale: f64) -> Option<Self> {
        let scaled = Self {
            half_major_sq_mm2: self.half_major_sq_mm2 * scale * scale,
            half_minor_sq_mm2: self.half_minor_sq_mm2 * scale * scale,
            ..*self
        };
        scaled.with_axes().filter(|_| scale > 0.0)
    }

    fn with_axes(self) -> Option<Self> {
        let sound = |sq: f64| sq.is_normal();
        (sound(self.half_major_sq_mm2) && sound(self.half_minor_sq_mm2)).then_some(self)
    }

    /// Distance of the boundary from the centre, mm, at `beta_rad` from the major axis.
    pub fn radius_mm(&self, beta_rad: f64) -> f64 {
        let (sin, cos) = libm::sincos(beta_rad);
        (self.half_major_sq_mm2 * cos * cos + self.half_minor_sq_mm2 * sin * sin).sqrt()
    }

    fn in_axes(&self, point: Vec3) -> (f64, f64) {
        let r = point - self.centre_mm;
        (r.dot(self.major), r.dot(self.minor))
    }

    /// (OD·OA)² (1 − t²) + |OD|² a² t², written out: what is left is a² u² + b² v².
    #[inline(always)]
    fn weighed(&self, u: f64, v: f64, w: f64, z: f64) -> f64 {
        self.half_major_sq_mm2 * u * w + self.half_minor_sq_mm2 * v * z
    }

    #[inline(always)]
    fn ratio_at(&self, u: f64, v: f64) -> f64 {
        let r_sq = u * u + v * v;
        // min() turns ∞/∞ far out into ∞.
        let q = (r_sq / self.weighed(u, v, u, v).sqrt()).min(f64::INFINITY);
        // What is no place is outside.
        if r_sq == 0.0 { 0.0 } else { q }
    }
}

impl Outline for PrintedEllipse {
    #[inline]
    fn ratio(&self, point: Vec3) -> f64 {
        let (u, v) = self.in_axes(point);
        self.ratio_at(u, v)
    }

    /// Inside is where h = |p|⁴ − a² u² − b² v² is below 0; along a segment h has at most two minima, which are found
    /// between the zeros of its second derivative.
    fn reaches(&self, from: Vec3, to: Vec3) -> bool {
        let (u, v) = self.in_axes(from);
        let (w, z) = self.in_axes(to);
        if self.ratio_at(u, v) < 1.0 || self.ratio_at(w, z) < 1.0 {
            return true;
        }
        let (du, dv) = (w - u, z - v);
        let (a, b, c) = (u * u + v * v, u * du + v * dv, du * du + dv * dv);
        if !(c > 0.0 && c.is_finite()) {
            return false;
        }
        let nearest = (-b / c).clamp(0.0, 1.0);
        let nearest_sq = a + nearest * (2.0 * b + nearest * c);
        let (outer, inner) = (
            self.half_major_sq_mm2.max(self.half_minor_sq_mm2),
            self.half_major_sq_mm2.min(self.half_minor_sq_mm2),
        );
        // The boundary runs between two circles.
        if nearest_sq >= outer || nearest_sq < inner {
            return nearest_sq < inner;
        }
        let inside = |s: f64| self.ratio_at(u + s * du, v + s * dv) < 1.0;
        let (wb, wc) = (self.weighed(u, v, du, dv), self.weighed(du, dv, du, dv));
        // Half of dh/ds, and where d²h/ds² is 0: with x = b + c s it is 12 x² − 2 wc + 4 (a c − b²).
        let slope = |s: f64| 2.0 * (a + s * (2.0 * b + s * c)) * (b + c * s) - wb - wc * s;
        let x = ((wc - 2.0 * (a * c - b * b)) / 6.0).max(0.0).sqrt();
        let turns = [-x, x].map(|x| ((x - b) / c).clamp(0.0, 1.0));
        let pieces = [(0.0, turns[0]), (turns[0], turns[1]), (turns[1], 1.0)];
        pieces.into_iter().any(|(mut lo, mut hi)| {
            if !(slope(lo) < 0.0 && slope(hi) > 0.0) {
                return false;
            }
            for _ in 0..HALVINGS {
                let middle = 0.5 * (lo + hi);
                if slope(middle) < 0.0 {
                    lo = middle;
                } else {
                    hi = middle;
                }
            }
            inside(0.5 * (lo + hi))
        })
    }

    /// By the corners of the rectangle of |u| and |v| that the box can have: over u² and v² the function h of
    /// [`Outline::reaches`] is convex, so it is largest at a corner. A billionth is left for rounding.
    #[inline]
    fn holds(&self, bounds: &Aabb) -> bool {
        let half = (bounds.max - bounds.min) * 0.5;
        let (u, v) = self.in_axes(bounds.min + half);
        let (hu, hv) = (self.major.abs().dot(half), self.minor.abs().dot(half));
        let (u, v) = (u.abs(), v.abs());
        let inside = |u: f64, v: f64| self.ratio_at(u, v) < 1.0 - 1e-9;
        let (near_u, near_v) = ((u - hu).max(0.0), (v - hv).max(0.0));
        inside(u + hu, v + hv)
            && inside(near_u, v + hv)
            && inside(u + hu, near_v)
            && inside(near_u, near_v)
    }

    /// By the most that q can rise per mm.
    #[inline]
    fn near_ratio(&self, edge_mm: f64) -> f64 {
        let (a_sq, b_sq) = (self.half_major_sq_mm2, self.half_minor_sq_mm2);
        let least_sq = a_sq.min(b_sq);
        // |∇q|² = 1/R² + (R′/R²)² with R² between a² and b² and 2 |R R′| at most |a² − b²|.
        let turn = (a_sq - b_sq) / (2.0 * least_sq);
        let rise = ((1.0 + turn * turn) / least_sq).sqrt();
        (1.0 + 0.5 * edge_mm * rise) * (1.0 + 1e-9)
    }

    /// What lies beyond the larger axis by a share of it has at least a ratio beyond 1 by that share.
    #[inline]
    fn excludes(&self, bounds: &Aabb, edge_mm: f64) -> bool {
        let most_sq = self.half_major_sq_mm2.max(self.half_minor_sq_mm2);
        let near = self.near_ratio(edge_mm) * (1.0 + 1e-8);
        nearest_sq(bounds, self.centre_mm, self.major, self.minor) > most_sq * near * near
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deform::footprint::Ellipse;
    use crate::deform::footprint::tests::{agrees_with_its_points, unit};
    use proptest::prelude::*;

    const TURN: f64 = 2.0 * std::f64::consts::PI;

    /// It was the centre, so that places which only fill up a block were displaced, and the drawing of them panicked.
    #[test]
    fn what_is_no_place_is_outside() {
        let outline = PrintedEllipse::new(Vec3::ZERO, Vec3::Z, 20.0, 10.0, 0.3).unwrap();
        assert!(outline.ratio(Vec3::NAN) >= 1.0);
        assert_eq!(outline.ratio(Vec3::ZERO), 0.0);
    }

    proptest! {
        #[test]
        fn q_is_eq_4_13_of_the_projected_point(
            n in unit(), angle in -4.0..4.0_f64, a in 1.0..200.0_f64, t in 0.05..1.0_f64,
            o in prop::array::uniform3(-200.0..200.0_f64), j in prop::array::uniform3(-200.0..200.0_f64),
        ) {
            let (o, j) = (Vec3::from(o), Vec3::from(j));
            let outline = PrintedEllipse::new(o, n, a, t * a, angle).unwrap();
            let od = j + n * n.dot(o - j) - o;
            let oa = major_axis_on_skin(n, angle) * a;
            let (od_sq, od_oa) = (od.length_squared(), od.dot(oa));
            let q = od_sq / (od_oa * od_oa * (1.0 - t * t) + od_sq * a * a * t * t).sqrt();
            prop_assert!((outline.ratio(j) - q).abs() <= 1e-9 * (1.0 + q));
        }

        #[test]
        fn its_boundary_lies_outside_the_ellipse_but_for_the_ends_of_the_axes(
            a in 1.0..200.0_f64, b in 1.0..200.0_f64, beta in 0.0..TURN,
        ) {
            let printed = PrintedEllipse::new(Vec3::ZERO, Vec3::Z, a, b, 0.0).unwrap();
            let ellipse = Ellipse::new(Vec3::ZERO, Vec3::Z, a, b, 0.0).unwrap();
            let at = Vec3::new(beta.cos(), beta.sin(), 0.0) * printed.radius_mm(beta);
            prop_assert!((printed.ratio(at) - 1.0).abs() < 1e-12);
            prop_assert!(ellipse.ratio(at) >= 1.0 - 1e-12);
        }

        #[test]
        fn segments_and_boxes_are_answered_as_their_points_are(
            a in 0.5..3.0_f64, b in 0.2..3.0_f64, angle in 0.0..TURN,
            from in prop::array::uniform3(-3.0..3.0_f64), to in prop::array::uniform3(-3.0..3.0_f64),
        ) {
            let outline = PrintedEllipse::new(Vec3::ZERO, Vec3::Z, a, b, angle).unwrap();
            agrees_with_its_points(&outline, Vec3::from(from), Vec3::from(to))?;
            agrees_with_its_points(&outline, Vec3::from(from) * 0.3, Vec3::from(to) * 0.3)?;
        }
    }

    #[test]
    fn the_waist_of_a_slender_outline_is_not_filled() {
        // At ratio 5 the boundary rises from b at the waist: a segment just above it crosses both lobes, its middle none.
        let o = PrintedEllipse::new(Vec3::ZERO, Vec3::Z, 5.0, 1.0, 0.0).unwrap();
        let at = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        assert!(o.ratio(at(0.0, 1.1)) > 1.0 && o.ratio(at(1.5, 1.1)) < 1.0);
        assert!(!o.reaches(at(-0.1, 1.1), at(0.1, 1.1)));
        assert!(o.reaches(at(0.0, 1.1), at(4.9, 1.3)));
        assert!(o.reaches(at(-5.0, 2.0), at(5.0, 2.0)));
        assert!(!o.reaches(at(-5.0, 2.6), at(5.0, 2.6)));
        assert!(!o.holds(&Aabb::of_points([at(-1.5, 0.0), at(1.5, 1.1)])));
        assert!(o.holds(&Aabb::of_points([at(1.2, 0.0), at(2.0, 1.1)])));
    }

    #[test]
    fn with_equal_axes_it_is_the_circle_and_at_the_centre_it_is_0() {
        let o = PrintedEllipse::new(Vec3::ONE, Vec3::Z, 30.0, 30.0, 0.7).unwrap();
        let circle = Ellipse::new(Vec3::ONE, Vec3::Z, 30.0, 30.0, 0.7).unwrap();
        for (x, y) in [(3.0, 4.0), (-20.0, 7.0), (0.0, 31.0)] {
            let at = Vec3::new(x, y, 2.0);
            assert!((o.ratio(at) - circle.ratio(at)).abs() < 1e-14);
        }
        assert_eq!(o.ratio(Vec3::ONE), 0.0);
        assert!(o.ratio(Vec3::ONE + Vec3::X * 1e-120) < 1e-100);
        assert_eq!(o.ratio(Vec3::X * 1e200), f64::INFINITY);
        let half = o.scaled(0.5).unwrap();
        assert!((half.ratio(Vec3::new(16.0, 1.0, 0.0)) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn empty_and_broken_outlines_are_none() {
        let make = |a, b, n, angle| PrintedEllipse::new(Vec3::ZERO, n, a, b, angle);
        for (a, b) in [
            (0.0, 1.0),
            (1.0, -1.0),
            (f64::NAN, 1.0),
            (1.0, f64::INFINITY),
            (1e-200, 1.0),
        ] {
            assert!(make(a, b, Vec3::Z, 0.0).is_none(), "{a} {b}");
        }
        assert!(make(1.0, 1.0, Vec3::ZERO, 0.0).is_none());
        assert!(make(1.0, 1.0, Vec3::splat(f64::NAN), 0.0).is_none());
        assert!(make(1.0, 1.0, Vec3::Z, f64::NAN).is_none());
        assert!(PrintedEllipse::new(Vec3::NAN, Vec3::Z, 1.0, 1.0, 0.0).is_none());
        let sound = make(2.0, 1.0, Vec3::Z, 0.0).unwrap();
        assert!(
            sound.scaled(0.0).is_none()
                && sound.scaled(-1.0).is_none()
                && sound.scaled(f64::NAN).is_none()
        );
    }
}
