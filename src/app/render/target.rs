//! The picture's own framebuffer: multisampled where the driver can, resolved into a texture that is kept, so that a
//! window repainted for another reason does not draw the skin anew.
#![allow(unsafe_code, reason = "OpenGL calls are unsafe by signature")] // OpenGL is a C interface; see `gl`.

use eframe::glow::{self, HasContext as _};

/// A framebuffer of one size.
#[derive(Debug)]
pub struct Target {
    size_px: [u32; 2],
    samples: i32,
    drawn_on: glow::Framebuffer,
    color: Option<glow::Renderbuffer>,
    depth: glow::Renderbuffer,
    resolved: Option<glow::Framebuffer>,
    texture: glow::Texture,
}

impl Target {
    /// Makes one with up to `samples` samples per pixel; falls back to one sample where the driver refuses more.
    ///
    /// # Errors
    /// The driver refuses even a plain one.
    pub fn new(gl: &glow::Context, size_px: [u32; 2], samples: i32) -> Result<Self, String> {
        let target = Self::try_new(gl, size_px, samples)?;
        if target.complete(gl) {
            return Ok(target);
        }
        target.delete(gl);
        let plain = Self::try_new(gl, size_px, 1)?;
        if plain.complete(gl) {
            return Ok(plain);
        }
        plain.delete(gl);
        Err(format!(
            "OpenGL gives no framebuffer of {} × {} pixels",
            size_px[0], size_px[1]
        ))
    }

    fn try_new(gl: &glow::Context, size_px: [u32; 2], samples: i32) -> Result<Self, String> {
        let [w, h] = size_px.map(|n| n as i32);
        // SAFETY: the context is current; handles are used with it only. The caller restores the bindings.
        unsafe {
            let texture = gl.create_texture()?;
            gl.bind_texture(glow::TEXTURE_2D, Some(texture));
            gl.tex_image_2d(
                glow::TEXTURE_2D,
                0,
                glow::RGBA8 as i32,
                w,
                h,
                0,
                glow::RGBA,
                glow::UNSIGNED_BYTE,
                glow::PixelUnpackData::Slice(None),
            );
            for (key, value) in [
                (glow::TEXTURE_MIN_FILTER, glow::NEAREST),
                (glow::TEXTURE_MAG_FILTER, glow::NEAREST),
                (glow::TEXTURE_WRAP_S, glow::CLAMP_TO_EDGE),
                (glow::TEXTURE_WRAP_T, glow::CLAMP_TO_EDGE),
            ] {
                gl.tex_parameter_i32(glow::TEXTURE_2D, key, value as i32);
            }
            let depth = gl.create_renderbuffer()?;
            gl.bind_renderbuffer(glow::RENDERBUFFER, Some(depth));
            let drawn_on = gl.create_framebuffer()?;
            gl.bind_framebuffer(glow::FRAMEBUFFER, Some(drawn_on));
            let (color, resolved) = if samples > 1 {
                gl.renderbuffer_storage_multisample(
                    glow::RENDERBUFFER,
                    samples,
                    glow::DEPTH_COMPONENT24,
                    w,
                    h,
                );
                let color = gl.create_renderbuffer()?;
                gl.bind_renderbuffer(glow::RENDERBUFFER, Some(color));
                gl.renderbuffer_storage_multisample(glow::RENDERBUFFER, samples, glow::RGBA8, w, h);
                gl.framebuffer_renderbuffer(
                    glow::FRAMEBUFFER,
                    glow::COLOR_ATTACHMENT0,
                    glow::RENDERBUFFER,
                    Some(color),
                );
                let resolved = gl.create_framebuffer()?;
                gl.bind_framebuffer(glow::FRAMEBUFFER, Some(resolved));
                gl.framebuffer_texture_2d(
                    glow::FRAMEBUFFER,
                    glow::COLOR_ATTACHMENT0,
                    glow::TEXTURE_2D,
                    Some(texture),
                    0,
                );
                gl.bind_framebuffer(glow::FRAMEBUFFER, Some(drawn_on));
                (Some(color), Some(resolved))
            } else {
                gl.renderbuffer_storage(glow::RENDERBUFFER, glow::DEPTH_COMPONENT24, w, h);
                gl.framebuffer_texture_2d(
                    glow::FRAMEBUFFER,
                    glow::COLOR_ATTACHMENT0,
                    glow::TEXTURE_2D,
                    Some(texture),
                    0,
                );
                (None, None)
            };
            gl.framebuffer_renderbuffer(
                glow::FRAMEBUFFER,
                glow::DEPTH_ATTACHMENT,
                glow::RENDERBUFFER,
                Some(depth),
            );
            Ok(Self {
                size_px,
                samples: samples.max(1),
                drawn_on,
                color,
                depth,
                resolved,
                texture,
            })
        }
    }

    fn complete(&self, gl: &glow::Context) -> bool {
        [Some(self.drawn_on), self.resolved]
            .into_iter()
            .flatten()
            .all(|fbo| {
                // SAFETY: the handle belongs to the current context.
                unsafe {
                    gl.bind_framebuffer(glow::FRAMEBUFFER, Some(fbo));
                    gl.check_framebuffer_status(glow::FRAMEBUFFER) == glow::FRAMEBUFFER_COMPLETE
                }
            })
    }

    /// Its size, pixels.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// Samples per pixel.
    pub fn samples(&self) -> i32 {
        self.samples
    }

    /// What was drawn, resolved.
    pub fn texture(&self) -> glow::Texture {
        self.texture
    }

    /// Makes it the framebuffer drawn on, whole and with a clear depth.
    pub fn begin(&self, gl: &glow::Context) {
        // SAFETY: the handle belongs to the current context.
        unsafe {
            gl.bind_framebuffer(glow::FRAMEBUFFER, Some(self.drawn_on));
            gl.viewport(0, 0, self.size_px[0] as i32, self.size_px[1] as i32);
            gl.disable(glow::SCISSOR_TEST);
            gl.depth_mask(true);
            gl.clear_depth_f32(1.0);
            gl.clear(glow::DEPTH_BUFFER_BIT);
        }
    }

    /// Brings what was drawn into the texture.
    pub fn resolve(&self, gl: &glow::Context) {
        let Some(resolved) = self.resolved else {
            return;
        };
        let [w, h] = self.size_px.map(|n| n as i32);
        // SAFETY: the handles belong to the current context.
        unsafe {
            gl.bind_framebuffer(glow::READ_FRAMEBUFFER, Some(self.drawn_on));
            gl.bind_framebuffer(glow::DRAW_FRAMEBUFFER, Some(resolved));
            gl.blit_framebuffer(
                0,
                0,
                w,
                h,
                0,
                0,
                w,
                h,
                glow::COLOR_BUFFER_BIT,
                glow::NEAREST,
            );
        }
    }

    /// Frees it.
    pub fn delete(self, gl: &glow::Context) {
        // SAFETY: the handles belong to the current context and are not used again.
        unsafe {
            gl.delete_framebuffer(self.drawn_on);
            if let Some(fbo) = self.resolved {
                gl.delete_framebuffer(fbo);
            }
            if let Some(color) = self.color {
                gl.delete_renderbuffer(color);
            }
            gl.delete_renderbuffer(self.depth);
            gl.delete_texture(self.texture);
        }
    }
}
