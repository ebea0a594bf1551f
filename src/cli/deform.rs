//! `dorsum deform`: the drawn skin under one or more presses: what moves, how far, its strain, what it costs.

use super::common::{build_scene, load_scenario};
use super::{CliError, Outcome, print, print_json};
use crate::deform::footprint::major_axis_on_skin;
use crate::deform::models::fsmd::Fsmd;
use crate::deform::strain::Strain;
use crate::deform::{Displacement, Model, Press};
use crate::geom::Vec3;
use crate::partition::{Partition as _, Sides};
use crate::reference::models::{self, Site, Tissue, Yardstick};
use crate::scenario::{Scene, Use};
use crate::surface::io::{Format, ply};
use serde::Serialize;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Times an update is repeated for its median time.
const REPEATS: usize = 101;
/// For no longer than this: a yardstick may take seconds.
const LONGEST: Duration = Duration::from_secs(5);
/// Depth of a press that states none, mm.
const DEPTH_MM: f64 = 5.0;
/// Deepest press and longest drag taken, mm: beyond the caps of any scenario.
const FARTHEST_MM: f64 = 1000.0;

/// Which scene, pressed where.
#[derive(Debug, clap::Args)]
pub struct DeformArgs {
    /// Scenario file, or the name of an example.
    scenario: String,
    /// A press: place on the map plane, depth below the skin (without: 5) and drag along the skin, all mm. Repeat it for
    /// more fingers.
    #[arg(
        long = "press",
        value_name = "X,Y[,DEPTH[,DX,DY]]",
        value_parser = parse_press,
        allow_hyphen_values = true,
        required = true
    )]
    presses: Vec<Place>,
    /// Press at the vertex nearest to each place instead of between vertices.
    #[arg(long)]
    at_vertex: bool,
    /// Draw by another model than the scenario's: a yardstick such as layer, fem-linear or xpbd, with muscle 20 mm over bone
    /// under the first press.
    #[arg(long, value_name = "NAME", value_parser = parse_model)]
    model: Option<&'static Yardstick>,
    /// Write the deformed skin to this PLY file, with displacement, strain and stiffness at its vertices.
    #[arg(long, value_name = "FILE.ply")]
    out: Option<PathBuf>,
}

/// One `--press`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    x: f64,
    y: f64,
    depth_mm: f64,
    drag_mm: [f64; 2],
}

fn parse_press(text: &str) -> Result<Place, String> {
    let fault = |what: &str| Err(format!("\"{text}\": {what}"));
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|t| t.trim().parse()).collect();
    let (x, y, depth_mm, drag_mm) = match numbers.as_deref() {
        Ok(&[x, y]) => (x, y, DEPTH_MM, [0.0; 2]),
        Ok(&[x, y, depth]) => (x, y, depth, [0.0; 2]),
        Ok(&[x, y, depth, dx, dy]) => (x, y, depth, [dx, dy]),
        _ => return fault("numbers x,y or x,y,depth or x,y,depth,dx,dy in mm are needed"),
    };
    if !(x.is_finite() && y.is_finite()) {
        return fault("x and y must be finite");
    }
    if !(depth_mm > 0.0 && depth_mm <= FARTHEST_MM) {
        return fault("the depth must be above 0 and at most 1000 mm");
    }
    if !drag_mm.iter().all(|d: &f64| d.abs() <= FARTHEST_MM) {
        return fault("the drag must be within ±1000 mm");
    }
    Ok(Place {
        x,
        y,
        depth_mm,
        drag_mm,
    })
}

fn parse_model(name: &str) -> Result<&'static Yardstick, String> {
    models::by_name(name).ok_or_else(|| {
        let names: Vec<_> = models::models().iter().map(|y| y.name).collect();
        format!("there are {}; without this option: fsmd", names.join(", "))
    })
}

/// The scenario's own model, whose halves can be timed, or a yardstick.
enum Drawn {
    Fsmd(Box<Fsmd>),
    Yardstick(Box<dyn Model>),
}

impl Drawn {
    fn new(scene: &Scene, yardstick: Option<&Yardstick>, press: &Press) -> Result<Self, CliError> {
        let Some(yardstick) = yardstick else {
            return Ok(Self::Fsmd(Box::new(Fsmd::new(scene.deform.clone()))));
        };
        let site = Site {
            surface: &scene.surface,
            search: &*scene.touch.search,
            at_mm: press.anchor_mm,
            normal: press.normal,
        };
        let made = yardstick.make(site, Tissue::default());
        let refused = |e| CliError::input(format_args!("--model {}: {e}", yardstick.name));
        made.map(Self::Yardstick).map_err(refused)
    }

