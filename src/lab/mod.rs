//! Experiments behind one trait, each of which answers with typed tables, plots and verdicts.
//!
//! An experiment is one file and one line in [`all`]; names that share what stands before a hyphen form a group, which
//! can be asked for by that word. Results are values: printing is the command line's business, and [`write()`] puts them
//! into a folder, all files or none.
//!
//! Times are measured on the machine at hand and say so; what must hold does not depend on them.

mod clock;
pub mod cohort;
pub mod contact;
pub mod deform;
#[cfg(target_os = "linux")]
pub mod devices;
mod document;
pub mod error;
pub mod html;
pub mod partition;
mod program;
pub mod pruning;
mod report;
pub mod session;
mod shelf;
pub mod stability;
mod table;
pub mod training;
mod watch;

use crate::scenario::Scenario;
use crate::session::utc_now;
use crate::surface::Surface;
use std::path::PathBuf;
use std::sync::Arc;

pub use clock::{Samples, Stopwatch};
pub use document::{Document, Machine, write};
pub use program::build;
pub use report::{Drawing, Figure, Report, Setting, Verdict};
pub use shelf::Shelf;
pub use table::{Column, Table, Value};
pub use watch::{Stopped, Watch};

/// Every experiment, groups side by side.
pub fn all() -> &'static [&'static dyn Experiment] {
    &[
        &partition::Complexity,
        &partition::Completeness,
        &partition::Passes,
        &partition::Threshold,
        &partition::BoxSize,
        &contact::Torture,
        &deform::CurveArrays,
        &deform::LocationRatio,
        &deform::Curves,
        &deform::Yardsticks,
        &error::ErrorVsTime,
        &error::ErrorOverSession,
        &pruning::Parts,
        &pruning::Live,
        &session::SessionDamage,
        &session::SessionEndurance,
        &stability::StabilityBorder,
        &stability::StabilityController,
        &stability::Extremes,
        &stability::Integrators,
        &training::TrainingObserver,
        &cohort::SessionCohort,
        #[cfg(target_os = "linux")]
        &devices::DeviceFaults,
        #[cfg(target_os = "linux")]
        &devices::DeviceLoop,
    ]
}

/// One experiment.
pub trait Experiment: Send + Sync {
    /// Name on the command line and in files: lower case and hyphens, its group first.
    fn name(&self) -> &'static str;

    /// What it answers, in one line.
    fn about(&self) -> &'static str;

    /// Which choices of [`Setup`] it heeds. [`Setup::quick`] is heeded by all.
    fn takes(&self) -> &'static [Choice] {
        &[]
    }

    /// Does it. Without timings the result depends on nothing but `setup`.
    ///
    /// # Errors
    /// [`LabError::Stopped`] when `watch` said so, [`LabError::Input`] when `setup` cannot be used.
    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError>;
}

/// What can be chosen for an experiment; each takes those that [`Experiment::takes`] lists.
#[derive(Clone, Debug, Default)]
pub struct Setup {
    /// Fewer repetitions and smaller sizes: a look in seconds instead of minutes.
    pub quick: bool,
    /// The surface to work on; the built-in back without one.
    pub mesh: Option<Mesh>,
    /// Sizes of the built-in back, triangles; the experiment's own where empty.
    pub triangles: Vec<usize>,
    /// The scene to work in; the experiment's own without one.
    pub scene: Option<Scene>,
    /// A recorded session to work on; a scripted one without it.
    pub session: Option<PathBuf>,
    /// Where chance starts: the same seed gives the same.
    pub seed: u64,
    /// How long it works in real time, s; the experiment's own time without it.
    pub seconds: Option<f64>,
    /// Keeps finished parts, so that a run that was stopped goes on where it was.
    pub shelf: Shelf,
}

