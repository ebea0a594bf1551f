//! The yardstick: asks every triangle.

use super::{Hit, Nearest, Partition, Sides};
use crate::geom::{Aabb, Vec3};
use crate::surface::Surface;

/// No structure at all.
#[derive(Clone, Copy, Debug, Default)]
pub struct Brute;

impl Partition for Brute {
    fn name(&self) -> &'static str {
        "brute"
    }

    fn nearest(&self, surface: &Surface, p: Vec3, max_mm: f64) -> Option<Nearest> {
        if !p.is_finite() || max_mm < 0.0 || max_mm.is_nan() {
            return None;
        }
        let mut best: Option<Nearest> = None;
        let mut bound = max_mm * max_mm;
        for triangle in 0..surface.triangles().len() as u32 {
            let point = surface.triangle(triangle).closest_point(p).point;
            let distance_sq = point.distance_squared(p);
            if distance_sq < bound || (best.is_none() && distance_sq <= bound) {
                bound = distance_sq;
                best = Some(Nearest {
                    triangle,
                    point,
                    distance_sq,
                });
            }
        }
        best
    }

    fn sweep(&self, surface: &Surface, from: Vec3, to: Vec3, sides: Sides) -> Option<Hit> {
        if !from.is_finite() || !(to - from).is_finite() {
            return None;
        }
        let mut best: Option<Hit> = None;
        for triangle in 0..surface.triangles().len() as u32 {
            let Some(c) = surface.triangle(triangle).crossing(from, to) else {
                continue;
            };
            if (c.inward || sides == Sides::Both) && best.is_none_or(|b| c.t < b.t) {
                best = Some(Hit {
                    triangle,
                    t: c.t,
                    point: from + (to - from) * c.t,
                    inward: c.inward,
                });
            }
        }
        best
    }

    fn in_box(&self, surface: &Surface, region: &Aabb, out: &mut Vec<u32>) {
        out.extend(
            (0..surface.triangles().len() as u32)
                .filter(|&t| surface.triangle(t).aabb().overlaps(region)),
        );
    }

    fn bytes(&self) -> usize {
        0
    }

    fn validate(&self, _surface: &Surface) -> Result<(), String> {
        Ok(())
    }
}
