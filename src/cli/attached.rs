//! Devices that a run is felt with: found, calibrated, laid over the scenario, held against its stiffness.

use super::CliError;
use crate::device::calibration::{self, Calibration};
use crate::device::hid::emulator::Outcome as Truth;
use crate::device::hid::guard::Condition;
use crate::device::stable::Stable;
use crate::device::{Capabilities, Device, Family, Found, Vitals, all, by_key};
use crate::geom::Vec3;
use crate::scenario::Scene;
use crate::servo::{MAX_FINGERS, StiffnessBound};
use std::cell::Cell;
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

/// Which devices, for how long.
#[derive(Debug, clap::Args)]
pub struct HandsArgs {
    /// Feel with a device: its family, or family and place as "dorsum devices" tells them. Once for each finger.
    #[arg(long, value_name = "FAMILY[:PLACE]")]
    device: Vec<String>,
    /// Feel with an emulated device of this family, which a simulated hand presses. Once for each finger.
    #[arg(long, value_name = "FAMILY", conflicts_with = "device")]
    emulator: Vec<String>,
    /// What goes wrong with the emulated device once it is pressed: unplugged, frozen, silent, jump, extreme, short, slow, reversed.
    #[arg(long, value_name = "FAULT", requires = "emulator")]
    fault: Option<String>,
    /// Folder of the device files, instead of the user's.
    #[arg(long, value_name = "FOLDER")]
    folder: Option<PathBuf>,
    /// How long it is felt with devices, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    seconds: f64,
    /// Where the scenario is stiffer than the device renders stably.
    #[arg(long, value_enum, default_value_t = Choice::AsIs)]
    stiffness: Choice,
}

/// What becomes of stiffness that a device does not render stably.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Choice {
    /// Rendered all the same; it is told.
    AsIs,
    /// All of it softer in proportion.
    Scale,
    /// Softer only where it is too stiff.
    Clamp,
}

/// Apart of two devices that say nothing about where they belong, mm.
const APART_MM: f64 = 60.0;

/// A device that is felt with.
pub(super) struct Hand {
    pub(super) capabilities: Capabilities,
    vitals: Option<Arc<Vitals>>,
    /// The last trouble it had.
    trouble: Cell<Option<Condition>>,
    pub(super) calibration: Calibration,
    stable: Stable,
    stiffest_n_per_mm: f64,
    pub(super) bound: StiffnessBound,
    #[cfg(target_os = "linux")]
    emulated: Option<crate::device::hid::emulator::process::Emulated>,
}

/// One per finger, for the servo.
type Devices = Vec<Box<dyn Device>>;

/// What is said about it afterwards. Bounds that are not there are `null`.
#[derive(serde::Serialize)]
pub(super) struct Told {
    device: String,
    stable: Stable,
    rendered_n_per_mm: f64,
    scenario_n_per_mm: f64,
    stiffness: StiffnessBound,
    /// The last trouble it had, if any.
    trouble: Option<Condition>,
    /// What the emulated device says; only there.
    #[serde(skip_serializing_if = "Option::is_none")]
    truth: Option<Truth>,
}

impl fmt::Display for Told {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (scenario, rendered) = (self.scenario_n_per_mm, self.rendered_n_per_mm);
        write!(f, "{}: {}; ", self.device, stable_line(&self.stable))?;
        if let Some(trouble) = self.trouble {
            write!(f, "{}; ", trouble.title())?;
        }
        if scenario <= rendered {
            return write!(f, "the scenario has {scenario:.2} N/mm");
        }
        write!(
            f,
            "the scenario has {scenario:.2} N/mm, more than {rendered:.2}: "
        )?;
        match self.stiffness {
            StiffnessBound::AsIs => write!(
                f,
                "rendered all the same (--stiffness scale or clamp softens it)"
            ),
            StiffnessBound::Scale { factor } => write!(f, "all scaled by {factor:.3}"),
            StiffnessBound::Clamp { n_per_mm } => write!(f, "clamped at {n_per_mm:.2} N/mm"),
        }
    }
}

