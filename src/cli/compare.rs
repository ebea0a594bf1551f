//! `dorsum compare`: what recordings tell beside each other: measures, differences over time, agreement, groups.

use super::common::progress_bar;
use super::{CliError, Outcome, print, print_json};
use crate::figure;
use crate::session::Session;
use crate::study::compare::{Align, Anchor, CompareOptions, Comparison, compare, traces};
use crate::study::groups::{Grouped, Row, grouped};
use crate::study::report::{self, MOST_DRAWN, Outline, Report};
use crate::study::stats::Pairing;
use crate::study::{Analysis, METRICS, Options, StudyError, analyse, cohort, tables};
use crate::table::Table;
use std::collections::BTreeMap;
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
    #[arg(long = "group", value_name = "NAME=PATTERN", value_parser = parse_group)]
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
    let group_of = groups(args)?;
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
        tell_all(&report, &written);
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
    match failed {
        Some(e) => return Err(CliError::input(e)),
        None if args.report.is_some() => {
            let first = args.files.iter().take(MOST_DRAWN);
            report.outline = first
                .flat_map(|f| Session::open(f))
                .find_map(|s| Outline::of(&s));
        }
        None => {}
    }
    Ok(report)
}

/// The measures of every recording, and each further one beside the first.
fn beside_the_first(
    args: &CompareArgs,
    options: &CompareOptions,
    tell: &mut dyn FnMut(f64) -> bool,
) -> Result<Report, CliError> {
    let mut report = Report::default();
    let mut first: Option<(Session, Analysis)> = None;
    let n = args.files.len() as f64;
    for (i, file) in args.files.iter().enumerate() {
        let session = Session::open(file).map_err(CliError::input)?;
        // Half of the time goes to the analysis, the rest to what is beside the first.
        let mut at = |done: f64| tell((i as f64 + 0.5 * done) / n);
        let analysis = analyse(&session, &Options::default(), &mut at).map_err(CliError::input)?;
        report.rows.push(Row::of(&analysis, None));
        if i < MOST_DRAWN && args.report.is_some() {
            report.dwell.push(analysis.dwell.clone());
            report.outline = report.outline.or_else(|| Outline::of(&session));
            if args.files.len() > 1 {
                let mut all = traces(&session, analysis.about.ticks, &mut |_| true)
                    .map_err(CliError::input)?;
                let finger = usize::from(args.finger);
                if finger < all.len() {
                    report.traces.push(all.swap_remove(finger));
                }
            }
        }
        match &first {
            None => first = Some((session, analysis)),
            Some((one, told)) => {
                let between = compare([one, &session], [told, &analysis], options, &mut |done| {
                    at(1.0 + done)
                });
                report.comparisons.push(between.map_err(CliError::input)?);
            }
        }
    }
    Ok(report)
}

fn parse_group(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, pattern)) if !name.trim().is_empty() && !pattern.is_empty() => {
            Ok((name.trim().to_owned(), pattern.to_owned()))
        }
        _ => Err(format!(
            "\"{text}\" is no group; NAME=PATTERN is needed, such as novice=N*.mcap"
        )),
    }
}

/// The group of every recording.
fn groups(args: &CompareArgs) -> Result<Vec<Option<String>>, CliError> {
    if let Some(path) = &args.groups_file {
        return from_table(path, &args.files);
    }
    let mut found = vec![None; args.files.len()];
    for (name, pattern) in &args.groups {
        let mut any = false;
        for (file, group) in args.files.iter().zip(&mut found) {
            let file_name = file.file_name().map(|n| n.to_string_lossy().into_owned());
            let fits = fits(pattern, &file.to_string_lossy())
                || file_name.is_some_and(|n| fits(pattern, &n));
            if !fits {
                continue;
            }
            any = true;
            if let Some(other) = group.replace(name.clone())
                && other != *name
            {
                let file = file.display();
                return Err(CliError::input(format_args!(
                    "{file}: fits two groups, {other} and {name}; a recording is in one"
                )));
            }
        }
        if !any {
            return Err(CliError::input(format_args!(
                "group {name}: no recording fits \"{pattern}\""
            )));
        }
    }
    need_two(&found)?;
    Ok(found)
}

fn need_two(found: &[Option<String>]) -> Result<(), CliError> {
    let names: std::collections::BTreeSet<_> = found.iter().flatten().collect();
    if names.len() == 1 {
        return Err(CliError::input(
            "one group alone cannot be compared; name a second",
        ));
    }
    Ok(())
}

/// Whether a text fits a pattern of `*` for anything and `?` for one character.
fn fits(pattern: &str, text: &str) -> bool {
    let (pattern, text): (Vec<char>, Vec<char>) =
        (pattern.chars().collect(), text.chars().collect());
    let (mut p, mut t) = (0, 0);
    let mut star: Option<(usize, usize)> = None;
    while t < text.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p, t));
                p += 1;
            }
            Some(c) if *c == '?' || *c == text[t] => {
                p += 1;
                t += 1;
            }
            _ => match star {
                Some((at, taken)) => {
                    star = Some((at, taken + 1));
                    (p, t) = (at + 1, taken + 1);
                }
                None => return false,
            },
        }
    }
    pattern[p..].iter().all(|c| *c == '*')
}

