//! Devices at the bench: what is attached, which finger each moves, what became of it.
//!
//! Opening, looking and writing files happen on a thread; the servo gets devices that are ready. While a recording or an
//! exercise runs nothing changes: a device that is pulled out leaves its finger without force, and the same device plugged in
//! again takes it back, with the bounds that the recording tells.

mod choose;
mod news;
mod open;
mod wishes;
mod work;

use super::Bench;
use super::job::Job;
use super::live::FINGERS;
use crate::app::hardware::{Attached, FingerDevice, Hardware, StiffnessChoice};
use crate::app::messages::Level;
use crate::app::state::BuildStatus;
use crate::device::hid::guard::Condition;
use crate::device::plug::{self, Change, Watch};
use crate::device::{Found, by_key, calibration};
use crate::servo::{self, Halt, Limits, StiffnessBound};
use choose::{Choices, finger_for};
use open::{Order, Used, is_emulated};
use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};
use work::{Done, Task};

/// How often is looked for what was plugged in.
const LOOK_EVERY: Duration = Duration::from_millis(500);

/// What passes by itself is not told more often than this.
const QUIET: Duration = Duration::from_secs(20);
/// A device that answers for so long is told to answer again.
const STAYS: Duration = Duration::from_secs(1);

/// The devices of the bench.
pub struct Devices {
    folder: PathBuf,
    watch: Option<(Watch, Receiver<Change>)>,
    attached: Vec<Attached>,
    /// What goes wrong with simulated devices, by place.
    faults: BTreeMap<String, &'static str>,
    /// Simulated devices so far.
    simulated: usize,
    choices: Choices,
    fingers: [Finger; FINGERS],
    tasks: VecDeque<Task>,
    job: Option<(Job<Done>, String)>,
    missing: Vec<(&'static str, String)>,
    makers_asked: bool,
    /// Why all force ended, as last told.
    halted: Option<Halt>,
    /// Scene and edit that the bounds were made for.
    bounded: Option<(u64, u64)>,
}

/// What moves one finger.
#[derive(Default)]
struct Finger {
    used: Option<Used>,
    condition: Condition,
    gone: bool,
    sunk: bool,
    /// Times that force was taken off it, as last seen.
    taken_off: u64,
    stiffness: StiffnessChoice,
    passivity: bool,
    /// Counts what was asked for this finger.
    asked: u64,
    /// When it was told last that something is amiss which passes by itself.
    amiss: Option<Instant>,
    /// Since when it answers again, where that is still to be told.
    back: Option<Instant>,
}

impl Default for Devices {
    fn default() -> Self {
        Self::new(calibration::usual_folder())
    }
}

impl Devices {
    /// None yet; device files are in `folder`.
    fn new(folder: PathBuf) -> Self {
        Self {
            choices: Choices::read(&folder),
            folder,
            watch: None,
            attached: Vec::new(),
            faults: BTreeMap::new(),
            simulated: 0,
            fingers: Default::default(),
            tasks: VecDeque::new(),
            job: None,
            missing: Vec::new(),
            makers_asked: false,
            halted: None,
            bounded: None,
        }
    }

    /// Whether the device of a finger tells by itself how it is.
    pub fn tells_itself(&self, finger: usize) -> bool {
        let used = self.fingers.get(finger).and_then(|f| f.used.as_ref());
        used.is_some_and(|u| u.told.vitals.is_some())
    }

    fn free(&self) -> [bool; FINGERS] {
        let waits = |finger: usize| {
            self.tasks.iter().any(|t| t.is_for(finger))
                || self.attached.iter().any(|a| a.finger == Some(finger))
        };
        std::array::from_fn(|i| self.fingers[i].used.is_none() && !waits(i))
    }

    fn came(&mut self, found: Found) {
        // Of twins the one that was plugged in there.
        let back = |f: &Finger, there: bool| {
            let used = f.used.as_ref().filter(|_| f.gone);
            used.is_some_and(|u| {
                let before = &u.told.found;
                same(before, &found) && (!there || before.place == found.place)
            })
        };
        let there = self.fingers.iter().position(|f| back(f, true));
        let again = there.or_else(|| self.fingers.iter().position(|f| back(f, false)));
        let family = by_key(found.family);
        let defaults = family.map(|f| f.defaults());
        let file = defaults.as_ref().and_then(|defaults| {
            calibration::load(&self.folder, found.serial.as_deref(), defaults).ok()
        });
        let named = file.as_ref().map_or(0, |c| usize::from(c.mapping.finger));
        let has_force = file.is_some_and(|c| c.rated_force_n > 0.0);
        let chosen = self.choices.of(&found).filter(|_| !is_emulated(&found));
        let finger = again.or_else(|| finger_for(chosen, named, has_force, &self.free()));
        self.attached.push(Attached {
            emulated: is_emulated(&found),
            found: found.clone(),
            finger,
            trouble: None,
        });
        if let Some(finger) = finger {
            self.open(finger, found, Duration::ZERO);
        }
    }

