//! A simulated observer: a trainee whose sensitivity is known, to try exercises and to see what their figures are worth.
//!
//! It palpates by a fixed policy ([`Hand`]), and takes of each place the logarithm of the ratio of its stiffness to what it
//! was where nothing was hidden, which a trained finger knows. To it comes noise, so that a place whose ratio is ρ differs by
//! d′ = s |ln ρ| from one that is as it was, s being the observer's sensitivity. A factor on all stiffness of a trial is common
//! to all places and so tells nothing.

mod hand;
#[cfg(test)]
mod tests;

use super::detection::{ForcedChoice, root, same_different_hit_share};
use super::level::log_ratio;
use super::normal::quantile;
use super::random::Random;
use super::run::{Input, TrainingError};
use super::shown::{Phase, Shown};
use super::sitting::Sitting;
use super::trial::{Answer, Mark, Reply, TrialRecord};
use crate::geom::Vec2;
use crate::scenario::Exercise;
use crate::scenario::exercise::Hides;
use std::fmt;
use std::str::FromStr;

pub use hand::{Hand, Pressing, Reading};

/// An observer whose sensitivity is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer {
    /// d′ for each unit of the logarithm of the ratio of stiffness: a compliance 28 % lower is 0.329 of them.
    pub d_prime: f64,
    /// Share of answers given without having felt anything, 0 … 1.
    pub lapse: f64,
    /// How much more the first of two places feels than it is, in standard deviations of the noise.
    pub bias: f64,
    /// Share of pairs alike that are called different, 0 … 1.
    pub false_alarms: f64,
    /// Whether it presses the skin, tick by tick; else it reads the stiffness map.
    pub felt: bool,
}

impl Default for Observer {
    fn default() -> Self {
        Self {
            d_prime: 10.0,
            lapse: 0.0,
            bias: 0.0,
            false_alarms: 0.2,
            felt: true,
        }
    }
}

impl fmt::Display for Observer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let policy = if self.felt { "press" } else { "read" };
        write!(
            f,
            "d-prime={},lapse={},bias={},false-alarms={},policy={policy}",
            self.d_prime, self.lapse, self.bias, self.false_alarms
        )
    }
}

impl FromStr for Observer {
    type Err = String;

    /// As it is shown; what is left out has its default.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut observer = Self::default();
        for part in text.split(',').filter(|p| !p.trim().is_empty()) {
            let (key, value) = part
                .split_once('=')
                .ok_or_else(|| format!("{part:?}; key=value is needed, as in d-prime=10"))?;
            let (key, value) = (key.trim(), value.trim());
            let number = |allowed: std::ops::RangeInclusive<f64>| {
                let read = value.parse().ok().filter(|x| allowed.contains(x));
                let (least, most) = (allowed.start(), allowed.end());
                read.ok_or_else(|| format!("{key} = {value:?}; {least} to {most} is allowed"))
            };
            match key {
                "d-prime" => observer.d_prime = number(0.0..=1000.0)?,
                "lapse" => observer.lapse = number(0.0..=1.0)?,
                "bias" => observer.bias = number(-10.0..=10.0)?,
                "false-alarms" => observer.false_alarms = number(0.001..=0.999)?,
                "policy" => {
                    observer.felt = match value {
                        "press" => true,
                        "read" => false,
                        _ => return Err(format!("policy = {value:?}; allowed are press, read")),
                    }
                }
                _ => {
                    return Err(format!(
                        "{key:?}; allowed are d-prime, lapse, bias, false-alarms, policy"
                    ));
                }
            }
        }
        Ok(observer)
    }
}

