//! Fills the outline with triangles that are near equilateral on the surface.
//!
//! The back is unrolled row by row: `s` is the length along the skin from the midline at one height `y`. In the plane
//! (s, y) a lattice of equilateral triangles fills the inside; a constrained Delaunay triangulation joins it to the rim.

use super::Heights;
use super::rim::{Rim, length, resampled};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation as _};

/// A filled outline.
pub(super) struct Filled {
    /// x and y of every vertex, mm.
    pub(super) places: Vec<(f64, f64)>,
    /// Counter-clockwise seen from behind.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Lattice points nearer to the rim than this share of the spacing are left out: the triangles between would be flat.
const CLEARANCE: f64 = 0.62;

/// Fills `rim` with `wanted` triangles.
pub(super) fn fill(heights: &Heights, rim: &Rim, wanted: usize) -> Filled {
    let unrolled = Unrolled::new(heights);
    let outline: Vec<(f64, f64)> = rim
        .points
        .iter()
        .map(|&(x, y)| (unrolled.s_of(x, y), y))
        .collect();
    let (lattice, n_rim) = choose(&outline, wanted);
    let rows = lattice.rows(&outline);
    let rim_places = resampled(&outline, n_rim);
    let mut places: Vec<(f64, f64)> = rows
        .iter()
        .flat_map(|r| r.columns().map(|k| lattice.place(r.row, k)))
        .collect();
    let n_inside = places.len();
    places.extend(rim_places);
    let mut triangles = lattice_triangles(&rows);
    let band = band_triangles(&places, n_inside, &triangles);
    triangles.extend(band);
    unrolled.roll_up(&mut places);
    Filled { places, triangles }
}

/// The lattice and the number of rim points that give `wanted` triangles.
///
/// A triangulation with `i` points inside and `b` on the rim has 2 i + b − 2 triangles. The inside count falls in steps as
/// the spacing grows; the rim takes up the rest, within a bound, so that its points stay about as dense as the inside.
fn choose(outline: &[(f64, f64)], wanted: usize) -> (Lattice, usize) {
    let rim_length = length(outline);
    let area = area(outline);
    let surplus = |spacing: f64| {
        let inside = Lattice { spacing }.count(outline) as f64;
        let natural = rim_length / spacing;
        (wanted as f64 + 2.0 - 2.0 * inside, natural)
    };
    let guess = (area / wanted as f64 * 4.0 / 3.0_f64.sqrt()).sqrt();
    let (mut fine, mut coarse) = (guess * 0.7, guess * 1.4);
    let mut best = (f64::INFINITY, guess, 3.0);
    for _ in 0..48 {
        let spacing = (fine * coarse).sqrt();
        let (rim, natural) = surplus(spacing);
        let misfit = (rim - natural).abs() / natural;
        if misfit < best.0 {
            best = (misfit, spacing, rim.clamp(0.8 * natural, 1.25 * natural));
        }
        if rim > natural {
            coarse = spacing
        } else {
            fine = spacing
        }
    }
    (
        Lattice { spacing: best.1 },
        best.2.round().max(3.0) as usize,
    )
}

fn area(outline: &[(f64, f64)]) -> f64 {
    let n = outline.len();
    let twice: f64 = (0..n)
        .map(|i| {
            let (p, q) = (outline[i], outline[(i + 1) % n]);
            p.0 * q.1 - q.0 * p.1
        })
        .sum();
    twice.abs() / 2.0
}

/// Rows of points `spacing` apart; odd rows are shifted by half of it. Row 0 lies on y = 0, column 0 on the midline.
#[derive(Clone, Copy, Debug)]
struct Lattice {
    spacing: f64,
}

/// The columns of one row that are inside the outline and clear of it, as whole runs.
#[derive(Clone, Debug)]
struct Row {
    row: i64,
    runs: Vec<(i64, i64)>,
    /// Index of the first point of each run among all points.
    first: Vec<u32>,
}

impl Row {
    fn columns(&self) -> impl Iterator<Item = i64> + '_ {
        self.runs.iter().flat_map(|&(a, b)| a..=b)
    }

    fn index(&self, column: i64) -> Option<u32> {
        let run = self
            .runs
            .iter()
            .position(|&(a, b)| (a..=b).contains(&column))?;
        Some(self.first[run] + (column - self.runs[run].0) as u32)
    }
}

