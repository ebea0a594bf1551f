//! The finger never gets through the skin: random motion at any speed over closed, thin, creased and rough surfaces.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::contact::{Contact, ContactState, Friction, Stiffness, Touch, TouchScene, advance};
use dorsum::geom::Vec3;
use dorsum::partition::Partition;
use dorsum::partition::brute::Brute;
use dorsum::partition::bvh::Bvh;
use dorsum::surface::primitives::{bench_height, bench_patch, cuboid, height_field, icosphere};
use dorsum::surface::{RawMesh, Surface};
use std::sync::Arc;

/// A reproducible stream of numbers (SplitMix64).
struct Stream(u64);

impl Stream {
    /// In −1…1.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit())
    }
}

fn scene(mesh: RawMesh, friction: bool) -> TouchScene {
    let (surface, _) = Surface::new(mesh).unwrap();
    let search = Arc::new(Bvh::new(&surface));
    TouchScene {
        friction: friction.then_some(Friction {
            static_coefficient: 0.46,
            dynamic_coefficient: 0.44,
            skin_looseness: 1.0,
        }),
        ..TouchScene::new(Arc::new(surface), search, Stiffness::Uniform(1.0))
    }
}

fn moved(mut mesh: RawMesh, scale: f64, by: Vec3) -> RawMesh {
    for p in &mut mesh.positions {
        *p = *p * scale + by;
    }
    mesh
}

fn free_at(p: Vec3) -> ContactState {
    ContactState {
        proxy_mm: p,
        ..ContactState::default()
    }
}

/// How often the surface winds round `p`: 1 inside a closed surface, 0 outside (van Oosterom & Strackee 1983).
fn winding(surface: &Surface, p: Vec3) -> f64 {
    let mut sum = 0.0;
    for t in 0..surface.triangles().len() as u32 {
        let t = surface.triangle(t);
        let (a, b, c) = (t.a - p, t.b - p, t.c - p);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let over = a.dot(b.cross(c));
        let under = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        sum += 2.0 * libm::atan2(over, under);
    }
    sum / (2.0 * std::f64::consts::TAU)
}

/// What must hold after every tick on a surface of size `size`.
fn sound(surface: &Surface, c: &Contact, hip: Vec3, size: f64, what: &str) {
    assert!(
        c.force_n.is_finite() && c.anchor_mm.is_finite() && c.foot_mm.is_finite(),
        "{what}"
    );
    if c.touch == Touch::Free {
        assert_eq!(c.anchor_mm, hip);
        return;
    }
    let on = surface
        .triangle(c.triangle)
        .closest_point(c.anchor_mm)
        .point;
    assert!(
        on.distance(c.anchor_mm) <= 1e-11 * size,
        "{what}: the proxy has left its triangle"
    );
    assert!(
        (c.normal.length() - 1.0).abs() < 1e-9 && c.depth_mm >= 0.0,
        "{what}"
    );
}

/// Random wandering: mostly small steps, now and then a dash, drawn towards `home`.
fn wander(s: &mut Stream, at: Vec3, home: Vec3, speed_mm_per_tick: f64) -> Vec3 {
    let dash = if s.unit() > 0.6 { 1.0 } else { 0.1 };
    at + s.vector() * (speed_mm_per_tick * dash) + (home - at) * 0.01
}

#[test]
fn on_a_bumpy_closed_mesh_a_free_finger_is_outside() {
    for (seed, friction) in [(1, false), (2, true), (3, false)] {
        let mut s = Stream(seed);
        let mut mesh = icosphere(20.0, 3);
        for p in &mut mesh.positions {
            *p *= 1.0 + 0.12 * s.unit();
        }
        let scene = scene(mesh, friction);
        let mut hip = Vec3::new(0.0, 0.0, 30.0);
        let mut state = free_at(hip);
        let mut touched = 0;
        for tick in 0..6000 {
            hip = wander(&mut s, hip, hip * (19.0 / hip.length().max(1.0)), 5.0);
            let c = advance(&scene, &mut state, hip);
            let what = format!("seed {seed}, tick {tick}, {hip}");
            sound(&scene.surface, &c, hip, 20.0, &what);
            touched += usize::from(c.touch != Touch::Free);
            if c.touch == Touch::Free {
                let near = Brute.nearest(&scene.surface, hip, 1e-9).is_some();
                assert!(
                    near || winding(&scene.surface, hip) < 0.5,
                    "{what}: inside and free"
                );
            }
        }
        assert!((1000..5900).contains(&touched), "{touched}");
    }
}

