//! The back under the hands: colours, sites, dysfunctions with their handles.

use super::doc::{self, Doc, centres, outwards, title};
use super::{State, preview, snap};
use crate::app::bench::Wake;
use crate::app::editor::canvas::{Handled, Lay, Look};
use crate::app::editor::frame;
use crate::app::editor::handles::{self, Gripped};
use crate::app::editor::ink::{Inks, halo_text};
use crate::app::editor::scale;
use crate::app::panels::PanelContext;
use crate::app::theme::Theme;
use crate::geom::Vec2;
use crate::scenario::{Dysfunction, Patch, Place, Site, SurfaceChoice, Target};
use egui::{Align2, FontId, Shape, Stroke, vec2};
use std::f64::consts::TAU;

/// How near a click must be to a site, points.
const CLICK: f64 = 9.0;
/// Points of an outline.
const OUTLINE: usize = 56;
/// How far beyond the first half axis the handle for the direction lies, points.
const BEYOND: f64 = 20.0;
/// Below this scale sites are too close to each other to be shown, points per mm.
const SITES_FROM: f64 = 0.35;

/// Draws it all and takes what a hand does.
pub fn show(
    ui: &mut egui::Ui,
    rect: egui::Rect,
    cx: &PanelContext<'_>,
    state: &mut State,
    wake: &Wake,
    editable: bool,
) {
    if rect.width() < 40.0 || rect.height() < 40.0 {
        return;
    }
    let theme = &cx.view.theme;
    let on_back = cx
        .view
        .scene
        .as_ref()
        .is_some_and(|s| matches!(s.scenario.surface, SurfaceChoice::BuiltinBack { .. }));
    let name = "Scenario on the back. Arrow keys move it, plus and minus zoom, Tab goes to the dysfunctions";
    let handled = state.canvas.place(ui, rect, name, true);
    let lay = state.canvas.lay(rect);
    let shows_sites = on_back && state.show.sites && lay.plane.points_per_mm >= SITES_FROM;
    let near = handled
        .cursor_mm
        .filter(|_| shows_sites)
        .and_then(|at| snap::nearest(at, CLICK / lay.plane.points_per_mm));
    if editable {
        click(state, &handled, near);
    }
    let spec = state.ground.spec(state.show.quantity);
    let area = state.canvas.visible(rect);
    state.field.follow(&spec, area, wake);
    let picture = state.field.picture().cloned();
    let shown = picture.as_ref().filter(|p| p.quantity == spec.quantity);
    let scale = shown.map(|p| preview::scale(state.show.quantity, p));
    let painter = ui.painter().with_clip_rect(rect);
    let look = Look {
        colour: state.show.colour,
        lines: state.show.lines,
        veiled: true,
        outline: true,
    };
    let made = state.field.made();
    let field = shown.zip(scale).map(|(p, s)| (p.as_ref(), made, s));
    state.canvas.paint(&painter, rect, theme, field, look);
    let inks = state.canvas.inks(theme, field, look);
    if shows_sites {
        sites(&painter, lay, &inks, theme, near.filter(|_| editable));
    }
    preview::follow_section(state);
    state.section.on_canvas(ui, lay, theme);
    for (i, patch) in &state.ground.patches {
        let chosen = state.editing.selected == Some(*i);
        outline(&painter, lay, &inks, theme, patch, chosen);
    }
    grips(ui, lay, theme, &inks, state, editable);
    let mut told = preview::told(picture.as_deref(), handled.cursor_mm);
    if let Some(site) = near {
        told = format!("{told}  {site}");
    }
    state.canvas.paint_front(&painter, rect, theme, &told);
    if let Some(scale) = scale.filter(|_| state.show.colour) {
        let quantity = state.show.quantity;
        let legend = scale::Legend {
            title: quantity.legend(),
            scale,
            decimals: quantity.decimals(),
            note: None,
        };
        let place = rect.shrink2(vec2(8.0, 24.0));
        scale::legend(&painter, place, theme, &legend);
    }
    frame::view_buttons(ui, rect, &mut state.canvas);
}

/// A click at a site adds there, a double click elsewhere adds at the very point, a click elsewhere lets go.
fn click(state: &mut State, handled: &Handled, near: Option<Site>) {
    let response = &handled.response;
    if let Some(site) = near.filter(|_| response.clicked() && !response.double_clicked()) {
        super::add(state, Place::from(site));
    } else if let Some(at) = handled.cursor_mm.filter(|_| response.double_clicked()) {
        if near.is_none() {
            super::add(state, Place::At(doc::tidy_place(at)));
        }
    } else if response.clicked() {
        state.editing.selected = None;
    }
}

