//! What cannot be: told before a finger feels it.

use super::patch::{Bumps, Drag};
use super::{Dysfunction, Fault, Patch, Place};
use crate::contact::Friction;
use crate::geom::Vec2;
use crate::maps::StiffnessMap;
use std::ops::RangeInclusive;

/// Stiffness that dysfunctions may lead to, N/mm: what a key may state.
pub const STIFFNESS_N_PER_MM: RangeInclusive<f64> = 0.001..=10_000.0;
/// Largest friction coefficient that they may lead to: what `[friction]` may state.
const MOST_FRICTION: f64 = 10.0;
/// Factors on friction that they may lead to together.
const DRAGS: RangeInclusive<f64> = 0.05..=10.0;
/// Steepest that bumps together may be against the skin as it was: 45°. Beyond, a finger is felt to hit a wall.
const STEEPEST: f64 = 1.0;
/// Highest and deepest that bumps together may be, mm.
const HIGHEST_MM: f64 = 30.0;
/// Two places nearer than this are one, mm.
const SAME_PLACE_MM: f64 = 1.0;
/// Slopes are taken over this share of the shorter half axis.
const SLOPE_STEP: f64 = 0.01;

/// Which dysfunction is wrong, counted from 0, and how.
#[derive(Debug)]
pub struct Clash {
    pub index: usize,
    pub fault: Fault,
}

fn clash(index: usize, key: &'static str, what: impl Into<String>) -> Clash {
    let fault = Fault::new(key, what);
    Clash { index, fault }
}

/// The patches of all in order, each with the number of its dysfunction.
///
/// Where there is no `friction`, drag that is only a kind's default is left out. `map` is the stiffness without any of them.
pub fn check(
    all: &[Dysfunction],
    friction: Option<&Friction>,
    map: &StiffnessMap,
) -> Result<Vec<(usize, Patch)>, Clash> {
    let mut patches: Vec<(usize, Patch)> = Vec::new();
    for (index, d) in all.iter().enumerate() {
        let alone = d.kind().is_some_and(|k| k.is_felt_by_friction_alone());
        let stated = d.skin_drag.is_some_and(|drag| drag != 1.0);
        if friction.is_none() && (alone || stated) {
            let what = "skin drag is felt by friction, and the scenario has no [friction]; add it, or leave skin drag out";
            return Err(clash(
                index,
                if stated { "skin_drag" } else { "kind" },
                what,
            ));
        }
        let of = d.patches().map_err(|fault| Clash { index, fault })?;
        patches.extend(of.into_iter().map(|mut patch| {
            if friction.is_none() {
                patch.drag_factor = 1.0;
            }
            (index, patch)
        }));
    }
    pairs(all)?;
    tenderness(all, &patches)?;
    stiffness(&patches, map)?;
    drag(&patches, friction)?;
    bumps(&patches)?;
    Ok(patches)
}

/// Two of one kind at one place.
fn pairs(all: &[Dysfunction]) -> Result<(), Clash> {
    for (j, b) in all.iter().enumerate() {
        for (i, a) in all[..j].iter().enumerate() {
            if a.kind == b.kind
                && let Some(at) = shared(&a.place, &b.place)
            {
                let what = format!(
                    "dysfunction {} is {} at {at} too; keep one of them",
                    i + 1,
                    a.kind
                );
                return Err(clash(j, "kind", what));
            }
        }
    }
    Ok(())
}

/// A place that both have.
fn shared(a: &Place, b: &Place) -> Option<String> {
    let near = |x: Vec2, y: Vec2| x.distance(y) < SAME_PLACE_MM;
    match (a, b) {
        (Place::Sites(a), Place::Sites(b)) => {
            a.iter().find(|s| b.contains(s)).map(|s| s.to_string())
        }
        (Place::At(at), Place::Sites(sites)) | (Place::Sites(sites), Place::At(at)) => {
            let site = sites.iter().find(|s| near(s.at_mm(), *at));
            site.map(|s| s.to_string())
        }
        (Place::At(a), Place::At(b)) => near(*a, *b).then(|| format!("({}, {}) mm", b.x, b.y)),
    }
}

fn tenderness(all: &[Dysfunction], patches: &[(usize, Patch)]) -> Result<(), Clash> {
    let tender: Vec<_> = (patches.iter())
        .filter_map(|(i, p)| Some((*i, &p.spot, p.tender?)))
        .collect();
    for (n, (j, spot, tenderness)) in tender.iter().enumerate() {
        for (i, other, before) in &tender[..n] {
            let together = other.ratio(spot.at_mm) < 1.0 || spot.ratio(other.at_mm) < 1.0;
            if i != j && together && before != tenderness {
                let shown = |shown| if shown { "shown" } else { "silent" };
                let what = format!(
                    "tender above {} N ({}), but dysfunction {} ({}) states {} N ({}) at the same place",
                    tenderness.above_n,
                    shown(tenderness.shown),
                    i + 1,
                    all[*i],
                    before.above_n,
                    shown(before.shown)
                );
                return Err(clash(*j, "tender_above_n", what));
            }
        }
    }
    Ok(())
}

