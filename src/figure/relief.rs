//! How hollow or raised the skin is: what makes furrows, shoulder blades and dents read at a glance.
//!
//! At a point p with normal n, the mean height of the seen surface round p above the tangent plane, n · (mean q − p), is
//! positive in a hollow and negative on a ridge. On a paraboloid z = r² ∕ 2R it grows with the square of the window, so it
//! is given per mm of window. The mean is taken in the picture over what is seen there, as Luft, Colditz & Deussen (2006)
//! do with depth alone; with places instead of depths a slope, or a window cut off at an outline, is no hollow.

use crate::geom::Vec3;

/// What one pixel sees of the skin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub position_mm: Vec3,
    pub normal: Vec3,
}

/// Hollowness of every pixel, mm per mm of window, 0 where no skin is seen. The window is about `radius_px` to each side,
/// which is `radius_mm` at the skin.
pub(super) fn hollowness(
    spots: &[Option<Spot>],
    width: usize,
    radius_px: f64,
    radius_mm: f64,
) -> Vec<f64> {
    if width == 0 {
        return Vec::new();
    }
    // Two boxes of half the width make a tent as wide as asked for; the third smooths what the mesh's facets leave.
    let half = ((radius_px / 2.0).round().clamp(1.0, width as f64)) as usize;
    let mut sums: Vec<Sum> = spots
        .iter()
        .map(|s| {
            s.map_or(Sum::default(), |s| Sum {
                total: s.position_mm,
                count: 1.0,
            })
        })
        .collect();
    for _ in 0..2 {
        sums = box_sums(&sums, width, half);
    }
    let raw: Vec<Sum> = spots
        .iter()
        .zip(&sums)
        .map(|(spot, sum)| match spot {
            Some(s) if sum.count > 0.0 => Sum {
                total: Vec3::X * (s.normal.dot(sum.total / sum.count - s.position_mm) / radius_mm),
                count: 1.0,
            },
            _ => Sum::default(),
        })
        .collect();
    box_sums(&raw, width, half.div_ceil(2))
        .iter()
        .zip(&raw)
        .map(|(smooth, raw)| {
            if raw.count > 0.0 && smooth.count > 0.0 {
                smooth.total.x / smooth.count
            } else {
                0.0
            }
        })
        .collect()
}

#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    total: Vec3,
    count: f64,
}

impl Sum {
    fn add(&mut self, other: &Self) {
        self.total += other.total;
        self.count += other.count;
    }

    fn take(&mut self, other: &Self) {
        self.total -= other.total;
        self.count -= other.count;
    }
}

/// Means over a square window of `2 · half + 1` pixels, cut off at the border, up to a common factor: sums along rows, then
/// along columns.
///
/// The counts are scaled back to at most 1 so that pixel values do not grow from pass to pass.
fn box_sums(values: &[Sum], width: usize, half: usize) -> Vec<Sum> {
    let height = values.len() / width;
    let scale = 1.0 / ((2 * half + 1) as f64 * (2 * half + 1) as f64);
    let mut rows = vec![Sum::default(); values.len()];
    for (row, out) in values.chunks(width).zip(rows.chunks_mut(width)) {
        let mut sum = Sum::default();
        row.iter().take(half).for_each(|v| sum.add(v));
        for (column, out) in out.iter_mut().enumerate() {
            if let Some(v) = row.get(column + half) {
                sum.add(v);
            }
            if let Some(v) = column.checked_sub(half + 1) {
                sum.take(&row[v]);
            }
            *out = sum;
        }
    }
    let mut sums = vec![Sum::default(); width];
    let mut out = vec![Sum::default(); values.len()];
    let row_at = |row: usize| rows.get(row * width..(row + 1) * width);
    for row in 0..half.min(height) {
        let added = row_at(row).into_iter().flatten();
        sums.iter_mut().zip(added).for_each(|(s, v)| s.add(v));
    }
    for (row, out) in out.chunks_mut(width).enumerate() {
        let added = row_at(row + half).into_iter().flatten();
        sums.iter_mut().zip(added).for_each(|(s, v)| s.add(v));
        if let Some(gone) = row.checked_sub(half + 1) {
            let taken = row_at(gone).into_iter().flatten();
            sums.iter_mut().zip(taken).for_each(|(s, v)| s.take(v));
        }
        for (out, s) in out.iter_mut().zip(&sums) {
            // Running sums leave crumbs where nothing is left to sum.
            if s.count > 0.5 * scale {
                *out = Sum {
                    total: s.total * scale,
                    count: s.count * scale,
                };
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One spot per mm over a height field given with its slope.
    fn spots(n: usize, height: impl Fn(f64, f64) -> (f64, f64, f64)) -> Vec<Option<Spot>> {
        (0..n * n)
            .map(|i| {
                let (x, y) = ((i % n) as f64, (i / n) as f64);
                let (z, by_x, by_y) = height(x, y);
                Some(Spot {
                    position_mm: Vec3::new(x, y, z),
                    normal: crate::geom::unit_or(Vec3::new(-by_x, -by_y, 1.0), Vec3::Z),
                })
            })
            .collect()
    }

    #[test]
    fn a_slope_is_no_hollow_even_at_its_border() {
        let found = hollowness(
            &spots(60, |x, y| (0.7 * x - 0.4 * y, 0.7, -0.4)),
            60,
            12.0,
            12.0,
        );
        assert!(found.iter().all(|h| h.abs() < 1.0e-12), "{found:?}");
    }

    #[test]
    fn a_bowl_is_as_hollow_as_its_window_says() {
        let (n, radius, curvature) = (121, 12.0, 0.002);
        let bowl = spots(n, |x, y| {
            let (x, y) = (x - 60.0, y - 60.0);
            let z = 0.5 * curvature * (x * x + y * y);
            (z, curvature * x, curvature * y)
        });
        let found = hollowness(&bowl, n, radius, radius)[60 * n + 60];
        // Variance of a box of 13 pixels along each axis, twice, on two axes: the mean of r².
        let mean_r_sq = 4.0 * (13.0 * 13.0 - 1.0) / 12.0;
        let expected = 0.5 * curvature * mean_r_sq / radius;
        assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
    }

    #[test]
    fn what_is_not_seen_counts_for_nothing() {
        let mut half = spots(40, |x, _| (0.3 * x, 0.3, 0.0));
        for (i, spot) in half.iter_mut().enumerate() {
            if i % 40 > 22 {
                *spot = None;
            }
        }
        let found = hollowness(&half, 40, 9.0, 9.0);
        assert!(found.iter().all(|h| h.abs() < 1.0e-12));
        assert!(hollowness(&[], 0, 9.0, 9.0).is_empty());
        assert!(hollowness(&[None], 1, 1.0e9, 9.0) == [0.0]);
        assert!(hollowness(&[None], 1, f64::NAN, 9.0) == [0.0]);
    }
}
