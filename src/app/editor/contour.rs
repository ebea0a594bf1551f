//! Lines of equal value through a grid: marching squares, with the pieces joined to lines.

use super::grid::Grid;
use super::plane::{multiples, round_step};
use crate::geom::Vec2;

/// The lines of one value.
#[derive(Clone, Debug, PartialEq)]
pub struct Contour {
    /// The value.
    pub level: f64,
    /// Lines, mm; a closed one ends where it begins.
    pub lines: Vec<Vec<Vec2>>,
}

/// Round values between `lo` and `hi`, at most `most` of them, and the step between them.
pub fn levels(lo: f64, hi: f64, most: f64) -> (Vec<f64>, f64) {
    let step = round_step(hi - lo, most);
    let flat = hi - lo <= 1e-9 * lo.abs().max(hi.abs());
    if flat || !(hi - lo).is_finite() {
        return (Vec::new(), step);
    }
    (multiples(lo, hi, step), step)
}

/// The lines of each of `levels` through `grid`. A cell with a corner that is no number has none.
pub fn contours(grid: &Grid, levels: &[f64]) -> Vec<Contour> {
    levels
        .iter()
        .map(|&level| Contour {
            level,
            lines: trace(grid, level),
        })
        .collect()
}

/// An edge of the grid: those along x first, row by row, then those along y.
type Edge = usize;

/// No edge.
const NONE: Edge = usize::MAX;

fn trace(grid: &Grid, level: f64) -> Vec<Vec<Vec2>> {
    let (nx, ny) = (grid.columns, grid.rows);
    let along_x = |i: usize, j: usize| j * (nx - 1) + i;
    let along_y = |i: usize, j: usize| (nx - 1) * ny + j * nx + i;
    let n_edges = (nx - 1) * ny + nx * (ny - 1);
    // Where each edge is crossed is shared by the two cells beside it, so the pieces join exactly.
    let mut next = vec![[NONE; 2]; n_edges];
    let mut link = |a: Edge, b: Edge| {
        for (from, to) in [(a, b), (b, a)] {
            let slot = usize::from(next[from][0] != NONE);
            next[from][slot] = to;
        }
    };
    for j in 0..ny - 1 {
        for i in 0..nx - 1 {
            let corners = [
                grid.at(i, j),
                grid.at(i + 1, j),
                grid.at(i + 1, j + 1),
                grid.at(i, j + 1),
            ];
            if corners.iter().any(|v| !v.is_finite()) {
                continue;
            }
            let edges = [
                along_x(i, j),
                along_y(i + 1, j),
                along_x(i, j + 1),
                along_y(i, j),
            ];
            let above = corners.map(|v| v >= level);
            let mut crossed = [NONE; 4];
            let mut n = 0;
            for k in 0..4 {
                if above[k] != above[(k + 1) % 4] {
                    crossed[n] = edges[k];
                    n += 1;
                }
            }
            match n {
                2 => link(crossed[0], crossed[1]),
                4 => {
                    // A saddle: its middle says which corners belong together.
                    let middle = corners.iter().sum::<f64>() * 0.25 >= level;
                    if middle == above[0] {
                        link(edges[0], edges[1]);
                        link(edges[2], edges[3]);
                    } else {
                        link(edges[3], edges[0]);
                        link(edges[1], edges[2]);
                    }
                }
                _ => {}
            }
        }
    }
    let point = |edge: Edge| {
        let (a, b) = if edge < (nx - 1) * ny {
            let (i, j) = (edge % (nx - 1), edge / (nx - 1));
            ((i, j), (i + 1, j))
        } else {
            let e = edge - (nx - 1) * ny;
            let (i, j) = (e % nx, e / nx);
            ((i, j), (i, j + 1))
        };
        let (va, vb) = (grid.at(a.0, a.1), grid.at(b.0, b.1));
        let t = ((level - va) / (vb - va)).clamp(0.0, 1.0);
        grid.place(a.0, a.1).lerp(grid.place(b.0, b.1), t)
    };
    let mut done = vec![false; n_edges];
    let mut lines = Vec::new();
    // Open lines from their ends first; what is left is closed.
    for open in [true, false] {
        for start in 0..n_edges {
            let ends = next[start];
            if done[start] || ends[0] == NONE || open == (ends[1] != NONE) {
                continue;
            }
            let mut line = vec![point(start)];
            done[start] = true;
            let mut at = ends[0];
            while at != NONE && !done[at] {
                done[at] = true;
                line.push(point(at));
                let [a, b] = next[at];
                at = if a != NONE && !done[a] { a } else { b };
            }
            if !open {
                line.push(line[0]);
            }
            lines.push(line);
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::super::plane::Area;
    use super::*;

    fn grid(f: impl Fn(Vec2) -> f64) -> Grid {
        let area = Area {
            min: Vec2::splat(-10.0),
            max: Vec2::splat(10.0),
        };
        Grid::sample(area, 0.25, f, &|| true).expect("a grid")
    }

    #[test]
    fn a_cone_has_one_closed_circle_for_each_level() {
        let grid = grid(|p| p.length());
        for contour in contours(&grid, &[2.0, 5.0, 9.0]) {
            assert_eq!(contour.lines.len(), 1);
            let line = &contour.lines[0];
            assert_eq!(line.first(), line.last());
            for p in line {
                assert!((p.length() - contour.level).abs() < 0.02, "{p}");
            }
            let length: f64 = line.windows(2).map(|w| w[0].distance(w[1])).sum();
            assert!((length / (std::f64::consts::TAU * contour.level) - 1.0).abs() < 0.01);
        }
    }

    #[test]
    fn a_slope_has_one_open_line_from_border_to_border() {
        let found = contours(&grid(|p| p.x + 0.3 * p.y), &[1.1]);
        assert_eq!(found[0].lines.len(), 1);
        let line = &found[0].lines[0];
        let (a, b) = (line[0], line[line.len() - 1]);
        assert_eq!(a.y.abs(), 10.0);
        assert_eq!(b.y.abs(), 10.0);
        for p in line {
            assert!((p.x + 0.3 * p.y - 1.1).abs() < 1e-9);
        }
    }

    #[test]
    fn a_saddle_joins_no_line_to_another() {
        let found = contours(&grid(|p| p.x * p.y + 1e-3), &[0.0]);
        let points: usize = found[0].lines.iter().map(Vec::len).sum();
        assert!(
            found[0].lines.len() == 2 && points > 100,
            "{}",
            found[0].lines.len()
        );
    }

    #[test]
    fn holes_and_levels_out_of_reach_have_no_line() {
        let holed = grid(|p| if p.x > 0.0 { f64::NAN } else { p.x });
        let found = contours(&holed, &[-5.0, 5.0]);
        assert_eq!((found[0].lines.len(), found[1].lines.len()), (1, 0));
    }

    #[test]
    fn levels_are_round_and_a_flat_field_has_none() {
        let (list, step) = levels(87.3, 121.0, 8.0);
        assert_eq!(step, 5.0);
        assert_eq!(list, [90.0, 95.0, 100.0, 105.0, 110.0, 115.0, 120.0]);
        assert!(levels(3.0, 3.0, 8.0).0.is_empty());
        assert!(levels(f64::NAN, 3.0, 8.0).0.is_empty());
    }
}
