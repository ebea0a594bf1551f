//! A recording on show: opened by its index, its scene built and its plots filled on threads of their own.

use super::Wake;
use super::edit::edited;
use super::file_name;
use super::job::Job;
use super::past::Past;
use crate::app::history::History;
use crate::app::state::{BuildStatus, PlaybackStatus, RecordedEvent};
use crate::scenario::{self, Scenario, Scene, Use};
use crate::servo::FingerRecord;
use crate::session::{MeshSource, Playback, Session, Timeline};
use crate::units::s_from_ns;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// A recording that is open.
pub struct Replay {
    path: PathBuf,
    playback: Playback,
    /// The scene of the header.
    first: Option<Arc<Scene>>,
    /// The scene of the present instant, and the edit that made it.
    scene: Option<Arc<Scene>>,
    edit: u32,
    /// The edit whose scene is being built, or could not be.
    build: Option<(u32, Job<Result<Scene, String>>)>,
    refused: Option<u32>,
    scenes_shown: u64,
    past: Past,
    events: Arc<[RecordedEvent]>,
    damage: Option<String>,
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
    let own = wake.clone();
    Job::start("replay reader", status, wake, move |progress| {
        read(&path, open, purpose, &own, progress)
    })
}

fn read(
    path: &Path,
    open: Option<Arc<Scene>>,
    purpose: Use,
    wake: &Wake,
    progress: &mut dyn FnMut(&str, f64) -> bool,
) -> Opened {
    let mut watch = |share: f64| progress("index of the recording", share);
    let timeline = Timeline::open_watched(path, &mut watch).map_err(|e| e.to_string())?;
    if timeline.n_ticks() == 0 {
        return Err(format!("{}: the recording holds no tick", path.display()));
    }
    let mut remarks = Vec::new();
    // A recording that was cut off is worth seeing as far as it goes; what is missing is said.
    let damage = (!timeline.damage().is_none()).then(|| timeline.damage().first.clone());
    if let Some(what) = &damage {
        remarks.push(format!(
            "{}: damaged; what can be read is shown. {what}",
            path.display(),
        ));
    }
    let header = timeline.header();
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
    let edit = header.edit;
    let past = Past::of(&timeline, wake);
    let events = events_of(&timeline);
    let mut playback = Playback::new(timeline);
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
            past,
            events,
            damage,
        },
        remarks,
    ))
}

/// What happened in it, by time since its start.
fn events_of(timeline: &Timeline) -> Arc<[RecordedEvent]> {
    let (first_ns, last_ns) = timeline.span_ns();
    let event = |e: &crate::session::Event| RecordedEvent {
        time_s: s_from_ns(e.time_ns.clamp(first_ns, last_ns) - first_ns),
        kind: e.kind.clone(),
        text: e.text.clone(),
    };
    timeline.events().iter().map(event).collect()
}

fn rebuild(
    path: &Path,
    toml: &str,
    purpose: Use,
    progress: &mut dyn FnMut(&str, f64) -> bool,
) -> Result<Scene, String> {
    let origin = format!("scenario in {}", file_name(path));
    // The mesh may have travelled along, if it is not beside the recording.
    let session = Session::open(path).map_err(|e| e.to_string())?;
    let folder = session.folder().map_err(|e| e.to_string())?;
    let scenario =
        Scenario::parse(toml, &origin, Some(folder.path())).map_err(|e| e.to_string())?;
    scenario::build(Arc::new(scenario), purpose, progress).map_err(|e| e.to_string())
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
            following: self.playback.is_following(),
            events: self.events.clone(),
            plotted: self.past.progress(),
            damage: self.damage.clone(),
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
        if wanted == recording.header().edit {
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
        self.past.history()
    }

    /// When a finger first touched the skin, s; `None` until that is read.
    pub fn first_contact_s(&self) -> Option<f64> {
        self.past.first_contact_s()
    }

    /// Takes over what was read for the plots; answers whether there is more to see.
    pub fn follow_past(&mut self) -> bool {
        let at_s = self.playback.at_s();
        self.past.follow(at_s)
    }

    /// The value that moves through time.
    pub fn playback(&mut self) -> &mut Playback {
        &mut self.playback
    }
}
