//! Dynamic time warping: the alignment of two traces under which they differ least.
//!
//! Sakoe & Chiba 1978 (IEEE Trans ASSP 26:43), steps (1, 0), (0, 1), (1, 1) of equal weight, both ends matched, within a band
//! round the straight line from end to end. The distance of two samples goes by position, force and depth, each over its
//! standard deviation in both recordings, so that none outweighs the others. Memory is two rows of costs and one byte a cell of
//! the band.

use super::trace::Trace;

/// Most samples of either trace that are warped: longer ones are thinned.
pub const MOST_WARPED: usize = 6000;
/// Least half width of the band, samples.
const LEAST_BAND: usize = 10;

/// Pairs of samples in order, from both first to both last; each step goes on by at most one in either.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Warp {
    /// Numbers in the first and the second trace.
    pub pairs: Vec<[u32; 2]>,
    /// Sum of the distances, in standard deviations.
    pub cost: f64,
}

/// Aligns `a` and `b` inside a band of `band`, a share of the longer one's length. `None` where either has no sample.
pub fn warp(a: &Trace, b: &Trace, band: f64) -> Option<Warp> {
    let (n, m) = (a.len(), b.len());
    if n == 0 || m == 0 {
        return None;
    }
    let scale = scales(a, b);
    let distance = |i: usize, j: usize| -> f64 {
        let mut sum = 0.0;
        for axis in 0..3 {
            let d = f64::from(a.position_mm[i][axis]) - f64::from(b.position_mm[j][axis]);
            sum += d * d * scale[0];
        }
        let force = f64::from(a.force_n[i]) - f64::from(b.force_n[j]);
        let depth = f64::from(a.depth_mm[i]) - f64::from(b.depth_mm[j]);
        (sum + force * force * scale[1] + depth * depth * scale[2]).sqrt()
    };
    let slope = if n > 1 {
        (m - 1) as f64 / (n - 1) as f64
    } else {
        0.0
    };
    let share = if band.is_finite() {
        band.clamp(0.0, 1.0)
    } else {
        1.0
    };
    // A band narrower than a step along the line would be cut through; a single row or column needs all of the other.
    let mut half = ((share * n.max(m) as f64) as usize)
        .max(LEAST_BAND)
        .max(slope as usize + 1);
    if n == 1 {
        half = m;
    }
    let range = |i: usize| {
        let middle = (i as f64 * slope).round() as usize;
        (middle.saturating_sub(half), (middle + half).min(m - 1))
    };
    let width = (2 * half + 1).min(m);
    let mut from: Vec<u8> = vec![0; n * width];
    let (mut before, mut now) = (vec![f64::INFINITY; m], vec![f64::INFINITY; m]);
    for i in 0..n {
        let (low, high) = range(i);
        now.fill(f64::INFINITY);
        for j in low..=high {
            let (best, step) = if i == 0 && j == 0 {
                (0.0, 0)
            } else {
                let diagonal = if j > 0 { before[j - 1] } else { f64::INFINITY };
                let up = before[j];
                let left = if j > 0 { now[j - 1] } else { f64::INFINITY };
                // Of equals the diagonal: the same recording is aligned with itself tick by tick.
                if diagonal <= up && diagonal <= left {
                    (diagonal, 0)
                } else if up <= left {
                    (up, 1)
                } else {
                    (left, 2)
                }
            };
            now[j] = best + distance(i, j);
            from[i * width + j - low] = step;
        }
        std::mem::swap(&mut before, &mut now);
    }
    let cost = before[m - 1];
    let (mut i, mut j) = (n - 1, m - 1);
    let mut pairs = vec![[i as u32, j as u32]];
    while i > 0 || j > 0 {
        let (low, _) = range(i);
        let step = if i == 0 {
            2
        } else {
            from[i * width + j.saturating_sub(low)]
        };
        match step {
            0 => (i, j) = (i - 1, j.saturating_sub(1)),
            1 => i -= 1,
            _ => j -= 1,
        }
        pairs.push([i as u32, j as u32]);
    }
    pairs.reverse();
    cost.is_finite().then_some(Warp { pairs, cost })
}

