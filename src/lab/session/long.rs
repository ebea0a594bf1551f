//! A long run without waiting for it: scripted fingers through the servo's tick, with all that interrupts a session.

use crate::device::scripted::{Script, Scripted};
use crate::device::{Device as _, MAX_FINGERS};
use crate::lab::{LabError, Watch};
use crate::scenario::{self, Scenario, Scene, Use};
use crate::servo::{Limits, Rig, TickInput, TickRecord, tick};
use crate::session::{DeviceInfo, Header, IfExists, MeshSource, SessionWriter, build_id, utc_now};
use std::path::Path;
use std::sync::Arc;

pub(super) const RATE_HZ: f64 = 1000.0;
pub(super) const FINGERS: usize = 2;
const DT_S: f64 = 1.0 / RATE_HZ;

pub(super) fn input(error: impl std::fmt::Display) -> LabError {
    LabError::Input(error.to_string())
}

/// A scenario by its stiffness, N/mm.
fn text(triangles: usize, stiffness: &str) -> String {
    format!(
        "format = 1\nname = \"Endurance\"\n[surface]\nbuiltin = \"back\"\ntriangles = {triangles}\n[stiffness]\nconstant_n_per_mm = {stiffness}\n\
         [friction]\nstatic = 0.46\ndynamic = 0.44\n"
    )
}

/// The scenes that a long run goes through.
pub(super) struct Scenes {
    /// At the start.
    pub(super) first: Scene,
    /// After the edit.
    pub(super) edited: Scene,
    /// That at the start with one bit of its stiffness changed.
    pub(super) one_bit_off: Scene,
}

impl Scenes {
    pub(super) fn build(triangles: usize, watch: &mut Watch<'_>) -> Result<Self, LabError> {
        let scenario = |stiffness: &str| {
            let text = text(triangles, stiffness);
            Scenario::parse(&text, "endurance", None)
                .map(Arc::new)
                .map_err(input)
        };
        let purpose = Use {
            fingers: FINGERS,
            recorded: true,
            ..Use::default()
        };
        let mut stopped = false;
        let first = scenario::build(scenario("0.6")?, purpose, &mut |what, share| {
            stopped = watch.at(what, share).is_err();
            !stopped
        });
        let first = match first {
            Err(_) if stopped => return Err(LabError::Stopped),
            first => first.map_err(input)?,
        };
        let other = |stiffness: &str| {
            scenario::rebuild(&first, scenario(stiffness)?, purpose).map_err(input)
        };
        let bit = f64::from_bits(0.6_f64.to_bits() ^ 1).to_string();
        Ok(Self {
            edited: other("0.75")?,
            one_bit_off: other(&bit)?,
            first,
        })
    }
}

/// A run on its way: it may be written in several files, one behind the other.
pub(super) struct Long<'a> {
    scenes: &'a Scenes,
    rig: Rig,
    devices: [Scripted; FINGERS],
    swapped: bool,
    done: u64,
}

impl<'a> Long<'a> {
    pub(super) fn new(scenes: &'a Scenes) -> Self {
        let rig = Rig::new(Box::new(scenes.first.touch.clone()), limits());
        Self {
            scenes,
            rig,
            devices: [0, 1].map(|finger| device(scenes, finger, Script::Spiral)),
            swapped: false,
            done: 0,
        }
    }

    /// What a file begun now says of itself.
    pub(super) fn header(&self) -> Header {
        let scene = match self.rig.edit {
            0 => &self.scenes.first,
            _ => &self.scenes.edited,
        };
        Header {
            scenario_toml: scene.scenario.source.clone(),
            scenario_name: scene.scenario.name.clone(),
            mesh: MeshSource::new(&scene.surface, &scene.mesh_origin),
            devices: vec![DeviceInfo::new("Scripted", &Limits::default()); FINGERS],
            rate_hz: RATE_HZ,
            build: build_id(),
            started_utc: utc_now(),
            participant: None,
            edit: self.rig.edit,
            sealed: false,
        }
    }

    /// Goes on for `ticks` ticks, written to `path`. A pause at a quarter of them, the edit (of the first such part) in the
    /// middle, and another device behind it.
    pub(super) fn record(
        &mut self,
        path: &Path,
        ticks: u64,
        watch: &mut Watch<'_>,
    ) -> Result<crate::session::RecordingSummary, LabError> {
        let header = self.header();
        let mut writer = SessionWriter::create(path, &header, IfExists::Replace).map_err(input)?;
        for i in 0..ticks {
            if i == ticks / 4 {
                // Felt on, and not recorded: the recording goes on behind a gap.
                writer.event("mark", "pause").map_err(input)?;
                for _ in 0..ticks.min(500) {
                    self.step();
                }
                writer.restarted();
            }
            if i == ticks / 2 && self.rig.edit == 0 {
                let scene = &self.scenes.edited;
                let text: Arc<str> = scene.scenario.source.as_str().into();
                writer.edit(1, &text).map_err(input)?;
                drop(self.rig.edit_scene(1, Box::new(scene.touch.clone())));
            }
            if i == ticks / 2 + ticks / 8 {
                self.devices[1] = device(self.scenes, 1, Script::Tap);
                self.swapped = true;
            }
            for record in self.step().fingers() {
                writer.write(record).map_err(input)?;
            }
            if i % 250 == 249 {
                writer.flush().map_err(input)?;
            }
            if i % 10_000 == 0 {
                watch.at("recording", i as f64 / ticks as f64)?;
            }
        }
        writer.finish().map_err(input)
    }

    fn step(&mut self) -> TickRecord {
        let mut given = TickInput {
            n_fingers: FINGERS,
            force_enabled: true,
            ..TickInput::default()
        };
        // A motion is played over and over, by one finger a little later than by the other.
        for (finger, script) in [Script::Spiral, Script::Spiral].into_iter().enumerate() {
            let again = (script.duration_s() * RATE_HZ) as u64 + 137 * finger as u64;
            if self.done > 0 && self.done.is_multiple_of(again.max(1)) {
                self.devices[finger] = device(self.scenes, finger, script);
            }
            given.readings[finger] = self.devices[finger].read(DT_S);
        }
        given.place_anew[1] = std::mem::take(&mut self.swapped);
        self.done += 1;
        tick(&mut self.rig, &given, DT_S)
    }
}

pub(super) fn limits() -> [Limits; MAX_FINGERS] {
    [Limits::default(); MAX_FINGERS]
}

fn device(scenes: &Scenes, finger: usize, script: Script) -> Scripted {
    let scene = &scenes.first;
    let (x, y) = scene.default_place_mm();
    let place = (x + 30.0 * finger as f64, y);
    Scripted::new(script.trajectory(place, 6.0, |x, y| scene.height_mm(x, y)))
}
