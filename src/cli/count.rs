//! The hidden subcommand that the lab starts itself with, to count what a scene holds and does.

use super::{CliError, Outcome, print};
use crate::lab::pruning;
use std::io::Read as _;

/// Lets the lab start this program to count.
pub fn offer() {
    if let Ok(program) = std::env::current_exe() {
        pruning::counted_by(program);
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
