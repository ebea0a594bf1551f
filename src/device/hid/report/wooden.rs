//! WoodenHaptics, first board: HID 1234:0006, 8 bytes each way, no report id.
//!
//! | bytes | device to host | host to device |
//! |---|---|---|
//! | 0–1 | encoder a, counts | motor a, mA |
//! | 2–3 | encoder b | motor b |
//! | 4–5 | encoder c | motor c |
//! | 6–7 | counter | counter |
//!
//! What is written begins with one byte more, the report id 0. The amplifiers go off by themselves after
//! [`AMPLIFIERS_OFF_S`] without a report.

use super::{milliampere, put, words};

/// Vendor and product.
pub const IDS: (u16, u16) = (0x1234, 0x0006);
/// HID usage page of its collection.
pub const USAGE_PAGE: u16 = 0xFFAB;
/// HID usage of its collection.
pub const USAGE: u16 = 0x0200;
/// Bytes read.
pub const IN_BYTES: usize = 8;
/// Bytes written, report id included.
pub const OUT_BYTES: usize = 9;
/// Largest current that is ever sent, mA.
pub const MOST_MA: i16 = 3000;
/// The amplifiers go off after this long without a report, s.
pub const AMPLIFIERS_OFF_S: f64 = 0.5;

/// Device to host.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct In {
    /// Encoders a, b, c, counts as the board has them.
    pub encoders: [i16; 3],
    /// Counts reports.
    pub counter: i16,
}

impl In {
    /// The report in `bytes`; `None` if it is not 8 bytes long.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        if bytes.len() != IN_BYTES {
            return None;
        }
        let [a, b, c, counter] = words(bytes)?;
        Some(Self {
            encoders: [a, b, c],
            counter,
        })
    }

    /// Its bytes.
    pub fn encode(&self) -> [u8; IN_BYTES] {
        let [a, b, c] = self.encoders;
        let mut out = [0; IN_BYTES];
        put(&mut out, &[a, b, c, self.counter]);
        out
    }
}

/// Host to device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Out {
    /// Motors a, b, c, mA, within ±[`MOST_MA`].
    pub current_ma: [i16; 3],
    /// Counts reports.
    pub counter: i16,
}

impl Out {
    /// A report with these currents, A; each is brought within ±[`MOST_MA`].
    pub fn new(currents_a: [f64; 3], counter: i16) -> Self {
        Self {
            current_ma: currents_a.map(|a| milliampere(a, MOST_MA)),
            counter,
        }
    }

    /// Its bytes, the report id first.
    pub fn encode(&self) -> [u8; OUT_BYTES] {
        let [a, b, c] = self.current_ma;
        let mut out = [0; OUT_BYTES];
        put(&mut out[1..], &[a, b, c, self.counter]);
        out
    }

    /// The report in `bytes`, as the board reads them; `None` if the length or the report id is wrong.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        if bytes.len() != OUT_BYTES || bytes[0] != 0 {
            return None;
        }
        let [a, b, c, counter] = words(&bytes[1..])?;
        Some(Self {
            current_ma: [a, b, c],
            counter,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn bytes_stand_where_the_board_has_them() {
        let report = In::decode(&[0x01, 0x02, 0xFE, 0xFF, 0x00, 0x80, 0x2A, 0x00]);
        let expected = In {
            encoders: [0x0201, -2, i16::MIN],
            counter: 42,
        };
        assert_eq!(report, Some(expected));
        let out = Out::new([0.258, -0.001, 9.0], 7);
        assert_eq!(out.encode(), [0, 0x02, 0x01, 0xFF, 0xFF, 0xB8, 0x0B, 7, 0]);
    }

    proptest! {
        #[test]
        fn reports_come_back_as_they_went(e in prop::array::uniform3(any::<i16>()), counter: i16) {
            let report = In { encoders: e, counter };
            prop_assert_eq!(In::decode(&report.encode()), Some(report));
            let out = Out { current_ma: e, counter };
            prop_assert_eq!(Out::decode(&out.encode()), Some(out));
        }

        #[test]
        fn any_bytes_decode_only_at_the_right_length(bytes in prop::collection::vec(any::<u8>(), 0..80)) {
            prop_assert_eq!(In::decode(&bytes).is_some(), bytes.len() == IN_BYTES);
            prop_assert_eq!(Out::decode(&bytes).is_some(), bytes.len() == OUT_BYTES && bytes[0] == 0);
        }

        #[test]
        fn no_current_leaves_the_range(a in prop::array::uniform3(prop::num::f64::ANY)) {
            prop_assert!(Out::new(a, 0).current_ma.iter().all(|ma| ma.abs() <= MOST_MA));
        }
    }
}
