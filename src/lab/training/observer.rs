//! Staircases, fits and d′ beside the simulated observer's own figures.

use crate::figure::{LinePlot, Series};
use crate::lab::{Choice, Experiment, LabError, Report, Setup, Table, Verdict, Watch};
use crate::scenario::Change;
use crate::scenario::exercise::{Staircase as Stated, Step};
use crate::training::analysis::sensitivity;
use crate::training::detection::{ForcedChoice, root};
use crate::training::level::log_ratio;
use crate::training::psychometric::{Bootstrap, Family, Model, points};
use crate::training::random::Random;
use crate::training::staircase::{self, Rule, Settings};

/// Simulated observers of known d′.
pub struct TrainingObserver;

/// Alternatives: the published trainer's sites (Howell et al. 2008).
const ALTERNATIVES: u32 = 12;
/// Trials of a run.
const TRIALS: u32 = 200;
/// d′ for each unit of the logarithm of the ratio of stiffness.
const D_PRIME: f64 = 10.0;
/// Lapses of the observer whose answers are fitted.
const LAPSE: f64 = 0.02;
/// Colours of the drawn runs.
const COLOURS: [[u8; 3]; 3] = [[24, 26, 30], [196, 124, 20], [120, 124, 130]];

/// An observer among 12 alternatives on the axis of a staircase.
struct Observer {
    forced: ForcedChoice,
    settings: Settings,
    d_prime: f64,
    lapse: f64,
}

/// One trial: strength in percent, logarithm of the ratio, answer.
struct Trial {
    percent: f64,
    log_ratio: f64,
    right: bool,
}

impl Observer {
    fn new(step_db: f64, d_prime: f64, lapse: f64) -> Self {
        let stated = Stated {
            step: Step::Decibel(step_db),
            ..Stated::default()
        };
        let forced = ForcedChoice::new(ALTERNATIVES);
        let change = Change::CompliancePercent(-28.0);
        Self {
            settings: Settings::new(&stated, change, forced.chance()),
            forced,
            d_prime,
            lapse,
        }
    }

    /// Share of right answers at a level of one who never lapses.
    fn share(&self, level: f64) -> f64 {
        let ratio = log_ratio(self.settings.scale.change(level));
        self.forced.share(self.d_prime * ratio)
    }

    /// The level at which a share is right.
    fn threshold(&self, share: f64) -> f64 {
        let (least, most) = (self.settings.least, self.settings.most);
        root(least, most, |level| self.share(level) - share)
    }

    /// The least standard error that as many trials allow, were all given at the threshold itself (Taylor & Creelman 1967).
    fn least_error(&self, share: f64) -> f64 {
        let (at, h) = (self.threshold(share), 1.0e-3);
        let slope = (self.share(at + h) - self.share(at - h)) / (2.0 * h);
        (share * (1.0 - share) / f64::from(TRIALS)).sqrt() / slope
    }

    /// A run of a rule: its trials, and what it makes of them.
    fn run(&self, rule: &dyn Rule, seed: u64) -> (Vec<Trial>, Option<f64>) {
        let mut random = Random::new(seed);
        let mut staircase = rule.start(&self.settings);
        let trials = (0..TRIALS).map(|_| {
            let level = staircase.level(&mut random);
            let p = (1.0 - self.lapse) * self.share(level) + self.lapse * self.forced.chance();
            let right = random.unit() < p;
            staircase.answered(level, right);
            Trial {
                percent: self.settings.scale.percent(level),
                log_ratio: log_ratio(self.settings.scale.change(level)),
                right,
            }
        });
        let trials = trials.collect();
        (trials, staircase.estimate().map(|e| e.level))
    }
}

/// The seed of a run.
fn seed(setup: &Setup, part: u64, run: usize) -> u64 {
    Random::new(setup.seed ^ (part << 40) ^ run as u64).bits()
}

fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    let n = values.len().max(2) as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    (mean, (squares / (n - 1.0)).sqrt())
}

