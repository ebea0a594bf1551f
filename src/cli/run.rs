//! `dorsum run`: the full servo loop with a scripted device, without a window.

use super::common::{build_scene, load_scenario, parse_place, progress_bar};
use super::summary::Summary;
use super::{CliError, Outcome, print, print_json};
use crate::device::Device;
use crate::device::scripted::{Script, Scripted, Trajectory};
use crate::scenario::{Scene, Use};
use crate::servo::{self, Limits, MAX_FINGERS, Rig, ServoConfig};
use crate::session::recorder::RecorderThread;
use crate::session::writer::{IfExists, SessionWriter};
use crate::session::{DeviceInfo, Extras, Header, MeshSource, build_id, compress, utc_now};
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Duration;

/// Which scenario, which motion, what becomes of it.
#[derive(Debug, clap::Args)]
pub struct RunArgs {
    /// Scenario file, or the name of an example.
    scenario: String,
    /// Motion of the fingers: CSV with columns t,x,y,z[,finger] in s and mm.
    #[arg(long, value_name = "TRAJ.csv", conflicts_with = "script")]
    path: Option<PathBuf>,
    /// Motion by name: press, slide, circle, spiral or tap.
    #[arg(long, value_name = "NAME", value_parser = script_by_name)]
    script: Option<Script>,
    /// Where a script presses on the map plane, mm.
    #[arg(long, value_name = "X,Y", value_parser = parse_place, requires = "script", allow_hyphen_values = true)]
    at: Option<(f64, f64)>,
    /// How deep a script presses, mm.
    #[arg(long, value_name = "MM", default_value_t = 6.0, value_parser = depth_mm, requires = "script")]
    depth: f64,
    /// Record the run into this file.
    #[arg(long, value_name = "OUT.mcap")]
    record: Option<PathBuf>,
    /// Replace the file if it is there.
    #[arg(long, requires = "record")]
    overwrite: bool,
    /// Compress the recording when it is finished.
    #[arg(long, requires = "record")]
    compress: bool,
    /// Run as fast as it goes instead of in real time.
    #[arg(long)]
    fast: bool,
    /// Ticks per second.
    #[arg(long, value_name = "HZ", default_value_t = 1000.0, value_parser = rate_hz)]
    rate: f64,
    /// Let the skin give out no more energy than the finger has put in (passivity controller).
    #[arg(long)]
    passivity: bool,
}

fn script_by_name(name: &str) -> Result<Script, String> {
    let names = Script::ALL.map(Script::name).join(", ");
    Script::by_name(name).ok_or_else(|| format!("allowed are {names}"))
}

fn depth_mm(text: &str) -> Result<f64, String> {
    number_in(text, 0.0, 100.0, "mm")
}

fn rate_hz(text: &str) -> Result<f64, String> {
    number_in(text, 100.0, 10_000.0, "Hz")
}

fn number_in(text: &str, low: f64, high: f64, unit: &str) -> Result<f64, String> {
    let allowed = format!("{low} to {high} {unit} is allowed");
    text.parse()
        .ok()
        .filter(|x| (low..=high).contains(x))
        .ok_or(allowed)
}

#[derive(serde::Serialize)]
struct Printed {
    scenario: String,
    motion: String,
    real_time: bool,
    passivity: bool,
    summary: Summary,
    recorded: Option<PathBuf>,
    lost_ticks: u64,
}

