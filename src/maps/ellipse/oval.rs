//! One ellipse, and its anisotropy as a vector that can be averaged.

use crate::geom::Vec2;
use std::f64::consts::{FRAC_PI_2, PI};

/// An ellipse about a point: lengths on the skin, direction on the map plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oval {
    /// Half the major axis, mm.
    pub half_major_mm: f64,
    /// Half the minor axis, mm; at most the major one.
    pub half_minor_mm: f64,
    /// Direction of the major axis from x, rad; axial, in 0 … π (π itself is 0). For a circle π/2.
    pub angle_rad: f64,
}

impl Oval {
    /// A circle; its direction is by convention upright (Ji 2008, eq. 5.2).
    pub fn circle(radius_mm: f64) -> Self {
        Self {
            half_major_mm: radius_mm,
            half_minor_mm: radius_mm,
            angle_rad: FRAC_PI_2,
        }
    }

    /// Major axis over minor axis, ≥ 1.
    pub fn major_over_minor(&self) -> f64 {
        self.half_major_mm / self.half_minor_mm
    }

    /// (major/minor − 1) in the direction of twice the angle: the same vector for both angles that an axis may state, 0 for a
    /// circle, and so the thing to average.
    pub fn anisotropy(&self) -> Vec2 {
        anisotropy(self.half_major_mm / self.half_minor_mm, self.angle_rad)
    }

    /// The ellipse with this half major axis, mm, and anisotropy. None at all makes a circle.
    pub fn of_anisotropy(half_major_mm: f64, anisotropy: Vec2) -> Self {
        let strength = anisotropy.length();
        if strength == 0.0 {
            return Self::circle(half_major_mm);
        }
        Self {
            half_major_mm,
            half_minor_mm: half_major_mm / (1.0 + strength),
            angle_rad: axial(0.5 * libm::atan2(anisotropy.y, anisotropy.x)),
        }
    }

    /// Distance from the centre to the outline in a direction of the map plane, rad from x, mm.
    pub fn radius_mm(&self, direction_rad: f64) -> f64 {
        let (sin, cos) = libm::sincos(direction_rad - self.angle_rad);
        let (a, b) = (self.half_major_mm, self.half_minor_mm);
        let (u, v) = (b * cos, a * sin);
        a * b / (u * u + v * v).sqrt()
    }
}

/// See [`Oval::anisotropy`].
pub(super) fn anisotropy(major_over_minor: f64, angle_rad: f64) -> Vec2 {
    let (sin, cos) = libm::sincos(2.0 * angle_rad);
    Vec2::new(cos, sin) * (major_over_minor - 1.0)
}

/// The same axis by its angle in 0 … π, π itself left out.
pub fn axial(angle_rad: f64) -> f64 {
    let wrapped = angle_rad.rem_euclid(PI);
    if wrapped < PI { wrapped } else { 0.0 }
}
