//! The figures of 2008 (Ji 2008, tables 3.1 and 3.2, appendix B), embedded.

use serde::Deserialize;

const CSV: &str = include_str!("../../../assets/lab/rendering_rates_2008.csv");

/// One printed row.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub(super) struct Printed {
    /// 3.1, 3.2 or B.
    pub table: String,
    /// none, bsp or octree.
    pub structure: String,
    /// What the pass did. draw: only hand the triangles on; untouch: collide too; touch: make a force too. graphic: the
    /// drawn frame.
    pub condition: String,
    /// Triangles handed on.
    pub triangles: f64,
    /// Time of a pass, ms; not printed in table 3.1.
    time_ms: Option<f64>,
    /// Passes per second.
    pub fps: f64,
}

impl Printed {
    /// Time of a pass, ms: as printed, or from the rate.
    pub fn ms(&self) -> f64 {
        self.time_ms.unwrap_or(1000.0 / self.fps)
    }
}

/// The rows of a structure in a condition, by rising number of triangles.
pub(super) fn rows(structure: &str, condition: &str) -> Vec<Printed> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_reader(CSV.as_bytes());
    reader
        .deserialize()
        .filter_map(Result::ok)
        .filter(|row: &Printed| row.structure == structure && row.condition == condition)
        .collect()
}

/// The value at `x` of a curve through positive points of rising x, straight between them where both axes are
/// logarithmic; `None` beyond its ends.
pub(super) fn at(curve: &[[f64; 2]], x: f64) -> Option<f64> {
    let pair = curve
        .windows(2)
        .find(|pair| pair[0][0] <= x && x <= pair[1][0] && pair[0][0] < pair[1][0])?;
    let share = libm::log(x / pair[0][0]) / libm::log(pair[1][0] / pair[0][0]);
    Some(pair[0][1] * libm::pow(pair[1][1] / pair[0][1], share))
}

/// How much better an octree is than a BSP per triangle, %, for each printed row.
pub(super) fn octree_better_percent(condition: &str) -> Vec<f64> {
    let per_triangle = |row: &Printed| row.ms() / row.triangles;
    rows("bsp", condition)
        .iter()
        .zip(rows("octree", condition))
        .map(|(bsp, octree)| 100.0 * (1.0 - per_triangle(&octree) / per_triangle(bsp)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_printed_row_is_read() {
        for (structure, conditions, n) in [
            ("none", &["touch", "graphic"][..], 5),
            ("bsp", &["draw", "untouch", "touch"], 7),
            ("octree", &["draw", "untouch", "touch"], 7),
        ] {
            for condition in conditions {
                let rows = rows(structure, condition);
                assert_eq!(rows.len(), n, "{structure} {condition}");
                assert!(rows.is_sorted_by(|a, b| a.triangles < b.triangles));
                for row in rows {
                    // Rates are printed in whole passes, times in tenths of ms.
                    let slack = 0.06 + 0.6 * row.ms() / row.fps;
                    assert!((row.ms() - 1000.0 / row.fps).abs() <= slack, "{row:?}");
                }
            }
        }
        assert_eq!(rows("bsp", "touch")[0].ms(), 11.0);
        assert_eq!(rows("none", "touch")[4].ms(), 1000.0 / 6.0);
    }

    /// "Slightly better (10%-20%)" in print; the tables beside it say more.
    #[test]
    fn per_triangle_the_printed_octree_is_18_to_38_percent_better_and_draws_worse() {
        let range = |condition: &str| {
            let all = octree_better_percent(condition);
            let least = all.iter().copied().fold(f64::INFINITY, f64::min);
            let most = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            (least.round(), most.round())
        };
        assert_eq!(range("untouch"), (18.0, 32.0));
        assert_eq!(range("touch"), (15.0, 38.0));
        assert_eq!(range("draw"), (-18.0, -1.0));
    }

    #[test]
    fn between_points_a_power_law_is_met_and_beyond_them_nothing_is_said() {
        let square: Vec<[f64; 2]> = [1.0, 3.0, 10.0].map(|x| [x, 2.0 * x * x]).to_vec();
        for x in [1.0, 2.0, 3.0, 5.0, 10.0] {
            let y = at(&square, x).unwrap();
            assert!((y / (2.0 * x * x) - 1.0).abs() < 1e-12, "{x}: {y}");
        }
        assert_eq!((at(&square, 0.9), at(&square, 10.1)), (None, None));
        assert_eq!(at(&square[..1], 1.0), None);
    }
}
