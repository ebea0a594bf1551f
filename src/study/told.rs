//! What a session tells: plain values, for tables, panels and reports.

use super::felt::Felt;
use super::metrics::Metrics;
use super::phases::Phase;
use super::presses::Press;
use crate::session::{Damage, Session};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// What one file tells.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Analysis {
    /// What was recorded.
    pub about: About,
    /// All fingers together: times and counts are sums over the fingers, means are weighted by time.
    pub whole: Metrics,
    /// The same while the fingers searched.
    pub search: Metrics,
    /// The same while they palpated.
    pub palpation: Metrics,
    /// Each finger, in order.
    pub fingers: Vec<FingerAnalysis>,
    /// The stiffness felt at each site that was pressed, by any finger.
    pub felt: Vec<Felt>,
    /// Where the fingers were on the skin, and for how long.
    pub dwell: Dwell,
    /// Marks, answers and other events in the order of time; the first [`MOST_EVENTS`].
    pub events: Vec<Moment>,
    /// Edges of the bands that [`Metrics::band_s`] goes by, N.
    pub force_bands_n: Vec<f64>,
    /// What could not be read.
    pub damage: Damage,
}

/// Most events that are listed.
pub const MOST_EVENTS: usize = 10_000;

/// An event of the session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Moment {
    /// From the first tick of the session, s.
    pub time_s: f64,
    /// What sort, one word, such as `mark`.
    pub kind: String,
    /// What it says.
    pub text: String,
}

/// What was recorded.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// The file.
    pub file: PathBuf,
    /// Pseudonym.
    pub participant: Option<String>,
    /// Name of the scenario.
    pub scenario: String,
    /// Start, UTC, ISO 8601.
    pub started_utc: String,
    /// Program that recorded it.
    pub build: String,
    /// One name a finger.
    pub devices: Vec<String>,
    /// Ticks per second.
    pub rate_hz: f64,
    /// Ticks in the file, of the finger that has most.
    pub ticks: u64,
    /// Their time, s.
    pub seconds: f64,
    /// Finger ticks that are missing where none should be: they never reached the recorder, or their chunk is damaged.
    pub lost: u64,
    /// Edits of the scene while it was felt.
    pub edits: u32,
    /// Events such as marks.
    pub events: u32,
    /// SHA-256 of the surface, hexadecimal.
    pub mesh_hash: String,
    /// `builtin:back`, or the mesh file as the scenario states it.
    pub mesh_origin: String,
    /// The trial was not answered: nothing else is told.
    pub sealed: bool,
    /// Size of the file, bytes.
    pub bytes: u64,
}

impl About {
    /// What the head of a file says; ticks, time, edits and events are 0 until it is read.
    pub fn of(session: &Session) -> Self {
        let header = session.header();
        Self {
            file: session.path().to_owned(),
            participant: header.participant.clone(),
            scenario: header.scenario_name.clone(),
            started_utc: header.started_utc.clone(),
            build: header.build.clone(),
            devices: header.devices.iter().map(|d| d.name.clone()).collect(),
            rate_hz: header.rate_hz,
            mesh_hash: header.mesh.hash.clone(),
            mesh_origin: header.mesh.origin.clone(),
            sealed: header.sealed,
            bytes: session.bytes(),
            ..Self::default()
        }
    }

    /// Short name for tables and legends: the file's own without its ending.
    pub fn name(&self) -> String {
        let stem = self.file.file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    }
}

/// Name of a finger, from 0, for people.
pub fn finger_name(finger: u8) -> &'static str {
    match finger {
        0 => "Left finger",
        1 => "Right finger",
        2 => "Second left finger",
        3 => "Second right finger",
        _ => "Further finger",
    }
}

/// What one finger did.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FingerAnalysis {
    /// Which, from 0.
    pub finger: u8,
    /// When it first touched the skin, from the first tick of the session, s; absent where it never did.
    pub first_contact_s: Option<f64>,
    /// From first to last tick.
    pub whole: Metrics,
    /// While it searched.
    pub search: Metrics,
    /// While it palpated.
    pub palpation: Metrics,
    /// One after the other, without gaps but where the recording has one.
    pub phases: Vec<Phase>,
    /// In the order of time; the first [`super::presses::MOST_PRESSES`].
    pub presses: Vec<Press>,
    /// The stiffness it felt at each site it pressed.
    pub felt: Vec<Felt>,
}

/// Time on the skin over the map plane, all fingers together.
///
/// Cells lie on a lattice through the origin of the plane, so that maps of equal cells can be added cell by cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Dwell {
    /// Corner of the first cell, mm: a multiple of `cell_mm`.
    pub origin_mm: [f64; 2],
    /// Edge of a cell, mm.
    pub cell_mm: f64,
    /// Cells along x.
    pub columns: usize,
    /// Cells along y.
    pub rows: usize,
    /// Time in each cell, s; row by row from the origin, which is the lower left.
    pub seconds: Vec<f32>,
}

impl Dwell {
    /// Longest time in a cell, s.
    pub fn most_s(&self) -> f64 {
        f64::from(self.seconds.iter().copied().fold(0.0, f32::max))
    }

    /// All time on the skin, s.
    pub fn total_s(&self) -> f64 {
        self.seconds.iter().map(|s| f64::from(*s)).sum()
    }
}
