//! Skin rendered softer than it is, for a device that cannot bear it.
//!
//! What is bounded is the slope of force over depth: of the force model at the stiffness of the skin where the finger is,
//! the steepest from the surface down to the depth felt, at rest ([`ForceModel::steepest_n_per_mm`]). With the linear model
//! that is the skin's stiffness k by itself, so that a clamp at k_max gives F = min(k, k_max) d.
//!
//! The force of a contact is multiplied as a whole, along the skin as well as out of it: where slip begins, and how the
//! force stands to the normal, is as before. So friction's own stiffness k/f_adj keeps its ratio to the one that is bounded;
//! on tight skin, f_adj 0.7, it may be 1.4 times the bound. The damping of a model that has one is multiplied too.
//! Where a press meets the bound the force goes on without a jump, and rises on with depth.
//!
//! Neither the proxy nor what the record says of the contact is changed by it; the force sent is, and the record's flag
//! says when. The drawn skin sinks as far as the finger does.

use crate::contact::{Contact, ForceModel, Touch};

/// How stiff the skin may be rendered. Part of the session's header, so that a replay does the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StiffnessBound {
    /// As stiff as the scene has it.
    #[default]
    AsIs,
    /// All of it softer in proportion: differences along the skin stay what they are in per cent.
    Scale {
        /// What every force of contact is multiplied by, 0 … 1; what is not counts as the nearest that is, NaN as 1.
        factor: f64,
    },
    /// Nowhere stiffer than this; softer places stay as they are.
    Clamp {
        /// Steepest slope of force over depth, N/mm, above 0; what is not counts as no bound.
        n_per_mm: f64,
    },
}

impl StiffnessBound {
    /// Scales a scene whose stiffest place has `stiffest` N/mm to what is `stable`, N/mm. One that is stable stays as it is.
    pub fn scaled(stiffest: f64, stable: f64) -> Self {
        if stable > 0.0 && stiffest > stable && stiffest.is_finite() {
            Self::Scale {
                factor: stable / stiffest,
            }
        } else {
            Self::AsIs
        }
    }

    /// Clamps at what is `stable`, N/mm. Where nothing bounds that, neither does this.
    pub fn clamped(stable: f64) -> Self {
        if stable > 0.0 && stable.is_finite() {
            Self::Clamp { n_per_mm: stable }
        } else {
            Self::AsIs
        }
    }

    /// What the force of this contact is multiplied by, 0 … 1.
    pub fn factor(&self, model: &ForceModel, contact: &Contact) -> f64 {
        match *self {
            Self::AsIs => 1.0,
            _ if contact.touch == Touch::Free => 1.0,
            Self::Scale { factor } if factor.is_nan() => 1.0,
            Self::Scale { factor } => factor.clamp(0.0, 1.0),
            Self::Clamp { n_per_mm } => {
                let steepest =
                    model.steepest_n_per_mm(contact.stiffness_n_per_mm, contact.felt_depth_mm);
                if n_per_mm > 0.0 && steepest > n_per_mm {
                    n_per_mm / steepest
                } else {
                    1.0
                }
            }
        }
    }

