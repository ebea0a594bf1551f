//! Which vertices a dent moves: ring by ring over adjacency (Ji 2008, 4.5).
//!
//! The dent is the part of the skin that can be reached from the triangle under the finger without leaving the outline.
//! Two triangles hang together when they share a corner inside the outline, or an edge that reaches into it. So the chest
//! never comes along with the back, however close it lies, and no vertex jumps in when the finger crosses an edge of a
//! triangle larger than the outline.
//!
//! Where a whole patch lies inside, the ring grows by the patch; elsewhere by the vertex. The result is the same.

use super::footprint::Outline;
use super::patches::{NEARBY, Patches, bits};
use crate::surface::{RIM, Surface};
use std::collections::HashSet;

/// The search with its scratch memory, reused from frame to frame. Safe to drop at any time.
///
/// Nothing is cleared between searches: what is known of a patch carries the generation it was learnt in. The cost is
/// proportional to the patches found and the vertices along the outline.
#[derive(Clone, Debug, Default)]
pub struct RingSearch {
    known: Vec<Known>,
    generation: u32,
    found: Vec<u32>,
    /// Patches with vertices whose neighbours have not been met.
    waiting: Vec<u32>,
    /// Triangles entered across an edge, not by a corner. Membership only: its order is never looked at.
    entered: HashSet<u32>,
}

/// What a search knows of a patch. One bit per vertex.
#[derive(Clone, Copy, Debug, Default)]
struct Known {
    generation: u32,
    waiting: bool,
    /// Lies inside the outline.
    within: u64,
    /// Within, and met: found.
    found: u64,
    /// Found, and its neighbours met.
    done: u64,
}

/// What is known of a vertex of a patch or its halo while its neighbours are met.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Nearby {
    Outside,
    Unmet,
    Met,
}

impl RingSearch {
    /// Patches with a vertex found, in an order that is the same every time.
    pub(super) fn found(&self) -> &[u32] {
        &self.found
    }

    /// Bits of the vertices found in patch `p`.
    #[inline]
    pub(super) fn inside(&self, p: u32) -> u64 {
        let known = &self.known[p as usize];
        if known.generation == self.generation {
            known.found
        } else {
            0
        }
    }

    /// The vertices found, in an order that is the same every time.
    pub fn vertices<'a>(&'a self, patches: &'a Patches) -> impl Iterator<Item = u32> + 'a {
        self.found.iter().flat_map(|&p| {
            let vertices = patches.patch(p).vertices;
            bits(self.inside(p)).map(|i| vertices[i])
        })
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        size_of::<Known>() * self.known.capacity()
            + 8 * self.entered.capacity()
            + 4 * (self.found.capacity() + self.waiting.capacity())
    }

    /// Finds the vertices inside `outline` that hang together with triangle `start`.
    ///
    /// `patches` must be those of `surface`, `start` one of its triangles. Nothing is found where no vertex is inside.
    pub fn search(
        &mut self,
        surface: &Surface,
        patches: &Patches,
        outline: &impl Outline,
        start: u32,
    ) {
        if self.known.len() != patches.len() || self.generation == u32::MAX {
            self.known.clear();
            self.known.resize(patches.len(), Known::default());
            self.generation = 0;
        }
        self.generation += 1;
        self.found.clear();
        self.waiting.clear();
        self.entered.clear();
        let mut walk = Walk {
            surface,
            patches,
            outline,
            search: self,
        };
        walk.enter(start);
        while let Some(p) = walk.search.waiting.pop() {
            walk.search.known[p as usize].waiting = false;
            walk.spread(p);
        }
    }
}

/// One search under way.
struct Walk<'a, O> {
    surface: &'a Surface,
    patches: &'a Patches,
    outline: &'a O,
    search: &'a mut RingSearch,
}

