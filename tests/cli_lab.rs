//! `dorsum lab` as a user meets it.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn dorsum(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_dorsum"))
        .arg("lab")
        .args(arguments)
        .current_dir(folder)
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
