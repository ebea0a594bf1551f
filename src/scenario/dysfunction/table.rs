//! The table `[[dysfunction]]`, and what its values may be.

use super::conflict::{self, Clash};
use super::site::levels;
use super::{
    Change, DEFAULT_SEVERITY, Dysfunction, Fault, MOST_SEVERE, Place, Target, VertebralLevel, all,
    sites_in,
};
use crate::contact::Friction;
use crate::geom::{Vec2, curve};
use crate::maps::StiffnessMap;
use crate::scenario::ScenarioError;
use crate::scenario::check::Check;
use crate::scenario::maps::MAP_MM;
use serde::Deserialize;
use std::ops::{Range, RangeInclusive};
use toml::Spanned;

const OFFSETS_MM: RangeInclusive<f64> = -100.0..=100.0;
const RADII_MM: RangeInclusive<f64> = 1.0..=300.0;
const ANGLES_DEG: RangeInclusive<f64> = -360.0..=360.0;
/// A hundredth of the stiffness to ten times it, as a change of either.
const STIFFNESS_PERCENT: RangeInclusive<f64> = -99.0..=900.0;
const COMPLIANCE_PERCENT: RangeInclusive<f64> = -90.0..=9900.0;
const DRAGS: RangeInclusive<f64> = 0.1..=10.0;
const BUMPS_MM: RangeInclusive<f64> = -20.0..=20.0;
const TENDER_N: RangeInclusive<f64> = 0.1..=50.0;
/// Largest whole number of a TOML file.
const MOST_SEED: u64 = i64::MAX as u64;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::scenario) struct DysfunctionTable {
    kind: Spanned<String>,
    preset: Option<Spanned<String>>,
    level: Option<Spanned<String>>,
    levels: Option<Spanned<String>>,
    side: Option<Spanned<String>>,
    target: Option<Spanned<String>>,
    sites: Option<Spanned<String>>,
    at_mm: Option<Spanned<[f64; 2]>>,
    offset_mm: Option<Spanned<[f64; 2]>>,
    radius_mm: Option<Spanned<[f64; 2]>>,
    angle_deg: Option<Spanned<f64>>,
    profile: Option<Spanned<String>>,
    severity: Option<Spanned<i64>>,
    stiffness_change: Option<Spanned<ChangeTable>>,
    skin_drag: Option<Spanned<f64>>,
    bump_mm: Option<Spanned<f64>>,
    tender_above_n: Option<Spanned<f64>>,
    tender_shown: Option<Spanned<bool>>,
    seed: Option<Spanned<i64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ChangeTable {
    compliance_percent: Option<f64>,
    stiffness_percent: Option<f64>,
}

impl DysfunctionTable {
    fn span(&self, key: &str) -> Option<Range<usize>> {
        fn of<T>(value: &Option<Spanned<T>>) -> Option<Range<usize>> {
            value.as_ref().map(Spanned::span)
        }
        match key {
            "kind" => Some(self.kind.span()),
            "preset" => of(&self.preset),
            "level" | "levels" | "sites" => of(&self.level)
                .or_else(|| of(&self.levels))
                .or_else(|| of(&self.sites)),
            "side" => of(&self.side).or_else(|| of(&self.sites)),
            "target" => of(&self.target).or_else(|| of(&self.sites)),
            "at_mm" => of(&self.at_mm),
            "offset_mm" => of(&self.offset_mm),
            "radius_mm" => of(&self.radius_mm),
            "angle_deg" => of(&self.angle_deg),
            "profile" => of(&self.profile),
            "severity" => of(&self.severity),
            "stiffness_change" => of(&self.stiffness_change),
            "skin_drag" => of(&self.skin_drag),
            "bump_mm" => of(&self.bump_mm),
            "tender_above_n" => of(&self.tender_above_n),
            "seed" => of(&self.seed),
            _ => None,
        }
    }
}

impl Check<'_> {
    /// All of them, checked one by one and together. `on_back`: the surface is the built-in back; `map` is the stiffness
    /// under them.
    pub(in crate::scenario) fn dysfunctions(
        &self,
        tables: &[Spanned<DysfunctionTable>],
        on_back: bool,
        friction: Option<&Friction>,
        map: &StiffnessMap,
    ) -> Result<Vec<Dysfunction>, ScenarioError> {
        let tell = |index: usize, name: &str, fault: &Fault| {
            let table = &tables[index];
            let span = table.get_ref().span(fault.key);
            let what = format!("dysfunction {} ({name}): {}", index + 1, fault.what);
            self.fail(&span.unwrap_or_else(|| table.span()), what)
        };
        let mut read = Vec::new();
        for (i, table) in tables.iter().enumerate() {
            let table = table.get_ref();
            let d = dysfunction(table, on_back);
            let d = d.map_err(|fault| tell(i, table.kind.get_ref(), &fault))?;
            if let Some(fault) = values_fault(&d) {
                return Err(tell(i, &d.to_string(), &fault));
            }
            read.push(d);
        }
        conflict::check(&read, friction, map)
            .map_err(|Clash { index, fault }| tell(index, &read[index].to_string(), &fault))?;
        Ok(read)
    }
}

