//! Growing a tree, level by level, so that a limit on its size meets all branches alike.

use super::{Node, Options, Tree};
use crate::geom::Aabb;
use crate::surface::Surface;

/// Entries a tree may list per triangle before no more triangles are listed twice or cut.
const MOST_COPIES: usize = 12;
/// Nodes a tree may have per triangle.
const MOST_NODES: usize = 12;
/// Splits in a row that leave a child with all its parent's triangles and its sibling not empty: one for each axis.
const FRUITLESS: u8 = 3;

/// Which child gets what.
pub(in crate::partition) trait Rule {
    /// A triangle, or a piece of one.
    type Item: Copy;
    /// Children of a node: 2 or 8.
    const FANOUT: usize;
    /// Most levels under the root.
    const LEVELS: u32;

    /// The triangle of an item.
    fn triangle(item: &Self::Item) -> u32;

    /// The cells of the children.
    fn cells(cell: &Aabb, level: u32) -> [Aabb; 8];

    /// Deals the items of a node out to its children.
    fn deal(&self, cell: &Aabb, level: u32, items: &[Self::Item], out: &mut [Vec<Self::Item>; 8]);

    /// Whether no plane within the cell can tell the items apart.
    fn alike(&self, cell: &Aabb, items: &[Self::Item]) -> bool;

    /// Loose bounds of a leaf, mm.
    fn bounds(&self, cell: &Aabb, items: &[Self::Item]) -> Aabb;
}

/// Nodes and what each leaf holds; the lists of inner nodes are empty.
pub(in crate::partition) struct Grown<I> {
    nodes: Vec<Node>,
    pub(in crate::partition) lists: Vec<Vec<I>>,
    unsplittable: usize,
}

/// Grows a tree over `items`. `progress` hears the share done, 0…1, and stops the work by answering `false`.
pub(in crate::partition) fn grow<R: Rule>(
    rule: &R,
    surface: &Surface,
    items: Vec<R::Item>,
    threshold: usize,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Option<Grown<R::Item>> {
    let threshold = threshold.max(1);
    let room = |per: usize| (items.len().saturating_mul(per) + 4096).min(u32::MAX as usize / 2);
    let (most_entries, most_nodes) = (room(MOST_COPIES), room(MOST_NODES));
    let mut nodes = vec![leaf(surface.bounds(), 0)];
    let (mut entries, mut settled, mut unsplittable) = (items.len(), 0, 0);
    let mut lists = vec![items];
    let mut fruitless = vec![0_u8];
    let mut dealt: [Vec<R::Item>; 8] = Default::default();
    let mut at = 0;
    while at < nodes.len() {
        let (cell, level) = (nodes[at].cell, nodes[at].level);
        let count = lists[at].len();
        let big = count > 4096 || at % 1024 == 0;
        if big && !progress(settled as f64 / entries.max(1) as f64) {
            return None;
        }
        let can_split = level < R::LEVELS
            && fruitless[at] < FRUITLESS
            && entries <= most_entries
            && nodes.len() + R::FANOUT <= most_nodes;
        if count <= threshold || !can_split || rule.alike(&cell, &lists[at]) {
            nodes[at].bounds = rule.bounds(&cell, &lists[at]);
            nodes[at].held = count as u32;
            lists[at].shrink_to_fit();
            unsplittable += usize::from(count > threshold);
            settled += count;
            at += 1;
            continue;
        }
        rule.deal(&cell, level, &lists[at], &mut dealt);
        lists[at] = Vec::new();
        nodes[at].first_child = nodes.len() as u32;
        let split = dealt.iter().filter(|d| !d.is_empty()).count() > 1;
        let cells = R::cells(&cell, level);
        for (child, cell) in dealt.iter_mut().zip(cells).take(R::FANOUT) {
            let stuck = if !split {
                fruitless[at]
            } else if child.len() >= count {
                fruitless[at] + 1
            } else {
                0
            };
            entries += child.len();
            nodes.push(leaf(cell, level + 1));
            lists.push(std::mem::take(child));
            fruitless.push(stuck);
        }
        entries -= count;
        at += 1;
    }
    for at in (0..nodes.len()).rev() {
        let node = nodes[at];
        if node.is_leaf() {
            continue;
        }
        let under = &nodes[node.first_child as usize..][..R::FANOUT];
        let bounds = under.iter().fold(Aabb::EMPTY, |b, n| b.union(n.bounds));
        let held = under.iter().map(|n| n.held).sum();
        nodes[at] = Node {
            bounds,
            held,
            ..node
        };
    }
    Some(Grown {
        nodes,
        lists,
        unsplittable,
    })
}

fn leaf(cell: Aabb, level: u32) -> Node {
    Node {
        cell,
        bounds: Aabb::EMPTY,
        level,
        held: 0,
        first_child: 0,
        first: 0,
    }
}

/// Where the triangles of the leaves are.
#[derive(Clone, Debug)]
pub(in crate::partition) enum Store {
    /// Each leaf has a list of its own, as published.
    Apart(Box<[Box<[u32]>]>),
    /// One list, in which the triangles under any node lie side by side.
    One(Box<[u32]>),
}

impl Store {
    /// What a leaf lists.
    pub(super) fn listed(&self, leaf: &Node) -> &[u32] {
        let (first, held) = (leaf.first as usize, leaf.held as usize);
        match self {
            Self::Apart(lists) => lists.get(first).map_or(&[], |list| list),
            Self::One(list) => list.get(first..first + held).unwrap_or(&[]),
        }
    }

    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Apart(lists) => {
                let held: usize = lists.iter().map(|l| size_of_val(&l[..])).sum();
                size_of_val(&lists[..]) + held
            }
            Self::One(list) => size_of_val(&list[..]),
        }
    }
}

impl Tree {
    /// Keeps a grown tree, with one list or a list for each leaf.
    pub(in crate::partition) fn keep<R: Rule>(
        grown: &Grown<R::Item>,
        surface: &Surface,
        options: &Options,
        one_list: bool,
    ) -> Self {
        let mut nodes = grown.nodes.clone();
        let ids = |at: usize| grown.lists[at].iter().map(R::triangle);
        let store = if one_list {
            for at in 0..nodes.len() {
                let node = nodes[at];
                let mut first = node.first;
                let many = if node.is_leaf() { 0 } else { R::FANOUT };
                for child in &mut nodes[node.first_child as usize..][..many] {
                    child.first = first;
                    first += child.held;
                }
            }
            let mut list = vec![0; nodes.first().map_or(0, |n| n.held as usize)];
            for (at, node) in nodes.iter().enumerate().filter(|(_, n)| n.is_leaf()) {
                for (slot, id) in list[node.first as usize..].iter_mut().zip(ids(at)) {
                    *slot = id;
                }
            }
            Store::One(list.into())
        } else {
            let mut lists = Vec::new();
            for (at, node) in nodes.iter_mut().enumerate().filter(|(_, n)| n.is_leaf()) {
                node.first = lists.len() as u32;
                lists.push(ids(at).collect());
            }
            Store::Apart(lists.into())
        };
        let bounds = surface.bounds();
        Self {
            nodes: nodes.into(),
            store,
            fanout: R::FANOUT as u32,
            threshold: options.threshold.max(1),
            unsplittable: grown.unsplittable,
            reach_mm: bounds.min.abs().max(bounds.max.abs()).max_element(),
        }
    }
}
