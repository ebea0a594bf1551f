//! Smoothness of a movement, from its speed.
//!
//! SPARC is the arc length of the normalised amplitude spectrum of the speed up to an adaptive bound (Balasubramanian,
//! Melendez-Calderon & Burdet 2012, IEEE Trans Biomed Eng 59:2126; Balasubramanian et al. 2015, J NeuroEng Rehabil 12:112),
//! with the cut-off at 10 Hz, the amplitude threshold at 0.05 and four levels of padding, as published. LDLJ is the log
//! dimensionless jerk of the speed (2015, there LDLJ-V). Both are 0 at best and grow more negative as the movement gets
//! less smooth.
//!
//! # Of a session
//! Both measures are made for single movements and depend on how long they are. A session, or all the phases of one sort in
//! it, is therefore cut into windows of [`WINDOW_S`] of speed in frames of 10 ms; a window also ends where the recording has
//! a gap or the phase changes. Of windows at least [`LEAST_WINDOW_S`] long in which the finger reached [`MOVING_MM_S`] the
//! mean is told, weighted by their length.

use rustfft::{FftPlanner, num_complex::Complex};

/// Length of a window, s.
pub const WINDOW_S: f64 = 4.0;
/// Shorter ones are left out, s.
pub const LEAST_WINDOW_S: f64 = 1.0;
/// A window in which the finger stayed slower is at rest, mm/s.
pub const MOVING_MM_S: f64 = 10.0;

const CUT_OFF_HZ: f64 = 10.0;
const AMPLITUDE: f64 = 0.05;
const PAD_LEVELS: u32 = 4;
/// Longest movement that is transformed whole, samples: its padded spectrum has 16 to 32 times as many.
pub const MOST_SAMPLES: usize = 1 << 18;

/// Transforms of the lengths met so far.
pub struct Smoothness {
    planner: FftPlanner<f64>,
    spectrum: Vec<Complex<f64>>,
}

impl Default for Smoothness {
    fn default() -> Self {
        Self {
            planner: FftPlanner::new(),
            spectrum: Vec::new(),
        }
    }
}

impl Smoothness {
    /// SPARC of a speed profile sampled at `rate_hz`. `None` for fewer than two samples, more than [`MOST_SAMPLES`], one that
    /// is not finite, or no movement at all.
    pub fn sparc(&mut self, speed: &[f64], rate_hz: f64) -> Option<f64> {
        let sound = speed.iter().all(|v| v.is_finite()) && rate_hz.is_finite() && rate_hz > 0.0;
        if !sound || !(2..=MOST_SAMPLES).contains(&speed.len()) {
            return None;
        }
        let n = speed.len().next_power_of_two() << PAD_LEVELS;
        self.spectrum.clear();
        self.spectrum
            .extend(speed.iter().map(|&v| Complex::new(v, 0.0)));
        self.spectrum.resize(n, Complex::new(0.0, 0.0));
        self.planner.plan_fft_forward(n).process(&mut self.spectrum);
        // The published code takes the greatest over both halves; a real signal has the same in each.
        let half = &self.spectrum[..=n / 2];
        let greatest = half.iter().map(|c| c.norm()).fold(0.0, f64::max);
        if greatest <= 0.0 || !greatest.is_finite() {
            return None;
        }
        let step_hz = rate_hz / n as f64;
        let bins = half.len().min((CUT_OFF_HZ / step_hz) as usize + 1);
        let amplitude = |i: usize| half[i].norm() / greatest;
        let first = (0..bins).find(|&i| amplitude(i) >= AMPLITUDE)?;
        let last = (0..bins).rfind(|&i| amplitude(i) >= AMPLITUDE)?;
        if last == first {
            return Some(0.0);
        }
        let along = 1.0 / (last - first) as f64;
        let arc = (first..last).map(|i| libm::hypot(along, amplitude(i + 1) - amplitude(i)));
        Some(-arc.sum::<f64>())
    }
}

/// Log dimensionless jerk of a speed profile: −ln(T³ ⁄ v² · ∫ v″² dt) with the greatest speed v. `None` for fewer than four
/// samples, one that is not finite, or a speed without curvature.
pub fn log_jerk(speed: &[f64], rate_hz: f64) -> Option<f64> {
    let peak = speed.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    if speed.len() < 4 || rate_hz.is_nan() || rate_hz <= 0.0 {
        return None;
    }
    let jerk = speed
        .windows(3)
        .map(|v| (v[2] - 2.0 * v[1] + v[0]) * rate_hz * rate_hz);
    let integral = jerk.map(|j| j * j).sum::<f64>() / rate_hz;
    let duration_s = speed.len() as f64 / rate_hz;
    let value = -libm::log(duration_s * duration_s * duration_s / (peak * peak) * integral);
    value.is_finite().then_some(value)
}

/// Gathers the smoothness of many windows.
#[derive(Clone, Debug, Default)]
pub(super) struct Windows {
    speed: Vec<f64>,
    sparc: Weighted,
    log_jerk: Weighted,
}

#[derive(Clone, Copy, Debug, Default)]
struct Weighted {
    sum: f64,
    weight: f64,
}

impl Weighted {
    fn add(&mut self, value: Option<f64>, weight: f64) {
        if let Some(value) = value {
            self.sum += value * weight;
            self.weight += weight;
        }
    }

    fn mean(&self) -> Option<f64> {
        (self.weight > 0.0).then(|| self.sum / self.weight)
    }
}

impl Windows {
    /// The speed of the next frame; what is missing ends the window.
    pub(super) fn push(&mut self, speed: Option<f64>, rate_hz: f64, with: &mut Smoothness) {
        match speed {
            Some(v) => self.speed.push(v),
            None => self.end(rate_hz, with),
        }
        if self.speed.len() as f64 >= WINDOW_S * rate_hz {
            self.end(rate_hz, with);
        }
    }

