//! Numbers, scale, labels and the hint over the picture.

use super::ghosts;
use super::labels::{self, Wish};
use super::model::{self, Finger};
use super::options::Options;
use super::palpate::Palpation;
use super::places;
use super::skin::DrawnSkin;
use crate::app::camera::Camera;
use crate::app::render::pixels;
use crate::app::state::{ExerciseView, GhostView};
use crate::app::stereo::Pane;
use crate::app::theme::Theme;
use crate::geom::Vec3;
use egui::{Align2, Color32, FontId, RichText, Stroke, pos2, vec2};
use std::sync::Arc;

/// What the overlay shows.
pub struct Shown<'a> {
    pub camera: &'a Camera,
    /// The pictures: one, or one for each eye.
    pub panes: &'a [Pane],
    /// Whether what fingers tell of stiffness is kept back.
    pub blind: bool,
    pub theme: &'a Theme,
    pub skin: &'a DrawnSkin,
    pub fingers: &'a [Finger],
    /// Fingers there are, also those not near the skin.
    pub n_fingers: usize,
    /// The mouse fingers, while the mouse can move them.
    pub palpation: Option<&'a Palpation>,
    pub hint: bool,
    pub focus_ring: bool,
    pub options: Options,
    /// Where the toolbar ends on the right.
    pub toolbar_end: f32,
    /// Overlaid recordings.
    pub ghosts: &'a [GhostView],
    /// The exercise that runs.
    pub exercise: Option<&'a ExerciseView>,
}

/// How to press, in a line: the longest that fits is shown.
const HINTS: [&str; 3] = [
    "Hold the left button to press · wheel or W S set the depth · move to slide · P parks the other finger · right-drag turns",
    "Hold the left button to press · wheel sets the depth · right-drag turns the view",
    "Hold the left button to press",
];

/// The plate that keeps text readable over the picture.
pub fn plate(theme: &Theme) -> egui::Frame {
    egui::Frame::new()
        .fill(theme.panel.gamma_multiply(0.88))
        .corner_radius(6)
        .inner_margin(egui::Margin::symmetric(6, 3))
}

/// Draws everything over the picture in `rect`, save the toolbar.
pub fn show(ui: &mut egui::Ui, rect: egui::Rect, shown: &Shown<'_>) {
    let painter = ui.painter().with_clip_rect(rect);
    let mut names = None;
    for pane in shown.panes {
        let corner = rect.min + pixels::pos(pane.from).to_vec2();
        let size = pixels::pos(pane.size).to_vec2();
        let place = egui::Rect::from_min_size(corner, size);
        let painter = ui.painter().with_clip_rect(place);
        if shown.options.anatomy.landmarks {
            // Both eyes see the same names at the same places beside what they name, or they could not be fused.
            let names = names
                .get_or_insert_with(|| names_to_show(&painter, place, shown, &pane.camera, rect));
            landmarks(&painter, place, shown, &pane.camera, names);
        }
        if shown.options.footprints {
            footprints(&painter, place, shown, &pane.camera);
        }
        if let Some(exercise) = shown.exercise {
            places::show(&painter, place, shown, &pane.camera, exercise);
        }
        ghosts::show(&painter, place, shown, &pane.camera);
        for finger in shown.fingers {
            finger_marks(&painter, place, shown, &pane.camera, finger);
        }
    }
    let scale_end = scale(&painter, rect, shown);
    numbers_ui(ui, rect, shown);
    hint(ui, &painter, rect, shown, scale_end);
    if shown.focus_ring {
        painter.rect_stroke(
            rect.shrink(1.0),
            2.0,
            Stroke::new(1.5, shown.theme.accent),
            egui::StrokeKind::Inside,
        );
    }
}

/// Where a point appears in the window.
pub(super) fn on_screen(rect: egui::Rect, camera: &Camera, point_mm: Vec3) -> Option<egui::Pos2> {
    let p = camera.project(point_mm, pixels::delta(rect.size()))?;
    Some(rect.min + pixels::pos(p).to_vec2())
}

/// A landmark to be shown: where it lies, and its name with the place of that beside it, where there is room.
struct Named {
    at_mm: Vec3,
    has_name: bool,
    text: Option<(egui::Vec2, Arc<egui::Galley>)>,
}

