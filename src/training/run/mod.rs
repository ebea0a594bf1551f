//! An exercise as it is done: trial after trial, with what may be shown kept apart from what is hidden.

mod draw;

use super::exercise::{self, Task, search};
use super::level::{compliance_percent, stiffness_percent};
use super::palpation::{Ground, Palpation};
use super::random::Seed;
use super::score;
use super::shown::{Choice, Phase, Shown, Told, Why};
use super::staircase::{self, Estimate, Settings, Staircase};
use super::trial::{Draw, Ended, Reply, TrialRecord};
use crate::geom::Vec2;
use crate::scenario::exercise::{Feedback, Hides, Measure};
use crate::scenario::{Change, Dysfunction, Exercise, Scenario, ScenarioError, dysfunction};
use crate::servo::TickRecord;
use draw::{change_of, fault};
use std::sync::Arc;

/// Why an exercise cannot be started or go on: one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct TrainingError(pub String);

impl From<ScenarioError> for TrainingError {
    fn from(e: ScenarioError) -> Self {
        Self(e.0)
    }
}

/// What the trainee does.
#[derive(Clone, Debug, PartialEq)]
pub enum Input {
    /// Starts the trial: from now on the hidden is felt.
    Start,
    /// Has felt enough; the answer follows.
    Enough,
    /// Answers.
    Answer(Reply),
    /// Feels it again after the answer, or no longer.
    FeelAgain(bool),
    /// Goes on to the next trial.
    Next,
    /// Stops the clock, or lets it go on.
    Pause(bool),
    /// Ends the exercise. The running trial is not scored.
    Abort,
}

/// Which scene the servo shall have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Felt {
    /// Without what is hidden.
    Blind,
    /// With it.
    Hidden,
}

/// How long things took, s.
#[derive(Clone, Copy, Debug, Default)]
struct Clock {
    /// The newest time told; none before the first.
    now_s: Option<f64>,
    /// In the scored part of the exercise.
    exercise_s: f64,
    search_s: f64,
    answer_s: f64,
}

/// The trial at hand.
struct Current {
    practice: bool,
    number: u32,
    draw: Draw,
    level: Option<f64>,
    gain: f64,
    hidden_scenario: Arc<Scenario>,
    palpation: Option<Palpation>,
    ended: Ended,
}

/// An exercise as it is done. A state machine without a clock: time is told to it, in seconds from any start.
///
/// What may be shown is in [`Run::shown`]; it holds nothing of the truth before the answer. What is hidden leaves it by three
/// doors only: [`Run::hidden_scenario`], which is for the servo; [`Shown::feedback`], after the answer; and the records of
/// settled trials.
pub struct Run {
    exercise: Exercise,
    task: &'static dyn Task,
    blind: Arc<Scenario>,
    /// Dysfunctions that are felt and shown in every trial.
    stated: Vec<Dysfunction>,
    /// Those that the scenario states and the exercise hides.
    hides: Vec<Dysfunction>,
    seed: Seed,
    staircase: Option<Box<dyn Staircase>>,
    settings: Option<Settings>,
    settled: Vec<TrialRecord>,
    ground: Option<Arc<Ground>>,
    current: Current,
    phase: Phase,
    paused: bool,
    feeling_again: bool,
    clock: Clock,
}

impl std::fmt::Debug for Run {
    /// Without what is hidden.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Run")
            .field("task", &self.task.key())
            .field("settled", &self.settled.len())
            .field("phase", &self.phase)
            .finish_non_exhaustive()
    }
}

impl Run {
    /// The exercise of `scenario` before its first trial.
    ///
    /// # Errors
    /// The scenario has no exercise, or one that cannot be done.
    pub fn new(scenario: &Scenario, seed: Seed) -> Result<Self, TrainingError> {
        Self::resume(scenario, seed, Vec::new())
    }

