//! An exercise in the window, driven by its accessibility tree: begun, palpated, answered, told, kept, gone on with; and
//! nothing of what it hides is to be had before the answer.
#![cfg(feature = "gui")]
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot be set up has failed"
)]

mod support;

#[path = "support/gl.rs"]
mod gl;

use dorsum::app::bench::{Source, Wish};
use dorsum::app::command::{self, Action, Command};
use dorsum::app::dock;
use dorsum::app::panels::{self, BACK_VIEW_KEY, PanelContext};
use dorsum::app::roles::Role;
use dorsum::app::shell::Start;
use dorsum::app::state::View;
use dorsum::contact::Touch;
use dorsum::scenario::{self, Scenario, Use};
use dorsum::servo::{FingerRecord, Rig};
use dorsum::session::{Session, Strictness, check};
use dorsum::training::{Input, Phase};
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::{Harness, TestRenderer};
use gl::{Api, Image, OffScreen, Painter};
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use support::{Window, said, view, wait_for, workbench_as};

const SCENE: &str = "format = 1\nname = \"Found or not\"\n[surface]\nbuiltin = \"back\"\ntriangles = 20389\n\
    [stiffness]\nconstant_n_per_mm = 0.5\n";

/// Six trials among two places, with the truth told.
const LOCATE: &str = "[exercise]\ntask = \"locate\"\ncandidates = \"T5 both sides\"\ndysfunction = \"hypertonic\"\n\
    change = { compliance_percent = -40 }\ntrials = 3\nasks = [\"confidence\"]\n";

/// What is at `level` is to be found.
fn search(level: &str) -> String {
    format!(
        "{SCENE}[[dysfunction]]\nkind = \"hypertonic\"\nlevel = \"{level}\"\nside = \"right\"\n\
         stiffness_change = {{ compliance_percent = -40 }}\n\
         [exercise]\ntask = \"search\"\nhides = \"stated\"\ntrials = 2\n"
    )
}

fn open(text: &str, folder: &Path, role: Role) -> Window {
    workbench_as(Start {
        source: Some(Source::Text {
            toml: text.to_owned(),
            origin: "exercise.toml".into(),
            folder: None,
        }),
        folder: folder.to_owned(),
        role: Some(role),
        ..Start::default()
    })
}

fn click(harness: &mut Window, name: &str) {
    harness.get_by_label(name).click();
    harness.run_steps(3);
}

fn phase(window: &dorsum::app::shell::Workbench) -> Option<Phase> {
    view(window).exercise.map(|e| e.shown.phase)
}

fn begin(harness: &mut Window) {
    wait_for(harness, "the panel", |w| view(w).scene.is_some());
    click(harness, "Begin");
    wait_for(harness, "the first trial", |w| {
        view(w).exercise.is_some_and(|e| e.prepared)
    });
}

/// Starts the trial and waits until its hidden scene is felt and recorded.
fn start(harness: &mut Window) {
    wait_for(harness, "a trial that is ready", |w| {
        view(w).exercise.is_some_and(|e| e.prepared)
    });
    let scenes = view(harness.state()).live.scene_generation;
    click(harness, "Start the trial");
    wait_for(harness, "the hidden scene", |w| {
        view(w).live.scene_generation > scenes && view(w).recorder.recording.is_some()
    });
}

/// Presses at a place of the map plane and lets go again.
fn press(harness: &mut Window, at: dorsum::geom::Vec2) {
    let seen = view(harness.state());
    let z = seen.scene.unwrap().height_mm(at.x, at.y).unwrap();
    let hand = seen.hands[1].clone();
    for depth_mm in [-8.0, 8.0] {
        hand.set(dorsum::geom::Vec3::new(at.x, at.y, z - depth_mm));
        std::thread::sleep(std::time::Duration::from_millis(200));
    }
    wait_for(harness, "contact", |w| {
        view(w).fingers[1].contact.touch != Touch::Free
    });
    std::thread::sleep(std::time::Duration::from_millis(200));
}