/// One over the variance of position (all axes together), force and depth in both traces; 0 for what does not vary.
fn scales(a: &Trace, b: &Trace) -> [f64; 3] {
    let inverse = |variance: f64| {
        if variance > 1e-12 {
            1.0 / variance
        } else {
            0.0
        }
    };
    let variance = |values: &mut dyn Iterator<Item = f64>| {
        let (mut n, mut mean, mut squares) = (0.0, 0.0, 0.0);
        for x in values {
            n += 1.0;
            let off = x - mean;
            mean += off / n;
            squares += off * (x - mean);
        }
        squares / f64::max(n, 1.0)
    };
    let axis = |axis: usize| {
        let both = a.position_mm.iter().chain(&b.position_mm);
        variance(&mut both.map(|p| f64::from(p[axis])))
    };
    let plain = |a: &[f32], b: &[f32]| variance(&mut a.iter().chain(b).map(|x| f64::from(*x)));
    [
        inverse(axis(0) + axis(1) + axis(2)),
        inverse(plain(&a.force_n, &b.force_n)),
        inverse(plain(&a.depth_mm, &b.depth_mm)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(force: &[f64]) -> Trace {
        Trace {
            rate_hz: 50.0,
            position_mm: force.iter().map(|f| [3.0 * *f as f32, 0.0, 1.0]).collect(),
            force_n: force.iter().map(|f| *f as f32).collect(),
            depth_mm: force.iter().map(|f| 2.0 * *f as f32).collect(),
        }
    }

    fn cost(a: &Trace, b: &Trace, pairs: &[[u32; 2]]) -> f64 {
        let s = scales(a, b);
        let of = |[i, j]: &[u32; 2]| {
            let f = f64::from(a.force_n[*i as usize]) - f64::from(b.force_n[*j as usize]);
            (f * f * (9.0 * s[0] + s[1] + 4.0 * s[2])).sqrt()
        };
        pairs.iter().map(of).sum()
    }

    /// Every path there is.
    fn brute(a: &Trace, b: &Trace, path: &mut Vec<[u32; 2]>) -> f64 {
        let [i, j] = path[path.len() - 1];
        let (n, m) = (a.len() as u32, b.len() as u32);
        if (i, j) == (n - 1, m - 1) {
            return cost(a, b, path);
        }
        let mut best = f64::INFINITY;
        for [di, dj] in [[1, 1], [1, 0], [0, 1]] {
            if i + di < n && j + dj < m {
                path.push([i + di, j + dj]);
                best = best.min(brute(a, b, path));
                path.pop();
            }
        }
        best
    }

    #[test]
    fn the_path_is_the_cheapest_of_all() {
        let mut random = crate::training::random::Random::new(3);
        for _ in 0..20 {
            let mut draw = |n: usize| trace(&(0..n).map(|_| random.unit()).collect::<Vec<_>>());
            let (a, b) = (draw(7), draw(6));
            let warp = warp(&a, &b, 1.0).expect("a path");
            let wanted = brute(&a, &b, &mut vec![[0, 0]]);
            assert!((warp.cost - wanted).abs() < 1e-6, "{} {wanted}", warp.cost);
            assert!((cost(&a, &b, &warp.pairs) - wanted).abs() < 1e-6);
        }
    }

    #[test]
    fn a_delayed_copy_is_found_again_and_the_same_is_the_diagonal() {
        let wave = |i: i32, by: i32| {
            if i < by {
                0.0
            } else {
                libm::sin(0.05 * f64::from(i - by)).max(0.0)
            }
        };
        let a = trace(&(0..600).map(|i| wave(i, 40)).collect::<Vec<_>>());
        let b = trace(&(0..600).map(|i| wave(i, 70)).collect::<Vec<_>>());
        let warp_ab = warp(&a, &b, 0.1).expect("a path");
        let shifted = warp_ab
            .pairs
            .iter()
            .filter(|[i, j]| j.abs_diff(*i) == 30 && *i > 60 && *i < 500)
            .count();
        assert!(shifted > 150, "{shifted}");
        assert!(
            warp_ab
                .pairs
                .windows(2)
                .all(|p| p[1][0] - p[0][0] <= 1 && p[1][1] - p[0][1] <= 1)
        );
        let same = warp(&a, &a, 0.1).expect("a path");
        assert!(same.cost == 0.0 && same.pairs.iter().all(|[i, j]| i == j));
        assert_eq!(warp(&a, &trace(&[]), 0.1), None);
        let one = warp(&trace(&[1.0]), &a, 0.0).expect("a path");
        assert_eq!(one.pairs.len(), 600);
        let one = warp(&a, &trace(&[1.0]), 0.0).expect("a path");
        assert_eq!(one.pairs.len(), 600);
    }
}
