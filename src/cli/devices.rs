//! `dorsum devices`: which devices are known and attached, what they can do, how they were tested; whether the loop holds.

use super::attached::stable_line;
use super::common::progress_bar;
use super::{CliError, Outcome, print, print_json};
use crate::device::calibration;
use crate::device::hid::check::{self, Checked, Trial};
use crate::device::hid::emulator::Outcome as Truth;
use crate::device::mapped::on_subject;
use crate::device::stable::Stable;
use crate::device::{Calibration, Capabilities, Device, Family, Found, Proof, all};
use crate::servo;
use std::path::PathBuf;

/// What is asked.
#[derive(Debug, clap::Args)]
pub struct DevicesArgs {
    /// Try the loop with what is attached: rate, latency, lost reports. Moves nothing.
    #[arg(long)]
    test: bool,
    /// Try the loop with an emulated device of this family, which a simulated hand presses into a plane of skin.
    #[arg(long, value_name = "FAMILY")]
    emulator: Option<String>,
    /// What goes wrong with the emulated device once it is pressed: unplugged, frozen, silent, jump, extreme, short, slow, reversed.
    #[arg(long, value_name = "FAULT", requires = "emulator")]
    fault: Option<String>,
    /// How long the loop is tried, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 3.0)]
    seconds: f64,
    /// Folder of the device files, instead of the user's.
    #[arg(long, value_name = "FOLDER")]
    folder: Option<PathBuf>,
}

/// Stiffness of the skin that an emulated hand presses, N/mm.
const SKIN_N_PER_MM: f64 = 0.5;

#[derive(serde::Serialize)]
struct PrintedFamily {
    key: &'static str,
    title: &'static str,
    about: &'static str,
    reached: &'static str,
    tested: Proof,
    /// What keeps devices from being looked for.
    missing: Option<String>,
    capabilities: PrintedCapabilities,
    /// How stiff a skin it renders stably at 1 kHz, by four answers.
    stable: Stable,
    found: Vec<PrintedFound>,
}

#[derive(serde::Serialize)]
struct PrintedFound {
    #[serde(flatten)]
    found: Found,
    /// Why its device file is refused.
    refused: Option<String>,
    capabilities: Option<PrintedCapabilities>,
    stable: Option<Stable>,
    test: Option<PrintedTest>,
}

/// Bounds that are not there are `null`.
#[derive(serde::Serialize)]
struct PrintedCapabilities {
    name: String,
    position_axes: u8,
    force_axes: u8,
    rated_force_n: f64,
    continuous_force_n: f64,
    max_stiffness_n_per_mm: Option<f64>,
    workspace_radius_mm: Option<f64>,
    resolution_mm: f64,
    buttons: u8,
    report_rate_hz: f64,
}

impl From<Capabilities> for PrintedCapabilities {
    fn from(c: Capabilities) -> Self {
        let bound = |x: f64| x.is_finite().then_some(x);
        Self {
            max_stiffness_n_per_mm: bound(c.max_stiffness_n_per_mm),
            workspace_radius_mm: bound(c.workspace_radius_mm),
            name: c.name,
            position_axes: c.position_axes,
            force_axes: c.force_axes,
            rated_force_n: c.rated_force_n,
            continuous_force_n: c.continuous_force_n,
            resolution_mm: c.resolution_mm,
            buttons: c.n_buttons,
            report_rate_hz: c.report_rate_hz,
        }
    }
}

#[derive(serde::Serialize)]
struct PrintedTest {
    holds: bool,
    fault: Option<String>,
    #[serde(flatten)]
    checked: Option<Checked>,
    /// Against the truth of the emulator, mm; only there, and with force.
    #[serde(skip_serializing_if = "Option::is_none")]
    position_error_mm: Option<f64>,
    /// Against the truth of the emulator, N; only there.
    #[serde(skip_serializing_if = "Option::is_none")]
    force_error_n: Option<f64>,
    /// What the emulator says; only there.
    #[serde(skip_serializing_if = "Option::is_none")]
    truth: Option<Truth>,
}

