//! Scenes that are opened, built and shown.

use super::builder::{self, Built, Source};
use super::document::Document;
use super::live::Live;
use super::{Bench, PURPOSE, Ready};
use crate::app::messages::Level;
use crate::scenario::{self, BuildError, Use};

/// Defects of a mesh that are told one by one.
const DEFECTS_TOLD: usize = 5;

impl Bench {
    /// Starts building a scene; one that is being built is cancelled.
    pub fn open(&mut self, source: Source) {
        if self.is_blind() {
            let text = "An exercise runs: end it before you open another scene";
            self.tell(Level::Warning, text);
            return;
        }
        let path = match &source {
            Source::File(path) => Some(path.clone()),
            Source::Example(_) | Source::Text { .. } => None,
        };
        match builder::build(source, self.purpose(), self.wake.clone()) {
            Ok(build) => (self.build, self.building_from) = (Some(build), path),
            Err(e) => self.tell(Level::Error, format!("the builder cannot start: {e}")),
        }
    }

    /// What a scene is built for at this moment: what is open and what is asked for.
    pub(super) fn purpose(&self) -> Use {
        Use {
            drawn: self.drawn,
            deformed: self.drawn,
            ..PURPOSE
        }
    }

    /// Opens an embedded example by its file name.
    pub fn open_example(&mut self, file: &str) {
        match scenario::examples().iter().find(|e| e.file == file) {
            Some(example) => self.open(Source::Example(*example)),
            None => self.tell(Level::Error, format!("there is no example named {file}")),
        }
    }

    /// Stops building.
    pub fn cancel_build(&mut self) {
        if let Some(build) = &self.build {
            build.cancel();
        }
        if let Some(opening) = &self.opening {
            opening.cancel();
        }
        self.rewriting.cancel();
    }

    pub(super) fn poll_build(&mut self) -> bool {
        let Some(build) = &self.build else {
            return false;
        };
        let Some(result) =
            build.poll(|| Err(BuildError("the builder stopped unexpectedly".into())))
        else {
            return false;
        };
        let cancelled = build.is_cancelled();
        self.build = None;
        match result {
            Ok(built) => {
                let opened = Some(self.building_from.take());
                self.ready = Some(Ready { built, opened });
            }
            Err(e) if cancelled || e.0 == BuildError::CANCELLED => {
                self.tell(Level::Info, "Building was cancelled");
            }
            Err(e) => self.tell(Level::Error, e.0),
        }
        true
    }

    /// A recording holds one scene, or it could not be repeated: it is finished before the next scene is felt.
    pub(super) fn poll_ready(&mut self) -> bool {
        if self.ready.is_none() {
            return false;
        }
        if self.is_recording() && !self.recordings.is_busy() {
            self.tell(Level::Info, "The recording ends with its scene");
            self.toggle_recording();
        }
        if !self.is_recording()
            && !self.recordings.is_busy()
            && self.saving.is_none()
            && let Some(ready) = self.ready.take()
        {
            match ready.opened {
                Some(path) if self.keep_unsaved() => {
                    self.document = Document::opened(path, &ready.built.scene.scenario.source);
                    self.generation += 1;
                    self.set_scene(ready.built);
                }
                Some(_) => {}
                // The same document: who edits it goes on.
                None => self.set_scene(ready.built),
            }
        }
        true
    }

    pub(super) fn set_scene(&mut self, built: Built) {
        self.close_exercise();
        let Built { scene, blind } = built;
        if let Some(units) = &scene.mesh_units {
            self.tell(Level::Info, format!("{}: {units}", scene.mesh_origin));
        }
        let defects = &scene.report.defects;
        for defect in defects.iter().take(DEFECTS_TOLD) {
            self.tell(Level::Warning, format!("{}: {defect}", scene.mesh_origin));
        }
        if let Some(more) = defects.len().checked_sub(DEFECTS_TOLD + 1) {
            let text = format!("{}: and {} more defects", scene.mesh_origin, more + 1);
            self.tell(Level::Warning, text);
        }
        let felt = blind.as_ref().filter(|_| self.conceals).unwrap_or(&scene);
        match &mut self.live {
            Some(live) => live.set_scene(felt),
            None => match Live::start(felt, self.force_enabled) {
                Ok(live) => self.live = Some(live),
                Err(e) => self.tell(Level::Error, format!("the servo cannot start: {e}")),
            },
        }
        self.edits.begin(&scene);
        (self.scene, self.blind) = (Some(scene), blind);
        // A view may have opened or closed while it was built.
        self.start_edit();
    }
}
