//! The Back view: the skin as it deforms, the fingers on it, and the mouse as a finger.
//!
//! | file | answers |
//! |---|---|
//! | [`palpate`] | where cursor and keys want the mouse fingers |
//! | [`model`] | what of the fingers is shown, in mm, N and N/mm |
//! | `gesture` | what a drag, wheel or key means |
//! | `skin` | how the fingers deform the drawn skin |
//! | `footprints` | how far a press reaches |
//! | `ghosts` | the fingers of overlaid recordings |
//! | `colour`, `ramp` | what colours it, and the legend of that |
//! | `stage` | what the paint callback needs |
//! | [`options`] | what is shown beside the skin, kept from run to run |
//! | `anatomy` | bones below it, hands upon it |
//! | `labels` | where names of landmarks stand |
//! | `overlay`, `toolbar`, `look` | numbers, scale, hint, buttons and menus over the picture |
//!
//! All that is drawn comes from the scene in [`View`] and from what the fingers met: where that scene is a blinded one, nothing
//! here knows another. What a finger tells of stiffness is left out while [`View::blind`] is set.

mod anatomy;
mod colour;
mod footprints;
mod gesture;
mod ghosts;
mod labels;
mod look;
pub mod model;
pub mod options;
mod overlay;
pub mod palpate;
mod places;
mod ramp;
mod skin;
mod stage;
mod toolbar;

use super::{Panel, PanelContext};
use crate::app::camera::{Camera, Glide, Preset};
use crate::app::render::{Palette, Picture, arrow::Arrow, layer::Overlay, pixels, sphere::Sphere};
use crate::app::state::{PartCost, View};
use crate::app::stereo::{Pane, panes};
use crate::app::widgets::empty_ui;
use crate::geom::{Vec2, Vec3};
use crate::scenario::Item;
use anatomy::Anatomy;
use colour::SurfaceColour;
use egui_material_icons::icons as icon;
use gesture::Gesture;
use options::Options;
pub(super) use overlay::plate;
use palpate::{Palpation, Targets};
use skin::DrawnSkin;
pub use stage::{SharedStage, draw_finely};
pub(super) use toolbar::preset_text;

/// Colours over the skin and what they mean.
type Legend<'a> = Vec<(egui::Color32, &'a str)>;

/// The Back view.
#[derive(Default)]
pub struct BackView {
    stage: SharedStage,
    skin: Option<DrawnSkin>,
    camera: Camera,
    glide: Option<Glide>,
    /// The preset on show, until the user turns, moves or zooms.
    preset: Option<Preset>,
    /// Size the preset was framed for, points.
    framed_for: Vec2,
    palpation: Palpation,
    gesture: Option<Gesture>,
    /// Pressed by key.
    key_press: bool,
    /// The picture got its focus by the pointer, so no focus ring is drawn.
    focus_by_pointer: bool,
    sent: Targets,
    /// A finger has pressed: the hint has done its work.
    pressed_once: bool,
    options: Options,
    colour: SurfaceColour,
    anatomy: Anatomy,
    /// Which of two pictures a drag began in.
    pane: usize,
    /// Where the toolbar ended on the right when it was last drawn: it is as wide as its words.
    toolbar_end: f32,
}

