//! Edits from the window: drawn, felt, recorded, replayed, saved.
#![cfg(feature = "gui")]
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

mod support;

use dorsum::app::bench::Source;
use dorsum::app::command::{Action, Command};
use dorsum::contact::Touch;
use dorsum::scenario::{self, Scenario, Scene, Use};
use dorsum::servo::Rig;
use dorsum::session::{Edit, Session, Strictness, check_edited};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use support::{Window, said, view, wait_for, workbench};

const FLAT: &str = "format = 1\nname = \"Flat\"\n[surface]\nbuiltin = \"back\"\ntriangles = 2962\n\
                    [stiffness]\nconstant_n_per_mm = 0.35\n[friction]\nstatic = 0.46\ndynamic = 0.44\n";

fn with_stiffness(n_per_mm: f64) -> String {
    FLAT.replace("0.35", &n_per_mm.to_string())
}

/// A window with the scene of `FLAT` from a file.
fn opened(folder: &Path) -> (Window, PathBuf) {
    let path = folder.join("flat.toml");
    std::fs::write(&path, FLAT).unwrap();
    let mut harness = workbench(folder.to_owned());
    open(&mut harness, &path);
    (harness, path)
}

fn open(harness: &mut Window, path: &Path) {
    let before = view(harness.state()).scene_generation;
    harness
        .state_mut()
        .shared()
        .bench()
        .open(Source::File(path.to_owned()));
    wait_for(harness, "the scene", |w| view(w).scene_generation > before);
}

fn send(harness: &mut Window, command: Command) {
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, command);
}

fn edit(harness: &mut Window, source: String) {
    send(harness, Command::EditScene { source });
}

/// Waits until the scene drawn is the edited one and the finger wholly feels it.
fn felt(harness: &mut Window, n_per_mm: f64) {
    wait_for(harness, "the edit", |w| {
        let v = view(w);
        v.live.fade == 1.0 && {
            let f = &v.live.record.fingers[1].contact;
            f.touch != Touch::Free && (f.stiffness_n_per_mm - n_per_mm).abs() < 1e-12
        }
    });
}

fn press(harness: &mut Window) {
    let (point, normal) = support::place();
    let hand = view(harness.state()).hands[1].clone();
    hand.set(point + normal * 20.0);
    std::thread::sleep(std::time::Duration::from_millis(300));
    hand.set(point - normal * 8.0);
    wait_for(harness, "contact", |w| {
        view(w).live.record.fingers[1].contact.touch != Touch::Free
    });
}

fn toggle_recording(harness: &mut Window, on: bool) {
    send(harness, Command::Do(Action::Record));
    wait_for(harness, "the recorder", |w| {
        let recorder = view(w).recorder;
        recorder.recording.is_some() == on && (on || !recorder.recent.is_empty())
    });
}

#[test]
fn an_edit_is_drawn_felt_recorded_and_replayed() {
    let folder = tempfile::tempdir().unwrap();
    let (mut harness, _) = opened(folder.path());
    press(&mut harness);
    // One edit before the recording begins: its scenario is the one in the header.
    edit(&mut harness, with_stiffness(0.5));
    felt(&mut harness, 0.5);
    toggle_recording(&mut harness, true);
    let generation = view(harness.state()).scene_generation;
    let before = view(harness.state());
    for k in [0.9, 0.7, 1.2] {
        edit(&mut harness, with_stiffness(k));
        felt(&mut harness, k);
    }
    let after = view(harness.state());
    assert_eq!(after.scene_generation, generation);
    assert_eq!(after.edit, before.edit + 3);
    let (old, new) = (before.scene.unwrap(), after.scene.unwrap());
    assert!(Arc::ptr_eq(&old.surface, &new.surface) && !Arc::ptr_eq(&old, &new));
    assert_eq!(new.scenario.source, with_stiffness(1.2));
    toggle_recording(&mut harness, false);

    let path = view(harness.state()).recorder.recent[0].path.clone();
    let session = Session::open(&path).unwrap();
    assert_eq!(session.header().edit, 1);
    assert_eq!(session.header().scenario_toml, with_stiffness(0.5));
    let built = |text: &str| -> Scene {
        let scenario = Scenario::parse(text, "recorded", None).unwrap();
        scenario::build(Arc::new(scenario), Use::default(), &mut |_, _| true).unwrap()
    };
    let first = built(&session.header().scenario_toml);
    let rig = Rig::new(Box::new(first.touch.clone()), session.header().limits());
    let rebuild = |e: &Edit| Ok(built(&e.scenario_toml).touch);
    let report = check_edited(
        &session,
        rig,
        Box::new(rebuild),
        Strictness::Strict,
        |_, _| (),
    );
    let report = report.unwrap();
    assert!(report.is_bit_exact(), "{:?}", report.first_difference);
    assert_eq!(report.passed.edits, 3);

    // On show: the scene is that of the instant, and live goes on with its own.
    let bench = |harness: &mut Window, act: &dyn Fn(&mut dorsum::app::bench::Bench)| {
        act(&mut harness.state_mut().shared().bench());
    };
    send(&mut harness, Command::OpenRecording(path));
    wait_for(&mut harness, "the recording", |w| {
        view(w).playback.is_some()
    });
    bench(&mut harness, &|b| b.set_playing(false));
    let length_s = view(harness.state()).playback.unwrap().duration_s;
    for (at_s, k) in [(length_s, 1.2), (0.0, 0.5), (length_s, 1.2)] {
        bench(&mut harness, &|b| b.seek(at_s));
        wait_for(&mut harness, "the scene of the instant", |w| {
            view(w).scene.unwrap().scenario.source == with_stiffness(k)
        });
    }
    // There it cannot be edited.
    edit(&mut harness, with_stiffness(2.0));
    assert!(
        said(harness.state())
            .last()
            .unwrap()
            .contains("back to live")
    );
    bench(&mut harness, &|b| b.close_recording());
    felt(&mut harness, 1.2);
}

