//! Table 4.2: which curve meets the finger and the skin at rest without a kink.

use super::{BROWN, GREEN, GREY, INK, VIOLET, series};
use crate::figure::{LinePlot, Mark, Scale};
use crate::geom::law::{Ends, Law, PUBLISHED_WIDTH};
use crate::lab::{Experiment, LabError, Report, Setup, Table, Verdict, Watch};

/// Slope and curvature of every falloff at both its ends, printed beside ours.
pub struct Curves;

/// A slope that counts as none.
const NO_SLOPE: f64 = 1e-12;
/// Steps of q in plots and measures.
const STEPS: u32 = 1000;

/// What table 4.2 prints: slopes at the centre and the rim, and whether the curve is free of symmetry.
struct Printed {
    law: Law,
    slopes: [f64; 2],
    without_symmetry: bool,
}

const PRINTED: [Printed; 3] = [
    Printed {
        law: Law::GaussianPrinted,
        slopes: [0.0, 0.0],
        without_symmetry: true,
    },
    Printed {
        law: Law::Cosine,
        slopes: [0.0, 0.0],
        without_symmetry: false,
    },
    Printed {
        law: Law::Logarithmic,
        slopes: [f64::INFINITY, 0.0],
        without_symmetry: true,
    },
];

impl Experiment for Curves {
    fn name(&self) -> &'static str {
        "deform-curves"
    }

    fn about(&self) -> &'static str {
        "Slope and curvature of every falloff at both ends (table 4.2), printed beside ours"
    }

    fn run(&self, _setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        watch.at("slopes and curvatures", 0.2)?;
        report.tables.push(table());
        watch.at("table 4.2", 0.6)?;
        report.verdicts = verdicts();
        report.draw(
            "curves",
            vec![
                plot("Falloffs from the centre to the rim", "M (share)", Law::at),
                // The logarithm's needle would flatten all others.
                plot("Their slopes, from −5 up", "dM/dq (1)", |law, q| {
                    let slope = law.slope(q);
                    if slope >= -5.0 { slope } else { f64::NAN }
                }),
            ],
        );
        report.note(
            "Slopes are per unit of q; per unit of x = 1.4 q, as METHOD and the publication count for the Gaussian, they are \
             1.4 times smaller. Table 4.2 prints the slopes of rising curves: a falling logarithm has the other sign.",
        );
        report.note(
            "A logarithm that is 1 at the centre and 0 at the rim of a finite range has a finite slope at its steep end and \
             some at its flat one. Both go to what is printed only as the array is made without end finer.",
        );
        Ok(report)
    }
}

fn printed(law: Law) -> Option<&'static Printed> {
    PRINTED.iter().find(|p| p.law == law)
}

/// How far M(q) + M(1 − q) strays from M(0) + M(1): 0 for a curve that is symmetric about its middle.
fn asymmetry(law: Law) -> f64 {
    let whole = law.at(0.0) + law.at(1.0);
    let off = |i: u32| {
        let q = f64::from(i) / f64::from(STEPS);
        (law.at(q) + law.at(1.0 - q) - whole).abs()
    };
    (0..=STEPS).map(off).fold(0.0, f64::max)
}

fn table() -> Table {
    let mut table = Table::new(
        "ends",
        "Value, slope and curvature at both ends, per unit of q, beside table 4.2",
        &[
            "curve",
            "slope at the centre",
            "printed slope at the centre",
            "slope at the rim",
            "printed slope at the rim",
            "curvature at the centre",
            "curvature at the rim",
            "value at the rim",
            "asymmetry",
            "printed without symmetry",
        ],
    );
    for &law in Law::all() {
        let ends = law.ends();
        let p = printed(law);
        // A table holds no infinity: said in words.
        let slope = |i: usize| {
            p.map(|p| {
                if p.slopes[i].is_finite() {
                    p.slopes[i].to_string()
                } else {
                    "+∞".to_owned()
                }
            })
        };
        table.push([
            law.name().into(),
            ends.slope_centre.into(),
            slope(0).into(),
            ends.slope_rim.into(),
            slope(1).into(),
            ends.curvature_centre.into(),
            ends.curvature_rim.into(),
            law.at(1.0).into(),
            asymmetry(law).into(),
            p.map(|p| if p.without_symmetry { "yes" } else { "no" })
                .into(),
        ]);
    }
    table
}

fn verdicts() -> Vec<Verdict> {
    let shown = |e: Ends| {
        let [centre, rim] = [e.slope_centre, e.slope_rim].map(|slope| {
            if slope.abs() <= NO_SLOPE {
                "0".to_owned()
            } else {
                format!("{slope:.4}")
            }
        });
        format!("{centre} at the centre, {rim} at the rim")
    };
    let mut verdicts = Vec::new();
    for p in &PRINTED {
        let ends = p.law.ends();
        let meets = |ours: f64, printed: f64| (ours.abs() - printed).abs() <= NO_SLOPE;
        let holds = meets(ends.slope_centre, p.slopes[0]) && meets(ends.slope_rim, p.slopes[1]);
        let goal = if p.slopes[0].is_finite() {
            "0, 0"
        } else {
            "+∞, 0"
        };
        verdicts.push(Verdict::told(
            format!("table 4.2 on the slopes of {}", p.law.name()),
            shown(ends),
            goal,
            holds,
        ));
        let asymmetry = asymmetry(p.law);
        verdicts.push(Verdict::must(
            format!("table 4.2 on the symmetry of {}", p.law.name()),
            format_args!("asymmetry {asymmetry:.2e}"),
            if p.without_symmetry {
                "none symmetric"
            } else {
                "symmetric: 1e-12"
            },
            (asymmetry > 1e-12) == p.without_symmetry,
        ));
    }
    let gaussian = Law::GaussianPrinted;
    let slope_per_x = gaussian.ends().slope_rim / PUBLISHED_WIDTH;
    verdicts.push(Verdict::must(
        "the printed half Gaussian leaves the rim with a slope and a step",
        format_args!(
            "{slope_per_x:.4} per unit of x, from {:.4}",
            gaussian.at(1.0)
        ),
        "-0.0186, 0.0021",
        (slope_per_x + 0.0186).abs() <= 0.5e-4 && (gaussian.at(1.0) - 0.0021).abs() <= 0.5e-4,
    ));
    let rim = Law::all()
        .iter()
        .filter(|&&l| l != gaussian)
        .map(|l| l.at(1.0).abs());
    let rim = rim.fold(0.0, f64::max);
    verdicts.push(Verdict::must(
        "every other curve ends at exactly 0",
        format_args!("{rim:e} at the rim at most"),
        "0",
        rim == 0.0,
    ));
    verdicts
}

fn plot(title: &str, y_label: &str, of: impl Fn(Law, f64) -> f64) -> LinePlot {
    let colours = [INK, GREY, GREEN, BROWN, VIOLET];
    let line = |(&law, colour): (&Law, [u8; 3])| {
        let mark = if law == Law::GaussianPrinted {
            Mark::Dashed
        } else {
            Mark::Line
        };
        let points = (0..=STEPS)
            .filter(|i| mark == Mark::Line || i % 50 == 0)
            .map(|i| {
                let q = f64::from(i) / f64::from(STEPS);
                [q, of(law, q)]
            });
        series(law.name(), colour, mark, points)
    };
    LinePlot {
        title: title.to_owned(),
        x_label: "location ratio q".to_owned(),
        y_label: y_label.to_owned(),
        x_scale: Scale::Linear,
        y_scale: Scale::Linear,
        series: Law::all().iter().zip(colours).map(line).collect(),
    }
}
