//! `dorsum scenario` as a user meets it, and `dorsum scene` on the examples with dysfunctions.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn dorsum(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_dorsum"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    let output = dorsum(folder, &[arguments, &["--json"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("stdout is one JSON document and nothing else")
}

const MAKE: [&str; 11] = [
    "scenario",
    "make",
    "FIRST",
    "--hide",
    "hypertonic",
    "--among",
    "T1-T12 both sides",
    "--compliance-percent",
    "-28",
    "--seed",
    "7",
];

#[test]
fn a_hidden_site_is_the_same_from_the_same_seed_and_told_only_when_asked() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let output = dorsum(folder, &[&MAKE[..], &["--out", "a.toml"]].concat());
    let told = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(
        told,
        "a.toml: 1 hypertonic among 24 places, compliance -28 %\n"
    );
    let output = dorsum(
        folder,
        &[&MAKE[..], &["--out", "b.toml", "--tell"]].concat(),
    );
    let told = text(&output.stdout);
    assert!(told.contains("  1. hypertonic at T"), "{told}");
    assert!(
        told.contains("severity 2: stiffness +38.9 % (compliance -28.0 %)"),
        "{told}"
    );
    let made = json(
        folder,
        &[&MAKE[..], &["--out", "c.toml", "--count", "3"]].concat(),
    );
    assert_eq!(made["hidden"].as_array().expect("a list").len(), 3);
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect("written");
    assert_eq!(read("a.toml"), read("b.toml"));
    assert!(
        read("a.toml").contains("# T5 spinous process"),
        "comments stay"
    );
    let checked = json(
        folder,
        &["scenario", "check", "a.toml", "c.toml", "FIRST", "fibrosis"],
    );
    let n = |i: usize| checked[i]["dysfunctions"].as_array().expect("a list").len();
    assert_eq!([n(0), n(1), n(2), n(3)], [1, 3, 0, 3]);
    assert_eq!(
        checked[0]["dysfunctions"][0]["sites"],
        made["hidden"][0]["sites"]
    );
}

#[test]
fn check_tells_what_is_wrong_and_exits_with_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let head = "format = 1\nname = \"T\"\n[surface]\nbuiltin = \"back\"\ntriangles = 400\n[stiffness]\nconstant_n_per_mm = 0.5\n";
    let table = "[[dysfunction]]\nkind = \"hypertonic\"\nlevel = \"T5\"\nside = \"right\"\n";
    std::fs::write(
        folder.join("bad.toml"),
        format!("{head}{table}bump_mm = 99\n"),
    )
    .expect("written");
    std::fs::write(
        folder.join("coarse.toml"),
        format!("{head}{table}radius_mm = [4, 4]\n"),
    )
    .expect("written");
    let output = dorsum(
        folder,
        &["scenario", "check", "FIRST", "bad.toml", "coarse.toml"],
    );
    assert_eq!(output.status.code(), Some(1));
    let told = text(&output.stdout);
    let lines: Vec<&str> = told.lines().collect();
    assert_eq!(lines[0], "FIRST: sound, no dysfunction");
    let of = "dysfunction 1 (hypertonic at T5 right transverse process): ";
    assert_eq!(
        lines[1],
        format!("bad.toml: line 12: {of}bump_mm = 99; -20 to 20 is allowed")
    );
    assert!(
        lines[2].starts_with(&format!("coarse.toml: line 8: {of}")),
        "{told}"
    );
    assert_eq!(lines.len(), 3);
    for (arguments, told) in [
        (
            &["scenario", "check", "missing.toml"][..],
            "missing.toml: cannot be read",
        ),
        (&["scenario", "sites", "T13"], "is no level"),
        (
            &[
                "scenario",
                "make",
                "FIRST",
                "--hide",
                "gout",
                "--among",
                "T1",
                "--stiffness-percent",
                "9",
                "--seed",
                "1",
                "--out",
                "x.toml",
            ],
            "--hide gout: allowed are hypertonic",
        ),
        (
            &[
                "scenario",
                "make",
                "FIRST",
                "--hide",
                "tender",
                "--among",
                "T1 up",
                "--stiffness-percent",
                "9",
                "--seed",
                "1",
                "--out",
                "x.toml",
            ],
            "--among",
        ),
        (
            &[
                "scenario",
                "make",
                "FIRST",
                "--hide",
                "tender",
                "--among",
                "T1",
                "--stiffness-percent",
                "9",
                "--seed",
                "1",
                "--count",
                "3",
                "--out",
                "x.toml",
            ],
            "--count 3: 1 to 2 is allowed",
        ),
        (
            &[
                "scenario",
                "make",
                "FIRST",
                "--hide",
                "hypertonic",
                "--among",
                "T1",
                "--compliance-percent",
                "-100",
                "--seed",
                "1",
                "--out",
                "x.toml",
            ],
            "compliance_percent = -100; -90 to 9900 is allowed",
        ),
        (
            &[
                "scenario",
                "make",
                "FIRST",
                "--hide",
                "hypertonic",
                "--among",
                "T1",
                "--compliance-percent",
                "nan",
                "--seed",
                "1",
                "--out",
                "x.toml",
            ],
            "compliance_percent = NaN",
        ),
        (
            &[
                "scenario",
                "make",
                "FIRST",
                "--hide",
                "hypertonic",
                "--among",
                "T1",
                "--seed",
                "1",
                "--out",
                "x.toml",
            ],
            "required",
        ),
    ] {
        let output = dorsum(folder, arguments);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(
            error.contains(told) && error.trim_end().lines().count() == 1,
            "{arguments:?}: {error}"
        );
        assert!(output.stdout.is_empty() && !folder.join("x.toml").exists());
    }
}

