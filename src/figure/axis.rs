//! One axis of a plot: its range and its marks, linear or logarithmic.
//!
//! A logarithmic axis is laid out in decades: [`Scale::place`] takes a value to its decimal logarithm, and all that is
//! drawn is placed by that.

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// How an axis is laid out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Scale {
    /// Equal steps are equally long.
    #[default]
    Linear,
    /// Equal factors are equally long; there is no 0.
    Logarithmic,
}

impl Scale {
    /// Where a value stands along the axis, in decades where it is logarithmic: NaN where it has no place.
    pub fn place(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Logarithmic if value > 0.0 && value <= FARTHEST => libm::log10(value),
            Self::Logarithmic => f64::NAN,
        }
    }
}

/// The range of an axis that shows `places`, with `margin` of their span to each side: never without a width.
pub fn axis_range(places: impl Iterator<Item = f64>, margin: f64, scale: Scale) -> Range<f64> {
    padded(
        extent(places.filter(|p| p.abs() <= FARTHEST)),
        margin,
        scale,
    )
}

/// The marks of an axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Marks {
    /// Where numbers stand, and the numbers.
    pub major: Vec<(f64, String)>,
    /// Where lines without a number stand.
    pub minor: Vec<f64>,
}

/// About `n` round marks for a range of places; none for a range without a width.
pub fn axis_marks(range: Range<f64>, n: usize, scale: Scale) -> Marks {
    let is_drawn = range.start.abs() <= FARTHEST && range.end.abs() <= FARTHEST;
    // Narrower, neighbouring marks would be one number.
    let least = 1.0e-12 * range.start.abs().max(range.end.abs());
    if !is_drawn || range.end - range.start <= least {
        return Marks::default();
    }
    let axis = Axis::new(range, n, scale);
    Marks {
        major: axis
            .marks
            .iter()
            .map(|m| (*m, axis.format_ext(m)))
            .collect(),
        minor: axis.minor,
    }
}

/// Farther out than any quantity here, and well inside what the axes can be divided over.
pub(super) const FARTHEST: f64 = 1.0e15;
/// Narrower than this, decades, a logarithmic axis has marks at 2 and 5 times the powers of ten too.
const FEW_DECADES: f64 = 3.2;
/// A logarithmic axis is at least this long, decades: round numbers lie on it.
const FEWEST_DECADES: f64 = 1.0;

/// The least and the greatest of some values.
pub(super) fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |found, v| match found {
        None => Some((v, v)),
        Some((low, high)) => Some((f64::min(low, v), f64::max(high, v))),
    })
}

/// The range of an axis: the places with `margin` of their span to each side, never without a width. 0 to 1 for none.
///
/// On a linear axis zero is taken in where it is near, for a curve that all but touches it misleads when cut off there.
pub(super) fn padded(extent: Option<(f64, f64)>, margin: f64, scale: Scale) -> Range<f64> {
    let Some((mut low, mut high)) = extent else {
        return 0.0..1.0;
    };
    if scale == Scale::Logarithmic {
        let pad = (margin * (high - low)).max((FEWEST_DECADES - (high - low)) / 2.0);
        return low - pad..high + pad;
    }
    // A span that the axis cannot be divided over: the values are all but equal.
    let least = 1.0e-9 * low.abs().max(high.abs()).max(1.0e-3);
    if high - low < least {
        let half = 0.05 * low.abs().max(high.abs());
        let half = if half > least { half } else { 0.5 };
        return low - half..high + half;
    }
    let span = high - low;
    if margin > 0.0 {
        let (starts_at_zero, ends_at_zero) = (
            low >= 0.0 && low < 0.3 * span,
            high <= 0.0 && -high < 0.3 * span,
        );
        let pad = margin * span;
        low = if starts_at_zero { 0.0 } else { low - pad };
        high = if ends_at_zero { 0.0 } else { high + pad };
    }
    low..high
}

/// An axis with marks at round places: multiples of 1, 2 or 5 times a power of ten, or on a logarithmic axis these
/// themselves.
pub(super) struct Axis {
    range: Range<f64>,
    marks: Vec<f64>,
    /// Lines without a number, between the marks.
    minor: Vec<f64>,
    scale: Scale,
    decimals: usize,
    is_wide: bool,
}

