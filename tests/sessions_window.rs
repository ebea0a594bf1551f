//! Sessions in the window: found, tagged, replayed, overlaid and compared, by the accessibility tree alone.
#![cfg(feature = "gui")]

mod support;

use dorsum::app::bench::Source;
use dorsum::app::command::Command;
use dorsum::app::history::Channel;
use dorsum::app::shell::Start;
use dorsum::app::state::{Alignment, Compared};
use dorsum::contact::Touch;
use dorsum::scenario::{self, Item};
use dorsum::session::{DeviceInfo, Header, IfExists, MeshSource, SessionWriter};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use std::path::{Path, PathBuf};
use support::{Window, touching, view, wait_for, workbench_as};

/// What a recording is made of.
struct Made {
    file: &'static str,
    participant: &'static str,
    day: u32,
    /// Depth of a press that begins after this time, s.
    press: (f64, f64),
    seconds: f64,
    sealed: bool,
}

const NOVICE: Made = Made {
    file: "a_novice.mcap",
    participant: "P01",
    day: 3,
    press: (0.5, 3.0),
    seconds: 2.0,
    sealed: false,
};

const EXPERT: Made = Made {
    file: "b_expert.mcap",
    participant: "P02",
    day: 9,
    press: (1.0, 6.0),
    seconds: 4.0,
    sealed: false,
};

fn header(made: &Made) -> Header {
    let example = scenario::default_example();
    let scene = support::scene();
    let device = DeviceInfo {
        name: "Mouse".into(),
        rated_force_n: 22.0,
        rise_n_per_s: 4400.0,
        passivity: false,
        stiffness: Default::default(),
    };
    Header {
        scenario_toml: example.text.into(),
        scenario_name: format!("Study of {}", made.participant),
        mesh: MeshSource::new(&scene.surface, "builtin:back"),
        devices: vec![device; 2],
        rate_hz: 1000.0,
        build: "test".into(),
        started_utc: format!("2031-05-{:02}T09:30:00Z", made.day),
        participant: Some(made.participant.into()),
        edit: 0,
        sealed: made.sealed,
    }
}

/// Writes it: the right finger presses, the left one stays away.
fn make(folder: &Path, made: &Made) -> PathBuf {
    let path = folder.join(made.file);
    let mut writer = SessionWriter::create(&path, &header(made), IfExists::Refuse).expect("begins");
    let (from_s, depth_mm) = made.press;
    let held = touching(0, 0, depth_mm);
    for tick in 0..(made.seconds * 1000.0) as u64 {
        let pressed = tick as f64 >= from_s * 1000.0;
        for finger in 0..2 {
            let mut record = held;
            (record.finger, record.tick) = (finger, tick);
            record.time_ns = tick * 1_000_000;
            if finger == 0 || !pressed {
                record.contact = Default::default();
                record.sent_force_n = Default::default();
                record.reading.position_mm.z += 60.0;
            }
            writer.write(&record).expect("writes");
        }
        if tick == 700 {
            writer.event("mark", "here").expect("writes");
        }
    }
    writer.finish().expect("ends");
    path
}

fn desk(folder: &Path) -> Window {
    let mut harness = workbench_as(Start {
        source: Some(Source::Example(scenario::default_example())),
        folder: folder.to_owned(),
        panel: Some("sessions".into()),
        ..Start::default()
    });
    wait_for(&mut harness, "a frame", |_| true);
    harness
}

fn click(harness: &mut Window, name: &str) {
    harness.get_by_label(name).click();
    harness.run_steps(3);
}

