//! Haptic arms against emulators in processes of their own: the loop, and the table of faults and what becomes of the force.
//!
//! What is asserted is the outcome. Times are held to bounds that a busy machine keeps; `dorsum devices --emulator` tells
//! the times themselves.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::device::hid::check::{self, Checked, Trial};
use dorsum::device::hid::emulator::process::{Emulated, Request, families, family};
use dorsum::device::hid::emulator::{Fault, Hand, Outcome};
use dorsum::device::hid::guard::Condition;
use dorsum::device::{Device as _, Family as _};
use dorsum::geom::Vec3;
use std::path::Path;

/// What a machine with other work may add to a bound, ms.
const BUSY_MS: f64 = 250.0;

/// A simulated hand presses an emulated arm into a plane of skin; the loop's side and the truth.
fn pressed(key: &str, fault: Option<Fault>, delay_ms: u16) -> (Checked, Outcome) {
    let arms = family(key).unwrap();
    let request = Request {
        seconds: 60.0,
        hand: match fault {
            // A press that the machine held up is followed by another.
            Some(_) => Hand::Insist { depth_mm: 8.0 },
            None => Hand::Press { depth_mm: 8.0 },
        },
        delay_ms,
        fault,
        ..Request::press(arms.key())
    };
    let program = Path::new(env!("CARGO_BIN_EXE_dorsum"));
    let (emulator, port) = Emulated::spawn(program, &request).unwrap();
    let mut calibration = arms.defaults();
    if !matches!(fault, Some(Fault::Silent | Fault::Short | Fault::Slow)) {
        // A busy machine must not be taken for a silent device where that is not what is tried.
        calibration.guards.silence_ms = 100.0;
        calibration.guards.command_timeout_ms = 100.0;
    }
    let mut device = arms.open_port(port, &calibration).unwrap();
    let trial = Trial {
        seconds: 2.5,
        rate_hz: 1000.0,
        skin_n_per_mm: 0.5,
    };
    let checked = check::run(&mut device, &trial, |_, _| true);
    device.close();
    drop(device);
    (checked, emulator.outcome().unwrap())
}

/// The same without a fault, in a run that the machine did not hold up: one that it did ends without force, as it should.
fn undisturbed(key: &str, delay_ms: u16) -> (Checked, Outcome) {
    for _ in 0..5 {
        let (checked, truth) = pressed(key, None, delay_ms);
        if checked.ticks_without == 0 {
            return (checked, truth);
        }
    }
    panic!("{key}: held up five times for 100 ms");
}

/// The same with a fault; once more where the machine held the loop up before it came, which ends the press.
fn failed(key: &str, fault: Fault) -> (Checked, Outcome) {
    for _ in 0..5 {
        let (checked, truth) = pressed(key, Some(fault), 0);
        if truth.fault_n.is_some() {
            return (checked, truth);
        }
    }
    panic!("{key}: held up five times before {fault:?}");
}

#[test]
fn every_board_is_read_and_driven_as_the_simulated_arm_truly_is() {
    for arms in families() {
        for delay_ms in [0, 3] {
            let key = arms.key();
            let (checked, truth) = undisturbed(key, delay_ms);
            let counts = checked.counts.unwrap();
            assert_eq!(checked.condition, Some(Condition::Good), "{key}");
            assert_eq!(counts.lost, 0, "{key}");
            assert_eq!(
                (counts.not_understood, truth.not_understood),
                (0, 0),
                "{key}"
            );
            assert!(truth.ended_at_zero, "{key}: currents after closing");
            // At rest in the skin: half a count on each axis, and what Coulomb friction lets it creep meanwhile.
            let laid = arms.defaults().mapping.subject_from_device();
            let there = laid * Vec3::from_array(truth.pressed_position_mm);
            let off_mm = there.distance(Vec3::from_array(checked.position_mm));
            assert!(
                off_mm < 0.2,
                "{key}: {off_mm} mm off, {checked:?} {truth:?}"
            );
            let force = laid * Vec3::from_array(truth.pressed_force_n);
            let off_n = force.distance(Vec3::from_array(checked.force_n));
            assert!(off_n < 0.1, "{key}: {off_n} N off");
            assert!(checked.force_n[2] > 1.0, "{key}: never pressed");
            assert!(truth.highest_n <= 5.5, "{key}: {} N", truth.highest_n);
        }
    }
}

