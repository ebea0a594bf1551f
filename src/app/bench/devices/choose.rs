//! Which device moves which finger, and what of that is remembered from one run to the next.

use crate::app::hardware::StiffnessChoice;
use crate::device::Found;
use serde::{Deserialize, Serialize};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Name of the file, beside the device files.
const FILE: &str = "fingers.json";
/// Most devices that are remembered; the oldest go first.
const MOST: usize = 64;

/// What a user chose for one device.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Choice {
    family: String,
    serial: Option<String>,
    /// The finger, from 0; `None`: it is left to the mouse.
    pub finger: Option<usize>,
    /// Where the skin is too stiff for it.
    #[serde(default)]
    pub stiffness: StiffnessChoice,
    /// Whether the passivity controller is on.
    #[serde(default)]
    pub passivity: bool,
}

/// The choices of this user on this machine.
#[derive(Clone, Debug, Default)]
pub struct Choices {
    path: PathBuf,
    list: Vec<Choice>,
}

impl Choices {
    /// Those kept in `folder`; none where nothing is, or what is cannot be read.
    pub fn read(folder: &Path) -> Self {
        let path = folder.join(FILE);
        let list = std::fs::read(&path)
            .ok()
            .and_then(|bytes| serde_json::from_slice::<Vec<Choice>>(&bytes).ok())
            .unwrap_or_default();
        Self { path, list }
    }

    /// What was chosen for a device. Simulated devices are not remembered.
    pub fn of(&self, found: &Found) -> Option<&Choice> {
        self.list
            .iter()
            .find(|c| c.family == found.family && c.serial == found.serial)
    }

    /// Remembers it.
    ///
    /// # Errors
    /// The file cannot be written: where, and why.
    pub fn keep(
        &mut self,
        found: &Found,
        finger: Option<usize>,
        stiffness: StiffnessChoice,
        passivity: bool,
    ) -> Result<(), String> {
        let choice = Choice {
            family: found.family.to_owned(),
            serial: found.serial.clone(),
            finger,
            stiffness,
            passivity,
        };
        self.list
            .retain(|c| (&c.family, &c.serial) != (&choice.family, &choice.serial));
        self.list.push(choice);
        let over = self.list.len().saturating_sub(MOST);
        self.list.drain(..over);
        self.write()
            .map_err(|e| format!("{}: {e}", self.path.display()))
    }

    fn write(&self) -> std::io::Result<()> {
        let folder = self.path.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder)?;
        let mut beside = tempfile::NamedTempFile::new_in(folder)?;
        beside.write_all(&serde_json::to_vec_pretty(&self.list)?)?;
        beside.persist(&self.path).map_err(|e| e.error)?;
        Ok(())
    }
}

/// The finger that a device takes when it is plugged in; `None`: it waits to be asked for.
///
/// One that was chosen for is where it was, if that finger is free. Others, and a twin of one that took its finger, take a free
/// one, that which their file names before others; a device without force waits, since many lie on desks for other work.
pub fn finger_for(
    chosen: Option<&Choice>,
    named: usize,
    has_force: bool,
    free: &[bool],
) -> Option<usize> {
    let is_free = |finger: usize| free.get(finger).copied().unwrap_or(false);
    let wanted = match chosen {
        Some(choice) => choice.finger?,
        None if !has_force => return None,
        None => named,
    };
    if is_free(wanted) {
        Some(wanted)
    } else {
        free.iter().position(|free| *free)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(serial: Option<&str>) -> Found {
        Found {
            family: "woodenhaptics",
            place: "1".into(),
            title: "W".into(),
            serial: serial.map(Into::into),
            note: None,
        }
    }

    #[test]
    fn a_device_goes_where_it_was_and_a_new_one_where_there_is_room() {
        let at = |finger| Choice {
            family: "f".into(),
            serial: None,
            finger,
            stiffness: StiffnessChoice::AsIs,
            passivity: false,
        };
        let both = [true, true];
        assert_eq!(finger_for(None, 0, true, &both), Some(0));
        assert_eq!(
            finger_for(None, 1, true, &both),
            Some(1),
            "as its file says"
        );
        assert_eq!(finger_for(None, 0, true, &[false, true]), Some(1));
        assert_eq!(finger_for(None, 0, true, &[false, false]), None);
        assert_eq!(finger_for(None, 7, true, &both), Some(0));
        assert_eq!(finger_for(None, 0, false, &both), None, "no force");
        assert_eq!(finger_for(Some(&at(Some(1))), 0, false, &both), Some(1));
        let twin = finger_for(Some(&at(Some(0))), 0, true, &[false, true]);
        assert_eq!(twin, Some(1), "its twin is at 0");
        assert_eq!(finger_for(Some(&at(None)), 0, true, &both), None);
    }

    #[test]
    fn choices_come_back_and_a_broken_file_is_none() {
        let folder = tempfile::tempdir().expect("folder");
        let at = folder.path().join("devices");
        let mut choices = Choices::read(&at);
        assert_eq!(choices.of(&found(None)), None);
        let kept = choices.keep(&found(Some("7")), Some(1), StiffnessChoice::Clamp, true);
        assert_eq!(kept, Ok(()));
        let kept = choices.keep(&found(None), None, StiffnessChoice::AsIs, false);
        assert_eq!(kept, Ok(()));
        let back = Choices::read(&at);
        let seven = back.of(&found(Some("7"))).expect("kept");
        assert_eq!(
            (seven.finger, seven.stiffness, seven.passivity),
            (Some(1), StiffnessChoice::Clamp, true)
        );
        assert_eq!(back.of(&found(None)).map(|c| c.finger), Some(None));
        assert_eq!(back.of(&found(Some("8"))), None);
        assert_eq!(std::fs::read_dir(&at).expect("folder").count(), 1);
        std::fs::write(at.join(FILE), "{").expect("written");
        assert_eq!(Choices::read(&at).of(&found(None)), None);
    }
}
