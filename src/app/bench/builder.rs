//! Where scenes come from, and how one is built beside the window.

use super::Wake;
use super::job::Job;
use crate::app::state::BuildStatus;
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

/// A scene being built.
pub type Build = Job<Result<Scene, BuildError>>;

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
        scenario::build(Arc::new(source.read()?), purpose, progress)
    })
}
