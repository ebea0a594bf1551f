//! Where a lattice comes to rest: Newton's method on its energy, each spring's matrix kept positive.

use super::lattice::Lattice;
use crate::geom::Vec3;
use crate::reference::fem::linear::SolveError;
use faer::prelude::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};

/// Where a search for rest ended.
#[derive(Clone, Debug)]
pub struct Rest {
    /// Displacement of every point, mm.
    pub displacements_mm: Vec<Vec3>,
    /// Largest force left over on a free point, over the largest applied.
    pub residual: f64,
    /// Newton iterations.
    pub iterations: usize,
}

/// The linear systems of a lattice: (`k_scale` K + M / dt²) per unknown.
pub(super) struct Systems {
    unknowns: Vec<[Option<usize>; 3]>,
    n: usize,
    symbolic: Option<SymbolicLlt<usize>>,
}

impl Systems {
    pub(super) fn new(lattice: &Lattice) -> Self {
        let mut n = 0;
        let unknowns = lattice
            .free
            .iter()
            .map(|free| {
                free.to_array().map(|f| {
                    (f > 0.0).then(|| {
                        n += 1;
                        n - 1
                    })
                })
            })
            .collect();
        Self {
            unknowns,
            n,
            symbolic: None,
        }
    }

    /// Solves (K + `inertia` M) x = `right`, K that of the springs at `at_mm`, `inertia` in 1/s² (mass in kg: the unit of
    /// force is N, of length mm, so M counts 1e-3).
    pub(super) fn solve(
        &mut self,
        lattice: &Lattice,
        at_mm: &[Vec3],
        inertia: f64,
        right: &[Vec3],
    ) -> Result<Vec<Vec3>, SolveError> {
        let n = self.n;
        let failed = |why: String| SolveError::Factor { n, why };
        let mut entries = Vec::with_capacity(lattice.springs.len() * 24 + n);
        for (places, mass) in self.unknowns.iter().zip(&lattice.mass_kg) {
            for place in places.iter().flatten() {
                entries.push(Triplet::new(*place, *place, mass * 1.0e-3 * inertia));
            }
        }
        for s in &lattice.springs {
            let [a, b] = s.ends.map(|n| n as usize);
            let along = at_mm[b] - at_mm[a];
            let length = along.length();
            // A spring of no length has no direction. It keeps its places in the matrix, whose pattern is factored once.
            let d = if length > 0.0 {
                along / length
            } else {
                Vec3::ZERO
            };
            // A shortened spring would push its ends aside: left out, so that the matrix stays positive.
            let across = if length > 0.0 {
                (1.0 - s.length_mm / length).max(0.0)
            } else {
                0.0
            };
            let block = |i: usize, j: usize| {
                let same = if i == j { across } else { 0.0 };
                s.stiffness_n_per_mm * (same + (1.0 - across) * d[i] * d[j])
            };
            for (p, q, sign) in [(a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)] {
                for i in 0..3 {
                    for j in 0..3 {
                        if let (Some(row), Some(column)) =
                            (self.unknowns[p][i], self.unknowns[q][j])
                            && row >= column
                        {
                            entries.push(Triplet::new(row, column, sign * block(i, j)));
                        }
                    }
                }
            }
        }
        let matrix = SparseColMat::try_new_from_triplets(n, n, &entries)
            .map_err(|e| failed(format!("{e:?}")))?;
        let symbolic = match &self.symbolic {
            Some(symbolic) => symbolic.clone(),
            None => SymbolicLlt::try_new(matrix.symbolic(), Side::Lower)
                .map_err(|e| failed(format!("{e:?}")))?,
        };
        self.symbolic = Some(symbolic.clone());
        let factor = Llt::try_new_with_symbolic(symbolic, matrix.as_ref(), Side::Lower)
            .map_err(|e| failed(format!("{e:?}")))?;
        let mut vector = Mat::zeros(n, 1);
        for (places, r) in self.unknowns.iter().zip(right) {
            for (place, r) in places.iter().zip(r.to_array()) {
                if let Some(place) = place {
                    vector[(*place, 0)] = r;
                }
            }
        }
        factor.solve_in_place(&mut vector);
        let of = |place: Option<usize>| place.map_or(0.0, |p| vector[(p, 0)]);
        Ok(self
            .unknowns
            .iter()
            .map(|[x, y, z]| Vec3::new(of(*x), of(*y), of(*z)))
            .collect())
    }
}

