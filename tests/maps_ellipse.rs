//! The ellipse map against the printed figures, its closed forms and its promises.

use dorsum::geom::{Vec2, Vec3};
use dorsum::maps::ellipse::{Oval, axial};
use dorsum::maps::printed::{self, figures, table_5_1};
use dorsum::maps::{AngleRule, EllipseKey, EllipseMap, EllipseSettings, Form, Level, MapError};
use dorsum::surface::{RawMesh, Surface};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

fn key(x: f64, y: f64, half_major_mm: f64, half_minor_mm: f64, angle_deg: f64) -> EllipseKey {
    let angle_rad = angle_deg.to_radians();
    EllipseKey::new("", Vec2::new(x, y), half_major_mm, half_minor_mm, angle_rad)
}

fn map(keys: &[EllipseKey], settings: EllipseSettings) -> EllipseMap {
    EllipseMap::new(keys.to_vec(), settings).expect("a sound map")
}

fn default_map(keys: &[EllipseKey]) -> EllipseMap {
    map(keys, EllipseSettings::default())
}

/// Every choice of form, angle and level.
fn all_settings() -> Vec<EllipseSettings> {
    let mut all = Vec::new();
    for form in Form::all() {
        for angle in AngleRule::all() {
            for level in Level::all() {
                all.push(EllipseSettings {
                    form: *form,
                    angle: *angle,
                    level: *level,
                    ..EllipseSettings::default()
                });
            }
        }
    }
    all
}

/// What is drawn: half axes as a symmetric tensor, mm. Continuous where the ellipse is.
fn shape(oval: Oval) -> [f64; 3] {
    let d = oval.anisotropy() * oval.half_major_mm;
    [oval.half_major_mm, d.x, d.y]
}

fn apart(a: Oval, b: Oval) -> f64 {
    let (a, b) = (shape(a), shape(b));
    (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max)
}

#[test]
fn both_forms_give_the_figures_of_the_worked_example() {
    for f in figures() {
        assert!(f.holds(), "{f:?} gives {:?}", f.found_mm());
    }
    assert_eq!(
        figures()
            .iter()
            .filter(|f| f.form == Form::Published)
            .count(),
        12
    );
}

#[test]
fn the_weights_are_those_of_eq_5_16_and_5_7_with_their_products() {
    let keys = [
        key(0.0, 150.0, 150.0, 120.0, 30.0),
        key(40.0, 60.0, 110.0, 100.0, 100.0),
        key(-70.0, -30.0, 180.0, 90.0, 150.0),
        key(300.0, 300.0, 60.0, 50.0, 20.0),
    ];
    let base = printed::settings(300.0, Form::Corrected, Level::Exact);
    for p in [
        Vec2::new(10.0, 20.0),
        Vec2::new(-33.0, 77.0),
        Vec2::new(90.0, 140.0),
    ] {
        let levels: Vec<f64> = keys
            .iter()
            .map(|k| {
                let q = k.at.distance(p) / 300.0;
                if q > 1.0 {
                    0.0
                } else {
                    (-PI * (1.4 * q).powi(2)).exp()
                }
            })
            .collect();
        for form in Form::all() {
            let weight = |i: usize| match form {
                Form::Published => levels[i],
                Form::Corrected => {
                    let others = (0..4).filter(|j| *j != i).map(|j| 1.0 - levels[j]);
                    levels[i] * others.product::<f64>()
                }
            };
            let blend = |ground: f64, value: fn(&EllipseKey) -> f64| {
                let sum: f64 = (0..4).map(weight).sum();
                let of = |i: usize| ground * (1.0 - levels[i]) + value(&keys[i]) * levels[i];
                (0..4).map(|i| weight(i) * of(i)).sum::<f64>() / sum
            };
            let linear = EllipseSettings {
                form: *form,
                angle: AngleRule::Linear,
                ..base
            };
            let oval = map(&keys, linear).at(p);
            let expected = [
                blend(90.0, |k| k.half_major_mm),
                blend(1.0, |k| k.half_major_mm / k.half_minor_mm),
                blend(FRAC_PI_2, |k| k.angle_rad),
            ];
            let found = [oval.half_major_mm, oval.major_over_minor(), oval.angle_rad];
            for (f, e) in found.iter().zip(expected) {
                assert!(
                    (f - e).abs() < 1e-9 * e.abs(),
                    "{} {p}: {found:?} {expected:?}",
                    form.name()
                );
            }
            let tensor = map(
                &keys,
                EllipseSettings {
                    form: *form,
                    ..base
                },
            )
            .at(p);
            let c = blend(0.0, |k| {
                (k.half_major_mm / k.half_minor_mm - 1.0) * (2.0 * k.angle_rad).cos()
            });
            let s = blend(0.0, |k| {
                (k.half_major_mm / k.half_minor_mm - 1.0) * (2.0 * k.angle_rad).sin()
            });
            assert!((tensor.major_over_minor() - 1.0 - c.hypot(s)).abs() < 1e-12);
            assert!((tensor.angle_rad - axial(0.5 * s.atan2(c))).abs() < 1e-12);
        }
    }
}

