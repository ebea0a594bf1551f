//! The skin's buffers on the graphics card, and its drawing: shaded surface and wire overlay.
#![allow(unsafe_code, reason = "OpenGL calls are unsafe by signature")] // OpenGL is a C interface; see `gl`.

use super::gl::{Bound, Program, VertexArray, attribute};
use super::light::Light;
use super::mesh::{PLAIN_SHADE, SkinMesh, SkinVertex, edges};
use super::tint::{Tint, TintBuffer, Tinting};
use super::values::Values;
use super::{Picture, SkinLook};
use eframe::glow::{self, HasContext as _};
use std::ops::Range;

const SKIN_VERT: &str = include_str!("shaders/skin.vert");
const SKIN_FRAG: &str = include_str!("shaders/skin.frag");

/// Programs for the skin; made once per context.
#[derive(Debug)]
pub struct SkinPrograms {
    skin: Program,
    /// With pores: a program of its own, since their noise is most of its cost and mostly too fine to be seen.
    pores: Program,
    wire: Program,
    /// Made when a translucent skin is first shown, freed when none is.
    glass: Option<Glass>,
}

/// Programs for a skin that lets through what lies below it.
#[derive(Debug)]
struct Glass {
    depth: Program,
    skin: Program,
}

impl Glass {
    fn new(gl: &glow::Context) -> Result<Self, String> {
        Ok(Self {
            depth: Program::new(
                gl,
                "depth of the skin",
                SKIN_VERT,
                include_str!("shaders/depth.frag"),
            )?,
            skin: Program::new(
                gl,
                "translucent skin",
                SKIN_VERT,
                &format!("#define TRANSLUCENT\n{SKIN_FRAG}"),
            )?,
        })
    }

    fn delete(self, gl: &glow::Context) {
        self.depth.delete(gl);
        self.skin.delete(gl);
    }
}

impl SkinPrograms {
    /// Compiles them.
    ///
    /// # Errors
    /// What the driver's compiler says.
    pub fn new(gl: &glow::Context) -> Result<Self, String> {
        Ok(Self {
            skin: Program::new(gl, "skin", SKIN_VERT, SKIN_FRAG)?,
            pores: Program::new(
                gl,
                "skin with pores",
                SKIN_VERT,
                &format!("#define PORES\n{SKIN_FRAG}"),
            )?,
            wire: Program::new(
                gl,
                "wire",
                include_str!("shaders/wire.vert"),
                include_str!("shaders/wire.frag"),
            )?,
            glass: None,
        })
    }

