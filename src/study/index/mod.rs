//! What a folder of recordings holds, for the session browser: read once, kept in a cache, refreshed where files changed.
//!
//! | file in the folder | holds |
//! |---|---|
//! | `.dorsum/index.json` | what each recording told, keyed by its path, size and time of change; may be deleted at any time |
//! | `.dorsum/labels.json` | tags and notes of the user; never deleted, a damaged one is set aside |
//!
//! Both are written beside and renamed. A recording of an exercise lies in the folder of its journal as `trial_003.mcap` or
//! `practice_001.mcap`; its score is read from the journal at every refresh. Of a sealed session nothing is told but that it is
//! sealed.

mod labels;
mod score;
mod thread;
mod thumbnail;

pub use labels::{Label, Labels};
pub use score::{Score, score_of};
pub use thread::{IndexState, IndexThread};
pub use thumbnail::Thumbnail;

use super::{About, Analysis, Metrics, Options, StudyError, cohort};
use crate::figure::write_files;
use crate::session::Damage;
use score::Journals;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

/// Folder of the cache inside the folder of recordings.
pub const CACHE_FOLDER: &str = ".dorsum";
/// Name of the cache.
pub const CACHE_FILE: &str = "index.json";
/// Version of the cache; another one is rebuilt.
const FORMAT: u32 = 1;
/// Folders within folders that are looked into.
const DEEPEST: usize = 8;

/// What a recording is told by: another size or time of change, and it is read again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stamp {
    /// Bytes.
    pub bytes: u64,
    /// Time of change, ns since 1970.
    pub changed_ns: u64,
}

impl Stamp {
    fn of(path: &Path) -> std::io::Result<Self> {
        let meta = std::fs::metadata(path)?;
        let changed = meta.modified()?.duration_since(UNIX_EPOCH);
        let changed_ns = changed.map_or(0, |d| u64::try_from(d.as_nanos()).unwrap_or(u64::MAX));
        Ok(Self {
            bytes: meta.len(),
            changed_ns,
        })
    }
}

/// What is known of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Known {
    /// Not read yet.
    Waiting,
    /// A trial that was not answered: nothing else is told.
    Sealed,
    /// It cannot be read: why.
    Unreadable(String),
    /// What it told.
    Read(Box<Told>),
}

/// What a recording told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Told {
    /// What was recorded. The file is as it was found then.
    pub about: About,
    /// Measures of all fingers together.
    pub whole: Metrics,
    /// Where the fingers dwelt.
    pub dwell: Thumbnail,
    /// What could not be read.
    pub damage: Damage,
}

impl Told {
    fn new(analysis: Analysis) -> Self {
        Self {
            dwell: Thumbnail::of(&analysis.dwell),
            about: analysis.about,
            whole: analysis.whole,
            damage: analysis.damage,
        }
    }
}

/// One recording of the folder.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// From the folder, with `/` between its parts.
    pub name: String,
    /// Size and time of change.
    pub stamp: Stamp,
    /// What is known of it.
    pub known: Known,
    /// What its trial came to.
    pub score: Option<Score>,
    /// What the user says of it.
    pub label: Label,
}

impl Recorded {
    /// What it told; `None` while it waits, is sealed or cannot be read.
    pub fn told(&self) -> Option<&Told> {
        match &self.known {
            Known::Read(told) => Some(told),
            _ => None,
        }
    }
}

/// The recordings of a folder.
#[derive(Clone, Debug, PartialEq)]
pub struct Index {
    folder: PathBuf,
    /// By name.
    recorded: BTreeMap<String, Recorded>,
    labels: Labels,
    /// Why the cache could not be kept, if it could not.
    pub fault: Option<String>,
}

#[derive(Serialize, Deserialize)]
struct Cache {
    format: u32,
    recorded: BTreeMap<String, Cached>,
}

#[derive(Serialize, Deserialize)]
struct Cached {
    stamp: Stamp,
    known: Known,
}