/// Where the user's device files are.
pub(super) fn users_folder() -> Option<PathBuf> {
    directories::ProjectDirs::from("", "", "dorsum").map(|d| d.config_dir().join("devices"))
}

/// Lists devices, or tries the loop.
///
/// # Errors
/// Options that make no sense, no emulator of that name.
pub fn run(args: &DevicesArgs, json: bool) -> Result<Outcome, CliError> {
    if !(0.1..=3600.0).contains(&args.seconds) {
        let what = format_args!("--seconds {}; 0.1 to 3600 is allowed", args.seconds);
        return Err(CliError::input(what));
    }
    if let Some(key) = &args.emulator {
        return emulated(key, args, json);
    }
    let folder = args.folder.clone().or_else(users_folder);
    let families: Vec<PrintedFamily> = all()
        .iter()
        .map(|family| look(*family, folder.as_deref(), args))
        .collect();
    let tests = families.iter().flat_map(|f| &f.found);
    let failed = tests.clone().any(|f| f.refused.is_some() && args.test)
        || tests.filter_map(|f| f.test.as_ref()).any(|t| !t.holds);
    if json {
        print_json(&families)?;
    } else {
        show(&families, args.test);
    }
    Ok(if failed {
        Outcome::DoesNotHold
    } else {
        Outcome::Done
    })
}

fn look(
    family: &'static dyn Family,
    folder: Option<&std::path::Path>,
    args: &DevicesArgs,
) -> PrintedFamily {
    let missing = family.ready().err().map(|e| e.to_string());
    let found = if missing.is_none() {
        family.find()
    } else {
        Vec::new()
    };
    let found = found
        .into_iter()
        .map(|found| {
            let defaults = family.defaults();
            let calibration = match folder {
                Some(folder) => calibration::load(folder, found.serial.as_deref(), &defaults),
                None => Ok(defaults),
            };
            match calibration {
                Ok(c) => PrintedFound {
                    test: args.test.then(|| tried(family, &found, &c, args.seconds)),
                    capabilities: Some(family.capabilities(&c).into()),
                    stable: Some(stable(family, &c)),
                    refused: None,
                    found,
                },
                Err(e) => PrintedFound {
                    found,
                    refused: Some(e.to_string()),
                    capabilities: None,
                    stable: None,
                    test: None,
                },
            }
        })
        .collect();
    PrintedFamily {
        key: family.key(),
        title: family.title(),
        about: family.about(),
        reached: family.reached(),
        tested: family.proof(),
        missing,
        capabilities: family.capabilities(&family.defaults()).into(),
        stable: stable(family, &family.defaults()),
        found,
    }
}

fn stable(family: &dyn Family, calibration: &Calibration) -> Stable {
    let capabilities = on_subject(&family.capabilities(calibration), &calibration.mapping);
    Stable::of(&capabilities, calibration, 1000.0)
}

fn tried(family: &dyn Family, found: &Found, c: &Calibration, seconds: f64) -> PrintedTest {
    match family.open(found, c) {
        Err(e) => PrintedTest {
            holds: false,
            fault: Some(e.to_string()),
            checked: None,
            position_error_mm: None,
            force_error_n: None,
            truth: None,
        },
        Ok(mut device) => {
            let checked = tick(&mut *device, seconds, 0.0);
            device.close();
            let fault = checked.fault(device.capabilities().report_rate_hz);
            PrintedTest {
                holds: fault.is_none(),
                fault,
                checked: Some(checked),
                position_error_mm: None,
                force_error_n: None,
                truth: None,
            }
        }
    }
}

