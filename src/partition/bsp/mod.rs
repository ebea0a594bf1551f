//! The published binary space partition (Ji 2008, 3.3): planes at right angles to x, y, z in turn, each through the
//! middle of its node's cell.

mod cut;
mod validate;

#[cfg(test)]
mod tests;

use super::hdb::Gathered;
use super::tree::{self, Case, Grown, MAX_HALVINGS, Options, Rule, Statistics, Tree};
use super::{Hit, Nearest, Partition, Sides};
use crate::geom::{Aabb, Vec3};
use crate::surface::Surface;
use cut::Piece;

/// Axis of the plane that splits nodes of this level: x, y, z in turn.
pub fn axis(level: u32) -> usize {
    level as usize % 3
}

/// A binary space partition over the triangles of one surface.
#[derive(Clone, Debug)]
pub struct Bsp {
    tree: Tree,
    case: Case,
    /// In case A the pieces of every leaf, leaf by leaf; empty in the others.
    pieces: Box<[Piece]>,
}

impl Bsp {
    /// Builds the partition.
    pub fn new(surface: &Surface, options: &Options) -> Self {
        Self::with_progress(surface, options, &mut |_| true).expect("nobody stops it")
    }

    /// Builds the partition. `progress` hears the share done, 0…1; when it answers `false` there is no partition.
    pub fn with_progress(
        surface: &Surface,
        options: &Options,
        progress: &mut dyn FnMut(f64) -> bool,
    ) -> Option<Self> {
        let n = surface.triangles().len() as u32;
        let finest = surface.bounds().size() * libm::exp2(-f64::from(MAX_HALVINGS));
        if options.case == Case::A {
            let whole = |triangle| {
                let t = surface.triangle(triangle);
                Piece {
                    triangle,
                    corners: [t.a, t.b, t.c],
                }
            };
            let rule = Cut { surface };
            let all = (0..n).map(whole).collect();
            let grown = tree::grow(&rule, surface, all, options.threshold, progress)?;
            Some(Self {
                tree: Tree::keep::<Cut<'_>>(&grown, surface, options, false),
                case: options.case,
                pieces: pieces(&grown),
            })
        } else {
            let rule = Whole {
                surface,
                both: options.case == Case::B,
                finest,
            };
            let all = (0..n).collect();
            let grown = tree::grow(&rule, surface, all, options.threshold, progress)?;
            Some(Self {
                tree: Tree::keep::<Whole<'_>>(&grown, surface, options, false),
                case: options.case,
                pieces: Box::default(),
            })
        }
    }

    /// The nodes.
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// What became of triangles on the planes.
    pub fn case(&self) -> Case {
        self.case
    }

    /// Corners of every piece, mm, with the triangle it was cut from; none except in case A.
    pub fn pieces(&self) -> impl Iterator<Item = (u32, [Vec3; 3])> + '_ {
        self.pieces.iter().map(|p| (p.triangle, p.corners))
    }

    /// Counts over the tree.
    pub fn statistics(&self, surface: &Surface) -> Statistics {
        Statistics {
            bytes: self.bytes(),
            ..self.tree.statistics(surface, self.case)
        }
    }

    /// The published query (Ji 2008, 3.3.3): appends all triangles of every leaf that the planes do not part from
    /// `region`. The outer leaves are half infinite, so they answer from far away; triangles that jut out of their leaf's
    /// space in case C are missed where only the jutting part lies in `region`.
    pub fn gather_by_half_spaces(&self, region: &Aabb, out: &mut Vec<u32>) -> Gathered {
        tree::in_rising_order(out, |out| self.each_by_half_spaces(region, |t| out.push(t)))
    }

    /// As [`Bsp::gather_by_half_spaces`], naming the triangles in no order, as often as they are listed. Allocates nothing.
    pub fn each_by_half_spaces(&self, region: &Aabb, name: impl FnMut(u32)) -> Gathered {
        let enters = |from: Option<(&tree::Node, usize)>, _: &tree::Node| {
            from.is_none_or(|(parent, side)| {
                // Hessian form S = V · N + d with N along the axis: of the eight vertices only the nearest and the
                // farthest along it count.
                let axis = axis(parent.level);
                let d = -parent.cell.centre()[axis];
                if side == 0 {
                    region.min[axis] + d < 0.0
                } else {
                    region.max[axis] + d >= 0.0
                }
            })
        };
        self.tree.each_in_leaves(enters, name)
    }
}

