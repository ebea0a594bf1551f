//! Dysfunctions through the file and back, their faults, and what they make of the maps.

use super::*;
use crate::geom::curve::{Curve, Lookup, PUBLISHED_SIZE};
use crate::scenario::Scenario;
use crate::scenario::edit::set_dysfunctions;
use proptest::prelude::*;

const HEAD: &str = "# A comment on top.\nformat = 1\nname = \"T\"\n[surface]\nbuiltin = \"back\"\n\
                    [stiffness]\nconstant_n_per_mm = 0.5\n[friction]\nstatic = 0.46\ndynamic = 0.44\n";

fn parse(tables: &str) -> Result<Scenario, crate::scenario::ScenarioError> {
    Scenario::parse(&format!("{HEAD}{tables}"), "a.toml", None)
}

fn site(text: &str) -> Site {
    sites(text).expect(text)[0]
}

#[test]
fn the_example_of_the_design_is_read_in_full() {
    let s = parse(
        "[[dysfunction]]\nkind = \"hypertonic\"\nlevel = \"T5\"\nside = \"right\"\nradius_mm = [14, 9]\nangle_deg = 80\n\
         profile = \"gaussian\"\nstiffness_change = { compliance_percent = -28 }\nbump_mm = 1.5\nskin_drag = 1.2\n\
         tender_above_n = 3.0\n",
    )
    .expect("good");
    let d = &s.dysfunctions[0];
    let expected = Dysfunction {
        radius_mm: [14.0, 9.0],
        angle_deg: 80.0,
        profile: "gaussian".into(),
        change: Some(Change::CompliancePercent(-28.0)),
        bump_mm: Some(1.5),
        skin_drag: Some(1.2),
        tender_above_n: Some(3.0),
        ..named("hypertonic")
            .expect("listed")
            .default_of(site("T5 right"), 2)
    };
    assert_eq!(*d, expected);
    assert_eq!(d.to_string(), "hypertonic at T5 right transverse process");
}

#[test]
fn a_compliance_and_a_stiffness_are_told_apart() {
    let c = Change::CompliancePercent(-14.0);
    assert!((c.stiffness_percent() - 16.279_069_767).abs() < 1e-8);
    let forty = Change::CompliancePercent(-40.0);
    assert!((forty.stiffness_percent() - 66.666_666_667).abs() < 1e-8);
    let back = Change::StiffnessPercent(c.stiffness_percent());
    assert!((back.compliance_percent() + 14.0).abs() < 1e-12);
    assert_eq!(c.to_string(), "compliance -14 %");
}

#[test]
fn a_hypertonic_spot_is_as_stiff_as_its_closed_form() {
    let s = parse(
        "[[dysfunction]]\nkind = \"hypertonic\"\nlevel = \"T5\"\nside = \"left\"\nradius_mm = [14, 9]\nangle_deg = 30\n\
         profile = \"gaussian\"\nstiffness_change = { compliance_percent = -28 }\n",
    )
    .expect("good");
    let map = s.stiffness_map().expect("sound");
    let curve = Curve::named("gaussian", PUBLISHED_SIZE, Lookup::Linear).expect("listed");
    let centre = site("T5 left").at_mm();
    assert!((map.at(centre) - 0.5 / 0.72).abs() < 1e-15);
    // Mirrored on the left: the long axis points away from the midline and 30° up.
    let (sin, cos) = (libm::sin(30f64.to_radians()), libm::cos(30f64.to_radians()));
    for (along, across) in [
        (5.0, 0.0),
        (0.0, 4.0),
        (6.0, -3.0),
        (-13.0, 2.0),
        (20.0, 0.0),
    ] {
        let away = Vec2::new(-cos, sin);
        let other = Vec2::new(-sin, -cos);
        let at = centre + away * along + other * across;
        let q = libm::hypot(along / 14.0, across / 9.0);
        let expected = 0.5 * (1.0 + (1.0 / 0.72 - 1.0) * curve.at(q));
        assert!((map.at(at) - expected).abs() < 1e-12, "{along} {across}");
    }
}

