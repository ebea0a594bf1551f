//! The thread that calls the tick.

use super::record::{FingerRecord, TickRecord};
use super::tick::Rig;
use super::timing::{Health, TimingStats};
use crate::contact::TouchScene;
use crate::device::Device;

/// Newest state outward: everything the window shows of the live servo, in physical units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// The last tick.
    pub record: TickRecord,
    /// Timing since the start.
    pub timing: TimingStats,
    /// Whether the servo runs as it should.
    pub health: Health,
    /// Counts the scenes handed in, so that the window knows which one a record belongs to.
    pub scene_generation: u64,
}

/// Inward: what the window asks of the servo.
pub enum Command {
    /// Feel another scene. The old one comes back through [`Lines::retired`] to be freed outside. Contacts start free.
    SetScene(Box<TouchScene>),
    /// Use another device for a finger; the old one is closed and comes back through [`Lines::retired`].
    SetDevice(usize, Box<dyn Device>),
    /// Switch force output on or off (emergency stop).
    EnableForce(bool),
    /// Start the timing statistics anew.
    ResetTiming,
}

/// Something the servo is done with, to be freed outside.
pub enum Retired {
    /// A scene.
    Scene(Box<TouchScene>),
    /// A closed device.
    Device(Box<dyn Device>),
}

/// How the thread runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoConfig {
    /// Ticks per second, 100 to 10,000.
    pub rate_hz: f64,
    /// A tick that starts later than this after its due time sends no force, ms.
    pub late_bound_ms: f64,
    /// Records the ring holds.
    pub ring_records: usize,
}

impl Default for ServoConfig {
    fn default() -> Self {
        Self {
            rate_hz: 1000.0,
            late_bound_ms: 5.0,
            ring_records: 16 * 1024,
        }
    }
}

/// The outside ends of the three lines.
pub struct Lines {
    /// Newest state.
    pub snapshot: triple_buffer::Output<Snapshot>,
    /// Every tick of every finger.
    pub records: rtrb::Consumer<FingerRecord>,
    /// What is to be freed.
    pub retired: rtrb::Consumer<Retired>,
    /// Commands inward.
    pub commands: rtrb::Producer<Command>,
}

/// The running servo. Dropping it zeroes the force, closes the devices and joins the thread.
pub struct Servo {}

/// Starts the servo thread on `rig` with one device per finger.
///
/// # Errors
/// When the system refuses another thread.
pub fn start(
    _config: ServoConfig,
    _rig: Rig,
    _devices: Vec<Box<dyn Device>>,
) -> std::io::Result<(Servo, Lines)> {
    Err(std::io::Error::other("the servo thread is not built"))
}
