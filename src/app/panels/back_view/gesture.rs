//! What a drag, the wheel and keys mean.
//!
//! | input | does |
//! |---|---|
//! | cursor over the skin | the finger hovers there |
//! | left button held on the skin | presses; moving slides, wheel or Shift and vertical drag set the depth |
//! | right drag, left drag beside the skin, Alt and left drag | turns the view |
//! | middle drag, Ctrl and left drag | moves it |
//! | wheel, pinch | zooms to the cursor |
//! | W S, + − | depth in steps; with Shift in fine steps |
//! | arrows, Enter | move the finger over the skin, press and let go |
//! | P | parks the other finger in the press, or lifts it off |
//! | C, Shift and C | the next surface colour, the one before |

use super::palpate::{Input, SkinPoint, Targets};
use super::{BackView, PanelContext};
use crate::app::camera::Ray;
use crate::app::render::pixels;
use crate::app::stereo::Pane;
use crate::geom::{Vec2, Vec3, unit_or};
use crate::partition::{Partition as _, Sides};
use crate::scenario::Scene;
use egui::{Key, PointerButton};

/// A drag in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gesture {
    /// The finger presses.
    Press,
    /// The view turns.
    Orbit,
    /// The view moves.
    Pan,
}

/// Depth per notch of the wheel (40 points) and per step of a key, mm.
const DEPTH_STEP_MM: f64 = 0.5;
/// The same for fine steps, mm.
const FINE_STEP_MM: f64 = 0.1;
/// Points of wheel per notch.
const NOTCH: f64 = 40.0;
/// Depth per point of vertical drag, mm.
const DEPTH_PER_POINT_MM: f64 = 0.06;
/// How far an arrow key moves the finger, points; with Shift a quarter of it.
const KEY_MOVE: f64 = 12.0;

/// What the devices of the window say in one frame.
struct Hands {
    hover: Option<Vec2>,
    delta: Vec2,
    wheel: f64,
    pinch: f64,
    down: Option<PointerButton>,
    modifiers: egui::Modifiers,
}

impl Hands {
    /// The same as seen from one picture's corner.
    fn in_pane(self, pane: &Pane) -> Self {
        Self {
            hover: self.hover.map(|p| p - pane.from),
            ..self
        }
    }
}

impl BackView {
    /// Reads pointer and keys: moves the camera, and sends the mouse fingers where they are wanted.
    pub(super) fn take_gestures(
        &mut self,
        ui: &egui::Ui,
        response: &egui::Response,
        cx: &PanelContext<'_>,
    ) {
        let rect = response.rect;
        let size = pixels::delta(rect.size());
        let local = |p: egui::Pos2| pixels::vec(p) - pixels::vec(rect.min);
        // Asked for outside `input`: both lock the context.
        let hover = response.interact_pointer_pos().or(response.hover_pos());
        let hands = ui.input(|i| Hands {
            hover: hover.map(local),
            delta: pixels::delta(i.pointer.delta()),
            wheel: f64::from(i.smooth_scroll_delta().y),
            pinch: f64::from(i.zoom_delta()),
            down: [
                PointerButton::Primary,
                PointerButton::Secondary,
                PointerButton::Middle,
            ]
            .into_iter()
            .find(|&b| i.pointer.button_down(b)),
            modifiers: i.modifiers,
        });
        // What is pointed at belongs to the picture under the cursor: there are two of them for two eyes.
        let pane = self.pane_at(hands.hover, size);
        let (hands, size) = (hands.in_pane(&pane), pane.size);
        let Some(skin) = &self.skin else { return };
        let scene = skin.scene();
        let cursor = hands
            .hover
            .and_then(|p| skin_under(scene, &pane.camera.ray(p, size)));
        let n_fingers = if cx.view.playback.is_some() {
            0
        } else {
            cx.view.hands.len()
        };

        self.gesture = match (response.is_pointer_button_down_on(), self.gesture) {
            (false, _) => None,
            (true, Some(gesture)) => Some(gesture),
            (true, None) => {
                response.request_focus();
                self.focus_by_pointer = true;
                Some(meaning(&hands, cursor.is_some() && n_fingers > 0))
            }
        };
        if !response.has_focus() && self.gesture.is_none() {
            self.focus_by_pointer = false;
            self.key_press = false;
        }
        let pressing = self.gesture == Some(Gesture::Press);

        let mut input = Input {
            cursor: cursor.filter(|_| matches!(self.gesture, None | Some(Gesture::Press))),
            press: pressing,
            hold_place: pressing && hands.modifiers.shift,
            ..Input::default()
        };
        if input.hold_place {
            input.depth_step_mm += hands.delta.y * DEPTH_PER_POINT_MM;
        }
        let mut looked = match self.gesture {
            Some(Gesture::Orbit) => self.camera.orbit(hands.delta, size),
            Some(Gesture::Pan) => self.camera.pan(hands.delta, size),
            _ => false,
        };
        if let Some(pixel) = hands.hover {
            if pressing {
                input.depth_step_mm += hands.wheel / NOTCH * DEPTH_STEP_MM;
            } else {
                let factor = (hands.wheel * 0.0025).exp() * hands.pinch;
                let about =
                    cursor.map_or_else(|| pane.camera.at_target_depth(pixel, size), |c| c.point_mm);
                looked |= factor != 1.0 && self.camera.zoom(factor, about);
            }
        }
        if looked {
            self.preset = None;
            self.glide = None;
        }
        self.take_keys(ui, response, cursor, &mut input, size);
        self.send(cx, &input, n_fingers);
    }

