//! The slab condensed to its skin: everything below is solved once, and a press costs only the nodes it loads.

use super::linear::Linear;
use crate::geom::Vec3;

/// How far every skin node moves along its normal per unit of each of some loads, mm: full, a column per load.
#[derive(Clone, Debug)]
pub struct Compliance {
    /// Nodes of the skin.
    n: usize,
    /// Column after column.
    columns_mm: Vec<f64>,
}

/// Skin nodes allowed: a matrix of half a gigabyte.
pub const MOST_SKIN_NODES: usize = 8_000;

/// Columns solved at a time.
const BLOCK: usize = 64;

impl Compliance {
    /// Condenses `slab` to its skin, whose outward unit `normals` are given per skin node: one column for 1 N along the
    /// normal of each node, so that the matrix is symmetric. `progress` is told a fraction 0 … 1 and answers whether to go on.
    ///
    /// `None` when told to stop, for more than [`MOST_SKIN_NODES`], or for a number of normals that is not that of the skin.
    pub fn of_nodes(
        slab: &Linear,
        normals: &[Vec3],
        progress: &mut dyn FnMut(f64) -> bool,
    ) -> Option<Self> {
        let at = |node: usize| vec![(node, normals[node])];
        Self::of(slab, normals, &at, progress)
    }

    /// The same for one `load` at each skin node: forces on nodes, N.
    pub fn of(
        slab: &Linear,
        normals: &[Vec3],
        load: &dyn Fn(usize) -> Vec<(usize, Vec3)>,
        progress: &mut dyn FnMut(f64) -> bool,
    ) -> Option<Self> {
        let n = slab.slab().skin_mm().len();
        if n > MOST_SKIN_NODES || normals.len() != n {
            return None;
        }
        let nodes: Vec<usize> = (0..n).collect();
        let mut columns_mm = Vec::with_capacity(n * n);
        for block in nodes.chunks(BLOCK) {
            if !progress(columns_mm.len() as f64 / (n * n) as f64) {
                return None;
            }
            let loads: Vec<_> = block.iter().map(|node| load(*node)).collect();
            slab.append_columns_mm(normals, &loads, &mut columns_mm);
        }
        Some(Self { n, columns_mm })
    }

    /// Adds up how far the skin nodes move along their normals under `amounts` of some loads, mm, into `out_mm`, which is
    /// filled anew. Loads that there are not are left out.
    pub fn displacements_mm(
        &self,
        amounts: impl Iterator<Item = (usize, f64)>,
        out_mm: &mut Vec<f64>,
    ) {
        out_mm.clear();
        out_mm.resize(self.n, 0.0);
        for (load, amount) in amounts {
            for (out, c) in out_mm.iter_mut().zip(self.column(load)) {
                *out += c * amount;
            }
        }
    }

    /// The same as vectors along a `normal` that all nodes share.
    pub fn displaced(
        &self,
        amounts: impl Iterator<Item = (usize, f64)>,
        normal: Vec3,
        out_mm: &mut Vec<Vec3>,
    ) {
        out_mm.clear();
        out_mm.resize(self.n, Vec3::ZERO);
        // Summed in z, turned at the end.
        for (load, amount) in amounts {
            for (out, c) in out_mm.iter_mut().zip(self.column(load)) {
                out.z += c * amount;
            }
        }
        for out in out_mm {
            *out = normal * out.z;
        }
    }

    fn column(&self, load: usize) -> &[f64] {
        let from = load.saturating_mul(self.n);
        let column = self.columns_mm.get(from..from.saturating_add(self.n));
        column.unwrap_or_default()
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        8 * self.columns_mm.capacity()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Fixed, Slab, graded};
    use super::*;
    use crate::reference::Elastic;

    fn slab() -> Linear {
        let half = graded(5, 40.0, 3.0);
        let xs: Vec<f64> = half
            .iter()
            .skip(1)
            .rev()
            .map(|x| -x)
            .chain(half.iter().copied())
            .collect();
        let skin = Slab::flat(&xs, &xs, &[0.0, 0.3, 0.6, 1.0], 15.0).unwrap();
        Linear::new(skin, Elastic::MUSCLE, [Fixed::Held; 4]).unwrap()
    }

    #[test]
    fn the_condensed_slab_answers_as_the_full_one() {
        let slab = slab();
        let n = slab.slab().skin_mm().len();
        let normals = vec![Vec3::Z; n];
        let condensed = Compliance::of_nodes(&slab, &normals, &mut |_| true).unwrap();
        let loads = [(60, -0.4), (61, -0.7), (49, 0.2), (100_000, 3.0)];
        let mut skin = Vec::new();
        condensed.displacements_mm(loads.into_iter(), &mut skin);
        let forces: Vec<(usize, Vec3)> =
            loads[..3].iter().map(|(i, f)| (*i, Vec3::Z * *f)).collect();
        let full = slab.displacements_mm(&forces);
        assert!(skin[60] < -0.5);
        for (c, f) in skin.iter().zip(&full) {
            assert!((c - f.z).abs() < 1e-12, "{c} against {f}");
        }
    }

    /// Betti 1872: what a force here does there, it does from there to here.
    #[test]
    fn it_is_symmetric_and_pushes_back_everywhere() {
        let slab = slab();
        let n = slab.slab().skin_mm().len();
        let condensed = Compliance::of_nodes(&slab, &vec![Vec3::Z; n], &mut |_| true).unwrap();
        let at = |i: usize, j: usize| condensed.columns_mm[i * n + j];
        for i in 0..n {
            assert!(at(i, i) >= 0.0);
            for j in 0..i {
                assert!((at(i, j) - at(j, i)).abs() < 1e-13);
            }
        }
        assert!(Compliance::of_nodes(&slab, &vec![Vec3::Z; n], &mut |_| false).is_none());
    }
}