fn dysfunction(t: &DysfunctionTable, on_back: bool) -> Result<Dysfunction, Fault> {
    let key = t.kind.get_ref().as_str();
    let Some(kind) = super::named(key) else {
        let keys: Vec<_> = all().iter().map(|k| format!("{:?}", k.key())).collect();
        let what = format!("kind = {key:?}; allowed are {}", keys.join(", "));
        return Err(Fault::new("kind", what));
    };
    let preset = match &t.preset {
        None => None,
        Some(given) => {
            let given = given.get_ref().as_str();
            let found = kind.presets().iter().find(|p| p.key == given);
            Some(
                found
                    .map(|p| p.key)
                    .ok_or_else(|| preset_fault(kind, Some(given)))?,
            )
        }
    };
    let severity = match &t.severity {
        None => DEFAULT_SEVERITY,
        Some(given) => u8::try_from(*given.get_ref())
            .ok()
            .filter(|s| *s <= MOST_SEVERE)
            .ok_or_else(|| severity_fault(*given.get_ref()))?,
    };
    let seed = match &t.seed {
        None => None,
        Some(seed) => Some(u64::try_from(*seed.get_ref()).map_err(|_| {
            let what = format!("seed = {}; 0 to {MOST_SEED} is allowed", seed.get_ref());
            Fault::new("seed", what)
        })?),
    };
    let default = kind.default_at(place(t, on_back)?, severity);
    let number = |v: &Option<Spanned<f64>>| v.as_ref().map(|v| *v.get_ref());
    let pair = |v: &Option<Spanned<[f64; 2]>>| v.as_ref().map(|v| *v.get_ref());
    Ok(Dysfunction {
        preset,
        offset_mm: pair(&t.offset_mm).map_or(Vec2::ZERO, Vec2::from),
        radius_mm: pair(&t.radius_mm).unwrap_or(default.radius_mm),
        angle_deg: number(&t.angle_deg).unwrap_or(default.angle_deg),
        profile: (t.profile.as_ref()).map_or(default.profile, |p| p.get_ref().clone()),
        change: t
            .stiffness_change
            .as_ref()
            .map(|c| change(c.get_ref()))
            .transpose()?,
        skin_drag: number(&t.skin_drag),
        bump_mm: number(&t.bump_mm),
        tender_above_n: number(&t.tender_above_n),
        tender_shown: t
            .tender_shown
            .as_ref()
            .map_or(default.tender_shown, |s| *s.get_ref()),
        seed,
        ..default
    })
}

