//! Points of a slab joined by springs along the edges and face diagonals of its bricks.

use crate::geom::Vec3;
use crate::reference::Elastic;
use crate::reference::fem::hex;
use crate::reference::fem::linear::{Fixed, free};
use crate::reference::fem::mesh::{Slab, SlabError};
use std::collections::BTreeMap;

/// A spring between two points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// The two points.
    pub ends: [u32; 2],
    /// Length at rest, mm.
    pub length_mm: f64,
    /// Stiffness, N/mm.
    pub stiffness_n_per_mm: f64,
}

/// A slab as points and springs.
#[derive(Clone, Debug)]
pub struct Lattice {
    /// Points at rest, mm, numbered as the slab's nodes.
    pub rest_mm: Vec<Vec3>,
    /// 1 where a point is free to move along an axis, 0 where it is held.
    pub free: Vec<Vec3>,
    /// Mass of every point, kg.
    pub mass_kg: Vec<f64>,
    /// The springs.
    pub springs: Vec<Spring>,
}

/// Pairs of corners of a brick: its edges along x, y, z, then the diagonals of its faces across x, y, z.
const CLASSES: [[[usize; 2]; 4]; 6] = [
    [[0, 1], [3, 2], [4, 5], [7, 6]],
    [[0, 3], [1, 2], [4, 7], [5, 6]],
    [[0, 4], [1, 5], [2, 6], [3, 7]],
    [[0, 7], [3, 4], [1, 6], [2, 5]],
    [[0, 5], [1, 4], [3, 6], [2, 7]],
    [[0, 2], [1, 3], [4, 6], [5, 7]],
];

/// Density of soft tissue, kg/mm³.
const DENSITY_KG_PER_MM3: f64 = 1.05e-6;

impl Lattice {
    /// The lattice of a slab of `material`, its bone held and its `sides` as stated.
    ///
    /// Central springs can only make ν = 1/4. They are fitted to a material of that ratio whose plane-strain modulus is that
    /// of `material`, so that both are equally hard to dent.
    ///
    /// # Errors
    /// A folded brick.
    pub fn new(slab: &Slab, material: Elastic, sides: [Fixed; 4]) -> Result<Self, SlabError> {
        let nu = 0.25;
        let e_n_per_mm2 = material.plane_strain_n_per_mm2() * (1.0 - nu * nu);
        // λ = G at ν = 1/4.
        let shear = e_n_per_mm2 / (2.0 * (1.0 + nu));
        let rest_mm = slab.nodes_mm().to_vec();
        let mut mass_kg = vec![0.0; rest_mm.len()];
        let mut between: BTreeMap<[u32; 2], f64> = BTreeMap::new();
        for (i, brick) in slab.bricks().enumerate() {
            let corners = brick.map(|n| rest_mm[n]);
            let points = hex::gauss_points(&corners).ok_or_else(|| slab.folded(i))?;
            let volume: f64 = points.iter().map(|p| p.volume_mm3).sum();
            for node in brick {
                mass_kg[node] += volume / 8.0 * DENSITY_KG_PER_MM3;
            }
            let stiffness = fit(&corners, volume, shear);
            for (class, k) in CLASSES.iter().zip(stiffness) {
                for ends in class {
                    let mut ends = ends.map(|c| brick[c] as u32);
                    ends.sort_unstable();
                    *between.entry(ends).or_default() += k;
                }
            }
        }
        let springs = between
            .into_iter()
            .filter(|(_, k)| *k > 0.0)
            .map(|(ends, stiffness_n_per_mm)| {
                let [a, b] = ends.map(|n| rest_mm[n as usize]);
                Spring {
                    ends,
                    length_mm: a.distance(b),
                    stiffness_n_per_mm,
                }
            })
            .collect();
        let free = (0..rest_mm.len())
            .map(|node| {
                Vec3::from(free(slab, node, sides).map(|free| if free { 1.0 } else { 0.0 }))
            })
            .collect();
        Ok(Self {
            rest_mm,
            free,
            mass_kg,
            springs,
        })
    }

    /// Force of the springs on every point, N, held ones included.
    pub fn forces_n(&self, at_mm: &[Vec3], out_n: &mut Vec<Vec3>) {
        out_n.clear();
        out_n.resize(at_mm.len(), Vec3::ZERO);
        for spring in &self.springs {
            let [a, b] = spring.ends.map(|n| n as usize);
            let along = at_mm[b] - at_mm[a];
            let length = along.length();
            if length > 0.0 {
                let pull =
                    along * (spring.stiffness_n_per_mm * (length - spring.length_mm) / length);
                out_n[a] += pull;
                out_n[b] -= pull;
            }
        }
    }

    /// Energy of the springs, N mm.
    pub fn energy_n_mm(&self, at_mm: &[Vec3]) -> f64 {
        let of = |s: &Spring| {
            let [a, b] = s.ends.map(|n| at_mm[n as usize]);
            let over = a.distance(b) - s.length_mm;
            0.5 * s.stiffness_n_per_mm * over * over
        };
        self.springs.iter().map(of).sum()
    }
}

