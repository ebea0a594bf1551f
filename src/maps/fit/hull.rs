//! The convex hull of places, and the closest point of it.

use crate::geom::Vec2;

/// Corners counter-clockwise; one or two where the places do not span an area.
#[derive(Clone, Debug)]
pub(super) struct Hull(Vec<Vec2>);

impl Hull {
    /// Andrew's monotone chain (1979). `places` are finite.
    pub fn of(places: &[Vec2]) -> Self {
        let mut sorted = places.to_vec();
        sorted.sort_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
        sorted.dedup();
        let half = |points: &mut dyn Iterator<Item = Vec2>| {
            let mut chain: Vec<Vec2> = Vec::new();
            for p in points {
                while let [.., a, b] = chain[..]
                    && (b - a).perp_dot(p - b) <= 0.0
                {
                    chain.pop();
                }
                chain.push(p);
            }
            chain.pop();
            chain
        };
        let mut corners = half(&mut sorted.iter().copied());
        corners.extend(half(&mut sorted.iter().rev().copied()));
        if corners.is_empty() {
            corners = sorted;
        }
        Self(corners)
    }

    /// `place` itself inside, else the closest point of the border.
    pub fn closest(&self, place: Vec2) -> Vec2 {
        let n = self.0.len();
        let edges = || (0..n).map(|i| (self.0[i], self.0[(i + 1) % n]));
        if n > 2 && edges().all(|(a, b)| (b - a).perp_dot(place - a) >= 0.0) {
            return place;
        }
        let mut nearest = (place, f64::INFINITY);
        for (a, b) in edges() {
            let along = b - a;
            let t = ((place - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
            // A hull of one corner has an edge of no length.
            let point = if t.is_nan() { a } else { a + along * t };
            let distance_sq = place.distance_squared(point);
            if distance_sq < nearest.1 {
                nearest = (point, distance_sq);
            }
        }
        nearest.0
    }
}
