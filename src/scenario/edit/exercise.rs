//! `[exercise]` written: what is as it was stays as somebody wrote it.

use super::cells::{Cell, number};
use super::dysfunctions::put;
use super::{ORIGIN, checked, parsed, table_of};
use crate::scenario::dysfunction::sites_words;
use crate::scenario::exercise::{Exercise, Hides, Staircase, Step};
use crate::scenario::{Change, Scenario, ScenarioError, Site};
use toml_edit::{Array, InlineTable, Item, TableLike, Value};

/// `source` with this exercise as its `[exercise]`, or without one.
///
/// What is stated already stays as written, with its comments; what changed is written anew; what is new and not the
/// default is added. Parsed again, the result gives the same exercise.
///
/// # Errors
/// `source` is no scenario, or a value of the exercise is not allowed.
pub fn set_exercise(source: &str, exercise: Option<&Exercise>) -> Result<String, ScenarioError> {
    let mut document = parsed(source)?;
    let old = Scenario::parse(source, ORIGIN, None)?.exercise;
    let Some(new) = exercise else {
        document.remove("exercise");
        return checked(&document);
    };
    if old.as_ref() == Some(new) {
        return Ok(source.to_owned());
    }
    let table = table_of(&mut document, "exercise")?;
    let default = Exercise::default();
    for key in KEYS {
        let is_default = match key {
            "task" => false,
            // Where what is stated is hidden, none are the default.
            "candidates" if new.hides == Hides::Stated => new.candidates.is_empty(),
            _ => same(value(&default, key), value(new, key)),
        };
        let was = old.as_ref().map(|old| value(old, key));
        settle(table, key, was, value(new, key), is_default);
    }
    match &new.staircase {
        None => {
            table.remove("staircase");
        }
        Some(new) => {
            if !table.contains_key("staircase") {
                table.insert("staircase", Item::Value(InlineTable::new().into()));
            }
            let was = old.as_ref().and_then(|old| old.staircase.as_ref());
            if let Some(table) = table.get_mut("staircase").and_then(Item::as_table_like_mut) {
                staircase(table, was, new);
            }
        }
    }
    checked(&document)
}

/// Every key but the staircase in the order of a new table.
const KEYS: [&str; 15] = [
    "task",
    "candidates",
    "hides",
    "dysfunction",
    "change",
    "most",
    "trials",
    "practice",
    "trial_limit_s",
    "limit_s",
    "feedback",
    "asks",
    "vary_stiffness_percent",
    "tolerance_mm",
    "seed",
];

const STAIRCASE_KEYS: [&str; 11] = [
    "rule",
    "measure",
    "step_percent",
    "step_db",
    "start_percent",
    "least_percent",
    "most_percent",
    "target_percent",
    "reversals",
    "skipped_reversals",
    "constant_percent",
];

/// Makes `key` say `new`: left as it is where it said so before, left out where it may be.
fn settle(
    table: &mut dyn TableLike,
    key: &str,
    was: Option<Option<Value>>,
    new: Option<Value>,
    is_default: bool,
) {
    let there = table.contains_key(key);
    match new {
        None => {
            table.remove(key);
        }
        Some(new) if there && !was.is_some_and(|was| same(was, Some(new.clone()))) => {
            put(table, key, new);
        }
        Some(new) if !there && !is_default => put(table, key, new),
        Some(_) => {}
    }
}

fn same(a: Option<Value>, b: Option<Value>) -> bool {
    a.map(|v| v.to_string()) == b.map(|v| v.to_string())
}

fn staircase(table: &mut dyn TableLike, old: Option<&Staircase>, new: &Staircase) {
    let default = Staircase::default();
    for key in STAIRCASE_KEYS {
        let is_default = match key {
            // Between least and most it stays where it begins by default.
            "start_percent" => {
                let start = default.start_percent;
                new.start_percent == start.clamp(new.least_percent, new.most_percent)
            }
            _ => same(step(&default, key), step(new, key)),
        };
        let was = old.map(|old| step(old, key));
        settle(table, key, was, step(new, key), is_default);
    }
}

