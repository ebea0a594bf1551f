//! Velocity from positions in encoder steps.
//!
//! First-order adaptive windowing (Janabi-Sharifi, Hayward and Chen 2000, "Discrete-time adaptive windowing for velocity
//! estimation", the end-fit variant): the slope over the longest window whose straight line misses no sample between by
//! more than the noise. Long at rest, where steps would make noise; short when the hand turns, where length would lag.

use crate::geom::Vec3;

/// When reports left the device, told from when they came.
///
/// They leave evenly and come when the host has time. Each is taken to have left its period after the one before, never
/// later than it came, and at most 20 ms before: so a device that is slower or faster than it states is followed
/// too. Without this two reports that come 10 µs apart make one encoder step a speed of 6 m/s.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    period_s: f64,
    left_s: Option<f64>,
}

/// Longest that a report is taken to have been on its way, s.
const MOST_LATE_S: f64 = 0.02;

impl Clock {
    /// A clock for reports at this rate, Hz; 0 for a device that has none, whose reports left when they came.
    pub fn new(rate_hz: f64) -> Self {
        Self {
            period_s: if rate_hz > 0.0 { 1.0 / rate_hz } else { 0.0 },
            left_s: None,
        }
    }

    /// Reports came at `came_s`, `n` since the last time; when the newest left, s.
    pub fn left_s(&mut self, came_s: f64, n: u64) -> f64 {
        let due_s = match self.left_s {
            Some(before_s) if self.period_s > 0.0 => before_s + self.period_s * n as f64,
            _ => came_s,
        };
        let left_s = due_s.min(came_s).max(came_s - MOST_LATE_S);
        self.left_s = Some(left_s);
        left_s
    }
}

/// Longest window, samples.
const LONGEST: usize = 16;

/// Positions lately, with their times.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    samples: [(f64, Vec3); LONGEST],
    /// How many are held, the newest at `newest`.
    n: usize,
    newest: usize,
    noise_mm: f64,
}

impl Window {
    /// An empty window for positions that are off by `noise_mm` at most on each axis.
    pub fn new(noise_mm: f64) -> Self {
        Self {
            samples: [(0.0, Vec3::ZERO); LONGEST],
            n: 0,
            newest: 0,
            noise_mm: if noise_mm > 0.0 { noise_mm } else { 0.0 },
        }
    }

    /// Forgets what it holds.
    pub fn clear(&mut self) {
        self.n = 0;
    }

    /// Takes a position, mm, at a time, s; the velocity then, mm/s. Zero for the first one and where time stands.
    pub fn take(&mut self, time_s: f64, position_mm: Vec3) -> Vec3 {
        self.newest = (self.newest + 1) % LONGEST;
        self.samples[self.newest] = (time_s, position_mm);
        self.n = (self.n + 1).min(LONGEST);
        let mut velocity = Vec3::ZERO;
        for length in 1..self.n {
            match self.slope(length) {
                Some(slope) => velocity = slope,
                None if length == 1 => return Vec3::ZERO,
                None => break,
            }
        }
        velocity
    }

    fn back(&self, i: usize) -> (f64, Vec3) {
        self.samples[(self.newest + LONGEST - i) % LONGEST]
    }

    /// The slope over the last `length` intervals, if its line is within the noise of every sample between.
    fn slope(&self, length: usize) -> Option<Vec3> {
        let (now_s, here) = self.back(0);
        let (then_s, there) = self.back(length);
        let span_s = now_s - then_s;
        if span_s.is_nan() || span_s <= 0.0 {
            return None;
        }
        let slope = (here - there) / span_s;
        let misses = (1..length).any(|i| {
            let (time_s, at) = self.back(i);
            let off = (here - slope * (now_s - time_s) - at).abs();
            !off.is_finite() || off.max_element() > self.noise_mm
        });
        (slope.is_finite() && !misses).then_some(slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_MM: f64 = 0.06;

    #[test]
    fn reports_that_come_in_bursts_left_evenly() {
        let mut clock = Clock::new(1000.0);
        assert_eq!(clock.left_s(1.0, 1), 1.0);
        // Held up for 4 ms, then two hard on each other's heels.
        assert!((clock.left_s(1.0050, 4) - 1.004).abs() < 1e-12);
        assert!((clock.left_s(1.00501, 1) - 1.005).abs() < 1e-12);
        // Before its time: the clock was late.
        assert!((clock.left_s(1.0055, 1) - 1.0055).abs() < 1e-12);
        // At half the rate it states: the lag ends, and intervals are true.
        let mut at = 0.0;
        for i in 1..=100 {
            at = clock.left_s(1.0055 + 0.002 * f64::from(i), 1);
        }
        let next = clock.left_s(1.0055 + 0.202, 1);
        assert!((next - at - 0.002).abs() < 1e-9);
    }

    fn run(position: impl Fn(f64) -> f64, ticks: usize) -> Vec<f64> {
        let mut window = Window::new(STEP_MM);
        let at = |i: usize| {
            let x = position(i as f64 * 0.001);
            Vec3::X * (libm::round(x / STEP_MM) * STEP_MM)
        };
        (0..ticks)
            .map(|i| window.take(i as f64 * 0.001, at(i)).x)
            .collect()
    }

    #[test]
    fn steady_motion_is_told_far_finer_than_by_differences() {
        let v = run(|t| 20.0 * t, 500);
        let worst = v[100..]
            .iter()
            .fold(0.0_f64, |w, v| w.max((v - 20.0).abs()));
        // A difference of two samples is 0 or 60 mm/s here.
        assert!(worst <= 2.0 * STEP_MM / 0.015, "{worst} mm/s off");
    }

    #[test]
    fn a_hand_that_stops_is_at_rest_within_the_window() {
        let v = run(|t| 100.0 * t.min(0.2), 400);
        assert!((v[199] - 100.0).abs() < 10.0);
        assert_eq!(
            v[200 + LONGEST + 1..].iter().copied().find(|v| *v != 0.0),
            None
        );
    }

    #[test]
    fn a_turn_is_followed_within_three_ticks() {
        let v = run(
            |t| {
                if t < 0.2 {
                    300.0 * t
                } else {
                    60.0 - 300.0 * (t - 0.2)
                }
            },
            400,
        );
        assert!(
            v[203] < -150.0,
            "{} mm/s three ticks after the turn",
            v[203]
        );
    }

    #[test]
    fn time_that_stands_or_goes_back_gives_no_speed() {
        let mut window = Window::new(STEP_MM);
        window.take(1.0, Vec3::ZERO);
        for (t, x) in [(1.0, 5.0), (0.5, 9.0), (f64::NAN, 1.0), (2.0, f64::NAN)] {
            assert_eq!(window.take(t, Vec3::X * x), Vec3::ZERO);
        }
        window.clear();
        assert_eq!(window.take(3.0, Vec3::X), Vec3::ZERO);
    }
}
