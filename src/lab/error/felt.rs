//! The force that is felt, at several rates, engines and meshes, beside the production engine at a very high rate.

use crate::contact::TouchScene;
use crate::contact::published::{Options, Published};
use crate::device::Device as _;
use crate::device::scripted::{Script, Scripted, Trajectory};
use crate::geom::Vec3;
use crate::lab::{LabError, Samples, Stopwatch, Watch};
use crate::partition::hdb::Query;
use crate::partition::{Partition as _, Sides};
use crate::scenario::{Scenario, Scene, SurfaceChoice, Use, build};
use crate::servo::{Limits, MAX_FINGERS, Rig, TickInput, tick};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Rate of the truth and at which forces are compared, Hz.
const FINE_HZ: f64 = 10_000.0;
/// Depth of the motion, mm.
const DEPTH_MM: f64 = 6.0;
/// Below this force a share of it means nothing, N.
const LEAST_N: f64 = 0.2;

/// One way to feel the scene.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    pub family: &'static str,
    pub setting: &'static str,
    pub rate_hz: f64,
    pub engine: Engine,
}

/// What is asked for the contact.
#[derive(Clone, Copy, Debug)]
pub enum Engine {
    /// The scene's mesh by the production engine.
    Production,
    /// The built-in back with other triangles.
    Mesh(usize),
    /// The published pass.
    Published {
        partition: &'static str,
        threshold: usize,
        hdb_part: f64,
        query: Query,
    },
}

/// Kinds with their colours in plots.
pub const FAMILIES: [(&str, [u8; 3]); 4] = [
    ("production", [214, 122, 0]),
    ("other mesh", [0, 140, 104]),
    ("octree", [136, 72, 168]),
    ("bsp", [120, 124, 130]),
];

/// Every way; fewer for a quick look.
pub fn ways(quick: bool) -> Vec<Way> {
    let production = |rate_hz, setting| Way {
        family: "production",
        setting,
        rate_hz,
        engine: Engine::Production,
    };
    let mesh = |triangles, setting| Way {
        family: "other mesh",
        setting,
        rate_hz: 1000.0,
        engine: Engine::Mesh(triangles),
    };
    let published = |partition, threshold, hdb_part, query, setting| Way {
        family: partition,
        setting,
        rate_hz: 1000.0,
        engine: Engine::Published {
            partition,
            threshold,
            hdb_part,
            query,
        },
    };
    let mut ways = vec![
        production(100.0, "100 Hz"),
        production(250.0, "250 Hz"),
        production(500.0, "500 Hz"),
        production(1000.0, "1 kHz"),
        published(
            "octree",
            1024,
            0.25,
            Query::Published,
            "threshold 1024, box 1/4, as printed",
        ),
        published("octree", 64, 0.25, Query::Complete, "threshold 64, box 1/4"),
    ];
    if !quick {
        ways.extend([
            production(2000.0, "2 kHz"),
            production(5000.0, "5 kHz"),
            mesh(2_962, "2,962 triangles"),
            mesh(41_582, "41,582 triangles"),
            mesh(500_000, "500,000 triangles"),
            published(
                "octree",
                1024,
                0.25,
                Query::Complete,
                "threshold 1024, box 1/4",
            ),
            published("octree", 64, 0.5, Query::Complete, "threshold 64, box 1/2"),
            published("octree", 64, 0.1, Query::Complete, "threshold 64, box 1/10"),
            published(
                "octree",
                64,
                0.02,
                Query::Complete,
                "threshold 64, box 1/50",
            ),
            published(
                "bsp",
                1024,
                0.25,
                Query::Published,
                "threshold 1024, box 1/4, as printed",
            ),
            published("bsp", 64, 0.25, Query::Complete, "threshold 64, box 1/4"),
        ]);
    }
    ways
}

/// What one way came to.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Felt {
    pub median_us: f64,
    pub p99_us: f64,
    /// Work per second of session by the median tick, ms.
    pub ms_per_s: f64,
    pub rms_n: f64,
    pub max_n: f64,
    /// RMS of the error over the force, where there is one worth the name.
    pub relative: f64,
    /// Time in which the skin was missed, ms.
    pub missed_ms: f64,
}

/// The motion and the true force along it.
pub struct Path<'a> {
    scene: &'a Scene,
    trajectory: Trajectory,
    duration_s: f64,
    truth_n: Vec<Vec3>,
}

impl<'a> Path<'a> {
    /// A motion over the skin.
    pub fn new(
        scene: &'a Scene,
        trajectory: Trajectory,
        watch: &mut Watch<'_>,
    ) -> Result<Self, LabError> {
        let mut path = Self {
            scene,
            duration_s: trajectory.duration_s(),
            trajectory,
            truth_n: Vec::new(),
        };
        let touch = touch(scene, Engine::Production, watch)?;
        path.truth_n = path.felt_n(&touch, FINE_HZ, None).0;
        Ok(path)
    }

