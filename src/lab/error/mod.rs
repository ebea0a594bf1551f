//! Error against run time: every model of the drawn skin beside a fine finite-element slab, on one press, and every way to
//! feel it beside a very high rate, along one motion; and what becomes of the error in the course of a session.
//!
//! | file | answers |
//! |---|---|
//! | `bench` | which press on which skin, what the truth is, how far off a shape is |
//! | `subject` | which models at which settings |
//! | `felt` | which engines, rates and meshes, and how far off the force is |
//! | `front` | which of them nothing else beats |
//! | `session` | drift, energy and repetition over the time of a session |

mod bench;
mod felt;
mod front;
mod session;
mod subject;

use super::{Choice, Experiment, LabError, Report, Setup, Table, Value, Verdict, Watch};
use crate::scenario::{Scenario, SurfaceChoice, default_example};
use bench::{Bench, Found};
use felt::{Felt, Path, Way};
use front::Point;

use session::Run;

pub use session::ErrorOverSession;

/// Error against run time.
pub struct ErrorVsTime;

/// An error that a hand does not feel and an eye hardly sees, mm: what a recommendation is made for.
const WITHIN_MM: f64 = 0.5;
/// Smallest difference in force that a finger tells, as a share of the force (Pang, Tan and Durlach 1991: 5 to 10 %).
const JND_SHARE: f64 = 0.07;
/// What is smaller is drawn here, mm and N: an error of 0 has no place on a logarithmic axis.
const LEAST_ERROR: f64 = 1.0e-6;

impl Experiment for ErrorVsTime {
    fn name(&self) -> &'static str {
        "error-vs-time"
    }

    fn about(&self) -> &'static str {
        "Every model of the drawn skin and every way to feel it, at several settings: how far off, at which cost"
    }

    fn takes(&self) -> &'static [Choice] {
        &[Choice::Scene, Choice::Session, Choice::Triangles]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        let mut part = watch.part(0.0, 0.05);
        let (scene, press, motion) = match &setup.session {
            Some(path) => Run::read(path, setup, &mut part)?.into_press()?,
            None => {
                let scene = felt::built(scenario(setup)?, &mut part)?;
                let motion = felt::scripted(&scene, setup.quick);
                (scene, None, motion)
            }
        };
        let bench = Bench::new(scene, press, setup, &mut watch.part(0.05, 0.2))?;
        bench.describe(&mut report);
        let drawn = drawn(&bench, setup, &mut watch.part(0.2, 0.8))?;
        tell_drawn(&bench, &drawn, &mut report);
        let mut part = watch.part(0.8, 1.0);
        let path = Path::new(&bench.scene, motion, &mut part)?;
        let felt = felt(&path, setup, &mut part)?;
        tell_felt(&path, &felt, &mut report);
        Ok(report)
    }
}

/// The scene asked for, with the triangles asked for.
fn scenario(setup: &Setup) -> Result<Scenario, LabError> {
    let mut scenario = match &setup.scene {
        Some(scene) => Scenario::clone(&scene.scenario),
        None => {
            let example = default_example();
            Scenario::parse(example.text, example.file, None)
                .map_err(|e| LabError::Input(e.to_string()))?
        }
    };
    match (&mut scenario.surface, setup.triangles.last()) {
        (_, None) => {}
        (SurfaceChoice::BuiltinBack { triangles }, Some(asked)) => *triangles = *asked,
        (SurfaceChoice::Mesh { .. }, Some(_)) => {
            let why = "the scene has a mesh of its own: its number of triangles cannot be chosen";
            return Err(LabError::Input(why.to_owned()));
        }
    }
    Ok(scenario)
}

/// One model at one setting, measured.
struct Drawn {
    family: &'static str,
    setting: String,
    found: Found,
}

impl Drawn {
    fn point(&self) -> Point {
        Point {
            cost: self.found.median_us,
            error: self.found.rms_mm,
        }
    }

    /// Models that know their force are felt as they are drawn; the yardsticks are no models of a scene.
    fn is_fsmd(&self) -> bool {
        self.family == "fsmd"
    }
}