#[test]
fn kinds_and_sites_are_listed() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let kinds = json(folder, &["scenario", "list-kinds"]);
    let keys: Vec<&str> = (kinds.as_array().expect("a list").iter())
        .map(|k| k["kind"].as_str().expect("a key"))
        .collect();
    assert_eq!(
        keys,
        [
            "hypertonic",
            "trigger_point",
            "texture",
            "rotation",
            "restricted",
            "tender",
            "skin_drag"
        ]
    );
    let hypertonic = &kinds[0]["forms"][0]["severities"];
    assert_eq!(hypertonic[1]["compliance_percent"], -14.0);
    assert!(
        (hypertonic[1]["stiffness_percent"]
            .as_f64()
            .expect("a number")
            - 16.279)
            .abs()
            < 1e-3
    );
    let told = text(&dorsum(folder, &["scenario", "list-kinds"]).stdout);
    assert!(
        told.contains("preset fryette_two: One level: rotated and bent to the same side."),
        "{told}"
    );
    let sites = json(folder, &["scenario", "sites", "T5 both sides; L1 spinous"]);
    assert_eq!(sites[1]["site"], "T5 right transverse process");
    assert_eq!(
        (&sites[1]["x_mm"], &sites[2]["side"]),
        (&25.0.into(), &"middle".into())
    );
    let told = text(&dorsum(folder, &["scenario", "sites", "T5 right"]).stdout);
    assert_eq!(told, "T5 right transverse process     25.0   348.2 mm\n");
}

#[test]
fn the_ledger_of_each_example_says_what_its_dysfunctions_need() {
    let folder = tempfile::tempdir().expect("a folder");
    const PARTS: [&str; 3] = [
        "Bumps of the surface",
        "Skin drag per vertex",
        "Tender places",
    ];
    for (example, built) in [
        ("FIRST", [false, false, false]),
        ("fryette_two", [true, false, true]),
        ("tender_knot", [true, false, true]),
        ("fibrosis", [true, true, false]),
    ] {
        let told = json(folder.path(), &["scene", example]);
        let rows = told["ledger"].as_array().expect("rows");
        for (part, built) in PARTS.into_iter().zip(built) {
            let row = rows.iter().find(|r| r["item"] == part).expect(part);
            assert_eq!(row["built"], built, "{example}: {row}");
            if !built {
                assert_eq!(
                    (&row["bytes"], &row["cost_us"]),
                    (&0.into(), &Value::Null),
                    "{example}: {row}"
                );
            }
        }
    }
}