    fn model(&mut self) -> &mut dyn Model {
        match self {
            Self::Fsmd(fsmd) => &mut **fsmd,
            Self::Yardstick(model) => &mut **model,
        }
    }
}

#[derive(Serialize)]
struct Pressed {
    anchor_mm: [f64; 3],
    normal: [f64; 3],
    triangle: u32,
    vertex: Option<u32>,
    depth_mm: f64,
    drag_mm: f64,
    hip_mm: [f64; 3],
    skin_mm: [f64; 3],
    off_hip_mm: f64,
    stiffness_n_per_mm: f64,
    force_n: f64,
    half_major_mm: f64,
    half_minor_mm: f64,
    direction_deg: f64,
    irregular: bool,
    bone_depth_mm: Option<f64>,
}

/// A value with the vertex that has it.
#[derive(Clone, Copy, Debug, Serialize)]
struct Extreme {
    value: f64,
    vertex: u32,
    at_mm: [f64; 3],
}

#[derive(Serialize)]
struct StrainFound {
    least: Option<Extreme>,
    largest: Option<Extreme>,
}

/// Median times, µs; preparing is done once.
#[derive(Serialize)]
struct Timings {
    prepare_us: f64,
    displace_us: f64,
    /// Nothing where it is part of displacing.
    shade_us: Option<f64>,
    strain_us: f64,
    ns_per_vertex: Option<f64>,
}

#[derive(Serialize)]
struct Printed {
    scenario: String,
    model: &'static str,
    curve: String,
    footprint: &'static str,
    triangles: usize,
    vertices: usize,
    moved: usize,
    touched: usize,
    max_normal_mm: f64,
    max_tangential_mm: f64,
    presses: Vec<Pressed>,
    largest_displacement_mm: Option<Extreme>,
    strain: StrainFound,
    timings: Timings,
    out: Option<PathBuf>,
}

/// Runs `dorsum deform`.
///
/// # Errors
/// The scenario cannot be read or built, a press lies beside the skin or drags a frictionless one, or the file cannot be
/// written.
pub fn run(args: &DeformArgs, json: bool) -> Result<Outcome, CliError> {
    if let Some(out) = &args.out
        && Format::from_extension(out) != Some(Format::Ply)
    {
        return Err(CliError::input(format_args!(
            "--out {}: only PLY is written; end it in .ply",
            out.display()
        )));
    }
    let purpose = Use {
        fingers: args.presses.len(),
        deformed: true,
        ..Use::default()
    };
    let scene = build_scene(load_scenario(&args.scenario)?, purpose)?;
    let presses: Vec<Press> = (args.presses.iter())
        .map(|place| press_at(&scene, place, args.at_vertex))
        .collect::<Result<_, _>>()?;

    let surface = &*scene.surface;
    // At least one is given.
    let first = presses.first().cloned().unwrap_or_default();
    let mut drawn = Drawn::new(&scene, args.model, &first)?;
    let timings = timed(&scene, &mut drawn, &presses);
    let model = drawn.model();
    // Once more from rest, so that what was touched is all that the presses change.
    let mut skin = Displacement::at_rest(surface);
    model.update(surface, &presses, &mut skin);
    let strain = Strain::new(surface, &skin);
    if let Some(out) = &args.out {
        write_ply(&scene, &skin, &strain, out)?;
    }
    let sized = |v: u32| skin.offset_mm(v).length();
    let by = |value: &dyn Fn(u32) -> f64, v: u32| Extreme {
        value: value(v),
        vertex: v,
        at_mm: surface.positions()[v as usize].to_array(),
    };
    let strained = |v: u32| strain.values()[v as usize];
    let under_strain = || strain.touched();
    let printed = Printed {
        scenario: scene.scenario.name.clone(),
        model: model.name(),
        curve: scene.deform.curve.name().to_owned(),
        footprint: scene.deform.footprint.name(),
        triangles: surface.triangles().len(),
        vertices: surface.positions().len(),
        moved: skin.n_moved(),
        touched: skin.n_touched(),
        max_normal_mm: scene.deform.max_normal_mm,
        max_tangential_mm: scene.deform.max_tangential_mm,
        presses: presses.iter().map(|p| told(&scene, &skin, p)).collect(),
        largest_displacement_mm: (skin.moved())
            .max_by(|&a, &b| sized(a).total_cmp(&sized(b)))
            .map(|v| by(&sized, v)),
        strain: StrainFound {
            least: under_strain()
                .min_by(|&a, &b| strained(a).total_cmp(&strained(b)))
                .map(|v| by(&strained, v)),
            largest: under_strain()
                .max_by(|&a, &b| strained(a).total_cmp(&strained(b)))
                .map(|v| by(&strained, v)),
        },
        timings,
        out: args.out.clone(),
    };
    if json {
        print_json(&printed)?;
    } else {
        print_table(&printed);
    }
    Ok(Outcome::Done)
}

