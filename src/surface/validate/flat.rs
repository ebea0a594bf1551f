//! Triangles without area: found, and removed so that no gap stays behind.

use super::{Element, Found, Sheet};
use crate::geom::Vec3;
use crate::surface::edges::{HalfEdges, ends};
use crate::surface::topology::Bits;

/// Height over longest edge below which a triangle has no area: far above what rounding leaves of three points on a line
/// (10⁻¹³ for a back written with all digits), far below the thinnest triangle of a 32-bit file (10⁻⁷).
const THINNEST: f64 = 1.0e-10;

/// How often neighbours are cut; each time closes the gap of one more vertex on the same edge.
const ROUNDS: usize = 16;

/// Whether the triangle is more than a point or a line, and has a normal.
pub(super) fn has_area([a, b, c]: [Vec3; 3]) -> bool {
    let (ab, ac) = (b - a, c - a);
    let longest_sq = (ab.length_squared())
        .max(ac.length_squared())
        .max((c - b).length_squared());
    let doubled_area_sq = ab.cross(ac).length_squared();
    doubled_area_sq >= f64::MIN_POSITIVE && doubled_area_sq.sqrt() > THINNEST * longest_sq
}

/// Removes the triangles without area.
///
/// Three vertices on a line fill the gap between one long edge on one side and two short ones on the other. Without the
/// triangle the surface would have a slit there, so the neighbour at the long edge is cut in two at the vertex between.
pub(super) fn remove_flat(sheet: &mut Sheet) -> Found<Element> {
    let mut flat: Vec<u32> = (0..sheet.triangles.len() as u32)
        .filter(|&t| !sheet.has_area(t))
        .collect();
    let found = sheet.found(&flat);
    for _ in 0..ROUNDS {
        let cuts = cuts(sheet, &flat);
        if cuts.is_empty() {
            break;
        }
        for &(filler, neighbour) in &cuts {
            let [from, to, over] = ends(&sheet.triangles, neighbour);
            let [.., between] = ends(&sheet.triangles, filler);
            let (t, n) = (filler as usize / 3, neighbour as usize / 3);
            sheet.triangles[n] = [from, between, over];
            sheet.triangles[t] = [between, to, over];
            sheet.triangle_ids[t] = sheet.triangle_ids[n];
        }
        flat.extend(cuts.iter().map(|&(_, neighbour)| neighbour / 3));
        flat.sort_unstable();
        flat.retain(|&t| !sheet.has_area(t));
    }
    sheet.remove(&flat);
    found
}

/// Long half-edges of triangles without area, with the half-edge of the only neighbour there, each triangle once.
fn cuts(sheet: &Sheet, flat: &[u32]) -> Vec<(u32, u32)> {
    let names_three = |&t: &u32| {
        let [a, b, c] = sheet.triangles[t as usize];
        a != b && b != c && c != a
    };
    if !flat.iter().any(names_three) {
        return Vec::new();
    }
    let mut is_flat = Bits::new(sheet.triangles.len());
    flat.iter().for_each(|&t| is_flat.set(t as usize));
    let mut taken = Bits::new(sheet.triangles.len());
    let mut cuts = Vec::new();
    let edges = HalfEdges::new(sheet.positions.len(), &sheet.triangles);
    edges.for_each(|_, _, group| {
        let [g, h] = *group else { return };
        let flat = |half: u32| is_flat.get(half as usize / 3);
        let (filler, neighbour) = if flat(g) { (g, h) } else { (h, g) };
        let [t, n] = [filler, neighbour].map(|half| half / 3);
        if flat(filler)
            && !flat(neighbour)
            && names_three(&t)
            && !taken.get(n as usize)
            && !taken.get(t as usize)
            && longest_edge(sheet, t) == filler as usize % 3
        {
            taken.set(n as usize);
            taken.set(t as usize);
            cuts.push((filler, neighbour));
        }
    });
    cuts
}

fn longest_edge(sheet: &Sheet, t: u32) -> usize {
    let p = sheet.triangles[t as usize].map(|v| sheet.positions[v as usize]);
    let length_sq = |i: usize| p[i].distance_squared(p[(i + 1) % 3]);
    let longest = if length_sq(1) > length_sq(0) { 1 } else { 0 };
    if length_sq(2) > length_sq(longest) {
        2
    } else {
        longest
    }
}

impl Sheet {
    fn has_area(&self, t: u32) -> bool {
        has_area(self.triangles[t as usize].map(|v| self.positions[v as usize]))
    }
}
