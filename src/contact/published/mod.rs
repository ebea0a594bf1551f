//! The haptic pass as published (Ji 2008, 3.3.3 and 3.4.1): gather the triangles that a structure finds for the haptic
//! detecting box about the proxy, collide the motion with those and no others, make a force of the depth.
//!
//! What happens with the triangles once they were drawn was the business of a haptic library and is not in print. Here it
//! is the god object that such libraries were made of (Zilles & Salisbury 1995), as METHOD reads it: the proxy stays on
//! the static surface, and without friction on the normal through the HIP.
//!
//! Faults that belong to it, and that the production engine does not have:
//! - The box stands about the proxy as the last tick left it. A motion that leaves the box meets nothing out there: a
//!   fast finger punctures the surface if the box is small. (In print the box lags behind by a frame of the whole system;
//!   [`gather`] about an older proxy and [`collide`] repeat that.)
//! - Where a structure's published query misses a triangle that juts out of its leaf, so does the finger.
//! - Every pass asks every triangle gathered: it costs what they are.
//! - Hard corners, slots and walls with friction can still let the proxy through (`dorsum lab contact-torture` measures what
//!   an engine does there); a skin has none.

mod options;

use super::friction::Cone;
use super::proxy::{self, FARTHEST_MM, LIFT_ULPS, WITNESS_LIFTS};
use super::walk::{ON_CONE, Rest};
use super::{Contact, ContactState, Hip, Touch, TouchScene};
use crate::geom::{Aabb, Triangle, Vec3, unit_or};
use crate::partition::Hit;
use crate::partition::hdb::Gathered;
use crate::surface::Surface;
use std::cell::Cell;

pub use options::{KINDS, Options, Published};

/// How far above the triangles that it stands on a motion begins, in lifts.
const ABOVE_LIFTS: f64 = 8.0;
/// Most candidates near a motion that are kept.
const MOST_NEAR: usize = 256;
/// Most planes that hold a proxy, and one that it runs into.
const MOST_PLANES: usize = 4;
/// Most walls about one place that are looked at.
const MOST_WALLS: usize = 12;
/// Most times that a motion is turned aside by a triangle before it stops there.
const MOST_TURNS: usize = 64;
/// Most times that the proxy is dropped on another triangle in one pass.
const MOST_DROPS: usize = 32;

/// Triangles that a pass collides with.
pub trait Candidates {
    /// Names each, in any order; naming one twice does no harm.
    fn each(&self, name: impl FnMut(u32));
}

impl Candidates for [u32] {
    fn each(&self, name: impl FnMut(u32)) {
        self.iter().copied().for_each(name);
    }
}

/// The leaves that the box meets, asked anew each time, so that no list of all need be kept.
struct InBox<'a> {
    published: &'a Published,
    surface: &'a Surface,
    region: Aabb,
    counts: Cell<PassCounts>,
}

impl Candidates for InBox<'_> {
    fn each(&self, name: impl FnMut(u32)) {
        let gathered = self.published.each(self.surface, &self.region, name);
        let before = self.counts.get();
        self.counts.set(PassCounts {
            gathered,
            sweeps: before.sweeps + 1,
        });
    }
}

/// The candidates that a motion can meet, kept so that most questions ask only those; all of them where they are many.
struct Near<'a, C: ?Sized> {
    all: &'a C,
    kept: [u32; MOST_NEAR],
    len: usize,
}

impl<'a, C: Candidates + ?Sized> Near<'a, C> {
    fn of(all: &'a C, surface: &Surface, region: &Aabb) -> Self {
        let (mut kept, mut len) = ([0; MOST_NEAR], 0);
        all.each(|t| {
            if surface.triangle(t).aabb().overlaps(region) {
                if let Some(slot) = kept.get_mut(len) {
                    *slot = t;
                }
                len += 1;
            }
        });
        Self { all, kept, len }
    }
}

impl<C: Candidates + ?Sized> Candidates for Near<'_, C> {
    fn each(&self, name: impl FnMut(u32)) {
        match self.kept.get(..self.len) {
            Some(kept) => kept.each(name),
            None => self.all.each(name),
        }
    }
}

/// What one pass cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct PassCounts {
    /// What the structure gathered; triangles as often as leaves list them.
    pub gathered: Gathered,
    /// How often all of them were asked.
    pub sweeps: u32,
}

