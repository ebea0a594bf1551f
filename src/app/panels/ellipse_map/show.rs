//! What of the map is shown, and in which colours.

use super::doc::Doc;
use crate::app::colours::map::Map;
use crate::app::editor::field::{Picture, Reader, Spec};
use crate::app::editor::plane::round_step;
use crate::app::editor::scale::Scale;
use crate::geom::Vec2;
use crate::maps::{AngleRule, EllipseMap, EllipseSettings, Form, Level, Oval};
use std::sync::Arc;

/// A value of the ellipse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quantity {
    /// Half the major axis.
    #[default]
    HalfMajor,
    /// Major over minor axis.
    Ratio,
    /// Direction of the major axis.
    Direction,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::HalfMajor, Self::Ratio, Self::Direction];

    /// Its name in the window.
    pub fn text(self) -> &'static str {
        match self {
            Self::HalfMajor => "Half major axis",
            Self::Ratio => "Ratio",
            Self::Direction => "Direction",
        }
    }

    /// Why one would look at it.
    pub fn about(self) -> &'static str {
        match self {
            Self::HalfMajor => "How far a drag carries the skin along its easiest direction, mm",
            Self::Ratio => "Major over minor axis: 1 is a circle",
            Self::Direction => "Of the major axis from x, degrees; 0 and 180 are the same",
        }
    }

    /// Its unit; empty for a plain number.
    pub fn unit(self) -> &'static str {
        match self {
            Self::HalfMajor => "mm",
            Self::Ratio => "",
            Self::Direction => "°",
        }
    }

    /// Decimals that a person can use.
    pub fn decimals(self) -> usize {
        match self {
            Self::HalfMajor | Self::Direction => 1,
            Self::Ratio => 3,
        }
    }

    /// Decimals of round numbers beside the colours.
    pub fn legend_decimals(self) -> usize {
        match self {
            Self::HalfMajor | Self::Direction => 0,
            Self::Ratio => 2,
        }
    }

    /// Its value.
    pub fn of(self, oval: &Oval) -> f64 {
        match self {
            Self::HalfMajor => oval.half_major_mm,
            Self::Ratio => oval.major_over_minor(),
            Self::Direction => oval.angle_rad.to_degrees(),
        }
    }

    /// How much `a` is above `b`; of directions the turn from `b` to `a`, −90 to 90.
    pub fn difference(self, a: &Oval, b: &Oval) -> f64 {
        let d = self.of(a) - self.of(b);
        match self {
            Self::Direction => d - 180.0 * (d / 180.0).round(),
            _ => d,
        }
    }
}

/// What the canvas shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Show {
    /// The value shown as colour and lines.
    pub quantity: Quantity,
    /// Published less corrected, in place of the map.
    pub difference: bool,
    /// The value as colour.
    pub colour: bool,
    /// Lines of equal value.
    pub lines: bool,
    /// A grid of ellipses.
    pub ellipses: bool,
    /// The keys' ellipses.
    pub keys: bool,
    /// Size of the keys' ellipses on the canvas, part of their true size.
    pub key_size: f64,
    /// How far the selected key has an effect, and the basic circle.
    pub reach: bool,
    /// The outline of the back.
    pub outline: bool,
    /// What lies beside the back dimmed.
    pub veiled: bool,
}

impl Default for Show {
    fn default() -> Self {
        Self {
            quantity: Quantity::HalfMajor,
            difference: false,
            colour: true,
            lines: true,
            ellipses: true,
            keys: true,
            key_size: 0.25,
            reach: false,
            outline: true,
            veiled: true,
        }
    }
}

/// The map in use, and both forms of it.
pub struct Maps {
    /// As the scenario chooses.
    pub map: EllipseMap,
    /// Everything as printed.
    pub published: EllipseMap,
    /// The default: exact at every key.
    pub corrected: EllipseMap,
}

