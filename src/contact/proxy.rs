//! The constraint-based proxy, a god object (Zilles & Salisbury 1995; Ruspini, Kolarov & Khatib 1997): what the finger
//! would be had the surface stopped it.
//!
//! Free, it moves straight to the HIP unless the surface is in the way. On the surface it follows the HIP by the
//! [`walk`](super::walk). The two alternate within one tick until the proxy rests or is free.
//!
//! The surface is one-sided: it stops what comes from outside; what is inside comes out freely. A proxy on the surface
//! is on its outer side because it is *said* to be on a triangle, not because of where rounding puts it. Where a motion
//! starts on the surface, it starts from a witness a little way into the triangle and above it, which is on the outer
//! side of every neighbour, however sharp the crease.

use super::face::Face;
use super::force::sound_stiffness;
use super::friction::Cone;
use super::pad::Pad;
use super::walk::{Footing, Outcome, Rest, TOUCH_LIFTS, Walk};
use super::{Contact, ContactState, Guard, Hip, Shading, Touch, TouchScene};
use crate::geom::{Vec3, unit_or};
use crate::partition::{Hit, Partition, Sides};

/// Farthest HIP that is believed, mm (1000 km): beyond it a reading is a fault, and squares of lengths stay finite.
pub const FARTHEST_MM: f64 = 1.0e9;

/// Rounding of a height, in units in the last place of the largest coordinate, with a wide margin: heights are sums of
/// three products of differences.
pub(super) const LIFT_ULPS: f64 = 64.0;
/// How far a witness lies inside its triangle, in lifts: enough to be above a neighbour that closes a wedge of 1°.
pub(super) const WITNESS_LIFTS: f64 = 1024.0;
/// Most times the proxy leaves the surface and comes back within one tick; then it waits on the surface.
const MAX_LANDINGS: u32 = 256;
/// Most times it changes over to another sheet without moving: then no sheet leads further.
const MAX_IN_PLACE: u32 = 8;

/// Moves the proxy of one finger after the HIP and returns what the finger feels: see [`advance`](super::advance).
pub(super) fn advance(scene: &TouchScene, state: &mut ContactState, hip: Hip) -> Contact {
    let hip_mm = hip.position_mm;
    let on_surface = state.touch != Touch::Free
        && (state.triangle as usize) < scene.surface.triangles().len()
        && state.proxy_mm.is_finite();
    if !(hip_mm.abs().max_element() <= FARTHEST_MM && hip_mm.is_finite()) {
        return waiting(scene, state, on_surface);
    }
    let cone = Cone::of(scene.friction.as_ref());
    let lift = LIFT_ULPS
        * f64::EPSILON
        * (hip_mm.abs().max_element() + state.proxy_mm.abs().max_element());
    let slipping = state.touch == Touch::Slip;
    let rest = if let Some(radius) = scene.choices.pad_mm() {
        let pad = Pad {
            surface: &scene.surface,
            search: &scene.search,
            hip: hip_mm,
            cone,
            radius,
            lift,
        };
        let touching = on_surface.then_some(state.triangle);
        let cone_at = |triangle, p| Cone::at(scene, triangle, p);
        pad.follow(state.proxy_mm, touching, slipping, cone_at)
            .map(|rest| (rest, false))
    } else {
        let walk = Walk {
            surface: &scene.surface,
            search: &scene.search,
            hip: hip_mm,
            cone,
            lift,
            sides: scene.choices.sides,
            behind: on_surface && state.behind,
        };
        if on_surface {
            let here = Footing {
                triangle: state.triangle,
                point: state.proxy_mm,
                behind: state.behind,
            };
            follow(scene, dragged(scene, walk, here), here, slipping)
        } else {
            approach(scene, &walk, state.proxy_mm)
                .and_then(|footing| follow(scene, dragged(scene, walk, footing), footing, false))
        }
    };
    let contact = match rest {
        Some((rest, behind)) => {
            let plain = Contact {
                behind,
                ..felt(scene, &rest, cone, hip)
            };
            match (&scene.shading, scene.choices.pad_mm()) {
                (Some(shading), None) => shaded(scene, shading, &rest, plain, hip, state),
                _ => plain,
            }
        }
        None => Contact {
            anchor_mm: hip_mm,
            foot_mm: hip_mm,
            ..Contact::default()
        },
    };
    *state = ContactState::after(hip_mm, &contact);
    contact
}

