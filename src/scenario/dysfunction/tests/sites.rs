//! Sites and the text that names them.

use super::super::site::{levels, levels_text};
use super::*;
use proptest::prelude::*;

fn site(level: &str, side: Side, target: Target) -> Site {
    Site {
        level: VertebralLevel::named(level).expect("level"),
        side,
        target,
    }
}

#[test]
fn landmarks_are_where_the_table_says() {
    let at = |level, side, target| site(level, side, target).at_mm();
    assert_eq!(
        at("T5", Side::Right, Target::Transverse),
        Vec2::new(25.0, 348.2)
    );
    assert_eq!(
        at("T5", Side::Left, Target::Transverse),
        Vec2::new(-25.0, 348.2)
    );
    assert_eq!(
        at("T5", Side::Middle, Target::Spinous),
        Vec2::new(0.0, 334.9)
    );
    assert_eq!(
        at("T5", Side::Left, Target::Spinous),
        Vec2::new(-5.0, 334.9)
    );
    assert_eq!(
        at("L2", Side::Left, Target::Muscle),
        Vec2::new(-34.0, 116.8)
    );
    assert_eq!(
        at("C7", Side::Right, Target::Transverse),
        Vec2::new(27.0, 455.0)
    );
    let rib = at("T12", Side::Right, Target::RibAngle);
    assert!((rib - Vec2::new(75.2, 156.4)).length() < 1e-12);
}

#[test]
fn texts_name_sites_in_order() {
    let all = sites("T1-T12 both sides").expect("good");
    assert_eq!(all.len(), 24);
    assert_eq!(all[0].to_string(), "T1 left transverse process");
    assert_eq!(all[23].to_string(), "T12 right transverse process");
    let some = sites("C7,T4-L5 right spinous").expect("good");
    assert_eq!(some.len(), 15);
    assert_eq!(some[0].to_string(), "C7 right spinous process");
    assert_eq!(
        sites("T5 spinous").expect("good")[0].to_string(),
        "T5 spinous process"
    );
    assert_eq!(sites("T5 middle").expect("good")[0].target, Target::Spinous);
    assert_eq!(sites("t3 , t5 LEFT rib angles").expect("good").len(), 2);
    assert_eq!(sites("T5 left; T5 both; T6 right").expect("good").len(), 3);
}

#[test]
fn faults_are_told() {
    for (text, told) in [
        ("", "\"\" is no level"),
        ("T13 left", "\"t13\" is no level"),
        ("T5-T2 left", "T5-T2 runs upward; write T2-T5"),
        ("T5 up", "\"t5up\" is no level"),
        ("T5 left up", "\"up\"; after the levels a side"),
        ("T5 left right", "\"right\" is a second side"),
        ("T5 left muscle spinous", "\"spinous\" is a second target"),
        ("L1 rib angle", "L1 has no rib; rib angles are at T1 to T12"),
        ("T5 middle muscle", "a muscle is left or right"),
        ("T5 left;", "is no level"),
    ] {
        let error = sites(text).expect_err(text).0;
        assert!(error.contains(told), "{text:?} gave {error:?}");
    }
}

fn any_site() -> impl Strategy<Value = Site> {
    let level = prop::sample::select(VertebralLevel::all().collect::<Vec<_>>());
    let side = prop::sample::select(vec![Side::Left, Side::Middle, Side::Right]);
    let target = prop::sample::select(Target::all().to_vec());
    (level, side, target)
        .prop_map(|(level, side, target)| Site {
            level,
            side,
            target,
        })
        .prop_filter("exists", |s| s.fault().is_none())
}

proptest! {
    #[test]
    fn a_sites_name_names_it(site in any_site()) {
        prop_assert_eq!(sites(&site.to_string()).expect("its own name"), vec![site]);
        prop_assert_eq!(site.mirrored().mirrored(), site);
        let (at, other) = (site.at_mm(), site.mirrored().at_mm());
        prop_assert_eq!((at.x, at.y), (-other.x, other.y));
        prop_assert!(at.is_finite());
    }

    #[test]
    fn levels_come_back_from_their_text(
        chosen in prop::sample::subsequence(VertebralLevel::all().collect::<Vec<_>>(), 1..18)
    ) {
        prop_assert_eq!(levels(&levels_text(&chosen)).expect("own text"), chosen);
    }

    #[test]
    fn no_text_makes_it_fail_otherwise_than_by_an_error(text in "\\PC{0,40}") {
        let _ = sites(&text);
    }

    #[test]
    fn nor_does_one_of_its_own_words(words in prop::collection::vec(prop::sample::select(vec![
        "T1", "t1-t12", "L5,", ",", "-", "–", ";", "left", "both", "sides", "middle", "rib", "angle", "muscle", "C7-L5",
    ]), 0..8)) {
        let named = sites(&words.join(" "));
        if let Ok(named) = named {
            prop_assert!(!named.is_empty() && named.iter().all(|s| s.fault().is_none()));
        }
    }
}
