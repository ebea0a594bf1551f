//! Drawing the skin with OpenGL. `f32` lives only here.
//!
//! | file | answers |
//! |---|---|
//! | [`mesh`] | the skin packed for the graphics card, and what of it changed |
//! | [`shade`] | hollows, ridges and tone, baked per vertex |
//! | `skin` | its buffers and drawing, wire overlay |
//! | [`values`], [`tint`] | what colours it: a number per vertex, and how numbers become colours |
//! | [`sphere`], [`arrow`], [`solid`] | fingers and forces |
//! | [`model`], [`bones`], [`hand`] | meshes that never change: bones below the skin, a hand in a sphere's place |
//! | `anaglyph` | two pictures in one for coloured glasses |
//! | [`layer`] | boxes, planes and marked triangles over the skin |
//! | [`light`] | eye and lights |
//! | `target` | the picture's own multisampled framebuffer |
//! | `gl` | programs, vertex arrays |
//! | [`pixels`] | between the window's `f32` points and the program's `f64` |
//!
//! The window hands in a [`Picture`] (a plain value) and a [`mesh::SkinMesh`]; [`Renderer::paint`] draws them into a
//! texture of its own when either changed and puts that texture onto the window.
#![allow(unsafe_code, reason = "OpenGL calls are unsafe by signature")] // OpenGL is a C interface; see `gl`.

mod anaglyph;
pub mod arrow;
pub mod bones;
mod gl;
pub mod hand;
pub mod layer;
pub mod light;
pub mod mesh;
pub mod model;
pub mod pixels;
pub mod shade;
mod skin;
pub mod solid;
pub mod sphere;
mod target;
pub mod tint;
pub mod values;

use crate::app::camera::Camera;
use crate::app::stereo::{Pane, Stereo};
use crate::app::theme::Theme;
use crate::geom::{Aabb, Vec2};
use anaglyph::Anaglyph;
use arrow::Arrow;
use eframe::glow::{self, HasContext as _};
use gl::{Program, VertexArray, attribute};
use layer::{Layers, Overlay};
use light::Light;
use mesh::SkinMesh;
use model::{Models, Placed};
use skin::{Skin, SkinPrograms};
use solid::{SolidVertex, Solids};
use sphere::Sphere;
use target::Target;
use tint::{Tint, Tinting};

/// Colours of a picture, sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Palette {
    /// Whether the window is dark.
    pub dark: bool,
    /// The floor behind the skin, at the top.
    pub floor_top: [u8; 3],
    /// The same at the bottom.
    pub floor_bottom: [u8; 3],
    /// Edges of the wire overlay.
    pub wire: [u8; 3],
}

/// Widest and highest picture, pixels: what every driver can.
const LARGEST_PX: u32 = 16_384;

/// Rim of fingers over a coloured skin, sRGB: no map has it.
const RIM: [f32; 3] = [1.0, 1.0, 1.0];

impl Palette {
    /// Of a window's colours.
    pub fn of(theme: &Theme) -> Self {
        Self {
            dark: theme.dark,
            floor_top: pixels::rgb(theme.floor[0]),
            floor_bottom: pixels::rgb(theme.floor[1]),
            wire: pixels::rgb(if theme.dark {
                theme.background
            } else {
                theme.text
            }),
        }
    }
}

/// How the skin is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SkinLook {
    /// It hides what lies below.
    #[default]
    Opaque,
    /// It lets through what lies below, less where it is seen aslant. Colours that stand for numbers are then mixed with that.
    Translucent,
    /// It is not drawn.
    Off,
}

/// Everything to be drawn besides the skin itself. Two equal pictures of one skin look the same.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Where from.
    pub camera: Camera,
    /// Size, pixels.
    pub size_px: [u32; 2],
    /// What must not be cut off in depth, mm, beside the overlay.
    pub bounds: Aabb,
    /// Colours.
    pub palette: Palette,
    /// How the skin itself is drawn.
    pub skin: SkinLook,
    /// How the values of the skin colour it; bare skin for `None`, or where it has none.
    pub tint: Option<Tint>,
    /// Whether edges are drawn over the skin.
    pub wireframe: bool,
    /// Drawn with one sample per pixel: for pictures that the next one soon replaces.
    pub draft: bool,
    /// For two eyes, or for one.
    pub stereo: Option<Stereo>,
    /// The fingers. The first four cast a shadow.
    pub spheres: Vec<Sphere>,
    /// Whether they are drawn, beside their shadows: models of fingers may stand for them.
    pub draws_spheres: bool,
    /// Bones, hands.
    pub models: Vec<Placed>,
    /// The forces.
    pub arrows: Vec<Arrow>,
    /// What is laid over the skin.
    pub overlay: Overlay,
}

