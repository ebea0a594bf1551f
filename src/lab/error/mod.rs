//! Error against run time: every model of the drawn skin beside a fine finite-element slab, on one press.
//!
//! | file | answers |
//! |---|---|
//! | [`bench`] | which press on which skin, what the truth is, how far off a shape is |
//! | [`field`] | which models at which settings |

mod bench;
mod field;

use super::{Choice, Experiment, LabError, Report, Setup, Table, Value, Verdict, Watch};
use crate::figure::{LinePlot, Mark, Scale, Series};
use bench::{Bench, Found};
use field::{FAMILIES, Family};

/// Error against run time.
pub struct ErrorVsTime;

/// An error that a hand does not feel and an eye hardly sees, mm: what a recommendation is made for.
const WITHIN_MM: f64 = 0.5;

/// Smallest difference in force that a finger tells, as a share of the force (Pang, Tan and Durlach 1991: 5 to 10 %).
const JND_SHARE: f64 = 0.07;

/// One model at one setting, measured.
struct Row {
    family: &'static Family,
    setting: String,
    found: Found,
    front: bool,
}

impl Experiment for ErrorVsTime {
    fn name(&self) -> &'static str {
        "error-vs-time"
    }

    fn about(&self) -> &'static str {
        "Every model of the drawn skin at several settings: how far off physics, at which cost"
    }

    fn takes(&self) -> &'static [Choice] {
        &[Choice::Triangles]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        let bench = Bench::new(setup, &mut watch.part(0.0, 0.3))?;
        bench.describe(&mut report);
        let candidates = field::all(&bench, setup.quick, &mut watch.part(0.3, 0.6))?;
        let n = candidates.len().max(1) as f64;
        let mut rows = Vec::new();
        let mut part = watch.part(0.6, 1.0);
        for (i, mut candidate) in candidates.into_iter().enumerate() {
            let what = format!("{} {}", candidate.family.name, candidate.setting);
            part.at(&what, i as f64 / n)?;
            rows.push(Row {
                family: candidate.family,
                setting: candidate.setting.clone(),
                found: bench.measure(&mut candidate),
                front: false,
            });
        }
        mark_front(&mut rows);
        report.tables.push(table(&bench, &rows));
        report.draw("error-vs-time", vec![plot(&rows)]);
        judge(&bench, &rows, &mut report);
        Ok(report)
    }
}

/// Marks what nothing else beats in both cost and error.
fn mark_front(rows: &mut [Row]) {
    for i in 0..rows.len() {
        let (cost, error) = (rows[i].found.median_us, rows[i].found.rms_mm);
        let beaten = rows.iter().enumerate().any(|(j, r)| {
            let (c, e) = (r.found.median_us, r.found.rms_mm);
            j != i && c <= cost && e <= error && (c < cost || e < error)
        });
        rows[i].front = !beaten && error.is_finite();
    }
}

fn table(bench: &Bench, rows: &[Row]) -> Table {
    let mut table = Table::new(
        "error-vs-time",
        format!(
            "One press, {} mm deep: how far off a fine slab, and the cost of one update",
            bench.depth_mm
        ),
        &[
            "model",
            "setting",
            "median µs",
            "p99 µs",
            "rms mm",
            "max mm",
            "relative %",
            "force N",
            "force off N",
            "force off % of JND",
            "strain off",
            "on front",
        ],
    );
    for row in rows {
        let f = &row.found;
        let off = f.force_n.map(|force_n| force_n - bench.force_n);
        let of_jnd = off.map(|off| 100.0 * off.abs() / (JND_SHARE * bench.force_n));
        let cell = |x: Option<f64>| x.map_or(Value::Empty, Value::from);
        table.push([
            row.family.name.into(),
            row.setting.as_str().into(),
            f.median_us.into(),
            f.p99_us.into(),
            f.rms_mm.into(),
            f.max_mm.into(),
            (100.0 * f.relative).into(),
            cell(f.force_n),
            cell(off),
            cell(of_jnd),
            f.strain_off.into(),
            Value::Text(if row.front { "front" } else { "" }.to_owned()),
        ]);
    }
    table
}

fn plot(rows: &[Row]) -> LinePlot {
    let mut series: Vec<Series> = FAMILIES
        .iter()
        .map(|family| Series {
            name: family.name.to_owned(),
            colour: family.colour,
            mark: Mark::Points,
            points: rows
                .iter()
                .filter(|r| r.family.name == family.name)
                .map(|r| [r.found.median_us, r.found.rms_mm.max(1e-6)])
                .collect(),
        })
        .filter(|s| !s.points.is_empty())
        .collect();
    let mut front: Vec<[f64; 2]> = rows
        .iter()
        .filter(|r| r.front)
        .map(|r| [r.found.median_us, r.found.rms_mm.max(1e-6)])
        .collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    series.push(Series {
        name: "Pareto front".to_owned(),
        colour: [24, 26, 30],
        mark: Mark::Dashed,
        points: front,
    });
    LinePlot {
        title: "Error against run time".to_owned(),
        x_label: "median cost of an update (µs)".to_owned(),
        y_label: "RMS error (mm)".to_owned(),
        x_scale: Scale::Logarithmic,
        y_scale: Scale::Logarithmic,
        series,
    }
}

fn judge(bench: &Bench, rows: &[Row], report: &mut Report) {
    let costs = || rows.iter().map(|r| r.found.median_us).filter(|c| *c > 0.0);
    let (least, most) = (
        costs().fold(f64::INFINITY, f64::min),
        costs().fold(0.0, f64::max),
    );
    let decades = (most / least).log10();
    report.verdicts.push(Verdict::told(
        "settings compared, and decades of cost between them",
        format!("{} over {decades:.1} decades", rows.len()),
        "12 over 3",
        rows.len() >= 12 && decades >= 3.0,
    ));
    let finite = rows.iter().all(|r| r.found.finite);
    report.verdicts.push(Verdict::must(
        "every shape is finite",
        if finite { "yes" } else { "no" },
        "yes",
        finite,
    ));
    let of = |name: &str| {
        let rows = rows
            .iter()
            .filter(|r| r.family.name == "fsmd" && r.setting.contains(name));
        rows.map(|r| r.found.relative).fold(f64::INFINITY, f64::min)
    };
    let (fitted, printed) = (of("fitted"), of("printed footprint"));
    report.verdicts.push(Verdict::told(
        "FSMD with its footprint fitted to the slab, relative error (L2)",
        format!("{:.1} %", 100.0 * fitted),
        "10 to 12 % of a bonded layer of 15 to 20 mm",
        fitted < 0.13,
    ));
    report.note(format!(
        "With the printed footprint FSMD is {:.0} % off: its dent is many times wider than that of a layer on bone.",
        100.0 * printed
    ));
    let mut within: Vec<&Row> = rows
        .iter()
        .filter(|r| r.found.max_mm <= WITHIN_MM)
        .collect();
    within.sort_by(|a, b| a.found.median_us.total_cmp(&b.found.median_us));
    report.note(match within.first() {
        Some(row) => format!(
            "For this scene within {WITHIN_MM} mm everywhere, {} mm deep: {} ({}), {:.0} µs an update.",
            bench.depth_mm, row.family.name, row.setting, row.found.median_us
        ),
        None => format!("No model at these settings stays within {WITHIN_MM} mm everywhere."),
    });
    report.note(
        "FSMD and the printed footprints tell no force: what is felt is stiffness times depth, whatever is drawn.",
    );
}
