//! Where another sheet of the surface crosses or touches the one that the proxy walks on: bodies that run into each other,
//! a wall that stands on a plate, a fold.
//!
//! Adjacency does not know of such places. The search structure marks the triangles that have one
//! ([`Bvh::is_crossed`](crate::partition::bvh::Bvh::is_crossed)); on the others nothing here is asked.

use super::face::Face;
use super::proxy::WITNESS_LIFTS;
use super::walk::{At, Footing, ON_CONE, Outcome, Rest, Step, TOUCH_LIFTS, Walk};
use crate::geom::{Vec3, unit_or};
use crate::partition::{Hit, Partition, Sides};
use crate::surface::RIM;

/// How near the corner that two triangles share a motion just above one must meet the other for that to be the joint itself,
/// in lifts: with angles of 1/1024 between them.
const JOINT_LIFTS: f64 = 1024.0;
/// How far from a second sheet a proxy stops that is stopped by both sides, in lifts: out of reach of a motion one lift above
/// the first.
const SHORT_LIFTS: f64 = 8.0;
/// Planes whose unit normals add up to less, squared and halved, are one plane seen from both sides.
const PARALLEL: f64 = 1e-12;
/// Sine of the angle between a line and an edge below which they run alongside each other.
const ALONG: f64 = 1e-10;

