//! Many sessions beside each other: groups, and how a participant learns.

use super::metrics::{METRICS, Metric, Metrics};
use super::stats::{
    BlandAltman, GroupDifference, Icc, IccForm, Pairing, bland_altman, icc, paired, unpaired,
};
use super::{About, Analysis, Felt, FingerAnalysis};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What of a session is kept where there are many.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// What was recorded.
    pub about: About,
    /// The group it is in.
    pub group: Option<String>,
    /// All fingers together, all of the time.
    pub whole: Metrics,
    /// While they searched.
    pub search: Metrics,
    /// While they palpated.
    pub palpation: Metrics,
    /// Each finger, in order.
    #[serde(default)]
    pub fingers: Vec<FingerRow>,
    /// Edges of the bands that [`Metrics::band_s`] goes by, N.
    #[serde(default)]
    pub force_bands_n: Vec<f64>,
    /// The stiffness felt.
    pub felt: Vec<Felt>,
}

/// What of a finger is kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FingerRow {
    /// Which, from 0.
    pub finger: u8,
    /// All of the time.
    pub whole: Metrics,
    /// While it searched.
    pub search: Metrics,
    /// While it palpated.
    pub palpation: Metrics,
}

impl FingerRow {
    fn of(finger: &FingerAnalysis) -> Self {
        Self {
            finger: finger.finger,
            whole: finger.whole.clone(),
            search: finger.search.clone(),
            palpation: finger.palpation.clone(),
        }
    }
}

impl Row {
    /// Of a session in a group.
    pub fn of(analysis: &Analysis, group: Option<String>) -> Self {
        Self {
            about: analysis.about.clone(),
            group,
            whole: analysis.whole.clone(),
            search: analysis.search.clone(),
            palpation: analysis.palpation.clone(),
            fingers: analysis.fingers.iter().map(FingerRow::of).collect(),
            force_bands_n: analysis.force_bands_n.clone(),
            felt: analysis.felt.clone(),
        }
    }

    /// Whose session it is: the participant, or the file where nobody is named.
    fn who(&self) -> String {
        let named = self.about.participant.clone();
        named.unwrap_or_else(|| self.about.file.display().to_string())
    }
}

/// Two groups by every measure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grouped {
    /// First and second; differences are second less first.
    pub names: [String; 2],
    /// Paired where at least two participants are in both: only those then count. Else unpaired.
    pub pairing: Pairing,
    /// Participants that count, of each group.
    pub participants: [usize; 2],
    /// In the order of [`METRICS`].
    pub measures: Vec<GroupedMeasure>,
}

/// Two groups by one measure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GroupedMeasure {
    /// Key of the measure.
    pub key: String,
    /// Difference and effect size; absent where too few have the measure, or where it does not vary.
    pub difference: Option<GroupDifference>,
    /// Agreement of first and second, of paired groups.
    pub agreement: Option<BlandAltman>,
    /// Intraclass correlations of first and second, of paired groups: ICC(2,1) for absolute agreement and ICC(3,1) for
    /// consistency.
    pub icc: Vec<Icc>,
}

/// Compares two groups by every measure of whole sessions. A participant counts once in a group, by the mean of her sessions
/// in it; sessions without a participant count one by one.
pub fn grouped(rows: &[Row], first: &str, second: &str) -> Grouped {
    let means = |group: &str, metric: &Metric| -> BTreeMap<String, f64> {
        let mut sums: BTreeMap<String, (f64, f64)> = BTreeMap::new();
        for row in rows.iter().filter(|r| r.group.as_deref() == Some(group)) {
            let value = (metric.get)(&row.whole).filter(|x| x.is_finite());
            if let Some(value) = value {
                let sum = sums.entry(row.who()).or_default();
                *sum = (sum.0 + value, sum.1 + 1.0);
            }
        }
        sums.into_iter()
            .map(|(who, (sum, n))| (who, sum / n))
            .collect()
    };
    let who = |group: &str| -> std::collections::BTreeSet<String> {
        let inside = rows.iter().filter(|r| r.group.as_deref() == Some(group));
        inside.map(Row::who).collect()
    };
    let (a, b) = (who(first), who(second));
    let both = a.intersection(&b).count();
    let pairing = if both >= 2 {
        Pairing::Paired
    } else {
        Pairing::Unpaired
    };
    let measures = METRICS.iter().map(|metric| {
        let (a, b) = (means(first, metric), means(second, metric));
        let key = metric.key.to_owned();
        if pairing == Pairing::Unpaired {
            let values = |means: BTreeMap<String, f64>| means.into_values().collect::<Vec<f64>>();
            return GroupedMeasure {
                key,
                difference: unpaired(&values(a), &values(b)),
                agreement: None,
                icc: Vec::new(),
            };
        }
        let pairs: Vec<[f64; 2]> = a
            .iter()
            .filter_map(|(who, x)| Some([*x, *b.get(who)?]))
            .collect();
        let table: Vec<Vec<f64>> = pairs.iter().map(|p| p.to_vec()).collect();
        let forms = [IccForm::TwoSingle, IccForm::ThreeSingle];
        GroupedMeasure {
            key,
            difference: paired(&pairs),
            agreement: bland_altman(pairs.iter().copied()),
            icc: forms
                .into_iter()
                .filter_map(|form| icc(&table, form))
                .collect(),
        }
    });
    Grouped {
        names: [first.to_owned(), second.to_owned()],
        pairing,
        participants: match pairing {
            Pairing::Paired => [both; 2],
            Pairing::Unpaired => [a.len(), b.len()],
        },
        measures: measures.collect(),
    }
}

