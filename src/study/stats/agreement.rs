//! Agreement of two series of measures of the same things: RMSE, and Bland & Altman's limits.

use super::t_quantile;
use serde::{Deserialize, Serialize};

/// How far two series of the same measure agree; differences are second less first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BlandAltman {
    /// Pairs.
    pub n: usize,
    /// Mean difference.
    pub bias: f64,
    /// Standard deviation of the differences.
    pub sd: f64,
    /// Root of the mean square of the differences.
    pub rmse: f64,
    /// Bias less and plus 1.96 standard deviations: between lie 95 % of differences that are normal.
    pub limits: [f64; 2],
    /// Ends of the bias's 95 % interval.
    pub bias_interval: [f64; 2],
    /// Ends of the 95 % interval of the lower limit.
    pub lower_interval: [f64; 2],
    /// Ends of that of the upper limit.
    pub upper_interval: [f64; 2],
    /// Mean and difference of each pair, in order.
    pub points: Vec<[f64; 2]>,
}

/// Normal quantile of the limits.
const Z: f64 = 1.96;

/// Agreement of pairs (first, second). Pairs that are not finite are left out; `None` with fewer than two.
///
/// Bland & Altman 1986 (Lancet 327:307); the variance of a limit is s² (1 ⁄ n + 1.96² ⁄ (2 (n − 1))) as in their 1999 paper
/// (Stat Methods Med Res 8:135), with Student's t. The intervals are right where pairs are independent.
pub fn bland_altman(pairs: impl IntoIterator<Item = [f64; 2]>) -> Option<BlandAltman> {
    let pairs = pairs
        .into_iter()
        .filter(|p| p.iter().all(|x| x.is_finite()));
    let points: Vec<[f64; 2]> = pairs.map(|[a, b]| [0.5 * a + 0.5 * b, b - a]).collect();
    let n = points.len();
    let count = n as f64;
    let t = t_quantile(0.975, count - 1.0)?;
    let bias = points.iter().map(|p| p[1]).sum::<f64>() / count;
    let squares = |about: f64| {
        points
            .iter()
            .map(|p| (p[1] - about) * (p[1] - about))
            .sum::<f64>()
    };
    let sd = (squares(bias) / (count - 1.0)).sqrt();
    let limits = [bias - Z * sd, bias + Z * sd];
    let of_bias = t * sd / count.sqrt();
    let of_limit = t * sd * (1.0 / count + Z * Z / (2.0 * (count - 1.0))).sqrt();
    let about = |x: f64, half: f64| [x - half, x + half];
    let all = BlandAltman {
        n,
        bias,
        sd,
        rmse: (squares(0.0) / count).sqrt(),
        limits,
        bias_interval: about(bias, of_bias),
        lower_interval: about(limits[0], of_limit),
        upper_interval: about(limits[1], of_limit),
        points,
    };
    // Numbers so large that their squares are not finite tell nothing.
    (all.rmse.is_finite() && all.sd.is_finite()).then_some(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bland & Altman 1986, table 1: peak expiratory flow, first measurements with the Wright and the mini meter, l/min.
    const PEFR: [[f64; 2]; 17] = [
        [494.0, 512.0],
        [395.0, 430.0],
        [516.0, 520.0],
        [434.0, 428.0],
        [476.0, 500.0],
        [557.0, 600.0],
        [413.0, 364.0],
        [442.0, 380.0],
        [650.0, 658.0],
        [433.0, 445.0],
        [417.0, 432.0],
        [656.0, 626.0],
        [267.0, 260.0],
        [478.0, 477.0],
        [178.0, 259.0],
        [423.0, 350.0],
        [427.0, 451.0],
    ];

    #[test]
    fn the_published_example_has_its_published_limits() {
        // The paper takes large less mini, and 2 for 1.96: −2.1, 38.8; bias from −22.0 to 17.8.
        let got = bland_altman(PEFR.map(|[large, mini]| [mini, large])).expect("agreement");
        assert!(
            (got.bias + 2.1).abs() < 0.05 && (got.sd - 38.8).abs() < 0.05,
            "{got:?}"
        );
        assert!(
            (got.bias_interval[0] + 22.0).abs() < 0.1 && (got.bias_interval[1] - 17.8).abs() < 0.1
        );
        let wide = |limit: f64| got.bias + (limit - got.bias) * 2.0 / 1.96;
        assert!(
            (wide(got.limits[0]) + 79.7).abs() < 0.1 && (wide(got.limits[1]) - 75.5).abs() < 0.1
        );
        // Lower limit: −114.3 to −45.1 by the cruder standard error √(3 s² ⁄ n) = 16.3 of the paper.
        let half = 0.5 * (got.lower_interval[1] - got.lower_interval[0]);
        assert!((half - 2.12 * 16.3).abs() < 0.03 * half, "{half}");
        let rmse = (PEFR.iter().map(|[a, b]| (a - b) * (a - b)).sum::<f64>() / 17.0).sqrt();
        assert!((got.rmse - rmse).abs() < 1e-12);
    }

    #[test]
    fn too_few_pairs_tell_nothing() {
        assert_eq!(bland_altman([]), None);
        assert_eq!(bland_altman([[1.0, 2.0]]), None);
        assert_eq!(bland_altman([[1.0, f64::NAN], [1.0, 2.0]]), None);
        assert_eq!(bland_altman([[1e300, -1e300], [1.0, 2.0]]), None);
        let same = bland_altman([[1.0, 1.0], [3.0, 3.0]]).expect("agreement");
        assert_eq!((same.bias, same.sd, same.rmse), (0.0, 0.0, 0.0));
    }
}
