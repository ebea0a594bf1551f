//! What several subcommands share: finding a scenario, building it, showing progress.

use super::CliError;
use crate::scenario::{self, Example, Scenario, Scene, Use};
use crate::surface::{RawMesh, Surface, back, io};
use indicatif::{ProgressBar, ProgressStyle};
use std::path::Path;
use std::sync::Arc;

/// The embedded example called `name`, unless there is a file of that name.
pub(super) fn example(name: &str) -> Option<Example> {
    let called = |e: &&Example| e.file == name || e.file.strip_suffix(".toml") == Some(name);
    scenario::examples()
        .iter()
        .find(called)
        .copied()
        .filter(|_| !Path::new(name).exists())
}

/// The scenario in the file `name`, or the embedded example of that name.
pub(super) fn load_scenario(name: &str) -> Result<Scenario, CliError> {
    if let Some(example) = example(name) {
        return Scenario::parse(example.text, example.file, None).map_err(CliError::input);
    }
    let path = Path::new(name);
    Scenario::load(path).map_err(|e| {
        if path.exists() {
            return CliError::input(e);
        }
        let names: Vec<_> = scenario::examples().iter().map(|e| e.file).collect();
        CliError::input(format!(
            "{e}; give a scenario file or one of the examples {}",
            names.join(", ")
        ))
    })
}

/// Builds a scene, with a progress bar on a terminal.
pub(super) fn build_scene(scenario: Scenario, purpose: Use) -> Result<Scene, CliError> {
    let bar = progress_bar(100, "{msg:32} {bar:30} {percent:>3} %");
    let built = scenario::build(Arc::new(scenario), purpose, &mut |what, fraction| {
        bar.set_message(what.to_owned());
        bar.set_position((fraction * 100.0) as u64);
        true
    });
    bar.finish_and_clear();
    built.map_err(CliError::input)
}

/// A progress bar on stderr; it hides itself when stderr is not a terminal.
pub(super) fn progress_bar(length: u64, template: &str) -> ProgressBar {
    let bar = ProgressBar::new(length);
    let style =
        ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.set_style(style.progress_chars("━╸ "));
    bar
}

/// The mesh in a file, or the built-in back.
pub(super) fn load_mesh(mesh: &str) -> Result<Surface, CliError> {
    let builtin = |triangles: usize| back::make(&back::BackOptions::with_triangles(triangles));
    let raw: RawMesh = if mesh == "back" && !Path::new(mesh).exists() {
        back::make(&back::BackOptions::default())
    } else if let Some(number) = mesh.strip_prefix("back:") {
        let allowed = back::FEWEST..=back::MOST;
        let triangles = number.parse().ok().filter(|n| allowed.contains(n));
        builtin(triangles.ok_or_else(|| {
            CliError::input(format_args!(
                "{mesh}: {} to {} triangles are allowed, as in back:41582",
                back::FEWEST,
                back::MOST
            ))
        })?)
    } else {
        io::read(Path::new(mesh), None).map_err(CliError::input)?.0
    };
    let (surface, _) =
        Surface::new(raw).map_err(|e| CliError::input(format_args!("{e}: {mesh}")))?;
    Ok(surface)
}

/// Parses `x,y` in mm.
pub(super) fn parse_place(text: &str) -> Result<(f64, f64), String> {
    let numbers: Vec<f64> = text
        .split(',')
        .filter_map(|t| t.trim().parse().ok())
        .filter(|x: &f64| x.is_finite())
        .collect();
    match numbers[..] {
        [x, y] if text.split(',').count() == 2 => Ok((x, y)),
        _ => Err(format!(
            "\"{text}\" is not a place; two numbers x,y in mm are needed"
        )),
    }
}

/// A number of bytes for people.
pub(super) fn bytes_text(bytes: usize) -> String {
    match bytes {
        0..10_000 => format!("{bytes} B"),
        10_000..10_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        _ => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}
