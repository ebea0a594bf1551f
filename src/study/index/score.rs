//! What the trial of a recording came to, from the journal beside it.

use crate::training::journal::{self, Read};
use crate::training::trial::TrialRecord;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What a trial came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Score {
    /// Its number among the scored or the practice trials, from 1.
    pub trial: u32,
    /// Not scored.
    pub practice: bool,
    /// What was asked.
    pub task: String,
    /// Whether the answer was right.
    pub right: bool,
    /// By how far it was wrong, mm.
    pub error_mm: Option<f64>,
    /// Right answers of the whole exercise so far, practice left out.
    pub exercise_right: u32,
    /// Of how many.
    pub exercise_trials: u32,
}

impl Score {
    fn of(trial: &TrialRecord, read: &Read) -> Self {
        let scored = || read.trials.iter().filter(|t| !t.practice);
        Self {
            trial: trial.trial,
            practice: trial.practice,
            task: trial.task.clone(),
            right: trial.right,
            error_mm: trial.errors.mm.filter(|mm| mm.is_finite()),
            exercise_right: scored().filter(|t| t.right).count() as u32,
            exercise_trials: scored().count() as u32,
        }
    }

    /// In a few words, such as "wrong by 34 mm".
    pub fn text(&self) -> String {
        match (self.right, self.error_mm) {
            (true, _) => "right".to_owned(),
            (false, Some(mm)) => format!("wrong by {mm:.0} mm"),
            (false, None) => "wrong".to_owned(),
        }
    }
}

/// What the trial of the recording at `path` came to; `None` where it is no settled trial of an exercise.
pub fn score_of(path: &Path) -> Option<Score> {
    Journals::default().score(path)
}

/// Journals, each read once.
#[derive(Default)]
pub(super) struct Journals(BTreeMap<PathBuf, Option<Read>>);

impl Journals {
    pub(super) fn score(&mut self, path: &Path) -> Option<Score> {
        let (practice, number) = trial_of(path)?;
        let folder = path.parent()?;
        let read = self.0.entry(folder.to_owned());
        let read = read.or_insert_with_key(|folder| journal::read(folder).ok());
        let read = read.as_ref()?;
        let is = |t: &&TrialRecord| t.practice == practice && t.trial == number;
        Some(Score::of(read.trials.iter().find(is)?, read))
    }
}

/// Whether it is practice, and its number, by the name of its file.
fn trial_of(path: &Path) -> Option<(bool, u32)> {
    let (sort, number) = path.file_stem()?.to_str()?.split_once('_')?;
    let practice = match sort {
        "trial" => false,
        "practice" => true,
        _ => return None,
    };
    Some((practice, number.parse().ok()?))
}
