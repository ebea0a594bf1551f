//! The servo: one pure function per tick, a thread that calls it, three lines to the window.
//!
//! ```text
//!            ┌── Snapshot (triple buffer, newest only) ──► window
//!   servo ───┼── FingerRecord (bounded ring, every tick) ─► recorder
//!   thread   └── retired boxes (bounded ring) ────────────► freed outside
//!            ◄── Command (bounded ring) ────────────────── window
//! ```

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
