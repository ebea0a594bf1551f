//! Named places on the built-in back.

use super::{BackOptions, Heights};
use crate::geom::Vec3;
use std::sync::OnceLock;

/// Vertebral levels from the neck down.
pub const LEVELS: [&str; 18] = [
    "C7", "T1", "T2", "T3", "T4", "T5", "T6", "T7", "T8", "T9", "T10", "T11", "T12", "L1", "L2",
    "L3", "L4", "L5",
];

const LANDMARKS_CSV: &str = include_str!("../../../assets/back/landmarks.csv");

/// What a landmark marks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Tip of a spinous process.
    Spinous,
    /// Over a transverse process.
    Transverse,
    /// Inferior angle of a scapula.
    ScapulaInferiorAngle,
    /// Medial end of the spine of a scapula.
    ScapulaSpine,
    /// Posterior superior iliac spine.
    Psis,
    /// Top of the iliac crest.
    IliacCrest,
}

/// Which side of the subject.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Side {
    /// x < 0.
    Left,
    /// On the midline.
    Middle,
    /// x > 0.
    Right,
}

/// A named place on the skin.
#[derive(Clone, Debug, PartialEq)]
pub struct Landmark {
    /// Name with its side, such as "T5 transverse right".
    pub name: String,
    /// Vertebral level, such as "T5"; empty for the others.
    pub level: &'static str,
    /// What it marks.
    pub kind: Kind,
    /// Which side of the subject.
    pub side: Side,
    /// Where, mm; on the height function of the back.
    pub position_mm: Vec3,
}

/// Heights of the spinous processes on the map plane.
pub(super) struct Levels {
    pub(super) spinous_y_mm: [f64; LEVELS.len()],
}

impl Levels {
    pub(super) fn get() -> &'static Self {
        static LEVELS_READ: OnceLock<Levels> = OnceLock::new();
        LEVELS_READ.get_or_init(|| {
            let mut spinous_y_mm = [0.0; LEVELS.len()];
            for (name, _, y_mm) in stored() {
                let level = name
                    .strip_suffix(" spinous")
                    .and_then(|l| LEVELS.iter().position(|&n| n == l));
                if let Some(i) = level {
                    spinous_y_mm[i] = y_mm;
                }
            }
            Self { spinous_y_mm }
        })
    }
}

/// Name, x and y of every stored landmark, mm.
pub(super) fn stored() -> impl Iterator<Item = (&'static str, f64, f64)> {
    LANDMARKS_CSV
        .lines()
        .filter(|l| !l.starts_with('#'))
        .skip(1)
        .filter_map(|line| {
            let mut cells = line.split(',');
            let name = cells.next()?;
            Some((
                name,
                cells.next()?.parse().ok()?,
                cells.next()?.parse().ok()?,
            ))
        })
}

/// All landmarks of the back made with `options`, from the neck down, left before right.
pub fn landmarks(options: &BackOptions) -> Vec<Landmark> {
    let heights = Heights::new(options);
    let mut out = Vec::new();
    for (name, x_mm, y_mm) in stored() {
        let Some((level, kind)) = meaning(name) else {
            continue;
        };
        let sides: &[(Side, f64)] = if x_mm == 0.0 {
            &[(Side::Middle, 0.0)]
        } else {
            &[(Side::Left, -1.0), (Side::Right, 1.0)]
        };
        for &(side, sign) in sides {
            let x = heights.carried_x_mm(sign * x_mm, y_mm);
            let suffix = match side {
                Side::Left => " left",
                Side::Middle => "",
                Side::Right => " right",
            };
            let position_mm = options.scaled(Vec3::new(x, y_mm, heights.at(x, y_mm)));
            out.push(Landmark {
                name: format!("{name}{suffix}"),
                level,
                kind,
                side,
                position_mm,
            });
        }
    }
    out
}

/// The landmark of a level (such as "T5"), kind and side, if there is one.
pub fn landmark(options: &BackOptions, level: &str, kind: Kind, side: Side) -> Option<Landmark> {
    landmarks(options)
        .into_iter()
        .find(|l| l.level == level && l.kind == kind && l.side == side)
}

fn meaning(name: &str) -> Option<(&'static str, Kind)> {
    let level_of = |suffix: &str| {
        let level = name.strip_suffix(suffix)?;
        LEVELS.iter().find(|&&l| l == level).copied()
    };
    if let Some(level) = level_of(" spinous") {
        return Some((level, Kind::Spinous));
    }
    if let Some(level) = level_of(" transverse") {
        return Some((level, Kind::Transverse));
    }
    match name {
        "scapula inferior angle" => Some(("", Kind::ScapulaInferiorAngle)),
        "scapula spine medial end" => Some(("", Kind::ScapulaSpine)),
        "PSIS" => Some(("", Kind::Psis)),
        "iliac crest" => Some(("", Kind::IliacCrest)),
        _ => None,
    }
}
