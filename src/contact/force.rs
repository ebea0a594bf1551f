//! Force models: how hard the skin pushes back at a depth.
//!
//! Each is a function of the stiffness k at the proxy, the depth d of the HIP below the tangent plane and the rate at
//! which d grows. It rises with d, is 0 at d = 0, never pulls, and is finite for every input, finite or not: what is no
//! number counts as 0, what is absurdly large as the bound below.
//!
//! What the contact uses of a model is its secant F(d)/d. The tangential stiffness is the secant over f_adj, so that the
//! tangential force at |P − A| is F/f_adj · |P − A|/d: slip starts at |P − A| = μ · f_adj · d for every model, and the
//! friction cone stays a ratio of lengths.

use std::fmt;

/// Bounds on what a model is asked, so that no product of them overflows.
const MOST_STIFFNESS_N_PER_MM: f64 = 1.0e9;
const MOST_DEPTH_MM: f64 = 1.0e10;
const MOST_RATE_MM_S: f64 = 1.0e9;
const MOST_GROWTH_PER_MM: f64 = 1.0e6;
/// The steepest that an exponential becomes, over its slope at the surface; from there it goes on straight.
const STEEPEST: f64 = 100.0;
/// Depth over the trend at which the nonlinear model is steepest: √3.
const STEEPEST_AT: f64 = 1.732_050_807_568_877_2;
/// The most that damping multiplies a force by: a rate that asks for more is a jump of the device and no press.
const MOST_DAMPING: f64 = 10.0;
/// Largest exponent of Hunt and Crossley's law. Below 1 the skin would be infinitely stiff at the surface.
const EXPONENTS: std::ops::RangeInclusive<f64> = 1.0..=4.0;

/// How the force grows with depth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ForceModel {
    /// F = k d (Ji 2008, 2.1).
    #[default]
    Linear,
    /// F = k(d) d: stiffness rises from a share of k at the surface to k along a Gaussian trend of depth,
    /// k(d) = k − (k − k₀) exp(−d²/2σ²) (after Ji 2008, future work 2).
    Nonlinear {
        /// k₀ / k, 0 … 1.
        start_share: f64,
        /// σ, mm. At 0 the model is linear.
        trend_mm: f64,
    },
    /// F = (k/B)(exp(B d) − 1): k is the slope at the surface. From where the slope is a hundred times that, F goes on
    /// straight with the slope it has there.
    Exponential {
        /// B, 1/mm. At 0 the model is linear.
        growth_per_mm: f64,
    },
    /// F = k dⁿ (1 + λ ḋ), d in mm, at least 0 (Hunt & Crossley 1975). k is the force at 1 mm. The bracket is at most 10.
    HuntCrossley {
        /// λ, s/mm.
        damping_s_per_mm: f64,
        /// n, 1 … 4: 1.5 for a sphere on an elastic half-space (Hertz).
        exponent: f64,
    },
}

impl ForceModel {
    /// Every model, with the values it has unless told otherwise.
    pub fn all() -> &'static [Self] {
        &[
            Self::Linear,
            Self::Nonlinear {
                start_share: 0.3,
                trend_mm: 4.0,
            },
            Self::Exponential {
                growth_per_mm: 0.15,
            },
            Self::HuntCrossley {
                damping_s_per_mm: 0.002,
                exponent: 1.5,
            },
        ]
    }

    /// Name in files, tables and the command line.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Nonlinear { .. } => "nonlinear",
            Self::Exponential { .. } => "exponential",
            Self::HuntCrossley { .. } => "hunt-crossley",
        }
    }

    /// F(d)/d, N/mm, at stiffness k, N/mm, depth d, mm, and rate of depth, mm/s. At d = 0 its limit.
    pub fn secant_n_per_mm(
        &self,
        stiffness_n_per_mm: f64,
        depth_mm: f64,
        depth_rate_mm_s: f64,
    ) -> f64 {
        let (k, d) = bounded(stiffness_n_per_mm, depth_mm);
        match *self {
            Self::Linear => k,
            Self::Nonlinear {
                start_share,
                trend_mm,
            } => k * nonlinear_secant(share(start_share), d / positive(trend_mm)),
            Self::Exponential { growth_per_mm } => {
                k * exponential_secant(growth(growth_per_mm) * d)
            }
            Self::HuntCrossley {
                damping_s_per_mm,
                exponent,
            } => {
                k * libm::pow(d, order(exponent) - 1.0) * damping(damping_s_per_mm, depth_rate_mm_s)
            }
        }
    }

    /// F, N, at stiffness k, N/mm, depth d, mm, and rate of depth, mm/s.
    pub fn force_n(&self, stiffness_n_per_mm: f64, depth_mm: f64, depth_rate_mm_s: f64) -> f64 {
        let (_, d) = bounded(stiffness_n_per_mm, depth_mm);
        self.secant_n_per_mm(stiffness_n_per_mm, depth_mm, depth_rate_mm_s) * d
    }

    /// The steepest slope of F over depth at rest, N/mm, from the surface down to depth d, mm, at stiffness k, N/mm. With the
    /// linear model k, at any depth. Of every model F over this rises with d.
    pub fn steepest_n_per_mm(&self, stiffness_n_per_mm: f64, depth_mm: f64) -> f64 {
        let (k, d) = bounded(stiffness_n_per_mm, depth_mm);
        match *self {
            Self::Linear => k,
            Self::Nonlinear {
                start_share,
                trend_mm,
            } => {
                let x = d / positive(trend_mm);
                // F' = k (1 − (1 − k₀/k)(1 − x²) exp(−x²/2)) is highest at x = √3; NaN or infinite where the trend is 0.
                let x = if x.is_finite() {
                    x.min(STEEPEST_AT)
                } else {
                    STEEPEST_AT
                };
                let rising = (1.0 - x * x) * libm::exp(-0.5 * x * x);
                let here = 1.0 - (1.0 - share(start_share)) * rising;
                // Without a trend the stiffness is k from the surface on.
                if positive(trend_mm) > 0.0 {
                    k * here
                } else {
                    k
                }
            }
            Self::Exponential { growth_per_mm } => {
                let x = growth(growth_per_mm) * d;
                k * libm::exp(x.min(libm::log(STEEPEST)))
            }
            Self::HuntCrossley { exponent, .. } => {
                let n = order(exponent);
                k * n * libm::pow(d, n - 1.0)
            }
        }
    }

    /// Work of pressing slowly from the surface to depth d, mJ: the integral of F at rate 0.
    pub fn energy_mj(&self, stiffness_n_per_mm: f64, depth_mm: f64) -> f64 {
        let (k, d) = bounded(stiffness_n_per_mm, depth_mm);
        match *self {
            Self::Linear => 0.5 * k * d * d,
            Self::Nonlinear {
                start_share,
                trend_mm,
            } => {
                let s = positive(trend_mm);
                let x = d / s;
                let softer = (1.0 - share(start_share)) * s * s * -libm::expm1(-0.5 * x * x);
                k * (0.5 * d * d - softer).max(0.0)
            }
            Self::Exponential { growth_per_mm } => {
                k * d * d * exponential_energy(growth(growth_per_mm) * d)
            }
            Self::HuntCrossley { exponent, .. } => {
                let n = order(exponent);
                k * libm::pow(d, n + 1.0) / (n + 1.0)
            }
        }
    }
}