/// Draws until something with this in its name is there.
fn until_said(harness: &mut Window, text: &str) {
    let start = std::time::Instant::now();
    while harness.query_all_by_label_contains(text).next().is_none() {
        assert!(start.elapsed().as_secs() < 60, "{text:?} is not said");
        harness.run_steps(1);
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    harness.run_steps(2);
}

fn says(harness: &Window, text: &str) -> bool {
    harness.query_all_by_label_contains(text).next().is_some()
}

fn rows(harness: &Window) -> Vec<String> {
    harness
        .query_all_by_role(egui::accesskit::Role::ListBoxOption)
        .filter_map(|node| node.accesskit_node().label())
        .collect()
}

#[test]
fn the_browser_lists_filters_tags_and_replays() {
    let folder = tempfile::tempdir().expect("a folder");
    make(folder.path(), &NOVICE);
    let expert = make(folder.path(), &EXPERT);
    let sealed = Made {
        file: "c_sealed.mcap",
        participant: "P03",
        day: 11,
        sealed: true,
        ..NOVICE
    };
    make(folder.path(), &sealed);
    std::fs::write(folder.path().join("d_none.mcap"), b"not a recording").expect("writes");
    let mut harness = desk(folder.path());
    for text in ["Study of P01", "Study of P02", "Sealed trial", "Unreadable"] {
        until_said(&mut harness, text);
    }
    let listed = rows(&harness);
    assert_eq!(listed.len(), 4, "{listed:?}");
    // Newest first; of a sealed one nothing is told but that it is sealed.
    assert!(listed[0].starts_with("Study of P02"), "{listed:?}");
    assert!(!says(&harness, "P03"));

    harness.get_by_label("Find").focus();
    harness.run_steps(2);
    harness.event(egui::Event::Text("p02".into()));
    harness.run_steps(3);
    assert_eq!(rows(&harness).len(), 1);
    let row = rows(&harness).remove(0);
    click(&mut harness, &row);
    harness.get_by_label("Tags").focus();
    harness.run_steps(2);
    harness.event(egui::Event::Text("expert, after".into()));
    harness.key_press(egui::Key::Enter);
    harness.run_steps(3);
    let row = rows(&harness).remove(0);
    assert!(row.ends_with("after, expert"), "{row}");

    click(&mut harness, "Replay recording");
    wait_for(&mut harness, "the replay", |w| view(w).playback.is_some());
    let playback = view(harness.state()).playback.expect("open");
    assert_eq!(playback.path, expert);
    assert!((playback.duration_s - 3.999).abs() < 1e-9, "{playback:?}");
}

#[test]
fn rows_are_reached_ticked_and_opened_by_keyboard() {
    let folder = tempfile::tempdir().expect("a folder");
    make(folder.path(), &NOVICE);
    make(folder.path(), &EXPERT);
    let mut harness = desk(folder.path());
    until_said(&mut harness, "Study of P01");
    until_said(&mut harness, "Study of P02");
    let listed = rows(&harness);
    harness.get_by_label(&listed[0]).focus();
    harness.run_steps(3);
    harness.key_press(egui::Key::ArrowDown);
    harness.run_steps(3);
    harness.key_press(egui::Key::Space);
    harness.run_steps(3);
    until_said(&mut harness, "1 ticked");
    harness.key_press(egui::Key::Enter);
    wait_for(&mut harness, "the replay", |w| view(w).playback.is_some());
    let path = view(harness.state()).playback.expect("open").path;
    assert!(path.ends_with(NOVICE.file), "{path:?}");
}

fn apply(harness: &mut Window, command: Command) {
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, command);
    harness.run_steps(2);
}