/// Where `lattice` comes to rest under forces on points.
///
/// # Errors
/// A matrix that cannot be factored.
pub fn rest(lattice: &Lattice, forces_n: &[(usize, Vec3)]) -> Result<Rest, SolveError> {
    let mut systems = Systems::new(lattice);
    let mut at = lattice.rest_mm.clone();
    let largest = forces_n
        .iter()
        .map(|(_, f)| f.length())
        .fold(f64::MIN_POSITIVE, f64::max);
    let energy = |at: &[Vec3]| {
        let work: f64 = forces_n
            .iter()
            .filter(|(n, _)| *n < at.len())
            .map(|(n, f)| f.dot(at[*n] - lattice.rest_mm[*n]))
            .sum();
        lattice.energy_n_mm(at) - work
    };
    let mut springs = Vec::new();
    let (mut residual, mut iterations) = (0.0, 0);
    for _ in 0..200 {
        let left = left_over(lattice, &at, forces_n, &mut springs);
        residual = left
            .iter()
            .map(|f| f.abs().max_element())
            .fold(0.0, f64::max)
            / largest;
        if residual <= 1.0e-9 || !residual.is_finite() {
            break;
        }
        iterations += 1;
        let change = systems.solve(lattice, &at, 0.0, &left)?;
        let (before, mut length) = (energy(&at), 1.0);
        loop {
            let tried: Vec<Vec3> = at
                .iter()
                .zip(&change)
                .map(|(a, c)| *a + *c * length)
                .collect();
            // Near rest the energy no longer tells: rounding.
            if energy(&tried) <= before + 1.0e-13 * before.abs() || length < 1.0e-3 {
                at = tried;
                break;
            }
            length *= 0.5;
        }
    }
    let displacements_mm = at
        .iter()
        .zip(&lattice.rest_mm)
        .map(|(a, r)| *a - *r)
        .collect();
    Ok(Rest {
        displacements_mm,
        residual,
        iterations,
    })
}

/// The force left over on every free point, N.
pub(super) fn left_over(
    lattice: &Lattice,
    at_mm: &[Vec3],
    forces_n: &[(usize, Vec3)],
    out_n: &mut Vec<Vec3>,
) -> Vec<Vec3> {
    lattice.forces_n(at_mm, out_n);
    for (node, force) in forces_n {
        if let Some(sum) = out_n.get_mut(*node) {
            *sum += *force;
        }
    }
    out_n
        .iter()
        .zip(&lattice.free)
        .map(|(f, free)| *f * *free)
        .collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::reference::Elastic;
    use crate::reference::fem::linear::{Fixed, skin_forces};
    use crate::reference::fem::{Linear, Slab};
    use std::f64::consts::PI;

    pub fn quarter(n: usize) -> Slab {
        let h = 15.0;
        let edge = h / n as f64;
        let xs: Vec<f64> = (0..=3 * n).map(|i| i as f64 * edge).collect();
        let depths: Vec<f64> = (0..=n).map(|i| i as f64 / n as f64).collect();
        Slab::flat(&xs, &xs, &depths, h).unwrap()
    }

    pub const SIDES: [Fixed; 4] = [Fixed::Mirror, Fixed::Held, Fixed::Mirror, Fixed::Held];

    pub fn press(slab: &Slab, force_n: f64) -> Vec<(usize, Vec3)> {
        let s = 5.0;
        let pressure = |at: Vec3| {
            Vec3::NEG_Z
                * (force_n / (2.0 * PI * s * s) * libm::exp(-at.length_squared() / (2.0 * s * s)))
        };
        skin_forces(slab, pressure)
    }

    /// The pattern of the matrix is looked at once; a spring that has lost its length must not change it. It panicked.
    #[test]
    fn a_spring_of_no_length_keeps_its_place_in_the_matrix() {
        let slab = quarter(2);
        let mut lattice = Lattice::new(&slab, Elastic::MUSCLE, SIDES).unwrap();
        let ends = lattice.springs[0].ends.map(|n| n as usize);
        lattice.rest_mm[ends[0]] = lattice.rest_mm[ends[1]];
        let found = rest(&lattice, &press(&slab, 0.1)).unwrap();
        assert!(found.displacements_mm.iter().all(|u| u.is_finite()));
    }

    /// A lattice of cubes is the body with ν = 1/4: under a small force both are dented alike, the more so the finer.
    #[test]
    fn springs_and_bricks_agree_where_both_can() {
        let material = Elastic::new(25.0, 0.25).unwrap();
        let apart = |n: usize| {
            let slab = quarter(n);
            let load = press(&slab, 0.01);
            let lattice = Lattice::new(&slab, material, SIDES).unwrap();
            let springs = rest(&lattice, &load).unwrap();
            assert!(springs.residual <= 1e-9);
            let bricks = Linear::new(slab, material, SIDES)
                .unwrap()
                .displacements_mm(&load);
            (springs.displacements_mm[0].z / bricks[0].z - 1.0).abs()
        };
        let (coarse, fine) = (apart(4), apart(8));
        assert!(fine < 0.03 && fine < 0.5 * coarse, "{coarse} and {fine}");
    }

    #[test]
    fn a_hard_press_comes_to_rest_too() {
        let slab = quarter(5);
        let lattice = Lattice::new(&slab, Elastic::MUSCLE, SIDES).unwrap();
        let found = rest(&lattice, &press(&slab, 2.0)).unwrap();
        assert!(found.residual <= 1e-9, "{}", found.residual);
        let depth = -found.displacements_mm[0].z;
        assert!(depth > 1.0 && depth < 15.0, "{depth}");
    }
}
