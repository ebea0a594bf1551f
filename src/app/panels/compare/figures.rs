//! Curves: traces over each other, their difference over time, agreement, learning.

use super::measures::{Named, Share, edges_n};
use crate::app::theme::Theme;
use crate::figure::{LinePlot, Mark, Series};
use crate::study::Metric;
use crate::study::compare::{self, Comparison, Trace};
use crate::study::stats::BlandAltman;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Most points of a curve.
const MOST: usize = 4000;
/// Most dots of an agreement plot: more hide each other.
const MOST_DOTS: usize = 1500;

/// Colour of recording `i`.
pub fn colour(theme: &Theme, i: usize) -> [u8; 3] {
    let [r, g, b, _] = theme.ghost(i).to_array();
    [r, g, b]
}

/// A quantity over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quantity {
    Force,
    Depth,
}

impl Quantity {
    fn label(self) -> &'static str {
        match self {
            Self::Force => "force (N)",
            Self::Depth => "depth (mm)",
        }
    }

    fn of(self, trace: &Trace, i: usize) -> f64 {
        let values = match self {
            Self::Force => &trace.force_n,
            Self::Depth => &trace.depth_mm,
        };
        values.get(i).copied().map_or(f64::NAN, f64::from)
    }
}

/// Those set side by side with the first, as far as that is known.
pub type Beside = Vec<Option<Arc<Comparison>>>;

/// Force and depth of a finger in each recording, on the time of the first.
pub fn traces(told: &[Named], beside: &Beside, finger: usize, theme: &Theme) -> Vec<LinePlot> {
    let plot = |quantity: Quantity| {
        let series = told.iter().enumerate().filter_map(|(i, (name, t))| {
            let trace = t.traces.get(finger)?;
            // One that is not aligned yet would stand at a wrong time.
            let aligned = match i.checked_sub(1) {
                None => None,
                Some(k) => Some(beside.get(k)?.as_ref()?),
            };
            let step = trace.len().div_ceil(MOST).max(1);
            let sample = |i: usize| {
                let own_s = trace.time_s(i);
                let time_s = aligned.map_or(own_s, |c| c.first_time_s(own_s));
                [time_s, quantity.of(trace, i)]
            };
            Some(Series {
                name: name.clone(),
                colour: colour(theme, i),
                mark: Mark::Line,
                points: (0..trace.len()).step_by(step).map(sample).collect(),
            })
        });
        LinePlot {
            title: format!("Overlaid {}", quantity.label()),
            x_label: "time of A (s)".into(),
            y_label: quantity.label().into(),
            series: series.collect(),
            ..LinePlot::default()
        }
    };
    [Quantity::Force, Quantity::Depth].map(plot).to_vec()
}

/// Second less first over time, for each pair: force, depth, and how far apart the fingers were.
pub fn differences(told: &[Named], beside: &Beside, theme: &Theme) -> Vec<LinePlot> {
    let plot = |title: &str, label: &str, of: &dyn Fn(&compare::Series) -> Vec<f64>| {
        let series = beside.iter().enumerate().filter_map(|(k, pair)| {
            let series = &pair.as_ref()?.series;
            let values = of(series);
            Some(Series {
                name: told.get(k + 1).map(|(n, _)| n.clone()).unwrap_or_default(),
                colour: colour(theme, k + 1),
                mark: Mark::Line,
                points: (series.time_s.iter().zip(values))
                    .map(|(s, v)| [*s, v])
                    .collect(),
            })
        });
        LinePlot {
            title: title.into(),
            x_label: "time of A (s)".into(),
            y_label: label.into(),
            series: series.collect(),
            ..LinePlot::default()
        }
    };
    vec![
        plot("Force less that of A", "difference (N)", &|s| {
            s.force_n.clone()
        }),
        plot("Depth less that of A", "difference (mm)", &|s| {
            s.depth_mm.clone()
        }),
        plot("Distance of the fingers", "distance (mm)", &|s| {
            s.position_mm.clone()
        }),
    ]
}

/// Points of a level: so many that none is shown as a ring.
const LEVEL: usize = 48;

/// Difference against mean of what recording `i`, with the letter `who`, and the first have in common.
pub fn agreement(
    found: &BlandAltman,
    (i, who): (usize, &str),
    title: &str,
    theme: &Theme,
) -> LinePlot {
    let step = found.points.len().div_ceil(MOST_DOTS).max(1);
    let dots: Vec<[f64; 2]> = found.points.iter().copied().step_by(step).collect();
    let xs = found.points.iter().map(|p| p[0]);
    let (lo, hi) = xs.fold((f64::MAX, f64::MIN), |(lo, hi), x| (lo.min(x), hi.max(x)));
    let at = |k: usize| lo + (hi - lo) * k as f64 / LEVEL as f64;
    let line = |name: &str, y: f64, mark: Mark, colour: [u8; 3]| Series {
        name: format!("{name} {y:.3} N"),
        colour,
        mark,
        points: (0..=LEVEL).map(|k| [at(k), y]).collect(),
    };
    let [r, g, b, _] = theme.accent.to_array();
    let accent = [r, g, b];
    let [lower, upper] = found.limits;
    LinePlot {
        title: title.to_owned(),
        x_label: "mean force of both (N)".into(),
        y_label: format!("{who} − A (N)"),
        series: vec![
            Series {
                name: format!("{} windows", found.n),
                colour: colour(theme, i),
                mark: Mark::Points,
                points: dots,
            },
            line("bias", found.bias, Mark::Line, accent),
            line("lower limit", lower, Mark::Dashed, accent),
            line("upper limit", upper, Mark::Dashed, accent),
        ],
        ..LinePlot::default()
    }
}

/// A measure over the sessions of each participant, in the order in which they were recorded.
pub fn learning(told: &[Named], metric: &Metric, share: Share, theme: &Theme) -> LinePlot {
    let mut by: BTreeMap<&str, Vec<(&str, f64)>> = BTreeMap::new();
    for (name, t) in told {
        let about = &t.analysis.about;
        let who = about.participant.as_deref().unwrap_or(name);
        if let Some(value) = share.of(&t.analysis).and_then(metric.get) {
            by.entry(who).or_default().push((&about.started_utc, value));
        }
    }
    let series = by.into_iter().enumerate().map(|(i, (who, mut values))| {
        values.sort_by(|a, b| a.0.cmp(b.0));
        let points = values.iter().enumerate();
        Series {
            name: who.to_owned(),
            colour: colour(theme, i),
            mark: Mark::Joined,
            points: points.map(|(k, (_, v))| [(k + 1) as f64, *v]).collect(),
        }
    });
    LinePlot {
        title: format!("{} over sessions", metric.title_at(edges_n(told))),
        x_label: "session of the participant".into(),
        y_label: metric.axis_at(edges_n(told)),
        series: series.collect(),
        ..LinePlot::default()
    }
}