fn tick(device: &mut dyn Device, seconds: f64, skin_n_per_mm: f64) -> Checked {
    let bar = progress_bar(1000, "{msg:32} {bar:30} {percent:>3} %");
    bar.set_message(device.capabilities().name.clone());
    let _running = servo::Running::new();
    let trial = Trial {
        seconds,
        rate_hz: 1000.0,
        skin_n_per_mm,
    };
    let mut shown = 0;
    let checked = check::run(device, &trial, |done, _| {
        let now = (done * 100.0) as u64;
        if now != shown {
            shown = now;
            bar.set_position(now * 10);
        }
        servo::halted().is_none()
    });
    bar.finish_and_clear();
    checked
}

#[cfg(target_os = "linux")]
fn emulated(key: &str, args: &DevicesArgs, json: bool) -> Result<Outcome, CliError> {
    use crate::device::hid::emulator::Fault;
    use crate::device::hid::emulator::process::{Emulated, Request, family};
    use crate::geom::Vec3;
    let arms = family(key).map_err(CliError::input)?;
    let fault = match &args.fault {
        None => None,
        Some(name) => Some(Fault::by_key(name).ok_or_else(|| {
            let names = Fault::ALL.map(Fault::key).join(", ");
            CliError::input(format_args!("--fault \"{name}\"; allowed are {names}"))
        })?),
    };
    let program = std::env::current_exe().map_err(CliError::input)?;
    let request = Request {
        // It is to be there until the host goes.
        seconds: args.seconds + 60.0,
        fault,
        ..Request::press(arms.key())
    };
    let (emulator, port) = Emulated::spawn(&program, &request).map_err(CliError::input)?;
    let mut device = arms
        .open_port(port, &arms.defaults())
        .map_err(CliError::input)?;
    let checked = tick(&mut device, args.seconds, SKIN_N_PER_MM);
    let nominal_hz = device.capabilities().report_rate_hz;
    drop(device);
    let truth = emulator.outcome().map_err(CliError::input)?;
    // The truth is told in the device's own frame.
    let laid = arms.defaults().mapping.subject_from_device();
    let off = |a: [f64; 3], b: [f64; 3]| Vec3::from_array(a).distance(laid * Vec3::from_array(b));
    let wrong = if !truth.ended_at_zero {
        Some("currents flowed after closing".to_owned())
    } else if fault.is_none() {
        checked.fault(nominal_hz)
    } else if truth.fault_n.is_none() {
        Some("it never came to be pressed: no fault was tried; give it more --seconds".to_owned())
    } else {
        let never = "currents never ended".to_owned();
        truth.zero_after_ms.is_none().then_some(never)
    };
    // Where the machine held the loop up the force is off, and there is nothing to compare.
    let whole = fault.is_none() && checked.force_n != [0.0; 3];
    let printed = PrintedTest {
        holds: wrong.is_none(),
        fault: wrong,
        position_error_mm: whole.then(|| off(checked.position_mm, truth.pressed_position_mm)),
        force_error_n: whole.then(|| off(checked.force_n, truth.pressed_force_n)),
        checked: Some(checked),
        truth: Some(truth),
    };
    let holds = printed.holds;
    if json {
        print_json(&printed)?;
    } else {
        print(format_args!("{}, emulated", arms.title()));
        show_test(&printed);
    }
    Ok(if holds {
        Outcome::Done
    } else {
        Outcome::DoesNotHold
    })
}

#[cfg(not(target_os = "linux"))]
fn emulated(_key: &str, _args: &DevicesArgs, _json: bool) -> Result<Outcome, CliError> {
    Err(CliError::input("emulated devices need Linux"))
}

