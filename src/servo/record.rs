//! What goes into a tick and what comes out: plain values.

use super::LimitFlags;
use super::passivity::Observer;
use crate::contact::{Contact, ContactState};
use crate::device::{MAX_FINGERS, Reading};
use crate::geom::Vec3;

/// Everything from outside that a tick depends on. A replay that repeats it repeats the run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TickInput {
    /// One reading per finger; those past `n_fingers` are ignored.
    pub readings: [Reading; MAX_FINGERS],
    /// Number of fingers, at most [`MAX_FINGERS`].
    pub n_fingers: usize,
    /// Place these fingers' proxies anew: another device or another scene.
    pub place_anew: [bool; MAX_FINGERS],
    /// The tick came later than the watchdog allows: force goes to zero.
    pub late: bool,
    /// Force output is wanted; off before enabling and after an emergency stop.
    pub force_enabled: bool,
}

/// One tick of one finger, complete: the input, the outcome and the state the next tick starts from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FingerRecord {
    /// Tick number since the servo started.
    pub tick: u64,
    /// Which finger, from 0.
    pub finger: u8,
    /// Monotonic time since the servo started, ns.
    pub time_ns: u64,
    /// Input: the device's reading.
    pub reading: Reading,
    /// Input: the proxy was placed anew, because the device or the scene is another one.
    pub placed_anew: bool,
    /// Input: the tick was late beyond the watchdog's bound.
    pub late: bool,
    /// Input: force output was wanted.
    pub force_enabled: bool,
    /// Input: number of the edit that made the scene what it is; 0 before the first.
    pub edit: u32,
    /// Share of that edit that is felt, 0 … 1; below 1 the rest is the scene before it.
    pub fade: f64,
    /// The contact; holds the proxy, the normal, the anchor, depth, stiffness and the force before limits.
    pub contact: Contact,
    /// Force sent to the device, N.
    pub sent_force_n: Vec3,
    /// Which limits acted on it.
    pub limits: LimitFlags,
    /// Where the passivity controller is on, what the finger is owed: 0, or below it the energy that the skin has given
    /// out beyond what was put in. Else 0.
    pub passivity_energy_n_mm: f64,
    /// How long the whole tick took, µs. Measured, not part of the replayed outcome.
    pub duration_us: f32,
}

impl Default for FingerRecord {
    /// Nothing read, nothing felt, in a scene that was never edited.
    fn default() -> Self {
        Self {
            tick: 0,
            finger: 0,
            time_ns: 0,
            reading: Reading::default(),
            placed_anew: false,
            late: false,
            force_enabled: false,
            edit: 0,
            fade: 1.0,
            contact: Contact::default(),
            sent_force_n: Vec3::ZERO,
            limits: LimitFlags::default(),
            passivity_energy_n_mm: 0.0,
            duration_us: 0.0,
        }
    }
}

impl FingerRecord {
    /// The contact state the next tick starts from; `None` where the device did not answer, so that the proxy is placed
    /// anew when it does.
    pub fn contact_state(&self) -> Option<ContactState> {
        self.reading
            .is_usable()
            .then(|| ContactState::after(self.reading.position_mm, &self.contact))
    }

    /// The energy balance that the next tick starts from, with the passivity controller on or off.
    /// `rendered` is the contact as the limits let it be rendered.
    pub(super) fn observer(&self, on: bool, rendered: &Contact) -> Observer {
        if on && self.reading.is_usable() {
            let hip_mm = self.reading.position_mm;
            Observer::after(hip_mm, rendered, self.passivity_energy_n_mm)
        } else {
            Observer::default()
        }
    }

    /// Whether the outcome equals `other`'s bit for bit; measured times are left out.
    pub fn same_outcome(&self, other: &Self) -> bool {
        let bits = |r: &Self| {
            let v = |v: Vec3| v.to_array().map(f64::to_bits);
            let c = &r.contact;
            (
                (
                    r.tick,
                    r.finger,
                    r.late,
                    r.force_enabled,
                    r.edit,
                    r.limits,
                    c.touch,
                    c.triangle,
                    c.behind,
                ),
                (
                    r.reading.buttons,
                    r.reading.connected,
                    v(r.reading.position_mm),
                    v(r.reading.velocity_mm_s),
                ),
                (
                    v(c.anchor_mm),
                    v(c.foot_mm),
                    v(c.normal),
                    v(c.force_n),
                    v(r.sent_force_n),
                ),
                [
                    c.depth_mm,
                    c.stiffness_n_per_mm,
                    c.felt_depth_mm,
                    c.credit_mj,
                    r.fade,
                    r.passivity_energy_n_mm,
                ]
                .map(f64::to_bits),
            )
        };
        bits(self) == bits(other)
    }
}

/// One tick of all fingers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TickRecord {
    /// Number of fingers.
    pub n_fingers: usize,
    /// One record per finger; those past `n_fingers` are default.
    pub fingers: [FingerRecord; MAX_FINGERS],
}

impl TickRecord {
    /// The records of the fingers there are.
    pub fn fingers(&self) -> &[FingerRecord] {
        &self.fingers[..self.n_fingers]
    }
}
