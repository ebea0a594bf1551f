//! Models: meshes that never change, drawn where their place puts them. Bones and hands.
//!
//! A model is a plain value with a number: two with one number are the same. What a picture no longer names is freed, and
//! with the last of them the program.
#![allow(unsafe_code, reason = "OpenGL calls are unsafe by signature")] // OpenGL is a C interface; see `gl`.

use super::gl::{Program, VertexArray, attribute};
use super::light::Light;
use crate::geom::{Aabb, Vec3};
use eframe::glow::{self, HasContext as _};
use glam::DMat4;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// One vertex as uploaded: 20 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ModelVertex {
    /// Position, mm.
    pub position: [f32; 3],
    /// Unit normal in 1/32767, then the share of the second colour.
    pub normal_tone: [i16; 4],
}

/// A mesh that never changes.
#[derive(Debug)]
pub struct Model {
    id: u64,
    vertices: Vec<ModelVertex>,
    triangles: Vec<[u32; 3]>,
    bounds: Aabb,
}

impl Model {
    /// Packs a mesh; `tone` gives the share of the second colour at a vertex, 0 to 1. A vertex without a normal has +z.
    pub fn new(
        positions: &[Vec3],
        normals: &[Vec3],
        triangles: &[[u32; 3]],
        tone: impl Fn(usize) -> f64,
    ) -> Self {
        static NEXT_ID: AtomicU64 = AtomicU64::new(1);
        let unit = |x: f64| (x.clamp(-1.0, 1.0) * 32767.0).round() as i16;
        let vertex = |(i, p): (usize, &Vec3)| {
            let n = normals.get(i).copied().unwrap_or(Vec3::Z);
            ModelVertex {
                position: p.to_array().map(|x| x as f32),
                normal_tone: [unit(n.x), unit(n.y), unit(n.z), unit(tone(i))],
            }
        };
        let n = positions.len() as u32;
        Self {
            id: NEXT_ID.fetch_add(1, Ordering::Relaxed),
            vertices: positions.iter().enumerate().map(vertex).collect(),
            triangles: (triangles.iter())
                .filter(|t| t.iter().all(|&v| v < n))
                .copied()
                .collect(),
            bounds: Aabb::of_points(positions.iter().copied()),
        }
    }

    /// The smallest box around it, mm.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Memory held, bytes; the graphics card holds as much once it is drawn.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.vertices[..]) + size_of_val(&self.triangles[..])
    }
}

/// A model in its place.
#[derive(Clone, Debug)]
pub struct Placed {
    /// Which.
    pub model: Arc<Model>,
    /// Turns, moves and scales evenly.
    pub subject_from_model: DMat4,
    /// Both its colours, sRGB.
    pub colors: [[u8; 3]; 2],
    /// How much it shines, 0 to 1.
    pub gloss: f64,
    /// It wears a finger's colour: over a coloured skin it gets a rim.
    pub is_finger: bool,
}

impl PartialEq for Placed {
    fn eq(&self, other: &Self) -> bool {
        self.model.id == other.model.id
            && self.subject_from_model == other.subject_from_model
            && self.colors == other.colors
            && self.gloss == other.gloss
            && self.is_finger == other.is_finger
    }
}

/// Models on the graphics card.
#[derive(Debug)]
pub struct Models {
    program: Program,
    held: BTreeMap<u64, (VertexArray, i32)>,
}

impl Models {
    /// Compiles the program.
    ///
    /// # Errors
    /// What the driver's compiler says.
    pub fn new(gl: &glow::Context) -> Result<Self, String> {
        Ok(Self {
            program: Program::new(
                gl,
                "model",
                include_str!("shaders/model.vert"),
                include_str!("shaders/model.frag"),
            )?,
            held: BTreeMap::new(),
        })
    }