/// The landmarks that face the eye, carried along by the deformed skin. Names that have no room are left out; `whole` is what
/// toolbar and numbers lie over.
fn names_to_show(
    painter: &egui::Painter,
    rect: egui::Rect,
    shown: &Shown<'_>,
    camera: &Camera,
    whole: egui::Rect,
) -> Vec<Named> {
    let (scene, skin) = (shown.skin.scene(), shown.skin.displacement());
    let (mut found, mut wishes, mut texts) = (Vec::new(), Vec::new(), Vec::new());
    for mark in shown.skin.marks() {
        if !model::is_seen(scene, camera, mark.point_mm) {
            continue;
        }
        let at_mm = skin.carried_point(&scene.surface, mark.triangle, mark.point_mm);
        let has_name = !mark.text.is_empty();
        if has_name && let Some(at) = on_screen(rect, camera, at_mm) {
            let font = FontId::proportional(11.0);
            let text = painter.layout_no_wrap(mark.text.clone(), font, shown.theme.text);
            wishes.push(Wish {
                at,
                size: text.size(),
                on_left: mark.point_mm.x < -1.0,
                rank: mark.rank,
            });
            texts.push((found.len(), text));
        }
        found.push(Named {
            at_mm,
            has_name,
            text: None,
        });
    }
    let toolbar = egui::Rect::from_min_max(
        whole.min,
        pos2(shown.toolbar_end.max(whole.left()), whole.top() + 42.0),
    );
    let mut taken = vec![toolbar, numbers_rect(whole, shown)];
    for finger in shown.fingers {
        if let Some((at, text)) = force_label(painter, rect, shown, camera, finger) {
            taken.push(egui::Rect::from_min_size(at, text.size()).expand2(vec2(4.0, 1.0)));
        }
    }
    let places = labels::placed(&wishes, &taken, rect);
    for (((i, text), place), wish) in texts.into_iter().zip(places).zip(&wishes) {
        found[i].text = place.map(|place| (place.min - wish.at, text));
    }
    found
}

/// Dots and names of landmarks.
fn landmarks(
    painter: &egui::Painter,
    rect: egui::Rect,
    shown: &Shown<'_>,
    camera: &Camera,
    names: &[Named],
) {
    let theme = shown.theme;
    let places: Vec<_> = (names.iter())
        .map(|named| on_screen(rect, camera, named.at_mm))
        .collect();
    for (named, at) in names.iter().zip(&places) {
        let radius = if named.has_name { 2.4 } else { 1.6 };
        if let Some(at) = at {
            painter.circle(*at, radius, theme.text, Stroke::new(1.0, theme.panel));
        }
    }
    for (named, at) in names.iter().zip(&places) {
        if let (Some((beside, text)), Some(at)) = (&named.text, at) {
            label(painter, theme, *at + *beside, text.clone());
        }
    }
}

/// The boundaries of the presses where they face the eye: outer lines drawn out, inner ones dashed.
fn footprints(painter: &egui::Painter, rect: egui::Rect, shown: &Shown<'_>, camera: &Camera) {
    let scene = shown.skin.scene();
    for boundary in shown.skin.boundaries() {
        let seen = |&[rest, carried]: &[Vec3; 2]| {
            let seen = model::is_seen(scene, camera, rest);
            on_screen(rect, camera, carried).filter(|_| seen)
        };
        let points: Vec<_> = (boundary.points.iter())
            .map(|p| p.as_ref().and_then(seen))
            .collect();
        // A dark line under the coloured one: it is seen on any skin.
        let strokes = [
            Stroke::new(3.2, Color32::from_black_alpha(120)),
            Stroke::new(1.6, shown.theme.finger(boundary.finger)),
        ];
        for stroke in strokes {
            for i in 0..points.len() {
                let next = points[(i + 1) % points.len()];
                let (Some(a), Some(b)) = (points[i], next) else {
                    continue;
                };
                if boundary.tangential || i % 2 == 0 {
                    painter.line_segment([a, b], stroke);
                }
            }
        }
    }
}

/// Text on a small plate, its top left at `at`.
pub(super) fn label(
    painter: &egui::Painter,
    theme: &Theme,
    at: egui::Pos2,
    text: Arc<egui::Galley>,
) {
    let place = egui::Rect::from_min_size(at, text.size());
    painter.rect_filled(
        place.expand2(vec2(4.0, 1.0)),
        4.0,
        theme.panel.gamma_multiply(0.8),
    );
    painter.galley(at, text, theme.text);
}

