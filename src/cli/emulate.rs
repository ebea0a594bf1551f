//! The hidden subcommand that is an emulated device: `dorsum devices --emulator` and tests start it.

use super::{CliError, Outcome};

/// What is emulated: family, seconds, depth of the press in mm, delay in ms and, if wanted, a fault.
#[derive(Debug, clap::Args)]
pub struct EmulateArgs {
    #[arg(allow_negative_numbers = true)]
    words: Vec<String>,
}

/// Serves the socket on standard input and prints what it came to.
///
/// # Errors
/// The words are wrong, or there is no socket.
#[cfg(target_os = "linux")]
pub fn run(args: &EmulateArgs) -> Result<Outcome, CliError> {
    use crate::device::hid::emulator::process::serve_stdin;
    super::print(serve_stdin(&args.words).map_err(CliError::input)?);
    Ok(Outcome::Done)
}

/// There is no such socket here.
///
/// # Errors
/// Always.
#[cfg(not(target_os = "linux"))]
pub fn run(args: &EmulateArgs) -> Result<Outcome, CliError> {
    Err(CliError::input(format_args!(
        "{}: emulated devices need Linux",
        args.words.join(" ")
    )))
}
