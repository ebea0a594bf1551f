//! The contact engine on surfaces that break contact engines, at every speed, size and place. The whole, with more ticks and
//! the cost of each, is `dorsum lab contact-torture`.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::contact::{Contact, ContactState, Friction, Stiffness, Touch, TouchScene, advance};
use dorsum::geom::Vec3;
use dorsum::lab::contact::{ENGINES, PLACES, SPEEDS_M_PER_S, Trial, closed_path_energy};
use dorsum::partition::Sides;
use dorsum::partition::bvh::Bvh;
use dorsum::surface::torture::{
    Stream, Truth, all, band_place, closest_in, grid, steps, twisted_band,
};
use dorsum::surface::{Defect, Report, Surface};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Every surface, engine, speed and place with and without friction: the proxy is on the right side, is the closest point
/// where the free space is convex, is in a local minimum elsewhere, its pull is in the cone, and nothing comes from nothing.
#[test]
fn no_surface_breaks_the_proxy() {
    for engine in ENGINES.iter().filter(|e| e.must_pass) {
        for case in all(1) {
            let mut touched = 0;
            for &place in PLACES {
                for friction in [false, true] {
                    let trial = Trial::new(&case, engine, place, friction).unwrap();
                    for speed in SPEEDS_M_PER_S {
                        let found = trial.run(&trial.path(speed, 1500));
                        let what = format!(
                            "{} on {}, {speed} m/s, {}, friction {friction}",
                            engine.name, case.name, place.name
                        );
                        assert_eq!(found.faults(), 0, "{what}: {found:?}");
                        touched += found.touched;
                    }
                }
            }
            assert!(touched > 1000, "{}: {touched}", case.name);
        }
    }
}

/// Round the closed path no energy comes from nothing, and where the free space is convex none is lost either: the force is
/// the gradient of half the squared distance.
#[test]
fn over_a_closed_path_no_energy_comes_from_nothing() {
    for engine in ENGINES.iter().filter(|e| e.must_pass) {
        for case in all(2) {
            let e = closed_path_energy(&case, engine, 0.7, 600).unwrap();
            assert!(e.work > 1.0, "{}: {e:?}", case.name);
            assert!(e.created <= 1e-9 * e.work, "{}: {e:?}", case.name);
            if matches!(case.truth, Truth::Cell(_)) {
                assert!(e.lost <= 1e-9 * e.work, "{}: {e:?}", case.name);
            }
        }
    }
}

/// Round both sides of a strip that has only one: the finger follows it twice round, pressing all the while.
fn twice_round(scene: &TouchScene, depth_mm: f64, step: f64) -> (usize, usize, f64) {
    let at = |angle: f64| {
        let [centre, across, normal] = band_place(30.0, 1, angle);
        centre + across * 1.3 - normal * depth_mm
    };
    let above = |angle: f64| {
        let [centre, across, normal] = band_place(30.0, 1, angle);
        centre + across * 1.3 + normal * 3.0
    };
    let mut state = ContactState {
        proxy_mm: above(0.3),
        ..ContactState::default()
    };
    let (mut free, mut turns, mut lag) = (0, 0, 0.0_f64);
    let n = (2.0 * TAU * 30.0 / step) as usize;
    for i in 0..=n {
        let hip = at(0.3 + 2.0 * TAU * i as f64 / n as f64);
        let before = state.behind;
        let c = advance(scene, &mut state, hip);
        free += usize::from(c.touch == Touch::Free);
        turns += usize::from(i > 0 && c.touch != Touch::Free && before != c.behind);
        lag = lag.max(c.anchor_mm.distance(hip));
        assert!((c.force_n - (c.anchor_mm - hip)).length() < 1e-9);
    }
    (free, turns, lag)
}

fn moebius(sides: Sides) -> (TouchScene, Report) {
    let mesh = twisted_band(30.0, 12.0, 1, 120);
    let (surface, report) = Surface::new(mesh).unwrap();
    let search = Arc::new(Bvh::new(&surface));
    let mut scene = TouchScene::new(Arc::new(surface), search, Stiffness::Uniform(1.0));
    scene.choices.sides = sides;
    (scene, report)
}

