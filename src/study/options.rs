//! How a session is studied: thresholds and places, all of them stated.

use super::StudyError;
use crate::scenario::dysfunction::sites;
use serde::{Deserialize, Serialize};

/// A place asked about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedPlace {
    /// Such as "T5 right transverse process".
    pub name: String,
    /// On the map plane, mm.
    pub at_mm: [f64; 2],
}

/// When a finger searches and when it palpates. See [`super::phases`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhaseRule {
    /// A finger that presses at least as hard palpates, however fast it moves, N.
    pub firm_n: f64,
    /// A finger on the skin that gets on slower than this dwells and so palpates; faster and lighter it searches, mm/s.
    pub slow_mm_s: f64,
    /// Both bounds hold on to what is: a phase ends only where they are passed by this share.
    pub hysteresis: f64,
    /// A phase lasts at least so long; what is shorter belongs to the phase before it, s.
    pub least_s: f64,
}

/// What a press is. See [`super::presses`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PressRule {
    /// A press begins where the force has risen by so much since the end of the last one, or since contact, N.
    pub rise_n: f64,
    /// It ends below this share of its own peak.
    pub release_share: f64,
    /// It ends below this force in any case, N.
    pub release_n: f64,
    /// What is shorter is none, s.
    pub least_s: f64,
    /// A press whose finger moved further over the skin than this is a stroke, mm.
    pub stroke_mm: f64,
}

/// How a session is studied.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Options {
    /// Edge of a cell of the dwell map and of coverage, mm; 1 to 50.
    pub cell_mm: f64,
    /// Where the stiffness felt is asked for.
    pub sites: Vec<NamedPlace>,
    /// The sites are those of the built-in back: they are left out where another surface was felt.
    pub sites_of_builtin: bool,
    /// A press belongs to the nearest site within this distance, mm: half the way between neighbouring levels.
    pub near_mm: f64,
    /// Edges of the bands of force, N: rising, at most `MOST_BANDS` − 1 of them.
    pub force_bands_n: Vec<f64>,
    /// Search and palpation.
    pub phases: PhaseRule,
    /// Presses and strokes.
    pub presses: PressRule,
}

/// Most bands of force.
pub const MOST_BANDS: usize = 8;

impl Default for Options {
    /// 5 mm cells; spinous and transverse processes of the built-in back; bands up to 0.5, 2, 4, 8 N and above.
    fn default() -> Self {
        Self {
            cell_mm: 5.0,
            sites: builtin_sites(),
            sites_of_builtin: true,
            near_mm: 12.0,
            force_bands_n: vec![0.5, 2.0, 4.0, 8.0],
            phases: PhaseRule {
                firm_n: 2.0,
                slow_mm_s: 15.0,
                hysteresis: 0.2,
                least_s: 0.25,
            },
            presses: PressRule {
                rise_n: 0.5,
                release_share: 0.4,
                release_n: 0.25,
                least_s: 0.05,
                stroke_mm: 15.0,
            },
        }
    }
}

fn builtin_sites() -> Vec<NamedPlace> {
    let named = sites("C7-L5 middle; C7-L5 both").unwrap_or_default();
    let place = |site: crate::scenario::Site| NamedPlace {
        name: site.to_string(),
        at_mm: site.at_mm().to_array(),
    };
    named.into_iter().map(place).collect()
}

impl Options {
    /// Whether every value is one that can be used.
    ///
    /// # Errors
    /// The first that is not.
    pub fn check(&self) -> Result<(), StudyError> {
        let (phases, presses) = (&self.phases, &self.presses);
        let positive = "more than 0 and at most 1e6";
        let share = "0 to 0.9";
        let numbers = [
            ("cell_mm", self.cell_mm, 1.0..=50.0, "1 to 50"),
            ("near_mm", self.near_mm, 1e-6..=1e6, positive),
            ("firm_n", phases.firm_n, 1e-6..=1e6, positive),
            ("slow_mm_s", phases.slow_mm_s, 1e-6..=1e6, positive),
            ("hysteresis", phases.hysteresis, 0.0..=0.9, share),
            ("least_s of a phase", phases.least_s, 0.0..=60.0, "0 to 60"),
            ("rise_n", presses.rise_n, 1e-6..=1e6, positive),
            ("release_share", presses.release_share, 0.0..=0.9, share),
            ("release_n", presses.release_n, 0.0..=1e6, "0 to 1e6"),
            ("least_s of a press", presses.least_s, 0.0..=60.0, "0 to 60"),
            ("stroke_mm", presses.stroke_mm, 1e-6..=1e6, positive),
        ];
        for (option, value, allowed_range, allowed) in numbers {
            if !allowed_range.contains(&value) {
                let value = value.to_string();
                return Err(StudyError::Option {
                    option,
                    value,
                    allowed,
                });
            }
        }
        let edges = &self.force_bands_n;
        let rising = edges.windows(2).all(|pair| pair[0] < pair[1]);
        let sound = edges.iter().all(|edge| edge.is_finite() && *edge > 0.0);
        if !rising || !sound || edges.len() >= MOST_BANDS {
            return Err(StudyError::Option {
                option: "force_bands_n",
                value: format!("{edges:?}"),
                allowed: "at most 7 rising forces above 0 N",
            });
        }
        if let Some(place) = self
            .sites
            .iter()
            .find(|s| !s.at_mm.iter().all(|x| x.is_finite()))
        {
            return Err(StudyError::Option {
                option: "sites",
                value: format!("{} at {:?}", place.name, place.at_mm),
                allowed: "places in mm",
            });
        }
        Ok(())
    }
}
