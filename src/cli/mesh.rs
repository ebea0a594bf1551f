//! `dorsum mesh`: what a mesh file holds, what is wrong with it, and the built-in back as a file.

use super::{CliError, Outcome, print, print_json};
use crate::geom::Vec3;
use crate::surface::io::{self, UnitsFound, ply};
use crate::surface::{Component, RIM, Report, RimLoop, Surface, back};
use crate::units::{LengthUnit, deg_from_rad};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What to do with meshes.
#[derive(Debug, clap::Subcommand)]
pub enum MeshCommand {
    /// Print counts, bounds, area, components, rim, edge lengths and the smallest angle.
    Info(FileArgs),
    /// Print every defect and what was done about it.
    ///
    /// Exit code 0 if the mesh is clean or can be repaired, 1 with --strict if anything was found, 2 if it is refused.
    Validate {
        #[command(flatten)]
        file: FileArgs,
        /// Exit with 1 if anything was found, repaired or not.
        #[arg(long)]
        strict: bool,
    },
    /// Write the built-in back as PLY.
    Make {
        /// Number of triangles; the mesh comes as near to it as its filling allows.
        #[arg(long, default_value_t = 2962, value_parser = clap::value_parser!(u32).range(back::FEWEST as i64..=back::MOST as i64))]
        triangles: u32,
        /// File to write, ending in .ply.
        #[arg(long, value_name = "FILE")]
        out: PathBuf,
        /// Write numbers as text.
        #[arg(long)]
        ascii: bool,
    },
}

/// A mesh file.
#[derive(Debug, clap::Args)]
pub struct FileArgs {
    /// Mesh file: OBJ, PLY or STL.
    file: PathBuf,
    /// Units of the file: mm, cm, m or inch. Without: as the file says, else guessed by size.
    #[arg(long, value_parser = parse_units)]
    units: Option<LengthUnit>,
}

fn parse_units(name: &str) -> Result<LengthUnit, String> {
    LengthUnit::from_name(name).ok_or_else(|| "allowed are mm, cm, m, inch".into())
}

/// Runs `dorsum mesh`.
///
/// # Errors
/// A file cannot be read or written, or is refused.
pub fn run(command: &MeshCommand, json: bool) -> Result<Outcome, CliError> {
    match command {
        MeshCommand::Info(args) => info(args, json),
        MeshCommand::Validate { file, strict } => validate(file, *strict, json),
        MeshCommand::Make {
            triangles,
            out,
            ascii,
        } => make(*triangles, out, *ascii, json),
    }
}

fn load(args: &FileArgs) -> Result<(Surface, Report, UnitsFound), CliError> {
    let (raw, units) = io::read(&args.file, args.units).map_err(CliError::input)?;
    let (surface, report) = Surface::new(raw)
        .map_err(|e| CliError::input(format_args!("{e}: {}", args.file.display())))?;
    Ok((surface, report, units))
}

/// Measures of a mesh, after repair.
#[derive(Debug, Serialize)]
struct Info {
    file: String,
    units: UnitsFound,
    vertices: usize,
    triangles: usize,
    bounds_min_mm: [f64; 3],
    bounds_max_mm: [f64; 3],
    area_mm2: f64,
    edge_min_mm: f64,
    edge_median_mm: f64,
    edge_max_mm: f64,
    smallest_angle_deg: f64,
    n_components: usize,
    components: Vec<Component>,
    n_rims: usize,
    rims: Vec<RimLoop>,
    defects: usize,
    sha256: String,
}

impl Info {
    fn new(file: &Path, surface: &Surface, report: &Report, units: UnitsFound) -> Self {
        let mut lengths = edge_lengths(surface);
        let middle = lengths.len() / 2;
        let (shorter, &mut edge_median_mm, longer) =
            lengths.select_nth_unstable_by(middle, f64::total_cmp);
        let edge_min_mm = shorter.iter().copied().fold(edge_median_mm, f64::min);
        let edge_max_mm = longer.iter().copied().fold(edge_median_mm, f64::max);
        let n = surface.triangles().len() as u32;
        Self {
            file: file.display().to_string(),
            units,
            vertices: surface.positions().len(),
            triangles: surface.triangles().len(),
            bounds_min_mm: surface.bounds().min.to_array(),
            bounds_max_mm: surface.bounds().max.to_array(),
            area_mm2: (0..n).map(|t| surface.triangle(t).area_mm2()).sum(),
            edge_min_mm,
            edge_median_mm,
            edge_max_mm,
            smallest_angle_deg: deg_from_rad(smallest_angle_rad(surface)),
            n_components: report.n_components,
            components: report.components.clone(),
            n_rims: report.n_rims,
            rims: report.rims.clone(),
            defects: report.defects.len(),
            sha256: surface.hash().iter().map(|b| format!("{b:02x}")).collect(),
        }
    }
}

/// Every edge once, mm. At least three, for a surface has a triangle.
fn edge_lengths(surface: &Surface) -> Vec<f64> {
    let mut lengths = Vec::with_capacity(surface.triangles().len() * 3 / 2 + 3);
    for (t, corners) in surface.triangles().iter().enumerate() {
        for (i, over) in surface.topology().across(t as u32).into_iter().enumerate() {
            if over == RIM || over as usize > t {
                let [p, q] = [corners[i], corners[(i + 1) % 3]];
                let [p, q] = [p, q].map(|v| surface.positions()[v as usize]);
                lengths.push(p.distance(q));
            }
        }
    }
    lengths
}

