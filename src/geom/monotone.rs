//! Monotone cubic interpolation (Fritsch & Carlson 1980, SIAM J. Numer. Anal. 17(2)).

/// A cubic between each two knots, with a continuous slope, that rises and falls only where the knots do.
///
/// Slopes at inner knots are the mean of the two secants, limited so that α² + β² ≤ 9; where secants differ in sign the
/// knot is a peak and its slope 0. At the ends they follow the parabola through three knots, limited likewise.
#[derive(Clone, Debug, PartialEq)]
pub struct Monotone {
    knots: Vec<Knot>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Knot {
    x: f64,
    y: f64,
    slope: f64,
}

impl Monotone {
    /// Through `points` (x, y). `None` for fewer than two, for x that do not ascend strictly, for what is not finite.
    pub fn new(points: &[(f64, f64)]) -> Option<Self> {
        let secants = secants(points)?;
        let last = secants.len() - 1;
        let slopes = (0..points.len()).map(|i| {
            if i == 0 {
                let step = |i: usize| points[i + 1].0 - points[i].0;
                at_end(secants[0], secants.get(1).map(|s| (*s, step(0), step(1))))
            } else if i > last {
                let step = |i: usize| points[i + 1].0 - points[i].0;
                let before = last
                    .checked_sub(1)
                    .map(|b| (secants[b], step(last), step(b)));
                at_end(secants[last], before)
            } else {
                between(secants[i - 1], secants[i])
            }
        });
        Self::limited(points, slopes.collect(), &secants)
    }

    /// Through `values` at equal steps from 0, one period long; x = `period` is x = 0 again.
    ///
    /// `None` for fewer than two values, a period that is not positive, for what is not finite.
    pub fn periodic(values: &[f64], period: f64) -> Option<Self> {
        let n = values.len();
        let at = |i: usize| (period * i as f64 / n as f64, values[i % n]);
        let points: Vec<_> = (0..=n).filter(|_| n > 1).map(at).collect();
        let secants = secants(&points)?;
        let slopes = (0..=n).map(|i| between(secants[(i + n - 1) % n], secants[i % n]));
        let mut slopes: Vec<f64> = slopes.collect();
        // What limits the slope at the seam from one side limits it on the other.
        limit(&mut slopes, &secants);
        let ends = [slopes[0], slopes[n]];
        let seam = if ends[0].abs() < ends[1].abs() {
            ends[0]
        } else {
            ends[1]
        };
        (slopes[0], slopes[n]) = (seam, seam);
        Self::limited(&points, slopes, &secants)
    }

    fn limited(points: &[(f64, f64)], mut slopes: Vec<f64>, secants: &[f64]) -> Option<Self> {
        limit(&mut slopes, secants);
        let knots = points
            .iter()
            .zip(slopes)
            .map(|(&(x, y), slope)| Knot { x, y, slope });
        let knots: Vec<Knot> = knots.collect();
        knots
            .iter()
            .all(|k| k.slope.is_finite())
            .then_some(Self { knots })
    }

    /// Value at `x`; beyond the ends that of the end. What is no number counts as the first x.
    pub fn at(&self, x: f64) -> f64 {
        Self::value(self.piece(x))
    }

    /// Values at many `xs` that do not descend: no piece is looked for from the start again.
    pub fn at_each(&self, xs: impl Iterator<Item = f64>) -> impl Iterator<Item = f64> {
        let mut i = 1;
        xs.map(move |x| {
            while i + 1 < self.knots.len() && self.knots[i].x <= x {
                i += 1;
            }
            Self::value(self.piece_before(i, x))
        })
    }

    fn value((from, to, t): (Knot, Knot, f64)) -> f64 {
        let step = to.x - from.x;
        let (s, t_sq) = (1.0 - t, t * t);
        let value = s * s * ((1.0 + 2.0 * t) * from.y + t * step * from.slope)
            + t_sq * ((3.0 - 2.0 * t) * to.y - s * step * to.slope);
        // Rounding may go past a knot by a bit.
        value.clamp(from.y.min(to.y), from.y.max(to.y))
    }

