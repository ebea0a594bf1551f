//! What lies on a canvas under the hands: pictures, lines of equal value, rulers, landmarks.

use super::canvas::Lay;
use super::field::Picture;
use super::ink::{Ink, Inks, halo_text};
use super::plane::{Area, multiples, round_step};
use super::scale::Scale;
use crate::app::theme::Theme;
use crate::geom::Vec2;
use crate::surface::back::{self, Landmark};
use egui::{Align2, Color32, FontId, Pos2, Rect, Shape, Stroke, TextureHandle, pos2, vec2};

/// Points between grid lines, at least.
const GRID: f64 = 56.0;
/// Width of the ruler on the left, points.
pub const LEFT: f32 = 38.0;
/// Height of the ruler below, points.
pub const LOW: f32 = 17.0;

/// Draws a texture whose outermost pixel centres lie on the border of `area`; returns where.
pub fn image(
    painter: &egui::Painter,
    lay: Lay,
    texture: &TextureHandle,
    area: &Area,
    tint: Color32,
) -> Rect {
    let place = Rect::from_two_pos(lay.at(area.min), lay.at(area.max));
    let [w, h] = texture.size().map(|n| n as f32);
    let (u, v) = (0.5 / w, 0.5 / h);
    let uv = Rect::from_min_max(pos2(u, v), pos2(1.0 - u, 1.0 - v));
    painter.image(texture.id(), place, uv, tint);
    place
}

/// Lines at round coordinates.
pub fn grid(painter: &egui::Painter, lay: Lay, theme: &Theme) {
    let step = step_mm(&lay);
    let area = lay.plane.visible(lay.rect);
    let stroke = Stroke::new(1.0, theme.weak_text.gamma_multiply(0.16));
    for x in multiples(area.min.x, area.max.x, step) {
        painter.vline(lay.at(Vec2::new(x, 0.0)).x, lay.rect.y_range(), stroke);
    }
    for y in multiples(area.min.y, area.max.y, step) {
        painter.hline(lay.rect.x_range(), lay.at(Vec2::new(0.0, y)).y, stroke);
    }
}

fn step_mm(lay: &Lay) -> f64 {
    let span = f64::from(lay.rect.width()) / lay.plane.points_per_mm;
    round_step(span, f64::from(lay.rect.width()) / GRID)
}

/// Numbers along the left and the lower border.
pub fn rulers(painter: &egui::Painter, lay: Lay, theme: &Theme) {
    let rect = lay.rect;
    if rect.width() < 120.0 || rect.height() < 80.0 {
        return;
    }
    let ground = theme.panel.gamma_multiply(0.82);
    let left = Rect::from_min_max(rect.min, pos2(rect.left() + LEFT, rect.bottom()));
    let low = Rect::from_min_max(pos2(rect.left() + LEFT, rect.bottom() - LOW), rect.max);
    painter.rect_filled(left, 0.0, ground);
    painter.rect_filled(low, 0.0, ground);
    let font = FontId::monospace(10.0);
    let step = step_mm(&lay);
    let decimals = if step < 1.0 { 1 } else { 0 };
    let area = lay.plane.visible(rect);
    for x in multiples(area.min.x, area.max.x, step) {
        let at = lay.at(Vec2::new(x, 0.0)).x;
        if at < left.right() + 14.0 || at > rect.right() - 40.0 {
            continue;
        }
        let place = pos2(at, rect.bottom() - 2.0);
        let text = format!("{x:.decimals$}");
        painter.text(
            place,
            Align2::CENTER_BOTTOM,
            text,
            font.clone(),
            theme.weak_text,
        );
    }
    for y in multiples(area.min.y, area.max.y, step) {
        let at = lay.at(Vec2::new(0.0, y)).y;
        if at < rect.top() + 8.0 || at > low.top() - 8.0 {
            continue;
        }
        let place = pos2(left.right() - 4.0, at);
        let text = format!("{y:.decimals$}");
        painter.text(
            place,
            Align2::RIGHT_CENTER,
            text,
            font.clone(),
            theme.weak_text,
        );
    }
    let corner = rect.right_bottom() - vec2(4.0, 2.0);
    painter.text(
        corner,
        Align2::RIGHT_BOTTOM,
        "x, mm",
        font.clone(),
        theme.weak_text,
    );
    let corner = pos2(left.left() + 4.0, rect.bottom() - 3.0);
    painter.text(corner, Align2::LEFT_BOTTOM, "y, mm", font, theme.weak_text);
}

