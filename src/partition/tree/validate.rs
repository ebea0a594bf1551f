//! The checker that every test calls after every build: what must hold of any tree of cells.

use super::{Node, STACK, Store, Tree};
use crate::geom::Aabb;
use crate::surface::Surface;

/// How often a triangle may be listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::partition) enum Ownership {
    /// In exactly one leaf, once.
    One,
    /// In one or more.
    Several,
}

impl Tree {
    /// Children have the cells that `cells` cuts, parents bound what is under them, leaves bound what they list (within
    /// their cell, if `clipped`), every node has one parent, and no triangle is lost.
    pub(in crate::partition) fn check(
        &self,
        surface: &Surface,
        cells: impl Fn(&Aabb, u32) -> [Aabb; 8],
        ownership: Ownership,
        clipped: bool,
    ) -> Result<(), String> {
        let mut seen = vec![false; surface.triangles().len()];
        let root = self.nodes.first().ok_or("there is no root")?;
        if root.cell != surface.bounds() || root.level != 0 {
            return Err("the root is not the surface's box".into());
        }
        let mut parents = vec![0_u32; self.nodes.len()];
        let mut above = 0;
        for (at, node) in self.nodes.iter().enumerate() {
            if node.is_leaf() {
                above += usize::from(node.held as usize > self.threshold);
                self.check_leaf(surface, at, node, clipped)?;
                for &t in self.held(node) {
                    let twice = std::mem::replace(&mut seen[t as usize], true);
                    if twice && ownership == Ownership::One {
                        return Err(format!("triangle {t} is held twice"));
                    }
                }
                continue;
            }
            let range = self.children(node);
            let under = self
                .nodes
                .get(range.start as usize..range.end as usize)
                .filter(|_| range.start as usize > at)
                .ok_or_else(|| format!("node {at} names node {}", range.start))?;
            let held: u64 = under.iter().map(|n| u64::from(n.held)).sum();
            if held != u64::from(node.held) {
                return Err(format!(
                    "node {at} holds {}, its children {held}",
                    node.held
                ));
            }
            for ((number, child), cell) in range.zip(under).zip(cells(&node.cell, node.level)) {
                parents[number as usize] += 1;
                if child.level != node.level + 1 || child.cell != cell {
                    return Err(format!("node {number} is not the cell its parent cuts"));
                }
                if !holds(&node.bounds, &child.bounds) {
                    return Err(format!("node {at} does not bound its child {number}"));
                }
            }
        }
        if let Some(at) = (1..parents.len()).find(|&at| parents[at] != 1) {
            return Err(format!("node {at} has {} parents", parents[at]));
        }
        if above != self.unsplittable {
            return Err(format!(
                "{above} leaves above the threshold, {} reported",
                self.unsplittable
            ));
        }
        if self.height() as usize * (self.fanout as usize - 1) + self.fanout as usize > STACK {
            return Err(format!("{} levels are too many", self.height()));
        }
        match seen.iter().position(|&seen| !seen) {
            Some(lost) => Err(format!("triangle {lost} is in no leaf")),
            None => Ok(()),
        }
    }

    /// All that lies under a node is its part of one list.
    pub(in crate::partition) fn check_one_list(&self) -> Result<(), String> {
        let Store::One(list) = &self.store else {
            return Err("there is more than one list".into());
        };
        let root = self.nodes.first().ok_or("there is no root")?;
        if root.first != 0 || root.held as usize != list.len() {
            return Err("the root is not the whole list".into());
        }
        for (at, node) in self.nodes.iter().enumerate() {
            let mut first = node.first;
            for number in self.children(node) {
                let child = (self.nodes.get(number as usize))
                    .ok_or_else(|| format!("node {at} names node {number}"))?;
                if child.first != first {
                    return Err(format!(
                        "node {number} does not follow its sibling in the list"
                    ));
                }
                first = first.saturating_add(child.held);
            }
        }
        Ok(())
    }

    fn check_leaf(
        &self,
        surface: &Surface,
        at: usize,
        node: &Node,
        clipped: bool,
    ) -> Result<(), String> {
        let held = self.held(node);
        if held.len() != node.held as usize {
            return Err(format!("leaf {at} lists {} of {}", held.len(), node.held));
        }
        for &t in held {
            if t as usize >= surface.triangles().len() {
                return Err(format!("triangle {t} does not exist"));
            }
            let mut bounds = surface.triangle(t).aabb();
            if clipped {
                bounds = within(&bounds, &node.cell);
            }
            if !holds(&node.bounds, &bounds) {
                return Err(format!("leaf {at} does not bound triangle {t}"));
            }
        }
        Ok(())
    }
}

/// The part of a box within a cell.
pub(in crate::partition) fn within(bounds: &Aabb, cell: &Aabb) -> Aabb {
    Aabb {
        min: bounds.min.max(cell.min),
        max: bounds.max.min(cell.max),
    }
}

fn holds(outer: &Aabb, inner: &Aabb) -> bool {
    inner.is_empty() || (outer.contains(inner.min) && outer.contains(inner.max))
}
