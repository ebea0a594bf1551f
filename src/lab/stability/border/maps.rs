//! Maps over damping and stiffness: what becomes of a tap in each cell, under the lines of theory.

use crate::figure::{CellMap, Class as CellClass, Mark, Scale, Series};
use crate::lab::stability::closed_loop::{Bench, Class, Loop, UNLIMITED};
use crate::lab::stability::devices::{Haptic, LINEAR};
use crate::lab::stability::plant::Hand;
use crate::lab::stability::search::{Tally, on_all_processors};
use crate::lab::stability::theory::{
    LinearLoop, passive_quantised_n_per_mm, passive_stiffness_n_per_mm,
};
use crate::lab::{LabError, Report, Setup, Verdict, Watch};
use serde::{Deserialize, Serialize};

/// One map.
struct Plan {
    name: &'static str,
    title: &'static str,
    rate_hz: f64,
    delay_ticks: f64,
    quantum_mm: f64,
    coulomb_n: f64,
}

const fn plan(name: &'static str, title: &'static str, loop_: [f64; 4]) -> Plan {
    let [rate_hz, delay_ticks, quantum_mm, coulomb_n] = loop_;
    Plan {
        name,
        title,
        rate_hz,
        delay_ticks,
        quantum_mm,
        coulomb_n,
    }
}

const PLANS: [Plan; 6] = [
    plan("map-1-khz", "1 kHz, force at once", [1000.0, 0.0, 0.0, 0.0]),
    plan(
        "map-1-khz-delay",
        "1 kHz, force a tick later",
        [1000.0, 1.0, 0.0, 0.0],
    ),
    plan(
        "map-1-khz-steps",
        "1 kHz, encoder steps of 0.03 mm, friction 0.1 N",
        [1000.0, 0.0, 0.03, 0.1],
    ),
    plan(
        "map-100-hz",
        "100 Hz, force at once",
        [100.0, 0.0, 0.0, 0.0],
    ),
    plan(
        "map-300-hz",
        "300 Hz, force at once",
        [300.0, 0.0, 0.0, 0.0],
    ),
    plan(
        "map-10-khz",
        "10 kHz, force at once",
        [10_000.0, 0.0, 0.0, 0.0],
    ),
];

/// Dampings of the device, N·s/mm, and stiffnesses of the skin, N/mm, that are mapped.
const DAMPING_N_S_PER_MM: [f64; 2] = [1.0e-4, 1.0e-1];
const STIFFNESS_N_PER_MM: [f64; 2] = [0.01, 1000.0];

/// Fills of the classes, from stable to unstable.
const FILLS: [[u8; 3]; 3] = [[216, 233, 224], [244, 213, 141], [176, 129, 168]];
const PASSIVE: [u8; 3] = [24, 26, 30];
const COUPLED: [u8; 3] = [0, 104, 88];

/// A row of cells of one stiffness.
#[derive(Serialize, Deserialize)]
struct Row {
    classes: Vec<Class>,
    tally: Tally,
}

/// Edges of `n` cells over a range, evenly in the logarithm.
fn edges([low, high]: [f64; 2], n: usize) -> Vec<f64> {
    (0..=n)
        .map(|i| low * libm::pow(high / low, i as f64 / n as f64))
        .collect()
}

/// The middle of each cell.
fn middles(edges: &[f64]) -> Vec<f64> {
    edges.windows(2).map(|e| libm::sqrt(e[0] * e[1])).collect()
}

impl Plan {
    fn is_linear(&self) -> bool {
        self.quantum_mm == 0.0 && self.coulomb_n == 0.0
    }

    fn device(&self, damping_n_s_per_mm: f64) -> Haptic {
        Haptic {
            damping_n_s_per_mm,
            coulomb_n: self.coulomb_n,
            quantum_mm: self.quantum_mm,
            ..LINEAR
        }
    }

    fn lap(&self, damping_n_s_per_mm: f64, stiffness_n_per_mm: f64) -> Loop {
        Loop {
            plant: self.device(damping_n_s_per_mm).held_by(&Hand::middle()),
            stiffness_n_per_mm,
            rate_hz: self.rate_hz,
            delay_ticks: self.delay_ticks,
            quantum_mm: self.quantum_mm,
            limits: UNLIMITED,
        }
    }

    /// The stiffest passive skin, N/mm.
    fn passive(&self, damping: f64) -> f64 {
        let period_s = 1.0 / self.rate_hz;
        let sampled =
            passive_stiffness_n_per_mm(damping, period_s, self.delay_ticks * period_s, 0.0);
        let stepped =
            passive_quantised_n_per_mm(damping, period_s, self.coulomb_n, self.quantum_mm);
        if self.quantum_mm > 0.0 {
            sampled.min(stepped)
        } else {
            sampled
        }
    }

