//! The Back view as a whole: its real paint callback in a window without a screen, pressed by a pointer.
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
use dorsum::app::panels::{Panel as _, PanelContext};
use dorsum::app::state::View;
use dorsum::app::theme::Theme;
use dorsum::device::mouse::{Hand, Mouse, MouseHandle};
use dorsum::geom::Vec3;
use egui_kittest::{Harness, TestRenderer, kittest::Queryable as _};
use gl::{Api, Image, OffScreen, Painter};
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

const SIZE: [u32; 2] = [800, 600];

/// Hands egui's textures to the painter on the off-screen window.
struct Textures(Rc<RefCell<Painter>>);

impl TestRenderer for Textures {
    fn handle_delta(&mut self, delta: &mut egui::TexturesDelta) {
        self.0.borrow_mut().textures(delta);
    }
}

/// The panel in a window, with two mouse fingers that nobody feels.
struct Window {
    harness: Harness<'static>,
    painter: Rc<RefCell<Painter>>,
    screen: Rc<OffScreen>,
    view: Arc<Mutex<View>>,
    hands: Vec<MouseHandle>,
    /// The panel is closed: released instead of drawn.
    closed: Arc<AtomicBool>,
}

impl Window {
    fn open(dark: bool) -> Option<Self> {
        let screen = Rc::new(OffScreen::or_skip(Api::Core33, SIZE)?);
        let painter = Rc::new(RefCell::new(Painter::new(&screen)));
        let away = Vec3::new(0.0, 200.0, 400.0);
        let hands: Vec<_> = (0..2)
            .map(|_| Mouse::new(away, Hand::default()).1)
            .collect();
        let mut view = support::running();
        view.theme = Theme::of(dark);
        view.fingers.clear();
        view.hands = hands.clone();
        view.gl = Some(screen.gl.clone());
        let theme = view.theme;
        let view = Arc::new(Mutex::new(view));
        let mut panel = BackView::default();
        let seen = view.clone();
        let closed = Arc::new(AtomicBool::new(false));
        let is_closed = closed.clone();
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
                if is_closed.load(Ordering::Relaxed) {
                    panel.release(&view);
                    return;
                }
                panel.ui(
                    ui,
                    &PanelContext {
                        view: &view,
                        send: &send,
                    },
                );
            });
        let mut window = Self {
            harness,
            painter,
            screen,
            view,
            hands,
            closed,
        };
        window.frames(3);
        Some(window)
    }

    fn frames(&mut self, n: usize) {
        self.harness.run_steps(n);
    }

    fn image(&mut self) -> Image {
        let shapes = self.harness.output().shapes.clone();
        self.painter
            .borrow_mut()
            .paint(&self.screen, &self.harness.ctx, shapes)
    }

    fn pointer(&mut self, event: egui::Event) {
        self.harness.event(event);
        self.frames(1);
    }

    fn move_to(&mut self, x: f32, y: f32) {
        self.pointer(egui::Event::PointerMoved(egui::pos2(x, y)));
        self.frames(1);
    }

    fn button(&mut self, button: egui::PointerButton, pressed: bool, at: [f32; 2]) {
        self.pointer(egui::Event::PointerButton {
            pos: at.into(),
            button,
            pressed,
            modifiers: egui::Modifiers::NONE,
        });
    }

    /// How far the place a hand is wanted at lies above the skin, mm; negative below.
    fn height_mm(&self, hand: usize) -> f64 {
        let target = self.hands[hand].target_mm();
        let scene = support::scene();
        let near = dorsum::partition::Partition::nearest(
            &*scene.touch.search,
            &scene.surface,
            target,
            1000.0,
        )
        .unwrap();
        let d = target - near.point;
        let outward = scene.surface.triangle(near.triangle).normal();
        d.length().copysign(d.dot(outward))
    }
}

fn is_skin([r, g, b]: [u8; 3]) -> bool {
    r > 90 && r > g && g > b
}

