//! What there is to know of a scenario without opening it.

use crate::scenario::{self, Scenario, exercise::Hides};
use crate::training;
use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most files of a folder that are listed.
const MOST_FILES: usize = 500;
/// Largest file that is read, bytes.
const MOST_BYTES: u64 = 4 << 20;
/// Dysfunctions named one by one.
const NAMED: usize = 3;

/// Where a scenario is from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// It comes with the program, under this file name.
    Example(&'static str),
    /// A file.
    File(PathBuf),
}

/// A scenario in the list.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Where it is from.
    pub origin: Origin,
    /// Its name; that of its file where it is at fault.
    pub name: String,
    /// What it is for; what is wrong with it where it is at fault.
    pub description: String,
    /// What its exercise asks.
    pub asks: Option<String>,
    /// What is wrong with the back, or what its exercise hides.
    pub hides: Option<String>,
    /// The scenario; `None` where it is at fault.
    pub scenario: Option<Arc<Scenario>>,
    hash: u64,
}

impl Entry {
    fn of(origin: Origin, text: &str, folder: Option<&Path>) -> Self {
        let file = match &origin {
            Origin::Example(file) => (*file).to_owned(),
            Origin::File(path) => file_name(path),
        };
        let mut hasher = DefaultHasher::new();
        text.hash(&mut hasher);
        let hash = hasher.finish();
        match Scenario::parse(text, &file, folder) {
            Ok(scenario) => Self {
                origin,
                name: scenario.name.clone(),
                description: scenario.description.clone(),
                asks: asks(&scenario),
                hides: hides(&scenario),
                scenario: Some(Arc::new(scenario)),
                hash,
            },
            Err(e) => Self::at_fault(origin, file, e.to_string()),
        }
    }

    fn at_fault(origin: Origin, name: String, fault: String) -> Self {
        let mut hasher = DefaultHasher::new();
        fault.hash(&mut hasher);
        Self {
            origin,
            name,
            description: fault,
            asks: None,
            hides: None,
            scenario: None,
            hash: hasher.finish(),
        }
    }

    /// Which picture shows it: another number for another content, and for a picture that tells less.
    pub fn picture(&self, tells: bool) -> u64 {
        self.hash ^ u64::from(tells)
    }

    /// The name of its file.
    pub fn file(&self) -> String {
        match &self.origin {
            Origin::Example(file) => (*file).to_owned(),
            Origin::File(path) => file_name(path),
        }
    }

