//! Normals of the deformed surface, recomputed only where a triangle changed (Ji 2008, 4.5).
//!
//! n = unit(n₀ |S₀| + S − S₀) with S and S₀ the sums of the area normals of a vertex's triangles, deformed and at rest, and n₀
//! its normal at rest. So a normal leaves the one at rest, which is weighted by angles, without a jump, follows the area
//! normals from there on. Where no triangle of the vertex moved it is exactly n₀.
//!
//! The area normals of a fan of triangles add up to the area vector of the closed polygon round it, whatever lies in the
//! middle. A polygon falls into quadrilaterals, and the area vector of one is a single cross product, that of its diagonals:
//! two for the usual six neighbours, instead of six.

use super::Displacement;
use super::patches::{NEARBY, Patch, Patches, bits};
use crate::geom::{Vec3, unit_or};
use crate::surface::Surface;

/// The patches with something to shade, and scratch memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Shading {
    marks: Vec<Mark>,
    generation: u32,
    marked: Vec<u32>,
    /// Per vertex in the order of the patches: n₀ |S₀| − S₀, mm².
    corrections: Vec<Vec3>,
    nearby: Nearby,
}

/// A patch and its halo, gathered.
#[derive(Clone, Debug)]
struct Nearby {
    deformed_mm: [Vec3; NEARBY],
    moved: [bool; NEARBY],
}

impl Default for Nearby {
    fn default() -> Self {
        Self {
            deformed_mm: [Vec3::ZERO; NEARBY],
            moved: [false; NEARBY],
        }
    }
}

impl Nearby {
    #[inline(always)]
    fn gather(&mut self, surface: &Surface, patch: &Patch, offset_mm: impl Fn(u32) -> Vec3) {
        let places = self.deformed_mm.iter_mut().zip(&mut self.moved);
        for ((at, moved), &v) in places.zip(patch.nearby()) {
            let offset = offset_mm(v);
            *at = surface.positions()[v as usize] + offset;
            *moved = offset != Vec3::ZERO;
        }
    }

    fn any_moved(&self, ring: &[u8]) -> bool {
        ring.iter().any(|&k| self.moved[k as usize])
    }
}

/// Vertices of a patch, a bit each.
#[derive(Clone, Copy, Debug, Default)]
struct Mark {
    generation: u32,
    /// Offset changed.
    displaced: u64,
    /// A triangle changed.
    stale: u64,
}

