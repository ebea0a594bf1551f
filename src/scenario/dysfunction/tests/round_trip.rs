//! Through the file and back.

use super::*;
use crate::scenario::edit::set_dysfunctions;
use proptest::prelude::*;

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
            // Its place is a text that names it.
            if let Place::Sites(of) = &d.place {
                prop_assert_eq!(&sites(&d.place.to_string()).expect("its own name"), of);
            }
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

#[test]
fn comments_stay_and_only_what_changed_is_written() {
    let text = format!(
        "{HEAD}# The first.\n[[dysfunction]] # here\nkind = \"hypertonic\" # tight\nlevels = \"T5,T6\" # two\nside = \"right\"\n\
         severity = 2 # stated\n\n# The second.\n[[dysfunction]]\nkind = \"tender\"\nlevel = \"L1\"\nside = \"left\"\n"
    );
    let s = Scenario::parse(&text, "a.toml", None).expect("good");
    assert_eq!(
        s.with_dysfunctions(&s.dysfunctions).expect("same").source,
        text
    );
    let mut list = s.dysfunctions.clone();
    list[0].severity = 3;
    list[0].change = Some(Change::CompliancePercent(-30.0));
    let edited = s.with_dysfunctions(&list).expect("sound").source;
    let expected = text.replace(
        "severity = 2 # stated\n",
        "severity = 3 # stated\nstiffness_change = { compliance_percent = -30 }\n",
    );
    assert_eq!(edited, expected);
    // Without the first, the second and its comment stay.
    let second = s.with_dysfunctions(&list[1..]).expect("sound").source;
    assert!(
        second.contains("# The second.\n[[dysfunction]]\nkind = \"tender\"")
            && !second.contains("tight")
    );
    // A new one says what is not the default.
    let mut new = named("texture")
        .expect("listed")
        .default_of(site("L2 left"), 3);
    new.preset = Some("fibrosis");
    list.push(new);
    let added = s.with_dysfunctions(&list).expect("sound").source;
    let told = "\n[[dysfunction]]\nkind = \"texture\"\npreset = \"fibrosis\"\nlevel = \"L2\"\nside = \"left\"\nseverity = 3\n";
    assert!(added.ends_with(told), "{added}");
}

#[test]
fn a_list_of_inline_tables_stays_one() {
    let text = format!(
        "dysfunction = [\n  {{ kind = \"tender\", level = \"T5\", side = \"left\" }}, # one\n]\n{HEAD}"
    );
    let s = Scenario::parse(&text, "a.toml", None).expect("good");
    let mut list = s.dysfunctions.clone();
    list[0].severity = 1;
    list.push(
        named("hypertonic")
            .expect("listed")
            .default_of(site("L2 left"), 2),
    );
    let edited = s.with_dysfunctions(&list).expect("sound");
    assert_eq!(edited.dysfunctions, list);
    assert!(
        edited.source.contains("severity = 1 }, # one\n"),
        "{}",
        edited.source
    );
}
