//! Dysfunctions: what is wrong with the back, laid over the scenario's maps in order.
//!
//! A [`Dysfunction`] is what `[[dysfunction]]` says. Its [`Kind`], one file each behind [`all`], turns it into [`Patch`]es:
//! ellipses on the map plane that change stiffness, skin drag and the surface's height, or are tender. What is felt of them
//! is told in the scenario's ledger.
//!
//! | file | holds |
//! |---|---|
//! | `site` | levels, sides, targets and the text that names them |
//! | `kinds/` | one kind each: its defaults by severity and its patches |
//! | `patch` | what a dysfunction does to the map plane |
//! | `place` | where and how large, with the variation that `seed` makes |
//! | `conflict` | what cannot be, before a finger feels it |
//! | `table` | `[[dysfunction]]` read |
//! | `random` | dysfunctions drawn at random |
//!
//! Severities are those of osteopathic findings: 0 none or background, 1 minor, 2 obvious, 3 the key lesion. Which numbers
//! belong to them is assumed; each kind says so beside its table.

mod conflict;
mod kinds;
mod patch;
mod place;
mod random;
mod site;
pub(super) mod table;
#[cfg(test)]
mod tests;

use crate::geom::Vec2;
use std::fmt;

pub use kinds::{all, named};
pub use patch::{Patch, Tender, Tenderness};
pub use random::{RandomSpec, random};
pub use site::{Side, Site, Target, VertebralLevel, side_name, sites};

pub(super) use conflict::{STIFFNESS_N_PER_MM, check};
pub(super) use patch::{Bumps, Drag};
use site::{levels_text, sites_in};

/// Severity of a dysfunction that names none.
pub const DEFAULT_SEVERITY: u8 = 2;
/// The highest severity.
pub const MOST_SEVERE: u8 = 3;

/// One `[[dysfunction]]` of a scenario. What is left out (`None`) has the default of its kind at its severity.
#[derive(Clone, Debug, PartialEq)]
pub struct Dysfunction {
    /// Key of its [`Kind`].
    pub kind: &'static str,
    /// Which of the kind's [`Preset`]s; `None` where the kind has none, or chooses by the place.
    pub preset: Option<&'static str>,
    /// Where.
    pub place: Place,
    /// Beside the place: x away from the midline (in the middle to the subject's right), y to the head, mm.
    pub offset_mm: Vec2,
    /// Half axes of the ellipse, mm.
    pub radius_mm: [f64; 2],
    /// Direction of the first half axis, from pointing away from the midline towards the head, degrees. So the same number
    /// on both sides is a mirror image.
    pub angle_deg: f64,
    /// Falloff from the centre to the rim, one of [`crate::geom::curve::all`].
    pub profile: String,
    /// 0 … [`MOST_SEVERE`].
    pub severity: u8,
    /// Change of stiffness at the centre.
    pub change: Option<Change>,
    /// Factor on both friction coefficients at the centre.
    pub skin_drag: Option<f64>,
    /// Height of the bump at the centre, mm; negative for a hollow.
    pub bump_mm: Option<f64>,
    /// Force from which on it hurts, N.
    pub tender_above_n: Option<f64>,
    /// Whether the patient shows it; else it is only counted.
    pub tender_shown: bool,
    /// Makes place, extent and angle vary a little, as patients differ; `None`: exactly as stated.
    pub seed: Option<u64>,
}

/// A change of stiffness, as stated. A compliance 14 % lower is a stiffness 16.3 % higher.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// Change of the compliance (mm/N), percent; above −100.
    CompliancePercent(f64),
    /// Change of the stiffness (N/mm), percent; above −100.
    StiffnessPercent(f64),
}

impl Change {
    /// What the stiffness is multiplied by. Infinite or negative for what is not allowed.
    pub fn factor(self) -> f64 {
        match self {
            Self::CompliancePercent(c) => 1.0 / (1.0 + c / 100.0),
            Self::StiffnessPercent(s) => 1.0 + s / 100.0,
        }
    }

    /// The same change of the stiffness, percent.
    pub fn stiffness_percent(self) -> f64 {
        match self {
            Self::CompliancePercent(_) => 100.0 * (self.factor() - 1.0),
            Self::StiffnessPercent(s) => s,
        }
    }

    /// The same change of the compliance, percent.
    pub fn compliance_percent(self) -> f64 {
        match self {
            Self::CompliancePercent(c) => c,
            Self::StiffnessPercent(_) => 100.0 * (1.0 / self.factor() - 1.0),
        }
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CompliancePercent(c) => write!(f, "compliance {c:+} %"),
            Self::StiffnessPercent(s) => write!(f, "stiffness {s:+} %"),
        }
    }
}

/// Where a dysfunction is.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// At sites of the built-in back, one or more.
    Sites(Vec<Site>),
    /// At a point of the map plane, mm: for any mesh.
    At(Vec2),
}

impl From<Site> for Place {
    fn from(site: Site) -> Self {
        Self::Sites(vec![site])
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::At(at) => write!(f, "({}, {}) mm", at.x, at.y),
            Self::Sites(sites) => match sites_words(sites) {
                Some((levels, side, target)) => {
                    let title = match (sites.len(), target) {
                        (1, _) => target.title(),
                        (_, Target::Spinous) => "spinous processes",
                        (_, Target::Transverse) => "transverse processes",
                        (_, Target::RibAngle) => "rib angles",
                        (_, Target::Muscle) => "muscles",
                    };
                    match side {
                        "middle" => write!(f, "{levels} {title}"),
                        side => write!(f, "{levels} {side} {title}"),
                    }
                }
                None => {
                    let names: Vec<String> = sites.iter().map(Site::to_string).collect();
                    f.write_str(&names.join("; "))
                }
            },
        }
    }
}

