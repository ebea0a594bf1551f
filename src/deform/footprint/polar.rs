//! An irregular outline: radii round the centre (Ji 2008, future work 3).

use super::{Outline, major_axis_on_skin, nearest_sq};
use crate::geom::{Aabb, Monotone, Vec2, Vec3, unit_or};
use std::f64::consts::FRAC_PI_2;
use std::sync::{Arc, LazyLock};

/// Directions from the centre in which the boundary is sampled; a multiple of 4.
const DIRECTIONS: usize = 512;
/// The same per quarter turn.
const PER_QUARTER: usize = DIRECTIONS / 4;
/// Sectors that share one bound of [`Shape::nearest_sq_mm2`].
const PER_RUN: usize = 8;
/// Fewest radii that bound an area whatever they are.
pub const FEWEST_RADII: usize = 3;

/// A boundary given by its radii at equal angles, q = r / R(θ).
///
/// The angle θ runs on the tangent plane from the map's x direction, carried over to the skin like a major axis
/// ([`major_axis_on_skin`]), counter-clockwise as seen from outside. Between the radii R(θ) is a periodic monotone cubic
/// (Fritsch & Carlson 1980): its slope is continuous, and it never leaves the range of the two radii on either side, so no
/// bulge is drawn that nobody asked for and the radius stays positive.
///
/// R is sampled once, in 512 directions, which are joined by straight lines: a ratio then costs no arc tangent. The polygon
/// departs from a circle by less than 3.1e-5 of its radius (4 µm at 140 mm). Finer detail than its sides is lost.
#[derive(Clone, Debug, PartialEq)]
pub struct Polar {
    centre_mm: Vec3,
    /// The x and y directions of the tangent plane over the scale.
    x: Vec3,
    y: Vec3,
    shape: Arc<Shape>,
}

/// The polygon on the tangent plane, shared by outlines of different size.
#[derive(Debug, PartialEq)]
struct Shape {
    /// Per sector the vector c, 1/mm, with q = c·p there.
    sectors: [Vec2; DIRECTIONS],
    /// Per run of sectors the square of the least distance of its sides' lines from the centre, mm².
    nearest_sq_mm2: [f64; DIRECTIONS / PER_RUN],
    /// Squares of the radii of the circles inside and around, mm².
    inner_sq_mm2: f64,
    outer_sq_mm2: f64,
}

/// Where a sector begins.
struct Corner {
    direction: Vec2,
    angle_rad: f64,
}

/// The corners lie on the square |u| + |v| = 1 in equal steps: the place of a point among them is found by one division.
static CORNERS: LazyLock<Vec<Corner>> = LazyLock::new(|| {
    let corner = |i: usize| {
        let along = (i % PER_QUARTER) as f64 / PER_QUARTER as f64;
        let first = Vec2::new(1.0 - along, along);
        Corner {
            direction: (0..i / PER_QUARTER).fold(first / first.length(), |p, _| p.perp()),
            angle_rad: libm::atan2(along, 1.0 - along) + (i / PER_QUARTER) as f64 * FRAC_PI_2,
        }
    };
    (0..DIRECTIONS).map(corner).collect()
});

/// The sector in which a place of the tangent plane lies; any for the centre and for what is no number.
#[inline(always)]
fn sector(p: Vec2) -> usize {
    let rise = p.y / (p.x.abs() + p.y.abs());
    let quarters = if p.x < 0.0 {
        2.0 - rise
    } else if rise < 0.0 {
        4.0 + rise
    } else {
        rise
    };
    // To 32 bits a processor converts in one instruction.
    (quarters * PER_QUARTER as f64) as i32 as usize % DIRECTIONS
}

