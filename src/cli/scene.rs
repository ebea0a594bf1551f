//! `dorsum scene`: what a scenario needs and what is left out, with bytes and µs.

use super::common::{build_scene, bytes_text, load_scenario};
use super::{CliError, Outcome, print, print_json};
use crate::scenario::Use;

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
    let tick_us = scene.measure(purpose, &mut ledger);
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
        "{:<22} {:<9} {:>10} {:>12} {:>14}  {:<8} reason",
        "part", "", "memory", "built in", "cost", ""
    ));
    for row in printed.ledger {
        let state = if row.built { "built" } else { "left out" };
        let memory = if row.built {
            bytes_text(row.bytes)
        } else {
            "–".into()
        };
        let built_in = row
            .build_us
            .map_or("–".into(), |us| format!("{:.2} ms", us / 1e3));
        let in_use = row.cost_us.filter(|_| row.cost_per != "build");
        let cost = in_use.map_or("–".into(), |us| format!("{us:.2} µs"));
        let per = in_use.map_or(String::new(), |_| format!("/ {}", row.cost_per));
        print(format_args!(
            "{:<22} {state:<9} {memory:>10} {built_in:>12} {cost:>14}  {per:<8} {}",
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
