//! Our engine: alone along the path, and within the whole tick of the servo.

use crate::cases::Case;
use crate::measure::{Cost, timed_ms};
use dorsum::contact::{
    Choices, ContactState, Friction, Shading, Stiffness, Touch, TouchScene, advance,
};
use dorsum::device::Reading;
use dorsum::geom::Vec3;
use dorsum::partition::{Partition, bvh::Bvh};
use dorsum::servo::{Limits, Rig, TickInput, tick};
use dorsum::surface::Surface;
use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

pub const TICKS: usize = 20_000;
pub const DT_S: f64 = 1e-3;
/// For how long one finger is measured at most; then the path is cut short.
const AT_MOST: Duration = Duration::from_secs(5);
/// Radius of the finger pad, mm.
pub const PAD_MM: f64 = 5.0;

/// How the surface is touched.
pub struct Fingers {
    pub name: &'static str,
    /// Height of the finger tip above the surface, mm.
    offset_mm: f64,
    friction: bool,
    radius_mm: f64,
    shaded: bool,
}

impl Fingers {
    /// Without friction, with it, above the surface, with a finger pad, with force shading.
    pub fn all() -> [Self; 6] {
        let finger = |name, offset_mm, friction, radius_mm| Self {
            name,
            offset_mm,
            friction,
            radius_mm,
            shaded: false,
        };
        let shaded = |name, friction| Self {
            shaded: true,
            ..finger(name, -5.0, friction, 0.0)
        };
        [
            finger("frictionless", -5.0, false, 0.0),
            finger("friction", -5.0, true, 0.0),
            finger("hover", 30.0, true, 0.0),
            finger("5 mm pad", -5.0, true, PAD_MM),
            shaded("shaded", false),
            shaded("shaded, fr.", true),
        ]
    }
}

/// A surface with its search structure, and what making them took.
pub struct Scene {
    pub surface: Arc<Surface>,
    pub search: Arc<Bvh>,
    pub surface_ms: f64,
    pub search_ms: f64,
    unit: f64,
}

/// What is felt along the path.
pub struct Felt {
    pub cost: Cost,
    /// Largest distance in the map plane between anchor and device.
    pub lag_mm: f64,
    /// Ticks well inside without contact.
    pub pops: usize,
    pub force_step_p99_n: f64,
    pub force_step_max_n: f64,
}

impl Scene {
    pub fn new(case: &Case) -> Self {
        let mesh = case.mesh.clone();
        let (surface_ms, made) = timed_ms(|| Surface::new(mesh));
        let surface = match made {
            Ok((surface, _)) => Arc::new(surface),
            Err(e) => panic!("the benchmark surface is refused: {e}"),
        };
        let (search_ms, search) = timed_ms(|| Arc::new(Bvh::new(&surface)));
        Self {
            surface,
            search,
            surface_ms,
            search_ms,
            unit: case.unit,
        }
    }

    pub fn triangles(&self) -> usize {
        self.surface.triangles().len()
    }

    pub fn search_bytes(&self) -> usize {
        self.search.bytes()
    }

    /// Stiffness 1 N per millimetre of the benchmark.
    pub fn touch(&self, finger: &Fingers) -> TouchScene {
        let stiffness = Stiffness::Uniform(1.0 / self.unit);
        TouchScene {
            friction: finger.friction.then_some(Friction {
                static_coefficient: 0.46,
                dynamic_coefficient: 0.44,
                skin_looseness: 1.0,
            }),
            choices: Choices {
                finger_radius_mm: finger.radius_mm * self.unit,
                ..Choices::default()
            },
            shading: finger.shaded.then(|| Shading::of(&self.surface)),
            ..TouchScene::new(self.surface.clone(), self.search.clone(), stiffness)
        }
    }

    /// The engine alone.
    pub fn path(&self, case: &Case, finger: &Fingers, clock_ns: f64) -> Felt {
        let scene = self.touch(finger);
        let (mut state, mut last_force_n) = approached(case, finger, &scene);
        let (mut ns, mut steps_n, mut lag_mm, mut pops) = (vec![], vec![], 0.0_f64, 0);
        let begun = Instant::now();
        for i in (0..TICKS).take_while(|_| begun.elapsed() < AT_MOST) {
            let hip = case.at(i as f64 * DT_S, finger.offset_mm + finger.radius_mm);
            let start = Instant::now();
            let contact = black_box(advance(&scene, &mut state, black_box(hip)));
            ns.push(start.elapsed().as_nanos() as u64);
            steps_n.push((contact.force_n - last_force_n).length());
            last_force_n = contact.force_n;
            let lag = (contact.anchor_mm - hip).truncate().length() / self.unit;
            lag_mm = lag_mm.max(lag);
            let inside = case.below_mm(hip) > 2.0 - finger.radius_mm;
            pops += usize::from(inside && contact.touch == Touch::Free);
        }
        steps_n.sort_unstable_by(f64::total_cmp);
        Felt {
            cost: Cost::of(ns, clock_ns),
            lag_mm,
            pops,
            force_step_p99_n: steps_n[steps_n.len() * 99 / 100],
            force_step_max_n: steps_n[steps_n.len() - 1],
        }
    }

    /// Everything the servo does in a tick.
    pub fn whole_ticks(&self, case: &Case, finger: &Fingers, clock_ns: f64) -> Cost {
        let mut rig = Rig::new(Box::new(self.touch(finger)), Default::default());
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
        let offset_mm = finger.offset_mm + finger.radius_mm;
        for hip in case.approach(offset_mm) {
            tick(&mut rig, &input(hip), DT_S);
        }
        let begun = Instant::now();
        let ns = (0..TICKS)
            .take_while(|_| begun.elapsed() < AT_MOST)
            .map(|i| {
                let input = input(case.at(i as f64 * DT_S, offset_mm));
                let start = Instant::now();
                black_box(tick(&mut rig, black_box(&input), DT_S));
                start.elapsed().as_nanos() as u64
            })
            .collect();
        Cost::of(ns, clock_ns)
    }

    /// The dearest tick of an approach: the one that meets the surface.
    pub fn first_touch_us(&self, case: &Case) -> f64 {
        let [_, finger, ..] = Fingers::all();
        let scene = self.touch(&finger);
        let mut state = free(case);
        let mut most = 0;
        for hip in case.approach(finger.offset_mm) {
            let was_free = state.touch == Touch::Free;
            let start = Instant::now();
            black_box(advance(&scene, &mut state, black_box(hip)));
            if was_free && state.touch != Touch::Free {
                most = most.max(start.elapsed().as_nanos());
            }
        }
        most as f64 / 1000.0
    }
}

fn free(case: &Case) -> ContactState {
    ContactState {
        proxy_mm: case.at(0.0, 30.0),
        ..ContactState::default()
    }
}

/// State and force after the approach.
fn approached(case: &Case, finger: &Fingers, scene: &TouchScene) -> (ContactState, Vec3) {
    let mut state = free(case);
    let mut force_n = Vec3::ZERO;
    for hip in case.approach(finger.offset_mm + finger.radius_mm) {
        force_n = advance(scene, &mut state, hip).force_n;
    }
    (state, force_n)
}
