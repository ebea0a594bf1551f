//! What is done for devices on a thread: each task comes to one result.

use super::open::{self, Opened, Order, is_emulated};
use crate::device::{Calibration, DeviceError, Found, all, calibration};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Time that a device gets to be let go before it is opened again.
pub const LET_GO: Duration = Duration::from_millis(150);

/// Something to be done.
pub enum Task {
    /// Open a device, after a while.
    Open {
        /// Which.
        order: Order,
        /// How long to wait.
        after: Duration,
    },
    /// Write a device file.
    Save {
        /// Whose device.
        finger: usize,
        /// What is written.
        calibration: Box<Calibration>,
    },
    /// Remove a device file.
    Forget {
        /// Whose device.
        finger: usize,
        /// Which device.
        found: Found,
    },
    /// Find out which families cannot be looked for.
    Survey,
    /// Look for devices of families whose looking loads a maker's library.
    AskMakers,
}

/// What came of it.
pub enum Done {
    /// A device is ready.
    Opened(Box<Opened>),
    /// It did not work.
    Failed {
        /// What was to be opened, where something was.
        order: Option<Order>,
        /// Why, in a line.
        why: String,
    },
    /// Families that cannot be looked for, and why.
    Surveyed {
        /// Key and reason.
        missing: Vec<(&'static str, String)>,
    },
    /// What makers' libraries tell.
    Makers {
        /// What is attached.
        found: Vec<Found>,
        /// Key and reason of those that are not there.
        missing: Vec<(&'static str, String)>,
    },
    /// A device file is written.
    Saved {
        /// Whose device.
        finger: usize,
        /// The file.
        path: PathBuf,
    },
    /// A device file is removed.
    Forgotten {
        /// Whose device.
        finger: usize,
        /// The file.
        path: PathBuf,
    },
}

impl Task {
    /// Whether it opens a device for this finger.
    pub fn is_for(&self, finger: usize) -> bool {
        matches!(self, Self::Open { order, .. } if order.finger == finger)
    }

    /// Whether it opens a simulated device.
    pub fn is_emulated(&self) -> bool {
        matches!(self, Self::Open { order, .. } if is_emulated(&order.found))
    }

    /// For people.
    pub fn title(&self) -> String {
        match self {
            Self::Open { order, .. } => format!("Opening {}", order.found.title),
            Self::Save { .. } => "Writing the device file".into(),
            Self::Forget { .. } => "Removing the device file".into(),
            Self::Survey | Self::AskMakers => "Looking for devices".into(),
        }
    }

    /// Does it; device files are in `folder`, the servo runs at `rate_hz`.
    pub fn run(self, folder: &Path, rate_hz: f64) -> Done {
        match self {
            Self::Open { order, after } => {
                std::thread::sleep(after);
                match open::open(&order, folder, rate_hz) {
                    Ok(opened) => Done::Opened(Box::new(opened)),
                    Err(e) => Done::Failed {
                        why: e.to_string(),
                        order: Some(order),
                    },
                }
            }
            Self::Save {
                finger,
                calibration,
            } => match calibration::save(folder, &calibration) {
                Ok(path) => Done::Saved { finger, path },
                Err(e) => failed(&e),
            },
            Self::Forget { finger, found } => {
                let name = calibration::file_name(found.family, found.serial.as_deref());
                let path = folder.join(name);
                match std::fs::remove_file(&path) {
                    Ok(()) => Done::Forgotten { finger, path },
                    Err(e) if e.kind() == std::io::ErrorKind::NotFound => failed(&format!(
                        "{}: there is no such file; published values are in use",
                        path.display()
                    )),
                    Err(e) => failed(&format!("{}: {e}", path.display())),
                }
            }
            Self::Survey => Done::Surveyed {
                missing: missing(true),
            },
            Self::AskMakers => {
                let makers = all().iter().filter(|f| !f.may_be_watched());
                Done::Makers {
                    found: makers.flat_map(|f| f.find()).collect(),
                    missing: missing(false),
                }
            }
        }
    }
}

fn failed(why: &dyn std::fmt::Display) -> Done {
    Done::Failed {
        order: None,
        why: DeviceError::new(why).to_string(),
    }
}

/// Families that are watched, or those that are not, which cannot be looked for.
fn missing(watched: bool) -> Vec<(&'static str, String)> {
    let families = all().iter().filter(|f| f.may_be_watched() == watched);
    families
        .filter_map(|f| Some((f.key(), f.ready().err()?.to_string())))
        .collect()
}
