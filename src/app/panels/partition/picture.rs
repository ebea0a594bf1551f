//! The panel's own picture: the skin at rest, which the tree was built over, and the tree over it.

use super::PanelContext;
use crate::app::camera::{Camera, Glide, Preset};
use crate::app::panels::back_view::{SharedStage, model, plate, preset_text};
use crate::app::panels::legend;
use crate::app::render::mesh::SkinMesh;
use crate::app::render::{Palette, Picture, SkinLook, pixels, sphere::Sphere};
use crate::app::state::View;
use crate::app::study::Shown;
use crate::app::study::settings::{Follow, Settings};
use crate::app::theme::Theme;
use crate::contact::Touch;
use crate::geom::{Vec2, Vec3};
use crate::partition::{Partition as _, Sides};
use crate::scenario::Scene;
use crate::surface::Surface;
use egui::{Key, PointerButton};
use std::sync::Arc;

/// How far an arrow key turns the view, points of drag.
const KEY_TURN: f64 = 24.0;
/// How much a key zooms.
const KEY_ZOOM: f64 = 1.15;

/// The picture with its camera.
#[derive(Default)]
pub struct TreePicture {
    stage: SharedStage,
    surface: Option<Arc<Surface>>,
    camera: Camera,
    glide: Option<Glide>,
    /// On show until the user turns, moves or zooms.
    preset: Option<Preset>,
    framed_for: Vec2,
    focus_by_pointer: bool,
}

/// A point of the skin and its triangle.
type OnSkin = (Vec3, u32);

impl TreePicture {
    /// Why nothing can be drawn.
    pub fn fault(&self) -> Option<String> {
        self.stage.lock().fault.clone()
    }

    /// Frees everything.
    pub fn release(&mut self, view: &View) {
        if self.surface.take().is_some() {
            self.stage.lock().release(view.gl.as_deref());
        }
    }

