//! What a shelf belongs to: everything that results depend on.

use crate::figure::write_files;
use crate::lab::program::{self, hexadecimal, sha256_of};
use crate::lab::{LabError, Machine, Mesh, Scene, Setup};
use crate::scenario::SurfaceChoice;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::path::Path;

/// Name of the file that holds a shelf's label.
pub(super) const FILE: &str = "shelf.json";

/// All that the results of an experiment depend on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Label {
    experiment: String,
    dorsum: String,
    /// First digits of the hash of the program.
    build: String,
    machine: Machine,
    quick: bool,
    mesh: Option<Named>,
    triangles: Vec<usize>,
    scene: Option<Named>,
    session: Option<Named>,
    seed: u64,
    seconds: Option<f64>,
}

/// Something the user named, and what it holds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Named {
    name: String,
    sha256: String,
}

impl Label {
    /// The label of `experiment` under `setup`; nothing where it is not known which program this is.
    pub(super) fn new(experiment: &str, setup: &Setup) -> Result<Option<Self>, LabError> {
        let Some(build) = program::build() else {
            return Ok(None);
        };
        Ok(Some(Self {
            experiment: experiment.to_owned(),
            dorsum: env!("CARGO_PKG_VERSION").to_owned(),
            build: build.to_owned(),
            machine: Machine::here(),
            quick: setup.quick,
            mesh: setup.mesh.as_ref().map(mesh),
            triangles: setup.triangles.clone(),
            scene: setup.scene.as_ref().map(scene),
            session: setup.session.as_deref().map(session).transpose()?,
            seed: setup.seed,
            seconds: setup.seconds,
        }))
    }

    /// Name of the shelf's folder: 64 hexadecimal digits.
    pub(super) fn folder_name(&self) -> String {
        // A value of strings, numbers and lists of these is always JSON.
        let text = serde_json::to_string(self).unwrap_or_default();
        hexadecimal(&Sha256::digest(text))
    }

    /// Puts the label into `folder`, which is made where it is missing.
    pub(super) fn put(&self, folder: &Path) -> std::io::Result<()> {
        std::fs::create_dir_all(folder)?;
        let text = serde_json::to_vec_pretty(self)?;
        write_files(&[(folder.join(FILE), text)])
    }
}

fn mesh(mesh: &Mesh) -> Named {
    Named {
        name: mesh.name.clone(),
        sha256: hexadecimal(&mesh.surface.hash()),
    }
}

/// Everything the scenario says, and the bytes of the mesh that it names. Where it lies does not matter.
fn scene(scene: &Scene) -> Named {
    let mut said = (*scene.scenario).clone();
    let mut hasher = Sha256::new();
    if let (SurfaceChoice::Mesh { path, .. }, Some(folder)) = (&said.surface, &said.folder) {
        // One that cannot be read is refused when the scene is built.
        if let Ok(hash) = sha256_of(&folder.join(path)) {
            hasher.update(hash);
        }
    }
    said.folder = None;
    hasher.update(format!("{said:?}"));
    Named {
        name: scene.name.clone(),
        sha256: hexadecimal(&hasher.finalize()),
    }
}

fn session(path: &Path) -> Result<Named, LabError> {
    let hash = sha256_of(path)
        .map_err(|e| LabError::Input(format!("{}: cannot be read: {e}", path.display())))?;
    Ok(Named {
        name: path.display().to_string(),
        sha256: hexadecimal(&hash),
    })
}
