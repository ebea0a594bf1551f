//! Which triangle or ball a place in the picture sees first: a z-buffer.

use super::camera::View;
use super::picture::Ball;
use crate::geom::{Vec2, Vec3};

/// What a sample sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Seen {
    Nothing,
    Triangle(u32),
    Ball(u32),
}

/// Samples in rows from the top, `per_pixel` × `per_pixel` of them in a pixel.
pub(super) struct Samples {
    pub width: usize,
    pub height: usize,
    pub seen: Vec<Seen>,
    /// 1 / depth, per mm: it is linear across a flat triangle in the picture, and 0 stands for infinitely far.
    pub nearness: Vec<f64>,
    per_pixel: f64,
}

/// A corner in the picture: place in samples and nearness.
#[derive(Clone, Copy)]
struct Corner {
    at: Vec2,
    nearness: f64,
}

/// How far outside of a triangle a sample still counts as inside, as a share of its height: rounding opens no cracks.
const SLACK: f64 = 1.0e-9;

impl Samples {
    pub fn new(width: usize, height: usize, per_pixel: usize) -> Self {
        let (width, height) = (width * per_pixel, height * per_pixel);
        Self {
            width,
            height,
            seen: vec![Seen::Nothing; width * height],
            nearness: vec![0.0; width * height],
            per_pixel: per_pixel as f64,
        }
    }

    /// Place of a sample in the picture, pixels.
    pub fn place_px(&self, column: usize, row: usize) -> Vec2 {
        Vec2::new(column as f64 + 0.5, row as f64 + 0.5) / self.per_pixel
    }

    /// Draws a triangle. One with a corner that is missing or not finite is left out; one that crosses the near plane is cut.
    pub fn triangle(&mut self, view: &View, positions: &[Vec3], index: u32, corners: [u32; 3]) {
        let mut in_view = [Vec3::ZERO; 3];
        for (place, v) in in_view.iter_mut().zip(corners) {
            match positions.get(v as usize).map(|&p| view.in_view(p)) {
                Some(p) if p.is_finite() => *place = p,
                _ => return,
            }
        }
        let (polygon, n) = cut_at(in_view, view.near_mm);
        if n < 3 {
            return;
        }
        let corner = |p: Vec3| Corner {
            at: view.place(p) * self.per_pixel,
            nearness: 1.0 / p.z,
        };
        let placed = polygon.map(corner);
        for i in 1..n - 1 {
            self.fill([placed[0], placed[i], placed[i + 1]], Seen::Triangle(index));
        }
    }

    /// Fills a triangle that lies wholly in front of the eye.
    fn fill(&mut self, [a, b, c]: [Corner; 3], seen: Seen) {
        let doubled_area = (b.at - a.at).perp_dot(c.at - a.at);
        if doubled_area == 0.0 || !doubled_area.is_finite() {
            return;
        }
        let low = a.at.min(b.at).min(c.at);
        let high = a.at.max(b.at).max(c.at);
        let columns = covered(low.x, high.x, self.width);
        let slope_b = (c.at - a.at) / doubled_area;
        let slope_c = (b.at - a.at) / doubled_area;
        for row in covered(low.y, high.y, self.height) {
            for column in columns.clone() {
                let p = Vec2::new(column as f64 + 0.5, row as f64 + 0.5) - a.at;
                let weight_b = p.perp_dot(slope_b);
                let weight_c = slope_c.perp_dot(p);
                let weight_a = 1.0 - weight_b - weight_c;
                if weight_a < -SLACK || weight_b < -SLACK || weight_c < -SLACK {
                    continue;
                }
                let nearness =
                    weight_a * a.nearness + weight_b * b.nearness + weight_c * c.nearness;
                self.put(row * self.width + column, nearness, seen);
            }
        }
    }

    /// Draws a ball. One that is not finite, has no size or reaches behind the near plane is left out.
    pub fn ball(&mut self, view: &View, index: u32, ball: &Ball) {
        let centre = view.in_view(ball.centre_mm);
        let r = ball.radius_mm;
        let drawn = centre.is_finite() && r.is_finite() && r > 0.0 && centre.z - r >= view.near_mm;
        if !drawn {
            return;
        }
        // The box round the ball in view: its corners are at its front or back, whichever lies farther out.
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for corner in 0..8 {
            let sign = |bit: i32| if corner >> bit & 1 == 0 { -r } else { r };
            let at = view.place(centre + Vec3::new(sign(0), sign(1), sign(2))) * self.per_pixel;
            low = low.min(at);
            high = high.max(at);
        }
        let from_centre = view.eye_mm - ball.centre_mm;
        for row in covered(low.y, high.y, self.height) {
            for column in covered(low.x, high.x, self.width) {
                let ray = view.ray(self.place_px(column, row));
                if let Some(depth_mm) = ball_depth(from_centre, ray, r) {
                    self.put(row * self.width + column, 1.0 / depth_mm, Seen::Ball(index));
                }
            }
        }
    }

    /// Nearer wins; of two at the same place the first one drawn.
    fn put(&mut self, at: usize, nearness: f64, seen: Seen) {
        if nearness > self.nearness[at] {
            self.nearness[at] = nearness;
            self.seen[at] = seen;
        }
    }
}

/// Depth at which a ray from the eye first meets a ball, mm.
fn ball_depth(eye_from_centre: Vec3, ray: Vec3, radius_mm: f64) -> Option<f64> {
    let a = ray.length_squared();
    let half_b = eye_from_centre.dot(ray);
    // The distance of the ray from the centre, rather than the textbook difference of squares: it keeps its digits far away.
    let beside = eye_from_centre - ray * (half_b / a);
    let inside = radius_mm * radius_mm - beside.length_squared();
    (inside >= 0.0).then(|| (-half_b - (inside * a).sqrt()) / a)
}

/// Samples whose middle may lie between two places on an axis of `n` samples. Empty where the places are not numbers.
fn covered(low: f64, high: f64, n: usize) -> std::ops::Range<usize> {
    // A cast of a float to an integer saturates, and takes what is not a number as 0.
    let first = (low - 0.5 - SLACK).ceil().max(0.0) as usize;
    let after = ((high - 0.5 + SLACK).floor() + 1.0).max(0.0) as usize;
    first.min(n)..after.min(n)
}

/// The part of a triangle at least `near_mm` deep: up to four corners (Sutherland & Hodgman 1974), and how many.
fn cut_at(corners: [Vec3; 3], near_mm: f64) -> ([Vec3; 4], usize) {
    let mut kept = [Vec3::new(0.0, 0.0, near_mm); 4];
    let mut n = 0;
    let mut keep = |p: Vec3| {
        if n < kept.len() {
            kept[n] = p;
            n += 1;
        }
    };
    for i in 0..3 {
        let (p, next) = (corners[i], corners[(i + 1) % 3]);
        if p.z >= near_mm {
            keep(p);
        }
        if (p.z >= near_mm) != (next.z >= near_mm) {
            let share = (near_mm - p.z) / (next.z - p.z);
            keep(p.lerp(next, share).with_z(near_mm));
        }
    }
    (kept, n)
}
