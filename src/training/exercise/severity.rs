//! How severe is it? Grading from 0 to 3.

use super::{Task, hidden, one_of};
use crate::scenario::{Change, Exercise, ScenarioError};
use crate::training::random::Random;
use crate::training::trial::{Answer, Draw, Pointed};

/// Grades what is at a place that is pointed at.
pub struct Severity;

/// Grades of severity: none, mild, moderate, severe.
const GRADES: u8 = 4;

impl Task for Severity {
    fn key(&self) -> &'static str {
        "severity"
    }

    fn title(&self) -> &'static str {
        "Grade severity"
    }

    fn about(&self) -> &'static str {
        "A place is pointed at: say how severe it is, from 0 for none to 3"
    }

    fn prompt(&self, _: &Exercise) -> String {
        "How severe is what is at A? 0 none, 1 mild, 2 moderate, 3 severe.".into()
    }

    /// The change that is stated is that of grade 3; the others are a third and two thirds of it, as parts of a percentage of
    /// the same measure.
    fn draw(
        &self,
        exercise: &Exercise,
        change: Change,
        random: &mut Random,
    ) -> Result<Draw, ScenarioError> {
        let site = one_of(&exercise.candidates, random)?;
        let grade = random.below(usize::from(GRADES)) as u8;
        let part = f64::from(grade) / f64::from(GRADES - 1);
        let change = match change {
            Change::CompliancePercent(p) => Change::CompliancePercent(p * part),
            Change::StiffnessPercent(p) => Change::StiffnessPercent(p * part),
        };
        Ok(Draw {
            hidden: match grade {
                0 => Vec::new(),
                _ => vec![hidden(exercise, site, Some(change), grade)?],
            },
            pointed: vec![Pointed::new(0, site.at_mm())],
            right: Answer::Severity(grade),
        })
    }

    fn choices(&self, _: &Exercise, _: &[Pointed]) -> Vec<Answer> {
        (0..GRADES).map(Answer::Severity).collect()
    }

    fn chance(&self, _: &Exercise) -> f64 {
        1.0 / f64::from(GRADES)
    }

    fn told(&self, draw: &Draw) -> String {
        format!("It was {}", draw.right)
    }
}
