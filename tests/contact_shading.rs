//! Force shading: the force of the surface that a mesh stands for, without energy from nothing.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::contact::{
    Contact, ContactState, ForceModel, Friction, Shading, Stiffness, Touch, TouchScene, advance,
};
use dorsum::geom::{Vec3, unit_or};
use dorsum::partition::bvh::Bvh;
use dorsum::surface::primitives::{bench_patch, bench_path, height_field, icosphere};
use dorsum::surface::{RawMesh, Surface};
use proptest::prelude::*;
use std::sync::Arc;

const K: f64 = 1.0;

fn scene(mesh: RawMesh, friction: Option<Friction>, shaded: bool) -> TouchScene {
    let (surface, _) = Surface::new(mesh).unwrap();
    let search = Arc::new(Bvh::new(&surface));
    TouchScene {
        friction,
        shading: shaded.then(|| Shading::of(&surface)),
        ..TouchScene::new(Arc::new(surface), search, Stiffness::Uniform(K))
    }
}

fn skin() -> Option<Friction> {
    Some(Friction {
        static_coefficient: 0.46,
        dynamic_coefficient: 0.44,
        skin_looseness: 1.0,
    })
}

fn at(hip: Vec3) -> ContactState {
    ContactState {
        proxy_mm: hip,
        ..ContactState::default()
    }
}

/// From outside along `path`; the contact of every point.
fn along(scene: &TouchScene, path: impl IntoIterator<Item = Vec3>) -> Vec<(Vec3, Contact)> {
    let mut path = path.into_iter();
    let mut state = at(path.next().unwrap());
    path.map(|hip| (hip, advance(scene, &mut state, hip)))
        .collect()
}

fn waves(amplitude: [f64; 3], phase: [f64; 3]) -> RawMesh {
    height_field([-30.0, 30.0], [-30.0, 30.0], [20, 20], 800, move |x, y| {
        amplitude[0] * libm::sin(x / 6.0 + phase[0])
            + amplitude[1] * libm::sin(y / 5.0 + phase[1])
            + amplitude[2] * libm::sin((x + y) / 4.0 + phase[2])
    })
}

#[test]
fn on_a_ball_of_facets_it_is_the_force_of_the_ball() {
    let (radius, depth) = (50.0, 5.0);
    let mut worst = [0.0_f64; 2];
    for (shaded, worst) in [false, true].into_iter().zip(&mut worst) {
        let s = scene(icosphere(radius, 3), None, shaded);
        let path = (0..3000).map(|i| {
            let a = 1e-3 * f64::from(i);
            let out = Vec3::new(
                libm::sin(a),
                libm::sin(2.0 * a) * libm::cos(a),
                libm::cos(a),
            );
            let height = if i == 0 { 10.0 } else { -depth };
            unit_or(out, Vec3::Z) * (radius + height)
        });
        for (hip, c) in along(&s, path) {
            let ball = unit_or(hip, Vec3::Z) * (K * depth);
            *worst = worst.max(c.force_n.distance(ball));
        }
    }
    // Facets of 7 mm on a radius of 50 mm turn the force by 0.07 rad either way; the ball itself is 0.06 mm above them.
    assert!(worst[0] > 0.3, "{worst:?}");
    assert!(worst[1] < 0.1, "{worst:?}");
}

#[test]
fn on_a_plane_it_changes_nothing() {
    let flat = || {
        height_field([-30.0, 30.0], [-30.0, 30.0], [7, 9], 126, |x, y| {
            0.3 * x - 0.2 * y
        })
    };
    for friction in [None, skin()] {
        let path = |i: u32| {
            let t = 0.01 * f64::from(i);
            Vec3::new(
                20.0 * libm::sin(t),
                15.0 * libm::cos(1.7 * t),
                12.0 - 14.0 * libm::sin(t),
            )
        };
        let plain = along(&scene(flat(), friction, false), (0..500).map(path));
        let shaded = along(&scene(flat(), friction, true), (0..500).map(path));
        for ((_, a), (_, b)) in plain.iter().zip(&shaded) {
            assert!(
                a.force_n.distance(b.force_n) < 1e-9,
                "{} {}",
                a.force_n,
                b.force_n
            );
        }
    }
}

#[test]
fn along_the_benchmark_path_the_force_steps_less() {
    let steps = |shaded: bool, friction: Option<Friction>| {
        let s = scene(bench_patch(20_389), friction, shaded);
        let approach = (0..300).map(|i| bench_path(0.0, 30.0 - 35.0 * f64::from(i) / 300.0));
        let slide = (0..6000).map(|i| bench_path(1e-3 * f64::from(i), -5.0));
        let felt = along(&s, approach.chain(slide));
        let mut steps: Vec<f64> = felt[300..]
            .windows(2)
            .map(|w| w[0].1.force_n.distance(w[1].1.force_n))
            .collect();
        steps.sort_unstable_by(f64::total_cmp);
        steps[steps.len() * 99 / 100]
    };
    // Less so with friction, where the force also turns as the proxy catches up behind a ridge.
    for (friction, most) in [(None, 0.65), (skin(), 0.85)] {
        let (plain, shaded) = (steps(false, friction), steps(true, friction));
        assert!(shaded < most * plain, "{shaded} of {plain}");
    }
}