fn smallest_angle_rad(surface: &Surface) -> f64 {
    let angle = |at: Vec3, p: Vec3, q: Vec3| {
        let (p, q) = (p - at, q - at);
        libm::atan2(p.cross(q).length(), p.dot(q))
    };
    (0..surface.triangles().len() as u32)
        .map(|t| surface.triangle(t))
        .flat_map(|t| {
            [
                angle(t.a, t.b, t.c),
                angle(t.b, t.c, t.a),
                angle(t.c, t.a, t.b),
            ]
        })
        .fold(f64::INFINITY, f64::min)
}

fn info(args: &FileArgs, json: bool) -> Result<Outcome, CliError> {
    let (surface, report, units) = load(args)?;
    let info = Info::new(&args.file, &surface, &report, units);
    if json {
        print_json(&info)?;
        return Ok(Outcome::Done);
    }
    let row = |name: &str, value: String| print(format_args!("{name:<16} {value}"));
    let [min, max] = [info.bounds_min_mm, info.bounds_max_mm];
    row("file", info.file.clone());
    row("units", info.units.to_string());
    row("triangles", info.triangles.to_string());
    row("vertices", info.vertices.to_string());
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        row(axis, format!("{:.2} to {:.2} mm", min[i], max[i]));
    }
    row("area", format!("{:.1} cm²", info.area_mm2 / 100.0));
    row(
        "edges",
        format!(
            "{:.3} to {:.3} mm, median {:.3} mm",
            info.edge_min_mm, info.edge_max_mm, info.edge_median_mm
        ),
    );
    row("smallest angle", format!("{:.3}°", info.smallest_angle_deg));
    row("components", components_text(&report));
    row("rim", rim_text(&report));
    row(
        "defects",
        match info.defects {
            0 => "none".into(),
            1 => "of 1 kind; see dorsum mesh validate".into(),
            n => format!("of {n} kinds; see dorsum mesh validate"),
        },
    );
    row("sha256", info.sha256);
    Ok(Outcome::Done)
}

fn components_text(report: &Report) -> String {
    let sizes: Vec<String> = (report.components.iter().take(5))
        .map(|c| {
            format!(
                "{} {}",
                c.triangles,
                if c.closed { "closed" } else { "open" }
            )
        })
        .collect();
    let more = if report.n_components > sizes.len() {
        ", …"
    } else {
        ""
    };
    format!(
        "{} (triangles: {}{more})",
        report.n_components,
        sizes.join(", ")
    )
}

fn rim_text(report: &Report) -> String {
    let Some(rim) = report.rim() else {
        return "none, the mesh is closed".into();
    };
    let others = match report.n_rims - 1 {
        0 => String::new(),
        1 => "; 1 other loop".into(),
        n => format!("; {n} other loops"),
    };
    format!("{} edges, {:.1} mm{others}", rim.edges, rim.perimeter_mm)
}

/// How a mesh that was not refused came out.
#[derive(Clone, Copy, Serialize)]
#[serde(rename_all = "snake_case")]
enum Verdict {
    Clean,
    Remarks,
    Repaired,
}

#[derive(Serialize)]
struct Validated<'a> {
    file: String,
    verdict: Verdict,
    units: &'a UnitsFound,
    #[serde(flatten)]
    report: &'a Report,
}

fn validate(args: &FileArgs, strict: bool, json: bool) -> Result<Outcome, CliError> {
    let (_, report, units) = load(args)?;
    let verdict = if report.is_repaired() {
        Verdict::Repaired
    } else if report.is_clean() {
        Verdict::Clean
    } else {
        Verdict::Remarks
    };
    if json {
        print_json(&Validated {
            file: args.file.display().to_string(),
            verdict,
            units: &units,
            report: &report,
        })?;
    } else {
        print(format_args!("units: {units}"));
        for defect in &report.defects {
            print(defect);
        }
        print(match verdict {
            Verdict::Clean => "clean",
            Verdict::Remarks => "usable as it is",
            Verdict::Repaired => "repaired",
        });
    }
    Ok(if strict && !report.is_clean() {
        Outcome::DoesNotHold
    } else {
        Outcome::Done
    })
}

fn make(triangles: u32, out: &Path, ascii: bool, json: bool) -> Result<Outcome, CliError> {
    if io::Format::from_extension(out) != Some(io::Format::Ply) {
        let out = out.display();
        return Err(CliError::input(format_args!(
            "--out {out}: only PLY is written; end it in .ply"
        )));
    }
    let raw = back::make(&back::BackOptions::with_triangles(triangles as usize));
    let encoding = if ascii {
        ply::PlyEncoding::Ascii
    } else {
        ply::PlyEncoding::BinaryLittleEndian
    };
    ply::write(out, &raw.positions, &raw.triangles, &[], encoding).map_err(CliError::input)?;
    if json {
        print_json(&serde_json::json!({
            "file": out.display().to_string(),
            "triangles": raw.triangles.len(),
            "vertices": raw.positions.len(),
        }))?;
    } else {
        let (out, triangles, vertices) = (out.display(), raw.triangles.len(), raw.positions.len());
        print(format_args!(
            "{out}: {triangles} triangles, {vertices} vertices"
        ));
    }
    Ok(Outcome::Done)
}
