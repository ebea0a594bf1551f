//! Where is it? One of m places is changed.

use super::{Task, fewer_than, hidden, nearest, one_of};
use crate::scenario::{Change, Exercise, ScenarioError};
use crate::training::random::Random;
use crate::training::trial::{Answer, Draw, Pointed};

/// Finds the one changed place among m candidates, as in the published trainer (Howell et al. 2008, m = 12).
pub struct Locate;

impl Task for Locate {
    fn key(&self) -> &'static str {
        "locate"
    }

    fn title(&self) -> &'static str {
        "Locate"
    }

    fn about(&self) -> &'static str {
        "One of the candidates is changed: find it. Chance is one in as many as there are"
    }

    fn prompt(&self, exercise: &Exercise) -> String {
        let n = exercise.candidates.len();
        format!("One of {n} places differs from the others. Where is it?")
    }

    fn fault(&self, exercise: &Exercise) -> Option<String> {
        fewer_than(2, exercise)
    }

    fn draw(
        &self,
        exercise: &Exercise,
        change: Change,
        random: &mut Random,
    ) -> Result<Draw, ScenarioError> {
        let site = one_of(&exercise.candidates, random)?;
        Ok(Draw {
            hidden: vec![hidden(exercise, site, Some(change), 2)?],
            pointed: Vec::new(),
            right: Answer::Site(site),
        })
    }

    fn choices(&self, exercise: &Exercise, _: &[Pointed]) -> Vec<Answer> {
        exercise
            .candidates
            .iter()
            .copied()
            .map(Answer::Site)
            .collect()
    }

    /// A candidate, or a place: then the nearest candidate is meant.
    fn allows(&self, exercise: &Exercise, _: &[Pointed], answer: &Answer) -> bool {
        match answer {
            Answer::Site(site) => exercise.candidates.contains(site),
            Answer::Here(at) => at.is_finite(),
            _ => false,
        }
    }

    fn is_right(&self, exercise: &Exercise, draw: &Draw, answer: &Answer) -> bool {
        match answer {
            Answer::Here(at) => {
                nearest(&exercise.candidates, *at).map(Answer::Site) == Some(draw.right.clone())
            }
            _ => draw.right == *answer,
        }
    }

    fn chance(&self, exercise: &Exercise) -> f64 {
        1.0 / exercise.candidates.len().max(1) as f64
    }

    fn told(&self, draw: &Draw) -> String {
        format!("It was at {}", draw.right)
    }
}
