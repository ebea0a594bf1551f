//! How long a step each integrator bears: found by halving, beside theory.
//!
//! A single mass on a spring, k and m, friction over mass c, ω² = k/m, step h:
//!
//! | integrator | where | theory |
//! |---|---|---|
//! | symplectic Euler, friction implicit | `Motion::step_explicit` | stable below ω² h² = 4 + 2 c h; without friction ω h = 2 |
//! | implicit Euler | `Motion::step_implicit`, the mouse's hand | always; each step shrinks areas of phase by 1/(1 + c h + ω² h²) |
//! | position-based | `Xpbd::step` | always; areas shrink by 1/((1 + c h)(1 + ω² h²)) for one spring |
//! | hand and skin by turns | `Mouse` with `servo::tick` | the skin's force is a tick old: explicit in it |
//!
//! All from the roots of the characteristic polynomial λ² − t λ + d by Jury's conditions: d < 1 and |t| < 1 + d (Jury 1964).

use crate::contact::{ForceModel, Stiffness, TouchScene};
use crate::device::mouse::{Hand, Mouse};
use crate::device::{Device as _, MAX_FINGERS};
use crate::figure::{LinePlot, Mark, Scale, Series};
use crate::geom::Vec3;
use crate::lab::{Choice, Experiment, LabError, Report, Setup, Table, Value, Verdict, Watch};
use crate::partition::bvh::Bvh;
use crate::reference::Elastic;
use crate::reference::fem::Slab;
use crate::reference::fem::linear::Fixed;
use crate::reference::springs::motion::{Motion, explicit_limit_s};
use crate::reference::springs::rest::rest;
use crate::reference::springs::xpbd::Xpbd;
use crate::reference::springs::{Lattice, Spring};
use crate::servo::{Limits, Rig, TickInput, tick};
use crate::surface::Surface;
use crate::surface::torture::{Stream, grid, steps};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Data colours: not the fingers' blue and red.
const COLOURS: [[u8; 3]; 6] = [
    [24, 26, 30],
    [0, 128, 90],
    [200, 130, 0],
    [120, 80, 160],
    [130, 90, 50],
    [120, 128, 138],
];

fn coloured(series: impl IntoIterator<Item = Series>) -> Vec<Series> {
    (series.into_iter().zip(COLOURS.into_iter().cycle()))
        .map(|(s, colour)| Series { colour, ..s })
        .collect()
}

/// The integrators.
pub struct Integrators;

/// Mass, kg, and stiffness, N/mm, of the single spring: a hand on skin.
const MASS_KG: f64 = 0.15;
const STIFFNESS_N_PER_MM: f64 = 1.5;
/// 1 N is 1000 kg mm/s².
const MM_PER_S2: f64 = 1000.0;
/// Growth of a disturbance that counts as blown up.
const BLOWN_UP: f64 = 1.0e3;

/// One limit, measured and by theory.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Limit {
    integrator: String,
    what: String,
    unit: String,
    theory: f64,
    measured: f64,
    /// Share that halving and the number of steps leave open.
    open: f64,
}

impl Limit {
    fn off(&self) -> f64 {
        (self.measured / self.theory - 1.0).abs()
    }

    fn holds(&self) -> bool {
        self.off() <= self.open
    }
}

