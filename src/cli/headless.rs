//! The main job without a window: a scripted finger palpates the back, the session is recorded, replayed bit by bit, and
//! shown in a plot and a picture.

use super::common::{build_scene, load_scenario};
use super::run::{Plan, script_over};
use super::summary::Summary;
use super::{CliError, Outcome, print, print_json};
use crate::contact::{Contact, Touch};
use crate::deform::{Displacement, Model as _, models::fsmd::Fsmd};
use crate::device::scripted::Script;
use crate::figure::{self, Ball, Camera, LinePlot, Picture, Series};
use crate::geom::Vec3;
use crate::scenario::{Scene, Use, default_example};
use crate::servo::{FingerRecord, Rig};
use crate::session::{IfExists, Session, Strictness, check};
use std::path::{Path, PathBuf};

/// How deep the finger presses, mm.
const DEPTH_MM: f64 = 8.0;
/// Radius of the drawn fingertip, mm.
const FINGERTIP_MM: f64 = 8.0;

#[derive(serde::Serialize)]
struct Printed<'a> {
    scenario: &'a str,
    summary: Summary,
    bit_exact: bool,
    session: PathBuf,
    plot: PathBuf,
    picture: PathBuf,
}

/// Does the main job in `scenario` (the default example without one) and says where in `out` (the user's data folder
/// without one) its results are.
///
/// # Errors
/// The scenario is refused or the folder cannot be written.
pub fn run(scenario: Option<&str>, out: Option<&Path>, json: bool) -> Result<Outcome, CliError> {
    let name = scenario.unwrap_or(default_example().file);
    let purpose = Use {
        fingers: 1,
        deformed: true,
        recorded: true,
        ..Use::default()
    };
    let scene = build_scene(load_scenario(name)?, purpose)?;
    let folder = match out {
        Some(folder) => folder.to_owned(),
        None => data_folder()?,
    };
    let failed = |e: std::io::Error| CliError::input(format!("{}: {e}", folder.display()));
    std::fs::create_dir_all(&folder).map_err(failed)?;
    let session_path = unused(&folder, "palpation", "mcap");

    let script = script_over(&scene, Script::Slide, scene.default_place_mm(), DEPTH_MM);
    let plan = Plan {
        rate_hz: 1000.0,
        trajectories: vec![script],
        passivity: false,
    };
    let (summary, lost) = plan.run_live(&scene, Some((&session_path, IfExists::Refuse)))?;

    let session = Session::open(&session_path).map_err(CliError::input)?;
    let rig = Rig::new(Box::new(scene.touch.clone()), session.header().limits());
    let report = check(&session, rig, Strictness::Strict).map_err(CliError::input)?;
    let recording = session.load(Strictness::Strict).map_err(CliError::input)?;
    let records = recording.fingers.first().map_or(&[][..], |f| &f[..]);

    let plot = session_path.with_extension("svg");
    figure::write_svg(&plot, &plots(records)).map_err(failed)?;
    let picture = session_path.with_extension("png");
    let deepest = records
        .iter()
        .map(|r| &r.contact)
        .max_by(|a, b| a.depth_mm.total_cmp(&b.depth_mm));
    write_picture(&scene, deepest, &picture).map_err(failed)?;

    let printed = Printed {
        scenario: &scene.scenario.name,
        summary,
        bit_exact: report.is_bit_exact() && lost == 0,
        session: session_path,
        plot,
        picture,
    };
    if json {
        print_json(&printed)?;
    } else {
        print(format_args!(
            "{} · palpated by a scripted finger",
            printed.scenario
        ));
        print(&printed.summary);
        match &report.first_difference {
            None => print(format_args!(
                "replay        bit-exact, {} ticks",
                report.ticks
            )),
            Some(first) => print(format_args!("replay        differs: {first}")),
        }
        print(format_args!("session       {}", printed.session.display()));
        print(format_args!("force plot    {}", printed.plot.display()));
        print(format_args!("picture       {}", printed.picture.display()));
    }
    Ok(if printed.bit_exact {
        Outcome::Done
    } else {
        Outcome::DoesNotHold
    })
}

/// Where the user's system keeps a program's data.
fn data_folder() -> Result<PathBuf, CliError> {
    directories::ProjectDirs::from("", "", "dorsum")
        .map(|dirs| dirs.data_dir().join("headless"))
        .ok_or_else(|| {
            CliError::input("the system names no folder for user data; say where with --out DIR")
        })
}

/// The first of name-1, name-2, … that is not there yet.
fn unused(folder: &Path, name: &str, extension: &str) -> PathBuf {
    let numbered = |i: u32| folder.join(format!("{name}-{i}.{extension}"));
    (1..)
        .map(numbered)
        .find(|p| !p.exists())
        .unwrap_or_else(|| numbered(0))
}

fn plots(records: &[FingerRecord]) -> Vec<LinePlot> {
    let start_ns = records.first().map_or(0, |r| r.time_ns);
    let series = |name: &str, colour: [u8; 3], value: fn(&Contact, Vec3) -> f64| Series {
        name: name.into(),
        colour,
        points: records
            .iter()
            .map(|r| {
                [
                    crate::units::s_from_ns(r.time_ns - start_ns),
                    value(&r.contact, r.sent_force_n),
                ]
            })
            .collect(),
        ..Series::default()
    };
    let normal = |c: &Contact, f: Vec3| f.dot(c.normal);
    let tangential = |c: &Contact, f: Vec3| (f - c.normal * f.dot(c.normal)).length();
    let grey = [120, 124, 130];
    vec![
        LinePlot {
            title: "Force on the finger".into(),
            x_label: "time (s)".into(),
            y_label: "force (N)".into(),
            series: vec![
                series("normal", figure::LEFT, normal),
                series("tangential", grey, tangential),
            ],
            ..LinePlot::default()
        },
        LinePlot {
            title: "Penetration".into(),
            x_label: "time (s)".into(),
            y_label: "depth (mm)".into(),
            series: vec![series("depth", figure::LEFT, |c, _| c.depth_mm)],
            ..LinePlot::default()
        },
    ]
}

/// The skin under the press, with the fingertip resting on it.
fn write_picture(scene: &Scene, contact: Option<&Contact>, path: &Path) -> std::io::Result<()> {
    let surface = &scene.surface;
    let mut skin = Displacement::at_rest(surface);
    let mut balls = Vec::new();
    if let Some(contact) = contact.filter(|c| c.touch != Touch::Free) {
        let pad_mm = scene.touch.choices.pad_mm();
        let press = scene.press(contact);
        Fsmd::new(scene.deform.clone()).update(surface, press.as_slice(), &mut skin);
        let radius_mm = pad_mm.unwrap_or(FINGERTIP_MM);
        let at = press.as_ref().map_or(contact.anchor_mm, |p| p.anchor_mm);
        let on_skin = skin.carried_point(surface, contact.triangle, at);
        let centre_mm = on_skin + contact.normal * radius_mm;
        balls.push(Ball {
            centre_mm,
            radius_mm,
            colour: figure::LEFT,
        });
    }
    let positions = skin.to_positions(surface);
    let (width, height) = (900, 1100);
    let direction = Vec3::new(0.45, 0.12, 1.0);
    let picture = Picture {
        positions: &positions,
        normals: &skin.to_normals(),
        triangles: surface.triangles(),
        colours: None,
        balls: &balls,
        camera: Camera::framing(&surface.bounds(), direction, width as f64 / height as f64),
        width,
        height,
    };
    picture.render().write_png(path)
}
