//! What every fit of the stiffness map promises, and strokes over it.

use dorsum::geom::Vec2;
use dorsum::maps::fit::MOST_RBF_KEYS;
use dorsum::maps::{Fit, MapError, StiffnessKey, StiffnessMap, Stroke, leave_one_out};
use proptest::prelude::*;

fn key(x: f64, y: f64, stiffness_n_per_mm: f64) -> StiffnessKey {
    StiffnessKey {
        at: Vec2::new(x, y),
        stiffness_n_per_mm,
    }
}

fn map(keys: &[StiffnessKey], fit: Fit) -> StiffnessMap {
    StiffnessMap::new(keys.to_vec(), fit).expect("sound keys")
}

fn dab(x: f64, y: f64, radius_mm: f64, change: f64) -> Stroke {
    Stroke {
        path: vec![Vec2::new(x, y)],
        radius_mm,
        change,
        falloff: "gaussian".into(),
    }
}

#[test]
fn names_are_unique_and_the_default_is_first() {
    assert_eq!(Fit::all()[0], Fit::default());
    let mut names: Vec<_> = Fit::all().iter().map(|f| f.name()).collect();
    names.sort_unstable();
    assert_eq!(names, ["constant", "gri", "idw", "natural", "rbf"]);
    let mut about: Vec<_> = Fit::all().iter().map(|f| f.about()).collect();
    about.sort_unstable();
    about.dedup();
    assert_eq!(about.len(), names.len());
}

#[test]
fn one_key_and_equal_keys_are_everywhere() {
    for fit in Fit::all() {
        for keys in [
            vec![key(3.0, 4.0, 0.37)],
            vec![
                key(0.0, 0.0, 0.37),
                key(50.0, 0.0, 0.37),
                key(9.0, 80.0, 0.37),
            ],
        ] {
            let m = map(&keys, *fit);
            assert_eq!(m.uniform(), Some(0.37));
            assert_eq!(m.at(Vec2::new(-700.0, 12.0)), 0.37, "{}", fit.name());
        }
    }
}

#[test]
fn closed_forms_half_way_between_two_keys() {
    let keys = [key(0.0, 0.0, 0.2), key(100.0, 0.0, 0.8)];
    let middle = Vec2::new(50.0, 0.0);
    for (fit, expected) in [
        (Fit::Natural, 0.5),
        (Fit::Gri, 0.5),
        (Fit::Rbf, 0.4),
        (Fit::Idw, 0.5),
        (Fit::Constant, 0.4),
    ] {
        let found = map(&keys, fit).at(middle);
        assert!((found - expected).abs() < 1e-12, "{}: {found}", fit.name());
    }
    // Shepard's weights at a quarter: 1/25² and 1/75².
    let found = map(&keys, Fit::Idw).at(Vec2::new(25.0, 0.0));
    assert!((found - (0.9 * 0.2 + 0.1 * 0.8)).abs() < 1e-12);
}

#[test]
fn a_plane_in_the_logarithm_is_a_thin_plate_without_bending() {
    let plane = |p: Vec2| (0.3 + 0.004 * p.x - 0.002 * p.y).exp();
    let places = [
        (0.0, 0.0),
        (170.0, 10.0),
        (150.0, 390.0),
        (-20.0, 350.0),
        (60.0, 200.0),
    ];
    let keys: Vec<_> = places
        .iter()
        .map(|&(x, y)| key(x, y, plane(Vec2::new(x, y))))
        .collect();
    let m = map(&keys, Fit::Rbf);
    for (x, y) in [(50.0, 50.0), (100.0, 300.0), (10.0, 200.0)] {
        let p = Vec2::new(x, y);
        assert!((m.at(p) / plane(p) - 1.0).abs() < 1e-9);
    }
}

#[test]
fn far_outside_each_fit_does_what_it_says() {
    let keys = [
        key(0.0, 0.0, 0.2),
        key(100.0, 0.0, 0.4),
        key(0.0, 100.0, 0.8),
    ];
    let far = Vec2::new(-1.0e5, -1.0e5);
    let mean = 1.4 / 3.0;
    for (fit, expected, within) in [
        (Fit::Natural, 0.2, 0.0),
        (Fit::Rbf, 0.2, 0.0),
        (Fit::Gri, mean, 1e-15),
        (Fit::Idw, mean, 1e-3),
        (Fit::Constant, (0.2_f64 * 0.4 * 0.8).cbrt(), 1e-15),
    ] {
        let found = map(&keys, fit).at(far);
        assert!(
            (found - expected).abs() <= within,
            "{}: {found}",
            fit.name()
        );
    }
}

