//! What a scene leaves out is not there: bytes and instructions, counted.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::lab::pruning::scenes::PLAIN;
use dorsum::lab::pruning::{self, Case, Counted, Finger, Of, Uncounted};
use dorsum::lab::{self, Document, Setup, Watch};
use dorsum::scenario::Item;
use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};
use std::alloc::System;
use std::sync::{Mutex, MutexGuard, PoisonError};

#[cfg(feature = "gui")]
mod support;

#[cfg(feature = "gui")]
#[path = "support/gl.rs"]
mod gl;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// The heap is that of the whole process: one test at a time.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The program counts, in processes of its own.
fn counted_by_the_program() {
    pruning::counted_by(env!("CARGO_BIN_EXE_dorsum").into());
}

fn case(finger: Finger, windows: usize, per_window: usize) -> Case {
    Case {
        scenario: PLAIN.on_back(900),
        deformed: false,
        of: Of::Tick,
        finger,
        windows,
        per_window,
        most_steps: 100_000,
    }
}

fn count(case: &Case) -> Counted {
    counted_by_the_program();
    pruning::count(case, &mut || true).unwrap()
}

/// Some containers do not let one process step another.
fn can_step(counted: &Counted) -> bool {
    let refused = &counted.counts.refused;
    if let Some(why) = refused {
        eprintln!("not checked: {why}");
    }
    refused.is_none()
}

#[test]
fn twice_as_many_ticks_are_twice_as_many_instructions_and_again_the_same() {
    let _alone = alone();
    let [one, two] = [8, 16].map(|n| count(&case(Finger::Aloft, 2, n)));
    if !can_step(&one) {
        return;
    }
    let again = count(&case(Finger::Aloft, 2, 8));
    let apart = |a: u64, b: u64| a.abs_diff(b);
    for w in 0..2 {
        // A tick in the air does the same each time, but for how far the sweep looks.
        assert!(one.windows[w] > 8 * 300, "{one:?}");
        let off = apart(2 * one.windows[w], two.windows[w]);
        assert!(off * 50 < two.windows[w], "{one:?} {two:?}");
        assert!(
            apart(one.windows[w], again.windows[w]) <= 16,
            "{one:?} {again:?}"
        );
    }
    assert_eq!(one.counts.scene, again.counts.scene);
    assert_eq!(one.counts.use_calls, Some(0));
}

#[test]
fn counting_ends_at_its_bound_and_when_nobody_wants_it() {
    let _alone = alone();
    let mut bounded = case(Finger::Aloft, 16, 8);
    bounded.most_steps = 30_000;
    let counted = count(&bounded);
    if !can_step(&counted) {
        return;
    }
    assert!(counted.windows.len() < 16, "{counted:?}");
    assert!(counted.windows.iter().sum::<u64>() <= bounded.most_steps);
    let stopped = pruning::count(&case(Finger::Aloft, 16, 8), &mut || false);
    assert_eq!(stopped, Err(Uncounted::Stopped));
}

#[test]
fn a_case_that_is_none_is_told() {
    let _alone = alone();
    counted_by_the_program();
    let mut bad = case(Finger::Aloft, 1, 1);
    bad.scenario = "format = 1\nname = \"x\"\n".into();
    let Err(Uncounted::Here(why)) = pruning::count(&bad, &mut || true) else {
        panic!("a scenario without a surface is refused");
    };
    assert!(why.contains("surface"), "{why}");
    // Nobody else may start it: the shell of a user would be the one that has to step it.
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_dorsum"))
        .arg(pruning::SUBCOMMAND)
        .stdin(std::process::Stdio::null())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(
        told.contains("lab pruning") && told.lines().count() == 1,
        "{told}"
    );
}

fn run(experiment: &dyn lab::Experiment) -> Document {
    counted_by_the_program();
    let setup = Setup {
        quick: true,
        triangles: vec![900],
        ..Setup::default()
    };
    lab::run(&[experiment], &setup, &mut Watch::new(&mut |_, _| true)).unwrap()
}

