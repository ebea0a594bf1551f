//! Tables 3.1, 3.2 and appendix B: what a haptic pass costs by the number of triangles it is given.

mod plots;
mod tables;

use super::shared::{BRUTE, BSP, HYBRID, Kind, OCTREE, back_of, places, surface};
use crate::contact::published::{self, Options, Published};
use crate::contact::{self, ContactState, Friction, Stiffness, Touch, TouchScene};
use crate::geom::{Vec3, any_tangent};
use crate::lab::{Choice, Experiment, LabError, Report, Samples, Setup, Stopwatch, Watch};
use crate::partition::bvh::Bvh;
use crate::partition::hdb::{EDGE_PART, Query};
use crate::partition::tree;
use crate::surface::{RIM, Surface};
use std::hint::black_box;
use std::sync::Arc;

/// A haptic pass as published, part by part, and the production engine's, beside the figures of 2008.
pub struct Passes;

/// Models of table 3.1, triangles.
const MODELS: [usize; 5] = [2915, 6261, 8163, 20_389, 41_582];
const QUICK_MODELS: [usize; 2] = [2915, 20_389];
/// Edges of the box over the longest edge of the surface's box, from one that meets a leaf to one that holds all.
const PARTS: [f64; 9] = [
    1.0 / 64.0,
    1.0 / 16.0,
    0.125,
    EDGE_PART,
    0.375,
    0.5,
    0.625,
    0.75,
    1.0,
];
const QUICK_PARTS: [f64; 4] = [1.0 / 64.0, EDGE_PART, 0.5, 1.0];
/// The trees in print, and the one proposed there.
const PUBLISHED: [Kind; 3] = [BSP, OCTREE, HYBRID];
/// Advance of the finger in one pass, mm: 0.25 m/s at 1 kHz.
const STEP_MM: f64 = 0.25;
/// Ticks of the production engine that are timed together: one is too short for the clock.
const BATCH: usize = 16;

impl Experiment for Passes {
    fn name(&self) -> &'static str {
        "partition-passes"
    }

    fn about(&self) -> &'static str {
        "Cost of a haptic pass by number of triangles (tables 3.1, 3.2, appendix B), ours and production beside 2008"
    }

    fn takes(&self) -> &'static [Choice] {
        &[Choice::Mesh, Choice::Triangles]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        let effort = Effort {
            clock: Stopwatch::new(),
            places: if setup.quick { 8 } else { 24 },
            steps: if setup.quick { 3 } else { 5 },
        };
        let bench = Bench::new(surface(setup, &mut report)?, &effort);
        report.set(
            "places",
            format_args!(
                "{} over the surface, {} passes at each, {STEP_MM} mm apart",
                effort.places, effort.steps
            ),
        );
        report.set(
            "touch",
            format_args!("{:.2} mm deep, friction 0.46 / 0.44", bench.depth_mm),
        );
        let parts: &[f64] = if setup.quick { &QUICK_PARTS } else { &PARTS };
        let cells = sweep_boxes(&bench, parts, &mut watch.part(0.0, 0.7))?;
        let production = [false, true].map(|touched| bench.production(touched));
        let models = models(setup, &effort, &mut watch.part(0.7, 1.0))?;

        report.tables.push(tables::by_box(&cells, &production));
        report.tables.push(tables::by_model(&models));
        report
            .tables
            .push(tables::beside_print(&cells, &production));
        report.tables.push(tables::octree_against_bsp(&cells));
        report.draw("passes", plots::by_haptic_triangles(&cells, &production));
        report.draw("models", vec![plots::by_model(&models)]);
        let is_back = setup.mesh.is_none();
        tables::conclude(&mut report, &cells, &production, &models, is_back);
        Ok(report)
    }
}

struct Effort {
    clock: Stopwatch,
    places: usize,
    steps: usize,
}

/// A finger about to move on.
#[derive(Clone, Copy)]
struct Start {
    /// Free just above the surface, and on it.
    states: [ContactState; 2],
    /// Where the HIP then is, mm.
    hips_mm: [Vec3; 2],
    /// Its way from pass to pass, mm.
    step_mm: Vec3,
}

/// A surface, and fingers over and on it.
struct Bench<'a> {
    scene: TouchScene,
    starts: Vec<Start>,
    depth_mm: f64,
    effort: &'a Effort,
}

