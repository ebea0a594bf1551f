//! What is laid over the skin: coloured lines and faces in space, and patches of the skin's own triangles.
//!
//! Both are plain values with a number: two with one number are the same, so a picture tells by the number alone whether
//! anything must be uploaded or drawn anew.
#![allow(unsafe_code, reason = "OpenGL calls are unsafe by signature")] // OpenGL is a C interface; see `gl`.

use super::gl::{Program, VertexArray, attribute};
use super::light::Light;
use super::mesh::SkinVertex;
use crate::geom::{Aabb, Vec3};
use crate::surface::Surface;
use eframe::glow::{self, HasContext as _};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

fn next_id() -> u64 {
    static NEXT_ID: AtomicU64 = AtomicU64::new(1);
    NEXT_ID.fetch_add(1, Ordering::Relaxed)
}

/// One vertex of a line or face: 16 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct LayerVertex {
    /// Position, mm.
    pub position: [f32; 3],
    /// Colour, sRGB, and opacity.
    pub color: [u8; 4],
}

/// Lines and faces being gathered for a [`Layer`].
#[derive(Clone, Debug, Default)]
pub struct LayerBuilder {
    lines: Vec<LayerVertex>,
    faces: Vec<LayerVertex>,
}

fn vertex(p: Vec3, color: [u8; 4]) -> LayerVertex {
    LayerVertex {
        position: p.to_array().map(|x| x as f32),
        color,
    }
}

impl LayerBuilder {
    /// Adds a line from `a` to `b`, mm.
    pub fn line(&mut self, a: Vec3, b: Vec3, color: [u8; 4]) {
        self.lines.extend([vertex(a, color), vertex(b, color)]);
    }

    /// Adds the twelve edges of a box.
    pub fn wire_box(&mut self, b: &Aabb, color: [u8; 4]) {
        let corner = |i: usize| {
            Vec3::from_array(std::array::from_fn(|k| {
                if i >> k & 1 == 1 { b.max[k] } else { b.min[k] }
            }))
        };
        for i in 0..8 {
            for k in (0..3).filter(|k| i >> k & 1 == 0) {
                self.line(corner(i), corner(i | 1 << k), color);
            }
        }
    }

    /// Adds the rectangle in which the plane `axis` = `at_mm` cuts a box: its outline and its face.
    pub fn cut(&mut self, b: &Aabb, axis: usize, at_mm: f64, outline: [u8; 4], face: [u8; 4]) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| {
            let mut p = b.min;
            p[axis] = at_mm;
            p[u] = [b.min[u], b.max[u]][i];
            p[v] = [b.min[v], b.max[v]][j];
            p
        });
        for i in 0..4 {
            self.line(corners[i], corners[(i + 1) % 4], outline);
        }
        for i in [0, 1, 2, 0, 2, 3] {
            self.faces.push(vertex(corners[i], face));
        }
    }

    /// The finished layer.
    pub fn finish(mut self) -> Arc<Layer> {
        let n_line_vertices = self.lines.len();
        self.lines.append(&mut self.faces);
        Arc::new(Layer {
            id: next_id(),
            vertices: self.lines,
            n_line_vertices,
        })
    }
}

/// Coloured lines and translucent faces in space. Where the skin hides them they are drawn faintly.
#[derive(Debug)]
pub struct Layer {
    id: u64,
    /// Two per line, then three per face.
    vertices: Vec<LayerVertex>,
    n_line_vertices: usize,
}

impl Layer {
    /// Both ends of every line.
    pub fn lines(&self) -> &[LayerVertex] {
        &self.vertices[..self.n_line_vertices]
    }

    /// Three corners of every face.
    pub fn faces(&self) -> &[LayerVertex] {
        &self.vertices[self.n_line_vertices..]
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.vertices[..])
    }
}

impl PartialEq for Layer {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

/// Triangles of the skin in a colour of their own. They follow the skin as it deforms, since they share its vertices.
#[derive(Debug)]
pub struct Patch {
    id: u64,
    corners: Vec<[u32; 3]>,
    color: [u8; 4],
}

impl Patch {
    /// The triangles of `surface` with these numbers; numbers it does not have are left out.
    pub fn new(surface: &Surface, triangles: &[u32], color: [u8; 4]) -> Arc<Self> {
        let corners = triangles
            .iter()
            .filter_map(|&t| surface.triangles().get(t as usize).copied())
            .collect();
        Arc::new(Self {
            id: next_id(),
            corners,
            color,
        })
    }

    /// Corners of each triangle, as numbers of the skin's vertices.
    pub fn corners(&self) -> &[[u32; 3]] {
        &self.corners
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.corners[..])
    }
}