impl Panel for BackView {
    fn key(&self) -> &'static str {
        "back_view"
    }

    fn title(&self) -> &'static str {
        "Back view"
    }

    fn tooltip(&self) -> &'static str {
        "The back under the fingers, drawn as it deforms; press it with the mouse"
    }

    fn home(&self) -> crate::app::dock::Home {
        crate::app::dock::Home::Main
    }

    fn release(&mut self, view: &View) {
        if self.skin.take().is_some() {
            self.colour.forget(&self.stage);
            self.anatomy = Anatomy::default();
            self.stage.lock().release(view.gl.as_deref());
            for item in [
                Item::Deformation,
                Item::TangentialField,
                Item::GraphicsMesh,
                Item::SurfaceColour,
                Item::DrawnBones,
                Item::LandmarkNames,
                Item::HandModel,
                Item::SecondEye,
            ] {
                view.parts.remove(item);
            }
        }
    }

    fn keep(&self) -> Option<String> {
        Some(format!("{}{}", self.colour.kept(), self.options.kept()))
    }

    fn recall(&mut self, kept: &str) {
        self.colour.recall(kept);
        self.options.recall(kept);
    }

    fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        let Some(scene) = &cx.view.scene else {
            empty_ui(
                ui,
                icon::ICON_ACCESSIBILITY_NEW,
                "No back yet",
                "It appears as soon as its scene is built",
            );
            return;
        };
        if cx.view.gl.is_none() {
            empty_ui(
                ui,
                icon::ICON_VISIBILITY_OFF,
                "The back cannot be drawn here",
                "This window has no OpenGL. Palpation, plots and recording work without it",
            );
            return;
        }
        if let Some(fault) = self.stage.lock().fault.clone() {
            empty_ui(
                ui,
                icon::ICON_VISIBILITY_OFF,
                "The back cannot be drawn here",
                &fault,
            );
            return;
        }
        let whole = ui.available_rect_before_wrap();
        let (rect, strip) = match self.colour.quantity() {
            Some(_) => ramp::split(whole),
            None => (whole, None),
        };
        let size = pixels::delta(rect.size());
        if size.x < 8.0 || size.y < 8.0 {
            return;
        }
        self.follow_scene(ui.ctx(), scene, cx.view.scene_generation);
        let Some(skin) = &mut self.skin else { return };
        let strain = self.colour.strain();
        let moved = skin.update(&cx.view.fingers, &self.stage, strain);
        if !self.options.anatomy.landmarks {
            skin.forget_marks();
        }
        self.anatomy.follow(scene, &self.options);
        let ctx = ui.ctx().clone();
        self.colour
            .follow(scene, skin.displacement(), moved, &self.stage, || {
                super::partition::wake(&ctx)
            });
        self.colour.report(&cx.view.parts, &self.stage);

        let response = ui.allocate_rect(rect, egui::Sense::click_and_drag());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(
                egui::accesskit::Role::Canvas,
                ui.is_enabled(),
                "Picture of the back. Arrow keys move the finger, Enter presses, W and S set the depth",
            )
        });
        self.take_gestures(ui, &response, cx);
        self.move_camera(ui.ctx(), size);

        let Some(skin) = &self.skin else { return };
        let fingers = model::fingers(skin.scene(), skin.displacement(), &cx.view.fingers);
        // A finger pressed by a script or a device shows as well how it is done.
        self.pressed_once |= fingers.iter().any(|f| f.hip_mm.is_some());
        let tree = over_the_skin(ui.ctx(), cx.view);
        let mut picture = self.picture(cx, &fingers);
        picture.models = {
            let hands = self.options.anatomy.hands;
            self.anatomy.models(&fingers, &cx.view.theme, hands)
        };
        for placed in &picture.models {
            if !placed.is_finger {
                picture.bounds = picture.bounds.union(placed.model.bounds());
            }
        }
        let Some(skin) = &self.skin else { return };
        picture.tint = self.colour.tint();
        let mut legend = Vec::new();
        if let Some((overlay, entries)) = tree {
            (picture.overlay, legend) = (overlay, entries);
        }
        let ghosts = cx.view.ghosts.iter();
        legend.extend(ghosts.map(|g| (cx.view.theme.ghost(g.colour), g.name.as_str())));
        self.stage.lock().set_picture(picture, ui.ctx());
        ui.painter().add(self.stage.callback(rect));

        overlay::show(
            ui,
            rect,
            &overlay::Shown {
                camera: &self.camera,
                panes: &panes(self.options.stereo.as_ref(), &self.camera, size),
                blind: cx.view.blind,
                theme: &cx.view.theme,
                skin,
                fingers: &fingers,
                n_fingers: cx.view.fingers.len(),
                palpation: (cx.view.playback.is_none() && !cx.view.hands.is_empty())
                    .then_some(&self.palpation),
                hint: !self.pressed_once,
                focus_ring: response.has_focus() && !self.focus_by_pointer,
                options: self.options,
                toolbar_end: self.toolbar_end,
                ghosts: &cx.view.ghosts,
                exercise: cx.view.exercise.as_ref(),
            },
        );
        self.report(cx.view);
        self.toolbar(ui, rect, cx, &fingers);
        if let (Some(strip), Some(skin)) = (strip, &self.skin) {
            let theme = &cx.view.theme;
            ramp::show(ui, strip, theme, &mut self.colour, skin.displacement());
        }
        super::legend::show(ui, rect, &cx.view.theme, &legend);
    }
}

/// The tree under study with its legend, where it is to be shown here too. The panel it belongs to may lie behind another
/// tab, so it is brought up to date here as well.
fn over_the_skin(ctx: &egui::Context, view: &View) -> Option<(Overlay, Legend<'static>)> {
    let mut study = view.study.lock();
    if !study.is_over_the_back() {
        return None;
    }
    study.follow(view, &super::partition::wake(ctx));
    Some((study.shown().overlay, study.legend(&view.theme)))
}

