//! How stiff a scene gets: what a device is held against.

use super::Scene;
use crate::contact::{ForceModel, Stiffness, TouchScene};

/// The most that a palpating finger uses, N (METHOD 7): how deep a press goes whose slope counts.
const PALPATION_N: f64 = 8.0;
/// No press goes deeper, mm.
const DEEPEST_MM: f64 = 100.0;

impl Scene {
    /// The highest stiffness felt anywhere in the scene, dysfunctions included, N/mm: the steepest slope of force over depth
    /// down to a press of 8 N. With the linear force model the highest stiffness of the skin itself.
    pub fn stiffest_n_per_mm(&self) -> f64 {
        of(&self.touch)
    }
}

fn of(touch: &TouchScene) -> f64 {
    // Between vertices it is a mean of theirs; what is no stiffness is felt as 0.
    let highest = |s: &Stiffness| match s {
        Stiffness::Uniform(k) => k.max(0.0),
        Stiffness::PerVertex(values) => values.iter().fold(0.0, |most: f64, k| most.max(*k)),
    };
    let k = highest(&touch.stiffness);
    let model = &touch.choices.force;
    model.steepest_n_per_mm(k, depth_mm(model, k))
}

/// How deep a press of [`PALPATION_N`] goes, mm.
fn depth_mm(model: &ForceModel, k: f64) -> f64 {
    let (mut above, mut below) = (0.0, DEEPEST_MM);
    for _ in 0..60 {
        let middle = 0.5 * (above + below);
        if model.force_n(k, middle, 0.0) < PALPATION_N {
            above = middle;
        } else {
            below = middle;
        }
    }
    below
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Choices;
    use crate::partition::bvh::Bvh;
    use crate::scenario::{Scenario, Use, build};
    use crate::surface::{RawMesh, Surface};
    use std::sync::Arc;

    fn touch(stiffness: Stiffness, force: ForceModel) -> TouchScene {
        let mesh = RawMesh {
            positions: vec![
                crate::geom::Vec3::X,
                crate::geom::Vec3::Y,
                crate::geom::Vec3::Z,
            ],
            triangles: vec![[0, 1, 2]],
        };
        let surface = Arc::new(Surface::new(mesh).expect("sound").0);
        let search = Arc::new(Bvh::new(&surface));
        TouchScene {
            choices: Choices {
                force,
                ..Choices::default()
            },
            ..TouchScene::new(surface, search, stiffness)
        }
    }

    #[test]
    fn of_a_linear_skin_it_is_that_of_its_stiffest_place() {
        let values = Stiffness::PerVertex(Arc::from([0.4, 1.3, f64::NAN]));
        assert_eq!(of(&touch(values, ForceModel::Linear)), 1.3);
        assert_eq!(of(&touch(Stiffness::Uniform(0.7), ForceModel::Linear)), 0.7);
    }

    /// F = (k/B)(exp(B d) − 1): its slope at a force is k + B F. F = k d^1.5: 1.5 k^(2/3) F^(1/3).
    #[test]
    fn of_a_stiffening_skin_it_is_the_slope_of_a_firm_press() {
        let growth = ForceModel::Exponential {
            growth_per_mm: 0.15,
        };
        let k = of(&touch(Stiffness::Uniform(0.5), growth));
        assert!((k - (0.5 + 0.15 * 8.0)).abs() < 1e-9, "{k}");
        let hertz = ForceModel::HuntCrossley {
            damping_s_per_mm: 0.002,
            exponent: 1.5,
        };
        let k = of(&touch(Stiffness::Uniform(0.5), hertz));
        let closed = 1.5 * libm::pow(0.5, 2.0 / 3.0) * 2.0;
        assert!((k - closed).abs() < 1e-9, "{k}");
    }

    #[test]
    fn a_dysfunction_that_stiffens_is_in_it() {
        let plain = "format = 1\nname = \"Plain\"\n[surface]\nbuiltin = \"back\"\n[stiffness]\nconstant_n_per_mm = 1\n";
        let hard = format!(
            "{plain}[[dysfunction]]\nkind = \"hypertonic\"\nlevel = \"T5\"\nside = \"right\"\nseverity = 3\n"
        );
        let stiffest = |text: &str| {
            let scenario = Scenario::parse(text, "test.toml", None).expect("valid");
            let scene = build(Arc::new(scenario), Use::default(), &mut |_, _| true);
            let scene = scene.expect("built");
            scene.stiffest_n_per_mm()
        };
        assert_eq!(stiffest(plain), 1.0);
        // 40 % less compliance where it is worst: 1 / 0.6.
        let k = stiffest(&hard);
        assert!(k > 1.6 && k <= 1.0 / 0.6 + 1e-9, "{k}");
    }
}
