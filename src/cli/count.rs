//! The hidden subcommands that the lab starts itself with: to count what a scene holds and does, and to be killed.

use super::{CliError, Outcome, print};
use crate::lab::{pruning, session};
use std::io::Read as _;
use std::path::PathBuf;

/// Lets the lab start this program.
pub fn offer() {
    if let Ok(program) = std::env::current_exe() {
        pruning::counted_by(program.clone());
        #[cfg(target_os = "linux")]
        crate::lab::devices::played_by(program.clone());
        session::damage::killed_in(program);
    }
}

/// Runs the case on stdin and prints what it counted.
///
/// # Errors
/// There is no case on stdin.
pub fn run() -> Result<Outcome, CliError> {
    let mut text = String::new();
    std::io::stdin()
        .read_to_string(&mut text)
        .map_err(CliError::input)?;
    print(pruning::serve(&text).map_err(CliError::input)?);
    Ok(Outcome::Done)
}

/// The file that is recorded until the recorder is killed.
#[derive(Debug, clap::Args)]
pub struct KilledArgs {
    file: PathBuf,
}

/// Records until it is killed.
///
/// # Errors
/// The recorder cannot be started.
pub fn record(args: &KilledArgs) -> Result<Outcome, CliError> {
    session::damage::record_until_killed(&args.file).map_err(CliError::input)?;
    Ok(Outcome::Done)
}

/// What is pressed, as JSON.
#[derive(Debug, clap::Args)]
pub struct PressArgs {
    order: String,
}

/// Presses the emulated device on standard input.
///
/// # Errors
/// The order is wrong, or something that the press needs is refused.
#[cfg(target_os = "linux")]
pub fn press(args: &PressArgs) -> Result<Outcome, CliError> {
    crate::lab::devices::press_stdin(&args.order).map_err(CliError::input)?;
    Ok(Outcome::Done)
}

/// There are no emulated devices here.
///
/// # Errors
/// Always.
#[cfg(not(target_os = "linux"))]
pub fn press(args: &PressArgs) -> Result<Outcome, CliError> {
    let order = &args.order;
    Err(CliError::input(format!(
        "{order}: emulated devices need Linux"
    )))
}
