//! Gaussian radial interpolation (Ji 2008, 5.2): keys stand out of a uniform ground, each within its effect radius.
//!
//! With a_i the effect level of key i at a point, r_c the ground and r_i the key's value, V_i = r_c (1 − a_i) + r_i a_i
//! (eq. 5.4) and the field is Σ V_i w_i / Σ w_i over the keys in range, or r_c where there is none:
//!
//! | form | w_i | |
//! |---|---|---|
//! | published (5.7) | a_i | stacks; misses the keys where their ranges overlap |
//! | corrected (5.16) | a_i Π_{j≠i} (1 − a_j) | meets the keys |
//!
//! Divided by Π (1 − a_j) the corrected weight is a_i / (1 − a_i): a sum over keys instead of products, which neither costs
//! the square of their number nor underflows with thousands. Eq. 5.17 as printed drops the a_i; 5.16 is meant.
//!
//! The level is a half Gaussian over distance / effect radius, exp(−π (1.4 q)²).

use crate::geom::Vec2;
use crate::geom::curve::{Curve, Lookup, PUBLISHED_SIZE};

/// A key this close to a point answers for it alone, mm: a micrometre.
///
/// The corrected form tends to the key there anyway: at this distance another key d away still has a share of about
/// (1 µm / d)².
pub const ALONE_MM: f64 = 1.0e-3;

/// Where the exact level starts on its way to 0 at the effect radius, as a ratio.
///
/// A Gaussian alone would drop by 0.0021 there, and the field with it. It is below 0.007 from here on, and the printed
/// figures lie within.
const FADE_FROM: f64 = 0.9;

/// How keys stack.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Form {
    /// Exact at every key (Ji 2008, eq. 5.16).
    #[default]
    Corrected,
    /// As first derived (Ji 2008, eq. 5.7): misses keys that lie in range of each other. For comparison.
    Published,
}

impl Form {
    /// Every form; the default first.
    pub fn all() -> &'static [Self] {
        &[Self::Corrected, Self::Published]
    }

    /// Name in files, tables and the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Corrected => "corrected",
            Self::Published => "published",
        }
    }
}

/// How the effect level is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Level {
    /// The Gaussian itself. Within the last tenth of the effect radius, where it is below 0.007, it is taken smoothly to 0,
    /// so that the field is continuous.
    #[default]
    Exact,
    /// As printed: the nearest of 700 samples. The field has small terraces, and a step of 0.0021 at the effect radius.
    Array,
}

impl Level {
    /// Both; the default first.
    pub fn all() -> &'static [Self] {
        &[Self::Exact, Self::Array]
    }

    /// Name in files, tables and the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Array => "array",
        }
    }
}

/// What [`Gri::weigh`] found in range of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Weighed {
    /// No key: the ground.
    Ground,
    /// One key answers alone.
    Alone(usize),
    /// Sum of the weights; those of the keys, times their levels, were handed out.
    Sum(f64),
}

/// Places and levels. Knows no values: whoever has some adds them up by the weights.
#[derive(Clone, Debug)]
pub(super) struct Gri {
    places: Vec<Vec2>,
    effect_radius_mm: f64,
    form: Form,
    /// The published array; empty for the exact level.
    array: Vec<f64>,
}

/// Level of a key, and its weight in the corrected form.
struct Effect {
    level: f64,
    weight: f64,
}

impl Gri {
    /// `places` finite, `effect_radius_mm` positive and finite.
    pub fn new(places: Vec<Vec2>, effect_radius_mm: f64, form: Form, level: Level) -> Self {
        let array = match level {
            Level::Exact => Vec::new(),
            Level::Array => Curve::gaussian_printed(PUBLISHED_SIZE, Lookup::Nearest)
                .samples()
                .to_vec(),
        };
        Self {
            places,
            effect_radius_mm,
            form,
            array,
        }
    }

    /// Hands `add` each key in range with w_i a_i and returns Σ w_i: the field is then r_c + Σ w_i a_i (r_i − r_c) / Σ w_i.
    pub fn weigh(&self, place: Vec2, mut add: impl FnMut(usize, f64)) -> Weighed {
        let reach_sq = self.effect_radius_mm * self.effect_radius_mm;
        if self.form == Form::Corrected
            && let Some((nearest, distance_sq)) = self.nearest(place)
            && (distance_sq <= ALONE_MM * ALONE_MM || self.effect(distance_sq.sqrt()).level >= 1.0)
        {
            return Weighed::Alone(nearest);
        }
        let mut sum = 0.0;
        for (i, key) in self.places.iter().enumerate() {
            let distance_sq = key.distance_squared(place);
            if distance_sq > reach_sq {
                continue;
            }
            let effect = self.effect(distance_sq.sqrt());
            let weight = match self.form {
                Form::Corrected => effect.weight,
                Form::Published => effect.level,
            };
            if weight > 0.0 {
                sum += weight;
                add(i, weight * effect.level);
            }
        }
        if sum > 0.0 {
            Weighed::Sum(sum)
        } else {
            Weighed::Ground
        }
    }

    /// The nearest key, the first of several, and the square of its distance, mm².
    fn nearest(&self, place: Vec2) -> Option<(usize, f64)> {
        let distances = self.places.iter().map(|key| key.distance_squared(place));
        distances
            .enumerate()
            .min_by(|(_, s), (_, t)| s.total_cmp(t))
    }

    fn effect(&self, distance_mm: f64) -> Effect {
        let q = distance_mm / self.effect_radius_mm;
        if q > 1.0 {
            return Effect {
                level: 0.0,
                weight: 0.0,
            };
        }
        if let Some(last) = self.array.len().checked_sub(1) {
            let level = self.array[((q * last as f64 + 0.5) as usize).min(last)];
            let weight = level / (1.0 - level);
            return Effect { level, weight };
        }
        // With g = exp(−x), 1/(1 + (exp(x) − 1)) is g and 1/(exp(x) − 1) is g/(1 − g), without loss near the key.
        let x = 1.4 * q;
        let rise = libm::expm1(std::f64::consts::PI * x * x);
        if q <= FADE_FROM {
            return Effect {
                level: 1.0 / (1.0 + rise),
                weight: 1.0 / rise,
            };
        }
        let t = (1.0 - q) / (1.0 - FADE_FROM);
        let level = t * t * (3.0 - 2.0 * t) / (1.0 + rise);
        let weight = level / (1.0 - level);
        Effect { level, weight }
    }
}
