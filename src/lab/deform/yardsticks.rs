//! How near a functional shape can come to what elasticity says: the falloff fitted to every closed form.

use super::{AMBER, BROWN, GREEN, GREY, INK, VIOLET, series};
use crate::figure::{LinePlot, Mark, Scale};
use crate::geom::curve::Curve;
use crate::lab::{Experiment, LabError, Report, Setup, Table, Value, Verdict, Watch};
use crate::reference::{self, Dent, Elastic, layer};

/// The dent of FSMD beside closed forms of elastic bodies.
pub struct Yardsticks;

/// Depth of every dent, mm.
const DEPTH_MM: f64 = 5.0;
/// Dents are compared over the skin within this radius, mm.
const WITHIN_MM: f64 = 100.0;
/// Rings over which differences are summed.
const RINGS: u32 = 2000;
/// Radii that a footprint may have, mm.
const FOOTPRINTS_MM: [f64; 2] = [3.0, 100.0];

/// A dent, its name, and what METHOD 6 leads one to expect of the best fit to it, %.
type Yardstick = (String, Box<dyn Dent>, Option<[f64; 2]>);

impl Experiment for Yardsticks {
    fn name(&self) -> &'static str {
        "deform-yardsticks"
    }

    fn about(&self) -> &'static str {
        "How far the best-fitting FSMD dent stays from closed forms of elastic bodies, and the printed footprint"
    }

    fn run(&self, _setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        report.set("depth", format!("{DEPTH_MM} mm"));
        report.set(
            "compared",
            format!("the skin within {WITHIN_MM} mm, by area"),
        );
        let curve = Curve::gaussian();
        let mut table = Table::new(
            "yardsticks",
            "FSMD's dent against elastic bodies (E = 25 kPa, ν = 0.45), relative error (L2)",
            &[
                "body",
                "force N",
                "half depth at mm",
                "best footprint mm",
                "best fit off %",
                "printed footprint off %",
            ],
        );
        let mut plots = Vec::new();
        let all = yardsticks();
        for (i, (name, dent, expected)) in all.iter().enumerate() {
            watch.at(name, i as f64 / all.len() as f64)?;
            let (radius_mm, off) = best_fit(&curve, dent.as_ref());
            // Scale of the normal footprint at this depth, between 0.10 and 0.40 of 140 mm.
            let printed_mm = 140.0 * (0.10 + 0.30 * DEPTH_MM / 10.0);
            let printed = relative_error(&curve, printed_mm, dent.as_ref());
            table.push([
                name.as_str().into(),
                dent.force_n(DEPTH_MM).into(),
                half_depth_mm(dent.as_ref()).into(),
                radius_mm.into(),
                Value::from(100.0 * off),
                Value::from(100.0 * printed),
            ]);
            if let Some([low, high]) = expected {
                report.verdicts.push(Verdict::told(
                    format!("FSMD fitted to {name}, relative error"),
                    format!("{:.1} %", 100.0 * off),
                    format!("{low} to {high} %"),
                    (low - 1.0..=high + 1.0).contains(&(100.0 * off)),
                ));
            }
            plots.push(plot(name, &curve, radius_mm, dent.as_ref()));
        }
        let farthest = all
            .iter()
            .map(|(_, dent, _)| (dent.at_mm(DEPTH_MM, 0.0) / DEPTH_MM - 1.0).abs());
        let farthest = farthest.fold(0.0, f64::max);
        report.verdicts.push(Verdict::must(
            "every closed form is as deep in its middle as it is told",
            format!("off by {farthest:.1e}"),
            "1e-9",
            farthest < 1e-9,
        ));
        report.tables.push(table);
        report.draw("yardsticks", plots);
        report.note(
            "A half-space falls off as 1/r: no dent that ends can follow it. Tissue on bone ends a few thicknesses off, \
             and there a fitted footprint does well; it has no rim bulge.",
        );
        Ok(report)
    }
}

fn yardsticks() -> Vec<Yardstick> {
    let expected = |name: &str| match name {
        "half-space-gaussian" => Some([63.0, 67.0]),
        "membrane" => Some([8.0, 8.0]),
        _ => None,
    };
    let mut all: Vec<Yardstick> = reference::all()
        .iter()
        .filter(|(name, _)| *name != "layer")
        .map(|(name, make)| ((*name).to_owned(), make(), expected(name)))
        .collect();
    for thickness_mm in [10.0, 15.0, 20.0, 40.0] {
        let layer = layer::Bonded::new(Elastic::MUSCLE, 3.5, thickness_mm);
        let expected = (15.0..=20.0)
            .contains(&thickness_mm)
            .then_some([10.0, 12.0]);
        all.push((
            format!("layer of {thickness_mm} mm"),
            Box::new(layer),
            expected,
        ));
    }
    all
}