impl PartialEq for Patch {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

/// What is laid over a skin.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    /// In space.
    pub layers: Vec<Arc<Layer>>,
    /// On the skin.
    pub patches: Vec<Arc<Patch>>,
    /// What all of it takes up, mm: it must not be cut off in depth.
    pub bounds: Aabb,
}

impl Default for Overlay {
    /// Nothing.
    fn default() -> Self {
        Self {
            layers: Vec::new(),
            patches: Vec::new(),
            bounds: Aabb::EMPTY,
        }
    }
}

/// Share of their opacity with which lines show that the skin hides.
const HIDDEN: f32 = 0.28;

/// Layers and patches on the graphics card.
#[derive(Debug)]
pub struct Layers {
    program: Program,
    held: BTreeMap<u64, VertexArray>,
    /// The mesh whose vertices the patches use.
    mesh_id: Option<u64>,
    uploads: usize,
}

impl Layers {
    /// Compiles the program.
    ///
    /// # Errors
    /// What the driver's compiler says.
    pub fn new(gl: &glow::Context) -> Result<Self, String> {
        Ok(Self {
            program: Program::new(
                gl,
                "layer",
                include_str!("shaders/layer.vert"),
                include_str!("shaders/layer.frag"),
            )?,
            held: BTreeMap::new(),
            mesh_id: None,
            uploads: 0,
        })
    }

    /// Uploads what is new in `overlay` and frees what is gone; `skin` is the mesh with its vertices. Returns how many went up.
    ///
    /// # Errors
    /// The driver is out of handles.
    pub fn upload(
        &mut self,
        gl: &glow::Context,
        overlay: &Overlay,
        (mesh_id, vertices): (u64, glow::Buffer),
    ) -> Result<usize, String> {
        let before = self.uploads;
        if self.mesh_id != Some(mesh_id) {
            self.clear(gl);
            self.mesh_id = Some(mesh_id);
        }
        let wanted = |id: &u64| {
            overlay.layers.iter().any(|l| l.id == *id)
                || overlay.patches.iter().any(|p| p.id == *id)
        };
        let gone: Vec<u64> = self.held.keys().filter(|id| !wanted(id)).copied().collect();
        for array in gone.iter().filter_map(|id| self.held.remove(id)) {
            array.delete(gl);
        }
        for layer in &overlay.layers {
            if let Entry::Vacant(place) = self.held.entry(layer.id) {
                let array = VertexArray::new(gl, 1)?;
                let stride = size_of::<LayerVertex>();
                // SAFETY: the context is current; array and buffer are its own and bound before attributes are declared.
                unsafe {
                    gl.bind_vertex_array(Some(array.vao));
                    gl.bind_buffer(glow::ARRAY_BUFFER, Some(array.buffers[0]));
                    gl.buffer_data_u8_slice(
                        glow::ARRAY_BUFFER,
                        bytemuck::cast_slice(&layer.vertices),
                        glow::STATIC_DRAW,
                    );
                    attribute(gl, 0, 3, glow::FLOAT, stride, 0);
                    attribute(gl, 1, 4, glow::UNSIGNED_BYTE, stride, 12);
                    gl.bind_vertex_array(None);
                }
                place.insert(array);
                self.uploads += 1;
            }
        }
        for patch in &overlay.patches {
            if let Entry::Vacant(place) = self.held.entry(patch.id) {
                let array = VertexArray::new(gl, 1)?;
                // SAFETY: as above.
                unsafe {
                    gl.bind_vertex_array(Some(array.vao));
                    gl.bind_buffer(glow::ARRAY_BUFFER, Some(vertices));
                    attribute(gl, 0, 3, glow::FLOAT, size_of::<SkinVertex>(), 0);
                    gl.bind_buffer(glow::ELEMENT_ARRAY_BUFFER, Some(array.buffers[0]));
                    gl.buffer_data_u8_slice(
                        glow::ELEMENT_ARRAY_BUFFER,
                        bytemuck::cast_slice(&patch.corners),
                        glow::STATIC_DRAW,
                    );
                    gl.bind_vertex_array(None);
                }
                place.insert(array);
                self.uploads += 1;
            }
        }
        Ok(self.uploads - before)
    }

