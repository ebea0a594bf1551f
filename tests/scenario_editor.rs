//! The scenario editor driven by its accessibility tree, as a person with a keyboard, a mouse or a screen reader would.
#![cfg(feature = "gui")]
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot be set up has failed"
)]

mod support;

use dorsum::app::command::Command;
use dorsum::app::panels::Panel as _;
use dorsum::app::panels::library::LibraryPanel;
use dorsum::app::panels::scenario_editor::{ScenarioEditorPanel, doc};
use dorsum::geom::Vec2;
use dorsum::scenario::exercise::{Feedback, Hides, Staircase, Step};
use dorsum::scenario::{
    self, Change, Dysfunction, Exercise, Item, Place, Scenario, Side, Site, Target, VertebralLevel,
    dysfunction, sites,
};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use support::panel_window::{Window, scene_of};

const PLAIN: &str = r#"format = 1
name = "Plain"
# A comment that stays.
[surface]
builtin = "back"
triangles = 2962
[stiffness]
constant_n_per_mm = 0.5 # as stiff as this
[friction]
static = 0.46
dynamic = 0.44
"#;

fn open(source: &str) -> Window {
    Window::open(ScenarioEditorPanel::default(), source, [1100.0, 1500.0])
}

fn list(window: &Window) -> Vec<Dysfunction> {
    window.scenario().dysfunctions
}

fn place(window: &Window, index: usize) -> String {
    list(window)[index].place.to_string()
}

fn site(text: &str) -> Site {
    sites(text).unwrap()[0]
}

/// Opens the list called `name` and picks `text`.
fn pick(window: &mut Window, name: &str, text: &str) {
    window.click(name);
    window.click(text);
}

/// Types into the field called `name`, in place of what is there, and enters it.
fn enter(window: &mut Window, name: &str, text: &str) {
    window.harness.get_by_label(name).focus();
    window.frames(2);
    window.press(Modifiers::COMMAND, Key::A);
    window.harness.get_by_label(name).type_text(text);
    window.frames(2);
    window.press(Modifiers::NONE, Key::Enter);
}

#[test]
fn one_is_added_changed_undone_and_redone_and_the_file_keeps_its_comments() {
    let mut window = open(PLAIN);
    assert!(window.sent.is_empty(), "looking changes nothing");
    window.click("Add dysfunction");
    assert_eq!(place(&window, 0), "T5 right transverse process");
    pick(&mut window, "Level of dysfunction 1", "T7");
    assert_eq!(place(&window, 0), "T7 right transverse process");
    window.click("left side of dysfunction 1");
    assert_eq!(place(&window, 0), "T7 left transverse process");
    pick(&mut window, "Target of dysfunction 1", "muscle");
    pick(&mut window, "Last level of dysfunction 1", "T9");
    assert_eq!(place(&window, 0), "T7-T9 left muscles");
    window.click("Strength of dysfunction 1 as compliance");
    window.set("Compliance change of dysfunction 1, %", -50.0);
    let d = list(&window)[0].clone();
    assert_eq!(d.change, Some(Change::CompliancePercent(-50.0)));
    assert!(window.says("compliance −50 % = stiffness +100 %"));
    let text = window.scenario().source;
    assert!(text.contains("# A comment that stays.") && text.contains("# as stiff as this"));
    for _ in 0..6 {
        window.click("Undo");
    }
    assert_eq!(place(&window, 0), "T5 right transverse process");
    window.click("Undo");
    assert_eq!(
        window.scenario().source,
        PLAIN,
        "back to the file to the letter"
    );
    for _ in 0..7 {
        window.click("Redo");
    }
    assert_eq!(list(&window), [d]);
    window.harness.check_accessibility();
}

