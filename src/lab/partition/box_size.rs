//! How large the haptic detecting box must be: punctures and cost by its size, the finger's speed and the rate of passes.

use super::passes::options;
use super::shared::{BSP, BVH, Kind, OCTREE, surface};
use crate::contact::published::Published;
use crate::contact::{ContactState, Stiffness, Touch, TouchScene, advance};
use crate::figure::{LinePlot, Mark, Scale, Series};
use crate::geom::Vec3;
use crate::lab::{
    Choice, Experiment, LabError, Report, Samples, Setup, Stopwatch, Table, Value, Verdict, Watch,
};
use crate::partition::bvh::Bvh;
use crate::partition::hdb::{EDGE_PART, Query};
use crate::partition::{Partition as _, Sides};
use crate::surface::Surface;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Share of strokes that go through the skin, and cost of a pass, for published passes and the production engine.
pub struct BoxSize;

/// Edges of the box over the longest edge of the surface's box. Published: 1/10 fails, 1/4 works, 1/2 is slow.
const PARTS: [(&str, f64); 6] = [
    ("1/16", 1.0 / 16.0),
    ("1/10", 0.1),
    ("1/8", 0.125),
    ("1/6", 1.0 / 6.0),
    ("1/4", EDGE_PART),
    ("1/2", 0.5),
];
/// Edges in mm.
const EDGES_MM: [f64; 3] = [1.0, 3.0, 10.0];
/// Speeds of the finger, m/s. Palpation stays below 0.3.
const SPEEDS_M_S: [f64; 6] = [0.05, 0.1, 0.2, 0.5, 1.0, 2.0];
/// As fast as a finger may be thrown about; the publication says "quickly".
const FAST_M_S: f64 = 1.0;
/// Passes per second: of a haptic device, and what 2008 reached with 8500 triangles (table B), about those of a box of a
/// quarter.
const RATES_HZ: [f64; 2] = [1000.0, 25.0];
/// Length of a stroke over the longest edge of the surface's box.
const STROKE_PART: f64 = 0.3;
/// Most passes of a stroke on the surface.
const MOST_PASSES: usize = 40;
/// Depth of the HIP below the skin over the longest edge: 5 mm on a back.
const DEPTH_PART: f64 = 0.01;

impl Experiment for BoxSize {
    fn name(&self) -> &'static str {
        "partition-hdb"
    }

    fn about(&self) -> &'static str {
        "Strokes that puncture the skin, and cost of a pass, by edge of the haptic detecting box, speed and rate"
    }

    fn takes(&self) -> &'static [Choice] {
        &[Choice::Mesh]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        let surface = surface(setup, &mut report)?;
        let longest_mm = surface.bounds().size().max_element();
        let bench = Bench::new(surface, if setup.quick { 4 } else { 16 });
        if bench.strokes.is_empty() {
            return Err(LabError::Input(
                "the mesh has no place seen from +z over which a finger could stroke".to_owned(),
            ));
        }
        report.set(
            "strokes",
            format_args!(
                "{} of at most {:.0} mm, {:.1} mm deep, at each speed",
                bench.strokes.len(),
                longest_mm * STROKE_PART,
                bench.depth_mm
            ),
        );
        let edges: Vec<(String, f64)> = EDGES_MM
            .into_iter()
            .map(|mm| (format!("{mm} mm"), mm / longest_mm))
            .chain(PARTS.map(|(name, part)| (name.to_owned(), part)))
            .filter(|(name, _)| !setup.quick || ["3 mm", "1/10", "1/4", "1/2"].contains(&&**name))
            .collect();
        let engines = [
            (BSP, Query::Published),
            (OCTREE, Query::Published),
            (OCTREE, Query::Complete),
        ];
        let mut found = Vec::new();
        let n = (engines.len() * edges.len() * RATES_HZ.len()) as f64;
        for (kind, query) in engines {
            for (name, part) in &edges {
                for rate_hz in RATES_HZ {
                    let share = found.len() as f64 / n;
                    watch.at(&format!("{}, box {name}, {rate_hz} Hz", kind.label), share)?;
                    let structure = kind.build(&bench.scene.surface, 1024, watch, share)?;
                    let options = options(kind, *part, query);
                    let published = Published::of(structure, &bench.scene.surface, &options);
                    let scene = TouchScene {
                        published: Some(Arc::new(published)),
                        ..bench.scene.clone()
                    };
                    found.push(Row {
                        engine: Some((kind, query)),
                        edge: name.clone(),
                        edge_mm: part * longest_mm,
                        rate_hz,
                        runs: bench.runs(&scene, rate_hz),
                    });
                }
            }
        }
        for rate_hz in RATES_HZ {
            watch.at("production", 1.0)?;
            found.push(Row {
                engine: None,
                edge: String::new(),
                edge_mm: 0.0,
                rate_hz,
                runs: bench.runs(&bench.scene, rate_hz),
            });
        }
        report.tables.push(table(&found));
        report.draw("cost", cost_plots(&found));
        report.draw("size", size_plots(&found));
        conclude(&mut report, &found, setup.mesh.is_none());
        Ok(report)
    }
}

