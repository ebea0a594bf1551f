//! The lab beside the window: which experiment, under which choices, how far it is, what it found.
//!
//! | file | answers |
//! |---|---|
//! | [`choices`] | what the user chose, and what an experiment gets of it |
//! | [`report`] | how results become files |
//!
//! It belongs to the Lab panel and runs experiments as the command line does, on a thread of low priority: the servo does
//! not feel it. Nothing is held while the panel is closed.

pub mod choices;
pub mod report;

use super::bench::Wake;
use super::bench::job::Job;
use super::editor::worker::Worker;
use super::state::{BuildStatus, View};
use crate::lab::{self, Document, Experiment, LabError, Shelf, Watch};
use choices::{Asked, Choices};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// An experiment of the list.
pub type Listed = &'static dyn Experiment;

/// What was found, and what was asked.
#[derive(Clone)]
pub struct Found {
    /// Tables, figures and verdicts.
    pub document: Arc<Document>,
    /// The question.
    asked: Asked,
    /// Counts answers: another one means that there is something else to show.
    pub number: u64,
}

struct Running {
    experiment: Listed,
    asked: Asked,
    job: Job<Result<Document, LabError>>,
    since: Instant,
    shelf: Shelf,
}

/// How far a run is.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// Name of the experiment.
    pub experiment: &'static str,
    /// What is being done.
    pub what: String,
    /// Done, 0 to 1.
    pub share: f64,
    /// Since the start.
    pub elapsed: Duration,
    /// Whether it was asked to stop.
    pub stopping: bool,
}

/// What was asked, and the answer that lay on the shelf.
type Kept = (Asked, Option<Document>);

/// The lab of one window.
pub struct Laboratory {
    shelf: Shelf,
    chosen: Option<Listed>,
    /// What the user chose; each experiment gets what it takes of it.
    pub choices: Choices,
    running: Option<Running>,
    looking: Worker<Kept>,
    /// What was last looked for on the shelf.
    looked: Option<Asked>,
    found: BTreeMap<&'static str, Found>,
    answers: u64,
    told: Option<String>,
}

impl Default for Laboratory {
    /// Keeps its results where the command line does.
    fn default() -> Self {
        Self::new(Shelf::usual_folder().map_or_else(Shelf::default, Shelf::open))
    }
}

impl Laboratory {
    /// Keeps its results on `shelf`.
    pub fn new(shelf: Shelf) -> Self {
        Self {
            shelf,
            chosen: None,
            choices: Choices::default(),
            running: None,
            looking: Worker::new("lab shelf"),
            looked: None,
            found: BTreeMap::new(),
            answers: 0,
            told: None,
        }
    }

    /// The experiment on show.
    pub fn chosen(&self) -> Option<Listed> {
        self.chosen
    }

    /// Shows the experiment called `name`, if there is one.
    pub fn choose(&mut self, name: &str) {
        if let Some(found) = lab::all().iter().find(|e| e.name() == name) {
            self.chosen = Some(*found);
            self.told = None;
        }
    }

    /// Takes over what is done, and looks on the shelf for what is asked. `wake` is called when there is something new.
    pub fn follow(&mut self, view: &View, wake: &Wake) {
        self.poll();
        if let Some((asked, kept)) = self.looking.poll(wake)
            && let Some(document) = kept
        {
            self.answer(asked, document);
        }
        let Some(experiment) = self.chosen.filter(|_| self.running.is_none()) else {
            return;
        };
        // A choice that cannot be used yet is told beside it.
        let Ok(asked) = self.choices.asked(experiment, view) else {
            return;
        };
        let is_shown = (self.found.get(experiment.name())).is_some_and(|f| f.asked == asked);
        if is_shown || self.looked.as_ref() == Some(&asked) {
            return;
        }
        self.looked = Some(asked.clone());
        let setup = asked.setup(&self.shelf);
        let look = move |_: &dyn Fn() -> bool| {
            let kept = lab::kept(experiment, &setup).ok().flatten();
            Some((
                asked,
                kept.map(|report| Document::new(&setup, vec![report])),
            ))
        };
        self.looking.ask(true, look, wake);
    }