/// Where a pass leaves the finger on the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stand {
    /// The triangle under the proxy.
    pub triangle: u32,
    /// The proxy P, mm: on the normal through the HIP.
    pub foot_mm: Vec3,
    /// Where friction holds the skin, A, mm; P without friction.
    pub anchor_mm: Vec3,
    /// Outward unit normal at P.
    pub normal: Vec3,
    /// Distance of the HIP from P, mm.
    pub depth_mm: f64,
    /// Whether A was dragged along.
    pub slipped: bool,
}

/// One pass: gathers, collides, and makes the force. A function of its arguments; allocates nothing.
pub(super) fn advance(
    scene: &TouchScene,
    published: &Published,
    state: &mut ContactState,
    hip: Hip,
) -> Contact {
    pass(scene, published, state, hip).0
}

/// As [`advance`](super::advance) with this engine, whatever the scene's own is; tells what it cost.
pub fn pass(
    scene: &TouchScene,
    published: &Published,
    state: &mut ContactState,
    hip: Hip,
) -> (Contact, PassCounts) {
    if !believable(hip.position_mm) {
        let on_surface = stands(scene, state);
        let idle = proxy::waiting(scene, state, on_surface);
        return (idle, PassCounts::default());
    }
    let candidates = InBox {
        published,
        surface: &scene.surface,
        region: published.region(state.proxy_mm),
        counts: Cell::default(),
    };
    let stand = collide(scene, &candidates, state, hip.position_mm);
    let contact = force(scene, stand.as_ref(), hip);
    *state = ContactState::after(hip.position_mm, &contact);
    (contact, candidates.counts.get())
}

/// First part of a pass: appends the triangles that the structure finds for the box about `proxy_mm`, in rising order.
pub fn gather(
    scene: &TouchScene,
    published: &Published,
    proxy_mm: Vec3,
    out: &mut Vec<u32>,
) -> Gathered {
    published.gather(&scene.surface, &published.region(proxy_mm), out)
}

/// Third part of a pass: what the finger feels, by the scene's force model and friction. `None` is a free finger.
pub fn force(scene: &TouchScene, stand: Option<&Stand>, hip: Hip) -> Contact {
    let Some(stand) = stand else {
        return Contact {
            anchor_mm: hip.position_mm,
            foot_mm: hip.position_mm,
            ..Contact::default()
        };
    };
    let pull = stand.anchor_mm - stand.foot_mm;
    let rest = Rest {
        triangle: stand.triangle,
        // The pull lies in the tangent plane, also where the anchor had to be put on a wall above it.
        proxy: stand.foot_mm + (pull - stand.normal * pull.dot(stand.normal)),
        normal: stand.normal,
        depth: stand.depth_mm,
        foot: stand.foot_mm,
        slipped: stand.slipped,
    };
    Contact {
        anchor_mm: stand.anchor_mm,
        ..proxy::felt(scene, &rest, Cone::of(scene.friction.as_ref()), hip)
    }
}

/// Second part of a pass: the motion from the proxy of `state` to the HIP against `candidates` alone. `None` where the
/// finger ends free, also where it should not.
pub fn collide<C: Candidates + ?Sized>(
    scene: &TouchScene,
    candidates: &C,
    state: &ContactState,
    hip_mm: Vec3,
) -> Option<Stand> {
    if !believable(hip_mm) {
        return None;
    }
    let from = state.proxy_mm;
    let lift = LIFT_ULPS * f64::EPSILON * (hip_mm.abs().max_element() + from.abs().max_element());
    // The proxy only comes nearer to the HIP; twice as far, for what is looked at from above.
    let reach = 4.0 * (from.distance(hip_mm) + WITNESS_LIFTS * lift);
    let near = Near::of(candidates, &scene.surface, &Aabb::cube(hip_mm, reach));
    let pass = Pass {
        surface: &scene.surface,
        candidates: &near,
        hip: hip_mm,
        lift,
    };
    let held = stands(scene, state).then(|| scene.surface.triangle(state.triangle).normal());
    let start = match held {
        Some(normal) => pass.above(from, normal),
        None => from + unit_or(from - hip_mm, Vec3::ZERO) * (WITNESS_LIFTS * lift),
    };
    let landed = pass.first(start, hip_mm)?;
    let (foot, triangle) = pass.settle(landed)?;
    let cone = match held {
        Some(_) => Cone::at(scene, state.triangle, from),
        None => Cone::at(scene, landed.triangle, landed.point),
    };
    let anchor = match (held, &scene.friction) {
        (_, None) => foot.point,
        (Some(_), Some(_)) => from,
        (None, Some(_)) => landed.point,
    };
    Some(pass.hold(foot, triangle, anchor, cone, state.touch == Touch::Slip))
}

