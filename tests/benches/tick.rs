//! What a tick costs, by number of triangles, beside the nearest-point query of parry: `cargo bench --bench tick`.
//!
//! The benchmark surface and path of `surface::primitives`: 20,000 ticks at 1 kHz, 5 mm deep (contact) or 30 mm above
//! (hover), stiffness 1 N/mm, friction 0.46 / 0.44. Every call is timed by itself; what reading the clock costs is
//! measured and taken off. `shuffled` has the triangles and vertices in random order.

use dorsum::contact::{ContactState, Friction, Stiffness, Touch, TouchScene, advance};
use dorsum::device::Reading;
use dorsum::geom::Vec3;
use dorsum::partition::{Partition, bvh::Bvh};
use dorsum::servo::{Limits, Rig, TickInput, tick};
use dorsum::surface::primitives::{bench_height, bench_patch, bench_path};
use dorsum::surface::{RawMesh, Surface};
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::TriMesh;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

const TICKS: usize = 20_000;
const DT_S: f64 = 1e-3;
const RIVAL_S: f64 = 3.0;

fn main() {
    let largest = std::env::args()
        .filter_map(|a| a.parse().ok())
        .next_back()
        .unwrap_or(2_000_000);
    let clock_ns = clock_cost_ns();
    println!("reading the clock: {clock_ns:.0} ns, taken off\n");
    println!(
        "{:>10} {:<10} {:<13} | {:>8} {:>8} {:>8} | {:>8} {:>8} {:>8} | {:>6} {:>5} {:>7} {:>7}",
        "triangles",
        "order",
        "what",
        "tick p50",
        "p99",
        "max us",
        "adv. p50",
        "p99",
        "mean us",
        "lag mm",
        "pops",
        "dF p99",
        "dF max"
    );
    let mut builds = Vec::new();
    for n in [2962, 20_389, 41_582, 500_000, 2_000_000] {
        if n > largest {
            continue;
        }
        for (order, mesh) in [
            ("rows", bench_patch(n)),
            ("shuffled", shuffled(bench_patch(n))),
        ] {
            builds.push(one_mesh(order, mesh, clock_ns));
        }
    }
    println!(
        "\n{:>10} {:<10} | {:>9} {:>8} | {:>9} {:>8} | {:>9} {:>9} | {:>12}",
        "triangles",
        "order",
        "build ms",
        "B/tri",
        "parry ms",
        "B/tri",
        "parry p50",
        "p99 us",
        "parry / tick"
    );
    for b in builds {
        println!(
            "{:>10} {:<10} | {:>9.1} {:>8.1} | {:>9.1} {:>8.1} | {:>9.2} {:>9.2} | {:>12.1}",
            b.triangles,
            b.order,
            b.build_ms,
            b.bytes,
            b.parry_build_ms,
            b.parry_bytes,
            b.parry.p50,
            b.parry.p99,
            b.parry.p50 / b.tick_p50,
        );
    }
}

struct Build {
    triangles: usize,
    order: &'static str,
    build_ms: f64,
    bytes: f64,
    parry_build_ms: f64,
    parry_bytes: f64,
    parry: Cost,
    tick_p50: f64,
}

/// Microseconds.
struct Cost {
    p50: f64,
    p99: f64,
    max: f64,
    mean: f64,
}

fn cost(mut ns: Vec<u64>, clock_ns: f64) -> Cost {
    ns.sort_unstable();
    let us = |ns: u64| (ns as f64 - clock_ns).max(0.0) / 1000.0;
    Cost {
        p50: us(ns[ns.len() / 2]),
        p99: us(ns[ns.len() * 99 / 100]),
        max: us(ns[ns.len() - 1]),
        mean: ns.iter().map(|&n| us(n)).sum::<f64>() / ns.len() as f64,
    }
}

fn clock_cost_ns() -> f64 {
    let mut ns: Vec<u64> = (0..100_000)
        .map(|_| Instant::now().elapsed().as_nanos() as u64)
        .collect();
    ns.sort_unstable();
    ns[ns.len() / 2] as f64
}