impl Walk<'_> {
    /// What another sheet makes of a motion over `face` from `p` to `end`, and on in the direction of `foot` where `end` is on
    /// an edge: `None` where there is none in the way.
    pub(super) fn stopped(&self, face: &Face, p: Vec3, end: Vec3, foot: Vec3) -> Option<Step> {
        if !self.search.is_crossed(face.triangle) {
            return None;
        }
        let own = [face.triangle; 2];
        if self.sides == Sides::Both {
            return self.stopped_short(face, p, end);
        }
        if let Some(wall) = self.blocker(own, p, foot - p, true) {
            return Some(Step::Go(At::crease(face, &wall, p)));
        }
        let Some(hit) = self.sheet_between(own, p, end, face.normal) else {
            let wall = self.blocker(own, end, foot - p, true)?;
            return Some(Step::Slip(At::crease(face, &wall, end)));
        };
        let triangle = self.surface.triangle(face.triangle);
        let q = triangle.closest_point(hit.point).point;
        Some(match self.face(hit.triangle) {
            Some(other) => Step::Slip(At::crease(face, &other, q)),
            None => self.cornered(face.triangle, hit.point),
        })
    }

    /// [`stopped`](Self::stopped) where both sides of every sheet stop a motion. Which side of another sheet the proxy is on is
    /// known from its motion alone, so it never comes to stand on two sheets: it stops short of the second.
    fn stopped_short(&self, face: &Face, p: Vec3, end: Vec3) -> Option<Step> {
        let beyond = end + unit_or(end - p, Vec3::ZERO) * (SHORT_LIFTS * self.lift);
        let hit = self.sheet_between([face.triangle; 2], p, beyond, face.normal)?;
        let Some(other) = self.face_on(hit.triangle, !hit.inward) else {
            return Some(self.cornered(face.triangle, p));
        };
        let back = self.clear_of(face, &other);
        let triangle = self.surface.triangle(face.triangle);
        let q = triangle.closest_point(hit.point + back).point;
        Some(Step::Slip(At::crease(face, &other, q)))
    }

    /// The step over `on` that leads from the line where it meets `other` clear of that.
    fn clear_of(&self, on: &Face, other: &Face) -> Vec3 {
        let line = unit_or(on.normal.cross(other.normal), Vec3::ZERO);
        let up = line.cross(on.normal);
        let away = up * up.dot(other.normal).signum();
        let steep = away.dot(other.normal).max(1.0 / SHORT_LIFTS);
        away * (SHORT_LIFTS * self.lift / steep)
    }

    /// The same where a proxy must not stand on two sheets, since both sides of each stop it.
    fn clear_where_both_stop(&self, on: &Face, other: &Face, q: Vec3) -> Vec3 {
        let near = other.height(q) < TOUCH_LIFTS * self.lift;
        match self.sides {
            Sides::Both if near => self.clear_of(on, other),
            _ => Vec3::ZERO,
        }
    }

    /// `on`, reached from `from`, clear of the other sheets that rise there.
    pub(super) fn clear_of_walls(&self, on: Footing, from: Vec3) -> Footing {
        let Some(face) = self.face(on.triangle) else {
            return on;
        };
        if !self.search.is_crossed(on.triangle) {
            return on;
        }
        let touch = TOUCH_LIFTS * self.lift;
        let before = on.point + (from - on.point).clamp_length_max(WITNESS_LIFTS * self.lift);
        let mut clear = on;
        self.search.around(on.point, touch, |t| {
            let Some(mut other) = self.face(t) else {
                return;
            };
            if other.height(before) < 0.0 {
                other = other.seen_from_behind();
            }
            if !other.vertices.iter().any(|v| face.vertices.contains(v))
                && other.corners.iter().any(|&c| face.height(c) > touch)
                && face.normal.cross(other.normal).length_squared() > PARALLEL
                && self
                    .surface
                    .triangle(t)
                    .closest_point(on.point)
                    .point
                    .distance(on.point)
                    <= touch
            {
                clear.point += self.clear_where_both_stop(&face, &other, clear.point);
            }
        });
        clear
    }

    /// On over `other`, on the side it shows.
    fn over_to(&self, other: &Face, q: Vec3) -> Step {
        if other.behind() == self.behind {
            return Step::Go(At::Face(*other, q));
        }
        Step::End(Outcome::Over(Footing {
            triangle: other.triangle,
            point: q,
            behind: other.behind(),
        }))
    }

    /// The sheet that a proxy standing at `p` against it would enter by moving `ahead`: of those that touch the place,
    /// apart from the two triangles it stands on and their neighbours, the one most in the way.
    ///
    /// A `wall` rises above the triangles stood on. A triangle that the motion leads away from over an edge is not in the way,
    /// nor one that lies in the plane stood on, faces the other way and ends there: the underside of what stands there.
    pub(super) fn blocker(&self, own: [u32; 2], p: Vec3, ahead: Vec3, wall: bool) -> Option<Face> {
        if self.sides == Sides::Both {
            return None;
        }
        let corners = |t: u32| self.surface.triangles()[t as usize];
        let stood_on = own.map(corners);
        let up = own.map(|t| self.out(self.surface.triangle(t).normal()));
        let touch = TOUCH_LIFTS * self.lift;
        let rises = |face: &Face| {
            face.corners.iter().any(|&c| {
                let to = c - p;
                let least = ALONG * to.length() + touch;
                up.iter().all(|n| n.dot(to) > least)
            })
        };
        let mut worst: Option<(f64, Face)> = None;
        self.search.around(p, touch, |t| {
            if corners(t)
                .iter()
                .any(|v| stood_on.iter().any(|c| c.contains(v)))
            {
                return;
            }
            let Some(face) = self.face(t) else {
                return;
            };
            let inward = ahead.dot(face.normal);
            if inward < 0.0
                && worst.is_none_or(|(most, _)| inward < most)
                && !(up.iter().any(|n| n.dot(face.normal) < PARALLEL - 1.0)
                    && self.at_border(&face, p))
                && !face.leaves(p, ahead, touch)
                && (!wall || rises(&face))
                && self.surface.triangle(t).closest_point(p).point.distance(p) <= touch
            {
                worst = Some((inward, face));
            }
        });
        worst.map(|(_, face)| face)
    }

    /// The sheet that lies on `face` about `p` and faces it, where only fronts stop a motion: nothing comes in between.
    pub(super) fn cover(&self, face: &Face, p: Vec3) -> Option<Face> {
        if self.sides == Sides::Both || !self.search.is_crossed(face.triangle) {
            return None;
        }
        let touch = TOUCH_LIFTS * self.lift;
        let mut cover = None;
        self.search.around(p, touch, |t| {
            if let Some(other) = self.face(t)
                && cover.is_none()
                && other.normal.dot(face.normal) < PARALLEL - 1.0
                && !other.vertices.iter().any(|v| face.vertices.contains(v))
                && self.surface.triangle(t).closest_point(p).point.distance(p) <= touch
                && !self.at_border(&other, p)
            {
                cover = Some(other);
            }
        });
        cover
    }

    /// Whether `p` is where the flat part that `face` belongs to ends.
    fn at_border(&self, face: &Face, p: Vec3) -> bool {
        let across = self.surface.topology().across(face.triangle);
        (0..3).any(|i| {
            face.rate(i, p - face.corners[i]) <= TOUCH_LIFTS * self.lift
                && self
                    .face(across[i])
                    .is_none_or(|next| next.normal.dot(face.normal) < 1.0 - PARALLEL)
        })
    }

    /// The first sheet that a motion just above the surface enters, apart from those joined to the triangles it stands on
    /// where they are joined: the walk itself knows how to go on there.
    pub(super) fn sheet_between(
        &self,
        own: [u32; 2],
        p: Vec3,
        end: Vec3,
        above: Vec3,
    ) -> Option<Hit> {
        let up = above * self.lift;
        let hit = self
            .search
            .sweep(self.surface, p + up, end + up, self.sides)?;
        let corners = |t: u32| self.surface.triangles()[t as usize];
        let joined = own.iter().any(|&t| {
            let other = corners(hit.triangle);
            let mut shared = corners(t).into_iter().filter(|v| other.contains(v));
            let near = |v: u32| {
                self.surface.positions()[v as usize].distance(hit.point) <= JOINT_LIFTS * self.lift
            };
            match (shared.next(), shared.next()) {
                (None, _) => false,
                (Some(v), None) => near(v),
                _ => true,
            }
        });
        (!joined).then_some(hit)
    }

    /// Stopped along a line by a third plane: nothing is left to slide along.
    pub(super) fn cornered(&self, triangle: u32, at: Vec3) -> Step {
        let proxy = self.surface.triangle(triangle).closest_point(at).point;
        let up = proxy - self.hip;
        Step::End(Outcome::Rests(Rest {
            triangle,
            proxy,
            normal: unit_or(up, self.out(self.surface.triangle(triangle).normal())),
            depth: up.length(),
            foot: proxy,
            slipped: true,
        }))
    }

    /// Along the line where `face` and `other`, of two sheets, meet: up one of them where that leads down to the HIP, else
    /// along the line.
    pub(super) fn follow_crease(&self, face: &Face, other: &Face, q: Vec3, radius: f64) -> Step {
        let stay = self.footing(face.triangle, q);
        let line = unit_or(face.normal.cross(other.normal), Vec3::ZERO);
        let down = self.hip - q;
        if line == Vec3::ZERO {
            return Step::End(Outcome::Rests(self.rest_in_plane(stay)));
        }
        // Up each face, away from the other.
        let up_face = line.cross(face.normal);
        let up_other = other.normal.cross(line);
        let outward = |up: Vec3, n: Vec3| if up.dot(n) < 0.0 { -up } else { up };
        let above = [face, other].map(|f| down.dot(f.normal) > self.lift);
        if above == [true; 2] {
            return Step::End(Outcome::Lifts(stay));
        }
        if !above[0] && down.dot(outward(up_face, other.normal)) > self.lift {
            return Step::Go(At::Face(*face, q));
        }
        if !above[1] && down.dot(outward(up_other, face.normal)) > self.lift {
            return self.over_to(other, q + self.clear_where_both_stop(other, face, q));
        }
        let along = down.dot(line);
        let across_mm = down - line * along;
        let depth = across_mm.length();
        let rest = |proxy: Vec3, slipped| {
            Step::End(Outcome::Rests(Rest {
                triangle: face.triangle,
                proxy,
                normal: unit_or(-across_mm, face.normal),
                depth,
                foot: q + line * along,
                slipped,
            }))
        };
        if along.abs() <= radius * depth * ON_CONE {
            return rest(q, false);
        }
        let way = along - (self.cone.moving * depth).min(along.abs()).copysign(along);
        let mut end = q + line * way;
        let mut exit: Option<(f64, bool, usize)> = None;
        for (is_face, f) in [(true, face), (false, other)] {
            for i in 0..3 {
                // An edge along the line is not left over, whatever rounding says.
                if f.rate(i, line * way) > -ALONG * way.abs() {
                    continue;
                }
                let (start, stop) = (f.inside(i, q).max(0.0), f.inside(i, end));
                if stop < 0.0 {
                    let fraction = start / (start - stop);
                    if exit.is_none_or(|(first, _, _)| fraction < first) {
                        exit = Some((fraction, is_face, i));
                    }
                }
            }
        }
        if let Some((fraction, _, _)) = exit {
            end = q + line * (way * fraction);
        }
        let (one, two) = (face.triangle, other.triangle);
        if self.blocker([one, two], q, end - q, true).is_some() {
            return self.cornered(one, q);
        }
        if let Some(hit) = self.sheet_between([one, two], q, end, face.normal + other.normal) {
            return self.cornered(one, hit.point);
        }
        let Some((_, is_face, i)) = exit else {
            return rest(end, true);
        };
        let leaving = if is_face { face } else { other };
        let next = self.surface.topology().across(leaving.triangle)[i];
        match (self.face_on(next, leaving.behind()), is_face) {
            (Some(next), true) => Step::Slip(At::crease(&next, other, end)),
            (Some(next), false) => {
                // Round the corner of the other sheet: it ends on the plane of the next one.
                let clear = self.clear_where_both_stop(face, &next, end);
                Step::Slip(At::crease(face, &next, end + clear))
            }
            (None, false) if next == RIM => Step::Slip(At::Face(*face, end)),
            (None, true) if next == RIM => {
                Step::End(Outcome::SlidesOff(self.footing(face.triangle, end)))
            }
            _ => rest(end, true),
        }
    }
}
