//! Friction: the cone, stick and slip, the anchor, what it dissipates.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::contact::{
    Contact, ContactState, Friction, Stiffness, Touch, TouchScene, advance, anchor_from,
};
use dorsum::geom::Vec3;
use dorsum::partition::bvh::Bvh;
use dorsum::surface::primitives::{bench_patch, bench_path, height_field};
use dorsum::surface::{RawMesh, Surface};
use proptest::prelude::*;
use std::sync::Arc;

const K: f64 = 0.8;

fn scene(mesh: RawMesh, friction: Option<Friction>) -> TouchScene {
    let (surface, _) = Surface::new(mesh).unwrap();
    let search = Arc::new(Bvh::new(&surface));
    TouchScene {
        friction,
        ..TouchScene::new(Arc::new(surface), search, Stiffness::Uniform(K))
    }
}

fn skin(looseness: f64) -> Friction {
    Friction {
        static_coefficient: 0.46,
        dynamic_coefficient: 0.44,
        skin_looseness: looseness,
    }
}

fn plane() -> RawMesh {
    height_field([-50.0, 50.0], [-50.0, 50.0], [25, 25], 1250, |_, _| 0.0)
}

fn free_at(p: Vec3) -> ContactState {
    ContactState {
        proxy_mm: p,
        ..ContactState::default()
    }
}

/// Presses straight down at the origin to `depth` and returns the state.
fn pressed(scene: &TouchScene, depth: f64) -> ContactState {
    let mut state = free_at(Vec3::new(0.3, 0.2, 1.0));
    let c = advance(scene, &mut state, Vec3::new(0.3, 0.2, -depth));
    assert_eq!(c.touch, Touch::Stick);
    state
}

fn tangential(c: &Contact) -> f64 {
    (c.force_n - c.normal * c.force_n.dot(c.normal)).length()
}

#[test]
fn inside_the_cone_the_anchor_stays_and_pulls_back_like_a_spring() {
    for looseness in [0.7, 1.0, 1.3] {
        let s = scene(plane(), Some(skin(looseness)));
        let mut state = pressed(&s, 4.0);
        let anchor = state.proxy_mm;
        for share in [0.2, -0.7, 0.99, -0.99, 0.0] {
            let offset = share * 0.46 * looseness * 4.0;
            let hip = anchor + Vec3::new(0.6 * offset, 0.8 * offset, -4.0);
            let c = advance(&s, &mut state, hip);
            assert_eq!(c.touch, Touch::Stick, "{share}");
            assert_eq!(c.anchor_mm, anchor);
            assert!(c.foot_mm.distance(hip + Vec3::Z * 4.0) < 1e-12);
            let expected =
                Vec3::new(0.0, 0.0, K * 4.0) - Vec3::new(0.6, 0.8, 0.0) * (offset * K / looseness);
            assert!((c.force_n - expected).length() < 1e-12);
        }
    }
}

#[test]
fn slip_starts_at_the_static_coefficient_and_goes_on_at_the_dynamic_one() {
    for looseness in [0.7, 1.0, 1.3] {
        for depth in [0.01, 1.0, 7.0] {
            let s = scene(plane(), Some(skin(looseness)));
            let start = 0.46 * looseness * depth;
            let mut state = pressed(&s, depth);
            let anchor = state.proxy_mm;
            let hip = |offset: f64| anchor + Vec3::new(offset, 0.0, -depth);
            let held = advance(&s, &mut state, hip(start * (1.0 - 1e-9)));
            assert_eq!(held.touch, Touch::Stick);
            assert!((tangential(&held) / (0.46 * K * depth) - 1.0).abs() < 1e-8);
            let slid = advance(&s, &mut state, hip(start * (1.0 + 1e-9)));
            assert_eq!(slid.touch, Touch::Slip);
            assert!((tangential(&slid) / (0.44 * K * depth) - 1.0).abs() < 1e-8);
            let gap = (slid.foot_mm - slid.anchor_mm).length();
            assert!((gap - 0.44 * looseness * depth).abs() < 1e-9);
            // As long as it moves on, dynamic; then it holds again, up to the static coefficient.
            for i in 1..50 {
                let c = advance(&s, &mut state, hip(start + f64::from(i) * 0.01 * depth));
                assert_eq!(c.touch, Touch::Slip);
                assert!((tangential(&c) / (0.44 * K * depth) - 1.0).abs() < 1e-9);
            }
            let stopped = hip(start + 0.49 * depth);
            let c = advance(&s, &mut state, stopped);
            assert_eq!(c.touch, Touch::Stick, "no motion, no slip");
            let more = 0.5 * (0.46 - 0.44) * looseness * depth;
            let c = advance(&s, &mut state, stopped + Vec3::X * more);
            assert_eq!(c.touch, Touch::Stick);
        }
    }
}

