//! Slabs as models of the drawn skin: a fingertip's pressure is put on, as strong as it takes to reach the depth.

use super::fem::linear::{Fixed, Linear, SolveError, skin_forces};
use super::fem::{Compliance, Corotated};
use super::material::Elastic;
use super::patch::Patch;
use super::spread::{Plane, Spread};
use super::springs::motion::{Motion, explicit_limit_s};
use super::springs::xpbd::Xpbd;
use super::springs::{Lattice, rest};
use crate::deform::{Displacement, Model, Press};
use crate::geom::{Vec2, Vec3};
use crate::surface::Surface;
use std::f64::consts::PI;

/// What answers a load on the skin of a slab.
pub trait Body: Send {
    /// Name in files, tables and the command line.
    fn name(&self) -> &'static str;

    /// How far the nodes of the skin move under forces on them, mm; empty where no answer is found.
    fn respond(&mut self, patch: &Patch, forces_n: &[(usize, Vec3)]) -> Vec<Vec3>;

    /// Whether twice the force moves everything twice as far.
    fn is_linear(&self) -> bool {
        true
    }
}

/// A slab under the skin as a model of the drawn skin.
///
/// Pressure with the shape of a Gaussian is put on along the normal of the press, as strong as makes the place pressed
/// `depth_mm` deep. One press at a time: of several the slab answers each by itself, and they add up.
pub struct SlabModel {
    patch: Patch,
    body: Box<dyn Body>,
    deviation_mm: f64,
    spread: Spread,
    force_n: f64,
}

impl SlabModel {
    /// A model of `body` on `patch`; the pressure has standard deviation `deviation_mm` > 0.
    pub fn new(patch: Patch, body: Box<dyn Body>, deviation_mm: f64) -> Self {
        Self {
            patch,
            body,
            deviation_mm,
            spread: Spread::default(),
            force_n: 0.0,
        }
    }

    /// The force of the last press answered, N.
    pub fn force_n(&self) -> f64 {
        self.force_n
    }

    /// Where the skin's nodes go for a press `depth_mm` deep at a place of the patch's plane, and the force, N.
    pub fn dent(&mut self, place_mm: Vec2, depth_mm: f64) -> (Vec<Vec3>, f64) {
        let (plane, s) = (self.patch.plane, self.deviation_mm);
        let unit = 1.0 / (2.0 * PI * s * s);
        let pressure = |at: Vec3| {
            let r_sq = (plane.place_mm(at) - place_mm).length_squared();
            plane.normal * (-unit * libm::exp(-r_sq / (2.0 * s * s)))
        };
        let load = skin_forces(&self.patch.slab, pressure);
        let depth = |patch: &Patch, moved: &[Vec3]| {
            patch
                .between(place_mm, moved)
                .map_or(0.0, |u| -u.dot(plane.normal))
        };
        let put = |force_n: f64| -> Vec<(usize, Vec3)> {
            load.iter().map(|(i, f)| (*i, *f * force_n)).collect()
        };
        // A first guess, then the secant through the last two: one step for what is linear.
        let first = 0.1;
        let moved = self.body.respond(&self.patch, &put(first));
        let (mut last, mut reached) = (first, depth(&self.patch, &moved));
        if reached <= 0.0 {
            return (Vec::new(), 0.0);
        }
        let mut force_n = first * depth_mm / reached;
        if self.body.is_linear() {
            let share = force_n / first;
            return (moved.iter().map(|u| *u * share).collect(), force_n);
        }
        let mut moved = moved;
        for _ in 0..12 {
            moved = self.body.respond(&self.patch, &put(force_n));
            let now = depth(&self.patch, &moved);
            let gain = (now - reached) / (force_n - last);
            if (now - depth_mm).abs() <= 1.0e-6 * depth_mm || gain.is_nan() || gain <= 0.0 {
                break;
            }
            let next = force_n + (depth_mm - now) / gain;
            (last, reached) = (force_n, now);
            force_n = next.clamp(0.25 * force_n, 4.0 * force_n);
        }
        (moved, force_n)
    }
}

impl Model for SlabModel {
    fn name(&self) -> &'static str {
        self.body.name()
    }

    fn update(&mut self, surface: &Surface, presses: &[Press], out: &mut Displacement) {
        self.spread.begin(surface);
        self.force_n = 0.0;
        for press in presses {
            if Plane::of(press, surface).is_none()
                || !(press.depth_mm > 0.0 && press.depth_mm.is_finite())
            {
                continue;
            }
            let place_mm = self.patch.plane.place_mm(press.anchor_mm);
            let (moved, force_n) = self.dent(place_mm, press.depth_mm);
            self.force_n = force_n;
            let patch = &self.patch;
            self.spread.around(surface, press.triangle, |at| {
                patch.between(patch.plane.place_mm(at), &moved)
            });
        }
        self.spread.write(surface, out);
    }
}

/// Sides of a patch: held.
const SIDES: [Fixed; 4] = [Fixed::Held; 4];

impl Body for Linear {
    fn name(&self) -> &'static str {
        "fem-linear"
    }

    fn respond(&mut self, patch: &Patch, forces_n: &[(usize, Vec3)]) -> Vec<Vec3> {
        let mut moved = self.displacements_mm(forces_n);
        moved.truncate(patch.slab.skin_mm().len());
        moved
    }
}

