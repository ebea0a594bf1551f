//! Devices behind their makers' software: libraries, which are loaded at run time where they are installed and never linked,
//! and services.
//!
//! That software stands in for the wire: what it says of a device goes through the same guard, thread and counts as what a
//! HID device says ([`Linked`]). Only the two files that call libraries hold unsafe code.

pub mod force_dimension;
pub mod haply;
pub mod openhaptics;

use crate::device::hid::link::{Driver, Linked, Seen};
use crate::device::hid::transport::{Port, REPORT};
use crate::device::mapped::Mapped;
use crate::device::{Calibration, Capabilities, DeviceError};
use crate::geom::Vec3;

/// What a library says of a device at once, in the device's own frame of the house: x towards the user, y to the user's
/// right, z up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Told {
    /// Place, mm.
    pub position_mm: Vec3,
    /// Pressed buttons, bit by bit.
    pub buttons: u32,
    /// Counts what it said.
    pub number: u16,
}

/// Bytes of [`Told`].
const TOLD: usize = 3 * 8 + 4 + 2;

impl Told {
    /// Its bytes.
    fn encode(&self, out: &mut [u8; REPORT]) -> usize {
        put(out, self.position_mm);
        out[24..28].copy_from_slice(&self.buttons.to_le_bytes());
        out[28..30].copy_from_slice(&self.number.to_le_bytes());
        TOLD
    }

    fn decode(bytes: &[u8]) -> Option<Self> {
        if bytes.len() != TOLD {
            return None;
        }
        Some(Self {
            position_mm: vector(bytes)?,
            buttons: u32::from_le_bytes(bytes[24..28].try_into().ok()?),
            number: u16::from_le_bytes(bytes[28..30].try_into().ok()?),
        })
    }
}

fn put(out: &mut [u8; REPORT], v: Vec3) {
    for (to, x) in out.chunks_exact_mut(8).zip(v.to_array()) {
        to.copy_from_slice(&x.to_le_bytes());
    }
}

/// The vector at the start of `bytes`.
fn vector(bytes: &[u8]) -> Option<Vec3> {
    let x = |i: usize| {
        Some(f64::from_le_bytes(
            bytes.get(8 * i..8 * i + 8)?.try_into().ok()?,
        ))
    };
    Some(Vec3::new(x(0)?, x(1)?, x(2)?))
}

/// The force that a report to a library asks for, N: nothing for what is none.
fn force_n(report: &[u8]) -> Vec3 {
    vector(report)
        .filter(|f| f.is_finite())
        .unwrap_or(Vec3::ZERO)
}

/// A device that speaks for itself: place in, force out.
#[derive(Debug, Default)]
struct Spoken {
    told: Told,
}

impl Driver for Spoken {
    fn take(&mut self, report: &[u8]) -> bool {
        let Some(told) = Told::decode(report) else {
            return false;
        };
        self.told = told;
        true
    }

    fn seen(&self) -> Seen {
        // Micrometres: what stands still to the micrometre is what a frozen device says.
        let um = (self.told.position_mm * 1000.0).to_array();
        let [x, y, z] = um.map(|x| libm::round(x) as i32);
        Seen {
            position_mm: self.told.position_mm,
            buttons: self.told.buttons,
            raw: [x, y, z, 0, 0, 0],
            counter: Some(self.told.number),
        }
    }

    fn render(&mut self, force_n: Option<Vec3>, out: &mut [u8; REPORT]) -> (usize, [i32; 3]) {
        put(out, force_n.unwrap_or(Vec3::ZERO));
        (24, [0; 3])
    }
}

/// Speaks with the device behind `port`.
fn link(
    capabilities: Capabilities,
    port: Box<dyn Port>,
    calibration: &Calibration,
) -> Result<Mapped<Linked>, DeviceError> {
    let driver = Box::<Spoken>::default();
    let linked = Linked::start(capabilities, port, driver, calibration)?;
    Ok(Mapped::new(linked, calibration.mapping))
}

/// The error of a library that is not there, or not what it should be.
fn not_loaded(title: &str, names: &[&str], why: &impl std::fmt::Display) -> DeviceError {
    DeviceError::new(format!(
        "{title} is not installed: none of {} can be loaded ({why})",
        names.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_told_comes_back_as_it_went(p in prop::array::uniform3(-1e3..1e3_f64), buttons: u32, number: u16) {
            let told = Told { position_mm: Vec3::from(p), buttons, number };
            let mut out = [0; REPORT];
            let n = told.encode(&mut out);
            prop_assert_eq!(Told::decode(&out[..n]), Some(told));
            prop_assert_eq!(Told::decode(&out[..n - 1]), None);
        }

        #[test]
        fn no_bytes_ask_for_a_force_that_is_none(bytes in prop::collection::vec(any::<u8>(), 0..40)) {
            prop_assert!(force_n(&bytes).is_finite());
        }
    }

    #[test]
    fn a_force_goes_out_as_it_came() {
        let mut out = [0; REPORT];
        let (n, _) = Spoken::default().render(Some(Vec3::new(1.0, -2.0, 3.0)), &mut out);
        assert_eq!(force_n(&out[..n]), Vec3::new(1.0, -2.0, 3.0));
        let (n, _) = Spoken::default().render(None, &mut out);
        assert_eq!(force_n(&out[..n]), Vec3::ZERO);
    }
}
