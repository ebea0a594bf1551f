//! What lies below the skin, what lies upon it, and both eyes: judged by pixels, OpenGL objects, and the panel's own words.
#![cfg(feature = "gui")]
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot be set up has failed"
)]

mod support;

#[path = "support/gl.rs"]
mod gl;

use dorsum::app::camera::{Camera, Preset};
use dorsum::app::command;
use dorsum::app::panels::back_view::BackView;
use dorsum::app::panels::{Panel as _, PanelContext};
use dorsum::app::render::layer::Overlay;
use dorsum::app::render::mesh::SkinMesh;
use dorsum::app::render::model::Model;
use dorsum::app::render::{Painted, Palette, Picture, Renderer, SkinLook, bones};
use dorsum::app::state::View;
use dorsum::app::stereo::{Mode, Stereo};
use dorsum::app::theme::Theme;
use dorsum::device::mouse::{Hand, Mouse, MouseHandle};
use dorsum::geom::{Vec2, Vec3};
use dorsum::scenario::{Item, Ledger, Scenario};
use dorsum::surface::back::{self, BackOptions};
use dorsum::surface::{RawMesh, Surface};
use eframe::glow::{self, HasContext as _};
use egui_kittest::{Harness, TestRenderer, kittest::Queryable as _};
use gl::{Api, Image, OffScreen, Painter};
use std::cell::RefCell;
use std::num::NonZeroU32;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

const SIZE: [u32; 2] = [360, 300];

fn skin() -> Arc<Surface> {
    let raw = back::make(&BackOptions::default());
    Arc::new(Surface::new(raw).unwrap().0)
}

fn skeleton() -> Arc<Model> {
    Arc::new(bones::model(&BackOptions::default()))
}

fn picture(surface: &Surface, size: [u32; 2]) -> Picture {
    let size_px = Vec2::new(f64::from(size[0]), f64::from(size[1]));
    Picture {
        camera: Camera::default().preset(Preset::Back, &surface.bounds(), None, size_px),
        size_px: size,
        bounds: surface.bounds(),
        palette: Palette::of(&Theme::of(true)),
        skin: SkinLook::Opaque,
        stereo: None,
        draws_spheres: true,
        models: Vec::new(),
        tint: None,
        wireframe: false,
        draft: false,
        spheres: Vec::new(),
        arrows: Vec::new(),
        overlay: Overlay::default(),
    }
}

struct Bench {
    screen: OffScreen,
    renderer: Renderer,
}

impl Bench {
    fn draw(&mut self, picture: &Picture, mesh: &mut SkinMesh) -> (Image, Painted) {
        self.screen.begin();
        let painted = self.renderer.paint(&self.screen.gl, picture, mesh).unwrap();
        let image = self.screen.pixels();
        assert_eq!(self.screen.error(), 0, "OpenGL reports an error");
        (image, painted)
    }
}

fn on_each(size: [u32; 2], test: impl Fn(&mut Bench)) {
    for api in [Api::Core33, Api::Es30] {
        if let Some(screen) = OffScreen::or_skip(api, size) {
            let renderer = Renderer::new(&screen.gl).unwrap();
            test(&mut Bench { screen, renderer });
        }
    }
}

/// How many programs, buffers, textures and framebuffers there are.
fn n_objects(gl: &glow::Context) -> [usize; 4] {
    let ids = || (1..2048).filter_map(NonZeroU32::new);
    // SAFETY: asking whether a name is that of an object is allowed for every name.
    #[allow(unsafe_code)]
    unsafe {
        [
            ids()
                .filter(|&i| gl.is_program(glow::NativeProgram(i)))
                .count(),
            ids()
                .filter(|&i| gl.is_buffer(glow::NativeBuffer(i)))
                .count(),
            ids()
                .filter(|&i| gl.is_texture(glow::NativeTexture(i)))
                .count(),
            ids()
                .filter(|&i| gl.is_framebuffer(glow::NativeFramebuffer(i)))
                .count(),
        ]
    }
}