impl Picture {
    /// Size, pixels.
    pub fn size(&self) -> Vec2 {
        Vec2::new(f64::from(self.size_px[0]), f64::from(self.size_px[1]))
    }

    /// Each eye's picture and its place among the pixels that are drawn, and how many of those there are. The halves of an
    /// anaglyph are drawn side by side and brought together after.
    fn panes(&self, size_px: [u32; 2]) -> (Vec<Pane>, [u32; 2]) {
        let size: Vec2 = size_px.map(f64::from).into();
        match &self.stereo {
            None => (vec![Pane::whole(self.camera, size)], size_px),
            Some(stereo) if stereo.is_split() => {
                (stereo.pictures(&self.camera, size).to_vec(), size_px)
            }
            Some(stereo) => {
                let half = size_px[0].min(LARGEST_PX / 2);
                let size = Vec2::new(f64::from(half), size.y);
                let mut panes = stereo.pictures(&self.camera, size).to_vec();
                panes[1].from.x = size.x;
                (panes, [2 * half, size_px[1]])
            }
        }
    }

    /// Pixels per mm at the depth of the camera's target.
    pub fn target_px_per_mm(&self) -> f64 {
        self.camera.px_per_mm(self.camera.target_mm, self.size().y)
    }
}

/// What the last call of [`Renderer::paint`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Painted {
    /// Whether the skin was drawn anew; otherwise the kept texture was shown.
    pub drawn: bool,
    /// Vertices sent to the graphics card, without a first whole upload.
    pub uploaded_vertices: usize,
    /// Numbers that colour the skin sent to the graphics card, without a first whole upload.
    pub uploaded_values: usize,
    /// Layers and patches of the overlay sent to the graphics card.
    pub uploaded_layers: usize,
    /// Models sent to the graphics card.
    pub uploaded_models: usize,
    /// Samples per pixel.
    pub samples: i32,
}

/// All OpenGL objects of one Back view. Belongs to the context it was made with.
#[derive(Debug)]
pub struct Renderer {
    floor: Program,
    present: Program,
    solid: Program,
    skin_programs: SkinPrograms,
    /// Made when a quantity is first shown.
    tinting: Option<Tinting>,
    empty: VertexArray,
    solid_array: VertexArray,
    solids: Solids,
    skin: Option<Skin>,
    layers: Layers,
    /// Made when a model is first shown, freed when none is.
    models: Option<Models>,
    /// Made when an anaglyph is first shown, freed when none is.
    anaglyph: Option<Anaglyph>,
    /// The fine one and the one for drafts, each made when first drawn on.
    targets: [Option<Target>; 2],
    max_samples: i32,
    is_software: bool,
    shown: Option<Picture>,
}

impl Renderer {
    /// Compiles the programs. The context must be current.
    ///
    /// # Errors
    /// What the driver says, in one line fit to be shown.
    pub fn new(gl: &glow::Context) -> Result<Self, String> {
        let empty = VertexArray::new(gl, 0)?;
        let solid_array = VertexArray::new(gl, 2)?;
        let stride = size_of::<SolidVertex>();
        // SAFETY: the context is current; array and buffers are its own and bound before attributes are declared.
        let (max_samples, is_software) = unsafe {
            gl.bind_vertex_array(Some(solid_array.vao));
            gl.bind_buffer(glow::ARRAY_BUFFER, Some(solid_array.buffers[0]));
            attribute(gl, 0, 3, glow::FLOAT, stride, 0);
            attribute(gl, 1, 3, glow::FLOAT, stride, 12);
            attribute(gl, 2, 4, glow::UNSIGNED_BYTE, stride, 24);
            gl.bind_buffer(glow::ELEMENT_ARRAY_BUFFER, Some(solid_array.buffers[1]));
            gl.bind_vertex_array(None);
            (
                gl.get_parameter_i32(glow::MAX_SAMPLES),
                draws_in_software(&gl.get_parameter_string(glow::RENDERER)),
            )
        };
        Ok(Self {
            floor: Program::new(
                gl,
                "floor",
                include_str!("shaders/floor.vert"),
                include_str!("shaders/floor.frag"),
            )?,
            present: Program::new(
                gl,
                "present",
                include_str!("shaders/floor.vert"),
                include_str!("shaders/present.frag"),
            )?,
            solid: Program::new(
                gl,
                "solid",
                include_str!("shaders/solid.vert"),
                include_str!("shaders/solid.frag"),
            )?,
            skin_programs: SkinPrograms::new(gl)?,
            tinting: None,
            empty,
            solid_array,
            solids: Solids::default(),
            skin: None,
            layers: Layers::new(gl)?,
            models: None,
            anaglyph: None,
            targets: [None, None],
            max_samples,
            is_software,
            shown: None,
        })
    }

