//! What the window knows of devices, and what it can ask of them.

use crate::device::stable::Stable;
use crate::device::{Calibration, Capabilities, Found, Vitals};
use crate::servo::Limits;
use std::path::PathBuf;
use std::sync::Arc;

/// Devices at one frame.
#[derive(Clone, Debug, Default)]
pub struct Hardware {
    /// What is attached, in the order it came.
    pub attached: Vec<Attached>,
    /// What moves each finger.
    pub fingers: Vec<FingerDevice>,
    /// Families that cannot be looked for on this machine: key, and why.
    pub missing: Vec<(&'static str, String)>,
    /// Whether those families were asked too whose looking loads a maker's library.
    pub makers_asked: bool,
    /// What is being done: a device opened, a file written.
    pub working: Option<String>,
    /// Why nothing may be changed at the moment, in a sentence.
    pub locked: Option<&'static str>,
    /// Where device files are kept.
    pub folder: PathBuf,
}

/// A device that is attached.
#[derive(Clone, Debug, PartialEq)]
pub struct Attached {
    /// What it is.
    pub found: Found,
    /// It is a simulated one.
    pub emulated: bool,
    /// The finger that it moves.
    pub finger: Option<usize>,
    /// Why it could not be used.
    pub trouble: Option<String>,
}

/// What moves a finger.
#[derive(Clone, Debug)]
pub struct FingerDevice {
    /// Name, also that in recordings.
    pub name: String,
    /// Its device; `None`: the mouse.
    pub device: Option<Arc<InUse>>,
    /// It was pulled out, and the finger is held without force until the recording that runs is finished.
    pub gone: bool,
    /// It is under the skin without touching it, as one is that went in while its force was off.
    pub sunk: bool,
    /// Bounds on its force.
    pub limits: Limits,
    /// What is done where the skin is stiffer than it renders.
    pub stiffness: StiffnessChoice,
    /// The force test under way: force along its axis, N, and share of its time that is over, 0 to 1.
    pub test: Option<(f64, f64)>,
}

/// A device in use.
#[derive(Clone, Debug)]
pub struct InUse {
    /// What it is.
    pub found: Found,
    /// It is a simulated one.
    pub emulated: bool,
    /// What it can do, said of the finger on the subject.
    pub capabilities: Capabilities,
    /// How it is calibrated.
    pub calibration: Calibration,
    /// What its link tells; `None` for one without a link.
    pub vitals: Option<Arc<Vitals>>,
    /// How stiff a skin it renders.
    pub stable: Stable,
}

/// What is done where the skin is stiffer than a device renders without shaking.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum StiffnessChoice {
    /// Nothing.
    #[default]
    AsIs,
    /// The whole skin is made softer by one factor: what is stiffer than what stays so.
    Scale,
    /// What is too stiff is made as stiff as can be; the rest stays.
    Clamp,
}

impl StiffnessChoice {
    /// All.
    pub const ALL: [Self; 3] = [Self::AsIs, Self::Scale, Self::Clamp];

    /// For people.
    pub fn title(self) -> &'static str {
        match self {
            Self::AsIs => "As it is",
            Self::Scale => "Scale",
            Self::Clamp => "Clamp",
        }
    }
}

/// What is asked of devices.
#[derive(Clone, Debug, PartialEq)]
pub enum DeviceWish {
    /// Have a finger moved by an attached device, or by the mouse.
    Assign {
        /// Which finger.
        finger: usize,
        /// By what; `None`: the mouse.
        found: Option<Found>,
    },
    /// Look for devices that need a maker's library, too.
    AskMakers,
    /// Calibrate the device of a finger so, and write that into its file.
    Calibrate {
        /// Which finger.
        finger: usize,
        /// How.
        calibration: Box<Calibration>,
    },
    /// Calibrate the device of a finger as published: its own file is removed.
    ResetCalibration {
        /// Which finger.
        finger: usize,
    },
    /// Take where the device of a finger stands for the middle of its workspace on the subject.
    Recentre {
        /// Which finger.
        finger: usize,
    },
    /// Let a latched fault of a finger's device go.
    Release {
        /// Which finger.
        finger: usize,
    },
    /// Push with a device: force rises for [`crate::device::push::RISE_S`], stays, and falls.
    Test {
        /// Which finger.
        finger: usize,
        /// Axis of the subject: 0 x, 1 y, 2 z.
        axis: usize,
        /// Force at the top, N; its sign is the direction. Not more than half of what the device holds without end.
        force_n: f64,
    },
    /// End the force test of a finger.
    StopTest {
        /// Which finger.
        finger: usize,
    },
    /// What is done where the skin is too stiff for the device of a finger.
    Stiffness {
        /// Which finger.
        finger: usize,
        /// What.
        choice: StiffnessChoice,
    },
    /// Switch the passivity controller of a finger.
    Passivity {
        /// Which finger.
        finger: usize,
        /// On or off.
        on: bool,
    },
    /// Attach a simulated device of this family in a simulated hand. Linux only.
    Emulate {
        /// Key of the family.
        family: &'static str,
        /// What goes wrong with it once it is pressed: a key of the emulator's faults.
        fault: Option<&'static str>,
    },
    /// Pull every simulated device out.
    EndEmulation,
}
