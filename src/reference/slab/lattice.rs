//! Springs under the skin.

use super::{Body, Load, SIDES};
use crate::geom::Vec3;
use crate::reference::Elastic;
use crate::reference::fem::mesh::SlabError;
use crate::reference::patch::Patch;
use crate::reference::springs::motion::{Motion, explicit_limit_s};
use crate::reference::springs::xpbd::Xpbd;
use crate::reference::springs::{Lattice, rest};

/// How a lattice of springs is brought to rest under a load, from rest without one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stepping {
    /// Newton's method.
    Rest,
    /// So many explicit steps of half the longest that is stable at rest: springs that are pressed together are stiffer.
    Explicit(usize),
    /// So many implicit steps of 1/60 s.
    Implicit(usize),
    /// So many frames of 1/60 s of position-based dynamics, in so many steps each, with so many sweeps each.
    Position(usize, usize, usize),
}

/// A frame, s.
const FRAME_S: f64 = 1.0 / 60.0;
/// Part of the longest stable step taken.
const OF_LIMIT: f64 = 0.5;
/// Friction over mass that lets the slab settle without swinging, 1/s.
const DAMPING_PER_S: f64 = 60.0;
/// Left-over force, over the largest one applied, up to which springs are at rest.
const RESIDUAL: f64 = 1.0e-6;

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
) -> Result<Box<dyn Body>, SlabError> {
    let lattice = Lattice::new(&patch.slab, material, SIDES)?;
    let dt_s = match stepping {
        Stepping::Explicit(_) => OF_LIMIT * explicit_limit_s(&lattice),
        _ => FRAME_S,
    };
    Ok(Box::new(Springs {
        lattice,
        stepping,
        dt_s,
    }))
}

impl Springs {
    /// Where the points go under forces; `None` where they come to no rest.
    fn settled_mm(&self, forces_n: &[(usize, Vec3)]) -> Option<Vec<Vec3>> {
        let lattice = &self.lattice;
        match self.stepping {
            Stepping::Rest => {
                let found = rest::rest(lattice, forces_n).ok()?;
                let whole = found.displacements_mm.iter().zip(&lattice.rest_mm);
                (found.residual < RESIDUAL).then(|| whole.map(|(u, r)| *u + *r).collect())
            }
            Stepping::Explicit(steps) => {
                let mut motion = Motion::new(lattice, DAMPING_PER_S);
                (0..steps).for_each(|_| motion.step_explicit(forces_n, self.dt_s));
                Some(motion.at_mm)
            }
            Stepping::Implicit(steps) => {
                let mut motion = Motion::new(lattice, DAMPING_PER_S);
                for _ in 0..steps {
                    motion.step_implicit(forces_n, self.dt_s).ok()?;
                }
                Some(motion.at_mm)
            }
            Stepping::Position(frames, steps, sweeps) => {
                let mut games = Xpbd::new(lattice, DAMPING_PER_S);
                let dt_s = self.dt_s / steps as f64;
                (0..frames * steps).for_each(|_| games.step(forces_n, dt_s, sweeps));
                Some(games.at_mm)
            }
        }
    }
}

impl Body for Springs {
    fn name(&self) -> &'static str {
        match self.stepping {
            Stepping::Rest => "springs-rest",
            Stepping::Explicit(_) => "springs-explicit",
            Stepping::Implicit(_) => "springs-implicit",
            Stepping::Position(..) => "xpbd",
        }
    }

    fn respond(&mut self, load: &Load<'_>, moved: &mut Vec<Vec3>) {
        moved.clear();
        if let Some(at_mm) = self.settled_mm(&load.forces_n()) {
            let by = at_mm
                .iter()
                .zip(&self.lattice.rest_mm)
                .map(|(a, r)| *a - *r);
            moved.extend(by.take(load.patch.slab.skin_mm().len()));
        }
    }

    fn is_linear(&self) -> bool {
        false
    }
}
