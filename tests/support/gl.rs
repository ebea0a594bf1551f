//! An OpenGL context without a display, and a renderer of egui output on it: the real paint callbacks run.
#![allow(unsafe_code, dead_code)] // EGL and OpenGL are C interfaces; each test file uses its own part of this one.

use eframe::egui_glow::{self, glow};
use egui_glow::glow::HasContext as _;
use glutin::api::egl::{
    config::Config, context::PossiblyCurrentContext, device::Device, display::Display,
    surface::Surface,
};
use glutin::config::{ConfigSurfaceTypes, ConfigTemplateBuilder};
use glutin::context::{ContextApi, ContextAttributesBuilder, GlProfile, Version};
use glutin::display::GlDisplay as _;
use glutin::prelude::{NotCurrentGlContext as _, PossiblyCurrentGlContext as _};
use glutin::surface::{PbufferSurface, SurfaceAttributesBuilder};
use std::ffi::CString;
use std::num::NonZeroU32;
use std::sync::Arc;

/// Which of the two kinds of context the program must run on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Api {
    /// OpenGL 3.3 core.
    Core33,
    /// OpenGL ES 3.0.
    Es30,
}

/// A current context on an off-screen surface.
pub struct OffScreen {
    pub gl: Arc<glow::Context>,
    pub size_px: [u32; 2],
    context: PossiblyCurrentContext,
    surface: Surface<PbufferSurface>,
}

impl OffScreen {
    /// Makes a context and makes it current on this thread, or tells why the test is skipped.
    pub fn or_skip(api: Api, size_px: [u32; 2]) -> Option<Self> {
        match Self::new(api, size_px) {
            Ok(screen) => Some(screen),
            Err(reason) => {
                println!("skipped: no off-screen OpenGL ({api:?}): {reason}");
                None
            }
        }
    }

    fn new(api: Api, size_px: [u32; 2]) -> Result<Self, String> {
        let say = |what: &str| {
            let what = what.to_owned();
            move |e: glutin::error::Error| format!("{what}: {e}")
        };
        let devices: Vec<Device> = Device::query_devices()
            .map_err(say("no EGL devices"))?
            .collect();
        let mut reason = "no EGL device".to_owned();
        for device in &devices {
            // SAFETY: no native display handle is passed.
            match unsafe { Display::with_device(device, None) }
                .map_err(say("no display"))
                .and_then(|display| Self::on(&display, api, size_px))
            {
                Ok(screen) => return Ok(screen),
                Err(e) => reason = e,
            }
        }
        Err(reason)
    }

    fn on(display: &Display, api: Api, size_px: [u32; 2]) -> Result<Self, String> {
        let say = |e: glutin::error::Error| e.to_string();
        let template = ConfigTemplateBuilder::new()
            .with_surface_type(ConfigSurfaceTypes::PBUFFER)
            .with_alpha_size(8)
            .build();
        // SAFETY: the template names no native window; every call below is made on objects of this display.
        unsafe {
            let config: Config = display
                .find_configs(template)
                .map_err(say)?
                .next()
                .ok_or("no pbuffer configuration")?;
            let wanted = match api {
                Api::Core33 => ContextApi::OpenGl(Some(Version::new(3, 3))),
                Api::Es30 => ContextApi::Gles(Some(Version::new(3, 0))),
            };
            let attributes = ContextAttributesBuilder::new()
                .with_context_api(wanted)
                .with_profile(GlProfile::Core)
                .build(None);
            let context = display.create_context(&config, &attributes).map_err(say)?;
            let [w, h] = size_px.map(|n| NonZeroU32::new(n).unwrap_or(NonZeroU32::MIN));
            let surface = display
                .create_pbuffer_surface(
                    &config,
                    &SurfaceAttributesBuilder::<PbufferSurface>::new().build(w, h),
                )
                .map_err(say)?;
            let context = context.make_current(&surface).map_err(say)?;
            let gl = glow::Context::from_loader_function(|name| {
                CString::new(name).map_or(std::ptr::null(), |name| {
                    display.get_proc_address(&name).cast()
                })
            });
            Ok(Self {
                gl: Arc::new(gl),
                size_px,
                context,
                surface,
            })
        }
    }

    /// Makes it current again, for tests that use several.
    pub fn make_current(&self) {
        self.context.make_current(&self.surface).unwrap();
    }

