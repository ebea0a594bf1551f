//! Functional shape matched deformation (Ji 2008, chapter 4): what its curves and footprints do, printed and ours.

mod curve_arrays;
mod curves;
mod location_ratio;
mod yardsticks;

use crate::figure::{Mark, Series};

pub use curve_arrays::CurveArrays;
pub use curves::Curves;
pub use location_ratio::{Excess, LocationRatio, boundary_excess, excess_at};
pub use yardsticks::Yardsticks;

/// sRGB colours of plots; none is a finger's.
const INK: [u8; 3] = [24, 26, 30];
const AMBER: [u8; 3] = [214, 122, 0];
const GREEN: [u8; 3] = [0, 140, 104];
const VIOLET: [u8; 3] = [136, 72, 168];
const BROWN: [u8; 3] = [124, 84, 28];
const GREY: [u8; 3] = [120, 124, 130];

fn series(
    name: impl Into<String>,
    colour: [u8; 3],
    mark: Mark,
    points: impl IntoIterator<Item = [f64; 2]>,
) -> Series {
    Series {
        name: name.into(),
        colour,
        mark,
        points: points.into_iter().collect(),
    }
}
