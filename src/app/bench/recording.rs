//! The recorder as the bench uses it: starting and finishing a file may wait for the disk, so each is a job of its own.

use super::edit::EditText;
use super::live::Live;
use crate::app::state::{RecentFile, RecorderStatus};
use crate::scenario::Scene;
use crate::session::recorder::{RecorderHandle, RecorderState};
use crate::session::{
    self, DeviceInfo, Extras, Header, MeshSource, RecordingSummary, SessionError,
};
use std::path::{Path, PathBuf};
use std::sync::{Arc, mpsc};
use std::time::Duration;

/// Recordings listed.
const LISTED: usize = 20;

/// Longest wait for the disk on the way out.
const PATIENCE: Duration = Duration::from_secs(10);

/// What the file of a trial goes through.
pub enum Tape {
    /// Is begun, with what it says of itself until its trial is answered, and the folder of its scenario.
    Begin(PathBuf, Box<Header>, Option<PathBuf>),
    /// Is held, or goes on.
    Hold(bool),
    /// Is finished, with what was felt in truth where that may be said.
    Finish(Option<Box<Header>>),
}

/// What a job of the recorder came to.
pub enum Done {
    /// Something of which nobody need hear.
    Quiet,
    /// A file was begun.
    Started(PathBuf),
    /// A file was finished.
    Finished(RecordingSummary),
    /// A file was copied.
    Copied(PathBuf),
    /// It did not work: what was wanted, and why not.
    Failed(String),
}

/// Recordings of the bench: the folder, the list, the job under way.
pub struct Recordings {
    folder: PathBuf,
    recent: Vec<RecentFile>,
    finished: u64,
    participant: String,
    job: Option<mpsc::Receiver<Done>>,
}

impl Recordings {
    /// Recordings kept in `folder`, which need not exist yet.
    pub fn new(folder: PathBuf) -> Self {
        let mut recordings = Self {
            folder,
            recent: Vec::new(),
            finished: 0,
            participant: String::new(),
            job: None,
        };
        recordings.list();
        recordings
    }

    /// Where they are kept.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Gives new recordings a pseudonym; none when empty.
    pub fn set_participant(&mut self, name: String) {
        self.participant = name;
    }

    /// The newest.
    pub fn newest(&self) -> Option<&Path> {
        self.recent.first().map(|f| f.path.as_path())
    }

    /// Looks at the folder again after something else wrote there.
    pub fn list_again(&mut self) {
        self.finished += 1;
        self.list();
    }

    /// Looks at the folder again.
    pub fn list(&mut self) {
        let mut files: Vec<(String, RecentFile)> = std::fs::read_dir(&self.folder)
            .into_iter()
            .flatten()
            .flatten()
            .map(|entry| (entry.path(), entry.metadata()))
            .filter(|(path, _)| path.extension().is_some_and(|e| e == "mcap"))
            .filter_map(|(path, meta)| {
                let bytes = meta.ok()?.len();
                Some((super::file_name(&path), RecentFile { path, bytes }))
            })
            .collect();
        // Names begin with the time of recording.
        files.sort_by(|a, b| b.0.cmp(&a.0));
        files.truncate(LISTED);
        self.recent = files.into_iter().map(|(_, file)| file).collect();
    }

    /// Begins a new file; `beside` is the folder of the scenario, where its mesh lies.
    ///
    /// # Errors
    /// The folder cannot be made, or the system refuses another thread.
    pub fn start(
        &mut self,
        recorder: Arc<RecorderHandle>,
        mut header: Header,
        beside: Option<PathBuf>,
    ) -> Result<(), SessionError> {
        let participant = self.participant.trim();
        if !participant.is_empty() {
            header.participant = Some(participant.to_owned());
        }
        let folder = self.folder.clone();
        let io = |source| SessionError::Io {
            path: folder.clone(),
            source,
        };
        std::fs::create_dir_all(&self.folder).map_err(io)?;
        let path = self.folder.join(recording_name(&header));
        self.run(
            move || match begin(&recorder, &path, header, beside.as_deref()) {
                Ok(()) => Done::Started(path),
                Err(e) => Done::Failed(format!("cannot record: {e}")),
            },
        )
        .map_err(io)
    }

