//! The shaded back, drawn in software.
//!
//! Light is linear inside and sRGB outside. Three lights hang on the camera (key from the upper left, low enough to rake over
//! the relief, fill from the right, rim from behind), so that the back reads from any direction.

use super::camera::{Camera, View};
use super::image::Image;
use super::raster::{Samples, Seen};
use super::relief::{Spot, hollowness};
use crate::geom::{Vec3, unit_or};

/// A picture is at most this wide and high, pixels; a larger one is drawn at this size.
pub const MAX_SIDE_PX: usize = 4096;
/// Samples along each side of a pixel.
const PER_PIXEL: usize = 2;
/// sRGB colour of skin.
const SKIN: [u8; 3] = [222, 176, 150];
/// sRGB colour of the inside of an open skin: plain, so that it is not taken for the back.
const INSIDE: [u8; 3] = [128, 122, 122];
/// sRGB colours of the background at its top and bottom.
const BACKGROUND: [[u8; 3]; 2] = [[232, 237, 243], [196, 207, 220]];
/// Half the windows in which hollows are sought, mm: one for a fingertip's dent, one for the spinal furrow.
const WINDOWS_MM: [f64; 2] = [10.0, 30.0];
/// Hollowness that counts as hollow, for each window; far more of it is drawn little darker. A dent of 2 mm under a fingertip has 0.05 to 0.1.
const FULL_HOLLOW: [f64; 2] = [0.06, 0.14];

/// A sphere: a fingertip or a mark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Centre, mm.
    pub centre_mm: Vec3,
    /// Radius, mm. A ball without a positive one is not drawn.
    pub radius_mm: f64,
    /// sRGB colour.
    pub colour: [u8; 3],
}

/// What is drawn, from where, and how large.
///
/// Nothing here can make [`Picture::render`] fail: a triangle that names a missing vertex, or has a corner that is not
/// finite, is left out, and what lies behind the eye is cut away.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Vertex positions, mm.
    pub positions: &'a [Vec3],
    /// Unit normals at the vertices. Where one is missing or not finite the triangle's own is taken.
    pub normals: &'a [Vec3],
    /// Corner indices, counter-clockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
    /// sRGB colour of every vertex; skin where there is none.
    pub colours: Option<&'a [[u8; 3]]>,
    /// Fingers and marks.
    pub balls: &'a [Ball],
    /// From where.
    pub camera: Camera,
    /// Pixels in a row, at most [`MAX_SIDE_PX`].
    pub width: usize,
    /// Rows, at most [`MAX_SIDE_PX`].
    pub height: usize,
}

