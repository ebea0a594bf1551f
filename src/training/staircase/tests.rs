//! Every rule: where it goes, within the error that theory gives it; the same answers, the same state.

use super::*;
use crate::scenario::exercise::{Measure, RULES, Staircase as Stated};
use crate::training::detection::{ForcedChoice, root};
use crate::training::level::log_ratio;
use proptest::prelude::*;

const CHANCE: f64 = 1.0 / 12.0;

fn settings(step: Step) -> Settings {
    let stated = Stated {
        step,
        ..Stated::default()
    };
    Settings::new(&stated, Change::CompliancePercent(-28.0), CHANCE)
}

#[test]
fn the_list_is_what_a_file_may_state() {
    let keys: Vec<&str> = all().iter().map(|rule| rule.key()).collect();
    assert_eq!(keys, RULES);
    for rule in all() {
        assert_eq!(by_key(rule.key()).map(|r| r.title()), Some(rule.title()));
    }
}

#[test]
fn rules_go_to_the_published_shares() {
    let target = |key: &str| by_key(key).and_then(|r| r.target(&settings(Step::Decibel(2.0))));
    for (key, percent) in [
        // García-Pérez 1998, table 1, as METHOD section 7 gives them.
        ("1-up-2-down", 80.35),
        ("1-up-3-down", 83.15),
        ("1-up-4-down", 85.84),
        // Levitt 1971.
        ("1-up-2-down-equal", 70.7),
        ("1-up-3-down-equal", 79.4),
        ("1-up-4-down-equal", 84.1),
        ("weighted-up-down", 75.0),
    ] {
        let found = 100.0 * target(key).expect("a target");
        let digits = if percent == 80.35 || key.ends_with("3-down") || key.ends_with("4-down") {
            0.0051
        } else {
            0.051
        };
        assert!((found - percent).abs() < digits, "{key}: {found}");
    }
    assert_eq!(target("constant"), None);
}

/// An observer among 12 alternatives, d′ = 10 per unit of the logarithm of the stiffness ratio.
struct Simulated {
    forced: ForcedChoice,
    scale: Scale,
}

impl Simulated {
    fn new(scale: Scale) -> Self {
        Self {
            forced: ForcedChoice::new(12),
            scale,
        }
    }

    fn share(&self, level: f64) -> f64 {
        self.forced
            .share(10.0 * log_ratio(self.scale.change(level)))
    }

    fn threshold(&self, settings: &Settings, target: f64) -> f64 {
        root(settings.least, settings.most, |level| {
            self.share(level) - target
        })
    }

    /// Estimates of many runs.
    fn estimates(
        &self,
        rule: &dyn Rule,
        settings: &Settings,
        trials: u32,
        repeats: u64,
    ) -> Vec<f64> {
        (0..repeats)
            .map(|seed| {
                let mut random = Random::new(seed);
                let mut staircase = rule.start(settings);
                for _ in 0..trials {
                    let level = staircase.level(&mut random);
                    let right = random.unit() < self.share(level);
                    staircase.answered(level, right);
                }
                staircase.estimate().expect("enough trials").level
            })
            .collect()
    }
}

fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    (mean, (squares / (n - 1.0)).sqrt())
}

#[test]
fn every_adaptive_rule_comes_to_the_observers_threshold_within_the_error_of_theory() {
    const TRIALS: u32 = 200;
    let settings = settings(Step::Decibel(1.0));
    let observer = Simulated::new(settings.scale);
    for &rule in all() {
        let Some(target) = rule.target(&settings) else {
            continue;
        };
        let truth = observer.threshold(&settings, target);
        // The least error that trials given at the threshold itself allow (Taylor & Creelman 1967), in dB.
        let h = 1.0e-3;
        let slope = (observer.share(truth + h) - observer.share(truth - h)) / (2.0 * h);
        let least = (target * (1.0 - target) / f64::from(TRIALS)).sqrt() / slope;
        let (mean, sd) = mean_and_sd(&observer.estimates(rule, &settings, TRIALS, 100));
        let key = rule.key();
        assert!(
            (mean - truth).abs() < least,
            "{key}: {mean} instead of {truth} ± {least}"
        );
        assert!(
            sd > 0.6 * least && sd < 2.0 * least,
            "{key}: spreads by {sd}, theory {least}"
        );
    }
}

