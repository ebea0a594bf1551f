use super::*;
use crate::training::random::Random;

const CHANCE: f64 = 1.0 / 12.0;

/// Answers as they are expected of a function, at many trials a strength.
fn expected(model: &Model, [alpha, beta, lapse]: [f64; 3]) -> Vec<Point> {
    let n = 1_000_000;
    (1..=14)
        .map(|i| {
            let x = alpha * 0.25 * f64::from(i);
            let f = model.shape.share(x.ln(), alpha.ln(), beta);
            let p = CHANCE + (1.0 - CHANCE - lapse) * f;
            let right = (f64::from(n) * p).round() as u32;
            Point { x, n, right }
        })
        .collect()
}

#[test]
fn a_function_is_found_again_in_the_answers_expected_of_it() {
    for family in Family::ALL {
        for lapse in [Lapse::Fixed(0.03), Lapse::UpTo(0.06)] {
            let model = Model::new(family, CHANCE).with_lapse(lapse);
            let truth = [18.0, 2.2, 0.03];
            let fit = model.fit(&expected(&model, truth)).expect("fitted");
            let found = [fit.alpha(), fit.beta(), fit.lapse()];
            for (found, truth) in found.iter().zip(truth) {
                assert!(
                    (found / truth - 1.0).abs() < 5e-3,
                    "{family:?} {lapse:?}: {found:?}"
                );
            }
            assert!(fit.deviance < 1.0 && !fit.at_bound);
            let share = fit.share(&model, 30.0);
            // The threshold is told for one who never lapses.
            let without = Fit {
                at: [fit.at[0], fit.at[1], 0.0],
                ..fit
            };
            let x = fit.threshold(&model, 0.8);
            assert!(
                (without.share(&model, x) - 0.8).abs() < 1e-6,
                "{family:?} {share}"
            );
        }
    }
}

/// Answers of chance at a few strengths.
fn drawn(random: &mut Random) -> Vec<Point> {
    let n_levels = 2 + random.below(6);
    (0..n_levels)
        .map(|i| {
            let n = 1 + random.below(30) as u32;
            let p = (0.1 + 0.15 * i as f64 * random.unit()).min(1.0);
            let right = (0..n).filter(|_| random.unit() < p).count() as u32;
            let x = 3.0 * f64::from(i as u32 + 1) * (0.8 + 0.4 * random.unit());
            Point { x, n, right }
        })
        .collect()
}

#[test]
fn no_place_of_a_fine_grid_is_likelier_than_the_fit() {
    let mut random = Random::new(17);
    for case in 0..60 {
        let points = drawn(&mut random);
        let family = Family::ALL[case % 4];
        let model = Model::new(family, CHANCE);
        let fit = model.fit(&points).expect("fitted");
        // Brute force, of its own formula for the likelihood.
        let mut best = f64::NEG_INFINITY;
        let (low, high) = (points[0].x, points[points.len() - 1].x);
        for i in 0..60 {
            let alpha = low / 7.9 * (high / low * 62.0).powf(f64::from(i) / 59.0);
            for j in 0..40 {
                let beta = 0.21 * 70.0_f64.powf(f64::from(j) / 39.0);
                for lapse in [0.0, 0.02, 0.04, 0.06] {
                    let term = |p: &Point| {
                        let f = model.shape.share(p.x.ln(), alpha.ln(), beta);
                        let q = (CHANCE + (1.0 - CHANCE - lapse) * f).clamp(1e-12, 1.0 - 1e-12);
                        f64::from(p.right) * q.ln() + f64::from(p.n - p.right) * (1.0 - q).ln()
                    };
                    best = best.max(points.iter().map(term).sum::<f64>());
                }
            }
        }
        assert!(
            fit.log_likelihood > best - 1e-3,
            "{family:?}, case {case}: {} below {best}, {points:?}",
            fit.log_likelihood
        );
    }
}

