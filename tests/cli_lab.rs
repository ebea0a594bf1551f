//! `dorsum lab` as a user meets it.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn dorsum(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_dorsum"))
        .arg("lab")
        .args(arguments)
        .current_dir(folder)
        .env("XDG_CACHE_HOME", folder.join("cache"))
        .output()
        .expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

fn json(output: &Output) -> Value {
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(output.stderr.is_empty(), "no progress in a pipe");
    serde_json::from_slice(&output.stdout).expect("stdout is one JSON document and nothing else")
}

#[test]
fn list_names_every_experiment_and_group() {
    let folder = tempfile::tempdir().expect("a folder");
    let listed = json(&dorsum(folder.path(), &["list", "--json"]));
    let shown = text(&dorsum(folder.path(), &["list"]).stdout);
    let all = listed.as_array().expect("a list");
    assert!(!all.is_empty());
    for experiment in all {
        let told = |key: &str| experiment[key].as_str().expect("text");
        assert!(shown.contains(told("name")) && shown.contains(told("about")));
        assert!(told("name").starts_with(told("group")));
        assert!(experiment["takes_mesh"].is_boolean());
    }
    assert!(shown.contains("\npartition "), "{shown}");
}

#[test]
fn an_experiment_is_printed_and_written_alike() {
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = ["partition-complexity", "--out", "found/here"];
    let output = dorsum(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let shown = text(&output.stdout);
    for told in [
        "Measured on ",
        "w printed",
        "holds: ",
        "partition-complexity.worst-w.csv",
    ] {
        assert!(shown.contains(told), "{told}: {shown}");
    }
    let read = |name: &str| {
        std::fs::read_to_string(folder.path().join("found/here").join(name)).expect("written")
    };
    assert!(read("partition-complexity.worst-w.csv").starts_with("tree,height,leaves,"));
    let written: Value = serde_json::from_str(&read("partition-complexity.json")).expect("JSON");
    let printed = json(&dorsum(folder.path(), &["partition-complexity", "--json"]));
    assert_eq!(written["experiments"], printed["experiments"]);
    assert_eq!(printed["holds"], true);
    assert_eq!(printed["seed"], 0);
    let build = printed["build"].as_str().expect("text");
    assert!(build.len() == 12 && shown.contains(&format!("build {build}, seed 0")));
    assert!(read("partition-complexity.html").contains(&format!("build {build}")));
    assert_eq!(printed["experiments"][0]["tables"][0]["rows"][0][0], "bsp");
}

#[test]
fn bad_input_is_one_line_that_says_what_is_allowed_and_nothing_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("file"), "").expect("written");
    for (arguments, told) in [
        (&[][..], "<NAME>"),
        (&["nothing"], "partition-complexity"),
        (&["nothing"], "for all of a kind"),
        (
            &["partition-complexity", "--mesh", "back"],
            "--mesh: partition-complexity takes none",
        ),
        (
            &["partition-complexity", "--triangles", "900"],
            "--triangles: partition-complexity",
        ),
        (
            &["partition-complexity", "--scenario", "bones"],
            "--scenario: partition-complexity takes none",
        ),
        (
            &["partition-complexity", "--session", "file"],
            "--session: partition-complexity takes none",
        ),
        (
            &["partition-complexity", "--seed", "1"],
            "--seed: partition-complexity takes none",
        ),
        (
            &["partition-complexity", "--no-cache", "--fresh"],
            "cannot be used with",
        ),
        (
            &["partition", "--triangles", "1"],
            "200 to 4000000 triangles",
        ),
        (&["partition-complexity", "--out", "file"], "file"),
        (
            &["partition-complexity", "--out", "file/in/it"],
            "file/in/it",
        ),
    ] {
        let output = dorsum(folder.path(), arguments);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert_eq!(error.trim_end().lines().count(), 1, "{error}");
        assert!(error.contains(told), "{arguments:?} gave {error:?}");
        assert!(output.stdout.is_empty());
    }
    let left = std::fs::read_dir(folder.path()).expect("a folder").count();
    assert_eq!(left, 1, "only what was there");
}

#[test]
fn a_second_run_shows_what_was_kept_unless_told_otherwise() {
    let folder = tempfile::tempdir().expect("a folder");
    let measured = |arguments: &[&str]| {
        let all = [&["partition-complexity", "--quick", "--json"], arguments].concat();
        let told = json(&dorsum(folder.path(), &all));
        told["experiments"][0]["measured"]
            .as_str()
            .expect("a time")
            .to_owned()
    };
    let first = measured(&[]);
    assert_eq!(measured(&[]), first);
    let shown = dorsum(folder.path(), &["partition-complexity", "--quick"]);
    let told = format!("Kept since {first}: --fresh measures anew");
    assert!(text(&shown.stdout).contains(&told));
    assert_ne!(measured(&["--no-cache"]), first);
    assert_ne!(measured(&["--cache", "elsewhere"]), first);
    assert!(folder.path().join("elsewhere").is_dir());
    assert_eq!(measured(&[]), first, "the others left it alone");
    let anew = measured(&["--fresh"]);
    assert_ne!(anew, first);
    assert_eq!(measured(&[]), anew);
    // Where nothing can be kept, that is said and no more.
    std::fs::write(folder.path().join("file"), "").expect("written");
    let output = dorsum(folder.path(), &["partition-complexity", "--cache", "file"]);
    assert!(output.status.success());
    let error = text(&output.stderr);
    assert!(
        error.contains("not kept") && error.lines().count() == 1,
        "{error}"
    );
}

/// Both experiments about error take a recording: its deepest press is drawn, its motion felt, and repeating it is exact.
#[test]
fn errors_are_measured_on_a_recorded_session() {
    let folder = tempfile::tempdir().expect("a folder");
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("sessions/t5_right_press.mcap");
    let sample = sample.to_str().expect("UTF-8");
    let lab = |name: &str, file: &str| {
        let arguments = [name, "--quick", "--no-cache", "--json", "--session", file];
        dorsum(folder.path(), &arguments)
    };
    let over = json(&lab("error-over-session", sample));
    let rows = &over["experiments"][0]["tables"][0]["rows"];
    assert_eq!(rows[0][0], "the same again");
    assert_eq!(rows[0][2].as_f64(), Some(0.0), "{rows}");
    assert!(rows[2][2].as_f64() > Some(0.0), "{rows}");
    let vs = json(&lab("error-vs-time", sample));
    let settings = vs["experiments"][0]["settings"].to_string();
    assert!(settings.contains("T5"), "{settings}");
    let refused = lab("error-vs-time", "none.mcap");
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("none.mcap"));
}
