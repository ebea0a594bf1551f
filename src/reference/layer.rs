//! An elastic layer of even thickness bonded to rigid bone, under Gaussian pressure (Sneddon 1951, Fourier Transforms,
//! ch. 10; Johnson 1985, 5.8).

use super::material::Elastic;
use super::{Dent, depth, size_mm};
use std::f64::consts::PI;

/// u(r) = (2/E*) ∫ P(k) G(kh) J₀(kr) dk with P = F/(2π) e^(−k² s²/2),
/// G = [2κ sinh 2w − 4w] / [2κ cosh 2w + 1 + κ² + 4w²], κ = 3 − 4ν, w = kh.
///
/// Tabulated when made; between the entries a cubic through four of them (error below 1e-7 of the depth).
#[derive(Clone, Debug)]
pub struct Bonded {
    stiffness_n_per_mm: f64,
    step_mm: f64,
    shares: Vec<f64>,
}

/// Gauss–Legendre, 8 points: places and weights on −1 … 1 (Abramowitz and Stegun 1964, table 25.4).
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

impl Bonded {
    /// A layer `thickness_mm` thick of `material` under pressure with standard deviation `deviation_mm`, both 1 to 100 mm. What
    /// lies outside is brought within.
    pub fn new(material: Elastic, deviation_mm: f64, thickness_mm: f64) -> Self {
        let (s, h) = (size_mm(deviation_mm), size_mm(thickness_mm));
        // Beyond ten thicknesses, and beyond the load, a layer is at rest.
        let reach_mm = 12.0 * h.max(s);
        let step_mm = 0.02 * h.min(s * 2.0);
        let n = (reach_mm / step_mm).min(20_000.0) as usize;
        let step_mm = reach_mm / n as f64;
        let waves = Waves::new(material, s, h, reach_mm);
        let middle = waves.at(0.0);
        let shares = (0..=n + 2)
            .map(|i| waves.at(i as f64 * step_mm) / middle)
            .collect();
        Self {
            stiffness_n_per_mm: material.plane_strain_n_per_mm2() * PI / middle,
            step_mm,
            shares,
        }
    }
}

impl Dent for Bonded {
    fn name(&self) -> &'static str {
        "layer"
    }

    fn at_mm(&self, depth_mm: f64, r_mm: f64) -> f64 {
        let place = r_mm.abs() / self.step_mm;
        let i = place as usize;
        let n = self.shares.len();
        match depth(depth_mm) {
            Some(d) if place < (n - 2) as f64 => {
                let t = place - i as f64;
                // Even in r: the entry before the first is the second.
                let before = self.shares[i.abs_diff(1).min(n - 1)];
                let before = if i == 0 { self.shares[1] } else { before };
                let [a, b, c] = [i, i + 1, i + 2].map(|j| self.shares[j]);
                d * cubic([before, a, b, c], t)
            }
            _ => 0.0,
        }
    }

    fn force_n(&self, depth_mm: f64) -> f64 {
        depth(depth_mm).map_or(0.0, |d| d * self.stiffness_n_per_mm)
    }
}

/// The cubic through values at −1, 0, 1, 2 (Lagrange) at `t` in 0 … 1.
fn cubic([a, b, c, d]: [f64; 4], t: f64) -> f64 {
    let (u, v, w) = (t + 1.0, t - 1.0, t - 2.0);
    -a * t * v * w / 6.0 + b * u * v * w / 2.0 - c * u * t * w / 2.0 + d * u * t * v / 6.0
}

/// ∫ e^(−k² s²/2) G(kh) J₀(kr) dk as a sum over fixed wave numbers.
struct Waves(Vec<(f64, f64)>);

impl Waves {
    fn new(material: Elastic, s: f64, h: f64, reach_mm: f64) -> Self {
        let kappa = 3.0 - 4.0 * material.nu();
        // e^(−k² s²/2) is below 1e-17 from here on.
        let end = 9.0 / s;
        // At the farthest place a panel holds about a third of a wave.
        let panels = (end * reach_mm / 2.0).ceil().max(64.0) as usize;
        let half = 0.5 * end / panels as f64;
        let mut waves = Vec::with_capacity(8 * panels);
        for p in 0..panels {
            let middle = (2 * p + 1) as f64 * half;
            for (place, weight) in GAUSS {
                for k in [middle - place * half, middle + place * half] {
                    let g = green(k * h, kappa);
                    waves.push((k, weight * half * libm::exp(-0.5 * k * k * s * s) * g));
                }
            }
        }
        Self(waves)
    }

