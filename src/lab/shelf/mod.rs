//! Keeps finished parts of an experiment, so that a run that was stopped goes on where it was.
//!
//! A shelf is a folder, a part is a file in it. [`run`](super::run) gives every experiment a shelf of its own, whose folder
//! is named after a SHA-256 over all that its results depend on: the experiment, the running program, the machine and the
//! setup. Whatever of these changes, parts are made anew.
//!
//! | file | answers |
//! |---|---|
//! | [`label`] | what a shelf belongs to |
//! | [`file`] | how a part lies on the disk |
//! | [`finite`] | whether a part comes back as it was |
//! | [`tidy`] | which shelves are thrown away |

mod file;
mod finite;
mod label;
mod tidy;

use super::{Drawing, LabError, Report, Setup};
use label::Label;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

/// Where finished parts are kept. The default keeps nothing.
#[derive(Clone, Debug, Default)]
pub struct Shelf(Option<Open>);

#[derive(Clone, Debug)]
struct Open {
    folder: PathBuf,
    /// Whether what lies there is not to be used.
    anew: bool,
    /// Why something could not be kept: the first reason.
    trouble: Arc<OnceLock<String>>,
}

/// A report together with its drawings, which are no part of a report's JSON.
#[derive(Serialize, Deserialize)]
struct Whole {
    report: Report,
    drawings: Vec<Drawing>,
}

/// The key of a whole report. Not one that an experiment could give its part.
const WHOLE: &str = "\nreport";

impl Shelf {
    /// A shelf in `folder`, which is made when the first part is kept.
    pub fn open(folder: impl Into<PathBuf>) -> Self {
        Self(Some(Open {
            folder: folder.into(),
            anew: false,
            trouble: Arc::default(),
        }))
    }

    /// The same, but experiments that are run begin with nothing: what was kept for them is thrown away.
    #[must_use]
    pub fn anew(mut self) -> Self {
        if let Some(open) = &mut self.0 {
            open.anew = true;
        }
        self
    }

    /// Where the user's system keeps what can be made again; nothing where it names no such place.
    pub fn usual_folder() -> Option<PathBuf> {
        directories::ProjectDirs::from("", "", "dorsum").map(|d| d.cache_dir().join("lab"))
    }

    /// The part called `key` as it was kept, or else as `make` makes it, which is then kept.
    ///
    /// What comes back is bit for bit what `make` gave: a part that would not is not kept. Such are those with a number
    /// that is not finite, and those that leave a field out when they are written. A part that is damaged is made anew; one
    /// that cannot be written is not kept, and [`trouble`](Self::trouble) says why.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn part<T: Serialize + DeserializeOwned>(
        &self,
        key: &str,
        make: impl FnOnce() -> Result<T, LabError>,
    ) -> Result<T, LabError> {
        if let Some(kept) = self.kept(key) {
            return Ok(kept);
        }
        let part = make()?;
        self.keep(key, &part);
        Ok(part)
    }

    /// Why results could not be kept, if so: the first reason.
    pub fn trouble(&self) -> Option<&str> {
        self.0.as_ref()?.trouble.get().map(String::as_str)
    }

    /// The shelf of one experiment under one setup; one that keeps nothing where it is not known which program this is.
    ///
    /// # Errors
    /// A file that the setup names cannot be read.
    pub(super) fn of(&self, experiment: &str, setup: &Setup) -> Result<Self, LabError> {
        Ok(self
            .labelled(experiment, setup)?
            .map(|(_, s)| s)
            .unwrap_or_default())
    }

    /// The same for an experiment that is about to be run: puts the label on it, and throws away old shelves beside it.
    ///
    /// # Errors
    /// A file that the setup names cannot be read.
    pub(super) fn begin(&self, experiment: &str, setup: &Setup) -> Result<Self, LabError> {
        let Some((label, shelf)) = self.labelled(experiment, setup)? else {
            return Ok(Self::default());
        };
        if let (Some(all), Some(open)) = (&self.0, &shelf.0) {
            if all.anew {
                tidy::discard(&open.folder);
            }
            open.tell(label.put(&open.folder));
            tidy::tidy(&all.folder, &open.folder);
        }
        Ok(shelf)
    }

    fn labelled(&self, experiment: &str, setup: &Setup) -> Result<Option<(Label, Self)>, LabError> {
        let Some(open) = &self.0 else {
            return Ok(None);
        };
        let label = Label::new(experiment, setup)?;
        Ok(label.map(|label| {
            let shelf = Open {
                folder: open.folder.join(label.folder_name()),
                anew: false,
                trouble: Arc::clone(&open.trouble),
            };
            (label, Self(Some(shelf)))
        }))
    }

    /// The whole report as it was kept.
    pub(super) fn report(&self) -> Option<Report> {
        let Whole {
            mut report,
            drawings,
        } = self.kept(WHOLE)?;
        for (figure, drawing) in report.figures.iter_mut().zip(drawings) {
            figure.drawing = drawing;
        }
        Some(report)
    }

    /// Keeps a whole report.
    pub(super) fn keep_report(&self, report: &Report) {
        let drawings = report.figures.iter().map(|f| f.drawing.clone()).collect();
        self.keep(
            WHOLE,
            &Whole {
                report: report.clone(),
                drawings,
            },
        );
    }

    fn kept<T: DeserializeOwned>(&self, key: &str) -> Option<T> {
        let open = self.0.as_ref()?;
        file::read(&open.path(key), key)
    }

    fn keep<T: Serialize + DeserializeOwned>(&self, key: &str, part: &T) {
        let Some(open) = &self.0 else {
            return;
        };
        if let Some(bytes) = file::bytes(key, part) {
            open.tell(file::write(&open.path(key), bytes));
        }
    }
}

impl Open {
    fn path(&self, key: &str) -> PathBuf {
        self.folder.join(file::name(key))
    }

    fn tell(&self, result: std::io::Result<()>) {
        if let Err(e) = result {
            let told = format!(
                "finished parts are not kept: {}: {e}",
                self.folder.display()
            );
            // The first one stays: with a full disk they are all alike.
            let _ = self.trouble.set(told);
        }
    }
}

#[cfg(test)]
mod tests;