#[test]
fn the_back_fills_the_panel_dark_and_light() {
    for dark in [true, false] {
        let Some(mut window) = Window::open(dark) else {
            return;
        };
        let image = window.image();
        image.keep(if dark {
            "panel_dark.png"
        } else {
            "panel_light.png"
        });
        let skin = image
            .data
            .chunks(4)
            .filter(|p| is_skin([p[0], p[1], p[2]]))
            .count();
        let part = skin as f64 / f64::from(SIZE[0] * SIZE[1]);
        assert!((0.15..0.8).contains(&part), "skin covers {part}");
        window.harness.check_accessibility();
    }
}

#[test]
fn fingers_that_press_dent_the_skin_and_show_their_numbers() {
    let Some(mut window) = Window::open(true) else {
        return;
    };
    let bare = window.image();
    window.view.lock().unwrap().fingers = vec![support::touching(0, 5, 6.0)];
    window.frames(2);
    let image = window.image();
    image.keep("panel_press.png");
    assert!(image.differing(&bare, 8).len() > 400);
    let blue = |image: &Image| {
        image
            .data
            .chunks(4)
            .filter(|p| p[2] > 180 && p[2] > p[0].saturating_add(90))
            .count()
    };
    assert!(blue(&image) > blue(&bare) + 30, "no blue finger");
    for number in ["6.0 mm", "3.0 N", "0.50 N/mm"] {
        window.harness.get_by_label(number);
    }
}

#[test]
fn the_pointer_hovers_presses_slides_and_lets_go() {
    let Some(mut window) = Window::open(true) else {
        return;
    };
    let at = [400.0, 330.0];
    window.move_to(at[0], at[1]);
    assert!(
        (2.0..8.0).contains(&window.height_mm(0)),
        "hovers above the skin"
    );
    window.button(egui::PointerButton::Primary, true, at);
    assert!(window.height_mm(0) < -3.0, "presses in");
    let before = window.hands[0].target_mm();
    window.move_to(at[0] + 40.0, at[1]);
    let after = window.hands[0].target_mm();
    assert!(
        window.height_mm(0) < -3.0 && after.x > before.x + 5.0,
        "slides"
    );
    window.button(egui::PointerButton::Primary, false, [at[0] + 40.0, at[1]]);
    assert!(window.height_mm(0) > 2.0, "lets go");
}

#[test]
fn wheel_and_keys_set_the_depth_of_a_press() {
    let Some(mut window) = Window::open(true) else {
        return;
    };
    let at = [400.0, 330.0];
    window.move_to(at[0], at[1]);
    window.button(egui::PointerButton::Primary, true, at);
    let first = window.height_mm(0);
    for _ in 0..4 {
        window.harness.key_press(egui::Key::W);
        window.frames(1);
    }
    let deeper = window.height_mm(0);
    assert!(deeper < first - 1.0, "{first} then {deeper}");
    window.pointer(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: egui::vec2(0.0, -6.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Unknown,
        modifiers: egui::Modifiers::NONE,
    });
    window.frames(30);
    assert!(window.height_mm(0) > deeper + 0.5);
}

#[test]
fn the_second_finger_can_be_parked_and_lifted() {
    let Some(mut window) = Window::open(true) else {
        return;
    };
    let at = [400.0, 330.0];
    window.move_to(at[0], at[1]);
    window.button(egui::PointerButton::Primary, true, at);
    let place = window.hands[0].target_mm();
    window.harness.key_press(egui::Key::P);
    window.frames(1);
    assert!(window.hands[1].target_mm().distance(place) < 1e-9);
    assert!(window.height_mm(0) > 2.0, "the first finger is free again");
    window.button(egui::PointerButton::Primary, false, at);
    window.harness.key_press(egui::Key::P);
    window.frames(1);
    assert!(window.height_mm(1) > 10.0, "lifted");
}

