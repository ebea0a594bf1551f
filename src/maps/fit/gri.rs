//! Gaussian radial interpolation of values: the corrected form about their mean.

use super::{Field, Fitted, Reader, Sample};
use crate::geom::Vec2;
use crate::maps::ellipse::EFFECT_RADIUS_MM;
use crate::maps::gri::{Form, Gri, Level, Weighed};
use std::sync::Arc;

#[derive(Debug)]
struct Radial {
    gri: Gri,
    values: Vec<f64>,
    ground: f64,
    least: f64,
    most: f64,
}

pub(super) fn through(samples: &[Sample]) -> Fitted {
    let places = samples.iter().map(|s| s.at).collect();
    let values: Vec<f64> = samples.iter().map(|s| s.value).collect();
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(0.0, f64::max);
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    Ok(Arc::new(Radial {
        gri: Gri::new(places, EFFECT_RADIUS_MM, Form::Corrected, Level::Exact),
        ground: mean.clamp(least, most),
        values,
        least,
        most,
    }))
}

impl Radial {
    fn at(&self, place: Vec2) -> f64 {
        let mut above = 0.0;
        let weighed = self.gri.weigh(place, |i, weight| {
            above += weight * (self.values[i] - self.ground);
        });
        match weighed {
            Weighed::Ground => self.ground,
            Weighed::Alone(i) => self.values[i],
            Weighed::Sum(sum) => (self.ground + above / sum).clamp(self.least, self.most),
        }
    }
}

impl Field for Radial {
    fn reader(&self) -> Box<dyn Reader + '_> {
        Box::new(|place: Vec2| self.at(place))
    }
}