impl Lattice {
    fn height(self) -> f64 {
        self.spacing * 0.75_f64.sqrt()
    }

    fn shift(self, row: i64) -> f64 {
        if row.rem_euclid(2) == 1 {
            self.spacing / 2.0
        } else {
            0.0
        }
    }

    fn place(self, row: i64, column: i64) -> (f64, f64) {
        (
            column as f64 * self.spacing + self.shift(row),
            row as f64 * self.height(),
        )
    }

    fn count(self, outline: &[(f64, f64)]) -> usize {
        self.rows(outline)
            .iter()
            .map(|r| {
                r.runs
                    .iter()
                    .map(|&(a, b)| (b - a + 1) as usize)
                    .sum::<usize>()
            })
            .sum()
    }

    /// Every row with its points, from the bottom up.
    fn rows(self, outline: &[(f64, f64)]) -> Vec<Row> {
        let clearance = CLEARANCE * self.spacing;
        let (low, high) = outline
            .iter()
            .fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p.1), h.max(p.1)));
        let first_row = (low / self.height()).floor() as i64;
        let n_rows = ((high / self.height()).ceil() as i64 - first_row + 1).max(0) as usize;
        // What each stretch of the outline does to each row: where it crosses, and which points it is too close to.
        let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); n_rows];
        let mut blocked: Vec<Vec<(f64, f64)>> = vec![Vec::new(); n_rows];
        for i in 0..outline.len() {
            let (p, q) = (outline[i], outline[(i + 1) % outline.len()]);
            let (below, above) = (p.1.min(q.1) - clearance, p.1.max(q.1) + clearance);
            let from = ((below / self.height()).ceil() as i64 - first_row).max(0) as usize;
            for row in from..n_rows {
                let y = (first_row + row as i64) as f64 * self.height();
                if y > above {
                    break;
                }
                if (p.1 <= y) != (q.1 <= y) {
                    crossings[row].push(p.0 + (q.0 - p.0) * (y - p.1) / (q.1 - p.1));
                }
                blocked[row].extend(capsule_on_line(p, q, clearance, y));
            }
        }
        let mut out = Vec::with_capacity(n_rows);
        let mut next = 0_u32;
        for row in 0..n_rows {
            let number = first_row + row as i64;
            let mut runs = Vec::new();
            crossings[row].sort_by(f64::total_cmp);
            blocked[row].sort_by(|a, b| a.0.total_cmp(&b.0));
            for inside in crossings[row].chunks_exact(2) {
                self.add_runs(number, (inside[0], inside[1]), &blocked[row], &mut runs);
            }
            let mut first = Vec::with_capacity(runs.len());
            for &(a, b) in &runs {
                first.push(next);
                next += (b - a + 1) as u32;
            }
            if !runs.is_empty() {
                out.push(Row {
                    row: number,
                    runs,
                    first,
                });
            }
        }
        out
    }

    /// The columns strictly between `inside.0` and `inside.1` and outside of every blocked stretch (sorted by its start).
    fn add_runs(
        self,
        row: i64,
        inside: (f64, f64),
        blocked: &[(f64, f64)],
        runs: &mut Vec<(i64, i64)>,
    ) {
        let column = |s: f64| (s - self.shift(row)) / self.spacing;
        let mut start = inside.0;
        let mut free = |from: f64, to: f64| {
            let (a, b) = (
                column(from).floor() as i64 + 1,
                column(to).ceil() as i64 - 1,
            );
            if from < to && a <= b {
                runs.push((a, b));
            }
        };
        for &(a, b) in blocked {
            if a >= inside.1 {
                break;
            }
            free(start, a);
            start = start.max(b);
        }
        free(start, inside.1);
    }
}

/// Where the line at height `y` runs within `radius` of the segment `p`–`q`.
fn capsule_on_line(p: (f64, f64), q: (f64, f64), radius: f64, y: f64) -> Option<(f64, f64)> {
    let mut reach: Option<(f64, f64)> = None;
    let mut add = |a: f64, b: f64| {
        reach = Some(reach.map_or((a.min(b), a.max(b)), |(l, h)| {
            (l.min(a).min(b), h.max(a).max(b))
        }));
    };
    for c in [p, q] {
        let dy = y - c.1;
        if dy.abs() <= radius {
            let half = (radius * radius - dy * dy).sqrt();
            add(c.0 - half, c.0 + half);
        }
    }
    let (dx, dy) = (q.0 - p.0, q.1 - p.1);
    let edge = (dx * dx + dy * dy).sqrt();
    if edge > 0.0 {
        let (nx, ny) = (-dy / edge * radius, dx / edge * radius);
        for sign in [-1.0, 1.0] {
            let (a, b) = (
                (p.0 + sign * nx, p.1 + sign * ny),
                (q.0 + sign * nx, q.1 + sign * ny),
            );
            if (a.1 <= y) != (b.1 <= y) {
                let s = a.0 + (b.0 - a.0) * (y - a.1) / (b.1 - a.1);
                add(s, s);
            }
        }
    }
    reach
}

