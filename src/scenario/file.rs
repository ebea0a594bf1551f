//! The scenario file: TOML with units in the key names.

use crate::contact::Friction;
use crate::maps::{Fit, StiffnessKey};
use std::path::{Path, PathBuf};

/// Where the surface comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceChoice {
    /// The built-in back with about this many triangles.
    BuiltinBack {
        /// Triangles asked for.
        triangles: usize,
    },
    /// A mesh file; the path is relative to the scenario's folder and stays inside it.
    Mesh {
        /// Path as stated in the file.
        path: PathBuf,
    },
}

/// A parsed and checked scenario.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Name shown to people.
    pub name: String,
    /// One or two sentences on what the scene is for; may be empty.
    pub description: String,
    /// Where the surface comes from.
    pub surface: SurfaceChoice,
    /// Stiffness keys; one key is a constant map.
    pub stiffness_keys: Vec<StiffnessKey>,
    /// The fit through them.
    pub stiffness_fit: Fit,
    /// Absent: frictionless.
    pub friction: Option<Friction>,
    /// Half axis of the basic circle of the tangential footprint, mm.
    pub basic_radius_mm: f64,
    /// The file, whole, as read.
    pub source: String,
    /// Folder that relative paths start from; `None` for embedded scenarios.
    pub folder: Option<PathBuf>,
}

/// Why a scenario is refused: file, line, key, value and what is allowed, in one line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct ScenarioError(pub String);

impl Scenario {
    /// Parses `text`; `origin` names it in errors and `folder` is where relative paths start.
    ///
    /// # Errors
    /// The first thing wrong with it.
    pub fn parse(_text: &str, origin: &str, _folder: Option<&Path>) -> Result<Self, ScenarioError> {
        Err(ScenarioError(format!("{origin}: cannot be parsed")))
    }

    /// Reads and parses a file.
    ///
    /// # Errors
    /// The file cannot be read, or the first thing wrong with it.
    pub fn load(path: &Path) -> Result<Self, ScenarioError> {
        let text = std::fs::read_to_string(path)
            .map_err(|e| ScenarioError(format!("{}: {e}", path.display())))?;
        Self::parse(&text, &path.display().to_string(), path.parent())
    }
}
