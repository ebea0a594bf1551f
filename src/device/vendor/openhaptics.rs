//! 3D Systems: Touch, Omni and PHANToM, through the maker's OpenHaptics library `libHD`.
//!
//! The library calls back a thousand times a second from a thread of its own; there the device is read and its force set,
//! between `hdBeginFrame` and `hdEndFrame`. Two triple buffers lie between that and the link.
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
use libloading::Library;
use std::ffi::{CString, OsStr, c_char, c_double, c_int, c_uint, c_ulong, c_ushort, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// What the library is called.
const NAMES: &[&str] = if cfg!(windows) {
    &["HD.dll"]
} else {
    &["libHD.so", "libHD.so.3"]
};

/// The device that the maker's own setup calls so.
const DEFAULT_DEVICE: &str = "Default Device";

const INVALID: c_uint = 0xFFFF_FFFF;
const BUTTONS: c_uint = 0x2000;
const POSITION: c_uint = 0x2050;
const MAX_STIFFNESS: c_uint = 0x2602;
const MAX_FORCE: c_uint = 0x2603;
const CONTINUOUS_FORCE: c_uint = 0x2604;
const FORCE: c_uint = 0x2700;
const FORCE_OUTPUT: c_uint = 0x4000;
const DONE: c_uint = 0;
const CONTINUE: c_uint = 1;
/// The middle of what the library's priorities span, its default.
const PRIORITY: c_ushort = 0x7FFF;
const RATE_HZ: c_uint = 1000;
/// Without a new force for this long the callback sets none, s.
const PATIENCE: Duration = Duration::from_millis(10);

/// `HDErrorInfo`, which the library gives by value.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
struct ErrorInfo {
    code: c_uint,
    internal: c_int,
    device: c_uint,
}

type Callback = unsafe extern "C" fn(*mut c_void) -> c_uint;

/// The library and the functions used of it. The functions are good for as long as the library is held.
struct Hd {
    init_device: unsafe extern "C" fn(*const c_char) -> c_uint,
    disable_device: unsafe extern "C" fn(c_uint),
    make_current: unsafe extern "C" fn(c_uint),
    begin_frame: unsafe extern "C" fn(c_uint),
    end_frame: unsafe extern "C" fn(c_uint),
    get_doublev: unsafe extern "C" fn(c_uint, *mut c_double),
    get_integerv: unsafe extern "C" fn(c_uint, *mut c_int),
    set_doublev: unsafe extern "C" fn(c_uint, *const c_double),
    enable: unsafe extern "C" fn(c_uint),
    disable: unsafe extern "C" fn(c_uint),
    get_error: unsafe extern "C" fn() -> ErrorInfo,
    schedule: unsafe extern "C" fn(Callback, *mut c_void, c_ushort) -> c_ulong,
    unschedule: unsafe extern "C" fn(c_ulong),
    set_rate: unsafe extern "C" fn(c_uint),
    start: unsafe extern "C" fn(),
    stop: unsafe extern "C" fn(),
    _library: Library,
}

impl Hd {
    fn load(name: &OsStr) -> Result<Self, libloading::Error> {
        // SAFETY: the library's own start-up code is trusted as the maker's; the types are those of its C header.
        unsafe {
            let library = Library::new(name)?;
            Ok(Self {
                init_device: *library.get(b"hdInitDevice\0")?,
                disable_device: *library.get(b"hdDisableDevice\0")?,
                make_current: *library.get(b"hdMakeCurrentDevice\0")?,
                begin_frame: *library.get(b"hdBeginFrame\0")?,
                end_frame: *library.get(b"hdEndFrame\0")?,
                get_doublev: *library.get(b"hdGetDoublev\0")?,
                get_integerv: *library.get(b"hdGetIntegerv\0")?,
                set_doublev: *library.get(b"hdSetDoublev\0")?,
                enable: *library.get(b"hdEnable\0")?,
                disable: *library.get(b"hdDisable\0")?,
                get_error: *library.get(b"hdGetError\0")?,
                schedule: *library.get(b"hdScheduleAsynchronous\0")?,
                unschedule: *library.get(b"hdUnschedule\0")?,
                set_rate: *library.get(b"hdSetSchedulerRate\0")?,
                start: *library.get(b"hdStartScheduler\0")?,
                stop: *library.get(b"hdStopScheduler\0")?,
                _library: library,
            })
        }
    }

    fn installed() -> Result<Self, DeviceError> {
        let mut why = String::new();
        for name in NAMES {
            match Self::load(OsStr::new(name)) {
                Ok(hd) => return Ok(hd),
                Err(e) if why.is_empty() => why = e.to_string(),
                Err(_) => {}
            }
        }
        Err(not_loaded("OpenHaptics", NAMES, &why))
    }

    /// The library's oldest untold error, in words.
    fn error(&self, what: &str) -> DeviceError {
        // SAFETY: a function of the library held; the answer is plain numbers.
        let error = unsafe { (self.get_error)() };
        DeviceError::new(format!(
            "{what}: OpenHaptics error {:#06x} ({}) of device {:#x}",
            error.code, error.internal, error.device
        ))
    }

    fn double(&self, what: c_uint) -> f64 {
        let mut x = [0.0; 16];
        // SAFETY: sixteen numbers are more than any of these parameters has.
        unsafe { (self.get_doublev)(what, x.as_mut_ptr()) };
        x[0]
    }
}

/// What the library's thread and the link's share, besides the buffers.
#[derive(Debug, Default)]
struct Flags {
    /// The link wants an end.
    stop: AtomicBool,
    /// The callback will not be called again.
    ended: AtomicBool,
    /// The device reported an error.
    gone: AtomicBool,
    /// Force output is wanted.
    on: AtomicBool,
}

/// Everything the library's thread owns.
struct Turn {
    hd: Arc<Hd>,
    device: c_uint,
    flags: Arc<Flags>,
    told: triple_buffer::Input<Told>,
    wanted: triple_buffer::Output<(Vec3, Option<Instant>)>,
    number: u16,
    farewells: u8,
    /// Whether the device's force output is on.
    on: bool,
}

impl Turn {
    /// One millisecond of the device; whether it goes on.
    fn go(&mut self) -> bool {
        let stopping = self.flags.stop.load(Ordering::Acquire);
        let (force, when) = *self.wanted.read();
        let fresh = when.is_some_and(|t| t.elapsed() <= PATIENCE);
        let on = self.flags.on.load(Ordering::Acquire) && !stopping;
        let force = if fresh && on { force } else { Vec3::ZERO };
        // The library has x to the right, y up, z towards the user.
        let theirs = [force.y, force.z, force.x];
        let (mut at, mut buttons) = ([0.0; 3], 0);
        // SAFETY: each pointer is to as many numbers as the parameter has; the frame is ended as it was begun.
        let error = unsafe {
            (self.hd.begin_frame)(self.device);
            (self.hd.make_current)(self.device);
            if on && !self.on {
                (self.hd.enable)(FORCE_OUTPUT);
            }
            (self.hd.get_doublev)(POSITION, at.as_mut_ptr());
            (self.hd.get_integerv)(BUTTONS, &mut buttons);
            (self.hd.set_doublev)(FORCE, theirs.as_ptr());
            if self.on && !on {
                (self.hd.disable)(FORCE_OUTPUT);
            }
            (self.hd.end_frame)(self.device);
            (self.hd.get_error)()
        };
        self.on = on;
        if error.code != 0 {
            self.flags.gone.store(true, Ordering::Release);
            return false;
        }
        self.number = self.number.wrapping_add(1);
        let [right, up, towards] = at;
        self.told.write(Told {
            position_mm: Vec3::new(towards, right, up),
            buttons: buttons as u32,
            number: self.number,
        });
        if stopping {
            self.farewells += 1;
        }
        // No force, said several times.
        self.farewells < 5
    }
}

/// What the library calls a thousand times a second.
///
/// # Safety
/// `data` is the [`Turn`] handed to the scheduler, which lives until `ended` is set and the scheduler is stopped.
unsafe extern "C" fn turn(data: *mut c_void) -> c_uint {
    // SAFETY: see above; the scheduler calls from one thread only, so this is the one reference.
    let turn = unsafe { &mut *data.cast::<Turn>() };
    // A panic must not run into the maker's C.
    let goes_on = catch_unwind(AssertUnwindSafe(|| turn.go())).unwrap_or(false);
    if goes_on {
        return CONTINUE;
    }
    turn.flags.ended.store(true, Ordering::Release);
    DONE
}

/// Devices whose turns the scheduler, which is one for all, has; it runs while there is any.
static SCHEDULED: AtomicUsize = AtomicUsize::new(0);

struct HdPort {
    hd: Arc<Hd>,
    device: c_uint,
    handle: c_ulong,
    flags: Arc<Flags>,
    told: triple_buffer::Output<Told>,
    wanted: triple_buffer::Input<(Vec3, Option<Instant>)>,
    turn: *mut Turn,
}

// SAFETY: the pointer is only used to free what it points at, after the library's thread is done with it.
unsafe impl Send for HdPort {}

/// What the library says of a device.
struct Stated {
    rated_force_n: f64,
    continuous_force_n: f64,
    max_stiffness_n_per_mm: f64,
}

impl HdPort {
    fn open(hd: Hd, name: &str) -> Result<(Self, Stated), DeviceError> {
        let c_name = CString::new(name).map_err(|_| DeviceError::new("no name of a device"))?;
        let hd = Arc::new(hd);
        // SAFETY: the functions are those of the library held; the name ends in 0.
        let device = unsafe {
            let device = (hd.init_device)(c_name.as_ptr());
            if device == INVALID {
                return Err(hd.error(&format!("{name:?} does not open")));
            }
            (hd.make_current)(device);
            device
        };
        let stated = Stated {
            rated_force_n: hd.double(MAX_FORCE),
            continuous_force_n: hd.double(CONTINUOUS_FORCE),
            max_stiffness_n_per_mm: hd.double(MAX_STIFFNESS),
        };
        let (told_in, told) = triple_buffer::triple_buffer(&Told::default());
        let (wanted, wanted_out) = triple_buffer::triple_buffer(&(Vec3::ZERO, None));
        let flags = Arc::new(Flags::default());
        let turn_of_it = Box::into_raw(Box::new(Turn {
            hd: Arc::clone(&hd),
            device,
            flags: Arc::clone(&flags),
            told: told_in,
            wanted: wanted_out,
            number: 0,
            farewells: 0,
            on: false,
        }));
        // SAFETY: what is scheduled lives until the turn has ended and is unscheduled (Drop).
        let handle = unsafe {
            let handle = (hd.schedule)(turn, turn_of_it.cast(), PRIORITY);
            (hd.set_rate)(RATE_HZ);
            if SCHEDULED.fetch_add(1, Ordering::AcqRel) == 0 {
                (hd.start)();
            }
            handle
        };
        let port = Self {
            hd,
            device,
            handle,
            flags,
            told,
            wanted,
            turn: turn_of_it,
        };
        Ok((port, stated))
    }
}

impl Port for HdPort {
    fn read(&mut self, into: &mut [u8; REPORT], wait_ms: u16) -> Result<usize, Gone> {
        let until = Instant::now() + Duration::from_millis(wait_ms.into());
        loop {
            if self.flags.gone.load(Ordering::Acquire) {
                return Err(Gone);
            }
            if self.told.update() {
                return Ok(self.told.output_buffer().encode(into));
            }
            if Instant::now() >= until {
                return Ok(0);
            }
            std::thread::sleep(Duration::from_micros(100));
        }
    }

    fn write(&mut self, report: &[u8]) -> Result<(), Gone> {
        self.wanted.write((force_n(report), Some(Instant::now())));
        if self.flags.gone.load(Ordering::Acquire) {
            Err(Gone)
        } else {
            Ok(())
        }
    }

    fn enable(&mut self, on: bool) -> Result<(), Gone> {
        self.flags.on.store(on, Ordering::Release);
        Ok(())
    }
}

impl Drop for HdPort {
    fn drop(&mut self) {
        self.flags.stop.store(true, Ordering::Release);
        let until = Instant::now() + Duration::from_millis(200);
        while !self.flags.ended.load(Ordering::Acquire) && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(1));
        }
        let ended = self.flags.ended.load(Ordering::Acquire);
        // SAFETY: the library's functions, with what it gave; the turn is freed only when it will not be called again.
        unsafe {
            if SCHEDULED.fetch_sub(1, Ordering::AcqRel) == 1 {
                (self.hd.stop)();
            }
            (self.hd.unschedule)(self.handle);
            (self.hd.disable_device)(self.device);
            // A turn that never came to its end is left: the library may still be in it.
            if ended {
                drop(Box::from_raw(self.turn));
            }
        }
    }
}