/// Validation cuts a Möbius strip across and says so. From the front the finger falls through where the cut turns it over;
/// with both sides felt it goes round and round, on the back every other time.
#[test]
fn a_moebius_strip_is_cut_and_felt_all_the_way_round_from_both_sides() {
    let (front, report) = moebius(Sides::Front);
    let cut = |d: &Defect| matches!(d, Defect::NonOrientable(found) if found.count > 0);
    assert!(report.defects.iter().any(cut), "{:?}", report.defects);
    assert_eq!(front.surface.check(), Ok(()));
    let (free, turns, _) = twice_round(&front, 2.0, 0.1);
    assert!(free > 1000 && turns == 0, "{free} {turns}");

    let (both, _) = moebius(Sides::Both);
    for step in [0.01, 0.1, 1.0, 10.0] {
        let (free, turns, lag) = twice_round(&both, 2.0, step);
        // Facets of 3 degrees on a radius of 30 mm are 0.1 mm off the formula; corners of the path cut in 0.1 mm more.
        assert_eq!((free, turns), (0, 2), "{step}");
        assert!(lag < 2.0 + 0.02 * step * step + 0.4, "{step}: {lag}");
    }
}

/// A plate from below: pressed, followed, left over the rim, and come round to the other side.
#[test]
fn an_open_sheet_is_felt_from_behind_and_left_round_its_rim() {
    let at = steps(-10.0, 10.0, 7);
    let (surface, _) = Surface::new(grid(&at, &at, |_, _| 0.0)).unwrap();
    let search = Arc::new(Bvh::new(&surface));
    let mut scene = TouchScene::new(Arc::new(surface), search, Stiffness::Uniform(0.5));
    scene.choices.sides = Sides::Both;
    let mut state = ContactState {
        proxy_mm: Vec3::new(1.0, 2.0, -3.0),
        ..ContactState::default()
    };
    let mut go = |x: f64, z: f64| advance(&scene, &mut state, Vec3::new(x, 2.0, z));
    let c = go(1.0, 4.0);
    assert!(c.behind && c.normal == -Vec3::Z && (c.depth_mm - 4.0).abs() < 1e-12);
    assert!((c.force_n + Vec3::Z * 2.0).length() < 1e-12);
    assert_eq!(c.anchor_mm, Vec3::new(1.0, 2.0, 0.0));
    // On the sheet itself: held without force, on the side it came from; and let go there.
    let c = go(3.0, 0.0);
    assert!(c.behind && c.force_n == Vec3::ZERO && c.touch == Touch::Frictionless);
    assert!(go(3.0, 1e-9).behind);
    assert_eq!(go(3.0, -1e-9).touch, Touch::Free);
    assert!(go(3.0, 2.0).behind);
    assert!(go(9.9, 2.0).behind);
    assert_eq!(go(10.1, 2.0).touch, Touch::Free);
    // Round the rim to the front.
    assert_eq!(go(9.0, 2.0).touch, Touch::Free);
    let c = go(9.0, -1.5);
    assert!(!c.behind && c.normal == Vec3::Z && (c.depth_mm - 1.5).abs() < 1e-12);
    assert_eq!(go(10.1, -1.5).touch, Touch::Free);
    assert_eq!(go(9.0, -1.5).touch, Touch::Free);
    assert!(go(9.0, 1.5).behind);
}

/// Two open sheets 0.1 mm apart, felt from both sides: the finger between them stays between them.
#[test]
fn between_two_sheets_the_finger_is_kept_by_both() {
    let case = all(1)
        .into_iter()
        .find(|c| c.name == "two sheets 0.1 mm")
        .unwrap();
    let (surface, _) = Surface::new(case.mesh).unwrap();
    let search = Arc::new(Bvh::new(&surface));
    let mut scene = TouchScene::new(Arc::new(surface), search, Stiffness::Uniform(1.0));
    scene.choices.sides = Sides::Both;
    let mut stream = Stream(3);
    let mut state = ContactState {
        proxy_mm: Vec3::new(0.3, 0.2, -0.05),
        ..ContactState::default()
    };
    for _ in 0..4000 {
        let hip = stream.vector() * Vec3::new(12.0, 12.0, 3.0);
        let c = advance(&scene, &mut state, hip);
        let expected = Vec3::new(hip.x, hip.y, hip.z.clamp(-0.1, 0.0));
        assert!(c.anchor_mm.distance(expected) < 1e-9, "{hip}: {c:?}");
        // Validation turns both to face up, so the upper one is felt on its back.
        assert_eq!(c.behind, hip.z > 0.0);
    }
}

