//! Strain of the drawn skin: how much longer the edges round a vertex are than at rest (Ji 2008, eqs. 4.19, 4.20).

use super::Displacement;
use super::blocks::{BLOCK, Block, Row, bits, unless, vertex};
use super::marks::Marks;
use super::nearby::{Nearby, Places, Ring};
use super::pairs::Pair;
use super::patches::{CORNERS, Patch, Patches};
use crate::geom::Vec3;
use crate::surface::Surface;
use std::sync::Arc;

/// A rest edge this short has no length to compare with, mm. Above it, squares and their quotients stay finite.
const NO_LENGTH_MM: f64 = 1e-100;

/// Strain of every vertex: the mean over its edges of (deformed length − rest length) / rest length.
///
/// Positive where the skin is drawn out, negative where it is pushed together, and exactly 0 where nothing near has moved.
/// An edge without length at rest is left out; a vertex without any other has strain 0. It exists only while somebody looks
/// at it: made by [`Strain::new`], kept up to date by [`Strain::update`], absent otherwise.
#[derive(Clone, Debug, Default)]
pub struct Strain {
    patches: Arc<Patches>,
    weights: Vec<Weights>,
    /// Those of ring corners beyond the sixth.
    longer: Vec<f64>,
    /// Per patch: vertices without a ring, or without an edge.
    odd: Vec<u64>,
    values: Vec<f64>,
    marks: Marks,
    /// Per patch that changed: the vertices whose strain did.
    touched: Vec<(u32, u64)>,
    seen_updates: u64,
    /// The model has brought this along in its last update, and nobody has asked for that one yet.
    fresh: bool,
    nearby: Nearby,
}

/// What makes a share of the mean of a squared length: 1 / (rest length · number of edges)², per mm². 0 for what is no edge.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Weights([Row; CORNERS]);

impl Strain {
    /// The strain of `surface` as deformed by `displacement`, which must have been made for it. Every vertex under strain
    /// counts as touched.
    pub fn new(surface: &Surface, displacement: &Displacement) -> Self {
        let known = displacement.patches.iter().find(|p| p.are_of(surface));
        let mut strain = Self {
            patches: (known.cloned()).unwrap_or_else(|| Arc::new(Patches::new(surface))),
            values: vec![0.0; surface.positions().len()],
            ..Self::default()
        };
        strain.weigh(surface);
        strain.follow_all(surface, displacement);
        strain
    }

    /// Follows one update of `displacement`, at the cost of what that changed, or at none where the model has brought it
    /// along ([`Model::update_strained`](super::Model::update_strained)). Where it missed one, all vertices are looked
    /// at; where it belongs to another surface, it is made anew.
    pub fn update(&mut self, surface: &Surface, displacement: &Displacement) {
        let same = self.patches.are_of(surface) && self.values.len() == displacement.n_vertices();
        let fresh = std::mem::take(&mut self.fresh);
        match displacement.updates().wrapping_sub(self.seen_updates) {
            _ if !same => *self = Self::new(surface, displacement),
            0 if fresh => {}
            0 => self.touched.clear(),
            1 => {
                self.marks.begin(&self.patches);
                for change in &displacement.changes {
                    self.marks.note(change.block, change.displaced);
                }
                self.renew(surface, displacement);
            }
            _ => self.follow_all(surface, displacement),
        }
        self.seen_updates = displacement.updates();
    }

