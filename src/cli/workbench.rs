//! `dorsum` without a subcommand: opens the workbench, or does the main job where no window can be opened.

use super::headless;
use super::{CliError, Outcome};
use std::path::PathBuf;

/// What to open and how.
#[derive(Debug, clap::Args)]
pub struct WorkbenchArgs {
    /// Scenario to open: a file, or the name of an example.
    #[arg(long)]
    scenario: Option<String>,
    /// Do the main job without a window: palpate, record, replay, write pictures.
    #[arg(long)]
    headless: bool,
    /// Folder for what the headless job writes; otherwise the user's data folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the time from start to the first frame and leave.
    #[arg(long)]
    first_frame: bool,
    /// Write a picture of the window once it is up, and leave.
    #[arg(long, value_name = "FILE.png")]
    screenshot: Option<PathBuf>,
    /// Let the fingers press by themselves.
    #[arg(long)]
    press: bool,
    /// With --screenshot: how long the scene is on show before, s.
    #[arg(long, value_name = "S", default_value_t = 3.0)]
    after_s: f64,
    /// Whose workspace opens; otherwise as chosen last.
    #[arg(long, value_enum)]
    role: Option<Role>,
    /// Open the trainee's own window too.
    #[arg(long)]
    trainee_window: bool,
    /// Bring this panel to the front (its key, such as "scene").
    #[arg(long, value_name = "PANEL")]
    panel: Option<String>,
    /// Colour the skin by this: skin, strain, displacement, stiffness, half-major, ratio or direction; otherwise as chosen
    /// last.
    #[arg(long, value_name = "NAME")]
    colour: Option<String>,
    /// Draw the skin like this: opaque, translucent or off; otherwise as chosen last.
    #[arg(long, value_name = "LOOK")]
    skin: Option<String>,
    /// Show these: bones, landmarks, hands, with commas between, or none; otherwise as chosen last. Opaque skin hides bones.
    #[arg(long, value_name = "PARTS")]
    anatomy: Option<String>,
    /// Draw for two eyes: parallel, cross-eyed or anaglyph; otherwise as chosen last.
    #[arg(long, value_name = "MODE")]
    stereo: Option<String>,
    /// The experiment that the Lab panel shows; otherwise as chosen last.
    #[arg(long, value_name = "NAME")]
    experiment: Option<String>,
    /// Attach a simulated device of this family, in a simulated hand: woodenhaptics, polhem or polhem-teensy.
    #[arg(long, value_name = "FAMILY")]
    emulator: Option<String>,
    /// What goes wrong with it once it is pressed: unplugged, frozen, silent, jump, extreme, short, slow, reversed.
    #[arg(long, value_name = "FAULT", requires = "emulator")]
    fault: Option<String>,
    /// A recording to replay at once.
    #[arg(long, value_name = "FILE.mcap")]
    recording: Option<PathBuf>,
    /// Colours of the window; otherwise as chosen last.
    #[arg(long, value_enum)]
    theme: Option<Theme>,
    /// Size of the window, points.
    #[arg(long, value_name = "WxH", default_value = "1280x800", value_parser = size)]
    size: (u16, u16),
}

/// Colours of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Theme {
    Dark,
    Light,
}

/// Whose workspace.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Role {
    Instructor,
    Trainee,
    Researcher,
}

fn size(text: &str) -> Result<(u16, u16), String> {
    let numbers = text
        .split_once('x')
        .and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    numbers
        .filter(|&(w, h): &(u16, u16)| (640..=7680).contains(&w) && (420..=4320).contains(&h))
        .ok_or_else(|| "two numbers from 640x420 to 7680x4320 are allowed".into())
}

/// Opens the workbench; without a display does the main job headless and says why.
///
/// # Errors
/// The scenario is refused, or the window or the headless job fails.
pub fn run(args: &WorkbenchArgs, json: bool) -> Result<Outcome, CliError> {
    if args.headless {
        return headless::run(args.scenario.as_deref(), args.out.as_deref(), json);
    }
    match open(args) {
        Ok(outcome) => outcome,
        Err(reason) if args.first_frame || args.screenshot.is_some() => {
            Err(CliError::input(reason))
        }
        Err(reason) => {
            eprintln!("dorsum: {reason}; doing the main job without a window");
            headless::run(args.scenario.as_deref(), args.out.as_deref(), json)
        }
    }
}