/// A stroke over the map plane: from, and direction.
#[derive(Clone, Copy)]
struct Stroke {
    from: [f64; 2],
    along: [f64; 2],
}

struct Bench {
    /// The production engine's; frictionless, so that the finger never holds the proxy back.
    scene: TouchScene,
    strokes: Vec<Stroke>,
    depth_mm: f64,
    length_mm: f64,
    clock: Stopwatch,
}

/// All strokes at one speed.
struct Run {
    punctured: usize,
    strokes: usize,
    pass_us: Samples,
}

struct Row {
    /// None: the production engine.
    engine: Option<(Kind, Query)>,
    edge: String,
    edge_mm: f64,
    rate_hz: f64,
    /// By speed.
    runs: Vec<Run>,
}

impl Row {
    fn name(&self) -> String {
        match self.engine {
            None => "production".to_owned(),
            Some((kind, Query::Published)) => kind.label.to_owned(),
            Some((kind, Query::Complete)) => format!("{}, complete query", kind.label),
        }
    }

    fn punctured_percent(&self) -> f64 {
        self.punctured_up_to_percent(f64::INFINITY)
    }

    /// Share of the strokes at most so fast.
    fn punctured_up_to_percent(&self, most_m_s: f64) -> f64 {
        let runs = || {
            let speeds = SPEEDS_M_S.iter().zip(&self.runs);
            speeds.filter(|(v, _)| **v <= most_m_s).map(|(_, run)| run)
        };
        let punctured: usize = runs().map(|r| r.punctured).sum();
        let strokes: usize = runs().map(|r| r.strokes).sum();
        100.0 * punctured as f64 / strokes.max(1) as f64
    }

    fn pass_us(&self) -> f64 {
        let medians = self.runs.iter().map(|r| r.pass_us.median());
        let felt: Samples = medians.filter(|us| us.is_finite()).collect();
        felt.median()
    }

    /// The greatest speed up to which no stroke went through, m/s; `None` where already the least did.
    fn safe_m_s(&self) -> Option<f64> {
        let safe = self.runs.iter().take_while(|r| r.punctured == 0).count();
        safe.checked_sub(1).map(|i| SPEEDS_M_S[i])
    }
}

impl Bench {
    fn new(surface: Arc<Surface>, strokes: usize) -> Self {
        let search = Arc::new(Bvh::new(&surface));
        let size = surface.bounds().size();
        let longest_mm = size.max_element();
        let mut bench = Self {
            scene: TouchScene::new(surface, search, Stiffness::Uniform(1.0)),
            strokes: Vec::new(),
            depth_mm: longest_mm * DEPTH_PART,
            length_mm: longest_mm * STROKE_PART,
            clock: Stopwatch::new(),
        };
        // Places and directions by the golden ratio and its square: evenly over the map plane and all round.
        let bounds = bench.scene.surface.bounds();
        let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
        let fraction = |x: f64| x - libm::floor(x);
        for i in 1..=40 * strokes {
            if bench.strokes.len() == strokes {
                break;
            }
            let i = i as f64;
            let at = [fraction(i * 0.754_877_666), fraction(i * 0.569_840_291)];
            let angle = TAU * fraction(i * golden);
            let stroke = Stroke {
                from: [bounds.min.x + size.x * at[0], bounds.min.y + size.y * at[1]],
                along: [libm::cos(angle), libm::sin(angle)],
            };
            if bench.covers(&stroke) {
                bench.strokes.push(stroke);
            }
        }
        bench
    }

    /// Whether there is skin under the whole stroke and some way round it, so that nothing slides off a rim.
    fn covers(&self, stroke: &Stroke) -> bool {
        let [dx, dy] = stroke.along;
        let aside_mm = 3.0 * self.depth_mm;
        (0..=20).all(|i| {
            let s = (self.length_mm + 2.0 * aside_mm) * f64::from(i) / 20.0 - aside_mm;
            [-aside_mm, 0.0, aside_mm].into_iter().all(|side| {
                let x = stroke.from[0] + dx * s - dy * side;
                let y = stroke.from[1] + dy * s + dx * side;
                self.height_mm(x, y).is_some()
            })
        })
    }

