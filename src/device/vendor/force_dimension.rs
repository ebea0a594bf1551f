//! Force Dimension: omega, delta, sigma and lambda, through the maker's library `libdhd`.
//!
//! Tested against a stub of the library, which checks order, types and values of the calls; never against hardware.
#![allow(
    unsafe_code,
    reason = "calls a maker's C library, loaded at run time; nothing else of the house does"
)]

use super::{Told, force_n, link, not_loaded};
use crate::device::calibration::Mechanics;
use crate::device::hid::transport::{Gone, Port, REPORT};
use crate::device::{Calibration, Capabilities, Device, DeviceError, Family, Found, Proof};
use crate::geom::Vec3;
use crate::units::mm_from_m;
use libloading::Library;
use std::ffi::{CStr, OsStr, c_char, c_double, c_int, c_uchar, c_uint};
use std::time::{Duration, Instant};

/// What the library is called.
const NAMES: &[&str] = if cfg!(windows) {
    &["dhd64.dll", "drd64.dll"]
} else {
    &["libdhd.so", "libdhd.so.3", "libdrd.so", "libdrd.so.3"]
};

/// Time between two looks at the device.
const PERIOD: Duration = Duration::from_millis(1);

type Id = c_char;
type Three = unsafe extern "C" fn(*mut c_double, *mut c_double, *mut c_double, Id) -> c_int;

/// The library and the functions used of it. The functions are good for as long as the library is held.
struct Dhd {
    device_count: unsafe extern "C" fn() -> c_int,
    open_id: unsafe extern "C" fn(Id) -> c_int,
    close: unsafe extern "C" fn(Id) -> c_int,
    position: Three,
    set_force: unsafe extern "C" fn(c_double, c_double, c_double, Id) -> c_int,
    enable_force: unsafe extern "C" fn(c_uchar, Id) -> c_int,
    button_mask: unsafe extern "C" fn(Id) -> c_uint,
    last_error: unsafe extern "C" fn() -> *const c_char,
    _library: Library,
}

impl Dhd {
    fn load(name: &OsStr) -> Result<Self, libloading::Error> {
        // SAFETY: the library's own start-up code is trusted as the maker's; the types are those of its C header.
        unsafe {
            let library = Library::new(name)?;
            Ok(Self {
                device_count: *library.get(b"dhdGetDeviceCount\0")?,
                open_id: *library.get(b"dhdOpenID\0")?,
                close: *library.get(b"dhdClose\0")?,
                position: *library.get(b"dhdGetPosition\0")?,
                set_force: *library.get(b"dhdSetForce\0")?,
                enable_force: *library.get(b"dhdEnableForce\0")?,
                button_mask: *library.get(b"dhdGetButtonMask\0")?,
                last_error: *library.get(b"dhdErrorGetLastStr\0")?,
                _library: library,
            })
        }
    }

    fn installed() -> Result<Self, DeviceError> {
        let mut why = String::new();
        for name in NAMES {
            match Self::load(OsStr::new(name)) {
                Ok(dhd) => return Ok(dhd),
                Err(e) if why.is_empty() => why = e.to_string(),
                Err(_) => {}
            }
        }
        Err(not_loaded("the Force Dimension SDK", NAMES, &why))
    }

    fn error(&self, what: &str) -> DeviceError {
        // SAFETY: the library answers with a string of its own that ends in 0, or with nothing.
        let told = unsafe {
            let text = (self.last_error)();
            if text.is_null() {
                String::new()
            } else {
                CStr::from_ptr(text).to_string_lossy().into_owned()
            }
        };
        DeviceError::new(format!("{what}: {told}"))
    }
}

/// An open device, looked at once a millisecond.
struct DhdPort {
    dhd: Dhd,
    id: Id,
    due: Instant,
    number: u16,
}

impl DhdPort {
    fn open(dhd: Dhd, index: u8) -> Result<Self, DeviceError> {
        // SAFETY: the functions are those of the library held beside them.
        unsafe {
            let id = (dhd.open_id)(index as Id);
            let Ok(id) = Id::try_from(id) else {
                return Err(dhd.error("the device does not open"));
            };
            if id < 0 {
                return Err(dhd.error("the device does not open"));
            }
            // Off until the servo switches it on; what refuses this takes no force either.
            if (dhd.enable_force)(0, id) < 0 {
                let error = dhd.error("the device takes no force");
                (dhd.close)(id);
                return Err(error);
            }
            Ok(Self {
                dhd,
                id,
                due: Instant::now(),
                number: 0,
            })
        }
    }
}

