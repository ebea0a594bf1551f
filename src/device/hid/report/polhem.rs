//! Polhem and WoodenHaptics with the newer board: the same HID 1234:0006 as the first, told from it by the length, 14 bytes.
//!
//! | bytes | device to host | host to device |
//! |---|---|---|
//! | 0–1, 2–3, 4–5 | encoders a, b, c, counts | motors a, b, c, mA |
//! | 6–7, 8–9, 10–11 | encoders d, e, f of the wrist | command, attributes 0, 1 |
//! | 12–13 | info: 1 = asks to be calibrated | attribute 2 |
//!
//! What is written begins with the report id 0. The host must send first: the board answers what it hears. A button on the
//! wrist is folded into encoder d: above [`FOLD_ABOVE`] it is pressed, and [`FOLD`] is to be taken off.

use super::{milliampere, put, words};

/// Bytes read.
pub const IN_BYTES: usize = 14;
/// Bytes written, report id included.
pub const OUT_BYTES: usize = 15;
/// Largest current that is ever sent, mA.
pub const MOST_MA: i16 = 6000;
/// Above this the count of encoder d holds the button.
pub const FOLD_ABOVE: i16 = 5000;
/// What the pressed button adds to encoder d.
pub const FOLD: i16 = 10_000;
/// What the device says in `info` when it wants to be calibrated.
pub const ASKS_TO_BE_CALIBRATED: i16 = 1;

/// Device to host.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct In {
    /// Encoders a to f, counts, the button taken out of d.
    pub encoders: [i16; 6],
    /// Whether the button is pressed.
    pub pressed: bool,
    /// What the device asks for.
    pub info: i16,
}

impl In {
    /// The report in `bytes`; `None` if it is not 14 bytes long.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        if bytes.len() == IN_BYTES {
            Self::decode_payload(bytes)
        } else {
            None
        }
    }

    /// The report at the start of `bytes`; `None` if they are fewer than 14.
    pub(super) fn decode_payload(bytes: &[u8]) -> Option<Self> {
        let [a, b, c, d, e, f, info] = words(bytes)?;
        let pressed = d > FOLD_ABOVE;
        let d = if pressed { d - FOLD } else { d };
        Some(Self {
            encoders: [a, b, c, d, e, f],
            pressed,
            info,
        })
    }

    /// Its bytes. Encoder d is brought within what leaves room for the button, −5000 to 5000.
    pub fn encode(&self) -> [u8; IN_BYTES] {
        let [a, b, c, d, e, f] = self.encoders;
        // Pressed, d must come out above the bound: −4999 is the least that does.
        let d = d.clamp(1 - FOLD_ABOVE, FOLD_ABOVE) + if self.pressed { FOLD } else { 0 };
        let mut out = [0; IN_BYTES];
        put(&mut out, &[a, b, c, d, e, f, self.info]);
        out
    }
}

/// Host to device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Out {
    /// Currents of motors a, b, c, mA, within ±[`MOST_MA`].
    Currents([i16; 3]),
    /// Encoders a to f stand at these counts now; no current flows.
    Preset([i16; 6]),
}

impl Out {
    /// A report with these currents, A; each is brought within ±[`MOST_MA`].
    pub fn currents(currents_a: [f64; 3]) -> Self {
        Self::Currents(currents_a.map(|a| milliampere(a, MOST_MA)))
    }

    /// Its bytes, the report id first.
    pub fn encode(&self) -> [u8; OUT_BYTES] {
        let mut out = [0; OUT_BYTES];
        let numbers = match *self {
            Self::Currents([a, b, c]) => [a, b, c, 0, 0, 0, 0],
            // The attributes hold a, b, c; d, e, f ride where currents would be.
            Self::Preset([a, b, c, d, e, f]) => [d, e, f, 1, a, b, c],
        };
        put(&mut out[1..], &numbers);
        out
    }

    /// The report in `bytes`, as the board reads them; `None` if length, report id or command is wrong.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        if bytes.len() != OUT_BYTES || bytes[0] != 0 {
            return None;
        }
        Self::decode_payload(&bytes[1..])
    }

    /// The report at the start of `bytes`, which hold no report id.
    pub(super) fn decode_payload(bytes: &[u8]) -> Option<Self> {
        let [a, b, c, command, p, q, r] = words(bytes)?;
        match command {
            0 => Some(Self::Currents([a, b, c])),
            1 => Some(Self::Preset([p, q, r, a, b, c])),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn bytes_stand_where_the_board_has_them() {
        let bytes = [1, 0, 2, 0, 3, 0, 0x0F, 0x27, 5, 0, 6, 0, 1, 0];
        let report = In::decode(&bytes).expect("14 bytes");
        // 0x270F = 9999: pressed, at −1.
        assert_eq!(report.encoders, [1, 2, 3, -1, 5, 6]);
        assert!(report.pressed);
        assert_eq!(report.info, ASKS_TO_BE_CALIBRATED);
        let out = Out::currents([1.0, -1.0, 7.0]);
        let expected = [0, 0xE8, 3, 0x18, 0xFC, 0x70, 0x17, 0, 0, 0, 0, 0, 0, 0, 0];
        assert_eq!(out.encode(), expected);
        let preset = Out::Preset([1, 2, 3, 4, 5, 6]);
        let expected = [0, 4, 0, 5, 0, 6, 0, 1, 0, 1, 0, 2, 0, 3, 0];
        assert_eq!(preset.encode(), expected);
    }

    proptest! {
        #[test]
        fn reports_come_back_as_they_went(
            mut encoders in prop::array::uniform6(any::<i16>()), d in -4999_i16..=5000, pressed: bool, info: i16,
        ) {
            encoders[3] = d;
            let report = In { encoders, pressed, info };
            prop_assert_eq!(In::decode(&report.encode()), Some(report));
            let [a, b, c, ..] = encoders;
            for out in [Out::Currents([a, b, c]), Out::Preset(encoders)] {
                prop_assert_eq!(Out::decode(&out.encode()), Some(out));
            }
        }

        #[test]
        fn any_bytes_decode_only_at_the_right_length(bytes in prop::collection::vec(any::<u8>(), 0..80)) {
            prop_assert_eq!(In::decode(&bytes).is_some(), bytes.len() == IN_BYTES);
            prop_assert!(Out::decode(&bytes).is_none() || bytes.len() == OUT_BYTES);
        }

        #[test]
        fn no_current_leaves_the_range(a in prop::array::uniform3(prop::num::f64::ANY)) {
            let Out::Currents(ma) = Out::currents(a) else { panic!("currents") };
            prop_assert!(ma.iter().all(|ma| ma.abs() <= MOST_MA));
        }
    }
}
