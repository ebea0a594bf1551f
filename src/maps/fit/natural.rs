//! Natural neighbour interpolation (Sibson 1981) of values at scattered places of the map plane.
//!
//! Inside the hull of the places: `spade`'s Sibson weights, which reproduce linear functions and meet the values at the
//! places. On the hull the weights become linear between the two places at the ends of its edge; outside, the value is that
//! of the closest point of the hull, so the field is continuous over the whole plane.
//!
//! Natural neighbour coordinates are undefined for places on one line. There, and for one or two places, the value is that
//! of the closest point on the chain of segments through them.

use super::{Field, Fitted, Reader, Sample, TOUCHING_MM};
use crate::geom::Vec2;
use crate::maps::MapError;
use spade::handles::FixedVertexHandle;
use spade::{DelaunayTriangulation, HasPosition, HintGenerator, Point2, Triangulation};
use std::sync::Arc;

impl HasPosition for Sample {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        point(self.at)
    }
}

/// Coordinates too small for exact predicates (below 1e-43 mm) are taken as 0.
fn point(place: Vec2) -> Point2<f64> {
    spade::mitigate_underflow(Point2::new(place.x, place.y))
}

type Mesh = DelaunayTriangulation<Sample, (), (), (), GridHint>;

/// The fitted field.
#[derive(Debug)]
struct NaturalNeighbour {
    /// Absent where the places lie on one line.
    mesh: Option<Mesh>,
    /// Segments of the hull, or of the chain through places on one line; one of no length for a single place.
    border: Vec<[Sample; 2]>,
    least: f64,
    most: f64,
}

impl NaturalNeighbour {
    /// Fits `samples`: at least one, finite, no two within [`TOUCHING_MM`], no coordinate beyond 1e60. `None` otherwise.
    fn new(samples: &[Sample]) -> Option<Self> {
        let first = samples.first()?;
        let (least, most) = samples
            .iter()
            .fold((first.value, first.value), |(lo, hi), s| {
                (lo.min(s.value), hi.max(s.value))
            });
        let (mesh, border) = match on_one_line(samples) {
            Some(chain) => (None, chain),
            None => {
                let mesh = Mesh::bulk_load(samples.to_vec()).ok()?;
                let border = hull(&mesh, samples);
                (Some(mesh), border)
            }
        };
        Some(Self {
            mesh,
            border,
            least,
            most,
        })
    }

    /// Value at the closest point of the border, and the square of the distance to it, mm².
    fn at_border(&self, place: Vec2) -> (f64, f64) {
        let mut nearest = (self.least, f64::INFINITY);
        for [from, to] in &self.border {
            let along = to.at - from.at;
            let t = (place - from.at).dot(along) / along.length_squared();
            // A segment of no length gives NaN, which like t ≤ 0 answers with its first end.
            let (closest, value) = if t >= 1.0 {
                (to.at, to.value)
            } else if t > 0.0 {
                (
                    from.at + along * t,
                    from.value + (to.value - from.value) * t,
                )
            } else {
                (from.at, from.value)
            };
            let distance_sq = place.distance_squared(closest);
            if distance_sq < nearest.1 {
                nearest = (value, distance_sq);
            }
        }
        nearest
    }
}

pub(super) fn through(samples: &[Sample]) -> Fitted {
    let field = NaturalNeighbour::new(samples).ok_or(MapError::NoKeys)?;
    Ok(Arc::new(field))
}

impl Field for NaturalNeighbour {
    fn reader(&self) -> Box<dyn Reader + '_> {
        Box::new(Walker {
            field: self,
            inner: self.mesh.as_ref().map(Mesh::natural_neighbor),
            weights: Vec::new(),
        })
    }
}

/// Reads the field with scratch memory.
struct Walker<'a> {
    field: &'a NaturalNeighbour,
    inner: Option<spade::NaturalNeighbor<'a, Mesh>>,
    weights: Vec<(FixedVertexHandle, f64)>,
}

impl Reader for Walker<'_> {
    /// Between the smallest and the largest of the samples.
    fn at(&mut self, place: Vec2) -> f64 {
        let (border_value, distance_sq) = self.field.at_border(place);
        let inside = if distance_sq > TOUCHING_MM * TOUCHING_MM {
            self.inside(place)
        } else {
            None
        };
        inside
            .unwrap_or(border_value)
            .clamp(self.field.least, self.field.most)
    }
}

impl Walker<'_> {
    /// Value from the natural neighbours; `None` outside the hull.
    fn inside(&mut self, place: Vec2) -> Option<f64> {
        let (Some(inner), Some(mesh)) = (&self.inner, &self.field.mesh) else {
            return None;
        };
        inner.get_weights(point(place), &mut self.weights);
        if self.weights.is_empty() {
            return None;
        }
        let value: f64 = self
            .weights
            .iter()
            .map(|&(vertex, weight)| mesh.vertex(vertex).data().value * weight)
            .sum();
        value.is_finite().then_some(value)
    }
}