fn show(families: &[PrintedFamily], tested: bool) {
    for family in families {
        let c = &family.capabilities;
        print(format_args!("{} ({})", family.title, family.key));
        print(format_args!("  {}", family.about));
        print(format_args!(
            "  {}; tested {}",
            family.reached,
            family.tested.title()
        ));
        print(format_args!("  {}", told(c)));
        if c.force_axes > 0 {
            print(format_args!("  {}", stable_line(&family.stable)));
        }
        match &family.missing {
            Some(missing) => print(format_args!("  {missing}")),
            None if family.found.is_empty() => print("  none attached"),
            None => {}
        }
        for f in &family.found {
            let serial = f.found.serial.as_deref();
            let serial = serial.map_or(String::new(), |s| format!(", serial number {s}"));
            print(format_args!(
                "  attached: {}, {}{serial}",
                f.found.title, f.found.place
            ));
            for line in [&f.found.note, &f.refused].into_iter().flatten() {
                print(format_args!("    {line}"));
            }
            if let Some(c) = &f.capabilities {
                print(format_args!("    {}", told(c)));
            }
            if let Some(stable) = f.stable.filter(|s| s.told_n_per_mm.is_finite()) {
                print(format_args!("    {}", stable_line(&stable)));
            }
            if let Some(test) = &f.test {
                show_test(test);
            }
        }
    }
    for gamepad in crate::device::rumble::find() {
        print(format_args!(
            "Force indicator: {}, {}: rumbles with the force, renders none",
            gamepad.title, gamepad.place
        ));
    }
    if tested && families.iter().all(|f| f.found.is_empty()) {
        print(
            "nothing is attached that could be tested; --emulator FAMILY tries an emulated device",
        );
    }
}

fn told(c: &PrintedCapabilities) -> String {
    let mut parts = Vec::new();
    if c.force_axes > 0 {
        parts.push(format!("{} N", c.rated_force_n));
        if let Some(k) = c.max_stiffness_n_per_mm {
            parts.push(format!("{k} N/mm at 1 kHz"));
        }
    } else {
        parts.push("no force".into());
    }
    if let Some(r) = c.workspace_radius_mm {
        parts.push(format!("{r} mm around its middle"));
    }
    if c.resolution_mm > 0.0 {
        parts.push(format!("resolves {:.3} mm", c.resolution_mm));
    }
    if c.report_rate_hz > 0.0 {
        parts.push(format!("{} reports a second", c.report_rate_hz));
    }
    if c.buttons > 0 {
        parts.push(format!("buttons: {}", c.buttons));
    }
    parts.join(", ")
}

fn show_test(test: &PrintedTest) {
    if let Some(c) = &test.checked {
        let us = |x: Option<f64>| x.map_or("none".to_owned(), |us| format!("{us:.0} µs"));
        print(format_args!(
            "    {:.0} reports a second over {:.1} s, between them {} (99 % {})",
            c.report_rate_hz,
            c.seconds,
            us(c.interval_median_us),
            us(c.interval_p99_us)
        ));
        if let Some(n) = c.counts {
            print(format_args!(
                "    {} reports, {} lost, {} passed over for a newer one, {} not understood",
                n.reports, n.lost, n.skipped, n.not_understood
            ));
        }
        if c.ticks_without > 0 {
            print(format_args!(
                "    without an answer in {} of {} ticks: no force then",
                c.ticks_without, c.ticks
            ));
        }
        print(format_args!(
            "    from a report to the currents that answer it {} (99 % {})",
            us(c.latency_median_us),
            us(c.latency_p99_us)
        ));
    }
    if let (Some(mm), Some(n)) = (test.position_error_mm, test.force_error_n) {
        print(format_args!("    off the truth by {mm:.3} mm and {n:.3} N"));
    }
    if let (Some(c), Some(truth)) = (&test.checked, &test.truth)
        && let (Some(n), Some(ms)) = (truth.fault_n, truth.zero_after_ms)
    {
        let found = c.condition.map_or("nothing", |c| c.title());
        print(format_args!(
            "    it failed at {n:.2} N: no current after {ms:.1} ms, {:.2} N at most; the link says: {found}",
            truth.highest_since_n
        ));
    }
    match &test.fault {
        None if test.truth.as_ref().is_some_and(|t| t.fault_n.is_some()) => {
            print("    the force was taken off");
        }
        None => print("    the loop holds"),
        Some(fault) => print(format_args!("    does not hold: {fault}")),
    }
}