    /// Whether OpenGL draws on the processor, where samples and pixels are dear.
    pub fn is_software(&self) -> bool {
        self.is_software
    }

    /// Shows `picture` of `mesh` in the current viewport and scissor of the current framebuffer.
    ///
    /// Draws only when something changed since the last call. Leaves framebuffer, viewport and scissor as they were,
    /// depth test and face culling off; program, buffers and blending are the caller's to set again.
    ///
    /// # Errors
    /// The driver refuses a buffer or framebuffer.
    pub fn paint(
        &mut self,
        gl: &glow::Context,
        picture: &Picture,
        mesh: &mut SkinMesh,
    ) -> Result<Painted, String> {
        let size_px = picture.size_px.map(|n| n.clamp(1, LARGEST_PX));
        let mut viewport = [0; 4];
        // SAFETY: the context is current; `viewport` holds the four numbers that GL writes.
        let window = unsafe {
            gl.get_parameter_i32_slice(glow::VIEWPORT, &mut viewport);
            gl.get_parameter_framebuffer(glow::DRAW_FRAMEBUFFER_BINDING)
        };
        let outcome = self.draw_if_changed(gl, picture, mesh, size_px);
        // SAFETY: as above; the window's state is put back also after a failure.
        unsafe {
            gl.bind_framebuffer(glow::FRAMEBUFFER, window);
            gl.viewport(viewport[0], viewport[1], viewport[2], viewport[3]);
            gl.enable(glow::SCISSOR_TEST);
            gl.disable(glow::DEPTH_TEST);
            gl.disable(glow::CULL_FACE);
        }
        let painted = outcome?;
        self.present(gl, picture);
        Ok(painted)
    }

    fn draw_if_changed(
        &mut self,
        gl: &glow::Context,
        picture: &Picture,
        mesh: &mut SkinMesh,
        size_px: [u32; 2],
    ) -> Result<Painted, String> {
        let mut changed = self.shown.as_ref() != Some(picture) || mesh.has_changes();
        let (mut uploaded_vertices, mut uploaded_values) = (0, 0);
        match &mut self.skin {
            Some(skin) if skin.mesh_id() == mesh.id() => {
                if mesh.has_changes() {
                    uploaded_vertices = skin.upload_changes(gl, mesh);
                }
            }
            old => {
                if let Some(old) = old.take() {
                    old.delete(gl);
                }
                self.skin = Some(Skin::new(gl, mesh)?);
                changed = true;
            }
        }
        if let Some(skin) = &mut self.skin {
            changed |= picture.tint.is_some() && !skin.holds(mesh.values());
            uploaded_values = skin.follow_values(gl, mesh, picture.tint.is_some())?;
        }
        let (panes, drawn_px) = picture.panes(size_px);
        let target = &mut self.targets[usize::from(picture.draft)];
        if target.as_ref().map(Target::size_px) != Some(drawn_px) {
            if let Some(old) = target.take() {
                old.delete(gl);
            }
            let samples = if picture.draft { 1 } else { 4 };
            *target = Some(Target::new(gl, drawn_px, self.max_samples.min(samples))?);
            changed = true;
        }
        let Some(target) = &self.targets[usize::from(picture.draft)] else {
            return Ok(Painted::default());
        };
        let mut painted = Painted {
            drawn: changed,
            uploaded_vertices,
            uploaded_values,
            uploaded_layers: 0,
            uploaded_models: 0,
            samples: target.samples(),
        };
        if !changed {
            return Ok(painted);
        }
        self.shown = None;
        target.begin(gl);
        if panes.len() > 1 && drawn_px[0] % 2 == 1 {
            // An odd pixel parts the halves.
            self.draw_floor(gl, &picture.palette);
        }
        self.upload_solids(gl, picture);
        painted.uploaded_models = self.follow_models(gl, picture)?;
        self.skin_programs.follow(gl, picture.skin)?;
        if let Some(skin) = &self.skin {
            let vertices = (skin.mesh_id(), skin.vertex_buffer());
            painted.uploaded_layers = self.layers.upload(gl, &picture.overlay, vertices)?;
        }
        for pane in &panes {
            let [x, y, w, h] =
                [pane.from.x, pane.from.y, pane.size.x, pane.size.y].map(|n| n as i32);
            // SAFETY: the context is current.
            unsafe { gl.viewport(x, y, w, h) };
            self.draw_pane(gl, picture, mesh, pane)?;
        }
        if let Some(target) = &self.targets[usize::from(picture.draft)] {
            target.resolve(gl);
        }
        self.shown = Some(picture.clone());
        Ok(painted)
    }

