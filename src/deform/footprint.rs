//! The outline of a dent on the skin, and the location ratio q of a point in it (Ji 2008, 4.4).

use crate::geom::{Aabb, Vec3, any_tangent, unit_or};

/// Below this |n·z| the skin stands so steep on the map plane (beyond 60°) that a direction carried over along z is mostly
/// its rise; see [`major_axis_on_skin`].
const STEEPEST_NORMAL_Z: f64 = 0.5;

/// An outline around the centre of a dent, in which every point has a location ratio.
pub trait Outline {
    /// The location ratio q of a point, mm: 0 at the centre, below 1 inside, 1 on the boundary, ≥ 1 outside.
    fn ratio(&self, point: Vec3) -> f64;

    /// Whether the segment between two points, mm, has a point inside.
    fn reaches(&self, from: Vec3, to: Vec3) -> bool;

    /// Whether all of a box is inside for certain. Answering false is always right, only slower.
    fn holds(&self, _bounds: &Aabb) -> bool {
        false
    }
}

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
}

/// The direction `angle_rad` of the map plane (from x), carried over along z to the tangent plane with the unit `normal`.
///
/// Unit length: lengths of an ellipse are measured on the skin, so only the direction is carried over and the basic circle
/// is a circle on any slope. The rise −(d·n)/n_z grows without bound where the normal comes near the map plane (the
/// flanks) and its sign there hangs on rounding. So beyond 60° of tilt it is replaced by −(d·n) n_z / 0.25, which joins on
/// continuously and falls back to 0, and the direction is then projected along the normal: on a vertical wall the major
/// axis is the map direction itself, flattened on the wall. Where even that has no direction (a wall that faces along
/// `angle_rad`) any tangent is taken.
pub fn major_axis_on_skin(normal: Vec3, angle_rad: f64) -> Vec3 {
    let (sin, cos) = libm::sincos(angle_rad);
    let on_map = Vec3::new(cos, sin, 0.0);
    let steep_sq = (normal.z * normal.z).max(STEEPEST_NORMAL_Z * STEEPEST_NORMAL_Z);
    let raised = on_map - Vec3::Z * (on_map.dot(normal) * normal.z / steep_sq);
    // On gentle slopes `raised` lies in the plane already and this only removes its rounding.
    let tangent = raised - normal * raised.dot(normal);
    if tangent.length_squared() > 1e-18 {
        unit_or(tangent, Vec3::X)
    } else {
        any_tangent(normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn unit() -> impl Strategy<Value = Vec3> {
        (-1.0..1.0_f64, 0.0..2.0 * PI).prop_map(|(z, phi)| {
            let r = (1.0 - z * z).sqrt();
            Vec3::new(r * phi.cos(), r * phi.sin(), z)
        })
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
        fn the_major_axis_is_a_unit_tangent_above_its_map_direction(n in unit(), angle in -4.0..4.0_f64) {
            let d = major_axis_on_skin(n, angle);
            prop_assert!((d.length() - 1.0).abs() < 1e-12);
            prop_assert!(d.dot(n).abs() < 1e-9);
            if n.z.abs() >= STEEPEST_NORMAL_Z {
                let (s, c) = angle.sin_cos();
                prop_assert!((d.x * s - d.y * c).abs() < 1e-12, "seen along z it keeps its direction");
                prop_assert!(d.x * c + d.y * s > 0.0);
            }
        }

        #[test]
        fn a_segment_reaches_in_when_one_of_its_points_does(
            from in prop::array::uniform3(-3.0..3.0_f64), to in prop::array::uniform3(-3.0..3.0_f64),
        ) {
            let (from, to) = (Vec3::from(from), Vec3::from(to));
            let ellipse = Ellipse::new(Vec3::ZERO, Vec3::Z, 2.0, 1.0, 0.3).unwrap();
            let least = (0..=2000)
                .map(|i| ellipse.ratio(from.lerp(to, i as f64 / 2000.0)))
                .fold(f64::INFINITY, f64::min);
            if (least - 1.0).abs() > 1e-5 {
                prop_assert_eq!(ellipse.reaches(from, to), least < 1.0);
            }
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
    fn the_axis_turns_continuously_from_the_back_over_the_flank_to_the_chest() {
        for angle in [0.0, 0.4, FRAC_PI_2, 2.0] {
            let mut last = None;
            for i in 0..=18_000 {
                // Slightly off the x–z plane, where the projection along z alone would swing round.
                let tilt = PI * i as f64 / 18_000.0;
                let n = unit_or(Vec3::new(tilt.sin(), 0.05, tilt.cos()), Vec3::Z);
                let axis = major_axis_on_skin(n, angle);
                if let Some(last) = last {
                    let turned = axis.cross(last).length();
                    assert!(turned < 0.02, "angle {angle}, tilt {tilt}: turned {turned}");
                }
                last = Some(axis);
            }
        }
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
        assert_eq!(major_axis_on_skin(Vec3::X, 0.0).dot(Vec3::X), 0.0);
    }
}
