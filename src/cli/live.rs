//! A run in real time: servo thread, recorder thread, and the end of both, whatever ends them.

use super::CliError;
use super::common::progress_bar;
use super::run::{RUN_BAR, Target};
use super::summary::Summary;
use crate::device::Device;
use crate::scenario::Scene;
use crate::servo::{self, Limits, MAX_FINGERS, Rig, Running, ServoConfig};
use crate::session::recorder::RecorderThread;
use crate::session::writer::IfExists;
use crate::session::{DeviceInfo, Extras, Header, MeshSource, build_id, utc_now};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

/// A servo that says nothing for this long is taken for dead.
const PATIENCE: Duration = Duration::from_secs(2);
/// How often it is looked whether the run is to end.
const LOOK: Duration = Duration::from_millis(20);

/// What is to run.
pub(super) struct Live {
    pub(super) rate_hz: f64,
    pub(super) n_ticks: u64,
    pub(super) limits: [Limits; MAX_FINGERS],
    pub(super) infos: Vec<DeviceInfo>,
    /// Of each finger, in its own words; none where there is nothing to say.
    pub(super) calibrations: Vec<String>,
}

impl Live {
    /// Runs to its end, until `gone` says why not, or until everything is halted; a recording is closed in any case. The
    /// summary and the number of ticks lost to the recorder.
    pub(super) fn run(
        &self,
        scene: &Scene,
        target: Target<'_>,
        devices: Vec<Box<dyn Device>>,
        gone: &dyn Fn() -> Option<String>,
    ) -> Result<(Summary, u64), CliError> {
        let _running = Running::new();
        let rig = Rig::new(Box::new(scene.touch.clone()), self.limits);
        let config = ServoConfig {
            rate_hz: self.rate_hz,
            ..ServoConfig::default()
        };
        let dt_s = config.dt_s();
        let (servo, lines) = servo::start(config, rig, devices).map_err(CliError::input)?;
        // The tap sees every record on the recorder's thread; one full summary at a time comes back.
        let (tell, told) = mpsc::sync_channel(8);
        let mut summary = Summary::new(dt_s);
        let tap = move |records: &[servo::FingerRecord]| {
            for record in records {
                summary.add(record);
            }
            // A full channel means that the last summary has not been read yet; the next one will tell more.
            let _ = tell.try_send(summary.clone());
        };
        let recorder =
            RecorderThread::spawn(lines.records, Some(Box::new(tap))).map_err(CliError::input)?;
        recorder.carry(match target {
            Some(_) => Extras {
                calibrations: self.calibrations.clone(),
                ..extras(scene)?
            },
            None => Extras::default(),
        });
        let header = || header(scene, self.rate_hz, self.infos.clone());
        match target {
            Some((path, IfExists::Refuse)) => recorder.start(path, header()),
            Some((path, IfExists::Replace)) => recorder.start_replacing(path, header()),
            None => Ok(()),
        }
        .map_err(CliError::input)?;
        let bar = progress_bar(self.n_ticks, RUN_BAR);
        let mut last = Summary::new(dt_s);
        let mut heard = Instant::now();
        let mut dead = None;
        while last.ticks < self.n_ticks && servo::halted().is_none() && gone().is_none() {
            match told.recv_timeout(LOOK) {
                Ok(summary) => (last, heard) = (summary, Instant::now()),
                Err(RecvTimeoutError::Timeout) if heard.elapsed() < PATIENCE => {}
                Err(_) => {
                    dead = Some("the servo stopped answering; try --fast");
                    break;
                }
            }
            bar.set_position(last.ticks.min(self.n_ticks));
        }
        bar.finish_and_clear();
        drop(servo);
        let lost = match target {
            Some(_) => recorder.stop().map_err(CliError::input)?.lost,
            None => 0,
        };
        drop(recorder);
        if let Some(why) = dead {
            return Err(CliError::input(why));
        }
        if let Some(newest) = told.try_iter().last() {
            last = newest;
        }
        Ok((last, lost))
    }
}

/// The header of a run that starts now.
pub(super) fn header(scene: &Scene, rate_hz: f64, devices: Vec<DeviceInfo>) -> Header {
    Header {
        scenario_toml: scene.scenario.source.clone(),
        scenario_name: scene.scenario.name.clone(),
        mesh: MeshSource::new(&scene.surface, &scene.mesh_origin),
        devices,
        rate_hz,
        build: build_id(),
        started_utc: utc_now(),
        participant: None,
        edit: 0,
        sealed: false,
    }
}

/// What travels with a recording: the mesh where it is a file.
pub(super) fn extras(scene: &Scene) -> Result<Extras, CliError> {
    let folder = scene.scenario.folder.as_deref();
    Extras::of_this_machine()
        .with_mesh_of(&scene.mesh_origin, folder)
        .map_err(CliError::input)
}
