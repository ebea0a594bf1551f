//! The printed location ratio (Ji 2008, eq. 4.13) against the true ellipse.

use super::{AMBER, GREEN, INK, VIOLET, series};
use crate::deform::curve::Curve;
use crate::deform::footprint::{Ellipse, Outline as _, PrintedEllipse};
use crate::figure::{LinePlot, Mark, Scale};
use crate::geom::Vec3;
use crate::lab::{Experiment, LabError, Report, Setup, Table, Verdict, Watch};
use std::f64::consts::{FRAC_PI_2, SQRT_2};

/// How far the boundary of eq. 4.13 lies outside the ellipse it is meant for, and what that does to a dent.
pub struct LocationRatio;

/// Axis ratios of the table: the one most unlike a circle of appendix C's means (1.357) and where convexity ends among them.
const RATIOS: [f64; 14] = [
    1.0, 1.1, 1.2, 1.3, 1.357, SQRT_2, 1.5, 1.75, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0,
];
/// METHOD's check values: axis ratio, how much too far out, %.
const CHECKED: [(f64, f64, f64); 3] = [(1.357, 4.7, 0.05), (2.0, 25.0, 1e-9), (5.0, 160.0, 1e-9)];
/// Directions looked at in a quarter of a turn; 45° is among them.
const DIRECTIONS: u32 = 900;
/// Places looked at along each direction.
const PLACES: u32 = 200;
/// Depth of the dent whose error is told, mm.
const DEPTH_MM: f64 = 10.0;

/// What the printed ratio does to the ellipse of one axis ratio.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Excess {
    /// Major over minor axis.
    pub axis_ratio: f64,
    /// Largest distance of the printed boundary from the centre over that of the ellipse in the same direction, less 1.
    pub boundary: f64,
    /// In which direction from the major axis it is largest, rad.
    pub direction_rad: f64,
    /// Area inside the printed boundary over that of the ellipse, less 1.
    pub area: f64,
    /// Largest difference of M(q) by the default curve, as a share of the displacement at the centre.
    pub displacement: f64,
}

/// Closed form of [`Excess::boundary`]: (ρ + 1/ρ)/2 − 1 for the axis ratio ρ, found at 45°.
///
/// The squared distances are a² cos²β + b² sin²β as printed and 1/(cos²β/a² + sin²β/b²) of the ellipse; their quotient is
/// 1 + sin²β cos²β (ρ − 1/ρ)².
pub fn boundary_excess(axis_ratio: f64) -> f64 {
    0.5 * (axis_ratio + 1.0 / axis_ratio) - 1.0
}

/// What the printed ratio does at one axis ratio, found with the outlines themselves; zeros for a ratio that is not a
/// positive number.
pub fn excess_at(axis_ratio: f64) -> Excess {
    let outlines = (
        PrintedEllipse::new(Vec3::ZERO, Vec3::Z, axis_ratio, 1.0, 0.0),
        Ellipse::new(Vec3::ZERO, Vec3::Z, axis_ratio, 1.0, 0.0),
    );
    let (Some(printed), Some(ellipse)) = outlines else {
        return Excess::default();
    };
    let curve = Curve::gaussian();
    let mut excess = Excess {
        axis_ratio,
        ..Excess::default()
    };
    let (mut area, mut true_area) = (0.0, 0.0);
    for i in 0..=DIRECTIONS {
        let beta = FRAC_PI_2 * f64::from(i) / f64::from(DIRECTIONS);
        let (sin, cos) = libm::sincos(beta);
        let radius = printed.radius_mm(beta);
        let at = |share: f64| Vec3::new(cos, sin, 0.0) * (share * radius);
        // The ellipse's ratio grows along a ray in proportion: at the printed boundary it tells how much farther that is.
        let farther = ellipse.ratio(at(1.0));
        if farther - 1.0 > excess.boundary {
            (excess.boundary, excess.direction_rad) = (farther - 1.0, beta);
        }
        let weight = if i == 0 || i == DIRECTIONS { 0.5 } else { 1.0 };
        area += weight * radius * radius;
        true_area += weight * (radius / farther) * (radius / farther);
        for j in 0..PLACES {
            let at = at(f64::from(j) / f64::from(PLACES));
            let off = (curve.at(printed.ratio(at)) - curve.at(ellipse.ratio(at))).abs();
            excess.displacement = excess.displacement.max(off);
        }
    }
    excess.area = area / true_area - 1.0;
    excess
}

impl Experiment for LocationRatio {
    fn name(&self) -> &'static str {
        "deform-location-ratio"
    }

    fn about(&self) -> &'static str {
        "The printed location ratio (4.13) against the true ellipse, by axis ratio: boundary, area, displacement"
    }

    fn run(&self, _setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        report.set("depth", format_args!("{DEPTH_MM} mm"));
        report.set("curve", Curve::gaussian().name());
        let mut rows = Vec::new();
        for (i, &ratio) in RATIOS.iter().enumerate() {
            let share = i as f64 / RATIOS.len() as f64;
            watch.at(&format!("axis ratio {ratio:.3}"), share)?;
            rows.push(excess_at(ratio));
        }
        report.tables.push(table(&rows));
        report.verdicts = verdicts(&rows);
        report.draw("excess", vec![excess_plot(&rows), displacement_plot(&rows)]);
        report.draw(
            "outlines",
            RATIOS[4..]
                .iter()
                .filter(|r| [1.357, 2.0, 5.0].contains(*r))
                .map(|&r| outlines(r))
                .collect(),
        );
        report.note(
            "The derivation takes the angle of D from the major axis for the parametric angle of the ellipse. The boundary that \
             results meets the ellipse at the ends of its axes and lies outside elsewhere: farthest at 45°, by (ρ + 1/ρ)/2 − 1 of \
             the distance. Its area is too large by the same share. Beyond an axis ratio of √2 it is not even convex.",
        );
        Ok(report)
    }
}

