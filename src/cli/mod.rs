//! The command line: one file per subcommand.
//!
//! Exit codes: 0 done, 1 the thing checked does not hold, 2 bad usage or bad input. Errors are one line on stderr that
//! names the cause and the remedy. With `--json` one JSON document stands on stdout and nothing else.

use clap::{Parser, Subcommand};
use std::fmt;

/// How a subcommand ended when nothing was wrong with its input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Exit code 0.
    Done,
    /// The thing checked does not hold: exit code 1.
    DoesNotHold,
}

/// Bad usage or bad input: one line, exit code 2.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CliError(String);

impl CliError {
    /// An error whose message is `message`; line breaks become spaces, so that it stays one line.
    pub fn input(message: impl fmt::Display) -> Self {
        let message = message.to_string();
        Self(message.split_whitespace().collect::<Vec<_>>().join(" "))
    }
}

impl fmt::Display for CliError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Palpate a virtual back, record, replay, compare. Without a subcommand: opens the workbench.
#[derive(Debug, Parser)]
#[command(name = "dorsum", version, about, max_term_width = 110)]
struct Arguments {
    /// Print one JSON document on stdout and nothing else.
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {}

/// Prints `value` as one JSON document on stdout.
///
/// # Errors
/// Stdout is closed.
pub fn print_json(value: &impl serde::Serialize) -> Result<(), CliError> {
    let text = serde_json::to_string_pretty(value).map_err(CliError::input)?;
    println!("{text}");
    Ok(())
}

/// Runs the program with the process's arguments and returns its exit code.
pub fn main() -> u8 {
    let arguments = Arguments::parse();
    let outcome: Result<Outcome, CliError> = match arguments.command {
        None => Ok(Outcome::Done),
        Some(command) => match command {},
    };
    match outcome {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::DoesNotHold) => 1,
        Err(error) => {
            eprintln!("dorsum: {error}");
            2
        }
    }
}
