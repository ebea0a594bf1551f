//! `dorsum replay`: what it prints and how it exits.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::scenario::{self, Scenario, Use};
use dorsum::servo::FingerRecord;
use dorsum::servo::{Rig, tick};
use dorsum::session::{Entry, IfExists, Session, SessionWriter, Strictness, input_of};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Arc;

fn dorsum(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dorsum"));
    command.args(arguments).output().unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// A second of pressing on the default scene.
fn recorded(folder: &Path) -> PathBuf {
    let path = folder.join("a.mcap");
    let text = path.to_str().unwrap();
    let run = dorsum(&[
        "run",
        "FIRST.toml",
        "--script",
        "press",
        "--fast",
        "--record",
        text,
    ]);
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    path
}

#[test]
fn a_run_with_the_passivity_controller_says_so_and_is_bit_exact() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let text = path.to_str().unwrap();
    let run = dorsum(&[
        "run",
        "FIRST.toml",
        "--script",
        "tap",
        "--fast",
        "--passivity",
        "--record",
        text,
        "--json",
    ]);
    let printed: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    assert_eq!(printed["passivity"], true);
    let session = Session::open(&path).unwrap();
    assert!(session.header().devices[0].passivity);
    let recording = session.load(Strictness::Strict).unwrap();
    let owed = |r: &&FingerRecord| r.passivity_energy_n_mm < 0.0;
    assert!(recording.fingers[0].iter().filter(owed).count() > 10);
    let output = dorsum(&["replay", text, "--check"]);
    assert!(output.status.success());
}

/// The same session with one record changed.
fn rewritten(from: &Path, to: &Path, change: impl Fn(&mut FingerRecord)) {
    let session = Session::open(from).unwrap();
    let mut writer = SessionWriter::create(to, session.header(), IfExists::Refuse).unwrap();
    for entry in session.entries(Strictness::Strict).unwrap() {
        if let Entry::Tick(mut record) = entry.unwrap() {
            change(&mut record);
            writer.write(&record).unwrap();
        }
    }
    writer.finish().unwrap();
}

#[test]
fn a_recorded_run_is_bit_exact_and_a_changed_one_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = recorded(folder.path());
    let output = dorsum(&["replay", path.to_str().unwrap(), "--check"]);
    let text = stdout(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert_eq!(
        text.lines().last(),
        Some("bit-exact: 2001 ticks of 1 finger")
    );
    assert!(output.stderr.is_empty());

    let changed = folder.path().join("changed.mcap");
    rewritten(&path, &changed, |r| {
        if r.tick == 1000 {
            r.contact.anchor_mm.x = f64::from_bits(r.contact.anchor_mm.x.to_bits() ^ 1);
        }
    });
    let output = dorsum(&["replay", changed.to_str().unwrap(), "--check"]);
    let text = stdout(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(
        text.contains("not bit-exact: tick 1000, finger 0, anchor_mm.x: recorded "),
        "{text}"
    );
    assert_eq!(
        dorsum(&["replay", changed.to_str().unwrap()]).status.code(),
        Some(0)
    );
}

#[test]
fn json_is_one_document_with_the_same_answer() {
    let folder = tempfile::tempdir().unwrap();
    let path = recorded(folder.path());
    let output = dorsum(&["replay", path.to_str().unwrap(), "--check", "--json"]);
    let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["bit_exact"], true);
    assert_eq!(document["replay"]["ticks"], 2001);
    assert_eq!(
        document["replay"]["first_difference"],
        serde_json::Value::Null
    );
    assert_eq!(document["summary"]["ticks"], 2001);
    assert_eq!(document["surface"], "builtin:back");
}

#[test]
fn a_cut_recording_is_replayed_as_far_as_it_goes() {
    let folder = tempfile::tempdir().unwrap();
    let path = recorded(folder.path());
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() * 3 / 4]).unwrap();
    let output = dorsum(&["replay", path.to_str().unwrap(), "--check"]);
    let text = stdout(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(
        text.contains("\nunfinished ") && text.contains("\nbit-exact: "),
        "{text}"
    );
}

