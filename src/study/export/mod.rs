//! Sessions handed on: Parquet and CSV for engines of all kinds, BIDS-Motion for archives.
//!
//! # Parquet and CSV
//! Every session goes into a place of its own, told by its participant and itself, so that any number of processes on any
//! number of machines may write into one folder. Placed like this, engines read the folder as one table each:
//!
//! ```text
//! DIR/ticks/participant=P07/session=20310517T093000125Z-t5-right/part-0.parquet
//! DIR/events/participant=…/session=…/part-0.parquet
//! DIR/felt/…
//! DIR/measures/…
//! DIR/sessions/…
//! DIR/sessions.parquet    all of DIR/sessions in one file, and so for events, felt and measures: made by [`gather`]
//! ```
//!
//! | table | one row per |
//! |---|---|
//! | `ticks` | finger and tick: every field of [`crate::session::format::FIELDS`], vectors as `_x` `_y` `_z`, `touch` by name |
//! | `events` | event |
//! | `felt` | site that was pressed, for all fingers together (`finger` absent) and for each |
//! | `measures` | part of the session (`whole`, `search`, `palpation`) and finger (absent: all together): every one of [`super::METRICS`] |
//! | `sessions` | session: what was recorded, what of it could not be read, and every one of [`super::METRICS`] for all fingers together |
//!
//! `participant` and `session` are the folders' names and stand in no file below them; whatever a path does not bear is
//! written as `%` and two hexadecimal digits there, which engines undo. A session without a pseudonym has the participant
//! `unknown`. A session is told by when it began and what its file is called. Integers are signed and have 64 bits. All files of a
//! table have the same columns, whatever the sessions hold. The folder of `sessions` is written last: what has one is whole.
//!
//! # BIDS
//! [`bids`] tells.
//!
//! # What is not handed on
//! A session that stayed sealed is refused. A damaged one is handed on as far as it can be read, and what is missing is told.

pub mod bids;
mod gather;
mod key;
mod tables;
mod tree;

pub use gather::gather;
pub use key::Key;
pub use tables::{Named, TABLES};

use super::{Options, StudyError, cohort};
use crate::session::{Damage, Session};
use serde::Serialize;
use std::collections::HashMap;
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// How sessions are handed on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// Apache Parquet.
    Parquet,
    /// Comma-separated values.
    Csv,
    /// BIDS-Motion.
    Bids,
}

/// What is handed on, and where to.
#[derive(Clone, Debug)]
pub struct Settings {
    /// How.
    pub format: Format,
    /// The folder that takes it; made where it is not there.
    pub folder: PathBuf,
    /// Whether to replace what is there.
    pub force: bool,
    /// How sessions are analysed.
    pub options: Options,
}

/// What became of a session.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Exported {
    /// Who and when.
    pub key: Key,
    /// It was there already and stayed as it was.
    pub skipped: bool,
    /// Rows of ticks, or samples.
    pub rows: u64,
    /// Bytes written.
    pub bytes: u64,
    /// Finger ticks left out: of a tick whose other fingers are missing, or numbered beyond what tables hold.
    pub left_out: u64,
    /// What of it could not be read.
    pub damage: Damage,
}

impl Exported {
    fn new(key: &Key) -> Self {
        Self {
            key: key.clone(),
            skipped: false,
            rows: 0,
            bytes: 0,
            left_out: 0,
            damage: Damage::default(),
        }
    }
}

/// Hands on one session. Each of its files is written beside and renamed; the place is marked as whole by the last.
///
/// # Errors
/// It cannot be read, stays sealed, the file system refuses, or `progress` said stop.
pub fn session(
    path: &Path,
    settings: &Settings,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Exported, StudyError> {
    let session = Session::open(path)?;
    if session.header().sealed {
        let path = path.to_owned();
        return Err(StudyError::Sealed { path });
    }
    let key = Key::of(&session);
    match settings.format {
        Format::Parquet | Format::Csv => tree::write(&session, &key, settings, progress),
        Format::Bids => bids::write(&session, &key, settings, progress),
    }
}

/// Hands on many sessions with `jobs` threads, as [`cohort::run`] analyses them. Of two files that are the same session by
/// their [`Key`] the first is handed on, the other is an error.
///
/// # Errors
/// [`StudyError::Stopped`] when `progress` said so, or an option is not allowed; what is wrong with a file is its result.
pub fn cohort(
    files: &[PathBuf],
    jobs: usize,
    settings: &Settings,
    progress: &mut dyn FnMut(f64) -> bool,
    each: &mut dyn FnMut(usize, Result<Exported, StudyError>),
) -> Result<(), StudyError> {
    settings.options.check()?;
    let mut first: HashMap<String, usize> = HashMap::new();
    let mut twice: HashMap<usize, usize> = HashMap::new();
    for (i, file) in files.iter().enumerate() {
        // What cannot be opened is told when its turn comes.
        let Ok(session) = Session::open(file) else {
            continue;
        };
        let key = Key::of(&session).place();
        if let Some(earlier) = first.get(&key) {
            twice.insert(i, *earlier);
        } else {
            first.insert(key, i);
        }
    }
    let work = |i: usize, path: &Path, done: &mut dyn FnMut(f64) -> bool| match twice.get(&i) {
        None => session(path, settings, done),
        Some(earlier) => {
            let (file, other) = (path.display(), files[*earlier].display());
            Err(StudyError::Output(format!(
                "{file}: the same session as {other} by participant, start and name; it would take its place"
            )))
        }
    };
    cohort::map(files, jobs, &work, progress, each)
}

/// Rounds off a folder that sessions were handed on to: the tables in one file each, or what a BIDS dataset has once.
///
/// # Errors
/// The file system refuses, or a file below is not one of ours.
pub fn finish(settings: &Settings) -> Result<(), StudyError> {
    match settings.format {
        Format::Parquet | Format::Csv => gather(settings),
        Format::Bids => bids::finish(&settings.folder),
    }
}

/// An error that names its file.
fn failed(path: &Path) -> impl Fn(std::io::Error) -> StudyError + '_ {
    move |error| output(path, &error)
}

fn output(path: &Path, error: &dyn Display) -> StudyError {
    StudyError::Output(format!("{}: {error}", path.display()))
}

#[cfg(test)]
mod tests;
