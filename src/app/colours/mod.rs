//! Colours that stand for numbers, and the quantities of the skin that can be shown by them.
//!
//! | file | answers |
//! |---|---|
//! | [`map`] | which colour stands for a share of the range |
//! | [`range`] | which values a legend spans, and the numbers beside it |
//! | [`frame`] | quantities that change as the skin deforms |
//! | [`rest`] | quantities of the scene at rest |
//!
//! A quantity is one entry of [`all`]. Only the one on show is computed, and only then is memory held for it.

pub mod frame;
pub mod map;
pub mod range;
pub mod rest;

use crate::deform::Displacement;
use crate::scenario::Scene;
use crate::surface::Surface;
use frame::PerFrame;
use map::Map;
use range::Span;
use rest::Rest;

/// What can be shown.
#[derive(Clone, Copy)]
pub struct Quantity {
    /// Stable name: stored, and given to `--colour`.
    pub key: &'static str,
    /// Its name in the window, sentence case.
    pub name: &'static str,
    /// Unit of its values; empty for a plain number.
    pub unit: &'static str,
    /// Why one would look at it.
    pub about: &'static str,
    /// Its colours.
    pub map: Map,
    /// How its range follows the data.
    pub span: Span,
    /// Where its values come from.
    pub source: Source,
}

/// Where the values of a quantity come from.
#[derive(Clone, Copy)]
pub enum Source {
    /// From the deformed skin, anew for what each frame changes.
    Frame(fn(&Surface, &Displacement) -> Box<dyn PerFrame>),
    /// From the scene at rest, once.
    Rest(fn(&Scene) -> Rest),
}

impl PartialEq for Quantity {
    fn eq(&self, other: &Self) -> bool {
        self.key == other.key
    }
}

impl Quantity {
    /// Whether level lines can be drawn: on what stands still.
    pub fn has_contours(&self) -> bool {
        matches!(self.source, Source::Rest(_))
    }

    /// Why its values are the same everywhere on `scene`, where they are.
    pub fn why_same(&self, scene: &Scene) -> Option<&'static str> {
        match self.source {
            Source::Rest(of) => match of(scene) {
                Rest::Same { why, .. } => Some(why),
                Rest::PerVertex(_) => None,
            },
            Source::Frame(_) => None,
        }
    }

    /// A value with its unit.
    pub fn written(&self, value: f64, digits: usize) -> String {
        // −0 would be told from 0.
        let value = if value == 0.0 { 0.0 } else { value };
        let number = format!("{value:.digits$}").replace('-', "−");
        match self.unit {
            "" => number,
            "°" => format!("{number}°"),
            unit => format!("{number} {unit}"),
        }
    }
}

/// The key of no quantity: bare skin.
pub const SKIN: &str = "skin";

/// Every quantity, in the order of the menu.
pub fn all() -> &'static [Quantity] {
    const ALL: &[Quantity] = &[
        Quantity {
            key: "strain",
            name: "Strain",
            unit: "%",
            about: "Where the skin is stretched (red) and compressed (blue): mean change of the edges at each vertex",
            map: Map::Diverging,
            span: Span::Symmetric,
            source: Source::Frame(frame::strain),
        },
        Quantity {
            key: "displacement",
            name: "Displacement",
            unit: "mm",
            about: "How far the fingers have moved the skin from rest",
            map: Map::FromRest,
            span: Span::FromZero,
            source: Source::Frame(frame::displacement),
        },
        Quantity {
            key: "stiffness",
            name: "Stiffness",
            unit: "N/mm",
            about: "How hard the skin is to press: what a finger feels there",
            map: Map::Sequential,
            span: Span::Data,
            source: Source::Rest(rest::stiffness),
        },
        Quantity {
            key: "half-major",
            name: "Half major axis",
            unit: "mm",
            about: "How far a press reaches along the stiff direction of the skin",
            map: Map::Sequential,
            span: Span::Data,
            source: Source::Rest(rest::half_major),
        },
        Quantity {
            key: "ratio",
            name: "Major over minor axis",
            unit: "",
            about: "How much farther a press reaches one way than across: 1 is a circle",
            map: Map::Sequential,
            span: Span::Data,
            source: Source::Rest(rest::ratio),
        },
        Quantity {
            key: "direction",
            name: "Direction",
            unit: "°",
            about: "Which way a press reaches farthest, seen from behind: 0° lies across, 90° along the spine",
            map: Map::Cyclic,
            span: Span::HalfTurn,
            source: Source::Rest(rest::direction),
        },
    ];
    ALL
}

/// The quantity with this key; `None` inside for [`SKIN`].
///
/// # Errors
/// A key that is none, in one line with those that are.
pub fn named(key: &str) -> Result<Option<&'static Quantity>, String> {
    if key == SKIN {
        return Ok(None);
    }
    all()
        .iter()
        .find(|q| q.key == key)
        .map(Some)
        .ok_or_else(|| {
            let keys: Vec<&str> = all().iter().map(|q| q.key).collect();
            format!(
                "there is no surface colour \"{key}\"; allowed are {SKIN}, {}",
                keys.join(", ")
            )
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn quantities_have_distinct_keys_and_names_and_say_why() {
        let mut seen = HashSet::from([SKIN]);
        for q in all() {
            assert!(seen.insert(q.key) && seen.insert(q.name));
            assert!(q.about.len() > q.name.len() && !q.about.ends_with('.'));
            assert!(named(q.key) == Ok(Some(q)));
        }
        assert!(named(SKIN) == Ok(None));
        let refused = named("colour").err().unwrap_or_default();
        assert!(refused.contains("\"colour\"") && refused.contains("strain"));
    }

    #[test]
    fn values_are_written_with_their_unit() {
        let of = |key| named(key).ok().flatten().copied().expect("listed");
        assert_eq!(of("strain").written(-3.25, 1), "−3.2 %");
        assert_eq!(of("strain").written(-0.0, 0), "0 %");
        assert_eq!(of("direction").written(90.0, 0), "90°");
        assert_eq!(of("ratio").written(1.357, 2), "1.36");
    }
}
