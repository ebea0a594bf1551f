//! What a tick costs, by number of triangles, beside what others take for one query: `cargo bench --bench tick`.
//!
//! The benchmark surface and path of `surface::primitives`: 20,000 ticks at 1 kHz, 5 mm deep (contact) or 30 mm above
//! (hover), stiffness 1 N/mm, friction 0.46 / 0.44. Every call is timed by itself; what reading the clock costs is
//! measured and taken off. What takes too long is cut short. A number as argument leaves out meshes with more triangles.

mod cases;
mod measure;
mod ours;
mod rivals;

use cases::Case;
use measure::{Cost, Table};
use ours::{Fingers, Scene};

fn main() {
    let largest = std::env::args()
        .filter_map(|a| a.parse().ok())
        .next_back()
        .unwrap_or(2_000_000);
    let clock_ns = measure::clock_cost_ns();
    println!("Reading the clock takes {clock_ns:.0} ns, taken off below. Times in µs a call.");
    let ours = Table::new(&[
        ("triangles", 9),
        ("mesh", -14),
        ("finger", -13),
        ("tick p50", 9),
        ("p99", 8),
        ("max", 9),
        ("engine p50", 11),
        ("p99", 8),
        ("lag mm", 7),
        ("pops", 5),
        ("dF p99 N", 9),
        ("max N", 7),
    ]);
    println!("\nOurs: the whole tick of the servo, and the contact engine in it.");
    ours.head();
    let mut beside = Vec::new();
    for make in cases::all(largest) {
        let case = make();
        let scene = Scene::new(&case);
        let mut ticks = Vec::new();
        for finger in Fingers::all() {
            let felt = scene.path(&case, &finger, clock_ns);
            let tick = scene.whole_ticks(&case, &finger, clock_ns);
            ours.row(&[
                scene.triangles().to_string(),
                case.name.into(),
                finger.name.into(),
                format!("{:.3}", tick.p50),
                format!("{:.3}", tick.p99),
                format!("{:.1}", tick.max),
                format!("{:.3}", felt.cost.p50),
                format!("{:.3}", felt.cost.p99),
                format!("{:.2}", felt.lag_mm),
                felt.pops.to_string(),
                format!("{:.3}", felt.force_step_p99_n),
                format!("{:.3}", felt.force_step_max_n),
            ]);
            ticks.push(tick);
        }
        beside.push(Beside::measure(&case, scene, ticks, clock_ns));
    }
    beside_rivals(&beside);
    builds(&beside);
}

/// One mesh: what ours takes for it and what the others take.
struct Beside {
    triangles: usize,
    mesh: &'static str,
    /// The whole tick with friction, and that of a finger pad.
    point: Cost,
    pad: Cost,
    nearest: Cost,
    sphere: Cost,
    brute: Option<Cost>,
    published: Option<Cost>,
    surface_ms: f64,
    search_ms: f64,
    first_touch_us: f64,
    search_bytes: f64,
    surface_bytes: f64,
    parry_ms: f64,
    parry_bytes: f64,
}

impl Beside {
    fn measure(case: &Case, scene: Scene, ticks: Vec<Cost>, clock_ns: f64) -> Self {
        let [_, point, _, pad, _, _] = ticks.try_into().unwrap_or_else(|_| panic!("six fingers"));
        let triangles = scene.triangles();
        let per_triangle = |bytes: usize| bytes as f64 / triangles as f64;
        let small = triangles <= 50_000;
        let brute = small.then(|| rivals::brute(case, &scene.surface, clock_ns));
        let published = rivals::published(case, &scene, clock_ns);
        let (surface_ms, search_ms) = (scene.surface_ms, scene.search_ms);
        let first_touch_us = scene.first_touch_us(case);
        let search_bytes = per_triangle(scene.search_bytes());
        let surface_bytes = per_triangle(scene.surface.bytes());
        drop(scene);
        let parry = rivals::Parry::new(&case.mesh);
        Self {
            triangles,
            mesh: case.name,
            point,
            pad,
            nearest: parry.nearest(case, clock_ns),
            sphere: parry.sphere_sweep(case, clock_ns),
            brute,
            published,
            surface_ms,
            search_ms,
            first_touch_us,
            search_bytes,
            surface_bytes,
            parry_ms: parry.build_ms,
            parry_bytes: per_triangle(parry.bytes()),
        }
    }
}

fn beside_rivals(rows: &[Beside]) {
    println!("\nBeside others: medians / 99th percentiles, and how many times ours the median is.");
    println!(
        "Point: our whole tick with friction; parry's nearest point; the nearest of all triangles; the published pass (octree, 1024)."
    );
    println!("Pad: our whole tick of a 5 mm pad with friction; parry's sweep of a 5 mm ball.");
    let table = Table::new(&[
        ("triangles", 9),
        ("mesh", -14),
        ("point", 13),
        ("nearest", 15),
        ("times", 7),
        ("brute", 15),
        ("times", 8),
        ("published", 16),
        ("times", 7),
        ("pad", 13),
        ("ball sweep", 17),
        ("times", 8),
    ]);
    table.head();
    for b in rows {
        let times = |rival: &Cost, own: &Cost| format!("{:.1}", rival.p50 / own.p50);
        let beside = |rival: &Option<Cost>| match rival {
            Some(cost) => [cost.short(), times(cost, &b.point)],
            None => ["-".into(), "-".into()],
        };
        let ([brute, brute_times], [published, published_times]) =
            (beside(&b.brute), beside(&b.published));
        table.row(&[
            b.triangles.to_string(),
            b.mesh.into(),
            b.point.short(),
            b.nearest.short(),
            times(&b.nearest, &b.point),
            brute,
            brute_times,
            published,
            published_times,
            b.pad.short(),
            b.sphere.short(),
            times(&b.sphere, &b.pad),
        ]);
    }
}

fn builds(rows: &[Beside]) {
    println!("\nBuilding, memory, and the first tick that touches.");
    let table = Table::new(&[
        ("triangles", 9),
        ("mesh", -14),
        ("surface ms", 11),
        ("search ms", 10),
        ("first touch us", 15),
        ("search B/tri", 13),
        ("with surface", 13),
        ("parry ms", 9),
        ("B/tri", 7),
    ]);
    table.head();
    for b in rows {
        table.row(&[
            b.triangles.to_string(),
            b.mesh.into(),
            format!("{:.1}", b.surface_ms),
            format!("{:.1}", b.search_ms),
            format!("{:.1}", b.first_touch_us),
            format!("{:.1}", b.search_bytes),
            format!("{:.1}", b.search_bytes + b.surface_bytes),
            format!("{:.1}", b.parry_ms),
            format!("{:.1}", b.parry_bytes),
        ]);
    }
}
