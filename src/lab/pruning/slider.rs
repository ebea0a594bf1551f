//! A finger that presses and slides, over and over.

use crate::device::scripted::Script;
use crate::device::{Capabilities, Device, Reading};
use crate::geom::Vec3;
use crate::scenario::Scene;
use std::sync::Arc;

/// How deep it presses, mm.
const DEPTH_MM: f64 = 5.0;

/// Presses and slides, over and over.
pub struct Slider {
    capabilities: Capabilities,
    readings: Arc<[Reading]>,
    next: usize,
}

impl Slider {
    /// Over the skin of `scene`; one tick is a millisecond.
    pub fn over(scene: &Scene) -> Self {
        let path = Script::Slide.trajectory(scene.default_place_mm(), DEPTH_MM, |x, y| {
            scene.height_mm(x, y)
        });
        let reading = |k: usize| {
            let (position_mm, velocity_mm_s) = path.at(k as f64 * 1e-3);
            Reading {
                position_mm,
                velocity_mm_s,
                connected: true,
                ..Reading::default()
            }
        };
        // There and back, so that it never jumps.
        let there = (path.duration_s() * 1e3) as usize;
        let back = |k: usize| {
            let r = reading(there - k);
            Reading {
                velocity_mm_s: -r.velocity_mm_s,
                ..r
            }
        };
        Self {
            capabilities: Capabilities::ideal("Scripted", 22.0),
            readings: (0..there)
                .map(reading)
                .chain((0..there).map(back))
                .collect(),
            next: 0,
        }
    }
}

impl Device for Slider {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self, _dt_s: f64) -> Reading {
        let reading = self.readings[self.next % self.readings.len()];
        self.next += 1;
        reading
    }

    fn write(&mut self, _force_n: Vec3) {}
}
