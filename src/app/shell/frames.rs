//! How long frames take.

use crate::app::state::FrameTiming;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Keeps the frames of the last second.
#[derive(Debug, Default)]
pub struct FrameMeter {
    recent: VecDeque<(Instant, f64)>,
}

impl FrameMeter {
    /// Counts a frame that started `now`; the one before took `work_ms` of processor time.
    pub fn count(&mut self, now: Instant, work_ms: f64) -> FrameTiming {
        self.recent.push_back((now, work_ms));
        while let Some((at, _)) = self.recent.front()
            && now.duration_since(*at) > Duration::from_secs(1)
        {
            self.recent.pop_front();
        }
        FrameTiming {
            last_ms: work_ms,
            longest_ms: self.recent.iter().map(|f| f.1).fold(0.0, f64::max),
            frames_per_s: self.recent.len() as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_last_second_counts() {
        let mut meter = FrameMeter::default();
        let start = Instant::now();
        meter.count(start, 50.0);
        let timing = meter.count(start + Duration::from_millis(500), 4.0);
        assert_eq!((timing.longest_ms, timing.frames_per_s), (50.0, 2.0));
        let timing = meter.count(start + Duration::from_millis(1200), 5.0);
        assert_eq!((timing.longest_ms, timing.frames_per_s), (5.0, 2.0));
    }
}
