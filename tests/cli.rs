//! The command line as a user meets it: exit codes, one-line errors, JSON, files.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn dorsum(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_dorsum"))
        .args(arguments)
        .current_dir(folder)
        .env("XDG_DATA_HOME", folder.join("data"))
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

fn json(output: &Output) -> Value {
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("stdout is one JSON document and nothing else")
}

fn assert_refused(folder: &Path, arguments: &[&str], told: &str) {
    let output = dorsum(folder, arguments);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    assert_eq!(
        error.trim_end().lines().count(),
        1,
        "{arguments:?}: {error}"
    );
    assert!(
        error.contains(told),
        "{arguments:?} gave {error:?}, wanted {told:?}"
    );
    assert!(output.stdout.is_empty());
}

/// The extreme numbers of the lab (`stability-extremes`) at the one door that it cannot reach.
#[test]
fn numbers_that_are_none_are_refused_by_every_command() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("p.csv"), "x,y\nnan,0\n").expect("written");
    std::fs::write(folder.path().join("t.csv"), "t,x,y,z\n0,1e400,0,0\n").expect("written");
    let of = |x: &str| {
        [
            ("run FIRST.toml --fast --script press --rate {}", x),
            ("run FIRST.toml --fast --script press --depth {}", x),
            ("run FIRST.toml --fast --script press --at {},0", x),
            ("run FIRST.toml --fast --script press --at 0,{}", x),
            ("deform FIRST.toml --press {},0,5", x),
            ("deform FIRST.toml --press 0,0,{}", x),
            ("deform FIRST.toml --press 0,0,5,{},0", x),
            ("partition back:900 --probe 0,{},0", x),
            ("partition back:900 --hdb-edge {}", x),
            ("partition back:900 --threshold {}", x),
            ("partition back:{}", x),
            ("mesh make --triangles {} --out m.ply", x),
            ("lab partition-complexity --triangles {}", x),
        ]
        .map(|(line, x)| line.replace("{}", x))
    };
    let lines = ["nan", "inf", "-inf", "1e400", "-1e400"]
        .into_iter()
        .flat_map(of);
    let files = [
        "map FIRST.toml --at p.csv",
        "run FIRST.toml --fast --path t.csv",
    ];
    for line in lines.chain(files.map(str::to_owned)) {
        let arguments: Vec<&str> = line.split(' ').collect();
        let output = dorsum(folder.path(), &arguments);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{line}: {error}");
        assert_eq!(error.trim_end().lines().count(), 1, "{line}: {error}");
        assert!(output.stdout.is_empty(), "{line}");
    }
}

const EXAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/scenarios/FIRST.toml");

#[test]
fn a_recorded_run_replays_bit_exactly() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = dorsum(
        folder.path(),
        &[
            "run", EXAMPLE, "--script", "slide", "--record", "a.mcap", "--fast", "--json",
        ],
    );
    let run = json(&run);
    assert!(
        run["summary"]["peak_force_n"].as_f64().expect("a number") > 0.5,
        "{run}"
    );
    assert!(
        run["summary"]["slip_s"].as_f64().expect("a number") > 0.1,
        "{run}"
    );
    assert_eq!(run["lost_ticks"], 0);
    let replay = dorsum(folder.path(), &["replay", "a.mcap", "--check"]);
    assert!(replay.status.success(), "{}", text(&replay.stderr));
    assert!(
        text(&replay.stdout).contains("bit-exact"),
        "{}",
        text(&replay.stdout)
    );
    json(&dorsum(
        folder.path(),
        &["replay", "a.mcap", "--check", "--json"],
    ));
}

#[test]
fn a_run_in_real_time_loses_no_tick_and_replays_bit_exactly() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = json(&dorsum(
        folder.path(),
        &[
            "run",
            "frictionless",
            "--script",
            "press",
            "--record",
            "a.mcap",
            "--json",
        ],
    ));
    assert_eq!(run["lost_ticks"], 0);
    assert_eq!(run["real_time"], true);
    assert!(run["summary"]["ticks"].as_u64().expect("a count") >= 2000);
    let replay = dorsum(folder.path(), &["replay", "a.mcap", "--check"]);
    assert!(
        replay.status.success(),
        "{}{}",
        text(&replay.stdout),
        text(&replay.stderr)
    );
}

