//! Sessions: how a run is written, read, replayed and checked.
//!
//! A session is an MCAP file; the layout is specified in [`mod@format`]. Nothing here names the scenario module: a recording
//! carries its scenario as text.
//!
//! | to do | use |
//! |---|---|
//! | write as fast as ticks come | [`SessionWriter`] |
//! | write beside a live servo | [`RecorderThread`] |
//! | read, also what a killed program left | [`Session`] |
//! | open at once and show any instant | [`Timeline`], [`Playback`] |
//! | repeat a run otherwise, and tell how far that is off | [`diverge`] |
//! | save what a damaged file still holds | [`recover`] |
//! | make a finished file smaller | [`compress`] |
//! | repeat a run and compare | [`resimulate`], [`check`] |

mod compare;
mod divergence;
mod extras;
mod faults;
pub mod format;
mod header;
mod index;
mod playback;
mod pops;
pub mod reader;
pub mod recorder;
mod recording;
mod records;
pub mod replay;
mod rewrite;
mod timeline;
mod wire;
pub mod writer;

pub use compare::{Difference, FieldDifference};
pub use divergence::{Divergence, FingerOff, Off, Otherwise, Spread, diverge};
pub use extras::{Extras, Folder};
pub use format::{Edit, Event};
pub use header::{DeviceInfo, Header, MeshSource, build_id, utc_now};
pub use playback::{PLAYBACK_SPEEDS, Playback, Source};
pub use reader::Session;
pub use recorder::{RecorderHandle, RecorderState, RecorderStatus, RecorderThread};
pub use recording::Recording;
pub use records::{Damage, Entry, Records, Strictness, Ticks};
pub use replay::{
    CheckReport, Passed, Rebuild, Resimulated, Resimulation, check, check_edited, check_with,
    input_of, resimulate, resimulate_edited,
};
pub use rewrite::{Compressed, FingerLoss, RecoverOptions, RecoverReport, compress, recover};
pub use timeline::Timeline;
pub use writer::{IfExists, RecordingSummary, SessionWriter};

use std::path::PathBuf;

/// Why a session could not be written, read or repeated.
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
    /// The header of a new session holds a value that cannot be written.
    #[error("session header: {key} is {value:?}; allowed: {allowed}")]
    Header {
        /// Which entry.
        key: String,
        /// Its value.
        value: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The run was felt on another surface than the one it is to be repeated on.
    #[error(
        "{path}: recorded on surface {recorded}, but the scene has {found}; replay it with the scenario it was recorded in"
    )]
    OtherSurface {
        /// Which file.
        path: PathBuf,
        /// Hash in the file, shortened.
        recorded: String,
        /// Hash of the scene's surface, shortened.
        found: String,
    },
    /// The run was felt in a scene that was hidden, and its trial was never answered.
    #[error(
        "{path}: a trial that was not answered: the scene it was felt in stayed hidden, and it cannot be repeated"
    )]
    Sealed {
        /// Which file.
        path: PathBuf,
    },
    /// A tick was felt in a scene that is not to be had.
    #[error("{path}: tick {tick} was felt after edit {edit} of the scene; {reason}")]
    Edit {
        /// Which file.
        path: PathBuf,
        /// The tick.
        tick: u64,
        /// Number of the edit.
        edit: u32,
        /// Why there is no scene for it.
        reason: String,
    },
    /// Whoever watched wanted no more.
    #[error("stopped before it was done")]
    Stopped,
    /// The recorder is not in a state to do this, or does not answer.
    #[error("recorder: {0}")]
    Recorder(String),
}