/// The press of a finger that comes from behind, along z, at a place of the map plane.
fn press_at(scene: &Scene, place: &Place, at_vertex: bool) -> Result<Press, CliError> {
    let Place { x, y, .. } = *place;
    let surface = &*scene.surface;
    let bounds = surface.bounds();
    let (from, to) = (
        Vec3::new(x, y, bounds.max.z + 1.0),
        Vec3::new(x, y, bounds.min.z - 1.0),
    );
    let hit = (scene.touch.search)
        .sweep(surface, from, to, Sides::Front)
        .ok_or_else(|| {
            let (lo, hi) = (bounds.min, bounds.max);
            CliError::input(format_args!(
                "--press {x},{y}: no skin there; it lies within x {:.0} to {:.0} mm, y {:.0} to {:.0} mm",
                lo.x, hi.x, lo.y, hi.y
            ))
        })?;
    let triangle = surface.triangle(hit.triangle);
    let (anchor_mm, normal) = if at_vertex {
        let [a, b, c] = surface.triangles()[hit.triangle as usize];
        let away = |v: u32| surface.positions()[v as usize].distance_squared(hit.point);
        let nearest = [b, c]
            .into_iter()
            .fold(a, |best, v| if away(v) < away(best) { v } else { best });
        (
            surface.positions()[nearest as usize],
            surface.normals()[nearest as usize],
        )
    } else {
        (hit.point, triangle.normal())
    };
    let [dx, dy] = place.drag_mm;
    let drag_mm = libm::hypot(dx, dy);
    if drag_mm > 0.0 && !scene.deform.tangential {
        return Err(CliError::input(format_args!(
            "--press {x},{y}: {} has no [friction], so nothing is dragged; leave dx,dy out",
            scene.scenario.name
        )));
    }
    let along = major_axis_on_skin(normal, libm::atan2(dy, dx));
    let press = Press {
        anchor_mm,
        foot_mm: anchor_mm + along * drag_mm,
        normal,
        depth_mm: place.depth_mm,
        triangle: hit.triangle,
        ..Press::default()
    };
    Ok(match (&scene.ellipse, &scene.ellipse_field) {
        (Some(map), Some(field)) => press.on_map(surface, map, field),
        _ => press,
    })
}

/// What updates take, every other one of slightly shallower presses so that each has something to do.
fn timed(scene: &Scene, drawn: &mut Drawn, presses: &[Press]) -> Timings {
    let surface = &*scene.surface;
    let us = |start: Instant| start.elapsed().as_secs_f64() * 1e6;
    let start = Instant::now();
    drawn.model().prepare(surface);
    let prepare_us = us(start);
    let shallower: Vec<Press> = (presses.iter())
        .map(|p| Press {
            depth_mm: 0.95 * p.depth_mm,
            foot_mm: p.anchor_mm.lerp(p.foot_mm, 0.95),
            ..p.clone()
        })
        .collect();
    let mut skin = Displacement::at_rest(surface);
    let mut strain = Strain::new(surface, &skin);
    let mut times = [const { Vec::new() }; 3];
    let began = Instant::now();
    for i in 0..REPEATS {
        let now = if i % 2 == 0 { presses } else { &shallower };
        let start = Instant::now();
        match drawn {
            Drawn::Fsmd(fsmd) => {
                fsmd.displace(surface, now, &mut skin);
                times[0].push(us(start));
                let start = Instant::now();
                fsmd.shade(surface, &mut skin);
                times[1].push(us(start));
            }
            Drawn::Yardstick(model) => {
                model.update(surface, now, &mut skin);
                times[0].push(us(start));
            }
        }
        let start = Instant::now();
        strain.update(surface, &skin);
        times[2].push(us(start));
        if began.elapsed() > LONGEST {
            break;
        }
    }
    let [displace_us, shade_us, strain_us] = times.map(|mut t| {
        t.sort_unstable_by(f64::total_cmp);
        t.get(t.len() / 2).copied()
    });
    let (displace_us, strain_us) = (displace_us.unwrap_or(0.0), strain_us.unwrap_or(0.0));
    let moved = skin.n_moved();
    let whole_us = displace_us + shade_us.unwrap_or(0.0) + strain_us;
    Timings {
        prepare_us,
        displace_us,
        shade_us,
        strain_us,
        ns_per_vertex: (moved > 0).then(|| whole_us * 1e3 / moved as f64),
    }
}

