//! The tree under study with its numbers, and how it is built beside the window.

use super::settings::Choice;
use crate::app::bench::Wake;
use crate::app::bench::job::Job;
use crate::app::state::BuildStatus;
use crate::geom::Vec3;
use crate::partition::tree::{Statistics, Tree};
use crate::partition::{Partition as _, Structure};
use crate::scenario::Scene;
use crate::surface::Surface;
use std::sync::Arc;
use std::time::Instant;

/// A finished tree and what was found out about it.
#[derive(Debug)]
pub struct Built {
    /// What it was built over.
    pub surface: Arc<Surface>,
    /// How it was grown.
    pub choice: Choice,
    /// The structure: one with a tree.
    structure: Structure,
    /// Counts over it.
    pub statistics: Statistics,
    /// What building took, µs; counting and checking not included.
    pub build_us: f64,
    /// What is not well formed; `None` when the check after the build found nothing.
    pub fault: Option<String>,
}

impl Built {
    /// Builds, counts and checks. `progress` hears what is done and a fraction; `None` when it answers `false`.
    pub fn new(
        surface: Arc<Surface>,
        choice: Choice,
        progress: &mut dyn FnMut(&str, f64) -> bool,
    ) -> Option<Self> {
        let start = Instant::now();
        let structure = Structure::build(
            choice.kind.name(),
            &surface,
            &choice.options(),
            &mut |fraction| progress("dealing out triangles", fraction),
        )
        .ok()
        .flatten()?;
        let build_us = start.elapsed().as_secs_f64() * 1e6;
        if !progress("counting", 1.0) {
            return None;
        }
        let statistics = structure.statistics(&surface)?;
        if !progress("checking", 1.0) {
            return None;
        }
        let fault = structure.partition().validate(&surface).err();
        Some(Self {
            surface,
            choice,
            structure,
            statistics,
            build_us,
            fault,
        })
    }

    /// What answers queries.
    pub fn structure(&self) -> &Structure {
        &self.structure
    }

    /// The nodes; every kind that can be chosen has some.
    pub fn tree(&self) -> Option<&Tree> {
        self.structure.tree()
    }

    /// Levels under the root.
    pub fn height(&self) -> u32 {
        self.statistics.height
    }
}

/// Starts to build on a thread of its own; `wake` is called when something is new to show.
///
/// # Errors
/// When the system refuses another thread.
pub fn start(
    surface: Arc<Surface>,
    choice: Choice,
    wake: Wake,
) -> std::io::Result<Job<Option<Built>>> {
    let status = BuildStatus {
        scenario: choice.kind.name().into(),
        part: "dealing out triangles".into(),
        fraction: 0.0,
    };
    Job::start("tree", status, wake, move |progress| {
        Built::new(surface, choice, progress)
    })
}

/// The skin nearest the middle of the box's back, mm: where a box is put that nobody has moved yet.
pub fn middle(scene: &Scene) -> Vec3 {
    let bounds = scene.surface.bounds();
    let back = bounds.centre().with_z(bounds.max.z);
    (scene.touch.search)
        .nearest(&scene.surface, back, f64::INFINITY)
        .map_or(back, |near| near.point)
}
