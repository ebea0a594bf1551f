//! Emulated devices through the whole chain: emulator in a process of its own, wire, link, servo thread, scene, recorder.
//!
//! | file | answers |
//! |---|---|
//! | [`faults`] | what becomes of force and recording when something fails in the middle of a press |
//! | [`turning`] | how far the loop is off the truth, and what gets lost |

pub mod faults;
mod judge;
mod press;
mod program;
pub mod turning;

pub use faults::DeviceFaults;
pub use turning::DeviceLoop;

use std::path::PathBuf;
use std::sync::OnceLock;

/// Name of the hidden subcommand that is the program which a device fails under: it calls [`press_stdin`].
pub const SUBCOMMAND: &str = "press-device";

pub use program::press_stdin;

static PROGRAM: OnceLock<PathBuf> = OnceLock::new();

/// Says which program has the subcommands that are emulated devices and what presses them. Only the first call counts.
pub fn played_by(program: PathBuf) {
    let _ = PROGRAM.set(program);
}

/// The program that can be an emulated device; where there is none, `report` says so and `watch` hears of it.
fn program(
    report: &mut crate::lab::Report,
    watch: &mut crate::lab::Watch<'_>,
) -> Result<Option<&'static PathBuf>, crate::lab::LabError> {
    let program = PROGRAM.get();
    if program.is_none() {
        for quarter in 0..4 {
            watch.at("nothing to press", f64::from(quarter) / 4.0)?;
        }
        report.verdicts.push(crate::lab::Verdict::told(
            "emulated devices",
            "none",
            "the program itself, which can be one",
            false,
        ));
        report.note("Nothing was tried: only the program itself can be an emulated device.");
    }
    Ok(program)
}

fn input(error: impl std::fmt::Display) -> crate::lab::LabError {
    crate::lab::LabError::Input(error.to_string())
}
