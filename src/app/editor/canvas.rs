//! The map plane as a picture to work on: field, lines, outline of the back, rulers; moved and magnified by hand.

use super::backdrop::{LEFT, LOW, contours, grid, image, landmarks, rulers};
use super::field::Picture;
use super::ink::{Ink, Inks};
use super::plane::{Area, Plane};
use super::scale::Scale;
use super::silhouette::Silhouette;
use super::worker::Worker;
use crate::app::bench::Wake;
use crate::app::theme::Theme;
use crate::geom::Vec2;
use crate::scenario::{Scene, SurfaceChoice};
use crate::surface::Surface;
use crate::surface::back::{self, Landmark};
use egui::{
    Color32, ColorImage, FontId, Key, PointerButton, Pos2, Rect, Shape, Stroke, TextureHandle,
    TextureOptions, pos2, vec2,
};
use std::sync::Arc;

/// How much a key zooms.
const KEY_ZOOM: f64 = 1.25;
/// Room around the back when it is fitted, mm.
const ROOM_MM: f64 = 6.0;

/// The canvas of one editor.
#[derive(Default)]
pub struct Canvas {
    plane: Plane,
    /// The size it was fitted for, until the user looks elsewhere.
    fitted: Option<egui::Vec2>,
    looked: bool,
    /// What is fitted instead of the back.
    frame: Option<Area>,
    silhouette: Option<Arc<Silhouette>>,
    worker: Option<Worker<Silhouette>>,
    surface: Option<Arc<Surface>>,
    landmarks: Vec<Landmark>,
    field: Option<Textured>,
    veil: Option<(TextureHandle, Area, Color32)>,
}

/// What the pointer and keys did to the canvas itself.
pub struct Handled {
    /// The canvas.
    pub response: egui::Response,
    /// The place under the pointer, mm.
    pub cursor_mm: Option<Vec2>,
    lay: Lay,
}

impl Handled {
    /// The place of the map at a point of the canvas, mm.
    pub fn to_map(&self, p: Pos2) -> Option<Vec2> {
        let on = self.lay.rect.contains(p);
        on.then(|| self.lay.plane.to_map(self.lay.rect, p))
    }
}

/// The field as a texture, and what it was made of.
struct Textured {
    texture: TextureHandle,
    area: Area,
    made: u64,
    scale: Scale,
}

/// A canvas with its place on the screen, to lay things on.
#[derive(Clone, Copy)]
pub struct Lay {
    /// The place.
    pub rect: Rect,
    /// What is seen of the map.
    pub plane: Plane,
}

impl Lay {
    /// Where a place of the map is on the screen.
    pub fn at(&self, p: Vec2) -> Pos2 {
        self.plane.to_screen(self.rect, p)
    }

    /// A line through places of the map.
    pub fn line(&self, points: impl IntoIterator<Item = Vec2>) -> Vec<Pos2> {
        points.into_iter().map(|p| self.at(p)).collect()
    }

    /// Whether a point of the screen is on the canvas, give or take `room` points.
    pub fn sees(&self, p: Pos2, room: f32) -> bool {
        self.rect.expand(room).contains(p)
    }
}

impl Canvas {
    /// Frees everything but where the user looks.
    pub fn clear(&mut self) {
        (self.silhouette, self.worker, self.surface) = (None, None, None);
        (self.field, self.veil) = (None, None);
        self.landmarks = Vec::new();
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let texture = |t: &TextureHandle| t.size()[0] * t.size()[1] * 4;
        self.silhouette.as_ref().map_or(0, |s| s.bytes())
            + self.field.as_ref().map_or(0, |f| texture(&f.texture))
            + self.veil.as_ref().map_or(0, |v| texture(&v.0))
    }

    /// The outline of the back, once it is known.
    pub fn silhouette(&self) -> Option<&Arc<Silhouette>> {
        self.silhouette.as_ref()
    }

    /// What is fitted: a given frame, or the back.
    pub fn frame(&self) -> Option<Area> {
        self.frame
            .or_else(|| self.silhouette.as_ref().map(|s| s.area.grown(ROOM_MM)))
    }

    /// Fits `frame`, or the back, from the next frame on.
    pub fn fit(&mut self, frame: Option<Area>) {
        self.frame = frame;
        self.fitted = None;
        self.looked = false;
    }

    /// The part of the map in `rect`.
    pub fn visible(&self, rect: Rect) -> Area {
        self.plane.visible(rect)
    }

    /// Follows the surface of `scene`: its outline is found off the window's thread.
    pub fn follow(&mut self, scene: &Scene, wake: &Wake) {
        let same = |s: &Arc<Surface>| Arc::ptr_eq(s, &scene.surface);
        if !self.surface.as_ref().is_some_and(same) {
            self.surface = Some(scene.surface.clone());
            self.silhouette = None;
            self.veil = None;
            self.fit(self.frame);
            self.landmarks = match scene.scenario.surface {
                SurfaceChoice::BuiltinBack { triangles } => back::landmarks(&back::BackOptions {
                    triangles,
                    ..back::BackOptions::default()
                }),
                SurfaceChoice::Mesh { .. } => Vec::new(),
            };
            let surface = scene.surface.clone();
            let mut worker = Worker::new("map outline");
            worker.ask(false, move |go_on| Silhouette::of(&surface, go_on), wake);
            self.worker = Some(worker);
        }
        if let Some(worker) = &mut self.worker {
            if let Some(found) = worker.poll(wake) {
                self.silhouette = Some(Arc::new(found));
                self.fitted = None;
            }
            if !worker.is_busy() {
                self.worker = None;
            }
        }
    }

