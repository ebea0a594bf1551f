//! `dorsum lab`: experiments, their tables, plots and verdicts.

use super::common::{load_mesh, load_scenario, progress_bar};
use super::{CliError, Outcome, print, print_json};
use crate::lab::{self, Choice, Document, Experiment, Mesh, Scene, Setup, Shelf, Watch};
use crate::session::{Session, utc_now};
use crate::surface::back;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Which experiment, on what, and where its results go.
#[derive(Debug, clap::Args)]
pub struct LabArgs {
    /// Experiment, or a group of them such as partition; list names all there are.
    name: String,
    /// Folder for the results: a report as HTML, tables as CSV, figures as SVG, everything as JSON and as text. Made where
    /// it is missing.
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
    /// Scenario file or the name of an example: the scene to work in.
    #[arg(long, value_name = "FILE")]
    scenario: Option<String>,
    /// Recorded session (.mcap) to work on.
    #[arg(long, value_name = "FILE")]
    session: Option<PathBuf>,
    /// Where chance starts: the same number gives the same. Without: 0.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// How long to work in real time, s. Without: the experiment's own time.
    #[arg(long, value_name = "S", value_parser = seconds)]
    seconds: Option<f64>,
    /// Folder that keeps finished parts, so that a stopped run goes on. Without: the user's cache folder.
    #[arg(long, value_name = "DIR", conflicts_with = "no_cache")]
    cache: Option<PathBuf>,
    /// Measure anew: throw away what was kept of this experiment under this setup.
    #[arg(long, conflicts_with = "no_cache")]
    fresh: bool,
    /// Keep nothing, and use nothing that was kept.
    #[arg(long)]
    no_cache: bool,
}

fn triangles(text: &str) -> Result<usize, String> {
    let allowed = back::FEWEST..=back::MOST;
    text.trim()
        .parse()
        .ok()
        .filter(|n| allowed.contains(n))
        .ok_or_else(|| format!("{} to {} triangles are allowed", back::FEWEST, back::MOST))
}

fn seconds(text: &str) -> Result<f64, String> {
    let allowed = lab::SECONDS;
    text.trim()
        .parse()
        .ok()
        .filter(|s| allowed.contains(s))
        .ok_or_else(|| format!("{} to {} s are allowed", allowed.start(), allowed.end()))
}

/// Runs `dorsum lab`.
///
/// # Errors
/// Unknown name, an option that does not go with the experiment, a mesh, scenario or session that is refused, a folder that
/// cannot be written.
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
    let started = utc_now();
    let document = work(&chosen, &setup)?;
    if let Some(trouble) = setup.shelf.trouble() {
        eprintln!("dorsum: {trouble}");
    }
    let files = match &args.out {
        Some(folder) => {
            lab::write(&document, &args.name, folder).map_err(|e| in_folder(folder, e))?
        }
        None => Vec::new(),
    };
    if json {
        print_json(&document)?;
    } else {
        show(&document, &started, &files);
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
    takes_scenario: bool,
    takes_session: bool,
    takes_seed: bool,
    takes_seconds: bool,
}

fn list(json: bool) -> Result<Outcome, CliError> {
    let listed: Vec<Listed> = lab::all()
        .iter()
        .map(|e| {
            let takes = |choice| e.takes().contains(&choice);
            Listed {
                name: e.name(),
                group: lab::group_of(e.name()),
                about: e.about(),
                takes_mesh: takes(Choice::Mesh),
                takes_triangles: takes(Choice::Triangles),
                takes_scenario: takes(Choice::Scene),
                takes_session: takes(Choice::Session),
                takes_seed: takes(Choice::Seed),
                takes_seconds: takes(Choice::Seconds),
            }
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
        ("--scenario", args.scenario.is_some(), Choice::Scene),
        ("--session", args.session.is_some(), Choice::Session),
        ("--seed", args.seed.is_some(), Choice::Seed),
        ("--seconds", args.seconds.is_some(), Choice::Seconds),
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
                if takers.is_empty() {
                    "no experiment yet".to_owned()
                } else {
                    takers.join(", ")
                }
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
    let scene = match &args.scenario {
        Some(name) => Some(Scene {
            name: name.clone(),
            scenario: Arc::new(load_scenario(name)?),
        }),
        None => None,
    };
    if let Some(path) = &args.session {
        Session::open(path).map_err(CliError::input)?;
    }
    Ok(Setup {
        quick: args.quick,
        mesh,
        triangles: args.triangles.clone(),
        scene,
        session: args.session.clone(),
        seed: args.seed.unwrap_or_default(),
        seconds: args.seconds,
        shelf: shelf(args),
    })
}

/// Where finished parts are kept.
fn shelf(args: &LabArgs) -> Shelf {
    let folder = args.cache.clone().or_else(Shelf::usual_folder);
    match folder.filter(|_| !args.no_cache) {
        Some(folder) if args.fresh => Shelf::open(folder).anew(),
        Some(folder) => Shelf::open(folder),
        None => Shelf::default(),
    }
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

/// `started`, UTC, tells what was made now from what was kept.
fn show(document: &Document, started: &str, files: &[PathBuf]) {
    print(document.origin());
    for report in &document.experiments {
        print(format_args!("\n{report}"));
        if *report.measured < *started {
            print(format_args!(
                "Kept since {}: --fresh measures anew",
                report.measured
            ));
        }
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
        let slow = Document::new(&Setup::default(), vec![report.clone()]);
        assert_eq!(outcome(&slow), Outcome::Done);
        report
            .verdicts
            .push(Verdict::must("whole", "1 lost", "0", false));
        let wrong = Document::new(&Setup::default(), vec![report]);
        assert_eq!(outcome(&wrong), Outcome::DoesNotHold);
    }
}
