//! The built-in back: a life-size human back at any requested triangle count.

use super::RawMesh;
use crate::geom::Vec3;

/// How the back is made.
#[derive(Clone, Debug, PartialEq)]
pub struct BackOptions {
    /// Number of triangles asked for; the mesh has as near to it as the filling allows.
    pub triangles: usize,
}

impl Default for BackOptions {
    fn default() -> Self {
        Self { triangles: 2962 }
    }
}

/// Makes the built-in back.
pub fn make(options: &BackOptions) -> RawMesh {
    let n = ((options.triangles as f64 / 2.0).sqrt() as usize).max(2);
    let mut mesh = RawMesh::default();
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (
                -175.0 + 350.0 * i as f64 / n as f64,
                480.0 * j as f64 / n as f64,
            );
            mesh.positions
                .push(Vec3::new(x, y, 100.0 * (1.0 - (x / 200.0) * (x / 200.0))));
        }
    }
    let at = |i: usize, j: usize| (j * (n + 1) + i) as u32;
    for j in 0..n {
        for i in 0..n {
            mesh.triangles
                .push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            mesh.triangles
                .push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    mesh
}
