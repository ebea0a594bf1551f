//! A recording on show: read, its scene built and its plots filled on a thread of their own.

use super::Wake;
use super::edit::edited;
use super::file_name;
use super::job::Job;
use crate::app::history::History;
use crate::app::state::{BuildStatus, PlaybackStatus};
use crate::scenario::{self, Scenario, Scene, Use};
use crate::servo::FingerRecord;
use crate::session::{MeshSource, Playback, Recording, Session, reader::Strictness};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// A recording that is open.
pub struct Replay {
    path: PathBuf,
    playback: Playback<Arc<Recording>>,
    /// The scene of the header.
    first: Option<Arc<Scene>>,
    /// The scene of the present instant, and the edit that made it.
    scene: Option<Arc<Scene>>,
    edit: u32,
    /// The edit whose scene is being built, or could not be.
    build: Option<(u32, Job<Result<Scene, String>>)>,
    refused: Option<u32>,
    scenes_shown: u64,
    history: Arc<Mutex<History>>,
}

/// What reading a recording came to: the recording, and what is to be said about it.
pub type Opened = Result<(Replay, Vec<String>), String>;

/// A recording that is being read.
pub type Opening = Job<Opened>;

/// Starts reading `path`. `open` is the scene that is open: it serves if it is the recorded one.
///
/// # Errors
/// When the system refuses another thread.
pub fn open(
    path: PathBuf,
    open: Option<Arc<Scene>>,
    purpose: Use,
    wake: Wake,
) -> std::io::Result<Opening> {
    let status = BuildStatus {
        scenario: file_name(&path),
        part: "recording".into(),
        fraction: 0.0,
    };
    Job::start("replay reader", status, wake, move |progress| {
        read(&path, open, purpose, progress)
    })
}

fn read(
    path: &Path,
    open: Option<Arc<Scene>>,
    purpose: Use,
    progress: &mut dyn FnMut(&str, f64) -> bool,
) -> Opened {
    let session = Session::open(path).map_err(|e| e.to_string())?;
    // A recording that was cut off is worth seeing as far as it goes; what is missing is said.
    let recording = session
        .load(Strictness::Lenient)
        .map_err(|e| e.to_string())?;
    if recording.fingers.iter().all(Vec::is_empty) {
        return Err(format!("{}: the recording holds no tick", path.display()));
    }
    let mut remarks = Vec::new();
    if !recording.damage.is_none() {
        remarks.push(format!(
            "{}: damaged; what can be read is shown. {}",
            path.display(),
            recording.damage.first
        ));
    }
    let header = &recording.header;
    if header.sealed {
        let what = "a trial that was not answered; it is shown without what was hidden in it";
        remarks.push(format!("{}: {what}", path.display()));
    }
    let scene = match open.filter(|s| s.scenario.source == header.scenario_toml) {
        Some(scene) if scene.fits(purpose) => Some(scene),
        Some(scene) => {
            let drawn = scenario::rebuild(&scene, scene.scenario.clone(), purpose);
            Some(Arc::new(drawn.map_err(|e| e.to_string())?))
        }
        None => match rebuild(path, &header.scenario_toml, purpose, progress) {
            Ok(scene) => Some(Arc::new(scene)),
            Err(e) => {
                remarks.push(format!("the recorded scene cannot be built: {e}"));
                None
            }
        },
    };
    if let Some(scene) = &scene
        && MeshSource::new(&scene.surface, &scene.mesh_origin).hash != header.mesh.hash
    {
        remarks.push(format!(
            "{}: recorded on another mesh than {} is now; what is drawn may not fit",
            path.display(),
            header.mesh.origin
        ));
    }
    let history = history_of(&recording);
    let edit = recording.header.edit;
    let mut playback = Playback::new(Arc::new(recording));
    playback.play();
    Ok((
        Replay {
            path: path.to_owned(),
            playback,
            first: scene.clone(),
            scene,
            edit,
            build: None,
            refused: None,
            scenes_shown: 0,
            history: Arc::new(Mutex::new(history)),
        },
        remarks,
    ))
}

