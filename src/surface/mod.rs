//! The skin: a triangle mesh that has passed validation, with its adjacency, and where it comes from.
//!
//! [`RawMesh`] is what a file or a generator hands over: anything at all. [`Surface`] is what the rest of the program
//! sees: finite, indexed within range, consistently oriented, manifold. [`Surface::new`] is the only door between them.

pub mod back;
pub mod io;
mod topology;
mod validate;

use crate::geom::{Aabb, Triangle, Vec3, unit_or};
use sha2::{Digest, Sha256};

pub use topology::{RIM, Topology};
pub use validate::{Defect, MeshError, Report};

/// Triangles as they come from outside, unchecked. Positions in mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawMesh {
    /// Vertex positions, mm.
    pub positions: Vec<Vec3>,
    /// Corner indices into `positions`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// The validated haptic surface. It never deforms (Ji 2008, 2.3): the drawn deformation is kept apart from it.
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
        let (mesh, report) = validate::repair(raw)?;
        let topology = Topology::new(mesh.positions.len(), &mesh.triangles);
        let normals = vertex_normals(&mesh.positions, &mesh.triangles);
        let bounds = Aabb::of_points(mesh.positions.iter().copied());
        let hash = hash_of(&mesh);
        let surface = Self {
            positions: mesh.positions,
            triangles: mesh.triangles,
            normals,
            topology,
            bounds,
            hash,
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
pub fn vertex_normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for corners in triangles {
        let p = corners.map(|v| positions[v as usize]);
        let n = unit_or((p[1] - p[0]).cross(p[2] - p[0]), Vec3::ZERO);
        for i in 0..3 {
            let (e, f) = (p[(i + 1) % 3] - p[i], p[(i + 2) % 3] - p[i]);
            let angle = libm::atan2(e.cross(f).length(), e.dot(f));
            sums[corners[i] as usize] += n * angle;
        }
    }
    sums.into_iter().map(|n| unit_or(n, Vec3::Z)).collect()
}

fn hash_of(mesh: &RawMesh) -> [u8; 32] {
    let mut hasher = Sha256::new();
    hasher.update((mesh.positions.len() as u64).to_le_bytes());
    hasher.update((mesh.triangles.len() as u64).to_le_bytes());
    let mut block = Vec::with_capacity(24 * 1024);
    for chunk in mesh.positions.chunks(1024) {
        block.clear();
        for p in chunk {
            for x in p.to_array() {
                block.extend_from_slice(&x.to_le_bytes());
            }
        }
        hasher.update(&block);
    }
    for chunk in mesh.triangles.chunks(2048) {
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
