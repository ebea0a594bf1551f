//! The software picture against the pinhole camera, brute force and awkward input.

use dorsum::figure::{Ball, Camera, Image, LEFT, Picture, RIGHT, picture::MAX_SIDE_PX};
use dorsum::geom::{Aabb, Vec3};
use proptest::prelude::*;

const GREEN: [u8; 3] = [20, 200, 40];
const BLUE: [u8; 3] = [20, 40, 220];

/// Looks along −z at the origin from 400 mm, 40° high.
fn camera() -> Camera {
    Camera {
        eye_mm: Vec3::new(0.0, 0.0, 400.0),
        target_mm: Vec3::ZERO,
        up: Vec3::Y,
        fov_y_rad: 40_f64.to_radians(),
    }
}

#[derive(Default)]
struct Soup {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    colours: Vec<[u8; 3]>,
    balls: Vec<Ball>,
}

impl Soup {
    fn triangle(mut self, corners: [Vec3; 3], colour: [u8; 3]) -> Self {
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.normals.extend([Vec3::Z; 3]);
        self.colours.extend([colour; 3]);
        self.triangles.push([first, first + 1, first + 2]);
        self
    }

    /// A square across the line of sight, facing the eye.
    fn square(self, middle: Vec3, half: f64, colour: [u8; 3]) -> Self {
        let at = |x: f64, y: f64| middle + Vec3::new(x * half, y * half, 0.0);
        self.triangle([at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0)], colour)
            .triangle([at(-1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)], colour)
    }

    fn ball(mut self, centre_mm: Vec3, radius_mm: f64, colour: [u8; 3]) -> Self {
        self.balls.push(Ball {
            centre_mm,
            radius_mm,
            colour,
        });
        self
    }

    fn picture(&self, camera: Camera, width: usize, height: usize) -> Image {
        Picture {
            positions: &self.positions,
            normals: &self.normals,
            triangles: &self.triangles,
            colours: Some(&self.colours),
            balls: &self.balls,
            camera,
            width,
            height,
        }
        .render()
    }
}

fn is_mostly(colour: [u8; 3], channel: usize) -> bool {
    (0..3).all(|c| c == channel || u16::from(colour[channel]) > 2 * u16::from(colour[c]))
}

/// Mean place of the pixels in which one channel outshines the others.
fn middle_of(image: &Image, channel: usize) -> Option<[f64; 2]> {
    let mut sum = [0.0; 3];
    for y in 0..image.height {
        for x in 0..image.width {
            if is_mostly(image.pixel(x, y).expect("inside"), channel) {
                sum = [
                    sum[0] + x as f64 + 0.5,
                    sum[1] + y as f64 + 0.5,
                    sum[2] + 1.0,
                ];
            }
        }
    }
    (sum[2] > 0.0).then(|| [sum[0] / sum[2], sum[1] / sum[2]])
}

/// Where a pinhole camera as in [`camera`] sees a point.
fn pinhole(p: Vec3, width: f64, height: f64) -> [f64; 2] {
    let focal = height / 2.0 / 20_f64.to_radians().tan();
    let depth = 400.0 - p.z;
    [
        width / 2.0 + focal * p.x / depth,
        height / 2.0 - focal * p.y / depth,
    ]
}

#[test]
fn a_point_lies_where_a_pinhole_camera_sees_it() {
    for p in [
        Vec3::new(0.0, 0.0, 0.0),
        Vec3::new(60.0, 20.0, 50.0),
        Vec3::new(-70.0, 90.0, -80.0),
        Vec3::new(30.0, -55.0, 120.0),
    ] {
        let [x, y] = pinhole(p, 200.0, 160.0);
        let said = camera().place_in_picture(p, 200, 160).expect("in front");
        assert!((said.x - x).abs() < 1.0e-9 && (said.y - y).abs() < 1.0e-9);
        let square = Soup::default().square(p, 6.0, GREEN);
        let ball = Soup::default().ball(p, 6.0, GREEN);
        for soup in [square, ball] {
            let image = soup.picture(camera(), 200, 160);
            let seen = middle_of(&image, 1).expect("seen");
            assert!(
                (seen[0] - x).abs() < 1.0 && (seen[1] - y).abs() < 1.0,
                "{p} at {seen:?}, not {x}, {y}"
            );
        }
    }
    let behind = camera().place_in_picture(Vec3::new(0.0, 0.0, 500.0), 200, 160);
    assert_eq!(behind, None);
}

