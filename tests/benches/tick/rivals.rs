//! What others take on the same mesh and path: parry's queries, all triangles one by one, the haptic pass as published.

use crate::cases::Case;
use crate::measure::{Cost, each, timed_ms};
use crate::ours::{DT_S, Fingers, PAD_MM, Scene, TICKS};
use dorsum::contact::published::{Options, Published};
use dorsum::contact::{ContactState, advance};
use dorsum::geom::Vec3;
use dorsum::partition::{Partition, brute::Brute};
use dorsum::surface::{RawMesh, Surface};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::{PointQuery, ShapeCastOptions, cast_shapes};
use parry3d_f64::shape::{Ball, TriMesh};
use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

/// For how long a rival is measured at most.
const AT_MOST: Duration = Duration::from_secs(2);
/// Every so many ticks are enough for a query that remembers nothing of the last.
const STEP: usize = 10;
/// Depth of the path below the surface, mm.
const OFFSET_MM: f64 = -5.0;

fn path(case: &Case, offset_mm: f64) -> impl Iterator<Item = Vec3> {
    (0..TICKS).map(move |i| case.at(i as f64 * DT_S, offset_mm))
}

/// parry's mesh with its own hierarchy, in the order of the file.
pub struct Parry {
    mesh: TriMesh,
    pub build_ms: f64,
}

fn vector(p: Vec3) -> Vector {
    Vector::new(p.x, p.y, p.z)
}

impl Parry {
    pub fn new(mesh: &RawMesh) -> Self {
        let vertices = mesh.positions.iter().map(|p| vector(*p)).collect();
        let triangles = mesh.triangles.clone();
        let (build_ms, mesh) = timed_ms(|| TriMesh::new(vertices, triangles));
        let mesh = mesh.unwrap_or_else(|e| panic!("parry refuses the benchmark surface: {e}"));
        Self { mesh, build_ms }
    }

    pub fn bytes(&self) -> usize {
        self.mesh.bvh().heap_memory_size()
    }

    /// The point of the mesh nearest to the device.
    pub fn nearest(&self, case: &Case, clock_ns: f64) -> Cost {
        each(path(case, OFFSET_MM), STEP, AT_MOST, clock_ns, |p| {
            black_box(self.mesh.project_local_point(vector(p), false));
        })
    }

    /// One sweep of a ball the size of our finger pad, from clear of the surface to where the device is: the least that a
    /// ball as proxy needs every tick.
    pub fn sphere_sweep(&self, case: &Case, clock_ns: f64) -> Cost {
        let ball = Ball::new(PAD_MM * case.unit);
        // On the steepest flank the ball is clear of the surface from this high.
        let clear_mm = 2.0 * PAD_MM;
        let down = vector(-Vec3::Z * (clear_mm - OFFSET_MM - PAD_MM) * case.unit);
        let options = ShapeCastOptions::with_max_time_of_impact(1.0);
        let still = Vector::new(0.0, 0.0, 0.0);
        each(path(case, clear_mm), STEP, AT_MOST, clock_ns, |p| {
            let pose = Pose::translation(p.x, p.y, p.z);
            let hit = cast_shapes(
                &Pose::IDENTITY,
                still,
                &self.mesh,
                &pose,
                down,
                &ball,
                options,
            );
            let _ = black_box(hit);
        })
    }
}

/// The nearest point by asking every triangle.
pub fn brute(case: &Case, surface: &Surface, clock_ns: f64) -> Cost {
    each(path(case, OFFSET_MM), STEP, AT_MOST, clock_ns, |p| {
        black_box(Brute.nearest(surface, p, f64::INFINITY));
    })
}

/// The published pass with its own choices. It goes on from the last tick, so every tick is taken until time is up; `None`
/// where its structure cannot be built.
pub fn published(case: &Case, scene: &Scene, clock_ns: f64) -> Option<Cost> {
    let [_, finger, ..] = Fingers::all();
    let options = Options::default();
    let built = Published::build(&scene.surface, &options, &mut |_| true);
    let mut touch = scene.touch(&finger);
    touch.published = Some(Arc::new(built.ok()??));
    let mut state = ContactState {
        proxy_mm: case.at(0.0, 30.0),
        ..ContactState::default()
    };
    // The last ticks of the approach: each may take milliseconds.
    for hip in case.approach(OFFSET_MM).skip(250) {
        advance(&touch, &mut state, hip);
    }
    Some(each(path(case, OFFSET_MM), 1, AT_MOST, clock_ns, |hip| {
        black_box(advance(&touch, &mut state, hip));
    }))
}