#[test]
fn what_cannot_be_edited_is_told_and_the_scene_stays() {
    let folder = tempfile::tempdir().unwrap();
    let (mut harness, _) = opened(folder.path());
    let before = view(harness.state());
    for (source, told) in [
        (with_stiffness(-1.0), "line 7: constant_n_per_mm = -1"),
        (FLAT.replace("2962", "4000"), "[surface] cannot be edited"),
        (FLAT.replace("0.46", "0.47"), "[friction] cannot be edited"),
        (
            format!("{FLAT}[force]\nmodel = \"exponential\"\n"),
            "[force] cannot be edited",
        ),
        (
            format!("{FLAT}[contact]\nfinger_radius_mm = 5.0\n"),
            "[contact] cannot be edited",
        ),
    ] {
        edit(&mut harness, source);
        wait_for(&mut harness, told, |w| {
            said(w).last().is_some_and(|m| m.contains(told))
        });
    }
    let after = view(harness.state());
    assert!(Arc::ptr_eq(&before.scene.unwrap(), &after.scene.unwrap()));
    assert_eq!((after.edit, after.unsaved), (before.edit, false));
    assert_eq!(after.live.edit, 0);
}

#[test]
fn of_many_edits_the_newest_is_felt() {
    let folder = tempfile::tempdir().unwrap();
    let (mut harness, _) = opened(folder.path());
    press(&mut harness);
    for i in 0..60 {
        edit(&mut harness, with_stiffness(0.4 + 0.01 * f64::from(i)));
        harness.run_steps(1);
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    felt(&mut harness, 0.4 + 0.01 * 59.0);
    let v = view(harness.state());
    assert!(
        v.live.edit < 40,
        "each of {} edits takes 64 ticks",
        v.live.edit
    );
}

#[test]
fn an_edited_scene_is_saved_to_its_file_and_what_is_not_saved_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let (mut harness, path) = opened(folder.path());
    assert!(!view(harness.state()).unsaved);
    let edited = |harness: &mut Window, k: f64| {
        let before = view(harness.state()).edit;
        edit(harness, with_stiffness(k));
        wait_for(harness, "the edit", |w| view(w).edit > before);
        assert!(view(harness.state()).unsaved);
    };
    edited(&mut harness, 0.6);
    send(&mut harness, Command::Do(Action::SaveScenario));
    wait_for(&mut harness, "the file", |w| !view(w).unsaved);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), with_stiffness(0.6));

    edited(&mut harness, 0.8);
    let copy = folder.path().join("copy");
    let save_as = |path: PathBuf| Command::SaveScenarioAs {
        path,
        replace: false,
    };
    send(&mut harness, save_as(copy));
    wait_for(&mut harness, "the copy", |w| !view(w).unsaved);
    let copy = folder.path().join("copy.toml");
    assert_eq!(std::fs::read_to_string(&copy).unwrap(), with_stiffness(0.8));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), with_stiffness(0.6));
    let bench = harness.state().shared().clone();
    assert_eq!(bench.bench().scenario_path(), Some(copy.as_path()));

    // Another file that is there is not replaced unasked.
    let other = folder.path().join("other.toml");
    std::fs::write(&other, "words").unwrap();
    send(&mut harness, save_as(other.clone()));
    assert!(
        said(harness.state())
            .last()
            .unwrap()
            .contains("there already")
    );
    assert_eq!(std::fs::read_to_string(&other).unwrap(), "words");

    // Someone else writes to it: their words are not lost.
    edited(&mut harness, 0.9);
    std::fs::write(&copy, FLAT).unwrap();
    send(&mut harness, Command::Do(Action::SaveScenario));
    wait_for(&mut harness, "the refusal", |w| {
        said(w).last().is_some_and(|m| m.contains("someone else"))
    });
    assert_eq!(std::fs::read_to_string(&copy).unwrap(), FLAT);

    // Another scene opens: the edit is kept beside the recordings, and told.
    open(&mut harness, &path);
    assert!(
        said(harness.state())
            .iter()
            .any(|m| m.contains("were not saved"))
    );
    let kept: Vec<_> = std::fs::read_dir(folder.path().join("unsaved"))
        .unwrap()
        .collect();
    assert_eq!(kept.len(), 1);
    let kept = kept.into_iter().next().unwrap().unwrap().path();
    assert_eq!(std::fs::read_to_string(kept).unwrap(), with_stiffness(0.9));
    assert!(!view(harness.state()).unsaved);
}