    /// The exercise after some trials, as a journal tells them: the staircase is brought to where it was by their answers.
    ///
    /// # Errors
    /// As [`Run::new`].
    pub fn resume(
        scenario: &Scenario,
        seed: Seed,
        settled: Vec<TrialRecord>,
    ) -> Result<Self, TrainingError> {
        let exercise = scenario.exercise.clone().ok_or_else(|| {
            TrainingError("the scenario has no [exercise]: there is nothing to train".into())
        })?;
        let task = exercise::by_key(exercise.task)
            .ok_or_else(|| TrainingError(format!("{:?} is no task", exercise.task)))?;
        if let Some(fault) = task
            .fault(&exercise)
            .or_else(|| fault(&exercise, task, scenario.dysfunctions.len()))
        {
            let what = format!("[exercise] task = {:?}: {fault}", exercise.task);
            return Err(TrainingError(what));
        }
        let (stated, hides) = match exercise.hides {
            Hides::Drawn { .. } => (scenario.dysfunctions.clone(), Vec::new()),
            Hides::Stated => (Vec::new(), scenario.dysfunctions.clone()),
        };
        let blind = if hides.is_empty() {
            Arc::new(scenario.clone())
        } else {
            Arc::new(scenario.with_dysfunctions(&stated)?)
        };
        let change = change_of(&exercise);
        let settings = exercise
            .staircase
            .as_ref()
            .map(|s| Settings::new(s, change, task.chance(&exercise)));
        let staircase = match (&exercise.staircase, &settings) {
            (Some(stated), Some(settings)) => {
                let rule = staircase::by_key(stated.rule)
                    .ok_or_else(|| TrainingError(format!("{:?} is no staircase", stated.rule)))?;
                Some(rule.start(settings))
            }
            _ => None,
        };
        // The first trial is drawn below; this one only holds its place.
        let current = Current {
            practice: false,
            number: 0,
            draw: search::all_of(Vec::new()),
            level: None,
            gain: 1.0,
            hidden_scenario: Arc::clone(&blind),
            palpation: None,
            ended: Ended::Answered,
        };
        let mut run = Self {
            exercise,
            task,
            blind,
            stated,
            hides,
            seed,
            staircase,
            settings,
            settled: Vec::with_capacity(settled.len()),
            ground: None,
            current,
            phase: Phase::Ready,
            paused: false,
            feeling_again: false,
            clock: Clock::default(),
        };
        for record in settled {
            run.clock.exercise_s += f64::from(u8::from(!record.practice))
                * (record.search_s + record.answer_s).max(0.0);
            run.settle(record);
        }
        run.draw_next()?;
        Ok(run)
    }

    /// What is asked.
    pub fn exercise(&self) -> &Exercise {
        &self.exercise
    }

