//! How fine the array of a curve must be (Ji 2008, 4.2.1 and Fig. 4.9).

use super::{AMBER, GREEN, INK, VIOLET, series};
use crate::deform::curve::{Curve, Lookup};
use crate::deform::models::fsmd::{Fsmd, Settings};
use crate::deform::{Displacement, Model as _, Press};
use crate::figure::{LinePlot, Mark, Scale};
use crate::geom::Vec3;
use crate::geom::law::Law;
use crate::lab::{Experiment, LabError, Report, Samples, Setup, Stopwatch, Table, Verdict, Watch};
use crate::surface::Surface;
use crate::surface::back::{BackOptions, make};
use std::hint::black_box;

/// Sizes of the array compared in Fig. 4.9, read as published and linearly, and the function itself: error against cost.
pub struct CurveArrays;

const SIZES: [usize; 3] = [20, 130, 700];
/// Depth of the dent, mm.
const DEPTH_MM: f64 = 10.0;
/// Steps of q over which errors are looked for: a multiple of none of the arrays.
const STEPS: usize = 200_003;
/// Ratios looked up in one timing.
const LOOKUPS: usize = 4096;
/// Triangles of the built-in back that is pressed.
const TRIANGLES: usize = 41_582;
const TRIANGLES_QUICK: usize = 2962;

/// One array and lookup.
struct Row {
    curve: Curve,
    largest_mm: f64,
    rms_mm: f64,
    step_mm: f64,
    bound_mm: f64,
    lookup_ns: f64,
    update_ns: f64,
}

impl Experiment for CurveArrays {
    fn name(&self) -> &'static str {
        "deform-curve-arrays"
    }

    fn about(&self) -> &'static str {
        "Arrays of 20, 130 and 700 samples (Fig. 4.9), by lookup, against the function: error in mm against cost"
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        let (n_triangles, repeats) = if setup.quick {
            (TRIANGLES_QUICK, 15)
        } else {
            (TRIANGLES, 101)
        };
        watch.at("building the back", 0.0)?;
        let skin = Surface::new(make(&BackOptions::with_triangles(n_triangles)))
            .map_err(|e| LabError::Input(e.to_string()))?
            .0;
        report.set("curve", Law::GaussianPrinted.name());
        report.set("depth", format_args!("{DEPTH_MM} mm"));
        report.set(
            "surface",
            format_args!("built-in back, {} triangles", skin.triangles().len()),
        );
        report.set("repetitions", repeats);
        let arrays = SIZES.map(|n| [(n, Lookup::Nearest), (n, Lookup::Linear)]);
        let all: Vec<_> = (arrays.into_iter().flatten())
            .chain([(SIZES[2], Lookup::Exact)])
            .collect();
        let mut rows = Vec::new();
        for (i, &(n, lookup)) in all.iter().enumerate() {
            let what = format!("{} of {n}", lookup.name());
            watch.at(&what, 0.1 + 0.9 * i as f64 / all.len() as f64)?;
            rows.push(measured(
                Curve::of(Law::GaussianPrinted, n, lookup),
                &skin,
                repeats,
            ));
        }
        report.tables.push(table(&rows));
        report.verdicts = verdicts(&rows);
        report.draw("error-against-cost", vec![error_against_cost(&rows)]);
        report.draw("error-along-radius", vec![error_along_radius()]);
        report.note(
            "Fig. 4.9 compares sizes by eye under the published nearest lookup. A linear lookup of the array of 20 is as close \
             as the nearest one of more than 250, and leaves no terraces.",
        );
        Ok(report)
    }
}

