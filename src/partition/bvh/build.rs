//! Top-down build: binned surface-area splits (Wald 2007, Interactive Ray Tracing) along the longest axis of the
//! centres, two levels of which make a node. Where the depth allowed would run out, splits halve instead, so the depth
//! is bounded for any input, coincident triangles included.

use super::{
    BoxFrame, Bvh, Child, LEAF_TRIANGLES, Node, SPARE_LEVELS, START_BITS, crossed, leaf_child,
    unpack,
};
use crate::surface::Surface;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Number of bins a split chooses between. More costs time and gains under 1 % in query cost.
const BINS: usize = 16;
/// Below this many triangles a thread of its own costs more than it brings.
const THREAD_TRIANGLES: usize = 64 * 1024;

/// One triangle while the tree is built.
#[derive(Clone, Copy)]
struct Prim {
    min: [f32; 3],
    max: [f32; 3],
    triangle: u32,
}

impl Prim {
    /// Twice the centre of the box.
    fn centre(&self) -> [f32; 3] {
        [0, 1, 2].map(|k| self.min[k] + self.max[k])
    }
}

#[derive(Clone, Copy)]
struct Box32 {
    min: [f32; 3],
    max: [f32; 3],
}

impl Box32 {
    const EMPTY: Self = Self {
        min: [f32::INFINITY; 3],
        max: [f32::NEG_INFINITY; 3],
    };

    fn grow(&mut self, min: &[f32; 3], max: &[f32; 3]) {
        for k in 0..3 {
            if min[k] < self.min[k] {
                self.min[k] = min[k];
            }
            if max[k] > self.max[k] {
                self.max[k] = max[k];
            }
        }
    }

    /// Half the area; 0 when empty.
    fn half_area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|k| (self.max[k] - self.min[k]).max(0.0));
        x * y + y * z + z * x
    }
}

pub(super) fn build(surface: &Surface) -> Bvh {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    build_with(surface, threads)
}

pub(super) fn build_with(surface: &Surface, threads: usize) -> Bvh {
    let frame = BoxFrame::of(surface);
    let n = surface.triangles().len().min((1 << START_BITS) - 4);
    let mut prims: Vec<Prim> = (0..n as u32)
        .map(|triangle| {
            let (min, max) = outward(frame, surface, triangle);
            Prim { min, max, triangle }
        })
        .collect();
    let levels = usize::BITS - (n.max(1) - 1).leading_zeros() + SPARE_LEVELS;
    let mut nodes = Vec::new();
    if n > 0 {
        subtree(&mut prims, 0, levels, threads, &mut nodes);
    }
    let order: Vec<u32> = prims.iter().map(|p| p.triangle).collect();
    drop(prims);
    let mut bvh = Bvh {
        frame,
        nodes: nodes.into_boxed_slice(),
        order: order.into_boxed_slice(),
        crossed: Box::default(),
    };
    bvh.crossed = crossed::crossed(&bvh, surface, threads);
    bvh
}

/// The box of a triangle in box units, rounded outward.
pub(super) fn outward(frame: BoxFrame, surface: &Surface, triangle: u32) -> ([f32; 3], [f32; 3]) {
    let bounds = surface.triangle(triangle).aabb();
    let (min, max) = (frame.to_box(bounds.min), frame.to_box(bounds.max));
    let down = |v: f64| {
        let r = v as f32;
        if f64::from(r) > v { r.next_down() } else { r }
    };
    let up = |v: f64| {
        let r = v as f32;
        if f64::from(r) < v { r.next_up() } else { r }
    };
    (min.to_array().map(down), max.to_array().map(up))
}

/// Appends the node over `prims` and everything under it to `nodes`, root first, children in order; returns its box.
/// `first` is where `prims` begin in the order of the leaves, `levels` how many two-way splits may lie under it.
fn subtree(
    prims: &mut [Prim],
    first: usize,
    levels: u32,
    threads: usize,
    nodes: &mut Vec<Node>,
) -> Box32 {
    let at = nodes.len();
    nodes.push(Node::EMPTY);
    let in_threads = threads > 1 && prims.len() >= THREAD_TRIANGLES;
    let ranges = four_ranges(prims, first, levels);
    let levels = levels.saturating_sub(2);
    let mut node = Node::EMPTY;
    let mut bounds = Box32::EMPTY;
    let mut put = |i: usize, child: u32, b: Box32| {
        node.child[i] = child;
        for k in 0..3 {
            node.min[k][i] = b.min[k];
            node.max[k][i] = b.max[k];
        }
        bounds.grow(&b.min, &b.max);
    };
    let built = if in_threads {
        apart(ranges, levels, threads)
    } else {
        ranges.map(|(first, range)| Part {
            first,
            range,
            bounds: Box32::EMPTY,
            nodes: None,
        })
    };
    for (i, part) in built.into_iter().enumerate() {
        let base = nodes.len() as u32;
        match part.nodes {
            _ if part.range.is_empty() => {}
            _ if part.range.len() <= LEAF_TRIANGLES => {
                let child = leaf_child(part.first, part.range.len());
                put(i, child, bounds_of(part.range));
            }
            Some(built) => {
                put(i, base, part.bounds);
                nodes.extend(built.into_iter().map(|n| moved(n, base)));
            }
            None => {
                let b = subtree(part.range, part.first, levels, 1, nodes);
                put(i, base, b);
            }
        }
    }
    nodes[at] = node;
    bounds
}

type Ranges<'a> = [(usize, &'a mut [Prim]); 4];

/// One range of a node's triangles, and its subtree where it has been built apart.
struct Part<'a> {
    first: usize,
    range: &'a mut [Prim],
    bounds: Box32,
    nodes: Option<Vec<Node>>,
}

