//! The plots of a sweep over passes.

use super::super::printed::rows;
use super::super::shared::{BRUTE, BSP, BVH, HYBRID, Kind, OCTREE};
use super::tables::curve;
use super::{Cell, Model, PUBLISHED, Production};
use crate::figure::{LinePlot, Mark, Scale, Series};

pub(super) fn by_haptic_triangles(cells: &[Cell], production: &[Production]) -> Vec<LinePlot> {
    let of_2008 = |kind: Kind, condition: &str| Series {
        name: format!("{} 2008", kind.label),
        colour: kind.colour,
        mark: Mark::Dashed,
        points: rows(kind.name, condition)
            .iter()
            .map(|r| [r.triangles, 1e3 * r.ms()])
            .collect(),
    };
    let plot = |condition: &str, title: &str| {
        let mut series: Vec<Series> = [BSP, OCTREE].map(|kind| of_2008(kind, condition)).to_vec();
        series.extend(PUBLISHED.map(|kind| Series {
            name: kind.label.to_owned(),
            colour: kind.colour,
            mark: Mark::Joined,
            points: curve(cells, kind, condition),
        }));
        series.push(Series {
            name: "brute".to_owned(),
            colour: BRUTE.colour,
            mark: Mark::Points,
            points: curve(cells, BRUTE, condition),
        });
        if condition != "draw" {
            let us = production[usize::from(condition == "touch")]
                .tick_us
                .median();
            let ends = series.iter().flat_map(|s| &s.points).map(|p| p[0]);
            let (least, most) =
                ends.fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
            series.push(Series {
                name: "production".to_owned(),
                colour: BVH.colour,
                mark: Mark::Line,
                points: vec![[least, us], [most, us]],
            });
        }
        LinePlot {
            title: title.to_owned(),
            x_label: "haptic triangles".to_owned(),
            y_label: "time (µs)".to_owned(),
            x_scale: Scale::Logarithmic,
            y_scale: Scale::Logarithmic,
            series,
        }
    };
    vec![
        plot(
            "draw",
            "Handing the triangles on (2008: drawn for the haptic library; ours: gathered)",
        ),
        plot("untouch", "A pass above the surface: gathered and collided"),
        plot("touch", "A pass on the surface: gathered, collided, force"),
    ]
}

pub(super) fn by_model(models: &[Model]) -> LinePlot {
    let series = |name: &str, colour, mark, points| Series {
        name: name.to_owned(),
        colour,
        mark,
        points,
    };
    let x = |m: &Model| m.triangles as f64;
    let printed = rows("none", "touch");
    let mut all = vec![series(
        "all triangles 2008",
        BRUTE.colour,
        Mark::Dashed,
        printed
            .iter()
            .map(|r| [r.triangles, 1e3 * r.ms()])
            .collect(),
    )];
    for (i, kind) in [BRUTE, BSP, OCTREE, HYBRID].into_iter().enumerate() {
        let points = models
            .iter()
            .filter_map(|m| Some([x(m), m.cells.get(i)?.pass_us.median()]))
            .collect();
        all.push(series(kind.label, kind.colour, Mark::Joined, points));
    }
    let points = models
        .iter()
        .map(|m| [x(m), m.production.tick_us.median()])
        .collect();
    all.push(series("production", BVH.colour, Mark::Joined, points));
    LinePlot {
        title: "A pass on the surface, by size of the model (box: a quarter)".to_owned(),
        x_label: "triangles of the model".to_owned(),
        y_label: "time (µs)".to_owned(),
        x_scale: Scale::Logarithmic,
        y_scale: Scale::Logarithmic,
        series: all,
    }
}
