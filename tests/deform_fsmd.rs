//! What FSMD promises, on flat, curved and folded skins: METHOD 3 and issue 2.

use dorsum::deform::curve::{Curve, Lookup};
use dorsum::deform::footprint::{Ellipse, Kind, Outline as _, Polar, PrintedEllipse};
use dorsum::deform::models::fsmd::{Fsmd, Settings};
use dorsum::deform::{Displacement, Model, Press, all};
use dorsum::geom::{Triangle, Vec2, Vec3, unit_or};
use dorsum::maps::Oval;
use dorsum::surface::{RawMesh, Surface};
use proptest::prelude::*;
use std::slice::from_ref;

/// A sheet of n × n cells of `cell_mm`, lifted by `height`, centred on the origin.
fn sheet(n: usize, cell_mm: f64, height: impl Fn(f64, f64) -> f64) -> Surface {
    let mut mesh = RawMesh::default();
    let half = n as f64 * cell_mm / 2.0;
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (i as f64 * cell_mm - half, j as f64 * cell_mm - half);
            mesh.positions.push(Vec3::new(x, y, height(x, y)));
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
    Surface::new(mesh).expect("a sound mesh").0
}

fn hill(n: usize, cell_mm: f64) -> Surface {
    sheet(n, cell_mm, |x, y| {
        20.0 * (x / 40.0).cos() + 10.0 * (y / 30.0).sin()
    })
}

/// A press with its anchor on a triangle, pulled by `pull_mm` in the tangent plane.
fn press_on(
    surface: &Surface,
    triangle: u32,
    weights: [f64; 3],
    depth_mm: f64,
    pull_mm: [f64; 2],
) -> Press {
    let t = surface.triangle(triangle);
    let normal = t.normal();
    let u = dorsum::geom::any_tangent(normal);
    let v = normal.cross(u);
    let anchor_mm = t.at(weights);
    Press {
        anchor_mm,
        foot_mm: anchor_mm + u * pull_mm[0] + v * pull_mm[1],
        normal,
        depth_mm,
        triangle,
        ..Press::default()
    }
}

/// The vertex nearest to a place.
fn vertex_at(surface: &Surface, place: Vec3) -> u32 {
    let to = |v: &u32| surface.positions()[*v as usize].distance_squared(place);
    (0..surface.positions().len() as u32)
        .min_by(|a, b| to(a).total_cmp(&to(b)))
        .expect("a vertex")
}

/// The vertex nearest to a place of the map plane, at whatever height.
fn vertex_over(surface: &Surface, x: f64, y: f64) -> u32 {
    let to = |v: &u32| (surface.positions()[*v as usize].truncate() - Vec2::new(x, y)).length();
    (0..surface.positions().len() as u32)
        .min_by(|a, b| to(a).total_cmp(&to(b)))
        .expect("a vertex")
}

/// The same surface somewhere else: every vertex there, by its number here, and every triangle.
fn moved_surface(here: &Surface, to: impl Fn(Vec3) -> Vec3) -> (Surface, Vec<u32>, Vec<u32>) {
    let positions: Vec<Vec3> = here.positions().iter().map(|&p| to(p)).collect();
    let there = Surface::new(RawMesh {
        positions: positions.clone(),
        triangles: here.triangles().to_vec(),
    });
    let there = there.expect("a sound mesh").0;
    let vertices: Vec<u32> = positions.iter().map(|&p| vertex_at(&there, p)).collect();
    let triangle = |corners: &[u32; 3]| {
        let corners = corners.map(|v| vertices[v as usize]);
        let found = there.triangles().iter().position(|c| *c == corners);
        found.expect("the same triangle") as u32
    };
    let triangles = here.triangles().iter().map(triangle).collect();
    (there, vertices, triangles)
}

fn press_at_vertex(surface: &Surface, vertex: u32, depth_mm: f64, pull_mm: [f64; 2]) -> Press {
    let triangle = surface.topology().triangles_of(vertex)[0];
    let corners = surface.triangles()[triangle as usize];
    let weights = corners.map(|c| f64::from(u8::from(c == vertex)));
    press_on(surface, triangle, weights, depth_mm, pull_mm)
}