    /// Takes its place, and what hand and keys do to the view. With `drag_moves` a drag of the main button moves the map;
    /// the middle button always does.
    pub fn place(
        &mut self,
        ui: &mut egui::Ui,
        rect: Rect,
        name: &str,
        drag_moves: bool,
    ) -> Handled {
        let response = ui.allocate_rect(rect, egui::Sense::click_and_drag());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::accesskit::Role::Canvas, ui.is_enabled(), name)
        });
        if response.clicked() || response.drag_started() {
            response.request_focus();
        }
        if let Some(frame) = self.frame()
            && !self.looked
            && self.fitted != Some(rect.size())
        {
            self.plane = fitted(&frame, rect);
            self.fitted = Some(rect.size());
        }
        let mut looked = false;
        if response.dragged_by(PointerButton::Middle)
            || (drag_moves && response.dragged_by(PointerButton::Primary))
        {
            looked |= self.plane.pan(response.drag_delta());
        }
        let over = ui.rect_contains_pointer(rect);
        let pointer = ui.input(|i| i.pointer.latest_pos());
        let cursor_mm = pointer
            .filter(|p| over && rect.contains(*p))
            .map(|p| self.plane.to_map(rect, p));
        if let Some(about) = cursor_mm {
            let (wheel, pinch) = ui.input(|i| {
                (
                    f64::from(i.smooth_scroll_delta().y),
                    f64::from(i.zoom_delta()),
                )
            });
            let factor = libm::exp(wheel * 0.0025) * pinch;
            if factor != 1.0 {
                looked |= self.plane.zoom(factor, about);
                // The scroll area around must not move as well.
                ui.input_mut(|i| i.smooth_scroll_delta = egui::Vec2::ZERO);
            }
        }
        if response.has_focus() {
            looked |= self.keys(ui, &response);
        }
        self.looked |= looked;
        if looked {
            ui.ctx().request_repaint();
        }
        Handled {
            response,
            cursor_mm,
            lay: self.lay(rect),
        }
    }

    fn keys(&mut self, ui: &egui::Ui, response: &egui::Response) -> bool {
        let filter = egui::EventFilter {
            horizontal_arrows: true,
            vertical_arrows: true,
            ..egui::EventFilter::default()
        };
        ui.memory_mut(|m| m.set_focus_lock_filter(response.id, filter));
        let (mv, zoom) = ui.input(|i| {
            let hits =
                |keys: &[Key]| -> f32 { keys.iter().map(|&k| i.num_presses(k) as f32).sum() };
            (
                vec2(
                    hits(&[Key::ArrowLeft]) - hits(&[Key::ArrowRight]),
                    hits(&[Key::ArrowUp]) - hits(&[Key::ArrowDown]),
                ),
                hits(&[Key::Plus, Key::Equals]) - hits(&[Key::Minus]),
            )
        });
        let mut looked = false;
        if mv != egui::Vec2::ZERO {
            looked |= self.plane.pan(mv * 30.0);
        }
        if zoom != 0.0 {
            let about = self.plane.centre_mm;
            looked |= self.plane.zoom(KEY_ZOOM.powf(f64::from(zoom)), about);
        }
        looked
    }

    /// The place in the middle of the view, mm.
    pub fn middle(&self) -> Vec2 {
        self.plane.centre_mm
    }

    /// Magnifies about the middle.
    pub fn zoom(&mut self, factor: f64) {
        let about = self.plane.centre_mm;
        self.looked |= self.plane.zoom(factor, about);
    }

    /// To lay things on the canvas in `rect`.
    pub fn lay(&self, rect: Rect) -> Lay {
        Lay {
            rect,
            plane: self.plane,
        }
    }

    /// Which ink to use where over `field`.
    pub fn inks<'a, M>(
        &self,
        theme: &Theme,
        field: Option<(&'a Picture<M>, u64, Scale)>,
        look: Look,
    ) -> Inks<'a> {
        Inks {
            plain: Ink::of(theme),
            field: field
                .filter(|_| look.colour)
                .map(|(picture, _, scale)| (&picture.grid, scale)),
            within: self.silhouette.clone().filter(|_| look.veiled),
        }
    }

    /// Ground, field, lines and outline.
    pub fn paint<M>(
        &mut self,
        painter: &egui::Painter,
        rect: Rect,
        theme: &Theme,
        field: Option<(&Picture<M>, u64, Scale)>,
        look: Look,
    ) {
        painter.rect_filled(rect, 0.0, theme.inset);
        let lay = self.lay(rect);
        let inks = self.inks(theme, field, look);
        if let Some((picture, made, scale)) = field {
            if look.colour {
                self.texture(painter.ctx(), picture, made, scale);
                if let Some(field) = &self.field {
                    image(painter, lay, &field.texture, &field.area, Color32::WHITE);
                }
            }
            if look.lines {
                contours(painter, lay, &inks, picture, scale, look.colour);
            }
            if (look.colour || look.lines) && look.veiled {
                self.veil(painter, lay, theme);
            }
        }
        grid(painter, lay, theme);
        if let Some(s) = self.silhouette.as_ref().filter(|_| look.outline) {
            for line in &s.outline {
                let points = lay.line(line.iter().copied());
                painter.add(Shape::line(points, Stroke::new(1.4, theme.weak_text)));
            }
            landmarks(painter, lay, &inks, &self.landmarks);
        }
    }

    /// Rulers and the read-out, over everything else.
    pub fn paint_front(&self, painter: &egui::Painter, rect: Rect, theme: &Theme, told: &str) {
        let lay = self.lay(rect);
        rulers(painter, lay, theme);
        if told.is_empty() {
            return;
        }
        let galley = painter.layout_no_wrap(told.to_owned(), FontId::monospace(11.5), theme.text);
        let at = rect.left_top() + vec2(44.0, 6.0);
        let back = Rect::from_min_size(at, galley.size()).expand2(vec2(6.0, 3.0));
        painter.rect_filled(back, 3.0, theme.panel.gamma_multiply(0.88));
        painter.galley(at, galley, theme.text);
    }

    fn texture<M>(&mut self, ctx: &egui::Context, picture: &Picture<M>, made: u64, scale: Scale) {
        if let Some(field) = &self.field
            && field.made == made
            && field.scale == scale
        {
            return;
        }
        let grid = &picture.grid;
        let mut pixels = Vec::with_capacity(grid.values.len());
        // Rows of a picture go down, those of the map up.
        for row in (0..grid.rows).rev() {
            for column in 0..grid.columns {
                pixels.push(scale.colour(grid.at(column, row)));
            }
        }
        let image = ColorImage::new([grid.columns, grid.rows], pixels);
        match &mut self.field {
            Some(field) => {
                field.texture.set(image, TextureOptions::LINEAR);
                (field.area, field.made, field.scale) = (grid.area, made, scale);
            }
            None => {
                let texture = ctx.load_texture("map field", image, TextureOptions::LINEAR);
                self.field = Some(Textured {
                    texture,
                    area: grid.area,
                    made,
                    scale,
                });
            }
        }
    }

    /// What lies beside the back is dimmed.
    fn veil(&mut self, painter: &egui::Painter, lay: Lay, theme: &Theme) {
        let Some(s) = &self.silhouette else {
            return;
        };
        let colour = theme.inset;
        let grid = &s.cover;
        if self.veil.as_ref().is_none_or(|v| v.2 != colour) {
            let mut pixels = Vec::with_capacity(grid.values.len());
            for row in (0..grid.rows).rev() {
                for column in 0..grid.columns {
                    // Nothing to something over the cells about the border.
                    let out = 1.0 - ((grid.at(column, row) - 0.5) * 3.0 + 0.5).clamp(0.0, 1.0);
                    pixels.push(colour.gamma_multiply(0.78 * out as f32));
                }
            }
            let image = ColorImage::new([grid.columns, grid.rows], pixels);
            let ctx = painter.ctx();
            let texture = ctx.load_texture("beside the back", image, TextureOptions::LINEAR);
            self.veil = Some((texture, grid.area, colour));
        }
        let Some((texture, area, _)) = &self.veil else {
            return;
        };
        let inner = image(painter, lay, texture, area, Color32::WHITE);
        let full = colour.gamma_multiply(0.78);
        let whole = lay.rect;
        for part in [
            Rect::from_min_max(whole.min, pos2(whole.right(), inner.top())),
            Rect::from_min_max(pos2(whole.left(), inner.bottom()), whole.max),
            Rect::from_min_max(
                pos2(whole.left(), inner.top()),
                pos2(inner.left(), inner.bottom()),
            ),
            Rect::from_min_max(
                pos2(inner.right(), inner.top()),
                pos2(whole.right(), inner.bottom()),
            ),
        ] {
            let part = part.intersect(whole);
            if part.is_positive() {
                painter.rect_filled(part, 0.0, full);
            }
        }
    }
}

/// `area` in the part of `rect` that rulers and legend leave free.
fn fitted(area: &Area, rect: Rect) -> Plane {
    let mut free = rect;
    if rect.width() > 200.0 && rect.height() > 200.0 {
        free.min.x += LEFT;
        free.max.y -= LOW;
    }
    if rect.height() > 420.0 {
        free.max.y -= super::scale::HEIGHT;
    }
    let mut plane = Plane::fit(area, free);
    plane.centre_mm += plane.delta_mm(rect.center() - free.center());
    plane
}

/// What a canvas shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    /// The field as colour.
    pub colour: bool,
    /// Lines of equal value.
    pub lines: bool,
    /// What lies beside the back dimmed.
    pub veiled: bool,
    /// The outline of the back, with its landmarks.
    pub outline: bool,
}