impl Axis {
    /// With about `n` marks; `range`, of places, has a width.
    pub(super) fn new(range: Range<f64>, n: usize, scale: Scale) -> Self {
        match scale {
            Scale::Linear => Self::linear(range, n, 0.0),
            Scale::Logarithmic => Self::logarithmic(range, n),
        }
    }

    /// The same for numbers of things: on a linear axis no mark stands between whole numbers.
    pub(super) fn of_whole(range: Range<f64>, n: usize, scale: Scale) -> Self {
        match scale {
            Scale::Linear => Self::linear(range, n, 1.0),
            Scale::Logarithmic => Self::logarithmic(range, n),
        }
    }

    fn linear(range: Range<f64>, n: usize, least_step: f64) -> Self {
        let rough = (range.end - range.start) / n as f64;
        let power = libm::pow(10.0, libm::floor(libm::log10(rough)));
        let step = [1.0, 2.0, 5.0]
            .into_iter()
            .map(|m| m * power)
            .find(|&s| s >= rough * 0.999)
            .unwrap_or(10.0 * power)
            .max(least_step);
        let most = range.start.abs().max(range.end.abs());
        let first = (range.start / step - 1.0e-6).ceil() as i64;
        let last = (range.end / step + 1.0e-6).floor() as i64;
        Self {
            range,
            marks: (first..=last).map(|i| i as f64 * step).collect(),
            minor: Vec::new(),
            scale: Scale::Linear,
            decimals: (-libm::floor(libm::log10(step * 1.001))).max(0.0) as usize,
            is_wide: most >= 1.0e6 || step < 1.0e-5,
        }
    }

    fn logarithmic(range: Range<f64>, n: usize) -> Self {
        let decades = range.end - range.start;
        let (first, last) = (
            libm::floor(range.start) as i32,
            libm::ceil(range.end) as i32,
        );
        let inside = |at: &f64| *at >= range.start - 1.0e-9 && *at <= range.end + 1.0e-9;
        let of = |multiples: &[f64]| -> Vec<f64> {
            let decade = |d: i32| {
                multiples
                    .iter()
                    .map(move |m| f64::from(d) + libm::log10(*m))
            };
            (first..=last).flat_map(decade).filter(inside).collect()
        };
        // Every decade, or every second, third … where there are many.
        let every = (decades / (2.0 * n as f64)).ceil().max(1.0) as i32;
        let powers = (first..=last).filter(|d| d % every == 0);
        let marks = if decades <= FEW_DECADES {
            of(&[1.0, 2.0, 5.0])
        } else {
            powers.map(f64::from).filter(inside).collect()
        };
        Self {
            marks,
            minor: of(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]),
            range,
            scale: Scale::Logarithmic,
            decimals: 0,
            is_wide: false,
        }
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let share = (value - self.range.start) / (self.range.end - self.range.start);
        let span = f64::from(limit.1) - f64::from(limit.0);
        (f64::from(limit.0) + share * span).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() && !self.minor.is_empty() {
            return self.minor.clone();
        }
        self.marks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, place: &f64) -> String {
        let text = if self.scale == Scale::Logarithmic {
            power_text(*place)
        } else if *place == 0.0 {
            "0".to_owned()
        } else if self.is_wide {
            format!("{place:.3e}")
        } else {
            format!("{place:.*}", self.decimals)
        };
        text.replace('-', "\u{2212}")
    }
}

