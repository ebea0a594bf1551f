//! Keys of the ellipse map, and what is refused of them.

use super::oval::{Oval, axial};
use super::{
    AngleRule, BASIC_RADII_MM, BOUNDARY_RADII, EFFECT_RADII_MM, EllipseSettings, HALF_AXES_MM,
    radius_direction,
};
use crate::geom::Vec2;
use crate::maps::{MapError, on_the_map, places};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::RangeInclusive;

/// Keys closer than this are at one place, mm.
///
/// Ten times the distance at which a key answers alone, and far below what a hand or a ruler places.
pub const SAME_PLACE_MM: f64 = 0.01;

/// Directions closer than this are one, rad: degrees in a file turned into radians by way of another half turn.
const SAME_ANGLE_RAD: f64 = 1.0e-9;

/// A measured ellipse (Ji 2008, eq. 5.1). Both half axes are stored; "ratio" means major over minor in chapter 5 and minor
/// over major in 4.4.
#[derive(Clone, Debug, PartialEq)]
pub struct EllipseKey {
    /// What it is called; may be empty.
    pub name: String,
    /// Centre on the map plane, mm.
    pub at: Vec2,
    /// Half the major axis, mm.
    pub half_major_mm: f64,
    /// Half the minor axis, mm; at most the major one.
    pub half_minor_mm: f64,
    /// Direction of the major axis from x, rad; axial.
    pub angle_rad: f64,
    /// Irregular boundary of the footprint: polar radii in the map plane at equal angles from x, counter-clockwise, mm.
    pub boundary_mm: Option<Vec<f64>>,
}

impl EllipseKey {
    /// A key without an irregular boundary. Half axes in the wrong order are exchanged and the direction turned by 90°:
    /// the same ellipse.
    pub fn new(
        name: impl Into<String>,
        at: Vec2,
        half_major_mm: f64,
        half_minor_mm: f64,
        angle_rad: f64,
    ) -> Self {
        Self {
            name: name.into(),
            at,
            half_major_mm,
            half_minor_mm,
            angle_rad,
            boundary_mm: None,
        }
        .ordered()
    }

    /// The same ellipse with the longer half axis as the major one.
    #[must_use]
    pub fn ordered(mut self) -> Self {
        if self.half_minor_mm > self.half_major_mm {
            std::mem::swap(&mut self.half_minor_mm, &mut self.half_major_mm);
            self.angle_rad = axial(self.angle_rad + FRAC_PI_2);
        }
        self
    }

    /// The same key on the other side of the spine (x = 0): place, direction and boundary mirrored, the name kept.
    ///
    /// An odd number of radii has none straight opposite: each is then the mean of the two on either side.
    #[must_use]
    pub fn mirrored(mut self) -> Self {
        self.at.x = -self.at.x;
        self.angle_rad = axial(PI - self.angle_rad);
        if let Some(radii) = &mut self.boundary_mm
            && !radii.is_empty()
        {
            let n = radii.len();
            let from = radii.clone();
            for (i, radius) in radii.iter_mut().enumerate() {
                let (left, right) = ((n / 2 + n - i) % n, (n.div_ceil(2) + n - i) % n);
                *radius = 0.5 * (from[left] + from[right]);
            }
        }
        self
    }

    /// The ellipse alone, its direction in 0 … π.
    pub fn oval(&self) -> Oval {
        Oval {
            half_major_mm: self.half_major_mm,
            half_minor_mm: self.half_minor_mm,
            angle_rad: axial(self.angle_rad),
        }
    }

    /// Its boundary, or `n` radii of its ellipse.
    pub(super) fn boundary(&self, n: usize) -> Vec<f64> {
        self.boundary_mm.clone().unwrap_or_else(|| {
            let oval = self.oval();
            (0..n)
                .map(|i| oval.radius_mm(radius_direction(i, n)))
                .collect()
        })
    }

    /// Whether it states the same ellipse and boundary as `other`, whatever both are called.
    fn states_the_same_as(&self, other: &Self, rule: AngleRule) -> bool {
        let between = self.angle_rad - other.angle_rad;
        let same_angle = match rule {
            AngleRule::Tensor => libm::sin(between).abs() <= SAME_ANGLE_RAD,
            AngleRule::Linear => between.abs() <= SAME_ANGLE_RAD,
        };
        self.half_major_mm == other.half_major_mm
            && self.half_minor_mm == other.half_minor_mm
            && (same_angle || self.half_major_mm == self.half_minor_mm)
            && self.boundary_mm == other.boundary_mm
    }

