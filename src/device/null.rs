//! The device that is always there: it rests far from any skin and takes no force.

use super::{Capabilities, Device, Reading};
use crate::geom::Vec3;

/// Stands in where a device is missing.
#[derive(Clone, Debug)]
pub struct Null {
    capabilities: Capabilities,
    at_mm: Vec3,
}

impl Null {
    /// A null device resting at `at_mm`.
    pub fn new(at_mm: Vec3) -> Self {
        let capabilities = Capabilities {
            position_axes: 0,
            workspace_radius_mm: 0.0,
            ..Capabilities::ideal("None", 0.0)
        };
        Self {
            capabilities,
            at_mm,
        }
    }
}

impl Device for Null {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self, _dt_s: f64) -> Reading {
        Reading {
            position_mm: self.at_mm,
            connected: true,
            ..Reading::default()
        }
    }

    fn write(&mut self, _force_n: Vec3) {}
}