/// The device's place under the skin, and the force in newtons at the arrow's tip.
fn finger_marks(
    painter: &egui::Painter,
    rect: egui::Rect,
    shown: &Shown<'_>,
    camera: &Camera,
    finger: &Finger,
) {
    let color = shown.theme.finger(finger.index);
    if let Some(hip) = finger.hip_mm.and_then(|p| on_screen(rect, camera, p)) {
        painter.circle(
            hip,
            3.0,
            color.gamma_multiply(0.9),
            Stroke::new(1.2, Color32::WHITE.gamma_multiply(0.85)),
        );
    }
    if let Some((at, text)) = force_label(painter, rect, shown, camera, finger) {
        label(painter, shown.theme, at, text);
    }
}

/// The force in newtons and where its text stands, beside the arrow's tip.
fn force_label(
    painter: &egui::Painter,
    rect: egui::Rect,
    shown: &Shown<'_>,
    camera: &Camera,
    finger: &Finger,
) -> Option<(egui::Pos2, Arc<egui::Galley>)> {
    let newtons = finger.force_n.length();
    if !shown.options.arrows || newtons < 0.1 {
        return None;
    }
    let tip = on_screen(rect, camera, finger.arrow_from_mm() + finger.arrow_mm())?;
    let words = format!("{newtons:.1} N");
    let text = painter.layout_no_wrap(words, FontId::monospace(12.0), shown.theme.text);
    Some((tip + vec2(10.0, -8.0), text))
}

/// A bar of round length and an arrow of round force, at the depth the camera looks at. Returns where they end on the right.
fn scale(painter: &egui::Painter, rect: egui::Rect, shown: &Shown<'_>) -> f32 {
    let theme = shown.theme;
    let size = pixels::delta(rect.size());
    let px_per_mm = shown.camera.px_per_mm(shown.camera.target_mm, size.y);
    let most_px = (size.x * 0.2).min(130.0);
    let left = rect.left() + 16.0;
    let mut y = rect.bottom() - 18.0;
    let ink = Stroke::new(1.5, theme.text.gamma_multiply(0.85));
    let mut end = left;
    let mut text = |y, length, words: String| {
        let place = painter.text(
            pos2(left + length + 8.0, y),
            Align2::LEFT_CENTER,
            words,
            FontId::proportional(12.0),
            theme.text.gamma_multiply(0.9),
        );
        end = end.max(place.right());
    };
    if let Some(mm) = model::round_below(most_px / px_per_mm.max(1e-9)) {
        let length = pixels::points(mm * px_per_mm);
        painter.line_segment([pos2(left, y), pos2(left + length, y)], ink);
        for x in [left, left + length] {
            painter.line_segment([pos2(x, y - 4.0), pos2(x, y + 4.0)], ink);
        }
        text(y, length, format!("{mm} mm"));
    }
    let newton_px = px_per_mm * model::ARROW_MM_PER_N;
    if shown.options.arrows
        && let Some(newtons) = model::round_below(most_px / newton_px.max(1e-9))
    {
        y -= 20.0;
        let length = pixels::points(newtons * newton_px);
        let tip = pos2(left + length, y);
        painter.line_segment([pos2(left, y), tip - vec2(6.0, 0.0)], ink);
        painter.add(egui::Shape::convex_polygon(
            vec![tip, tip + vec2(-8.0, -4.0), tip + vec2(-8.0, 4.0)],
            ink.color,
            Stroke::NONE,
        ));
        text(y, length, format!("{newtons} N"));
    }
    end
}

/// Depth, force and stiffness of each finger, in columns that do not move.
fn numbers_ui(ui: &mut egui::Ui, rect: egui::Rect, shown: &Shown<'_>) {
    if shown.n_fingers == 0 {
        return;
    }
    let place = numbers_rect(rect, shown);
    let builder = egui::UiBuilder::new()
        .max_rect(place)
        .layout(egui::Layout::top_down(egui::Align::Min));
    ui.scope_builder(builder, |ui| {
        plate(shown.theme).show(ui, |ui| {
            ui.spacing_mut().item_spacing = vec2(0.0, 1.0);
            ui.horizontal(|ui| {
                for (column, head) in ["", "Depth", "Force", "Stiffness"].into_iter().enumerate() {
                    cell(ui, column, RichText::new(head).size(11.0).weak());
                }
            });
            for index in 0..shown.n_fingers {
                ui.horizontal(|ui| row_ui(ui, shown, index));
            }
            if let Some(palpation) = shown.palpation {
                let wanted = format!("Pressing asks for {:>4.1} mm", palpation.depth_mm());
                ui.label(RichText::new(wanted).size(11.0).weak())
                    .on_hover_text("Set it with the wheel while pressing, or with W and S");
            }
        });
    });
}

