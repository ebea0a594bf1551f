//! Plots of a score sheet.

use super::Done;
use crate::figure::{LinePlot, Mark, Series};
use crate::training::analysis::Fitted;
use crate::training::psychometric::{Family, Shape};

/// What was measured.
const INK: [u8; 3] = [24, 26, 30];
/// What was fitted, and what is compared with.
const FIT: [u8; 3] = [196, 124, 20];
/// Guides.
const GUIDE: [u8; 3] = [120, 124, 130];

/// Strength from trial to trial, right and wrong answers apart; none where no strength is given.
pub fn staircase(done: &Done) -> Option<LinePlot> {
    let scored = || done.read.trials.iter().filter(|t| !t.practice);
    let measure = scored().find_map(|t| t.measure.clone())?;
    let points = |right: Option<bool>| -> Vec<[f64; 2]> {
        scored()
            .filter(|t| right.is_none_or(|right| t.right == right))
            .filter_map(|t| Some([f64::from(t.trial), t.strength_percent?]))
            .collect()
    };
    let series = |name: &str, colour, mark, points| Series {
        name: name.to_owned(),
        colour,
        mark,
        points,
    };
    Some(LinePlot {
        title: "Strength from trial to trial".into(),
        x_label: "trial".into(),
        y_label: format!("change of {measure} (%)"),
        series: vec![
            series("", GUIDE, Mark::Line, points(None)),
            series("wrong", FIT, Mark::Points, points(Some(false))),
            series("right", INK, Mark::Points, points(Some(true))),
        ],
        ..LinePlot::default()
    })
}

/// Share of right answers over strength, with the fitted function.
pub fn psychometric(fit: &Fitted) -> LinePlot {
    let most = fit
        .points
        .iter()
        .map(|p| p.0)
        .fold(fit.threshold_percent * 1.2, f64::max);
    let shape = Shape::new(Family::by_name(&fit.family).unwrap_or_default(), fit.guess);
    let curve = (0..=200).map(|i| {
        let x = most * f64::from(i) / 200.0;
        let ln_x = if x > 0.0 {
            libm::log(x)
        } else {
            f64::NEG_INFINITY
        };
        let f = shape.share(ln_x, libm::log(fit.alpha_percent), fit.beta);
        [x, 100.0 * (fit.guess + (1.0 - fit.guess - fit.lapse) * f)]
    });
    let level = 100.0 * fit.target;
    let [low, high] = fit.threshold_interval_percent;
    LinePlot {
        title: "Right answers over strength".into(),
        x_label: format!("change of {} (%)", fit.measure),
        y_label: "right answers (%)".into(),
        series: vec![
            Series {
                name: "chance".into(),
                colour: GUIDE,
                mark: Mark::Dashed,
                points: vec![[0.0, 100.0 * fit.guess], [most, 100.0 * fit.guess]],
            },
            Series {
                name: "fit".into(),
                colour: FIT,
                mark: Mark::Line,
                points: curve.collect(),
            },
            Series {
                name: "threshold, 95 %".into(),
                colour: FIT,
                mark: Mark::Joined,
                points: vec![[low, level], [fit.threshold_percent, level], [high, level]],
            },
            Series {
                name: "answers".into(),
                colour: INK,
                mark: Mark::Points,
                points: gathered(fit),
            },
        ],
        ..LinePlot::default()
    }
}

/// Answers gathered so that a dot stands for enough of them to mean something.
fn gathered(fit: &Fitted) -> Vec<[f64; 2]> {
    let all: u32 = fit.points.iter().map(|p| p.1).sum();
    let enough = (all / 12).max(5);
    let (mut out, mut x, mut n, mut right) = (Vec::new(), 0.0, 0_u32, 0_u32);
    for (i, point) in fit.points.iter().enumerate() {
        x += point.0 * f64::from(point.1);
        n += point.1;
        right += point.2;
        if n >= enough || i + 1 == fit.points.len() {
            let weight = f64::from(n.max(1));
            out.push([x / weight, 100.0 * f64::from(right) / weight]);
            (x, n, right) = (0.0, 0, 0);
        }
    }
    out
}

/// Threshold and accuracy of one participant from exercise to exercise.
pub fn learning(done: &[&Done]) -> Vec<LinePlot> {
    let over = |value: &dyn Fn(&Done) -> Option<f64>| -> Vec<[f64; 2]> {
        let numbered = done.iter().enumerate();
        numbered
            .filter_map(|(i, d)| Some([(i + 1) as f64, value(d)?]))
            .collect()
    };
    let plot = |title: &str, y_label: &str, points| LinePlot {
        title: title.to_owned(),
        x_label: "exercise".into(),
        y_label: y_label.to_owned(),
        series: vec![Series {
            name: String::new(),
            colour: INK,
            mark: Mark::Joined,
            points,
        }],
        ..LinePlot::default()
    };
    let thresholds = over(&|d| d.analysis.fit.as_ref().map(|f| f.threshold_percent));
    let right = over(&|d| d.analysis.score.right_share.map(|s| 100.0 * s));
    let search = over(&|d| d.analysis.score.search_s);
    let mut plots = vec![plot("Right answers", "right answers (%)", right)];
    if thresholds.len() > 1 {
        plots.insert(
            0,
            plot("Smallest change found", "threshold (%)", thresholds),
        );
    }
    plots.push(plot("Time to palpate", "median (s)", search));
    plots
}

/// Share of right answers within one exercise, over the trials so far and over the last ten.
pub fn accuracy(done: &Done) -> LinePlot {
    let right: Vec<f64> = (done.read.trials.iter().filter(|t| !t.practice))
        .map(|t| 100.0 * f64::from(u8::from(t.right)))
        .collect();
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len().max(1) as f64;
    let curve = |last: usize| -> Vec<[f64; 2]> {
        (1..=right.len())
            .map(|n| [n as f64, mean(&right[n.saturating_sub(last)..n])])
            .collect()
    };
    LinePlot {
        title: "Right answers so far".into(),
        x_label: "trial".into(),
        y_label: "right answers (%)".into(),
        series: vec![
            Series {
                name: "last ten".into(),
                colour: GUIDE,
                mark: Mark::Line,
                points: curve(10),
            },
            Series {
                name: "all".into(),
                colour: INK,
                mark: Mark::Line,
                points: curve(usize::MAX),
            },
        ],
        ..LinePlot::default()
    }
}
