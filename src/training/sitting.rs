//! An exercise with its journal: no settled trial is told before it is written.

use super::journal::{self, Changes, CutOff, FORMAT, Header, Journal, JournalError};
use super::palpation::Ground;
use super::random::Seed;
use super::run::{Input, Run, TrainingError};
use super::shown::Phase;
use super::trial::TrialRecord;
use crate::scenario::Scenario;
use crate::scenario::exercise::{self, Hides};
use crate::servo::TickRecord;
use crate::session::{build_id, utc_now};
use std::path::Path;

/// Who begins an exercise, and with what.
#[derive(Clone, Debug)]
pub struct Begun {
    /// The scenario as the user named it: a file or an example.
    pub scenario: String,
    /// Who trains, by a pseudonym of letters, digits, `-`, `_` and `.`.
    pub participant: Option<String>,
    /// What is changed of the exercise.
    pub changes: Changes,
    /// Where chance starts; `None`: where the scenario says, or else nobody knows.
    pub seed: Option<u64>,
    /// The simulated observer, if one trains.
    pub observer: Option<String>,
}

/// An exercise as it is done and written.
#[derive(Debug)]
pub struct Sitting {
    run: Run,
    journal: Journal,
    header: Header,
    ended: bool,
}

/// Longest pseudonym.
const LONGEST_NAME: usize = 40;

impl Sitting {
    /// Begins the exercise of `scenario`; its journal lies in `folder`.
    ///
    /// # Errors
    /// The exercise cannot be done, the participant has no allowed name, or the journal cannot be made.
    pub fn begin(folder: &Path, scenario: &Scenario, begun: &Begun) -> Result<Self, TrainingError> {
        if let Some(name) = &begun.participant {
            pseudonym(name)?;
        }
        let scenario = changed(scenario, &begun.changes)?;
        let stated = scenario.exercise.as_ref().and_then(|e| e.seed);
        let seed = begun.seed.or(stated);
        let run = Run::new(&scenario, seed.map_or_else(Seed::fresh, Seed::Stated))?;
        let header = Header {
            format: FORMAT,
            program: build_id(),
            scenario: begun.scenario.clone(),
            blind_toml: run.blind_scenario().source.clone(),
            changes: begun.changes.clone(),
            participant: begun.participant.clone(),
            seed,
            observer: begun.observer.clone(),
            started_utc: utc_now(),
        };
        Ok(Self {
            run,
            journal: Journal::create(folder, &header)?,
            header,
            ended: false,
        })
    }

    /// Goes on with the exercise in `folder` at the trial after its last settled one. `scenario` gives the scenario that its
    /// header names.
    ///
    /// # Errors
    /// The journal cannot be read, the exercise has ended, or the scenario is not the one it was begun with.
    pub fn resume(
        folder: &Path,
        scenario: impl FnOnce(&Header) -> Result<Scenario, String>,
    ) -> Result<(Self, Option<CutOff>), TrainingError> {
        let (journal, read) = Journal::resume(folder)?;
        let header = read.header;
        if let Some(why) = read.ended {
            let what = format!("{}: the exercise has ended: {why}", folder.display());
            return Err(TrainingError(what));
        }
        let scenario = match scenario(&header) {
            Ok(scenario) => scenario,
            // What is drawn needs nothing but what the journal holds.
            Err(why) => Scenario::parse(&header.blind_toml, "the journal's scenario", None)
                .ok()
                .filter(|s| {
                    s.exercise
                        .as_ref()
                        .is_some_and(|e| e.hides != Hides::Stated)
                })
                .ok_or(TrainingError(why))?,
        };
        let scenario = changed(&scenario, &header.changes)?;
        let seed = header.seed.map_or_else(Seed::fresh, Seed::Stated);
        let run = Run::resume(&scenario, seed, read.trials)?;
        if run.blind_scenario().source != header.blind_toml {
            return Err(TrainingError(format!(
                "{}: the scenario has changed since the exercise was begun; put it back, or begin anew in another folder",
                header.scenario
            )));
        }
        let sitting = Self {
            run,
            journal,
            header,
            ended: false,
        };
        Ok((sitting, read.cut_off))
    }

    /// The exercise as it is done.
    pub fn run(&self) -> &Run {
        &self.run
    }