    /// Whether `filter` is part of what is told of it, in any case.
    pub fn fits(&self, filter: &str, tells: bool) -> bool {
        let filter = filter.trim().to_lowercase();
        let file = self.file();
        let told = [
            Some(&self.name),
            Some(&self.description),
            Some(&file),
            self.asks.as_ref(),
            self.hides.as_ref().filter(|_| tells),
        ];
        told.into_iter()
            .flatten()
            .any(|text| text.to_lowercase().contains(&filter))
    }
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

fn asks(scenario: &Scenario) -> Option<String> {
    let e = scenario.exercise.as_ref()?;
    let task = training::exercise::by_key(e.task).map_or(e.task, |task| task.title());
    let mut out = vec![task.to_owned()];
    if !e.candidates.is_empty() {
        out.push(format!("{} candidates", e.candidates.len()));
    }
    out.push(format!("{} trials", e.trials));
    if let Some(s) = &e.staircase {
        out.push(s.rule.to_owned());
    }
    Some(out.join(", "))
}

fn hides(scenario: &Scenario) -> Option<String> {
    if let Some(e) = &scenario.exercise
        && let Hides::Drawn { kind, change, .. } = &e.hides
    {
        let kind = scenario::dysfunction::named(kind).map_or(*kind, |k| k.title());
        return Some(format!("Hides {}, {change}", lower(kind)));
    }
    let all = &scenario.dysfunctions;
    if all.is_empty() {
        return None;
    }
    let title = |d: &scenario::Dysfunction| {
        let kind = d.kind().map_or(d.kind, |k| k.title());
        format!("{kind}, {}", d.place)
    };
    let mut out: Vec<String> = all.iter().take(NAMED).map(title).collect();
    if all.len() > NAMED {
        out.push(format!("and {} more", all.len() - NAMED));
    }
    Some(out.join("; "))
}

fn lower(text: &str) -> String {
    let mut chars = text.chars();
    chars
        .next()
        .map_or(String::new(), |c| c.to_lowercase().chain(chars).collect())
}

/// The examples and the scenarios of a folder.
#[derive(Clone, Debug, Default)]
pub struct Listing {
    /// Examples first, then files by name, those at fault last.
    pub entries: Vec<Entry>,
    /// Why the folder cannot be read, or what of it was left out.
    pub note: Option<String>,
}

impl Listing {
    /// Reads it all. Nothing when `go_on` says so.
    pub fn of(folder: &Path, go_on: &dyn Fn() -> bool) -> Option<Self> {
        let mut entries: Vec<Entry> = scenario::examples()
            .iter()
            .map(|example| Entry::of(Origin::Example(example.file), example.text, None))
            .collect();
        let (mut paths, mut note) = match files(folder) {
            Ok(paths) => (paths, None),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => (Vec::new(), None),
            Err(e) => (
                Vec::new(),
                Some(format!("{}: cannot be read: {e}", folder.display())),
            ),
        };
        if paths.len() > MOST_FILES {
            let n = paths.len();
            note = Some(format!("{MOST_FILES} of {n} files are listed"));
            paths.truncate(MOST_FILES);
        }
        let mut found = Vec::new();
        for path in paths {
            if !go_on() {
                return None;
            }
            found.push(read(path));
        }
        found.sort_by_key(|e| (e.scenario.is_none(), e.name.to_lowercase()));
        entries.extend(found);
        Some(Self { entries, note })
    }
}

/// The scenario files of a folder by name.
fn files(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let is_toml = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("toml"));
        if is_toml && path.is_file() {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

fn read(path: PathBuf) -> Entry {
    let name = file_name(&path);
    let fault = |what: String| format!("{name}: {what}");
    let bytes = std::fs::metadata(&path).map_or(0, |m| m.len());
    if bytes > MOST_BYTES {
        let what = fault(format!("{bytes} bytes; up to {MOST_BYTES} are read"));
        return Entry::at_fault(Origin::File(path), name, what);
    }
    match std::fs::read_to_string(&path) {
        Ok(text) => {
            let folder = path.parent().map(Path::to_owned);
            Entry::of(Origin::File(path), &text, folder.as_deref())
        }
        Err(e) => {
            let what = fault(format!("cannot be read: {e}"));
            Entry::at_fault(Origin::File(path), name, what)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn examples_and_files_are_listed_and_those_at_fault_last() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        let example = scenario::default_example();
        std::fs::write(at("b.toml"), example.text).expect("writes");
        std::fs::write(at("a.toml"), "format = 9\n").expect("writes");
        std::fs::write(at("c.toml"), [0xff, 0xfe]).expect("writes");
        std::fs::write(at("notes.txt"), "no scenario").expect("writes");
        std::fs::create_dir(at("d.toml")).expect("a folder");
        let listing = Listing::of(folder.path(), &|| true).expect("goes on");
        let n = scenario::examples().len();
        let files: Vec<_> = listing.entries[n..].iter().map(Entry::file).collect();
        assert_eq!(files, ["b.toml", "a.toml", "c.toml"]);
        let [good, bad, unread] = &listing.entries[n..] else {
            panic!("three");
        };
        assert!(good.scenario.is_some() && bad.scenario.is_none() && unread.scenario.is_none());
        assert!(bad.description.contains("a.toml: line 1"), "{bad:?}");
        for e in &listing.entries {
            assert!(!e.description.is_empty());
        }
        assert_eq!(good.picture(true), listing.entries[0].picture(true));
        assert_ne!(good.picture(true), good.picture(false));
        let missing = Listing::of(&at("nowhere"), &|| true).expect("goes on");
        assert_eq!((missing.entries.len(), missing.note), (n, None));
        assert!(Listing::of(folder.path(), &|| false).is_none());
    }

    #[test]
    fn what_is_hidden_is_no_ground_to_find_it_by_unless_it_may_be_told() {
        let text = "format = 1\nname = \"A\"\ndescription = \"b\"\n[surface]\nbuiltin = \"back\"\n[stiffness]\n\
                    constant_n_per_mm = 1\n[[dysfunction]]\nkind = \"hypertonic\"\nlevel = \"T5\"\nside = \"right\"\n\
                    [exercise]\ntask = \"locate\"\nhides = \"stated\"\ntrials = 20\n";
        let e = Entry::of(Origin::Example("a.toml"), text, None);
        assert_eq!(e.asks.as_deref(), Some("Locate, 20 trials"));
        assert!(e.fits("t5 RIGHT", true) && !e.fits("T5", false));
        assert!(e.fits("locate", false) && e.fits("", false) && !e.fits("zz", true));
    }
}