/// The walk with the skin drag of where it starts.
fn dragged<'a>(scene: &TouchScene, walk: Walk<'a>, start: Footing) -> Walk<'a> {
    Walk {
        cone: Cone::at(scene, start.triangle, start.point),
        ..walk
    }
}

/// No reading: the proxy stays, no force.
pub(super) fn waiting(scene: &TouchScene, state: &ContactState, on_surface: bool) -> Contact {
    let idle = Contact {
        anchor_mm: state.proxy_mm,
        foot_mm: state.proxy_mm,
        ..Contact::default()
    };
    if !on_surface {
        return idle;
    }
    let out = scene.surface.triangle(state.triangle).normal();
    Contact {
        touch: state.touch,
        triangle: state.triangle,
        behind: state.behind,
        normal: if state.behind { -out } else { out },
        stiffness_n_per_mm: stiffness_at(scene, state.triangle, state.proxy_mm),
        ..idle
    }
}

/// The first place where the free motion from `from` to the HIP meets the surface.
///
/// A proxy that came to stand on the surface, or by a rounding below, is stopped where it goes in: by the triangle most in
/// its way, from which the walk goes on, since by a rounding a sweep can slip through where two of them meet.
fn approach(scene: &TouchScene, walk: &Walk, from: Vec3) -> Option<Footing> {
    if walk.sides == Sides::Both {
        return land(scene, walk, from, None);
    }
    let motion = walk.hip - from;
    let touch = TOUCH_LIFTS * walk.lift;
    let mut most = 0.0;
    let mut stands_on = None;
    scene.search.around(from, touch, |t| {
        let triangle = scene.surface.triangle(t);
        let inward = motion.dot(triangle.normal());
        if inward < most {
            let point = triangle.closest_point(from).point;
            if point.distance_squared(from) <= touch * touch {
                most = inward;
                stands_on = Some(walk.footing(t, point));
            }
        }
    });
    stands_on.or_else(|| land(scene, walk, from, None))
}

/// Where the motion from `from` to the HIP meets the surface.
///
/// Where both sides are felt, a HIP that comes to lie on the surface has landed too, so that a free one is always clearly on
/// one side of everything. A proxy that leaves the surface from `leaving` does not land on the other side of what it is
/// joined to there: the motion begins a little beside the proxy.
fn land(scene: &TouchScene, walk: &Walk, from: Vec3, leaving: Option<Footing>) -> Option<Footing> {
    let surface = &scene.surface;
    let mut start = from;
    for _ in 0..MAX_IN_PLACE {
        let Some(hit) = scene.search.sweep(surface, start, walk.hip, walk.sides) else {
            break;
        };
        let joint = leaving.is_some_and(|footing| {
            let corners = |t: u32| surface.triangles()[t as usize];
            let began = || surface.triangle(hit.triangle).closest_point(start).point;
            hit.inward == footing.behind
                && corners(hit.triangle)
                    .iter()
                    .any(|v| corners(footing.triangle).contains(v))
                && (hit.point.distance(footing.point) <= 4.0 * WITNESS_LIFTS * walk.lift
                    || began().distance(start) <= TOUCH_LIFTS * walk.lift)
        });
        if !joint {
            let lands = landing(scene, hit);
            return match walk.sides {
                Sides::Front => Some(lands),
                Sides::Both => {
                    let on = lying_on(scene, walk, hit.point, start).unwrap_or(lands);
                    Some(walk.on_side_of(on).clear_of_walls(on, start))
                }
            };
        }
        start = hit.point + unit_or(walk.hip - start, Vec3::ZERO) * walk.lift;
    }
    match walk.sides {
        Sides::Front => None,
        Sides::Both => lying_on(scene, walk, walk.hip, from)
            .map(|on| walk.on_side_of(on).clear_of_walls(on, from)),
    }
}

