//! Signal detection: from shares of answers to d′ and back.
//!
//! d′ is the distance between the means of what is felt with and without the signal, in standard deviations of its noise
//! (Green & Swets 1966). It does not depend on how many alternatives there are, nor on what the observer is inclined to say.

use super::normal::{density, quantile, share_below};

/// Largest d′ that is told: nobody errs beyond it.
pub const MOST_D_PRIME: f64 = 12.0;

/// A forced choice among m alternatives: one of them has the signal, and the observer says the one that felt strongest.
///
/// P(d′) = ∫ φ(t − d′) Φ(t)^(m−1) dt (Green & Swets 1966; tables: Hacker & Ratcliff 1979).
#[derive(Clone, Debug)]
pub struct ForcedChoice {
    alternatives: u32,
    /// Share of right answers and its slope at multiples of [`GRID`], from 0.
    table: Vec<[f64; 2]>,
}

/// Step of the table in d′. Between two entries a cubic through values and slopes is off by less than 1e-10.
const GRID: f64 = 0.02;

impl ForcedChoice {
    /// Among `alternatives`; fewer than 2 count as 2.
    pub fn new(alternatives: u32) -> Self {
        let alternatives = alternatives.max(2);
        let n = (MOST_D_PRIME / GRID) as usize;
        let table = (0..=n)
            .map(|i| integral(alternatives, i as f64 * GRID))
            .collect();
        Self {
            alternatives,
            table,
        }
    }

    /// How many there are.
    pub fn alternatives(&self) -> u32 {
        self.alternatives
    }

    /// Share of right answers by guessing.
    pub fn chance(&self) -> f64 {
        1.0 / f64::from(self.alternatives)
    }

    /// Share of right answers at `d_prime`; what is below 0 or no number counts as 0.
    pub fn share(&self, d_prime: f64) -> f64 {
        self.share_and_slope(d_prime)[0]
    }

    /// The same and its derivative; 0 beyond [`MOST_D_PRIME`].
    pub(super) fn share_and_slope(&self, d_prime: f64) -> [f64; 2] {
        let d = if d_prime.is_nan() { 0.0 } else { d_prime };
        let d = d.clamp(0.0, MOST_D_PRIME);
        let i = ((d / GRID) as usize).min(self.table.len() - 2);
        let t = d / GRID - i as f64;
        let ([p0, s0], [p1, s1]) = (self.table[i], self.table[i + 1]);
        let rise = p1 - p0;
        let (a, b) = (s0 * GRID - rise, rise - s1 * GRID);
        let bent = (1.0 - t) * a + t * b;
        let share = p0 + t * rise + t * (1.0 - t) * bent;
        let slope = (rise + (1.0 - 2.0 * t) * bent + t * (1.0 - t) * (b - a)) / GRID;
        let inside = f64::from(u8::from(d_prime < MOST_D_PRIME));
        [share.clamp(0.0, 1.0), slope * inside]
    }

    /// The d′ at which a share of the answers is right: 0 at or below chance, [`MOST_D_PRIME`] where all are.
    pub fn d_prime(&self, share: f64) -> f64 {
        root(0.0, MOST_D_PRIME, |d| self.share(d) - share)
    }
}

/// Share of right answers among m at d′ and its derivative, by the trapezoidal rule: for so smooth a function it is exact to
/// rounding at this step.
fn integral(alternatives: u32, d_prime: f64) -> [f64; 2] {
    const STEP: f64 = 0.1;
    const REACH: i32 = 85;
    let power = f64::from(alternatives - 1);
    let (mut share, mut slope) = (0.0, 0.0);
    for i in -REACH..=REACH {
        let z = f64::from(i) * STEP;
        let weight = STEP * density(z) * libm::pow(share_below(d_prime + z), power);
        share += weight;
        slope += weight * z;
    }
    [share, slope]
}

/// Hits and false alarms of an observer who says "different": H where there was a difference, F where there was none.
///
/// The counts are corrected as by half an answer of either sort (log-linear: Hautus 1995), so that shares of 0 and 1 have a
/// finite d′.
pub fn corrected_shares(hits: u32, signals: u32, false_alarms: u32, noises: u32) -> [f64; 2] {
    let share = |n: u32, of: u32| (f64::from(n) + 0.5) / (f64::from(of) + 1.0);
    [share(hits, signals), share(false_alarms, noises)]
}

