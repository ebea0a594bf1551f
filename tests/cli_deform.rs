//! `dorsum deform` as a user meets it.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

const HEAD: &str = "format = 1\nname = \"Test\"\n[surface]\nbuiltin = \"back\"\ntriangles = 8000\n[stiffness]\nconstant_n_per_mm = 0.5\n";
const FRICTION: &str = "[friction]\nstatic = 0.46\ndynamic = 0.44\n";

/// Runs the command in a folder with the scenario `s.toml`.
fn dorsum_in(folder: &Path, tables: &str, arguments: &[&str]) -> Output {
    std::fs::write(folder.join("s.toml"), format!("{HEAD}{tables}")).expect("a file");
    Command::new(env!("CARGO_BIN_EXE_dorsum"))
        .args(["deform", "s.toml"])
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the program starts")
}

fn dorsum(tables: &str, arguments: &[&str]) -> Output {
    dorsum_in(
        tempfile::tempdir().expect("a folder").path(),
        tables,
        arguments,
    )
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

fn parsed(output: &Output) -> Value {
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("stdout is one JSON document and nothing else")
}

fn json(tables: &str, arguments: &[&str]) -> Value {
    parsed(&dorsum(tables, &[arguments, &["--json"]].concat()))
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn a_vertex_at_the_anchor_lands_on_the_finger_below_the_caps_and_at_the_cap_beyond() {
    let press = |p: &str| json(FRICTION, &["--at-vertex", "--press", p]);
    for p in ["30,200", "-30,200,8,3,-4", "0,300,10,20,0"] {
        let found = press(p);
        assert!(
            number(&found["presses"][0]["off_hip_mm"]) < 1e-9,
            "{p}: {found}"
        );
        assert_eq!(
            found["presses"][0]["vertex"],
            found["largest_displacement_mm"]["vertex"]
        );
    }
    let deep = press("30,200,17");
    assert!((number(&deep["presses"][0]["off_hip_mm"]) - 7.0).abs() < 1e-9);
    assert!((number(&deep["largest_displacement_mm"]["value"]) - 10.0).abs() < 1e-9);
    assert!(number(&deep["strain"]["largest"]["value"]) > 0.0);
    assert!(number(&deep["timings"]["displace_us"]) > 0.0);
}

#[test]
fn several_fingers_move_more_than_one_and_the_caps_hold_for_the_sum() {
    let one = json(FRICTION, &["--press", "30,200,9"]);
    let two = json(FRICTION, &["--press", "30,200,9", "--press", "35,205,9"]);
    assert_eq!(two["presses"].as_array().expect("presses").len(), 2);
    assert!(two["moved"].as_u64() > one["moved"].as_u64());
    assert!(number(&two["largest_displacement_mm"]["value"]) <= 10.0 + 1e-9);
}

#[test]
fn footprint_and_curve_of_the_scenario_are_used() {
    let moved = |tables: &str| {
        let found = json(&format!("{FRICTION}{tables}"), &["--press", "0,240,5,8,0"]);
        found["moved"].as_u64().expect("a count")
    };
    let slender = "[ellipse]\nbasic_radius_mm = 60\n";
    assert!(moved(slender) < moved(""));
    let found = json(
        "[deformation]\ncurve = \"cosine\"\nfootprint = \"circle\"\n",
        &["--press", "0,240"],
    );
    assert_eq!(
        (&found["curve"], &found["footprint"]),
        (&"cosine".into(), &"circle".into())
    );
}

#[test]
fn bones_hold_a_dent_up_only_where_the_scenario_has_them() {
    // Over the spinous process of T8.
    let press = ["--at-vertex", "--press", "0,259,10"];
    let without = json("", &press);
    assert!(without["presses"][0]["bone_depth_mm"].is_null());
    let with = json("[bones]\nbuiltin = \"back\"\n", &press);
    let bone_mm = number(&with["presses"][0]["bone_depth_mm"]);
    assert!((6.0..12.0).contains(&bone_mm), "{bone_mm}");
    assert!(number(&with["largest_displacement_mm"]["value"]) < 0.7 * 12.0);
    assert!(with["moved"].as_u64() < without["moved"].as_u64());
}

#[test]
fn the_deformed_skin_is_written_with_its_fields_and_is_the_one_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = ["--press", "30,200,8,5,5", "--out", "dent.ply", "--json"];
    let told = parsed(&dorsum_in(
        folder.path(),
        &format!("{FRICTION}[bones]\nbuiltin = \"back\"\n"),
        &arguments,
    ));
    let bytes = std::fs::read(folder.path().join("dent.ply")).expect("written");
    let end = bytes
        .windows(11)
        .position(|w| w == b"end_header\n")
        .expect("a header");
    let header = text(&bytes[..end]);
    for field in [
        "displacement_mm",
        "displacement_x_mm",
        "strain",
        "stiffness_n_per_mm",
        "bone_depth_mm",
    ] {
        assert!(
            header.contains(&format!("property double {field}\n")),
            "{field}: {header}"
        );
    }
    // x, y, z and seven fields of doubles per vertex.
    let n = told["vertices"].as_u64().expect("a count") as usize;
    let value = |v: usize, i: usize| {
        let at = end + 11 + 8 * (10 * v + i);
        f64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"))
    };
    let moved = (0..n).filter(|&v| value(v, 3) > 0.0).count();
    assert_eq!(told["moved"], moved);
    let most = &told["largest_displacement_mm"];
    let v = most["vertex"].as_u64().expect("a vertex") as usize;
    assert_eq!(value(v, 3), number(&most["value"]));
    // The deformed position is that at rest and the displacement.
    for i in 0..3 {
        let rest = number(&most["at_mm"][i]);
        assert!((value(v, i) - rest - value(v, 4 + i)).abs() < 1e-9);
    }
    let least = &told["strain"]["least"];
    assert_eq!(
        value(least["vertex"].as_u64().expect("a vertex") as usize, 7),
        number(&least["value"])
    );
    let left = std::fs::read_dir(folder.path()).expect("folder").count();
    assert_eq!(
        left, 2,
        "nothing but the scenario and the mesh is left behind"
    );
}

#[test]
fn for_people_it_is_a_table() {
    let output = dorsum(FRICTION, &["--press", "30,200"]);
    let table = text(&output.stdout);
    for line in [
        "press 1",
        "  skin there",
        "moved",
        "largest strain",
        "an update takes",
    ] {
        assert!(
            table.lines().any(|l| l.starts_with(line)),
            "{line}: {table}"
        );
    }
    assert!(output.stderr.is_empty());
}

#[test]
fn bad_input_is_one_line_and_exit_code_2() {
    for (tables, arguments, told) in [
        ("", &[][..], "--press"),
        (
            "",
            &["--press", "1"],
            "numbers x,y or x,y,depth or x,y,depth,dx,dy in mm are needed",
        ),
        ("", &["--press", "1,2,0"], "the depth must be above 0"),
        ("", &["--press", "1,2,nan"], "the depth must be above 0"),
        ("", &["--press", "900,0"], "--press 900,0: no skin there"),
        (
            "",
            &["--press", "0,200,5,3,0"],
            "has no [friction], so nothing is dragged",
        ),
        (
            "",
            &["--press", "0,200", "--out", "x.obj"],
            "--out x.obj: only PLY is written",
        ),
        (
            "",
            &["--press", "0,200", "--out", "no/such/x.ply"],
            "cannot write the mesh",
        ),
        (
            "[bones]\n",
            &["--press", "0,200"],
            "s.toml: line 8: [bones] needs either",
        ),
        (
            "[deformation]\ncurve = \"x\"\n",
            &["--press", "0,200"],
            "s.toml: line 9: curve = \"x\"; allowed are",
        ),
    ] {
        let output = dorsum(tables, arguments);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(
            error.contains(told) && error.lines().count() == 1,
            "{arguments:?}: {error}"
        );
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn a_yardstick_is_named_and_dents_as_deep_as_the_finger() {
    let found = json(
        "",
        &["--press", "30,200,4", "--model", "layer", "--at-vertex"],
    );
    assert_eq!(found["model"], "layer");
    assert!(number(&found["presses"][0]["off_hip_mm"]) < 1e-9, "{found}");
    assert_eq!(found["timings"]["shade_us"], Value::Null);
    // A layer on bone dents far less wide than the scenario's footprint.
    let own = json("", &["--press", "30,200,4", "--at-vertex"]);
    assert!(number(&own["timings"]["shade_us"]) >= 0.0);
    let refused = dorsum("", &["--press", "30,200", "--model", "jelly"]);
    assert_eq!(refused.status.code(), Some(2));
    let said = text(&refused.stderr);
    assert!(
        said.contains("jelly") && said.contains("fem-linear"),
        "{said}"
    );
    // At the rim there is no skin for a slab to lie under.
    let refused = dorsum("", &["--press", "0,440", "--model", "fem-linear"]);
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused.stderr));
    assert!(text(&refused.stderr).contains("the skin ends"));
}
