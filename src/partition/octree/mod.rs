//! The published octree (Ji 2008, 3.4): eight children about the middle of the cell; a triangle goes to the child with at
//! least two of its vertices. Where three vertices lie in three children, which the publication leaves open and so loses
//! the triangle, it goes to the child that holds its centroid.

#[cfg(test)]
mod tests;

use super::hdb::Gathered;
use super::tree::{self, Case, MAX_HALVINGS, Options, Ownership, Rule, Statistics, Tree};
use super::{Hit, Nearest, Partition, Sides};
use crate::geom::{Aabb, Vec3};
use crate::surface::Surface;

/// An octree over the triangles of one surface; every leaf has a list of its own.
#[derive(Clone, Debug)]
pub struct Octree {
    tree: Tree,
}

impl Octree {
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
        let tree = build(surface, options, false, progress)?;
        Some(Self { tree })
    }

    /// The nodes.
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// Counts over the tree.
    pub fn statistics(&self, surface: &Surface) -> Statistics {
        statistics(&self.tree, surface)
    }

    /// Triangles that the published rule loses, in rising order: no two of their vertices lie in the cell of their leaf.
    pub fn lost_as_published(&self, surface: &Surface) -> Vec<u32> {
        let mut lost = lost_as_published(&self.tree, surface);
        lost.sort_unstable();
        lost
    }

    /// The published query (Ji 2008, 3.4.1): see [`Tree::gather_by_cells`].
    pub fn gather_by_cells(&self, region: &Aabb, out: &mut Vec<u32>) -> Gathered {
        self.tree.gather_by_cells(region, out)
    }
}

pub(super) fn build(
    surface: &Surface,
    options: &Options,
    one_list: bool,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Option<Tree> {
    let rule = Octants {
        surface,
        finest: surface.bounds().size() * libm::exp2(-f64::from(MAX_HALVINGS)),
    };
    let all = (0..surface.triangles().len() as u32).collect();
    let grown = tree::grow(&rule, surface, all, options.threshold, progress)?;
    Some(Tree::keep::<Octants<'_>>(
        &grown, surface, options, one_list,
    ))
}

pub(super) fn statistics(tree: &Tree, surface: &Surface) -> Statistics {
    Statistics {
        lost_as_published: lost_as_published(tree, surface).len(),
        ..tree.statistics(surface, Case::C)
    }
}

fn lost_as_published(tree: &Tree, surface: &Surface) -> Vec<u32> {
    let mut lost = Vec::new();
    for leaf in tree.nodes() {
        lost.extend(tree.held(leaf).iter().filter(|&&t| {
            let t = surface.triangle(t);
            let inside = [t.a, t.b, t.c].map(|p| leaf.cell.contains(p));
            inside.iter().filter(|&&i| i).count() < 2
        }));
    }
    lost
}

/// Cells halve on every axis, and every triangle lies in the leaf to which the rule leads.
pub(super) fn validate(tree: &Tree, surface: &Surface) -> Result<(), String> {
    tree.check(surface, octants, Ownership::One, false)?;
    for at in 0..tree.nodes().len() {
        for &t in tree.held(&tree.nodes()[at]) {
            let mut led = 0;
            while let node = &tree.nodes()[led]
                && !node.is_leaf()
            {
                led = tree.children(node).start as usize + child_of(surface, &node.cell, t);
            }
            if led != at {
                return Err(format!("triangle {t} is in leaf {at}, should be in {led}"));
            }
        }
    }
    Ok(())
}

/// Which octant about `centre` a point is in: bit 0, 1, 2 for the upper half of x, y, z.
fn octant(centre: Vec3, p: Vec3) -> usize {
    (0..3).fold(0, |o, k| o | usize::from(p[k] >= centre[k]) << k)
}

fn child_of(surface: &Surface, cell: &Aabb, triangle: u32) -> usize {
    let t = surface.triangle(triangle);
    let centre = cell.centre();
    let [a, b, c] = [t.a, t.b, t.c].map(|p| octant(centre, p));
    if a == b || a == c {
        a
    } else if b == c {
        b
    } else {
        octant(centre, t.centroid())
    }
}

/// The eight parts of a cell.
fn octants(cell: &Aabb, _level: u32) -> [Aabb; 8] {
    let centre = cell.centre();
    std::array::from_fn(|o| {
        let (mut part, upper) = (*cell, |k: usize| o >> k & 1 == 1);
        for k in 0..3 {
            if upper(k) {
                part.min[k] = centre[k];
            } else {
                part.max[k] = centre[k];
            }
        }
        part
    })
}

struct Octants<'a> {
    surface: &'a Surface,
    /// Size of the smallest cell, mm.
    finest: Vec3,
}

impl Rule for Octants<'_> {
    type Item = u32;
    const FANOUT: usize = 8;
    const LEVELS: u32 = MAX_HALVINGS;

    fn triangle(item: &u32) -> u32 {
        *item
    }

    fn cells(cell: &Aabb, level: u32) -> [Aabb; 8] {
        octants(cell, level)
    }

    fn deal(&self, cell: &Aabb, _level: u32, items: &[u32], out: &mut [Vec<u32>; 8]) {
        for &t in items {
            out[child_of(self.surface, cell, t)].push(t);
        }
    }

    /// Two vertices in one octant: the median of the three is there too. Otherwise the centroid decides.
    fn alike(&self, cell: &Aabb, items: &[u32]) -> bool {
        let inside = |p: Vec3| p.clamp(cell.min, cell.max);
        let corners = items.iter().map(|&t| self.surface.triangle(t));
        let medians = corners
            .clone()
            .map(|t| inside(tree::median([t.a, t.b, t.c])));
        tree::all_within(medians, self.finest)
            && tree::all_within(corners.map(|t| inside(t.centroid())), self.finest)
    }

    fn bounds(&self, _cell: &Aabb, items: &[u32]) -> Aabb {
        items.iter().fold(Aabb::EMPTY, |b, &t| {
            b.union(self.surface.triangle(t).aabb())
        })
    }
}

impl Partition for Octree {
    fn name(&self) -> &'static str {
        "octree"
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
        validate(&self.tree, surface)
    }
}
