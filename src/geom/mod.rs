//! Vectors, boxes, triangles and the two questions asked of them: where is the closest point, where does a segment cross.
//! And falloffs over a ratio: as functions ([`law`]), and as arrays read fast ([`curve`]).
//!
//! All coordinates are mm in the frame of the subject: x to the subject's right, y to the head, z out of the back.

mod aabb;
pub mod curve;
pub mod law;
mod monotone;
mod table;
mod triangle;

pub use aabb::Aabb;
pub use glam::{DVec2 as Vec2, DVec3 as Vec3};
pub use monotone::Monotone;
pub use triangle::{Crossing, Feature, Triangle, TrianglePoint};

/// `v` scaled to length 1, or `fallback` where `v` is too short or not finite to have a direction.
///
/// The bound is the smallest length whose square is still a normal number: below it the division loses digits.
pub fn unit_or(v: Vec3, fallback: Vec3) -> Vec3 {
    let length_sq = v.length_squared();
    if length_sq.is_finite() && length_sq >= f64::MIN_POSITIVE {
        v / length_sq.sqrt()
    } else {
        fallback
    }
}

/// A unit vector at right angles to the unit vector `n`. Continuous except at `n.z` = −1 (Duff et al. 2017, JCGT 6(1)).
pub fn any_tangent(n: Vec3) -> Vec3 {
    let sign = if n.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x)
}
