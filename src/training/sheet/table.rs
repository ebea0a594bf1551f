//! Columns of trials and of participants.

use super::Done;
use crate::training::trial::TrialRecord;

/// What a cell holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A number; absent where there is none, and where it is not finite.
    Number(Option<f64>),
    /// A count.
    Count(Option<i64>),
    /// Yes or no.
    Yes(Option<bool>),
    /// A name.
    Text(String),
}

/// A column: its name carries the unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name.
    pub name: &'static str,
    /// One cell a row, all of one sort.
    pub cells: Vec<Cell>,
}

/// Columns of the same length.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Its columns; at least one.
    pub columns: Vec<Column>,
}

impl Table {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |c| c.cells.len())
    }

    /// As CSV: numbers with as many digits as bring them back bit for bit, nothing for what is absent.
    ///
    /// # Errors
    /// None that is known: the writer's own, which writes to memory.
    pub fn csv(&self) -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(self.columns.iter().map(|c| c.name))?;
        for row in 0..self.rows() {
            writer.write_record(self.columns.iter().map(|c| match &c.cells[row] {
                Cell::Number(x) => x.map(|x| x.to_string()).unwrap_or_default(),
                Cell::Count(n) => n.map(|n| n.to_string()).unwrap_or_default(),
                Cell::Yes(yes) => yes.map(|yes| yes.to_string()).unwrap_or_default(),
                Cell::Text(text) => text.clone(),
            }))?;
        }
        writer.into_inner().map_err(|e| e.into_error().into())
    }
}

fn number(x: Option<f64>) -> Cell {
    Cell::Number(x.filter(|x| x.is_finite()))
}

fn count(n: Option<impl Into<i64>>) -> Cell {
    Cell::Count(n.map(Into::into))
}

fn text(text: impl Into<String>) -> Cell {
    Cell::Text(text.into())
}

/// One row a trial, practice among them.
pub fn trials(done: &[Done]) -> Table {
    type Get = fn(&Done, &TrialRecord) -> Cell;
    const COLUMNS: [(&str, Get); 41] = [
        ("participant", |d, _| text(d.participant())),
        ("exercise_started_utc", |d, _| {
            text(&d.read.header.started_utc)
        }),
        ("scenario", |d, _| text(&d.read.header.scenario)),
        ("observer", |d, _| {
            text(d.read.header.observer.clone().unwrap_or_default())
        }),
        ("task", |_, t| text(&t.task)),
        ("practice", |_, t| Cell::Yes(Some(t.practice))),
        ("trial", |_, t| count(Some(t.trial))),
        ("settled_utc", |_, t| text(&t.settled_utc)),
        ("staircase_level", |_, t| number(t.level)),
        ("strength_percent", |_, t| number(t.strength_percent)),
        ("strength_of", |_, t| {
            text(t.measure.clone().unwrap_or_default())
        }),
        ("stiffness_change_percent", |_, t| {
            number(t.stiffness_percent)
        }),
        ("compliance_change_percent", |_, t| {
            number(t.compliance_percent)
        }),
        ("stiffness_gain", |_, t| number(Some(t.stiffness_gain))),
        ("chance", |_, t| number(Some(t.chance))),
        ("pointed_at", |_, t| text(t.pointed.join("; "))),
        ("truth", |_, t| text(&t.truth)),
        ("answer", |_, t| text(&t.answer)),
        ("right", |_, t| Cell::Yes(Some(t.right))),
        ("out_of_time", |_, t| {
            Cell::Yes(Some(t.ended == crate::training::trial::Ended::OutOfTime))
        }),
        ("confidence_percent", |_, t| count(t.confidence_percent)),
        ("search_s", |_, t| number(Some(t.search_s))),
        ("answer_s", |_, t| number(Some(t.answer_s))),
        ("level_error", |_, t| count(t.errors.levels)),
        ("side_right", |_, t| Cell::Yes(t.errors.side_right)),
        ("error_mm", |_, t| number(t.errors.mm)),
        ("kind_right", |_, t| Cell::Yes(t.errors.kind_right)),
        ("severity_error", |_, t| count(t.errors.severity)),
        ("found", |_, t| count(t.errors.found)),
        ("missed", |_, t| count(t.errors.missed)),
        ("false_positives", |_, t| count(t.errors.false_positives)),
        ("contact_s", |_, t| number(Some(t.palpation.contact_s))),
        ("presses", |_, t| count(Some(t.palpation.presses))),
        ("path_mm", |_, t| number(Some(t.palpation.path_mm))),
        ("coverage", |_, t| number(Some(t.palpation.coverage))),
        ("peak_force_n", |_, t| {
            number(Some(t.palpation.peak_force_n))
        }),
        ("mean_force_n", |_, t| {
            number(Some(t.palpation.mean_force_n))
        }),
        ("tender_presses", |_, t| {
            count(Some(t.palpation.tender_presses))
        }),
        ("tender_s", |_, t| number(Some(t.palpation.tender_s))),
        ("n_visits", |_, t| count(Some(t.palpation.n_visits))),
        ("visits", |_, t| {
            let numbers: Vec<String> = t.palpation.visits.iter().map(u16::to_string).collect();
            text(numbers.join(" "))
        }),
    ];
    let rows = || {
        done.iter()
            .flat_map(|d| d.read.trials.iter().map(move |t| (d, t)))
    };
    let column = |(name, get): &(&'static str, Get)| Column {
        name,
        cells: rows().map(|(d, t)| get(d, t)).collect(),
    };
    Table {
        columns: COLUMNS.iter().map(column).collect(),
    }
}

