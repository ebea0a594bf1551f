//! The finger pad: a sphere instead of a point. HIP and proxy are its centre, and the proxy keeps a radius away from the
//! surface.
//!
//! A triangle grown by a ball is convex, so a half-space keeps the centre clear of it. The centre goes to the place nearest
//! to the HIP in the half-spaces of the triangles that were in its way, asks the search structure whether another one is,
//! and so on until none is; then from there again, until it rests. No step is as long as the radius, or as the room there
//! is: a pad needs no sweep and cannot pass through, however far it goes in a tick. (Ruspini, Kolarov & Khatib 1997 have
//! the sphere as proxy, too; they stop at each constraint that a sweep hits.)
//!
//! The surface is one-sided here too: what is behind a triangle does not feel it, except at a rim. A pad that comes out
//! from inside feels nothing until it is clear of the skin.

mod planes;

use super::face::Face;
use super::friction::Cone;
use super::walk::{ON_CONE, Rest};
use crate::geom::{Feature, TrianglePoint, Vec3, unit_or};
use crate::partition::{Nearest, bvh::Bvh};
use crate::surface::{RIM, Surface};
use planes::{Held, Plane, Planes};

/// Most steps of one tick; what is left waits for the next, clear of the surface.
const MAX_STEPS: u32 = 128;
/// Most times a step is cut back when the triangles in its way are too many to stand together.
const MAX_CUTS: u32 = 4;
/// A step shorter than this share of the radius is left to the next tick, unless it is the first.
const SETTLED: f64 = 1e-3;
/// Most triangles from where the nearest one was to where it is.
const MAX_DESCENT: u32 = 256;
/// How far from touching a triangle may be that friction acts on, as a share of the radius: what is left of a settled step
/// towards it, and then some.
const TOUCH: f64 = 2.0 * SETTLED;
/// How much nearer than a radius a triangle may be to a pad that is clear of it, as a share of the radius: above the
/// rounding of a rest.
const CLEAR: f64 = 1e-9;

/// Everything a pad needs besides where it starts.
pub(super) struct Pad<'a> {
    pub(super) surface: &'a Surface,
    pub(super) search: &'a Bvh,
    pub(super) hip: Vec3,
    pub(super) cone: Cone,
    pub(super) radius: f64,
    /// Rounding of heights, mm.
    pub(super) lift: f64,
}

