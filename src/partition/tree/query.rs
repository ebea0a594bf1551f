//! Queries. Each walks the nodes with a stack of fixed size, nearest child first, and asks the exact triangles.

use super::{Node, STACK, Store, Tree};
use crate::geom::{Aabb, Vec3};
use crate::partition::hdb::Gathered;
use crate::partition::{Hit, Nearest, Sides};
use crate::surface::Surface;

/// Nodes still to be visited, each with a lower bound of what it can offer; smallest bound on top of its siblings.
struct Pending {
    entries: [(f64, u32); STACK],
    len: usize,
}

impl Pending {
    fn new() -> Self {
        Self {
            entries: [(0.0, 0); STACK],
            len: 0,
        }
    }

    fn pop(&mut self) -> Option<(f64, u32)> {
        self.len = self.len.checked_sub(1)?;
        Some(self.entries[self.len])
    }

    /// Inserts above `base`, where the siblings begin, keeping the smallest on top.
    fn push(&mut self, base: usize, entry: (f64, u32)) {
        if self.len == STACK {
            return;
        }
        let mut at = self.len;
        while at > base && self.entries[at - 1].0 < entry.0 {
            self.entries[at] = self.entries[at - 1];
            at -= 1;
        }
        self.entries[at] = entry;
        self.len += 1;
    }
}

impl Tree {
    /// How far boxes must be grown for a query near `p`, mm, so that no rounding of the exact tests can find what the
    /// boxes excluded.
    fn pad_mm(&self, p: Vec3) -> f64 {
        8.0 * f64::EPSILON * (self.reach_mm + p.abs().max_element())
    }

    /// Visits leaves by rising `lower`, as long as that is at most the limit, which `leaf` returns anew.
    fn walk(
        &self,
        mut limit: f64,
        lower: impl Fn(&Node, f64) -> f64,
        mut leaf: impl FnMut(&[u32]) -> f64,
    ) {
        let mut pending = Pending::new();
        let mut next = (!self.nodes.is_empty()).then_some((0.0, 0));
        while let Some((bound, at)) = next {
            let node = &self.nodes[at as usize];
            if bound <= limit && node.held > 0 {
                if node.is_leaf() {
                    limit = leaf(self.store.listed(node));
                } else {
                    let base = pending.len;
                    for child in self.children(node) {
                        let under = &self.nodes[child as usize];
                        let bound = lower(under, limit);
                        if under.held > 0 && bound <= limit {
                            pending.push(base, (bound, child));
                        }
                    }
                }
            }
            next = pending.pop();
        }
    }

    pub(in crate::partition) fn nearest(
        &self,
        surface: &Surface,
        p: Vec3,
        max_mm: f64,
    ) -> Option<Nearest> {
        if !p.is_finite() || max_mm < 0.0 || max_mm.is_nan() {
            return None;
        }
        let pad = self.pad_mm(p);
        // A hair more than the bound, since squaring rounds too.
        let more = 1.0 + 1e-14;
        let mut best: Option<Nearest> = None;
        let mut bound = max_mm * max_mm;
        self.walk(
            bound * more,
            |node, _| node.bounds.grown(pad).distance_sq(p),
            |held| {
                for &triangle in held {
                    let point = surface.triangle(triangle).closest_point(p).point;
                    let distance_sq = point.distance_squared(p);
                    let better = match best {
                        None => distance_sq <= bound,
                        Some(b) => {
                            distance_sq < bound || (distance_sq == bound && triangle < b.triangle)
                        }
                    };
                    if better {
                        bound = distance_sq;
                        best = Some(Nearest {
                            triangle,
                            point,
                            distance_sq,
                        });
                    }
                }
                bound * more
            },
        );
        best
    }

    pub(in crate::partition) fn sweep(
        &self,
        surface: &Surface,
        from: Vec3,
        to: Vec3,
        sides: Sides,
    ) -> Option<Hit> {
        let along = to - from;
        if !from.is_finite() || !along.is_finite() {
            return None;
        }
        let pad = self.pad_mm(from).max(self.pad_mm(to));
        let mut best: Option<Hit> = None;
        self.walk(
            1.0,
            |node, end| enter(&node.bounds.grown(pad), from, along, end),
            |held| {
                for &triangle in held {
                    let Some(c) = surface.triangle(triangle).crossing(from, to) else {
                        continue;
                    };
                    if !c.inward && sides == Sides::Front {
                        continue;
                    }
                    let better =
                        best.is_none_or(|b| c.t < b.t || (c.t == b.t && triangle < b.triangle));
                    if better {
                        best = Some(Hit {
                            triangle,
                            t: c.t,
                            point: from + along * c.t,
                            inward: c.inward,
                        });
                    }
                }
                best.map_or(1.0, |b| b.t)
            },
        );
        best
    }

    /// Appends every triangle whose box overlaps `region`, in rising order and once, and tells the cost.
    pub fn gather(&self, surface: &Surface, region: &Aabb, out: &mut Vec<u32>) -> Gathered {
        in_rising_order(out, |out| self.each_in(surface, region, |t| out.push(t)))
    }

