//! `dorsum export`: what it prints, how it exits, and that others read what it wrote.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::geom::Vec3;
use dorsum::session::{
    DeviceInfo, Header, IfExists, MeshSource, Session, SessionWriter, Strictness,
};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn dorsum(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dorsum"));
    command.args(arguments).output().unwrap()
}

fn json(output: &Output) -> serde_json::Value {
    let error = String::from_utf8_lossy(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {error}"))
}

fn path_text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A second of pressing on the default scene, felt by the real tick.
fn pressed(folder: &Path) -> PathBuf {
    let path = folder.join("run.mcap");
    let run = dorsum(&[
        "run",
        "FIRST.toml",
        "--script",
        "press",
        "--fast",
        "--record",
        path_text(&path),
    ]);
    assert!(run.status.success());
    path
}

fn header(recorded: &Path, participant: &str, day: u32, fingers: usize) -> Header {
    let session = Session::open(recorded).unwrap();
    let device = DeviceInfo {
        name: "Test µ; \"quoted\"".into(),
        ..session.header().devices[0].clone()
    };
    Header {
        devices: vec![device; fingers],
        participant: Some(participant.into()),
        started_utc: format!("2031-05-{day:02}T09:30:00.125Z"),
        mesh: MeshSource {
            origin: "builtin:back".into(),
            ..session.header().mesh.clone()
        },
        ..session.header().clone()
    }
}

/// The recorded press as that of a participant with two fingers; numbers that test a writer of numbers among its ticks.
fn written(recorded: &Path, to: &Path, participant: &str, day: u32) {
    let header = header(recorded, participant, day, 2);
    let mut writer = SessionWriter::create(to, &header, IfExists::Refuse).unwrap();
    let session = Session::open(recorded).unwrap();
    for (i, tick) in session.ticks(Strictness::Strict).unwrap().enumerate() {
        let mut record = tick.unwrap().fingers[0];
        record.reading.velocity_mm_s = Vec3::new(-0.0, 5e-324, f64::MAX / f64::from(day));
        record.duration_us = 0.1 * i as f32;
        for finger in 0..2 {
            record.finger = finger;
            record.reading.position_mm.x += 0.1;
            writer.write(&record).unwrap();
        }
        if i == 100 {
            writer.event("mark", "here, \"this\" one; µ").unwrap();
        }
    }
    writer.finish().unwrap();
}

/// Three sessions of two participants.
fn cohort(folder: &Path) -> Vec<PathBuf> {
    let recorded = pressed(folder);
    let below = folder.join("recordings");
    std::fs::create_dir(&below).unwrap();
    let sessions = [("a", "P07", 1), ("b", "P07", 2), ("c d", "P08", 1)];
    let paths = sessions.map(|(name, participant, day)| {
        let path = below.join(format!("{name}.mcap"));
        written(&recorded, &path, participant, day);
        path
    });
    paths.to_vec()
}

fn sealed(folder: &Path, like: &Path) -> PathBuf {
    let path = folder.join("sealed.mcap");
    let header = Header {
        sealed: true,
        ..header(like, "P09", 3, 1)
    };
    let writer = SessionWriter::create(&path, &header, IfExists::Refuse).unwrap();
    writer.finish().unwrap();
    path
}

/// `DORSUM_PYTHON` names an interpreter that has what `tests/python/requirements.txt` names; `tests/run.sh` sets it.
fn python(script: &str, arguments: &[&str]) -> Option<serde_json::Value> {
    let Some(python) = std::env::var_os("DORSUM_PYTHON") else {
        eprintln!("skipped: DORSUM_PYTHON is not set (tests/run.sh sets it)");
        return None;
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/python")
        .join(script);
    let output = Command::new(python)
        .arg(script)
        .args(arguments)
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    Some(json(&output))
}

#[test]
fn a_folder_of_sessions_is_handed_on_and_python_reads_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let paths = cohort(folder.path());
    let [parquet, csv] = ["parquet", "csv"].map(|n| folder.path().join(n));
    let recordings = path_text(paths[0].parent().unwrap());
    for (option, out) in [("--parquet", &parquet), ("--csv", &csv)] {
        let output = dorsum(&["export", recordings, option, path_text(out), "--json"]);
        let told = json(&output);
        assert_eq!(output.status.code(), Some(0));
        assert_eq!((&told["exported"], &told["failed"]), (&3.into(), &0.into()));
        assert_eq!(told["rows"], 3 * 2 * 2001);
        assert_eq!(told["sessions"][2]["key"]["participant"], "P08");
        assert!(output.stderr.is_empty());
    }
    let again = dorsum(&["export", recordings, "--csv", path_text(&csv)]);
    let text = String::from_utf8(again.stdout).unwrap();
    assert!(text.contains("\nskipped              3 "), "{text}");
    let mut arguments = vec![path_text(&parquet), path_text(&csv)];
    arguments.extend(paths.iter().map(|p| path_text(p)));
    if let Some(told) = python("read_export.py", &arguments) {
        assert_eq!(told["sessions"], 3);
        assert_eq!(told["ticks"], 3 * 2 * 2001);
        assert_eq!(told["events"], 3);
    }
}

#[test]
fn a_bids_dataset_is_one_by_its_schema_and_validator() {
    let folder = tempfile::tempdir().unwrap();
    let paths = cohort(folder.path());
    let out = folder.path().join("bids");
    let recordings = path_text(paths[0].parent().unwrap());
    let output = dorsum(&["export", recordings, "--bids", path_text(&out)]);
    assert_eq!(output.status.code(), Some(0));
    assert!(out.join("participants.tsv").exists());
    if let Some(told) = python("check_bids.py", &[path_text(&out)]) {
        assert_eq!(told["sessions"], 3);
        if told["validator"].is_null() {
            eprintln!(
                "the BIDS validator did not run; the schema was held against the dataset all the same"
            );
        } else {
            assert_eq!(told["validator"]["errors"], serde_json::json!([]));
        }
    }
}

#[test]
fn many_processes_fill_one_folder_as_one_process_does() {
    let folder = tempfile::tempdir().unwrap();
    let paths = cohort(folder.path());
    let (recordings, by_many) = (paths[0].parent().unwrap(), folder.path().join("many"));
    sealed(recordings, &folder.path().join("run.mcap"));
    let arguments = [
        env!("CARGO_BIN_EXE_dorsum"),
        path_text(recordings),
        path_text(&by_many),
        "2",
    ];
    let Some(told) = python("cohort.py", &arguments) else {
        return;
    };
    assert_eq!(told["files"], 4);
    assert_eq!(told["refused"].as_object().map(|r| r.len()), Some(1));
    let pressed = &told["answers"]["how hard each participant pressed"];
    assert_eq!(pressed[0]["participant"], "P07");
    assert_eq!(
        (&pressed[0]["sessions"], &pressed[1]["sessions"]),
        (&2.into(), &1.into())
    );
    assert!(
        dorsum(&["export", "--parquet", path_text(&by_many)])
            .status
            .success()
    );
    let by_one = folder.path().join("one");
    dorsum(&[
        "export",
        path_text(recordings),
        "--parquet",
        path_text(&by_one),
        "--jobs",
        "3",
    ]);
    for table in ["sessions", "measures", "events", "felt"] {
        let [a, b] =
            [&by_many, &by_one].map(|f| std::fs::read(f.join(table).with_extension("parquet")));
        assert!(a.unwrap() == b.unwrap(), "{table} differs");
    }
}

#[test]
fn bad_input_is_one_line_and_does_not_stop_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let good = pressed(folder.path());
    let sealed = sealed(folder.path(), &good);
    let broken = folder.path().join("broken.mcap");
    std::fs::write(&broken, "no session").unwrap();
    let out = folder.path().join("out");
    let [good, sealed, broken, out] = [&good, &sealed, &broken, &out].map(|p| path_text(p));
    let cases: [(&[&str], &str); 5] = [
        (&["export", sealed, "--parquet", out], "stays sealed"),
        (&["export", broken, "--csv", out], "broken.mcap"),
        (&["export", good], "--parquet"),
        (
            &["export", good, "--csv", out, "--bids", out],
            "cannot be used with",
        ),
        (
            &["export", "--csv", &format!("{out}/none")],
            "holds nothing yet",
        ),
    ];
    for (case, expected) in cases {
        let output = dorsum(case);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{case:?}: {error}");
        assert_eq!(error.trim_end().lines().count(), 1, "{error}");
        assert!(error.contains(expected), "{error}");
        assert!(output.stdout.is_empty());
    }
    // A sealed one among others is counted, a broken one told at the end.
    let output = dorsum(&["export", sealed, good, "--parquet", out]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("\nsealed               1 "), "{text}");
    let output = dorsum(&[
        "export",
        broken,
        good,
        sealed,
        "--parquet",
        out,
        "--force",
        "--json",
    ]);
    assert_eq!(output.status.code(), Some(2));
    let told = json(&output);
    assert_eq!((&told["exported"], &told["sealed"]), (&1.into(), &1.into()));
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(
        error.contains("1 of 3 sessions were not handed on; ") && error.contains("broken.mcap"),
        "{error}"
    );
}

/// What a killed export leaves is never taken for a whole session, and the next run completes it.
#[test]
fn a_killed_export_is_completed_by_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let paths = cohort(folder.path());
    let recordings = path_text(paths[0].parent().unwrap());
    let whole = folder.path().join("whole");
    assert!(
        dorsum(&["export", recordings, "--parquet", path_text(&whole)])
            .status
            .success()
    );
    for wait_ms in [0, 20, 60, 120, 200] {
        let out = folder.path().join(format!("killed-{wait_ms}"));
        let mut child = Command::new(env!("CARGO_BIN_EXE_dorsum"))
            .args(["export", recordings, "--parquet", path_text(&out)])
            .stdout(std::process::Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_millis(wait_ms));
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(
            dorsum(&["export", recordings, "--parquet", path_text(&out)])
                .status
                .success()
        );
        for table in ["sessions", "measures", "events", "felt"] {
            let [a, b] =
                [&whole, &out].map(|f| std::fs::read(f.join(table).with_extension("parquet")));
            assert!(a.unwrap() == b.unwrap(), "{table} after {wait_ms} ms");
        }
    }
}
