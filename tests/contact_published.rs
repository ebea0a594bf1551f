//! The haptic pass as published: where it agrees with the production engine, where it fails as print says, and that it
//! keeps the tick's rules.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::contact::published::{self, Options, Published};
use dorsum::contact::{
    Contact, ContactState, Friction, Hip, Stiffness, Touch, TouchScene, advance, anchor_from,
};
use dorsum::geom::{Vec3, unit_or};
use dorsum::partition::bvh::Bvh;
use dorsum::partition::hdb::Query;
use dorsum::partition::tree::{self, Case};
use dorsum::surface::primitives::{bench_patch, bench_path, height_field, icosphere};
use dorsum::surface::{RawMesh, Surface};
use proptest::prelude::*;
use std::sync::Arc;

const K: f64 = 0.8;

fn production(mesh: RawMesh, friction: Option<Friction>) -> TouchScene {
    let (surface, _) = Surface::new(mesh).unwrap();
    let search = Arc::new(Bvh::new(&surface));
    TouchScene {
        friction,
        ..TouchScene::new(Arc::new(surface), search, Stiffness::Uniform(K))
    }
}

fn with(scene: &TouchScene, options: &Options) -> TouchScene {
    let built = Published::build(&scene.surface, options, &mut |_| true);
    TouchScene {
        published: Some(Arc::new(built.unwrap().unwrap())),
        ..scene.clone()
    }
}

fn skin() -> Friction {
    Friction {
        static_coefficient: 0.46,
        dynamic_coefficient: 0.44,
        skin_looseness: 1.0,
    }
}

/// Every structure there is, in every case.
fn structures(query: Query, hdb_part: f64, threshold: usize) -> Vec<Options> {
    let of = |partition, case| Options {
        partition,
        tree: tree::Options { threshold, case },
        hdb_part,
        query,
    };
    vec![
        of("brute", Case::C),
        of("bsp", Case::A),
        of("bsp", Case::B),
        of("bsp", Case::C),
        of("octree", Case::C),
        of("hybrid", Case::C),
    ]
}

fn free_at(p: Vec3) -> ContactState {
    ContactState {
        proxy_mm: p,
        ..ContactState::default()
    }
}

fn plate(z: impl Fn(f64, f64) -> f64) -> RawMesh {
    height_field([-50.0, 50.0], [-50.0, 50.0], [20, 20], 800, z)
}

/// Presses to `hip` from straight above.
fn press(scene: &TouchScene, hip: Vec3) -> Contact {
    let mut state = free_at(Vec3::new(hip.x, hip.y, 20.0));
    let mut contact = Contact::default();
    for i in 1..=100 {
        let z = 20.0 + (hip.z - 20.0) * f64::from(i) / 100.0;
        contact = advance(scene, &mut state, Vec3::new(hip.x, hip.y, z));
    }
    contact
}

#[test]
fn on_planes_the_proxy_stands_where_geometry_says() {
    // A slope, a roof whose sides are nearer than its ridge, a groove along y, a pit: from 3 mm below the origin.
    let hip = Vec3::new(0.0, 0.0, -3.0);
    let steep = 3.0 / libm::sqrt(1.25);
    for options in structures(Query::Complete, 0.3, 40) {
        let felt = |z: fn(f64, f64) -> f64| {
            let c = press(&with(&production(plate(z), None), &options), hip);
            let up = c.foot_mm - hip;
            assert_eq!(c.touch, Touch::Frictionless);
            assert!(
                (up - c.normal * c.depth_mm).length() < 1e-9,
                "{options}: {c:?}"
            );
            assert!(c.force_n.distance(up * K) < 1e-9);
            c
        };
        let slope = felt(|x, _| 0.5 * x);
        assert!(
            (slope.depth_mm - steep).abs() < 1e-9,
            "{options}: {slope:?}"
        );
        let roof = felt(|x, _| -0.5 * x.abs());
        assert!((roof.depth_mm - steep).abs() < 1e-9, "{options}: {roof:?}");
        for hollow in [
            felt(|x, _| 0.5 * x.abs()),
            felt(|x, y| 0.5 * x.abs().max(y.abs())),
        ] {
            assert!(hollow.foot_mm.length() < 1e-6, "{options}: {hollow:?}");
        }
    }
}