fn hip(press: &Press) -> Vec3 {
    press.foot_mm - press.normal * press.depth_mm
}

fn deformed(surface: &Surface, settings: Settings, presses: &[Press]) -> Displacement {
    let mut out = Displacement::at_rest(surface);
    Fsmd::new(settings).update(surface, presses, &mut out);
    out
}

fn small() -> Settings {
    Settings {
        half_major_mm: 60.0,
        half_minor_mm: 40.0,
        ..Settings::default()
    }
}

fn offsets(out: &Displacement) -> Vec<Vec3> {
    (0..out.n_vertices() as u32)
        .map(|v| out.offset_mm(v))
        .collect()
}

/// The touched vertices in ascending order.
fn touched(out: &Displacement) -> Vec<u32> {
    let mut touched: Vec<u32> = out.touched().collect();
    touched.sort_unstable();
    touched
}

fn same_bits(a: &Displacement, b: &Displacement) -> bool {
    let bits = |v: &[Vec3]| -> Vec<[u64; 3]> {
        v.iter()
            .map(|p| p.to_array().map(|x| (x + 0.0).to_bits()))
            .collect()
    };
    bits(&offsets(a)) == bits(&offsets(b))
        && bits(&a.to_normals()) == bits(&b.to_normals())
        && a.moved().eq(b.moved())
}

#[test]
fn a_vertex_at_the_anchor_lands_on_the_hip_below_the_caps() {
    let skin = hill(30, 5.0);
    let places = [
        [-75.0, -75.0],
        [0.0, -75.0],
        [0.0, 0.0],
        [25.0, 0.0],
        [-5.0, 35.0],
        [75.0, 75.0],
    ];
    for [x, y] in places {
        let vertex = vertex_over(&skin, x, y);
        for (depth, pull) in [(0.5, [0.0, 0.0]), (4.0, [3.0, -2.0]), (9.9, [12.0, 15.0])] {
            let press = press_at_vertex(&skin, vertex, depth, pull);
            let out = deformed(&skin, small(), from_ref(&press));
            let missed = (out.position(&skin, vertex) - hip(&press)).length();
            assert!(missed < 1e-12, "vertex {vertex}: {missed} mm");
            let finger = out.carried_point(&skin, press.triangle, press.anchor_mm);
            assert!((finger - hip(&press)).length() < 1e-12);
        }
    }
}

#[test]
fn beyond_the_caps_the_drawn_dent_stays_at_10_and_20_mm() {
    let skin = sheet(30, 5.0, |_, _| 0.0);
    let middle = vertex_over(&skin, 0.0, 0.0);
    let press = press_at_vertex(&skin, middle, 25.0, [40.0, 0.0]);
    let out = deformed(&skin, small(), from_ref(&press));
    let offset = out.offset_mm(middle);
    assert!((offset.z + 10.0).abs() < 1e-12);
    assert!((offset.truncate().length() - 20.0).abs() < 1e-12);
}

#[test]
fn every_vertex_moves_by_the_formula() {
    let skin = hill(40, 4.0);
    let settings = Settings {
        angle_rad: 0.7,
        ..small()
    };
    let press = press_at_vertex(&skin, vertex_over(&skin, 0.0, 0.0), 6.0, [5.0, 2.0]);
    let out = deformed(&skin, settings.clone(), from_ref(&press));
    let curve = Curve::gaussian();
    // The sheet nowhere folds back, so that all of it inside an outline hangs together.
    let n = press.normal;
    let map = Vec3::new(0.7_f64.cos(), 0.7_f64.sin(), 0.0);
    let major = unit_or(map - Vec3::Z * (map.dot(n) / n.z), Vec3::ZERO);
    let minor = n.cross(major);
    let scale = 0.10 + 0.30 * 6.0 / 10.0;
    for (v, p) in skin.positions().iter().enumerate() {
        let r = *p - press.anchor_mm;
        let q = ((r.dot(major) / 60.0).powi(2) + (r.dot(minor) / 40.0).powi(2)).sqrt();
        let expected =
            (press.foot_mm - press.anchor_mm) * curve.at(q) - n * 6.0 * curve.at(q / scale);
        let missed = (out.offset_mm(v as u32) - expected).length();
        assert!(missed < 1e-9, "vertex {v} at q {q}: {missed} mm");
    }
}

