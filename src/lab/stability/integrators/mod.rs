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

mod damping;
mod energy;
mod hand_and_skin;
mod limits;
mod rests;
mod sweeps;

use crate::figure::Series;
use crate::geom::Vec3;
use crate::lab::{Choice, Experiment, LabError, Report, Setup, Watch};
use crate::reference::Elastic;
use crate::reference::fem::Slab;
use crate::reference::fem::linear::Fixed;
use crate::reference::springs::{Lattice, Spring};
use crate::surface::torture::steps;
use damping::{damping, tell_damping};
use energy::energies;
use hand_and_skin::loops;
use limits::{explicit, lattices, tell_limits};
use rests::{rests, tell_rests};
use sweeps::{sweeps, tell_sweeps};

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

/// A block of muscle as a lattice of n × n points and m layers.
fn block(n: usize, layers: usize) -> Option<Lattice> {
    let lines = steps(0.0, 20.0, n);
    let depths = steps(0.0, 1.0, layers);
    let slab = Slab::flat(&lines, &lines, &depths, 10.0).ok()?;
    Lattice::new(&slab, Elastic::MUSCLE, [Fixed::Held; 4]).ok()
}

fn middle_of(lattice: &Lattice, n: usize) -> (usize, f64) {
    let node = (n / 2) * (n + 1) + n / 2;
    (node, lattice.rest_mm[node].z)
}
