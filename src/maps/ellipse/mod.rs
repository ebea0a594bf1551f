//! The ellipse map: how far and which way a tangential drag carries the skin, at every point of the map plane.
//!
//! Measured key ellipses stand out of a uniform ground, the basic circle (Ji 2008, 5.1–5.2); between them
//! [Gaussian radial interpolation](super::gri). Half major axis, ratio and direction are interpolated as the text says,
//! except that the default takes ratio and direction together ([`AngleRule::Tensor`]).
//!
//! The ellipses are what a drag *along the spine* showed, on five subjects: an isotropic half-space, too, gives contours
//! 1/(1 − ν) longer along a drag than across it, so the data do not tell the direction of the muscle from that of the drag.

mod field;
mod keys;
mod oval;

use super::gri::{Form, Gri, Level, Weighed};
use super::{MapError, on_map};
use crate::geom::Vec2;
use crate::surface::Surface;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::ops::RangeInclusive;

pub use field::EllipseField;
pub use keys::{EllipseKey, SAME_PLACE_MM};
pub use oval::{Oval, axial};

/// Radius of the basic circle unless told otherwise, mm. Not printed for the back: ours.
pub const BASIC_RADIUS_MM: f64 = 140.0;

/// Effect radius of a key unless told otherwise, mm. Not printed for the back: ours.
pub const EFFECT_RADIUS_MM: f64 = 200.0;

/// Radii allowed for the basic circle, mm.
pub const BASIC_RADII_MM: RangeInclusive<f64> = 1.0..=1000.0;

/// Effect radii allowed, mm.
pub const EFFECT_RADII_MM: RangeInclusive<f64> = 1.0..=10_000.0;

/// Half axes and boundary radii allowed, mm.
pub const HALF_AXES_MM: RangeInclusive<f64> = 1.0..=1000.0;

/// Radii that a boundary may have.
pub const BOUNDARY_RADII: RangeInclusive<usize> = 8..=72;

/// How directions are interpolated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AngleRule {
    /// As a symmetric tensor: the vector (major/minor − 1) at twice the angle, which is 0 for the basic circle.
    ///
    /// An axis stated as 0° or 180° is the same; 5° and 175° meet at 0°; where keys agree in direction the ratio is that of
    /// the published rule. Where directions cancel, the ellipse is a circle there, so the field is continuous everywhere.
    #[default]
    Tensor,
    /// As published: ratio and angle each by themselves, the angle linear in degrees and 90° for the basic circle. 5° and
    /// 175° then meet at 90°, and an axis stated as 180° differs from one stated as 0°.
    Linear,
}

impl AngleRule {
    /// Both; the default first.
    pub fn all() -> &'static [Self] {
        &[Self::Tensor, Self::Linear]
    }

    /// Name in files, tables and the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tensor => "tensor",
            Self::Linear => "linear",
        }
    }
}

/// What a map may choose beside its keys.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EllipseSettings {
    /// Radius of the basic circle, mm.
    pub basic_radius_mm: f64,
    /// How far a key has an effect, mm.
    pub effect_radius_mm: f64,
    /// How keys stack.
    pub form: Form,
    /// How directions are interpolated.
    pub angle: AngleRule,
    /// How the effect level is read.
    pub level: Level,
}

impl Default for EllipseSettings {
    fn default() -> Self {
        Self {
            basic_radius_mm: BASIC_RADIUS_MM,
            effect_radius_mm: EFFECT_RADIUS_MM,
            form: Form::default(),
            angle: AngleRule::default(),
            level: Level::default(),
        }
    }
}

impl EllipseSettings {
    /// Everything as printed: eq. 5.7, the array of 700, angles linear in degrees.
    #[must_use]
    pub fn published(self) -> Self {
        Self {
            form: Form::Published,
            angle: AngleRule::Linear,
            level: Level::Array,
            ..self
        }
    }
}

/// The ellipse at every point of the map plane. Finite everywhere, the half axes within those of keys and basic circle.
#[derive(Clone, Debug)]
pub struct EllipseMap {
    /// As given.
    keys: Vec<EllipseKey>,
    settings: EllipseSettings,
    /// One key per place, in the order of `gri`.
    distinct: Vec<Distinct>,
    gri: Gri,
    /// Radii per boundary; 0 where no key has one.
    n_radii: usize,
}

/// A key, ready to be weighed.
#[derive(Clone, Debug)]
struct Distinct {
    oval: Oval,
    /// As stated, rad: what the linear rule takes.
    stated_angle_rad: f64,
    major_over_minor: f64,
    anisotropy: Vec2,
    /// Empty where no key has a boundary.
    boundary_mm: Vec<f64>,
}