#[test]
fn answers_that_tell_nothing_break_nothing() {
    let point = |x, n, right| Point { x, n, right };
    for family in Family::ALL {
        let model = Model::new(family, CHANCE);
        for none in [
            vec![],
            vec![point(5.0, 10, 5)],
            vec![point(0.0, 5, 1), point(3.0, 4, 4)],
        ] {
            assert_eq!(model.fit(&none), None);
        }
        for points in [
            vec![point(5.0, 10, 10), point(10.0, 10, 10)],
            vec![point(5.0, 10, 0), point(10.0, 10, 0)],
            vec![point(5.0, 10, 10), point(10.0, 10, 0)],
            vec![point(5.0, 10, 0), point(10.0, 10, 10)],
            vec![point(1e-9, 1, 1), point(1e9, 1, 0)],
            vec![
                point(f64::NAN, 3, 1),
                point(-1.0, 3, 1),
                point(2.0, 3, 1),
                point(4.0, 3, 9),
            ],
        ] {
            let fit = model.fit(&points).expect("fitted");
            let threshold = fit.threshold(&model, 0.8);
            assert!(
                threshold.is_finite() && threshold > 0.0,
                "{family:?} {points:?}"
            );
            assert!(fit.log_likelihood.is_finite() && fit.deviance.is_finite());
            let bootstrap = Bootstrap {
                samples: 20,
                ..Bootstrap::default()
            };
            let told = bootstrap
                .of(&model, &points, &fit, &[0.8, f64::NAN])
                .expect("told");
            assert!(told.thresholds.iter().flatten().all(|x| x.is_finite()));
        }
    }
}

#[test]
fn trials_are_gathered_by_strength() {
    let trials = [
        (10.0, true),
        (5.0, false),
        (10.0 + 1e-12, false),
        (f64::NAN, true),
        (10.0, true),
    ];
    let expected = [
        Point {
            x: 5.0,
            n: 1,
            right: 0,
        },
        Point {
            x: 10.0,
            n: 3,
            right: 2,
        },
    ];
    assert_eq!(points(trials), expected);
}

#[test]
fn intervals_hold_the_truth_as_often_as_they_say() {
    // Constant stimuli of an observer whose function is the model's; the lab does the same with staircases, longer.
    let model = Model::new(Family::Weibull, CHANCE);
    let (ln_alpha, beta, lapse, share) = (18.0_f64.ln(), 2.2, 0.02, 0.8);
    let truth = model
        .shape
        .ln_x_at((share - CHANCE) / (1.0 - CHANCE), ln_alpha, beta)
        .exp();
    let mut random = Random::new(4);
    let (mut held, mut bad_fits) = (0, 0);
    const REPEATS: u32 = 100;
    for seed in 0..REPEATS {
        let points: Vec<Point> = [7.0, 12.0, 18.0, 27.0, 40.0]
            .map(|x: f64| {
                let p = CHANCE + (1.0 - CHANCE - lapse) * model.shape.share(x.ln(), ln_alpha, beta);
                let right = (0..40).filter(|_| random.unit() < p).count() as u32;
                Point { x, n: 40, right }
            })
            .to_vec();
        let fit = model.fit(&points).expect("fitted");
        let bootstrap = Bootstrap {
            samples: 150,
            seed: seed.into(),
            ..Bootstrap::default()
        };
        let told = bootstrap.of(&model, &points, &fit, &[share]).expect("told");
        let [low, high] = told.thresholds[0];
        held += u32::from((low..=high).contains(&truth));
        bad_fits += u32::from(told.fit_share < 0.05);
        assert_eq!(
            bootstrap.of(&model, &points, &fit, &[share]),
            Some(told),
            "the same seed"
        );
    }
    // Three standard errors of a share of 95 % in 100.
    assert!((89..=100).contains(&held), "{held} of {REPEATS}");
    assert!(bad_fits <= 12, "{bad_fits} of {REPEATS} look bad");
}