impl Observer {
    /// Share of its right answers to `exercise` where the logarithm of the ratio of stiffness is `log_ratio`; without bias.
    /// `None` for tasks that have no such share.
    pub fn right_share(&self, exercise: &Exercise, log_ratio: f64) -> Option<f64> {
        let d_prime = self.d_prime * log_ratio.abs();
        let (right, chance) = match exercise.task {
            "locate" => {
                let forced = ForcedChoice::new(exercise.candidates.len() as u32);
                (forced.share(d_prime), forced.chance())
            }
            "compare" => (ForcedChoice::new(2).share(d_prime), 0.5),
            "same-different" => {
                let hits = same_different_hit_share(d_prime, self.false_alarms);
                (0.5 * (hits + 1.0 - self.false_alarms), 0.5)
            }
            _ => return None,
        };
        Some((1.0 - self.lapse) * right + self.lapse * chance)
    }

    /// The logarithm of the ratio at which this share of its answers would be right if it never lapsed.
    pub fn threshold(&self, exercise: &Exercise, share: f64) -> Option<f64> {
        let never = Self {
            lapse: 0.0,
            ..*self
        };
        never.right_share(exercise, 0.0)?;
        let most = super::detection::MOST_D_PRIME / self.d_prime.max(1e-6);
        Some(root(0.0, most, |ratio| {
            never.right_share(exercise, ratio).unwrap_or(0.0) - share
        }))
    }

    /// Does the trial at hand of a sitting: palpates, answers, goes on to the next. `now_s` is simulated time.
    ///
    /// # Errors
    /// As [`Sitting::take`]; a place cannot be pressed.
    pub fn do_trial(
        &self,
        sitting: &mut Sitting,
        hand: &mut dyn Hand,
        random: &mut Random,
        now_s: &mut f64,
    ) -> Result<TrialRecord, TrainingError> {
        sitting.take(Input::Start, *now_s)?;
        let shown = sitting.run().shown();
        let places = places(&shown);
        let scenario = sitting.run().hidden_scenario().clone();
        let felt = hand.feel(&scenario, &places, &mut |tick, dt_s| {
            sitting.feel(tick, dt_s)
        })?;
        *now_s += felt.seconds;
        sitting.advance(*now_s)?;
        if sitting.run().shown().phase == Phase::Palpating {
            sitting.take(Input::Enough, *now_s)?;
        }
        let reply = self.answer(sitting.run().exercise(), &shown, &felt.log_ratios, random);
        *now_s += 0.5;
        let record = sitting.take(Input::Answer(reply), *now_s)?;
        if sitting.run().shown().phase == Phase::Feedback {
            sitting.take(Input::Next, *now_s)?;
        }
        record.ok_or_else(|| TrainingError("the exercise was over before the answer".into()))
    }

    /// What it answers to what it felt at [`places`].
    fn answer(
        &self,
        exercise: &Exercise,
        shown: &Shown,
        log_ratios: &[f64],
        random: &mut Random,
    ) -> Reply {
        let softer = match exercise.hides {
            Hides::Drawn { change, .. } => change.factor() < 1.0,
            Hides::Stated => false,
        };
        let side = if softer { -1.0 } else { 1.0 };
        let felt: Vec<f64> = log_ratios
            .iter()
            .map(|x| self.d_prime * x + random.normal())
            .collect();
        let lapses = random.unit() < self.lapse;
        let guess = random.below(shown.choices.len());
        let n_pointed = shown.pointed.len();
        let answer = match shown.choices.get(guess) {
            Some(choice) if lapses => choice.answer.clone(),
            _ => match exercise.task {
                "locate" => strongest(&felt, side)
                    .and_then(|i| exercise.candidates.get(i))
                    .map_or(Answer::Here(Vec2::ZERO), |site| Answer::Site(*site)),
                "compare" => Answer::Stiffer(usize::from(felt[1] > felt[0] + self.bias)),
                "same-different" => {
                    let k = -std::f64::consts::SQRT_2 * quantile(0.5 * self.false_alarms);
                    Answer::Same((felt[0] - felt[1]).abs() <= k)
                }
                "severity" => self.grade(exercise, side * (felt[0] - middle(&felt[n_pointed..]))),
                "level" => counted(exercise, shown, random),
                _ => self.marks(exercise, &felt, side, lapses),
            },
        };
        let confident = (!felt.is_empty()).then(|| sureness(&felt, side));
        Reply {
            confidence_percent: confident.or(Some(50)).filter(|_| exercise.asks_confidence),
            kind: match exercise.hides {
                Hides::Drawn { kind, .. } if exercise.asks_kind => Some(kind.to_owned()),
                _ => None,
            },
            severity: Some(2).filter(|_| exercise.asks_severity),
            answer,
        }
    }