#[test]
fn the_nearer_triangle_wins_whatever_the_order() {
    let (near, far) = (Vec3::new(0.0, 0.0, 30.0), Vec3::new(0.0, 0.0, -30.0));
    let one = Soup::default()
        .square(near, 30.0, GREEN)
        .square(far, 60.0, BLUE)
        .picture(camera(), 80, 80);
    let other = Soup::default()
        .square(far, 60.0, BLUE)
        .square(near, 30.0, GREEN)
        .picture(camera(), 80, 80);
    assert_eq!(one, other);
    assert!(is_mostly(one.pixel(40, 40).expect("inside"), 1));
    assert!(is_mostly(one.pixel(40, 52).expect("inside"), 2));
}

#[test]
fn a_ball_shows_in_front_of_the_skin_and_hides_behind_it() {
    let with_ball_at = |z: f64| {
        Soup::default()
            .square(Vec3::ZERO, 60.0, GREEN)
            .ball(Vec3::new(0.0, 0.0, z), 8.0, RIGHT)
            .picture(camera(), 80, 80)
    };
    assert!(is_mostly(
        with_ball_at(12.0).pixel(40, 40).expect("inside"),
        0
    ));
    assert!(is_mostly(
        with_ball_at(3.0).pixel(40, 40).expect("inside"),
        0
    ));
    assert!(is_mostly(
        with_ball_at(-12.0).pixel(40, 40).expect("inside"),
        1
    ));
}

#[test]
fn a_ball_covers_what_a_sphere_covers() {
    let (centre, r) = (Vec3::new(40.0, -25.0, 60.0), 35.0);
    let image = Soup::default()
        .ball(centre, r, LEFT)
        .picture(camera(), 160, 120);
    let empty = Soup::default().picture(camera(), 160, 120);
    let focal = 60.0 / 20_f64.to_radians().tan();
    for y in 0..120 {
        for x in 0..160 {
            let ray = Vec3::new(x as f64 + 0.5 - 80.0, 60.0 - y as f64 - 0.5, -focal);
            let to_centre = centre - camera().eye_mm;
            let miss = to_centre.cross(ray).length() / ray.length();
            let drawn = image.pixel(x, y) != empty.pixel(x, y);
            // A pixel is about 1.2 mm wide there.
            if (miss - r).abs() > 1.5 {
                assert_eq!(drawn, miss < r, "pixel {x}, {y}");
            }
        }
    }
}