fn believable(hip_mm: Vec3) -> bool {
    hip_mm.is_finite() && hip_mm.abs().max_element() <= FARTHEST_MM
}

/// Whether the state says that the finger is on this surface.
fn stands(scene: &TouchScene, state: &ContactState) -> bool {
    state.touch != Touch::Free
        && (state.triangle as usize) < scene.surface.triangles().len()
        && state.proxy_mm.is_finite()
}

/// A triangle taken for its whole plane.
#[derive(Clone, Copy, Default)]
struct Plane {
    triangle: u32,
    point: Vec3,
    normal: Vec3,
}

impl Plane {
    fn height(&self, p: Vec3) -> f64 {
        (p - self.point).dot(self.normal)
    }
}

/// The planes that hold a proxy, at most [`MOST_PLANES`].
#[derive(Clone, Copy, Default)]
struct Planes {
    all: [Plane; MOST_PLANES],
    len: usize,
}

impl Planes {
    fn list(&self) -> &[Plane] {
        &self.all[..self.len]
    }

    fn push(&mut self, plane: Plane) {
        if let Some(slot) = self.all.get_mut(self.len) {
            *slot = plane;
            self.len += 1;
        }
    }
}

/// The place nearest to the HIP that planes allow.
#[derive(Clone, Copy)]
struct Foot {
    point: Vec3,
    normal: Vec3,
    depth_mm: f64,
}

struct Pass<'a, C: ?Sized> {
    surface: &'a Surface,
    candidates: &'a C,
    hip: Vec3,
    /// Rounding of heights, mm, as in the production engine.
    lift: f64,
}

