//! An exercise as the bench runs it: which scene the servo has, what of it may be seen, what is recorded and kept.
//!
//! The scene that a trial hides is built beside the one that is shown, and goes to the servo only. Each trial is a recording of
//! its own, sealed until it is answered; what is felt between trials is in none of them.

use super::builder::beside;
use super::job::Job;
use super::live::Live;
use super::recording::{self, Recordings, Tape};
use super::{Bench, Wake};
use crate::app::messages::Level;
use crate::app::state::{BuildStatus, ExerciseView, View};
use crate::scenario::{BuildError, Scenario, Scene, Use};
use crate::servo::{FingerRecord, MAX_FINGERS, TickRecord};
use crate::session::{self, Header};
use crate::training::analysis::Options;
use crate::training::journal::{self, Changes, Header as JournalHeader};
use crate::training::sheet::{self, Done};
use crate::training::sitting::{Begun, Sitting};
use crate::training::trial::places_mm;
use crate::training::{Felt, Ground, Input, Phase, Run, Seed};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// What somebody wants of an exercise.
#[derive(Clone, Debug, PartialEq)]
pub enum Wish {
    /// Begin the exercise of the open scene.
    Begin {
        /// Pseudonym of the trainee; may be empty.
        participant: String,
    },
    /// Go on with one that was broken off, in this folder.
    Resume(PathBuf),
    /// Something in the exercise that runs.
    Do(Input),
    /// Write the score sheet beside the answers.
    Sheet,
    /// Put the exercise away.
    Close,
}

/// Which scene the servo has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// The one that is shown.
    Blind,
    /// The hidden one is on its way; the servo had as many scenes before.
    Arriving(u64),
    /// The hidden one.
    Hidden,
    /// The hidden one, until the recorder has what was felt in it.
    Leaving,
}

/// The file of a trial.
struct TrialTape {
    /// What it says of itself once its trial is answered.
    truth: Header,
    answered: bool,
    /// What is felt now does not belong into it.
    held: bool,
}

/// An exercise under way.
pub struct Exercising {
    sitting: Sitting,
    /// Where answers and recordings are kept.
    folder: PathBuf,
    started: Instant,
    blind: Arc<Scene>,
    /// The scene of the trial at hand, once it is built.
    hidden: Option<Arc<Scene>>,
    build: Option<Job<Result<Scene, BuildError>>>,
    stage: Stage,
    tape: Option<TrialTape>,
    /// Ticks of a tick number that is not complete yet.
    pending: TickRecord,
    /// Seconds told to the window last: more than a frame a second is not worth it for a clock.
    shown_s: u64,
}

impl Exercising {
    fn run(&self) -> &Run {
        self.sitting.run()
    }

    fn now_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Whether something is hidden at the moment.
    fn hides(&self) -> bool {
        !matches!(self.run().shown().phase, Phase::Done(_))
    }

    /// Whether the truth of the trial was told, so that its scene may be seen by everyone.
    fn is_told(&self) -> bool {
        let told = self.run().shown().feedback;
        told.is_some_and(|told| !told.truth.is_empty())
    }

    /// Whether the next trial can start.
    fn is_prepared(&self) -> bool {
        self.hidden.is_some() && self.stage == Stage::Blind && self.tape.is_none()
    }

    /// For the window, without what its reader may not know.
    fn view(&self, sees_truth: bool) -> ExerciseView {
        let shown = self.run().shown();
        let hidden = self.hidden.as_ref().filter(|_| sees_truth);
        let stated = &self.blind.scenario.dysfunctions;
        let truth: Option<Vec<_>> = hidden.map(|scene| {
            let all = scene.scenario.dysfunctions.iter();
            all.filter(|d| !stated.contains(d)).collect()
        });
        ExerciseView {
            prepared: self.is_prepared(),
            truth_mm: truth.iter().flatten().flat_map(|d| places_mm(d)).collect(),
            truth: truth.map(|all| all.into_iter().map(ToString::to_string).collect()),
            threshold: sees_truth.then(|| self.threshold()).flatten(),
            settled: if sees_truth || matches!(shown.phase, Phase::Done(_)) {
                self.run().settled().to_vec()
            } else {
                Vec::new()
            },
            folder: self.folder.clone(),
            shown,
        }
    }