impl Experiment for Integrators {
    fn name(&self) -> &'static str {
        "stability-integrators"
    }

    fn about(&self) -> &'static str {
        "The longest step of each integrator, measured by halving, beside theory"
    }

    fn takes(&self) -> &'static [Choice] {
        &[Choice::Seed]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let many = if setup.quick { 3_000 } else { 60_000 };
        let mut report = Report::default();
        report.set("spring", format!("{STIFFNESS_N_PER_MM} N/mm, {MASS_KG} kg"));
        report.set("steps", format!("{many} for each step length tried"));
        report.set("seed", setup.seed);
        let mut limits = Vec::new();
        for (i, friction) in [0.0, 10.0, 1.0e3].into_iter().enumerate() {
            watch.at("explicit steps", 0.05 * i as f64)?;
            let key = format!("explicit c={friction}");
            limits.push(setup.shelf.part(&key, || Ok(explicit(friction, many)))?);
        }
        watch.at("explicit steps of a lattice", 0.15)?;
        limits.extend(setup.shelf.part("lattices", || lattices(setup))?);
        watch.at("hand and skin", 0.4)?;
        limits.extend(setup.shelf.part("hand and skin", || Ok(loops(many)))?);
        watch.at("steps without a limit", 0.55)?;
        let damped = setup.shelf.part("damping", || damping(watch))?;
        watch.at("position-based steps of a lattice", 0.65)?;
        let swept = setup.shelf.part("sweeps", || sweeps(setup, watch))?;
        watch.at("rest", 0.9)?;
        let rests = setup.shelf.part("rest", || rests(setup))?;
        watch.at("energy", 0.95)?;
        tell_limits(&limits, &mut report);
        tell_damping(&damped, &mut report);
        tell_sweeps(&swept, &mut report);
        tell_rests(&rests, &mut report);
        report.draw("energy", energies(setup.quick));
        report.note(
            "No plain (forward) Euler is in the program: it gains energy at any step. Explicit steps are symplectic, the \
             friction in them implicit.",
        );
        Ok(report)
    }
}