/// Runs the motion to its end and says what it came to.
///
/// # Errors
/// The scenario, the motion or the file to record into is refused.
pub fn run(args: &RunArgs, json: bool) -> Result<Outcome, CliError> {
    if let Some(path) = args
        .record
        .as_deref()
        .filter(|p| !args.overwrite && p.exists())
    {
        let what = "is already there; choose another name or add --overwrite";
        return Err(CliError::input(format!("{}: {what}", path.display())));
    }
    let purpose = Use {
        fingers: 1,
        recorded: args.record.is_some(),
        passivity: args.passivity,
        ..Use::default()
    };
    let scene = build_scene(load_scenario(&args.scenario)?, purpose)?;
    let (trajectories, motion) = match (&args.path, args.script) {
        (Some(path), _) => (
            Trajectory::load_csv(path).map_err(CliError::input)?,
            path.display().to_string(),
        ),
        (None, Some(script)) => {
            let place = args.at.unwrap_or_else(|| scene.default_place_mm());
            (
                vec![script_over(&scene, script, place, args.depth)],
                script.to_string(),
            )
        }
        (None, None) => {
            return Err(CliError::input(
                "a motion is needed: --path TRAJ.csv or --script NAME",
            ));
        }
    };
    let plan = Plan {
        rate_hz: args.rate,
        trajectories,
        passivity: args.passivity,
    };
    let target = args.record.as_deref().map(|path| {
        (
            path,
            if args.overwrite {
                IfExists::Replace
            } else {
                IfExists::Refuse
            },
        )
    });
    let (summary, lost_ticks) = if args.fast {
        plan.run_fast(&scene, target)?
    } else {
        plan.run_live(&scene, target)?
    };
    if let Some(path) = args.record.as_deref().filter(|_| args.compress) {
        let bar = progress_bar(1000, "compressing  {bar:40} {percent:>3} %  {eta}");
        let compressed = compress(path, &mut |done| {
            bar.set_position((done * 1000.0) as u64);
            true
        });
        bar.finish_and_clear();
        compressed.map_err(CliError::input)?;
    }
    let printed = Printed {
        scenario: scene.scenario.name.clone(),
        motion,
        real_time: !args.fast,
        passivity: args.passivity,
        summary,
        recorded: args.record.clone(),
        lost_ticks,
    };
    if json {
        print_json(&printed)?;
    } else {
        print(format_args!("{} · {}", printed.scenario, printed.motion));
        print(format_args!("{}", printed.summary));
        if let Some(path) = &printed.recorded {
            print(format_args!("lost ticks    {lost_ticks:>8}"));
            print(format_args!("recorded to {}", path.display()));
        }
    }
    Ok(Outcome::Done)
}

/// A script laid over the skin of a scene.
pub(super) fn script_over(
    scene: &Scene,
    script: Script,
    place: (f64, f64),
    depth_mm: f64,
) -> Trajectory {
    script.trajectory(place, depth_mm, |x, y| scene.height_mm(x, y))
}

/// Motions at a rate.
pub(super) struct Plan {
    pub(super) rate_hz: f64,
    pub(super) trajectories: Vec<Trajectory>,
    /// The passivity controller is on.
    pub(super) passivity: bool,
}

type Target<'a> = Option<(&'a Path, IfExists)>;

impl Plan {
    fn devices(&self) -> Vec<Box<dyn Device>> {
        self.trajectories
            .iter()
            .map(|t| Box::new(Scripted::new(t.clone())) as Box<dyn Device>)
            .collect()
    }

    fn n_ticks(&self) -> u64 {
        let longest_s = self
            .trajectories
            .iter()
            .map(Trajectory::duration_s)
            .fold(0.0, f64::max);
        (longest_s * self.rate_hz).ceil() as u64 + 1
    }

    /// One limit per finger, from what its device can do.
    fn limits(&self) -> [Limits; MAX_FINGERS] {
        let mut limits = [Limits::default(); MAX_FINGERS];
        for (limit, device) in limits.iter_mut().zip(self.devices()) {
            *limit = Limits {
                passivity: self.passivity,
                ..Limits::of(device.capabilities())
            };
        }
        limits
    }

    fn header(&self, scene: &Scene) -> Header {
        let devices = self.devices();
        let named = devices.iter().zip(self.limits());
        Header {
            scenario_toml: scene.scenario.source.clone(),
            scenario_name: scene.scenario.name.clone(),
            mesh: MeshSource::new(&scene.surface, &scene.mesh_origin),
            devices: named
                .map(|(d, limits)| DeviceInfo::new(&d.capabilities().name, &limits))
                .collect(),
            rate_hz: self.rate_hz,
            build: build_id(),
            started_utc: utc_now(),
            participant: None,
            edit: 0,
            sealed: false,
        }
    }

