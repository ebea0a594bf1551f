//! The resting frictionless proxy against brute force: the closest point of all triangles where that is unique, a local
//! minimum over everything it touches elsewhere. To 10⁻⁹ mm, however deep the finger.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::contact::{Contact, ContactState, Stiffness, Touch, TouchScene, advance};
use dorsum::geom::Vec3;
use dorsum::partition::Partition;
use dorsum::partition::brute::Brute;
use dorsum::partition::bvh::Bvh;
use dorsum::surface::torture::{Stream, grid, steps};
use dorsum::surface::{RawMesh, Surface};
use proptest::prelude::*;
use std::sync::Arc;

const TOLERANCE_MM: f64 = 1e-9;

fn scene(mesh: RawMesh) -> TouchScene {
    let (surface, _) = Surface::new(mesh).unwrap();
    let search = Arc::new(Bvh::new(&surface));
    TouchScene::new(Arc::new(surface), search, Stiffness::Uniform(1.0))
}

fn above(height_mm: f64) -> ContactState {
    ContactState {
        proxy_mm: Vec3::new(0.1, 0.2, height_mm),
        ..ContactState::default()
    }
}

/// A patch of 40 mm over a grid whose lines are moved at random, so that no two triangles are alike.
fn patch(seed: u64, shape: impl Fn(f64, f64) -> f64) -> RawMesh {
    let mut s = Stream(seed);
    let mut lines = || {
        let mut at = steps(-20.0, 20.0, 16);
        for x in &mut at[1..16] {
            *x += s.unit();
        }
        at
    };
    let (xs, ys) = (lines(), lines());
    grid(&xs, &ys, shape)
}

/// How much closer to `hip` than the proxy any point of the triangles that it touches is, mm: those of its own vertices,
/// edges and faces, found by looking at all triangles.
fn closer_nearby(scene: &TouchScene, c: &Contact, hip: Vec3) -> f64 {
    let reach = c.anchor_mm.distance(hip);
    let surface = &scene.surface;
    (0..surface.triangles().len() as u32)
        .map(|t| surface.triangle(t))
        .filter(|t| t.closest_point(c.anchor_mm).point.distance(c.anchor_mm) < 1e-11)
        .map(|t| reach - t.closest_point(hip).point.distance(hip))
        .fold(0.0, f64::max)
}

