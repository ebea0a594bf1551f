//! What the trainee may see of a trial: nothing here tells what is hidden before the answer.

use super::trial::{Answer, Pointed};
use crate::geom::Vec2;
use crate::scenario::{Dysfunction, Site};

/// Where a trial is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Waits for the trainee to start it.
    Ready,
    /// Is being palpated; it may be answered at any time.
    Palpating,
    /// Is no longer felt and waits for the answer.
    Answering,
    /// Is answered.
    Feedback,
    /// There is none any more.
    Done(Why),
}

/// Why an exercise is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// All trials are settled.
    AllDone,
    /// The staircase has turned as often as it should.
    Converged,
    /// Its time is over.
    OutOfTime,
    /// It was broken off.
    Aborted,
}

impl Why {
    /// For people.
    pub fn words(self) -> &'static str {
        match self {
            Self::AllDone => "All trials are done.",
            Self::Converged => "The staircase has settled.",
            Self::OutOfTime => "The time is over.",
            Self::Aborted => "The exercise was broken off.",
        }
    }
}

/// All that may be shown at a moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// Where the trial is.
    pub phase: Phase,
    /// Whether the clock stands still and nothing is felt.
    pub paused: bool,
    /// Whether the trial is not scored.
    pub practice: bool,
    /// Number of the trial, from 1.
    pub trial: u32,
    /// How many there are of its sort at most.
    pub of: u32,
    /// Name of the task.
    pub title: &'static str,
    /// What is asked.
    pub prompt: String,
    /// Where it may be.
    pub candidates: Vec<Site>,
    /// Answers to choose from; none where places are marked.
    pub choices: Vec<Choice>,
    /// Places that are pointed at.
    pub pointed: Vec<Pointed>,
    /// Whether it is asked how sure the answer is; it is refused without.
    pub asks_confidence: bool,
    /// Whether the kind is asked for.
    pub asks_kind: bool,
    /// Whether the severity is asked for.
    pub asks_severity: bool,
    /// Time left to palpate, s.
    pub trial_left_s: Option<f64>,
    /// Time left for the exercise, s.
    pub exercise_left_s: Option<f64>,
    /// Right answers and scored trials so far; nothing where there is no feedback.
    pub right_so_far: Option<(u32, u32)>,
    /// What is told of the answer, after it.
    pub feedback: Option<Told>,
}

/// An answer to choose.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The answer.
    pub answer: Answer,
    /// On the button.
    pub label: String,
    /// Key that gives it; the others are chosen otherwise.
    pub key: Option<char>,
}

impl Choice {
    /// A choice with its label and key.
    pub fn new(answer: Answer) -> Self {
        let (label, key) = match &answer {
            Answer::Same(true) => ("Same".to_owned(), Some('S')),
            Answer::Same(false) => ("Different".to_owned(), Some('D')),
            Answer::Stiffer(i) => {
                let name = super::trial::pointed_name(*i);
                (name.to_string(), Some(name))
            }
            Answer::Severity(n) => (n.to_string(), char::from_digit(u32::from(*n), 10)),
            other => (other.to_string(), None),
        };
        Self { answer, label, key }
    }
}

/// What is told after an answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    /// Whether it was right.
    pub right: bool,
    /// In words.
    pub text: String,
    /// What was hidden; nothing where only right or wrong is told.
    pub truth: Vec<Dysfunction>,
    /// Where, on the map plane, mm.
    pub truth_mm: Vec<Vec2>,
    /// Whether it can be felt again.
    pub can_feel_again: bool,
    /// Whether it is being felt again.
    pub feeling_again: bool,
}
