//! What the haptic detecting box gathers, and what that costs; which leaf a point of the skin is in.

use super::built::Built;
use super::settings::Query;
use crate::geom::{Aabb, Vec3};
use crate::partition::hdb::Gathered;
use std::time::{Duration, Instant};

/// One query is repeated this often for its median time…
const REPEATS: usize = 9;
/// …or until this much time has gone.
const ENOUGH: Duration = Duration::from_micros(500);

/// One query and its cost.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    /// The triangles, in rising order and each once.
    pub triangles: Vec<u32>,
    /// What was visited.
    pub cost: Gathered,
    /// Median time, µs.
    pub us: f64,
}

impl Answer {
    fn of(mut ask: impl FnMut(&mut Vec<u32>) -> Option<Gathered>) -> Self {
        let mut answer = Self::default();
        let mut times_us = Vec::with_capacity(REPEATS);
        let begin = Instant::now();
        while times_us.is_empty() || (times_us.len() < REPEATS && begin.elapsed() < ENOUGH) {
            answer.triangles.clear();
            let start = Instant::now();
            answer.cost = ask(&mut answer.triangles).unwrap_or_default();
            times_us.push(start.elapsed().as_secs_f64() * 1e6);
        }
        times_us.sort_unstable_by(f64::total_cmp);
        answer.us = times_us[times_us.len() / 2];
        answer
    }
}

/// The box about a probe and what both queries gather in it.
#[derive(Clone, Debug)]
pub struct Asked {
    /// Its middle, mm.
    pub probe_mm: Vec3,
    /// The box, mm.
    pub region: Aabb,
    /// Every triangle whose box overlaps it.
    pub complete: Answer,
    /// Whole leaves, as published.
    pub published: Answer,
    /// Triangles whose box overlaps it that the published query misses.
    pub missed: usize,
}

impl Asked {
    /// Asks a tree.
    pub fn new(built: &Built, probe_mm: Vec3, region: Aabb) -> Self {
        let structure = built.structure();
        let complete = Answer::of(|out| structure.gather(&built.surface, &region, out));
        let published = Answer::of(|out| structure.gather_as_published(&region, out));
        let missed = (complete.triangles.iter())
            .filter(|t| published.triangles.binary_search(t).is_err())
            .count();
        Self {
            probe_mm,
            region,
            complete,
            published,
            missed,
        }
    }

    /// The answer of one query.
    pub fn answer(&self, query: Query) -> &Answer {
        match query {
            Query::Complete => &self.complete,
            Query::Published => &self.published,
        }
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        (self.complete.triangles.capacity() + self.published.triangles.capacity())
            * size_of::<u32>()
    }
}

/// The leaf whose cell holds a point of the skin.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The point, mm.
    pub point_mm: Vec3,
    /// The triangle it is on.
    pub triangle: u32,
    /// Whether the leaf lists that triangle; one that juts out of another leaf it does not.
    pub is_listed: bool,
    /// Number of the leaf among the nodes.
    pub leaf: u32,
    /// Levels under the root.
    pub level: u32,
    /// Entries.
    pub held: usize,
    /// Its cell, mm.
    pub cell: Aabb,
    /// The turns from the root, level by level: for each plane the axis and the side of it.
    pub path: String,
}

impl Place {
    /// The leaf at `point_mm` on `triangle`; `None` outside of the surface's box.
    pub fn of(built: &Built, point_mm: Vec3, triangle: u32) -> Option<Self> {
        let tree = built.tree()?;
        let numbers = tree.path_to(point_mm);
        let number = *numbers.last()?;
        let leaf = &tree.nodes()[number as usize];
        let turns: Vec<String> = numbers
            .iter()
            .map(|&at| &tree.nodes()[at as usize])
            .filter(|node| !node.is_leaf())
            .map(|node| {
                let side = |(axis, at_mm): (usize, f64)| {
                    let sign = if point_mm[axis] >= at_mm { '+' } else { '-' };
                    format!("{sign}{}", ["x", "y", "z"][axis])
                };
                tree.splits(node).map(side).collect()
            })
            .collect();
        Some(Self {
            point_mm,
            triangle,
            is_listed: tree.held(leaf).contains(&triangle),
            leaf: number,
            level: leaf.level,
            held: leaf.held as usize,
            cell: leaf.cell,
            path: turns.join(" "),
        })
    }
}
