//! Functional shape matched deformation (Ji 2008, chapter 4).

use crate::deform::{Displacement, Model, Press};
use crate::surface::Surface;

/// What a scenario may choose. Lengths mm, angles rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Half the major axis of the tangential footprint, mm.
    pub half_major_mm: f64,
    /// Half the minor axis, mm; equal to the major one for the basic circle.
    pub half_minor_mm: f64,
    /// Direction of the major axis on the map plane from x, rad; axial.
    pub angle_rad: f64,
    /// Scale of the normal footprint against the tangential one at zero depth (METHOD 3, s0).
    pub normal_scale_shallow: f64,
    /// The same at the depth cap (METHOD 3, s1).
    pub normal_scale_deep: f64,
    /// Cap of the drawn normal displacement, mm (Ji 2008, eq. 4.16).
    pub max_normal_mm: f64,
    /// Cap of the drawn tangential displacement, mm (Ji 2008, eq. 4.18).
    pub max_tangential_mm: f64,
    /// Whether the tangential field is computed at all; off in a frictionless scene.
    pub tangential: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            half_major_mm: 140.0,
            half_minor_mm: 140.0,
            angle_rad: std::f64::consts::FRAC_PI_2,
            normal_scale_shallow: 0.10,
            normal_scale_deep: 0.40,
            max_normal_mm: 10.0,
            max_tangential_mm: 20.0,
            tangential: true,
        }
    }
}

/// The model with its scratch memory.
#[derive(Debug)]
pub struct Fsmd {
    settings: Settings,
}

impl Fsmd {
    /// A model with the given settings.
    pub fn new(settings: Settings) -> Self {
        Self { settings }
    }

    /// The settings in use.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }
}

impl Model for Fsmd {
    fn name(&self) -> &'static str {
        "fsmd"
    }

    fn update(&mut self, _surface: &Surface, _presses: &[Press], out: &mut Displacement) {
        out.touched.clear();
    }
}
