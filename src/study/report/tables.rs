//! The tables of a report.

use crate::study::compare::{Comparison, Spread};
use crate::study::groups::{FingerRow, Grouped, Row};
use crate::study::metrics::{METRICS, Metric, Metrics};
use crate::study::stats::Pairing;
use crate::study::{Felt, finger_name};
use maud::{Markup, html};

/// Recordings that fit beside each other as columns.
const MOST_COLUMNS: usize = 8;

/// A number with about four digits that count.
pub(super) fn number(x: Option<f64>) -> String {
    let Some(x) = x.filter(|x| x.is_finite()) else {
        return "–".to_owned();
    };
    let text = match x.abs() {
        _ if x == x.round() && x.abs() < 1e6 => format!("{x:.0}"),
        ..0.001 => format!("{x:.2e}"),
        ..1.0 => format!("{x:.4}"),
        ..10.0 => format!("{x:.3}"),
        ..100.0 => format!("{x:.2}"),
        ..1000.0 => format!("{x:.1}"),
        _ => format!("{x:.0}"),
    };
    text.replace('-', "\u{2212}")
}

/// A number with two decimals; what rounds to nothing has no sign.
fn two(x: f64) -> String {
    let x = if x.abs() < 0.005 { 0.0 } else { x };
    format!("{x:.2}").replace('-', "\u{2212}")
}

fn interval([low, high]: [f64; 2]) -> String {
    format!("{} to {}", number(Some(low)), number(Some(high)))
}

pub(super) fn recordings(rows: &[Row]) -> Markup {
    let grouped = rows.iter().any(|r| r.group.is_some());
    html! {
        div.wide { table {
            thead { tr {
                th.text { "File" } th.text { "Participant" } @if grouped { th.text { "Group" } }
                th.text { "Scenario" } th.text { "Started (UTC)" } th.text { "Devices" } th { "Duration (s)" } th { "Rate (Hz)" } th { "Lost ticks" }
            } }
            tbody { @for row in rows { tr {
                td.text { (row.about.name()) }
                td.text { (row.about.participant.as_deref().unwrap_or("–")) }
                @if grouped { td.text { (row.group.as_deref().unwrap_or("–")) } }
                td.text { (row.about.scenario) }
                td.text { (row.about.started_utc.chars().take(16).collect::<String>().replace('T', " ")) }
                td.text { (row.about.devices.join(", ")) }
                td { (number(Some(row.about.seconds))) }
                td { (number(Some(row.about.rate_hz))) }
                td { (row.about.lost) }
            } } }
        } }
    }
}

/// The measures of each recording in a part, where it has any.
type Part<'a> = (String, Vec<Option<&'a Metrics>>);

/// A name, and how measures are read from a row or a finger of it.
type Reader<T> = (&'static str, fn(&T) -> &Metrics);

/// All fingers together, then each where there is more than one.
fn parts(rows: &[Row]) -> Vec<Part<'_>> {
    let all: [Reader<Row>; 3] = [
        ("Whole session, all fingers", |r| &r.whole),
        ("Search, all fingers", |r| &r.search),
        ("Palpation, all fingers", |r| &r.palpation),
    ];
    let mut parts: Vec<Part<'_>> = all
        .into_iter()
        .map(|(name, of)| (name.to_owned(), rows.iter().map(|r| Some(of(r))).collect()))
        .collect();
    let most = rows.iter().map(|r| r.fingers.len()).max().unwrap_or(0);
    let each: [Reader<FingerRow>; 3] = [
        ("whole session", |f| &f.whole),
        ("search", |f| &f.search),
        ("palpation", |f| &f.palpation),
    ];
    for finger in (0..most).filter(|_| most > 1) {
        for (name, of) in each {
            let values = rows.iter().map(|r| r.fingers.get(finger).map(of));
            parts.push((
                format!("{}, {name}", finger_name(finger as u8)),
                values.collect(),
            ));
        }
    }
    parts.retain(|(_, of)| of.iter().flatten().any(|m| m.duration_s > 0.0));
    parts
}

/// Measures as rows where few recordings fit as columns; else the recordings as rows.
pub(super) fn measures(rows: &[Row]) -> Markup {
    let edges_n = super::edges_n(rows);
    if rows.len() > MOST_COLUMNS {
        return html! {
            div.wide { table {
                thead { tr { th.text { "File" } @for m in METRICS { th title=(m.about) { (m.heading_at(edges_n)) } } } }
                tbody { @for row in rows { tr {
                    td.text { (row.about.name()) }
                    @for m in METRICS { td { (number((m.get)(&row.whole))) } }
                } } }
            } }
        };
    }
    html! {
        @for (i, (part, of)) in parts(rows).iter().enumerate() {
            @let get = |m: &Metric, k: usize| of[k].and_then(m.get);
            details open[i == 0] {
                summary { (part) }
                div.wide { table {
                    thead { tr { th.text { "Measure" } @for row in rows { th { (row.about.name()) } } } }
                    tbody { @for m in METRICS.iter().filter(|m| (0..rows.len()).any(|k| get(m, k).is_some())) { tr {
                        td.text title=(m.about) { (m.heading_at(edges_n)) }
                        @for k in 0..rows.len() { td { (number(get(m, k))) } }
                    } } }
                } }
            }
        }
    }
}

