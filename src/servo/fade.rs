//! How an edit of the scene reaches the finger: the new stiffness and skin drag come in by shares, no faster than a hand
//! may feel.

use super::Limits;
use super::tick::{Rig, feel};
use crate::contact::{Contact, ContactState, Fading, Touch, TouchScene};
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
                std::mem::swap(&mut fading.from_drag, &mut self.scene.drag);
                fading.share = 0.0;
            }
            none => {
                *none = Some(Fading {
                    from: self.scene.stiffness.clone(),
                    from_drag: self.scene.drag.clone(),
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
/// and skin drag can make it part from that, so what comes out is looked at again.
///
/// Skin that drags less and less lets a finger go that it held: that step, from static to dynamic friction, is friction's
/// own, however small the share, and is not held back.
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
    let let_go =
        |felt: &Felt, i: usize| before.1[i].touch == Touch::Stick && felt[i].touch == Touch::Slip;
    let mut part = largest(on_the_line);
    for n in 1..=TRIES {
        let share = if part < 1.0 {
            from + (to - from) * part
        } else {
            to
        };
        let (contacts, felt) = at(share);
        let allowed =
            |i| small(sent(&felt, i) - sent(&before.1, i)) || n == TRIES && let_go(&felt, i);
        if (0..MAX_FINGERS).all(allowed) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{Friction, Stiffness};
    use crate::partition::bvh::Bvh;
    use crate::servo::{TickInput, tick};
    use crate::surface::{RawMesh, Surface};
    use std::sync::Arc;

    /// A plane that drags twice as much as its friction says.
    fn rough() -> TouchScene {
        let at = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        let mesh = RawMesh {
            positions: vec![
                at(-50.0, -50.0),
                at(50.0, -50.0),
                at(50.0, 50.0),
                at(-50.0, 50.0),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        };
        let surface = Arc::new(Surface::new(mesh).expect("sound").0);
        let search = Arc::new(Bvh::new(&surface));
        TouchScene {
            friction: Some(Friction {
                static_coefficient: 0.46,
                dynamic_coefficient: 0.44,
                skin_looseness: 1.0,
            }),
            drag: Some(Arc::from([2.0; 4])),
            ..TouchScene::new(surface, search, Stiffness::Uniform(1.0))
        }
    }

    fn press(rig: &mut Rig, x: f64, z: f64) -> (Contact, Vec3) {
        let mut input = TickInput {
            n_fingers: 1,
            force_enabled: true,
            ..TickInput::default()
        };
        input.readings[0] = Reading {
            position_mm: Vec3::new(x, 0.0, z),
            connected: true,
            ..Reading::default()
        };
        let out = tick(rig, &input, 0.001);
        (out.fingers[0].contact, out.fingers[0].contact.force_n)
    }

    /// Pressed 5 N deep and pulled aside by `pull` mm; then the drag goes over to `to` while the hand holds still. The force
    /// of every tick since the edit.
    fn edited(pull: f64, to: Option<f64>) -> Vec<(Contact, Vec3)> {
        let scene = rough();
        let mut rig = Rig::new(Box::new(scene.clone()), Default::default());
        for i in 0..200 {
            press(&mut rig, 0.0, 1.0 - 0.03 * f64::from(i));
        }
        for i in 0..=100 {
            press(&mut rig, pull * 0.01 * f64::from(i), -5.0);
        }
        let drag: Option<Arc<[f64]>> = to.map(|to| Arc::from([to; 4]));
        drop(rig.edit_scene(1, Box::new(TouchScene { drag, ..scene })));
        let felt = (0..400).map(|_| press(&mut rig, pull, -5.0)).collect();
        assert!(!rig.is_fading(), "the edit never was wholly felt");
        felt
    }

    fn steps(felt: &[(Contact, Vec3)]) -> Vec<f64> {
        felt.windows(2)
            .map(|w| (w[1].1 - w[0].1).length())
            .collect()
    }

    #[test]
    fn less_drag_lets_a_held_finger_go_once_and_then_smoothly() {
        // Held at 4 mm of the 4.6 that twice the static coefficient holds at 5 mm depth.
        for to in [None, Some(1.0), Some(0.5)] {
            let felt = edited(4.0, to);
            assert_eq!(felt[0].0.touch, Touch::Stick);
            let let_go = felt
                .windows(2)
                .position(|w| w[0].0.touch == Touch::Stick && w[1].0.touch == Touch::Slip);
            let let_go = let_go.expect("lets go");
            for (i, step) in steps(&felt).into_iter().enumerate() {
                // From static to dynamic at most twice 0.02 of 5 N, and a share.
                let most = if i == let_go {
                    0.2 + MOST_STEP_N
                } else {
                    MOST_STEP_N
                };
                assert!(step <= most * SLACK, "tick {i}: {step} N");
            }
            let last = felt.last().expect("ticks").1;
            let expected = 0.44 * to.unwrap_or(1.0);
            assert!(
                (libm::fabs(last.x / last.z) - expected).abs() < 1e-9,
                "{last}"
            );
        }
    }

    #[test]
    fn more_drag_changes_nothing_for_a_finger_that_is_held() {
        let felt = edited(4.0, Some(4.0));
        assert!(steps(&felt).into_iter().all(|step| step == 0.0));
        assert!(felt.iter().all(|(c, _)| c.touch == Touch::Stick));
    }
}