/// The triangle that a point lies on which was reached from `from`, and the side of it: of several, that of the one nearest
/// to where the point came from, and of those in line the most upright one. So an edge is not taken from the wrong side.
fn lying_on(scene: &TouchScene, walk: &Walk, at: Vec3, from: Vec3) -> Option<Footing> {
    let before = at + (from - at).clamp_length_max(WITNESS_LIFTS * walk.lift);
    let mut nearest = (f64::INFINITY, 0.0);
    let mut lies_on = None;
    scene.search.around(at, walk.lift, |t| {
        let triangle = scene.surface.triangle(t);
        let point = triangle.closest_point(at).point;
        if point.distance_squared(at) > walk.lift * walk.lift {
            return;
        }
        let apart = before - triangle.closest_point(before).point;
        let height = apart.dot(triangle.normal());
        let rank = (apart.length_squared(), -height.abs());
        if rank < nearest {
            nearest = rank;
            lies_on = Some(Footing {
                triangle: t,
                point,
                behind: height < 0.0,
            });
        }
    });
    lies_on
}

fn landing(scene: &TouchScene, hit: Hit) -> Footing {
    let triangle = scene.surface.triangle(hit.triangle);
    Footing {
        triangle: hit.triangle,
        point: triangle.closest_point(hit.point).point,
        behind: !hit.inward,
    }
}

/// Follows the HIP from a place on the surface; `None` where it ends free. Also tells whether it rests on the back.
fn follow(scene: &TouchScene, walk: Walk, start: Footing, slipping: bool) -> Option<(Rest, bool)> {
    let mut here = start;
    let mut slipping = slipping;
    let mut wall = None;
    let mut in_place = 0;
    for _ in 0..MAX_LANDINGS {
        let walk = walk.on_side_of(here);
        let outcome = walk.run(here, wall.take(), slipping);
        slipping = false;
        if let Outcome::Lifts(footing) | Outcome::SlidesOff(footing) = outcome {
            let here_still = footing.point.distance(here.point) <= 4.0 * WITNESS_LIFTS * walk.lift;
            in_place = if here_still { in_place + 1 } else { 0 };
            if in_place < MAX_IN_PLACE
                && let Some((triangle, ahead)) = against(scene, &walk, footing)
            {
                here = Footing {
                    triangle,
                    ..footing
                };
                wall = ahead;
                continue;
            }
        }
        here = match outcome {
            Outcome::Rests(rest) => return Some((rest, walk.behind)),
            Outcome::Over(footing) => footing,
            Outcome::Lifts(footing) => {
                let w = witness(scene, &walk, footing);
                land(scene, &walk, w, Some(footing))?
            }
            Outcome::SlidesOff(footing) => {
                let w = witness(scene, &walk, footing);
                let normal = walk.out(scene.surface.triangle(footing.triangle).normal());
                let down = walk.hip - footing.point;
                let ahead = unit_or(down - normal * down.dot(normal), Vec3::ZERO);
                let beyond =
                    footing.point + ahead * (WITNESS_LIFTS * walk.lift) + normal * walk.lift;
                if in_place >= MAX_IN_PLACE && against(scene, &walk, footing).is_none() {
                    // Off the corner of a jagged rim, where the way ahead leads back over the sheet: straight down, and free
                    // unless something else is there.
                    let near = 4.0 * WITNESS_LIFTS * walk.lift;
                    let below = footing.point + down.clamp_length_max(near);
                    here = land(scene, &walk, below, None)
                        .filter(|next| next.point.distance(footing.point) > near)?;
                    continue;
                }
                match scene.search.sweep(&scene.surface, w, beyond, walk.sides) {
                    Some(hit) if walk.sides == Sides::Both && in_place < MAX_IN_PLACE => {
                        wall = walk.face_on(hit.triangle, !hit.inward);
                        footing
                    }
                    Some(hit) => landing(scene, hit),
                    None => land(scene, &walk, beyond, None)?,
                }
            }
        };
    }
    let walk = walk.on_side_of(here);
    Some((walk.rest_in_plane(here), walk.behind))
}

