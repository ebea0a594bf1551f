//! The longest step that stays stable, found by halving.

use super::{block, omega_per_s, single};
use crate::lab::{LabError, Report, Setup, Table, Verdict};
use crate::reference::springs::Lattice;
use crate::reference::springs::motion::{Motion, explicit_limit_s};
use crate::surface::torture::Stream;
use serde::{Deserialize, Serialize};

/// Growth of a disturbance that counts as blown up.
pub(super) const BLOWN_UP: f64 = 1.0e3;

/// One limit, measured and by theory.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Limit {
    pub(super) integrator: String,
    pub(super) what: String,
    pub(super) unit: String,
    pub(super) theory: f64,
    pub(super) measured: f64,
    /// Share that halving and the number of steps leave open.
    pub(super) open: f64,
}

impl Limit {
    fn off(&self) -> f64 {
        (self.measured / self.theory - 1.0).abs()
    }

    fn holds(&self) -> bool {
        self.off() <= self.open
    }
}

/// Halves until the largest value that is stable is known to a part in 1e9, between one that is and one that is not.
pub(super) fn border(
    mut stable: f64,
    mut blows: f64,
    mut is_stable: impl FnMut(f64) -> bool,
) -> f64 {
    while (blows - stable) > 1.0e-9 * blows {
        let middle = 0.5 * (stable + blows);
        if is_stable(middle) {
            stable = middle;
        } else {
            blows = middle;
        }
    }
    0.5 * (stable + blows)
}

/// How much a limit measured with so many steps may be off: a root beyond 1 by a share ε of the step grows like e^(n √(8 ε))
/// without friction, where two roots meet at −1, and like e^(n ε/2) or faster with friction. A share ε below the limit a swing
/// without friction already rises to 1/√(2 ε) of the first.
pub(super) fn open(many: usize, damped: bool) -> f64 {
    let rate = libm::log(BLOWN_UP) / many as f64;
    if damped {
        8.0 * rate
    } else {
        rate * rate + 1.0 / (BLOWN_UP * BLOWN_UP)
    }
}

pub(super) fn explicit(friction_per_s: f64, many: usize) -> Limit {
    let lattice = single();
    let omega = omega_per_s();
    let theory = (friction_per_s + libm::hypot(friction_per_s, 2.0 * omega)) / (omega * omega);
    let measured = border(0.5 * theory, 2.0 * theory, |dt_s| {
        let mut motion = Motion::new(&lattice, friction_per_s);
        motion.at_mm[1].x += 1.0e-3;
        for _ in 0..many {
            motion.step_explicit(&[], dt_s);
            let off = (motion.at_mm[1].x - 1.0e3).abs();
            if off.is_nan() || off >= 1.0e-3 * BLOWN_UP {
                return false;
            }
        }
        true
    });
    Limit {
        integrator: "explicit spring".to_owned(),
        what: if friction_per_s > 0.0 {
            format!("longest step, ω² h² = 4 + 2 c h, c = {friction_per_s} /s")
        } else {
            "longest step, ω h = 2".to_owned()
        },
        unit: "ms".to_owned(),
        theory: theory * 1.0e3,
        measured: measured * 1.0e3,
        open: open(many, friction_per_s > 0.0),
    }
}

pub(super) fn lattices(setup: &Setup) -> Result<Vec<Limit>, LabError> {
    let sizes: &[(usize, usize)] = if setup.quick {
        &[(3, 1)]
    } else {
        &[(3, 1), (5, 2), (8, 4)]
    };
    let many = if setup.quick { 2_000 } else { 8_000 };
    let mut limits = Vec::new();
    for &(n, layers) in sizes {
        let mut lattice =
            block(n, layers).ok_or_else(|| LabError::Input("no lattice".to_owned()))?;
        for uneven in [false, true] {
            if uneven {
                // One spring in seven a hundred times as stiff: a few stiff modes among many soft ones.
                let stiff = lattice.springs.iter_mut().step_by(7);
                stiff.for_each(|s| s.stiffness_n_per_mm *= 100.0);
            }
            let theory = explicit_limit_s(&lattice);
            let measured = border(0.5 * theory, 2.0 * theory, |dt_s| {
                lattice_stays(&lattice, dt_s, many, setup.seed)
            });
            let kind = if uneven { ", some 100 × as stiff" } else { "" };
            limits.push(Limit {
                integrator: format!("explicit lattice, {} springs{kind}", lattice.springs.len()),
                what: "longest step, 2/ω of the stiffest mode by power iteration".to_owned(),
                unit: "ms".to_owned(),
                theory: theory * 1.0e3,
                measured: measured * 1.0e3,
                // The disturbance holds but a part of the stiffest mode, so it takes longer to show.
                open: 16.0 * open(many, false),
            });
        }
    }
    Ok(limits)
}

/// Whether a disturbance too small to bend the springs stays small.
fn lattice_stays(lattice: &Lattice, dt_s: f64, many: usize, seed: u64) -> bool {
    let start_mm = 1.0e-7;
    let mut stream = Stream(seed);
    let mut motion = Motion::new(lattice, 0.0);
    for (at, free) in motion.at_mm.iter_mut().zip(&lattice.free) {
        *at += stream.vector() * *free * start_mm;
    }
    for i in 0..many {
        motion.step_explicit(&[], dt_s);
        if i % 16 == 0 {
            let moved = motion.at_mm.iter().zip(&lattice.rest_mm);
            // What is no number has blown up too.
            let far = moved.map(|(a, r)| (*a - *r).length());
            let largest = far.fold(
                0.0,
                |m: f64, x| if x.is_nan() { f64::INFINITY } else { m.max(x) },
            );
            if largest >= BLOWN_UP * start_mm {
                return false;
            }
        }
    }
    true
}

pub(super) fn tell_limits(limits: &[Limit], report: &mut Report) {
    let mut table = Table::new(
        "limits",
        "Limits of stability: measured by halving, beside theory",
        &[
            "integrator",
            "limit",
            "unit",
            "theory",
            "measured",
            "off by (%)",
            "left open (%)",
            "verdict",
        ],
    );
    for l in limits {
        table.push([
            l.integrator.as_str().into(),
            l.what.as_str().into(),
            l.unit.as_str().into(),
            l.theory.into(),
            l.measured.into(),
            (100.0 * l.off()).into(),
            (100.0 * l.open).into(),
            if l.holds() { "as in theory" } else { "NOT" }.into(),
        ]);
        report.verdicts.push(Verdict::must(
            format!("{}: {}", l.integrator, l.what),
            format!("{:.6} {}", l.measured, l.unit),
            format!("{:.6} {} within {:.1e}", l.theory, l.unit, l.open),
            l.holds(),
        ));
    }
    report.tables.push(table);
}
