//! The measured ellipses of appendix C (Ji 2008), their means, and the seven keys made of them.
//!
//! Five subjects were pressed at five points of the left half and the middle of the back, with the force up (to the
//! shoulders) and, three of them, down (to the waist). The table gives *full* axes. Up and down differ by up to 10 cm on the
//! same subject: they are two sets of data, not one. The contour measured is that of 2 mm displacement.
//!
//! In four rows the axis called major is the shorter one. The printed means take them as they stand, and directions as plain
//! numbers; [`Means::Axial`] exchanges the axes, turns such a row by 90°, and takes directions as axes.

use super::ellipse::{EllipseKey, axial};
use crate::geom::Vec2;
use crate::surface::back::{self, BackOptions, Kind, Side};
use serde::Deserialize;
use std::f64::consts::FRAC_PI_2;
use std::sync::LazyLock;

const CSV: &str = include_str!("../../assets/appendix_c.csv");

/// How far the keys beside the spine lie from it, mm (Ji 2008, 5.1).
pub const ASIDE_MM: f64 = 100.0;

/// Which way the skin was pressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Force {
    /// To the shoulders; all five subjects.
    #[default]
    Up,
    /// To the waist; subjects 3 to 5.
    Down,
}

impl Force {
    /// Both.
    pub fn all() -> &'static [Self] {
        &[Self::Up, Self::Down]
    }

    /// Name in files, tables and the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Up => "up",
            Self::Down => "down",
        }
    }
}

/// How rows become a mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Means {
    /// As printed: axes as they stand, directions as numbers.
    #[default]
    Printed,
    /// The longer axis is the major one; directions as axes, so that 10° and 170° meet at 0°.
    Axial,
}

impl Means {
    /// Both; the default first.
    pub fn all() -> &'static [Self] {
        &[Self::Printed, Self::Axial]
    }

    /// Name in files, tables and the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Printed => "printed",
            Self::Axial => "axial",
        }
    }
}

/// One measurement, as printed: full axes.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct Row {
    /// Which way the skin was pressed.
    pub force: Force,
    /// Key point, 1 … 5.
    pub point: u32,
    /// Subject, 1 … 5.
    pub subject: u32,
    /// Full axis called major, cm.
    pub major_cm: f64,
    /// Full axis called minor, cm.
    pub minor_cm: f64,
    /// Direction of the axis called major from x, degrees.
    pub direction_deg: f64,
}

impl Row {
    /// Whether the axis called major is the shorter one.
    pub fn is_exchanged(&self) -> bool {
        self.minor_cm > self.major_cm
    }

    /// The same ellipse with the longer axis as the major one.
    #[must_use]
    pub fn ordered(self) -> Self {
        if !self.is_exchanged() {
            return self;
        }
        Self {
            major_cm: self.minor_cm,
            minor_cm: self.major_cm,
            direction_deg: (self.direction_deg + 90.0).rem_euclid(180.0),
            ..self
        }
    }
}

/// The mean over the rows of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean {
    /// Key point, 1 … 5.
    pub point: u32,
    /// Number of rows.
    pub rows: usize,
    /// Mean of the full major axes, mm.
    pub major_mm: f64,
    /// Mean of the ratios major over minor.
    pub major_over_minor: f64,
    /// Mean direction from x, rad.
    pub angle_rad: f64,
}

/// Every row, in the order of the table.
pub fn rows() -> &'static [Row] {
    static ROWS: LazyLock<Vec<Row>> = LazyLock::new(|| {
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .from_reader(CSV.as_bytes());
        // The table is part of the program; a test counts its rows.
        reader.deserialize().filter_map(Result::ok).collect()
    });
    &ROWS
}

/// Means per point over all subjects, or of one; a point without rows is left out.
pub fn means(means: Means, force: Force, subject: Option<u32>) -> Vec<Mean> {
    (1..=5)
        .filter_map(|point| {
            let rows: Vec<Row> = rows()
                .iter()
                .filter(|r| r.force == force && r.point == point)
                .filter(|r| subject.is_none_or(|s| s == r.subject))
                .map(|r| match means {
                    Means::Printed => *r,
                    Means::Axial => r.ordered(),
                })
                .collect();
            let n = rows.len();
            if n == 0 {
                return None;
            }
            let mean = |of: fn(&Row) -> f64| rows.iter().map(of).sum::<f64>() / n as f64;
            Some(Mean {
                point,
                rows: n,
                major_mm: 10.0 * mean(|r| r.major_cm),
                major_over_minor: mean(|r| r.major_cm / r.minor_cm),
                angle_rad: match means {
                    Means::Printed => mean(|r| r.direction_deg).to_radians(),
                    Means::Axial => axial_mean(&rows),
                },
            })
        })
        .collect()
}

/// Half the direction of the sum of the doubled ones; upright where they cancel.
fn axial_mean(rows: &[Row]) -> f64 {
    let sum = rows.iter().fold(Vec2::ZERO, |sum, row| {
        let (sin, cos) = libm::sincos(2.0 * row.direction_deg.to_radians());
        sum + Vec2::new(cos, sin)
    });
    // What is left of directions that cancel is rounding.
    if sum.length() < 1.0e-9 {
        return FRAC_PI_2;
    }
    axial(0.5 * libm::atan2(sum.y, sum.x))
}

/// The seven keys of the back (Ji 2008, fig. 5.1) from the printed means of all subjects, or of one: see
/// [`seven_keys_by`].
pub fn seven_keys(force: Force, subject: Option<u32>) -> Vec<EllipseKey> {
    seven_keys_by(Means::Printed, force, subject)
}

/// The seven keys of the back on the landmarks of the built-in one, half axes, mm.
///
/// P1, P2 and P3 over the spinous processes of T5, T10 and L2; P4 on the left, where a direction beyond 90° follows the
/// fibres, 100 mm from the spine half way between P1 and P2; P5 likewise between P2 and P3; P6 and P7 mirror P4 and P5. A
/// point without rows (subjects 1 and 2 have none with the force down) is left out.
pub fn seven_keys_by(by: Means, force: Force, subject: Option<u32>) -> Vec<EllipseKey> {
    let options = BackOptions::default();
    let on_spine = |level: &str| {
        back::landmark(&options, level, Kind::Spinous, Side::Middle).map(|l| l.position_mm.y)
    };
    let (Some(t5), Some(t10), Some(l2)) = (on_spine("T5"), on_spine("T10"), on_spine("L2")) else {
        return Vec::new();
    };
    let place = |point: u32| match point {
        1 => Vec2::new(0.0, t5),
        2 => Vec2::new(0.0, t10),
        3 => Vec2::new(0.0, l2),
        4 => Vec2::new(-ASIDE_MM, 0.5 * (t5 + t10)),
        _ => Vec2::new(-ASIDE_MM, 0.5 * (t10 + l2)),
    };
    let means = means(by, force, subject);
    let key = |mean: &Mean, name: String| {
        let half_major_mm = 0.5 * mean.major_mm;
        EllipseKey::new(
            name,
            place(mean.point),
            half_major_mm,
            half_major_mm / mean.major_over_minor,
            mean.angle_rad,
        )
    };
    let measured = means.iter().map(|m| key(m, format!("P{}", m.point)));
    let mirrored = means
        .iter()
        .filter(|m| m.point > 3)
        .map(|m| key(m, format!("P{}", m.point + 2)).mirrored());
    measured.chain(mirrored).collect()
}
