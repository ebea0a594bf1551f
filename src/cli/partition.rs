//! `dorsum partition`: one search structure over a mesh, its statistics, and what a haptic detecting box gathers.

use super::common::{bytes_text, load_mesh, progress_bar};
use super::{CliError, Outcome, print, print_json};
use crate::geom::{Aabb, Vec3};
use crate::partition::brute::Brute;
use crate::partition::hdb::{self, Gathered};
use crate::partition::structure::TREES;
use crate::partition::tree::{Case, Options, Statistics};
use crate::partition::{self, Partition as _, Structure};
use crate::surface::Surface;
use serde::Serialize;
use std::time::Instant;

/// Times a query is repeated for its median time.
const REPEATS: usize = 101;

/// Which mesh, which structure, where to ask.
#[derive(Debug, clap::Args)]
pub struct PartitionArgs {
    /// Mesh file, or back, or back:N for the built-in one with N triangles.
    mesh: String,
    /// Structure: brute, bvh, bsp, octree or hybrid.
    #[arg(long, value_parser = kind_by_name)]
    kind: &'static str,
    /// Most triangles in a leaf of bsp, octree and hybrid. Without: 1024.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    threshold: Option<u32>,
    /// Triangles on a plane of bsp: a cuts them in pieces, b lists them on both sides, c where most vertices are.
    /// Without: c.
    #[arg(long, value_parser = case_by_name)]
    case: Option<Case>,
    /// Middle of the haptic detecting box, mm. Without: the skin nearest the middle of the box's back.
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    probe: Option<Vec3>,
    /// Edge of the haptic detecting box. Without: a quarter of the longest edge of the mesh's box.
    #[arg(long, value_name = "MM", value_parser = edge)]
    hdb_edge: Option<f64>,
}

fn kind_by_name(name: &str) -> Result<&'static str, String> {
    let names = || partition::all().iter().map(|(n, _)| *n);
    names()
        .find(|n| *n == name)
        .ok_or_else(|| format!("allowed are {}", names().collect::<Vec<_>>().join(", ")))
}

fn case_by_name(name: &str) -> Result<Case, String> {
    match name {
        "a" => Ok(Case::A),
        "b" => Ok(Case::B),
        "c" => Ok(Case::C),
        _ => Err("allowed are a, b, c".into()),
    }
}

fn point(text: &str) -> Result<Vec3, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|t| t.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if Vec3::new(x, y, z).is_finite() => Ok(Vec3::new(x, y, z)),
        _ => Err("three numbers x,y,z in mm are needed".into()),
    }
}

fn edge(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|x: &f64| x.is_finite() && *x > 0.0)
        .ok_or_else(|| "a length above 0 mm is needed".into())
}

/// Builds the structure, with a progress bar on a terminal.
fn built(kind: &str, surface: &Surface, options: &Options) -> Result<Structure, CliError> {
    let bar = progress_bar(100, "building {bar:30} {percent:>3} %");
    let built = Structure::build(kind, surface, options, &mut |part| {
        bar.set_position((part * 100.0) as u64);
        true
    });
    bar.finish_and_clear();
    built
        .map_err(CliError::input)?
        .ok_or_else(|| CliError::input("the build was stopped"))
}

#[derive(Serialize)]
struct Query {
    triangles: usize,
    nodes_visited: Option<usize>,
    leaves_visited: Option<usize>,
    median_us: f64,
}

/// Result and median time of a query.
fn asked(mut ask: impl FnMut(&mut Vec<u32>) -> Option<Gathered>) -> Query {
    let mut out = Vec::new();
    let mut cost = None;
    let mut times: Vec<f64> = (0..REPEATS)
        .map(|_| {
            out.clear();
            let start = Instant::now();
            cost = ask(&mut out);
            start.elapsed().as_secs_f64() * 1e6
        })
        .collect();
    times.sort_unstable_by(f64::total_cmp);
    Query {
        triangles: out.len(),
        nodes_visited: cost.map(|c| c.nodes),
        leaves_visited: cost.map(|c| c.leaves),
        median_us: times[REPEATS / 2],
    }
}

#[derive(Serialize)]
struct Hdb {
    probe_mm: [f64; 3],
    edge_mm: f64,
    complete: Query,
    as_published: Option<Query>,
}

#[derive(Serialize)]
struct Printed<'a> {
    mesh: &'a str,
    kind: &'a str,
    triangles: usize,
    build_ms: f64,
    bytes: usize,
    bytes_per_triangle: f64,
    well_formed: bool,
    fault: Option<String>,
    statistics: Option<Statistics>,
    hdb: Hdb,
}

