//! What [`bsp`](super::bsp), [`octree`](super::octree) and [`hybrid`](super::hybrid) share: nodes that halve their cell,
//! how they grow, how they are walked, checked and counted. Each adds its rule of which child a triangle goes to.
//!
//! A node has two boxes. Its cell is the published one: what the splits leave of the surface's box. Its bounds are loose:
//! they hold every triangle under it wholly, also where it juts out of the cell, so that no query loses any.

mod build;
mod query;
mod statistics;
mod validate;

use crate::geom::{Aabb, Vec3};

use build::Store;
pub(super) use build::{Grown, Rule, grow};
pub use query::in_rising_order;
pub use statistics::{Occupancy, Statistics};
pub(super) use validate::{Ownership, within};

/// Halvings an axis can see. A cell then is a millionth of the surface: triangles it still cannot tell apart stay together.
pub const MAX_HALVINGS: u32 = 20;
/// Entries a query's stack can ever need: each of an octree's levels leaves at most seven siblings waiting, plus the
/// eight of the last; each of a BSP's, thrice as many, one.
const STACK: usize = 7 * MAX_HALVINGS as usize + 8;

/// What becomes of a triangle that a splitting plane cuts (Ji 2008, figure 3.7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Case {
    /// It is cut in pieces, which keep its number.
    A,
    /// Both children hold it.
    B,
    /// The child with at least two of its vertices holds it.
    #[default]
    C,
}

/// How a tree is grown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Most triangles in a leaf; 0 counts as 1.
    pub threshold: usize,
    /// What becomes of a triangle on the plane. Octrees know case C only.
    pub case: Case,
}

impl Default for Options {
    /// The published choice.
    fn default() -> Self {
        Self {
            threshold: 1024,
            case: Case::C,
        }
    }
}

/// One node of a tree.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// What the splits above leave of the surface's box, mm.
    pub cell: Aabb,
    /// The smallest box around every triangle under the node, mm; empty where there is none.
    pub bounds: Aabb,
    /// 0 for the root.
    pub level: u32,
    /// Entries in the leaves under it. A triangle counts as often as it is listed.
    pub held: u32,
    /// Number of the first child; 0 for a leaf.
    first_child: u32,
    /// Where its entries begin in one list, or which of the lists is the leaf's.
    first: u32,
}

impl Node {
    /// Whether it has no children.
    pub fn is_leaf(&self) -> bool {
        self.first_child == 0
    }
}

/// Nodes, root first and children after their parent and side by side, and the triangles of the leaves.
#[derive(Clone, Debug)]
pub struct Tree {
    nodes: Box<[Node]>,
    store: Store,
    /// Children of an inner node.
    fanout: u32,
    threshold: usize,
    /// Leaves above the threshold.
    unsplittable: usize,
    /// Largest coordinate of the surface, mm: sets the rounding of the exact tests.
    reach_mm: f64,
}

impl Tree {
    /// Every node; the root is the first.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Numbers of the children of a node, none for a leaf.
    pub fn children(&self, node: &Node) -> std::ops::Range<u32> {
        let many = if node.is_leaf() { 0 } else { self.fanout };
        node.first_child..node.first_child + many
    }

    /// Children of an inner node: 2 or 8.
    pub fn fanout(&self) -> u32 {
        self.fanout
    }

    /// The planes that split an inner node, as axis and place, mm; none for a leaf. Bit `i` of a child's place among its
    /// siblings says whether it lies above the `i`-th.
    pub fn splits(&self, node: &Node) -> impl Iterator<Item = (usize, f64)> + use<> {
        let centre = node.cell.centre();
        let axes = match (node.is_leaf(), self.fanout) {
            (true, _) => 0..0,
            (false, 2) => {
                let axis = super::bsp::axis(node.level);
                axis..axis + 1
            }
            (false, _) => 0..3,
        };
        axes.map(move |axis| (axis, centre[axis]))
    }

    /// Numbers of the nodes whose cells hold `p`, from the root to a leaf; a point on a plane belongs above it. Empty where
    /// `p` lies outside of the surface's box or is not finite.
    pub fn path_to(&self, p: Vec3) -> Vec<u32> {
        let mut path = Vec::new();
        let mut next = (self.nodes.first())
            .filter(|root| root.cell.contains(p))
            .map(|_| 0);
        while let Some(at) = next {
            path.push(at);
            let node = &self.nodes[at as usize];
            let mut child = node.first_child;
            for (i, (axis, at_mm)) in self.splits(node).enumerate() {
                child += u32::from(p[axis] >= at_mm) << i;
            }
            next = (!node.is_leaf()).then_some(child);
        }
        path
    }