/// Slowly over the benchmark patch, without friction: both engines stand at the same place, to rounding, except in the
/// few ticks in which the finger changes facets where two are as good.
#[test]
fn on_a_smooth_patch_at_slow_speed_it_agrees_with_the_production_engine() {
    let scene = production(bench_patch(20_389), None);
    let other = with(&scene, &Options::default());
    let mut states = [free_at(bench_path(0.0, 3.0)); 2];
    let (mut apart, mut touching) = (0, 0);
    for i in 0..3000 {
        let t = f64::from(i) / 1000.0;
        let hip = bench_path(t, -4.0 * libm::sin(1.5 * t));
        let a = advance(&scene, &mut states[0], hip);
        let b = advance(&other, &mut states[1], hip);
        touching += usize::from(a.touch != Touch::Free);
        assert_eq!(a.touch == Touch::Free, b.touch == Touch::Free, "at {t}");
        let step = a.force_n.distance(b.force_n);
        apart += usize::from(step > 1e-6);
        // Two facets of this patch bend by at most 0.03.
        assert!(step <= 0.03 * K * 4.0, "at {t}: {step} N");
    }
    assert!(touching > 1500 && apart < 10, "{apart} of {touching}");
}

/// A motion begun straight back from the finger begins behind a wall that the finger moves away from, and so it fell
/// through pits at first: it begins above all walls of the place.
#[test]
fn in_a_steep_pit_it_leaves_one_wall_for_another_and_stays() {
    let scene = production(plate(|x, y| 3.0 * x.abs().max(y.abs())), None);
    let other = with(&scene, &Options::default());
    let start = Vec3::new(0.0, 0.0, 5.0);
    let mut states = [free_at(start); 2];
    for i in 0..2000 {
        let angle = f64::from(i) * 0.31;
        let down = (f64::from(i) * 0.02).min(1.0);
        let hip = Vec3::new(libm::cos(angle), libm::sin(1.7 * angle), 5.0 - 6.0 * down);
        let a = advance(&scene, &mut states[0], hip);
        let b = advance(&other, &mut states[1], hip);
        assert_eq!(a.touch, b.touch, "at {i}");
        assert!(a.foot_mm.distance(b.foot_mm) < 1e-6, "at {i}: {a:?} {b:?}");
    }
    assert_eq!(states[1].touch, Touch::Frictionless);
}

/// A tangent plane cuts below a hollow surface; an anchor left there would let go of the skin, as it did at first.
#[test]
fn with_friction_it_never_loses_a_bumpy_surface() {
    let scene = production(bench_patch(5_000), Some(skin()));
    let other = with(&scene, &Options::default());
    let mut states = [free_at(bench_path(0.0, 3.0)); 2];
    for i in 0..3000 {
        let t = f64::from(i) / 1000.0;
        let hip = bench_path(t, -4.0 * libm::sin(1.5 * t));
        let a = advance(&scene, &mut states[0], hip);
        let b = advance(&other, &mut states[1], hip);
        let shallow = a.depth_mm.max(b.depth_mm) < 0.01;
        assert!(
            shallow || (a.touch == Touch::Free) == (b.touch == Touch::Free),
            "at {t}"
        );
    }
}

