//! The map editors driven by their accessibility tree, as a person with a keyboard, a mouse or a screen reader would.
#![cfg(feature = "gui")]
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot be set up has failed"
)]

mod support;

use dorsum::app::panels::ellipse_map::EllipseMapPanel;
use dorsum::app::panels::stiffness_map::StiffnessMapPanel;
use dorsum::geom::Vec2;
use dorsum::maps::{EllipseMap, Fit, Form, Level, StiffnessMap, appendix};
use dorsum::scenario::{self, Item};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use support::panel_window::{Window, scene_of};

const STIFF: &str = r#"format = 1
name = "Editors"
# A comment that stays.
[surface]
builtin = "back"
triangles = 2962
[stiffness]
fit = "natural"
key = [
  { x = 0, y = 334.9, stiffness_n_per_mm = 1.1 }, # T5
  { x = -60, y = 220, stiffness_n_per_mm = 0.4 },
  { x = 60, y = 220, stiffness_n_per_mm = 0.4 },
  { x = 0, y = 94.6, stiffness_n_per_mm = 1.2 },
]
"#;

fn ellipse_panel(source: &str) -> Window {
    Window::open(EllipseMapPanel::default(), source, [1100.0, 1400.0])
}

fn stiff(source: &str) -> Window {
    Window::open(StiffnessMapPanel::default(), source, [1100.0, 1400.0])
}

fn seven() -> String {
    let keys = appendix::seven_keys(appendix::Force::Up, None);
    let settings = dorsum::maps::EllipseSettings::default();
    scenario::edit::with_ellipse(STIFF, Some((&keys, &settings))).unwrap()
}

fn ellipse(window: &Window) -> EllipseMap {
    let (keys, settings) = window.scenario().ellipse.unwrap();
    EllipseMap::new(keys, settings).unwrap()
}

fn stiffness(window: &Window) -> StiffnessMap {
    let s = window.scenario();
    let map = StiffnessMap::new(s.stiffness_keys, s.stiffness_fit).unwrap();
    map.with_strokes(s.strokes).unwrap()
}

#[test]
fn a_number_typed_reaches_the_scene_and_undo_and_redo_go_back_and_forth() {
    let mut window = ellipse_panel(&seven());
    assert!(window.sent.is_empty(), "looking changes nothing");
    window.set("Half major axis of P4, mm", 160.0);
    assert_eq!(window.sent.len(), 1);
    let after = window.scenario();
    let key = &after.ellipse.unwrap().0[3];
    assert_eq!((key.name.as_str(), key.half_major_mm), ("P4", 160.0));
    assert!(after.source.contains("# A comment that stays."));
    let at = key.at;
    assert_eq!(ellipse(&window).at(at).half_major_mm, 160.0);
    window.click("Undo");
    assert_eq!(ellipse(&window).at(at).half_major_mm, 179.0);
    window.click("Redo");
    assert_eq!(ellipse(&window).at(at).half_major_mm, 160.0);
    window.harness.check_accessibility();
}

#[test]
fn what_is_not_allowed_is_held_and_told_at_once() {
    let mut window = ellipse_panel(&seven());
    window.set("Half minor axis of P1, mm", 500.0);
    let key = window.scenario().ellipse.unwrap().0[0].clone();
    assert_eq!(
        key.half_minor_mm, key.half_major_mm,
        "the minor axis is the shorter one"
    );
    window.set("Half major axis of P1, mm", -5.0);
    assert!(window.says("-5 is outside 1 to 1000; set to 1"));
    let key = window.scenario().ellipse.unwrap().0[0].clone();
    assert_eq!(key.half_major_mm, 1.0);
    let mut window = stiff(STIFF);
    window.set("Stiffness of key 2, N/mm", -1.0);
    assert!(window.says("-1 is outside 0.001 to 10000; set to 0.001"));
    assert_eq!(
        window.scenario().stiffness_keys[1].stiffness_n_per_mm,
        0.001
    );
    window.set("Stiffness of key 2, N/mm", f64::NAN);
    assert_eq!(
        window.scenario().stiffness_keys[1].stiffness_n_per_mm,
        0.001
    );
}

