//! Comparisons as tables, for files.

use super::compare::{Comparison, Spread};
use super::groups::{Grouped, Row};
use super::metrics::{METRICS, Metrics};
use super::stats::Pairing;
use crate::table::{Cell, Head, Sort, Table};

fn text(name: &'static str) -> Head {
    Head::new(name, Sort::Text)
}

fn value(name: impl Into<std::borrow::Cow<'static, str>>) -> Head {
    Head::new(name, Sort::Number)
}

/// One row a recording, part (whole, search, palpation) and finger; of all fingers together without one.
pub fn measures(rows: &[Row]) -> Table<'_> {
    let heads = [
        "file",
        "participant",
        "group",
        "scenario",
        "started_utc",
        "force_bands_n",
        "part",
    ]
    .map(text);
    let finger = Head::new("finger", Sort::Count).about("Finger, from 0; absent: all together.");
    let metrics = METRICS
        .iter()
        .map(|m| value(m.key).unit(m.unit).about(m.about));
    let parts = |row| {
        let Row {
            whole,
            search,
            palpation,
            fingers,
            ..
        }: &Row = row;
        let all = [(None, [whole, search, palpation])].into_iter();
        let each = fingers
            .iter()
            .map(|f| (Some(f.finger), [&f.whole, &f.search, &f.palpation]));
        all.chain(each).flat_map(|(finger, of)| {
            let named = ["whole", "search", "palpation"].into_iter().zip(of);
            named.map(move |(part, metrics)| (part, finger, metrics))
        })
    };
    let optional = |text: &Option<String>| Cell::Text(text.clone().map(Into::into));
    let cells = |row, (part, finger, metrics): (&'static str, Option<u8>, &Metrics)| {
        let Row {
            about,
            group,
            force_bands_n,
            ..
        }: &Row = row;
        let bands: Vec<String> = force_bands_n.iter().map(f64::to_string).collect();
        let mut cells = vec![
            Cell::text(about.file.display().to_string()),
            optional(&about.participant),
            optional(group),
            Cell::text(about.scenario.clone()),
            Cell::text(about.started_utc.clone()),
            Cell::text(bands.join("; ")),
            Cell::text(part),
            Cell::count(finger),
        ];
        cells.extend(METRICS.iter().map(|m| Cell::number((m.get)(metrics))));
        cells
    };
    Table {
        heads: heads.into_iter().chain([finger]).chain(metrics).collect(),
        rows: rows
            .iter()
            .flat_map(|row| parts(row).map(move |part| cells(row, part)))
            .collect(),
    }
}

/// One row a comparison and quantity.
pub fn comparisons(comparisons: &[Comparison]) -> Table<'static> {
    let names = ["first", "second", "aligned", "quantity"].map(text);
    let values = ["rms", "mean", "max", "max_at_s", "shift_s", "overlap_s"].map(value);
    let counts = ["finger", "pairs", "identical"].map(|name| Head::new(name, Sort::Count));
    let row = |c: &Comparison, quantity: &'static str, s: &Spread| {
        vec![
            Cell::text(c.names[0].clone()),
            Cell::text(c.names[1].clone()),
            Cell::text(c.aligned.clone()),
            Cell::text(quantity),
            Cell::number(Some(s.rms)),
            Cell::number(Some(s.mean)),
            Cell::number(Some(s.max)),
            Cell::number(Some(s.max_at_s)),
            Cell::number(Some(c.shift_s)),
            Cell::number(Some(c.overlap_s)),
            Cell::count(Some(c.finger)),
            Cell::natural(c.pairs),
            Cell::Count(c.identical.and_then(|n| i64::try_from(n).ok())),
        ]
    };
    let of = |c: &Comparison| {
        [
            row(c, "position_mm", &c.position_mm),
            row(c, "force_n", &c.force_n),
            row(c, "depth_mm", &c.depth_mm),
        ]
    };
    Table {
        heads: names.into_iter().chain(values).chain(counts).collect(),
        rows: comparisons.iter().flat_map(of).collect(),
    }
}