/// What `key` is in a file; `None` where it is not to be there.
fn value(e: &Exercise, key: &str) -> Option<Value> {
    let whole = |n: u32| Value::from(i64::from(n));
    Some(match (key, &e.hides) {
        ("task", _) => Value::from(e.task),
        ("candidates", _) if e.candidates.is_empty() => return None,
        ("candidates", _) => Value::from(sites_text(&e.candidates)),
        ("hides", Hides::Drawn { .. }) => Value::from("drawn"),
        ("hides", Hides::Stated) => Value::from("stated"),
        ("dysfunction", Hides::Drawn { kind, .. }) => Value::from(*kind),
        ("change", Hides::Drawn { change, .. }) => change_value(*change),
        ("most", Hides::Drawn { most, .. }) => Value::from(i64::try_from(*most).ok()?),
        ("trials", _) => whole(e.trials),
        ("practice", _) => whole(e.practice),
        ("trial_limit_s", _) => number(e.trial_limit_s?),
        ("limit_s", _) => number(e.limit_s?),
        ("feedback", _) => Value::from(e.feedback.name()),
        ("asks", _) => {
            let asks = [
                (e.asks_confidence, "confidence"),
                (e.asks_kind, "kind"),
                (e.asks_severity, "severity"),
            ];
            let asks: Array = (asks.iter().filter(|a| a.0)).map(|a| a.1).collect();
            Value::Array(asks)
        }
        ("vary_stiffness_percent", _) => number(e.vary_stiffness_percent),
        ("tolerance_mm", _) => number(e.tolerance_mm),
        ("seed", _) => Value::from(i64::try_from(e.seed?).ok()?),
        _ => return None,
    })
}

fn change_value(change: Change) -> Value {
    let (key, percent) = match change {
        Change::CompliancePercent(c) => ("compliance_percent", c),
        Change::StiffnessPercent(s) => ("stiffness_percent", s),
    };
    let mut table = InlineTable::new();
    table.insert(key, number(percent));
    Value::InlineTable(table)
}

/// What `key` of a staircase is in a file; `None` where it is not to be there.
fn step(s: &Staircase, key: &str) -> Option<Value> {
    let whole = |n: u32| Value::from(i64::from(n));
    Some(match (key, s.step) {
        ("rule", _) => Value::from(s.rule),
        ("measure", _) => Value::from(s.measure.name()),
        ("step_percent", Step::Percent(step)) | ("step_db", Step::Decibel(step)) => number(step),
        ("start_percent", _) => number(s.start_percent),
        ("least_percent", _) => number(s.least_percent),
        ("most_percent", _) => number(s.most_percent),
        ("target_percent", _) => Cell::Percent(s.target).value(),
        ("reversals", _) => whole(s.reversals?),
        ("skipped_reversals", _) => whole(s.skipped_reversals),
        ("constant_percent", _) => {
            Value::Array(s.constant_percent.iter().map(|x| number(*x)).collect())
        }
        _ => return None,
    })
}

