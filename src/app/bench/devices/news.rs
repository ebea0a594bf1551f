//! What became of devices: how they are, and what was done for them.

use super::open::Opened;
use super::work::{Done, LET_GO, Task};
use super::{QUIET, STAYS};
use crate::app::bench::Bench;
use crate::app::bench::live::{Live, Seat};
use crate::app::messages::Level;
use crate::contact::{Touch, TouchScene};
use crate::device::hid::guard::Condition;
use crate::device::{Found, by_key};
use crate::geom::Vec3;
use crate::partition::Partition as _;
use std::time::{Duration, Instant};

impl Bench {
    pub(super) fn poll_condition(&mut self, finger: usize) -> bool {
        let slot = &mut self.devices.fingers[finger];
        let Some(used) = &slot.used else { return false };
        let Some(vitals) = &used.told.vitals else {
            return false;
        };
        let mut now = vitals.condition();
        let taken_off = vitals.counts().taken_off;
        if std::mem::replace(&mut slot.taken_off, taken_off) < taken_off && now == Condition::Good {
            // It passed between two looks.
            now = vitals.why_off();
        }
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

    /// Whether a finger that a device moves is under the skin without touching it: there it feels nothing until it comes out.
    pub(super) fn poll_sunk(&mut self, finger: usize) -> bool {
        let slot = &mut self.devices.fingers[finger];
        let record = self.live.as_ref().map(|l| l.snapshot().record);
        let record = record.as_ref().and_then(|r| r.fingers().get(finger));
        let sunk = match (&slot.used, record, &self.scene) {
            (Some(_), Some(r), Some(scene)) if r.reading.is_usable() => {
                r.contact.touch == Touch::Free && is_under(&scene.touch, r.reading.position_mm)
            }
            _ => false,
        };
        std::mem::replace(&mut slot.sunk, sunk) != sunk
    }

    pub(super) fn device_done(&mut self, done: Done) {
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
    pub(super) fn reopen(&mut self, finger: usize) {
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
        self.devices.open(finger, found, LET_GO);
    }

    pub(super) fn opened(&mut self, opened: Opened) {
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
        (slot.condition, slot.taken_off) = (Condition::Waiting, 0);
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
}

/// A finger is said to be under the skin from this far, mm, to so far under it.
const UNDER_MM: std::ops::RangeInclusive<f64> = 1.0..=80.0;

/// Whether a place is behind the triangle that is nearest to it.
fn is_under(scene: &TouchScene, at_mm: Vec3) -> bool {
    let found = (scene.search).nearest(&scene.surface, at_mm, *UNDER_MM.end());
    found.is_some_and(|near| {
        let normal = scene.surface.triangle(near.triangle).normal();
        -(at_mm - near.point).dot(normal) >= *UNDER_MM.start()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Stiffness;
    use crate::partition::bvh::Bvh;
    use crate::surface::{RawMesh, Surface};
    use std::sync::Arc;

    #[test]
    fn under_the_skin_is_behind_it_and_neither_on_it_nor_far_from_it() {
        let mesh = RawMesh {
            positions: vec![
                Vec3::new(-100.0, -100.0, 5.0),
                Vec3::new(200.0, -100.0, 5.0),
                Vec3::new(-100.0, 200.0, 5.0),
            ],
            triangles: vec![[0, 1, 2]],
        };
        let surface = Arc::new(Surface::new(mesh).expect("sound").0);
        let search = Arc::new(Bvh::new(&surface));
        let scene = TouchScene::new(surface, search, Stiffness::Uniform(1.0));
        for (z, expected) in [
            (15.0, false),
            (5.0, false),
            (4.5, false),
            (3.9, true),
            (-60.0, true),
            (-90.0, false),
        ] {
            assert_eq!(is_under(&scene, Vec3::new(1.0, 2.0, z)), expected, "{z}");
        }
        assert!(!is_under(&scene, Vec3::NAN));
    }
}