/// Where a valley runs out at a rim, the way ahead off the rim leads back over the sheet: the finger once went to and fro there
/// for ever instead of coming free.
#[test]
fn where_a_valley_runs_out_at_the_rim_the_finger_comes_free() {
    let shape = |x: f64, y: f64| -1.7 * (x + 0.3 * y).abs() + 0.8 * (y - 2.0).abs();
    let at = [-20.0, -17.0, -13.4, -8.2, -2.6, 1.1, 4.0, 9.5, 15.0, 20.0];
    let ys = [
        -20.0,
        -12.0,
        -5.0,
        -1.3,
        1.9765421772848673,
        4.4,
        11.0,
        20.0,
    ];
    let (surface, _) = Surface::new(grid(&at, &ys, shape)).unwrap();
    let search = Arc::new(Bvh::new(&surface));
    let scene = TouchScene::new(Arc::new(surface), search, Stiffness::Uniform(1.0));
    for depth in [60.0, 105.0, 105.01744578377615, 300.0] {
        for x in [0.0, -1.0, 3.0] {
            let mut state = ContactState {
                proxy_mm: Vec3::new(x, 0.0, 30.0),
                ..ContactState::default()
            };
            let hip = Vec3::new(x, 0.0, -depth);
            let c = advance(&scene, &mut state, hip);
            // Either free, or held by the surface: the force is that of the proxy where it is.
            assert!(
                (c.force_n - (c.anchor_mm - hip)).length() < 1e-9,
                "{depth} {x}: {c:?}"
            );
        }
    }
}

/// Where two bodies cross, a finger that both sides stop slides in the crease between them, round the corners of either. It
/// once stood on the very line where the next sheet began and was taken to be behind that.
#[test]
fn along_the_crease_of_crossing_bodies_no_finger_that_both_sides_stop_changes_sides() {
    for seed in 1..5 {
        for case in all(seed) {
            if !["crossing spheres", "boxes in and on a box"].contains(&case.name) {
                continue;
            }
            let (surface, _) = Surface::new(case.mesh.clone()).expect("usable");
            let surface = Arc::new(surface);
            let search = Arc::new(Bvh::new(&surface));
            let mut scene = TouchScene::new(surface, search, Stiffness::Uniform(1.0));
            scene.choices.sides = Sides::Both;
            let mut stream = Stream(seed);
            let inside = &case.path[1..];
            let low = inside.iter().copied().fold(Vec3::INFINITY, Vec3::min);
            let high = inside.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
            let (mut at, mut goal) = (case.path[0], case.path[0]);
            let mut state = ContactState {
                proxy_mm: at,
                ..ContactState::default()
            };
            for tick in 0..3_000 {
                if at == goal {
                    goal = (low + high) / 2.0 + stream.vector() * (high - low) / 2.0;
                }
                let way = goal - at;
                at += way * (1.0 / way.length()).min(1.0);
                if way.length() <= 1.0 {
                    at = goal;
                }
                let contact = advance(&scene, &mut state, at);
                let through_mm = case.truth.depth_mm(contact.anchor_mm);
                let name = case.name;
                assert!(
                    through_mm < 1.0e-8,
                    "{name}, {seed}: {through_mm} mm at {tick}"
                );
            }
        }
    }
}

/// The scene of the torture case called `name`, with what is known of it.
fn scene_of(name: &str, friction: f64, sides: Sides) -> (TouchScene, Truth) {
    let case = all(1).into_iter().find(|c| c.name == name).unwrap();
    let surface = Arc::new(Surface::new(case.mesh).unwrap().0);
    let search = Arc::new(Bvh::new(&surface));
    let mut scene = TouchScene::new(surface, search, Stiffness::Uniform(1.0));
    scene.friction = (friction > 0.0).then_some(Friction {
        static_coefficient: friction,
        dynamic_coefficient: 0.95 * friction,
        skin_looseness: 1.0,
    });
    scene.choices.sides = sides;
    (scene, case.truth)
}

/// Takes a finger that starts free along `path`; nowhere may it be on the inner side of the body.
fn kept_out(scene: &TouchScene, truth: &Truth, path: &[Vec3]) -> Contact {
    let mut state = ContactState {
        proxy_mm: path[0],
        ..ContactState::default()
    };
    let mut last = Contact::default();
    for &hip in path {
        last = advance(scene, &mut state, hip);
        let through_mm = truth.depth_mm(last.anchor_mm);
        assert!(through_mm < 1.0e-9, "{path:?}: {through_mm} mm at {hip}");
    }
    last
}

/// A finger that friction holds on a plate just beside a box on it, and that pulls up into the box, is stopped by the box. The
/// point it left the plate from was once taken a little towards the middle of the triangle, and so within the box.
#[test]
fn a_finger_held_beside_a_wall_does_not_leave_the_plate_within_it() {
    let (scene, truth) = scene_of("boxes in and on a box", 1000.0, Sides::Front);
    for power in 9..14 {
        let beside = -4.0 - 10_f64.powi(-power);
        let path = [
            Vec3::new(0.64, beside, 12.0),
            Vec3::new(0.64, beside, 9.0),
            Vec3::new(-1.2, 3.1, 9.2),
            Vec3::new(-1.1, 2.9, 10.2),
        ];
        let c = kept_out(&scene, &truth, &path);
        assert_eq!(c.normal, -Vec3::Y, "{beside}: {c:?}");
    }
}