    /// Uploads what is new among `wanted` and frees what is gone; returns how many went up.
    ///
    /// # Errors
    /// The driver is out of handles.
    pub fn upload(&mut self, gl: &glow::Context, wanted: &[Placed]) -> Result<usize, String> {
        let gone: Vec<u64> = (self.held.keys())
            .filter(|id| !wanted.iter().any(|p| p.model.id == **id))
            .copied()
            .collect();
        for (array, _) in gone.iter().filter_map(|id| self.held.remove(id)) {
            array.delete(gl);
        }
        let mut uploads = 0;
        for placed in wanted {
            let model = &placed.model;
            if let Entry::Vacant(place) = self.held.entry(model.id) {
                let array = VertexArray::new(gl, 2)?;
                let stride = size_of::<ModelVertex>();
                // SAFETY: the context is current; array and buffers are its own and bound before attributes are declared.
                unsafe {
                    gl.bind_vertex_array(Some(array.vao));
                    gl.bind_buffer(glow::ARRAY_BUFFER, Some(array.buffers[0]));
                    gl.buffer_data_u8_slice(
                        glow::ARRAY_BUFFER,
                        bytemuck::cast_slice(&model.vertices),
                        glow::STATIC_DRAW,
                    );
                    attribute(gl, 0, 3, glow::FLOAT, stride, 0);
                    attribute(gl, 1, 4, glow::SHORT, stride, 12);
                    gl.bind_buffer(glow::ELEMENT_ARRAY_BUFFER, Some(array.buffers[1]));
                    gl.buffer_data_u8_slice(
                        glow::ELEMENT_ARRAY_BUFFER,
                        bytemuck::cast_slice(&model.triangles),
                        glow::STATIC_DRAW,
                    );
                    gl.bind_vertex_array(None);
                }
                place.insert((array, (model.triangles.len() * 3) as i32));
                uploads += 1;
            }
        }
        Ok(uploads)
    }

    /// Draws what was uploaded on the bound framebuffer. `rim` is the colour of fingers' rims, where they get one.
    pub fn draw(
        &self,
        gl: &glow::Context,
        wanted: &[Placed],
        light: &Light,
        rim: Option<[f32; 3]>,
    ) {
        let program = self.program.bind(gl);
        light.set(&program);
        program.vec3("u_rim_color", rim.unwrap_or_default());
        // SAFETY: the context is current, and every index was checked when its model was packed.
        unsafe {
            gl.enable(glow::DEPTH_TEST);
            gl.depth_func(glow::LESS);
            gl.disable(glow::BLEND);
            // Closed solids that face outward.
            gl.enable(glow::CULL_FACE);
            gl.cull_face(glow::BACK);
            gl.front_face(glow::CCW);
        }
        for placed in wanted {
            let Some((array, n)) = self.held.get(&placed.model.id) else {
                continue;
            };
            let matrix = placed.subject_from_model.to_cols_array();
            program.mat4("u_subject_from_model", &matrix.map(|x| x as f32));
            let [first, second] = placed.colors.map(linear);
            program.vec3("u_colors[0]", first);
            program.vec3("u_colors[1]", second);
            program.float("u_gloss", placed.gloss as f32);
            let rimmed = placed.is_finger && rim.is_some();
            program.float("u_rimmed", if rimmed { 1.0 } else { 0.0 });
            // SAFETY: as above.
            unsafe {
                gl.bind_vertex_array(Some(array.vao));
                gl.draw_elements(glow::TRIANGLES, *n, glow::UNSIGNED_INT, 0);
            }
        }
        // SAFETY: as above.
        unsafe {
            gl.bind_vertex_array(None);
            gl.disable(glow::CULL_FACE);
        }
    }

    /// Frees everything.
    pub fn delete(self, gl: &glow::Context) {
        for (array, _) in self.held.into_values() {
            array.delete(gl);
        }
        self.program.delete(gl);
    }
}

/// A colour in linear light.
fn linear(color: [u8; 3]) -> [f32; 3] {
    color.map(|c| {
        let c = f32::from(c) / 255.0;
        if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_packs_its_mesh_and_leaves_out_what_it_does_not_have() {
        let positions = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 3.0];
        let model = Model::new(&positions, &[Vec3::Z; 3], &[[0, 1, 2], [0, 1, 9]], |i| {
            f64::from(u8::from(i == 1))
        });
        assert_eq!(model.triangles, [[0, 1, 2]]);
        assert_eq!(model.vertices[1].position, [2.0, 0.0, 0.0]);
        assert_eq!(model.vertices[1].normal_tone, [0, 0, 32767, 32767]);
        assert_eq!(model.bounds().max, Vec3::new(2.0, 3.0, 0.0));
        assert_eq!(model.bytes(), 3 * 20 + 12);
    }

    #[test]
    fn the_same_model_in_the_same_place_is_the_same() {
        let model = Arc::new(Model::new(&[], &[], &[], |_| 0.0));
        let placed = |model: &Arc<Model>, x: f64| Placed {
            model: model.clone(),
            subject_from_model: DMat4::from_translation(Vec3::X * x),
            colors: [[1, 2, 3]; 2],
            gloss: 0.0,
            is_finger: false,
        };
        assert_eq!(placed(&model, 1.0), placed(&model, 1.0));
        assert_ne!(placed(&model, 1.0), placed(&model, 2.0));
        let other = Arc::new(Model::new(&[], &[], &[], |_| 0.0));
        assert_ne!(placed(&model, 1.0), placed(&other, 1.0));
    }
}
