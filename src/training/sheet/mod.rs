//! Score sheets: what an exercise, or all that a participant did, came to, to print, to read and to reckon with.
//!
//! | file | gives |
//! |---|---|
//! | `html` | one page to print, without scripts; nothing is loaded from elsewhere |
//! | `table` | the columns of a trial and of a participant, for CSV and Parquet alike ([`crate::table`]) |

mod html;
mod plots;
mod table;

use super::analysis::{self, Analysis, Options};
use super::journal::Read;
use super::run::TrainingError;
use crate::figure::write_files;
use std::path::{Path, PathBuf};

pub use html::page;

/// An exercise that was done, and what it came to.
#[derive(Clone, Debug)]
pub struct Done {
    /// Its journal.
    pub read: Read,
    /// What its trials say.
    pub analysis: Analysis,
}

impl Done {
    /// Analyses a journal.
    pub fn new(read: Read, options: &Options) -> Self {
        let analysis = analysis::of(&read.trials, options);
        Self { read, analysis }
    }

    /// Pseudonym of who did it; "–" where none is known.
    pub fn participant(&self) -> &str {
        self.read.header.participant.as_deref().unwrap_or("–")
    }
}

/// The files of a score sheet.
pub const FILES: [&str; 5] = [
    "sheet.html",
    "trials.csv",
    "trials.parquet",
    "participants.csv",
    "participants.parquet",
];

/// Writes the sheet of exercises into `folder`: all its files or none.
///
/// # Errors
/// The file system refuses, or a figure cannot be drawn.
pub fn write(folder: &Path, done: &[Done]) -> Result<Vec<PathBuf>, TrainingError> {
    let failed = |e: &dyn std::fmt::Display| TrainingError(format!("{}: {e}", folder.display()));
    let (trials, participants) = (table::trials(done), table::participants(done));
    let contents = [
        page(done).map_err(|e| failed(&e))?.into_bytes(),
        trials.csv().map_err(|e| failed(&e))?,
        trials.parquet().map_err(|e| failed(&e))?,
        participants.csv().map_err(|e| failed(&e))?,
        participants.parquet().map_err(|e| failed(&e))?,
    ];
    let files: Vec<(PathBuf, Vec<u8>)> = (FILES.iter().map(|name| folder.join(name)))
        .zip(contents)
        .collect();
    write_files(&files).map_err(|e| failed(&e))?;
    Ok(files.into_iter().map(|(path, _)| path).collect())
}

#[cfg(test)]
mod tests;
