//! The surface in blocks of 64 vertices, so that a dent is found and filled block by block.
//!
//! Vertices are numbered along a space-filling curve, so that 64 in a row are a small patch of skin. A dent is wide (tens of
//! thousands of vertices on a fine mesh) and smooth: nearly all of its patches lie inside it as a whole. Such a patch needs
//! one look at its box instead of one at each vertex, and its vertices lie together in memory. What is found does not
//! depend on how the surface was cut.

use super::blocks::{BLOCK, Block, bits, blocks_of, place, vertex};
use crate::geom::{Aabb, Vec3};
use crate::surface::Surface;

/// Points a patch and its halo may have in its rings, as these number them by a byte.
pub(super) const NEARBY: usize = 256;

/// Corners of a ring that every vertex has a place for.
pub(super) const CORNERS: usize = 6;

/// The patches of one surface. Made once per surface: some 0.1 µs per vertex.
#[derive(Clone, Debug, Default)]
pub struct Patches {
    hash: [u8; 32],
    n_vertices: usize,
    positions: Vec<Block>,
    /// Per patch and one more, for its end.
    heads: Vec<Head>,
    parts: Vec<u64>,
    beside: Vec<Beside>,
    halos: Vec<u32>,
    /// Per vertex of `halos`: its neighbours within the patch.
    halo_adjacency: Vec<u64>,
    adjacency: Vec<[u64; BLOCK]>,
    rings: Vec<Rings>,
    longer: Vec<Longer>,
}

/// What a search asks of a patch first, and where its lists start.
#[derive(Clone, Copy, Debug)]
struct Head {
    bounds: Aabb,
    longest_edge_mm: f64,
    without_ring: u64,
    parts: u32,
    beside: u32,
    halo: u32,
    longer: u32,
}

/// Another patch next to one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beside {
    pub block: u32,
    /// Twice the place of its first vertex in the halo, and 1 where `theirs` hang together within it.
    halo_and_part: u32,
    /// The vertices of this patch that have an edge to that one.
    pub mine: u64,
    /// The vertices of that patch that have an edge to this one: so many in the halo.
    pub theirs: u64,
}

impl Beside {
    /// Whether `theirs` hang together within that patch.
    #[inline]
    pub fn is_one_part(&self) -> bool {
        self.halo_and_part & 1 == 1
    }

    /// Where its vertices are in the halo.
    #[inline]
    pub fn in_halo(&self) -> std::ops::Range<usize> {
        let from = (self.halo_and_part / 2) as usize;
        from..from + self.theirs.count_ones() as usize
    }
}

/// First six corners of the ring round each vertex of a patch. A shorter ring repeats its last one.
pub(super) type Rings = [[u8; BLOCK]; CORNERS];

/// Two more corners of the ring round a vertex with more than six, with its first and the one before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Longer {
    pub vertex: u8,
    pub first: u8,
    pub before: u8,
    pub next: [u8; 2],
}

/// One patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch<'a> {
    /// Box round its vertices.
    pub bounds: &'a Aabb,
    /// Length of the longest edge at its vertices, mm.
    pub longest_edge_mm: f64,
    /// A word with the bits of all its vertices.
    pub all: u64,
    /// What hangs together by edges within the patch.
    pub parts: &'a [u64],
    pub beside: &'a [Beside],
    /// The vertices of other patches next to its own.
    pub halo: &'a [u32],
    pub halo_adjacency: &'a [u64],
    /// Per vertex: its neighbours within the patch.
    pub adjacency: &'a [u64; BLOCK],
    /// A ring is a closed polygon round the triangles of a vertex, counter-clockwise seen from outside. Its corners count
    /// the vertices and then, from 64 on, the halo; on the rim of the surface the vertex itself is one of them.
    pub rings: &'a Rings,
    pub longer: &'a [Longer],
    /// Number of the first of `longer` among those of all patches.
    pub longer_from: usize,
    /// The vertices without a ring: where several fans of triangles meet, or too many.
    pub without_ring: u64,
}

impl Patch<'_> {
    /// What of `within` can be reached from `found` over edges within the patch and `within`.
    #[inline]
    pub fn reached(&self, within: u64, found: u64) -> u64 {
        if within == self.all {
            let met = self.parts.iter().filter(|&part| part & found != 0);
            return met.fold(0, |reached, part| reached | part);
        }
        let (mut reached, mut done) = (found & within, 0);
        while reached != done {
            let new = reached & !done;
            done = reached;
            reached |= self.next_to(new) & within;
        }
        reached
    }

    /// The neighbours of some vertices in a patch beside.
    #[inline]
    pub fn across(&self, beside: &Beside, vertices: u64) -> u64 {
        if vertices & beside.mine == beside.mine {
            return beside.theirs;
        }
        let mut met = 0;
        for k in beside.in_halo() {
            if self.halo_adjacency[k] & vertices != 0 {
                met |= place(self.halo[k]).1;
            }
        }
        met
    }

    /// The neighbours of some vertices within the patch.
    #[inline]
    pub fn next_to(&self, vertices: u64) -> u64 {
        bits(vertices).fold(0, |met, i| met | self.adjacency[i])
    }
}

