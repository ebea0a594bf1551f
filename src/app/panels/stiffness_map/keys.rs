//! Keys and brush on the canvas.

use super::doc::{Brush, Doc, tidy_place};
use crate::app::editor::canvas::{Handled, Lay};
use crate::app::editor::editing::Editing;
use crate::app::editor::handles;
use crate::app::editor::ink::{Ink, Inks, halo_text};
use crate::app::editor::scale::Scale;
use crate::app::theme::Theme;
use egui::{Align2, FontId, PointerButton, Rect, Shape, Stroke, vec2};

/// Draws the keys and takes what a hand does to them.
pub fn show(
    ui: &mut egui::Ui,
    lay: Lay,
    theme: &Theme,
    inks: &Inks<'_>,
    scale: Option<Scale>,
    editing: &mut Editing<Doc>,
    editable: bool,
) {
    let painter = ui.painter().with_clip_rect(lay.rect);
    let keys = editing.doc().keys.clone();
    let font = FontId::proportional(11.0);
    let mut taken: Vec<Rect> = Vec::new();
    let mut delete = None;
    for (i, key) in keys.iter().enumerate() {
        let at = lay.at(key.at);
        if !lay.sees(at, 0.0) {
            continue;
        }
        let id = ui.scope_id().with(("key", i));
        let said = format!("Stiffness key {}", i + 1);
        let tooltip = format!(
            "Key {}: {:.3} N/mm at ({:.1}, {:.1}) mm. Drag it or push it with the arrow keys; Delete removes it",
            i + 1,
            key.stiffness_n_per_mm,
            key.at.x,
            key.at.y
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
        let on = editing.selected == Some(i);
        let fill = scale.map_or(theme.text, |s| s.colour(key.stiffness_n_per_mm));
        let ink = inks.at(key.at);
        let ring = if on { theme.accent } else { ink.text };
        let radius = if on { 5.5 } else { 4.0 };
        painter.circle(at, radius + 1.6, ink.halo, Stroke::NONE);
        painter.circle(
            at,
            radius,
            fill,
            Stroke::new(if on { 2.2 } else { 1.2 }, ring),
        );
        if g.response.has_focus() || g.response.hovered() {
            painter.circle_stroke(at, radius + 3.0, Stroke::new(1.5, theme.accent));
        }
        let room = Rect::from_min_size(at + vec2(6.0, -7.0), vec2(30.0, 14.0));
        if on || taken.iter().all(|r| !r.intersects(room)) {
            let text = format!("{:.2}", key.stiffness_n_per_mm);
            let place = at + vec2(8.0, 0.0);
            halo_text(&painter, place, Align2::LEFT_CENTER, &text, &font, ink);
            taken.push(room);
        }
    }
    if let Some(i) = delete {
        remove(editing, i);
    }
}

/// Removes a key, but not the last one.
pub fn remove(editing: &mut Editing<Doc>, index: usize) {
    if editing.doc().keys.len() == 1 {
        editing.told = Some("The last key stays: a stiffness map needs at least one".into());
        return;
    }
    let doc = editing.doc().without(index);
    editing.set("Remove key", doc);
    editing.selected = None;
}

/// Paints with the brush; one stroke is one step, however long.
pub fn paint(ui: &egui::Ui, handled: &Handled, brush: &Brush, editing: &mut Editing<Doc>) {
    let response = &handled.response;
    let lower = ui.input(|i| i.modifiers.alt) != brush.lowers;
    if response.drag_started_by(PointerButton::Primary) {
        let origin = ui.input(|i| i.pointer.press_origin());
        let at = origin.and_then(|p| handled.to_map(p)).or(handled.cursor_mm);
        if let Some(at) = at {
            editing.hold("Brush stroke");
            let doc = editing.doc().with_stroke(at, brush, lower);
            editing.set("Brush stroke", doc);
        }
    }
    if response.dragged_by(PointerButton::Primary)
        && editing.is_held()
        && let Some(at) = handled.cursor_mm
        && let Some(doc) = editing.doc().with_stroke_to(at)
    {
        editing.set("Brush stroke", doc);
    }
    if response.drag_stopped_by(PointerButton::Primary) {
        editing.release();
    }
    if response.clicked()
        && let Some(at) = handled.cursor_mm
    {
        let doc = editing.doc().with_stroke(at, brush, lower);
        editing.set("Brush dab", doc);
    }
}

/// The brush under the pointer, and the strokes there are; `chosen` stands out.
pub fn strokes(
    ui: &egui::Ui,
    lay: Lay,
    theme: &Theme,
    doc: &Doc,
    chosen: Option<usize>,
    brush: Option<(&Brush, &Handled)>,
) {
    let painter = ui.painter().with_clip_rect(lay.rect);
    for (i, stroke) in doc.strokes.iter().enumerate() {
        let on = chosen == Some(i);
        if !on && brush.is_none() {
            continue;
        }
        let points = lay.line(stroke.path.iter().copied());
        let ink = if on {
            theme.accent
        } else {
            theme.text.gamma_multiply(0.5)
        };
        let width = if on { 2.0 } else { 1.0 };
        if let [single] = points[..] {
            painter.circle_filled(single, 2.5, ink);
        }
        for end in [points.first(), points.last()]
            .into_iter()
            .flatten()
            .filter(|_| on)
        {
            let radius = lay.plane.points(stroke.radius_mm);
            painter.circle_stroke(*end, radius, Stroke::new(1.0, ink));
        }
        painter.add(Shape::line(points, Stroke::new(width, ink)));
    }
    let Some((brush, handled)) = brush else {
        return;
    };
    let Some(at) = handled.cursor_mm else {
        return;
    };
    let lower = ui.input(|i| i.modifiers.alt) != brush.lowers;
    let at = lay.at(at);
    let radius = lay.plane.points(brush.radius_mm);
    painter.circle_stroke(
        at,
        radius,
        Stroke::new(2.6, theme.inset.gamma_multiply(0.7)),
    );
    painter.circle_stroke(at, radius, Stroke::new(1.4, theme.accent));
    // Where the falloff is at half.
    painter.circle_stroke(
        at,
        radius * 0.5,
        Stroke::new(0.8, theme.accent.gamma_multiply(0.7)),
    );
    let sign = if lower { "−" } else { "+" };
    let text = format!("{sign}{:.0} %", brush.percent);
    let font = FontId::proportional(12.0);
    let place = at + vec2(0.0, -radius - 3.0);
    halo_text(
        &painter,
        place,
        Align2::CENTER_BOTTOM,
        &text,
        &font,
        Ink::of(theme),
    );
}
