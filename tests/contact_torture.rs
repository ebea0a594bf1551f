//! The contact engine on surfaces that break contact engines, at every speed, size and place. The whole, with more ticks and
//! the cost of each, is `dorsum lab contact`.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::lab::contact::{ENGINES, PLACES, SPEEDS_M_PER_S, Trial, closed_path_energy};
use dorsum::surface::torture::all;

/// Every surface, engine, speed and place with and without friction: the proxy is on the right side, is the closest point
/// where the free space is convex, is in a local minimum elsewhere, its pull is in the cone, and nothing comes from nothing.
#[test]
fn no_surface_breaks_the_proxy() {
    for engine in ENGINES {
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
    for engine in ENGINES {
        for case in all(2) {
            let e = closed_path_energy(&case, engine, 0.7, 600).unwrap();
            assert!(e.work > 1.0, "{}: {e:?}", case.name);
            assert!(e.created <= 1e-9 * e.work, "{}: {e:?}", case.name);
            if matches!(case.truth, dorsum::surface::torture::Truth::Cell(_)) {
                assert!(e.lost <= 1e-9 * e.work, "{}: {e:?}", case.name);
            }
        }
    }
}
