//! Inverse distance weighting: Σ v_i / d_i² over Σ 1 / d_i² (Shepard, D. 1968, "A two-dimensional interpolation function for
//! irregularly-spaced data", Proc. 23rd ACM National Conference, 517–524).

use super::{Field, Fitted, Reader, Sample, TOUCHING_MM};
use crate::geom::Vec2;
use std::sync::Arc;

#[derive(Debug)]
struct InverseDistance(Vec<Sample>);

pub(super) fn through(samples: &[Sample]) -> Fitted {
    Ok(Arc::new(InverseDistance(samples.to_vec())))
}

impl InverseDistance {
    fn at(&self, place: Vec2) -> f64 {
        let (mut sum, mut weights) = (0.0, 0.0);
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for s in &self.0 {
            let distance_sq = s.at.distance_squared(place);
            // Half of what keeps keys apart, so that only one can be this near.
            if distance_sq <= 0.25 * TOUCHING_MM * TOUCHING_MM {
                return s.value;
            }
            sum += s.value / distance_sq;
            weights += 1.0 / distance_sq;
            least = least.min(s.value);
            most = most.max(s.value);
        }
        (sum / weights).clamp(least, most)
    }
}

impl Field for InverseDistance {
    fn reader(&self) -> Box<dyn Reader + '_> {
        Box::new(|place: Vec2| self.at(place))
    }
}