/// The model and its numbers, for people.
impl fmt::Display for ForceModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())?;
        match self {
            Self::Linear => Ok(()),
            Self::Nonlinear {
                start_share,
                trend_mm,
            } => {
                let percent = start_share * 100.0;
                write!(
                    f,
                    ", from {percent:.3} % of the stiffness, trend {trend_mm} mm"
                )
            }
            Self::Exponential { growth_per_mm } => write!(f, ", growth {growth_per_mm} per mm"),
            Self::HuntCrossley {
                damping_s_per_mm,
                exponent,
            } => write!(f, ", damping {damping_s_per_mm} s/mm, exponent {exponent}"),
        }
    }
}

/// `x` where it is positive, else 0; NaN counts as 0.
fn positive(x: f64) -> f64 {
    if x > 0.0 { x } else { 0.0 }
}

/// A stiffness within what a model is asked, N/mm; what is none counts as 0.
pub(super) fn sound_stiffness(stiffness_n_per_mm: f64) -> f64 {
    positive(stiffness_n_per_mm).min(MOST_STIFFNESS_N_PER_MM)
}

fn bounded(stiffness_n_per_mm: f64, depth_mm: f64) -> (f64, f64) {
    (
        sound_stiffness(stiffness_n_per_mm),
        positive(depth_mm).min(MOST_DEPTH_MM),
    )
}

fn share(start_share: f64) -> f64 {
    positive(start_share).min(1.0)
}

fn growth(growth_per_mm: f64) -> f64 {
    positive(growth_per_mm).min(MOST_GROWTH_PER_MM)
}

fn order(exponent: f64) -> f64 {
    positive(exponent).clamp(*EXPONENTS.start(), *EXPONENTS.end())
}

/// k(d)/k at x = d/σ. `x` is NaN or infinite where σ is 0: then the stiffness has risen.
fn nonlinear_secant(start_share: f64, x: f64) -> f64 {
    if x.is_finite() {
        1.0 - (1.0 - start_share) * libm::exp(-0.5 * x * x)
    } else {
        1.0
    }
}

/// (exp x − 1)/x, straight from the bound on.
fn exponential_secant(x: f64) -> f64 {
    let straight_from = libm::log(STEEPEST);
    if x <= 0.0 {
        1.0
    } else if x <= straight_from {
        libm::expm1(x) / x
    } else {
        (STEEPEST - 1.0 + STEEPEST * (x - straight_from)) / x
    }
}

/// (exp x − 1 − x)/x², and what belongs to the straight part.
fn exponential_energy(x: f64) -> f64 {
    let straight_from = libm::log(STEEPEST);
    if x < 0.01 {
        // Where the difference would cancel: the first terms of its series, the next being below 1e-13.
        0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0 + x * (1.0 / 120.0 + x / 720.0)))
    } else if x <= straight_from {
        (libm::expm1(x) - x) / (x * x)
    } else {
        let (to_there, beyond) = (STEEPEST - 1.0 - straight_from, x - straight_from);
        (to_there + beyond * (STEEPEST - 1.0 + 0.5 * STEEPEST * beyond)) / (x * x)
    }
}

/// 1 + λ ḋ, within its bounds.
fn damping(damping_s_per_mm: f64, depth_rate_mm_s: f64) -> f64 {
    let rate = if depth_rate_mm_s.is_nan() {
        0.0
    } else {
        depth_rate_mm_s.clamp(-MOST_RATE_MM_S, MOST_RATE_MM_S)
    };
    let lambda = positive(damping_s_per_mm).min(MOST_RATE_MM_S);
    (1.0 + lambda * rate).clamp(0.0, MOST_DAMPING)
}