    /// The task.
    pub fn task(&self) -> &'static dyn Task {
        self.task
    }

    /// The scenario without what is hidden: all that may be shown of it before the answer.
    pub fn blind_scenario(&self) -> &Arc<Scenario> {
        &self.blind
    }

    /// The scenario with what the running trial hides. For the servo only: its source text tells the truth.
    pub fn hidden_scenario(&self) -> &Arc<Scenario> {
        &self.current.hidden_scenario
    }

    /// Which of the two the servo shall have now.
    pub fn felt(&self) -> Felt {
        let feels = match self.phase {
            Phase::Palpating => true,
            Phase::Feedback => self.feeling_again,
            Phase::Ready | Phase::Answering | Phase::Done(_) => false,
        };
        if feels && !self.paused {
            Felt::Hidden
        } else {
            Felt::Blind
        }
    }

    /// Where the candidates are on the map plane, mm, in their order.
    pub fn candidates_mm(&self) -> Vec<Vec2> {
        self.exercise.candidates.iter().map(|s| s.at_mm()).collect()
    }

    /// The skin that palpation is measured on; without it nothing of it is told. From the next trial on.
    pub fn set_ground(&mut self, ground: Ground) {
        let ground = Arc::new(ground);
        if self.phase == Phase::Ready {
            self.current.palpation = Some(self.palpation_on(&ground));
        }
        self.ground = Some(ground);
    }

    /// Settled trials in order, practice among them.
    pub fn settled(&self) -> &[TrialRecord] {
        &self.settled
    }

    /// Scored trials settled so far.
    pub fn n_scored(&self) -> u32 {
        self.settled.iter().filter(|t| !t.practice).count() as u32
    }

    /// Where the staircase thinks the threshold is, and its scale.
    pub fn estimate(&self) -> Option<(Estimate, &Settings)> {
        self.staircase
            .as_ref()
            .and_then(|s| s.estimate())
            .zip(self.settings.as_ref())
    }

    /// Levels at which the staircase turned.
    pub fn reversals(&self) -> &[f64] {
        self.staircase.as_ref().map_or(&[], |s| s.reversals())
    }

    /// Takes in a tick of the servo: it counts while the trainee palpates.
    pub fn feel(&mut self, tick: &TickRecord, dt_s: f64) {
        if self.phase == Phase::Palpating
            && !self.paused
            && let Some(palpation) = &mut self.current.palpation
        {
            palpation.add(tick, dt_s);
        }
    }

    /// Lets time go on to `now_s` and heeds the limits. Time that goes back, or is not a number, stands still.
    pub fn advance(&mut self, now_s: f64) {
        let elapsed_s = match self.clock.now_s {
            Some(before) if now_s > before => now_s - before,
            Some(_) => return,
            None => 0.0,
        };
        if !now_s.is_finite() {
            return;
        }
        self.clock.now_s = Some(now_s);
        if self.paused || matches!(self.phase, Phase::Done(_)) {
            return;
        }
        let is_scored = !self.current.practice && self.phase != Phase::Ready;
        if is_scored {
            self.clock.exercise_s += elapsed_s;
        }
        match self.phase {
            Phase::Palpating => {
                self.clock.search_s += elapsed_s;
                if let Some(limit_s) = self.exercise.trial_limit_s
                    && self.clock.search_s >= limit_s
                {
                    self.clock.search_s = limit_s;
                    self.current.ended = Ended::OutOfTime;
                    self.phase = Phase::Answering;
                }
            }
            Phase::Answering => self.clock.answer_s += elapsed_s,
            _ => {}
        }
        let is_over = |limit_s| self.clock.exercise_s >= limit_s;
        if self.exercise.limit_s.is_some_and(is_over) {
            self.phase = Phase::Done(Why::OutOfTime);
        }
    }

    /// Takes in what the trainee does at `now_s`. An answer settles the trial and gives back its record.
    ///
    /// # Errors
    /// It cannot be done now, with a line that says why; nothing has changed then but the time.
    pub fn take(
        &mut self,
        input: Input,
        now_s: f64,
    ) -> Result<Option<&TrialRecord>, TrainingError> {
        self.advance(now_s);
        let refused = |why: &str| Err(TrainingError(why.to_owned()));
        if matches!(self.phase, Phase::Done(_)) {
            return refused("the exercise is over");
        }
        if self.paused && !matches!(input, Input::Pause(_) | Input::Abort) {
            return refused("the exercise is paused");
        }
        match (input, self.phase) {
            (Input::Pause(pause), _) => self.paused = pause,
            (Input::Abort, _) => self.phase = Phase::Done(Why::Aborted),
            (Input::Start, Phase::Ready) => self.phase = Phase::Palpating,
            (Input::Enough, Phase::Palpating) => self.phase = Phase::Answering,
            (Input::Answer(reply), Phase::Palpating | Phase::Answering) => {
                self.check(&reply)?;
                let record = self.record(&reply);
                self.settle(record);
                self.phase = Phase::Feedback;
                self.feeling_again = false;
                return Ok(self.settled.last());
            }
            (Input::FeelAgain(again), Phase::Feedback)
                if self.exercise.feedback == Feedback::Truth =>
            {
                self.feeling_again = again;
            }
            (Input::Next, Phase::Feedback) => {
                self.feeling_again = false;
                self.draw_next()?;
            }
            (Input::Start, _) => return refused("a trial is running"),
            (Input::Enough, _) => return refused("no trial is being palpated"),
            (Input::Answer(_), _) => return refused("no trial waits for an answer"),
            (Input::FeelAgain(_), _) => return refused("there is nothing to feel again"),
            (Input::Next, _) => return refused("the trial has not been answered"),
        }
        Ok(None)
    }

    /// All that may be shown now.
    pub fn shown(&self) -> Shown {
        let (exercise, current) = (&self.exercise, &self.current);
        let scored = self.settled.iter().filter(|t| !t.practice);
        let left = |limit: Option<f64>, gone: f64| limit.map(|limit| (limit - gone).max(0.0));
        let pointed = current.draw.pointed.clone();
        let choices = self.task.choices(exercise, &pointed);
        Shown {
            phase: self.phase,
            paused: self.paused,
            practice: current.practice,
            trial: current.number,
            of: if current.practice {
                exercise.practice
            } else {
                exercise.trials
            },
            title: self.task.title(),
            prompt: self.task.prompt(exercise),
            candidates: exercise.candidates.clone(),
            choices: choices.into_iter().map(Choice::new).collect(),
            pointed,
            asks_confidence: exercise.asks_confidence,
            asks_kind: exercise.asks_kind,
            asks_severity: exercise.asks_severity,
            trial_left_s: left(exercise.trial_limit_s, self.clock.search_s),
            exercise_left_s: left(exercise.limit_s, self.clock.exercise_s),
            right_so_far: (exercise.feedback != Feedback::None).then(|| {
                (
                    scored.clone().filter(|t| t.right).count() as u32,
                    scored.count() as u32,
                )
            }),
            feedback: (self.phase == Phase::Feedback)
                .then(|| self.told())
                .flatten(),
        }
    }

    fn told(&self) -> Option<Told> {
        let record = self.settled.last()?;
        let draw = &self.current.draw;
        let truth = self.exercise.feedback == Feedback::Truth;
        (self.exercise.feedback != Feedback::None).then(|| Told {
            right: record.right,
            text: match (record.right, truth) {
                (true, _) => "Correct.".to_owned(),
                (false, false) => "Not correct.".to_owned(),
                (false, true) => format!("Not correct. {}.", self.task.told(draw)),
            },
            truth: if truth {
                draw.hidden.clone()
            } else {
                Vec::new()
            },
            truth_mm: if truth {
                draw.hidden_at_mm().map(|(_, at)| at).collect()
            } else {
                Vec::new()
            },
            can_feel_again: truth,
            feeling_again: self.feeling_again,
        })
    }

    fn check(&self, reply: &Reply) -> Result<(), TrainingError> {
        let pointed = &self.current.draw.pointed;
        if !self.task.allows(&self.exercise, pointed, &reply.answer) {
            let what = format!("\"{}\" does not answer what is asked", reply.answer);
            return Err(TrainingError(what));
        }
        if reply.confidence_percent.is_some_and(|c| c > 100) {
            return Err(TrainingError("confidence goes from 0 to 100 %".into()));
        }
        if self.exercise.asks_confidence && reply.confidence_percent.is_none() {
            let what = "say how sure you are, 0 to 100 %, with the answer";
            return Err(TrainingError(what.into()));
        }
        if reply.severity.is_some_and(|s| s > dysfunction::MOST_SEVERE) {
            return Err(TrainingError("severity goes from 0 to 3".into()));
        }
        Ok(())
    }

    fn record(&self, reply: &Reply) -> TrialRecord {
        let current = &self.current;
        let factor = (current.draw.hidden.first())
            .and_then(|d| d.strength().change)
            .map(Change::factor);
        let given = self.given();
        TrialRecord {
            trial: current.number,
            practice: current.practice,
            task: self.task.key().to_owned(),
            level: current.level,
            strength_percent: given.map(|g| g.0),
            measure: given.map(|g| g.1.name().to_owned()),
            stiffness_percent: factor.map(stiffness_percent),
            compliance_percent: factor.map(compliance_percent),
            stiffness_gain: current.gain,
            chance: self.task.chance(&self.exercise),
            pointed: (current.draw.pointed.iter())
                .map(|p| format!("{} ({:.1}, {:.1}) mm", p.name, p.at_mm.x, p.at_mm.y))
                .collect(),
            truth: current.draw.right.to_string(),
            answer: reply.answer.to_string(),
            right: (self.task).is_right(&self.exercise, &current.draw, &reply.answer),
            ended: current.ended,
            confidence_percent: reply.confidence_percent,
            search_s: self.clock.search_s,
            answer_s: self.clock.answer_s,
            errors: score::errors(&self.exercise, &current.draw, reply),
            palpation: (current.palpation.as_ref())
                .map(Palpation::facts)
                .unwrap_or_default(),
            settled_utc: String::new(),
        }
    }

    /// Size of the change that the trial is given, and of what it is.
    fn given(&self) -> Option<(f64, Measure)> {
        match (self.current.level, &self.settings, &self.exercise.hides) {
            _ if !self.task.has_strength() => None,
            (Some(level), Some(settings), _) => {
                Some((settings.scale.percent(level), settings.scale.measure))
            }
            (_, _, Hides::Drawn { change, .. }) => Some(match change {
                Change::CompliancePercent(p) => (p.abs(), Measure::Compliance),
                Change::StiffnessPercent(p) => (p.abs(), Measure::Stiffness),
            }),
            (_, _, Hides::Stated) => None,
        }
    }

    /// Notes when the last settled trial was settled, and gives it back.
    pub(super) fn stamp_last(&mut self, utc: String) -> Option<TrialRecord> {
        let last = self.settled.last_mut()?;
        last.settled_utc = utc;
        Some(last.clone())
    }

    /// Counts a settled trial in; the staircase hears of it.
    fn settle(&mut self, record: TrialRecord) {
        if let (Some(staircase), Some(level), false) =
            (&mut self.staircase, record.level, record.practice)
        {
            staircase.answered(level, record.right);
        }
        self.settled.push(record);
    }
}

#[cfg(test)]
mod tests;