impl Picture<'_> {
    /// Draws the picture: the same bytes on every machine. A camera that sees nothing gives the background alone.
    pub fn render(&self) -> Image {
        let width = self.width.min(MAX_SIDE_PX);
        let height = self.height.min(MAX_SIDE_PX);
        let mut samples = Samples::new(width, height, PER_PIXEL);
        let mut hollows = vec![0.0; width * height];
        let view = View::new(&self.camera, width, height);
        if let Some(view) = &view {
            for (&corners, index) in self.triangles.iter().zip(0..) {
                samples.triangle(view, self.positions, index, corners);
            }
            hollows = self.hollows(view, &samples, width);
            for (ball, index) in self.balls.iter().zip(0..) {
                samples.ball(view, index, ball);
            }
        }
        let tone = Tone::new();
        let mut rgb = Vec::with_capacity(3 * width * height);
        for row in 0..height {
            let background = background(row, height);
            for column in 0..width {
                let mut sum = Vec3::ZERO;
                for sub in 0..PER_PIXEL * PER_PIXEL {
                    let (x, y) = (
                        column * PER_PIXEL + sub % PER_PIXEL,
                        row * PER_PIXEL + sub / PER_PIXEL,
                    );
                    sum += view.as_ref().map_or(background, |view| {
                        let hollow = hollows[row * width + column];
                        self.sample(view, &samples, x, y, hollow, background)
                    });
                }
                rgb.extend(tone.srgb(sum / (PER_PIXEL * PER_PIXEL) as f64));
            }
        }
        Image { width, height, rgb }
    }

    /// Hollowness of the skin at every pixel, from −1 (ridge) to 1 (hollow), whether or not a ball hides it.
    fn hollows(&self, view: &View, samples: &Samples, width: usize) -> Vec<f64> {
        let n_pixels = samples.seen.len() / (PER_PIXEL * PER_PIXEL);
        let spots: Vec<Option<Spot>> = (0..n_pixels)
            .map(|pixel| {
                let (column, row) = (pixel % width * PER_PIXEL, pixel / width * PER_PIXEL);
                (0..PER_PIXEL * PER_PIXEL).find_map(|sub| {
                    let (x, y) = (column + sub % PER_PIXEL, row + sub / PER_PIXEL);
                    match samples.seen[y * samples.width + x] {
                        Seen::Triangle(index) => {
                            let lit = self.skin_at(view, samples, x, y, index)?;
                            Some(Spot {
                                position_mm: lit.position_mm,
                                normal: lit.normal,
                            })
                        }
                        _ => None,
                    }
                })
            })
            .collect();
        let px_per_mm = view.focal_px / view.target_depth_mm;
        let mut hollows = vec![0.0; n_pixels];
        for (radius_mm, full) in WINDOWS_MM.into_iter().zip(FULL_HOLLOW) {
            let found = hollowness(&spots, width, radius_mm * px_per_mm, radius_mm);
            for ((sum, found), spot) in hollows.iter_mut().zip(found).zip(&spots) {
                // A window in the picture reaches farther over skin that is seen aslant.
                let facing = spot.map_or(1.0, |s| {
                    s.normal
                        .dot(unit_or(view.eye_mm - s.position_mm, view.back))
                });
                *sum += found / full * facing;
            }
        }
        hollows
            .iter_mut()
            .for_each(|h| *h /= (1.0 + *h * *h).sqrt());
        hollows
    }

    /// Linear light that one sample sees.
    fn sample(
        &self,
        view: &View,
        samples: &Samples,
        x: usize,
        y: usize,
        hollow: f64,
        background: Vec3,
    ) -> Vec3 {
        let at = y * samples.width + x;
        let lit = match samples.seen[at] {
            Seen::Nothing => None,
            Seen::Triangle(index) => self.skin_at(view, samples, x, y, index),
            Seen::Ball(index) => self.balls.get(index as usize).map(|ball| {
                let position_mm = seen_at(view, samples, x, y);
                Lit {
                    position_mm,
                    normal: unit_or(position_mm - ball.centre_mm, view.back),
                    albedo: linear(ball.colour),
                    finish: Finish::Ball,
                }
            }),
        };
        lit.map_or(background, |lit| shade(view, &lit, hollow, self.balls))
    }

    /// The skin where a sample sees it.
    fn skin_at(
        &self,
        view: &View,
        samples: &Samples,
        x: usize,
        y: usize,
        index: u32,
    ) -> Option<Lit> {
        let corners = *self.triangles.get(index as usize)?;
        let [a, b, c] = corners.map(|v| self.positions.get(v as usize).copied());
        let (a, b, c) = (a?, b?, c?);
        let p = seen_at(view, samples, x, y);
        let area_normal = (b - a).cross(c - a);
        let doubled_area_sq = area_normal.length_squared();
        let share = |from: Vec3, to: Vec3| {
            let share = (to - from).cross(p - from).dot(area_normal) / doubled_area_sq;
            if share.is_finite() {
                share.clamp(0.0, 1.0)
            } else {
                1.0 / 3.0
            }
        };
        let weights = [share(b, c), share(c, a), share(a, b)];
        let flat = unit_or(area_normal, view.back);
        let smooth: Vec3 = corners
            .iter()
            .zip(weights)
            .map(|(&v, w)| self.normals.get(v as usize).copied().unwrap_or(flat) * w)
            .sum();
        let towards_eye = view.eye_mm - p;
        let outside = flat.dot(towards_eye) >= 0.0;
        let normal = unit_or(smooth, flat);
        let albedo = match self.colours {
            _ if !outside => linear(INSIDE),
            None => linear(SKIN),
            Some(colours) => corners
                .iter()
                .zip(weights)
                .map(|(&v, w)| linear(colours.get(v as usize).copied().unwrap_or(SKIN)) * w)
                .sum(),
        };
        Some(Lit {
            position_mm: p,
            normal: if outside { normal } else { -normal },
            albedo,
            finish: if outside {
                Finish::Skin
            } else {
                Finish::Inside
            },
        })
    }
}

