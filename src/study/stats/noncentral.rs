//! The noncentral t distribution, for intervals of standardised differences.

use crate::training::normal::share_below;

/// Share of the noncentral t distribution with `df` degrees of freedom and noncentrality `delta` below `t`.
///
/// T ≤ t where Z ≤ t S − δ with S = √(χ² ⁄ df): the mean of Φ(t S − δ) over the density of S, by Simpson's rule over ten
/// standard deviations of S.
pub fn noncentral_t_below(t: f64, df: f64, delta: f64) -> f64 {
    // The density of S is c s^(df − 1) exp(−df s² ⁄ 2), greatest near 1; its spread is about 1 ⁄ √(2 df).
    let spread = 1.0 / (2.0 * df).sqrt();
    let (from, to) = ((1.0 - 10.0 * spread).max(0.0), 1.0 + 10.0 * spread);
    const STEPS: usize = 400;
    let h = (to - from) / STEPS as f64;
    let constant = 0.5 * df * libm::log(0.5 * df) + std::f64::consts::LN_2 - libm::lgamma(0.5 * df);
    let density = |s: f64| {
        if s <= 0.0 {
            // Only with one degree of freedom anything is left at 0.
            return if df == 1.0 { libm::exp(constant) } else { 0.0 };
        }
        libm::exp(constant + (df - 1.0) * libm::log(s) - 0.5 * df * s * s)
    };
    let value = |i: usize| {
        let s = from + h * i as f64;
        let weight = match i {
            0 | STEPS => 1.0,
            even if even.is_multiple_of(2) => 2.0,
            _ => 4.0,
        };
        weight * density(s) * share_below(t * s - delta)
    };
    ((0..=STEPS).map(value).sum::<f64>() * h / 3.0).clamp(0.0, 1.0)
}

/// The noncentralities under which a `t` as large, and as small, has a chance of 2.5 %: ends of the 95 % interval. `None`
/// where `t` is not finite or there is no degree of freedom.
pub fn noncentrality_interval(t: f64, df: f64) -> Option<[f64; 2]> {
    if !t.is_finite() || !df.is_finite() || df < 1.0 || t.abs() > 1.0e6 {
        return None;
    }
    let solve = |share: f64| {
        // The share below t falls as the noncentrality grows.
        let reach = 10.0 + 10.0 * t.abs();
        let (mut low, mut high) = (t - reach, t + reach);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if noncentral_t_below(t, df, middle) > share {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    };
    Some([solve(0.975), solve(0.025)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ContinuousCDF, StudentsT};

    #[test]
    fn without_noncentrality_it_is_students() {
        for df in [1.0, 2.0, 5.0, 30.0, 400.0] {
            let central = StudentsT::new(0.0, 1.0, df).expect("t");
            for t in [-4.0, -1.0, 0.0, 0.3, 2.0, 6.0] {
                let (got, wanted) = (noncentral_t_below(t, df, 0.0), central.cdf(t));
                assert!((got - wanted).abs() < 1e-6, "{df} {t}: {got} {wanted}");
            }
        }
    }

    #[test]
    fn shares_are_those_of_a_simulation() {
        let mut random = crate::training::random::Random::new(5);
        let mut normal = || crate::training::normal::quantile(random.unit());
        for (t, df, delta) in [(2.0, 6_usize, 1.0), (0.5, 10, 1.5), (4.0, 4, 3.0)] {
            let n = 60_000;
            let below = (0..n)
                .filter(|_| {
                    let chi: f64 = (0..df).map(|_| normal()).map(|z| z * z).sum();
                    (normal() + delta) / (chi / df as f64).sqrt() <= t
                })
                .count();
            let got = noncentral_t_below(t, df as f64, delta);
            // Four standard errors of the count.
            assert!(
                (got - below as f64 / f64::from(n)).abs() < 4.0 * 0.5 / 60_000_f64.sqrt(),
                "{t} {df} {delta}: {got}"
            );
        }
    }
}
