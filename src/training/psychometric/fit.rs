//! Maximum likelihood.

use super::family::{Family, Shape};
use nalgebra::{Matrix3, Vector3};

/// Answers at one strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Strength, such as a percentage; ≥ 0.
    pub x: f64,
    /// Trials.
    pub n: u32,
    /// Right ones, at most `n`.
    pub right: u32,
}

/// Trials gathered by strength, in rising order. A strength that is no number, or below 0, is left out.
pub fn points(trials: impl IntoIterator<Item = (f64, bool)>) -> Vec<Point> {
    let mut sorted: Vec<(f64, bool)> = trials
        .into_iter()
        .filter(|t| t.0 >= 0.0 && t.0.is_finite())
        .collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut points: Vec<Point> = Vec::new();
    for (x, right) in sorted {
        let right = u32::from(right);
        match points.last_mut() {
            // A staircase comes back to a level by another way, off by a rounding.
            Some(last) if x - last.x <= 1.0e-9 * x => {
                last.n += 1;
                last.right += right;
            }
            _ => points.push(Point { x, n: 1, right }),
        }
    }
    points
}

/// What is taken of the lapse rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lapse {
    /// It is this.
    Fixed(f64),
    /// It is fitted between 0 and this.
    UpTo(f64),
}

/// What is fitted.
#[derive(Clone, Debug)]
pub struct Model {
    /// Shape between guessing and certainty.
    pub shape: Shape,
    /// Share of right answers by guessing.
    pub chance: f64,
    /// Lapse rate.
    pub lapse: Lapse,
}

/// Slopes that are fitted: beyond them a function is a step, or flat, for any set of answers.
const BETA: [f64; 2] = [0.2, 15.0];
/// How far outside the strengths that were given a threshold is looked for, as a factor.
const OUTSIDE: f64 = 8.0;

impl Model {
    /// A model of this family for answers of which `chance` are right by guessing; the lapse rate is fitted up to 6 %
    /// (Wichmann & Hill 2001a).
    pub fn new(family: Family, chance: f64) -> Self {
        Self {
            shape: Shape::new(family, chance),
            chance: chance.clamp(0.0, 0.99),
            lapse: Lapse::UpTo(0.06),
        }
    }

    /// With another lapse rate.
    #[must_use]
    pub fn with_lapse(mut self, lapse: Lapse) -> Self {
        self.lapse = lapse;
        self
    }

    fn lapse_bounds(&self) -> [f64; 2] {
        let most = 0.99 - self.chance;
        match self.lapse {
            Lapse::Fixed(lapse) => [lapse.clamp(0.0, most); 2],
            Lapse::UpTo(bound) => [0.0, bound.clamp(0.0, most)],
        }
    }

    /// Share of right answers at a strength, for (ln α, ln β, λ).
    fn share(&self, ln_x: f64, [ln_alpha, ln_beta, lapse]: [f64; 3]) -> f64 {
        let f = self.shape.share(ln_x, ln_alpha, libm::exp(ln_beta));
        self.chance + (1.0 - self.chance - lapse) * f
    }

    /// The parameters under which the answers are likeliest.
    ///
    /// A grid over all that is allowed finds the best hill, Fisher scoring its top (Nelder & Wedderburn 1972), held inside
    /// the bounds. `None` for answers at fewer than two strengths above 0: they tell nothing of a slope.
    pub fn fit(&self, points: &[Point]) -> Option<Fit> {
        let data = Data::new(points)?;
        let bounds = data.bounds(self);
        let start = data.best_of_grid(self, &bounds);
        Some(data.climb(self, &bounds, &start))
    }

    /// The logarithm of the likelihood where the threshold at `share` has the logarithm `ln_x`, and slope and lapse rate are
    /// those under which the answers are then likeliest.
    pub(super) fn profile(
        &self,
        points: &[Point],
        share: f64,
        ln_x: f64,
        near: &Fit,
    ) -> Option<f64> {
        let mut data = Data::new(points)?;
        data.anchor = self
            .shape
            .ln_x_at((share - self.chance) / (1.0 - self.chance), 0.0, 1.0);
        let [_, beta, lapse] = data.bounds(self);
        let bounds = [[ln_x; 2], beta, lapse];
        let start = data.near_start(self, &bounds, near);
        Some(data.climb(self, &bounds, &[start]).log_likelihood)
    }

    /// The same from a start that is near already, for one of many samples.
    pub(super) fn refit(&self, points: &[Point], near: &Fit) -> Option<Fit> {
        let data = Data::new(points)?;
        let bounds = data.bounds(self);
        let start = data.near_start(self, &bounds, near);
        Some(data.climb(self, &bounds, &[start]))
    }
}

/// A fitted psychometric function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// ln α, ln β, λ.
    pub(super) at: [f64; 3],
    /// Logarithm of the likelihood, without the constant of the binomials.
    pub log_likelihood: f64,
    /// Twice the logarithm of how much likelier the answers are where every strength has its own share: about χ² with as many
    /// degrees of freedom as strengths less parameters where the model is right and each strength has many trials.
    pub deviance: f64,
    /// Whether a parameter ran into a bound: the answers do not tell it.
    pub at_bound: bool,
}