#[test]
fn without_a_key_in_range_there_is_the_basic_circle() {
    let circle = Oval {
        half_major_mm: 140.0,
        half_minor_mm: 140.0,
        angle_rad: FRAC_PI_2,
    };
    for settings in all_settings() {
        let none = map(&[], settings);
        assert!(none.is_circle());
        assert_eq!(none.at(Vec2::new(3.0, 4.0)), circle);
        let one = map(&[key(0.0, 0.0, 180.0, 120.0, 20.0)], settings);
        assert!(!one.is_circle());
        assert_eq!(one.at(Vec2::new(200.1, 0.0)), circle);
        assert_eq!(one.boundary_at(Vec2::ZERO), None);
        assert!(map(&[key(5.0, 5.0, 140.0, 140.0, 0.0)], settings).is_circle());
    }
}

#[test]
fn an_axis_stated_as_0_or_180_is_the_same_by_the_tensor_rule() {
    let keys = |turn: f64| {
        [
            key(0.0, 0.0, 170.0, 120.0, 0.0 + turn),
            key(90.0, 20.0, 150.0, 100.0, 35.0 - turn),
        ]
    };
    let (a, b) = (default_map(&keys(0.0)), default_map(&keys(180.0)));
    for i in 0..200 {
        let p = Vec2::new(
            f64::from(i % 20) * 17.0 - 150.0,
            f64::from(i / 20) * 21.0 - 90.0,
        );
        assert!(apart(a.at(p), b.at(p)) < 1e-9, "{p}");
    }
}

#[test]
fn directions_of_5_and_175_degrees_meet_at_0_and_as_published_at_90() {
    let keys = [
        key(-50.0, 0.0, 160.0, 120.0, 5.0),
        key(50.0, 0.0, 160.0, 120.0, 175.0),
    ];
    let tensor = default_map(&keys).at(Vec2::ZERO);
    assert!(
        tensor.angle_rad.min(PI - tensor.angle_rad) < 1e-12,
        "{tensor:?}"
    );
    let published = map(&keys, EllipseSettings::default().published()).at(Vec2::ZERO);
    assert!((published.angle_rad.to_degrees() - 90.0).abs() < 1e-9);
    assert!((published.major_over_minor() - tensor.major_over_minor()).abs() < 0.01);
}

#[test]
fn directions_that_cancel_make_a_circle_and_no_jump() {
    let keys = [
        key(-50.0, 0.0, 160.0, 120.0, 0.0),
        key(50.0, 0.0, 160.0, 120.0, 90.0),
    ];
    let m = default_map(&keys);
    let middle = m.at(Vec2::ZERO);
    assert!((middle.major_over_minor() - 1.0).abs() < 1e-12);
    for step in [1e-9, 1e-6, 1e-3] {
        let (left, right) = (m.at(Vec2::new(-step, 0.0)), m.at(Vec2::new(step, 0.0)));
        // The weights go as 1/d², so the share of one key falls by 4 % per mm, of 53 mm of anisotropy.
        assert!(apart(left, right) < 10.0 * step);
        assert!(left.angle_rad.is_finite() && right.angle_rad.is_finite());
    }
    let opposed = [
        key(0.0, 0.0, 160.0, 120.0, 0.0),
        key(0.0, 50.0, 140.0, 140.0, 13.0),
    ];
    assert_eq!(default_map(&opposed).at(opposed[1].at).half_minor_mm, 140.0);
}

