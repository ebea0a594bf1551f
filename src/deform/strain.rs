//! Strain of the drawn skin: how much longer the edges round a vertex are than at rest (Ji 2008, eqs. 4.19, 4.20).

use super::Displacement;
use crate::geom::Vec3;
use crate::surface::Surface;

/// A rest edge this short has no length to compare with, mm. Above it, squares and their quotients stay finite.
const NO_LENGTH_MM: f64 = 1e-100;

/// Strain of every vertex: the mean over its edges of (deformed length − rest length) / rest length.
///
/// Positive where the skin is drawn out, negative where it is pushed together, and exactly 0 where nothing near has moved.
/// An edge without length at rest is left out; a vertex without any other has strain 0. It exists only while somebody looks
/// at it: made by [`Strain::new`], kept up to date by [`Strain::update`], absent otherwise.
#[derive(Clone, Debug, Default)]
pub struct Strain {
    hash: [u8; 32],
    values: Vec<f64>,
    touched: Vec<u32>,
    seen_updates: u64,
    /// Per vertex: the pass in which it was looked at last.
    looked_at: Vec<u32>,
    pass: u32,
}

impl Strain {
    /// The strain of `surface` as deformed by `displacement`, which must have been made for it. Every vertex under strain
    /// counts as touched.
    pub fn new(surface: &Surface, displacement: &Displacement) -> Self {
        let mut strain = Self {
            hash: surface.hash(),
            values: vec![0.0; surface.positions().len()],
            looked_at: vec![0; surface.positions().len()],
            ..Self::default()
        };
        strain.begin();
        strain.renew(surface, displacement, displacement.moved());
        strain.seen_updates = displacement.updates();
        strain
    }

    /// Follows one update of `displacement`, at the cost of what that touched. Made anew where it missed one, or belongs to
    /// another surface.
    pub fn update(&mut self, surface: &Surface, displacement: &Displacement) {
        let missed = displacement.updates().wrapping_sub(self.seen_updates);
        if self.hash != surface.hash() || self.values.len() != displacement.n_vertices() {
            *self = Self::new(surface, displacement);
        } else if missed == 0 {
            self.touched.clear();
        } else {
            self.begin();
            if missed == 1 {
                self.renew(surface, displacement, displacement.touched());
            } else {
                // What was under strain before may lie anywhere.
                self.renew(surface, displacement, 0..self.values.len() as u32);
            }
        }
        self.seen_updates = displacement.updates();
    }

    /// Strain of every vertex, without unit.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The vertices whose strain changed in the last update, in an order that is the same every time.
    pub fn touched(&self) -> impl Iterator<Item = u32> + '_ {
        self.touched.iter().copied()
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        8 * self.values.capacity() + 4 * (self.touched.capacity() + self.looked_at.capacity())
    }

    fn begin(&mut self) {
        if self.pass == u32::MAX {
            self.looked_at.fill(0);
            self.pass = 0;
        }
        self.pass += 1;
        self.touched.clear();
    }

    /// Renews the strain of some vertices and of those next to them.
    fn renew(
        &mut self,
        surface: &Surface,
        displacement: &Displacement,
        vertices: impl Iterator<Item = u32>,
    ) {
        for v in vertices {
            self.look_at(surface, displacement, v);
            for &n in surface.topology().neighbours(v) {
                self.look_at(surface, displacement, n);
            }
        }
    }

    fn look_at(&mut self, surface: &Surface, displacement: &Displacement, v: u32) {
        let i = v as usize;
        if std::mem::replace(&mut self.looked_at[i], self.pass) == self.pass {
            return;
        }
        let strain = of_vertex(surface, displacement, v);
        if strain != self.values[i] {
            self.values[i] = strain;
            self.touched.push(v);
        }
    }
}

fn of_vertex(surface: &Surface, displacement: &Displacement, v: u32) -> f64 {
    let offset = displacement.offset_mm(v);
    let mut moved = offset != Vec3::ZERO;
    let (mut stretches, mut n) = (0.0, 0_u32);
    for &k in surface.topology().neighbours(v) {
        let edge = surface.positions()[k as usize] - surface.positions()[v as usize];
        let other = displacement.offset_mm(k);
        moved |= other != Vec3::ZERO;
        let rest_mm = edge.length();
        if rest_mm > NO_LENGTH_MM {
            stretches += (edge + (other - offset)).length() / rest_mm;
            n += 1;
        }
    }
    if moved && n > 0 {
        stretches / f64::from(n) - 1.0
    } else {
        0.0
    }
}