impl Shape {
    fn new(boundary_mm: &[f64]) -> Option<Self> {
        let sound = |r: &f64| *r > 0.0 && r.is_finite();
        if boundary_mm.len() < FEWEST_RADII || !boundary_mm.iter().all(sound) {
            return None;
        }
        let radius_mm = Monotone::periodic(boundary_mm, 4.0 * FRAC_PI_2)?;
        let mut points = [Vec2::ZERO; DIRECTIONS];
        let angles = CORNERS.iter().map(|c| c.angle_rad);
        for ((point, corner), radius_mm) in points
            .iter_mut()
            .zip(&*CORNERS)
            .zip(radius_mm.at_each(angles))
        {
            *point = corner.direction * radius_mm;
        }
        let sectors: [Vec2; DIRECTIONS] = std::array::from_fn(|i| {
            let (from, to) = (points[i], points[(i + 1) % DIRECTIONS]);
            (from - to).perp() / from.perp_dot(to)
        });
        let nearest_sq_mm2 = std::array::from_fn(|run| {
            let sides = sectors[run * PER_RUN..(run + 1) * PER_RUN].iter();
            let most_sq = sides.map(|c| c.length_squared()).fold(0.0, f64::max);
            1.0 / most_sq
        });
        let inner_sq_mm2 = nearest_sq_mm2.iter().copied().fold(f64::INFINITY, f64::min);
        let outer_sq_mm2 = points
            .iter()
            .map(|p| p.length_squared())
            .fold(0.0, f64::max);
        let sound =
            sectors.iter().all(|c| c.is_finite()) && inner_sq_mm2 > 0.0 && outer_sq_mm2.is_finite();
        sound.then_some(Self {
            sectors,
            nearest_sq_mm2,
            inner_sq_mm2,
            outer_sq_mm2,
        })
    }

    #[inline(always)]
    fn ratio(&self, p: Vec2) -> f64 {
        self.sectors[sector(p)].dot(p).min(f64::INFINITY)
    }

    /// Least q where the segment crosses from one sector to the next. Between, q is linear.
    fn least_at_crossings(&self, from: Vec2, to: Vec2) -> f64 {
        let (first, last) = (sector(from), sector(to));
        let turns_left = from.perp_dot(to) >= 0.0;
        let (start, end) = if turns_left {
            (first, last)
        } else {
            (last, first)
        };
        let crossed = (end + DIRECTIONS - start) % DIRECTIONS;
        if crossed > DIRECTIONS / 2 + 1 {
            // It passes through the centre but for rounding.
            return 0.0;
        }
        let mut least = f64::INFINITY;
        for step in 1..=crossed {
            let corner = CORNERS[(start + step) % DIRECTIONS].direction;
            let (f, t) = (corner.perp_dot(from), corner.perp_dot(to));
            if f != t {
                let at = from + (to - from) * (f / (f - t)).clamp(0.0, 1.0);
                least = least.min(self.ratio(at));
            }
        }
        least
    }

    /// Square of the least distance of the boundary in the directions of the points, each of which must lie within half a
    /// turn of `middle`, mm². Never above the true one.
    fn nearest_towards(&self, middle: Vec2, points: [Vec2; 4]) -> f64 {
        let half_turn = DIRECTIONS / 2;
        // Sectors from the one opposite to the middle: no wrap within half a turn to either side.
        let start = sector(middle) + half_turn;
        let from_start = points.map(|p| (sector(p) + DIRECTIONS - start % DIRECTIONS) % DIRECTIONS);
        let first = from_start.into_iter().fold(usize::MAX, usize::min);
        let last = from_start.into_iter().fold(0, usize::max);
        let run = |from_start: usize| (start + from_start) / PER_RUN;
        (run(first)..=run(last))
            .map(|r| self.nearest_sq_mm2[r % (DIRECTIONS / PER_RUN)])
            .fold(f64::INFINITY, f64::min)
    }
}

impl Polar {
    /// The outline on the tangent plane at `centre_mm` with the outward unit `normal`, whose boundary has the radii
    /// `boundary_mm`, mm on the skin, at the angles 0, 1/n, 2/n … of a turn.
    ///
    /// `None` when it is empty: fewer than [`FEWEST_RADII`] radii, one that is not positive, anything not finite, or radii
    /// so far apart that the numbers between them run out.
    pub fn new(centre_mm: Vec3, normal: Vec3, boundary_mm: &[f64]) -> Option<Self> {
        let normal = unit_or(normal, Vec3::ZERO);
        if normal == Vec3::ZERO || !centre_mm.is_finite() {
            return None;
        }
        let x = major_axis_on_skin(normal, 0.0);
        Some(Self {
            centre_mm,
            x,
            y: normal.cross(x),
            shape: Arc::new(Shape::new(boundary_mm)?),
        })
    }

    /// The same outline `scale` times as large; `None` when that is empty.
    pub fn scaled(&self, scale: f64) -> Option<Self> {
        let (x, y) = (self.x / scale, self.y / scale);
        (scale > 0.0 && x.is_finite() && y.is_finite() && x != Vec3::ZERO).then(|| Self {
            centre_mm: self.centre_mm,
            x,
            y,
            shape: Arc::clone(&self.shape),
        })
    }

