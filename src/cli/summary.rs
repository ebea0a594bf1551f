//! What a run came to, in a few numbers.

use crate::contact::Touch;
use crate::servo::{FingerRecord, LimitFlags};
use std::fmt;

/// Figures of one run, all fingers together.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Summary {
    /// Number of fingers.
    pub fingers: usize,
    /// Ticks done.
    pub ticks: u64,
    /// Simulated or lived time, s.
    pub seconds: f64,
    /// Time any finger touched the skin, finger-seconds.
    pub contact_s: f64,
    /// Of that, time the proxy slipped against friction.
    pub slip_s: f64,
    /// Deepest penetration, mm.
    pub max_depth_mm: f64,
    /// Highest force sent, N.
    pub peak_force_n: f64,
    /// Ticks in which a limit changed the force, counted per finger.
    pub limited_ticks: u64,
    /// Ticks that came too late.
    pub late_ticks: u64,
    #[serde(skip)]
    dt_s: f64,
    #[serde(skip)]
    first_tick: Option<u64>,
}

impl Summary {
    /// An empty summary of a run with the given step, s.
    pub fn new(dt_s: f64) -> Self {
        Self {
            dt_s,
            ..Self::default()
        }
    }

    /// Counts one record.
    pub fn add(&mut self, record: &FingerRecord) {
        let first = *self.first_tick.get_or_insert(record.tick);
        self.fingers = self.fingers.max(usize::from(record.finger) + 1);
        self.ticks = self.ticks.max(record.tick.saturating_sub(first) + 1);
        self.seconds = self.ticks as f64 * self.dt_s;
        if record.contact.touch != Touch::Free {
            self.contact_s += self.dt_s;
        }
        if record.contact.touch == Touch::Slip {
            self.slip_s += self.dt_s;
        }
        self.max_depth_mm = self.max_depth_mm.max(record.contact.depth_mm);
        self.peak_force_n = self.peak_force_n.max(record.sent_force_n.length());
        self.limited_ticks += u64::from(!record.limits.is_empty());
        if record.finger == 0 {
            self.late_ticks += u64::from(record.limits.has(LimitFlags::LATE));
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fingers = if self.fingers == 1 {
            "finger"
        } else {
            "fingers"
        };
        writeln!(
            f,
            "{:.3} s, {} ticks, {} {fingers}",
            self.seconds, self.ticks, self.fingers
        )?;
        writeln!(f, "contact       {:>8.3} s", self.contact_s)?;
        writeln!(f, "slipping      {:>8.3} s", self.slip_s)?;
        writeln!(f, "deepest       {:>8.3} mm", self.max_depth_mm)?;
        writeln!(f, "peak force    {:>8.3} N", self.peak_force_n)?;
        writeln!(f, "limited ticks {:>8}", self.limited_ticks)?;
        write!(f, "late ticks    {:>8}", self.late_ticks)
    }
}
