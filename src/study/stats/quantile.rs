//! Quantiles of the distributions that intervals are made from.

use statrs::distribution::{ContinuousCDF, FisherSnedecor, StudentsT};

/// The value below which lies the share `p` of Student's t with `df` degrees of freedom. `None` where there is none.
pub fn t_quantile(p: f64, df: f64) -> Option<f64> {
    if !(p > 0.0 && p < 1.0 && df > 0.0 && df.is_finite()) {
        return None;
    }
    let t = StudentsT::new(0.0, 1.0, df).ok()?.inverse_cdf(p);
    t.is_finite().then_some(t)
}

/// The value below which lies the share `p` of Fisher's F with `df1` and `df2` degrees of freedom. `None` where there is
/// none.
pub fn f_quantile(p: f64, df1: f64, df2: f64) -> Option<f64> {
    let sound = |df: f64| df > 0.0 && df.is_finite();
    if !(p > 0.0 && p < 1.0 && sound(df1) && sound(df2)) {
        return None;
    }
    let f = FisherSnedecor::new(df1, df2).ok()?.inverse_cdf(p);
    f.is_finite().then_some(f)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Abramowitz & Stegun 1964, tables 26.10 and 26.9.
        for (p, df, t) in [
            (0.975, 1.0, 12.706),
            (0.975, 10.0, 2.228),
            (0.95, 30.0, 1.697),
            (0.025, 5.0, -2.571),
        ] {
            let got = t_quantile(p, df).expect("one");
            assert!((got - t).abs() < 6e-4, "{p} {df}: {got}");
        }
        for (p, a, b, f) in [
            (0.95, 3.0, 10.0, 3.71),
            (0.975, 5.0, 15.0, 3.58),
            (0.99, 1.0, 5.0, 16.26),
        ] {
            let got = f_quantile(p, a, b).expect("one");
            assert!((got - f).abs() < 6e-3, "{p} {a} {b}: {got}");
        }
        for (p, df) in [
            (0.0, 3.0),
            (1.0, 3.0),
            (f64::NAN, 3.0),
            (0.5, 0.0),
            (0.5, f64::NAN),
        ] {
            assert_eq!(t_quantile(p, df), None);
            assert_eq!(f_quantile(p, df, 2.0), None);
        }
    }
}
