//! The stiffness map: measured keys, fitted by a continuous function.

use super::natural::{NaturalNeighbour, Sample, TOUCHING_MM};
use super::{MapError, on_map, on_the_map, parallel, places};
use crate::geom::Vec2;
use crate::surface::Surface;

/// Largest stiffness a key may state, N/mm: steel is below it.
pub const MAX_STIFFNESS_N_PER_MM: f64 = 1.0e6;

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
            if !on_the_map(at) {
                let map = "stiffness";
                return Err(MapError::Place { map, key, at });
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
        parallel::fill(&mut values, positions, || {
            let mut reader = self.field.reader();
            move |p| reader.at(on_map(p.truncate()))
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

/// Samples for the fit: the first key of each place.
fn one_per_place(keys: &[StiffnessKey]) -> Result<Vec<Sample>, MapError> {
    let at: Vec<Vec2> = keys.iter().map(|k| k.at).collect();
    let repeated = places::repeated(&at, TOUCHING_MM, |i, j| {
        let values = [keys[i], keys[j]].map(|k| k.stiffness_n_per_mm);
        if values[0] == values[1] {
            return Ok(());
        }
        Err(MapError::Conflict {
            keys: [i + 1, j + 1],
            at: keys[i].at,
            values,
        })
    })?;
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
