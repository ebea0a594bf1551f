//! The same motion felt otherwise: a session through another scene, force model, engine or servo rate, and how far that is off.

use super::replay::Rebuild;
use super::{Damage, Edit, Session, SessionError, Strictness, input_of};
use crate::device::Reading;
use crate::geom::Vec3;
use crate::servo::{Rig, TickInput, TickRecord, tick};
use serde::Serialize;
use std::collections::BTreeMap;

/// How a session is to be repeated otherwise.
pub struct Otherwise<'a> {
    /// Ticks per second; that of the session without it.
    pub rate_hz: Option<f64>,
    /// Makes the scene of an edit; without it edits are passed over, as in a scenario of one's own.
    pub rebuild: Option<Rebuild<'a>>,
}

/// How far one finger was off at one recorded tick: what came out otherwise less what was recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Off {
    /// Recorded tick.
    pub tick: u64,
    /// Finger, from 0.
    pub finger: u8,
    /// Time since the first tick, by tick numbers, s.
    pub time_s: f64,
    /// Proxy, mm.
    pub proxy_mm: Vec3,
    /// Force before any limit, N.
    pub force_n: Vec3,
    /// Force sent to the device, N.
    pub sent_force_n: Vec3,
    /// Penetration depth, mm.
    pub depth_mm: f64,
}

/// Root mean square and greatest of a quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Root mean square; 0 for no value.
    pub rms: f64,
    /// Greatest magnitude; 0 for no value.
    pub max: f64,
    /// The tick that has it.
    pub max_tick: u64,
    #[serde(skip)]
    sum: f64,
    #[serde(skip)]
    n: u64,
}

impl Spread {
    fn add(&mut self, value: f64, tick: u64) {
        if !value.is_finite() {
            return;
        }
        self.n += 1;
        self.sum += value * value;
        self.rms = libm::sqrt(self.sum / self.n as f64);
        if value.abs() > self.max {
            (self.max, self.max_tick) = (value.abs(), tick);
        }
    }
}

/// How far one finger was off over a session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FingerOff {
    /// Finger, from 0.
    pub finger: u8,
    /// Distance of the proxies, mm.
    pub proxy_mm: Spread,
    /// Magnitude of the difference of the forces before any limit, N.
    pub force_n: Spread,
    /// The same of the forces sent, N.
    pub sent_force_n: Spread,
    /// Difference of the depths, mm.
    pub depth_mm: Spread,
}

/// What repeating a session otherwise came to.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Divergence {
    /// Recorded ticks compared.
    pub compared: u64,
    /// Ticks computed.
    pub computed: u64,
    /// Places where it began anew: gaps, and changes that it could not follow.
    pub gaps: u64,
    /// Finger by finger.
    pub fingers: Vec<FingerOff>,
    /// What reading stepped over.
    pub damage: Damage,
}

