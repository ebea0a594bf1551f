//! Large strains: each brick's small-strain stiffness in a frame that turns with it (Müller and Gross 2004; after Felippa and
//! Haugen 2005), by Newton's method with the load in steps.

use super::hex;
use super::linear::{Fixed, SolveError, free};
use super::mesh::Slab;
use crate::geom::Vec3;
use crate::reference::Elastic;
use faer::prelude::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use glam::DMat3;

/// A slab whose bricks turn.
pub struct Corotated {
    slab: Slab,
    bricks: Vec<Brick>,
    unknowns: Vec<[Option<usize>; 3]>,
    n_unknowns: usize,
    symbolic: Option<SymbolicLlt<usize>>,
}

struct Brick {
    nodes: [usize; 8],
    stiffness: Box<hex::Stiffness>,
    /// Mean gradients: the mean deformation gradient is Σ x ⊗ ∇N.
    gradients: [Vec3; 8],
}

/// Where a Newton iteration ended.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Displacement of every node, mm.
    pub displacements_mm: Vec<Vec3>,
    /// Largest force left over on a free node, N, over the largest one applied.
    pub residual: f64,
    /// Newton iterations of all steps.
    pub iterations: usize,
}

/// Iterations allowed in a step.
const ITERATIONS: usize = 40;

impl Corotated {
    /// A slab as for [`super::Linear`].
    ///
    /// # Errors
    /// A folded brick, an incompressible material (ν = 0.5).
    pub fn new(slab: Slab, material: Elastic, sides: [Fixed; 4]) -> Result<Self, SolveError> {
        if !material.bulk_n_per_mm2().is_finite() {
            return Err(SolveError::Incompressible);
        }
        let mut n_unknowns = 0;
        let unknowns = (0..slab.nodes_mm().len())
            .map(|node| {
                free(&slab, node, sides).map(|free| {
                    free.then(|| {
                        n_unknowns += 1;
                        n_unknowns - 1
                    })
                })
            })
            .collect();
        let mut bricks = Vec::new();
        for (i, nodes) in slab.bricks().enumerate() {
            let corners = nodes.map(|n| slab.nodes_mm()[n]);
            let points = hex::gauss_points(&corners).ok_or_else(|| slab.folded(i))?;
            let stiffness = hex::stiffness(&corners, material).ok_or_else(|| slab.folded(i))?;
            bricks.push(Brick {
                nodes,
                stiffness: Box::new(stiffness),
                gradients: hex::mean_gradients(&points).0,
            });
        }
        Ok(Self {
            slab,
            bricks,
            unknowns,
            n_unknowns,
            symbolic: None,
        })
    }

    /// The slab.
    pub fn slab(&self) -> &Slab {
        &self.slab
    }

    /// Where the nodes come to rest under forces on nodes that are put on in `steps` equal parts. A step is done when the
    /// largest force left over is `tolerance` of the largest one applied; a residual above that says that it did not come to
    /// rest.
    ///
    /// # Errors
    /// A matrix that cannot be factored.
    pub fn solve(
        &mut self,
        forces_n: &[(usize, Vec3)],
        steps: usize,
        tolerance: f64,
    ) -> Result<Solution, SolveError> {
        let rest = self.slab.nodes_mm().to_vec();
        let mut at = rest.clone();
        let largest = forces_n.iter().map(|(_, f)| f.length()).fold(0.0, f64::max);
        let (mut iterations, mut residual) = (0, 0.0);
        for step in 1..=steps.max(1) {
            let share = step as f64 / steps.max(1) as f64;
            let mut left = self.state(&rest, &at, forces_n, share);
            residual = largest_of(&left.0) / largest.max(f64::MIN_POSITIVE);
            for _ in 0..ITERATIONS {
                if residual <= tolerance || !residual.is_finite() {
                    break;
                }
                iterations += 1;
                let change = self.newton(&left.0, &left.1)?;
                // The bricks' turning is left out of the matrix: a step too far is halved until it leaves less force over.
                let mut length = 1.0;
                loop {
                    let tried = self.moved(&at, &change, length);
                    let state = self.state(&rest, &tried, forces_n, share);
                    let over = largest_of(&state.0) / largest.max(f64::MIN_POSITIVE);
                    if over < residual || length < 0.02 {
                        (at, left, residual) = (tried, state, over);
                        break;
                    }
                    length *= 0.5;
                }
            }
        }
        Ok(Solution {
            displacements_mm: at.iter().zip(&rest).map(|(a, r)| *a - *r).collect(),
            residual,
            iterations,
        })
    }

