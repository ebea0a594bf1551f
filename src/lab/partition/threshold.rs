//! How large a leaf should be: what trees hold and what a query costs, by threshold.

use super::shared::{Kind, TREES, places, surface};
use crate::figure::{LinePlot, Mark, Scale, Series};
use crate::geom::{Aabb, Vec3};
use crate::lab::{
    Choice, Experiment, LabError, Report, Samples, Setup, Stopwatch, Table, Verdict, Watch,
};
use crate::partition::Structure;
use crate::partition::hdb;
use crate::partition::tree::{Case, Statistics};
use crate::surface::Surface;

/// Trees and their published query by the most triangles a leaf may hold.
pub struct Threshold;

const THRESHOLDS: [usize; 8] = [64, 128, 256, 512, 1024, 2048, 4096, 8192];
const QUICK_THRESHOLDS: [usize; 3] = [64, 1024, 8192];
/// The published choice, found best in 3.3.1.
const PUBLISHED: usize = 1024;

impl Experiment for Threshold {
    fn name(&self) -> &'static str {
        "partition-threshold"
    }

    fn about(&self) -> &'static str {
        "Most triangles in a leaf, 64 to 8192: what trees hold, how long they take to build and to ask"
    }

    fn takes(&self) -> &'static [Choice] {
        &[Choice::Mesh]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        let surface = surface(setup, &mut report)?;
        let effort = Effort {
            builds: if setup.quick { 1 } else { 3 },
            rounds: if setup.quick { 2 } else { 7 },
            edge_mm: hdb::edge_mm(&surface),
            boxes: places(&surface, if setup.quick { 30 } else { 100 }),
        };
        let thresholds: &[usize] = if setup.quick {
            &QUICK_THRESHOLDS
        } else {
            &THRESHOLDS
        };
        report.set(
            "box",
            format_args!(
                "{:.1} mm, a quarter of the longest edge; {} places, {} rounds",
                effort.edge_mm,
                effort.boxes.len(),
                effort.rounds
            ),
        );
        let mut found = Vec::new();
        let n = (thresholds.len() * TREES.len()) as f64;
        for kind in TREES {
            for &threshold in thresholds {
                let share = found.len() as f64 / n;
                watch.at(&format!("{} with leaves of {threshold}", kind.label), share)?;
                found.push(measure(kind, &surface, threshold, &effort, watch, share)?);
            }
        }
        report.tables.push(trees(&found));
        report.tables.push(queries(&found));
        report.draw("threshold", plots(&found));
        conclude(&mut report, &surface, &found);
        Ok(report)
    }
}

struct Effort {
    builds: usize,
    rounds: usize,
    edge_mm: f64,
    boxes: Vec<Vec3>,
}

/// One tree: what it holds and what its queries cost.
struct Row {
    kind: Kind,
    threshold: usize,
    build_ms: f64,
    statistics: Statistics,
    jutting: Option<Jutting>,
    published: Query,
    complete: Query,
    malformed: Option<String>,
}

/// Triangles that their leaf's cell does not hold wholly.
struct Jutting {
    triangles: usize,
    farthest_mm: f64,
}

/// Means over the boxes, and times over boxes and rounds.
struct Query {
    nodes: f64,
    triangles: f64,
    times_us: Samples,
}

fn measure(
    kind: Kind,
    surface: &Surface,
    threshold: usize,
    effort: &Effort,
    watch: &mut Watch<'_>,
    share: f64,
) -> Result<Row, LabError> {
    let clock = Stopwatch::new();
    let (first, first_us) = clock.time(|| kind.build(surface, threshold, watch, share));
    let built = first?;
    let mut builds_us = Samples::from_iter([first_us]);
    for _ in 1..effort.builds {
        let (again, us) = clock.time(|| kind.build(surface, threshold, watch, share));
        again?;
        builds_us.push(us);
    }
    let statistics = built
        .statistics(surface)
        .ok_or_else(|| LabError::Input(format!("{} is no tree", kind.label)))?;
    let query = |ask: &dyn Fn(&Aabb, &mut Vec<u32>) -> Option<hdb::Gathered>| {
        let mut out = Vec::with_capacity(surface.triangles().len());
        let (mut nodes, mut triangles) = (0, 0);
        let mut times_us = Samples::default();
        // The first round warms up.
        for round in 0..=effort.rounds {
            for &place in &effort.boxes {
                let region = Aabb::cube(place, effort.edge_mm);
                out.clear();
                let (cost, us) = clock.time(|| ask(&region, &mut out));
                if round == 0 {
                    nodes += cost.map_or(0, |c| c.nodes);
                    triangles += out.len();
                } else {
                    times_us.push(us);
                }
            }
        }
        let mean = |sum: usize| sum as f64 / effort.boxes.len() as f64;
        Query {
            nodes: mean(nodes),
            triangles: mean(triangles),
            times_us,
        }
    };
    Ok(Row {
        kind,
        threshold,
        build_ms: builds_us.median() / 1e3,
        jutting: jutting(kind, &built, surface),
        published: query(&|region, out| built.gather_as_published(region, out)),
        complete: query(&|region, out| built.gather(surface, region, out)),
        malformed: built.partition().validate(surface).err(),
        statistics,
    })
}

fn jutting(kind: Kind, built: &Structure, surface: &Surface) -> Option<Jutting> {
    // In the other cases a triangle lies wholly in its leaves together.
    let tree = built.tree().filter(|_| kind.case == Case::C)?;
    let mut found = Jutting {
        triangles: 0,
        farthest_mm: 0.0,
    };
    for leaf in tree.nodes() {
        for &t in tree.held(leaf) {
            let b = surface.triangle(t).aabb();
            let out_mm = (leaf.cell.min - b.min)
                .max(b.max - leaf.cell.max)
                .max_element();
            found.triangles += usize::from(out_mm > 0.0);
            found.farthest_mm = found.farthest_mm.max(out_mm);
        }
    }
    Some(found)
}

