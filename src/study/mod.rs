//! What recorded sessions tell: measures of one session, differences between two, agreement and groups of many.
//!
//! | part | answers |
//! |---|---|
//! | [`analyse()`](analyse()) | what one file tells: a pure function of it, in one pass, in memory that does not grow with its length |
//! | [`metrics`] | the list of measures that tables, panels and reports loop over |
//! | [`phases`], [`presses`], [`felt`] | search and palpation, pressing and stroking, the stiffness felt at a site |
//! | [`smooth`] | SPARC and jerk of a movement |
//! | [`compare`] | two recordings aligned, and how far they are apart over time |
//! | [`otherwise`] | a recording repeated in another scenario, with another model, engine or rate, and how far that is off |
//! | [`stats`] | agreement of series, differences of groups |
//! | [`cohort`] | many files at once, in memory that does not grow with their number |
//! | [`export`] | sessions handed on: Parquet, CSV, BIDS-Motion |
//! | [`index`] | what a folder of recordings holds, kept in a cache, with the user's tags |
//! | [`groups`] | many sessions: before and after, novices and experts, learning curves |
//! | [`report`], [`tables`] | what was found as a page, and as tables for files |

mod analyse;
pub mod cohort;
pub mod compare;
pub mod export;
pub mod felt;
mod frame;
pub mod groups;
pub mod index;
pub mod metrics;
mod options;
pub mod otherwise;
pub mod phases;
pub mod presses;
pub mod report;
pub mod smooth;
pub mod stats;
mod sum;
pub mod tables;
#[cfg(test)]
pub(crate) mod tests;
pub mod told;

pub use analyse::analyse;
pub use felt::Felt;
pub use metrics::{METRICS, Metric, Metrics};
pub use options::{NamedPlace, Options, PhaseRule, PressRule};
pub use phases::{Phase, PhaseKind};
pub use presses::{Press, PressKind};
pub use told::{About, Analysis, Dwell, FingerAnalysis, Moment, finger_name};

use crate::session::SessionError;
use std::path::PathBuf;

/// Why a session could not be studied.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The file cannot be read.
    #[error("{0}")]
    Session(#[from] SessionError),
    /// A trial that was not answered.
    #[error(
        "{path}: a trial that was not answered stays sealed: nothing of how it was felt is told"
    )]
    Sealed {
        /// Which file.
        path: PathBuf,
    },
    /// An option has a value that is not allowed.
    #[error("{option} is {value}; allowed: {allowed}")]
    Option {
        /// Which.
        option: &'static str,
        /// Its value.
        value: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A scene cannot be built.
    #[error("{0}")]
    Scene(String),
    /// There is not enough to tell from.
    #[error("{0}")]
    TooLittle(String),
    /// A report or table could not be made.
    #[error("{0}")]
    Output(String),
    /// `progress` said stop.
    #[error("cancelled")]
    Stopped,
}
