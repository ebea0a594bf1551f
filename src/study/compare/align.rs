//! What of one recording goes with what of another.

use super::super::{Analysis, StudyError};
use serde::{Deserialize, Serialize};

/// How two recordings are aligned.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Align {
    /// By time from the first tick of each: right for a run and its repetition.
    #[default]
    Time,
    /// So that an event falls together.
    Event(Anchor),
    /// By dynamic time warping; see [`super::dtw`].
    Dtw,
}

/// An event that falls together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Anchor {
    /// The finger's first touch of the skin.
    #[default]
    FirstContact,
    /// The start of its n-th press or stroke, from 1.
    Press(u32),
    /// The n-th event of a kind such as `mark`, from 1.
    Event {
        /// Which kind.
        kind: String,
        /// Which of them.
        nth: u32,
    },
}

impl std::fmt::Display for Anchor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::FirstContact => f.write_str("first contact"),
            Self::Press(n) => write!(f, "press {n}"),
            Self::Event { kind, nth } => write!(f, "{kind} {nth}"),
        }
    }
}

impl Anchor {
    /// Reads `contact`, `press:N`, or `KIND:N` of an event; without a number the first.
    ///
    /// # Errors
    /// What is none of them.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (kind, number) = text.split_once(':').unwrap_or((text, "1"));
        let nth = number.trim().parse().ok().filter(|n| *n > 0);
        let (Some(nth), false) = (nth, kind.trim().is_empty()) else {
            return Err(format!(
                "\"{text}\" is no event; contact, press:N, or KIND:N such as mark:2 is allowed, N from 1"
            ));
        };
        Ok(match kind.trim() {
            "contact" => Self::FirstContact,
            "press" => Self::Press(nth),
            kind => Self::Event {
                kind: kind.to_owned(),
                nth,
            },
        })
    }

    /// When it was in a session, s from its first tick.
    ///
    /// # Errors
    /// It never was.
    pub fn time_s(&self, analysis: &Analysis, finger: u8) -> Result<f64, StudyError> {
        let of = analysis.fingers.iter().find(|f| f.finger == finger);
        let nth = |n: u32| n.saturating_sub(1) as usize;
        let found = match self {
            Self::FirstContact => of.and_then(|f| f.first_contact_s),
            Self::Press(n) => of.and_then(|f| f.presses.get(nth(*n))).map(|p| p.start_s),
            Self::Event { kind, nth: n } => {
                let mut same = analysis.events.iter().filter(|e| e.kind == *kind);
                same.nth(nth(*n)).map(|e| e.time_s)
            }
        };
        found.ok_or_else(|| {
            let file = analysis.about.file.display();
            StudyError::TooLittle(format!(
                "{file}: there is no {self} of finger {finger} to align by"
            ))
        })
    }
}