impl Patches {
    /// Cuts the surface.
    pub fn new(surface: &Surface) -> Self {
        let mut patches = Self {
            hash: surface.hash(),
            n_vertices: surface.positions().len(),
            positions: blocks_of(surface.positions(), Vec3::NAN),
            ..Self::default()
        };
        let mut halo = Vec::new();
        for p in 0..patches.len() as u32 {
            patches.heads.push(patches.head(surface, p));
            patches.surround(surface, p, &mut halo);
            patches.add_rings(surface, p, &halo);
        }
        patches.heads.push(Head {
            bounds: Aabb::EMPTY,
            longest_edge_mm: 0.0,
            ..patches.ends()
        });
        for i in 0..patches.beside.len() {
            let Beside { block, theirs, .. } = patches.beside[i];
            let parts = patches.patch(block).parts;
            let one_part = parts.iter().any(|part| theirs & !part == 0);
            patches.beside[i].halo_and_part |= u32::from(one_part);
        }
        patches.trim();
        patches
    }

    /// Gives back what the lists took to grow: they stay as they are from here on.
    fn trim(&mut self) {
        self.positions.shrink_to_fit();
        self.heads.shrink_to_fit();
        self.parts.shrink_to_fit();
        self.beside.shrink_to_fit();
        self.halos.shrink_to_fit();
        self.halo_adjacency.shrink_to_fit();
        self.adjacency.shrink_to_fit();
        self.rings.shrink_to_fit();
        self.longer.shrink_to_fit();
    }

    /// Whether these are the patches of `surface`.
    pub fn are_of(&self, surface: &Surface) -> bool {
        self.hash == surface.hash() && self.n_vertices == surface.positions().len()
    }

    /// Whether these are the same patches.
    pub(super) fn are_those(&self, other: &Self) -> bool {
        self.hash == other.hash && self.n_vertices == other.n_vertices
    }