    fn poll(&mut self) {
        let Some(running) = &self.running else {
            return;
        };
        let lost = || Err(LabError::Input("the experiment broke off".to_owned()));
        let Some(outcome) = running.job.poll(lost) else {
            return;
        };
        let (asked, trouble) = (running.asked.clone(), running.shelf.trouble());
        self.told = trouble.map(str::to_owned);
        self.running = None;
        match outcome {
            Ok(document) => self.answer(asked, document),
            Err(LabError::Stopped) => {
                self.told = Some("Stopped. Finished parts are kept: Run goes on from there".into());
            }
            Err(e) => self.told = Some(e.to_string()),
        }
    }

    fn answer(&mut self, asked: Asked, document: Document) {
        self.answers += 1;
        let found = Found {
            document: Arc::new(document),
            number: self.answers,
            asked,
        };
        self.found.insert(found.asked.experiment(), found);
    }

    /// Runs the experiment on show; with `anew` what was kept of it is thrown away first. Does nothing while one runs.
    ///
    /// # Errors
    /// A choice cannot be used, or the system refuses another thread: one line.
    pub fn run(&mut self, anew: bool, view: &View, wake: &Wake) -> Result<(), String> {
        let Some(experiment) = self.chosen.filter(|_| self.running.is_none()) else {
            return Ok(());
        };
        let asked = self.choices.asked(experiment, view)?;
        let shelf = match anew {
            true => self.shelf.clone().anew(),
            false => self.shelf.clone(),
        };
        let setup = asked.setup(&shelf);
        let status = BuildStatus {
            scenario: experiment.name().into(),
            part: String::new(),
            fraction: 0.0,
        };
        let job = Job::start("lab", status, calm(wake), move |progress| {
            // Refused where the system does not allow it: then it runs as it is.
            let _ =
                thread_priority::set_current_thread_priority(thread_priority::ThreadPriority::Min);
            lab::run(&[experiment], &setup, &mut Watch::new(progress))
        })
        .map_err(|e| format!("the experiment cannot start: {e}"))?;
        self.told = None;
        self.running = Some(Running {
            experiment,
            asked,
            job,
            since: Instant::now(),
            shelf,
        });
        Ok(())
    }

    /// Asks what runs to stop; its finished parts are kept.
    pub fn cancel(&self) {
        if let Some(running) = &self.running {
            running.job.cancel();
        }
    }

    /// How far the run is; nothing while none is under way.
    pub fn progress(&self) -> Option<Progress> {
        let running = self.running.as_ref()?;
        let status = running.job.status();
        Some(Progress {
            experiment: running.experiment.name(),
            what: status.part,
            share: status.fraction,
            elapsed: running.since.elapsed(),
            stopping: running.job.is_cancelled(),
        })
    }

    /// What was last found for the experiment on show.
    pub fn found(&self) -> Option<&Found> {
        self.found.get(self.chosen?.name())
    }

    /// Whether what was found answers the choices as they are.
    pub fn is_current(&self, view: &View) -> bool {
        let asked = |e| self.choices.asked(e, view).ok();
        match (self.found(), self.chosen.and_then(asked)) {
            (Some(found), Some(asked)) => found.asked == asked,
            _ => false,
        }
    }

    /// What there is to say of the last run: that it was stopped, why it failed, why nothing could be kept.
    pub fn told(&self) -> Option<&str> {
        self.told.as_deref()
    }

    /// Forgets results and stops what runs; what was chosen stays.
    pub fn release(&mut self) {
        self.running = None;
        self.looking.stop();
        self.looked = None;
        self.found.clear();
        self.told = None;
    }
}

/// Wakes no more than some times a second: an experiment tells every step, of which there may be thousands.
fn calm(wake: &Wake) -> Wake {
    let (wake, last) = (wake.clone(), std::sync::Mutex::new(Instant::now()));
    Arc::new(move || {
        let mut last = last
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        if last.elapsed() > Duration::from_millis(100) {
            *last = Instant::now();
            wake();
        }
    })
}
