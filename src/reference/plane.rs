//! The tangent plane of a press, on which the yardsticks are laid out.

use crate::deform::Press;
use crate::geom::{Vec2, Vec3, any_tangent, unit_or};
use crate::surface::Surface;

/// No coordinate or depth of a press may be larger, mm: ten times as far as a surface may reach, and the products that
/// normals are made of stay finite.
const FARTHEST_MM: f64 = 10.0 * crate::surface::MAX_COORDINATE_MM;

/// The tangent plane of a press.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// Where its axes meet, mm.
    pub origin_mm: Vec3,
    /// Unit axes.
    pub x: Vec3,
    /// Unit, at right angles to x.
    pub y: Vec3,
    /// Outward unit normal.
    pub normal: Vec3,
}

impl Plane {
    /// The plane at the anchor of a press, `None` where any of it is no number or out of reach, or there is no such triangle.
    pub fn of(press: &Press, surface: &Surface) -> Option<Self> {
        let normal = unit_or(press.normal, Vec3::ZERO);
        // Also false for NaN.
        let near = |x: f64| x <= FARTHEST_MM;
        let sound = normal != Vec3::ZERO
            && near(press.anchor_mm.abs().max_element())
            && near(press.foot_mm.abs().max_element())
            && press.anchor_mm.is_finite()
            && press.foot_mm.is_finite()
            && near(press.depth_mm.abs())
            && (press.triangle as usize) < surface.triangles().len();
        sound.then(|| Self::at(press.anchor_mm, normal))
    }

    /// The plane through a point with a unit normal.
    pub fn at(origin_mm: Vec3, normal: Vec3) -> Self {
        let x = any_tangent(normal);
        Self {
            origin_mm,
            x,
            y: normal.cross(x),
            normal,
        }
    }

    /// Where the foot of a point lies on it, mm.
    pub fn place_mm(&self, point_mm: Vec3) -> Vec2 {
        let from = point_mm - self.origin_mm;
        Vec2::new(from.dot(self.x), from.dot(self.y))
    }
}
