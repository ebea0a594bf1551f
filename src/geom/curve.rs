//! Falloffs over a ratio q, as arrays or exactly: from the centre of a dent to its rim, from a key of a map to the rim of
//! its effect (Ji 2008, 4.2.1, 5.2.2).

use super::Monotone;
use super::law::{Ends, Law};
use super::table::Table;
use std::sync::Arc;

/// Samples of the published array.
pub const PUBLISHED_SIZE: usize = 700;

/// How a ratio between two samples is answered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lookup {
    /// The nearest sample: `M[round(q · (n − 1))]` (Ji 2008, eq. 4.3). A dent then has small terraces.
    Nearest,
    /// Linear between the two samples around q.
    #[default]
    Linear,
    /// The function itself, worked out for every q: nothing is lost, at the cost of an exponential a vertex.
    Exact,
}

impl Lookup {
    /// Every lookup.
    pub fn all() -> &'static [Self] {
        &[Self::Nearest, Self::Linear, Self::Exact]
    }

    /// Name in files, tables and the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nearest => "nearest",
            Self::Linear => "linear",
            Self::Exact => "exact",
        }
    }

    /// The lookup called `name`.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().iter().copied().find(|l| l.name() == name)
    }
}

/// A falloff M(q): its value at q = 0 is the share of the finger's displacement at the centre, at q = 1 that at the rim.
///
/// Outside, q ≥ 1, it is 0 by definition (Ji 2008, eq. 4.14), and so it is for a ratio that is not a number.
///
/// Cheap to clone: the arrays are shared.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    name: String,
    samples: Arc<[f64]>,
    lookup: Lookup,
    steps: f64,
    table: Table,
    function: Function,
}

/// What an array was taken from.
#[derive(Clone, Debug, PartialEq)]
enum Function {
    Law(Law),
    Points(Arc<Monotone>),
    /// The array is all there is.
    Samples,
}

/// Points of a curve are at least this far apart in q, so that slopes between them are numbers.
const CLOSEST: f64 = 1e-9;
/// Name of a curve through points that the user gave.
pub const POINTS: &str = "points";

/// Why samples do not make a curve.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CurveError {
    /// A curve needs both its ends.
    #[error("curve \"{name}\" has {n} samples; at least 2 are needed")]
    TooFew {
        /// Name of the curve.
        name: String,
        /// Number of samples given.
        n: usize,
    },
    /// The same of a curve through points.
    #[error(
        "curve \"{name}\" has {n} points; at least 2 are needed, the first at q = 0 and the last at q = 1"
    )]
    TooFewPoints {
        /// Name of the curve.
        name: String,
        /// Number of points given.
        n: usize,
    },
    /// A point that is not beyond the one before, or not in 0 … 1, or an end where none belongs.
    #[error("curve \"{name}\": point {} is at q = {place}; it must be {allowed}", .index + 1)]
    Place {
        /// Name of the curve.
        name: String,
        /// Which point, counted from 0.
        index: usize,
        /// Where it is.
        place: f64,
        /// What is allowed there.
        allowed: String,
    },
    /// A point beyond the whole displacement.
    #[error("curve \"{name}\": point {} is {value} at q = {place}; a number in -1 ... 1 is allowed", .index + 1)]
    PointOutOfRange {
        /// Name of the curve.
        name: String,
        /// Which point, counted from 0.
        index: usize,
        /// Where it is.
        place: f64,
        /// What it is.
        value: f64,
    },
    /// A share of the displacement beyond the whole, or none at all.
    #[error("curve \"{name}\": sample {index} is {value}; it must be a number in -1 ... 1")]
    OutOfRange {
        /// Name of the curve.
        name: String,
        /// Which sample, counted from 0.
        index: usize,
        /// What it is.
        value: f64,
    },
}

impl CurveError {
    /// Which point is at fault, counted from 0.
    pub fn point(&self) -> Option<usize> {
        match self {
            Self::Place { index, .. } | Self::PointOutOfRange { index, .. } => Some(*index),
            Self::TooFew { .. } | Self::TooFewPoints { .. } | Self::OutOfRange { .. } => None,
        }
    }
}