#[test]
fn a_drag_moves_a_key_in_one_step_and_the_scene_hears_of_it_on_the_way() {
    let mut window = ellipse_panel(&seven());
    let before = ellipse(&window).keys().to_vec();
    let from = window.at("Ellipse key P4");
    window.drag(from, egui::vec2(30.0, 12.0), Modifiers::NONE);
    let after = ellipse(&window).keys().to_vec();
    let moved = after[3].at - before[3].at;
    assert!(moved.x > 10.0 && moved.y < -4.0, "{moved}");
    assert!((moved.x / moved.y + 30.0 / 12.0).abs() < 0.05, "{moved}");
    for i in [0, 1, 2, 4, 5, 6] {
        assert_eq!(after[i].at, before[i].at);
    }
    let here = window.at("Ellipse key P4");
    assert!((here - from - egui::vec2(30.0, 12.0)).length() < 1.0);
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(ellipse(&window).keys()[3].at, before[3].at, "one step");
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(ellipse(&window).keys()[3].at, after[3].at);
    window.press(Modifiers::COMMAND, Key::Z);
    window.press(Modifiers::COMMAND, Key::Y);
    assert_eq!(ellipse(&window).keys()[3].at, after[3].at);
}

#[test]
fn handles_change_axes_and_direction_and_keys_of_the_keyboard_do_the_same() {
    let mut window = ellipse_panel(&seven());
    window.harness.get_by_label("Ellipse key P1").focus();
    window.frames(3);
    // P1 stands upright: its major axis ends above it.
    let end = window.at("Half major axis of P1");
    let centre = window.at("Ellipse key P1");
    assert!((end.x - centre.x).abs() < 1.0 && end.y < centre.y);
    window.drag(end, egui::vec2(0.0, -15.0), Modifiers::NONE);
    let longer = ellipse(&window).keys()[0].clone();
    assert!(longer.half_major_mm > 190.0, "{longer:?}");
    window.harness.get_by_label("Direction of P1").focus();
    window.frames(2);
    window.press(Modifiers::NONE, Key::ArrowUp);
    let turned = ellipse(&window).keys()[0].clone();
    assert!((turned.angle_rad.to_degrees() - 91.0).abs() < 1e-9);
    window.harness.get_by_label("Ellipse key P1").focus();
    window.frames(2);
    window.press(Modifiers::SHIFT, Key::ArrowLeft);
    window.press(Modifiers::NONE, Key::ArrowUp);
    let pushed = ellipse(&window).keys()[0].clone();
    assert_eq!(pushed.at - turned.at, Vec2::new(-10.0, 1.0));
    window.press(Modifiers::NONE, Key::Delete);
    assert_eq!(ellipse(&window).keys().len(), 6);
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(ellipse(&window).keys()[0], pushed);
}

#[test]
fn mirrored_keys_lie_on_the_other_side_with_their_directions_turned() {
    let mut window = ellipse_panel(&seven());
    let before = ellipse(&window).keys().to_vec();
    window.click("Mirror");
    window.click("All keys");
    let after = ellipse(&window).keys().to_vec();
    for (a, b) in after.iter().zip(&before) {
        assert_eq!(a.at, Vec2::new(-b.at.x, b.at.y));
        let sum = a.angle_rad + b.angle_rad;
        assert!(sum.sin().abs() < 1e-9, "{a:?} {b:?}");
    }
    // The measured keys are symmetric, so the map is the same.
    let (a, b) = (
        ellipse(&window),
        EllipseMap::new(before, *ellipse(&window).settings()).unwrap(),
    );
    for p in [Vec2::new(-80.0, 260.0), Vec2::new(30.0, 150.0)] {
        assert!((a.at(p).half_major_mm - b.at(p).half_major_mm).abs() < 1e-6);
    }
}

#[test]
fn form_angle_and_level_are_chosen_and_figures_load_their_keys() {
    let mut window = ellipse_panel(&seven());
    window.click("Published form");
    window.click("Array of 700 level");
    let settings = *ellipse(&window).settings();
    assert_eq!(
        (settings.form, settings.level),
        (Form::Published, Level::Array)
    );
    window.set("Effect radius, mm", 150.0);
    assert_eq!(ellipse(&window).settings().effect_radius_mm, 150.0);
    window.click("Figures");
    window.click("5.10 Results satisfy all the key points");
    let map = ellipse(&window);
    for y in [150.0, 60.0, -30.0] {
        assert_eq!(map.at(Vec2::new(0.0, y)).half_major_mm, 120.0);
    }
    window.click("Undo");
    assert_eq!(ellipse(&window).keys().len(), 7);
    assert_eq!(ellipse(&window).settings().form, Form::Published);
    window.click("Remove the ellipse map");
    assert!(window.scenario().ellipse.is_none());
    window.click("Add the seven keys of appendix C");
    assert_eq!(ellipse(&window).keys().len(), 7);
}

