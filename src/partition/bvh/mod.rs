//! The production structure: a bounding volume hierarchy, four children to a node.
//!
//! Boxes are `f32`, relative to the surface's own box and rounded outward, so they always hold what they should; they
//! only decide what need not be asked. Every answer comes from the `f64` triangles at the leaves and equals
//! [`brute`](super::brute)'s. About 18 bytes per triangle.

mod build;
mod crossed;
mod query;
mod validate;

#[cfg(test)]
mod tests;

use super::{Hit, Nearest, Partition, Sides};
use crate::geom::{Aabb, TrianglePoint, Vec3};
use crate::surface::Surface;

/// Most triangles in a leaf. Fewer: more nodes to hold; more: more exact tests per query.
const LEAF_TRIANGLES: usize = 4;
/// Bits of a child reference that hold the first position in `order`; bounds the number of triangles.
const START_BITS: u32 = 29;
/// Stands for "no child".
const NO_CHILD: u32 = u32::MAX;
/// Levels of two-way splits spent above a perfectly balanced tree before splits are forced to halve. A split into two
/// levels makes one level of nodes.
const SPARE_LEVELS: u32 = 8;
/// Entries a query's stack can ever need: 29 + 8 two-way levels are at most 19 levels of nodes, and each level leaves
/// at most three siblings waiting, plus the four of the last.
const STACK: usize = 64;

/// Four children: their boxes, one array per axis so that four are tested at once, and where they are.
#[derive(Clone, Copy, Debug)]
struct Node {
    min: [[f32; 4]; 3],
    max: [[f32; 4]; 3],
    child: [u32; 4],
}

impl Node {
    const EMPTY: Self = Self {
        min: [[f32::INFINITY; 4]; 3],
        max: [[f32::NEG_INFINITY; 4]; 3],
        child: [NO_CHILD; 4],
    };
}

/// What a child reference stands for.
enum Child {
    Node(u32),
    /// First position in `order` and number of triangles.
    Leaf(usize, usize),
    None,
}

fn leaf_child(start: usize, count: usize) -> u32 {
    1 << 31 | (count as u32 - 1) << START_BITS | start as u32
}

fn unpack(child: u32) -> Child {
    if child == NO_CHILD {
        Child::None
    } else if child >> 31 == 0 {
        Child::Node(child)
    } else {
        let start = child & ((1 << START_BITS) - 1);
        let count = (child >> START_BITS & 3) + 1;
        Child::Leaf(start as usize, count as usize)
    }
}

/// Where the boxes live: x' = (x − centre) · scale lies in −1…1 for every vertex. The scale is a power of two, so that
/// multiplying loses nothing.
#[derive(Clone, Copy, Debug)]
struct BoxFrame {
    centre_mm: Vec3,
    scale_per_mm: f64,
    /// Largest coordinate of the surface as it was given, mm: sets the rounding of the exact tests.
    reach_mm: f64,
}

impl BoxFrame {
    fn of(surface: &Surface) -> Self {
        let bounds = surface.bounds();
        let half = (bounds.size() / 2.0).max_element();
        let scale_per_mm = if half.is_finite() && half > 0.0 {
            libm::exp2(-libm::ceil(libm::log2(half)).clamp(-1000.0, 1000.0))
        } else {
            1.0
        };
        Self {
            centre_mm: bounds.centre(),
            scale_per_mm,
            reach_mm: bounds.min.abs().max(bounds.max.abs()).max_element(),
        }
    }

    fn to_box(self, p: Vec3) -> Vec3 {
        (p - self.centre_mm) * self.scale_per_mm
    }

    /// How far the boxes must be grown for a query near `p`, in box units, so that no rounding of the exact tests, which
    /// work in mm about the frame's origin, can find what the boxes excluded.
    fn pad(self, p: Vec3) -> f64 {
        let reach = self.reach_mm + p.abs().max_element();
        8.0 * f64::EPSILON * (reach * self.scale_per_mm + 1.0)
    }
}

/// A bounding volume hierarchy over the triangles of one surface.
#[derive(Clone, Debug)]
pub struct Bvh {
    frame: BoxFrame,
    /// The root is the first.
    nodes: Box<[Node]>,
    /// Triangles in the order of the leaves.
    order: Box<[u32]>,
    /// One bit per triangle: another sheet runs through it or touches it. Empty where that is so of none.
    crossed: Box<[u64]>,
}

impl Bvh {
    /// Builds the hierarchy, on several threads where there are several; the result does not depend on how many.
    ///
    /// At most 2^29 triangles are taken in.
    pub fn new(surface: &Surface) -> Self {
        build::build(surface)
    }

    /// Whether another sheet of the surface runs through triangle `t` or touches it: only there can a motion along the
    /// triangle meet another one.
    pub fn is_crossed(&self, t: u32) -> bool {
        let word = self.crossed.get(t as usize / 64).unwrap_or(&0);
        word >> (t % 64) & 1 == 1
    }

    /// The closest point within `max_mm` of `p` among those that `accept` lets count.
    pub fn nearest_where(
        &self,
        surface: &Surface,
        p: Vec3,
        max_mm: f64,
        accept: impl Fn(u32, &TrianglePoint) -> bool,
    ) -> Option<Nearest> {
        query::nearest(self, surface, p, max_mm, accept)
    }

    /// Calls `visit` with every triangle whose box comes within `reach_mm` of `p`, and perhaps some that come near.
    pub fn around(&self, p: Vec3, reach_mm: f64, mut visit: impl FnMut(u32)) {
        let q = self.frame.to_box(p);
        let reach = reach_mm * self.frame.scale_per_mm + self.frame.pad(p);
        let (low, high) = ((q - reach).to_array(), (q + reach).to_array());
        query::leaves_in(self, low, high, |start, count| {
            self.order[start..start + count]
                .iter()
                .for_each(|&t| visit(t));
        });
    }
}

impl Partition for Bvh {
    fn name(&self) -> &'static str {
        "bvh"
    }

    fn nearest(&self, surface: &Surface, p: Vec3, max_mm: f64) -> Option<Nearest> {
        query::nearest(self, surface, p, max_mm, |_, _| true)
    }

    fn sweep(&self, surface: &Surface, from: Vec3, to: Vec3, sides: Sides) -> Option<Hit> {
        query::sweep(self, surface, from, to, sides)
    }

    fn in_box(&self, surface: &Surface, region: &Aabb, out: &mut Vec<u32>) {
        query::in_box(self, surface, region, out);
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.order[..]) + size_of_val(&self.crossed[..])
    }

    fn validate(&self, surface: &Surface) -> Result<(), String> {
        validate::validate(self, surface)
    }
}
