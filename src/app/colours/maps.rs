//! Colour maps, and scales from numbers to them.

use egui::Color32;

/// A perceptually uniform map from 0…1 to colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColourMap {
    /// From little to much: viridis (Smith & van der Walt 2015). Lightness rises evenly.
    Sequential,
    /// Below and above a middle: purple, near white, orange (Brewer's PuOr). Lightness falls evenly to both sides.
    Diverging,
    /// For directions: a hue circle of even lightness and chroma in Oklab (Ottosson 2020). 0 and 1 are the same.
    Cyclic,
}

impl ColourMap {
    /// All of them.
    pub fn all() -> [Self; 3] {
        [Self::Sequential, Self::Diverging, Self::Cyclic]
    }

    /// The colour at `t`, held to 0…1; where `t` is no number a mid grey that is in no map.
    pub fn at(self, t: f64) -> Color32 {
        if t.is_nan() {
            return Color32::from_gray(128);
        }
        let t = t.clamp(0.0, 1.0);
        match self {
            Self::Sequential => of(colorous::VIRIDIS.eval_continuous(t)),
            // Turned round: more than the middle is the warm side.
            Self::Diverging => of(colorous::PURPLE_ORANGE.eval_continuous(1.0 - t)),
            Self::Cyclic => oklch(0.70, 0.115, std::f64::consts::TAU * (t - t.floor())),
        }
    }
}

fn of(c: colorous::Color) -> Color32 {
    Color32::from_rgb(c.r, c.g, c.b)
}

/// A colour by lightness, chroma and hue in Oklab.
fn oklch(lightness: f64, chroma: f64, hue_rad: f64) -> Color32 {
    let (sin, cos) = hue_rad.sin_cos();
    let (a, b) = (chroma * cos, chroma * sin);
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    let linear = [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ];
    let [r, g, b] = linear.map(|c| {
        let c = c.clamp(0.0, 1.0);
        let coded = if c <= 0.003_130_8 {
            12.92 * c
        } else {
            1.055 * c.powf(1.0 / 2.4) - 0.055
        };
        (coded * 255.0).round() as u8
    });
    Color32::from_rgb(r, g, b)
}

/// Numbers laid on a colour map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The map.
    pub map: ColourMap,
    /// The number at its start.
    pub low: f64,
    /// The number at its end.
    pub high: f64,
}

impl Scale {
    /// A scale from `low` to `high`. An empty or unusable range becomes one about its number, so that legends read well.
    pub fn new(map: ColourMap, low: f64, high: f64) -> Self {
        let (low, high) = match (low.is_finite(), high.is_finite()) {
            (true, true) => (low, high),
            (true, false) => (low, low),
            (false, true) => (high, high),
            (false, false) => (0.0, 0.0),
        };
        let (low, high) = if low < high {
            (low, high)
        } else {
            let half = (0.5 * low.abs().max(high.abs()) * 0.02).max(1e-6);
            (low.min(high) - half, low.max(high) + half)
        };
        Self { map, low, high }
    }

    /// A scale as far below `middle` as above it.
    pub fn about(map: ColourMap, middle: f64, reach: f64) -> Self {
        let reach = reach.abs();
        Self::new(map, middle - reach, middle + reach)
    }

    /// Where on the map a number is, 0…1 inside the range.
    pub fn part(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    /// The colour of a number; beyond the range that of its nearer end.
    pub fn colour(&self, value: f64) -> Color32 {
        self.map.at(self.part(value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE lightness, 0…100.
    fn lightness(c: Color32) -> f64 {
        let linear = |c: u8| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 {
                c / 12.92
            } else {
                ((c + 0.055) / 1.055).powf(2.4)
            }
        };
        let y = 0.2126 * linear(c.r()) + 0.7152 * linear(c.g()) + 0.0722 * linear(c.b());
        116.0 * y.cbrt() - 16.0
    }

    fn along(map: ColourMap) -> Vec<f64> {
        (0..=64)
            .map(|i| lightness(map.at(f64::from(i) / 64.0)))
            .collect()
    }

    #[test]
    fn more_is_lighter_in_the_sequential_map() {
        assert!(along(ColourMap::Sequential).windows(2).all(|w| w[1] > w[0]));
    }

    #[test]
    fn both_sides_of_the_diverging_map_darken_from_its_middle() {
        let l = along(ColourMap::Diverging);
        assert!(l[..=32].windows(2).all(|w| w[1] > w[0] - 0.3), "{l:?}");
        assert!(l[32..].windows(2).all(|w| w[1] < w[0] + 0.3), "{l:?}");
        assert!(l[32] > 90.0);
    }

    #[test]
    fn the_cyclic_map_closes_and_no_direction_stands_out() {
        assert_eq!(ColourMap::Cyclic.at(0.0), ColourMap::Cyclic.at(1.0));
        let l = along(ColourMap::Cyclic);
        let (lo, hi) = (
            l.iter().copied().fold(f64::MAX, f64::min),
            l.iter().copied().fold(f64::MIN, f64::max),
        );
        assert!(hi - lo < 9.0, "{lo} to {hi}");
    }

    #[test]
    fn any_number_has_a_colour() {
        for map in ColourMap::all() {
            for (low, high) in [
                (0.0, 1.0),
                (3.0, 3.0),
                (f64::NAN, 1.0),
                (5.0, -5.0),
                (0.0, f64::INFINITY),
            ] {
                let scale = Scale::new(map, low, high);
                assert!(scale.low < scale.high && scale.low.is_finite() && scale.high.is_finite());
                for value in [f64::NAN, f64::INFINITY, -1e300, 0.5] {
                    let _ = scale.colour(value);
                }
            }
            let scale = Scale::about(map, 140.0, 20.0);
            assert_eq!(scale.colour(1e9), map.at(1.0));
            assert_eq!(scale.part(140.0), 0.5);
        }
    }
}
