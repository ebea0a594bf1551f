//! The hidden subcommand that is an emulated device: `dorsum devices --emulator` and tests start it.

use super::{CliError, Outcome};

/// What is emulated, as JSON.
#[derive(Debug, clap::Args)]
pub struct EmulateArgs {
    request: String,
}

/// Serves the wire on standard input and prints what it came to.
///
/// # Errors
/// The request is wrong, or there is no wire.
#[cfg(target_os = "linux")]
pub fn run(args: &EmulateArgs) -> Result<Outcome, CliError> {
    use crate::device::hid::emulator::process::serve_stdin;
    super::print(serve_stdin(&args.request).map_err(CliError::input)?);
    Ok(Outcome::Done)
}

/// There is no such wire here.
///
/// # Errors
/// Always.
#[cfg(not(target_os = "linux"))]
pub fn run(args: &EmulateArgs) -> Result<Outcome, CliError> {
    Err(CliError::input(format_args!(
        "{}: emulated devices need Linux",
        args.request
    )))
}
