//! Sessions: how a run is written, read, replayed and checked.
//!
//! A session is an MCAP file; the layout is specified in [`format`]. Nothing here names the scenario module: a recording
//! carries its scenario as text.

pub mod format;
pub mod reader;
pub mod recorder;
pub mod replay;

use std::path::PathBuf;

/// Where the recorded surface came from.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct MeshSource {
    /// SHA-256 of the surface ([`crate::surface::Surface::hash`]), hexadecimal.
    pub hash: String,
    /// `builtin:back` or a path as the scenario states it.
    pub origin: String,
    /// Number of triangles.
    pub triangles: usize,
}

/// What was used to feel it.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct DeviceInfo {
    /// Name.
    pub name: String,
    /// Highest force, N.
    pub rated_force_n: f64,
    /// Fastest rise allowed, N/s.
    pub rise_n_per_s: f64,
}

/// Everything beside the ticks that is needed to rebuild a run.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Header {
    /// The scenario file as it was, whole.
    pub scenario_toml: String,
    /// Its name.
    pub scenario_name: String,
    /// The surface.
    pub mesh: MeshSource,
    /// One per finger.
    pub devices: Vec<DeviceInfo>,
    /// Ticks per second.
    pub rate_hz: f64,
    /// Program version and commit that recorded it.
    pub build: String,
    /// Start, UTC, ISO 8601.
    pub started_utc: String,
    /// Pseudonym of the participant; nothing else personal is written.
    pub participant: Option<String>,
}

/// Why a session could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// The file system said no.
    #[error("{path}: {source}")]
    Io {
        /// Which file.
        path: PathBuf,
        /// What it said.
        source: std::io::Error,
    },
    /// The file is not a session or is damaged.
    #[error("{path}: not a readable session: {reason}")]
    Damaged {
        /// Which file.
        path: PathBuf,
        /// What is wrong and where.
        reason: String,
    },
}