#[test]
fn an_up_down_walk_stays_where_its_markov_chain_does() {
    // A second way to the same: the chain over levels and answers in a row, by powers of its matrix, on a lattice.
    let settings = Settings {
        start: 30.0,
        ..settings(Step::Decibel(1.0))
    };
    let observer = Simulated::new(settings.scale);
    let n_levels = 38;
    let level = |i: usize| i as f64;
    let at = |i: usize, row: usize| 2 * i + row;
    let mut chain = vec![0.0; 2 * n_levels];
    chain[at(30, 0)] = 1.0;
    for _ in 0..4000 {
        let mut next = vec![0.0; chain.len()];
        for i in 0..n_levels {
            let p = observer.share(level(i));
            for row in 0..2 {
                let here = chain[at(i, row)];
                next[at((i + 1).min(n_levels - 1), 0)] += here * (1.0 - p);
                let (to, answered) = if row == 1 {
                    (i.saturating_sub(1), 0)
                } else {
                    (i, 1)
                };
                next[at(to, answered)] += here * p;
            }
        }
        chain = next;
    }
    let expected: f64 = (0..n_levels)
        .map(|i| level(i) * (chain[at(i, 0)] + chain[at(i, 1)]))
        .sum();
    let rule = by_key("1-up-2-down-equal").expect("listed");
    let (mut random, mut staircase) = (Random::new(3), rule.start(&settings));
    let mut batch = |n: u32| {
        let mut sum = 0.0;
        for _ in 0..n {
            let level = staircase.level(&mut random);
            let right = random.unit() < observer.share(level);
            staircase.answered(level, right);
            sum += level;
        }
        sum / f64::from(n)
    };
    batch(500);
    // Batches are long against the memory of the walk, so that their spread gives the error of their mean.
    let batches: Vec<f64> = (0..100).map(|_| batch(1000)).collect();
    let (mean, sd) = mean_and_sd(&batches);
    let error = sd / 10.0;
    assert!(
        (mean - expected).abs() < 4.0 * error,
        "{mean} ± {error} instead of {expected}"
    );
}

#[test]
fn steps_go_the_published_ways() {
    let mut settings = settings(Step::Decibel(2.0));
    settings.start = settings.scale.level(20.0);
    let mut staircase = by_key("1-up-2-down").expect("listed").start(&settings);
    let mut random = Random::new(0);
    let mut levels = Vec::new();
    for right in [true, true, false, true, true, true, true, false, false] {
        let level = staircase.level(&mut random);
        levels.push(level - settings.start);
        staircase.answered(level, right);
    }
    let down = 2.0 * 0.5488;
    // Twice as far until it has turned once.
    let expected = [0.0, 0.0, -2.0 * down, 2.0 - 2.0 * down, 2.0 - 2.0 * down];
    for (found, expected) in levels.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{levels:?}");
    }
    assert!(
        (levels[6] - levels[5] - 0.0).abs() < 1e-12 && (levels[5] - levels[4] + down).abs() < 1e-12
    );
    assert_eq!(staircase.reversals().len(), 3);
}

#[test]
fn it_is_done_after_its_reversals() {
    let mut settings = settings(Step::Percent(2.0));
    settings.reversals = Some(4);
    let mut staircase = by_key("1-up-2-down-equal")
        .expect("listed")
        .start(&settings);
    let mut random = Random::new(1);
    for i in 0.. {
        if staircase.is_done() {
            break;
        }
        let level = staircase.level(&mut random);
        staircase.answered(level, i % 3 != 2);
        assert!(i < 30);
    }
    assert_eq!(staircase.reversals().len(), 4);
    // All of them are left out of the estimate.
    assert_eq!(staircase.estimate(), None);
}

#[test]
fn constant_stimuli_come_equally_often_in_an_order_of_chance() {
    let settings = settings(Step::Percent(1.0));
    let order = |seed| {
        let mut staircase = by_key("constant").expect("listed").start(&settings);
        let mut random = Random::new(seed);
        let levels: Vec<f64> = (0..60)
            .map(|_| {
                let level = staircase.level(&mut random);
                staircase.answered(level, random.below(2) == 0);
                level
            })
            .collect();
        for block in levels.chunks(6) {
            let mut sorted = block.to_vec();
            sorted.sort_by(f64::total_cmp);
            assert_eq!(sorted, settings.constant);
        }
        levels
    };
    assert_ne!(order(1), order(2));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn any_answers_keep_every_rule_in_its_bounds_and_bring_it_to_the_same_state(
        answers in prop::collection::vec(any::<bool>(), 0..60),
        decibel in any::<bool>(),
        stiffness in any::<bool>(),
        cut in 0..60_usize,
    ) {
        let stated = Stated {
            step: if decibel { Step::Decibel(3.0) } else { Step::Percent(4.0) },
            measure: if stiffness { Measure::Stiffness } else { Measure::Compliance },
            ..Stated::default()
        };
        let settings = Settings::new(&stated, Change::StiffnessPercent(20.0), CHANCE);
        for &rule in all() {
            let mut staircase = rule.start(&settings);
            let mut told = Vec::new();
            for (i, &right) in answers.iter().enumerate() {
                let level = staircase.level(&mut Random::new(i as u64));
                let slack = 1e-9 * settings.most.abs();
                prop_assert!((settings.least - slack..=settings.most + slack).contains(&level), "{}: {level}", rule.key());
                staircase.answered(level, right);
                told.push((level, right));
                if i + 1 == cut {
                    // Another one that is told the same answers goes on alike.
                    let mut again = rule.start(&settings);
                    told.iter().for_each(|&(level, right)| again.answered(level, right));
                    prop_assert_eq!(again.estimate(), staircase.estimate());
                    let next = |s: &mut Box<dyn Staircase>| s.level(&mut Random::new(7)).to_bits();
                    prop_assert_eq!(next(&mut again), next(&mut staircase));
                    staircase = again;
                }
            }
            if let Some(estimate) = staircase.estimate() {
                prop_assert!(estimate.level.is_finite() && estimate.standard_error.is_none_or(f64::is_finite));
            }
        }
    }
}