#[test]
fn a_micrometre_beside_a_key_is_the_key_and_a_little_more_nearly_so() {
    let keys = [
        key(0.0, 0.0, 170.0, 110.0, 40.0),
        key(30.0, 10.0, 100.0, 90.0, 120.0),
        key(-20.0, 60.0, 200.0, 150.0, 90.0),
    ];
    let m = default_map(&keys);
    for k in &keys {
        for i in 0..16 {
            let direction = Vec2::from_angle(f64::from(i) * 0.4);
            assert_eq!(m.at(k.at + direction * 0.9e-3), k.oval());
            for mm in [1.1e-3, 2e-3, 1e-2] {
                // Another key d away has a share of (mm / d)², here at most mm² / 1000, of 300 mm.
                assert!(apart(m.at(k.at + direction * mm), k.oval()) < mm * mm);
            }
        }
    }
    // As printed, the nearest of 700 samples: within 0.14 mm of a key that key alone.
    let printed = map(
        &keys,
        EllipseSettings {
            level: Level::Array,
            ..EllipseSettings::default()
        },
    );
    assert_eq!(printed.at(Vec2::new(0.1, 0.0)), keys[0].oval());
    assert_ne!(printed.at(Vec2::new(0.2, 0.0)), keys[0].oval());
}

#[test]
fn thousands_of_keys_neither_underflow_nor_miss() {
    let keys: Vec<EllipseKey> = (0..5000)
        .map(|i| {
            let (column, row) = (i % 71, i / 71);
            let at = [f64::from(column) * 5.0 - 175.0, f64::from(row) * 6.0];
            key(
                at[0],
                at[1],
                100.0 + f64::from(i % 97),
                80.0,
                f64::from(i % 180),
            )
        })
        .collect();
    for settings in all_settings() {
        let m = map(&keys, settings);
        for i in 0..40 {
            let p = Vec2::new(f64::from(i) * 7.3 - 150.0, f64::from(i) * 9.1 + 3.0);
            let oval = m.at(p);
            assert!((80.0..=197.0).contains(&oval.half_major_mm), "{oval:?}");
            assert!(oval.half_minor_mm <= oval.half_major_mm && oval.half_minor_mm > 40.0);
        }
        if settings.form == Form::Corrected {
            for k in keys.iter().step_by(301) {
                assert_eq!(m.at(k.at), k.oval());
            }
        }
    }
}

#[test]
fn keys_at_one_place_are_one_or_an_error_that_names_both() {
    let named = |name: &str, k: EllipseKey| EllipseKey {
        name: name.into(),
        ..k
    };
    let twice = [
        named("a", key(0.0, 0.0, 150.0, 120.0, 10.0)),
        named("b", key(60.0, 0.0, 120.0, 120.0, 10.0)),
        named("c", key(0.0, 0.001, 150.0, 120.0, 190.0)),
    ];
    let (m, once) = (default_map(&twice), default_map(&twice[..2]));
    assert_eq!(m.keys().len(), 3);
    for p in [Vec2::ZERO, Vec2::new(30.0, 0.0), Vec2::new(5.0, 80.0)] {
        assert_eq!(m.at(p), once.at(p));
    }
    let mut clash = twice.clone();
    clash[2].half_minor_mm = 119.0;
    let e = EllipseMap::new(clash.to_vec(), EllipseSettings::default()).expect_err("clash");
    assert_eq!(
        e.to_string(),
        "ellipse key 1 (a) and ellipse key 3 (c) are both at (0, 0) mm but state different ellipses; keep one of them"
    );
    assert_eq!(e.key(), Some(3));
    // By the published rule 10° and 190° are not the same.
    assert!(EllipseMap::new(twice.to_vec(), EllipseSettings::default().published()).is_err());
}