    /// Names every triangle whose box overlaps `region`, in no order, as often as it is listed. Allocates nothing.
    pub fn each_in(&self, surface: &Surface, region: &Aabb, mut name: impl FnMut(u32)) -> Gathered {
        let mut named = 0;
        let cost = self.visit(
            |_, node| node.bounds.overlaps(region),
            |node| {
                let all: &[u32] = match &self.store {
                    // All under the node lies side by side: no need to go on down.
                    Store::One(all)
                        if region.contains(node.bounds.min) && region.contains(node.bounds.max) =>
                    {
                        let first = node.first as usize;
                        &all[first..first + node.held as usize]
                    }
                    _ if !node.is_leaf() => return false,
                    _ => {
                        for &t in self.store.listed(node) {
                            if surface.triangle(t).aabb().overlaps(region) {
                                name(t);
                                named += 1;
                            }
                        }
                        return true;
                    }
                };
                all.iter().for_each(|&t| name(t));
                named += all.len();
                true
            },
        );
        Gathered {
            triangles: named,
            ..cost
        }
    }

    /// The published query of octrees: appends all triangles of every leaf whose cell overlaps `region`. Triangles that
    /// jut out of their cell are missed where only the jutting part lies in `region`.
    pub fn gather_by_cells(&self, region: &Aabb, out: &mut Vec<u32>) -> Gathered {
        in_rising_order(out, |out| self.each_by_cells(region, |t| out.push(t)))
    }

    /// As [`Tree::gather_by_cells`], naming the triangles in no order, as often as they are listed. Allocates nothing.
    pub fn each_by_cells(&self, region: &Aabb, name: impl FnMut(u32)) -> Gathered {
        self.each_in_leaves(|_, node| node.cell.overlaps(region), name)
    }

    /// Names what the leaves list to which `enters` leads.
    pub(in crate::partition) fn each_in_leaves(
        &self,
        enters: impl Fn(Option<(&Node, usize)>, &Node) -> bool,
        mut name: impl FnMut(u32),
    ) -> Gathered {
        let mut named = 0;
        let cost = self.visit(enters, |node| {
            let list = self.held(node);
            list.iter().for_each(|&t| name(t));
            named += list.len();
            node.is_leaf()
        });
        Gathered {
            triangles: named,
            ..cost
        }
    }

    /// Enters every child that `enters` lets in, given its parent; `take` says whether it took all there is under a node.
    pub(in crate::partition) fn visit(
        &self,
        enters: impl Fn(Option<(&Node, usize)>, &Node) -> bool,
        mut take: impl FnMut(&Node) -> bool,
    ) -> Gathered {
        let mut cost = Gathered::default();
        let mut pending = Pending::new();
        let root = self.nodes.first().filter(|n| n.held > 0 && enters(None, n));
        let mut next = root.map(|_| (0.0, 0));
        while let Some((_, at)) = next {
            let node = &self.nodes[at as usize];
            cost.nodes += 1;
            cost.leaves += usize::from(node.is_leaf());
            if !take(node) {
                for (i, child) in self.children(node).enumerate() {
                    let under = &self.nodes[child as usize];
                    if under.held > 0 && enters(Some((node, i)), under) {
                        let base = pending.len;
                        pending.push(base, (0.0, child));
                    }
                }
            }
            next = pending.pop();
        }
        cost
    }
}

/// Appends what `gather` appends, each triangle once and in rising order: several leaves may list it.
pub fn in_rising_order(
    out: &mut Vec<u32>,
    gather: impl FnOnce(&mut Vec<u32>) -> Gathered,
) -> Gathered {
    let before = out.len();
    let cost = gather(out);
    out[before..].sort_unstable();
    let mut kept = before;
    for i in before..out.len() {
        if kept == before || out[i] != out[kept - 1] {
            out[kept] = out[i];
            kept += 1;
        }
    }
    out.truncate(kept);
    Gathered {
        triangles: kept - before,
        ..cost
    }
}

/// Fraction at which a motion enters a box (slabs: Kay & Kajiya 1986); infinite if it misses it before `end`.
fn enter(b: &Aabb, from: Vec3, along: Vec3, end: f64) -> f64 {
    let (mut near, mut far) = (0.0_f64, end);
    for k in 0..3 {
        let d = along[k];
        // A motion across the axis only: the sign of box − start decides, and 0 · 1e300 is still 0.
        let inverse = if d.abs() >= 1e-300 {
            1.0 / d
        } else {
            1e300_f64.copysign(d)
        };
        let (first, last) = if inverse < 0.0 {
            (b.max[k], b.min[k])
        } else {
            (b.min[k], b.max[k])
        };
        near = near.max((first - from[k]) * inverse);
        far = far.min((last - from[k]) * inverse);
    }
    if near <= far { near } else { f64::INFINITY }
}
