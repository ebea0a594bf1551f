//! How well the servo keeps time.

/// Number of histogram bins; the last holds everything above.
pub const N_BINS: usize = 100;
/// Width of a bin of the period histogram, µs.
pub const PERIOD_BIN_US: f64 = 25.0;
/// Width of a bin of the duration histogram, µs.
pub const DURATION_BIN_US: f64 = 0.5;

/// Whether the servo runs as it should.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Health {
    /// Not running.
    #[default]
    Stopped,
    /// On time, devices answering.
    Good,
    /// Late ticks in the last second.
    Late,
    /// A device does not answer, or the servo thread hangs or has panicked: force is zero.
    Fault,
}

/// Timing since the servo started. A plain value, cheap to copy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimingStats {
    /// Ticks done.
    pub ticks: u64,
    /// Ticks that came later than the watchdog's bound; force was zero in them.
    pub late_ticks: u64,
    /// Records that found the ring full and were lost to the recorder.
    pub lost_records: u64,
    /// Longest time between the start of two ticks, µs.
    pub longest_period_us: f64,
    /// Longest tick, µs.
    pub longest_tick_us: f64,
    /// Sum of all ticks' durations, µs.
    pub total_tick_us: f64,
    /// Ticks by time between two starts, [`PERIOD_BIN_US`] per bin.
    pub period_histogram: [u32; N_BINS],
    /// Ticks by their own duration, [`DURATION_BIN_US`] per bin.
    pub duration_histogram: [u32; N_BINS],
}

impl Default for TimingStats {
    fn default() -> Self {
        Self {
            ticks: 0,
            late_ticks: 0,
            lost_records: 0,
            longest_period_us: 0.0,
            longest_tick_us: 0.0,
            total_tick_us: 0.0,
            period_histogram: [0; N_BINS],
            duration_histogram: [0; N_BINS],
        }
    }
}

impl TimingStats {
    /// Counts one tick. `period_us` is the time since the last tick's start; `None` for the first.
    pub fn count(&mut self, period_us: Option<f64>, duration_us: f64, late: bool) {
        self.ticks += 1;
        self.late_ticks += u64::from(late);
        if let Some(period_us) = period_us {
            self.longest_period_us = self.longest_period_us.max(period_us);
            add(&mut self.period_histogram, period_us / PERIOD_BIN_US);
        }
        self.longest_tick_us = self.longest_tick_us.max(duration_us);
        self.total_tick_us += duration_us;
        add(&mut self.duration_histogram, duration_us / DURATION_BIN_US);
    }

    /// Mean duration of a tick, µs; zero before the first.
    pub fn mean_tick_us(&self) -> f64 {
        if self.ticks == 0 {
            0.0
        } else {
            self.total_tick_us / self.ticks as f64
        }
    }

    /// Upper edge of the bin below which a fraction `p` (0…1) of all tick durations lie, µs; zero before the first tick.
    /// Durations beyond the histogram answer with the longest.
    pub fn duration_quantile_us(&self, p: f64) -> f64 {
        quantile(&self.duration_histogram, p)
            .map_or(self.longest_tick_us, |bin| bin as f64 * DURATION_BIN_US)
    }
}

fn add(histogram: &mut [u32; N_BINS], bin: f64) {
    // A cast from f64 saturates, so that NaN and negative times land in the first bin and infinite ones in the last.
    let count = &mut histogram[(bin as usize).min(N_BINS - 1)];
    *count = count.saturating_add(1);
}

/// Number of bins that hold a fraction `p`; `None` when that reaches into the open last bin.
fn quantile(histogram: &[u32; N_BINS], p: f64) -> Option<usize> {
    let total: u64 = histogram.iter().map(|&n| u64::from(n)).sum();
    if total == 0 {
        return Some(0);
    }
    let wanted = p.clamp(0.0, 1.0) * total as f64;
    let mut seen = 0_u64;
    for (bin, &n) in histogram.iter().enumerate().take(N_BINS - 1) {
        seen += u64::from(n);
        if seen as f64 >= wanted {
            return Some(bin + 1);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn histograms_hold_every_tick_and_the_last_bin_is_open() {
        let mut t = TimingStats::default();
        t.count(None, 0.2, false);
        t.count(Some(1000.0), 0.7, false);
        t.count(Some(1.0e9), 1.0e9, true);
        assert_eq!((t.ticks, t.late_ticks), (3, 1));
        assert_eq!(t.period_histogram.iter().sum::<u32>(), 2);
        assert_eq!(t.duration_histogram.iter().sum::<u32>(), 3);
        assert_eq!(
            (t.period_histogram[40], t.period_histogram[N_BINS - 1]),
            (1, 1)
        );
        assert_eq!(t.longest_period_us, 1.0e9);
    }

    #[test]
    fn quantiles_are_upper_edges_of_bins() {
        let mut t = TimingStats::default();
        assert_eq!(t.duration_quantile_us(0.5), 0.0);
        for i in 0..100 {
            t.count(None, if i < 90 { 0.3 } else { 1.2 }, false);
        }
        assert_eq!(t.duration_quantile_us(0.5), 0.5);
        assert_eq!(t.duration_quantile_us(0.99), 1.5);
        t.count(None, 900.0, false);
        assert_eq!(t.duration_quantile_us(1.0), 900.0);
    }

    #[test]
    fn times_that_make_no_sense_are_counted_not_fatal() {
        let mut t = TimingStats::default();
        t.count(Some(f64::NAN), f64::NAN, false);
        t.count(Some(-1.0), f64::INFINITY, false);
        assert_eq!(t.period_histogram[0], 2);
    }
}
