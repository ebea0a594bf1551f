//! Intraclass correlation: how far the measures of the same targets by several judges agree.
//!
//! Shrout & Fleiss 1979 (Psychol Bull 86:420), McGraw & Wong 1996 (Psychol Methods 1:30). A table has one row a target and one
//! column a judge (or session). Intervals are F-based, that of the two-way random forms by Satterthwaite's approximation.

use super::f_quantile;
use serde::{Deserialize, Serialize};

/// Which of the six.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum IccForm {
    /// One-way random, single measure: each target has judges of its own.
    #[serde(rename = "ICC(1,1)")]
    OneSingle,
    /// Two-way random, single measure, absolute agreement: the judges are a sample of many.
    #[serde(rename = "ICC(2,1)")]
    TwoSingle,
    /// Two-way mixed, single measure, consistency: these judges are all there are.
    #[serde(rename = "ICC(3,1)")]
    ThreeSingle,
    /// As the first, mean of k measures.
    #[serde(rename = "ICC(1,k)")]
    OneMean,
    /// As the second, mean of k measures.
    #[serde(rename = "ICC(2,k)")]
    TwoMean,
    /// As the third, mean of k measures.
    #[serde(rename = "ICC(3,k)")]
    ThreeMean,
}

impl IccForm {
    /// All six.
    pub const ALL: [Self; 6] = [
        Self::OneSingle,
        Self::TwoSingle,
        Self::ThreeSingle,
        Self::OneMean,
        Self::TwoMean,
        Self::ThreeMean,
    ];

    /// Such as "ICC(2,1)".
    pub fn name(self) -> &'static str {
        match self {
            Self::OneSingle => "ICC(1,1)",
            Self::TwoSingle => "ICC(2,1)",
            Self::ThreeSingle => "ICC(3,1)",
            Self::OneMean => "ICC(1,k)",
            Self::TwoMean => "ICC(2,k)",
            Self::ThreeMean => "ICC(3,k)",
        }
    }

    /// What it is of.
    pub fn about(self) -> &'static str {
        match self {
            Self::OneSingle => "one-way random, single measure",
            Self::TwoSingle => "two-way random, absolute agreement, single measure",
            Self::ThreeSingle => "two-way mixed, consistency, single measure",
            Self::OneMean => "one-way random, mean of k measures",
            Self::TwoMean => "two-way random, absolute agreement, mean of k measures",
            Self::ThreeMean => "two-way mixed, consistency, mean of k measures",
        }
    }
}

/// An intraclass correlation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Icc {
    /// Which form.
    pub form: IccForm,
    /// Its value; below 0 where targets differ less than chance would have it.
    pub value: f64,
    /// Ends of its 95 % interval.
    pub interval: [f64; 2],
    /// Targets.
    pub targets: usize,
    /// Judges.
    pub judges: usize,
}

/// The correlation of `form` of a table, one row a target. `None` with fewer than two targets or judges, rows of different
/// lengths, a number that is not finite, or targets and judges between which nothing varies.
pub fn icc(rows: &[Vec<f64>], form: IccForm) -> Option<Icc> {
    let (n, k) = (rows.len(), rows.first()?.len());
    let sound = rows
        .iter()
        .all(|r| r.len() == k && r.iter().all(|x| x.is_finite()));
    if n < 2 || k < 2 || !sound {
        return None;
    }
    let (nf, kf) = (n as f64, k as f64);
    let grand = rows.iter().flatten().sum::<f64>() / (nf * kf);
    let row_means: Vec<f64> = rows.iter().map(|r| r.iter().sum::<f64>() / kf).collect();
    let square = |x: f64| x * x;
    let between = kf * row_means.iter().map(|m| square(m - grand)).sum::<f64>() / (nf - 1.0);
    let within_sum: f64 = rows
        .iter()
        .zip(&row_means)
        .map(|(row, mean)| row.iter().map(|x| square(x - mean)).sum::<f64>())
        .sum();
    let within = within_sum / (nf * (kf - 1.0));
    let column = |j: usize| rows.iter().map(|r| r[j]).sum::<f64>() / nf;
    let judges_sum = nf * (0..k).map(|j| square(column(j) - grand)).sum::<f64>();
    let judges = judges_sum / (kf - 1.0);
    let error = ((within_sum - judges_sum) / ((nf - 1.0) * (kf - 1.0))).max(0.0);
    let ms = MeanSquares {
        n: nf,
        k: kf,
        between,
        judges,
        error,
    };
    let (value, interval) = match form {
        IccForm::OneSingle | IccForm::OneMean => {
            ms.one_way(within, nf * (kf - 1.0), form == IccForm::OneMean)?
        }
        IccForm::ThreeSingle | IccForm::ThreeMean => {
            ms.one_way(error, (nf - 1.0) * (kf - 1.0), form == IccForm::ThreeMean)?
        }
        IccForm::TwoSingle | IccForm::TwoMean => ms.two_way(form == IccForm::TwoMean)?,
    };
    let all_finite = value.is_finite() && interval.iter().all(|x| x.is_finite());
    all_finite.then_some(Icc {
        form,
        value,
        interval,
        targets: n,
        judges: k,
    })
}

