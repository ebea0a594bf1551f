//! `dorsum run`: the full servo loop with a scripted device, without a window.

use super::attached::{Hand, HandsArgs, Told};
use super::common::{build_scene, load_scenario, parse_place, progress_bar};
use super::live::{Live, extras, header};
use super::summary::Summary;
use super::{CliError, Outcome, print, print_json};
use crate::device::Device;
use crate::device::scripted::{Script, Scripted, Trajectory};
use crate::scenario::{Scene, Use};
use crate::servo::{self, Limits, MAX_FINGERS, Rig};
use crate::session::writer::{IfExists, SessionWriter};
use crate::session::{DeviceInfo, compress};
use std::path::{Path, PathBuf};

/// Which scenario, which motion, what becomes of it.
#[derive(Debug, clap::Args)]
pub struct RunArgs {
    /// Scenario file, or the name of an example.
    scenario: String,
    /// Motion of the fingers: CSV with columns t,x,y,z[,finger] in s and mm.
    #[arg(long, value_name = "TRAJ.csv", conflicts_with_all = ["script", "device", "emulator"])]
    path: Option<PathBuf>,
    /// Motion by name: press, slide, circle, spiral or tap.
    #[arg(long, value_name = "NAME", value_parser = script_by_name, conflicts_with_all = ["device", "emulator"])]
    script: Option<Script>,
    /// Where a script presses on the map plane, or where the middle of a device's workspace is laid, mm.
    #[arg(long, value_name = "X,Y", value_parser = parse_place, conflicts_with = "path", allow_hyphen_values = true)]
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
    #[arg(long, conflicts_with_all = ["device", "emulator"])]
    fast: bool,
    #[command(flatten)]
    hands: HandsArgs,
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
    #[serde(skip_serializing_if = "Vec::is_empty")]
    hands: Vec<Told>,
    summary: Summary,
    recorded: Option<PathBuf>,
    lost_ticks: u64,
    /// Why it ended before its time, if it did.
    ended_early: Option<String>,
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
        fingers: args.hands.n().max(1),
        recorded: args.record.is_some(),
        passivity: args.passivity,
        ..Use::default()
    };
    let scene = build_scene(load_scenario(&args.scenario)?, purpose)?;
    if args.hands.n() > 0 {
        return with_devices(args, &scene, json);
    }
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
                "a motion is needed: --path TRAJ.csv, --script NAME, --device FAMILY or --emulator FAMILY",
            ));
        }
    };
    let plan = Plan {
        rate_hz: args.rate,
        trajectories,
        passivity: args.passivity,
    };
    let target = target(args);
    let (summary, lost_ticks) = if args.fast {
        plan.run_fast(&scene, target)?
    } else {
        plan.run_live(&scene, target)?
    };
    finish(args)?;
    let printed = Printed {
        scenario: scene.scenario.name.clone(),
        motion,
        real_time: !args.fast,
        passivity: args.passivity,
        hands: Vec::new(),
        summary,
        recorded: args.record.clone(),
        lost_ticks,
        ended_early: servo::halted().map(|h| h.title().to_owned()),
    };
    printed.show(json)?;
    Ok(servo::halted().map_or(Outcome::Done, Outcome::Halted))
}

impl Printed {
    fn show(&self, json: bool) -> Result<(), CliError> {
        if json {
            return print_json(self);
        }
        print(format_args!("{} · {}", self.scenario, self.motion));
        for hand in &self.hands {
            print(format_args!("{hand}"));
        }
        print(format_args!("{}", self.summary));
        if let Some(path) = &self.recorded {
            print(format_args!("lost ticks    {:>8}", self.lost_ticks));
            print(format_args!("recorded to {}", path.display()));
        }
        if let Some(why) = &self.ended_early {
            eprintln!("dorsum: ended early: {why}");
        }
        Ok(())
    }
}

