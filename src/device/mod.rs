//! Where the finger is and who takes the force. One device is one finger.
//!
//! Hardware stands in families ([`all`]): a family says what it is, how it is reached, how it was tested, finds what is
//! attached and opens it. A new family is one file and one line in that list.

pub mod calibration;
mod family;
pub mod figures;
pub mod hid;
pub mod mapped;
pub mod mouse;
pub mod null;
pub mod place;
pub mod plug;
pub mod push;
pub mod replay;
pub mod rumble;
pub mod scripted;
pub mod seat;
pub mod stable;
pub mod vendor;

use crate::geom::Vec3;
pub use calibration::Calibration;
pub use family::{DeviceError, Family, Found, Proof, all, by_key};
pub use hid::vitals::Vitals;
use std::sync::Arc;

/// Most fingers at once.
pub const MAX_FINGERS: usize = 4;

/// What a device reports at one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// The HIP, mm.
    pub position_mm: Vec3,
    /// Its velocity, mm/s.
    pub velocity_mm_s: Vec3,
    /// Pressed buttons, bit by bit.
    pub buttons: u32,
    /// Whether the device answered. When not, the position is the last known one and no force is sent.
    pub connected: bool,
}

impl Reading {
    /// Whether the tick can use it: the device answered and the position is finite.
    pub fn is_usable(&self) -> bool {
        self.connected && self.position_mm.is_finite()
    }
}

/// What a device can do.
#[derive(Clone, Debug, PartialEq)]
pub struct Capabilities {
    /// Name shown to people and written into sessions.
    pub name: String,
    /// Axes along which the position is told, 0 to 3.
    pub position_axes: u8,
    /// Axes along which force is rendered, 0 to 3.
    pub force_axes: u8,
    /// Highest force it renders, N; zero for a device without force.
    pub rated_force_n: f64,
    /// Force it can hold without end, N; the rated force where the maker names no other.
    pub continuous_force_n: f64,
    /// Highest stiffness it renders stably at 1 kHz, N/mm; infinite where nothing bounds it.
    pub max_stiffness_n_per_mm: f64,
    /// Radius of the sphere it can reach, mm.
    pub workspace_radius_mm: f64,
    /// Smallest motion that it tells apart, mm; zero where nothing bounds it.
    pub resolution_mm: f64,
    /// How many buttons it has.
    pub n_buttons: u8,
    /// Reports that it sends in a second, Hz; zero for a device that answers whenever it is asked.
    pub report_rate_hz: f64,
}

impl Default for Capabilities {
    /// A device without a name that tells three axes, renders no force and is bounded by nothing else.
    fn default() -> Self {
        Self {
            name: String::new(),
            position_axes: 3,
            force_axes: 0,
            rated_force_n: 0.0,
            continuous_force_n: 0.0,
            max_stiffness_n_per_mm: f64::INFINITY,
            workspace_radius_mm: f64::INFINITY,
            resolution_mm: 0.0,
            n_buttons: 0,
            report_rate_hz: 0.0,
        }
    }
}

impl Capabilities {
    /// A device that exists in the program only: any place, any stiffness, force up to `rated_force_n`.
    pub fn ideal(name: &str, rated_force_n: f64) -> Self {
        Self {
            name: name.into(),
            force_axes: if rated_force_n > 0.0 { 3 } else { 0 },
            rated_force_n,
            continuous_force_n: rated_force_n,
            ..Self::default()
        }
    }
}

/// One finger's device. Called from the servo thread only.
pub trait Device: Send {
    /// What it can do. Fixed while open.
    fn capabilities(&self) -> &Capabilities;

    /// The newest reading; `dt_s` is the time since the last one. Never blocks longer than a fraction of a tick, never
    /// fails: a device that does not answer says so in [`Reading::connected`].
    fn read(&mut self, dt_s: f64) -> Reading;

    /// Renders a force, N, in the frame of the subject. Always finite and within the rated force.
    fn write(&mut self, force_n: Vec3);

    /// Switches force output on or off as a whole. Off: the device lets go entirely, gravity compensation and damping too. A
    /// device is off when it is opened. The servo calls it before the first tick, where it changes, and on any other device
    /// before its first tick. Nothing by itself: the tick sends no force while it is off.
    fn enable(&mut self, _on: bool) {}

    /// Zero force, then let go. Called once, also on the way out of a panic.
    fn close(&mut self) {
        self.write(Vec3::ZERO);
    }

    /// What its link tells about itself; `None` for a device without one.
    fn vitals(&self) -> Option<Arc<Vitals>> {
        None
    }
}
