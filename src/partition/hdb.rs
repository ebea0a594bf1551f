//! The haptic detecting box (Ji 2008, 3.3.3): the cube about the proxy whose triangles alone are asked in a haptic pass.

use crate::geom::{Aabb, Vec3};
use crate::surface::Surface;

/// Edge of the box over the longest edge of the surface's box. Published: at 1/10 a fast proxy punctures the surface,
/// 1/2 is slow.
pub const EDGE_PART: f64 = 0.25;

/// Published edge of the box for a surface, mm.
pub fn edge_mm(surface: &Surface) -> f64 {
    surface.bounds().size().max_element() * EDGE_PART
}

/// The published box about a proxy at `proxy`, mm.
pub fn cube(surface: &Surface, proxy: Vec3) -> Aabb {
    Aabb::cube(proxy, edge_mm(surface))
}

/// Which triangles a structure gathers for a box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Query {
    /// As published: all that the leaves list which the query of the structure finds. Without a structure, all there are.
    #[default]
    Published,
    /// Exactly those whose box overlaps the region; alike for every structure.
    Complete,
}

/// What one box query cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Gathered {
    /// Nodes entered, leaves included.
    pub nodes: usize,
    /// Leaves entered that hold triangles.
    pub leaves: usize,
    /// Triangles appended.
    pub triangles: usize,
}
