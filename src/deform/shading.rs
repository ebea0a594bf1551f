//! Normals of the deformed surface, recomputed only where a triangle changed (Ji 2008, 4.5).
//!
//! n = unit(n₀ |S₀| + S − S₀) with S and S₀ the sums of the area normals of a vertex's triangles, deformed and at rest, and n₀
//! its normal at rest. So a normal leaves the one at rest, which is weighted by angles, without a jump, and follows the area
//! normals from there on. Where no triangle of the vertex moved it is exactly n₀.
//!
//! The area normals of a fan of triangles add up to the area vector of the closed polygon round it, whatever lies in the
//! middle. A polygon falls into quadrilaterals, and the area vector of one is a single cross product, that of its diagonals:
//! two for the usual six neighbours, instead of six.

use super::Displacement;
use super::blocks::{BLOCK, Block, Row, bits, unless, vertex};
use super::displacement::Change;
use super::marks::Marks;
use super::nearby::{Nearby, Places, Ring};
use super::pairs::Pair;
use super::patches::{Patch, Patches};
use super::strain::{self, Strain, Weights};
use crate::geom::{Vec3, unit_or};
use crate::surface::Surface;
use std::sync::Arc;

/// What an update has to shade, what a surface needs for it, and scratch memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Shading {
    marks: Marks,
    /// n₀ |S₀| − S₀, mm².
    corrections: Vec<Block>,
    nearby: Nearby,
    new: New,
}

impl Shading {
    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        self.marks.bytes() + size_of::<Block>() * self.corrections.capacity()
    }

    /// Builds what is kept about a surface.
    pub fn prepare(&mut self, surface: &Surface, patches: &Patches) {
        let at_rest = vec![Block::ZERO; patches.len()];
        self.corrections = Vec::with_capacity(patches.len());
        for p in 0..patches.len() as u32 {
            self.nearby.gather(patches, p, &at_rest);
            let patch = patches.patch(p);
            let mut sums = Block::ZERO;
            add_longer(&self.nearby, &patch, &mut sums);
            for i in (0..BLOCK).step_by(2) {
                area(&Ring::of(&self.nearby, &patch, i))
                    .plus(pair_of(&sums, i))
                    .put(&mut sums, i);
            }
            for i in bits(patch.all) {
                let (sum, v) = (sums.get(i), vertex(p, i));
                sums.set(i, surface.normals()[v as usize] * sum.length() - sum);
            }
            self.corrections.push(sums);
        }
    }

    /// Forgets what was noted.
    pub fn begin(&mut self, patches: &Patches) {
        self.marks.begin(patches);
    }

    /// Notes the vertices of patch `p` whose offset changed.
    #[inline]
    pub fn note(&mut self, p: u32, displaced: u64) {
        self.marks.note(p, displaced);
    }

    /// Renews the normals of displaced vertices and those next to them, and their strain in the same pass where it has
    /// followed every update; lists in `out` what changed.
    pub fn renew(
        &mut self,
        surface: &Surface,
        patches: &Arc<Patches>,
        out: &mut Displacement,
        mut strain: Option<&mut Strain>,
    ) {
        self.marks.spread(patches);
        out.changes.clear();
        let follows = (strain.as_deref_mut()).is_some_and(|strain| strain.begins(patches, out));
        for i in 0..self.marks.marked().len() {
            let p = self.marks.marked()[i];
            let stale = self.marks.stale(patches, p);
            let displaced = self.marks.displaced(p);
            let strain = strain.as_deref_mut().filter(|_| follows);
            let turned = self.renew_patch(surface, patches, p, stale, out, strain);
            let touched = displaced | turned;
            if touched != 0 {
                out.changes.push(Change {
                    block: p,
                    displaced,
                    touched,
                });
            }
        }
        if let (Some(strain), false) = (strain, follows) {
            strain.update(surface, out);
        }
    }

    /// Renews the `stale` normals of a patch; answers with the bits of those that changed, and maybe of some displaced.
    fn renew_patch(
        &mut self,
        surface: &Surface,
        patches: &Patches,
        p: u32,
        stale: u64,
        out: &mut Displacement,
        strain: Option<&mut Strain>,
    ) -> u64 {
        let patch = patches.patch(p);
        let bent = self.marks.bent(patches, p, stale, &out.moved);
        let at = &mut self.nearby;
        at.gather(patches, p, &out.offsets_mm);
        let mut with_longer;
        let mut start = &self.corrections[p as usize];
        if !patch.longer.is_empty() {
            with_longer = *start;
            add_longer(at, &patch, &mut with_longer);
            start = &with_longer;
        }
        let wanted = stale & bent;
        let new = &mut self.new;
        match strain {
            None => compute(at, &patch, start, wanted, None, new),
            Some(strain) => {
                compute(at, &patch, start, wanted, Some(strain.weights(p)), new);
                strain.put(
                    surface,
                    at,
                    p,
                    &patch,
                    [stale, wanted],
                    out,
                    &mut new.strains,
                );
            }
        }
        if wanted & !patch.without_ring == u64::MAX && new.n_sound == BLOCK as u64 {
            let held = &mut out.normals[p as usize];
            if self.marks.displaced(p) == u64::MAX {
                // All are drawn anew, whether the normal turns or not.
                *held = new.normals;
                return u64::MAX;
            }
            return replace(held, &new.normals);
        }
        let mut turned = 0;
        for i in bits(stale) {
            let v = vertex(p, i);
            let at_rest = surface.normals()[v as usize];
            let normal = if bent >> i & 1 == 0 {
                at_rest
            } else if patch.without_ring >> i & 1 == 1 {
                normal_of_fans(surface, out, v)
            } else if is_sound(new.lengths_sq[i]) {
                new.normals.get(i)
            } else {
                let even = i & !1;
                let sums = area(&Ring::of(at, &patch, even)).plus(pair_of(start, even));
                unit_or(sums.get(i - even), at_rest)
            };
            let held = &mut out.normals[p as usize];
            turned |= u64::from(held.get(i) != normal) << i;
            held.set(i, normal);
        }
        turned
    }
}