#[test]
fn an_exercise_is_begun_palpated_answered_told_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("{SCENE}{LOCATE}");
    let mut harness = open(&text, folder.path(), Role::Trainee);
    begin(&mut harness);
    let mut files = Vec::new();
    for trial in 1..=3 {
        start(&mut harness);
        let sites = scenario::sites("T5 both sides").unwrap();
        press(&mut harness, sites[0].at_mm());
        let file = view(harness.state()).recorder.recording.unwrap();
        files.push(file);
        assert_eq!(phase(harness.state()), Some(Phase::Palpating));
        click(&mut harness, &sites[0].to_string());
        wait_for(&mut harness, "feedback", |w| {
            phase(w) == Some(Phase::Feedback)
        });
        let told = view(harness.state()).exercise.unwrap().shown.feedback;
        assert_eq!(told.unwrap().truth_mm.len(), 1);
        if trial == 1 {
            // It can be felt again, and is not while nobody asks.
            click(&mut harness, "Feel it again");
            wait_for(&mut harness, "the place once more", |w| {
                let told = view(w).exercise.and_then(|e| e.shown.feedback);
                told.is_some_and(|told| told.feeling_again)
            });
        }
        wait_for(&mut harness, "the end of the recording", |w| {
            view(w).recorder.recording.is_none()
        });
        click(&mut harness, "Next trial");
    }
    wait_for(&mut harness, "the end", |w| {
        matches!(phase(w), Some(Phase::Done(_)))
    });
    let settled = view(harness.state()).exercise.unwrap().settled;
    assert_eq!(settled.len(), 3);
    assert!(
        settled.iter().all(|t| t.palpation.presses >= 1),
        "{settled:?}"
    );
    assert!(settled.iter().all(|t| t.palpation.peak_force_n > 0.2));
    // Each file says what was felt in it, and repeats bit by bit.
    for (file, trial) in files.iter().zip(&settled) {
        let session = Session::open(file).unwrap();
        let header = session.header();
        assert!(!header.sealed);
        let felt = Scenario::parse(&header.scenario_toml, "recorded", None).unwrap();
        assert_eq!(felt.dysfunctions.len(), 1);
        assert!(trial.truth.starts_with("T5"), "{}", trial.truth);
        let scene = scenario::build(Arc::new(felt), Use::default(), &mut |_, _| true).unwrap();
        let rig = Rig::new(Box::new(scene.touch), header.limits());
        let report = check(&session, rig, Strictness::Strict).unwrap();
        assert!(report.is_bit_exact(), "{:?}", report.first_difference);
        assert!(report.ticks > 300, "{report:?}");
    }
    click(&mut harness, "Write score sheet");
    wait_for(&mut harness, "the sheet", |w| {
        said(w).iter().any(|text| text.contains("score sheet"))
    });
    let folder = view(harness.state()).exercise.unwrap().folder;
    let pages = std::fs::read_dir(folder).unwrap().flatten();
    let html = pages
        .map(|e| e.path())
        .find(|p| p.extension().is_some_and(|e| e == "html"));
    let page = std::fs::read_to_string(html.expect("a page")).unwrap();
    assert!(page.contains("T5"), "{page}");
    click(&mut harness, "Close exercise");
    wait_for(&mut harness, "the way back", |w| view(w).exercise.is_none());
    harness.get_by_label("Begin");
}

#[test]
fn one_that_was_broken_off_goes_on_where_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("{SCENE}{LOCATE}");
    let mut harness = open(&text, folder.path(), Role::Trainee);
    begin(&mut harness);
    start(&mut harness);
    click(&mut harness, "T5 left transverse process");
    wait_for(&mut harness, "feedback", |w| {
        phase(w) == Some(Phase::Feedback)
    });
    click(&mut harness, "Next trial");
    start(&mut harness);
    drop(harness);
    let mut harness = open(&text, folder.path(), Role::Trainee);
    click(&mut harness, "Go on with nobody named, 1 of 3 answered");
    wait_for(&mut harness, "the second trial", |w| {
        view(w).exercise.is_some_and(|e| e.prepared)
    });
    let shown = view(harness.state()).exercise.unwrap().shown;
    assert_eq!((shown.trial, shown.of), (2, 3));
}