/// The four answers side by side.
pub(super) fn stable_line(s: &Stable) -> String {
    let answers = [
        ("maker", s.told_n_per_mm),
        ("passive", s.passive_n_per_mm),
        ("with a hand", s.coupled_n_per_mm),
        ("by encoder steps", s.quantised_n_per_mm),
    ];
    let told = answers.map(|(what, k)| {
        if k.is_finite() {
            format!("{what} {k:.2}")
        } else {
            format!("{what} unbounded")
        }
    });
    format!("stable N/mm: {}", told.join(", "))
}

impl HandsArgs {
    /// How many devices are asked for.
    pub(super) fn n(&self) -> usize {
        self.device.len().max(self.emulator.len())
    }

    /// How long it is felt with them, s.
    pub(super) fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Opens them over `scene`; force is off until the servo switches it on.
    pub(super) fn open(
        &self,
        scene: &Scene,
        at: Option<(f64, f64)>,
        rate_hz: f64,
    ) -> Result<(Vec<Hand>, Devices), CliError> {
        if !(0.1..=86_400.0).contains(&self.seconds) {
            let what = format_args!("--seconds {}; 0.1 to 86400 is allowed", self.seconds);
            return Err(CliError::input(what));
        }
        if self.n() > MAX_FINGERS {
            let what = format_args!("{} devices; {MAX_FINGERS} at most", self.n());
            return Err(CliError::input(what));
        }
        let mut taken: Vec<Found> = Vec::new();
        let (mut hands, mut devices) = (Vec::new(), Vec::new());
        for i in 0..self.n() {
            let (hand, device) = if self.emulator.is_empty() {
                self.attached(&self.device[i], &mut taken, scene, self.place(i, at, scene))?
            } else {
                self.emulated(&self.emulator[i], scene, self.place(i, at, scene))?
            };
            hands.push(self.held_against(scene, hand, rate_hz));
            devices.push(device);
        }
        Ok((hands, devices))
    }

    /// Where on the map plane finger `i` of several is laid unless its file says so.
    fn place(&self, i: usize, at: Option<(f64, f64)>, scene: &Scene) -> (f64, f64) {
        let (x, y) = at.unwrap_or_else(|| scene.default_place_mm());
        let middle = 0.5 * (self.n() - 1) as f64;
        (x + APART_MM * (i as f64 - middle), y)
    }

    fn attached(
        &self,
        asked: &str,
        taken: &mut Vec<Found>,
        scene: &Scene,
        place: (f64, f64),
    ) -> Result<(Hand, Box<dyn Device>), CliError> {
        let (key, at) = match asked.split_once(':') {
            Some((key, at)) => (key, Some(at)),
            None => (asked, None),
        };
        let Some(family) = by_key(key) else {
            let keys: Vec<_> = all().iter().map(|f| f.key()).collect();
            let what = format_args!("--device {asked}: there are {}", keys.join(", "));
            return Err(CliError::input(what));
        };
        family.ready().map_err(CliError::input)?;
        let free = |f: &Found| {
            !taken
                .iter()
                .any(|t| t.place == f.place && t.family == f.family)
        };
        let mut found = family.find().into_iter().filter(free);
        let Some(found) = found.find(|f| at.is_none_or(|at| f.place == at)) else {
            let place = at.map_or(String::new(), |at| format!(" at {at}"));
            return Err(CliError::input(format_args!(
                "no {} is attached{place}; \"dorsum devices\" lists what is, --emulator {key} does without",
                family.title()
            )));
        };
        let mut calibration = self.calibration(family, found.serial.as_deref())?;
        lay(&mut calibration, scene, place);
        let device = family.open(&found, &calibration).map_err(CliError::input)?;
        taken.push(found);
        Ok((Hand::of(&*device, calibration), device))
    }

    fn calibration(
        &self,
        family: &dyn Family,
        serial: Option<&str>,
    ) -> Result<Calibration, CliError> {
        let folder = self.folder.clone().or_else(super::devices::users_folder);
        match folder {
            Some(folder) => {
                calibration::load(&folder, serial, &family.defaults()).map_err(CliError::input)
            }
            None => Ok(family.defaults()),
        }
    }