#[test]
fn another_stiffness_fails_the_check_with_exit_code_1_and_says_where() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = std::fs::read_to_string(EXAMPLE)
        .expect("the example")
        .replace("= 1.05", "= 1.0500001");
    std::fs::write(folder.path().join("other.toml"), scenario).expect("written");
    let run = dorsum(
        folder.path(),
        &[
            "run", EXAMPLE, "--script", "press", "--at", "4,281", "--record", "a.mcap", "--fast",
        ],
    );
    assert!(run.status.success(), "{}", text(&run.stderr));
    let replay = dorsum(
        folder.path(),
        &["replay", "a.mcap", "--check", "--scenario", "other.toml"],
    );
    assert_eq!(
        replay.status.code(),
        Some(1),
        "{}{}",
        text(&replay.stdout),
        text(&replay.stderr)
    );
    let told = text(&replay.stdout);
    assert!(
        told.contains("tick") && told.contains("stiffness"),
        "{told}"
    );
}

#[test]
fn two_fingers_of_a_trajectory_are_both_felt() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut csv = String::from("t,x,y,z,finger\n");
    for (t, z) in [(0.0, 140.0), (0.4, 95.0), (0.8, 140.0)] {
        csv += &format!("{t},-30,260,{z},0\n{t},30,260,{z},1\n");
    }
    std::fs::write(folder.path().join("two.csv"), csv).expect("written");
    let run = json(&dorsum(
        folder.path(),
        &["run", EXAMPLE, "--path", "two.csv", "--fast", "--json"],
    ));
    assert_eq!(run["summary"]["fingers"], 2);
    assert!(
        run["summary"]["max_depth_mm"].as_f64().expect("a number") > 5.0,
        "{run}"
    );
}

/// Every named choice of how a scene is felt is in the scenario, so a recording of it replays bit for bit.
#[test]
fn every_engine_and_force_model_replays_bit_exactly_and_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let base = "format = 1\nname = \"n\"\nsurface = { builtin = \"back\", triangles = 1000 }\n\
        stiffness.constant_n_per_mm = 0.5\nfriction = { static = 0.46, dynamic = 0.44, skin_looseness = 1.3 }\n";
    for (tables, engine, force) in [
        (
            "contact = { engine = \"published\", partition = \"bsp\", case = \"B\", threshold = 50, hdb_part = 0.1 }",
            "published, bsp, case B, threshold 50, box 0.1 of the surface",
            "linear",
        ),
        (
            "contact.engine = \"published\"\nforce = { model = \"hunt-crossley\", exponent = 1.2 }",
            "published, octree, threshold 1024, box 0.25 of the surface",
            "hunt-crossley, damping 0.002 s/mm, exponent 1.2",
        ),
        (
            "force = { model = \"nonlinear\", trend_mm = 3 }",
            "production",
            "nonlinear, from 30.000 % of the stiffness, trend 3 mm",
        ),
    ] {
        let scenario = folder.path().join("s.toml");
        std::fs::write(&scenario, format!("{base}{tables}\n")).expect("written");
        let run = dorsum(
            folder.path(),
            &[
                "run",
                "s.toml",
                "--script",
                "slide",
                "--fast",
                "--record",
                "a.mcap",
                "--overwrite",
                "--json",
            ],
        );
        let run = json(&run);
        assert!(
            run["summary"]["peak_force_n"].as_f64().expect("a number") > 0.5,
            "{run}"
        );
        let replay = json(&dorsum(
            folder.path(),
            &["replay", "a.mcap", "--check", "--json"],
        ));
        assert_eq!(replay["bit_exact"], true, "{tables}");
        let told = json(&dorsum(folder.path(), &["scene", "s.toml", "--json"]));
        assert_eq!(told["engine"], engine);
        assert_eq!(told["force_model"], force);
        let rows = told["ledger"].as_array().expect("rows");
        let row = |name| rows.iter().find(|r| r["item"] == name).expect("a row");
        let pass = row("Published haptic pass");
        assert_eq!(pass["built"], engine != "production", "{pass}");
        let felt_by = |name| row(name)["cost_per"] == "tick";
        assert_eq!(felt_by("Published haptic pass"), engine != "production");
        assert_eq!(felt_by("Search structure"), engine == "production");
        assert_eq!(pass["build_us"].is_number(), engine != "production");
        assert_eq!(row("Force model")["built"], force != "linear");
    }
}