/// The chain of segments through samples that lie on one line, `None` where they do not.
fn on_one_line(samples: &[Sample]) -> Option<Vec<[Sample; 2]>> {
    let mut chain = samples.to_vec();
    chain.sort_by(|s, t| {
        (s.at.x, s.at.y)
            .partial_cmp(&(t.at.x, t.at.y))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    let (first, last) = (*chain.first()?, *chain.last()?);
    let along = last.at - first.at;
    let length = along.length();
    let off = |s: &Sample| along.perp_dot(s.at - first.at).abs();
    if chain.iter().any(|s| off(s) > TOUCHING_MM * length) {
        return None;
    }
    // Sorting by x leaves a line along y to the noise in x: order by the place along the line.
    chain.sort_by(|s, t| along.dot(s.at).total_cmp(&along.dot(t.at)));
    if chain.len() == 1 {
        return Some(vec![[first, first]]);
    }
    Some(chain.windows(2).map(|w| [w[0], w[1]]).collect())
}

/// The segments of the hull, cut at samples that lie on them.
fn hull(mesh: &Mesh, samples: &[Sample]) -> Vec<[Sample; 2]> {
    let mut border = Vec::new();
    for edge in mesh.convex_hull() {
        let [from, to] = edge.vertices().map(|v| *v.data());
        let along = to.at - from.at;
        let length_sq = along.length_squared();
        let mut on_edge: Vec<(f64, Sample)> = samples
            .iter()
            .map(|s| ((s.at - from.at).dot(along) / length_sq, *s))
            .filter(|(t, s)| {
                let off = along.perp_dot(s.at - from.at).abs();
                *t > 0.0 && *t < 1.0 && s.at != to.at && off <= TOUCHING_MM * length_sq.sqrt()
            })
            .collect();
        on_edge.sort_by(|s, t| s.0.total_cmp(&t.0));
        let mut last = from;
        for s in on_edge.into_iter().map(|(_, s)| s).chain([to]) {
            border.push([last, s]);
            last = s;
        }
    }
    border
}

/// Where `spade` starts its walk to a place: a sample near it, by a grid.
///
/// Its own generators remember the last query, so that the order of queries, or a second thread, can turn an edge round and
/// the last bit of a sum with it. This one depends on the place alone.
#[derive(Clone, Debug, Default)]
struct GridHint {
    origin: Vec2,
    cells_per_mm: Vec2,
    columns: usize,
    rows: usize,
    nearby: Vec<FixedVertexHandle>,
}

impl HintGenerator<f64> for GridHint {
    fn get_hint(&self, place: Point2<f64>) -> FixedVertexHandle {
        if self.nearby.is_empty() {
            return FixedVertexHandle::from_index(0);
        }
        let cell = (Vec2::new(place.x, place.y) - self.origin) * self.cells_per_mm;
        // Casting saturates, so places off the grid take its rim.
        let column = (cell.x as usize).min(self.columns - 1);
        let row = (cell.y as usize).min(self.rows - 1);
        self.nearby[row * self.columns + column]
    }

    fn notify_vertex_lookup(&self, _: FixedVertexHandle) {}

    fn notify_vertex_inserted(&mut self, _: FixedVertexHandle, _: Point2<f64>) {}

    fn notify_vertex_removed(
        &mut self,
        _: Option<Point2<f64>>,
        _: FixedVertexHandle,
        _: Point2<f64>,
    ) {
    }

    fn initialize_from_triangulation<TR, V>(triangulation: &TR) -> Self
    where
        TR: Triangulation<Vertex = V>,
        V: HasPosition<Scalar = f64>,
    {
        let places = || {
            triangulation
                .vertices()
                .map(|v| (v.fix(), Vec2::new(v.position().x, v.position().y)))
        };
        let side = (triangulation.num_vertices() as f64).sqrt() as usize;
        let low = places().fold(Vec2::INFINITY, |m, (_, p)| m.min(p));
        let high = places().fold(Vec2::NEG_INFINITY, |m, (_, p)| m.max(p));
        let span = high - low;
        let flat = span.x <= 0.0 || span.y <= 0.0;
        if side < 4 || flat || !span.is_finite() {
            return Self::default();
        }
        let mut grid = Self {
            origin: low,
            cells_per_mm: Vec2::splat(side as f64) / span,
            columns: side,
            rows: side,
            nearby: vec![FixedVertexHandle::from_index(0); side * side],
        };
        let mut filled = vec![false; side * side];
        for (vertex, p) in places() {
            let cell = (p - grid.origin) * grid.cells_per_mm;
            let at = (cell.y as usize).min(side - 1) * side + (cell.x as usize).min(side - 1);
            grid.nearby[at] = vertex;
            filled[at] = true;
        }
        let mut last = FixedVertexHandle::from_index(0);
        for (vertex, filled) in grid.nearby.iter_mut().zip(filled) {
            if filled {
                last = *vertex;
            }
            *vertex = last;
        }
        grid
    }
}
