//! `dorsum map`: what the maps of a scenario say at given points; appendix C; the dissertation's worked example.

use super::common::load_scenario;
use super::{CliError, Outcome, print, print_json};
use crate::geom::Vec2;
use crate::maps::appendix::{self, Force, Means};
use crate::maps::{EllipseMap, EllipseSettings, Oval, printed};
use crate::scenario::Scenario;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Coordinates allowed in a file of points, mm: as in a scenario.
const FAR_MM: f64 = 50_000.0;

/// What to tell: a scenario's maps at points, appendix C, or the worked example.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("what").required(true).args(["at", "appendix_c", "check"]))]
pub struct MapArgs {
    /// Scenario file, or the name of an example.
    #[arg(requires = "at")]
    scenario: Option<String>,
    /// Points on the map plane: a CSV file with the columns x,y, mm.
    #[arg(long, value_name = "POINTS.csv", requires = "scenario")]
    at: Option<PathBuf>,
    /// Means of the ellipses measured in appendix C, and the keys made of them.
    #[arg(long)]
    appendix_c: bool,
    /// Which way the skin was pressed: up or down. Without: up.
    #[arg(long, value_parser = force_by_name, requires = "appendix_c")]
    force: Option<Force>,
    /// One subject instead of the mean of all.
    #[arg(long, value_name = "N", requires = "appendix_c")]
    subject: Option<u32>,
    /// The worked example of table 5.1, published and corrected, and the means of appendix C, against the figures to meet.
    #[arg(long)]
    check: bool,
}

fn force_by_name(name: &str) -> Result<Force, String> {
    let mut all = Force::all().iter().copied();
    all.find(|f| f.name() == name)
        .ok_or_else(|| "allowed are up, down".into())
}

/// Prints what was asked for.
///
/// # Errors
/// The scenario or the file of points is refused; no such subject.
pub fn run(args: &MapArgs, json: bool) -> Result<Outcome, CliError> {
    if args.check {
        return check(json);
    }
    match (&args.scenario, &args.at) {
        (Some(scenario), Some(points)) => at_points(&load_scenario(scenario)?, points, json),
        _ => appendix_c(args.force.unwrap_or_default(), args.subject, json),
    }
}

/// An ellipse as printed.
#[derive(Clone, Copy, Serialize)]
struct PrintedOval {
    half_major_mm: f64,
    half_minor_mm: f64,
    major_over_minor: f64,
    angle_deg: f64,
}

impl From<Oval> for PrintedOval {
    fn from(oval: Oval) -> Self {
        Self {
            half_major_mm: oval.half_major_mm,
            half_minor_mm: oval.half_minor_mm,
            major_over_minor: oval.major_over_minor(),
            angle_deg: oval.angle_rad.to_degrees(),
        }
    }
}

impl std::fmt::Display for PrintedOval {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{:>9.3} {:>9.3} {:>7.2}",
            self.half_major_mm, self.half_minor_mm, self.angle_deg
        )
    }
}

#[derive(Serialize)]
struct Point {
    x_mm: f64,
    y_mm: f64,
    stiffness_n_per_mm: f64,
    /// By the forms that the scenario chooses.
    scenario: PrintedOval,
    /// Corrected form, exact level, direction as a tensor.
    default: PrintedOval,
    /// Stacking form of eq. 5.7, array of 700, direction linear in degrees.
    published: PrintedOval,
}

#[derive(Serialize)]
struct AtPoints<'a> {
    scenario: &'a str,
    fit: &'static str,
    strokes: usize,
    ellipse_keys: usize,
    form: &'static str,
    angle: &'static str,
    level: &'static str,
    points: Vec<Point>,
}

