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
use super::blocks::{BLOCK, Block, bits, unless, vertex};
use super::displacement::Change;
use super::marks::Marks;
use super::nearby::{Nearby, Places};
use super::pairs::Pair;
use super::patches::{Patch, Patches};
use crate::geom::{Vec3, unit_or};
use crate::surface::Surface;

/// What an update has to shade, what a surface needs for it, and scratch memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Shading {
    marks: Marks,
    /// n₀ |S₀| − S₀, mm².
    corrections: Vec<Block>,
    nearby: Nearby,
}

impl Shading {
    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        self.marks.bytes() + size_of_val(&self.corrections[..])
    }

    /// Builds what is kept about a surface.
    pub fn prepare(&mut self, surface: &Surface, patches: &Patches) {
        let at_rest = vec![Block::ZERO; patches.len()];
        self.corrections.clear();
        for p in 0..patches.len() as u32 {
            self.nearby.gather(patches, p, &at_rest);
            let patch = patches.patch(p);
            let mut sums = Block::ZERO;
            add_longer(&self.nearby, &patch, &mut sums);
            for i in (0..BLOCK).step_by(2) {
                area(&self.nearby, &patch, i)
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

    /// Renews the normals of displaced vertices and those next to them; lists in `out` what changed.
    pub fn renew(&mut self, surface: &Surface, patches: &Patches, out: &mut Displacement) {
        self.marks.spread(patches);
        out.changes.clear();
        for i in 0..self.marks.marked().len() {
            let p = self.marks.marked()[i];
            let stale = self.marks.stale(patches, p);
            let displaced = self.marks.displaced(p);
            let turned = self.renew_patch(surface, patches, p, stale, out);
            let touched = displaced | turned;
            if touched != 0 {
                out.changes.push(Change {
                    block: p,
                    displaced,
                    touched,
                });
            }
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
    ) -> u64 {
        let patch = patches.patch(p);
        let bent = self.marks.bent(patches, p, stale, &out.moved);
        self.nearby.gather(patches, p, &out.offsets_mm);
        let mut with_longer;
        let mut start = &self.corrections[p as usize];
        if !patch.longer.is_empty() {
            with_longer = *start;
            add_longer(&self.nearby, &patch, &mut with_longer);
            start = &with_longer;
        }
        let wanted = stale & bent;
        let (mut new, mut lengths_sq) = (Block::ZERO, [1.0; BLOCK]);
        let mut n_sound = 0;
        for i in (0..BLOCK).step_by(2) {
            if wanted >> i & 3 == 0 {
                continue;
            }
            let sum = area(&self.nearby, &patch, i).plus(pair_of(start, i));
            let length_sq = sum.length_sq();
            sum.times(per_length(length_sq)).put(&mut new, i);
            length_sq.put(&mut lengths_sq, i);
            let [l, m] = length_sq.0;
            n_sound += u64::from(is_sound(l)) + u64::from(is_sound(m));
        }
        if wanted & !patch.without_ring == u64::MAX && n_sound == BLOCK as u64 {
            let held = &mut out.normals[p as usize];
            if self.marks.displaced(p) == u64::MAX {
                // All are drawn anew, whether the normal turns or not.
                *held = new;
                return u64::MAX;
            }
            return replace(held, &new);
        }
        let mut turned = 0;
        for i in bits(stale) {
            let v = vertex(p, i);
            let at_rest = surface.normals()[v as usize];
            let normal = if bent >> i & 1 == 0 {
                at_rest
            } else if patch.without_ring >> i & 1 == 1 {
                normal_of_fans(surface, out, v)
            } else if is_sound(lengths_sq[i]) {
                new.get(i)
            } else {
                let even = i & !1;
                let sums = area(&self.nearby, &patch, even).plus(pair_of(start, even));
                unit_or(sums.get(i - even), at_rest)
            };
            let held = &mut out.normals[p as usize];
            turned |= u64::from(held.get(i) != normal) << i;
            held.set(i, normal);
        }
        turned
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

/// Twice the area vectors of the first six corners of the rings of two vertices, mm².
#[inline(always)]
fn area(at: &Nearby, patch: &Patch, i: usize) -> Places {
    let [r0, r1, r2, r3, r4, r5] = patch.rings;
    let a = at.pair(r0[i], r0[i + 1]);
    let b = at.pair(r1[i], r1[i + 1]);
    let c = at.pair(r2[i], r2[i + 1]);
    let d = at.pair(r3[i], r3[i + 1]);
    let e = at.pair(r4[i], r4[i + 1]);
    let f = at.pair(r5[i], r5[i + 1]);
    let first = c.minus(a).cross(d.minus(b));
    let second = e.minus(a).cross(f.minus(d));
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
