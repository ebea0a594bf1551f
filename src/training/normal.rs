//! The normal distribution.

/// Density of the standard normal distribution.
pub fn density(z: f64) -> f64 {
    const ONE_OVER_ROOT_TWO_PI: f64 = 0.398_942_280_401_432_7;
    ONE_OVER_ROOT_TWO_PI * libm::exp(-0.5 * z * z)
}

/// Share of the standard normal distribution below `z`.
pub fn share_below(z: f64) -> f64 {
    0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2)
}

/// The `z` below which lies the share `p`; p is brought to 1e-15 … 1 − 1e-15, and what is no number counts as one half.
///
/// By Newton's method inside a bracket, to the last digits that [`share_below`] has.
pub fn quantile(p: f64) -> f64 {
    if p.is_nan() {
        return 0.0;
    }
    let p = p.clamp(1.0e-15, 1.0 - 1.0e-15);
    let (mut low, mut high) = (-8.0, 8.0);
    let mut z = 0.0;
    for _ in 0..100 {
        let off = share_below(z) - p;
        if off > 0.0 {
            high = z;
        } else {
            low = z;
        }
        let newton = z - off / density(z);
        let next = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        if (next - z).abs() <= 1e-15 * (1.0 + z.abs()) {
            return next;
        }
        z = next;
    }
    z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Abramowitz & Stegun 1964, table 26.1 and 26.6.
        for (p, z) in [
            (0.5, 0.0),
            (0.975, 1.959_963_984_540_054),
            (0.025, -1.959_963_984_540_054),
            (0.9, 1.281_551_565_544_6),
            (0.999, 3.090_232_306_167_814),
            (1.0e-6, -4.753_424_308_822_899),
        ] {
            assert!((quantile(p) - z).abs() < 1e-12, "{p}: {}", quantile(p));
        }
        for p in [0.0, 1.0, -3.0, f64::NAN, f64::INFINITY] {
            assert!(quantile(p).is_finite() && quantile(p).abs() < 8.0);
        }
    }

    #[test]
    fn a_quantile_is_where_its_share_is() {
        for i in 1..200 {
            let p = f64::from(i) / 200.0;
            assert!((share_below(quantile(p)) - p).abs() < 1e-15);
        }
    }
}
