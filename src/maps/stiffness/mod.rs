//! The stiffness map: measured keys, fitted by a continuous function, with strokes of a brush and spots over it.

mod strokes;

use super::fit::{Field, Fit, Sample, TOUCHING_MM};
use super::spot::{Spot, SpotReader};
use super::{MapError, on_map, on_the_map, parallel, places};
use crate::geom::Vec2;
use crate::surface::Surface;
use std::sync::Arc;
use strokes::Brushed;

pub use strokes::{BRUSHED_N_PER_MM, STROKE_CHANGES, STROKE_POINTS, STROKE_RADII_MM, Stroke};

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

/// Stiffness over the map plane, N/mm. Positive, finite and continuous everywhere.
///
/// Without strokes and spots it stays within the range of its keys, but for [`Fit::Rbf`], which may swing beyond it by a
/// factor of two. Strokes keep it within [`BRUSHED_N_PER_MM`].
#[derive(Clone, Debug)]
pub struct StiffnessMap {
    keys: Vec<StiffnessKey>,
    fit: Fit,
    strokes: Vec<Stroke>,
    field: Arc<dyn Field>,
    brushed: Vec<Brushed>,
    spots: Vec<(SpotReader, f64)>,
    uniform: Option<f64>,
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
            Fit::Constant,
        )
    }

    /// Fits `keys`. A key stated twice counts once; places within a nanometre of each other are the same.
    ///
    /// # Errors
    /// No key; a key whose place or stiffness is not allowed; two keys at one place with different values; keys that the fit
    /// cannot take.
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
        let first = samples.first().map(|s| s.value);
        let same = first.is_some() && samples.iter().all(|s| Some(s.value) == first);
        // One value needs no net of places to be found in.
        let field = if same { Fit::Constant } else { fit }.through(&samples)?;
        let uniform = match fit {
            _ if same => first,
            Fit::Constant => Some(field.reader().at(Vec2::ZERO)),
            _ => None,
        };
        Ok(Self {
            keys,
            fit,
            strokes: Vec::new(),
            field,
            brushed: Vec::new(),
            spots: Vec::new(),
            uniform,
        })
    }

    /// The same map with strokes over it, applied in order, in place of those it had.
    ///
    /// # Errors
    /// A stroke that states something that is not allowed.
    pub fn with_strokes(mut self, strokes: Vec<Stroke>) -> Result<Self, MapError> {
        let brushed = strokes.iter().enumerate();
        self.brushed = brushed
            .map(|(i, stroke)| Brushed::new(stroke, i + 1))
            .collect::<Result<_, _>>()?;
        self.strokes = strokes;
        Ok(self)
    }

    /// The same map with spots over its strokes, in place of those it had. At the centre of each the stiffness is multiplied
    /// by its factor f, on the way to its rim by 1 + (f − 1) · M(q).
    ///
    /// A factor that is not positive and finite counts as 1.
    #[must_use]
    pub fn with_spots<'a>(mut self, spots: impl IntoIterator<Item = (&'a Spot, f64)>) -> Self {
        let sound = |f: &f64| *f > 0.0 && f.is_finite() && *f != 1.0;
        self.spots = (spots.into_iter().filter(|(_, f)| sound(f)))
            .map(|(spot, factor)| (SpotReader::new(spot), factor - 1.0))
            .collect();
        self
    }

    /// The keys, as given.
    pub fn keys(&self) -> &[StiffnessKey] {
        &self.keys
    }

    /// The continuous function through them.
    pub fn fit(&self) -> Fit {
        self.fit
    }

    /// The strokes over it.
    pub fn strokes(&self) -> &[Stroke] {
        &self.strokes
    }

    /// Stiffness at a place of the map plane, N/mm.
    ///
    /// Without strokes and spots: at a key exactly its value ([`Fit::Constant`] apart). A coordinate that is not a number counts as 0,
    /// one beyond 1e6 mm as 1e6 mm.
    pub fn at(&self, place: Vec2) -> f64 {
        self.reader()(place)
    }

    /// Reads one place after another, quicker than [`StiffnessMap::at`] for many.
    pub fn reader(&self) -> impl FnMut(Vec2) -> f64 + '_ {
        let mut field = self.field.reader();
        move |place| {
            let place = on_map(place);
            let fitted = self.uniform.unwrap_or_else(|| field.at(place));
            self.spotted(self.brush(fitted, place), place)
        }
    }

    fn brush(&self, fitted: f64, place: Vec2) -> f64 {
        if self.brushed.is_empty() {
            return fitted;
        }
        let (least, most) = (BRUSHED_N_PER_MM.start(), BRUSHED_N_PER_MM.end());
        let (least, most) = (least.min(fitted), most.max(fitted));
        self.brushed.iter().fold(fitted, |value, stroke| {
            (value * stroke.factor(place)).clamp(least, most)
        })
    }

    fn spotted(&self, brushed: f64, place: Vec2) -> f64 {
        self.spots.iter().fold(brushed, |value, (spot, change)| {
            value * (1.0 + change * spot.weight(place))
        })
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
            let mut reader = self.reader();
            move |p| reader(p.truncate())
        });
        values
    }

    /// The stiffness of every place where it is the same, so that no value per vertex is needed.
    pub fn uniform(&self) -> Option<f64> {
        self.uniform
            .filter(|_| self.brushed.is_empty() && self.spots.is_empty())
    }
}

/// What the map without a key answers at that key, less what the key states, N/mm; for each key.
///
/// Keys at one place are left out together. Costs one fit per key.
///
/// # Errors
/// As [`StiffnessMap::new`]; fewer than two places, so that nothing is left to answer.
pub fn leave_one_out(keys: &[StiffnessKey], fit: Fit) -> Result<Vec<f64>, MapError> {
    StiffnessMap::new(keys.to_vec(), fit)?;
    let samples = one_per_place(keys)?;
    keys.iter()
        .map(|key| {
            let others: Vec<Sample> = samples
                .iter()
                .filter(|s| s.at.distance_squared(key.at) > TOUCHING_MM * TOUCHING_MM)
                .copied()
                .collect();
            let field = fit.through(&others)?;
            Ok(field.reader().at(key.at) - key.stiffness_n_per_mm)
        })
        .collect()
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
