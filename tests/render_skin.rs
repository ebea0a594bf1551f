//! The skin as the graphics card draws it, judged by its pixels, on OpenGL 3.3 core and OpenGL ES 3.0.
#![cfg(feature = "gui")]
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot be set up has failed"
)]

#[path = "support/gl.rs"]
mod gl;

use dorsum::app::camera::{Camera, Preset, Projection};
use dorsum::app::render::arrow::Arrow;
use dorsum::app::render::layer::Overlay;
use dorsum::app::render::mesh::SkinMesh;
use dorsum::app::render::sphere::Sphere;
use dorsum::app::render::{Painted, Palette, Picture, Renderer, SkinLook, shade};
use dorsum::deform::models::fsmd::{Fsmd, Settings};
use dorsum::deform::{Displacement, Model as _, Press};
use dorsum::geom::{Vec2, Vec3};
use dorsum::surface::{RawMesh, Surface};
use gl::{Api, Image, OffScreen};
use std::sync::Arc;

const SIZE: [u32; 2] = [320, 240];
const BLUE: [u8; 3] = [88, 158, 255];
const RED: [u8; 3] = [255, 98, 88];

/// A gently rolling sheet of 200 × 160 mm, 2.5 mm spacing.
fn sheet() -> Arc<Surface> {
    let (nx, ny) = (80_u32, 64_u32);
    let mut raw = RawMesh::default();
    for j in 0..=ny {
        for i in 0..=nx {
            let (x, y) = (f64::from(i) * 2.5 - 100.0, f64::from(j) * 2.5 - 80.0);
            raw.positions
                .push(Vec3::new(x, y, 6.0 * (x / 30.0).cos() - x * x / 400.0));
        }
    }
    let at = |i: u32, j: u32| j * (nx + 1) + i;
    for j in 0..ny {
        for i in 0..nx {
            raw.triangles
                .push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            raw.triangles
                .push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    Arc::new(Surface::new(raw).unwrap().0)
}

fn picture(surface: &Surface) -> Picture {
    let size = Vec2::new(f64::from(SIZE[0]), f64::from(SIZE[1]));
    Picture {
        camera: Camera::default().preset(Preset::Back, &surface.bounds(), None, size),
        size_px: SIZE,
        bounds: surface.bounds(),
        palette: Palette {
            dark: true,
            floor_top: [58, 63, 70],
            floor_bottom: [30, 33, 37],
            wire: [22, 24, 27],
        },
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

/// A press of `depth_mm` at the vertex nearest to (x, y).
fn dent(surface: &Surface, x: f64, y: f64, depth_mm: f64) -> (Press, Displacement) {
    let d = |p: &Vec3| (p.x - x).hypot(p.y - y);
    let v = (0..surface.positions().len())
        .min_by(|&a, &b| d(&surface.positions()[a]).total_cmp(&d(&surface.positions()[b])))
        .unwrap();
    let press = Press {
        anchor_mm: surface.positions()[v],
        foot_mm: surface.positions()[v],
        normal: surface.normals()[v],
        depth_mm,
        triangle: surface.topology().triangles_of(v as u32)[0],
        ..Press::default()
    };
    let mut out = Displacement::at_rest(surface);
    Fsmd::new(Settings::default()).update(surface, std::slice::from_ref(&press), &mut out);
    (press, out)
}

struct Bench {
    screen: OffScreen,
    renderer: Renderer,
}

impl Bench {
    fn new(api: Api) -> Option<Self> {
        let screen = OffScreen::or_skip(api, SIZE)?;
        let renderer = Renderer::new(&screen.gl).unwrap();
        Some(Self { screen, renderer })
    }

    fn draw(&mut self, picture: &Picture, mesh: &mut SkinMesh) -> (Image, Painted) {
        self.screen.begin();
        let painted = self.renderer.paint(&self.screen.gl, picture, mesh).unwrap();
        let image = self.screen.pixels();
        assert_eq!(self.screen.error(), 0, "OpenGL reports an error");
        (image, painted)
    }

    fn at(&self, image: &Image, picture: &Picture, p: Vec3) -> [u8; 3] {
        let pixel = picture.camera.project(p, picture.size()).unwrap();
        image.at(pixel.x, pixel.y)
    }
}

/// Runs on both kinds of context; a kind that this machine lacks is told and left out.
fn on_each(test: impl Fn(&mut Bench)) {
    for api in [Api::Core33, Api::Es30] {
        if let Some(mut bench) = Bench::new(api) {
            test(&mut bench);
        }
    }
}

fn is_skin([r, g, b]: [u8; 3]) -> bool {
    r > 90 && r > g && g > b
}

#[test]
fn skin_is_visible_in_front_of_a_floor_of_the_stated_colours() {
    on_each(|bench| {
        let surface = sheet();
        let mut mesh = SkinMesh::new(surface.clone());
        let picture = picture(&surface);
        let (image, painted) = bench.draw(&picture, &mut mesh);
        image.keep("skin.png");
        assert!(painted.drawn && painted.samples >= 1);
        for x in [-60.0, 0.0, 60.0] {
            assert!(is_skin(bench.at(&image, &picture, Vec3::new(x, 0.0, 0.0))));
        }
        let top = image.at(3.0, 3.0);
        let bottom = image.at(3.0, 236.0);
        assert!(
            !is_skin(top)
                && top
                    .iter()
                    .zip([58, 63, 70])
                    .all(|(a, b)| a.abs_diff(b) < 14)
        );
        assert!(
            bottom
                .iter()
                .zip([30, 33, 37])
                .all(|(a, b)| a.abs_diff(b) < 14)
        );
    });
}

#[test]
fn a_dent_of_two_millimetres_shows_under_the_finger_and_nowhere_else() {
    on_each(|bench| {
        let surface = sheet();
        let mut mesh = SkinMesh::new(surface.clone());
        let picture = picture(&surface);
        let (rest, _) = bench.draw(&picture, &mut mesh);
        let (press, displacement) = dent(&surface, 30.0, 10.0, 2.0);
        mesh.update(&displacement);
        let (dented, painted) = bench.draw(&picture, &mut mesh);
        assert!(painted.uploaded_vertices >= displacement.n_touched());
        assert!(painted.uploaded_vertices < surface.positions().len());
        let middle = picture
            .camera
            .project(press.anchor_mm, picture.size())
            .unwrap();
        let changed = dented.differing(&rest, 8);
        assert!(changed.len() > 150, "only {} pixels show it", changed.len());
        let reach_px = 60.0 * picture.target_px_per_mm();
        for [x, y] in dented.differing(&rest, 0) {
            let away = Vec2::new(f64::from(x), f64::from(y)).distance(middle);
            assert!(away < reach_px, "a pixel changed {away} px away");
        }
    });
}

#[test]
fn fingers_are_blue_and_red_where_they_stand_and_cast_a_soft_shadow() {
    on_each(|bench| {
        let surface = sheet();
        let mut mesh = SkinMesh::new(surface.clone());
        let mut picture = picture(&surface);
        let (bare, _) = bench.draw(&picture, &mut mesh);
        let spheres = [(-40.0, BLUE), (40.0, RED)].map(|(x, color)| Sphere {
            centre_mm: Vec3::new(x, 0.0, 15.0),
            radius_mm: 7.5,
            color,
        });
        picture.spheres = spheres.to_vec();
        picture.arrows = vec![Arrow {
            from_mm: Vec3::new(40.0, 7.5, 15.0),
            along_mm: Vec3::Y * 40.0,
            color: RED,
        }];
        let (image, _) = bench.draw(&picture, &mut mesh);
        image.keep("fingers.png");
        let [r, g, b] = bench.at(&image, &picture, spheres[0].centre_mm);
        assert!(b > 150 && b > r.saturating_add(60), "L is {:?}", [r, g, b]);
        let [r, g, b] = bench.at(&image, &picture, spheres[1].centre_mm);
        assert!(r > 150 && r > b.saturating_add(60), "R is {:?}", [r, g, b]);
        let [r, _, b] = bench.at(&image, &picture, Vec3::new(40.0, 38.0, 15.0));
        assert!(r > b.saturating_add(80), "no arrow");
        // Right beside the sphere, away from the key light, which comes from the upper left.
        let beside = Vec3::new(-32.0, -8.0, 0.0);
        let lit = |image| -> i32 {
            bench
                .at(image, &picture, beside)
                .iter()
                .map(|&c| i32::from(c))
                .sum()
        };
        assert!(lit(&image) < lit(&bare) - 20, "no shadow");
    });
}

#[test]
fn uploading_what_changed_gives_the_picture_of_uploading_all() {
    on_each(|bench| {
        let surface = sheet();
        let mut mesh = SkinMesh::new(surface.clone());
        mesh.set_shade(shade::bake(&surface, 1));
        let picture = picture(&surface);
        bench.draw(&picture, &mut mesh);
        // Several steps, the last one a retreat: vertices go out, move and come back.
        let mut model = Fsmd::new(Settings::default());
        let mut displacement = Displacement::at_rest(&surface);
        let mut stepwise = None;
        for (x, depth) in [(-30.0, 3.0), (0.0, 9.0), (35.0, 6.0), (35.0, 1.5)] {
            let (press, _) = dent(&surface, x, 5.0, depth);
            model.update(&surface, &[press], &mut displacement);
            mesh.update(&displacement);
            stepwise = Some(bench.draw(&picture, &mut mesh).0);
        }
        let mut fresh = Bench {
            renderer: Renderer::new(&bench.screen.gl).unwrap(),
            screen: OffScreen::or_skip(Api::Core33, SIZE).unwrap(),
        };
        bench.screen.make_current();
        std::mem::swap(&mut fresh.renderer, &mut bench.renderer);
        let (whole, painted) = bench.draw(&picture, &mut mesh);
        assert_eq!(painted.uploaded_vertices, 0, "all went up at once");
        assert!(stepwise.unwrap() == whole, "the two pictures differ");
    });
}

#[test]
fn an_unchanged_picture_is_shown_without_drawing_it_anew() {
    on_each(|bench| {
        let surface = sheet();
        let mut mesh = SkinMesh::new(surface.clone());
        let mut picture = picture(&surface);
        let (first, _) = bench.draw(&picture, &mut mesh);
        let (second, painted) = bench.draw(&picture, &mut mesh);
        assert!(!painted.drawn && first == second);
        mesh.set_shade(shade::bake(&surface, 1));
        assert!(bench.draw(&picture, &mut mesh).1.drawn);
        assert!(picture.camera.orbit(Vec2::new(40.0, 10.0), picture.size()));
        assert!(bench.draw(&picture, &mut mesh).1.drawn);
    });
}

#[test]
fn the_wireframe_comes_and_goes() {
    on_each(|bench| {
        let surface = sheet();
        let mut mesh = SkinMesh::new(surface.clone());
        let mut picture = picture(&surface);
        let (plain, _) = bench.draw(&picture, &mut mesh);
        picture.wireframe = true;
        let (wired, _) = bench.draw(&picture, &mut mesh);
        wired.keep("wire.png");
        assert!(wired.differing(&plain, 3).len() > 5000);
        picture.wireframe = false;
        assert!(bench.draw(&picture, &mut mesh).0 == plain);
    });
}

#[test]
fn hollows_are_darker_once_baked() {
    on_each(|bench| {
        let surface = sheet();
        let mut mesh = SkinMesh::new(surface.clone());
        let picture = picture(&surface);
        let (plain, _) = bench.draw(&picture, &mut mesh);
        mesh.set_shade(shade::bake(&surface, 2));
        let (baked, _) = bench.draw(&picture, &mut mesh);
        let sum = |image: &Image, x: f64| -> i32 {
            (-30..30)
                .flat_map(|y| {
                    let z = 6.0 * (x / 30.0).cos() - x * x / 400.0;
                    bench.at(image, &picture, Vec3::new(x, f64::from(y), z))
                })
                .map(i32::from)
                .sum()
        };
        let furrow = sum(&baked, 80.0) - sum(&plain, 80.0);
        let ridge = sum(&baked, 0.0) - sum(&plain, 0.0);
        assert!(furrow < ridge - 360, "furrow {furrow}, ridge {ridge}");
    });
}

#[test]
fn a_draft_shows_the_same_but_for_its_edges_and_gives_way_to_the_fine_picture() {
    on_each(|bench| {
        let surface = sheet();
        let mut mesh = SkinMesh::new(surface.clone());
        let mut picture = picture(&surface);
        let (fine, _) = bench.draw(&picture, &mut mesh);
        picture.draft = true;
        let (draft, painted) = bench.draw(&picture, &mut mesh);
        assert_eq!(painted.samples, 1);
        let differing = draft.differing(&fine, 6).len();
        let pixels = (SIZE[0] * SIZE[1]) as usize;
        assert!(differing < pixels / 40, "{differing} pixels differ");
        picture.draft = false;
        let (again, painted) = bench.draw(&picture, &mut mesh);
        assert!(painted.drawn && again == fine);
    });
}

#[test]
fn another_skin_takes_the_place_of_the_first() {
    on_each(|bench| {
        let surface = sheet();
        let picture = picture(&surface);
        let mut mesh = SkinMesh::new(surface.clone());
        let (first, _) = bench.draw(&picture, &mut mesh);
        let mut raw = RawMesh {
            positions: surface.positions().to_vec(),
            triangles: surface.triangles().to_vec(),
        };
        for p in &mut raw.positions {
            p.x *= 0.5;
        }
        let narrow = Arc::new(Surface::new(raw).unwrap().0);
        let mut narrow = SkinMesh::new(narrow);
        let (second, _) = bench.draw(&picture, &mut narrow);
        let beside = Vec3::new(80.0, 0.0, 0.0);
        assert!(is_skin(bench.at(&first, &picture, beside)));
        assert!(!is_skin(bench.at(&second, &picture, beside)));
    });
}

#[test]
fn orthographic_and_perspective_agree_at_the_depth_of_the_target() {
    on_each(|bench| {
        let surface = sheet();
        let mut mesh = SkinMesh::new(surface.clone());
        let mut picture = picture(&surface);
        picture.spheres = vec![Sphere {
            centre_mm: picture.camera.target_mm,
            radius_mm: 30.0,
            color: BLUE,
        }];
        let blue = |image: &Image| {
            image
                .data
                .chunks(4)
                .filter(|p| p[2] > p[0].saturating_add(40))
                .count() as f64
        };
        let perspective = blue(&bench.draw(&picture, &mut mesh).0);
        picture.camera.projection = Projection::Orthographic;
        let orthographic = blue(&bench.draw(&picture, &mut mesh).0);
        assert!(orthographic > 500.0);
        assert!((perspective / orthographic - 1.0).abs() < 0.15);
    });
}

#[test]
fn the_windows_own_state_is_left_as_it_was() {
    use eframe::glow::HasContext as _;
    on_each(|bench| {
        let surface = sheet();
        let mut mesh = SkinMesh::new(surface.clone());
        let picture = picture(&surface);
        bench.screen.begin();
        let gl = bench.screen.gl.clone();
        let state = || {
            let mut viewport = [0; 4];
            let mut scissor = [0; 4];
            // SAFETY: the context is current and both arrays hold the four numbers GL writes.
            #[allow(unsafe_code)]
            unsafe {
                gl.get_parameter_i32_slice(eframe::glow::VIEWPORT, &mut viewport);
                gl.get_parameter_i32_slice(eframe::glow::SCISSOR_BOX, &mut scissor);
                (
                    viewport,
                    scissor,
                    gl.get_parameter_framebuffer(eframe::glow::DRAW_FRAMEBUFFER_BINDING),
                    gl.is_enabled(eframe::glow::SCISSOR_TEST),
                    gl.is_enabled(eframe::glow::DEPTH_TEST),
                )
            }
        };
        let before = state();
        bench.renderer.paint(&gl, &picture, &mut mesh).unwrap();
        assert_eq!(state(), before);
    });
}
