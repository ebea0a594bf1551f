//! The keys on the canvas: ellipses with handles at the centre, both axes and for the direction.

use super::doc::{Doc, tidy_place};
use super::show::Show;
use crate::app::editor::canvas::Lay;
use crate::app::editor::editing::Editing;
use crate::app::editor::handles::{self, Gripped};
use crate::app::editor::ink::{Ink, Inks, halo_text};
use crate::app::theme::Theme;
use crate::geom::Vec2;
use crate::maps::ellipse::HALF_AXES_MM;
use crate::maps::{EllipseKey, Oval};
use egui::{Align2, FontId, Shape, Stroke};
use std::f64::consts::TAU;

/// Points of an outline.
const OUTLINE: usize = 72;
/// How far beyond the major axis the handle for the direction lies, points.
const BEYOND: f64 = 20.0;
/// Widest spacing of the grid of ellipses, points.
const SPACING: f64 = 42.0;

/// Draws the keys and takes what a hand does to them. Without `editable` they can be looked at only.
pub fn show(
    ui: &mut egui::Ui,
    lay: Lay,
    theme: &Theme,
    inks: &Inks<'_>,
    show: &Show,
    editing: &mut Editing<Doc>,
    editable: bool,
) {
    if !editing.doc().on {
        return;
    }
    let painter = ui.painter().with_clip_rect(lay.rect);
    let keys = editing.doc().keys.clone();
    let size = show.key_size;
    if show.keys {
        for (i, key) in keys.iter().enumerate() {
            let on = editing.selected == Some(i);
            let text = inks.at(key.at);
            let ink = if on { theme.accent } else { text.text };
            let width = if on { 2.2 } else { 1.3 };
            let points = outline(key, size).map(|p| lay.at(p)).collect();
            let halo = Stroke::new(width + 1.6, text.halo.gamma_multiply(0.6));
            painter.add(Shape::closed_line(Vec::clone(&points), halo));
            painter.add(Shape::closed_line(points, Stroke::new(width, ink)));
            let axis = Vec2::from_angle(key.angle_rad) * key.half_major_mm * size;
            painter.line_segment(
                [lay.at(key.at - axis), lay.at(key.at + axis)],
                Stroke::new(1.0, ink.gamma_multiply(0.7)),
            );
        }
    }
    if show.reach
        && let Some(key) = editing.selected.and_then(|i| keys.get(i)).or(keys.first())
    {
        let settings = editing.doc().settings;
        let circle = |radius: f64, stroke: Stroke| {
            let at = lay.at(key.at);
            painter.circle_stroke(at, lay.plane.points(radius), stroke);
        };
        let text = |radius: f64, text: &str| {
            let p = lay.at(key.at + Vec2::new(0.0, radius));
            let font = FontId::proportional(10.5);
            halo_text(
                &painter,
                p,
                Align2::CENTER_BOTTOM,
                text,
                &font,
                Ink::of(theme),
            );
        };
        circle(settings.effect_radius_mm, Stroke::new(1.2, theme.accent));
        text(settings.effect_radius_mm, "effect");
        circle(settings.basic_radius_mm, Stroke::new(1.2, theme.weak_text));
        text(settings.basic_radius_mm, "basic circle");
    }
    let mut delete = None;
    for (i, key) in keys.iter().enumerate() {
        let name = label(key, i);
        if lay.sees(lay.at(key.at), 0.0) {
            let id = ui.scope_id().with(("key", i));
            let said = format!("Ellipse key {name}");
            let tooltip = format!(
                "{name}: {:.1} by {:.1} mm at {:.1}°. Drag it or push it with the arrow keys; Delete removes it",
                key.half_major_mm,
                key.half_minor_mm,
                key.angle_rad.to_degrees()
            );
            let g = handles::grip(ui, lay, id, key.at, &said, &tooltip);
            if g.chosen {
                editing.selected = Some(i);
            }
            if editable {
                editing.grip(&g, key.at, "Move key", |doc, to| {
                    doc.with_key(i, |k| k.at = tidy_place(to))
                });
                delete = delete.or(g.delete.then_some(i));
            }
            let hot = g.response.has_focus() || g.response.hovered();
            let on = editing.selected == Some(i);
            let ink = inks.at(key.at);
            paint_centre(&painter, lay.at(key.at), theme, ink, &name, on, hot);
        }
        if editable && show.keys && editing.selected == Some(i) {
            axes(ui, lay, theme, size, key, i, &name, editing);
        }
    }
    if let Some(i) = delete {
        let doc = editing.doc().without(i);
        editing.set("Remove key", doc);
        editing.selected = None;
    }
}

/// What a key is called.
pub fn label(key: &EllipseKey, index: usize) -> String {
    if key.name.is_empty() {
        format!("{}", index + 1)
    } else {
        key.name.clone()
    }
}

