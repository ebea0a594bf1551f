//! The walk: how a proxy on the surface follows its HIP.
//!
//! The proxy goes down the distance to the HIP the steepest way there is: straight across a face towards the HIP's foot
//! on its plane, over an edge where the next face leads further down, along the edge where neither does (a valley: two
//! constraints), from a corner into the steepest face or edge, and rests where none goes down (a pit: three). Each
//! step is decided by the triangles it touches, never by a small distance, and all are taken within one tick.
//!
//! Which side the HIP is on is read off the closest of the faces, edges and corner where the proxy stands, with the
//! normal of the face, the sum at an edge, or the angle-weighted normal at a corner (Bærentzen & Aanæs 2005): this is
//! exact, also for creases and wedges, where the planes taken one by one contradict each other.
//!
//! With friction the same walk ends earlier: where the HIP's foot is within the cone.

use super::face::Face;
use super::friction::Cone;
use crate::geom::{Vec3, unit_or};
use crate::partition::Sides;
use crate::partition::bvh::Bvh;
use crate::surface::{RIM, Surface};

/// Most steps of one walk. A tick at 10 m/s over 0.1 mm triangles takes some 200; what is left waits for the next tick,
/// on the surface.
const MAX_STEPS: u32 = 4096;
/// Most steps along creases of one walk: they ask the search structure each.
const MAX_CREASES: u32 = 64;
/// How near a sheet or an edge must be for the proxy to stand on it, in lifts: a sheet stops a motion that is looked at one
/// lift above the face.
pub(super) const TOUCH_LIFTS: f64 = 4.0;
/// Anything nearer than this share of the cone's radius counts as in it: a proxy put on the cone stays there.
pub(super) const ON_CONE: f64 = 1.0 + 1e-12;

/// Where a walk ended.
#[derive(Clone, Copy, Debug)]
pub(super) enum Outcome {
    /// In contact.
    Rests(Rest),
    /// The HIP is outside the surface as seen from here.
    Lifts(Footing),
    /// The HIP is beyond a rim.
    SlidesOff(Footing),
    /// The way leads on over another sheet, on its other side.
    Over(Footing),
}

/// A proxy in contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rest {
    pub(super) triangle: u32,
    pub(super) proxy: Vec3,
    /// Outward unit normal of what carries the proxy: of the face, or from HIP to proxy at edges and corners.
    pub(super) normal: Vec3,
    /// Depth of the HIP below the plane through the proxy, mm, ≥ 0.
    pub(super) depth: f64,
    /// The HIP's foot on that plane.
    pub(super) foot: Vec3,
    pub(super) slipped: bool,
}

/// A point on the surface from which to leave it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Footing {
    pub(super) triangle: u32,
    pub(super) point: Vec3,
    /// On the back of the triangle.
    pub(super) behind: bool,
}

#[derive(Clone, Copy)]
pub(super) enum At {
    Face(Face, Vec3),
    /// On edge `.1` of a face, having come over that face.
    Edge(Face, usize, Vec3),
    Vertex(u32),
    /// Where a face is cut by another sheet, of which the proxy is on the back or not: both hold. By number, so that this
    /// rare place does not make the others large.
    Crease([u32; 2], bool, Vec3),
}

impl At {
    pub(super) fn crease(face: &Face, other: &Face, q: Vec3) -> Self {
        Self::Crease([face.triangle, other.triangle], other.behind(), q)
    }
}

/// Everything a walk needs besides where it starts.
#[derive(Clone, Copy)]
pub(super) struct Walk<'a> {
    pub(super) surface: &'a Surface,
    pub(super) search: &'a Bvh,
    pub(super) hip: Vec3,
    pub(super) cone: Cone,
    /// How far above a plane the HIP must be to have left it, mm: above the rounding of heights, so that a HIP on the
    /// surface stays in contact, with no force.
    pub(super) lift: f64,
    /// What other sheets stop a motion.
    pub(super) sides: Sides,
    /// The proxy is on the back of its triangle.
    pub(super) behind: bool,
}