/// Repeats a session otherwise and tells at each recorded tick how far that is off.
///
/// The run begins, at the first tick and behind each gap, with the recorded state where the surface is the recorded one, and with
/// the proxy placed at the device where it is another. At another rate its ticks fall at k / `rate_hz` s behind that: position and
/// velocity are interpolated linearly between the recorded ticks (the time of a tick is its number times the recorded step), all
/// else is that of the recorded tick before; a device is placed anew in the first tick from there on. Each recorded tick is compared
/// with the newest computed one: a device holds its force that long. A tick felt while an edit came in by shares begins, if the run
/// begins there, with the whole edit.
///
/// `each` sees every difference and the share done, 0 to 1, and answers whether to go on.
///
/// # Errors
/// The session is sealed, reading finds something wrong (strict), or [`SessionError::Stopped`].
pub fn diverge(
    session: &Session,
    rig: Rig,
    otherwise: Otherwise<'_>,
    strictness: Strictness,
    mut each: impl FnMut(&Off, f64) -> bool,
) -> Result<Divergence, SessionError> {
    let header = session.header();
    if header.sealed {
        return Err(SessionError::Sealed {
            path: session.path().to_owned(),
        });
    }
    let step_s = header.dt_s();
    let dt_s = otherwise.rate_hz.map_or(step_s, |rate| 1.0 / rate);
    let mut run = Run {
        known_surface: super::header::hexadecimal(&rig.scene.surface.hash()) == header.mesh.hash,
        rig,
        rebuild: otherwise.rebuild,
        edits: BTreeMap::new(),
        step_s,
        dt_s,
        same_rate: otherwise.rate_hz.is_none_or(|rate| rate == header.rate_hz),
        begun: None,
        computed: 0,
    };
    run.rig.edit = header.edit;
    let mut out = Divergence {
        fingers: (0..header.n_fingers())
            .map(|i| FingerOff {
                finger: i as u8,
                ..FingerOff::default()
            })
            .collect(),
        ..Divergence::default()
    };
    let mut ticks = session.ticks(strictness)?;
    let mut first = None;
    while let Some(recorded) = ticks.next() {
        let recorded = recorded?;
        for edit in ticks.take_edits() {
            run.edits.insert(edit.number, edit);
        }
        let number = recorded.fingers[0].tick;
        let first = *first.get_or_insert(number);
        let Some(got) = run.follow(&recorded) else {
            out.gaps += u64::from(number != first);
            continue;
        };
        out.compared += 1;
        for (was, is) in recorded.fingers().iter().zip(got.fingers()) {
            let off = Off {
                tick: number,
                finger: was.finger,
                time_s: (number - first) as f64 * step_s,
                proxy_mm: is.contact.anchor_mm - was.contact.anchor_mm,
                force_n: is.contact.force_n - was.contact.force_n,
                sent_force_n: is.sent_force_n - was.sent_force_n,
                depth_mm: is.contact.depth_mm - was.contact.depth_mm,
            };
            if let Some(finger) = out.fingers.get_mut(usize::from(was.finger)) {
                finger.proxy_mm.add(off.proxy_mm.length(), number);
                finger.force_n.add(off.force_n.length(), number);
                finger.sent_force_n.add(off.sent_force_n.length(), number);
                finger.depth_mm.add(off.depth_mm, number);
            }
            if !each(&off, ticks.progress()) {
                return Err(SessionError::Stopped);
            }
        }
    }
    out.computed = run.computed;
    out.damage = ticks.damage().clone();
    Ok(out)
}

/// The run on its way.
struct Run<'a> {
    rig: Rig,
    rebuild: Option<Rebuild<'a>>,
    edits: BTreeMap<u32, Edit>,
    known_surface: bool,
    step_s: f64,
    dt_s: f64,
    same_rate: bool,
    begun: Option<Begun>,
    computed: u64,
}

/// A stretch without gaps.
struct Begun {
    /// The recorded tick that came last, and its number from the start of the stretch.
    last: TickRecord,
    place: u64,
    /// Ticks computed since the start of the stretch.
    done: u64,
    /// The newest of them.
    got: TickRecord,
    /// Devices that the next tick computed places anew.
    place_anew: [bool; crate::servo::MAX_FINGERS],
}

