//! `dorsum export`: hands sessions on as Parquet, CSV or BIDS-Motion.

use super::common::{bytes_text, progress_bar};
use super::{CliError, Outcome, print, print_json};
use crate::session::Damage;
use crate::study::export::{self, Exported, Format, Settings};
use crate::study::{Options, StudyError, cohort};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Which sessions, and how they are handed on.
#[derive(Debug, clap::Args)]
#[command(group(clap::ArgGroup::new("to").required(true)))]
pub struct ExportArgs {
    /// Sessions, or folders that are looked through for them. None: only rounds off what the folder holds.
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Tables as Parquet, a folder for each participant and session: ticks, events, felt, measures, sessions.
    #[arg(long, value_name = "DIR", group = "to")]
    parquet: Option<PathBuf>,
    /// The same tables as CSV.
    #[arg(long, value_name = "DIR", group = "to")]
    csv: Option<PathBuf>,
    /// A BIDS-Motion dataset.
    #[arg(long, value_name = "DIR", group = "to")]
    bids: Option<PathBuf>,
    /// Sessions at once; as many as there are processors without it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Replace what is there; without it a session that is there is skipped.
    #[arg(long)]
    force: bool,
    /// Write nothing but the sessions' own files, as one of many processes. Run once more without FILE at the end.
    #[arg(long, requires = "files")]
    part: bool,
}

#[derive(serde::Serialize)]
struct Printed<'a> {
    folder: &'a Path,
    format: Format,
    exported: usize,
    skipped: usize,
    sealed: usize,
    damaged: usize,
    failed: usize,
    rows: u64,
    bytes: u64,
    seconds: f64,
    sessions: Vec<Told<'a>>,
}

#[derive(serde::Serialize)]
struct Told<'a> {
    file: &'a Path,
    #[serde(flatten)]
    exported: Option<Exported>,
    sealed: bool,
    error: Option<String>,
}

/// Hands sessions on.
///
/// # Errors
/// Nothing to hand on, a file that cannot be read, or a folder that cannot be written. The other sessions are handed on
/// before that is told.
pub fn run(args: &ExportArgs, json: bool) -> Result<Outcome, CliError> {
    let began = Instant::now();
    let (format, folder) = match (&args.parquet, &args.csv, &args.bids) {
        (Some(folder), _, _) => (Format::Parquet, folder),
        (_, Some(folder), _) => (Format::Csv, folder),
        (_, _, Some(folder)) => (Format::Bids, folder),
        _ => return Err(CliError::input("give --parquet, --csv or --bids")),
    };
    let settings = Settings {
        format,
        folder: folder.clone(),
        force: args.force,
        options: Options::default(),
    };
    let files = found(&args.files)?;
    if files.is_empty() && !folder.is_dir() {
        let folder = folder.display();
        return Err(CliError::input(format_args!(
            "{folder} holds nothing yet; give sessions to hand on"
        )));
    }
    let made = std::fs::create_dir_all(folder);
    made.map_err(|e| CliError::input(format_args!("{}: {e}", folder.display())))?;
    let jobs = args.jobs.map_or_else(cohort::default_jobs, usize::from);
    let results = hand_on(&files, jobs, &settings)?;
    if !args.part {
        export::finish(&settings).map_err(CliError::input)?;
    }
    let mut printed = Printed {
        folder,
        format,
        exported: 0,
        skipped: 0,
        sealed: 0,
        damaged: 0,
        failed: 0,
        rows: 0,
        bytes: 0,
        seconds: 0.0,
        sessions: Vec::new(),
    };
    for (file, result) in files.iter().zip(results) {
        printed.add(file, result);
    }
    printed.seconds = began.elapsed().as_secs_f64();
    // A single session that is refused is bad input; among others it is counted.
    if let [only] = &printed.sessions[..]
        && let Some(error) = &only.error
    {
        return Err(CliError::input(error));
    }
    if json {
        print_json(&printed)?;
    } else {
        printed.tell();
    }
    match printed.failure() {
        None => Ok(Outcome::Done),
        Some(error) => Err(CliError::input(error)),
    }
}