    fn at(&self, r_mm: f64) -> f64 {
        self.0.iter().map(|(k, w)| w * libm::j0(k * r_mm)).sum()
    }
}

/// G, numerator and denominator divided by e^(2w) so that neither overflows.
fn green(w: f64, kappa: f64) -> f64 {
    let fall = libm::exp(-2.0 * w);
    let above = -kappa * libm::expm1(-4.0 * w) - 4.0 * w * fall;
    let below = kappa * (1.0 + fall * fall) + (1.0 + kappa * kappa + 4.0 * w * w) * fall;
    above / below
}

#[cfg(test)]
mod tests {
    use super::super::half_space::Gaussian;
    use super::*;

    #[test]
    fn three_thicknesses_make_the_known_dents() {
        for (h, depth_mm, stiffness) in [
            (10.0, 6.473, 0.463),
            (20.0, 8.506, 0.353),
            (40.0, 9.680, 0.310),
        ] {
            let layer = Bonded::new(Elastic::MUSCLE, 3.5, h);
            let here = 3.0 / layer.force_n(1.0);
            assert!((here - depth_mm).abs() < 0.5e-3, "h {h}: {here}");
            assert!((layer.force_n(1.0) - stiffness).abs() < 0.5e-3, "h {h}");
        }
    }

    /// Past the last number that counts entries it panicked.
    #[test]
    fn beyond_its_table_a_layer_is_at_rest() {
        let layer = Bonded::new(Elastic::MUSCLE, 3.5, 5.0);
        for r_mm in [61.0, 1e18, 1e300, f64::MAX, f64::INFINITY, f64::NAN] {
            assert_eq!(layer.at_mm(1.0, r_mm), 0.0, "{r_mm}");
            assert_eq!(layer.at_mm(1.0, -r_mm), 0.0, "{r_mm}");
        }
    }

    /// What the bone takes away goes with 1/h.
    #[test]
    fn thicker_and_thicker_layers_become_a_half_space() {
        let settles = |dent: &dyn Dent| 1.0 / dent.force_n(1.0);
        let body = settles(&Gaussian::new(Elastic::MUSCLE, 3.5));
        let [thin, thick] = [50.0, 100.0].map(|h| settles(&Bonded::new(Elastic::MUSCLE, 3.5, h)));
        let ratio = (body - thin) / (body - thick);
        assert!((ratio - 2.0).abs() < 0.01, "{ratio}");
    }

    #[test]
    fn entries_and_what_lies_between_agree_with_the_integral() {
        let (s, h) = (3.5, 20.0);
        let layer = Bonded::new(Elastic::MUSCLE, s, h);
        let waves = Waves::new(Elastic::MUSCLE, s, h, 12.0 * h);
        for i in 0..400 {
            let r = 0.173 * f64::from(i);
            let exact = waves.at(r) / waves.at(0.0);
            assert!((layer.at_mm(1.0, r) - exact).abs() < 1e-7, "r {r}");
        }
    }

    /// A nearly incompressible layer keeps its volume: what goes down in the middle comes up around it.
    #[test]
    fn a_nearly_incompressible_layer_bulges_round_the_dent() {
        let layer = |nu| Bonded::new(Elastic::new(25.0, nu).unwrap(), 3.5, 20.0);
        let lowest = |l: &Bonded| {
            (0..240)
                .map(|i| l.at_mm(1.0, f64::from(i)))
                .fold(f64::INFINITY, f64::min)
        };
        let (soft, hard) = (lowest(&layer(0.3)), lowest(&layer(0.499)));
        assert!(
            soft > -0.01 && hard < -0.01 && hard > -0.05,
            "{soft} {hard}"
        );
    }
}
