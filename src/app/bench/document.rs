//! The file of the open scene: saving what was edited, and keeping what was not saved.

use super::job::Job;
use super::{Bench, file_name};
use crate::app::messages::Level;
use crate::app::state::BuildStatus;
use crate::figure::write_files;
use crate::scenario::{Scenario, SurfaceChoice};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Folder beside the recordings where unsaved scenarios are kept.
const UNSAVED: &str = "unsaved";

/// The text of the open scene as it is in its file.
#[derive(Debug, Default)]
pub struct Document {
    /// The file; `None` for an example that comes with the program, or the scenario of a recording.
    path: Option<PathBuf>,
    saved: Arc<str>,
}

/// A scenario being written: the file and the text.
pub type Saving = Job<Result<(PathBuf, String), String>>;

impl Document {
    /// A scene that was just opened.
    pub fn opened(path: Option<PathBuf>, source: &str) -> Self {
        Self {
            path,
            saved: source.into(),
        }
    }
}

impl Bench {
    /// Whether the open scene was edited since it was opened or saved.
    pub fn is_edited(&self) -> bool {
        let scene = self.scene.as_ref();
        scene.is_some_and(|s| *s.scenario.source != *self.document.saved)
    }

    /// The open scene's text as in its file, or as it was opened where it has none.
    pub fn saved_text(&self) -> Option<Arc<str>> {
        self.scene.as_ref().map(|_| self.document.saved.clone())
    }

    /// The file that [`Self::save_scenario`] writes.
    pub fn scenario_path(&self) -> Option<&Path> {
        self.document.path.as_deref()
    }

    /// A name for the open scene's file where it has none yet, and the folder to begin with.
    pub fn suggested_file(&self) -> (Option<PathBuf>, String) {
        let folder = self.scene.as_ref().and_then(|s| s.scenario.folder.clone());
        let name = match (&self.document.path, &self.scene) {
            (Some(path), _) => file_name(path),
            (None, Some(scene)) => format!("{}.toml", stem(&scene.scenario.name)),
            (None, None) => "scenario.toml".into(),
        };
        (folder, name)
    }

    /// Writes the open scene to its file.
    pub fn save_scenario(&mut self) {
        let Some(path) = self.document.path.clone() else {
            self.tell(Level::Warning, "The scene has no file yet: save it as one");
            return;
        };
        let before = self.document.saved.clone();
        self.write_scenario(path, Some(before));
    }

    /// Writes the open scene to `path`, which is its file from then on. Another file that is there is replaced only if someone
    /// has said so.
    pub fn save_scenario_as(&mut self, path: PathBuf, replace: bool) {
        let path = match path.extension() {
            Some(_) => path,
            None => path.with_extension("toml"),
        };
        if Some(path.as_path()) == self.scenario_path() {
            self.save_scenario();
        } else if path.exists() && !replace {
            let what = "is there already; give another name";
            self.tell(Level::Error, format!("{}: {what}", path.display()));
        } else {
            self.write_scenario(path, None);
        }
    }

    /// `before`: what the file must still hold, else someone else has changed it.
    fn write_scenario(&mut self, path: PathBuf, before: Option<Arc<str>>) {
        let Some(scene) = &self.scene else {
            self.tell(
                Level::Warning,
                "There is nothing to save: open a scene first",
            );
            return;
        };
        let scenario = scene.scenario.clone();
        let work = move |_: super::job::Progress<'_>| {
            write(&scenario, &path, before.as_deref())?;
            Ok((path, scenario.source.clone()))
        };
        let status = BuildStatus::default();
        match Job::start("scenario writer", status, self.wake.clone(), work) {
            Ok(job) => self.saving = Some(job),
            Err(e) => self.tell(Level::Error, format!("the scenario cannot be saved: {e}")),
        }
    }

    pub(super) fn poll_saving(&mut self) -> bool {
        let lost = || Err("the scenario could not be saved".to_owned());
        let Some(outcome) = self.saving.as_ref().and_then(|job| job.poll(lost)) else {
            return false;
        };
        self.saving = None;
        match outcome {
            Ok((path, text)) => {
                self.tell(Level::Info, format!("Saved {}", path.display()));
                self.document = Document::opened(Some(path), &text);
            }
            Err(e) => self.tell(Level::Error, e),
        }
        true
    }

    /// Writes what was edited and not saved to a file of its own, before its scene is closed. `false` where that fails: then
    /// the scene should stay.
    pub(super) fn keep_unsaved(&mut self) -> bool {
        let Some(scene) = self.scene.clone().filter(|_| self.is_edited()) else {
            return true;
        };
        let folder = self.folder().join(UNSAVED);
        let now = crate::session::utc_now().replace(':', "-");
        let time = now.split('.').next().unwrap_or_default().replace('T', "_");
        let path = folder.join(format!("{time}_{}.toml", stem(&scene.scenario.name)));
        let written = std::fs::create_dir_all(&folder)
            .and_then(|()| write_files(&[(path.clone(), scene.scenario.source.clone().into())]));
        match written {
            Ok(()) => {
                let (name, path) = (&scene.scenario.name, path.display());
                let text = format!("Edits of \"{name}\" were not saved; they are kept in {path}");
                self.tell(Level::Warning, text);
                true
            }
            Err(e) => {
                let text = format!("{}: cannot be written: {e}", path.display());
                self.tell(Level::Error, text);
                false
            }
        }
    }
}