    /// Distance of the boundary from the centre, mm, at `theta_rad` from the x direction.
    pub fn radius_mm(&self, theta_rad: f64) -> f64 {
        let (sin, cos) = libm::sincos(theta_rad);
        1.0 / (self.shape.ratio(Vec2::new(cos, sin)) * self.x.length())
    }

    #[inline(always)]
    fn on_plane(&self, point: Vec3) -> Vec2 {
        let r = point - self.centre_mm;
        Vec2::new(r.dot(self.x), r.dot(self.y))
    }
}

impl Outline for Polar {
    #[inline]
    fn ratio(&self, point: Vec3) -> f64 {
        self.shape.ratio(self.on_plane(point))
    }

    fn reaches(&self, from: Vec3, to: Vec3) -> bool {
        let shape = &*self.shape;
        let (from, to) = (self.on_plane(from), self.on_plane(to));
        if shape.ratio(from) < 1.0 || shape.ratio(to) < 1.0 {
            return true;
        }
        let along = to - from;
        let t = -from.dot(along) / along.length_squared();
        let nearest = from + along * if t > 0.0 { t.min(1.0) } else { 0.0 };
        let nearest_sq = nearest.length_squared();
        if nearest_sq < shape.inner_sq_mm2 || nearest_sq >= shape.outer_sq_mm2 {
            return nearest_sq < shape.inner_sq_mm2;
        }
        shape.least_at_crossings(from, to) < 1.0
    }

