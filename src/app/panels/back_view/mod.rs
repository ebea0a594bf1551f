//! The Back view: the skin as it deforms, the fingers on it, and the mouse as a finger.
//!
//! | file | answers |
//! |---|---|
//! | [`palpate`] | where cursor and keys want the mouse fingers |
//! | [`model`] | what of the fingers is shown, in mm, N and N/mm |
//! | `gesture` | what a drag, wheel or key means |
//! | `skin` | how the fingers deform the drawn skin |
//! | `footprints` | how far a press reaches |
//! | `colour`, `ramp` | what colours it, and the legend of that |
//! | `stage` | what the paint callback needs |
//! | `overlay`, `toolbar` | numbers, scale, hint and buttons over the picture |

mod colour;
mod footprints;
mod gesture;
pub mod model;
mod overlay;
pub mod palpate;
mod ramp;
mod skin;
mod stage;
mod toolbar;

use super::{Panel, PanelContext};
use crate::app::camera::{Camera, Glide, Preset};
use crate::app::render::{Palette, Picture, arrow::Arrow, layer::Overlay, pixels, sphere::Sphere};
use crate::app::state::View;
use crate::app::widgets::empty_ui;
use crate::geom::{Vec2, Vec3};
use crate::scenario::Item;
use colour::SurfaceColour;
use egui_material_icons::icons as icon;
use gesture::Gesture;
pub(super) use overlay::plate;
use palpate::{Palpation, Targets};
use skin::DrawnSkin;
pub use stage::{SharedStage, draw_finely};
pub(super) use toolbar::preset_text;

/// Colours over the skin and what they mean.
type Legend = Vec<(egui::Color32, &'static str)>;

/// What is shown beside the skin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Edges of the triangles.
    pub wireframe: bool,
    /// Forces as arrows.
    pub arrows: bool,
    /// Names of landmarks.
    pub landmarks: bool,
    /// How far presses reach.
    pub footprints: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            wireframe: false,
            arrows: true,
            landmarks: false,
            footprints: false,
        }
    }
}

impl Options {
    /// What is not as at first, as words with a space before each.
    fn kept(self) -> String {
        [
            (self.wireframe, " wireframe"),
            (!self.arrows, " no-arrows"),
            (self.landmarks, " landmarks"),
            (self.footprints, " footprints"),
        ]
        .into_iter()
        .filter_map(|(on, word)| on.then_some(word))
        .collect()
    }

    /// Takes that back; other words are not its own.
    fn recall(&mut self, kept: &str) {
        for word in kept.split_whitespace() {
            match word {
                "wireframe" => self.wireframe = true,
                "no-arrows" => self.arrows = false,
                "landmarks" => self.landmarks = true,
                "footprints" => self.footprints = true,
                _ => {}
            }
        }
    }
}

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
            self.stage.lock().release(view.gl.as_deref());
            for item in [
                Item::Deformation,
                Item::TangentialField,
                Item::GraphicsMesh,
                Item::SurfaceColour,
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
        skin.report(&cx.view.parts, &self.stage);
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
        picture.tint = self.colour.tint();
        let mut legend = Vec::new();
        if let Some((overlay, entries)) = tree {
            (picture.overlay, legend) = (overlay, entries);
        }
        self.stage.lock().set_picture(picture, ui.ctx());
        ui.painter().add(self.stage.callback(rect));

        overlay::show(
            ui,
            rect,
            &overlay::Shown {
                camera: &self.camera,
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
            },
        );
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
fn over_the_skin(ctx: &egui::Context, view: &View) -> Option<(Overlay, Legend)> {
    let mut study = view.study.lock();
    if !study.is_over_the_back() {
        return None;
    }
    study.follow(view, &super::partition::wake(ctx));
    Some((study.shown().overlay, study.legend(&view.theme)))
}

impl BackView {
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

    /// Glides to a preset.
    fn go_to(&mut self, preset: Preset, fingers: &[model::Finger], size: Vec2) {
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
            skin: true,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_option_is_taken_back_as_it_was_kept() {
        for i in 0..16 {
            let bit = |k: i32| i >> k & 1 == 1;
            let options = Options {
                wireframe: bit(0),
                arrows: bit(1),
                landmarks: bit(2),
                footprints: bit(3),
            };
            let mut again = Options::default();
            again.recall(&format!("colour=skin{} unknown", options.kept()));
            assert_eq!(again, options);
        }
    }
}
