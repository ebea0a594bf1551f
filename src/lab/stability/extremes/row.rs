//! What one extreme case is, and how it ended.

use crate::lab::Value;
use crate::servo::tolerate;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// How much of each case is done.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// Ticks of a case that has ticks.
    pub ticks: u64,
    /// Questions of a case without.
    pub questions: usize,
    /// Whether this is the quick look, for which costly structures are small.
    pub quick: bool,
    /// Where chance starts.
    pub seed: u64,
}

/// One extreme case: where it enters, what is done there, and how.
pub struct Case {
    /// What is extreme.
    pub name: String,
    /// The public door it enters by.
    pub door: &'static str,
    /// What is done.
    pub done: String,
    /// Does it.
    pub go: Box<dyn Fn(&Size) -> Ended>,
}

impl Case {
    /// A case by its parts.
    pub fn new(
        name: impl Into<String>,
        door: &'static str,
        done: impl Into<String>,
        go: impl Fn(&Size) -> Ended + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            door,
            done: done.into(),
            go: Box::new(go),
        }
    }

    /// Runs it. A panic ends the case, not the table.
    pub fn row(&self, subject: &str, size: &Size) -> Row {
        let ended = catch_unwind(AssertUnwindSafe(|| tolerate(|| (self.go)(size))));
        let Ended {
            tally,
            outcome,
            says,
        } = ended.unwrap_or_else(|_| Ended::wrong("it panicked"));
        Row {
            subject: subject.to_owned(),
            case: self.name.clone(),
            door: self.door.to_owned(),
            done: self.done.clone(),
            tally,
            outcome,
            says,
        }
    }
}

/// How a case ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Outcome {
    /// Equal to a closed form or to an ordinary case that is equivalent.
    Right,
    /// Finite and within its bounds; what is right is not known.
    Bounded,
    /// Not let in, with one line that says why.
    Refused,
    /// None of these: a fault of the program.
    Wrong,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Right => "right",
            Self::Bounded => "bounded",
            Self::Refused => "refused",
            Self::Wrong => "WRONG",
        })
    }
}

/// What was counted in a case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// Real ticks of the servo.
    pub ticks: u64,
    /// Answers of other doors.
    pub answers: u64,
    /// Numbers that are none, in what ticks and answers hold.
    pub not_finite: u64,
    /// Forces sent beyond what the limits allow.
    pub over_limit: u64,
    /// Largest force sent, N.
    pub largest_n: f64,
    /// Largest length in an answer, mm: an offset, or a distance.
    pub largest_mm: f64,
}

impl Tally {
    /// One answer, made of these lengths, mm.
    pub fn lengths(&mut self, mm: impl IntoIterator<Item = f64>) {
        self.answers += 1;
        for x in mm {
            if x.is_finite() {
                self.largest_mm = self.largest_mm.max(x.abs());
            } else {
                self.not_finite += 1;
            }
        }
    }

    /// One answer, made of numbers that are no lengths.
    pub fn numbers(&mut self, numbers: impl IntoIterator<Item = f64>) {
        self.answers += 1;
        self.not_finite += numbers.into_iter().filter(|x| !x.is_finite()).count() as u64;
    }

    /// Adds what another counted.
    pub fn add(&mut self, other: &Self) {
        self.ticks += other.ticks;
        self.answers += other.answers;
        self.not_finite += other.not_finite;
        self.over_limit += other.over_limit;
        self.largest_n = self.largest_n.max(other.largest_n);
        self.largest_mm = self.largest_mm.max(other.largest_mm);
    }

    fn is_sound(&self) -> bool {
        self.not_finite == 0 && self.over_limit == 0
    }
}

/// What came of a case.
#[derive(Clone, Debug)]
pub struct Ended {
    /// What was counted.
    pub tally: Tally,
    /// How it ended.
    pub outcome: Outcome,
    /// The check it was held against and how near it came, or the line that refuses.
    pub says: String,
}

impl Ended {
    /// Held against a check that says how far off it is; `most` is allowed.
    pub fn held(tally: Tally, check: &str, off: f64, most: f64) -> Self {
        let right = off <= most && tally.is_sound();
        Self {
            tally,
            outcome: if right {
                Outcome::Right
            } else {
                Outcome::Wrong
            },
            says: format!("{check}: off by {off:.1e}, {most:.0e} allowed"),
        }
    }

    /// Held against yes and no: the first fault in words, where there is one.
    pub fn checked(tally: Tally, check: &str, fault: Option<String>) -> Self {
        let right = fault.is_none() && tally.is_sound();
        Self {
            tally,
            outcome: if right {
                Outcome::Right
            } else {
                Outcome::Wrong
            },
            says: fault.unwrap_or_else(|| check.to_owned()),
        }
    }

    /// Only looked at for being finite and bounded.
    pub fn bounded(tally: Tally, says: impl Into<String>) -> Self {
        Self {
            outcome: if tally.is_sound() {
                Outcome::Bounded
            } else {
                Outcome::Wrong
            },
            tally,
            says: says.into(),
        }
    }

    /// Not let in; what it says must be one line.
    pub fn refused(line: impl fmt::Display) -> Self {
        let says = line.to_string();
        let clear = !says.trim().is_empty() && says.lines().count() == 1;
        Self {
            tally: Tally {
                answers: 1,
                ..Tally::default()
            },
            outcome: if clear {
                Outcome::Refused
            } else {
                Outcome::Wrong
            },
            says,
        }
    }

    /// Let in what should have been refused, or the other way round.
    pub fn wrong(says: impl Into<String>) -> Self {
        Self {
            tally: Tally::default(),
            outcome: Outcome::Wrong,
            says: says.into(),
        }
    }

    /// Refused with a line, each of several; the line of the first is told.
    pub fn all_refused<E: fmt::Display>(
        tried: impl IntoIterator<Item = (String, Result<(), E>)>,
    ) -> Self {
        let mut first: Option<Self> = None;
        for (what, result) in tried {
            let one = match result {
                Ok(()) => return Self::wrong(format!("{what} was let in")),
                Err(line) => Self::refused(line),
            };
            match &mut first {
                _ if one.outcome != Outcome::Refused => return one,
                None => first = Some(one),
                Some(first) => first.tally.answers += 1,
            }
        }
        first.unwrap_or_else(|| Self::wrong("nothing was tried"))
    }
}

/// A row of the table.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    /// Group of cases.
    pub subject: String,
    /// What is extreme.
    pub case: String,
    /// The public door.
    pub door: String,
    /// What was done.
    pub done: String,
    /// What was counted.
    pub tally: Tally,
    /// How it ended.
    pub outcome: Outcome,
    /// The check, or the line that refuses.
    pub says: String,
}

/// Columns of the table of [`Row::cells`].
pub const COLUMNS: [&str; 12] = [
    "subject",
    "case",
    "door",
    "done",
    "ticks",
    "answers",
    "not finite",
    "forces over limit",
    "largest force (N)",
    "largest length (mm)",
    "outcome",
    "check or line",
];

impl Row {
    /// Its cells.
    pub fn cells(&self) -> [Value; 12] {
        let t = &self.tally;
        [
            self.subject.as_str().into(),
            self.case.as_str().into(),
            self.door.as_str().into(),
            self.done.as_str().into(),
            (t.ticks as usize).into(),
            (t.answers as usize).into(),
            (t.not_finite as usize).into(),
            (t.over_limit as usize).into(),
            (t.ticks > 0).then_some(t.largest_n).into(),
            (t.largest_mm > 0.0).then_some(t.largest_mm).into(),
            self.outcome.to_string().into(),
            self.says.as_str().into(),
        ]
    }
}