/// The family.
#[derive(Debug)]
pub struct OpenHaptics;

/// The family.
pub static FAMILY: OpenHaptics = OpenHaptics;

impl OpenHaptics {
    /// Opens a device through the library in `file`; how tests come by their stub.
    ///
    /// # Errors
    /// The library cannot be loaded or the device not be opened.
    pub fn open_through(
        &self,
        file: &OsStr,
        name: &str,
        calibration: &Calibration,
    ) -> Result<Box<dyn Device>, DeviceError> {
        let hd = Hd::load(file).map_err(DeviceError::new)?;
        self.start(hd, name, calibration)
    }

    fn start(
        &self,
        hd: Hd,
        name: &str,
        calibration: &Calibration,
    ) -> Result<Box<dyn Device>, DeviceError> {
        let (port, stated) = HdPort::open(hd, name)?;
        let mut capabilities = self.capabilities(calibration);
        // The device knows itself better than the family, and the file may hold it to less.
        let least = |told: f64, known: f64| if told > 0.0 { told.min(known) } else { known };
        let c = &mut capabilities;
        c.rated_force_n = least(stated.rated_force_n, c.rated_force_n);
        c.continuous_force_n = least(stated.continuous_force_n, c.rated_force_n);
        c.max_stiffness_n_per_mm = least(stated.max_stiffness_n_per_mm, c.max_stiffness_n_per_mm);
        Ok(Box::new(link(capabilities, Box::new(port), calibration)?))
    }
}

