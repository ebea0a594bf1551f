//! Which stretch of time, and which height, the plots show.

/// Widths on offer, s.
pub const WINDOWS_S: [f64; 8] = [2.0, 5.0, 10.0, 30.0, 60.0, 300.0, 900.0, 3600.0];

/// A width in words.
pub fn window_name(width_s: f64) -> String {
    if width_s < 1.0 {
        format!("{:.0} ms", width_s * 1000.0)
    } else if width_s < 60.0 {
        format!("{width_s:.0} s")
    } else if width_s < 3600.0 {
        format!("{:.0} min", width_s / 60.0)
    } else {
        format!("{:.0} h", width_s / 3600.0)
    }
}

const NARROWEST_S: f64 = 0.02;
const WIDEST_S: f64 = 24.0 * 3600.0;

/// The time on show: it follows the newest tick, or the replayed instant, until it is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    width_s: f64,
    end_s: f64,
    following: bool,
}

impl Default for Range {
    /// The last ten seconds, following.
    fn default() -> Self {
        Self {
            width_s: 10.0,
            end_s: 0.0,
            following: true,
        }
    }
}

impl Range {
    /// Moves on to data that spans `span_s` (s), or to the replayed instant.
    pub fn update(&mut self, span_s: (f64, f64), replayed_s: Option<f64>) {
        if !self.following {
            return;
        }
        let (start_s, end_s) = span_s;
        self.end_s = match replayed_s {
            // A recording is known to its end: show what comes, and stand still near the ends.
            Some(s) => (s + 0.3 * self.width_s)
                .min(end_s)
                .max(start_s + self.width_s),
            // A young history grows from the left before it scrolls.
            None => end_s.max(start_s + self.width_s),
        };
    }

    /// First and last time, s.
    pub fn bounds_s(&self) -> (f64, f64) {
        (self.end_s - self.width_s, self.end_s)
    }

    /// Its width, s.
    pub fn width_s(&self) -> f64 {
        self.width_s
    }

    /// Sets the width, s; the newest end stays.
    pub fn set_width(&mut self, width_s: f64) {
        if width_s.is_finite() {
            self.width_s = width_s.clamp(NARROWEST_S, WIDEST_S);
        }
    }

    /// Whether it follows.
    pub fn is_following(&self) -> bool {
        self.following
    }

    /// Follows again.
    pub fn follow(&mut self) {
        self.following = true;
    }

    /// Holds, or follows again.
    pub fn toggle(&mut self) {
        self.following = !self.following;
    }

    /// Moves by `delta_s` and holds.
    pub fn pan(&mut self, delta_s: f64) {
        if delta_s.is_finite() && delta_s != 0.0 {
            self.end_s += delta_s;
            self.following = false;
        }
    }

    /// Narrows by `factor` about `at_s`; a following range keeps following and its newest end.
    pub fn zoom(&mut self, factor: f64, at_s: f64) {
        if !(factor.is_finite() && factor > 0.0 && at_s.is_finite()) {
            return;
        }
        let width_s = (self.width_s / factor).clamp(NARROWEST_S, WIDEST_S);
        if !self.following {
            let right = (self.end_s - at_s) / self.width_s;
            self.end_s = at_s + right * width_s;
        }
        self.width_s = width_s;
    }
}

/// The top of a value axis: a round number that grows at once and shrinks only when far too high, so that it does not
/// flicker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Top(f64);

impl Default for Top {
    fn default() -> Self {
        Self(1.0)
    }
}

impl Top {
    /// The top for data up to `largest`.
    pub fn update(&mut self, largest: f64) -> f64 {
        if largest.is_finite() {
            let wanted = round_up(largest * 1.05);
            if wanted > self.0 || largest * 3.0 < self.0 {
                self.0 = wanted;
            }
        }
        self.0
    }
}