fn pieces(grown: &Grown<Piece>) -> Box<[Piece]> {
    grown.lists.iter().flatten().copied().collect()
}

/// The two halves of a cell.
fn halves(cell: &Aabb, level: u32) -> [Aabb; 8] {
    let axis = axis(level);
    let middle = cell.centre()[axis];
    let (mut low, mut high) = (*cell, *cell);
    low.max[axis] = middle;
    high.min[axis] = middle;
    let mut cells = [Aabb::EMPTY; 8];
    [cells[0], cells[1]] = [low, high];
    cells
}

fn union(surface: &Surface, triangles: impl Iterator<Item = u32>) -> Aabb {
    triangles.fold(Aabb::EMPTY, |b, t| b.union(surface.triangle(t).aabb()))
}

/// Case A.
struct Cut<'a> {
    surface: &'a Surface,
}

impl Rule for Cut<'_> {
    type Item = Piece;
    const FANOUT: usize = 2;
    const LEVELS: u32 = 3 * MAX_HALVINGS;

    fn triangle(item: &Piece) -> u32 {
        item.triangle
    }

    fn cells(cell: &Aabb, level: u32) -> [Aabb; 8] {
        halves(cell, level)
    }

    fn deal(&self, cell: &Aabb, level: u32, items: &[Piece], out: &mut [Vec<Piece>; 8]) {
        let axis = axis(level);
        let middle = cell.centre()[axis];
        for piece in items {
            piece.cut(axis, middle, out);
        }
    }

    fn alike(&self, _cell: &Aabb, _items: &[Piece]) -> bool {
        false
    }

    fn bounds(&self, _cell: &Aabb, items: &[Piece]) -> Aabb {
        union(self.surface, items.iter().map(|p| p.triangle))
    }
}

/// Cases B and C.
struct Whole<'a> {
    surface: &'a Surface,
    both: bool,
    /// Size of the smallest cell, mm.
    finest: Vec3,
}

impl Whole<'_> {
    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        let t = self.surface.triangle(triangle);
        [t.a, t.b, t.c]
    }
}

impl Rule for Whole<'_> {
    type Item = u32;
    const FANOUT: usize = 2;
    const LEVELS: u32 = 3 * MAX_HALVINGS;

    fn triangle(item: &u32) -> u32 {
        *item
    }

    fn cells(cell: &Aabb, level: u32) -> [Aabb; 8] {
        halves(cell, level)
    }

    fn deal(&self, cell: &Aabb, level: u32, items: &[u32], out: &mut [Vec<u32>; 8]) {
        let axis = axis(level);
        let middle = cell.centre()[axis];
        for &triangle in items {
            let above = self.corners(triangle).map(|p| p[axis] >= middle);
            let n_above = above.iter().filter(|&&a| a).count();
            let fewest = if self.both { 1 } else { 2 };
            if 3 - n_above >= fewest {
                out[0].push(triangle);
            }
            if n_above >= fewest {
                out[1].push(triangle);
            }
        }
    }

    /// In case C only the median of the vertices decides.
    fn alike(&self, _cell: &Aabb, items: &[u32]) -> bool {
        !self.both && {
            let medians = items.iter().map(|&t| tree::median(self.corners(t)));
            tree::all_within(medians, self.finest)
        }
    }

    fn bounds(&self, cell: &Aabb, items: &[u32]) -> Aabb {
        if self.both {
            // Whatever lies outside the cell is held by another leaf.
            tree::within(&union(self.surface, items.iter().copied()), cell)
        } else {
            union(self.surface, items.iter().copied())
        }
    }
}

impl Partition for Bsp {
    fn name(&self) -> &'static str {
        "bsp"
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
        self.tree.bytes() + size_of_val(&self.pieces[..])
    }

    fn validate(&self, surface: &Surface) -> Result<(), String> {
        validate::validate(self, surface)
    }
}