/// Where the surface seen by a sample lies, mm.
fn seen_at(view: &View, samples: &Samples, x: usize, y: usize) -> Vec3 {
    let depth_mm = 1.0 / samples.nearness[y * samples.width + x];
    view.eye_mm + view.ray(samples.place_px(x, y)) * depth_mm
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Finish {
    Skin,
    Inside,
    Ball,
}

/// A place that light falls on.
struct Lit {
    position_mm: Vec3,
    normal: Vec3,
    albedo: Vec3,
    finish: Finish,
}

/// Linear light from a place to the eye. `hollow` is −1 on a ridge, 0 on the flat, 1 in a hollow.
fn shade(view: &View, lit: &Lit, hollow: f64, balls: &[Ball]) -> Vec3 {
    let in_scene = |right: f64, up: f64, back: f64| {
        unit_or(
            view.right * right + view.up * up + view.back * back,
            view.back,
        )
    };
    let key = in_scene(-0.70, 0.52, 0.49);
    let fill = in_scene(0.85, 0.05, 0.52);
    let rim = in_scene(0.35, 0.65, -0.68);
    let n = lit.normal;
    let to_eye = unit_or(view.eye_mm - lit.position_mm, view.back);
    let is_ball = lit.finish == Finish::Ball;

    let (mut tint, mut open, mut key_open) = (Vec3::ONE, 1.0, 1.0);
    if !is_ball {
        let (deep, high) = (hollow.max(0.0), (-hollow).max(0.0));
        // Light bounced in a hollow is warm.
        tint = Vec3::ONE - Vec3::new(0.58, 0.70, 0.74) * deep + Vec3::splat(0.10 * high);
        key_open *= 1.0 - 0.40 * deep + 0.10 * high;
        for ball in balls {
            let (o, k) = openness_under(ball, lit.position_mm, n, key);
            open *= o;
            key_open *= k;
        }
    }

    // Light wraps past the terminator, red farthest: what scattering under the skin does to the edge of a shadow. The
    // square lets it end without a crease.
    let wrap = if is_ball {
        Vec3::splat(0.25)
    } else {
        Vec3::new(0.60, 0.52, 0.48)
    };
    let wrapped = |light: Vec3| {
        let share = ((Vec3::splat(n.dot(light)) + wrap) / (Vec3::ONE + wrap)).max(Vec3::ZERO);
        share * share
    };
    let sky =
        Vec3::new(0.19, 0.17, 0.16).lerp(Vec3::new(0.29, 0.285, 0.285), 0.5 + 0.5 * n.dot(view.up));
    let around = tint * open;
    let diffuse = sky * around
        + wrapped(key) * Vec3::new(1.08, 1.04, 1.0) * key_open
        + wrapped(fill) * Vec3::new(0.22, 0.22, 0.22) * around;

    let half = unit_or(key + to_eye, n);
    let gloss = power(n.dot(half).max(0.0), 4 + u32::from(is_ball))
        * n.dot(key).max(0.0)
        * key_open
        * if is_ball { 0.22 } else { 0.05 };
    let facing = n.dot(to_eye).clamp(0.0, 1.0);
    let grazing = (1.0 - facing) * (1.0 - facing) * (1.0 - facing);
    let edge = grazing * (0.35 + 0.65 * n.dot(rim)).max(0.0) * open * 0.14;
    let (gloss, edge) = if lit.finish == Finish::Inside {
        (0.0, 0.0)
    } else {
        (gloss, edge)
    };
    lit.albedo * diffuse + Vec3::splat(gloss) + Vec3::new(1.0, 0.95, 0.90) * edge
}

/// What a ball leaves of the sky and of the key light at a point p with normal n: 1 far away.
fn openness_under(ball: &Ball, p: Vec3, n: Vec3, key: Vec3) -> (f64, f64) {
    let r = ball.radius_mm;
    if !(r > 0.0 && r.is_finite() && ball.centre_mm.is_finite()) {
        return (1.0, 1.0);
    }
    let d = ball.centre_mm - p;
    let reach = d.length().max(r);
    // Share of the hemisphere that the ball takes up, weighed by the cosine.
    let cover = (n.dot(d) / reach).clamp(0.0, 1.0) * (r / reach) * (r / reach);
    let along = d.dot(key);
    let miss = (d.length_squared() - along * along).max(0.0).sqrt();
    let soft = 0.3 * r + 0.15 * along.max(0.0);
    let shadow = if along > 0.0 {
        1.0 - smooth_step((miss - r + soft) / (2.0 * soft))
    } else {
        0.0
    };
    (1.0 - 0.8 * cover, 1.0 - 0.45 * shadow)
}

fn smooth_step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// `x` to the power of 2 to the `doublings`.
fn power(x: f64, doublings: u32) -> f64 {
    (0..doublings).fold(x, |x, _| x * x)
}

fn background(row: usize, height: usize) -> Vec3 {
    let [top, bottom] = BACKGROUND.map(linear);
    top.lerp(bottom, smooth_step((row as f64 + 0.5) / height as f64))
}

/// Linear light of an sRGB colour, by a polynomial that is exact at black and white and within 0.003 in between.
fn linear(colour: [u8; 3]) -> Vec3 {
    let [r, g, b] = colour.map(|c| {
        let s = f64::from(c) / 255.0;
        s * (s * (s * 0.305306011 + 0.682171111) + 0.012522878)
    });
    Vec3::new(r, g, b)
}

/// From linear light to sRGB bytes, by table.
struct Tone {
    bytes: Vec<u8>,
}

impl Tone {
    const STEPS: usize = 4095;

    fn new() -> Self {
        let byte = |i: usize| {
            let c = i as f64 / Self::STEPS as f64;
            let s = if c <= 0.003_130_8 {
                12.92 * c
            } else {
                1.055 * libm::pow(c, 1.0 / 2.4) - 0.055
            };
            (s * 255.0).round() as u8
        };
        Self {
            bytes: (0..=Self::STEPS).map(byte).collect(),
        }
    }

    fn srgb(&self, light: Vec3) -> [u8; 3] {
        light.to_array().map(|c| {
            let step = (c.clamp(0.0, 1.0) * Self::STEPS as f64).round() as usize;
            self.bytes[step.min(Self::STEPS)]
        })
    }
}
