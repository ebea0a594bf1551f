//! The window driven by its accessibility tree, as a person with a screen reader would: no display, no GPU.
#![cfg(feature = "gui")]

mod support;

use dorsum::app::command::{Action, Command};
use dorsum::contact::Touch;
use dorsum::scenario::{self, Scenario, Use};
use dorsum::servo::Rig;
use dorsum::session::{Session, Strictness, check};
use egui_kittest::kittest::Queryable;
use std::sync::Arc;
use support::{Window, said, view, wait_for, workbench};

fn click(harness: &mut Window, name: &str) {
    harness.get_by_label(name).click();
    harness.run_steps(3);
}

/// Presses the right finger 8 mm into the skin and waits until it feels it.
fn press(harness: &mut Window) {
    let (point, normal) = support::place();
    let hand = view(harness.state()).hands[1].clone();
    hand.set(point + normal * 5.0);
    std::thread::sleep(std::time::Duration::from_millis(300));
    hand.set(point - normal * 8.0);
    wait_for(harness, "contact", |w| {
        view(w).live.record.fingers[1].contact.touch != Touch::Free
    });
}

#[test]
fn a_session_is_opened_recorded_pressed_stopped_and_replayed() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = workbench(folder.path().to_owned());

    click(&mut harness, "Record");
    wait_for(&mut harness, "recording", |w| {
        view(w).recorder.recording.is_some()
    });
    harness.get_by_label("Recording");
    press(&mut harness);
    std::thread::sleep(std::time::Duration::from_millis(300));
    click(&mut harness, "Stop");
    wait_for(&mut harness, "the end of the recording", |w| {
        view(w).recorder.recording.is_none() && !view(w).recorder.recent.is_empty()
    });

    let file = view(harness.state()).recorder.recent[0].path.clone();
    let name = file
        .file_name()
        .expect("a name")
        .to_string_lossy()
        .into_owned();
    click(&mut harness, &format!("Replay {name}"));
    wait_for(&mut harness, "replay", |w| view(w).playback.is_some());
    let playback = view(harness.state()).playback.expect("open");
    assert!(playback.duration_s > 0.5, "{playback:?}");

    // Whatever is shown now is the recording: at its end the finger is in the skin.
    harness.state_mut().shared().bench().set_playing(false);
    harness
        .state_mut()
        .shared()
        .bench()
        .seek(playback.duration_s);
    harness.run_steps(2);
    let felt = view(harness.state());
    assert_ne!(felt.fingers[1].contact.touch, Touch::Free);
    assert!(felt.fingers[1].sent_force_n.length() > 0.1);
    let last_tick = felt.fingers[1].tick;
    click(&mut harness, "Step back");
    assert_eq!(view(harness.state()).fingers[1].tick, last_tick - 1);

    click(&mut harness, "Back to live");
    wait_for(&mut harness, "live", |w| view(w).playback.is_none());
    harness.get_by_label("Record");
}

#[test]
fn a_recording_ends_with_its_scene_and_replays_bit_for_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = workbench(folder.path().to_owned());
    click(&mut harness, "Record");
    wait_for(&mut harness, "recording", |w| {
        view(w).recorder.recording.is_some()
    });
    press(&mut harness);
    let scene_before = view(harness.state()).live.scene_generation;
    let other = "frictionless.toml";
    harness.state_mut().shared().bench().open_example(other);
    wait_for(&mut harness, "the other scene", |w| {
        view(w).live.scene_generation != scene_before
    });
    let recorder = view(harness.state()).recorder;
    assert!(recorder.recording.is_none());

    let session = Session::open(&recorder.recent[0].path).expect("a session");
    let header = session.header();
    let scenario = Scenario::parse(&header.scenario_toml, "recorded", None).expect("parses");
    let scene = scenario::build(Arc::new(scenario), Use::default(), &mut |_, _| true);
    let touch = scene.expect("builds").touch;
    let rig = Rig::new(Box::new(touch), header.limits());
    let report = check(&session, rig, Strictness::Strict).expect("readable");
    assert!(report.is_bit_exact(), "{:?}", report.first_difference);
    assert!(report.ticks > 200 && report.passed.gaps == 0, "{report:?}");
}

