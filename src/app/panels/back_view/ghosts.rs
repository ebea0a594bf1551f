//! The fingers of overlaid recordings and where they were of late: translucent, in colours of their own.

use super::model;
use super::overlay::{Shown, on_screen};
use crate::app::camera::Camera;
use crate::app::render::pixels;
use crate::app::state::{GhostView, Trail};
use egui::Stroke;

/// Opacity of a finger that faces the eye, and of one behind the skin.
const OPACITY: [f32; 2] = [0.42, 0.14];
/// The same of its rim.
const RIM: [f32; 2] = [0.95, 0.35];

/// Draws them all.
pub fn show(painter: &egui::Painter, rect: egui::Rect, shown: &Shown<'_>, camera: &Camera) {
    for ghost in shown.ghosts {
        for trail in ghost.trails.iter() {
            finger(painter, rect, shown, camera, ghost, trail);
        }
    }
}

fn finger(
    painter: &egui::Painter,
    rect: egui::Rect,
    shown: &Shown<'_>,
    camera: &Camera,
    ghost: &GhostView,
    trail: &Trail,
) {
    let (scene, skin) = (shown.skin.scene(), shown.skin.displacement());
    let Some(finger) = model::finger(scene, skin, &trail.now) else {
        return;
    };
    let Some(centre) = on_screen(rect, camera, finger.centre_mm) else {
        return;
    };
    let colour = shown.theme.ghost(ghost.colour);
    let hidden = usize::from(!model::is_seen(scene, camera, finger.centre_mm));
    let places = trail.places_mm.iter();
    let points: Vec<_> = places.map(|&p| on_screen(rect, camera, p)).collect();
    let n = points.len().max(1) as f32;
    for (i, pair) in points.windows(2).enumerate() {
        let (Some(a), Some(b)) = (pair[0], pair[1]) else {
            continue;
        };
        // The older, the fainter and the thinner.
        let young = (i + 1) as f32 / n;
        let stroke = Stroke::new(
            1.0 + 2.0 * young,
            colour.gamma_multiply(young * RIM[hidden] * 0.8),
        );
        painter.line_segment([a, b], stroke);
    }
    let per_mm = camera.px_per_mm(finger.centre_mm, pixels::delta(rect.size()).y);
    let radius = pixels::points(finger.radius_mm * per_mm).clamp(3.0, 200.0);
    let rim = Stroke::new(1.6, colour.gamma_multiply(RIM[hidden]));
    painter.circle(centre, radius, colour.gamma_multiply(OPACITY[hidden]), rim);
    // The place that the device has under the skin, as the fingers on show have it.
    if let Some(hip) = finger.hip_mm.and_then(|p| on_screen(rect, camera, p)) {
        painter.circle_filled(hip, 2.5, colour.gamma_multiply(RIM[hidden]));
        painter.line_segment([centre, hip], Stroke::new(1.0, rim.color));
    }
}
