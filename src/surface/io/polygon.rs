//! Faces with any number of corners become triangles.

use crate::geom::{Vec3, unit_or};

/// Corners up to which ears are cut; larger polygons become a fan, for the search grows with the cube of the corners.
const EARS: usize = 32;

/// Appends the triangles of the face with the given corners, at least three.
///
/// A quadrilateral is cut along its shorter diagonal of those inside it, a larger polygon by cutting ears (Meisters 1975)
/// in its mean plane. Corners that name no vertex are passed on as they are, for validation to name.
pub(super) fn append(positions: &[Vec3], corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    if let [a, b, c] = *corners {
        triangles.push([a, b, c]);
        return;
    }
    let places: Option<Vec<Vec3>> = (corners.iter())
        .map(|&v| positions.get(v as usize).copied())
        .collect();
    match places {
        Some(p) if corners.len() == 4 => {
            let [along_02, along_13] = [[0, 1, 2, 3], [1, 2, 3, 0]].map(|[a, b, c, d]| {
                let normals = [
                    (p[b] - p[a]).cross(p[c] - p[a]),
                    (p[c] - p[a]).cross(p[d] - p[a]),
                ];
                (
                    normals[0].dot(normals[1]) <= 0.0,
                    p[a].distance_squared(p[c]),
                )
            });
            let first = usize::from(along_13 < along_02);
            let [a, b, c, d] = [0, 1, 2, 3].map(|i| corners[(first + i) % 4]);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        Some(places) if corners.len() <= EARS => cut_ears(&places, corners, triangles),
        _ => triangles.extend((corners.windows(2).skip(1)).map(|w| [corners[0], w[0], w[1]])),
    }
}

fn cut_ears(places: &[Vec3], corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    // Newell's normal: the sum of the area vectors seen from any point.
    let n = places.len();
    let newell = (0..n).map(|i| (places[i] - places[0]).cross(places[(i + 1) % n] - places[0]));
    let normal = unit_or(newell.sum(), Vec3::Z);
    let left = |a: usize, b: usize, c: usize| {
        (places[b] - places[a])
            .cross(places[c] - places[a])
            .dot(normal)
    };
    let mut rest: Vec<usize> = (0..n).collect();
    while rest.len() > 3 {
        let m = rest.len();
        let ear = (0..m).find(|&i| {
            let [a, b, c] = [rest[(i + m - 1) % m], rest[i], rest[(i + 1) % m]];
            left(a, b, c) > 0.0
                && (rest.iter().filter(|q| ![a, b, c].contains(q)))
                    .all(|&q| left(a, b, q) < 0.0 || left(b, c, q) < 0.0 || left(c, a, q) < 0.0)
        });
        // No ear: the polygon crosses itself or is flat; any corner will do.
        let i = ear.unwrap_or(0);
        let corner = |k: usize| corners[rest[k % m]];
        triangles.push([corner(i + m - 1), corner(i), corner(i + 1)]);
        rest.remove(i);
    }
    triangles.push([corners[rest[0]], corners[rest[1]], corners[rest[2]]]);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn areas(outline: &[[f64; 2]]) -> (Vec<f64>, f64) {
        let positions: Vec<Vec3> = outline.iter().map(|p| Vec3::new(p[0], p[1], 0.0)).collect();
        let corners: Vec<u32> = (0..outline.len() as u32).collect();
        let mut triangles = Vec::new();
        append(&positions, &corners, &mut triangles);
        assert_eq!(triangles.len(), outline.len() - 2);
        let area = |c: &[u32; 3]| {
            let [a, b, c] = c.map(|v| positions[v as usize]);
            (b - a).cross(c - a).z / 2.0
        };
        let shoelace = (0..outline.len())
            .map(|i| (outline[i], outline[(i + 1) % outline.len()]))
            .map(|(p, q)| (p[0] * q[1] - q[0] * p[1]) / 2.0)
            .sum();
        (triangles.iter().map(area).collect(), shoelace)
    }

    #[test]
    fn concave_polygons_are_covered_exactly_once() {
        let arrow = vec![[0.0, 0.0], [4.0, -2.0], [1.0, 0.0], [4.0, 2.0]];
        let comb = vec![
            [0.0, 0.0],
            [9.0, 0.0],
            [9.0, 5.0],
            [7.0, 1.0],
            [6.0, 5.0],
            [5.0, 1.0],
            [3.0, 6.0],
            [2.0, 1.0],
            [0.0, 5.0],
        ];
        for turn in 0..9 {
            for mut outline in [arrow.clone(), comb.clone()] {
                let n = outline.len();
                outline.rotate_left(turn % n);
                let (areas, expected) = areas(&outline);
                assert!(areas.iter().all(|&a| a > 0.0), "{outline:?}: {areas:?}");
                assert!((areas.iter().sum::<f64>() - expected).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_quadrilateral_is_cut_along_its_shorter_diagonal() {
        let positions =
            [[0.0, 0.0], [5.0, 1.0], [6.0, 6.0], [1.0, 5.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        let mut triangles = Vec::new();
        append(&positions, &[0, 1, 2, 3], &mut triangles);
        assert_eq!(triangles, [[1, 2, 3], [1, 3, 0]]);
    }

    #[test]
    fn corners_without_vertex_and_huge_or_crossed_polygons_still_give_triangles() {
        let mut triangles = Vec::new();
        append(&[Vec3::ZERO], &[0, 7, 8, 9, 10], &mut triangles);
        assert_eq!(triangles, [[0, 7, 8], [0, 8, 9], [0, 9, 10]]);
        let flat = vec![Vec3::ONE; 100];
        let corners: Vec<u32> = (0..100).collect();
        for n in [4, 5, 32, 33, 100] {
            triangles.clear();
            append(&flat, &corners[..n], &mut triangles);
            assert_eq!(triangles.len(), n - 2);
        }
    }
}