    /// The force left over on every unknown, and the stiffness of the turned bricks.
    fn state(
        &self,
        rest: &[Vec3],
        at: &[Vec3],
        forces_n: &[(usize, Vec3)],
        share: f64,
    ) -> (Mat<f64>, Vec<Triplet<usize, usize, f64>>) {
        let mut left = Mat::zeros(self.n_unknowns, 1);
        let mut entries = Vec::new();
        for (node, force) in forces_n {
            let places = self.unknowns.get(*node).copied().unwrap_or_default();
            for (place, f) in places.into_iter().zip(force.to_array()) {
                if let Some(place) = place {
                    left[(place, 0)] += f * share;
                }
            }
        }
        for brick in &self.bricks {
            let mut deformation = DMat3::ZERO;
            for (node, g) in brick.nodes.iter().zip(brick.gradients) {
                let x = at[*node];
                deformation += DMat3::from_cols(x * g.x, x * g.y, x * g.z);
            }
            let turn = rotation(deformation);
            let back = turn.transpose();
            let mut strained = [0.0; 24];
            for (i, node) in brick.nodes.iter().enumerate() {
                let u = back * at[*node] - rest[*node];
                strained[3 * i..3 * i + 3].copy_from_slice(&u.to_array());
            }
            let row = |i: usize| -> f64 {
                brick.stiffness[i]
                    .iter()
                    .zip(&strained)
                    .map(|(k, u)| k * u)
                    .sum()
            };
            for (a, node) in brick.nodes.iter().enumerate() {
                let force = turn * Vec3::new(row(3 * a), row(3 * a + 1), row(3 * a + 2));
                for (place, f) in self.unknowns[*node].into_iter().zip(force.to_array()) {
                    if let Some(place) = place {
                        left[(place, 0)] -= f;
                    }
                }
                for (b, other) in brick.nodes.iter().enumerate() {
                    let k = &brick.stiffness;
                    let column = |j: usize| {
                        Vec3::new(
                            k[3 * a][3 * b + j],
                            k[3 * a + 1][3 * b + j],
                            k[3 * a + 2][3 * b + j],
                        )
                    };
                    let block = turn * DMat3::from_cols(column(0), column(1), column(2)) * back;
                    for (i, row) in self.unknowns[*node].into_iter().enumerate() {
                        for (j, column) in self.unknowns[*other].into_iter().enumerate() {
                            if let (Some(row), Some(column)) = (row, column)
                                && row >= column
                            {
                                entries.push(Triplet::new(row, column, block.col(j)[i]));
                            }
                        }
                    }
                }
            }
        }
        (left, entries)
    }

    fn moved(&self, at: &[Vec3], change: &Mat<f64>, length: f64) -> Vec<Vec3> {
        let of = |place: Option<usize>| place.map_or(0.0, |p| change[(p, 0)] * length);
        at.iter()
            .zip(&self.unknowns)
            .map(|(at, [x, y, z])| *at + Vec3::new(of(*x), of(*y), of(*z)))
            .collect()
    }

    fn newton(
        &mut self,
        left: &Mat<f64>,
        entries: &[Triplet<usize, usize, f64>],
    ) -> Result<Mat<f64>, SolveError> {
        let n = self.n_unknowns;
        let failed = |why: String| SolveError::Factor { n, why };
        let matrix = SparseColMat::try_new_from_triplets(n, n, entries)
            .map_err(|e| failed(format!("{e:?}")))?;
        let symbolic = match self.symbolic.take() {
            Some(symbolic) => symbolic,
            None => SymbolicLlt::try_new(matrix.symbolic(), Side::Lower)
                .map_err(|e| failed(format!("{e:?}")))?,
        };
        self.symbolic = Some(symbolic.clone());
        let factor = Llt::try_new_with_symbolic(symbolic, matrix.as_ref(), Side::Lower)
            .map_err(|e| failed(format!("{e:?}")))?;
        Ok(factor.solve(left))
    }
}

fn largest_of(forces: &Mat<f64>) -> f64 {
    (0..forces.nrows())
        .map(|i| forces[(i, 0)].abs())
        .fold(0.0, f64::max)
}

