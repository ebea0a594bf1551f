//! Two groups, paired or not: the difference of their means and its size.

use super::noncentral::noncentrality_interval;
use super::t_quantile;
use serde::{Deserialize, Serialize};

/// A group in a few numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// How many.
    pub n: usize,
    /// Mean.
    pub mean: f64,
    /// Standard deviation; 0 for one.
    pub sd: f64,
}

/// How groups are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Pairing {
    /// The same participants before and after.
    Paired,
    /// Others.
    Unpaired,
}

/// The difference of two groups: second less first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GroupDifference {
    /// How they were compared.
    pub pairing: Pairing,
    /// The first and the second; of paired groups only those with a partner.
    pub groups: [Summary; 2],
    /// Difference of the means.
    pub difference: f64,
    /// Ends of its 95 % interval: Student's t of the pairs' differences, or Welch's.
    pub difference_interval: [f64; 2],
    /// Degrees of freedom of that interval.
    pub df: f64,
    /// Cohen's d: unpaired over the pooled standard deviation (d_s), paired over that of the differences (d_z).
    pub d: f64,
    /// Hedges' g: d without its bias in small samples.
    pub g: f64,
    /// Ends of the 95 % interval of g, by the noncentral t distribution.
    pub g_interval: [f64; 2],
}

impl GroupDifference {
    /// Whether g tells anything: of two pairs it does not, for d has no mean with one degree of freedom, and g is 0.
    pub fn has_g(&self) -> bool {
        self.pairing == Pairing::Unpaired || self.groups[0].n > 2
    }
}

/// Mean and standard deviation of what is finite; `None` for nothing.
pub fn summary(values: &[f64]) -> Option<Summary> {
    let finite: Vec<f64> = values.iter().copied().filter(|x| x.is_finite()).collect();
    let n = finite.len();
    if n == 0 {
        return None;
    }
    let mean = finite.iter().sum::<f64>() / n as f64;
    let squares = finite.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>();
    let sd = (squares / n.saturating_sub(1).max(1) as f64).sqrt();
    (mean.is_finite() && sd.is_finite()).then_some(Summary { n, mean, sd })
}

/// What a small sample makes d too large by (Hedges 1981, J Educ Stat 6:107): Γ(df ⁄ 2) ⁄ (√(df ⁄ 2) Γ((df − 1) ⁄ 2)). 0 for one
/// degree of freedom, where d has no mean.
pub fn small_sample(df: f64) -> f64 {
    if df <= 1.0 {
        return 0.0;
    }
    libm::exp(libm::lgamma(0.5 * df) - libm::lgamma(0.5 * (df - 1.0))) / (0.5 * df).sqrt()
}

/// Two groups of others. `None` with fewer than two in either, or where nothing varies.
///
/// Mean difference by Welch 1947; d_s and its interval by the noncentral t of the pooled test (Hedges & Olkin 1985; Cumming &
/// Finch 2001), with the small-sample factor on both.
pub fn unpaired(first: &[f64], second: &[f64]) -> Option<GroupDifference> {
    let groups = [summary(first)?, summary(second)?];
    let [a, b] = groups;
    let (n_a, n_b) = (a.n as f64, b.n as f64);
    if a.n < 2 || b.n < 2 {
        return None;
    }
    let difference = b.mean - a.mean;
    let [v_a, v_b] = [a.sd * a.sd / n_a, b.sd * b.sd / n_b];
    let error = (v_a + v_b).sqrt();
    let df = (v_a + v_b) * (v_a + v_b) / (v_a * v_a / (n_a - 1.0) + v_b * v_b / (n_b - 1.0));
    let pooled_df = n_a + n_b - 2.0;
    let pooled = (((n_a - 1.0) * a.sd * a.sd + (n_b - 1.0) * b.sd * b.sd) / pooled_df).sqrt();
    let scale = (n_a * n_b / (n_a + n_b)).sqrt();
    told(
        Pairing::Unpaired,
        groups,
        difference,
        error,
        df,
        difference / pooled,
        scale,
        pooled_df,
    )
}

/// The same participants twice: pairs (first, second). `None` with fewer than two, or where the differences do not vary.
pub fn paired(pairs: &[[f64; 2]]) -> Option<GroupDifference> {
    let pairs: Vec<[f64; 2]> = pairs
        .iter()
        .copied()
        .filter(|p| p.iter().all(|x| x.is_finite()))
        .collect();
    let side = |i: usize| -> Vec<f64> { pairs.iter().map(|p| p[i]).collect() };
    let groups = [summary(&side(0))?, summary(&side(1))?];
    let differences: Vec<f64> = pairs.iter().map(|p| p[1] - p[0]).collect();
    let of = summary(&differences)?;
    if of.n < 2 {
        return None;
    }
    let (n, df) = (of.n as f64, of.n as f64 - 1.0);
    let error = of.sd / n.sqrt();
    told(
        Pairing::Paired,
        groups,
        of.mean,
        error,
        df,
        of.mean / of.sd,
        n.sqrt(),
        df,
    )
}

