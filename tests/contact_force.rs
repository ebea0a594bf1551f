//! Force models: closed forms, limits, energy, and what the contact makes of them.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::contact::published::{self, Published};
use dorsum::contact::{
    ContactState, ForceModel, Friction, Hip, Stiffness, Touch, TouchScene, advance, anchor_from,
};
use dorsum::geom::Vec3;
use dorsum::partition::bvh::Bvh;
use dorsum::surface::Surface;
use dorsum::surface::primitives::height_field;
use proptest::prelude::*;
use std::sync::Arc;

const K: f64 = 0.8;

fn nonlinear(start_share: f64, trend_mm: f64) -> ForceModel {
    ForceModel::Nonlinear {
        start_share,
        trend_mm,
    }
}

fn exponential(growth_per_mm: f64) -> ForceModel {
    ForceModel::Exponential { growth_per_mm }
}

fn hunt_crossley(damping_s_per_mm: f64, exponent: f64) -> ForceModel {
    ForceModel::HuntCrossley {
        damping_s_per_mm,
        exponent,
    }
}

fn close(a: f64, b: f64, relative: f64) {
    assert!((a - b).abs() <= relative * b.abs(), "{a} for {b}");
}

#[test]
fn each_model_has_its_closed_form() {
    let f = |model: ForceModel, d, rate| model.force_n(K, d, rate);
    assert_eq!(f(ForceModel::Linear, 3.0, 100.0), K * 3.0);
    // σ = 2: at d = 2 the stiffness is k − 0.75 k e^(−1/2).
    let at_sigma = K * (1.0 - 0.75 * 0.606_530_659_712_633_4) * 2.0;
    close(f(nonlinear(0.25, 2.0), 2.0, 0.0), at_sigma, 1e-15);
    // Slope at the surface k, and e-fold at 1/B.
    close(
        f(exponential(0.5), 2.0, 0.0),
        K / 0.5 * 1.718_281_828_459_045,
        1e-15,
    );
    close(f(exponential(0.5), 1e-9, 0.0), K * 1e-9, 1e-9);
    close(f(hunt_crossley(0.01, 1.5), 4.0, 0.0), K * 8.0, 1e-15);
    close(f(hunt_crossley(0.01, 1.5), 4.0, 50.0), K * 8.0 * 1.5, 1e-15);
    close(
        f(hunt_crossley(0.01, 1.5), 4.0, -50.0),
        K * 8.0 * 0.5,
        1e-15,
    );
    assert_eq!(
        f(hunt_crossley(0.01, 1.5), 4.0, -200.0),
        0.0,
        "skin does not pull"
    );
    // Hunt and Crossley's damped spring at n = 1 is k d + λ k d ḋ.
    close(f(hunt_crossley(0.02, 1.0), 3.0, 10.0), K * 3.0 * 1.2, 1e-15);
}

#[test]
fn at_its_limit_each_model_is_linear() {
    for d in [0.0, 1e-6, 0.3, 5.0, 40.0] {
        for model in [
            nonlinear(0.3, 0.0),
            nonlinear(1.0, 4.0),
            exponential(0.0),
            hunt_crossley(0.0, 1.0),
        ] {
            assert_eq!(model.force_n(K, d, 30.0), K * d, "{model}");
            close(model.energy_mj(K, d), 0.5 * K * d * d, 1e-12);
        }
        close(nonlinear(0.3, 1e-9).force_n(K, d, 0.0), K * d, 1e-12);
        close(exponential(1e-9).force_n(K, d, 0.0), K * d, 1e-7);
    }
}

#[test]
fn an_exponential_goes_on_straight_without_a_kink() {
    let (model, b) = (exponential(0.5), 0.5);
    let from = 100.0_f64.ln() / b;
    let slope = |d: f64| {
        let h = 1e-5;
        (model.force_n(K, d + h, 0.0) - model.force_n(K, d - h, 0.0)) / (2.0 * h)
    };
    close(slope(from - 0.01), K * (b * (from - 0.01)).exp(), 1e-6);
    for d in [from + 0.01, from + 10.0, from + 1e4] {
        close(slope(d), K * 100.0, 1e-5);
    }
    let at = |d| model.force_n(K, d, 0.0);
    close(at(from * (1.0 + 1e-12)), at(from * (1.0 - 1e-12)), 1e-10);
}

