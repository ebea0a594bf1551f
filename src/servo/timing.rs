//! How well the servo keeps time.

/// Width of a histogram bin, µs.
pub const BIN_US: f64 = 20.0;
/// Number of bins; the last holds everything above.
pub const N_BINS: usize = 100;

/// Whether the servo runs as it should.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Health {
    /// Not running.
    #[default]
    Stopped,
    /// On time, device answering.
    Good,
    /// Late ticks in the last second.
    Late,
    /// The device does not answer, or the servo thread hangs: force is zero.
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
    /// Mean tick, µs.
    pub mean_tick_us: f64,
    /// Ticks by time between two starts, [`BIN_US`] per bin.
    pub period_histogram: [u32; N_BINS],
    /// Ticks by their own duration, a tenth of [`BIN_US`] per bin.
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
            mean_tick_us: 0.0,
            period_histogram: [0; N_BINS],
            duration_histogram: [0; N_BINS],
        }
    }
}
