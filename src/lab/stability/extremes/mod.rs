//! Extreme cases at every public door, a row each: finite, bounded, right or refused.

mod dents;
mod devices;
mod drive;
mod edges;
mod elastic;
mod files;
mod maps;
mod plates;
mod readings;
mod row;
mod scales;
mod searches;

use crate::lab::{Choice, Experiment, LabError, Report, Setup, Table, Verdict, Watch};
use row::{COLUMNS, Case, Outcome, Row, Size, Tally};

/// Ticks of a case that has ticks.
const TICKS: u64 = 60_000;
const QUICK_TICKS: u64 = 100;
/// Questions of a case without ticks.
const QUESTIONS: usize = 20_000;
const QUICK_QUESTIONS: usize = 60;
/// Ticks that a full run makes at least.
const FEWEST_TICKS: u64 = 10_000_000;

/// The cases of one subject.
type Subject = (&'static str, fn() -> Vec<Case>);

/// Every subject.
const SUBJECTS: &[Subject] = &[
    ("triangles", plates::shapes),
    ("motion", plates::motions),
    ("material", plates::materials),
    ("published", plates::published_engine),
    ("edges", edges::cases),
    ("scale", scales::cases),
    ("readings", readings::cases),
    ("devices", devices::cases),
    ("searches", searches::cases),
    ("maps", maps::cases),
    ("dents", dents::cases),
    ("elastic", elastic::cases),
    ("files", files::cases),
];

/// The extremes.
pub struct Extremes;

impl Experiment for Extremes {
    fn name(&self) -> &'static str {
        "stability-extremes"
    }

    fn about(&self) -> &'static str {
        "Extreme cases at every public door: finite, bounded, right or refused, over millions of ticks"
    }

    fn takes(&self) -> &'static [Choice] {
        &[Choice::Seed]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let size = if setup.quick {
            Size {
                ticks: QUICK_TICKS,
                questions: QUICK_QUESTIONS,
                quick: true,
                seed: setup.seed,
            }
        } else {
            Size {
                ticks: TICKS,
                questions: QUESTIONS,
                quick: false,
                seed: setup.seed,
            }
        };
        let mut report = Report::default();
        report.set("seed", setup.seed);
        report.set("ticks", format!("{} a case", size.ticks));
        let mut table = Table::new("extremes", "Every extreme case", &COLUMNS);
        let mut sum = Tally::default();
        let mut rows: Vec<Row> = Vec::new();
        let n = SUBJECTS.len() as f64;
        for (i, (subject, cases)) in SUBJECTS.iter().enumerate() {
            let mut part = watch.part(i as f64 / n, (i + 1) as f64 / n);
            part.at(subject, 0.0)?;
            let made = setup.shelf.part(subject, || {
                let cases = cases();
                let of = cases.len() as f64;
                let mut rows = Vec::with_capacity(cases.len());
                for (j, case) in cases.iter().enumerate() {
                    part.at(&format!("{subject}: {}", case.name), j as f64 / of)?;
                    rows.push(case.row(subject, &size));
                }
                Ok(rows)
            })?;
            rows.extend(made);
        }
        for row in &rows {
            sum.add(&row.tally);
            table.push(row.cells());
        }
        judge(&rows, &sum, setup.quick, &mut report);
        report.tables.push(table);
        Ok(report)
    }
}

/// What holds over all rows.
fn judge(rows: &[Row], sum: &Tally, quick: bool, report: &mut Report) {
    let count = |outcome| rows.iter().filter(|r| r.outcome == outcome).count();
    let wrong = count(Outcome::Wrong);
    report.verdicts.push(Verdict::must(
        "ticks of extremes",
        format!(
            "{} non-finite values and {} forces above the limit over {} ticks",
            sum.not_finite, sum.over_limit, sum.ticks
        ),
        if quick {
            "0 and 0".to_owned()
        } else {
            format!("0 and 0 over at least {FEWEST_TICKS}")
        },
        sum.not_finite == 0 && sum.over_limit == 0 && (quick || sum.ticks >= FEWEST_TICKS),
    ));
    let first = rows.iter().find(|r| r.outcome == Outcome::Wrong);
    report.verdicts.push(Verdict::must(
        "every case right, bounded or refused",
        match first {
            None => format!(
                "{} right, {} bounded, {} refused of {}",
                count(Outcome::Right),
                count(Outcome::Bounded),
                count(Outcome::Refused),
                rows.len()
            ),
            Some(r) => format!(
                "{wrong} wrong of {}; first {}: {}",
                rows.len(),
                r.case,
                r.says
            ),
        },
        "none wrong",
        wrong == 0,
    ));
    report.note(
        "Right: equal to a closed form, or to an ordinary case that is equivalent. Bounded: finite and within its limits, \
         where no form tells what is right. Refused: not let in, with the line shown.",
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOOK: Size = Size {
        ticks: QUICK_TICKS,
        questions: QUICK_QUESTIONS,
        quick: true,
        seed: 7,
    };

    #[test]
    fn no_case_goes_wrong() {
        let mut wrong = Vec::new();
        for (subject, cases) in SUBJECTS {
            for case in cases() {
                let row = case.row(subject, &LOOK);
                if row.outcome == Outcome::Wrong {
                    wrong.push(format!(
                        "{subject}: {}: {} {:?}",
                        row.case, row.says, row.tally
                    ));
                }
            }
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }
}