/// L2 of the difference over L2 of the closed form, weighed by area.
fn relative_error(curve: &Curve, radius_mm: f64, dent: &dyn Dent) -> f64 {
    let (mut off, mut whole) = (0.0, 0.0);
    for i in 0..RINGS {
        let r_mm = (f64::from(i) + 0.5) * WITHIN_MM / f64::from(RINGS);
        let truth = dent.at_mm(DEPTH_MM, r_mm);
        let drawn = DEPTH_MM * curve.at(r_mm / radius_mm);
        off += r_mm * (drawn - truth) * (drawn - truth);
        whole += r_mm * truth * truth;
    }
    libm::sqrt(off / whole)
}

/// The footprint with the smallest error, mm, and that error: the best of a coarse search, then golden section about it.
fn best_fit(curve: &Curve, dent: &dyn Dent) -> (f64, f64) {
    let error = |log_mm: f64| relative_error(curve, libm::exp(log_mm), dent);
    let [low, high] = FOOTPRINTS_MM.map(libm::log);
    let step = (high - low) / 40.0;
    let coarse = (0..=40).map(|i| low + step * f64::from(i));
    let best = coarse
        .min_by(|a, b| error(*a).total_cmp(&error(*b)))
        .unwrap_or(low);
    let golden = 0.5 * (libm::sqrt(5.0) - 1.0);
    let (mut a, mut b) = (best - step, best + step);
    for _ in 0..30 {
        let (c, d) = (b - golden * (b - a), a + golden * (b - a));
        if error(c) < error(d) {
            b = d;
        } else {
            a = c;
        }
    }
    let middle = 0.5 * (a + b);
    (libm::exp(middle), error(middle))
}

/// Where half the depth is left, mm.
fn half_depth_mm(dent: &dyn Dent) -> f64 {
    let (mut near, mut far) = (0.0, WITHIN_MM);
    for _ in 0..60 {
        let middle = 0.5 * (near + far);
        if dent.at_mm(DEPTH_MM, middle) > 0.5 * DEPTH_MM {
            near = middle;
        } else {
            far = middle;
        }
    }
    near
}

fn plot(name: &str, curve: &Curve, radius_mm: f64, dent: &dyn Dent) -> LinePlot {
    let places = || (0..=240).map(|i| f64::from(i) * 0.25);
    let colour = match name {
        "half-space-gaussian" => GREEN,
        "half-space-disc" => BROWN,
        "half-space-sphere" => VIOLET,
        "membrane" => GREY,
        _ => INK,
    };
    LinePlot {
        title: format!("{name}: its dent and the best FSMD one"),
        x_label: "distance from the middle (mm)".to_owned(),
        y_label: "depth (mm)".to_owned(),
        x_scale: Scale::Linear,
        y_scale: Scale::Linear,
        series: vec![
            series(
                name,
                colour,
                Mark::Line,
                places().map(|r| [r, dent.at_mm(DEPTH_MM, r)]),
            ),
            series(
                format!("FSMD, footprint {radius_mm:.1} mm"),
                AMBER,
                Mark::Dashed,
                places().map(|r| [r, DEPTH_MM * curve.at(r / radius_mm)]),
            ),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A dent that is FSMD's own is found again, and nothing is left over.
    #[test]
    fn the_fit_finds_a_footprint_that_is_there() {
        struct Own;
        impl Dent for Own {
            fn name(&self) -> &'static str {
                "own"
            }
            fn at_mm(&self, depth_mm: f64, r_mm: f64) -> f64 {
                depth_mm * Curve::gaussian().at(r_mm / 23.0)
            }
            fn force_n(&self, depth_mm: f64) -> f64 {
                depth_mm
            }
        }
        let (radius_mm, off) = best_fit(&Curve::gaussian(), &Own);
        assert!(
            (radius_mm - 23.0).abs() < 1e-3 && off < 1e-4,
            "{radius_mm} {off}"
        );
    }

    #[test]
    fn a_layer_on_bone_is_followed_and_a_body_without_end_is_not() {
        let curve = Curve::gaussian();
        let off = |name: &str| {
            let all = yardsticks();
            let (_, dent, _) = all.iter().find(|(n, ..)| n == name).unwrap();
            best_fit(&curve, dent.as_ref()).1
        };
        let (layer, body) = (off("layer of 20 mm"), off("half-space-gaussian"));
        assert!(layer < 0.15 && body > 0.5, "{layer} {body}");
    }
}