#[test]
fn absent_parts_cost_nothing_and_the_ledger_tells_what_the_others_hold() {
    let _alone = alone();
    let document = run(&pruning::Parts);
    let report = &document.experiments[0];
    println!("{report}");
    assert!(report.holds());
    let bytes = &report.tables[0];
    for row in 0..bytes.rows().len() {
        let part = bytes.cell(row, "part").to_string();
        let number = |name: &str| bytes.cell(row, name).number();
        if let Some(left_out) = number("named but left out") {
            // Keys that are stated are kept, as stated.
            let keys = if part == Item::StiffnessField.name() {
                100.0
            } else {
                0.0
            };
            assert!((0.0..=keys).contains(&left_out), "{part}: {left_out}");
        }
        let used = number("used").expect("counted by the program");
        // A few numbers in the scene itself, or something of its own.
        let inline = [
            Item::Friction,
            Item::ForceModel,
            Item::FingerPad,
            Item::ForceShading,
        ];
        if inline.iter().any(|item| item.name() == part) {
            assert_eq!((used, number("ledger")), (0.0, Some(0.0)), "{part}");
        } else {
            assert!(used > 100.0, "{part}: {used}");
        }
    }
}

#[test]
fn needs_change_under_a_servo_that_allocates_nothing_and_all_of_it_is_repeated() {
    let _alone = alone();
    let document = run(&pruning::Live);
    let report = &document.experiments[0];
    println!("{report}");
    assert!(report.holds());
    let counted = report
        .verdicts
        .iter()
        .filter(|v| v.measured.contains("not counted"));
    assert_eq!(counted.count(), 0);
    assert_eq!(report.tables[0].cell(1, "changes").number(), Some(12.0));
}

