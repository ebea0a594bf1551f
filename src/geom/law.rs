//! Falloffs M(q) as functions, by name (Ji 2008, 4.1, 4.2 and table 4.2): value, slope and curvature.
//!
//! A law falls from M(0) = 1 at the centre of a dent to its rim at q = 1. Arrays of it are made by
//! [`Curve`](super::curve::Curve).

use std::f64::consts::PI;

/// The variable x of the published half Gaussian at the rim: x = 1.4 q (Ji 2008, 4.2.1).
pub const PUBLISHED_WIDTH: f64 = 1.4;
/// What makes the logarithm as steep as one counted in steps of the published array, ln(i + 1) with i = 0 … 699.
const LOGARITHMIC_STEPS: f64 = 699.0;

/// A falloff from the centre of a dent to its rim.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Law {
    /// The published half Gaussian, lowered by its value at the rim and rescaled, so that it ends at exactly 0:
    /// (g(q) − g(1)) / (1 − g(1)).
    #[default]
    Gaussian,
    /// The half Gaussian as printed, g(q) = exp(−π (1.4 q)²), as σ² = 1/(2π) (eq. 4.1). It ends at 0.0021.
    GaussianPrinted,
    /// Half a period of the cosine, (1 + cos π q) / 2.
    Cosine,
    /// 1 − ln(1 + 699 q) / ln 700.
    Logarithmic,
    /// The half Gaussian without the part between its inflection points (Fig. 4.4): from x = σ to 1.4, stretched over the
    /// whole of q, lowered and rescaled. For a sharp object: steepest at its tip.
    GaussianSharp,
}

/// Slope dM/dq and second derivative d²M/dq² of a falloff at its ends.
///
/// At the rim they are those from inside; outside a falloff is 0 throughout.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ends {
    /// Slope at the centre.
    pub slope_centre: f64,
    /// Slope at the rim.
    pub slope_rim: f64,
    /// Second derivative at the centre.
    pub curvature_centre: f64,
    /// Second derivative at the rim.
    pub curvature_rim: f64,
}

impl Law {
    /// Every law.
    pub fn all() -> &'static [Self] {
        &[
            Self::Gaussian,
            Self::GaussianPrinted,
            Self::Cosine,
            Self::Logarithmic,
            Self::GaussianSharp,
        ]
    }

    /// Name in files, tables and the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gaussian => "gaussian",
            Self::GaussianPrinted => "gaussian-printed",
            Self::Cosine => "cosine",
            Self::Logarithmic => "logarithmic",
            Self::GaussianSharp => "gaussian-sharp",
        }
    }

    /// What it is, in a line for people.
    pub fn about(self) -> &'static str {
        match self {
            Self::Gaussian => "half Gaussian that ends at exactly 0",
            Self::GaussianPrinted => "half Gaussian as printed, 0.0021 at the rim",
            Self::Cosine => "half a period of the cosine",
            Self::Logarithmic => "logarithm: a needle at the centre, a slow rim",
            Self::GaussianSharp => {
                "Gaussian without the part between its inflection points: a sharp tip"
            }
        }
    }

    /// The law called `name`.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().iter().copied().find(|l| l.name() == name)
    }

    /// M at `q`; what lies outside 0 … 1 counts as the nearer end, what is no number as 0.
    pub fn at(self, q: f64) -> f64 {
        let [value, _, _] = self.derivatives(q);
        value
    }

    /// dM/dq at `q`, limited as in [`Law::at`].
    pub fn slope(self, q: f64) -> f64 {
        let [_, slope, _] = self.derivatives(q);
        slope
    }

    /// d²M/dq² at `q`, limited as in [`Law::at`].
    pub fn curvature(self, q: f64) -> f64 {
        let [_, _, curvature] = self.derivatives(q);
        curvature
    }

    /// Slope and curvature at both ends.
    pub fn ends(self) -> Ends {
        let [_, slope_centre, curvature_centre] = self.derivatives(0.0);
        let [_, slope_rim, curvature_rim] = self.derivatives(1.0);
        Ends {
            slope_centre,
            slope_rim,
            curvature_centre,
            curvature_rim,
        }
    }

    #[inline]
    fn derivatives(self, q: f64) -> [f64; 3] {
        let q = if q > 0.0 { q.min(1.0) } else { 0.0 };
        match self {
            Self::Gaussian => rescaled(|q| half_gaussian(0.0, q), q),
            Self::GaussianPrinted => half_gaussian(0.0, q),
            Self::Cosine => {
                let (sin, cos) = libm::sincos(PI * q);
                [0.5 * (1.0 + cos), -0.5 * PI * sin, -0.5 * PI * PI * cos]
            }
            Self::Logarithmic => {
                let whole = libm::log(1.0 + LOGARITHMIC_STEPS);
                let part = 1.0 + LOGARITHMIC_STEPS * q;
                let rate = LOGARITHMIC_STEPS / part;
                [
                    1.0 - libm::log(part) / whole,
                    -rate / whole,
                    rate * rate / whole,
                ]
            }
            Self::GaussianSharp => {
                let sigma = 1.0 / (2.0 * PI).sqrt();
                rescaled(|q| half_gaussian(sigma, q), q)
            }
        }
    }
}

