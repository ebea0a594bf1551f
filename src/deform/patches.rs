//! The surface cut into small connected patches, so that a dent is found and filled patch by patch.
//!
//! A dent is wide (tens of thousands of vertices on a fine mesh) and smooth: nearly all of its patches lie inside it as a
//! whole. Such a patch needs one look at its box instead of one at each vertex, and its vertices lie together in memory.
//! Only patches on the outline are walked vertex by vertex. What is found does not depend on how the surface was cut.

use crate::geom::{Aabb, Vec3};
use crate::surface::Surface;

/// Most vertices a patch may have: one bit each in a word.
pub(super) const PATCH: usize = 64;

/// Vertices a patch should have, so that most cells of the grid stay below [`PATCH`] and become one patch.
const USUAL: f64 = 40.0;

const NONE: u32 = u32::MAX;

/// The patches of one surface. Made once per surface: some 0.1 µs per vertex.
#[derive(Clone, Debug, Default)]
pub struct Patches {
    hash: [u8; 32],
    /// Per vertex: patch · 64 + its number in the patch.
    places: Vec<u32>,
    /// Per patch and one more, for its end.
    heads: Vec<Head>,
    vertices: Vec<u32>,
    halos: Vec<u32>,
    /// Places of `halos`.
    halo_places: Vec<u32>,
    beside: Vec<u32>,
    /// Per vertex in the order of the patches: corners of its ring.
    ring_lengths: Vec<u8>,
    ring_corners: Vec<u8>,
}

/// All that a search asks of a patch, in one cache line.
#[derive(Clone, Copy, Debug)]
struct Head {
    bounds: Aabb,
    /// Where its vertices, its halo, the patches beside it and its rings start.
    vertices: u32,
    halo: u32,
    beside: u32,
    rings: u32,
}

/// Points a patch and its halo may have, as rings number them by a byte.
pub(super) const NEARBY: usize = 256;

/// One patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch<'a> {
    /// Its vertices, connected among themselves.
    pub vertices: &'a [u32],
    /// The vertices of other patches next to them.
    pub halo: &'a [u32],
    halo_places: &'a [u32],
    /// The patches of the halo, the one nearest in memory last.
    pub beside: &'a [u32],
    /// Box round its vertices.
    pub bounds: &'a Aabb,
    ring_lengths: &'a [u8],
    ring_corners: &'a [u8],
}

impl Patch<'_> {
    /// Patches and bits of the halo.
    pub fn halo_places(&self) -> impl Iterator<Item = (u32, u64)> + use<'_> {
        self.halo_places.iter().map(|&place| split(place))
    }

    /// The vertex that a corner of a ring stands for.
    pub fn near(&self, corner: u8) -> u32 {
        let corner = corner as usize;
        let inner = self.vertices.get(corner);
        inner
            .copied()
            .unwrap_or_else(|| self.halo[corner - self.vertices.len()])
    }

    /// Patch and bit of a vertex of the halo.
    pub fn halo_place(&self, i: usize) -> (u32, u64) {
        split(self.halo_places[i])
    }

    /// The rings round its vertices, in their order.
    ///
    /// A ring is a closed polygon round the triangles of a vertex, counter-clockwise seen from outside. Its corners count
    /// through the vertices and then the halo; on the rim of the surface the vertex itself is one of them. Empty for a
    /// vertex where several fans of triangles meet, or too many.
    pub fn rings(&self) -> impl Iterator<Item = &'_ [u8]> {
        let mut rest = self.ring_corners;
        self.ring_lengths.iter().map(move |&n| {
            let (ring, after) = rest.split_at(n as usize);
            rest = after;
            ring
        })
    }

    /// Its vertices and then its halo.
    pub fn nearby(&self) -> impl Iterator<Item = &u32> + Clone {
        self.vertices.iter().chain(self.halo)
    }

    /// A word with the bits of all its vertices.
    pub fn all(&self) -> u64 {
        u64::MAX >> (PATCH - self.vertices.len())
    }
}

