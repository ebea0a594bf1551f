//! Appendix C: the table, its means against the printed ones, the keys made of them.

use dorsum::geom::Vec2;
use dorsum::maps::appendix::{Force, Means, means, rows, seven_keys, seven_keys_by};
use dorsum::maps::{EllipseKey, EllipseMap, EllipseSettings};
use std::f64::consts::PI;

#[test]
fn every_row_is_there_and_four_are_exchanged() {
    assert_eq!(rows().len(), 40);
    let per_force = |f| rows().iter().filter(|r| r.force == f).count();
    assert_eq!((per_force(Force::Up), per_force(Force::Down)), (25, 15));
    let exchanged: Vec<_> = rows().iter().filter(|r| r.is_exchanged()).collect();
    assert_eq!(exchanged.len(), 4);
    for row in exchanged {
        let ordered = row.ordered();
        assert_eq!(
            (ordered.major_cm, ordered.minor_cm),
            (row.minor_cm, row.major_cm)
        );
        assert_eq!((row.direction_deg - ordered.direction_deg).abs(), 90.0);
        assert_eq!(ordered.ordered(), ordered);
    }
}

#[test]
fn the_printed_means_come_out() {
    let found = means(Means::Printed, Force::Up, None);
    for (m, (major_mm, ratio, deg)) in found.iter().zip([
        (358.0, 1.134, 90.0),
        (298.0, 1.049, 90.0),
        (266.0, 1.231, 180.0),
        (358.0, 1.357, 99.4),
        (284.0, 1.313, 121.0),
    ]) {
        assert_eq!(m.rows, 5);
        assert!((m.major_mm - major_mm).abs() < 1e-9, "P{}", m.point);
        assert!(
            (m.major_over_minor - ratio).abs() <= 0.0005,
            "P{}: {}",
            m.point,
            m.major_over_minor
        );
        assert!(
            (m.angle_rad.to_degrees() - deg).abs() < 1e-9,
            "P{}",
            m.point
        );
    }
}

#[test]
fn directions_as_axes_give_the_axial_means() {
    let found = means(Means::Axial, Force::Up, None);
    let deg: Vec<f64> = found.iter().map(|m| m.angle_rad.to_degrees()).collect();
    for (found, expected) in deg.iter().zip([90.0, 90.0, 0.0, 97.5, 126.0]) {
        assert!((found - expected).abs() < 0.05, "{deg:?}");
    }
    // The row of P2 that is exchanged counts with 28 / 23 instead of 23 / 28.
    assert!((found[1].major_mm - 308.0).abs() < 1e-9);
}

#[test]
fn paired_subjects_differ_between_up_and_down() {
    // METHOD's +6.7, -6.7, -1.7, +1.0, -10.0 cm: up less down, subjects that were pressed both ways.
    let mean = |force, point| {
        let both = |subject| {
            rows()
                .iter()
                .any(|r| r.force == Force::Down && r.point == point && r.subject == subject)
        };
        let majors: Vec<f64> = rows()
            .iter()
            .filter(|r| r.force == force && r.point == point && both(r.subject))
            .map(|r| r.major_cm)
            .collect();
        majors.iter().sum::<f64>() / majors.len() as f64
    };
    for (point, expected) in (1..).zip([6.7, -6.7, -1.7, 1.0, -10.0]) {
        let found = mean(Force::Up, point) - mean(Force::Down, point);
        assert!((found - expected).abs() < 0.05, "P{point}: {found}");
    }
}

#[test]
fn the_seven_keys_lie_where_the_text_puts_them() {
    let keys = seven_keys(Force::Up, None);
    let names: Vec<_> = keys.iter().map(|k| k.name.as_str()).collect();
    assert_eq!(names, ["P1", "P2", "P3", "P4", "P5", "P6", "P7"]);
    let (t5, t10, l2) = (334.9, 214.3, 116.8);
    for (key, (x, y)) in keys.iter().zip([
        (0.0, t5),
        (0.0, t10),
        (0.0, l2),
        (-100.0, 0.5 * (t5 + t10)),
        (-100.0, 0.5 * (t10 + l2)),
        (100.0, 0.5 * (t5 + t10)),
        (100.0, 0.5 * (t10 + l2)),
    ]) {
        assert!(
            key.at.distance(Vec2::new(x, y)) < 0.06,
            "{}: {}",
            key.name,
            key.at
        );
    }
    assert!((keys[0].half_major_mm - 179.0).abs() < 1e-9);
    for (left, right) in [(3, 5), (4, 6)] {
        let (l, r) = (&keys[left], &keys[right]);
        assert_eq!(
            (l.half_major_mm, l.half_minor_mm),
            (r.half_major_mm, r.half_minor_mm)
        );
        assert!((l.angle_rad + r.angle_rad - PI).abs() < 1e-12);
    }
    for by in Means::all() {
        for force in Force::all() {
            for subject in [None, Some(1), Some(3), Some(5), Some(9)] {
                let keys = seven_keys_by(*by, *force, subject);
                let n_rows = means(*by, *force, subject).len();
                assert!(keys.len() >= n_rows);
                EllipseMap::new(keys, EllipseSettings::default()).expect("sound keys");
            }
        }
    }
    assert!(seven_keys(Force::Down, Some(1)).is_empty());
}

#[test]
fn mirroring_twice_is_nothing_and_a_boundary_goes_along() {
    for n in [8, 9, 36] {
        let mut key = EllipseKey::new("k", Vec2::new(-30.0, 7.0), 90.0, 60.0, 0.4);
        // Smooth enough that the mean of neighbours is the value between them to third order.
        let radius = |phi: f64| 80.0 + 5.0 * (phi - 0.3).cos();
        let direction = |i: usize| 2.0 * PI * i as f64 / n as f64;
        key.boundary_mm = Some((0..n).map(|i| radius(direction(i))).collect());
        let m = key.clone().mirrored();
        assert_eq!(m.at, Vec2::new(30.0, 7.0));
        assert!((m.angle_rad - (PI - 0.4)).abs() < 1e-15);
        let within = if n % 2 == 0 {
            1e-9
        } else {
            5.0 * (1.0 - (PI / n as f64).cos()) + 1e-9
        };
        for (i, r) in m.boundary_mm.iter().flatten().enumerate() {
            assert!((r - radius(PI - direction(i))).abs() <= within, "{n} {i}");
        }
        if n % 2 == 0 {
            assert_eq!(m.mirrored().boundary_mm, key.boundary_mm);
        }
    }
}
