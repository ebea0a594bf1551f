//! `dorsum replay`: repeats a recorded session from its device readings and compares.

use super::common::{build_scene, progress_bar};
use super::otherwise::OtherwiseArgs;
use super::summary::Summary;
use super::{CliError, Outcome, print, print_json};
use crate::scenario::{self, Scenario, Scene, Use};
use crate::servo::Rig;
use crate::session::{
    CheckReport, Damage, Divergence, Edit, Header, Rebuild, Session, Strictness, check_edited,
};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Which session, and what it is to be compared with.
#[derive(Debug, clap::Args)]
pub struct ReplayArgs {
    /// The session.
    file: PathBuf,
    /// Repeat it in this scenario instead of the one recorded with it; the surface must be the same.
    #[arg(long, value_name = "S.toml")]
    scenario: Option<PathBuf>,
    /// Exit with 1 unless every tick comes out as recorded, bit for bit.
    #[arg(long)]
    check: bool,
    #[command(flatten)]
    otherwise: OtherwiseArgs,
}

#[derive(serde::Serialize)]
struct Printed<'a> {
    file: &'a Path,
    bytes: u64,
    scenario: &'a str,
    started_utc: &'a str,
    build: &'a str,
    participant: Option<&'a str>,
    surface: &'a str,
    triangles: usize,
    rate_hz: f64,
    devices: Vec<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    summary: Option<Summary>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bit_exact: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    replay: Option<CheckReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    otherwise: Option<Divergence>,
}

/// Repeats the session and says what it was and whether it came out the same.
///
/// # Errors
/// The session cannot be read, its scene cannot be rebuilt, or it was recorded on another surface.
pub fn run(args: &ReplayArgs, json: bool) -> Result<Outcome, CliError> {
    let session = Session::open(&args.file).map_err(CliError::input)?;
    let header = session.header();
    args.otherwise.check(header.n_fingers())?;
    let purpose = Use {
        fingers: header.n_fingers(),
        ..Use::default()
    };
    let folder = session.folder().map_err(CliError::input)?;
    let scene = build_scene(scenario_of(args, header, folder.path())?, purpose)?;
    let rig = || Rig::new(Box::new(scene.touch.clone()), header.limits());
    let rebuild = |edit: &Edit| edited(args, &scene, edit, purpose).map(|s: Scene| s.touch);
    let mut summary = Summary::new(header.dt_s());
    // Felt otherwise, there is nothing to be equal to.
    let report = match args.otherwise.is_other() {
        false => Some(checked(&session, rig(), Box::new(rebuild), &mut summary)?),
        true => None,
    };
    let otherwise = if args.otherwise.is_wanted() {
        // In a scenario of one's own the recorded edits mean nothing.
        let rebuild: Option<Rebuild<'_>> = match args.scenario {
            Some(_) => None,
            None => Some(Box::new(rebuild)),
        };
        Some(args.otherwise.run(&session, rig(), rebuild)?)
    } else {
        None
    };
    let holds = report.as_ref().is_none_or(|report| {
        report.is_bit_exact() && report.damage.chunks == 0 && report.damage.messages == 0
    });
    let printed = Printed {
        file: &args.file,
        bytes: session.bytes(),
        scenario: &header.scenario_name,
        started_utc: &header.started_utc,
        build: &header.build,
        participant: header.participant.as_deref(),
        surface: &header.mesh.origin,
        triangles: header.mesh.triangles,
        rate_hz: header.rate_hz,
        devices: header.devices.iter().map(|d| d.name.as_str()).collect(),
        summary: report.as_ref().map(|_| summary),
        bit_exact: report.as_ref().map(|_| holds),
        replay: report,
        otherwise,
    };
    if json {
        print_json(&printed)?;
    } else {
        tell(&printed);
        if let Some(found) = &printed.otherwise {
            args.otherwise.tell(found);
        }
    }
    Ok(if holds || !args.check {
        Outcome::Done
    } else {
        Outcome::DoesNotHold
    })
}

fn checked(
    session: &Session,
    rig: Rig,
    rebuild: Rebuild<'_>,
    summary: &mut Summary,
) -> Result<CheckReport, CliError> {
    let bar = progress_bar(1000, "replaying    {bar:40} {percent:>3} %  {eta}");
    // Lenient: a killed recording is replayed as far as it goes, and the report tells what is missing.
    let report = check_edited(session, rig, rebuild, Strictness::Lenient, |pair, done| {
        for record in pair.recorded.fingers() {
            summary.add(record);
        }
        if summary.ticks.is_multiple_of(1024) {
            bar.set_position((done * 1000.0) as u64);
        }
    });
    bar.finish_and_clear();
    report.map_err(CliError::input)
}

