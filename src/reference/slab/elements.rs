//! Finite elements under the skin.

use super::{Body, Load, SIDES};
use crate::geom::{Vec2, Vec3};
use crate::reference::Elastic;
use crate::reference::fem::linear::{Linear, SolveError};
use crate::reference::fem::{Compliance, Corotated};
use crate::reference::patch::Patch;

impl Body for Linear {
    fn name(&self) -> &'static str {
        "fem-linear"
    }

    fn respond(&mut self, load: &Load<'_>, moved: &mut Vec<Vec3>) {
        *moved = self.displacements_mm(&load.forces_n());
        moved.truncate(load.patch.slab.skin_mm().len());
    }
}

/// Finite elements for small strains.
///
/// # Errors
/// See [`Linear::new`].
pub fn linear(patch: &Patch, material: Elastic) -> Result<Box<dyn Body>, SolveError> {
    Ok(Box::new(Linear::new(patch.slab.clone(), material, SIDES)?))
}

/// The skin's answer to a force on each of its nodes.
struct Condensed(Compliance);

impl Body for Condensed {
    fn name(&self) -> &'static str {
        "fem-condensed"
    }

    fn respond(&mut self, load: &Load<'_>, moved: &mut Vec<Vec3>) {
        let shares = load.patch.shares(load.place_mm, load.deviation_mm);
        let forces = shares
            .into_iter()
            .map(|(node, share)| (node, -load.force_n * share));
        self.0.displaced(forces, load.patch.plane.normal, moved);
    }
}

/// The skin's answer to a fingertip on each of its nodes; between nodes that of the four round it.
struct Pressed {
    compliance: Compliance,
    deviation_mm: f64,
}

impl Body for Pressed {
    fn name(&self) -> &'static str {
        "fem-pressed"
    }

    fn respond(&mut self, load: &Load<'_>, moved: &mut Vec<Vec3>) {
        moved.clear();
        let Some(round) = load.patch.round(load.place_mm) else {
            return;
        };
        debug_assert_eq!(load.deviation_mm, self.deviation_mm);
        let forces = round.map(|(node, share)| (node, -load.force_n * share));
        let normal = load.patch.plane.normal;
        self.compliance.displaced(forces.into_iter(), normal, moved);
    }
}

/// Finite elements condensed to the skin and to the direction of the press: an answer is a sum of columns, one for each node
/// under the finger. `None` when `progress`, told a fraction, says stop, or for too many nodes.
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
    let found = Compliance::of_nodes(&full, &normals, progress);
    Ok(found.map(|c| Box::new(Condensed(c)) as Box<dyn Body>))
}

/// The same for one shape of pressure, of standard deviation `deviation_mm`: an answer is a sum of four columns, however
/// fine the nodes are. Between nodes the pressure is by (spacing / deviation)² / 8 too wide.
///
/// # Errors
/// See [`Linear::new`].
pub fn pressed(
    patch: &Patch,
    material: Elastic,
    deviation_mm: f64,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Option<Box<dyn Body>>, SolveError> {
    let full = Linear::new(patch.slab.clone(), material, SIDES)?;
    let normals = vec![patch.plane.normal; patch.slab.skin_mm().len()];
    let load = |node: usize| {
        let n = patch.lines_mm.len();
        let at_mm = Vec2::new(patch.lines_mm[node % n], patch.lines_mm[node / n]);
        let shares = patch.shares(at_mm, deviation_mm).into_iter();
        shares
            .map(|(node, share)| (node, patch.plane.normal * share))
            .collect()
    };
    let found = Compliance::of(&full, &normals, &load, progress);
    Ok(found.map(|compliance| {
        Box::new(Pressed {
            compliance,
            deviation_mm,
        }) as Box<dyn Body>
    }))
}

/// Steps in which a load is put on bricks that turn.
const LOAD_STEPS: usize = 3;

struct Turning {
    slab: Corotated,
    tolerance: f64,
}

impl Body for Turning {
    fn name(&self) -> &'static str {
        "fem-corotated"
    }

    fn respond(&mut self, load: &Load<'_>, moved: &mut Vec<Vec3>) {
        moved.clear();
        if let Ok(solution) = self
            .slab
            .solve(&load.forces_n(), LOAD_STEPS, self.tolerance)
            && solution.residual <= self.tolerance
        {
            *moved = solution.displacements_mm;
            moved.truncate(load.patch.slab.skin_mm().len());
        }
    }

    fn is_linear(&self) -> bool {
        false
    }
}

/// Finite elements that turn, solved to a left-over force of `tolerance` of the load.
///
/// # Errors
/// See [`Corotated::new`].
pub fn corotated(
    patch: &Patch,
    material: Elastic,
    tolerance: f64,
) -> Result<Box<dyn Body>, SolveError> {
    let slab = Corotated::new(patch.slab.clone(), material, SIDES)?;
    Ok(Box::new(Turning { slab, tolerance }))
}
