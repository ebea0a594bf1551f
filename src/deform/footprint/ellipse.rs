//! The true ellipse.

use super::{Outline, major_axis_on_skin, nearest_sq};
use crate::geom::{Aabb, Vec3, unit_or};

/// The true ellipse q² = (u/a)² + (v/b)² in its own axes on the tangent plane at its centre.
///
/// A point J off the plane is projected on it along the normal N first, D = J + (N·(O−J)) N (Ji 2008, eq. 4.9). As the axes
/// lie in the plane, u and v of D and of J are the same, so D is never formed. No 0/0 at the centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    centre_mm: Vec3,
    /// Unit major axis over the half major axis, 1/mm.
    major_per_mm: Vec3,
    /// Unit minor axis over the half minor axis, 1/mm.
    minor_per_mm: Vec3,
}

impl Ellipse {
    /// An ellipse on the tangent plane at `centre_mm` with the outward unit `normal`.
    ///
    /// The half axes are lengths on the skin, mm; `angle_rad` is the direction of the major one on the map plane from x
    /// (axial; see [`major_axis_on_skin`]). `None` when it is empty: a half axis that is not positive, or anything not
    /// finite.
    pub fn new(
        centre_mm: Vec3,
        normal: Vec3,
        half_major_mm: f64,
        half_minor_mm: f64,
        angle_rad: f64,
    ) -> Option<Self> {
        let normal = unit_or(normal, Vec3::ZERO);
        let major = major_axis_on_skin(normal, angle_rad);
        let ellipse = Self {
            centre_mm,
            major_per_mm: major / half_major_mm,
            minor_per_mm: normal.cross(major) / half_minor_mm,
        };
        let sound = half_major_mm > 0.0
            && half_minor_mm > 0.0
            && half_major_mm.is_finite()
            && half_minor_mm.is_finite()
            && angle_rad.is_finite()
            && normal != Vec3::ZERO
            && centre_mm.is_finite()
            && ellipse.major_per_mm.is_finite()
            && ellipse.minor_per_mm.is_finite();
        sound.then_some(ellipse)
    }

    /// The same ellipse `scale` times as large; `None` when that is empty.
    pub fn scaled(&self, scale: f64) -> Option<Self> {
        let scaled = Self {
            centre_mm: self.centre_mm,
            major_per_mm: self.major_per_mm / scale,
            minor_per_mm: self.minor_per_mm / scale,
        };
        let sound =
            scale > 0.0 && scaled.major_per_mm.is_finite() && scaled.minor_per_mm.is_finite();
        sound.then_some(scaled)
    }

    fn in_axes(&self, point: Vec3) -> (f64, f64) {
        let r = point - self.centre_mm;
        (r.dot(self.major_per_mm), r.dot(self.minor_per_mm))
    }

    /// The square of the most that half an edge can be long in these axes.
    fn half_edge_sq(&self, edge_mm: f64) -> f64 {
        let (x, y) = (self.major_per_mm, self.minor_per_mm);
        edge_mm * edge_mm * 0.25 * x.length_squared().max(y.length_squared())
    }
}

impl Outline for Ellipse {
    #[inline]
    fn ratio(&self, point: Vec3) -> f64 {
        let (u, v) = self.in_axes(point);
        (u * u + v * v).sqrt()
    }