#[test]
fn a_skin_of_many_triangles_has_no_cracks() {
    let n = 37_u32;
    let mut soup = Soup::default();
    for i in 0..=n * (n + 2) {
        let (x, y) = (f64::from(i % (n + 1)), f64::from(i / (n + 1)));
        let z = 10.0 * (x * 0.7).sin() * (y * 0.5).cos();
        soup.positions
            .push(Vec3::new(x, y, 0.0) * 10.0 - Vec3::new(185.0, 185.0, z));
        soup.normals.push(Vec3::Z);
        soup.colours.push(GREEN);
    }
    for j in 0..n {
        for i in 0..n {
            let at = |i: u32, j: u32| j * (n + 1) + i;
            soup.triangles
                .push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            soup.triangles
                .push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    let image = soup.picture(camera(), 90, 90);
    for y in 0..90 {
        for x in 0..90 {
            assert!(is_mostly(image.pixel(x, y).expect("inside"), 1), "{x}, {y}");
        }
    }
}

#[test]
fn what_crosses_the_eye_is_cut_and_the_rest_is_drawn() {
    // A floor from far behind the eye to far before it: what is below the horizon, and nothing above it.
    let soup = Soup::default().triangle(
        [
            Vec3::new(-9.0e5, -50.0, 9.0e5),
            Vec3::new(9.0e5, -50.0, 9.0e5),
            Vec3::new(0.0, -50.0, -9.0e5),
        ],
        GREEN,
    );
    let image = soup.picture(camera(), 60, 60);
    let empty = Soup::default().picture(camera(), 60, 60);
    for x in 0..60 {
        assert_eq!(image.pixel(x, 20), empty.pixel(x, 20));
        assert_ne!(image.pixel(x, 50), empty.pixel(x, 50));
    }
    let behind = Soup::default()
        .square(Vec3::new(0.0, 0.0, 500.0), 50.0, GREEN)
        .ball(Vec3::new(0.0, 0.0, 450.0), 20.0, RIGHT);
    assert_eq!(behind.picture(camera(), 60, 60), empty);
}

/// A plain field of skin with a dent.
fn dented(depth_mm: f64) -> Soup {
    let n = 80_u32;
    let mut soup = Soup::default();
    for i in 0..=n * (n + 2) {
        let (x, y) = (
            f64::from(i % (n + 1)) * 2.0 - 80.0,
            f64::from(i / (n + 1)) * 2.0 - 80.0,
        );
        let z = -depth_mm * (-(x * x + y * y) / 128.0).exp();
        soup.positions.push(Vec3::new(x, y, z));
        let slope = Vec3::new(x, y, 0.0) * (z / 64.0);
        soup.normals
            .push((slope + Vec3::Z) / (slope + Vec3::Z).length());
    }
    for j in 0..n {
        for i in 0..n {
            let at = |i: u32, j: u32| j * (n + 1) + i;
            soup.triangles
                .push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            soup.triangles
                .push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    soup
}

#[test]
fn a_dent_of_two_millimetres_reads_at_a_glance() {
    let skin = |depth_mm: f64| {
        let soup = dented(depth_mm);
        Picture {
            colours: None,
            positions: &soup.positions,
            normals: &soup.normals,
            triangles: &soup.triangles,
            balls: &[],
            camera: camera(),
            width: 300,
            height: 300,
        }
        .render()
    };
    let (flat, dented) = (skin(0.0), skin(2.0));
    let light =
        |image: &Image, x: usize, y: usize| i32::from(image.pixel(x, y).expect("inside")[1]);
    let inside: Vec<i32> = (-12..=12)
        .map(|i| light(&dented, (150 + i) as usize, (150 + i) as usize))
        .collect();
    let plain = light(&flat, 150, 150);
    let darkest = inside.iter().min().expect("some");
    assert!(plain - darkest >= 20, "{plain}: {inside:?}");
    assert!(
        plain - light(&dented, 150, 150) >= 10,
        "{plain}: {inside:?}"
    );
    assert!((plain - light(&dented, 80, 80)).abs() <= 2);
}

#[test]
fn the_inside_of_an_open_skin_is_not_taken_for_skin() {
    let soup = dented(0.0);
    let mut from_front = camera();
    from_front.eye_mm.z = -400.0;
    let image = Picture {
        colours: None,
        positions: &soup.positions,
        normals: &soup.normals,
        triangles: &soup.triangles,
        balls: &[],
        camera: from_front,
        width: 40,
        height: 40,
    }
    .render();
    let [r, _, b] = image.pixel(20, 20).expect("inside").map(i32::from);
    assert!((r - b).abs() < 25, "{r} {b}");
}

#[test]
fn the_same_scene_gives_the_same_bytes() {
    let once = dented(2.0).ball(Vec3::new(5.0, 5.0, 4.0), 8.0, LEFT);
    assert_eq!(
        once.picture(camera(), 70, 50),
        once.picture(camera(), 70, 50)
    );
    let image = once.picture(camera(), 70, 50);
    assert_eq!(
        (image.width, image.height, image.rgb.len()),
        (70, 50, 70 * 50 * 3)
    );
}

#[test]
fn the_background_is_a_quiet_light_gradient() {
    let image = Soup::default().picture(camera(), 30, 200);
    for y in 0..200 {
        let colour = image.pixel(7, y).expect("inside");
        assert_eq!(image.pixel(0, y), image.pixel(29, y));
        assert!(colour.iter().all(|&c| c > 180) && colour[2] >= colour[0]);
    }
}

#[test]
fn the_png_holds_the_same_pixels() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("back.png");
    std::fs::write(&path, "an older picture").expect("written");
    let image = dented(2.0).picture(camera(), 61, 47);
    image.write_png(&path).expect("written");
    let file = std::io::BufReader::new(std::fs::File::open(&path).expect("there"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut bytes).expect("a frame");
    assert_eq!((info.width, info.height), (61, 47));
    assert_eq!(info.color_type, png::ColorType::Rgb);
    assert_eq!(bytes, image.rgb);
    let left_over = std::fs::read_dir(folder.path()).expect("a folder").count();
    assert_eq!(left_over, 1);
}

#[test]
fn what_cannot_be_written_is_an_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let image = Soup::default().picture(camera(), 4, 4);
    assert!(
        image
            .write_png(&folder.path().join("no/such/folder.png"))
            .is_err()
    );
    let empty = Soup::default().picture(camera(), 0, 4);
    assert!(empty.write_png(&folder.path().join("empty.png")).is_err());
    let torn = Image {
        width: 3,
        height: 3,
        rgb: vec![0; 5],
    };
    assert!(torn.write_png(&folder.path().join("torn.png")).is_err());
    assert_eq!(
        std::fs::read_dir(folder.path()).expect("a folder").count(),
        0
    );
}

#[test]
fn a_picture_too_large_is_drawn_at_the_largest_size() {
    let image = Soup::default().picture(camera(), usize::MAX, 1);
    assert_eq!((image.width, image.height), (MAX_SIDE_PX, 1));
}

fn awkward() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -300.0..300.0_f64,
        1 => prop::sample::select(vec![
            0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN, 5.0e-324, 1.0e-160, 1.0e160, 400.0,
        ]),
    ]
}

fn awkward_vec() -> impl Strategy<Value = Vec3> {
    (awkward(), awkward(), awkward()).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn no_input_makes_it_panic(
        points in prop::collection::vec(awkward_vec(), 0..12),
        normals in prop::collection::vec(awkward_vec(), 0..12),
        triangles in prop::collection::vec(prop::array::uniform3(0_u32..14), 0..12),
        balls in prop::collection::vec((awkward_vec(), awkward()), 0..3),
        eye_mm in awkward_vec(), target_mm in awkward_vec(), up in awkward_vec(), fov in awkward(),
        calm in any::<bool>(), width in 0..24_usize, height in 0..24_usize,
    ) {
        let soup = Soup {
            colours: vec![GREEN; points.len() / 2],
            positions: points,
            normals,
            triangles,
            balls: balls
                .into_iter()
                .map(|(centre_mm, radius_mm)| Ball { centre_mm, radius_mm, colour: LEFT })
                .collect(),
        };
        let wild = Camera { eye_mm, target_mm, up, fov_y_rad: fov };
        let image = soup.picture(if calm { camera() } else { wild }, width, height);
        prop_assert_eq!(image.rgb.len(), 3 * width * height);
    }

    #[test]
    fn what_is_drawn_is_what_rays_meet(
        corners in prop::collection::vec(prop::array::uniform3(-150.0..150.0_f64), 3..18),
    ) {
        let corners: Vec<Vec3> = corners.into_iter().map(Vec3::from_array).collect();
        let colour = |i: usize| if i.is_multiple_of(2) { GREEN } else { BLUE };
        let soup = corners
            .chunks_exact(3)
            .enumerate()
            .fold(Soup::default(), |s, (i, c)| s.triangle([c[0], c[1], c[2]], colour(i)));
        let (width, height) = (24, 20);
        let image = soup.picture(camera(), width, height);
        let empty = Soup::default().picture(camera(), width, height);
        let focal = height as f64 / 2.0 / 20_f64.to_radians().tan();
        for y in 0..height {
            for x in 0..width {
                let mut n_met = 0;
                let mut is_close_call = false;
                for sub in 0..4 {
                    let right = x as f64 + 0.25 + 0.5 * f64::from(sub % 2) - width as f64 / 2.0;
                    let up = height as f64 / 2.0 - y as f64 - 0.25 - 0.5 * f64::from(sub / 2);
                    let ray = Vec3::new(right, up, -focal);
                    // Volumes to the edges: of one sign inside (Plücker).
                    let met = corners.chunks_exact(3).any(|c| {
                        let [a, b, c] = [c[0], c[1], c[2]].map(|p| p - camera().eye_mm);
                        let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|n| n.dot(ray));
                        is_close_call |= sides.iter().any(|s| s.abs() < 1.0e-3);
                        sides.iter().all(|&s| s > 0.0) || sides.iter().all(|&s| s < 0.0)
                    });
                    n_met += u32::from(met);
                }
                if !is_close_call {
                    let drawn = image.pixel(x, y) != empty.pixel(x, y);
                    prop_assert_eq!(drawn, n_met > 0, "pixel {}, {}", x, y);
                }
            }
        }
    }

    #[test]
    fn a_framed_box_fills_the_picture_and_is_never_cut_off(
        a in prop::array::uniform3(-400.0..400.0_f64), b in prop::array::uniform3(-400.0..400.0_f64),
        direction in prop::array::uniform3(-1.0..1.0_f64), wide in 0.3..3.0_f64,
    ) {
        let (a, b) = (Vec3::from_array(a), Vec3::from_array(b));
        let bounds = Aabb { min: a.min(b), max: a.max(b) };
        let (width, height) = ((500.0 * wide) as usize, 500);
        let camera = Camera::framing(&bounds, Vec3::from_array(direction), width as f64 / height as f64);
        let mut fullest: f64 = 0.0;
        for i in 0..8 {
            let pick = |bit: i32, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
            let corner = Vec3::new(
                pick(0, bounds.min.x, bounds.max.x),
                pick(1, bounds.min.y, bounds.max.y),
                pick(2, bounds.min.z, bounds.max.z),
            );
            let at = camera.place_in_picture(corner, width, height).expect("in front");
            let from_middle = [at.x / width as f64 - 0.5, at.y / height as f64 - 0.5];
            fullest = fullest.max(from_middle[0].abs()).max(from_middle[1].abs());
        }
        prop_assert!((0.5 / 1.07..=0.5 / 1.05).contains(&fullest), "{}", fullest);
    }
}

#[test]
fn framing_something_impossible_still_gives_a_camera() {
    for bounds in [
        Aabb::EMPTY,
        Aabb::of_points([Vec3::NAN]),
        Aabb::of_points([Vec3::ZERO]),
        Aabb::cube(Vec3::ZERO, f64::INFINITY),
    ] {
        for direction in [Vec3::ZERO, Vec3::NAN, Vec3::Y, Vec3::Z] {
            for aspect in [0.0, f64::NAN, 1.0] {
                let camera = Camera::framing(&bounds, direction, aspect);
                assert!(camera.place_in_picture(camera.target_mm, 10, 10).is_some());
            }
        }
    }
}
