//! Where a picture is taken from, and where a point of the scene lies in it.

use crate::geom::{Aabb, Vec2, Vec3, any_tangent, unit_or};
use crate::units::rad_from_deg;

/// Full vertical angle of a framed view: a long lens, so that the near side is not blown up.
const FRAMING_FOV_DEG: f64 = 24.0;
/// Share of the picture left free round a framed box.
const FRAMING_MARGIN: f64 = 1.06;
/// The near plane, as a share of the distance from eye to target.
const NEAR: f64 = 0.01;

/// A perspective view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The eye, mm.
    pub eye_mm: Vec3,
    /// The point in the middle of the picture, mm.
    pub target_mm: Vec3,
    /// What shall be up in the picture; needs no length and no right angle with the line of sight.
    pub up: Vec3,
    /// Full vertical angle of view, rad, between 0 and π.
    pub fov_y_rad: f64,
}

impl Camera {
    /// A view of the whole box from `direction` (from the target to the eye), for a picture of the given width ∕ height.
    ///
    /// Up is to the head, or to the back where one looks along the body. A box that is empty or not finite is taken as a cube of 100 mm round
    /// the origin, a direction without length as +z (from behind), an aspect that is not positive as 1.
    pub fn framing(bounds: &Aabb, direction: Vec3, aspect: f64) -> Self {
        let has_place = bounds.centre().is_finite() && bounds.diagonal_mm().is_finite();
        let bounds = if bounds.is_empty() || !has_place {
            Aabb::cube(Vec3::ZERO, 100.0)
        } else {
            *bounds
        };
        let aspect = if aspect.is_finite() && aspect > 0.0 {
            aspect
        } else {
            1.0
        };
        let back = unit_or(direction, Vec3::Z);
        let up = if back.y.abs() > 0.999 {
            Vec3::Z
        } else {
            Vec3::Y
        };
        let (right, up_in_view) = axes(back, up);
        let fov_y_rad = rad_from_deg(FRAMING_FOV_DEG);
        let slope = libm::tan(fov_y_rad / 2.0) / FRAMING_MARGIN;
        let half = bounds.size() / 2.0;
        let mut distance_mm: f64 = 1.0;
        for corner in 0..8 {
            let sign = |bit: i32| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
            let offset = half * Vec3::new(sign(0), sign(1), sign(2));
            let across = offset.dot(right).abs() / aspect;
            let along = offset.dot(up_in_view).abs();
            distance_mm = distance_mm.max(offset.dot(back) + across.max(along) / slope);
        }
        let target_mm = bounds.centre();
        Self {
            eye_mm: target_mm + back * distance_mm,
            target_mm,
            up,
            fov_y_rad,
        }
    }

    /// Where a point, mm, lies in a picture of the given size: pixels from the left and top edge. `None` where it is not in
    /// front of the eye or the camera sees nothing.
    pub fn place_in_picture(&self, point_mm: Vec3, width: usize, height: usize) -> Option<Vec2> {
        let view = View::new(self, width, height)?;
        let in_view = view.in_view(point_mm);
        let at = view.place(in_view);
        (in_view.z >= view.near_mm && at.is_finite()).then_some(at)
    }
}

/// Right and up of a picture taken against the unit vector `back`.
fn axes(back: Vec3, up: Vec3) -> (Vec3, Vec3) {
    let right = unit_or(up.cross(back), any_tangent(back));
    (right, back.cross(right))
}

/// A camera made ready for a picture of a certain size. View coordinates: right, up, and depth away from the eye, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub eye_mm: Vec3,
    pub right: Vec3,
    pub up: Vec3,
    /// From the target to the eye.
    pub back: Vec3,
    /// Nothing nearer is drawn, mm.
    pub near_mm: f64,
    /// Depth of the target, mm.
    pub target_depth_mm: f64,
    /// Pixels per unit of slope.
    pub focal_px: f64,
    middle_px: Vec2,
}

impl View {
    /// `None` for a camera that sees nothing: eye at the target, a number that is not finite, an angle out of range.
    pub fn new(camera: &Camera, width: usize, height: usize) -> Option<Self> {
        let line = camera.eye_mm - camera.target_mm;
        let target_depth_mm = line.length();
        let back = unit_or(line, Vec3::ZERO);
        let (right, up) = axes(back, camera.up);
        let middle_px = Vec2::new(width as f64, height as f64) / 2.0;
        let view = Self {
            eye_mm: camera.eye_mm,
            right,
            up,
            back,
            near_mm: NEAR * target_depth_mm,
            target_depth_mm,
            focal_px: middle_px.y / libm::tan(camera.fov_y_rad / 2.0),
            middle_px,
        };
        let angle_fits = camera.fov_y_rad > 0.0 && camera.fov_y_rad < std::f64::consts::PI;
        let fits = angle_fits
            && back != Vec3::ZERO
            && view.near_mm > 0.0
            && view.focal_px.is_finite()
            && view.focal_px > 0.0
            && camera.eye_mm.is_finite()
            && right.is_finite();
        fits.then_some(view)
    }

    pub fn in_view(&self, point_mm: Vec3) -> Vec3 {
        let d = point_mm - self.eye_mm;
        Vec3::new(d.dot(self.right), d.dot(self.up), -d.dot(self.back))
    }

    /// Place in the picture of a point in view coordinates, pixels.
    pub fn place(&self, in_view: Vec3) -> Vec2 {
        let slope = Vec2::new(in_view.x, -in_view.y) / in_view.z;
        self.middle_px + slope * self.focal_px
    }

    /// What a place in the picture sees: the direction that goes 1 mm deep, not of unit length.
    pub fn ray(&self, at_px: Vec2) -> Vec3 {
        let slope = (at_px - self.middle_px) / self.focal_px;
        self.right * slope.x - self.up * slope.y - self.back
    }
}