#[test]
fn a_trial_after_an_edit_of_the_scene_repeats_bit_by_bit_and_holds_no_text_of_the_edit() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("{SCENE}{LOCATE}");
    let mut harness = open(&text, folder.path(), Role::Instructor);
    let ctx = harness.ctx.clone();
    let source = text.replace("0.5", "0.55");
    harness
        .state_mut()
        .apply(&ctx, Command::EditScene { source });
    wait_for(&mut harness, "the edit", |w| {
        view(w).live.edit == 1 && view(w).live.fade >= 1.0
    });
    std::thread::sleep(std::time::Duration::from_millis(100));
    harness.run_steps(2);
    begin(&mut harness);
    start(&mut harness);
    let file = view(harness.state()).recorder.recording.unwrap();
    let site = scenario::sites("T5 both sides").unwrap()[0];
    press(&mut harness, site.at_mm());
    click(&mut harness, &site.to_string());
    wait_for(&mut harness, "the end of the recording", |w| {
        view(w).recorder.recording.is_none()
    });
    let session = Session::open(&file).unwrap();
    let header = session.header();
    assert!(session.load(Strictness::Strict).unwrap().edits.is_empty());
    let felt = Scenario::parse(&header.scenario_toml, "recorded", None).unwrap();
    let scene = scenario::build(Arc::new(felt), Use::default(), &mut |_, _| true).unwrap();
    let rig = Rig::new(Box::new(scene.touch), header.limits());
    let report = check(&session, rig, Strictness::Strict).unwrap();
    assert!(report.is_bit_exact(), "{:?}", report.first_difference);
}

#[test]
fn a_pause_is_neither_felt_nor_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("{SCENE}{LOCATE}");
    let mut harness = open(&text, folder.path(), Role::Instructor);
    begin(&mut harness);
    start(&mut harness);
    let file = view(harness.state()).recorder.recording.unwrap();
    let scenes = view(harness.state()).live.scene_generation;
    click(&mut harness, "Pause exercise");
    wait_for(&mut harness, "the shown scene", |w| {
        view(w).live.scene_generation > scenes
    });
    let scenes = view(harness.state()).live.scene_generation;
    std::thread::sleep(std::time::Duration::from_millis(400));
    click(&mut harness, "Go on");
    wait_for(&mut harness, "the hidden scene", |w| {
        view(w).live.scene_generation > scenes
    });
    std::thread::sleep(std::time::Duration::from_millis(200));
    harness.run_steps(2);
    click(&mut harness, "T5 left transverse process");
    wait_for(&mut harness, "the end of the recording", |w| {
        view(w).recorder.recording.is_none()
    });
    let read = Session::open(&file)
        .unwrap()
        .load(Strictness::Strict)
        .unwrap();
    let kinds: Vec<_> = read.events.iter().map(|e| e.kind.as_str()).collect();
    assert_eq!(kinds, ["restart"]);
}

#[test]
fn while_an_exercise_runs_nothing_else_changes_the_scene_or_the_role() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("{SCENE}{LOCATE}");
    let mut harness = open(&text, folder.path(), Role::Researcher);
    let shared = harness.state().shared().clone();
    shared.bench().exercise(Wish::Begin {
        participant: String::new(),
    });
    wait_for(&mut harness, "the first trial", |w| {
        view(w).exercise.is_some_and(|e| e.prepared)
    });
    let before = view(harness.state());
    let ctx = harness.ctx.clone();
    for command in [
        Command::EditScene {
            source: SCENE.to_owned(),
        },
        Command::OpenExample("frictionless.toml"),
        Command::OpenRecording(PathBuf::from("none.mcap")),
        Command::Do(Action::Record),
        Command::Do(Action::BeInstructor),
    ] {
        let told = said(harness.state()).len();
        harness.state_mut().apply(&ctx, command.clone());
        harness.run_steps(3);
        assert_eq!(said(harness.state()).len(), told + 1, "{command:?}");
    }
    let after = view(harness.state());
    assert!(Arc::ptr_eq(&before.scene.unwrap(), &after.scene.unwrap()));
    assert_eq!(after.role, Role::Researcher);
    assert!(after.recorder.recording.is_none());
    shared.bench().exercise(Wish::Do(Input::Abort));
    shared.bench().exercise(Wish::Close);
    harness
        .state_mut()
        .apply(&ctx, Command::Do(Action::BeInstructor));
    assert_eq!(view(harness.state()).role, Role::Instructor);
}