fn drawn(bench: &Bench, setup: &Setup, watch: &mut Watch<'_>) -> Result<Vec<Drawn>, LabError> {
    let candidates = subject::all(setup.quick);
    let n = candidates.len() as f64;
    let mut rows = Vec::new();
    for (i, candidate) in candidates.into_iter().enumerate() {
        let what = format!("{}, {}", candidate.family, candidate.setting);
        watch.at(&what, i as f64 / n)?;
        let mut part = watch.part(i as f64 / n, (i + 1) as f64 / n);
        let found = setup
            .shelf
            .part(&what, || bench.measure(&*candidate.make, &mut part))?;
        rows.push(Drawn {
            family: candidate.family,
            setting: candidate.setting,
            found,
        });
    }
    Ok(rows)
}

fn tell_drawn(bench: &Bench, rows: &[Drawn], report: &mut Report) {
    let points: Vec<Point> = rows.iter().map(Drawn::point).collect();
    let on_front = front::on_front(&points);
    let mut table = Table::new(
        "drawn",
        format!(
            "One press {:.1} mm deep: how far off a fine slab, and the cost of an update",
            bench.depth_mm()
        ),
        &[
            "model",
            "setting",
            "median (µs)",
            "p99 (µs)",
            "RMS (mm)",
            "largest (mm)",
            "relative (%)",
            "dent alone (%)",
            "force (N)",
            "force off (N)",
            "force off, of JND (%)",
            "strain off",
            "on the front",
        ],
    );
    for (row, on_front) in rows.iter().zip(&on_front) {
        let f = &row.found;
        let off = f.force_n.map(|force_n| force_n - bench.force_n());
        let of_jnd = off.map(|off| 100.0 * off.abs() / (JND_SHARE * bench.force_n()));
        table.push([
            row.family.into(),
            row.setting.as_str().into(),
            f.median_us.into(),
            f.p99_us.into(),
            f.rms_mm.into(),
            f.max_mm.into(),
            (100.0 * f.relative).into(),
            (100.0 * f.dent_relative).into(),
            f.force_n.into(),
            off.into(),
            of_jnd.into(),
            f.strain_off.into(),
            Value::Text(if *on_front { "yes" } else { "" }.to_owned()),
        ]);
    }
    report.tables.push(table);
    let rows_of: Vec<(&str, Point)> = rows.iter().map(|r| (r.family, r.point())).collect();
    let labels = [
        "median cost of an update (µs)",
        "RMS error of the shape (mm)",
    ];
    let plot = front::plot(
        "Drawn skin",
        labels,
        &subject::FAMILIES,
        &rows_of,
        LEAST_ERROR,
    );
    report.draw("drawn", vec![plot]);

    let decades = front::decades(&points);
    report.verdicts.push(Verdict::told(
        "settings of drawn models, and decades of cost between them",
        format!("{} over {decades:.1}", rows.len()),
        "12 over 3",
        rows.len() >= 12 && decades >= 3.0,
    ));
    let finite = rows.iter().filter(|r| !r.found.finite).count();
    report.verdicts.push(Verdict::must(
        "shapes that are not finite",
        finite,
        "0",
        finite == 0,
    ));
    let of = |word: &str| {
        let rows = rows
            .iter()
            .filter(|r| r.is_fsmd() && r.setting.contains(word));
        rows.map(|r| 100.0 * r.found.dent_relative)
            .fold(f64::INFINITY, f64::min)
    };
    let fitted = of("fitted");
    report.verdicts.push(Verdict::told(
        "FSMD with its footprint fitted to the slab, relative error of the dent (L2 along the normal)",
        format!("{fitted:.1} %"),
        "10 to 12 % of a bonded layer of 15 to 20 mm",
        fitted < 13.0,
    ));
    report.note(format!(
        "The dent of FSMD as the scene has it is {:.0} % off, with one wide footprint, as printed, {:.0} %: that of a layer \
         on bone is many times narrower.",
        of("scene"),
        of("wide")
    ));
    let worst: Vec<f64> = rows.iter().map(|r| r.found.max_mm).collect();
    let what = format!(
        "For a press {:.1} mm deep in this scene, drawn within {WITHIN_MM} mm everywhere: ",
        bench.depth_mm()
    );
    report.note(
        what + &match front::cheapest(&points, &worst, WITHIN_MM) {
            Some(i) => format!(
                "{}, {}, {:.0} µs an update.",
                rows[i].family, rows[i].setting, points[i].cost
            ),
            None => "none of these.".to_owned(),
        },
    );
    let rms: Vec<f64> = points.iter().map(|p| p.error).collect();
    if let Some(i) = front::cheapest(&points, &rms, WITHIN_MM) {
        report.note(format!(
            "Within {WITHIN_MM} mm RMS: {}, {}, {:.0} µs an update.",
            rows[i].family, rows[i].setting, points[i].cost
        ));
    }
    report.note(
        "The truth is a body for small strains, as all its yardsticks here but one: bricks that turn (fem-corotated) are \
         softer the deeper one presses, and what they are off by is how far small strains carry.",
    );
    report.note(
        "Models that move the skin along the normal alone miss what goes sideways: \"dent alone\" leaves that out. The force \
         of FSMD is that of the stiffness map, stiffness times depth, whatever is drawn. Every update finds the \
         vertices anew, moves them and renews their normals by the same means, whichever model says where they go.",
    );
}

