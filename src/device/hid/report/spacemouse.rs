//! SpaceMouse and its kin: a cap on springs that tells six deflections.
//!
//! | first byte | what follows |
//! |---|---|
//! | 1 | x, y, z; newer devices all six, x, y, z, rx, ry, rz, in one report of 13 bytes |
//! | 2 | rx, ry, rz |
//! | 3 | buttons, bit by bit, 1 to 6 bytes |
//! | 4 | to the device: lamp on (1) or off (0) |
//! | 23 | charge of the battery, per cent |
//!
//! Axes as the device has them: x to the right, y towards the user, z down; full deflection is ±[`FULL`].

use super::words;

/// Vendor and product of the devices known to speak this.
pub const IDS: [(u16, u16); 12] = [
    (0x046D, 0xC603),
    (0x046D, 0xC623),
    (0x046D, 0xC625),
    (0x046D, 0xC626),
    (0x046D, 0xC627),
    (0x046D, 0xC628),
    (0x046D, 0xC629),
    (0x046D, 0xC62B),
    (0x256F, 0xC62E),
    (0x256F, 0xC62F),
    (0x256F, 0xC633),
    (0x256F, 0xC635),
];
/// Full deflection.
pub const FULL: i16 = 350;

/// One report of the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum In {
    /// x, y, z.
    Shift([i16; 3]),
    /// rx, ry, rz.
    Turn([i16; 3]),
    /// All six.
    Both([i16; 3], [i16; 3]),
    /// Pressed buttons, bit by bit.
    Buttons(u32),
    /// Charge, per cent.
    Battery(u8),
}

impl In {
    /// The report in `bytes`; `None` if it is none of these. Deflections are brought within ±[`FULL`].
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        let (&id, rest) = bytes.split_first()?;
        let clamped = |w: [i16; 3]| w.map(|x| x.clamp(-FULL, FULL));
        match id {
            1 if rest.len() >= 12 => {
                let [x, y, z, rx, ry, rz] = words(rest)?;
                Some(Self::Both(clamped([x, y, z]), clamped([rx, ry, rz])))
            }
            1 => Some(Self::Shift(clamped(words(rest)?))),
            2 => Some(Self::Turn(clamped(words(rest)?))),
            3 if !rest.is_empty() => {
                let low = rest.iter().take(4).enumerate();
                Some(Self::Buttons(
                    low.fold(0, |sum, (i, &b)| sum | u32::from(b) << (8 * i)),
                ))
            }
            23 => rest.first().map(|&charge| Self::Battery(charge.min(100))),
            _ => None,
        }
    }

    /// Writes its bytes into `out`; how many they are.
    pub fn encode(&self, out: &mut [u8; 13]) -> usize {
        let mut numbers = |id: u8, w: &[i16]| {
            out[0] = id;
            super::put(&mut out[1..=2 * w.len()], w);
            1 + 2 * w.len()
        };
        match *self {
            Self::Shift(w) => numbers(1, &w),
            Self::Turn(w) => numbers(2, &w),
            Self::Both([x, y, z], [rx, ry, rz]) => numbers(1, &[x, y, z, rx, ry, rz]),
            Self::Buttons(bits) => {
                out[0] = 3;
                out[1..5].copy_from_slice(&bits.to_le_bytes());
                5
            }
            Self::Battery(charge) => {
                (out[0], out[1]) = (23, charge);
                2
            }
        }
    }
}

/// The report that switches the lamp.
pub fn lamp(on: bool) -> [u8; 2] {
    [4, u8::from(on)]
}

/// What the device has told so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct State {
    /// x, y, z.
    pub shift: [i16; 3],
    /// rx, ry, rz.
    pub turn: [i16; 3],
    /// Pressed buttons, bit by bit.
    pub buttons: u32,
    /// Charge, per cent; `None` for a device with a cable.
    pub battery_percent: Option<u8>,
}

impl State {
    /// Takes a report in.
    pub fn take(&mut self, report: In) {
        match report {
            In::Shift(w) => self.shift = w,
            In::Turn(w) => self.turn = w,
            In::Both(shift, turn) => (self.shift, self.turn) = (shift, turn),
            In::Buttons(bits) => self.buttons = bits,
            In::Battery(charge) => self.battery_percent = Some(charge),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn both_layouts_tell_the_same() {
        let (mut old, mut new) = (State::default(), State::default());
        old.take(In::decode(&[1, 10, 0, 0xF6, 0xFF, 0x5E, 1]).expect("shift"));
        old.take(In::decode(&[2, 1, 0, 2, 0, 3, 0]).expect("turn"));
        new.take(In::decode(&[1, 10, 0, 0xF6, 0xFF, 0x5E, 1, 1, 0, 2, 0, 3, 0]).expect("both"));
        assert_eq!(old, new);
        assert_eq!((old.shift, old.turn), ([10, -10, 350], [1, 2, 3]));
    }

    #[test]
    fn buttons_battery_and_lamp() {
        assert_eq!(In::decode(&[3, 2]), Some(In::Buttons(2)));
        assert_eq!(
            In::decode(&[3, 1, 0, 0, 0x80, 9, 9]),
            Some(In::Buttons(0x8000_0001))
        );
        assert_eq!(In::decode(&[23, 87, 0]), Some(In::Battery(87)));
        assert_eq!(lamp(true), [4, 1]);
        assert_eq!(In::decode(&[3]), None);
        assert_eq!(In::decode(&[1, 0, 0, 0]), None);
        assert_eq!(In::decode(&[]), None);
    }

    proptest! {
        #[test]
        fn reports_come_back_as_they_went(
            shift in prop::array::uniform3(-FULL..=FULL), turn in prop::array::uniform3(-FULL..=FULL),
            bits: u32, charge in 0_u8..=100,
        ) {
            for report in [In::Shift(shift), In::Turn(turn), In::Both(shift, turn), In::Buttons(bits), In::Battery(charge)] {
                let mut bytes = [0; 13];
                let n = report.encode(&mut bytes);
                prop_assert_eq!(In::decode(&bytes[..n]), Some(report));
            }
        }

        #[test]
        fn any_bytes_are_a_report_within_the_range_or_none(bytes in prop::collection::vec(any::<u8>(), 0..80)) {
            if let Some(In::Shift(w) | In::Turn(w) | In::Both(w, _)) = In::decode(&bytes) {
                prop_assert!(w.iter().all(|x| x.abs() <= FULL));
            }
        }
    }
}
