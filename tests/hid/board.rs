//! What an emulated device does with its reports: an arm that gives way to currents, counters, the amplifiers' watchdog.

use crate::kinds::{Kind, Speaks};

/// Encoder counts an axis rests at per mA: the spring against which the simulated motors work. A power of two, so that the rest is exact.
pub const COUNTS_PER_MA: f64 = 0.5;
/// Where the 14-byte report has a count: encoder e, of the wrist, which the simulated arm has none of.
pub const ENCODER_E: usize = 8;
/// Where this test writes its own count into the free bytes of a 64-byte report.
pub const COUNT_AT: usize = 60;

/// A way in which a device can be wrong; a check that does not notice it is no check.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Input reports end one byte early.
    Short,
    /// Every hundredth input report never leaves the device.
    Loses,
    /// Output reports are taken as if the id byte were not there: all fields one byte off.
    Shifted,
    /// The counter stands still: the same report over and over.
    Frozen,
    /// The serial number is another one.
    Alias,
    /// Announces another usage page.
    Page,
    /// Pays no heed to being unplugged.
    Stays,
    /// Has no watchdog over its amplifiers.
    Deaf,
    /// Its product id is another one.
    Stranger,
    /// Its arm is not as long as its maker says.
    Bent,
}

impl Fault {
    pub const ALL: [(&'static str, Self); 10] = [
        ("short", Self::Short),
        ("loses", Self::Loses),
        ("shifted", Self::Shifted),
        ("frozen", Self::Frozen),
        ("alias", Self::Alias),
        ("page", Self::Page),
        ("stays", Self::Stays),
        ("deaf", Self::Deaf),
        ("stranger", Self::Stranger),
        ("bent", Self::Bent),
    ];

    pub fn key(self) -> &'static str {
        Self::ALL
            .iter()
            .find(|(_, fault)| *fault == self)
            .map_or("none", |(key, _)| key)
    }
}

/// One axis: a mass on a spring with friction, driven by a current; counts.
#[derive(Debug, Clone, Copy, Default)]
struct Axis {
    counts: f64,
    counts_per_s: f64,
}

impl Axis {
    /// One millisecond under a current. Critically damped at 100 rad/s, semi-implicit Euler.
    fn step(&mut self, current_ma: f64) {
        const OMEGA: f64 = 100.0;
        let pull = OMEGA * OMEGA * (COUNTS_PER_MA * current_ma - self.counts)
            - 2.0 * OMEGA * self.counts_per_s;
        self.counts_per_s += pull * 1e-3;
        self.counts += self.counts_per_s * 1e-3;
    }
}

/// What the device has seen, told to the checks on request.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Seen {
    /// Input reports that left.
    pub sent: u64,
    /// Output reports that came.
    pub got: u64,
    /// Output reports missing by their counter.
    pub missing: u64,
    /// Whether the amplifiers' watchdog fired since the newest.
    pub off: bool,
    /// The newest output report, id byte first.
    pub last: Vec<u8>,
    /// Programs that have the device open.
    pub open: bool,
}

/// The device's own side of the protocol.
pub struct Board {
    kind: &'static Kind,
    fault: Option<Fault>,
    arm: [Axis; 3],
    offset: [i16; 3],
    current_ma: [i16; 3],
    quiet_ms: u64,
    asked: bool,
    count: u32,
    host_count: Option<u32>,
    pub seen: Seen,
}

impl Board {
    /// At rest, encoder a at `offset` counts (by which twins are told apart).
    pub fn new(kind: &'static Kind, offset: i16, fault: Option<Fault>) -> Self {
        Self {
            kind,
            fault,
            arm: [Axis::default(); 3],
            offset: [offset, 0, 0],
            current_ma: [0; 3],
            quiet_ms: 0,
            asked: false,
            count: 0,
            host_count: None,
            seen: Seen::default(),
        }
    }

    /// One millisecond passes; the reports that leave at its end.
    pub fn step(&mut self) -> Vec<Vec<u8>> {
        self.quiet_ms += 1;
        if self.quiet_ms == self.kind.speaks.off_after_ms()
            && self.seen.got > 0
            && self.fault != Some(Fault::Deaf)
        {
            self.current_ma = [0; 3];
            self.seen.off = true;
        }
        for (axis, current_ma) in self.arm.iter_mut().zip(self.current_ma) {
            axis.step(f64::from(current_ma));
        }
        if self.fault != Some(Fault::Frozen) {
            self.count = self.count.wrapping_add(1);
        }
        if self.fault == Some(Fault::Loses) && self.count.is_multiple_of(100) {
            return Vec::new();
        }
        let mut reports = self.reports();
        self.asked = false;
        if self.fault == Some(Fault::Short) {
            for report in &mut reports {
                report.pop();
            }
        }
        self.seen.sent += reports.len() as u64;
        reports
    }