/// The name of a scenario as part of a file name.
fn stem(name: &str) -> String {
    let mut stem = String::new();
    for c in name.chars().take(60) {
        if c.is_ascii_alphanumeric() {
            stem.push(c.to_ascii_lowercase());
        } else if !stem.ends_with('_') {
            stem.push('_');
        }
    }
    match stem.trim_matches('_') {
        "" => "scenario".to_owned(),
        stem => stem.to_owned(),
    }
}

/// Writes a scenario whole or not at all.
fn write(scenario: &Scenario, path: &Path, before: Option<&str>) -> Result<(), String> {
    let told = |what: String| format!("{}: {what}", path.display());
    if let SurfaceChoice::Mesh { path: mesh, .. } = &scenario.surface {
        finds_its_mesh(scenario, mesh, path).map_err(told)?;
    }
    // The file itself, where a link leads to it.
    let file = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if let (Some(before), Ok(now)) = (before, std::fs::read_to_string(&file))
        && before != now
    {
        let what = "was changed by someone else since it was opened; save under another name";
        return Err(told(what.into()));
    }
    write_files(&[(file, scenario.source.clone().into())])
        .map_err(|e| told(format!("cannot be written: {e}")))
}

/// A mesh is looked for from the folder of its scenario: elsewhere the scenario would not find it, or another one.
fn finds_its_mesh(scenario: &Scenario, mesh: &Path, path: &Path) -> Result<(), String> {
    let from = |folder: Option<&Path>| {
        let folder = folder.filter(|f| !f.as_os_str().is_empty());
        folder
            .unwrap_or(Path::new("."))
            .join(mesh)
            .canonicalize()
            .ok()
    };
    let (here, there) = (from(scenario.folder.as_deref()), from(path.parent()));
    if here.is_some() && here == there {
        return Ok(());
    }
    let folder = scenario.folder.as_deref().unwrap_or(Path::new("."));
    Err(format!(
        "the scenario's mesh {} would not be found from there; save it in {}",
        mesh.display(),
        folder.display()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_mesh(folder: &Path) -> Scenario {
        let text = "format = 1\nname = \"A\"\n[surface]\nmesh = \"m/a.obj\"\nunits = \"mm\"\n\
                    [stiffness]\nconstant_n_per_mm = 1.0\n";
        Scenario::parse(text, "a.toml", Some(folder)).expect("good")
    }

    #[test]
    fn a_scenario_is_saved_only_where_it_finds_its_mesh() {
        let folder = tempfile::tempdir().expect("a folder");
        let here = folder.path();
        for sub in ["m", "other/m"] {
            std::fs::create_dir_all(here.join(sub)).expect("folders");
        }
        std::fs::write(here.join("m/a.obj"), "mesh").expect("writes");
        let scenario = on_mesh(here);
        write(&scenario, &here.join("b.toml"), None).expect("beside its mesh");
        let text = std::fs::read_to_string(here.join("b.toml")).expect("reads");
        assert_eq!(text, scenario.source);
        let there = here.join("other/b.toml");
        let error = write(&scenario, &there, None).expect_err("no mesh there");
        assert!(
            error.contains("m/a.obj") && !error.contains('\n'),
            "{error}"
        );
        // One of the same name is another mesh.
        std::fs::write(here.join("other/m/a.obj"), "mesh").expect("writes");
        assert!(write(&scenario, &there, None).is_err());
        assert!(!there.exists());
    }

    #[test]
    fn what_someone_else_wrote_is_not_overwritten() {
        let folder = tempfile::tempdir().expect("a folder");
        let here = folder.path();
        std::fs::create_dir(here.join("m")).expect("a folder");
        std::fs::write(here.join("m/a.obj"), "mesh").expect("writes");
        let (scenario, path) = (on_mesh(here), here.join("a.toml"));
        std::fs::write(&path, "as opened").expect("writes");
        write(&scenario, &path, Some("as opened")).expect("unchanged");
        let error = write(&scenario, &path, Some("as opened")).expect_err("changed");
        assert!(error.contains("someone else"), "{error}");
        std::fs::remove_file(&path).expect("removes");
        write(&scenario, &path, Some("as opened")).expect("gone is not changed");
    }

    #[test]
    fn names_suit_every_file_system() {
        assert_eq!(stem("T5 right, hypertonic"), "t5_right_hypertonic");
        assert_eq!(stem("../…/:"), "scenario");
    }
}