impl Pad<'_> {
    /// Follows the HIP from a centre clear of the surface. `touching` is the triangle that a pad in contact is on.
    /// `cone_at` tells the cone for a start on a triangle. `None` where it ends free.
    pub(super) fn follow(
        &self,
        from: Vec3,
        touching: Option<u32>,
        slipping: bool,
        cone_at: impl Fn(u32, Vec3) -> Cone,
    ) -> Option<Rest> {
        let triangle = match touching {
            Some(t) => t,
            None => self.first_in_reach(from)?,
        };
        let pad = Self {
            cone: cone_at(triangle, from),
            ..*self
        };
        pad.follow_on(triangle, from, slipping)
    }

    fn follow_on(&self, mut triangle: u32, from: Vec3, slipping: bool) -> Option<Rest> {
        let mut centre = from;
        let mut cone_radius = if slipping {
            self.cone.moving
        } else {
            self.cone.starting
        };
        let mut slipped = false;
        let mut last = self.waiting(triangle, from);
        for n in 0..MAX_STEPS {
            let mut near = self.descend(triangle, centre);
            // Shorter than a radius no step passes a triangle that it does not end at.
            let mut most = self.radius / 2.0;
            if near.distance > 1.5 * self.radius {
                let t = self.nearest_in_reach(centre)?.triangle;
                near = Near::of(self.surface, t, centre);
                most += near.distance - self.radius;
            }
            triangle = near.triangle;
            let mut planes = Planes::new();
            if let Some(plane) = self.plane_of(&near, centre) {
                planes.push(plane);
            }
            let (aim, step) = loop {
                let aim = self.aim(&planes, centre, cone_radius);
                let step = aim.step.clamp_length_max(most);
                let settled = n > 0 && step.length() <= SETTLED * self.radius;
                if let Some(ground) = aim.ground.as_ref().filter(|_| aim.rests || settled) {
                    return Some(ground.rest(centre, slipped, self.cone));
                }
                let Some(t) = self.in_the_way(centre + step) else {
                    break (aim, step);
                };
                match self.plane_of(&Near::of(self.surface, t, centre), centre) {
                    Some(plane) if planes.has(t) || !planes.push(plane) => {
                        break (aim, self.cut(centre, step));
                    }
                    Some(_) => {}
                    None => break (aim, step),
                }
            };
            let Some(ground) = aim.ground else {
                if step == aim.step {
                    return None;
                }
                centre += step;
                last = self.waiting(triangle, centre);
                continue;
            };
            if aim.slides {
                slipped = true;
                cone_radius = self.cone.moving;
            }
            centre += step;
            triangle = ground.plane.triangle;
            last = ground.rest(centre, slipped, self.cone);
            if step.length() <= self.lift {
                break;
            }
        }
        Some(last)
    }

    /// Where the half-spaces and friction let the centre go.
    fn aim(&self, planes: &Planes, centre: Vec3, cone_radius: f64) -> Aim {
        let to_hip = self.hip - centre;
        let held = planes.nearest_to(to_hip, f64::INFINITY, self.lift);
        if held.n_active == 0 {
            return Aim {
                step: to_hip,
                slides: false,
                rests: false,
                ground: None,
            };
        }
        let ground = |held: Held| {
            let up = held.goal - to_hip;
            Ground {
                plane: planes.as_slice()[held.active[0]],
                foot: self.hip + up,
                up,
            }
        };
        let mut aim = Aim {
            step: held.goal,
            slides: true,
            rests: false,
            ground: Some(ground(held)),
        };
        if self.cone.moving == 0.0 {
            return aim;
        }
        // What friction holds is told by the planes in touch; a centre above them all falls straight for the HIP.
        let touch = planes.nearest_to(to_hip, TOUCH * self.radius + self.lift, self.lift);
        if touch.n_active == 0 {
            aim.step = planes.allowed(to_hip, self.lift);
            aim.slides = false;
            return aim;
        }
        let here = ground(touch);
        let (distance, depth) = (touch.goal.length(), here.up.length());
        aim.ground = Some(here);
        aim.rests = distance <= cone_radius * depth * ON_CONE;
        if !aim.rests {
            let target = touch.goal * ((distance - self.cone.moving * depth) / distance);
            aim.step = planes.nearest_to(target, f64::INFINITY, self.lift).goal;
        }
        aim
    }

    /// A rest without a force, for a pad that has not come where it goes within a tick.
    fn waiting(&self, triangle: u32, centre: Vec3) -> Rest {
        Rest {
            triangle,
            proxy: centre,
            normal: unit_or(centre - self.hip, Vec3::Z),
            depth: 0.0,
            foot: centre,
            slipped: true,
        }
    }

    /// A shorter step the same way that is clear of every triangle; none where there is none.
    fn cut(&self, centre: Vec3, step: Vec3) -> Vec3 {
        let mut step = step;
        for _ in 0..MAX_CUTS {
            step *= 0.25;
            if self.in_the_way(centre + step).is_none() {
                return step;
            }
        }
        Vec3::ZERO
    }

    /// The triangle that a pad at `centre` would be deepest in.
    fn in_the_way(&self, centre: Vec3) -> Option<u32> {
        let clear = self.radius * (1.0 - 0.1 * CLEAR) - self.lift;
        self.nearest_within(centre, clear).map(|near| near.triangle)
    }

    fn nearest_in_reach(&self, from: Vec3) -> Option<Nearest> {
        let reach = self.radius + (self.hip - from).length() + self.lift;
        self.nearest_within(from, reach)
    }

    fn nearest_within(&self, centre: Vec3, reach: f64) -> Option<Nearest> {
        self.search
            .nearest_where(self.surface, centre, reach, |t, at| {
                self.faces(t, at, centre - at.point)
            })
    }

    /// The nearest triangle that the motion from `from` could touch; `None` where there is none, or where the pad is not
    /// clear of it.
    fn first_in_reach(&self, from: Vec3) -> Option<u32> {
        let near = self.nearest_in_reach(from)?;
        let clear = self.radius * (1.0 - CLEAR) - self.lift;
        (near.distance_sq >= clear * clear).then_some(near.triangle)
    }

    /// From `triangle` over its neighbours to the one that is nearest to `centre` thereabouts.
    fn descend(&self, triangle: u32, centre: Vec3) -> Near {
        let mut here = Near::of(self.surface, triangle, centre);
        for _ in 0..MAX_DESCENT {
            let topology = self.surface.topology();
            let mut next: Option<Near> = None;
            let mut offer = |t: u32| {
                let near = Near::of(self.surface, t, centre);
                let least = next.as_ref().map_or(here.distance, |n| n.distance);
                if near.distance < least {
                    next = Some(near);
                }
            };
            match here.at.feature {
                Feature::Face => return here,
                Feature::Edge(i) => {
                    let across = topology.across(here.triangle)[i as usize];
                    if across != RIM {
                        offer(across);
                    }
                }
                Feature::Vertex(i) => {
                    let v = self.surface.triangles()[here.triangle as usize][i as usize];
                    topology.triangles_of(v).iter().for_each(|&t| offer(t));
                }
            }
            match next {
                Some(near) => here = near,
                None => return here,
            }
        }
        here
    }

    /// The half-space that keeps the centre clear of one triangle; `None` where it is behind it.
    ///
    /// The triangle's own plane where the centre is a radius above it, since neighbours in one plane must not stop a
    /// motion along it; else, or where that would stop a centre that has room, the plane through its closest point.
    fn plane_of(&self, near: &Near, centre: Vec3) -> Option<Plane> {
        let out = centre - near.at.point;
        if !self.faces(near.triangle, &near.at, out) {
            return None;
        }
        let slack = near.distance - self.radius;
        let leaning = Plane {
            normal: out / near.distance,
            gap: slack,
            slack,
            triangle: near.triangle,
        };
        let Some(face) = Face::of(self.surface, near.triangle) else {
            return leaning.normal.is_finite().then_some(leaning);
        };
        let gap = face.height(centre) - self.radius;
        let inside = near.at.feature == Feature::Face;
        if inside || (gap >= -self.lift && gap >= slack / 2.0) {
            return Some(Plane {
                normal: face.normal,
                gap,
                ..leaning
            });
        }
        leaning.normal.is_finite().then_some(leaning)
    }

    /// Whether a centre that is `out` away from its closest point on `t` is on the outer side there: told by the normal
    /// of the face, the sum at an edge, the angle-weighted one at a corner (Bærentzen & Aanæs 2005). A rim is felt from
    /// all around.
    fn faces(&self, t: u32, at: &TrianglePoint, out: Vec3) -> bool {
        let normal = |t: u32| Face::of(self.surface, t).map_or(Vec3::ZERO, |face| face.normal);
        let vertices = self.surface.triangles()[t as usize];
        match at.feature {
            Feature::Face => match Face::of(self.surface, t) {
                Some(face) => out.dot(face.normal) > 0.0,
                None => out.dot(self.surface.normals()[vertices[0] as usize]) > 0.0,
            },
            Feature::Edge(i) => {
                let across = self.surface.topology().across(t)[i as usize];
                across == RIM || out.dot(normal(t) + normal(across)) > 0.0
            }
            Feature::Vertex(i) => {
                let v = vertices[i as usize];
                self.is_on_rim(v) || out.dot(self.surface.normals()[v as usize]) > 0.0
            }
        }
    }

    fn is_on_rim(&self, v: u32) -> bool {
        let topology = self.surface.topology();
        topology.triangles_of(v).iter().any(|&t| {
            let across = topology.across(t);
            let corners = self.surface.triangles()[t as usize];
            (0..3).any(|i| across[i] == RIM && (corners[i] == v || corners[(i + 1) % 3] == v))
        })
    }
}

