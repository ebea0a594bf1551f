//! The tick: a pure function of rig, input and time step.

use super::fade::feel_on_the_way;
use super::limiter::{Gate, LimitFlags, Limits, limit};
use super::passivity::Observer;
use super::record::{FingerRecord, TickInput, TickRecord};
use crate::contact::{self, Contact, ContactState, Hip, Touch, TouchScene};
use crate::device::{MAX_FINGERS, Reading};
use crate::geom::Vec3;
use crate::units::NS_PER_S;

/// Everything a tick reads and changes.
#[derive(Debug)]
pub struct Rig {
    /// The scene felt.
    pub scene: Box<TouchScene>,
    /// Bounds on each finger's force.
    pub limits: [Limits; MAX_FINGERS],
    /// Contact state of each finger; `None` until its device answers, and again when it stops.
    pub contacts: [Option<ContactState>; MAX_FINGERS],
    /// Force sent to each finger last tick, N.
    pub last_force_n: [Vec3; MAX_FINGERS],
    /// Energy balance of each finger; at rest where the passivity controller is off.
    pub observers: [Observer; MAX_FINGERS],
    /// Number of the edit that made the scene what it is; 0 before the first.
    pub edit: u32,
    /// Number of the next tick.
    pub next_tick: u64,
}

impl Rig {
    /// A rig at rest: no contact, no force.
    pub fn new(scene: Box<TouchScene>, limits: [Limits; MAX_FINGERS]) -> Self {
        Self {
            scene,
            limits,
            contacts: [None; MAX_FINGERS],
            last_force_n: [Vec3::ZERO; MAX_FINGERS],
            observers: [Observer::default(); MAX_FINGERS],
            edit: 0,
            next_tick: 0,
        }
    }

    /// Takes over the state that a record left behind, so that the next tick continues the recorded run. Where the record is
    /// one of an edit, the scene must be that of the edit, and on its way ([`TouchScene::fading`]) where the record's was.
    pub fn resume_from(&mut self, record: &TickRecord) {
        for r in record.fingers() {
            self.edit = r.edit;
            self.set_share(r.fade);
            let i = usize::from(r.finger);
            if i < MAX_FINGERS {
                self.contacts[i] = r.contact_state();
                self.last_force_n[i] = r.sent_force_n;
                let limits = &self.limits[i];
                let model = &self.scene.choices.force;
                let rendered = limits.stiffness.rendered(model, &r.contact).0;
                self.observers[i] = r.observer(limits.passivity, &rendered);
            }
            self.next_tick = r.tick.saturating_add(1);
        }
    }
}

/// One step of the servo.
///
/// No clock, allocation, lock, I/O, `Result` or panic: live run, replay and tests call this one function and get the
/// same bits. `dt_s` is the nominal step. Forces sent are finite and within the limits whatever the input holds; a
/// reading that is not finite counts as a device that did not answer.
///
/// A proxy is first placed where the device is, even inside the skin: there it feels nothing until it has been outside,
/// so that nobody is pushed out with full force on enabling, on reconnecting or in a new scene.
///
/// An edit of the scene ([`Rig::edit_scene`]) comes in by shares: no finger's force changes by more than
/// [`MOST_STEP_N`](super::MOST_STEP_N) in a tick because of it.
pub fn tick(rig: &mut Rig, input: &TickInput, dt_s: f64) -> TickRecord {
    let n_fingers = input.n_fingers.min(MAX_FINGERS);
    let readings = &input.readings[..n_fingers];
    for i in 0..n_fingers {
        if input.place_anew[i] {
            rig.contacts[i] = None;
            rig.last_force_n[i] = Vec3::ZERO;
            rig.observers[i] = Observer::default();
        }
    }
    let on_the_way = rig.is_fading().then(|| feel_on_the_way(rig, readings));
    let mut out = TickRecord {
        n_fingers,
        ..TickRecord::default()
    };
    for i in 0..n_fingers {
        let reading = input.readings[i];
        let contact = match &on_the_way {
            Some(felt) => felt[i],
            None => touch(&rig.scene, &mut rig.contacts[i], &reading),
        };
        let gate = Gate {
            enabled: input.force_enabled,
            late: input.late,
            connected: reading.is_usable(),
        };
        let model = rig.scene.choices.force;
        let (rendered, softer) = rig.limits[i].stiffness.rendered(&model, &contact);
        let (wanted_n, damped) = passive(rig, i, &reading, &rendered, dt_s);
        let (sent_force_n, mut limits) =
            limit(wanted_n, rig.last_force_n[i], gate, &rig.limits[i], dt_s);
        if damped {
            limits.set(LimitFlags::PASSIVITY);
        }
        if softer {
            limits.set(LimitFlags::STIFFNESS);
        }
        rig.last_force_n[i] = sent_force_n;
        out.fingers[i] = FingerRecord {
            tick: rig.next_tick,
            finger: i as u8,
            time_ns: (rig.next_tick as f64 * dt_s * NS_PER_S) as u64,
            reading,
            placed_anew: input.place_anew[i],
            late: input.late,
            force_enabled: input.force_enabled,
            edit: rig.edit,
            fade: rig.scene.share(),
            contact,
            sent_force_n,
            limits,
            passivity_energy_n_mm: rig.observers[i].energy_n_mm,
            duration_us: 0.0,
        };
    }
    rig.next_tick = rig.next_tick.saturating_add(1);
    out
}

/// The force wanted of a finger's device, N, and whether it is other than that of the contact as it is rendered: where the
/// passivity controller is on.
fn passive(
    rig: &mut Rig,
    i: usize,
    reading: &Reading,
    contact: &Contact,
    dt_s: f64,
) -> (Vec3, bool) {
    if !rig.limits[i].passivity {
        return (contact.force_n, false);
    }
    if !reading.is_usable() {
        rig.observers[i] = Observer::default();
        return (contact.force_n, false);
    }
    let model = &rig.scene.choices.force;
    let sent_n = rig.last_force_n[i];
    rig.observers[i].control(model, reading.position_mm, contact, sent_n, dt_s)
}

/// What each finger feels; those without a reading feel nothing and are placed anew when they have one.
pub(super) fn feel(
    scene: &TouchScene,
    contacts: &mut [Option<ContactState>; MAX_FINGERS],
    readings: &[Reading],
) -> [Contact; MAX_FINGERS] {
    let mut felt = [Contact::default(); MAX_FINGERS];
    for ((contact, state), reading) in felt.iter_mut().zip(contacts).zip(readings) {
        *contact = touch(scene, state, reading);
    }
    felt
}

fn touch(scene: &TouchScene, state: &mut Option<ContactState>, reading: &Reading) -> Contact {
    if !reading.is_usable() {
        *state = None;
        return Contact::default();
    }
    let hip_mm = reading.position_mm;
    let placed = ContactState {
        touch: Touch::Free,
        proxy_mm: hip_mm,
        ..ContactState::default()
    };
    let hip = Hip {
        position_mm: hip_mm,
        velocity_mm_s: reading.velocity_mm_s,
    };
    contact::advance(scene, state.get_or_insert(placed), hip)
}
