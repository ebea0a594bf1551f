//! The host's side: what is listed, opened, read and written, through `hidapi` over the kernel's hidraw.

use hidapi::{DeviceInfo, HidApi, HidDevice};
use std::ffi::CString;
use std::time::{Duration, Instant};

use crate::board::{COUNT_AT, ENCODER_E, words};
use crate::kinds::{Kind, Speaks};
use crate::plug::Emulated;

/// How long a device may take to come or go: a guest without hardware help is slow.
pub const PATIENCE: Duration = Duration::from_secs(4);

/// Everything that is listed.
pub fn everything() -> Result<Vec<DeviceInfo>, String> {
    let api = HidApi::new().map_err(|error| format!("hidapi: {error}"))?;
    Ok(api.device_list().cloned().collect())
}

/// What is listed with the ids of a kind.
pub fn listed(kind: &Kind) -> Result<Vec<DeviceInfo>, String> {
    let ids = (kind.vendor, kind.product);
    Ok(everything()?
        .into_iter()
        .filter(|found| (found.vendor_id(), found.product_id()) == ids)
        .collect())
}

/// Waits until so many devices of a kind are listed.
pub fn awaited(kind: &Kind, number: usize) -> Result<Vec<DeviceInfo>, String> {
    let start = Instant::now();
    loop {
        let found = listed(kind)?;
        if found.len() == number {
            return Ok(found);
        }
        if start.elapsed() > PATIENCE {
            return Err(format!(
                "{} listed after {PATIENCE:?}, expected {number}",
                found.len()
            ));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A device that is open.
pub struct Opened {
    pub kind: &'static Kind,
    pub handle: HidDevice,
    count: u32,
}

impl Opened {
    /// The only one of its kind, once it is listed.
    pub fn only(emulated: &Emulated) -> Result<Self, String> {
        let found = awaited(emulated.kind, 1)?;
        Self::at(emulated.kind, &found[0].path().to_owned())
    }

    pub fn at(kind: &'static Kind, path: &CString) -> Result<Self, String> {
        let api = HidApi::new().map_err(|error| format!("hidapi: {error}"))?;
        let handle = api
            .open_path(path)
            .map_err(|error| format!("open {path:?}: {error}"))?;
        Ok(Self {
            kind,
            handle,
            count: 0,
        })
    }

    /// The next report, within half a second.
    pub fn read(&self) -> Result<Vec<u8>, String> {
        let report = self.read_within(500)?;
        if report.is_empty() {
            Err("no report in 500 ms".into())
        } else {
            Ok(report)
        }
    }

    /// The next report within so many ms, empty if none came.
    pub fn read_within(&self, ms: i32) -> Result<Vec<u8>, String> {
        let mut bytes = [0; 128];
        let length = self
            .handle
            .read_timeout(&mut bytes, ms)
            .map_err(|error| format!("read: {error}"))?;
        Ok(bytes[..length].to_vec())
    }

    /// Everything that waits, oldest first.
    pub fn drain(&self) -> Result<Vec<Vec<u8>>, String> {
        let mut reports = Vec::new();
        loop {
            match self.read_within(0)? {
                report if report.is_empty() => return Ok(reports),
                report => reports.push(report),
            }
        }
    }

    pub fn write(&self, report: &[u8]) -> Result<(), String> {
        let written = self
            .handle
            .write(report)
            .map_err(|error| format!("write: {error}"))?;
        if written == report.len() {
            Ok(())
        } else {
            Err(format!("{written} of {} bytes written", report.len()))
        }
    }

    /// Currents for the three motors, mA, with the host's count where the protocol has one. What went out.
    pub fn drive(&mut self, current_ma: [i16; 3]) -> Result<Vec<u8>, String> {
        let [a, b, c] = current_ma;
        self.count = self.count.wrapping_add(1);
        let mut body = match self.kind.speaks {
            Speaks::Wooden8 => words(&[a, b, c, self.count as u16 as i16], 8),
            Speaks::Wooden14 => words(&[a, b, c], 14),
            Speaks::Teensy64 => {
                let mut body = words(&[a, b, c], 64);
                body[COUNT_AT..].copy_from_slice(&self.count.to_le_bytes());
                body
            }
            Speaks::SpaceMouseSplit | Speaks::SpaceMouseWhole => vec![u8::from(a != 0)],
        };
        body.insert(0, self.kind.out_id);
        self.write(&body)?;
        Ok(body)
    }
}

/// The device's count in a report; `None` where the protocol has none, or the report is too short for it.
pub fn count(kind: &Kind, report: &[u8]) -> Option<u32> {
    match kind.speaks {
        Speaks::Wooden8 => word(report, 6).map(|low| u32::from(low as u16)),
        Speaks::Wooden14 => word(report, ENCODER_E).map(|low| u32::from(low as u16)),
        Speaks::Teensy64 => report
            .get(COUNT_AT..COUNT_AT + 4)
            .map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        Speaks::SpaceMouseSplit | Speaks::SpaceMouseWhole => None,
    }
}

/// How many reports are missing between two counts that should follow each other. The same count twice is an error.
pub fn missing(kind: &Kind, before: u32, now: u32) -> Result<u32, String> {
    let mask = if kind.speaks == Speaks::Teensy64 {
        u32::MAX
    } else {
        0xFFFF
    };
    match now.wrapping_sub(before) & mask {
        0 => Err(format!("count {now} twice: the report is frozen")),
        step => Ok(step - 1),
    }
}

/// The little-endian word at a byte.
pub fn word(report: &[u8], at: usize) -> Option<i16> {
    report
        .get(at..at + 2)
        .map(|b| i16::from_le_bytes([b[0], b[1]]))
}
