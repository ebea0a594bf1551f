//! A tensed skin on a bed of springs: T ∇²w − k_w w = −p (Winkler 1867; Timoshenko and Woinowsky-Krieger 1959, ch. 8).

use super::bessel::{i01_scaled, k01};
use super::{Dent, depth, size_mm};
use std::f64::consts::PI;

/// Uniform pressure on a disc of radius a. With λ = √(T/k_w): inside w = (p/k_w) [1 − (a/λ) K₁(a/λ) I₀(r/λ)], outside
/// (p/k_w) (a/λ) I₁(a/λ) K₀(r/λ).
#[derive(Clone, Copy, Debug)]
pub struct Tensed {
    length_mm: f64,
    radius_mm: f64,
    bed_n_per_mm3: f64,
}

impl Tensed {
    /// A skin with λ = `length_mm` under a disc of radius `radius_mm`, both 1 to 100 mm, on a bed of `bed_n_per_mm3`, pressure
    /// per depth, 1e-6 to 1. What lies outside is brought within.
    pub fn new(length_mm: f64, radius_mm: f64, bed_n_per_mm3: f64) -> Self {
        Self {
            length_mm: size_mm(length_mm),
            radius_mm: size_mm(radius_mm),
            bed_n_per_mm3: if bed_n_per_mm3 >= 1.0e-6 {
                bed_n_per_mm3.min(1.0)
            } else {
                1.0e-6
            },
        }
    }

    /// w k_w / p at a distance.
    fn share(&self, r_mm: f64) -> f64 {
        let (a, r) = (self.radius_mm / self.length_mm, r_mm.abs() / self.length_mm);
        if r <= a {
            1.0 - a * k01(a)[1] * i01_scaled(r)[0] * libm::exp(r)
        } else {
            a * i01_scaled(a)[1] * libm::exp(a) * k01(r)[0]
        }
    }
}

impl Dent for Tensed {
    fn name(&self) -> &'static str {
        "membrane"
    }

    fn at_mm(&self, depth_mm: f64, r_mm: f64) -> f64 {
        match depth(depth_mm) {
            Some(d) if r_mm.is_finite() => d * self.share(r_mm) / self.share(0.0),
            _ => 0.0,
        }
    }

    fn force_n(&self, depth_mm: f64) -> f64 {
        let area_mm2 = PI * self.radius_mm * self.radius_mm;
        depth(depth_mm).map_or(0.0, |d| d / self.share(0.0) * self.bed_n_per_mm3 * area_mm2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_is_the_known_one() {
        let w = Tensed::new(5.0, 7.0, 0.002).share(0.0);
        assert!((w - 0.5508).abs() < 0.5e-4, "{w}");
    }

    #[test]
    fn the_bed_carries_the_whole_force() {
        let skin = Tensed::new(5.0, 7.0, 0.002);
        // ∫ k_w w dA by the midpoint rule; beyond 30 λ nothing is left.
        let n = 30_000;
        let step = 150.0 / f64::from(n);
        let carried: f64 = (0..n)
            .map(|i| (f64::from(i) + 0.5) * step)
            .map(|r| 0.002 * skin.at_mm(3.0, r) * 2.0 * PI * r * step)
            .sum();
        let force_n = skin.force_n(3.0);
        assert!(
            (carried / force_n - 1.0).abs() < 1e-6,
            "{carried} of {force_n}"
        );
    }

    #[test]
    fn both_formulas_meet_at_the_rim_with_one_slope() {
        let skin = Tensed::new(5.0, 7.0, 0.002);
        let [inner, rim, outer] = [7.0 - 1e-4, 7.0, 7.0 + 1e-4].map(|r| skin.share(r));
        assert!(((rim - inner) - (outer - rim)).abs() < 1e-8);
    }
}
