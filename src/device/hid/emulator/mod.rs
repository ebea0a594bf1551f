//! A device that is not there: the simulated arm behind the bytes of a real board, with the faults that boards have.
//!
//! It stands at the far end of a socket, in a thread or in a process of its own, and speaks each protocol as the board does,
//! once a millisecond. What it knows of itself and of its force is the truth that the host is held against.

mod plant;
#[cfg(target_os = "linux")]
pub mod process;

pub use plant::{Mechanics, Plant};

use super::arm::Arm;
use super::driver::Protocol;
use super::report::{polhem, teensy, wooden};
use super::transport::{Gone, Port, REPORT};
use crate::geom::Vec3;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The hidden subcommand that is the emulator as a process.
pub const SUBCOMMAND: &str = "emulate-device";

/// What goes wrong with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
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
    /// Its reports are cut off.
    Short,
    /// It reports every 50 ms.
    Slow,
    /// The motor that lifts turns the wrong way, and the hand lets go.
    Reversed,
}

impl Fault {
    /// All.
    pub const ALL: [Self; 7] = [
        Self::Unplugged,
        Self::Frozen,
        Self::Silent,
        Self::Jump,
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
    /// How deep under the middle of its workspace the hand presses, mm.
    pub press_mm: f64,
    /// How late its reports come, ms.
    pub delay_ms: u16,
    /// What goes wrong, once it has been pressed with 1 N for a while.
    pub fault: Option<Fault>,
    /// How long it lives, s.
    pub seconds: f64,
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
    /// Whether the last command was no current.
    pub ended_at_zero: bool,
}

/// How long it is pressed before a fault comes, s.
const PRESSED_S: f64 = 0.3;
/// What counts as pressed, N.
const PRESSED_N: f64 = 1.0;
/// How far encoders jump, counts: some 100 mm.
const JUMP_COUNTS: i32 = 3000;

/// Speaks at `port` until its time is over, the host goes or `stop` is set.
pub fn serve(mut port: impl Port, options: &Options, stop: &AtomicBool) -> Outcome {
    let mut board = Board::new(options);
    let started = Instant::now();
    let mut due = started;
    while !stop.load(Ordering::Acquire) {
        let t = started.elapsed().as_secs_f64();
        if t >= options.seconds {
            break;
        }
        if board.millisecond(&mut port, t) == Err(Gone) {
            break;
        }
        due = (due + Duration::from_millis(1)).max(Instant::now() - Duration::from_millis(5));
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
    }
    if board.fault() != Some(Fault::Unplugged) {
        // What the host said at the end.
        let _ = board.listen(&mut port, started.elapsed().as_secs_f64());
    }
    board.outcome()
}

struct Board<'a> {
    options: &'a Options,
    plant: Plant,
    commanded_a: [f64; 3],
    heard_s: Option<f64>,
    now_s: f64,
    counter: u16,
    pressed_since_s: Option<f64>,
    fault_s: Option<f64>,
    zero_since_s: Option<f64>,
    late: VecDeque<([u8; REPORT], usize)>,
    frozen: Option<([u8; REPORT], usize)>,
    ms: u64,
    tally: Outcome,
}

impl<'a> Board<'a> {
    fn new(options: &'a Options) -> Self {
        let start = Vec3::Z * 20.0;
        Self {
            options,
            plant: Plant::new(options.arm.clone(), options.mechanics, start),
            commanded_a: [0.0; 3],
            heard_s: None,
            now_s: 0.0,
            counter: 0,
            pressed_since_s: None,
            fault_s: None,
            zero_since_s: None,
            late: VecDeque::new(),
            frozen: None,
            ms: 0,
            tally: Outcome::default(),
        }
    }

    fn fault(&self) -> Option<Fault> {
        self.options.fault.filter(|_| self.fault_s.is_some())
    }

    /// Listens, moves on, reports.
    fn millisecond(&mut self, port: &mut impl Port, t: f64) -> Result<(), Gone> {
        self.listen(port, t)?;
        // The hand: rests above, goes down within half a second, stays there.
        let down = ((t - 0.3) / 0.5).clamp(0.0, 1.0);
        self.plant.target_mm = Vec3::Z * (20.0 - (20.0 + self.options.press_mm) * down);
        self.plant
            .advance(self.commanded_a, (t - self.now_s).clamp(0.0, 0.1));
        self.now_s = t;
        if self.commanded_a != [0.0; 3] {
            self.tally.pressed_position_mm = self.plant.position_mm.to_array();
            self.tally.pressed_force_n = self.plant.force_n().to_array();
        }
        let force_n = self.plant.force_n().length();
        self.tally.highest_n = self.tally.highest_n.max(force_n);
        if self.fault_s.is_some() {
            self.tally.highest_since_n = self.tally.highest_since_n.max(force_n);
        }
        self.trouble(force_n, t);
        if self.fault() == Some(Fault::Unplugged) {
            // Its power is gone with the plug.
            self.commanded_a = [0.0; 3];
            self.zero_since_s = Some(t);
            return Err(Gone);
        }
        self.ms += 1;
        self.speak(port)
    }