    /// Number of patches.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether the surface has no vertex.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.positions[..])
            + size_of_val(&self.heads[..])
            + size_of_val(&self.parts[..])
            + size_of_val(&self.beside[..])
            + size_of_val(&self.halos[..])
            + size_of_val(&self.halo_adjacency[..])
            + size_of_val(&self.adjacency[..])
            + size_of_val(&self.rings[..])
            + size_of_val(&self.longer[..])
    }

    /// Positions of the vertices of a patch at rest, mm; no numbers where it has fewer than 64.
    #[inline(always)]
    pub(super) fn positions(&self, p: u32) -> &Block {
        &self.positions[p as usize]
    }

    /// A word with the bits of all vertices of a patch.
    #[inline(always)]
    pub(super) fn all(&self, p: u32) -> u64 {
        let n = self.n_vertices - (p as usize * BLOCK).min(self.n_vertices);
        u64::MAX >> (BLOCK - n.clamp(1, BLOCK))
    }

    #[inline(always)]
    pub(super) fn patch(&self, p: u32) -> Patch<'_> {
        let [head, next] = [p, p + 1].map(|p| &self.heads[p as usize]);
        Patch {
            bounds: &head.bounds,
            longest_edge_mm: head.longest_edge_mm,
            all: self.all(p),
            parts: &self.parts[head.parts as usize..next.parts as usize],
            beside: &self.beside[head.beside as usize..next.beside as usize],
            halo: &self.halos[head.halo as usize..next.halo as usize],
            halo_adjacency: &self.halo_adjacency[head.halo as usize..next.halo as usize],
            adjacency: &self.adjacency[p as usize],
            rings: &self.rings[p as usize],
            longer: &self.longer[head.longer as usize..next.longer as usize],
            longer_from: head.longer as usize,
            without_ring: head.without_ring,
        }
    }

    /// The vertices of patch `p` that are in a set, or next to one that is. `set` tells its bits in a patch.
    #[inline]
    pub(super) fn grown(&self, p: u32, set: impl Fn(u32) -> u64) -> u64 {
        let patch = self.patch(p);
        let own = set(p);
        if own == patch.all {
            return own;
        }
        let mut grown = own | patch.next_to(own);
        for beside in patch.beside {
            let theirs = set(beside.block) & beside.theirs;
            if theirs == beside.theirs {
                grown |= beside.mine;
            } else if theirs != 0 {
                for k in beside.in_halo() {
                    if theirs & place(patch.halo[k]).1 != 0 {
                        grown |= patch.halo_adjacency[k];
                    }
                }
            }
        }
        grown
    }

    fn vertices(&self, p: u32) -> std::ops::Range<u32> {
        let first = vertex(p, 0);
        first..(first + BLOCK as u32).min(self.n_vertices as u32)
    }

    fn ends(&self) -> Head {
        Head {
            bounds: Aabb::EMPTY,
            longest_edge_mm: 0.0,
            without_ring: 0,
            parts: self.parts.len() as u32,
            beside: self.beside.len() as u32,
            halo: self.halos.len() as u32,
            longer: self.longer.len() as u32,
        }
    }

    fn head(&self, surface: &Surface, p: u32) -> Head {
        let at = |v: u32| surface.positions()[v as usize];
        let edges = self.vertices(p).flat_map(|v| {
            let to = surface.topology().neighbours(v).iter();
            to.map(move |&n| at(v).distance_squared(at(n)))
        });
        Head {
            longest_edge_mm: edges.fold(0.0, f64::max).sqrt(),
            bounds: Aabb::of_points(self.vertices(p).map(at)),
            ..self.ends()
        }
    }

    /// Lists what hangs together in a patch, and what lies next to it; `halo` is left with the latter.
    fn surround(&mut self, surface: &Surface, p: u32, halo: &mut Vec<u32>) {
        halo.clear();
        let mut adjacency = [0; BLOCK];
        let mut beside: Vec<Beside> = Vec::new();
        for v in self.vertices(p) {
            let (_, mine) = place(v);
            for &n in surface.topology().neighbours(v) {
                let (block, theirs) = place(n);
                if block == p {
                    adjacency[v as usize % BLOCK] |= theirs;
                    continue;
                }
                halo.push(n);
                match beside.iter_mut().find(|b| b.block == block) {
                    Some(known) => {
                        known.mine |= mine;
                        known.theirs |= theirs;
                    }
                    None => beside.push(Beside {
                        block,
                        halo_and_part: 0,
                        mine,
                        theirs,
                    }),
                }
            }
        }
        halo.sort_unstable();
        halo.dedup();
        for beside in &mut beside {
            let first = halo.partition_point(|&n| n < vertex(beside.block, 0));
            beside.halo_and_part = 2 * first as u32;
        }
        for &n in halo.iter() {
            let within = surface.topology().neighbours(n).iter();
            let within = within.map(|&v| place(v)).filter(|(block, _)| *block == p);
            self.halo_adjacency
                .push(within.fold(0, |word, (_, bit)| word | bit));
        }
        // A search goes on with the last one first, and so runs through memory in strips.
        beside.sort_by_key(|b| std::cmp::Reverse((b.block.abs_diff(p), b.block)));
        self.adjacency.push(adjacency);
        self.beside.extend_from_slice(&beside);
        self.halos.extend_from_slice(halo);
        let mut left = self.all(p);
        while left != 0 {
            let (mut part, mut grown) = (0, 1 << left.trailing_zeros());
            while part != grown {
                part = grown;
                grown = bits(part).fold(part, |met, i| met | adjacency[i]);
            }
            self.parts.push(part);
            left &= !part;
        }
    }

    fn add_rings(&mut self, surface: &Surface, p: u32, halo: &[u32]) {
        let number = |n: u32| {
            let place = if n / BLOCK as u32 == p {
                n as usize % BLOCK
            } else {
                BLOCK + halo.binary_search(&n).ok()?
            };
            u8::try_from(place).ok()
        };
        let mut rings = [[0; BLOCK]; CORNERS];
        let (mut without_ring, mut ring) = (0, Vec::new());
        for v in self.vertices(p) {
            let (i, bit) = (v as usize % BLOCK, place(v).1);
            ring.clear();
            if !push_ring(surface, v, number, &mut ring) {
                without_ring |= bit;
                continue;
            }
            let last = ring[ring.len() - 1];
            for (k, corners) in rings.iter_mut().enumerate() {
                corners[i] = ring.get(k).copied().unwrap_or(last);
            }
            for k in (CORNERS..ring.len()).step_by(2) {
                self.longer.push(Longer {
                    vertex: i as u8,
                    first: ring[0],
                    before: ring[k - 1],
                    next: [ring[k], ring.get(k + 1).copied().unwrap_or(last)],
                });
            }
        }
        self.rings.push(rings);
        if let Some(head) = self.heads.last_mut() {
            head.without_ring = without_ring;
        }
    }
}

/// Appends the ring of `v`; false, with anything appended, where it has none.
fn push_ring(
    surface: &Surface,
    v: u32,
    number: impl Fn(u32) -> Option<u8>,
    ring: &mut Vec<u8>,
) -> bool {
    let neighbours = surface.topology().neighbours(v);
    let fan = surface.topology().triangles_of(v);
    let open = neighbours.len() == fan.len() + 1;
    if fan.is_empty() || (!open && neighbours.len() != fan.len()) {
        return false;
    }
    let one_fan = fan.iter().enumerate().all(|(i, &t)| {
        let corners = surface.triangles()[t as usize];
        let next = neighbours[(i + 1) % neighbours.len()];
        corners.contains(&neighbours[i]) && corners.contains(&next)
    });
    if !one_fan {
        return false;
    }
    let itself = open.then_some(v);
    for n in itself.iter().chain(neighbours) {
        match number(*n) {
            Some(number) => ring.push(number),
            None => return false,
        }
    }
    true
}
