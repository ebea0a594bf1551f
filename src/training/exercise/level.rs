//! Which level is this? Counting vertebrae under the finger.

use super::{Task, levels_of, one_of};
use crate::scenario::{Change, Exercise, ScenarioError};
use crate::training::random::Random;
use crate::training::trial::{Answer, Draw, Pointed};

/// Names the level of a place; nothing is hidden but its name.
pub struct Level;

impl Task for Level {
    fn key(&self) -> &'static str {
        "level"
    }

    fn title(&self) -> &'static str {
        "Count levels"
    }

    fn about(&self) -> &'static str {
        "A place is pointed at: count the vertebrae and say which level it is at"
    }

    fn prompt(&self, _: &Exercise) -> String {
        "At which level is A?".into()
    }

    fn fault(&self, exercise: &Exercise) -> Option<String> {
        let n = levels_of(&exercise.candidates).len();
        (n < 2).then(|| format!("candidates at {n} level; at least 2 levels are needed"))
    }

    fn has_strength(&self) -> bool {
        false
    }

    /// Each level is as likely as the others, however many candidates it has.
    fn draw(
        &self,
        exercise: &Exercise,
        _: Change,
        random: &mut Random,
    ) -> Result<Draw, ScenarioError> {
        let levels = levels_of(&exercise.candidates);
        let level = levels.get(random.below(levels.len())).copied();
        let at_level: Vec<_> = exercise
            .candidates
            .iter()
            .copied()
            .filter(|s| Some(s.level) == level)
            .collect();
        let site = one_of(&at_level, random)?;
        Ok(Draw {
            hidden: Vec::new(),
            pointed: vec![Pointed::new(0, site.at_mm())],
            right: Answer::Level(site.level),
        })
    }

    fn choices(&self, exercise: &Exercise, _: &[Pointed]) -> Vec<Answer> {
        levels_of(&exercise.candidates)
            .into_iter()
            .map(Answer::Level)
            .collect()
    }

    fn chance(&self, exercise: &Exercise) -> f64 {
        1.0 / levels_of(&exercise.candidates).len().max(1) as f64
    }

    fn told(&self, draw: &Draw) -> String {
        format!("A was at {}", draw.right)
    }
}