/// Lets the bench take in where time stands.
fn settle(harness: &mut Window) {
    for _ in 0..10 {
        harness.run_steps(1);
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
}

#[test]
fn ghosts_appear_follow_the_time_and_vanish() {
    let folder = tempfile::tempdir().expect("a folder");
    let novice = make(folder.path(), &NOVICE);
    let expert = make(folder.path(), &EXPERT);
    let mut harness = desk(folder.path());
    until_said(&mut harness, "Study of P01");
    until_said(&mut harness, "Study of P02");
    for row in rows(&harness) {
        click(&mut harness, &format!("Tick {row}"));
    }
    until_said(&mut harness, "2 ticked");
    click(&mut harness, "Overlay ticked as ghosts");
    wait_for(&mut harness, "the ghost", |w| {
        view(w).playback.is_some() && view(w).ghosts.len() == 1
    });
    let seen = view(harness.state());
    assert_eq!(seen.playback.expect("open").path, novice);
    assert_eq!(seen.ghosts[0].path, expert);
    apply(&mut harness, Command::SetPlaying(false));
    let touch = |harness: &Window| {
        let seen = view(harness.state());
        seen.ghosts[0].trails[1].now.contact.touch
    };
    // The expert presses from 1.0 s on, the novice from 0.5 s.
    apply(&mut harness, Command::Seek(0.7));
    settle(&mut harness);
    assert_eq!(touch(&harness), Touch::Free);
    wait_for(&mut harness, "the first contacts", |w| {
        view(w).ghosts[0].plotted.is_none() && view(w).playback.is_some_and(|p| p.plotted.is_none())
    });
    apply(&mut harness, Command::AlignGhosts(Alignment::FirstContact));
    settle(&mut harness);
    assert!((view(harness.state()).ghosts[0].shift_s + 0.5).abs() < 1e-9);
    assert_eq!(touch(&harness), Touch::Stick);
    let offset_s = 0.4;
    apply(
        &mut harness,
        Command::SetGhostOffset {
            path: expert,
            offset_s,
        },
    );
    settle(&mut harness);
    assert_eq!(touch(&harness), Touch::Free);
    let parts = view(harness.state()).parts;
    assert!(parts.has(Item::Ghosts));
    click(&mut harness, "Remove ghost P02, Study of P02");
    settle(&mut harness);
    assert!(view(harness.state()).ghosts.is_empty());
    assert!(!parts.has(Item::Ghosts));
}

#[test]
fn an_hour_opens_before_it_is_read_and_shows_any_instant() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("hour.mcap");
    let mut header = header(&NOVICE);
    (header.rate_hz, header.devices) = (100.0, header.devices[..1].to_vec());
    let mut writer = SessionWriter::create(&path, &header, IfExists::Refuse).expect("begins");
    let n_ticks = 360_000;
    let mut record = touching(0, 0, 1.0);
    for tick in 0..n_ticks {
        (record.tick, record.time_ns) = (tick, tick * 10_000_000);
        writer.write(&record).expect("writes");
        if tick == 90_000 {
            writer.event("mark", "a quarter").expect("writes");
        }
    }
    writer.finish().expect("ends");
    let mut harness = desk(folder.path());
    apply(&mut harness, Command::OpenRecording(path));
    wait_for(&mut harness, "the hour", |w| view(w).playback.is_some());
    let seen = view(harness.state());
    let playback = seen.playback.expect("open");
    assert!((playback.duration_s - 3599.99).abs() < 1e-6, "{playback:?}");
    assert!(
        playback.plotted.is_some_and(|share| share < 0.9),
        "{playback:?}"
    );
    apply(&mut harness, Command::SetPlaying(false));
    for at_s in [3000.0, 7.0, 1234.0] {
        apply(&mut harness, Command::Seek(at_s));
        let fingers = view(harness.state()).fingers;
        assert_eq!(fingers[0].tick, (at_s * 100.0) as u64);
    }
    until_said(&mut harness, "Go to Mark: a quarter");
    click(&mut harness, "Go to Mark: a quarter at 15:00.00");
    settle(&mut harness);
    let at_s = view(harness.state()).playback.expect("open").time_s;
    assert!((at_s - 900.0).abs() < 1e-6, "{at_s}");
    wait_for(&mut harness, "the plots", |w| {
        let seen = view(w);
        let history = seen.history.lock().expect("free");
        let points = history.line(0, Channel::Depth, at_s - 2.0, at_s + 2.0, 4000);
        seen.playback.is_some_and(|p| p.plotted.is_none())
            // Every tick, although the finest level of a whole hour has lost this by now.
            && points.iter().map(Vec::len).sum::<usize>() >= 400
            && history.span_s().is_some_and(|(_, end_s)| end_s > 3599.0)
    });
}

