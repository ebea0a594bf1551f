//! Which values a colour map spans, and the numbers beside its legend.

/// How the range follows the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Span {
    /// From −x to x, x round.
    Symmetric,
    /// From 0 to a round number.
    FromZero,
    /// From the smallest value to the largest.
    Data,
    /// Always 0 to 180 degrees: the end is the beginning.
    HalfTurn,
}

/// A range that cannot be smaller: of values that are all 0, in the unit of the quantity.
const LEAST: f64 = 1.0;
/// Values beyond this are no quantity of a skin; they are cut so that ranges stay finite.
const MOST: f64 = 1.0e9;

/// The range of one quantity on show.
///
/// What moves with every frame (strain, displacement) spans the largest value seen since the last reset: a range that came
/// and went with each press would change the colour of what stands still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    span: Span,
    seen: Option<[f64; 2]>,
    fixed: Option<[f64; 2]>,
}

impl Range {
    /// One that follows the data; none was seen.
    pub fn new(span: Span) -> Self {
        Self {
            span,
            seen: None,
            fixed: None,
        }
    }

    /// How it follows the data.
    pub fn span(&self) -> Span {
        self.span
    }

    /// Takes in the smallest and the largest value of a frame. What is no number is not taken.
    pub fn note(&mut self, [low, high]: [f64; 2]) {
        let (low, high) = (low.clamp(-MOST, MOST), high.clamp(-MOST, MOST));
        if low <= high {
            let seen = self.seen.unwrap_or([low, high]);
            self.seen = Some([seen[0].min(low), seen[1].max(high)]);
        }
    }

    /// Forgets what was seen, as when the field is another one.
    pub fn forget(&mut self) {
        self.seen = None;
    }

    /// Smallest and largest value seen; `None` before the first.
    pub fn seen(&self) -> Option<[f64; 2]> {
        self.seen
    }

    /// The range: its lower end is always below its upper one.
    pub fn bounds(&self) -> [f64; 2] {
        self.fixed.unwrap_or_else(|| self.automatic())
    }

    fn automatic(&self) -> [f64; 2] {
        let [low, high] = self.seen.unwrap_or([0.0, 0.0]);
        let most = low.abs().max(high.abs());
        match self.span {
            Span::Symmetric => {
                let top = round_above(most);
                [-top, top]
            }
            Span::FromZero => [0.0, round_above(high)],
            Span::HalfTurn => [0.0, 180.0],
            // One value everywhere stands in the middle.
            Span::Data if high - low <= 1e-9 * most => {
                let half = if most > 0.0 { most / 2.0 } else { LEAST };
                [low - half, high + half]
            }
            Span::Data => [low, high],
        }
    }

    /// Whether it follows the data.
    pub fn is_automatic(&self) -> bool {
        self.fixed.is_none()
    }

    /// Whether ends can be set at all.
    pub fn can_be_fixed(&self) -> bool {
        self.span != Span::HalfTurn
    }

    /// Holds the range as it is, or lets it follow again.
    pub fn set_automatic(&mut self, on: bool) {
        self.fixed = (!on && self.can_be_fixed()).then(|| self.bounds());
    }

    /// Sets the lower end (`end` 0) or the upper one (`end` 1) and holds the range. A symmetric range changes at both ends;
    /// the other end gives way where it must. What is no number changes nothing.
    pub fn fix(&mut self, end: usize, value: f64) {
        if !value.is_finite() || !self.can_be_fixed() {
            return;
        }
        let value = value.clamp(-MOST, MOST);
        let mut bounds = self.bounds();
        let least = 1e-6 * value.abs().max(1e-3);
        if self.span == Span::Symmetric {
            let half = value.abs().max(least);
            bounds = [-half, half];
        } else if end == 0 {
            bounds = [value, bounds[1].max(value + least)];
        } else {
            bounds = [bounds[0].min(value - least), value];
        }
        self.fixed = Some(bounds);
    }

    /// Follows the data anew, with nothing seen so far but `now`.
    pub fn reset(&mut self, now: Option<[f64; 2]>) {
        *self = Self::new(self.span);
        if let Some(now) = now {
            self.note(now);
        }
    }

    /// Step between numbers so that there are at most `most` steps; a finer one where no multiple of that lies in the range.
    pub fn step(&self, most: usize) -> f64 {
        let [low, high] = self.bounds();
        let raw = (high - low) / most.max(1) as f64;
        if self.span == Span::HalfTurn {
            let steps = [5.0, 10.0, 15.0, 30.0, 45.0, 90.0];
            return steps.into_iter().find(|&s| s >= raw).unwrap_or(180.0);
        }
        let power = 10.0_f64.powf(raw.log10().floor());
        let steps = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0].map(|m| m * power);
        let coarse = steps.iter().position(|&s| s >= raw * (1.0 - 1e-9));
        let coarse = coarse.unwrap_or(steps.len() - 1);
        let fits = |&s: &f64| {
            let [first, last] = multiples([low, high], s);
            first <= last
        };
        let step = steps[..=coarse].iter().rev().copied().find(fits);
        step.unwrap_or(steps[coarse])
    }

    /// Round values within the range, rising, at most `most` + 1 of them.
    pub fn ticks(&self, most: usize) -> Vec<f64> {
        let step = self.step(most);
        let [first, last] = multiples(self.bounds(), step);
        (first..=last)
            .take(most + 1)
            .map(|i| i as f64 * step)
            .collect()
    }

    /// Digits after the point that tell `step` apart.
    pub fn digits(step: f64) -> usize {
        (0..9)
            .find(|&d| {
                let scaled = step * 10.0_f64.powi(d);
                (scaled - scaled.round()).abs() < 1e-6 * scaled.abs().max(1.0)
                    && scaled.round() >= 1.0
            })
            .unwrap_or(3) as usize
    }
}