/// Where a proxy leaving `footing` goes on although it is not joined to it: against a sheet that rises there, or over to one
/// that goes on from it.
fn against(scene: &TouchScene, walk: &Walk, footing: Footing) -> Option<(u32, Option<Face>)> {
    let Footing {
        triangle, point, ..
    } = footing;
    if !scene.search.is_crossed(triangle) {
        return None;
    }
    let find = |wall| walk.blocker([triangle; 2], point, walk.hip - point, wall);
    (find(true).map(|face| (triangle, Some(face))))
        .or_else(|| find(false).map(|face| (face.triangle, None)))
}

/// A point just above the triangle of `footing` and a little inside it: but not past another sheet.
fn witness(scene: &TouchScene, walk: &Walk, footing: Footing) -> Vec3 {
    let triangle = scene.surface.triangle(footing.triangle);
    let inward = triangle.centroid() - footing.point;
    let length = inward.length();
    let share = (WITNESS_LIFTS * walk.lift / length).min(0.5);
    let (own, out) = ([footing.triangle; 2], walk.out(triangle.normal()));
    let aside = footing.point + inward * share;
    let beside = length > 0.0
        && (!scene.search.is_crossed(footing.triangle)
            || walk.sides == Sides::Front
                && walk.sheet_between(own, footing.point, aside, out).is_none());
    let start = if beside { aside } else { footing.point };
    start + out * walk.lift
}

fn stiffness_at(scene: &TouchScene, triangle: u32, p: Vec3) -> f64 {
    if let (super::Stiffness::Uniform(k), None) = (&scene.stiffness, &scene.fading) {
        return sound_stiffness(*k);
    }
    let at = scene.surface.triangle(triangle).closest_point(p);
    scene.stiffness_at(scene.surface.triangles()[triangle as usize], at.barycentric)
}

pub(super) fn felt(scene: &TouchScene, rest: &Rest, cone: Cone, hip: Hip) -> Contact {
    let k = stiffness_at(scene, rest.triangle, rest.proxy);
    let (touch, foot_mm) = match (&scene.friction, rest.slipped) {
        (None, _) => (Touch::Frictionless, rest.proxy),
        (Some(_), true) => (Touch::Slip, rest.foot),
        (Some(_), false) => (Touch::Stick, rest.foot),
    };
    let rate_mm_s = hip.depth_rate_mm_s(rest.normal);
    let secant = (scene.choices.force).secant_n_per_mm(k, rest.depth, rate_mm_s);
    let force_n =
        rest.normal * (secant * rest.depth) + (rest.proxy - foot_mm) * (secant / cone.looseness);
    Contact {
        touch,
        triangle: rest.triangle,
        behind: false,
        anchor_mm: rest.proxy,
        foot_mm,
        normal: rest.normal,
        depth_mm: rest.depth,
        stiffness_n_per_mm: k,
        force_n,
        felt_depth_mm: rest.depth,
        credit_mj: 0.0,
    }
}

/// `plain` with its normal force replaced by that of the smooth surface.
fn shaded(
    scene: &TouchScene,
    shading: &Shading,
    rest: &Rest,
    plain: Contact,
    hip: Hip,
    before: &ContactState,
) -> Contact {
    let held = plain.touch != Touch::Frictionless;
    let smooth = shading.smooth(&scene.surface, rest, hip.position_mm, held);
    let (model, k) = (&scene.choices.force, plain.stiffness_n_per_mm);
    let rate_mm_s = hip.depth_rate_mm_s(rest.normal);
    let flat_n = rest.normal * model.force_n(k, rest.depth, rate_mm_s);
    let sideways_n = plain.force_n - flat_n;
    let push = |depth| smooth.direction * model.force_n(k, depth, rate_mm_s) + sideways_n;
    let guard = match before.touch {
        Touch::Free => Guard {
            hip_mm: before.proxy_mm,
            ..Guard::default()
        },
        _ => before.guard,
    };
    let force_n = push(smooth.depth);
    let (share, credit_mj) = guard.allow(model, k, hip.position_mm, force_n, smooth.depth);
    let felt_depth_mm = smooth.depth * share;
    Contact {
        felt_depth_mm,
        credit_mj,
        force_n: if share < 1.0 {
            push(felt_depth_mm)
        } else {
            force_n
        },
        ..plain
    }
}
