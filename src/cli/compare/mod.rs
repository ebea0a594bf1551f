//! `dorsum compare`: what recordings tell beside each other: measures, differences over time, agreement, groups.

mod groups;
mod tell;

use super::common::progress_bar;
use super::{CliError, Outcome, print_json};
use crate::figure;
use crate::session::Session;
use crate::study::compare::{Align, Anchor, CompareOptions, Comparison, Trace, compare, traces};
use crate::study::groups::{Grouped, Row, grouped};
use crate::study::report::{self, MOST_DRAWN, Outline, Report};
use crate::study::{Analysis, Dwell, Options, StudyError, analyse, cohort, tables};
use crate::table::Table;
use std::cell::Cell;
use std::path::{Path, PathBuf};

/// Which recordings, and how they are compared.
#[derive(Debug, clap::Args)]
pub struct CompareArgs {
    /// Recordings. Each further one is compared with the first; with groups only their measures are.
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// What of the one goes with what of the other.
    #[arg(long, value_enum, default_value_t = AlignBy::Time)]
    align: AlignBy,
    /// The event to align by: contact, press:N, or KIND:N of an event such as mark:2.
    #[arg(long, value_name = "EVENT", value_parser = Anchor::parse)]
    event: Option<Anchor>,
    /// Which finger is aligned, from 0.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..4))]
    finger: u8,
    /// A group: recordings whose path, or file name, fits the pattern of * and ?. Twice or more.
    #[arg(long = "group", value_name = "NAME=PATTERN", value_parser = groups::parse_group)]
    groups: Vec<(String, String)>,
    /// Groups from a table with the columns file and group.
    #[arg(long = "groups", value_name = "FILE.csv", conflicts_with = "groups")]
    groups_file: Option<PathBuf>,
    /// Write one page that needs nothing beside itself.
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,
    /// Write the tables as Parquet: measures, comparisons, series, groups.
    #[arg(long, value_name = "DIR")]
    parquet: Option<PathBuf>,
    /// Write the tables as CSV.
    #[arg(long, value_name = "DIR")]
    csv: Option<PathBuf>,
}

/// What of one recording goes with what of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum AlignBy {
    /// By time from the first tick.
    Time,
    /// By an event; the first contact unless --event says another.
    Event,
    /// By dynamic time warping.
    Dtw,
}

#[derive(serde::Serialize)]
struct Printed<'a> {
    sessions: &'a [Row],
    comparisons: &'a [Comparison],
    groups: &'a [Grouped],
    written: &'a [PathBuf],
}

/// Compares, prints, and writes what is asked for.
///
/// # Errors
/// A recording cannot be read or stays sealed, cannot be aligned, a group is empty, or a file cannot be written.
pub fn run(args: &CompareArgs, json: bool) -> Result<Outcome, CliError> {
    let align = match (args.align, &args.event) {
        (AlignBy::Time, None) => Align::Time,
        (AlignBy::Dtw, None) => Align::Dtw,
        (AlignBy::Event, event) => Align::Event(event.clone().unwrap_or_default()),
        (_, Some(_)) => return Err(CliError::input("--event goes with --align event")),
    };
    let options = CompareOptions {
        align,
        finger: args.finger,
        ..CompareOptions::default()
    };
    let group_of = groups::groups(args)?;
    let bar = progress_bar(1000, "comparing    {bar:40} {percent:>3} %  {eta}");
    let mut tell = |done: f64| {
        bar.set_position((1000.0 * done) as u64);
        true
    };
    let mut report = match group_of.iter().any(Option::is_some) {
        true => in_groups(args, &group_of, &mut tell)?,
        false => beside_the_first(args, &options, &mut tell)?,
    };
    bar.finish_and_clear();
    if args.report.is_some() {
        let mut drawn = args
            .files
            .iter()
            .take(MOST_DRAWN)
            .flat_map(|f| Session::open(f));
        report.outline = drawn.find_map(|s| Outline::of(&s));
    }
    report.groups = by_twos(&report.rows);
    let written = write(args, &report)?;
    if json {
        print_json(&Printed {
            sessions: &report.rows,
            comparisons: &report.comparisons,
            groups: &report.groups,
            written: &written,
        })?;
    } else {
        tell::tell_all(&report, &written);
    }
    Ok(Outcome::Done)
}

/// The measures of every recording in its group: many at once, in memory that grows by the measures alone.
fn in_groups(
    args: &CompareArgs,
    group_of: &[Option<String>],
    tell: &mut dyn FnMut(f64) -> bool,
) -> Result<Report, CliError> {
    let mut report = Report::default();
    let mut failed = None;
    let each = &mut |i: usize, result: Result<Analysis, StudyError>| match result {
        Ok(analysis) => {
            let group = group_of.get(i).cloned().flatten();
            report.rows.push(Row::of(&analysis, group));
            if i < MOST_DRAWN {
                report.dwell.push(analysis.dwell);
            }
        }
        Err(e) => failed = failed.take().or(Some(e)),
    };
    cohort::run(
        &args.files,
        cohort::default_jobs(),
        &Options::default(),
        tell,
        each,
    )
    .map_err(CliError::input)?;
    if let Some(e) = failed {
        return Err(CliError::input(e));
    }
    Ok(report)
}