/// A way of the finger: where to, and how many ticks of equal size it takes.
fn way() -> impl Strategy<Value = Vec<([f64; 3], u32)>> {
    let depth = prop_oneof![-1e-6..0.5_f64, -3.0..3.0, -200.0..1.0];
    prop::collection::vec(
        (
            (-9.0..9.0_f64, -9.0..9.0_f64, depth),
            prop_oneof![Just(1_u32), 2..40_u32],
        ),
        8,
    )
    .prop_map(|w| w.into_iter().map(|((x, y, z), n)| ([x, y, z], n)).collect())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

    /// In a trough the free space is convex: however the finger went, the proxy is the one closest point. The trough follows
    /// twelve tangents of a parabola and is tilted, so that no two of its faces are alike.
    #[test]
    fn in_a_trough_the_proxy_is_the_closest_point_of_all(seed in 0_u64..1 << 40, way in way()) {
        let mut s = Stream(seed);
        let tangents: Vec<(f64, f64)> = (0..12)
            .map(|_| {
                let x = 20.0 * s.unit();
                (x / 25.0, -x * x / 50.0)
            })
            .collect();
        let slope = |x: f64| tangents.iter().map(|p| p.0 * x + p.1).fold(f64::MIN, f64::max);
        let xs = steps(-30.0, 30.0, 240);
        let zs: Vec<f64> = xs.iter().map(|&x| slope(x)).collect();
        let lower_hull = |x: f64| {
            let i = xs.partition_point(|&at| at < x).clamp(1, xs.len() - 1);
            let share = (x - xs[i - 1]) / (xs[i] - xs[i - 1]);
            zs[i - 1] + (zs[i] - zs[i - 1]) * share
        };
        let scene = scene(grid(&xs, &steps(-30.0, 30.0, 5), |x, y| lower_hull(x) + 0.3 * y));
        let mut state = above(40.0);
        let mut at = state.proxy_mm;
        for (to, ticks) in way {
            let to = Vec3::from_array(to) + Vec3::Z * (0.3 * to[1] + lower_hull(to[0]));
            let by = (to - at) / f64::from(ticks);
            for _ in 0..ticks {
                at += by;
                let c = advance(&scene, &mut state, at);
                if c.touch == Touch::Free || c.anchor_mm.abs().max_element() > 29.0 {
                    continue;
                }
                let closest = Brute.nearest(&scene.surface, at, f64::INFINITY).unwrap();
                let far = closest.point.abs().max_element() > 29.0;
                prop_assert!(far || c.anchor_mm.distance(closest.point) < TOLERANCE_MM, "{at}: {} for {}", c.anchor_mm, closest.point);
            }
        }
    }

    /// On domes, saddles, creases and rough ground several places may be closest for a while: the proxy is in one from which
    /// no way on the surface leads closer, and it came there without ever going away from the finger.
    #[test]
    fn elsewhere_no_way_on_the_surface_leads_closer(seed in 0_u64..1 << 40, kind in 0..4, way in way()) {
        let a = (seed % 97) as f64;
        let shape = move |x: f64, y: f64| match kind {
            0 => -(x * x + y * y) / 40.0,
            1 => (x * x - y * y) / 30.0 + 0.1 * libm::sin(5.0 * x + a),
            2 => -1.7 * (x + 0.3 * y).abs() + 0.8 * (y - 2.0).abs(),
            _ => 2.0 * libm::sin(0.9 * x + a) * libm::sin(1.1 * y - a) + 0.4 * libm::sin(4.0 * x * y),
        };
        let scene = scene(patch(seed, shape));
        let mut state = above(60.0);
        let mut at = state.proxy_mm;
        for (to, ticks) in way {
            let to = Vec3::from_array(to) + Vec3::Z * shape(to[0], to[1]);
            let by = (to - at) / f64::from(ticks);
            for _ in 0..ticks {
                at += by;
                let before = state.proxy_mm;
                let c = advance(&scene, &mut state, at);
                prop_assert!(c.anchor_mm.distance(at) <= before.distance(at) * (1.0 + 1e-12) + 1e-12);
                // How a finger slides off the rim is another question.
                let inner = c.anchor_mm.truncate().abs().max_element() < 19.5;
                if c.touch != Touch::Free && inner {
                    let closer = closer_nearby(&scene, &c, at);
                    prop_assert!(closer < TOLERANCE_MM, "{at}: {} could be {closer} closer", c.anchor_mm);
                    prop_assert!((c.force_n - (c.anchor_mm - at)).length() < TOLERANCE_MM);
                }
            }
        }
    }

    /// Doubling is exact in floating point: the same path over the same surface, 2ⁿ times as large, gives the same bits.
    #[test]
    fn a_power_of_two_changes_no_bit(seed in 0_u64..1 << 40, power in -40_i32..17, way in way()) {
        let scale = libm::exp2(f64::from(power));
        let mesh = patch(seed, |x, y| libm::sin(x) * libm::cos(1.3 * y) + 0.3 * libm::sin(3.0 * x + y));
        let mut large = mesh.clone();
        large.positions.iter_mut().for_each(|p| *p *= scale);
        let (one, two) = (scene(mesh), scene(large));
        let mut states = [above(5.0), above(5.0)];
        states[1].proxy_mm *= scale;
        for (to, _) in way {
            let hip = Vec3::from_array(to);
            let a = advance(&one, &mut states[0], hip);
            let b = advance(&two, &mut states[1], hip * scale);
            prop_assert_eq!((a.touch, a.triangle), (b.touch, b.triangle));
            prop_assert_eq!((a.anchor_mm * scale, a.depth_mm * scale), (b.anchor_mm, b.depth_mm));
            prop_assert_eq!((a.force_n * scale, a.normal), (b.force_n, b.normal));
        }
    }
}
