//! Two groups: who is in them, and how far they are apart.

use super::measures::{self, Named, Share};
use crate::app::panels::PanelContext;
use crate::app::panels::lab::table::Tables;
use crate::app::state::Compared;
use crate::lab::{Table, Value};
use crate::study::METRICS;
use crate::study::groups::{Grouped, Row, grouped};
use crate::study::stats::Pairing;
use std::collections::BTreeSet;

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

    fn holds(&self, of: &Compared, told: &Named) -> bool {
        match self {
            Self::Tag(tag) => of.tags.contains(tag),
            Self::Participant(name) => told.1.analysis.about.participant.as_ref() == Some(name),
        }
    }
}

/// The two that are chosen, if they are two.
pub fn chosen(groups: &[Option<Group>; 2]) -> Option<[&Group; 2]> {
    match groups {
        [Some(a), Some(b)] if a != b => Some([a, b]),
        _ => None,
    }
}

/// Groups that could be made of them.
fn offers(told: &[(Compared, Named)]) -> Vec<Group> {
    let mut groups = BTreeSet::new();
    for (of, (_, told)) in told {
        groups.extend(of.tags.iter().cloned().map(Group::Tag));
        let participant = told.analysis.about.participant.clone();
        groups.extend(participant.map(Group::Participant));
    }
    groups.into_iter().collect()
}

/// The group of a recording in a report: that of the two it is in, the first where it is in both.
pub fn group_of(of: [&Group; 2], compared: &Compared, told: &Named) -> Option<String> {
    let found = of.into_iter().find(|g| g.holds(compared, told))?;
    Some(found.words().to_owned())
}

/// Two groups by every measure of a share of their recordings.
pub fn between(told: &[(Compared, Named)], of: [&Group; 2], share: Share) -> Grouped {
    let mut names = of.map(|g| g.words().to_owned());
    if names[0] == names[1] {
        // A tag that is called as a participant is.
        names[1] += " (2)";
    }
    let mut rows = Vec::new();
    for (group, name) in of.into_iter().zip(&names) {
        for (_, (_, t)) in told.iter().filter(|(c, n)| group.holds(c, n)) {
            // Groups are compared by what stands for the whole.
            let whole = share.of(&t.analysis).cloned().unwrap_or_default();
            rows.push(Row {
                whole,
                ..Row::of(&t.analysis, Some(name.clone()))
            });
        }
    }
    grouped(&rows, &names[0], &names[1])
}

fn table(of: &Grouped, edges_n: &[f64]) -> Table {
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
        of.names[0],
        of.names[1],
        match of.pairing {
            Pairing::Paired => "paired by participant",
            Pairing::Unpaired => "unpaired (Welch)",
        }
    );
    let mut table = Table::new("groups", title, &columns);
    for (measure, metric) in of.measures.iter().zip(METRICS) {
        let Some(d) = &measure.difference else {
            continue;
        };
        let interval = |[lo, hi]: [f64; 2]| Value::from(format!("{lo:.3} to {hi:.3}").as_str());
        let name = metric.title_at(edges_n);
        let mut row = vec![Value::from(&*name), Value::from(metric.unit)];
        for s in d.groups {
            row.extend([
                measures::number(Some(s.mean)),
                measures::number(Some(s.sd)),
                Value::from(s.n),
            ]);
        }
        row.extend([
            measures::number(Some(d.difference)),
            interval(d.difference_interval),
            measures::number(Some(d.g).filter(|_| d.has_g())),
            match d.has_g() {
                true => interval(d.g_interval),
                false => Value::Empty,
            },
        ]);
        table.push(row);
    }
    table
}

/// Chooses two groups and compares them.
pub fn ui(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    told: &[(Compared, Named)],
    groups: &mut [Option<Group>; 2],
    share: Share,
    tables: &mut Tables,
    number: u64,
) {
    let offers = offers(told);
    if told.len() < 2 || offers.len() < 2 {
        let what = "Groups are made by tags, such as before and after, or by participants: tag the recordings in the Sessions panel";
        ui.weak(what);
        return;
    }
    ui.horizontal_wrapped(|ui| {
        for (i, group) in groups.iter_mut().enumerate() {
            let name = format!("Group {}", i + 1);
            // A tag that was taken away makes no group any more.
            if group.as_ref().is_some_and(|g| !offers.contains(g)) {
                *group = None;
            }
            ui.label(&name);
            let text = group.as_ref().map_or("choose", Group::words).to_owned();
            let combo = egui::ComboBox::from_id_salt(&name)
                .selected_text(text)
                .width(140.0)
                .truncate()
                .show_ui(ui, |ui| {
                    for offer in &offers {
                        ui.selectable_value(group, Some(offer.clone()), offer.words());
                    }
                });
            let why = "Recordings with this tag, or of this participant";
            combo.response.on_hover_text(why).widget_info(|| {
                egui::WidgetInfo::labeled(egui::accesskit::Role::ComboBox, true, &name)
            });
        }
    });
    let Some(two) = chosen(groups) else {
        ui.weak("Choose two groups that differ");
        return;
    };
    let names: Vec<Named> = told.iter().map(|(_, n)| n.clone()).collect();
    let found = between(told, two, share);
    let table = table(&found, measures::edges_n(&names));
    if table.rows().is_empty() {
        ui.weak(
            "There is too little in these groups: each takes two recordings or more, of participants who count once each",
        );
        return;
    }
    let key = (
        "compare".to_owned(),
        format!("{} {}", table.title, share.words()),
    );
    // Tags change what is in a group while its name stays.
    let of_tags = told.iter().map(|(c, _)| c.tags.len() as u64).sum::<u64>();
    tables.show(
        ui,
        key,
        number + 1 + (of_tags << 32),
        &table,
        &cx.view.theme,
    );
    ui.weak(
        "A participant counts once in a group, by the mean of the sessions in it. Hedges’ g is the difference over the common standard deviation, corrected for few; intervals are of 95 %",
    );
}