#[test]
fn every_kind_of_footprint_moves_each_vertex_by_its_own_ratio() {
    let skin = hill(60, 3.0);
    let oval = Oval {
        half_major_mm: 50.0,
        half_minor_mm: 30.0,
        angle_rad: 0.7,
    };
    let radii: Vec<f64> = (0..16).map(|i| 30.0 + 8.0 * f64::from(i % 3)).collect();
    let vertex = vertex_over(&skin, 6.0, -9.0);
    let press = Press {
        oval: Some(oval),
        boundary_mm: Some(radii.as_slice().into()),
        ..press_at_vertex(&skin, vertex, 10.0, [5.0, 2.0])
    };
    let (o, n) = (press.anchor_mm, press.normal);
    let circle = Ellipse::new(o, n, 60.0, 60.0, 0.0).unwrap();
    let ellipse = Ellipse::new(o, n, 50.0, 30.0, 0.7).unwrap();
    let printed = PrintedEllipse::new(o, n, 50.0, 30.0, 0.7).unwrap();
    let polar = Polar::new(o, n, &radii).unwrap();
    let ratio = |kind, p| match kind {
        Kind::Circle => circle.ratio(p),
        Kind::Ellipse => ellipse.ratio(p),
        Kind::EllipsePrinted => printed.ratio(p),
        Kind::Irregular => polar.ratio(p),
    };
    for &footprint in Kind::all() {
        for lookup in [Lookup::Nearest, Lookup::Linear, Lookup::Exact] {
            let settings = Settings {
                footprint,
                curve: Curve::gaussian_printed(130, lookup),
                ..small()
            };
            let curve = settings.curve.clone();
            let out = deformed(&skin, settings, from_ref(&press));
            for (v, &p) in skin.positions().iter().enumerate() {
                let q = ratio(footprint, p);
                let expected = (press.foot_mm - o) * curve.at(q) - n * 10.0 * curve.at(q / 0.4);
                let missed = (out.offset_mm(v as u32) - expected).length();
                // Rounding may take a ratio to the sample beside.
                let step = if lookup == Lookup::Nearest {
                    0.15
                } else {
                    1e-9
                };
                assert!(
                    missed < step,
                    "{footprint:?} {lookup:?} {v} at {q}: {missed} mm"
                );
                assert!(q < 1.0 || out.offset_mm(v as u32) == Vec3::ZERO);
            }
        }
    }
}

#[test]
fn outside_the_footprint_nothing_moves_and_no_normal_turns_bit_for_bit() {
    let skin = hill(40, 4.0);
    let press = press_at_vertex(&skin, vertex_over(&skin, 0.0, 0.0), 9.0, [5.0, 5.0]);
    let out = deformed(&skin, small(), from_ref(&press));
    let mut at_rest = 0;
    for v in 0..skin.positions().len() {
        if (skin.positions()[v] - press.anchor_mm).dot(press.normal) == 0.0 {
            continue;
        }
        let ring = skin.topology().neighbours(v as u32);
        let still = |u: u32| out.offset_mm(u) == Vec3::ZERO;
        let far = (skin.positions()[v] - press.anchor_mm).length() > 120.0;
        assert!(!far || still(v as u32));
        if still(v as u32) && ring.iter().all(|&u| still(u)) {
            at_rest += 1;
            assert_eq!(out.normal(v as u32), skin.normals()[v]);
            assert!(!touched(&out).contains(&(v as u32)));
        }
    }
    assert!(at_rest > 200);
}

