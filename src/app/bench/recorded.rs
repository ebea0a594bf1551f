//! The recording that runs, those that were made, and those that are compared.

use super::Bench;
use super::recording::{self, Done};
use crate::app::messages::Level;
use crate::app::state::Compared;
use crate::session::RecorderState;
use std::path::{Path, PathBuf};
use std::sync::Arc;

impl Bench {
    pub(super) fn poll_recorder(&mut self) -> bool {
        let state = self.live.as_ref().map(|l| l.recorder().status().state);
        let failure = match &state {
            Some(RecorderState::Failed { reason }) => Some(reason.clone()),
            _ => None,
        };
        if failure != self.failure {
            self.failure.clone_from(&failure);
            if let Some(reason) = failure {
                self.tell(Level::Error, format!("recording stopped: {reason}"));
            }
        }
        match self.recordings.poll() {
            Some(Done::Started(path)) => {
                self.tell(Level::Info, format!("Recording to {}", path.display()));
            }
            Some(Done::Finished(summary)) => {
                self.tell(
                    Level::Info,
                    format!(
                        "Recorded {:.1} s, {} ticks, to {}",
                        summary.seconds,
                        summary.ticks,
                        summary.path.display()
                    ),
                );
                self.compress_finished(summary.path.clone());
                if summary.lost > 0 {
                    self.tell(
                        Level::Warning,
                        format!("{} records were lost", summary.lost),
                    );
                }
            }
            Some(Done::Quiet) => {}
            Some(Done::Copied(path)) => {
                self.tell(Level::Info, format!("Saved {}", path.display()));
            }
            Some(Done::Failed(text)) => self.tell(Level::Error, text),
            None => return matches!(state, Some(RecorderState::Recording { .. })),
        }
        true
    }

    /// Whether ticks are written to a file.
    pub fn is_recording(&self) -> bool {
        self.live
            .as_ref()
            .is_some_and(|l| matches!(l.recorder().status().state, RecorderState::Recording { .. }))
    }

    /// Begins a recording, or finishes the one that runs.
    pub fn toggle_recording(&mut self) {
        if self.exercise.is_some() {
            let text = "An exercise runs: each of its trials is recorded by itself";
            self.tell(Level::Warning, text);
            return;
        }
        if self.recordings.is_busy() {
            return;
        }
        let recording = self.is_recording();
        let (Some(live), Some(scene)) = (&self.live, &self.scene) else {
            self.tell(
                Level::Warning,
                "there is nothing to record yet: open a scene first",
            );
            return;
        };
        let recorder = live.recorder().clone();
        let started = if recording {
            self.recordings.stop(recorder).map_err(|e| e.to_string())
        } else {
            let header = recording::header(scene, live, self.edits.settled());
            self.recordings
                .start(recorder, header, scene.scenario.folder.clone())
                .map_err(|e| e.to_string())
        };
        if let Err(e) = started {
            self.tell(Level::Error, format!("cannot record: {e}"));
        }
    }

    /// Notes something in the recording that is being written.
    pub fn mark(&mut self, text: &str) {
        let noted = match &self.live {
            Some(live) if self.is_recording() => live.recorder().mark("mark", text.trim()),
            _ => {
                self.tell(
                    Level::Warning,
                    "There is no recording to mark: start one first",
                );
                return;
            }
        };
        if noted {
            self.tell(Level::Info, "Marked");
        } else {
            self.tell(
                Level::Warning,
                "The mark was not written: the recorder is behind",
            );
        }
    }

    /// Gives new recordings a pseudonym; none when empty.
    pub fn set_participant(&mut self, name: String) {
        self.recordings.set_participant(name);
    }

    /// The recording that "save as" means: the open one, else the newest.
    pub fn recording_to_save(&self) -> Option<PathBuf> {
        match &self.replay {
            Some(replay) => Some(replay.path().to_owned()),
            None => self.recordings.newest().map(Path::to_owned),
        }
    }

    /// Copies a recording.
    pub fn copy_recording(&mut self, from: &Path, to: &Path) {
        if let Err(e) = self.recordings.copy(from, to) {
            self.tell(
                Level::Error,
                format!("{}: cannot be written: {e}", to.display()),
            );
        }
    }

    /// Adds recordings to those that are compared; one that is there already has its tags anew.
    pub fn compare(&mut self, recordings: Vec<Compared>) {
        let compared = Arc::make_mut(&mut self.compared);
        for recording in recordings {
            match compared.iter_mut().find(|c| c.path == recording.path) {
                Some(there) => *there = recording,
                None => compared.push(recording),
            }
        }
    }

    /// Gives a recording its tags anew where it is compared.
    pub fn retag(&mut self, recording: Compared) {
        if self.compared.iter().any(|c| c.path == recording.path) {
            self.compare(vec![recording]);
        }
    }

    /// Takes a recording out of those that are compared.
    pub fn uncompare(&mut self, path: &Path) {
        Arc::make_mut(&mut self.compared).retain(|c| c.path != path);
    }

    /// Where recordings are kept.
    pub fn folder(&self) -> &Path {
        self.recordings.folder()
    }
}
