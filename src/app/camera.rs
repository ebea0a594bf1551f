//! Where the back is looked at from. Pure mathematics: no widget, no GL; lengths mm, angles rad, pixels from the top left.
//!
//! A turntable: the eye circles `target_mm` about the subject's y axis, and rises towards the head by its elevation.
//!
//! ```text
//!        head (+y)                 seen from behind (azimuth 0, elevation 0):
//!          |   eye                  y
//!          |  /   elevation         |
//!          | /                      |____ x  (subject's right, right on the screen)
//!   target o------ +z
//! ```

use crate::geom::{Aabb, Vec2, Vec3};
use glam::DMat4;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Elevation stops short of the pole, where the turntable would spin: the basis stays exact but dragging feels wrong.
const MAX_ELEVATION: f64 = FRAC_PI_2 - 0.001;
/// Nearest and farthest the eye may come to the target, mm: a few pores to a few bodies.
const DISTANCE_MM: (f64, f64) = (15.0, 6000.0);
/// How long a change of view takes, s: long enough to keep one's bearings, short enough not to wait for.
const GLIDE_S: f64 = 0.28;

/// How depth shrinks things.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Projection {
    /// Nearer is larger.
    #[default]
    Perspective,
    /// Lengths across the view keep their scale: for measuring.
    Orthographic,
}

/// A named direction to look from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// From behind and a little from the side and above: the first view, where depth and force arrows show.
    Oblique,
    /// Straight from behind.
    Back,
    /// From the subject's left.
    Left,
    /// From the subject's right.
    Right,
    /// From above the head.
    Head,
    /// Near the finger, aslant.
    Close,
}

impl Preset {
    /// All of them, in the order of the toolbar.
    pub const ALL: [Self; 6] = [
        Self::Oblique,
        Self::Back,
        Self::Left,
        Self::Right,
        Self::Head,
        Self::Close,
    ];
}

/// A half-line, mm. `direction` has length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts, mm.
    pub origin_mm: Vec3,
    /// Where it goes.
    pub direction: Vec3,
}

impl Ray {
    /// The point `distance_mm` along it.
    pub fn at(&self, distance_mm: f64) -> Vec3 {
        self.origin_mm + self.direction * distance_mm
    }
}

/// The axes of the view in the frame of the subject, each of length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// To the right of the screen.
    pub right: Vec3,
    /// To the top of the screen.
    pub up: Vec3,
    /// Out of the screen, from the target to the eye.
    pub back: Vec3,
}

/// One of two eyes: how far it stands beside the camera, and where its picture is taken. See [`super::stereo`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Eye {
    /// To the right of the camera, mm; 0 for a single eye.
    pub shift_mm: f64,
    /// To the plane where it sees what the camera sees, mm in front of it. Without meaning for a single eye.
    pub convergence_mm: f64,
}

impl Eye {
    /// Its shift and the inverse of its convergence, mm and 1/mm; zeros where it does not stand aside.
    fn aslant(self) -> (f64, f64) {
        if self.shift_mm != 0.0 && self.convergence_mm > 0.0 {
            (self.shift_mm, 1.0 / self.convergence_mm)
        } else {
            (0.0, 0.0)
        }
    }
}

/// The eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// What it circles, mm.
    pub target_mm: Vec3,
    /// Angle about the subject's y axis from straight behind; positive moves the eye to the subject's right.
    pub azimuth: f64,
    /// Angle above the horizontal plane, towards the head.
    pub elevation: f64,
    /// From the target, mm. In orthographic view it only sets the scale.
    pub distance_mm: f64,
    /// Full vertical opening angle.
    pub fov_y: f64,
    /// How depth shrinks things.
    pub projection: Projection,
    /// Which of two eyes it is; the single one at first.
    pub eye: Eye,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            target_mm: Vec3::new(0.0, 240.0, 40.0),
            azimuth: 0.0,
            elevation: 0.0,
            distance_mm: 1000.0,
            fov_y: 28.0_f64.to_radians(),
            projection: Projection::Perspective,
            eye: Eye::default(),
        }
    }
}

impl Camera {
    /// The axes of the view.
    pub fn basis(&self) -> Basis {
        let (sin_a, cos_a) = self.azimuth.sin_cos();
        let (sin_e, cos_e) = self.elevation.sin_cos();
        let right = Vec3::new(cos_a, 0.0, -sin_a);
        let back = Vec3::new(sin_a * cos_e, sin_e, cos_a * cos_e);
        Basis {
            right,
            up: back.cross(right),
            back,
        }
    }