/// Runs `dorsum partition`.
///
/// # Errors
/// The mesh cannot be read or is refused, or an option does not go with the structure.
pub fn run(args: &PartitionArgs, json: bool) -> Result<Outcome, CliError> {
    let is_tree = TREES.contains(&args.kind);
    if args.threshold.is_some() && !is_tree {
        return Err(CliError::input(format_args!(
            "--threshold: {} has none; it goes with bsp, octree and hybrid",
            args.kind
        )));
    }
    if args.case.is_some() && args.kind != "bsp" {
        return Err(CliError::input(format_args!(
            "--case: {} knows no cases; it goes with bsp",
            args.kind
        )));
    }
    let surface = load_mesh(&args.mesh)?;
    let default = Options::default();
    let options = Options {
        threshold: args.threshold.map_or(default.threshold, |n| n as usize),
        case: args.case.unwrap_or(default.case),
    };
    let start = Instant::now();
    let built = built(args.kind, &surface, &options)?;
    let build_ms = start.elapsed().as_secs_f64() * 1e3;
    let partition = built.partition();
    let fault = partition.validate(&surface).err();
    let probe = args.probe.unwrap_or_else(|| default_probe(&surface));
    let edge_mm = args.hdb_edge.unwrap_or_else(|| hdb::edge_mm(&surface));
    let region = Aabb::cube(probe, edge_mm);
    let triangles = surface.triangles().len();
    let printed = Printed {
        mesh: &args.mesh,
        kind: args.kind,
        triangles,
        build_ms,
        bytes: partition.bytes(),
        bytes_per_triangle: partition.bytes() as f64 / triangles as f64,
        well_formed: fault.is_none(),
        fault,
        statistics: built.statistics(&surface),
        hdb: Hdb {
            probe_mm: probe.to_array(),
            edge_mm,
            complete: asked(|out| built.gather(&surface, &region, out)),
            as_published: is_tree.then(|| asked(|out| built.gather_as_published(&region, out))),
        },
    };
    if json {
        print_json(&printed)?;
    } else {
        print_table(&printed);
    }
    Ok(if printed.well_formed {
        Outcome::Done
    } else {
        Outcome::DoesNotHold
    })
}

/// The skin nearest the middle of the box's back.
fn default_probe(surface: &Surface) -> Vec3 {
    let bounds = surface.bounds();
    let middle = bounds.centre().with_z(bounds.max.z);
    (Brute.nearest(surface, middle, f64::INFINITY)).map_or(middle, |n| n.point)
}

fn print_table(p: &Printed<'_>) {
    let row = |name: &str, value: String| print(format_args!("{name:<20} {value}"));
    row("mesh", format!("{}, {} triangles", p.mesh, p.triangles));
    row("structure", structure(p));
    row("built in", format!("{:.2} ms", p.build_ms));
    let bytes = bytes_text(p.bytes);
    row(
        "memory",
        format!("{bytes}, {:.1} bytes per triangle", p.bytes_per_triangle),
    );
    if let Some(s) = &p.statistics {
        row("nodes", s.nodes.to_string());
        row(
            "leaves",
            format!("{}, of them {} empty", s.leaves, s.empty_leaves),
        );
        row("height", s.height.to_string());
        row(
            "w",
            format!("{:.2}, of a complete tree {:.2}", s.w, s.w_complete),
        );
        row(
            "entries",
            format!(
                "{}, {:.3} per triangle",
                s.entries,
                s.entries as f64 / s.triangles.max(1) as f64
            ),
        );
        row(
            "in a full leaf",
            format!("mean {:.1}, most {}", s.mean_occupancy, s.max_occupancy),
        );
        row(
            "overlap",
            format!("a leaf meets {:.1} others", s.mean_overlap),
        );
        row(
            "above threshold",
            format!("{} leaves", s.unsplittable_leaves),
        );
        if p.kind != "bsp" {
            row(
                "lost as published",
                format!("{} triangles, held here", s.lost_as_published),
            );
        }
        let most = s.occupancy.iter().map(|o| o.leaves).max().unwrap_or(0);
        for o in s.occupancy.iter().filter(|o| o.leaves > 0) {
            let range = if o.from == o.to {
                o.from.to_string()
            } else {
                format!("{} to {}", o.from, o.to)
            };
            let bar = "█".repeat((o.leaves * 30).div_ceil(most.max(1)));
            row(
                &format!("  holding {range}"),
                format!("{:>7} {bar}", o.leaves),
            );
        }
    }
    row(
        "well formed",
        p.fault.clone().map_or("yes".into(), |f| format!("no: {f}")),
    );
    let [x, y, z] = p.hdb.probe_mm;
    row(
        "box",
        format!("{:.2} mm about {x:.2}, {y:.2}, {z:.2} mm", p.hdb.edge_mm),
    );
    row("  gathered", query(&p.hdb.complete));
    if let Some(published) = &p.hdb.as_published {
        row("  as published", query(published));
    }
}

fn structure(p: &Printed<'_>) -> String {
    match &p.statistics {
        None => p.kind.to_owned(),
        Some(s) if p.kind == "bsp" => {
            format!("bsp, case {:?}, at most {} in a leaf", s.case, s.threshold)
        }
        Some(s) => format!("{}, at most {} in a leaf", p.kind, s.threshold),
    }
}

fn query(q: &Query) -> String {
    let visited = match (q.nodes_visited, q.leaves_visited) {
        (Some(nodes), Some(leaves)) => format!("; {nodes} nodes visited, {leaves} of them leaves"),
        _ => String::new(),
    };
    format!(
        "{} triangles in {:.2} µs{visited}",
        q.triangles, q.median_us
    )
}