#[test]
fn without_friction_the_wide_field_is_neither_computed_nor_seen() {
    let skin = sheet(40, 4.0, |_, _| 0.0);
    let press = press_at_vertex(&skin, vertex_over(&skin, 0.0, 0.0), 5.0, [8.0, 0.0]);
    let settings = Settings {
        tangential: false,
        ..small()
    };
    let out = deformed(&skin, settings.clone(), from_ref(&press));
    assert!(out.n_moved() > 0);
    for v in out.moved() {
        assert_eq!(out.offset_mm(v).truncate().length(), 0.0);
        let r = skin.positions()[v as usize] - press.anchor_mm;
        assert!(r.length() < 60.0 * 0.25);
    }
}

#[test]
fn two_fingers_add_as_vectors_and_then_meet_the_caps() {
    let skin = sheet(40, 4.0, |_, _| 0.0);
    let one = press_at_vertex(&skin, vertex_over(&skin, 0.0, 0.0), 4.0, [3.0, 1.0]);
    let two = press_at_vertex(&skin, vertex_over(&skin, 8.0, 0.0), 3.0, [-1.0, 5.0]);
    let a = deformed(&skin, small(), from_ref(&one));
    let b = deformed(&skin, small(), from_ref(&two));
    let both = deformed(&skin, small(), &[one, two]);
    for v in 0..skin.positions().len() {
        let sum = a.offset_mm(v as u32) + b.offset_mm(v as u32);
        assert!((both.offset_mm(v as u32) - sum).length() < 1e-12);
    }

    let deep = press_at_vertex(&skin, vertex_over(&skin, 0.0, 0.0), 9.0, [15.0, 0.0]);
    let beside = press_at_vertex(&skin, vertex_over(&skin, 4.0, 0.0), 9.0, [15.0, 0.0]);
    let both = deformed(&skin, small(), &[deep, beside]);
    for offset in offsets(&both) {
        assert!(offset.z.abs() <= 10.0 + 1e-12);
        assert!(offset.truncate().length() <= 20.0 + 1e-12);
    }
    let middle = vertex_over(&skin, 0.0, 0.0);
    let offset = both.offset_mm(middle);
    assert!((offset.z + 10.0).abs() < 1e-12 && (offset.truncate().length() - 20.0).abs() < 1e-12);
}

#[test]
fn lifting_the_finger_gives_the_surface_back_bit_for_bit() {
    let skin = hill(30, 5.0);
    let mut model = Fsmd::new(small());
    let mut out = Displacement::at_rest(&skin);
    let press = press_at_vertex(&skin, vertex_over(&skin, 0.0, 0.0), 7.0, [6.0, 3.0]);
    model.update(&skin, from_ref(&press), &mut out);
    let were_drawn = touched(&out);
    model.update(&skin, &[], &mut out);
    assert!(same_bits(&out, &Displacement::at_rest(&skin)));
    assert_eq!(touched(&out), were_drawn);
    model.update(&skin, &[], &mut out);
    assert_eq!(out.n_touched(), 0);
}