    /// Strain of every vertex, without unit.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The vertices whose strain changed in the last update, ascending.
    pub fn touched(&self) -> impl Iterator<Item = u32> + '_ {
        let words = self.touched.iter();
        words.flat_map(|&(block, word)| bits(word).map(move |i| vertex(block, i)))
    }

    /// Memory held, bytes, without what it shares with the model.
    pub fn bytes(&self) -> usize {
        size_of::<Weights>() * self.weights.capacity()
            + 8 * (self.values.capacity() + self.longer.capacity() + self.odd.capacity())
            + size_of::<(u32, u64)>() * self.touched.capacity()
            + self.marks.bytes()
    }

    fn follow_all(&mut self, surface: &Surface, displacement: &Displacement) {
        self.marks.begin(&self.patches);
        for p in 0..self.patches.len() as u32 {
            self.marks.note(p, self.patches.all(p));
        }
        self.renew(surface, displacement);
        self.seen_updates = displacement.updates();
    }

    /// Takes the lengths of all edges at rest.
    fn weigh(&mut self, surface: &Surface) {
        let patches = Arc::clone(&self.patches);
        let at_rest = vec![Block::ZERO; patches.len()];
        for p in 0..patches.len() as u32 {
            let patch = patches.patch(p);
            self.nearby.gather(&patches, p, &at_rest);
            let mut weights = Weights([[0.0; BLOCK]; CORNERS]);
            let mut odd = patch.without_ring;
            for i in bits(patch.all & !patch.without_ring) {
                let n = n_edges(surface, vertex(p, i));
                odd |= u64::from(n == 0) << i;
                let per_edges = 1.0 / n.max(1) as f64;
                let here = self.nearby.get(i as u8);
                for (k, ring) in patch.rings.iter().enumerate() {
                    // A shorter ring repeats its last corner.
                    if k == 0 || ring[i] != patch.rings[k - 1][i] {
                        weights.0[k][i] = weight(self.nearby.get(ring[i]) - here, per_edges);
                    }
                }
            }
            self.odd.push(odd);
            self.weights.push(weights);
            for l in patch.longer {
                let per_edges = 1.0 / n_edges(surface, vertex(p, l.vertex.into())).max(1) as f64;
                let here = self.nearby.get(l.vertex);
                let [c, d] = l.next.map(|k| weight(self.nearby.get(k) - here, per_edges));
                let d = if l.next[0] == l.next[1] { 0.0 } else { d };
                self.longer.extend([c, d]);
            }
        }
        self.weights.shrink_to_fit();
    }

    fn renew(&mut self, surface: &Surface, displacement: &Displacement) {
        let patches = Arc::clone(&self.patches);
        self.marks.spread(&patches);
        self.touched.clear();
        let mut at = std::mem::take(&mut self.nearby);
        for i in 0..self.marks.marked().len() {
            let p = self.marks.marked()[i];
            let stale = self.marks.stale(&patches, p);
            let bent = self.marks.bent(&patches, p, stale, &displacement.moved);
            let wanted = stale & bent;
            let mut strains = [0.0; BLOCK];
            let patch = patches.patch(p);
            if wanted != 0 {
                at.gather(&patches, p, &displacement.offsets_mm);
            }
            for i in (0..BLOCK).step_by(2) {
                if wanted >> i & 3 != 0 {
                    let here = at.pair(i as u8, i as u8 + 1);
                    let ring = Ring::of(&at, &patch, i);
                    of_ring(here, &ring, self.weights(p), i).put(&mut strains, i);
                }
            }
            let words = [stale, wanted];
            self.put(surface, &at, p, &patch, words, displacement, &mut strains);
        }
        self.nearby = at;
    }

    /// Whether the pass that follows `displacement` now may bring this along, patch by patch: it is of the same patches
    /// and has seen all updates before. Then it counts as having seen this one.
    pub(super) fn begins(&mut self, patches: &Arc<Patches>, displacement: &Displacement) -> bool {
        let follows = self.patches.are_those(patches)
            && displacement.updates().wrapping_sub(self.seen_updates) == 1;
        if follows {
            // Its own were made before the model's; from now on they are shared.
            self.patches = Arc::clone(patches);
            self.seen_updates = displacement.updates();
            self.fresh = true;
            self.touched.clear();
        }
        follows
    }

    pub(super) fn weights(&self, p: u32) -> &Weights {
        &self.weights[p as usize]
    }

    /// Takes over the `stale` values of a patch: 0 where they are not `wanted`, the others from `strains`, by the first six
    /// edges of their ring.
    #[allow(clippy::too_many_arguments, reason = "one pass for normals and strain")]
    pub(super) fn put(
        &mut self,
        surface: &Surface,
        at: &Nearby,
        p: u32,
        patch: &Patch,
        [stale, wanted]: [u64; 2],
        out: &Displacement,
        strains: &mut Row,
    ) {
        let weights = self.longer[2 * patch.longer_from..].chunks_exact(2);
        for (l, weights) in patch.longer.iter().zip(weights) {
            let here = at.get(l.vertex);
            for (&corner, weight) in l.next.iter().zip(weights) {
                let edge = at.get(corner) - here;
                strains[l.vertex as usize] += (edge.length_squared() * weight).sqrt();
            }
        }
        let odd = self.odd[p as usize];
        for i in bits(wanted & odd) {
            strains[i] = of_vertex(surface, out, vertex(p, i));
        }
        let from = p as usize * BLOCK;
        let to = (from + BLOCK).min(self.values.len());
        let held = &mut self.values[from..to];
        let turned = if let (u64::MAX, Ok(held)) = (wanted, <&mut Row>::try_from(&mut *held)) {
            let (mut same, mut n_same) = ([0_u64; BLOCK], 0);
            for i in 0..BLOCK {
                same[i] = u64::from(held[i] == strains[i]);
                n_same += same[i];
            }
            *held = *strains;
            unless(&same, n_same)
        } else {
            let mut turned = 0;
            for i in bits(stale) {
                let strain = if wanted >> i & 1 == 1 {
                    strains[i]
                } else {
                    0.0
                };
                turned |= u64::from(held[i] != strain) << i;
                held[i] = strain;
            }
            turned
        };
        if turned != 0 {
            self.touched.push((p, turned));
        }
    }
}

