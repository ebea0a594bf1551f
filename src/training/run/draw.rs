//! Drawing a trial: what is hidden, how strong, under which stiffness of the whole back.

use super::{Current, Run, TrainingError};
use crate::scenario::exercise::Hides;
use crate::scenario::{self, Change, Dysfunction, Exercise, Scenario, ScenarioError, dysfunction};
use crate::training::exercise::{Task, search};
use crate::training::palpation::{Ground, Palpation, Tender};
use crate::training::random::Random;
use crate::training::shown::{Phase, Why};
use crate::training::trial::Ended;
use std::sync::Arc;

impl Run {
    /// Draws the trial after the settled ones, or finds that there is none.
    pub(super) fn draw_next(&mut self) -> Result<(), TrainingError> {
        let scored = self.n_scored();
        let practised = self.settled.len() as u32 - scored;
        let practice = scored == 0 && practised < self.exercise.practice;
        if scored >= self.exercise.trials {
            self.phase = Phase::Done(Why::AllDone);
            return Ok(());
        }
        if self.staircase.as_ref().is_some_and(|s| s.is_done()) {
            self.phase = Phase::Done(Why::Converged);
            return Ok(());
        }
        let number = if practice { practised } else { scored } + 1;
        let mut random = self.seed.of_trial(practice, number);
        let (level, change) = self.strength(practice, &mut random);
        let draw = match self.exercise.hides {
            Hides::Stated => search::all_of(self.hides.clone()),
            Hides::Drawn { .. } => self.task.draw(&self.exercise, change, &mut random)?,
        };
        let gain = gain(self.exercise.vary_stiffness_percent, &mut random);
        let all: Vec<Dysfunction> = (self.stated.iter().chain(&draw.hidden)).cloned().collect();
        let hidden_scenario = scaled(self.blind.with_dysfunctions(&all)?, gain)?;
        self.current = Current {
            practice,
            number,
            draw,
            level,
            gain,
            hidden_scenario: Arc::new(hidden_scenario),
            palpation: None,
            ended: Ended::Answered,
        };
        self.current.palpation = self.ground.as_ref().map(|g| self.palpation_on(g));
        (self.clock.search_s, self.clock.answer_s) = (0.0, 0.0);
        self.phase = Phase::Ready;
        Ok(())
    }

    /// Level and change of the next trial. Practice has the strength of the start.
    fn strength(&mut self, practice: bool, random: &mut Random) -> (Option<f64>, Change) {
        match (&mut self.staircase, &self.settings) {
            (Some(staircase), Some(settings)) => {
                let level = if practice {
                    settings.start
                } else {
                    staircase.level(random)
                };
                (Some(level), settings.scale.change(level))
            }
            _ => (None, change_of(&self.exercise)),
        }
    }

    pub(super) fn palpation_on(&self, ground: &Arc<Ground>) -> Palpation {
        let hidden = self.current.draw.hidden.iter().chain(&self.stated);
        let patches = hidden.filter_map(|d| d.patches().ok()).flatten();
        let tender = patches.filter_map(|patch| {
            patch.tender.map(|tender| Tender {
                at_mm: patch.spot.at_mm,
                radius_mm: patch.spot.half_axes_mm[0].max(patch.spot.half_axes_mm[1]),
                above_n: tender.above_n,
            })
        });
        Palpation::new(Arc::clone(ground), tender.collect())
    }
}

/// Why an exercise cannot be done, whatever its task.
pub(super) fn fault(exercise: &Exercise, task: &dyn Task, n_stated: usize) -> Option<String> {
    let stated = exercise.hides == Hides::Stated;
    if stated && task.key() != "search" {
        return Some("only \"search\" hides what the scenario states".into());
    }
    if stated && n_stated == 0 {
        return Some("the scenario states no [[dysfunction]] that could be hidden".into());
    }
    exercise.staircase.as_ref()?;
    if stated || !task.has_strength() {
        return Some("it has no strength that a staircase could change; leave it out".into());
    }
    let Hides::Drawn { kind, .. } = exercise.hides else {
        return None;
    };
    let made = dysfunction::named(kind)?;
    let site = *exercise.candidates.first()?;
    let default = made.default_of(site, dysfunction::DEFAULT_SEVERITY);
    let strength = made.strength(default.preset, dysfunction::DEFAULT_SEVERITY);
    let why = "leaves the stiffness as it is: no staircase can change it";
    strength.change.is_none().then(|| format!("{kind} {why}"))
}

/// The strength that is stated.
pub(super) fn change_of(exercise: &Exercise) -> Change {
    match exercise.hides {
        Hides::Drawn { change, .. } => change,
        Hides::Stated => Change::StiffnessPercent(0.0),
    }
}

/// Factor on all stiffness of a trial, even on a logarithmic scale.
fn gain(vary_percent: f64, random: &mut Random) -> f64 {
    let most = libm::log(1.0 + vary_percent.max(0.0) / 100.0);
    libm::exp(most * (2.0 * random.unit() - 1.0))
}

/// The scenario with all its keys of stiffness multiplied by `gain`. The tick knows nothing of it, and the source text says it.
fn scaled(scenario: Scenario, gain: f64) -> Result<Scenario, ScenarioError> {
    if gain == 1.0 {
        return Ok(scenario);
    }
    let mut keys = scenario.stiffness_keys.clone();
    for key in &mut keys {
        key.stiffness_n_per_mm *= gain;
    }
    let (fit, strokes) = (scenario.stiffness_fit, &scenario.strokes);
    let source = scenario::edit::with_stiffness(&scenario.source, &keys, fit, strokes)?;
    Scenario::parse(&source, "the trial's scenario", scenario.folder.as_deref())
}
