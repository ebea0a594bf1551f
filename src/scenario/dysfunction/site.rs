//! Named places of the back where a dysfunction can sit, and the text that names them.

use crate::geom::Vec2;
use crate::scenario::ScenarioError;
use crate::surface::back::{self, BackOptions, LEVELS, Landmark};
use std::fmt;
use std::sync::OnceLock;

pub use crate::surface::back::Side;

/// A vertebral level from C7 to L5, in that order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VertebralLevel(u8);

impl VertebralLevel {
    /// All of them from the neck down.
    pub fn all() -> impl DoubleEndedIterator<Item = Self> + ExactSizeIterator {
        (0..LEVELS.len() as u8).map(Self)
    }

    /// Such as "T5".
    pub fn name(self) -> &'static str {
        LEVELS.get(usize::from(self.0)).copied().unwrap_or("?")
    }

    /// The level called `name`, in either case.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|level| level.name().eq_ignore_ascii_case(name))
    }

    /// How many levels `other` lies below: negative above.
    pub fn levels_down_to(self, other: Self) -> i32 {
        i32::from(other.0) - i32::from(self.0)
    }

    /// The level `n` further down; up where negative.
    pub fn down(self, n: i32) -> Option<Self> {
        let at = i32::from(self.0) + n;
        Self::all().find(|level| i32::from(level.0) == at)
    }

    /// Number of the rib that springs here, 1 … 12.
    pub fn rib(self) -> Option<u8> {
        self.name().strip_prefix('T')?.parse().ok()
    }
}

impl fmt::Display for VertebralLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What of a level is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Target {
    /// The tip of the spinous process; of a side, its slope on that side.
    Spinous,
    /// Over the transverse process.
    Transverse,
    /// The angle of the rib.
    RibAngle,
    /// The ridge of the erector spinae beside the spinous process.
    Muscle,
}

impl Target {
    /// Every target.
    pub fn all() -> &'static [Self] {
        &[
            Self::Spinous,
            Self::Transverse,
            Self::RibAngle,
            Self::Muscle,
        ]
    }

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Spinous => "spinous",
            Self::Transverse => "transverse",
            Self::RibAngle => "rib angle",
            Self::Muscle => "muscle",
        }
    }

    /// The target called `name`.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().iter().copied().find(|t| t.name() == name)
    }

    /// Such as "transverse process".
    pub fn title(self) -> &'static str {
        match self {
            Self::Spinous => "spinous process",
            Self::Transverse => "transverse process",
            Self::RibAngle => "rib angle",
            Self::Muscle => "muscle",
        }
    }
}

/// Name of a side in files.
pub fn side_name(side: Side) -> &'static str {
    match side {
        Side::Left => "left",
        Side::Middle => "middle",
        Side::Right => "right",
    }
}

/// A place on the built-in back by level, side and target. Shown as "T5 right transverse process".
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Site {
    /// Which vertebra.
    pub level: VertebralLevel,
    /// Which side of the subject; the middle is the spinous process's alone.
    pub side: Side,
    /// What of it.
    pub target: Target,
}

impl fmt::Display for Site {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (level, target) = (self.level, self.target.title());
        match self.side {
            Side::Middle => write!(f, "{level} {target}"),
            side => write!(f, "{level} {} {target}", side_name(side)),
        }
    }
}

/// A spinous process's slope lies so far beside its tip, mm: half the width of the process at half its height.
const SPINOUS_SLOPE_MM: f64 = 5.0;
/// C7 has no landmark over its transverse process: it is taken to lie as far out as that of T1, at the height of its own
/// spinous process, mm. Assumed.
const C7_TRANSVERSE_MM: f64 = 27.0;
/// The ridge of the erector spinae beside thoracic and lumbar spinous processes, mm from the midline. Assumed, from the
/// places of the muscle keys of the built-in stiffness map and the wider muscle of the loins.
const MUSCLE_MM: [f64; 2] = [28.0, 34.0];
/// The angle of the first rib lies so far from the midline, and that of each further one so much more, mm: they diverge
/// downward. Assumed.
const RIB_ANGLE_MM: [f64; 2] = [40.0, 3.2];
/// A rib slopes down from the transverse process to its angle by so much, mm. Assumed.
const RIB_DROP_MM: f64 = 8.0;