/// The strains of two vertices from the first six edges of each.
#[inline(always)]
pub(super) fn of_ring(here: Places, ring: &Ring, weights: &Weights, i: usize) -> Pair {
    let [a, b, c, d, e, f] = &ring.0;
    let [ra, rb, rc, rd, re, rf] = &weights.0;
    let share =
        |corner: &Places, row: &Row| (corner.minus(here).length_sq() * Pair::of(row, i)).sqrt();
    let first = share(a, ra) + share(b, rb) + share(c, rc);
    let second = share(d, rd) + share(e, re) + share(f, rf);
    first + second - Pair([1.0; 2])
}

/// 1 / (length · number of edges)²; 0 for an edge without length.
fn weight(edge_mm: Vec3, per_edges: f64) -> f64 {
    let length_mm = edge_mm.length();
    if length_mm > NO_LENGTH_MM {
        let weight = per_edges / length_mm;
        weight * weight
    } else {
        0.0
    }
}

/// Number of edges of a vertex that have a length at rest.
fn n_edges(surface: &Surface, v: u32) -> usize {
    let at = |v: u32| surface.positions()[v as usize];
    let edges = surface.topology().neighbours(v).iter();
    edges
        .filter(|&&n| (at(n) - at(v)).length() > NO_LENGTH_MM)
        .count()
}

/// The strain of a vertex without a ring, or without an edge.
fn of_vertex(surface: &Surface, out: &Displacement, v: u32) -> f64 {
    let at = |v: u32| surface.positions()[v as usize];
    let (mut sum, mut n) = (0.0, 0_u32);
    for &k in surface.topology().neighbours(v) {
        let rest_mm = (at(k) - at(v)).length();
        if rest_mm > NO_LENGTH_MM {
            sum += (out.position(surface, k) - out.position(surface, v)).length() / rest_mm;
            n += 1;
        }
    }
    if n > 0 { sum / f64::from(n) - 1.0 } else { 0.0 }
}