impl Setup {
    /// With nothing but what `experiment` takes.
    fn taken_by(&self, experiment: &dyn Experiment) -> Self {
        let takes = |choice| experiment.takes().contains(&choice);
        Self {
            quick: self.quick,
            mesh: self.mesh.clone().filter(|_| takes(Choice::Mesh)),
            triangles: match takes(Choice::Triangles) {
                true => self.triangles.clone(),
                false => Vec::new(),
            },
            scene: self.scene.clone().filter(|_| takes(Choice::Scene)),
            session: self.session.clone().filter(|_| takes(Choice::Session)),
            seed: if takes(Choice::Seed) { self.seed } else { 0 },
            seconds: self.seconds.filter(|_| takes(Choice::Seconds)),
            shelf: self.shelf.clone(),
        }
    }
}

/// A scenario and where it came from.
#[derive(Clone, Debug)]
pub struct Scene {
    /// As the user named it.
    pub name: String,
    /// What it says.
    pub scenario: Arc<Scenario>,
}

/// A surface and where it came from.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// As the user named it.
    pub name: String,
    /// The surface.
    pub surface: Arc<Surface>,
}

/// A choice that some experiments take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// [`Setup::mesh`].
    Mesh,
    /// [`Setup::triangles`].
    Triangles,
    /// [`Setup::scene`].
    Scene,
    /// [`Setup::session`].
    Session,
    /// [`Setup::seed`].
    Seed,
    /// [`Setup::seconds`].
    Seconds,
}

/// What [`Setup::seconds`] may be, s: up to a day.
pub const SECONDS: std::ops::RangeInclusive<f64> = 1.0..=86_400.0;

/// Why there is no report.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LabError {
    /// Whoever watched stopped it.
    #[error("the experiment was stopped")]
    Stopped,
    /// The setup cannot be used; says why and what can.
    #[error("{0}")]
    Input(String),
}

impl From<Stopped> for LabError {
    fn from(_: Stopped) -> Self {
        Self::Stopped
    }
}

/// The group of an experiment: its name up to the first hyphen.
pub fn group_of(name: &str) -> &str {
    name.split('-').next().unwrap_or(name)
}

/// The experiment called `name`, or all of the group called so; none for an unknown name.
pub fn select(name: &str) -> Vec<&'static dyn Experiment> {
    let of = |matches: &dyn Fn(&str) -> bool| {
        all()
            .iter()
            .copied()
            .filter(|e| matches(e.name()))
            .collect::<Vec<_>>()
    };
    let one = of(&|n| n == name);
    if one.is_empty() {
        of(&|n| group_of(n) == name)
    } else {
        one
    }
}

/// Runs experiments one after the other; progress is shared out evenly among them. Each gets a shelf of its own and only
/// the choices that it takes. A report that is on its shelf is not made again.
///
/// # Errors
/// The first error of any of them: then there is no document.
pub fn run(
    experiments: &[&dyn Experiment],
    setup: &Setup,
    watch: &mut Watch<'_>,
) -> Result<Document, LabError> {
    let n = experiments.len().max(1) as f64;
    let mut reports = Vec::with_capacity(experiments.len());
    for (i, experiment) in experiments.iter().enumerate() {
        let mut part = watch.part(i as f64 / n, (i + 1) as f64 / n);
        part.at(experiment.name(), 0.0)?;
        let mut setup = setup.taken_by(*experiment);
        let shelf = setup.shelf.begin(experiment.name(), &setup)?;
        let report = match shelf.report() {
            Some(kept) => kept,
            None => {
                setup.shelf = shelf.clone();
                let report = made(*experiment, &setup, &mut part)?;
                shelf.keep_report(&report);
                report
            }
        };
        reports.push(report);
    }
    watch.at("", 1.0)?;
    Ok(Document::new(setup, reports))
}

fn made(
    experiment: &dyn Experiment,
    setup: &Setup,
    watch: &mut Watch<'_>,
) -> Result<Report, LabError> {
    let mut report = experiment.run(setup, watch)?;
    report.experiment = experiment.name().to_owned();
    report.about = experiment.about().to_owned();
    report.measured = utc_now();
    Ok(report)
}

/// The report of an experiment as it lies on its shelf; nothing where there is none.
///
/// # Errors
/// A file that the setup names cannot be read.
pub fn kept(experiment: &dyn Experiment, setup: &Setup) -> Result<Option<Report>, LabError> {
    let setup = setup.taken_by(experiment);
    Ok(setup.shelf.of(experiment.name(), &setup)?.report())
}