#[test]
fn the_centre_of_every_kind_has_the_stated_strength() {
    for kind in all() {
        let d = Dysfunction {
            change: Some(Change::StiffnessPercent(60.0)),
            ..kind.default_of(site("T6 right"), 2)
        };
        let s = parse("")
            .expect("good")
            .with_dysfunctions(&[d])
            .expect("sound");
        let k = s
            .stiffness_map()
            .expect("sound")
            .at(site("T6 right").at_mm());
        assert!((k - 0.8).abs() < 1e-12, "{} {k}", kind.key());
    }
}

#[test]
fn severities_rise_and_none_is_nothing() {
    for kind in all() {
        let presets: Vec<Option<&str>> = match kind.presets() {
            [] => vec![None],
            of => of.iter().map(|p| Some(p.key)).collect(),
        };
        for preset in presets {
            let at = |severity| {
                let s = kind.strength(preset, severity);
                [
                    libm::fabs(libm::log(s.stiffness_factor())),
                    s.skin_drag.unwrap_or(1.0),
                    s.bump_mm.unwrap_or(0.0),
                    -s.tender_above_n.unwrap_or(f64::INFINITY),
                ]
            };
            assert_eq!(
                kind.strength(preset, 0),
                Strength::default(),
                "{}",
                kind.key()
            );
            for severity in 1..=MOST_SEVERE {
                let (less, more) = (at(severity - 1), at(severity));
                assert!((0..4).all(|i| more[i] >= less[i]), "{}", kind.key());
                assert!((0..4).any(|i| more[i] > less[i]), "{}", kind.key());
            }
        }
        let none = kind.default_of(site("T6 right"), 0);
        let patches = none.patches().expect("sound");
        assert!(patches.iter().all(Patch::does_nothing), "{}", kind.key());
    }
}

#[test]
fn every_kind_is_named_and_told() {
    for kind in all() {
        assert_eq!(named(kind.key()).expect("listed").title(), kind.title());
        assert!(kind.about().ends_with('.') && !kind.title().is_empty());
        for severity in 0..=MOST_SEVERE {
            let d = kind.default_of(site("T6 right"), severity);
            let s = parse("")
                .expect("good")
                .with_dysfunctions(std::slice::from_ref(&d))
                .expect("sound");
            assert_eq!(s.dysfunctions, [d]);
        }
    }
    let mut keys: Vec<_> = all().iter().map(|k| k.key()).collect();
    keys.dedup();
    assert_eq!(keys.len(), 7);
}

fn any_place() -> impl Strategy<Value = Place> {
    let one = (0..18_usize, 0..2_usize, 0..4_usize).prop_map(|(level, side, target)| {
        let level = VertebralLevel::all().nth(level).expect("a level");
        let target = Target::all()[target];
        let target = if level.rib().is_none() && target == Target::RibAngle {
            Target::Spinous
        } else {
            target
        };
        let side = [Side::Left, Side::Right][side];
        Site {
            level,
            side,
            target,
        }
    });
    let middle = site("T1 middle");
    prop_oneof![
        one.clone().prop_map(Place::from),
        (0..18_usize).prop_map(move |n| {
            let level = VertebralLevel::all().nth(n).expect("a level");
            Place::from(Site { level, ..middle })
        }),
        prop::collection::vec(one, 1..4).prop_map(|mut sites| {
            sites.sort();
            sites.dedup();
            Place::Sites(sites)
        }),
        (-150.0..150.0, 0.0..450.0).prop_map(|(x, y)| Place::At(Vec2::new(x, y))),
    ]
}