/// Simpson's rule over the force, in steps, against the closed potential.
#[test]
fn the_energy_is_the_integral_of_the_force() {
    let others = [
        exponential(2.0),
        nonlinear(0.0, 1.0),
        hunt_crossley(0.1, 2.2),
    ];
    for model in ForceModel::all().iter().copied().chain(others) {
        let mut sum = 0.0;
        let (steps, to) = (20_000, 12.0);
        let h = to / f64::from(steps);
        for i in 0..steps {
            let d = f64::from(i) * h;
            let f = |d| model.force_n(K, d, 0.0);
            sum += h / 6.0 * (f(d) + 4.0 * f(d + 0.5 * h) + f(d + h));
            if i % 1999 == 1998 {
                close(model.energy_mj(K, d + h), sum, 1e-6);
            }
        }
    }
}

proptest! {
    /// Also where the numbers are none.
    #[test]
    fn force_rises_from_zero_and_is_finite_and_never_pulls(
        number in prop::array::uniform2(prop_oneof![0.0..10.0_f64, any::<f64>()]),
        which in 0..4_usize,
        k in prop_oneof![0.01..10.0_f64, any::<f64>()],
        d in prop_oneof![0.0..100.0_f64, any::<f64>()],
        more in prop_oneof![0.0..1.0_f64, any::<f64>()],
        rate in prop_oneof![-1e3..1e3_f64, any::<f64>()],
    ) {
        let [a, b] = number;
        let model = [ForceModel::Linear, nonlinear(a, b), exponential(a), hunt_crossley(a, b)][which];
        prop_assert_eq!(model.force_n(k, 0.0, rate), 0.0);
        let f = model.force_n(k, d, rate);
        let (secant, energy) = (model.secant_n_per_mm(k, d, rate), model.energy_mj(k, d));
        prop_assert!(f.is_finite() && secant.is_finite() && energy.is_finite(), "{model}: {f} {secant} {energy}");
        prop_assert!(f >= 0.0 && secant >= 0.0 && energy >= 0.0);
        if d >= 0.0 && more >= 0.0 {
            let deeper = model.force_n(k, d + more, rate);
            prop_assert!(deeper >= f * (1.0 - 1e-14), "{model} at {d} + {more}: {deeper} after {f}");
        }
    }
}

fn plate(force: ForceModel, friction: Option<Friction>) -> TouchScene {
    let mesh = height_field([-50.0, 50.0], [-50.0, 50.0], [25, 25], 1250, |_, _| 0.0);
    let (surface, _) = Surface::new(mesh).unwrap();
    let search = Arc::new(Bvh::new(&surface));
    let mut scene = TouchScene::new(Arc::new(surface), search, Stiffness::Uniform(K));
    (scene.friction, scene.choices.force) = (friction, force);
    scene
}

fn free_above() -> ContactState {
    ContactState {
        proxy_mm: Vec3::new(0.3, 0.2, 1.0),
        ..ContactState::default()
    }
}

#[test]
fn the_contact_feels_the_model_and_only_the_rate_along_the_normal() {
    for &model in ForceModel::all() {
        let scene = plate(model, None);
        let hip = |rate: f64| Hip {
            position_mm: Vec3::new(0.3, 0.2, -3.0),
            velocity_mm_s: Vec3::new(400.0, -300.0, -rate),
        };
        for rate in [0.0, 120.0, -120.0, -1e9] {
            let c = advance(&scene, &mut free_above(), hip(rate));
            let expected = Vec3::Z * model.force_n(K, 3.0, rate);
            assert!(
                c.force_n.distance(expected) < 1e-12,
                "{model} at {rate}: {}",
                c.force_n
            );
            assert_eq!(c.stiffness_n_per_mm, K);
        }
        // A velocity that is none counts as rest.
        let rest = advance(&scene, &mut free_above(), Vec3::new(0.3, 0.2, -3.0)).force_n;
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308] {
            let hip = Hip {
                velocity_mm_s: Vec3::splat(bad),
                ..hip(0.0)
            };
            let c = advance(&scene, &mut free_above(), hip);
            assert!(c.force_n.is_finite());
            if !bad.is_finite() {
                assert_eq!(c.force_n, rest, "{model}, {bad}");
            }
        }
    }
}

