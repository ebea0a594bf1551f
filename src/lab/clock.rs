//! Measuring how long short work takes.

use std::time::Instant;

/// Calls by which the cost of reading the clock is found.
const CLOCK_READINGS: usize = 20_000;

/// A clock that takes off what reading it costs.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    cost_us: f64,
}

impl Default for Stopwatch {
    fn default() -> Self {
        Self::new()
    }
}

impl Stopwatch {
    /// Finds what reading the clock costs here.
    pub fn new() -> Self {
        let readings = (0..CLOCK_READINGS).map(|_| Instant::now().elapsed().as_secs_f64() * 1e6);
        Self {
            cost_us: Samples::from_iter(readings).median(),
        }
    }

    /// What `work` gives, and how long it took, µs, at least 0.
    pub fn time<T>(&self, work: impl FnOnce() -> T) -> (T, f64) {
        let start = Instant::now();
        let result = work();
        let took_us = start.elapsed().as_secs_f64() * 1e6;
        (result, (took_us - self.cost_us).max(0.0))
    }
}

/// Measured values, sorted when asked.
#[derive(Clone, Debug, Default)]
pub struct Samples(Vec<f64>);

impl FromIterator<f64> for Samples {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        Self(values.into_iter().collect())
    }
}

impl Samples {
    /// Adds a value.
    pub fn push(&mut self, value: f64) {
        self.0.push(value);
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The arithmetic mean; NaN for no value.
    pub fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len() as f64
    }

    /// The value below which the share `p`, 0…1, of all lie, as one of them (nearest rank); NaN for no value.
    pub fn quantile(&self, p: f64) -> f64 {
        let mut sorted = self.0.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let rank = (p.clamp(0.0, 1.0) * sorted.len() as f64).ceil() as usize;
        sorted
            .get(rank.saturating_sub(1))
            .copied()
            .unwrap_or(f64::NAN)
    }

    /// The middle value; of an even number the lower middle one.
    pub fn median(&self) -> f64 {
        self.quantile(0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_by_nearest_rank() {
        let s: Samples = (1..=100).rev().map(f64::from).collect();
        assert_eq!(
            (s.median(), s.quantile(0.99), s.quantile(1.0)),
            (50.0, 99.0, 100.0)
        );
        assert_eq!((s.quantile(0.0), s.mean(), s.len()), (1.0, 50.5, 100));
        let one = Samples::from_iter([3.0]);
        assert_eq!((one.median(), one.quantile(0.99)), (3.0, 3.0));
        assert!(Samples::default().median().is_nan() && Samples::default().mean().is_nan());
    }
}