    /// The grade whose change is nearest to what is felt.
    fn grade(&self, exercise: &Exercise, felt: f64) -> Answer {
        use crate::scenario::Change::{CompliancePercent, StiffnessPercent};
        let Hides::Drawn { change, .. } = exercise.hides else {
            return Answer::Severity(0);
        };
        let off = |grade: u8| {
            let part = f64::from(grade) / 3.0;
            let change = match change {
                CompliancePercent(p) => CompliancePercent(p * part),
                StiffnessPercent(p) => StiffnessPercent(p * part),
            };
            (self.d_prime * log_ratio(change) - felt).abs()
        };
        let nearest = (0..4).min_by(|&a, &b| off(a).total_cmp(&off(b)));
        Answer::Severity(nearest.unwrap_or(0))
    }

    /// Marks what stands out by more than half of what is hidden, and by more than noise does once in a hundred searches.
    fn marks(&self, exercise: &Exercise, felt: &[f64], side: f64, lapses: bool) -> Answer {
        let half = match exercise.hides {
            Hides::Drawn { change, .. } => 0.5 * self.d_prime * log_ratio(change),
            Hides::Stated => 0.0,
        };
        let noise = -quantile(0.01 / felt.len().max(1) as f64);
        let (usual, least) = (middle(felt), half.max(noise));
        let found = exercise.candidates.iter().zip(felt);
        let found = found.filter(|(_, f)| !lapses && side * (*f - usual) > least);
        let mark = |site: &crate::scenario::Site| Mark {
            at_mm: site.at_mm(),
            kind: None,
            severity: None,
        };
        Answer::Marks(found.map(|(site, _)| mark(site)).collect())
    }
}

/// The places that a trial makes one feel, in the order of the policy: what is pointed at, then the candidates where they are
/// asked about.
pub fn places(shown: &Shown) -> Vec<Vec2> {
    let pointed = shown.pointed.iter().map(|p| p.at_mm);
    let asks_candidates = shown.pointed.len() != 2;
    let candidates = shown.candidates.iter().filter(|_| asks_candidates);
    pointed.chain(candidates.map(|s| s.at_mm())).collect()
}

fn strongest(felt: &[f64], side: f64) -> Option<usize> {
    let by = |a: &usize, b: &usize| (side * felt[*a]).total_cmp(&(side * felt[*b]));
    (0..felt.len()).max_by(by)
}

/// The median: what is usual among places of which few are changed.
fn middle(felt: &[f64]) -> f64 {
    let mut sorted = felt.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

/// How far the strongest stands out from the next, as a percentage.
fn sureness(felt: &[f64], side: f64) -> u8 {
    let mut sorted: Vec<f64> = felt.iter().map(|f| side * f).collect();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let lead = sorted[0] - sorted.get(1).copied().unwrap_or(0.0);
    (100.0 * (1.0 - libm::exp(-lead))).clamp(0.0, 100.0) as u8
}

/// Counts vertebrae: a place is taken for one that is off by noise of half the height of a vertebra.
fn counted(exercise: &Exercise, shown: &Shown, random: &mut Random) -> Answer {
    const OFF_MM: f64 = 12.0;
    let at_mm = shown.pointed.first().map_or(0.0, |p| p.at_mm.y) + OFF_MM * random.normal();
    let off = |s: &&crate::scenario::Site| (s.at_mm().y - at_mm).abs();
    let nearest = (exercise.candidates.iter()).min_by(|a, b| off(a).total_cmp(&off(b)));
    nearest.map_or(Answer::Here(Vec2::ZERO), |site| Answer::Level(site.level))
}
