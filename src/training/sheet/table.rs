//! Columns of trials and of participants.

use super::Done;
use crate::table::{Cell, Head, Sort, Table};
use crate::training::trial::TrialRecord;

/// One row a trial, practice among them.
pub fn trials(done: &[Done]) -> Table<'_> {
    type Get = for<'a> fn(&'a Done, &'a TrialRecord) -> Cell<'a>;
    const COLUMNS: [(&str, Sort, Get); 41] = [
        ("participant", Sort::Text, |d, _| {
            Cell::text(d.participant())
        }),
        ("exercise_started_utc", Sort::Text, |d, _| {
            Cell::text(&d.read.header.started_utc)
        }),
        ("scenario", Sort::Text, |d, _| {
            Cell::text(&d.read.header.scenario)
        }),
        ("observer", Sort::Text, |d, _| {
            Cell::text(d.read.header.observer.clone().unwrap_or_default())
        }),
        ("task", Sort::Text, |_, t| Cell::text(&t.task)),
        ("practice", Sort::Yes, |_, t| Cell::Yes(Some(t.practice))),
        ("trial", Sort::Count, |_, t| Cell::count(Some(t.trial))),
        ("settled_utc", Sort::Text, |_, t| Cell::text(&t.settled_utc)),
        ("staircase_level", Sort::Number, |_, t| {
            Cell::number(t.level)
        }),
        ("strength_percent", Sort::Number, |_, t| {
            Cell::number(t.strength_percent)
        }),
        ("strength_of", Sort::Text, |_, t| {
            Cell::text(t.measure.clone().unwrap_or_default())
        }),
        ("stiffness_change_percent", Sort::Number, |_, t| {
            Cell::number(t.stiffness_percent)
        }),
        ("compliance_change_percent", Sort::Number, |_, t| {
            Cell::number(t.compliance_percent)
        }),
        ("stiffness_gain", Sort::Number, |_, t| {
            Cell::number(Some(t.stiffness_gain))
        }),
        ("chance", Sort::Number, |_, t| Cell::number(Some(t.chance))),
        ("pointed_at", Sort::Text, |_, t| {
            Cell::text(t.pointed.join("; "))
        }),
        ("truth", Sort::Text, |_, t| Cell::text(&t.truth)),
        ("answer", Sort::Text, |_, t| Cell::text(&t.answer)),
        ("right", Sort::Yes, |_, t| Cell::Yes(Some(t.right))),
        ("out_of_time", Sort::Yes, |_, t| {
            Cell::Yes(Some(t.ended == crate::training::trial::Ended::OutOfTime))
        }),
        ("confidence_percent", Sort::Count, |_, t| {
            Cell::count(t.confidence_percent)
        }),
        ("search_s", Sort::Number, |_, t| {
            Cell::number(Some(t.search_s))
        }),
        ("answer_s", Sort::Number, |_, t| {
            Cell::number(Some(t.answer_s))
        }),
        ("level_error", Sort::Count, |_, t| {
            Cell::count(t.errors.levels)
        }),
        ("side_right", Sort::Yes, |_, t| {
            Cell::Yes(t.errors.side_right)
        }),
        ("error_mm", Sort::Number, |_, t| Cell::number(t.errors.mm)),
        ("kind_right", Sort::Yes, |_, t| {
            Cell::Yes(t.errors.kind_right)
        }),
        ("severity_error", Sort::Count, |_, t| {
            Cell::count(t.errors.severity)
        }),
        ("found", Sort::Count, |_, t| Cell::count(t.errors.found)),
        ("missed", Sort::Count, |_, t| Cell::count(t.errors.missed)),
        ("false_positives", Sort::Count, |_, t| {
            Cell::count(t.errors.false_positives)
        }),
        ("contact_s", Sort::Number, |_, t| {
            Cell::number(Some(t.palpation.contact_s))
        }),
        ("presses", Sort::Count, |_, t| {
            Cell::count(Some(t.palpation.presses))
        }),
        ("path_mm", Sort::Number, |_, t| {
            Cell::number(Some(t.palpation.path_mm))
        }),
        ("coverage", Sort::Number, |_, t| {
            Cell::number(Some(t.palpation.coverage))
        }),
        ("peak_force_n", Sort::Number, |_, t| {
            Cell::number(Some(t.palpation.peak_force_n))
        }),
        ("mean_force_n", Sort::Number, |_, t| {
            Cell::number(Some(t.palpation.mean_force_n))
        }),
        ("tender_presses", Sort::Count, |_, t| {
            Cell::count(Some(t.palpation.tender_presses))
        }),
        ("tender_s", Sort::Number, |_, t| {
            Cell::number(Some(t.palpation.tender_s))
        }),
        ("n_visits", Sort::Count, |_, t| {
            Cell::count(Some(t.palpation.n_visits))
        }),
        ("visits", Sort::Text, |_, t| {
            let numbers: Vec<String> = t.palpation.visits.iter().map(u16::to_string).collect();
            Cell::text(numbers.join(" "))
        }),
    ];
    let rows = || {
        done.iter()
            .flat_map(|d| d.read.trials.iter().map(move |t| (d, t)))
    };
    let row = |(d, t)| COLUMNS.iter().map(|(_, _, get)| get(d, t)).collect();
    Table {
        heads: (COLUMNS
            .iter()
            .map(|(name, sort, _)| Head::new(*name, *sort)))
        .collect(),
        rows: rows().map(row).collect(),
    }
}

