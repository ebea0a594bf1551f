//! The stiffness map: measured keys, fitted by a continuous function.

use super::natural::{NaturalNeighbour, Sample, TOUCHING_MM};
use crate::geom::Vec2;
use crate::surface::Surface;
use std::sync::{Mutex, PoisonError};

/// Largest stiffness a key may state, N/mm: steel is below it.
pub const MAX_STIFFNESS_N_PER_MM: f64 = 1.0e6;

/// Largest coordinate of a key, mm.
pub const MAX_COORDINATE_MM: f64 = 1.0e6;

/// Vertices a thread takes at a time: some milliseconds of work, against tens of µs for starting a thread.
const PART: usize = 16_384;

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

/// Why a map is refused. Keys are counted from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MapError {
    /// There is no key.
    #[error("the stiffness map has no keys; at least one is needed")]
    NoKeys,
    /// A key lies nowhere.
    #[error("stiffness key {key} at ({}, {}) mm: coordinates must be numbers within ±{MAX_COORDINATE_MM} mm", at.x, at.y)]
    Place {
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
}

/// Stiffness over the map plane, N/mm. Positive, finite and within the range of its keys everywhere; continuous.
#[derive(Clone, Debug)]
pub struct StiffnessMap {
    keys: Vec<StiffnessKey>,
    fit: Fit,
    field: NaturalNeighbour,
}

impl StiffnessMap {
    /// The same stiffness everywhere.
    ///
    /// # Errors
    /// [`MapError::Value`] for a stiffness that is not allowed.
    pub fn constant(stiffness_n_per_mm: f64) -> Result<Self, MapError> {
        Self::new(
            vec![StiffnessKey {
                at: Vec2::ZERO,
                stiffness_n_per_mm,
            }],
            Fit::Natural,
        )
    }

    /// Fits `keys`. A key stated twice counts once; places within a nanometre of each other are the same.
    ///
    /// # Errors
    /// No key; a key whose place or stiffness is not allowed; two keys at one place with different values.
    pub fn new(keys: Vec<StiffnessKey>, fit: Fit) -> Result<Self, MapError> {
        for (i, k) in keys.iter().enumerate() {
            let (key, at, value) = (i + 1, k.at, k.stiffness_n_per_mm);
            if !(at.abs().max_element() <= MAX_COORDINATE_MM && at.is_finite()) {
                return Err(MapError::Place { key, at });
            }
            if !(value > 0.0 && value <= MAX_STIFFNESS_N_PER_MM) {
                return Err(MapError::Value { key, at, value });
            }
        }
        let samples = one_per_place(&keys)?;
        let field = match fit {
            Fit::Natural => NaturalNeighbour::new(&samples).ok_or(MapError::NoKeys)?,
        };
        Ok(Self { keys, fit, field })
    }

    /// The keys, as given.
    pub fn keys(&self) -> &[StiffnessKey] {
        &self.keys
    }

    /// The continuous function through them.
    pub fn fit(&self) -> Fit {
        self.fit
    }

    /// Stiffness at a place of the map plane, N/mm.
    ///
    /// At a key exactly its value. A coordinate that is not a number counts as 0, one beyond 1e6 mm as 1e6 mm.
    pub fn at(&self, place: Vec2) -> f64 {
        self.field.reader().at(on_map(place))
    }

    /// Stiffness at every vertex of the surface, seen along z, N/mm.
    ///
    /// The same bits on every machine and for any number of threads.
    pub fn per_vertex(&self, surface: &Surface) -> Vec<f64> {
        let positions = surface.positions();
        if let Some(k) = self.uniform() {
            return vec![k; positions.len()];
        }
        let mut values = vec![0.0; positions.len()];
        let parts = Mutex::new(values.chunks_mut(PART).zip(positions.chunks(PART)));
        let work = || {
            let mut reader = self.field.reader();
            loop {
                let part = parts.lock().unwrap_or_else(PoisonError::into_inner).next();
                let Some((values, positions)) = part else {
                    return;
                };
                for (value, p) in values.iter_mut().zip(positions) {
                    *value = reader.at(on_map(p.truncate()));
                }
            }
        };
        let n_helpers = std::thread::available_parallelism()
            .map_or(1, usize::from)
            .min(positions.len().div_ceil(PART))
            .saturating_sub(1);
        std::thread::scope(|scope| {
            for _ in 0..n_helpers {
                // A helper that cannot be had is done without.
                let builder = std::thread::Builder::new().name("stiffness map".into());
                let _ = builder.spawn_scoped(scope, work);
            }
            work();
        });
        values
    }

    /// The stiffness of every place where all keys agree, so that no value per vertex is needed.
    pub fn uniform(&self) -> Option<f64> {
        let k = self.keys[0].stiffness_n_per_mm;
        let same = self.keys.iter().all(|key| key.stiffness_n_per_mm == k);
        same.then_some(k)
    }
}

fn on_map(place: Vec2) -> Vec2 {
    let limited = |x: f64| {
        if x.is_nan() {
            0.0
        } else {
            x.clamp(-MAX_COORDINATE_MM, MAX_COORDINATE_MM)
        }
    };
    Vec2::new(limited(place.x), limited(place.y))
}

/// Samples for the fit: the first key of each place.
fn one_per_place(keys: &[StiffnessKey]) -> Result<Vec<Sample>, MapError> {
    let mut order: Vec<usize> = (0..keys.len()).collect();
    order.sort_by(|&i, &j| keys[i].at.x.total_cmp(&keys[j].at.x).then(i.cmp(&j)));
    let mut repeated = vec![false; keys.len()];
    for (rank, &i) in order.iter().enumerate() {
        for &j in &order[rank + 1..] {
            if keys[j].at.x - keys[i].at.x > TOUCHING_MM {
                break;
            }
            if keys[i].at.distance_squared(keys[j].at) > TOUCHING_MM * TOUCHING_MM {
                continue;
            }
            let (i, j) = (i.min(j), i.max(j));
            let values = [keys[i], keys[j]].map(|k| k.stiffness_n_per_mm);
            if values[0] != values[1] {
                return Err(MapError::Conflict {
                    keys: [i + 1, j + 1],
                    at: keys[i].at,
                    values,
                });
            }
            repeated[j] = true;
        }
    }
    Ok(keys
        .iter()
        .zip(&repeated)
        .filter(|(_, repeated)| !**repeated)
        .map(|(k, _)| Sample {
            at: k.at,
            value: k.stiffness_n_per_mm,
        })
        .collect())
}