#[test]
fn scale_and_place_do_not_change_what_stops_the_finger() {
    // The same motion over the same mesh, in metres, in micrometres, a kilometre away.
    let wave = |x: f64, y: f64| libm::sin(x) * libm::cos(1.3 * y) + 0.3 * libm::sin(3.0 * x + y);
    let mesh = height_field([-8.0, 8.0], [-8.0, 8.0], [40, 40], 3200, wave);
    let offsets = [Vec3::ZERO, Vec3::new(1e6, -2e6, 5e5)];
    for (scale, by) in [(1.0, 0), (1e-3, 0), (1e3, 0), (1.0, 1), (0.25, 1)] {
        let by = offsets[by];
        let scene = scene(moved(mesh.clone(), scale, by), false);
        let mut s = Stream(11);
        let mut at = Vec3::new(0.0, 0.0, 4.0);
        let mut state = free_at(at * scale + by);
        for tick in 0..4000 {
            at = wander(&mut s, at, Vec3::new(0.0, 0.0, -0.5), 3.0);
            at = at.clamp(Vec3::new(-6.0, -6.0, -5.0), Vec3::new(6.0, 6.0, 5.0));
            let hip = at * scale + by;
            let c = advance(&scene, &mut state, hip);
            let what = format!("scale {scale}, at {by}, tick {tick}");
            sound(
                &scene.surface,
                &c,
                hip,
                8.0 * scale + 1e3 * by.length() * 1e-2,
                &what,
            );
            if c.touch == Touch::Free {
                let down = hip - Vec3::Z * (20.0 * scale);
                let up = hip + Vec3::Z * (20.0 * scale);
                let below = Brute.sweep(&scene.surface, up, hip, dorsum::partition::Sides::Both);
                let above = Brute.sweep(&scene.surface, hip, down, dorsum::partition::Sides::Both);
                let near = Brute
                    .nearest(&scene.surface, hip, 1e-9 * (scale + by.length()))
                    .is_some();
                assert!(
                    near || (below.is_none() && above.is_some()),
                    "{what}: through"
                );
            }
        }
    }
}

#[test]
fn on_the_bench_surface_no_finger_gets_through_at_5_m_per_s() {
    for (n, friction) in [(2962, false), (2962, true), (41_582, true)] {
        let scene = scene(bench_patch(n), friction);
        let mut s = Stream(n as u64);
        let mut hip = Vec3::new(0.0, 0.0, bench_height(0.0, 0.0) + 5.0);
        let mut state = free_at(hip);
        for tick in 0..20_000 {
            let home = Vec3::new(hip.x * 0.9, hip.y * 0.9, bench_height(hip.x, hip.y) - 3.0);
            hip = wander(&mut s, hip, home, 5.0);
            hip.x = hip.x.clamp(-150.0, 150.0);
            hip.y = hip.y.clamp(-180.0, 180.0);
            let c = advance(&scene, &mut state, hip);
            let what = format!("{n}, friction {friction}, tick {tick}, {hip}");
            sound(&scene.surface, &c, hip, 300.0, &what);
            let depth = bench_height(hip.x, hip.y) - hip.z;
            // Chords of the coarse mesh cut up to 0.8 mm off the formula.
            if depth > 1.0 {
                assert_ne!(c.touch, Touch::Free, "{what}: {depth} deep and free");
            }
            if c.touch != Touch::Free {
                let lag = (c.anchor_mm - hip).length();
                assert!(
                    lag < 2.0 * depth.max(0.0) + 3.0,
                    "{what}: {lag} behind, {depth} deep"
                );
            }
        }
    }
}

