//! Things on the canvas that a hand drags or arrow keys move. Each is a control of its own: Tab goes from one to the next.

use super::canvas::Lay;
use crate::geom::Vec2;
use egui::{Id, Key, Rect, Sense, vec2};

/// How near the pointer must be, points.
const REACH: f32 = 7.0;
/// A step of an arrow key, mm; ten times as much with Shift.
const STEP_MM: f64 = 1.0;

/// What happened to a handle.
#[derive(Debug)]
pub struct Gripped {
    /// The control.
    pub response: egui::Response,
    /// It was clicked, or reached with Tab, or is being dragged.
    pub chosen: bool,
    /// A drag began.
    pub started: bool,
    /// Where it is dragged to, mm.
    pub to_mm: Option<Vec2>,
    /// Where keys push it, mm: right and up are positive.
    pub push_mm: Option<Vec2>,
    /// The drag ended.
    pub ended: bool,
    /// Delete was pressed.
    pub delete: bool,
}

/// A handle at `at_mm`, called `name`. `tooltip` says what it does.
pub fn grip(
    ui: &mut egui::Ui,
    lay: Lay,
    id: Id,
    at_mm: Vec2,
    name: &str,
    tooltip: &str,
) -> Gripped {
    let at = lay.at(at_mm);
    let rect = Rect::from_center_size(at, vec2(2.0 * REACH, 2.0 * REACH));
    let response = ui.interact(rect.intersect(lay.rect), id, Sense::click_and_drag());
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::accesskit::Role::Button, ui.is_enabled(), name)
    });
    let started = response.drag_started_by(egui::PointerButton::Primary);
    if response.clicked() || started {
        response.request_focus();
    }
    let mut to_mm = None;
    if response.dragged_by(egui::PointerButton::Primary)
        && let Some(pointer) = response.interact_pointer_pos()
    {
        let pointer_mm = lay.plane.to_map(lay.rect, pointer);
        if started {
            // It is held where it was taken, not by its middle.
            let origin = ui.input(|i| i.pointer.press_origin()).unwrap_or(pointer);
            let held_mm = at_mm - lay.plane.to_map(lay.rect, origin);
            ui.data_mut(|d| d.insert_temp(id, held_mm.to_array()));
        }
        let held_mm: [f64; 2] = ui.data(|d| d.get_temp(id)).unwrap_or_default();
        to_mm = Some(pointer_mm + Vec2::from_array(held_mm));
    }
    let focused = response.has_focus();
    let (mut push_mm, mut delete) = (None, false);
    if focused {
        let filter = egui::EventFilter {
            horizontal_arrows: true,
            vertical_arrows: true,
            ..egui::EventFilter::default()
        };
        ui.memory_mut(|m| m.set_focus_lock_filter(id, filter));
        (push_mm, delete) = ui.input(|i| {
            let hits = |key: Key| i.num_presses(key) as f64;
            let push = Vec2::new(
                hits(Key::ArrowRight) - hits(Key::ArrowLeft),
                hits(Key::ArrowUp) - hits(Key::ArrowDown),
            );
            let step_mm = if i.modifiers.shift { 10.0 } else { 1.0 } * STEP_MM;
            let delete = hits(Key::Delete) + hits(Key::Backspace) > 0.0;
            ((push != Vec2::ZERO).then_some(push * step_mm), delete)
        });
    }
    let chosen = response.clicked() || response.gained_focus() || started;
    let ended = response.drag_stopped();
    let response = response
        .on_hover_text(tooltip)
        .on_hover_cursor(egui::CursorIcon::Grab);
    Gripped {
        chosen,
        started,
        to_mm: to_mm.filter(|p| p.is_finite()),
        push_mm,
        ended,
        delete,
        response,
    }
}
