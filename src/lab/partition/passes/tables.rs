//! The tables of a sweep over passes, and what they say.

use super::super::printed::{self, octree_better_percent, rows};
use super::super::shared::{BRUTE, BSP, Kind, OCTREE};
use super::{Cell, Model, Production};
use crate::lab::{Report, Table, Value, Verdict};
use crate::partition::hdb::EDGE_PART;

fn condition(touched: bool) -> &'static str {
    if touched { "touched" } else { "untouched" }
}

pub(super) fn by_box(cells: &[Cell], production: &[Production]) -> Table {
    let mut table = Table::new(
        "by-box",
        "One pass by the edge of the box: parts, and the whole engine's pass (medians)",
        &[
            "structure",
            "condition",
            "box part",
            "haptic triangles",
            "gather (µs)",
            "collide (µs)",
            "force (µs)",
            "pass (µs)",
            "pass p99 (µs)",
            "per triangle (ns)",
        ],
    );
    for c in cells {
        let pass_us = c.pass_us.median();
        table.push([
            c.kind.label.into(),
            condition(c.touched).into(),
            c.part.into(),
            c.triangles.into(),
            c.gather_us.median().into(),
            c.collide_us.median().into(),
            c.force_us.median().into(),
            pass_us.into(),
            c.pass_us.quantile(0.99).into(),
            Value::from(1e3 * pass_us / c.triangles),
        ]);
    }
    for p in production {
        let mut row = vec!["production".into(), condition(p.touched).into()];
        row.extend([const { Value::Empty }; 5]);
        row.extend([
            p.tick_us.median().into(),
            p.tick_us.quantile(0.99).into(),
            Value::Empty,
        ]);
        table.push(row);
    }
    table
}

pub(super) fn by_model(models: &[Model]) -> Table {
    let mut table = Table::new(
        "by-model",
        "Table 3.1: touched passes by size of the model, with the published box (medians; production: one tick)",
        &[
            "model triangles",
            "brute (µs)",
            "bsp c (µs)",
            "octree (µs)",
            "hybrid (µs)",
            "production (µs)",
            "brute / production",
            "2008, all triangles (ms)",
            "2008 / brute",
        ],
    );
    let printed: Vec<[f64; 2]> = rows("none", "touch")
        .iter()
        .map(|r| [r.triangles, r.ms()])
        .collect();
    for m in models {
        let us: Vec<f64> = m.cells.iter().map(|c| c.pass_us.median()).collect();
        let ours_us = m.production.tick_us.median();
        let brute_us = us.first().copied().unwrap_or(f64::NAN);
        let ms = printed::at(&printed, m.triangles as f64);
        let mut row: Vec<Value> = vec![m.triangles.into()];
        row.extend(us.iter().map(|&us| Value::from(us)));
        row.extend([
            ours_us.into(),
            Value::from(brute_us / ours_us),
            ms.into(),
            ms.map(|ms| 1e3 * ms / brute_us).into(),
        ]);
        table.push(row);
    }
    table
}

/// Our curve of a structure in a printed condition: triangles, µs.
pub(super) fn curve(cells: &[Cell], kind: Kind, condition: &str) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = cells
        .iter()
        .filter(|c| c.kind == kind && c.touched == (condition == "touch"))
        .map(|c| {
            let us = if condition == "draw" {
                c.gather_us.median()
            } else {
                c.pass_us.median()
            };
            [c.triangles, us]
        })
        .collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    points
}

/// Printed conditions, and what ours are called.
const CONDITIONS: [(&str, &str); 3] = [
    ("draw", "draw (ours: gather)"),
    ("untouch", "untouched"),
    ("touch", "touched"),
];

pub(super) fn beside_print(cells: &[Cell], production: &[Production]) -> Table {
    let mut table = Table::new(
        "beside-print",
        "Tables 3.2 (BSP) and B (octree): each printed row, and ours at as many haptic triangles",
        &[
            "structure",
            "condition",
            "haptic triangles",
            "2008 (ms)",
            "2008 rate (1/s)",
            "ours (µs)",
            "2008 / ours",
            "production (µs)",
        ],
    );
    for kind in [BSP, OCTREE] {
        for (condition, shown) in CONDITIONS {
            let ours = curve(cells, kind, condition);
            let engine = match condition {
                "untouch" => Some(production[0].tick_us.median()),
                "touch" => Some(production[1].tick_us.median()),
                _ => None,
            };
            for row in rows(kind.name, condition) {
                let us = printed::at(&ours, row.triangles);
                table.push([
                    kind.label.into(),
                    shown.into(),
                    row.triangles.into(),
                    row.ms().into(),
                    row.fps.into(),
                    us.into(),
                    us.map(|us| 1e3 * row.ms() / us).into(),
                    engine.into(),
                ]);
            }
        }
    }
    table
}

