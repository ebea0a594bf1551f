//! Numbers on a grid over a part of the map plane.

use super::plane::Area;
use crate::geom::Vec2;

/// Most samples in a grid.
const MOST: usize = 400_000;

/// Values at the corners of a regular grid: row by row from the smallest y, each from the smallest x.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// From the first to the last sample, mm.
    pub area: Area,
    /// Samples along x, at least 2.
    pub columns: usize,
    /// Samples along y, at least 2.
    pub rows: usize,
    /// `columns × rows` values.
    pub values: Vec<f64>,
}

impl Grid {
    /// Samples of `f` about `cell_mm` apart. Nothing when `go_on`, asked once a row, says so, or when the area is empty.
    pub fn sample(
        area: Area,
        cell_mm: f64,
        mut f: impl FnMut(Vec2) -> f64,
        go_on: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let size = area.size();
        if !(size.x > 0.0 && size.y > 0.0 && size.is_finite() && cell_mm > 0.0) {
            return None;
        }
        let least_mm = (size.x * size.y / MOST as f64).sqrt();
        let cell_mm = cell_mm.max(least_mm);
        let count = |length: f64| (length / cell_mm).ceil() as usize + 1;
        let (columns, rows) = (count(size.x).max(2), count(size.y).max(2));
        let mut grid = Self {
            area,
            columns,
            rows,
            values: Vec::with_capacity(columns * rows),
        };
        for row in 0..rows {
            if !go_on() {
                return None;
            }
            for column in 0..columns {
                grid.values.push(f(grid.place(column, row)));
            }
        }
        Some(grid)
    }

    /// Where a sample is, mm.
    pub fn place(&self, column: usize, row: usize) -> Vec2 {
        let part = Vec2::new(
            column as f64 / (self.columns - 1) as f64,
            row as f64 / (self.rows - 1) as f64,
        );
        self.area.min + self.area.size() * part
    }

    /// A value.
    pub fn at(&self, column: usize, row: usize) -> f64 {
        self.values[row * self.columns + column]
    }

    /// The value between the samples, bilinear; nothing outside.
    pub fn between(&self, p: Vec2) -> Option<f64> {
        if !self.area.contains(p) {
            return None;
        }
        let last = Vec2::new((self.columns - 1) as f64, (self.rows - 1) as f64);
        let at = (p - self.area.min) / self.area.size() * last;
        let corner = at.floor().clamp(Vec2::ZERO, last - 1.0);
        let (i, j, t) = (corner.x as usize, corner.y as usize, at - corner);
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        Some(mix(
            mix(self.at(i, j), self.at(i + 1, j), t.x),
            mix(self.at(i, j + 1), self.at(i + 1, j + 1), t.x),
            t.y,
        ))
    }

    /// Smallest and largest finite value.
    pub fn range(&self) -> Option<(f64, f64)> {
        let finite = self.values.iter().copied().filter(|v| v.is_finite());
        finite.fold(None, |range, v| {
            let (lo, hi) = range.unwrap_or((v, v));
            Some((lo.min(v), hi.max(v)))
        })
    }

    /// The finite value largest in size, and where it is.
    pub fn largest(&self) -> Option<(f64, Vec2)> {
        let mut best: Option<(f64, usize)> = None;
        for (i, &v) in self.values.iter().enumerate() {
            if v.is_finite() && best.is_none_or(|(b, _)| v.abs() > b.abs()) {
                best = Some((v, i));
            }
        }
        best.map(|(v, i)| (v, self.place(i % self.columns, i / self.columns)))
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.values.capacity() * size_of::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area() -> Area {
        Area {
            min: Vec2::new(-10.0, 0.0),
            max: Vec2::new(30.0, 20.0),
        }
    }

    #[test]
    fn samples_lie_where_they_say_and_a_plane_is_met_between_them() {
        let f = |p: Vec2| 3.0 * p.x - 2.0 * p.y + 1.0;
        let grid = Grid::sample(area(), 3.0, f, &|| true).expect("a grid");
        for row in 0..grid.rows {
            for column in 0..grid.columns {
                assert!((grid.at(column, row) - f(grid.place(column, row))).abs() < 1e-12);
            }
        }
        for p in [
            Vec2::new(-10.0, 0.0),
            Vec2::new(7.3, 19.9),
            Vec2::new(30.0, 20.0),
        ] {
            let between = grid.between(p).expect("inside");
            assert!((between - f(p)).abs() < 1e-9, "{p}: {between}");
        }
        assert_eq!(grid.between(Vec2::new(31.0, 0.0)), None);
        assert_eq!(grid.range(), Some((-69.0, 91.0)));
        assert_eq!(grid.largest(), Some((91.0, Vec2::new(30.0, 0.0))));
    }

    #[test]
    fn no_area_and_no_patience_give_no_grid_and_size_is_bounded() {
        let empty = Area {
            min: Vec2::ZERO,
            max: Vec2::new(10.0, 0.0),
        };
        assert!(Grid::sample(empty, 1.0, |_| 0.0, &|| true).is_none());
        assert!(Grid::sample(area(), 1.0, |_| 0.0, &|| false).is_none());
        assert!(Grid::sample(area(), 0.0, |_| 0.0, &|| true).is_none());
        let fine = Grid::sample(area(), 1e-9, |_| 0.0, &|| true).expect("a grid");
        assert!(fine.values.len() < MOST + 4 * fine.columns.max(fine.rows));
    }

    #[test]
    fn what_is_no_number_counts_for_nothing() {
        let f = |p: Vec2| if p.x < 0.0 { f64::NAN } else { p.x };
        let grid = Grid::sample(area(), 5.0, f, &|| true).expect("a grid");
        assert_eq!(grid.range(), Some((0.0, 30.0)));
        let none = Grid::sample(area(), 5.0, |_| f64::NAN, &|| true).expect("a grid");
        assert_eq!((none.range(), none.largest()), (None, None));
    }
}
