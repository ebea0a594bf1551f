//! Which triangles does another sheet run through or touch?
//!
//! A finger that walks over a triangle can only meet another sheet where that sheet meets the triangle. On a surface
//! that does not cut itself no triangle is marked, and the walk never needs to ask.

use super::{Bvh, Child, Node, query, unpack};
use crate::geom::{Triangle, Vec3};
use crate::surface::Surface;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Nodes a thread takes at a time.
const BATCH: usize = 1024;

/// One bit per triangle, none at all where no triangle is marked: set where a triangle that is no neighbour comes within rounding of it, or one that shares just a
/// corner goes through it.
pub(super) fn crossed(bvh: &Bvh, surface: &Surface, threads: usize) -> Box<[u64]> {
    let next = AtomicUsize::new(0);
    let found = Mutex::new(Vec::new());
    let work = || {
        let mut mine = Vec::new();
        let mut near = Vec::new();
        loop {
            let first = next.fetch_add(BATCH, Ordering::Relaxed);
            let Some(batch) = bvh.nodes.get(first..(first + BATCH).min(bvh.nodes.len())) else {
                break;
            };
            for node in batch {
                for lane in 0..4 {
                    meet_others(bvh, surface, node, lane, &mut near, &mut mine);
                }
            }
        }
        match found.lock() {
            Ok(mut all) => all.append(&mut mine),
            Err(poisoned) => poisoned.into_inner().append(&mut mine),
        }
    };
    let helpers = threads.min(bvh.nodes.len() / BATCH);
    std::thread::scope(|scope| {
        for i in 1..helpers {
            let helper = std::thread::Builder::new().name(format!("crossed-{i}"));
            if helper.spawn_scoped(scope, work).is_err() {
                break;
            }
        }
        work();
    });
    let found: Vec<u32> = found
        .into_inner()
        .unwrap_or_else(|poisoned| poisoned.into_inner());
    if found.is_empty() {
        return Box::default();
    }
    let mut bits = vec![0_u64; surface.triangles().len().div_ceil(64)];
    for t in found {
        bits[t as usize / 64] |= 1 << (t % 64);
    }
    bits.into_boxed_slice()
}

/// Holds the triangles of one leaf against those of the leaves from there on, and lists those that meet.
fn meet_others(
    bvh: &Bvh,
    surface: &Surface,
    node: &Node,
    lane: usize,
    near: &mut Vec<(usize, usize)>,
    found: &mut Vec<u32>,
) {
    let Child::Leaf(start, count) = unpack(node.child[lane]) else {
        return;
    };
    let pad = bvh.frame.pad(Vec3::ZERO);
    let low = [0, 1, 2].map(|k| f64::from(node.min[k][lane]) - pad);
    let high = [0, 1, 2].map(|k| f64::from(node.max[k][lane]) + pad);
    near.clear();
    query::leaves_in(bvh, low, high, |other, n| {
        if other >= start {
            near.push((other, n));
        }
    });
    let margin = 64.0 * f64::EPSILON * bvh.frame.reach_mm;
    for i in start..start + count {
        let t = bvh.order[i];
        let one = surface.triangle(t);
        let bounds = one.aabb().grown(margin);
        for &(other, n) in near.iter() {
            for j in other.max(i + 1)..other + n {
                let u = bvh.order[j];
                let two = surface.triangle(u);
                if !bounds.overlaps(&two.aabb()) {
                    continue;
                }
                let (a, b) = (
                    surface.triangles()[t as usize],
                    surface.triangles()[u as usize],
                );
                let shared = a.iter().filter(|v| b.contains(v)).count();
                let meet = match shared {
                    0 => !apart(&one, &two, margin),
                    1 => through(&one, a, &two, b, margin) || through(&two, b, &one, a, margin),
                    _ => false,
                };
                if meet {
                    found.extend([t, u]);
                }
            }
        }
    }
}

/// Whether the edge of `two` opposite to the corner it shares with `one` goes through `one`.
///
/// Where it lies in the plane of `one`, which side of it an end is on is rounding: there the two meet where they overlap
/// apart from that corner.
fn through(one: &Triangle, a: [u32; 3], two: &Triangle, b: [u32; 3], margin_mm: f64) -> bool {
    let at = b.iter().position(|v| a.contains(v)).unwrap_or(0);
    let corners = [two.a, two.b, two.c];
    let (p, q) = (corners[(at + 1) % 3], corners[(at + 2) % 3]);
    let n = one.area_normal();
    let (above_p, above_q) = (n.dot(p - one.a), n.dot(q - one.a));
    if above_p.abs().max(above_q.abs()) <= margin_mm * n.length() {
        let off_the_corner = Triangle {
            a: corners[at].lerp((p + q) / 2.0, 1.0 / 64.0),
            b: p,
            c: q,
        };
        return !apart(one, &off_the_corner, margin_mm);
    }
    above_p * above_q <= 0.0 && one.crossing(p, q).is_some()
}

/// Whether an axis separates the two by more than `margin_mm` (Gottschalk et al. 1996: the normals, the products of
/// edges, and for triangles in one plane the products of normal and edges).
fn apart(one: &Triangle, two: &Triangle, margin_mm: f64) -> bool {
    let origin = one.a;
    let p = [one.a, one.b, one.c].map(|v| v - origin);
    let q = [two.a, two.b, two.c].map(|v| v - origin);
    let separates = |axis: Vec3| {
        let (a, b) = (p.map(|v| v.dot(axis)), q.map(|v| v.dot(axis)));
        let ends = |v: [f64; 3]| (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]));
        let ((a0, a1), (b0, b1)) = (ends(a), ends(b));
        let gap = (b0 - a1).max(a0 - b1);
        gap > 0.0 && gap * gap > margin_mm * margin_mm * axis.length_squared()
    };
    let edges = |c: &[Vec3; 3]| [c[1] - c[0], c[2] - c[1], c[0] - c[2]];
    let (e, f) = (edges(&p), edges(&q));
    let (n, m) = (e[0].cross(e[1]), f[0].cross(f[1]));
    separates(n)
        || separates(m)
        || e.iter().any(|e| separates(n.cross(*e)))
        || f.iter().any(|f| separates(m.cross(*f)))
        || e.iter().any(|e| f.iter().any(|f| separates(e.cross(*f))))
}