/// Reads `file` and `group`; a file is named by its path as given, by its path from the table's folder, or by its name.
fn from_table(path: &Path, files: &[PathBuf]) -> Result<Vec<Option<String>>, CliError> {
    let failed = |what: String| CliError::input(format_args!("{}: {what}", path.display()));
    let mut reader = csv::Reader::from_path(path).map_err(|e| failed(e.to_string()))?;
    let heads = reader.headers().map_err(|e| failed(e.to_string()))?.clone();
    let column = |name: &str| {
        let found = heads
            .iter()
            .position(|h| h.trim().eq_ignore_ascii_case(name));
        found.ok_or_else(|| {
            failed(format!(
                "there is no column {name}; file and group are needed"
            ))
        })
    };
    let (file, group) = (column("file")?, column("group")?);
    let mut named: BTreeMap<PathBuf, String> = BTreeMap::new();
    for record in reader.records() {
        let record = record.map_err(|e| failed(e.to_string()))?;
        let cell = |i: usize| record.get(i).unwrap_or_default().trim().to_owned();
        named.insert(cell(file).into(), cell(group));
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let found = files.iter().map(|wanted| {
        let by_path = named.get(wanted);
        let beside = || {
            named
                .iter()
                .find(|(name, _)| folder.join(name) == *wanted)
                .map(|n| n.1)
        };
        let by_name = || named.get(Path::new(wanted.file_name()?));
        let group = by_path.or_else(beside).or_else(by_name);
        group.filter(|g| !g.is_empty()).cloned()
    });
    let found: Vec<_> = found.collect();
    if found.iter().all(Option::is_none) {
        return Err(failed("it names none of the recordings".into()));
    }
    need_two(&found)?;
    Ok(found)
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

/// Columns of recordings that fit on a terminal.
const MOST_COLUMNS: usize = 4;

fn tell_all(report: &Report, written: &[PathBuf]) {
    let rows = &report.rows;
    let shown = &rows[..rows.len().min(MOST_COLUMNS)];
    let text = |x: Option<f64>| x.map_or("–".to_owned(), |x| format!("{x:.3}"));
    let names = shown
        .iter()
        .map(|r| format!("{:>18}", cut(&r.about.name(), 18)));
    print(format_args!(
        "{:28}{}",
        "measure",
        names.collect::<String>()
    ));
    for metric in METRICS {
        let values = shown
            .iter()
            .map(|r| format!("{:>18}", text((metric.get)(&r.whole))));
        print(format_args!(
            "{:28}{}",
            metric.heading(),
            values.collect::<String>()
        ));
    }
    if rows.len() > shown.len() {
        print(format_args!(
            "and {} more; --csv, --parquet or --json has all",
            rows.len() - shown.len()
        ));
    }
    for c in &report.comparisons {
        let alike = c
            .identical
            .map_or(String::new(), |n| format!(", {n} alike bit for bit"));
        print(format_args!(
            "{} less {}, {}: {} pairs{alike}",
            c.names[1], c.names[0], c.aligned, c.pairs
        ));
        for (name, unit, s) in [
            ("position", "mm", &c.position_mm),
            ("force", "N", &c.force_n),
            ("depth", "mm", &c.depth_mm),
        ] {
            print(format_args!(
                "  {name:10} RMS {:>9.4} {unit}  mean {:>9.4} {unit}  greatest {:>9.4} {unit} at {:.3} s",
                s.rms, s.mean, s.max, s.max_at_s
            ));
        }
    }
    for g in &report.groups {
        let how = match g.pairing {
            Pairing::Paired => "paired",
            Pairing::Unpaired => "unpaired",
        };
        let [n_a, n_b] = g.participants;
        print(format_args!(
            "{} less {}, {how}, {n_b} and {n_a} participants",
            g.names[1], g.names[0]
        ));
        for (measure, metric) in g.measures.iter().zip(METRICS) {
            let Some(d) = &measure.difference else {
                continue;
            };
            print(format_args!(
                "  {:28} {:>11.3} ({:.3} to {:.3})  g {:.2} ({:.2} to {:.2})",
                metric.heading(),
                d.difference,
                d.difference_interval[0],
                d.difference_interval[1],
                d.g,
                d.g_interval[0],
                d.g_interval[1]
            ));
        }
    }
    for path in written {
        print(format_args!("written       {}", path.display()));
    }
}

fn cut(name: &str, most: usize) -> String {
    match name.chars().count() > most - 1 {
        true => name.chars().take(most - 2).chain(['…']).collect(),
        false => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_fit_what_they_say() {
        for (pattern, text) in [
            ("*", ""),
            ("N*.mcap", "N12.mcap"),
            ("?1*", "P1"),
            ("*a*b*", "xaxxbx"),
            ("a", "a"),
        ] {
            assert!(fits(pattern, text), "{pattern} {text}");
        }
        for (pattern, text) in [
            ("", "a"),
            ("N*.mcap", "N12.mca"),
            ("?", ""),
            ("*ab", "aba"),
            ("a?", "a"),
        ] {
            assert!(!fits(pattern, text), "{pattern} {text}");
        }
        assert!(
            parse_group("a=b*").is_ok() && parse_group("=b").is_err() && parse_group("a").is_err()
        );
    }
}
