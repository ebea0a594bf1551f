//! Tables: measures side by side, the stiffness felt at sites, groups.

use super::work::Told;
use crate::app::widgets::named;
use crate::lab::{Table, Value};
use crate::study::{self, Analysis, Felt, METRICS, Metric, Metrics};
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
}

/// Which share of a recording is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Share {
    /// Which part of its time.
    pub part: Part,
    /// Which finger, from 0; all together without one.
    pub finger: Option<u8>,
}

impl Share {
    /// In words, such as "Palpation, right finger".
    pub fn words(self) -> String {
        let finger = self.finger.map_or("all fingers".into(), |finger| {
            study::finger_name(finger).to_lowercase()
        });
        format!("{}, {finger}", self.part.words())
    }

    /// The measures of that share; `None` where there is no such finger.
    pub fn of(self, analysis: &Analysis) -> Option<&Metrics> {
        let Some(finger) = self.finger else {
            return Some(match self.part {
                Part::Whole => &analysis.whole,
                Part::Search => &analysis.search,
                Part::Palpation => &analysis.palpation,
            });
        };
        let found = analysis.fingers.iter().find(|f| f.finger == finger)?;
        Some(match self.part {
            Part::Whole => &found.whole,
            Part::Search => &found.search,
            Part::Palpation => &found.palpation,
        })
    }

    /// To choose it: parts, and as many fingers as there are in one of the recordings.
    pub fn ui(&mut self, ui: &mut egui::Ui, told: &[Named]) {
        let fingers = told.iter().map(|(_, t)| t.analysis.fingers.len());
        let most = fingers.max().unwrap_or(0) as u8;
        ui.horizontal_wrapped(|ui| {
            for part in Part::ALL {
                let on = self.part == part;
                let label = ui
                    .selectable_label(on, part.words())
                    .on_hover_text("Which part of each recording is measured");
                if label.clicked() {
                    self.part = part;
                }
            }
            ui.separator();
            let all = [(None, "All fingers")].into_iter();
            let each = (0..most).map(|i| (Some(i), study::finger_name(i)));
            for (finger, name) in all.chain(each) {
                let on = self.finger == finger;
                let label = ui.selectable_label(on, name).on_hover_text(
                    "Whose measures they are; of all together times and counts are sums",
                );
                named(ui, &label, &format!("Measures of {}", name.to_lowercase()));
                if label.clicked() {
                    self.finger = finger;
                }
            }
        });
    }
}

/// A recording in the tables: what it is called, and what it told.
pub type Named = (String, Arc<Told>);

/// A cell with a number, empty where there is none.
pub fn number(x: Option<f64>) -> Value {
    x.filter(|x| x.is_finite())
        .map_or(Value::Empty, Value::from)
}

/// Edges of the bands of force of the first; all are analysed alike.
pub fn edges_n(told: &[Named]) -> &[f64] {
    told.first().map_or(&[], |(_, t)| &t.analysis.force_bands_n)
}

/// One row for each measure, one column for each recording with the seconds that it lasted; of two the difference too.
pub fn side_by_side(told: &[Named], share: Share) -> Table {
    let lasted = |t: &Arc<Told>| share.of(&t.analysis).map_or(0.0, |m| m.duration_s);
    let headings: Vec<String> = (told.iter())
        .map(|(name, t)| format!("{name} ({:.1} s)", lasted(t)))
        .collect();
    let mut columns = vec!["measure", "unit"];
    columns.extend(headings.iter().map(String::as_str));
    if told.len() == 2 {
        columns.push("B − A");
    }
    let title = format!("Measures: {}", share.words().to_lowercase());
    let mut table = Table::new("measures", title, &columns);
    for metric in METRICS {
        let values: Vec<Option<f64>> = (told.iter())
            .map(|(_, t)| (metric.get)(share.of(&t.analysis)?))
            .collect();
        if values.iter().all(Option::is_none) {
            continue;
        }
        let name = metric.title_at(edges_n(told));
        let mut row = vec![Value::from(&*name), Value::from(metric.unit)];
        row.extend(values.iter().map(|v| number(*v)));
        if let [a, b] = values[..] {
            row.push(number(a.zip(b).map(|(a, b)| b - a)));
        }
        table.push(row);
    }
    table
}

/// The stiffness felt at each site that was pressed in one of them, by a finger or by all.
pub fn felt(told: &[Named], finger: Option<u8>) -> Option<Table> {
    let felt = |t: &'_ Arc<Told>| -> Vec<Felt> {
        let analysis = &t.analysis;
        match finger {
            None => analysis.felt.clone(),
            Some(finger) => {
                let mut found = analysis.fingers.iter().filter(|f| f.finger == finger);
                found.next().map_or(Vec::new(), |f| f.felt.clone())
            }
        }
    };
    let felt: Vec<Vec<Felt>> = told.iter().map(|(_, t)| felt(t)).collect();
    let sites: BTreeSet<&str> = (felt.iter().flatten()).map(|f| f.site.as_str()).collect();
    if sites.is_empty() {
        return None;
    }
    let headings: Vec<String> = (told.iter())
        .flat_map(|(name, _)| [format!("{name} (N/mm)"), format!("{name}, 95 %")])
        .collect();
    let mut columns = vec!["site"];
    columns.extend(headings.iter().map(String::as_str));
    let whose = finger.map_or(String::new(), |finger| {
        format!(": {}", study::finger_name(finger).to_lowercase())
    });
    let title = format!("Stiffness felt where it was pressed{whose}");
    let mut table = Table::new("stiffness", title, &columns);
    for site in sites {
        let mut row = vec![Value::from(site)];
        for felt in &felt {
            let felt = felt.iter().find(|f| f.site == site);
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

/// The measure with this key, or the first.
pub fn metric(key: &str) -> &'static Metric {
    METRICS.iter().find(|m| m.key == key).unwrap_or(&METRICS[0])
}
