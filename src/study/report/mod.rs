//! What was found, as one page that needs nothing beside itself: tables, and figures as SVG.

mod heat;
mod plots;
mod tables;

pub use heat::Outline;

use super::compare::{Comparison, Trace};
use super::groups::{Grouped, Row, learning};
use super::metrics::{METRICS, by_key};
use super::{Dwell, StudyError, finger_name};
use crate::figure::{Page, plot};
use maud::{Markup, PreEscaped, html};

const STYLE: &str = include_str!("report.css");
/// Recordings that are drawn over each other, and whose maps are shown.
pub const MOST_DRAWN: usize = 6;
/// Points of a curve.
const MOST_POINTS: usize = 6000;
/// Fewer windows of a second show no agreement.
const LEAST_WINDOWS: usize = 8;
/// Measures with a learning curve.
const LEARNED: [&str; 6] = [
    "duration_s",
    "coverage_percent",
    "peak_force_n",
    "mean_force_n",
    "sparc",
    "presses",
];
/// Measures of paired groups whose agreement is drawn.
const AGREED: [&str; 3] = ["mean_force_n", "sparc", "presses"];

/// Everything that a report tells.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// The recordings, in the order given.
    pub rows: Vec<Row>,
    /// Maps of the first [`MOST_DRAWN`].
    pub dwell: Vec<Dwell>,
    /// Traces of the compared finger of the first [`MOST_DRAWN`].
    pub traces: Vec<Trace>,
    /// Each further recording beside the first.
    pub comparisons: Vec<Comparison>,
    /// Groups, two and two.
    pub groups: Vec<Grouped>,
    /// Which share of the sessions the groups are compared by, such as "Palpation, right finger"; empty: all of them.
    pub groups_by: String,
    /// What is to be said beside the recordings, such as which could not be aligned.
    pub notes: Vec<String>,
    /// The back, where it is at hand.
    pub outline: Option<Outline>,
}

fn drawn(plots: &[crate::figure::LinePlot], caption: &str) -> Result<Markup, StudyError> {
    let svg = plot::svg(plots, caption).map_err(|e| StudyError::Output(e.to_string()))?;
    Ok(html! { figure { (PreEscaped(svg)) } })
}

/// The page.
///
/// # Errors
/// None that is known: those of the drawing library, which writes to memory here.
pub fn page(report: &Report) -> Result<String, StudyError> {
    let rows = &report.rows;
    let title = match (&report.groups[..], &rows[..]) {
        ([one], _) => format!("{} and {}", one.names[0], one.names[1]),
        (_, [one]) => format!("Session {}", one.about.name()),
        (_, [a, b]) => format!("{} and {}", a.about.name(), b.about.name()),
        (_, many) => format!("{} sessions", many.len()),
    };
    let most_s = report.dwell.iter().map(Dwell::most_s).fold(0.0, f64::max);
    let maps = rows
        .iter()
        .zip(&report.dwell)
        .map(|(row, dwell)| heat::svg(&row.about.name(), dwell, report.outline.as_ref(), most_s));
    let body = html! {
        section {
            h2 { "Recordings" }
            (tables::recordings(rows))
            @for note in &report.notes { p.about { (note) } }
        }
        (beside(report)?)
        section {
            h2 { "Measures" }
            p.about {
                "Search is moving lightly over the skin; palpation is pressing or dwelling. Of all fingers together times and counts are sums."
            }
            (tables::measures(rows))
            @if rows.iter().any(|r| !r.felt.is_empty()) {
                h3 { "Stiffness felt" }
                p.about { "Mean slope of force over depth of the presses near a site, with its 95 % interval." }
                (tables::felt(rows))
            }
        }
        @if !report.dwell.is_empty() {
            section {
                h2 { "Where the time went" }
                div.heats { @for map in maps { (map) } }
            }
        }
        (groups(report)?)
        (curves(rows)?)
    };
    let page = Page {
        kind: "Dorsum comparison",
        title: &title,
        style: STYLE,
        body,
        footer: html! {
            "Force is that of the skin on the finger before a device limits it. SPARC: cut-off 10 Hz, threshold 0.05, padding 4, \
             the mean over windows of 4 s. Intervals are of 95 %."
        },
    };
    Ok(page.document())
}

