//! Device files in a folder: one per device, by family and serial number.

use super::{Calibration, CalibrationError};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Largest file that is read, bytes.
const MOST_BYTES: u64 = 1 << 20;

/// The user's folder of device files; the working directory's `devices` where the system has none.
pub fn usual_folder() -> PathBuf {
    directories::ProjectDirs::from("", "", "dorsum").map_or_else(
        || PathBuf::from("devices"),
        |dirs| dirs.config_dir().join("devices"),
    )
}

/// Name of the file of a device: family and serial number, or the family alone. Characters that no file system minds stay,
/// others become `_`, and what was changed that way is told apart by a sum of the serial number.
pub fn file_name(family: &str, serial: Option<&str>) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '.';
    let safe = |text: &str| -> String {
        text.chars()
            .take(64)
            .map(|c| if plain(c) { c } else { '_' })
            .collect()
    };
    match serial {
        None => format!("{}.toml", safe(family)),
        Some(s) if safe(s) == s => format!("{}-{s}.toml", safe(family)),
        Some(s) => {
            // FNV-1a, 32 bits: serial numbers that look alike in a file name are few.
            let sum = s.bytes().fold(0x811C_9DC5_u32, |sum, b| {
                (sum ^ u32::from(b)).wrapping_mul(0x0100_0193)
            });
            format!("{}-{}-{sum:08x}.toml", safe(family), safe(s))
        }
    }
}

/// The calibration of a device from `folder`: the file of its serial number, else that of the family, else `defaults`.
///
/// # Errors
/// A file that is there and cannot be read, or the first thing wrong with it.
pub fn load(
    folder: &Path,
    serial: Option<&str>,
    defaults: &Calibration,
) -> Result<Calibration, CalibrationError> {
    let family = &defaults.family;
    let own = serial.map(|s| file_name(family, Some(s)));
    for name in own.into_iter().chain([file_name(family, None)]) {
        let path = folder.join(name);
        let Some(text) = read(&path)? else { continue };
        let known = |key: &str| (key == family).then(|| defaults.clone());
        let origin = path.display().to_string();
        let found = Calibration::parse(&text, &origin, known)?;
        if let (Some(a), Some(b)) = (&found.serial, serial)
            && a != b
        {
            let what =
                format!("{origin}: serial = {a:?}; the file is read for serial number {b:?}");
            return Err(CalibrationError(what));
        }
        return Ok(found);
    }
    Ok(defaults.clone())
}

fn read(path: &Path) -> Result<Option<String>, CalibrationError> {
    let fail = |what: String| CalibrationError(format!("{}: {what}", path.display()));
    match std::fs::metadata(path) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(fail(e.to_string())),
        Ok(about) if about.len() > MOST_BYTES => {
            let what = format!(
                "{} bytes; a device file has at most {MOST_BYTES}",
                about.len()
            );
            return Err(fail(what));
        }
        Ok(_) => {}
    }
    match std::fs::read_to_string(path) {
        Ok(text) => Ok(Some(text)),
        Err(e) => Err(fail(e.to_string())),
    }
}

/// Writes the file of a device into `folder`, beside and then in its place; the path written.
///
/// # Errors
/// The folder cannot be made or the file not be written.
pub fn save(folder: &Path, calibration: &Calibration) -> Result<PathBuf, CalibrationError> {
    let path = folder.join(file_name(
        &calibration.family,
        calibration.serial.as_deref(),
    ));
    let fail = |e: std::io::Error| CalibrationError(format!("{}: {e}", path.display()));
    std::fs::create_dir_all(folder).map_err(fail)?;
    let mut beside = tempfile::NamedTempFile::new_in(folder).map_err(fail)?;
    beside
        .write_all(calibration.to_toml().as_bytes())
        .and_then(|()| beside.as_file().sync_all())
        .map_err(fail)?;
    beside.persist(&path).map_err(|e| fail(e.error))?;
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::hid::models::ARMS;

    fn arm(serial: Option<&str>) -> Calibration {
        let mut c = Calibration::plain("woodenhaptics", 5.0, 1.0);
        c.arm = Some(ARMS[0].arm());
        c.serial = serial.map(Into::into);
        c
    }

    #[test]
    fn a_device_has_its_own_file_and_others_that_of_the_family() {
        let folder = tempfile::tempdir().expect("folder");
        let at = folder.path().join("devices");
        assert_eq!(load(&at, Some("7"), &arm(None)), Ok(arm(None)));
        let mut own = arm(Some("7"));
        own.mapping.scale = 2.0;
        let path = save(&at, &own).expect("written");
        assert_eq!(
            path.file_name().and_then(|n| n.to_str()),
            Some("woodenhaptics-7.toml")
        );
        let mut all = arm(None);
        all.mapping.scale = 3.0;
        save(&at, &all).expect("written");
        assert_eq!(load(&at, Some("7"), &arm(None)), Ok(own));
        assert_eq!(load(&at, Some("8"), &arm(None)), Ok(all.clone()));
        assert_eq!(load(&at, None, &arm(None)), Ok(all));
        assert_eq!(
            std::fs::read_dir(&at).expect("folder").count(),
            2,
            "nothing is left beside"
        );
    }

    #[test]
    fn a_file_copied_for_another_serial_number_is_refused() {
        let folder = tempfile::tempdir().expect("folder");
        let path = save(folder.path(), &arm(Some("7"))).expect("written");
        std::fs::rename(
            path,
            folder.path().join(file_name("woodenhaptics", Some("8"))),
        )
        .expect("moved");
        let error = load(folder.path(), Some("8"), &arm(None))
            .expect_err("refused")
            .to_string();
        assert!(
            error.contains("serial = \"7\"; the file is read for serial number \"8\""),
            "{error}"
        );
    }

    #[test]
    fn no_serial_number_leaves_the_folder_and_two_never_share_a_file() {
        let names: Vec<String> = [
            "../../etc",
            "a/b",
            "a_b",
            "a b",
            "",
            "ö",
            "A:B",
            &"x".repeat(500),
        ]
        .iter()
        .map(|s| file_name("w", Some(s)))
        .collect();
        for (i, name) in names.iter().enumerate() {
            assert!(!name.contains('/') && name.len() < 100, "{name}");
            assert!(!names[..i].contains(name), "{name} twice");
        }
    }
}