impl Curve {
    /// A curve through `samples` at equal steps of q from 0 to 1. [`Lookup::Exact`] is linear between them: there is no
    /// function to ask.
    ///
    /// # Errors
    /// Fewer than two samples; a sample that is not a number in −1 … 1 (beyond that the caps of the drawn displacement
    /// would not hold).
    pub fn new(
        name: impl Into<String>,
        samples: Vec<f64>,
        lookup: Lookup,
    ) -> Result<Self, CurveError> {
        let name = name.into();
        if samples.len() < 2 {
            let n = samples.len();
            return Err(CurveError::TooFew { name, n });
        }
        let wrong = samples.iter().position(|m| !(-1.0..=1.0).contains(m));
        if let Some(index) = wrong {
            let value = samples[index];
            return Err(CurveError::OutOfRange { name, index, value });
        }
        Ok(Self::of_checked(name, samples, lookup, Function::Samples))
    }

    /// The default: the half Gaussian lowered by its value at the rim and rescaled, M(q) = (g(q) − g(1)) / (1 − g(1)).
    ///
    /// The published array ends at 0.0021, so that at 20 mm of drag the rim jumps by 0.04 mm; this one ends at exactly 0.
    /// It differs from the published one by at most 0.0021.
    pub fn gaussian() -> Self {
        Self::of(Law::Gaussian, PUBLISHED_SIZE, Lookup::Linear)
    }

    /// The half Gaussian as printed: `n` samples over x = 0 … 1.4 with σ² = 1/(2π), so that `M[0]` = 1 and the last is 0.0021.
    ///
    /// Fewer than 2 samples are taken as 2.
    pub fn gaussian_printed(n: usize, lookup: Lookup) -> Self {
        Self::of(Law::GaussianPrinted, n, lookup)
    }

    /// A law as an array of `n` samples. Fewer than 2 are taken as 2.
    pub fn of(law: Law, n: usize, lookup: Lookup) -> Self {
        let samples = sampled(n, |q| law.at(q));
        Self::of_checked(law.name().into(), samples, lookup, Function::Law(law))
    }

    /// The [`Law`] called `name` as an array of `n` samples (fewer than 2 are taken as 2), `None` for an unknown name.
    pub fn named(name: &str, n: usize, lookup: Lookup) -> Option<Self> {
        Law::named(name).map(|law| Self::of(law, n, lookup))
    }

    /// A curve through `points` (q, M), joined by a monotone cubic ([`Monotone`]), as an array of `n` samples (fewer than 2
    /// are taken as 2). It turns only where the points do, so that it stays in their range.
    ///
    /// Where M(0) is not 1 the skin under the finger does not land on it; where M(1) is not 0 the dent ends with a step.
    ///
    /// # Errors
    /// Fewer than two points; places q that do not ascend from 0 to 1; an M that is not a number in −1 … 1.
    pub fn through(points: &[(f64, f64)], n: usize, lookup: Lookup) -> Result<Self, CurveError> {
        let name = || POINTS.to_owned();
        let last = points.len().saturating_sub(1);
        for (index, &(place, value)) in points.iter().enumerate() {
            let before = index.checked_sub(1).map(|b| points[b].0);
            let allowed = match before {
                None if place != 0.0 => Some("0, the centre".to_owned()),
                Some(_) if index == last && place != 1.0 => Some("1, the rim".to_owned()),
                Some(before) if !(place >= before + CLOSEST && place <= 1.0) => Some(format!(
                    "a number above {before}, that of the point before, by {CLOSEST:e} or more, up to 1"
                )),
                _ => None,
            };
            if let Some(allowed) = allowed {
                let name = name();
                return Err(CurveError::Place {
                    name,
                    index,
                    place,
                    allowed,
                });
            }
            if !(-1.0..=1.0).contains(&value) {
                let name = name();
                return Err(CurveError::PointOutOfRange {
                    name,
                    index,
                    place,
                    value,
                });
            }
        }
        // Of checked points only too few make no curve.
        let monotone = Monotone::new(points).ok_or(CurveError::TooFewPoints {
            name: name(),
            n: points.len(),
        })?;
        let samples = sampled(n, |q| monotone.at(q));
        let function = Function::Points(Arc::new(monotone));
        Ok(Self::of_checked(name(), samples, lookup, function))
    }

