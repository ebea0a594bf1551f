//! Fingers that press by themselves, so that a picture shows a dent and plots show lines.

use crate::device::mouse::MouseHandle;
use crate::geom::Vec3;
use crate::scenario::Scene;

/// Where each finger presses: share of the half width from the middle, and of the height from below.
const PLACES: [(f64, f64); 2] = [(-0.28, 0.52), (0.28, 0.62)];
/// How deep each presses, mm.
const DEPTHS_MM: [f64; 2] = [9.0, 15.0];
/// Time from the air to the full depth, s.
const APPROACH_S: f64 = 0.8;
/// Height from which they come, mm.
const HEIGHT_MM: f64 = 12.0;

/// The fingers on their way.
#[derive(Clone, Debug, Default)]
pub struct Demo {
    time_s: f64,
    /// Point and outward normal where each finger presses, once known.
    places: Vec<(Vec3, Vec3)>,
}

impl Demo {
    /// Moves the hands on by `dt_s`.
    pub fn advance<'a>(
        &mut self,
        dt_s: f64,
        scene: &Scene,
        hands: impl Iterator<Item = &'a MouseHandle>,
    ) {
        if self.places.is_empty() {
            self.places = PLACES.map(|p| place(scene, p)).to_vec();
        }
        self.time_s += dt_s;
        for (i, (hand, (point, normal))) in hands.zip(&self.places).enumerate() {
            let way = (self.time_s / APPROACH_S).min(1.0);
            let swing = 0.15 * libm::sin(3.0 * (self.time_s - APPROACH_S).max(0.0));
            let depth = -HEIGHT_MM + way * (HEIGHT_MM + DEPTHS_MM[i % 2] * (1.0 + swing));
            let pad_mm = scene.touch.choices.pad_mm().unwrap_or(0.0);
            hand.set(*point + *normal * (pad_mm - depth));
        }
    }
}

/// The vertex nearest to a place on the back, seen from behind, and its normal.
fn place(scene: &Scene, (across, up): (f64, f64)) -> (Vec3, Vec3) {
    let bounds = scene.surface.bounds();
    let middle = (bounds.min + bounds.max) * 0.5;
    let x = middle.x + across * (bounds.max.x - middle.x);
    let y = bounds.min.y + up * (bounds.max.y - bounds.min.y);
    let distance = |p: &Vec3| (p.x - x) * (p.x - x) + (p.y - y) * (p.y - y);
    scene
        .surface
        .positions()
        .iter()
        .zip(scene.surface.normals())
        .filter(|(_, n)| n.z > 0.5)
        .min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)))
        .map_or((middle, Vec3::Z), |(p, n)| (*p, *n))
}