    /// Finishes the file.
    ///
    /// # Errors
    /// The system refuses another thread.
    pub fn stop(&mut self, recorder: Arc<RecorderHandle>) -> std::io::Result<()> {
        self.run(move || match recorder.stop() {
            Ok(summary) => Done::Finished(summary),
            Err(e) => Done::Failed(format!("the recording did not finish: {e}")),
        })
    }

    /// Does something with the file of a trial.
    ///
    /// # Errors
    /// The system refuses another thread.
    pub fn wind(&mut self, recorder: Arc<RecorderHandle>, tape: Tape) -> std::io::Result<()> {
        self.run(move || {
            let wound = match tape {
                Tape::Begin(path, header, beside) => {
                    begin(&recorder, &path, *header, beside.as_deref())
                }
                Tape::Hold(hold) => recorder.hold(hold),
                Tape::Finish(truth) => {
                    let revealed = truth.map_or(Ok(()), |truth| recorder.reveal(*truth));
                    revealed.and(recorder.stop().map(drop))
                }
            };
            match wound {
                Ok(()) => Done::Quiet,
                Err(e) => Done::Failed(format!("the trial is not recorded: {e}")),
            }
        })
    }

    /// Copies a recording; a file that is there already stays as it is.
    ///
    /// # Errors
    /// The system refuses another thread.
    pub fn copy(&mut self, from: &Path, to: &Path) -> std::io::Result<()> {
        let (from, to) = (from.to_owned(), to.to_owned());
        self.run(move || match copy_over(&from, &to) {
            Ok(()) => Done::Copied(to),
            Err(e) => Done::Failed(format!("{}: cannot be written: {e}", to.display())),
        })
    }

    fn run(&mut self, job: impl FnOnce() -> Done + Send + 'static) -> std::io::Result<()> {
        let (send, receive) = mpsc::sync_channel(1);
        std::thread::Builder::new()
            .name("recording".into())
            .spawn(move || {
                let _ = send.send(job());
            })?;
        self.job = Some(receive);
        Ok(())
    }

    /// Whether a file is being begun, finished or copied.
    pub fn is_busy(&self) -> bool {
        self.job.is_some()
    }

    /// Waits for the job under way, as long as the recorder itself is patient with a slow disk.
    pub fn wait(&mut self) {
        if let Some(job) = self.job.take() {
            let _ = job.recv_timeout(PATIENCE);
        }
    }

    /// What the job under way came to, once it is done.
    pub fn poll(&mut self) -> Option<Done> {
        let done = match self.job.as_ref()?.try_recv() {
            Ok(done) => done,
            Err(mpsc::TryRecvError::Empty) => return None,
            Err(mpsc::TryRecvError::Disconnected) => {
                Done::Failed("the recorder stopped unexpectedly".into())
            }
        };
        self.job = None;
        self.finished += u64::from(!matches!(done, Done::Started(_) | Done::Failed(_)));
        self.list();
        Some(done)
    }

    /// For the window.
    pub fn status(&self, live: Option<&Live>) -> RecorderStatus {
        let recorder = live.map(|l| l.recorder().status()).unwrap_or_default();
        RecorderStatus {
            recording: match recorder.state {
                RecorderState::Recording { path } => Some(path),
                RecorderState::Idle | RecorderState::Failed { .. } => None,
            },
            time_s: recorder.seconds,
            bytes: recorder.bytes,
            lost: recorder.lost,
            held_bytes: recorder.held_bytes,
            finished: self.finished,
            participant: self.participant.clone(),
            failed: None,
            compresses: false,
            recent: self.recent.clone(),
            folder: self.folder.clone(),
        }
    }
}