    fn of_checked(name: String, samples: Vec<f64>, lookup: Lookup, function: Function) -> Self {
        let steps = (samples.len() - 1) as f64;
        let table = match lookup {
            Lookup::Nearest => Table::nearest(&samples),
            Lookup::Linear | Lookup::Exact => Table::linear(&samples),
        };
        Self {
            name,
            samples: samples.into(),
            lookup,
            steps,
            table,
            function,
        }
    }

    /// Name in files, tables and the command line.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The array M.
    pub fn samples(&self) -> &[f64] {
        &self.samples
    }

    /// How values between samples are found.
    pub fn lookup(&self) -> Lookup {
        self.lookup
    }

    /// Turns each location ratio q into M(q), two at a time and with the same bits as [`Curve::at`].
    #[inline]
    pub fn apply<const N: usize>(&self, ratios: &mut [f64; N]) {
        match self.lookup {
            Lookup::Nearest | Lookup::Linear => self.table.apply(ratios),
            Lookup::Exact => {
                for q in ratios {
                    *q = self.at(*q);
                }
            }
        }
    }

    /// M at the location ratio `q`; a negative one counts as 0.
    #[inline]
    pub fn at(&self, q: f64) -> f64 {
        if q >= 1.0 || q.is_nan() {
            return 0.0;
        }
        let place = q.max(0.0) * self.steps;
        let last = self.samples.len() - 1;
        match self.lookup {
            Lookup::Nearest => self.samples[((place + 0.5) as usize).min(last)],
            Lookup::Linear => self.linear(place),
            Lookup::Exact => self.exact(q),
        }
    }

    #[inline(always)]
    fn linear(&self, place: f64) -> f64 {
        let i = (place as usize).min(self.samples.len() - 2);
        let (m, next) = (self.samples[i], self.samples[i + 1]);
        m + (next - m) * (place - i as f64)
    }

    /// The function behind the array at `q`, limited to 0 … 1 (what is no number counts as 0); unlike [`Curve::at`] not cut
    /// to 0 at the rim.
    pub fn exact(&self, q: f64) -> f64 {
        match &self.function {
            Function::Law(law) => law.at(q),
            Function::Points(points) => points.at(q),
            Function::Samples => {
                let q = if q > 0.0 { q.min(1.0) } else { 0.0 };
                self.linear(q * self.steps)
            }
        }
    }

    /// Slope and second derivative of the function behind the array at both ends (table 4.2); `None` where the array is all
    /// there is.
    pub fn ends(&self) -> Option<Ends> {
        match &self.function {
            Function::Law(law) => Some(law.ends()),
            Function::Points(points) => Some(Ends {
                slope_centre: points.slope(0.0),
                slope_rim: points.slope(1.0),
                curvature_centre: points.curvature(0.0),
                curvature_rim: points.curvature(1.0),
            }),
            Function::Samples => None,
        }
    }
}

/// A curve's name and how it is made.
pub type Named = (&'static str, fn() -> Curve);

/// Every curve that has a name, with the array it usually comes in.
pub fn all() -> &'static [Named] {
    &[
        ("gaussian", Curve::gaussian),
        ("gaussian-printed", || {
            Curve::gaussian_printed(PUBLISHED_SIZE, Lookup::Nearest)
        }),
        ("cosine", || usual(Law::Cosine)),
        ("logarithmic", || usual(Law::Logarithmic)),
        ("gaussian-sharp", || usual(Law::GaussianSharp)),
    ]
}

fn usual(law: Law) -> Curve {
    Curve::of(law, PUBLISHED_SIZE, Lookup::Linear)
}