/// The stiffness at each site, recording beside recording.
pub(super) fn felt(rows: &[Row]) -> Markup {
    let shown = &rows[..rows.len().min(MOST_COLUMNS)];
    let mut sites: Vec<&str> = Vec::new();
    for felt in shown.iter().flat_map(|r| &r.felt) {
        if !sites.contains(&felt.site.as_str()) {
            sites.push(&felt.site);
        }
    }
    html! {
        div.wide { table {
            thead { tr { th.text { "Site" } @for row in shown { th { (row.about.name()) } } } }
            tbody { @for site in &sites { tr {
                td.text { (site) }
                @for row in shown {
                    @let felt = row.felt.iter().find(|f| f.site == **site);
                    td title=[felt.map(presses)] {
                        (number(felt.map(|f| f.slope_n_per_mm)))
                        @if let Some(range) = felt.and_then(|f| f.interval_n_per_mm) { small { (interval(range)) } }
                    }
                }
            } } }
        } }
        @if rows.len() > shown.len() { p.about { "The first " (shown.len()) " recordings." } }
    }
}

fn presses(felt: &Felt) -> String {
    let n = felt.presses;
    let word = if n == 1 { "press" } else { "presses" };
    match felt.r_squared {
        Some(r) => format!("{n} {word}, R² {r:.4}"),
        None => format!("{n} {word}"),
    }
}

pub(super) fn spreads(comparisons: &[Comparison]) -> Markup {
    let cells = |s: &Spread| {
        html! {
            td { (number(Some(s.rms))) } td { (number(Some(s.mean))) } td { (number(Some(s.max))) }
            td { (number(Some(s.max_at_s))) }
        }
    };
    html! {
        div.wide { table {
            thead { tr {
                th.text { "Second" } th.text { "Quantity" } th { "RMS" } th { "Mean" } th { "Greatest" } th { "at (s)" }
                th { "Pairs" } th { "Shift (s)" } th { "Alike bit for bit" }
            } }
            tbody { @for c in comparisons {
                @for (i, (what, spread)) in [("distance (mm)", &c.position_mm), ("force (N)", &c.force_n), ("depth (mm)", &c.depth_mm)].into_iter().enumerate() { tr {
                    td.text { @if i == 0 { (c.names[1]) } }
                    td.text { (what) }
                    (cells(spread))
                    @if i == 0 {
                        td { (c.pairs) }
                        td { (number(Some(c.shift_s))) }
                        td { (c.identical.map_or("–".to_owned(), |n| n.to_string())) }
                    } @else { td {} td {} td {} }
                } }
            } }
        } }
    }
}

pub(super) fn grouped(grouped: &Grouped, edges_n: &[f64]) -> Markup {
    let [a, b] = &grouped.names;
    let paired = grouped.pairing == Pairing::Paired;
    let [n_a, n_b] = grouped.participants;
    let measures = || {
        let with = grouped.measures.iter().zip(METRICS);
        with.filter_map(|(of, metric)| Some((of, metric, of.difference.as_ref()?)))
    };
    html! {
        p.about {
            @if paired {
                "Paired: " (n_a) " participants are in both, each by the mean of her sessions. Interval of the difference by Student's t of the \
                 pairs; Hedges' g over the standard deviation of the differences (g of d_z)."
            } @else {
                "Unpaired: " (n_a) " and " (n_b) ". Interval of the difference by Welch's t; Hedges' g over the pooled standard deviation."
            }
            " Intervals of g by the noncentral t distribution. Not corrected for many measures."
        }
        @if measures().next().is_none() { p { "Too few, or nothing varies: no measure can be compared." } }
        @else { div.wide { table {
            thead { tr {
                th.text { "Measure" } th { (a) } th { (b) } th { "Difference" small { "95 % interval" } } th { "g" small { "95 % interval" } }
                @if paired { th { "ICC(2,1)" small { "95 % interval" } } th { "ICC(3,1)" small { "95 % interval" } } }
            } }
            tbody { @for (of, metric, d) in measures() { tr {
                td.text title=(metric.about) { (metric.heading_at(edges_n)) }
                @for s in &d.groups { td { (number(Some(s.mean))) " ± " (number(Some(s.sd))) } }
                td { (number(Some(d.difference))) small { (interval(d.difference_interval)) } }
                td {
                    @if d.has_g() { (two(d.g)) small { (two(d.g_interval[0])) " to " (two(d.g_interval[1])) } } @else { "–" }
                }
                @if paired { @for i in 0..2 { td {
                    @if let Some(icc) = of.icc.get(i) {
                        (two(icc.value)) small { (two(icc.interval[0])) " to " (two(icc.interval[1])) }
                    } @else { "–" }
                } } }
            } } }
        } } }
    }
}
