//! The outline of a surface seen along z: what the map plane is laid over.

use super::contour;
use super::grid::Grid;
use super::plane::Area;
use crate::geom::Vec2;
use crate::surface::Surface;

/// Cells along the longer side.
const CELLS: f64 = 360.0;

/// The outline, and how much of each cell the surface covers.
#[derive(Clone, Debug, PartialEq)]
pub struct Silhouette {
    /// The surface's extent on the map plane, mm.
    pub area: Area,
    /// The border, mm: closed lines, one for each piece and each hole.
    pub outline: Vec<Vec<Vec2>>,
    /// Covered share about each sample, 0…1; 0 at its border.
    pub cover: Grid,
}

impl Silhouette {
    /// The outline of `surface`. Nothing for one without extent on the map plane, or when `go_on` says so.
    pub fn of(surface: &Surface, go_on: &dyn Fn() -> bool) -> Option<Self> {
        let positions = surface.positions();
        let area = Area::around(positions.iter().map(|p| p.truncate()))?;
        let size = area.size();
        if size.min_element() <= 0.0 {
            return None;
        }
        let cell_mm = size.max_element() / CELLS;
        // Three cells of nothing around, so that every outline closes.
        let around = area.grown(3.0 * cell_mm);
        let mut hit = Grid::sample(around, cell_mm, |_| 0.0, go_on)?;
        let step = around.size() / Vec2::new((hit.columns - 1) as f64, (hit.rows - 1) as f64);
        let on_grid = |p: Vec2| (p - around.min) / step;
        for (i, triangle) in surface.triangles().iter().enumerate() {
            if i % 65_536 == 0 && !go_on() {
                return None;
            }
            let corners = triangle.map(|v| on_grid(positions[v as usize].truncate()));
            fill(&mut hit, corners);
        }
        let cover = smoothed(&hit, go_on)?;
        let outline = contour::contours(&cover, &[0.5]).pop()?.lines;
        Some(Self {
            area,
            outline,
            cover,
        })
    }

    /// Whether a place of the map has skin above it.
    pub fn covers(&self, p: Vec2) -> bool {
        self.cover.between(p).is_some_and(|c| c >= 0.5)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let points: usize = self.outline.iter().map(Vec::capacity).sum();
        self.cover.bytes() + points * size_of::<Vec2>()
    }
}

/// Marks the samples in a triangle, and those nearest to its corners: small triangles lie between samples.
fn fill(hit: &mut Grid, corners: [Vec2; 3]) {
    let last = Vec2::new((hit.columns - 1) as f64, (hit.rows - 1) as f64);
    for c in corners {
        let at = c.round().clamp(Vec2::ZERO, last);
        hit.values[at.y as usize * hit.columns + at.x as usize] = 1.0;
    }
    let [a, b, c] = corners;
    let turn = (b - a).perp_dot(c - a);
    if turn == 0.0 || !turn.is_finite() {
        return;
    }
    let lo = a.min(b).min(c).ceil().clamp(Vec2::ZERO, last);
    let hi = a.max(b).max(c).floor().clamp(Vec2::ZERO, last);
    for row in lo.y as usize..=hi.y as usize {
        for column in lo.x as usize..=hi.x as usize {
            let p = Vec2::new(column as f64, row as f64);
            let side = |from: Vec2, to: Vec2| (to - from).perp_dot(p - from) * turn >= 0.0;
            if side(a, b) && side(b, c) && side(c, a) {
                hit.values[row * hit.columns + column] = 1.0;
            }
        }
    }
}

/// Mean over 3 × 3 samples, so that the outline is no staircase.
fn smoothed(hit: &Grid, go_on: &dyn Fn() -> bool) -> Option<Grid> {
    let mut out = hit.clone();
    for row in 1..hit.rows - 1 {
        if !go_on() {
            return None;
        }
        for column in 1..hit.columns - 1 {
            let mut sum = 0.0;
            for y in row - 1..=row + 1 {
                for x in column - 1..=column + 1 {
                    sum += hit.at(x, y);
                }
            }
            out.values[row * hit.columns + column] = sum / 9.0;
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::primitives;

    #[test]
    fn a_sphere_is_a_disc() {
        let (surface, _) = Surface::new(primitives::icosphere(100.0, 5)).expect("closed");
        let s = Silhouette::of(&surface, &|| true).expect("has an outline");
        assert_eq!(s.outline.len(), 1);
        let line = &s.outline[0];
        assert_eq!(line.first(), line.last());
        for p in line {
            assert!((p.length() - 100.0).abs() < 2.0, "{p} {}", p.length());
        }
        assert!(s.covers(Vec2::new(60.0, 60.0)) && !s.covers(Vec2::new(80.0, 80.0)));
        assert!(!s.covers(Vec2::new(1e6, 0.0)) && !s.covers(Vec2::NAN));
    }

    #[test]
    fn asked_to_stop_it_stops() {
        let (surface, _) = Surface::new(primitives::icosphere(100.0, 2)).expect("closed");
        assert!(Silhouette::of(&surface, &|| false).is_none());
    }
}