impl Fit {
    /// α: what of the strength it is, the [`Family`] says.
    pub fn alpha(&self) -> f64 {
        libm::exp(self.at[0])
    }

    /// Slope β.
    pub fn beta(&self) -> f64 {
        libm::exp(self.at[1])
    }

    /// Lapse rate λ.
    pub fn lapse(&self) -> f64 {
        self.at[2]
    }

    /// Share of right answers at a strength ≥ 0.
    pub fn share(&self, model: &Model, x: f64) -> f64 {
        model.share(ln(x), self.at)
    }

    /// The strength at which `share` of the answers are right for one who never lapses; the share is brought between chance
    /// and 1.
    pub fn threshold(&self, model: &Model, share: f64) -> f64 {
        let f = (share - model.chance) / (1.0 - model.chance);
        libm::exp(model.shape.ln_x_at(f, self.at[0], self.beta()))
    }
}

fn ln(x: f64) -> f64 {
    if x > 0.0 {
        libm::log(x)
    } else {
        f64::NEG_INFINITY
    }
}

/// Answers made ready for many evaluations.
struct Data {
    ln_x: Vec<f64>,
    n: Vec<f64>,
    right: Vec<f64>,
    /// What β (ln x − t) + anchor is at t, the first parameter: 0 where t is ln α, else t is the threshold at a share.
    anchor: f64,
}

impl Data {
    fn new(points: &[Point]) -> Option<Self> {
        let used = || {
            points
                .iter()
                .filter(|p| p.n > 0 && p.x >= 0.0 && p.x.is_finite())
        };
        if used().filter(|p| p.x > 0.0).count() < 2 {
            return None;
        }
        Some(Self {
            ln_x: used().map(|p| ln(p.x)).collect(),
            n: used().map(|p| f64::from(p.n)).collect(),
            right: used().map(|p| f64::from(p.right.min(p.n))).collect(),
            anchor: 0.0,
        })
    }

    fn bounds(&self, model: &Model) -> [[f64; 2]; 3] {
        let finite = || self.ln_x.iter().copied().filter(|x| x.is_finite());
        let low = finite().fold(f64::INFINITY, f64::min);
        let high = finite().fold(f64::NEG_INFINITY, f64::max);
        let outside = libm::log(OUTSIDE);
        [
            [low - outside, high + outside],
            BETA.map(libm::log),
            model.lapse_bounds(),
        ]
    }

    fn log_likelihood(&self, model: &Model, at: [f64; 3]) -> f64 {
        let shift = self.anchor / libm::exp(at[1]);
        let mut sum = 0.0;
        for ((&ln_x, &n), &right) in self.ln_x.iter().zip(&self.n).zip(&self.right) {
            let p = within(model.share(ln_x, [at[0] - shift, at[1], at[2]]));
            sum += right * libm::log(p) + (n - right) * libm::log(1.0 - p);
        }
        sum
    }

    fn best_of_grid(&self, model: &Model, bounds: &[[f64; 2]; 3]) -> Vec<[f64; 3]> {
        const N_ALPHA: usize = 16;
        const N_BETA: usize = 8;
        let lapses = if bounds[2][0] == bounds[2][1] { 1 } else { 3 };
        let mut all: Vec<([f64; 3], f64)> = Vec::with_capacity(N_ALPHA * N_BETA * lapses);
        for i in 0..N_ALPHA {
            for j in 0..N_BETA {
                for k in 0..lapses {
                    let at = [
                        between(bounds[0], i, N_ALPHA),
                        between(bounds[1], j, N_BETA),
                        between(bounds[2], k, lapses),
                    ];
                    all.push((at, self.log_likelihood(model, at)));
                }
            }
        }
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        // Neighbours on the grid climb to one top: the few best do.
        all.truncate(3);
        all.into_iter().map(|(at, _)| at).collect()
    }

    /// The best of a place that is near already and a few around it.
    fn near_start(&self, model: &Model, bounds: &[[f64; 2]; 3], near: &Fit) -> [f64; 3] {
        let [low, high] = bounds[0];
        let inside = |t: f64| t.clamp(low, high);
        let first = [inside(near.at[0]), near.at[1], near.at[2]];
        let mut best = (self.log_likelihood(model, first), first);
        let steps = if low < high { 2 } else { 0 };
        for step in -steps..=steps {
            for j in 0..3 {
                let at = [
                    inside(near.at[0] + 0.3 * f64::from(step)),
                    between(bounds[1], j, 3),
                    between(bounds[2], 1, 4),
                ];
                let found = self.log_likelihood(model, at);
                if found > best.0 {
                    best = (found, at);
                }
            }
        }
        best.1
    }

