//! Small strains: the stiffness matrix is assembled and factored once, then any load is one solve.

use super::hex;
use super::mesh::{Slab, SlabError};
use crate::geom::Vec3;
use crate::reference::Elastic;
use faer::prelude::Solve;
use faer::sparse::linalg::solvers::Llt;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};

/// What holds the sides of the slab: at the first and last column and the first and last row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fixed {
    /// Nothing moves there: the slab goes on, at rest.
    Held,
    /// A plane of symmetry: points stay in it.
    Mirror,
}

/// A factored slab.
pub struct Linear {
    slab: Slab,
    material: Elastic,
    /// Per node and direction: its place among the unknowns.
    unknowns: Vec<[Option<usize>; 3]>,
    n_unknowns: usize,
    factor: Llt<usize, f64>,
}

/// Why a slab has no solution.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// The mesh.
    #[error(transparent)]
    Slab(#[from] SlabError),
    /// The material.
    #[error(
        "finite elements need a Poisson's ratio below 0.5; 0.4999 is as good as incompressible"
    )]
    Incompressible,
    /// The matrix.
    #[error("the stiffness matrix of {n} unknowns cannot be factored: {why}")]
    Factor {
        /// Its size.
        n: usize,
        /// What the solver says.
        why: String,
    },
}

impl Linear {
    /// Assembles and factors `slab` of `material`, its bone at rest and its `sides` held.
    ///
    /// # Errors
    /// A folded brick, an incompressible material (ν = 0.5), or too little memory for the factor.
    pub fn new(slab: Slab, material: Elastic, sides: [Fixed; 4]) -> Result<Self, SolveError> {
        if !material.bulk_n_per_mm2().is_finite() {
            return Err(SolveError::Incompressible);
        }
        let mut n_unknowns = 0;
        let unknowns: Vec<[Option<usize>; 3]> = (0..slab.nodes_mm().len())
            .map(|node| {
                free(&slab, node, sides).map(|free| {
                    free.then(|| {
                        n_unknowns += 1;
                        n_unknowns - 1
                    })
                })
            })
            .collect();
        let mut entries = Vec::new();
        for (i, brick) in slab.bricks().enumerate() {
            let corners = brick.map(|n| slab.nodes_mm()[n]);
            let k = hex::stiffness(&corners, material).ok_or_else(|| slab.folded(i))?;
            push(&mut entries, &unknowns, &brick, &k);
        }
        let failed = |why: String| SolveError::Factor { n: n_unknowns, why };
        let matrix = SparseColMat::try_new_from_triplets(n_unknowns, n_unknowns, &entries)
            .map_err(|e| failed(format!("{e:?}")))?;
        drop(entries);
        let factor = matrix
            .sp_cholesky(Side::Lower)
            .map_err(|e| failed(format!("{e:?}")))?;
        Ok(Self {
            slab,
            material,
            unknowns,
            n_unknowns,
            factor,
        })
    }

    /// The slab.
    pub fn slab(&self) -> &Slab {
        &self.slab
    }

    /// Its material.
    pub fn material(&self) -> Elastic {
        self.material
    }

    /// Unknowns of the system.
    pub fn n_unknowns(&self) -> usize {
        self.n_unknowns
    }

    /// Appends, for each of `loads`, forces on nodes, N, how far the nodes of the skin move along their `normals`, mm.
    pub(super) fn append_columns_mm(
        &self,
        normals: &[Vec3],
        loads: &[Vec<(usize, Vec3)>],
        columns_mm: &mut Vec<f64>,
    ) {
        let mut moved = Mat::zeros(self.n_unknowns, loads.len());
        for (column, load) in loads.iter().enumerate() {
            for (node, force) in load {
                for (place, f) in self.unknowns[*node].into_iter().zip(force.to_array()) {
                    if let Some(place) = place {
                        moved[(place, column)] += f;
                    }
                }
            }
        }
        self.factor.solve_in_place(&mut moved);
        for column in 0..loads.len() {
            columns_mm.extend(normals.iter().enumerate().map(|(node, normal)| {
                let along = self.unknowns[node].into_iter().zip(normal.to_array());
                along
                    .map(|(place, n)| place.map_or(0.0, |p| moved[(p, column)] * n))
                    .sum::<f64>()
            }));
        }
    }

