//! What each kind is, how strong, and what the stiffness is then.

use super::*;
use crate::geom::curve::{Curve, Lookup, PUBLISHED_SIZE};

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

#[test]
fn order_is_kept_and_later_ones_lie_over_earlier_ones() {
    let text = "[[dysfunction]]\nkind = \"hypertonic\"\nlevel = \"T5\"\nside = \"left\"\n\
                [[dysfunction]]\nkind = \"restricted\"\nlevel = \"T5\"\nside = \"left\"\n";
    let s = parse(text).expect("good");
    let kinds: Vec<_> = s.dysfunctions.iter().map(|d| d.kind).collect();
    assert_eq!(kinds, ["hypertonic", "restricted"]);
    let at = site("T5 left").at_mm();
    let k = s.stiffness_map().expect("sound").at(at);
    assert!((k - 0.5 / 0.72 * 1.45).abs() < 1e-12, "{k}");
    let turned: Vec<_> = s.dysfunctions.iter().rev().cloned().collect();
    let turned = s.with_dysfunctions(&turned).expect("sound");
    assert_eq!(turned.dysfunctions[0].kind, "restricted");
    assert!((turned.stiffness_map().expect("sound").at(at) - k).abs() < 1e-12);
}

#[test]
fn fryette_one_bends_away_from_its_rotation_and_two_towards_it() {
    let at = |text: &str| parse(text).expect("good").patches().expect("sound");
    let group = at("[[dysfunction]]\nkind = \"rotation\"\nlevels = \"T4-T6\"\nside = \"right\"\n");
    let one = at("[[dysfunction]]\nkind = \"rotation\"\nlevel = \"T5\"\nside = \"right\"\n");
    let sides = |patches: &[(usize, Patch)], of: fn(&Patch) -> f64| {
        let all = patches.iter().filter(|(_, p)| of(p) != 0.0);
        all.map(|(_, p)| (p.spot.at_mm.x.signum(), of(p).signum()))
            .collect::<Vec<_>>()
    };
    let bump = |p: &Patch| p.bump_mm;
    assert_eq!(sides(&one, bump), [(1.0, 1.0), (-1.0, -1.0)]);
    assert_eq!(sides(&group, bump), [(1.0, 1.0), (-1.0, -1.0)].repeat(3));
    // The bend is the last: one ellipse along the spine.
    let bend = |patches: &[(usize, Patch)]| {
        let spot = &patches.last().expect("some").1.spot;
        (spot.at_mm.x.signum(), spot.half_axes_mm[0] > 20.0)
    };
    assert_eq!((bend(&group), bend(&one)), ((-1.0, true), (1.0, true)));
    let heights: Vec<f64> = group
        .iter()
        .map(|(_, p)| p.bump_mm)
        .step_by(2)
        .take(3)
        .collect();
    assert_eq!(heights, [0.75, 1.5, 0.75]);
}

#[test]
fn a_seed_varies_a_little_and_the_same_way_each_time() {
    let kind = named("hypertonic").expect("listed");
    let with = |seed| Dysfunction {
        place: Place::Sites(sites("T5 both; T6 both").expect("good")),
        seed,
        ..kind.default_of(site("T5 right"), 2)
    };
    let exact = with(None).patches().expect("sound");
    let mut seen = Vec::new();
    for seed in 0..200 {
        let patches = with(Some(seed)).patches().expect("sound");
        assert_eq!(patches, with(Some(seed)).patches().expect("sound"));
        for (a, b) in patches.iter().zip(&exact) {
            let moved = a.spot.at_mm - b.spot.at_mm;
            assert!(moved.abs().max_element() <= 2.0 && moved != Vec2::ZERO);
            let larger = a.spot.half_axes_mm[0] / b.spot.half_axes_mm[0];
            assert!((0.9..=1.1).contains(&larger));
            assert!((a.spot.angle_rad - b.spot.angle_rad).abs() <= 10f64.to_radians() + 1e-12);
            assert_eq!(a.stiffness_factor, b.stiffness_factor);
            seen.push(moved.x);
        }
    }
    // Evenly distributed: the mean of 800 has a standard error of 2/√3/√800 = 0.041.
    let mean = seen.iter().sum::<f64>() / seen.len() as f64;
    assert!(
        mean.abs() < 0.16 && seen.iter().filter(|x| x.abs() > 1.0).count() > 320,
        "{mean}"
    );
}

#[test]
fn random_draws_every_candidate_alike_and_the_same_from_the_same_seed() {
    let candidates = sites("T1-T6 both sides").expect("good");
    let draw = |seed, count| {
        random(&RandomSpec {
            kind: "hypertonic",
            candidates: candidates.clone(),
            strength: Change::CompliancePercent(-28.0),
            count,
            seed,
        })
    };
    // Fixed for all machines and all time: sessions name it by its seed.
    let names: Vec<String> = (0..4)
        .map(|seed| draw(seed, 1)[0].place.to_string())
        .collect();
    assert_eq!(names, FIRST_FOUR);
    let mut counts = std::collections::BTreeMap::new();
    for seed in 0..6000 {
        let drawn = draw(seed, 1);
        assert_eq!(drawn.len(), 1);
        assert_eq!(
            (drawn[0].severity, drawn[0].change),
            (2, Some(Change::CompliancePercent(-28.0)))
        );
        *counts.entry(drawn[0].place.to_string()).or_insert(0.0) += 1.0;
    }
    // χ² with 11 degrees of freedom: 31.3 is its 99.9th percentile.
    let chi: f64 = counts
        .values()
        .map(|n: &f64| (n - 500.0) * (n - 500.0) / 500.0)
        .sum();
    assert!(counts.len() == 12 && chi < 31.3, "{chi}");
    let all = draw(7, 99);
    let mut places: Vec<_> = all.iter().map(|d| d.place.to_string()).collect();
    places.sort();
    places.dedup();
    assert_eq!(places.len(), 12);
    assert_eq!(
        parse("")
            .expect("good")
            .with_dysfunctions(&all)
            .expect("sound")
            .dysfunctions,
        all
    );
    let tender = random(&RandomSpec {
        kind: "tender",
        candidates: candidates.clone(),
        strength: Change::StiffnessPercent(20.0),
        count: 1,
        seed: 1,
    });
    assert_eq!((tender[0].severity, tender[0].change), (2, None));
    for (percent, preset, severity) in [
        (-40.0, "oedema", 3),
        (-10.0, "oedema", 1),
        (50.0, "fibrosis", 2),
    ] {
        let texture = random(&RandomSpec {
            kind: "texture",
            candidates: candidates.clone(),
            strength: Change::StiffnessPercent(percent),
            count: 1,
            seed: 1,
        });
        assert_eq!(
            (texture[0].preset, texture[0].severity),
            (Some(preset), severity)
        );
    }
    let none = RandomSpec {
        kind: "gout",
        candidates,
        strength: Change::StiffnessPercent(1.0),
        count: 1,
        seed: 1,
    };
    assert!(random(&none).is_empty());
}

const FIRST_FOUR: [&str; 4] = [
    "T4 right transverse process",
    "T3 right transverse process",
    "T6 left transverse process",
    "T5 right transverse process",
];
