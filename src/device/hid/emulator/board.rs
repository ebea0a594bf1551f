//! One board: what it hears, does and says in each millisecond, and what it keeps of the truth.

use super::truth::{Truth, now_s};
use super::{Fault, Options, Outcome, Plant};
use crate::device::hid::driver::Protocol;
use crate::device::hid::report::{polhem, teensy, wooden};
use crate::device::hid::transport::{Gone, Port, REPORT};
use crate::geom::Vec3;
use std::collections::VecDeque;

/// How long it is pressed before a fault comes, s.
const PRESSED_S: f64 = 0.1;
/// What counts as pressed, N.
const PRESSED_N: f64 = 1.0;
/// How far encoders jump, counts: some 100 mm.
const JUMP_COUNTS: i32 = 3000;

pub(super) struct Board<'a> {
    options: &'a Options,
    plant: Plant,
    commanded_a: [f64; 3],
    /// The force that they mean where the tip was when they came, N.
    commanded_n: Vec3,
    heard_s: Option<f64>,
    now_s: f64,
    counter: u16,
    pressed_since_s: Option<f64>,
    fault_s: Option<f64>,
    zero_since_s: Option<f64>,
    late: VecDeque<([u8; REPORT], usize)>,
    frozen: Option<([u8; REPORT], usize)>,
    ms: u64,
    /// Reports made, those on their way included.
    made: u64,
    tally: Outcome,
    truths: Vec<Truth>,
}

impl<'a> Board<'a> {
    pub(super) fn new(options: &'a Options) -> Self {
        let start = Vec3::Z * 20.0;
        Self {
            options,
            plant: Plant::new(options.arm.clone(), options.mechanics, start),
            commanded_a: [0.0; 3],
            commanded_n: Vec3::ZERO,
            heard_s: None,
            now_s: 0.0,
            counter: 0,
            pressed_since_s: None,
            fault_s: None,
            zero_since_s: None,
            late: VecDeque::new(),
            frozen: None,
            ms: 0,
            made: 0,
            tally: Outcome::default(),
            truths: Vec::new(),
        }
    }

    fn fault(&self) -> Option<Fault> {
        self.options.fault.filter(|_| self.fault_s.is_some())
    }

    /// Whether it was pulled out.
    pub(super) fn is_unplugged(&self) -> bool {
        self.fault() == Some(Fault::Unplugged)
    }

    /// Whether no current is commanded.
    pub(super) fn is_at_zero(&self) -> bool {
        self.commanded_a == [0.0; 3]
    }

    /// Listens, moves on, reports.
    pub(super) fn millisecond(&mut self, port: &mut impl Port, t: f64) -> Result<(), Gone> {
        let heard = self.listen(port, t);
        self.advance(t);
        heard?;
        if self.is_unplugged() {
            // Its power is gone with the plug.
            self.commanded_a = [0.0; 3];
            self.commanded_n = Vec3::ZERO;
            self.zero_since_s = Some(t);
            return Err(Gone);
        }
        self.ms += 1;
        self.speak(port)
    }

    /// Moves on without a host.
    pub(super) fn alone(&mut self, t: f64) {
        self.watch(t);
        self.advance(t);
    }

    fn advance(&mut self, t: f64) {
        // Once something failed the hand stays.
        let moves_s = self.fault_s.unwrap_or(t);
        self.plant.target_mm = self.options.hand.target_mm(moves_s);
        let dt_s = (t - self.now_s).max(0.0);
        self.plant.advance(self.commanded_a, dt_s.min(0.1));
        if self.ms > 0 {
            self.tally.held_up_ms = self.tally.held_up_ms.max(dt_s * 1000.0);
        }
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
        if self.options.keeps_truth {
            self.truths.push(Truth {
                at_s: now_s(),
                position_mm: self.plant.position_mm,
                flowing_n: self.plant.force_n(),
                commanded_n: self.commanded_n,
                report: self.made + 1,
                heard: self.tally.heard,
            });
        }
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
            self.tally.fault_at_s = Some(now_s());
            if self.options.fault == Some(Fault::Reversed) {
                self.plant.reversed = Some(2);
                self.plant.mechanics.hand_n_per_mm = 0.0;
                self.plant.mechanics.hand_n_s_per_mm = 0.0;
            }
        }
    }

    pub(super) fn listen(&mut self, port: &mut impl Port, t: f64) -> Result<(), Gone> {
        let mut into = [0; REPORT];
        let mut gone = Ok(());
        loop {
            let n = match port.read(&mut into, 0) {
                Ok(0) => break,
                Ok(n) => n,
                Err(Gone) => {
                    gone = Err(Gone);
                    break;
                }
            };
            match self.understand(&into[..n]) {
                Some(ma) => {
                    self.tally.heard += 1;
                    self.heard_s = Some(t);
                    self.commanded_a = ma.map(|ma| f64::from(ma) / 1000.0);
                    self.commanded_n = self.plant.force_of_n(self.commanded_a);
                }
                None => self.tally.not_understood += 1,
            }
        }
        self.watch(t);
        gone
    }

    /// The board's own watchdog, and since when nothing is commanded.
    fn watch(&mut self, t: f64) {
        let patience_s = self.options.protocol.board_watchdog_s();
        if let (Some(patience_s), Some(heard_s)) = (patience_s, self.heard_s)
            && t - heard_s > patience_s
        {
            self.commanded_a = [0.0; 3];
            self.commanded_n = Vec3::ZERO;
        }
        if self.is_at_zero() {
            self.zero_since_s.get_or_insert(t);
        } else {
            self.zero_since_s = None;
        }
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
        self.made += 1;
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
        if self.fault() == Some(Fault::Extreme) {
            let most = if self.ms.is_multiple_of(2) {
                i16::MAX
            } else {
                i16::MIN
            };
            encoders = [i32::from(most); 3];
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

    pub(super) fn outcome(mut self) -> (Outcome, Vec<Truth>) {
        self.tally.ended_at_zero = self.is_at_zero();
        if let (Some(fault_s), Some(zero_s)) = (self.fault_s, self.zero_since_s) {
            self.tally.zero_after_ms = Some((zero_s - fault_s).max(0.0) * 1000.0);
        }
        (self.tally, self.truths)
    }
}