fn measured(curve: Curve, skin: &Surface, repeats: usize) -> Row {
    let (mut largest_mm, mut sum, mut weights) = (0.0_f64, 0.0, 0.0);
    for i in 0..STEPS {
        let q = i as f64 / STEPS as f64;
        let off_mm = DEPTH_MM * (curve.at(q) - curve.exact(q));
        largest_mm = largest_mm.max(off_mm.abs());
        // A ring of the footprint holds the more skin the farther out it lies.
        sum += q * off_mm * off_mm;
        weights += q;
    }
    let steps = curve.samples().windows(2).map(|w| (w[0] - w[1]).abs());
    let step_mm = match curve.lookup() {
        Lookup::Nearest => DEPTH_MM * steps.fold(0.0, f64::max),
        Lookup::Linear | Lookup::Exact => 0.0,
    };
    Row {
        largest_mm,
        rms_mm: (sum / weights).sqrt(),
        step_mm,
        bound_mm: bound_mm(&curve),
        lookup_ns: lookup_ns(&curve, repeats),
        update_ns: update_ns(&curve, skin, repeats),
        curve,
    }
}

/// What theory allows: half a step of the array at the steepest place, or h²/8 at the most curved.
fn bound_mm(curve: &Curve) -> f64 {
    let h = 1.0 / (curve.samples().len() - 1) as f64;
    let most = |of: fn(Law, f64) -> f64| {
        let places = (0..=10_000).map(|i| of(Law::GaussianPrinted, f64::from(i) / 10_000.0).abs());
        places.fold(0.0, f64::max)
    };
    DEPTH_MM
        * match curve.lookup() {
            Lookup::Nearest => 0.5 * h * most(Law::slope),
            Lookup::Linear => 0.125 * h * h * most(Law::curvature),
            Lookup::Exact => 0.0,
        }
}

fn lookup_ns(curve: &Curve, repeats: usize) -> f64 {
    // Ratios in no order, as vertices come.
    let ratios: Vec<f64> = (0..LOOKUPS)
        .map(|i| (i as f64 * 0.618_033_988_75).fract())
        .collect();
    let watch = Stopwatch::new();
    let times = (0..repeats).map(|_| {
        let sum = || ratios.iter().map(|&q| curve.at(black_box(q))).sum::<f64>();
        watch.time(|| black_box(sum())).1 * 1e3 / LOOKUPS as f64
    });
    Samples::from_iter(times).median()
}

/// One whole update of the offsets under a press and a drag, ns per vertex moved.
fn update_ns(curve: &Curve, skin: &Surface, repeats: usize) -> f64 {
    let mut model = Fsmd::new(Settings {
        curve: curve.clone(),
        ..Settings::default()
    });
    model.prepare(skin);
    let mut out = Displacement::at_rest(skin);
    let watch = Stopwatch::new();
    let times = (0..repeats).filter_map(|i| {
        let press = press(skin, if i % 2 == 0 { DEPTH_MM } else { 0.9 * DEPTH_MM })?;
        let ((), us) = watch.time(|| model.displace(skin, &[press], &mut out));
        Some(us * 1e3 / out.n_moved().max(1) as f64)
    });
    Samples::from_iter(times).median()
}

/// A press on the vertex nearest to the middle of the back.
fn press(skin: &Surface, depth_mm: f64) -> Option<Press> {
    let middle = skin.bounds().centre().truncate();
    let from_middle = |v: &u32| {
        let at = skin.positions()[*v as usize].truncate();
        at.distance_squared(middle)
    };
    let vertex = (0..skin.positions().len() as u32)
        .min_by(|a, b| from_middle(a).total_cmp(&from_middle(b)))?;
    let anchor_mm = skin.positions()[vertex as usize];
    Some(Press {
        anchor_mm,
        foot_mm: anchor_mm + Vec3::Y * depth_mm,
        normal: skin.normals()[vertex as usize],
        depth_mm,
        triangle: *skin.topology().triangles_of(vertex).first()?,
        ..Press::default()
    })
}

fn table(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "arrays",
        "Error at 10 mm depth against the function (RMS over the area of the footprint), and cost per vertex",
        &[
            "samples",
            "lookup",
            "largest error (mm)",
            "rms error (mm)",
            "largest terrace (mm)",
            "bound of theory (mm)",
            "one lookup (ns)",
            "whole update (ns per vertex)",
        ],
    );
    for row in rows {
        let exact = row.curve.lookup() == Lookup::Exact;
        table.push([
            (!exact).then(|| row.curve.samples().len()).into(),
            row.curve.lookup().name().into(),
            row.largest_mm.into(),
            row.rms_mm.into(),
            row.step_mm.into(),
            row.bound_mm.into(),
            row.lookup_ns.into(),
            row.update_ns.into(),
        ]);
    }
    table
}