    /// The skin seen from +z.
    fn height_mm(&self, x: f64, y: f64) -> Option<f64> {
        let b = self.scene.surface.bounds();
        let (from, to) = (
            Vec3::new(x, y, b.max.z + 1.0),
            Vec3::new(x, y, b.min.z - 1.0),
        );
        let hit = (self.scene.search).sweep(&self.scene.surface, from, to, Sides::Front);
        hit.map(|hit| hit.point.z)
    }

    /// Where the HIP is after a way of `s` mm on a stroke: it comes down to its depth, then follows the skin.
    fn hip_mm(&self, stroke: &Stroke, s: f64) -> Option<(Vec3, f64)> {
        let down = 2.0 * self.depth_mm;
        let on = (s - down).max(0.0);
        let x = stroke.from[0] + stroke.along[0] * on;
        let y = stroke.from[1] + stroke.along[1] * on;
        let depth = (s - self.depth_mm).min(self.depth_mm);
        let height = self.height_mm(x, y)?;
        Some((Vec3::new(x, y, height - depth), depth))
    }

    fn runs(&self, scene: &TouchScene, rate_hz: f64) -> Vec<Run> {
        SPEEDS_M_S
            .iter()
            .map(|speed| self.run(scene, 1000.0 * speed / rate_hz))
            .collect()
    }

    /// All strokes with `step_mm` between passes. A stroke is punctured once the engine says that the finger is free while
    /// it is deeper than a fifth of the depth wanted.
    fn run(&self, scene: &TouchScene, step_mm: f64) -> Run {
        let mut run = Run {
            punctured: 0,
            strokes: self.strokes.len(),
            pass_us: Samples::default(),
        };
        let end_mm = (2.0 * self.depth_mm + self.length_mm)
            .min(2.0 * self.depth_mm + step_mm * MOST_PASSES as f64);
        for stroke in &self.strokes {
            // A pass above the skin comes first, at least half a step up.
            let mut s = self.depth_mm - step_mm.max(self.depth_mm * 0.2) * 0.5;
            let Some((above, _)) = self.hip_mm(stroke, s) else {
                continue;
            };
            let mut state = ContactState {
                proxy_mm: above,
                ..ContactState::default()
            };
            while s < end_mm {
                s = (s + step_mm).min(end_mm);
                let Some((hip, depth)) = self.hip_mm(stroke, s) else {
                    break;
                };
                let (contact, us) = self.clock.time(|| advance(scene, &mut state, hip));
                if contact.touch == Touch::Free && depth > 0.2 * self.depth_mm {
                    run.punctured += 1;
                    break;
                }
                if contact.touch != Touch::Free {
                    run.pass_us.push(us);
                }
            }
        }
        run
    }
}

fn table(found: &[Row]) -> Table {
    let speeds = SPEEDS_M_S.map(|v| format!("{v} m/s (%)"));
    let mut columns = vec![
        "engine",
        "box edge",
        "edge (mm)",
        "rate (1/s)",
        "pass (µs)",
        "pass p99 (µs)",
        "safe by geometry (m/s)",
        "no puncture up to (m/s)",
    ];
    columns.extend(speeds.iter().map(String::as_str));
    let mut table = Table::new(
        "punctures",
        "Strokes that go through the skin, by speed; safe by geometry: half the edge in one pass",
        &columns,
    );
    for row in found {
        let edge_mm = row.engine.map(|_| row.edge_mm);
        let worst = row.runs.iter().map(|r| r.pass_us.quantile(0.99));
        let mut cells: Vec<Value> = vec![
            row.name().into(),
            row.edge.as_str().into(),
            edge_mm.into(),
            row.rate_hz.into(),
            row.pass_us().into(),
            worst.filter(|us| us.is_finite()).fold(0.0, f64::max).into(),
            edge_mm.map(|mm| mm / 2.0 * row.rate_hz / 1000.0).into(),
            row.safe_m_s().into(),
        ];
        cells.extend(
            row.runs
                .iter()
                .map(|r| Value::from(100.0 * r.punctured as f64 / r.strokes.max(1) as f64)),
        );
        table.push(cells);
    }
    table
}

/// One series for each engine at one rate.
fn series(found: &[Row], rate_hz: f64, point: &dyn Fn(&Row) -> [f64; 2]) -> Vec<Series> {
    let mut all: Vec<Series> = Vec::new();
    for row in found.iter().filter(|r| r.rate_hz == rate_hz) {
        let name = row.name();
        if all.last().is_none_or(|s| s.name != name) {
            let (colour, mark) = match row.engine {
                None => (BVH.colour, Mark::Points),
                Some((kind, Query::Published)) => (kind.colour, Mark::Joined),
                Some((kind, Query::Complete)) => (kind.colour, Mark::Dashed),
            };
            all.push(Series {
                name,
                colour,
                mark,
                points: Vec::new(),
            });
        }
        if let Some(series) = all.last_mut() {
            series.points.push(point(row));
        }
    }
    all
}

