//! One trial: what is hidden, what is answered, and what is written of it once it is settled.

use super::palpation::Facts;
use super::score::Errors;
use crate::geom::Vec2;
use crate::scenario::{Dysfunction, Place, Site, VertebralLevel};
use serde::{Deserialize, Serialize};
use std::fmt;

/// What is said to be so.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// It is at this candidate.
    Site(Site),
    /// It is here on the map plane, mm: the nearest candidate is meant.
    Here(Vec2),
    /// The two places feel the same, or not.
    Same(bool),
    /// The place pointed at with this number, from 0, is the stiffer one.
    Stiffer(usize),
    /// The place pointed at is at this level.
    Level(VertebralLevel),
    /// It is this severe, 0 to 3.
    Severity(u8),
    /// It is at these places and nowhere else; none: nowhere.
    Marks(Vec<Mark>),
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Site(site) => site.fmt(f),
            Self::Here(at) => write!(f, "at ({:.1}, {:.1}) mm", at.x, at.y),
            Self::Same(true) => f.write_str("same"),
            Self::Same(false) => f.write_str("different"),
            Self::Stiffer(i) => write!(f, "{} is stiffer", pointed_name(*i)),
            Self::Level(level) => level.fmt(f),
            Self::Severity(n) => write!(f, "severity {n}"),
            Self::Marks(marks) if marks.is_empty() => f.write_str("nothing there"),
            Self::Marks(marks) => {
                for (i, mark) in marks.iter().enumerate() {
                    let comma = if i > 0 { ", " } else { "" };
                    write!(f, "{comma}({:.1}, {:.1}) mm", mark.at_mm.x, mark.at_mm.y)?;
                }
                Ok(())
            }
        }
    }
}

/// A place where something is said to be.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// On the map plane, mm.
    pub at_mm: Vec2,
    /// Its kind, by name; where it is asked for.
    pub kind: Option<String>,
    /// Its severity, 0 to 3; where it is asked for.
    pub severity: Option<u8>,
}

/// An answer with all that is said beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct Reply {
    /// What is said to be so.
    pub answer: Answer,
    /// How sure, 0 to 100 %.
    pub confidence_percent: Option<u8>,
    /// The kind, by name.
    pub kind: Option<String>,
    /// The severity, 0 to 3.
    pub severity: Option<u8>,
}

impl From<Answer> for Reply {
    fn from(answer: Answer) -> Self {
        Self {
            answer,
            confidence_percent: None,
            kind: None,
            severity: None,
        }
    }
}

/// A place that the trainee is pointed at.
#[derive(Clone, Debug, PartialEq)]
pub struct Pointed {
    /// "A", "B"; tells nothing of what is hidden.
    pub name: String,
    /// On the map plane, mm.
    pub at_mm: Vec2,
}

impl Pointed {
    /// The place with number `i`, from 0.
    pub fn new(i: usize, at_mm: Vec2) -> Self {
        let name = pointed_name(i).to_string();
        Self { name, at_mm }
    }
}

/// "A" for 0, "B" for 1, ….
pub fn pointed_name(i: usize) -> char {
    char::from(b'A' + (i % 26) as u8)
}

/// What a trial is: drawn before it starts, and known to the trainee only in part.
#[derive(Clone, PartialEq)]
pub struct Draw {
    /// What is hidden.
    pub hidden: Vec<Dysfunction>,
    /// What the trainee is pointed at: the one part that may be shown.
    pub pointed: Vec<Pointed>,
    /// What is right.
    pub right: Answer,
}

impl Draw {
    /// Where the hidden ones are on the map plane, mm.
    pub fn hidden_at_mm(&self) -> impl Iterator<Item = (&Dysfunction, Vec2)> {
        self.hidden
            .iter()
            .flat_map(|d| places_mm(d).into_iter().map(move |at| (d, at)))
    }

    /// The hidden one's site, where it is a single one.
    pub fn site(&self) -> Option<Site> {
        match &self.hidden[..] {
            [one] => match &one.place {
                Place::Sites(sites) if sites.len() == 1 => sites.first().copied(),
                _ => None,
            },
            _ => None,
        }
    }
}

/// Where a dysfunction's middles are on the map plane, mm.
pub fn places_mm(dysfunction: &Dysfunction) -> Vec<Vec2> {
    let offset = dysfunction.offset_mm;
    match &dysfunction.place {
        Place::At(at) => {
            let side = if at.x < 0.0 { -1.0 } else { 1.0 };
            vec![*at + Vec2::new(side * offset.x, offset.y)]
        }
        Place::Sites(sites) => sites
            .iter()
            .map(|s| {
                let side = if s.lateral() < 0.0 { -1.0 } else { 1.0 };
                s.at_mm() + Vec2::new(side * offset.x, offset.y)
            })
            .collect(),
    }
}

/// How a trial came to its end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ended {
    /// Answered when the trainee wanted to.
    #[default]
    Answered,
    /// Answered after the time to palpate was over.
    OutOfTime,
}

/// A settled trial: plain values only, so that a journal can be read by anyone at any time. What is not asked is absent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrialRecord {
    /// Number among the scored trials, or among the practice trials, from 1.
    pub trial: u32,
    /// Not scored.
    pub practice: bool,
    /// What was asked.
    pub task: String,
    /// Level on the staircase's scale; absent without a staircase.
    pub level: Option<f64>,
    /// Size of the change that the trial was given, percent of [`TrialRecord::measure`]; also where nothing was hidden.
    pub strength_percent: Option<f64>,
    /// Of what: compliance or stiffness.
    pub measure: Option<String>,
    /// Change of stiffness of what was hidden, percent; absent where nothing is changed.
    pub stiffness_percent: Option<f64>,
    /// The same as a change of compliance, percent.
    pub compliance_percent: Option<f64>,
    /// Factor on all stiffness of the trial.
    pub stiffness_gain: f64,
    /// Share of right answers by guessing; 0 where guessing leads nowhere.
    pub chance: f64,
    /// What was pointed at.
    pub pointed: Vec<String>,
    /// What was right.
    pub truth: String,
    /// What was answered.
    pub answer: String,
    /// Whether it was right.
    pub right: bool,
    /// How it ended.
    pub ended: Ended,
    /// How sure, percent.
    pub confidence_percent: Option<u8>,
    /// Time spent palpating, s.
    pub search_s: f64,
    /// Time from there to the answer, s.
    pub answer_s: f64,
    /// By how much it was wrong.
    pub errors: Errors,
    /// How it was palpated.
    pub palpation: Facts,
    /// When it was settled, UTC, ISO 8601.
    pub settled_utc: String,
}
