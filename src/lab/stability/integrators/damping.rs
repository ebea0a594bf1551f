//! How integrators without a limit shrink what swings.

use super::{MASS_KG, MM_PER_S2, STIFFNESS_N_PER_MM, coloured, omega_per_s, single};
use crate::device::Device as _;
use crate::device::mouse::{Hand, Mouse};
use crate::figure::{LinePlot, Mark, Scale, Series};
use crate::geom::Vec3;
use crate::lab::{LabError, Report, Table, Verdict, Watch};
use crate::reference::springs::motion::Motion;
use crate::reference::springs::xpbd::Xpbd;
use serde::{Deserialize, Serialize};

/// How an integrator without a limit shrinks an area of phase in a step of ω h.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Damped {
    integrator: String,
    omega_h: f64,
    friction_h: f64,
    theory: f64,
    measured: f64,
    /// Largest way from rest over that at the start, over many steps.
    largest: f64,
}

/// Place and speed after a step from place and speed, for one of the integrators without a limit.
type Stepper<'a> = &'a dyn Fn([f64; 2], f64, f64) -> [f64; 2];

pub(super) fn damping(watch: &mut Watch<'_>) -> Result<Vec<Damped>, LabError> {
    let lattice = single();
    let implicit = |[x, v]: [f64; 2], friction: f64, dt_s: f64| {
        let mut motion = Motion::new(&lattice, friction);
        motion.at_mm[1].x += x;
        motion.velocity_mm_s[1].x = v;
        // A single spring's matrix is one positive number.
        let _ = motion.step_implicit(&[], dt_s);
        [motion.at_mm[1].x - 1.0e3, motion.velocity_mm_s[1].x]
    };
    let position_based = |[x, v]: [f64; 2], friction: f64, dt_s: f64| {
        let mut games = Xpbd::new(&lattice, friction);
        games.at_mm[1].x += x;
        games.velocity_mm_s[1].x = v;
        games.step(&[], dt_s, 1);
        [games.at_mm[1].x - 1.0e3, games.velocity_mm_s[1].x]
    };
    let omega = omega_per_s();
    let mut rows = Vec::new();
    for (i, power) in (-2..=3).enumerate() {
        watch.at("numerical damping", 0.55 + 0.01 * i as f64)?;
        let omega_h = 10_f64.powi(power);
        let dt_s = omega_h / omega;
        for friction_h in [0.0, 0.5] {
            let friction = friction_h / dt_s;
            let both = 1.0 + friction_h + omega_h * omega_h;
            let apart = (1.0 + friction_h) * (1.0 + omega_h * omega_h);
            let list: [(&str, Stepper<'_>, f64); 2] = [
                ("implicit spring", &implicit, 1.0 / both),
                ("position-based spring", &position_based, 1.0 / apart),
            ];
            for (name, step, theory) in list {
                rows.push(damped(name, omega_h, friction_h, theory, &|s| {
                    step(s, friction, dt_s)
                }));
            }
            // The hand has its friction as damping: b = c m.
            let hand = Hand {
                mass_kg: MASS_KG,
                stiffness_n_per_mm: STIFFNESS_N_PER_MM,
                damping_n_s_per_mm: friction * MASS_KG / MM_PER_S2,
            };
            let by_hand = hand_from(hand, dt_s);
            rows.push(damped(
                "mouse's hand",
                omega_h,
                friction_h,
                1.0 / both,
                &by_hand,
            ));
        }
    }
    Ok(rows)
}

/// Two steps of a hand pulled to the origin from rest at two places tell its map: it is linear.
fn hand_from(hand: Hand, dt_s: f64) -> impl Fn([f64; 2]) -> [f64; 2] {
    // From rest at 1 mm: (x₁, v₁) is the first column; the next step from there gives the second.
    let (mut mouse, handle) = Mouse::new(Vec3::X, hand);
    handle.set(Vec3::ZERO);
    let [one, two] = [0, 1].map(|_| {
        let r = mouse.read(dt_s);
        [r.position_mm.x, r.velocity_mm_s.x]
    });
    let column = |k: usize| (two[k] - one[k] * one[0]) / one[1];
    let second = [column(0), column(1)];
    move |[x, v]| [0, 1].map(|k| one[k] * x + second[k] * v)
}

fn damped(
    name: &str,
    omega_h: f64,
    friction_h: f64,
    theory: f64,
    step: &dyn Fn([f64; 2]) -> [f64; 2],
) -> Damped {
    let omega = omega_per_s();
    // The images of two states span an area that is smaller by the determinant.
    let (a, b) = (step([1.0, 0.0]), step([0.0, omega]));
    let measured = (a[0] * b[1] - a[1] * b[0]) / omega;
    let mut state = [1.0, 0.0];
    let mut largest = 0.0_f64;
    for _ in 0..2000 {
        state = step(state);
        largest = largest.max(libm::hypot(state[0], state[1] / omega));
    }
    Damped {
        integrator: name.to_owned(),
        omega_h,
        friction_h,
        theory,
        measured,
        largest,
    }
}

pub(super) fn tell_damping(rows: &[Damped], report: &mut Report) {
    let mut table = Table::new(
        "damping",
        "Integrators without a limit: what a step leaves of an area of phase",
        &[
            "integrator",
            "ω h",
            "c h",
            "theory",
            "measured",
            "off by",
            "largest swing over first",
        ],
    );
    let (mut off, mut swing) = (0.0_f64, 0.0_f64);
    for r in rows {
        // Of places of 1000 mm a millimetre keeps 13 digits.
        let apart = (r.measured - r.theory).abs();
        off = off.max(apart);
        swing = swing.max(r.largest);
        table.push([
            r.integrator.as_str().into(),
            r.omega_h.into(),
            r.friction_h.into(),
            r.theory.into(),
            r.measured.into(),
            apart.into(),
            r.largest.into(),
        ]);
    }
    report.tables.push(table);
    report.verdicts.push(Verdict::must(
        "numerical damping of implicit and position-based steps",
        format!("off by {off:.1e} at most"),
        "1/(1 + c h + ω² h²), 1/((1 + c h)(1 + ω² h²)) within 1e-9",
        off <= 1.0e-9,
    ));
    report.verdicts.push(Verdict::must(
        "implicit and position-based steps of any length",
        format!("largest swing {swing:.6} of the first"),
        "never more than the first",
        swing <= 1.0 + 1.0e-9,
    ));
    let curve = |name: &str, mark: Mark, of: fn(&Damped) -> f64| Series {
        name: name.to_owned(),
        points: (rows.iter())
            .filter(|r| r.integrator == "implicit spring" && r.friction_h == 0.0)
            .map(|r| [r.omega_h, of(r)])
            .collect(),
        mark,
        ..Series::default()
    };
    report.draw(
        "damping",
        vec![LinePlot {
            title: "What an implicit step leaves of an area of phase".to_owned(),
            x_label: "ω h (rad)".to_owned(),
            y_label: "share (1)".to_owned(),
            x_scale: Scale::Logarithmic,
            y_scale: Scale::Logarithmic,
            series: coloured([
                curve("theory, 1/(1 + ω² h²)", Mark::Line, |r| r.theory),
                curve("measured", Mark::Points, |r| r.measured),
            ]),
        }],
    );
}