/// A measure of one participant from session to session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Pseudonym.
    pub participant: String,
    /// Number of the session in the order of time, from 1, and the measure.
    pub points: Vec<[f64; 2]>,
}

/// Learning curves of those participants who have at least two sessions.
pub fn learning(rows: &[Row], metric: &Metric) -> Vec<Curve> {
    let mut by: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
    for row in rows {
        if let Some(participant) = &row.about.participant {
            by.entry(participant).or_default().push(row);
        }
    }
    let many = by.into_iter().filter(|(_, rows)| rows.len() > 1);
    let curve = |(participant, mut rows): (&str, Vec<&Row>)| {
        rows.sort_by(|a, b| a.about.started_utc.cmp(&b.about.started_utc));
        let points = rows.iter().enumerate();
        let points =
            points.filter_map(|(i, row)| Some([(i + 1) as f64, (metric.get)(&row.whole)?]));
        Curve {
            participant: participant.to_owned(),
            points: points.collect(),
        }
    };
    many.map(curve).filter(|c| c.points.len() > 1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(participant: Option<&str>, group: &str, day: u32, peak_force_n: f64) -> Row {
        Row {
            about: About {
                file: format!("{group}{day}.mcap").into(),
                participant: participant.map(str::to_owned),
                started_utc: format!("2031-05-{day:02}T09:30:00Z"),
                ..About::default()
            },
            group: Some(group.to_owned()),
            whole: Metrics {
                peak_force_n,
                ..Metrics::default()
            },
            search: Metrics::default(),
            palpation: Metrics::default(),
            fingers: Vec::new(),
            force_bands_n: Vec::new(),
            felt: Vec::new(),
        }
    }

    fn measure<'a>(grouped: &'a Grouped, key: &str) -> &'a GroupedMeasure {
        grouped
            .measures
            .iter()
            .find(|m| m.key == key)
            .expect("the measure")
    }

    #[test]
    fn participants_in_both_groups_are_paired_and_count_once() {
        let rows = [
            row(Some("P1"), "before", 1, 4.0),
            row(Some("P1"), "before", 2, 6.0),
            row(Some("P2"), "before", 1, 3.0),
            row(Some("P3"), "before", 1, 9.0),
            row(Some("P1"), "after", 3, 4.0),
            row(Some("P2"), "after", 3, 1.0),
        ];
        let told = grouped(&rows, "before", "after");
        assert_eq!((told.pairing, told.participants), (Pairing::Paired, [2, 2]));
        let force = measure(&told, "peak_force_n");
        let difference = force.difference.as_ref().expect("told");
        assert_eq!(
            (difference.difference, difference.groups[0].mean),
            (-1.5, 4.0)
        );
        assert_eq!(force.agreement.as_ref().map(|a| a.bias), Some(-1.5));
        assert_eq!(
            force.icc.iter().map(|i| i.form.name()).collect::<Vec<_>>(),
            ["ICC(2,1)", "ICC(3,1)"]
        );
        // What does not vary tells nothing.
        assert_eq!(measure(&told, "contact_s").difference, None);
        let curves = learning(
            &rows,
            super::super::metrics::by_key("peak_force_n").expect("one"),
        );
        assert_eq!(curves.len(), 2);
        assert_eq!(curves[0].points, [[1.0, 4.0], [2.0, 6.0], [3.0, 4.0]]);
    }

    #[test]
    fn others_are_not_paired() {
        let rows = [
            row(Some("N1"), "novice", 1, 4.0),
            row(None, "novice", 2, 6.0),
            row(None, "novice", 3, 5.0),
            row(Some("E1"), "expert", 1, 9.0),
            row(Some("E2"), "expert", 1, 8.0),
        ];
        let told = grouped(&rows, "novice", "expert");
        assert_eq!(
            (told.pairing, told.participants),
            (Pairing::Unpaired, [3, 2])
        );
        let difference = measure(&told, "peak_force_n")
            .difference
            .as_ref()
            .expect("told");
        assert_eq!((difference.difference, difference.groups[0].n), (3.5, 3));
        assert!(measure(&told, "sparc").difference.is_none());
    }
}