#[test]
fn every_kind_goes_through_file_editor_and_file_and_stays_the_same() {
    // Fine enough for the smallest of them.
    let fine = PLAIN.replace("triangles = 2962", "triangles = 41582");
    for kind in dysfunction::all() {
        let mut window = open(&fine);
        pick(&mut window, "Kind to add", kind.title());
        pick(&mut window, "Level to add at", "T8");
        window.click("Severity 3 of what is added");
        window.click("Add dysfunction");
        let site = site("T8 right");
        let wanted = kind.default_of(site, 3);
        assert_eq!(list(&window), [wanted], "{}", kind.key());
        // Every number of the form.
        for (name, value) in [
            ("First half axis of dysfunction 1, mm", 21.5),
            ("Second half axis of dysfunction 1, mm", 13.0),
            ("Angle of dysfunction 1, °", 35.0),
            ("Offset outwards of dysfunction 1, mm", 2.5),
            ("Offset upwards of dysfunction 1, mm", -3.0),
            ("Bump of dysfunction 1, mm", 0.8),
            ("Skin drag of dysfunction 1, ×", 1.3),
        ] {
            window.set(name, value);
        }
        pick(&mut window, "Falloff of dysfunction 1", "gaussian");
        window.click("Severity 1 of dysfunction 1");
        window.click("Strength of dysfunction 1 as stiffness");
        window.set("Stiffness change of dysfunction 1, %", 44.0);
        window.click("Dysfunction 1 varies by seed");
        window.set("Seed of dysfunction 1", 7.0);
        let d = list(&window)[0].clone();
        let stated = Dysfunction {
            radius_mm: [21.5, 13.0],
            angle_deg: 35.0,
            offset_mm: Vec2::new(2.5, -3.0),
            bump_mm: Some(0.8),
            skin_drag: Some(1.3),
            profile: "gaussian".into(),
            severity: 1,
            change: Some(Change::StiffnessPercent(44.0)),
            seed: Some(7),
            ..kind.default_of(site, 3)
        };
        assert_eq!(d, stated, "{}", kind.key());
        // The file is opened anew: the editor has the same, and sends nothing.
        let text = window.scenario().source;
        let again = open(&text);
        assert_eq!(list(&again), [stated], "{}", kind.key());
        assert!(again.sent.is_empty());
        let read = Scenario::parse(&text, "again.toml", None).unwrap();
        assert_eq!(doc_of(&read, &text), text, "{}", kind.key());
    }
}

/// What the editor writes of a scenario that it did not change.
fn doc_of(scenario: &Scenario, text: &str) -> String {
    use dorsum::app::editor::editing::Document as _;
    doc::Doc::of(scenario).write(text).unwrap()
}

#[test]
fn a_click_on_a_site_adds_there_and_a_drag_goes_from_site_to_site() {
    let mut window = open(PLAIN);
    window.click("Add dysfunction");
    let first = "Dysfunction 1: Hypertonic muscle, T5 right transverse process";
    let at = window.at(first);
    window.click("left side of dysfunction 1");
    let mirror = window.at("Dysfunction 1: Hypertonic muscle, T5 left transverse process");
    // Points per mm, from the two sides.
    let t5 = site("T5 right");
    let per_mm = (at.x - mirror.x) / (2.0 * t5.at_mm().x as f32);
    assert!(per_mm > 0.3, "{per_mm}");
    let to = |s: Site| {
        let by = s.at_mm() - t5.at_mm();
        at + egui::vec2(by.x as f32, -by.y as f32) * per_mm
    };
    let rib = Site {
        level: VertebralLevel::named("T8").unwrap(),
        side: Side::Right,
        target: Target::RibAngle,
    };
    window.pointer(to(rib), None, Modifiers::NONE);
    window.pointer(to(rib), Some(true), Modifiers::NONE);
    window.pointer(to(rib), Some(false), Modifiers::NONE);
    window.settle();
    assert_eq!(place(&window, 1), "T8 right rib angle");
    let by = to(t5) - to(rib) + egui::vec2(2.0, 2.0);
    window.drag(to(rib), by, Modifiers::NONE);
    assert_eq!(list(&window)[1].place, Place::from(t5));
    assert_eq!(list(&window)[1].offset_mm, Vec2::ZERO);
    window.click("Undo");
    assert_eq!(
        place(&window, 1),
        "T8 right rib angle",
        "a drag is one step"
    );
    window.drag(to(rib), egui::vec2(6.0, 0.0), Modifiers::ALT);
    let d = list(&window)[1].clone();
    assert_eq!(d.place, Place::from(rib));
    assert!(
        (d.offset_mm.x - 6.0 / f64::from(per_mm)).abs() < 1.0,
        "{d:?}"
    );
}

