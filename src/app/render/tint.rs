//! The skin coloured by a quantity: a program, a table of colours and a buffer of values that exist only while one is shown.
//!
//! What is seen is the colour of the legend under white light: a flat piece of skin that faces the eye, in no hollow and
//! under no finger, has exactly the legend's colour. Where there is less light it is darker, where there is more it is
//! lighter, by about half as much, so that hue stays and shape still reads. Gloss and the tone of skin are left out.
#![allow(unsafe_code, reason = "OpenGL calls are unsafe by signature")] // OpenGL is a C interface; see `gl`.

use super::gl::{Bound, Program, VertexArray, attribute};
use super::values::{Held, Values};
use crate::app::colours::map::{ENTRIES, Map};
use eframe::glow::{self, HasContext as _};
use std::ops::Range;

/// How values become colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tint {
    /// The colours. A cyclic map goes round once over the range.
    pub map: Map,
    /// Values at the ends of the map, the lower one first.
    pub range: [f64; 2],
    /// Step between level lines, in the unit of the values; without lines for `None`.
    pub contour_step: Option<f64>,
}

/// Location of the value in the vertex shader.
const VALUE: u32 = 3;

/// What every coloured skin shares; made when the first one is shown.
#[derive(Debug)]
pub struct Tinting {
    program: Program,
    translucent: bool,
    table: glow::Texture,
    map: Option<Map>,
}

impl Tinting {
    /// Compiles the program, for a skin that lets through what lies below or for one that does not.
    ///
    /// # Errors
    /// What the driver's compiler says.
    pub fn new(gl: &glow::Context, translucent: bool) -> Result<Self, String> {
        let define = if translucent {
            "#define TINT\n#define TRANSLUCENT"
        } else {
            "#define TINT"
        };
        let with_tint = |text: &str| format!("{define}\n{text}");
        let program = Program::new(
            gl,
            "coloured skin",
            &with_tint(include_str!("shaders/skin.vert")),
            &with_tint(include_str!("shaders/skin.frag")),
        )?;
        // SAFETY: the context is current.
        let table = unsafe { gl.create_texture()? };
        Ok(Self {
            program,
            translucent,
            table,
            map: None,
        })
    }

    /// Whether it was made for a translucent skin.
    pub fn is_translucent(&self) -> bool {
        self.translucent
    }

    /// Makes the program current, with the table of `tint` in texture unit 0.
    pub fn bind<'a>(&'a mut self, gl: &'a glow::Context, tint: &Tint) -> Bound<'a> {
        // SAFETY: the context is current; the table holds the bytes of as many texels as are named.
        unsafe {
            gl.active_texture(glow::TEXTURE0);
            gl.bind_texture(glow::TEXTURE_2D, Some(self.table));
            if self.map.replace(tint.map) != Some(tint.map) {
                let texels: Vec<u8> = tint
                    .map
                    .table()
                    .iter()
                    .flat_map(|&[r, g, b]| [r, g, b, 255])
                    .collect();
                gl.tex_image_2d(
                    glow::TEXTURE_2D,
                    0,
                    glow::RGBA8 as i32,
                    ENTRIES as i32,
                    1,
                    0,
                    glow::RGBA,
                    glow::UNSIGNED_BYTE,
                    glow::PixelUnpackData::Slice(Some(&texels)),
                );
                let around = if tint.map == Map::Cyclic {
                    glow::REPEAT
                } else {
                    glow::CLAMP_TO_EDGE
                };
                for (key, value) in [
                    (glow::TEXTURE_MIN_FILTER, glow::LINEAR),
                    (glow::TEXTURE_MAG_FILTER, glow::LINEAR),
                    (glow::TEXTURE_WRAP_S, around),
                    (glow::TEXTURE_WRAP_T, glow::CLAMP_TO_EDGE),
                ] {
                    gl.tex_parameter_i32(glow::TEXTURE_2D, key, value as i32);
                }
            }
        }
        let bound = self.program.bind(gl);
        bound.int("u_table", 0);
        let [low, high] = tint.range;
        let width = high - low;
        let per_width = if width > 0.0 && width.is_finite() {
            1.0 / width
        } else {
            0.0
        };
        bound.float("u_low", low as f32);
        bound.float("u_per_width", per_width as f32);
        bound.int("u_cyclic", i32::from(tint.map == Map::Cyclic));
        let lines = tint
            .contour_step
            .filter(|step| *step > 0.0 && step.is_finite());
        bound.float("u_lines_per_unit", lines.map_or(0.0, |s| 1.0 / s) as f32);
        bound
    }