/// d′ of saying "different" of two places, by the differencing model of the same–different task: the observer says it where
/// what is felt of the two differs by more than a criterion k, either way. With the independent noise of two places
///
/// F = 2 Φ(−k/√2), H = Φ((d′ − k)/√2) + Φ((−d′ − k)/√2) (Macmillan & Creelman 2005, chapter 9).
///
/// 0 where there are no more hits than false alarms.
pub fn same_different_d_prime(hit_share: f64, false_alarm_share: f64) -> f64 {
    let k = criterion(false_alarm_share);
    root(0.0, MOST_D_PRIME, |d| same_different_hits(d, k) - hit_share)
}

/// Share of differences that are noticed at d′ where `false_alarm_share` of what is the same is called different.
pub fn same_different_hit_share(d_prime: f64, false_alarm_share: f64) -> f64 {
    same_different_hits(d_prime, criterion(false_alarm_share))
}

fn criterion(false_alarm_share: f64) -> f64 {
    -std::f64::consts::SQRT_2 * quantile(0.5 * false_alarm_share)
}

fn same_different_hits(d_prime: f64, k: f64) -> f64 {
    let part = |d: f64| share_below((d - k) * std::f64::consts::FRAC_1_SQRT_2);
    part(d_prime) + part(-d_prime)
}

/// Where a rising function goes through 0, by halving: the nearer end where it does not.
pub fn root(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    if f(low) >= 0.0 {
        return low;
    }
    if f(high) <= 0.0 {
        return high;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if f(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::training::random::Random;

    #[test]
    fn twelve_alternatives_give_the_published_shares() {
        // METHOD, section 7.
        let twelve = ForcedChoice::new(12);
        for (d, p) in [(1.0, 0.3077), (2.0, 0.6430), (3.0, 0.8891)] {
            assert!(
                (twelve.share(d) - p).abs() < 5e-5,
                "{d}: {}",
                twelve.share(d)
            );
            assert!((twelve.d_prime(p) - d).abs() < 5e-4);
        }
        assert!((twelve.share(0.0) - 1.0 / 12.0).abs() < 1e-12);
    }

    #[test]
    fn two_alternatives_have_a_closed_form() {
        let two = ForcedChoice::new(2);
        for i in 0..100 {
            let d = 0.0777 * f64::from(i);
            let closed = share_below(d * std::f64::consts::FRAC_1_SQRT_2);
            assert!((two.share(d) - closed).abs() < 1e-9, "{d}");
        }
    }

    #[test]
    fn shares_are_those_of_an_observer_who_takes_the_strongest() {
        let mut random = Random::new(5);
        for (m, d) in [(3, 0.7), (12, 1.8), (24, 2.6)] {
            let n = 40_000;
            let right = (0..n)
                .filter(|_| {
                    let signal = d + random.normal();
                    (1..m).all(|_| random.normal() < signal)
                })
                .count();
            let p = ForcedChoice::new(m).share(d);
            let error = (p * (1.0 - p) / f64::from(n)).sqrt();
            assert!((right as f64 / f64::from(n) - p).abs() < 4.0 * error, "{m}");
        }
    }

    #[test]
    fn same_and_different_are_told_as_by_an_observer_who_takes_the_difference() {
        // An independent simulation of the model: two places, noise in each, a criterion on the difference.
        let mut random = Random::new(9);
        let (d, k) = (1.5, 1.8);
        let n = 60_000;
        let mut says = |d: f64| {
            let n_said = (0..n).filter(|_| (d + random.normal() - random.normal()).abs() > k);
            n_said.count() as f64 / f64::from(n)
        };
        let (hits, false_alarms) = (says(d), says(0.0));
        assert!((same_different_d_prime(hits, false_alarms) - d).abs() < 0.03);
        assert!((same_different_hit_share(d, false_alarms) - hits).abs() < 0.01);
    }

    #[test]
    fn extremes_stay_finite() {
        let five = ForcedChoice::new(5);
        for share in [0.0, -1.0, 0.2] {
            assert!(five.d_prime(share) < 1e-6);
        }
        assert_eq!(five.d_prime(1.0), MOST_D_PRIME);
        for d in [f64::NAN, -1.0, f64::INFINITY, 1e300] {
            assert!((0.0..=1.0).contains(&five.share(d)), "{d}");
        }
        assert_eq!(ForcedChoice::new(0).alternatives(), 2);
        assert!(same_different_d_prime(0.3, 0.3) < 1e-6);
        let [h, f] = corrected_shares(20, 20, 0, 20);
        assert!(same_different_d_prime(h, f).is_finite() && h < 1.0 && f > 0.0);
    }
}