/// Any one, with bumps and changes small enough never to clash with itself.
fn any_dysfunction() -> impl Strategy<Value = Dysfunction> {
    let kind = 0..all().len();
    let shape = (
        (-40.0..40.0, -40.0..40.0),
        (10.0..60.0, 10.0..60.0),
        -360.0..360.0,
        0..crate::geom::curve::all().len(),
    );
    let change = prop_oneof![
        (-60.0..200.0).prop_map(Change::CompliancePercent),
        (-60.0..200.0).prop_map(Change::StiffnessPercent),
    ];
    let strength = (
        prop::option::of(change),
        prop::option::of(0.7..1.5),
        prop::option::of(-0.3..0.3),
        prop::option::of(0.1..50.0),
    );
    let rest = (any::<bool>(), prop::option::of(0..u64::MAX / 2), 0..4_u8);
    (kind, any_place(), shape, strength, rest, 0..3_usize).prop_map(
        |(kind, place, (offset, radius, angle_deg, profile), strength, rest, preset)| {
            let kind = all()[kind];
            let many = matches!(&place, Place::Sites(s) if s.len() > 1);
            let right = site("T5 right");
            let place = match kind.key() {
                "rotation" if many => Place::Sites(sites("T3-T6 right").expect("good")),
                "rotation" => Place::from(right),
                _ => place,
            };
            let default = kind.default_at(place, rest.2);
            let (change, skin_drag, bump_mm, tender_above_n) = strength;
            Dysfunction {
                preset: match kind.presets().get(preset) {
                    Some(p) if kind.needs_preset() => Some(p.key),
                    _ => default.preset,
                },
                offset_mm: offset.into(),
                radius_mm: radius.into(),
                angle_deg,
                profile: crate::geom::curve::all()[profile].0.to_owned(),
                change,
                skin_drag,
                bump_mm,
                tender_above_n,
                tender_shown: rest.0,
                seed: rest.1,
                ..default
            }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn any_one_comes_back_from_the_file(d in any_dysfunction()) {
        let base = parse("").expect("good");
        // The sharper falloffs may be refused for their slope.
        if let Ok(text) = set_dysfunctions(&base.source, std::slice::from_ref(&d)) {
            let read = Scenario::parse(&text, "a.toml", None).expect("own text");
            prop_assert_eq!(&read.dysfunctions, &vec![d.clone()]);
            prop_assert_eq!(&set_dysfunctions(&text, &[d]).expect("again"), &text);
            prop_assert!(text.starts_with(HEAD));
            prop_assert_eq!(set_dysfunctions(&text, &[]).expect("without"), HEAD);
        }
    }

    #[test]
    fn changing_one_leads_to_what_is_asked(a in any_dysfunction(), b in any_dysfunction()) {
        let base = parse("").expect("good");
        if let Ok(text) = set_dysfunctions(&base.source, &[a])
            && let Ok(text) = set_dysfunctions(&text, std::slice::from_ref(&b))
        {
            let read = Scenario::parse(&text, "a.toml", None).expect("own text");
            prop_assert_eq!(&read.dysfunctions, &vec![b]);
        }
    }

    #[test]
    fn no_value_makes_the_parser_fail_otherwise_than_by_a_line(
        key in prop::sample::select(vec!["level", "levels", "side", "target", "sites", "at_mm", "offset_mm", "radius_mm",
            "angle_deg", "profile", "severity", "stiffness_change", "bump_mm", "skin_drag", "tender_above_n",
            "tender_shown", "seed", "preset", "kind"]),
        value in prop::sample::select(vec!["nan", "inf", "-1", "0", "1e300", "\"x\"", "[1, nan]", "[0, 0]", "[]", "true",
            "{ compliance_percent = -100 }", "{ stiffness_percent = nan }", "{}", "9223372036854775807", "\"T5\"", "\"both\""]),
    ) {
        let mut lines = vec![("kind", "\"hypertonic\""), ("level", "\"T5\""), ("side", "\"right\"")];
        lines.retain(|(k, _)| *k != key);
        lines.push((key, value));
        let table: String = lines.iter().map(|(k, v)| format!("{k} = {v}\n")).collect();
        if let Err(e) = parse(&format!("[[dysfunction]]\n{table}")) {
            prop_assert!(e.0.starts_with("a.toml: line 1") && !e.0.contains('\n'), "{}", e.0);
        }
    }
}