    fn take_keys(
        &mut self,
        ui: &egui::Ui,
        response: &egui::Response,
        cursor: Option<SkinPoint>,
        input: &mut Input,
        size: Vec2,
    ) {
        let free = response.hovered() && ui.memory(|m| m.focused().is_none());
        if !(response.has_focus() || free) {
            return;
        }
        if response.has_focus() {
            let filter = egui::EventFilter {
                horizontal_arrows: true,
                vertical_arrows: true,
                ..egui::EventFilter::default()
            };
            ui.memory_mut(|m| m.set_focus_lock_filter(response.id, filter));
        }
        let (mut steps, mut across, mut park, mut press) = (0.0, Vec2::ZERO, false, false);
        let mut colour = 0;
        let fine = ui.input(|i| {
            if !i.modifiers.command && !i.modifiers.alt {
                let hits =
                    |keys: &[Key]| -> f64 { keys.iter().map(|&k| i.num_presses(k) as f64).sum() };
                steps = hits(&[Key::W, Key::Plus, Key::Equals]) - hits(&[Key::S, Key::Minus]);
                across = Vec2::new(
                    hits(&[Key::ArrowRight]) - hits(&[Key::ArrowLeft]),
                    hits(&[Key::ArrowDown]) - hits(&[Key::ArrowUp]),
                );
                park = i.key_pressed(Key::P);
                press = i.key_pressed(Key::Enter);
                let on = i.num_presses(Key::C) as isize;
                colour = if i.modifiers.shift { -on } else { on };
            }
            i.modifiers.shift
        });
        input.depth_step_mm += steps * if fine { FINE_STEP_MM } else { DEPTH_STEP_MM };
        input.park |= park;
        if colour != 0 {
            let next = self.colour.beside(colour);
            self.colour.choose(next, &self.stage);
        }
        if !response.has_focus() {
            return;
        }
        self.key_press ^= press;
        if across != Vec2::ZERO {
            self.focus_by_pointer = false;
            let step = across * if fine { KEY_MOVE / 4.0 } else { KEY_MOVE };
            input.cursor = self.beside(step, size).or(self.palpation.place());
        } else if self.key_press || (cursor.is_none() && !self.focus_by_pointer) {
            // A finger moved by keys stays where they put it.
            input.cursor = self.palpation.place();
        }
        input.press |= self.key_press;
    }

    /// The skin `step` points on the screen beside the place of the finger, or in the middle of the picture at first.
    fn beside(&self, step: Vec2, size: Vec2) -> Option<SkinPoint> {
        let from = match self.palpation.place() {
            Some(place) => self.camera.project(place.point_mm, size)? + step,
            None => size / 2.0,
        };
        skin_under(self.skin.as_ref()?.scene(), &self.camera.ray(from, size))
    }

    /// Parks or lifts the second finger, from a button.
    pub(super) fn park(&mut self, cx: &PanelContext<'_>) {
        let input = Input {
            cursor: self.palpation.place(),
            park: true,
            ..Input::default()
        };
        self.send(cx, &input, cx.view.hands.len());
    }

    fn send(&mut self, cx: &PanelContext<'_>, input: &Input, n_fingers: usize) {
        let wanted = self.palpation.step(input, n_fingers);
        self.pressed_once |= self.palpation.is_pressing();
        let fingers = [
            (wanted.moving_mm, &mut self.sent.moving_mm),
            (wanted.parked_mm, &mut self.sent.parked_mm),
        ];
        for (hand, (wanted, sent)) in cx.view.hands.iter().zip(fingers) {
            // Set only what changed: a script may be moving the same hand.
            if let Some(target_mm) = wanted
                && *sent != wanted
            {
                hand.set(target_mm);
                *sent = wanted;
            }
        }
        debug_assert!(wanted == Targets::default() || n_fingers > 0);
    }
}

fn meaning(hands: &Hands, on_skin: bool) -> Gesture {
    match hands.down {
        Some(PointerButton::Middle) => Gesture::Pan,
        Some(PointerButton::Primary) if hands.modifiers.command => Gesture::Pan,
        Some(PointerButton::Primary) if on_skin && !hands.modifiers.alt => Gesture::Press,
        _ => Gesture::Orbit,
    }
}

/// Where a half-line first meets the outside of the skin.
fn skin_under(scene: &Scene, ray: &Ray) -> Option<SkinPoint> {
    const FAR_MM: f64 = 20_000.0;
    let surface = &scene.surface;
    let hit = scene
        .touch
        .search
        .sweep(surface, ray.origin_mm, ray.at(FAR_MM), Sides::Front)?;
    let triangle = surface.triangle(hit.triangle);
    let weights = triangle.closest_point(hit.point).barycentric;
    let corners = surface.triangles()[hit.triangle as usize];
    let normal: Vec3 = (0..3)
        .map(|i| surface.normals()[corners[i] as usize] * weights[i])
        .sum();
    let normal = unit_or(normal, triangle.normal());
    let pad_mm = scene.touch.choices.pad_mm().unwrap_or(0.0);
    Some(SkinPoint {
        point_mm: hit.point + normal * pad_mm,
        normal,
    })
}