    /// Slope dy/dx at `x`; that of the ends beyond them.
    pub fn slope(&self, x: f64) -> f64 {
        let (from, to, t) = self.piece(x);
        let secant = (to.y - from.y) / (to.x - from.x);
        let s = 1.0 - t;
        6.0 * t * s * secant + s * (1.0 - 3.0 * t) * from.slope + t * (3.0 * t - 2.0) * to.slope
    }

    /// Second derivative at `x`, of the piece that begins there, at the last knot of the piece that ends there.
    pub fn curvature(&self, x: f64) -> f64 {
        let (from, to, t) = self.piece(x);
        let step = to.x - from.x;
        let secant = (to.y - from.y) / step;
        ((6.0 - 12.0 * t) * secant + (6.0 * t - 4.0) * from.slope + (6.0 * t - 2.0) * to.slope)
            / step
    }

    /// The knots around `x` and where between them it lies, 0…1.
    fn piece(&self, x: f64) -> (Knot, Knot, f64) {
        let after = self.knots.partition_point(|k| k.x <= x);
        self.piece_before(after.clamp(1, self.knots.len() - 1), x)
    }

    fn piece_before(&self, i: usize, x: f64) -> (Knot, Knot, f64) {
        let (from, to) = (self.knots[i - 1], self.knots[i]);
        let t = (x - from.x) / (to.x - from.x);
        (from, to, if t > 0.0 { t.min(1.0) } else { 0.0 })
    }
}

fn secants(points: &[(f64, f64)]) -> Option<Vec<f64>> {
    let rise = |w: &[(f64, f64)]| {
        let step = w[1].0 - w[0].0;
        (step > 0.0).then(|| (w[1].1 - w[0].1) / step)
    };
    let secants: Vec<f64> = points.windows(2).map(rise).collect::<Option<_>>()?;
    let finite = !secants.is_empty() && secants.iter().all(|s| s.is_finite());
    finite.then_some(secants)
}

fn between(before: f64, after: f64) -> f64 {
    if before * after > 0.0 {
        0.5 * (before + after)
    } else {
        0.0
    }
}

/// The slope at an end: `near` is the secant there; the next one inwards comes with the steps of both.
fn at_end(near: f64, next: Option<(f64, f64, f64)>) -> f64 {
    let Some((far, step, far_step)) = next else {
        return near;
    };
    let parabola = near + (near - far) * step / (step + far_step);
    if parabola * near <= 0.0 {
        0.0
    } else if near * far <= 0.0 && parabola.abs() > 3.0 * near.abs() {
        3.0 * near
    } else {
        parabola
    }
}

/// Shortens pairs of slopes that would make a piece turn.
fn limit(slopes: &mut [f64], secants: &[f64]) {
    for (i, &secant) in secants.iter().enumerate() {
        let (from, to) = (slopes[i], slopes[i + 1]);
        if secant == 0.0 {
            (slopes[i], slopes[i + 1]) = (0.0, 0.0);
            continue;
        }
        let (alpha, beta) = (from / secant, to / secant);
        let length_sq = alpha * alpha + beta * beta;
        if length_sq > 9.0 {
            let tau = 3.0 / length_sq.sqrt();
            (slopes[i], slopes[i + 1]) = (tau * from, tau * to);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn points() -> impl Strategy<Value = Vec<(f64, f64)>> {
        prop::collection::vec((0.01..2.0_f64, -5.0..5.0_f64), 2..12).prop_map(|steps| {
            let mut x = -1.0;
            steps
                .into_iter()
                .map(|(step, y)| {
                    x += step;
                    (x, y)
                })
                .collect()
        })
    }

    proptest! {
        #[test]
        fn it_meets_the_points_and_turns_only_where_they_do(points in points()) {
            let m = Monotone::new(&points).unwrap();
            let xs: Vec<f64> = (-10..200).map(|i| points[0].0 + f64::from(i) * 0.1).collect();
            prop_assert!(m.at_each(xs.iter().copied()).eq(xs.iter().map(|&x| m.at(x))));
            for w in points.windows(2) {
                prop_assert_eq!((m.at(w[0].0), m.at(w[1].0)), (w[0].1, w[1].1));
                let values: Vec<f64> = (0..=100).map(|i| m.at(w[0].0 + (w[1].0 - w[0].0) * f64::from(i) / 100.0)).collect();
                let rises = w[1].1 >= w[0].1;
                for v in values.windows(2) {
                    let step = if rises { v[1] - v[0] } else { v[0] - v[1] };
                    prop_assert!(step >= -1e-12, "{step}");
                }
            }
        }

        #[test]
        fn slope_and_curvature_are_the_derivatives(points in points(), share in 0.0..1.0_f64) {
            let m = Monotone::new(&points).unwrap();
            let (first, last) = (points[0].0, points[points.len() - 1].0);
            let x = first + (last - first) * share;
            let e = 1e-5;
            if points.iter().all(|p| (p.0 - x).abs() > 2.0 * e) && x - e > first && x + e < last {
                let slope = (m.at(x + e) - m.at(x - e)) / (2.0 * e);
                prop_assert!((m.slope(x) - slope).abs() < 1e-4 * (1.0 + slope.abs()), "{} {slope}", m.slope(x));
                let curvature = (m.slope(x + e) - m.slope(x - e)) / (2.0 * e);
                prop_assert!((m.curvature(x) - curvature).abs() < 1e-4 * (1.0 + curvature.abs()));
            }
        }

        #[test]
        fn the_slope_is_continuous_at_knots_and_over_the_seam(values in prop::collection::vec(0.1..9.0_f64, 2..20)) {
            let m = Monotone::periodic(&values, 3.0).unwrap();
            let n = values.len();
            for i in 0..=n {
                let x = 3.0 * i as f64 / n as f64;
                prop_assert_eq!(m.at(x), values[i % n]);
                let (before, after) = (if i == 0 { 3.0 } else { x }, if i == n { 0.0 } else { x });
                let e = 1e-9;
                let jump = (m.slope(before - e) - m.slope(after + e)).abs();
                prop_assert!(jump < 1e-4, "knot {i}: {jump}");
            }
        }
    }

    #[test]
    fn a_line_stays_a_line_and_two_points_make_one() {
        for points in [
            vec![(0.0, 1.0), (0.25, 0.75), (0.4, 0.6), (1.0, 0.0)],
            vec![(0.0, 1.0), (1.0, 0.0)],
        ] {
            let m = Monotone::new(&points).unwrap();
            for i in 0..=20 {
                let x = f64::from(i) / 20.0;
                assert!((m.at(x) - (1.0 - x)).abs() < 1e-15);
                assert!((m.slope(x) + 1.0).abs() < 1e-14 && m.curvature(x).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn what_is_no_function_is_none() {
        for points in [
            &[][..],
            &[(0.0, 1.0)],
            &[(0.0, 1.0), (0.0, 2.0)],
            &[(1.0, 1.0), (0.0, 2.0)],
            &[(0.0, f64::NAN), (1.0, 0.0)],
            &[(0.0, 1.0), (f64::INFINITY, 0.0), (f64::INFINITY, 1.0)],
        ] {
            assert!(Monotone::new(points).is_none(), "{points:?}");
        }
        assert!(
            Monotone::periodic(&[1.0], 1.0).is_none()
                && Monotone::periodic(&[1.0, 2.0], 0.0).is_none()
        );
        let m = Monotone::new(&[(0.0, 1.0), (1.0, 0.0)]).unwrap();
        assert_eq!((m.at(-5.0), m.at(5.0), m.at(f64::NAN)), (1.0, 0.0, 1.0));
    }
}