impl BackView {
    /// Tells the ledger what is held.
    fn report(&self, view: &View) {
        let parts = &view.parts;
        if let Some(skin) = &self.skin {
            skin.report(parts, &self.stage);
        }
        self.anatomy.report(parts);
        if self.options.stereo.is_some() {
            // The larger picture is on the graphics card alone.
            parts.report(Item::SecondEye, PartCost::default());
        } else {
            parts.remove(Item::SecondEye);
        }
    }

    /// The picture to be pointed at: that of the pixel, or that in which a drag began.
    fn pane_at(&mut self, pixel: Option<Vec2>, size: Vec2) -> Pane {
        let panes = panes(self.options.stereo.as_ref(), &self.camera, size);
        if self.gesture.is_none()
            && let Some(found) = pixel.and_then(|p| panes.iter().position(|pane| pane.holds(p)))
        {
            self.pane = found;
        }
        let whole = Pane::whole(self.camera, size);
        let chosen = panes.get(self.pane).or(panes.first());
        chosen.copied().unwrap_or(whole)
    }

    fn follow_scene(
        &mut self,
        ctx: &egui::Context,
        scene: &std::sync::Arc<crate::scenario::Scene>,
        generation: u64,
    ) {
        self.stage.lock().poll_bake();
        if let Some(skin) = &mut self.skin {
            if skin.is_of(scene, generation) {
                return;
            }
            if skin.renew(scene, generation, &self.stage) {
                // An edit of the scene that is open: one goes on looking and pressing.
                self.colour.renew();
                return;
            }
        }
        self.colour.forget(&self.stage);
        self.stage.lock().set_surface(&scene.surface, ctx);
        self.skin = Some(DrawnSkin::new(scene.clone(), generation));
        self.palpation = Palpation::default();
        self.sent = Targets::default();
        self.key_press = false;
        self.glide = None;
        self.preset = Some(Preset::Oblique);
        self.framed_for = Vec2::ZERO;
    }

    /// Lets a glide go on; keeps a preset framed while the panel is resized.
    fn move_camera(&mut self, ctx: &egui::Context, size: Vec2) {
        let size = self.pane_size(size);
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
        if let (Some(preset), Some(skin)) = (self.preset, &self.skin)
            && self.framed_for != size
            && preset != Preset::Close
        {
            self.camera = self
                .camera
                .preset(preset, &skin.scene().surface.bounds(), None, size);
            self.glide = None;
            self.framed_for = size;
        }
    }

    /// Size of one eye's picture in a panel of `size`.
    fn pane_size(&self, size: Vec2) -> Vec2 {
        let panes = panes(self.options.stereo.as_ref(), &self.camera, size);
        panes.first().map_or(size, |pane| pane.size)
    }

    /// Glides to a preset.
    fn go_to(&mut self, preset: Preset, fingers: &[model::Finger], size: Vec2) {
        let size = self.pane_size(size);
        let Some(skin) = &self.skin else { return };
        // On its way to the button the cursor has taken the finger along: the press is what one wants to see.
        let touching = fingers.iter().find(|f| f.hip_mm.is_some());
        let pressed = self.palpation.pressed().or(self.palpation.place());
        let finger = touching
            .map(|f| (f.centre_mm, f.normal))
            .or(pressed.map(|p| (p.point_mm, p.normal)));
        let goal = self
            .camera
            .preset(preset, &skin.scene().surface.bounds(), finger, size);
        self.glide = Some(Glide::new(self.camera, goal));
        self.preset = Some(preset);
        self.framed_for = size;
    }

    fn picture(&self, cx: &PanelContext<'_>, fingers: &[model::Finger]) -> Picture {
        let theme = &cx.view.theme;
        let color = |f: &model::Finger| pixels::rgb(theme.finger(f.index));
        let bounds = self
            .skin
            .as_ref()
            .map_or(crate::geom::Aabb::EMPTY, |s| s.scene().surface.bounds());
        Picture {
            camera: self.camera,
            size_px: [1, 1],
            bounds,
            palette: Palette::of(theme),
            skin: self.options.skin,
            stereo: self.options.stereo,
            draws_spheres: !self.options.anatomy.hands,
            models: Vec::new(),
            tint: None,
            wireframe: self.options.wireframe,
            draft: false,
            spheres: fingers
                .iter()
                .map(|f| Sphere {
                    centre_mm: f.centre_mm,
                    radius_mm: f.radius_mm,
                    color: color(f),
                })
                .collect(),
            arrows: fingers
                .iter()
                .filter(|f| self.options.arrows && f.force_n != Vec3::ZERO)
                .map(|f| Arrow {
                    from_mm: f.arrow_from_mm(),
                    along_mm: f.arrow_mm(),
                    color: color(f),
                })
                .collect(),
            overlay: Overlay::default(),
        }
    }
}
