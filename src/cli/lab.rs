//! `dorsum lab`: experiments, their tables, plots and verdicts.

use super::common::{load_mesh, progress_bar};
use super::{CliError, Outcome, print, print_json};
use crate::lab::{self, Choice, Document, Experiment, Mesh, Setup, Watch};
use crate::surface::back;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Which experiment, on what, and where its results go.
#[derive(Debug, clap::Args)]
pub struct LabArgs {
    /// Experiment, or a group of them such as partition; list names all there are.
    name: String,
    /// Folder for the results: tables as CSV, plots as SVG, everything as JSON and as text. Made where it is missing.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// A look in seconds: fewer repetitions, smaller sizes.
    #[arg(long)]
    quick: bool,
    /// Mesh file, or back, or back:N for the built-in one with N triangles. Without: what the experiment's print used.
    #[arg(long, value_name = "FILE")]
    mesh: Option<String>,
    /// Sizes of the built-in back for experiments that go through several, triangles.
    #[arg(long, value_name = "N,N", value_delimiter = ',', value_parser = triangles)]
    triangles: Vec<usize>,
}

fn triangles(text: &str) -> Result<usize, String> {
    let allowed = back::FEWEST..=back::MOST;
    text.trim()
        .parse()
        .ok()
        .filter(|n| allowed.contains(n))
        .ok_or_else(|| format!("{} to {} triangles are allowed", back::FEWEST, back::MOST))
}

/// Runs `dorsum lab`.
///
/// # Errors
/// Unknown name, an option that does not go with the experiment, a mesh that is refused, a folder that cannot be written.
pub fn run(args: &LabArgs, json: bool) -> Result<Outcome, CliError> {
    if args.name == "list" {
        return list(json);
    }
    let chosen = lab::select(&args.name);
    if chosen.is_empty() {
        let names: Vec<_> = lab::all().iter().map(|e| e.name()).collect();
        return Err(CliError::input(format_args!(
            "no experiment is called \"{}\"; there are {}, and {} for all of a kind",
            args.name,
            names.join(", "),
            groups().join(", ")
        )));
    }
    let setup = setup(args, &chosen)?;
    if let Some(folder) = &args.out {
        // Before minutes of work, not after.
        writable(folder).map_err(|e| in_folder(folder, e))?;
    }
    let document = work(&chosen, &setup)?;
    let files = match &args.out {
        Some(folder) => {
            lab::write(&document, &args.name, folder).map_err(|e| in_folder(folder, e))?
        }
        None => Vec::new(),
    };
    if json {
        print_json(&document)?;
    } else {
        show(&document, &files);
    }
    Ok(outcome(&document))
}

/// A time that misses its goal is told; only what must hold decides.
fn outcome(document: &Document) -> Outcome {
    if document.holds {
        Outcome::Done
    } else {
        Outcome::DoesNotHold
    }
}

#[derive(Serialize)]
struct Listed {
    name: &'static str,
    group: &'static str,
    about: &'static str,
    takes_mesh: bool,
    takes_triangles: bool,
}

fn list(json: bool) -> Result<Outcome, CliError> {
    let listed: Vec<Listed> = lab::all()
        .iter()
        .map(|e| Listed {
            name: e.name(),
            group: lab::group_of(e.name()),
            about: e.about(),
            takes_mesh: e.takes().contains(&Choice::Mesh),
            takes_triangles: e.takes().contains(&Choice::Triangles),
        })
        .collect();
    if json {
        print_json(&listed)?;
        return Ok(Outcome::Done);
    }
    let width = listed.iter().map(|l| l.name.len()).max().unwrap_or(0);
    for l in &listed {
        print(format_args!("{:<width$}  {}", l.name, l.about));
    }
    for group in groups() {
        print(format_args!("{group:<width$}  All whose name begins so"));
    }
    Ok(Outcome::Done)
}

/// The groups of more than one experiment.
fn groups() -> Vec<&'static str> {
    let mut groups: Vec<_> = lab::all().iter().map(|e| lab::group_of(e.name())).collect();
    groups.dedup();
    groups.retain(|g| lab::all().iter().all(|e| e.name() != *g));
    groups
}

/// The setup, once every option has someone who takes it.
fn setup(args: &LabArgs, chosen: &[&dyn Experiment]) -> Result<Setup, CliError> {
    for (option, given, choice) in [
        ("--mesh", args.mesh.is_some(), Choice::Mesh),
        ("--triangles", !args.triangles.is_empty(), Choice::Triangles),
    ] {
        if given && !chosen.iter().any(|e| e.takes().contains(&choice)) {
            let takers: Vec<_> = lab::all()
                .iter()
                .filter(|e| e.takes().contains(&choice))
                .map(|e| e.name())
                .collect();
            return Err(CliError::input(format_args!(
                "{option}: {} takes none; it goes with {}",
                args.name,
                takers.join(", ")
            )));
        }
    }
    let mesh = match &args.mesh {
        Some(name) => Some(Mesh {
            name: name.clone(),
            surface: Arc::new(load_mesh(name)?),
        }),
        None => None,
    };
    Ok(Setup {
        quick: args.quick,
        mesh,
        triangles: args.triangles.clone(),
        ..Setup::default()
    })
}

/// Makes the folder and a file in it that goes away again.
fn writable(folder: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    tempfile::tempfile_in(folder).map(drop)
}

fn in_folder(folder: &Path, error: std::io::Error) -> CliError {
    CliError::input(format_args!("{}: {error}", folder.display()))
}

/// Runs the experiments, with a progress bar on a terminal.
fn work(chosen: &[&dyn Experiment], setup: &Setup) -> Result<Document, CliError> {
    let bar = progress_bar(1000, "{msg:44} {bar:30} {percent:>3} %");
    let mut tell = |what: &str, share: f64| {
        bar.set_message(what.to_owned());
        bar.set_position((share * 1000.0) as u64);
        true
    };
    let document = lab::run(chosen, setup, &mut Watch::new(&mut tell));
    bar.finish_and_clear();
    document.map_err(CliError::input)
}

fn show(document: &Document, files: &[PathBuf]) {
    print(format_args!("Measured on {}", document.machine));
    for report in &document.experiments {
        print(format_args!("\n{report}"));
    }
    if !files.is_empty() {
        print("\nWritten");
    }
    for file in files {
        print(format_args!("  {}", file.display()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::{Report, Verdict};

    #[test]
    fn a_slow_result_is_done_and_a_wrong_one_does_not_hold() {
        let mut report = Report::default();
        report
            .verdicts
            .push(Verdict::told("fast", "2 µs", "1 µs", false));
        let slow = Document::new(false, vec![report.clone()]);
        assert_eq!(outcome(&slow), Outcome::Done);
        report
            .verdicts
            .push(Verdict::must("whole", "1 lost", "0", false));
        let wrong = Document::new(false, vec![report]);
        assert_eq!(outcome(&wrong), Outcome::DoesNotHold);
    }
}