/// Where a step leads.
struct Aim {
    /// Seen from the centre, mm.
    step: Vec3,
    /// It is a motion in touch: friction is dynamic from here.
    slides: bool,
    /// Friction holds the pad where it is.
    rests: bool,
    /// What carries the pad; nothing where it is free.
    ground: Option<Ground>,
}

/// What carries the pad.
struct Ground {
    plane: Plane,
    /// The HIP's foot on it, mm.
    foot: Vec3,
    /// From the HIP to its foot, mm.
    up: Vec3,
}

impl Ground {
    /// At rest at `centre`, with no more pull than friction holds.
    fn rest(&self, centre: Vec3, slipped: bool, cone: Cone) -> Rest {
        let depth = self.up.length();
        let most = cone.starting * depth;
        Rest {
            triangle: self.plane.triangle,
            proxy: centre,
            normal: unit_or(self.up, self.plane.normal),
            depth,
            foot: centre + (self.foot - centre).clamp_length_max(most),
            slipped,
        }
    }
}

/// A triangle and its point closest to the centre.
struct Near {
    triangle: u32,
    at: TrianglePoint,
    distance: f64,
}

impl Near {
    fn of(surface: &Surface, triangle: u32, centre: Vec3) -> Self {
        let at = surface.triangle(triangle).closest_point(centre);
        Self {
            triangle,
            at,
            distance: at.point.distance(centre),
        }
    }
}