/// One row an exercise of a participant, in the order of time.
pub fn participants(done: &[Done]) -> Table {
    type Get = fn(&Done) -> Cell;
    const COLUMNS: [(&str, Get); 34] = [
        ("participant", |d| text(d.participant())),
        ("exercise_started_utc", |d| text(&d.read.header.started_utc)),
        ("scenario", |d| text(&d.read.header.scenario)),
        ("observer", |d| {
            text(d.read.header.observer.clone().unwrap_or_default())
        }),
        ("task", |d| {
            text(d.read.trials.first().map_or("", |t| &t.task))
        }),
        ("ended", |d| text(d.read.ended.clone().unwrap_or_default())),
        ("trials", |d| count(Some(d.analysis.score.trials))),
        ("right", |d| count(Some(d.analysis.score.right))),
        ("right_share", |d| number(d.analysis.score.right_share)),
        ("chance", |d| number(d.analysis.score.chance)),
        ("threshold_percent", |d| {
            number(d.analysis.fit.as_ref().map(|f| f.threshold_percent))
        }),
        ("threshold_low_percent", |d| {
            number(
                d.analysis
                    .fit
                    .as_ref()
                    .map(|f| f.threshold_interval_percent[0]),
            )
        }),
        ("threshold_high_percent", |d| {
            number(
                d.analysis
                    .fit
                    .as_ref()
                    .map(|f| f.threshold_interval_percent[1]),
            )
        }),
        ("threshold_of", |d| {
            text(d.analysis.fit.as_ref().map_or("", |f| &f.measure))
        }),
        ("threshold_at_share", |d| {
            number(d.analysis.fit.as_ref().map(|f| f.target))
        }),
        ("weber_fraction", |d| {
            number(d.analysis.fit.as_ref().map(|f| f.weber_fraction))
        }),
        ("d_prime", |d| {
            number(d.analysis.d_prime.as_ref().map(|p| p.over_all))
        }),
        ("d_prime_per_log_ratio", |d| {
            number(d.analysis.d_prime.as_ref().and_then(|p| p.per_log_ratio))
        }),
        ("mean_level_error", |d| number(d.analysis.score.levels)),
        ("side_wrong_share", |d| {
            number(d.analysis.score.side_wrong_share)
        }),
        ("mean_error_mm", |d| number(d.analysis.score.mm)),
        ("kind_right_share", |d| {
            number(d.analysis.score.kind_right_share)
        }),
        ("mean_severity_error", |d| number(d.analysis.score.severity)),
        ("found", |d| count(Some(d.analysis.score.found))),
        ("missed", |d| count(Some(d.analysis.score.missed))),
        ("false_positives", |d| {
            count(Some(d.analysis.score.false_positives))
        }),
        ("confidence_right_percent", |d| {
            number(d.analysis.score.confidence_right_percent)
        }),
        ("confidence_wrong_percent", |d| {
            number(d.analysis.score.confidence_wrong_percent)
        }),
        ("median_search_s", |d| number(d.analysis.score.search_s)),
        ("mean_path_mm", |d| number(d.analysis.score.path_mm)),
        ("mean_coverage", |d| number(d.analysis.score.coverage)),
        ("peak_force_n", |d| number(d.analysis.score.peak_force_n)),
        ("mean_force_n", |d| number(d.analysis.score.mean_force_n)),
        ("tender_presses", |d| {
            count(Some(d.analysis.score.tender_presses))
        }),
    ];
    let mut sorted: Vec<&Done> = done.iter().collect();
    sorted.sort_by(|a, b| {
        let key = |d: &Done| {
            (
                d.participant().to_owned(),
                d.read.header.started_utc.clone(),
            )
        };
        key(a).cmp(&key(b))
    });
    let column = |(name, get): &(&'static str, Get)| Column {
        name,
        cells: sorted.iter().map(|d| get(d)).collect(),
    };
    Table {
        columns: COLUMNS.iter().map(column).collect(),
    }
}
