//! The finger pad: a sphere instead of a point. HIP and proxy are its centre, and the proxy keeps a radius away from the
//! surface.
//!
//! The triangles near the centre are replaced by half-spaces that keep the centre a radius away from them, each on its
//! own side; the place in all of them that is nearest to the HIP is where the centre goes, and from there again, until it
//! rests. A triangle grown by a ball is convex, so every such step stays clear of every triangle on its way: a pad needs
//! no sweep and cannot pass through, however far it goes in a tick. (Ruspini, Kolarov & Khatib 1997 have the sphere as
//! proxy; they stop at the first constraint hit, here all near ones are known before the step.)
//!
//! The surface is one-sided here too: what is behind a triangle does not feel it, except at a rim. A pad that comes out
//! from inside feels nothing until it is clear of the skin.

mod planes;

use super::face::Face;
use super::friction::Cone;
use super::walk::{ON_CONE, Rest};
use crate::geom::{Feature, Triangle, TrianglePoint, Vec3, unit_or};
use crate::partition::bvh::Bvh;
use crate::surface::{RIM, Surface};
use planes::{Plane, Planes};

/// Most steps of one tick; what is left waits for the next, clear of the surface.
const MAX_STEPS: u32 = 64;
/// A step shorter than this share of the radius ends the tick: the next goes on from there.
const SETTLED: f64 = 1e-5;
/// Most triangles from where the nearest one was to where it is.
const MAX_DESCENT: u32 = 256;
/// How far from touching a triangle may be that friction acts on, as a share of the radius: above what is left of a
/// settled step.
const TOUCH: f64 = 1e-7;
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
    /// `None` where it ends free.
    pub(super) fn follow(&self, from: Vec3, touching: Option<u32>, slipping: bool) -> Option<Rest> {
        let mut triangle = match touching {
            Some(t) => t,
            None => self.first_in_reach(from)?,
        };
        let mut centre = from;
        let mut cone_radius = if slipping {
            self.cone.moving
        } else {
            self.cone.starting
        };
        let mut slipped = false;
        let mut last = None;
        for _ in 0..MAX_STEPS {
            let near = self.descend(triangle, centre);
            triangle = near.triangle;
            let support = self.plane_of(&near, centre);
            let to_hip = self.hip - centre;
            let planes = self.gather(centre, support, self.span(support, to_hip, cone_radius));
            let held = planes.nearest_to(to_hip, f64::INFINITY, self.lift);
            if held.n_active == 0 {
                let distance = to_hip.length();
                if distance <= planes.span {
                    return None;
                }
                centre += to_hip * (planes.span / distance);
                continue;
            }
            // What friction holds is told by the planes in touch alone: those ahead only end the step.
            let frictionless = self.cone.moving == 0.0;
            let touch = if frictionless {
                held
            } else {
                planes.nearest_to(to_hip, TOUCH * self.radius + self.lift, self.lift)
            };
            let ground = if touch.n_active > 0 { touch } else { held };
            let first = planes.as_slice()[ground.active[0]];
            triangle = first.triangle;
            let up = ground.goal - to_hip;
            let depth = up.length();
            let rest = |centre: Vec3, slipped| Rest {
                triangle,
                proxy: centre,
                normal: unit_or(up, first.normal),
                depth,
                foot: self.hip + up,
                slipped,
            };
            let distance = ground.goal.length();
            let mut step = held.goal;
            if touch.n_active == 0 {
                step = planes.allowed(to_hip, self.lift);
            } else {
                if distance <= cone_radius * depth * ON_CONE {
                    return Some(rest(centre, slipped));
                }
                if !frictionless {
                    let way = distance - self.cone.moving * depth;
                    step = planes.allowed(touch.goal * (way / distance), self.lift);
                }
                slipped = true;
                cone_radius = self.cone.moving;
            }
            step = step.clamp_length_max(planes.span);
            centre += step;
            let here = rest(centre, slipped);
            if step.length() <= SETTLED * self.radius {
                return Some(here);
            }
            last = Some(here);
        }
        last
    }

    /// The nearest triangle that the motion from `from` could touch; `None` where there is none, or where the pad is not
    /// clear of it.
    fn first_in_reach(&self, from: Vec3) -> Option<u32> {
        let reach = self.radius + (self.hip - from).length() + self.lift;
        let near = self
            .search
            .nearest_where(self.surface, from, reach, |t, at| {
                self.faces(t, at, from - at.point)
            })?;
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

    /// How far the centre may want to go in this step, mm: no farther than to its goal as far as `support` tells, less
    /// what friction holds.
    fn span(&self, support: Option<Plane>, to_hip: Vec3, cone_radius: f64) -> f64 {
        let far = to_hip.length();
        let want = match support {
            None => far,
            Some(p) => {
                let depth = -(p.normal.dot(to_hip) + p.gap);
                if depth <= 0.0 {
                    far
                } else if p.gap > 0.0 {
                    (far * far - depth * depth).max(0.0).sqrt()
                } else {
                    let way = (to_hip + p.normal * depth).length();
                    if way <= cone_radius * depth * ON_CONE {
                        0.0
                    } else {
                        way - self.cone.moving * depth
                    }
                }
            }
        };
        let most = self.radius.max(far / 4.0);
        want.min(most) * (1.0 + 1e-9) + self.lift
    }

    /// The half-spaces of all triangles that a motion of `span` could touch.
    fn gather(&self, centre: Vec3, support: Option<Plane>, span: f64) -> Planes {
        let mut planes = Planes::new(span);
        if let Some(p) = support {
            planes.push(p);
        }
        let above = support.map(|p| (p.normal, -(p.gap + self.radius) + self.lift));
        let own = support.map(|p| p.triangle);
        self.search
            .in_ball_above(centre, self.radius + span, above, |t| {
                if Some(t) == own || self.is_under(t, centre, planes.as_slice(), own) {
                    return;
                }
                let near = Near::of(self.surface, t, centre);
                if near.distance > self.radius + planes.span {
                    return;
                }
                if let Some(plane) = self.plane_of(&near, centre) {
                    planes.push(plane);
                }
            });
        planes.drop_if(|plane, all| {
            !plane.is_face
                && Some(plane.triangle) != own
                && self.is_under(plane.triangle, centre, all, own)
        });
        planes
    }

    /// Whether one of those `planes` that stay, `own` and those of other faces, keeps the centre clear of triangle `t` too.
    fn is_under(&self, t: u32, centre: Vec3, planes: &[Plane], own: Option<u32>) -> bool {
        let Triangle { a, b, c } = self.surface.triangle(t);
        let (a, b, c) = (a - centre, b - centre, c - centre);
        planes.iter().any(|p| {
            if p.triangle == t || !(p.is_face || Some(p.triangle) == own) {
                return false;
            }
            let top = p.normal.dot(a).max(p.normal.dot(b)).max(p.normal.dot(c));
            top <= self.lift - p.gap - self.radius
        })
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
            is_face: false,
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
                is_face: true,
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
