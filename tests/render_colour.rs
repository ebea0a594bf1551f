//! The skin coloured by a quantity, judged by its pixels, on OpenGL 3.3 core and OpenGL ES 3.0.
#![cfg(feature = "gui")]
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot be set up has failed"
)]

#[path = "support/gl.rs"]
mod gl;

use dorsum::app::camera::{Camera, Preset, Projection};
use dorsum::app::colours::map::Map;
use dorsum::app::colours::{self, Source};
use dorsum::app::render::layer::Overlay;
use dorsum::app::render::mesh::SkinMesh;
use dorsum::app::render::sphere::Sphere;
use dorsum::app::render::tint::Tint;
use dorsum::app::render::values::Values;
use dorsum::app::render::{Painted, Palette, Picture, Renderer, SkinLook, shade};
use dorsum::deform::models::fsmd::{Fsmd, Settings};
use dorsum::deform::{Displacement, Model as _, Press};
use dorsum::geom::{Vec2, Vec3};
use dorsum::surface::{RawMesh, Surface};
use gl::{Api, Image, OffScreen};
use std::sync::Arc;

const SIZE: [u32; 2] = [320, 240];
const BLUE: [u8; 3] = [88, 158, 255];

/// A sheet of 200 × 160 mm, 2.5 mm spacing, of the given height.
fn sheet(z: impl Fn(f64) -> f64) -> Arc<Surface> {
    let (nx, ny) = (80_u32, 64_u32);
    let mut raw = RawMesh::default();
    for j in 0..=ny {
        for i in 0..=nx {
            let (x, y) = (f64::from(i) * 2.5 - 100.0, f64::from(j) * 2.5 - 80.0);
            raw.positions.push(Vec3::new(x, y, z(x)));
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

fn flat() -> Arc<Surface> {
    sheet(|_| 0.0)
}

fn tint(map: Map, low: f64, high: f64) -> Option<Tint> {
    Some(Tint {
        map,
        range: [low, high],
        contour_step: None,
    })
}

fn picture(surface: &Surface) -> Picture {
    let size = Vec2::new(f64::from(SIZE[0]), f64::from(SIZE[1]));
    let mut camera = Camera::default().preset(Preset::Back, &surface.bounds(), None, size);
    camera.projection = Projection::Orthographic;
    Picture {
        camera,
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

/// A value per vertex, by its place.
fn values(surface: &Surface, value: impl Fn(Vec3) -> f64) -> Values {
    let positions = surface.positions();
    Values::each(positions.len(), |v| value(positions[v as usize]))
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

    fn at(&self, image: &Image, picture: &Picture, x: f64, y: f64) -> [u8; 3] {
        let p = Vec3::new(x, y, 0.0);
        let pixel = picture.camera.project(p, picture.size()).unwrap();
        image.at(pixel.x, pixel.y)
    }
}

/// Runs on both kinds of context; a kind that this machine lacks is told and left out.
fn on_each(test: impl Fn(&mut Bench)) {
    for api in [Api::Core33, Api::Es30] {
        if let Some(screen) = OffScreen::or_skip(api, SIZE) {
            let renderer = Renderer::new(&screen.gl).unwrap();
            test(&mut Bench { screen, renderer });
        }
    }
}

fn apart(a: [u8; 3], b: [u8; 3]) -> u8 {
    (0..3).map(|k| a[k].abs_diff(b[k])).max().unwrap_or(0)
}

#[test]
fn flat_skin_that_faces_the_eye_has_the_colours_of_the_legend_dark_and_light() {
    on_each(|bench| {
        let surface = flat();
        let mut mesh = SkinMesh::new(surface.clone());
        let mut picture = picture(&surface);
        for dark in [true, false] {
            picture.palette.dark = dark;
            for map in Map::ALL {
                mesh.set_values(Some(values(&surface, |p| p.x)));
                picture.tint = tint(map, -100.0, 100.0);
                let (image, _) = bench.draw(&picture, &mut mesh);
                image.keep(&format!("legend_{map:?}.png"));
                for x in (-90..=90).step_by(15) {
                    let x = f64::from(x);
                    let seen = bench.at(&image, &picture, x, 0.0);
                    let said = map.at((x + 100.0) / 200.0);
                    assert!(
                        apart(seen, said) <= 4,
                        "{map:?} at {x}: {seen:?}, legend {said:?}"
                    );
                }
            }
        }
    });
}

#[test]
fn bare_skin_is_the_same_before_and_after_a_quantity_was_shown() {
    on_each(|bench| {
        let surface = sheet(|x| 6.0 * (x / 30.0).cos());
        let mut mesh = SkinMesh::new(surface.clone());
        mesh.set_shade(shade::bake(&surface, 1));
        let mut picture = picture(&surface);
        picture.spheres = vec![finger()];
        let (bare, _) = bench.draw(&picture, &mut mesh);
        // Values alone change nothing, nor does a tint without values.
        mesh.set_values(Some(values(&surface, |p| p.y)));
        assert!(bench.draw(&picture, &mut mesh).0 == bare);
        picture.tint = tint(Map::Sequential, -80.0, 80.0);
        let (coloured, _) = bench.draw(&picture, &mut mesh);
        assert!(coloured.differing(&bare, 20).len() > 20_000);
        mesh.set_values(None);
        assert!(mesh.values().is_none());
        picture.tint = None;
        assert!(bench.draw(&picture, &mut mesh).0 == bare);
    });
}

#[test]
fn strain_is_red_where_the_skin_is_stretched_and_blue_where_it_is_compressed() {
    on_each(|bench| {
        let surface = flat();
        let mut mesh = SkinMesh::new(surface.clone());
        let mut picture = picture(&surface);
        let start = Press {
            anchor_mm: Vec3::ZERO,
            foot_mm: Vec3::ZERO,
            normal: Vec3::Z,
            depth_mm: 0.5,
            triangle: (0..surface.triangles().len() as u32)
                .find(|&t| surface.triangle(t).closest_point(Vec3::ZERO).point == Vec3::ZERO)
                .unwrap(),
            ..Press::default()
        };
        let mut model = Fsmd::new(Settings {
            half_major_mm: 60.0,
            half_minor_mm: 60.0,
            ..Settings::default()
        });
        let mut displacement = Displacement::at_rest(&surface);
        let strain = colours::named("strain").unwrap().unwrap();
        let Source::Frame(make) = strain.source else {
            panic!("strain follows the frames")
        };
        let mut quantity = make(&surface, &displacement);
        mesh.set_values(Some(values(&surface, |_| 0.0)));
        picture.tint = tint(strain.map, -25.0, 25.0);
        bench.draw(&picture, &mut mesh);
        // Two steps to the right: what lies ahead is pushed together, what lies behind is drawn out.
        for pull_mm in [4.0, 15.0] {
            let press = Press {
                foot_mm: Vec3::X * pull_mm,
                ..start.clone()
            };
            model.update(&surface, &[press], &mut displacement);
            mesh.update(&displacement);
            quantity.follow(&surface, &displacement);
            let held = mesh.values_mut().unwrap();
            quantity.changed(&displacement, &mut |v| {
                held.set(v, quantity.value(&displacement, v));
            });
        }
        let (image, painted) = bench.draw(&picture, &mut mesh);
        image.keep("strain.png");
        let n = surface.positions().len();
        assert!((500..n).contains(&painted.uploaded_values), "{painted:?}");
        let held = mesh.values().unwrap();
        let at = |x: f64| {
            let near = |v: &u32| (surface.positions()[*v as usize] - Vec3::X * x).length_squared();
            let v = (0..n as u32).min_by(|a, b| near(a).total_cmp(&near(b)));
            held.at(v.unwrap()).unwrap()
        };
        assert!(at(32.0) < -5.0 && at(-32.0) > 5.0 && at(80.0) == 0.0);
        let [r, g, b] = bench.at(&image, &picture, 42.0, 0.0);
        assert!(b > r + 20 && b > g, "ahead {r} {g} {b}");
        let [r, g, b] = bench.at(&image, &picture, -28.0, 0.0);
        assert!(r > b + 20 && r > g, "behind {r} {g} {b}");
        let [r, g, b] = bench.at(&image, &picture, -90.0, 60.0);
        assert!(r.abs_diff(g) < 8 && g.abs_diff(b) < 8, "far {r} {g} {b}");
        // Every vertex has the strain that working all of it out anew gives.
        let anew = make(&surface, &displacement);
        for v in 0..n as u32 {
            let (kept, anew) = (held.at(v).unwrap(), anew.value(&displacement, v));
            assert!((kept - anew).abs() < 1e-5, "vertex {v}: {kept} and {anew}");
        }
    });
}

#[test]
fn changed_values_go_up_alone_and_give_the_picture_of_uploading_all() {
    on_each(|bench| {
        let surface = flat();
        let mut mesh = SkinMesh::new(surface.clone());
        let mut picture = picture(&surface);
        picture.tint = tint(Map::Sequential, 0.0, 10.0);
        mesh.set_values(Some(values(&surface, |_| 0.0)));
        bench.draw(&picture, &mut mesh);
        let hill = |p: Vec3| 10.0 * (-(p.x * p.x + p.y * p.y) / 800.0).exp();
        for v in 0..surface.positions().len() as u32 {
            let height = hill(surface.positions()[v as usize]);
            if height > 1.0 {
                mesh.values_mut().unwrap().set(v, height);
            }
        }
        let (stepwise, painted) = bench.draw(&picture, &mut mesh);
        assert!(painted.drawn && painted.uploaded_vertices == 0);
        assert!(
            (200..4000).contains(&painted.uploaded_values),
            "{painted:?}"
        );
        let whole = values(&surface, |p| {
            Some(hill(p)).filter(|h| *h > 1.0).unwrap_or(0.0)
        });
        mesh.set_values(Some(whole));
        let (anew, painted) = bench.draw(&picture, &mut mesh);
        assert_eq!(painted.uploaded_values, 0, "all went up at once");
        assert!(anew == stepwise);
    });
}

#[test]
fn one_value_everywhere_needs_no_buffer_and_no_number_is_drawn_as_any_other() {
    on_each(|bench| {
        let surface = flat();
        let mut mesh = SkinMesh::new(surface.clone());
        let mut picture = picture(&surface);
        picture.tint = tint(Map::Sequential, 0.0, 1.0);
        mesh.set_values(Some(Values::same(0.25)));
        assert_eq!(mesh.values().unwrap().bytes(), 0);
        let (image, _) = bench.draw(&picture, &mut mesh);
        let said = Map::Sequential.at(0.25);
        assert!(apart(bench.at(&image, &picture, 30.0, 20.0), said) <= 4);
        // A range that is none, too: everything is at its lower end.
        mesh.set_values(Some(values(&surface, |_| f64::NAN)));
        for range in [
            [0.0, 1.0],
            [2.0, 2.0],
            [f64::NAN, 1.0],
            [0.0, f64::INFINITY],
        ] {
            picture.tint = Some(Tint {
                map: Map::Sequential,
                range,
                contour_step: Some(f64::NAN),
            });
            let (image, _) = bench.draw(&picture, &mut mesh);
            let seen = bench.at(&image, &picture, 30.0, 20.0);
            let known = Map::Sequential.table().iter().any(|&c| apart(c, seen) <= 4);
            assert!(known, "{range:?}: {seen:?}");
        }
    });
}

#[test]
fn directions_meet_across_the_seam_without_passing_all_others() {
    on_each(|bench| {
        let surface = flat();
        let mut mesh = SkinMesh::new(surface.clone());
        let mut picture = picture(&surface);
        // 176° on the left of the middle, 4° on the right of it: in between lies 0°.
        mesh.set_values(Some(values(
            &surface,
            |p| if p.x < 1.0 { 176.0 } else { 4.0 },
        )));
        picture.tint = tint(Map::Cyclic, 0.0, 180.0);
        let (image, _) = bench.draw(&picture, &mut mesh);
        let allowed = [176.0, 178.0, 0.0, 2.0, 4.0].map(|a: f64| Map::Cyclic.at(a / 180.0));
        for tenth in -60..60 {
            let x = f64::from(tenth) / 10.0;
            let seen = bench.at(&image, &picture, x, 10.0);
            let near = allowed.iter().map(|&c| apart(c, seen)).min().unwrap();
            assert!(near <= 8, "at {x}: {seen:?}");
        }
    });
}

#[test]
fn level_lines_lie_at_their_levels_and_not_on_a_plateau() {
    on_each(|bench| {
        let surface = flat();
        let mut mesh = SkinMesh::new(surface.clone());
        let mut picture = picture(&surface);
        // Level 40 is a plateau to the right of x = 40.
        mesh.set_values(Some(values(&surface, |p| p.x.min(40.0))));
        picture.tint = tint(Map::Sequential, -100.0, 40.0);
        let (plain, _) = bench.draw(&picture, &mut mesh);
        if let Some(tint) = &mut picture.tint {
            tint.contour_step = Some(20.0);
        }
        let (lined, _) = bench.draw(&picture, &mut mesh);
        lined.keep("contours.png");
        let changed: Vec<f64> = lined
            .differing(&plain, 12)
            .iter()
            .map(|&[x, y]| {
                let pixel = Vec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                picture.camera.at_target_depth(pixel, picture.size()).x
            })
            .collect();
        assert!(changed.len() > 600, "{}", changed.len());
        for x in &changed {
            let away = (x / 20.0 - (x / 20.0).round()).abs() * 20.0;
            assert!(away < 2.5 && *x < 42.0, "a line at {x}");
        }
        for level in [-80.0, -60.0, -40.0, -20.0, 0.0, 20.0] {
            assert!(changed.iter().any(|x| (x - level).abs() < 2.5), "{level}");
        }
    });
}

fn finger() -> Sphere {
    Sphere {
        centre_mm: Vec3::new(-30.0, 0.0, 12.0),
        radius_mm: 12.0,
        color: BLUE,
    }
}

#[test]
fn fingers_keep_their_colour_and_get_a_rim_over_a_coloured_skin() {
    on_each(|bench| {
        let surface = flat();
        let mut mesh = SkinMesh::new(surface.clone());
        mesh.set_values(Some(values(&surface, |p| p.x)));
        let mut picture = picture(&surface);
        picture.spheres = vec![finger()];
        picture.tint = tint(Map::Diverging, -100.0, 100.0);
        let (image, _) = bench.draw(&picture, &mut mesh);
        image.keep("rim.png");
        let [r, _, b] = bench.at(&image, &picture, -30.0, 0.0);
        assert!(b > 150 && b > r.saturating_add(60), "the finger is blue");
        let rim = bench.at(&image, &picture, -30.0 + 11.6, 0.0);
        assert!(rim.iter().all(|&c| c > 200), "its rim is white: {rim:?}");
    });
}

#[test]
fn relief_reads_under_the_colour() {
    on_each(|bench| {
        let surface = sheet(|x| 6.0 * (x / 15.0).cos());
        let mut mesh = SkinMesh::new(surface.clone());
        let mut picture = picture(&surface);
        picture.tint = tint(Map::Sequential, 0.0, 1.0);
        for value in [0.1, 0.5, 0.9] {
            mesh.set_values(Some(Values::same(value)));
            let (image, painted) = bench.draw(&picture, &mut mesh);
            assert!(painted.drawn, "other values are another picture");
            image.keep(&format!("relief_{value}.png"));
            let lightness: Vec<i32> = (-60..60)
                .map(|x| {
                    let seen = bench.at(&image, &picture, f64::from(x), 0.0);
                    seen.iter().map(|&c| i32::from(c)).sum()
                })
                .collect();
            let (low, high) = (lightness.iter().min(), lightness.iter().max());
            let contrast = f64::from(*high.unwrap()) / f64::from(*low.unwrap());
            assert!(contrast > 1.25, "value {value}: {contrast}");
        }
    });
}
