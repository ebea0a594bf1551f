//! What the stiffness map promises: exact at its keys, linear where they are, continuous, bounded, refusing by name.

use dorsum::geom::{Vec2, Vec3};
use dorsum::maps::{Fit, MapError, StiffnessKey, StiffnessMap};
use dorsum::surface::{RawMesh, Surface};
use proptest::prelude::*;

fn key(x: f64, y: f64, stiffness_n_per_mm: f64) -> StiffnessKey {
    StiffnessKey {
        at: Vec2::new(x, y),
        stiffness_n_per_mm,
    }
}

fn map(keys: &[StiffnessKey]) -> StiffnessMap {
    StiffnessMap::new(keys.to_vec(), Fit::Natural).expect("keys that are allowed")
}

fn refusal(keys: &[StiffnessKey]) -> MapError {
    StiffnessMap::new(keys.to_vec(), Fit::Natural).expect_err("keys that are not")
}

/// Keys of a field that is linear in x and y.
fn linear(at: Vec2) -> f64 {
    0.8 + 0.001 * at.x - 0.0007 * at.y
}

fn linear_keys(places: &[(f64, f64)]) -> Vec<StiffnessKey> {
    places
        .iter()
        .map(|&(x, y)| key(x, y, linear(Vec2::new(x, y))))
        .collect()
}

const HULL: [(f64, f64); 4] = [(-170.0, 0.0), (170.0, 0.0), (170.0, 400.0), (-170.0, 400.0)];

#[test]
fn one_key_is_everywhere_and_needs_no_field() {
    let m = map(&[key(10.0, 20.0, 0.4)]);
    assert_eq!(m.uniform(), Some(0.4));
    assert_eq!(m.at(Vec2::new(-300.0, 1e5)), 0.4);
    assert_eq!(StiffnessMap::constant(0.7).unwrap().at(Vec2::ZERO), 0.7);
    let same = map(&[key(0.0, 0.0, 0.4), key(9.0, 0.0, 0.4), key(0.0, 9.0, 0.4)]);
    assert_eq!(same.uniform(), Some(0.4));
}

#[test]
fn two_keys_are_a_ramp_along_their_segment() {
    let m = map(&[key(0.0, 0.0, 0.2), key(100.0, 0.0, 0.6)]);
    assert_eq!(m.uniform(), None);
    assert_eq!(m.at(Vec2::new(-50.0, 3.0)), 0.2);
    assert_eq!(m.at(Vec2::new(150.0, -9.0)), 0.6);
    for y in [-80.0, 0.0, 80.0] {
        assert!((m.at(Vec2::new(25.0, y)) - 0.3).abs() < 1e-15);
    }
}

#[test]
fn keys_on_one_line_are_a_chain_even_where_rounding_bent_it() {
    let on_line = |t: f64, k: f64| key(0.1 + 0.7 * t, 0.2 - 0.3 * t, k);
    let keys = [
        on_line(300.0, 0.9),
        on_line(0.0, 0.3),
        on_line(100.0, 0.5),
        on_line(217.7, 0.4),
    ];
    let m = map(&keys);
    for k in &keys {
        assert_eq!(m.at(k.at), k.stiffness_n_per_mm);
    }
    let across = Vec2::new(0.3, 0.7);
    for side in [-50.0, -1e-9, 0.0, 1e-9, 50.0] {
        let half_way = on_line(50.0, 0.0).at + across * side;
        assert!((m.at(half_way) - 0.4).abs() < 1e-9, "{side}");
    }
    let upright = map(&[
        key(1e-14, 0.0, 0.3),
        key(0.0, 200.0, 0.5),
        key(-1e-14, 100.0, 0.4),
    ]);
    assert!((upright.at(Vec2::new(30.0, 150.0)) - 0.45).abs() < 1e-12);
}

