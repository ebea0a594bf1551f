//! How far each press reaches over the skin: the boundaries of its footprints, carried along by the deformed skin.

use crate::deform::{Displacement, Press};
use crate::geom::Vec3;
use crate::partition::{Partition as _, Sides};
use crate::scenario::Scene;

/// Points along a boundary.
const POINTS: usize = 96;
/// How far above and below the tangent plane the skin is looked for, as a part of the distance from the press; a boundary
/// that lies farther off runs past the skin.
const HEIGHT: f64 = 1.2;

/// One boundary on the skin.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    /// Which finger, from 0.
    pub finger: usize,
    /// Whether it is that of the tangential half: where a drag of the finger ends. Else where its dent ends.
    pub tangential: bool,
    /// Points in order, closed: place on the rest skin and on the deformed one, mm; `None` where there is no skin.
    pub points: Vec<Option<[Vec3; 2]>>,
}

/// The boundaries of all presses, each with the finger it belongs to.
pub fn boundaries(
    scene: &Scene,
    displacement: &Displacement,
    presses: &[(usize, &Press)],
) -> Vec<Boundary> {
    let mut found = Vec::new();
    for (finger, press) in presses {
        let halves = scene.deform.outlines(&scene.surface, press, POINTS);
        for (outline, tangential) in halves.into_iter().zip([true, false]) {
            if !outline.is_empty() {
                let points = outline.into_iter();
                found.push(Boundary {
                    finger: *finger,
                    tangential,
                    points: points
                        .map(|p| on_skin(scene, displacement, press, p))
                        .collect(),
                });
            }
        }
    }
    found
}

/// The skin above or below a point of the tangent plane, at rest and deformed.
fn on_skin(
    scene: &Scene,
    displacement: &Displacement,
    press: &Press,
    point: Vec3,
) -> Option<[Vec3; 2]> {
    let surface = &scene.surface;
    let reach = press.normal * ((point - press.anchor_mm).length() * HEIGHT + 5.0);
    let search = &scene.touch.search;
    let hit = search.sweep(surface, point + reach, point - reach, Sides::Front)?;
    let carried = displacement.carried_point(surface, hit.triangle, hit.point);
    Some([hit.point, carried])
}