fn paint_centre(
    painter: &egui::Painter,
    at: egui::Pos2,
    theme: &Theme,
    ink: Ink,
    name: &str,
    on: bool,
    hot: bool,
) {
    let fill = if on { theme.accent } else { ink.text };
    painter.circle(at, 4.0, fill, Stroke::new(1.5, ink.halo));
    if hot {
        painter.circle_stroke(at, 7.0, Stroke::new(1.5, theme.accent));
    }
    let font = FontId::proportional(12.0);
    let aside = at + egui::vec2(6.0, -4.0);
    halo_text(painter, aside, Align2::LEFT_BOTTOM, name, &font, ink);
}

/// Handles of the chosen key.
#[expect(clippy::too_many_arguments, reason = "all that a key is drawn with")]
fn axes(
    ui: &mut egui::Ui,
    lay: Lay,
    theme: &Theme,
    size: f64,
    key: &EllipseKey,
    index: usize,
    name: &str,
    editing: &mut Editing<Doc>,
) {
    let painter = ui.painter().with_clip_rect(lay.rect);
    let dot = |p: Vec2, g: &Gripped| {
        let at = lay.at(p);
        let r = egui::Rect::from_center_size(at, egui::vec2(8.0, 8.0));
        painter.rect_filled(r, 1.5, theme.inset);
        let wide = g.response.has_focus() || g.response.hovered();
        let stroke = Stroke::new(if wide { 2.4 } else { 1.5 }, theme.accent);
        painter.rect_stroke(r, 1.5, stroke, egui::StrokeKind::Middle);
    };
    let along = Vec2::from_angle(key.angle_rad);
    let across = along.perp();
    for (axis, what, said) in [
        (
            along * key.half_major_mm,
            "Change half major axis",
            "Half major axis",
        ),
        (
            across * key.half_minor_mm,
            "Change half minor axis",
            "Half minor axis",
        ),
    ] {
        let at = key.at + axis * size;
        let id = ui.scope_id().with(("axis", what, index));
        let text = format!("{said} of {name}");
        let tooltip = format!(
            "{text}: {:.1} mm. Drag it, or use the arrow keys",
            axis.length()
        );
        let g = handles::grip(ui, lay, id, at, &text, &tooltip);
        // Keys make it longer or shorter, whatever its direction.
        let length = g
            .to_mm
            .map(|to| (to - key.at).dot(axis.normalize_or_zero()).abs() / size)
            .or(g.push_mm.map(|push| axis.length() + push.x + push.y));
        let pushed = Gripped {
            to_mm: length.map(|mm| Vec2::new(mm, 0.0)),
            push_mm: None,
            ..g
        };
        let major = what == "Change half major axis";
        editing.grip(&pushed, at, what, |doc, to| {
            doc.with_key(index, |k| set_half_axis(k, major, to.x))
        });
        dot(at, &pushed);
    }
    let out = key.half_major_mm * size + BEYOND / lay.plane.points_per_mm;
    let at = key.at + along * out;
    let id = ui.scope_id().with(("direction", index));
    let text = format!("Direction of {name}");
    let tooltip = format!(
        "{text}: {:.1}°. Drag it round, or use the arrow keys: 1°, with Shift 10°",
        key.angle_rad.to_degrees()
    );
    let g = handles::grip(ui, lay, id, at, &text, &tooltip);
    let degrees = g.to_mm.map(|to| (to - key.at).to_angle().to_degrees()).or(g
        .push_mm
        .map(|push| key.angle_rad.to_degrees() + push.x + push.y));
    let turned = Gripped {
        to_mm: degrees.map(|deg| Vec2::new(deg, 0.0)),
        push_mm: None,
        ..g
    };
    editing.grip(&turned, at, "Turn key", |doc, to| {
        doc.with_key(index, |k| set_degrees(k, to.x))
    });
    let end = lay.at(key.at + along * (key.half_major_mm * size));
    painter.line_segment([end, lay.at(at)], Stroke::new(1.0, theme.accent));
    painter.circle(lay.at(at), 4.5, theme.inset, Stroke::new(1.8, theme.accent));
    let Some(radii) = &key.boundary_mm else {
        return;
    };
    for (i, radius) in radii.iter().enumerate() {
        let direction = Vec2::from_angle(TAU * i as f64 / radii.len() as f64);
        let at = key.at + direction * radius * size;
        let id = ui.scope_id().with(("radius", index, i));
        let degrees = 360.0 * i as f64 / radii.len() as f64;
        let text = format!("Boundary of {name} at {degrees:.0}°");
        let tooltip = format!("{text}: {radius:.1} mm");
        let g = handles::grip(ui, lay, id, at, &text, &tooltip);
        let length = g
            .to_mm
            .map(|to| (to - key.at).dot(direction) / size)
            .or(g.push_mm.map(|push| radius + push.x + push.y));
        let pushed = Gripped {
            to_mm: length.map(|mm| Vec2::new(mm, 0.0)),
            push_mm: None,
            ..g
        };
        editing.grip(&pushed, at, "Shape boundary", |doc, to| {
            doc.with_key(index, |k| {
                if let Some(r) = k.boundary_mm.as_mut().and_then(|r| r.get_mut(i)) {
                    *r = tidy_length(to.x);
                }
            })
        });
        dot(at, &pushed);
    }
}