#[test]
fn the_spline_says_when_keys_are_too_many_or_too_close() {
    let many: Vec<_> = (0..=MOST_RBF_KEYS)
        .map(|i| key(i as f64, (i * i % 97) as f64, 0.5 + 0.001 * i as f64))
        .collect();
    let e = StiffnessMap::new(many, Fit::Rbf).expect_err("too many");
    assert_eq!(
        e.to_string(),
        "the fit \"rbf\" takes at most 400 keys, not 401; choose another fit"
    );
    let close = vec![
        key(0.0, 0.0, 0.3),
        key(200.0, 0.0, 0.4),
        key(0.0, 200.0, 0.9),
        key(90.0, 90.0, 0.3),
        key(90.0, 90.00001, 0.6),
    ];
    match StiffnessMap::new(close.clone(), Fit::Rbf) {
        Ok(m) => {
            for k in &close {
                assert_eq!(m.at(k.at), k.stiffness_n_per_mm);
            }
        }
        Err(e) => assert_eq!(
            e.to_string(),
            "the fit \"rbf\" has no sound solution: the keys at (90, 90) and (90, 90.00001) mm are too close to each \
             other; move them apart or choose another fit"
        ),
    }
}

#[test]
fn leaving_one_out_is_asking_the_others() {
    let keys = [
        key(0.0, 0.0, 0.2),
        key(100.0, 0.0, 0.4),
        key(0.0, 100.0, 0.8),
        key(40.0, 30.0, 0.5),
    ];
    for fit in Fit::all() {
        let errors = leave_one_out(&keys, *fit).expect("sound");
        for (i, error) in errors.iter().enumerate() {
            let mut others = keys.to_vec();
            let left_out = others.remove(i);
            let expected = map(&others, *fit).at(left_out.at) - left_out.stiffness_n_per_mm;
            assert!((error - expected).abs() < 1e-14, "{}", fit.name());
        }
        assert_eq!(leave_one_out(&keys[..1], *fit), Err(MapError::NoKeys));
        let twice = [keys[0], keys[1], keys[1], keys[2], keys[3]];
        let again = leave_one_out(&twice, *fit).expect("sound");
        assert_eq!(
            [again[0], again[1], again[2]],
            [errors[0], errors[1], errors[1]]
        );
    }
}

#[test]
fn a_stroke_multiplies_by_its_falloff_and_leaves_the_rest_bit_for_bit() {
    let keys = [
        key(0.0, 0.0, 0.2),
        key(100.0, 0.0, 0.4),
        key(0.0, 100.0, 0.8),
    ];
    let plain = map(&keys, Fit::Natural);
    let path = vec![
        Vec2::new(20.0, 20.0),
        Vec2::new(60.0, 20.0),
        Vec2::new(60.0, 60.0),
    ];
    let stroke = Stroke {
        path,
        ..dab(0.0, 0.0, 10.0, 0.5)
    };
    let m = plain.clone().with_strokes(vec![stroke]).expect("sound");
    assert_eq!(m.uniform(), None);
    for on in [
        Vec2::new(20.0, 20.0),
        Vec2::new(41.0, 20.0),
        Vec2::new(60.0, 33.0),
    ] {
        assert_eq!(m.at(on), plain.at(on) * 1.5);
    }
    for off in [
        Vec2::new(41.0, 30.0),
        Vec2::new(9.9, 20.0),
        Vec2::new(60.0, 70.1),
    ] {
        assert_eq!(m.at(off), plain.at(off));
    }
    let half_way = m.at(Vec2::new(40.0, 25.0)) / plain.at(Vec2::new(40.0, 25.0));
    let gaussian = |q: f64| (-std::f64::consts::PI * 1.96 * q * q).exp();
    let expected = (gaussian(0.5) - gaussian(1.0)) / (1.0 - gaussian(1.0));
    assert!((half_way - 1.0 - 0.5 * expected).abs() < 1e-5, "{half_way}");
}

#[test]
fn strokes_add_up_in_order_and_stay_in_bounds() {
    let m = StiffnessMap::constant(0.5).expect("sound");
    let at = Vec2::new(1.0, 2.0);
    let twice = vec![dab(1.0, 2.0, 5.0, 1.0), dab(1.0, 2.0, 5.0, -0.5)];
    assert_eq!(m.clone().with_strokes(twice).expect("sound").at(at), 0.5);
    let up = m.clone().with_strokes(vec![dab(1.0, 2.0, 5.0, 9.0); 50]);
    assert_eq!(up.expect("sound").at(at), 10_000.0);
    let down = m.with_strokes(vec![dab(1.0, 2.0, 5.0, -0.99); 50]);
    assert_eq!(down.expect("sound").at(at), 0.001);
}

#[test]
fn what_is_wrong_with_a_stroke_is_told() {
    let m = StiffnessMap::constant(0.5).expect("sound");
    let good = dab(0.0, 0.0, 5.0, 0.5);
    for (bad, told) in [
        (
            dab(f64::NAN, 0.0, 5.0, 0.5),
            "stiffness stroke 2: a point of path is (NaN, 0); numbers within ±1000000 mm are allowed",
        ),
        (
            dab(0.0, 0.0, -5.0, 0.5),
            "stiffness stroke 2: radius_mm is -5; 0.1 to 1000 is allowed",
        ),
        (
            dab(0.0, 0.0, 5.0, -1.0),
            "stiffness stroke 2: change is -1; -0.99 to 9 is allowed",
        ),
        (
            Stroke {
                path: vec![],
                ..good.clone()
            },
            "stiffness stroke 2: number of points in path is 0; 1 to 10000 are allowed",
        ),
    ] {
        let e = m
            .clone()
            .with_strokes(vec![good.clone(), bad])
            .expect_err(told);
        assert_eq!(e.to_string(), told);
    }
    let odd = Stroke {
        falloff: "odd".into(),
        ..good
    };
    let e = m.with_strokes(vec![odd]).expect_err("odd").to_string();
    assert!(
        e.starts_with("stiffness stroke 1: falloff is \"odd\"; allowed are \"gaussian\""),
        "{e}"
    );
}