#[test]
fn moving_the_whole_scene_moves_the_result_with_it() {
    let skin = hill(30, 5.0);
    let press = press_at_vertex(&skin, vertex_over(&skin, 0.0, 0.0), 7.0, [6.0, 3.0]);
    let beside = press_at_vertex(&skin, vertex_over(&skin, -55.0, 5.0), 3.0, [-2.0, 3.0]);
    let settings = Settings {
        angle_rad: 0.3,
        ..small()
    };
    let here = deformed(&skin, settings.clone(), &[press.clone(), beside.clone()]);
    for (turn, shift) in [
        (0.8_f64, Vec3::new(30.0, -70.0, 11.0)),
        (3.0, Vec3::Z * 200.0),
    ] {
        // The ellipse is given on the map plane, so that it turns with a turn about z.
        let turned = |p: Vec3| {
            let (s, c) = turn.sin_cos();
            Vec3::new(c * p.x - s * p.y, s * p.x + c * p.y, p.z)
        };
        let (moved_skin, vertices, triangles) = moved_surface(&skin, |p| turned(p) + shift);
        let moved = |p: &Press| Press {
            anchor_mm: turned(p.anchor_mm) + shift,
            foot_mm: turned(p.foot_mm) + shift,
            normal: turned(p.normal),
            triangle: triangles[p.triangle as usize],
            ..p.clone()
        };
        let turned_settings = Settings {
            angle_rad: 0.3 + turn,
            ..settings.clone()
        };
        let there = deformed(
            &moved_skin,
            turned_settings,
            &[moved(&press), moved(&beside)],
        );
        for (v, &u) in vertices.iter().enumerate() {
            let (offset, normal) = (there.offset_mm(u), there.normal(u));
            assert!((offset - turned(here.offset_mm(v as u32))).length() < 1e-9);
            assert!((normal - turned(here.normal(v as u32))).length() < 1e-9);
        }
    }
}

#[test]
fn the_basic_circle_moves_with_any_turn_of_the_scene() {
    let skin = hill(30, 5.0);
    let settings = Settings {
        half_minor_mm: 60.0,
        ..small()
    };
    let press = press_at_vertex(&skin, vertex_over(&skin, 0.0, 0.0), 7.0, [6.0, 3.0]);
    let here = deformed(&skin, settings.clone(), from_ref(&press));
    let turn = |p: Vec3| Vec3::new(p.z, p.x, p.y);
    let (lying, vertices, triangles) = moved_surface(&skin, turn);
    let moved = Press {
        anchor_mm: turn(press.anchor_mm),
        foot_mm: turn(press.foot_mm),
        normal: turn(press.normal),
        triangle: triangles[press.triangle as usize],
        ..press.clone()
    };
    let there = deformed(&lying, settings, &[moved]);
    for (v, &u) in vertices.iter().enumerate() {
        let offset = there.offset_mm(u);
        assert!((offset - turn(here.offset_mm(v as u32))).length() < 1e-9);
    }
}

/// Normals by the documented formula over all triangles, written the long way.
fn normals_by_definition(surface: &Surface, out: &Displacement) -> Vec<Vec3> {
    let n = surface.positions().len();
    let (mut at_rest, mut now) = (vec![Vec3::ZERO; n], vec![Vec3::ZERO; n]);
    for corners in surface.triangles() {
        let [a, b, c] = corners.map(|v| out.position(surface, v));
        let [a0, b0, c0] = corners.map(|v| surface.positions()[v as usize]);
        for &v in corners {
            now[v as usize] += Triangle { a, b, c }.area_normal();
            at_rest[v as usize] += Triangle {
                a: a0,
                b: b0,
                c: c0,
            }
            .area_normal();
        }
    }
    (0..n)
        .map(|v| {
            let rest = surface.normals()[v];
            unit_or(rest * at_rest[v].length() + now[v] - at_rest[v], rest)
        })
        .collect()
}

#[test]
fn normals_equal_those_recomputed_over_the_whole_surface() {
    let skin = hill(40, 4.0);
    let press = press_at_vertex(&skin, vertex_over(&skin, 0.0, 0.0), 9.0, [10.0, -5.0]);
    let out = deformed(&skin, small(), from_ref(&press));
    let expected = normals_by_definition(&skin, &out);
    let positions: Vec<Vec3> = (0..skin.positions().len())
        .map(|v| out.position(&skin, v as u32))
        .collect();
    let by_angle = dorsum::surface::vertex_normals(&positions, skin.triangles());
    for v in 0..positions.len() {
        assert!((out.normal(v as u32) - expected[v]).length() < 1e-12);
        assert!((out.normal(v as u32).length() - 1.0).abs() < 1e-12);
        let angle = out.normal(v as u32).angle_between(by_angle[v]).to_degrees();
        assert!(
            angle < 12.0,
            "vertex {v}: {angle}° off the angle-weighted normal"
        );
    }
}