/// The triangles whose three corners are lattice points.
fn lattice_triangles(rows: &[Row]) -> Vec<[u32; 3]> {
    let mut out = Vec::new();
    for pair in rows.windows(2) {
        let [low, high] = pair else { continue };
        if high.row != low.row + 1 {
            continue;
        }
        // Above the gap between columns k and k + 1 of the lower row stands column k + up of the upper one.
        let up = if low.row.rem_euclid(2) == 1 { 1 } else { 0 };
        for k in low.columns() {
            let (a, b) = (low.index(k), low.index(k + 1));
            let (c, d) = (high.index(k + up), high.index(k + up - 1));
            if let (Some(a), Some(b), Some(c)) = (a, b, c) {
                out.push([a, b, c]);
            }
            if let (Some(a), Some(c), Some(d)) = (a, c, d) {
                out.push([a, c, d]);
            }
        }
    }
    out
}

/// The triangles between the rim (the points from `n_inside` on) and the filled inside.
fn band_triangles(places: &[(f64, f64)], n_inside: usize, inside: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let border = border_edges(n_inside, inside);
    let mut used = vec![false; n_inside];
    for v in inside.iter().flatten() {
        used[*v as usize] = true;
    }
    let mut on_border = vec![false; n_inside];
    for &(a, b) in &border {
        on_border[a as usize] = true;
        on_border[b as usize] = true;
    }
    // Indices of the points that take part; the handle of each is its place in this list.
    let taking_part: Vec<u32> = (0..places.len() as u32)
        .filter(|&v| v as usize >= n_inside || on_border[v as usize] || !used[v as usize])
        .collect();
    let mut handle_of = vec![u32::MAX; places.len()];
    for (handle, &v) in taking_part.iter().enumerate() {
        handle_of[v as usize] = handle as u32;
    }
    let n_rim = (places.len() - n_inside) as u32;
    let rim = (0..n_rim).map(|i| (n_inside as u32 + i, n_inside as u32 + (i + 1) % n_rim));
    let edges: Vec<[usize; 2]> = rim
        .chain(border.iter().copied())
        .map(|(a, b)| {
            [
                handle_of[a as usize] as usize,
                handle_of[b as usize] as usize,
            ]
        })
        .collect();
    let points: Vec<Point2<f64>> = taking_part
        .iter()
        .map(|&v| places[v as usize])
        .map(|(x, y)| Point2::new(x, y))
        .collect();
    // The input is made here: finite, distinct, its edges do not cross. Were it refused, the back would lack its band,
    // which the tests of every size would see.
    let Ok(net) = ConstrainedDelaunayTriangulation::<Point2<f64>>::bulk_load_cdt(points, edges)
    else {
        return Vec::new();
    };
    // The band is what can be reached from the inner side of the rim without crossing a fixed edge.
    let n_faces = net.num_all_faces();
    let mut seen = vec![false; n_faces];
    let mut open = Vec::new();
    for i in 0..n_rim {
        let (a, b) = (n_inside as u32 + i, n_inside as u32 + (i + 1) % n_rim);
        let at =
            |v: u32| spade::handles::FixedVertexHandle::from_index(handle_of[v as usize] as usize);
        if let Some(edge) = net.get_edge_from_neighbors(at(a), at(b))
            && let Some(face) = edge.face().as_inner()
        {
            open.push(face.fix());
        }
    }
    while let Some(face) = open.pop() {
        if std::mem::replace(&mut seen[face.index()], true) {
            continue;
        }
        for edge in net.face(face).adjacent_edges() {
            if !edge.is_constraint_edge()
                && let Some(next) = edge.rev().face().as_inner()
            {
                open.push(next.fix());
            }
        }
    }
    net.inner_faces()
        .filter(|f| seen[f.fix().index()])
        .map(|f| f.vertices().map(|v| taking_part[v.fix().index()]))
        .collect()
}

