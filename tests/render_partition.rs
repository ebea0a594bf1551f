//! The tree as it is really drawn, in the Partition panel and over the skin in the Back view, on a window without a screen.
#![cfg(feature = "gui")]
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot be set up has failed"
)]

mod support;

#[path = "support/gl.rs"]
mod gl;

use dorsum::app::command;
use dorsum::app::panels::back_view::BackView;
use dorsum::app::panels::partition::PartitionPanel;
use dorsum::app::panels::{Panel, PanelContext};
use dorsum::app::state::View;
use dorsum::app::study::settings::{Follow, Settings};
use dorsum::app::theme::Theme;
use egui_kittest::{Harness, TestRenderer, kittest::Queryable as _};
use gl::{Api, Image, OffScreen, Painter};
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

const SIZE: [u32; 2] = [900, 640];

/// Hands egui's textures to the painter on the off-screen window.
struct Textures(Rc<RefCell<Painter>>);

impl TestRenderer for Textures {
    fn handle_delta(&mut self, delta: &mut egui::TexturesDelta) {
        self.0.borrow_mut().textures(delta);
    }
}

/// What is drawn: one of the two panels, or none.
#[derive(Clone, Copy, PartialEq)]
enum Front {
    Tree,
    Back,
    None,
}

/// Both panels share a window, one in front.
struct Window {
    harness: Harness<'static>,
    painter: Rc<RefCell<Painter>>,
    screen: Rc<OffScreen>,
    view: Arc<Mutex<View>>,
    front: Arc<Mutex<Front>>,
}

impl Window {
    fn open(dark: bool) -> Option<Self> {
        let screen = Rc::new(OffScreen::or_skip(Api::Core33, SIZE)?);
        let painter = Rc::new(RefCell::new(Painter::new(&screen)));
        let mut view = support::running();
        view.theme = Theme::of(dark);
        view.fingers = vec![support::touching(0, 0, 5.0)];
        view.gl = Some(screen.gl.clone());
        let theme = view.theme;
        let view = Arc::new(Mutex::new(view));
        let front = Arc::new(Mutex::new(Front::Tree));
        let (mut tree, mut back) = (PartitionPanel::default(), BackView::default());
        let (seen, which) = (view.clone(), front.clone());
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
                match *which.lock().unwrap() {
                    Front::Tree => tree.ui(ui, &cx),
                    Front::Back => back.ui(ui, &cx),
                    Front::None => {
                        tree.release(&view);
                        back.release(&view);
                    }
                }
            });
        let mut window = Self {
            harness,
            painter,
            screen,
            view,
            front,
        };
        let start = Instant::now();
        while !window.has_tree() {
            assert!(start.elapsed() < Duration::from_secs(60), "no tree");
            window.harness.run_steps(1);
            std::thread::sleep(Duration::from_millis(2));
        }
        window.harness.run_steps(3);
        Some(window)
    }

    fn has_tree(&self) -> bool {
        let shown = self.view.lock().unwrap().study.lock().shown();
        shown.built.is_some() && shown.asked.is_some()
    }

    fn choose(&mut self, change: impl FnOnce(&mut Settings)) {
        let view = self.view.lock().unwrap().clone();
        let mut settings = view.study.lock().settings();
        change(&mut settings);
        view.study.lock().choose(settings);
        self.harness.run_steps(3);
    }

    fn bring(&mut self, front: Front) {
        *self.front.lock().unwrap() = front;
        self.harness.run_steps(3);
    }

    fn image(&mut self) -> Image {
        let shapes = self.harness.output().shapes.clone();
        self.painter
            .borrow_mut()
            .paint(&self.screen, &self.harness.ctx, shapes)
    }
}

/// Pixels in the picture, left of the controls, that are near a colour.
fn near(image: &Image, color: egui::Color32, by: u8) -> usize {
    let wide = (SIZE[0] - 340) as usize;
    (0..SIZE[1] as usize)
        .flat_map(|y| (0..wide).map(move |x| (x, y)))
        .filter(|&(x, y)| {
            let p = &image.data[(y * SIZE[0] as usize + x) * 4..][..3];
            let close = |a: u8, b: u8| a.abs_diff(b) <= by;
            close(p[0], color.r()) && close(p[1], color.g()) && close(p[2], color.b())
        })
        .count()
}

/// Pixels where green is far ahead of red and blue: skin under the mark of haptic triangles, or the box around them.
fn green(image: &Image) -> usize {
    let pixels = image.data.chunks(4);
    pixels
        .filter(|p| p[1] > p[0].saturating_add(30) && p[1] > p[2].saturating_add(30))
        .count()
}