#[test]
fn order_copies_mirror_images_and_removal_by_buttons_and_keys() {
    let mut window = open(PLAIN);
    window.click("Add dysfunction");
    window.click("Duplicate dysfunction");
    assert_eq!(place(&window, 1), "T6 right transverse process");
    window.click("Copy dysfunction to the other side");
    assert_eq!(place(&window, 2), "T6 left transverse process");
    window.click("Mirror dysfunction");
    assert!(
        window.says("keep one of them"),
        "two of a kind at one place are told"
    );
    assert_eq!(
        place(&window, 2),
        "T6 left transverse process",
        "and not sent"
    );
    window.click("Undo");
    assert!(!window.says("keep one of them"));
    window.click("Choose dysfunction 3");
    window.click("Earlier in the order");
    assert_eq!(place(&window, 1), "T6 left transverse process");
    window.click("Later in the order");
    assert_eq!(place(&window, 2), "T6 left transverse process");
    window.harness.get_by_label("Choose dysfunction 1").focus();
    window.frames(2);
    window.press(Modifiers::ALT, Key::ArrowDown);
    assert_eq!(place(&window, 1), "T5 right transverse process");
    window
        .harness
        .get_by_label("Dysfunction 2: Hypertonic muscle, T5 right transverse process")
        .focus();
    window.frames(2);
    window.press(Modifiers::NONE, Key::ArrowRight);
    assert_eq!(list(&window)[1].offset_mm, Vec2::new(1.0, 0.0));
    window
        .harness
        .get_by_label("First half axis of dysfunction 2")
        .focus();
    window.frames(2);
    let before = list(&window)[1].radius_mm;
    window.press(Modifiers::NONE, Key::ArrowUp);
    assert_eq!(list(&window)[1].radius_mm, [before[0] + 1.0, before[1]]);
    window
        .harness
        .get_by_label("Direction of dysfunction 2")
        .focus();
    window.frames(2);
    window.press(Modifiers::NONE, Key::ArrowUp);
    assert_eq!(list(&window)[1].angle_deg, 81.0);
    window.click("Angle as the kind says");
    assert_eq!(list(&window)[1].angle_deg, 80.0);
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(list(&window)[1].angle_deg, 81.0);
    window.click("Remove dysfunction");
    assert_eq!(list(&window).len(), 2);
    window.harness.check_accessibility();
}

#[test]
fn what_cannot_be_is_told_in_one_line_and_is_not_sent() {
    let mut window = open(PLAIN);
    window.click("Add dysfunction");
    let sent = window.sent.len();
    enter(&mut window, "Sites of dysfunction 1", "T5 up");
    assert!(window.says("T5 up"));
    enter(&mut window, "Sites of dysfunction 1", "L3 left rib angle");
    assert!(window.says("has no rib"));
    assert_eq!(window.sent.len(), sent);
    enter(
        &mut window,
        "Sites of dysfunction 1",
        "T3 left muscle; L1-L3 right",
    );
    assert_eq!(
        list(&window)[0].place,
        Place::Sites(sites("T3 left muscle; L1-L3 right").unwrap())
    );
    window.click("Strength of dysfunction 1 as compliance");
    window.set("Compliance change of dysfunction 1, %", -95.0);
    assert!(
        window.says("-95 is outside -90 to 9900"),
        "held to what is allowed"
    );
    window.click("Name and description");
    enter(&mut window, "Name of the scenario", "Another");
    assert_eq!(window.scenario().name, "Another");
    window.click("Differences from the file");
    assert!(window.says("− name = \"Plain\"") && window.says("+ name = \"Another\""));
    window.harness.check_accessibility();
}

#[test]
fn one_is_drawn_among_the_sites_by_its_seed() {
    let mut window = open(PLAIN);
    window.click("Draw at random");
    window.set("Seed to draw by", 11.0);
    window.click("Add drawn dysfunctions");
    let first = list(&window);
    let among = sites("T1-T12 both sides").unwrap();
    let Place::Sites(there) = &first[0].place else {
        panic!("a site");
    };
    assert!(there.len() == 1 && among.contains(&there[0]));
    assert_eq!(first[0].change, Some(Change::CompliancePercent(-28.0)));
    window.set("How many to draw", 3.0);
    window.click("Replace dysfunctions by drawn ones");
    let three = list(&window);
    assert_eq!(
        (three.len(), &three[0]),
        (3, &first[0]),
        "the same seed begins the same"
    );
    window.click("Undo");
    assert_eq!(list(&window), first);
}