    /// As fast as it goes, on this thread. Returns the summary and the number of ticks lost to the recorder.
    fn run_fast(&self, scene: &Scene, target: Target<'_>) -> Result<(Summary, u64), CliError> {
        let mut writer = match target {
            Some((path, if_exists)) => Some(
                SessionWriter::create_with(path, &self.header(scene), &extras(scene)?, if_exists)
                    .map_err(CliError::input)?,
            ),
            None => None,
        };
        let mut rig = Rig::new(Box::new(scene.touch.clone()), self.limits());
        let dt_s = 1.0 / self.rate_hz;
        let mut summary = Summary::new(dt_s);
        let (n_ticks, mut done) = (self.n_ticks(), 0);
        let bar = progress_bar(n_ticks, RUN_BAR);
        let mut failed = None;
        servo::run_offline(&mut rig, self.devices(), dt_s, |out| {
            for record in out.fingers() {
                summary.add(record);
                if let Some(writer) = &mut writer
                    && let Err(e) = writer.write(record)
                {
                    failed = Some(e);
                }
            }
            done += 1;
            if done % 256 == 0 {
                bar.set_position(done);
            }
            done < n_ticks && failed.is_none()
        });
        bar.finish_and_clear();
        if let Some(e) = failed {
            return Err(CliError::input(e));
        }
        let recorded = writer
            .map(SessionWriter::finish)
            .transpose()
            .map_err(CliError::input)?;
        Ok((summary, recorded.map_or(0, |r| r.lost)))
    }

    /// In real time through the servo thread and the recorder thread. Returns the same as [`Plan::run_fast`].
    pub(super) fn run_live(
        &self,
        scene: &Scene,
        target: Target<'_>,
    ) -> Result<(Summary, u64), CliError> {
        let rig = Rig::new(Box::new(scene.touch.clone()), self.limits());
        let config = ServoConfig {
            rate_hz: self.rate_hz,
            ..ServoConfig::default()
        };
        let dt_s = config.dt_s();
        let n_ticks = self.n_ticks();
        let (servo, lines) = servo::start(config, rig, self.devices()).map_err(CliError::input)?;
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
            Some(_) => extras(scene)?,
            None => Extras::default(),
        });
        match target {
            Some((path, IfExists::Refuse)) => recorder.start(path, self.header(scene)),
            Some((path, IfExists::Replace)) => recorder.start_replacing(path, self.header(scene)),
            None => Ok(()),
        }
        .map_err(CliError::input)?;
        let bar = progress_bar(n_ticks, RUN_BAR);
        let mut last = Summary::new(dt_s);
        while last.ticks < n_ticks {
            match told.recv_timeout(Duration::from_secs(2)) {
                Ok(summary) => last = summary,
                Err(_) => return Err(CliError::input("the servo stopped answering; try --fast")),
            }
            bar.set_position(last.ticks.min(n_ticks));
        }
        bar.finish_and_clear();
        drop(servo);
        let lost = match target {
            Some(_) => recorder.stop().map_err(CliError::input)?.lost,
            None => 0,
        };
        drop(recorder);
        if let Some(newest) = told.try_iter().last() {
            last = newest;
        }
        Ok((last, lost))
    }
}

/// What travels with a recording: the mesh where it is a file.
fn extras(scene: &Scene) -> Result<Extras, CliError> {
    let folder = scene.scenario.folder.as_deref();
    Extras::of_this_machine()
        .with_mesh_of(&scene.mesh_origin, folder)
        .map_err(CliError::input)
}

const RUN_BAR: &str = "{msg:12} {bar:40} {percent:>3} %  {eta}";