#[test]
fn an_irregular_boundary_has_its_radii_as_handles_and_numbers() {
    let mut window = ellipse_panel(&seven());
    window.click("Choose key P2");
    window.click("Irregular boundary");
    window.set("Radius at 0° of P2, mm", 90.0);
    let key = ellipse(&window).keys()[1].clone();
    let radii = key.boundary_mm.unwrap();
    assert_eq!((radii.len(), radii[0]), (12, 90.0));
    let handle = window.at("Boundary of P2 at 90°");
    window.drag(handle, egui::vec2(0.0, -10.0), Modifiers::NONE);
    let after = ellipse(&window).keys()[1].boundary_mm.clone().unwrap();
    assert!(after[3] > radii[3] + 5.0 && after[0] == 90.0, "{after:?}");
}

#[test]
fn a_bad_table_is_told_in_one_line_and_changes_nothing_and_a_good_one_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    for (bad, good, ellipses) in [
        (
            "x_mm,y_mm,stiffness_n_per_mm\n0,0,0.5\n0,50,-1\n",
            "x_mm,y_mm,stiffness_n_per_mm\n0,0,0.5\n0,50,1.5\n",
            false,
        ),
        (
            "name,x_mm,y_mm,half_major_mm,half_minor_mm,angle_deg\nA,0,0,100,90,1e9\n",
            "name,x_mm,y_mm,half_major_mm,half_minor_mm,angle_deg\nA,0,0,100,90,45\n",
            true,
        ),
    ] {
        let mut window = if ellipses {
            ellipse_panel(&seven())
        } else {
            stiff(STIFF)
        };
        let import = if ellipses {
            "Import ellipse keys"
        } else {
            "Import stiffness keys"
        };
        let path = folder.path().join("keys.csv");
        window.click("File");
        window
            .harness
            .get_by_role_and_label(egui::accesskit::Role::TextInput, "Path")
            .focus();
        window.frames(1);
        window
            .harness
            .get_by_role_and_label(egui::accesskit::Role::TextInput, "Path")
            .type_text(&path.display().to_string());
        window.frames(2);
        let before = window.scenario();
        let _ = std::fs::remove_file(&path);
        window.click(import);
        assert!(window.says("keys.csv: cannot be read"));
        std::fs::write(&path, bad).unwrap();
        window.click(import);
        let line = if ellipses {
            "line 2: angle_deg"
        } else {
            "line 3: stiffness_n_per_mm"
        };
        assert!(window.says(&format!("keys.csv: {line}")));
        assert!(window.sent.is_empty());
        assert_eq!(window.scenario(), before);
        std::fs::write(&path, good).unwrap();
        window.click(import);
        let after = window.scenario();
        if ellipses {
            let keys = after.ellipse.unwrap().0;
            assert_eq!((keys.len(), keys[0].name.as_str()), (1, "A"));
        } else {
            assert_eq!(after.stiffness_keys.len(), 2);
            assert_eq!(after.stiffness_keys[1].stiffness_n_per_mm, 1.5);
        }
        let export = import.replace("Import", "Export");
        window.click(&export);
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text.lines().count(), good.lines().count());
        assert!(
            window.told.iter().any(|t| t.contains("written to")),
            "{:?}",
            window.told
        );
    }
}

#[test]
fn a_brush_stroke_is_one_step_raises_the_map_and_alt_lowers_it() {
    let mut window = stiff(STIFF);
    let canvas = window
        .harness
        .get_by_label_contains("Stiffness map. Arrow keys")
        .rect();
    window.click("Take the brush");
    window.set("Radius of the brush, mm", 30.0);
    window.set("Change by the brush, percent", 50.0);
    let before = stiffness(&window);
    window.drag(canvas.center(), egui::vec2(60.0, 0.0), Modifiers::NONE);
    let strokes = window.scenario().strokes;
    assert_eq!(strokes.len(), 1);
    assert!(
        strokes[0].path.len() >= 3 && strokes[0].change == 0.5,
        "{strokes:?}"
    );
    assert_eq!(strokes[0].radius_mm, 30.0);
    let middle = strokes[0].path[1];
    let after = stiffness(&window);
    assert!((after.at(middle) / before.at(middle) - 1.5).abs() < 1e-6);
    window.drag(canvas.center(), egui::vec2(0.0, 40.0), Modifiers::ALT);
    let strokes = window.scenario().strokes;
    assert_eq!((strokes.len(), strokes[1].change), (2, -0.5));
    window.click("Undo");
    assert_eq!(window.scenario().strokes.len(), 1);
    window.click("Redo");
    window.click("Remove stroke 1");
    let strokes = window.scenario().strokes;
    assert_eq!((strokes.len(), strokes[0].change), (1, -0.5));
    window.set("Change of stroke 1, percent", 25.0);
    assert_eq!(window.scenario().strokes[0].change, 0.25);
    window.harness.check_accessibility();
}