fn split(place: u32) -> (u32, u64) {
    (place / PATCH as u32, 1 << (place % PATCH as u32))
}

impl Patches {
    /// Cuts the surface.
    pub fn new(surface: &Surface) -> Self {
        let mut patches = Self {
            hash: surface.hash(),
            places: vec![NONE; surface.positions().len()],
            ..Self::default()
        };
        patches.cut(surface);
        patches.surround(surface);
        patches.add_rings(surface);
        patches
    }

    /// Whether these are the patches of `surface`.
    pub fn are_of(&self, surface: &Surface) -> bool {
        self.hash == surface.hash() && self.places.len() == surface.positions().len()
    }

    /// Number of patches.
    pub fn len(&self) -> usize {
        self.heads.len().saturating_sub(1)
    }

    /// Whether the surface has no vertex.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        let lists = [
            &self.places,
            &self.vertices,
            &self.halos,
            &self.halo_places,
            &self.beside,
        ];
        lists.iter().map(|list| 4 * list.len()).sum::<usize>()
            + size_of_val(&self.heads[..])
            + self.ring_lengths.len()
            + self.ring_corners.len()
    }

    /// Patch of a vertex, and its bit in the words of that patch.
    #[inline]
    pub(super) fn place(&self, v: u32) -> (u32, u64) {
        split(self.places[v as usize])
    }

    #[inline]
    pub(super) fn patch(&self, p: u32) -> Patch<'_> {
        let [head, next] = [p, p + 1].map(|p| &self.heads[p as usize]);
        Patch {
            vertices: &self.vertices[head.vertices as usize..next.vertices as usize],
            halo: &self.halos[head.halo as usize..next.halo as usize],
            beside: &self.beside[head.beside as usize..next.beside as usize],
            bounds: &head.bounds,
            ring_lengths: &self.ring_lengths[head.vertices as usize..next.vertices as usize],
            ring_corners: &self.ring_corners[head.rings as usize..next.rings as usize],
            halo_places: &self.halo_places[head.halo as usize..next.halo as usize],
        }
    }

    /// Fills cells of a grid over the adjacency: what hangs together in a cell is a patch, cut again where it is too many.
    fn cut(&mut self, surface: &Surface) {
        let cells = cells(surface);
        let mut found = Vec::with_capacity(PATCH);
        for seed in 0..surface.positions().len() as u32 {
            if self.places[seed as usize] != NONE {
                continue;
            }
            let first = (self.heads.len() * PATCH) as u32;
            found.clear();
            found.push(seed);
            self.places[seed as usize] = first;
            let mut head = 0;
            while let Some(&v) = found.get(head) {
                head += 1;
                for &n in surface.topology().neighbours(v) {
                    if found.len() == PATCH {
                        break;
                    }
                    let free = self.places[n as usize] == NONE;
                    if free && cells[n as usize] == cells[seed as usize] {
                        self.places[n as usize] = first;
                        found.push(n);
                    }
                }
            }
            found.sort_unstable();
            for (number, &v) in found.iter().enumerate() {
                self.places[v as usize] = first + number as u32;
            }
            let positions = found.iter().map(|&v| surface.positions()[v as usize]);
            self.push_head(Aabb::of_points(positions));
            self.vertices.extend_from_slice(&found);
        }
        self.push_head(Aabb::EMPTY);
    }

    fn push_head(&mut self, bounds: Aabb) {
        self.heads.push(Head {
            bounds,
            vertices: self.vertices.len() as u32,
            halo: 0,
            beside: 0,
            rings: 0,
        });
    }

    /// Lists what lies next to every patch.
    fn surround(&mut self, surface: &Surface) {
        let (mut halo, mut beside) = (Vec::new(), Vec::new());
        for p in 0..self.len() as u32 {
            halo.clear();
            let [from, to] = [p, p + 1].map(|p| self.heads[p as usize].vertices as usize);
            for &v in &self.vertices[from..to] {
                let beyond = surface.topology().neighbours(v).iter();
                halo.extend(beyond.filter(|&&n| self.place(n).0 != p));
            }
            halo.sort_unstable();
            halo.dedup();
            beside.clear();
            beside.extend(halo.iter().map(|&n| self.place(n).0));
            beside.sort_unstable();
            beside.dedup();
            // A search goes on with the last one first, and so runs through memory in strips.
            beside.sort_by_key(|&q: &u32| std::cmp::Reverse(q.abs_diff(p)));
            self.halos.extend_from_slice(&halo);
            let places = halo.iter().map(|&v| self.places[v as usize]);
            self.halo_places.extend(places);
            self.beside.extend_from_slice(&beside);
            let next = &mut self.heads[p as usize + 1];
            next.halo = self.halos.len() as u32;
            next.beside = self.beside.len() as u32;
        }
    }

    /// Number of the first vertex of a patch, counted in the order of the patches.
    pub(super) fn first(&self, p: u32) -> usize {
        self.heads[p as usize].vertices as usize
    }

    fn add_rings(&mut self, surface: &Surface) {
        let (mut corners, mut lengths, mut ends) = (Vec::new(), Vec::new(), Vec::new());
        for p in 0..self.len() as u32 {
            let (vertices, halo) = self.patch_without_rings(p);
            let number = |v: u32| {
                let place = self.places[v as usize];
                if place / PATCH as u32 == p {
                    return u8::try_from(place % PATCH as u32).ok();
                }
                let number = halo.binary_search(&v).ok()?;
                u8::try_from(vertices.len() + number).ok()
            };
            for &v in vertices {
                let before = corners.len();
                if !push_ring(surface, v, number, &mut corners) {
                    corners.truncate(before);
                }
                lengths.push((corners.len() - before) as u8);
            }
            ends.push(corners.len() as u32);
        }
        for (head, end) in self.heads[1..].iter_mut().zip(ends) {
            head.rings = end;
        }
        (self.ring_corners, self.ring_lengths) = (corners, lengths);
    }

    fn patch_without_rings(&self, p: u32) -> (&[u32], &[u32]) {
        let [head, next] = [p, p + 1].map(|p| self.heads[p as usize]);
        (
            &self.vertices[head.vertices as usize..next.vertices as usize],
            &self.halos[head.halo as usize..next.halo as usize],
        )
    }
}