    fn trouble(&mut self, force_n: f64, t: f64) {
        if self.options.fault.is_none() || self.fault_s.is_some() {
            return;
        }
        if force_n < PRESSED_N {
            self.pressed_since_s = None;
        } else if t - *self.pressed_since_s.get_or_insert(t) >= PRESSED_S {
            self.fault_s = Some(t);
            self.zero_since_s = None;
            self.tally.fault_n = Some(force_n);
            if self.options.fault == Some(Fault::Reversed) {
                self.plant.reversed = Some(2);
                self.plant.mechanics.hand_n_per_mm = 0.0;
                self.plant.mechanics.hand_n_s_per_mm = 0.0;
            }
        }
    }

    fn listen(&mut self, port: &mut impl Port, t: f64) -> Result<(), Gone> {
        let mut into = [0; REPORT];
        loop {
            let n = port.read(&mut into, 0)?;
            if n == 0 {
                break;
            }
            match self.understand(&into[..n]) {
                Some(ma) => {
                    self.tally.heard += 1;
                    self.heard_s = Some(t);
                    self.commanded_a = ma.map(|ma| f64::from(ma) / 1000.0);
                }
                None => self.tally.not_understood += 1,
            }
        }
        let patience_s = self.options.protocol.board_watchdog_s();
        if let (Some(patience_s), Some(heard_s)) = (patience_s, self.heard_s)
            && t - heard_s > patience_s
        {
            self.commanded_a = [0.0; 3];
        }
        if self.commanded_a == [0.0; 3] {
            self.zero_since_s.get_or_insert(t);
        } else {
            self.zero_since_s = None;
        }
        Ok(())
    }

    fn understand(&self, bytes: &[u8]) -> Option<[i16; 3]> {
        let currents = |out| match out {
            polhem::Out::Currents(ma) => ma,
            polhem::Out::Preset(_) => [0; 3],
        };
        match self.options.protocol {
            Protocol::Wooden => wooden::Out::decode(bytes).map(|r| r.current_ma),
            Protocol::Polhem => polhem::Out::decode(bytes).map(currents),
            Protocol::Teensy => teensy::decode_out(bytes).map(currents),
        }
    }

    fn speak(&mut self, port: &mut impl Port) -> Result<(), Gone> {
        // The newer boards answer only those who spoke to them.
        if self.options.protocol != Protocol::Wooden && self.heard_s.is_none() {
            return Ok(());
        }
        let mut report = self.report();
        match self.fault() {
            Some(Fault::Silent) => return Ok(()),
            Some(Fault::Slow) if !self.ms.is_multiple_of(50) => return Ok(()),
            Some(Fault::Short) => report.1 /= 2,
            Some(Fault::Frozen) => report = *self.frozen.get_or_insert(report),
            _ => {}
        }
        self.late.push_back(report);
        if self.late.len() <= usize::from(self.options.delay_ms) {
            return Ok(());
        }
        let Some((bytes, n)) = self.late.pop_front() else {
            return Ok(());
        };
        port.write(&bytes[..n])?;
        self.tally.sent += 1;
        Ok(())
    }

    fn report(&mut self) -> ([u8; REPORT], usize) {
        let mut encoders = self.plant.encoders();
        if self.fault() == Some(Fault::Jump) {
            encoders[1] += JUMP_COUNTS;
        }
        let [a, b, c] = encoders.map(|e| e as i16);
        self.counter = self.counter.wrapping_add(1);
        let wrist = polhem::In {
            encoders: [a, b, c, 0, 0, 0],
            ..polhem::In::default()
        };
        let mut out = [0; REPORT];
        let n = self.options.protocol.in_bytes();
        match self.options.protocol {
            Protocol::Wooden => out[..n].copy_from_slice(
                &wooden::In {
                    encoders: [a, b, c],
                    counter: self.counter as i16,
                }
                .encode(),
            ),
            Protocol::Polhem => out[..n].copy_from_slice(&wrist.encode()),
            Protocol::Teensy => out[..n].copy_from_slice(&teensy::encode(&wrist)),
        }
        (out, n)
    }

    fn outcome(mut self) -> Outcome {
        self.tally.ended_at_zero = self.commanded_a == [0.0; 3];
        if let (Some(fault_s), Some(zero_s)) = (self.fault_s, self.zero_since_s) {
            self.tally.zero_after_ms = Some((zero_s - fault_s).max(0.0) * 1000.0);
        }
        self.tally
    }
}