impl<C: Candidates + ?Sized> Pass<'_, C> {
    /// The first candidate that a motion enters from outside; of several at one place the lowest number.
    fn first(&self, from: Vec3, to: Vec3) -> Option<Hit> {
        let along = to - from;
        let near = Aabb::of_points([from, to]).grown(self.lift);
        let mut best: Option<Hit> = None;
        self.candidates.each(|triangle| {
            let shape = self.surface.triangle(triangle);
            if !shape.aabb().overlaps(&near) {
                return;
            }
            let Some(c) = shape.crossing(from, to).filter(|c| c.inward) else {
                return;
            };
            if best.is_none_or(|b| c.t < b.t || (c.t == b.t && triangle < b.triangle)) {
                best = Some(Hit {
                    triangle,
                    t: c.t,
                    point: from + along * c.t,
                    inward: true,
                });
            }
        });
        best
    }

    /// A place on the surface moved just above every triangle there, as little as can be: in a corner along none of its
    /// walls. Where nothing is, or what is there faces both ways, along `normal`.
    fn above(&self, p: Vec3, normal: Vec3) -> Vec3 {
        let rise = ABOVE_LIFTS * self.lift;
        let touching_mm = WITNESS_LIFTS * self.lift;
        let around = Aabb::cube(p, 2.0 * touching_mm);
        let (mut at, mut planes) = (p, Planes::default());
        for _ in 0..MOST_WALLS {
            let mut worst: Option<(f64, Plane)> = None;
            self.candidates.each(|triangle| {
                let shape = self.surface.triangle(triangle);
                if !shape.aabb().overlaps(&around) {
                    return;
                }
                let mut plane = self.plane(triangle);
                plane.point += plane.normal * rise;
                let height = plane.height(at);
                let more =
                    |(h, w): (f64, Plane)| height < h || (height == h && triangle < w.triangle);
                if height < -0.125 * rise
                    && worst.is_none_or(more)
                    && shape.closest_point(p).point.distance(p) <= touching_mm
                {
                    worst = Some((height, plane));
                }
            });
            let Some((_, plane)) = worst else {
                return if planes.len > 0 {
                    at
                } else {
                    p + normal * rise
                };
            };
            planes.push(plane);
            let Some((foot, held)) = self.lowest(p, &planes, 0.0625 * rise) else {
                break;
            };
            (at, planes) = (foot.point, held);
        }
        p + normal * rise
    }

    fn plane(&self, triangle: u32) -> Plane {
        let shape = self.surface.triangle(triangle);
        Plane {
            triangle,
            point: shape.a,
            normal: shape.normal(),
        }
    }

    /// From where the motion landed to where the proxy rests, with the triangle under it. `None` where nothing is under
    /// it any more.
    fn settle(&self, landed: Hit) -> Option<(Foot, u32)> {
        let mut visited = [landed.triangle; MOST_DROPS];
        let mut here = landed;
        for n in 0..MOST_DROPS {
            let (foot, planes) = self.slide(here)?;
            // The planes are endless, their triangles not: what is really under the foot?
            let under = self.first(self.above(foot.point, foot.normal), self.hip)?;
            let there = self.surface.triangle(under.triangle);
            let stays = planes.list().iter().any(|p| p.triangle == under.triangle)
                || there.closest_point(foot.point).point.distance(foot.point)
                    <= WITNESS_LIFTS * self.lift;
            if stays {
                return Some((self.on_surface(foot, &there), under.triangle));
            }
            if visited[..=n].contains(&under.triangle) {
                return Some(self.nearest_of(&visited[..=n]));
            }
            if let Some(next) = visited.get_mut(n + 1) {
                *next = under.triangle;
            }
            here = under;
        }
        Some(self.nearest_of(&visited))
    }

    /// A foot that came to lie a little below another facet than those that hold it, put on that.
    fn on_surface(&self, foot: Foot, under: &Triangle) -> Foot {
        if (foot.point - under.a).dot(under.normal()) >= -self.lift {
            return foot;
        }
        let point = under.closest_point(foot.point).point;
        Foot {
            point,
            depth_mm: (point - self.hip).dot(foot.normal).max(0.0),
            ..foot
        }
    }

    /// Slides from a landing towards the HIP, as far as the planes met on the way let it: Zilles and Salisbury's god
    /// object. `None` where they turn out not to be in the way at all.
    fn slide(&self, landed: Hit) -> Option<(Foot, Planes)> {
        let mut at = landed.point;
        let mut planes = Planes::default();
        planes.push(self.plane(landed.triangle));
        for _ in 0..MOST_TURNS {
            let slack = 2.0 * WITNESS_LIFTS * self.lift;
            let (foot, active) = self.lowest(self.hip, &planes, slack)?;
            let raised = |p| self.above(p, foot.normal);
            let Some(hit) = self.first(raised(at), raised(foot.point)) else {
                return Some((foot, active));
            };
            if active.list().iter().any(|p| p.triangle == hit.triangle) {
                return Some((foot, active));
            }
            let wall = self.surface.triangle(hit.triangle);
            at = wall.closest_point(hit.point).point;
            planes = active;
            planes.push(self.plane(hit.triangle));
        }
        // Stopped on the way: held by the last plane, with no more pull than straight up.
        let last = planes.list().last()?;
        let foot = Foot {
            point: at,
            normal: last.normal,
            depth_mm: (-last.height(self.hip)).max(0.0),
        };
        Some((foot, planes))
    }

    /// The point nearest to `goal` that is below none of the planes by more than `slack`, mm, and those that hold it
    /// there: the least number of planes that does. `None` where the goal is above all.
    fn lowest(&self, goal: Vec3, planes: &Planes, slack: f64) -> Option<(Foot, Planes)> {
        let all = planes.list();
        let mut best: Option<(f64, Foot, Planes)> = None;
        // Every choice of at most three, by bits; smaller choices first.
        for size in 1..=3_u32 {
            for choice in 1_usize..1 << all.len() {
                if choice.count_ones() != size {
                    continue;
                }
                let mut held = Planes::default();
                let chosen = all.iter().enumerate().filter(|(i, _)| choice >> i & 1 == 1);
                chosen.for_each(|(_, p)| held.push(*p));
                let Some(foot) = foot_on(goal, held.list()) else {
                    continue;
                };
                let lowest = all.iter().map(|p| p.height(foot.point));
                let below = lowest.fold(0.0, |worst: f64, h| worst.max(-h));
                if best.is_none_or(|(least, _, _)| below < least) {
                    best = Some((below, foot, held));
                }
            }
            if let Some((below, foot, held)) = best
                && below <= slack
            {
                return Some((foot, held));
            }
        }
        best.map(|(_, foot, held)| (foot, held))
    }

    /// The point nearest to the HIP on any of these triangles: where the proxy comes to rest that their planes hand on to
    /// each other, on the edge or corner they share.
    fn nearest_of(&self, triangles: &[u32]) -> (Foot, u32) {
        let mut best = (f64::INFINITY, Vec3::ZERO, 0);
        for &t in triangles {
            let p = self.surface.triangle(t).closest_point(self.hip).point;
            let distance = p.distance(self.hip);
            if distance < best.0 || (distance == best.0 && t < best.2) {
                best = (distance, p, t);
            }
        }
        let (depth_mm, point, triangle) = best;
        let foot = Foot {
            point,
            normal: unit_or(point - self.hip, self.surface.triangle(triangle).normal()),
            depth_mm,
        };
        (foot, triangle)
    }

    /// Friction: the anchor stays where it was if the cone at the foot holds it, else it is dragged along.
    fn hold(&self, foot: Foot, triangle: u32, anchor: Vec3, cone: Cone, slipping: bool) -> Stand {
        let offset = anchor - foot.point;
        let pull = offset - foot.normal * offset.dot(foot.normal);
        let distance = pull.length();
        let radius = if slipping { cone.moving } else { cone.starting };
        let slipped = distance > radius * foot.depth_mm * ON_CONE;
        let reach = if slipped {
            pull * (cone.moving * foot.depth_mm / distance)
        } else {
            pull
        };
        let anchor = foot.point + reach;
        let up = foot.normal;
        let raised = |p| self.above(p, up);
        let blocked = (reach != Vec3::ZERO)
            .then(|| self.first(raised(foot.point), raised(anchor)))
            .flatten();
        // The tangent plane cuts below a hollow surface: there the anchor goes over the wall, or stops at one too steep.
        let anchor = if blocked.is_some() {
            let high = anchor + up * reach.length();
            let onto = |hit: Hit| {
                let shape = self.surface.triangle(hit.triangle);
                shape.closest_point(hit.point).point
            };
            self.first(raised(foot.point), high)
                .or_else(|| self.first(high, anchor - up * self.lift))
                .map_or(anchor, onto)
        } else {
            anchor
        };
        Stand {
            triangle,
            foot_mm: foot.point,
            anchor_mm: anchor,
            normal: foot.normal,
            depth_mm: foot.depth_mm,
            slipped,
        }
    }
}