/// Levels, side and target that name exactly these sites in this order; `None` where no such words do.
pub(super) fn sites_words(sites: &[Site]) -> Option<(String, &'static str, Target)> {
    let target = sites.first()?.target;
    let mut levels: Vec<VertebralLevel> = sites.iter().map(|s| s.level).collect();
    levels.dedup();
    let text = levels_text(&levels);
    let (side, _) = site::SIDES.iter().find(|(side, _)| {
        sites_in(&format!("{text} {side} {}", target.name())).is_ok_and(|read| read == sites)
    })?;
    Some((text, side, target))
}

/// A kind of dysfunction: defaults and what it does.
pub trait Kind: Sync {
    /// Name in files.
    fn key(&self) -> &'static str;

    /// Name for people.
    fn title(&self) -> &'static str;

    /// What it is and what of it is felt, in one or two sentences.
    fn about(&self) -> &'static str;

    /// Its named forms; none for most.
    fn presets(&self) -> &'static [Preset] {
        &[]
    }

    /// Whether a form must be named; else the kind chooses one by the place.
    fn needs_preset(&self) -> bool {
        !self.presets().is_empty()
    }

    /// How large it is unless stated.
    fn extent(&self) -> Extent;

    /// How strong it is at a severity unless stated. Assumed values.
    fn strength(&self, preset: Option<&str>, severity: u8) -> Strength;

    /// Whether it is nothing without friction, so that a scenario without `[friction]` cannot have it.
    fn is_felt_by_friction_alone(&self) -> bool {
        false
    }

    /// The dysfunction with every default at a site.
    fn default_of(&self, site: Site, severity: u8) -> Dysfunction {
        self.default_at(Place::from(site), severity)
    }

    /// The dysfunction with every default at a place.
    fn default_at(&self, place: Place, severity: u8) -> Dysfunction {
        let Extent {
            radius_mm,
            angle_deg,
            profile,
        } = self.extent();
        let first = self.presets().first().map(|p| p.key);
        Dysfunction {
            kind: self.key(),
            preset: first.filter(|_| self.needs_preset()),
            place,
            offset_mm: Vec2::ZERO,
            radius_mm,
            angle_deg,
            profile: profile.to_owned(),
            severity,
            change: None,
            skin_drag: None,
            bump_mm: None,
            tender_above_n: None,
            tender_shown: true,
            seed: None,
        }
    }

    /// What it does to the map plane.
    ///
    /// # Errors
    /// Values that are not allowed, or a place that the kind cannot be at.
    fn patches(&self, d: &Dysfunction) -> Result<Vec<Patch>, Fault>;
}

/// A named form of a kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// Name in files.
    pub key: &'static str,
    /// Name for people.
    pub title: &'static str,
    /// What is special about it.
    pub about: &'static str,
}

/// How large a kind is unless stated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Half axes, mm.
    pub radius_mm: [f64; 2],
    /// Direction of the first, degrees, as [`Dysfunction::angle_deg`].
    pub angle_deg: f64,
    /// Falloff.
    pub profile: &'static str,
}

/// How strong a dysfunction is at its centre, everything resolved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Strength {
    /// Change of stiffness; `None`: none.
    pub change: Option<Change>,
    /// Factor on the friction coefficients; `None`: 1.
    pub skin_drag: Option<f64>,
    /// Height of the bump, mm; `None`: flat.
    pub bump_mm: Option<f64>,
    /// Force from which on it hurts, N; `None`: never.
    pub tender_above_n: Option<f64>,
}

impl Strength {
    /// What the stiffness is multiplied by.
    pub fn stiffness_factor(&self) -> f64 {
        self.change.map_or(1.0, Change::factor)
    }
}

impl Dysfunction {
    /// Its kind; `None` for a key that is in no list.
    pub fn kind(&self) -> Option<&'static dyn Kind> {
        named(self.kind)
    }

    /// How strong it is: what is stated, and for the rest what its kind says of its severity.
    pub fn strength(&self) -> Strength {
        let default = self
            .kind()
            .map(|kind| kind.strength(self.preset, self.severity))
            .unwrap_or_default();
        Strength {
            change: self.change.or(default.change),
            skin_drag: self.skin_drag.or(default.skin_drag),
            bump_mm: self.bump_mm.or(default.bump_mm),
            tender_above_n: self.tender_above_n.or(default.tender_above_n),
        }
    }

    /// What it does to the map plane.
    ///
    /// # Errors
    /// Its kind is in no list, a value is not allowed, or the kind cannot be at this place.
    pub fn patches(&self) -> Result<Vec<Patch>, Fault> {
        let Some(kind) = self.kind() else {
            let keys: Vec<&str> = all().iter().map(|k| k.key()).collect();
            let allowed = keys.join(", ");
            return Err(Fault::new(
                "kind",
                format!("{:?}; allowed are {allowed}", self.kind),
            ));
        };
        table::values_fault(self).map_or(Ok(()), Err)?;
        kind.patches(self)
    }
}

/// Shown as "hypertonic at T5 right transverse process".
impl fmt::Display for Dysfunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} at {}", self.kind, self.place)
    }
}

/// What is wrong with a dysfunction: which key of its table, and what with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Key in the file.
    pub key: &'static str,
    /// What is wrong, with the value and what is allowed.
    pub what: String,
}

impl Fault {
    pub(super) fn new(key: &'static str, what: impl Into<String>) -> Self {
        Self {
            key,
            what: what.into(),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)
    }
}
