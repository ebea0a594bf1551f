//! What dysfunctions make of a scene: the surface lifted, skin drag and tenderness, and whether the mesh can carry them.

#[cfg(test)]
mod tests;

use super::dysfunction::{Bumps, Drag, Patch, STIFFNESS_N_PER_MM, Tenderness};
use super::needs::{Item, Needs};
use super::{BuildError, Ledger, Scenario, Scene};
use crate::contact::Stiffness;
use crate::maps::SpotReader;
use crate::surface::{RawMesh, Surface};
use std::sync::Arc;
use std::time::Instant;

/// Patches in order, each with the number of its dysfunction.
type Patches = [(usize, Patch)];

/// Least share of a patch that some vertex must have: with less, what is felt is not what is stated.
const LEAST_FELT: f64 = 0.5;

fn only(patches: &Patches) -> impl Iterator<Item = &Patch> {
    patches.iter().map(|(_, p)| p)
}

/// Moves the vertices along z, the height of the map. A shear: nothing can fold over or through itself, and a place of the
/// map stays above itself. Of a closed body both sides move.
pub(super) fn lift(patches: &Patches, raw: &mut RawMesh, needs: &Needs, ledger: &mut Ledger) {
    if !needs.has(Item::Bumps) {
        return;
    }
    let started = Instant::now();
    let bumps = Bumps::of(only(patches));
    for p in &mut raw.positions {
        p.z += bumps.at(p.truncate());
    }
    ledger.built(Item::Bumps, 0);
    ledger.cost(
        Item::Bumps,
        started.elapsed().as_secs_f64() * 1.0e6,
        "build",
    );
}

/// The patches that change what is felt, each with the number of its dysfunction and the largest share of it that a vertex
/// has.
fn shares<'a>(
    patches: &'a Patches,
    surface: &'a Surface,
) -> impl Iterator<Item = (usize, &'a Patch, f64)> {
    let felt = |p: &Patch| p.stiffness_factor != 1.0 || p.drag_factor != 1.0 || p.bump_mm != 0.0;
    patches
        .iter()
        .filter(move |(_, p)| felt(p))
        .map(|(index, patch)| {
            let spot = SpotReader::new(&patch.spot);
            let places = surface.positions().iter().map(|p| p.truncate());
            let most = places.map(|at| spot.weight(at)).fold(0.0, f64::max);
            (*index, patch, most)
        })
}

impl Scene {
    /// For each dysfunction the share of its strength that the mesh carries where it carries least, ½ … 1: between vertices
    /// it is interpolated, so that a small spot on a coarse mesh is weaker than stated. 1 for one that is not felt.
    pub fn carried(&self) -> Vec<f64> {
        let mut all = vec![1.0; self.scenario.dysfunctions.len()];
        let patches = self.scenario.patches().unwrap_or_default();
        for (index, _, share) in shares(&patches, &self.surface) {
            if let Some(least) = all.get_mut(index) {
                *least = f64::min(*least, share);
            }
        }
        all
    }
}

/// Whether every dysfunction is felt, but for tenderness, which needs no vertex: some vertex must have at least half of it.
///
/// # Errors
/// A mesh so coarse, or a place so far beside it, that less of one would be felt.
pub(super) fn fine_enough(
    scenario: &Scenario,
    patches: &Patches,
    surface: &Surface,
) -> Result<(), BuildError> {
    for (index, patch, most) in shares(patches, surface) {
        if most >= LEAST_FELT {
            continue;
        }
        let at = patch.spot.at_mm;
        let what = if most == 0.0 {
            format!(
                "no vertex of the mesh lies in it at ({:.1}, {:.1}) mm; choose a place on the skin, a finer mesh or a larger \
                 radius_mm",
                at.x, at.y
            )
        } else {
            format!(
                "the mesh is too coarse for it at ({:.1}, {:.1}) mm: at most {:.0} % of it would be felt, at least {:.0} % is \
                 needed; choose a finer mesh or a larger radius_mm",
                at.x,
                at.y,
                100.0 * most,
                100.0 * LEAST_FELT
            )
        };
        return Err(BuildError(scenario.about_dysfunction(index, &what)));
    }
    Ok(())
}

/// Whether the stiffness with dysfunctions is one that a key may state, at every vertex.
///
/// # Errors
/// It is not where it was without them.
pub(super) fn stiffness_allowed(
    scenario: &Scenario,
    patches: &Patches,
    surface: &Surface,
    stiffness: &Stiffness,
) -> Result<(), BuildError> {
    let Stiffness::PerVertex(values) = stiffness else {
        return Ok(());
    };
    if only(patches).all(|p| p.stiffness_factor == 1.0) {
        return Ok(());
    }
    let base = (scenario.base_stiffness_map()).map_err(|e| BuildError(e.to_string()))?;
    let mut before = base.reader();
    for (p, k) in surface.positions().iter().zip(&values[..]) {
        let at = p.truncate();
        if STIFFNESS_N_PER_MM.contains(k) || !STIFFNESS_N_PER_MM.contains(&before(at)) {
            continue;
        }
        let of = |(_, p): &&(usize, Patch)| p.stiffness_factor != 1.0 && p.spot.weight(at) > 0.0;
        let index = patches.iter().rev().find(of).map_or(0, |(index, _)| *index);
        let what = format!(
            "makes the stiffness {k:.4} N/mm at ({:.1}, {:.1}) mm; {} to {} is allowed",
            at.x,
            at.y,
            STIFFNESS_N_PER_MM.start(),
            STIFFNESS_N_PER_MM.end()
        );
        return Err(BuildError(scenario.about_dysfunction(index, &what)));
    }
    Ok(())
}

/// Skin drag per vertex, where it is needed.
pub(super) fn drag(
    patches: &Patches,
    needs: &Needs,
    surface: &Surface,
    ledger: &mut Ledger,
) -> Option<Arc<[f64]>> {
    if !needs.has(Item::SkinDrag) {
        return None;
    }
    let started = Instant::now();
    let drag = Drag::of(only(patches));
    let positions = surface.positions().iter();
    let values: Arc<[f64]> = positions.map(|p| drag.at(p.truncate())).collect();
    ledger.built(Item::SkinDrag, size_of_val(&values[..]));
    ledger.cost(
        Item::SkinDrag,
        started.elapsed().as_secs_f64() * 1.0e6,
        "build",
    );
    Some(values)
}

/// The places that hurt, where there are any.
pub(super) fn tenderness(
    patches: &Patches,
    needs: &Needs,
    ledger: &mut Ledger,
) -> Option<Arc<Tenderness>> {
    needs.has(Item::Tenderness).then(|| {
        let tenderness = Tenderness::of(only(patches));
        ledger.built(Item::Tenderness, tenderness.bytes());
        Arc::new(tenderness)
    })
}