/// The scene after an edit. In a scenario of one's own the recorded edits mean nothing: it stays as it is.
fn edited(args: &ReplayArgs, scene: &Scene, edit: &Edit, purpose: Use) -> Result<Scene, String> {
    if args.scenario.is_some() {
        return Ok(scene.clone());
    }
    let origin = format!("{}: edit {}", args.file.display(), edit.number);
    let folder = scene.scenario.folder.as_deref();
    let text = args.otherwise.varied(&edit.scenario_toml)?;
    let scenario = Scenario::parse(&text, &origin, folder);
    let scenario = scenario.map_err(|e| e.to_string())?;
    scenario::rebuild(scene, Arc::new(scenario), purpose).map_err(|e| e.to_string())
}

fn scenario_of(args: &ReplayArgs, header: &Header, folder: &Path) -> Result<Scenario, CliError> {
    let (text, origin, folder) = match &args.scenario {
        Some(path) => {
            let scenario = Scenario::load(path).map_err(CliError::input)?;
            let origin = path.display().to_string();
            (scenario.source, origin, path.parent().map(Path::to_owned))
        }
        None => {
            let origin = format!("{}: scenario", args.file.display());
            let text = header.scenario_toml.clone();
            (text, origin, Some(folder.to_owned()))
        }
    };
    let text = args.otherwise.varied(&text).map_err(CliError::input)?;
    Scenario::parse(&text, &origin, folder.as_deref()).map_err(CliError::input)
}

fn tell(printed: &Printed<'_>) {
    print(format_args!(
        "{} · {}",
        printed.file.display(),
        printed.scenario
    ));
    print(format_args!(
        "recorded      {}, {}",
        printed.started_utc, printed.build
    ));
    if let Some(participant) = printed.participant {
        print(format_args!("participant   {participant}"));
    }
    let (surface, triangles) = (printed.surface, printed.triangles);
    print(format_args!(
        "surface       {surface}, {triangles} triangles"
    ));
    print(format_args!("devices       {}", printed.devices.join(", ")));
    let (Some(report), Some(summary)) = (&printed.replay, &printed.summary) else {
        if let Some(found) = &printed.otherwise {
            tell_damage(&found.damage);
        }
        return;
    };
    print(summary);
    tell_damage(&report.damage);
    if report.passed.gaps > 0 {
        let (gaps, missing) = (report.passed.gaps, report.passed.missing);
        print(format_args!(
            "gaps          {gaps:>8}, {missing} ticks missing; replayed behind each"
        ));
    }
    let passed = &report.passed;
    if passed.edits > 0 {
        let edits = passed.edits;
        print(format_args!(
            "edits         {edits:>8} of the scene while it was felt"
        ));
    }
    if passed.unrepeated > 0 {
        let (ticks, first) = (passed.unrepeated, &passed.first_unrepeated);
        print(format_args!("not repeated  {ticks:>8} ticks; {first}"));
    }
    let fingers = match report.fingers {
        1 => "1 finger".to_owned(),
        n => format!("{n} fingers"),
    };
    let Some(first) = &report.first_difference else {
        let ticks = report.ticks - passed.unrepeated;
        print(format_args!("bit-exact: {ticks} ticks of {fingers}"));
        return;
    };
    print(format_args!("not bit-exact: {first}"));
    for field in &report.differences {
        let (name, records, max) = (field.field, field.records, field.max);
        print(format_args!(
            "  {name:<20} differs in {records} records, at most by {max:e}"
        ));
    }
}

fn tell_damage(damage: &Damage) {
    if damage.unfinished {
        print("unfinished    the recording was killed or cut; replayed as far as it goes");
    }
    let (chunks, messages) = (damage.chunks, damage.messages);
    if chunks + messages > 0 {
        let first = &damage.first;
        print(format_args!(
            "damaged       {chunks} chunks, {messages} messages; first at {first}"
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: ReplayArgs,
    }

    #[test]
    fn what_is_no_session_is_bad_input() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.mcap");
        std::fs::write(&path, "no session").expect("a file");
        let line = Line::try_parse_from([Path::new("replay"), &path]).expect("good usage");
        let error = run(&line.args, false).expect_err("refused").to_string();
        assert!(
            error.contains("a.mcap") && error.contains("not an MCAP file"),
            "{error}"
        );
    }
}
