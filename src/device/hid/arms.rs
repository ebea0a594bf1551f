//! The families of arms: WoodenHaptics, Polhem and those with a Teensy board.

use super::attached;
use super::driver::{ArmDriver, Protocol};
use super::link::Linked;
use super::models::{self, Model};
use super::report::{teensy, wooden};
use super::transport::{HidPort, Port};
use crate::device::calibration::Mechanics;
use crate::device::mapped::Mapped;
use crate::device::{Calibration, Capabilities, Device, DeviceError, Family, Found, Proof};

/// Arms that speak one protocol.
#[derive(Debug)]
pub struct Arms {
    key: &'static str,
    title: &'static str,
    about: &'static str,
    reached: &'static str,
    ids: (u16, u16),
    /// Which board.
    pub protocol: Protocol,
    model: &'static str,
}

/// First board.
pub static WOODEN: Arms = Arms {
    key: "woodenhaptics",
    title: "WoodenHaptics",
    about: "Open haptic arm, three motors on capstans, first board",
    reached: "HID 1234:0006, 8-byte reports, no driver",
    ids: wooden::IDS,
    protocol: Protocol::Wooden,
    model: "woodenhaptics",
};

/// Newer board.
pub static POLHEM: Arms = Arms {
    key: "polhem",
    title: "Polhem",
    about: "Haptic arm with a wrist of encoders; v2's own kinematics is not published and not known here",
    reached: "HID 1234:0006, 14-byte reports, no driver",
    ids: wooden::IDS,
    protocol: Protocol::Polhem,
    model: "polhem-v1",
};

/// Teensy board.
pub static TEENSY: Arms = Arms {
    key: "polhem-teensy",
    title: "Polhem (Teensy)",
    about: "Haptic arms with a Teensy board: Polhem, AluHaptics and others, by the model in the device file",
    reached: "HID 16C0:0486, 64-byte reports, no driver",
    ids: teensy::IDS,
    protocol: Protocol::Teensy,
    model: "polhem-v1",
};

impl Arms {
    fn model(&self) -> &'static Model {
        models::by_key(self.model).unwrap_or(&models::ARMS[0])
    }

    /// Opens the device at the other end of `port`.
    ///
    /// # Errors
    /// It does not fit the calibration, or the system gives no thread.
    pub fn open_port(
        &self,
        port: Box<dyn Port>,
        calibration: &Calibration,
    ) -> Result<Mapped<Linked>, DeviceError> {
        let Some(arm) = calibration.arm.clone() else {
            let what = format!("a calibration for {:?} has no arm", calibration.family);
            return Err(DeviceError::new(what));
        };
        let capabilities = self.capabilities(calibration);
        let driver = ArmDriver::new(self.protocol, arm, calibration.gravity);
        let linked = Linked::start(capabilities, port, Box::new(driver), calibration)?;
        Ok(Mapped::new(linked, calibration.mapping))
    }
}

impl Family for Arms {
    fn key(&self) -> &'static str {
        self.key
    }

    fn title(&self) -> &'static str {
        self.title
    }

    fn about(&self) -> &'static str {
        self.about
    }

    fn reached(&self) -> &'static str {
        self.reached
    }

    fn proof(&self) -> Proof {
        Proof::Emulator
    }

    fn defaults(&self) -> Calibration {
        let model = self.model();
        let mut out =
            Calibration::plain(self.key, model.rated_force_n, model.max_stiffness_n_per_mm);
        out.arm = Some(model.arm());
        out.mechanics = Mechanics::assumed(1.0e-3, 0.15);
        out
    }

    fn capabilities(&self, calibration: &Calibration) -> Capabilities {
        let arm = calibration.arm.as_ref();
        let name = calibration.name.as_deref().unwrap_or(self.title);
        Capabilities {
            name: name.into(),
            position_axes: 3,
            force_axes: 3,
            rated_force_n: calibration.rated_force_n,
            continuous_force_n: calibration.rated_force_n,
            max_stiffness_n_per_mm: calibration.max_stiffness_n_per_mm,
            workspace_radius_mm: arm.map_or(0.0, |a| a.workspace_radius_mm),
            resolution_mm: arm.map_or(0.0, |a| a.resolution_mm()),
            n_buttons: self.protocol.n_buttons(),
            report_rate_hz: 1000.0,
        }
    }

    fn ready(&self) -> Result<(), DeviceError> {
        attached::ready()
    }

    fn find(&self) -> Vec<Found> {
        let listed = attached::list(&[self.ids]).into_iter().filter_map(|a| {
            // Both boards of 1234:0006 are told apart by the length of their reports.
            let note = match attached::input_bytes(&a.path) {
                Some(n) if n == self.protocol.in_bytes() => None,
                Some(_) => return None,
                None => Some("may not be opened: which board it is cannot be told".to_owned()),
            };
            Some(a.found(self.key, self.title, note))
        });
        let mut out: Vec<Found> = listed.collect();
        Found::tell_apart(&mut out);
        out
    }

    fn open(
        &self,
        found: &Found,
        calibration: &Calibration,
    ) -> Result<Box<dyn Device>, DeviceError> {
        let port = HidPort::open(&found.place)?;
        Ok(Box::new(self.open_port(Box::new(port), calibration)?))
    }
}
