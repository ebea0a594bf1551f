//! `dorsum replay`: repeats a recorded session from its device readings and compares.

use super::common::{build_scene, progress_bar};
use super::summary::Summary;
use super::{CliError, Outcome, print, print_json};
use crate::scenario::{self, Scenario, Scene, Use};
use crate::servo::Rig;
use crate::session::{CheckReport, Damage, Edit, Header, Session, Strictness, check_edited};
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
    summary: Summary,
    bit_exact: bool,
    replay: CheckReport,
}

/// Repeats the session and says what it was and whether it came out the same.
///
/// # Errors
/// The session cannot be read, its scene cannot be rebuilt, or it was recorded on another surface.
pub fn run(args: &ReplayArgs, json: bool) -> Result<Outcome, CliError> {
    let session = Session::open(&args.file).map_err(CliError::input)?;
    let header = session.header();
    let purpose = Use {
        fingers: header.n_fingers(),
        ..Use::default()
    };
    let scene = build_scene(scenario_of(args, header)?, purpose)?;
    let rig = Rig::new(Box::new(scene.touch.clone()), header.limits());
    let rebuild = |edit: &Edit| edited(args, &scene, edit, purpose).map(|s: Scene| s.touch);
    let mut summary = Summary::new(header.dt_s());
    let bar = progress_bar(1000, "replaying    {bar:40} {percent:>3} %  {eta}");
    // Lenient: a killed recording is replayed as far as it goes, and the report tells what is missing.
    let report = check_edited(
        &session,
        rig,
        Box::new(rebuild),
        Strictness::Lenient,
        |pair, done| {
            for record in pair.recorded.fingers() {
                summary.add(record);
            }
            if summary.ticks.is_multiple_of(1024) {
                bar.set_position((done * 1000.0) as u64);
            }
        },
    );
    bar.finish_and_clear();
    let report = report.map_err(CliError::input)?;
    let holds = report.is_bit_exact() && report.damage.chunks == 0 && report.damage.messages == 0;
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
        summary,
        bit_exact: holds,
        replay: report,
    };
    if json {
        print_json(&printed)?;
    } else {
        tell(&printed);
    }
    Ok(if holds || !args.check {
        Outcome::Done
    } else {
        Outcome::DoesNotHold
    })
}

/// The scene after an edit. In a scenario of one's own the recorded edits mean nothing: it stays as it is.
fn edited(args: &ReplayArgs, scene: &Scene, edit: &Edit, purpose: Use) -> Result<Scene, String> {
    if args.scenario.is_some() {
        return Ok(scene.clone());
    }
    let origin = format!("{}: edit {}", args.file.display(), edit.number);
    let folder = scene.scenario.folder.as_deref();
    let scenario = Scenario::parse(&edit.scenario_toml, &origin, folder);
    let scenario = scenario.map_err(|e| e.to_string())?;
    scenario::rebuild(scene, Arc::new(scenario), purpose).map_err(|e| e.to_string())
}

fn scenario_of(args: &ReplayArgs, header: &Header) -> Result<Scenario, CliError> {
    let parsed = match &args.scenario {
        Some(path) => Scenario::load(path),
        None => {
            let origin = format!("{}: scenario", args.file.display());
            Scenario::parse(&header.scenario_toml, &origin, args.file.parent())
        }
    };
    parsed.map_err(CliError::input)
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
    print(&printed.summary);
    tell_damage(&printed.replay.damage);
    let report = &printed.replay;
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