#[test]
fn bad_input_is_one_line_and_exit_code_2() {
    let folder = tempfile::tempdir().unwrap();
    let path = recorded(folder.path());
    let missing = folder.path().join("missing.mcap");
    let scenario = folder.path().join("missing.toml");
    let other = folder.path().join("other.toml");
    let session = Session::open(&path).unwrap();
    let coarser = |line: &str| match line.strip_prefix("triangles = ") {
        Some(_) => "triangles = 2962".to_owned(),
        None => line.to_owned(),
    };
    let lines = session.header().scenario_toml.lines().map(coarser);
    std::fs::write(&other, lines.collect::<Vec<_>>().join("\n")).unwrap();
    let [path, missing, scenario, other] =
        [&path, &missing, &scenario, &other].map(|p| p.to_str().unwrap());
    let cases: [&[&str]; 4] = [
        &["replay", missing],
        &["replay", path, "--scenario", scenario],
        &["replay", path, "--scenario", other],
        &["replay"],
    ];
    for case in cases {
        let output = dorsum(case);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{case:?}: {error}");
        assert_eq!(error.trim_end().lines().count(), 1, "{error}");
        assert!(output.stdout.is_empty());
    }
    let output = dorsum(&["replay", path, "--scenario", other]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(error.contains("recorded on surface"), "{error}");
}

/// All stiffness twice as high.
fn twice_as_stiff(first: &Scenario) -> String {
    let keys = first
        .stiffness_keys
        .iter()
        .map(|k| dorsum::maps::StiffnessKey {
            stiffness_n_per_mm: 2.0 * k.stiffness_n_per_mm,
            ..*k
        });
    let keys: Vec<_> = keys.collect();
    scenario::edit::with_stiffness(&first.source, &keys, first.stiffness_fit, &[]).unwrap()
}

/// The recorded run with an edit of the scene in the middle of it; `told`: its text is in the file.
fn edited(from: &Path, to: &Path, told: bool, edit: impl Fn(&Scenario) -> String) {
    let session = Session::open(from).unwrap();
    let header = session.header();
    let parsed = |text: &str| Arc::new(Scenario::parse(text, "a.toml", None).unwrap());
    let first = parsed(&header.scenario_toml);
    let scene = scenario::build(Arc::clone(&first), Use::default(), &mut |_, _| true).unwrap();
    let text = edit(&first);
    let after = scenario::rebuild(&scene, parsed(&text), Use::default()).unwrap();
    let mut rig = Rig::new(Box::new(scene.touch.clone()), header.limits());
    let mut writer = SessionWriter::create(to, header, IfExists::Refuse).unwrap();
    for (i, recorded) in session.ticks(Strictness::Strict).unwrap().enumerate() {
        if i == 1000 {
            if told {
                writer.edit(1, &text.as_str().into()).unwrap();
            }
            drop(rig.edit_scene(1, Box::new(after.touch.clone())));
        }
        let out = tick(&mut rig, &input_of(&recorded.unwrap()), header.dt_s());
        for finger in out.fingers() {
            writer.write(finger).unwrap();
        }
    }
    writer.finish().unwrap();
}

#[test]
fn a_run_with_an_edit_is_bit_exact_and_one_without_its_text_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = recorded(folder.path());
    let [with, without] = ["with.mcap", "without.mcap"].map(|n| folder.path().join(n));
    edited(&path, &with, true, twice_as_stiff);
    let output = dorsum(&["replay", with.to_str().unwrap(), "--check"]);
    let text = stdout(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    let last = text.lines().last();
    assert_eq!(last, Some("bit-exact: 2001 ticks of 1 finger"));
    assert!(
        text.contains("\nedits                1 of the scene"),
        "{text}"
    );

    edited(&path, &without, false, twice_as_stiff);
    let output = dorsum(&["replay", without.to_str().unwrap(), "--check"]);
    let text = stdout(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    let told = text.lines().find(|l| l.starts_with("not repeated"));
    let told = told.unwrap();
    assert!(
        told.contains(" 1001 ticks; ") && told.contains("tick 1000 was felt after edit 1"),
        "{told}"
    );
    assert!(
        text.ends_with("bit-exact: 1000 ticks of 1 finger\n"),
        "{text}"
    );
}

/// A finger slides over a bump that is stiffer, drags more and hurts; on its way the dysfunction changes.
#[test]
fn a_run_over_dysfunctions_with_an_edit_of_them_is_bit_exact() {
    let folder = tempfile::tempdir().unwrap();
    let [file, plain, changed] =
        ["s.toml", "plain.mcap", "changed.mcap"].map(|n| folder.path().join(n));
    std::fs::write(
        &file,
        "format = 1\nname = \"Rough\"\n[surface]\nbuiltin = \"back\"\ntriangles = 2962\n\
         [stiffness]\nconstant_n_per_mm = 0.4\n[[dysfunction]]\nkind = \"hypertonic\"\nat_mm = [30, 250]\n\
         radius_mm = [90, 90]\nskin_drag = 1.8\nbump_mm = 4\ntender_above_n = 2\nseed = 5\n\
         [friction]\nstatic = 0.46\ndynamic = 0.44\n",
    )
    .unwrap();
    let [from, out] = [&file, &plain].map(|p| p.to_str().unwrap());
    let run = dorsum(&["run", from, "--script", "slide", "--fast", "--record", out]);
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    let output = dorsum(&["replay", out, "--check"]);
    assert_eq!(output.status.code(), Some(0), "{}", stdout(&output));

    edited(&plain, &changed, true, |first| {
        let mut list = first.dysfunctions.clone();
        list[0].skin_drag = Some(0.6);
        list[0].change = Some(scenario::Change::StiffnessPercent(-40.0));
        first.with_dysfunctions(&list).unwrap().source
    });
    let output = dorsum(&["replay", changed.to_str().unwrap(), "--check"]);
    let text = stdout(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(
        text.contains("\nedits                1 of the scene"),
        "{text}"
    );
    // It was felt: sideways force over normal force, where both runs slip well after the edit.
    let drag = |path: &Path| {
        let recording = Session::open(path)
            .unwrap()
            .load(Strictness::Strict)
            .unwrap();
        let slips = recording.fingers[0].iter().skip(1500);
        let slips = slips.filter(|r| r.contact.touch == dorsum::contact::Touch::Slip);
        let shares: Vec<f64> = slips
            .map(|r| {
                let normal = r.contact.force_n.dot(r.contact.normal);
                (r.contact.force_n - r.contact.normal * normal).length() / normal
            })
            .collect();
        assert!(shares.len() > 200, "{}", shares.len());
        shares.iter().sum::<f64>() / shares.len() as f64
    };
    let (before, after) = (drag(&plain), drag(&changed));
    assert!(before > 0.5 && after < 0.4, "{before} {after}");
}

#[test]
fn what_a_cut_file_holds_is_saved_counted_and_still_bit_exact() {
    let folder = tempfile::tempdir().unwrap();
    let path = recorded(folder.path());
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() * 3 / 4]).unwrap();
    let out = folder.path().join("saved.mcap");
    let [broken, saved] = [&path, &out].map(|p| p.to_str().unwrap());
    let output = dorsum(&["recover", broken, saved, "--json"]);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["whole"], false);
    assert_eq!(report["damage"]["unfinished"], true);
    let session = Session::open(&out).unwrap();
    let ticks = session.ticks(Strictness::Strict).unwrap();
    let ticks = ticks.map(|t| t.unwrap().fingers[0].tick);
    let ticks: Vec<u64> = ticks.collect();
    assert_eq!(report["ticks"], ticks.len());
    // From the start on, none left out in between.
    assert_eq!(
        ticks,
        (ticks[0]..=*ticks.last().unwrap()).collect::<Vec<_>>()
    );
    // Three quarters of 2001, less what stood in the chunk that was cut.
    assert!(ticks.len() > 500, "{}", ticks.len());
    let output = dorsum(&["replay", saved, "--check"]);
    assert_eq!(output.status.code(), Some(0), "{}", stdout(&output));
    // Nothing is replaced unasked.
    let before = std::fs::read(&out).unwrap();
    assert_eq!(dorsum(&["recover", broken, saved]).status.code(), Some(2));
    assert_eq!(std::fs::read(&out).unwrap(), before);
}