    #[cfg(target_os = "linux")]
    fn emulated(
        &self,
        key: &str,
        scene: &Scene,
        place: (f64, f64),
    ) -> Result<(Hand, Box<dyn Device>), CliError> {
        use crate::device::hid::emulator::Fault;
        use crate::device::hid::emulator::process::{Emulated, Request, family};
        let arms = family(key).map_err(CliError::input)?;
        let fault = match &self.fault {
            None => None,
            Some(name) => Some(Fault::by_key(name).ok_or_else(|| {
                let names = Fault::ALL.map(Fault::key).join(", ");
                CliError::input(format_args!("--fault \"{name}\"; allowed are {names}"))
            })?),
        };
        let request = Request {
            // It is to be there until the host goes.
            seconds: self.seconds + 60.0,
            fault,
            ..Request::press(arms.key())
        };
        let program = std::env::current_exe().map_err(CliError::input)?;
        let (emulated, port) = Emulated::spawn(&program, &request).map_err(CliError::input)?;
        let mut calibration = self.calibration(arms, None)?;
        lay(&mut calibration, scene, place);
        let device = arms
            .open_port(port, &calibration)
            .map_err(CliError::input)?;
        let hand = Hand {
            emulated: Some(emulated),
            ..Hand::of(&device, calibration)
        };
        Ok((hand, Box::new(device)))
    }

    #[cfg(not(target_os = "linux"))]
    fn emulated(
        &self,
        _key: &str,
        _scene: &Scene,
        _place: (f64, f64),
    ) -> Result<(Hand, Box<dyn Device>), CliError> {
        Err(CliError::input("emulated devices need Linux"))
    }

    fn held_against(&self, scene: &Scene, hand: Hand, rate_hz: f64) -> Hand {
        let stable = Stable::of(&hand.capabilities, &hand.calibration, rate_hz);
        let (stiffest, renders) = (scene.stiffest_n_per_mm(), stable.rendered_n_per_mm());
        Hand {
            bound: match self.stiffness {
                Choice::AsIs => StiffnessBound::AsIs,
                Choice::Scale => StiffnessBound::scaled(stiffest, renders),
                Choice::Clamp if stiffest > renders => StiffnessBound::clamped(renders),
                Choice::Clamp => StiffnessBound::AsIs,
            },
            stable,
            stiffest_n_per_mm: stiffest,
            ..hand
        }
    }
}

/// Lays the middle of the workspace on the skin at `place`, where the device file does not say where it lies.
fn lay(calibration: &mut Calibration, scene: &Scene, (x, y): (f64, f64)) {
    let offset_mm = &mut calibration.mapping.offset_mm;
    if *offset_mm == Vec3::ZERO {
        let top_mm = scene.surface.bounds().max.z;
        *offset_mm = Vec3::new(x, y, scene.height_mm(x, y).unwrap_or(top_mm));
    }
}

impl Hand {
    fn of(device: &dyn Device, calibration: Calibration) -> Self {
        Self {
            vitals: device.vitals(),
            capabilities: device.capabilities().clone(),
            trouble: Cell::new(None),
            stable: Stable::of(device.capabilities(), &calibration, 1000.0),
            calibration,
            stiffest_n_per_mm: 0.0,
            bound: StiffnessBound::AsIs,
            #[cfg(target_os = "linux")]
            emulated: None,
        }
    }

    /// Looks how it is; whether it went for good, and how.
    pub(super) fn gone(&self) -> Option<String> {
        let condition = self.vitals.as_ref()?.condition();
        if !matches!(
            condition,
            Condition::Waiting | Condition::Good | Condition::Closed
        ) {
            self.trouble.set(Some(condition));
        }
        let gone = matches!(condition, Condition::Unplugged | Condition::Ended);
        gone.then(|| format!("{}: {}", self.capabilities.name, condition.title()))
    }

    /// What there is to say of it; after its device was closed.
    pub(super) fn told(self) -> Result<Told, CliError> {
        #[cfg(target_os = "linux")]
        let truth = self.emulated.map(|e| e.outcome().map_err(CliError::input));
        #[cfg(not(target_os = "linux"))]
        let truth: Option<Result<Truth, CliError>> = None;
        Ok(Told {
            device: self.capabilities.name,
            stable: self.stable,
            rendered_n_per_mm: self.stable.rendered_n_per_mm(),
            scenario_n_per_mm: self.stiffest_n_per_mm,
            stiffness: self.bound,
            trouble: self.trouble.get(),
            truth: truth.transpose()?,
        })
    }
}
