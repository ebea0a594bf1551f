//! The tables of a report.

use crate::study::compare::{Comparison, Spread};
use crate::study::groups::{Grouped, Row};
use crate::study::metrics::METRICS;
use crate::study::metrics::Metrics;
use crate::study::stats::Pairing;
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

type Part = (&'static str, fn(&Row) -> &Metrics);
const PARTS: [Part; 3] = [
    ("Whole", |r| &r.whole),
    ("Search", |r| &r.search),
    ("Palpation", |r| &r.palpation),
];

/// Measures as rows where few recordings fit as columns; else the recordings as rows.
pub(super) fn measures(rows: &[Row]) -> Markup {
    if rows.len() > MOST_COLUMNS {
        return html! {
            div.wide { table {
                thead { tr { th.text { "File" } @for m in METRICS { th title=(m.about) { (m.heading()) } } } }
                tbody { @for row in rows { tr {
                    td.text { (row.about.name()) }
                    @for m in METRICS { td { (number((m.get)(&row.whole))) } }
                } } }
            } }
        };
    }
    html! {
        div.wide { table {
            thead { tr { th.text { "Measure" } @for row in rows { th { (row.about.name()) } } } }
            tbody { @for (part, of) in PARTS.into_iter().filter(|(_, of)| rows.iter().any(|r| of(r).duration_s > 0.0)) {
                tr.part { td.text colspan=(rows.len() + 1) { (part) } }
                @for m in METRICS.iter().filter(|m| rows.iter().any(|r| (m.get)(of(r)).is_some())) { tr {
                    td.text title=(m.about) { (m.heading()) }
                    @for row in rows { td { (number((m.get)(of(row)))) } }
                } }
            } }
        } }
    }
}

pub(super) fn felt(rows: &[Row]) -> Markup {
    html! {
        div.wide { table {
            thead { tr {
                th.text { "File" } th.text { "Site" } th { "Presses" } th { "Slope (N/mm)" } th { "95 % interval (N/mm)" } th { "R²" }
            } }
            tbody { @for row in rows.iter().take(MOST_COLUMNS) { @for felt in &row.felt { tr {
                td.text { (row.about.name()) }
                td.text { (felt.site) }
                td { (felt.presses) }
                td { (number(Some(felt.slope_n_per_mm))) }
                td { (felt.interval_n_per_mm.map_or("–".to_owned(), interval)) }
                td { (number(felt.r_squared)) }
            } } } }
        } }
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

pub(super) fn grouped(grouped: &Grouped) -> Markup {
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
                th.text { "Measure" } th { (a) } th { (b) } th { "Difference" } th { "95 % interval" } th { "g" } th { "95 % interval" }
                @if paired { th { "ICC(2,1)" } th { "ICC(3,1)" } }
            } }
            tbody { @for (of, metric, d) in measures() { tr {
                td.text title=(metric.about) { (metric.heading()) }
                @for s in &d.groups { td { (number(Some(s.mean))) " ± " (number(Some(s.sd))) } }
                td { (number(Some(d.difference))) }
                td { (interval(d.difference_interval)) }
                td { (format!("{:.2}", d.g).replace('-', "\u{2212}")) }
                td { (format!("{:.2} to {:.2}", d.g_interval[0], d.g_interval[1]).replace('-', "\u{2212}")) }
                @if paired { @for i in 0..2 { td {
                    @if let Some(icc) = of.icc.get(i) {
                        (format!("{:.2} ({:.2} to {:.2})", icc.value, icc.interval[0], icc.interval[1]).replace('-', "\u{2212}"))
                    } @else { "–" }
                } } }
            } } }
        } } }
    }
}