struct MeanSquares {
    n: f64,
    k: f64,
    between: f64,
    judges: f64,
    error: f64,
}

impl MeanSquares {
    /// The forms that compare targets with one residual.
    fn one_way(&self, residual: f64, df: f64, mean: bool) -> Option<(f64, [f64; 2])> {
        let k = self.k;
        let f = self.between / residual;
        let low = f / f_quantile(0.975, self.n - 1.0, df)?;
        let high = f * f_quantile(0.975, df, self.n - 1.0)?;
        // As ratios, so that no residual at all gives 1 and not what is no number.
        let single = |f: f64| {
            if f.is_infinite() {
                1.0
            } else {
                (f - 1.0) / (f + k - 1.0)
            }
        };
        let mean_of = |f: f64| 1.0 - 1.0 / f;
        let of = |f: f64| if mean { mean_of(f) } else { single(f) };
        Some((of(f), [of(low), of(high)]))
    }

    fn two_way(&self, mean: bool) -> Option<(f64, [f64; 2])> {
        let Self {
            n,
            k,
            between: b,
            judges: j,
            error: e,
            ..
        } = *self;
        let single = (b - e) / (b + (k - 1.0) * e + k * (j - e) / n);
        let value = if mean {
            (b - e) / (b + (j - e) / n)
        } else {
            single
        };
        if j == 0.0 && e == 0.0 {
            return (b > 0.0).then_some((1.0, [1.0, 1.0]));
        }
        let rest = k * j + (k * n - k - n) * e;
        let a_j = k * single / (n * (1.0 - single)) * j;
        let b_e = (1.0 + k * single * (n - 1.0) / (n * (1.0 - single))) * e;
        let v = (a_j + b_e) * (a_j + b_e)
            / (a_j * a_j / (k - 1.0) + b_e * b_e / ((n - 1.0) * (k - 1.0)));
        let upper = f_quantile(0.975, n - 1.0, v)?;
        let lower = f_quantile(0.975, v, n - 1.0)?;
        let low = n * (b - upper * e) / (upper * rest + n * b);
        let high = n * (lower * b - e) / (rest + n * lower * b);
        let interval = [low, high].map(|x| {
            if mean {
                k * x / (1.0 + (k - 1.0) * x)
            } else {
                x
            }
        });
        Some((value, interval))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shrout & Fleiss 1979, table 2: four judges, six targets.
    fn published() -> Vec<Vec<f64>> {
        [
            [9, 2, 5, 8],
            [6, 1, 3, 2],
            [8, 4, 6, 8],
            [7, 1, 2, 6],
            [10, 5, 6, 9],
            [6, 2, 4, 7],
        ]
        .map(|row| row.map(f64::from).to_vec())
        .to_vec()
    }

    #[test]
    fn the_published_table_has_its_published_correlations() {
        // Values: their table 4. Intervals: as printed for the same table by the usual statistics packages.
        let wanted = [
            (IccForm::OneSingle, 0.17, [-0.13, 0.72]),
            (IccForm::TwoSingle, 0.29, [0.02, 0.76]),
            (IccForm::ThreeSingle, 0.71, [0.34, 0.95]),
            (IccForm::OneMean, 0.44, [-0.88, 0.91]),
            (IccForm::TwoMean, 0.62, [0.07, 0.93]),
            (IccForm::ThreeMean, 0.91, [0.68, 0.99]),
        ];
        for (form, value, interval) in wanted {
            let got = icc(&published(), form).expect("a value");
            assert!((got.value - value).abs() <= 0.0051, "{got:?}");
            for (got_end, end) in got.interval.iter().zip(interval) {
                assert!((got_end - end).abs() <= 0.0051, "{got:?} {end}");
            }
            assert_eq!((got.targets, got.judges), (6, 4));
        }
    }

    #[test]
    fn judges_who_agree_have_one_and_a_constant_shift_only_harms_absolute_agreement() {
        let same: Vec<Vec<f64>> = (0..5).map(|i| vec![f64::from(i); 3]).collect();
        let shifted: Vec<Vec<f64>> = (0..5)
            .map(|i| vec![f64::from(i), f64::from(i) + 2.0])
            .collect();
        for form in IccForm::ALL {
            assert_eq!(icc(&same, form).map(|i| i.value), Some(1.0), "{form:?}");
        }
        assert_eq!(
            icc(&shifted, IccForm::ThreeSingle).map(|i| i.value),
            Some(1.0)
        );
        assert!(icc(&shifted, IccForm::TwoSingle).expect("value").value < 0.7);
        for table in [
            vec![],
            vec![vec![1.0, 2.0]],
            vec![vec![1.0], vec![2.0]],
            vec![vec![1.0, 2.0], vec![1.0]],
        ] {
            assert!(icc(&table, IccForm::TwoSingle).is_none());
        }
        for form in IccForm::ALL {
            assert!(icc(&vec![vec![3.0; 3]; 4], form).is_none());
            assert!(icc(&[vec![f64::NAN, 1.0], vec![1.0, 2.0]], form).is_none());
        }
    }
}
