//! Tables: measures side by side, the stiffness felt at sites, groups.

use super::work::Told;
use crate::app::state::Compared;
use crate::lab::{Table, Value};
use crate::study::stats::{paired, unpaired};
use crate::study::{Analysis, METRICS, Metric, Metrics};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Which part of a recording is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Part {
    /// All of it.
    #[default]
    Whole,
    /// While the fingers searched.
    Search,
    /// While they palpated.
    Palpation,
}

impl Part {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Whole, Self::Search, Self::Palpation];

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Whole => "Whole session",
            Self::Search => "Search",
            Self::Palpation => "Palpation",
        }
    }

    /// The measures of that part.
    pub fn of(self, analysis: &Analysis) -> &Metrics {
        match self {
            Self::Whole => &analysis.whole,
            Self::Search => &analysis.search,
            Self::Palpation => &analysis.palpation,
        }
    }
}

/// A recording in the tables: what it is called, and what it told.
pub type Named = (String, Arc<Told>);

fn number(x: Option<f64>) -> Value {
    x.filter(|x| x.is_finite())
        .map_or(Value::Empty, Value::from)
}

/// One row for each measure, one column for each recording; of two the difference too.
pub fn side_by_side(told: &[Named], part: Part) -> Table {
    let mut columns = vec!["measure", "unit"];
    columns.extend(told.iter().map(|(name, _)| name.as_str()));
    if told.len() == 2 {
        columns.push("B − A");
    }
    let title = format!("Measures: {}", part.words().to_lowercase());
    let mut table = Table::new("measures", title, &columns);
    for metric in METRICS {
        let values: Vec<Option<f64>> = (told.iter())
            .map(|(_, t)| (metric.get)(part.of(&t.analysis)))
            .collect();
        if values.iter().all(Option::is_none) {
            continue;
        }
        let mut row = vec![Value::from(metric.title), Value::from(metric.unit)];
        row.extend(values.iter().map(|v| number(*v)));
        if let [a, b] = values[..] {
            row.push(number(a.zip(b).map(|(a, b)| b - a)));
        }
        table.push(row);
    }
    table
}

/// The stiffness felt at each site that was pressed in one of them.
pub fn felt(told: &[Named]) -> Option<Table> {
    let sites: BTreeSet<&str> = (told.iter())
        .flat_map(|(_, t)| t.analysis.felt.iter().map(|f| f.site.as_str()))
        .collect();
    if sites.is_empty() {
        return None;
    }
    let headings: Vec<String> = (told.iter())
        .flat_map(|(name, _)| [format!("{name} (N/mm)"), format!("{name}, 95 %")])
        .collect();
    let mut columns = vec!["site"];
    columns.extend(headings.iter().map(String::as_str));
    let mut table = Table::new("stiffness", "Stiffness felt where it was pressed", &columns);
    for site in sites {
        let mut row = vec![Value::from(site)];
        for (_, t) in told {
            let felt = t.analysis.felt.iter().find(|f| f.site == site);
            row.push(number(felt.map(|f| f.slope_n_per_mm)));
            let interval = felt.and_then(|f| f.interval_n_per_mm);
            row.push(interval.map_or(Value::Empty, |[lo, hi]| {
                Value::from(format!("{lo:.3} to {hi:.3}").as_str())
            }));
        }
        table.push(row);
    }
    Some(table)
}

/// Who is in a group.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// Recordings with this tag.
    Tag(String),
    /// Recordings of this participant.
    Participant(String),
}

impl Group {
    /// In words.
    pub fn words(&self) -> &str {
        match self {
            Self::Tag(name) | Self::Participant(name) => name,
        }
    }

    fn holds(&self, of: &Compared, told: &Told) -> bool {
        match self {
            Self::Tag(tag) => of.tags.contains(tag),
            Self::Participant(name) => told.analysis.about.participant.as_ref() == Some(name),
        }
    }
}

/// Groups that could be made of them.
pub fn groups(told: &[(Compared, Arc<Told>)]) -> Vec<Group> {
    let mut groups = BTreeSet::new();
    for (of, told) in told {
        groups.extend(of.tags.iter().cloned().map(Group::Tag));
        let participant = told.analysis.about.participant.clone();
        groups.extend(participant.map(Group::Participant));
    }
    groups.into_iter().collect()
}

/// Two groups, measure by measure: means, difference with its interval, effect size with its own. Where every participant of
/// one group is in the other too they are compared with themselves.
pub fn between(told: &[(Compared, Arc<Told>)], of: [&Group; 2], part: Part) -> Table {
    let members = |group: &Group| -> Vec<&Arc<Told>> {
        told.iter()
            .filter(|(c, t)| group.holds(c, t))
            .map(|(_, t)| t)
            .collect()
    };
    let [first, second] = of.map(members);
    let pairs = partners(&first, &second);
    let columns = [
        "measure",
        "unit",
        "mean 1",
        "SD 1",
        "n 1",
        "mean 2",
        "SD 2",
        "n 2",
        "difference",
        "95 %",
        "Hedges g",
        "g, 95 %",
    ];
    let title = format!(
        "{} (1) against {} (2), {}",
        of[0].words(),
        of[1].words(),
        match pairs {
            Some(_) => "the same participants: paired",
            None => "unpaired (Welch)",
        }
    );
    let mut table = Table::new("groups", title, &columns);
    for metric in METRICS {
        let value = |t: &Arc<Told>| (metric.get)(part.of(&t.analysis));
        let difference = match &pairs {
            Some(pairs) => {
                let both = pairs
                    .iter()
                    .filter_map(|[a, b]| Some([value(a)?, value(b)?]));
                paired(&both.collect::<Vec<_>>())
            }
            None => {
                let of = |group: &[&Arc<Told>]| group.iter().filter_map(|t| value(t)).collect();
                let (a, b): (Vec<f64>, Vec<f64>) = (of(&first), of(&second));
                unpaired(&a, &b)
            }
        };
        let Some(d) = difference else { continue };
        let interval = |[lo, hi]: [f64; 2]| Value::from(format!("{lo:.3} to {hi:.3}").as_str());
        let mut row = vec![Value::from(metric.title), Value::from(metric.unit)];
        for s in d.groups {
            row.extend([number(Some(s.mean)), number(Some(s.sd)), Value::from(s.n)]);
        }
        row.extend([
            number(Some(d.difference)),
            interval(d.difference_interval),
            number(Some(d.g)),
            interval(d.g_interval),
        ]);
        table.push(row);
    }
    table
}

/// The recordings of each participant in both groups, where each has exactly one in either.
fn partners<'a>(
    first: &[&'a Arc<Told>],
    second: &[&'a Arc<Told>],
) -> Option<Vec<[&'a Arc<Told>; 2]>> {
    let who = |t: &Arc<Told>| t.analysis.about.participant.clone();
    if first.len() != second.len() || first.is_empty() {
        return None;
    }
    first
        .iter()
        .map(|a| {
            let name = who(a)?;
            let alone = first
                .iter()
                .filter(|t| who(t).as_ref() == Some(&name))
                .count()
                == 1;
            let mut others = second.iter().filter(|t| who(t).as_ref() == Some(&name));
            let other = others.next()?;
            (alone && others.next().is_none()).then_some([*a, *other])
        })
        .collect()
}

/// The measure with this key, or the first.
pub fn metric(key: &str) -> &'static Metric {
    METRICS.iter().find(|m| m.key == key).unwrap_or(&METRICS[0])
}