    /// Draws it into `rect`. A click on the skin puts the box there.
    pub fn ui(
        &mut self,
        ui: &mut egui::Ui,
        rect: egui::Rect,
        cx: &PanelContext<'_>,
        scene: &Scene,
        shown: &Shown,
        settings: &mut Settings,
    ) {
        let size = pixels::delta(rect.size());
        if size.x < 8.0 || size.y < 8.0 {
            return;
        }
        self.follow_surface(ui.ctx(), scene);
        let response = ui.allocate_rect(rect, egui::Sense::click_and_drag());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(
                egui::accesskit::Role::Canvas,
                ui.is_enabled(),
                "Picture of the tree. Arrow keys turn it, plus and minus zoom",
            )
        });
        let cursor = self.take_pointer(ui, &response, scene, size);
        self.take_keys(ui, &response, size);
        if response.clicked()
            && let Some((point_mm, _)) = cursor
        {
            settings.follow = Follow::Fixed;
            settings.fixed_mm = point_mm;
        }
        let before = shown.place.as_ref().map(|p| (p.point_mm, p.triangle));
        if before != cursor {
            let mut study = cx.view.study.lock();
            study.point_at(cursor);
            // Shown in the next frame, when the tree has been followed.
            ui.ctx().request_repaint();
        }
        self.move_camera(ui.ctx(), scene, size);
        let picture = self.picture(cx, scene, shown);
        self.stage.lock().set_picture(picture, ui.ctx());
        ui.painter().add(self.stage.callback(rect));
        self.presets_ui(ui, rect, &cx.view.theme, scene, size);
        let entries = cx.view.study.lock().legend(&cx.view.theme);
        legend::show(ui, rect, &cx.view.theme, &entries);
        if response.has_focus() && !self.focus_by_pointer {
            ui.painter().rect_stroke(
                rect.shrink(1.0),
                2.0,
                egui::Stroke::new(1.5, cx.view.theme.accent),
                egui::StrokeKind::Inside,
            );
        }
        let held = self.stage.lock().mesh.as_ref().map_or(0, SkinMesh::bytes);
        cx.view.study.lock().set_picture_bytes(held);
    }

    fn follow_surface(&mut self, ctx: &egui::Context, scene: &Scene) {
        let mut stage = self.stage.lock();
        stage.poll_bake();
        let same = |s: &Arc<Surface>| Arc::ptr_eq(s, &scene.surface);
        if !self.surface.as_ref().is_some_and(same) {
            stage.set_surface(&scene.surface, ctx);
            self.surface = Some(scene.surface.clone());
            self.glide = None;
            self.preset = Some(Preset::Oblique);
            self.framed_for = Vec2::ZERO;
        }
    }

    /// Turns, moves and zooms; returns the skin under the cursor.
    fn take_pointer(
        &mut self,
        ui: &egui::Ui,
        response: &egui::Response,
        scene: &Scene,
        size: Vec2,
    ) -> Option<OnSkin> {
        let min = pixels::vec(response.rect.min);
        let at = response.interact_pointer_pos().or(response.hover_pos());
        let pixel = at.map(|p| pixels::vec(p) - min);
        let cursor = pixel.and_then(|p| self.skin_under(scene, p, size));
        if response.is_pointer_button_down_on() && !response.has_focus() {
            response.request_focus();
            self.focus_by_pointer = true;
        }
        let delta = pixels::delta(response.drag_delta());
        let command = ui.input(|i| i.modifiers.command);
        let mut looked = false;
        if response.dragged_by(PointerButton::Middle)
            || (command && response.dragged_by(PointerButton::Primary))
        {
            looked |= self.camera.pan(delta, size);
        } else if response.dragged() {
            looked |= self.camera.orbit(delta, size);
        }
        if let Some(pixel) = pixel.filter(|_| response.contains_pointer()) {
            let (wheel, pinch) = ui.input(|i| {
                (
                    f64::from(i.smooth_scroll_delta().y),
                    f64::from(i.zoom_delta()),
                )
            });
            let factor = (wheel * 0.0025).exp() * pinch;
            let about = cursor.map_or_else(|| self.camera.at_target_depth(pixel, size), |c| c.0);
            looked |= factor != 1.0 && self.camera.zoom(factor, about);
        }
        self.looked(looked);
        cursor.filter(|_| response.hovered() && !response.dragged())
    }

    fn take_keys(&mut self, ui: &egui::Ui, response: &egui::Response, size: Vec2) {
        if !response.has_focus() {
            self.focus_by_pointer = false;
            return;
        }
        let filter = egui::EventFilter {
            horizontal_arrows: true,
            vertical_arrows: true,
            ..egui::EventFilter::default()
        };
        ui.memory_mut(|m| m.set_focus_lock_filter(response.id, filter));
        let (turn, zoom) = ui.input(|i| {
            let hits =
                |keys: &[Key]| -> f64 { keys.iter().map(|&k| i.num_presses(k) as f64).sum() };
            (
                Vec2::new(
                    hits(&[Key::ArrowRight]) - hits(&[Key::ArrowLeft]),
                    hits(&[Key::ArrowDown]) - hits(&[Key::ArrowUp]),
                ),
                hits(&[Key::Plus, Key::Equals]) - hits(&[Key::Minus]),
            )
        });
        let mut looked = false;
        if turn != Vec2::ZERO {
            looked |= self.camera.orbit(turn * KEY_TURN, size);
        }
        if zoom != 0.0 {
            looked |= self.camera.zoom(KEY_ZOOM.powf(zoom), self.camera.target_mm);
        }
        if looked {
            self.focus_by_pointer = false;
        }
        self.looked(looked);
    }

    fn looked(&mut self, looked: bool) {
        if looked {
            self.preset = None;
            self.glide = None;
        }
    }

    fn skin_under(&self, scene: &Scene, pixel: Vec2, size: Vec2) -> Option<OnSkin> {
        const FAR_MM: f64 = 20_000.0;
        let ray = self.camera.ray(pixel, size);
        let hit =
            scene
                .touch
                .search
                .sweep(&scene.surface, ray.origin_mm, ray.at(FAR_MM), Sides::Both)?;
        Some((hit.point, hit.triangle))
    }

    fn move_camera(&mut self, ctx: &egui::Context, scene: &Scene, size: Vec2) {
        if let Some(glide) = &mut self.glide {
            let dt_s = f64::from(ctx.input(|i| i.stable_dt)).min(0.05);
            let (camera, arrived) = glide.step(dt_s);
            self.camera = camera;
            if arrived {
                self.glide = None;
            } else {
                ctx.request_repaint();
            }
        }
        if let Some(preset) = self.preset
            && self.framed_for != size
        {
            let bounds = scene.surface.bounds();
            self.camera = self.camera.preset(preset, &bounds, None, size);
            self.glide = None;
            self.framed_for = size;
        }
    }

    fn presets_ui(
        &mut self,
        ui: &mut egui::Ui,
        rect: egui::Rect,
        theme: &Theme,
        scene: &Scene,
        size: Vec2,
    ) {
        let builder = egui::UiBuilder::new()
            .max_rect(rect.shrink(8.0))
            .layout(egui::Layout::left_to_right(egui::Align::Min));
        ui.scope_builder(builder, |ui| {
            plate(theme).show(ui, |ui| {
                ui.spacing_mut().item_spacing.x = 2.0;
                ui.spacing_mut().button_padding = egui::vec2(6.0, 2.0);
                ui.horizontal_wrapped(|ui| {
                    for preset in Preset::ALL.into_iter().filter(|p| *p != Preset::Close) {
                        let (name, why) = preset_text(preset);
                        let there = ui
                            .selectable_label(self.preset == Some(preset), name)
                            .on_hover_text(why);
                        if there.clicked() {
                            let bounds = scene.surface.bounds();
                            let goal = self.camera.preset(preset, &bounds, None, size);
                            self.glide = Some(Glide::new(self.camera, goal));
                            self.preset = Some(preset);
                            self.framed_for = size;
                            ui.ctx().request_repaint();
                        }
                    }
                });
            });
        });
    }

    fn picture(&self, cx: &PanelContext<'_>, scene: &Scene, shown: &Shown) -> Picture {
        let theme = &cx.view.theme;
        Picture {
            camera: self.camera,
            size_px: [1, 1],
            bounds: scene.surface.bounds(),
            palette: Palette::of(theme),
            skin: if shown.settings.show.skin {
                SkinLook::Opaque
            } else {
                SkinLook::Off
            },
            stereo: None,
            draws_spheres: true,
            models: Vec::new(),
            tint: None,
            wireframe: false,
            draft: false,
            spheres: spheres(cx.view, scene),
            arrows: Vec::new(),
            overlay: shown.overlay.clone(),
        }
    }
}

/// The fingers near the skin, as spheres that touch it at the proxy.
fn spheres(view: &View, scene: &Scene) -> Vec<Sphere> {
    const NEAR_MM: f64 = 120.0;
    let near = scene.surface.bounds().grown(NEAR_MM);
    let pad_mm = scene.touch.choices.pad_mm();
    let radius_mm = pad_mm.unwrap_or(model::FINGER_RADIUS_MM);
    // A pad's points are those of its centre.
    let above_mm = if pad_mm.is_some() { 0.0 } else { radius_mm };
    let sphere = |record: &crate::servo::FingerRecord| {
        let contact = &record.contact;
        let centre_mm = match contact.touch {
            Touch::Free => record.reading.position_mm + Vec3::Z * above_mm,
            _ => contact.anchor_mm + contact.normal * above_mm,
        };
        (centre_mm.is_finite() && near.contains(centre_mm)).then(|| Sphere {
            centre_mm,
            radius_mm,
            color: pixels::rgb(view.theme.finger(usize::from(record.finger))),
        })
    };
    view.fingers.iter().filter_map(sphere).collect()
}