    /// How far every node moves under forces on nodes, mm; forces on what is held are taken by what holds it.
    pub fn displacements_mm(&self, forces_n: &[(usize, Vec3)]) -> Vec<Vec3> {
        let mut load = Mat::zeros(self.n_unknowns, 1);
        for (node, force) in forces_n {
            let places = self.unknowns.get(*node).copied().unwrap_or_default();
            for (place, f) in places.into_iter().zip(force.to_array()) {
                if let Some(place) = place {
                    load[(place, 0)] += f;
                }
            }
        }
        let moved = self.factor.solve(&load);
        let of = |place: Option<usize>| place.map_or(0.0, |p| moved[(p, 0)]);
        self.unknowns
            .iter()
            .map(|[x, y, z]| Vec3::new(of(*x), of(*y), of(*z)))
            .collect()
    }

    /// Forces on the skin's nodes from a traction, N/mm² (2 × 2 Gauss points on every face).
    pub fn forces_n(&self, traction: impl Fn(Vec3) -> Vec3) -> Vec<(usize, Vec3)> {
        skin_forces(&self.slab, traction)
    }
}

/// Which directions of a node are free.
pub(in crate::reference) fn free(slab: &Slab, node: usize, sides: [Fixed; 4]) -> [bool; 3] {
    if slab.on_bone(node) {
        return [false; 3];
    }
    let mut free = [true; 3];
    for (side, on) in slab.on_sides(node).into_iter().enumerate() {
        match (on, sides[side]) {
            (false, _) => {}
            (true, Fixed::Held) => free = [false; 3],
            (true, Fixed::Mirror) => free[side / 2] = false,
        }
    }
    free
}

/// Appends the lower triangle of an element's matrix.
fn push(
    entries: &mut Vec<Triplet<usize, usize, f64>>,
    unknowns: &[[Option<usize>; 3]],
    brick: &[usize; 8],
    k: &hex::Stiffness,
) {
    let places: [Option<usize>; 24] = std::array::from_fn(|i| unknowns[brick[i / 3]][i % 3]);
    for (row, k) in places.iter().zip(k) {
        for (column, value) in places.iter().zip(k) {
            if let (Some(row), Some(column)) = (row, column)
                && row >= column
            {
                entries.push(Triplet::new(*row, *column, *value));
            }
        }
    }
}

