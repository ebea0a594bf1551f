//! The last step before the device: whatever comes in, what goes out is finite, within the rated force, and does not
//! rise faster than allowed.

use super::stiffness::StiffnessBound;
use crate::device::Capabilities;
use crate::geom::Vec3;

/// Bounds on the force sent to one device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Highest force, N.
    pub rated_force_n: f64,
    /// Fastest rise of force, N/s. Falling is not limited: letting go is always safe.
    pub rise_n_per_s: f64,
    /// Whether the skin may give out no more energy than the finger has put in: [`passivity`](super::passivity).
    pub passivity: bool,
    /// How stiff the skin may be rendered.
    pub stiffness: StiffnessBound,
}

impl Default for Limits {
    /// The rated force of a PHANToM Premium 3.0 (METHOD 7), reached from zero in 5 ms at the earliest.
    fn default() -> Self {
        Self {
            rated_force_n: 22.0,
            rise_n_per_s: 22.0 / 0.005,
            passivity: false,
            stiffness: StiffnessBound::AsIs,
        }
    }
}

impl Limits {
    /// The limits that go with a device: its rated force, reached from zero in 5 ms at the earliest.
    pub fn of(device: &Capabilities) -> Self {
        Self {
            rated_force_n: device.rated_force_n,
            rise_n_per_s: device.rated_force_n / 0.005,
            passivity: false,
            stiffness: StiffnessBound::AsIs,
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
    /// The passivity controller changed the force.
    pub const PASSIVITY: Self = Self(64);
    /// The skin was rendered softer than it is: [`Limits::stiffness`].
    pub const STIFFNESS: Self = Self(128);

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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const OPEN: Gate = Gate {
        enabled: true,
        late: false,
        connected: true,
    };
    const LIMITS: Limits = Limits {
        rated_force_n: 8.0,
        rise_n_per_s: 1000.0,
        passivity: false,
        stiffness: StiffnessBound::AsIs,
    };

    #[test]
    fn a_force_within_every_limit_passes_bit_for_bit() {
        let wanted = Vec3::new(0.1, -2.0, 3.3);
        assert_eq!(
            limit(wanted, Vec3::Z * 3.0, OPEN, &LIMITS, 0.001),
            (wanted, LimitFlags::default())
        );
    }

    #[test]
    fn rated_force_keeps_the_direction() {
        let (sent, flags) = limit(
            Vec3::new(30.0, 0.0, 40.0),
            Vec3::Z * 8.0,
            OPEN,
            &LIMITS,
            0.001,
        );
        assert!((sent - Vec3::new(4.8, 0.0, 6.4)).length() < 1e-12);
        assert_eq!(flags, LimitFlags::RATED);
    }

    #[test]
    fn force_rises_no_faster_than_allowed_and_falls_at_once() {
        let (sent, flags) = limit(Vec3::Z * 5.0, Vec3::ZERO, OPEN, &LIMITS, 0.001);
        assert!((sent.length() - 1.0).abs() < 1e-12 && flags == LimitFlags::RISE);
        assert_eq!(
            limit(Vec3::ZERO, Vec3::Z * 5.0, OPEN, &LIMITS, 0.001).0,
            Vec3::ZERO
        );
    }

    #[test]
    fn nothing_flows_through_a_shut_gate() {
        for (gate, flag) in [
            (
                Gate {
                    enabled: false,
                    ..OPEN
                },
                LimitFlags::DISABLED,
            ),
            (Gate { late: true, ..OPEN }, LimitFlags::LATE),
            (
                Gate {
                    connected: false,
                    ..OPEN
                },
                LimitFlags::DISCONNECTED,
            ),
        ] {
            assert_eq!(
                limit(Vec3::Z, Vec3::Z, gate, &LIMITS, 0.001),
                (Vec3::ZERO, flag)
            );
        }
    }

    proptest! {
        #[test]
        fn whatever_is_wanted_what_is_sent_is_finite_and_within_the_rated_force(
            wanted in prop::array::uniform3(prop::num::f64::ANY),
            last in prop::array::uniform3(-10.0..10.0_f64),
            rated in 0.0..30.0_f64,
            rise in 0.0..1e6_f64,
        ) {
            let limits = Limits { rated_force_n: rated, rise_n_per_s: rise, ..Limits::default() };
            let (sent, flags) = limit(Vec3::from(wanted), Vec3::from(last), OPEN, &limits, 0.001);
            prop_assert!(sent.is_finite());
            prop_assert!(sent.length() <= rated * (1.0 + 1e-12));
            prop_assert_eq!(flags.has(LimitFlags::NOT_FINITE), !Vec3::from(wanted).is_finite());
        }
    }
}
