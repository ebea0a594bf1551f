//! The Back view coloured by a quantity: chosen by pointer and keys, its legend, its range, its line of the ledger.
#![cfg(feature = "gui")]
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot be set up has failed"
)]

mod support;

#[path = "support/gl.rs"]
mod gl;

use dorsum::app::colours;
use dorsum::app::command;
use dorsum::app::panels::back_view::BackView;
use dorsum::app::panels::{Panel as _, PanelContext};
use dorsum::app::state::View;
use dorsum::app::theme::Theme;
use dorsum::contact::Stiffness;
use dorsum::partition::Partition as _;
use dorsum::scenario::{self, Item, Ledger, Scenario, Scene, Use};
use egui_kittest::{Harness, TestRenderer, kittest::NodeT as _, kittest::Queryable as _};
use gl::{Api, Image, OffScreen, Painter};
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::{Arc, Mutex};

const SIZE: [u32; 2] = [900, 640];

struct Textures(Rc<RefCell<Painter>>);

impl TestRenderer for Textures {
    fn handle_delta(&mut self, delta: &mut egui::TexturesDelta) {
        self.0.borrow_mut().textures(delta);
    }
}

struct Window {
    harness: Harness<'static>,
    painter: Rc<RefCell<Painter>>,
    screen: Rc<OffScreen>,
    view: Arc<Mutex<View>>,
    panel: Arc<Mutex<BackView>>,
}

impl Window {
    fn open(dark: bool, kept: &str) -> Option<Self> {
        let screen = Rc::new(OffScreen::or_skip(Api::Core33, SIZE)?);
        let painter = Rc::new(RefCell::new(Painter::new(&screen)));
        let mut view = support::running();
        view.theme = Theme::of(dark);
        view.fingers.clear();
        view.gl = Some(screen.gl.clone());
        let theme = view.theme;
        let view = Arc::new(Mutex::new(view));
        let mut panel = BackView::default();
        panel.recall(kept);
        let panel = Arc::new(Mutex::new(panel));
        let (seen, shown) = (view.clone(), panel.clone());
        let (send, _commands) = command::queue(Arc::new(|| {}));
        let harness = Harness::builder()
            .with_size([SIZE[0] as f32, SIZE[1] as f32])
            .with_context_setup(move |ctx| {
                egui_material_icons::initialize(ctx);
                theme.apply(ctx);
            })
            .renderer(Textures(painter.clone()))
            .build_ui(move |ui| {
                let view = seen.lock().unwrap().clone();
                let cx = PanelContext {
                    view: &view,
                    send: &send,
                };
                shown.lock().unwrap().ui(ui, &cx);
            });
        let mut window = Self {
            harness,
            painter,
            screen,
            view,
            panel,
        };
        window.frames(3);
        Some(window)
    }

    fn frames(&mut self, n: usize) {
        self.harness.run_steps(n);
    }

    fn image(&mut self) -> Image {
        let shapes = self.harness.output().shapes.clone();
        let mut painter = self.painter.borrow_mut();
        painter.paint(&self.screen, &self.harness.ctx, shapes)
    }

    /// Opens the menu and picks an entry.
    fn choose(&mut self, entry: &str) {
        self.harness
            .get_by_label_contains("Surface colour:")
            .click();
        self.frames(3);
        self.harness.get_by_label_contains(entry).click();
        self.frames(3);
    }

    fn press(&mut self, depth_mm: f64) {
        let scene = support::scene();
        let mut finger = support::touching(0, 5, depth_mm);
        let anchor = finger.contact.anchor_mm;
        let search = &scene.touch.search;
        finger.contact.triangle = search
            .nearest(&scene.surface, anchor, 1.0)
            .unwrap()
            .triangle;
        self.view.lock().unwrap().fingers = vec![finger];
        self.frames(2);
    }

    /// Draws until nothing changes any more: the shading is baked on a thread of its own, and glides end.
    fn settle(&mut self) -> Image {
        let mut last = self.image();
        let mut still = 0;
        for _ in 0..200 {
            std::thread::sleep(std::time::Duration::from_millis(30));
            self.frames(4);
            let now = self.image();
            still = if now == last { still + 1 } else { 0 };
            last = now;
            if still == 12 {
                break;
            }
        }
        last
    }

