//! Simple shapes and the benchmark surface: for tests, benches and the lab.

use super::RawMesh;
use crate::geom::Vec3;
use std::collections::HashMap;
use std::f64::consts::TAU;

/// Height of the benchmark surface at (`x`, `y`), all mm: a back-like saddle with a furrow and 0.5 mm bumps,
/// for x in −175…175 and y in −200…200.
pub fn bench_height(x: f64, y: f64) -> f64 {
    let sq = |v: f64| v * v;
    115.0 * (1.0 - 0.9 * sq(x / 175.0)) * (1.0 - 0.1 * sq(y / 200.0))
        + 6.0 * libm::sin(TAU * y / 400.0)
        - 6.0 * libm::exp(-sq(x / 12.0))
        + 0.5 * libm::sin(TAU * x / 17.0) * libm::sin(TAU * y / 23.0)
}

/// The benchmark surface cut into `triangles` triangles (at least 2), row by row over a regular grid.
pub fn bench_patch(triangles: usize) -> RawMesh {
    let n = triangles.max(2);
    let nx = ((n as f64 / 2.0 * 350.0 / 400.0).sqrt() as usize).max(1);
    let ny = n.div_ceil(2 * nx);
    height_field([-175.0, 175.0], [-200.0, 200.0], [nx, ny], n, bench_height)
}

/// Device position at time `t_s` of the benchmark path: `offset_mm` above (below when negative) the surface, at most
/// 0.282 m/s.
pub fn bench_path(t_s: f64, offset_mm: f64) -> Vec3 {
    let x = 110.0 * libm::sin(TAU * 0.29 * t_s);
    let y = 150.0 * libm::sin(TAU * 0.19 * t_s + 0.7);
    Vec3::new(x, y, bench_height(x, y) + offset_mm)
}

/// A height field over a regular grid of `cells`, two triangles a cell, of which the first `triangles` are kept.
/// Vertex (i, j) has index j (cells\[0\] + 1) + i.
pub fn height_field(
    x_mm: [f64; 2],
    y_mm: [f64; 2],
    cells: [usize; 2],
    triangles: usize,
    height: impl Fn(f64, f64) -> f64,
) -> RawMesh {
    let [nx, ny] = cells;
    let mut mesh = RawMesh::default();
    mesh.positions.reserve((nx + 1) * (ny + 1));
    for j in 0..=ny {
        let y = y_mm[0] + (y_mm[1] - y_mm[0]) * j as f64 / ny as f64;
        for i in 0..=nx {
            let x = x_mm[0] + (x_mm[1] - x_mm[0]) * i as f64 / nx as f64;
            mesh.positions.push(Vec3::new(x, y, height(x, y)));
        }
    }
    let at = |i: usize, j: usize| (j * (nx + 1) + i) as u32;
    mesh.triangles.reserve(2 * nx * ny);
    for j in 0..ny {
        for i in 0..nx {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh.triangles.truncate(triangles);
    mesh
}

/// One small triangle inside each of `cells` cubes of 1 mm from the origin on, none touching a border, save that the first
/// and the last reach into the corners of the whole: trees that halve its box become complete.
pub fn one_per_cell(cells: [u32; 3]) -> RawMesh {
    let [nx, ny, nz] = cells.map(|n| n.max(1));
    let all = nx * ny * nz;
    let mut mesh = RawMesh::default();
    for i in 0..all {
        let low = Vec3::new(
            f64::from(i % nx),
            f64::from(i / nx % ny),
            f64::from(i / (nx * ny)),
        );
        let mut corners = [[0.3, 0.3, 0.4], [0.6, 0.3, 0.5], [0.4, 0.7, 0.6]]
            .map(|within| low + Vec3::from_array(within));
        if i == 0 {
            corners[0] = Vec3::ZERO;
        }
        if i + 1 == all {
            corners[2] = low + Vec3::ONE;
        }
        mesh.positions.extend(corners);
        mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    mesh
}

/// A closed box with outward triangles, edges along the axes, two triangles a side.
pub fn cuboid(min: Vec3, max: Vec3) -> RawMesh {
    let positions = (0..8)
        .map(|i| {
            let pick = |bit: usize, lo: f64, hi: f64| if i >> bit & 1 == 1 { hi } else { lo };
            Vec3::new(
                pick(0, min.x, max.x),
                pick(1, min.y, max.y),
                pick(2, min.z, max.z),
            )
        })
        .collect();
    let quads: [[u32; 4]; 6] = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles = quads
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    RawMesh {
        positions,
        triangles,
    }
}

/// A closed sphere about the origin: an icosahedron whose triangles are cut in four `levels` times (20 · 4^levels).
pub fn icosphere(radius_mm: f64, levels: u32) -> RawMesh {
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut positions: Vec<Vec3> = [
        [-1.0, g, 0.0],
        [1.0, g, 0.0],
        [-1.0, -g, 0.0],
        [1.0, -g, 0.0],
        [0.0, -1.0, g],
        [0.0, 1.0, g],
        [0.0, -1.0, -g],
        [0.0, 1.0, -g],
        [g, 0.0, -1.0],
        [g, 0.0, 1.0],
        [-g, 0.0, -1.0],
        [-g, 0.0, 1.0],
    ]
    .map(Vec3::from_array)
    .to_vec();
    #[rustfmt::skip]
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11],
        [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
        [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9],
        [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1],
    ];
    for _ in 0..levels {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]) / 2.0);
                (positions.len() - 1) as u32
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    for p in &mut positions {
        *p *= radius_mm / p.length();
    }
    RawMesh {
        positions,
        triangles,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(mesh: &RawMesh) -> f64 {
        let p = |v: u32| mesh.positions[v as usize];
        let six_volumes: f64 = mesh
            .triangles
            .iter()
            .map(|&[a, b, c]| p(a).dot(p(b).cross(p(c))))
            .sum();
        six_volumes / 6.0
    }

    #[test]
    fn closed_shapes_enclose_their_volume_with_outward_triangles() {
        let box_volume = volume(&cuboid(Vec3::new(1.0, 2.0, 3.0), Vec3::new(3.0, 5.0, 7.0)));
        assert!((box_volume - 24.0).abs() < 1e-12);
        let sphere = icosphere(10.0, 4);
        assert_eq!(sphere.triangles.len(), 20 * 256);
        assert_eq!(sphere.positions.len(), 2 + 10 * 256);
        let round = 4.0 / 3.0 * std::f64::consts::PI * 1000.0;
        assert!((volume(&sphere) / round - 1.0).abs() < 0.01);
    }

    #[test]
    fn the_bench_patch_has_the_triangles_asked_for_and_faces_up() {
        for n in [2962, 20_389, 41_582] {
            let mesh = bench_patch(n);
            assert_eq!(mesh.triangles.len(), n);
            let p = |v: u32| mesh.positions[v as usize];
            assert!(
                mesh.triangles
                    .iter()
                    .all(|&[a, b, c]| (p(b) - p(a)).cross(p(c) - p(a)).z > 0.0)
            );
        }
        assert_eq!(bench_patch(2962).positions.len(), 36 * 44);
    }
}