fn at_points(scenario: &Scenario, file: &Path, json: bool) -> Result<Outcome, CliError> {
    let points = read_points(file)?;
    let stiffness = scenario.stiffness_map().map_err(CliError::input)?;
    let (keys, settings) = scenario.ellipse.clone().unwrap_or_default();
    let default = EllipseSettings {
        basic_radius_mm: settings.basic_radius_mm,
        effect_radius_mm: settings.effect_radius_mm,
        ..EllipseSettings::default()
    };
    let map = |settings| EllipseMap::new(keys.clone(), settings).map_err(CliError::input);
    let [own, default, published] = [map(settings)?, map(default)?, map(settings.published())?];
    let mut stiffness_at = stiffness.reader();
    let found = AtPoints {
        scenario: &scenario.name,
        fit: scenario.stiffness_fit.name(),
        strokes: scenario.strokes.len(),
        ellipse_keys: keys.len(),
        form: settings.form.name(),
        angle: settings.angle.name(),
        level: settings.level.name(),
        points: points
            .into_iter()
            .map(|p| Point {
                x_mm: p.x,
                y_mm: p.y,
                stiffness_n_per_mm: stiffness_at(p),
                scenario: own.at(p).into(),
                default: default.at(p).into(),
                published: published.at(p).into(),
            })
            .collect(),
    };
    if json {
        print_json(&found)?;
        return Ok(Outcome::Done);
    }
    print(found.scenario);
    print(format_args!(
        "stiffness: fit {}, {} strokes; ellipses: {} keys, basic circle {} mm, effect radius {} mm",
        found.fit,
        found.strokes,
        found.ellipse_keys,
        settings.basic_radius_mm,
        settings.effect_radius_mm
    ));
    let own_form = settings != *default.settings() && settings != *published.settings();
    print("");
    let mut heads = format!("{:>28} {:^27} {:^27}", "", "default", "published");
    let half_axes = format!("{:>9} {:>9} {:>7}", "major mm", "minor mm", "angle°");
    let mut units = format!(
        "{:>8} {:>8} {:>10} {half_axes} {half_axes}",
        "x mm", "y mm", "N/mm"
    );
    if own_form {
        heads += &format!(
            " {:^27}",
            format!("{}, {}, {}", found.form, found.angle, found.level)
        );
        units += &format!(" {half_axes}");
    }
    print(heads.trim_end());
    print(units);
    for p in &found.points {
        let own = if own_form {
            format!(" {}", p.scenario)
        } else {
            String::new()
        };
        print(format_args!(
            "{:>8} {:>8} {:>10.5} {} {}{own}",
            p.x_mm, p.y_mm, p.stiffness_n_per_mm, p.default, p.published
        ));
    }
    Ok(Outcome::Done)
}

/// The points of a CSV file: columns x,y in mm; further columns are passed over, lines that start with # too.
fn read_points(file: &Path) -> Result<Vec<Vec2>, CliError> {
    let origin = file.display();
    let text = std::fs::read_to_string(file)
        .map_err(|e| CliError::input(format_args!("{origin}: cannot be read: {e}")))?;
    let fail =
        |line: u64, what: String| CliError::input(format_args!("{origin}: line {line}: {what}"));
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(text.as_bytes());
    let header = reader
        .headers()
        .map_err(|e| fail(1, e.to_string()))?
        .clone();
    let column = |name: &str| header.iter().position(|h| h == name);
    let (Some(x), Some(y)) = (column("x"), column("y")) else {
        let columns: Vec<_> = header.iter().collect();
        let what = format!("columns \"{}\"; x and y are needed, mm", columns.join(","));
        let line = header.position().map_or(1, csv::Position::line);
        return Err(fail(line, what));
    };
    let mut points = Vec::new();
    for row in reader.records() {
        let row = row.map_err(|e| {
            let line = e.position().map_or(0, csv::Position::line);
            fail(line, e.to_string())
        })?;
        let line = row.position().map_or(0, csv::Position::line);
        let number = |name: &str, i: usize| {
            let text = row.get(i).unwrap_or_default();
            let number = text.parse().ok().filter(|v: &f64| v.abs() <= FAR_MM);
            number.ok_or_else(|| {
                let what = format!("{name} = \"{text}\"; a number within ±{FAR_MM} mm is needed");
                fail(line, what)
            })
        };
        points.push(Vec2::new(number("x", x)?, number("y", y)?));
    }
    if points.is_empty() {
        let what = "no points; below the header x,y each line is one, in mm";
        return Err(CliError::input(format_args!("{origin}: {what}")));
    }
    Ok(points)
}

#[derive(Serialize)]
struct PrintedMean {
    point: u32,
    rows: usize,
    major_mm: f64,
    major_over_minor: f64,
    direction_deg: f64,
}

impl From<&appendix::Mean> for PrintedMean {
    fn from(m: &appendix::Mean) -> Self {
        Self {
            point: m.point,
            rows: m.rows,
            major_mm: m.major_mm,
            major_over_minor: m.major_over_minor,
            direction_deg: m.angle_rad.to_degrees(),
        }
    }
}

#[derive(Serialize)]
struct PrintedKey {
    name: String,
    x_mm: f64,
    y_mm: f64,
    half_major_mm: f64,
    half_minor_mm: f64,
    angle_deg: f64,
}

#[derive(Serialize)]
struct AppendixC {
    force: &'static str,
    subject: Option<u32>,
    /// As printed: axes as they stand, directions as numbers.
    printed: Vec<PrintedMean>,
    /// The longer axis as the major one, directions as axes.
    axial: Vec<PrintedMean>,
    /// The seven keys on the built-in back, from the means as printed.
    keys: Vec<PrintedKey>,
}

