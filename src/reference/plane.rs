//! The tangent plane of a press, on which the yardsticks are laid out.

use crate::deform::Press;
use crate::geom::{Vec2, Vec3, any_tangent, unit_or};
use crate::surface::Surface;

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
    /// The plane at the anchor of a press, `None` where any of it is no number, or there is no such triangle.
    pub fn of(press: &Press, surface: &Surface) -> Option<Self> {
        let normal = unit_or(press.normal, Vec3::ZERO);
        let sound = normal != Vec3::ZERO
            && press.anchor_mm.is_finite()
            && press.foot_mm.is_finite()
            && press.depth_mm.is_finite()
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