fn cost_plots(found: &[Row]) -> Vec<LinePlot> {
    let plot = |rate_hz: f64| LinePlot {
        title: format!(
            "Punctures against cost, all speeds, {rate_hz} passes per second; each point a box size"
        ),
        x_label: "cost of a pass, median (µs)".to_owned(),
        y_label: "strokes punctured (%)".to_owned(),
        x_scale: Scale::Logarithmic,
        series: series(found, rate_hz, &|r| [r.pass_us(), r.punctured_percent()]),
        ..LinePlot::default()
    };
    RATES_HZ.map(plot).to_vec()
}

fn size_plots(found: &[Row]) -> Vec<LinePlot> {
    let plot = |rate_hz: f64| LinePlot {
        title: format!("Punctures by size of the box, all speeds, {rate_hz} passes per second"),
        x_label: "edge of the box (mm)".to_owned(),
        y_label: "strokes punctured (%)".to_owned(),
        x_scale: Scale::Logarithmic,
        series: series(found, rate_hz, &|r| [r.edge_mm, r.punctured_percent()])
            .into_iter()
            .filter(|s| s.name != "production")
            .collect(),
        ..LinePlot::default()
    };
    RATES_HZ.map(plot).to_vec()
}

fn conclude(report: &mut Report, found: &[Row], is_back: bool) {
    let production: Vec<&Row> = found.iter().filter(|r| r.engine.is_none()).collect();
    let count = |rows: &[&Row]| -> (usize, usize) {
        let runs = || rows.iter().flat_map(|r| &r.runs);
        (
            runs().map(|r| r.punctured).sum(),
            runs().map(|r| r.strokes).sum(),
        )
    };
    let (punctured, strokes) = count(&production);
    report.verdicts.push(Verdict {
        // Through a hole or round the rim of a mesh of one's own the finger may well go.
        required: is_back,
        ..Verdict::must(
            "the production engine never lets the finger through",
            format_args!("{punctured} of {strokes} strokes"),
            "0",
            punctured == 0,
        )
    });
    let slow = RATES_HZ[1];
    let of = |edge: &str, rate_hz: f64| {
        found.iter().find(|r| {
            r.edge == edge && r.rate_hz == rate_hz && r.engine == Some((OCTREE, Query::Published))
        })
    };
    if let (Some(tenth), Some(quarter)) = (of("1/10", slow), of("1/4", slow)) {
        let [tenth, quarter] = [tenth, quarter].map(|r| r.punctured_up_to_percent(FAST_M_S));
        report.verdicts.push(Verdict::told(
            format!(
                "at {slow} passes per second a finger of up to {FAST_M_S} m/s punctures with a box of 1/10 and not with \
                 1/4 (3.3.3, octree)"
            ),
            format_args!("{tenth:.0} % and {quarter:.0} % of strokes"),
            "some and none",
            tenth > 0.0 && quarter == 0.0,
        ));
    }
    for query in [Query::Published, Query::Complete] {
        let of_query = found
            .iter()
            .filter(|r| r.engine.is_some_and(|(_, q)| q == query));
        let (mut punctured, mut strokes) = (0, 0);
        for row in of_query {
            let safe_m_s = row.edge_mm / 2.0 * row.rate_hz / 1000.0;
            let speeds = SPEEDS_M_S.iter().zip(&row.runs);
            for (_, run) in speeds.filter(|(v, _)| **v < 0.99 * safe_m_s) {
                punctured += run.punctured;
                strokes += run.strokes;
            }
        }
        let name = match query {
            Query::Published => "published",
            Query::Complete => "complete",
        };
        report.verdicts.push(Verdict::told(
            format!(
                "{name} query: moving less than half an edge in a pass, no finger goes through"
            ),
            format_args!("{punctured} of {strokes} strokes"),
            "0",
            punctured == 0,
        ));
    }
    report.note(
        "The box stands about the proxy of the last pass. What the finger crosses within half an edge of it is asked, if the \
         query is complete; the published one also lets the finger through where a triangle juts out of its leaf, and finds \
         more than it must where leaves are larger than the box. So the size that is needed is a matter of speed over rate: \
         at 1000 passes per second boxes far smaller than the published quarter would do, at the 25 of 2008 the quarter \
         holds up to about 1.5 m/s.",
    );
}
