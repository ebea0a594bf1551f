//! Which HID devices are attached.

use super::report::descriptor;
use crate::device::{DeviceError, Found};

/// One HID device, as the system lists it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attached {
    /// Where it is opened.
    pub path: String,
    /// Vendor and product.
    pub ids: (u16, u16),
    /// What it calls itself.
    pub product: Option<String>,
    /// Its serial number.
    pub serial: Option<String>,
}

/// Whether the system can list HID devices.
///
/// # Errors
/// Why not.
pub fn ready() -> Result<(), DeviceError> {
    match hidapi::HidApi::new() {
        Ok(_) => Ok(()),
        Err(e) => Err(DeviceError::new(format!(
            "HID devices cannot be listed: {e}"
        ))),
    }
}

/// The attached devices with any of these ids, by path.
pub fn list(ids: &[(u16, u16)]) -> Vec<Attached> {
    let Ok(api) = hidapi::HidApi::new() else {
        return Vec::new();
    };
    let mut out: Vec<Attached> = api
        .device_list()
        .filter(|d| ids.contains(&(d.vendor_id(), d.product_id())))
        .map(|d| Attached {
            path: d.path().to_string_lossy().into_owned(),
            ids: (d.vendor_id(), d.product_id()),
            product: d.product_string().and_then(words),
            serial: d.serial_number().and_then(words),
        })
        .collect();
    out.sort_by(|a, b| a.path.cmp(&b.path));
    // One device may stand in the list once for each of its collections.
    out.dedup_by(|a, b| a.path == b.path);
    out
}

/// The path and ids of every HID device, in one order: what tells that something was plugged in or pulled out.
pub fn paths() -> Vec<String> {
    let Ok(api) = hidapi::HidApi::new() else {
        return Vec::new();
    };
    let mut out: Vec<String> = api
        .device_list()
        .map(|d| {
            let (path, serial) = (
                d.path().to_string_lossy(),
                d.serial_number().unwrap_or_default(),
            );
            format!(
                "{path} {:04x}:{:04x} {serial}",
                d.vendor_id(),
                d.product_id()
            )
        })
        .collect();
    out.sort();
    out.dedup();
    out
}

fn words(text: &str) -> Option<String> {
    let clean: String = text.chars().filter(|c| !c.is_control()).take(120).collect();
    let clean = clean.trim();
    (!clean.is_empty()).then(|| clean.to_owned())
}

/// Bytes of the device's input report, as its descriptor says; `None` where it may not be opened.
pub fn input_bytes(path: &str) -> Option<usize> {
    let api = hidapi::HidApi::new().ok()?;
    let device = api.open_path(&std::ffi::CString::new(path).ok()?).ok()?;
    let mut bytes = [0; 4096];
    let n = device.get_report_descriptor(&mut bytes).ok()?;
    descriptor::input_bytes(bytes.get(..n)?)
}

impl Attached {
    /// It, as a device of a family.
    pub fn found(self, family: &'static str, title: &str, note: Option<String>) -> Found {
        Found {
            family,
            place: self.path,
            title: self.product.unwrap_or_else(|| title.to_owned()),
            serial: self.serial,
            note,
        }
    }
}