/// Where the numbers stand, and room below them.
fn numbers_rect(rect: egui::Rect, shown: &Shown<'_>) -> egui::Rect {
    let mut place = rect.shrink(8.0);
    let width: f64 = COLUMNS.iter().sum();
    place.min.x = place.max.x - pixels::points(width) - 12.0;
    if place.min.x < shown.toolbar_end + 8.0 {
        // Beside the toolbar there is no room: below it.
        place.min.y += 34.0;
    }
    let rows = 2.0 + shown.n_fingers as f32;
    place.with_max_y(place.min.y + 10.0 + 17.0 * rows)
}

/// Widths of name, depth, force and stiffness, points.
const COLUMNS: [f64; 4] = [22.0, 68.0, 62.0, 88.0];

/// One entry of the table, to the right of its column.
fn cell(ui: &mut egui::Ui, column: usize, text: RichText) -> egui::Response {
    let size = vec2(pixels::points(COLUMNS[column]), 16.0);
    let layout = if column == 0 {
        egui::Layout::left_to_right(egui::Align::Center)
    } else {
        egui::Layout::right_to_left(egui::Align::Center)
    };
    ui.allocate_ui_with_layout(size, layout, |ui| {
        ui.set_min_size(size);
        ui.label(text)
    })
    .inner
}

fn row_ui(ui: &mut egui::Ui, shown: &Shown<'_>, index: usize) {
    let finger = shown.fingers.iter().find(|f| f.index == index);
    let name = ["L", "R", "L2", "R2"].get(index).copied().unwrap_or("?");
    let name = RichText::new(name).strong();
    cell(ui, 0, name.color(shown.theme.finger(index)));
    let touching = finger.filter(|f| f.stiffness_n_per_mm.is_some());
    let number = |value: Option<f64>, digits: usize, unit: &str| match value {
        Some(v) => RichText::new(format!("{v:.digits$} {unit}")).monospace(),
        None => RichText::new(format!("– {unit}")).monospace().weak(),
    };
    // At the same wish of a hand that gives way, the depth alone would tell the stiffness.
    let told = touching.filter(|_| !shown.blind);
    cell(ui, 1, number(told.map(|f| f.depth_mm), 1, "mm"));
    let force = number(told.map(|f| f.force_n.length()), 1, "N");
    if touching.is_some_and(|f| f.limited) {
        cell(ui, 2, force.color(shown.theme.warning))
            .on_hover_text("The device's rated force is reached: the skin would push harder");
    } else {
        cell(ui, 2, force);
    }
    let stiffness = touching.and_then(|f| f.stiffness_n_per_mm);
    let told = cell(ui, 3, number(stiffness.filter(|_| !shown.blind), 2, "N/mm"));
    if shown.blind {
        told.on_hover_text("Kept back until the answer");
    }
}

/// How to press, until one has: a quiet line below the back, beside the scale that ends at `scale_end`.
fn hint(
    ui: &egui::Ui,
    painter: &egui::Painter,
    rect: egui::Rect,
    shown: &Shown<'_>,
    scale_end: f32,
) {
    let strength = ui.ctx().animate_bool_with_time(
        egui::Id::unique("back view hint"),
        shown.hint && shown.palpation.is_some(),
        1.2,
    );
    if strength <= 0.0 {
        return;
    }
    let ink = shown.theme.text.gamma_multiply(0.8 * strength);
    let (from, to) = (scale_end + 24.0, rect.right() - 16.0);
    let fitting = HINTS.iter().find_map(|&words| {
        let text = painter.layout_no_wrap(words.to_owned(), FontId::proportional(12.0), ink);
        (text.size().x <= to - from).then_some(text)
    });
    if let Some(text) = fitting {
        let (size, room) = (text.size(), to - from);
        // In the middle of the picture, unless the scale is in the way.
        let x = (rect.center().x - size.x / 2.0).clamp(from, from + (room - size.x));
        painter.galley(pos2(x, rect.bottom() - 18.0 - size.y / 2.0), text, ink);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_on_screen_lies_where_the_camera_projects_it() {
        let rect = egui::Rect::from_min_size(pos2(100.0, 50.0), vec2(400.0, 300.0));
        let camera = Camera::default();
        let middle = on_screen(rect, &camera, camera.target_mm).unwrap();
        assert!((middle - rect.center()).length() < 1e-3);
    }
}