/// A length to a tenth of a mm, within what is allowed.
pub fn tidy_length(mm: f64) -> f64 {
    let tidy = (mm * 10.0).round() / 10.0;
    if tidy.is_nan() {
        return *HALF_AXES_MM.start();
    }
    tidy.clamp(*HALF_AXES_MM.start(), *HALF_AXES_MM.end())
}

/// Sets a half axis; the other one follows where the minor one would be the longer.
pub fn set_half_axis(key: &mut EllipseKey, major: bool, mm: f64) {
    let mm = tidy_length(mm);
    if major {
        key.half_major_mm = mm;
        key.half_minor_mm = key.half_minor_mm.min(mm);
    } else {
        key.half_minor_mm = mm.min(key.half_major_mm);
    }
}

/// Sets the direction, as 0 to 180 degrees; 180 stays what it is, as it is printed so.
pub fn set_degrees(key: &mut EllipseKey, degrees: f64) {
    let tidy = (degrees * 10.0).round() / 10.0;
    let turned = if tidy == 180.0 {
        tidy
    } else {
        tidy.rem_euclid(180.0)
    };
    key.angle_rad = turned.to_radians();
}

/// The boundary of a key at a part of its size.
fn outline(key: &EllipseKey, size: f64) -> impl Iterator<Item = Vec2> + '_ {
    let oval = key.oval();
    let radii = key.boundary_mm.as_deref();
    let n = radii.map_or(OUTLINE, <[f64]>::len);
    (0..n).map(move |i| {
        let direction = TAU * i as f64 / n as f64;
        let radius = match radii {
            Some(radii) => radii[i],
            None => oval.radius_mm(direction),
        };
        key.at + Vec2::from_angle(direction) * radius * size
    })
}

/// A grid of small ellipses: the map as it is between the keys.
pub fn grid(
    painter: &egui::Painter,
    lay: Lay,
    inks: &Inks<'_>,
    longest_mm: f64,
    covers: impl Fn(Vec2) -> bool,
    at: impl Fn(Vec2) -> Oval,
) {
    use crate::app::editor::plane::{multiples, round_step};
    let step = round_step(SPACING * 0.55 / lay.plane.points_per_mm, 1.0);
    let area = lay.plane.visible(lay.rect);
    let size = 0.46 * step / longest_mm.max(1e-9);
    for y in multiples(area.min.y, area.max.y, step) {
        for x in multiples(area.min.x, area.max.x, step) {
            let place = Vec2::new(x, y);
            if !covers(place) {
                continue;
            }
            let stroke = Stroke::new(1.1, inks.at(place).text.gamma_multiply(0.8));
            let oval = at(place);
            let (a, b) = (oval.half_major_mm * size, oval.half_minor_mm * size);
            let along = Vec2::from_angle(oval.angle_rad);
            let points = (0..28)
                .map(|i| {
                    let (sin, cos) = (TAU * f64::from(i) / 28.0).sin_cos();
                    lay.at(place + along * (a * cos) + along.perp() * (b * sin))
                })
                .collect();
            painter.add(Shape::closed_line(points, stroke));
            // The direction, where there is one to see.
            if oval.major_over_minor() > 1.01 {
                let axis = along * a;
                painter.line_segment([lay.at(place - axis), lay.at(place + axis)], stroke);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_axes_stay_in_order_and_directions_in_half_a_turn() {
        let mut key = EllipseKey::new("", Vec2::ZERO, 150.0, 120.0, 1.0);
        set_half_axis(&mut key, true, 100.04);
        assert_eq!((key.half_major_mm, key.half_minor_mm), (100.0, 100.0));
        set_half_axis(&mut key, false, 300.0);
        assert_eq!(key.half_minor_mm, 100.0);
        set_half_axis(&mut key, true, f64::NAN);
        assert!(key.half_major_mm >= 1.0);
        for (given, kept) in [(-10.0, 170.0), (180.0, 180.0), (190.0, 10.0), (359.96, 0.0)] {
            set_degrees(&mut key, given);
            assert!((key.angle_rad.to_degrees() - kept).abs() < 1e-9, "{given}");
        }
    }
}
