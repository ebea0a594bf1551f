//! Where the frictionless proxy comes to rest: closed forms, convex projections, brute-force minima.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::contact::{Contact, ContactState, Stiffness, Touch, TouchScene, advance};
use dorsum::geom::Vec3;
use dorsum::partition::Partition;
use dorsum::partition::brute::Brute;
use dorsum::partition::bvh::Bvh;
use dorsum::surface::primitives::{bench_patch, cuboid, height_field, icosphere};
use dorsum::surface::{RawMesh, Surface};
use proptest::prelude::*;
use std::sync::Arc;

const K: f64 = 0.5;

fn scene(mesh: RawMesh) -> TouchScene {
    let (surface, _) = Surface::new(mesh).unwrap();
    let search = Arc::new(Bvh::new(&surface));
    TouchScene::new(Arc::new(surface), search, Stiffness::Uniform(K))
}

/// `outer` with `inner` hollowed out of it, open where both have lost the triangles `lid`: a closed body whose cavity can
/// be reached. `mouth` are the vertices of the opening, counter-clockwise seen from outside, the same in both.
fn hollow(outer: RawMesh, inner: RawMesh, lid: &[usize], mouth: &[u32]) -> RawMesh {
    let n = outer.positions.len() as u32;
    let keep = |mesh: &RawMesh| -> Vec<[u32; 3]> {
        let all = mesh.triangles.iter().enumerate();
        all.filter(|(i, _)| !lid.contains(i))
            .map(|(_, &t)| t)
            .collect()
    };
    let mut mesh = RawMesh {
        triangles: keep(&outer),
        positions: outer.positions,
    };
    mesh.triangles
        .extend(keep(&inner).iter().map(|t| [t[0] + n, t[2] + n, t[1] + n]));
    mesh.positions.extend(inner.positions);
    for i in 0..mouth.len() {
        let (a, b) = (mouth[i], mouth[(i + 1) % mouth.len()]);
        mesh.triangles.extend([[a, b, b + n], [a, b + n, a + n]]);
    }
    mesh
}

/// A box-shaped cavity, open at the top of its box.
fn cup(low: Vec3, high: Vec3) -> RawMesh {
    let wall = Vec3::new(5.0, 5.0, 5.0);
    let outer = cuboid(low - wall, Vec3::new(high.x + 5.0, high.y + 5.0, high.z));
    hollow(outer, cuboid(low, high), &[2, 3], &[4, 5, 7, 6])
}

/// A ball-shaped cavity, open at one triangle near the top.
fn bowl(radius: f64, levels: u32) -> RawMesh {
    let (outer, inner) = (icosphere(8.0 * radius, levels), icosphere(radius, levels));
    let height = |t: &[u32; 3]| -> f64 { t.map(|v| outer.positions[v as usize].z).iter().sum() };
    let lid = (0..outer.triangles.len())
        .max_by(|&a, &b| height(&outer.triangles[a]).total_cmp(&height(&outer.triangles[b])))
        .unwrap();
    let mouth = outer.triangles[lid];
    hollow(outer, inner, &[lid], &mouth)
}

fn free_at(p: Vec3) -> ContactState {
    ContactState {
        touch: Touch::Free,
        proxy_mm: p,
        ..ContactState::default()
    }
}

/// What must hold of any contact, whatever the surface.
fn sound(c: &Contact, state: &ContactState, hip: Vec3) {
    assert_eq!((state.touch, state.triangle), (c.touch, c.triangle));
    assert_eq!(state.proxy_mm, c.anchor_mm, "the state is in the record");
    assert!(c.force_n.is_finite() && c.foot_mm.is_finite());
    if c.touch == Touch::Free {
        assert_eq!((c.anchor_mm, c.foot_mm), (hip, hip));
        assert_eq!(
            (c.force_n, c.normal, c.depth_mm),
            (Vec3::ZERO, Vec3::ZERO, 0.0)
        );
    } else {
        assert!((c.normal.length() - 1.0).abs() < 1e-12);
        assert!(c.depth_mm >= 0.0);
    }
}

fn step(scene: &TouchScene, state: &mut ContactState, hip: Vec3) -> Contact {
    let c = advance(scene, state, hip);
    sound(&c, state, hip);
    c
}

fn plane() -> RawMesh {
    height_field([-50.0, 50.0], [-50.0, 50.0], [10, 10], 200, |_, _| 0.0)
}

