//! Between the window's points (`f32`, egui) and the program's numbers (`f64`).

use crate::geom::Vec2;

/// A window position as a vector.
pub fn vec(p: egui::Pos2) -> Vec2 {
    Vec2::new(f64::from(p.x), f64::from(p.y))
}

/// A window offset as a vector.
pub fn delta(v: egui::Vec2) -> Vec2 {
    Vec2::new(f64::from(v.x), f64::from(v.y))
}

/// A vector as a window position.
pub fn pos(v: Vec2) -> egui::Pos2 {
    egui::pos2(v.x as f32, v.y as f32)
}

/// A length in points.
pub fn points(x: f64) -> f32 {
    x as f32
}

/// A colour without its transparency, sRGB.
pub fn rgb(color: egui::Color32) -> [u8; 3] {
    [color.r(), color.g(), color.b()]
}