#[test]
fn a_key_that_rounding_put_beside_the_hull_counts_on_both_its_sides() {
    for off in [-1e-10, 0.0, 1e-10] {
        let m = map(&[
            key(0.0, 0.0, 0.2),
            key(100.0, 0.0, 0.2),
            key(50.0, 100.0, 0.2),
            key(50.0, off, 0.8),
        ]);
        for y in [-10.0, -1e-9, 0.0, 1e-9] {
            let k = m.at(Vec2::new(50.0, y));
            assert!((k - 0.8).abs() < 1e-6, "off {off}, y {y}: {k}");
        }
    }
}

#[test]
fn outside_the_hull_the_closest_point_of_the_hull_answers() {
    let m = map(&linear_keys(&HULL));
    assert!((m.at(Vec2::new(300.0, 100.0)) - linear(Vec2::new(170.0, 100.0))).abs() < 1e-12);
    assert!((m.at(Vec2::new(12.0, -90.0)) - linear(Vec2::new(12.0, 0.0))).abs() < 1e-12);
    let corner = linear(Vec2::new(-170.0, 400.0));
    assert_eq!(m.at(Vec2::new(-999.0, 999.0)), corner);
}

#[test]
fn places_that_are_no_numbers_get_a_stiffness_all_the_same() {
    let m = map(&linear_keys(&HULL));
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, 1e-300] {
        for place in [Vec2::new(x, 50.0), Vec2::new(50.0, x), Vec2::splat(x)] {
            let k = m.at(place);
            assert!(k.is_finite() && k > 0.0, "{place}: {k}");
        }
    }
}

#[test]
fn a_vertex_gets_the_value_of_its_place_and_threads_change_no_bit() {
    let n = 330;
    let mut mesh = RawMesh::default();
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (i as f64 * 1.1 - 180.0, j as f64 * 1.3 - 10.0);
            mesh.positions.push(Vec3::new(x, y, (x * y) % 7.0));
        }
    }
    let at = |i: usize, j: usize| (j * (n + 1) + i) as u32;
    for j in 0..n {
        for i in 0..n {
            mesh.triangles
                .push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            mesh.triangles
                .push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    let skin = Surface::new(mesh).expect("a sound mesh").0;
    let keys: Vec<StiffnessKey> = (0..60)
        .map(|i| {
            let t = f64::from(i);
            key(
                170.0 * (t * 2.4).cos(),
                200.0 + 190.0 * (t * 1.7).sin(),
                0.3 + 0.01 * t,
            )
        })
        .collect();
    let m = map(&keys);
    let values = m.per_vertex(&skin);
    for (value, p) in values.iter().zip(skin.positions()).rev().step_by(7) {
        assert_eq!(value.to_bits(), m.at(p.truncate()).to_bits());
    }
}

#[test]
fn what_is_wrong_is_refused_by_key_value_and_what_is_allowed() {
    let good = key(0.0, 0.0, 0.5);
    assert_eq!(refusal(&[]), MapError::NoKeys);
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY, 2e6] {
        let e = refusal(&[good, key(10.0, 20.0, value)]).to_string();
        assert_eq!(
            e,
            format!(
                "stiffness key 2 at (10, 20) mm: stiffness_n_per_mm is {value}; it must be above 0 and at most 1000000"
            )
        );
    }
    for x in [f64::NAN, f64::INFINITY, -2e6] {
        let e = refusal(&[good, good, key(x, 20.0, 0.5)]).to_string();
        assert_eq!(
            e,
            format!(
                "stiffness key 3 at ({x}, 20) mm: coordinates must be numbers within ±1000000 mm"
            )
        );
    }
    let e = refusal(&[key(1.0, 2.0, 0.5), good, key(1.0, 2.0 + 1e-9, 0.6)]).to_string();
    assert_eq!(
        e,
        "stiffness keys 1 and 3 are both at (1, 2) mm but state 0.5 and 0.6 N/mm; keep one of them"
    );
    let twice = map(&[
        key(1.0, 2.0, 0.5),
        good,
        key(1.0, 2.0, 0.5),
        key(9.0, 9.0, 0.7),
    ]);
    assert_eq!(twice.at(Vec2::new(1.0, 2.0)), 0.5);
}