impl Shading {
    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        size_of::<Mark>() * self.marks.capacity()
            + 4 * self.marked.capacity()
            + size_of_val(&self.corrections[..])
    }

    /// Builds what is kept about a surface.
    pub fn prepare(&mut self, surface: &Surface, patches: &Patches) {
        self.corrections.clear();
        for p in 0..patches.len() as u32 {
            let patch = patches.patch(p);
            self.nearby.gather(surface, &patch, |_| Vec3::ZERO);
            for (ring, &v) in patch.rings().zip(patch.vertices) {
                let sum = area(&self.nearby.deformed_mm, ring);
                let correction = surface.normals()[v as usize] * sum.length() - sum;
                self.corrections.push(correction);
            }
        }
    }

    /// Forgets all marks.
    pub fn begin(&mut self, patches: &Patches) {
        if self.marks.len() != patches.len() || self.generation == u32::MAX {
            self.marks.clear();
            self.marks.resize(patches.len(), Mark::default());
            self.generation = 0;
        }
        self.generation += 1;
        self.marked.clear();
    }

    /// Notes the vertices of patch `p` whose offset changed.
    pub fn note(&mut self, p: u32, displaced: u64) {
        if displaced != 0 {
            let mark = self.mark(p);
            mark.displaced |= displaced;
            mark.stale |= displaced;
        }
    }

    #[inline]
    fn mark(&mut self, p: u32) -> &mut Mark {
        let mark = &mut self.marks[p as usize];
        if mark.generation != self.generation {
            *mark = Mark {
                generation: self.generation,
                ..Mark::default()
            };
            self.marked.push(p);
        }
        mark
    }

    /// Renews the normals of displaced vertices and those next to them; lists in `out.touched` what changed.
    pub fn renew(&mut self, surface: &Surface, patches: &Patches, out: &mut Displacement) {
        for i in 0..self.marked.len() {
            self.mark_neighbours(surface, patches, self.marked[i]);
        }
        out.touched.clear();
        self.marked.sort_unstable();
        for i in 0..self.marked.len() {
            self.renew_patch(surface, patches, self.marked[i], out);
        }
    }

    fn mark_neighbours(&mut self, surface: &Surface, patches: &Patches, p: u32) {
        let patch = patches.patch(p);
        let displaced = self.marks[p as usize].displaced;
        if displaced == patch.all() {
            for (p, bit) in patch.halo_places() {
                self.mark(p).stale |= bit;
            }
            return;
        }
        for v in bits(displaced).map(|i| patch.vertices[i]) {
            for &n in surface.topology().neighbours(v) {
                let (p, bit) = patches.place(n);
                self.mark(p).stale |= bit;
            }
        }
    }

    fn renew_patch(
        &mut self,
        surface: &Surface,
        patches: &Patches,
        p: u32,
        out: &mut Displacement,
    ) {
        let patch = patches.patch(p);
        let mark = self.marks[p as usize];
        let offsets_mm = &out.offsets_mm;
        self.nearby
            .gather(surface, &patch, |v| offsets_mm[v as usize]);
        let corrections = &self.corrections[patches.first(p)..];
        let vertices = patch.vertices.iter().zip(corrections);
        for (i, (ring, (&v, &correction))) in patch.rings().zip(vertices).enumerate() {
            if mark.stale >> i & 1 == 0 {
                continue;
            }
            let at_rest = || surface.normals()[v as usize];
            let normal = if ring.is_empty() {
                normal_of_fans(surface, offsets_mm, v)
            } else if self.nearby.moved[i] || self.nearby.any_moved(ring) {
                let sum = correction + area(&self.nearby.deformed_mm, ring);
                let length_sq = sum.length_squared();
                if length_sq > f64::MIN_POSITIVE && length_sq < f64::MAX {
                    sum * (1.0 / length_sq.sqrt())
                } else {
                    unit_or(sum, at_rest())
                }
            } else {
                at_rest()
            };
            let held = &mut out.normals[v as usize];
            if mark.displaced >> i & 1 == 1 || *held != normal {
                *held = normal;
                out.touched.push(v);
            }
        }
    }
}

/// Twice the area vector of the closed polygon with the given corners, mm².
#[inline(always)]
fn area(points: &[Vec3; NEARBY], ring: &[u8]) -> Vec3 {
    let at = |k: u8| points[k as usize];
    if let &[a, b, c, d, e, f] = ring {
        let a = at(a);
        return (at(c) - a).cross(at(d) - at(b)) + (at(e) - a).cross(at(f) - at(d));
    }
    let [first, rest @ ..] = ring else {
        return Vec3::ZERO;
    };
    let a = at(*first);
    let mut sum = Vec3::ZERO;
    let mut rest = rest;
    while let [b, c, d, ..] = rest {
        sum += (at(*c) - a).cross(at(*d) - at(*b));
        rest = &rest[2..];
    }
    if let [b, c] = rest {
        sum += (at(*b) - a).cross(at(*c) - a);
    }
    sum
}

/// The normal of a vertex without a plain ring, from its triangles one by one.
fn normal_of_fans(surface: &Surface, offsets_mm: &[Vec3], v: u32) -> Vec3 {
    let normal_at_rest = surface.normals()[v as usize];
    let (mut at_rest, mut now, mut moved) = (Vec3::ZERO, Vec3::ZERO, false);
    for &t in surface.topology().triangles_of(v) {
        let corners = surface.triangles()[t as usize].map(|c| c as usize);
        let [a, b, c] = corners.map(|c| surface.positions()[c]);
        let [d, e, f] = corners.map(|c| surface.positions()[c] + offsets_mm[c]);
        at_rest += (b - a).cross(c - a);
        now += (e - d).cross(f - d);
        moved |= corners.iter().any(|&c| offsets_mm[c] != Vec3::ZERO);
    }
    if moved {
        let sum = normal_at_rest * at_rest.length() + (now - at_rest);
        unit_or(sum, normal_at_rest)
    } else {
        normal_at_rest
    }
}
