//! How soon an edit is felt: `cargo bench --bench edit`.
//!
//! A bench without a window, polled as the window polls it; a finger holds still in the skin. Every edit changes a stiffness
//! key, so that the field is fitted anew for every vertex. The frame in which the window passes the edit on is not in the
//! figures: at most 17 ms more.

use dorsum::app::bench::{Bench, Source};
use dorsum::app::state::View;
use dorsum::contact::Touch;
use std::sync::Arc;
use std::time::{Duration, Instant};

const PERIOD: Duration = Duration::from_millis(16);
const EDITS: u32 = 40;
const LONGEST: Duration = Duration::from_secs(120);

fn scenario(triangles: usize, stiffness_n_per_mm: f64) -> String {
    let rows = (0..7).flat_map(|j| (0..5).map(move |i| (i, j)));
    let keys = rows.map(|(i, j)| {
        let (x, y) = (60 * i - 120, 60 * j + 60);
        let here = if (i, j) == (3, 3) {
            stiffness_n_per_mm
        } else {
            0.5
        };
        format!("  {{ x = {x}, y = {y}, stiffness_n_per_mm = {here} }},\n")
    });
    let keys: String = keys.collect();
    format!(
        "format = 1\nname = \"Edited\"\n[surface]\nbuiltin = \"back\"\ntriangles = {triangles}\n\
         [stiffness]\nkey = [\n{keys}]\n[friction]\nstatic = 0.46\ndynamic = 0.44\n"
    )
}

/// Polls as the window does until `done`; the time it took, ms.
fn until(bench: &mut Bench, view: &mut View, done: impl Fn(&View) -> bool) -> f64 {
    let began = Instant::now();
    loop {
        bench.poll();
        bench.fill(view, true);
        if done(view) {
            return began.elapsed().as_secs_f64() * 1e3;
        }
        if began.elapsed() > LONGEST {
            println!("nothing came within {} s", LONGEST.as_secs());
            return f64::NAN;
        }
        std::thread::sleep(PERIOD);
    }
}

fn middle_and_longest(mut ms: Vec<f64>) -> (f64, f64) {
    ms.sort_by(f64::total_cmp);
    (ms[ms.len() / 2], ms[ms.len() - 1])
}

fn main() -> std::io::Result<()> {
    let folder = tempfile::tempdir()?;
    println!("triangles   first felt, ms (p50, longest)   wholly felt, ms (p50, longest)");
    for triangles in [2_962, 20_389, 41_582, 500_000] {
        let mut bench = Bench::new(Arc::new(|| {}), folder.path().to_owned());
        let mut view = View::default();
        bench.open(Source::Text {
            toml: scenario(triangles, 0.35),
            origin: "edited".into(),
            folder: None,
        });
        until(&mut bench, &mut view, |v| v.live.record.n_fingers > 0);
        let Some(scene) = view.scene.clone() else {
            continue;
        };
        let aim = scene
            .surface
            .positions()
            .iter()
            .zip(scene.surface.normals());
        let distance = |x: f64, y: f64| (x - 60.0).hypot(y - 240.0);
        let at = aim
            .filter(|(_, n)| n.z > 0.5)
            .min_by(|a, b| distance(a.0.x, a.0.y).total_cmp(&distance(b.0.x, b.0.y)));
        let Some((point, normal)) = at else {
            continue;
        };
        view.hands[1].set(*point + *normal * 20.0);
        std::thread::sleep(Duration::from_millis(300));
        view.hands[1].set(*point - *normal * 4.0);
        until(&mut bench, &mut view, |v| {
            v.live.record.fingers[1].contact.touch != Touch::Free
        });
        let (mut first, mut whole) = (Vec::new(), Vec::new());
        for i in 1..=EDITS {
            // Out of step with the polls.
            std::thread::sleep(Duration::from_millis(u64::from(i * 7 % 16)));
            let k = if i % 2 == 1 { 1.5 } else { 0.35 };
            bench.edit_scene(scenario(triangles, k));
            let began = Instant::now();
            first.push(until(&mut bench, &mut view, |v| v.live.edit == i));
            until(&mut bench, &mut view, |v| v.live.fade >= 1.0);
            whole.push(began.elapsed().as_secs_f64() * 1e3);
        }
        let ((a, b), (c, d)) = (middle_and_longest(first), middle_and_longest(whole));
        println!("{triangles:>9}   {a:>14.0} {b:>8.0}        {c:>14.0} {d:>8.0}");
        bench.shut_down();
    }
    Ok(())
}