/// Stiffness per class of springs that comes nearest, in the least squares of the elasticity tensor, to λ = G = `shear`;
/// none of them negative.
fn fit(corners: &[Vec3; 8], volume: f64, shear: f64) -> [f64; 6] {
    let tensors = CLASSES.map(|class| {
        let mut sum = [[0.0; 6]; 6];
        for [a, b] in class {
            let along = corners[b] - corners[a];
            let n = mandel(along);
            let per_length_sq = along.length_squared() * volume;
            for (row, x) in sum.iter_mut().zip(n) {
                for (value, y) in row.iter_mut().zip(n) {
                    *value += x * y / per_length_sq;
                }
            }
        }
        sum
    });
    let mut target = [[0.0; 6]; 6];
    for (i, row) in target.iter_mut().enumerate() {
        for (j, value) in row.iter_mut().enumerate() {
            let volumetric = if i < 3 && j < 3 { shear } else { 0.0 };
            *value = volumetric + if i == j { 2.0 * shear } else { 0.0 };
        }
    }
    let dot = |a: &[[f64; 6]; 6], b: &[[f64; 6]; 6]| -> f64 {
        a.iter()
            .flatten()
            .zip(b.iter().flatten())
            .map(|(x, y)| x * y)
            .sum()
    };
    let normal: [[f64; 6]; 6] =
        std::array::from_fn(|i| std::array::from_fn(|j| dot(&tensors[i], &tensors[j])));
    let right: [f64; 6] = std::array::from_fn(|i| dot(&tensors[i], &target));
    // Coordinate descent with a floor at 0: convex, six unknowns.
    let mut k = [0.0; 6];
    for _ in 0..400 {
        for i in 0..6 {
            let rest: f64 = (0..6)
                .filter(|j| *j != i)
                .map(|j| normal[i][j] * k[j])
                .sum();
            k[i] = ((right[i] - rest) / normal[i][i]).max(0.0);
        }
    }
    k
}

/// v ⊗ v as a vector of six whose dot products are those of the tensors.
fn mandel(v: Vec3) -> [f64; 6] {
    let r = std::f64::consts::SQRT_2;
    [
        v.x * v.x,
        v.y * v.y,
        v.z * v.z,
        r * v.y * v.z,
        r * v.x * v.z,
        r * v.x * v.y,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slab(edge: f64, n: usize) -> Slab {
        let xs: Vec<f64> = (0..=n).map(|i| i as f64 * edge).collect();
        let depths: Vec<f64> = (0..=n).map(|i| i as f64 / n as f64).collect();
        Slab::flat(&xs, &xs, &depths, n as f64 * edge).unwrap()
    }

    /// Cubes have a closed form: edges and face diagonals equally stiff, k = 2 E a / 5 (ν = 1/4) for a whole one.
    #[test]
    fn springs_of_cubes_are_those_of_the_closed_form() {
        let material = Elastic::MUSCLE;
        let lattice = Lattice::new(&slab(2.0, 4), material, [Fixed::Held; 4]).unwrap();
        let e = material.plane_strain_n_per_mm2() * (1.0 - 1.0 / 16.0);
        let k = 2.0 * e * 2.0 / 5.0;
        // An edge amid four bricks, and a diagonal between two.
        let stiffest = |long: bool| {
            let of = lattice
                .springs
                .iter()
                .filter(|s| (s.length_mm > 2.1) == long);
            of.map(|s| s.stiffness_n_per_mm).fold(0.0, f64::max)
        };
        assert!(
            (stiffest(false) / k - 1.0).abs() < 1e-9,
            "{} {k}",
            stiffest(false)
        );
        assert!(
            (stiffest(true) / k - 1.0).abs() < 1e-9,
            "{} {k}",
            stiffest(true)
        );
    }

    /// An even small strain has the energy of the isotropic body with ν = 1/4.
    #[test]
    fn an_even_strain_costs_what_it_does_in_the_material() {
        let material = Elastic::MUSCLE;
        let lattice = Lattice::new(&slab(2.0, 3), material, [Fixed::Held; 4]).unwrap();
        let shear = material.plane_strain_n_per_mm2() * (1.0 - 1.0 / 16.0) / 2.5;
        let strain =
            [[2.0, 0.5, -1.0], [0.5, -3.0, 0.4], [-1.0, 0.4, 5.0]].map(|row| row.map(|e| e * 1e-6));
        let at: Vec<Vec3> = lattice
            .rest_mm
            .iter()
            .map(|p| *p + Vec3::from(strain.map(|row| Vec3::from(row).dot(*p))))
            .collect();
        let trace = strain[0][0] + strain[1][1] + strain[2][2];
        let square: f64 = strain.iter().flatten().map(|e| e * e).sum();
        let energy = (0.5 * shear * trace * trace + shear * square) * 216.0;
        assert!((lattice.energy_n_mm(&at) / energy - 1.0).abs() < 1e-5);
    }

    #[test]
    fn mass_is_that_of_the_tissue_and_springs_at_rest_do_not_pull() {
        let lattice = Lattice::new(&slab(2.0, 3), Elastic::MUSCLE, [Fixed::Held; 4]).unwrap();
        let mass: f64 = lattice.mass_kg.iter().sum();
        assert!((mass / (216.0 * DENSITY_KG_PER_MM3) - 1.0).abs() < 1e-12);
        let mut forces = Vec::new();
        lattice.forces_n(&lattice.rest_mm, &mut forces);
        assert!(forces.iter().all(|f| f.length() < 1e-15));
        assert_eq!(lattice.energy_n_mm(&lattice.rest_mm), 0.0);
    }
}