#[test]
fn letting_up_shrinks_the_cone_and_lets_the_anchor_follow() {
    let s = scene(plane(), Some(skin(1.0)));
    let mut state = pressed(&s, 5.0);
    let anchor = state.proxy_mm;
    let off = anchor + Vec3::X * 2.0;
    assert_eq!(
        advance(&s, &mut state, off - Vec3::Z * 5.0).touch,
        Touch::Stick
    );
    let c = advance(&s, &mut state, off - Vec3::Z * 1.0);
    assert_eq!(c.touch, Touch::Slip);
    assert!((c.anchor_mm.x - (off.x - 0.44)).abs() < 1e-12);
    let c = advance(&s, &mut state, off - Vec3::Z * 1e-13);
    assert!(tangential(&c) < 1e-12 && c.force_n.is_finite());
    assert_eq!(advance(&s, &mut state, off + Vec3::Z).touch, Touch::Free);
}

#[test]
fn coefficients_that_make_no_sense_are_taken_as_none() {
    for bad in [f64::NAN, f64::INFINITY, -1.0, 0.0] {
        let friction = Friction {
            static_coefficient: bad,
            dynamic_coefficient: bad,
            skin_looseness: bad,
        };
        let s = scene(plane(), Some(friction));
        let mut state = free_at(Vec3::Z);
        advance(&s, &mut state, Vec3::new(0.3, 0.2, -1.0));
        let c = advance(&s, &mut state, Vec3::new(3.0, -2.0, -1.0));
        assert!((c.force_n - Vec3::Z * K).length() < 1e-12);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    /// On any surface: the tangential force never exceeds the cone, the anchor is where the force says it is, and the
    /// friction never pushes the finger on.
    #[test]
    fn the_cone_holds_on_a_curved_surface_and_the_anchor_agrees_with_the_force(
        moves in prop::collection::vec([-3.0..3.0_f64, -3.0..3.0, -1.5..1.5], 60),
    ) {
        let s = scene(bench_patch(20_389), Some(skin(1.0)));
        let mut hip = bench_path(0.0, 3.0);
        let mut state = free_at(hip);
        for by in moves {
            hip += Vec3::from_array(by);
            let before = state;
            let c = advance(&s, &mut state, hip);
            if c.touch == Touch::Free {
                prop_assert_eq!(anchor_from(c.foot_mm, hip, c.force_n, c.normal, 1.0), None);
                hip = bench_path(0.0, 3.0);
                state = free_at(hip);
                continue;
            }
            let normal = c.force_n.dot(c.normal);
            let t = tangential(&c);
            let mu = if c.touch == Touch::Stick { 0.46 } else { 0.44 };
            prop_assert!(t <= mu * normal + 1e-9, "{t} of {normal}");
            let foot_offset = hip - c.foot_mm;
            prop_assert!((foot_offset + c.normal * c.depth_mm).length() < 1e-9);
            prop_assert!((c.anchor_mm - c.foot_mm).dot(c.normal).abs() < 1e-9);
            prop_assert!((c.force_n - (c.anchor_mm - hip) * K).length() < 1e-9);
            if c.depth_mm > 1e-6 {
                let a = anchor_from(c.foot_mm, hip, c.force_n, c.normal, 1.0).unwrap();
                prop_assert!(a.distance(c.anchor_mm) < 1e-8, "{a} for {}", c.anchor_mm);
            }
            // Slip takes energy out of the spring between HIP and anchor, at the place of the HIP.
            if before.touch != Touch::Free {
                prop_assert!(hip.distance(c.anchor_mm) <= hip.distance(before.proxy_mm) + 1e-9);
            }
        }
    }

    /// Round a closed path, what the finger gets back is less than what it put in; without friction the two are equal up
    /// to the size of the steps.
    #[test]
    fn friction_only_dissipates(radius in 3.0..6.0_f64, depth in 0.5..3.0_f64, laps in 1..3_i32) {
        let mut work = [0.0; 2];
        for (i, friction) in [None, Some(skin(1.0))].into_iter().enumerate() {
            // The lower part of a faceted ball, seen from within, as a height field.
            let ball = |x: f64, y: f64| -(1600.0 - (x * x + y * y).min(1500.0)).sqrt();
            let mesh = height_field([-26.0, 26.0], [-26.0, 26.0], [40, 40], 3200, ball);
            let s = scene(mesh, friction);
            let at = |k: i32| {
                let angle = f64::from(k) / 2000.0 * std::f64::consts::TAU;
                Vec3::new(radius * libm::cos(angle), radius * libm::sin(angle), -40.0 - depth)
            };
            let mut state = free_at(Vec3::ZERO);
            let mut last = (at(0), advance(&s, &mut state, at(0)).force_n);
            // One lap to settle: the anchor then goes round with the finger.
            for k in 1..=2000 * (laps + 1) {
                let c = advance(&s, &mut state, at(k));
                if k > 2000 {
                    work[i] += (c.force_n + last.1).dot(at(k) - last.0) / 2.0;
                }
                last = (at(k), c.force_n);
            }
        }
        let depth = libm::hypot(40.0 + depth, radius) - 40.0;
        let scale = K * depth * radius;
        prop_assert!(work[0].abs() < 1e-3 * scale, "frictionless {}", work[0]);
        // The anchor follows inside the finger's circle, so that the pull is not quite along it.
        let lag = 0.44 * depth / radius;
        let length = std::f64::consts::TAU * radius * f64::from(laps) * (1.0 - lag * lag).sqrt();
        let expected = -0.44 * K * depth * length;
        prop_assert!(work[1] < 0.0, "{work:?} {expected}");
        prop_assert!((work[1] / expected - 1.0).abs() < 0.15, "{} for {expected}", work[1]);
    }
}

/// A looseness of 5e-324 was a stiffness along the skin of infinity, and its product with no pull at all NaN.
#[test]
fn no_looseness_makes_a_force_that_is_not_finite() {
    for looseness in [f64::from_bits(1), 1e-300, 1e300, f64::MAX] {
        for coefficient in [0.0, f64::from_bits(1), 1.0, 1e300] {
            let friction = Friction {
                static_coefficient: coefficient,
                dynamic_coefficient: coefficient,
                skin_looseness: looseness,
            };
            let scene = scene(plane(), Some(friction));
            let mut state = free_at(Vec3::Z);
            for hip in [Vec3::new(3.0, 1.0, -2.0), Vec3::new(-4.0, 2.0, -1.0)] {
                let c = advance(&scene, &mut state, hip);
                assert!(c.force_n.is_finite() && c.anchor_mm.is_finite(), "{c:?}");
                assert!((c.force_n.z + K * hip.z).abs() < 1e-6, "{c:?}");
            }
        }
    }
}

#[test]
fn the_anchor_of_a_device_follows_from_position_and_force() {
    let (foot, hip) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(1.0, 2.0, -1.0));
    let a = anchor_from(foot, hip, Vec3::new(0.3, 0.0, 1.0), Vec3::Z, 1.0);
    assert!(a.unwrap().distance(foot + Vec3::X * 1.2) < 1e-12);
    // A looser skin gives way further under the same force.
    let loose = anchor_from(foot, hip, Vec3::new(0.3, 0.0, 1.0), Vec3::Z, 1.3);
    assert!(loose.unwrap().distance(foot + Vec3::X * 1.56) < 1e-12);
    for none in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let as_one = anchor_from(foot, hip, Vec3::new(0.3, 0.0, 1.0), Vec3::Z, none);
        assert_eq!(as_one, a);
    }
    // No contact, a pull, nonsense: no anchor, and never NaN.
    for force in [
        Vec3::ZERO,
        Vec3::X,
        -Vec3::Z,
        Vec3::NAN,
        Vec3::new(1e300, 0.0, 1e-300),
    ] {
        assert_eq!(anchor_from(foot, hip, force, Vec3::Z, 1.0), None, "{force}");
    }
    assert_eq!(
        anchor_from(hip, foot, Vec3::Z, Vec3::Z, 1.0),
        None,
        "the device is outside"
    );
    let small = anchor_from(
        foot,
        foot - Vec3::Z * 1e-200,
        Vec3::Z * 1e-200,
        Vec3::Z,
        1.0,
    );
    assert!(small.unwrap().distance(foot) < 1e-12);
}
