//! Yardsticks for the drawn deformation: what elasticity says the skin does under a known load.
//!
//! Closed forms of a linear elastic body, exact up to quadrature, each in its own file; every one answers how deep the
//! surface lies at a distance from the middle of the load, and which force that takes. [`all`] lists them with the
//! material and sizes of a finger on a back. Bodies without a closed form are cut into bricks or springs. [`models::models`]
//! lists all of them as models of the drawn skin.
//!
//! | file | holds |
//! |---|---|
//! | [`material`] | Young's modulus, Poisson's ratio and what follows from them |
//! | [`half_space`] | a body without end: Gaussian pressure, uniform disc, rigid sphere (Hertz) |
//! | [`layer`] | a layer of tissue bonded to bone |
//! | [`membrane`] | a tensed skin on a bed of springs (Winkler) |
//! | [`traction`] | a body without end dragged along its surface (Cerruti) |
//! | [`fem`] | finite elements: a slab of tissue over bone, also condensed to its skin, also for large strains |
//! | [`springs`] | the same slab as mass and springs, and position-based |
//! | [`patch`] | the slab under a place on the skin |
//! | [`continuum`], [`slab`] | closed forms and slabs as models of the drawn skin |
//! | [`models`] | all of these by name |

mod bessel;
pub mod continuum;
pub mod fem;
pub mod half_space;
pub mod layer;
pub mod material;
pub mod membrane;
pub mod models;
pub mod patch;
mod plane;
pub mod slab;
pub mod springs;
pub mod traction;

pub use material::{Elastic, MaterialError};
pub use plane::Plane;

/// A dent with rotational symmetry, driven by its depth in the middle.
pub trait Dent: Send + Sync {
    /// Name in files, tables and the command line.
    fn name(&self) -> &'static str;

    /// How far the surface has moved into the body at `r_mm` from the middle of a dent `depth_mm` deep, mm.
    ///
    /// At r = 0 that is `depth_mm`. A depth that is not positive, or anything that is no number, gives 0.
    fn at_mm(&self, depth_mm: f64, r_mm: f64) -> f64;

    /// The force that makes a dent `depth_mm` deep, N; 0 for a depth that is not positive.
    fn force_n(&self, depth_mm: f64) -> f64;
}

/// A yardstick's name and how it is made for a fingertip on a back: E = 25 kPa, ν = 0.45 (erector spinae, METHOD 6 and 7).
pub type Named = (&'static str, fn() -> Box<dyn Dent>);

/// Every dent, by name.
pub fn all() -> &'static [Named] {
    &[
        ("half-space-gaussian", || {
            Box::new(half_space::Gaussian::new(Elastic::MUSCLE, 3.5))
        }),
        ("half-space-disc", || {
            Box::new(half_space::Disc::new(Elastic::MUSCLE, 7.0))
        }),
        ("half-space-sphere", || {
            Box::new(half_space::Sphere::new(Elastic::MUSCLE, 8.0))
        }),
        ("layer", || {
            Box::new(layer::Bonded::new(Elastic::MUSCLE, 3.5, 20.0))
        }),
        ("membrane", || {
            Box::new(membrane::Tensed::new(5.0, 7.0, 0.002))
        }),
    ]
}

/// A length of load or tissue, brought within 1 to 100 mm, the sizes of fingers and of what lies under them; what is no
/// number counts as 1 mm. So no body is empty, and none takes minutes to tabulate.
fn size_mm(length_mm: f64) -> f64 {
    if length_mm >= 1.0 {
        length_mm.min(100.0)
    } else {
        1.0
    }
}

/// `depth_mm` where it is a depth.
fn depth(depth_mm: f64) -> Option<f64> {
    (depth_mm > 0.0 && depth_mm.is_finite()).then_some(depth_mm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_dent_is_as_deep_in_its_middle_as_it_is_told_and_falls_outward() {
        for (name, make) in all() {
            let dent = make();
            assert_eq!(dent.name(), *name);
            for depth_mm in [0.01, 2.0, 10.0] {
                let middle = dent.at_mm(depth_mm, 0.0);
                assert!((middle / depth_mm - 1.0).abs() < 1e-9, "{name}: {middle}");
                // The bonded layer bulges a little: it falls to below 0 and comes back.
                let far = dent.at_mm(depth_mm, 150.0).abs();
                assert!(far < 0.06 * depth_mm, "{name}: {far} of {depth_mm}");
                let profile: Vec<f64> = (0..60)
                    .map(|i| dent.at_mm(depth_mm, f64::from(i) * 0.25))
                    .collect();
                assert!(profile.windows(2).all(|w| w[1] < w[0] + 1e-12), "{name}");
                assert!(dent.force_n(depth_mm) > 0.0);
                assert!(dent.force_n(depth_mm) < dent.force_n(depth_mm * 1.1));
            }
        }
    }

    #[test]
    fn a_body_of_no_size_or_no_number_is_still_a_body() {
        for size_mm in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let dents: [Box<dyn Dent>; 5] = [
                Box::new(half_space::Gaussian::new(Elastic::MUSCLE, size_mm)),
                Box::new(half_space::Disc::new(Elastic::MUSCLE, size_mm)),
                Box::new(half_space::Sphere::new(Elastic::MUSCLE, size_mm)),
                Box::new(layer::Bonded::new(Elastic::MUSCLE, 5.0, size_mm.min(10.0))),
                Box::new(membrane::Tensed::new(size_mm, size_mm, size_mm)),
            ];
            for dent in dents {
                let (here, force_n) = (dent.at_mm(2.0, 3.0), dent.force_n(2.0));
                assert!(here.is_finite() && here.abs() <= 2.0, "{}", dent.name());
                assert!(force_n.is_finite() && force_n > 0.0, "{}", dent.name());
            }
        }
    }

    #[test]
    fn what_is_no_depth_or_no_place_moves_nothing() {
        for (name, make) in all() {
            let dent = make();
            for depth_mm in [0.0, -1.0, f64::NAN, f64::INFINITY] {
                assert_eq!(dent.at_mm(depth_mm, 1.0), 0.0, "{name}");
                assert_eq!(dent.force_n(depth_mm), 0.0, "{name}");
            }
            for r_mm in [f64::NAN, f64::INFINITY] {
                assert_eq!(dent.at_mm(1.0, r_mm), 0.0, "{name}");
            }
            assert_eq!(dent.at_mm(1.0, -3.0), dent.at_mm(1.0, 3.0), "{name}");
        }
    }
}