    /// Runs one way and compares.
    pub fn measure(&self, way: &Way, watch: &mut Watch<'_>) -> Result<Felt, LabError> {
        let touch = touch(self.scene, way.engine, watch)?;
        let (felt_n, samples) = self.felt_n(&touch, way.rate_hz, Some(Stopwatch::new()));
        let (mut sum, mut most, mut n) = (0.0, 0.0_f64, 0.0_f64);
        let (mut shares, mut n_shares, mut missed) = (0.0, 0.0_f64, 0_usize);
        for (felt, truth) in felt_n.iter().zip(&self.truth_n) {
            let off = felt.distance(*truth);
            sum += off * off;
            most = most.max(off);
            n += 1.0;
            if truth.length() > LEAST_N {
                shares += (off / truth.length()) * (off / truth.length());
                n_shares += 1.0;
                missed += usize::from(felt.length() == 0.0);
            }
        }
        Ok(Felt {
            median_us: samples.median(),
            p99_us: samples.quantile(0.99),
            ms_per_s: samples.median() * way.rate_hz / 1000.0,
            rms_n: (sum / n.max(1.0)).sqrt(),
            max_n: most,
            relative: (shares / n_shares.max(1.0)).sqrt(),
            missed_ms: missed as f64 * 1000.0 / FINE_HZ,
        })
    }

    /// Whether the surface cannot be had with other triangles.
    pub fn is_fixed(&self) -> bool {
        !matches!(
            self.scene.scenario.surface,
            SurfaceChoice::BuiltinBack { .. }
        )
    }

    /// Largest true force, N.
    pub fn largest_n(&self) -> f64 {
        self.truth_n.iter().map(|f| f.length()).fold(0.0, f64::max)
    }

    /// The force before limits at the fine rate, N, held from tick to tick, and the time of each tick, µs.
    fn felt_n(
        &self,
        touch: &TouchScene,
        rate_hz: f64,
        stopwatch: Option<Stopwatch>,
    ) -> (Vec<Vec3>, Samples) {
        let mut device = Scripted::new(self.trajectory.clone());
        let mut rig = Rig::new(Box::new(touch.clone()), [Limits::default(); MAX_FINGERS]);
        let dt_s = 1.0 / rate_hz;
        let held = (FINE_HZ / rate_hz).round().max(1.0) as usize;
        let n_ticks = (self.duration_s * rate_hz).ceil() as usize;
        let mut felt_n = Vec::with_capacity(n_ticks * held);
        let mut samples = Samples::default();
        let mut input = TickInput {
            n_fingers: 1,
            force_enabled: true,
            ..TickInput::default()
        };
        for _ in 0..n_ticks {
            input.readings[0] = device.read(dt_s);
            let record = match &stopwatch {
                Some(stopwatch) => {
                    let (record, took_us) = stopwatch.time(|| tick(&mut rig, &input, dt_s));
                    samples.push(took_us);
                    record
                }
                None => tick(&mut rig, &input, dt_s),
            };
            let force_n = record
                .fingers()
                .first()
                .map_or(Vec3::ZERO, |f| f.contact.force_n);
            felt_n.extend(std::iter::repeat_n(force_n, held));
        }
        (felt_n, samples)
    }
}

/// What a finger does that was not recorded.
pub fn scripted(scene: &Scene, quick: bool) -> Trajectory {
    let script = if quick { Script::Press } else { Script::Spiral };
    trajectory(scene, script, DEPTH_MM)
}

/// A script laid over the skin of a scene about its middle.
pub fn trajectory(scene: &Scene, script: Script, depth_mm: f64) -> Trajectory {
    let surface = &*scene.surface;
    let bounds = surface.bounds();
    let centre = bounds.centre();
    let place = (centre.x + 0.08 * bounds.size().x, centre.y);
    script.trajectory(place, depth_mm, |x, y| {
        let from = Vec3::new(x, y, bounds.max.z + 1.0);
        let to = Vec3::new(x, y, bounds.min.z - 1.0);
        let hit = scene.touch.search.sweep(surface, from, to, Sides::Front)?;
        Some(hit.point.z + scene.touch.choices.pad_mm().unwrap_or(0.0))
    })
}

/// What the servo gets for a scene felt by `engine`.
pub fn touch(scene: &Scene, engine: Engine, watch: &mut Watch<'_>) -> Result<TouchScene, LabError> {
    let plain = TouchScene {
        published: None,
        ..scene.touch.clone()
    };
    match engine {
        Engine::Production => Ok(plain),
        Engine::Mesh(triangles) => {
            let mut scenario = Scenario::clone(&scene.scenario);
            scenario.surface = SurfaceChoice::BuiltinBack { triangles };
            scenario.published = None;
            built(scenario, watch).map(|scene| scene.touch)
        }
        Engine::Published {
            partition,
            threshold,
            hdb_part,
            query,
        } => {
            let mut options = Options {
                partition,
                hdb_part,
                query,
                ..Options::default()
            };
            options.tree.threshold = threshold;
            let mut go_on = |share| watch.at("building a published structure", share).is_ok();
            let made = Published::build(&scene.surface, &options, &mut go_on)
                .map_err(|e| LabError::Input(e.to_string()))?;
            Ok(TouchScene {
                published: Some(Arc::new(made.ok_or(LabError::Stopped)?)),
                ..plain
            })
        }
    }
}

/// A scene from a scenario.
pub fn built(scenario: Scenario, watch: &mut Watch<'_>) -> Result<Scene, LabError> {
    let purpose = Use {
        fingers: 1,
        deformed: true,
        ..Use::default()
    };
    let mut stopped = false;
    let made = build(Arc::new(scenario), purpose, &mut |what, share| {
        stopped = watch.at(what, share).is_err();
        !stopped
    });
    match made {
        Err(_) if stopped => Err(LabError::Stopped),
        made => made.map_err(|e| LabError::Input(e.to_string())),
    }
}
