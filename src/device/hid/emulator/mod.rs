//! A device that is not there: the simulated arm behind the bytes of a real board, with the faults that boards have.
//!
//! It stands at the far end of a socket, in a thread or in a process of its own, and speaks each protocol as the board does,
//! once a millisecond. What it knows of itself and of its force is the truth that the host is held against.

mod board;
mod hand;
mod plant;
#[cfg(target_os = "linux")]
pub mod process;
pub mod truth;

pub use hand::Hand;
pub use plant::{Mechanics, Plant};

use super::arm::Arm;
use super::driver::Protocol;
use super::transport::{Gone, Port};
use board::Board;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use truth::Truth;

/// The hidden subcommand that is the emulator as a process.
pub const SUBCOMMAND: &str = "emulate-device";

/// What goes wrong with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// It is pulled out.
    Unplugged,
    /// It repeats its last report.
    Frozen,
    /// It says nothing more.
    Silent,
    /// Its encoders jump.
    Jump,
    /// Its encoders say the most that the report can carry, this way and that.
    Extreme,
    /// Its reports are cut off.
    Short,
    /// It reports every 50 ms.
    Slow,
    /// The motor that lifts turns the wrong way, and the hand lets go.
    Reversed,
}

impl Fault {
    /// All.
    pub const ALL: [Self; 8] = [
        Self::Unplugged,
        Self::Frozen,
        Self::Silent,
        Self::Jump,
        Self::Extreme,
        Self::Short,
        Self::Slow,
        Self::Reversed,
    ];

    /// Name on the command line.
    pub fn key(self) -> &'static str {
        match self {
            Self::Unplugged => "unplugged",
            Self::Frozen => "frozen",
            Self::Silent => "silent",
            Self::Jump => "jump",
            Self::Extreme => "extreme",
            Self::Short => "short",
            Self::Slow => "slow",
            Self::Reversed => "reversed",
        }
    }

    /// The fault called `key`.
    pub fn by_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.key() == key)
    }
}

/// What is emulated.
#[derive(Clone, Debug)]
pub struct Options {
    /// Which board.
    pub protocol: Protocol,
    /// Its arm.
    pub arm: Arm,
    /// Mass, friction, hand.
    pub mechanics: Mechanics,
    /// What the hand does.
    pub hand: Hand,
    /// How late its reports come, ms.
    pub delay_ms: u16,
    /// What goes wrong, once it has been pressed with 1 N for a while.
    pub fault: Option<Fault>,
    /// How long it lives, s.
    pub seconds: f64,
    /// Whether it keeps a row of the truth for every millisecond.
    pub keeps_truth: bool,
}

/// What it came to.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Outcome {
    /// Reports sent.
    pub sent: u64,
    /// Reports heard.
    pub heard: u64,
    /// Reports heard that it did not understand.
    pub not_understood: u64,
    /// Where the tip was when currents last flowed, mm.
    pub pressed_position_mm: [f64; 3],
    /// Force at the tip then, N.
    pub pressed_force_n: [f64; 3],
    /// Highest force at the tip, N.
    pub highest_n: f64,
    /// Force when the fault came, N; absent: it never came.
    pub fault_n: Option<f64>,
    /// From the fault until no current was commanded or the board took it off, and none was again, ms; absent: never.
    pub zero_after_ms: Option<f64>,
    /// Highest force at the tip since the fault, N.
    pub highest_since_n: f64,
    /// When the fault came, s of [`truth::now_s`].
    #[serde(default)]
    pub fault_at_s: Option<f64>,
    /// Longest time between two of its milliseconds, ms: how much the machine held it up.
    #[serde(default)]
    pub held_up_ms: f64,
    /// Whether the last command was no current.
    pub ended_at_zero: bool,
}

/// How long a board whose host went without taking its currents off is looked at, s.
const ALONE_S: f64 = 1.0;

/// Speaks at `port` until its time is over, the host goes or `stop` is set; what it came to, and the truth of every
/// millisecond where it was asked for.
///
/// A host that goes leaves the board powered: whatever was commanded last flows on until the board's own watchdog ends it.
pub fn serve(mut port: impl Port, options: &Options, stop: &AtomicBool) -> (Outcome, Vec<Truth>) {
    let mut board = Board::new(options);
    let started = Instant::now();
    let mut due = started;
    let mut alone_since_s = None;
    while !stop.load(Ordering::Acquire) {
        let t = started.elapsed().as_secs_f64();
        if t >= options.seconds {
            break;
        }
        match alone_since_s {
            None if board.millisecond(&mut port, t) == Err(Gone) => alone_since_s = Some(t),
            None => {}
            Some(since_s) => {
                board.alone(t);
                if board.is_unplugged() || board.is_at_zero() || t - since_s > ALONE_S {
                    break;
                }
            }
        }
        due = (due + Duration::from_millis(1)).max(Instant::now() - Duration::from_millis(5));
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
    }
    if alone_since_s.is_none() {
        // What the host said at the end.
        let _ = board.listen(&mut port, started.elapsed().as_secs_f64());
    }
    board.outcome()
}