    /// Has `found` opened for `finger`, after a while.
    fn open(&mut self, finger: usize, found: Found, after: Duration) {
        if let Some(choice) = self.choices.of(&found).filter(|_| !is_emulated(&found)) {
            self.fingers[finger].stiffness = choice.stiffness;
            self.fingers[finger].passivity = choice.passivity;
        }
        let fault = self.faults.get(&found.place).copied();
        let number = self.forget_asked(finger);
        self.tasks.push_back(Task::Open {
            order: Order {
                finger,
                found,
                fault,
                number,
            },
            after,
        });
    }

    /// Nothing that was asked for a finger before is carried out; the number of what is asked for next.
    fn forget_asked(&mut self, finger: usize) -> u64 {
        self.tasks.retain(|t| !t.is_for(finger));
        self.fingers[finger].asked += 1;
        self.fingers[finger].asked
    }

    /// Remembers what moves a finger, and how; answers what went wrong.
    fn keep(&mut self, found: &Found, finger: Option<usize>) -> Option<String> {
        if is_emulated(found) {
            return None;
        }
        let how = finger.map_or((StiffnessChoice::AsIs, false), |f| {
            (self.fingers[f].stiffness, self.fingers[f].passivity)
        });
        self.choices.keep(found, finger, how.0, how.1).err()
    }
}

/// Whether two are the same device, plugged in twice.
fn same(a: &Found, b: &Found) -> bool {
    (a.family, &a.serial, &a.title) == (b.family, &b.serial, &b.title)
}

impl Bench {
    /// Looks for devices from now on.
    pub fn watch_devices(&mut self) {
        self.devices.tasks.push_back(Task::Survey);
        self.look_again();
    }

    /// Looks anew: what is attached is told once more.
    fn look_again(&mut self) {
        match Watch::start(plug::looker(), LOOK_EVERY) {
            Ok(watch) => self.devices.watch = Some(watch),
            Err(e) => self.tell(Level::Error, format!("devices cannot be looked for: {e}")),
        }
    }

    /// Why no finger may be given another device now.
    fn devices_locked(&self) -> Option<&'static str> {
        if self.exercise.is_some() {
            Some("An exercise runs: devices stay as they are until its end")
        } else if self.is_recording() || self.recordings.is_busy() {
            Some("A recording runs: devices stay as they are until its end")
        } else if self.live.is_none() {
            Some("The servo does not run yet")
        } else {
            None
        }
    }

    /// The bounds that go with the device of a finger in the open scene.
    fn limits_of(&self, finger: &Finger) -> Option<Limits> {
        let told = &finger.used.as_ref()?.told;
        let rendered = told.stable.rendered_n_per_mm();
        let stiffest = || self.scene.as_ref().map_or(0.0, |s| s.stiffest_n_per_mm());
        Some(Limits {
            passivity: finger.passivity,
            stiffness: match finger.stiffness {
                StiffnessChoice::AsIs => StiffnessBound::AsIs,
                StiffnessChoice::Scale => StiffnessBound::scaled(stiffest(), rendered),
                StiffnessChoice::Clamp => StiffnessBound::clamped(rendered),
            },
            ..Limits::of(&told.capabilities)
        })
    }

    fn bound_anew(&mut self, finger: usize) {
        let limits = self.limits_of(&self.devices.fingers[finger]);
        if let (Some(limits), Some(live)) = (limits, &mut self.live) {
            live.set_limits(finger, limits);
        }
    }

    /// Says once why all force ended; whether it did now.
    pub(super) fn poll_halt(&mut self) -> bool {
        let halted = servo::halted();
        if halted == self.devices.halted {
            return false;
        }
        self.devices.halted = halted;
        if let Some(halt) = halted {
            let text = format!("Force has ended on every device: {}", halt.title());
            self.tell(Level::Error, text);
        }
        true
    }