/// Each further recording beside the first.
fn beside(report: &Report) -> Result<Markup, StudyError> {
    let comparisons = &report.comparisons;
    if comparisons.is_empty() {
        return Ok(html! {});
    }
    let names: Vec<String> = report.rows.iter().map(|r| r.about.name()).collect();
    let thinned: Vec<Trace> = report
        .traces
        .iter()
        .map(|t| t.thinned(MOST_POINTS))
        .collect();
    let same = |t: f64| t;
    let times: Vec<Box<dyn Fn(f64) -> f64>> = (0..thinned.len())
        .map(
            |i| match i.checked_sub(1).and_then(|i| comparisons.get(i)) {
                Some(c) => {
                    let c = c.clone();
                    Box::new(move |t| c.first_time_s(t)) as Box<dyn Fn(f64) -> f64>
                }
                None => Box::new(same),
            },
        )
        .collect();
    let traces: Vec<_> = (names.iter().zip(&thinned).zip(&times))
        .map(|((name, trace), time)| (name.as_str(), trace, &**time))
        .collect();
    let finger = comparisons[0].finger;
    let overlaid = drawn(
        &plots::overlaid(&traces),
        &format!(
            "{}, aligned {}.",
            finger_name(finger),
            comparisons[0].aligned
        ),
    )?;
    let mut details = Vec::new();
    for c in comparisons.iter().take(MOST_DRAWN - 1) {
        let [a, b] = &c.names;
        let mut figures = vec![drawn(&plots::differences(c), "")?];
        if let Some(agreement) = c.force_agreement.as_ref().filter(|a| a.n >= LEAST_WINDOWS) {
            let caption = format!(
                "Bias {:+.3} N ({:+.3} to {:+.3}), limits {:+.3} and {:+.3} N, RMSE {:.3} N, {} windows of a second. Windows that follow \
                 each other are not independent: the interval is too narrow where motion is slow.",
                agreement.bias,
                agreement.bias_interval[0],
                agreement.bias_interval[1],
                agreement.limits[0],
                agreement.limits[1],
                agreement.rmse,
                agreement.n
            );
            figures.push(drawn(
                &[plots::agreement(agreement, "Agreement of the forces", "N")],
                &caption,
            )?);
        }
        details.push(html! {
            h3.names { (b) " less " (a) }
            @for figure in &figures { (figure) }
        });
    }
    Ok(html! {
        section {
            h2 { "Side by side" }
            (overlaid)
            h3 { "How far apart" }
            (tables::spreads(comparisons))
            @for detail in &details { (detail) }
        }
    })
}

fn groups(report: &Report) -> Result<Markup, StudyError> {
    let mut parts = Vec::new();
    for grouped in &report.groups {
        let mut figures = Vec::new();
        let edges_n = edges_n(&report.rows);
        for key in AGREED {
            let of = grouped.measures.iter().find(|m| m.key == key);
            if let (Some(agreement), Some(metric)) =
                (of.and_then(|m| m.agreement.as_ref()), by_key(key))
            {
                figures.push(plots::agreement(
                    agreement,
                    &metric.title_at(edges_n),
                    metric.unit,
                ));
            }
        }
        let figures = figures.iter().map(|f| drawn(std::slice::from_ref(f), ""));
        let figures: Vec<Markup> = figures.collect::<Result<_, _>>()?;
        parts.push(html! {
            h2 { (grouped.names[0]) " and " (grouped.names[1]) }
            @if !report.groups_by.is_empty() { p { (report.groups_by) "." } }
            (tables::grouped(grouped, edges_n))
            @for figure in &figures { (figure) }
        });
    }
    Ok(html! { @for part in &parts { section { (part) } } })
}

fn curves(rows: &[Row]) -> Result<Markup, StudyError> {
    // A participant has the same colour in every plot.
    let mut people: Vec<&str> = Vec::new();
    for row in rows {
        let mut seen = people.iter();
        if let Some(name) = row.about.participant.as_deref()
            && seen.all(|p| *p != name)
        {
            people.push(name);
        }
    }
    let metrics = METRICS.iter().filter(|m| LEARNED.contains(&m.key));
    let plots: Vec<_> = metrics
        .map(|m| (learning(rows, m), m))
        .filter(|(curves, _)| !curves.is_empty())
        .map(|(curves, m)| plots::learning(&curves, &people, &m.title_at(edges_n(rows)), m.unit))
        .collect();
    if plots.is_empty() {
        return Ok(html! {});
    }
    let figure = drawn(
        &plots,
        "Sessions of a participant in the order of their start; at most six participants are drawn.",
    )?;
    Ok(html! { section { h2 { "Learning curves" } (figure) } })
}

/// Edges of the bands of force: one report goes by one set of them.
fn edges_n(rows: &[Row]) -> &[f64] {
    rows.first().map_or(&[], |row| &row.force_bands_n)
}