/// The cone is a ratio of lengths: where slip starts does not depend on the model, and there the tangential force is the
/// coefficient times the normal force.
/// The force was bounded already, but the contact told a stiffness of NaN or infinity on to the record.
#[test]
fn the_contact_tells_no_stiffness_that_is_none() {
    let mut scene = plate(ForceModel::Linear, None);
    for (stated, felt) in [
        (f64::NAN, 0.0),
        (-1.0, 0.0),
        (f64::NEG_INFINITY, 0.0),
        (f64::INFINITY, 1e9),
        (1e300, 1e9),
    ] {
        let per_vertex = vec![stated; scene.surface.positions().len()];
        for stiffness in [
            Stiffness::Uniform(stated),
            Stiffness::PerVertex(per_vertex.into()),
        ] {
            scene.stiffness = stiffness;
            let hip = Hip::from(Vec3::new(0.3, 0.2, -3.0));
            let c = advance(&scene, &mut free_above(), hip);
            assert_eq!(c.stiffness_n_per_mm, felt, "{stated}");
            assert_eq!(c.force_n, Vec3::Z * (felt * c.depth_mm), "{stated}");
        }
    }
}

#[test]
fn slip_starts_at_the_same_place_under_every_model() {
    for &model in ForceModel::all() {
        for skin_looseness in [0.7, 1.0, 1.3] {
            let friction = Friction {
                static_coefficient: 0.46,
                dynamic_coefficient: 0.44,
                skin_looseness,
            };
            let scene = plate(model, Some(friction));
            let mut state = free_above();
            let depth = 4.0;
            advance(&scene, &mut state, Vec3::new(0.3, 0.2, -depth));
            let reach = 0.46 * skin_looseness * depth;
            let hip = |share: f64| Vec3::new(0.3 + share * reach, 0.2, -depth);
            let held = advance(&scene, &mut state, hip(1.0 - 1e-9));
            assert_eq!(held.touch, Touch::Stick, "{model}");
            close(-held.force_n.x, 0.46 * held.force_n.z, 1e-8);
            let slid = advance(&scene, &mut state, hip(1.0 + 1e-9));
            assert_eq!(slid.touch, Touch::Slip, "{model}");
            close(-slid.force_n.x, 0.44 * slid.force_n.z, 1e-8);
        }
    }
}

/// A device that reports P, D and F only: its anchor is the engine's, under every force model, f_adj and engine, also
/// when its motors give less than was asked for.
#[test]
fn the_anchor_from_position_and_force_is_the_engines_own() {
    for &model in ForceModel::all() {
        for skin_looseness in [0.7, 1.0, 1.3] {
            let friction = Friction {
                static_coefficient: 0.46,
                dynamic_coefficient: 0.44,
                skin_looseness,
            };
            let production = plate(model, Some(friction));
            let pass = Published::build(
                &production.surface,
                &published::Options::default(),
                &mut |_| true,
            );
            let published = TouchScene {
                published: Some(Arc::new(pass.unwrap().unwrap())),
                ..production.clone()
            };
            for (scene, which) in [(production, "production"), (published, "published")] {
                let mut state = free_above();
                let mut seen = [0; 4];
                for i in 0..400 {
                    let t = f64::from(i) * 0.01;
                    let position_mm = Vec3::new(
                        0.3 + 3.0 * libm::sin(5.0 * t),
                        0.2 + 2.0 * libm::sin(1.9 * t),
                        -4.0 * libm::sin(2.0 * t),
                    );
                    let velocity_mm_s = Vec3::new(20.0, 5.0, -30.0 * libm::cos(2.0 * t));
                    let hip = Hip {
                        position_mm,
                        velocity_mm_s,
                    };
                    let c = advance(&scene, &mut state, hip);
                    if c.force_n.dot(c.normal) < 1e-3 {
                        continue;
                    }
                    seen[c.touch as usize] += 1;
                    let anchor = |share: f64| {
                        anchor_from(
                            c.foot_mm,
                            position_mm,
                            c.force_n * share,
                            c.normal,
                            skin_looseness,
                        )
                        .unwrap()
                    };
                    for share in [1.0, 0.3] {
                        let off = anchor(share).distance(c.anchor_mm);
                        assert!(
                            off < 1e-9,
                            "{which}, {model}, f_adj {skin_looseness}: off by {off} mm"
                        );
                    }
                }
                assert!(
                    seen[Touch::Stick as usize] > 10 && seen[Touch::Slip as usize] > 50,
                    "{seen:?}"
                );
            }
        }
    }
}
