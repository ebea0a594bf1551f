//! Two pictures for two eyes. Pure mathematics: no widget, no GL; lengths mm, pixels from the top left.
//!
//! The eyes stand side by side and look the same way; what converges are their frusta, cut aslant (off-axis), not their
//! axes: turned-in eyes would see every upright line at a slant of its own, and the two pictures could not be fused towards
//! the sides.
//!
//! With the eyes `e` apart and both pictures taken on the plane at the convergence distance `c`, a point at depth `z` in front
//! of the eyes stands `e (1 − c / z)` farther to the right in the right eye's picture than in the left eye's, measured on that
//! plane: nothing at `c`, to the left before it (it stands out), to the right behind it, and never more than `e`, where eyes
//! look straight ahead.

use super::camera::{Camera, Eye};
use crate::geom::Vec2;
use std::ops::RangeInclusive;

/// How the two pictures are brought to the two eyes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Side by side, the left eye's on the left: for a viewer, or eyes that look straight ahead.
    Parallel,
    /// Side by side, the left eye's on the right: for eyes that squint.
    CrossEyed,
    /// One over the other in red and cyan, for glasses with a red left and a cyan right filter.
    Anaglyph,
}

impl Mode {
    /// All of them, in the order of the menu.
    pub const ALL: [Self; 3] = [Self::Parallel, Self::CrossEyed, Self::Anaglyph];

    /// Stable name: kept between runs, taken on the command line.
    pub fn key(self) -> &'static str {
        match self {
            Self::Parallel => "parallel",
            Self::CrossEyed => "cross-eyed",
            Self::Anaglyph => "anaglyph",
        }
    }

    /// The one of this name.
    pub fn named(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|m| m.key() == key)
    }
}

/// Distances between eyes that can be chosen, mm: from none to a giant's.
pub const SEPARATION_MM: RangeInclusive<f64> = 0.0..=200.0;
/// Distances of convergence that can be chosen, mm.
pub const CONVERGENCE_MM: RangeInclusive<f64> = 50.0..=6000.0;
/// Mean distance between the pupils of adults, mm (Dodgson 2004, rounded).
const USUAL_SEPARATION_MM: f64 = 63.0;

/// How a picture is seen with two eyes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stereo {
    /// How the pictures reach the eyes.
    pub mode: Mode,
    /// From eye to eye, mm.
    pub separation_mm: f64,
    /// From the eyes to what shows without parallax, mm; `None` is what the camera looks at.
    pub convergence_mm: Option<f64>,
}

impl Default for Stereo {
    /// Side by side with usual eyes that look at what the camera looks at.
    fn default() -> Self {
        Self {
            mode: Mode::Parallel,
            separation_mm: USUAL_SEPARATION_MM,
            convergence_mm: None,
        }
    }
}

/// One picture's place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pane {
    /// Whose picture it is.
    pub camera: Camera,
    /// Its top left corner in the whole, pixels.
    pub from: Vec2,
    /// Its size, pixels.
    pub size: Vec2,
}

impl Pane {
    /// The whole of `size` for one camera.
    pub fn whole(camera: Camera, size: Vec2) -> Self {
        Self {
            camera,
            from: Vec2::ZERO,
            size,
        }
    }

    /// Whether a pixel of the whole lies in it.
    pub fn holds(&self, pixel: Vec2) -> bool {
        let p = pixel - self.from;
        (0.0..self.size.x).contains(&p.x) && (0.0..self.size.y).contains(&p.y)
    }
}

impl Stereo {
    /// The cameras of the left and the right eye, their middle where `camera` stands. A separation or distance that is no
    /// number, or out of range, is brought within it.
    pub fn eyes(&self, camera: &Camera) -> [Camera; 2] {
        let within = |x: f64, range: &RangeInclusive<f64>, otherwise: f64| {
            if x.is_finite() {
                x.clamp(*range.start(), *range.end())
            } else {
                otherwise
            }
        };
        let separation = within(self.separation_mm, &SEPARATION_MM, USUAL_SEPARATION_MM);
        let target = camera.distance_mm;
        let convergence_mm = self
            .convergence_mm
            .map_or(target, |c| within(c, &CONVERGENCE_MM, target));
        [-0.5, 0.5].map(|side| Camera {
            eye: Eye {
                shift_mm: side * separation,
                convergence_mm,
            },
            ..*camera
        })
    }