impl Maps {
    fn of(doc: &Doc) -> Result<Self, String> {
        let with = |settings: EllipseSettings| {
            Doc {
                settings,
                ..doc.clone()
            }
            .map()
        };
        Ok(Self {
            map: doc.map()?,
            published: with(published(doc.settings))?,
            corrected: with(corrected(doc.settings))?,
        })
    }

    /// The value on show at a place.
    pub fn value(&self, show: &Show, place: Vec2) -> f64 {
        if show.difference {
            let (p, c) = (self.published.at(place), self.corrected.at(place));
            show.quantity.difference(&p, &c)
        } else {
            show.quantity.of(&self.map.at(place))
        }
    }
}

/// As printed, with the radii in use.
pub fn published(settings: EllipseSettings) -> EllipseSettings {
    settings.published()
}

/// As corrected, with the radii in use.
pub fn corrected(settings: EllipseSettings) -> EllipseSettings {
    EllipseSettings {
        form: Form::Corrected,
        angle: AngleRule::Tensor,
        level: Level::Exact,
        ..settings
    }
}

/// What the field shall be; `state` is another number for each state of the map.
pub fn spec(doc: &Doc, state: u64, show: &Show) -> Spec<Maps> {
    let (doc, show) = (doc.clone(), *show);
    Spec {
        map: state,
        quantity: show.quantity as u64 * 2 + u64::from(show.difference),
        build: Arc::new(move || Maps::of(&doc)),
        read: Arc::new(move |maps: &Maps| -> Reader<'_> {
            Box::new(move |place| maps.value(&show, place))
        }),
        lines: show.quantity != Quantity::Direction || show.difference,
        line_at_zero: !show.difference,
    }
}

/// The colours: the same while keys move about, so that nothing flickers.
pub fn scale(doc: &Doc, show: &Show, picture: &Picture<Maps>) -> Scale {
    if show.difference {
        let largest = picture.grid.largest().map_or(0.0, |(v, _)| v.abs());
        return Scale::about(Map::Diverging, 0.0, rounded_up(largest, 1e-3));
    }
    let keys = doc.keys.iter().filter(|_| doc.on);
    match show.quantity {
        Quantity::HalfMajor => {
            let basic = doc.settings.basic_radius_mm;
            let reach = keys
                .map(|k| (k.half_major_mm - basic).abs())
                .fold(0.0, f64::max);
            Scale::about(Map::Diverging, basic, rounded_up(reach, 1.0))
        }
        Quantity::Ratio => {
            let most = keys
                .map(|k| k.oval().major_over_minor())
                .fold(1.0, f64::max);
            Scale::new(Map::Sequential, 1.0, 1.0 + rounded_up(most - 1.0, 0.01))
        }
        Quantity::Direction => Scale::new(Map::Cyclic, 0.0, 180.0),
    }
}

/// The next round number above `value`, at least `least`.
fn rounded_up(value: f64, least: f64) -> f64 {
    let step = round_step(value.max(least), 4.0);
    (value.max(least) / step - 1e-9).ceil() * step
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_differ_by_a_quarter_turn_at_most() {
        let oval = |deg: f64| Oval {
            half_major_mm: 150.0,
            half_minor_mm: 100.0,
            angle_rad: deg.to_radians(),
        };
        let d = |a, b| Quantity::Direction.difference(&oval(a), &oval(b));
        assert!((d(5.0, 175.0) - 10.0).abs() < 1e-9);
        assert!((d(175.0, 5.0) + 10.0).abs() < 1e-9);
        assert!((d(100.0, 30.0) - 70.0).abs() < 1e-9);
        assert_eq!(Quantity::Ratio.of(&oval(3.0)), 1.5);
    }

    #[test]
    fn ranges_end_at_round_numbers() {
        assert_eq!(rounded_up(38.0, 1.0), 40.0);
        assert_eq!(rounded_up(0.0, 1.0), 1.0);
        assert_eq!(rounded_up(40.0, 1.0), 40.0);
        assert!((rounded_up(0.357, 0.01) - 0.4).abs() < 1e-12);
    }
}
