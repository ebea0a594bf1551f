//! Which of two places is stiffer? A choice of two.

use super::{Task, fewer_than, hidden, pair_of};
use crate::scenario::{Change, Exercise, ScenarioError};
use crate::training::random::Random;
use crate::training::trial::{Answer, Draw, Pointed, pointed_name};

/// Compares the stiffness of two places, one of which is changed (2AFC).
pub struct Compare;

impl Task for Compare {
    fn key(&self) -> &'static str {
        "compare"
    }

    fn title(&self) -> &'static str {
        "Compare stiffness"
    }

    fn about(&self) -> &'static str {
        "Two places are pointed at, one of them is changed: say which is stiffer (two alternatives, forced choice)"
    }

    fn prompt(&self, _: &Exercise) -> String {
        "Which is stiffer, A or B?".into()
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
        let pair = pair_of(&exercise.candidates, random)?;
        let changed = random.below(2);
        let stiffer = if change.factor() < 1.0 {
            1 - changed
        } else {
            changed
        };
        Ok(Draw {
            hidden: vec![hidden(exercise, pair[changed], Some(change), 2)?],
            pointed: vec![
                Pointed::new(0, pair[0].at_mm()),
                Pointed::new(1, pair[1].at_mm()),
            ],
            right: Answer::Stiffer(stiffer),
        })
    }

    fn choices(&self, _: &Exercise, pointed: &[Pointed]) -> Vec<Answer> {
        (0..pointed.len()).map(Answer::Stiffer).collect()
    }

    fn chance(&self, _: &Exercise) -> f64 {
        0.5
    }

    fn told(&self, draw: &Draw) -> String {
        match draw.right {
            Answer::Stiffer(i) => format!("{} was stiffer", pointed_name(i)),
            _ => String::new(),
        }
    }
}
