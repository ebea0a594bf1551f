//! The last step before the device: whatever comes in, what goes out is finite, within the rated force, and does not
//! rise faster than allowed.

use crate::geom::Vec3;

/// Bounds on the force sent to one device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Highest force, N.
    pub rated_force_n: f64,
    /// Fastest rise of force, N/s. Falling is not limited: letting go is always safe.
    pub rise_n_per_s: f64,
}

impl Default for Limits {
    /// The rated force of a PHANToM Premium 3.0 (METHOD 7), reached from zero in 5 ms at the earliest.
    fn default() -> Self {
        Self {
            rated_force_n: 22.0,
            rise_n_per_s: 22.0 / 0.005,
        }
    }
}

/// Which limits acted on a force, bit by bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct LimitFlags(pub u32);

impl LimitFlags {
    /// The wanted force was not finite.
    pub const NOT_FINITE: Self = Self(1);
    /// The wanted force exceeded the rated force.
    pub const RATED: Self = Self(2);
    /// The wanted force rose too fast.
    pub const RISE: Self = Self(4);
    /// Output is switched off.
    pub const DISABLED: Self = Self(8);
    /// The tick was late beyond the watchdog's bound.
    pub const LATE: Self = Self(16);
    /// The device did not answer.
    pub const DISCONNECTED: Self = Self(32);

    /// Whether all of `other` is set.
    pub fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Whether nothing acted.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    pub(super) fn set(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

/// What decides whether force may flow at all.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gate {
    pub(super) enabled: bool,
    pub(super) late: bool,
    pub(super) connected: bool,
}

/// The force to send, given the wanted one and the one sent last tick.
pub(super) fn limit(
    wanted_n: Vec3,
    last_n: Vec3,
    gate: Gate,
    limits: &Limits,
    dt_s: f64,
) -> (Vec3, LimitFlags) {
    let mut flags = LimitFlags::default();
    if !gate.enabled {
        flags.set(LimitFlags::DISABLED);
    }
    if gate.late {
        flags.set(LimitFlags::LATE);
    }
    if !gate.connected {
        flags.set(LimitFlags::DISCONNECTED);
    }
    if !wanted_n.is_finite() {
        flags.set(LimitFlags::NOT_FINITE);
    }
    if !flags.is_empty() {
        return (Vec3::ZERO, flags);
    }
    let mut force_n = wanted_n;
    let rated_n = limits.rated_force_n.max(0.0);
    if force_n.length() > rated_n {
        flags.set(LimitFlags::RATED);
        force_n = scaled_to(force_n, rated_n);
    }
    let most_n = last_n.length() + limits.rise_n_per_s.max(0.0) * dt_s.max(0.0);
    if force_n.length() > most_n {
        flags.set(LimitFlags::RISE);
        force_n = scaled_to(force_n, most_n);
    }
    (force_n, flags)
}

/// `v` shortened to `length`. Divides by the largest component first, so that no square overflows.
fn scaled_to(v: Vec3, length: f64) -> Vec3 {
    let largest = v.abs().max_element();
    let v = v / largest;
    let scaled = v * (length / v.length());
    if scaled.is_finite() {
        scaled
    } else {
        Vec3::ZERO
    }
}