#[test]
fn bones_are_seen_through_translucent_skin_and_not_through_opaque_skin() {
    let (surface, skeleton) = (skin(), skeleton());
    on_each(SIZE, |bench| {
        let mut mesh = SkinMesh::new(surface.clone());
        let mut plain = picture(&surface, SIZE);
        let mut boned = plain.clone();
        boned.models = vec![bones::placed(&skeleton)];
        let (opaque, _) = bench.draw(&plain, &mut mesh);
        let hidden = bench.draw(&boned, &mut mesh).0.differing(&opaque, 0).len();
        assert_eq!(hidden, 0, "bones stick out of the skin seen from behind");
        for look in [SkinLook::Translucent, SkinLook::Off] {
            (plain.skin, boned.skin) = (look, look);
            let (without, _) = bench.draw(&plain, &mut mesh);
            let (with, _) = bench.draw(&boned, &mut mesh);
            with.keep(&format!("bones_{look:?}.png"));
            let seen = with.differing(&without, 8).len();
            assert!(seen > 8_000, "{look:?}: bones cover {seen} pixels");
        }
        // Through the skin, not instead of it: no pixel of skin over bone is as bright as bone alone.
        let at = Vec2::new(f64::from(SIZE[0]) / 2.0 + 42.0, 90.0);
        boned.skin = SkinLook::Translucent;
        let through = bench.draw(&boned, &mut mesh).0.at(at.x, at.y);
        boned.skin = SkinLook::Off;
        let alone = bench.draw(&boned, &mut mesh).0.at(at.x, at.y);
        assert_ne!(through, alone);
    });
}

