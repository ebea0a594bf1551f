//! Which vertices a dent moves: ring by ring over adjacency (Ji 2008, 4.5).
//!
//! The dent is the part of the skin that can be reached from the triangle under the finger without leaving the outline.
//! Two triangles hang together when they share a corner inside the outline, or an edge that reaches into it. So the chest
//! never comes along with the back, however close it lies, and no vertex jumps in when the finger crosses an edge of a
//! triangle larger than the outline.

use super::footprint::Outline;
use crate::surface::{RIM, Surface};
use std::collections::HashSet;

/// The search with its scratch memory, reused from frame to frame. Safe to drop at any time.
///
/// Nothing is cleared between searches: a vertex is known by the generation it was last seen in. The cost is proportional
/// to the vertices found.
#[derive(Clone, Debug, Default)]
pub struct RingSearch {
    /// Per vertex: the generation, plus one where it was found inside.
    seen: Vec<u32>,
    generation: u32,
    inside: Vec<u32>,
    ratios: Vec<f64>,
    border: Vec<u32>,
    /// Triangles entered across an edge, not by a corner. Membership only: its order is never looked at.
    entered: HashSet<u32>,
}

impl RingSearch {
    /// Vertices inside, from the innermost ring to the outermost.
    pub fn inside(&self) -> &[u32] {
        &self.inside
    }

    /// Location ratios of [`RingSearch::inside`], each below 1.
    pub fn ratios(&self) -> &[f64] {
        &self.ratios
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        4 * (self.seen.capacity() + self.inside.capacity() + self.border.capacity())
            + 8 * (self.ratios.capacity() + self.entered.capacity())
    }

    /// Finds the vertices inside `outline` that hang together with triangle `start`.
    ///
    /// `start` must be a triangle of `surface`. Nothing is found where no vertex is inside.
    pub fn search(&mut self, surface: &Surface, outline: &impl Outline, start: u32) {
        self.begin(surface.positions().len());
        for v in surface.triangles()[start as usize] {
            self.rate(surface, outline, v);
        }
        if self.inside.is_empty() {
            self.enter(surface, outline, start);
        }
        let mut head = 0;
        let mut border_head = 0;
        loop {
            while let Some(&v) = self.inside.get(head) {
                head += 1;
                for &n in surface.topology().neighbours(v) {
                    self.rate(surface, outline, n);
                }
            }
            let Some(&v) = self.border.get(border_head) else {
                break;
            };
            border_head += 1;
            let n_found = self.inside.len();
            self.look_across(surface, outline, v);
            if self.inside.len() > n_found {
                // A new patch of the dent may lie against border vertices looked at before.
                border_head = 0;
            }
        }
    }

    fn begin(&mut self, n_vertices: usize) {
        if self.seen.len() != n_vertices || self.generation >= u32::MAX - 3 {
            self.seen.clear();
            self.seen.resize(n_vertices, 0);
            self.generation = 0;
        }
        self.generation += 2;
        self.inside.clear();
        self.ratios.clear();
        self.border.clear();
        self.entered.clear();
    }

    #[inline]
    fn rate(&mut self, surface: &Surface, outline: &impl Outline, v: u32) {
        let seen = &mut self.seen[v as usize];
        if *seen >= self.generation {
            return;
        }
        let q = outline.ratio(surface.positions()[v as usize]);
        if q < 1.0 {
            *seen = self.generation + 1;
            self.inside.push(v);
            self.ratios.push(q);
        } else {
            *seen = self.generation;
            self.border.push(v);
        }
    }

    fn is_inside(&self, v: u32) -> bool {
        self.seen[v as usize] == self.generation + 1
    }

    /// Follows the outline across edges at the border vertex `v` whose both ends are outside.
    fn look_across(&mut self, surface: &Surface, outline: &impl Outline, v: u32) {
        for &t in surface.topology().triangles_of(v) {
            let corners = surface.triangles()[t as usize];
            let inside = corners.map(|c| self.is_inside(c));
            // With two corners inside, the triangles across all edges share one of them.
            let far_edge = match inside {
                [true, false, false] => 1,
                [false, true, false] => 2,
                [false, false, true] => 0,
                _ => continue,
            };
            let ends = [corners[far_edge], corners[(far_edge + 1) % 3]]
                .map(|c| surface.positions()[c as usize]);
            let next = surface.topology().across(t)[far_edge];
            if next != RIM && outline.reaches(ends[0], ends[1]) {
                self.enter(surface, outline, next);
            }
        }
    }

    /// Takes in triangle `t`, which the outline reaches, and goes on across its edges while no corner is inside.
    fn enter(&mut self, surface: &Surface, outline: &impl Outline, t: u32) {
        let mut waiting = vec![t];
        while let Some(t) = waiting.pop() {
            if !self.entered.insert(t) {
                continue;
            }
            let corners = surface.triangles()[t as usize];
            for v in corners {
                self.rate(surface, outline, v);
            }
            if corners.iter().any(|&v| self.is_inside(v)) {
                continue;
            }
            let p = corners.map(|v| surface.positions()[v as usize]);
            for edge in 0..3 {
                let next = surface.topology().across(t)[edge];
                if next != RIM && outline.reaches(p[edge], p[(edge + 1) % 3]) {
                    waiting.push(next);
                }
            }
        }
    }
}
