//! The shapes a psychometric function may have between guessing and certainty.

use crate::training::detection::ForcedChoice;
use crate::training::normal::{density, quantile, share_below};

/// A shape by its name, without its parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Family {
    /// F = 1 − exp(−(x/α)^β): at α it is 0.632 (Weibull 1951; Quick 1974).
    #[default]
    Weibull,
    /// F = 1/(1 + (x/α)^−β): logistic over the logarithm of x; at α it is one half.
    Logistic,
    /// F = Φ(β ln(x/α)): normal over the logarithm of x; at α it is one half.
    CumulativeNormal,
    /// That of an observer who takes the strongest of m places whose d′ is (x/α)^β: at α it has d′ = 1
    /// ([`ForcedChoice`]).
    Detection,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Weibull,
        Self::Logistic,
        Self::CumulativeNormal,
        Self::Detection,
    ];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Weibull => "weibull",
            Self::Logistic => "logistic",
            Self::CumulativeNormal => "normal",
            Self::Detection => "detection",
        }
    }

    /// The one called `name`.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.name() == name)
    }
}

/// A family with what it needs to know of the task.
#[derive(Clone, Debug)]
pub struct Shape {
    family: Family,
    forced: Option<ForcedChoice>,
}

impl Shape {
    /// For a share `chance` of right answers by guessing.
    pub fn new(family: Family, chance: f64) -> Self {
        let alternatives = libm::round(1.0 / chance.clamp(1.0e-3, 0.5)) as u32;
        let forced = (family == Family::Detection).then(|| ForcedChoice::new(alternatives));
        Self { family, forced }
    }

    /// Which family.
    pub fn family(&self) -> Family {
        self.family
    }

    /// F at a strength whose natural logarithm is `ln_x`, 0 … 1; α by its logarithm.
    pub fn share(&self, ln_x: f64, ln_alpha: f64, beta: f64) -> f64 {
        let z = beta * (ln_x - ln_alpha);
        match (self.family, &self.forced) {
            (Family::Weibull, _) => -libm::expm1(-libm::exp(z)),
            (Family::Logistic, _) => 1.0 / (1.0 + libm::exp(-z)),
            (Family::CumulativeNormal, _) => share_below(z),
            (Family::Detection, Some(forced)) => {
                let chance = forced.chance();
                ((forced.share(libm::exp(z)) - chance) / (1.0 - chance)).max(0.0)
            }
            (Family::Detection, None) => 0.0,
        }
    }

    /// F and its slope over z = β (ln x − ln α).
    pub(super) fn share_and_slope(&self, z: f64) -> (f64, f64) {
        match (self.family, &self.forced) {
            (Family::Weibull, _) => {
                let e = libm::exp(z.min(40.0));
                let left = libm::exp(-e);
                (1.0 - left, e * left)
            }
            (Family::Logistic, _) => {
                let f = 1.0 / (1.0 + libm::exp(-z));
                (f, f * (1.0 - f))
            }
            (Family::CumulativeNormal, _) => (share_below(z), density(z)),
            (Family::Detection, Some(forced)) => {
                let (d, chance) = (libm::exp(z.min(40.0)), forced.chance());
                let [share, slope] = forced.share_and_slope(d);
                (
                    ((share - chance) / (1.0 - chance)).max(0.0),
                    d * slope / (1.0 - chance),
                )
            }
            (Family::Detection, None) => (0.0, 0.0),
        }
    }

    /// The logarithm of the strength at which F is `share`; the share is brought inside 0 … 1, and what is no number counts as one half.
    pub fn ln_x_at(&self, share: f64, ln_alpha: f64, beta: f64) -> f64 {
        let share = if share.is_nan() { 0.5 } else { share };
        let share = share.clamp(1.0e-9, 1.0 - 1.0e-9);
        let z = match (self.family, &self.forced) {
            (Family::Weibull, _) => libm::log(-libm::log1p(-share)),
            (Family::Logistic, _) => libm::log(share / (1.0 - share)),
            (Family::CumulativeNormal, _) => quantile(share),
            (Family::Detection, Some(forced)) => {
                let chance = forced.chance();
                libm::log(forced.d_prime(chance + share * (1.0 - chance)).max(1.0e-9))
            }
            (Family::Detection, None) => 0.0,
        };
        ln_alpha + z / beta
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_family_rises_from_nothing_to_all_and_is_turned_around() {
        for family in Family::ALL {
            assert_eq!(Family::by_name(family.name()), Some(family));
            let shape = Shape::new(family, 1.0 / 12.0);
            let (ln_alpha, beta) = (1.3, 2.1);
            let mut before = -1.0;
            for i in -60..=60 {
                let ln_x = f64::from(i) * 0.1;
                let share = shape.share(ln_x, ln_alpha, beta);
                assert!(
                    (0.0..=1.0).contains(&share) && share >= before - 1e-9,
                    "{family:?}"
                );
                if (0.001..0.999).contains(&share) {
                    let back = shape.ln_x_at(share, ln_alpha, beta);
                    assert!((back - ln_x).abs() < 1e-6, "{family:?} at {ln_x}: {back}");
                }
                before = share;
            }
            assert!(shape.share(f64::NEG_INFINITY, ln_alpha, beta) < 1e-12);
            assert!(before > 0.999);
        }
    }

    #[test]
    fn slopes_are_those_of_the_shares() {
        for family in Family::ALL {
            let shape = Shape::new(family, 1.0 / 12.0);
            for i in -40..40 {
                let (z, h) = (0.1 * f64::from(i) + 0.003, 1.0e-5);
                let (f, slope) = shape.share_and_slope(z);
                let around = |z| shape.share(z, 0.0, 1.0);
                assert!((f - around(z)).abs() < 1e-12, "{family:?}");
                let difference = (around(z + h) - around(z - h)) / (2.0 * h);
                assert!(
                    (slope - difference).abs() < 1e-6,
                    "{family:?} at {z}: {slope} {difference}"
                );
            }
        }
    }

    #[test]
    fn at_alpha_they_are_what_is_said_of_them() {
        let at_alpha = |family| Shape::new(family, 1.0 / 12.0).share(0.7, 0.7, 3.0);
        assert!((at_alpha(Family::Weibull) - 0.632_120_558_8).abs() < 1e-9);
        assert!((at_alpha(Family::Logistic) - 0.5).abs() < 1e-15);
        assert!((at_alpha(Family::CumulativeNormal) - 0.5).abs() < 1e-15);
        // METHOD, section 7: among 12 at d′ = 1, 0.3077 are right.
        let right = 1.0 / 12.0 + 11.0 / 12.0 * at_alpha(Family::Detection);
        assert!((right - 0.3077).abs() < 5e-5);
    }
}