#[test]
fn normals_are_right_round_a_hub_with_hundreds_of_spokes_and_on_the_rim() {
    let spokes = 300_u32;
    let mut mesh = RawMesh::default();
    mesh.positions.push(Vec3::new(0.0, 0.0, 3.0));
    for i in 0..spokes {
        let phi = std::f64::consts::TAU * f64::from(i) / f64::from(spokes);
        mesh.positions
            .push(Vec3::new(20.0 * phi.cos(), 20.0 * phi.sin(), 0.0));
        mesh.triangles.push([0, 1 + i, 1 + (i + 1) % spokes]);
    }
    let skin = Surface::new(mesh).expect("a sound mesh").0;
    for place in [Vec3::Z * 3.0, Vec3::X * 20.0] {
        let vertex = vertex_at(&skin, place);
        let press = press_at_vertex(&skin, vertex, 6.0, [4.0, 1.0]);
        let out = deformed(&skin, small(), from_ref(&press));
        let expected = normals_by_definition(&skin, &out);
        for (drawn, expected) in out.to_normals().iter().zip(&expected) {
            assert!((*drawn - *expected).length() < 1e-12);
        }
    }
}

#[test]
fn shading_starts_from_the_normal_at_rest_without_a_jump() {
    let skin = hill(40, 4.0);
    let press = press_at_vertex(&skin, vertex_over(&skin, 0.0, 0.0), 1e-7, [1e-7, 0.0]);
    let out = deformed(&skin, small(), from_ref(&press));
    assert!(out.n_moved() > 0);
    for v in 0..skin.positions().len() {
        assert!((out.normal(v as u32) - skin.normals()[v]).length() < 1e-6);
    }
}

