//! The servo: one pure function per tick, a thread that calls it, three lines to the window.
//!
//! ```text
//!            ┌── Snapshot (triple buffer, newest only) ──► window
//!   servo ───┼── FingerRecord (bounded ring, every tick) ─► recorder
//!   thread   └── retired boxes (bounded ring) ────────────► freed outside
//!            ◄── Command (bounded ring) ────────────────── window
//! ```
//!
//! # What a force passes on its way to a hand
//! The same for every family of devices, in this order. Each step can only take away, but for the passivity controller and
//! the damping by the motors, which stand before a clamp to the rated force.
//!
//! | step | where | what it does |
//! |---|---|---|
//! | reading | tick | a device that does not answer, or a place that is not finite: no contact, no force, and the proxy is placed anew |
//! | contact | tick | who is placed inside the skin feels nothing until he was outside |
//! | stiffness | tick, [`StiffnessBound`] | skin rendered softer than it is, for a device that cannot bear it |
//! | passivity | tick, [`passivity`] | where it is on: what the skin gave out beyond what was put in is taken up again |
//! | gate | tick | force switched off, tick late, no reading, a force that is not finite: zero |
//! | rated force | tick, [`Limits`] | shortened, direction kept |
//! | rise | tick, [`Limits`] | no faster up than allowed, from zero after the gate was shut: first contact, enabling, coming back |
//! | clutch | [`Mapped`](crate::device::mapped::Mapped) | zero while the finger is let go of by its button |
//! | switch | link, [`Output`](crate::device::hid::output::Output) | off: no current at all, whatever else the motors would do |
//! | order | link | none for `command_timeout_ms`: no current; a servo that hangs leaves no force standing |
//! | guard | link, [`Guard`](crate::device::hid::guard::Guard) | silent, frozen, jumped, too fast, too far, against its force: no current |
//! | damping | link | where the device file asks for it, against the motion |
//! | rated force | link | once more; what is not finite: no current |
//! | motors | driver | gravity compensation by its share, then the current limits, all motors together |
//! | watchdog | device | its own, where it has one: a host that falls silent |
//!
//! Families reach the link by HID, a maker's library or a maker's service. The mouse, scripts and replay have no link and
//! render no force. The end of a link, however it comes, is the report of no current, several times. [`halt()`] ends every
//! servo: zero, switched off, closed.

mod fade;
mod halt;
mod limiter;
pub mod passivity;
mod record;
mod runner;
mod stiffness;
mod tick;
mod timing;

pub use crate::device::MAX_FINGERS;
pub use fade::{MOST_SHARE, MOST_STEP_N};
pub use halt::{
    Halt, Running, halt, halt_on_panic, halted, resume, running, tolerate, wait_for_halt,
};
pub use limiter::{LimitFlags, Limits};
pub use record::{FingerRecord, TickInput, TickRecord};
pub use runner::{
    Command, Fault, HANG_BOUND, Lines, Retired, Servo, ServoConfig, Snapshot, run_offline, start,
};
pub use stiffness::StiffnessBound;
pub use tick::{Rig, tick};
pub use timing::{DURATION_BIN_US, Health, N_BINS, PERIOD_BIN_US, TimingStats};