#[test]
fn a_keyboard_alone_moves_and_presses_the_finger() {
    let Some(mut window) = Window::open(true) else {
        return;
    };
    window
        .harness
        .get_by_label_contains("Picture of the back")
        .focus();
    window.frames(3);
    window.harness.key_press(egui::Key::ArrowRight);
    window.frames(2);
    let first = window.hands[0].target_mm();
    window.harness.key_press(egui::Key::ArrowRight);
    window.frames(2);
    let second = window.hands[0].target_mm();
    assert!(second.x > first.x + 1.0, "{first} then {second}");
    window.harness.key_press(egui::Key::Enter);
    window.frames(2);
    assert!(window.height_mm(0) < -3.0, "presses");
    window.harness.key_press(egui::Key::Enter);
    window.frames(2);
    assert!(window.height_mm(0) > 0.0, "lets go");
}

#[test]
fn turning_and_presets_change_the_picture_and_leave_the_fingers_alone() {
    let Some(mut window) = Window::open(false) else {
        return;
    };
    let first = window.image();
    let target = window.hands[0].target_mm();
    let secondary = egui::PointerButton::Secondary;
    window.button(secondary, true, [300.0, 550.0]);
    window.move_to(380.0, 560.0);
    window.button(secondary, false, [380.0, 560.0]);
    window.frames(2);
    let turned = window.image();
    assert!(turned.differing(&first, 12).len() > 3000);
    assert!(window.hands[0].target_mm().distance(target) < 500.0);
    window.harness.get_by_label("Back").click();
    window.frames(60);
    let back = window.image();
    back.keep("panel_back.png");
    assert!(back.differing(&turned, 12).len() > 3000);
}

#[test]
fn a_recording_on_show_cannot_be_palpated() {
    let Some(mut window) = Window::open(true) else {
        return;
    };
    window.view.lock().unwrap().playback = Some(dorsum::app::state::PlaybackStatus {
        path: "a.mcap".into(),
        time_s: 0.0,
        duration_s: 1.0,
        playing: false,
        speed: 1.0,
        looped: false,
        ..dorsum::app::state::PlaybackStatus::default()
    });
    let before = window.hands[0].target_mm();
    window.move_to(400.0, 330.0);
    window.button(egui::PointerButton::Primary, true, [400.0, 330.0]);
    assert_eq!(window.hands[0].target_mm(), before);
}

/// The ledger says that a closed view leaves its mesh and deformation out: they must be gone, not merely unseen.
#[test]
fn a_closed_view_holds_nothing_and_draws_again_when_opened() {
    let Some(mut window) = Window::open(true) else {
        return;
    };
    let skin = |image: &Image| {
        let pixels = image.data.chunks(4);
        pixels.filter(|p| is_skin([p[0], p[1], p[2]])).count()
    };
    let open = skin(&window.image());
    let held = |window: &Window| window.view.lock().unwrap().parts.list().len();
    assert!(
        open > 10_000 && held(&window) == 3,
        "{open} {}",
        held(&window)
    );
    window.closed.store(true, Ordering::Relaxed);
    window.frames(2);
    assert_eq!((held(&window), skin(&window.image())), (0, 0));
    window.closed.store(false, Ordering::Relaxed);
    window.frames(3);
    let again = skin(&window.image());
    assert_eq!(held(&window), 3);
    assert!(again.abs_diff(open) < open / 20, "{again} against {open}");
}

#[test]
fn without_opengl_the_panel_says_so() {
    let mut view = support::running();
    view.gl = None;
    let (send, _commands) = command::queue(Arc::new(|| {}));
    let mut panel = BackView::default();
    let harness = Harness::builder()
        .with_context_setup(egui_material_icons::initialize)
        .build_ui(move |ui| {
            panel.ui(
                ui,
                &PanelContext {
                    view: &view,
                    send: &send,
                },
            );
        });
    harness.get_by_label_contains("cannot be drawn");
}
