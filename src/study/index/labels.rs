//! Tags and notes of the user.

use super::CACHE_FOLDER;
use crate::figure::write_files;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::{Error, Result};
use std::path::{Path, PathBuf};

/// Name of the file inside [`CACHE_FOLDER`].
pub const FILE: &str = "labels.json";

/// What the user says of a recording.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Label {
    /// Words, each once, in their order.
    pub tags: Vec<String>,
    /// A remark.
    pub note: String,
}

impl Label {
    /// Whether nothing is said.
    pub fn is_empty(&self) -> bool {
        self.tags.is_empty() && self.note.is_empty()
    }

    /// Tags trimmed, sorted, each once and none empty.
    #[must_use]
    pub fn tidy(self) -> Self {
        let trimmed = self.tags.iter().map(|t| t.trim().to_owned());
        let mut tags: Vec<String> = trimmed.filter(|t| !t.is_empty()).collect();
        tags.sort_unstable();
        tags.dedup();
        let note = self.note.trim().to_owned();
        Self { tags, note }
    }
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Said {
    #[serde(flatten)]
    label: Label,
    /// When the recording was begun: finds one that was renamed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    started_utc: Option<String>,
}

/// What the user says of the recordings of a folder, also of those that are not there at the moment.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Labels(BTreeMap<String, Said>);

impl Labels {
    /// Reads those of `folder`; none where nothing was ever said. A damaged file is set aside under another name.
    ///
    /// # Errors
    /// The file cannot be read, or was set aside: where it is now.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(CACHE_FOLDER).join(FILE);
        let told = |e: &dyn std::fmt::Display| Error::other(format!("{}: {e}", path.display()));
        let bytes = match std::fs::read(&path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Self::default()),
            read => read.map_err(|e| told(&e))?,
        };
        serde_json::from_slice(&bytes).map_err(|e| {
            let aside = free_name(&path);
            match std::fs::rename(&path, &aside) {
                Ok(()) => told(&format_args!("{e}; set aside as {}", aside.display())),
                Err(cannot) => told(&format_args!("{e}; not set aside: {cannot}")),
            }
        })
    }

    /// What is said of a recording: by its name, else by its beginning where the file that was called otherwise is gone.
    pub fn get(&self, name: &str, started_utc: Option<&str>, folder: &Path) -> Option<&Label> {
        if let Some(said) = self.0.get(name) {
            return Some(&said.label);
        }
        let started = started_utc?;
        let moved = |(name, said): &(&String, &Said)| {
            said.started_utc.as_deref() == Some(started) && !folder.join(name).exists()
        };
        self.0.iter().find(moved).map(|(_, said)| &said.label)
    }

    /// Says it; a [`Label`] that is empty forgets it.
    pub fn set(&mut self, name: &str, started_utc: Option<String>, label: Label) {
        if label.is_empty() && started_utc.is_none() {
            self.0.remove(name);
            return;
        }
        // An empty one stays: it stands against what was said under an older name.
        self.0.insert(name.to_owned(), Said { label, started_utc });
    }

    /// Writes them all.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let folder = folder.join(CACHE_FOLDER);
        std::fs::create_dir_all(&folder)?;
        write_files(&[(folder.join(FILE), serde_json::to_vec_pretty(self)?)])
    }
}

fn free_name(path: &Path) -> PathBuf {
    (1_u32..)
        .map(|n| path.with_extension(format!("damaged-{n}.json")))
        .find(|p| !p.exists())
        .unwrap_or_else(|| path.with_extension("damaged.json"))
}