    /// Where the staircase thinks the threshold is, in words.
    fn threshold(&self) -> Option<String> {
        let (estimate, settings) = self.run().estimate()?;
        let words = settings.scale.words(estimate.level);
        let error = match estimate.standard_error {
            Some(error) => {
                let percent = |level| settings.scale.percent(level);
                let (low, high) = (
                    percent(estimate.level - error),
                    percent(estimate.level + error),
                );
                format!(" ({low:.1} to {high:.1})")
            }
            None => String::new(),
        };
        Some(format!(
            "{words}{error}, where {:.1} % are right",
            100.0 * estimate.target
        ))
    }

    /// Starts to build the scene of the trial at hand, unless it is there.
    fn prepare(&mut self, purpose: Use, wake: &Wake) -> std::io::Result<()> {
        if self.hidden.is_some() || self.build.is_some() || self.run().shown().phase != Phase::Ready
        {
            return Ok(());
        }
        let (blind, scenario) = (
            Arc::clone(&self.blind),
            Arc::clone(self.run().hidden_scenario()),
        );
        let work = move |_: super::job::Progress<'_>| beside(&blind, scenario, purpose);
        self.build = Some(Job::start(
            "trial",
            BuildStatus::default(),
            wake.clone(),
            work,
        )?);
        Ok(())
    }

    /// Takes in what was felt since the last look.
    fn feel(&mut self, records: &[FingerRecord], dt_s: f64) {
        for record in records {
            let n = self.pending.n_fingers;
            if n > 0 && self.pending.fingers[0].tick != record.tick {
                self.sitting.feel(&self.pending, dt_s);
                self.pending.n_fingers = 0;
            }
            let n = self.pending.n_fingers;
            if n < MAX_FINGERS {
                self.pending.fingers[n] = *record;
                self.pending.n_fingers += 1;
            }
        }
    }

    /// Brings the servo to the scene it shall have, and the recorder after it. Answers whether anything changed.
    fn direct(&mut self, live: &mut Live, recordings: &mut Recordings) -> Result<bool, String> {
        let wanted = self.run().felt();
        let recorder = live.recorder().clone();
        let before = (self.stage, self.tape.is_some());
        match (self.stage, wanted) {
            (Stage::Blind, Felt::Hidden) => {
                if let Some(hidden) = &self.hidden {
                    self.stage = Stage::Arriving(live.snapshot().scene_generation);
                    live.set_scene(hidden);
                }
            }
            (Stage::Arriving(before), _) if live.snapshot().scene_generation > before => {
                self.stage = Stage::Hidden;
            }
            (Stage::Hidden, Felt::Hidden) if !recordings.is_busy() => {
                self.record(live, recordings)?;
            }
            (Stage::Hidden, Felt::Blind) => match &mut self.tape {
                Some(tape) if !tape.held => {
                    if !recordings.is_busy() {
                        let hold = Tape::Hold(true);
                        recordings.wind(recorder.clone(), hold).map_err(told)?;
                        tape.held = true;
                        self.stage = Stage::Leaving;
                    }
                }
                _ => self.leave(live),
            },
            (Stage::Leaving, _) if !recordings.is_busy() => self.leave(live),
            _ => {}
        }
        let over = self.tape.as_ref().is_some_and(|tape| {
            let unanswered = matches!(self.run().shown().phase, Phase::Ready | Phase::Done(_));
            tape.held && (tape.answered || unanswered)
        });
        if over
            && !recordings.is_busy()
            && let Some(tape) = self.tape.take()
        {
            let truth = tape.answered.then(|| Box::new(tape.truth));
            recordings
                .wind(recorder, Tape::Finish(truth))
                .map_err(told)?;
        }
        Ok(before != (self.stage, self.tape.is_some()))
    }

    fn leave(&mut self, live: &mut Live) {
        live.set_scene(&self.blind);
        self.stage = Stage::Blind;
    }