/// What one press does to the skin under its anchor.
fn told(scene: &Scene, skin: &Displacement, press: &Press) -> Pressed {
    let surface = &*scene.surface;
    let at = surface
        .triangle(press.triangle)
        .closest_point(press.anchor_mm);
    let corners = surface.triangles()[press.triangle as usize];
    let vertex = corners
        .into_iter()
        .find(|&v| surface.positions()[v as usize] == press.anchor_mm);
    let skin_mm = match vertex {
        Some(v) => skin.position(surface, v),
        None => skin.carried(surface, press.triangle, at.barycentric),
    };
    let hip_mm = press.foot_mm - press.normal * press.depth_mm;
    let stiffness_n_per_mm = scene.stiffness.at(press.anchor_mm.truncate());
    let s = &scene.deform;
    let (half_major_mm, half_minor_mm, angle_rad) = press
        .oval
        .map_or((s.half_major_mm, s.half_minor_mm, s.angle_rad), |o| {
            (o.half_major_mm, o.half_minor_mm, o.angle_rad)
        });
    let bone_depth_mm = s.bones.as_ref().map(|bones| {
        let depths = corners.map(|v| bones.depth_mm()[v as usize]);
        depths.iter().zip(at.barycentric).map(|(h, w)| h * w).sum()
    });
    Pressed {
        anchor_mm: press.anchor_mm.to_array(),
        normal: press.normal.to_array(),
        triangle: press.triangle,
        vertex,
        depth_mm: press.depth_mm,
        drag_mm: press.foot_mm.distance(press.anchor_mm),
        hip_mm: hip_mm.to_array(),
        skin_mm: skin_mm.to_array(),
        off_hip_mm: skin_mm.distance(hip_mm),
        stiffness_n_per_mm,
        force_n: scene
            .touch
            .choices
            .force
            .force_n(stiffness_n_per_mm, press.depth_mm, 0.0),
        half_major_mm,
        half_minor_mm,
        direction_deg: angle_rad.to_degrees(),
        irregular: press.boundary_mm.is_some(),
        bone_depth_mm,
    }
}

/// Writes the deformed skin with its fields.
fn write_ply(
    scene: &Scene,
    skin: &Displacement,
    strain: &Strain,
    out: &std::path::Path,
) -> Result<(), CliError> {
    let surface = &*scene.surface;
    let offsets: Vec<Vec3> = (0..skin.n_vertices() as u32)
        .map(|v| skin.offset_mm(v))
        .collect();
    let of = |part: fn(&Vec3) -> f64| offsets.iter().map(part).collect::<Vec<f64>>();
    let stiffness = scene.stiffness.per_vertex(surface);
    let mut columns = vec![
        ("displacement_mm", of(|o| o.length())),
        ("displacement_x_mm", of(|o| o.x)),
        ("displacement_y_mm", of(|o| o.y)),
        ("displacement_z_mm", of(|o| o.z)),
        ("strain", strain.values().to_vec()),
        ("stiffness_n_per_mm", stiffness),
    ];
    if let Some(bones) = &scene.deform.bones {
        columns.push(("bone_depth_mm", bones.depth_mm().to_vec()));
    }
    let fields: Vec<ply::Field<'_>> = (columns.iter())
        .map(|(name, values)| ply::Field { name, values })
        .collect();
    let positions = skin.to_positions(surface);
    let encoding = ply::PlyEncoding::BinaryLittleEndian;
    ply::write(out, &positions, surface.triangles(), &fields, encoding).map_err(CliError::input)
}

