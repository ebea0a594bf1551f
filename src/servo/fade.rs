//! How an edit of the scene reaches the finger: the new stiffness comes in by shares, no faster than a hand may feel.

use super::Limits;
use super::tick::{Rig, feel};
use crate::contact::{Contact, ContactState, Fading, TouchScene};
use crate::device::{MAX_FINGERS, Reading};
use crate::geom::Vec3;

/// Most that the share of the new stiffness grows within one tick: an edit takes 64 ticks at least.
pub const MOST_SHARE: f64 = 1.0 / 64.0;
/// Most that an edit changes the force sent to a finger within one tick, N.
pub const MOST_STEP_N: f64 = 0.04;

/// Rounding of the line that the force is taken to follow between two shares.
const SLACK: f64 = 1.0 + 1.0e-9;
/// Halvings that find the share: to one part in a billion of the step.
const HALVINGS: u32 = 30;
/// Shares tried where the force does not follow the line; then the tick goes without.
const TRIES: u32 = 4;

impl Rig {
    /// Goes over to `scene`, which has the same surface, in shares over the next ticks; contacts go on. `number` is that of
    /// the edit. Gives back the scene before.
    ///
    /// From a scene that is not wholly there yet the force would jump: see [`Rig::is_fading`].
    pub fn edit_scene(&mut self, number: u32, mut scene: Box<TouchScene>) -> Box<TouchScene> {
        match &mut scene.fading {
            // Nothing may be freed here: what lies in the way goes with the scene before.
            Some(fading) => {
                std::mem::swap(&mut fading.from, &mut self.scene.stiffness);
                fading.share = 0.0;
            }
            none => {
                *none = Some(Fading {
                    from: self.scene.stiffness.clone(),
                    share: 0.0,
                });
            }
        }
        self.edit = number;
        std::mem::replace(&mut self.scene, scene)
    }

    /// Whether the newest edit is not wholly felt yet.
    pub fn is_fading(&self) -> bool {
        self.scene.share() < 1.0
    }

    pub(super) fn set_share(&mut self, share: f64) {
        if let Some(fading) = &mut self.scene.fading {
            fading.share = if share.is_nan() {
                1.0
            } else {
                share.clamp(0.0, 1.0)
            };
        }
    }
}

type Contacts = [Option<ContactState>; MAX_FINGERS];
type Felt = [Contact; MAX_FINGERS];

/// One tick of all fingers in a scene on its way: the share grows as far as [`MOST_SHARE`] and [`MOST_STEP_N`] allow.
///
/// The fingers are felt at the share before and at the largest one allowed. Force is proportional to stiffness in every
/// model, and where a proxy rests does not depend on it: in between, force follows a line. Only the balance of force shading
/// can make it part from that, so what comes out is looked at again.
pub(super) fn feel_on_the_way(rig: &mut Rig, readings: &[Reading]) -> Felt {
    let from = rig.scene.share();
    let to = (from + MOST_SHARE).min(1.0);
    let rated_n = rig.limits.map(|l: Limits| l.rated_force_n.max(0.0));
    let mut at = |share: f64| -> (Contacts, Felt) {
        rig.set_share(share);
        let mut contacts = rig.contacts;
        let felt = feel(&rig.scene, &mut contacts, readings);
        (contacts, felt)
    };
    let sent = |felt: &Felt, i: usize| felt[i].force_n.clamp_length_max(rated_n[i]);
    let before = at(from);
    let whole = at(to);
    let on_the_line = |part: f64| {
        (0..MAX_FINGERS).all(|i| {
            let (a, b) = (before.1[i].force_n, whole.1[i].force_n);
            let there = (a + (b - a) * part).clamp_length_max(rated_n[i]);
            small(there - sent(&before.1, i))
        })
    };
    let mut part = largest(on_the_line);
    for _ in 0..TRIES {
        let share = if part < 1.0 {
            from + (to - from) * part
        } else {
            to
        };
        let (contacts, felt) = at(share);
        if (0..MAX_FINGERS).all(|i| small(sent(&felt, i) - sent(&before.1, i))) {
            rig.contacts = contacts;
            return felt;
        }
        part *= 0.5;
    }
    rig.set_share(from);
    rig.contacts = before.0;
    before.1
}

fn small(step_n: Vec3) -> bool {
    step_n.length() <= MOST_STEP_N * SLACK
}

/// The largest part of a step, 0 … 1, that `allows`; what is allowed at 0 need not be asked.
fn largest(allows: impl Fn(f64) -> bool) -> f64 {
    if allows(1.0) {
        return 1.0;
    }
    let (mut good, mut bad) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (good + bad);
        if allows(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    good
}