#[test]
fn on_a_plane_the_proxy_is_the_foot_and_the_force_is_hookes() {
    let s = scene(plane());
    let mut state = free_at(Vec3::new(1.0, 2.0, 3.0));
    for (x, y, z) in [
        (1.0, 2.0, -4.0),
        (12.3, -31.0, -0.5),
        (-40.0, 44.0, -9.0),
        (10.0, 10.0, -1.0),
    ] {
        let c = step(&s, &mut state, Vec3::new(x, y, z));
        assert!(c.anchor_mm.distance(Vec3::new(x, y, 0.0)) < 1e-12);
        assert_eq!(c.anchor_mm, c.foot_mm);
        assert!((c.depth_mm + z).abs() < 1e-12);
        assert!((c.force_n - Vec3::new(0.0, 0.0, -z * K)).length() < 1e-12);
        assert_eq!(c.touch, Touch::Frictionless);
    }
    assert_eq!(
        step(&s, &mut state, Vec3::new(10.0, 10.0, 0.1)).touch,
        Touch::Free
    );
}

#[test]
fn a_hip_on_the_plane_itself_is_held_without_force_and_stopped_when_it_goes_in() {
    let s = scene(plane());
    let mut state = free_at(Vec3::new(1.0, 2.0, 3.0));
    for x in [1.0, 5.0, 10.0, 20.0] {
        let c = step(&s, &mut state, Vec3::new(x, 2.0, 0.0));
        assert_eq!(c.force_n, Vec3::ZERO);
    }
    let c = step(&s, &mut state, Vec3::new(20.0, 2.0, -1e-9));
    assert_eq!(c.touch, Touch::Frictionless);
    let c = step(&s, &mut state, Vec3::new(20.0, 2.0, -3.0));
    assert!((c.force_n.z - 3.0 * K).abs() < 1e-12);
}

#[test]
fn a_finger_from_below_passes_and_is_stopped_from_above() {
    let s = scene(plane());
    let mut state = free_at(Vec3::new(1.0, 2.0, -3.0));
    assert_eq!(
        step(&s, &mut state, Vec3::new(1.0, 2.0, -1.0)).touch,
        Touch::Free
    );
    assert_eq!(
        step(&s, &mut state, Vec3::new(1.0, 2.0, 1.0)).touch,
        Touch::Free
    );
    assert_eq!(
        step(&s, &mut state, Vec3::new(1.0, 2.0, -1.0)).touch,
        Touch::Frictionless
    );
}

#[test]
fn at_an_open_rim_the_finger_slides_off_and_is_free() {
    let s = scene(plane());
    let mut state = free_at(Vec3::new(45.0, 2.0, 3.0));
    assert_eq!(
        step(&s, &mut state, Vec3::new(45.0, 2.0, -5.0)).touch,
        Touch::Frictionless
    );
    assert_eq!(
        step(&s, &mut state, Vec3::new(49.9, 2.0, -5.0)).touch,
        Touch::Frictionless
    );
    assert_eq!(
        step(&s, &mut state, Vec3::new(50.1, 2.0, -5.0)).touch,
        Touch::Free
    );
    // From below and beside, nothing holds it.
    assert_eq!(
        step(&s, &mut state, Vec3::new(40.0, 2.0, -5.0)).touch,
        Touch::Free
    );
    assert_eq!(
        step(&s, &mut state, Vec3::new(40.0, 2.0, 5.0)).touch,
        Touch::Free
    );
    // Off a corner as well, and onto what lies beyond within the same tick.
    assert_eq!(
        step(&s, &mut state, Vec3::new(49.0, 49.0, -1.0)).touch,
        Touch::Frictionless
    );
    assert_eq!(
        step(&s, &mut state, Vec3::new(52.0, 53.0, -1.0)).touch,
        Touch::Free
    );
}

#[test]
fn a_hip_that_is_no_place_leaves_the_proxy_where_it_was() {
    let s = scene(plane());
    let mut state = free_at(Vec3::new(1.0, 2.0, 3.0));
    step(&s, &mut state, Vec3::new(1.0, 2.0, -4.0));
    let before = state;
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200, -1e10] {
        let c = advance(&s, &mut state, Vec3::new(1.0, bad, 0.0));
        assert_eq!(state, before);
        assert_eq!(c.force_n, Vec3::ZERO);
        assert_eq!(
            (c.touch, c.triangle, c.anchor_mm),
            (before.touch, before.triangle, before.proxy_mm)
        );
    }
    let c = step(&s, &mut state, Vec3::new(1.0, 2.0, -4.0));
    assert!((c.force_n.z - 4.0 * K).abs() < 1e-12);
    let mut lost = ContactState {
        triangle: 99_999,
        ..before
    };
    assert_eq!(
        advance(&s, &mut lost, Vec3::new(1.0, 2.0, 9.0)).touch,
        Touch::Free
    );
}

