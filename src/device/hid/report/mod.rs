//! What goes over the wire, byte by byte: pure functions, both ends of each, so that an emulator speaks the same.
//!
//! Numbers are little-endian and signed, 16 bits, unless said otherwise. A report that is not of the right length decodes
//! to `None`; nothing here panics, whatever the bytes.

pub mod descriptor;
pub mod polhem;
pub mod spacemouse;
pub mod teensy;
pub mod wooden;

/// The number at byte `at`, or `None` past the end.
fn word(bytes: &[u8], at: usize) -> Option<i16> {
    let pair = bytes.get(at..at + 2)?;
    Some(i16::from_le_bytes([pair[0], pair[1]]))
}

/// Numbers one after the other, as many as `N`.
fn words<const N: usize>(bytes: &[u8]) -> Option<[i16; N]> {
    let mut out = [0; N];
    for (i, w) in out.iter_mut().enumerate() {
        *w = word(bytes, 2 * i)?;
    }
    Some(out)
}

fn put(out: &mut [u8], numbers: &[i16]) {
    for (pair, n) in out.chunks_exact_mut(2).zip(numbers) {
        pair.copy_from_slice(&n.to_le_bytes());
    }
}

/// Whole milliampere of a current in A, brought within ±`most_ma`. What is no number is no current.
pub fn milliampere(current_a: f64, most_ma: i16) -> i16 {
    let most = f64::from(most_ma.max(0));
    let ma = libm::round(current_a * 1000.0).clamp(-most, most);
    // NaN passes through the clamp and is cast to 0.
    ma as i16
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_current_of_any_kind_stays_within_its_bound(a in prop::num::f64::ANY, most in 0_i16..=i16::MAX) {
            let ma = milliampere(a, most);
            prop_assert!(ma.unsigned_abs() <= most.unsigned_abs());
            if a.is_nan() { prop_assert_eq!(ma, 0); }
        }
    }

    #[test]
    fn a_current_is_rounded_to_a_milliampere() {
        assert_eq!(milliampere(0.0126, 3000), 13);
        assert_eq!(milliampere(-0.0126, 3000), -13);
        assert_eq!(milliampere(f64::INFINITY, 3000), 3000);
        assert_eq!(milliampere(-9.0, 3000), -3000);
    }
}