    fn shows(&self, label: &str) -> bool {
        self.harness.query_by_label_contains(label).is_some()
    }

    /// The number at an end of the range.
    fn end(&self, name: &str) -> f64 {
        let node = self.harness.get_by_label(name);
        node.accesskit_node().numeric_value().unwrap()
    }

    fn held(&self) -> Option<usize> {
        let parts = self.view.lock().unwrap().parts.list();
        let part = parts.into_iter().find(|(i, _)| *i == Item::SurfaceColour);
        part.map(|(_, cost)| cost.bytes)
    }
}

fn most_stiffness(scene: &Scene) -> [f64; 2] {
    let Stiffness::PerVertex(values) = &scene.touch.stiffness else {
        panic!("the healthy back has a map")
    };
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    [low, values.iter().copied().fold(0.0, f64::max)]
}

#[test]
fn every_quantity_is_chosen_from_the_menu_drawn_and_given_up_again() {
    for dark in [true, false] {
        let Some(mut window) = Window::open(dark, "") else {
            return;
        };
        // The hint how to press goes with the first press.
        window.press(6.0);
        window.view.lock().unwrap().fingers.clear();
        let bare = window.settle();
        assert_eq!(window.held(), None, "bare skin holds nothing");
        for quantity in colours::all() {
            window.choose(&format!("Colour by {}", quantity.name));
            window.press(6.0);
            let image = window.image();
            image.keep(&format!("colour_{}_{dark}.png", quantity.key));
            assert!(
                image.differing(&bare, 12).len() > 20_000,
                "{}",
                quantity.key
            );
            assert!(window.shows(&format!("Surface colour: {}", quantity.name)));
            assert!(window.held().is_some());
            window.harness.check_accessibility();
        }
        window.view.lock().unwrap().fingers.clear();
        window.choose("Colour by Skin");
        window.frames(2);
        assert_eq!(window.held(), None);
        // Below the toolbar, whose button was just pressed.
        let mut changed = window.settle().differing(&bare, 0);
        changed.retain(|[_, y]| *y > 110);
        assert!(changed.is_empty(), "{} pixels", changed.len());
    }
}

#[test]
fn the_legend_says_what_the_data_are() {
    let Some(mut window) = Window::open(true, "colour=stiffness") else {
        return;
    };
    let [low, high] = most_stiffness(&support::scene());
    assert!((window.end("Lower end of the range") - low).abs() < 1e-6);
    assert!((window.end("Upper end of the range") - high).abs() < 1e-6);
    assert!(window.shows("N/mm"));
    // A number for each vertex, and no more.
    let n = support::scene().surface.positions().len();
    assert_eq!(window.held(), Some(4 * n));
    window.choose("Colour by Half major axis");
    assert!(window.shows("the basic circle everywhere"));
    assert_eq!(window.held(), Some(0), "one value needs no memory");
    window
        .harness
        .get_by_label_contains("Surface colour:")
        .click();
    window.frames(3);
    assert!(window.shows("Colour by Direction: the basic circle everywhere"));
}

#[test]
fn a_scene_with_measured_fibres_shows_its_ellipses() {
    let Some(mut window) = Window::open(true, "colour=half-major") else {
        return;
    };
    let examples = scenario::examples();
    let example = examples.iter().find(|e| e.file == "fibres.toml").unwrap();
    let parsed = Scenario::parse(example.text, example.file, None).unwrap();
    let purpose = Use {
        drawn: true,
        deformed: true,
        ..Use::default()
    };
    let scene = scenario::build(Arc::new(parsed), purpose, &mut |_, _| true).unwrap();
    let field = scene.ellipse_field.clone().unwrap();
    let ovals: Vec<_> = (0..scene.surface.positions().len() as u32)
        .map(|v| field.vertex(v))
        .collect();
    {
        let mut view = window.view.lock().unwrap();
        view.scene = Some(Arc::new(scene));
        view.scene_generation += 1;
    }
    window.frames(3);
    let ends = |window: &Window| {
        ["Lower end of the range", "Upper end of the range"].map(|name| window.end(name))
    };
    let span = |of: &dyn Fn(&dorsum::maps::Oval) -> f64| {
        let values = ovals.iter().map(of);
        [
            values.clone().fold(f64::INFINITY, f64::min),
            values.fold(f64::NEG_INFINITY, f64::max),
        ]
    };
    let close = |a: [f64; 2], b: [f64; 2]| (0..2).all(|k| (a[k] - b[k]).abs() < 1e-4);
    let told = span(&|oval| oval.half_major_mm);
    assert!(told[0] < 140.0 && told[1] > 170.0, "{told:?}");
    assert!(close(ends(&window), told), "{:?}", ends(&window));
    assert!(!window.shows("the basic circle everywhere"));
    window.choose("Colour by Major over minor axis");
    assert!(close(ends(&window), span(&|oval| oval.major_over_minor())));
    window.choose("Colour by Direction");
    assert!(window.shows("degrees") && window.held() == Some(4 * ovals.len()));
}

