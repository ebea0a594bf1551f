//! Opening a device: its file read, its family asked, its wrappers put around it. On a thread of its own.

use crate::app::hardware::InUse;
use crate::device::place::Place;
use crate::device::push::{Push, Pushed};
use crate::device::seat::Seated;
use crate::device::stable::Stable;
use crate::device::{Calibration, Device, DeviceError, Family, Found, by_key, calibration};
use crate::geom::Vec3;
use std::path::Path;
use std::sync::Arc;

/// What names an emulated device among those attached.
pub const EMULATED: &str = "emulated";

/// How far above the skin the middle of a device's workspace lies, mm: the hand begins in the air.
const ABOVE_MM: f64 = 20.0;

/// A device ready for a finger.
pub struct Opened {
    /// What was asked for.
    pub order: Order,
    /// For the servo.
    pub device: Box<dyn Device>,
    /// What the window knows of it.
    pub used: Used,
    /// Where it sits; `None` where its file says so.
    pub seat: Option<(Place, f64)>,
}

/// A device in use, seen from outside of the servo.
pub struct Used {
    /// What it is.
    pub told: Arc<InUse>,
    /// Its force test.
    pub push: Push,
    /// The process that stands in for it; ends with this.
    _emulator: Option<Emulator>,
}

/// What opening needs to know.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// Which finger.
    pub finger: usize,
    /// Which device.
    pub found: Found,
    /// Its fault, where it is emulated.
    pub fault: Option<&'static str>,
    /// Counts what was asked for this finger: only the newest is carried out.
    pub number: u64,
}

/// Opens what `order` names, calibrated by the file in `folder`, for a servo at `rate_hz`.
///
/// # Errors
/// The file is refused; the device is gone, may not be opened or does not fit its calibration.
pub fn open(order: &Order, folder: &Path, rate_hz: f64) -> Result<Opened, DeviceError> {
    let found = &order.found;
    let family = family(found)?;
    let calibration = calibration_of(found, family, folder)?;
    let (device, emulator) = if is_emulated(found) {
        let (device, emulator) = emulated(order, &calibration)?;
        (device, Some(emulator))
    } else {
        (family.open(found, &calibration)?, None)
    };
    let seated = calibration.mapping.offset_mm == Vec3::ZERO;
    let place = Place::default();
    // A simulated hand presses into whatever lies in the middle.
    let above_mm = if emulator.is_some() { 0.0 } else { ABOVE_MM };
    let push = Push::default();
    let told = InUse {
        found: found.clone(),
        emulated: emulator.is_some(),
        capabilities: device.capabilities().clone(),
        vitals: device.vitals(),
        stable: Stable::of(device.capabilities(), &calibration, rate_hz),
        calibration,
    };
    let device: Box<dyn Device> = Box::new(Pushed::new(device, &push));
    Ok(Opened {
        order: order.clone(),
        device: if seated {
            Box::new(Seated::new(device, &place))
        } else {
            device
        },
        used: Used {
            told: Arc::new(told),
            push,
            _emulator: emulator,
        },
        seat: seated.then_some((place, above_mm)),
    })
}

/// Whether it is a simulated device.
pub fn is_emulated(found: &Found) -> bool {
    found.place.starts_with(EMULATED)
}

fn family(found: &Found) -> Result<&'static dyn Family, DeviceError> {
    let none = || DeviceError::new(format!("there are no devices called {:?}", found.family));
    by_key(found.family).ok_or_else(none)
}

/// The calibration of a device; simulated ones have files of the family only.
fn calibration_of(
    found: &Found,
    family: &dyn Family,
    folder: &Path,
) -> Result<Calibration, DeviceError> {
    Ok(calibration::load(
        folder,
        found.serial.as_deref(),
        &family.defaults(),
    )?)
}

#[cfg(target_os = "linux")]
mod emulator {
    use super::Order;
    use crate::device::hid::emulator::process::{Emulated, Request, family};
    use crate::device::hid::emulator::{Fault, Hand};
    use crate::device::{Calibration, Device, DeviceError, Family as _};

    /// The process that stands in for a device.
    pub type Emulator = Emulated;

    /// It is to be there for as long as the window is.
    const SECONDS: f64 = 86_400.0;
    /// How far the hand reaches under the middle of the workspace, mm.
    const DEPTH_MM: f64 = 6.0;

    /// Starts the simulated device and opens it.
    ///
    /// # Errors
    /// The system gives no process, or it does not fit the calibration.
    pub fn emulated(
        order: &Order,
        calibration: &Calibration,
    ) -> Result<(Box<dyn Device>, Emulator), DeviceError> {
        let arms = family(order.found.family)?;
        let program = std::env::current_exe().map_err(DeviceError::new)?;
        let fault = order.fault.and_then(Fault::by_key);
        let request = Request {
            seconds: SECONDS,
            hand: match fault {
                Some(_) => Hand::Insist { depth_mm: DEPTH_MM },
                None => Hand::Visit { depth_mm: DEPTH_MM },
            },
            fault,
            ..Request::press(arms.key())
        };
        let (emulator, port) = Emulated::spawn(&program, &request)?;
        let mut named = calibration.clone();
        let name = calibration.name.as_deref().unwrap_or(arms.title());
        named.name = Some(format!("{name} (emulated)"));
        let device = arms.open_port(port, &named)?;
        Ok((Box::new(device), emulator))
    }
}

#[cfg(not(target_os = "linux"))]
mod emulator {
    use super::Order;
    use crate::device::{Calibration, Device, DeviceError};

    /// There is none.
    pub enum Emulator {}

    /// # Errors
    /// Always.
    pub fn emulated(
        _order: &Order,
        _calibration: &Calibration,
    ) -> Result<(Box<dyn Device>, Emulator), DeviceError> {
        Err(DeviceError::new("emulated devices need Linux"))
    }
}

pub use emulator::Emulator;
use emulator::emulated;
