//! Scenes are built on a thread of their own, with progress and cancel.

use crate::app::state::BuildStatus;
use crate::scenario::{self, BuildError, Example, Scenario, Scene, Use};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};

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
pub struct Build {
    status: Arc<Mutex<BuildStatus>>,
    cancel: Arc<AtomicBool>,
    result: mpsc::Receiver<Result<Scene, BuildError>>,
}

impl Build {
    /// Starts building; `wake` is called when something is new to show.
    ///
    /// # Errors
    /// When the system refuses another thread.
    pub fn start(
        source: Source,
        purpose: Use,
        wake: Arc<dyn Fn() + Send + Sync>,
    ) -> std::io::Result<Self> {
        let status = Arc::new(Mutex::new(BuildStatus {
            scenario: source.name(),
            part: "scenario".into(),
            fraction: 0.0,
        }));
        let cancel = Arc::new(AtomicBool::new(false));
        let (send, result) = mpsc::sync_channel(1);
        let (shared, stop) = (status.clone(), cancel.clone());
        std::thread::Builder::new()
            .name("builder".into())
            .spawn(move || {
                let mut progress = |part: &str, fraction: f64| {
                    let mut status = shared.lock().unwrap_or_else(PoisonError::into_inner);
                    part.clone_into(&mut status.part);
                    status.fraction = fraction;
                    drop(status);
                    wake();
                    !stop.load(Ordering::Relaxed)
                };
                let scene = source
                    .read()
                    .and_then(|s| scenario::build(Arc::new(s), purpose, &mut progress));
                // The bench may have gone in the meantime.
                let _ = send.send(scene);
                wake();
            })?;
        Ok(Self {
            status,
            cancel,
            result,
        })
    }

    /// How far it is.
    pub fn status(&self) -> BuildStatus {
        self.status
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    /// Asks it to stop at the next step.
    pub fn cancel(&self) {
        self.cancel.store(true, Ordering::Relaxed);
    }

    /// Whether it was asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    /// The outcome, once there is one.
    pub fn poll(&self) -> Option<Result<Scene, BuildError>> {
        match self.result.try_recv() {
            Ok(result) => Some(result),
            Err(mpsc::TryRecvError::Empty) => None,
            Err(mpsc::TryRecvError::Disconnected) => {
                Some(Err(BuildError("the builder stopped unexpectedly".into())))
            }
        }
    }
}

impl Drop for Build {
    fn drop(&mut self) {
        self.cancel();
    }
}