fn verdicts(rows: &[Row]) -> Vec<Verdict> {
    let excess = |row: &Row| row.largest_mm - row.bound_mm * (1.0 + 1e-9);
    let most = rows.iter().map(excess).fold(f64::NEG_INFINITY, f64::max);
    let of = |n: usize, lookup: Lookup| {
        let found = |r: &&Row| r.curve.samples().len() == n && r.curve.lookup() == lookup;
        rows.iter().find(found).map_or(f64::NAN, |r| r.largest_mm)
    };
    let nearest = SIZES.map(|n| of(n, Lookup::Nearest));
    let linear = SIZES.map(|n| of(n, Lookup::Linear));
    let shown = |errors: [f64; 3]| {
        let [a, b, c] = errors.map(|e| format!("{e:.2e}"));
        format!("{a}, {b}, {c} mm")
    };
    vec![
        Verdict::must(
            "no lookup is farther off than theory allows",
            format_args!("largest error less its bound: {most:.1e} mm"),
            "at most 0 mm",
            most <= 0.0,
        ),
        Verdict::must(
            "a finer array is closer",
            format_args!("nearest {}; linear {}", shown(nearest), shown(linear)),
            "falling from 20 over 130 to 700",
            [nearest, linear].iter().all(|e| e[0] > e[1] && e[1] > e[2]),
        ),
        Verdict::told(
            "\"a higher resolution than 700 is not necessary\" (4.2.1): its terraces cannot be seen",
            format_args!("{:.3} mm with the nearest lookup", nearest[2]),
            "0.05 mm, a tenth of a pixel with 400 mm over 800 pixels",
            nearest[2] <= 0.05,
        ),
        Verdict::must(
            "a linear lookup of 20 is closer than the nearest of 130",
            format_args!("{:.3} mm against {:.3} mm", linear[0], nearest[1]),
            "less",
            linear[0] < nearest[1],
        ),
    ]
}

fn error_against_cost(rows: &[Row]) -> LinePlot {
    // On a logarithmic axis the function, which is the yardstick, has no place.
    let of = |lookup: Lookup| {
        let those = rows.iter().filter(move |r| r.curve.lookup() == lookup);
        those.map(|r| [r.update_ns, r.largest_mm])
    };
    let name = |lookup: Lookup| format!("{} of 20, 130, 700 from above", lookup.name());
    LinePlot {
        title: "Largest error at 10 mm depth against the cost of a whole update".to_owned(),
        x_label: "cost (ns per vertex)".to_owned(),
        y_label: "error (mm)".to_owned(),
        x_scale: Scale::Linear,
        y_scale: Scale::Logarithmic,
        series: vec![
            series(
                name(Lookup::Nearest),
                AMBER,
                Mark::Points,
                of(Lookup::Nearest),
            ),
            series(
                name(Lookup::Linear),
                GREEN,
                Mark::Points,
                of(Lookup::Linear),
            ),
        ],
    }
}

fn error_along_radius() -> LinePlot {
    let of = |n: usize, lookup: Lookup| {
        let curve = Curve::of(Law::GaussianPrinted, n, lookup);
        (0..2000).map(move |i| {
            let q = f64::from(i) / 2000.0;
            [q, DEPTH_MM * (curve.at(q) - curve.exact(q))]
        })
    };
    LinePlot {
        title: "Error along a radius at 10 mm depth".to_owned(),
        x_label: "location ratio q".to_owned(),
        y_label: "error (mm)".to_owned(),
        x_scale: Scale::Linear,
        y_scale: Scale::Linear,
        series: vec![
            series("nearest of 20", AMBER, Mark::Line, of(20, Lookup::Nearest)),
            series(
                "nearest of 130",
                VIOLET,
                Mark::Line,
                of(130, Lookup::Nearest),
            ),
            series("nearest of 700", INK, Mark::Line, of(700, Lookup::Nearest)),
            series("linear of 20", GREEN, Mark::Line, of(20, Lookup::Linear)),
        ],
    }
}