    /// Begins the trial's file when it is palpated, goes on with it after a pause, and holds it when it is felt again.
    fn record(&mut self, live: &Live, recordings: &mut Recordings) -> Result<(), String> {
        let palpated = self.run().shown().phase == Phase::Palpating;
        let recorder = live.recorder().clone();
        match (&mut self.tape, &self.hidden) {
            (Some(tape), _) if !palpated => {
                if tape.held {
                    return Ok(());
                }
                tape.held = true;
                recordings.wind(recorder, Tape::Hold(true)).map_err(told)
            }
            (None, _) if !palpated => Ok(()),
            (Some(tape), _) if tape.held => {
                tape.held = false;
                recordings.wind(recorder, Tape::Hold(false)).map_err(told)
            }
            (None, Some(hidden)) => {
                // Ticks go on naming the newest edit: header and ticks must agree, and no text of an edit is written.
                let edit = live.snapshot().edit;
                let source = hidden.scenario.source.as_str();
                let truth = Header {
                    participant: self.sitting.header().participant.clone(),
                    ..recording::header(hidden, live, &(edit, source.into()))
                };
                let source = self.blind.scenario.source.as_str();
                let seen = Header {
                    participant: truth.participant.clone(),
                    started_utc: truth.started_utc.clone(),
                    sealed: true,
                    ..recording::header(&self.blind, live, &(edit, source.into()))
                };
                let shown = self.run().shown();
                let practice = if shown.practice { "practice" } else { "trial" };
                let file = format!("{practice}_{:03}.mcap", shown.trial);
                let path = self.folder.join(file);
                let (answered, held) = (false, false);
                self.tape = Some(TrialTape {
                    truth,
                    answered,
                    held,
                });
                let seen = Box::new(seen);
                let beside = self.blind.scenario.folder.clone();
                recordings
                    .wind(recorder, Tape::Begin(path, seen, beside))
                    .map_err(told)
            }
            _ => Ok(()),
        }
    }
}

fn told(e: std::io::Error) -> String {
    format!("cannot record: {e}")
}

impl Bench {
    /// Whether an exercise hides something from whoever does it.
    pub fn is_blind(&self) -> bool {
        self.exercise.as_ref().is_some_and(Exercising::hides)
    }

    /// Does what somebody wants of an exercise; tells why where it cannot be done.
    pub fn exercise(&mut self, wish: Wish) {
        let done = match wish {
            Wish::Begin { participant } => self.begin_exercise(&participant),
            Wish::Resume(folder) => self.resume_exercise(&folder),
            Wish::Do(input) => self.go_on(input),
            Wish::Sheet => self.write_sheet(),
            Wish::Close => {
                self.close_exercise();
                Ok(())
            }
        };
        if let Err(why) = done {
            self.tell(Level::Warning, why);
        }
    }

    fn begin_exercise(&mut self, participant: &str) -> Result<(), String> {
        let scene = self.free_for_exercise()?;
        let participant = Some(participant.to_owned()).filter(|p| !p.is_empty());
        let folder = exercises_in(self.folder()).join(folder_name(participant.as_deref()));
        let named = match self.scenario_path() {
            Some(path) => path.display().to_string(),
            None => scene.scenario.name.clone(),
        };
        let begun = Begun {
            scenario: named,
            participant,
            changes: Changes::default(),
            seed: None,
            observer: None,
        };
        let sitting = Sitting::begin(&folder, &scene.scenario, &begun);
        self.start_exercise(&scene, sitting.map_err(|e| e.to_string())?, folder)
    }

    fn resume_exercise(&mut self, folder: &Path) -> Result<(), String> {
        let scene = self.free_for_exercise()?;
        let open = |_: &JournalHeader| Ok(Scenario::clone(&scene.scenario));
        let (sitting, cut_off) = Sitting::resume(folder, open).map_err(|e| e.to_string())?;
        if let Some(cut_off) = cut_off {
            self.tell(Level::Warning, cut_off.to_string());
        }
        self.start_exercise(&scene, sitting, folder.to_owned())
    }

    /// The open scene, where an exercise can begin in it.
    fn free_for_exercise(&self) -> Result<Arc<Scene>, String> {
        if self.exercise.is_some() {
            return Err("an exercise runs already: end it first".into());
        }
        if self.replay.is_some() {
            return Err("a recording is on show: go back to live to exercise".into());
        }
        if self.is_recording() || self.recordings.is_busy() {
            return Err(
                "a recording runs: stop it first; every trial is recorded by itself".into(),
            );
        }
        if self.build.is_some() || self.ready.is_some() || !self.edits.is_at_rest() {
            return Err("a scene is being built: wait until it is there".into());
        }
        let scene = self.scene.clone();
        scene.ok_or_else(|| "there is no scene to exercise in".into())
    }

