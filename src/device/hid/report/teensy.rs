//! Polhem and others with a Teensy board: HID 16C0:0486, 64 bytes read, 65 written, of which the first 14 after the report
//! id count. What stands in them is [`polhem`]'s.
//!
//! The board sends currents of zero to its motors if it heard nothing for [`ZERO_AFTER_S`].

use super::polhem;

/// Vendor and product.
pub const IDS: (u16, u16) = (0x16C0, 0x0486);
/// Bytes read.
pub const IN_BYTES: usize = 64;
/// Bytes written, report id included.
pub const OUT_BYTES: usize = 65;
/// Without a report for this long the board takes the currents off, s.
pub const ZERO_AFTER_S: f64 = 0.010;

/// The report in `bytes`; `None` if it is not 64 bytes long.
pub fn decode(bytes: &[u8]) -> Option<polhem::In> {
    if bytes.len() == IN_BYTES {
        polhem::In::decode_payload(bytes)
    } else {
        None
    }
}

/// The bytes of a report of the device.
pub fn encode(report: &polhem::In) -> [u8; IN_BYTES] {
    let mut out = [0; IN_BYTES];
    out[..polhem::IN_BYTES].copy_from_slice(&report.encode());
    out
}

/// The bytes of a report to the device, the report id first.
pub fn encode_out(report: &polhem::Out) -> [u8; OUT_BYTES] {
    let mut out = [0; OUT_BYTES];
    out[..polhem::OUT_BYTES].copy_from_slice(&report.encode());
    out
}

/// The report to the device in `bytes`; `None` if length, report id or command is wrong.
pub fn decode_out(bytes: &[u8]) -> Option<polhem::Out> {
    if bytes.len() != OUT_BYTES || bytes[0] != 0 {
        return None;
    }
    polhem::Out::decode_payload(&bytes[1..])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_button_is_folded_into_encoder_d() {
        let mut bytes = [0; IN_BYTES];
        for (d, expected) in [
            (5000_i16, (5000, false)),
            (5001, (-4999, true)),
            (10_123, (123, true)),
        ] {
            bytes[6..8].copy_from_slice(&d.to_le_bytes());
            let report = decode(&bytes).expect("64 bytes");
            assert_eq!((report.encoders[3], report.pressed), expected);
        }
    }

    proptest! {
        #[test]
        fn reports_come_back_as_they_went(
            mut encoders in prop::array::uniform6(any::<i16>()), d in -4999_i16..=5000, pressed: bool, info: i16,
        ) {
            encoders[3] = d;
            let report = polhem::In { encoders, pressed, info };
            prop_assert_eq!(decode(&encode(&report)), Some(report));
            let [a, b, c, ..] = encoders;
            for out in [polhem::Out::Currents([a, b, c]), polhem::Out::Preset(encoders)] {
                prop_assert_eq!(decode_out(&encode_out(&out)), Some(out));
            }
        }

        #[test]
        fn any_bytes_decode_only_at_the_right_length(bytes in prop::collection::vec(any::<u8>(), 0..80)) {
            prop_assert_eq!(decode(&bytes).is_some(), bytes.len() == IN_BYTES);
            prop_assert!(decode_out(&bytes).is_none() || bytes.len() == OUT_BYTES);
        }
    }
}
