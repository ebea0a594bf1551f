//! From a field round a finger to the vertices of the skin, by the plainest means: a walk over the adjacency, all normals
//! from scratch. A second way beside the one of [`crate::deform`], and slower.

use crate::deform::{Displacement, Press};
use crate::geom::{Vec2, Vec3, any_tangent, unit_or};
use crate::surface::Surface;
use std::collections::BTreeSet;

/// The tangent plane of a press.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// Where its axes meet, mm.
    pub origin_mm: Vec3,
    /// Unit axes.
    pub x: Vec3,
    /// Unit, at right angles to x.
    pub y: Vec3,
    /// Outward unit normal.
    pub normal: Vec3,
}

impl Plane {
    /// The plane at the anchor of a press, `None` where that is no place or no triangle.
    pub fn of(press: &Press, surface: &Surface) -> Option<Self> {
        let normal = unit_or(press.normal, Vec3::ZERO);
        let sound = normal != Vec3::ZERO
            && press.anchor_mm.is_finite()
            && (press.triangle as usize) < surface.triangles().len();
        sound.then(|| Self::at(press.anchor_mm, normal))
    }

    /// The plane through a point with a unit normal.
    pub fn at(origin_mm: Vec3, normal: Vec3) -> Self {
        let x = any_tangent(normal);
        Self {
            origin_mm,
            x,
            y: normal.cross(x),
            normal,
        }
    }

    /// Where the foot of a point lies on it, mm.
    pub fn place_mm(&self, point_mm: Vec3) -> Vec2 {
        let from = point_mm - self.origin_mm;
        Vec2::new(from.dot(self.x), from.dot(self.y))
    }
}

/// Offsets gathered for one update.
#[derive(Clone, Debug, Default)]
pub struct Spread {
    offsets_mm: Vec<Vec3>,
}

impl Spread {
    /// Starts from the surface at rest.
    pub fn begin(&mut self, surface: &Surface) {
        self.offsets_mm.clear();
        self.offsets_mm
            .resize(surface.positions().len(), Vec3::ZERO);
    }

    /// Adds `offset` of every vertex that hangs together with triangle `start` by vertices for which it answers.
    pub fn around(&mut self, surface: &Surface, start: u32, offset: impl Fn(Vec3) -> Option<Vec3>) {
        let Some(corners) = surface.triangles().get(start as usize) else {
            return;
        };
        let mut seen: BTreeSet<u32> = corners.iter().copied().collect();
        let mut waiting: Vec<u32> = corners.to_vec();
        while let Some(v) = waiting.pop() {
            let Some(by) = offset(surface.positions()[v as usize]) else {
                continue;
            };
            if by.is_finite() {
                self.offsets_mm[v as usize] += by;
            }
            for &n in surface.topology().neighbours(v) {
                if seen.insert(n) {
                    waiting.push(n);
                }
            }
        }
    }

    /// Writes offsets and the normals that follow from them.
    pub fn write(&self, surface: &Surface, out: &mut Displacement) {
        if out.n_vertices() != self.offsets_mm.len() {
            *out = Displacement::at_rest(surface);
        }
        let mut renewed: BTreeSet<u32> = BTreeSet::new();
        for (v, offset) in self.offsets_mm.iter().enumerate() {
            let v = v as u32;
            if *offset != Vec3::ZERO || out.offset_mm(v) != Vec3::ZERO {
                renewed.insert(v);
                renewed.extend(surface.topology().neighbours(v));
            }
        }
        for v in renewed {
            let normal = self.normal(surface, v);
            out.put(v, self.offsets_mm[v as usize], normal);
        }
    }

    /// The normal at rest turned by as much as the area normals round the vertex have changed.
    fn normal(&self, surface: &Surface, v: u32) -> Vec3 {
        let at_rest = surface.normals()[v as usize];
        let (mut before, mut after) = (Vec3::ZERO, Vec3::ZERO);
        for &t in surface.topology().triangles_of(v) {
            let corners = surface.triangles()[t as usize].map(|c| c as usize);
            let [a, b, c] = corners.map(|c| surface.positions()[c]);
            let [d, e, f] = corners.map(|c| surface.positions()[c] + self.offsets_mm[c]);
            before += (b - a).cross(c - a);
            after += (e - d).cross(f - d);
        }
        if before == after {
            at_rest
        } else {
            unit_or(at_rest * before.length() + (after - before), at_rest)
        }
    }
}