    /// Whether the pictures stand side by side.
    pub fn is_split(&self) -> bool {
        self.mode != Mode::Anaglyph
    }

    /// Width of one of two pictures in a whole this wide.
    fn half(width: f64) -> f64 {
        (width / 2.0).floor().max(1.0)
    }

    /// Both pictures and their places in a whole of `size`, the left eye's first. In an anaglyph both fill it.
    pub fn pictures(&self, camera: &Camera, size: Vec2) -> [Pane; 2] {
        let eyes = self.eyes(camera);
        if !self.is_split() {
            return eyes.map(|camera| Pane::whole(camera, size));
        }
        let half = Self::half(size.x);
        let mut places = [0.0, size.x - half];
        if self.mode == Mode::CrossEyed {
            places.reverse();
        }
        std::array::from_fn(|i| Pane {
            camera: eyes[i],
            from: Vec2::new(places[i], 0.0),
            size: Vec2::new(half, size.y),
        })
    }
}

/// The panes on which one points, writes and draws lines: two side by side; one for a single picture and for an anaglyph,
/// where what is not in the picture lies between its two halves.
pub fn panes(stereo: Option<&Stereo>, camera: &Camera, size: Vec2) -> Vec<Pane> {
    match stereo.filter(|s| s.is_split()) {
        Some(stereo) => stereo.pictures(camera, size).to_vec(),
        None => vec![Pane::whole(*camera, size)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::camera::Projection;
    use crate::geom::{Aabb, Vec3};

    const SIZE: Vec2 = Vec2::new(900.0, 700.0);

    fn camera() -> Camera {
        Camera {
            azimuth: 0.4,
            elevation: -0.2,
            ..Camera::default()
        }
    }

    fn at_depth(camera: &Camera, right: f64, up: f64, depth: f64) -> Vec3 {
        let b = camera.basis();
        camera.target_mm + b.back * (camera.distance_mm - depth) + b.right * right + b.up * up
    }

    /// Parallax on the plane of convergence, mm.
    fn parallax(stereo: &Stereo, camera: &Camera, point: Vec3) -> [f64; 2] {
        let [left, right] = stereo.eyes(camera);
        let [l, r] = [left, right].map(|eye| eye.project(point, SIZE).unwrap());
        let c = left.eye.convergence_mm;
        let mm_per_px = 2.0 * c * (camera.fov_y / 2.0).tan() / SIZE.y;
        ((r - l) * mm_per_px).to_array()
    }

    #[test]
    fn parallax_is_that_of_the_closed_form() {
        let camera = camera();
        for convergence_mm in [None, Some(700.0), Some(1400.0)] {
            let stereo = Stereo {
                separation_mm: 65.0,
                convergence_mm,
                ..Stereo::default()
            };
            let c = convergence_mm.unwrap_or(camera.distance_mm);
            for (x, y) in [(0.0, 0.0), (120.0, -80.0), (-200.0, 150.0)] {
                for depth in [300.0, 700.0, 1000.0, 1400.0, 5000.0] {
                    let [px, py] = parallax(&stereo, &camera, at_depth(&camera, x, y, depth));
                    let wanted = 65.0 * (1.0 - c / depth);
                    assert!((px - wanted).abs() < 1e-9, "{px} for {wanted} at {depth}");
                    // Off-axis frusta have no vertical parallax, turned-in eyes would.
                    assert!(py.abs() < 1e-9, "{py}");
                }
                let on_plane = at_depth(&camera, x, y, c);
                assert!(parallax(&stereo, &camera, on_plane)[0].abs() < 1e-9);
            }
        }
    }

    #[test]
    fn in_orthographic_view_parallax_grows_straight_with_depth() {
        let camera = Camera {
            projection: Projection::Orthographic,
            ..camera()
        };
        let stereo = Stereo::default();
        for beyond in [-150.0, 0.0, 90.0] {
            let depth = camera.distance_mm + beyond;
            let [px, _] = parallax(&stereo, &camera, at_depth(&camera, 30.0, 10.0, depth));
            let wanted = 63.0 * beyond / camera.distance_mm;
            assert!((px - wanted).abs() < 1e-9, "{px} for {wanted}");
        }
    }

    /// The matrix of the graphics card, the projection of the overlay and the ray of the mouse are one geometry.
    #[test]
    fn matrix_projection_and_ray_agree_for_each_eye() {
        let bounds = Aabb::of_points([
            Vec3::new(-170.0, 0.0, -20.0),
            Vec3::new(170.0, 470.0, 120.0),
        ]);
        for projection in [Projection::Perspective, Projection::Orthographic] {
            let camera = Camera {
                projection,
                ..camera()
            };
            for eye in Stereo::default().eyes(&camera) {
                for p in [Vec3::new(20.0, 200.0, 90.0), Vec3::new(-150.0, 420.0, 10.0)] {
                    let pixel = eye.project(p, SIZE).unwrap();
                    let clip = eye.clip_from_subject(SIZE, &bounds) * p.extend(1.0);
                    let ndc = Vec2::new(clip.x, clip.y) / clip.w;
                    let from_clip =
                        Vec2::new((ndc.x + 1.0) / 2.0 * SIZE.x, (1.0 - ndc.y) / 2.0 * SIZE.y);
                    assert!(pixel.distance(from_clip) < 1e-6, "{pixel} {from_clip}");
                    let ray = eye.ray(pixel, SIZE);
                    let along = (p - ray.origin_mm).dot(ray.direction);
                    assert!(ray.at(along).distance(p) < 1e-6);
                }
            }
        }
    }

    #[test]
    fn the_middle_of_both_eyes_is_the_single_one() {
        let camera = camera();
        let p = at_depth(&camera, 40.0, -30.0, 850.0);
        let [l, r] = Stereo::default()
            .eyes(&camera)
            .map(|eye| eye.project(p, SIZE).unwrap());
        let single = camera.project(p, SIZE).unwrap();
        assert!(((l + r) / 2.0).distance(single) < 1e-9);
        let none = Stereo {
            separation_mm: 0.0,
            ..Stereo::default()
        };
        for eye in none.eyes(&camera) {
            assert!(eye.project(p, SIZE).unwrap().distance(single) < 1e-12);
        }
    }

    #[test]
    fn pictures_stand_where_their_eyes_look_for_them() {
        let camera = camera();
        let of = |mode| {
            let stereo = Stereo {
                mode,
                ..Stereo::default()
            };
            stereo.pictures(&camera, Vec2::new(901.0, 700.0))
        };
        let [left, right] = of(Mode::Parallel);
        assert!(left.camera.eye.shift_mm < 0.0 && right.camera.eye.shift_mm > 0.0);
        assert_eq!((left.from.x, right.from.x), (0.0, 451.0));
        assert_eq!((left.size.x, right.size.x), (450.0, 450.0));
        assert!(left.holds(Vec2::new(449.0, 3.0)) && !right.holds(Vec2::new(449.0, 3.0)));
        let [left, right] = of(Mode::CrossEyed);
        assert_eq!((left.from.x, right.from.x), (451.0, 0.0));
        let [left, right] = of(Mode::Anaglyph);
        assert_eq!(
            (left.size, right.size),
            (Vec2::new(901.0, 700.0), Vec2::new(901.0, 700.0))
        );
        assert_eq!(panes(None, &camera, SIZE).len(), 1);
    }

    #[test]
    fn what_is_no_number_or_out_of_range_is_brought_within_it() {
        for bad in [f64::NAN, f64::INFINITY, -5.0, 1e9] {
            let stereo = Stereo {
                separation_mm: bad,
                convergence_mm: Some(bad),
                ..Stereo::default()
            };
            for eye in stereo.eyes(&camera()) {
                assert!(SEPARATION_MM.contains(&(2.0 * eye.eye.shift_mm.abs())));
                assert!(eye.eye.convergence_mm >= 50.0 && eye.eye.convergence_mm <= 6000.0);
            }
        }
        for mode in Mode::ALL {
            assert_eq!(Mode::named(mode.key()), Some(mode));
        }
        assert_eq!(Mode::named("red"), None);
    }
}