/// The rotation nearest to a deformation gradient, by Newton's iteration for the polar decomposition (Higham 1986). One
/// that is turned inside out or flat counts as not turned.
fn rotation(f: DMat3) -> DMat3 {
    if f.determinant().is_nan() || f.determinant() <= 1.0e-9 {
        return DMat3::IDENTITY;
    }
    let mut r = f;
    for _ in 0..60 {
        let next = (r + r.inverse().transpose()) * 0.5;
        let step = (next - r)
            .to_cols_array()
            .iter()
            .map(|x| x.abs())
            .fold(0.0, f64::max);
        r = next;
        if step < 1.0e-15 {
            break;
        }
    }
    r
}

#[cfg(test)]
mod tests {
    use super::super::linear::skin_forces;
    use super::super::{Linear, graded};
    use super::*;

    fn flat() -> Slab {
        let xs = graded(6, 40.0, 4.0);
        Slab::flat(&xs, &xs, &[0.0, 0.25, 0.5, 1.0], 15.0).unwrap()
    }

    const QUARTER: [Fixed; 4] = [Fixed::Mirror, Fixed::Held, Fixed::Mirror, Fixed::Held];

    /// A quarter of a finger pressing with four times `force_n`.
    fn press(slab: &Slab, force_n: f64) -> Vec<(usize, Vec3)> {
        let s = 5.0_f64;
        let middle = 4.0 * force_n / (2.0 * std::f64::consts::PI * s * s);
        skin_forces(slab, |at| {
            Vec3::NEG_Z * middle * (-at.length_squared() / (2.0 * s * s)).exp()
        })
    }

    #[test]
    fn small_forces_are_answered_as_by_small_strains() {
        let mut large = Corotated::new(flat(), Elastic::MUSCLE, QUARTER).unwrap();
        let small = Linear::new(flat(), Elastic::MUSCLE, QUARTER).unwrap();
        let load = press(small.slab(), 1e-4);
        let (l, s) = (
            large.solve(&load, 1, 1.0e-9).unwrap(),
            small.displacements_mm(&load),
        );
        assert!(l.residual <= 1.0e-9);
        let most = s.iter().map(|u| u.length()).fold(0.0, f64::max);
        for (l, s) in l.displacements_mm.iter().zip(&s) {
            assert!((*l - *s).length() < 1e-3 * most);
        }
    }

    #[test]
    fn a_deep_press_comes_to_rest() {
        let mut slab = Corotated::new(flat(), Elastic::MUSCLE, QUARTER).unwrap();
        let load = press(slab.slab(), 0.4);
        let solution = slab.solve(&load, 4, 1.0e-9).unwrap();
        assert!(solution.residual <= 1.0e-9, "{}", solution.residual);
        let depth = -solution.displacements_mm[0].z;
        assert!(depth > 2.0 && depth < 15.0, "{depth}");
    }

    /// Turning the whole of a brick strains nothing: where small strains invent forces, these do not.
    #[test]
    fn a_turned_brick_is_not_strained() {
        let slab = Slab::flat(&[0.0, 1.0], &[0.0, 2.0], &[0.0, 1.0], 3.0).unwrap();
        let rest = slab.nodes_mm().to_vec();
        let body = Corotated::new(slab, Elastic::MUSCLE, [Fixed::Mirror; 4]).unwrap();
        let turn = DMat3::from_axis_angle(
            Vec3::new(1.0, 2.0, -0.5) / Vec3::new(1.0, 2.0, -0.5).length(),
            1.3,
        );
        let at: Vec<Vec3> = rest.iter().map(|p| turn * *p + Vec3::X).collect();
        let (left, _) = body.state(&rest, &at, &[], 1.0);
        for i in 0..body.n_unknowns {
            assert!(left[(i, 0)].abs() < 1e-13);
        }
    }

    #[test]
    fn rotations_come_out_of_stretched_and_turned_frames() {
        let turn = DMat3::from_axis_angle(Vec3::Z, 0.8) * DMat3::from_axis_angle(Vec3::X, -0.4);
        let stretch = DMat3::from_diagonal(Vec3::new(0.3, 1.4, 2.0));
        let found = rotation(turn * stretch);
        assert!(
            (found - turn)
                .to_cols_array()
                .iter()
                .all(|x| x.abs() < 1e-13)
        );
        assert_eq!(
            rotation(DMat3::from_diagonal(Vec3::new(1.0, 1.0, -1.0))),
            DMat3::IDENTITY
        );
    }
}