#[test]
fn a_thin_double_sheet_is_one_wall() {
    for thickness in [0.1, 1e-3] {
        for friction in [false, true] {
            // Bumpy, closed all round, 80 mm wide; the finger stays over the middle and goes 15 mm deep.
            let bump = |x: f64, y: f64| libm::sin(0.7 * x) * libm::sin(0.6 * y);
            let top = height_field([-40.0, 40.0], [-40.0, 40.0], [60, 60], 7200, bump);
            let n = top.positions.len() as u32;
            let mut mesh = top.clone();
            mesh.positions
                .extend(top.positions.iter().map(|p| *p - Vec3::Z * thickness));
            mesh.triangles
                .extend(top.triangles.iter().map(|t| [t[0] + n, t[2] + n, t[1] + n]));
            let at = |i: u32, j: u32| j * 61 + i;
            for i in 0..60 {
                for (a, b) in [
                    (at(i, 0), at(i + 1, 0)),
                    (at(i + 1, 60), at(i, 60)),
                    (at(0, i + 1), at(0, i)),
                    (at(60, i), at(60, i + 1)),
                ] {
                    mesh.triangles.extend([[b, a, a + n], [b, a + n, b + n]]);
                }
            }
            let scene = scene(mesh, friction);
            let mut s = Stream(5);
            let mut hip = Vec3::new(0.0, 0.0, 5.0);
            let mut state = free_at(hip);
            let mut deepest = 0.0_f64;
            for tick in 0..8000 {
                let home = if tick / 500 % 2 == 0 { -8.0 } else { 6.0 };
                hip = wander(&mut s, hip, Vec3::new(0.0, 0.0, home), 5.0);
                hip = hip.clamp(Vec3::new(-20.0, -20.0, -15.0), Vec3::new(20.0, 20.0, 15.0));
                let c = advance(&scene, &mut state, hip);
                let what = format!("{thickness}, tick {tick}, {hip}");
                sound(&scene.surface, &c, hip, 40.0, &what);
                if c.touch == Touch::Free {
                    assert!(hip.z > -1.2, "{what}: free below the sheet");
                } else {
                    assert!(
                        scene.surface.triangle(c.triangle).normal().z > 0.0,
                        "{what}: on the lower side"
                    );
                    deepest = deepest.max(c.depth_mm);
                }
            }
            assert!(deepest > 4.0, "{deepest}");
        }
    }
}

#[test]
fn into_sharp_creases_the_finger_goes_no_deeper_than_their_bottom() {
    // Saw-tooth trenches with walls as steep as 89.4°: wedges of about 1°.
    for height in [5.0, 50.0] {
        let saw = move |x: f64, _: f64| {
            if (x.round() as i64) % 2 == 0 {
                0.0
            } else {
                height
            }
        };
        let mesh = height_field([-10.0, 10.0], [-10.0, 10.0], [20, 7], 280, saw);
        for friction in [false, true] {
            let scene = scene(mesh.clone(), friction);
            let mut s = Stream(17);
            let mut hip = Vec3::new(0.1, 0.0, height + 4.0);
            let mut state = free_at(hip);
            for tick in 0..12_000 {
                let home = if tick / 700 % 2 == 0 {
                    -2.0
                } else {
                    height + 1.0
                };
                hip = wander(&mut s, hip, Vec3::new(0.0, 0.0, home), 5.0);
                hip = hip.clamp(
                    Vec3::new(-8.0, -8.0, -6.0),
                    Vec3::new(8.0, 8.0, height + 6.0),
                );
                let c = advance(&scene, &mut state, hip);
                let what = format!("height {height}, friction {friction}, tick {tick}, {hip}");
                sound(&scene.surface, &c, hip, 50.0, &what);
                if c.touch == Touch::Free {
                    let x = hip.x - 2.0 * (hip.x / 2.0).floor();
                    let surface_z = height * (1.0 - (x - 1.0).abs());
                    assert!(hip.z > surface_z - 1e-9 * height, "{what}: {surface_z}");
                }
            }
        }
    }
}

/// Both meshes in one, not joined.
fn together(mut one: RawMesh, other: RawMesh) -> RawMesh {
    let n = one.positions.len() as u32;
    one.positions.extend(other.positions);
    one.triangles
        .extend(other.triangles.iter().map(|t| t.map(|v| v + n)));
    one
}