/// One row an exercise of a participant, in the order of time.
pub fn participants(done: &[Done]) -> Table<'_> {
    type Get = for<'a> fn(&'a Done) -> Cell<'a>;
    const COLUMNS: [(&str, Sort, Get); 34] = [
        ("participant", Sort::Text, |d| Cell::text(d.participant())),
        ("exercise_started_utc", Sort::Text, |d| {
            Cell::text(&d.read.header.started_utc)
        }),
        ("scenario", Sort::Text, |d| {
            Cell::text(&d.read.header.scenario)
        }),
        ("observer", Sort::Text, |d| {
            Cell::text(d.read.header.observer.clone().unwrap_or_default())
        }),
        ("task", Sort::Text, |d| {
            Cell::text(d.read.trials.first().map_or("", |t| &t.task))
        }),
        ("ended", Sort::Text, |d| {
            Cell::text(d.read.ended.clone().unwrap_or_default())
        }),
        ("trials", Sort::Count, |d| {
            Cell::count(Some(d.analysis.score.trials))
        }),
        ("right", Sort::Count, |d| {
            Cell::count(Some(d.analysis.score.right))
        }),
        ("right_share", Sort::Number, |d| {
            Cell::number(d.analysis.score.right_share)
        }),
        ("chance", Sort::Number, |d| {
            Cell::number(d.analysis.score.chance)
        }),
        ("threshold_percent", Sort::Number, |d| {
            Cell::number(d.analysis.fit.as_ref().map(|f| f.threshold_percent))
        }),
        ("threshold_low_percent", Sort::Number, |d| {
            Cell::number(
                d.analysis
                    .fit
                    .as_ref()
                    .map(|f| f.threshold_interval_percent[0]),
            )
        }),
        ("threshold_high_percent", Sort::Number, |d| {
            Cell::number(
                d.analysis
                    .fit
                    .as_ref()
                    .map(|f| f.threshold_interval_percent[1]),
            )
        }),
        ("threshold_of", Sort::Text, |d| {
            Cell::text(d.analysis.fit.as_ref().map_or("", |f| &f.measure))
        }),
        ("threshold_at_share", Sort::Number, |d| {
            Cell::number(d.analysis.fit.as_ref().map(|f| f.target))
        }),
        ("weber_fraction", Sort::Number, |d| {
            Cell::number(d.analysis.fit.as_ref().map(|f| f.weber_fraction))
        }),
        ("d_prime", Sort::Number, |d| {
            Cell::number(d.analysis.d_prime.as_ref().map(|p| p.over_all))
        }),
        ("d_prime_per_log_ratio", Sort::Number, |d| {
            Cell::number(d.analysis.d_prime.as_ref().and_then(|p| p.per_log_ratio))
        }),
        ("mean_level_error", Sort::Number, |d| {
            Cell::number(d.analysis.score.levels)
        }),
        ("side_wrong_share", Sort::Number, |d| {
            Cell::number(d.analysis.score.side_wrong_share)
        }),
        ("mean_error_mm", Sort::Number, |d| {
            Cell::number(d.analysis.score.mm)
        }),
        ("kind_right_share", Sort::Number, |d| {
            Cell::number(d.analysis.score.kind_right_share)
        }),
        ("mean_severity_error", Sort::Number, |d| {
            Cell::number(d.analysis.score.severity)
        }),
        ("found", Sort::Count, |d| {
            Cell::count(Some(d.analysis.score.found))
        }),
        ("missed", Sort::Count, |d| {
            Cell::count(Some(d.analysis.score.missed))
        }),
        ("false_positives", Sort::Count, |d| {
            Cell::count(Some(d.analysis.score.false_positives))
        }),
        ("confidence_right_percent", Sort::Number, |d| {
            Cell::number(d.analysis.score.confidence_right_percent)
        }),
        ("confidence_wrong_percent", Sort::Number, |d| {
            Cell::number(d.analysis.score.confidence_wrong_percent)
        }),
        ("median_search_s", Sort::Number, |d| {
            Cell::number(d.analysis.score.search_s)
        }),
        ("mean_path_mm", Sort::Number, |d| {
            Cell::number(d.analysis.score.path_mm)
        }),
        ("mean_coverage", Sort::Number, |d| {
            Cell::number(d.analysis.score.coverage)
        }),
        ("peak_force_n", Sort::Number, |d| {
            Cell::number(d.analysis.score.peak_force_n)
        }),
        ("mean_force_n", Sort::Number, |d| {
            Cell::number(d.analysis.score.mean_force_n)
        }),
        ("tender_presses", Sort::Count, |d| {
            Cell::count(Some(d.analysis.score.tender_presses))
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
    let row = |d| COLUMNS.iter().map(|(_, _, get)| get(d)).collect();
    Table {
        heads: (COLUMNS
            .iter()
            .map(|(name, sort, _)| Head::new(*name, *sort)))
        .collect(),
        rows: sorted.into_iter().map(row).collect(),
    }
}