/// Down the side of a box to the plate it stands on, round the corner of the box, and on along its next side, under which an
/// edge of the plate runs. That edge once drew a finger that both sides stop onto the very line, and so into the box.
#[test]
fn along_a_wall_on_an_edge_of_its_plate_no_finger_that_both_sides_stop_changes_sides() {
    let (scene, truth) = scene_of("boxes in and on a box", 0.0, Sides::Both);
    for rise in 0..20 {
        let path = [
            Vec3::new(6.2, 3.0, 14.0),
            Vec3::new(3.645285433143578, 4.926836682835077, 5.864523909662462),
            Vec3::new(3.06 - 0.1 * f64::from(rise), 5.47, 6.46),
            Vec3::new(4.0, 5.5, 10.1 + 0.3 * f64::from(rise)),
        ];
        let c = kept_out(&scene, &truth, &path);
        assert_eq!(c.touch, Touch::Free, "{rise}: {c:?}");
    }
}

/// From the bottom of a slot of 0.1° almost along its wall: where the finger leaves one wall, one rounding above it is behind
/// the other. That it comes out of there was once taken for a landing on the back.
#[test]
fn a_finger_that_both_sides_stop_comes_out_of_a_slot_the_way_it_went_in() {
    let tan = libm::tan(0.05_f64.to_radians());
    for friction in [0.0, 1000.0] {
        let (scene, truth) = scene_of("0.1° slot", friction, Sides::Both);
        for power in 1..7 {
            for side in [-1.0, 1.0] {
                let z = 0.27618950580230006;
                let beside = side * tan * z * (1.0 - 10_f64.powi(-power));
                let path = [
                    Vec3::new(0.0, -7.3, 5.0),
                    Vec3::new(-1e-3 * side, -7.2, -0.7),
                    Vec3::new(beside, -7.04, z),
                ];
                let c = kept_out(&scene, &truth, &path);
                assert_eq!(c.touch, Touch::Free, "{friction}, {beside}: {c:?}");
                let path = [&path[..], &[Vec3::new(3.0 * side, -7.0, z)]].concat();
                assert!(!kept_out(&scene, &truth, &path).behind);
            }
        }
    }
}

/// At a corner of the mesh of a wall, where the wall stands on a plate: the way down to a finger within the wall leads along
/// its side, not below it, where the plate is.
#[test]
fn no_finger_slides_in_between_a_wall_and_the_plate_it_stands_on() {
    let (scene, truth) = scene_of("wall on plate", 0.0, Sides::Front);
    let Truth::Cell(cell) = &truth else {
        unreachable!()
    };
    for (along, up) in [(-0.04, 0.08), (0.04, 0.08), (0.0, 0.08), (-0.04, 0.0)] {
        let hip = Vec3::new(4.13, -9.25 + along, up);
        let path = [Vec3::new(-3.0, 0.0, 4.0), Vec3::new(5.0, -9.25, -0.41), hip];
        let c = kept_out(&scene, &truth, &path);
        let expected = closest_in(cell, hip);
        assert!(c.anchor_mm.distance(expected) < 1e-9, "{hip}: {c:?}");
    }
}

/// In the groove of two crossing spheres, where the finger comes out of the one that it stands on and into the other, it is the
/// other that it lands on. It was once put back on the first, which passes through the same place, and through the other.
#[test]
fn out_of_one_of_two_crossing_bodies_a_finger_that_both_sides_stop_lands_on_the_other() {
    for friction in [0.0, 1000.0] {
        let (scene, truth) = scene_of("crossing spheres", friction, Sides::Both);
        for turn in 0..720 {
            let angle = f64::from(turn) * 0.01;
            let round = |x: f64, radius: f64| {
                Vec3::new(x, radius * libm::sin(angle), radius * libm::cos(angle))
            };
            for x in [-3.0, 3.0] {
                let path = [
                    round(0.0, 22.0),
                    round(0.0, 10.0),
                    round(0.3 * x, 9.0),
                    round(x, 8.5),
                    round(1.2 * x, 8.7),
                ];
                let c = kept_out(&scene, &truth, &path);
                let outward = c.anchor_mm - Vec3::X * 10.0_f64.copysign(x);
                assert!(!c.behind && c.normal.dot(outward) > 10.0, "{path:?}: {c:?}");
            }
        }
    }
}
