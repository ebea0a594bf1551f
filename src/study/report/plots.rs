//! The plots of a report, from plain numbers.

use crate::figure::{LinePlot, Mark, Series};
use crate::study::compare::{Comparison, Trace};
use crate::study::groups::Curve;
use crate::study::stats::BlandAltman;

/// What recordings are drawn in, in their order; the colours of the fingers are not among them.
const COLOURS: [[u8; 3]; 6] = [
    [24, 26, 30],
    [204, 121, 20],
    [0, 128, 96],
    [130, 84, 168],
    [120, 94, 60],
    [110, 118, 128],
];
const GUIDE: [u8; 3] = [120, 124, 130];

/// The colour of the recording with number `i`.
pub(super) fn colour(i: usize) -> [u8; 3] {
    COLOURS[i % COLOURS.len()]
}

fn line(name: &str, colour: [u8; 3], mark: Mark, points: Vec<[f64; 2]>) -> Series {
    Series {
        name: name.to_owned(),
        colour,
        mark,
        points,
    }
}

/// A recording that is drawn over others: its name, its trace, and what its times are of the first one's.
pub(super) type Drawn<'a> = (&'a str, &'a Trace, &'a dyn Fn(f64) -> f64);

/// Force and depth of recordings over each other.
pub(super) fn overlaid(traces: &[Drawn<'_>]) -> Vec<LinePlot> {
    let plot = |title: &str, y_label: &str, of: fn(&Trace) -> &[f32]| LinePlot {
        title: title.to_owned(),
        x_label: "time in the first recording (s)".into(),
        y_label: y_label.to_owned(),
        series: traces
            .iter()
            .enumerate()
            .map(|(i, (name, trace, time))| {
                let points = of(trace).iter().enumerate();
                let points = points.map(|(k, y)| [time(trace.time_s(k)), f64::from(*y)]);
                line(name, colour(i), Mark::Line, points.collect())
            })
            .collect(),
        ..LinePlot::default()
    };
    vec![
        plot("Force", "force (N)", |t| &t.force_n),
        plot("Depth", "depth (mm)", |t| &t.depth_mm),
    ]
}

/// Differences over time.
pub(super) fn differences(c: &Comparison) -> Vec<LinePlot> {
    let s = &c.series;
    let plot = |title: &str, y_label: &str, mean: &[f64], max: &[f64], mean_name: &str| {
        let with = |ys: &[f64]| s.time_s.iter().zip(ys).map(|(t, y)| [*t, *y]).collect();
        LinePlot {
            title: title.to_owned(),
            x_label: "time in the first recording (s)".into(),
            y_label: y_label.to_owned(),
            series: vec![
                line("greatest size", [206, 186, 150], Mark::Line, with(max)),
                line(mean_name, colour(0), Mark::Line, with(mean)),
            ],
            ..LinePlot::default()
        }
    };
    vec![
        plot(
            "Distance of the fingers",
            "distance (mm)",
            &s.position_mm,
            &s.position_max_mm,
            "mean",
        ),
        plot(
            "Difference of the forces",
            "difference (N)",
            &s.force_n,
            &s.force_max_n,
            "mean, second less first",
        ),
        plot(
            "Difference of the depths",
            "difference (mm)",
            &s.depth_mm,
            &s.depth_max_mm,
            "mean, second less first",
        ),
    ]
}

/// Points of a level: so many that none is shown as a ring.
const LEVEL: usize = 48;

/// Differences over means, with bias and limits.
pub(super) fn agreement(a: &BlandAltman, title: &str, unit: &str) -> LinePlot {
    let with = |word: &str| match unit {
        "" => word.to_owned(),
        unit => format!("{word} ({unit})"),
    };
    let xs = || a.points.iter().map(|p| p[0]);
    let (low, high) = (
        xs().fold(f64::INFINITY, f64::min),
        xs().fold(f64::NEG_INFINITY, f64::max),
    );
    let level = |y: f64| -> Vec<[f64; 2]> {
        let at = |i: usize| low + (high - low) * i as f64 / LEVEL as f64;
        (0..=LEVEL).map(|i| [at(i), y]).collect()
    };
    let [lower, upper] = a.limits;
    LinePlot {
        title: title.to_owned(),
        x_label: with("mean of both"),
        y_label: with("second less first"),
        series: vec![
            line(
                "limits of agreement, 95 %",
                GUIDE,
                Mark::Dashed,
                level(lower),
            ),
            line("", GUIDE, Mark::Dashed, level(upper)),
            line("bias", colour(1), Mark::Line, level(a.bias)),
            line("pairs", colour(0), Mark::Points, a.points.clone()),
        ],
        ..LinePlot::default()
    }
}

/// A measure of some participants from session to session; each has the colour of its place among `people`.
pub(super) fn learning(curves: &[Curve], people: &[&str], title: &str, unit: &str) -> LinePlot {
    let place = |c: &&Curve| people.iter().position(|p| *p == c.participant);
    let drawn = curves
        .iter()
        .filter_map(|c| Some((place(&c)?, c)))
        .filter(|(place, _)| *place < COLOURS.len());
    LinePlot {
        title: title.to_owned(),
        x_label: "session".into(),
        y_label: match unit {
            "" => "value".to_owned(),
            unit => format!("value ({unit})"),
        },
        series: drawn
            .map(|(i, c)| line(&c.participant, colour(i), Mark::Joined, c.points.clone()))
            .collect(),
        ..LinePlot::default()
    }
}