/// Builds the larger ranges side by side, by this thread and as many more as the system grants.
fn apart(ranges: Ranges<'_>, levels: u32, threads: usize) -> [Part<'_>; 4] {
    let tasks = ranges.map(|(first, range)| {
        Mutex::new(Part {
            first,
            range,
            bounds: Box32::EMPTY,
            nodes: None,
        })
    });
    let next = AtomicUsize::new(0);
    let work = || {
        while let Some(task) = tasks.get(next.fetch_add(1, Ordering::Relaxed)) {
            if let Ok(mut part) = task.lock()
                && part.range.len() > LEAF_TRIANGLES
            {
                let part = &mut *part;
                let mut nodes = Vec::new();
                part.bounds = subtree(part.range, part.first, levels, 1, &mut nodes);
                part.nodes = Some(nodes);
            }
        }
    };
    std::thread::scope(|scope| {
        for i in 1..threads.min(4) {
            let helper = std::thread::Builder::new().name(format!("bvh-{i}"));
            if helper.spawn_scoped(scope, work).is_err() {
                break;
            }
        }
        work();
    });
    tasks.map(|task| {
        task.into_inner()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
    })
}

/// The node with its child nodes counted from `base` instead of 0.
fn moved(mut node: Node, base: u32) -> Node {
    for child in &mut node.child {
        if let Child::Node(i) = unpack(*child) {
            *child = i + base;
        }
    }
    node
}

/// Cuts `prims` in two, and each half that is too large for a leaf in two again.
fn four_ranges(prims: &mut [Prim], first: usize, levels: u32) -> Ranges<'_> {
    let halves = two_ranges(prims, first, levels);
    let mut out: Ranges = Default::default();
    for (i, (first, half)) in halves.into_iter().enumerate() {
        let [a, b] = two_ranges(half, first, levels.saturating_sub(1));
        (out[2 * i], out[2 * i + 1]) = (a, b);
    }
    out
}

fn two_ranges(prims: &mut [Prim], first: usize, levels: u32) -> [(usize, &mut [Prim]); 2] {
    if prims.len() <= LEAF_TRIANGLES {
        return [(first, prims), (first, &mut [])];
    }
    let cut = split(prims, levels);
    let (a, b) = prims.split_at_mut(cut);
    [(first, a), (first + cut, b)]
}

/// Sorts `prims` into two parts and returns the length of the first; both hold at least one.
fn split(prims: &mut [Prim], levels: u32) -> usize {
    let n = prims.len();
    let mut centres = Box32::EMPTY;
    for p in prims.iter() {
        let c = p.centre();
        centres.grow(&c, &c);
    }
    let size = [0, 1, 2].map(|k| centres.max[k] - centres.min[k]);
    let axis = (0..3).fold(0, |a, k| if size[k] > size[a] { k } else { a });
    // Halving from here on just reaches leaves of one triangle with the levels left.
    let must_halve = usize::BITS - (n - 1).leading_zeros() >= levels;
    if !must_halve && size[axis] > 0.0 {
        let bins = Bins {
            axis,
            low: centres.min[axis],
            per_unit: BINS as f32 * 0.999_99 / size[axis],
        };
        if let Some(last) = bins.best_cut(prims) {
            return partition(prims, |p| bins.of(p) <= last);
        }
    }
    let middle = n / 2;
    prims.select_nth_unstable_by(middle, |p, q| {
        let by_centre = p.centre()[axis].total_cmp(&q.centre()[axis]);
        by_centre.then(p.triangle.cmp(&q.triangle))
    });
    middle
}

struct Bins {
    axis: usize,
    low: f32,
    per_unit: f32,
}

impl Bins {
    fn of(&self, p: &Prim) -> usize {
        (((p.min[self.axis] + p.max[self.axis]) - self.low) * self.per_unit) as usize % BINS
    }

    /// The last bin of the first part of the cheapest cut; `None` where all are in one bin.
    fn best_cut(&self, prims: &[Prim]) -> Option<usize> {
        let mut count = [0_usize; BINS];
        let mut bounds = [Box32::EMPTY; BINS];
        for p in prims {
            let i = self.of(p);
            count[i] += 1;
            bounds[i].grow(&p.min, &p.max);
        }
        let mut right = [(0_usize, 0.0_f32); BINS];
        let (mut n, mut b) = (0, Box32::EMPTY);
        for i in (1..BINS).rev() {
            n += count[i];
            b.grow(&bounds[i].min, &bounds[i].max);
            right[i - 1] = (n, b.half_area());
        }
        let mut best: Option<(f32, usize)> = None;
        (n, b) = (0, Box32::EMPTY);
        for i in 0..BINS - 1 {
            n += count[i];
            b.grow(&bounds[i].min, &bounds[i].max);
            if n == 0 || right[i].0 == 0 {
                continue;
            }
            let cost = n as f32 * b.half_area() + right[i].0 as f32 * right[i].1;
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, i));
            }
        }
        best.map(|(_, i)| i)
    }
}

/// Moves what belongs to the first part to the front; returns how many.
fn partition(prims: &mut [Prim], first: impl Fn(&Prim) -> bool) -> usize {
    let (mut i, mut j) = (0, prims.len());
    loop {
        while i < j && first(&prims[i]) {
            i += 1;
        }
        while i < j && !first(&prims[j - 1]) {
            j -= 1;
        }
        if i >= j {
            return i;
        }
        prims.swap(i, j - 1);
    }
}

fn bounds_of(prims: &[Prim]) -> Box32 {
    let mut b = Box32::EMPTY;
    for p in prims {
        b.grow(&p.min, &p.max);
    }
    b
}