    fn reports(&self) -> Vec<Vec<u8>> {
        let mut encoder = [0; 3];
        for (to, (axis, offset)) in encoder.iter_mut().zip(self.arm.iter().zip(self.offset)) {
            *to = (axis.counts.round() as i16).wrapping_add(offset);
        }
        let [a, b, c] = encoder;
        let low = self.count as u16 as i16;
        // An axis of the mouse runs up and down its range, each from another place; all six show in one picture.
        let deflection = |axis: u32| ((self.count + 100 * axis) % 701) as i16 - 350;
        match self.kind.speaks {
            Speaks::Wooden8 => vec![words(&[a, b, c, low], 8)],
            Speaks::Wooden14 if !self.asked => Vec::new(),
            Speaks::Wooden14 => vec![words(&[a, b, c, 0, low, 0, 0], 14)],
            Speaks::Teensy64 => {
                // The calibration button rides on encoder d: pressed in every second of two.
                let d = if self.count / 1000 % 2 == 1 {
                    10_000
                } else {
                    0
                };
                let mut report = words(&[a, b, c, d, 0, 0, 0], 64);
                report[COUNT_AT..].copy_from_slice(&self.count.to_le_bytes());
                vec![report]
            }
            Speaks::SpaceMouseSplit if self.count.is_multiple_of(2) => {
                vec![numbered(2, &[deflection(3), deflection(4), deflection(5)])]
            }
            Speaks::SpaceMouseSplit => {
                let mut reports = vec![numbered(1, &[deflection(0), deflection(1), deflection(2)])];
                reports.extend(self.buttons());
                reports
            }
            Speaks::SpaceMouseWhole => {
                let mut reports = vec![numbered(1, &[0, 1, 2, 3, 4, 5].map(deflection))];
                reports.extend(self.buttons());
                reports
            }
        }
    }

    /// The left button changes every 50 reports.
    fn buttons(&self) -> Option<Vec<u8>> {
        (self.count % 50 == 1).then(|| vec![3, (self.count / 50 % 2) as u8, 0])
    }

    /// A report from the host, the id byte in front.
    pub fn output(&mut self, report: &[u8]) {
        self.seen.got += 1;
        self.seen.off = false;
        self.seen.last = report.to_vec();
        self.quiet_ms = 0;
        self.asked = true;
        // A USB host strips the id byte 0 of reports that are not numbered; so does this board.
        let body = if self.fault == Some(Fault::Shifted) {
            report
        } else {
            report.get(1..).unwrap_or_default()
        };
        let word = |i: usize| {
            body.get(2 * i..2 * i + 2)
                .map_or(0, |b| i16::from_le_bytes([b[0], b[1]]))
        };
        let currents = [word(0), word(1), word(2)];
        let count = match self.kind.speaks {
            Speaks::Wooden8 => Some((u32::from(word(3) as u16), 0xFFFF)),
            Speaks::Wooden14 => None,
            Speaks::Teensy64 => body
                .get(COUNT_AT..COUNT_AT + 4)
                .map(|b| (u32::from_le_bytes([b[0], b[1], b[2], b[3]]), u32::MAX)),
            Speaks::SpaceMouseSplit | Speaks::SpaceMouseWhole => return,
        };
        if self.kind.speaks == Speaks::Wooden14 && word(3) == 1 {
            // Preset: the words of the currents are what the encoders read from here on.
            for (offset, (axis, counts)) in
                self.offset.iter_mut().zip(self.arm.iter().zip(currents))
            {
                *offset = counts.wrapping_sub(axis.counts.round() as i16);
            }
            self.current_ma = [0; 3];
            return;
        }
        self.current_ma = currents;
        if let Some((count, mask)) = count {
            if let Some(before) = self.host_count {
                self.seen.missing += u64::from(count.wrapping_sub(before).wrapping_sub(1) & mask);
            }
            self.host_count = Some(count);
        }
    }

    /// The plug goes in anew: what the host said before is forgotten, the arm stays where it is.
    pub fn plugged(&mut self) {
        self.current_ma = [0; 3];
        self.host_count = None;
        self.asked = false;
        self.seen = Seen::default();
    }
}

/// Little-endian words, padded with zeros to `bytes`.
pub fn words(values: &[i16], bytes: usize) -> Vec<u8> {
    let mut report: Vec<u8> = values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    report.resize(bytes, 0);
    report
}

fn numbered(id: u8, values: &[i16]) -> Vec<u8> {
    let mut report = vec![id];
    report.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    report
}
