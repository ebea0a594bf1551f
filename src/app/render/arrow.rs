//! A force as an arrow: its length is proportional to the force.

use super::solid::Solids;
use crate::geom::{Vec3, any_tangent, unit_or};
use std::f64::consts::TAU;

/// Where it starts, what it shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrow {
    /// Its tail, mm.
    pub from_mm: Vec3,
    /// From tail to tip, mm.
    pub along_mm: Vec3,
    /// Its colour, sRGB.
    pub color: [u8; 3],
}

impl Arrow {
    /// Its tip, mm.
    pub fn tip_mm(&self) -> Vec3 {
        self.from_mm + self.along_mm
    }

    /// Adds it to a batch; nothing is added for an arrow too short to have a direction.
    pub(super) fn add_to(&self, solids: &mut Solids) {
        const SIDES: u32 = 20;
        let length = self.along_mm.length();
        let axis = unit_or(self.along_mm, Vec3::ZERO);
        if !length.is_finite() || length < 0.5 || axis == Vec3::ZERO {
            return;
        }
        // Short arrows keep their proportions, long ones do not grow thick.
        let head = (0.34 * length).min(9.0);
        let (shaft_radius, head_radius) = (0.13 * head.max(3.0), 0.36 * head);
        let (u, neck) = (any_tangent(axis), self.from_mm + axis * (length - head));
        let v = axis.cross(u);
        let slope = axis * (head_radius / head);
        let first = solids.vertices.len() as u32;
        for i in 0..=SIDES {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(SIDES)).sin_cos();
            let out = u * cos + v * sin;
            let cone = unit_or(out + slope, out);
            for (p, n) in [
                (self.from_mm, -axis),
                (self.from_mm + out * shaft_radius, -axis),
                (self.from_mm + out * shaft_radius, out),
                (neck + out * shaft_radius, out),
                (neck + out * shaft_radius, -axis),
                (neck + out * head_radius, -axis),
                (neck + out * head_radius, cone),
                (self.tip_mm(), cone),
            ] {
                solids.vertex(p, n, self.color);
            }
        }
        for i in 0..SIDES {
            let a = first + 8 * i;
            for strip in [0, 2, 4, 6] {
                let (low, high) = (a + strip, a + strip + 1);
                solids.quad(low, low + 8, high + 8, high);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::render::solid::SolidVertex;

    fn solids(along_mm: Vec3) -> Solids {
        let mut s = Solids::default();
        Arrow {
            from_mm: Vec3::ZERO,
            along_mm,
            color: [0; 3],
        }
        .add_to(&mut s);
        s
    }

    #[test]
    fn no_force_no_arrow_and_no_nan() {
        for along in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
            assert!(solids(along).vertices.is_empty());
        }
    }

    #[test]
    fn every_face_of_an_arrow_looks_outward() {
        let s = solids(Vec3::new(0.0, 3.0, 20.0));
        for t in s.indices.chunks(3) {
            let [p, n] = [SolidVertex::position_f64, SolidVertex::normal_f64]
                .map(|of| [0, 1, 2].map(|k| of(&s.vertices[t[k] as usize])));
            let face = (p[1] - p[0]).cross(p[2] - p[0]);
            assert!(face.length() < 1e-6 || face.dot(n[0] + n[1] + n[2]) > 0.0);
        }
    }
}
