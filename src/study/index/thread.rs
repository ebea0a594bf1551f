//! An index that refreshes itself beside the window.

use super::{Index, Label};
use crate::study::{Options, StudyError, cohort};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How often what is known so far is handed on while files are read.
const HAND_ON: Duration = Duration::from_millis(250);

/// What the window sees.
#[derive(Clone, Debug)]
pub struct IndexState {
    /// What is known; replaced as a whole, cheap to keep.
    pub index: Arc<Index>,
    /// Share of the files under way that is read, 0 to 1; `None` while nothing is read.
    pub progress: Option<f64>,
    /// Grows with every change, so that a window redraws only then.
    pub version: u64,
}

/// A folder's [`Index`] with a thread that reads what changed. Dropped, it stops.
pub struct IndexThread {
    folder: PathBuf,
    state: Arc<Mutex<IndexState>>,
    stop: Arc<AtomicBool>,
    running: Option<JoinHandle<()>>,
}

impl IndexThread {
    /// What the cache says, at once; call [`Self::refresh`] to read the rest.
    pub fn open(folder: &Path) -> Self {
        let state = IndexState {
            index: Arc::new(Index::open(folder)),
            progress: None,
            version: 1,
        };
        Self {
            folder: folder.to_owned(),
            state: Arc::new(Mutex::new(state)),
            stop: Arc::default(),
            running: None,
        }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// What is known now.
    pub fn state(&self) -> IndexState {
        lock(&self.state).clone()
    }

    /// Whether files are being read.
    pub fn is_running(&self) -> bool {
        self.running.as_ref().is_some_and(|t| !t.is_finished())
    }

    /// Looks at the folder and reads what changed, on a thread of its own that leaves a processor to others; does nothing while
    /// that goes on. `changed` is called from that thread whenever there is something new.
    ///
    /// # Errors
    /// The system refuses another thread.
    pub fn refresh(&mut self, changed: impl Fn() + Send + 'static) -> std::io::Result<()> {
        if self.is_running() {
            return Ok(());
        }
        self.stop = Arc::default();
        let (state, stop) = (Arc::clone(&self.state), Arc::clone(&self.stop));
        let thread = std::thread::Builder::new().name("index".into());
        let jobs = cohort::default_jobs().saturating_sub(1).max(1);
        self.running = Some(thread.spawn(move || refresh(&state, &stop, jobs, &changed))?);
        Ok(())
    }

    /// Stops reading; what was read is kept.
    pub fn cancel(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Says something of a recording and writes it down.
    ///
    /// # Errors
    /// The file system refuses: it is said all the same, until the program ends.
    pub fn set_label(&self, name: &str, label: Label) -> std::io::Result<()> {
        let mut state = lock(&self.state);
        state.version += 1;
        Arc::make_mut(&mut state.index).set_label(name, label)
    }
}

impl Drop for IndexThread {
    fn drop(&mut self) {
        self.cancel();
    }
}

fn lock(state: &Mutex<IndexState>) -> MutexGuard<'_, IndexState> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

fn refresh(state: &Mutex<IndexState>, stop: &AtomicBool, jobs: usize, changed: &dyn Fn()) {
    let mut index = Index::clone(&lock(state).index);
    let mut handed: Option<Instant> = None;
    let hand_on = |index: &Index, progress: Option<f64>| {
        let mut state = lock(state);
        let mut index = index.clone();
        // What was said meanwhile is said.
        index.take_labels(&state.index);
        state.index = Arc::new(index);
        state.progress = progress;
        state.version += 1;
        drop(state);
        changed();
    };
    let ended = index.refresh(jobs, &Options::default(), &mut |share, index| {
        if handed.is_none_or(|at| at.elapsed() >= HAND_ON) {
            handed = Some(Instant::now());
            hand_on(index, Some(share));
        }
        !stop.load(Ordering::Relaxed)
    });
    if let Err(error @ StudyError::Option { .. }) = ended {
        index.fault = Some(error.to_string());
    }
    hand_on(&index, None);
}