#[test]
fn on_a_skin_twice_as_stiff_a_frictionless_press_is_twice_as_strong() {
    let folder = tempfile::tempdir().unwrap();
    let scene = |stiffness_n_per_mm: f64| {
        let path = folder.path().join(format!("{stiffness_n_per_mm}.toml"));
        let text = format!(
            "format = 1\nname = \"Test\"\n[surface]\nbuiltin = \"back\"\ntriangles = 2962\n\
             [stiffness]\nconstant_n_per_mm = {stiffness_n_per_mm}\n"
        );
        std::fs::write(&path, text).unwrap();
        path
    };
    let [soft, stiffer] = [scene(0.3), scene(0.6)];
    let path = folder.path().join("a.mcap");
    let [soft, to] = [&soft, &path].map(|p| p.to_str().unwrap());
    let run = dorsum(&["run", soft, "--script", "press", "--fast", "--record", to]);
    assert!(run.status.success(), "{run:?}");
    let table = folder.path().join("off.csv");
    let [path, stiffer, table] = [&path, &stiffer, &table].map(|p| p.to_str().unwrap());
    let arguments = ["replay", path, "--scenario", stiffer, "--difference", table];
    let output = dorsum(&arguments);
    assert!(output.status.success(), "{output:?}");
    let mut rows = csv::Reader::from_path(table).unwrap();
    let head = rows.headers().unwrap().clone();
    let column = |name: &str| head.iter().position(|h| h == name).unwrap();
    let (depth, axes) = (
        column("depth_mm"),
        ["force_x_n", "force_y_n", "force_z_n"].map(column),
    );
    let session = Session::open(Path::new(path)).unwrap();
    let ticks = session.ticks(Strictness::Strict).unwrap();
    let mut pressed = 0;
    // The first tick is what the repetition starts from.
    for (row, tick) in rows.records().map(Result::unwrap).zip(ticks.skip(1)) {
        let recorded = tick.unwrap().fingers[0];
        assert_eq!(row[column("tick")], recorded.tick.to_string());
        let value = |i: usize| row[i].parse::<f64>().unwrap();
        // The proxy does not know how stiff the skin is: same depth, and a difference as large as the force itself.
        assert!(value(depth).abs() < 1e-9, "tick {}", recorded.tick);
        for (axis, force_n) in axes.into_iter().zip(recorded.contact.force_n.to_array()) {
            let off = value(axis) - force_n;
            assert!(off.abs() < 1e-9, "tick {}: {off} N", recorded.tick);
        }
        pressed += usize::from(recorded.contact.force_n.length() > 0.5);
    }
    assert!(pressed > 100, "{pressed}");
    // A table that is there is not replaced unasked.
    assert_eq!(dorsum(&arguments).status.code(), Some(2));
}