/// Forces on the nodes of the skin that do the same work as a traction, N/mm², on its faces.
pub fn skin_forces(slab: &Slab, traction: impl Fn(Vec3) -> Vec3) -> Vec<(usize, Vec3)> {
    let g = 1.0 / 3.0_f64.sqrt();
    let mut forces = vec![Vec3::ZERO; slab.skin_mm().len()];
    for face in slab.faces() {
        let corners = face.map(|n| slab.skin_mm()[n]);
        for (x, y) in [(-g, -g), (g, -g), (g, g), (-g, g)] {
            let signs = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
            let shapes = signs.map(|(a, b)| (1.0 + a * x) * (1.0 + b * y) / 4.0);
            let mut at = Vec3::ZERO;
            let (mut along_x, mut along_y) = (Vec3::ZERO, Vec3::ZERO);
            for ((corner, n), (a, b)) in corners.iter().zip(shapes).zip(signs) {
                at += *corner * n;
                along_x += *corner * (a * (1.0 + b * y) / 4.0);
                along_y += *corner * (b * (1.0 + a * x) / 4.0);
            }
            let force = traction(at) * along_x.cross(along_y).length();
            for (node, n) in face.iter().zip(shapes) {
                forces[*node] += force * n;
            }
        }
    }
    forces
        .into_iter()
        .enumerate()
        .filter(|(_, f)| *f != Vec3::ZERO)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::graded;
    use super::*;
    use crate::reference::{Dent as _, layer};
    use std::f64::consts::PI;

    const DEVIATION_MM: f64 = 7.0;
    const QUARTER: [Fixed; 4] = [Fixed::Mirror, Fixed::Held, Fixed::Mirror, Fixed::Held];

    /// It said that the slab was folded.
    #[test]
    fn an_incompressible_material_is_refused_by_its_name() {
        let material = Elastic::new(25.0, 0.5).unwrap();
        let slab = Slab::flat(&[0.0, 1.0], &[0.0, 1.0], &[0.0, 1.0], 1.0).unwrap();
        let refused = Linear::new(slab, material, [Fixed::Mirror; 4]).err();
        assert_eq!(refused, Some(SolveError::Incompressible));
    }

    /// Patch test: a block pulled evenly on its skin stretches evenly, whatever its bricks look like.
    #[test]
    fn an_even_pull_makes_an_even_stretch() {
        let material = Elastic::new(25.0, 0.0).unwrap();
        // ν = 0: nothing is drawn in, so the bonded bone does not disturb.
        let uneven = [0.0, 0.3, 0.4, 1.0];
        let xs = [0.0, 1.0, 4.0, 5.0];
        let slab = Slab::flat(&xs, &xs, &uneven, 10.0).unwrap();
        let block = Linear::new(slab, material, [Fixed::Mirror; 4]).unwrap();
        let pull = block.forces_n(|_| Vec3::Z * 0.001);
        let total: Vec3 = pull.iter().map(|(_, f)| *f).sum();
        assert!((total - Vec3::Z * 0.025).length() < 1e-15);
        for (at, u) in block
            .slab()
            .nodes_mm()
            .iter()
            .zip(block.displacements_mm(&pull))
        {
            let stretched = Vec3::Z * (0.001 / 0.025 * (at.z + 10.0));
            assert!((u - stretched).length() < 1e-12, "{at}: {u}");
        }
    }

    fn dent_mm(n: usize, nu: f64) -> f64 {
        let (s, h) = (DEVIATION_MM, 20.0);
        let material = Elastic::new(25.0, nu).unwrap();
        let xs = graded(2 * n, 120.0, 10.0);
        let depths = graded(n, 1.0, 2.0);
        let slab = Slab::flat(&xs, &xs, &depths, h).unwrap();
        let slab = Linear::new(slab, material, QUARTER).unwrap();
        let pressure = |at: Vec3| {
            Vec3::NEG_Z * (3.0 / (2.0 * PI * s * s) * (-at.length_squared() / (2.0 * s * s)).exp())
        };
        let load = slab.forces_n(pressure);
        let total: f64 = load.iter().map(|(_, f)| -f.z).sum();
        // Scaled to the force of the closed form, so that the order is the element's, not the quadrature's.
        -slab.displacements_mm(&load)[0].z * (0.75 / total)
    }

    /// Second order, against the closed form of the layer.
    #[test]
    fn finer_bricks_converge_to_the_bonded_layer_at_second_order() {
        for nu in [0.45, 0.499] {
            let layer = layer::Bonded::new(Elastic::new(25.0, nu).unwrap(), DEVIATION_MM, 20.0);
            let exact = 3.0 / layer.force_n(1.0);
            let errors = [6, 9, 12].map(|n| (dent_mm(n, nu) - exact).abs() / exact);
            let order = |i: usize, finer: f64| (errors[i] / errors[i + 1]).ln() / finer.ln();
            for order in [order(0, 9.0 / 6.0), order(1, 12.0 / 9.0)] {
                assert!(
                    (order - 2.0).abs() < 0.1,
                    "nu {nu}: {errors:?}, order {order}"
                );
            }
        }
    }
}
