//! A finger's sphere.

use super::solid::Solids;
use crate::geom::Vec3;
use std::f64::consts::{PI, TAU};

/// Where it is and what it looks like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Its centre, mm.
    pub centre_mm: Vec3,
    /// Its radius, mm.
    pub radius_mm: f64,
    /// Its colour, sRGB.
    pub color: [u8; 3],
}

impl Sphere {
    /// Adds it to a batch: 24 meridians, 16 parallels, smooth at the sizes a finger has on a screen.
    pub(super) fn add_to(&self, solids: &mut Solids) {
        const MERIDIANS: u32 = 24;
        const PARALLELS: u32 = 16;
        let first = solids.vertices.len() as u32;
        for j in 0..=PARALLELS {
            let (sin_j, cos_j) = (PI * f64::from(j) / f64::from(PARALLELS)).sin_cos();
            for i in 0..=MERIDIANS {
                let (sin_i, cos_i) = (TAU * f64::from(i) / f64::from(MERIDIANS)).sin_cos();
                let n = Vec3::new(sin_j * cos_i, cos_j, -sin_j * sin_i);
                solids.vertex(self.centre_mm + n * self.radius_mm, n, self.color);
            }
        }
        let row = MERIDIANS + 1;
        for j in 0..PARALLELS {
            for i in 0..MERIDIANS {
                let a = first + j * row + i;
                solids.quad(a, a + row, a + row + 1, a + 1);
            }
        }
    }
}