#[test]
fn where_bodies_run_into_each_other_the_finger_stays_outside_both() {
    // Two boxes through each other, a post standing on a plate (a T-junction), two boxes side by side in touch.
    let v = Vec3::new;
    let pairs = [
        [
            (v(-10.0, -10.0, -10.0), v(10.0, 10.0, 10.0)),
            (v(-4.0, -15.0, 0.0), v(6.0, 14.0, 16.0)),
        ],
        [
            (v(-15.0, -15.0, -3.0), v(15.0, 15.0, 0.0)),
            (v(-3.0, -4.0, 0.0), v(4.0, 3.0, 12.0)),
        ],
        [
            (v(-10.0, -10.0, -10.0), v(0.0, 10.0, 10.0)),
            (v(0.0, -8.0, -10.0), v(10.0, 8.0, 7.0)),
        ],
        [
            (v(-10.0, -10.0, -10.0), v(10.0, 10.0, 10.0)),
            (v(-3.3, 1.0, 9.0), v(2.0, 5.7, 10.5)),
        ],
    ];
    for (i, boxes) in pairs.into_iter().enumerate() {
        for friction in [false, true] {
            let mesh = together(
                cuboid(boxes[0].0, boxes[0].1),
                cuboid(boxes[1].0, boxes[1].1),
            );
            let scene = scene(mesh, friction);
            let inside = |p: Vec3| {
                let depth = |b: &(Vec3, Vec3)| (p - b.0).min(b.1 - p).min_element();
                depth(&boxes[0]).max(depth(&boxes[1]))
            };
            let mut s = Stream(31 + i as u64);
            let mut hip = v(0.0, 1.0, 20.0);
            let mut state = free_at(hip);
            let mut creased = 0;
            for tick in 0..20_000 {
                let home = if tick / 400 % 3 == 0 { 25.0 } else { 4.0 };
                hip = wander(&mut s, hip, hip * (home / hip.length().max(1.0)), 4.0);
                let c = advance(&scene, &mut state, hip);
                let what = format!("pair {i}, friction {friction}, tick {tick}, {hip}: {c:?}");
                sound(&scene.surface, &c, hip, 20.0, &what);
                let depth = inside(c.anchor_mm);
                assert!(depth < 1e-9, "{what}: proxy {depth} inside");
                let edge = c.normal.abs().max_element() < 0.999;
                creased += usize::from(c.touch != Touch::Free && edge);
            }
            assert!(
                friction || creased > 20,
                "pair {i}: {creased} rests in creases"
            );
        }
    }
}

#[test]
fn one_dash_through_everything_stops_at_the_first_wall() {
    // Far faster than any hand: metres within a tick, through both walls of a box, along the axes and across.
    let scene = scene(cuboid(Vec3::splat(-10.0), Vec3::splat(10.0)), false);
    let mut s = Stream(23);
    for _ in 0..2000 {
        let from = s.vector() * 4000.0;
        let to = s.vector() * 4000.0;
        if from.abs().max_element() < 11.0 {
            continue;
        }
        let mut state = free_at(from);
        let c = advance(&scene, &mut state, to);
        let hit = Brute.sweep(&scene.surface, from, to, dorsum::partition::Sides::Front);
        if to.abs().max_element() < 10.0 {
            assert_ne!(c.touch, Touch::Free, "{from} to {to}");
        }
        if hit.is_none() {
            assert_eq!(c.touch, Touch::Free, "{from} to {to}");
        }
    }
}

#[test]
fn slow_fingers_creep_along_creases_without_leaking() {
    // Speeds down to rounding: 1e-12 mm a tick across the edges and corners of a box, from just outside.
    let scene = scene(cuboid(Vec3::splat(-10.0), Vec3::splat(10.0)), false);
    let mut s = Stream(29);
    for round in 0..400 {
        let pick = |s: &mut Stream| {
            if s.unit() > 0.0 {
                10.0
            } else {
                10.0 * s.unit()
            }
        };
        let on = Vec3::new(10.0, pick(&mut s), pick(&mut s));
        let mut hip = on + Vec3::X * 1e-9;
        let mut state = free_at(hip);
        let speed = 10.0_f64.powi(-(round % 13));
        for tick in 0..40 {
            hip += s.vector() * speed - Vec3::X * (0.3 * speed);
            let c = advance(&scene, &mut state, hip);
            if c.touch == Touch::Free {
                let depth = 10.0 - hip.abs().max_element();
                assert!(
                    depth < 1e-11,
                    "round {round}, tick {tick}: {hip} is {depth} deep and free"
                );
            }
        }
    }
}
