//! Colour maps, as tables of 256 sRGB colours.
//!
//! | map | source |
//! |---|---|
//! | sequential | Viridis (van der Walt & Smith 2015), from the crate `colorous` |
//! | from rest | ours: a straight line in OKLab (Ottosson 2020) from a light grey to a dark green |
//! | diverging | ours: two such lines, to a dark blue and a dark red |
//! | cyclic | ours: a circle of constant lightness and chroma in OKLab |
//!
//! Equal steps of value are equal steps of colour in all of them. The grey is lighter than the dark window's floor and
//! darker than the light one's. No map comes near the blue and the red that fingers wear: they are
//! held apart by lightness and chroma (a test tells how far).

use std::sync::OnceLock;

/// Entries of a table.
pub const ENTRIES: usize = 256;

/// A table of colours, sRGB.
pub type Table = [[u8; 3]; ENTRIES];

/// The maps there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Map {
    /// From dark to light: for magnitudes.
    Sequential,
    /// From light grey to dark green: for what is 0 nearly everywhere, so that relief reads best where nothing happens.
    FromRest,
    /// Blue below the middle, red above it: for signed values.
    Diverging,
    /// The end is the beginning: for directions.
    Cyclic,
}

impl Map {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Sequential,
        Self::FromRest,
        Self::Diverging,
        Self::Cyclic,
    ];

    /// Its colours. Entry i stands for i/255 of the range; of the cyclic map for i/256 of the circle.
    pub fn table(self) -> &'static Table {
        static TABLES: [OnceLock<Table>; 4] = [const { OnceLock::new() }; 4];
        TABLES[self as usize].get_or_init(|| {
            std::array::from_fn(|i| {
                let last = (ENTRIES - 1) as f64;
                match self {
                    Self::Sequential => colorous::VIRIDIS
                        .eval_continuous(i as f64 / last)
                        .as_array(),
                    Self::FromRest => between(MIDDLE, FAR, i as f64 / last),
                    Self::Diverging => diverging(i as f64 / last),
                    Self::Cyclic => cyclic(i as f64 / ENTRIES as f64),
                }
            })
        })
    }

    /// The colour at a share of the range, sRGB: 0 at its lower end, 1 at its upper one. What lies outside gets the colour of
    /// the end; on the cyclic map it goes round. No number counts as 0.
    pub fn at(self, share: f64) -> [u8; 3] {
        let share = if share.is_finite() { share } else { 0.0 };
        let index = match self {
            Self::Cyclic => (share.rem_euclid(1.0) * ENTRIES as f64).round() as usize % ENTRIES,
            _ => (share.clamp(0.0, 1.0) * (ENTRIES - 1) as f64).round() as usize,
        };
        self.table()[index]
    }

    /// The same as a colour of the window.
    pub fn color(self, share: f64) -> egui::Color32 {
        let [r, g, b] = self.at(share);
        egui::Color32::from_rgb(r, g, b)
    }
}

/// Lightness, chroma and hue (degrees) of the middle and of both ends of the diverging map.
const MIDDLE: [f64; 3] = [0.86, 0.0, 0.0];
const COMPRESSION: [f64; 3] = [0.38, 0.125, 257.0];
const TENSION: [f64; 3] = [0.38, 0.140, 24.0];
/// The other end of the map from rest.
const FAR: [f64; 3] = [0.36, 0.100, 152.0];
/// Lightness and chroma of the cyclic map: the largest circle that keeps inside sRGB and away from the fingers.
const CIRCLE: [f64; 2] = [0.76, 0.105];
/// Hue of direction 0, degrees: across the back is violet, along the spine green.
const FIRST_HUE: f64 = 315.0;

fn diverging(share: f64) -> [u8; 3] {
    let signed = 2.0 * share - 1.0;
    let end = if signed < 0.0 { COMPRESSION } else { TENSION };
    between(MIDDLE, end, signed.abs())
}

/// On the straight line between two colours.
fn between(from: [f64; 3], to: [f64; 3], part: f64) -> [u8; 3] {
    let (from, to) = (lab(from), lab(to));
    srgb(std::array::from_fn(|k| from[k] + (to[k] - from[k]) * part))
}

fn cyclic(share: f64) -> [u8; 3] {
    srgb(lab([CIRCLE[0], CIRCLE[1], FIRST_HUE + 360.0 * share]))
}

fn lab([lightness, chroma, hue_deg]: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = hue_deg.to_radians().sin_cos();
    [lightness, chroma * cos, chroma * sin]
}