    /// By the corner farthest from the centre of the rectangle that the box can have on the tangent plane, against the
    /// nearest boundary in the directions of the rectangle. A billionth is left for rounding.
    #[inline]
    fn holds(&self, bounds: &Aabb) -> bool {
        let shape = &*self.shape;
        let half = (bounds.max - bounds.min) * 0.5;
        let middle = self.on_plane(bounds.min + half);
        let half = Vec2::new(self.x.abs().dot(half), self.y.abs().dot(half));
        let farthest_sq = (middle.abs() + half).length_squared() * (1.0 + 1e-9);
        if farthest_sq < shape.inner_sq_mm2 {
            return true;
        }
        // With the centre inside the rectangle lies in all directions.
        let beside = middle.x.abs() > half.x || middle.y.abs() > half.y;
        if !(beside && farthest_sq < shape.outer_sq_mm2) {
            return false;
        }
        let corner = |x: f64, y: f64| middle + Vec2::new(x, y) * half;
        let corners = [
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        farthest_sq < shape.nearest_towards(middle, corners)
    }

    /// By the most that q can rise per mm, which is in the sector whose side comes nearest to the centre.
    #[inline]
    fn near_ratio(&self, edge_mm: f64) -> f64 {
        let rise_sq = self.x.length_squared() / self.shape.inner_sq_mm2;
        (1.0 + 0.5 * edge_mm * rise_sq.sqrt()) * (1.0 + 1e-9)
    }

    /// What lies beyond the farthest corner by a share of its distance has at least a ratio beyond 1 by that share.
    #[inline]
    fn excludes(&self, bounds: &Aabb, edge_mm: f64) -> bool {
        let near = self.near_ratio(edge_mm) * (1.0 + 1e-8);
        nearest_sq(bounds, self.centre_mm, self.x, self.y) > self.shape.outer_sq_mm2 * near * near
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deform::footprint::Ellipse;
    use crate::deform::footprint::tests::{agrees_with_its_points, unit};
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn radii() -> impl Strategy<Value = Vec<f64>> {
        prop::collection::vec(0.3..3.0_f64, FEWEST_RADII..24)
    }

    proptest! {
        #[test]
        fn segments_and_boxes_are_answered_as_their_points_are(
            n in unit(), radii in radii(), scale in 0.2..2.0_f64,
            from in prop::array::uniform3(-3.0..3.0_f64), to in prop::array::uniform3(-3.0..3.0_f64),
        ) {
            let outline = Polar::new(Vec3::ZERO, n, &radii).unwrap().scaled(scale).unwrap();
            agrees_with_its_points(&outline, Vec3::from(from), Vec3::from(to))?;
            agrees_with_its_points(&outline, Vec3::from(from) * 0.3, Vec3::from(to) * 0.3)?;
        }

        #[test]
        fn q_is_r_over_the_radius_between_the_two_around(n in unit(), radii in radii(), theta in 0.0..2.0 * PI, r in 0.0..9.0_f64) {
            let outline = Polar::new(Vec3::ONE, n, &radii).unwrap();
            let x = major_axis_on_skin(n, 0.0);
            let at = Vec3::ONE + (x * theta.cos() + n.cross(x) * theta.sin()) * r + n * 5.0;
            let radius = outline.radius_mm(theta);
            prop_assert!((outline.ratio(at) - r / radius).abs() < 1e-9 * (1.0 + r / radius));
            // On the side of a polygon whose corners lie on the curve.
            let curve = Monotone::periodic(&radii, 2.0 * PI).unwrap();
            let first = sector(Vec2::new(theta.cos(), theta.sin()));
            let corners = [first, (first + 1) % DIRECTIONS].map(|i| curve.at(CORNERS[i].angle_rad));
            let (least, most) = (corners[0].min(corners[1]), corners[0].max(corners[1]));
            prop_assert!(radius >= least * (2.0 / PER_QUARTER as f64).cos() * (1.0 - 1e-12));
            prop_assert!(radius <= most * (1.0 + 1e-12));
        }
    }

    #[test]
    fn the_radii_are_met_at_their_angles() {
        // Eight radii: all their directions are among those sampled.
        let radii = [140.0, 120.0, 100.0, 110.0, 150.0, 90.0, 100.0, 130.0];
        let o = Polar::new(Vec3::ZERO, Vec3::Z, &radii).unwrap();
        for (i, r) in radii.iter().enumerate() {
            let met = o.radius_mm(i as f64 * PI / 4.0);
            assert!((met - r).abs() < 1e-12 * r, "{i}: {met} for {r}");
        }
    }

    #[test]
    fn many_radii_of_an_ellipse_make_the_ellipse() {
        let (a, b) = (140.0, 103.0);
        let radius = |i: usize| {
            let (sin, cos) = (2.0 * PI * i as f64 / 180.0).sin_cos();
            1.0 / ((cos / a).powi(2) + (sin / b).powi(2)).sqrt()
        };
        let radii: Vec<f64> = (0..180).map(radius).collect();
        let n = unit_or(Vec3::new(0.2, -0.3, 0.9), Vec3::Z);
        let polar = Polar::new(Vec3::X, n, &radii).unwrap();
        let ellipse = Ellipse::new(Vec3::X, n, a, b, 0.0).unwrap();
        for i in 0..5000 {
            let (r, t) = (f64::from(i % 97) * 2.0, f64::from(i) * 0.37);
            let at = Vec3::new(r * t.cos(), r * t.sin(), f64::from(i % 7));
            let (p, e) = (polar.ratio(at), ellipse.ratio(at));
            assert!((p - e).abs() <= 2e-4 * e, "{at}: {p} for {e}");
        }
        assert_eq!(polar.ratio(Vec3::X), 0.0);
    }

    #[test]
    fn places_that_are_no_place_lie_outside() {
        let o = Polar::new(Vec3::ZERO, Vec3::Z, &[1.0, 2.0, 3.0]).unwrap();
        for at in [Vec3::NAN, Vec3::splat(f64::INFINITY), Vec3::X * -1e300] {
            assert!(o.ratio(at) >= 1.0, "{at}: {}", o.ratio(at));
            assert!(!o.reaches(at, at));
            assert!(!o.holds(&Aabb { min: at, max: at }));
        }
    }

    #[test]
    fn empty_and_broken_boundaries_are_none() {
        let make = |radii: &[f64]| Polar::new(Vec3::ZERO, Vec3::Z, radii);
        for radii in [
            &[][..],
            &[1.0, 1.0],
            &[1.0, 0.0, 1.0],
            &[1.0, -1.0, 1.0],
            &[1.0, f64::NAN, 1.0],
            &[1.0, f64::INFINITY, 1.0],
            &[1e200; 4],
        ] {
            assert!(make(radii).is_none(), "{radii:?}");
        }
        let sound = [1.0; 4];
        assert!(Polar::new(Vec3::NAN, Vec3::Z, &sound).is_none());
        assert!(Polar::new(Vec3::ZERO, Vec3::ZERO, &sound).is_none());
        let sound = make(&sound).unwrap();
        for scale in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-320] {
            assert!(sound.scaled(scale).is_none(), "{scale}");
        }
    }
}
