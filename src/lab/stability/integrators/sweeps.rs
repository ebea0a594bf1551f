//! Where position-based steps come to rest.

use super::{block, coloured, middle_of};
use crate::figure::{LinePlot, Mark, Scale, Series};
use crate::geom::Vec3;
use crate::lab::{LabError, Report, Setup, Table, Verdict, Watch};
use crate::reference::springs::rest::rest;
use crate::reference::springs::xpbd::Xpbd;
use serde::{Deserialize, Serialize};

/// How far position-based dynamics comes to rest from where the lattice truly does.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Swept {
    sweeps: usize,
    dt_s: f64,
    /// Depth under the load over the true one, less 1.
    off: f64,
    /// Farthest that any point was from rest, mm, in the first half of the steps and in the second.
    largest_mm: [f64; 2],
}

const LOAD_N: f64 = 0.05;

pub(super) fn sweeps(setup: &Setup, watch: &mut Watch<'_>) -> Result<Vec<Swept>, LabError> {
    let n = 6;
    let lattice = block(n, 3).ok_or_else(|| LabError::Input("no lattice".to_owned()))?;
    let (node, z) = middle_of(&lattice, n);
    let load = [(node, Vec3::NEG_Z * LOAD_N)];
    let truth = rest(&lattice, &load).map_err(|e| LabError::Input(e.to_string()))?;
    let true_mm = -truth.displacements_mm[node].z;
    let counts: &[usize] = if setup.quick {
        &[1, 10]
    } else {
        &[1, 2, 5, 10, 20, 50, 100, 200]
    };
    let lengths: &[f64] = if setup.quick {
        &[1.0 / 60.0, 10.0]
    } else {
        &[1.0e-3, 1.0 / 240.0, 1.0 / 60.0, 0.1, 1.0, 10.0]
    };
    let mut rows = Vec::new();
    for (i, &sweeps) in counts.iter().enumerate() {
        watch.at(
            "position-based steps",
            0.65 + 0.25 * i as f64 / counts.len() as f64,
        )?;
        for &dt_s in lengths {
            let mut games = Xpbd::new(&lattice, 60.0);
            let many = ((2.0 / dt_s) as usize).clamp(100, 2000);
            let many = if setup.quick { 60 } else { many };
            let mut largest_mm = [0.0_f64; 2];
            for i in 0..many {
                games.step(&load, dt_s, sweeps);
                let moved = games.at_mm.iter().zip(&lattice.rest_mm);
                let far = moved.map(|(a, r)| (*a - *r).length());
                // NaN must not hide.
                let half = &mut largest_mm[usize::from(2 * i >= many)];
                *half = far.fold(*half, |m, x| if x > m || x.is_nan() { x } else { m });
            }
            rows.push(Swept {
                sweeps,
                dt_s,
                off: (z - games.at_mm[node].z) / true_mm - 1.0,
                largest_mm,
            });
        }
    }
    Ok(rows)
}

pub(super) fn tell_sweeps(rows: &[Swept], report: &mut Report) {
    let mut table = Table::new(
        "sweeps",
        "Position-based steps of a lattice: where it comes to rest, against Newton's method",
        &[
            "sweeps",
            "step (s)",
            "depth off by (%)",
            "farthest in first half (mm)",
            "farthest in second half (mm)",
        ],
    );
    for r in rows {
        table.push([
            r.sweeps.into(),
            r.dt_s.into(),
            (100.0 * r.off).into(),
            r.largest_mm[0].into(),
            r.largest_mm[1].into(),
        ]);
    }
    report.tables.push(table);
    let grows = |r: &&Swept| {
        let [first, second] = r.largest_mm;
        !second.is_finite() || second > 2.0 * first
    };
    let wild = rows.iter().find(grows);
    report.verdicts.push(Verdict::must(
        "position-based steps of a lattice stay bounded",
        match wild {
            None => format!("{} runs of steps of 1 ms … 10 s", rows.len()),
            Some(r) => format!("{:?} mm at {} s, {} sweeps", r.largest_mm, r.dt_s, r.sweeps),
        },
        "no point ever farther in the second half of the steps than twice as in the first",
        wild.is_none(),
    ));
    let lengths: Vec<f64> = rows.iter().fold(Vec::new(), |mut all, r| {
        if !all.contains(&r.dt_s) {
            all.push(r.dt_s);
        }
        all
    });
    let series = lengths
        .into_iter()
        .map(|dt_s| Series {
            name: format!("step {:.4} ms", 1.0e3 * dt_s),
            points: (rows.iter())
                .filter(|r| r.dt_s == dt_s)
                .map(|r| [r.sweeps as f64, 100.0 * r.off.abs().max(1.0e-9)])
                .collect(),
            mark: Mark::Joined,
            ..Series::default()
        })
        .collect::<Vec<_>>();
    report.draw(
        "sweeps",
        vec![LinePlot {
            title: "Position-based dynamics: error of the depth at rest".to_owned(),
            x_label: "sweeps per step".to_owned(),
            y_label: "error (%)".to_owned(),
            x_scale: Scale::Logarithmic,
            y_scale: Scale::Logarithmic,
            series: coloured(series),
        }],
    );
}
