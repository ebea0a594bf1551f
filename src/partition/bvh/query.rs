//! Queries. Each walks the nodes with a stack of fixed size, nearest child first, and asks the exact triangles.

use super::{Bvh, Child, NO_CHILD, Node, STACK, unpack};
use crate::geom::{Aabb, TrianglePoint, Vec3};
use crate::partition::{Hit, Nearest, Sides};
use crate::surface::Surface;

/// Children still to be visited, each with a lower bound of what it can offer; smallest bound on top of its siblings.
struct Pending {
    entries: [(f64, u32); STACK],
    len: usize,
}

impl Pending {
    fn new() -> Self {
        Self {
            entries: [(0.0, NO_CHILD); STACK],
            len: 0,
        }
    }

    fn pop(&mut self) -> Option<(f64, u32)> {
        self.len = self.len.checked_sub(1)?;
        Some(self.entries[self.len])
    }

    /// Pushes those of four siblings whose bound is at most `limit`, the smallest last.
    fn push(&mut self, bounds: [f64; 4], children: [u32; 4], limit: f64) {
        let base = self.len;
        for i in 0..4 {
            let entry = (bounds[i], children[i]);
            if entry.0 > limit || entry.1 == NO_CHILD || self.len == STACK {
                continue;
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
}

pub(super) fn nearest(
    bvh: &Bvh,
    surface: &Surface,
    p: Vec3,
    max_mm: f64,
    accept: impl Fn(u32, &TrianglePoint) -> bool,
) -> Option<Nearest> {
    if !p.is_finite() || max_mm < 0.0 || max_mm.is_nan() || bvh.nodes.is_empty() {
        return None;
    }
    let q = bvh.frame.to_box(p);
    let pad = bvh.frame.pad(p);
    let (low, high) = ((q - pad).to_array(), (q + pad).to_array());
    let in_box = |distance_sq: f64| distance_sq * bvh.frame.scale_per_mm * bvh.frame.scale_per_mm;
    let mut best: Option<Nearest> = None;
    let mut bound = max_mm * max_mm;
    // A hair more than the bound, since scaling and squaring round too.
    let mut limit = in_box(bound) * (1.0 + 1e-14);
    let mut pending = Pending::new();
    let mut next = Some((0.0, 0));
    while let Some((lower, child)) = next {
        if lower <= limit {
            match unpack(child) {
                Child::Node(node) => {
                    let node = &bvh.nodes[node as usize];
                    pending.push(distances_sq(node, low, high), node.child, limit);
                }
                Child::Leaf(start, count) => {
                    for &triangle in &bvh.order[start..start + count] {
                        let at = surface.triangle(triangle).closest_point(p);
                        let point = at.point;
                        let distance_sq = point.distance_squared(p);
                        let better = match best {
                            None => distance_sq <= bound,
                            Some(b) => {
                                distance_sq < bound
                                    || (distance_sq == bound && triangle < b.triangle)
                            }
                        };
                        if better && accept(triangle, &at) {
                            bound = distance_sq;
                            limit = in_box(bound) * (1.0 + 1e-14);
                            best = Some(Nearest {
                                triangle,
                                point,
                                distance_sq,
                            });
                        }
                    }
                }
                Child::None => {}
            }
        }
        next = pending.pop();
    }
    best
}

/// Squared distances from a point, given as a small box, to the four children, in box units.
#[expect(clippy::needless_range_loop, reason = "lanes of several arrays")]
fn distances_sq(node: &Node, low: [f64; 3], high: [f64; 3]) -> [f64; 4] {
    let mut sum = [0.0; 4];
    for k in 0..3 {
        for i in 0..4 {
            let below = f64::from(node.min[k][i]) - high[k];
            let above = low[k] - f64::from(node.max[k][i]);
            let outside = if below > above { below } else { above };
            let outside = if outside > 0.0 { outside } else { 0.0 };
            sum[i] += outside * outside;
        }
    }
    sum
}

/// A segment prepared for slab tests (Kay & Kajiya 1986): entering and leaving are asked from starts that are pushed
/// apart by the padding.
struct Slabs {
    near_start: [f64; 3],
    far_start: [f64; 3],
    inverse: [f64; 3],
    backward: [bool; 3],
}

impl Slabs {
    fn new(start: Vec3, along: Vec3, pad: f64) -> Self {
        let mut slabs = Self {
            near_start: [0.0; 3],
            far_start: [0.0; 3],
            inverse: [0.0; 3],
            backward: [false; 3],
        };
        for k in 0..3 {
            let (s, d) = (start[k], along[k]);
            let backward = d < 0.0;
            let outward = if backward { -pad } else { pad };
            slabs.near_start[k] = s + outward;
            slabs.far_start[k] = s - outward;
            // A motion across the axis only: the sign of start − slab decides, and 0 · 1e300 is still 0.
            let steep = if d.abs() < 1e-300 { 1e-300 } else { d.abs() };
            slabs.inverse[k] = if backward { -1.0 / steep } else { 1.0 / steep };
            slabs.backward[k] = backward;
        }
        slabs
    }

    /// Fractions at which the segment enters the four children; infinite for those it misses before `end`.
    fn enter(&self, node: &Node, end: f64) -> [f64; 4] {
        let mut near = [0.0; 4];
        let mut far = [end; 4];
        for k in 0..3 {
            let (first, second) = if self.backward[k] {
                (&node.max[k], &node.min[k])
            } else {
                (&node.min[k], &node.max[k])
            };
            for i in 0..4 {
                let n = (f64::from(first[i]) - self.near_start[k]) * self.inverse[k];
                let f = (f64::from(second[i]) - self.far_start[k]) * self.inverse[k];
                near[i] = if n > near[i] { n } else { near[i] };
                far[i] = if f < far[i] { f } else { far[i] };
            }
        }
        let mut enter = [f64::INFINITY; 4];
        for i in 0..4 {
            if near[i] <= far[i] {
                enter[i] = near[i];
            }
        }
        enter
    }
}

pub(super) fn sweep(
    bvh: &Bvh,
    surface: &Surface,
    from: Vec3,
    to: Vec3,
    sides: Sides,
) -> Option<Hit> {
    let along = to - from;
    if !from.is_finite() || !along.is_finite() || bvh.nodes.is_empty() {
        return None;
    }
    let pad = bvh.frame.pad(from).max(bvh.frame.pad(to));
    let start = bvh.frame.to_box(from);
    let slabs = Slabs::new(start, bvh.frame.to_box(to) - start, pad);
    let mut best: Option<Hit> = None;
    let mut end = 1.0;
    let mut pending = Pending::new();
    let mut next = Some((0.0, 0));
    while let Some((enter, child)) = next {
        if enter <= end {
            match unpack(child) {
                Child::Node(node) => {
                    let node = &bvh.nodes[node as usize];
                    pending.push(slabs.enter(node, end), node.child, end);
                }
                Child::Leaf(start, count) => {
                    for &triangle in &bvh.order[start..start + count] {
                        let Some(c) = surface.triangle(triangle).crossing(from, to) else {
                            continue;
                        };
                        if !c.inward && sides == Sides::Front {
                            continue;
                        }
                        let better =
                            best.is_none_or(|b| c.t < b.t || (c.t == b.t && triangle < b.triangle));
                        if better {
                            end = c.t;
                            best = Some(Hit {
                                triangle,
                                t: c.t,
                                point: from + along * c.t,
                                inward: c.inward,
                            });
                        }
                    }
                }
                Child::None => {}
            }
        }
        next = pending.pop();
    }
    best
}

pub(super) fn in_box(bvh: &Bvh, surface: &Surface, region: &Aabb, out: &mut Vec<u32>) {
    let before = out.len();
    let pad = bvh.frame.pad(region.min).max(bvh.frame.pad(region.max));
    let low = (bvh.frame.to_box(region.min) - pad).to_array();
    let high = (bvh.frame.to_box(region.max) + pad).to_array();
    leaves_in(bvh, low, high, |start, count| {
        out.extend(
            bvh.order[start..start + count]
                .iter()
                .filter(|&&t| surface.triangle(t).aabb().overlaps(region)),
        );
    });
    out[before..].sort_unstable();
}

/// Calls `leaf` with first position and length of every leaf whose box shares a point with the given one, in box units.
pub(super) fn leaves_in(
    bvh: &Bvh,
    low: [f64; 3],
    high: [f64; 3],
    mut leaf: impl FnMut(usize, usize),
) {
    let mut pending = Pending::new();
    let mut next = (!bvh.nodes.is_empty()).then_some((0.0, 0));
    while let Some((_, child)) = next {
        match unpack(child) {
            Child::Node(node) => {
                let node = &bvh.nodes[node as usize];
                pending.push(apart(node, low, high), node.child, 0.5);
            }
            Child::Leaf(start, count) => leaf(start, count),
            Child::None => {}
        }
        next = pending.pop();
    }
}

/// 0 for the children whose boxes share a point with the given one, 1 for the others.
#[expect(clippy::needless_range_loop, reason = "lanes of several arrays")]
fn apart(node: &Node, low: [f64; 3], high: [f64; 3]) -> [f64; 4] {
    let mut apart = [0.0; 4];
    for k in 0..3 {
        for i in 0..4 {
            if f64::from(node.min[k][i]) > high[k] || f64::from(node.max[k][i]) < low[k] {
                apart[i] = 1.0;
            }
        }
    }
    apart
}
