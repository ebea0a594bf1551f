//! Closed forms as models of the drawn skin: the skin near the finger taken for flat.

use super::Dent;
use super::plane::Plane;
use super::traction;
use crate::deform::strain::Strain;
use crate::deform::{Displacement, Model, Press, Spread};
use crate::geom::Vec2;
use crate::surface::Surface;
use std::sync::Arc;

/// A dent, and what drags along the surface; each vertex moves by the closed form at its place on the tangent plane.
///
/// Presses add up. Vertices within `reach_mm` that hang together with the finger move; the closed forms themselves never
/// end, so a step of what is left there stays at the rim.
pub struct Continuum {
    dent: Arc<dyn Dent>,
    drag: Option<traction::Gaussian>,
    reach_mm: f64,
    spread: Spread,
}

impl Continuum {
    /// A model of `dent`, and of `drag` where the skin is to follow along the surface too.
    pub fn new(dent: Arc<dyn Dent>, drag: Option<traction::Gaussian>, reach_mm: f64) -> Self {
        Self {
            dent,
            drag,
            reach_mm,
            spread: Spread::default(),
        }
    }

    fn gather(&mut self, surface: &Surface, presses: &[Press]) {
        self.spread.begin(surface);
        for press in presses {
            let Some(plane) = Plane::of(press, surface) else {
                continue;
            };
            let pull = press.foot_mm - press.anchor_mm;
            let pull_mm = Vec2::new(pull.dot(plane.x), pull.dot(plane.y));
            self.spread.around(surface, press.triangle, |at| {
                let place = plane.place_mm(at);
                let r_mm = place.length();
                if r_mm > self.reach_mm {
                    return None;
                }
                let down = plane.normal * -self.dent.at_mm(press.depth_mm, r_mm);
                let along = match &self.drag {
                    Some(drag) if pull_mm.is_finite() => drag.at_mm(pull_mm, place),
                    _ => Vec2::ZERO,
                };
                Some(down + plane.x * along.x + plane.y * along.y)
            });
        }
    }
}

impl Model for Continuum {
    fn name(&self) -> &'static str {
        self.dent.name()
    }

    fn prepare(&mut self, surface: &Surface) {
        self.spread.prepare(surface);
    }

    fn update(&mut self, surface: &Surface, presses: &[Press], out: &mut Displacement) {
        self.gather(surface, presses);
        self.spread.write(surface, out, None);
    }

    fn update_strained(
        &mut self,
        surface: &Surface,
        presses: &[Press],
        out: &mut Displacement,
        strain: &mut Strain,
    ) {
        self.gather(surface, presses);
        self.spread.write(surface, out, Some(strain));
    }
}