fn appendix_c(force: Force, subject: Option<u32>, json: bool) -> Result<Outcome, CliError> {
    let means = |by| -> Vec<PrintedMean> {
        let means = appendix::means(by, force, subject);
        means.iter().map(PrintedMean::from).collect()
    };
    let found = AppendixC {
        force: force.name(),
        subject,
        printed: means(Means::Printed),
        axial: means(Means::Axial),
        keys: appendix::seven_keys(force, subject)
            .into_iter()
            .map(|key| PrintedKey {
                x_mm: key.at.x,
                y_mm: key.at.y,
                half_major_mm: key.half_major_mm,
                half_minor_mm: key.half_minor_mm,
                angle_deg: key.angle_rad.to_degrees(),
                name: key.name,
            })
            .collect(),
    };
    if found.printed.is_empty() {
        let mut measured: Vec<u32> = appendix::rows()
            .iter()
            .filter(|row| row.force == force)
            .map(|row| row.subject)
            .collect();
        measured.sort_unstable();
        measured.dedup();
        let measured: Vec<_> = measured.iter().map(u32::to_string).collect();
        return Err(CliError::input(format_args!(
            "subject {} was not measured with the force {}; there are {}",
            subject.unwrap_or_default(),
            force.name(),
            measured.join(", ")
        )));
    }
    if json {
        print_json(&found)?;
        return Ok(Outcome::Done);
    }
    let who = match subject {
        Some(n) => format!("subject {n}"),
        None => "mean of all subjects".to_owned(),
    };
    print(format_args!(
        "Appendix C, force {}, {who}; full axes. Printed: axes and directions as they stand; axial: the longer axis is the \
         major one, directions as axes.",
        found.force
    ));
    print("");
    print(format_args!("{:15} {:^25} {:^25}", "", "printed", "axial"));
    let columns = format!("{:>8} {:>7} {:>8}", "major mm", "ratio", "angle°");
    print(format_args!(
        "{:<6} {:>8} {columns} {columns}",
        "point", "rows"
    ));
    for (printed, axial) in found.printed.iter().zip(&found.axial) {
        let cells = |m: &PrintedMean| {
            format!(
                "{:>8.1} {:>7.3} {:>8.1}",
                m.major_mm, m.major_over_minor, m.direction_deg
            )
        };
        print(format_args!(
            "P{:<5} {:>8} {} {}",
            printed.point,
            printed.rows,
            cells(printed),
            cells(axial)
        ));
    }
    print("");
    print("Keys on the built-in back, half axes:");
    print(format_args!(
        "{:<6} {:>8} {:>8} {:>9} {:>9} {:>8}",
        "key", "x mm", "y mm", "major mm", "minor mm", "angle°"
    ));
    for key in &found.keys {
        print(format_args!(
            "{:<6} {:>8.1} {:>8.1} {:>9.1} {:>9.1} {:>8.1}",
            key.name, key.x_mm, key.y_mm, key.half_major_mm, key.half_minor_mm, key.angle_deg
        ));
    }
    Ok(Outcome::Done)
}

#[derive(Serialize)]
struct Checked {
    what: String,
    expected: f64,
    found: Option<f64>,
    within: f64,
    holds: bool,
}

/// Printed means of appendix C: full major axis mm, ratio, direction °.
const PRINTED_MEANS: [(f64, f64, f64); 5] = [
    (358.0, 1.134, 90.0),
    (298.0, 1.049, 90.0),
    (266.0, 1.231, 180.0),
    (358.0, 1.357, 99.4),
    (284.0, 1.313, 121.0),
];

fn check(json: bool) -> Result<Outcome, CliError> {
    let mut rows: Vec<Checked> = printed::figures()
        .iter()
        .map(|f| Checked {
            what: format!(
                "table 5.1, {}, {}, effect radius {} mm, at ({}, {}): half major axis, mm",
                f.form.name(),
                f.level.name(),
                f.effect_radius_mm,
                f.at.x,
                f.at.y
            ),
            expected: f.half_major_mm,
            found: f.found_mm(),
            within: f.within_mm,
            holds: f.holds(),
        })
        .collect();
    let means = appendix::means(Means::Printed, Force::Up, None);
    for (mean, (major_mm, ratio, deg)) in means.iter().zip(PRINTED_MEANS) {
        for (what, expected, found, within) in [
            ("full major axis, mm", major_mm, mean.major_mm, 0.5),
            ("major over minor", ratio, mean.major_over_minor, 0.0005),
            ("direction, degrees", deg, mean.angle_rad.to_degrees(), 0.05),
        ] {
            rows.push(Checked {
                what: format!("appendix C, force up, P{}: {what}", mean.point),
                expected,
                found: Some(found),
                within,
                holds: (found - expected).abs() <= within,
            });
        }
    }
    let all_hold = rows.iter().all(|row| row.holds);
    if json {
        print_json(&rows)?;
    } else {
        print(format_args!(
            "{:>10} {:>12} {:>10}  {:<5} of",
            "printed", "found", "apart", ""
        ));
        for row in &rows {
            let found = row.found.unwrap_or(f64::NAN);
            let holds = if row.holds { "holds" } else { "FAILS" };
            print(format_args!(
                "{:>10} {found:>12.5} {:>10.1e}  {holds} {}",
                row.expected,
                (found - row.expected).abs(),
                row.what
            ));
        }
        let n = rows.iter().filter(|row| row.holds).count();
        print(format_args!("{n} of {} hold", rows.len()));
    }
    Ok(if all_hold {
        Outcome::Done
    } else {
        Outcome::DoesNotHold
    })
}