fn trees(found: &[Row]) -> Table {
    let mut table = Table::new(
        "trees",
        "What the trees hold",
        &[
            "structure",
            "threshold",
            "nodes",
            "leaves",
            "empty",
            "height",
            "largest leaf",
            "above threshold",
            "entries per triangle",
            "jutting out",
            "farthest (mm)",
            "memory (B/triangle)",
            "build (ms)",
        ],
    );
    for row in found {
        let s = &row.statistics;
        let per_triangle = |n: usize| n as f64 / s.triangles.max(1) as f64;
        table.push([
            row.kind.label.into(),
            row.threshold.into(),
            s.nodes.into(),
            s.leaves.into(),
            s.empty_leaves.into(),
            s.height.into(),
            s.max_occupancy.into(),
            s.unsplittable_leaves.into(),
            per_triangle(s.entries).into(),
            row.jutting.as_ref().map(|j| j.triangles).into(),
            row.jutting.as_ref().map(|j| j.farthest_mm).into(),
            per_triangle(s.bytes).into(),
            row.build_ms.into(),
        ]);
    }
    table
}

fn queries(found: &[Row]) -> Table {
    let mut table = Table::new(
        "queries",
        "What a box query costs: published (all of every leaf found), and complete (only what overlaps the box)",
        &[
            "structure",
            "threshold",
            "published nodes",
            "published gathered",
            "published median (µs)",
            "published p99 (µs)",
            "complete nodes",
            "complete gathered",
            "complete median (µs)",
            "complete p99 (µs)",
            "gathered / needed",
        ],
    );
    for row in found {
        let (p, c) = (&row.published, &row.complete);
        table.push([
            row.kind.label.into(),
            row.threshold.into(),
            p.nodes.into(),
            p.triangles.into(),
            p.times_us.median().into(),
            p.times_us.quantile(0.99).into(),
            c.nodes.into(),
            c.triangles.into(),
            c.times_us.median().into(),
            c.times_us.quantile(0.99).into(),
            (p.triangles / c.triangles).into(),
        ]);
    }
    table
}

fn plots(found: &[Row]) -> Vec<LinePlot> {
    let series = |value: &dyn Fn(&Row) -> f64| {
        let of = |kind: &Kind| Series {
            name: kind.label.to_owned(),
            colour: kind.colour,
            mark: Mark::Joined,
            points: found
                .iter()
                .filter(|r| r.kind == *kind)
                .map(|r| [r.threshold as f64, value(r)])
                .collect(),
        };
        TREES.iter().map(of).collect()
    };
    let plot = |title: &str, y_label: &str, value: &dyn Fn(&Row) -> f64| LinePlot {
        title: title.to_owned(),
        x_label: "most triangles in a leaf".to_owned(),
        y_label: y_label.to_owned(),
        x_scale: Scale::Logarithmic,
        y_scale: Scale::Logarithmic,
        series: series(value),
    };
    vec![
        plot(
            "Triangles gathered by the published query",
            "triangles (count)",
            &|r| r.published.triangles,
        ),
        plot("Published query, median", "time (µs)", &|r| {
            r.published.times_us.median()
        }),
        plot("Complete query, median", "time (µs)", &|r| {
            r.complete.times_us.median()
        }),
        plot("Build", "time (ms)", &|r| r.build_ms),
    ]
}

fn conclude(report: &mut Report, surface: &Surface, found: &[Row]) {
    let faults: Vec<_> = found.iter().filter_map(|r| r.malformed.as_ref()).collect();
    report.verdicts.push(Verdict::must(
        "every tree is well formed",
        faults
            .first()
            .map_or("no fault".to_owned(), |f| (*f).clone()),
        "no fault",
        faults.is_empty(),
    ));
    let needed: Vec<f64> = found.iter().map(|r| r.complete.triangles).collect();
    report.verdicts.push(Verdict::must(
        "the complete query gathers the same, whatever the tree and the threshold",
        format_args!("{:.2} to {:.2} triangles", least(&needed), most(&needed)),
        "the same",
        least(&needed) == most(&needed),
    ));
    for kind in TREES
        .iter()
        .filter(|k| k.label != "bsp a" && k.label != "bsp b")
    {
        let best = found.iter().filter(|r| r.kind == *kind).min_by(|a, b| {
            a.published
                .times_us
                .median()
                .total_cmp(&b.published.times_us.median())
        });
        if let Some(best) = best {
            report.verdicts.push(Verdict::told(
                format!("{}: {PUBLISHED} is the best threshold (3.3.1)", kind.label),
                format_args!(
                    "the published query is quickest at {}, {:.1} µs, and gathers {:.0} triangles",
                    best.threshold,
                    best.published.times_us.median(),
                    best.published.triangles
                ),
                PUBLISHED,
                best.threshold == PUBLISHED,
            ));
        }
    }
    let n = surface.triangles().len();
    if n <= THRESHOLDS[THRESHOLDS.len() - 1] {
        report.note(format!(
            "With {n} triangles a tree whose leaves may hold as many is one leaf."
        ));
    }
    report.note(
        "Gathering is only the first part of a haptic pass: each triangle gathered is then asked for a collision, which costs \
         more than gathering it. Smaller leaves gather fewer.",
    );
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

fn most(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}