#[test]
fn two_recordings_are_compared_with_the_right_numbers() {
    let folder = tempfile::tempdir().expect("a folder");
    let paths = [make(folder.path(), &NOVICE), make(folder.path(), &EXPERT)];
    let mut harness = desk(folder.path());
    let tagged = |(path, tag): (&PathBuf, &str)| Compared {
        path: path.clone(),
        tags: vec![tag.to_owned()],
    };
    let recordings = paths.iter().zip(["novice", "expert"]).map(tagged);
    apply(&mut harness, Command::Compare(recordings.collect()));
    until_said(&mut harness, "A P01");
    until_said(&mut harness, "B P02");
    until_said(&mut harness, "Peak force");
    // 0.5 N/mm: 3 mm deep the one, 6 mm the other, for 1.5 s and 3 s.
    for value in ["1.500", "3.000"] {
        assert!(harness.query_all_by_label(value).count() >= 2, "{value}");
    }
    click(&mut harness, "Page Difference");
    until_said(&mut harness, "B P02 against A, by time");
    // While both last the one presses with 1.5 N from 0.5 s on, the other with 3 N from 1 s on.
    until_said(&mut harness, "largest 1.500 N");
    click(&mut harness, "Page Dwell");
    until_said(&mut harness, "Dwell map of A P01");
    until_said(&mut harness, "1.5 s on the skin");
    until_said(&mut harness, "3.0 s on the skin");
    for (page, text) in [
        ("Traces", "Figure: Overlaid force (N)"),
        ("Agreement", "Bias"),
        ("Learning", "over sessions"),
        ("Groups", "Choose two groups"),
    ] {
        click(&mut harness, &format!("Page {page}"));
        until_said(&mut harness, text);
        harness.check_accessibility();
    }
    // Tags that are given later are those that groups are made of; others are not added by that.
    let tags = vec!["late".to_owned()];
    let retag = |path: &Path| {
        Command::Retag(Compared {
            path: path.to_owned(),
            tags: tags.clone(),
        })
    };
    apply(&mut harness, retag(&paths[1]));
    apply(&mut harness, retag(Path::new("elsewhere.mcap")));
    let compared = view(harness.state()).compared.clone();
    let said: Vec<&[String]> = compared.iter().map(|c| &*c.tags).collect();
    assert_eq!(said, [&["novice".to_owned()][..], &tags[..]]);
    // Each finger by itself: the left one never touched.
    click(&mut harness, "Page Measures");
    click(&mut harness, "Measures of left finger");
    until_said(&mut harness, "whole session, left finger");
    assert_eq!(harness.query_all_by_label("1.500").count(), 0);
    click(&mut harness, "Measures of right finger");
    until_said(&mut harness, "whole session, right finger");
    assert!(harness.query_all_by_label("1.500").count() >= 2);
    assert!(says(&harness, "Force 0.5–2 N") && !says(&harness, "Force band"));
    harness.check_accessibility();
    // The recorded motion through the recorded scene: what was made up comes out otherwise.
    click(&mut harness, "Page Repeat");
    until_said(&mut harness, "Choose what is to be other");
    harness.check_accessibility();
    click(&mut harness, "Repeat recording otherwise");
    until_said(
        &mut harness,
        "a_novice, as recorded: 1999 recorded ticks compared, 1999 computed",
    );
    until_said(&mut harness, "Figure: Distance of the proxies");
    harness.check_accessibility();
    // All of it as a page.
    click(&mut harness, "Save report…");
    click(&mut harness, "Save report to file");
    let page = view(harness.state())
        .recorder
        .folder
        .join("comparison.html");
    wait_for(&mut harness, "the page", |_| page.exists());
    let text = std::fs::read_to_string(&page).expect("written");
    assert!(text.contains("a_novice and b_expert") && text.matches("<svg").count() >= 4);
    assert!(view(harness.state()).parts.has(Item::Comparison));
    click(&mut harness, "Page Groups");
    click(&mut harness, "Take B out");
    until_said(&mut harness, "tag the recordings in the Sessions panel");
    click(&mut harness, "Take A out");
    until_said(&mut harness, "Nothing to compare yet");
    assert!(!view(harness.state()).parts.has(Item::Comparison));
}
