//! The drawn skin's offset from the rest surface.

use super::blocks::{Block, bits, blocks_of, place, vertex};
use super::patches::Patches;
use crate::geom::Vec3;
use crate::surface::Surface;
use std::sync::Arc;

/// Where every vertex of the drawn skin is against the rest surface, its normal, and what the last update changed.
///
/// A vertex has *moved* when its offset is not zero; it was *displaced* by the last update when its offset changed, and
/// *touched* when its offset or its normal did: the touched ones are all that must be drawn anew. A vertex number must be
/// below [`Displacement::n_vertices`]. Lists of vertices ascend.
#[derive(Clone, Debug, Default)]
pub struct Displacement {
    n_vertices: usize,
    pub(super) offsets_mm: Vec<Block>,
    pub(super) normals: Vec<Block>,
    /// Per block.
    pub(super) moved: Vec<u64>,
    /// The blocks in which something has moved.
    pub(super) moved_in: Vec<u32>,
    pub(super) changes: Vec<Change>,
    pub(super) updates: u64,
    /// Those of the model that made it.
    pub(super) patches: Option<Arc<Patches>>,
}

/// What the last update changed among 64 vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change {
    pub block: u32,
    /// Offset changed.
    pub displaced: u64,
    /// Offset or normal changed.
    pub touched: u64,
}

impl Displacement {
    /// The surface at rest.
    pub fn at_rest(surface: &Surface) -> Self {
        let n_vertices = surface.positions().len();
        let normals = blocks_of(surface.normals(), Vec3::ZERO);
        Self {
            n_vertices,
            offsets_mm: vec![Block::ZERO; normals.len()],
            moved: vec![0; normals.len()],
            normals,
            ..Self::default()
        }
    }

    /// Number of vertices of the surface it was made for.
    pub fn n_vertices(&self) -> usize {
        self.n_vertices
    }

    /// Offset of a vertex from rest, mm.
    #[inline]
    pub fn offset_mm(&self, vertex: u32) -> Vec3 {
        self.offsets_mm[vertex as usize / 64].get(vertex as usize % 64)
    }

    /// Unit normal of a vertex of the deformed surface.
    #[inline]
    pub fn normal(&self, vertex: u32) -> Vec3 {
        self.normals[vertex as usize / 64].get(vertex as usize % 64)
    }

    /// Unit normals of all vertices of the deformed surface.
    pub fn to_normals(&self) -> Vec<Vec3> {
        (0..self.n_vertices as u32)
            .map(|v| self.normal(v))
            .collect()
    }

    /// Position of a vertex of the deformed surface, mm.
    #[inline]
    pub fn position(&self, surface: &Surface, vertex: u32) -> Vec3 {
        surface.positions()[vertex as usize] + self.offset_mm(vertex)
    }

    /// Positions of all vertices of the deformed surface, mm.
    pub fn to_positions(&self, surface: &Surface) -> Vec<Vec3> {
        (0..self.n_vertices as u32)
            .map(|v| self.position(surface, v))
            .collect()
    }

    /// The vertices with a non-zero offset.
    pub fn moved(&self) -> impl Iterator<Item = u32> + '_ {
        self.moved_words()
            .flat_map(|(block, word)| bits(word).map(move |i| vertex(block, i)))
    }

    /// Number of vertices with a non-zero offset.
    pub fn n_moved(&self) -> usize {
        self.moved_words()
            .map(|(_, word)| word.count_ones() as usize)
            .sum()
    }

    /// The vertices whose offset or normal changed in the last update.
    pub fn touched(&self) -> impl Iterator<Item = u32> + '_ {
        self.changes
            .iter()
            .flat_map(|c| bits(c.touched).map(move |i| vertex(c.block, i)))
    }

    /// Number of vertices touched by the last update.
    pub fn n_touched(&self) -> usize {
        let touched = self.changes.iter().map(|c| c.touched.count_ones() as usize);
        touched.sum()
    }

    /// The touched vertices in words: the first vertex of 64, a multiple of that, and a bit for each of them.
    pub fn touched_words(&self) -> impl Iterator<Item = (u32, u64)> + '_ {
        let touched = self.changes.iter().filter(|c| c.touched != 0);
        touched.map(|c| (vertex(c.block, 0), c.touched))
    }

    /// Number of updates so far: who follows the changes can tell that it missed some.
    pub fn updates(&self) -> u64 {
        self.updates
    }

    /// Puts one vertex somewhere else, by hand. It is the only one touched.
    pub fn put(&mut self, vertex: u32, offset_mm: Vec3, normal: Vec3) {
        let (block, bit) = place(vertex);
        let i = vertex as usize % 64;
        self.updates += 1;
        self.offsets_mm[block as usize].set(i, offset_mm);
        self.normals[block as usize].set(i, normal);
        let moved = self.moved[block as usize] & !bit;
        self.moved[block as usize] = moved | if offset_mm == Vec3::ZERO { 0 } else { bit };
        if let Err(at) = self.moved_in.binary_search(&block) {
            self.moved_in.insert(at, block);
        }
        self.changes.clear();
        self.changes.push(Change {
            block,
            displaced: bit,
            touched: bit,
        });
    }

    /// Where a point of the rest surface on triangle `t`, mm, has gone on the deformed one: the place to draw a finger at,
    /// given the triangle and anchor of its contact.
    ///
    /// The point is first brought to the closest point of the triangle. A triangle that does not exist, or a point that is
    /// not finite, gives the point back.
    pub fn carried_point(&self, surface: &Surface, t: u32, point_mm: Vec3) -> Vec3 {
        if (t as usize) < surface.triangles().len() && point_mm.is_finite() {
            let at = surface.triangle(t).closest_point(point_mm);
            self.carried(surface, t, at.barycentric)
        } else {
            point_mm
        }
    }

    /// A point of triangle `t` carried along with the deformed surface, mm; `barycentric` weighs its corners.
    pub fn carried(&self, surface: &Surface, t: u32, barycentric: [f64; 3]) -> Vec3 {
        let corners = surface.triangles()[t as usize];
        (0..3)
            .map(|i| self.position(surface, corners[i]) * barycentric[i])
            .sum()
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        size_of::<Block>() * (self.offsets_mm.capacity() + self.normals.capacity())
            + 8 * self.moved.capacity()
            + 4 * self.moved_in.capacity()
            + size_of::<Change>() * self.changes.capacity()
    }

    /// Blocks in which something has moved, and what.
    fn moved_words(&self) -> impl Iterator<Item = (u32, u64)> + '_ {
        let blocks = self.moved_in.iter();
        blocks.map(|&block| (block, self.moved[block as usize]))
    }
}