/// What one recording comes to, alone and beside the first.
struct One {
    row: Row,
    dwell: Option<Dwell>,
    trace: Option<Trace>,
    comparison: Option<Comparison>,
}

/// The measures of every recording, and each further one beside the first: many at once. What is held of each is its row,
/// its differences over time, and of the few that are drawn map and trace.
fn beside_the_first(
    args: &CompareArgs,
    options: &CompareOptions,
    tell: &mut dyn FnMut(f64) -> bool,
) -> Result<Report, CliError> {
    let Some((first, others)) = args.files.split_first() else {
        return Ok(Report::default());
    };
    let share = 1.0 / args.files.len() as f64;
    let session = Session::open(first).map_err(CliError::input)?;
    let told = analyse(&session, &Options::default(), &mut |done| {
        tell(share * done)
    })
    .map_err(CliError::input)?;
    let one =
        |i: usize, session: &Session, told: &Analysis, comparison| -> Result<One, StudyError> {
            let is_drawn = i < MOST_DRAWN && args.report.is_some();
            let trace = if is_drawn && !others.is_empty() {
                let mut all = traces(session, told.about.ticks, &mut |_| true)?;
                let finger = usize::from(args.finger);
                (finger < all.len()).then(|| all.swap_remove(finger))
            } else {
                None
            };
            Ok(One {
                row: Row::of(told, None),
                dwell: is_drawn.then(|| told.dwell.clone()),
                trace,
                comparison,
            })
        };
    let mut report = Report::default();
    take(
        &mut report,
        one(0, &session, &told, None).map_err(CliError::input)?,
    );
    let work = |i: usize, path: &Path, done: &mut dyn FnMut(f64) -> bool| {
        let other = Session::open(path)?;
        // Half of the time goes to the analysis, the rest to what is beside the first.
        let its = analyse(&other, &Options::default(), &mut |s| done(0.5 * s))?;
        let between = compare([&session, &other], [&told, &its], options, &mut |s| {
            done(0.5 + 0.5 * s)
        })?;
        one(i + 1, &other, &its, Some(between))
    };
    let failed: Cell<Option<StudyError>> = Cell::new(None);
    let has_failed = Cell::new(false);
    let ran = cohort::map(
        others,
        cohort::default_jobs(),
        &work,
        &mut |done| !has_failed.get() && tell(share + (1.0 - share) * done),
        &mut |_, result: Result<One, StudyError>| match result {
            Ok(one) => take(&mut report, one),
            Err(e) => {
                has_failed.set(true);
                failed.set(failed.take().or(Some(e)));
            }
        },
    );
    match failed.into_inner() {
        Some(e) => Err(CliError::input(e)),
        None => ran.map(|()| report).map_err(CliError::input),
    }
}

fn take(report: &mut Report, one: One) {
    report.rows.push(one.row);
    report.dwell.extend(one.dwell);
    report.traces.extend(one.trace);
    report.comparisons.extend(one.comparison);
}

/// Every two groups, in the order they come in.
fn by_twos(rows: &[Row]) -> Vec<Grouped> {
    let mut names: Vec<&str> = Vec::new();
    for name in rows.iter().filter_map(|r| r.group.as_deref()) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let pairs = names
        .iter()
        .enumerate()
        .flat_map(|(i, a)| names[i + 1..].iter().map(move |b| (*a, *b)));
    pairs.map(|(a, b)| grouped(rows, a, b)).collect()
}

/// Writes what is asked for: all beside their places first, then renamed.
fn write(args: &CompareArgs, report: &Report) -> Result<Vec<PathBuf>, CliError> {
    let mut files: Vec<(PathBuf, Vec<u8>)> = Vec::new();
    if let Some(path) = &args.report {
        files.push((
            path.clone(),
            report::page(report).map_err(CliError::input)?.into_bytes(),
        ));
    }
    let mut all: Vec<(&str, Table<'_>)> = vec![("measures", tables::measures(&report.rows))];
    if !report.comparisons.is_empty() {
        all.push(("comparisons", tables::comparisons(&report.comparisons)));
        all.push(("series", tables::series(&report.comparisons)));
    }
    if !report.groups.is_empty() {
        all.push(("groups", tables::groups(&report.groups)));
    }
    let made = |e: std::io::Error| CliError::input(StudyError::Output(e.to_string()));
    for (name, table) in &all {
        if let Some(folder) = &args.csv {
            files.push((
                folder.join(format!("{name}.csv")),
                table.csv().map_err(made)?,
            ));
        }
        if let Some(folder) = &args.parquet {
            files.push((
                folder.join(format!("{name}.parquet")),
                table.parquet().map_err(made)?,
            ));
        }
    }
    for folder in [&args.csv, &args.parquet].into_iter().flatten() {
        let failed = |e| CliError::input(format_args!("{}: {e}", folder.display()));
        std::fs::create_dir_all(folder).map_err(failed)?;
    }
    let named = || {
        files
            .iter()
            .map(|f| f.0.display().to_string())
            .collect::<Vec<_>>()
            .join(", ")
    };
    figure::write_files(&files)
        .map_err(|e| CliError::input(format_args!("{}: cannot be written: {e}", named())))?;
    Ok(files.into_iter().map(|(path, _)| path).collect())
}
