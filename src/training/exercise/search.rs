//! What is there, and where? Free search of the whole back.

use super::{Task, hidden};
use crate::scenario::exercise::Hides;
use crate::scenario::{Change, Exercise, ScenarioError};
use crate::training::random::Random;
use crate::training::score;
use crate::training::trial::{Answer, Draw, Mark, Pointed, places_mm};

/// Finds all that is hidden, and says where.
pub struct Search;

impl Task for Search {
    fn key(&self) -> &'static str {
        "search"
    }

    fn title(&self) -> &'static str {
        "Free search"
    }

    fn about(&self) -> &'static str {
        "Any number of places may be changed, or none: mark each that is found"
    }

    fn prompt(&self, _: &Exercise) -> String {
        "Search the back and mark every place that is changed. There may be none.".into()
    }

    /// From none to as many as there may be, each number as likely as the others, no two at one site; or what the scenario
    /// states.
    fn draw(
        &self,
        exercise: &Exercise,
        change: Change,
        random: &mut Random,
    ) -> Result<Draw, ScenarioError> {
        let Hides::Drawn { most, .. } = exercise.hides else {
            return Ok(Draw {
                hidden: Vec::new(),
                pointed: Vec::new(),
                right: Answer::Marks(Vec::new()),
            });
        };
        let n = random.below(most.min(exercise.candidates.len()) + 1);
        let mut sites = exercise.candidates.clone();
        random.shuffle(&mut sites);
        let hidden = sites[..n]
            .iter()
            .map(|&site| hidden(exercise, site, Some(change), 2))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(all_of(hidden))
    }

    fn choices(&self, _: &Exercise, _: &[Pointed]) -> Vec<Answer> {
        Vec::new()
    }

    fn allows(&self, _: &Exercise, _: &[Pointed], answer: &Answer) -> bool {
        match answer {
            Answer::Marks(marks) => marks.iter().all(|m| m.at_mm.is_finite()),
            _ => false,
        }
    }

    /// All found and nothing marked that is not there.
    fn is_right(&self, exercise: &Exercise, draw: &Draw, answer: &Answer) -> bool {
        let errors = score::errors(exercise, draw, &answer.clone().into());
        errors.missed == Some(0) && errors.false_positives == Some(0)
    }

    /// Who marks a back at random finds nothing.
    fn chance(&self, _: &Exercise) -> f64 {
        0.0
    }

    fn told(&self, draw: &Draw) -> String {
        match draw.hidden_at_mm().count() {
            0 => "Nothing was hidden".into(),
            1 => "One place was changed".into(),
            n => format!("{n} places were changed"),
        }
    }
}

/// The trial in which `hidden` is to be found.
pub(in super::super) fn all_of(hidden: Vec<crate::scenario::Dysfunction>) -> Draw {
    let mark = |d: &crate::scenario::Dysfunction| {
        let marked = |at_mm| Mark {
            at_mm,
            kind: Some(d.kind.to_owned()),
            severity: Some(d.severity),
        };
        places_mm(d).into_iter().map(marked).collect::<Vec<_>>()
    };
    Draw {
        right: Answer::Marks(hidden.iter().flat_map(mark).collect()),
        pointed: Vec::new(),
        hidden,
    }
}