    /// The best top that is climbed to from the starts.
    fn climb(&self, model: &Model, bounds: &[[f64; 2]; 3], starts: &[[f64; 3]]) -> Fit {
        let mut best = ([0.0; 3], f64::NEG_INFINITY);
        for &start in starts {
            let top = self.climb_from(model, bounds, start);
            if top.1 > best.1 {
                best = top;
            }
        }
        let (at, log_likelihood) = best;
        let near = |i: usize| {
            let width = bounds[i][1] - bounds[i][0];
            (at[i] - bounds[i][0]).min(bounds[i][1] - at[i]) < 1.0e-6 * width
        };
        Fit {
            at,
            log_likelihood,
            deviance: (2.0 * (self.saturated() - log_likelihood)).max(0.0),
            // A lapse rate of 0 is no fault of the answers.
            at_bound: near(0) || near(1),
        }
    }

    fn saturated(&self) -> f64 {
        let term = |k: f64, n: f64| if k > 0.0 { k * libm::log(k / n) } else { 0.0 };
        let each = self.n.iter().zip(&self.right);
        each.map(|(&n, &right)| term(right, n) + term(n - right, n))
            .sum()
    }

    /// Fisher scoring with a damping that grows until a step climbs (Marquardt 1963), inside the bounds.
    fn climb_from(
        &self,
        model: &Model,
        bounds: &[[f64; 2]; 3],
        start: [f64; 3],
    ) -> ([f64; 3], f64) {
        let clamp = |at: [f64; 3]| std::array::from_fn(|i| at[i].clamp(bounds[i][0], bounds[i][1]));
        let mut at: [f64; 3] = clamp(start);
        let mut value = self.log_likelihood(model, at);
        let mut damping = 1.0e-3;
        for _ in 0..60 {
            let (gradient, fisher) = self.scores(model, at);
            // A parameter at its bound that wants to go beyond stays there.
            let free: [bool; 3] = std::array::from_fn(|i| {
                let [low, high] = bounds[i];
                low < high
                    && !(at[i] <= low && gradient[i] <= 0.0)
                    && !(at[i] >= high && gradient[i] >= 0.0)
            });
            let mut climbed = false;
            for _ in 0..12 {
                let step = solve(fisher, gradient, free, damping);
                let next = clamp(std::array::from_fn(|i| at[i] + step[i].clamp(-1.0, 1.0)));
                let found = self.log_likelihood(model, next);
                if found > value {
                    let gained = found - value;
                    (at, value, climbed) = (next, found, gained > 1.0e-8);
                    damping = (damping * 0.2).max(1.0e-9);
                    break;
                }
                damping = (damping * 6.0).min(1.0e9);
            }
            if !climbed {
                break;
            }
        }
        (at, value)
    }

    /// Gradient and expected information at a place.
    fn scores(&self, model: &Model, at: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
        let (mut gradient, mut fisher) = ([0.0; 3], [[0.0; 3]; 3]);
        let (beta, rest) = (libm::exp(at[1]), 1.0 - model.chance - at[2]);
        for ((&ln_x, &n), &right) in self.ln_x.iter().zip(&self.n).zip(&self.right) {
            let z = beta * (ln_x - at[0]);
            let (f, slope) = if z.is_finite() {
                model.shape.share_and_slope(z + self.anchor)
            } else {
                (0.0, 0.0)
            };
            let p = within(model.chance + rest * f);
            let along = if z.is_finite() { z } else { 0.0 };
            let d = [-beta * rest * slope, along * rest * slope, -f];
            let weight = n / (p * (1.0 - p));
            let score = (right - n * p) / (p * (1.0 - p));
            for i in 0..3 {
                gradient[i] += score * d[i];
                for j in 0..3 {
                    fisher[i][j] += weight * d[i] * d[j];
                }
            }
        }
        (gradient, fisher)
    }
}

/// A share that has a logarithm.
fn within(p: f64) -> f64 {
    p.clamp(1.0e-12, 1.0 - 1.0e-12)
}

/// Number `i` of `n` values evenly between two bounds, both among them where there is more than one.
fn between([low, high]: [f64; 2], i: usize, n: usize) -> f64 {
    low + (high - low) * i as f64 / (n.max(2) - 1) as f64
}

/// The damped step of the free parameters; the others stay.
fn solve(fisher: [[f64; 3]; 3], gradient: [f64; 3], free: [bool; 3], damping: f64) -> [f64; 3] {
    let a = Matrix3::from_fn(|i, j| match (free[i] && free[j], i == j) {
        (true, true) => fisher[i][i] + damping * (fisher[i][i] + 1.0e-6),
        (true, false) => fisher[i][j],
        (false, true) => 1.0,
        (false, false) => 0.0,
    });
    let b = Vector3::from_fn(|i, _| if free[i] { gradient[i] } else { 0.0 });
    let step = a.lu().solve(&b).unwrap_or_default();
    if step.iter().all(|x| x.is_finite()) {
        step.into()
    } else {
        [0.0; 3]
    }
}
