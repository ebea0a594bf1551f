//! Tables 3.3 and 3.4: what finding one leaf costs in a complete tree, in the worst case.

use crate::geom::{Aabb, Vec3};
use crate::lab::{Experiment, LabError, Report, Setup, Table, Value, Verdict, Watch};
use crate::partition::Structure;
use crate::partition::hdb::Gathered;
use crate::partition::tree::{Case, Options, worst_w};
use crate::surface::Surface;
use crate::surface::primitives::one_per_cell;

/// Tables 3.3 and 3.4 recomputed, by formula and by walking trees that are really complete.
pub struct Complexity;

/// Table 3.3: w of a binary tree by height.
const PRINTED_BSP: [(u32, f64); 8] = [
    (3, 2.13),
    (4, 2.58),
    (5, 3.04),
    (6, 3.53),
    (7, 4.02),
    (8, 4.51),
    (9, 5.01),
    (10, 5.50),
];
/// Table 3.4: w of an octree by height.
const PRINTED_OCTREE: [(u32, f64); 3] = [(2, 2.63), (3, 3.50), (4, 4.38)];
/// Two roundings of the last printed digit.
const PRINTED_TOLERANCE: f64 = 0.0101;
/// Share of the leaves that a haptic detecting box meets at most, as the publication takes it (3.3.4).
const SHARE_FOUND: f64 = 0.1;

impl Experiment for Complexity {
    fn name(&self) -> &'static str {
        "partition-complexity"
    }

    fn about(&self) -> &'static str {
        "Worst cost of finding leaves in a complete tree (tables 3.3 and 3.4), recomputed beside print"
    }

    fn run(&self, _setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        let mut one_leaf = Table::new(
            "worst-w",
            "w = (nodes visited for one leaf / all nodes) / (1 / leaves), complete tree",
            &[
                "tree",
                "height",
                "leaves",
                "nodes",
                "nodes visited",
                "w computed",
                "w walked",
                "w printed",
                "w off print",
            ],
        );
        let (mut walked_off, mut printed_off) = (0.0_f64, 0.0_f64);
        let bsp = PRINTED_BSP.map(|(height, w)| ("bsp", 2, height, w));
        let octree = PRINTED_OCTREE.map(|(height, w)| ("octree", 8, height, w));
        let all: Vec<_> = bsp.into_iter().chain(octree).collect();
        for (i, &(kind, fanout, height, printed)) in all.iter().enumerate() {
            watch.at(
                &format!("{kind} of height {height}"),
                i as f64 / all.len() as f64,
            )?;
            let (nodes, leaves, cost) = walk_one_leaf(kind, height)?;
            let computed = worst_w(fanout, height);
            let walked = cost.nodes as f64 / nodes as f64 * leaves as f64;
            walked_off = walked_off.max((walked - computed).abs());
            printed_off = printed_off.max((computed - printed).abs());
            one_leaf.push([
                kind.into(),
                height.into(),
                leaves.into(),
                nodes.into(),
                cost.nodes.into(),
                computed.into(),
                walked.into(),
                printed.into(),
                Value::from(computed - printed),
            ]);
        }
        report.tables.push(one_leaf);
        report.tables.push(spread());
        report.verdicts.push(Verdict::must(
            "walking a complete tree costs what the formula says",
            format_args!("w differs by at most {walked_off:.1e}"),
            "1e-12",
            walked_off <= 1e-12,
        ));
        report.verdicts.push(Verdict::must(
            "the printed w come out of the formula, to their last digit",
            format_args!("off by at most {printed_off:.4}"),
            "0.01",
            printed_off <= PRINTED_TOLERANCE,
        ));
        report.note(
            "Printed at heights 5 and 9: 3.04 and 5.01; the fractions printed above them give 3.05 and 5.00.",
        );
        report.note(
            "The publication bounds a box query by w · r with r = 0.1: that multiplies the cost of one leaf, whose path to \
             the root is shared with no other, by the number of leaves. Leaves spread out share the upper levels; but every \
             child of a node entered must be asked, which an octree pays eight times.",
        );
        Ok(report)
    }
}

/// Nodes and leaves of a complete tree of that height, and what its published query costs for a box within one leaf.
fn walk_one_leaf(kind: &str, height: u32) -> Result<(usize, usize, Gathered), LabError> {
    let cells = match kind {
        // Planes turn x, y, z: x is halved first, and once more than z.
        "bsp" => [height.div_ceil(3), (height + 1) / 3, height / 3],
        _ => [height; 3],
    };
    let failed = |e: String| LabError::Input(format!("complete {kind} of height {height}: {e}"));
    let mesh = one_per_cell(cells.map(|halvings| 1 << halvings));
    let (surface, _) = Surface::new(mesh).map_err(|e| failed(e.to_string()))?;
    let options = Options {
        threshold: 1,
        case: Case::C,
    };
    let built = Structure::build(kind, &surface, &options, &mut |_| true)
        .map_err(|e| failed(e.to_string()))?
        .ok_or(LabError::Stopped)?;
    let region = Aabb::cube(Vec3::splat(0.5), 0.1);
    let cost = built.gather_as_published(&region, &mut Vec::new());
    match (built.tree(), cost) {
        (Some(tree), Some(cost)) => {
            let leaves = tree.nodes().iter().filter(|n| n.is_leaf()).count();
            Ok((tree.nodes().len(), leaves, cost))
        }
        _ => Err(failed("it is no tree".to_owned())),
    }
}

/// What a box that meets a tenth of the leaves costs: the published bound, and leaves as far apart as can be.
fn spread() -> Table {
    let mut table = Table::new(
        "spread-leaves",
        "Finding a tenth of n leaves: the published bound w · r · nodes, and leaves spread out as far as can be",
        &[
            "tree",
            "height",
            "leaves n",
            "found",
            "bound (n)",
            "bound printed (n)",
            "nodes spread (n)",
            "box tests spread (n)",
        ],
    );
    for (kind, fanout, height, printed) in [("bsp", 2_u32, 7, 0.8), ("octree", 8, 3, 0.4)] {
        let n = f64::from(fanout.pow(height));
        let found = (SHARE_FOUND * n).ceil();
        let levels = || (0..=height).map(|level| f64::from(fanout.pow(level)));
        let all: f64 = levels().sum();
        let entered: f64 = levels().map(|wide| wide.min(found)).sum();
        let inner = entered - found;
        table.push([
            kind.into(),
            height.into(),
            (n as usize).into(),
            (found as usize).into(),
            (SHARE_FOUND * worst_w(fanout, height) * all / n).into(),
            printed.into(),
            (entered / n).into(),
            ((inner * f64::from(fanout) + 1.0) / n).into(),
        ]);
    }
    table
}