/// Scattered keys: anywhere, on a coarse lattice (cocircular, collinear), or nearly so.
fn keys() -> impl Strategy<Value = Vec<StiffnessKey>> {
    let free = prop::array::uniform2(-200.0..200.0_f64);
    let lattice = prop::array::uniform2(-3..4_i32).prop_map(|p| p.map(|i| f64::from(i) * 50.0));
    let nearly = (lattice.clone(), prop::array::uniform2(-1e-9..1e-9_f64))
        .prop_map(|(p, d)| [p[0] + d[0], p[1] + d[1]]);
    let place = prop_oneof![free, lattice, nearly];
    prop::collection::vec((place, 0.05..2.0_f64), 1..40).prop_map(|keys| {
        let mut kept: Vec<StiffnessKey> = Vec::new();
        for (p, k) in keys {
            let at = Vec2::from(p);
            if kept.iter().all(|other| other.at.distance(at) > 1e-5) {
                kept.push(key(p[0], p[1], k));
            }
        }
        kept
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn values_stay_within_the_keys_meet_them_and_do_not_jump(
        keys in keys(),
        places in prop::collection::vec(prop::array::uniform2(-260.0..260.0_f64), 60),
    ) {
        let m = map(&keys);
        let all = || keys.iter().map(|k| k.stiffness_n_per_mm);
        let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
        for k in &keys {
            prop_assert_eq!(m.at(k.at), k.stiffness_n_per_mm);
        }
        for p in places.into_iter().map(Vec2::from) {
            prop_assert!((low..=high).contains(&m.at(p)));
        }
    }

    #[test]
    fn linear_fields_are_reproduced_inside_the_hull(
        inner in prop::collection::vec(prop::array::uniform2(0.0..1.0_f64), 0..30),
        places in prop::collection::vec(prop::array::uniform2(0.0..1.0_f64), 40),
    ) {
        let on_back = |[u, v]: [f64; 2]| (-170.0 + 340.0 * u, 400.0 * v);
        let mut all = HULL.to_vec();
        all.extend(inner.into_iter().map(on_back));
        let m = map(&linear_keys(&all));
        for (x, y) in places.into_iter().map(on_back) {
            let (found, expected) = (m.at(Vec2::new(x, y)), linear(Vec2::new(x, y)));
            prop_assert!((found - expected).abs() <= 1e-9 * expected, "({x}, {y}): {found}, not {expected}");
        }
    }

    #[test]
    fn the_field_is_continuous_across_the_hull(
        inner in prop::collection::vec((prop::array::uniform2(0.05..0.95_f64), 0.1..2.0_f64), 1..12),
        along in prop::collection::vec(0.001..0.999_f64, 20),
    ) {
        let mut keys: Vec<StiffnessKey> = HULL
            .iter()
            .enumerate()
            .map(|(i, &(x, y))| key(x, y, 0.3 + 0.2 * i as f64))
            .collect();
        keys.extend(inner.into_iter().map(|([u, v], k)| key(-170.0 + 340.0 * u, 400.0 * v, k)));
        let m = map(&keys);
        for (i, t) in along.into_iter().enumerate() {
            let (a, b) = (HULL[i % 4], HULL[(i + 1) % 4]);
            let (a, b) = (Vec2::from(a), Vec2::from(b));
            let on = a.lerp(b, t);
            let outward = -(b - a).perp() / (b - a).length();
            for step in [1e-7, 1e-5, 1e-3] {
                let (inside, outside) = (m.at(on - outward * step), m.at(on + outward * step));
                prop_assert!((inside - outside).abs() < 20.0 * step.sqrt() * 0.05, "{inside} {outside} at {step}");
            }
        }
    }
}
