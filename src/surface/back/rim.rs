//! The outline of the back on the map plane: a smooth closed curve.

use super::Heights;

/// The outline, counter-clockwise seen from behind, as a closed polygon with a point about every millimetre.
#[derive(Clone, Debug)]
pub(super) struct Rim {
    /// x and y, mm; the last point joins the first.
    pub(super) points: Vec<(f64, f64)>,
}

/// The flanks end where the back has fallen to this height, mm: below it the side of the trunk begins.
const FLANK_HEIGHT_MM: f64 = 42.0;
/// The arms are cut off here, mm.
const WIDEST_MM: f64 = 178.0;
/// Lower and upper end, mm.
const ENDS_MM: (f64, f64) = (2.0, 474.0);
/// Spacing of the points, mm.
const SPACING_MM: f64 = 1.0;
/// Standard deviation of the smoothing along the outline, mm: rounds the corners where flanks meet the ends.
const SMOOTHING_MM: f64 = 11.0;

impl Rim {
    pub(super) fn new(heights: &Heights) -> Self {
        let (low, high) = ENDS_MM;
        let n = ((high - low) / 2.0) as usize;
        let level = |i: usize| low + (high - low) * i as f64 / n as f64;
        let mut corners = Vec::with_capacity(2 * n + 2);
        corners.extend((0..=n).map(|i| (half_width_mm(heights, level(i), 1.0), level(i))));
        corners.extend(
            (0..=n)
                .rev()
                .map(|i| (-half_width_mm(heights, level(i), -1.0), level(i))),
        );
        let even = resampled(
            &corners,
            (length(&corners) / SPACING_MM).round().max(3.0) as usize,
        );
        let points = smoothed(&even, SMOOTHING_MM / SPACING_MM);
        Self { points }
    }
}

/// Where the flank falls to [`FLANK_HEIGHT_MM`], mm from the midline.
fn half_width_mm(heights: &Heights, y_mm: f64, sign: f64) -> f64 {
    const STEP_MM: f64 = 0.5;
    let mut x = 40.0;
    while x < WIDEST_MM && heights.at(sign * x, y_mm) > FLANK_HEIGHT_MM {
        x += STEP_MM;
    }
    x.min(WIDEST_MM)
}

/// Length of a closed polygon.
pub(super) fn length(points: &[(f64, f64)]) -> f64 {
    (0..points.len())
        .map(|i| distance(points[i], points[(i + 1) % points.len()]))
        .sum()
}

/// `n` points at equal distances along a closed polygon, from its first point.
pub(super) fn resampled(points: &[(f64, f64)], n: usize) -> Vec<(f64, f64)> {
    let step = length(points) / n as f64;
    let mut out = Vec::with_capacity(n);
    let (mut i, mut walked) = (0, 0.0);
    for k in 0..n {
        let wanted = k as f64 * step;
        loop {
            let (a, b) = (points[i % points.len()], points[(i + 1) % points.len()]);
            let edge = distance(a, b);
            if walked + edge >= wanted || i >= points.len() {
                let t = if edge > 0.0 {
                    ((wanted - walked) / edge).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                out.push((a.0 + (b.0 - a.0) * t, a.1 + (b.1 - a.1) * t));
                break;
            }
            walked += edge;
            i += 1;
        }
    }
    out
}

/// A closed curve after Gaussian smoothing with a standard deviation given in points.
fn smoothed(points: &[(f64, f64)], sd: f64) -> Vec<(f64, f64)> {
    let reach = (4.0 * sd).ceil() as isize;
    let kernel: Vec<f64> = (-reach..=reach)
        .map(|k| libm::exp(-0.5 * (k as f64 / sd) * (k as f64 / sd)))
        .collect();
    let total: f64 = kernel.iter().sum();
    let n = points.len() as isize;
    (0..n)
        .map(|i| {
            let (mut x, mut y) = (0.0, 0.0);
            for (w, k) in kernel.iter().zip(-reach..) {
                let p = points[(i + k).rem_euclid(n) as usize];
                x += w * p.0;
                y += w * p.1;
            }
            (x / total, y / total)
        })
        .collect()
}

fn distance(a: (f64, f64), b: (f64, f64)) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    (dx * dx + dy * dy).sqrt()
}
