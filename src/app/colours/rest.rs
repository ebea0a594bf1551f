//! Quantities of the scene at rest: they change only when the scene is edited.

use crate::contact::Stiffness;
use crate::deform::footprint::Kind;
use crate::maps::Oval;
use crate::scenario::Scene;

/// A quantity at rest.
pub enum Rest {
    /// The same everywhere: nothing is held per vertex.
    Same {
        /// Its value.
        value: f64,
        /// Why it does not vary, in a few words.
        why: &'static str,
    },
    /// The value at a vertex. Worked through beside the window where there are many.
    PerVertex(Box<dyn Fn(u32) -> f64 + Send>),
}

/// Stiffness felt, N/mm.
pub fn stiffness(scene: &Scene) -> Rest {
    match &scene.touch.stiffness {
        Stiffness::Uniform(value) => Rest::Same {
            value: *value,
            why: "the same everywhere",
        },
        Stiffness::PerVertex(values) => {
            let values = values.clone();
            Rest::PerVertex(Box::new(move |v| {
                values.get(v as usize).copied().unwrap_or(0.0)
            }))
        }
    }
}

/// Half the major axis of the footprint, mm.
pub fn half_major(scene: &Scene) -> Rest {
    of_ovals(scene, |oval| oval.half_major_mm)
}

/// Major over minor axis of the footprint; at least 1.
pub fn ratio(scene: &Scene) -> Rest {
    of_ovals(scene, |oval| oval.major_over_minor())
}

/// Direction of the major axis of the footprint on the map plane from x, degrees in 0…180.
pub fn direction(scene: &Scene) -> Rest {
    of_ovals(scene, |oval| oval.angle_rad.to_degrees().rem_euclid(180.0))
}

/// What the ellipse map says at every vertex; without one, what the scenario says of all of the skin.
fn of_ovals(scene: &Scene, value: fn(&Oval) -> f64) -> Rest {
    // A footprint that is a circle by choice has no use for a map.
    let mapped = scene.deform.footprint != Kind::Circle;
    if let Some(field) = scene.ellipse_field.as_ref().filter(|_| mapped) {
        let field = field.clone();
        return Rest::PerVertex(Box::new(move |v| value(&field.vertex(v))));
    }
    let basic = Oval {
        half_major_mm: scene.deform.half_major_mm,
        half_minor_mm: if mapped {
            scene.deform.half_minor_mm
        } else {
            scene.deform.half_major_mm
        },
        angle_rad: scene.deform.angle_rad,
    };
    Rest::Same {
        value: value(&basic),
        why: if basic.half_major_mm == basic.half_minor_mm {
            "the basic circle everywhere"
        } else {
            "the basic ellipse everywhere"
        },
    }
}