impl<O: Outline> Walk<'_, O> {
    /// What is known of patch `p`, learnt now if need be: by its box, or of all its vertices in one pass through memory.
    #[inline]
    fn known(&mut self, p: u32) -> &mut Known {
        let generation = self.search.generation;
        if self.search.known[p as usize].generation != generation {
            self.search.known[p as usize] = Known {
                generation,
                within: self.within(p),
                ..Known::default()
            };
        }
        &mut self.search.known[p as usize]
    }

    fn within(&self, p: u32) -> u64 {
        let patch = self.patches.patch(p);
        if self.outline.holds(patch.bounds) {
            return patch.all();
        }
        let within = |&v: &u32| self.outline.ratio(self.surface.positions()[v as usize]) < 1.0;
        let each = patch.vertices.iter().map(within).enumerate();
        each.fold(0, |word, (i, within)| word | u64::from(within) << i)
    }

    /// Meets vertices of patch `p` next to one found; answers whether all of the patch is within, and so found.
    #[inline]
    fn meet(&mut self, p: u32, met: u64) -> bool {
        let all = self.patches.patch(p).all();
        let known = self.known(p);
        let whole = known.within == all;
        let new = if whole { all } else { met & known.within } & !known.found;
        if new != 0 {
            let first = known.found == 0;
            known.found |= new;
            if !std::mem::replace(&mut known.waiting, true) {
                self.search.waiting.push(p);
            }
            if first {
                self.search.found.push(p);
            }
        }
        whole
    }

    /// Meets the neighbours of what is newly found in patch `p`.
    fn spread(&mut self, p: u32) {
        let patch = self.patches.patch(p);
        if self.search.known[p as usize].found == patch.all() {
            let mut amid_whole = true;
            for &q in patch.beside {
                // A whole patch beside has a vertex of this one's halo.
                amid_whole &= self.meet(q, 0);
            }
            if amid_whole {
                self.search.known[p as usize].done = patch.all();
                return;
            }
        }
        let mut nearby = [Nearby::Outside; NEARBY];
        let n = patch.vertices.len();
        let known = self.search.known[p as usize];
        for i in bits(known.within & !known.found) {
            nearby[i] = Nearby::Unmet;
        }
        for i in bits(known.found) {
            nearby[i] = Nearby::Met;
        }
        for (near, (q, bit)) in nearby[n..].iter_mut().zip(patch.halo_places()) {
            let known = self.known(q);
            if known.found & bit != 0 {
                *near = Nearby::Met;
            } else if known.within & bit != 0 {
                *near = Nearby::Unmet;
            }
        }
        let (mut found, mut done) = (known.found, known.done);
        while found != done {
            let new = found & !done;
            done = found;
            for (i, ring) in patch.rings().enumerate() {
                if new >> i & 1 == 0 {
                    continue;
                }
                if ring.is_empty() {
                    self.spread_over_fans(patch.vertices[i]);
                    found |= self.search.known[p as usize].found;
                    continue;
                }
                let mut before = ring[ring.len() - 1];
                for &k in ring {
                    match nearby[k as usize] {
                        Nearby::Met => {}
                        Nearby::Unmet if (k as usize) < n => {
                            nearby[k as usize] = Nearby::Met;
                            found |= 1 << k;
                        }
                        Nearby::Unmet => {
                            nearby[k as usize] = Nearby::Met;
                            let (q, bit) = patch.halo_place(k as usize - n);
                            self.meet(q, bit);
                        }
                        Nearby::Outside if nearby[before as usize] == Nearby::Outside => {
                            self.cross(patch.vertices[i], patch.near(before), patch.near(k));
                        }
                        Nearby::Outside => {}
                    }
                    before = k;
                }
            }
        }
        let known = &mut self.search.known[p as usize];
        known.found |= found;
        known.done |= done;
    }

    fn spread_over_fans(&mut self, v: u32) {
        for &t in self.surface.topology().triangles_of(v) {
            for c in self.surface.triangles()[t as usize] {
                let (p, bit) = self.patches.place(c);
                self.meet(p, bit);
            }
            let [a, b, c] = self.surface.triangles()[t as usize];
            for (at, from, to) in [(a, b, c), (b, c, a), (c, a, b)] {
                if at == v && !self.is_within(from) && !self.is_within(to) {
                    self.cross(v, from, to);
                }
            }
        }
    }

    fn is_within(&mut self, v: u32) -> bool {
        let (p, bit) = self.patches.place(v);
        self.known(p).within & bit != 0
    }

    /// Goes on across the edge `from`–`to` of a triangle whose third corner `v` was found, where the outline reaches over it.
    fn cross(&mut self, v: u32, from: u32, to: u32) {
        let [a, b] = [from, to].map(|v| self.surface.positions()[v as usize]);
        if !self.outline.reaches(a, b) {
            return;
        }
        for &t in self.surface.topology().triangles_of(v) {
            let corners = self.surface.triangles()[t as usize];
            let edge = (0..3).find(|&e| corners[e] == from && corners[(e + 1) % 3] == to);
            if let Some(edge) = edge {
                let next = self.surface.topology().across(t)[edge];
                if next != RIM {
                    self.enter(next);
                }
            }
        }
    }

    /// Takes in triangle `t`, which the outline reaches, and goes on across its edges while no corner is inside.
    fn enter(&mut self, t: u32) {
        let mut waiting = vec![t];
        while let Some(t) = waiting.pop() {
            if !self.search.entered.insert(t) {
                continue;
            }
            let corners = self.surface.triangles()[t as usize];
            if corners.iter().any(|&v| self.is_within(v)) {
                for v in corners {
                    let (p, bit) = self.patches.place(v);
                    self.meet(p, bit);
                }
                continue;
            }
            let p = corners.map(|v| self.surface.positions()[v as usize]);
            for edge in 0..3 {
                let next = self.surface.topology().across(t)[edge];
                if next != RIM && self.outline.reaches(p[edge], p[(edge + 1) % 3]) {
                    waiting.push(next);
                }
            }
        }
    }
}