#[test]
fn what_is_wrong_is_refused_by_key_value_and_what_is_allowed() {
    let good = key(0.0, 0.0, 150.0, 120.0, 10.0);
    let refused = |bad: EllipseKey| {
        EllipseMap::new(vec![good.clone(), bad], EllipseSettings::default())
            .expect_err("bad")
            .to_string()
    };
    let with = |change: fn(&mut EllipseKey)| {
        let mut k = key(50.0, 0.0, 150.0, 120.0, 10.0);
        change(&mut k);
        k
    };
    for (bad, told) in [
        (
            with(|k| k.at.x = f64::NAN),
            "ellipse key 2 at (NaN, 0) mm: coordinates must be numbers within ±1000000 mm",
        ),
        (
            with(|k| k.half_major_mm = f64::INFINITY),
            "ellipse key 2: half_major_mm is inf; 1 to 1000 is allowed",
        ),
        (
            with(|k| k.half_minor_mm = 0.0),
            "ellipse key 2: half_minor_mm is 0; 1 to 1000 is allowed",
        ),
        (
            with(|k| k.half_minor_mm = 151.0),
            "ellipse key 2: half_minor_mm is 151; at most half_major_mm = 150 is allowed",
        ),
        (
            with(|k| k.angle_rad = f64::NAN),
            "ellipse key 2: angle_deg is NaN; -360 to 360 is allowed",
        ),
        (
            with(|k| k.boundary_mm = Some(vec![9.0; 73])),
            "ellipse key 2: number of radii in boundary_mm is 73; 8 to 72 are allowed",
        ),
        (
            with(|k| k.boundary_mm = Some(vec![f64::NAN; 9])),
            "ellipse key 2: a radius in boundary_mm is NaN; 1 to 1000 is allowed",
        ),
    ] {
        assert_eq!(refused(bad), told);
    }
    let mut first = good.clone();
    first.boundary_mm = Some(vec![9.0; 12]);
    let keys = vec![first, with(|k| k.boundary_mm = Some(vec![9.0; 13]))];
    let e = EllipseMap::new(keys, EllipseSettings::default()).expect_err("13");
    assert_eq!(
        e.to_string(),
        "ellipse key 2: number of radii in boundary_mm is 13; 12 as in the keys before it is allowed"
    );
    for (basic_radius_mm, effect_radius_mm, told) in [
        (
            0.0,
            200.0,
            "ellipse map: basic_radius_mm is 0; 1 to 1000 is allowed",
        ),
        (
            140.0,
            f64::NAN,
            "ellipse map: effect_radius_mm is NaN; 1 to 10000 is allowed",
        ),
    ] {
        let settings = EllipseSettings {
            basic_radius_mm,
            effect_radius_mm,
            ..EllipseSettings::default()
        };
        let e: MapError = EllipseMap::new(vec![good.clone()], settings).expect_err(told);
        assert_eq!(e.to_string(), told);
    }
}

#[test]
fn half_axes_in_the_wrong_order_are_the_same_ellipse() {
    let (a, b) = (
        key(0.0, 0.0, 90.0, 120.0, 10.0),
        key(0.0, 0.0, 120.0, 90.0, 100.0),
    );
    assert_eq!((a.half_major_mm, a.half_minor_mm), (120.0, 90.0));
    assert!((a.angle_rad - b.angle_rad).abs() < 1e-15);
    for i in 0..20 {
        let direction = f64::from(i) * 0.3;
        let (u, v) = (
            (direction - a.angle_rad).cos() / 120.0,
            (direction - a.angle_rad).sin() / 90.0,
        );
        assert!((a.oval().radius_mm(direction) - 1.0 / u.hypot(v)).abs() < 1e-9);
    }
}