/// Halves until the largest value that is stable is known to a part in 1e9, between one that is and one that is not.
fn border(mut stable: f64, mut blows: f64, mut is_stable: impl FnMut(f64) -> bool) -> f64 {
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

/// One mass on one spring along x.
fn single() -> Lattice {
    Lattice {
        rest_mm: vec![Vec3::ZERO, Vec3::X * 1.0e3],
        free: vec![Vec3::ZERO, Vec3::X],
        mass_kg: vec![0.0, MASS_KG],
        springs: vec![Spring {
            ends: [0, 1],
            length_mm: 1.0e3,
            stiffness_n_per_mm: STIFFNESS_N_PER_MM,
        }],
    }
}

fn omega_per_s() -> f64 {
    libm::sqrt(STIFFNESS_N_PER_MM * MM_PER_S2 / MASS_KG)
}

/// How much a limit measured with so many steps may be off: a root beyond 1 by a share ε of the step grows like e^(n √(8 ε))
/// without friction, where two roots meet at −1, and like e^(n ε/2) or faster with friction. A share ε below the limit a swing
/// without friction already rises to 1/√(2 ε) of the first.
fn open(many: usize, damped: bool) -> f64 {
    let rate = libm::log(BLOWN_UP) / many as f64;
    if damped {
        8.0 * rate
    } else {
        rate * rate + 1.0 / (BLOWN_UP * BLOWN_UP)
    }
}

fn explicit(friction_per_s: f64, many: usize) -> Limit {
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

/// A block of muscle as a lattice of n × n points and m layers.
fn block(n: usize, layers: usize) -> Option<Lattice> {
    let lines = steps(0.0, 20.0, n);
    let depths = steps(0.0, 1.0, layers);
    let slab = Slab::flat(&lines, &lines, &depths, 10.0).ok()?;
    Lattice::new(&slab, Elastic::MUSCLE, [Fixed::Held; 4]).ok()
}

fn lattices(setup: &Setup) -> Result<Vec<Limit>, LabError> {
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

/// A hand that follows its target implicitly, on a skin whose force is as old as the last tick.
///
/// With the hand's mass m, stiffness k, damping b, the skin's stiffness K and damping B about where they rest,
/// D = m + b h + k h² (in kg): v′ = (m v − (k + K) h x − B h v)/D, x′ = x + h v′. So t = 1 + (m − B h)/D − (k + K) h²/D and
/// d = (m − B h)/D: stable while (k + K) h² < 2 (D + m − B h).
struct Loop {
    hand: Hand,
    model: ForceModel,
    skin_n_per_mm: f64,
    dt_s: f64,
}

/// Depth that the hand holds, mm.
const HELD_MM: f64 = 4.0;

impl Loop {
    /// Stiffness and damping of the skin about where it is held.
    fn slopes(&self) -> [f64; 2] {
        match self.model {
            ForceModel::HuntCrossley {
                damping_s_per_mm,
                exponent,
            } => {
                let held_n = self.skin_n_per_mm * libm::pow(HELD_MM, exponent);
                [exponent * held_n / HELD_MM, held_n * damping_s_per_mm]
            }
            _ => [self.skin_n_per_mm, 0.0],
        }
    }

    /// What is left of stability, kg; 0 at the border.
    fn margin(&self) -> f64 {
        let Hand {
            mass_kg: m,
            stiffness_n_per_mm: k,
            damping_n_s_per_mm: b,
        } = self.hand;
        let h = self.dt_s;
        let [skin, damper] = self.slopes();
        let held = m + MM_PER_S2 * h * (b + k * h);
        2.0 * (held + m - MM_PER_S2 * damper * h) - MM_PER_S2 * (k + skin) * h * h
    }

    /// Whether hand and skin stay where they balance.
    fn stays(&self, scene: &TouchScene, many: usize) -> bool {
        let mut scene = scene.clone();
        scene.stiffness = Stiffness::Uniform(self.skin_n_per_mm);
        scene.choices.force = self.model;
        let free = Limits {
            rated_force_n: 1.0e12,
            rise_n_per_s: 1.0e18,
            ..Limits::default()
        };
        let held_n = self.model.force_n(self.skin_n_per_mm, HELD_MM, 0.0);
        let start_mm = 1.0e-6;
        let (mut device, handle) = Mouse::new(Vec3::Z * (start_mm - HELD_MM), self.hand);
        handle.set(Vec3::Z * (-HELD_MM - held_n / self.hand.stiffness_n_per_mm));
        device.write(Vec3::Z * held_n);
        let mut rig = Rig::new(Box::new(scene), [free; MAX_FINGERS]);
        let mut input = TickInput {
            n_fingers: 1,
            force_enabled: true,
            ..TickInput::default()
        };
        // Once outside, so that the skin holds.
        input.readings[0].connected = true;
        input.readings[0].position_mm = Vec3::Z;
        tick(&mut rig, &input, self.dt_s);
        for _ in 0..many {
            input.readings[0] = device.read(self.dt_s);
            let off = (input.readings[0].position_mm.z + HELD_MM).abs();
            if off.is_nan() || off >= start_mm * BLOWN_UP {
                return false;
            }
            device.write(tick(&mut rig, &input, self.dt_s).fingers[0].sent_force_n);
        }
        true
    }
}

/// The zero of a function that falls.
fn zero(mut above: f64, mut below: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..200 {
        let middle = 0.5 * (above + below);
        if f(middle) > 0.0 {
            above = middle;
        } else {
            below = middle;
        }
    }
    0.5 * (above + below)
}

fn loops(many: usize) -> Vec<Limit> {
    let s = steps(-10.0, 10.0, 2);
    let Ok((surface, _)) = Surface::new(grid(&s, &s, |_, _| 0.0)) else {
        return Vec::new();
    };
    let search = Arc::new(Bvh::new(&surface));
    let scene = TouchScene::new(Arc::new(surface), search, Stiffness::Uniform(1.0));
    let hand = Hand::default();
    let mut limits = Vec::new();
    let mut find =
        |integrator: &str, what: String, unit: &str, most: f64, of: &dyn Fn(f64) -> Loop| {
            let theory = zero(0.0, most, |x| of(x).margin());
            let measured = border(0.5 * theory, 2.0 * theory, |x| of(x).stays(&scene, many));
            limits.push(Limit {
                integrator: integrator.to_owned(),
                what,
                unit: unit.to_owned(),
                theory,
                measured,
                open: open(many, true),
            });
        };
    for rate_hz in [100.0, 1000.0, 10_000.0] {
        find(
            "mouse's hand on linear skin",
            format!("stiffest skin at {rate_hz} Hz"),
            "N/mm",
            1.0e9,
            &|skin_n_per_mm| Loop {
                hand,
                model: ForceModel::Linear,
                skin_n_per_mm,
                dt_s: 1.0 / rate_hz,
            },
        );
    }
    find(
        "mouse's hand on linear skin",
        "longest tick on 100 N/mm".to_owned(),
        "s",
        1.0,
        &|dt_s| Loop {
            hand,
            model: ForceModel::Linear,
            skin_n_per_mm: 100.0,
            dt_s,
        },
    );
    for exponent in [1.0, 1.5] {
        find(
            "mouse's hand on a Hunt–Crossley skin",
            format!("largest damping at 1 kHz, 2 N at 1 mm, exponent {exponent}"),
            "s/mm",
            1.0e6,
            &|damping_s_per_mm| Loop {
                hand,
                model: ForceModel::HuntCrossley {
                    damping_s_per_mm,
                    exponent,
                },
                skin_n_per_mm: 2.0,
                dt_s: 1.0e-3,
            },
        );
    }
    limits
}

fn tell_limits(limits: &[Limit], report: &mut Report) {
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

/// How an integrator without a limit shrinks an area of phase in a step of ω h.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Damped {
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

fn damping(watch: &mut Watch<'_>) -> Result<Vec<Damped>, LabError> {
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

fn tell_damping(rows: &[Damped], report: &mut Report) {
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

/// How far position-based dynamics comes to rest from where the lattice truly does.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Swept {
    sweeps: usize,
    dt_s: f64,
    /// Depth under the load over the true one, less 1.
    off: f64,
    /// Farthest that any point was from rest, mm, in the first half of the steps and in the second.
    largest_mm: [f64; 2],
}

const LOAD_N: f64 = 0.05;

fn middle_of(lattice: &Lattice, n: usize) -> (usize, f64) {
    let node = (n / 2) * (n + 1) + n / 2;
    (node, lattice.rest_mm[node].z)
}

fn sweeps(setup: &Setup, watch: &mut Watch<'_>) -> Result<Vec<Swept>, LabError> {
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

fn tell_sweeps(rows: &[Swept], report: &mut Report) {
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

/// Where Newton's method ended under a load.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Rested {
    load_n: f64,
    iterations: usize,
    said: f64,
    /// Largest force left over on a free point by the springs themselves, over the load.
    left: f64,
    depth_mm: f64,
}

fn rests(setup: &Setup) -> Result<Vec<Rested>, LabError> {
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

fn tell_rests(rows: &[Rested], report: &mut Report) {
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

/// Energy of one spring over time, explicit just below and just above the limit, and without a limit.
fn energies(quick: bool) -> Vec<LinePlot> {
    let lattice = single();
    let omega = omega_per_s();
    let limit_s = 2.0 / omega;
    let many = if quick { 60 } else { 400 };
    let start = |share: f64| {
        let mut motion = Motion::new(&lattice, 0.0);
        motion.at_mm[1].x += 1.0;
        (motion, share * limit_s)
    };
    let mut explicit = Vec::new();
    for share in [0.99, 0.999, 1.0001, 1.001, 1.01] {
        let (mut motion, dt_s) = start(share);
        let points = (0..many).map(|i| {
            let now = [f64::from(i) * dt_s, motion.energy_n_mm().max(1.0e-12)];
            motion.step_explicit(&[], dt_s);
            now
        });
        explicit.push(Series {
            name: format!("{share} of the limit"),
            points: points.take_while(|p| p[1] < 1.0e9).collect(),
            ..Series::default()
        });
    }
    let mut always = Vec::new();
    for share in [0.05, 0.2, 1.001] {
        let (mut motion, dt_s) = start(share);
        let points = (0..many).map(|i| {
            let now = [f64::from(i) * dt_s, motion.energy_n_mm()];
            let _ = motion.step_implicit(&[], dt_s);
            now
        });
        always.push(Series {
            name: format!("implicit, {share} of the explicit limit"),
            points: points.take_while(|p| p[1] > 1.0e-9).collect(),
            ..Series::default()
        });
    }
    let plot = |title: &str, series: Vec<Series>| LinePlot {
        title: title.to_owned(),
        x_label: "time (s)".to_owned(),
        y_label: "energy (N·mm)".to_owned(),
        x_scale: Scale::Linear,
        y_scale: Scale::Logarithmic,
        series: coloured(series),
    };
    vec![
        plot("Explicit steps just below and just above ω h = 2", explicit),
        plot("Implicit steps damp the more, the longer they are", always),
    ]
}
