//! Case A: a triangle is cut along the plane in pieces.

use crate::geom::{Triangle, Vec3};

/// A piece of a triangle, or all of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// The triangle it was cut from.
    pub(super) triangle: u32,
    /// Its own corners, mm, in the order of the triangle's.
    pub(super) corners: [Vec3; 3],
}

impl Piece {
    pub(super) fn area_mm2(&self) -> f64 {
        let [a, b, c] = self.corners;
        Triangle { a, b, c }.area_mm2()
    }

    /// Adds what lies below and above the plane `axis` = `at_mm`. What only touches the plane is not cut.
    pub(super) fn cut(&self, axis: usize, at_mm: f64, out: &mut [Vec<Self>; 8]) {
        let along = self.corners.map(|p| p[axis]);
        if along.iter().all(|&x| x >= at_mm) {
            out[1].push(*self);
        } else if along.iter().all(|&x| x <= at_mm) {
            out[0].push(*self);
        } else {
            self.side(&mut out[0], |p| at_mm - p[axis], axis, at_mm);
            self.side(&mut out[1], |p| p[axis] - at_mm, axis, at_mm);
        }
    }

    /// The part where `height` is not negative (Sutherland & Hodgman 1974), as a fan: three or four corners.
    fn side(&self, out: &mut Vec<Self>, height: impl Fn(Vec3) -> f64, axis: usize, at_mm: f64) {
        let mut fan = [Vec3::ZERO; 4];
        let mut len = 0;
        let mut add = |p: Vec3| {
            if let Some(slot) = fan.get_mut(len) {
                *slot = p;
                len += 1;
            }
        };
        for i in 0..3 {
            let (p, q) = (self.corners[i], self.corners[(i + 1) % 3]);
            let (from, to) = (height(p), height(q));
            if from >= 0.0 {
                add(p);
            }
            if (from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0) {
                add(crossed(p, q, axis, at_mm));
            }
        }
        for i in 1..len.saturating_sub(1) {
            out.push(Self {
                triangle: self.triangle,
                corners: [fan[0], fan[i], fan[i + 1]],
            });
        }
    }
}

/// Where an edge meets the plane: the same point from both ends, on the plane, and within the edge's box.
fn crossed(p: Vec3, q: Vec3, axis: usize, at_mm: f64) -> Vec3 {
    let (low, high) = if p[axis] < q[axis] { (p, q) } else { (q, p) };
    let t = (at_mm - low[axis]) / (high[axis] - low[axis]);
    let mut cut = (low + (high - low) * t).clamp(low.min(high), low.max(high));
    cut[axis] = at_mm;
    cut
}