impl Family for OpenHaptics {
    fn key(&self) -> &'static str {
        "openhaptics"
    }

    fn title(&self) -> &'static str {
        "3D Systems Touch, PHANToM"
    }

    fn about(&self) -> &'static str {
        "Touch, Omni and PHANToM, through their maker's library"
    }

    fn reached(&self) -> &'static str {
        "OpenHaptics (libHD), loaded at run time where it is installed"
    }

    fn proof(&self) -> Proof {
        Proof::Stub
    }

    /// The Premium 3.0's figures, the most of the family; a device is held to what it says of itself.
    fn defaults(&self) -> Calibration {
        Calibration {
            mechanics: Mechanics::assumed(1.0e-3, 0.2),
            ..Calibration::plain(self.key(), 22.0, 1.0)
        }
    }

    fn capabilities(&self, calibration: &Calibration) -> Capabilities {
        let name = calibration.name.as_deref().unwrap_or(self.title());
        Capabilities {
            max_stiffness_n_per_mm: calibration.max_stiffness_n_per_mm,
            workspace_radius_mm: 75.0,
            resolution_mm: 0.055,
            n_buttons: 2,
            report_rate_hz: 1000.0,
            ..Capabilities::ideal(name, calibration.rated_force_n)
        }
    }

    fn ready(&self) -> Result<(), DeviceError> {
        Hd::installed().map(|_| ())
    }

    fn may_be_watched(&self) -> bool {
        false
    }

    fn find(&self) -> Vec<Found> {
        if self.ready().is_err() {
            return Vec::new();
        }
        vec![Found {
            family: self.key(),
            place: DEFAULT_DEVICE.into(),
            title: self.title().into(),
            serial: None,
            note: Some(
                "set up in the maker's own program; opening it tells whether it is there".into(),
            ),
        }]
    }

    fn open(
        &self,
        found: &Found,
        calibration: &Calibration,
    ) -> Result<Box<dyn Device>, DeviceError> {
        self.start(Hd::installed()?, &found.place, calibration)
    }
}
