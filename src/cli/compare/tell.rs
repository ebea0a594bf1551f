//! What is printed for people.

use crate::cli::print;
use crate::study::METRICS;
use crate::study::report::Report;
use crate::study::stats::Pairing;
use std::path::PathBuf;

/// Columns of recordings that fit on a terminal.
const MOST_COLUMNS: usize = 4;

/// Prints measures, differences, groups, and what was written.
pub(super) fn tell_all(report: &Report, written: &[PathBuf]) {
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
    let edges_n = rows.first().map_or(&[][..], |r| &r.force_bands_n);
    for metric in METRICS {
        let values = shown
            .iter()
            .map(|r| format!("{:>18}", text((metric.get)(&r.whole))));
        print(format_args!(
            "{:28}{}",
            metric.heading_at(edges_n),
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
            let g = match d.has_g() {
                true => format!(
                    "g {:.2} ({:.2} to {:.2})",
                    d.g, d.g_interval[0], d.g_interval[1]
                ),
                false => "g –".to_owned(),
            };
            print(format_args!(
                "  {:28} {:>11.3} ({:.3} to {:.3})  {g}",
                metric.heading_at(edges_n),
                d.difference,
                d.difference_interval[0],
                d.difference_interval[1]
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