    /// What its journal says of it.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// [`Run::set_ground`].
    pub fn set_ground(&mut self, ground: Ground) {
        self.run.set_ground(ground);
    }

    /// [`Run::feel`].
    pub fn feel(&mut self, tick: &TickRecord, dt_s: f64) {
        self.run.feel(tick, dt_s);
    }

    /// [`Run::advance`].
    ///
    /// # Errors
    /// The journal cannot be written.
    pub fn advance(&mut self, now_s: f64) -> Result<(), TrainingError> {
        self.run.advance(now_s);
        self.end()
    }

    /// [`Run::take`]; a settled trial is on the disk when this returns.
    ///
    /// # Errors
    /// As [`Run::take`]; the journal cannot be written.
    pub fn take(&mut self, input: Input, now_s: f64) -> Result<Option<TrialRecord>, TrainingError> {
        let settled = self.run.take(input, now_s)?.is_some();
        let mut record = None;
        if settled {
            let written = self.run.stamp_last(utc_now());
            if let Some(trial) = &written {
                self.journal.settle(trial)?;
            }
            record = written;
        }
        self.end()?;
        Ok(record)
    }

    /// Writes once how it ended. Time that is over, or a break-off, leaves trials to be done another day.
    fn end(&mut self) -> Result<(), TrainingError> {
        use super::shown::Why::{AllDone, Converged};
        if let Phase::Done(why @ (AllDone | Converged)) = self.run.shown().phase
            && !self.ended
        {
            self.journal.end(why.words())?;
            self.ended = true;
        }
        Ok(())
    }
}

impl From<JournalError> for TrainingError {
    fn from(e: JournalError) -> Self {
        Self(e.to_string())
    }
}

/// Whether a name may stand for a participant.
///
/// # Errors
/// It may not; says what may.
pub fn pseudonym(name: &str) -> Result<(), TrainingError> {
    let allowed = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let n = name.chars().count();
    if (1..=LONGEST_NAME).contains(&n) && name.chars().all(allowed) && !name.starts_with('.') {
        return Ok(());
    }
    let what = "1 to 40 letters, digits, -, _ and . are allowed, as in P07: a pseudonym, no name";
    Err(TrainingError(format!("participant {name:?}: {what}")))
}

/// The scenario with a changed exercise.
fn changed(scenario: &Scenario, changes: &Changes) -> Result<Scenario, TrainingError> {
    let mut scenario = scenario.clone();
    let Some(exercise) = &mut scenario.exercise else {
        return Ok(scenario);
    };
    if let Some(trials) = changes.trials {
        if !exercise::TRIALS.contains(&i64::from(trials)) {
            let (least, most) = (exercise::TRIALS.start(), exercise::TRIALS.end());
            let what = format!("{trials} trials; {least} to {most} are allowed");
            return Err(TrainingError(what));
        }
        exercise.trials = trials;
    }
    if let Some(key) = &changes.staircase {
        let Some(rule) = exercise::RULES.iter().find(|rule| *rule == key) else {
            let allowed = exercise::RULES.join(", ");
            return Err(TrainingError(format!(
                "staircase {key:?}; allowed are {allowed}"
            )));
        };
        let stated = exercise.staircase.take().unwrap_or_default();
        exercise.staircase = Some(exercise::Staircase { rule, ..stated });
    }
    Ok(scenario)
}

/// The journals below a folder: its own, and those of the folders in it, in the order of their names.
///
/// # Errors
/// There is none, or one cannot be read.
pub fn journals(folder: &Path) -> Result<Vec<journal::Read>, TrainingError> {
    if folder.join(journal::FILE).exists() {
        return Ok(vec![journal::read(folder)?]);
    }
    let entries = std::fs::read_dir(folder);
    let entries = entries.map_err(|e| TrainingError(format!("{}: {e}", folder.display())))?;
    let mut folders: Vec<_> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
    folders.sort();
    let found: Vec<_> = folders
        .iter()
        .filter(|f| f.join(journal::FILE).exists())
        .map(|f| Ok(journal::read(f)?))
        .collect::<Result<_, TrainingError>>()?;
    if found.is_empty() {
        let what = "holds no journal of an exercise, nor do the folders in it";
        return Err(TrainingError(format!("{} {what}", folder.display())));
    }
    Ok(found)
}
