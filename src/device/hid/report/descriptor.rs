//! How long a device's reports are, as its own HID descriptor says (HID 1.11, section 6.2.2).

/// Longest input report, bytes, report id not counted; `None` where the descriptor holds none or is cut off.
pub fn input_bytes(descriptor: &[u8]) -> Option<usize> {
    let (mut size, mut count, mut id) = (0_u32, 0_u32, 0_u32);
    // Bits of the input report of each id.
    let mut bits: Vec<(u32, u64)> = Vec::new();
    let mut rest = descriptor;
    while let Some((&prefix, after)) = rest.split_first() {
        if prefix == 0xFE {
            // A long item: its length is in the next byte, its tag in the one after.
            let n = usize::from(*after.first()?);
            rest = after.get(2 + n..)?;
            continue;
        }
        let n = [0, 1, 2, 4][usize::from(prefix & 3)];
        let data = after.get(..n)?;
        let value = data.iter().rev().fold(0_u32, |v, &b| v << 8 | u32::from(b));
        match prefix & 0xFC {
            0x74 => size = value,
            0x94 => count = value,
            0x84 => id = value,
            0x80 => {
                let more = u64::from(size) * u64::from(count);
                match bits.iter_mut().find(|(i, _)| *i == id) {
                    Some((_, sum)) => *sum = sum.saturating_add(more),
                    None => bits.push((id, more)),
                }
            }
            _ => {}
        }
        rest = &after[n..];
    }
    let longest = bits.iter().map(|(_, bits)| *bits).max()?;
    usize::try_from(longest.div_ceil(8)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Usage page FFAB, usage 0200, eight (or fourteen) bytes in and out.
    fn raw_hid(n: u8) -> Vec<u8> {
        vec![
            0x06, 0xAB, 0xFF, 0x0A, 0x00, 0x02, 0xA1, 0x01, 0x75, 0x08, 0x15, 0x00, 0x26, 0xFF,
            0x00, 0x95, n, 0x09, 0x01, 0x81, 0x02, 0x95, n, 0x09, 0x02, 0x91, 0x02, 0xC0,
        ]
    }

    #[test]
    fn the_boards_are_told_apart_by_their_descriptors() {
        assert_eq!(input_bytes(&raw_hid(8)), Some(8));
        assert_eq!(input_bytes(&raw_hid(14)), Some(14));
        assert_eq!(input_bytes(&raw_hid(64)), Some(64));
        assert_eq!(input_bytes(&[]), None);
        assert_eq!(input_bytes(&raw_hid(8)[..16]), None);
    }

    #[test]
    fn reports_with_ids_are_counted_apart() {
        let two = [
            0x75, 16, 0x95, 3, 0x85, 1, 0x81, 2, 0x85, 2, 0x81, 2, 0x85, 3, 0x95, 1, 0x81, 2,
        ];
        assert_eq!(input_bytes(&two), Some(6));
    }

    proptest! {
        #[test]
        fn any_bytes_are_a_length_or_none(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = input_bytes(&bytes);
        }
    }
}