/// OKLab to sRGB (Ottosson 2020), cut to what sRGB holds.
fn srgb([l, a, b]: [f64; 3]) -> [u8; 3] {
    let cone = |ka: f64, kb: f64| (l + ka * a + kb * b).powi(3);
    let c = [
        cone(0.396_337_777_4, 0.215_803_757_3),
        cone(-0.105_561_345_8, -0.063_854_172_8),
        cone(-0.089_484_177_5, -1.291_485_548),
    ];
    let rows = [
        [4.076_741_662_1, -3.307_711_591_3, 0.230_969_929_2],
        [-1.268_438_004_6, 2.609_757_401_1, -0.341_319_396_5],
        [-0.004_196_086_3, -0.703_418_614_7, 1.707_614_701],
    ];
    rows.map(|row| {
        let linear: f64 = row.iter().zip(c).map(|(k, c)| k * c).sum();
        let linear = linear.clamp(0.0, 1.0);
        let gamma = if linear <= 0.003_130_8 {
            12.92 * linear
        } else {
            1.055 * linear.powf(1.0 / 2.4) - 0.055
        };
        (gamma * 255.0).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::render::pixels;
    use crate::app::theme::{DARK, LIGHT};

    /// sRGB to OKLab.
    fn seen(color: [u8; 3]) -> [f64; 3] {
        let [r, g, b] = color.map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.040_45 {
                c / 12.92
            } else {
                ((c + 0.055) / 1.055).powf(2.4)
            }
        });
        let l = (0.412_221_470_8 * r + 0.536_332_536_3 * g + 0.051_445_992_9 * b).cbrt();
        let m = (0.211_903_498_2 * r + 0.680_699_545_1 * g + 0.107_396_956_6 * b).cbrt();
        let s = (0.088_302_461_9 * r + 0.281_718_837_6 * g + 0.629_978_700_5 * b).cbrt();
        [
            0.210_454_255_3 * l + 0.793_617_785 * m - 0.004_072_046_8 * s,
            1.977_998_495_1 * l - 2.428_592_205 * m + 0.450_593_709_9 * s,
            0.025_904_037_1 * l + 0.782_771_766_2 * m - 0.808_675_766 * s,
        ]
    }

    fn apart(a: [u8; 3], b: [u8; 3]) -> f64 {
        let (a, b) = (seen(a), seen(b));
        (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
    }

    #[test]
    fn equal_steps_of_value_are_equal_steps_of_colour() {
        for map in Map::ALL {
            // Sixteen entries at a time: single steps are below the rounding to 8 bits.
            let steps: Vec<f64> = (0..ENTRIES - 16)
                .map(|i| apart(map.table()[i], map.table()[i + 16]))
                .collect();
            // Over the middle of the diverging map the line turns back.
            let turns = |i: usize| map == Map::Diverging && (112..128).contains(&i);
            let straight = || {
                steps
                    .iter()
                    .enumerate()
                    .filter(|(i, _)| !turns(*i))
                    .map(|(_, s)| *s)
            };
            let mean = straight().sum::<f64>() / straight().count() as f64;
            let bound = if map == Map::Sequential { 0.45 } else { 0.12 };
            for (i, step) in straight().enumerate() {
                let off = (step / mean - 1.0).abs();
                assert!(off < bound, "{map:?} at {i}: {step} against {mean}");
            }
        }
    }

    #[test]
    fn the_diverging_map_is_grey_in_the_middle_and_as_dark_at_both_ends() {
        let t = Map::Diverging.table();
        let [r, g, b] = Map::Diverging.at(0.5);
        assert!(r.abs_diff(g) <= 4 && g.abs_diff(b) <= 4, "{r} {g} {b}");
        assert!(t[0][2] > t[0][0] + 60, "blue below: {:?}", t[0]);
        assert!(t[255][0] > t[255][2] + 60, "red above: {:?}", t[255]);
        for i in 0..128 {
            let (below, above) = (seen(t[i])[0], seen(t[255 - i])[0]);
            assert!((below - above).abs() < 0.006, "{i}: {below} and {above}");
        }
    }

    #[test]
    fn the_cyclic_map_has_one_lightness_and_no_seam() {
        let t = Map::Cyclic.table();
        for i in 0..ENTRIES {
            assert!((seen(t[i])[0] - CIRCLE[0]).abs() < 0.004, "{:?}", t[i]);
            assert!(apart(t[i], t[(i + 1) % ENTRIES]) < 0.008);
        }
        assert_eq!(Map::Cyclic.at(0.25), Map::Cyclic.at(1.25));
        assert_eq!(Map::Cyclic.at(-0.75), Map::Cyclic.at(0.25));
    }

    #[test]
    fn no_colour_of_a_map_is_that_of_a_finger() {
        for theme in [DARK, LIGHT] {
            for finger in &theme.fingers[..2] {
                for map in Map::ALL {
                    let nearest = map
                        .table()
                        .iter()
                        .map(|&c| apart(c, pixels::rgb(*finger)))
                        .fold(f64::INFINITY, f64::min);
                    assert!(nearest > 0.07, "{map:?} and {finger:?}: {nearest}");
                }
            }
        }
    }

    #[test]
    fn outside_the_range_the_end_is_shown_and_no_number_is_the_lower_end() {
        for map in [Map::Sequential, Map::FromRest, Map::Diverging] {
            assert_eq!(map.at(-3.0), map.table()[0]);
            assert_eq!(map.at(3.0), map.table()[ENTRIES - 1]);
            assert_eq!(map.at(f64::NAN), map.table()[0]);
        }
    }
}
