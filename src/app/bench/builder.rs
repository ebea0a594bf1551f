//! Where scenes come from, and how one is built beside the window.

use super::Wake;
use super::job::Job;
use crate::app::state::BuildStatus;
use crate::scenario::exercise::Hides;
use crate::scenario::{self, BuildError, Example, Scenario, Scene, Use};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where a scenario comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// A file.
    File(PathBuf),
    /// An embedded example.
    Example(Example),
    /// Text that a recording carries; relative paths start from `folder`.
    Text {
        /// The scenario, whole.
        toml: String,
        /// What to call it in errors.
        origin: String,
        /// Where relative paths start.
        folder: Option<PathBuf>,
    },
}

impl Source {
    /// What to call it before it is read.
    pub fn name(&self) -> String {
        match self {
            Self::File(path) => file_name(path),
            Self::Example(example) => example.file.to_owned(),
            Self::Text { origin, .. } => origin.clone(),
        }
    }

    fn read(&self) -> Result<Scenario, BuildError> {
        Ok(match self {
            Self::File(path) => Scenario::load(path)?,
            Self::Example(example) => Scenario::parse(example.text, example.file, None)?,
            Self::Text {
                toml,
                origin,
                folder,
            } => Scenario::parse(toml, origin, folder.as_deref())?,
        })
    }
}

/// The last part of a path.
pub fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(
        || path.display().to_string(),
        |n| n.to_string_lossy().into(),
    )
}

/// A scene, and the same without what its exercise hides, where that is stated in it.
#[derive(Clone)]
pub struct Built {
    /// The scene as its scenario says.
    pub scene: Arc<Scene>,
    /// Without what is hidden; `None` where there is nothing to hide.
    pub blind: Option<Arc<Scene>>,
}

impl Built {
    /// `scene`, and what of it may be shown to who shall find the rest.
    ///
    /// # Errors
    /// The other one cannot be built.
    pub fn of(scene: Scene, purpose: Use) -> Result<Self, BuildError> {
        let scenario = &scene.scenario;
        let hides = scenario.exercise.as_ref().map(|e| &e.hides);
        let blind = if hides == Some(&Hides::Stated) && !scenario.dysfunctions.is_empty() {
            let blind = Arc::new(scenario.with_dysfunctions(&[])?);
            Some(Arc::new(beside(&scene, blind, purpose)?))
        } else {
            None
        };
        let scene = Arc::new(scene);
        Ok(Self { scene, blind })
    }
}

/// A scene beside `scene`, sharing with it what it can.
///
/// # Errors
/// The scenario is refused.
pub fn beside(scene: &Scene, scenario: Arc<Scenario>, purpose: Use) -> Result<Scene, BuildError> {
    if scenario::changes_surface(&scene.scenario, &scenario) {
        scenario::build(scenario, purpose, &mut |_, _| true)
    } else {
        scenario::rebuild(scene, scenario, purpose)
    }
}

/// A scene being built.
pub type Build = Job<Result<Built, BuildError>>;

/// Starts building; `wake` is called when something is new to show.
///
/// # Errors
/// When the system refuses another thread.
pub fn build(source: Source, purpose: Use, wake: Wake) -> std::io::Result<Build> {
    let status = BuildStatus {
        scenario: source.name(),
        part: "scenario".into(),
        fraction: 0.0,
    };
    Job::start("builder", status, wake, move |progress| {
        let scene = scenario::build(Arc::new(source.read()?), purpose, progress)?;
        Built::of(scene, purpose)
    })
}