/// Words that name these sites in this order.
pub fn sites_text(sites: &[Site]) -> String {
    match sites_words(sites) {
        Some((levels, side, target)) => match (side, target.name()) {
            ("both", "transverse") => format!("{levels} both sides"),
            (side, target) => format!("{levels} {side} {target}"),
        },
        None => {
            let names: Vec<String> = sites.iter().map(Site::to_string).collect();
            names.join("; ")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::exercise::{Feedback, Measure, RULES, TASKS};
    use crate::scenario::sites;
    use proptest::prelude::*;

    const FILE: &str = "format = 1\nname = \"A\" # short\n[surface]\nbuiltin = \"back\"\n[stiffness]\nconstant_n_per_mm = 1\n";

    fn read(text: &str) -> Option<Exercise> {
        Scenario::parse(text, "a.toml", None)
            .expect("good")
            .exercise
    }

    #[test]
    fn the_default_is_written_in_two_lines_and_taken_out_again() {
        let text = set_exercise(FILE, Some(&Exercise::default())).expect("good");
        assert_eq!(text, format!("{FILE}\n[exercise]\ntask = \"locate\"\n"));
        let without = set_exercise(&text, None).expect("good");
        assert_eq!(read(&without), None);
        assert!(without.starts_with(FILE));
    }

    #[test]
    fn what_changes_is_written_and_comments_stay() {
        let file = format!(
            "{FILE}\n# What is asked.\n[exercise]\ntask = \"locate\" # where is it?\ntrials = 30 # half an hour\n\
             staircase = {{ rule = \"psi\", start_percent = 30 }} # as in METHOD\n"
        );
        let mut e = read(&file).expect("an exercise");
        assert_eq!(set_exercise(&file, Some(&e)).as_deref(), Ok(file.as_str()));
        e.trials = 40;
        e.asks_kind = true;
        if let Some(s) = &mut e.staircase {
            s.step = Step::Percent(3.0);
        }
        let text = set_exercise(&file, Some(&e)).expect("good");
        for kept in [
            "# What is asked.",
            "# where is it?",
            "trials = 40 # half an hour",
            "# as in METHOD",
            "rule = \"psi\"",
        ] {
            assert!(text.contains(kept), "{kept} is not in\n{text}");
        }
        assert_eq!(read(&text), Some(e));
    }

    #[test]
    fn what_is_not_allowed_is_refused_in_one_line() {
        let e = Exercise {
            trials: 0,
            ..Exercise::default()
        };
        let error = set_exercise(FILE, Some(&e)).expect_err("none").to_string();
        assert!(
            error.contains("trials = 0") && !error.contains('\n'),
            "{error}"
        );
    }

    fn exercises() -> impl Strategy<Value = Exercise> {
        let places = prop::sample::select(vec![
            "T1-T12 both sides",
            "C7,T4-L5 right spinous",
            "T3 left muscle; L1-L3 right",
            "T2 middle",
        ]);
        let hides = prop_oneof![
            Just(Hides::Stated),
            (prop::bool::ANY, -89.0..899.0f64, 1..20usize).prop_map(|(harder, x, most)| {
                let change = if harder {
                    Change::StiffnessPercent(x)
                } else {
                    Change::CompliancePercent(x)
                };
                Hides::Drawn {
                    kind: "texture",
                    change,
                    most,
                }
            }),
        ];
        let stairs = (
            prop::sample::select(RULES.to_vec()),
            prop::bool::ANY,
            0.01..20.0f64,
            0.1..40.0f64,
            41.0..90.0f64,
            0.1..0.99f64,
            prop::option::of(2..1000u32),
        )
            .prop_map(|(rule, db, x, least, most, target, reversals)| Staircase {
                rule,
                measure: if db {
                    Measure::Stiffness
                } else {
                    Measure::Compliance
                },
                step: if db {
                    Step::Decibel(x)
                } else {
                    Step::Percent(x)
                },
                start_percent: 0.5 * (least + most),
                least_percent: least,
                most_percent: most,
                target: ((100.0 * target).round() / 100.0).max(0.1),
                reversals,
                skipped_reversals: 3,
                constant_percent: vec![least, most],
            });
        (
            prop::sample::select(TASKS.to_vec()),
            places,
            hides,
            (1..10_000u32, 0..1000u32, prop::option::of(1.0..3600.0f64)),
            prop::sample::select(Feedback::ALL.to_vec()),
            [prop::bool::ANY; 3],
            (0.0..100.0f64, 1.0..200.0f64, prop::option::of(0..9_999u64)),
            prop::option::of(stairs),
        )
            .prop_map(
                |(
                    task,
                    places,
                    hides,
                    (trials, practice, limit),
                    feedback,
                    asks,
                    more,
                    staircase,
                )| Exercise {
                    task,
                    candidates: sites(places).expect("sites"),
                    hides,
                    trials,
                    practice,
                    trial_limit_s: limit,
                    limit_s: limit.map(|l| l * 2.0),
                    feedback,
                    asks_confidence: asks[0],
                    asks_kind: asks[1],
                    asks_severity: asks[2],
                    vary_stiffness_percent: more.0,
                    tolerance_mm: more.1,
                    seed: more.2,
                    staircase,
                },
            )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn any_exercise_is_read_as_it_was_written(a in exercises(), b in exercises()) {
            let text = set_exercise(FILE, Some(&a)).expect("allowed");
            prop_assert_eq!(read(&text), Some(a));
            // From one to any other, in the same file.
            let text = set_exercise(&text, Some(&b)).expect("allowed");
            prop_assert_eq!(read(&text), Some(b.clone()));
            prop_assert_eq!(set_exercise(&text, Some(&b)), Ok(text));
        }
    }
}