/// exp(−π x²) with x from `first` at q = 0 to 1.4 at q = 1, and its derivatives with respect to q.
fn half_gaussian(first: f64, q: f64) -> [f64; 3] {
    let width = PUBLISHED_WIDTH - first;
    let x = first + width * q;
    let g = libm::exp(-PI * x * x);
    let rate = -2.0 * PI * x * width;
    [g, rate * g, (rate * rate - 2.0 * PI * width * width) * g]
}

/// A falloff brought to 1 at the centre and 0 at the rim.
fn rescaled(falloff: impl Fn(f64) -> [f64; 3], q: f64) -> [f64; 3] {
    let ([top, ..], [rim, ..]) = (falloff(0.0), falloff(1.0));
    let [value, slope, curvature] = falloff(q);
    [
        (value - rim) / (top - rim),
        slope / (top - rim),
        curvature / (top - rim),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_law_falls_from_exactly_one_to_its_rim() {
        for &law in Law::all() {
            assert_eq!(Law::named(law.name()), Some(law));
            assert_eq!(law.at(0.0), 1.0, "{law:?}");
            let rim = law.at(1.0);
            if law == Law::GaussianPrinted {
                assert!((rim - 0.0021).abs() < 0.5e-4, "{rim}");
            } else {
                assert_eq!(rim, 0.0, "{law:?}");
            }
            let values: Vec<f64> = (0..=2000).map(|i| law.at(f64::from(i) / 2000.0)).collect();
            assert!(values.windows(2).all(|w| w[1] < w[0]), "{law:?}");
            assert_eq!(
                (law.at(-1.0), law.at(9.0), law.at(f64::NAN)),
                (1.0, rim, 1.0)
            );
        }
        assert_eq!(Law::named("parabola"), None);
    }

    #[test]
    fn slope_and_curvature_are_the_derivatives() {
        for &law in Law::all() {
            for i in 1..100 {
                let (q, e) = (f64::from(i) / 100.0, 1e-6);
                let slope = (law.at(q + e) - law.at(q - e)) / (2.0 * e);
                let curvature = (law.slope(q + e) - law.slope(q - e)) / (2.0 * e);
                assert!(
                    (law.slope(q) - slope).abs() < 1e-6 * (1.0 + slope.abs()),
                    "{law:?} {q}"
                );
                assert!(
                    (law.curvature(q) - curvature).abs() < 1e-5 * (1.0 + curvature.abs()),
                    "{law:?} {q}"
                );
            }
        }
    }

    /// Table 4.2 prints the slopes 0, 0 for the half Gaussian, 0, 0 for half a period of the cosine, +∞, 0 for the logarithm.
    #[test]
    fn table_4_2_holds_for_the_cosine_and_nearly_for_the_others() {
        let cosine = Law::Cosine.ends();
        assert_eq!(cosine.slope_centre, 0.0);
        assert!(cosine.slope_rim.abs() < 1e-15);
        // The printed Gaussian leaves the rim at −0.0186 per unit of x = 1.4 q, not at 0, and from 0.0021.
        let printed = Law::GaussianPrinted.ends();
        assert_eq!(printed.slope_centre, 0.0);
        assert!((printed.slope_rim / PUBLISHED_WIDTH + 0.0186).abs() < 0.5e-4);
        // A logarithm over a finite range that is 1 at the centre has neither an infinite slope there nor none at the rim.
        let logarithm = Law::Logarithmic.ends();
        assert!((logarithm.slope_centre + 699.0 / 700.0_f64.ln()).abs() < 1e-9);
        assert!((logarithm.slope_rim + 699.0 / 700.0 / 700.0_f64.ln()).abs() < 1e-12);
    }

    #[test]
    fn the_sharp_gaussian_is_steepest_at_its_tip_where_it_turns() {
        let ends = Law::GaussianSharp.ends();
        assert!(
            ends.curvature_centre.abs() < 1e-12,
            "{}",
            ends.curvature_centre
        );
        for i in 1..=100 {
            assert!(Law::GaussianSharp.slope(f64::from(i) / 100.0) > ends.slope_centre);
        }
    }
}
