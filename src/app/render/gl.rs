//! The few OpenGL helpers that every drawing file shares.
//!
//! Works with OpenGL 3.3 core and OpenGL ES 3.0: one shader text, with the header of whichever the context is.
#![allow(unsafe_code, reason = "OpenGL calls are unsafe by signature")] // OpenGL is a C interface: every call is unsafe. All of them are made with the context current.

use eframe::glow::{self, HasContext as _};

/// A linked program and its uniforms, asked for by name.
#[derive(Debug)]
pub struct Program {
    program: glow::Program,
}

impl Program {
    /// Compiles and links.
    ///
    /// # Errors
    /// What the driver's compiler says, with the name of the program.
    pub fn new(
        gl: &glow::Context,
        name: &str,
        vertex: &str,
        fragment: &str,
    ) -> Result<Self, String> {
        let header = if gl.version().is_embedded {
            "#version 300 es\nprecision highp float;\nprecision highp int;\n"
        } else {
            "#version 330 core\n"
        };
        // SAFETY: the context is current on this thread; handles come from it and are used with it only.
        unsafe {
            let program = gl
                .create_program()
                .map_err(|e| format!("OpenGL refuses a program ({name}): {e}"))?;
            let mut shaders = Vec::new();
            for (kind, text) in [
                (glow::VERTEX_SHADER, vertex),
                (glow::FRAGMENT_SHADER, fragment),
            ] {
                let shader = gl
                    .create_shader(kind)
                    .map_err(|e| format!("OpenGL refuses a shader ({name}): {e}"))?;
                gl.shader_source(shader, &format!("{header}{text}"));
                gl.compile_shader(shader);
                if !gl.get_shader_compile_status(shader) {
                    return Err(format!(
                        "the {name} shader does not compile: {}",
                        gl.get_shader_info_log(shader).trim()
                    ));
                }
                gl.attach_shader(program, shader);
                shaders.push(shader);
            }
            gl.link_program(program);
            if !gl.get_program_link_status(program) {
                return Err(format!(
                    "the {name} program does not link: {}",
                    gl.get_program_info_log(program).trim()
                ));
            }
            for shader in shaders {
                gl.detach_shader(program, shader);
                gl.delete_shader(shader);
            }
            Ok(Self { program })
        }
    }

    /// Frees it.
    pub fn delete(self, gl: &glow::Context) {
        // SAFETY: the handle belongs to this context, which is current, and is not used again.
        unsafe { gl.delete_program(self.program) };
    }

    /// Makes it the current program and gives access to its uniforms.
    pub fn bind<'a>(&'a self, gl: &'a glow::Context) -> Bound<'a> {
        // SAFETY: as in `new`.
        unsafe { gl.use_program(Some(self.program)) };
        Bound {
            gl,
            program: self.program,
        }
    }
}

/// The current program.
pub struct Bound<'a> {
    gl: &'a glow::Context,
    program: glow::Program,
}

impl Bound<'_> {
    fn at(&self, name: &str) -> Option<glow::UniformLocation> {
        // SAFETY: the program belongs to this context, which is current. Unknown names give `None`, which GL ignores.
        unsafe { self.gl.get_uniform_location(self.program, name) }
    }

    /// Sets a matrix, column by column.
    pub fn mat4(&self, name: &str, m: &[f32; 16]) {
        // SAFETY: as in `at`; likewise below.
        unsafe {
            self.gl
                .uniform_matrix_4_f32_slice(self.at(name).as_ref(), false, m);
        }
    }

    /// Sets a matrix of three by three, column by column.
    pub fn mat3(&self, name: &str, m: &[f32; 9]) {
        unsafe {
            self.gl
                .uniform_matrix_3_f32_slice(self.at(name).as_ref(), false, m);
        }
    }

    /// Sets a vector of three.
    pub fn vec3(&self, name: &str, v: [f32; 3]) {
        unsafe {
            self.gl
                .uniform_3_f32_slice(self.at(name).as_ref(), v.as_slice());
        }
    }

    /// Sets one or more vectors of four.
    pub fn vec4s(&self, name: &str, v: &[[f32; 4]]) {
        if !v.is_empty() {
            unsafe {
                self.gl
                    .uniform_4_f32_slice(self.at(name).as_ref(), v.as_flattened());
            }
        }
    }

    /// Sets a number.
    pub fn float(&self, name: &str, x: f32) {
        unsafe { self.gl.uniform_1_f32(self.at(name).as_ref(), x) };
    }

    /// Sets a whole number or a texture unit.
    pub fn int(&self, name: &str, x: i32) {
        unsafe { self.gl.uniform_1_i32(self.at(name).as_ref(), x) };
    }
}

/// A vertex array with its buffers, deleted with [`VertexArray::delete`].
#[derive(Debug)]
pub struct VertexArray {
    pub vao: glow::VertexArray,
    pub buffers: Vec<glow::Buffer>,
}

impl VertexArray {
    /// An empty one with `n` buffers.
    ///
    /// # Errors
    /// The driver gives no more of them.
    pub fn new(gl: &glow::Context, n: usize) -> Result<Self, String> {
        // SAFETY: the context is current.
        unsafe {
            let vao = gl.create_vertex_array()?;
            let buffers = (0..n)
                .map(|_| gl.create_buffer())
                .collect::<Result<_, _>>()?;
            Ok(Self { vao, buffers })
        }
    }

    /// Frees it and its buffers.
    pub fn delete(self, gl: &glow::Context) {
        // SAFETY: the handles belong to this context, which is current, and are not used again.
        unsafe {
            gl.delete_vertex_array(self.vao);
            for b in self.buffers {
                gl.delete_buffer(b);
            }
        }
    }
}

/// Declares attribute `location` of the bound vertex array, read from the bound array buffer.
///
/// # Safety
/// A vertex array and an array buffer of this context must be bound, and the context current.
pub unsafe fn attribute(
    gl: &glow::Context,
    location: u32,
    components: i32,
    kind: u32,
    stride: usize,
    offset: usize,
) {
    let normalised = kind != glow::FLOAT;
    unsafe {
        gl.enable_vertex_attrib_array(location);
        gl.vertex_attrib_pointer_f32(
            location,
            components,
            kind,
            normalised,
            stride as i32,
            offset as i32,
        );
    }
}
