//! `dorsum train`: what it prints, what it writes, and that no end of the program takes a settled trial away.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::training::{TrialRecord, journal};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dorsum"));
    command.args(arguments);
    command
}

fn dorsum(arguments: &[&str]) -> Output {
    command(arguments).output().unwrap()
}

fn json(arguments: &[&str]) -> serde_json::Value {
    let output = dorsum(&[arguments, &["--json"]].concat());
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{told}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// What of a trial does not depend on the time of day.
fn timeless(trials: &[TrialRecord]) -> Vec<TrialRecord> {
    let without = |t: &TrialRecord| TrialRecord {
        settled_utc: String::new(),
        ..t.clone()
    };
    trials.iter().map(without).collect()
}

fn scored(folder: &Path) -> Option<usize> {
    let read = journal::read(folder).ok()?;
    Some(read.trials.iter().filter(|t| !t.practice).count())
}

#[cfg(unix)]
#[test]
fn killed_during_trial_37_of_50_it_goes_on_at_37_with_36_scored() {
    let at = tempfile::tempdir().unwrap();
    let folders = ["whole", "killed"].map(|name| at.path().join(name));
    let [whole, killed] = folders.each_ref().map(|f| f.to_str().unwrap());
    const EXERCISE: [&str; 9] = [
        "train",
        "locate.toml",
        "--observer",
        "d-prime=10,lapse=0.02,policy=read",
        "--trials",
        "50",
        "--seed",
        "11",
        "--out",
    ];
    let mut run = command(&[&EXERCISE[..], &[killed, "--pace", "0.15"]].concat())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let started = Instant::now();
    while scored(&folders[1]) != Some(36) {
        assert!(started.elapsed() < Duration::from_secs(120), "too slow");
        assert!(run.try_wait().unwrap().is_none(), "it ended by itself");
        std::thread::sleep(Duration::from_millis(3));
    }
    // On Unix this is signal 9.
    run.kill().unwrap();
    run.wait().unwrap();
    let before = journal::read(&folders[1]).unwrap();
    assert_eq!(scored(&folders[1]), Some(36));
    assert!(before.ended.is_none());

    // And the line that was being written is torn.
    let torn = folders[1].join(journal::FILE);
    let mut bytes = std::fs::read(&torn).unwrap();
    bytes.extend_from_slice(b"{\"trial\":{\"trial\":37,\"pract");
    std::fs::write(&torn, bytes).unwrap();
    let output = dorsum(&["train", "--resume", killed, "--json"]);
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(told.contains("27 bytes were cut off"), "{told}");
    let resumed: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(resumed["settled_before"], 36);
    assert_eq!(resumed["trials"], 50);

    let uninterrupted = json(&[&EXERCISE[..], &[whole]].concat());
    assert_eq!(uninterrupted["settled_before"], 0);
    assert_eq!(uninterrupted["staircase"], resumed["staircase"]);
    let trials = folders
        .each_ref()
        .map(|f| timeless(&journal::read(f).unwrap().trials));
    assert_eq!(trials[0], trials[1], "the same as if nothing had happened");
    let again = dorsum(&["train", "--resume", killed]);
    assert_eq!(again.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&again.stderr).contains("has ended"));
}

#[test]
fn two_hundred_trials_come_to_the_observers_threshold_and_leave_a_sheet() {
    let at = tempfile::tempdir().unwrap();
    let folder = at.path().join("P07-1");
    let out = folder.to_str().unwrap();
    let told = json(&[
        "train",
        "locate.toml",
        "--observer",
        "d-prime=10,lapse=0.01,policy=read",
        "--trials",
        "200",
        "--seed",
        "3",
        "--participant",
        "P07",
        "--out",
        out,
        "--staircase",
        "1-up-2-down",
    ]);
    assert_eq!(told["trials"], 200);
    let staircase = &told["staircase"];
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let (found, truth) = (
        number(&staircase["threshold_percent"]),
        number(&staircase["true_threshold_percent"]),
    );
    // Four standard errors of theory: 0.4 dB each.
    assert!(
        (found / truth).ln().abs() < 0.19,
        "{found} instead of {truth}"
    );
    let [low, high] =
        [0, 1].map(|i| number(&told["analysis"]["fit"]["threshold_interval_percent"][i]));
    assert!(low < high && (low / truth).ln().abs() < 0.4 && (high / truth).ln().abs() < 0.4);
    let d_prime = number(&told["analysis"]["d_prime"]["per_log_ratio"]);
    assert!((d_prime - 10.0).abs() < 2.0, "{d_prime}");
    assert!((number(&staircase["target"]) - 0.8035).abs() < 1e-4);
    for file in [
        "sheet.html",
        "trials.csv",
        "trials.parquet",
        "participants.csv",
    ] {
        assert!(folder.join(file).metadata().unwrap().len() > 100, "{file}");
    }

    // The sheet of a folder of exercises, and the fit of its CSV.
    let all = at.path().to_str().unwrap();
    let sheet = json(&["train", "sheet", all]);
    assert_eq!(sheet["exercises"].as_array().unwrap().len(), 1);
    let csv = at.path().join("trials.csv");
    let fit = json(&[
        "train",
        "fit",
        csv.to_str().unwrap(),
        "--at",
        "80.35",
        "--family",
        "detection",
    ]);
    assert!(
        (number(&fit["threshold_percent"]) / truth).ln().abs() < 0.25,
        "{fit}"
    );
    assert!(
        (number(&fit["guess"]) - 1.0 / 24.0).abs() < 1e-12,
        "chance is in the file"
    );
}

