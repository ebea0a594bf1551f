//! The recordings of a folder, read on a thread of their own: first that they are there, then what they say of themselves.

use super::entry::{Entry, State};
use crate::app::bench::Wake;
use crate::app::bench::job::Job;
use crate::app::state::BuildStatus;
use crate::session::Session;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Most recordings listed.
const MOST: usize = 20_000;
/// Folders below the chosen one that are looked into: exercises keep a folder each.
const DEPTH: usize = 3;
/// The list on show is renewed no oftener.
const RENEWED: Duration = Duration::from_millis(200);

/// What the reading thread has found so far.
#[derive(Default)]
struct Found {
    entries: Vec<Entry>,
    /// Counts changes.
    version: u64,
    /// What is to be said of the folder as a whole.
    note: Option<String>,
}

/// The recordings of one folder.
pub struct Shelf {
    folder: PathBuf,
    found: Arc<Mutex<Found>>,
    reading: Option<Job<()>>,
    entries: Arc<Vec<Entry>>,
    note: Option<String>,
    version: u64,
    renewed: Option<Instant>,
}

impl Shelf {
    /// Starts reading `folder`.
    pub fn of(folder: &Path, wake: Wake) -> Self {
        let found = Arc::new(Mutex::new(Found::default()));
        let status = BuildStatus {
            scenario: "recordings".into(),
            part: "listing".into(),
            fraction: 0.0,
        };
        let (shared, place) = (found.clone(), folder.to_owned());
        let reading = Job::start("session browser", status, wake, move |progress| {
            read(&place, &shared, progress);
        });
        let mut shelf = Self {
            folder: folder.to_owned(),
            found,
            reading: None,
            entries: Arc::default(),
            note: None,
            version: 0,
            renewed: None,
        };
        match reading {
            Ok(job) => shelf.reading = Some(job),
            Err(e) => shelf.note = Some(format!("the folder cannot be read: {e}")),
        }
        shelf
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The recordings as far as they are read; the number changes with them.
    pub fn entries(&self) -> (Arc<Vec<Entry>>, u64) {
        (self.entries.clone(), self.version)
    }

    /// What is to be said of the folder.
    pub fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    /// How far the reading is; `None` when it is done.
    pub fn progress(&self) -> Option<BuildStatus> {
        self.reading.as_ref().map(Job::status)
    }

    /// Ends the reading; what is known stays.
    pub fn cancel(&mut self) {
        if let Some(job) = &self.reading {
            job.cancel();
        }
    }

    /// Bytes held, without what thumbnails are made of.
    pub fn bytes(&self) -> usize {
        self.entries.capacity() * size_of::<Entry>()
    }

    /// Writes tags on a recording.
    pub fn tag(&mut self, path: &Path, tags: Vec<String>) {
        let mut found = lock(&self.found);
        if let Some(entry) = found.entries.iter_mut().find(|e| e.path == path) {
            entry.tags = tags;
            found.version += 1;
        }
        self.entries = Arc::new(found.entries.clone());
        self.version = found.version;
    }

    /// Takes over what is new; answers after how long to ask again.
    pub fn poll(&mut self) -> Option<Duration> {
        let done = self.reading.as_ref()?.poll(|| ()).is_some();
        let since = self.renewed.map_or(RENEWED, |at| at.elapsed());
        if !done && since < RENEWED {
            return Some(RENEWED - since);
        }
        if done {
            self.reading = None;
        }
        let found = lock(&self.found);
        if found.version != self.version {
            self.version = found.version;
            self.entries = Arc::new(found.entries.clone());
            self.note.clone_from(&found.note);
            self.renewed = Some(Instant::now());
        }
        None
    }
}

fn lock(found: &Mutex<Found>) -> MutexGuard<'_, Found> {
    found.lock().unwrap_or_else(PoisonError::into_inner)
}

fn read(folder: &Path, found: &Mutex<Found>, progress: &mut dyn FnMut(&str, f64) -> bool) {
    let mut files = Vec::new();
    let fault = files_in(folder, DEPTH, &mut files).err();
    let n = files.len();
    let say = |change: &mut dyn FnMut(&mut Found)| {
        let mut found = lock(found);
        change(&mut found);
        found.version += 1;
    };
    say(&mut |found| {
        found.entries = (files.iter())
            .map(|(path, bytes)| Entry::unread(path.clone(), *bytes))
            .collect();
        found.note = match &fault {
            // A folder that is not there yet is an empty one.
            Some(e) if e.kind() != std::io::ErrorKind::NotFound => {
                Some(format!("{}: cannot be read: {e}", folder.display()))
            }
            _ if n >= MOST => Some(format!("Only the first {MOST} recordings are listed")),
            _ => None,
        };
    });
    for (i, (path, bytes)) in files.into_iter().enumerate() {
        let entry = entry_of(path, bytes);
        say(&mut |found| found.entries[i].clone_from(&entry));
        if !progress("reading", (i + 1) as f64 / n as f64) {
            return;
        }
    }
}

fn entry_of(path: PathBuf, bytes: u64) -> Entry {
    let mut entry = Entry::unread(path, bytes);
    match Session::open(&entry.path) {
        Ok(session) => {
            let header = session.header();
            entry.started_utc.clone_from(&header.started_utc);
            entry.participant.clone_from(&header.participant);
            if header.sealed {
                entry.state = State::Sealed;
            } else {
                entry.scenario.clone_from(&header.scenario_name);
            }
        }
        Err(e) => entry.state = State::Unreadable(e.to_string()),
    }
    entry
}

/// Adds the recordings in `folder` and up to `depth` folders below it, with their sizes, in the order of their paths.
fn files_in(folder: &Path, depth: usize, files: &mut Vec<(PathBuf, u64)>) -> std::io::Result<()> {
    let mut entries: Vec<_> = std::fs::read_dir(folder)?.flatten().collect();
    entries.sort_by_key(std::fs::DirEntry::path);
    for entry in entries {
        let Ok(meta) = entry.metadata() else { continue };
        let path = entry.path();
        if files.len() >= MOST {
            return Ok(());
        }
        if meta.is_dir() {
            if depth > 0 {
                // One that may not be looked into has nothing to show.
                let _ = files_in(&path, depth - 1, files);
            }
        } else if path.extension().is_some_and(|e| e == "mcap") {
            files.push((path, meta.len()));
        }
    }
    Ok(())
}