/// The edges that only one triangle has, as that triangle runs them.
fn border_edges(n_vertices: usize, triangles: &[[u32; 3]]) -> Vec<(u32, u32)> {
    // Each vertex has at most six neighbours in the lattice: one short list per lower end of an edge.
    let mut edges: Vec<[(u32, i8); 4]> = vec![[(u32::MAX, 0); 4]; n_vertices];
    for t in triangles {
        for i in 0..3 {
            let (a, b) = (t[i], t[(i + 1) % 3]);
            let (low, high, way) = if a < b { (a, b, 1) } else { (b, a, -1) };
            let slots = &mut edges[low as usize];
            if let Some(slot) = slots.iter_mut().find(|s| s.0 == high || s.0 == u32::MAX) {
                *slot = (high, slot.1 + way);
            }
        }
    }
    let mut out = Vec::new();
    for (low, slots) in edges.iter().enumerate() {
        for &(high, way) in slots {
            match way {
                1 => out.push((low as u32, high)),
                -1 => out.push((high, low as u32)),
                _ => {}
            }
        }
    }
    out
}

/// Length along the skin, tabulated row by row.
struct Unrolled {
    /// `s` of each x, for each row of the table.
    table: Vec<Vec<f64>>,
}

const TABLE_STEP_X_MM: f64 = 1.0;
const TABLE_STEP_Y_MM: f64 = 4.0;
/// Reach of the table, mm: past the rim everywhere.
const TABLE_X_MM: f64 = 190.0;
const TABLE_Y_MM: (f64, f64) = (-8.0, 488.0);

impl Unrolled {
    fn new(heights: &Heights) -> Self {
        let half = (TABLE_X_MM / TABLE_STEP_X_MM) as usize;
        let n_rows = ((TABLE_Y_MM.1 - TABLE_Y_MM.0) / TABLE_STEP_Y_MM) as usize + 1;
        let table = (0..n_rows)
            .map(|row| {
                let y = TABLE_Y_MM.0 + row as f64 * TABLE_STEP_Y_MM;
                let z: Vec<f64> = (0..=2 * half)
                    .map(|i| heights.at((i as f64 - half as f64) * TABLE_STEP_X_MM, y))
                    .collect();
                let mut s = vec![0.0; 2 * half + 1];
                let arc =
                    |a: f64, b: f64| (TABLE_STEP_X_MM * TABLE_STEP_X_MM + (b - a) * (b - a)).sqrt();
                for i in half..2 * half {
                    s[i + 1] = s[i] + arc(z[i], z[i + 1]);
                }
                for i in (0..half).rev() {
                    s[i] = s[i + 1] - arc(z[i], z[i + 1]);
                }
                s
            })
            .collect();
        Self { table }
    }

    /// The two table rows around `y`, and how far `y` lies from the first to the second.
    fn rows(&self, y: f64) -> (&[f64], &[f64], f64) {
        let v = ((y - TABLE_Y_MM.0) / TABLE_STEP_Y_MM).clamp(0.0, (self.table.len() - 1) as f64);
        let i = (v as usize).min(self.table.len() - 2);
        (&self.table[i], &self.table[i + 1], v - i as f64)
    }

    fn s_of(&self, x: f64, y: f64) -> f64 {
        let (low, high, t) = self.rows(y);
        let u = ((x + TABLE_X_MM) / TABLE_STEP_X_MM).clamp(0.0, (low.len() - 1) as f64);
        let i = (u as usize).min(low.len() - 2);
        let at = |i: usize| low[i] + (high[i] - low[i]) * t;
        at(i) + (at(i + 1) - at(i)) * (u - i as f64)
    }

    /// Turns every (s, y) into (x, y).
    fn roll_up(&self, places: &mut [(f64, f64)]) {
        for p in places {
            let (low, high, t) = self.rows(p.1);
            let at = |i: usize| low[i] + (high[i] - low[i]) * t;
            let (mut a, mut b) = (0, low.len() - 1);
            while b - a > 1 {
                let middle = (a + b) / 2;
                if at(middle) <= p.0 {
                    a = middle
                } else {
                    b = middle
                }
            }
            let u = a as f64 + (p.0 - at(a)) / (at(b) - at(a));
            p.0 = u * TABLE_STEP_X_MM - TABLE_X_MM;
        }
    }
}