    /// Where the eye is, mm.
    pub fn eye_mm(&self) -> Vec3 {
        let b = self.basis();
        // Without perspective the eyes are far away: what parts them is the slant of their views.
        let aside_mm = match self.projection {
            Projection::Perspective => self.eye.aslant().0,
            Projection::Orthographic => 0.0,
        };
        self.target_mm + b.back * self.distance_mm + b.right * aside_mm
    }

    /// What an eye that stands aside adds to the horizontal place of a point on the picture at its depth, mm: what brings the
    /// plane of convergence to where the camera sees it. `depth_mm` is taken from the eye in perspective, else beyond the
    /// target.
    fn slant_mm(&self, depth_mm: f64) -> f64 {
        let (shift_mm, per_convergence) = self.eye.aslant();
        shift_mm * per_convergence * depth_mm
    }

    /// Half the height of the picture at the depth of the target, mm.
    pub fn half_height_mm(&self) -> f64 {
        self.distance_mm * (self.fov_y / 2.0).tan()
    }

    /// Pixels per mm at the depth of `point_mm` in a picture `height_px` high. Zero behind the eye.
    pub fn px_per_mm(&self, point_mm: Vec3, height_px: f64) -> f64 {
        let half_mm = match self.projection {
            Projection::Orthographic => self.half_height_mm(),
            Projection::Perspective => {
                let depth = (self.eye_mm() - point_mm).dot(self.basis().back);
                if depth <= 0.0 {
                    return 0.0;
                }
                depth * (self.fov_y / 2.0).tan()
            }
        };
        height_px / (2.0 * half_mm)
    }

    /// View coordinates from subject coordinates: x right, y up, z towards the eye, origin at the eye.
    pub fn view_from_subject(&self) -> DMat4 {
        let b = self.basis();
        let eye = self.eye_mm();
        DMat4::from_cols(
            Vec3::new(b.right.x, b.up.x, b.back.x).extend(0.0),
            Vec3::new(b.right.y, b.up.y, b.back.y).extend(0.0),
            Vec3::new(b.right.z, b.up.z, b.back.z).extend(0.0),
            Vec3::new(-b.right.dot(eye), -b.up.dot(eye), -b.back.dot(eye)).extend(1.0),
        )
    }

    /// OpenGL clip coordinates (depth −1…1) from subject coordinates, for a picture of `size_px` that must hold `bounds`.
    pub fn clip_from_subject(&self, size_px: Vec2, bounds: &Aabb) -> DMat4 {
        let (near, far) = self.depth_range_mm(bounds);
        let aspect = aspect(size_px);
        let clip_from_view = match self.projection {
            Projection::Perspective => {
                glam::dcamera::rh::proj::opengl::perspective(self.fov_y, aspect, near, far)
            }
            Projection::Orthographic => {
                let h = self.half_height_mm();
                glam::dcamera::rh::proj::opengl::orthographic(
                    -h * aspect,
                    h * aspect,
                    -h,
                    h,
                    near,
                    far,
                )
            }
        };
        let mut clip = clip_from_view * self.view_from_subject();
        // The slant is linear in depth, as one row more in that of x: off-axis frustum, or shear.
        if self.eye.aslant().0 != 0.0 {
            let b = self.basis();
            let half_width = match self.projection {
                Projection::Perspective => (self.fov_y / 2.0).tan() * aspect,
                Projection::Orthographic => self.half_height_mm() * aspect,
            };
            let from = match self.projection {
                Projection::Perspective => self.eye_mm(),
                Projection::Orthographic => self.target_mm,
            };
            let slant = self.slant_mm(1.0) / half_width;
            let row = (-b.back).extend(b.back.dot(from)) * slant;
            for (k, column) in [
                &mut clip.x_axis,
                &mut clip.y_axis,
                &mut clip.z_axis,
                &mut clip.w_axis,
            ]
            .into_iter()
            .enumerate()
            {
                column.x += row[k];
            }
        }
        clip
    }