#[test]
fn boxes_planes_and_haptic_triangles_are_drawn_and_each_can_be_switched_off() {
    for dark in [true, false] {
        let Some(mut window) = Window::open(dark) else {
            return;
        };
        let theme = Theme::of(dark);
        let all = window.image();
        all.keep(if dark {
            "partition_dark.png"
        } else {
            "partition_light.png"
        });
        let leaf = |image: &Image| near(image, theme.tree.leaf, 40);
        assert!(leaf(&all) > 300, "{} pixels of boxes", leaf(&all));
        assert!(green(&all) > 1500, "{} green pixels", green(&all));
        window.choose(|s| s.show.wire = false);
        assert!(leaf(&window.image()) < leaf(&all) / 2);
        window.choose(|s| {
            s.show.haptic = false;
            s.show.hdb = false;
            s.show.planes = false;
        });
        let bare = window.image();
        assert!(green(&bare) < green(&all) / 8, "{}", green(&bare));
        window.choose(|s| s.show.skin = false);
        assert!(
            window.image().differing(&bare, 20).len() > 20_000,
            "the skin is still there"
        );
    }
}

#[test]
fn the_back_view_shows_the_same_when_asked_and_nothing_otherwise() {
    let Some(mut window) = Window::open(true) else {
        return;
    };
    window.bring(Front::Back);
    let bare = window.image();
    window.choose(|s| s.show.in_back_view = true);
    let over = window.image();
    over.keep("partition_back_view.png");
    assert!(
        green(&over) > green(&bare) + 1500,
        "{} {}",
        green(&over),
        green(&bare)
    );
    window.harness.get_by_label("Haptic triangles");
    // Followed from here as well: the finger moves, and so does the mark.
    window.view.lock().unwrap().fingers[0].contact.anchor_mm.y += 120.0;
    window.harness.run_steps(3);
    let moved = window.image();
    assert!(moved.differing(&over, 30).len() > 2000);
    window.bring(Front::None);
    assert!(!window.has_tree());
    window.bring(Front::Back);
    let again = window.image();
    assert!(
        green(&again) < green(&over) / 8,
        "a closed panel lays nothing over the back"
    );
}

#[test]
fn a_click_puts_the_box_there_and_the_cursor_tells_the_leaf() {
    let Some(mut window) = Window::open(true) else {
        return;
    };
    let at = egui::pos2(280.0, 320.0);
    window.harness.event(egui::Event::PointerMoved(at));
    window.harness.run_steps(3);
    let shown = |w: &Window| w.view.lock().unwrap().study.lock().shown();
    let place = shown(&window).place.unwrap();
    assert!(place.cell.contains(place.point_mm));
    for pressed in [true, false] {
        window.harness.event(egui::Event::PointerButton {
            pos: at,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        });
        window.harness.run_steps(1);
    }
    window.harness.run_steps(3);
    let put = shown(&window);
    assert_eq!(put.settings.follow, Follow::Fixed);
    assert!(put.settings.fixed_mm.distance(place.point_mm) < 1e-9);
    assert!(put.asked.unwrap().probe_mm.distance(place.point_mm) < 1e-9);
    window
        .harness
        .event(egui::Event::PointerMoved(egui::pos2(5.0, 630.0)));
    window.harness.run_steps(3);
    assert!(shown(&window).place.is_none());
}

#[test]
fn an_idle_panel_draws_nothing_anew_and_keys_turn_the_picture() {
    let Some(mut window) = Window::open(true) else {
        return;
    };
    // The skin's shading is baked beside the window.
    let start = Instant::now();
    let mut first = window.image();
    loop {
        std::thread::sleep(Duration::from_millis(200));
        window.harness.run_steps(2);
        let next = window.image();
        if next.differing(&first, 0).is_empty() {
            break;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "never still");
        first = next;
    }
    let output = window.harness.output();
    let delay = output.viewport_output[&egui::ViewportId::ROOT].repaint_delay;
    assert!(
        delay > Duration::from_millis(100),
        "asks for a frame in {delay:?}"
    );
    window
        .harness
        .get_by_label_contains("Picture of the tree")
        .focus();
    window.harness.run_steps(2);
    window.harness.key_press(egui::Key::ArrowRight);
    window.harness.run_steps(3);
    assert!(window.image().differing(&first, 20).len() > 3000);
}