impl Experiment for TrainingObserver {
    fn name(&self) -> &'static str {
        "training-observer"
    }

    fn about(&self) -> &'static str {
        "Simulated observers of known d′: where staircases go, how often intervals hold the truth, which d′ is found"
    }

    fn takes(&self) -> &'static [Choice] {
        &[Choice::Seed]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        report.set("alternatives", ALTERNATIVES);
        report.set("trials of a run", TRIALS);
        report.set(
            "d′ for each unit of the logarithm of the ratio of stiffness",
            D_PRIME,
        );
        report.set("runs", repeats(setup));
        convergence(setup, &mut report, &mut watch.part(0.0, 0.15))?;
        coverage(setup, &mut report, &mut watch.part(0.15, 0.95))?;
        recovery(setup, &mut report, &mut watch.part(0.95, 1.0))?;
        report.note(
            "The observer takes the strongest of 12 places, one of which is stiffer; its d′ is in proportion to the logarithm of \
             the ratio of stiffness. Levels are decibels of the percentage by which the compliance is lower. Theory's error is \
             that of as many trials all given at the threshold itself: no rule can do better.",
        );
        Ok(report)
    }
}

fn repeats(setup: &Setup) -> usize {
    if setup.quick { 40 } else { 400 }
}

/// Every rule's estimates beside the observer's threshold.
fn convergence(setup: &Setup, report: &mut Report, watch: &mut Watch<'_>) -> Result<(), LabError> {
    let observer = Observer::new(1.0, D_PRIME, 0.0);
    let mut table = Table::new(
        "staircases",
        "Thresholds that staircases come to, over all runs",
        &[
            "rule",
            "right answers (%)",
            "true threshold (%)",
            "mean found (%)",
            "bias (dB)",
            "spread (dB)",
            "error of theory (dB)",
            "efficiency (%)",
            "runs within two errors (%)",
        ],
    );
    let mut drawn = Vec::new();
    let rules = staircase::all();
    for (i, &rule) in rules.iter().enumerate() {
        watch.at(rule.title(), i as f64 / rules.len() as f64)?;
        let Some(target) = rule.target(&observer.settings) else {
            continue;
        };
        let runs = (0..repeats(setup)).map(|r| observer.run(rule, seed(setup, i as u64, r)));
        let mut estimates = Vec::new();
        for (r, (trials, estimate)) in runs.enumerate() {
            if r == 0 && ["1-up-2-down", "1-up-4-down", "psi"].contains(&rule.key()) {
                drawn.push((rule.title(), trials));
            }
            estimates.extend(estimate);
        }
        let percent = |level| observer.settings.scale.percent(level);
        let (truth, least) = (observer.threshold(target), observer.least_error(target));
        let (mean, sd) = mean_and_sd(&estimates);
        let near = estimates
            .iter()
            .filter(|e| (*e - truth).abs() < 2.0 * least)
            .count();
        table.push([
            rule.key().into(),
            (100.0 * target).into(),
            percent(truth).into(),
            percent(mean).into(),
            (mean - truth).into(),
            sd.into(),
            least.into(),
            (100.0 * (least / sd) * (least / sd)).into(),
            (100.0 * near as f64 / estimates.len().max(1) as f64).into(),
        ]);
        report.verdicts.push(Verdict::must(
            format!("{}: mean threshold beside the observer's own", rule.key()),
            format!("{:+.3} dB", mean - truth),
            format!("within the error of theory, {least:.3} dB"),
            (mean - truth).abs() <= least,
        ));
    }
    report.tables.push(table);
    let curves = drawn
        .into_iter()
        .zip(COLOURS)
        .map(|((name, trials), colour)| Series {
            name: name.to_owned(),
            colour,
            points: (trials.iter().enumerate())
                .map(|(n, t)| [(n + 1) as f64, t.percent])
                .collect(),
            ..Series::default()
        });
    let plot = LinePlot {
        title: "Strength from trial to trial".into(),
        x_label: "trial".into(),
        y_label: "compliance lower by (%)".into(),
        series: curves.collect(),
        ..LinePlot::default()
    };
    report.draw("runs", vec![plot]);
    Ok(())
}

