//! Thin-plate spline through the logarithms of the values (Duchon, J. 1977, "Splines minimizing rotation-invariant
//! semi-norms in Sobolev spaces", in *Constructive Theory of Functions of Several Variables*, 85–100).
//!
//! s(p) = Σ c_i φ(|p − p_i|) + a_0 + a_1 u + a_2 v with φ(r) = r² ln r, u and v along the principal axes of the places; where
//! they lie on one line, v is left out, and for a single place u too. Lengths are over the extent of the places.

use super::hull::Hull;
use super::{Field, Fitted, Reader, Sample, TOUCHING_MM};
use crate::geom::Vec2;
use crate::maps::MapError;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Most keys that the spline is solved for: the dense solve costs their cube, and is some tens of ms here.
pub const MOST_KEYS: usize = 400;

/// How far a swing between keys may go beyond the least and the largest value, as a factor.
const SWING: f64 = 2.0;

/// Largest misfit at a key that counts as met, in the logarithm.
///
/// Far above what rounding leaves in sound sets of keys (1e-12), far below what a finger feels.
const MISFIT: f64 = 1.0e-8;

#[derive(Debug)]
struct ThinPlate {
    samples: Vec<Sample>,
    hull: Hull,
    axes: Axes,
    bends: Vec<f64>,
    plane: Vec<f64>,
    least: f64,
    most: f64,
}

pub(super) fn through(samples: &[Sample]) -> Fitted {
    let n = samples.len();
    if n > MOST_KEYS {
        return Err(MapError::TooManyKeys {
            fit: "rbf",
            keys: n,
            most: MOST_KEYS,
        });
    }
    let places: Vec<Vec2> = samples.iter().map(|s| s.at).collect();
    let axes = Axes::of(&places);
    let size = n + axes.n_terms;
    let local: Vec<Vec2> = places.iter().map(|p| axes.local(*p)).collect();
    let mut matrix = DMatrix::zeros(size, size);
    let mut right = DVector::zeros(size);
    for i in 0..n {
        for j in 0..n {
            matrix[(i, j)] = bend(places[i].distance_squared(places[j]) / axes.extent_sq);
        }
        for (term, value) in axes.terms(local[i]).iter().enumerate().take(axes.n_terms) {
            matrix[(i, n + term)] = *value;
            matrix[(n + term, i)] = *value;
        }
        right[i] = libm::log(samples[i].value);
    }
    // Elimination by columns only: no product of matrices, whose order of sums would depend on the processor.
    let solved = matrix.lu().solve(&right);
    let unsound = || MapError::Unsolved {
        fit: "rbf",
        places: closest_pair(&places),
    };
    let solution = solved.ok_or_else(unsound)?;
    let least = samples
        .iter()
        .map(|s| s.value)
        .fold(f64::INFINITY, f64::min);
    let most = samples.iter().map(|s| s.value).fold(0.0, f64::max);
    let field = ThinPlate {
        samples: samples.to_vec(),
        hull: Hull::of(&places),
        bends: solution.rows(0, n).iter().copied().collect(),
        plane: solution.rows(n, axes.n_terms).iter().copied().collect(),
        axes,
        least: least / SWING,
        most: most * SWING,
    };
    let missed = |s: &Sample| {
        let misfit = field.log_at(s.at) - libm::log(s.value);
        misfit.is_nan() || misfit.abs() > MISFIT
    };
    if samples.iter().any(missed) {
        return Err(unsound());
    }
    Ok(Arc::new(field))
}

impl ThinPlate {
    fn log_at(&self, place: Vec2) -> f64 {
        let local = self.axes.local(place);
        let terms = self.axes.terms(local);
        let plane: f64 = terms.iter().zip(&self.plane).map(|(t, a)| t * a).sum();
        let bent = self.samples.iter().zip(&self.bends).map(|(s, c)| {
            let distance_sq = s.at.distance_squared(place);
            c * bend(distance_sq / self.axes.extent_sq)
        });
        bent.sum::<f64>() + plane
    }

    fn at(&self, place: Vec2) -> f64 {
        let inside = self.hull.closest(place);
        let key = self
            .samples
            .iter()
            .find(|s| s.at.distance_squared(inside) <= 0.25 * TOUCHING_MM * TOUCHING_MM);
        match key {
            Some(key) => key.value,
            None => libm::exp(self.log_at(inside)).clamp(self.least, self.most),
        }
    }
}

impl Field for ThinPlate {
    fn reader(&self) -> Box<dyn Reader + '_> {
        Box::new(|place: Vec2| self.at(place))
    }
}

/// r² ln r of r²; 0 at 0.
fn bend(distance_sq: f64) -> f64 {
    if distance_sq > 0.0 {
        0.5 * distance_sq * libm::log(distance_sq)
    } else {
        0.0
    }
}

/// The two places nearest to each other.
fn closest_pair(places: &[Vec2]) -> [Vec2; 2] {
    let mut nearest = ([Vec2::ZERO; 2], f64::INFINITY);
    for (i, p) in places.iter().enumerate() {
        for q in &places[i + 1..] {
            let distance_sq = p.distance_squared(*q);
            if distance_sq < nearest.1 {
                nearest = ([*p, *q], distance_sq);
            }
        }
    }
    nearest.0
}

/// Principal axes of places, each over the extent along it, so that a thin band of keys makes as sound an equation as a
/// round cloud.
#[derive(Clone, Debug)]
struct Axes {
    centre: Vec2,
    along_per_mm: Vec2,
    across_per_mm: Vec2,
    /// 1 for a single place, 2 for places on one line, 3 otherwise.
    n_terms: usize,
    /// Square of the largest extent, mm².
    extent_sq: f64,
}

impl Axes {
    fn of(places: &[Vec2]) -> Self {
        let centre = places.iter().sum::<Vec2>() / places.len() as f64;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for d in places.iter().map(|p| *p - centre) {
            xx += d.x * d.x;
            xy += d.x * d.y;
            yy += d.y * d.y;
        }
        let angle = 0.5 * libm::atan2(2.0 * xy, xx - yy);
        let (sin, cos) = libm::sincos(angle);
        let along = Vec2::new(cos, sin);
        let extent = |axis: Vec2| {
            let reach = places.iter().map(|p| (*p - centre).dot(axis).abs());
            reach.fold(0.0, f64::max)
        };
        let (length, width) = (extent(along), extent(along.perp()));
        let over = |axis: Vec2, extent: f64| {
            if extent > TOUCHING_MM {
                axis / extent
            } else {
                Vec2::ZERO
            }
        };
        Self {
            centre,
            along_per_mm: over(along, length),
            across_per_mm: over(along.perp(), width),
            n_terms: 1 + usize::from(length > TOUCHING_MM) + usize::from(width > TOUCHING_MM),
            extent_sq: if length > 0.0 { length * length } else { 1.0 },
        }
    }

    fn local(&self, place: Vec2) -> Vec2 {
        let d = place - self.centre;
        Vec2::new(d.dot(self.along_per_mm), d.dot(self.across_per_mm))
    }

    fn terms(&self, local: Vec2) -> [f64; 3] {
        [1.0, local.x, local.y]
    }
}