/// The first and the last multiple of `step` within `bounds`, counted in steps; the last before the first where there is none.
fn multiples([low, high]: [f64; 2], step: f64) -> [i64; 2] {
    let slack = 1e-6 * step;
    [
        ((low - slack) / step).ceil() as i64,
        ((high + slack) / step).floor() as i64,
    ]
}

/// The smallest of 1, 1.5, 2, 3, 4, 5, 6 and 8 times a power of ten that is at least `x`; [`LEAST`] at the least.
fn round_above(x: f64) -> f64 {
    if !(x > LEAST && x.is_finite()) {
        return LEAST;
    }
    let power = 10.0_f64.powf(x.log10().floor());
    [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0]
        .into_iter()
        .map(|m| m * power)
        .find(|&v| v >= x * (1.0 - 1e-9))
        .unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_symmetric_range_is_round_and_grows_only() {
        let mut range = Range::new(Span::Symmetric);
        assert_eq!(range.bounds(), [-1.0, 1.0]);
        range.note([-3.2, 11.0]);
        assert_eq!(range.bounds(), [-15.0, 15.0]);
        range.note([0.0, 0.0]);
        assert_eq!(range.bounds(), [-15.0, 15.0]);
        range.note([-16.0, 0.0]);
        assert_eq!(range.bounds(), [-20.0, 20.0]);
        range.reset(Some([-0.5, 2.5]));
        assert_eq!(range.bounds(), [-3.0, 3.0]);
    }

    #[test]
    fn a_range_between_two_round_numbers_has_a_number_all_the_same() {
        let mut range = Range::new(Span::Data);
        range.note([528_811.0, 958_644.0]);
        assert_eq!(range.ticks(2), [600_000.0, 800_000.0]);
    }

    #[test]
    fn data_span_their_ends_and_one_value_stands_in_the_middle() {
        let mut range = Range::new(Span::Data);
        range.note([0.21, 0.87]);
        assert_eq!(range.bounds(), [0.21, 0.87]);
        range.reset(Some([140.0, 140.0]));
        assert_eq!(range.bounds(), [70.0, 210.0]);
    }

    #[test]
    fn an_end_that_is_set_holds_the_range_until_it_follows_again() {
        let mut range = Range::new(Span::Data);
        range.note([1.0, 2.0]);
        range.fix(1, 5.0);
        range.note([0.0, 9.0]);
        assert_eq!(range.bounds(), [1.0, 5.0]);
        range.fix(0, 7.0);
        let [low, high] = range.bounds();
        assert!(low == 7.0 && high > low, "the other end gives way");
        range.set_automatic(true);
        assert_eq!(range.bounds(), [0.0, 9.0]);
        let mut strain = Range::new(Span::Symmetric);
        strain.fix(0, -4.0);
        assert_eq!(strain.bounds(), [-4.0, 4.0]);
        let mut angle = Range::new(Span::HalfTurn);
        angle.fix(0, 20.0);
        angle.set_automatic(false);
        assert_eq!(angle.bounds(), [0.0, 180.0]);
    }

    #[test]
    fn directions_are_numbered_by_parts_of_a_right_angle() {
        let range = Range::new(Span::HalfTurn);
        assert_eq!(range.ticks(4), [0.0, 45.0, 90.0, 135.0, 180.0]);
        assert_eq!(range.step(12), 15.0);
    }

    #[test]
    fn numbers_beside_a_legend_have_the_digits_that_tell_them_apart() {
        assert_eq!(Range::digits(5.0), 0);
        assert_eq!(Range::digits(0.5), 1);
        assert_eq!(Range::digits(0.02), 2);
        assert_eq!(Range::digits(20.0), 0);
    }

    proptest! {
        #[test]
        fn ticks_are_few_rising_and_within(
            span in prop::sample::select(vec![Span::Symmetric, Span::FromZero, Span::Data]),
            low in -1e6..1e6_f64, width in 0.0..1e6_f64, most in 2..12_usize,
        ) {
            let mut range = Range::new(span);
            range.note([low, low + width]);
            let [from, to] = range.bounds();
            prop_assert!(from < to && from.is_finite() && to.is_finite());
            let ticks = range.ticks(most);
            prop_assert!(!ticks.is_empty() && ticks.len() <= most + 1);
            let slack = 1e-5 * range.step(most);
            prop_assert!(ticks.iter().all(|t| (from - slack..=to + slack).contains(t)));
            prop_assert!(ticks.windows(2).all(|w| w[0] < w[1]));
        }

        #[test]
        fn any_number_typed_leaves_a_range(span in prop::sample::select(vec![Span::Symmetric, Span::FromZero, Span::Data]),
            values in prop::collection::vec((0..2_usize, prop::num::f64::ANY), 1..8)) {
            let mut range = Range::new(span);
            for (end, value) in values {
                range.fix(end, value);
                range.note([value, value]);
                let [low, high] = range.bounds();
                prop_assert!(low < high && low.is_finite() && high.is_finite());
                prop_assert!(!range.ticks(6).is_empty());
            }
        }
    }
}
