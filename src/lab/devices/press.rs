//! A device laid over the back, pressed through the real servo into a file.

use super::input;
use crate::device::{Calibration, Capabilities, Device};
use crate::geom::Vec3;
use crate::lab::LabError;
use crate::scenario::{self, Scenario, Scene, Use};
use crate::servo::{self, Limits, Lines, MAX_FINGERS, Rig, Servo, ServoConfig};
use crate::session::{
    DeviceInfo, Header, MeshSource, RecorderHandle, RecorderThread, build_id, utc_now,
};
use std::path::Path;
use std::sync::Arc;

/// Stiffness of the skin, N/mm: below what every emulated arm is told to render.
pub(super) const SKIN_N_PER_MM: f64 = 0.6;

/// The back that is pressed.
pub(super) fn scene() -> Result<Scene, LabError> {
    let text = format!(
        "format = 1\nname = \"Device loop\"\n[surface]\nbuiltin = \"back\"\ntriangles = 2962\n[stiffness]\nconstant_n_per_mm = {SKIN_N_PER_MM}\n\
         [friction]\nstatic = 0.46\ndynamic = 0.44\n"
    );
    let scenario = Scenario::parse(&text, "device loop", None).map_err(input)?;
    let purpose = Use {
        fingers: 1,
        recorded: true,
        ..Use::default()
    };
    scenario::build(Arc::new(scenario), purpose, &mut |_, _| true).map_err(input)
}

/// Lays the middle of a device's workspace on the skin.
pub(super) fn laid(scene: &Scene, mut calibration: Calibration) -> Calibration {
    let (x, y) = scene.default_place_mm();
    let z = scene.height_mm(x, y).unwrap_or(0.0);
    calibration.mapping.offset_mm = Vec3::new(x, y, z);
    calibration
}

/// A servo with one device, recorded.
pub(super) struct Run {
    pub(super) servo: Servo,
    pub(super) snapshot: triple_buffer::Output<servo::Snapshot>,
    /// Kept: a servo whose lines are gone has nowhere to put what it is done with.
    _retired: rtrb::Consumer<servo::Retired>,
    _commands: rtrb::Producer<servo::Command>,
    pub(super) recorder: RecorderHandle,
}

impl Run {
    pub(super) fn start(
        scene: &Scene,
        device: Box<dyn Device>,
        recording: Option<&Path>,
    ) -> Result<Self, LabError> {
        let can = device.capabilities().clone();
        let limits = Limits::of(&can);
        let rig = Rig::new(Box::new(scene.touch.clone()), [limits; MAX_FINGERS]);
        let (servo, lines) =
            servo::start(ServoConfig::default(), rig, vec![device]).map_err(input)?;
        let Lines {
            snapshot,
            records,
            retired,
            commands,
        } = lines;
        let recorder = RecorderThread::spawn(records, None).map_err(input)?;
        if let Some(path) = recording {
            recorder.start(path, header(scene, &can)).map_err(input)?;
        }
        Ok(Self {
            servo,
            snapshot,
            _retired: retired,
            _commands: commands,
            recorder,
        })
    }
}

fn header(scene: &Scene, can: &Capabilities) -> Header {
    Header {
        scenario_toml: scene.scenario.source.clone(),
        scenario_name: scene.scenario.name.clone(),
        mesh: MeshSource::new(&scene.surface, &scene.mesh_origin),
        devices: vec![DeviceInfo::new(&can.name, &Limits::of(can))],
        rate_hz: ServoConfig::default().rate_hz,
        build: build_id(),
        started_utc: utc_now(),
        participant: None,
        edit: 0,
        sealed: false,
    }
}
