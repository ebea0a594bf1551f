//! Scenario files changed in place: what is written is read again, and all else stays.

use dorsum::geom::Vec2;
use dorsum::maps::appendix::{Force, seven_keys};
use dorsum::maps::{
    AngleRule, EllipseKey, EllipseSettings, Fit, Form, Level, StiffnessKey, Stroke,
};
use dorsum::scenario::edit::{with_ellipse, with_stiffness};
use dorsum::scenario::{Scenario, examples};
use proptest::prelude::*;

const SOURCE: &str = r#"# What it is for.
format = 1 # the only one
name = "Test"

[surface]
builtin = "back"

# Where the stiffness comes from.
[stiffness]
fit = "natural" # the smoothest
key = [
  # spine
  { x = 0, y = 284, stiffness_n_per_mm = 0.550 }, # C7
  { x = 0.0, y = 1.5e2, stiffness_n_per_mm = 0.6 }, # T1
  # flank
  { x = -40, y = 100, stiffness_n_per_mm = 0.3 }, # left
  { x = 40, y = 100, stiffness_n_per_mm = 0.3 } # right
  # the end
]

[friction] # skin
static = 0.46
dynamic = 0.44
"#;

fn parse(text: &str) -> Scenario {
    Scenario::parse(text, "test", None).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn keys(text: &str) -> Vec<StiffnessKey> {
    parse(text).stiffness_keys
}

fn key(x: f64, y: f64, stiffness_n_per_mm: f64) -> StiffnessKey {
    StiffnessKey {
        at: Vec2::new(x, y),
        stiffness_n_per_mm,
    }
}

fn edited(keys: &[StiffnessKey]) -> String {
    with_stiffness(SOURCE, keys, Fit::Natural, &[]).expect("sound")
}

#[test]
fn writing_what_is_there_changes_no_byte() {
    for (text, name) in examples().iter().map(|e| (e.text, e.file)).chain([(
        SOURCE.replace("0.3 } # right", "0.3 }, # right").as_str(),
        "source",
    )]) {
        let s = parse(text);
        let again = with_stiffness(text, &s.stiffness_keys, s.stiffness_fit, &s.strokes);
        assert_eq!(again.expect(name), text, "{name}");
        let map = s
            .ellipse
            .as_ref()
            .map(|(keys, settings)| (&keys[..], settings));
        assert_eq!(with_ellipse(text, map).expect(name), text, "{name}");
    }
}

#[test]
fn one_value_changes_one_line() {
    let mut all = keys(SOURCE);
    all[1].stiffness_n_per_mm = 0.75;
    let text = edited(&all);
    let changed: Vec<_> = SOURCE
        .lines()
        .zip(text.lines())
        .filter(|(a, b)| a != b)
        .collect();
    assert_eq!(
        changed,
        [
            (
                "  { x = 0.0, y = 1.5e2, stiffness_n_per_mm = 0.6 }, # T1",
                "  { x = 0.0, y = 1.5e2, stiffness_n_per_mm = 0.75 }, # T1",
            ),
            (
                "  { x = 40, y = 100, stiffness_n_per_mm = 0.3 } # right",
                "  { x = 40, y = 100, stiffness_n_per_mm = 0.3 }, # right",
            ),
        ]
    );
}

#[test]
fn a_key_taken_out_takes_its_comments_along_and_leaves_the_others_theirs() {
    let mut all = keys(SOURCE);
    all.remove(2);
    let text = edited(&all);
    assert!(
        !text.contains("# left") && !text.contains("# flank"),
        "{text}"
    );
    for line in [
        "stiffness_n_per_mm = 0.6 }, # T1",
        "stiffness_n_per_mm = 0.3 }, # right",
        "  # the end\n]",
        "  # spine\n",
    ] {
        assert!(text.contains(line), "{line:?} is not in\n{text}");
    }
    assert_eq!(keys(&text), all);
}

#[test]
fn a_key_put_in_between_stands_on_a_line_of_its_own() {
    let mut all = keys(SOURCE);
    all.insert(2, key(1.25, -7.0, 0.9));
    all.push(key(9.0, 9.0, 0.1));
    let text = edited(&all);
    for line in [
        "0.6 }, # T1\n",
        "\n  { x = 1.25, y = -7, stiffness_n_per_mm = 0.9 },\n",
        "0.3 }, # right\n  { x = 9, y = 9, stiffness_n_per_mm = 0.1 },\n  # the end\n]",
    ] {
        assert!(text.contains(line), "{line:?} is not in\n{text}");
    }
    assert_eq!(keys(&text), all);
}

#[test]
fn a_constant_stays_one_as_long_as_it_is_one() {
    let source = "format = 1\nname = \"T\"\n[surface]\nbuiltin = \"back\"\n[stiffness]\n# assumed\nconstant_n_per_mm = 0.5 # soft\n";
    let text = with_stiffness(source, &[key(0.0, 0.0, 0.7)], Fit::Natural, &[]).expect("sound");
    assert_eq!(text, source.replace("0.5", "0.7"));
    let two = [key(0.0, 0.0, 0.7), key(1.0, 2.0, 0.8)];
    let text = with_stiffness(source, &two, Fit::Rbf, &[]).expect("sound");
    assert!(
        text.contains("fit = \"rbf\"") && !text.contains("constant"),
        "{text}"
    );
    assert_eq!(keys(&text), two);
}

#[test]
fn other_ways_to_write_a_table_are_understood() {
    let head = "format = 1\nname = \"T\"\nsurface.builtin = \"back\"\n";
    let strokes = [Stroke {
        path: vec![Vec2::new(1.0, 2.0)],
        radius_mm: 5.0,
        change: 0.25,
        falloff: "gaussian".into(),
    }];
    let two = [key(0.0, 5.0, 0.7), key(1.0, 2.0, 0.8)];
    for body in [
        "stiffness = { constant_n_per_mm = 0.5 }\n[friction]\nstatic = 0.4\ndynamic = 0.3\n",
        "stiffness.constant_n_per_mm = 0.5\n[friction]\nstatic = 0.4\ndynamic = 0.3\n",
        "[[stiffness.key]]\nx = 1 # one\ny = 2\nstiffness_n_per_mm = 0.8\n[friction]\nstatic = 0.4\ndynamic = 0.3\n",
        "[stiffness]\nkey = [{x=1,y=2,stiffness_n_per_mm=0.5}]\nstroke = [{path=[[1,2]],radius_mm=3,change_percent=4}]\n[friction]\nstatic = 0.4\ndynamic = 0.3\n",
    ] {
        let source = format!("{head}{body}");
        let text = with_stiffness(&source, &two, Fit::Idw, &strokes).expect(body);
        let s = parse(&text);
        assert_eq!(
            (s.stiffness_keys.as_slice(), s.strokes.as_slice()),
            (&two[..], &strokes[..]),
            "{text}"
        );
        assert!(s.friction.is_some());
        let without = with_stiffness(&text, &two, Fit::Idw, &[]).expect(body);
        assert!(!without.contains("stroke"), "{without}");
        let ellipse = with_ellipse(
            &text,
            Some((&seven_keys(Force::Up, None), &EllipseSettings::default())),
        );
        assert_eq!(
            parse(&ellipse.expect(body)).ellipse.expect("there").0.len(),
            7
        );
    }
}

#[test]
fn the_seven_keys_may_stay_named_and_are_written_out_once_changed() {
    let source =
        format!("{SOURCE}\n[ellipse]\nkeys_from = \"appendix-c\" # measured\nforce = \"down\"\n");
    let (keys, settings) = parse(&source).ellipse.expect("there");
    let wider = EllipseSettings {
        effect_radius_mm: 250.0,
        ..settings
    };
    let text = with_ellipse(&source, Some((&keys, &wider))).expect("sound");
    assert_eq!(text, format!("{source}effect_radius_mm = 250\n"));
    let mut moved = keys.clone();
    moved[0].at.x = 3.5;
    let text = with_ellipse(&text, Some((&moved, &wider))).expect("sound");
    assert!(
        !text.contains("appendix-c") && !text.contains("force"),
        "{text}"
    );
    assert_eq!(parse(&text).ellipse, Some((moved, wider)));
    let without = with_ellipse(&text, None).expect("sound");
    assert!(parse(&without).ellipse.is_none());
    assert_eq!(without.trim_end(), SOURCE.trim_end());
}

#[test]
fn what_would_be_refused_is_not_written() {
    let e = with_stiffness(SOURCE, &[], Fit::Natural, &[]).expect_err("no keys");
    assert_eq!(e.0, "the stiffness map has no keys; at least one is needed");
    let e = with_stiffness(SOURCE, &[key(0.0, 0.0, f64::NAN)], Fit::Natural, &[]).expect_err("NaN");
    assert!(e.0.contains("stiffness_n_per_mm = NaN"), "{e}");
    let clash = [key(0.0, 0.0, 0.2), key(0.0, 0.0, 0.3)];
    let e = with_stiffness(SOURCE, &clash, Fit::Natural, &[]).expect_err("clash");
    assert!(
        e.0.contains("stiffness keys 1 and 2 are both at (0, 0) mm"),
        "{e}"
    );
    let e = with_stiffness("format = ", &clash[..1], Fit::Natural, &[]).expect_err("no scenario");
    assert!(e.0.starts_with("scenario: ") && !e.0.contains('\n'), "{e}");
}

fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        -300.0..300.0_f64,
        (-300..300_i32).prop_map(f64::from),
        Just(-0.0),
        Just(1e-12)
    ]
}

