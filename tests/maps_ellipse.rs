//! The ellipse map against the printed figures, its closed forms and its promises.

use dorsum::geom::Vec2;
use dorsum::maps::{EllipseKey, EllipseMap, EllipseSettings, Form, Level};
use std::f64::consts::FRAC_PI_2;

fn circle(name: &str, x: f64, y: f64, radius_mm: f64) -> EllipseKey {
    EllipseKey::new(name, Vec2::new(x, y), radius_mm, radius_mm, FRAC_PI_2)
}

/// The three keys of table 5.1.
fn table_5_1() -> Vec<EllipseKey> {
    vec![
        circle("O1", 0.0, 150.0, 120.0),
        circle("O2", 0.0, 60.0, 120.0),
        circle("O3", 0.0, -30.0, 120.0),
    ]
}

fn settings(effect_radius_mm: f64, form: Form, level: Level) -> EllipseSettings {
    EllipseSettings {
        basic_radius_mm: 90.0,
        effect_radius_mm,
        form,
        level,
        ..EllipseSettings::default()
    }
}

fn map(keys: Vec<EllipseKey>, settings: EllipseSettings) -> EllipseMap {
    EllipseMap::new(keys, settings).expect("a sound map")
}

fn close(found: f64, expected: f64, within: f64) {
    assert!(
        (found - expected).abs() <= within,
        "{found}, not {expected}"
    );
}

#[test]
fn the_published_form_misses_the_keys_by_the_printed_amounts() {
    for (e, level, first, middle) in [
        (200.0, Level::Array, 115.102, 112.204),
        (200.0, Level::Exact, 115.096, 112.197),
        (400.0, Level::Array, 114.056, 115.238),
        (400.0, Level::Exact, 114.045, 115.226),
    ] {
        let m = map(table_5_1(), settings(e, Form::Published, level));
        let at = |y: f64| m.at(Vec2::new(0.0, y)).half_major_mm;
        close(at(150.0), first, 0.0005);
        close(at(60.0), middle, 0.0005);
        close(at(-30.0), first, 0.0005);
    }
}

#[test]
fn the_corrected_form_meets_the_keys_and_the_figures_between_them() {
    for (level, near, far) in [
        (Level::Array, 117.2337, 107.7648),
        (Level::Exact, 117.2573, 107.7784),
    ] {
        for e in [200.0, 400.0] {
            let m = map(table_5_1(), settings(e, Form::Corrected, level));
            for key in table_5_1() {
                assert_eq!(m.at(key.at), key.oval());
            }
        }
        let m = map(table_5_1(), settings(400.0, Form::Corrected, level));
        close(m.at(Vec2::new(0.0, 105.0)).half_major_mm, near, 0.00005);
        close(m.at(Vec2::new(100.0, 60.0)).half_major_mm, far, 0.00005);
    }
}
