//! Axis-aligned boxes.

use super::Vec3;

/// An axis-aligned box, mm. Empty when any `min` component exceeds its `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Lowest corner, mm.
    pub min: Vec3,
    /// Highest corner, mm.
    pub max: Vec3,
}

impl Aabb {
    /// The box that holds nothing: the neutral element of [`Aabb::union`].
    pub const EMPTY: Self = Self {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
    };

    /// The smallest box around `points`; [`Aabb::EMPTY`] for none.
    pub fn of_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self {
            min: b.min.min(p),
            max: b.max.max(p),
        })
    }

    /// The cube with the given centre and edge length, both mm.
    pub fn cube(centre: Vec3, edge_mm: f64) -> Self {
        let half = Vec3::splat(edge_mm / 2.0);
        Self {
            min: centre - half,
            max: centre + half,
        }
    }

    /// The smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// The box grown by `margin_mm` on every side.
    pub fn grown(self, margin_mm: f64) -> Self {
        Self {
            min: self.min - Vec3::splat(margin_mm),
            max: self.max + Vec3::splat(margin_mm),
        }
    }

    /// Whether the box holds nothing.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// The middle, mm. Not finite for an empty box.
    pub fn centre(&self) -> Vec3 {
        (self.min + self.max) / 2.0
    }

    /// Edge lengths, mm; zero for an empty box.
    pub fn size(&self) -> Vec3 {
        (self.max - self.min).max(Vec3::ZERO)
    }

    /// Length of the diagonal, mm; zero for an empty box.
    pub fn diagonal_mm(&self) -> f64 {
        self.size().length()
    }

    /// Whether `p` lies inside or on the border.
    pub fn contains(&self, p: Vec3) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }

    /// Whether the two boxes share a point.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && self.max.cmpge(other.min).all()
    }

    /// Squared distance from `p` to the box, mm²; zero inside.
    pub fn distance_sq(&self, p: Vec3) -> f64 {
        (self.min - p)
            .max(p - self.max)
            .max(Vec3::ZERO)
            .length_squared()
    }
}