/// Fault, board, how the link finds the device, and within which time no current is commanded, ms.
const TABLE: [(Fault, &str, Condition, f64); 9] = [
    (Fault::Unplugged, "woodenhaptics", Condition::Unplugged, 0.0),
    (Fault::Unplugged, "polhem-teensy", Condition::Unplugged, 0.0),
    (Fault::Silent, "woodenhaptics", Condition::Silent, 10.0),
    (Fault::Silent, "polhem", Condition::Silent, 10.0),
    (Fault::Frozen, "woodenhaptics", Condition::Frozen, 10.0),
    (Fault::Jump, "polhem-teensy", Condition::Jumped, 1.0),
    (Fault::Short, "polhem", Condition::Silent, 10.0),
    (Fault::Short, "woodenhaptics", Condition::Silent, 10.0),
    (
        Fault::Reversed,
        "woodenhaptics",
        Condition::AgainstForce,
        100.0,
    ),
];

#[test]
fn every_fault_in_the_middle_of_a_press_ends_at_no_force() {
    for (fault, key, condition, bound_ms) in TABLE {
        let (checked, truth) = failed(key, fault);
        let told = format!("{fault:?} of {key}: {checked:?} {truth:?}");
        assert!(
            truth.fault_n.is_some_and(|n| n >= 1.0),
            "it never came: {told}"
        );
        assert_eq!(checked.condition, Some(condition), "{told}");
        assert_eq!(checked.force_n, [0.0; 3], "{told}");
        assert!(
            truth
                .zero_after_ms
                .is_some_and(|ms| ms <= bound_ms + BUSY_MS),
            "{told}"
        );
        assert!(truth.highest_since_n <= 5.5, "{told}");
    }
}

#[test]
fn a_device_that_is_slow_gets_no_force_between_its_reports() {
    let (checked, truth) = failed("woodenhaptics", Fault::Slow);
    // It is found good with each report and silent soon after; who comes back inside the skin feels nothing.
    assert_eq!(checked.force_n, [0.0; 3], "{checked:?}");
    assert!(
        truth.zero_after_ms.is_some_and(|ms| ms <= 10.0 + BUSY_MS),
        "{truth:?}"
    );
    assert!(checked.ticks_without > 500, "{checked:?}");
}

/// Boards without a counter cannot be told from a still hand: the force stays what it was, within the rated force.
#[test]
fn frozen_reports_without_a_counter_hold_the_force_and_raise_none() {
    let (checked, truth) = failed("polhem", Fault::Frozen);
    assert_eq!(checked.condition, Some(Condition::Good));
    let before_n = truth.fault_n.unwrap();
    assert!(truth.highest_since_n <= before_n + 0.1, "{truth:?}");
    assert!(truth.ended_at_zero);
}

fn dorsum(words: &[&str]) -> (Option<i32>, String, String) {
    let out = std::process::Command::new(env!("CARGO_BIN_EXE_dorsum"))
        .args(words)
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (out.status.code(), text(out.stdout), text(out.stderr))
}

#[test]
fn the_command_line_lists_every_family_and_tries_an_emulated_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().to_str().unwrap();
    let (code, out, err) = dorsum(&["devices", "--json", "--folder", at]);
    assert_eq!((code, err.as_str()), (Some(0), ""));
    let families: serde_json::Value = serde_json::from_str(&out).unwrap();
    let listed: Vec<&str> = families
        .as_array()
        .unwrap()
        .iter()
        .map(|f| f["key"].as_str().unwrap())
        .collect();
    let known: Vec<&str> = dorsum::device::all().iter().map(|f| f.key()).collect();
    assert_eq!(listed, known);
    for family in families.as_array().unwrap() {
        // Nothing here has met hardware; whoever changes that changes this.
        assert!(["emulator", "stub"].contains(&family["tested"].as_str().unwrap()));
        assert!(family["found"].is_array());
    }
    let words = [
        "devices",
        "--emulator",
        "woodenhaptics",
        "--fault",
        "jump",
        "--seconds",
        "2.5",
        "--json",
    ];
    // A busy machine can end the press before the fault comes; the program says so.
    let ended = |_: &u32| Some(dorsum(&words)).filter(|(_, out, _)| !out.contains("it never came"));
    let (code, out, err) = (0..5).find_map(|i| ended(&i)).unwrap();
    assert_eq!((code, err.as_str()), (Some(0), ""), "{out}");
    let told: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(told["condition"], "jumped");
    assert_eq!(told["holds"], true);
    for (words, told) in [
        (
            &["devices", "--emulator", "theremin"][..],
            "no emulator for \"theremin\"; there are woodenhaptics",
        ),
        (
            &["devices", "--emulator", "polhem", "--fault", "x"],
            "--fault \"x\"; allowed are unplugged",
        ),
        (
            &["devices", "--seconds", "0"],
            "--seconds 0; 0.1 to 3600 is allowed",
        ),
        (&["devices", "--fault", "jump"], "--emulator"),
    ] {
        let (code, out, err) = dorsum(words);
        assert_eq!((code, out.as_str()), (Some(2), ""), "{words:?}");
        assert!(
            err.contains(told) && err.trim_end().lines().count() == 1,
            "{err}"
        );
    }
}