impl Run<'_> {
    /// Computes up to a recorded tick; `None` where it begins anew there.
    fn follow(&mut self, recorded: &TickRecord) -> Option<TickRecord> {
        let number = recorded.fingers[0].tick;
        let follows = |b: &Begun| b.last.fingers[0].tick.checked_add(1) == Some(number);
        let Some(mut begun) = self.begun.take().filter(follows) else {
            self.begin(recorded);
            return None;
        };
        self.take_edit(recorded.fingers[0].edit);
        let (before, after) = (input_of(&begun.last), input_of(recorded));
        if self.same_rate {
            begun.got = tick(&mut self.rig, &after, self.dt_s);
            self.computed += 1;
        } else {
            let place = begun.place + 1;
            for (due, anew) in begun.place_anew.iter_mut().zip(after.place_anew) {
                *due |= anew;
            }
            loop {
                // In steps of the recording, so that equal rates fall on equal ticks.
                let at = (begun.done + 1) as f64 * self.dt_s / self.step_s;
                let share = at - begun.place as f64;
                if at > place as f64 + 1e-9 {
                    break;
                }
                let mut input = between(&before, &after, share);
                input.place_anew = match share >= 1.0 - 1e-9 {
                    // What is placed anew at the recorded tick is not before it.
                    true => std::mem::take(&mut begun.place_anew),
                    false => Default::default(),
                };
                begun.got = tick(&mut self.rig, &input, self.dt_s);
                begun.done += 1;
                self.computed += 1;
            }
            begun.place = place;
        }
        begun.last = *recorded;
        let got = begun.got;
        self.begun = Some(begun);
        Some(got)
    }

    fn begin(&mut self, recorded: &TickRecord) {
        let first = recorded.fingers[0];
        self.take_edit(first.edit);
        // Wholly there: what it leads away from is not known here.
        self.rig.scene.fading = None;
        if self.known_surface {
            let mut whole = *recorded;
            for finger in &mut whole.fingers {
                finger.fade = 1.0;
                finger.edit = self.rig.edit;
            }
            self.rig.resume_from(&whole);
        } else {
            self.rig.contacts = Default::default();
            self.rig.last_force_n = Default::default();
            self.rig.observers = Default::default();
            self.rig.next_tick = first.tick.saturating_add(1);
        }
        self.begun = Some(Begun {
            last: *recorded,
            place: 0,
            done: 0,
            got: *recorded,
            place_anew: Default::default(),
        });
    }

    /// Goes over to the scene of an edit, where it can be had; else what is felt stays.
    fn take_edit(&mut self, number: u32) {
        let Some(rebuild) = &mut self.rebuild else {
            return;
        };
        if number == self.rig.edit {
            return;
        }
        let scene = self.edits.get(&number).map(rebuild);
        match scene {
            Some(Ok(scene)) if scene.surface.hash() == self.rig.scene.surface.hash() => {
                drop(self.rig.edit_scene(number, Box::new(scene)));
            }
            _ => self.rig.edit = number,
        }
    }
}

/// Inputs a share of the way from one recorded tick to the next.
fn between(before: &TickInput, after: &TickInput, share: f64) -> TickInput {
    if share >= 1.0 - 1e-9 {
        return *after;
    }
    let mut input = *before;
    for ((reading, a), b) in input
        .readings
        .iter_mut()
        .zip(&before.readings)
        .zip(&after.readings)
    {
        if a.is_usable() && b.is_usable() {
            *reading = Reading {
                position_mm: a.position_mm.lerp(b.position_mm, share),
                velocity_mm_s: a.velocity_mm_s.lerp(b.velocity_mm_s, share),
                ..*a
            };
        }
    }
    input
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreads_are_those_of_their_values() {
        let mut spread = Spread::default();
        for (tick, value) in [(1, 3.0), (2, -4.0), (3, f64::NAN), (4, 0.0)] {
            spread.add(value, tick);
        }
        assert_eq!((spread.max, spread.max_tick), (4.0, 2));
        assert!((spread.rms - (25.0_f64 / 3.0).sqrt()).abs() < 1e-15);
    }

    #[test]
    fn inputs_in_between_are_on_the_line_and_the_rest_is_that_before() {
        let mut before = TickInput {
            n_fingers: 1,
            force_enabled: true,
            ..TickInput::default()
        };
        before.readings[0] = Reading {
            position_mm: Vec3::new(1.0, 0.0, -1.0),
            velocity_mm_s: Vec3::X,
            buttons: 1,
            connected: true,
        };
        let mut after = before;
        after.late = true;
        after.readings[0].position_mm = Vec3::new(3.0, 1.0, -1.0);
        after.readings[0].buttons = 2;
        let half = between(&before, &after, 0.5);
        assert_eq!(half.readings[0].position_mm, Vec3::new(2.0, 0.5, -1.0));
        assert!(half.readings[0].buttons == 1 && !half.late);
        assert_eq!(between(&before, &after, 1.0), after);
        // A device that does not answer has no place on the line.
        after.readings[0].connected = false;
        let half = between(&before, &after, 0.5);
        assert_eq!(half.readings[0], before.readings[0]);
    }
}
