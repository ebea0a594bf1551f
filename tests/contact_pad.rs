//! The finger pad, a sphere about the proxy: closed forms, optimality and clearance by brute force.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::contact::{
    Choices, Contact, ContactState, Friction, Stiffness, Touch, TouchScene, advance,
};
use dorsum::geom::{Triangle, Vec3, unit_or};
use dorsum::partition::Partition as _;
use dorsum::partition::bvh::Bvh;
use dorsum::surface::primitives::{
    bench_height, bench_patch, bench_path, cuboid, height_field, icosphere,
};
use dorsum::surface::{RawMesh, Surface, torture};
use proptest::prelude::*;
use std::sync::Arc;

const R: f64 = 5.0;
const K: f64 = 0.5;

fn scene(mesh: RawMesh, radius: f64, friction: Option<Friction>) -> TouchScene {
    let (surface, _) = Surface::new(mesh).unwrap();
    let search = Arc::new(Bvh::new(&surface));
    TouchScene {
        friction,
        choices: Choices {
            finger_radius_mm: radius,
            ..Choices::default()
        },
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

/// Goes from `from` to `to` in `ticks` and then stays for as many.
fn press(scene: &TouchScene, from: Vec3, to: Vec3, ticks: u32) -> Contact {
    let mut state = at(from);
    let mut last = Contact::default();
    for i in 1..=2 * ticks {
        let part = (f64::from(i) / f64::from(ticks)).min(1.0);
        last = advance(scene, &mut state, from + (to - from) * part);
    }
    last
}

fn flat(half: f64) -> RawMesh {
    height_field([-half, half], [-half, half], [16, 16], 512, |_, _| 0.0)
}

/// Three walls that meet in the corner (−20, −20, −20) and are felt from the side of the origin.
fn corner() -> RawMesh {
    let at = |i: u32| {
        let side = |bit: u32| if i >> bit & 1 == 1 { 20.0 } else { -20.0 };
        Vec3::new(side(0), side(1), side(2))
    };
    RawMesh {
        positions: (0..7).map(at).collect(),
        triangles: vec![
            [0, 1, 3],
            [0, 3, 2],
            [0, 2, 6],
            [0, 6, 4],
            [0, 4, 5],
            [0, 5, 1],
        ],
    }
}

fn closest(surface: &Surface, p: Vec3) -> f64 {
    (0..surface.triangles().len() as u32)
        .map(|t| surface.triangle(t).closest_point(p).point.distance(p))
        .fold(f64::INFINITY, f64::min)
}

/// The smallest part of `to_hip` that is left when pushes along `normals` take away what they can: zero where a centre
/// held by them cannot come nearer to the HIP (Karush, Kuhn, Tucker).
fn unheld(to_hip: Vec3, normals: &[Vec3]) -> f64 {
    let mut least = to_hip.length();
    let mut offer = |subset: &[Vec3], shares: &[f64]| {
        if shares.iter().all(|&s| s >= -1e-12) {
            let rest: Vec3 = subset.iter().zip(shares).map(|(&n, &s)| n * s).sum();
            least = least.min((to_hip + rest).length());
        }
    };
    for (i, &a) in normals.iter().enumerate() {
        offer(&[a], &[-to_hip.dot(a)]);
        for (j, &b) in normals[i + 1..].iter().enumerate() {
            let (c, ra, rb) = (a.dot(b), -to_hip.dot(a), -to_hip.dot(b));
            let det = 1.0 - c * c;
            if det > 1e-14 {
                offer(&[a, b], &[(ra - c * rb) / det, (rb - c * ra) / det]);
            }
            for &d in &normals[i + j + 2..] {
                let det = a.dot(b.cross(d));
                if det.abs() > 1e-9 {
                    let by = |v: Vec3| -to_hip.dot(v) / det;
                    offer(
                        &[a, b, d],
                        &[by(b.cross(d)), by(d.cross(a)), by(a.cross(b))],
                    );
                }
            }
        }
    }
    least
}

/// Directions from the triangles that a ball about `c` touches.
fn touching(surface: &Surface, c: Vec3, radius: f64, within: f64) -> Vec<Vec3> {
    let mut normals: Vec<Vec3> = Vec::new();
    for t in 0..surface.triangles().len() as u32 {
        let Triangle { a, b, c: d } = surface.triangle(t);
        let p = Triangle { a, b, c: d }.closest_point(c).point;
        let n = unit_or(c - p, Vec3::ZERO);
        if p.distance(c) <= radius + within && normals.iter().all(|m| m.distance(n) > 1e-9) {
            normals.push(n);
        }
    }
    normals
}

#[test]
fn on_a_plane_the_centre_stays_a_radius_above_and_the_force_is_that_of_its_depth() {
    let s = scene(flat(40.0), R, None);
    let c = press(&s, Vec3::new(1.3, 2.1, 9.0), Vec3::new(1.3, 2.1, 1.5), 40);
    assert_eq!(c.touch, Touch::Frictionless);
    assert!((c.depth_mm - 3.5).abs() < 1e-12, "{}", c.depth_mm);
    assert!(c.anchor_mm.distance(Vec3::new(1.3, 2.1, R)) < 1e-12);
    assert!(c.force_n.distance(Vec3::Z * (K * 3.5)) < 1e-12);
    let above = press(
        &s,
        Vec3::new(1.3, 2.1, 9.0),
        Vec3::new(1.3, 2.1, R + 1e-9),
        40,
    );
    assert_eq!(above.touch, Touch::Free);
}

#[test]
fn on_a_plane_friction_is_that_of_a_point() {
    for radius in [0.0, 0.5, R, 40.0] {
        let s = scene(flat(40.0), radius, skin());
        let mut state = at(Vec3::new(0.3, 0.2, radius + 1.0));
        advance(&s, &mut state, Vec3::new(0.3, 0.2, radius - 2.0));
        let held = advance(&s, &mut state, Vec3::new(0.3 + 0.9, 0.2, radius - 2.0));
        assert_eq!(held.touch, Touch::Stick, "{radius}");
        assert!((held.force_n.x + K * 0.9).abs() < 1e-12, "{radius}");
        let slid = advance(&s, &mut state, Vec3::new(0.3 + 1.7, 0.2, radius - 2.0));
        assert_eq!(slid.touch, Touch::Slip, "{radius}");
        assert!(
            (slid.anchor_mm.x - (2.0 - 0.44 * 2.0)).abs() < 1e-9,
            "{radius}"
        );
    }
}

#[test]
fn over_an_edge_and_a_corner_it_rolls_on_a_cylinder_and_a_ball() {
    let s = scene(cuboid(Vec3::splat(-20.0), Vec3::splat(20.0)), R, None);
    for (hip, foot) in [
        (Vec3::new(22.0, 3.0, 23.0), Vec3::new(20.0, 3.0, 20.0)),
        (Vec3::new(21.0, 22.0, 22.5), Vec3::splat(20.0)),
    ] {
        let out = unit_or(hip - foot, Vec3::ZERO);
        let c = press(&s, foot + out * 9.0 + Vec3::X * 2.0, hip, 200);
        let expected = foot + out * R;
        assert!(
            c.anchor_mm.distance(expected) < 1e-6,
            "{hip}: {}",
            c.anchor_mm
        );
        assert!((c.depth_mm - hip.distance(expected)).abs() < 1e-9);
        assert!(c.normal.distance(out) < 1e-6);
    }
}

#[test]
fn in_a_corner_three_walls_hold_it_within_one_tick() {
    let s = scene(corner(), R, None);
    let mut state = at(Vec3::ZERO);
    let hip = Vec3::new(-17.0, -18.0, -19.0);
    let c = advance(&s, &mut state, hip);
    let expected = Vec3::splat(-15.0);
    assert!(c.anchor_mm.distance(expected) < 1e-9, "{}", c.anchor_mm);
    assert!(c.force_n.distance((expected - hip) * K) < 1e-9);
}

#[test]
fn over_a_slot_it_rests_on_both_lips_and_a_point_falls_in() {
    let width = 6.0;
    let block = |x: f64| {
        cuboid(
            Vec3::new(x - 20.0, -30.0, -20.0),
            Vec3::new(x + 20.0, 30.0, 0.0),
        )
    };
    let mut mesh = block(-20.0 - width / 2.0);
    let other = block(20.0 + width / 2.0);
    let n = mesh.positions.len() as u32;
    mesh.positions.extend(other.positions);
    mesh.triangles
        .extend(other.triangles.iter().map(|t| t.map(|v| v + n)));
    let (from, to) = (Vec3::new(0.4, 1.0, 12.0), Vec3::new(0.2, 1.0, 0.5));
    let c = press(&scene(mesh.clone(), R, None), from, to, 100);
    let height = (R * R - width * width / 4.0).sqrt();
    let expected = Vec3::new(0.0, 1.0, height);
    assert!(c.anchor_mm.distance(expected) < 1e-9, "{}", c.anchor_mm);
    let point = press(&scene(mesh, 0.0, None), from, to, 100);
    assert_eq!(point.touch, Touch::Free);
}

#[test]
fn a_ball_on_a_ball_stays_at_the_sum_of_the_radii() {
    let s = scene(icosphere(50.0, 4), R, None);
    let mut state = at(Vec3::Z * 60.0);
    for i in 0..400 {
        let a = 0.004 * f64::from(i);
        let out = unit_or(
            Vec3::new(libm::sin(a), libm::sin(a) * libm::cos(a), libm::cos(a)),
            Vec3::ZERO,
        );
        let c = advance(&s, &mut state, out * 48.0);
        // The facets lie inside the sphere by at most the sagitta of an edge, about 0.1 mm.
        let from_centre = c.anchor_mm.length();
        assert!((54.85..=55.0001).contains(&from_centre), "{from_centre}");
        assert!(c.normal.dot(out) > 0.99);
    }
}

#[test]
fn it_slides_off_a_rim_and_is_free_below() {
    let s = scene(flat(20.0), R, None);
    let mut state = at(Vec3::new(10.0, 0.0, 6.0));
    let mut worst: f64 = 0.0;
    for i in 0..4000 {
        let hip = Vec3::new(10.0 + 0.005 * f64::from(i), 0.0, 3.0);
        let c = advance(&s, &mut state, hip);
        let expected = if hip.x <= 20.0 {
            Vec3::new(hip.x, 0.0, R)
        } else if hip.x < 24.0 {
            Vec3::X * 20.0 + unit_or(hip - Vec3::X * 20.0, Vec3::ZERO) * R
        } else {
            hip
        };
        worst = worst.max(c.anchor_mm.distance(expected));
    }
    assert!(worst < 0.02, "{worst}");
    assert_eq!(state.touch, Touch::Free);
}

#[test]
fn what_comes_out_from_inside_feels_nothing_until_it_is_clear() {
    let s = scene(cuboid(Vec3::splat(-20.0), Vec3::splat(20.0)), R, None);
    let mut state = at(Vec3::ZERO);
    for i in 0..=249 {
        let c = advance(&s, &mut state, Vec3::X * (0.1 * f64::from(i)));
        assert_eq!(c.touch, Touch::Free, "{i}");
    }
    advance(&s, &mut state, Vec3::X * 25.5);
    let c = advance(&s, &mut state, Vec3::X * 24.0);
    assert!((c.depth_mm - 1.0).abs() < 1e-12);
}

#[test]
fn what_is_no_number_and_what_is_no_radius_do_no_harm() {
    for radius in [R, 1e-300, 1e300, f64::NAN, f64::INFINITY, -1.0] {
        for friction in [None, skin()] {
            let s = scene(flat(40.0), radius, friction);
            for bad in [f64::NAN, f64::INFINITY, f64::MIN_POSITIVE, 1e300] {
                let mut state = at(Vec3::Z * 9.0);
                for hip in [
                    Vec3::new(1.0, bad, 2.0),
                    Vec3::new(1.0, 2.0, 1.0),
                    Vec3::splat(bad),
                ] {
                    let c = advance(&s, &mut state, hip);
                    let sane = c.force_n.is_finite() && c.normal.is_finite();
                    assert!(sane && c.depth_mm.is_finite(), "{radius} {hip}: {c:?}");
                }
                // A state out of nowhere.
                let mut lost = ContactState {
                    touch: Touch::Slip,
                    ..at(Vec3::splat(bad))
                };
                let c = advance(&s, &mut lost, Vec3::new(1.0, 2.0, 1.0));
                assert!(c.force_n.is_finite(), "{radius} {bad}: {c:?}");
            }
        }
    }
}

#[test]
fn a_small_pad_feels_what_a_point_feels() {
    let radius = 0.01;
    let mesh = bench_patch(2962);
    let (point, pad) = (scene(mesh.clone(), 0.0, None), scene(mesh, radius, None));
    let start = bench_path(0.0, 20.0);
    let (mut a, mut b) = (at(start), at(start));
    let n = 3000;
    let mut apart = 0;
    for i in 0..n {
        let hip = bench_path(f64::from(i) / 20_000.0, -3.0);
        let (p, q) = (advance(&point, &mut a, hip), advance(&pad, &mut b, hip));
        assert_eq!(p.touch == Touch::Free, q.touch == Touch::Free);
        apart += u32::from(p.force_n.distance(q.force_n) > 1.5 * K * radius);
    }
    // A ridge is left a tick or two earlier.
    assert!(apart < n / 100, "{apart} of {n}");
}

#[test]
fn at_any_speed_it_stays_clear_and_outside() {
    for (speed, friction) in [(0.3, None), (3.0, None), (30.0, skin()), (300.0, None)] {
        let s = scene(bench_patch(6000), R, friction);
        let mut state = at(Vec3::new(0.0, 0.0, 150.0));
        let step: f64 = speed; // mm a tick
        let mut hip = Vec3::new(3.0, 5.0, 140.0);
        for i in 0..400 {
            let turn = 0.7 * f64::from(i) * f64::min(step / 40.0, 1.0);
            hip += Vec3::new(libm::cos(turn), libm::sin(1.3 * turn), 0.0) * step;
            hip = hip.clamp(
                Vec3::new(-120.0, -150.0, 0.0),
                Vec3::new(120.0, 150.0, 200.0),
            );
            hip.z = bench_height(hip.x, hip.y)
                + 12.0 * libm::cos(0.05 * f64::from(i) * step.min(3.0))
                - 4.0;
            let c = advance(&s, &mut state, hip);
            let clearance = closest(&s.surface, c.anchor_mm);
            assert!(
                c.touch == Touch::Free || clearance >= R * (1.0 - 1e-9),
                "{speed} {i}: {clearance}"
            );
            assert!(c.anchor_mm.z > bench_height(c.anchor_mm.x, c.anchor_mm.y) - 0.5);
            assert!(c.force_n.is_finite());
            if c.touch == Touch::Free {
                assert!(closest(&s.surface, hip) >= R * (1.0 - 1e-9));
            }
        }
    }
}

#[test]
fn a_finer_or_scaled_or_distant_mesh_feels_alike() {
    let base = bench_patch(2962);
    let moved = |scale: f64, by: Vec3| {
        let mut mesh = base.clone();
        mesh.positions.iter_mut().for_each(|p| *p = *p * scale + by);
        mesh
    };
    let far = Vec3::new(1.0e6, -1.0e6, 1.0e6);
    let run = |scale: f64, by: Vec3, friction: Option<Friction>| -> Vec<Vec3> {
        let s = scene(moved(scale, by), R * scale, friction);
        let mut state = at(bench_path(0.0, 40.0) * scale + by);
        (0..600)
            .map(|i| {
                let hip = bench_path(f64::from(i) * 1e-3, 1.0) * scale + by;
                (advance(&s, &mut state, hip).anchor_mm - by) / scale
            })
            .collect()
    };
    // Where friction lets the centre rest depends on its way, hence on rounding, by less than a tick's motion.
    for (friction, most) in [(None, 1e-7), (skin(), 0.28)] {
        let here = run(1.0, Vec3::ZERO, friction);
        for (scale, by) in [(1e-3, Vec3::ZERO), (1024.0, Vec3::ZERO), (1.0, far)] {
            let there = run(scale, by, friction);
            let pairs = here.iter().zip(&there);
            let apart = pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            assert!(apart < most, "{scale} {by}: {apart}");
        }
    }
}

/// Waves with random amplitudes: convex, concave and saddle-shaped places.
fn waves(amplitude: [f64; 3], phase: [f64; 3]) -> RawMesh {
    height_field([-30.0, 30.0], [-30.0, 30.0], [20, 20], 800, move |x, y| {
        amplitude[0] * libm::sin(x / 5.0 + phase[0])
            + amplitude[1] * libm::sin(y / 4.0 + phase[1])
            + amplitude[2] * libm::sin((x + y) / 3.0 + phase[2])
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn at_rest_no_touching_triangle_lets_it_nearer_to_the_hip(
        amplitude in [0.0..3.0, 0.0..3.0, 0.0..1.5],
        phase in [0.0..6.0, 0.0..6.0, 0.0..6.0],
        x in -15.0_f64..15.0,
        y in -15.0_f64..15.0,
        z in -12.0_f64..6.0,
        radius in 0.5_f64..8.0,
    ) {
        let s = scene(waves(amplitude, phase), radius, None);
        let hip = Vec3::new(x, y, z);
        let mut state = at(Vec3::new(x, y, 30.0));
        let mut c = Contact::default();
        for _ in 0..300 {
            c = advance(&s, &mut state, hip);
        }
        if c.touch == Touch::Free {
            prop_assert!(closest(&s.surface, hip) >= radius * (1.0 - 1e-9));
        } else {
            let centre = c.anchor_mm;
            let clearance = closest(&s.surface, centre);
            prop_assert!(clearance >= radius * (1.0 - 1e-12), "{clearance} {radius}");
            let to_hip = hip - centre;
            let left = unheld(to_hip, &touching(&s.surface, centre, radius, 1e-7));
            prop_assert!(left <= 1e-5 * (1.0 + to_hip.length()), "{left} of {to_hip}");
            prop_assert!((c.depth_mm - to_hip.length()).abs() < 1e-6);
        }
    }
}

/// The torture surfaces at every speed: never nearer than a radius, never inside, nothing that is no number, no step away from
/// the finger, no pull beyond the cone.
#[test]
fn no_surface_breaks_the_pad() {
    for case in torture::all(1) {
        for (friction, step) in [
            (None, 0.01),
            (None, 0.1),
            (None, 1.0),
            (None, 10.0),
            (skin(), 0.1),
            (skin(), 10.0),
        ] {
            let radius = 0.05;
            let s = scene(case.mesh.clone(), radius, friction);
            let start = case.path[0];
            if closest(&s.surface, start) <= radius {
                // The path starts where no pad fits in.
                assert_eq!(case.name, "0.1° slot");
                continue;
            }
            let mut state = at(start);
            let (mut from, mut ticks) = (start, 0);
            'path: for corner in case.path[1..].iter().cycle() {
                while from != *corner {
                    let way = *corner - from;
                    let hip = if way.length() <= step {
                        *corner
                    } else {
                        from + unit_or(way, Vec3::ZERO) * step
                    };
                    let before = state.proxy_mm;
                    let c = advance(&s, &mut state, hip);
                    let told = || format!("{} at {step} mm, tick {ticks}, {hip}: {c:?}", case.name);
                    assert!(
                        c.force_n.is_finite() && c.anchor_mm.is_finite(),
                        "{}",
                        told()
                    );
                    if c.touch != Touch::Free {
                        let near = s.search.nearest(&s.surface, c.anchor_mm, radius);
                        let clearance = near.map_or(radius, |n| n.distance_sq.sqrt());
                        assert!(
                            clearance >= radius * (1.0 - 1e-8),
                            "{clearance}: {}",
                            told()
                        );
                        let pull = c.foot_mm.distance(c.anchor_mm);
                        assert!(
                            pull <= 0.46 * c.depth_mm * (1.0 + 1e-9) + 1e-9,
                            "{pull}: {}",
                            told()
                        );
                    }
                    let depth = case.truth.depth_mm(c.anchor_mm);
                    assert!(depth <= 1e-9, "{depth}: {}", told());
                    if friction.is_none() {
                        let (far, was) = (hip.distance(c.anchor_mm), hip.distance(before));
                        assert!(far <= was + 1e-9, "{far} from {was}: {}", told());
                    }
                    from = hip;
                    ticks += 1;
                    if ticks == 1500 {
                        break 'path;
                    }
                }
            }
        }
    }
}
