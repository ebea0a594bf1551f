//! Makes a mesh manifold: which triangles stay joined at a crowded edge, and which vertices have to be doubled.

use super::Sheet;
use crate::geom::{Vec3, unit_or};
use crate::surface::RIM;
use crate::surface::edges::{HalfEdges, ends};
use crate::surface::topology::{Bits, corner_of};

/// Half-edges at one edge up to which pairs are looked for; beyond it the edge is cut altogether.
const CROWD: usize = 32;

/// Pairs of half-edges of one edge that stay joined, while none of the crowded edges is joined yet.
///
/// First those that the other triangles round an end of the edge lead from one to the other: so a skin stays whole where a
/// fin stands on it, and two bodies that touch along an edge come apart whole. Then those that agree in orientation, then
/// the flattest: so two sheets that cross go straight on.
pub(super) fn pairs(sheet: &Sheet, group: &[u32]) -> Vec<(u32, u32)> {
    if group.len() > CROWD {
        return Vec::new();
    }
    let away: Vec<Vec3> = group.iter().map(|&h| away_from_edge(sheet, h)).collect();
    let far = |&h: &u32| [0, 1].map(|end| fan_end(sheet, h, ends(&sheet.triangles, h)[end]));
    let far: Vec<[u32; 2]> = group.iter().map(far).collect();
    let mut candidates = Vec::new();
    for (i, &g) in group.iter().enumerate() {
        for (j, &h) in group.iter().enumerate().skip(i + 1) {
            let round = far[i].contains(&h);
            let agree = ends(&sheet.triangles, g)[0] != ends(&sheet.triangles, h)[0];
            candidates.push((!round, !agree, away[i].dot(away[j]), g, h));
        }
    }
    candidates.sort_by(|a, b| {
        ((a.0, a.1).cmp(&(b.0, b.1)))
            .then(a.2.total_cmp(&b.2))
            .then((a.3, a.4).cmp(&(b.3, b.4)))
    });
    let mut pairs: Vec<(u32, u32)> = Vec::new();
    for (.., g, h) in candidates {
        if (pairs.iter()).all(|&(p, q)| ![p, q].contains(&g) && ![p, q].contains(&h)) {
            pairs.push((g, h));
        }
    }
    pairs
}

/// Where one comes out walking round `v` from the unjoined half-edge `half`, whichever way the triangles are oriented.
fn fan_end(sheet: &Sheet, half: u32, v: u32) -> u32 {
    let (mut t, mut edge) = (half / 3, half as usize % 3);
    loop {
        let corner = corner_of(&sheet.triangles[t as usize], v);
        // The two edges at the corner are `corner` and `corner + 2`.
        edge = if edge == corner {
            (corner + 2) % 3
        } else {
            corner
        };
        let u = sheet.across[t as usize][edge];
        if u == RIM {
            return 3 * t + edge as u32;
        }
        (t, edge) = (u, sheet.edge_to(u, t));
    }
}

/// Unit vector in the triangle's plane, at right angles to the edge, pointing into the triangle.
fn away_from_edge(sheet: &Sheet, half: u32) -> Vec3 {
    let [a, b, c] = ends(&sheet.triangles, half).map(|v| sheet.positions[v as usize]);
    let along = unit_or(b - a, Vec3::ZERO);
    unit_or((c - a).reject_from_normalized(along), Vec3::ZERO)
}

/// Gives every fan of triangles round a vertex its own vertex. Returns the vertices that were doubled, ascending.
pub(super) fn split_fans(sheet: &mut Sheet) -> Vec<u32> {
    let mut done = Bits::new(sheet.triangles.len() * 3);
    let mut seen = Bits::new(sheet.positions.len());
    let mut fan = Vec::new();
    let mut doubled = Vec::new();
    for t in 0..sheet.triangles.len() as u32 {
        for i in 0..3 {
            if done.get(3 * t as usize + i) {
                continue;
            }
            let v = sheet.triangles[t as usize][i];
            fan.clear();
            done.set(3 * t as usize + i);
            fan.push((t, i));
            for side in [2, 0] {
                walk(sheet, (t, i), side, &mut done, &mut fan);
            }
            if seen.get(v as usize) {
                let copy = sheet.positions.len() as u32;
                sheet.positions.push(sheet.positions[v as usize]);
                sheet.vertex_ids.push(sheet.vertex_ids[v as usize]);
                for &(t, i) in &fan {
                    sheet.triangles[t as usize][i] = copy;
                }
                doubled.push(v);
            } else {
                seen.set(v as usize);
            }
        }
    }
    doubled.sort_unstable();
    doubled.dedup();
    doubled
}

/// Collects the corners round a vertex, leaving each triangle across the edge `side` places after the corner.
fn walk(
    sheet: &Sheet,
    (mut t, mut i): (u32, usize),
    side: usize,
    done: &mut Bits,
    fan: &mut Vec<(u32, usize)>,
) {
    let v = sheet.triangles[t as usize][i];
    loop {
        let u = sheet.across[t as usize][(i + side) % 3];
        if u == RIM {
            return;
        }
        (t, i) = (u, corner_of(&sheet.triangles[u as usize], v));
        if done.get(3 * t as usize + i) {
            return;
        }
        done.set(3 * t as usize + i);
        fan.push((t, i));
    }
}

/// Parts triangles that still name the vertices of an edge they are not joined at from all their neighbours. Returns
/// them, ascending; their vertices are still to be split.
///
/// This happens where a cut edge ends in vertices that the two sides share all the same by a way round.
pub(super) fn cut_loose(sheet: &mut Sheet) -> Vec<u32> {
    let mut loose = Vec::new();
    let edges = HalfEdges::new(sheet.positions.len(), &sheet.triangles);
    edges.for_each(|_, _, group| {
        if group.len() < 2 {
            return;
        }
        let neighbour = |h: u32| sheet.across[h as usize / 3][h as usize % 3];
        let first = (group.iter().copied().find(|&h| neighbour(h) != RIM)).unwrap_or(group[0]);
        let kept = [first / 3, neighbour(first)];
        loose.extend(group.iter().map(|h| h / 3).filter(|t| !kept.contains(t)));
    });
    loose.sort_unstable();
    loose.dedup();
    for &t in &loose {
        for i in 0..3 {
            let u = sheet.across[t as usize][i];
            if u != RIM {
                let j = sheet.edge_to(u, t);
                sheet.across[u as usize][j] = RIM;
                sheet.across[t as usize][i] = RIM;
            }
        }
    }
    loose
}