    /// Makes what a translucent skin needs, or frees it.
    ///
    /// # Errors
    /// What the driver's compiler says.
    pub fn follow(&mut self, gl: &glow::Context, look: SkinLook) -> Result<(), String> {
        match (look, self.glass.is_some()) {
            (SkinLook::Translucent, false) => self.glass = Some(Glass::new(gl)?),
            (SkinLook::Opaque | SkinLook::Off, true) => {
                if let Some(glass) = self.glass.take() {
                    glass.delete(gl);
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Frees them.
    pub fn delete(self, gl: &glow::Context) {
        self.skin.delete(gl);
        self.pores.delete(gl);
        self.wire.delete(gl);
        if let Some(glass) = self.glass {
            glass.delete(gl);
        }
    }
}

/// Opacity of translucent skin that faces the eye, bare and coloured: colours must still be told apart.
const OPACITY: [f32; 2] = [0.46, 0.60];

/// Linear colour of skin.
const SKIN_ALBEDO: [f32; 3] = [0.680, 0.422, 0.315];

const VERTICES: usize = 0;
const SHADE: usize = 1;
const TRIANGLES: usize = 2;

/// One skin on the graphics card.
#[derive(Debug)]
pub struct Skin {
    mesh_id: u64,
    array: VertexArray,
    n_indices: i32,
    /// Made when the wire is first shown: most scenes never ask for it.
    wire: Option<(VertexArray, i32)>,
    /// There only while a quantity is shown.
    tint: Option<TintBuffer>,
    mean_edge_mm: f64,
    runs: Vec<Range<u32>>,
}

impl Skin {
    /// Uploads `mesh` whole.
    ///
    /// # Errors
    /// The mesh is too large for 32-bit offsets, or the driver is out of handles.
    pub fn new(gl: &glow::Context, mesh: &mut SkinMesh) -> Result<Self, String> {
        let surface = mesh.surface().clone();
        let n_indices = i32::try_from(surface.triangles().len() * 3)
            .ok()
            .filter(|_| size_of_val(mesh.vertices()) < i32::MAX as usize)
            .ok_or("the mesh is too large to be drawn: at most 100 million vertices")?;
        let array = VertexArray::new(gl, 3)?;
        let plain;
        let shade = match mesh.shade() {
            Some(shade) => shade,
            None => {
                plain = vec![PLAIN_SHADE; mesh.vertices().len()];
                &plain
            }
        };
        // SAFETY: the context is current; array and buffers are its own and bound before attributes are declared.
        unsafe {
            gl.bind_vertex_array(Some(array.vao));
            gl.bind_buffer(glow::ARRAY_BUFFER, Some(array.buffers[VERTICES]));
            gl.buffer_data_u8_slice(
                glow::ARRAY_BUFFER,
                bytemuck::cast_slice(mesh.vertices()),
                glow::DYNAMIC_DRAW,
            );
            gl.bind_buffer(glow::ARRAY_BUFFER, Some(array.buffers[SHADE]));
            gl.buffer_data_u8_slice(
                glow::ARRAY_BUFFER,
                bytemuck::cast_slice(shade),
                glow::STATIC_DRAW,
            );
            declare(gl, &array.buffers);
            gl.buffer_data_u8_slice(
                glow::ELEMENT_ARRAY_BUFFER,
                bytemuck::cast_slice(surface.triangles()),
                glow::STATIC_DRAW,
            );
            gl.bind_vertex_array(None);
        }
        let mut runs = Vec::new();
        mesh.take_changed(&mut runs);
        let _ = mesh.take_shade();
        Ok(Self {
            mesh_id: mesh.id(),
            array,
            n_indices,
            wire: None,
            tint: None,
            mean_edge_mm: mean_edge_mm(&surface),
            runs,
        })
    }

    /// Which mesh it holds.
    pub fn mesh_id(&self) -> u64 {
        self.mesh_id
    }

    /// Its vertices, for what is drawn with them.
    pub fn vertex_buffer(&self) -> glow::Buffer {
        self.array.buffers[VERTICES]
    }

    /// Uploads what changed in the mesh it was made from; returns how many vertices went up.
    pub fn upload_changes(&mut self, gl: &glow::Context, mesh: &mut SkinMesh) -> usize {
        mesh.take_changed(&mut self.runs);
        // SAFETY: as in `new`; every run lies within the buffer, which has one entry per vertex of the same mesh.
        unsafe {
            if !self.runs.is_empty() {
                gl.bind_buffer(glow::ARRAY_BUFFER, Some(self.array.buffers[VERTICES]));
                for run in &self.runs {
                    let part = &mesh.vertices()[run.start as usize..run.end as usize];
                    let offset = run.start as usize * size_of::<SkinVertex>();
                    gl.buffer_sub_data_u8_slice(
                        glow::ARRAY_BUFFER,
                        offset as i32,
                        bytemuck::cast_slice(part),
                    );
                }
            }
            if let Some(shade) = mesh.take_shade() {
                gl.bind_buffer(glow::ARRAY_BUFFER, Some(self.array.buffers[SHADE]));
                gl.buffer_sub_data_u8_slice(glow::ARRAY_BUFFER, 0, bytemuck::cast_slice(shade));
            }
            gl.bind_buffer(glow::ARRAY_BUFFER, None);
        }
        self.runs.iter().map(|run| run.len()).sum()
    }

    /// Follows the values that colour it: uploads them whole when they are new, else what changed; frees them where
    /// `shown` is false or there are none. Returns how many numbers went up besides a first whole upload.
    ///
    /// # Errors
    /// The driver is out of handles.
    pub fn follow_values(
        &mut self,
        gl: &glow::Context,
        mesh: &mut SkinMesh,
        shown: bool,
    ) -> Result<usize, String> {
        let values = mesh.values_mut().filter(|_| shown);
        let held = self.tint.take();
        let Some(values) = values else {
            if let Some(held) = held {
                held.delete(gl);
            }
            return Ok(0);
        };
        match held {
            Some(held) if held.is_of(values) => {
                let uploaded = held.upload_changes(gl, values, &mut self.runs);
                self.tint = Some(held);
                Ok(uploaded)
            }
            other => {
                if let Some(other) = other {
                    other.delete(gl);
                }
                let buffers = &self.array.buffers;
                self.tint = Some(TintBuffer::new(gl, values, |gl| declare(gl, buffers))?);
                Ok(0)
            }
        }
    }

    /// Whether these are the values it is coloured by, be they up to date or not.
    pub fn holds(&self, values: Option<&Values>) -> bool {
        match (&self.tint, values) {
            (Some(held), Some(values)) => held.is_of(values),
            (held, values) => held.is_none() && values.is_none(),
        }
    }

    /// Whether there are values to colour it by.
    pub fn has_values(&self) -> bool {
        self.tint.is_some()
    }

    /// Draws the surface coloured by its values on the bound framebuffer; nothing without any.
    pub fn draw_tinted(
        &self,
        gl: &glow::Context,
        tinting: &mut Tinting,
        tint: &Tint,
        picture: &Picture,
        light: &Light,
    ) {
        let Some(buffer) = &self.tint else { return };
        let layer = if tinting.is_translucent() {
            LayerOf::Glass
        } else {
            LayerOf::Solid
        };
        let program = tinting.bind(gl, tint);
        light.set(&program);
        program.float("u_flat", light.flat());
        program.float("u_opacity", OPACITY[1]);
        set_fingers(&program, picture);
        buffer.set_constant(gl);
        self.draw_triangles(gl, &buffer.array, layer);
        // SAFETY: the context is current.
        unsafe { gl.bind_texture(glow::TEXTURE_2D, None) };
    }

    /// Draws the shaded surface on the bound framebuffer.
    pub fn draw(
        &self,
        gl: &glow::Context,
        programs: &SkinPrograms,
        picture: &Picture,
        light: &Light,
    ) {
        // Pores are about 1 mm apart: they fade in between 3 and 7 pixels.
        let pores = ((picture.target_px_per_mm() - 3.0) / 4.0).clamp(0.0, 1.0) as f32;
        let (program, layer) = match &programs.glass {
            Some(glass) => (glass.skin.bind(gl), LayerOf::Glass),
            None if pores > 0.0 => (programs.pores.bind(gl), LayerOf::Solid),
            None => (programs.skin.bind(gl), LayerOf::Solid),
        };
        light.set(&program);
        let dark = picture.palette.dark;
        program.vec3("u_albedo", SKIN_ALBEDO);
        program.float("u_exposure", if dark { 0.90 } else { 1.0 });
        program.float("u_pores", pores);
        program.float("u_opacity", OPACITY[0]);
        set_fingers(&program, picture);
        self.draw_triangles(gl, &self.array, layer);
    }

    /// Draws the depth of the nearest layer of a translucent skin, and nothing else: the colour drawn after it is then that of
    /// one layer at each place, whatever the order of the triangles.
    pub fn draw_depth(&self, gl: &glow::Context, programs: &SkinPrograms, light: &Light) {
        let Some(glass) = &programs.glass else { return };
        let program = glass.depth.bind(gl);
        light.set_matrix(&program);
        // SAFETY: the context is current.
        unsafe { gl.color_mask(false, false, false, false) };
        self.draw_triangles(gl, &self.array, LayerOf::Solid);
        // SAFETY: as above.
        unsafe { gl.color_mask(true, true, true, true) };
    }

    fn draw_triangles(&self, gl: &glow::Context, array: &VertexArray, layer: LayerOf) {
        // SAFETY: the context is current and every index lies within the vertex buffer (a `Surface` guarantees it).
        unsafe {
            gl.enable(glow::DEPTH_TEST);
            match layer {
                LayerOf::Solid => {
                    gl.disable(glow::BLEND);
                    gl.depth_func(glow::LESS);
                }
                LayerOf::Glass => {
                    gl.enable(glow::BLEND);
                    gl.blend_equation(glow::FUNC_ADD);
                    gl.blend_func(glow::SRC_ALPHA, glow::ONE_MINUS_SRC_ALPHA);
                    gl.depth_func(glow::LEQUAL);
                    gl.depth_mask(false);
                }
            }
            gl.bind_vertex_array(Some(array.vao));
            gl.draw_elements(glow::TRIANGLES, self.n_indices, glow::UNSIGNED_INT, 0);
            gl.bind_vertex_array(None);
            gl.depth_mask(true);
            gl.disable(glow::BLEND);
        }
    }

    /// Draws the edges over it, fainter the closer they stand on the screen.
    ///
    /// # Errors
    /// The driver is out of handles.
    pub fn draw_wire(
        &mut self,
        gl: &glow::Context,
        programs: &SkinPrograms,
        picture: &Picture,
        light: &Light,
        mesh: &SkinMesh,
    ) -> Result<(), String> {
        if self.wire.is_none() {
            self.wire = Some(self.make_wire(gl, mesh)?);
        }
        let Some((array, n)) = &self.wire else {
            return Ok(());
        };
        // Below about two pixels an edge is a veil, not a line.
        let apart_px = self.mean_edge_mm * picture.target_px_per_mm();
        let strength = ((apart_px - 1.5) / 7.0).clamp(0.06, 1.0) as f32;
        let program = programs.wire.bind(gl);
        light.set_matrix(&program);
        let [r, g, b] = picture.palette.wire.map(|c| f32::from(c) / 255.0);
        program.vec4s("u_color", &[[r, g, b, 0.42 * strength]]);
        // SAFETY: as in `draw`.
        unsafe {
            gl.enable(glow::BLEND);
            gl.blend_equation(glow::FUNC_ADD);
            gl.blend_func(glow::SRC_ALPHA, glow::ONE_MINUS_SRC_ALPHA);
            gl.enable(glow::DEPTH_TEST);
            gl.depth_func(glow::LEQUAL);
            gl.depth_mask(false);
            gl.bind_vertex_array(Some(array.vao));
            gl.draw_elements(glow::LINES, *n, glow::UNSIGNED_INT, 0);
            gl.bind_vertex_array(None);
            gl.depth_mask(true);
            gl.disable(glow::BLEND);
        }
        Ok(())
    }

    /// A vertex array of its own over the skin's vertices, with the edges for indices.
    fn make_wire(&self, gl: &glow::Context, mesh: &SkinMesh) -> Result<(VertexArray, i32), String> {
        let edges = edges(mesh.surface());
        let array = VertexArray::new(gl, 1)?;
        // SAFETY: as in `new`.
        unsafe {
            gl.bind_vertex_array(Some(array.vao));
            gl.bind_buffer(glow::ARRAY_BUFFER, Some(self.array.buffers[VERTICES]));
            attribute(gl, 0, 3, glow::FLOAT, size_of::<SkinVertex>(), 0);
            gl.bind_buffer(glow::ELEMENT_ARRAY_BUFFER, Some(array.buffers[0]));
            gl.buffer_data_u8_slice(
                glow::ELEMENT_ARRAY_BUFFER,
                bytemuck::cast_slice(&edges),
                glow::STATIC_DRAW,
            );
            gl.bind_vertex_array(None);
        }
        Ok((array, (edges.len() * 2) as i32))
    }

    /// Frees it.
    pub fn delete(self, gl: &glow::Context) {
        self.array.delete(gl);
        if let Some((wire, _)) = self.wire {
            wire.delete(gl);
        }
        if let Some(tint) = self.tint {
            tint.delete(gl);
        }
    }
}

/// How a layer of skin is laid on.
#[derive(Clone, Copy)]
enum LayerOf {
    /// It covers what lies below.
    Solid,
    /// It is blended over what lies below, where its depth has been drawn.
    Glass,
}

/// Binds a skin's buffers and declares its attributes in the bound vertex array.
fn declare(gl: &glow::Context, buffers: &[glow::Buffer]) {
    let stride = size_of::<SkinVertex>();
    // SAFETY: the context is current and the caller has bound a vertex array of it; buffers are bound before attributes are
    // declared.
    unsafe {
        gl.bind_buffer(glow::ARRAY_BUFFER, Some(buffers[VERTICES]));
        attribute(gl, 0, 3, glow::FLOAT, stride, 0);
        attribute(gl, 1, 4, glow::SHORT, stride, 12);
        gl.bind_buffer(glow::ARRAY_BUFFER, Some(buffers[SHADE]));
        attribute(gl, 2, 4, glow::UNSIGNED_BYTE, 4, 0);
        gl.bind_buffer(glow::ELEMENT_ARRAY_BUFFER, Some(buffers[TRIANGLES]));
    }
}

/// Tells a skin's program where the fingers are that shade it.
fn set_fingers(program: &Bound<'_>, picture: &Picture) {
    let fingers: Vec<[f32; 4]> = picture
        .spheres
        .iter()
        .take(4)
        .map(|s| s.centre_mm.extend(s.radius_mm).to_array().map(|x| x as f32))
        .collect();
    program.vec4s("u_fingers", &fingers);
    program.int("u_n_fingers", fingers.len() as i32);
}

/// Mean edge length from the mean triangle area, as if all were equilateral, mm.
fn mean_edge_mm(surface: &crate::surface::Surface) -> f64 {
    let n = surface.triangles().len();
    let area: f64 = (0..n as u32).map(|t| surface.triangle(t).area_mm2()).sum();
    if n == 0 {
        0.0
    } else {
        (area / n as f64 * 4.0 / 3.0_f64.sqrt()).sqrt()
    }
}