fn print_table(p: &Printed) {
    let row = |name: &str, value: String| print(format_args!("{name:<20} {value}"));
    let place = |at: [f64; 3]| format!("{:.2}, {:.2}, {:.2} mm", at[0], at[1], at[2]);
    row("scenario", p.scenario.clone());
    row(
        "model",
        format!("{}, curve {}, footprint {}", p.model, p.curve, p.footprint),
    );
    row(
        "skin",
        format!("{} triangles, {} vertices", p.triangles, p.vertices),
    );
    row(
        "drawn at most",
        format!(
            "{} mm deep, {} mm dragged",
            p.max_normal_mm, p.max_tangential_mm
        ),
    );
    for (i, press) in p.presses.iter().enumerate() {
        row(
            &format!("press {}", i + 1),
            format!(
                "at {}, {:.2} mm deep, dragged {:.2} mm",
                place(press.anchor_mm),
                press.depth_mm,
                press.drag_mm
            ),
        );
        row(
            "  force",
            format!(
                "{:.3} N at {:.3} N/mm",
                press.force_n, press.stiffness_n_per_mm
            ),
        );
        row(
            "  footprint",
            if press.irregular {
                "irregular".to_owned()
            } else {
                format!(
                    "half axes {:.1} and {:.1} mm at {:.1}°",
                    press.half_major_mm, press.half_minor_mm, press.direction_deg
                )
            },
        );
        if let Some(depth_mm) = press.bone_depth_mm {
            row("  bone", format!("{depth_mm:.1} mm deep"));
        }
        row("  finger", place(press.hip_mm));
        let where_ = press
            .vertex
            .map_or("skin at the anchor".to_owned(), |v| format!("vertex {v}"));
        row(
            "  skin there",
            format!(
                "{}, {:.6} mm from the finger ({where_})",
                place(press.skin_mm),
                press.off_hip_mm
            ),
        );
    }
    row(
        "moved",
        format!("{} vertices; {} to be drawn anew", p.moved, p.touched),
    );
    let extreme = |e: &Option<Extreme>, unit: &str, scale: f64| {
        e.map_or("none".to_owned(), |e| {
            format!(
                "{:.3} {unit} at {} (vertex {})",
                e.value * scale,
                place(e.at_mm),
                e.vertex
            )
        })
    };
    row(
        "largest displacement",
        extreme(&p.largest_displacement_mm, "mm", 1.0),
    );
    row("least strain", extreme(&p.strain.least, "%", 100.0));
    row("largest strain", extreme(&p.strain.largest, "%", 100.0));
    let t = &p.timings;
    row("prepared in", format!("{:.1} µs, once", t.prepare_us));
    row(
        "an update takes",
        format!(
            "{:.1} µs: offsets {}, strain {:.1}{}",
            t.displace_us + t.shade_us.unwrap_or(0.0) + t.strain_us,
            match t.shade_us {
                Some(shade_us) => format!("{:.1}, normals {shade_us:.1}", t.displace_us),
                None => format!("and normals {:.1}", t.displace_us),
            },
            t.strain_us,
            t.ns_per_vertex
                .map_or(String::new(), |ns| format!("; {ns:.1} ns per vertex moved"))
        ),
    );
    if let Some(out) = &p.out {
        row("written", out.display().to_string());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_press_is_two_three_or_five_numbers() {
        let press = |x, y, depth_mm, drag_mm| {
            Ok(Place {
                x,
                y,
                depth_mm,
                drag_mm,
            })
        };
        assert_eq!(parse_press("-30,200"), press(-30.0, 200.0, 5.0, [0.0; 2]));
        assert_eq!(parse_press("1, 2, 8.5"), press(1.0, 2.0, 8.5, [0.0; 2]));
        assert_eq!(parse_press("1,2,3,-4,5"), press(1.0, 2.0, 3.0, [-4.0, 5.0]));
        for wrong in [
            "",
            "1",
            "1,2,3,4",
            "1,2,3,4,5,6",
            "a,2",
            "1,nan",
            "1,2,0",
            "1,2,-3",
            "1,2,inf",
            "1,2,3,4,nan",
            "1,2,3,4,1e9",
        ] {
            let error = parse_press(wrong).expect_err(wrong);
            assert!(
                error.starts_with(&format!("\"{wrong}\": ")) && error.contains("mm")
                    || error.contains("finite"),
                "{error}"
            );
        }
    }
}
