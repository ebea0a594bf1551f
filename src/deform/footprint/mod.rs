//! The outline of a dent on the skin, and the location ratio q of a point in it (Ji 2008, 4.4).
//!
//! | file | outline | boundary on the tangent plane |
//! |---|---|---|
//! | [`ellipse`] | [`Ellipse`]; with equal half axes the circle of 4.3 | the ellipse |
//! | [`printed`] | [`PrintedEllipse`] | that of eq. 4.13, which lies outside the ellipse |
//! | [`polar`] | [`Polar`] | radii at equal angles, joined smoothly |
//!
//! All of them take a point J to the tangent plane at the centre O along its normal N, D = J + (N·(O−J)) N (eq. 4.9), and
//! answer how far out on its ray from O the point D lies.

pub mod ellipse;
pub mod polar;
pub mod printed;

pub use ellipse::Ellipse;
pub use polar::Polar;
pub use printed::PrintedEllipse;

use crate::geom::{Aabb, Vec3, any_tangent, unit_or};

/// Below this |n·z| the skin stands so steep on the map plane (beyond 60°) that a direction carried over along z is mostly
/// its rise; see [`major_axis_on_skin`].
const STEEPEST_NORMAL_Z: f64 = 0.5;

/// An outline around the centre of a dent, in which every point has a location ratio.
pub trait Outline {
    /// The location ratio q of a point, mm: 0 at the centre, below 1 inside, 1 on the boundary, ≥ 1 outside.
    fn ratio(&self, point: Vec3) -> f64;

    /// Whether the segment between two points, mm, has a point inside. To rounding where it grazes the boundary.
    fn reaches(&self, from: Vec3, to: Vec3) -> bool;

    /// Whether all of a box is inside for certain. Answering false is always right, only slower.
    fn holds(&self, _bounds: &Aabb) -> bool {
        false
    }

    /// A ratio that one end at least of every segment of at most `edge_mm` with a point inside does not exceed.
    fn near_ratio(&self, _edge_mm: f64) -> f64 {
        f64::INFINITY
    }

    /// Whether every point of a box has more than the [`Outline::near_ratio`] of `edge_mm` for certain. Answering false is
    /// always right, only slower.
    fn excludes(&self, _bounds: &Aabb, _edge_mm: f64) -> bool {
        false
    }
}

/// Squared distance from a centre of what comes nearest to it in a box, in the two axes given; at most what it is.
#[inline(always)]
fn nearest_sq(bounds: &Aabb, centre_mm: Vec3, x: Vec3, y: Vec3) -> f64 {
    let half = (bounds.max - bounds.min) * 0.5;
    let middle = bounds.min + half - centre_mm;
    let u = (middle.dot(x).abs() - x.abs().dot(half)).max(0.0);
    let v = (middle.dot(y).abs() - y.abs().dot(half)).max(0.0);
    u * u + v * v
}

/// The kinds of footprint, by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// The basic circle everywhere, whatever an ellipse map says (Ji 2008, 4.3).
    Circle,
    /// The ellipse of the map, or the basic circle without one.
    #[default]
    Ellipse,
    /// The same ellipse with its location ratio as printed (eq. 4.13).
    EllipsePrinted,
    /// The polar boundary of the map's keys (future work 3); the ellipse where a map has none.
    Irregular,
}

impl Kind {
    /// Every kind.
    pub fn all() -> &'static [Self] {
        &[
            Self::Circle,
            Self::Ellipse,
            Self::EllipsePrinted,
            Self::Irregular,
        ]
    }

    /// Name in files, tables and the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Circle => "circle",
            Self::Ellipse => "ellipse",
            Self::EllipsePrinted => "ellipse-printed",
            Self::Irregular => "irregular",
        }
    }

    /// What it is, in a line for people.
    pub fn about(self) -> &'static str {
        match self {
            Self::Circle => "the basic circle everywhere",
            Self::Ellipse => "the ellipse of the map, true to its axes",
            Self::EllipsePrinted => {
                "the ellipse of the map by the printed ratio, which reaches beyond it"
            }
            Self::Irregular => "the polar boundary of the map's keys",
        }
    }

    /// The kind called `name`.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().iter().copied().find(|k| k.name() == name)
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
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    /// Unit vectors in all directions.
    pub fn unit() -> impl Strategy<Value = Vec3> {
        (-1.0..1.0_f64, 0.0..2.0 * PI).prop_map(|(z, phi)| {
            let r = (1.0 - z * z).sqrt();
            Vec3::new(r * phi.cos(), r * phi.sin(), z)
        })
    }

    /// Holds `reaches` against 2000 points of the segment, and `holds` against 11³ points of the box between its ends.
    pub fn agrees_with_its_points(
        outline: &impl Outline,
        from: Vec3,
        to: Vec3,
    ) -> Result<(), TestCaseError> {
        let least = (0..=2000)
            .map(|i| outline.ratio(from.lerp(to, f64::from(i) / 2000.0)))
            .fold(f64::INFINITY, f64::min);
        if (least - 1.0).abs() > 1e-4 {
            prop_assert_eq!(outline.reaches(from, to), least < 1.0, "least q {}", least);
        }
        let bounds = Aabb::of_points([from, to]);
        let near = outline.near_ratio(from.distance(to));
        let ends = [from, to].map(|p| outline.ratio(p));
        prop_assert!(
            least >= 1.0 || ends.iter().any(|&q| q <= near),
            "{} not {}",
            near,
            ends[0]
        );
        for edge_mm in [0.01, 0.7] {
            if outline.excludes(&bounds, edge_mm) {
                prop_assert!(least > outline.near_ratio(edge_mm));
            }
        }
        if outline.holds(&bounds) {
            let share = |i: usize| (i % 11) as f64 / 10.0;
            for i in 0..11 * 11 * 11 {
                let t = Vec3::new(share(i), share(i / 11), share(i / 121));
                let q = outline.ratio(from + (to - from) * t);
                prop_assert!(q < 1.0, "q {} at {}", q, t);
            }
        }
        Ok(())
    }

    #[test]
    fn every_kind_is_found_by_its_name() {
        for &kind in Kind::all() {
            assert_eq!(Kind::named(kind.name()), Some(kind));
            assert!(!kind.about().is_empty());
        }
        assert_eq!(Kind::named("square"), None);
    }

    proptest! {
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
    fn a_wall_that_faces_the_direction_has_some_tangent() {
        assert_eq!(major_axis_on_skin(Vec3::X, 0.0).dot(Vec3::X), 0.0);
    }
}