/// Above 50,000 vertices a field is worked through beside the window, which goes on drawing.
#[test]
fn a_large_surface_gets_its_colours_a_little_later() {
    let Some(mut window) = Window::open(true, "colour=stiffness") else {
        return;
    };
    let first = window.end("Upper end of the range");
    let example = scenario::default_example();
    let text = example
        .text
        .replace("triangles = 20389", "triangles = 110000");
    let parsed = Scenario::parse(&text, "large", None).unwrap();
    let purpose = Use {
        drawn: true,
        ..Use::default()
    };
    let scene = scenario::build(Arc::new(parsed), purpose, &mut |_, _| true).unwrap();
    let n = scene.surface.positions().len();
    assert!(n > 50_000);
    let [low, high] = most_stiffness(&scene);
    {
        let mut view = window.view.lock().unwrap();
        view.scene = Some(Arc::new(scene));
        view.scene_generation += 1;
    }
    window.frames(1);
    for _ in 0..500 {
        if window.held() == Some(4 * n) {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
        window.frames(1);
    }
    assert_eq!(window.held(), Some(4 * n));
    window.frames(2);
    assert!(!window.shows("working…"));
    assert!((window.end("Lower end of the range") - low).abs() < 1e-6);
    assert!((window.end("Upper end of the range") - high).abs() < 1e-6);
    assert!((high - first).abs() < 0.2, "the same map on a finer skin");
}

#[test]
fn strain_has_a_symmetric_range_that_grows_is_held_and_begins_anew() {
    let Some(mut window) = Window::open(true, "colour=strain") else {
        return;
    };
    let ends = |window: &Window| {
        ["Lower end of the range", "Upper end of the range"].map(|name| window.end(name))
    };
    assert_eq!(ends(&window), [-1.0, 1.0]);
    window.press(8.0);
    let [low, deep] = ends(&window);
    assert!(deep > 1.0 && low == -deep, "{low} {deep}");
    // A lighter press leaves it; the button begins anew.
    window.press(2.0);
    assert_eq!(ends(&window), [low, deep]);
    window.harness.get_by_label("Reset range").click();
    window.frames(2);
    let [_, light] = ends(&window);
    assert!(light < deep, "{light} and {deep}");
    // Typed, it is held at both ends, and follows again.
    window
        .harness
        .get_by_label("Upper end of the range")
        .focus();
    window.frames(2);
    window
        .harness
        .get_by_label("Upper end of the range")
        .click();
    window.frames(2);
    window.harness.event(egui::Event::Key {
        key: egui::Key::A,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers: egui::Modifiers::COMMAND,
    });
    window.harness.event(egui::Event::Text("12.5".into()));
    window.harness.key_press(egui::Key::Enter);
    window.frames(3);
    assert_eq!(ends(&window), [-12.5, 12.5]);
    window.press(8.0);
    assert_eq!(ends(&window), [-12.5, 12.5]);
    window
        .harness
        .get_by_label("Range follows the values")
        .click();
    window.frames(2);
    assert_eq!(ends(&window), [-deep, deep]);
}

#[test]
fn a_quantity_chosen_during_a_press_shows_that_press() {
    let Some(mut window) = Window::open(true, "") else {
        return;
    };
    window.press(6.0);
    window.choose("Colour by Displacement");
    assert!(window.end("Upper end of the range") >= 6.0);
    assert_eq!(window.end("Lower end of the range"), 0.0);
}

#[test]
fn keys_go_through_the_list_and_the_choice_is_remembered() {
    let Some(mut window) = Window::open(true, "colour=nothing-known") else {
        return;
    };
    let picture = "Picture of the back";
    window.harness.get_by_label_contains(picture).focus();
    window.frames(2);
    let names = colours::all().iter().map(|q| q.name);
    for name in names.chain(["Skin"]) {
        window.harness.key_press(egui::Key::C);
        window.frames(2);
        assert!(window.shows(&format!("Surface colour: {name}")), "{name}");
    }
    window
        .harness
        .key_press_modifiers(egui::Modifiers::SHIFT, egui::Key::C);
    window.frames(2);
    assert!(window.shows("Surface colour: Direction"));
    window.choose("Colour by Stiffness");
    window.harness.get_by_label("Contours").click();
    window.frames(2);
    let kept = window.panel.lock().unwrap().keep().unwrap();
    let mut again = Window::open(true, &kept).unwrap();
    assert!(again.shows("Surface colour: Stiffness"));
    let lined = again.image();
    again.harness.get_by_label("Contours").click();
    again.frames(2);
    assert!(again.image().differing(&lined, 12).len() > 300);
}

#[test]
fn footprints_of_a_press_are_drawn_when_asked_for_and_only_then() {
    let Some(mut window) = Window::open(true, "") else {
        return;
    };
    window.press(6.0);
    let without = window.settle();
    window.harness.get_by_label("Footprints").click();
    window.frames(2);
    let blue = |[r, _, b]: [u8; 3]| b > 150 && b > r.saturating_add(80);
    let with = window.settle();
    with.keep("footprints.png");
    let drawn = with.differing(&without, 20).into_iter();
    let lines = drawn.filter(|&[x, y]| {
        let at = |image: &Image| image.at(f64::from(x), f64::from(y));
        y > 110 && blue(at(&with)) && !blue(at(&without))
    });
    assert!(lines.count() > 250);
    window.view.lock().unwrap().fingers.clear();
    window.frames(2);
    let lifted = window.settle();
    let places = (111..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
    let left = places.filter(|&(x, y)| blue(lifted.at(f64::from(x), f64::from(y))));
    assert!(left.count() < 20);
}

#[test]
fn the_legend_stands_beside_the_picture() {
    let Some(window) = Window::open(true, "colour=strain") else {
        return;
    };
    let picture = window.harness.get_by_label_contains("Picture of the back");
    for name in [
        "Upper end of the range",
        "Reset range",
        "Range follows the values",
    ] {
        let control = window.harness.get_by_label(name).rect();
        assert!(control.left() >= picture.rect().right(), "{name}");
        assert!(control.right() <= SIZE[0] as f32 && control.bottom() <= SIZE[1] as f32);
    }
}

#[test]
fn an_edit_of_the_scene_renews_the_colours_and_leaves_the_view_alone() {
    let Some(mut window) = Window::open(true, "colour=stiffness") else {
        return;
    };
    let high = window.end("Upper end of the range");
    window.harness.get_by_label("Left").click();
    let before = window.settle();
    {
        let mut view = window.view.lock().unwrap();
        let mut edited = Scene::clone(view.scene.as_ref().unwrap());
        let Stiffness::PerVertex(values) = &edited.touch.stiffness else {
            panic!("the healthy back has a map")
        };
        let doubled: Vec<f64> = values.iter().map(|k| 2.0 * k).collect();
        edited.touch.stiffness = Stiffness::PerVertex(doubled.into());
        view.scene = Some(Arc::new(edited));
        view.edit += 1;
    }
    window.frames(3);
    let doubled = window.end("Upper end of the range");
    assert!((doubled - 2.0 * high).abs() < 1e-5, "{doubled} and {high}");
    // All values doubled over a doubled range: the same picture, from the same side. The numbers beside it are others.
    let (width, changed) = (SIZE[0] - 110, window.settle().differing(&before, 3));
    let in_picture = changed.iter().filter(|[x, _]| *x < width).count();
    assert!(in_picture < 200, "{in_picture} pixels changed");
}

#[test]
fn the_ledger_tells_why_it_is_left_out() {
    let scene = support::scene();
    let mut purpose = support::running().purpose;
    purpose.drawn = true;
    let row = |purpose| {
        Ledger::of(&scene.scenario, purpose)
            .row(Item::SurfaceColour)
            .clone()
    };
    assert_eq!(row(purpose).reason, "bare skin is shown");
    purpose.coloured = true;
    assert_eq!(row(purpose).reason, "back view");
}
