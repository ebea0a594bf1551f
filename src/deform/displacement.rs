//! The drawn skin's offset from the rest surface.

use crate::geom::Vec3;
use crate::surface::Surface;

/// Where every vertex of the drawn skin is against the rest surface, its normal, and what the last update changed.
///
/// A vertex has *moved* when its offset is not zero; it was *displaced* by the last update when its offset changed, and
/// *touched* when its offset or its normal did: the touched ones are all that must be drawn anew. A vertex number must be
/// below [`Displacement::n_vertices`].
#[derive(Clone, Debug, Default)]
pub struct Displacement {
    pub(super) offsets_mm: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    pub(super) moved: Vec<u32>,
    pub(super) touched: Vec<u32>,
    pub(super) updates: u64,
}

impl Displacement {
    /// The surface at rest.
    pub fn at_rest(surface: &Surface) -> Self {
        Self {
            offsets_mm: vec![Vec3::ZERO; surface.positions().len()],
            normals: surface.normals().to_vec(),
            ..Self::default()
        }
    }

    /// Number of vertices of the surface it was made for.
    pub fn n_vertices(&self) -> usize {
        self.offsets_mm.len()
    }

    /// Offset of a vertex from rest, mm.
    pub fn offset_mm(&self, vertex: u32) -> Vec3 {
        self.offsets_mm[vertex as usize]
    }

    /// Unit normal of a vertex of the deformed surface.
    pub fn normal(&self, vertex: u32) -> Vec3 {
        self.normals[vertex as usize]
    }

    /// Unit normals of all vertices of the deformed surface.
    pub fn to_normals(&self) -> Vec<Vec3> {
        (0..self.n_vertices() as u32)
            .map(|v| self.normal(v))
            .collect()
    }

    /// Position of a vertex of the deformed surface, mm.
    pub fn position(&self, surface: &Surface, vertex: u32) -> Vec3 {
        surface.positions()[vertex as usize] + self.offset_mm(vertex)
    }

    /// Positions of all vertices of the deformed surface, mm.
    pub fn to_positions(&self, surface: &Surface) -> Vec<Vec3> {
        (0..self.n_vertices() as u32)
            .map(|v| self.position(surface, v))
            .collect()
    }

    /// The vertices with a non-zero offset, in an order that is the same every time.
    pub fn moved(&self) -> impl Iterator<Item = u32> + '_ {
        self.moved.iter().copied()
    }

    /// Number of vertices with a non-zero offset.
    pub fn n_moved(&self) -> usize {
        self.moved.len()
    }

    /// The vertices whose offset or normal changed in the last update, in an order that is the same every time.
    pub fn touched(&self) -> impl Iterator<Item = u32> + '_ {
        self.touched.iter().copied()
    }

    /// Number of vertices touched by the last update.
    pub fn n_touched(&self) -> usize {
        self.touched.len()
    }

    /// Number of updates so far: who follows the changes can tell that it missed some.
    pub fn updates(&self) -> u64 {
        self.updates
    }

    /// Puts one vertex somewhere else, by hand. It is the only one touched.
    pub fn put(&mut self, vertex: u32, offset_mm: Vec3, normal: Vec3) {
        self.updates += 1;
        self.offsets_mm[vertex as usize] = offset_mm;
        self.normals[vertex as usize] = normal;
        self.moved.retain(|&v| v != vertex);
        if offset_mm != Vec3::ZERO {
            self.moved.push(vertex);
        }
        self.touched = vec![vertex];
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
        24 * (self.offsets_mm.capacity() + self.normals.capacity())
            + 4 * (self.moved.capacity() + self.touched.capacity())
    }
}