impl Port for DhdPort {
    fn read(&mut self, into: &mut [u8; REPORT], wait_ms: u16) -> Result<usize, Gone> {
        let now = Instant::now();
        if now < self.due {
            let wait = (self.due - now).min(Duration::from_millis(wait_ms.into()));
            std::thread::sleep(wait);
            if Instant::now() < self.due {
                return Ok(0);
            }
        }
        self.due = (self.due + PERIOD).max(Instant::now());
        let (mut x, mut y, mut z) = (0.0, 0.0, 0.0);
        // SAFETY: three places to write to, and an id that the library gave.
        let (answer, buttons) = unsafe {
            let answer = (self.dhd.position)(&mut x, &mut y, &mut z, self.id);
            (answer, (self.dhd.button_mask)(self.id))
        };
        if answer < 0 {
            return Err(Gone);
        }
        self.number = self.number.wrapping_add(1);
        // Its frame is the house's: x towards the user, y to the right, z up. It tells metres.
        let told = Told {
            position_mm: Vec3::new(mm_from_m(x), mm_from_m(y), mm_from_m(z)),
            buttons,
            number: self.number,
        };
        Ok(told.encode(into))
    }

    fn write(&mut self, report: &[u8]) -> Result<(), Gone> {
        let f = force_n(report);
        // SAFETY: plain numbers, and an id that the library gave.
        let answer = unsafe { (self.dhd.set_force)(f.x, f.y, f.z, self.id) };
        if answer < 0 { Err(Gone) } else { Ok(()) }
    }

    fn enable(&mut self, on: bool) -> Result<(), Gone> {
        // SAFETY: a plain number, and an id that the library gave.
        let answer = unsafe { (self.dhd.enable_force)(c_uchar::from(on), self.id) };
        if answer < 0 { Err(Gone) } else { Ok(()) }
    }
}

impl Drop for DhdPort {
    fn drop(&mut self) {
        // SAFETY: the id is the library's, and is not used after this.
        unsafe {
            (self.dhd.set_force)(0.0, 0.0, 0.0, self.id);
            (self.dhd.enable_force)(0, self.id);
            (self.dhd.close)(self.id);
        }
    }
}

/// The family.
#[derive(Debug)]
pub struct ForceDimension;

/// The family.
pub static FAMILY: ForceDimension = ForceDimension;

impl ForceDimension {
    /// Opens a device through the library in `file`; how tests come by their stub.
    ///
    /// # Errors
    /// The library cannot be loaded or the device not be opened.
    pub fn open_through(
        &self,
        file: &OsStr,
        index: u8,
        calibration: &Calibration,
    ) -> Result<Box<dyn Device>, DeviceError> {
        let dhd = Dhd::load(file).map_err(DeviceError::new)?;
        let port = DhdPort::open(dhd, index)?;
        let device = link(self.capabilities(calibration), Box::new(port), calibration)?;
        Ok(Box::new(device))
    }
}

impl Family for ForceDimension {
    fn key(&self) -> &'static str {
        "force-dimension"
    }

    fn title(&self) -> &'static str {
        "Force Dimension"
    }

    fn about(&self) -> &'static str {
        "omega, delta, sigma and lambda, through their maker's library"
    }

    fn reached(&self) -> &'static str {
        "libdhd, loaded at run time where it is installed"
    }

    fn proof(&self) -> Proof {
        Proof::Stub
    }

    /// The omega.3's figures, the least of the family; a device file states others.
    fn defaults(&self) -> Calibration {
        Calibration {
            mechanics: Mechanics::assumed(3.0e-3, 0.1),
            ..Calibration::plain(self.key(), 12.0, 5.0)
        }
    }

    fn capabilities(&self, calibration: &Calibration) -> Capabilities {
        let name = calibration.name.as_deref().unwrap_or(self.title());
        Capabilities {
            max_stiffness_n_per_mm: calibration.max_stiffness_n_per_mm,
            workspace_radius_mm: 75.0,
            resolution_mm: 0.01,
            n_buttons: 1,
            report_rate_hz: 1000.0,
            ..Capabilities::ideal(name, calibration.rated_force_n)
        }
    }

    fn ready(&self) -> Result<(), DeviceError> {
        Dhd::installed().map(|_| ())
    }

    fn may_be_watched(&self) -> bool {
        false
    }

    fn find(&self) -> Vec<Found> {
        let Ok(dhd) = Dhd::installed() else {
            return Vec::new();
        };
        // SAFETY: a function of the library held.
        let n = unsafe { (dhd.device_count)() };
        (0..n.clamp(0, 16))
            .map(|i| Found {
                family: self.key(),
                place: i.to_string(),
                title: self.title().into(),
                serial: None,
                note: None,
            })
            .collect()
    }

    fn open(
        &self,
        found: &Found,
        calibration: &Calibration,
    ) -> Result<Box<dyn Device>, DeviceError> {
        let index = found
            .place
            .parse()
            .map_err(|_| DeviceError::new(format!("{:?} is no number of a device", found.place)))?;
        let port = DhdPort::open(Dhd::installed()?, index)?;
        let device = link(self.capabilities(calibration), Box::new(port), calibration)?;
        Ok(Box::new(device))
    }
}