/// Differences over time: one row a comparison and bin.
pub fn series(comparisons: &[Comparison]) -> Table<'static> {
    let values = [
        "time_s",
        "position_mm",
        "force_n",
        "depth_mm",
        "position_max_mm",
        "force_max_n",
        "depth_max_mm",
    ];
    let rows = comparisons.iter().flat_map(|c| {
        let s = &c.series;
        (0..s.time_s.len()).map(move |i| {
            let of = [
                &s.time_s,
                &s.position_mm,
                &s.force_n,
                &s.depth_mm,
                &s.position_max_mm,
                &s.force_max_n,
                &s.depth_max_mm,
            ];
            let mut cells = vec![
                Cell::text(c.names[0].clone()),
                Cell::text(c.names[1].clone()),
            ];
            cells.extend(of.iter().map(|values| Cell::number(values.get(i).copied())));
            cells
        })
    });
    Table {
        heads: ["first", "second"]
            .map(text)
            .into_iter()
            .chain(values.map(value))
            .collect(),
        rows: rows.collect(),
    }
}

/// Groups: one row a pair of groups and measure.
pub fn groups(groups: &[Grouped]) -> Table<'static> {
    let names = ["first", "second", "pairing", "measure"].map(text);
    let values = [
        "first_mean",
        "first_sd",
        "second_mean",
        "second_sd",
        "difference",
        "difference_low",
        "difference_high",
        "df",
        "d",
        "g",
        "g_low",
        "g_high",
        "bias",
        "limit_low",
        "limit_high",
        "icc_2_1",
        "icc_2_1_low",
        "icc_2_1_high",
        "icc_3_1",
        "icc_3_1_low",
        "icc_3_1_high",
    ];
    let counts = ["first_n", "second_n"].map(|name| Head::new(name, Sort::Count));
    let rows = groups.iter().flat_map(|grouped| {
        grouped.measures.iter().map(move |m| {
            let pairing = match grouped.pairing {
                Pairing::Paired => "paired",
                Pairing::Unpaired => "unpaired",
            };
            let mut cells = vec![
                Cell::text(grouped.names[0].clone()),
                Cell::text(grouped.names[1].clone()),
                Cell::text(pairing),
                Cell::text(m.key.clone()),
            ];
            let d = m.difference.as_ref();
            let a = m.agreement.as_ref();
            let icc = |i: usize| m.icc.get(i);
            let numbers = [
                d.map(|d| d.groups[0].mean),
                d.map(|d| d.groups[0].sd),
                d.map(|d| d.groups[1].mean),
                d.map(|d| d.groups[1].sd),
                d.map(|d| d.difference),
                d.map(|d| d.difference_interval[0]),
                d.map(|d| d.difference_interval[1]),
                d.map(|d| d.df),
                d.map(|d| d.d),
                d.filter(|d| d.has_g()).map(|d| d.g),
                d.filter(|d| d.has_g()).map(|d| d.g_interval[0]),
                d.filter(|d| d.has_g()).map(|d| d.g_interval[1]),
                a.map(|a| a.bias),
                a.map(|a| a.limits[0]),
                a.map(|a| a.limits[1]),
                icc(0).map(|i| i.value),
                icc(0).map(|i| i.interval[0]),
                icc(0).map(|i| i.interval[1]),
                icc(1).map(|i| i.value),
                icc(1).map(|i| i.interval[0]),
                icc(1).map(|i| i.interval[1]),
            ];
            cells.extend(numbers.into_iter().map(Cell::number));
            let n = |i: usize| d.and_then(|d| i64::try_from(d.groups[i].n).ok());
            cells.extend([Cell::Count(n(0)), Cell::Count(n(1))]);
            cells
        })
    });
    Table {
        heads: names
            .into_iter()
            .chain(values.map(value))
            .chain(counts)
            .collect(),
        rows: rows.collect(),
    }
}