impl EllipseMap {
    /// A map through `keys`; none at all make the basic circle everywhere. A key stated twice counts once.
    ///
    /// # Errors
    /// A place, length or angle that is not allowed; two keys within [`SAME_PLACE_MM`] of each other that state different
    /// ellipses; boundaries with different numbers of radii.
    pub fn new(keys: Vec<EllipseKey>, settings: EllipseSettings) -> Result<Self, MapError> {
        keys::check_settings(&settings)?;
        for (i, key) in keys.iter().enumerate() {
            key.check(i + 1)?;
        }
        let n_radii = keys::radii_of_boundaries(&keys)?;
        let once = keys::one_per_place(&keys, settings.angle)?;
        let distinct = once
            .iter()
            .map(|key| Distinct {
                oval: key.oval(),
                stated_angle_rad: key.angle_rad,
                major_over_minor: key.half_major_mm / key.half_minor_mm,
                anisotropy: key.oval().anisotropy(),
                boundary_mm: key.boundary(n_radii),
            })
            .collect();
        let places = once.iter().map(|key| key.at).collect();
        let gri = Gri::new(
            places,
            settings.effect_radius_mm,
            settings.form,
            settings.level,
        );
        Ok(Self {
            keys,
            settings,
            distinct,
            gri,
            n_radii,
        })
    }

    /// The keys, as given.
    pub fn keys(&self) -> &[EllipseKey] {
        &self.keys
    }

    /// What the map chooses beside its keys.
    pub fn settings(&self) -> &EllipseSettings {
        &self.settings
    }

    /// Whether it is the basic circle everywhere, so that no value per vertex is needed.
    pub fn is_circle(&self) -> bool {
        let basic = self.settings.basic_radius_mm;
        self.n_radii == 0
            && self
                .distinct
                .iter()
                .all(|key| key.oval.half_major_mm == basic && key.oval.half_minor_mm == basic)
    }

    /// The ellipse at a point of the map plane; that of a key at the key, the basic circle where none is in range.
    ///
    /// A coordinate that is not a number counts as 0, one beyond 1e6 mm as 1e6 mm.
    pub fn at(&self, place: Vec2) -> Oval {
        let basic_mm = self.settings.basic_radius_mm;
        let (mut major, mut ratio, mut angle) = (0.0, 0.0, 0.0);
        let mut anisotropy = Vec2::ZERO;
        let weighed = self.gri.weigh(on_map(place), |i, weight| {
            let key = &self.distinct[i];
            major += weight * (key.oval.half_major_mm - basic_mm);
            match self.settings.angle {
                AngleRule::Tensor => anisotropy += key.anisotropy * weight,
                AngleRule::Linear => {
                    ratio += weight * (key.major_over_minor - 1.0);
                    angle += weight * (key.stated_angle_rad - FRAC_PI_2);
                }
            }
        });
        let sum = match weighed {
            Weighed::Ground => return Oval::circle(basic_mm),
            Weighed::Alone(i) => return self.distinct[i].oval,
            Weighed::Sum(sum) => sum,
        };
        let half_major_mm = basic_mm + major / sum;
        match self.settings.angle {
            AngleRule::Tensor => Oval::of_anisotropy(half_major_mm, anisotropy / sum),
            AngleRule::Linear => Oval {
                half_major_mm,
                half_minor_mm: half_major_mm / (1.0 + (ratio / sum).max(0.0)),
                angle_rad: axial(FRAC_PI_2 + angle / sum),
            },
        }
    }

    /// The irregular boundary at a point of the map plane: radii at equal angles from x, mm. `None` where no key has one.
    ///
    /// Each radius is interpolated by itself, by the map's form. A key without a boundary takes part with the radii of its
    /// ellipse, the ground with the basic circle.
    pub fn boundary_at(&self, place: Vec2) -> Option<Vec<f64>> {
        let mut radii = Vec::new();
        self.boundary_into(place, &mut radii).then_some(radii)
    }

    /// The same into `radii_mm`, which a caller may use again; `false`, and nothing in it, where no key has a boundary.
    pub fn boundary_into(&self, place: Vec2, radii_mm: &mut Vec<f64>) -> bool {
        radii_mm.clear();
        if self.n_radii == 0 {
            return false;
        }
        let basic_mm = self.settings.basic_radius_mm;
        radii_mm.resize(self.n_radii, 0.0);
        let weighed = self.gri.weigh(on_map(place), |i, weight| {
            for (sum, radius) in radii_mm.iter_mut().zip(&self.distinct[i].boundary_mm) {
                *sum += weight * (radius - basic_mm);
            }
        });
        match weighed {
            Weighed::Ground => radii_mm.fill(basic_mm),
            Weighed::Alone(i) => radii_mm.copy_from_slice(&self.distinct[i].boundary_mm),
            Weighed::Sum(sum) => {
                for radius in radii_mm {
                    *radius = basic_mm + *radius / sum;
                }
            }
        }
        true
    }

    /// Radii per boundary, `None` where no key has one.
    pub fn n_radii(&self) -> Option<usize> {
        (self.n_radii > 0).then_some(self.n_radii)
    }

    /// The map at every vertex of a surface, seen along z (Ji 2008, 5.3). The same bits for any number of threads.
    pub fn per_vertex(&self, surface: &Surface) -> EllipseField {
        EllipseField::of(self, surface)
    }
}

/// Direction of radius `i` of `n`, rad from x.
fn radius_direction(i: usize, n: usize) -> f64 {
    TAU * i as f64 / n as f64
}