    /// Triangles a leaf lists; none for an inner node.
    pub fn held(&self, node: &Node) -> &[u32] {
        if node.is_leaf() {
            self.store.listed(node)
        } else {
            &[]
        }
    }

    /// Number of levels under the root.
    pub fn height(&self) -> u32 {
        self.nodes.last().map_or(0, |n| n.level)
    }

    /// Largest coordinate of the surface, mm.
    pub(super) fn reach_mm(&self) -> f64 {
        self.reach_mm
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + self.store.bytes()
    }
}

/// Worst cost of finding one leaf in a complete tree, over finding it in a list: w = (nodes visited / all nodes) /
/// (1 / leaves) (Ji 2008, tables 3.3 and 3.4). `fanout` is 2 or 8.
pub fn worst_w(fanout: u32, height: u32) -> f64 {
    let power = |h: u32| libm::pow(f64::from(fanout), f64::from(h));
    let all = (0..=height).map(power).sum::<f64>();
    f64::from(height + 1) / all * power(height)
}

/// The middle one of the three coordinates on each axis: a plane has at least two vertices on the side where this is.
pub(super) fn median(corners: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = corners;
    a.min(b).max(a.max(b).min(c))
}

/// Whether a box of `size`, mm, could hold all points.
pub(super) fn all_within(points: impl Iterator<Item = Vec3>, size: Vec3) -> bool {
    let mut box_of = Aabb::EMPTY;
    for p in points {
        box_of = box_of.union(Aabb { min: p, max: p });
        if (box_of.max - box_of.min).cmpgt(size).any() {
            return false;
        }
    }
    true
}

#[cfg(test)]
impl Tree {
    /// Breaks the tree in one of four ways, for tests of the checkers.
    pub(super) fn damage(&mut self, fault: usize) {
        let last = (self.nodes.iter())
            .rposition(|n| n.is_leaf() && n.held > 0)
            .unwrap();
        match fault {
            0 => self.nodes[0].bounds.max.x -= 1.0,
            1 => self.nodes[last].bounds.min.y += 1.0,
            2 => self.nodes[last].held -= 1,
            _ => self.nodes[last].cell.max.z += 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::partition::structure::{Structure, TREES};
    use crate::surface::Surface;
    use crate::surface::primitives::bench_patch;

    /// Every split plane lies where the boxes of the two children meet, and the path to a point goes from cell to cell
    /// that hold it, down to a leaf.
    #[test]
    fn planes_part_the_children_and_paths_lead_to_the_leaf_of_a_point() {
        let surface = Surface::new(bench_patch(2000)).unwrap().0;
        let options = Options {
            threshold: 40,
            case: Case::C,
        };
        for kind in TREES {
            let built = Structure::build(kind, &surface, &options, &mut |_| true);
            let built = built.unwrap().unwrap();
            let tree = built.tree().unwrap();
            for node in tree.nodes() {
                let under: Vec<_> = tree.children(node).collect();
                assert_eq!(
                    tree.splits(node).count(),
                    match under.len() {
                        0 => 0,
                        2 => 1,
                        _ => 3,
                    }
                );
                for (i, (axis, at_mm)) in tree.splits(node).enumerate() {
                    for (number, &child) in under.iter().enumerate() {
                        let cell = tree.nodes()[child as usize].cell;
                        let upper = number >> i & 1 == 1;
                        let face = if upper { cell.min } else { cell.max };
                        assert_eq!(face[axis], at_mm, "{kind}");
                    }
                }
            }
            for triangle in (0..surface.triangles().len() as u32).step_by(37) {
                let p = surface.triangle(triangle).centroid();
                let path = tree.path_to(p);
                assert_eq!(path[0], 0);
                for pair in path.windows(2) {
                    assert!(
                        tree.children(&tree.nodes()[pair[0] as usize])
                            .contains(&pair[1])
                    );
                }
                assert!(
                    path.iter()
                        .all(|&n| tree.nodes()[n as usize].cell.contains(p))
                );
                assert!(tree.nodes()[*path.last().unwrap() as usize].is_leaf());
            }
            assert!(tree.path_to(Vec3::splat(1e6)).is_empty());
            assert!(tree.path_to(Vec3::NAN).is_empty());
        }
    }
}
