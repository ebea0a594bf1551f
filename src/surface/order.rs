//! The order in which a surface keeps its triangles and vertices: along a space-filling curve, so that what lies together
//! on the skin lies together in memory. A finger that slides over millions of triangles then finds the next ones in the
//! cache, whatever order the file had.
//!
//! Triangles follow the Hilbert curve through a cube around the mesh, by their centroids; those in one cell keep the
//! order they had. Vertices follow by first use. Corners are not turned.

use crate::geom::{Aabb, Vec3};

/// Most cells along an edge of the cube, as a power of two: at 400 mm a cell is 6 µm wide.
const MAX_BITS: u32 = 16;

/// A mesh whose elements have been renumbered along the curve.
pub(super) struct Ordered {
    pub positions: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Neighbours across the edges, renumbered as well.
    pub across: Vec<[u32; 3]>,
    /// The number that each triangle had before.
    pub was: Vec<u32>,
}

/// Renumbers a mesh along the curve. Indices must be within range and every vertex in use; values in `across` that name
/// no triangle are kept as they are.
pub(super) fn ordered(positions: &[Vec3], triangles: &[[u32; 3]], across: &[[u32; 3]]) -> Ordered {
    let was = along_curve(positions, triangles);
    let mut is_now = vec![0_u32; was.len()];
    for (now, &t) in was.iter().enumerate() {
        is_now[t as usize] = now as u32;
    }
    let across = (was.iter())
        .map(|&t| across[t as usize].map(|u| is_now.get(u as usize).copied().unwrap_or(u)))
        .collect();
    drop(is_now);

    const UNUSED: u32 = u32::MAX;
    let mut place = vec![UNUSED; positions.len()];
    let mut moved = Vec::with_capacity(positions.len());
    let renumbered = (was.iter())
        .map(|&t| {
            triangles[t as usize].map(|v| {
                let place = &mut place[v as usize];
                if *place == UNUSED {
                    *place = moved.len() as u32;
                    moved.push(positions[v as usize]);
                }
                *place
            })
        })
        .collect();
    Ordered {
        positions: moved,
        triangles: renumbered,
        across,
        was,
    }
}

