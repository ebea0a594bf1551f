//! What light the shape of the rest surface keeps out, and where the skin is a little redder: baked once per vertex.
//!
//! *Hollowness* is the mean height, over the surface around a vertex, above the tangent plane, per width of what counts as
//! around: positive in a hollow, negative on a ridge, w ∕ ρ on a bowl of radius ρ ≫ w. It is a first-order ambient
//! occlusion that also brightens ridges (in the spirit of accessibility shading, Miller 1994) and, unlike rays, needs no
//! sampling noise to be hidden. Three widths are added, so that the light falls off softly from the wide hollows (loin,
//! beside the shoulder blades) to the narrow ones (furrow, dimples); far more of it is drawn little darker.

use super::mesh::Shade;
use crate::geom::{Vec3, unit_or};
use crate::surface::Surface;
use std::collections::BTreeMap;

/// Width of the neighbourhood (mm; its kernel is that of a Gaussian of this deviation) and weight of its hollowness. A
/// sum of 1 is most of the way to full shade.
const WIDTHS: [(f64, f64); 3] = [(36.0, 0.9), (18.0, 3.0), (10.0, 2.2)];
/// Cells per width of the summary that stands for the surface around.
const CELLS_PER_WIDTH: f64 = 2.0;
/// Reach of the kernel (1 − d²/R²)³ in widths: R at which it comes nearest to the Gaussian.
const REACH: f64 = 2.5;

/// Bakes every vertex on up to `n_threads` threads. The result does not depend on how many.
///
/// Cost: some 240 patches visited per vertex, about 17 µs per vertex and thread (measured at opt-level 1 on two busy
/// cores); linear in the number of vertices.
pub fn bake(surface: &Surface, n_threads: usize) -> Vec<Shade> {
    let n = surface.positions().len();
    let mut hollow = vec![0.0; n];
    for (width_mm, weight) in WIDTHS {
        let summary = Summary::new(surface, width_mm);
        // By cell, so that the patches around are gathered once for all its vertices.
        let mut order: Vec<([i32; 3], u32)> = (0..n as u32)
            .map(|v| (cell_of(surface.positions()[v as usize], summary.cell_mm), v))
            .collect();
        order.sort_unstable();
        let mut found = vec![0.0; n];
        let chunk = n.div_ceil(n_threads.max(1)).max(1);
        std::thread::scope(|scope| {
            for (order, found) in order.chunks(chunk).zip(found.chunks_mut(chunk)) {
                let summary = &summary;
                let mut work = move || summary.hollowness_of(surface, order, found);
                if n_threads <= 1 {
                    work();
                } else {
                    scope.spawn(work);
                }
            }
        });
        for (&(_, v), found) in order.iter().zip(found) {
            hollow[v as usize] += weight * found;
        }
    }
    surface
        .positions()
        .iter()
        .zip(hollow)
        .map(|(&p, hollow)| {
            let [warm, light] = tone(p);
            let open = 0.5 - 0.5 * hollow / (1.0 + hollow * hollow).sqrt();
            [open, warm, light, 1.0].map(|x| (x.clamp(0.0, 1.0) * 255.0).round() as u8)
        })
        .collect()
}

/// How red and how light the skin is at a place, each 0…1: slow, so that no patch of it is taken for relief.
fn tone(p: Vec3) -> [f64; 2] {
    [
        value_noise(p / 60.0) * 0.7 + value_noise(p / 24.0 + Vec3::splat(9.7)) * 0.3,
        value_noise(p / 90.0 + Vec3::splat(31.3)),
    ]
}

/// The surface summed up in the cells of a cubic grid.
struct Summary {
    reach_mm: f64,
    cell_mm: f64,
    cells: BTreeMap<[i32; 3], Patch>,
}

/// The part of the surface in one cell.
#[derive(Clone, Copy, Default)]
struct Patch {
    area_mm2: f64,
    /// First a sum weighted by area, then its mean.
    centre_mm: Vec3,
    /// First a sum weighted by area, then of length 1.
    normal: Vec3,
}

impl Summary {
    fn new(surface: &Surface, width_mm: f64) -> Self {
        let cell_mm = width_mm / CELLS_PER_WIDTH;
        let mut cells: BTreeMap<[i32; 3], Patch> = BTreeMap::new();
        for t in 0..surface.triangles().len() as u32 {
            let triangle = surface.triangle(t);
            let centre = triangle.centroid();
            let normal = triangle.area_normal() / 2.0;
            let area = normal.length();
            let patch = cells.entry(cell_of(centre, cell_mm)).or_default();
            patch.area_mm2 += area;
            patch.centre_mm += centre * area;
            patch.normal += normal;
        }
        cells.retain(|_, patch| patch.area_mm2 > 0.0);
        for patch in cells.values_mut() {
            patch.centre_mm /= patch.area_mm2;
            patch.normal = unit_or(patch.normal, Vec3::ZERO);
        }
        Self {
            reach_mm: REACH * width_mm,
            cell_mm,
            cells,
        }
    }