impl Index {
    /// What the cache of `folder` and a look at its files tell; quick, whatever the files hold. A cache that is missing or
    /// damaged is empty.
    ///
    /// # Errors
    /// None: a folder that cannot be read has no recordings, and [`Self::fault`] says why.
    pub fn open(folder: &Path) -> Self {
        let mut index = Self {
            folder: folder.to_owned(),
            recorded: BTreeMap::new(),
            labels: Labels::default(),
            fault: None,
        };
        let cached = read_cache(folder).unwrap_or_default();
        let known = |(name, cached): (String, Cached)| {
            let recorded = Recorded {
                name: name.clone(),
                stamp: cached.stamp,
                known: cached.known,
                score: None,
                label: Label::default(),
            };
            (name, recorded)
        };
        index.recorded = cached.into_iter().map(known).collect();
        index.look();
        index
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The recordings by name. Names of the program begin with the time of recording.
    pub fn recorded(&self) -> impl DoubleEndedIterator<Item = &Recorded> + ExactSizeIterator {
        self.recorded.values()
    }

    /// The recording of that name.
    pub fn get(&self, name: &str) -> Option<&Recorded> {
        self.recorded.get(name)
    }

    /// Where the recording of that name lies.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Every tag in use, once.
    pub fn tags(&self) -> Vec<&str> {
        let all = self.recorded.values().flat_map(|r| &r.label.tags);
        let mut tags: Vec<&str> = all.map(String::as_str).collect();
        tags.sort_unstable();
        tags.dedup();
        tags
    }

    /// Says something of a recording and writes it down.
    ///
    /// # Errors
    /// The file system refuses: it is said all the same, until the program ends.
    pub fn set_label(&mut self, name: &str, label: Label) -> std::io::Result<()> {
        let label = label.tidy();
        let started = self.get(name).and_then(Recorded::told);
        let started = started.map(|t| t.about.started_utc.clone());
        if let Some(recorded) = self.recorded.get_mut(name) {
            recorded.label = label.clone();
        }
        self.labels.set(name, started, label);
        self.labels.write(&self.folder)
    }

    /// Looks at the folder: new files wait, changed ones wait again, those that are gone are forgotten.
    pub fn look(&mut self) {
        let mut journals = Journals::default();
        let mut there = BTreeMap::new();
        let names = match recordings(&self.folder) {
            Ok(names) => names,
            Err(e) => {
                self.fault = Some(format!("{}: {e}", self.folder.display()));
                Vec::new()
            }
        };
        for name in names {
            let path = self.folder.join(&name);
            // Gone since it was listed.
            let Ok(stamp) = Stamp::of(&path) else {
                continue;
            };
            let before = self.recorded.remove(&name).filter(|r| r.stamp == stamp);
            let known = before.map_or(Known::Waiting, |r| r.known);
            let score = match known {
                Known::Sealed => None,
                _ => journals.score(&path),
            };
            let recorded = Recorded {
                name: name.clone(),
                stamp,
                known,
                score,
                label: Label::default(),
            };
            there.insert(name, recorded);
        }
        self.recorded = there;
        match Labels::read(&self.folder) {
            Ok(labels) => self.labels = labels,
            Err(e) => self.fault = Some(e.to_string()),
        }
        self.apply_labels();
    }

    fn apply_labels(&mut self) {
        for recorded in self.recorded.values_mut() {
            let started = recorded.told().map(|t| t.about.started_utc.as_str());
            let found = self.labels.get(&recorded.name, started, &self.folder);
            recorded.label = found.cloned().unwrap_or_default();
        }
    }

    /// Takes what `other`, an index of the same folder, says of recordings.
    fn take_labels(&mut self, other: &Self) {
        self.labels = other.labels.clone();
        self.apply_labels();
    }

    /// Names of the recordings that are not read yet, the newest name first.
    pub fn waiting(&self) -> Vec<String> {
        let waits = |r: &&Recorded| r.known == Known::Waiting;
        let all = self.recorded.values().rev();
        all.filter(waits).map(|r| r.name.clone()).collect()
    }

    /// Takes what a recording told. Nothing is taken of one that changed or went since it was read.
    fn learn(&mut self, name: &str, stamp: Stamp, known: Known) {
        let Some(recorded) = self.recorded.get_mut(name).filter(|r| r.stamp == stamp) else {
            return;
        };
        recorded.known = known;
        if recorded.known == Known::Sealed {
            recorded.score = None;
        }
        let started = recorded.told().map(|t| t.about.started_utc.as_str());
        let found = self.labels.get(name, started, &self.folder);
        recorded.label = found.cloned().unwrap_or_default();
    }

    /// Looks at the folder, reads what waits with `jobs` threads, and writes the cache. `progress` gets the share done and what
    /// is known so far, and answers whether to go on; what was read until then is kept.
    ///
    /// # Errors
    /// [`StudyError::Stopped`] when `progress` said so; an option is not allowed. That the cache cannot be written is no error
    /// but told by [`Self::fault`].
    pub fn refresh(
        &mut self,
        jobs: usize,
        options: &Options,
        progress: &mut dyn FnMut(f64, &Self) -> bool,
    ) -> Result<(), StudyError> {
        self.look();
        let waiting = self.waiting();
        let stamps: Vec<Stamp> = waiting.iter().map(|n| self.recorded[n].stamp).collect();
        let paths: Vec<PathBuf> = waiting.iter().map(|n| self.folder.join(n)).collect();
        let shared = std::cell::RefCell::new(self);
        let ended = cohort::run(
            &paths,
            jobs,
            options,
            &mut |share| progress(share, &shared.borrow()),
            &mut |i, result| {
                let known = known(result);
                shared.borrow_mut().learn(&waiting[i], stamps[i], known);
            },
        );
        let index = shared.into_inner();
        if !waiting.is_empty()
            && let Err(e) = index.write_cache()
        {
            index.fault = Some(format!("the cache is not kept: {e}"));
        }
        ended
    }

    fn write_cache(&self) -> std::io::Result<()> {
        let cached = |r: &Recorded| {
            let (stamp, known) = (r.stamp, r.known.clone());
            (r.name.clone(), Cached { stamp, known })
        };
        let read = self.recorded.values().filter(|r| r.known != Known::Waiting);
        let cache = Cache {
            format: FORMAT,
            recorded: read.map(cached).collect(),
        };
        let folder = self.folder.join(CACHE_FOLDER);
        std::fs::create_dir_all(&folder)?;
        write_files(&[(folder.join(CACHE_FILE), serde_json::to_vec(&cache)?)])
    }
}

fn known(result: Result<Analysis, StudyError>) -> Known {
    match result {
        Ok(analysis) => Known::Read(Box::new(Told::new(analysis))),
        Err(StudyError::Sealed { .. }) => Known::Sealed,
        Err(StudyError::Stopped) => Known::Waiting,
        Err(error) => Known::Unreadable(error.to_string()),
    }
}

/// `None`: there is none that can be used.
fn read_cache(folder: &Path) -> Option<BTreeMap<String, Cached>> {
    let bytes = std::fs::read(folder.join(CACHE_FOLDER).join(CACHE_FILE)).ok()?;
    let cache: Cache = serde_json::from_slice(&bytes).ok()?;
    (cache.format == FORMAT).then_some(cache.recorded)
}

/// The recordings below `folder`, from there, with `/` between the parts. Hidden folders and links to folders are left out.
///
/// # Errors
/// The folder cannot be read.
pub fn recordings(folder: &Path) -> std::io::Result<Vec<String>> {
    fn walk(folder: &Path, from: &str, depth: usize, names: &mut Vec<String>) {
        // A folder inside that cannot be read has no recordings for us.
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let (Ok(kind), Ok(name)) = (entry.file_type(), entry.file_name().into_string()) else {
                continue;
            };
            let path = entry.path();
            let below = format!("{from}{name}");
            if kind.is_dir() && depth < DEEPEST && !name.starts_with('.') {
                walk(&path, &format!("{below}/"), depth + 1, names);
            } else if !kind.is_dir() && path.extension().is_some_and(|e| e == "mcap") {
                names.push(below);
            }
        }
    }
    if !folder.exists() {
        return Ok(Vec::new());
    }
    std::fs::read_dir(folder)?;
    let mut names = Vec::new();
    walk(folder, "", 0, &mut names);
    names.sort_unstable();
    Ok(names)
}

#[cfg(test)]
mod tests;