    /// The stiffest skin on which the linear loop is stable, N/mm. Friction helps and steps do not: without them.
    fn coupled(&self, damping: f64) -> f64 {
        let plant = self.lap(damping, 1.0).plant;
        let linear = LinearLoop::new(&plant, 1.0 / self.rate_hz, self.delay_ticks);
        linear.stable_stiffness_n_per_mm(0.9 * self.passive(damping))
    }
}

/// Draws all maps; a quick look has the first three in few cells.
pub(super) fn draw(
    bench: &Bench,
    setup: &Setup,
    report: &mut Report,
    watch: &mut Watch<'_>,
) -> Result<Tally, LabError> {
    let (columns, rows, plans) = if setup.quick {
        (5, 7, &PLANS[..2])
    } else {
        (48, 60, &PLANS[..])
    };
    let mut tally = Tally::default();
    let (mut active, mut quiet, mut checked) = (0_u32, 0_u32, 0_u32);
    for (i, plan) in plans.iter().enumerate() {
        let share = |done: f64| (i as f64 + done) / plans.len() as f64;
        let x_edges = edges(DAMPING_N_S_PER_MM, columns);
        let y_edges = edges(STIFFNESS_N_PER_MM, rows);
        let dampings = middles(&x_edges);
        let mut cells = Vec::new();
        for (j, k) in middles(&y_edges).into_iter().enumerate() {
            watch.at(
                &format!("map: {}", plan.title),
                share(j as f64 / rows as f64),
            )?;
            let key = format!("{} {columns}x{rows} row {j}", plan.name);
            let row: Row = setup
                .shelf
                .part(&key, || Ok(row(bench, plan, &dampings, k)))?;
            tally += row.tally;
            if plan.is_linear() {
                for (damping, class) in dampings.iter().zip(&row.classes) {
                    checked += 1;
                    let passive = k < plan.passive(*damping) / NEAR;
                    active += u32::from(passive && *class != Class::Stable);
                    let beyond = k > plan.coupled(*damping) * NEAR;
                    quiet += u32::from(beyond && *class == Class::Stable);
                }
            }
            cells.extend(row.classes.iter().map(|c| *c as u8));
        }
        report.draw_map(plan.name, map(plan, x_edges, y_edges, cells));
    }
    report.set(
        "maps",
        format!(
            "{columns} × {rows} cells; device of {} g in the middle hand",
            LINEAR.mass_kg * 1e3
        ),
    );
    report.verdicts.push(Verdict::must(
        "maps of linear devices: cells below the passive line that did not rest",
        format!("{active} of {checked}"),
        "0",
        active == 0,
    ));
    report.verdicts.push(Verdict::must(
        "maps of linear devices: cells above the coupled line that rested",
        format!("{quiet} of {checked}"),
        "0",
        quiet == 0,
    ));
    Ok(tally)
}

/// So near to a line, a factor, a cell belongs to neither side.
const NEAR: f64 = 1.05;

fn row(bench: &Bench, plan: &Plan, dampings: &[f64], k: f64) -> Row {
    let outcomes = on_all_processors(dampings, |b| bench.tap(&plan.lap(*b, k)));
    let mut tally = Tally::default();
    for outcome in &outcomes {
        tally += Tally::from(outcome);
    }
    Row {
        classes: outcomes.iter().map(|o| o.class).collect(),
        tally,
    }
}

fn map(plan: &Plan, x_edges: Vec<f64>, y_edges: Vec<f64>, cells: Vec<u8>) -> CellMap {
    let [low, high] = STIFFNESS_N_PER_MM;
    let line = |name: &str, colour, at: &dyn Fn(f64) -> f64| Series {
        name: name.to_owned(),
        colour,
        mark: Mark::Line,
        points: edges(DAMPING_N_S_PER_MM, 96)
            .into_iter()
            .map(|b| [b, at(b)])
            .filter(|p| (low..=high).contains(&p[1]))
            .collect(),
    };
    CellMap {
        title: plan.title.to_owned(),
        x_label: "damping of the device (N·s/mm)".to_owned(),
        y_label: "stiffness of the skin (N/mm)".to_owned(),
        x_scale: Scale::Logarithmic,
        y_scale: Scale::Logarithmic,
        x_edges,
        y_edges,
        cells,
        classes: Class::ALL
            .iter()
            .zip(FILLS)
            .map(|(class, colour)| CellClass {
                name: class.name().to_owned(),
                colour,
            })
            .collect(),
        series: vec![
            line("passive, whatever holds it", PASSIVE, &|b| plan.passive(b)),
            line("stable in this hand", COUPLED, &|b| plan.coupled(b)),
        ],
    }
}