    /// Ends the window.
    pub(super) fn end(&mut self, rate_hz: f64, with: &mut Smoothness) {
        let weight = self.speed.len() as f64;
        let moved = self.speed.iter().any(|v| *v >= MOVING_MM_S);
        if weight >= LEAST_WINDOW_S * rate_hz && moved {
            self.sparc.add(with.sparc(&self.speed, rate_hz), weight);
            self.log_jerk.add(log_jerk(&self.speed, rate_hz), weight);
        }
        self.speed.clear();
    }

    /// Takes in the ended windows of another.
    pub(super) fn merge(&mut self, other: &Self) {
        for (mine, theirs) in [
            (&mut self.sparc, &other.sparc),
            (&mut self.log_jerk, &other.log_jerk),
        ] {
            mine.sum += theirs.sum;
            mine.weight += theirs.weight;
        }
    }

    pub(super) fn sparc(&self) -> Option<f64> {
        self.sparc.mean()
    }

    pub(super) fn log_jerk(&self) -> Option<f64> {
        self.log_jerk.mean()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bell() -> Vec<f64> {
        let at = |i: i32| -1.0 + f64::from(i) * 0.01;
        (0..200).map(|i| libm::exp(-5.0 * at(i) * at(i))).collect()
    }

    #[test]
    fn the_published_example_has_its_published_arc_length() {
        // METHOD, section 7: exp(−5t²) on [−1, 1) at 100 Hz.
        let sparc = Smoothness::default()
            .sparc(&bell(), 100.0)
            .expect("a value");
        assert!((sparc + 1.41403).abs() < 5e-6, "{sparc}");
    }

    #[test]
    fn neither_scale_nor_a_plain_sum_changes_it_and_a_tremor_makes_it_worse() {
        let mut with = Smoothness::default();
        let plain = with.sparc(&bell(), 100.0).expect("a value");
        let large: Vec<f64> = bell().iter().map(|v| 73.0 * v).collect();
        assert!((with.sparc(&large, 100.0).expect("a value") - plain).abs() < 1e-12);
        let shaky: Vec<f64> = (0..)
            .zip(bell())
            .map(|(i, v)| v + 0.2 * libm::sin(0.4 * f64::from(i)))
            .collect();
        assert!(with.sparc(&shaky, 100.0).expect("a value") < plain - 0.2);
        assert!(
            log_jerk(&shaky, 100.0).expect("a value") < log_jerk(&bell(), 100.0).expect("a value")
        );
    }

    #[test]
    fn the_spectrum_is_that_of_a_plain_sum() {
        // A direct discrete transform in place of the fast one.
        let speed: Vec<f64> = (0..50)
            .map(|i| 1.0 + libm::sin(0.3 * f64::from(i)))
            .collect();
        let (n, rate) = (64 << 4, 100.0);
        let amplitude = |k: usize| {
            let term = |i: usize| 2.0 * std::f64::consts::PI * (k * i % n) as f64 / n as f64;
            let re: f64 = speed
                .iter()
                .enumerate()
                .map(|(i, v)| v * libm::cos(term(i)))
                .sum();
            let im: f64 = speed
                .iter()
                .enumerate()
                .map(|(i, v)| v * libm::sin(term(i)))
                .sum();
            libm::hypot(re, im)
        };
        let all: Vec<f64> = (0..=n / 2).map(amplitude).collect();
        let most = all.iter().copied().fold(0.0, f64::max);
        let kept: Vec<f64> = all[..=(10.0 * n as f64 / rate) as usize]
            .iter()
            .map(|a| a / most)
            .collect();
        let last = kept.iter().rposition(|a| *a >= 0.05).expect("one");
        let arc: f64 = kept[..=last]
            .windows(2)
            .map(|p| libm::hypot(1.0 / last as f64, p[1] - p[0]))
            .sum();
        let sparc = Smoothness::default().sparc(&speed, rate).expect("a value");
        assert!((sparc + arc).abs() < 1e-9, "{sparc} {arc}");
    }

    #[test]
    fn a_minimum_jerk_movement_has_the_jerk_of_its_formula() {
        // v = 30 τ²(1−τ)²/T of unit length and time: ∫ jerk² = 720, peak 1.875; LDLJ-V = −ln(720 / 1.875²).
        let n = 20_000;
        let speed: Vec<f64> = (0..n)
            .map(|i| (f64::from(i) + 0.5) / f64::from(n))
            .map(|t| 30.0 * t * t * (1.0 - t) * (1.0 - t))
            .collect();
        let value = log_jerk(&speed, f64::from(n)).expect("a value");
        let wanted = -libm::log(720.0 / (1.875 * 1.875));
        // Two of n second differences are missing at the ends.
        assert!((value - wanted).abs() < 1e-3, "{value} {wanted}");
    }

    #[test]
    fn what_is_no_movement_has_no_smoothness() {
        let mut with = Smoothness::default();
        for speed in [&[][..], &[1.0], &[0.0; 50], &[f64::NAN; 50]] {
            assert_eq!(with.sparc(speed, 100.0), None);
            assert_eq!(log_jerk(speed, 100.0), None);
        }
        assert_eq!(with.sparc(&[1.0, 2.0], 0.0), None);
        let mut windows = Windows::default();
        for v in bell().iter().chain(&bell()) {
            windows.push(Some(100.0 * v), 100.0, &mut with);
        }
        windows.push(None, 100.0, &mut with);
        assert_eq!(windows.sparc.weight, 400.0);
    }
}
