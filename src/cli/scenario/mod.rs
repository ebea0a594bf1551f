//! `dorsum scenario`: what scenarios hold, whether they are sound, and dysfunctions hidden in them at random.

mod printed;

use super::common::{build_scene, load_scenario};
use super::{CliError, Outcome, print, print_json};
use crate::figure::write_files;
use crate::scenario::dysfunction;
use crate::scenario::{Change, RandomSpec, Scenario, SurfaceChoice, Use, random, sites};
use printed::{Printed, PrintedKind, PrintedSite, printed, tell_one};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What to do with scenarios.
#[derive(Debug, clap::Subcommand)]
pub enum ScenarioCommand {
    /// Tell whether scenarios are sound, and which dysfunctions they state. Builds each.
    ///
    /// Exit code 0 if all are, 1 if one is not, 2 if a file cannot be read.
    Check {
        /// Scenario files, or names of examples.
        #[arg(required = true)]
        scenarios: Vec<String>,
    },
    /// List the kinds of dysfunction with their defaults by severity.
    ListKinds,
    /// List the places that a text names, as in "T1-T12 both sides" or "C7,T4-L5 right spinous".
    Sites {
        /// Levels, then a side (left, right, both, middle), then a target (spinous, transverse, rib angle, muscle).
        text: String,
    },
    /// Write a scenario with dysfunctions hidden at random places. Tells their places only with --tell or --json.
    Make(MakeArgs),
}

/// Which dysfunctions, where, how strong.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("strength").required(true).args(["compliance_percent", "stiffness_percent"]))]
pub struct MakeArgs {
    /// Scenario to start from: a file, or the name of an example. Its own dysfunctions stay.
    from: String,
    /// Kind of dysfunction, one of `dorsum scenario list-kinds`.
    #[arg(long, value_name = "KIND")]
    hide: String,
    /// Places to draw from, as in "T1-T12 both sides".
    #[arg(long, value_name = "SITES")]
    among: String,
    /// Change of compliance, percent: -28 yields 38.9 % more stiffness.
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true)]
    compliance_percent: Option<f64>,
    /// Change of stiffness, percent.
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true)]
    stiffness_percent: Option<f64>,
    /// How many, at different places.
    #[arg(long, default_value_t = 1, value_name = "N")]
    count: usize,
    /// The same seed draws the same places on every machine.
    #[arg(long, value_name = "N")]
    seed: u64,
    /// File to write, ending in .toml.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Tell where they are.
    #[arg(long)]
    tell: bool,
}

/// Runs `dorsum scenario`.
///
/// # Errors
/// A scenario cannot be read or written, or is refused; a text names no places.
pub fn run(command: &ScenarioCommand, json: bool) -> Result<Outcome, CliError> {
    match command {
        ScenarioCommand::Check { scenarios } => check(scenarios, json),
        ScenarioCommand::ListKinds => list_kinds(json),
        ScenarioCommand::Sites { text } => list_sites(text, json),
        ScenarioCommand::Make(args) => make(args, json),
    }
}

#[derive(Serialize)]
struct Checked {
    scenario: String,
    sound: bool,
    /// What is wrong, in one line.
    fault: Option<String>,
    name: Option<String>,
    dysfunctions: Vec<Printed>,
}

fn check(scenarios: &[String], json: bool) -> Result<Outcome, CliError> {
    let mut all = Vec::new();
    for name in scenarios {
        if super::common::example(name).is_none() {
            let readable = std::fs::read_to_string(name);
            readable.map_err(|e| CliError::input(format_args!("{name}: cannot be read: {e}")))?;
        }
        let purpose = Use {
            fingers: 1,
            ..Use::default()
        };
        let parsed = load_scenario(name);
        let built = parsed.and_then(|s| build_scene(s, purpose));
        all.push(match built {
            Ok(scene) => Checked {
                scenario: name.clone(),
                sound: true,
                fault: None,
                name: Some(scene.scenario.name.clone()),
                dysfunctions: printed(&scene, 0),
            },
            Err(e) => Checked {
                scenario: name.clone(),
                sound: false,
                fault: Some(e.to_string()),
                name: None,
                dysfunctions: Vec::new(),
            },
        });
    }
    if json {
        print_json(&all)?;
    } else {
        for checked in &all {
            tell(checked);
        }
    }
    Ok(if all.iter().all(|c| c.sound) {
        Outcome::Done
    } else {
        Outcome::DoesNotHold
    })
}

fn tell(checked: &Checked) {
    let name = &checked.scenario;
    match (&checked.fault, checked.dysfunctions.len()) {
        (Some(fault), _) if fault.starts_with(name.as_str()) => print(fault),
        (Some(fault), _) => print(format_args!("{name}: {fault}")),
        (None, 0) => print(format_args!("{name}: sound, no dysfunction")),
        (None, n) => print(format_args!(
            "{name}: sound, {n} dysfunction{}",
            if n == 1 { "" } else { "s" }
        )),
    }
    for (i, d) in checked.dysfunctions.iter().enumerate() {
        tell_one(i, d);
    }
}