/// What is computed anew of a patch; leftovers of another where it is not.
#[derive(Clone, Debug)]
struct New {
    normals: Block,
    lengths_sq: Row,
    /// Vertices whose normal has a direction.
    n_sound: u64,
    strains: Row,
}

impl Default for New {
    fn default() -> Self {
        Self {
            normals: Block::ZERO,
            lengths_sq: [0.0; BLOCK],
            n_sound: 0,
            strains: [0.0; BLOCK],
        }
    }
}

/// Computes the `wanted` normals of a patch, those that have a ring, and their strains where there are weights for them.
#[inline(always)]
fn compute(
    at: &Nearby,
    patch: &Patch,
    start: &Block,
    wanted: u64,
    weights: Option<&Weights>,
    new: &mut New,
) {
    new.n_sound = 0;
    for i in (0..BLOCK).step_by(2) {
        if wanted >> i & 3 == 0 {
            continue;
        }
        let ring = Ring::of(at, patch, i);
        let sum = area(&ring).plus(pair_of(start, i));
        let length_sq = sum.length_sq();
        sum.times(per_length(length_sq)).put(&mut new.normals, i);
        length_sq.put(&mut new.lengths_sq, i);
        let [l, m] = length_sq.0;
        new.n_sound += u64::from(is_sound(l)) + u64::from(is_sound(m));
        if let Some(weights) = weights {
            let here = at.pair(i as u8, i as u8 + 1);
            strain::of_ring(here, &ring, weights, i).put(&mut new.strains, i);
        }
    }
}

/// Writes the normals of a patch; answers with the bits of those that changed.
#[inline]
fn replace(held: &mut Block, new: &Block) -> u64 {
    let (mut same, mut n_same) = ([0_u64; BLOCK], 0);
    for (i, same) in same.iter_mut().enumerate() {
        let (x, y, z) = (new.x[i], new.y[i], new.z[i]);
        *same = u64::from((x == held.x[i]) & (y == held.y[i]) & (z == held.z[i]));
        n_same += *same;
        (held.x[i], held.y[i], held.z[i]) = (x, y, z);
    }
    unless(&same, n_same)
}

/// Whether a vector with this squared length has a direction.
#[inline(always)]
fn is_sound(length_sq: f64) -> bool {
    (f64::MIN_POSITIVE..=f64::MAX).contains(&length_sq)
}

#[inline(always)]
fn per_length(length_sq: Pair) -> Pair {
    Pair([1.0; 2]) / length_sq.sqrt()
}

#[inline(always)]
fn pair_of(block: &Block, i: usize) -> Places {
    Places {
        x: Pair::of(&block.x, i),
        y: Pair::of(&block.y, i),
        z: Pair::of(&block.z, i),
    }
}

/// Twice the area vectors of two rings, mm².
#[inline(always)]
fn area(Ring([a, b, c, d, e, f]): &Ring) -> Places {
    let first = c.minus(*a).cross(d.minus(*b));
    let second = e.minus(*a).cross(f.minus(*d));
    first.plus(second)
}

/// Adds what longer rings have beyond that.
fn add_longer(at: &Nearby, patch: &Patch, sums: &mut Block) {
    for l in patch.longer {
        let [a, b] = [l.first, l.before].map(|k| at.get(k));
        let [c, d] = l.next.map(|k| at.get(k));
        let i = l.vertex as usize;
        sums.set(i, sums.get(i) + (c - a).cross(d - b));
    }
}

/// The normal of a vertex without a plain ring, from its triangles one by one.
fn normal_of_fans(surface: &Surface, out: &Displacement, v: u32) -> Vec3 {
    let normal_at_rest = surface.normals()[v as usize];
    let (mut at_rest, mut now) = (Vec3::ZERO, Vec3::ZERO);
    for &t in surface.topology().triangles_of(v) {
        let corners = surface.triangles()[t as usize];
        let [a, b, c] = corners.map(|c| surface.positions()[c as usize]);
        let [d, e, f] = corners.map(|c| out.position(surface, c));
        at_rest += (b - a).cross(c - a);
        now += (e - d).cross(f - d);
    }
    let sum = normal_at_rest * at_rest.length() + (now - at_rest);
    unit_or(sum, normal_at_rest)
}
