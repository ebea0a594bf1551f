//! Dysfunctions, sites and kinds as printed.

use crate::cli::print;
use crate::scenario::dysfunction::{self, MOST_SEVERE, Strength, side_name};
use crate::scenario::{Change, Dysfunction, Kind, Place, Scene, Site};
use serde::Serialize;

/// A dysfunction as printed.
#[derive(Serialize)]
pub(super) struct Printed {
    pub(super) kind: &'static str,
    pub(super) preset: Option<&'static str>,
    pub(super) place: String,
    pub(super) sites: Vec<PrintedSite>,
    pub(super) severity: u8,
    #[serde(flatten)]
    pub(super) strength: PrintedStrength,
    /// What of it the mesh carries where it carries least, 0.5 to 1.
    pub(super) carried: f64,
}

impl Printed {
    fn of((d, carried): (&Dysfunction, f64)) -> Self {
        let sites: &[Site] = match &d.place {
            Place::Sites(sites) => sites,
            Place::At(_) => &[],
        };
        Self {
            kind: d.kind,
            preset: d.preset,
            place: d.place.to_string(),
            sites: sites.iter().map(PrintedSite::from).collect(),
            severity: d.severity,
            strength: d.strength().into(),
            carried,
        }
    }
}

/// The dysfunctions of a scene but for the first few.
pub(super) fn printed(scene: &Scene, first: usize) -> Vec<Printed> {
    let all = scene.scenario.dysfunctions.iter().zip(scene.carried());
    all.skip(first).map(Printed::of).collect()
}

#[derive(Serialize)]
pub(super) struct PrintedStrength {
    pub(super) stiffness_factor: f64,
    pub(super) stiffness_percent: f64,
    pub(super) compliance_percent: f64,
    pub(super) skin_drag: f64,
    pub(super) bump_mm: f64,
    pub(super) tender_above_n: Option<f64>,
}

impl From<Strength> for PrintedStrength {
    fn from(s: Strength) -> Self {
        Self {
            stiffness_factor: s.stiffness_factor(),
            stiffness_percent: s.change.map_or(0.0, Change::stiffness_percent),
            compliance_percent: s.change.map_or(0.0, Change::compliance_percent),
            skin_drag: s.skin_drag.unwrap_or(1.0),
            bump_mm: s.bump_mm.unwrap_or(0.0),
            tender_above_n: s.tender_above_n,
        }
    }
}

impl std::fmt::Display for PrintedStrength {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut parts = Vec::new();
        if self.stiffness_factor != 1.0 {
            let (s, c) = (self.stiffness_percent, self.compliance_percent);
            parts.push(format!("stiffness {s:+.1} % (compliance {c:+.1} %)"));
        }
        if self.skin_drag != 1.0 {
            parts.push(format!("skin drag × {}", self.skin_drag));
        }
        if self.bump_mm != 0.0 {
            parts.push(format!("bump {:+} mm", self.bump_mm));
        }
        if let Some(above_n) = self.tender_above_n {
            parts.push(format!("tender above {above_n} N"));
        }
        if parts.is_empty() {
            parts.push("nothing".into());
        }
        f.write_str(&parts.join(", "))
    }
}

#[derive(Serialize)]
pub(super) struct PrintedSite {
    pub(super) site: String,
    pub(super) level: &'static str,
    pub(super) side: &'static str,
    pub(super) target: &'static str,
    pub(super) x_mm: f64,
    pub(super) y_mm: f64,
}

impl From<&Site> for PrintedSite {
    fn from(site: &Site) -> Self {
        let at = site.at_mm();
        Self {
            site: site.to_string(),
            level: site.level.name(),
            side: side_name(site.side),
            target: site.target.name(),
            x_mm: at.x,
            y_mm: at.y,
        }
    }
}

#[derive(Serialize)]
pub(super) struct PrintedKind {
    pub(super) kind: &'static str,
    pub(super) title: &'static str,
    pub(super) about: &'static str,
    pub(super) radius_mm: [f64; 2],
    pub(super) angle_deg: f64,
    pub(super) profile: &'static str,
    pub(super) forms: Vec<PrintedForm>,
}

#[derive(Serialize)]
pub(super) struct PrintedForm {
    pub(super) preset: Option<&'static str>,
    pub(super) about: Option<&'static str>,
    /// One for each severity from 0.
    pub(super) severities: Vec<PrintedStrength>,
}

impl From<&'static dyn Kind> for PrintedKind {
    fn from(kind: &'static dyn Kind) -> Self {
        let extent = kind.extent();
        let form = |preset: Option<&dysfunction::Preset>| PrintedForm {
            preset: preset.map(|p| p.key),
            about: preset.map(|p| p.about),
            severities: (0..=MOST_SEVERE)
                .map(|severity| kind.strength(preset.map(|p| p.key), severity).into())
                .collect(),
        };
        Self {
            kind: kind.key(),
            title: kind.title(),
            about: kind.about(),
            radius_mm: extent.radius_mm,
            angle_deg: extent.angle_deg,
            profile: extent.profile,
            forms: match kind.presets() {
                [] => vec![form(None)],
                presets => presets.iter().map(|p| form(Some(p))).collect(),
            },
        }
    }
}

pub(super) fn tell_one(i: usize, d: &Printed) {
    let (n, kind, place, severity) = (i + 1, d.kind, &d.place, d.severity);
    let preset = d.preset.map_or(String::new(), |p| format!(" ({p})"));
    let strength = &d.strength;
    let carried = match 100.0 * d.carried {
        99.5.. => String::new(),
        share => format!("; the mesh carries {share:.0} % of it"),
    };
    print(format_args!(
        "  {n}. {kind}{preset} at {place}, severity {severity}: {strength}{carried}"
    ));
}