    /// Nearest and farthest depth that `bounds` needs, mm in front of the eye, with a margin for fingers and arrows.
    fn depth_range_mm(&self, bounds: &Aabb) -> (f64, f64) {
        let back = self.basis().back;
        let (centre, radius) = if bounds.is_empty() {
            (self.target_mm, 100.0)
        } else {
            (bounds.centre(), bounds.diagonal_mm() / 2.0)
        };
        let middle = (self.eye_mm() - centre).dot(back);
        let reach = radius + 150.0;
        match self.projection {
            Projection::Perspective => {
                let far = (middle + reach).max(10.0);
                ((middle - reach).max(far / 2000.0), far)
            }
            Projection::Orthographic => (middle - reach, middle + reach),
        }
    }

    /// Where `point_mm` appears, pixels from the top left; `None` behind the eye.
    pub fn project(&self, point_mm: Vec3, size_px: Vec2) -> Option<Vec2> {
        let b = self.basis();
        let from_eye = point_mm - self.eye_mm();
        let half_mm = match self.projection {
            Projection::Orthographic => self.half_height_mm(),
            Projection::Perspective => -from_eye.dot(b.back) * (self.fov_y / 2.0).tan(),
        };
        if !(half_mm > 1e-9 && half_mm.is_finite()) {
            return None;
        }
        let scale = size_px.y / (2.0 * half_mm);
        let depth_mm = match self.projection {
            Projection::Perspective => -from_eye.dot(b.back),
            Projection::Orthographic => (self.target_mm - point_mm).dot(b.back),
        };
        Some(Vec2::new(
            size_px.x / 2.0 + (from_eye.dot(b.right) + self.slant_mm(depth_mm)) * scale,
            size_px.y / 2.0 - from_eye.dot(b.up) * scale,
        ))
    }

    /// The half-line seen under a pixel. It starts at the eye, or in orthographic view far in front of everything.
    pub fn ray(&self, pixel: Vec2, size_px: Vec2) -> Ray {
        let b = self.basis();
        let h = self.half_height_mm();
        let x = (2.0 * pixel.x / size_px.x.max(1.0) - 1.0) * h * aspect(size_px);
        let y = (1.0 - 2.0 * pixel.y / size_px.y.max(1.0)) * h;
        let on_target_plane = self.target_mm + b.right * x + b.up * y;
        match self.projection {
            Projection::Perspective => {
                let eye = self.eye_mm();
                // An eye that stands aside sees that plane moved by what its slant leaves of its shift.
                let (shift_mm, _) = self.eye.aslant();
                let aside_mm = shift_mm - self.slant_mm(self.distance_mm);
                Ray {
                    origin_mm: eye,
                    direction: crate::geom::unit_or(
                        on_target_plane + b.right * aside_mm - eye,
                        -b.back,
                    ),
                }
            }
            Projection::Orthographic => {
                let direction =
                    crate::geom::unit_or(-b.back - b.right * self.slant_mm(1.0), -b.back);
                Ray {
                    origin_mm: on_target_plane - direction * 10_000.0,
                    direction,
                }
            }
        }
    }

    /// Turns the view by a drag of `delta` pixels: half a turn over the height of the picture. Says whether it changed.
    #[must_use]
    pub fn orbit(&mut self, delta: Vec2, size_px: Vec2) -> bool {
        if !delta.is_finite() || size_px.y < 1.0 {
            return false;
        }
        let before = *self;
        let rate = PI / size_px.y;
        self.azimuth = wrapped(self.azimuth - delta.x * rate);
        self.elevation = (self.elevation + delta.y * rate).clamp(-MAX_ELEVATION, MAX_ELEVATION);
        *self != before
    }

    /// Moves the view so that what was under the cursor at the depth of the target follows a drag of `delta` pixels.
    /// Says whether it changed.
    #[must_use]
    pub fn pan(&mut self, delta: Vec2, size_px: Vec2) -> bool {
        if !delta.is_finite() || size_px.y < 1.0 {
            return false;
        }
        let before = *self;
        let b = self.basis();
        let mm_per_px = 2.0 * self.half_height_mm() / size_px.y;
        self.target_mm += (b.up * delta.y - b.right * delta.x) * mm_per_px;
        *self != before
    }

