//! One element: the trilinear brick with eight corners, its dilatation averaged (B-bar; Hughes 1980), so that it does not
//! lock as ν nears 0.5.

use crate::geom::Vec3;
use crate::reference::Elastic;

/// Corners of the unit brick −1 … 1: bottom face counter-clockwise seen from above, then the top face.
pub const CORNERS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Stiffness of one element: 24 × 24, rows and columns x, y, z of each corner in turn, N/mm.
pub type Stiffness = [[f64; 24]; 24];

/// Gradients of the eight shape functions at a Gauss point, 1/mm, and the volume that the point stands for, mm³.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// ∇N of each corner.
    pub gradients: [Vec3; 8],
    /// Determinant of the Jacobian; its weight is 1.
    pub volume_mm3: f64,
}

/// The 2 × 2 × 2 Gauss points of a brick, mm; `None` where it is turned inside out or flat.
pub fn gauss_points(corners_mm: &[Vec3; 8]) -> Option<[Point; 8]> {
    let g = 1.0 / 3.0_f64.sqrt();
    let mut points = [Point {
        gradients: [Vec3::ZERO; 8],
        volume_mm3: 0.0,
    }; 8];
    for (point, at) in points.iter_mut().zip(CORNERS) {
        *point = gradients(corners_mm, at.map(|x| x * g))?;
    }
    Some(points)
}

/// Gradients at a place of the unit brick.
fn gradients(corners_mm: &[Vec3; 8], [x, y, z]: [f64; 3]) -> Option<Point> {
    let local = CORNERS.map(|[a, b, c]| {
        let (u, v, w) = (1.0 + a * x, 1.0 + b * y, 1.0 + c * z);
        Vec3::new(a * v * w, b * u * w, c * u * v) / 8.0
    });
    // Columns of the Jacobian: dX/dξ, dX/dη, dX/dζ.
    let mut columns = [Vec3::ZERO; 3];
    for (n, at) in local.iter().zip(corners_mm) {
        for (column, d) in columns.iter_mut().zip(n.to_array()) {
            *column += *at * d;
        }
    }
    let [a, b, c] = columns;
    let volume_mm3 = a.dot(b.cross(c));
    if !(volume_mm3 > 0.0 && volume_mm3.is_finite()) {
        return None;
    }
    let inverse = [b.cross(c), c.cross(a), a.cross(b)].map(|row| row / volume_mm3);
    let gradients = local.map(|n| inverse[0] * n.x + inverse[1] * n.y + inverse[2] * n.z);
    Some(Point {
        gradients,
        volume_mm3,
    })
}

/// Mean gradients over a brick: what its mean dilatation is made of.
pub fn mean_gradients(points: &[Point; 8]) -> ([Vec3; 8], f64) {
    let volume: f64 = points.iter().map(|p| p.volume_mm3).sum();
    let mut mean = [Vec3::ZERO; 8];
    for p in points {
        for (sum, g) in mean.iter_mut().zip(p.gradients) {
            *sum += g * (p.volume_mm3 / volume);
        }
    }
    (mean, volume)
}