/// The next of 1, 2, 5, 10, 20 … from 1 up.
fn round_up(x: f64) -> f64 {
    let mut step = 1.0;
    while step < 1e12 {
        for factor in [1.0, 2.0, 5.0] {
            if x <= factor * step {
                return factor * step;
            }
        }
        step *= 10.0;
    }
    step
}

/// Marks of a time axis from `from_s` to `to_s`: about five, at round times.
pub fn time_marks(from_s: f64, to_s: f64) -> Vec<egui_plot::GridMark> {
    const STEPS_S: [f64; 19] = [
        0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 120.0, 300.0,
        600.0, 1800.0, 3600.0, 21600.0,
    ];
    let wanted_s = (to_s - from_s) / 6.0;
    let step_s = STEPS_S
        .into_iter()
        .find(|s| *s >= wanted_s)
        .unwrap_or(STEPS_S[STEPS_S.len() - 1]);
    let first = (from_s / step_s).ceil().max(0.0);
    (0..32)
        .map(|i| (first + f64::from(i)) * step_s)
        .take_while(|s| *s <= to_s)
        .map(|value| egui_plot::GridMark {
            value,
            step_size: to_s - from_s,
        })
        .collect()
}

/// Marks of a value axis from zero to `top`: zero, the middle and the top.
pub fn marks(top: f64) -> Vec<egui_plot::GridMark> {
    [0.0, 0.5, 1.0]
        .map(|share| egui_plot::GridMark {
            value: share * top,
            step_size: top,
        })
        .to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_following_range_ends_at_the_newest_tick_and_a_held_one_stays() {
        let mut range = Range::default();
        range.update((0.0, 42.0), None);
        assert_eq!(range.bounds_s(), (32.0, 42.0));
        range.toggle();
        range.update((0.0, 99.0), None);
        assert_eq!(range.bounds_s(), (32.0, 42.0));
        range.follow();
        range.update((0.0, 99.0), None);
        assert_eq!(range.bounds_s(), (89.0, 99.0));
    }

    #[test]
    fn panning_holds_and_zooming_keeps_the_time_under_the_cursor() {
        let mut range = Range::default();
        range.update((0.0, 100.0), None);
        range.pan(-20.0);
        assert!(!range.is_following());
        assert_eq!(range.bounds_s(), (70.0, 80.0));
        range.zoom(2.0, 75.0);
        assert_eq!(range.bounds_s(), (72.5, 77.5));
        range.zoom(f64::NAN, 75.0);
        range.zoom(1e9, 75.0);
        assert!(range.width_s() >= NARROWEST_S);
    }

    #[test]
    fn replay_stands_still_near_the_ends_of_the_recording() {
        let mut range = Range::default();
        range.update((0.0, 60.0), Some(0.0));
        assert_eq!(range.bounds_s(), (0.0, 10.0));
        range.update((0.0, 60.0), Some(30.0));
        assert_eq!(range.bounds_s(), (23.0, 33.0));
        range.update((0.0, 60.0), Some(60.0));
        assert_eq!(range.bounds_s(), (50.0, 60.0));
    }

    #[test]
    fn time_marks_are_few_and_round() {
        let values =
            |from, to| -> Vec<f64> { time_marks(from, to).iter().map(|m| m.value).collect() };
        assert_eq!(values(0.0, 10.0), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(values(-5.0, 5.0), [0.0, 2.0, 4.0]);
        assert_eq!(values(61.5, 121.5), [70.0, 80.0, 90.0, 100.0, 110.0, 120.0]);
        assert!(values(0.0, 1e9).len() <= 32);
        assert!(values(f64::NAN, f64::NAN).is_empty());
    }

    #[test]
    fn the_top_is_round_and_does_not_flicker() {
        let mut top = Top::default();
        assert_eq!(top.update(0.0), 1.0);
        assert_eq!(top.update(3.9), 5.0);
        assert_eq!(top.update(2.0), 5.0);
        assert_eq!(top.update(1.0), 2.0);
        assert_eq!(top.update(f64::NAN), 2.0);
        assert_eq!(round_up(1e300), 1e12);
    }
}
