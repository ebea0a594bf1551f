//! Pieces that awkward surfaces are made of.

use super::HalfSpace;
use crate::geom::Vec3;
use crate::surface::RawMesh;
use crate::surface::primitives::cuboid;
use std::f64::consts::TAU;

/// A height field over the given coordinates.
pub fn grid(xs: &[f64], ys: &[f64], height: impl Fn(f64, f64) -> f64) -> RawMesh {
    let mut mesh = RawMesh::default();
    for &y in ys {
        let row = xs.iter().map(|&x| Vec3::new(x, y, height(x, y)));
        mesh.positions.extend(row);
    }
    let at = |i: usize, j: usize| (j * xs.len() + i) as u32;
    for j in 1..ys.len() {
        for i in 1..xs.len() {
            let (a, b, c, d) = (at(i - 1, j - 1), at(i, j - 1), at(i, j), at(i - 1, j));
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// `n` + 1 numbers from `first` to `last`.
pub fn steps(first: f64, last: f64, n: usize) -> Vec<f64> {
    let part = |i: usize| (first * (n - i) as f64 + last * i as f64) / n as f64;
    (0..=n).map(part).collect()
}

/// Both meshes in one, not joined; validation joins vertices at one place.
pub fn together(mut one: RawMesh, other: RawMesh) -> RawMesh {
    let n = one.positions.len() as u32;
    one.positions.extend(other.positions);
    let moved = other.triangles.iter().map(|t| t.map(|v| v + n));
    one.triangles.extend(moved);
    one
}

/// The same mesh facing the other way.
pub fn turned(mut mesh: RawMesh) -> RawMesh {
    for t in &mut mesh.triangles {
        t.swap(1, 2);
    }
    mesh
}

/// A four-cornered patch, counter-clockwise seen from outside, cut into `n` × `n` cells. Where `n` is a power of two, patches
/// that share corners share the vertices of their edge bit for bit.
pub fn patch(corners: [Vec3; 4], n: u32) -> RawMesh {
    let mut mesh = RawMesh::default();
    let part = |i: u32| f64::from(i) / f64::from(n);
    for j in 0..=n {
        for i in 0..=n {
            let (u, v) = (part(i), part(j));
            let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v];
            let p = corners.iter().zip(weights).map(|(&c, w)| c * w);
            mesh.positions.push(p.sum());
        }
    }
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// The planes of a closed convex mesh.
pub fn planes(mesh: &RawMesh) -> Vec<HalfSpace> {
    let plane = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        HalfSpace::new(a, (b - a).cross(c - a))
    };
    mesh.triangles.iter().map(plane).collect()
}

/// A box, each side cut into `n` × `n` cells.
pub fn block(low: Vec3, high: Vec3, n: u32) -> RawMesh {
    let corners = cuboid(low, high).positions;
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let side = |s: [usize; 4]| patch(s.map(|i| corners[i]), n);
    sides
        .into_iter()
        .map(side)
        .fold(RawMesh::default(), together)
}

/// A band of `width_mm` round a circle of `radius_mm` about z that turns over `half_turns` times on its way round, cut
/// into `n` × 4 cells and joined at the end: with an odd number it has one side only.
pub fn twisted_band(radius_mm: f64, width_mm: f64, half_turns: u32, n: u32) -> RawMesh {
    let mut mesh = RawMesh::default();
    for i in 0..n {
        for j in 0..5 {
            let across = width_mm * (f64::from(j) / 4.0 - 0.5);
            let place = band_place(radius_mm, half_turns, TAU * f64::from(i) / f64::from(n));
            mesh.positions.push(place[0] + place[1] * across);
        }
    }
    for i in 0..n {
        for j in 0..4 {
            let (a, d) = (5 * i + j, 5 * i + j + 1);
            let [mut b, mut c] = [a + 5, d + 5];
            if i + 1 == n {
                let over = |j: u32| if half_turns % 2 == 1 { 4 - j } else { j };
                (b, c) = (over(j), over(j + 1));
            }
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// Centre, direction across and normal of a [`twisted_band`] at an angle round it; after a whole round an odd band gives the
/// opposite normal.
pub fn band_place(radius_mm: f64, half_turns: u32, angle: f64) -> [Vec3; 3] {
    let turn = angle / 2.0 * f64::from(half_turns);
    let out = Vec3::new(libm::cos(angle), libm::sin(angle), 0.0);
    let along = Vec3::new(-out.y, out.x, 0.0);
    let across = out * libm::cos(turn) + Vec3::Z * libm::sin(turn);
    [out * radius_mm, across, along.cross(across)]
}
