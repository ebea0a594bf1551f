//! `dorsum scene`: what a scenario needs and what is left out, with bytes and µs.

use super::common::{build_scene, bytes_text, default_place, height_mm, load_scenario};
use super::{CliError, Outcome, print, print_json};
use crate::deform::{Displacement, Model as _, models::fsmd::Fsmd};
use crate::device::scripted::{Script, Scripted};
use crate::scenario::{Item, Ledger, Scene, Use};
use crate::servo::{self, Limits, MAX_FINGERS, Rig};
use std::time::{Duration, Instant};

/// Which scenario, used how.
#[derive(Debug, clap::Args)]
pub struct SceneArgs {
    /// Scenario file, or the name of an example.
    scenario: String,
    /// As with an open Back view: the drawn skin is deformed.
    #[arg(long)]
    drawn: bool,
}

#[derive(serde::Serialize)]
struct Printed<'a> {
    scenario: &'a str,
    surface: &'a str,
    units: Option<&'a crate::surface::io::UnitsFound>,
    defects: &'a [crate::surface::Defect],
    vertices: usize,
    triangles: usize,
    engine: String,
    force_model: String,
    tick_us: f64,
    ledger: &'a [crate::scenario::LedgerRow],
    total_bytes: usize,
}

/// Builds the scene, measures it with a short press and prints the ledger.
///
/// # Errors
/// The scenario is refused.
pub fn run(args: &SceneArgs, json: bool) -> Result<Outcome, CliError> {
    let purpose = Use {
        fingers: 1,
        deformed: args.drawn,
        ..Use::default()
    };
    let scene = build_scene(load_scenario(&args.scenario)?, purpose)?;
    let mut ledger = scene.ledger.clone();
    let tick_us = measure(&scene, purpose, &mut ledger);
    let printed = Printed {
        scenario: &scene.scenario.name,
        surface: &scene.mesh_origin,
        units: scene.mesh_units.as_ref(),
        defects: &scene.report.defects,
        vertices: scene.surface.positions().len(),
        triangles: scene.surface.triangles().len(),
        engine: match &scene.scenario.published {
            None => "production".to_owned(),
            Some(options) => format!("published, {options}"),
        },
        tick_us,
        force_model: scene.scenario.choices.force.to_string(),
        ledger: &ledger.rows,
        total_bytes: ledger.total_bytes(),
    };
    if json {
        print_json(&printed)?;
        return Ok(Outcome::Done);
    }
    print(format_args!("{}", printed.scenario));
    print(format_args!(
        "{}, {} vertices, {} triangles",
        printed.surface, printed.vertices, printed.triangles
    ));
    print(format_args!(
        "engine: {}, {tick_us:.2} µs a tick",
        printed.engine
    ));
    print(format_args!("force: {}", printed.force_model));
    if let Some(units) = printed.units {
        print(format_args!("{units}"));
    }
    for defect in printed.defects {
        print(format_args!("{defect}"));
    }
    print("");
    print(format_args!(
        "{:<22} {:<9} {:>10} {:>14}  {:<9} reason",
        "part", "", "memory", "cost", ""
    ));
    for row in printed.ledger {
        let state = if row.built { "built" } else { "left out" };
        let memory = if row.built {
            bytes_text(row.bytes)
        } else {
            "–".into()
        };
        let cost = row.cost_us.map_or("–".into(), |us| format!("{us:.2} µs"));
        let per = if row.cost_per.is_empty() {
            String::new()
        } else {
            format!("/ {}", row.cost_per)
        };
        print(format_args!(
            "{:<22} {state:<9} {memory:>10} {cost:>14}  {per:<9} {}",
            row.item, row.reason
        ));
    }
    print(format_args!(
        "{:<22} {:<9} {:>10}",
        "total",
        "",
        bytes_text(printed.total_bytes)
    ));
    Ok(Outcome::Done)
}

/// Presses and slides for four seconds of simulated time and notes the mean cost of a frame; returns that of a tick, µs.
fn measure(scene: &Scene, purpose: Use, ledger: &mut Ledger) -> f64 {
    const DT_S: f64 = 0.001;
    const TICKS: usize = 4000;
    const TICKS_PER_FRAME: usize = 16;
    /// Frames of a very large mesh are slow: enough is measured by then.
    const MEASURED_FOR: Duration = Duration::from_secs(1);
    let script = Script::Slide.trajectory(default_place(scene), 5.0, |x, y| height_mm(scene, x, y));
    let mut rig = Rig::new(
        Box::new(scene.touch.clone()),
        [Limits::default(); MAX_FINGERS],
    );
    let mut records = Vec::with_capacity(TICKS);
    let started = Instant::now();
    servo::run_offline(
        &mut rig,
        vec![Box::new(Scripted::new(script))],
        DT_S,
        |out| {
            records.push(out.fingers[0].contact);
            records.len() < TICKS
        },
    );
    let tick_us = started.elapsed().as_secs_f64() * 1.0e6 / TICKS as f64;
    if scene.touch.published.is_none() {
        ledger.cost(Item::Search, tick_us, "tick");
    }
    if !(purpose.drawn || purpose.deformed) {
        return tick_us;
    }
    let mut model = Fsmd::new(scene.deform.clone());
    model.prepare(&scene.surface);
    let mut skin = Displacement::at_rest(&scene.surface);
    let started = Instant::now();
    let mut n_frames = 0_u32;
    for contact in records.iter().step_by(TICKS_PER_FRAME) {
        let press = scene.press(contact);
        model.update(&scene.surface, press.as_slice(), &mut skin);
        n_frames += 1;
        if started.elapsed() > MEASURED_FOR {
            break;
        }
    }
    let frame_us = started.elapsed().as_secs_f64() * 1.0e6 / f64::from(n_frames.max(1));
    ledger.built(Item::Deformation, skin.bytes() + model.bytes());
    ledger.cost(Item::Deformation, frame_us, "frame");
    if scene.deform.tangential {
        ledger.built(Item::TangentialField, 0);
    }
    tick_us
}
