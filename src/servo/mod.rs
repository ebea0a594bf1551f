//! The servo: one pure function per tick, a thread that calls it, three lines to the window.
//!
//! ```text
//!            ┌── Snapshot (triple buffer, newest only) ──► window
//!   servo ───┼── FingerRecord (bounded ring, every tick) ─► recorder
//!   thread   └── retired boxes (bounded ring) ────────────► freed outside
//!            ◄── Command (bounded ring) ────────────────── window
//! ```

mod limiter;
mod record;
mod runner;
mod tick;
mod timing;

pub use limiter::{LimitFlags, Limits};
pub use record::{FingerRecord, MAX_FINGERS, TickInput, TickRecord};
pub use runner::{Command, Lines, Servo, ServoConfig, Snapshot, start};
pub use tick::{Rig, tick};
pub use timing::{Health, TimingStats};