/// How far to go along each of the first `n` normals to rise by these depths above each of their planes; `None` where
/// the planes are parallel.
fn shares(normals: [Vec3; 3], n: usize, depths: [f64; 3]) -> Option<[f64; 3]> {
    let ([a, b, c], [p, q, r]) = (normals, depths);
    match n {
        1 => Some([p, 0.0, 0.0]),
        2 => {
            let cos = a.dot(b);
            let sin_sq = a.cross(b).length_squared();
            (sin_sq > 1e-14).then(|| [(p - cos * q) / sin_sq, (q - cos * p) / sin_sq, 0.0])
        }
        _ => {
            let det = a.dot(b.cross(c));
            let to = (b.cross(c) * p + c.cross(a) * q + a.cross(b) * r) / det;
            let share = |u: Vec3, v: Vec3| to.dot(u.cross(v)) / det;
            (det.abs() > 1e-10).then(|| [share(b, c), share(c, a), share(a, b)])
        }
    }
}

/// The point nearest to `goal` on all of these planes at once; `None` where one of them would have to pull, or where
/// they are parallel.
fn foot_on(goal: Vec3, planes: &[Plane]) -> Option<Foot> {
    let normals: [Vec3; 3] =
        std::array::from_fn(|i| planes.get(i).map_or(Vec3::ZERO, |p| p.normal));
    let depths = |at: Vec3| std::array::from_fn(|i| planes.get(i).map_or(0.0, |p| -p.height(at)));
    let shares = shares(normals, planes.len(), depths(goal))?;
    if !shares.iter().all(|&s| s >= 0.0) {
        return None;
    }
    let step =
        |shares: [f64; 3]| normals[0] * shares[0] + normals[1] * shares[1] + normals[2] * shares[2];
    let mut point = goal + step(shares);
    if let [plane] = planes {
        return Some(Foot {
            point,
            normal: plane.normal,
            depth_mm: shares[0],
        });
    }
    // Planes that are nearly parallel magnify rounding: once more, from there.
    point += step(self::shares(normals, planes.len(), depths(point))?);
    let push = point - goal;
    push.is_finite().then(|| Foot {
        point,
        normal: unit_or(push, planes[0].normal),
        depth_mm: push.length(),
    })
}
