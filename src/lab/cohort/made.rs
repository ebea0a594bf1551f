//! The synthetic sessions: one after the other, each from its own seed.

use super::{EACH, FINGERS, RATE_HZ, SECONDS, failed, ticks};
use crate::device::Device;
use crate::device::scripted::{Scripted, Trajectory, TrajectoryError, Waypoint};
use crate::geom::Vec3;
use crate::lab::{LabError, Setup, Watch};
use crate::scenario::{self, Scenario, Scene, Use, default_example};
use crate::servo::{Limits, MAX_FINGERS, Rig, run_offline};
use crate::session::{DeviceInfo, Header, IfExists, MeshSource, SessionWriter, build_id};
use crate::training::random::Random;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How deep the fingers of participants with an even and an odd number press at most, mm.
pub(super) const DEEP_MM: [f64; 2] = [8.0, 6.0];
/// The group of either.
pub(super) const GROUPS: [&str; 2] = ["deep", "shallow"];

/// The group of session `i`: 0 or 1.
pub(super) fn group_of(i: usize) -> usize {
    (i / EACH) % 2
}

/// Records `n` sessions; each has its own seed.
pub(super) fn made(
    folder: &Path,
    n: usize,
    setup: &Setup,
    watch: &mut Watch<'_>,
) -> Result<Vec<PathBuf>, LabError> {
    let example = default_example();
    let input = |e: &dyn std::fmt::Display| LabError::Input(e.to_string());
    let parsed = Scenario::parse(example.text, example.file, None).map_err(|e| input(&e))?;
    let purpose = Use {
        fingers: FINGERS,
        ..Use::default()
    };
    let built = scenario::build(Arc::new(parsed), purpose, &mut |_, _| true);
    let scene = built.map_err(|e| input(&e))?;
    let mut files = Vec::with_capacity(n);
    for i in 0..n {
        watch.at("recording sessions", i as f64 / n as f64)?;
        let path = folder.join(format!("{i:05}.mcap"));
        record(&path, &scene, i, setup.seed).map_err(|e| failed(&path, &e))?;
        files.push(path);
    }
    Ok(files)
}

fn record(
    path: &Path,
    scene: &Scene,
    i: usize,
    seed: u64,
) -> Result<(), Box<dyn std::error::Error>> {
    let limits = [Limits::default(); MAX_FINGERS];
    let person = i / EACH;
    let header = Header {
        scenario_toml: scene.scenario.source.clone(),
        scenario_name: scene.scenario.name.clone(),
        mesh: MeshSource::new(&scene.surface, &scene.mesh_origin),
        devices: vec![DeviceInfo::new("Scripted", &limits[0]); FINGERS],
        rate_hz: RATE_HZ,
        build: build_id(),
        started_utc: format!("2031-05-{:02}T09:{:02}:00.000Z", 1 + i % EACH, person % 60),
        participant: Some(format!("P{person:04}")),
        edit: 0,
        sealed: false,
    };
    let mut random = Random::new(seed ^ ((i as u64) << 20));
    let deep_mm = DEEP_MM[group_of(i)];
    let devices = (0..FINGERS).map(|finger| {
        let path = trajectory(scene, finger, deep_mm, &mut random);
        path.map(|path| Box::new(Scripted::new(path)) as Box<dyn Device>)
    });
    let devices = devices.collect::<Result<_, _>>()?;
    let mut writer = SessionWriter::create(path, &header, IfExists::Refuse)?;
    let mut rig = Rig::new(Box::new(scene.touch.clone()), limits);
    let (mut n, mut wrong) = (0, None);
    run_offline(&mut rig, devices, 1.0 / RATE_HZ, |out| {
        wrong = out.fingers().iter().find_map(|r| writer.write(r).err());
        n += 1;
        wrong.is_none() && n < ticks()
    });
    match wrong {
        Some(error) => Err(error.into()),
        None => Ok(writer.finish().map(drop)?),
    }
}

/// Presses at places of chance, one after the other.
fn trajectory(
    scene: &Scene,
    finger: usize,
    deep_mm: f64,
    random: &mut Random,
) -> Result<Trajectory, TrajectoryError> {
    let (x, y) = scene.default_place_mm();
    let side = if finger == 0 { 1.0 } else { -1.0 };
    let mut waypoints = Vec::new();
    let mut time_s = 0.0;
    while time_s < SECONDS {
        let at = (
            side * x.abs().max(10.0) + 30.0 * random.unit(),
            y - 80.0 * random.unit(),
        );
        let skin_mm = scene.height_mm(at.0, at.1).unwrap_or_default();
        let depth_mm = deep_mm * (0.7 + 0.3 * random.unit());
        for (after_s, height_mm) in [(0.0, 5.0), (0.25, -depth_mm), (0.4, -depth_mm), (0.6, 5.0)] {
            waypoints.push(Waypoint {
                time_s: time_s + after_s,
                position_mm: Vec3::new(at.0, at.1, skin_mm + height_mm),
            });
        }
        time_s += 0.7;
    }
    Trajectory::new(waypoints)
}