#[test]
fn the_other_side_of_a_thin_fold_stays() {
    // A strip folded over at x = 0 into two sheets 2 mm apart.
    let n = 40;
    let mut mesh = RawMesh::default();
    for j in 0..=n {
        for i in 0..=2 * n {
            let s = (i as f64 - n as f64) * 3.0;
            let z = if s < 0.0 { 2.0 } else { 0.0 };
            mesh.positions
                .push(Vec3::new(-s.abs(), j as f64 * 3.0, z - s.abs() * 1e-3));
        }
    }
    let at = |i: usize, j: usize| (j * (2 * n + 1) + i) as u32;
    for j in 0..n {
        for i in 0..2 * n {
            mesh.triangles
                .push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            mesh.triangles
                .push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    let skin = Surface::new(mesh).expect("a sound mesh").0;
    let vertex = vertex_at(&skin, Vec3::new(-60.0, 60.0, 2.0));
    let press = press_at_vertex(&skin, vertex, 5.0, [2.0, 0.0]);
    let out = deformed(
        &skin,
        Settings {
            half_major_mm: 30.0,
            half_minor_mm: 30.0,
            ..Settings::default()
        },
        from_ref(&press),
    );
    assert!(out.n_moved() > 100);
    let in_the_upper = |p: Vec3| p.z > 1.0 || p.x == 0.0;
    assert!(
        out.moved()
            .all(|v| in_the_upper(skin.positions()[v as usize]))
    );
}

#[test]
fn settings_that_mean_nothing_move_nothing() {
    let skin = hill(10, 5.0);
    let press = press_at_vertex(&skin, vertex_over(&skin, 0.0, 0.0), 5.0, [2.0, 0.0]);
    for bad in [
        0.0,
        -1.0,
        f64::NAN,
        f64::INFINITY,
        f64::MIN_POSITIVE,
        f64::MAX,
    ] {
        let all_fields: [fn(&mut Settings) -> &mut f64; 7] = [
            |s| &mut s.half_major_mm,
            |s| &mut s.half_minor_mm,
            |s| &mut s.angle_rad,
            |s| &mut s.normal_scale_shallow,
            |s| &mut s.normal_scale_deep,
            |s| &mut s.max_normal_mm,
            |s| &mut s.max_tangential_mm,
        ];
        for field in all_fields {
            let mut settings = small();
            *field(&mut settings) = bad;
            let out = deformed(&skin, settings.clone(), from_ref(&press));
            assert!(offsets(&out).iter().all(|o| o.is_finite()), "{settings:?}");
            assert!(
                out.to_normals().iter().all(|n| n.is_finite()),
                "{settings:?}"
            );
        }
    }
}

/// Any press at all: on the skin, off it, broken.
fn any_press() -> impl Strategy<Value = Press> {
    let number = || {
        prop_oneof![
            8 => -200.0..200.0_f64,
            1 => prop::num::f64::ANY,
            1 => Just(f64::NAN),
            1 => Just(f64::INFINITY),
            1 => Just(1e300),
        ]
    };
    let vector = move || [number(), number(), number()].prop_map(Vec3::from);
    (
        vector(),
        vector(),
        vector(),
        number(),
        prop_oneof![0..900_u32, Just(u32::MAX)],
    )
        .prop_map(|(anchor_mm, foot_mm, normal, depth_mm, triangle)| Press {
            anchor_mm,
            foot_mm,
            normal,
            depth_mm,
            triangle,
            ..Press::default()
        })
}

fn press_on_hill() -> impl Strategy<Value = (u32, [f64; 2], f64, [f64; 2])> {
    (
        0..2592_u32,
        prop::array::uniform2(0.0..0.5_f64),
        0.0..14.0_f64,
        prop_oneof![Just([0.0, 0.0]), prop::array::uniform2(-25.0..25.0_f64)],
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn contract_every_model_stays_finite_and_still_without_presses(
        presses in prop::collection::vec(any_press(), 0..4),
    ) {
        let skin = hill(20, 6.0);
        for (name, make) in all() {
            let mut model = make();
            prop_assert_eq!(model.name(), *name);
            let mut out = Displacement::at_rest(&skin);
            model.update(&skin, &[], &mut out);
            prop_assert!(out.n_touched() == 0 && out.n_moved() == 0);
            model.update(&skin, &presses, &mut out);
            prop_assert!(offsets(&out).iter().all(|o| o.is_finite()));
            prop_assert!(out.to_normals().iter().all(|n| (n.length() - 1.0).abs() < 1e-9));
            let moved: Vec<u32> = out.moved().collect();
            prop_assert_eq!(moved.len(), out.n_moved());
            for (v, offset) in offsets(&out).iter().enumerate() {
                prop_assert_eq!(moved.contains(&(v as u32)), *offset != Vec3::ZERO);
            }
            model.update(&skin, &[], &mut out);
            prop_assert!(same_bits(&out, &Displacement::at_rest(&skin)));
        }
    }

    #[test]
    fn contract_an_update_equals_one_from_scratch_and_lists_exactly_what_changed(
        steps in prop::collection::vec(prop::collection::vec(press_on_hill(), 0..3), 1..8),
    ) {
        let skin = hill(36, 4.0);
        for (_, make) in all() {
            let mut model = make();
            let mut out = Displacement::at_rest(&skin);
            for step in &steps {
                let presses: Vec<Press> = step
                    .iter()
                    .map(|&(t, [u, v], depth, pull)| press_on(&skin, t, [1.0 - u - v, u, v], depth, pull))
                    .collect();
                let before = out.clone();
                model.update(&skin, &presses, &mut out);
                let mut scratch = Displacement::at_rest(&skin);
                make().update(&skin, &presses, &mut scratch);
                prop_assert!(same_bits(&out, &scratch));
                let changed: Vec<u32> = (0..out.n_vertices())
                    .filter(|&v| {
                        out.offset_mm(v as u32) != before.offset_mm(v as u32) || out.normal(v as u32) != before.normal(v as u32)
                    })
                    .map(|v| v as u32)
                    .collect();
                prop_assert_eq!(out.n_touched(), changed.len());
                prop_assert_eq!(touched(&out), changed);
            }
        }
    }
}