/// Numbers of the triangles in the order of the curve.
fn along_curve(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<u32> {
    // Position on the curve above, number below: sorting the two as one number is quick, and stable.
    let index_bits = usize::BITS - triangles.len().leading_zeros();
    let bits = ((u64::BITS - index_bits) / 3).min(MAX_BITS);
    let cube = Cube::around(positions, bits);
    let mut keys: Vec<u64> = (triangles.iter().enumerate())
        .map(|(t, corners)| {
            let [a, b, c] = corners.map(|v| positions[v as usize]);
            hilbert(cube.cell((a + b + c) / 3.0), bits) << index_bits | t as u64
        })
        .collect();
    keys.sort_unstable();
    let index = (1_u64 << index_bits) - 1;
    keys.into_iter().map(|key| (key & index) as u32).collect()
}

/// The cube that the curve fills.
struct Cube {
    min: Vec3,
    cells_per_mm: f64,
    last_cell: f64,
}

impl Cube {
    fn around(positions: &[Vec3], bits: u32) -> Self {
        let bounds = Aabb::of_points(positions.iter().copied());
        let n_cells = f64::from(1_u32 << bits);
        let cells_per_mm = n_cells / bounds.size().max_element();
        Self {
            min: bounds.min,
            cells_per_mm: if cells_per_mm.is_finite() {
                cells_per_mm
            } else {
                0.0
            },
            last_cell: n_cells - 1.0,
        }
    }

    fn cell(&self, p: Vec3) -> [u32; 3] {
        let cell = |x: f64| x.clamp(0.0, self.last_cell) as u32;
        ((p - self.min) * self.cells_per_mm).to_array().map(cell)
    }
}

/// Position on the Hilbert curve of a cell, whose numbers have `bits` bits each.
fn hilbert(cell: [u32; 3], bits: u32) -> u64 {
    let mut state = 0;
    let mut at = 0;
    for level in (0..bits).rev() {
        let bit = |k: usize| (cell[k] >> level & 1) << k;
        let octant = bit(0) | bit(1) | bit(2);
        let step = STEPS[state as usize][octant as usize];
        at = at << 3 | u64::from(step & 7);
        state = step >> 3;
    }
    at
}

/// For each state of the curve and each octant: when the curve passes the octant (below) and its state in there (above).
///
/// A state is the octant that the curve enters by, and the axis along which it leaves, as 3 · entry + axis: the curve of
/// Hamilton & Rau-Chaplin (2008, Compact Hilbert indices, Inf. Process. Lett. 105) in three dimensions.
const STEPS: [[u8; 8]; 24] = {
    let mut steps = [[0; 8]; 24];
    let mut state = 0;
    while state < 24 {
        let (entry, axis) = (state as u32 / 3, state as u32 % 3);
        let mut octant = 0;
        while octant < 8 {
            let when = ungray(turn_right(octant as u32 ^ entry, axis + 1));
            let entry = entry ^ turn_left(entry_of(when), axis + 1);
            let axis = (axis + direction_of(when) + 1) % 3;
            steps[state][octant] = ((3 * entry + axis) << 3 | when) as u8;
            octant += 1;
        }
        state += 1;
    }
    steps
};

/// Turns three bits towards the lower ones.
const fn turn_right(bits: u32, by: u32) -> u32 {
    let by = by % 3;
    (bits >> by | bits << (3 - by)) & 7
}

/// Turns three bits towards the higher ones.
const fn turn_left(bits: u32, by: u32) -> u32 {
    turn_right(bits, 3 - by % 3)
}

const fn gray(i: u32) -> u32 {
    i ^ i >> 1
}

/// The number whose Gray code is `code`, of three bits.
const fn ungray(code: u32) -> u32 {
    code ^ code >> 1 ^ code >> 2
}

/// Corner by which the curve enters the octant that it passes as number `when`.
const fn entry_of(when: u32) -> u32 {
    if when == 0 { 0 } else { gray((when - 1) & !1) }
}

/// Axis along which the curve crosses the octant that it passes as number `when`.
const fn direction_of(when: u32) -> u32 {
    let run = if when.is_multiple_of(2) {
        when.saturating_sub(1)
    } else {
        when
    };
    if when == 0 {
        0
    } else {
        run.trailing_ones() % 3
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::primitives::{bench_patch, cuboid, icosphere};
    use crate::surface::{RIM, RawMesh, Surface, Topology};
    use proptest::prelude::*;

    #[test]
    fn the_curve_passes_every_cell_once_and_goes_from_neighbour_to_neighbour() {
        for bits in [1, 2, 4] {
            let n = 1_u32 << bits;
            let mut cells = vec![None; (n as usize).pow(3)];
            for x in 0..n {
                for y in 0..n {
                    for z in 0..n {
                        let at = hilbert([x, y, z], bits) as usize;
                        assert_eq!(cells[at], None, "twice at {at}");
                        cells[at] = Some([x, y, z]);
                    }
                }
            }
            let cells: Vec<[u32; 3]> = cells.into_iter().map(|c| c.expect("passed")).collect();
            assert_eq!(cells[0], [0; 3]);
            for pair in cells.windows(2) {
                let steps: u32 = (0..3).map(|k| pair[0][k].abs_diff(pair[1][k])).sum();
                assert_eq!(steps, 1, "{pair:?} at {bits} bits");
            }
        }
    }

    /// Places of the corners of every triangle, in the order given.
    fn places(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<[Vec3; 3]> {
        (triangles.iter())
            .map(|c| c.map(|v| positions[v as usize]))
            .collect()
    }

    fn check(mesh: &RawMesh) {
        let before = Topology::new(mesh.positions.len(), &mesh.triangles);
        let across: Vec<[u32; 3]> = (0..mesh.triangles.len() as u32)
            .map(|t| before.across(t))
            .collect();
        let now = ordered(&mesh.positions, &mesh.triangles, &across);
        let mut listed = now.was.clone();
        listed.sort_unstable();
        assert!(listed.iter().copied().eq(0..mesh.triangles.len() as u32));
        assert_eq!(now.positions.len(), mesh.positions.len());
        let (old, new) = (
            places(&mesh.positions, &mesh.triangles),
            places(&now.positions, &now.triangles),
        );
        let mut highest = 0;
        for (t, &was) in now.was.iter().enumerate() {
            assert_eq!(new[t], old[was as usize], "triangle {t}, {was} before");
            let over = now.across[t].map(|u| if u == RIM { RIM } else { now.was[u as usize] });
            assert_eq!(over, across[was as usize], "across triangle {t}");
            for v in now.triangles[t] {
                assert!(v <= highest, "vertex {v} before {highest} was used");
                highest = highest.max(v + 1);
            }
        }
        let again = ordered(&now.positions, &now.triangles, &now.across);
        assert_eq!(
            (again.positions, again.triangles),
            (now.positions, now.triangles)
        );
    }

    #[test]
    fn renumbering_changes_numbers_only_and_is_done_after_once() {
        check(&RawMesh {
            positions: vec![Vec3::X, Vec3::Y, Vec3::Z],
            triangles: vec![[2, 0, 1]],
        });
        check(&cuboid(Vec3::splat(-1.0e6), Vec3::splat(1.0e6)));
        check(&icosphere(1.0e-3, 3));
        check(&bench_patch(3024));
    }

    #[test]
    fn triangles_in_one_cell_keep_their_order() {
        // Sixty-four slim triangles about one centroid, and a pair far off that makes the cells large.
        let mut mesh = RawMesh::default();
        for i in 0..64 {
            let turn = f64::from(i * 37 % 64) / 64.0;
            let (s, c) = (1e-9 * libm::sin(turn), 1e-9 * libm::cos(turn));
            let n = mesh.positions.len() as u32;
            mesh.positions.extend([
                Vec3::new(50.0 + c, 50.0 + s, 0.0),
                Vec3::new(50.0 - c, 50.0 - s, 0.0),
                Vec3::new(50.0, 50.0, 1e-9),
            ]);
            mesh.triangles.push([n, n + 1, n + 2]);
        }
        for far in [0.0, 1000.0] {
            let n = mesh.positions.len() as u32;
            mesh.positions
                .extend([Vec3::X, Vec3::Y, Vec3::Z].map(|p| p + far));
            mesh.triangles.push([n, n + 1, n + 2]);
        }
        let was = along_curve(&mesh.positions, &mesh.triangles);
        let within: Vec<u32> = was.into_iter().filter(|&t| t < 64).collect();
        assert!(within.iter().copied().eq(0..64), "{within:?}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// Where no two triangles share a cell, nothing of the order in the file is left.
        #[test]
        fn a_shuffled_file_gives_the_same_surface(seed in any::<u64>()) {
            let mut mesh = bench_patch(1000);
            let (surface, _) = Surface::new(mesh.clone()).expect("sound");
            let mut state = seed;
            let mut below = |n: usize| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695);
                (state >> 33) as usize % n
            };
            let n = mesh.positions.len();
            let mut place: Vec<u32> = (0..n as u32).collect();
            for i in (1..n).rev() {
                place.swap(i, below(i + 1));
            }
            for (v, p) in place.iter().zip(mesh.positions.clone()) {
                mesh.positions[*v as usize] = p;
            }
            for v in mesh.triangles.iter_mut().flatten() {
                *v = place[*v as usize];
            }
            for t in (1..mesh.triangles.len()).rev() {
                mesh.triangles.swap(t, below(t + 1));
            }
            let (other, _) = Surface::new(mesh).expect("sound");
            prop_assert_eq!(other.hash(), surface.hash());
        }
    }

    /// What the order is for: the triangles round a vertex lie near each other in memory, whatever their number.
    #[test]
    fn neighbours_are_near_in_memory() {
        for n in [2962, 41_582, 200_000] {
            let (surface, _) = Surface::new(bench_patch(n)).expect("sound");
            let mut apart: Vec<u32> = (0..n as u32)
                .flat_map(|t| surface.topology().across(t).map(|u| (t, u)))
                .filter(|&(_, u)| u != RIM)
                .map(|(t, u)| t.abs_diff(u))
                .collect();
            apart.sort_unstable();
            // Rows, as made: half of the neighbours are next to each other, a third a row apart, which grows with n.
            assert!(apart[apart.len() * 3 / 4] <= 16, "{n}: {apart:?}");
        }
    }
}
