//! The hybrid octree (Ji 2008, future work 4): the octree's leaves, their triangles in one list in which all that lies
//! under any node is side by side. A node wholly inside a box query answers with its part of the list at once.

#[cfg(test)]
mod tests;

use super::hdb::Gathered;
use super::octree;
use super::tree::{Options, Statistics, Tree};
use super::{Hit, Nearest, Partition, Sides};
use crate::geom::{Aabb, Vec3};
use crate::surface::Surface;

/// An octree over one list of the triangles of one surface.
#[derive(Clone, Debug)]
pub struct Hybrid {
    tree: Tree,
}

impl Hybrid {
    /// Builds the octree; of the options only the threshold counts.
    pub fn new(surface: &Surface, options: &Options) -> Self {
        Self::with_progress(surface, options, &mut |_| true).expect("nobody stops it")
    }

    /// Builds the octree. `progress` hears the share done, 0…1; when it answers `false` there is no octree.
    pub fn with_progress(
        surface: &Surface,
        options: &Options,
        progress: &mut dyn FnMut(f64) -> bool,
    ) -> Option<Self> {
        let tree = octree::build(surface, options, true, progress)?;
        Some(Self { tree })
    }

    /// The nodes.
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// Counts over the tree.
    pub fn statistics(&self, surface: &Surface) -> Statistics {
        octree::statistics(&self.tree, surface)
    }

    /// The octree's published query: see [`Tree::gather_by_cells`].
    pub fn gather_by_cells(&self, region: &Aabb, out: &mut Vec<u32>) -> Gathered {
        self.tree.gather_by_cells(region, out)
    }
}

impl Partition for Hybrid {
    fn name(&self) -> &'static str {
        "hybrid"
    }

    fn nearest(&self, surface: &Surface, p: Vec3, max_mm: f64) -> Option<Nearest> {
        self.tree.nearest(surface, p, max_mm)
    }

    fn sweep(&self, surface: &Surface, from: Vec3, to: Vec3, sides: Sides) -> Option<Hit> {
        self.tree.sweep(surface, from, to, sides)
    }

    fn in_box(&self, surface: &Surface, region: &Aabb, out: &mut Vec<u32>) {
        self.tree.gather(surface, region, out);
    }

    fn bytes(&self) -> usize {
        self.tree.bytes()
    }

    fn validate(&self, surface: &Surface) -> Result<(), String> {
        self.tree.check_one_list()?;
        octree::validate(&self.tree, surface)
    }
}
