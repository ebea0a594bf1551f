//! What a tree looks like in numbers.

use super::{Case, Tree};
use crate::partition::hdb::Gathered;
use crate::surface::Surface;

/// Leaves that hold `from`…`to` entries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Occupancy {
    /// Fewest entries.
    pub from: usize,
    /// Most entries.
    pub to: usize,
    /// How many leaves.
    pub leaves: usize,
}

/// Counts over one tree. What the build took is for the caller to measure.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Statistics {
    /// Most triangles a leaf should hold.
    pub threshold: usize,
    /// What becomes of a triangle on the plane.
    pub case: Case,
    /// Triangles of the surface.
    pub triangles: usize,
    /// Entries in the leaves: pieces in case A, copies counted in case B.
    pub entries: usize,
    /// Nodes, leaves and empty ones included.
    pub nodes: usize,
    /// Leaves, empty ones included.
    pub leaves: usize,
    /// Leaves that hold nothing.
    pub empty_leaves: usize,
    /// Leaves above the threshold: their triangles cannot be told apart, or only by listing too many twice.
    pub unsplittable_leaves: usize,
    /// Levels under the root.
    pub height: u32,
    /// Worst cost of finding one leaf, over finding it in a list: w = (nodes visited / all nodes) / (1 / leaves).
    pub w: f64,
    /// The same for a complete tree of this height: see [`super::worst_w`].
    pub w_complete: f64,
    /// Mean number of entries in a leaf that is not empty.
    pub mean_occupancy: f64,
    /// Most entries in a leaf.
    pub max_occupancy: usize,
    /// Mean number of other leaves whose bounds share a point with a leaf's bounds; empty leaves do not count.
    pub mean_overlap: f64,
    /// Triangles that the published octree rule loses, since no two of their vertices lie in one cell: those that span
    /// three octants, and those that jut out. Held all the same. Always 0 for a BSP.
    pub lost_as_published: usize,
    /// Memory held, bytes.
    pub bytes: usize,
    /// Leaves by how much they hold: none, 1, 2–3, 4–7 and so on.
    pub occupancy: Vec<Occupancy>,
}

impl Tree {
    /// Counts over the tree. The overlap asks each leaf against the tree: for large trees that takes as long as the build.
    pub(in crate::partition) fn statistics(&self, surface: &Surface, case: Case) -> Statistics {
        let leaves = || self.nodes.iter().filter(|n| n.is_leaf());
        let full = || leaves().filter(|n| n.held > 0);
        let n_leaves = leaves().count();
        let n_full = full().count();
        let entries: usize = full().map(|n| n.held as usize).sum();
        let max_occupancy = leaves().map(|n| n.held as usize).max().unwrap_or(0);
        let overlaps: usize = full().map(|leaf| self.leaves_over(leaf) - 1).sum();
        let mean = |sum: usize| sum as f64 / n_full.max(1) as f64;
        Statistics {
            threshold: self.threshold,
            case,
            triangles: surface.triangles().len(),
            entries,
            nodes: self.nodes.len(),
            leaves: n_leaves,
            empty_leaves: n_leaves - n_full,
            unsplittable_leaves: self.unsplittable,
            height: self.height(),
            w: f64::from(self.height() + 1) / self.nodes.len().max(1) as f64 * n_leaves as f64,
            w_complete: super::worst_w(self.fanout, self.height()),
            mean_occupancy: mean(entries),
            max_occupancy,
            mean_overlap: mean(overlaps),
            lost_as_published: 0,
            bytes: self.bytes(),
            occupancy: self.occupancy(max_occupancy),
        }
    }

    fn occupancy(&self, most: usize) -> Vec<Occupancy> {
        let bin = |held: usize| (usize::BITS - held.leading_zeros()) as usize;
        let mut bins: Vec<Occupancy> = (0..=bin(most))
            .map(|i| Occupancy {
                from: (1 << i) >> 1,
                to: (1_usize << i) - 1,
                leaves: 0,
            })
            .collect();
        for leaf in self.nodes.iter().filter(|n| n.is_leaf()) {
            bins[bin(leaf.held as usize)].leaves += 1;
        }
        bins
    }

    /// Number of leaves whose bounds share a point with those of `leaf`, itself included.
    fn leaves_over(&self, leaf: &super::Node) -> usize {
        let Gathered { leaves, .. } = self.visit(
            |_, node| node.bounds.overlaps(&leaf.bounds),
            |node| node.is_leaf(),
        );
        leaves.max(1)
    }
}
