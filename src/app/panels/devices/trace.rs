//! The last seconds of a device, one sample a frame, in bounded memory.

use crate::geom::Vec3;
use std::collections::VecDeque;

/// How far back it goes, s.
pub const SPAN_S: f64 = 8.0;
/// Samples are at least this far apart, s: no more than a screen shows.
const APART_S: f64 = 1.0 / 90.0;

/// One look at a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When, s.
    pub time_s: f64,
    /// Where it was, mm.
    pub position_mm: Vec3,
    /// What it rendered, N.
    pub force_n: Vec3,
}

/// The last [`SPAN_S`] seconds.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    samples: VecDeque<Sample>,
}

impl Trace {
    /// Takes a sample in, unless it comes too early or has no number; forgets what is too old. A clock that went back
    /// starts it anew.
    pub fn push(&mut self, sample: Sample) {
        let finite = sample.position_mm.is_finite() && sample.force_n.is_finite();
        if !finite || !sample.time_s.is_finite() {
            return;
        }
        if let Some(last) = self.samples.back() {
            if sample.time_s < last.time_s {
                self.samples.clear();
            } else if sample.time_s - last.time_s < APART_S {
                return;
            }
        }
        let from_s = sample.time_s - SPAN_S;
        while self.samples.front().is_some_and(|s| s.time_s < from_s) {
            self.samples.pop_front();
        }
        self.samples.push_back(sample);
    }

    /// Forgets all, and the memory too.
    pub fn clear(&mut self) {
        self.samples = VecDeque::new();
    }

    /// `value` over seconds before the newest sample, oldest first.
    pub fn line(&self, value: impl Fn(&Sample) -> f64) -> Vec<[f64; 2]> {
        let Some(last) = self.samples.back() else {
            return Vec::new();
        };
        let now_s = last.time_s;
        let points = self.samples.iter();
        points.map(|s| [s.time_s - now_s, value(s)]).collect()
    }

    /// Smallest and largest `value` of the three; `None` before the first sample.
    pub fn range(&self, value: impl Fn(&Sample) -> Vec3) -> Option<(f64, f64)> {
        let mut values = self.samples.iter().map(value);
        let first = values.next()?;
        let start = (first.min_element(), first.max_element());
        Some(values.fold(start, |(low, high), v| {
            (low.min(v.min_element()), high.max(v.max_element()))
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time_s: f64, x: f64) -> Sample {
        Sample {
            time_s,
            position_mm: Vec3::new(x, 0.0, 0.0),
            force_n: Vec3::ZERO,
        }
    }

    #[test]
    fn memory_is_bounded_however_often_it_is_looked_at() {
        let mut trace = Trace::default();
        for i in 0..200_000 {
            trace.push(at(f64::from(i) * 1e-3, 1.0));
        }
        let line = trace.line(|s| s.position_mm.x);
        let most = (SPAN_S / APART_S) as usize + 2;
        assert!(
            line.len() <= most && line.len() > most / 2,
            "{}",
            line.len()
        );
        assert!(line[0][0] >= -SPAN_S && line[line.len() - 1][0] == 0.0);
        assert!(line.windows(2).all(|p| p[1][0] - p[0][0] >= APART_S));
    }

    #[test]
    fn what_is_no_number_is_left_out_and_a_clock_that_goes_back_begins_anew() {
        let mut trace = Trace::default();
        assert_eq!(trace.range(|s| s.position_mm), None);
        trace.push(at(5.0, 2.0));
        trace.push(at(6.0, f64::NAN));
        trace.push(at(f64::NAN, 1.0));
        trace.push(at(7.0, -3.0));
        assert_eq!(trace.range(|s| s.position_mm), Some((-3.0, 2.0)));
        trace.push(at(1.0, 9.0));
        assert_eq!(trace.line(|s| s.position_mm.x), [[0.0, 9.0]]);
    }
}
