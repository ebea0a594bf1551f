//! What can be asked of whom palpates: one task a file, all in one list.

mod compare;
mod level;
mod locate;
mod same_different;
pub(super) mod search;
mod severity;

use super::random::Random;
use super::trial::{Answer, Draw, Pointed};
use crate::geom::Vec2;
use crate::scenario::exercise::Hides;
use crate::scenario::{
    Change, Dysfunction, Exercise, ScenarioError, Site, VertebralLevel, dysfunction,
};

/// Every task, by the names that [`TASKS`](crate::scenario::exercise::TASKS) lets a file state.
pub fn all() -> &'static [&'static dyn Task] {
    &[
        &locate::Locate,
        &same_different::SameDifferent,
        &compare::Compare,
        &level::Level,
        &severity::Severity,
        &search::Search,
    ]
}

/// The task called `key`.
pub fn by_key(key: &str) -> Option<&'static dyn Task> {
    all().iter().copied().find(|task| task.key() == key)
}

/// Something that is asked.
pub trait Task: Sync {
    /// Name in files.
    fn key(&self) -> &'static str;

    /// Name for people.
    fn title(&self) -> &'static str;

    /// What it trains, in a line.
    fn about(&self) -> &'static str;

    /// What the trainee reads; the same for all that a trial may hide.
    fn prompt(&self, exercise: &Exercise) -> String;

    /// Why `exercise` cannot be done, if so.
    fn fault(&self, exercise: &Exercise) -> Option<String> {
        let _ = exercise;
        None
    }

    /// Whether the strength of what is hidden makes it easier, so that a staircase has something to go by.
    fn has_strength(&self) -> bool {
        true
    }

    /// Draws a trial.
    ///
    /// # Errors
    /// What is to be hidden cannot be made.
    fn draw(
        &self,
        exercise: &Exercise,
        change: Change,
        random: &mut Random,
    ) -> Result<Draw, ScenarioError>;

    /// The answers to choose from; none where places are marked instead.
    fn choices(&self, exercise: &Exercise, pointed: &[Pointed]) -> Vec<Answer>;

    /// Whether `answer` answers it.
    fn allows(&self, exercise: &Exercise, pointed: &[Pointed], answer: &Answer) -> bool {
        self.choices(exercise, pointed).contains(answer)
    }

    /// Whether it is right.
    fn is_right(&self, exercise: &Exercise, draw: &Draw, answer: &Answer) -> bool {
        let _ = exercise;
        draw.right == *answer
    }

    /// Share of right answers by guessing.
    fn chance(&self, exercise: &Exercise) -> f64;

    /// What is told of the truth after the answer, as "It was at T5 right transverse process".
    fn told(&self, draw: &Draw) -> String;
}

/// A dysfunction of the exercise's kind at a site, changed by `change`; `severity` 0 to 3 where the task grades it.
fn hidden(
    exercise: &Exercise,
    site: Site,
    change: Option<Change>,
    severity: u8,
) -> Result<Dysfunction, ScenarioError> {
    let Hides::Drawn { kind, .. } = exercise.hides else {
        return Err(ScenarioError(
            "what the scenario states is hidden; nothing is drawn".into(),
        ));
    };
    let kind = dysfunction::named(kind)
        .ok_or_else(|| ScenarioError(format!("{kind:?} is no kind of dysfunction")))?;
    let default = kind.default_of(site, severity);
    // A kind that leaves the stiffness as it is has no strength to be changed.
    let is_felt = kind.strength(default.preset, severity).change.is_some();
    Ok(Dysfunction {
        change: change.filter(|_| is_felt),
        ..default
    })
}

/// One of the candidates, each as likely as the others.
fn one_of(candidates: &[Site], random: &mut Random) -> Result<Site, ScenarioError> {
    let chosen = candidates.get(random.below(candidates.len()));
    chosen
        .copied()
        .ok_or_else(|| ScenarioError("the exercise has no candidates".into()))
}

/// Two candidates to be compared: where there are any, mirrored sites, whose skin is alike but for what is hidden; else any
/// two. The first of them is as likely left as right.
fn pair_of(candidates: &[Site], random: &mut Random) -> Result<[Site; 2], ScenarioError> {
    let first = one_of(candidates, random)?;
    let mirrored = first.mirrored();
    if mirrored != first && candidates.contains(&mirrored) {
        return Ok([first, mirrored]);
    }
    let others: Vec<Site> = candidates.iter().copied().filter(|&s| s != first).collect();
    Ok([first, one_of(&others, random)?])
}

/// The candidates' levels from the neck down, each once.
fn levels_of(candidates: &[Site]) -> Vec<VertebralLevel> {
    let mut levels: Vec<_> = candidates.iter().map(|s| s.level).collect();
    levels.sort();
    levels.dedup();
    levels
}

/// The candidate nearest to a place.
fn nearest(candidates: &[Site], at_mm: Vec2) -> Option<Site> {
    let distance = |s: &Site| s.at_mm().distance_squared(at_mm);
    let by = |a: &&Site, b: &&Site| distance(a).total_cmp(&distance(b));
    candidates.iter().min_by(by).copied()
}

/// Why fewer candidates than `n` are too few.
fn fewer_than(n: usize, exercise: &Exercise) -> Option<String> {
    let found = exercise.candidates.len();
    (found < n).then(|| format!("{found} candidates; at least {n} are needed"))
}
