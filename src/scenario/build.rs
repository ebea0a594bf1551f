//! From a scenario to the things it needs, and nothing else.

use super::{Ledger, Scenario, ScenarioError, Use};
use crate::contact::TouchScene;
use crate::deform::models::fsmd;
use crate::maps::StiffnessMap;
use crate::surface::{Report, Surface};
use std::sync::Arc;

/// A scene ready to be felt and drawn. Cheap to clone: large parts are shared.
#[derive(Clone, Debug)]
pub struct Scene {
    /// What it was built from.
    pub scenario: Arc<Scenario>,
    /// The skin at rest.
    pub surface: Arc<Surface>,
    /// What validation found and repaired.
    pub report: Arc<Report>,
    /// Stiffness over the map plane.
    pub stiffness: Arc<StiffnessMap>,
    /// What the servo gets (a copy is boxed and handed in).
    pub touch: TouchScene,
    /// Settings of the drawn deformation.
    pub deform: fsmd::Settings,
    /// `builtin:back` or the mesh path as stated.
    pub mesh_origin: String,
    /// What was built and what was left out, with its cost.
    pub ledger: Ledger,
}

/// Why a scene could not be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct BuildError(pub String);

impl From<ScenarioError> for BuildError {
    fn from(e: ScenarioError) -> Self {
        Self(e.0)
    }
}

/// Builds what `scenario` needs for `purpose`. `progress` is told what is being built and a fraction 0…1, and answers
/// whether to go on.
///
/// # Errors
/// The mesh cannot be read or is refused, a map is refused, or `progress` said stop.
pub fn build(
    _scenario: Arc<Scenario>,
    _purpose: Use,
    _progress: &mut dyn FnMut(&str, f64) -> bool,
) -> Result<Scene, BuildError> {
    Err(BuildError("no builder".into()))
}
