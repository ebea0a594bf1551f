//! The arm behind each of its protocols.

use super::arm::{Arm, Gravity};
use super::link::{Driver, Seen};
use super::report::{polhem, teensy, wooden};
use super::transport::REPORT;
use crate::geom::Vec3;

/// Which reports a board speaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Protocol {
    /// 8 bytes.
    Wooden,
    /// 14 bytes.
    Polhem,
    /// 64 bytes.
    Teensy,
}

impl Protocol {
    /// Bytes that it reads.
    pub fn in_bytes(self) -> usize {
        match self {
            Self::Wooden => wooden::IN_BYTES,
            Self::Polhem => polhem::IN_BYTES,
            Self::Teensy => teensy::IN_BYTES,
        }
    }

    /// Buttons that it tells.
    pub fn n_buttons(self) -> u8 {
        match self {
            Self::Wooden => 0,
            Self::Polhem | Self::Teensy => 1,
        }
    }

    /// After how long without a report the board itself takes the currents off, s; `None` where nobody says.
    pub fn board_watchdog_s(self) -> Option<f64> {
        match self {
            Self::Wooden => Some(wooden::AMPLIFIERS_OFF_S),
            Self::Polhem => None,
            Self::Teensy => Some(teensy::ZERO_AFTER_S),
        }
    }
}

/// An arm: encoders in, currents out.
#[derive(Clone, Debug)]
pub struct ArmDriver {
    protocol: Protocol,
    arm: Arm,
    gravity: Option<Gravity>,
    /// Share of its weight that is held up.
    held: f64,
    /// Counts beyond what 16 bits hold.
    encoders: [i32; 3],
    last: Option<[i16; 3]>,
    seen: Seen,
    out_counter: i16,
}

impl ArmDriver {
    /// An arm that has heard nothing.
    pub fn new(protocol: Protocol, arm: Arm, gravity: Option<Gravity>) -> Self {
        Self {
            protocol,
            arm,
            gravity,
            held: 1.0,
            encoders: [0; 3],
            last: None,
            seen: Seen::default(),
            out_counter: 0,
        }
    }

    fn decode(&self, report: &[u8]) -> Option<([i16; 6], u32, Option<u16>)> {
        let wrist = |r: polhem::In| (r.encoders, u32::from(r.pressed), None);
        match self.protocol {
            Protocol::Wooden => wooden::In::decode(report).map(|r| {
                let [a, b, c] = r.encoders;
                ([a, b, c, 0, 0, 0], 0, Some(r.counter as u16))
            }),
            Protocol::Polhem => polhem::In::decode(report).map(wrist),
            Protocol::Teensy => teensy::decode(report).map(wrist),
        }
    }
}

impl Driver for ArmDriver {
    fn take(&mut self, report: &[u8]) -> bool {
        let Some((raw, buttons, counter)) = self.decode(report) else {
            return false;
        };
        let [a, b, c, ..] = raw;
        let now = [a, b, c];
        let before = self.last.replace(now);
        for (i, count) in self.encoders.iter_mut().enumerate() {
            *count = match before {
                // The short way round: 16 bits wrap.
                Some(before) => count.wrapping_add(i32::from(now[i].wrapping_sub(before[i]))),
                None => i32::from(now[i]),
            };
        }
        self.seen = Seen {
            position_mm: self.arm.position_mm(self.arm.angles_rad(self.encoders)),
            buttons,
            raw: raw.map(i32::from),
            counter,
        };
        true
    }

    fn seen(&self) -> Seen {
        self.seen
    }

    fn hold(&mut self, share: f64) {
        self.held = share;
    }

    fn render(&mut self, force_n: Option<Vec3>, out: &mut [u8; REPORT]) -> (usize, [i32; 3]) {
        let mut currents_a = [0.0; 3];
        if let (Some(force_n), Some(_)) = (force_n, self.last) {
            let angles = self.arm.angles_rad(self.encoders);
            let mut torques = self.arm.torques_n_mm(angles, force_n);
            if let Some(gravity) = &self.gravity {
                let held = gravity.torques_n_mm(&self.arm, angles);
                torques = std::array::from_fn(|i| torques[i] + held[i] * self.held);
            }
            currents_a = self.arm.currents_a(torques).a;
        }
        let mut put = |bytes: &[u8]| {
            out[..bytes.len()].copy_from_slice(bytes);
            bytes.len()
        };
        let polhem_out = polhem::Out::currents(currents_a);
        let polhem_ma = match polhem_out {
            polhem::Out::Currents(ma) => ma.map(i32::from),
            polhem::Out::Preset(_) => [0; 3],
        };
        match self.protocol {
            Protocol::Wooden => {
                self.out_counter = self.out_counter.wrapping_add(1);
                let report = wooden::Out::new(currents_a, self.out_counter);
                (put(&report.encode()), report.current_ma.map(i32::from))
            }
            Protocol::Polhem => (put(&polhem_out.encode()), polhem_ma),
            Protocol::Teensy => (put(&teensy::encode_out(&polhem_out)), polhem_ma),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::hid::models::ARMS;

    fn driver() -> ArmDriver {
        ArmDriver::new(Protocol::Wooden, ARMS[0].arm(), None)
    }

    fn report(encoders: [i16; 3]) -> [u8; 8] {
        wooden::In {
            encoders,
            counter: 0,
        }
        .encode()
    }

    #[test]
    fn counts_go_on_where_sixteen_bits_wrap() {
        let mut d = driver();
        assert!(d.take(&report([32_000, 0, -32_000])));
        assert!(d.take(&report([-32_536, 0, 32_536])));
        assert_eq!(d.encoders, [33_000, 0, -33_000]);
    }

    #[test]
    fn nothing_heard_or_nothing_wanted_is_no_current() {
        let mut out = [0; REPORT];
        let mut d = driver();
        assert_eq!(d.render(Some(Vec3::Z), &mut out), (9, [0; 3]));
        assert!(!d.take(&[0; 7]) && !d.take(&[0; 14]));
        assert!(d.take(&report([0, 1000, 6000])));
        assert_ne!(d.render(Some(Vec3::Z), &mut out).1, [0; 3]);
        d.gravity = Some(ARMS[0].gravity);
        assert_ne!(d.render(Some(Vec3::ZERO), &mut out).1, [0; 3]);
        assert_eq!(d.render(None, &mut out).1, [0; 3]);
    }

    #[test]
    fn weight_is_held_up_by_the_share_that_is_wanted() {
        let mut out = [0; REPORT];
        let mut d = driver();
        d.gravity = Some(ARMS[0].gravity);
        assert!(d.take(&report([0, 1000, 6000])));
        let mut held = |share| {
            d.hold(share);
            d.render(Some(Vec3::ZERO), &mut out).1
        };
        let (none, half, whole) = (held(0.0), held(0.5), held(1.0));
        assert_eq!(none, [0; 3]);
        for i in 0..3 {
            assert!((2 * half[i] - whole[i]).abs() <= 2, "{half:?} {whole:?}");
        }
    }
}