impl Walk<'_> {
    /// The same walk on the side of `footing`.
    pub(super) fn on_side_of(&self, footing: Footing) -> Self {
        Self {
            behind: footing.behind,
            ..*self
        }
    }

    /// The triangle as it looks from the side that the proxy is on.
    pub(super) fn face(&self, triangle: u32) -> Option<Face> {
        self.face_on(triangle, self.behind)
    }

    /// The triangle as it looks from its back or its front.
    pub(super) fn face_on(&self, triangle: u32, behind: bool) -> Option<Face> {
        let face = Face::of(self.surface, triangle)?;
        Some(if behind {
            face.seen_from_behind()
        } else {
            face
        })
    }

    /// A normal of the surface, seen from the side that the proxy is on.
    pub(super) fn out(&self, normal: Vec3) -> Vec3 {
        if self.behind { -normal } else { normal }
    }

    pub(super) fn footing(&self, triangle: u32, point: Vec3) -> Footing {
        Footing {
            triangle,
            point,
            behind: self.behind,
        }
    }

    /// Walks from `start`, where it stands against `wall` if there is one. `slipping` says whether friction is dynamic from
    /// the start.
    pub(super) fn run(&self, start: Footing, wall: Option<Face>, slipping: bool) -> Outcome {
        let mut radius = if slipping {
            self.cone.moving
        } else {
            self.cone.starting
        };
        let mut slipped = false;
        let mut tried = Tried::default();
        let mut creases = 0;
        let Some(mut at) = self.on_face(start) else {
            return Outcome::Lifts(start);
        };
        if let (At::Face(face, p), Some(wall)) = (at, wall) {
            at = At::crease(&face, &wall, p);
        }
        let mut here = start;
        for _ in 0..MAX_STEPS {
            // By reference: a face is too large to be copied every step.
            let step = match at {
                At::Face(ref face, p) => {
                    here = self.footing(face.triangle, p);
                    self.cross_face(face, p, radius)
                }
                At::Edge(ref face, i, q) => {
                    here = self.footing(face.triangle, q);
                    self.pass_edge(face, i, q, radius)
                }
                At::Crease([one, two], behind, q) => {
                    here = self.footing(one, q);
                    creases += 1;
                    match [self.face(one), self.face_on(two, behind)] {
                        [Some(face), Some(other)] if creases <= MAX_CREASES => {
                            self.follow_crease(&face, &other, q, radius)
                        }
                        _ => break,
                    }
                }
                At::Vertex(v) => {
                    if v != tried.vertex {
                        tried = Tried {
                            vertex: v,
                            way: None,
                        };
                    }
                    here.point = self.surface.positions()[v as usize];
                    self.pass_vertex(here, &mut tried)
                }
            };
            match step {
                Step::Go(next) => at = next,
                Step::Slip(next) => {
                    at = next;
                    slipped = true;
                    radius = self.cone.moving;
                }
                Step::End(Outcome::Rests(mut rest)) => {
                    rest.slipped |= slipped;
                    return Outcome::Rests(rest);
                }
                Step::End(outcome) => return outcome,
            }
        }
        Outcome::Rests(self.rest_in_plane(here))
    }

    /// A rest at `here` however far the walk has come, on the plane of its triangle, with no more pull than friction holds.
    pub(super) fn rest_in_plane(&self, here: Footing) -> Rest {
        let (normal, height) = match self.face(here.triangle) {
            Some(face) => (face.normal, face.height(self.hip)),
            None => (unit_or(here.point - self.hip, Vec3::Z), 0.0),
        };
        let depth = (-height).max(0.0);
        let pull = self.hip - normal * height - here.point;
        let reach = self.cone.moving * depth;
        Rest {
            triangle: here.triangle,
            proxy: here.point,
            normal,
            depth,
            foot: here.point + pull.clamp_length_max(reach),
            slipped: true,
        }
    }

    /// Starts on `triangle`, or beyond it where it is too thin to have a plane.
    fn on_face(&self, start: Footing) -> Option<At> {
        let Footing {
            triangle, point: p, ..
        } = start;
        if let Some(face) = self.face(triangle) {
            return Some(At::Face(face, p));
        }
        let vertices = self.surface.triangles().get(triangle as usize)?;
        let to = vertices.map(|v| self.surface.positions()[v as usize].distance_squared(p));
        let nearest = (0..3).fold(0, |m, i| if to[i] < to[m] { i } else { m });
        Some(At::Vertex(vertices[nearest]))
    }

    fn cross_face(&self, face: &Face, p: Vec3, radius: f64) -> Step {
        let height = face.height(self.hip);
        if height > self.lift {
            return self.leave_face(face, p);
        }
        let depth = (-height).max(0.0);
        let foot = self.hip - face.normal * height;
        let reach = radius * depth;
        let pull = foot - p;
        let distance = pull.length();
        let rest = |proxy, slipped| {
            Step::End(Outcome::Rests(Rest {
                triangle: face.triangle,
                proxy,
                normal: face.normal,
                depth,
                foot,
                slipped,
            }))
        };
        if distance <= reach * ON_CONE {
            return rest(p, false);
        }
        let reach = self.cone.moving * depth;
        let share = if reach > 0.0 {
            ((distance - reach) / distance).max(0.0)
        } else {
            1.0
        };
        let mut exit: Option<(f64, usize)> = None;
        for i in 0..3 {
            let hip = face.inside(i, self.hip);
            if hip >= 0.0 {
                continue;
            }
            let start = face.inside(i, p).max(0.0);
            let end = start + (hip - start) * share;
            if end < 0.0 {
                let fraction = start / (start - end);
                if exit.is_none_or(|(first, _)| fraction < first) {
                    exit = Some((fraction, i));
                }
            }
        }
        let end = match exit {
            None if reach > 0.0 => p + pull * share,
            None => foot,
            Some((fraction, _)) => p + pull * (share * fraction),
        };
        if let Some(stop) = self.stopped(face, p, end, foot) {
            return stop;
        }
        match exit {
            None => rest(end, true),
            Some((fraction, i)) => Step::Slip(self.over_edge(face, i, end, fraction)),
        }
    }

    /// Up from `face`, unless `p` is on its border and the HIP is not over it, or behind a face that rises there: so a proxy in
    /// the bottom of however narrow a wedge stays in it.
    fn leave_face(&self, face: &Face, p: Vec3) -> Step {
        for i in 0..3 {
            if face.rate(i, p - face.corners[i]) > TOUCH_LIFTS * self.lift {
                continue;
            }
            if face.inside(i, self.hip) < 0.0 {
                return Step::Go(self.onto_edge(face, i, p));
            }
            let across = self.surface.topology().across(face.triangle)[i];
            if let Some(other) = self.face(across)
                && other.height(self.hip) <= self.lift
                && face.height(other.corners[(other.edge_from(face.vertices[(i + 1) % 3]) + 2) % 3])
                    > self.lift
            {
                return Step::Go(At::Face(other, p));
            }
        }
        Step::End(Outcome::Lifts(self.footing(face.triangle, p)))
    }

    /// The point of edge `i` nearest to `q`, or its end.
    fn onto_edge(&self, face: &Face, i: usize, q: Vec3) -> At {
        let edge = face.edges[i];
        let along = (q - face.corners[i]).dot(edge) / edge.length_squared();
        if along <= 0.0 {
            At::Vertex(face.vertices[i])
        } else if along >= 1.0 {
            At::Vertex(face.vertices[(i + 1) % 3])
        } else {
            At::Edge(*face, i, face.corners[i] + edge * along)
        }
    }

    /// [`onto_edge`](Self::onto_edge), reached after `fraction` of the way: but a proxy that stands beyond the edge, clear of
    /// another sheet on whose line the edge lies, stays clear of that.
    fn over_edge(&self, face: &Face, i: usize, end: Vec3, fraction: f64) -> At {
        let clear =
            fraction == 0.0 && self.sides == Sides::Both && self.search.is_crossed(face.triangle);
        match self.onto_edge(face, i, end) {
            At::Edge(..) if clear => At::Edge(*face, i, end),
            at => at,
        }
    }

    fn pass_edge(&self, face: &Face, i: usize, q: Vec3, radius: f64) -> Step {
        let here = self.footing(face.triangle, q);
        let across = self.surface.topology().across(face.triangle)[i];
        if across == RIM {
            return Step::End(Outcome::SlidesOff(here));
        }
        let Some(other) = self.face(across) else {
            return Step::Go(self.over_sliver(face, i, across, q));
        };
        let back = other.edge_from(face.vertices[(i + 1) % 3]);
        if other.inside(back, self.hip) > 0.0 {
            return Step::Go(match self.cover(&other, q) {
                Some(cover) if self.cover(face, q).is_none() => At::crease(face, &cover, q),
                _ => At::Face(other, q),
            });
        }
        let down = self.hip - q;
        let outward = face.normal + other.normal;
        if outward.length_squared() < 1e-18 {
            return Step::End(Outcome::SlidesOff(here));
        }
        if down.dot(outward) > self.lift {
            // From the face it came over where it can: the other may be covered by another sheet.
            let over = down.dot(face.normal);
            let higher = if over > 0.0 || over >= down.dot(other.normal) {
                face
            } else {
                &other
            };
            return Step::End(Outcome::Lifts(self.footing(higher.triangle, q)));
        }
        let direction = unit_or(face.edges[i], Vec3::ZERO);
        let along = down.dot(direction);
        let across_mm = down - direction * along;
        let depth = across_mm.length();
        let rest = |proxy: Vec3, slipped| {
            Step::End(Outcome::Rests(Rest {
                triangle: face.triangle,
                proxy,
                normal: unit_or(-across_mm, unit_or(outward, face.normal)),
                depth,
                foot: q + direction * along,
                slipped,
            }))
        };
        if along.abs() <= radius * depth * ON_CONE {
            return rest(q, false);
        }
        let way = along - (self.cone.moving * depth).min(along.abs()).copysign(along);
        let next = self.onto_edge(face, i, q + direction * way);
        let end = match next {
            At::Vertex(v) => self.surface.positions()[v as usize],
            _ => q + direction * way,
        };
        let one = face.triangle;
        if self.search.is_crossed(one) || self.search.is_crossed(across) {
            if self.blocker([one, across], q, end - q, true).is_some() {
                return self.cornered(one, q);
            }
            if let Some(hit) = self.sheet_between([one, across], q, end, outward) {
                return self.cornered(one, hit.point);
            }
        }
        match next {
            At::Edge(_, _, target) => rest(target, true),
            end => Step::Slip(end),
        }
    }

    /// From edge `i` of `face` to the far side of `sliver`, a triangle too thin to walk on: through that of its other
    /// edges that is nearer.
    fn over_sliver(&self, face: &Face, i: usize, sliver: u32, q: Vec3) -> At {
        let nearer = if (q - face.corners[i]).length_squared()
            < (q - face.corners[(i + 1) % 3]).length_squared()
        {
            i
        } else {
            (i + 1) % 3
        };
        let Some(vertices) = self.surface.triangles().get(sliver as usize) else {
            return At::Vertex(face.vertices[nearer]);
        };
        let back = vertices
            .iter()
            .position(|&v| v == face.vertices[(i + 1) % 3])
            .unwrap_or(0);
        let triangle = self.surface.triangle(sliver);
        let corners = [triangle.a, triangle.b, triangle.c];
        let off = |j: usize| {
            let (a, b) = (corners[j % 3], corners[(j + 1) % 3]);
            let t = ((q - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            let d = (a + (b - a) * t).distance_squared(q);
            if d.is_finite() { d } else { f64::MAX }
        };
        let j = if off(back + 1) <= off(back + 2) {
            (back + 1) % 3
        } else {
            (back + 2) % 3
        };
        match self.surface.topology().across(sliver)[j] {
            RIM => At::Vertex(face.vertices[nearer]),
            beyond => match self.face(beyond) {
                Some(next) => At::Face(next, q),
                None => At::Vertex(face.vertices[nearer]),
            },
        }
    }

    /// Down the steepest way from a vertex that has not been tried: one may lead straight back by a rounding.
    fn pass_vertex(&self, from: Footing, tried: &mut Tried) -> Step {
        let (v, p) = (tried.vertex, from.point);
        let down = self.hip - p;
        let topology = self.surface.topology();
        let mut best: Option<(f64, u32, At)> = None;
        let mut ways = 0;
        let mut open = false;
        let mut highest: Option<(f64, u32)> = None;
        // One that came up inside goes on there, to come out.
        let under_cover = (self.face(from.triangle)).is_some_and(|f| self.cover(&f, p).is_some());
        let mut offer = |rate: f64, at: At| {
            ways += 1;
            let fresh = (tried.way).is_none_or(|(r, way)| rate < r || rate == r && ways > way);
            if rate > self.lift && fresh && best.is_none_or(|(most, ..)| rate > most) {
                best = Some((rate, ways, at));
            }
        };
        for &t in topology.triangles_of(v) {
            let Some(face) = self.face(t) else {
                continue;
            };
            let out = face.edge_from(v);
            let back = (out + 2) % 3;
            let across = topology.across(t);
            if self.cover(&face, p).is_some() && !under_cover {
                continue;
            }
            open |= across[out] == RIM || across[back] == RIM;
            let height = down.dot(face.normal);
            if highest.is_none_or(|(most, _)| height > most) {
                highest = Some((height, t));
            }
            if face.inside(out, self.hip) > 0.0 && face.inside(back, self.hip) > 0.0 {
                offer((down - face.normal * height).length(), At::Face(face, p));
            }
            offer(
                down.dot(unit_or(face.edges[out], Vec3::ZERO)),
                At::Edge(face, out, p),
            );
            offer(
                -down.dot(unit_or(face.edges[back], Vec3::ZERO)),
                At::Edge(face, back, p),
            );
        }
        let Some((height, triangle)) = highest else {
            return Step::End(Outcome::Rests(self.rest_in_plane(from)));
        };
        let here = self.footing(triangle, p);
        if let Some((rate, way, at)) = best {
            tried.way = Some((rate, way));
            return Step::Slip(at);
        }
        let tangential = down.length_squared() - height * height;
        if open && tangential > self.lift * self.lift {
            return Step::End(Outcome::SlidesOff(here));
        }
        if !open && down.dot(self.out(self.surface.normals()[v as usize])) > self.lift {
            return Step::End(Outcome::Lifts(here));
        }
        let depth = down.length();
        Step::End(Outcome::Rests(Rest {
            triangle,
            proxy: p,
            normal: unit_or(-down, self.out(self.surface.normals()[v as usize])),
            depth,
            foot: p,
            slipped: true,
        }))
    }
}

/// The vertex last stood on, and the way down from it taken last: its rate, mm, and its place among the ways.
struct Tried {
    vertex: u32,
    way: Option<(f64, u32)>,
}

impl Default for Tried {
    fn default() -> Self {
        Self {
            vertex: RIM,
            way: None,
        }
    }
}

/// What one step of a walk leads to.
pub(super) enum Step {
    /// On to another place without having moved.
    Go(At),
    /// On to another place after a motion: friction is dynamic from here.
    Slip(At),
    End(Outcome),
}
