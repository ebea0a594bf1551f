//! What FSMD costs per vertex in the footprint, over mesh size and number of fingers: `cargo bench --bench deform`.
//!
//! Fingers slide over the built-in back with friction, so that every frame finds its footprint anew and every vertex in it
//! changes. A footprint is the tangential one, 140 mm in radius.
//!
//! "plain" is the yardstick that shares the state of the machine: the formula alone for every vertex of the surface in the
//! order of memory, with no search, no comparison and no list.

use dorsum::deform::curve::Curve;
use dorsum::deform::footprint::{Ellipse, Outline};
use dorsum::deform::models::fsmd::{Fsmd, Settings};
use dorsum::deform::{Displacement, Press};
use dorsum::geom::Vec3;
use dorsum::surface::Surface;
use dorsum::surface::back::{self, BackOptions};
use std::time::Instant;

fn main() {
    println!(
        "{:>10} {:>8} {:>10} {:>10} {:>12} {:>14} {:>12}",
        "triangles", "fingers", "moved", "plain ns", "offsets ns", "+ normals ns", "frame ms"
    );
    for triangles in [20_389, 500_000, 2_000_000] {
        let skin = match Surface::new(back::make(&BackOptions::with_triangles(triangles))) {
            Ok((skin, _)) => skin,
            Err(e) => {
                println!("{triangles}: {e}");
                continue;
            }
        };
        for n_fingers in [1, 2] {
            let row = measure(&skin, n_fingers);
            println!(
                "{:>10} {:>8} {:>10} {:>10.2} {:>12.2} {:>14.2} {:>12.3}",
                skin.triangles().len(),
                n_fingers,
                row.moved,
                row.plain_ns,
                row.offsets_ns,
                row.all_ns,
                row.frame_ms
            );
        }
    }
}

/// The cheapest of the frames for ns, as other programs only ever add; the median for the whole frame. ns are per vertex moved.
struct Row {
    moved: usize,
    plain_ns: f64,
    offsets_ns: f64,
    all_ns: f64,
    frame_ms: f64,
}

fn measure(skin: &Surface, n_fingers: usize) -> Row {
    let mut model = Fsmd::new(Settings::default());
    let mut out = Displacement::at_rest(skin);
    let n_frames = (20_000_000 / skin.triangles().len()).clamp(15, 400);
    let mut plain = vec![];
    let mut plain_offsets = vec![Vec3::ZERO; skin.positions().len()];
    let (mut moved, mut offsets, mut all, mut frame) = (vec![], vec![], vec![], vec![]);
    for i in 0..n_frames {
        let presses: Vec<Press> = (0..n_fingers).map(|f| press(skin, i, f)).collect();
        plain.push(plain_pass(skin, &presses[0], &mut plain_offsets));
        let start = Instant::now();
        model.displace(skin, &presses, &mut out);
        let displaced = start.elapsed();
        model.shade(skin, &mut out);
        let done = start.elapsed();
        let in_footprints = out.n_moved();
        let per_vertex = 1.0e9 / in_footprints.max(1) as f64;
        moved.push(in_footprints as f64);
        offsets.push(displaced.as_secs_f64() * per_vertex);
        all.push(done.as_secs_f64() * per_vertex);
        frame.push(done.as_secs_f64() * 1.0e3);
    }
    Row {
        moved: median(moved) as usize,
        plain_ns: least(&plain),
        offsets_ns: least(&offsets),
        all_ns: least(&all),
        frame_ms: median(frame),
    }
}

/// The formula for every vertex; ns per vertex.
fn plain_pass(skin: &Surface, press: &Press, offsets: &mut [Vec3]) -> f64 {
    let curve = Curve::gaussian();
    let Some(circle) = Ellipse::new(press.anchor_mm, press.normal, 140.0, 140.0, 0.0) else {
        return f64::NAN;
    };
    let pull = press.foot_mm - press.anchor_mm;
    let start = Instant::now();
    for (offset, p) in offsets.iter_mut().zip(skin.positions()) {
        *offset = pull * curve.at(circle.ratio(*p));
    }
    std::hint::black_box(&offsets);
    start.elapsed().as_secs_f64() * 1.0e9 / offsets.len() as f64
}

/// A finger sliding up and down beside the spine, at the vertex nearest to its path.
fn press(skin: &Surface, frame: usize, finger: usize) -> Press {
    let bounds = skin.bounds();
    let y = bounds.centre().y + 60.0 * (frame as f64 * 0.37).sin();
    let x = if finger == 0 { -30.0 } else { 35.0 };
    let from_path = |p: &Vec3| {
        (p.x - x).powi(2) + (p.y - y).powi(2) - if p.z > bounds.centre().z { 1e4 } else { 0.0 }
    };
    let vertex = (0..skin.positions().len())
        .min_by(|&a, &b| {
            from_path(&skin.positions()[a]).total_cmp(&from_path(&skin.positions()[b]))
        })
        .unwrap_or(0);
    let anchor_mm = skin.positions()[vertex];
    let triangle = skin.topology().triangles_of(vertex as u32)[0];
    let normal = skin.triangle(triangle).normal();
    let pull = dorsum::geom::any_tangent(normal) * (6.0 + (frame as f64 * 0.7).sin());
    Press {
        anchor_mm,
        foot_mm: anchor_mm + pull,
        normal,
        depth_mm: 6.0 + 2.0 * (frame as f64 * 0.9).cos(),
        triangle,
        ..Press::default()
    }
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
