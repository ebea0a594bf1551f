//! Devices at the bench: what is attached, which finger each moves, what became of it.
//!
//! Opening, looking and writing files happen on a thread; the servo gets devices that are ready. While a recording or an
//! exercise runs nothing changes: a device that is pulled out leaves its finger without force, and the same device plugged in
//! again takes it back, with the bounds that the recording tells.

mod choose;
mod open;
mod work;

use super::Bench;
use super::job::Job;
use super::live::{FINGERS, Live, Seat};
use crate::app::hardware::{Attached, DeviceWish, FingerDevice, Hardware, StiffnessChoice};
use crate::app::messages::Level;
use crate::app::state::BuildStatus;
use crate::device::hid::guard::Condition;
use crate::device::plug::{self, Change, Watch};
use crate::device::{Calibration, Found, by_key, calibration};
use crate::geom::Vec3;
use crate::servo::{self, Halt, Limits, StiffnessBound};
use choose::{Choices, finger_for};
use open::{Opened, Order, Used, is_emulated};
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

    /// Carries out what is asked of devices.
    pub fn device(&mut self, wish: DeviceWish) {
        let harmless = matches!(
            wish,
            DeviceWish::Release { .. } | DeviceWish::StopTest { .. } | DeviceWish::AskMakers
        );
        if let Some(why) = self.devices_locked().filter(|_| !harmless) {
            self.tell(Level::Warning, why);
            return;
        }
        let used = |bench: &Self, finger: usize| {
            let finger = bench.devices.fingers.get(finger)?;
            finger.used.as_ref().map(|u| u.told.clone())
        };
        match wish {
            DeviceWish::Assign { finger, found } => self.assign(finger, found),
            DeviceWish::AskMakers => {
                self.devices.makers_asked = true;
                self.devices.tasks.push_back(Task::AskMakers);
            }
            DeviceWish::Calibrate {
                finger,
                calibration,
            } => {
                if let Some(told) = used(self, finger) {
                    let calibration = Box::new(Calibration {
                        family: told.found.family.into(),
                        serial: told.found.serial.clone(),
                        ..*calibration
                    });
                    let task = Task::Save {
                        finger,
                        calibration,
                    };
                    self.devices.tasks.push_back(task);
                }
            }
            DeviceWish::ResetCalibration { finger } => {
                if let Some(told) = used(self, finger) {
                    let found = told.found.clone();
                    self.devices.tasks.push_back(Task::Forget { finger, found });
                }
            }
            DeviceWish::Recentre { finger } => {
                if let (Some(live), Some(scene)) = (&mut self.live, &self.scene)
                    && !live.recentre(finger, scene)
                {
                    let text = "Its device file says where it sits, or it does not answer: it stays where it is";
                    self.tell(Level::Warning, text);
                }
            }
            DeviceWish::Release { finger } => {
                if let Some(vitals) = used(self, finger).and_then(|t| t.vitals.clone()) {
                    vitals.release();
                }
            }
            DeviceWish::Test {
                finger,
                axis,
                force_n,
            } => self.push(finger, axis, force_n),
            DeviceWish::StopTest { finger } => {
                let finger = self.devices.fingers.get(finger);
                if let Some(used) = finger.and_then(|f| f.used.as_ref()) {
                    used.push.end();
                }
            }
            DeviceWish::Stiffness { finger, choice } => {
                if let Some(slot) = self.devices.fingers.get_mut(finger) {
                    slot.stiffness = choice;
                    self.bound_anew(finger);
                    self.keep_choice(finger);
                }
            }
            DeviceWish::Passivity { finger, on } => {
                if let Some(slot) = self.devices.fingers.get_mut(finger) {
                    slot.passivity = on;
                    self.bound_anew(finger);
                    self.keep_choice(finger);
                }
            }
            DeviceWish::Emulate { family, fault } => self.emulate(family, fault),
            DeviceWish::EndEmulation => {
                for finger in 0..FINGERS {
                    if used(self, finger).is_some_and(|told| told.emulated) {
                        self.by_mouse(finger);
                    }
                }
                self.devices.attached.retain(|a| !a.emulated);
                self.devices.tasks.retain(|t| !t.is_emulated());
            }
        }
    }

    fn assign(&mut self, finger: usize, found: Option<Found>) {
        if finger >= FINGERS {
            return;
        }
        let before = self.devices.fingers[finger].used.as_ref();
        if let Some(left) = before.map(|u| u.told.found.clone()) {
            let trouble = self.devices.keep(&left, None);
            self.tell_trouble(trouble);
        }
        self.by_mouse(finger);
        let Some(found) = found else { return };
        let attached = &self.devices.attached;
        let elsewhere = (attached.iter().find(|a| a.found == found)).and_then(|a| a.finger);
        if let Some(other) = elsewhere.filter(|f| *f != finger) {
            self.by_mouse(other);
        }
        for a in &mut self.devices.attached {
            if a.found == found {
                (a.finger, a.trouble) = (Some(finger), None);
            }
        }
        let trouble = self.devices.keep(&found, Some(finger));
        self.tell_trouble(trouble);
        self.devices.open(finger, found, work::LET_GO);
    }

    fn tell_trouble(&mut self, trouble: Option<String>) {
        if let Some(text) = trouble {
            self.tell(Level::Warning, format!("the choice is not kept: {text}"));
        }
    }

    /// Has a finger moved by the mouse; what moved it is closed.
    fn by_mouse(&mut self, finger: usize) {
        let asked = self.devices.forget_asked(finger);
        for a in &mut self.devices.attached {
            if a.finger == Some(finger) {
                a.finger = None;
            }
        }
        if self.devices.fingers[finger].used.is_none() {
            return;
        }
        self.devices.fingers[finger] = Finger {
            asked,
            ..Finger::default()
        };
        if let (Some(live), Some(scene)) = (&mut self.live, &self.scene) {
            live.use_mouse(finger, scene);
        }
    }

    /// Attaches a simulated device, which takes a free finger; `fault` goes wrong with it once it is pressed.
    pub fn emulate(&mut self, family: &str, fault: Option<&'static str>) {
        let Some(known) = by_key(family) else { return };
        self.devices.simulated += 1;
        let found = Found {
            family: known.key(),
            place: format!("{} {}", open::EMULATED, self.devices.simulated),
            title: format!("{} (emulated)", known.title()),
            serial: None,
            note: Some("a simulated arm in a simulated hand".into()),
        };
        if let Some(fault) = fault {
            self.devices.faults.insert(found.place.clone(), fault);
        }
        self.devices.came(found);
    }

    fn push(&mut self, finger: usize, axis: usize, force_n: f64) {
        let touches = |bench: &Self| {
            let fingers = bench.live.as_ref()?.snapshot().record.fingers().to_vec();
            Some(fingers.get(finger)?.contact.depth_mm > 0.0)
        };
        if touches(self).unwrap_or(false) {
            let text = "The finger touches the skin: lift it off before its force is tested";
            self.tell(Level::Warning, text);
            return;
        }
        let along = [Vec3::X, Vec3::Y, Vec3::Z].get(axis).copied();
        let finger = self.devices.fingers.get(finger);
        if let (Some(along), Some(used)) = (along, finger.and_then(|f| f.used.as_ref())) {
            used.push.begin(along * force_n);
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

    fn keep_choice(&mut self, finger: usize) {
        let used = self.devices.fingers[finger].used.as_ref();
        if let Some(found) = used.map(|u| u.told.found.clone()) {
            let trouble = self.devices.keep(&found, Some(finger));
            self.tell_trouble(trouble);
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

    fn poll_condition(&mut self, finger: usize) -> bool {
        let slot = &mut self.devices.fingers[finger];
        let Some(used) = &slot.used else { return false };
        let Some(vitals) = &used.told.vitals else {
            return false;
        };
        let now = vitals.condition();
        let name = used.told.capabilities.name.clone();
        let place = used.told.found.clone();
        let before = std::mem::replace(&mut slot.condition, now);
        if now == before {
            let back = slot.back.take_if(|since| since.elapsed() > STAYS);
            if back.is_some() && now == Condition::Good {
                self.tell(Level::Info, format!("{name} answers again"));
            }
            return back.is_some();
        }
        match now {
            Condition::Good if slot.amiss.is_some() => slot.back = Some(Instant::now()),
            Condition::Good | Condition::Waiting | Condition::Closed => {}
            other => {
                slot.back = None;
                // On a busy machine a device falls silent again and again.
                let passes = !other.is_latched() && !other.is_final();
                if passes && slot.amiss.is_some_and(|at| at.elapsed() < QUIET) {
                    return true;
                }
                slot.amiss = Some(Instant::now());
                slot.gone |= other.is_final();
                let text = format!("{name}: {}. Its force is zero", other.title());
                self.tell(Level::Error, text);
                if other.is_final() {
                    self.devices.attached.retain(|a| a.found != place);
                    // It may be there again before anyone looked.
                    if self.devices.watch.is_some() {
                        self.look_again();
                    }
                }
            }
        }
        true
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

    fn device_done(&mut self, done: Done) {
        match done {
            Done::Opened(opened) => self.opened(*opened),
            Done::Failed { order, why } => {
                if let Some(order) = order {
                    for a in &mut self.devices.attached {
                        if a.found == order.found {
                            (a.finger, a.trouble) = (None, Some(why.clone()));
                        }
                    }
                    let text = format!("{} cannot be used: {why}", order.found.title);
                    self.tell(Level::Error, text);
                } else {
                    self.tell(Level::Error, why);
                }
            }
            Done::Surveyed { missing } => {
                for (key, why) in missing {
                    self.devices.missing.retain(|m| m.0 != key);
                    self.devices.missing.push((key, why));
                }
            }
            Done::Makers { found, missing } => {
                self.devices
                    .missing
                    .retain(|m| by_key(m.0).is_some_and(|f| f.may_be_watched()));
                self.devices.missing.extend(missing);
                let known = |f: &Found| self.devices.attached.iter().any(|a| a.found == *f);
                let new: Vec<Found> = found.into_iter().filter(|f| !known(f)).collect();
                for found in new {
                    self.devices.came(found);
                }
            }
            Done::Saved { finger, path } => {
                self.tell(Level::Info, format!("Saved to {}", path.display()));
                self.reopen(finger);
            }
            Done::Forgotten { finger, path } => {
                let text = format!("{} is removed: published values are used", path.display());
                self.tell(Level::Info, text);
                self.reopen(finger);
            }
        }
    }

    /// Closes the device of a finger and opens it again as it is calibrated now.
    fn reopen(&mut self, finger: usize) {
        let used = self.devices.fingers[finger].used.as_ref();
        let Some(found) = used.map(|u| u.told.found.clone()) else {
            return;
        };
        let slot = &self.devices.fingers[finger];
        let (stiffness, passivity) = (slot.stiffness, slot.passivity);
        self.by_mouse(finger);
        let slot = &mut self.devices.fingers[finger];
        (slot.stiffness, slot.passivity) = (stiffness, passivity);
        for a in &mut self.devices.attached {
            if a.found == found {
                a.finger = Some(finger);
            }
        }
        self.devices.open(finger, found, work::LET_GO);
    }

    fn opened(&mut self, opened: Opened) {
        let Opened {
            order,
            mut device,
            used,
            seat,
        } = opened;
        let (Some(scene), true) = (self.scene.clone(), self.live.is_some()) else {
            return;
        };
        let finger = order.finger;
        let locked = self.devices_locked().is_some();
        let slot = &mut self.devices.fingers[finger];
        if order.number != slot.asked || (locked && !slot.gone) {
            device.close();
            // A recording was begun meanwhile: it is opened again at its end.
            if order.number == slot.asked {
                let after = Duration::ZERO;
                self.devices.tasks.push_back(Task::Open { order, after });
            }
            return;
        }
        let name = used.told.capabilities.name.clone();
        let again = std::mem::replace(&mut slot.gone, false);
        slot.used = Some(used);
        slot.condition = Condition::Waiting;
        // The bounds that a running recording tells stay.
        let told = |live: &Live| live.devices().nth(finger).map(|(_, limits)| *limits);
        let limits = match &self.live {
            Some(live) if locked => told(live),
            _ => self.limits_of(&self.devices.fingers[finger]),
        };
        let seat = seat.map(|(place, above_mm)| Seat { place, above_mm });
        if let Some(seat) = &seat {
            seat.over(&scene, finger);
        }
        if let (Some(live), Some(limits)) = (&mut self.live, limits) {
            live.use_device(finger, device, seat, limits);
        }
        let text = if again {
            format!("{name} is back at finger {}", finger + 1)
        } else {
            format!("{name} moves finger {}", finger + 1)
        };
        self.tell(Level::Info, text);
        self.tell_too_stiff(finger);
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
