//! Why a map is refused.

use super::MAX_COORDINATE_MM;
use super::stiffness::MAX_STIFFNESS_N_PER_MM;
use crate::geom::Vec2;

/// Why a map is refused. Keys are counted from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MapError {
    /// There is no key.
    #[error("the stiffness map has no keys; at least one is needed")]
    NoKeys,
    /// A key lies nowhere.
    #[error("{map} key {key} at ({}, {}) mm: coordinates must be numbers within ±{MAX_COORDINATE_MM} mm", at.x, at.y)]
    Place {
        /// Of which map: `stiffness` or `ellipse`.
        map: &'static str,
        /// Which key.
        key: usize,
        /// Its place as stated, mm.
        at: Vec2,
    },
    /// A key states no stiffness.
    #[error(
        "stiffness key {key} at ({}, {}) mm: stiffness_n_per_mm is {value}; it must be above 0 and at most \
         {MAX_STIFFNESS_N_PER_MM}", at.x, at.y
    )]
    Value {
        /// Which key.
        key: usize,
        /// Its place, mm.
        at: Vec2,
        /// Its stiffness as stated, N/mm.
        value: f64,
    },
    /// One place, two stiffnesses.
    #[error(
        "stiffness keys {} and {} are both at ({}, {}) mm but state {} and {} N/mm; keep one of them",
        keys[0], keys[1], at.x, at.y, values[0], values[1]
    )]
    Conflict {
        /// Which keys.
        keys: [usize; 2],
        /// The place of the first, mm.
        at: Vec2,
        /// Their stiffnesses, N/mm.
        values: [f64; 2],
    },
    /// A spot over the map is refused; in words.
    #[error("{0}")]
    Spot(String),
    /// More keys than a fit takes.
    #[error("the fit \"{fit}\" takes at most {most} keys, not {keys}; choose another fit")]
    TooManyKeys {
        /// Name of the fit.
        fit: &'static str,
        /// Keys given, each place counted once.
        keys: usize,
        /// Most allowed.
        most: usize,
    },
    /// Keys that a fit cannot tell apart.
    #[error(
        "the fit \"{fit}\" has no sound solution: the keys at ({}, {}) and ({}, {}) mm are too close to each other; \
         move them apart or choose another fit", places[0].x, places[0].y, places[1].x, places[1].y
    )]
    Unsolved {
        /// Name of the fit.
        fit: &'static str,
        /// The keys nearest to each other, mm.
        places: [Vec2; 2],
    },
    /// A stroke states something that is not allowed.
    #[error("stiffness stroke {stroke}: {field} is {value}; {allowed}")]
    Stroke {
        /// Which stroke, counted from 1.
        stroke: usize,
        /// Which of its values.
        field: &'static str,
        /// As stated.
        value: String,
        /// What is allowed.
        allowed: String,
    },
    /// A value of an ellipse key, or a setting of the ellipse map, is not allowed.
    #[error("{of}: {field} is {value}; {allowed}")]
    Ellipse {
        /// Which key, counted from 1; `None` for a setting of the map.
        key: Option<usize>,
        /// Which key, by number and name, or `ellipse map`.
        of: String,
        /// Which of its values, by the name it has in a scenario.
        field: &'static str,
        /// As stated.
        value: f64,
        /// What is allowed.
        allowed: String,
    },
    /// One place, two ellipses.
    #[error(
        "{} and {} are both at ({}, {}) mm but state different ellipses; keep one of them",
        names[0], names[1], at.x, at.y
    )]
    EllipseConflict {
        /// Which keys.
        keys: [usize; 2],
        /// The same by number and name.
        names: [String; 2],
        /// The place of the first, mm.
        at: Vec2,
    },
}

impl MapError {
    /// The key to blame, counted from 1: of two, the later one.
    pub fn key(&self) -> Option<usize> {
        match self {
            Self::Place { key, .. } | Self::Value { key, .. } => Some(*key),
            Self::Conflict { keys, .. } | Self::EllipseConflict { keys, .. } => Some(keys[1]),
            Self::Ellipse { key, .. } => *key,
            Self::NoKeys
            | Self::Spot(_)
            | Self::TooManyKeys { .. }
            | Self::Unsolved { .. }
            | Self::Stroke { .. } => None,
        }
    }
}