    /// The ellipse is the unit circle in its scaled axes, and projection keeps segments straight.
    fn reaches(&self, from: Vec3, to: Vec3) -> bool {
        let (u, v) = self.in_axes(from);
        let (w, z) = self.in_axes(to);
        let (du, dv) = (w - u, z - v);
        let length_sq = du * du + dv * dv;
        let t = if length_sq > 0.0 {
            (-(u * du + v * dv) / length_sq).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let (cu, cv) = (u + t * du, v + t * dv);
        cu * cu + cv * cv < 1.0
    }

    /// By the largest |u| and |v| in the box; a billionth is left for rounding.
    #[inline]
    fn holds(&self, bounds: &Aabb) -> bool {
        let half = (bounds.max - bounds.min) * 0.5;
        let (u, v) = self.in_axes(bounds.min + half);
        let u = u.abs() + self.major_per_mm.abs().dot(half);
        let v = v.abs() + self.minor_per_mm.abs().dot(half);
        u * u + v * v < 1.0 - 1e-9
    }

    /// The foot of the centre on the segment splits it: one part is no longer than half of it.
    #[inline]
    fn near_ratio(&self, edge_mm: f64) -> f64 {
        ((1.0 + self.half_edge_sq(edge_mm)) * (1.0 + 1e-9)).sqrt()
    }

    #[inline]
    fn excludes(&self, bounds: &Aabb, edge_mm: f64) -> bool {
        let (centre_mm, x, y) = (self.centre_mm, self.major_per_mm, self.minor_per_mm);
        nearest_sq(bounds, centre_mm, x, y) > (1.0 + self.half_edge_sq(edge_mm)) * (1.0 + 1e-8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deform::footprint::tests::{agrees_with_its_points, unit};
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn angles_and_axes_that_are_none_have_no_ellipse() {
        for bad in [f64::NAN, f64::INFINITY] {
            for (major, minor, angle) in [(5.0, 4.0, bad), (bad, 4.0, 0.3), (5.0, bad, 0.3)] {
                let made = Ellipse::new(Vec3::ZERO, Vec3::Z, major, minor, angle);
                assert_eq!(made, None, "{major} × {minor}, {angle}");
            }
        }
    }

    proptest! {
        #[test]
        fn q_is_the_formula_of_the_projected_point(
            n in unit(), angle in -4.0..4.0_f64, a in 1.0..200.0_f64, b in 1.0..200.0_f64,
            o in prop::array::uniform3(-200.0..200.0_f64), j in prop::array::uniform3(-200.0..200.0_f64),
        ) {
            let (o, j) = (Vec3::from(o), Vec3::from(j));
            let ellipse = Ellipse::new(o, n, a, b, angle).unwrap();
            let d = j + n * n.dot(o - j);
            let major = major_axis_on_skin(n, angle);
            let minor = n.cross(major);
            let (u, v) = ((d - o).dot(major), (d - o).dot(minor));
            let q = ((u / a).powi(2) + (v / b).powi(2)).sqrt();
            prop_assert!((ellipse.ratio(j) - q).abs() <= 1e-11 * (1.0 + q));
        }

        #[test]
        fn a_segment_reaches_in_when_one_of_its_points_does(
            from in prop::array::uniform3(-3.0..3.0_f64), to in prop::array::uniform3(-3.0..3.0_f64),
        ) {
            let (from, to) = (Vec3::from(from), Vec3::from(to));
            let ellipse = Ellipse::new(Vec3::ZERO, Vec3::Z, 2.0, 1.0, 0.3).unwrap();
            agrees_with_its_points(&ellipse, from, to)?;
        }
    }

    #[test]
    fn a_box_is_held_only_when_all_of_it_is_inside() {
        let e = Ellipse::new(Vec3::ZERO, Vec3::Z, 30.0, 10.0, 0.0).unwrap();
        let held = |x: f64, y: f64| {
            let corner = Vec3::new(x, y, 3.0);
            e.holds(&Aabb::of_points([corner, -corner]))
        };
        assert!(held(20.0, 7.0) && held(0.0, 9.99) && held(0.0, 0.0));
        assert!(!held(30.0, 0.0) && !held(25.0, 8.0) && !held(0.0, 11.0));
        assert!(!e.holds(&Aabb::of_points([Vec3::X * 100.0])));
    }

    #[test]
    fn q_is_one_at_the_ends_of_both_axes_and_zero_at_the_centre() {
        let e = Ellipse::new(Vec3::ONE, Vec3::Z, 30.0, 10.0, FRAC_PI_2).unwrap();
        assert_eq!(e.ratio(Vec3::ONE), 0.0);
        assert!((e.ratio(Vec3::new(1.0, 31.0, 5.0)) - 1.0).abs() < 1e-15);
        assert!((e.ratio(Vec3::new(11.0, 1.0, -9.0)) - 1.0).abs() < 1e-15);
        let half = e.scaled(0.5).unwrap();
        assert!((half.ratio(Vec3::new(1.0, 16.0, 0.0)) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn empty_and_broken_ellipses_are_none() {
        let make = |a, b, n| Ellipse::new(Vec3::ZERO, n, a, b, 0.0);
        assert!(make(0.0, 1.0, Vec3::Z).is_none());
        assert!(make(1.0, -1.0, Vec3::Z).is_none());
        assert!(make(f64::NAN, 1.0, Vec3::Z).is_none());
        assert!(make(1.0, f64::NAN, Vec3::Z).is_none());
        assert!(make(1.0, 1.0, Vec3::ZERO).is_none());
        assert!(make(1.0, 1.0, Vec3::splat(f64::NAN)).is_none());
        let sound = make(1.0, 1.0, Vec3::Z).unwrap();
        assert!(sound.scaled(0.0).is_none());
        assert!(sound.scaled(f64::NAN).is_none());
    }
}