    /// Zooms by `factor` (above 1 comes nearer) so that `about_mm` keeps its pixel. Says whether it changed.
    #[must_use]
    pub fn zoom(&mut self, factor: f64, about_mm: Vec3) -> bool {
        if !(factor.is_finite() && factor > 0.0 && about_mm.is_finite()) {
            return false;
        }
        let before = *self;
        let distance = (self.distance_mm / factor).clamp(DISTANCE_MM.0, DISTANCE_MM.1);
        // Eye and target both shrink towards the point: its direction from the eye, hence its pixel, stays.
        let shrink = distance / self.distance_mm;
        self.target_mm = about_mm + (self.target_mm - about_mm) * shrink;
        self.distance_mm = distance;
        *self != before
    }

    /// The point at the depth of the target under a pixel, mm: what to zoom about where the cursor meets no surface.
    pub fn at_target_depth(&self, pixel: Vec2, size_px: Vec2) -> Vec3 {
        let ray = self.ray(pixel, size_px);
        let back = self.basis().back;
        let along = (self.target_mm - ray.origin_mm).dot(back) / ray.direction.dot(back);
        if along.is_finite() {
            ray.at(along)
        } else {
            self.target_mm
        }
    }

    /// This camera moved so that the box fills a picture of `size_px` with a small margin, direction kept.
    /// An empty box leaves it as it is.
    #[must_use]
    pub fn framed(mut self, bounds: &Aabb, size_px: Vec2) -> Self {
        if bounds.is_empty() || !bounds.diagonal_mm().is_finite() {
            return self;
        }
        let b = self.basis();
        let (aspect, tan) = (aspect(size_px), (self.fov_y / 2.0).tan());
        self.target_mm = bounds.centre();
        let half = bounds.size() / 2.0;
        // Each corner asks for the distance at which it just fits; the farthest request wins.
        let mut distance = 0.0_f64;
        for corner in 0..8 {
            let sign = |bit: u32| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
            let c = half * Vec3::new(sign(0), sign(1), sign(2));
            let across = (c.dot(b.up).abs() / tan).max(c.dot(b.right).abs() / (tan * aspect));
            let towards = match self.projection {
                Projection::Perspective => c.dot(b.back),
                Projection::Orthographic => 0.0,
            };
            distance = distance.max(across + towards);
        }
        self.distance_mm = (distance * 1.04).clamp(DISTANCE_MM.0, DISTANCE_MM.1);
        self
    }

    /// This camera as `preset` wants it. `finger` (place in mm, outward normal) is what [`Preset::Close`] looks at, along
    /// the skin rather than at it; without one only the distance changes.
    #[must_use]
    pub fn preset(
        mut self,
        preset: Preset,
        bounds: &Aabb,
        finger: Option<(Vec3, Vec3)>,
        size_px: Vec2,
    ) -> Self {
        let (azimuth, elevation) = match preset {
            Preset::Oblique => (-0.38, 0.16),
            Preset::Back => (0.0, 0.0),
            Preset::Left => (-FRAC_PI_2, 0.0),
            Preset::Right => (FRAC_PI_2, 0.0),
            Preset::Head => (0.0, MAX_ELEVATION),
            Preset::Close => {
                if let Some((place_mm, normal)) = finger {
                    self.target_mm = place_mm;
                    self.azimuth = wrapped(normal.x.atan2(normal.z) - 0.55);
                    self.elevation = (normal.y.clamp(-1.0, 1.0).asin() + 0.45)
                        .clamp(-MAX_ELEVATION, MAX_ELEVATION);
                }
                self.distance_mm = 260.0;
                return self;
            }
        };
        self.azimuth = azimuth;
        self.elevation = elevation;
        self.framed(bounds, size_px)
    }
}

fn aspect(size_px: Vec2) -> f64 {
    (size_px.x / size_px.y.max(1.0)).max(1e-3)
}

/// The same angle in −π…π.
fn wrapped(angle: f64) -> f64 {
    let a = angle.rem_euclid(TAU);
    if a > PI { a - TAU } else { a }
}

/// A smooth change from one view to another.
#[derive(Clone, Copy, Debug)]
pub struct Glide {
    from: Camera,
    to: Camera,
    time_s: f64,
}

impl Glide {
    /// From `from` to `to`.
    pub fn new(from: Camera, to: Camera) -> Self {
        Self {
            from,
            to,
            time_s: 0.0,
        }
    }