    /// The contact as it is rendered: its force and its stiffness times the factor, and whether that is not 1.
    pub(super) fn rendered(&self, model: &ForceModel, contact: &Contact) -> (Contact, bool) {
        let factor = self.factor(model, contact);
        if factor == 1.0 {
            return (*contact, false);
        }
        let rendered = Contact {
            force_n: contact.force_n * factor,
            stiffness_n_per_mm: contact.stiffness_n_per_mm * factor,
            ..*contact
        };
        (rendered, true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Vec3;
    use proptest::prelude::*;

    fn pressed(k: f64, depth_mm: f64, model: &ForceModel) -> Contact {
        let force = model.force_n(k, depth_mm, 0.0);
        Contact {
            touch: Touch::Stick,
            normal: Vec3::Z,
            depth_mm,
            felt_depth_mm: depth_mm,
            stiffness_n_per_mm: k,
            // Friction along x, at four tenths.
            force_n: Vec3::new(0.4, 0.0, 1.0) * force,
            ..Contact::default()
        }
    }

    fn rendered_n(bound: StiffnessBound, k: f64, depth_mm: f64, model: &ForceModel) -> f64 {
        let contact = pressed(k, depth_mm, model);
        bound.rendered(model, &contact).0.force_n.z
    }

    #[test]
    fn a_linear_skin_is_clamped_to_the_lower_stiffness_and_scaled_by_the_factor() {
        let model = ForceModel::Linear;
        for (k, d) in [(0.3, 2.0), (0.8, 5.0), (2.5, 0.1), (9.0, 12.0)] {
            let clamped = rendered_n(StiffnessBound::clamped(0.8), k, d, &model);
            let closed = k.min(0.8) * d;
            assert!((clamped - closed).abs() <= 1e-12 * closed, "{k} {d}");
            let scaled = rendered_n(StiffnessBound::scaled(2.0, 0.5), k, d, &model);
            assert!((scaled - 0.25 * k * d).abs() <= 1e-12 * closed, "{k} {d}");
        }
    }

    #[test]
    fn friction_keeps_its_ratio() {
        let contact = pressed(4.0, 3.0, &ForceModel::Linear);
        let (soft, acted) = StiffnessBound::clamped(1.0).rendered(&ForceModel::Linear, &contact);
        assert!(acted && (soft.force_n.x / soft.force_n.z - 0.4).abs() < 1e-15);
        assert_eq!(soft.depth_mm, contact.depth_mm);
    }

    #[test]
    fn what_is_stable_stays_bit_for_bit() {
        let contact = pressed(0.7, 3.0, &ForceModel::Linear);
        for bound in [
            StiffnessBound::AsIs,
            StiffnessBound::scaled(0.7, 0.7),
            StiffnessBound::scaled(0.7, f64::INFINITY),
            StiffnessBound::clamped(0.7),
            StiffnessBound::clamped(f64::INFINITY),
            StiffnessBound::Scale { factor: 1.0 },
            StiffnessBound::Scale { factor: f64::NAN },
            StiffnessBound::Clamp { n_per_mm: f64::NAN },
            StiffnessBound::Clamp { n_per_mm: 0.0 },
        ] {
            let same = bound.rendered(&ForceModel::Linear, &contact);
            assert_eq!(same, (contact, false), "{bound:?}");
        }
    }

    /// The slope by differences, along whole presses of every model, deep and shallow.
    #[test]
    fn no_model_is_steeper_than_the_clamp_and_each_rises_without_a_jump() {
        let (bound, step) = (0.9, 1.0e-3);
        for model in ForceModel::all() {
            for k in [0.2, 0.9, 3.0] {
                let at = |d| rendered_n(StiffnessBound::clamped(bound), k, d, model);
                let mut before = at(0.0);
                assert_eq!(before, 0.0);
                for i in 1..20_000 {
                    let now = at(f64::from(i) * step);
                    let slope = (now - before) / step;
                    assert!(slope <= bound * (1.0 + 1e-6), "{model} {k} at {i}: {slope}");
                    assert!(slope >= -1e-9, "{model} {k} at {i}: {slope}");
                    before = now;
                }
            }
        }
    }

    proptest! {
        #[test]
        fn whatever_comes_the_factor_is_a_share(
            k in prop::num::f64::ANY, d in prop::num::f64::ANY, bound in prop::num::f64::ANY, model in 0..4_usize,
        ) {
            let contact = Contact { touch: Touch::Slip, stiffness_n_per_mm: k, felt_depth_mm: d, ..Contact::default() };
            let model = &ForceModel::all()[model];
            for bound in [
                StiffnessBound::Scale { factor: bound },
                StiffnessBound::Clamp { n_per_mm: bound },
                StiffnessBound::clamped(bound),
                StiffnessBound::scaled(k, bound),
            ] {
                prop_assert!((0.0..=1.0).contains(&bound.factor(model, &contact)));
            }
        }
    }
}
