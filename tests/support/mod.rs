//! What the tests of the window share.
#![allow(dead_code, reason = "each test uses its part")]
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot be set up has failed"
)]

pub mod panel_window;

use dorsum::app::bench::Source;
use dorsum::app::history::History;
use dorsum::app::messages::{Level, Messages};
use dorsum::app::shell::{Start, Workbench};
use dorsum::app::state::{
    BuildStatus, FrameTiming, PlaybackStatus, RecentFile, RecorderStatus, View,
};
use dorsum::contact::Touch;
use dorsum::geom::Vec3;
use dorsum::scenario::{self, Scenario, Scene, Use};
use dorsum::servo::{FingerRecord, Health};
use eframe::App;
use egui_kittest::Harness;
use std::ops::{Deref, DerefMut};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};

/// The default scene, built once.
pub fn scene() -> Arc<Scene> {
    static SCENE: OnceLock<Arc<Scene>> = OnceLock::new();
    SCENE
        .get_or_init(|| {
            let example = scenario::default_example();
            let scenario = Scenario::parse(example.text, example.file, None).unwrap();
            let purpose = Use {
                fingers: 2,
                live: true,
                drawn: true,
                deformed: true,
                recorded: true,
                plotted: true,
                partitioned: false,
                bones_drawn: false,
                named: false,
                hands_drawn: false,
                two_eyes: false,
                coloured: false,
                ellipse_edited: false,
                stiffness_edited: false,
                scenario_edited: false,
                listed: false,
                browsed: false,
                ghosts: false,
                compared: false,
                passivity: false,
            };
            let scene = scenario::build(Arc::new(scenario), purpose, &mut |_, _| true);
            Arc::new(scene.unwrap())
        })
        .clone()
}

/// A finger `depth_mm` deep in the skin above a vertex near the middle of the back.
pub fn touching(finger: u8, tick: u64, depth_mm: f64) -> FingerRecord {
    let mut r = FingerRecord {
        tick,
        finger,
        time_ns: tick * 1_000_000,
        force_enabled: true,
        ..FingerRecord::default()
    };
    let (point, normal) = place();
    r.reading.connected = true;
    r.reading.position_mm = point - normal * depth_mm;
    r.contact.touch = Touch::Stick;
    r.contact.anchor_mm = point;
    r.contact.foot_mm = point;
    r.contact.normal = normal;
    r.contact.depth_mm = depth_mm;
    r.contact.stiffness_n_per_mm = 0.5;
    r.contact.force_n = normal * (0.5 * depth_mm);
    r.sent_force_n = r.contact.force_n;
    r
}

/// A vertex to press on, and its normal.
pub fn place() -> (Vec3, Vec3) {
    let scene = scene();
    let bounds = scene.surface.bounds();
    let middle = (bounds.min + bounds.max) * 0.5;
    let aim = middle + Vec3::new(40.0, 0.0, 0.0);
    let flat = |p: &Vec3| (p.x - aim.x).hypot(p.y - aim.y);
    scene
        .surface
        .positions()
        .iter()
        .zip(scene.surface.normals())
        .filter(|(_, n)| n.z > 0.3)
        .min_by(|a, b| flat(a.0).total_cmp(&flat(b.0)))
        .map(|(p, n)| (*p, *n))
        .unwrap()
}

/// The states that every panel must draw: by name.
pub fn views() -> Vec<(&'static str, View)> {
    vec![
        ("empty", View::default()),
        ("building", building()),
        ("running", running()),
        ("replaying", replaying()),
        ("faulty", faulty()),
    ]
}

fn building() -> View {
    View {
        build: Some(BuildStatus {
            scenario: "FIRST.toml".into(),
            part: "search structure".into(),
            fraction: 0.4,
        }),
        ..View::default()
    }
}

pub fn running() -> View {
    let mut history = History::new(1000.0);
    for tick in 0..5000 {
        let depth = 5.0 + 3.0 * (tick as f64 * 0.004).sin();
        history.push(&touching(0, tick, depth));
        history.push(&touching(1, tick, 0.5 * depth));
    }
    let mut view = View {
        scene: Some(scene()),
        scene_generation: 1,
        fingers: vec![touching(0, 4999, 6.0), touching(1, 4999, 3.0)],
        history: Arc::new(Mutex::new(history)),
        devices: vec!["Mouse".into(), "Mouse".into()],
        recorder: RecorderStatus {
            recording: Some(PathBuf::from("/tmp/2031-05-17_first.mcap")),
            time_s: 12.3,
            bytes: 1_234_567,
            lost: 0,
            held_bytes: 600_000,
            finished: 3,
            recent: recent(),
            folder: PathBuf::from("/tmp"),
            ..RecorderStatus::default()
        },
        frame: FrameTiming {
            last_ms: 4.0,
            longest_ms: 8.0,
            frames_per_s: 60.0,
        },
        ..View::default()
    };
    view.live.health = Health::Good;
    for i in 0..5000 {
        let period_us = 1000.0 + f64::from(i % 7) * 20.0;
        view.live.timing.count(Some(period_us), 1.5, false);
    }
    view
}