/// Appends the ring of `v`; false, with anything appended, where it has none.
fn push_ring(
    surface: &Surface,
    v: u32,
    number: impl Fn(u32) -> Option<u8>,
    rings: &mut Vec<u8>,
) -> bool {
    let neighbours = surface.topology().neighbours(v);
    let fan = surface.topology().triangles_of(v);
    let open = neighbours.len() == fan.len() + 1;
    let corners = neighbours.len() + usize::from(open);
    if fan.is_empty() || corners > u8::MAX as usize || (!open && neighbours.len() != fan.len()) {
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
            Some(number) => rings.push(number),
            None => return false,
        }
    }
    true
}

/// Cell of a cubic grid for every vertex, with some [`USUAL`] vertices to a cell.
fn cells(surface: &Surface) -> Vec<[i32; 3]> {
    let n = surface.positions().len().max(1) as f64;
    let area: f64 = (0..surface.triangles().len() as u32)
        .map(|t| surface.triangle(t).area_mm2())
        .sum();
    let edge_mm = (area / n * USUAL).sqrt();
    let per_mm = if edge_mm > 0.0 { 1.0 / edge_mm } else { 1.0 };
    let low = surface.bounds().min;
    // Casting saturates: a cell far off is one of the outermost.
    let cell = |p: &Vec3| ((*p - low) * per_mm).to_array().map(|c| c as i32);
    surface.positions().iter().map(cell).collect()
}

/// Numbers of the bits set, ascending.
pub(super) fn bits(mut word: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let i = word.trailing_zeros() as usize;
        word &= word.wrapping_sub(1);
        (i < 64).then_some(i)
    })
}