    /// Takes in what happened to devices; whether anything did.
    pub(super) fn poll_devices(&mut self) -> bool {
        let mut changed = false;
        let heard: Vec<Change> = match &self.devices.watch {
            Some((_, changes)) => changes.try_iter().collect(),
            None => Vec::new(),
        };
        for change in heard {
            changed = true;
            match change {
                Change::Came(found) if self.devices.attached.iter().any(|a| a.found == found) => {}
                Change::Came(found) => {
                    self.tell(Level::Info, format!("{} is attached", found.title));
                    self.devices.came(found);
                }
                Change::Went(found) => self.devices.attached.retain(|a| a.found != found),
            }
        }
        changed |= self.poll_device_work();
        for finger in 0..FINGERS {
            changed |= self.poll_condition(finger);
            changed |= self.poll_sunk(finger);
        }
        if self.devices_locked().is_some() {
            // What is recorded is the skin's force.
            for used in self.devices.fingers.iter().filter_map(|f| f.used.as_ref()) {
                used.push.end();
            }
        } else {
            for finger in 0..FINGERS {
                if self.devices.fingers[finger].gone {
                    self.by_mouse(finger);
                    changed = true;
                }
            }
            self.bound_for_scene();
        }
        changed
    }

    /// Another scene may be stiffer than the last.
    fn bound_for_scene(&mut self) {
        let now = Some((self.generation, self.edits.applied()));
        if self.devices.bounded == now || self.scene.is_none() {
            return;
        }
        self.devices.bounded = now;
        for finger in 0..FINGERS {
            if self.devices.fingers[finger].used.is_some() {
                self.bound_anew(finger);
                self.tell_too_stiff(finger);
            }
        }
    }

    /// Says where the scene is stiffer than a device renders and nothing is done about it.
    fn tell_too_stiff(&mut self, finger: usize) {
        let slot = &self.devices.fingers[finger];
        let (Some(used), Some(scene)) = (&slot.used, &self.scene) else {
            return;
        };
        let rendered = used.told.stable.rendered_n_per_mm();
        let stiffest = scene.stiffest_n_per_mm();
        if stiffest > rendered && slot.stiffness == StiffnessChoice::AsIs {
            let name = &used.told.capabilities.name;
            let text = format!(
                "{name} renders up to {rendered:.2} N/mm without shaking, and this scene has {stiffest:.2}: see Devices for what can be done"
            );
            let blind = format!(
                "{name} may shake on this scene, which is stiffer than it renders: see Devices for what can be done"
            );
            let hides = self.blind.is_some() && self.conceals;
            self.tell(Level::Warning, if hides { blind } else { text });
        }
    }

    /// Starts what is to be done, and takes in what is done.
    fn poll_device_work(&mut self) -> bool {
        if let Some((job, _)) = &self.devices.job {
            let Some(done) = job.poll(|| Done::Failed {
                order: None,
                why: "a device's thread ended unexpectedly".into(),
            }) else {
                return false;
            };
            self.devices.job = None;
            self.device_done(done);
            return true;
        }
        let locked = self.devices_locked().is_some();
        let fingers = &self.devices.fingers;
        let ready = self.devices.tasks.iter().position(|t| match t {
            // One that was pulled out comes back with the bounds that it had.
            Task::Open { order, .. } => {
                self.live.is_some() && (!locked || fingers[order.finger].gone)
            }
            Task::Save { .. } | Task::Forget { .. } => !locked,
            Task::Survey | Task::AskMakers => true,
        });
        let Some(task) = ready.and_then(|i| self.devices.tasks.remove(i)) else {
            return false;
        };
        let what = task.title();
        let status = BuildStatus {
            scenario: what.clone(),
            ..BuildStatus::default()
        };
        let folder = self.devices.folder.clone();
        let rate_hz = self.live.as_ref().map_or(1000.0, |l| l.rate_hz());
        let work = move |_: super::job::Progress<'_>| task.run(&folder, rate_hz);
        match Job::start("device", status, self.wake.clone(), work) {
            Ok(job) => self.devices.job = Some((job, what)),
            Err(e) => self.tell(Level::Error, format!("{what}: {e}")),
        }
        true
    }

    /// Devices as panels see them.
    pub(super) fn hardware(&self) -> Hardware {
        let live = self.live.as_ref();
        let fingers = live.into_iter().flat_map(|l| l.devices());
        let fingers = fingers.zip(&self.devices.fingers);
        Hardware {
            attached: self.devices.attached.clone(),
            fingers: fingers
                .map(|((name, limits), finger)| {
                    let used = finger.used.as_ref();
                    FingerDevice {
                        name: name.to_owned(),
                        device: used.map(|u| u.told.clone()),
                        gone: finger.gone,
                        sunk: finger.sunk,
                        limits: *limits,
                        stiffness: finger.stiffness,
                        test: used.and_then(|u| u.push.state()),
                    }
                })
                .collect(),
            missing: self.devices.missing.clone(),
            makers_asked: self.devices.makers_asked,
            working: self.devices.job.as_ref().map(|(_, what)| what.clone()),
            locked: self.devices_locked(),
            folder: self.devices.folder.clone(),
        }
    }
}