#[test]
fn fits_are_chosen_and_compared_and_the_best_is_marked() {
    let mut window = stiff(STIFF);
    for &fit in Fit::all() {
        window.click(&format!("Fit {}", fit.name()));
        assert_eq!(window.scenario().stiffness_fit, fit);
    }
    window.click("Comparison of fits");
    let start = Instant::now();
    while !window.says("best") {
        assert!(start.elapsed() < Duration::from_secs(30), "never compared");
        window.frames(1);
        std::thread::sleep(Duration::from_millis(5));
    }
    let keys = window.scenario().stiffness_keys;
    let errors = dorsum::app::panels::stiffness_map::compare::compare(&keys, &|| true).unwrap();
    let best = dorsum::app::panels::stiffness_map::compare::best(&errors).unwrap();
    window.click(&format!("Use fit {}", best.name()));
    assert_eq!(window.scenario().stiffness_fit, best);
    window.click("Section");
    window.click("Every fit");
    window.frames(4);
    window.harness.check_accessibility();
}

#[test]
fn keys_are_added_moved_copied_and_removed_but_never_the_last() {
    let mut window = stiff(STIFF);
    window.click("Add key");
    assert_eq!(window.scenario().stiffness_keys.len(), 5);
    window.click("Duplicate key");
    assert_eq!(window.scenario().stiffness_keys.len(), 6);
    for _ in 0..8 {
        window.click("Choose key 1");
        window.click("Remove key");
    }
    assert_eq!(window.scenario().stiffness_keys.len(), 1);
    assert!(window.says("The last key stays"));
}

#[test]
fn what_others_change_is_followed_and_another_scene_starts_anew() {
    let mut window = stiff(STIFF);
    window.set("Stiffness of key 1, N/mm", 2.0);
    let other = window.scenario().source.replace("0.4", "0.6");
    {
        let mut view = window.view.lock().unwrap();
        view.scene = Some(scene_of(&other));
        view.edit += 1;
    }
    window.settle();
    assert_eq!(window.sent.len(), 1, "following sends nothing back");
    window.click("Undo");
    let keys = window.scenario().stiffness_keys;
    assert_eq!(
        (keys[0].stiffness_n_per_mm, keys[1].stiffness_n_per_mm),
        (2.0, 0.4)
    );
    {
        let mut view = window.view.lock().unwrap();
        view.scene = Some(scene_of(&STIFF.replace("1.1", "0.9")));
        view.scene_generation = 2;
    }
    window.settle();
    let sent = window.sent.len();
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.sent.len(), sent, "another scene has no past");
}

#[test]
fn keys_on_one_place_are_told_and_do_not_reach_the_scene() {
    let mut window = ellipse_panel(&seven());
    let other = ellipse(&window).keys()[1].at;
    window.set("y of P1, mm", other.y);
    assert!(window.says("P1") && window.says("P2"));
    assert!(window.sent.is_empty());
    window.click("Undo");
    window.set("y of P1, mm", other.y + 40.0);
    assert_eq!(ellipse(&window).keys()[0].at.y, other.y + 40.0);
}

#[test]
fn a_closed_panel_holds_nothing_and_a_replay_cannot_be_edited() {
    let mut window = stiff(STIFF);
    let surface = {
        let view = window.view.lock().unwrap();
        view.scene.as_ref().unwrap().surface.clone()
    };
    let open = Arc::strong_count(&surface);
    let held = |window: &Window| {
        let parts = window.view.lock().unwrap().parts.list();
        let editor = parts.into_iter().find(|(i, _)| *i == Item::StiffnessEditor);
        editor.map(|(_, cost)| cost.bytes)
    };
    assert!(held(&window).is_some_and(|bytes| bytes > 10_000));
    window.closed.store(true, Ordering::Relaxed);
    window.frames(2);
    assert!(Arc::strong_count(&surface) < open);
    assert_eq!(held(&window), None);
    window.closed.store(false, Ordering::Relaxed);
    let replaying = support::views()
        .into_iter()
        .find(|(n, _)| *n == "replaying");
    window.view.lock().unwrap().playback = replaying.unwrap().1.playback;
    window.frames(3);
    assert!(window.says("go back to live to edit"));
    window.click("Fit gri");
    window.set("Stiffness of key 1, N/mm", 2.0);
    assert!(window.sent.is_empty());
}
