//! Re-simulation: the recorded inputs through the same tick.

use super::compare::{Difference, FieldDifference, Tally};
use super::header::hexadecimal;
use super::reader::{Session, Strictness, Ticks};
use super::{Damage, SessionError};
use crate::device::MAX_FINGERS;
use crate::servo::{Rig, TickInput, TickRecord, tick};
use serde::Serialize;

/// A recorded tick and what the same inputs give now.
#[derive(Clone, Copy, Debug)]
pub struct Resimulated {
    /// The tick as recorded.
    pub recorded: TickRecord,
    /// The tick as it comes out now. `None` where the run cannot be followed from the tick before: at the start and behind
    /// each gap. There the recorded tick is the state that the next one starts from.
    pub got: Option<TickRecord>,
}

/// Repeats a session on `rig`, whose limits must be those of the header's devices.
///
/// The first tick sets the state, all others are computed. A gap in the tick numbers starts anew behind it.
///
/// # Errors
/// The rig has another surface than the session, or the file cannot be opened.
pub fn resimulate(
    session: &Session,
    rig: Rig,
    strictness: Strictness,
) -> Result<Resimulation, SessionError> {
    let found = hexadecimal(&rig.scene.surface.hash());
    let recorded = &session.header().mesh.hash;
    if *recorded != found {
        return Err(SessionError::OtherSurface {
            path: session.path().to_owned(),
            recorded: recorded.chars().take(12).collect(),
            found: found.chars().take(12).collect(),
        });
    }
    Ok(Resimulation {
        ticks: session.ticks(strictness)?,
        rig,
        dt_s: session.header().dt_s(),
        started: false,
        gaps: 0,
        missing: 0,
    })
}

/// Iterates over the ticks of a session, each with its repetition.
pub struct Resimulation {
    ticks: Ticks,
    rig: Rig,
    dt_s: f64,
    started: bool,
    gaps: u64,
    missing: u64,
}

impl Resimulation {
    /// Gaps in the tick numbers so far.
    pub fn gaps(&self) -> u64 {
        self.gaps
    }

    /// Ticks missing in them.
    pub fn missing(&self) -> u64 {
        self.missing
    }

    /// What a lenient reading stepped over so far.
    pub fn damage(&self) -> &Damage {
        self.ticks.damage()
    }

    /// How much of the file is done, 0 to 1.
    pub fn progress(&self) -> f64 {
        self.ticks.progress()
    }
}

impl Iterator for Resimulation {
    type Item = Result<Resimulated, SessionError>;

    fn next(&mut self) -> Option<Self::Item> {
        let recorded = match self.ticks.next()? {
            Ok(recorded) => recorded,
            Err(e) => return Some(Err(e)),
        };
        let number = recorded.fingers[0].tick;
        let follows = self.started && number == self.rig.next_tick;
        let got = if follows {
            Some(tick(&mut self.rig, &input_of(&recorded), self.dt_s))
        } else {
            if self.started {
                self.gaps += 1;
                self.missing += number.saturating_sub(self.rig.next_tick);
            }
            self.rig.resume_from(&recorded);
            None
        };
        self.started = true;
        Some(Ok(Resimulated { recorded, got }))
    }
}

/// The inputs of a recorded tick.
pub fn input_of(recorded: &TickRecord) -> TickInput {
    let mut input = TickInput {
        n_fingers: recorded.n_fingers.min(MAX_FINGERS),
        ..TickInput::default()
    };
    for (i, record) in recorded.fingers().iter().enumerate().take(MAX_FINGERS) {
        input.readings[i] = record.reading;
        input.place_anew[i] = record.placed_anew;
        input.late = record.late;
        input.force_enabled = record.force_enabled;
    }
    input
}

/// What became of repeating a session.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CheckReport {
    /// Ticks in the session.
    pub ticks: u64,
    /// Ticks computed and compared: all but the first and those behind gaps.
    pub compared: u64,
    /// Number of fingers.
    pub fingers: usize,
    /// Gaps in the tick numbers: lost ticks or a servo started anew.
    pub gaps: u64,
    /// Ticks missing in them.
    pub missing: u64,
    /// Where recording and repetition part first; `None` when they are equal bit for bit.
    pub first_difference: Option<Difference>,
    /// How far apart they are, for each field that differs.
    pub differences: Vec<FieldDifference>,
    /// What a lenient reading stepped over.
    pub damage: Damage,
}

impl CheckReport {
    /// Whether every compared tick came out equal, bit for bit.
    pub fn is_bit_exact(&self) -> bool {
        self.first_difference.is_none()
    }
}

/// Repeats a session and compares every outcome bit for bit.
///
/// After a difference the repetition goes on from its own state, so that the report tells how far the runs drift apart.
///
/// # Errors
/// As [`resimulate`], and what reading finds.
pub fn check(
    session: &Session,
    rig: Rig,
    strictness: Strictness,
) -> Result<CheckReport, SessionError> {
    check_with(session, rig, strictness, |_, _| ())
}

/// As [`check`]; `each` sees every tick and how much of the file is done, 0 to 1.
///
/// # Errors
/// As [`check`].
pub fn check_with(
    session: &Session,
    rig: Rig,
    strictness: Strictness,
    mut each: impl FnMut(&Resimulated, f64),
) -> Result<CheckReport, SessionError> {
    let mut tally = Tally::default();
    let (mut ticks, mut compared) = (0, 0);
    let mut resimulation = resimulate(session, rig, strictness)?;
    while let Some(pair) = resimulation.next() {
        let pair = pair?;
        ticks += 1;
        if let Some(got) = &pair.got {
            compared += 1;
            tally.add(&pair.recorded, got);
        }
        each(&pair, resimulation.progress());
    }
    let differences = tally.fields();
    Ok(CheckReport {
        ticks,
        compared,
        fingers: session.header().n_fingers(),
        gaps: resimulation.gaps,
        missing: resimulation.missing,
        first_difference: tally.first,
        differences,
        damage: resimulation.damage().clone(),
    })
}
