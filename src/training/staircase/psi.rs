//! The psi method: each trial is given where its answer is expected to tell most.

use super::{Estimate, Rule, Settings, Staircase};
use crate::training::level::Scale;
use crate::training::psychometric::{Family, Shape};
use crate::training::random::Random;

/// Kontsevich & Tyler 1999: a posterior over threshold and slope, guess rate fixed at chance, lapse rate fixed at 1 %. The next
/// level is the one at which the entropy of the posterior is expected to fall most; the threshold told is the posterior mean of
/// its logarithm, with the posterior's standard deviation.
///
/// The function is that of an observer who takes the strongest of m places ([`Family::Detection`]). With a Weibull function in
/// its place, which bends otherwise near chance, where this rule gives many of its trials, thresholds came out 7 % low.
pub struct Psi;

/// Lapse rate that is taken for granted.
const LAPSE: f64 = 0.01;
/// Thresholds, slopes and levels looked at.
const N_THRESHOLD: usize = 61;
const N_BETA: usize = 13;
const N_LEVELS: usize = 41;
/// Slopes, evenly on a logarithmic scale: d′ is in proportion to this power of the strength.
const BETA: [f64; 2] = [0.5, 3.0];
/// The way from guessing to certainty that is gone at the threshold.
const WAY: f64 = 0.632;

impl Rule for Psi {
    fn key(&self) -> &'static str {
        "psi"
    }

    fn title(&self) -> &'static str {
        "Psi"
    }

    fn about(&self) -> &'static str {
        "Bayesian: each trial where it tells most of threshold and slope (Kontsevich & Tyler 1999)"
    }

    fn target(&self, settings: &Settings) -> Option<f64> {
        Some(settings.chance + (1.0 - settings.chance) * WAY)
    }

    fn start(&self, settings: &Settings) -> Box<dyn Staircase> {
        let scale = settings.scale;
        let [low, high] =
            [settings.least, settings.most].map(|l| libm::log(scale.percent(l).max(1e-3)));
        let grid = |n: usize, i: usize| low + (high - low) * i as f64 / (n - 1) as f64;
        let ln_threshold: Vec<f64> = (0..N_THRESHOLD).map(|i| grid(N_THRESHOLD, i)).collect();
        let ln_x: Vec<f64> = (0..N_LEVELS).map(|i| grid(N_LEVELS, i)).collect();
        let n = N_THRESHOLD * N_BETA;
        let shape = Shape::new(Family::Detection, settings.chance);
        let mut psi = Posterior {
            z_at_threshold: shape.ln_x_at(WAY, 0.0, 1.0),
            target: self.target(settings).unwrap_or(0.5),
            chance: settings.chance,
            scale,
            shape,
            start: settings.start,
            tables: Vec::with_capacity(N_LEVELS),
            weights: vec![1.0 / n as f64; n],
            ln_threshold,
            answers: 0,
        };
        for ln_x in ln_x {
            let right: Vec<f64> = psi.cells().map(|(a, b)| psi.right(ln_x, a, b)).collect();
            let entropy = right.iter().map(|&p| entropy(p)).collect();
            psi.tables.push(Table {
                ln_x,
                right,
                entropy,
            });
        }
        Box::new(psi)
    }
}

/// What a trial at one level would do, for every cell of the posterior.
struct Table {
    ln_x: f64,
    /// Share of right answers.
    right: Vec<f64>,
    /// Entropy of the answer.
    entropy: Vec<f64>,
}

struct Posterior {
    target: f64,
    chance: f64,
    scale: Scale,
    shape: Shape,
    /// β ln(x/α) at the threshold.
    z_at_threshold: f64,
    start: f64,
    ln_threshold: Vec<f64>,
    tables: Vec<Table>,
    /// Over cells of threshold and slope, slopes running fastest.
    weights: Vec<f64>,
    answers: u32,
}

impl Posterior {
    fn cells(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let [low, high] = BETA.map(libm::log);
        let beta = move |j: usize| libm::exp(low + (high - low) * j as f64 / (N_BETA - 1) as f64);
        self.ln_threshold
            .iter()
            .flat_map(move |&a| (0..N_BETA).map(move |j| (a, beta(j))))
    }

    /// Share of right answers in a cell, its threshold by its logarithm.
    fn right(&self, ln_x: f64, ln_threshold: f64, beta: f64) -> f64 {
        let ln_alpha = ln_threshold - self.z_at_threshold / beta;
        let f = self.shape.share(ln_x, ln_alpha, beta);
        self.chance + (1.0 - self.chance - LAPSE).max(0.01) * f
    }
}

impl Staircase for Posterior {
    /// The information that an answer gives of the cell is that of the answer, less what is chance in every cell: the same as
    /// the expected fall of the posterior's entropy.
    fn level(&mut self, _: &mut Random) -> f64 {
        if self.answers == 0 {
            return self.start;
        }
        let told = |table: &Table| {
            let mean =
                |of: &[f64]| -> f64 { of.iter().zip(&self.weights).map(|(v, w)| v * w).sum() };
            entropy(mean(&table.right)) - mean(&table.entropy)
        };
        let best = (self.tables.iter())
            .map(|table| (told(table), table.ln_x))
            .reduce(|best, next| if next.0 > best.0 { next } else { best });
        best.map_or(self.start, |(_, ln_x)| self.scale.level(libm::exp(ln_x)))
    }

    fn answered(&mut self, level: f64, right: bool) {
        let ln_x = libm::log(self.scale.percent(level).max(1e-3));
        let likelihoods: Vec<f64> = self
            .cells()
            .map(|(a, b)| {
                let p = self.right(ln_x, a, b);
                if right { p } else { 1.0 - p }
            })
            .collect();
        let mut sum = 0.0;
        for (weight, likelihood) in self.weights.iter_mut().zip(likelihoods) {
            *weight *= likelihood;
            sum += *weight;
        }
        // No answer is impossible: chance and lapses see to it.
        if sum > 0.0 {
            self.weights.iter_mut().for_each(|w| *w /= sum);
        }
        self.answers += 1;
    }

    fn is_done(&self) -> bool {
        false
    }

    fn reversals(&self) -> &[f64] {
        &[]
    }

    fn estimate(&self) -> Option<Estimate> {
        if self.answers == 0 {
            return None;
        }
        let weighed = |of: &dyn Fn(f64) -> f64| -> f64 {
            let cells = self.cells().zip(&self.weights);
            cells.map(|((a, _), w)| w * of(a)).sum()
        };
        let mean = weighed(&|a| a);
        let sd = weighed(&|a| (a - mean) * (a - mean)).max(0.0).sqrt();
        let level = |ln_x: f64| self.scale.level(libm::exp(ln_x));
        Some(Estimate {
            level: level(mean),
            // Half the way between one standard deviation below and above, in units of the level.
            standard_error: Some(0.5 * (level(mean + sd) - level(mean - sd))),
            target: self.target,
        })
    }
}

/// Entropy of a choice of two, in nats.
fn entropy(p: f64) -> f64 {
    let term = |p: f64| if p > 0.0 { -p * libm::log(p) } else { 0.0 };
    term(p) + term(1.0 - p)
}
