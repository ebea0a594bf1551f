//! Vertebrae that are rotated and bent to a side, by Fryette's convention.

use super::by_severity;
use crate::geom::Vec2;
use crate::scenario::dysfunction::patch::{amid, share_of};
use crate::scenario::dysfunction::place::{Placed, places};
use crate::scenario::dysfunction::{
    Change, Dysfunction, Extent, Fault, Kind, Patch, Place, Preset, Side, Site, Strength,
};

pub(super) struct Rotation;

/// Several levels in neutral position: bent to the side opposite to the rotation.
const TYPE_ONE: &str = "fryette_one";
/// One level, flexed or extended: bent to the side of the rotation.
const TYPE_TWO: &str = "fryette_two";

const PRESETS: [Preset; 2] = [
    Preset {
        key: TYPE_ONE,
        title: "Fryette I",
        about: "Several levels: rotated to one side and bent to the other; most in the middle of the group.",
    },
    Preset {
        key: TYPE_TWO,
        title: "Fryette II",
        about: "One level: rotated and bent to the same side.",
    },
];

/// How far the transverse process stands out on the side of the rotation by severity, mm, as far as it lies in on the other;
/// assumed.
const BUMP_MM: [f64; 4] = [0.0, 0.8, 1.5, 2.5];
/// Change of stiffness over the process that stands out by severity, percent; assumed.
const STIFFNESS_PERCENT: [f64; 4] = [0.0, 15.0, 30.0, 50.0];
/// What the shortened muscle on the side of the bend has of it; assumed.
const BEND_SHARE: f64 = 0.5;
/// What the first and last levels of a group have of the rotation of its middle; assumed.
const END_SHARE: f64 = 0.5;

impl Kind for Rotation {
    fn key(&self) -> &'static str {
        "rotation"
    }

    fn title(&self) -> &'static str {
        "Vertebral rotation and side-bending"
    }

    fn about(&self) -> &'static str {
        "The transverse process on the side of the rotation stands out and is stiffer, the other lies in; the muscle on the \
         side of the bend is shortened and stiffer. The side is that of the rotation."
    }

    fn presets(&self) -> &'static [Preset] {
        &PRESETS
    }

    fn needs_preset(&self) -> bool {
        false
    }

    fn extent(&self) -> Extent {
        Extent {
            radius_mm: [14.0, 11.0],
            angle_deg: 0.0,
            profile: "cosine",
        }
    }

    fn strength(&self, _: Option<&str>, severity: u8) -> Strength {
        if severity == 0 {
            return Strength::default();
        }
        let percent = by_severity(STIFFNESS_PERCENT, severity);
        Strength {
            change: Some(Change::StiffnessPercent(percent)),
            bump_mm: Some(by_severity(BUMP_MM, severity)),
            ..Strength::default()
        }
    }

    fn patches(&self, d: &Dysfunction) -> Result<Vec<Patch>, Fault> {
        let opposite = match &d.place {
            Place::At(at) if at.x == 0.0 => {
                let what = "rotation is to a side; at_mm must lie beside the midline";
                return Err(Fault::new("at_mm", what));
            }
            Place::At(_) if d.preset == Some(TYPE_ONE) => {
                let what = "fryette_one takes several levels; at_mm is one place";
                return Err(Fault::new("preset", what));
            }
            Place::At(_) => false,
            Place::Sites(sites) => bends_opposite(sites, d.preset)?,
        };
        let places = places(d);
        let bend = bend(d, &places, opposite);
        let n = places.len();
        let mut out = Vec::new();
        for (i, place) in places.iter().enumerate() {
            let share = rotated_share(i, n);
            let whole = place.patch(d);
            let rotated = Patch {
                stiffness_factor: share_of(whole.stiffness_factor, share),
                bump_mm: whole.bump_mm * share,
                ..whole.clone()
            };
            out.push(amid(rotated, &bend));
            let across = Vec2::new(-place.at_mm.x, place.at_mm.y);
            let angle = std::f64::consts::PI - place.angle_rad;
            out.push(Patch {
                bump_mm: -whole.bump_mm * share,
                ..Patch::plain(place.spot_of(d, across, place.half_axes_mm, angle))
            });
        }
        out.extend(bend);
        Ok(out)
    }
}

/// From [`END_SHARE`] at the first and last level to 1 in the middle.
fn rotated_share(i: usize, n: usize) -> f64 {
    if n < 3 {
        return 1.0;
    }
    let half = (n - 1) as f64 / 2.0;
    1.0 - (1.0 - END_SHARE) * (i as f64 - half).abs() / half
}

/// The shortened muscle: one ellipse along the spine past all levels.
fn bend(d: &Dysfunction, places: &[Placed], opposite: bool) -> Option<Patch> {
    let first = places.first()?;
    let sum: Vec2 = places.iter().map(|p| p.at_mm).sum();
    let middle = sum / places.len() as f64;
    let low = places
        .iter()
        .map(|p| p.at_mm.y)
        .fold(f64::INFINITY, f64::min);
    let high = places
        .iter()
        .map(|p| p.at_mm.y)
        .fold(f64::NEG_INFINITY, f64::max);
    let [a, b] = first.half_axes_mm;
    let at = Vec2::new(
        if opposite { -middle.x } else { middle.x },
        0.5 * (low + high),
    );
    let axes = [0.5 * (high - low) + 1.5 * a.max(b), a.min(b)];
    let along = std::f64::consts::FRAC_PI_2;
    Some(Patch {
        stiffness_factor: share_of(d.strength().stiffness_factor(), BEND_SHARE),
        ..Patch::plain(first.spot_of(d, at, axes, along))
    })
}

/// Whether the bend is opposite to the rotation, by preset or, without one, by the number of levels.
fn bends_opposite(sites: &[Site], preset: Option<&str>) -> Result<bool, Fault> {
    let one_side = sites.windows(2).all(|w| w[0].side == w[1].side);
    if !one_side || sites.iter().any(|s| s.side == Side::Middle) {
        let what = "rotation is to one side; left or right is allowed";
        return Err(Fault::new("side", what));
    }
    let joined = |w: &[Site]| w[0].level.levels_down_to(w[1].level) == 1;
    match (sites.len(), preset) {
        (1, None | Some(TYPE_TWO)) => Ok(false),
        (1, _) => {
            let what = "fryette_one takes several levels, such as levels = \"T3-T6\"; one is given";
            Err(Fault::new("preset", what))
        }
        (n, Some(TYPE_TWO)) => {
            let what = format!("fryette_two takes one level; {n} are given");
            Err(Fault::new("preset", what))
        }
        _ if !sites.windows(2).all(joined) => {
            let what = "a group of rotated vertebrae has no gaps, such as \"T3-T6\"";
            Err(Fault::new("levels", what))
        }
        _ => Ok(true),
    }
}
