//! What a scene leaves out is not there: bytes and instructions, counted.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::lab::pruning::scenes::PLAIN;
use dorsum::lab::pruning::{self, Case, Counted, Finger, Of, Uncounted};
use dorsum::lab::{self, Document, Setup, Watch};
use dorsum::scenario::Item;

/// The program counts, in processes of its own.
fn counted_by_the_program() {
    pruning::counted_by(env!("CARGO_BIN_EXE_dorsum").into());
}

fn case(finger: Finger, windows: usize, per_window: usize) -> Case {
    Case {
        scenario: PLAIN.on_back(900),
        deformed: false,
        of: Of::Tick,
        finger,
        windows,
        per_window,
        most_steps: 100_000,
    }
}

fn count(case: &Case) -> Counted {
    counted_by_the_program();
    pruning::count(case, &mut || true).unwrap()
}

/// Some containers do not let one process step another.
fn can_step(counted: &Counted) -> bool {
    let refused = &counted.counts.refused;
    if let Some(why) = refused {
        eprintln!("not checked: {why}");
    }
    refused.is_none()
}

#[test]
fn twice_as_many_ticks_are_twice_as_many_instructions_and_again_the_same() {
    let [one, two] = [8, 16].map(|n| count(&case(Finger::Aloft, 2, n)));
    if !can_step(&one) {
        return;
    }
    let again = count(&case(Finger::Aloft, 2, 8));
    let apart = |a: u64, b: u64| a.abs_diff(b);
    for w in 0..2 {
        // A tick in the air does the same each time, but for how far the sweep looks.
        assert!(one.windows[w] > 8 * 300, "{one:?}");
        let off = apart(2 * one.windows[w], two.windows[w]);
        assert!(off * 50 < two.windows[w], "{one:?} {two:?}");
        assert!(
            apart(one.windows[w], again.windows[w]) <= 16,
            "{one:?} {again:?}"
        );
    }
    assert_eq!(one.counts.scene, again.counts.scene);
    assert_eq!(one.counts.use_calls, Some(0));
}

#[test]
fn counting_ends_at_its_bound_and_when_nobody_wants_it() {
    let mut bounded = case(Finger::Aloft, 16, 8);
    bounded.most_steps = 30_000;
    let counted = count(&bounded);
    if !can_step(&counted) {
        return;
    }
    assert!(counted.windows.len() < 16, "{counted:?}");
    assert!(counted.windows.iter().sum::<u64>() <= bounded.most_steps);
    let stopped = pruning::count(&case(Finger::Aloft, 16, 8), &mut || false);
    assert_eq!(stopped, Err(Uncounted::Stopped));
}

#[test]
fn a_case_that_is_none_is_told() {
    counted_by_the_program();
    let mut bad = case(Finger::Aloft, 1, 1);
    bad.scenario = "format = 1\nname = \"x\"\n".into();
    let Err(Uncounted::Here(why)) = pruning::count(&bad, &mut || true) else {
        panic!("a scenario without a surface is refused");
    };
    assert!(why.contains("surface"), "{why}");
    // Nobody else may start it: the shell of a user would be the one that has to step it.
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_dorsum"))
        .arg(pruning::SUBCOMMAND)
        .stdin(std::process::Stdio::null())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(
        told.contains("lab pruning") && told.lines().count() == 1,
        "{told}"
    );
}

fn run(experiment: &dyn lab::Experiment) -> Document {
    counted_by_the_program();
    let setup = Setup {
        quick: true,
        triangles: vec![900],
        ..Setup::default()
    };
    lab::run(&[experiment], &setup, &mut Watch::new(&mut |_, _| true)).unwrap()
}

#[test]
fn absent_parts_cost_nothing_and_the_ledger_tells_what_the_others_hold() {
    let document = run(&pruning::Parts);
    let report = &document.experiments[0];
    println!("{report}");
    assert!(report.holds());
    let bytes = &report.tables[0];
    for row in 0..bytes.rows().len() {
        let part = bytes.cell(row, "part").to_string();
        let number = |name: &str| bytes.cell(row, name).number();
        if let Some(left_out) = number("named but left out") {
            // Keys that are stated are kept, as stated.
            let keys = if part == Item::StiffnessField.name() {
                100.0
            } else {
                0.0
            };
            assert!((0.0..=keys).contains(&left_out), "{part}: {left_out}");
        }
        let used = number("used").expect("counted by the program");
        // A few numbers in the scene itself, or something of its own.
        let inline = [
            Item::Friction,
            Item::ForceModel,
            Item::FingerPad,
            Item::ForceShading,
        ];
        if inline.iter().any(|item| item.name() == part) {
            assert_eq!((used, number("ledger")), (0.0, Some(0.0)), "{part}");
        } else {
            assert!(used > 500.0, "{part}: {used}");
        }
    }
}