#[test]
fn a_panel_pops_out_and_comes_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = workbench(folder.path().to_owned());
    click(&mut harness, "Pop out Plots");
    assert!(harness.state().layout().is_popped("plots"));
    assert!(
        harness
            .query_by_label("Plots")
            .is_none_or(|tab| { tab.rect().width() > 0.0 })
    );
    click(&mut harness, "Dock back Plots");
    assert!(!harness.state().layout().is_popped("plots"));
    assert!(harness.state().layout().is_shown("plots"));
}

#[test]
fn a_closed_panel_is_one_click_away() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = workbench(folder.path().to_owned());
    click(&mut harness, "Close Plots");
    assert!(harness.state().layout().is_closed("plots"));
    click(&mut harness, "Open Plots");
    assert!(harness.state().layout().is_shown("plots"));
    click(&mut harness, "Timing");
    assert!(harness.state().layout().is_shown("timing"));
}

#[test]
fn escape_stops_force_whatever_is_open_and_a_button_allows_it_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = workbench(folder.path().to_owned());
    click(&mut harness, "File");
    harness.key_press(egui::Key::Escape);
    harness.run_steps(3);
    assert!(!view(harness.state()).force_enabled);
    wait_for(&mut harness, "the servo", |w| !view(w).live.force_enabled);
    press(&mut harness);
    assert_eq!(
        view(harness.state()).live.record.fingers[1]
            .sent_force_n
            .length(),
        0.0
    );
    click(&mut harness, "Allow force");
    wait_for(&mut harness, "force", |w| {
        view(w).live.record.fingers[1].sent_force_n.length() > 0.1
    });
}

#[test]
fn another_scenario_opens_and_a_bad_one_is_told_and_changes_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = workbench(folder.path().to_owned());
    let first = view(harness.state()).scene_generation;
    let bad = folder.path().join("bad.toml");
    std::fs::write(&bad, "format = 1\nname = 3\n").expect("writes");
    open(&mut harness, Command::OpenScenario(bad));
    wait_for(&mut harness, "an error", |w| !said(w).is_empty());
    assert_eq!(view(harness.state()).scene_generation, first);
    let other = dorsum::scenario::examples()[1];
    open(&mut harness, Command::OpenExample(other.file));
    wait_for(&mut harness, "the other scene", |w| {
        view(w).scene_generation > first
    });
    assert_ne!(
        view(harness.state()).scene.expect("open").scenario.name,
        support::scene().scenario.name
    );
}

#[test]
fn a_recording_that_is_none_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = workbench(folder.path().to_owned());
    let path = folder.path().join("none.mcap");
    open(&mut harness, Command::OpenRecording(path.clone()));
    wait_for(&mut harness, "an error", |w| {
        said(w).iter().any(|m| m.contains("none.mcap"))
    });
    std::fs::write(&path, b"not a recording").expect("writes");
    open(&mut harness, Command::OpenRecording(path));
    wait_for(&mut harness, "another error", |w| said(w).len() >= 2);
    assert!(view(harness.state()).playback.is_none());
}

#[test]
fn the_palette_finds_a_command_by_part_of_its_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = workbench(folder.path().to_owned());
    open(&mut harness, Command::Do(Action::Palette));
    harness.run_steps(3);
    // The palette's field has the focus.
    harness.event(egui::Event::Text("stop for".into()));
    harness.run_steps(3);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(3);
    assert!(!view(harness.state()).force_enabled);
}

#[test]
fn every_control_of_the_workbench_has_a_name_dark_and_light() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = workbench(folder.path().to_owned());
    harness.check_accessibility();
    click(&mut harness, "Light window");
    harness.check_accessibility();
    for menu in ["File", "Session", "View", "Panels"] {
        click(&mut harness, menu);
        harness.check_accessibility();
        click(&mut harness, menu);
    }
}

fn open(harness: &mut Window, command: Command) {
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, command);
    harness.run_steps(2);
}

#[test]
fn an_idle_bench_wants_no_frames_and_a_touched_one_does() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = workbench(folder.path().to_owned());
    std::thread::sleep(std::time::Duration::from_millis(500));
    let frames_wanted = |harness: &Window| {
        let polls = (0..60).filter(|_| {
            std::thread::sleep(std::time::Duration::from_millis(10));
            harness.state().shared().bench().poll()
        });
        polls.count()
    };
    // A busy machine may make ticks late, which is told once a second.
    assert!(frames_wanted(&harness) <= 2);
    press(&mut harness);
    assert_eq!(frames_wanted(&harness), 60);
}