    fn start_exercise(
        &mut self,
        scene: &Arc<Scene>,
        mut sitting: Sitting,
        folder: PathBuf,
    ) -> Result<(), String> {
        let blind = match &self.blind {
            Some(blind) => Arc::clone(blind),
            None => Arc::clone(scene),
        };
        let candidates_mm = sitting.run().candidates_mm();
        sitting.set_ground(Ground::of(&blind, candidates_mm));
        let Some(live) = &mut self.live else {
            return Err("the servo does not run".into());
        };
        live.listen(true);
        live.set_scene(&blind);
        self.exercise = Some(Exercising {
            sitting,
            folder,
            started: Instant::now(),
            blind,
            hidden: None,
            build: None,
            stage: Stage::Blind,
            tape: None,
            pending: TickRecord::default(),
            shown_s: 0,
        });
        Ok(())
    }

    fn go_on(&mut self, input: Input) -> Result<(), String> {
        let Some(exercise) = &mut self.exercise else {
            return Err("no exercise runs".into());
        };
        if input == Input::Start && !exercise.is_prepared() {
            return Ok(());
        }
        let now_s = exercise.now_s();
        let taken = exercise.sitting.take(input, now_s);
        let is_told = exercise.run().shown().phase == Phase::Feedback;
        if let Some(tape) = &mut exercise.tape {
            tape.answered |= is_told;
        }
        taken.map_err(|e| e.to_string())?;
        if exercise.run().shown().phase == Phase::Ready {
            exercise.hidden = None;
        }
        Ok(())
    }

    fn write_sheet(&mut self) -> Result<(), String> {
        let Some(exercise) = &self.exercise else {
            return Err("there is no exercise to write a sheet of".into());
        };
        let folder = exercise.folder.clone();
        let target = exercise.run().estimate().map(|(e, _)| e.target);
        let work = move |_: super::job::Progress<'_>| {
            let options = Options {
                target,
                ..Options::default()
            };
            let read = journal::read(&folder).map_err(|e| e.to_string())?;
            let written = sheet::write(&folder, &[Done::new(read, &options)]);
            let files = written.map_err(|e| e.to_string())?;
            let page = files.into_iter().next();
            page.ok_or_else(|| "the score sheet is empty".to_owned())
        };
        let job = Job::start(
            "score sheet",
            BuildStatus::default(),
            self.wake.clone(),
            work,
        );
        self.sheet = Some(job.map_err(|e| format!("the score sheet cannot be written: {e}"))?);
        Ok(())
    }

    /// Tells where a score sheet was written.
    pub(super) fn poll_sheet(&mut self) -> bool {
        let lost = || Err("the score sheet could not be written".to_owned());
        let Some(written) = self.sheet.as_ref().and_then(|job| job.poll(lost)) else {
            return false;
        };
        self.sheet = None;
        match written {
            Ok(page) => {
                let text = format!("The score sheet is written: {}", page.display());
                self.tell(Level::Info, text);
            }
            Err(e) => self.tell(Level::Error, e),
        }
        true
    }

    pub(super) fn close_exercise(&mut self) {
        let (Some(exercise), Some(live)) = (self.exercise.take(), &mut self.live) else {
            return;
        };
        live.listen(false);
        if exercise.tape.is_some()
            && let Err(e) = self.recordings.stop(live.recorder().clone())
        {
            self.tell(Level::Error, told(e));
        }
        self.feel_what_is_open();
    }

    /// Gives the servo the open scene: without what it hides where nobody may see that.
    pub(super) fn feel_what_is_open(&mut self) {
        let scene = match (&self.blind, self.conceals) {
            (Some(blind), true) => Some(blind),
            _ => self.scene.as_ref(),
        };
        if let (Some(live), Some(scene)) = (&mut self.live, scene) {
            live.set_scene(scene);
        }
    }

    /// Whether what the open scene hides is kept from everyone at the window, exercise or not.
    pub fn conceal(&mut self, on: bool) {
        if std::mem::replace(&mut self.conceals, on) != on
            && self.exercise.is_none()
            && self.blind.is_some()
        {
            self.feel_what_is_open();
        }
    }

    /// Lets the exercise go on with time. Answers whether there is anything new to show.
    pub(super) fn poll_exercise(&mut self) -> bool {
        let purpose = self.purpose();
        let (Some(exercise), Some(live)) = (&mut self.exercise, &mut self.live) else {
            return false;
        };
        let phase = exercise.run().shown().phase;
        let now_s = exercise.now_s();
        exercise.feel(&live.take_felt(), 1.0 / live.rate_hz());
        let mut faults = Vec::new();
        if let Err(e) = exercise.sitting.advance(now_s) {
            faults.push(e.to_string());
        }
        let lost = || Err(BuildError("the builder stopped unexpectedly".into()));
        let built = exercise.build.as_ref().and_then(|job| job.poll(lost));
        let mut changed = built.is_some();
        if let Some(built) = built {
            exercise.build = None;
            match built {
                Ok(scene) => exercise.hidden = Some(Arc::new(scene)),
                Err(e) => {
                    // Another try would come to the same.
                    let _ = exercise.sitting.take(Input::Abort, now_s);
                    faults.push(format!("the trial cannot be built: {e}"));
                }
            }
        }
        if let Err(e) = exercise.prepare(purpose, &self.wake) {
            faults.push(format!("the trial cannot be built: {e}"));
        }
        match exercise.direct(live, &mut self.recordings) {
            Ok(moved) => changed |= moved,
            Err(e) => faults.push(e),
        }
        changed |= phase != exercise.run().shown().phase;
        let second = now_s as u64;
        changed |= std::mem::replace(&mut exercise.shown_s, second) != second;
        for fault in faults {
            self.tell(Level::Error, fault);
        }
        changed
    }

    /// Writes into `view` what may be seen of scene and exercise.
    pub(super) fn fill_exercise(&self, view: &mut View, sees_truth: bool) {
        if self.replay.is_some() {
            return;
        }
        let Some(exercise) = &self.exercise else {
            if let (Some(blind), true) = (&self.blind, self.conceals && !sees_truth) {
                view.scene = Some(Arc::clone(blind));
                super::blind::blind(view, &self.no_history);
            }
            return;
        };
        let told = sees_truth || exercise.is_told();
        let hidden = exercise
            .hidden
            .as_ref()
            .filter(|_| told && exercise.hides());
        view.scene = Some(Arc::clone(hidden.unwrap_or(&exercise.blind)));
        view.exercise = Some(exercise.view(sees_truth));
        if !told && exercise.hides() {
            super::blind::blind(view, &self.no_history);
        }
    }
}