/// The number at a mark of a logarithmic axis: 1, 2 or 5 times a power of ten.
fn power_text(place: f64) -> String {
    let power = libm::floor(place + 1.0e-9);
    let multiple = libm::round(libm::pow(10.0, place - power));
    let power = power as i32;
    match power {
        -4..=-1 => format!(
            "{:.*}",
            -power as usize,
            multiple * libm::pow(10.0, power.into())
        ),
        0..=5 => format!("{:.0}", multiple * libm::pow(10.0, power.into())),
        _ => format!("{multiple:.0}e{power}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_whole_numbers_stands_no_mark_where_things_are_counted() {
        let marks = |range: Range<f64>| Axis::of_whole(range, 10, Scale::Linear).marks;
        assert_eq!(marks(0.97..2.03), [1.0, 2.0]);
        assert_eq!(marks(0.9..4.1), [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(
            marks(0.0..100.0),
            Axis::new(0.0..100.0, 10, Scale::Linear).marks
        );
    }
    use plotters::coord::ranged1d::{BoldPoints, LightPoints};
    use proptest::prelude::*;

    fn marks(axis: &Axis) -> Vec<f64> {
        axis.key_points(BoldPoints(5))
    }

    fn texts(axis: &Axis) -> Vec<String> {
        marks(axis).iter().map(|m| axis.format_ext(m)).collect()
    }

    proptest! {
        #[test]
        fn every_axis_has_a_width_and_a_few_round_marks_inside(
            low in -1.0e15..1.0e15_f64, exponent in -20..16_i32, up in 0.0..9.0_f64,
        ) {
            let high = (low + up * 10_f64.powi(exponent)).min(FARTHEST);
            let range = padded(Some((low, high)), 0.06, Scale::Linear);
            prop_assert!(range.start <= low && range.end >= high && range.start < range.end);
            let axis = Axis::new(range.clone(), 5, Scale::Linear);
            let marks = marks(&axis);
            prop_assert!((2..=12).contains(&marks.len()), "{:?}: {:?}", range, marks);
            for pair in marks.windows(2) {
                prop_assert!(axis.format_ext(&pair[0]) != axis.format_ext(&pair[1]) || axis.is_wide);
            }
        }

        #[test]
        fn every_logarithmic_axis_has_a_few_marks_inside_that_read_as_what_they_are(
            low in -300.0..15.0_f64, decades in 0.0..30.0_f64,
        ) {
            let high = (low + decades).min(15.0);
            let range = padded(Some((low, high)), 0.06, Scale::Logarithmic);
            prop_assert!(range.start <= low && range.end >= high && range.start < range.end);
            let axis = Axis::new(range.clone(), 5, Scale::Logarithmic);
            let marks = marks(&axis);
            prop_assert!((2..=13).contains(&marks.len()), "{:?}: {:?}", range, marks);
            for place in marks {
                prop_assert!(range.start - 1e-6 <= place && place <= range.end + 1e-6);
                let read: f64 = axis.format_ext(&place).replace('\u{2212}', "-").parse().unwrap();
                prop_assert!((read.log10() - place).abs() < 1e-6, "{} at {}", read, place);
            }
        }
    }

    #[test]
    fn marks_are_round_and_read_as_such() {
        let axis = Axis::new(-0.4..1.3, 5, Scale::Linear);
        assert_eq!(texts(&axis), ["0", "0.5", "1.0"]);
        let axis = Axis::new(-25.0..25.0, 5, Scale::Linear);
        assert_eq!(texts(&axis), ["\u{2212}20", "\u{2212}10", "0", "10", "20"]);
        let axis = Axis::new(-2.1..1.1, 5, Scale::Logarithmic);
        let wanted = [
            "0.01", "0.02", "0.05", "0.1", "0.2", "0.5", "1", "2", "5", "10",
        ];
        assert_eq!(texts(&axis), wanted);
        let axis = Axis::new(2.0..8.0, 5, Scale::Logarithmic);
        let wanted = ["100", "1000", "10000", "100000", "1e6", "1e7", "1e8"];
        assert_eq!(texts(&axis), wanted);
        assert_eq!(axis.key_points(LightPoints::new(5, 5)).len(), 55);
    }

    #[test]
    fn what_is_not_above_zero_has_no_place_on_a_logarithmic_axis() {
        for value in [0.0, -0.0, -1.0, f64::NAN, f64::INFINITY, 1.0e16] {
            assert!(Scale::Logarithmic.place(value).is_nan(), "{value}");
        }
        assert_eq!(Scale::Logarithmic.place(1000.0), 3.0);
        assert_eq!(Scale::Linear.place(-2.5), -2.5);
    }
}