/// With friction one engine takes the tangent plane at the anchor, the other that at the proxy. On a surface of radius R
/// they differ by the angle between them, at most the cone's radius and a facet to either side over R; so do the forces.
#[test]
fn with_friction_it_agrees_within_the_bend_of_the_surface() {
    let (radius, depth, facet) = (150.0, 3.0, 2.5 * std::f64::consts::SQRT_2);
    for outward in [1.0, -1.0] {
        let ball =
            |x: f64, y: f64| outward * (libm::sqrt(radius * radius - x * x - y * y) - radius);
        let mesh = height_field([-50.0, 50.0], [-50.0, 50.0], [40, 40], 3200, ball);
        let scene = production(mesh, Some(skin()));
        let other = with(&scene, &Options::default());
        let mut states = [free_at(Vec3::new(20.0, 0.0, 5.0)); 2];
        let bound = K * depth * 2.0 * (0.46 * depth + 2.0 * facet) / (radius - depth);
        let mut worst = 0.0_f64;
        for i in 0..4000 {
            let angle = 0.7 * libm::sin(f64::from(i) * 0.005);
            let (x, y) = (20.0 * libm::cos(angle), 20.0 * libm::sin(angle));
            let hip = Vec3::new(x, y, ball(x, y) - depth);
            let a = advance(&scene, &mut states[0], hip);
            let b = advance(&other, &mut states[1], hip);
            worst = worst.max(a.force_n.distance(b.force_n));
        }
        assert!(
            worst > 0.0 && worst <= bound,
            "{outward}: {worst} N of {bound}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// What a structure gathers completely is the same set, so the contact is the same, bit for bit.
    #[test]
    fn every_structure_gives_the_same_contact_when_its_query_is_complete(
        moves in prop::collection::vec([-4.0..4.0_f64, -4.0..4.0, -1.5..1.0], 10..60),
        rough in any::<bool>(),
        held in any::<bool>(),
    ) {
        let bumps = |x: f64, y: f64| 2.0 * libm::sin(0.9 * x) * libm::cos(0.8 * y);
        let mesh = if rough { plate(bumps) } else { bench_patch(2_000) };
        let scene = production(mesh, held.then(skin));
        let others: Vec<_> = structures(Query::Complete, 0.15, 30).iter().map(|o| with(&scene, o)).collect();
        let start = Vec3::new(0.3, 0.2, scene.surface.bounds().max.z + 1.0);
        let mut states = vec![free_at(start); others.len()];
        let mut hip = start;
        for by in moves {
            hip += Vec3::from_array(by);
            let felt: Vec<_> = others.iter().zip(&mut states).map(|(s, state)| advance(s, state, hip)).collect();
            for (c, options) in felt.iter().zip(structures(Query::Complete, 0.15, 30)) {
                prop_assert_eq!(c, &felt[0], "{}", options);
            }
        }
    }

    #[test]
    fn the_force_is_finite_within_the_cone_and_never_pulls(
        moves in prop::collection::vec([-6.0..6.0_f64, -6.0..6.0, -3.0..3.0], 1..80),
    ) {
        let bumps = |x: f64, y: f64| 3.0 * libm::sin(0.4 * x) * libm::cos(0.3 * y);
        let scene = production(plate(bumps), Some(skin()));
        let scene = with(&scene, &Options { hdb_part: 0.3, ..Options::default() });
        let mut hip = Vec3::new(0.0, 0.0, 5.0);
        let mut state = free_at(hip);
        for by in moves {
            hip = (hip + Vec3::from_array(by)).clamp(Vec3::splat(-60.0), Vec3::splat(60.0));
            let c = advance(&scene, &mut state, hip);
            prop_assert!(c.force_n.is_finite() && c.anchor_mm.is_finite() && c.depth_mm >= 0.0);
            let normal = c.force_n.dot(c.normal);
            let tangential = (c.force_n - c.normal * normal).length();
            prop_assert!(tangential <= 0.46 * normal + 1e-9, "{} of {}", tangential, normal);
            if c.touch != Touch::Free {
                prop_assert!((c.foot_mm - hip - c.normal * c.depth_mm).length() < 1e-9, "{:?}", c);
            }
        }
    }
}

/// Print: "the size cannot be too small … otherwise the proxy might get through the model surface frequently when the
/// proxy moves quickly". The box reaches half its edge: a step from farther above meets nothing.
#[test]
fn a_fast_finger_punctures_the_skin_where_the_box_is_too_small() {
    let scene = production(plate(|_, _| 0.0), None);
    for options in structures(Query::Complete, 0.02, 40) {
        let small = with(&scene, &options);
        for (above, step, punctures) in [
            (0.9, 2.0, false),
            (1.1, 2.0, true),
            (9.0, 10.0, true),
            (0.4, 0.5, false),
        ] {
            let mut state = free_at(Vec3::new(0.3, 0.2, above));
            let c = advance(&small, &mut state, Vec3::new(0.3, 0.2, above - step));
            assert_eq!(
                c.touch == Touch::Free,
                punctures,
                "{options}: {above} {step}"
            );
            // Once through, it stays through; the production engine never is.
            let after = advance(&small, &mut state, Vec3::new(0.3, 0.2, above - step - 0.1));
            assert_eq!(after.touch == Touch::Free, punctures);
            let mut state = free_at(Vec3::new(0.3, 0.2, above));
            let c = advance(&scene, &mut state, Vec3::new(0.3, 0.2, above - step));
            assert_eq!(c.touch, Touch::Frictionless);
        }
        let published = with(
            &scene,
            &Options {
                hdb_part: 0.25,
                ..options
            },
        );
        let mut state = free_at(Vec3::new(0.3, 0.2, 9.0));
        assert_ne!(
            advance(&published, &mut state, Vec3::new(0.3, 0.2, -1.0)).touch,
            Touch::Free
        );
    }
}

/// Print: the box lags behind the proxy by a frame. Gathering about an older proxy is that.
#[test]
fn what_was_gathered_about_an_older_proxy_is_punctured_too() {
    let scene = production(plate(|_, _| 0.0), None);
    let options = Options {
        hdb_part: 0.1,
        query: Query::Complete,
        ..Options::default()
    };
    let pass = Published::build(&scene.surface, &options, &mut |_| true)
        .unwrap()
        .unwrap();
    let (old, now) = (Vec3::new(0.3, 0.2, 6.0), Vec3::new(0.3, 0.2, 0.5));
    let hip = Vec3::new(0.3, 0.2, -1.0);
    let collide = |about| {
        let mut list = Vec::new();
        let gathered = published::gather(&scene, &pass, about, &mut list);
        assert_eq!(gathered.triangles, list.len());
        published::collide(&scene, &list[..], &free_at(now), hip)
    };
    assert_eq!(collide(old), None);
    let stand = collide(now).unwrap();
    assert!((stand.depth_mm - 1.0).abs() < 1e-12);
    // The three parts are the pass.
    let mut state = free_at(now);
    let (whole, counts) = published::pass(&scene, &pass, &mut state, Hip::from(hip));
    assert_eq!(
        published::force(&scene, Some(&stand), Hip::from(hip)),
        whole
    );
    assert!(counts.sweeps >= 1 && counts.gathered.triangles > 0 && counts.gathered.nodes > 0);
    assert_eq!(
        published::force(&scene, None, Hip::from(hip)).force_n,
        Vec3::ZERO
    );
}

#[test]
fn round_a_ball_it_follows_and_lets_go_as_the_production_engine_does() {
    let scene = production(icosphere(40.0, 3), None);
    for options in [Query::Complete, Query::Published]
        .map(|q| structures(q, 0.25, 64))
        .concat()
    {
        let other = with(&scene, &options);
        let mut states = [free_at(Vec3::X * 50.0); 2];
        for i in 0..600 {
            let angle = f64::from(i) * 0.01;
            let radius = 41.0 - 3.0 * libm::sin(2.0 * angle);
            let hip = Vec3::new(
                libm::cos(angle),
                0.7 * libm::sin(angle),
                0.3 * libm::sin(angle),
            );
            let hip = unit_or(hip, Vec3::X) * radius;
            let a = advance(&scene, &mut states[0], hip);
            let b = advance(&other, &mut states[1], hip);
            assert!(
                a.foot_mm.distance(b.foot_mm) < 1e-6 || a.depth_mm.max(b.depth_mm) < 0.1,
                "{options} at {i}: {a:?} {b:?}"
            );
            assert!(
                (a.depth_mm - b.depth_mm).abs() < 0.02,
                "{options} at {i}: {a:?} {b:?}"
            );
        }
    }
}

#[test]
fn over_a_rim_the_finger_is_free() {
    let scene = with(&production(plate(|_, _| 0.0), None), &Options::default());
    let mut state = free_at(Vec3::new(48.0, 0.2, 1.0));
    let mut seen = Vec::new();
    for i in 0..40 {
        let x = 48.0 + 0.1 * f64::from(i);
        seen.push(advance(&scene, &mut state, Vec3::new(x, 0.2, -2.0)).touch);
    }
    assert_eq!(seen[10], Touch::Frictionless);
    assert_eq!(seen[39], Touch::Free);
}

#[test]
fn what_is_no_number_is_felt_as_nothing() {
    for friction in [None, Some(skin())] {
        let scene = with(
            &production(plate(|_, _| 0.0), friction),
            &Options::default(),
        );
        let mut state = free_at(Vec3::new(0.3, 0.2, 1.0));
        advance(&scene, &mut state, Vec3::new(0.3, 0.2, -2.0));
        let before = state;
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
            for hip in [Vec3::splat(bad), Vec3::new(0.0, bad, 0.0)] {
                let c = advance(&scene, &mut state, hip);
                assert_eq!(c.force_n, Vec3::ZERO);
                assert_eq!(state, before);
            }
            // A state out of nowhere does no harm either.
            for touch in [Touch::Free, Touch::Stick] {
                for triangle in [0, u32::MAX] {
                    let mut lost = ContactState {
                        touch,
                        proxy_mm: Vec3::splat(bad),
                        triangle,
                        ..ContactState::default()
                    };
                    let c = advance(&scene, &mut lost, Vec3::new(0.3, 0.2, -2.0));
                    assert!(c.force_n.is_finite() && c.anchor_mm.is_finite(), "{c:?}");
                }
            }
        }
        let after = advance(&scene, &mut state, Vec3::new(0.3, 0.2, -2.0));
        assert!((after.depth_mm - 2.0).abs() < 1e-9);
    }
}

/// On a plane friction is the production engine's: the same anchor, stick and slip; and the anchor follows from P, D, F.
#[test]
fn on_a_plane_the_anchor_is_the_production_engines() {
    let scene = production(plate(|_, _| 0.0), Some(skin()));
    let other = with(&scene, &Options::default());
    let mut states = [free_at(Vec3::new(0.3, 0.2, 1.0)); 2];
    let mut seen = [0; 4];
    for i in 0..2000 {
        let t = f64::from(i) / 1000.0;
        let across = 12.0 * libm::sin(2.0 * t) * libm::sin(9.0 * t);
        let depth = 3.0 * libm::sin(3.0 * t + 0.01);
        let hip = Vec3::new(0.3 + across, 0.2 + 0.5 * across, -depth);
        let a = advance(&scene, &mut states[0], hip);
        let b = advance(&other, &mut states[1], hip);
        assert_eq!(a.touch, b.touch, "at {t}");
        assert!(a.anchor_mm.distance(b.anchor_mm) < 1e-9 && a.force_n.distance(b.force_n) < 1e-9);
        seen[b.touch as usize] += 1;
        if b.depth_mm > 1e-6 {
            let anchor = anchor_from(b.foot_mm, hip, b.force_n, b.normal, 1.0).unwrap();
            assert!(anchor.distance(b.anchor_mm) < 1e-8);
        }
    }
    assert!(seen[2] > 100 && seen[3] > 100, "{seen:?}");
}