#[test]
fn what_others_change_is_followed_and_a_blind_or_closed_panel_holds_nothing() {
    let mut window = open(PLAIN);
    window.click("Add dysfunction");
    let other = window.scenario().source.replace("0.5 #", "0.6 #");
    {
        let mut view = window.view.lock().unwrap();
        view.scene = Some(scene_of(&other));
        view.edit += 1;
    }
    window.settle();
    let sent = window.sent.len();
    window.click("Severity 3 of dysfunction 1");
    assert_eq!(window.sent.len(), sent + 1);
    assert!(
        window.scenario().source.contains("0.6 #"),
        "the other edit stays"
    );
    let held = |window: &Window| window.view.lock().unwrap().parts.has(Item::ScenarioEditor);
    assert!(held(&window));
    window.view.lock().unwrap().blind = true;
    window.frames(3);
    assert!(!held(&window) && window.says("Hidden for now"));
    assert!(!window.says("T5"), "nothing tells the site");
    window.view.lock().unwrap().blind = false;
    window.frames(3);
    assert!(held(&window) && window.says("T5"));
    let surface = {
        let view = window.view.lock().unwrap();
        view.scene.as_ref().unwrap().surface.clone()
    };
    let before = Arc::strong_count(&surface);
    window.closed.store(true, Ordering::Relaxed);
    window.frames(2);
    assert!(Arc::strong_count(&surface) < before && !held(&window));
}

#[test]
fn an_exercise_is_added_filled_in_and_taken_out_and_the_file_says_so() {
    let mut window = open(PLAIN);
    window.click("Exercise");
    window.click("Add exercise");
    assert_eq!(window.scenario().exercise, Some(Exercise::default()));
    pick(&mut window, "Task of the exercise", "Free search");
    enter(
        &mut window,
        "Candidates of the exercise",
        "T3-T6 right muscle",
    );
    window.set("Scored trials", 24.0);
    window.set("Practice trials", 3.0);
    window.click("Limit of a trial is set");
    window.set("Limit of a trial, s", 45.0);
    window.click("Asks for kind");
    window.click("Feedback: right or wrong");
    window.click("Hidden strength as stiffness");
    window.set("Hidden strength, %", 60.0);
    window.click("Add staircase");
    window.click("Step in percent");
    window.set("Step, %", 4.0);
    let e = window.scenario().exercise.unwrap();
    let wanted = Exercise {
        task: "search",
        candidates: sites("T3-T6 right muscle").unwrap(),
        trials: 24,
        practice: 3,
        trial_limit_s: Some(45.0),
        asks_kind: true,
        feedback: Feedback::Right,
        hides: Hides::Drawn {
            kind: "hypertonic",
            change: Change::StiffnessPercent(60.0),
            most: 1,
        },
        staircase: Some(Staircase {
            step: Step::Percent(4.0),
            ..Staircase::default()
        }),
        ..Exercise::default()
    };
    assert_eq!(e, wanted);
    assert!(window.scenario().source.contains("# A comment that stays."));
    window.harness.check_accessibility();
    window.click("Remove exercise");
    assert_eq!(window.scenario().exercise, None);
    window.click("Undo");
    assert_eq!(window.scenario().exercise, Some(wanted));
}

#[test]
fn the_library_lists_examples_and_a_folder_and_opens_what_is_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let hard =
        format!("{PLAIN}[[dysfunction]]\nkind = \"hypertonic\"\nlevel = \"T9\"\nside = \"left\"\n")
            .replace("Plain", "Hard to find");
    std::fs::write(folder.path().join("hard.toml"), hard).unwrap();
    std::fs::write(folder.path().join("broken.toml"), "format = 1\n").unwrap();
    let mut panel = LibraryPanel::default();
    panel.recall(&format!("folder={}", folder.path().display()));
    let mut window = Window::open(panel, PLAIN, [460.0, 6000.0]);
    let start = Instant::now();
    let bytes = |window: &Window| {
        let parts = window.view.lock().unwrap().parts.list();
        let found = parts.into_iter().find(|(i, _)| *i == Item::Thumbnails);
        found.map_or(0, |(_, cost)| cost.bytes)
    };
    let all = (scenario::examples().len() + 1) * 168 * 200 * 4;
    while bytes(&window) < all {
        assert!(
            start.elapsed() < Duration::from_secs(60),
            "{} of {all}",
            bytes(&window)
        );
        window.frames(1);
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(
        window.says("Hard to find") && window.says("Hypertonic muscle, T9 left transverse process")
    );
    assert!(window.says("broken.toml: line 1"));
    window.harness.check_accessibility();
    window.click("Open Hard to find");
    let path = folder.path().join("hard.toml");
    assert_eq!(window.other, [Command::OpenScenario(path)]);
    enter(&mut window, "Filter", "hard to FIND");
    assert!(window.says("Hard to find") && !window.says("broken.toml"));
    window.view.lock().unwrap().blind = true;
    window.frames(3);
    assert!(
        window.says("Hard to find") && !window.says("T9"),
        "nothing tells the site"
    );
    window.closed.store(true, Ordering::Relaxed);
    window.frames(2);
    assert_eq!(bytes(&window), 0);
}