/// A folder that sorts by time and tells whose exercise it is: `2031-05-17_09-30-00_P07`.
fn folder_name(participant: Option<&str>) -> String {
    let now = session::utc_now().replace(':', "-").replace('T', "_");
    let time = now.split('.').next().unwrap_or_default();
    match participant {
        Some(participant) => format!("{time}_{participant}"),
        None => time.to_owned(),
    }
}

/// An exercise that was broken off.
#[derive(Clone, Debug, PartialEq)]
pub struct Unfinished {
    /// Where it is kept.
    pub folder: PathBuf,
    /// Who did it.
    pub participant: Option<String>,
    /// Scored trials that are settled, and how many there are at most.
    pub scored: (usize, u32),
}

/// What was broken off of the exercise of `scenario`, newest first, given the folder of recordings.
pub fn unfinished(recordings: &Path, scenario: &Scenario) -> Vec<Unfinished> {
    let Ok(run) = Run::new(scenario, Seed::Stated(0)) else {
        return Vec::new();
    };
    let entries = std::fs::read_dir(exercises_in(recordings));
    let folders = entries.into_iter().flatten().flatten().map(|e| e.path());
    let mut found: Vec<Unfinished> = folders
        .filter_map(|folder| {
            let read = journal::read(&folder).ok()?;
            let same = read.header.blind_toml == run.blind_scenario().source;
            let scored = read.trials.iter().filter(|t| !t.practice).count();
            (same && read.ended.is_none()).then(|| Unfinished {
                folder,
                participant: read.header.participant,
                scored: (scored, run.exercise().trials),
            })
        })
        .collect();
    found.sort_by(|a, b| b.folder.cmp(&a.folder));
    found
}

/// Where exercises are kept, given the folder of recordings.
fn exercises_in(recordings: &Path) -> PathBuf {
    recordings.join("exercises")
}