#[test]
fn boundaries_are_met_at_their_keys_and_blend_with_ellipses_and_the_basic_circle() {
    let radii: Vec<f64> = (0..12)
        .map(|i| 100.0 + f64::from(i * i % 7) * 9.0)
        .collect();
    let mut irregular = key(0.0, 0.0, 150.0, 120.0, 10.0);
    irregular.boundary_mm = Some(radii.clone());
    let plain = key(80.0, 0.0, 160.0, 100.0, 90.0);
    let m = default_map(&[irregular, plain.clone()]);
    assert_eq!(m.n_radii(), Some(12));
    assert_eq!(m.boundary_at(Vec2::ZERO), Some(radii.clone()));
    assert_eq!(m.boundary_at(Vec2::new(900.0, 0.0)), Some(vec![140.0; 12]));
    let own = m.boundary_at(plain.at).expect("there");
    for (i, r) in own.iter().enumerate() {
        assert!((r - plain.oval().radius_mm(PI * i as f64 / 6.0)).abs() < 1e-9);
    }
    // Half way the two weigh the same, and what is missing to 1 is the basic circle's.
    let half_way = m.boundary_at(Vec2::new(40.0, 0.0)).expect("there");
    let level = (-PI * (1.4 * 40.0 / 200.0_f64).powi(2)).exp();
    for i in 0..12 {
        let expected = 140.0 * (1.0 - level) + level * 0.5 * (radii[i] + own[i]);
        assert!((half_way[i] - expected).abs() < 1e-9);
    }
    let mut again = vec![7.0; 3];
    assert!(m.boundary_into(Vec2::new(40.0, 0.0), &mut again));
    assert_eq!(again, half_way);
    assert!(!default_map(&[plain]).boundary_into(Vec2::ZERO, &mut again) && again.is_empty());
}