/// How often the 95 % interval of a fit holds the observer's threshold.
fn coverage(setup: &Setup, report: &mut Report, watch: &mut Watch<'_>) -> Result<(), LabError> {
    let observer = Observer::new(2.0, D_PRIME, LAPSE);
    let samples = if setup.quick { 60 } else { 500 };
    let runs = repeats(setup);
    let share = 0.8315;
    let truth = observer.settings.scale.percent(observer.threshold(share));
    let mut table = Table::new(
        "coverage",
        format!(
            "Intervals of 95 % around the threshold at {:.2} % right, {samples} samples each",
            100.0 * share
        ),
        &[
            "rule",
            "function",
            "true threshold (%)",
            "mean found (%)",
            "holds the truth (%)",
            "too low (%)",
            "too high (%)",
            "mean width (%)",
            "runs",
        ],
    );
    let cases = [
        ("1-up-3-down", Family::Weibull),
        ("1-up-3-down", Family::Detection),
        ("constant", Family::Weibull),
    ];
    for (c, (key, family)) in cases.into_iter().enumerate() {
        let Some(rule) = staircase::by_key(key) else {
            continue;
        };
        let model = Model::new(family, observer.forced.chance());
        let (mut found, mut widths, mut low, mut high) = (Vec::new(), 0.0, 0_usize, 0_usize);
        for r in 0..runs {
            if r % 5 == 0 {
                let done = (c as f64 + r as f64 / runs as f64) / cases.len() as f64;
                watch.at(&format!("{key}, {}", family.name()), done)?;
            }
            let (trials, _) = observer.run(rule, seed(setup, 100 + c as u64, r));
            let answers = points(trials.iter().map(|t| (t.percent, t.right)));
            let bootstrap = Bootstrap {
                samples,
                seed: seed(setup, 200 + c as u64, r),
                ..Bootstrap::default()
            };
            let Some(fit) = model.fit(&answers) else {
                continue;
            };
            let Some(told) = bootstrap.of(&model, &answers, &fit, &[share]) else {
                continue;
            };
            let Some(&[from, to]) = told.thresholds.first() else {
                continue;
            };
            found.push(fit.threshold(&model, share));
            widths += to - from;
            low += usize::from(to < truth);
            high += usize::from(from > truth);
        }
        let n = found.len().max(1) as f64;
        let held = 100.0 * (n - low as f64 - high as f64) / n;
        table.push([
            key.into(),
            family.name().into(),
            truth.into(),
            mean_and_sd(&found).0.into(),
            held.into(),
            (100.0 * low as f64 / n).into(),
            (100.0 * high as f64 / n).into(),
            (widths / n).into(),
            found.len().into(),
        ]);
        // 400 runs tell a share of 95 % to 1.1 %, fewer tell less.
        let slack = f64::max(2.0, 300.0 * (0.95 * 0.05 / n).sqrt());
        let slack = if setup.quick { slack } else { 2.0 };
        let what = format!("{key}, {}: intervals that hold the truth", family.name());
        let goal = format!(
            "{:.1} to {:.1} %",
            95.0 - slack,
            f64::min(95.0 + slack, 100.0)
        );
        let holds = (held - 95.0).abs() <= slack;
        let measured = format!("{held:.2} % of {}", found.len());
        report.verdicts.push(match c {
            0 => Verdict::must(what, measured, goal, holds),
            _ => Verdict::told(what, measured, goal, holds),
        });
    }
    report.tables.push(table);
    Ok(())
}

/// The d′ that is found beside the one put in.
fn recovery(setup: &Setup, report: &mut Report, watch: &mut Watch<'_>) -> Result<(), LabError> {
    let mut table = Table::new(
        "d-prime",
        "d′ for each unit of the logarithm of the ratio of stiffness, from the answers of a 1-up 3-down staircase",
        &[
            "true d′",
            "mean d′",
            "spread",
            "mean error told",
            "off by over spread",
        ],
    );
    for (i, d_prime) in [5.0, 10.0, 20.0].into_iter().enumerate() {
        watch.at("d′", i as f64 / 3.0)?;
        let observer = Observer::new(2.0, d_prime, 0.0);
        let Some(rule) = staircase::by_key("1-up-3-down") else {
            continue;
        };
        let found: Vec<(f64, f64)> = (0..repeats(setup) / 2)
            .filter_map(|r| {
                let (trials, _) = observer.run(rule, seed(setup, 300 + i as u64, r));
                let answers: Vec<(f64, bool)> =
                    trials.iter().map(|t| (t.log_ratio, t.right)).collect();
                sensitivity(&observer.forced, &answers)
            })
            .collect();
        let (mean, sd) = mean_and_sd(&found.iter().map(|f| f.0).collect::<Vec<_>>());
        let (error, _) = mean_and_sd(&found.iter().map(|f| f.1).collect::<Vec<_>>());
        let off = (mean - d_prime) / sd;
        table.push([
            d_prime.into(),
            mean.into(),
            sd.into(),
            error.into(),
            off.into(),
        ]);
        report.verdicts.push(Verdict::must(
            format!("d′ of {d_prime}: found in the mean"),
            format!("{mean:.3}, spread {sd:.3}, error told {error:.3}"),
            "within half the spread of a run",
            off.abs() <= 0.5,
        ));
    }
    report.tables.push(table);
    Ok(())
}
