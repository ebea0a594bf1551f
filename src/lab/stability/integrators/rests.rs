//! What Newton's method says of rest, and what is left over.

use super::{block, middle_of};
use crate::geom::Vec3;
use crate::lab::{LabError, Report, Setup, Table, Value, Verdict};
use crate::reference::springs::rest::rest;
use serde::{Deserialize, Serialize};

/// Where Newton's method ended under a load.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Rested {
    load_n: f64,
    iterations: usize,
    said: f64,
    /// Largest force left over on a free point by the springs themselves, over the load.
    left: f64,
    depth_mm: f64,
}

pub(super) fn rests(setup: &Setup) -> Result<Vec<Rested>, LabError> {
    let n = 6;
    let lattice = block(n, 3).ok_or_else(|| LabError::Input("no lattice".to_owned()))?;
    let (node, _) = middle_of(&lattice, n);
    let powers = if setup.quick { -3..=0 } else { -9..=6 };
    let mut rows = Vec::new();
    for power in powers {
        let load_n = 10_f64.powi(power);
        let load = [(node, Vec3::NEG_Z * load_n)];
        let Ok(found) = rest(&lattice, &load) else {
            continue;
        };
        let at: Vec<Vec3> = (lattice.rest_mm.iter())
            .zip(&found.displacements_mm)
            .map(|(r, u)| *r + *u)
            .collect();
        let mut forces = Vec::new();
        lattice.forces_n(&at, &mut forces);
        forces[node] += load[0].1;
        let left = (forces.iter().zip(&lattice.free))
            .map(|(f, free)| (*f * *free).abs().max_element())
            .fold(0.0, f64::max);
        rows.push(Rested {
            load_n,
            iterations: found.iterations,
            said: found.residual,
            left: left / load_n,
            depth_mm: -found.displacements_mm[node].z,
        });
    }
    Ok(rows)
}

pub(super) fn tell_rests(rows: &[Rested], report: &mut Report) {
    let mut table = Table::new(
        "rest",
        "Newton's method to rest: what it says is left over, and what is",
        &[
            "load (N)",
            "iterations",
            "said left over",
            "left over",
            "depth (mm)",
            "ends",
        ],
    );
    let mut lies = 0;
    let mut rested = 0;
    for r in rows {
        let at_rest = r.said < 1.0e-6;
        rested += usize::from(at_rest);
        lies += usize::from(
            (r.said - r.left).abs() > 1.0e-6 * r.left.max(1.0e-3) || !r.left.is_finite(),
        );
        let ends: Value = if at_rest { "at rest" } else { "says it is not" }.into();
        table.push([
            r.load_n.into(),
            r.iterations.into(),
            r.said.into(),
            r.left.into(),
            r.depth_mm.into(),
            ends,
        ]);
    }
    report.tables.push(table);
    report.verdicts.push(Verdict::must(
        "Newton's method says truly what is left over",
        format!(
            "{rested} of {} loads at rest, {lies} not as said",
            rows.len()
        ),
        "all as said",
        lies == 0 && rested > 0,
    ));
}
