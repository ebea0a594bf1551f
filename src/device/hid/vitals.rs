//! What a link tells about itself while it runs: counts, conditions and histograms in plain atomics, so that looking costs
//! the link nothing.

use super::guard::Condition;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU8, AtomicU64, Ordering};
use std::time::Duration;

/// Bins of a histogram.
pub const N_BINS: usize = 100;
/// Width of a bin, µs. The last bin holds all that is longer.
pub const BIN_US: f64 = 100.0;

/// How often durations were how long.
#[derive(Debug)]
pub struct Histogram {
    bins: [AtomicU64; N_BINS],
}

impl Default for Histogram {
    fn default() -> Self {
        Self {
            bins: [const { AtomicU64::new(0) }; N_BINS],
        }
    }
}

impl Histogram {
    fn count(&self, duration: Duration) {
        let bin = (duration.as_secs_f64() * 1.0e6 / BIN_US) as usize;
        self.bins[bin.min(N_BINS - 1)].fetch_add(1, Ordering::Relaxed);
    }

    /// Counts, the shortest first.
    pub fn bins(&self) -> [u64; N_BINS] {
        std::array::from_fn(|i| self.bins[i].load(Ordering::Relaxed))
    }

    /// The upper edge of the bin that `share` (0 … 1) of the durations do not pass, µs; `None` before the first.
    pub fn quantile_us(&self, share: f64) -> Option<f64> {
        let bins = self.bins();
        let total: u64 = bins.iter().sum();
        if total == 0 {
            return None;
        }
        let wanted = (share.clamp(0.0, 1.0) * total as f64).max(1.0);
        let mut sum = 0;
        let bin = bins.iter().position(|n| {
            sum += n;
            sum as f64 >= wanted
        });
        Some((bin.unwrap_or(N_BINS - 1) + 1) as f64 * BIN_US)
    }
}

/// The state of one link. The link writes, anybody reads.
#[derive(Debug, Default)]
pub struct Vitals {
    /// Time between reports.
    pub interval: Histogram,
    /// Time from a report to the first currents that answer it.
    pub latency: Histogram,
    condition: AtomicU8,
    taken_off: AtomicU64,
    why_off: AtomicU8,
    reports: AtomicU64,
    not_understood: AtomicU64,
    lost: AtomicU64,
    skipped: AtomicU64,
    written: AtomicU64,
    raw: [AtomicI32; 6],
    current_ma: [AtomicI32; 3],
    release: AtomicBool,
}

/// What [`Vitals`] counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, Default)]
pub struct Counts {
    /// Reports understood.
    pub reports: u64,
    /// Reports of a wrong length or kind.
    pub not_understood: u64,
    /// Reports that the device's counter says were sent and never came.
    pub lost: u64,
    /// Reports passed over because a newer one was there.
    pub skipped: u64,
    /// Reports written.
    pub written: u64,
    /// Times that it was good and force was taken off it.
    pub taken_off: u64,
}

impl Vitals {
    /// How the device is.
    pub fn condition(&self) -> Condition {
        Condition::from_number(self.condition.load(Ordering::Acquire))
    }

    /// What force was last taken off for, which may have passed since; [`Condition::Waiting`] before the first time.
    pub fn why_off(&self) -> Condition {
        Condition::from_number(self.why_off.load(Ordering::Acquire))
    }

    /// What was counted.
    pub fn counts(&self) -> Counts {
        let get = |n: &AtomicU64| n.load(Ordering::Relaxed);
        Counts {
            reports: get(&self.reports),
            not_understood: get(&self.not_understood),
            lost: get(&self.lost),
            skipped: get(&self.skipped),
            written: get(&self.written),
            taken_off: get(&self.taken_off),
        }
    }

    /// Encoders or deflections, as they came last.
    pub fn raw(&self) -> [i32; 6] {
        std::array::from_fn(|i| self.raw[i].load(Ordering::Relaxed))
    }

    /// Currents sent last, mA.
    pub fn current_ma(&self) -> [i32; 3] {
        std::array::from_fn(|i| self.current_ma[i].load(Ordering::Relaxed))
    }

    /// Asks the link to let a latched fault go. Force comes back with the next report.
    pub fn release(&self) {
        self.release.store(true, Ordering::Release);
    }

    pub(super) fn take_release(&self) -> bool {
        self.release.swap(false, Ordering::AcqRel)
    }

    pub(super) fn set_condition(&self, condition: Condition) {
        let before = self.condition.swap(condition as u8, Ordering::AcqRel);
        let fell = before == Condition::Good as u8 && condition != Condition::Good;
        if fell && condition != Condition::Closed {
            self.why_off.store(condition as u8, Ordering::Release);
            self.taken_off.fetch_add(1, Ordering::Release);
        }
    }

    pub(super) fn count_reports(&self, understood: u64, other: u64) {
        self.reports.fetch_add(understood, Ordering::Relaxed);
        self.not_understood.fetch_add(other, Ordering::Relaxed);
        let over = understood.saturating_sub(1);
        self.skipped.fetch_add(over, Ordering::Relaxed);
    }

    pub(super) fn count_lost(&self, n: u64) {
        self.lost.fetch_add(n, Ordering::Relaxed);
    }

    pub(super) fn count_interval(&self, interval: Duration) {
        self.interval.count(interval);
    }

    pub(super) fn count_latency(&self, latency: Duration) {
        self.latency.count(latency);
    }

    pub(super) fn count_written(&self, current_ma: [i32; 3]) {
        self.written.fetch_add(1, Ordering::Relaxed);
        for (to, ma) in self.current_ma.iter().zip(current_ma) {
            to.store(ma, Ordering::Relaxed);
        }
    }

    pub(super) fn show_raw(&self, raw: [i32; 6]) {
        for (to, n) in self.raw.iter().zip(raw) {
            to.store(n, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What passes between two looks is seen all the same.
    #[test]
    fn each_time_that_force_is_taken_off_is_counted_and_a_good_bye_is_none() {
        let vitals = Vitals::default();
        let off = || (vitals.counts().taken_off, vitals.why_off());
        for condition in [Condition::Waiting, Condition::Good, Condition::Good] {
            vitals.set_condition(condition);
        }
        assert_eq!(off(), (0, Condition::Waiting));
        vitals.set_condition(Condition::Silent);
        vitals.set_condition(Condition::Good);
        assert_eq!(off(), (1, Condition::Silent));
        vitals.set_condition(Condition::Jumped);
        vitals.set_condition(Condition::Jumped);
        assert_eq!(off(), (2, Condition::Jumped));
        vitals.set_condition(Condition::Good);
        vitals.set_condition(Condition::Closed);
        assert_eq!(off(), (2, Condition::Jumped));
    }

    #[test]
    fn quantiles_are_upper_edges_of_their_bins() {
        let h = Histogram::default();
        assert_eq!(h.quantile_us(0.5), None);
        for us in [50, 950, 1010, 1020, 1_000_000] {
            h.count(Duration::from_micros(us));
        }
        assert_eq!(h.quantile_us(0.0), Some(100.0));
        assert_eq!(h.quantile_us(0.4), Some(1000.0));
        assert_eq!(h.quantile_us(0.8), Some(1100.0));
        assert_eq!(h.quantile_us(1.0), Some(10_000.0));
    }
}