/// Finite elements for small strains.
///
/// # Errors
/// See [`Linear::new`].
pub fn linear(patch: &Patch, material: Elastic) -> Result<Box<dyn Body>, SolveError> {
    Ok(Box::new(Linear::new(patch.slab.clone(), material, SIDES)?))
}

struct Condensed(Compliance);

impl Body for Condensed {
    fn name(&self) -> &'static str {
        "fem-condensed"
    }

    fn respond(&mut self, patch: &Patch, forces_n: &[(usize, Vec3)]) -> Vec<Vec3> {
        let normal = patch.plane.normal;
        let along: Vec<(usize, f64)> = forces_n.iter().map(|(i, f)| (*i, f.dot(normal))).collect();
        let mut moved = Vec::new();
        self.0.displacements_mm(&along, &mut moved);
        moved.into_iter().map(|u| normal * u).collect()
    }
}

/// The same, condensed to the skin and to the direction of the press. `None` when `progress` says stop or it is too large.
///
/// # Errors
/// See [`Linear::new`].
pub fn condensed(
    patch: &Patch,
    material: Elastic,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Option<Box<dyn Body>>, SolveError> {
    let full = Linear::new(patch.slab.clone(), material, SIDES)?;
    let normals = vec![patch.plane.normal; patch.slab.skin_mm().len()];
    let condensed = Compliance::of(&full, &normals, progress);
    Ok(condensed.map(|c| Box::new(Condensed(c)) as Box<dyn Body>))
}

impl Body for Corotated {
    fn name(&self) -> &'static str {
        "fem-corotated"
    }

    fn respond(&mut self, patch: &Patch, forces_n: &[(usize, Vec3)]) -> Vec<Vec3> {
        match self.solve(forces_n, 3) {
            Ok(solution) if solution.residual < 1.0e-6 => {
                let mut moved = solution.displacements_mm;
                moved.truncate(patch.slab.skin_mm().len());
                moved
            }
            _ => Vec::new(),
        }
    }

    fn is_linear(&self) -> bool {
        false
    }
}

/// Finite elements that turn.
///
/// # Errors
/// See [`Corotated::new`].
pub fn corotated(patch: &Patch, material: Elastic) -> Result<Box<dyn Body>, SolveError> {
    Ok(Box::new(Corotated::new(
        patch.slab.clone(),
        material,
        SIDES,
    )?))
}

/// How a lattice of springs is brought to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stepping {
    /// Newton's method.
    Rest,
    /// So many explicit steps at nine tenths of the longest stable one.
    Explicit(usize),
    /// So many implicit steps of 1/60 s.
    Implicit(usize),
    /// So many steps of 1/60 s with 10 sweeps of position-based dynamics each.
    Position(usize),
}

struct Springs {
    lattice: Lattice,
    stepping: Stepping,
    dt_s: f64,
}

/// Springs fitted to a material, brought to rest by `stepping`.
///
/// # Errors
/// See [`Lattice::new`].
pub fn springs(
    patch: &Patch,
    material: Elastic,
    stepping: Stepping,
) -> Result<Box<dyn Body>, SolveError> {
    let lattice = Lattice::new(&patch.slab, material, SIDES)?;
    let dt_s = match stepping {
        Stepping::Explicit(_) => 0.9 * explicit_limit_s(&lattice),
        _ => 1.0 / 60.0,
    };
    Ok(Box::new(Springs {
        lattice,
        stepping,
        dt_s,
    }))
}

/// Friction over mass that lets the slab settle without swinging, 1/s.
const DAMPING_PER_S: f64 = 60.0;

impl Body for Springs {
    fn name(&self) -> &'static str {
        match self.stepping {
            Stepping::Rest => "springs-rest",
            Stepping::Explicit(_) => "springs-explicit",
            Stepping::Implicit(_) => "springs-implicit",
            Stepping::Position(_) => "xpbd",
        }
    }

    fn respond(&mut self, patch: &Patch, forces_n: &[(usize, Vec3)]) -> Vec<Vec3> {
        let lattice = &self.lattice;
        let at_mm = match self.stepping {
            Stepping::Rest => match rest::rest(lattice, forces_n) {
                Ok(found) if found.residual < 1.0e-6 => {
                    let moved = found.displacements_mm;
                    moved
                        .iter()
                        .zip(&lattice.rest_mm)
                        .map(|(u, r)| *u + *r)
                        .collect()
                }
                _ => return Vec::new(),
            },
            Stepping::Explicit(steps) => {
                let mut motion = Motion::new(lattice, DAMPING_PER_S);
                (0..steps).for_each(|_| motion.step_explicit(forces_n, self.dt_s));
                motion.at_mm
            }
            Stepping::Implicit(steps) => {
                let mut motion = Motion::new(lattice, DAMPING_PER_S);
                for _ in 0..steps {
                    if motion.step_implicit(forces_n, self.dt_s).is_err() {
                        return Vec::new();
                    }
                }
                motion.at_mm
            }
            Stepping::Position(steps) => {
                let mut games = Xpbd::new(lattice, DAMPING_PER_S);
                (0..steps).for_each(|_| games.step(forces_n, self.dt_s, 10));
                games.at_mm
            }
        };
        let moved = at_mm.iter().zip(&lattice.rest_mm).map(|(a, r)| *a - *r);
        moved.take(patch.slab.skin_mm().len()).collect()
    }

    fn is_linear(&self) -> bool {
        false
    }
}