/// Replacing is allowed: the dialog that gave `to` has asked.
fn copy_over(from: &Path, to: &Path) -> std::io::Result<()> {
    let same = std::fs::canonicalize(from)? == std::fs::canonicalize(to).unwrap_or_default();
    if same {
        return Err(std::io::Error::other("it is the recording itself"));
    }
    std::fs::copy(from, to).map(|_| ())
}

/// A file name that sorts by time and tells the scenario: `2031-05-17_09-30-00_t5-right.mcap`.
fn recording_name(header: &Header) -> String {
    let time: String = header
        .started_utc
        .chars()
        .take(19)
        .map(|c| match c {
            'T' => '_',
            ':' => '-',
            c => c,
        })
        .collect();
    let mut name = String::new();
    for c in header.scenario_name.chars().take(40) {
        if c.is_ascii_alphanumeric() {
            name.push(c.to_ascii_lowercase());
        } else if !name.ends_with('-') {
            name.push('-');
        }
    }
    let name = name.trim_matches('-');
    if name.is_empty() {
        format!("{time}.mcap")
    } else {
        format!("{time}_{name}.mcap")
    }
}

/// Begins a file that carries the mesh it is felt on, where that is not built in.
fn begin(
    recorder: &RecorderHandle,
    path: &Path,
    header: Header,
    beside: Option<&Path>,
) -> Result<(), SessionError> {
    let machine = Extras::of_this_machine();
    let with_mesh = machine.clone().with_mesh_of(&header.mesh.origin, beside);
    recorder.carry(with_mesh.unwrap_or_else(|e| {
        // What is felt is recorded even so; its hash names the mesh that a replay needs.
        log::warn!("the recording goes without its mesh: {e}");
        machine
    }));
    recorder.start(path, header)
}

/// What a recording of `scene` on `live` says about itself; `felt` is the newest edit that is wholly felt.
pub fn header(scene: &Scene, live: &Live, felt: &EditText) -> Header {
    Header {
        scenario_toml: felt.1.to_string(),
        scenario_name: scene.scenario.name.clone(),
        mesh: MeshSource::new(&scene.surface, &scene.mesh_origin),
        devices: live
            .devices()
            .map(|(name, limits)| DeviceInfo::new(name, limits))
            .collect(),
        rate_hz: live.rate_hz(),
        build: session::build_id(),
        started_utc: session::utc_now(),
        participant: None,
        edit: felt.0,
        sealed: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(name: &str) -> Header {
        Header {
            scenario_toml: String::new(),
            scenario_name: name.into(),
            mesh: MeshSource {
                hash: String::new(),
                origin: String::new(),
                triangles: 0,
            },
            devices: Vec::new(),
            rate_hz: 1000.0,
            build: String::new(),
            started_utc: "2031-05-17T09:30:00.125Z".into(),
            participant: None,
            edit: 0,
            sealed: false,
        }
    }

    #[test]
    fn names_sort_by_time_and_suit_every_file_system() {
        assert_eq!(
            recording_name(&header("T5 right, hypertonic")),
            "2031-05-17_09-30-00_t5-right-hypertonic.mcap"
        );
        assert_eq!(
            recording_name(&header("../…/:")),
            "2031-05-17_09-30-00.mcap"
        );
    }

    #[test]
    fn the_list_is_newest_first_and_a_missing_folder_is_empty() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(
            Recordings::new(folder.path().join("none"))
                .newest()
                .is_none()
        );
        for name in ["2030_a.mcap", "2031_b.mcap", "note.txt"] {
            std::fs::write(folder.path().join(name), b"x").expect("writes");
        }
        let recordings = Recordings::new(folder.path().to_owned());
        assert_eq!(
            recordings.newest(),
            Some(folder.path().join("2031_b.mcap").as_path())
        );
        assert_eq!(recordings.recent.len(), 2);
    }

    #[test]
    fn a_recording_is_never_copied_onto_itself() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.mcap");
        std::fs::write(&path, b"ticks").expect("writes");
        assert!(copy_over(&path, &path).is_err());
        assert_eq!(std::fs::read(&path).expect("reads"), b"ticks");
        copy_over(&path, &folder.path().join("b.mcap")).expect("copies");
    }
}