    /// Draws one eye's picture in the viewport.
    fn draw_pane(
        &mut self,
        gl: &glow::Context,
        picture: &Picture,
        mesh: &SkinMesh,
        pane: &Pane,
    ) -> Result<(), String> {
        self.draw_floor(gl, &picture.palette);
        let light = Light::of(picture, &pane.camera, pane.size);
        let coloured = picture.tint.is_some();
        let translucent = picture.skin == SkinLook::Translucent;
        if let Some(models) = &self.models {
            models.draw(gl, &picture.models, &light, coloured.then_some(RIM));
        }
        if translucent {
            // What of a finger is in the skin is seen through it.
            self.draw_solids(gl, &light, coloured);
        }
        if let Some(skin) = &mut self.skin {
            if translucent {
                skin.draw_depth(gl, &self.skin_programs, &light);
            }
            let tint = picture.tint.filter(|_| skin.has_values());
            if picture.skin == SkinLook::Off {
            } else if let Some(tint) = tint {
                let held = self.tinting.take();
                let tinting = match held {
                    Some(held) if held.is_translucent() == translucent => held,
                    held => {
                        if let Some(held) = held {
                            held.delete(gl);
                        }
                        Tinting::new(gl, translucent)?
                    }
                };
                skin.draw_tinted(gl, self.tinting.insert(tinting), &tint, picture, &light);
            } else {
                skin.draw(gl, &self.skin_programs, picture, &light);
            }
            if picture.wireframe {
                skin.draw_wire(gl, &self.skin_programs, picture, &light, mesh)?;
            }
        }
        if !translucent {
            self.draw_solids(gl, &light, coloured);
        }
        // Last: it lets what lies behind show through.
        self.layers.draw(gl, &picture.overlay, &light);
        Ok(())
    }

    /// Makes or frees what models and anaglyph need; returns how many models went up.
    fn follow_models(&mut self, gl: &glow::Context, picture: &Picture) -> Result<usize, String> {
        let anaglyph = picture.stereo.is_some_and(|s| !s.is_split());
        if anaglyph && self.anaglyph.is_none() {
            self.anaglyph = Some(Anaglyph::new(gl)?);
        } else if !anaglyph && let Some(old) = self.anaglyph.take() {
            old.delete(gl);
        }
        if picture.models.is_empty() {
            if let Some(old) = self.models.take() {
                old.delete(gl);
            }
            return Ok(0);
        }
        let models = match &mut self.models {
            Some(models) => models,
            None => self.models.insert(Models::new(gl)?),
        };
        models.upload(gl, &picture.models)
    }

    fn draw_floor(&self, gl: &glow::Context, palette: &Palette) {
        let program = self.floor.bind(gl);
        let unit = |c: [u8; 3]| c.map(|x| f32::from(x) / 255.0);
        program.vec3("u_top", unit(palette.floor_top));
        program.vec3("u_bottom", unit(palette.floor_bottom));
        program.float("u_glow", if palette.dark { 0.035 } else { 0.02 });
        // SAFETY: the context is current; three vertices without attributes.
        unsafe {
            gl.disable(glow::DEPTH_TEST);
            gl.disable(glow::BLEND);
            gl.disable(glow::CULL_FACE);
            gl.bind_vertex_array(Some(self.empty.vao));
            gl.draw_arrays(glow::TRIANGLES, 0, 3);
            gl.bind_vertex_array(None);
        }
    }