fn rebuild(
    path: &Path,
    toml: &str,
    purpose: Use,
    progress: &mut dyn FnMut(&str, f64) -> bool,
) -> Result<Scene, String> {
    let origin = format!("scenario in {}", file_name(path));
    let scenario = Scenario::parse(toml, &origin, path.parent()).map_err(|e| e.to_string())?;
    scenario::build(Arc::new(scenario), purpose, progress).map_err(|e| e.to_string())
}

/// The whole recording as plots, from time zero.
fn history_of(recording: &Recording) -> History {
    let mut history = History::new(recording.header.rate_hz);
    let firsts = recording.fingers.iter().filter_map(|f| f.first());
    let start_ns = firsts.map(|r| r.time_ns).min().unwrap_or(0);
    for record in recording.fingers.iter().flatten() {
        history.push(&FingerRecord {
            time_ns: record.time_ns.saturating_sub(start_ns),
            ..*record
        });
    }
    history
}

impl Replay {
    /// For the window.
    pub fn status(&self) -> PlaybackStatus {
        PlaybackStatus {
            path: self.path.clone(),
            time_s: self.playback.at_s(),
            duration_s: self.playback.duration_s(),
            playing: self.playback.is_playing(),
            speed: self.playback.speed(),
            looped: self.playback.is_looping(),
        }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The fingers at the present instant.
    pub fn fingers(&self) -> Vec<FingerRecord> {
        self.playback.at().fingers().to_vec()
    }

    /// Goes over to the scene of the present instant, which is built beside the window. Answers whether there is another one
    /// now, and what is to be said about one that cannot be had.
    pub fn follow_edits(&mut self, wake: &Wake) -> (bool, Option<String>) {
        let (Some(first), Some(scene)) = (&self.first, &self.scene) else {
            return (false, None);
        };
        let wanted = self.playback.at().fingers[0].edit;
        let lost = || Err("the builder stopped unexpectedly".to_owned());
        let built = self
            .build
            .as_ref()
            .and_then(|(n, job)| Some((*n, job.poll(lost)?)));
        if let Some((number, outcome)) = built {
            self.build = None;
            return match outcome {
                Ok(scene) => {
                    self.show(number, Arc::new(scene));
                    (true, None)
                }
                Err(reason) => {
                    self.refused = Some(number);
                    let path = self.path.display();
                    let text =
                        format!("{path}: the scene after edit {number} cannot be shown: {reason}");
                    (false, Some(text))
                }
            };
        }
        if wanted == self.edit || self.build.is_some() || self.refused == Some(wanted) {
            return (false, None);
        }
        let recording = self.playback.source();
        if wanted == recording.header.edit {
            let first = Arc::clone(first);
            self.show(wanted, first);
            return (true, None);
        }
        let source = recording.scenario_after(wanted).map(str::to_owned);
        let old = Arc::clone(scene);
        let work = move |_: super::job::Progress<'_>| {
            let source = source.ok_or("the file does not hold what was edited")?;
            edited(&old, &source, super::PURPOSE).map_err(|e| e.to_string())
        };
        match Job::start("replay editor", BuildStatus::default(), wake.clone(), work) {
            Ok(job) => {
                self.build = Some((wanted, job));
                (false, None)
            }
            Err(e) => {
                self.refused = Some(wanted);
                (
                    false,
                    Some(format!("the recorded edit cannot be shown: {e}")),
                )
            }
        }
    }

    fn show(&mut self, edit: u32, scene: Arc<Scene>) {
        (self.edit, self.scene, self.refused) = (edit, Some(scene), None);
        self.scenes_shown += 1;
    }

    /// Counts the scenes shown, one after the other.
    pub fn scenes_shown(&self) -> u64 {
        self.scenes_shown
    }

    /// The recorded scene at the present instant, where it could be built.
    pub fn scene(&self) -> Option<&Arc<Scene>> {
        self.scene.as_ref()
    }

    /// The whole recording as plots.
    pub fn history(&self) -> &Arc<Mutex<History>> {
        &self.history
    }

    /// The value that moves through time.
    pub fn playback(&mut self) -> &mut Playback<Arc<Recording>> {
        &mut self.playback
    }
}