/// Opens the window. The outer error says why none can be opened at all.
#[cfg(feature = "gui")]
fn open(args: &WorkbenchArgs) -> Result<Result<Outcome, CliError>, String> {
    crate::app::can_open()?;
    let options = match options(args) {
        Ok(options) => options,
        Err(e) => return Ok(Err(e)),
    };
    Ok(crate::app::run(options)
        .map(|()| Outcome::Done)
        .map_err(CliError::input))
}

#[cfg(feature = "gui")]
fn options(args: &WorkbenchArgs) -> Result<crate::app::Options, CliError> {
    use crate::app::{Options, Screenshot, Source};
    let source = |name: &String| match super::common::example(name) {
        Some(example) => Ok(Source::Example(example)),
        // Refused here, a bad scenario is told in one line instead of in a window.
        None => super::common::load_scenario(name).map(|_| Source::File(name.into())),
    };
    if let Some(key) = &args.colour {
        crate::app::colours::named(key).map_err(CliError::input)?;
    }
    if let Some(name) = &args.experiment
        && !crate::lab::all().iter().any(|e| e.name() == name)
    {
        let names: Vec<_> = crate::lab::all().iter().map(|e| e.name()).collect();
        return Err(CliError::input(format_args!(
            "--experiment {name}: there are {}",
            names.join(", ")
        )));
    }
    Ok(Options {
        look: look(args)?,
        source: args.scenario.as_ref().map(source).transpose()?,
        first_frame: args.first_frame,
        screenshot: args.screenshot.clone().map(|path| Screenshot {
            path,
            after_s: args.after_s,
        }),
        press: args.press,
        dark: args.theme.map(|theme| theme == Theme::Dark),
        role: args.role.map(|role| match role {
            Role::Instructor => crate::app::roles::Role::Instructor,
            Role::Trainee => crate::app::roles::Role::Trainee,
            Role::Researcher => crate::app::roles::Role::Researcher,
        }),
        trainee_window: args.trainee_window,
        panel: args.panel.clone(),
        colour: args.colour.clone(),
        experiment: args.experiment.clone(),
        size: args.size,
        recording: args.recording.clone(),
        emulator: emulator(args)?,
        ..Options::default()
    })
}

/// The simulated device that is asked for: its family, and what goes wrong with it.
#[cfg(all(feature = "gui", target_os = "linux"))]
fn emulator(
    args: &WorkbenchArgs,
) -> Result<Option<(&'static str, Option<&'static str>)>, CliError> {
    use crate::device::Family as _;
    use crate::device::hid::emulator::{Fault, process::family};
    let Some(key) = &args.emulator else {
        return Ok(None);
    };
    let arms = family(key).map_err(CliError::input)?;
    let fault = match &args.fault {
        None => None,
        Some(name) => Some(Fault::by_key(name).ok_or_else(|| {
            let names = Fault::ALL.map(Fault::key).join(", ");
            CliError::input(format_args!("--fault \"{name}\"; allowed are {names}"))
        })?),
    };
    Ok(Some((arms.key(), fault.map(Fault::key))))
}

#[cfg(all(feature = "gui", not(target_os = "linux")))]
fn emulator(
    args: &WorkbenchArgs,
) -> Result<Option<(&'static str, Option<&'static str>)>, CliError> {
    match &args.emulator {
        None => Ok(None),
        Some(_) => Err(CliError::input("emulated devices need Linux")),
    }
}

/// How the Back view shows the body, in its own words.
#[cfg(feature = "gui")]
fn look(args: &WorkbenchArgs) -> Result<Vec<String>, CliError> {
    use crate::app::panels::back_view::options::{Anatomy, LOOKS, look_named};
    use crate::app::stereo::Mode;
    let mut words = Vec::new();
    if let Some(name) = &args.skin {
        if look_named(name).is_none() {
            let known = LOOKS.map(|(_, known)| known).join(", ");
            return Err(CliError::input(format_args!(
                "--skin {name}: there are {known}"
            )));
        }
        words.push(format!("skin={name}"));
    }
    if let Some(parts) = &args.anatomy {
        Anatomy::named(parts).map_err(|e| CliError::input(format_args!("--anatomy {e}")))?;
        words.push(format!("anatomy={}", parts.replace(' ', "")));
    }
    if let Some(name) = &args.stereo {
        if Mode::named(name).is_none() {
            let known = Mode::ALL.map(Mode::key).join(", ");
            return Err(CliError::input(format_args!(
                "--stereo {name}: there are {known}"
            )));
        }
        words.push(format!("stereo={name}"));
    }
    Ok(words)
}

#[cfg(not(feature = "gui"))]
fn open(_args: &WorkbenchArgs) -> Result<Result<Outcome, CliError>, String> {
    Err("this build has no window (feature \"gui\" is off)".into())
}
