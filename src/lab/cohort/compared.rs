//! The sessions beside each other: each beside the first, and the groups by every measure.

use super::made::{DEEP_MM, GROUPS, group_of};
use crate::lab::{LabError, Report, Table, Verdict, Watch};
use crate::session::Session;
use crate::study::compare::{Align, CompareOptions, compare};
use crate::study::groups::{Row, grouped};
use crate::study::{METRICS, Options, StudyError, analyse, cohort};
use std::path::{Path, PathBuf};

/// The ratio of what the groups pressed may be so far from that of what they were told to press.
const OFF: f64 = 0.05;

/// What comparing them told.
#[derive(Default)]
pub(super) struct Compared {
    /// How many were compared.
    pub(super) sessions: usize,
    /// Whether the first agrees with itself in every bit.
    same: bool,
    /// Whether every distance and difference is finite.
    finite: bool,
    /// Root mean square of the distance of each from the first, warped, mm.
    distances_mm: Vec<f64>,
    /// The measures of every session.
    rows: Vec<Row>,
}

impl Compared {
    /// Analyses each of `files` and compares it with the first by warping, with `jobs` threads. What is kept of each are its
    /// measures.
    pub(super) fn of(
        files: &[PathBuf],
        jobs: usize,
        watch: &mut Watch<'_>,
    ) -> Result<Self, LabError> {
        let options = Options::default();
        let first = Session::open(&files[0]).map_err(|e| super::failed(&files[0], &e))?;
        let told = analyse(&first, &options, &mut |_| true).map_err(super::told)?;
        let by = |align| CompareOptions {
            align,
            ..CompareOptions::default()
        };
        let (by_time, by_warping) = (by(Align::Time), by(Align::Dtw));
        let beside = |path: &Path, done: &mut dyn FnMut(f64) -> bool| {
            let session = Session::open(path)?;
            let analysis = analyse(&session, &options, &mut |share| done(0.5 * share))?;
            let (both, tell) = ([&first, &session], [&told, &analysis]);
            let plain = compare(both, tell, &by_time, &mut |share| done(0.5 + 0.25 * share))?;
            let warped = compare(both, tell, &by_warping, &mut |share| {
                done(0.75 + 0.25 * share)
            })?;
            Ok::<_, StudyError>((Row::of(&analysis, None), plain, warped))
        };
        let mut made = Self {
            finite: true,
            ..Self::default()
        };
        let (mut wrong, mut heard) = (None, Ok(()));
        let stop = std::cell::Cell::new(false);
        let ended = cohort::map(
            files,
            jobs,
            &|_, path, done| beside(path, done),
            &mut |_| !stop.get(),
            &mut |i, result| {
                match result {
                    Ok((row, plain, warped)) => {
                        made.sessions += 1;
                        let apart = [
                            plain.position_mm.rms,
                            plain.force_n.rms,
                            warped.position_mm.rms,
                        ];
                        made.finite &= apart.into_iter().all(f64::is_finite);
                        made.distances_mm.push(warped.position_mm.rms);
                        if i == 0 {
                            made.same = plain.identical == Some(plain.pairs) && plain.pairs > 0;
                        }
                        let group = Some(GROUPS[group_of(i)].to_owned());
                        made.rows.push(Row { group, ..row });
                    }
                    Err(e) => wrong = wrong.take().or(Some(e)),
                }
                heard = watch.at("comparing sessions", i as f64 / files.len() as f64);
                stop.set(heard.is_err());
            },
        );
        heard?;
        ended.map_err(super::told)?;
        wrong.map_or(Ok(made), |e| Err(super::told(e)))
    }

    /// What must hold of `n` sessions, and how the groups differ.
    pub(super) fn tell(&self, n: usize, report: &mut Report) {
        let whole = self.sessions == n && self.finite;
        report.verdicts.push(Verdict::must(
            format!("{n} sessions, every one compared with the first, by time and by warping"),
            format!("{} compared", self.sessions),
            n,
            whole,
        ));
        report.verdicts.push(Verdict::must(
            format!("{n} sessions, the first beside itself"),
            if self.same {
                "alike in every bit"
            } else {
                "not alike"
            },
            "alike in every bit",
            self.same,
        ));
        let [deep, shallow] = GROUPS;
        let found = grouped(&self.rows, shallow, deep);
        let mut table = Table::new(
            "groups",
            "The groups by every measure: those who pressed deeper less the others, participants counted once",
            &[
                "measure",
                "shallow, mean",
                "deep, mean",
                "difference",
                "from (95 %)",
                "to",
                "Hedges' g",
                "g from (95 %)",
                "g to",
            ],
        );
        for (metric, measure) in METRICS.iter().zip(&found.measures) {
            let Some(d) = &measure.difference else {
                continue;
            };
            let name = match metric.unit {
                "" => metric.title.to_owned(),
                unit => format!("{} ({unit})", metric.title),
            };
            table.push([
                name.into(),
                d.groups[0].mean.into(),
                d.groups[1].mean.into(),
                d.difference.into(),
                d.difference_interval[0].into(),
                d.difference_interval[1].into(),
                d.g.into(),
                d.g_interval[0].into(),
                d.g_interval[1].into(),
            ]);
            if metric.key == "press_depth_mm" {
                let ratio = d.groups[1].mean / d.groups[0].mean;
                let wanted = DEEP_MM[0] / DEEP_MM[1];
                report.verdicts.push(Verdict::must(
                    format!("{n} sessions, depth of the presses, deep over shallow"),
                    format!(
                        "{ratio:.3}; g {:.1} ({:.1} to {:.1})",
                        d.g, d.g_interval[0], d.g_interval[1]
                    ),
                    format!(
                        "within {:.0} % of {wanted:.3}, which the fingers were told; g above 0",
                        100.0 * OFF
                    ),
                    (ratio / wanted - 1.0).abs() <= OFF && d.g_interval[0] > 0.0,
                ));
            }
        }
        report.tables.push(table);
    }
}