/// Flat sheets of 100 × 80 mm at these heights.
fn sheets(heights_mm: &[f64]) -> Arc<Surface> {
    let (nx, ny) = (20_u32, 16_u32);
    let mut raw = RawMesh::default();
    for &z in heights_mm {
        let first = raw.positions.len() as u32;
        for j in 0..=ny {
            for i in 0..=nx {
                let (x, y) = (f64::from(i) * 5.0 - 50.0, f64::from(j) * 5.0 - 40.0);
                raw.positions.push(Vec3::new(x, y, z));
            }
        }
        let at = |i: u32, j: u32| first + j * (nx + 1) + i;
        for j in 0..ny {
            for i in 0..nx {
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                raw.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    Arc::new(Surface::new(raw).unwrap().0)
}

/// Blended triangles leave traces of their order unless depth decides which layer is seen: seen from one side or from the
/// other, the far one of two sheets would come first or last.
#[test]
fn of_translucent_skin_one_layer_is_seen_whatever_lies_behind_it() {
    let (both, near, far) = (sheets(&[0.0, -40.0]), sheets(&[0.0]), sheets(&[-40.0]));
    on_each(SIZE, |bench| {
        let mut picture = picture(&both, SIZE);
        picture.skin = SkinLook::Translucent;
        for (azimuth, alone) in [(0.3, &near), (std::f64::consts::PI - 0.3, &far)] {
            picture.camera.azimuth = azimuth;
            let (two, _) = bench.draw(&picture, &mut SkinMesh::new(both.clone()));
            let (one, _) = bench.draw(&picture, &mut SkinMesh::new(alone.clone()));
            two.keep(&format!("translucent_{azimuth:.1}.png"));
            let bare = Picture {
                skin: SkinLook::Off,
                ..picture.clone()
            };
            let (floor, _) = bench.draw(&bare, &mut SkinMesh::new(alone.clone()));
            let is_skin = |(x, y): (f64, f64)| {
                let (a, b) = (one.at(x, y), floor.at(x, y));
                a.iter().zip(b).any(|(a, b)| a.abs_diff(b) > 5)
            };
            let mut compared = 0;
            for y in 0..SIZE[1] {
                for x in 0..SIZE[0] {
                    let at = |image: &Image| image.at(f64::from(x), f64::from(y));
                    // Within the outline of the one: clear of it the other is seen alone.
                    let inside = [(-4, 0), (4, 0), (0, -4), (0, 4)].iter().all(|(dx, dy)| {
                        let beside = (f64::from(x) + f64::from(*dx), f64::from(y) + f64::from(*dy));
                        is_skin(beside)
                    });
                    if inside {
                        compared += 1;
                        assert_eq!(at(&two), at(&one), "{azimuth}: {x}, {y}");
                    }
                }
            }
            assert!(compared > 5_000, "{azimuth}: {compared} pixels");
        }
    });
}

#[test]
fn what_is_shown_no_more_is_gone_from_the_graphics_card() {
    let (surface, skeleton) = (skin(), skeleton());
    on_each(SIZE, |bench| {
        let mut mesh = SkinMesh::new(surface.clone());
        let plain = picture(&surface, SIZE);
        bench.draw(&plain, &mut mesh);
        let gl = bench.screen.gl.clone();
        let before = n_objects(&gl);
        let mut all = plain.clone();
        all.models = vec![bones::placed(&skeleton)];
        all.skin = SkinLook::Translucent;
        all.stereo = Some(Stereo {
            mode: Mode::Anaglyph,
            ..Stereo::default()
        });
        let (_, painted) = bench.draw(&all, &mut mesh);
        assert_eq!(painted.uploaded_models, 1);
        let during = n_objects(&gl);
        // Model, depth, translucent skin and anaglyph; vertices and triangles of the bones.
        let more = |k: usize| during[k] - before[k];
        assert_eq!([more(0), more(1)], [4, 2], "{before:?} {during:?}");
        let (_, painted) = bench.draw(&all, &mut mesh);
        assert!(
            !painted.drawn && painted.uploaded_models == 0,
            "nothing changed"
        );
        bench.draw(&plain, &mut mesh);
        assert_eq!(n_objects(&gl), before);
        assert_eq!(bench.draw(&all, &mut mesh).1.uploaded_models, 1);
    });
}

#[test]
fn each_eye_gets_the_picture_of_its_own_camera() {
    let (surface, skeleton) = (skin(), skeleton());
    let half = [SIZE[0] / 2, SIZE[1]];
    let single: Vec<Image> = {
        let Some(screen) = OffScreen::or_skip(Api::Core33, half) else {
            return;
        };
        let renderer = Renderer::new(&screen.gl).unwrap();
        let mut bench = Bench { screen, renderer };
        let mut mesh = SkinMesh::new(surface.clone());
        let mut picture = picture(&surface, half);
        picture.models = vec![bones::placed(&skeleton)];
        picture.skin = SkinLook::Translucent;
        let eyes = Stereo::default().eyes(&picture.camera);
        eyes.map(|camera| {
            let picture = Picture {
                camera,
                ..picture.clone()
            };
            bench.draw(&picture, &mut mesh).0
        })
        .into()
    };
    assert!(
        single[0].differing(&single[1], 8).len() > 2_000,
        "no parallax"
    );
    on_each(SIZE, |bench| {
        let mut mesh = SkinMesh::new(surface.clone());
        let mut wide = picture(&surface, half);
        wide.size_px = SIZE;
        wide.models = vec![bones::placed(&skeleton)];
        wide.skin = SkinLook::Translucent;
        for (mode, order) in [(Mode::Parallel, [0, 1]), (Mode::CrossEyed, [1, 0])] {
            wide.stereo = Some(Stereo {
                mode,
                ..Stereo::default()
            });
            let (image, _) = bench.draw(&wide, &mut mesh);
            image.keep(&format!("stereo_{}.png", mode.key()));
            for (place, eye) in order.into_iter().enumerate() {
                let from = place as u32 * half[0];
                let differing = (0..half[1])
                    .flat_map(|y| (0..half[0]).map(move |x| (x, y)))
                    .filter(|&(x, y)| {
                        let here = image.at(f64::from(from + x), f64::from(y));
                        let there = single[eye].at(f64::from(x), f64::from(y));
                        here.iter().zip(there).any(|(a, b)| a.abs_diff(b) > 3)
                    })
                    .count();
                assert!(differing < 60, "{mode:?}: {differing} pixels");
            }
        }
    });
}

#[test]
fn an_anaglyph_keeps_greys_and_parts_what_is_out_of_the_plane() {
    let surface = skin();
    on_each(SIZE, |bench| {
        let mut mesh = SkinMesh::new(surface.clone());
        let mut picture = picture(&surface, SIZE);
        let (plain, _) = bench.draw(&picture, &mut mesh);
        let with = |separation_mm: f64, bench: &mut Bench, mesh: &mut SkinMesh| {
            let mut picture = picture.clone();
            picture.stereo = Some(Stereo {
                mode: Mode::Anaglyph,
                separation_mm,
                ..Stereo::default()
            });
            bench.draw(&picture, mesh).0
        };
        let together = with(0.0, bench, &mut mesh);
        let apart = with(90.0, bench, &mut mesh);
        apart.keep("stereo_anaglyph.png");
        // The floor is grey, and the same to both eyes.
        for image in [&together, &apart] {
            let (a, b) = (plain.at(4.0, 4.0), image.at(4.0, 4.0));
            assert!(
                a.iter().zip(b).all(|(a, b)| a.abs_diff(b) < 8),
                "{a:?} {b:?}"
            );
        }
        assert!(apart.differing(&together, 12).len() > 500);
        picture.stereo = None;
        assert!(bench.draw(&picture, &mut mesh).0 == plain);
    });
}

struct Textures(Rc<RefCell<Painter>>);

impl TestRenderer for Textures {
    fn handle_delta(&mut self, delta: &mut egui::TexturesDelta) {
        self.0.borrow_mut().textures(delta);
    }
}

/// The panel in a window, with two mouse fingers.
struct Window {
    harness: Harness<'static>,
    painter: Rc<RefCell<Painter>>,
    screen: Rc<OffScreen>,
    view: Arc<Mutex<View>>,
    panel: Arc<Mutex<BackView>>,
    hands: Vec<MouseHandle>,
    closed: Arc<AtomicBool>,
}

const PANEL: [u32; 2] = [900, 640];

impl Window {
    fn open(dark: bool, kept: &str) -> Option<Self> {
        let screen = Rc::new(OffScreen::or_skip(Api::Core33, PANEL)?);
        let painter = Rc::new(RefCell::new(Painter::new(&screen)));
        let away = Vec3::new(0.0, 200.0, 400.0);
        let hands: Vec<_> = (0..2)
            .map(|_| Mouse::new(away, Hand::default()).1)
            .collect();
        let mut view = support::running();
        view.theme = Theme::of(dark);
        view.fingers.clear();
        view.hands.clone_from(&hands);
        view.gl = Some(screen.gl.clone());
        let theme = view.theme;
        let view = Arc::new(Mutex::new(view));
        let mut panel = BackView::default();
        panel.recall(kept);
        let panel = Arc::new(Mutex::new(panel));
        let closed = Arc::new(AtomicBool::new(false));
        let (seen, shown, is_closed) = (view.clone(), panel.clone(), closed.clone());
        let (send, _commands) = command::queue(Arc::new(|| {}));
        let harness = Harness::builder()
            .with_size([PANEL[0] as f32, PANEL[1] as f32])
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
                let mut panel = shown.lock().unwrap();
                if is_closed.load(Ordering::Relaxed) {
                    panel.release(&view);
                } else {
                    panel.ui(ui, &cx);
                }
            });
        let mut window = Self {
            harness,
            painter,
            screen,
            view,
            panel,
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
        let mut painter = self.painter.borrow_mut();
        painter.paint(&self.screen, &self.harness.ctx, shapes)
    }

    /// Draws until nothing changes any more: the shading is baked on a thread of its own.
    fn settle(&mut self) -> Image {
        let (mut last, mut still) = (self.image(), 0);
        for _ in 0..200 {
            std::thread::sleep(std::time::Duration::from_millis(30));
            self.frames(4);
            let now = self.image();
            still = if now == last { still + 1 } else { 0 };
            last = now;
            if still == 10 {
                break;
            }
        }
        last
    }

    fn click(&mut self, label: &str) {
        self.harness.get_by_label_contains(label).click();
        self.frames(3);
    }

    fn held(&self, item: Item) -> Option<usize> {
        let parts = self.view.lock().unwrap().parts.list();
        let found = parts.into_iter().find(|(i, _)| *i == item);
        found.map(|(_, cost)| cost.bytes)
    }

    fn pointer(&mut self, event: egui::Event) {
        self.harness.event(event);
        self.frames(2);
    }
}

const ITEMS: [Item; 4] = [
    Item::DrawnBones,
    Item::LandmarkNames,
    Item::HandModel,
    Item::SecondEye,
];

#[test]
fn bones_names_and_hands_are_there_while_they_are_shown_and_no_longer() {
    for dark in [true, false] {
        let Some(mut window) = Window::open(dark, "") else {
            return;
        };
        let (gl, bare) = (window.screen.gl.clone(), window.image());
        let objects = n_objects(&gl);
        assert!(ITEMS.iter().all(|i| window.held(*i).is_none()));
        window.view.lock().unwrap().fingers = vec![support::touching(1, 5, 6.0)];
        window.click("Anatomy:");
        for name in ["Bones", "Landmark names", "Hands"] {
            window.click(name);
        }
        window.harness.check_accessibility();
        window.image().keep(&format!("anatomy_menu_{dark}.png"));
        // Bones under opaque skin would not be seen: the skin gives way.
        assert!(
            window
                .harness
                .query_by_label("Anatomy: skin translucent")
                .is_some()
        );
        window.harness.key_press(egui::Key::Escape);
        window.frames(3);
        for (item, least) in [
            (Item::DrawnBones, 400_000),
            (Item::LandmarkNames, 2_000),
            (Item::HandModel, 10_000),
        ] {
            assert!(
                window.held(item).is_some_and(|bytes| bytes > least),
                "{item:?}"
            );
        }
        let shown = window.image();
        shown.keep(&format!("anatomy_{dark}.png"));
        assert!(shown.differing(&bare, 12).len() > 60_000);
        assert!(
            n_objects(&gl)[1] >= objects[1] + 4,
            "bones and a hand are uploaded"
        );
        // Off again: nothing of it is left.
        window.view.lock().unwrap().fingers.clear();
        window.click("Anatomy:");
        for name in ["Bones", "Landmark names", "Hands", "Skin opaque"] {
            window.click(name);
        }
        window.harness.key_press(egui::Key::Escape);
        window.frames(3);
        window.image();
        assert!(ITEMS.iter().all(|i| window.held(*i).is_none()));
        assert_eq!(n_objects(&gl)[..2], objects[..2]);
        // And after closing the panel with everything on.
        window
            .panel
            .lock()
            .unwrap()
            .recall("skin=translucent anatomy=bones,landmarks,hands stereo=anaglyph");
        window.frames(2);
        window.image();
        assert!(window.held(Item::DrawnBones).is_some() && window.held(Item::SecondEye).is_some());
        window.closed.store(true, Ordering::Relaxed);
        window.frames(2);
        assert!(ITEMS.iter().all(|i| window.held(*i).is_none()));
        assert!(n_objects(&gl)[0] < objects[0] && n_objects(&gl)[1] < objects[1]);
    }
}

#[test]
fn a_mesh_that_is_not_the_back_has_no_bones_and_the_menu_says_why() {
    let Some(mut window) = Window::open(true, "skin=translucent anatomy=bones,landmarks") else {
        return;
    };
    {
        let mut view = window.view.lock().unwrap();
        let mut scene = dorsum::scenario::Scene::clone(view.scene.as_ref().unwrap());
        let mut scenario = Scenario::clone(&scene.scenario);
        scenario.surface = dorsum::scenario::SurfaceChoice::Mesh {
            path: "scan.obj".into(),
            units: None,
        };
        scene.scenario = Arc::new(scenario);
        view.scene = Some(Arc::new(scene));
        view.scene_generation += 1;
    }
    window.frames(3);
    assert_eq!(window.held(Item::DrawnBones), None);
    window.click("Anatomy:");
    assert!(
        window
            .harness
            .query_by_label_contains("built-in back only")
            .is_some()
    );
}

#[test]
fn blind_neither_the_stiffness_nor_the_depth_under_a_finger_is_told() {
    let Some(mut window) = Window::open(true, "") else {
        return;
    };
    window.view.lock().unwrap().fingers = vec![support::touching(0, 5, 6.0)];
    window.frames(2);
    assert!(window.harness.query_by_label("0.50 N/mm").is_some());
    window.view.lock().unwrap().blind = true;
    window.frames(2);
    assert!(window.harness.query_by_label("0.50 N/mm").is_none());
    // The depth tells the stiffness too, to whoever knows the force.
    assert!(window.harness.query_by_label("6.0 mm").is_none());
    // Two scenes that differ in what the finger felt alone look the same.
    let one = window.settle();
    {
        let mut view = window.view.lock().unwrap();
        view.fingers[0].contact.stiffness_n_per_mm = 0.9;
    }
    window.frames(2);
    assert!(window.settle() == one);
}

#[test]
fn the_mouse_presses_in_either_picture_where_it_points() {
    for mode in ["parallel", "cross-eyed", "anaglyph"] {
        let kept = format!("stereo={mode}");
        let Some(mut window) = Window::open(true, &kept) else {
            return;
        };
        let scene = support::scene();
        let mut reached = Vec::new();
        let places: &[f32] = if mode == "anaglyph" {
            &[450.0]
        } else {
            &[225.0, 675.0]
        };
        for &x in places {
            let at = egui::pos2(x, 360.0);
            window.pointer(egui::Event::PointerMoved(at));
            for pressed in [true, false] {
                window.pointer(egui::Event::PointerButton {
                    pos: at,
                    button: egui::PointerButton::Primary,
                    pressed,
                    modifiers: egui::Modifiers::NONE,
                });
                if pressed {
                    let target = window.hands[0].target_mm();
                    let search = &scene.touch.search;
                    let near = dorsum::partition::Partition::nearest(
                        &**search,
                        &scene.surface,
                        target,
                        50.0,
                    );
                    let near = near.unwrap();
                    let outward = scene.surface.triangle(near.triangle).normal();
                    assert!(
                        (target - near.point).dot(outward) < -3.0,
                        "{mode}: not pressed"
                    );
                    reached.push(near.point);
                }
            }
        }
        // The middle of each picture shows what the camera looks at: the same place but for parallax.
        for p in &reached {
            assert!(p.distance(reached[0]) < 12.0, "{mode}: {reached:?}");
            assert!(p.x.abs() < 80.0);
        }
    }
}

#[test]
fn the_ledger_tells_why_anatomy_is_left_out() {
    let scene = support::scene();
    let mut purpose = support::running().purpose;
    purpose.drawn = true;
    let reason = |purpose, item| {
        Ledger::of(&scene.scenario, purpose)
            .row(item)
            .reason
            .clone()
    };
    assert_eq!(reason(purpose, Item::DrawnBones), "nothing shows bones");
    purpose.bones_drawn = true;
    purpose.two_eyes = true;
    assert_eq!(reason(purpose, Item::DrawnBones), "back view");
    assert_eq!(reason(purpose, Item::SecondEye), "back view");
    assert_eq!(reason(purpose, Item::HandModel), "fingertips are spheres");
}
