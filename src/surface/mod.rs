//! The skin: a triangle mesh that has passed validation, with its adjacency, and where it comes from.
//!
//! [`RawMesh`] is what a file or a generator hands over: anything at all. [`Surface`] is what the rest of the program
//! sees: finite, indexed within range, consistently oriented, manifold, numbered so that neighbours are near in memory.
//! [`Surface::new`] is the only door between them.

pub mod back;
mod check;
mod edges;
pub mod io;
mod order;
pub mod primitives;
pub mod solids;
mod topology;
pub mod torture;
mod validate;

use crate::geom::{Aabb, Triangle, Vec3, unit_or};
use sha2::{Digest, Sha256};

pub use topology::{RIM, Topology};
pub use validate::{
    Component, Defect, Edge, Element, Found, MAX_COORDINATE_MM, MeshError, Report, RimLoop,
};

/// Triangles as they come from outside, unchecked. Positions in mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawMesh {
    /// Vertex positions, mm.
    pub positions: Vec<Vec3>,
    /// Corner indices into `positions`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// The validated haptic surface. It never deforms (Ji 2008, 2.3): the drawn deformation is kept apart from it.
///
/// Triangles are numbered along a space-filling curve and vertices by first use, not as in the file they come from; only
/// a [`Report`] names elements as the file does.
#[derive(Clone, Debug)]
pub struct Surface {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    normals: Vec<Vec3>,
    topology: Topology,
    bounds: Aabb,
    hash: [u8; 32],
}

impl Surface {
    /// Checks and repairs `raw`, then builds adjacency and normals.
    ///
    /// # Errors
    /// What cannot be repaired, naming the element: see [`MeshError`].
    pub fn new(raw: RawMesh) -> Result<(Self, Report), MeshError> {
        let validate::Repaired {
            positions,
            triangles,
            topology,
            report,
        } = validate::repair(raw)?;
        let surface = Self {
            normals: vertex_normals(&positions, &triangles),
            bounds: Aabb::of_points(positions.iter().copied()),
            hash: hash_of(&positions, &triangles),
            positions,
            triangles,
            topology,
        };
        Ok((surface, report))
    }

    /// Vertex positions, mm.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Corner indices of every triangle, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Unit normals at the vertices, weighted by the angle of each triangle at the vertex.
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Who is next to whom.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// The smallest box around the surface, mm.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// SHA-256 over positions and triangles: two surfaces with one hash give the same forces bit for bit.
    pub fn hash(&self) -> [u8; 32] {
        self.hash
    }

    /// Corners of triangle `t`, mm.
    pub fn triangle(&self, t: u32) -> Triangle {
        let [a, b, c] = self.triangles[t as usize];
        Triangle {
            a: self.positions[a as usize],
            b: self.positions[b as usize],
            c: self.positions[c as usize],
        }
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.positions[..])
            + size_of_val(&self.triangles[..])
            + size_of_val(&self.normals[..])
            + self.topology.bytes()
    }
}

/// Angle-weighted vertex normals (Thürmer & Wüthrich 1998), so that they do not depend on how a face is cut.
///
/// +z where the triangles cancel out. A triangle without area counts for nothing.
pub fn vertex_normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for corners in triangles {
        let [a, b, c] = corners.map(|v| positions[v as usize]);
        let (ab, ac, bc) = (b - a, c - a, c - b);
        let area_normal = ab.cross(ac);
        let n = unit_or(area_normal, Vec3::ZERO);
        let doubled_area = area_normal.length();
        let at_a = libm::atan2(doubled_area, ab.dot(ac));
        let at_b = libm::atan2(doubled_area, -ab.dot(bc));
        let at_c = std::f64::consts::PI - at_a - at_b;
        for (&v, angle) in corners.iter().zip([at_a, at_b, at_c]) {
            sums[v as usize] += n * angle;
        }
    }
    sums.into_iter().map(|n| unit_or(n, Vec3::Z)).collect()
}

fn hash_of(positions: &[Vec3], triangles: &[[u32; 3]]) -> [u8; 32] {
    let mut hasher = Sha256::new();
    hasher.update((positions.len() as u64).to_le_bytes());
    hasher.update((triangles.len() as u64).to_le_bytes());
    let mut block = Vec::with_capacity(24 * 1024);
    for chunk in positions.chunks(1024) {
        block.clear();
        for p in chunk {
            for x in p.to_array() {
                block.extend_from_slice(&x.to_le_bytes());
            }
        }
        hasher.update(&block);
    }
    for chunk in triangles.chunks(2048) {
        block.clear();
        for t in chunk {
            for i in t {
                block.extend_from_slice(&i.to_le_bytes());
            }
        }
        hasher.update(&block);
    }
    hasher.finalize().into()
}