/// A sheet of (n + 1)² vertices, 1.1 mm apart in x and 1.3 mm in y.
fn sheet(n: usize) -> Surface {
    let mut mesh = RawMesh::default();
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (i as f64 * 1.1 - 180.0, j as f64 * 1.3 - 10.0);
            mesh.positions.push(Vec3::new(x, y, (x * y) % 7.0));
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

#[test]
fn the_field_is_the_map_at_the_vertices_and_between_them_nearly() {
    let skin = sheet(330);
    let keys = [
        key(-100.0, 100.0, 179.0, 132.0, 99.4),
        key(100.0, 100.0, 179.0, 132.0, 80.6),
        key(0.0, 250.0, 133.0, 108.0, 180.0),
    ];
    for settings in [
        EllipseSettings::default(),
        EllipseSettings::default().published(),
    ] {
        let m = map(&keys, settings);
        let field = m.per_vertex(&skin);
        assert_eq!(field, m.per_vertex(&skin));
        assert!(field.bytes() >= 24 * skin.positions().len());
        for (i, p) in skin.positions().iter().enumerate().step_by(97) {
            assert!(apart(field.vertex(i as u32), m.at(p.truncate())) < 1e-9);
        }
        let sound = settings == EllipseSettings::default();
        for t in (0..skin.triangles().len() as u32)
            .step_by(501)
            .filter(|_| sound)
        {
            let corners = skin.triangles()[t as usize];
            let at = |b: [f64; 3]| field.at(&skin, t, b);
            for (i, b) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
                .into_iter()
                .enumerate()
            {
                assert_eq!(at(b), field.vertex(corners[i]));
            }
            let b = [0.2, 0.3, 0.5];
            let p: Vec3 = (0..3)
                .map(|i| skin.positions()[corners[i] as usize] * b[i])
                .sum();
            assert!(apart(at(b), m.at(p.truncate())) < 0.05);
        }
        for odd in [
            [f64::NAN; 3],
            [0.0; 3],
            [f64::INFINITY, 0.0, 0.0],
            [-1.0, -2.0, -3.0],
        ] {
            assert!(field.at(&skin, 5, odd).half_major_mm.is_finite());
        }
        assert!(
            field
                .at(&skin, u32::MAX, [1.0, 0.0, 0.0])
                .half_major_mm
                .is_finite()
        );
    }
}

fn keys() -> impl Strategy<Value = Vec<EllipseKey>> {
    let one = (
        -200.0..200.0_f64,
        0.0..400.0_f64,
        30.0..300.0_f64,
        0.2..1.0_f64,
        0.0..180.0_f64,
    );
    let one = one.prop_map(|(x, y, a, t, deg)| key(x, y, a, a * t, deg));
    prop::collection::vec(one, 0..25).prop_map(|keys| {
        let mut kept: Vec<EllipseKey> = Vec::new();
        for k in keys {
            if kept.iter().all(|o| o.at.distance(k.at) > 0.5) {
                kept.push(k);
            }
        }
        kept
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn ellipses_are_finite_and_within_those_of_the_keys(
        keys in keys(),
        places in prop::collection::vec(prop::array::uniform2(-500.0..700.0_f64), 30),
    ) {
        let radii = || keys.iter().map(|k| k.half_major_mm).chain([140.0]);
        let (low, high) = (radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max));
        let ratio = keys.iter().map(|k| k.half_major_mm / k.half_minor_mm).fold(1.0, f64::max);
        let odd = [f64::NAN, f64::INFINITY, -1e300, 1e-300].map(|x| [x, 30.0]);
        for settings in all_settings() {
            let m = map(&keys, settings);
            for p in places.iter().copied().chain(odd).map(Vec2::from) {
                let o = m.at(p);
                prop_assert!((low - 1e-9..=high + 1e-9).contains(&o.half_major_mm), "{o:?}");
                prop_assert!((1.0..=ratio + 1e-9).contains(&o.major_over_minor()), "{o:?}");
                prop_assert!((0.0..PI).contains(&o.angle_rad), "{o:?}");
            }
            for k in keys.iter().filter(|_| settings.form == Form::Corrected) {
                prop_assert_eq!(m.at(k.at), k.oval());
            }
        }
    }

    #[test]
    fn the_default_is_continuous_also_where_keys_come_into_range(
        keys in keys(),
        from in prop::array::uniform2(-400.0..600.0_f64),
        to in prop::array::uniform2(-400.0..600.0_f64),
        turn in 0.0..6.3_f64,
    ) {
        let m = default_map(&keys);
        let tiny = Vec2::from_angle(turn) * 1e-7;
        let rims = keys.iter().map(|k| k.at + Vec2::from_angle(turn) * (200.0 - 5e-8));
        let walk = (0..=60).map(|i| Vec2::from(from).lerp(Vec2::from(to), f64::from(i) / 60.0));
        for p in rims.chain(walk).chain(keys.iter().map(|k| k.at)) {
            // Keys 0.5 mm apart may differ by 270 mm and a ratio of 5.
            let jump = apart(m.at(p), m.at(p + tiny));
            prop_assert!(jump < 1e-2, "{jump} at {p}");
        }
        for k in &keys {
            let out = k.at + Vec2::from_angle(turn) * 200.0;
            let steps = [1e-3, 1e-6].map(|mm| apart(m.at(out), m.at(out + Vec2::from_angle(turn) * mm)));
            prop_assert!(steps[1] < 1e-3 + 0.1 * steps[0], "{steps:?}");
        }
    }

    #[test]
    fn the_order_of_keys_matters_to_the_last_bits_only(keys in keys(), p in prop::array::uniform2(-300.0..500.0_f64)) {
        let mut reversed = keys.clone();
        reversed.reverse();
        for settings in all_settings() {
            let (a, b) = (map(&keys, settings).at(Vec2::from(p)), map(&reversed, settings).at(Vec2::from(p)));
            prop_assert!((a.half_major_mm - b.half_major_mm).abs() < 1e-9 && (a.half_minor_mm - b.half_minor_mm).abs() < 1e-9);
        }
    }

    #[test]
    fn a_mirrored_map_is_the_map_in_the_mirror(keys in keys(), p in prop::array::uniform2(-300.0..500.0_f64)) {
        let p = Vec2::from(p);
        let mirrored: Vec<EllipseKey> = keys.iter().map(|k| k.clone().mirrored()).collect();
        let (here, there) = (default_map(&keys).at(p), default_map(&mirrored).at(Vec2::new(-p.x, p.y)));
        let (a, b) = (here.anisotropy(), there.anisotropy());
        prop_assert!((here.half_major_mm - there.half_major_mm).abs() < 1e-9);
        prop_assert!((a.x - b.x).abs() < 1e-9 && (a.y + b.y).abs() < 1e-9);
    }

    #[test]
    fn the_worked_example_stays_between_basic_circle_and_keys(p in prop::array::uniform2(-250.0..250.0_f64)) {
        for form in Form::all() {
            let m = map(&table_5_1(), printed::settings(400.0, *form, Level::Exact));
            let found = m.at(Vec2::from(p)).half_major_mm;
            prop_assert!((90.0..=120.0).contains(&found));
        }
    }
}