/// Everything a screen reader would say, and where it is.
fn tree(harness: &Window) -> Vec<String> {
    fn walk(node: egui_kittest::Node<'_>, out: &mut Vec<String>) {
        let this = node.accesskit_node();
        out.push(format!(
            "{:?} {:?} {:?} {:?}",
            this.role(),
            this.label(),
            this.value(),
            this.bounding_box()
        ));
        for child in node.children() {
            walk(child, out);
        }
    }
    let mut out = Vec::new();
    walk(harness.root(), &mut out);
    // What the clock and the timing of this machine say differs from run to run.
    out.retain(|line| ![" late", "00:0", "Servo "].iter().any(|s| line.contains(s)));
    out
}

/// A record without what no two runs have in common: its time and how long it took.
fn timeless(record: &FingerRecord) -> FingerRecord {
    FingerRecord {
        tick: 0,
        time_ns: 0,
        duration_us: 0.0,
        ..*record
    }
}

/// Everything panels get to see, as text.
fn seen(view: &View) -> String {
    let scene = view.scene.as_ref().unwrap();
    let stiffness: Vec<f64> = (0..scene.surface.positions().len())
        .map(|i| scene.touch.stiffness.at([i as u32; 3], [1.0, 0.0, 0.0]))
        .collect();
    let mut exercise = view.exercise.clone().unwrap();
    exercise.folder = PathBuf::new();
    let fingers: Vec<_> = view.fingers.iter().map(timeless).collect();
    let live: Vec<_> = view.live.record.fingers().iter().map(timeless).collect();
    let messages: Vec<_> = view.messages.iter().map(|m| m.text.clone()).collect();
    let rows: Vec<_> = (scene.ledger.rows.iter())
        .map(|r| (r.item, r.reason.clone(), r.built, r.bytes))
        .collect();
    format!(
        "{:?}\n{stiffness:?}\n{exercise:?}\n{fingers:?}\n{live:?}\n{messages:?}\n{rows:?}\n{:?}",
        scene.scenario, view.blind
    )
}

/// Every file below `folder`, without times: name and what it says.
fn files(folder: &Path) -> Vec<String> {
    let mut out = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            let says = if name.ends_with(".mcap") {
                let session = Session::open(&path).unwrap();
                let mut header = session.header().clone();
                header.started_utc = String::new();
                let read = session.load(Strictness::Lenient).unwrap();
                let first = read.fingers.iter().filter_map(|f| f.last()).map(timeless);
                format!(
                    "{header:?} {:?} {:?}",
                    first.collect::<Vec<_>>(),
                    read.edits
                )
            } else {
                let text = std::fs::read_to_string(&path).unwrap();
                text.lines()
                    .map(|line| match line.find("_utc\"") {
                        Some(at) => &line[..at],
                        None => line,
                    })
                    .collect::<Vec<_>>()
                    .join("\n")
            };
            out.push(format!("{name}: {says}"));
        }
    }
    out.sort();
    out
}

/// Hands egui's textures to the painter on the off-screen window.
struct Textures(Rc<RefCell<Painter>>);

impl TestRenderer for Textures {
    fn handle_delta(&mut self, delta: &mut egui::TexturesDelta) {
        self.0.borrow_mut().textures(delta);
    }
}