/// Places all over an ellipse, the centre first.
fn over(patch: &Patch, rings: u32, turns: u32) -> impl Iterator<Item = Vec2> {
    let centre = std::iter::once(patch.spot.at_mm);
    centre.chain((1..=rings).flat_map(move |ring| {
        let q = f64::from(ring) / f64::from(rings);
        (0..turns).map(move |t| {
            let turn = std::f64::consts::TAU * f64::from(t) / f64::from(turns);
            patch.spot.point(q, turn)
        })
    }))
}

fn stiffness(patches: &[(usize, Patch)], map: &StiffnessMap) -> Result<(), Clash> {
    let spots = patches.iter().map(|(_, p)| (&p.spot, p.stiffness_factor));
    let with = map.clone().with_spots(spots);
    let (mut before, mut after) = (map.reader(), with.reader());
    for (i, patch) in patches {
        if patch.stiffness_factor == 1.0 {
            continue;
        }
        for at in over(patch, 4, 8) {
            let k = after(at);
            if !STIFFNESS_N_PER_MM.contains(&k) && STIFFNESS_N_PER_MM.contains(&before(at)) {
                let what = format!(
                    "makes the stiffness {k:.4} N/mm at ({:.1}, {:.1}) mm; {} to {} is allowed",
                    at.x,
                    at.y,
                    STIFFNESS_N_PER_MM.start(),
                    STIFFNESS_N_PER_MM.end()
                );
                return Err(clash(*i, "stiffness_change", what));
            }
        }
    }
    Ok(())
}

fn drag(patches: &[(usize, Patch)], friction: Option<&Friction>) -> Result<(), Clash> {
    let Some(friction) = friction else {
        return Ok(());
    };
    let together = Drag::of(patches.iter().map(|(_, p)| p));
    let of = |p: &&(usize, Patch)| p.1.drag_factor != 1.0;
    for (i, patch) in patches.iter().filter(of) {
        for at in over(patch, 4, 8) {
            let drag = together.at(at);
            let coefficient = drag * friction.static_coefficient;
            if !DRAGS.contains(&drag) || coefficient > MOST_FRICTION {
                let what = format!(
                    "makes the drag {drag:.3} times that of [friction], a coefficient of {coefficient:.3}, at ({:.1}, {:.1}) \
                     mm; {} to {} times and a coefficient up to {MOST_FRICTION} are allowed",
                    at.x,
                    at.y,
                    DRAGS.start(),
                    DRAGS.end()
                );
                return Err(clash(*i, "skin_drag", what));
            }
        }
    }
    Ok(())
}

/// Bumps move the skin along z by a function of x and y: nothing can fold over or through itself. What is left to be checked
/// is how steep and how high they are together.
fn bumps(patches: &[(usize, Patch)]) -> Result<(), Clash> {
    let together = Bumps::of(patches.iter().map(|(_, p)| p));
    let height = |at| together.at(at);
    for (i, patch) in patches.iter().filter(|(_, p)| p.bump_mm != 0.0) {
        let [a, b] = patch.spot.half_axes_mm;
        let step_mm = SLOPE_STEP * a.min(b);
        for at in over(patch, 12, 16) {
            let rise = |way: Vec2| (height(at + way) - height(at - way)) / (2.0 * step_mm);
            let slope = Vec2::new(rise(Vec2::new(step_mm, 0.0)), rise(Vec2::new(0.0, step_mm)));
            let slope = slope.length();
            if slope > STEEPEST {
                let what = format!(
                    "makes a bump as steep as {slope:.2} mm per mm at ({:.1}, {:.1}) mm; up to {STEEPEST} is allowed: lower it \
                     or make radius_mm larger",
                    at.x, at.y
                );
                return Err(clash(*i, "bump_mm", what));
            }
            let high = height(at);
            if high.abs() > HIGHEST_MM {
                let what = format!(
                    "makes a bump of {high:.1} mm at ({:.1}, {:.1}) mm; up to {HIGHEST_MM} mm either way is allowed",
                    at.x, at.y
                );
                return Err(clash(*i, "bump_mm", what));
            }
        }
    }
    Ok(())
}
