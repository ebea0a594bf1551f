//! The map plane on the screen: x to the right, y up, mm.

use crate::geom::Vec2;
use egui::{Pos2, Rect, pos2};

/// Largest and smallest scale, points per mm.
const SCALE: std::ops::RangeInclusive<f64> = 0.02..=60.0;
/// Room around what is fitted, part of the screen.
const MARGIN: f64 = 0.06;

/// A rectangle of the map plane, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// Smallest x and y, mm.
    pub min: Vec2,
    /// Largest x and y, mm.
    pub max: Vec2,
}

impl Area {
    /// The rectangle around `points`; nothing without a finite one.
    pub fn around(points: impl IntoIterator<Item = Vec2>) -> Option<Self> {
        let finite = points.into_iter().filter(|p| p.is_finite());
        finite.fold(None, |area, p| {
            Some(match area {
                None => Self { min: p, max: p },
                Some(a) => Self {
                    min: a.min.min(p),
                    max: a.max.max(p),
                },
            })
        })
    }

    /// Width and height, mm.
    pub fn size(&self) -> Vec2 {
        self.max - self.min
    }

    /// The middle, mm.
    pub fn centre(&self) -> Vec2 {
        (self.min + self.max) * 0.5
    }

    /// Grown by `by_mm` on every side.
    #[must_use]
    pub fn grown(&self, by_mm: f64) -> Self {
        Self {
            min: self.min - by_mm,
            max: self.max + by_mm,
        }
    }

    /// The part common with `other`; nothing where they do not overlap.
    pub fn common(&self, other: &Self) -> Option<Self> {
        let (min, max) = (self.min.max(other.min), self.max.min(other.max));
        (min.x < max.x && min.y < max.y).then_some(Self { min, max })
    }

    /// The smallest rectangle that holds both.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// Whether `p` lies in it or on its border.
    pub fn contains(&self, p: Vec2) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }
}

/// Which part of the map plane is on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// The place in the middle of the screen, mm.
    pub centre_mm: Vec2,
    /// Scale, points per mm.
    pub points_per_mm: f64,
}

impl Default for Plane {
    fn default() -> Self {
        Self {
            centre_mm: Vec2::ZERO,
            points_per_mm: 1.0,
        }
    }
}

impl Plane {
    /// All of `area` in `rect`, in its middle, with a little room around.
    pub fn fit(area: &Area, rect: Rect) -> Self {
        let size = area.size().max(Vec2::splat(1.0));
        let room = Vec2::new(f64::from(rect.width()), f64::from(rect.height()));
        let scale = (room * (1.0 - 2.0 * MARGIN) / size).min_element();
        Self {
            centre_mm: area.centre(),
            points_per_mm: if scale.is_finite() {
                scale.clamp(*SCALE.start(), *SCALE.end())
            } else {
                1.0
            },
        }
    }

    /// Where a place of the map is on the screen.
    pub fn to_screen(&self, rect: Rect, p: Vec2) -> Pos2 {
        let d = (p - self.centre_mm) * self.points_per_mm;
        let c = rect.center();
        pos2(c.x + d.x as f32, c.y - d.y as f32)
    }

    /// Which place of the map is at a point of the screen, mm.
    pub fn to_map(&self, rect: Rect, p: Pos2) -> Vec2 {
        let d = p - rect.center();
        self.centre_mm + Vec2::new(f64::from(d.x), -f64::from(d.y)) / self.points_per_mm
    }

    /// What a movement on the screen is on the map, mm.
    pub fn delta_mm(&self, delta: egui::Vec2) -> Vec2 {
        Vec2::new(f64::from(delta.x), -f64::from(delta.y)) / self.points_per_mm
    }

    /// A length on the screen, points.
    pub fn points(&self, mm: f64) -> f32 {
        (mm * self.points_per_mm) as f32
    }

    /// Moves with the pointer; true when something moved.
    pub fn pan(&mut self, delta: egui::Vec2) -> bool {
        let moved = self.delta_mm(delta);
        let centre = self.centre_mm - moved;
        let usable = moved != Vec2::ZERO && centre.is_finite() && centre.abs().max_element() < 1e6;
        if usable {
            self.centre_mm = centre;
        }
        usable
    }