fn change(t: &ChangeTable) -> Result<Change, Fault> {
    match (t.compliance_percent, t.stiffness_percent) {
        (Some(percent), None) => Ok(Change::CompliancePercent(percent)),
        (None, Some(percent)) => Ok(Change::StiffnessPercent(percent)),
        _ => {
            let what = "stiffness_change needs either compliance_percent or stiffness_percent";
            Err(Fault::new("stiffness_change", what))
        }
    }
}

fn place(t: &DysfunctionTable, on_back: bool) -> Result<Place, Fault> {
    let by_level = t.level.is_some() || t.levels.is_some();
    let by_words = by_level || t.side.is_some() || t.target.is_some();
    let place = match (&t.at_mm, &t.sites) {
        (Some(at), None) if !by_words => return Ok(Place::At(Vec2::from(*at.get_ref()))),
        (None, Some(text)) if !by_words => {
            let text = text.get_ref();
            sites_in(text).map_err(|e| Fault::new("sites", format!("sites = {text:?}: {e}")))?
        }
        (None, None) if by_level => by_words_of(t)?,
        _ => {
            let what = "the place needs either level (or levels) and side, or sites, or at_mm";
            return Err(Fault::new("kind", what));
        }
    };
    if !on_back {
        let what = "levels are those of builtin = \"back\"; on a mesh the place is at_mm = [x, y]";
        return Err(Fault::new("levels", what));
    }
    Ok(Place::Sites(place))
}

fn by_words_of(t: &DysfunctionTable) -> Result<Vec<super::Site>, Fault> {
    let (key, text) = match (&t.level, &t.levels) {
        (Some(level), None) => ("level", level.get_ref()),
        (None, Some(levels)) => ("levels", levels.get_ref()),
        _ => {
            let what = "level and levels are both there; keep one of them";
            return Err(Fault::new("level", what));
        }
    };
    let tell = |e: String| Fault::new(key, format!("{key} = {text:?}: {e}"));
    if key == "level" && VertebralLevel::named(text.trim()).is_none() {
        let e = "not one level; C7, T1 to T12 and L1 to L5 are, and levels takes several";
        return Err(tell(e.to_owned()));
    }
    levels(text).map_err(tell)?;
    let side = t.side.as_ref().map(|s| s.get_ref().as_str());
    if let Some(side) = side
        && !super::site::SIDES.iter().any(|(name, _)| *name == side)
    {
        let what =
            format!("side = {side:?}; allowed are \"left\", \"right\", \"both\", \"middle\"");
        return Err(Fault::new("side", what));
    }
    let target = t.target.as_ref().map(|t| t.get_ref().as_str());
    if let Some(target) = target
        && Target::named(target).is_none()
    {
        let names: Vec<_> = Target::all()
            .iter()
            .map(|t| format!("{:?}", t.name()))
            .collect();
        let what = format!("target = {target:?}; allowed are {}", names.join(", "));
        return Err(Fault::new("target", what));
    }
    let side = match (side, target) {
        (Some(side), _) => side,
        (None, Some("spinous")) => "middle",
        (None, _) => {
            let what = "side is missing; allowed are \"left\", \"right\", \"both\", \"middle\"";
            return Err(Fault::new("level", what));
        }
    };
    sites_in(&format!("{text} {side} {}", target.unwrap_or_default()))
        .map_err(|e| Fault::new("target", e))
}

fn preset_fault(kind: &dyn super::Kind, given: Option<&str>) -> Fault {
    let names: Vec<_> = kind
        .presets()
        .iter()
        .map(|p| format!("{:?}", p.key))
        .collect();
    let names = names.join(", ");
    let what = match given {
        Some(given) if names.is_empty() => {
            format!("preset = {given:?}; kind = {:?} has none", kind.key())
        }
        Some(given) => format!("preset = {given:?}; allowed are {names}"),
        None => format!("kind = {:?} needs a preset: {names}", kind.key()),
    };
    Fault::new("preset", what)
}

fn severity_fault(given: impl std::fmt::Display) -> Fault {
    Fault::new(
        "severity",
        format!("severity = {given}; 0 to {MOST_SEVERE} is allowed"),
    )
}

