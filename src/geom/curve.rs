//! Falloffs over a ratio q: from the centre of a dent to its rim, from a key of a map to the rim of its effect (Ji 2008,
//! 4.2.1, 5.2.2).

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
}

/// A falloff M(q): its value at q = 0 is the share of the finger's displacement at the centre, at q = 1 that at the rim.
///
/// Outside, q ≥ 1, it is 0 by definition (Ji 2008, eq. 4.14), and so it is for a ratio that is not a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    name: String,
    samples: Vec<f64>,
    lookup: Lookup,
    steps: f64,
}

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

impl Curve {
    /// A curve through `samples` at equal steps of q from 0 to 1.
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
        Ok(Self::of_checked(name, samples, lookup))
    }

    /// The default: the half Gaussian lowered by its value at the rim and rescaled, M(q) = (g(q) − g(1)) / (1 − g(1)).
    ///
    /// The published array ends at 0.0021, so that at 20 mm of drag the rim jumps by 0.04 mm; this one ends at exactly 0.
    /// It differs from the published one by at most 0.0021.
    pub fn gaussian() -> Self {
        let rim = gaussian(1.0);
        let samples = sampled(PUBLISHED_SIZE, |q| (gaussian(q) - rim) / (1.0 - rim));
        Self::of_checked("gaussian".into(), samples, Lookup::Linear)
    }

    /// The half Gaussian as printed: `n` samples over x = 0 … 1.4 with σ² = 1/(2π), so that `M[0]` = 1 and the last is 0.0021.
    ///
    /// Fewer than 2 samples are taken as 2.
    pub fn gaussian_printed(n: usize, lookup: Lookup) -> Self {
        Self::of_checked("gaussian-printed".into(), sampled(n, gaussian), lookup)
    }

    fn of_checked(name: String, samples: Vec<f64>, lookup: Lookup) -> Self {
        let steps = (samples.len() - 1) as f64;
        Self {
            name,
            samples,
            lookup,
            steps,
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
            Lookup::Linear => {
                let i = (place as usize).min(last - 1);
                let (m, next) = (self.samples[i], self.samples[i + 1]);
                m + (next - m) * (place - i as f64)
            }
        }
    }
}

/// A curve's name and how it is made.
pub type Named = (&'static str, fn() -> Curve);

/// Every curve, by name.
pub fn all() -> &'static [Named] {
    &[
        ("gaussian", Curve::gaussian),
        ("gaussian-printed", || {
            Curve::gaussian_printed(PUBLISHED_SIZE, Lookup::Nearest)
        }),
    ]
}

/// The half Gaussian of eq. 4.1 scaled to 1 at its top: exp(−π x²) with x = 1.4 q, as σ² = 1/(2π).
fn gaussian(q: f64) -> f64 {
    let x = 1.4 * q;
    libm::exp(-std::f64::consts::PI * x * x)
}

fn sampled(n: usize, curve: impl Fn(f64) -> f64) -> Vec<f64> {
    let n = n.max(2);
    (0..n).map(|i| curve(i as f64 / (n - 1) as f64)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

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
            .map(|q| (c.at(q) - gaussian(q)).abs())
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
