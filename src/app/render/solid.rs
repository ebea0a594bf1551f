//! A batch of small coloured solids: finger spheres and force arrows, made anew for each picture.

use crate::geom::Vec3;

/// One vertex of a solid: 28 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct SolidVertex {
    position: [f32; 3],
    normal: [f32; 3],
    color: [u8; 4],
}

#[cfg(test)]
impl SolidVertex {
    pub(super) fn position_f64(&self) -> Vec3 {
        Vec3::from_array(self.position.map(f64::from))
    }

    pub(super) fn normal_f64(&self) -> Vec3 {
        Vec3::from_array(self.normal.map(f64::from))
    }
}

/// Triangles of all solids of a picture.
#[derive(Clone, Debug, Default)]
pub struct Solids {
    pub(super) vertices: Vec<SolidVertex>,
    pub(super) indices: Vec<u32>,
    /// How many of the indices, from the first, get a rim over a coloured skin.
    pub(super) n_rimmed: usize,
}

impl Solids {
    /// Forgets all, keeps the memory.
    pub fn clear(&mut self) {
        self.vertices.clear();
        self.indices.clear();
        self.n_rimmed = 0;
    }

    /// Adds a vertex and returns its index.
    pub(super) fn vertex(&mut self, position_mm: Vec3, normal: Vec3, color: [u8; 3]) -> u32 {
        let index = self.vertices.len() as u32;
        self.vertices.push(SolidVertex {
            position: position_mm.to_array().map(|x| x as f32),
            normal: normal.to_array().map(|x| x as f32),
            color: [color[0], color[1], color[2], 255],
        });
        index
    }

    /// Adds a quad a-b-c-d, counter-clockwise seen from outside.
    pub(super) fn quad(&mut self, a: u32, b: u32, c: u32, d: u32) {
        self.indices.extend([a, b, c, a, c, d]);
    }
}