    /// `dt_s` later: the camera now, and whether it has arrived (then exactly at its goal).
    #[must_use]
    pub fn step(&mut self, dt_s: f64) -> (Camera, bool) {
        self.time_s += dt_s.max(0.0);
        let t = self.time_s / GLIDE_S;
        if t.is_nan() || t >= 1.0 {
            return (self.to, true);
        }
        let s = t * t * (3.0 - 2.0 * t);
        let (a, b) = (&self.from, &self.to);
        let camera = Camera {
            target_mm: a.target_mm.lerp(b.target_mm, s),
            azimuth: a.azimuth + wrapped(b.azimuth - a.azimuth) * s,
            elevation: a.elevation + (b.elevation - a.elevation) * s,
            distance_mm: a.distance_mm * (b.distance_mm / a.distance_mm).powf(s),
            ..*b
        };
        (camera, false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SIZE: Vec2 = Vec2::new(800.0, 600.0);

    fn back_box() -> Aabb {
        Aabb {
            min: Vec3::new(-180.0, 0.0, -20.0),
            max: Vec3::new(180.0, 480.0, 100.0),
        }
    }

    fn cameras() -> impl Strategy<Value = Camera> {
        (
            -3.1..3.1_f64,
            -1.5..1.5_f64,
            50.0..2000.0_f64,
            any::<bool>(),
            -100.0..100.0_f64,
        )
            .prop_map(|(azimuth, elevation, distance_mm, ortho, x)| Camera {
                target_mm: Vec3::new(x, 200.0, 30.0),
                azimuth,
                elevation,
                distance_mm,
                projection: if ortho {
                    Projection::Orthographic
                } else {
                    Projection::Perspective
                },
                ..Camera::default()
            })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn a_point_on_the_ray_of_a_pixel_projects_back_to_it(
            camera in cameras(), px in 0.0..800.0_f64, py in 0.0..600.0_f64, along in 1.0..3000.0_f64,
        ) {
            let pixel = Vec2::new(px, py);
            let ray = camera.ray(pixel, SIZE);
            prop_assert!((ray.direction.length() - 1.0).abs() < 1e-12);
            let back = camera.project(ray.at(along), SIZE).unwrap();
            prop_assert!((back - pixel).length() < 1e-6, "{pixel} came back as {back}");
        }

        #[test]
        fn the_matrix_agrees_with_projection(camera in cameras(), x in -100.0..100.0_f64, y in 0.0..400.0_f64) {
            let p = Vec3::new(x, y, 40.0);
            let clip = camera.clip_from_subject(SIZE, &back_box()) * p.extend(1.0);
            let Some(pixel) = camera.project(p, SIZE) else { return Ok(()); };
            prop_assume!(clip.w > 1.0 || camera.projection == Projection::Orthographic);
            let from_clip = Vec2::new(
                (clip.x / clip.w + 1.0) / 2.0 * SIZE.x,
                (1.0 - clip.y / clip.w) / 2.0 * SIZE.y,
            );
            prop_assert!((from_clip - pixel).length() < 1e-6, "{from_clip} against {pixel}");
            prop_assert!(clip.z.abs() <= clip.w.abs() * (1.0 + 1e-9) || clip.w < camera.distance_mm / 10.0);
        }

        #[test]
        fn zooming_keeps_the_point_under_the_cursor(camera in cameras(), factor in 0.5..2.0_f64, px in 1.0..800.0_f64) {
            let pixel = Vec2::new(px, 250.0);
            let about = camera.ray(pixel, SIZE).at(if camera.projection == Projection::Orthographic { 10_000.0 } else { camera.distance_mm });
            let mut zoomed = camera;
            prop_assert!(zoomed.zoom(factor, about) || factor == 1.0);
            let after = zoomed.project(about, SIZE).unwrap();
            prop_assert!((after - pixel).length() < 1e-6);
        }

        #[test]
        fn panning_follows_the_cursor(camera in cameras(), dx in -200.0..200.0_f64, dy in -200.0..200.0_f64) {
            let start = Vec2::new(400.0, 300.0);
            let grabbed = camera.at_target_depth(start, SIZE);
            let mut panned = camera;
            let _ = panned.pan(Vec2::new(dx, dy), SIZE);
            let now = panned.project(grabbed, SIZE).unwrap();
            prop_assert!((now - start - Vec2::new(dx, dy)).length() < 1e-6);
        }

        #[test]
        fn a_framed_box_lies_in_the_picture(camera in cameras(), w in 200.0..2000.0_f64) {
            let size = Vec2::new(w, 600.0);
            let bounds = back_box();
            let framed = camera.framed(&bounds, size);
            for i in 0..8 {
                let pick = |bit: u32, lo: f64, hi: f64| if i >> bit & 1 == 1 { hi } else { lo };
                let c = Vec3::new(
                    pick(0, bounds.min.x, bounds.max.x),
                    pick(1, bounds.min.y, bounds.max.y),
                    pick(2, bounds.min.z, bounds.max.z),
                );
                let p = framed.project(c, size).unwrap();
                prop_assert!(p.x >= 0.0 && p.x <= size.x && p.y >= 0.0 && p.y <= size.y, "{c} at {p}");
            }
        }
    }

    fn screen_offset(camera: &Camera, direction: Vec3) -> Vec2 {
        let c = camera.project(camera.target_mm, SIZE).unwrap();
        camera
            .project(camera.target_mm + direction * 10.0, SIZE)
            .unwrap()
            - c
    }

    #[test]
    fn from_behind_the_subjects_right_is_right_and_the_head_is_up() {
        let camera = Camera::default().preset(Preset::Back, &back_box(), None, SIZE);
        assert!(screen_offset(&camera, Vec3::X).x > 1.0);
        assert!(screen_offset(&camera, Vec3::Y).y < -1.0);
        assert!(camera.eye_mm().z > back_box().max.z);
    }

    #[test]
    fn presets_look_from_where_they_say() {
        let at = |p| Camera::default().preset(p, &back_box(), None, SIZE);
        assert!(at(Preset::Left).eye_mm().x < -180.0);
        assert!(at(Preset::Right).eye_mm().x > 180.0);
        assert!(at(Preset::Head).eye_mm().y > 480.0);
        // From the side the head stays up; from the head the back's outside points down the screen.
        assert!(screen_offset(&at(Preset::Left), Vec3::Y).y < -1.0);
        assert!(screen_offset(&at(Preset::Head), Vec3::Z).y > 1.0);
        assert!(screen_offset(&at(Preset::Head), Vec3::X).x > 1.0);
        let finger = Vec3::new(30.0, 200.0, 90.0);
        let close =
            Camera::default().preset(Preset::Close, &back_box(), Some((finger, Vec3::Z)), SIZE);
        assert_eq!(close.target_mm, finger);
        assert!(close.distance_mm < 300.0);
    }

    #[test]
    fn orbit_says_whether_it_changed_and_stops_at_the_pole() {
        let mut camera = Camera::default();
        assert!(!camera.orbit(Vec2::ZERO, SIZE));
        assert!(!camera.orbit(Vec2::new(f64::NAN, 0.0), SIZE));
        assert!(camera.orbit(Vec2::new(0.0, 1e4), SIZE));
        assert!(!camera.orbit(Vec2::new(0.0, 10.0), SIZE));
        assert!(camera.basis().up.is_finite());
    }

    #[test]
    fn dragging_to_the_right_shows_more_of_the_left() {
        let mut camera = Camera::default();
        assert!(camera.orbit(Vec2::new(50.0, 0.0), SIZE));
        assert!(camera.eye_mm().x < 0.0);
    }

    #[test]
    fn a_glide_ends_exactly_at_its_goal_the_short_way_round() {
        let from = Camera {
            azimuth: 3.0,
            ..Camera::default()
        };
        let to = Camera {
            azimuth: -3.0,
            distance_mm: 200.0,
            ..Camera::default()
        };
        let mut glide = Glide::new(from, to);
        let (middle, done) = glide.step(0.1);
        assert!(!done && middle.azimuth.abs() >= 3.0, "{}", middle.azimuth);
        assert!(middle.distance_mm < 1000.0 && middle.distance_mm > 200.0);
        assert_eq!(glide.step(1.0), (to, true));
    }

    #[test]
    fn an_empty_box_or_picture_gives_finite_numbers() {
        let camera = Camera::default();
        assert_eq!(camera.framed(&Aabb::EMPTY, SIZE), camera);
        let m = camera.clip_from_subject(Vec2::ZERO, &Aabb::EMPTY);
        assert!(m.is_finite());
        assert!(camera.ray(Vec2::ZERO, Vec2::ZERO).direction.is_finite());
    }
}
