//! Which vertices a dent moves: ring by ring over adjacency (Ji 2008, 4.5).
//!
//! The dent is the part of the skin that can be reached from the triangle under the finger without leaving the outline.
//! Two triangles hang together when they share a corner inside the outline, or an edge that reaches into it. So the chest
//! never comes along with the back, however close it lies, and no vertex jumps in when the finger crosses an edge of a
//! triangle larger than the outline.
//!
//! Where a whole patch lies inside, the ring grows by the patch; elsewhere by the vertex. The result is the same.

use super::blocks::{bits, place, vertex, word};
use super::footprint::Outline;
use super::patches::Patches;
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
    /// Triangles to enter.
    entering: Vec<u32>,
}

/// What a search knows of a patch. One bit per vertex.
#[derive(Clone, Copy, Debug, Default)]
struct Known {
    generation: u32,
    waiting: bool,
    /// Lies inside the outline.
    within: u64,
    /// Lies outside, but so near that an edge there may reach in.
    near: u64,
    /// Within, and met: found.
    found: u64,
    /// Found, and its neighbours met.
    done: u64,
}

impl RingSearch {
    /// Patches with a vertex found, in an order that is the same every time.
    pub(super) fn found(&self) -> &[u32] {
        &self.found
    }

    /// Bits of the vertices found in patch `p`.
    #[inline]
    pub(super) fn inside(&self, p: u32) -> u64 {
        self.of(p).map_or(0, |known| known.found)
    }

    /// Bits of the vertices of patch `p` that lie inside the outline, found or not. Only for a patch with a vertex found.
    #[inline]
    pub(super) fn within(&self, p: u32) -> u64 {
        self.of(p).map_or(0, |known| known.within)
    }

    fn of(&self, p: u32) -> Option<&Known> {
        let known = &self.known[p as usize];
        (known.generation == self.generation).then_some(known)
    }

    /// The vertices found, in an order that is the same every time.
    pub fn vertices(&self) -> impl Iterator<Item = u32> + '_ {
        let found = self.found.iter();
        found.flat_map(|&p| bits(self.inside(p)).map(move |i| vertex(p, i)))
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        size_of::<Known>() * self.known.capacity()
            + 8 * self.entered.capacity()
            + 4 * (self.found.capacity() + self.waiting.capacity() + self.entering.capacity())
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
            let (within, near) = self.look(p);
            self.search.known[p as usize] = Known {
                generation,
                within,
                near,
                ..Known::default()
            };
        }
        &mut self.search.known[p as usize]
    }

    /// The vertices of a patch that lie within and near the outline.
    fn look(&self, p: u32) -> (u64, u64) {
        let patch = self.patches.patch(p);
        if self.outline.holds(patch.bounds) {
            return (patch.all, 0);
        }
        if (self.outline).excludes(patch.bounds, patch.longest_edge_mm) {
            return (0, 0);
        }
        let near_ratio = self.outline.near_ratio(patch.longest_edge_mm);
        let positions = self.patches.positions(p);
        let mut ratios = [0.0; 64];
        for (i, ratio) in ratios.iter_mut().enumerate() {
            *ratio = self.outline.ratio(positions.get(i));
        }
        let (mut n_within, mut n_near) = (0, 0);
        for ratio in &ratios {
            n_within += u64::from(*ratio < 1.0);
            n_near += u64::from(*ratio <= near_ratio);
        }
        let within = match n_within {
            0 => 0,
            64 => u64::MAX,
            _ => word(|i| ratios[i] < 1.0),
        };
        if n_near == n_within {
            return (within, 0);
        }
        let near = word(|i| ratios[i] <= near_ratio);
        (within, near & patch.all & !within)
    }

    /// Meets vertices of patch `p` next to one found, and all that hangs together with them there.
    #[inline]
    fn meet(&mut self, p: u32, met: u64) {
        let known = *self.known(p);
        let new = met & known.within & !known.found;
        if new == 0 {
            return;
        }
        let reached = self.patches.patch(p).reached(known.within, new);
        if known.found == 0 {
            self.search.found.push(p);
        }
        if !known.waiting {
            self.search.waiting.push(p);
        }
        let known = &mut self.search.known[p as usize];
        known.found |= reached;
        known.waiting = true;
    }

    /// Meets the neighbours of what is newly found in patch `p`.
    fn spread(&mut self, p: u32) {
        let patches = self.patches;
        let patch = patches.patch(p);
        let known = &mut self.search.known[p as usize];
        let new = known.found & !known.done;
        known.done = known.found;
        let mut beside_near = if known.near == 0 {
            0
        } else {
            new & patch.next_to(known.near)
        };
        for beside in patch.beside {
            if beside.mine & new == 0 {
                continue;
            }
            let known = *self.known(beside.block);
            if known.near & beside.theirs != 0 {
                beside_near |= beside.mine & new;
            }
            if known.within & beside.theirs & !known.found != 0 {
                // Where all of them come along with any of them it does not matter which were met.
                let alike = beside.is_one_part() && known.within == patches.all(beside.block);
                let met = if alike {
                    beside.theirs
                } else {
                    patch.across(beside, new)
                };
                self.meet(beside.block, met);
            }
        }
        for i in bits(beside_near) {
            self.leave(vertex(p, i));
        }
    }

    /// Goes on across the edges that triangles with the found corner `v` have outside, where these reach in.
    fn leave(&mut self, v: u32) {
        for &t in self.surface.topology().triangles_of(v) {
            let corners = self.surface.triangles()[t as usize];
            let Some(k) = corners.iter().position(|&c| c == v) else {
                continue;
            };
            let edge = (k + 1) % 3;
            let [from, to] = [edge, (edge + 1) % 3].map(|k| corners[k]);
            let next = self.surface.topology().across(t)[edge];
            if next != RIM && !self.is_within(from) && !self.is_within(to) {
                let [a, b] = [from, to].map(|v| self.surface.positions()[v as usize]);
                if self.outline.reaches(a, b) {
                    self.enter(next);
                }
            }
        }
    }

    fn is_within(&mut self, v: u32) -> bool {
        let (p, bit) = place(v);
        self.known(p).within & bit != 0
    }

    /// Takes in triangle `t`, which the outline reaches, and goes on across its edges while no corner is inside.
    fn enter(&mut self, t: u32) {
        self.search.entering.push(t);
        while let Some(t) = self.search.entering.pop() {
            if !self.search.entered.insert(t) {
                continue;
            }
            let corners = self.surface.triangles()[t as usize];
            if corners.iter().any(|&v| self.is_within(v)) {
                for v in corners {
                    let (p, bit) = place(v);
                    self.meet(p, bit);
                }
                continue;
            }
            let p = corners.map(|v| self.surface.positions()[v as usize]);
            for edge in 0..3 {
                let next = self.surface.topology().across(t)[edge];
                if next != RIM && self.outline.reaches(p[edge], p[(edge + 1) % 3]) {
                    self.search.entering.push(next);
                }
            }
        }
    }
}