    /// The window's pixels, rows from the top, RGBA.
    pub fn pixels(&self) -> Image {
        let [w, h] = self.size_px;
        let mut data = vec![0; (w * h * 4) as usize];
        // SAFETY: the slice holds exactly the bytes of the rectangle read.
        unsafe {
            self.gl.bind_framebuffer(glow::FRAMEBUFFER, None);
            self.gl.read_pixels(
                0,
                0,
                w as i32,
                h as i32,
                glow::RGBA,
                glow::UNSIGNED_BYTE,
                glow::PixelPackData::Slice(Some(&mut data)),
            );
        }
        let row = (w * 4) as usize;
        let data = data.chunks(row).rev().flatten().copied().collect();
        Image {
            size_px: [w, h],
            data,
        }
    }

    /// Clears the window and sets viewport and scissor as egui does before a callback over all of it.
    pub fn begin(&self) {
        let [w, h] = self.size_px.map(|n| n as i32);
        // SAFETY: the context is current.
        unsafe {
            self.gl.bind_framebuffer(glow::FRAMEBUFFER, None);
            self.gl.viewport(0, 0, w, h);
            self.gl.disable(glow::SCISSOR_TEST);
            self.gl.clear_color(0.0, 0.0, 0.0, 1.0);
            self.gl.clear(glow::COLOR_BUFFER_BIT);
            self.gl.enable(glow::SCISSOR_TEST);
            self.gl.scissor(0, 0, w, h);
        }
    }

    /// The error flag of OpenGL, which must be clear after every picture.
    pub fn error(&self) -> u32 {
        // SAFETY: the context is current.
        unsafe { self.gl.get_error() }
    }
}

/// Pixels, rows from the top, RGBA.
#[derive(Clone, PartialEq, Eq)]
pub struct Image {
    pub size_px: [u32; 2],
    pub data: Vec<u8>,
}

impl Image {
    /// Colour at a pixel, clamped to the border.
    pub fn at(&self, x: f64, y: f64) -> [u8; 3] {
        let [w, h] = self.size_px;
        let (x, y) = (
            (x.max(0.0) as u32).min(w - 1),
            (y.max(0.0) as u32).min(h - 1),
        );
        let i = ((y * w + x) * 4) as usize;
        [self.data[i], self.data[i + 1], self.data[i + 2]]
    }

    /// Pixels that differ from `other` by more than `bound` in any channel.
    pub fn differing(&self, other: &Self, bound: u8) -> Vec<[u32; 2]> {
        assert_eq!(self.size_px, other.size_px);
        let w = self.size_px[0];
        (self.data.chunks(4).zip(other.data.chunks(4)))
            .enumerate()
            .filter(|(_, (a, b))| a.iter().zip(*b).any(|(x, y)| x.abs_diff(*y) > bound))
            .map(|(i, _)| [i as u32 % w, i as u32 / w])
            .collect()
    }

    /// Writes a PNG where the variable `DORSUM_TEST_IMAGES` names a folder, so that a person can look at it.
    pub fn keep(&self, name: &str) {
        let Some(folder) = std::env::var_os("DORSUM_TEST_IMAGES") else {
            return;
        };
        let file = std::fs::File::create(std::path::Path::new(&folder).join(name)).unwrap();
        let mut encoder = png::Encoder::new(
            std::io::BufWriter::new(file),
            self.size_px[0],
            self.size_px[1],
        );
        encoder.set_color(png::ColorType::Rgba);
        let opaque: Vec<u8> = self
            .data
            .chunks(4)
            .flat_map(|p| [p[0], p[1], p[2], 255])
            .collect();
        encoder
            .write_header()
            .unwrap()
            .write_image_data(&opaque)
            .unwrap();
    }
}

/// Paints egui output onto an [`OffScreen`].
pub struct Painter {
    painter: egui_glow::Painter,
}

impl Painter {
    pub fn new(screen: &OffScreen) -> Self {
        let painter = egui_glow::Painter::new(screen.gl.clone(), "", None, false).unwrap();
        Self { painter }
    }

    /// Takes over new and freed textures.
    pub fn textures(&mut self, delta: &mut egui::TexturesDelta) {
        self.painter
            .paint_and_update_textures([1, 1], 1.0, &[], delta);
    }

    /// Paints one frame and reads it back.
    pub fn paint(
        &mut self,
        screen: &OffScreen,
        ctx: &egui::Context,
        shapes: Vec<egui::epaint::ClippedShape>,
    ) -> Image {
        let primitives = ctx.tessellate(shapes, ctx.pixels_per_point());
        self.painter.clear(screen.size_px, [0.0, 0.0, 0.0, 1.0]);
        self.painter
            .paint_primitives(screen.size_px, ctx.pixels_per_point(), &primitives);
        screen.pixels()
    }
}

impl Drop for Painter {
    fn drop(&mut self) {
        self.painter.destroy();
    }
}