fn table(rows: &[Excess]) -> Table {
    let mut table = Table::new(
        "excess",
        "Printed boundary against the ellipse, and the largest error of a dent of 10 mm",
        &[
            "axis ratio",
            "too far out (%)",
            "closed form (%)",
            "direction (°)",
            "area too large (%)",
            "largest error (mm)",
            "convex",
        ],
    );
    for row in rows {
        table.push([
            row.axis_ratio.into(),
            (100.0 * row.boundary).into(),
            (100.0 * boundary_excess(row.axis_ratio)).into(),
            (row.axis_ratio > 1.0)
                .then(|| row.direction_rad.to_degrees())
                .into(),
            (100.0 * row.area).into(),
            (DEPTH_MM * row.displacement).into(),
            if row.axis_ratio <= SQRT_2 {
                "yes"
            } else {
                "no"
            }
            .into(),
        ]);
    }
    table
}

fn verdicts(rows: &[Excess]) -> Vec<Verdict> {
    let mut verdicts: Vec<Verdict> = CHECKED
        .iter()
        .map(|&(ratio, percent, tolerance)| {
            let found = rows.iter().find(|r| r.axis_ratio == ratio);
            let found = found.map_or(f64::NAN, |r| 100.0 * r.boundary);
            Verdict::must(
                format!("too far out at an axis ratio of {ratio}"),
                format_args!("{found:.2} %"),
                format_args!("{percent} %"),
                (found - percent).abs() <= tolerance,
            )
        })
        .collect();
    let off = |row: &Excess| (row.boundary - boundary_excess(row.axis_ratio)).abs();
    let worst = rows.iter().map(off).fold(0.0, f64::max);
    let area_off = |row: &Excess| (row.area - boundary_excess(row.axis_ratio)).abs();
    let worst_area = rows.iter().map(area_off).fold(0.0, f64::max);
    verdicts.push(Verdict::must(
        "the outlines give what the closed form says",
        format_args!("boundary off by at most {worst:.1e}, area by {worst_area:.1e}"),
        "1e-9",
        worst <= 1e-9 && worst_area <= 1e-9,
    ));
    let circle = rows.first().map_or(f64::NAN, |r| r.displacement);
    verdicts.push(Verdict::must(
        "for a circle both ratios are the same",
        format_args!("displacement differs by {circle:.1e} of that at the centre"),
        "1e-12",
        circle <= 1e-12,
    ));
    verdicts
}

fn excess_plot(rows: &[Excess]) -> LinePlot {
    let closed = (0..=200).map(|i| 1.0 + 4.0 * f64::from(i) / 200.0);
    LinePlot {
        title: "How far outside the ellipse the printed boundary lies".to_owned(),
        x_label: "axis ratio".to_owned(),
        y_label: "too far out (%)".to_owned(),
        x_scale: Scale::Linear,
        y_scale: Scale::Linear,
        series: vec![
            series(
                "closed form",
                INK,
                Mark::Line,
                closed.map(|r| [r, 100.0 * boundary_excess(r)]),
            ),
            series(
                "by the outlines",
                AMBER,
                Mark::Points,
                rows.iter().map(|r| [r.axis_ratio, 100.0 * r.boundary]),
            ),
        ],
    }
}

fn displacement_plot(rows: &[Excess]) -> LinePlot {
    LinePlot {
        title: "Largest error of a dent of 10 mm".to_owned(),
        x_label: "axis ratio".to_owned(),
        y_label: "error (mm)".to_owned(),
        x_scale: Scale::Linear,
        y_scale: Scale::Linear,
        series: vec![series(
            "printed less true",
            VIOLET,
            Mark::Joined,
            rows.iter()
                .map(|r| [r.axis_ratio, DEPTH_MM * r.displacement]),
        )],
    }
}

/// A quarter of both boundaries, in units of the half minor axis.
fn outlines(axis_ratio: f64) -> LinePlot {
    let angles = || (0..=180).map(|i| FRAC_PI_2 * f64::from(i) / 180.0);
    let ellipse = angles().map(|t| [axis_ratio * libm::cos(t), libm::sin(t)]);
    let printed = PrintedEllipse::new(Vec3::ZERO, Vec3::Z, axis_ratio, 1.0, 0.0);
    let printed = angles().filter_map(|t| {
        let radius = printed.as_ref()?.radius_mm(t);
        Some([radius * libm::cos(t), radius * libm::sin(t)])
    });
    LinePlot {
        title: format!("A quarter of both boundaries at an axis ratio of {axis_ratio}"),
        x_label: "along the major axis (half minor axes)".to_owned(),
        y_label: "across (half minor axes)".to_owned(),
        x_scale: Scale::Linear,
        y_scale: Scale::Linear,
        series: vec![
            series("ellipse", GREEN, Mark::Line, ellipse),
            series("as printed", AMBER, Mark::Line, printed),
        ],
    }
}