    fn upload_solids(&mut self, gl: &glow::Context, picture: &Picture) {
        self.solids.clear();
        for sphere in picture.spheres.iter().filter(|_| picture.draws_spheres) {
            sphere.add_to(&mut self.solids);
        }
        // Arrows are too thin for a rim.
        self.solids.n_rimmed = self.solids.indices.len();
        for arrow in &picture.arrows {
            arrow.add_to(&mut self.solids);
        }
        // SAFETY: the context is current and the buffers are its own. The index buffer is part of the vertex array.
        unsafe {
            gl.bind_vertex_array(Some(self.solid_array.vao));
            gl.bind_buffer(glow::ARRAY_BUFFER, Some(self.solid_array.buffers[0]));
            gl.buffer_data_u8_slice(
                glow::ARRAY_BUFFER,
                bytemuck::cast_slice(&self.solids.vertices),
                glow::STREAM_DRAW,
            );
            gl.buffer_data_u8_slice(
                glow::ELEMENT_ARRAY_BUFFER,
                bytemuck::cast_slice(&self.solids.indices),
                glow::STREAM_DRAW,
            );
            gl.bind_vertex_array(None);
        }
    }

    fn draw_solids(&self, gl: &glow::Context, light: &Light, rimmed: bool) {
        if self.solids.indices.is_empty() {
            return;
        }
        let program = self.solid.bind(gl);
        light.set(&program);
        program.vec3("u_rim_color", RIM);
        let n_rimmed = if rimmed { self.solids.n_rimmed } else { 0 };
        let parts = [
            (0..n_rimmed, 1.0),
            (n_rimmed..self.solids.indices.len(), 0.0),
        ];
        // SAFETY: the context is current and every index was made with its vertex.
        unsafe {
            gl.enable(glow::DEPTH_TEST);
            gl.depth_func(glow::LESS);
            gl.disable(glow::BLEND);
            gl.bind_vertex_array(Some(self.solid_array.vao));
            for (part, rim) in parts.into_iter().filter(|(part, _)| !part.is_empty()) {
                program.float("u_rimmed", rim);
                let from = (part.start * size_of::<u32>()) as i32;
                let n = part.len() as i32;
                gl.draw_elements(glow::TRIANGLES, n, glow::UNSIGNED_INT, from);
            }
            gl.bind_vertex_array(None);
        }
    }

    fn present(&self, gl: &glow::Context, picture: &Picture) {
        let Some(target) = &self.targets[usize::from(picture.draft)] else {
            return;
        };
        let program = match &self.anaglyph {
            Some(anaglyph) => anaglyph.bind(gl),
            None => self.present.bind(gl),
        };
        program.int("u_picture", 0);
        // SAFETY: the context is current; three vertices without attributes.
        unsafe {
            gl.disable(glow::BLEND);
            gl.active_texture(glow::TEXTURE0);
            gl.bind_texture(glow::TEXTURE_2D, Some(target.texture()));
            gl.bind_vertex_array(Some(self.empty.vao));
            gl.draw_arrays(glow::TRIANGLES, 0, 3);
            gl.bind_vertex_array(None);
            gl.bind_texture(glow::TEXTURE_2D, None);
        }
    }

    /// Frees every OpenGL object. The context must be current.
    pub fn delete(self, gl: &glow::Context) {
        self.empty.delete(gl);
        self.solid_array.delete(gl);
        self.layers.delete(gl);
        if let Some(skin) = self.skin {
            skin.delete(gl);
        }
        for target in self.targets.into_iter().flatten() {
            target.delete(gl);
        }
        for program in [self.floor, self.present, self.solid] {
            program.delete(gl);
        }
        self.skin_programs.delete(gl);
        if let Some(tinting) = self.tinting {
            tinting.delete(gl);
        }
        if let Some(models) = self.models {
            models.delete(gl);
        }
        if let Some(anaglyph) = self.anaglyph {
            anaglyph.delete(gl);
        }
    }
}

/// Whether a driver's name for its renderer is that of one that works on the processor.
fn draws_in_software(renderer: &str) -> bool {
    let name = renderer.to_lowercase();
    [
        "llvmpipe",
        "softpipe",
        "swrast",
        "swiftshader",
        "software",
        "basic render",
    ]
    .iter()
    .any(|known| name.contains(known))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn renderers_on_the_processor_are_known_by_name() {
        assert!(draws_in_software("llvmpipe (LLVM 19.1.7, 256 bits)"));
        assert!(draws_in_software(
            "ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device))"
        ));
        assert!(!draws_in_software(
            "Mesa Intel(R) Iris(R) Xe Graphics (TGL GT2)"
        ));
        assert!(!draws_in_software("NVIDIA GeForce RTX 4070/PCIe/SSE2"));
    }
}