/// What one structure costs with one box, untouched or touched. Triangles as the median, times over all passes.
struct Cell {
    kind: Kind,
    touched: bool,
    part: Option<f64>,
    triangles: f64,
    gather_us: Samples,
    collide_us: Samples,
    force_us: Samples,
    pass_us: Samples,
    /// Passes in which the finger felt the surface.
    felt: usize,
}

impl Cell {
    fn parts_us(&self) -> f64 {
        self.gather_us.median() + self.collide_us.median() + self.force_us.median()
    }
}

/// What the production engine costs.
struct Production {
    touched: bool,
    tick_us: Samples,
    felt: usize,
    ticks: usize,
}

impl<'a> Bench<'a> {
    fn new(surface: Arc<Surface>, effort: &'a Effort) -> Self {
        let longest_mm = surface.bounds().size().max_element();
        let depth_mm = 0.01 * longest_mm;
        let search = Arc::new(Bvh::new(&surface));
        let scene = TouchScene {
            friction: Some(Friction {
                static_coefficient: 0.46,
                dynamic_coefficient: 0.44,
                skin_looseness: 1.0,
            }),
            ..TouchScene::new(surface, search, Stiffness::Uniform(1.0))
        };
        let starts = inner_places(&scene, effort.places, 3.0 * depth_mm)
            .into_iter()
            .map(|place| start(&scene, place, depth_mm))
            .collect();
        Self {
            scene,
            starts,
            depth_mm,
            effort,
        }
    }

    /// One structure with one box, in one condition.
    fn published(&self, kind: Kind, published: &Published, touched: bool) -> Cell {
        let clock = &self.effort.clock;
        let mut cell = Cell {
            kind,
            touched,
            part: (kind.name != "brute").then_some(published.options().hdb_part),
            triangles: 0.0,
            gather_us: Samples::default(),
            collide_us: Samples::default(),
            force_us: Samples::default(),
            pass_us: Samples::default(),
            felt: 0,
        };
        let mut gathered = Samples::default();
        let mut found = Vec::with_capacity(self.scene.surface.triangles().len());
        for start in &self.starts {
            let mut state = start.states[usize::from(touched)];
            let mut hip = start.hips_mm[usize::from(touched)];
            // The first pass warms up.
            for step in 0..=self.effort.steps {
                hip += start.step_mm;
                found.clear();
                let region = published.region(state.proxy_mm);
                let query = published.options().query;
                let all = published.structure();
                // In the order of the leaves, as published: sorting takes longer than finding.
                let (_, gather_us) =
                    clock.time(|| all.each(&self.scene.surface, &region, query, |t| found.push(t)));
                let (stand, collide_us) = clock
                    .time(|| published::collide(&self.scene, black_box(&found[..]), &state, hip));
                let (_, force_us) = clock
                    .time(|| black_box(published::force(&self.scene, stand.as_ref(), hip.into())));
                let ((contact, _), pass_us) =
                    clock.time(|| published::pass(&self.scene, published, &mut state, hip.into()));
                if step > 0 {
                    gathered.push(found.len() as f64);
                    cell.gather_us.push(gather_us);
                    cell.collide_us.push(collide_us);
                    cell.force_us.push(force_us);
                    cell.pass_us.push(pass_us);
                    cell.felt += usize::from(contact.touch != Touch::Free);
                }
            }
        }
        cell.triangles = gathered.median();
        cell
    }

    /// The production engine on the same ways, which go on for longer.
    fn production(&self, touched: bool) -> Production {
        let mut found = Production {
            touched,
            tick_us: Samples::default(),
            felt: 0,
            ticks: 0,
        };
        for start in &self.starts {
            let mut state = start.states[usize::from(touched)];
            let mut hip = start.hips_mm[usize::from(touched)];
            for round in 0..=self.effort.steps {
                let mut felt = 0;
                let (_, batch_us) = self.effort.clock.time(|| {
                    for _ in 0..BATCH {
                        hip += start.step_mm / BATCH as f64;
                        let contact = contact::advance(&self.scene, &mut state, black_box(hip));
                        felt += usize::from(black_box(contact).touch != Touch::Free);
                    }
                });
                if round > 0 {
                    found.tick_us.push(batch_us / BATCH as f64);
                    found.felt += felt;
                    found.ticks += BATCH;
                }
            }
        }
        found
    }
}

