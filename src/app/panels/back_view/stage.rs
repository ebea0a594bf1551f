//! What the panel and its paint callback share: the skin to upload, the picture to draw, the renderer that draws it.

use crate::app::render::mesh::{Shade, SkinMesh};
use crate::app::render::{Painted, Picture, Renderer, shade};
use crate::surface::Surface;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};
use std::time::{Duration, Instant};

/// Surfaces up to this many vertices are baked at once: it takes less than 0.1 s, and the first frame shows them finished.
const BAKED_AT_ONCE: usize = 5_000;
/// How long nothing may have moved until a draft is drawn finely.
const STILL: Duration = Duration::from_millis(150);

fn finely_id() -> egui::Id {
    egui::Id::unique("back view without drafts")
}

/// Never draws drafts from now on: for a window that is to be pictured.
pub fn draw_finely(ctx: &egui::Context) {
    ctx.data_mut(|d| d.insert_temp(finely_id(), true));
}

/// The state behind the paint callback.
#[derive(Debug, Default)]
pub struct Stage {
    renderer: Option<Renderer>,
    /// The skin on show.
    pub mesh: Option<SkinMesh>,
    /// What to draw beside it.
    picture: Option<Picture>,
    /// When picture or skin last changed.
    moved: Option<Instant>,
    /// Why nothing can be drawn, in words.
    pub fault: Option<String>,
    /// What the last frame did.
    pub painted: Painted,
    /// How long its calls took on the processor, ms.
    pub paint_ms: f64,
    baking: Option<mpsc::Receiver<Vec<Shade>>>,
}

/// The stage, shared with the callback.
#[derive(Clone, Debug, Default)]
pub struct SharedStage(Arc<Mutex<Stage>>);

impl SharedStage {
    /// Locks it: briefly, and never while another window draws.
    pub fn lock(&self) -> MutexGuard<'_, Stage> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The callback that paints the picture into its place in the window.
    pub fn callback(&self, rect: egui::Rect) -> egui::PaintCallback {
        let stage = self.clone();
        egui::PaintCallback {
            rect,
            callback: Arc::new(eframe::egui_glow::CallbackFn::new(move |info, painter| {
                let place = info.viewport_in_pixels();
                let size_px = [place.width_px, place.height_px].map(|n| n.max(1).unsigned_abs());
                stage.lock().paint(painter.gl(), size_px);
            })),
        }
    }
}

impl Stage {
    /// Puts another surface on, at rest. `ctx` is woken when its shading is baked.
    pub fn set_surface(&mut self, surface: &Arc<Surface>, ctx: &egui::Context) {
        let mut mesh = SkinMesh::new(surface.clone());
        self.baking = None;
        if surface.positions().len() <= BAKED_AT_ONCE {
            mesh.set_shade(shade::bake(surface, 1));
        } else {
            let (send, receive) = mpsc::sync_channel(1);
            let (surface, ctx) = (surface.clone(), ctx.clone());
            let threads = std::thread::available_parallelism().map_or(1, usize::from);
            let spawned = std::thread::Builder::new()
                .name("shade".into())
                .spawn(move || {
                    // The panel may have gone on to another surface: then nobody receives.
                    let _ = send.send(shade::bake(&surface, threads.div_ceil(2)));
                    ctx.request_repaint();
                });
            // Without a thread the skin is drawn plain: still whole and right.
            self.baking = spawned.is_ok().then_some(receive);
        }
        self.mesh = Some(mesh);
        self.picture = None;
        self.moved = None;
    }

    /// Hands in what to draw next, as a fine picture. Where OpenGL draws on the processor a moving one is drawn as a draft
    /// instead, and `ctx` is woken when it has been still for long enough.
    pub fn set_picture(&mut self, mut picture: Picture, ctx: &egui::Context) {
        if let Some(last) = &self.picture {
            picture.size_px = last.size_px;
            picture.draft = last.draft;
            if *last != picture || self.mesh.as_ref().is_some_and(SkinMesh::has_changes) {
                self.moved = Some(Instant::now());
            }
        }
        let still_in = self.moved.and_then(|at| STILL.checked_sub(at.elapsed()));
        let software = self.renderer.as_ref().is_some_and(Renderer::is_software);
        let finely = ctx.data(|d| d.get_temp(finely_id()).unwrap_or(false));
        picture.draft = still_in.is_some() && software && !finely;
        if let Some(rest) = still_in.filter(|_| picture.draft) {
            ctx.request_repaint_after(rest);
        }
        self.picture = Some(picture);
    }

    /// Takes over a finished bake.
    pub fn poll_bake(&mut self) {
        let Some(receive) = &self.baking else { return };
        match receive.try_recv() {
            Ok(shade) => {
                if let Some(mesh) = &mut self.mesh {
                    mesh.set_shade(shade);
                }
                self.baking = None;
            }
            Err(mpsc::TryRecvError::Empty) => {}
            Err(mpsc::TryRecvError::Disconnected) => self.baking = None,
        }
    }

    /// Frees the skin and everything on the graphics card; the next surface starts anew.
    pub fn release(&mut self, gl: Option<&eframe::glow::Context>) {
        self.mesh = None;
        self.picture = None;
        self.baking = None;
        if let (Some(gl), Some(renderer)) = (gl, self.renderer.take()) {
            renderer.delete(gl);
        }
    }

    fn paint(&mut self, gl: &eframe::glow::Context, size_px: [u32; 2]) {
        let start = Instant::now();
        let (Some(picture), Some(mesh)) = (&mut self.picture, &mut self.mesh) else {
            return;
        };
        picture.size_px = size_px;
        let renderer = match &mut self.renderer {
            Some(renderer) => renderer,
            None => match Renderer::new(gl) {
                Ok(renderer) => self.renderer.insert(renderer),
                Err(fault) => {
                    self.fault = Some(fault);
                    return;
                }
            },
        };
        match renderer.paint(gl, picture, mesh) {
            Ok(painted) => {
                self.painted = painted;
                self.fault = None;
            }
            Err(fault) => self.fault = Some(fault),
        }
        self.paint_ms = start.elapsed().as_secs_f64() * 1e3;
    }
}
