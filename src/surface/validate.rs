//! What is wrong with a mesh, what of it can be repaired, and what is refused.

use super::RawMesh;
use std::fmt;

/// Why a mesh is refused. Each names the element.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// No triangle is left to touch.
    #[error("the mesh has no triangles; at least one is needed")]
    Empty,
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} has a coordinate that is not finite ({value}); all must be finite")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
        /// The offending coordinate.
        value: f64,
    },
    /// A corner names a vertex that does not exist.
    #[error("triangle {triangle} names vertex {vertex}; the mesh has vertices 0 to {last}")]
    IndexOutOfRange {
        /// Index of the triangle.
        triangle: usize,
        /// The index it names.
        vertex: u64,
        /// The highest index allowed.
        last: usize,
    },
}

/// Something found and repaired or tolerated.
#[derive(Clone, Debug, PartialEq)]
pub enum Defect {}

impl fmt::Display for Defect {
    fn fmt(&self, _f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {}
    }
}

/// What validation found and did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// In the order found.
    pub defects: Vec<Defect>,
}

/// Checks `raw`, repairs what can be repaired and lists it.
pub(super) fn repair(raw: RawMesh) -> Result<(RawMesh, Report), MeshError> {
    if raw.triangles.is_empty() {
        return Err(MeshError::Empty);
    }
    for (vertex, p) in raw.positions.iter().enumerate() {
        if let Some(value) = p.to_array().into_iter().find(|x| !x.is_finite()) {
            return Err(MeshError::NotFinite { vertex, value });
        }
    }
    for (triangle, corners) in raw.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= raw.positions.len()) {
            let last = raw.positions.len().saturating_sub(1);
            return Err(MeshError::IndexOutOfRange {
                triangle,
                vertex: vertex.into(),
                last,
            });
        }
    }
    Ok((raw, Report::default()))
}