/// Keys at least a tenth of a millimetre apart: scattered, on a lattice, on one line.
fn keys() -> impl Strategy<Value = Vec<StiffnessKey>> {
    let free = prop::array::uniform2(-200.0..200.0_f64);
    let lattice = prop::array::uniform2(-3..4_i32).prop_map(|p| p.map(|i| f64::from(i) * 50.0));
    let line = (-150.0..150.0_f64).prop_map(|t| [0.3 + t, 7.0 - 0.4 * t]);
    let near = prop::array::uniform2(-0.3..0.3_f64);
    let cloud = prop_oneof![
        prop::collection::vec(prop_oneof![free, lattice.clone(), near], 1..30),
        prop::collection::vec(lattice, 1..20),
        prop::collection::vec(line, 1..20),
    ];
    (cloud, prop::collection::vec(0.05..2.0_f64, 30)).prop_map(|(places, values)| {
        let mut kept: Vec<StiffnessKey> = Vec::new();
        for (p, k) in places.into_iter().zip(values) {
            if kept.iter().all(|o| o.at.distance(Vec2::from(p)) > 0.1) {
                kept.push(key(p[0], p[1], k));
            }
        }
        kept
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn every_fit_is_positive_finite_in_bounds_and_exact_at_its_keys(
        keys in keys(),
        places in prop::collection::vec(prop::array::uniform2(-400.0..400.0_f64), 40),
    ) {
        let all = || keys.iter().map(|k| k.stiffness_n_per_mm);
        let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
        for fit in Fit::all() {
            let m = map(&keys, *fit);
            let swing = if *fit == Fit::Rbf { 2.0 } else { 1.0 };
            let odd = [f64::NAN, f64::INFINITY, -1e300, 1e-300].map(|x| [x, 3.0]);
            for p in places.iter().copied().chain(odd).map(Vec2::from) {
                let k = m.at(p);
                prop_assert!((low / swing..=high * swing).contains(&k), "{} at {p}: {k}", fit.name());
            }
            if *fit != Fit::Constant {
                for k in &keys {
                    prop_assert_eq!(m.at(k.at), k.stiffness_n_per_mm, "{}", fit.name());
                }
            }
        }
    }

    #[test]
    fn no_fit_jumps(
        keys in keys(),
        from in prop::array::uniform2(-300.0..300.0_f64),
        to in prop::array::uniform2(-300.0..300.0_f64),
        nudge in prop::array::uniform2(-1.0..1.0_f64),
    ) {
        let strokes = vec![dab(20.0, 10.0, 60.0, 0.8), dab(-50.0, 10.0, 90.0, -0.6)];
        let tiny = Vec2::from(nudge) * 1e-8;
        for fit in Fit::all() {
            let m = map(&keys, *fit).with_strokes(strokes.clone()).expect("sound");
            let ends = keys.iter().map(|k| k.at);
            let walk = (0..=60).map(|i| Vec2::from(from).lerp(Vec2::from(to), f64::from(i) / 60.0));
            for p in ends.chain(walk) {
                let (here, there) = (m.at(p), m.at(p + tiny));
                // Keys 0.1 mm apart may differ by 2 N/mm: 1e-8 mm are then 2e-7, times the overshoot of a spline.
                prop_assert!((here - there).abs() < 1e-5, "{} at {p}: {here} {there}", fit.name());
            }
        }
    }

    #[test]
    fn the_order_of_keys_and_questions_changes_nothing_that_can_be_felt(keys in keys(), seed in 0..1000_u64) {
        let mut shuffled = keys.clone();
        let n = shuffled.len();
        for i in 0..n {
            shuffled.swap(i, (seed as usize * 7919 + i * 31) % n);
        }
        let places: Vec<Vec2> = (0..30).map(|i| Vec2::new(f64::from(i) * 13.0 - 200.0, f64::from(i * i % 37) * 9.0 - 160.0)).collect();
        for fit in Fit::all() {
            let (a, b) = (map(&keys, *fit), map(&shuffled, *fit));
            let forward: Vec<u64> = places.iter().map(|p| a.at(*p).to_bits()).collect();
            let mut reader = a.reader();
            let backward: Vec<u64> = places.iter().rev().map(|p| reader(*p).to_bits()).collect();
            prop_assert!(forward.iter().eq(backward.iter().rev()), "{}", fit.name());
            for p in &places {
                prop_assert!((a.at(*p) - b.at(*p)).abs() < 1e-6 * a.at(*p), "{}", fit.name());
            }
        }
    }
}