/// Runs with the devices that are asked for, until their time is over or one of them goes.
fn with_devices(args: &RunArgs, scene: &Scene, json: bool) -> Result<Outcome, CliError> {
    let (hands, devices) = args.hands.open(scene, args.at, args.rate)?;
    let mut limits = [Limits::default(); MAX_FINGERS];
    for (limit, hand) in limits.iter_mut().zip(&hands) {
        *limit = Limits {
            passivity: args.passivity,
            stiffness: hand.bound,
            ..Limits::of(&hand.capabilities)
        };
    }
    let names = hands.iter().map(|h| h.capabilities.name.clone());
    let names: Vec<String> = names.collect();
    let infos = names
        .iter()
        .zip(&limits)
        .map(|(n, l)| DeviceInfo::new(n, l));
    let live = Live {
        rate_hz: args.rate,
        n_ticks: (args.hands.seconds() * args.rate).ceil() as u64,
        limits,
        infos: infos.collect(),
        calibrations: hands.iter().map(|h| h.calibration.to_toml()).collect(),
    };
    // Each is looked at, also behind one that went.
    let gone = || hands.iter().filter_map(Hand::gone).reduce(|first, _| first);
    let (summary, lost_ticks) = live.run(scene, target(args), devices, &gone)?;
    finish(args)?;
    let ended = gone();
    let printed = Printed {
        scenario: scene.scenario.name.clone(),
        motion: names.join(", "),
        real_time: true,
        passivity: args.passivity,
        hands: hands
            .into_iter()
            .map(Hand::told)
            .collect::<Result<_, _>>()?,
        summary,
        recorded: args.record.clone(),
        lost_ticks,
        ended_early: match servo::halted() {
            Some(h) => Some(h.title().to_owned()),
            None => ended.clone(),
        },
    };
    printed.show(json)?;
    Ok(match (servo::halted(), ended) {
        (Some(h), _) => Outcome::Halted(h),
        (None, Some(_)) => Outcome::DoesNotHold,
        (None, None) => Outcome::Done,
    })
}

fn target(args: &RunArgs) -> Target<'_> {
    let if_exists = if args.overwrite {
        IfExists::Replace
    } else {
        IfExists::Refuse
    };
    args.record.as_deref().map(|path| (path, if_exists))
}

/// Compresses the recording where that is asked for and nobody wants to be gone.
fn finish(args: &RunArgs) -> Result<(), CliError> {
    let wanted = args.compress && servo::halted().is_none();
    if let Some(path) = args.record.as_deref().filter(|_| wanted) {
        let bar = progress_bar(1000, "compressing  {bar:40} {percent:>3} %  {eta}");
        let compressed = compress(path, &mut |done| {
            bar.set_position((done * 1000.0) as u64);
            servo::halted().is_none()
        });
        bar.finish_and_clear();
        if servo::halted().is_none() {
            compressed.map_err(CliError::input)?;
        }
    }
    Ok(())
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

/// The file to record into.
pub(super) type Target<'a> = Option<(&'a Path, IfExists)>;

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

    fn infos(&self) -> Vec<DeviceInfo> {
        let devices = self.devices();
        let named = devices.iter().zip(self.limits());
        named
            .map(|(d, limits)| DeviceInfo::new(&d.capabilities().name, &limits))
            .collect()
    }

    /// As fast as it goes, on this thread. Returns the summary and the number of ticks lost to the recorder.
    fn run_fast(&self, scene: &Scene, target: Target<'_>) -> Result<(Summary, u64), CliError> {
        let mut writer = match target {
            Some((path, if_exists)) => Some(
                SessionWriter::create_with(
                    path,
                    &header(scene, self.rate_hz, self.infos()),
                    &extras(scene)?,
                    if_exists,
                )
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
        let live = Live {
            rate_hz: self.rate_hz,
            n_ticks: self.n_ticks(),
            limits: self.limits(),
            infos: self.infos(),
            calibrations: Vec::new(),
        };
        live.run(scene, target, self.devices(), &|| None)
    }
}

pub(super) const RUN_BAR: &str = "{msg:12} {bar:40} {percent:>3} %  {eta}";
