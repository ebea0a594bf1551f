//! Where the finger is and who takes the force. One device is one finger.

pub mod mouse;
pub mod null;
pub mod replay;
pub mod scripted;

use crate::geom::Vec3;

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
    /// Highest force it renders, N; zero for a device without force.
    pub rated_force_n: f64,
    /// Highest stiffness it renders stably at 1 kHz, N/mm; infinite where nothing bounds it.
    pub max_stiffness_n_per_mm: f64,
    /// Radius of the sphere it can reach, mm.
    pub workspace_radius_mm: f64,
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

    /// Zero force, then let go. Called once, also on the way out of a panic.
    fn close(&mut self) {
        self.write(Vec3::ZERO);
    }
}