fn stiffness_keys() -> impl Strategy<Value = Vec<StiffnessKey>> {
    let kept = keys(SOURCE);
    let either = prop_oneof![
        (coordinate(), coordinate(), 0.01..5.0_f64).prop_map(|(x, y, k)| key(x, y, k)),
        (0..kept.len()).prop_map(move |i| kept[i]),
    ];
    prop::collection::vec(either, 1..9).prop_map(|keys| {
        let mut apart: Vec<StiffnessKey> = Vec::new();
        for k in keys {
            if apart.iter().all(|o| o.at.distance(k.at) > 0.5) {
                apart.push(k);
            }
        }
        apart
    })
}

fn strokes() -> impl Strategy<Value = Vec<Stroke>> {
    let point = (coordinate(), coordinate()).prop_map(|(x, y)| Vec2::new(x, y));
    let stroke = (
        prop::collection::vec(point, 1..6),
        0.5..90.0_f64,
        -99..900_i32,
        any::<bool>(),
    );
    let stroke = stroke.prop_map(|(path, radius_mm, percent, printed)| Stroke {
        path,
        radius_mm,
        change: f64::from(percent) / 100.0,
        falloff: if printed {
            "gaussian-printed"
        } else {
            "gaussian"
        }
        .into(),
    });
    prop::collection::vec(stroke, 0..4)
}

