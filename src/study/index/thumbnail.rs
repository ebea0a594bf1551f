//! A small picture of where fingers dwelt.

use crate::study::Dwell;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Most cells along x.
pub const MOST_COLUMNS: usize = 48;
/// Most cells along y.
pub const MOST_ROWS: usize = 64;

/// Time on the skin over the map plane in few cells.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Thumbnail {
    /// Corner of the first cell, mm.
    pub origin_mm: [f64; 2],
    /// Edge of a cell, mm.
    pub cell_mm: f64,
    /// Cells along x, at most `MOST_COLUMNS`.
    pub columns: usize,
    /// Cells along y, at most `MOST_ROWS`.
    pub rows: usize,
    /// Longest time in a cell, s.
    pub most_s: f64,
    /// Root of the share of that time, 0 to 255, row by row from the lower left; 0 only where nothing was touched.
    #[serde(serialize_with = "write_hex", deserialize_with = "read_hex")]
    pub shade: Vec<u8>,
}

impl Thumbnail {
    /// A dwell map with as many of its cells taken together as make it small enough.
    pub fn of(dwell: &Dwell) -> Self {
        let (width, height) = (dwell.columns, dwell.rows);
        if width * height == 0 || dwell.seconds.len() != width * height {
            return Self::default();
        }
        let by = width.div_ceil(MOST_COLUMNS).max(height.div_ceil(MOST_ROWS));
        let (columns, rows) = (width.div_ceil(by), height.div_ceil(by));
        let mut seconds = vec![0.0_f64; columns * rows];
        for (i, s) in dwell.seconds.iter().enumerate() {
            let (x, y) = (i % width / by, i / width / by);
            seconds[y * columns + x] += f64::from(*s);
        }
        let most_s = seconds.iter().copied().fold(0.0, f64::max);
        let shade = |s: f64| match s > 0.0 {
            true => (255.0 * (s / most_s).sqrt()).round().clamp(1.0, 255.0) as u8,
            false => 0,
        };
        Self {
            origin_mm: dwell.origin_mm,
            cell_mm: dwell.cell_mm * by as f64,
            columns,
            rows,
            most_s,
            shade: seconds.into_iter().map(shade).collect(),
        }
    }
}

fn write_hex<S: Serializer>(shade: &[u8], to: S) -> Result<S::Ok, S::Error> {
    use std::fmt::Write;
    let mut text = String::with_capacity(2 * shade.len());
    for byte in shade {
        let _ = write!(text, "{byte:02x}");
    }
    to.serialize_str(&text)
}

fn read_hex<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<u8>, D::Error> {
    let text = String::deserialize(from)?;
    let pair = |i: usize| {
        let digits = text.get(i..i + 2)?;
        u8::from_str_radix(digits, 16).ok()
    };
    let bytes: Option<Vec<u8>> = (0..text.len()).step_by(2).map(pair).collect();
    bytes.ok_or_else(|| serde::de::Error::custom("not hexadecimal"))
}
