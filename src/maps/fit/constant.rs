//! One value for all places.

use super::{Field, Fitted, Reader, Sample};
use crate::geom::Vec2;
use std::sync::Arc;

#[derive(Debug)]
struct Constant(f64);

/// The geometric mean: stiffness is felt by ratios, and the mean of the compliances is then that of the stiffnesses.
pub(super) fn through(samples: &[Sample]) -> Fitted {
    Ok(Arc::new(Constant(geometric_mean(samples))))
}

/// Of at least one positive value; exactly that value where all are the same.
pub(super) fn geometric_mean(samples: &[Sample]) -> f64 {
    let least = samples
        .iter()
        .map(|s| s.value)
        .fold(f64::INFINITY, f64::min);
    let most = samples.iter().map(|s| s.value).fold(0.0, f64::max);
    let sum: f64 = samples.iter().map(|s| libm::log(s.value)).sum();
    libm::exp(sum / samples.len() as f64).clamp(least, most)
}

impl Field for Constant {
    fn reader(&self) -> Box<dyn Reader + '_> {
        Box::new(|_: Vec2| self.0)
    }
}