    /// Magnifies by `factor` so that `about_mm` stays where it is; true when something changed.
    pub fn zoom(&mut self, factor: f64, about_mm: Vec2) -> bool {
        let scale = (self.points_per_mm * factor).clamp(*SCALE.start(), *SCALE.end());
        if !scale.is_finite() || !about_mm.is_finite() || scale == self.points_per_mm {
            return false;
        }
        self.centre_mm = about_mm + (self.centre_mm - about_mm) * (self.points_per_mm / scale);
        self.points_per_mm = scale;
        true
    }

    /// The part of the map in `rect`.
    pub fn visible(&self, rect: Rect) -> Area {
        let (a, b) = (
            self.to_map(rect, rect.left_bottom()),
            self.to_map(rect, rect.right_top()),
        );
        Area { min: a, max: b }
    }
}

/// A round step (1, 2 or 5 times a power of ten) that divides `span` into at most `most` parts.
pub fn round_step(span: f64, most: f64) -> f64 {
    let least = span / most.max(1.0);
    if !(least.is_finite() && least > 0.0) {
        return 1.0;
    }
    let power = libm::pow(10.0, libm::floor(libm::log10(least)));
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|m| m * power)
        .find(|step| *step >= least * (1.0 - 1e-9))
        .unwrap_or(10.0 * power)
}

/// The multiples of `step` from `from` to `to`.
pub fn multiples(from: f64, to: f64, step: f64) -> Vec<f64> {
    if !(step > 0.0 && from.is_finite() && to.is_finite()) {
        return Vec::new();
    }
    let (first, last) = ((from / step).ceil(), (to / step).floor());
    let count = (last - first + 1.0).clamp(0.0, 1000.0) as usize;
    // Adding zero turns −0 into 0.
    (0..count)
        .map(|i| (first + i as f64) * step + 0.0)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const RECT: Rect = Rect {
        min: pos2(40.0, 10.0),
        max: pos2(440.0, 410.0),
    };

    #[test]
    fn what_is_fitted_is_seen_with_x_to_the_right_and_y_up() {
        let area = Area {
            min: Vec2::new(-200.0, 0.0),
            max: Vec2::new(200.0, 500.0),
        };
        let plane = Plane::fit(&area, RECT);
        let visible = plane.visible(RECT);
        assert!(visible.contains(area.min) && visible.contains(area.max));
        let (left, right) = (area.min, area.max);
        assert!(plane.to_screen(RECT, right).x > plane.to_screen(RECT, left).x);
        assert!(plane.to_screen(RECT, right).y < plane.to_screen(RECT, left).y);
    }

    #[test]
    fn steps_are_round_and_few() {
        assert_eq!(round_step(100.0, 10.0), 10.0);
        assert_eq!(round_step(100.0, 7.0), 20.0);
        assert_eq!(round_step(0.31, 7.0), 0.05);
        assert_eq!(round_step(0.0, 7.0), 1.0);
        assert_eq!(round_step(f64::NAN, 7.0), 1.0);
        assert_eq!(multiples(-1.0, 1.0, 0.5), [-1.0, -0.5, 0.0, 0.5, 1.0]);
        assert!(multiples(0.0, f64::INFINITY, 1.0).is_empty());
    }

    proptest! {
        #[test]
        fn there_and_back_is_where_it_was(x in -500.0..500.0f64, y in -500.0..500.0f64, f in 0.2..5.0f64) {
            let mut plane = Plane::default();
            let p = Vec2::new(x, y);
            plane.zoom(f, Vec2::new(30.0, -20.0));
            let back = plane.to_map(RECT, plane.to_screen(RECT, p));
            prop_assert!((back - p).length() < 1e-3, "{back} {p}");
        }

        #[test]
        fn zooming_keeps_the_place_under_the_pointer(x in 40.0..440.0f32, y in 10.0..410.0f32, f in -1.0..8.0f64) {
            let mut plane = Plane::default();
            let at = plane.to_map(RECT, pos2(x, y));
            plane.zoom(f, at);
            let after = plane.to_map(RECT, pos2(x, y));
            prop_assert!((after - at).length() < 1e-3 / plane.points_per_mm.min(1.0));
        }
    }
}
