//! What is asked of the recording that is replayed, and of those laid over it.

use super::{Bench, PURPOSE, replay};
use crate::app::messages::Level;
use crate::app::state::Alignment;
use std::path::{Path, PathBuf};

impl Bench {
    pub(super) fn poll_opening(&mut self) -> bool {
        let Some(opened) = self
            .opening
            .as_ref()
            .and_then(|o| o.poll(|| Err("the recording could not be read".into())))
        else {
            return false;
        };
        self.opening = None;
        match opened {
            Ok((replay, remarks)) => {
                for remark in remarks {
                    self.tell(Level::Warning, remark);
                }
                self.ghosts.remove(replay.path());
                self.replay = Some(replay);
                self.generation += 1;
            }
            Err(e) => {
                if self.replay.is_none() {
                    self.ghosts.clear();
                }
                self.tell(Level::Error, e);
            }
        }
        true
    }

    pub(super) fn poll_ghosts(&mut self) -> bool {
        if self.ghosts.is_empty() {
            return false;
        }
        let told = self.ghosts.poll(&self.wake);
        for opened in &told {
            match opened {
                Ok(name) => self.tell(Level::Info, format!("{name} is overlaid")),
                Err(e) => self.tell(Level::Error, e.as_str()),
            }
        }
        !told.is_empty()
    }

    /// Reads a recording and replays it.
    pub fn open_recording(&mut self, path: PathBuf) {
        if self.is_blind() {
            let text = "An exercise runs: end it before you open a recording";
            self.tell(Level::Warning, text);
            return;
        }
        let opening = replay::open(path, self.scene.clone(), PURPOSE, self.wake.clone());
        match opening {
            Ok(opening) => self.opening = Some(opening),
            Err(e) => self.tell(Level::Error, format!("the reader cannot start: {e}")),
        }
    }

    /// Shows the fingers as they are now.
    pub fn close_recording(&mut self) {
        self.ghosts.clear();
        if self.replay.take().is_some() {
            self.generation += 1;
        }
    }

    /// Overlays recordings on the one that is replayed.
    pub fn add_ghosts(&mut self, paths: Vec<PathBuf>) {
        if self.replay.is_none() && self.opening.is_none() {
            let text = "Open a recording first: ghosts move with its time";
            self.tell(Level::Warning, text);
            return;
        }
        for path in paths {
            if let Err(e) = self.ghosts.add(path, &self.wake) {
                self.tell(Level::Warning, e);
                return;
            }
        }
    }

    /// Takes a ghost away.
    pub fn remove_ghost(&mut self, path: &Path) {
        self.ghosts.remove(path);
    }

    /// Shows a ghost later, s, or earlier.
    pub fn set_ghost_offset(&mut self, path: &Path, offset_s: f64) {
        self.ghosts.set_offset(path, offset_s);
    }

    /// What makes the times of the ghosts that of the open recording.
    pub fn align_ghosts(&mut self, alignment: Alignment) {
        self.ghosts.align(alignment);
    }

    /// Pauses at each event of the open recording, or plays past them.
    pub fn set_following(&mut self, on: bool) {
        if let Some(replay) = &mut self.replay {
            replay.playback().set_follow(on);
        }
    }

    /// Goes to the next event of the open recording, or to the one before.
    pub fn seek_event(&mut self, next: bool) {
        if let Some(replay) = &mut self.replay {
            let playback = replay.playback();
            playback.pause();
            let _ = if next {
                playback.seek_next_event()
            } else {
                playback.seek_previous_event()
            };
        }
    }

    /// Goes to a time of the open recording, s.
    pub fn seek(&mut self, time_s: f64) {
        if let Some(replay) = &mut self.replay {
            replay.playback().seek_s(time_s);
        }
    }

    /// Lets time of the open recording run or stand.
    pub fn set_playing(&mut self, on: bool) {
        if let Some(replay) = &mut self.replay {
            let playback = replay.playback();
            if on {
                playback.play();
            } else {
                playback.pause();
            }
        }
    }

    /// Lets time of the open recording run, or stand if it runs.
    pub fn play_or_pause(&mut self) {
        if let Some(replay) = &mut self.replay {
            replay.playback().toggle();
        }
    }

    /// Replays at this speed, 1 is real time.
    pub fn set_speed(&mut self, speed: f64) {
        if let Some(replay) = &mut self.replay {
            replay.playback().set_speed(speed);
        }
    }

    /// Starts over at the end, or stays there.
    pub fn set_looped(&mut self, on: bool) {
        if let Some(replay) = &mut self.replay {
            replay.playback().set_looping(on);
        }
    }

    /// Goes some ticks on, or back.
    pub fn step(&mut self, ticks: i64) {
        if let Some(replay) = &mut self.replay {
            replay.playback().step(ticks);
        }
    }
}
