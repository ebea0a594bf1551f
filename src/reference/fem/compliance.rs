//! The slab condensed to its skin: everything below is solved once, and a press costs only the nodes it loads.

use super::linear::Linear;
use crate::geom::Vec3;

/// Normal displacement of every skin node per normal force on every skin node, mm/N: a symmetric matrix, full.
#[derive(Clone, Debug)]
pub struct Compliance {
    n: usize,
    /// Column after column.
    columns_mm_per_n: Vec<f64>,
}

/// Skin nodes allowed: a matrix of half a gigabyte.
pub const MOST_SKIN_NODES: usize = 8_000;

/// Columns solved at a time.
const BLOCK: usize = 64;

impl Compliance {
    /// Condenses `slab` to its skin, whose outward unit `normals` are given per skin node. `progress` is told a fraction
    /// 0 … 1 and answers whether to go on.
    ///
    /// `None` when told to stop, for more than [`MOST_SKIN_NODES`], or for a number of normals that is not that of the skin.
    pub fn of(
        slab: &Linear,
        normals: &[Vec3],
        progress: &mut dyn FnMut(f64) -> bool,
    ) -> Option<Self> {
        let n = slab.slab().skin_mm().len();
        if n > MOST_SKIN_NODES || normals.len() != n {
            return None;
        }
        let nodes: Vec<usize> = (0..n).collect();
        let mut columns_mm_per_n = Vec::with_capacity(n * n);
        for block in nodes.chunks(BLOCK) {
            if !progress(columns_mm_per_n.len() as f64 / (n * n) as f64) {
                return None;
            }
            for column in slab.columns_mm_per_n(normals, block) {
                columns_mm_per_n.extend(column);
            }
        }
        Some(Self {
            n,
            columns_mm_per_n,
        })
    }

    /// Adds up how far the skin nodes move along their normals under normal `forces_n` on some of them, mm, into `out_mm`,
    /// which is filled anew. Nodes that there are not are left out.
    pub fn displacements_mm(&self, forces_n: &[(usize, f64)], out_mm: &mut Vec<f64>) {
        out_mm.clear();
        out_mm.resize(self.n, 0.0);
        for (node, force_n) in forces_n {
            let column = self
                .columns_mm_per_n
                .get(node * self.n..(node + 1) * self.n);
            for (out, c) in out_mm.iter_mut().zip(column.unwrap_or_default()) {
                *out += c * force_n;
            }
        }
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        8 * self.columns_mm_per_n.capacity()
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
        let condensed = Compliance::of(&slab, &normals, &mut |_| true).unwrap();
        let loads = [(60, -0.4), (61, -0.7), (49, 0.2), (100_000, 3.0)];
        let mut skin = Vec::new();
        condensed.displacements_mm(&loads, &mut skin);
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
        let condensed = Compliance::of(&slab, &vec![Vec3::Z; n], &mut |_| true).unwrap();
        let at = |i: usize, j: usize| condensed.columns_mm_per_n[i * n + j];
        for i in 0..n {
            assert!(at(i, i) >= 0.0);
            for j in 0..i {
                assert!((at(i, j) - at(j, i)).abs() < 1e-13);
            }
        }
        assert!(Compliance::of(&slab, &vec![Vec3::Z; n], &mut |_| false).is_none());
    }
}