#[test]
fn the_ledger_leaves_out_what_a_frictionless_scene_does_not_need() {
    let folder = tempfile::tempdir().expect("a folder");
    let ledger = json(&dorsum(folder.path(), &["scene", "frictionless", "--json"]));
    let rows = ledger["ledger"].as_array().expect("rows");
    for row in rows {
        let built = ["Surface and adjacency", "Search structure"]
            .contains(&row["item"].as_str().expect("a name"));
        assert_eq!(row["built"], built, "{row}");
        assert_eq!(row["bytes"].as_u64().expect("a count") > 0, built, "{row}");
    }
}

#[test]
fn without_a_display_the_main_job_is_done_and_its_files_are_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = dorsum(folder.path(), &["--out", "made"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let why = if cfg!(feature = "gui") {
        "no display"
    } else {
        "no window"
    };
    let told = text(&output.stderr);
    assert!(told.contains(why), "{told}");
    assert!(
        text(&output.stdout).contains("bit-exact"),
        "{}",
        text(&output.stdout)
    );
    for ending in ["mcap", "svg", "png"] {
        let files = std::fs::read_dir(folder.path().join("made")).expect("a folder");
        let sizes = files
            .map(|f| f.expect("entry"))
            .filter(|f| f.path().extension().is_some_and(|e| e == ending))
            .map(|f| f.metadata().expect("metadata").len());
        assert!(
            sizes.max().unwrap_or(0) > 5_000,
            "no .{ending} worth the name"
        );
    }
}

#[test]
fn bad_usage_and_bad_input_are_one_line_and_exit_code_2() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("bad.toml"), "format = 1\nname = \"x\"\n[surface]\nbuiltin = \"front\"\n[stiffness]\nconstant_n_per_mm = 1\n")
        .expect("written");
    std::fs::write(folder.path().join("bad.csv"), "t,x,y,z\n0,0,0,none\n").expect("written");
    std::fs::write(folder.path().join("bad.mcap"), "not a session").expect("written");
    let folder = folder.path();
    assert_refused(folder, &["dance"], "dance");
    assert_refused(folder, &["run"], "required");
    assert_refused(folder, &["run", EXAMPLE], "--script");
    assert_refused(
        folder,
        &["run", EXAMPLE, "--script", "dance"],
        "allowed are press",
    );
    assert_refused(
        folder,
        &["run", EXAMPLE, "--script", "press", "--depth", "NaN"],
        "0 to 100 mm",
    );
    assert_refused(
        folder,
        &["run", EXAMPLE, "--script", "press", "--rate", "5"],
        "100 to 10000 Hz",
    );
    assert_refused(
        folder,
        &["run", EXAMPLE, "--script", "press", "--at", "1;2"],
        "two numbers",
    );
    assert_refused(
        folder,
        &["run", "missing.toml", "--script", "press"],
        "missing.toml",
    );
    assert_refused(
        folder,
        &["run", "bad.toml", "--script", "press"],
        "bad.toml: line 4: builtin",
    );
    assert_refused(
        folder,
        &["run", EXAMPLE, "--path", "bad.csv"],
        "bad.csv: line 2: z = \"none\"",
    );
    assert_refused(
        folder,
        &[
            "run",
            EXAMPLE,
            "--script",
            "press",
            "--record",
            "no/folder/a.mcap",
            "--fast",
        ],
        "no/folder",
    );
    assert_refused(
        folder,
        &[
            "run", EXAMPLE, "--script", "press", "--record", "bad.mcap", "--fast",
        ],
        "already there",
    );
    assert_refused(folder, &["replay", "bad.mcap"], "bad.mcap");
    assert_refused(folder, &["replay", "missing.mcap"], "missing.mcap");
    assert_refused(folder, &["scene", "bad.toml"], "line 4");
    assert_refused(folder, &["mesh", "info", "missing.obj"], "missing.obj");
    assert_eq!(
        std::fs::read(folder.join("bad.mcap")).expect("still there"),
        b"not a session"
    );
}