/// Levels of the spine, as many as there is room for.
pub fn landmarks(painter: &egui::Painter, lay: Lay, inks: &Inks<'_>, landmarks: &[Landmark]) {
    let font = FontId::proportional(10.5);
    let mut last = f32::NEG_INFINITY;
    let mut spine: Vec<_> = landmarks
        .iter()
        .filter(|l| l.kind == back::Kind::Spinous)
        .collect();
    spine.sort_by(|a, b| b.position_mm.y.total_cmp(&a.position_mm.y));
    for l in spine {
        let place = l.position_mm.truncate();
        let at = lay.at(place);
        if !lay.rect.contains(at) {
            continue;
        }
        painter.circle_filled(at, 1.6, inks.at(place).text);
        if at.y - last < 13.0 || at.y > lay.rect.bottom() - 30.0 || lay.rect.width() < 200.0 {
            continue;
        }
        last = at.y;
        // Beside the ruler, where no key is in the way.
        let aside = pos2(lay.rect.left() + LEFT + 4.0, at.y);
        halo_text(
            painter,
            aside,
            Align2::LEFT_CENTER,
            l.level,
            &font,
            inks.plain,
        );
    }
    for l in landmarks {
        let mark = match l.kind {
            back::Kind::ScapulaInferiorAngle | back::Kind::ScapulaSpine | back::Kind::Psis => true,
            back::Kind::Spinous | back::Kind::Transverse | back::Kind::IliacCrest => false,
        };
        let place = l.position_mm.truncate();
        let at = lay.at(place);
        if mark && lay.rect.contains(at) {
            let stroke = Stroke::new(1.0, inks.at(place).text);
            painter.line_segment([at - vec2(2.5, 0.0), at + vec2(2.5, 0.0)], stroke);
            painter.line_segment([at - vec2(0.0, 2.5), at + vec2(0.0, 2.5)], stroke);
        }
    }
}

/// Lines of equal value, with their values.
pub fn contours<M>(
    painter: &egui::Painter,
    lay: Lay,
    inks: &Inks<'_>,
    picture: &Picture<M>,
    scale: Scale,
    on_colour: bool,
) {
    let font = FontId::proportional(10.5);
    let decimals = decimals_for(picture.step);
    let mut taken: Vec<Rect> = Vec::new();
    for contour in &picture.contours {
        // A line lies on its own colour, everywhere.
        let ink = if on_colour {
            Ink::on(scale.colour(contour.level))
        } else {
            inks.plain
        };
        let stroke = Stroke::new(1.0, ink.text.gamma_multiply(0.62));
        let mut longest: Option<(f32, Vec<Pos2>)> = None;
        for line in &contour.lines {
            let points = lay.line(line.iter().copied());
            let length: f32 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
            if longest.as_ref().is_none_or(|(l, _)| length > *l) {
                longest = Some((length, points.clone()));
            }
            painter.add(Shape::line(points, stroke));
        }
        let Some((length, points)) = longest.filter(|(l, _)| *l > 50.0) else {
            continue;
        };
        // Where along the line a label finds room.
        let text = format!("{:.decimals$}", contour.level);
        for part in [0.5, 0.3, 0.7, 0.15, 0.85] {
            let Some(at) = along(&points, length * part) else {
                continue;
            };
            let room = Rect::from_center_size(at, vec2(7.0 * text.len() as f32 + 8.0, 15.0));
            let free = lay.rect.shrink(24.0).contains(at)
                && taken.iter().all(|other| !other.intersects(room));
            if free {
                halo_text(painter, at, Align2::CENTER_CENTER, &text, &font, ink);
                taken.push(room);
                break;
            }
        }
    }
}

/// Decimals that tell multiples of `step` apart.
pub fn decimals_for(step: f64) -> usize {
    if step.is_nan() || step <= 0.0 {
        return 0;
    }
    (-libm::floor(libm::log10(step) + 1e-9)).clamp(0.0, 6.0) as usize
}

fn along(points: &[Pos2], mut length: f32) -> Option<Pos2> {
    for w in points.windows(2) {
        let part = w[0].distance(w[1]);
        if part >= length && part > 0.0 {
            return Some(w[0].lerp(w[1], length / part));
        }
        length -= part;
    }
    None
}