#[test]
fn a_pressing_observer_trains_through_the_tick() {
    let at = tempfile::tempdir().unwrap();
    let folder = at.path().join("felt");
    let told = json(&[
        "train",
        "locate.toml",
        "--observer",
        "d-prime=25",
        "--trials",
        "4",
        "--seed",
        "5",
        "--out",
        folder.to_str().unwrap(),
    ]);
    assert_eq!(told["trials"], 4);
    let score = &told["analysis"]["score"];
    assert!(score["right"].as_u64().unwrap() >= 3, "{score}");
    assert!(
        score["peak_force_n"].as_f64().unwrap() > 0.5
            && score["coverage"].as_f64().unwrap() > 0.005
    );
    let trials = journal::read(&folder).unwrap().trials;
    assert!(
        trials
            .iter()
            .all(|t| t.palpation.n_visits == 24 && t.confidence_percent.is_some())
    );
}

#[test]
fn bad_input_is_one_line_and_exit_code_two() {
    let at = tempfile::tempdir().unwrap();
    let out = at.path().join("x");
    let out = out.to_str().unwrap();
    let csv = at.path().join("a.csv");
    std::fs::write(&csv, "x_percent,trials,right\n10,5,6\n").unwrap();
    let csv = csv.to_str().unwrap();
    for (arguments, told) in [
        (vec!["locate.toml", "--out", out], "--observer is needed"),
        (vec!["locate.toml", "--observer", "d-prime=10"], "--out"),
        (
            vec!["FIRST.toml", "--observer", "d-prime=10", "--out", out],
            "no [exercise]",
        ),
        (
            vec!["locate.toml", "--observer", "eyes=2", "--out", out],
            "allowed are d-prime",
        ),
        (
            vec![
                "locate.toml",
                "--observer",
                "d-prime=1",
                "--out",
                out,
                "--staircase",
                "up",
            ],
            "allowed are 1-up-2-down",
        ),
        (
            vec![
                "locate.toml",
                "--observer",
                "d-prime=1",
                "--out",
                out,
                "--trials",
                "0",
            ],
            "0 trials; 1 to 10000",
        ),
        (
            vec![
                "locate.toml",
                "--observer",
                "d-prime=1",
                "--out",
                out,
                "--participant",
                "Jane Doe",
            ],
            "pseudonym",
        ),
        (
            vec!["no.toml", "--observer", "d-prime=1", "--out", out],
            "no.toml",
        ),
        (vec!["--resume", "no/such/folder"], "journal.jsonl"),
        (vec!["sheet", "no/such/folder"], "no/such/folder"),
        (
            vec!["sheet", at.path().to_str().unwrap()],
            "holds no journal",
        ),
        (vec!["fit", csv], "line 2: right = \"6\"; 0 to 5"),
        (
            vec!["fit", csv, "--family", "probit"],
            "allowed are weibull",
        ),
        (vec!["fit", "no.csv"], "no.csv"),
    ] {
        let output = dorsum(&[&["train"][..], &arguments].concat());
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(
            error.contains(told) && error.trim_end().lines().count() == 1,
            "{arguments:?}: {error}"
        );
        assert!(
            !Path::new(out).join(journal::FILE).exists(),
            "{arguments:?}"
        );
    }
}
