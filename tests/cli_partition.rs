//! `dorsum partition` as a user meets it.

use serde_json::Value;
use std::process::{Command, Output};

fn dorsum(arguments: &[&str]) -> Output {
    let folder = tempfile::tempdir().expect("a folder");
    Command::new(env!("CARGO_BIN_EXE_dorsum"))
        .arg("partition")
        .args(arguments)
        .current_dir(folder.path())
        .output()
        .expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

fn json(arguments: &[&str]) -> Value {
    let output = dorsum(&[arguments, &["--json"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("stdout is one JSON document and nothing else")
}

#[test]
fn every_structure_is_well_formed_and_gathers_the_same_triangles() {
    let mut gathered = Vec::new();
    for kind in ["brute", "bvh", "bsp", "octree", "hybrid"] {
        let found = json(&["back", "--kind", kind]);
        assert_eq!(found["well_formed"], true, "{kind}");
        assert_eq!(found["triangles"], 2962, "{kind}");
        gathered.push(found["hdb"]["complete"]["triangles"].clone());
        let is_tree = !["brute", "bvh"].contains(&kind);
        assert_eq!(found["statistics"].is_object(), is_tree, "{kind}");
        assert_eq!(found["hdb"]["as_published"].is_object(), is_tree, "{kind}");
    }
    assert!(gathered[0].as_u64().expect("a number") > 50, "{gathered:?}");
    assert!(gathered.iter().all(|g| *g == gathered[0]), "{gathered:?}");
}

#[test]
fn threshold_and_case_reach_the_tree() {
    for case in ["a", "b", "c"] {
        let found = json(&["back", "--kind", "bsp", "--threshold", "64", "--case", case]);
        let s = &found["statistics"];
        assert_eq!(s["case"], case);
        assert_eq!(s["threshold"], 64);
        assert!(s["max_occupancy"].as_u64().expect("a number") <= 64, "{s}");
        let once = s["entries"] == s["triangles"];
        assert_eq!(once, case == "c", "{s}");
    }
}

#[test]
fn a_far_box_gathers_nothing_but_as_published_the_outer_leaves_of_a_bsp_answer() {
    let far = ["--probe", "-900,900,900", "--hdb-edge", "10"];
    for (kind, published) in [("bsp", true), ("octree", false), ("hybrid", false)] {
        let start = ["back", "--kind", kind, "--threshold", "64"];
        let found = json(&[&start[..], &far[..]].concat());
        assert_eq!(found["hdb"]["edge_mm"], 10.0);
        assert_eq!(found["hdb"]["complete"]["triangles"], 0, "{kind}");
        let outer = &found["hdb"]["as_published"];
        if published {
            assert!(outer["nodes_visited"].as_u64().expect("a number") > 1);
        } else {
            assert_eq!(outer["triangles"], 0, "{kind}");
        }
    }
}

#[test]
fn a_mesh_file_and_a_back_of_any_size_are_taken_and_a_table_is_printed() {
    let clean = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/clean.obj");
    for mesh in [clean, "back:600"] {
        let output = dorsum(&[mesh, "--kind", "hybrid", "--threshold", "8"]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let table = text(&output.stdout);
        for told in ["hybrid, at most 8", "height", "well formed          yes"] {
            assert!(table.contains(told), "{told}: {table}");
        }
    }
}

#[test]
fn bad_input_is_one_line_that_says_what_is_allowed() {
    for (arguments, told) in [
        (
            &["back", "--kind", "kd"][..],
            "brute, bvh, bsp, octree, hybrid",
        ),
        (&["back", "--kind", "bsp", "--case", "d"], "a, b, c"),
        (
            &["back", "--kind", "bsp", "--threshold", "0"],
            "--threshold",
        ),
        (
            &["back", "--kind", "bvh", "--threshold", "8"],
            "bsp, octree and hybrid",
        ),
        (
            &["back", "--kind", "octree", "--case", "a"],
            "goes with bsp",
        ),
        (&["back", "--kind", "bsp", "--probe", "1,2"], "x,y,z"),
        (
            &["back", "--kind", "bsp", "--hdb-edge", "NaN"],
            "above 0 mm",
        ),
        (&["back:1", "--kind", "bsp"], "back:41582"),
        (&["missing.obj", "--kind", "bsp"], "missing.obj"),
    ] {
        let output = dorsum(arguments);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert_eq!(error.trim_end().lines().count(), 1, "{error}");
        assert!(error.contains(told), "{arguments:?} gave {error:?}");
        assert!(output.stdout.is_empty());
    }
}