fn list_kinds(json: bool) -> Result<Outcome, CliError> {
    let all: Vec<PrintedKind> = dysfunction::all().iter().map(|k| (*k).into()).collect();
    if json {
        print_json(&all)?;
        return Ok(Outcome::Done);
    }
    for kind in &all {
        let [a, b] = kind.radius_mm;
        print(format_args!("{}: {}", kind.kind, kind.title));
        print(format_args!("  {}", kind.about));
        print(format_args!(
            "  {a} × {b} mm, {}°, {}",
            kind.angle_deg, kind.profile
        ));
        for form in &kind.forms {
            if let (Some(preset), Some(about)) = (form.preset, form.about) {
                print(format_args!("  preset {preset}: {about}"));
            }
            for (severity, strength) in form.severities.iter().enumerate().skip(1) {
                print(format_args!("    severity {severity}: {strength}"));
            }
        }
    }
    print("Strengths by severity are assumed; what a scenario states wins.");
    Ok(Outcome::Done)
}

fn list_sites(text: &str, json: bool) -> Result<Outcome, CliError> {
    let all = sites(text).map_err(CliError::input)?;
    let all: Vec<PrintedSite> = all.iter().map(PrintedSite::from).collect();
    if json {
        print_json(&all)?;
        return Ok(Outcome::Done);
    }
    for site in &all {
        print(format_args!(
            "{:<28} {:>7.1} {:>7.1} mm",
            site.site, site.x_mm, site.y_mm
        ));
    }
    Ok(Outcome::Done)
}

fn make(args: &MakeArgs, json: bool) -> Result<Outcome, CliError> {
    let out = args.out.display();
    if args.out.extension().is_none_or(|e| e != "toml") {
        return Err(CliError::input(format_args!(
            "--out {out}: a scenario is written; end it in .toml"
        )));
    }
    let from = load_scenario(&args.from)?;
    finds_its_mesh(&from, &args.out)?;
    let Some(kind) = dysfunction::named(&args.hide) else {
        let keys: Vec<&str> = dysfunction::all().iter().map(|k| k.key()).collect();
        return Err(CliError::input(format_args!(
            "--hide {}: allowed are {}",
            args.hide,
            keys.join(", ")
        )));
    };
    let candidates =
        sites(&args.among).map_err(|e| CliError::input(format_args!("--among {e}")))?;
    let n = candidates.len();
    if !(1..=n).contains(&args.count) {
        return Err(CliError::input(format_args!(
            "--count {}: 1 to {n} is allowed, the number of places",
            args.count
        )));
    }
    let strength = match (args.compliance_percent, args.stiffness_percent) {
        (Some(percent), _) => Change::CompliancePercent(percent),
        (None, percent) => Change::StiffnessPercent(percent.unwrap_or_default()),
    };
    let hidden = random(&RandomSpec {
        kind: kind.key(),
        candidates,
        strength,
        count: args.count,
        seed: args.seed,
    });
    let all = [&from.dysfunctions[..], &hidden[..]].concat();
    let scenario = from.with_dysfunctions(&all).map_err(CliError::input)?;
    // Nothing is written that would be refused.
    let purpose = Use {
        fingers: 1,
        ..Use::default()
    };
    let scene = build_scene(scenario, purpose)?;
    let text = scene.scenario.source.clone().into_bytes();
    write_files(&[(args.out.clone(), text)])
        .map_err(|e| CliError::input(format_args!("{out}: cannot be written: {e}")))?;
    let printed = printed(&scene, from.dysfunctions.len());
    if json {
        print_json(&serde_json::json!({
            "file": args.out.display().to_string(),
            "seed": args.seed,
            "candidates": n,
            "hidden": printed,
        }))?;
        return Ok(Outcome::Done);
    }
    print(format_args!(
        "{out}: {} {} among {n} places, {strength}",
        args.count,
        kind.key()
    ));
    if args.tell {
        for (i, d) in printed.iter().enumerate() {
            tell_one(i, d);
        }
    }
    Ok(Outcome::Done)
}

/// A mesh is looked for from the folder of its scenario.
fn finds_its_mesh(from: &Scenario, out: &Path) -> Result<(), CliError> {
    if !matches!(from.surface, SurfaceChoice::Mesh { .. }) {
        return Ok(());
    }
    let whole = |folder: Option<&Path>| {
        let folder = folder.filter(|f| !f.as_os_str().is_empty());
        folder.unwrap_or(Path::new(".")).canonicalize().ok()
    };
    let here = whole(from.folder.as_deref());
    if here.is_some() && here == whole(out.parent()) {
        return Ok(());
    }
    Err(CliError::input(format_args!(
        "--out {}: the scenario's mesh would not be found from there; write into the folder of the scenario",
        out.display()
    )))
}