/// The first value that is not allowed, if any.
pub(super) fn values_fault(d: &Dysfunction) -> Option<Fault> {
    let within = |key, value: f64, allowed: &RangeInclusive<f64>| {
        (!allowed.contains(&value)).then(|| {
            let (least, most) = (allowed.start(), allowed.end());
            Fault::new(
                key,
                format!("{key} = {value}; {least} to {most} is allowed"),
            )
        })
    };
    let both = |key, [a, b]: [f64; 2], allowed: &RangeInclusive<f64>| {
        let outside = !(allowed.contains(&a) && allowed.contains(&b));
        outside.then(|| {
            let (least, most) = (allowed.start(), allowed.end());
            let what = format!("{key} = [{a}, {b}]; {least} to {most} is allowed for each");
            Fault::new(key, what)
        })
    };
    let maybe = |key, value: Option<f64>, allowed| value.and_then(|v| within(key, v, allowed));
    let change = || match d.change? {
        Change::CompliancePercent(c) => within("compliance_percent", c, &COMPLIANCE_PERCENT),
        Change::StiffnessPercent(s) => within("stiffness_percent", s, &STIFFNESS_PERCENT),
    };
    let change = || {
        change().map(|f| Fault {
            key: "stiffness_change",
            ..f
        })
    };
    place_fault(&d.place)
        .or_else(|| {
            let kind = d.kind()?;
            match d.preset {
                None => kind.needs_preset().then(|| preset_fault(kind, None)),
                Some(given) => (!kind.presets().iter().any(|p| p.key == given))
                    .then(|| preset_fault(kind, Some(given))),
            }
        })
        .or_else(|| both("offset_mm", d.offset_mm.to_array(), &OFFSETS_MM))
        .or_else(|| both("radius_mm", d.radius_mm, &RADII_MM))
        .or_else(|| within("angle_deg", d.angle_deg, &ANGLES_DEG))
        .or_else(|| {
            let names: Vec<_> = curve::all().iter().map(|(n, _)| format!("{n:?}")).collect();
            let named = curve::all().iter().any(|(name, _)| *name == d.profile);
            (!named).then(|| {
                let allowed = names.join(", ");
                let what = format!("profile = {:?}; allowed are {allowed}", d.profile);
                Fault::new("profile", what)
            })
        })
        .or_else(|| (d.severity > MOST_SEVERE).then(|| severity_fault(d.severity)))
        .or_else(change)
        .or_else(|| maybe("skin_drag", d.skin_drag, &DRAGS))
        .or_else(|| maybe("bump_mm", d.bump_mm, &BUMPS_MM))
        .or_else(|| maybe("tender_above_n", d.tender_above_n, &TENDER_N))
        .or_else(|| {
            let seed = d.seed.filter(|seed| *seed > MOST_SEED)?;
            let what = format!("seed = {seed}; 0 to {MOST_SEED} is allowed");
            Some(Fault::new("seed", what))
        })
}

fn place_fault(place: &Place) -> Option<Fault> {
    match place {
        Place::At(at) => {
            let inside = MAP_MM.contains(&at.x) && MAP_MM.contains(&at.y);
            let (least, most) = (MAP_MM.start(), MAP_MM.end());
            let what = format!(
                "at_mm = [{}, {}]; {least} to {most} is allowed for each",
                at.x, at.y
            );
            (!inside).then(|| Fault::new("at_mm", what))
        }
        Place::Sites(sites) if sites.is_empty() => {
            Some(Fault::new("levels", "no site; at least one is needed"))
        }
        Place::Sites(sites) => {
            let fault = sites.iter().find_map(|s| s.fault());
            let twice = || {
                let again = sites
                    .iter()
                    .enumerate()
                    .find(|(i, s)| sites[..*i].contains(s));
                again.map(|(_, s)| format!("{s} is there twice"))
            };
            fault.or_else(twice).map(|what| Fault::new("sites", what))
        }
    }
}
