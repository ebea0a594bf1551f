//! How strong the next trial is, from the answers so far: one rule a file, all in one list.

mod constant;
mod psi;
#[cfg(test)]
mod tests;
mod up_down;

use super::level::Scale;
use super::random::Random;
use crate::scenario::Change;
use crate::scenario::exercise::{self, Step};

/// Every rule, by the names that [`exercise::RULES`] lets a file state.
pub fn all() -> &'static [&'static dyn Rule] {
    &[
        &up_down::ONE_UP_TWO_DOWN,
        &up_down::ONE_UP_THREE_DOWN,
        &up_down::ONE_UP_FOUR_DOWN,
        &up_down::ONE_UP_TWO_DOWN_EQUAL,
        &up_down::ONE_UP_THREE_DOWN_EQUAL,
        &up_down::ONE_UP_FOUR_DOWN_EQUAL,
        &up_down::WEIGHTED,
        &psi::Psi,
        &constant::Constant,
    ]
}

/// The rule called `key`.
pub fn by_key(key: &str) -> Option<&'static dyn Rule> {
    all().iter().copied().find(|rule| rule.key() == key)
}

/// A rule from answers to strengths.
pub trait Rule: Sync {
    /// Name in files and on the command line.
    fn key(&self) -> &'static str;

    /// Name for people.
    fn title(&self) -> &'static str;

    /// What it does and whose it is, in a line.
    fn about(&self) -> &'static str;

    /// The share of right answers at the level it goes to, for an observer who never lapses; `None` where it goes nowhere.
    fn target(&self, settings: &Settings) -> Option<f64>;

    /// At its start.
    fn start(&self, settings: &Settings) -> Box<dyn Staircase>;
}

/// What a rule is told. Levels are on [`Settings::scale`].
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The axis of the levels.
    pub scale: Scale,
    /// Level of the first trial.
    pub start: f64,
    /// Lowest level: the weakest change.
    pub least: f64,
    /// Highest level: the strongest change.
    pub most: f64,
    /// How far it goes up at a time; above 0.
    pub step: f64,
    /// Share of right answers by guessing, 0 … 1.
    pub chance: f64,
    /// Share of right answers that the weighted rule goes to, 0 … 1.
    pub target: f64,
    /// It is done after as many reversals; `None`: never by itself.
    pub reversals: Option<u32>,
    /// First reversals that the estimate leaves out.
    pub skipped_reversals: u32,
    /// Levels of constant stimuli.
    pub constant: Vec<f64>,
}

impl Settings {
    /// As a scenario states it, for changes to the side of `change` and answers of which `chance` are right by guessing.
    pub fn new(stated: &exercise::Staircase, change: Change, chance: f64) -> Self {
        let scale = Scale::new(stated.measure, stated.step, change);
        let (least, most) = (
            scale.level(stated.least_percent),
            scale.level(stated.most_percent),
        );
        let (Step::Percent(step) | Step::Decibel(step)) = stated.step;
        Self {
            scale,
            start: scale
                .level(stated.start_percent)
                .clamp(least, most.max(least)),
            least,
            most: most.max(least),
            step,
            chance,
            target: stated.target,
            reversals: stated.reversals,
            skipped_reversals: stated.skipped_reversals,
            constant: (stated.constant_percent.iter())
                .map(|&percent| scale.level(percent))
                .collect(),
        }
    }
}

/// A rule at work. It knows nothing but its settings and what it was answered, so that the same answers bring it to the same
/// state.
pub trait Staircase: Send {
    /// Level of the next trial. Chance is for rules that choose among levels.
    fn level(&mut self, random: &mut Random) -> f64;

    /// What was answered at a level.
    fn answered(&mut self, level: f64, right: bool);

    /// Whether it needs no more trials.
    fn is_done(&self) -> bool;

    /// Levels at which it turned, in order.
    fn reversals(&self) -> &[f64];

    /// The level it has come to; `None` while there is too little to say.
    fn estimate(&self) -> Option<Estimate>;
}

/// Where a staircase thinks the threshold is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Level.
    pub level: f64,
    /// Its standard error in units of the level; `None` where the rule cannot tell.
    pub standard_error: Option<f64>,
    /// Share of right answers there, for an observer who never lapses.
    pub target: f64,
}
