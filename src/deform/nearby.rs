//! The places of one patch and what is round it, gathered where every vertex finds its neighbours by a byte.

use super::blocks::{BLOCK, Block};
use super::pairs::Pair;
use super::patches::{CORNERS, NEARBY, Patch, Patches};
use crate::geom::Vec3;

/// Places of a patch and its halo, mm, in the numbers of its rings.
#[derive(Clone, Debug)]
pub(super) struct Nearby {
    x: [f64; NEARBY],
    y: [f64; NEARBY],
    z: [f64; NEARBY],
}

impl Default for Nearby {
    fn default() -> Self {
        Self {
            x: [0.0; NEARBY],
            y: [0.0; NEARBY],
            z: [0.0; NEARBY],
        }
    }
}

impl Nearby {
    /// Gathers the places of patch `p` and its halo, each the sum of its position at rest and its offset.
    #[inline(always)]
    pub fn gather(&mut self, patches: &Patches, p: u32, offsets_mm: &[Block]) {
        let (rest, offset) = (patches.positions(p), &offsets_mm[p as usize]);
        for i in 0..BLOCK {
            self.x[i] = rest.x[i] + offset.x[i];
            self.y[i] = rest.y[i] + offset.y[i];
            self.z[i] = rest.z[i] + offset.z[i];
        }
        let patch = patches.patch(p);
        for beside in patch.beside {
            let rest = patches.positions(beside.block);
            let offset = &offsets_mm[beside.block as usize];
            let places = beside.in_halo();
            // What lies beyond has no number in a ring.
            for (k, &v) in (BLOCK + places.start..NEARBY).zip(&patch.halo[places]) {
                let i = v as usize % BLOCK;
                self.x[k] = rest.x[i] + offset.x[i];
                self.y[k] = rest.y[i] + offset.y[i];
                self.z[k] = rest.z[i] + offset.z[i];
            }
        }
    }

    #[inline(always)]
    pub fn get(&self, k: u8) -> Vec3 {
        let k = k as usize;
        Vec3::new(self.x[k], self.y[k], self.z[k])
    }

    /// Two places.
    #[inline(always)]
    pub fn pair(&self, k: u8, l: u8) -> Places {
        let (k, l) = (k as usize, l as usize);
        Places {
            x: Pair([self.x[k], self.x[l]]),
            y: Pair([self.y[k], self.y[l]]),
            z: Pair([self.z[k], self.z[l]]),
        }
    }
}

/// Two vectors, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Places {
    pub x: Pair,
    pub y: Pair,
    pub z: Pair,
}

impl Places {
    #[inline(always)]
    pub fn minus(self, o: Self) -> Self {
        Self {
            x: self.x - o.x,
            y: self.y - o.y,
            z: self.z - o.z,
        }
    }

    #[inline(always)]
    pub fn plus(self, o: Self) -> Self {
        Self {
            x: self.x + o.x,
            y: self.y + o.y,
            z: self.z + o.z,
        }
    }

    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self {
            x: self.y * o.z - self.z * o.y,
            y: self.z * o.x - self.x * o.z,
            z: self.x * o.y - self.y * o.x,
        }
    }

    /// Each by its number.
    #[inline(always)]
    pub fn times(self, by: Pair) -> Self {
        Self {
            x: self.x * by,
            y: self.y * by,
            z: self.z * by,
        }
    }

    /// The first or the second.
    #[inline(always)]
    pub fn get(self, i: usize) -> Vec3 {
        Vec3::new(self.x.0[i], self.y.0[i], self.z.0[i])
    }

    #[inline(always)]
    pub fn put(self, block: &mut Block, i: usize) {
        self.x.put(&mut block.x, i);
        self.y.put(&mut block.y, i);
        self.z.put(&mut block.z, i);
    }

    #[inline(always)]
    pub fn length_sq(self) -> Pair {
        self.x * self.x + self.y * self.y + self.z * self.z
    }
}

/// The first six corners of the rings of two vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ring(pub [Places; CORNERS]);

impl Ring {
    #[inline(always)]
    pub fn of(at: &Nearby, patch: &Patch, i: usize) -> Self {
        let [r0, r1, r2, r3, r4, r5] = patch.rings;
        Self([
            at.pair(r0[i], r0[i + 1]),
            at.pair(r1[i], r1[i + 1]),
            at.pair(r2[i], r2[i + 1]),
            at.pair(r3[i], r3[i + 1]),
            at.pair(r4[i], r4[i + 1]),
            at.pair(r5[i], r5[i + 1]),
        ])
    }
}
