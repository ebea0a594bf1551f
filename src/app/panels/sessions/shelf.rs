//! The recordings of a folder, as its index knows them. Opening the index, reading what it does not know yet and writing tags
//! are done on threads of their own.

use super::entry::{Entry, Mark, State};
use crate::app::bench::Wake;
use crate::app::bench::job::Job;
use crate::app::state::BuildStatus;
use crate::study::index::{Index, IndexThread, Known, Label, Recorded, Score};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, UNIX_EPOCH};

/// The recordings of one folder.
pub struct Shelf {
    folder: PathBuf,
    wake: Wake,
    opening: Option<Job<Option<IndexThread>>>,
    index: Option<IndexThread>,
    entries: Arc<Vec<Entry>>,
    /// Of the index that the entries are of.
    version: u64,
    note: Option<String>,
}

impl Shelf {
    /// Starts reading `folder`.
    pub fn of(folder: &Path, wake: Wake) -> Self {
        let place = folder.to_owned();
        let work = move |_: crate::app::bench::job::Progress<'_>| Some(IndexThread::open(&place));
        let opening = Job::start("index", BuildStatus::default(), wake.clone(), work);
        let mut shelf = Self {
            folder: folder.to_owned(),
            wake,
            opening: None,
            index: None,
            entries: Arc::default(),
            version: 0,
            note: None,
        };
        match opening {
            Ok(job) => shelf.opening = Some(job),
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

    /// Share of the recordings that is read, 0 to 1; `None` when that is done.
    pub fn progress(&self) -> Option<f64> {
        match &self.index {
            Some(index) => index.state().progress,
            None => self.opening.as_ref().map(|_| 0.0),
        }
    }

    /// Ends the reading; what is known stays.
    pub fn cancel(&self) {
        if let Some(index) = &self.index {
            index.cancel();
        }
    }

    /// Bytes held, without what thumbnails are made of.
    pub fn bytes(&self) -> usize {
        self.entries.capacity() * size_of::<Entry>()
    }

    /// Looks at the folder again: what is new or changed is read.
    pub fn look_again(&mut self) {
        if let Some(index) = &mut self.index {
            let wake = self.wake.clone();
            if let Err(e) = index.refresh(move || wake()) {
                self.note = Some(format!("the folder cannot be read: {e}"));
            }
        }
    }

    /// Writes tags on a recording; what was remarked on it stays.
    pub fn tag(&mut self, path: &Path, tags: Vec<String>) {
        let Some(index) = &self.index else { return };
        let known = index.state().index;
        let Some(recorded) = known.recorded().find(|r| known.path(&r.name) == path) else {
            return;
        };
        let note = recorded.label.note.clone();
        if let Err(e) = index.set_label(&recorded.name, Label { tags, note }) {
            self.note = Some(format!("the tags are not kept: {e}"));
        }
    }

    /// Takes over what is new.
    pub fn poll(&mut self) {
        let opened = self.opening.as_ref().and_then(|job| job.poll(|| None));
        if let Some(index) = opened {
            self.opening = None;
            self.index = index;
            self.look_again();
        }
        let Some(index) = &self.index else { return };
        let state = index.state();
        if state.version == self.version {
            return;
        }
        self.version = state.version;
        self.note.clone_from(&state.index.fault);
        let entries = state.index.recorded().map(|r| entry_of(&state.index, r));
        self.entries = Arc::new(entries.collect());
    }
}

fn entry_of(index: &Index, recorded: &Recorded) -> Entry {
    let mut entry = Entry::unread(index.path(&recorded.name), recorded.stamp.bytes);
    entry.tags.clone_from(&recorded.label.tags);
    let changed = UNIX_EPOCH.checked_add(Duration::from_nanos(recorded.stamp.changed_ns));
    let changed = changed.map(|at| humantime::format_rfc3339_seconds(at).to_string());
    entry.started_utc = changed.unwrap_or_default();
    match &recorded.known {
        Known::Waiting => entry.state = State::Unread,
        Known::Sealed => {
            entry.state = State::Sealed;
            return entry;
        }
        Known::Unreadable(why) => entry.state = State::Unreadable(why.clone()),
        Known::Read(told) => {
            if !told.damage.is_none() {
                entry.state = State::Damaged(told.damage.first.clone());
            } else {
                entry.state = State::Good;
            }
            entry.participant.clone_from(&told.about.participant);
            entry.scenario.clone_from(&told.about.scenario);
            entry.started_utc.clone_from(&told.about.started_utc);
            entry.seconds = Some(told.about.seconds);
            entry.lost = told.about.lost;
            entry.dwell = Some(Arc::new(told.dwell.clone()));
        }
    }
    entry.score = recorded.score.as_ref().map(mark_of);
    entry
}

fn mark_of(score: &Score) -> Mark {
    let text = if score.practice {
        format!("{}, practice", score.text())
    } else {
        score.text()
    };
    Mark {
        text,
        rank: match (score.right, score.error_mm) {
            (true, _) => 0.0,
            (false, Some(mm)) => -mm,
            (false, None) => f64::MIN,
        },
    }
}