    /// Draws what was uploaded, over the skin on the bound framebuffer.
    pub fn draw(&self, gl: &glow::Context, overlay: &Overlay, light: &Light) {
        if overlay.layers.is_empty() && overlay.patches.is_empty() {
            return;
        }
        let program = self.program.bind(gl);
        light.set_matrix(&program);
        program.float("u_strength", 1.0);
        // SAFETY: the context is current, and buffers hold as many vertices as are drawn. An attribute that an array does
        // not declare has the constant value set here.
        unsafe {
            gl.enable(glow::BLEND);
            gl.blend_equation(glow::FUNC_ADD);
            gl.blend_func(glow::SRC_ALPHA, glow::ONE_MINUS_SRC_ALPHA);
            gl.enable(glow::DEPTH_TEST);
            gl.depth_mask(false);
            gl.depth_func(glow::LEQUAL);
            for patch in &overlay.patches {
                let Some(array) = self.held.get(&patch.id) else {
                    continue;
                };
                let [r, g, b, a] = patch.color.map(|c| f32::from(c) / 255.0);
                gl.vertex_attrib_4_f32(1, r, g, b, a);
                gl.bind_vertex_array(Some(array.vao));
                let n = patch.corners.len() * 3;
                gl.draw_elements(glow::TRIANGLES, n as i32, glow::UNSIGNED_INT, 0);
            }
            for layer in &overlay.layers {
                let Some(array) = self.held.get(&layer.id) else {
                    continue;
                };
                gl.bind_vertex_array(Some(array.vao));
                let (first, all) = (layer.n_line_vertices as i32, layer.vertices.len() as i32);
                if all > first {
                    gl.draw_arrays(glow::TRIANGLES, first, all - first);
                }
                if first > 0 {
                    gl.draw_arrays(glow::LINES, 0, first);
                    gl.depth_func(glow::GREATER);
                    program.float("u_strength", HIDDEN);
                    gl.draw_arrays(glow::LINES, 0, first);
                    program.float("u_strength", 1.0);
                    gl.depth_func(glow::LEQUAL);
                }
            }
            gl.bind_vertex_array(None);
            gl.depth_mask(true);
            gl.depth_func(glow::LESS);
            gl.disable(glow::BLEND);
        }
    }

    fn clear(&mut self, gl: &glow::Context) {
        for (_, array) in std::mem::take(&mut self.held) {
            array.delete(gl);
        }
    }

    /// Frees everything.
    pub fn delete(mut self, gl: &glow::Context) {
        self.clear(gl);
        self.program.delete(gl);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(layer: &Layer) -> Vec<[[f32; 3]; 2]> {
        let pairs = layer.lines().chunks(2);
        pairs.map(|p| [p[0].position, p[1].position]).collect()
    }

    #[test]
    fn a_box_has_twelve_edges_four_along_each_axis() {
        let b = Aabb {
            min: Vec3::new(1.0, 2.0, 3.0),
            max: Vec3::new(2.0, 4.0, 7.0),
        };
        let mut builder = LayerBuilder::default();
        builder.wire_box(&b, [255; 4]);
        let layer = builder.finish();
        let lines = ends(&layer);
        assert_eq!((lines.len(), layer.faces().len()), (12, 0));
        for (axis, length) in [1.0, 2.0, 4.0].into_iter().enumerate() {
            let along = lines.iter().filter(|[p, q]| {
                (0..3).all(|k| (q[k] - p[k] == 0.0) == (k != axis)) && q[axis] - p[axis] == length
            });
            assert_eq!(along.count(), 4);
        }
        let mut distinct: Vec<_> = lines
            .iter()
            .map(|l| l.map(|p| p.map(f32::to_bits)))
            .collect();
        distinct.sort_unstable();
        distinct.dedup();
        assert_eq!(distinct.len(), 12);
    }

    #[test]
    fn a_cut_is_the_rectangle_of_the_box_on_the_plane() {
        let b = Aabb {
            min: Vec3::ZERO,
            max: Vec3::new(2.0, 3.0, 4.0),
        };
        for axis in 0..3 {
            let mut builder = LayerBuilder::default();
            builder.cut(&b, axis, 0.5, [255; 4], [60; 4]);
            let layer = builder.finish();
            assert_eq!((layer.lines().len(), layer.faces().len()), (8, 6));
            assert!(layer.faces().iter().all(|v| v.position[axis] == 0.5));
            let area = |t: &[LayerVertex]| {
                let p = |i: usize| Vec3::from_array(t[i].position.map(f64::from));
                0.5 * (p(1) - p(0)).cross(p(2) - p(0)).length()
            };
            let whole: f64 = layer.faces().chunks(3).map(area).sum();
            assert_eq!(whole, 24.0 / b.size()[axis]);
        }
    }

    #[test]
    fn layers_are_told_apart_by_their_number() {
        let [a, b] = [0, 1].map(|_| LayerBuilder::default().finish());
        assert!(a == a.clone() && a != b);
    }
}
