//! The places of an exercise on the back: where it may be, what is pointed at, and after the answer where it was.

use super::model;
use super::overlay::{self, Shown};
use crate::app::camera::Camera;
use crate::app::state::ExerciseView;
use crate::geom::{Vec2, Vec3};
use crate::training::Phase;
use egui::{Align2, FontId, Pos2, Stroke, vec2};

/// Draws them where they face the eye.
pub fn show(
    painter: &egui::Painter,
    rect: egui::Rect,
    shown: &Shown<'_>,
    camera: &Camera,
    of: &ExerciseView,
) {
    let theme = shown.theme;
    let asked = &of.shown;
    if matches!(asked.phase, Phase::Done(_)) {
        return;
    }
    let seen = |at_mm: Vec2| on_the_back(rect, shown, camera, at_mm);
    let words = |at: Pos2, words: &str| {
        let font = FontId::proportional(12.0);
        let text = painter.layout_no_wrap(words.into(), font, theme.text);
        overlay::label(painter, theme, at + vec2(20.0, -8.0), text);
    };
    if asked.pointed.is_empty() {
        for at in asked.candidates.iter().filter_map(|s| seen(s.at_mm())) {
            painter.circle(
                at,
                3.0,
                theme.panel.gamma_multiply(0.5),
                Stroke::new(1.2, theme.text.gamma_multiply(0.9)),
            );
        }
    }
    for place in &asked.pointed {
        let Some(at) = seen(place.at_mm) else {
            continue;
        };
        painter.circle(at, 11.0, theme.panel, Stroke::new(2.0, theme.accent));
        let font = FontId::proportional(14.0);
        painter.text(at, Align2::CENTER_CENTER, &place.name, font, theme.text);
    }
    for at in of.truth_mm.iter().filter_map(|&at_mm| seen(at_mm)) {
        painter.circle_stroke(at, 15.0, Stroke::new(1.5, theme.warning));
        words(at, "Hidden");
    }
    let told = (asked.feedback.iter())
        .filter(|_| of.truth_mm.is_empty())
        .flat_map(|told| &told.truth_mm);
    for at in told.filter_map(|&at_mm| seen(at_mm)) {
        for (radius, width) in [(15.0, 2.5), (5.0, 2.0)] {
            painter.circle_stroke(at, radius, Stroke::new(width, theme.accent));
        }
        words(at, "It was here");
    }
}

/// Where a place of the map plane appears in the window, if it faces the eye.
fn on_the_back(rect: egui::Rect, shown: &Shown<'_>, camera: &Camera, at_mm: Vec2) -> Option<Pos2> {
    let scene = shown.skin.scene();
    let height_mm = scene.height_mm(at_mm.x, at_mm.y)?;
    let point_mm = Vec3::new(at_mm.x, at_mm.y, height_mm);
    if !model::is_seen(scene, camera, point_mm) {
        return None;
    }
    overlay::on_screen(rect, camera, point_mm)
}