    /// Frees it.
    pub fn delete(self, gl: &glow::Context) {
        self.program.delete(gl);
        // SAFETY: the handle belongs to this context, which is current, and is not used again.
        unsafe { gl.delete_texture(self.table) };
    }
}

/// The values of one skin on the graphics card: nothing but a constant where they are the same everywhere.
#[derive(Debug)]
pub struct TintBuffer {
    values_id: u64,
    /// The skin's vertex array once more, with the values beside.
    pub(super) array: VertexArray,
    same: Option<f32>,
}

impl TintBuffer {
    /// Uploads `values` whole. `declare` binds and declares what the skin itself needs in the bound vertex array.
    ///
    /// # Errors
    /// The driver is out of handles.
    pub fn new(
        gl: &glow::Context,
        values: &mut Values,
        declare: impl FnOnce(&glow::Context),
    ) -> Result<Self, String> {
        let (n_buffers, same) = match values.held() {
            Held::Same(x) => (0, Some(*x)),
            Held::Each(_) => (1, None),
        };
        let array = VertexArray::new(gl, n_buffers)?;
        // SAFETY: the context is current; array and buffers are its own and bound before attributes are declared.
        unsafe {
            gl.bind_vertex_array(Some(array.vao));
            declare(gl);
            if let Held::Each(held) = values.held() {
                gl.bind_buffer(glow::ARRAY_BUFFER, Some(array.buffers[0]));
                gl.buffer_data_u8_slice(
                    glow::ARRAY_BUFFER,
                    bytemuck::cast_slice(held),
                    glow::DYNAMIC_DRAW,
                );
                attribute(gl, VALUE, 1, glow::FLOAT, size_of::<f32>(), 0);
            }
            gl.bind_vertex_array(None);
        }
        values.changed.clear();
        Ok(Self {
            values_id: values.id(),
            array,
            same,
        })
    }

    /// Whether it holds these values.
    pub fn is_of(&self, values: &Values) -> bool {
        self.values_id == values.id()
    }

    /// Uploads what changed; returns how many numbers went up.
    pub fn upload_changes(
        &self,
        gl: &glow::Context,
        values: &mut Values,
        runs: &mut Vec<Range<u32>>,
    ) -> usize {
        super::mesh::take_runs(&mut values.changed, runs);
        let Held::Each(held) = values.held() else {
            return 0;
        };
        // SAFETY: the context is current; every run lies within the buffer, which holds as many numbers as `held`.
        unsafe {
            gl.bind_buffer(glow::ARRAY_BUFFER, self.array.buffers.first().copied());
            for run in runs.iter() {
                let part = &held[run.start as usize..run.end as usize];
                let offset = run.start as usize * size_of::<f32>();
                gl.buffer_sub_data_u8_slice(
                    glow::ARRAY_BUFFER,
                    offset as i32,
                    bytemuck::cast_slice(part),
                );
            }
            gl.bind_buffer(glow::ARRAY_BUFFER, None);
        }
        runs.iter().map(|run| run.len()).sum()
    }

    /// Sets the value that an array without numbers per vertex does not declare.
    pub fn set_constant(&self, gl: &glow::Context) {
        if let Some(x) = self.same {
            // SAFETY: the context is current.
            unsafe { gl.vertex_attrib_1_f32(VALUE, x) };
        }
    }

    /// Frees it.
    pub fn delete(self, gl: &glow::Context) {
        self.array.delete(gl);
    }
}
