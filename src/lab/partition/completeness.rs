//! Whether a haptic detecting box gets all triangles that meet it, as published and as built here.

use super::shared::{BRUTE, BVH, Kind, TREES, places, surface};
use crate::geom::Aabb;
use crate::lab::{Choice, Experiment, LabError, Report, Setup, Table, Value, Verdict, Watch};
use crate::partition::Structure;
use crate::surface::Surface;

/// Triangles that meet a box and are not gathered, by structure, for the published and the complete query.
pub struct Completeness;

/// The published threshold, and a small one, whose leaves are not much larger than what juts out of them.
const THRESHOLDS: [usize; 2] = [1024, 64];
/// Edges of the box over the longest edge of the surface's box: the published one, and a small one.
const PARTS: [f64; 2] = [0.25, 1.0 / 16.0];

impl Experiment for Completeness {
    fn name(&self) -> &'static str {
        "partition-completeness"
    }

    fn about(&self) -> &'static str {
        "Triangles that a haptic detecting box should get and does not: published query, complete query, brute force"
    }

    fn takes(&self) -> &'static [Choice] {
        &[Choice::Mesh]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        let surface = surface(setup, &mut report)?;
        let n = if setup.quick { 40 } else { 200 };
        report.set(
            "boxes",
            format_args!("{n}, about places spread over the surface"),
        );
        let longest_mm = surface.bounds().size().max_element();
        let mut table = Table::new(
            "gathered",
            format!(
                "Triangles that meet the box and what each query makes of them: means, and sums of those missed, over {n} boxes"
            ),
            &[
                "structure",
                "threshold",
                "box edge (mm)",
                "needed",
                "gathered",
                "missed",
                "published gathered",
                "published missed",
                "boxes with a miss (%)",
                "lost by printed rule",
            ],
        );
        let (mut missed, mut published_missed) = (0, 0);
        let mut lost = Vec::new();
        for (i, part) in PARTS.into_iter().enumerate() {
            let edge_mm = longest_mm * part;
            let boxes: Vec<Aabb> = places(&surface, n)
                .into_iter()
                .map(|p| Aabb::cube(p, edge_mm))
                .collect();
            let mut needed = Vec::with_capacity(n);
            let mut half = watch.part(
                i as f64 / PARTS.len() as f64,
                (i + 1) as f64 / PARTS.len() as f64,
            );
            for region in &boxes {
                half.at("asking every triangle", 0.0)?;
                needed.push(meeting(&surface, region));
            }
            let flat = [BRUTE, BVH].map(|kind| (kind, None));
            let trees = THRESHOLDS.map(|t| TREES.map(|kind| (kind, Some(t))));
            let all: Vec<(Kind, Option<usize>)> = flat
                .into_iter()
                .chain(trees.into_iter().flatten())
                .collect();
            for (j, &(kind, threshold)) in all.iter().enumerate() {
                let share = (j + 1) as f64 / all.len() as f64;
                half.at(&format!("asking {}", kind.label), share)?;
                let built = kind.build(&surface, threshold.unwrap_or(1), &mut half, share)?;
                let found = ask(&built, &surface, &boxes, &needed);
                missed += found.missed;
                published_missed += found.published.as_ref().map_or(0, |p| p.missed);
                let lost_here = built.statistics(&surface).map(|s| s.lost_as_published);
                if i == 0 && kind.name == "octree" {
                    lost.extend(threshold.zip(lost_here));
                }
                let mean = |sum: usize| sum as f64 / n as f64;
                table.push([
                    kind.label.into(),
                    threshold.into(),
                    edge_mm.into(),
                    mean(needed.iter().map(Vec::len).sum()).into(),
                    mean(found.gathered).into(),
                    found.missed.into(),
                    found.published.as_ref().map(|p| mean(p.gathered)).into(),
                    found.published.as_ref().map(|p| p.missed).into(),
                    Value::from(found.published.as_ref().map(|p| 100.0 * mean(p.boxes))),
                    lost_here.filter(|_| kind.name != "bsp").into(),
                ]);
            }
        }
        report.tables.push(table);
        report.verdicts.push(Verdict::must(
            "the complete query of every structure gathers every triangle that meets the box",
            format_args!("{missed} missed"),
            "0 missed",
            missed == 0,
        ));
        report.verdicts.push(Verdict::told(
            "the published query gathers every triangle that meets the box",
            format_args!("{published_missed} missed"),
            "0 missed",
            published_missed == 0,
        ));
        for (threshold, lost) in lost {
            report.verdicts.push(Verdict::told(
                format!("the printed octree rule holds every triangle (threshold {threshold})"),
                format_args!("{lost} of {} lost", surface.triangles().len()),
                "0 lost",
                lost == 0,
            ));
        }
        report.note(
            "In cases A and B every leaf lists what lies in its cell, so the published query is complete. In case C and in \
             octrees a triangle is listed by one leaf only and juts out of its cell: a box that meets no more than what juts \
             out is not answered. Leaf bounds that hold their triangles wholly mend it at no cost in entries.",
        );
        report.note(
            "The printed octree rule gives a triangle to the child with two of its vertices, and so to none where it spans \
             three; the published counts and timings cannot show it. Here the child that holds the centroid takes it.",
        );
        Ok(report)
    }
}

/// Every triangle that shares a point with the box.
fn meeting(surface: &Surface, region: &Aabb) -> Vec<u32> {
    (0..surface.triangles().len() as u32)
        .filter(|&t| surface.triangle(t).meets(region))
        .collect()
}

/// Sums over all boxes.
struct Found {
    gathered: usize,
    missed: usize,
    /// Boxes in which one is missed.
    boxes: usize,
    published: Option<Box<Found>>,
}

fn ask(built: &Structure, surface: &Surface, boxes: &[Aabb], needed: &[Vec<u32>]) -> Found {
    let complete = sums(boxes, needed, |region, out| {
        built.gather(surface, region, out);
    });
    let published = built.tree().map(|_| {
        Box::new(sums(boxes, needed, |region, out| {
            built.gather_as_published(region, out);
        }))
    });
    Found {
        published,
        ..complete
    }
}

fn sums(boxes: &[Aabb], needed: &[Vec<u32>], ask: impl Fn(&Aabb, &mut Vec<u32>)) -> Found {
    let mut found = Found {
        gathered: 0,
        missed: 0,
        boxes: 0,
        published: None,
    };
    let mut out = Vec::new();
    for (region, needed) in boxes.iter().zip(needed) {
        out.clear();
        ask(region, &mut out);
        let missed = needed
            .iter()
            .filter(|t| out.binary_search(t).is_err())
            .count();
        found.gathered += out.len();
        found.missed += missed;
        found.boxes += usize::from(missed > 0);
    }
    found
}