#[allow(clippy::too_many_arguments, reason = "what the two designs differ in")]
fn told(
    pairing: Pairing,
    groups: [Summary; 2],
    difference: f64,
    error: f64,
    df: f64,
    d: f64,
    scale: f64,
    d_df: f64,
) -> Option<GroupDifference> {
    if !d.is_finite() || !error.is_finite() || !df.is_finite() {
        return None;
    }
    let half = t_quantile(0.975, df)? * error;
    let factor = small_sample(d_df);
    let [low, high] = noncentrality_interval(d * scale, d_df)?;
    Some(GroupDifference {
        pairing,
        groups,
        difference,
        difference_interval: [difference - half, difference + half],
        df,
        d,
        g: factor * d,
        g_interval: [factor * low / scale, factor * high / scale],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::training::normal::quantile;
    use crate::training::random::Random;

    #[test]
    fn students_sleep_data_have_their_published_test() {
        // Student 1908: hours of sleep gained by ten patients under two drugs.
        let first = [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0];
        let second = [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4];
        let near = |a: f64, b: f64| assert!((a - b).abs() < 6e-5 * b.abs().max(1.0), "{a} {b}");
        // Welch: t = 1.8608, df = 17.776, −0.2055 to 3.3655. Paired: t = 4.0621, 0.7001 to 2.4599.
        let others = unpaired(&first, &second).expect("told");
        near(others.difference, 1.58);
        near(others.df, 17.776);
        near(others.difference_interval[0], -0.205_483);
        near(others.difference_interval[1], 3.365_483);
        near(others.d, 1.8608 * (2.0_f64 / 10.0).sqrt());
        let pairs: Vec<[f64; 2]> = first.into_iter().zip(second).map(|(a, b)| [a, b]).collect();
        let same = paired(&pairs).expect("told");
        near(same.difference_interval[0], 0.700_114);
        near(same.difference_interval[1], 2.459_886);
        near(same.d, 4.062_13 / 10_f64.sqrt());
        assert!(same.has_g() && others.has_g());
        let two = paired(&pairs[..2]).expect("told");
        assert!(!two.has_g() && two.g == 0.0);
        assert!(same.g < same.d && same.g_interval[0] > 0.0 && same.g_interval[1] > same.g);
    }

    #[test]
    fn the_small_sample_factor_is_that_of_hedges_table() {
        // Hedges 1981, table 1.
        for (df, factor) in [
            (2.0, 0.5642),
            (4.0, 0.7979),
            (10.0, 0.9228),
            (20.0, 0.9619),
            (50.0, 0.9849),
        ] {
            assert!(
                (small_sample(df) - factor).abs() < 6e-5,
                "{df}: {}",
                small_sample(df)
            );
        }
    }

    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        let mut random = Random::new(11);
        let (n, truth, runs) = (9, 0.8, 400);
        let mut held = [0_u32; 3];
        for _ in 0..runs {
            let mut draw = |shift: f64| -> Vec<f64> {
                (0..n).map(|_| shift + quantile(random.unit())).collect()
            };
            let (a, b) = (draw(0.0), draw(truth));
            let told = unpaired(&a, &b).expect("told");
            let pairs: Vec<[f64; 2]> = a.iter().zip(&b).map(|(a, b)| [*a, *b]).collect();
            let same = paired(&pairs).expect("told");
            let within = |[low, high]: [f64; 2], x: f64| u32::from(low <= x && x <= high);
            held[0] += within(told.difference_interval, truth);
            // The interval of g is that of d by the factor.
            held[1] += within(told.g_interval.map(|g| g / small_sample(16.0)), truth);
            held[2] += within(
                same.g_interval.map(|g| g / small_sample(8.0)),
                truth / 2_f64.sqrt(),
            );
        }
        // Four standard errors of 400 runs about 95 %.
        for times in held {
            let share = f64::from(times) / f64::from(runs);
            assert!(
                (share - 0.95).abs() < 4.0 * (0.95 * 0.05 / 400.0_f64).sqrt(),
                "{held:?}"
            );
        }
    }

    #[test]
    fn groups_that_tell_nothing_are_absent() {
        assert_eq!(unpaired(&[1.0], &[2.0, 3.0]), None);
        assert_eq!(unpaired(&[1.0, 1.0], &[2.0, 2.0]), None);
        assert_eq!(paired(&[[1.0, 2.0]]), None);
        assert_eq!(paired(&[[1.0, 2.0], [3.0, 4.0]]), None);
        assert_eq!(unpaired(&[f64::NAN, 1.0], &[2.0, 3.0]), None);
    }
}