#[test]
fn stiffness_is_barycentric_on_the_triangle() {
    let mut s = scene(plane());
    let k = |p: Vec3| 0.5 + 0.004 * p.x - 0.002 * p.y;
    s.stiffness = Stiffness::PerVertex(s.surface.positions().iter().map(|&p| k(p)).collect());
    let mut state = free_at(Vec3::new(1.0, 2.0, 3.0));
    for (x, y) in [(1.0, 2.0), (-33.0, 17.5), (40.0, 40.0), (11.1, -48.0)] {
        let hip = Vec3::new(x, y, -2.0);
        let c = step(&s, &mut state, hip);
        assert!((c.stiffness_n_per_mm - k(hip)).abs() < 1e-12);
        assert!((c.force_n.z - 2.0 * k(hip)).abs() < 1e-12);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// Inside a box the free space is convex and the closest point is a clamp: faces, valleys (two planes) and corners
    /// (three), reached in one tick however far the HIP jumps.
    #[test]
    fn in_a_box_shaped_cavity_the_proxy_is_the_clamped_hip(
        hips in prop::collection::vec([-30.0..30.0_f64, -30.0..30.0, -30.0..7.9], 30),
    ) {
        let (low, high) = (Vec3::new(-10.0, -7.0, -12.0), Vec3::new(9.0, 11.0, 8.0));
        let s = scene(cup(low, high));
        let mut state = free_at(Vec3::ZERO);
        for hip in hips {
            let hip = Vec3::from_array(hip);
            let c = step(&s, &mut state, hip);
            let expected = hip.clamp(low, high);
            prop_assert!(c.anchor_mm.distance(expected) < 1e-11, "{hip}: {} for {expected}", c.anchor_mm);
            prop_assert!((c.force_n - (expected - hip) * K).length() < 1e-10);
            prop_assert_eq!(c.touch == Touch::Free, expected == hip);
        }
    }

    /// The same in a faceted ball: the projection onto a convex set is unique, so brute force knows it; and it never
    /// stretches a step, which bounds the step of the force.
    #[test]
    fn in_a_ball_shaped_cavity_the_proxy_is_the_closest_point_and_the_force_is_continuous(
        hips in prop::collection::vec(([-25.0..25.0_f64, -25.0..25.0, -25.0..-3.0], 0.001..1.0_f64), 20),
    ) {
        let s = scene(bowl(15.0, 2));
        let mut state = free_at(-Vec3::Z * 3.0);
        let (mut last_hip, mut last_force) = (-Vec3::Z * 3.0, Vec3::ZERO);
        for (target, share) in hips {
            let hip = last_hip + (Vec3::from_array(target) - last_hip) * share * share;
            let c = step(&s, &mut state, hip);
            if c.touch != Touch::Free {
                let closest = Brute.nearest(&s.surface, hip, f64::INFINITY).unwrap().point;
                prop_assert!(c.anchor_mm.distance(closest) < 1e-10, "{hip}: {} for {closest}", c.anchor_mm);
            }
            let stretch = (c.force_n - last_force).length() - K * (hip - last_hip).length();
            prop_assert!(stretch < 1e-10, "{stretch}");
            (last_hip, last_force) = (hip, c.force_n);
        }
    }

    /// On any surface a resting proxy has no closer point on the triangles it touches.
    #[test]
    fn on_a_rough_surface_the_proxy_rests_in_a_local_minimum(
        seed in 0_u32..1000,
        moves in prop::collection::vec([-6.0..6.0_f64, -6.0..6.0, -6.0..6.0], 40),
    ) {
        let rough = |x: f64, y: f64| {
            let a = f64::from(seed);
            3.0 * libm::sin(1.3 * x + a) * libm::sin(0.9 * y + 2.0 * a) + libm::sin(3.1 * x * y + a)
        };
        let s = scene(height_field([-20.0, 20.0], [-20.0, 20.0], [40, 40], 3200, rough));
        let mut hip = Vec3::new(0.0, 0.0, 10.0);
        let mut state = free_at(hip);
        for by in moves {
            hip = (hip + Vec3::from_array(by)).clamp(Vec3::new(-17.0, -17.0, -8.0), Vec3::new(17.0, 17.0, 8.0));
            let c = step(&s, &mut state, hip);
            if c.touch == Touch::Free {
                continue;
            }
            let reach = c.anchor_mm.distance(hip);
            for t in 0..s.surface.triangles().len() as u32 {
                let triangle = s.surface.triangle(t);
                if triangle.closest_point(c.anchor_mm).point.distance(c.anchor_mm) < 1e-9 {
                    let near = triangle.closest_point(hip).point.distance(hip);
                    prop_assert!(near > reach - 1e-9, "{hip}: {} could be {near}, is {reach}", c.anchor_mm);
                }
            }
            prop_assert!((c.force_n - (c.anchor_mm - hip) * K).length() < 1e-9);
        }
    }
}

#[test]
fn over_a_ridge_the_force_turns_with_the_face() {
    // A roof along y with slopes of 45°, ridge at x = 0.
    let s = scene(height_field(
        [-20.0, 20.0],
        [-20.0, 20.0],
        [2, 2],
        8,
        |x, _| -x.abs(),
    ));
    let mut state = free_at(Vec3::new(-5.0, 1.0, 5.0));
    let left = step(&s, &mut state, Vec3::new(-4.0, 1.0, -8.0));
    let root = 0.5_f64.sqrt();
    assert!((left.normal - Vec3::new(-root, 0.0, root)).length() < 1e-12);
    assert!((left.depth_mm - 4.0 * root).abs() < 1e-12);
    // A little past the middle the left face still holds it, until its foot is over the ridge.
    let held = step(&s, &mut state, Vec3::new(1.0, 1.0, -8.0));
    assert!(held.normal.x < 0.0);
    let over = step(&s, &mut state, Vec3::new(9.0, 1.0, -8.0));
    assert_eq!(
        over.touch,
        Touch::Free,
        "beyond the ridge the HIP is outside: {over:?}"
    );
    let right = step(&s, &mut state, Vec3::new(7.0, 1.0, -8.0));
    assert!((right.normal - Vec3::new(root, 0.0, root)).length() < 1e-12);
}

#[test]
fn in_a_valley_two_planes_hold_and_the_force_points_at_the_edge() {
    let s = scene(height_field(
        [-20.0, 20.0],
        [-20.0, 20.0],
        [2, 2],
        8,
        |x, _| x.abs(),
    ));
    let mut state = free_at(Vec3::new(-5.0, 1.0, 9.0));
    for (x, y, z) in [
        (-1.0, 3.0, -5.0),
        (2.0, -4.0, -5.0),
        (0.0, 0.0, -3.0),
        (2.9, 9.0, -3.0),
    ] {
        let hip = Vec3::new(x, y, z);
        let c = step(&s, &mut state, hip);
        assert!(
            c.anchor_mm.distance(Vec3::new(0.0, y, 0.0)) < 1e-12,
            "{c:?}"
        );
        assert!((c.force_n - (Vec3::new(0.0, y, 0.0) - hip) * K).length() < 1e-12);
    }
}

#[test]
fn slowly_around_a_closed_box_the_finger_comes_free_at_every_edge() {
    let s = scene(cuboid(Vec3::splat(-10.0), Vec3::splat(10.0)));
    let mut state = free_at(Vec3::new(0.0, 0.0, 12.0));
    let mut freed = 0;
    let mut before = Touch::Free;
    for i in 0..4000 {
        let angle = f64::from(i) * std::f64::consts::TAU / 2000.0;
        let hip = Vec3::new(10.5 * libm::sin(angle), 1.0, 10.5 * libm::cos(angle));
        let c = step(&s, &mut state, hip);
        let inside = hip.abs().max_element() < 10.0;
        assert_eq!(c.touch == Touch::Frictionless, inside, "{hip}");
        freed += u32::from(before != Touch::Free && c.touch == Touch::Free);
        before = c.touch;
    }
    assert_eq!(freed, 8);
}

#[test]
fn the_bench_path_is_followed_within_3_mm() {
    for n in [2962, 20_389] {
        let s = scene(bench_patch(n));
        let start = dorsum::surface::primitives::bench_path(0.0, 30.0);
        let mut state = free_at(start);
        for i in 0..300 {
            step(
                &s,
                &mut state,
                start - Vec3::Z * (35.0 * f64::from(i) / 299.0),
            );
        }
        for tick in 0..6000 {
            let hip = dorsum::surface::primitives::bench_path(f64::from(tick) / 1000.0, -5.0);
            let c = step(&s, &mut state, hip);
            assert_eq!(c.touch, Touch::Frictionless);
            let lag = (c.anchor_mm - hip).truncate().length();
            assert!(lag <= 3.5, "{n}: {lag} at tick {tick}");
        }
    }
}