/// Places of the surface no nearer to a rim than `reach_mm`: beside one a finger may slide off. Where there is none, any.
fn inner_places(scene: &TouchScene, n: usize, reach_mm: f64) -> Vec<Vec3> {
    let topology = scene.surface.topology();
    let is_inner = |place: &Vec3| {
        let mut rim = false;
        (scene.search).around(*place, reach_mm, |t| {
            rim |= topology.across(t).contains(&RIM)
        });
        !rim
    };
    let candidates = places(&scene.surface, 4 * n);
    let inner: Vec<Vec3> = candidates
        .iter()
        .copied()
        .filter(is_inner)
        .take(n)
        .collect();
    if inner.is_empty() {
        candidates.into_iter().take(n).collect()
    } else {
        inner
    }
}

/// A finger a little above a place of the surface, and one pressed in there by the production engine.
fn start(scene: &TouchScene, place: Vec3, depth_mm: f64) -> Start {
    let nearest =
        crate::partition::Partition::nearest(&*scene.search, &scene.surface, place, f64::INFINITY);
    let triangle = nearest.map_or(0, |n| n.triangle);
    let normal = scene.surface.triangle(triangle).normal();
    let above = place + normal * (0.5 * depth_mm);
    let free = ContactState {
        proxy_mm: above,
        ..ContactState::default()
    };
    let mut pressed = free;
    let below = place - normal * depth_mm;
    contact::advance(scene, &mut pressed, below);
    Start {
        states: [free, pressed],
        hips_mm: [above, below],
        step_mm: any_tangent(normal) * STEP_MM,
    }
}

fn sweep_boxes(
    bench: &Bench<'_>,
    parts: &[f64],
    watch: &mut Watch<'_>,
) -> Result<Vec<Cell>, LabError> {
    let mut cells = Vec::new();
    let surface = &bench.scene.surface;
    let threshold = tree::Options::default().threshold;
    let n = (PUBLISHED.len() * parts.len() + 1) as f64;
    for kind in PUBLISHED.into_iter().chain([BRUTE]) {
        // Without a structure every triangle is asked, whatever the box.
        let parts = if kind == BRUTE { &[EDGE_PART] } else { parts };
        for &part in parts {
            let share = cells.len() as f64 / 2.0 / n;
            watch.at(&format!("passes by {}", kind.label), share)?;
            let structure = kind.build(surface, threshold, watch, share)?;
            let published =
                Published::of(structure, surface, &options(kind, part, Query::Published));
            cells.extend([false, true].map(|touched| bench.published(kind, &published, touched)));
        }
    }
    Ok(cells)
}

/// The options of a pass by a structure of this kind.
pub(super) fn options(kind: Kind, hdb_part: f64, query: Query) -> Options {
    Options {
        partition: kind.name,
        tree: tree::Options {
            case: kind.case,
            ..tree::Options::default()
        },
        hdb_part,
        query,
    }
}

/// All structures with the published box, touched, on one size of the built-in back.
struct Model {
    triangles: usize,
    cells: Vec<Cell>,
    production: Production,
}

fn models(setup: &Setup, effort: &Effort, watch: &mut Watch<'_>) -> Result<Vec<Model>, LabError> {
    let sizes: &[usize] = match (setup.triangles.is_empty(), setup.quick) {
        (false, _) => &setup.triangles,
        (true, true) => &QUICK_MODELS,
        (true, false) => &MODELS,
    };
    let mut models = Vec::new();
    for (i, &size) in sizes.iter().enumerate() {
        let share = i as f64 / sizes.len() as f64;
        watch.at(&format!("a back of {size} triangles"), share)?;
        let surface = back_of(size)?;
        let bench = Bench::new(surface.clone(), effort);
        let mut cells = Vec::new();
        for kind in [BRUTE, BSP, OCTREE, HYBRID] {
            let threshold = tree::Options::default().threshold;
            let structure = kind.build(&surface, threshold, watch, share)?;
            let options = options(kind, EDGE_PART, Query::Published);
            let published = Published::of(structure, &surface, &options);
            cells.push(bench.published(kind, &published, true));
        }
        models.push(Model {
            triangles: surface.triangles().len(),
            cells,
            production: bench.production(true),
        });
    }
    models.sort_by_key(|m| m.triangles);
    Ok(models)
}