/// By how much our octree is better than our BSP at the printed numbers of triangles, %.
fn ours_better_percent(cells: &[Cell], condition: &str) -> Vec<f64> {
    let (bsp, octree) = (
        curve(cells, BSP, condition),
        curve(cells, OCTREE, condition),
    );
    rows("bsp", condition)
        .iter()
        .filter_map(|row| {
            let ratio = printed::at(&octree, row.triangles)? / printed::at(&bsp, row.triangles)?;
            Some(100.0 * (1.0 - ratio))
        })
        .collect()
}

fn range_text(percent: &[f64]) -> String {
    let least = percent.iter().copied().fold(f64::INFINITY, f64::min);
    let most = percent.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if percent.is_empty() {
        "not measured".to_owned()
    } else {
        format!("{least:.0} to {most:.0} %")
    }
}

pub(super) fn octree_against_bsp(cells: &[Cell]) -> Table {
    let mut table = Table::new(
        "octree-against-bsp",
        "How much less time an octree needs than a BSP for as many triangles (section 3.4.2 says 10 to 20 %)",
        &[
            "condition",
            "2008, least (%)",
            "2008, most (%)",
            "ours, least (%)",
            "ours, most (%)",
        ],
    );
    let ends = |all: &[f64]| {
        [
            all.iter().copied().fold(f64::INFINITY, f64::min),
            all.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        ]
    };
    for (condition, shown) in CONDITIONS {
        let printed = ends(&octree_better_percent(condition));
        let ours = ends(&ours_better_percent(cells, condition));
        let figures = printed.into_iter().chain(ours).map(Value::from);
        table.push([Value::from(shown)].into_iter().chain(figures));
    }
    table
}

pub(super) fn conclude(
    report: &mut Report,
    cells: &[Cell],
    production: &[Production],
    models: &[Model],
    is_back: bool,
) {
    let felt: Vec<&Cell> = cells
        .iter()
        .filter(|c| c.touched && c.kind == BRUTE)
        .collect();
    let passes: usize = felt.iter().map(|c| c.pass_us.len()).sum();
    let in_touch: usize = felt.iter().map(|c| c.felt).sum();
    let engine = &production[1];
    report.verdicts.push(Verdict {
        // A mesh of one's own may have walls so near that the finger slides off them.
        required: is_back,
        ..Verdict::must(
            "the finger stays in touch when every triangle is asked, and by the production engine",
            format_args!(
                "{in_touch} of {passes} passes, {} of {} ticks",
                engine.felt, engine.ticks
            ),
            "all",
            in_touch == passes && engine.felt == engine.ticks,
        )
    });
    for (condition, shown) in &CONDITIONS[1..] {
        let (printed, ours) = (
            octree_better_percent(condition),
            ours_better_percent(cells, condition),
        );
        let claimed = |percent: &[f64]| percent.iter().all(|p| (10.0..=20.0).contains(p));
        report.verdicts.push(Verdict::told(
            format!("an octree is 10 to 20 % better than a BSP for as many triangles, {shown}"),
            format_args!(
                "printed tables {}, ours {}",
                range_text(&printed),
                range_text(&ours)
            ),
            "10 to 20 %",
            claimed(&printed) && !ours.is_empty() && claimed(&ours),
        ));
    }
    let flat: Vec<f64> = models
        .iter()
        .map(|m| m.production.tick_us.median())
        .collect();
    if let (Some(first), Some(last)) = (flat.first(), flat.last()) {
        report.verdicts.push(Verdict::told(
            "the production engine costs the same whatever the size of the model",
            format_args!("{first:.3} µs at the smallest, {last:.3} µs at the largest"),
            "at most 1.5 times",
            *last <= 1.5 * first,
        ));
    }
    let published = cells
        .iter()
        .find(|c| c.touched && c.kind == OCTREE && c.part == Some(EDGE_PART));
    if let Some(published) = published {
        let (pass, tick) = (published.pass_us.median(), engine.tick_us.median());
        report.verdicts.push(Verdict::told(
            "the production engine costs less than the published pass (octree, box a quarter)",
            format_args!(
                "{tick:.3} µs and {pass:.1} µs: {:.0} times less",
                pass / tick
            ),
            "less",
            tick < pass,
        ));
        let parts = published.parts_us();
        report.note(format!(
            "Of the parts of that pass gathering takes {:.0} %, colliding {:.0} %. The whole pass asks the leaves anew where \
             the parts keep a list, so it differs from their sum.",
            100.0 * published.gather_us.median() / parts,
            100.0 * published.collide_us.median() / parts
        ));
    }
    report.note(
        "The times of 2008 include a closed haptic library and its drawing, of which nothing here has a like: the slopes can be \
         compared, the ratio is also that of two machines and two decades.",
    );
}
