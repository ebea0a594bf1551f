//! Strokes of a brush that make the skin stiffer or softer along a path.

use crate::geom::Vec2;
use crate::geom::curve::{self, Curve};
use crate::maps::{MapError, on_the_map};
use std::ops::RangeInclusive;

/// Radii allowed for a brush, mm.
pub const STROKE_RADII_MM: RangeInclusive<f64> = 0.1..=1000.0;

/// Changes allowed at the centre of a stroke: from a hundredth of the stiffness to ten times it.
pub const STROKE_CHANGES: RangeInclusive<f64> = -0.99..=9.0;

/// Points that the path of a stroke may have.
pub const STROKE_POINTS: RangeInclusive<usize> = 1..=10_000;

/// What strokes may not leave, N/mm, unless a key is beyond it.
pub const BRUSHED_N_PER_MM: RangeInclusive<f64> = 0.001..=10_000.0;

/// One stroke: the stiffness is multiplied by 1 + change · M(distance / radius), with M the falloff.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Where the brush went on the map plane, mm; a single point is a dab.
    pub path: Vec<Vec2>,
    /// Radius of the brush, mm.
    pub radius_mm: f64,
    /// Change on the path: 0.5 makes half as stiff again, −0.5 half as stiff; above −1.
    pub change: f64,
    /// Name of the falloff, one of [`curve::all`].
    pub falloff: String,
}

/// A stroke ready to be read.
#[derive(Clone, Debug)]
pub(super) struct Brushed {
    path: Vec<Vec2>,
    radius_mm: f64,
    change: f64,
    falloff: Curve,
    /// Bounds of all that the stroke changes, mm.
    low: Vec2,
    high: Vec2,
}

impl Brushed {
    /// `number` counts strokes from 1.
    pub fn new(stroke: &Stroke, number: usize) -> Result<Self, MapError> {
        let refuse = |field, value: String, allowed: String| {
            Err(MapError::Stroke {
                stroke: number,
                field,
                value,
                allowed,
            })
        };
        let between = |(least, most): (f64, f64)| format!("{least} to {most} is allowed");
        let n = stroke.path.len();
        if !STROKE_POINTS.contains(&n) {
            let (least, most) = (STROKE_POINTS.start(), STROKE_POINTS.end());
            let allowed = format!("{least} to {most} are allowed");
            return refuse("number of points in path", n.to_string(), allowed);
        }
        if let Some(at) = stroke.path.iter().find(|at| !on_the_map(**at)) {
            let allowed = "numbers within ±1000000 mm are allowed".to_owned();
            return refuse("a point of path", format!("({}, {})", at.x, at.y), allowed);
        }
        if !STROKE_RADII_MM.contains(&stroke.radius_mm) {
            let allowed = between((*STROKE_RADII_MM.start(), *STROKE_RADII_MM.end()));
            return refuse("radius_mm", stroke.radius_mm.to_string(), allowed);
        }
        if !STROKE_CHANGES.contains(&stroke.change) {
            let allowed = between((*STROKE_CHANGES.start(), *STROKE_CHANGES.end()));
            return refuse("change", stroke.change.to_string(), allowed);
        }
        let Some((_, falloff)) = curve::all()
            .iter()
            .find(|(name, _)| *name == stroke.falloff)
        else {
            let names: Vec<_> = curve::all().iter().map(|(n, _)| format!("{n:?}")).collect();
            let allowed = format!("allowed are {}", names.join(", "));
            return refuse("falloff", format!("{:?}", stroke.falloff), allowed);
        };
        let reach = Vec2::splat(stroke.radius_mm);
        let all = || stroke.path.iter().copied();
        Ok(Self {
            low: all().fold(Vec2::INFINITY, Vec2::min) - reach,
            high: all().fold(Vec2::NEG_INFINITY, Vec2::max) + reach,
            path: stroke.path.clone(),
            radius_mm: stroke.radius_mm,
            change: stroke.change,
            falloff: falloff(),
        })
    }

    /// What the stiffness at a place is multiplied by; 1 outside the stroke.
    pub fn factor(&self, place: Vec2) -> f64 {
        if place.cmplt(self.low).any() || place.cmpgt(self.high).any() {
            return 1.0;
        }
        let q = self.distance_sq(place).sqrt() / self.radius_mm;
        1.0 + self.change * self.falloff.at(q)
    }

    fn distance_sq(&self, place: Vec2) -> f64 {
        let first = place.distance_squared(self.path[0]);
        self.path.windows(2).fold(first, |nearest, ends| {
            let along = ends[1] - ends[0];
            let t = (place - ends[0]).dot(along) / along.length_squared();
            // A segment of no length gives NaN, which `min` passes over: its ends count with its neighbours.
            let t = t.clamp(0.0, 1.0);
            nearest.min(place.distance_squared(ends[0] + along * t))
        })
    }
}