/// The sessions that `given` names: files as they are, folders for those below them.
fn found(given: &[PathBuf]) -> Result<Vec<PathBuf>, CliError> {
    let mut files = Vec::new();
    for path in given {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let told = |e| CliError::input(format_args!("{}: {e}", path.display()));
        let below = crate::study::index::recordings(path).map_err(told)?;
        if below.is_empty() {
            let path = path.display();
            return Err(CliError::input(format_args!(
                "{path} holds no sessions (.mcap)"
            )));
        }
        files.extend(below.iter().map(|name| path.join(name)));
    }
    Ok(files)
}

type Results = Vec<Result<Exported, StudyError>>;

fn hand_on(files: &[PathBuf], jobs: usize, settings: &Settings) -> Result<Results, CliError> {
    let bar = progress_bar(1000, "{msg:22} {bar:40} {percent:>3} %  {eta}");
    let mut results = Results::new();
    let ended = {
        let n = files.len();
        bar.set_message(format!("0 of {n} sessions"));
        export::cohort(
            files,
            jobs,
            settings,
            &mut |share| {
                bar.set_position((share * 1000.0) as u64);
                true
            },
            &mut |i, result| {
                bar.set_message(format!("{} of {n} sessions", i + 1));
                results.push(result);
            },
        )
    };
    bar.finish_and_clear();
    ended.map_err(CliError::input)?;
    Ok(results)
}

impl<'a> Printed<'a> {
    fn add(&mut self, file: &'a Path, result: Result<Exported, StudyError>) {
        let mut told = Told {
            file,
            exported: None,
            sealed: false,
            error: None,
        };
        match result {
            Ok(exported) => {
                self.skipped += usize::from(exported.skipped);
                self.exported += usize::from(!exported.skipped);
                self.damaged += usize::from(!exported.damage.is_none());
                self.rows += exported.rows;
                self.bytes += exported.bytes;
                told.exported = Some(exported);
            }
            Err(error) => {
                told.sealed = matches!(error, StudyError::Sealed { .. });
                self.sealed += usize::from(told.sealed);
                self.failed += usize::from(!told.sealed);
                told.error = Some(error.to_string());
            }
        }
        self.sessions.push(told);
    }

    fn tell(&self) {
        let (folder, rows, seconds) = (self.folder.display(), self.rows, self.seconds);
        let bytes = bytes_text(usize::try_from(self.bytes).unwrap_or(usize::MAX));
        let exported = self.exported;
        print(format_args!(
            "exported      {exported:>8} sessions, {rows} rows, {bytes} in {seconds:.1} s, to {folder}"
        ));
        let counts = [
            (
                "skipped",
                self.skipped,
                "are there already; --force replaces them",
            ),
            (
                "sealed",
                self.sealed,
                "trials that were not answered; nothing of them is told",
            ),
            (
                "damaged",
                self.damaged,
                "handed on as far as they can be read",
            ),
            ("failed", self.failed, "not handed on"),
        ];
        for (name, n, what) in counts {
            if n > 0 {
                print(format_args!("{name:<13} {n:>8} {what}"));
            }
        }
        for told in &self.sessions {
            let Some(exported) = &told.exported else {
                continue;
            };
            let (file, damage) = (told.file.display(), &exported.damage);
            if !damage.is_none() {
                print(format_args!("  {file}: {}", damage_text(damage)));
            }
            if exported.left_out > 0 {
                let n = exported.left_out;
                print(format_args!("  {file}: {n} finger ticks left out"));
            }
        }
    }

    /// What is wrong with files that are not sealed, in one line.
    fn failure(&self) -> Option<String> {
        let is = |told: &&Told<'_>| !told.sealed && told.error.is_some();
        let mut wrong = self.sessions.iter().filter(is);
        let first = wrong.next()?.error.as_deref().unwrap_or_default();
        let (n, of) = (self.failed, self.sessions.len());
        let more = match n {
            1 => String::new(),
            _ => format!(" (and {} more: --json names them)", n - 1),
        };
        Some(format!(
            "{n} of {of} sessions were not handed on; {first}{more}"
        ))
    }
}

fn damage_text(damage: &Damage) -> String {
    let mut parts = Vec::new();
    if damage.unfinished {
        parts.push("no proper end".to_owned());
    }
    let counts = [
        (damage.chunks, "chunks"),
        (damage.messages, "messages"),
        (damage.bytes, "bytes"),
    ];
    for (n, what) in counts {
        if n > 0 {
            parts.push(format!("{n} {what} not readable"));
        }
    }
    parts.join(", ")
}