fn ellipse_keys() -> impl Strategy<Value = Vec<EllipseKey>> {
    let boundary = prop::option::of(prop::collection::vec(1.0..900.0_f64, 12));
    let one = (
        coordinate(),
        coordinate(),
        50.0..400.0_f64,
        0.1..1.0_f64,
        -3600..3600_i32,
        "[a-zA-Z \"\\\\é#]{0,9}",
        boundary,
    );
    let one = one.prop_map(
        |(x, y, half_major_mm, t, tenths, name, boundary_mm)| EllipseKey {
            name,
            at: Vec2::new(x, y),
            half_major_mm,
            half_minor_mm: half_major_mm * t,
            angle_rad: (f64::from(tenths) / 10.0).to_radians(),
            boundary_mm,
        },
    );
    prop::collection::vec(one, 0..8).prop_map(|keys| {
        let mut apart: Vec<EllipseKey> = Vec::new();
        for k in keys {
            if apart.iter().all(|o| o.at.distance(k.at) > 0.5) {
                apart.push(k);
            }
        }
        apart
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn stiffness_comes_back_bit_for_bit(
        first in (stiffness_keys(), 0..5_usize, strokes()),
        second in (stiffness_keys(), 0..5_usize, strokes()),
    ) {
        let mut text = SOURCE.to_owned();
        for (keys, fit, strokes) in [first, second] {
            let fit = Fit::all()[fit];
            text = with_stiffness(&text, &keys, fit, &strokes).expect("sound");
            let s = parse(&text);
            let bits = |k: &StiffnessKey| [k.at.x, k.at.y, k.stiffness_n_per_mm].map(f64::to_bits);
            prop_assert!(s.stiffness_keys.iter().map(bits).eq(keys.iter().map(bits)), "{text}");
            prop_assert_eq!(s.stiffness_fit, fit);
            prop_assert_eq!(s.strokes, strokes);
            for kept in ["# What it is for.\nformat = 1 # the only one\n", "\n# Where the stiffness comes from.\n[stiffness]\n", "[friction] # skin\nstatic = 0.46\n", "# the smoothest", "  # the end\n]"] {
                prop_assert!(text.contains(kept), "{kept:?} is not in\n{text}");
            }
        }
    }

    #[test]
    fn ellipses_come_back_bit_for_bit(
        first in (ellipse_keys(), 1.0..999.0_f64, 1.0..9999.0_f64, 0..8_usize),
        second in (ellipse_keys(), 1.0..999.0_f64, 1.0..9999.0_f64, 0..8_usize),
    ) {
        let mut text = SOURCE.to_owned();
        for (keys, basic_radius_mm, effect_radius_mm, choice) in [first, second] {
            let settings = EllipseSettings {
                basic_radius_mm,
                effect_radius_mm,
                form: Form::all()[choice % 2],
                angle: AngleRule::all()[choice / 2 % 2],
                level: Level::all()[choice / 4],
            };
            text = with_ellipse(&text, Some((&keys, &settings))).expect("sound");
            prop_assert_eq!(parse(&text).ellipse, Some((keys, settings)), "{}", text);
            prop_assert!(text.starts_with(SOURCE), "{text}");
        }
    }

    #[test]
    fn an_angle_or_change_in_other_units_is_off_by_a_rounding_at_most(angle_rad in -6.0..6.0_f64, change in -0.9..8.0_f64) {
        let mut key = seven_keys(Force::Up, None).remove(0);
        key.angle_rad = angle_rad;
        let text = with_ellipse(SOURCE, Some((&[key], &EllipseSettings::default()))).expect("sound");
        let found = parse(&text).ellipse.expect("there").0[0].angle_rad;
        prop_assert!((found - angle_rad).abs() <= 2.0 * f64::EPSILON * angle_rad.abs());
        let stroke = Stroke { path: vec![Vec2::ZERO], radius_mm: 9.0, change, falloff: "gaussian".into() };
        let text = with_stiffness(SOURCE, &keys(SOURCE), Fit::Natural, &[stroke]).expect("sound");
        let found = parse(&text).strokes[0].change;
        prop_assert!((found - change).abs() <= 2.0 * f64::EPSILON * change.abs());
        let again = with_stiffness(&text, &keys(SOURCE), Fit::Natural, &parse(&text).strokes).expect("sound");
        prop_assert_eq!(again, text);
    }
}
