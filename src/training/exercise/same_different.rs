//! Do two places feel the same? In half of the trials one of them is changed.

use super::{Task, fewer_than, hidden, pair_of};
use crate::scenario::{Change, Exercise, ScenarioError};
use crate::training::random::Random;
use crate::training::trial::{Answer, Draw, Pointed};

/// Tells whether two places differ.
pub struct SameDifferent;

impl Task for SameDifferent {
    fn key(&self) -> &'static str {
        "same-different"
    }

    fn title(&self) -> &'static str {
        "Same or different"
    }

    fn about(&self) -> &'static str {
        "Two places are pointed at; in half of the trials one of them is changed: say whether they differ"
    }

    fn prompt(&self, _: &Exercise) -> String {
        "Do A and B feel the same, or different?".into()
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
        let same = random.below(2) == 0;
        // Drawn in either case, so that what is pointed at says nothing.
        let changed = pair[random.below(2)];
        Ok(Draw {
            hidden: if same {
                Vec::new()
            } else {
                vec![hidden(exercise, changed, Some(change), 2)?]
            },
            pointed: vec![
                Pointed::new(0, pair[0].at_mm()),
                Pointed::new(1, pair[1].at_mm()),
            ],
            right: Answer::Same(same),
        })
    }

    fn choices(&self, _: &Exercise, _: &[Pointed]) -> Vec<Answer> {
        vec![Answer::Same(true), Answer::Same(false)]
    }

    fn chance(&self, _: &Exercise) -> f64 {
        0.5
    }

    fn told(&self, draw: &Draw) -> String {
        match draw.site() {
            None => "They were the same".into(),
            Some(site) => format!("They were different: {site} was changed"),
        }
    }
}