fn one_mesh(order: &'static str, mesh: RawMesh, clock_ns: f64) -> Build {
    let vertices: Vec<Vector> = mesh
        .positions
        .iter()
        .map(|p| Vector::new(p.x, p.y, p.z))
        .collect();
    let surface = match Surface::new(mesh) {
        Ok((surface, _)) => Arc::new(surface),
        Err(e) => panic!("the benchmark surface is refused: {e}"),
    };
    let triangles = surface.triangles().len();
    let start = Instant::now();
    let search = Arc::new(Bvh::new(&surface));
    let build_ms = start.elapsed().as_secs_f64() * 1e3;
    let mut tick_p50 = 0.0;
    for (what, offset_mm, friction) in [
        ("frictionless", -5.0, None),
        ("friction", -5.0, Some(())),
        ("hover", 30.0, Some(())),
    ] {
        let scene = TouchScene {
            friction: friction.map(|()| Friction {
                static_coefficient: 0.46,
                dynamic_coefficient: 0.44,
                skin_looseness: 1.0,
            }),
            ..TouchScene::new(surface.clone(), search.clone(), Stiffness::Uniform(1.0))
        };
        let run = path(&scene, offset_mm, clock_ns);
        let whole = whole_ticks(scene, offset_mm, clock_ns);
        if what == "friction" {
            tick_p50 = whole.p50;
        }
        println!(
            "{triangles:>10} {order:<10} {what:<13} | {:>8.3} {:>8.3} {:>8.2} | {:>8.3} {:>8.3} {:>8.3} | {:>6.2} {:>5} {:>7.3} {:>7.3}",
            whole.p50,
            whole.p99,
            whole.max,
            run.cost.p50,
            run.cost.p99,
            run.cost.mean,
            run.lag_mm,
            run.pops,
            run.force_step_p99_n,
            run.force_step_max_n,
        );
    }
    let bytes = search.bytes() as f64 / triangles as f64;
    let start = Instant::now();
    let rival = match TriMesh::new(vertices, surface.triangles().to_vec()) {
        Ok(rival) => rival,
        Err(e) => panic!("parry refuses the benchmark surface: {e}"),
    };
    let parry_build_ms = start.elapsed().as_secs_f64() * 1e3;
    // Every tenth tick, and no longer than RIVAL_S: its tree over shuffled triangles can take milliseconds a query.
    let begun = Instant::now();
    let ns = (0..TICKS)
        .step_by(10)
        .take_while(|_| begun.elapsed().as_secs_f64() < RIVAL_S)
        .map(|i| {
            let p = bench_path(i as f64 * DT_S, -5.0);
            let start = Instant::now();
            black_box(rival.project_local_point(Vector::new(p.x, p.y, p.z), false));
            start.elapsed().as_nanos() as u64
        })
        .collect();
    Build {
        triangles,
        order,
        build_ms,
        bytes,
        parry_build_ms,
        parry_bytes: rival.bvh().heap_memory_size() as f64 / triangles as f64,
        parry: cost(ns, clock_ns),
        tick_p50,
    }
}

/// Ticks of the approach from 30 mm above, not timed.
fn approach(offset_mm: f64) -> impl Iterator<Item = Vec3> {
    let first = bench_path(0.0, 30.0);
    (0..300).map(move |i| first + Vec3::Z * ((offset_mm - 30.0) * f64::from(i) / 299.0))
}

struct Run {
    cost: Cost,
    lag_mm: f64,
    pops: usize,
    force_step_p99_n: f64,
    force_step_max_n: f64,
}

fn path(scene: &TouchScene, offset_mm: f64, clock_ns: f64) -> Run {
    let mut state = ContactState {
        proxy_mm: bench_path(0.0, 30.0),
        ..ContactState::default()
    };
    let mut last_force_n = Vec3::ZERO;
    for hip in approach(offset_mm) {
        last_force_n = advance(scene, &mut state, hip).force_n;
    }
    let (mut ns, mut steps_n, mut lag_mm, mut pops) = (vec![], vec![], 0.0_f64, 0);
    for i in 0..TICKS {
        let hip = bench_path(i as f64 * DT_S, offset_mm);
        let start = Instant::now();
        let contact = black_box(advance(scene, &mut state, black_box(hip)));
        ns.push(start.elapsed().as_nanos() as u64);
        steps_n.push((contact.force_n - last_force_n).length());
        last_force_n = contact.force_n;
        lag_mm = lag_mm.max((contact.anchor_mm - hip).truncate().length());
        let below = hip.z < bench_height(hip.x, hip.y) - 2.0;
        pops += usize::from(below && contact.touch == Touch::Free);
    }
    steps_n.sort_unstable_by(f64::total_cmp);
    Run {
        cost: cost(ns, clock_ns),
        lag_mm,
        pops,
        force_step_p99_n: steps_n[TICKS * 99 / 100],
        force_step_max_n: steps_n[TICKS - 1],
    }
}

fn whole_ticks(scene: TouchScene, offset_mm: f64, clock_ns: f64) -> Cost {
    let mut rig = Rig::new(Box::new(scene), Default::default());
    for limits in &mut rig.limits {
        *limits = Limits {
            rated_force_n: 22.0,
            ..Limits::default()
        };
    }
    let input = |hip: Vec3| {
        let mut input = TickInput {
            n_fingers: 1,
            force_enabled: true,
            ..TickInput::default()
        };
        input.readings[0] = Reading {
            position_mm: hip,
            connected: true,
            ..Reading::default()
        };
        input
    };
    for hip in approach(offset_mm) {
        tick(&mut rig, &input(hip), DT_S);
    }
    let ns = (0..TICKS)
        .map(|i| {
            let input = input(bench_path(i as f64 * DT_S, offset_mm));
            let start = Instant::now();
            black_box(tick(&mut rig, black_box(&input), DT_S));
            start.elapsed().as_nanos() as u64
        })
        .collect();
    cost(ns, clock_ns)
}

/// The same surface with its vertices and triangles in an order that tells nothing of where they are.
fn shuffled(mesh: RawMesh) -> RawMesh {
    let mut seed = 1_u64;
    let mut below = |n: usize| {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((seed >> 33) as usize) % n
    };
    let n = mesh.positions.len();
    let mut place: Vec<u32> = (0..n as u32).collect();
    for i in (1..n).rev() {
        place.swap(i, below(i + 1));
    }
    let mut positions = vec![Vec3::ZERO; n];
    for (i, &to) in place.iter().enumerate() {
        positions[to as usize] = mesh.positions[i];
    }
    let mut triangles: Vec<[u32; 3]> = mesh
        .triangles
        .iter()
        .map(|t| t.map(|v| place[v as usize]))
        .collect();
    for i in (1..triangles.len()).rev() {
        triangles.swap(i, below(i + 1));
    }
    RawMesh {
        positions,
        triangles,
    }
}
