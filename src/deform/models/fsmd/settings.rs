//! What may be chosen about the model, and the footprints that a press has by it.

use super::field::Footprint;
use crate::deform::Press;
use crate::deform::bones::Bones;
use crate::deform::curve::Curve;
use crate::deform::footprint::{Ellipse, Kind, Polar, PrintedEllipse};
use crate::maps::Oval;
use crate::surface::Surface;
use std::sync::Arc;

/// What a scenario may choose. Lengths mm, angles rad.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Which outline, and whether it follows a map.
    pub footprint: Kind,
    /// The falloff from the centre to the rim.
    pub curve: Curve,
    /// Half the major axis of the tangential footprint where no map tells it, mm; the radius of the basic circle.
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
    /// Bone under the surface that limits and narrows normal dents; absent, it is nowhere near.
    pub bones: Option<Arc<Bones>>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            footprint: Kind::default(),
            curve: Curve::gaussian(),
            half_major_mm: 140.0,
            half_minor_mm: 140.0,
            angle_rad: std::f64::consts::FRAC_PI_2,
            normal_scale_shallow: 0.10,
            normal_scale_deep: 0.40,
            max_normal_mm: 10.0,
            max_tangential_mm: 20.0,
            tangential: true,
            bones: None,
        }
    }
}

impl Settings {
    /// The tangential footprint of a press; `None` when it is empty.
    pub(super) fn footprint_at(&self, press: &Press) -> Option<Footprint> {
        let (o, n) = (press.anchor_mm, press.normal);
        let own = Oval {
            half_major_mm: self.half_major_mm,
            half_minor_mm: self.half_minor_mm,
            angle_rad: self.angle_rad,
        };
        let at = press.oval.unwrap_or(own);
        let (a, b, angle_rad) = (at.half_major_mm, at.half_minor_mm, at.angle_rad);
        let ellipse = || Ellipse::new(o, n, a, b, angle_rad).map(Footprint::Ellipse);
        match (self.footprint, &press.boundary_mm) {
            (Kind::Circle, _) => {
                let radius_mm = self.half_major_mm;
                Ellipse::new(o, n, radius_mm, radius_mm, 0.0).map(Footprint::Ellipse)
            }
            (Kind::EllipsePrinted, _) => {
                PrintedEllipse::new(o, n, a, b, angle_rad).map(Footprint::Printed)
            }
            (Kind::Irregular, Some(radii_mm)) => Polar::new(o, n, radii_mm).map(Footprint::Polar),
            (Kind::Ellipse | Kind::Irregular, _) => ellipse(),
        }
    }

    /// The tangential and the normal footprint of a press, each `None` when it is empty. Bones narrow the normal one.
    pub(super) fn footprints_at(&self, surface: &Surface, press: &Press) -> [Option<Footprint>; 2] {
        let mut scale = self.normal_scale(press.depth_mm);
        if let Some(bones) = &self.bones {
            scale *= bones.narrowing(surface, press.triangle, press.anchor_mm);
        }
        let wide = self.footprint_at(press);
        let narrow = wide.as_ref().and_then(|f| f.scaled(scale));
        [wide, narrow]
    }

    /// Scale of the normal footprint at a depth, mm.
    fn normal_scale(&self, depth_mm: f64) -> f64 {
        let share = (depth_mm / self.max_normal_mm).clamp(0.0, 1.0);
        self.normal_scale_shallow + (self.normal_scale_deep - self.normal_scale_shallow) * share
    }
}