/// Where a click adds.
fn sites(painter: &egui::Painter, lay: Lay, inks: &Inks<'_>, theme: &Theme, near: Option<Site>) {
    for (site, at) in snap::targets() {
        let p = lay.at(*at);
        if !lay.sees(p, 4.0) {
            continue;
        }
        let ink = inks.at(*at).text.gamma_multiply(0.75);
        match site.target {
            Target::Spinous => {
                painter.circle_stroke(p, 2.6, Stroke::new(1.0, ink));
            }
            Target::Transverse => {
                painter.circle_filled(p, 1.7, ink);
            }
            Target::RibAngle => {
                let d = 2.4;
                let corners = [vec2(-d, d), vec2(0.0, -d), vec2(d, d)].map(|v| p + v);
                let stroke = Stroke::new(1.0, ink);
                painter.add(Shape::closed_line(corners.to_vec(), stroke));
            }
            Target::Muscle => {
                painter.line_segment(
                    [p - vec2(0.0, 3.0), p + vec2(0.0, 3.0)],
                    Stroke::new(1.6, ink),
                );
            }
        }
        if near == Some(*site) {
            painter.circle_stroke(p, 7.0, Stroke::new(1.8, theme.accent));
        }
    }
}

fn outline(
    painter: &egui::Painter,
    lay: Lay,
    inks: &Inks<'_>,
    theme: &Theme,
    patch: &Patch,
    chosen: bool,
) {
    // A rim lies on the colour beside it, not on that of the middle.
    let at = inks.at(patch.spot.point(1.0, 0.0));
    let ring = |q: f64| {
        (0..OUTLINE)
            .map(|i| lay.at(patch.spot.point(q, TAU * i as f64 / OUTLINE as f64)))
            .collect::<Vec<_>>()
    };
    let (ink, width) = if chosen {
        (theme.accent, 2.2)
    } else {
        (at.text, 1.4)
    };
    let halo = Stroke::new(width + 1.6, at.halo.gamma_multiply(0.6));
    painter.add(Shape::closed_line(ring(1.0), halo));
    let stroke = Stroke::new(width, ink);
    if patch.does_nothing() || patch.stiffness_factor == 1.0 {
        // What changes no stiffness is drawn broken.
        let mut line = ring(1.0);
        line.extend(line.first().copied());
        painter.extend(Shape::dashed_line(&line, stroke, 5.0, 3.5));
    } else {
        painter.add(Shape::closed_line(ring(1.0), stroke));
    }
}

/// The middle of every dysfunction at each of its places, and the handles of the chosen one.
fn grips(
    ui: &mut egui::Ui,
    lay: Lay,
    theme: &Theme,
    inks: &Inks<'_>,
    state: &mut State,
    editable: bool,
) {
    let painter = ui.painter().with_clip_rect(lay.rect);
    let editing = &mut state.editing;
    let list = editing.doc().list.clone();
    let free = ui.input(|i| i.modifiers.alt || i.modifiers.shift);
    let mut delete = None;
    for (i, d) in list.iter().enumerate() {
        let on = editing.selected == Some(i);
        for (which, at) in centres(d).into_iter().enumerate() {
            if !lay.sees(lay.at(at), 0.0) {
                continue;
            }
            let id = ui.scope_id().with(("dysfunction", i, which));
            let said = said(d, i, which);
            let tooltip = format!(
                "{said}. Drag it from site to site, with Alt or Shift anywhere; arrow keys push it, Delete removes it"
            );
            let g = handles::grip(ui, lay, id, at, &said, &tooltip);
            if g.chosen {
                editing.selected = Some(i);
            }
            if editable {
                // Keys push by single mm: that is beside a site, never to the next one.
                let free = free || g.push_mm.is_some();
                editing.grip(&g, at, "Move dysfunction", |doc, to| {
                    doc.with(i, |d| doc::move_to(d, which, to, free))
                });
                delete = delete.or(g.delete.then_some(i));
            }
            let ink = inks.at(at);
            let p = lay.at(at);
            let fill = if on { theme.accent } else { ink.text };
            painter.circle(p, 4.0, fill, Stroke::new(1.5, ink.halo));
            if g.response.has_focus() || g.response.hovered() {
                painter.circle_stroke(p, 7.5, Stroke::new(1.6, theme.accent));
            }
            if which == 0 {
                let font = FontId::proportional(12.0);
                let text = format!("{}", i + 1);
                halo_text(
                    &painter,
                    p + vec2(6.0, -4.0),
                    Align2::LEFT_BOTTOM,
                    &text,
                    &font,
                    ink,
                );
            }
        }
        if editable && on {
            handles_of(ui, lay, theme, editing, d, i);
        }
    }
    if let Some(i) = delete {
        super::remove(state, i);
    }
}