    fn hollowness_of(&self, surface: &Surface, order: &[([i32; 3], u32)], found: &mut [f64]) {
        let mut around = Vec::new();
        let mut gathered_at = None;
        for (&(cell, v), found) in order.iter().zip(found) {
            if gathered_at != Some(cell) {
                gathered_at = Some(cell);
                self.gather(cell, &mut around);
            }
            let (p, n) = (
                surface.positions()[v as usize],
                surface.normals()[v as usize],
            );
            *found = self.hollowness(p, n, &around);
        }
    }

    /// Mean height of the surface around `p` above the plane with normal `n`, per width.
    fn hollowness(&self, p: Vec3, n: Vec3, around: &[Patch]) -> f64 {
        let (mut sum, mut weight) = (0.0, 0.0);
        let per_reach = 1.0 / (self.reach_mm * self.reach_mm);
        for patch in around {
            let d = patch.centre_mm - p;
            let left = 1.0 - d.length_squared() * per_reach;
            // What faces away belongs to another side of the body.
            let facing = n.dot(patch.normal);
            if left > 0.0 && facing > 0.0 {
                let w = patch.area_mm2 * facing * left * left * left;
                sum += w * n.dot(d);
                weight += w;
            }
        }
        if weight > 0.0 {
            sum / weight * (REACH / self.reach_mm)
        } else {
            0.0
        }
    }

    fn gather(&self, cell: [i32; 3], around: &mut Vec<Patch>) {
        around.clear();
        let reach = (self.reach_mm / self.cell_mm).ceil() as i32;
        for x in cell[0] - reach..=cell[0] + reach {
            for y in cell[1] - reach..=cell[1] + reach {
                let column = [x, y, cell[2] - reach]..=[x, y, cell[2] + reach];
                around.extend(self.cells.range(column).map(|(_, patch)| *patch));
            }
        }
    }
}

fn cell_of(p: Vec3, cell_mm: f64) -> [i32; 3] {
    (p / cell_mm).floor().to_array().map(|x| x as i32)
}

/// Smooth noise in 0…1 with one bump per unit length.
fn value_noise(p: Vec3) -> f64 {
    let base = p.floor();
    let f = p - base;
    let f = f * f * (Vec3::splat(3.0) - 2.0 * f);
    let corner = base.to_array().map(|x| x as i64);
    let mut sum = 0.0;
    for k in 0..8_i64 {
        let bit = [k & 1, k >> 1 & 1, k >> 2];
        let w = (0..3)
            .map(|a| if bit[a] == 1 { f[a] } else { 1.0 - f[a] })
            .product::<f64>();
        sum += w * hashed([0, 1, 2].map(|a| corner[a] + bit[a]));
    }
    sum
}

/// A number in 0…1 for a lattice point (finaliser of SplitMix64; Steele et al. 2014).
fn hashed(lattice: [i64; 3]) -> f64 {
    let mut z = lattice.iter().fold(0x9e37_79b9_7f4a_7c15_u64, |h, &x| {
        (h ^ x as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9)
    });
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as f64 / u64::MAX as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::RawMesh;

    /// A 200 mm square of height `z(x, y)`, 5 mm spacing.
    fn sheet(z: impl Fn(f64, f64) -> f64) -> Surface {
        let n = 40;
        let mut raw = RawMesh::default();
        for j in 0..=n {
            for i in 0..=n {
                let (x, y) = (f64::from(i) * 5.0 - 100.0, f64::from(j) * 5.0 - 100.0);
                raw.positions.push(Vec3::new(x, y, z(x, y)));
            }
        }
        let at = |i: i32, j: i32| (j * (n + 1) + i) as u32;
        for j in 0..n {
            for i in 0..n {
                raw.triangles
                    .push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                raw.triangles
                    .push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        Surface::new(raw).unwrap().0
    }

    fn near(surface: &Surface, x: f64, y: f64) -> usize {
        (0..surface.positions().len())
            .min_by(|&a, &b| {
                let d = |i: usize| (surface.positions()[i] - Vec3::new(x, y, 0.0)).length();
                d(a).total_cmp(&d(b))
            })
            .unwrap()
    }

    #[test]
    fn a_plane_is_neither_hollow_nor_ridge() {
        let s = sheet(|_, _| 0.0);
        let shade = bake(&s, 1);
        assert!(shade.iter().all(|b| (126..=129).contains(&b[0])));
    }

    #[test]
    fn a_furrow_is_darker_than_the_ridges_beside_it() {
        let s = sheet(|x, _| 6.0 * (x / 30.0).cos().abs());
        let shade = bake(&s, 1);
        let floor = shade[near(&s, 45.0, 0.0)][0];
        let crest = shade[near(&s, 0.0, 0.0)][0];
        assert!(floor < 110 && crest > 146, "floor {floor}, crest {crest}");
    }

    #[test]
    fn the_result_does_not_depend_on_the_number_of_threads() {
        let s = sheet(|x, y| 5.0 * (x / 20.0).sin() * (y / 25.0).cos());
        assert_eq!(bake(&s, 1), bake(&s, 3));
    }
}
