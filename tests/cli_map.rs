//! `dorsum map` as a user meets it.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn dorsum(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_dorsum"))
        .arg("map")
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

fn json(arguments: &[&str], folder: &Path) -> Value {
    let output = dorsum(&[arguments, &["--json"]].concat(), folder);
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("stdout is one JSON document and nothing else")
}

fn folder(points: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("points.csv"), points).expect("written");
    folder
}

const TABLE_5_1: &str = r#"format = 1
name = "Table 5.1"
[surface]
builtin = "back"
[stiffness]
constant_n_per_mm = 0.5
[[stiffness.stroke]]
path = [[100, 60]]
radius_mm = 10
change_percent = 20
[ellipse]
basic_radius_mm = 90
effect_radius_mm = 400
level = "array"
key = [
  { name = "O1", x = 0, y = 150, half_major_mm = 120, half_minor_mm = 120, angle_deg = 90 },
  { name = "O2", x = 0, y = 60, half_major_mm = 120, half_minor_mm = 120, angle_deg = 90 },
  { name = "O3", x = 0, y = -30, half_major_mm = 120, half_minor_mm = 120, angle_deg = 90 },
]
"#;

#[test]
fn points_of_table_5_1_give_the_figures_of_every_form() {
    let folder = folder(
        "# name first\nname, x, y\na, 0, 150\nb, 0, 60\nc, 0, 105\nd, 100, 60\ne, 1000, 1000\n",
    );
    std::fs::write(folder.path().join("s.toml"), TABLE_5_1).expect("written");
    let found = json(&["s.toml", "--at", "points.csv"], folder.path());
    assert_eq!(found["ellipse_keys"], 3);
    let half_major = |i: usize, form: &str| {
        let point = &found["points"][i];
        point[form]["half_major_mm"].as_f64().expect("a number")
    };
    for (i, form, expected) in [
        (0, "default", 120.0),
        (0, "scenario", 120.0),
        (0, "published", 114.056),
        (1, "published", 115.238),
        (2, "default", 117.2573),
        (2, "scenario", 117.2337),
        (3, "default", 107.7784),
        (3, "scenario", 107.7648),
        (4, "default", 90.0),
        (4, "published", 90.0),
    ] {
        let apart = (half_major(i, form) - expected).abs();
        assert!(apart < 0.0006, "point {i}, {form}: {}", half_major(i, form));
    }
    assert_eq!(found["points"][0]["stiffness_n_per_mm"], 0.5);
    assert_eq!(found["points"][3]["stiffness_n_per_mm"], 0.6);
    let printed = text(&dorsum(&["s.toml", "--at", "points.csv"], folder.path()).stdout);
    for told in [
        "default",
        "published",
        "corrected, tensor, array",
        "117.234",
        "117.257",
    ] {
        assert!(printed.contains(told), "{told} is not in\n{printed}");
    }
}

#[test]
fn an_example_without_ellipses_is_the_basic_circle() {
    let folder = folder("x,y\n25,348.2\n");
    let found = json(&["t5_right", "--at", "points.csv"], folder.path());
    assert_eq!(found["points"][0]["stiffness_n_per_mm"], 0.7);
    assert_eq!(found["points"][0]["default"]["half_minor_mm"], 140.0);
    let fibres = json(&["fibres", "--at", "points.csv"], folder.path());
    assert_eq!(fibres["ellipse_keys"], 7);
}

#[test]
fn bad_points_are_told_in_one_line_with_exit_code_2() {
    for (points, told) in [
        (
            "x,y\n1,2\n3,abc\n",
            "points.csv: line 3: y = \"abc\"; a number within ±50000 mm is needed",
        ),
        ("x,y\n1,nan\n", "points.csv: line 2: y = \"nan\""),
        ("x,y\n1,inf\n", "points.csv: line 2: y = \"inf\""),
        ("x,y\n1\n", "points.csv: line 2: y = \"\""),
        ("x,y\n60000,1\n", "points.csv: line 2: x = \"60000\""),
        ("x,y\n", "points.csv: no points"),
        (
            "",
            "points.csv: line 1: columns \"\"; x and y are needed, mm",
        ),
        (
            "1,2\n3,4\n",
            "points.csv: line 1: columns \"1,2\"; x and y are needed, mm",
        ),
    ] {
        let folder = folder(points);
        let output = dorsum(&["FIRST", "--at", "points.csv"], folder.path());
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{points:?}");
        assert!(
            error.contains(told) && error.trim_end().lines().count() == 1,
            "{points:?} gave {error:?}"
        );
    }
    let folder = folder("x,y\n1,2\n");
    for (arguments, told) in [
        (
            &["FIRST", "--at", "none.csv"][..],
            "none.csv: cannot be read",
        ),
        (
            &["none.toml", "--at", "points.csv"],
            "none.toml: cannot be read",
        ),
        (&["FIRST"], "--at"),
        (&["--at", "points.csv"], "SCENARIO"),
        (&[], "required"),
        (
            &["--appendix-c", "--subject", "9"],
            "subject 9 was not measured with the force up; there are 1, 2, 3, 4, 5",
        ),
        (
            &["--appendix-c", "--force", "down", "--subject", "1"],
            "there are 3, 4, 5",
        ),
        (
            &["--appendix-c", "--force", "sideways"],
            "allowed are up, down",
        ),
        (&["--subject", "1"], "--appendix-c"),
    ] {
        let output = dorsum(arguments, folder.path());
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(
            error.contains(told) && error.trim_end().lines().count() == 1,
            "{arguments:?} gave {error:?}"
        );
    }
}

#[test]
fn the_means_of_appendix_c_are_printed_both_ways() {
    let folder = folder("");
    let found = json(&["--appendix-c"], folder.path());
    let deg = |how: &str, i: usize| found[how][i]["direction_deg"].as_f64().expect("a number");
    assert!((deg("printed", 3) - 99.4).abs() < 1e-9 && (deg("axial", 3) - 97.5).abs() < 0.05);
    assert!((deg("printed", 4) - 121.0).abs() < 1e-9 && (deg("axial", 4) - 126.0).abs() < 0.05);
    assert_eq!(found["keys"].as_array().expect("a list").len(), 7);
    let one = json(
        &["--appendix-c", "--force", "down", "--subject", "4"],
        folder.path(),
    );
    assert_eq!(
        (&one["force"], &one["subject"]),
        (&Value::from("down"), &Value::from(4))
    );
    assert_eq!(one["printed"][0]["major_mm"], 320.0);
    let printed = text(&dorsum(&["--appendix-c"], folder.path()).stdout);
    for told in ["358.0   1.134     90.0", "121.0", "126.0", "P7"] {
        assert!(printed.contains(told), "{told} is not in\n{printed}");
    }
}

#[test]
fn every_figure_to_meet_is_met() {
    let folder = folder("");
    let output = dorsum(&["--check"], folder.path());
    assert!(output.status.success());
    let printed = text(&output.stdout);
    assert!(
        !printed.contains("FAILS") && printed.contains("115.102") && printed.contains("117.2573")
    );
    let rows = json(&["--check"], folder.path());
    let rows = rows.as_array().expect("a list");
    assert!(rows.len() > 40 && rows.iter().all(|row| row["holds"] == true));
}