fn recent() -> Vec<RecentFile> {
    (0..30)
        .map(|i| RecentFile {
            path: PathBuf::from(format!(
                "/tmp/2031-05-{i:02}_09-30-00_a-rather-long-name-of-a-scenario.mcap"
            )),
            bytes: 1_000_000 * i,
        })
        .collect()
}

fn replaying() -> View {
    let mut view = running();
    view.recorder.recording = None;
    view.playback = Some(PlaybackStatus {
        path: PathBuf::from("/tmp/2031-05-17_first.mcap"),
        time_s: 2.5,
        duration_s: 5.0,
        playing: true,
        speed: 1.0,
        looped: true,
        ..PlaybackStatus::default()
    });
    view
}

/// Everything that can be wrong at once: numbers that are none, a dead servo, lost ticks, long messages.
fn faulty() -> View {
    let mut view = running();
    let mut broken = touching(0, 5000, f64::NAN);
    broken.reading.position_mm = Vec3::NAN;
    broken.contact.normal = Vec3::NAN;
    broken.sent_force_n = Vec3::INFINITY;
    broken.contact.foot_mm = Vec3::NAN;
    broken.contact.triangle = u32::MAX;
    view.history.lock().unwrap().push(&broken);
    view.fingers = vec![broken, touching(1, 5000, 1e9)];
    view.live.health = Health::Fault;
    view.live.timing.late_ticks = u64::MAX;
    view.live.timing.lost_records = 12;
    view.live.timing.longest_period_us = f64::INFINITY;
    view.live.timing.period_histogram = [u32::MAX; dorsum::servo::N_BINS];
    view.recorder.lost = 99;
    view.recorder.time_s = f64::NAN;
    view.force_enabled = false;
    view.frame.last_ms = f64::NAN;
    view.playback = Some(PlaybackStatus {
        path: PathBuf::new(),
        time_s: f64::NAN,
        duration_s: 0.0,
        playing: false,
        speed: f64::NAN,
        looped: false,
        ..PlaybackStatus::default()
    });
    let mut messages = Messages::default();
    messages.tell(Level::Info, "a note");
    messages.tell(Level::Warning, "a warning");
    for _ in 0..3 {
        messages.tell(Level::Error, "a very long error ".repeat(40));
    }
    view.messages = messages.list();
    view
}

/// A workbench and the frame that eframe would hand it.
pub struct Desk {
    workbench: Option<Workbench>,
    frame: eframe::Frame,
}

impl Deref for Desk {
    type Target = Workbench;

    fn deref(&self) -> &Workbench {
        self.workbench.as_ref().expect("made in the first frame")
    }
}

impl DerefMut for Desk {
    fn deref_mut(&mut self) -> &mut Workbench {
        self.workbench.as_mut().expect("made in the first frame")
    }
}

/// A desk under test.
pub type Window = Harness<'static, Desk>;

/// A whole workbench without a window system, on the default scene, keeping recordings in `folder`.
pub fn workbench(folder: PathBuf) -> Window {
    workbench_as(Start {
        source: Some(Source::Example(scenario::default_example())),
        folder,
        ..Start::default()
    })
}

/// A whole workbench without a window system that starts as `start` says.
pub fn workbench_as(start: Start) -> Window {
    let desk = Desk {
        workbench: None,
        frame: eframe::Frame::_new_kittest(),
    };
    let mut harness = Harness::builder()
        .with_size([1280.0, 800.0])
        .with_context_setup(egui_material_icons::initialize)
        .build_ui_state(
            move |ui, desk: &mut Desk| {
                let ctx = ui.ctx().clone();
                let workbench = desk.workbench.get_or_insert_with(|| {
                    let cc = eframe::CreationContext::_new_kittest(ctx.clone());
                    Workbench::new(&cc, start.clone())
                });
                workbench.logic(&ctx, &mut desk.frame);
                workbench.ui(ui, &mut desk.frame);
            },
            desk,
        );
    wait_for(&mut harness, "the first scene", |w| view(w).scene.is_some());
    harness
}

/// What panels see now.
pub fn view(workbench: &Workbench) -> View {
    workbench.shared().view()
}

/// Draws frames until `done` holds; a live bench has threads, so the clock is real.
pub fn wait_for(harness: &mut Window, what: &str, done: impl Fn(&Workbench) -> bool) {
    let start = Instant::now();
    while !done(harness.state()) {
        assert!(
            start.elapsed() < Duration::from_secs(60),
            "{what} did not come: {:?}",
            said(harness.state())
        );
        harness.run_steps(1);
        std::thread::sleep(Duration::from_millis(5));
    }
    // What was waited for is drawn.
    harness.run_steps(2);
}

/// All messages, for a failing test to tell.
pub fn said(workbench: &Workbench) -> Vec<String> {
    view(workbench)
        .messages
        .iter()
        .map(|m| m.text.clone())
        .collect()
}
