//! A falloff array laid out for many ratios at once.

use std::sync::Arc;

/// Added to a number below it, it leaves the nearest integer in the lowest bits.
const INTEGERS: f64 = 4_503_599_627_370_496.0;

/// Value and slope of each step of a falloff, and nothing beyond the last.
///
/// Two ratios are worked on at a time without a branch, on every machine with the same result. Cheap to clone.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Table {
    /// The last one is for all that lies outside.
    entries: Arc<[[f64; 2]]>,
    steps: f64,
    /// What is added before the fraction is dropped.
    shift: f64,
}

impl Table {
    /// Steps of samples of which the nearest is meant.
    pub fn nearest(samples: &[f64]) -> Self {
        let entries = samples.iter().map(|&m| [m, 0.0]);
        Self::new(entries.collect(), samples.len(), 0.5)
    }

    /// Steps of samples with straight lines between them.
    pub fn linear(samples: &[f64]) -> Self {
        let entries = samples.windows(2).map(|m| [m[0], m[1] - m[0]]);
        Self::new(entries.collect(), samples.len(), 0.0)
    }

    fn new(mut entries: Vec<[f64; 2]>, n_samples: usize, shift: f64) -> Self {
        entries.push([0.0; 2]);
        Self {
            entries: entries.into(),
            steps: (n_samples - 1) as f64,
            shift,
        }
    }

    /// Turns each ratio into the share there.
    #[inline]
    pub fn apply<const N: usize>(&self, ratios: &mut [f64; N]) {
        let outside = (self.entries.len() - 1) as f64;
        let mut steps = [0_u64; N];
        for (q, step) in ratios.iter_mut().zip(&mut steps) {
            let inside = if *q < 1.0 { *q } else { 0.0 };
            let place = if inside > 0.0 { inside } else { 0.0 } * self.steps;
            let place_up = place + self.shift;
            let nearest = (place_up + INTEGERS) - INTEGERS;
            let below = nearest - if nearest > place_up { 1.0 } else { 0.0 };
            let last = outside - 1.0;
            let below = if below < last { below } else { last };
            let at = if *q < 1.0 { below } else { outside };
            *step = (at + INTEGERS).to_bits();
            *q = place - below;
        }
        for (q, &step) in ratios.iter_mut().zip(&steps) {
            // The bits above the lowest 32 belong to the exponent.
            let [m, rise] = self.entries[step as u32 as usize];
            *q = m + rise * *q;
        }
    }
}
