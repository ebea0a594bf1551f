//! The families of devices: one file each and one line in [`all`].

use super::calibration::CalibrationError;
use super::{Calibration, Capabilities, Device, hid, vendor};
use std::fmt;

/// How far a family was tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Proof {
    /// With the device itself.
    Hardware,
    /// With an emulator that speaks its protocol byte by byte; never with hardware.
    Emulator,
    /// With a stub of its maker's library that checks order and types of the calls; never with hardware.
    Stub,
    /// Not at all.
    Nothing,
}

impl Proof {
    /// For people.
    pub fn title(self) -> &'static str {
        match self {
            Self::Hardware => "with hardware",
            Self::Emulator => "with an emulator, never with hardware",
            Self::Stub => "against a stub, never with hardware",
            Self::Nothing => "not tested",
        }
    }
}

/// A device that is attached.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Found {
    /// Key of its family.
    pub family: &'static str,
    /// Where it is opened: a path, or a number of the maker's library. Names one device among those attached.
    pub place: String,
    /// What it calls itself.
    pub title: String,
    /// Its serial number, if it tells one that no other attached device of the family tells too.
    pub serial: Option<String>,
    /// What is amiss with it, in one line.
    pub note: Option<String>,
}

impl Found {
    /// Takes serial numbers away that more than one device tells: a calibration by serial number would go to either.
    pub fn tell_apart(found: &mut [Self]) {
        for i in 0..found.len() {
            let Some(serial) = found[i].serial.clone() else {
                continue;
            };
            let mut n = 0;
            for other in found
                .iter_mut()
                .filter(|f| f.serial.as_ref() == Some(&serial))
            {
                n += 1;
                if n > 1 {
                    other.serial = None;
                    other.note = Some(shared(&serial));
                }
            }
            if n > 1 {
                found[i].serial = None;
                found[i].note = Some(shared(&serial));
            }
        }
    }
}

fn shared(serial: &str) -> String {
    format!(
        "serial number {serial:?} is told by another device too; the calibration of the family is used"
    )
}

/// Why a device cannot be had: one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct DeviceError(String);

impl DeviceError {
    /// An error whose message is `message`; line breaks become spaces.
    pub fn new(message: impl fmt::Display) -> Self {
        let message = message.to_string();
        Self(message.split_whitespace().collect::<Vec<_>>().join(" "))
    }
}

impl From<CalibrationError> for DeviceError {
    fn from(e: CalibrationError) -> Self {
        Self::new(e)
    }
}

/// Devices that are found and opened the same way.
pub trait Family: Sync {
    /// Name on the command line and in device files.
    fn key(&self) -> &'static str;

    /// Name shown to people.
    fn title(&self) -> &'static str;

    /// What it is, in a sentence.
    fn about(&self) -> &'static str;

    /// How it is reached.
    fn reached(&self) -> &'static str;

    /// How far it was tested.
    fn proof(&self) -> Proof;

    /// What stands in for a device file.
    fn defaults(&self) -> Calibration;

    /// What a device of this family can do, calibrated so.
    fn capabilities(&self, calibration: &Calibration) -> Capabilities;

    /// Whether devices can be looked for on this machine at all.
    ///
    /// # Errors
    /// What is missing.
    fn ready(&self) -> Result<(), DeviceError>;

    /// Whether it may be looked for again and again while the program runs: not where looking loads a maker's library.
    fn may_be_watched(&self) -> bool {
        true
    }

    /// What is attached. Blocks for some milliseconds: not for the servo or the window.
    fn find(&self) -> Vec<Found>;

    /// Opens a device that was found.
    ///
    /// # Errors
    /// It is gone, may not be opened, or does not fit the calibration.
    fn open(
        &self,
        found: &Found,
        calibration: &Calibration,
    ) -> Result<Box<dyn Device>, DeviceError>;
}

/// Every family, in the order that people see them.
pub fn all() -> &'static [&'static dyn Family] {
    static ALL: [&dyn Family; 7] = [
        &hid::arms::WOODEN,
        &hid::arms::POLHEM,
        &hid::arms::TEENSY,
        &hid::spacemouse::FAMILY,
        &vendor::openhaptics::FAMILY,
        &vendor::force_dimension::FAMILY,
        &vendor::haply::FAMILY,
    ];
    &ALL
}

/// The family called `key`.
pub fn by_key(key: &str) -> Option<&'static dyn Family> {
    all().iter().copied().find(|f| f.key() == key)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(place: &str, serial: Option<&str>) -> Found {
        Found {
            family: "f",
            place: place.into(),
            title: "F".into(),
            serial: serial.map(Into::into),
            note: None,
        }
    }

    #[test]
    fn every_family_has_a_name_of_its_own_and_defaults_that_its_file_holds() {
        let mut keys: Vec<_> = all().iter().map(|f| f.key()).collect();
        let n = keys.len();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), n);
        for family in all() {
            let key = family.key();
            assert!(by_key(key).is_some());
            let defaults = family.defaults();
            let known = |k: &str| by_key(k).map(|f| f.defaults());
            let back = Calibration::parse(&defaults.to_toml(), key, known);
            assert_eq!(back.as_ref(), Ok(&defaults), "{key}");
            let c = family.capabilities(&defaults);
            assert!(
                !c.name.is_empty() && c.position_axes <= 3 && c.force_axes <= 3,
                "{key}"
            );
            assert_eq!(c.rated_force_n > 0.0, c.force_axes > 0, "{key}");
            assert!(c.continuous_force_n <= c.rated_force_n, "{key}");
            for text in [family.title(), family.about(), family.reached()] {
                assert!(!text.is_empty() && !text.contains('\n'), "{key}");
            }
            // Nothing is attached where tests run; looking for it must not fail or hang.
            for found in family.find() {
                assert_eq!(found.family, key);
            }
        }
    }

    #[test]
    fn a_serial_number_told_twice_is_none() {
        let mut three = [
            found("a", Some("7")),
            found("b", Some("8")),
            found("c", Some("7")),
            found("d", Some("7")),
            found("e", None),
        ];
        Found::tell_apart(&mut three);
        let serials: Vec<_> = three.iter().map(|f| f.serial.as_deref()).collect();
        assert_eq!(serials, [None, Some("8"), None, None, None]);
        let noted: Vec<_> = three.iter().map(|f| f.note.is_some()).collect();
        assert_eq!(noted, [true, false, true, true, false]);
    }
}