impl Site {
    /// Where it is on the map plane, mm.
    ///
    /// Spinous and transverse processes are the landmarks of the built-in back. Muscle and rib angle are taken from them by
    /// assumed offsets: muscle 28 mm (loins 34 mm) beside the spinous process at its height, rib angles from 40 mm (first
    /// rib) to 75 mm (twelfth) beside the midline, 8 mm below the transverse process. A side of a spinous process is 5 mm
    /// beside its tip. What [`sites`] refuses lies as far out as a right one would, or in the middle.
    pub fn at_mm(&self) -> Vec2 {
        let [spinous, transverse] = processes(self.level);
        let out = match self.target {
            Target::Spinous => Vec2::new(SPINOUS_SLOPE_MM, spinous.y),
            Target::Transverse => transverse,
            Target::Muscle => {
                let lumbar = self.level.name().starts_with('L');
                Vec2::new(MUSCLE_MM[usize::from(lumbar)], spinous.y)
            }
            Target::RibAngle => {
                let [first, more] = RIB_ANGLE_MM;
                let rib = f64::from(self.level.rib().unwrap_or(1));
                Vec2::new(first + more * (rib - 1.0), transverse.y - RIB_DROP_MM)
            }
        };
        Vec2::new(out.x * self.lateral(), out.y)
    }

    /// The sign of x away from the midline: −1 left, 0 in the middle, 1 right.
    pub fn lateral(&self) -> f64 {
        lateral(self.side)
    }

    /// The same place on the other side.
    #[must_use]
    pub fn mirrored(self) -> Self {
        let side = match self.side {
            Side::Left => Side::Right,
            Side::Middle => Side::Middle,
            Side::Right => Side::Left,
        };
        Self { side, ..self }
    }

    /// Why there is no such place, if so.
    pub(super) fn fault(&self) -> Option<String> {
        if self.target == Target::RibAngle && self.level.rib().is_none() {
            return Some(format!(
                "{} has no rib; rib angles are at T1 to T12",
                self.level
            ));
        }
        if self.side == Side::Middle && self.target != Target::Spinous {
            let target = self.target.title();
            return Some(format!(
                "a {target} is left or right; in the middle is the spinous process"
            ));
        }
        None
    }
}

pub(super) fn lateral(side: Side) -> f64 {
    match side {
        Side::Left => -1.0,
        Side::Middle => 0.0,
        Side::Right => 1.0,
    }
}

/// Spinous and right transverse process of a level on the map plane, mm.
fn processes(level: VertebralLevel) -> [Vec2; 2] {
    static PLACES: OnceLock<Vec<[Vec2; 2]>> = OnceLock::new();
    let places = PLACES.get_or_init(|| {
        let all = back::landmarks(&BackOptions::default());
        let find = |level: &str, kind, side| {
            let is = |l: &&Landmark| l.level == level && l.kind == kind && l.side == side;
            all.iter().find(is).map(|l| l.position_mm.truncate())
        };
        let of = |level: &&str| {
            let spinous = find(level, back::Kind::Spinous, Side::Middle).unwrap_or_default();
            let transverse = find(level, back::Kind::Transverse, Side::Right);
            let beside = Vec2::new(C7_TRANSVERSE_MM, spinous.y);
            [spinous, transverse.unwrap_or(beside)]
        };
        LEVELS.iter().map(of).collect()
    });
    places
        .get(usize::from(level.0))
        .copied()
        .unwrap_or_default()
}

/// The sites that a text names, in its order, each once: levels, then sides, then targets.
///
/// - Levels: "T5", "T1-T12", "C7,T4-L5".
/// - Side: `left`, `right`, `both` (`both sides`), `middle`. Left out: both, and for spinous processes the middle.
/// - Target: `spinous`, `transverse`, `rib angle`, `muscle`, with or without "process". Left out: transverse; in the middle
///   spinous.
/// - Several such groups are set apart by ";": "T3 left muscle; L1-L3 right". A site's own name is such a text.
///
/// # Errors
/// What is no level, side or target; a rib angle where there is no rib; a transverse process in the middle; no site at all.
pub fn sites(text: &str) -> Result<Vec<Site>, ScenarioError> {
    sites_in(text).map_err(|what| ScenarioError(format!("{text:?}: {what}")))
}