#[test]
fn the_state_is_what_the_record_of_a_tick_says() {
    let s = scene(bench_patch(2962), skin(), true);
    let mut state = at(bench_path(0.0, 10.0));
    for i in 0..500 {
        let hip = bench_path(1e-3 * f64::from(i), -3.0);
        let c = advance(&s, &mut state, hip);
        assert_eq!(state, ContactState::after(hip, &c));
    }
}

#[test]
fn a_balance_that_is_no_number_is_forgotten() {
    let s = scene(bench_patch(2962), None, true);
    for bad in [f64::NAN, f64::INFINITY, -1.0, 1e300] {
        let mut state = at(bench_path(0.0, 10.0));
        advance(&s, &mut state, bench_path(0.0, -3.0));
        state.guard.credit_mj = bad;
        state.guard.felt_depth_mm = bad;
        state.guard.force_n = Vec3::splat(bad);
        for i in 1..50 {
            let c = advance(&s, &mut state, bench_path(1e-3 * f64::from(i), -3.0));
            let sane = c.force_n.is_finite() && c.felt_depth_mm.is_finite();
            assert!(sane && c.credit_mj >= 0.0, "{bad} {i}: {c:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn pressing_deeper_is_felt_deeper(
        amplitude in [0.0..3.0, 0.0..3.0, 0.0..2.0],
        phase in [0.0..6.0, 0.0..6.0, 0.0..6.0],
        triangle in 100_u32..700,
        weights in (0.05_f64..1.0, 0.05_f64..1.0, 0.05_f64..1.0),
        held in any::<bool>(),
    ) {
        let s = scene(waves(amplitude, phase), if held { skin() } else { None }, true);
        let t = s.surface.triangle(triangle);
        let sum = weights.0 + weights.1 + weights.2;
        let p = t.at([weights.0 / sum, weights.1 / sum, weights.2 / sum]);
        let path = (0..200).map(|i| p + t.normal() * (1.0 - 0.05 * f64::from(i)));
        let mut before = Contact::default();
        for (_, c) in along(&s, path) {
            // Deep under a hollow the proxy may leave the facet for a nearer one.
            if c.touch == Touch::Free || c.triangle != triangle || c.normal.distance(t.normal()) > 1e-9 {
                continue;
            }
            if before.triangle == triangle {
                prop_assert!(c.felt_depth_mm > before.felt_depth_mm);
                prop_assert!(c.force_n.length() > before.force_n.length());
            }
            before = c;
        }
    }

    #[test]
    fn a_closed_path_never_gives_energy(
        amplitude in [0.0..3.0, 0.0..3.0, 0.0..2.0],
        phase in [0.0..6.0, 0.0..6.0, 0.0..6.0],
        turns in [1_i32..4, 1_i32..4, 1_i32..4],
        shift in [0.0..6.0, 0.0..6.0, 0.0..6.0],
        deep in 2.0_f64..12.0,
        held in any::<bool>(),
        model in 0_usize..3,
    ) {
        let mut s = scene(waves(amplitude, phase), if held { skin() } else { None }, true);
        s.choices.force = ForceModel::all()[model];
        let n = 4000;
        let round = |i: i32| {
            let a = std::f64::consts::TAU * f64::from(i) / f64::from(n);
            let wave = |k: usize| libm::sin(f64::from(turns[k]) * a + shift[k]);
            Vec3::new(15.0 * wave(0), 15.0 * wave(1), -deep + 3.0 * wave(2))
        };
        let above = round(0) + Vec3::Z * 40.0;
        let down = (0..=400).map(|i| above + (round(0) - above) * (f64::from(i) / 400.0));
        let up = (0..=400).map(|i| round(0) + (above - round(0)) * (f64::from(i) / 400.0));
        let path = down.chain((0..n).map(round)).chain(up);
        let felt = along(&s, path);
        let (mut put_in, mut moved) = (0.0, 0.0);
        for w in felt.windows(2) {
            let work = -0.5 * (w[0].1.force_n + w[1].1.force_n).dot(w[1].0 - w[0].0);
            put_in += work;
            moved += work.abs();
            prop_assert!(w[1].1.credit_mj >= 0.0);
        }
        prop_assert!(put_in >= -1e-9 * moved, "{put_in} of {moved}");
    }
}
