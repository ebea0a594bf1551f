//! The command line: one file per subcommand.
//!
//! Exit codes: 0 done, 1 the thing checked does not hold, 2 bad usage or bad input. Errors are one line on stderr that
//! names the cause and the remedy. With `--json` one JSON document stands on stdout and nothing else.

mod attached;
mod common;
mod compare;
mod count;
mod deform;
mod devices;
mod emulate;
mod export;
mod headless;
mod lab;
mod live;
mod map;
mod mesh;
mod otherwise;
mod partition;
mod recover;
mod replay;
mod run;
mod scenario;
mod scene;
mod signals;
mod summary;
mod train;
mod workbench;

use crate::servo::Halt;
use clap::{Parser, Subcommand};
use std::fmt;
use std::io::Write as _;

/// How a subcommand ended when nothing was wrong with its input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Exit code 0.
    Done,
    /// The thing checked does not hold: exit code 1.
    DoesNotHold,
    /// A signal or a panic ended it early: its own exit code.
    Halted(Halt),
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
#[command(
    name = "dorsum",
    version,
    about,
    max_term_width = 110,
    args_conflicts_with_subcommands = true
)]
struct Arguments {
    /// Print one JSON document on stdout and nothing else.
    #[arg(long, global = true)]
    json: bool,
    #[command(flatten)]
    workbench: workbench::WorkbenchArgs,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run the servo loop with a scripted finger, without a window.
    Run(run::RunArgs),
    /// Repeat a recorded session from its device readings and compare.
    Replay(replay::ReplayArgs),
    /// Save what a damaged or unfinished session still holds, and count what it does not; or compress a whole one.
    Recover(recover::RecoverArgs),
    /// Hand sessions on as Parquet, CSV or BIDS-Motion; many at once.
    Export(export::ExportArgs),
    /// Compare recordings: measures, differences over time, agreement, groups, one report.
    Compare(compare::CompareArgs),
    /// Tell what a scenario needs and what is left out, with bytes and µs.
    Scene(scene::SceneArgs),
    /// Check scenarios, list dysfunctions and places, hide dysfunctions at random.
    #[command(subcommand)]
    Scenario(scenario::ScenarioCommand),
    /// Look into mesh files, or write the built-in back.
    #[command(subcommand)]
    Mesh(mesh::MeshCommand),
    /// Tell stiffness and ellipse at points of a scenario's maps; appendix C; the dissertation's worked example.
    Map(map::MapArgs),
    /// Build a search structure over a mesh: statistics, checks, what a haptic detecting box gathers.
    Partition(partition::PartitionArgs),
    /// Press the drawn skin once: what moves, strain, timings, and the deformed mesh as PLY.
    Deform(deform::DeformArgs),
    /// Run an experiment: tables, plots and what holds. "list" tells which there are.
    Lab(lab::LabArgs),
    /// Do an exercise with a simulated observer, write score sheets, fit psychometric functions.
    Train(train::TrainArgs),
    /// Tell which haptic devices are known and attached, what they can do, whether the loop with them holds.
    Devices(devices::DevicesArgs),
    /// Be an emulated device; `devices --emulator` starts it.
    #[command(name = crate::device::hid::emulator::SUBCOMMAND, hide = true)]
    Emulate(emulate::EmulateArgs),
    /// Count one case of `lab pruning`; the lab starts it.
    #[command(name = crate::lab::pruning::SUBCOMMAND, hide = true)]
    Count,
    /// Record until killed, for `lab session-damage`; the lab starts it.
    #[command(name = crate::lab::session::damage::SUBCOMMAND, hide = true)]
    Record(count::KilledArgs),
    /// Press an emulated device, for `lab device-faults`; the lab starts it.
    #[command(name = "press-device", hide = true)]
    Press(count::PressArgs),
}

/// Prints a line, or several, on stdout. Whoever closed the pipe has read enough: that is no error.
pub(crate) fn print(text: impl fmt::Display) {
    let _ = writeln!(std::io::stdout().lock(), "{text}");
}

/// Prints `value` as one JSON document on stdout.
///
/// # Errors
/// A value that JSON cannot hold.
pub fn print_json(value: &impl serde::Serialize) -> Result<(), CliError> {
    print(serde_json::to_string_pretty(value).map_err(CliError::input)?);
    Ok(())
}

/// Runs the program with the process's arguments and returns its exit code.
pub fn main() -> u8 {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(e) if e.use_stderr() => {
            eprintln!("dorsum: {}", usage_line(&e.to_string()));
            return 2;
        }
        Err(help) => {
            print(help.to_string().trim_end());
            return 0;
        }
    };
    let json = arguments.json;
    count::offer();
    match &arguments.command {
        Some(Command::Emulate(_)) => signals::leave_to_parent(),
        // Nothing runs beside what is counted.
        Some(Command::Count) => {}
        _ => signals::heed(),
    }
    let outcome = match &arguments.command {
        None => workbench::run(&arguments.workbench, json),
        Some(Command::Run(args)) => run::run(args, json),
        Some(Command::Replay(args)) => replay::run(args, json),
        Some(Command::Recover(args)) => recover::run(args, json),
        Some(Command::Export(args)) => export::run(args, json),
        Some(Command::Compare(args)) => compare::run(args, json),
        Some(Command::Scene(args)) => scene::run(args, json),
        Some(Command::Scenario(command)) => scenario::run(command, json),
        Some(Command::Mesh(command)) => mesh::run(command, json),
        Some(Command::Map(args)) => map::run(args, json),
        Some(Command::Partition(args)) => partition::run(args, json),
        Some(Command::Deform(args)) => deform::run(args, json),
        Some(Command::Lab(args)) => lab::run(args, json),
        Some(Command::Train(args)) => train::run(args, json),
        Some(Command::Devices(args)) => devices::run(args, json),
        Some(Command::Emulate(args)) => emulate::run(args),
        Some(Command::Count) => count::run(),
        Some(Command::Record(args)) => count::record(args),
        Some(Command::Press(args)) => count::press(args),
    };
    match outcome {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::DoesNotHold) => 1,
        Ok(Outcome::Halted(how)) => how.exit_code(),
        Err(error) => {
            eprintln!("dorsum: {error}");
            2
        }
    }
}

/// The first paragraph of a usage error, in one line.
fn usage_line(error: &str) -> String {
    let first = error
        .split("\n\n")
        .next()
        .unwrap_or_default()
        .trim_start_matches("error: ");
    format!(
        "{}; see --help",
        first.split_whitespace().collect::<Vec<_>>().join(" ")
    )
}