/// The trainee's panels as `view` lets them be drawn, once nothing of the picture changes any more; `None` without OpenGL.
fn picture(view: &View) -> Option<Image> {
    let size = [900_u32, 600];
    let screen = Rc::new(OffScreen::or_skip(Api::Core33, size)?);
    let painter = Rc::new(RefCell::new(Painter::new(&screen)));
    let mut view = view.clone();
    view.gl = Some(screen.gl.clone());
    let theme = view.theme;
    let slots = dock::slots(panels::trainee());
    let (send, _commands) = command::queue(Arc::new(|| {}));
    let mut harness = Harness::builder()
        .with_size([size[0] as f32, size[1] as f32])
        .with_context_setup(move |ctx| {
            egui_material_icons::initialize(ctx);
            theme.apply(ctx);
        })
        .renderer(Textures(painter.clone()))
        .build_ui(move |ui| {
            let cx = PanelContext {
                view: &view,
                send: &send,
            };
            for slot in slots.iter().filter(|s| s.key != BACK_VIEW_KEY) {
                egui::Panel::right("side")
                    .exact_size(300.0)
                    .show(ui, |ui| dock::draw(ui, slot, &cx));
            }
            for slot in slots.iter().filter(|s| s.key == BACK_VIEW_KEY) {
                egui::CentralPanel::no_frame().show(ui, |ui| dock::draw(ui, slot, &cx));
            }
        });
    let mut last: Option<Image> = None;
    for _ in 0..100 {
        harness.run_steps(2);
        let shapes = harness.output().shapes.clone();
        let image = painter.borrow_mut().paint(&screen, &harness.ctx, shapes);
        if last.as_ref() == Some(&image) {
            return last;
        }
        last = Some(image);
        std::thread::sleep(std::time::Duration::from_millis(300));
    }
    panic!("the picture does not come to rest");
}

#[test]
fn before_the_answer_nothing_tells_where_the_hidden_place_is() {
    let run = |level: &str| {
        let folder = tempfile::tempdir().unwrap();
        let mut harness = open(&search(level), folder.path(), Role::Trainee);
        let mut trees = vec![tree(&harness)];
        let before = view(harness.state());
        assert!(before.blind && before.scene.unwrap().scenario.dysfunctions.is_empty());
        begin(&mut harness);
        trees.push(tree(&harness));
        let mut views = vec![seen(&view(harness.state()))];
        start(&mut harness);
        std::thread::sleep(std::time::Duration::from_millis(700));
        harness.run_steps(3);
        trees.push(tree(&harness));
        views.push(seen(&view(harness.state())));
        let shared = harness.state().shared().clone();
        let pictures = [Role::Trainee, Role::Instructor].map(|r| picture(&shared.view_of(r)));
        let files = files(folder.path());
        assert!(
            files.iter().any(|f| f.starts_with("trial_001.mcap")),
            "{files:?}"
        );
        (trees, views, files, pictures)
    };
    let (a, b) = (run("T4"), run("T9"));
    assert_eq!(a.0, b.0);
    assert_eq!(a.1, b.1);
    assert_eq!(a.2, b.2);
    let ([a_trainee, a_instructor], [b_trainee, b_instructor]) = (&a.3, &b.3);
    assert!(a_trainee == b_trainee, "a pixel tells it");
    // Were it told, it would be seen.
    assert!(a_instructor.is_none() || a_instructor != b_instructor);
    assert!(!a.1[1].contains("T4") && !a.0[2].join("\n").contains("T4"));
}

#[test]
fn the_instructor_sees_beside_it_what_the_trainees_window_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = open(&search("T4"), folder.path(), Role::Instructor);
    let ctx = harness.ctx.clone();
    harness
        .state_mut()
        .apply(&ctx, Command::ShowTraineeWindow(true));
    harness.run_steps(3);
    let shared = harness.state().shared().clone();
    shared.bench().exercise(Wish::Begin {
        participant: String::new(),
    });
    wait_for(&mut harness, "the truth", |w| {
        view(w).exercise.is_some_and(|e| e.truth.is_some())
    });
    let (instructor, trainee) = (shared.view(), shared.view_of(Role::Trainee));
    let truth = instructor.exercise.unwrap().truth.unwrap().join(" ");
    assert!(truth.contains("T4"), "{truth}");
    assert_eq!(instructor.scene.unwrap().scenario.dysfunctions.len(), 1);
    assert!(!instructor.blind && trainee.blind);
    assert!(trainee.scene.unwrap().scenario.dysfunctions.is_empty());
    let theirs = trainee.exercise.unwrap();
    assert!(theirs.truth.is_none() && theirs.truth_mm.is_empty());
}
