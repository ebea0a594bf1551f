//! What FSMD costs per vertex in the footprint, over mesh size and number of fingers: `cargo bench --bench deform`.
//!
//! Fingers slide over the built-in back with friction, so that every frame finds its footprint anew and every vertex in it
//! changes. A footprint is the tangential one, 140 mm in radius. Times are ns per vertex moved, least / median over the
//! frames: other programs only ever add. "normals" and "strain" are passes of their own, "both" is the one pass in which
//! the model brings both along, "frame" offsets and both.
//!
//! "plain" is the yardstick that shares the state of the machine: the formula alone for every vertex of the surface in the
//! order of memory, one after the other, with no search, no comparison and no list. "ratio" is frame over plain.

use dorsum::deform::curve::Curve;
use dorsum::deform::footprint::{Ellipse, Outline};
use dorsum::deform::models::fsmd::{Fsmd, Settings};
use dorsum::deform::strain::Strain;
use dorsum::deform::{Displacement, Model as _, Press};
use dorsum::geom::Vec3;
use dorsum::surface::Surface;
use dorsum::surface::back::{self, BackOptions};
use std::time::Instant;

const COLUMNS: [&str; 6] = ["plain", "offsets", "normals", "strain", "both", "frame"];

fn main() {
    print!("{:>10} {:>8} {:>10}", "triangles", "fingers", "moved");
    COLUMNS.iter().for_each(|name| print!("{name:>15}"));
    println!("{:>8}", "ratio");
    for triangles in [20_389, 500_000, 2_000_000] {
        let skin = match Surface::new(back::make(&BackOptions::with_triangles(triangles))) {
            Ok((skin, _)) => skin,
            Err(e) => {
                println!("{triangles}: {e}");
                continue;
            }
        };
        for n_fingers in [1, 2] {
            report(&skin, n_fingers);
        }
    }
}

fn report(skin: &Surface, n_fingers: usize) {
    let mut model = Fsmd::new(Settings::default());
    let mut out = Displacement::at_rest(skin);
    model.update(skin, &[], &mut out);
    let mut strain = Strain::new(skin, &out);
    let n_frames = (20_000_000 / skin.triangles().len()).clamp(15, 400);
    let mut plain_offsets = vec![Vec3::ZERO; skin.positions().len()];
    let mut moved = vec![];
    let mut times: [Vec<f64>; 6] = Default::default();
    for i in 0..n_frames {
        let presses: Vec<Press> = (0..n_fingers).map(|f| press(skin, i, f)).collect();
        model.displace(skin, &presses, &mut out);
        let in_passes = 1.0 / out.n_moved().max(1) as f64;
        let normals = timed(|| model.shade(skin, &mut out));
        let strains = timed(|| strain.update(skin, &out));
        // The same again for the passes in one.
        let presses: Vec<Press> = (0..n_fingers).map(|f| press(skin, i + 7, f)).collect();
        let offsets = timed(|| model.displace(skin, &presses, &mut out));
        let both = timed(|| model.shade_strained(skin, &mut out, &mut strain));
        let plain = timed(|| plain_pass(skin, &presses[0], &mut plain_offsets));
        let per_vertex = 1.0 / out.n_moved().max(1) as f64;
        moved.push(out.n_moved() as f64);
        let here = [
            plain / plain_offsets.len() as f64,
            offsets * per_vertex,
            normals * in_passes,
            strains * in_passes,
            both * per_vertex,
            (offsets + both) * per_vertex,
        ];
        for (times, ns) in times.iter_mut().zip(here) {
            times.push(ns);
        }
    }
    let n_moved = median(moved);
    print!(
        "{:>10} {n_fingers:>8} {n_moved:>10}",
        skin.triangles().len()
    );
    for times in &times {
        let both = format!("{:.1} / {:.1}", least(times), median(times.clone()));
        print!("{both:>15}");
    }
    println!("{:>8.1}", least(&times[5]) / least(&times[0]));
    let per_vertex = |bytes: usize| bytes as f64 / skin.positions().len() as f64;
    println!(
        "{:>10} bytes per vertex: model {:.0}, displacement {:.0}, strain {:.0}",
        "",
        per_vertex(model.bytes()),
        per_vertex(out.bytes()),
        per_vertex(strain.bytes())
    );
}

/// What it takes, ns.
fn timed(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1.0e9
}

/// The formula for every vertex.
fn plain_pass(skin: &Surface, press: &Press, offsets: &mut [Vec3]) {
    let curve = Curve::gaussian();
    let Some(circle) = Ellipse::new(press.anchor_mm, press.normal, 140.0, 140.0, 0.0) else {
        return;
    };
    let pull = press.foot_mm - press.anchor_mm;
    for (offset, p) in offsets.iter_mut().zip(skin.positions()) {
        *offset = pull * curve.at(circle.ratio(*p));
    }
    std::hint::black_box(&offsets);
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
