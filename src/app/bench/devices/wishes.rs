//! What is asked of devices, carried out.

use super::Finger;
use super::open::EMULATED;
use super::work::{LET_GO, Task};
use crate::app::bench::Bench;
use crate::app::bench::live::FINGERS;
use crate::app::hardware::DeviceWish;
use crate::app::messages::Level;
use crate::device::{Calibration, Found, by_key};
use crate::geom::Vec3;

impl Bench {
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

    pub(super) fn assign(&mut self, finger: usize, found: Option<Found>) {
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
        self.devices.open(finger, found, LET_GO);
    }

    pub(super) fn tell_trouble(&mut self, trouble: Option<String>) {
        if let Some(text) = trouble {
            self.tell(Level::Warning, format!("the choice is not kept: {text}"));
        }
    }

    /// Has a finger moved by the mouse; what moved it is closed.
    pub(super) fn by_mouse(&mut self, finger: usize) {
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
            place: format!("{} {}", EMULATED, self.devices.simulated),
            title: format!("{} (emulated)", known.title()),
            serial: None,
            note: Some("a simulated arm in a simulated hand".into()),
        };
        if let Some(fault) = fault {
            self.devices.faults.insert(found.place.clone(), fault);
        }
        self.devices.came(found);
    }

    pub(super) fn push(&mut self, finger: usize, axis: usize, force_n: f64) {
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

    pub(super) fn keep_choice(&mut self, finger: usize) {
        let used = self.devices.fingers[finger].used.as_ref();
        if let Some(found) = used.map(|u| u.told.found.clone()) {
            let trouble = self.devices.keep(&found, Some(finger));
            self.tell_trouble(trouble);
        }
    }
}