fn sampled(n: usize, curve: impl Fn(f64) -> f64) -> Vec<f64> {
    let n = n.max(2);
    (0..n).map(|i| curve(i as f64 / (n - 1) as f64)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_ratios_at_once_have_the_bits_of_each_alone() {
        let mut ratios = [0.0; 4096];
        for (i, q) in ratios.iter_mut().enumerate() {
            *q = i as f64 / 4000.0 + if i % 3 == 0 { 1e-17 } else { 0.0 };
        }
        let odd = [
            -1.0,
            -0.0,
            1.0 - f64::EPSILON / 2.0,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            1e-320,
        ];
        ratios[..odd.len()].copy_from_slice(&odd);
        for i in 0..700 {
            ratios[100 + i] = (i as f64 + 0.5 * (i % 2) as f64) / 699.0;
        }
        for lookup in [Lookup::Nearest, Lookup::Linear, Lookup::Exact] {
            for n in [2, 20, 130, 700] {
                let curve = Curve::gaussian_printed(n, lookup);
                let mut shares = ratios;
                curve.apply(&mut shares);
                for (q, share) in ratios.iter().zip(shares) {
                    assert_eq!(
                        share.to_bits(),
                        curve.at(*q).to_bits(),
                        "{lookup:?} {n} at {q}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_printed_array_has_the_printed_ends_and_closed_form_between() {
        let c = Curve::gaussian_printed(PUBLISHED_SIZE, Lookup::Nearest);
        assert_eq!(c.samples().len(), 700);
        assert_eq!(c.samples()[0], 1.0);
        assert!((c.samples()[699] - 0.0021).abs() < 0.5e-4);
        for (i, m) in c.samples().iter().enumerate() {
            let x = 1.4 * i as f64 / 699.0;
            let sigma_sq = 1.0 / (2.0 * std::f64::consts::PI);
            assert!((m - (-x * x / (2.0 * sigma_sq)).exp()).abs() < 1e-14);
        }
    }

    #[test]
    fn nearest_lookup_rounds_as_eq_4_3() {
        let c = Curve::gaussian_printed(PUBLISHED_SIZE, Lookup::Nearest);
        for q in [0.0, 0.3, 0.4999 / 699.0, 0.5001 / 699.0, 0.77, 0.9999] {
            assert_eq!(c.at(q), c.samples()[(699.0 * q).round() as usize], "q {q}");
        }
    }

    #[test]
    fn the_default_meets_the_skin_at_rest_exactly_and_without_a_jump() {
        let c = Curve::gaussian();
        assert_eq!(c.at(0.0), 1.0);
        assert_eq!(c.samples()[699], 0.0);
        assert!(c.at(1.0 - 1e-9) < 1e-10);
        assert_eq!(c.at(1.0), 0.0);
        let printed = Curve::gaussian_printed(PUBLISHED_SIZE, Lookup::Linear);
        for i in 0..1000 {
            let q = i as f64 / 1000.0;
            assert!((c.at(q) - printed.at(q)).abs() <= 0.00212);
        }
    }

    #[test]
    fn linear_lookup_is_within_a_step_squared_of_the_closed_form() {
        let c = Curve::gaussian_printed(PUBLISHED_SIZE, Lookup::Linear);
        let worst = (0..10_000)
            .map(|i| i as f64 / 10_000.0)
            .map(|q| (c.at(q) - c.exact(q)).abs())
            .fold(0.0, f64::max);
        // h²/8 · max |M″| with h = 1/699 and M″(0) = −2π · 1.4².
        let bound = 2.0 * std::f64::consts::PI * 1.96 / 8.0 / (699.0 * 699.0);
        assert!(worst <= bound * 1.0001, "{worst}");
    }

    #[test]
    fn every_curve_falls_from_one_and_is_zero_from_the_rim_on() {
        for (name, make) in all() {
            let c = make();
            assert_eq!(c.name(), *name);
            assert_eq!(c.at(0.0), 1.0, "{name}");
            let values: Vec<f64> = (0..=2000).map(|i| c.at(i as f64 / 2000.0)).collect();
            assert!(values.windows(2).all(|w| w[1] <= w[0]), "{name}");
            for q in [1.0, 1.5, f64::INFINITY, f64::NAN] {
                assert_eq!(c.at(q), 0.0, "{name} at {q}");
            }
            assert_eq!(c.at(-1.0), 1.0, "{name}");
        }
    }

    #[test]
    fn every_law_is_an_array_of_any_size_and_a_function() {
        for &law in Law::all() {
            for n in [2, 20, 130, 700] {
                for &lookup in Lookup::all() {
                    let c = Curve::named(law.name(), n, lookup).unwrap();
                    assert_eq!(
                        (c.samples().len(), c.lookup(), c.name()),
                        (n, lookup, law.name())
                    );
                    for i in 0..=1000 {
                        let q = f64::from(i) / 1001.0;
                        let step = 1.0 / (n - 1) as f64;
                        // The next samples on either side bound every lookup of a falling curve.
                        let (most, least) = (law.at(q - step), law.at(q + step));
                        assert!(
                            c.at(q) <= most && c.at(q) >= least,
                            "{law:?} {n} {lookup:?} {q}"
                        );
                    }
                }
                let exact = Curve::of(law, n, Lookup::Exact);
                assert_eq!(exact.at(0.3), law.at(0.3));
                assert_eq!(exact.ends(), Some(law.ends()));
            }
        }
        assert!(
            all()
                .iter()
                .map(|(name, _)| Law::named(name))
                .eq(Law::all().iter().map(|&l| Some(l)))
        );
        for &lookup in Lookup::all() {
            assert_eq!(Lookup::named(lookup.name()), Some(lookup));
        }
        assert!(Curve::named("mine", 700, Lookup::Linear).is_none());
        assert_eq!(
            Curve::of(Law::Cosine, 0, Lookup::Nearest).samples(),
            [1.0, 0.0]
        );
    }

    #[test]
    fn a_curve_through_points_meets_them_and_stays_between_them() {
        let points = [(0.0, 1.0), (0.2, 0.9), (0.5, -0.1), (0.8, -0.1), (1.0, 0.0)];
        let c = Curve::through(&points, 1001, Lookup::Exact).unwrap();
        for (q, m) in &points[..4] {
            assert_eq!(c.at(*q), *m);
        }
        assert_eq!(c.at(1.0), 0.0);
        let linear = Curve::through(&points, 1001, Lookup::Linear).unwrap();
        for i in 0..1000 {
            let q = f64::from(i) / 1000.0;
            assert!((-0.1..=1.0).contains(&c.at(q)));
            assert!((linear.at(q) - c.at(q)).abs() < 1e-5);
        }
        let ends = c.ends().unwrap();
        assert!(ends.slope_centre == 0.0 && ends.slope_rim > 0.0);
        let plain = Curve::new("mine", vec![1.0, 0.25, 0.0], Lookup::Exact).unwrap();
        assert_eq!(
            (plain.at(0.25), plain.exact(7.0), plain.ends()),
            (0.625, 0.0, None)
        );
    }

    #[test]
    fn points_that_make_no_curve_are_refused_by_number() {
        let told = |points: &[(f64, f64)]| {
            Curve::through(points, 700, Lookup::Linear)
                .unwrap_err()
                .to_string()
        };
        let two = "at least 2 are needed, the first at q = 0 and the last at q = 1";
        assert_eq!(told(&[]), format!("curve \"points\" has 0 points; {two}"));
        assert_eq!(
            told(&[(0.0, 1.0)]),
            format!("curve \"points\" has 1 points; {two}")
        );
        for (points, what) in [
            (
                &[(0.1, 1.0), (1.0, 0.0)][..],
                "point 1 is at q = 0.1; it must be 0, the centre",
            ),
            (
                &[(0.0, 1.0), (0.9, 0.0)],
                "point 2 is at q = 0.9; it must be 1, the rim",
            ),
            (
                &[(0.0, 1.0), (0.5, 0.5), (0.5, 0.4), (1.0, 0.0)],
                "point 3 is at q = 0.5; it must be a number above 0.5",
            ),
            (
                &[(0.0, 1.0), (f64::NAN, 0.5), (1.0, 0.0)],
                "point 2 is at q = NaN; it must be a number above 0",
            ),
            (
                &[(0.0, 1.0), (0.5, 1.1), (1.0, 0.0)],
                "point 2 is 1.1 at q = 0.5; a number in -1 ... 1 is allowed",
            ),
            (
                &[(0.0, 1.0), (0.5, f64::NAN), (1.0, 0.0)],
                "point 2 is NaN at q = 0.5",
            ),
        ] {
            assert!(told(points).contains(what), "{} for {what}", told(points));
        }
    }

    #[test]
    fn samples_that_break_the_caps_are_refused_by_index() {
        let nan = Curve::new("mine", vec![1.0, f64::NAN, 0.0], Lookup::Linear);
        assert_eq!(
            nan.unwrap_err().to_string(),
            "curve \"mine\": sample 1 is NaN; it must be a number in -1 ... 1"
        );
        assert!(Curve::new("mine", vec![1.0], Lookup::Linear).is_err());
        let line = Curve::new("line", vec![1.0, 0.0], Lookup::Linear).unwrap();
        assert_eq!(line.at(0.25), 0.75);
    }
}