/// Stiffness of a brick of `material`; `None` where it is turned inside out or flat, or the material is incompressible.
///
/// Energy = ∫ G dev ε : dev ε + K/2 (mean dilatation)² over the brick.
pub fn stiffness(corners_mm: &[Vec3; 8], material: Elastic) -> Option<Stiffness> {
    let g = material.shear_n_per_mm2();
    let bulk = material.bulk_n_per_mm2();
    if !bulk.is_finite() {
        return None;
    }
    let points = gauss_points(corners_mm)?;
    let (mean, volume) = mean_gradients(&points);
    let mut k = [[0.0; 24]; 24];
    for a in 0..8 {
        for b in 0..8 {
            let mut block = [[0.0; 3]; 3];
            for p in &points {
                let (ga, gb) = (p.gradients[a].to_array(), p.gradients[b].to_array());
                let dot = p.gradients[a].dot(p.gradients[b]);
                for (i, row) in block.iter_mut().enumerate() {
                    for (j, value) in row.iter_mut().enumerate() {
                        let same = if i == j { dot } else { 0.0 };
                        *value +=
                            p.volume_mm3 * g * (same + ga[j] * gb[i] - 2.0 / 3.0 * ga[i] * gb[j]);
                    }
                }
            }
            let (ma, mb) = (mean[a].to_array(), mean[b].to_array());
            for i in 0..3 {
                for j in 0..3 {
                    k[3 * a + i][3 * b + j] = block[i][j] + volume * bulk * ma[i] * mb[j];
                }
            }
        }
    }
    Some(k)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brick() -> [Vec3; 8] {
        let mut corners = CORNERS.map(|c| Vec3::from(c) * 2.0);
        // Out of square, as under a curved skin.
        corners[6] += Vec3::new(0.3, -0.2, 0.5);
        corners[0] += Vec3::new(-0.1, 0.2, 0.1);
        corners
    }

    fn force(k: &Stiffness, u: &[Vec3; 8]) -> [Vec3; 8] {
        let u: Vec<f64> = u.iter().flat_map(|u| u.to_array()).collect();
        let mut f = [Vec3::ZERO; 8];
        for (a, f) in f.iter_mut().enumerate() {
            let row = |i: usize| k[3 * a + i].iter().zip(&u).map(|(k, u)| k * u).sum::<f64>();
            *f = Vec3::new(row(0), row(1), row(2));
        }
        f
    }

    #[test]
    fn it_is_symmetric_and_rigid_motions_cost_nothing() {
        let corners = brick();
        let k = stiffness(&corners, Elastic::MUSCLE).unwrap();
        for (i, row) in k.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                assert!((value - k[j][i]).abs() < 1e-15);
            }
        }
        let turned = |w: Vec3| corners.map(|c| w.cross(c));
        let motions = [
            [Vec3::X; 8],
            [Vec3::Y; 8],
            [Vec3::Z; 8],
            turned(Vec3::X),
            turned(Vec3::Y),
            turned(Vec3::Z),
        ];
        for u in motions {
            for f in force(&k, &u) {
                assert!(f.length() < 1e-14, "{f}");
            }
        }
    }

    /// Any even strain is exact: the energy is that of the closed form times the volume.
    #[test]
    fn an_even_strain_has_its_energy() {
        let corners = brick();
        let m = Elastic::MUSCLE;
        let k = stiffness(&corners, m).unwrap();
        let strain = [
            [0.02, 0.005, -0.01],
            [0.005, -0.03, 0.004],
            [-0.01, 0.004, 0.05],
        ];
        let u = corners.map(|c| {
            let row = |i: usize| Vec3::from(strain[i]).dot(c);
            Vec3::new(row(0), row(1), row(2))
        });
        let energy: f64 = 0.5
            * force(&k, &u)
                .iter()
                .zip(&u)
                .map(|(f, u)| f.dot(*u))
                .sum::<f64>();
        let trace = strain[0][0] + strain[1][1] + strain[2][2];
        let square: f64 = strain.iter().flatten().map(|e| e * e).sum();
        let (g, bulk) = (m.shear_n_per_mm2(), m.bulk_n_per_mm2());
        let density = g * (square - trace * trace / 3.0) + 0.5 * bulk * trace * trace;
        let volume: f64 = gauss_points(&corners)
            .unwrap()
            .iter()
            .map(|p| p.volume_mm3)
            .sum();
        assert!((energy / (density * volume) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_turned_inside_out_or_flat_is_none() {
        let mut corners = brick();
        corners.swap(0, 4);
        assert!(stiffness(&corners, Elastic::MUSCLE).is_none());
        assert!(stiffness(&[Vec3::ZERO; 8], Elastic::MUSCLE).is_none());
        let incompressible = Elastic::new(25.0, 0.5).unwrap();
        assert!(stiffness(&brick(), incompressible).is_none());
    }
}