fn felt(
    path: &Path<'_>,
    setup: &Setup,
    watch: &mut Watch<'_>,
) -> Result<Vec<(Way, Felt)>, LabError> {
    let ways = felt::ways(setup.quick);
    let n = ways.len() as f64;
    let mut rows = Vec::new();
    for (i, way) in ways.into_iter().enumerate() {
        if path.is_fixed() && matches!(way.engine, felt::Engine::Mesh(_)) {
            continue;
        }
        let what = format!("{}, {}", way.family, way.setting);
        watch.at(&what, i as f64 / n)?;
        let mut part = watch.part(i as f64 / n, (i + 1) as f64 / n);
        let felt = setup.shelf.part(&what, || path.measure(&way, &mut part))?;
        rows.push((way, felt));
    }
    Ok(rows)
}

fn tell_felt(path: &Path<'_>, rows: &[(Way, Felt)], report: &mut Report) {
    let point = |f: &Felt| Point {
        cost: f.ms_per_s,
        error: f.rms_n,
    };
    let points: Vec<Point> = rows.iter().map(|(_, f)| point(f)).collect();
    let on_front = front::on_front(&points);
    let mut table = Table::new(
        "felt",
        format!(
            "A motion over the skin, up to {:.1} N: how far off the force of the production engine at 10 kHz, and the cost",
            path.largest_n()
        ),
        &[
            "engine",
            "setting",
            "rate (Hz)",
            "median (µs)",
            "p99 (µs)",
            "work (ms/s)",
            "RMS (N)",
            "largest (N)",
            "off, of JND (%)",
            "skin missed (ms)",
            "on the front",
        ],
    );
    for ((way, f), on_front) in rows.iter().zip(&on_front) {
        table.push([
            way.family.into(),
            way.setting.into(),
            way.rate_hz.into(),
            f.median_us.into(),
            f.p99_us.into(),
            f.ms_per_s.into(),
            f.rms_n.into(),
            f.max_n.into(),
            (100.0 * f.relative / JND_SHARE).into(),
            f.missed_ms.into(),
            Value::Text(if *on_front { "yes" } else { "" }.to_owned()),
        ]);
    }
    report.tables.push(table);
    let rows_of: Vec<(&str, Point)> = rows.iter().map(|(w, f)| (w.family, point(f))).collect();
    let labels = [
        "work per second of session (ms)",
        "RMS error of the force (N)",
    ];
    let plot = front::plot("Felt force", labels, &felt::FAMILIES, &rows_of, LEAST_ERROR);
    report.draw("felt", vec![plot]);
    let relative: Vec<f64> = rows.iter().map(|(_, f)| f.relative).collect();
    if let Some(i) = front::cheapest(&points, &relative, JND_SHARE) {
        let (way, felt) = &rows[i];
        report.note(format!(
            "For a force whose error a finger does not tell (RMS within {:.0} % of it, Pang, Tan and Durlach 1991): {}, {}, \
             {:.2} ms of work a second. What a device renders stably asks for a higher rate: see stability-border.",
            100.0 * JND_SHARE,
            way.family,
            way.setting,
            felt.ms_per_s
        ));
    }
}