pub(super) fn sites_in(text: &str) -> Result<Vec<Site>, String> {
    let mut out: Vec<Site> = Vec::new();
    for group in text.split(';') {
        for site in group_of(group)? {
            if !out.contains(&site) {
                out.push(site);
            }
        }
    }
    Ok(out)
}

fn group_of(group: &str) -> Result<Vec<Site>, String> {
    let words: Vec<String> = group.split_whitespace().map(str::to_lowercase).collect();
    let is_word = |w: &&String| SIDES.iter().any(|(n, _)| n == w) || target_word(w).is_some();
    let n_levels = words.iter().take_while(|w| !is_word(w)).count();
    let levels = levels(&words[..n_levels].concat())?;
    let mut sides: Option<&[Side]> = None;
    let mut target = None;
    for word in &words[n_levels..] {
        if let Some((_, of)) = SIDES.iter().find(|(n, _)| n == word) {
            if sides.replace(*of).is_some() {
                return Err(format!(
                    "{word:?} is a second side; set groups apart by \";\""
                ));
            }
        } else if let Some(of) = target_word(word) {
            if target.replace(of).is_some_and(|before| before != of) {
                return Err(format!(
                    "{word:?} is a second target; set groups apart by \";\""
                ));
            }
        } else if !FILLING.contains(&word.as_str()) {
            return Err(format!(
                "{word:?}; after the levels a side (left, right, both, middle) and a target (spinous, transverse, rib \
                 angle, muscle) are allowed"
            ));
        }
    }
    let middle: &[Side] = &[Side::Middle];
    let target = target.unwrap_or(match sides {
        Some([Side::Middle]) => Target::Spinous,
        _ => Target::Transverse,
    });
    let sides = sides.unwrap_or(match target {
        Target::Spinous => middle,
        _ => &[Side::Left, Side::Right],
    });
    let mut out = Vec::new();
    for level in levels {
        for &side in sides {
            let site = Site {
                level,
                side,
                target,
            };
            if let Some(fault) = site.fault() {
                return Err(fault);
            }
            out.push(site);
        }
    }
    Ok(out)
}

pub(super) const SIDES: [(&str, &[Side]); 4] = [
    ("left", &[Side::Left]),
    ("right", &[Side::Right]),
    ("both", &[Side::Left, Side::Right]),
    ("middle", &[Side::Middle]),
];

/// Words that may stand for better reading.
const FILLING: [&str; 7] = [
    "side",
    "sides",
    "process",
    "processes",
    "angle",
    "angles",
    "and",
];

fn target_word(word: &str) -> Option<Target> {
    match word {
        "spinous" => Some(Target::Spinous),
        "transverse" => Some(Target::Transverse),
        "rib" | "ribs" => Some(Target::RibAngle),
        "muscle" | "muscles" => Some(Target::Muscle),
        _ => None,
    }
}

/// Levels and ranges of them, set apart by commas, in the order of the text.
pub(super) fn levels(text: &str) -> Result<Vec<VertebralLevel>, String> {
    let level = |name: &str| {
        let name = name.trim();
        VertebralLevel::named(name)
            .ok_or_else(|| format!("{name:?} is no level; C7, T1 to T12 and L1 to L5 are"))
    };
    let mut out = Vec::new();
    for part in text.split(',') {
        match part.split_once(['-', '–']) {
            None => out.push(level(part)?),
            Some((from, to)) => {
                let (from, to) = (level(from)?, level(to)?);
                if from > to {
                    return Err(format!("{from}-{to} runs upward; write {to}-{from}"));
                }
                out.extend(VertebralLevel::all().filter(|l| (from..=to).contains(l)));
            }
        }
    }
    Ok(out)
}

/// Levels as a text that [`levels`] reads the same: runs of three and more as ranges.
pub(super) fn levels_text(levels: &[VertebralLevel]) -> String {
    let mut parts: Vec<String> = Vec::new();
    let mut i = 0;
    while i < levels.len() {
        let mut end = i;
        while end + 1 < levels.len() && levels[end].levels_down_to(levels[end + 1]) == 1 {
            end += 1;
        }
        if end - i >= 1 {
            parts.push(format!("{}-{}", levels[i], levels[end]));
        } else {
            parts.push(levels[i].to_string());
        }
        i = end + 1;
    }
    parts.join(",")
}
