//! Continuous functions through scattered values. They know places and numbers only.
//!
//! Every one is positive and finite where its samples are, meets them exactly (but for [`Fit::Constant`]), says what it does
//! outside their hull, and answers the same bits on every machine and for any order of questions.

mod constant;
mod gri;
mod hull;
mod idw;
mod natural;
mod rbf;

use super::MapError;
use crate::geom::Vec2;
use std::fmt;
use std::sync::Arc;

pub use rbf::MOST_KEYS as MOST_RBF_KEYS;

/// Places closer than this to each other are one place, and a place this close to the hull lies on it, mm.
///
/// A nanometre: far above what rounding does to coordinates of a body (1e-13 mm), far below what anyone can mean. Three
/// places that rounding has pushed off a line would otherwise span a sliver in which the field runs through all its values.
pub(super) const TOUCHING_MM: f64 = 1.0e-6;

/// A value at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub at: Vec2,
    pub value: f64,
}

/// A fitted function.
pub(super) trait Field: fmt::Debug + Send + Sync {
    /// A reader of the field; it may hold scratch memory, so one should serve many places.
    fn reader(&self) -> Box<dyn Reader + '_>;
}

/// A fitted function, or why there is none.
pub(super) type Fitted = Result<Arc<dyn Field>, MapError>;

/// Reads a field at one place after another.
pub(super) trait Reader {
    /// Value at a finite place.
    fn at(&mut self, place: Vec2) -> f64;
}

impl<F: FnMut(Vec2) -> f64> Reader for F {
    fn at(&mut self, place: Vec2) -> f64 {
        self(place)
    }
}

/// Continuous functions through the keys of a stiffness map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fit {
    /// Natural neighbour (Sibson 1981) inside the hull of the keys; outside, the value at the closest point of the hull.
    #[default]
    Natural,
    /// Gaussian radial interpolation, corrected form (Ji 2008, eq. 5.16), with the mean of the keys as the ground and an
    /// effect radius of 200 mm. Farther than that from every key, the mean.
    Gri,
    /// Thin-plate spline (Duchon 1977) through the logarithms, so it stays positive; kept within half the least and twice
    /// the largest key. Outside the hull, the value at the closest point of the hull. At most [`MOST_RBF_KEYS`] keys.
    Rbf,
    /// Inverse distance weighting (Shepard 1968), weights 1/d². Far outside it tends to the mean of the keys.
    Idw,
    /// The geometric mean of the keys, everywhere. Meets no key in particular.
    Constant,
}

/// What is known of a fit: name, what it does in a few words, and how it is made.
struct Listed {
    fit: Fit,
    name: &'static str,
    about: &'static str,
    through: fn(&[Sample]) -> Fitted,
}

const LIST: [Listed; 5] = [
    Listed {
        fit: Fit::Natural,
        name: "natural",
        about: "Natural neighbour: follows the keys closely, never beyond their values",
        through: natural::through,
    },
    Listed {
        fit: Fit::Gri,
        name: "gri",
        about: "Gaussian radial: keys stand out of their mean, each within 200 mm",
        through: gri::through,
    },
    Listed {
        fit: Fit::Rbf,
        name: "rbf",
        about: "Thin-plate spline in the logarithm: the smoothest, may swing beyond the keys by up to twice",
        through: rbf::through,
    },
    Listed {
        fit: Fit::Idw,
        name: "idw",
        about: "Inverse distance: flat about each key, the mean of all far away",
        through: idw::through,
    },
    Listed {
        fit: Fit::Constant,
        name: "constant",
        about: "One stiffness everywhere: the geometric mean of the keys",
        through: constant::through,
    },
];

impl Fit {
    /// Every fit; the default first.
    pub fn all() -> &'static [Self] {
        const ALL: [Fit; LIST.len()] = {
            let mut all = [Fit::Natural; LIST.len()];
            let mut i = 0;
            while i < LIST.len() {
                all[i] = LIST[i].fit;
                i += 1;
            }
            all
        };
        &ALL
    }

    /// Name in files, tables and the command line.
    pub fn name(self) -> &'static str {
        self.listed().name
    }

    /// What it does, in a few words.
    pub fn about(self) -> &'static str {
        self.listed().about
    }

    fn listed(self) -> &'static Listed {
        // Every fit is in the list; a test loops over it.
        LIST.iter().find(|l| l.fit == self).unwrap_or(&LIST[0])
    }

    /// The function through `samples`: at least one, all finite and positive, no two within [`TOUCHING_MM`].
    pub(super) fn through(self, samples: &[Sample]) -> Fitted {
        if samples.is_empty() {
            return Err(MapError::NoKeys);
        }
        (self.listed().through)(samples)
    }
}