    pub(super) fn check(&self, number: usize) -> Result<(), MapError> {
        if !on_the_map(self.at) {
            return Err(MapError::Place {
                map: "ellipse",
                key: number,
                at: self.at,
            });
        }
        let of = || (Some(number), self.label(number));
        in_range(of, "half_major_mm", self.half_major_mm, &HALF_AXES_MM)?;
        in_range(of, "half_minor_mm", self.half_minor_mm, &HALF_AXES_MM)?;
        if self.half_minor_mm > self.half_major_mm {
            return Err(MapError::Ellipse {
                key: Some(number),
                of: self.label(number),
                field: "half_minor_mm",
                value: self.half_minor_mm,
                allowed: format!("at most half_major_mm = {} is allowed", self.half_major_mm),
            });
        }
        in_range_of(
            of,
            "angle_deg",
            self.angle_rad.to_degrees(),
            self.angle_rad.abs() <= TAU,
            "-360 to 360 is allowed",
        )?;
        let Some(radii) = &self.boundary_mm else {
            return Ok(());
        };
        if !BOUNDARY_RADII.contains(&radii.len()) {
            let (least, most) = (BOUNDARY_RADII.start(), BOUNDARY_RADII.end());
            return Err(MapError::Ellipse {
                key: Some(number),
                of: self.label(number),
                field: "number of radii in boundary_mm",
                value: radii.len() as f64,
                allowed: format!("{least} to {most} are allowed"),
            });
        }
        radii
            .iter()
            .try_for_each(|radius| in_range(of, "a radius in boundary_mm", *radius, &HALF_AXES_MM))
    }

    /// What it is called in messages; `number` counts from 1.
    fn label(&self, number: usize) -> String {
        if self.name.is_empty() {
            format!("ellipse key {number}")
        } else {
            format!("ellipse key {number} ({})", self.name)
        }
    }
}

pub(super) fn check_settings(settings: &EllipseSettings) -> Result<(), MapError> {
    let of = || (None, "ellipse map".to_owned());
    in_range(
        of,
        "basic_radius_mm",
        settings.basic_radius_mm,
        &BASIC_RADII_MM,
    )?;
    in_range(
        of,
        "effect_radius_mm",
        settings.effect_radius_mm,
        &EFFECT_RADII_MM,
    )
}

/// Number of a key, and what it is called in messages.
type Of = (Option<usize>, String);

fn in_range(
    of: impl Fn() -> Of,
    field: &'static str,
    value: f64,
    allowed: &RangeInclusive<f64>,
) -> Result<(), MapError> {
    let what = format_args!("{} to {} is allowed", allowed.start(), allowed.end()).to_string();
    in_range_of(of, field, value, allowed.contains(&value), &what)
}

fn in_range_of(
    of: impl Fn() -> Of,
    field: &'static str,
    value: f64,
    holds: bool,
    allowed: &str,
) -> Result<(), MapError> {
    if holds {
        return Ok(());
    }
    let (key, of) = of();
    Err(MapError::Ellipse {
        key,
        of,
        field,
        value,
        allowed: allowed.to_owned(),
    })
}

/// The number of radii of all boundaries; 0 where there is none.
pub(super) fn radii_of_boundaries(keys: &[EllipseKey]) -> Result<usize, MapError> {
    let mut n_radii = 0;
    for (i, key) in keys.iter().enumerate() {
        let n = key.boundary_mm.as_ref().map_or(0, Vec::len);
        if n_radii > 0 && n > 0 && n != n_radii {
            return Err(MapError::Ellipse {
                key: Some(i + 1),
                of: key.label(i + 1),
                field: "number of radii in boundary_mm",
                value: n as f64,
                allowed: format!("{n_radii} as in the keys before it is allowed"),
            });
        }
        n_radii = n_radii.max(n);
    }
    Ok(n_radii)
}

/// The first key of each place.
pub(super) fn one_per_place(
    keys: &[EllipseKey],
    rule: AngleRule,
) -> Result<Vec<&EllipseKey>, MapError> {
    let at: Vec<Vec2> = keys.iter().map(|key| key.at).collect();
    let repeated = places::repeated(&at, SAME_PLACE_MM, |i, j| {
        if keys[i].states_the_same_as(&keys[j], rule) {
            return Ok(());
        }
        Err(MapError::EllipseConflict {
            keys: [i + 1, j + 1],
            names: [i, j].map(|k| keys[k].label(k + 1)),
            at: keys[i].at,
        })
    })?;
    let once = keys.iter().zip(&repeated);
    Ok(once
        .filter(|(_, repeated)| !**repeated)
        .map(|(key, _)| key)
        .collect())
}