/// What `dorsum scene` prints is what the heap holds.
#[test]
fn the_ledger_on_the_command_line_is_the_count() {
    let _alone = alone();
    counted_by_the_program();
    let folder = tempfile::tempdir().unwrap();
    let scenario = pruning::scenes::EDITED.on_back(2962);
    std::fs::write(folder.path().join("s.toml"), &scenario).unwrap();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_dorsum"))
        .args(["scene", "s.toml", "--drawn", "--json"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(output.status.success());
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let mut case = case(Finger::Slides, 0, 0);
    (case.scenario, case.deformed, case.of) = (scenario, true, Of::Frame);
    let counted = count(&case).counts.held().unwrap() as f64;
    let total = told["total_bytes"].as_f64().unwrap();
    assert!(
        (total - counted).abs() < 0.02 * counted + 2048.0,
        "{total} {counted}"
    );
    let rows = told["ledger"].as_array().unwrap();
    let sum: f64 = rows.iter().map(|r| r["bytes"].as_f64().unwrap()).sum();
    assert_eq!(sum, total);
    for row in rows {
        let built = row["built"] == true;
        assert!(built || row["bytes"] == 0, "{row}");
        assert_eq!(row["cost_us"].is_null(), row["cost_per"] == "", "{row}");
    }
}

/// The parts that live in the window: panels opened and closed.
#[cfg(feature = "gui")]
mod window {
    use super::support::{self, Window, view, wait_for, workbench};
    use super::{alone, gl};
    use dorsum::app::bench::Source;
    use dorsum::app::command::{self, Action, Command};
    use dorsum::app::history::History;
    use dorsum::app::panels::back_view::BackView;
    use dorsum::app::panels::{Panel as _, PanelContext};
    use dorsum::lab::pruning::{Heap, scenes::EDITED};
    use dorsum::scenario::{self, Item, Scenario, Use};
    use egui_kittest::Harness;
    use std::cell::RefCell;
    use std::rc::Rc;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::{Duration, Instant};

    /// What the toolkit keeps of a panel that was drawn: text laid out, places of widgets, states of animations.
    const TOOLKIT_BYTES: i64 = 700_000;
    /// What may come and go between two looks.
    const STILL_BYTES: i64 = 4_096;

    /// Bytes held once nothing comes or goes any more.
    fn settled(mut frame: impl FnMut()) -> i64 {
        let started = Instant::now();
        let mut seen: Vec<i64> = Vec::with_capacity(1024);
        loop {
            assert!(started.elapsed() < Duration::from_secs(30), "{seen:?}");
            frame();
            std::thread::sleep(Duration::from_millis(40));
            seen.push(Heap::now().unwrap().held);
            if let [.., a, b, c, d] = seen[..] {
                let four = [a, b, c, d];
                let (least, most) = (four.iter().min().unwrap(), four.iter().max().unwrap());
                if most - least <= STILL_BYTES {
                    return *least;
                }
            }
        }
    }

    fn heap(harness: &mut Window) -> i64 {
        settled(|| harness.run_steps(2))
    }

    fn send(harness: &mut Window, command: Command) {
        let ctx = harness.ctx.clone();
        harness.state_mut().apply(&ctx, command);
    }

    fn told(harness: &Window, item: Item) -> Option<i64> {
        let parts = view(harness.state()).parts.list();
        let found = parts.into_iter().find(|(i, _)| *i == item);
        found.map(|(_, cost)| cost.bytes as i64)
    }

    /// A window on a scene with everything that a map can have, its plots closed: they grow with time.
    fn opened(folder: &std::path::Path) -> Window {
        let path = folder.join("all.toml");
        std::fs::write(&path, EDITED.on_back(20_389)).unwrap();
        let mut harness = workbench(folder.to_owned());
        send(&mut harness, Command::ClosePanel("plots"));
        let before = view(harness.state()).scene_generation;
        harness
            .state_mut()
            .shared()
            .bench()
            .open(Source::File(path));
        wait_for(&mut harness, "the scene", |w| {
            view(w).scene_generation > before
        });
        harness
    }

    #[test]
    fn a_workbench_that_is_closed_leaves_nothing() {
        let _alone = alone();
        let folder = tempfile::tempdir().unwrap();
        let mut left = Vec::new();
        // What is made once in a program's life is there after the first.
        for _ in 0..3 {
            let mut harness = opened(folder.path());
            let open = heap(&mut harness);
            drop(harness);
            left.push((open, settled(|| ())));
        }
        println!("open and left: {left:?}");
        assert!((left[2].1 - left[1].1).abs() < STILL_BYTES, "{left:?}");
    }

    #[test]
    fn what_a_panel_built_is_gone_when_it_is_closed() {
        let _alone = alone();
        let folder = tempfile::tempdir().unwrap();
        let mut harness = opened(folder.path());
        for (key, item) in [
            ("partition", Item::PartitionTree),
            ("ellipse_map", Item::EllipseEditor),
            ("stiffness_map", Item::StiffnessEditor),
        ] {
            assert_eq!(told(&harness, item), None, "{key} is built before it opens");
            let never = heap(&mut harness);
            let mut held = Vec::new();
            for _ in 0..2 {
                send(&mut harness, Command::ShowPanel(key));
                wait_for(&mut harness, key, |w| {
                    view(w)
                        .parts
                        .list()
                        .iter()
                        .any(|(i, c)| *i == item && c.bytes > 10_000)
                });
                let open = heap(&mut harness);
                let told_bytes = told(&harness, item).unwrap();
                send(&mut harness, Command::ClosePanel(key));
                wait_for(&mut harness, "closing", |w| {
                    view(w).parts.list().iter().all(|(i, _)| *i != item)
                });
                held.push((open, told_bytes, heap(&mut harness)));
            }
            println!("{key}: never {never} then {held:?}");
            let [(first, told, closed), (again, _, closed_again)] = held[..] else {
                panic!("twice");
            };
            println!(
                "{key}: opens for {} told {told}, again for {}, leaves {} and {}",
                first - never,
                again - closed,
                closed - never,
                closed_again - closed
            );
            // The first time the toolkit learns; then a panel comes and goes.
            assert!(closed - never < TOOLKIT_BYTES, "{key} {held:?}");
            assert!((closed_again - closed).abs() < 64_000, "{key} {held:?}");
            let off = again - closed - told;
            assert!(off.abs() < TOOLKIT_BYTES, "{key}: {off} {held:?}");
        }
    }

    #[test]
    fn a_plotted_past_holds_what_it_tells() {
        let _alone = alone();
        let before = settled(|| ());
        let mut history = History::new(1000.0);
        for tick in 0..40_000 {
            history.push(&support::touching(0, tick, 5.0));
            history.push(&support::touching(1, tick, 3.0));
        }
        let held = settled(|| ()) - before;
        let told = history.bytes() as i64;
        println!("history: {held} told {told}");
        assert!(
            (held - told).abs() < held / 50 + STILL_BYTES,
            "{held} {told}"
        );
        history.clear();
        assert!(settled(|| ()) - before < 64_000);
        // While no plot is open none is kept.
        let folder = tempfile::tempdir().unwrap();
        let mut harness = opened(folder.path());
        let kept = |h: &Window| view(h.state()).history.lock().unwrap().bytes();
        harness.run_steps(2);
        assert_eq!(kept(&harness), 0);
        send(&mut harness, Command::ShowPanel("plots"));
        let started = Instant::now();
        while kept(&harness) == 0 {
            assert!(
                started.elapsed() < Duration::from_secs(30),
                "nothing is plotted"
            );
            harness.run_steps(1);
            std::thread::sleep(Duration::from_millis(10));
        }
        send(&mut harness, Command::ClosePanel("plots"));
        harness.run_steps(2);
        assert_eq!(kept(&harness), 0);
    }

    #[test]
    fn a_recording_holds_nothing_once_it_ends() {
        let _alone = alone();
        let folder = tempfile::tempdir().unwrap();
        let mut harness = opened(folder.path());
        for _ in 0..2 {
            let before = heap(&mut harness);
            assert_eq!(view(harness.state()).recorder.held_bytes, 0);
            send(&mut harness, Command::Do(Action::Record));
            wait_for(&mut harness, "ticks", |w| {
                let recorder = view(w).recorder;
                recorder.recording.is_some() && recorder.time_s > 1.0
            });
            let during = Heap::now().unwrap().held;
            let told = view(harness.state()).recorder.held_bytes;
            send(&mut harness, Command::Do(Action::Record));
            wait_for(&mut harness, "the end", |w| {
                view(w).recorder.recording.is_none()
            });
            let after = heap(&mut harness);
            println!(
                "recorder: {} told {told}, leaves {}",
                during - before,
                after - before
            );
            assert_eq!(view(harness.state()).recorder.held_bytes, 0);
        }
    }

    /// Nothing shows the skin: its bones and ellipses go, the finger feels what it felt, and all comes back.
    #[test]
    fn a_closed_back_view_keeps_neither_bones_nor_ellipses() {
        let _alone = alone();
        let folder = tempfile::tempdir().unwrap();
        let mut harness = opened(folder.path());
        let built = |harness: &Window| {
            let scene = view(harness.state()).scene.unwrap();
            (scene.ellipse_field.is_some(), scene.deform.bones.is_some())
        };
        assert_eq!(built(&harness), (true, true));
        let ledger = view(harness.state()).scene.unwrap().ledger.clone();
        let told = ledger.row(Item::EllipseField).bytes + ledger.row(Item::Bones).bytes;
        let open = heap(&mut harness);
        let live = view(harness.state()).live;
        send(&mut harness, Command::ClosePanel("back_view"));
        wait_for(&mut harness, "the smaller scene", |w| {
            let scene = view(w).scene.unwrap();
            scene.ellipse_field.is_none() && scene.deform.bones.is_none()
        });
        let closed = heap(&mut harness);
        println!("closed: {} told {told}", open - closed);
        assert!(
            (open - closed - told as i64).abs() < 64_000,
            "{open} {closed} {told}"
        );
        let now = view(harness.state());
        assert_eq!(
            (now.live.edit, now.scene_generation),
            (live.edit, now.scene_generation)
        );
        assert!(!now.unsaved);
        // An edit meanwhile builds neither; the view opens on what was edited.
        let source = now.scene.unwrap().scenario.source.replace("1.1 }", "1.2 }");
        send(
            &mut harness,
            Command::EditScene {
                source: source.clone(),
            },
        );
        wait_for(&mut harness, "the edit", |w| view(w).live.edit > live.edit);
        assert_eq!(built(&harness), (false, false));
        send(&mut harness, Command::ShowPanel("back_view"));
        wait_for(&mut harness, "the whole scene", |w| {
            let scene = view(w).scene.unwrap();
            scene.ellipse_field.is_some() && scene.deform.bones.is_some()
        });
        let again = heap(&mut harness);
        // The servo keeps the stiffness from before the edit until the next one.
        let kept = 8 * view(harness.state())
            .scene
            .unwrap()
            .surface
            .positions()
            .len() as i64;
        println!("opened again: {} with {kept}", again - open);
        assert!((again - open - kept).abs() < 64_000, "{open} {again}");
        let now = view(harness.state());
        assert_eq!(now.scene.unwrap().scenario.source, source);
        assert_eq!(now.live.edit, live.edit + 1, "what is felt is one edit");
    }

    /// With a screen: the mesh, the deformation and the colour of the skin.
    #[test]
    fn a_closed_back_view_frees_its_mesh_and_its_deformation() {
        let _alone = alone();
        let Some(screen) = gl::OffScreen::or_skip(gl::Api::Core33, [800, 600]) else {
            return;
        };
        let painter = Rc::new(RefCell::new(gl::Painter::new(&screen)));
        // So small that its shading is there at once, and not whenever a thread has made it.
        let scenario = Scenario::parse(&EDITED.on_back(2962), "drawn", None).unwrap();
        let purpose = Use {
            drawn: true,
            ..Use::default()
        };
        let scene = scenario::build(Arc::new(scenario), purpose, &mut |_, _| true).unwrap();
        let mut seen = support::running();
        seen.scene = Some(Arc::new(scene));
        seen.fingers.clear();
        seen.gl = Some(screen.gl.clone());
        let parts = seen.parts.clone();
        let closed = Arc::new(AtomicBool::new(true));
        let is_closed = closed.clone();
        let (send, _commands) = command::queue(Arc::new(|| {}));
        let mut panel = BackView::default();
        let mut harness = Harness::builder()
            .with_size([800.0, 600.0])
            .with_context_setup(egui_material_icons::initialize)
            .build_ui(move |ui| {
                let cx = PanelContext {
                    view: &seen,
                    send: &send,
                };
                if is_closed.load(Ordering::Relaxed) {
                    panel.release(&seen);
                } else {
                    panel.ui(ui, &cx);
                }
            });
        let mut looks = Vec::new();
        let mut before = settled(|| harness.run_steps(2));
        assert!(parts.list().is_empty());
        for _ in 0..3 {
            closed.store(false, Ordering::Relaxed);
            harness.run_steps(3);
            let shapes = harness.output().shapes.clone();
            painter.borrow_mut().paint(&screen, &harness.ctx, shapes);
            let open = settled(|| harness.run_steps(2));
            let told: usize = parts.list().iter().map(|(_, cost)| cost.bytes).sum();
            closed.store(true, Ordering::Relaxed);
            let after = settled(|| harness.run_steps(3));
            assert!(parts.list().is_empty());
            looks.push((open - before, told, after - before));
            before = after;
        }
        println!("back view: {looks:?}");
        // The first time the toolkit and the renderer learn; then it comes and goes.
        for (opens_for, told, leaves) in &looks[1..] {
            let off = opens_for - *told as i64;
            assert!(off.abs() < TOOLKIT_BYTES, "{looks:?}");
            assert!(leaves.abs() < 16_000, "{looks:?}");
        }
    }
}