fn said(d: &Dysfunction, index: usize, which: usize) -> String {
    let n = index + 1;
    match &d.place {
        Place::Sites(sites) if sites.len() > 1 => match sites.get(which) {
            Some(site) => format!("Dysfunction {n} at {site}"),
            None => format!("Dysfunction {n}"),
        },
        _ => format!("Dysfunction {n}: {}", title(d)),
    }
}

/// Handles for extent and angle, at the first place.
fn handles_of(
    ui: &mut egui::Ui,
    lay: Lay,
    theme: &Theme,
    editing: &mut crate::app::editor::editing::Editing<Doc>,
    d: &Dysfunction,
    index: usize,
) {
    let painter = ui.painter().with_clip_rect(lay.rect);
    let Some((at, out)) = centres(d)
        .first()
        .copied()
        .zip(outwards(&d.place).first().copied())
    else {
        return;
    };
    let n = index + 1;
    // Outwards is to the left on the left side: there directions are mirror images.
    let mirror = |v: Vec2| Vec2::new(v.x * out, v.y);
    let along = mirror(Vec2::from_angle(d.angle_deg.to_radians()));
    let across = mirror(Vec2::from_angle(d.angle_deg.to_radians()).perp());
    for (which, direction) in [along, across].into_iter().enumerate() {
        let mm = d.radius_mm[which];
        let place = at + direction * mm;
        let id = ui.scope_id().with(("half axis", index, which));
        let which_text = ["First", "Second"][which];
        let text = format!("{which_text} half axis of dysfunction {n}");
        let tooltip = format!("{text}: {mm:.1} mm. Drag it, or use the arrow keys");
        let g = handles::grip(ui, lay, id, place, &text, &tooltip);
        let length = g
            .to_mm
            .map(|to| (to - at).dot(direction).abs())
            .or(g.push_mm.map(|push| mm + push.x + push.y));
        let pushed = Gripped {
            to_mm: length.map(|mm| Vec2::new(mm, 0.0)),
            push_mm: None,
            ..g
        };
        editing.grip(&pushed, place, "Resize dysfunction", |doc, to| {
            doc.with(index, |d| doc::set_half_axis(d, which, to.x))
        });
        let p = lay.at(place);
        let r = egui::Rect::from_center_size(p, vec2(8.0, 8.0));
        painter.rect_filled(r, 1.5, theme.inset);
        let wide = pushed.response.has_focus() || pushed.response.hovered();
        let stroke = Stroke::new(if wide { 2.4 } else { 1.5 }, theme.accent);
        painter.rect_stroke(r, 1.5, stroke, egui::StrokeKind::Middle);
    }
    let reach = d.radius_mm[0] + BEYOND / lay.plane.points_per_mm;
    let place = at + along * reach;
    let id = ui.scope_id().with(("direction", index));
    let text = format!("Direction of dysfunction {n}");
    let tooltip = format!(
        "{text}: {:.0}° from outwards towards the head. Drag it round, or use the arrow keys: 1°, with Shift 10°",
        d.angle_deg
    );
    let g = handles::grip(ui, lay, id, place, &text, &tooltip);
    let degrees = g
        .to_mm
        .map(|to| mirror(to - at).to_angle().to_degrees())
        .or(g.push_mm.map(|push| d.angle_deg + push.x + push.y));
    let turned = Gripped {
        to_mm: degrees.map(|deg| Vec2::new(deg, 0.0)),
        push_mm: None,
        ..g
    };
    editing.grip(&turned, place, "Turn dysfunction", |doc, to| {
        doc.with(index, |d| d.angle_deg = doc::tidy_angle(to.x))
    });
    let end = lay.at(at + along * d.radius_mm[0]);
    painter.line_segment([end, lay.at(place)], Stroke::new(1.0, theme.accent));
    let wide = turned.response.has_focus() || turned.response.hovered();
    let stroke = Stroke::new(if wide { 2.6 } else { 1.8 }, theme.accent);
    painter.circle(lay.at(place), 4.5, theme.inset, stroke);
}
