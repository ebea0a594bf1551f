//! Runs the real tick and counts what must never be.

use super::row::Tally;
use crate::contact::{Contact, Stiffness, TouchScene};
use crate::device::{MAX_FINGERS, Reading};
use crate::geom::Vec3;
use crate::partition::bvh::Bvh;
use crate::servo::{FingerRecord, Limits, Rig, TickInput, TickRecord, tick};
use crate::surface::torture::Stream;
use crate::surface::{MeshError, RawMesh, Surface};
use std::sync::Arc;

/// Step of an ordinary servo, s.
pub const DT_S: f64 = 1.0e-3;

/// A force sent may exceed its bound by this share: rounding of a length.
const ROUNDING: f64 = 1.0 + 1.0e-12;

/// A rig that is ticked under observation.
pub struct Drive {
    /// The rig.
    pub rig: Rig,
    /// What was counted.
    pub tally: Tally,
    /// Largest departure from what the checks want, as a share of what is allowed or in their own unit.
    pub off: f64,
    /// The first fault of a check, in words.
    pub fault: Option<String>,
    dt_s: f64,
}

impl Drive {
    /// A rig at rest with the limits of the default device.
    pub fn new(scene: TouchScene, dt_s: f64) -> Self {
        Self::with_limits(scene, Limits::default(), dt_s)
    }

    /// A rig at rest with these limits on every finger.
    pub fn with_limits(scene: TouchScene, limits: Limits, dt_s: f64) -> Self {
        Self {
            rig: Rig::new(Box::new(scene), [limits; MAX_FINGERS]),
            tally: Tally::default(),
            off: 0.0,
            fault: None,
            dt_s,
        }
    }

    /// One finger at a place, moving with a velocity, mm/s.
    pub fn put(&mut self, position_mm: Vec3, velocity_mm_s: Vec3) -> FingerRecord {
        let mut input = TickInput {
            n_fingers: 1,
            force_enabled: true,
            ..TickInput::default()
        };
        input.readings[0] = Reading {
            position_mm,
            velocity_mm_s,
            buttons: 0,
            connected: true,
        };
        self.tick(&input).fingers[0]
    }

    /// One tick, and everything in it looked at.
    pub fn tick(&mut self, input: &TickInput) -> TickRecord {
        let before = self.rig.last_force_n;
        let record = tick(&mut self.rig, input, self.dt_s);
        self.tally.ticks += 1;
        for (i, r) in record.fingers().iter().enumerate() {
            self.tally.not_finite += not_finite(&r.contact, r.sent_force_n);
            let sent_n = length(r.sent_force_n);
            let limits = self.rig.limits[i];
            // What is no bound allows nothing.
            let bound = |x: f64| if x > 0.0 { x } else { 0.0 };
            let last_n = if input.place_anew[i] {
                0.0
            } else {
                length(before[i])
            };
            let rise_n = last_n + bound(limits.rise_n_per_s * self.dt_s);
            let most_n = bound(limits.rated_force_n).min(rise_n);
            // A tiny step may round up to the next number.
            let within = sent_n <= most_n * ROUNDING + f64::MIN_POSITIVE;
            self.tally.over_limit += u64::from(!within);
            if sent_n.is_finite() {
                self.tally.largest_n = self.tally.largest_n.max(sent_n);
            }
        }
        record
    }

    /// Notes how far a figure is from what it should be, in units of what is allowed for it.
    pub fn expect(&mut self, found: f64, wanted: f64, allowed: f64, what: &str) {
        let off = (found - wanted).abs() / allowed;
        // NaN is a fault too.
        if off.is_nan() || off > 1.0 {
            let ticks = self.tally.ticks;
            self.say(|| format!("tick {ticks}: {what} is {found:e}, {wanted:e} expected"));
        }
        if off.is_finite() {
            self.off = self.off.max(off);
        }
    }

    /// Keeps the first fault.
    pub fn say(&mut self, words: impl FnOnce() -> String) {
        if self.fault.is_none() {
            self.fault = Some(words());
        }
    }

    /// A fault unless it holds.
    pub fn must(&mut self, holds: bool, words: impl FnOnce() -> String) {
        if !holds {
            let ticks = self.tally.ticks;
            self.say(|| format!("tick {ticks}: {}", words()));
        }
    }
}

/// Length of a vector whose squares may underflow.
pub fn length(v: Vec3) -> f64 {
    libm::hypot(libm::hypot(v.x, v.y), v.z)
}

fn not_finite(c: &Contact, sent_n: Vec3) -> u64 {
    let vectors = [c.anchor_mm, c.foot_mm, c.normal, c.force_n, sent_n];
    let numbers = [
        c.depth_mm,
        c.stiffness_n_per_mm,
        c.felt_depth_mm,
        c.credit_mj,
    ];
    let flat = vectors.iter().flat_map(|v| v.to_array()).chain(numbers);
    flat.filter(|x| !x.is_finite()).count() as u64
}

/// A mesh let in as a scene that is felt without friction.
///
/// # Errors
/// Why the mesh is refused.
pub fn scene(raw: RawMesh, stiffness: Stiffness) -> Result<TouchScene, MeshError> {
    let (surface, _) = Surface::new(raw)?;
    let search = Arc::new(Bvh::new(&surface));
    Ok(TouchScene::new(Arc::new(surface), search, stiffness))
}

/// A vector of one component each in −1 … 1, z mostly below zero.
pub fn pressed(stream: &mut Stream) -> Vec3 {
    let v = stream.vector();
    Vec3::new(v.x, v.y, 0.6 * v.z - 0.4)
}

/// The stream of a case: the same seed and name give the same.
pub fn stream(seed: u64, name: &str) -> Stream {
    // FNV-1a.
    let hash = name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| {
        (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)
    });
    Stream(hash ^ seed.rotate_left(17))
}
