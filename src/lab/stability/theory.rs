//! What theory says of a virtual wall: how stiff it may be so that it is passive whatever holds it, and so that it is
//! stable with one that is known.
//!
//! The wall is a spring of stiffness k, read once every T seconds; its force is held until the next one comes, and comes
//! t_d seconds after the reading. The device has a mass and viscous damping b.

use super::plant::Plant;
use nalgebra::DMatrix;

/// The stiffest passive wall, N/mm: k = (b − |B|) / (T/2 + t_d).
///
/// Colgate & Schenkel 1997 (their condition for a spring and a damper B by backward differences, b > kT/2 + |B|; a delay
/// of whole ticks in their general condition adds its time to T/2, and Gil et al. 2009 find the same line for the
/// stability of any delay that is short beside the swing). A wall that a hand is not held against belongs to it: they
/// prove it for the unilateral one. 0 where there is none.
pub fn passive_stiffness_n_per_mm(
    damping_n_s_per_mm: f64,
    period_s: f64,
    delay_s: f64,
    wall_damping_n_s_per_mm: f64,
) -> f64 {
    ((damping_n_s_per_mm - wall_damping_n_s_per_mm.abs()) / (period_s / 2.0 + delay_s)).max(0.0)
}

/// The damping that makes a wall passive, N·s/mm: b = k (T/2 + t_d) + |B|. See [`passive_stiffness_n_per_mm`].
pub fn passive_damping_n_s_per_mm(
    stiffness_n_per_mm: f64,
    period_s: f64,
    delay_s: f64,
    wall_damping_n_s_per_mm: f64,
) -> f64 {
    stiffness_n_per_mm * (period_s / 2.0 + delay_s) + wall_damping_n_s_per_mm.abs()
}

/// The stiffest wall that stays passive although positions come in steps of Δ, N/mm: k = min(2b/T, 2f/Δ) with Coulomb
/// friction f (Abbott & Okamura 2005, for prompt forces). Without steps the first alone.
pub fn passive_quantised_n_per_mm(
    damping_n_s_per_mm: f64,
    period_s: f64,
    coulomb_n: f64,
    quantum_mm: f64,
) -> f64 {
    let sampled = passive_stiffness_n_per_mm(damping_n_s_per_mm, period_s, 0.0, 0.0);
    if quantum_mm > 0.0 {
        sampled.min(2.0 * coulomb_n / quantum_mm)
    } else {
        sampled
    }
}

/// The loop of a plant without Coulomb friction and a wall that is always touched: linear, so that its stability is that of
/// a matrix.
#[derive(Clone, Debug)]
pub struct LinearLoop {
    /// From one reading to the next: position (mm), velocity (mm/s).
    motion: [[f64; 2]; 2],
    /// What the force that still holds at the reading does to them, per N, and what the one that follows it does.
    before: [f64; 2],
    after: [f64; 2],
    /// Whole ticks of the delay.
    whole: usize,
}

/// Longest delay that is told apart, ticks: a longer one counts as this.
const MOST_DELAY_TICKS: f64 = 64.0;
/// Stiffness beyond which a loop counts as stable whatever comes, N/mm.
const MOST_STIFFNESS_N_PER_MM: f64 = 1.0e9;
/// Growth per tick below which a loop counts as one that does not grow: rounding of the eigenvalues.
const ROUNDING: f64 = 1.0e-11;
/// Steps of the search for the first stiffness that is unstable.
const SCAN: f64 = 1.01;

impl LinearLoop {
    /// The loop of `plant` at a period and a delay from reading to force, ticks, whole or not.
    pub fn new(plant: &Plant, period_s: f64, delay_ticks: f64) -> Self {
        let delay = delay_ticks.clamp(0.0, MOST_DELAY_TICKS);
        let whole = libm::floor(delay);
        let part_s = (delay - whole) * period_s;
        let first = plant.stretch(part_s).rows();
        let second = plant.stretch(period_s - part_s).rows();
        let all = plant.stretch(period_s).rows();
        // The first force pushes, then the state it leaves moves on by itself.
        let through = |row: [f64; 3]| row[0] * first[0][2] + row[1] * first[1][2];
        Self {
            motion: all.map(|row| [row[0], row[1]]),
            before: second.map(through),
            after: second.map(|row| row[2]),
            whole: whole as usize,
        }
    }

    /// The matrix from one reading to the next at a stiffness of the wall. The state is position, velocity, and the
    /// positions read before as far back as their force still waits.
    fn matrix(&self, stiffness_n_per_mm: f64) -> DMatrix<f64> {
        let waiting = self.whole + 1;
        let n = 2 + waiting;
        let mut a = DMatrix::zeros(n, n);
        // Column of the position read `back` ticks ago.
        let read = |back: usize| if back == 0 { 0 } else { 1 + back };
        for i in 0..2 {
            a[(i, 0)] += self.motion[i][0];
            a[(i, 1)] += self.motion[i][1];
            a[(i, read(self.whole))] -= stiffness_n_per_mm * self.after[i];
            a[(i, read(self.whole + 1))] -= stiffness_n_per_mm * self.before[i];
        }
        for back in 1..=waiting {
            a[(read(back), read(back - 1))] = 1.0;
        }
        a
    }

    /// Largest factor by which a small motion grows within a tick; below 1 it dies away.
    pub fn growth(&self, stiffness_n_per_mm: f64) -> f64 {
        let values = self.matrix(stiffness_n_per_mm).complex_eigenvalues();
        values.iter().map(|v| v.norm()).fold(0.0, f64::max)
    }

    /// The stiffness from which on the loop is unstable, N/mm, looked for upward from `from_n_per_mm`: the smallest, to
    /// one part in 10¹⁰. `from_n_per_mm` itself where that is unstable already.
    pub fn stable_stiffness_n_per_mm(&self, from_n_per_mm: f64) -> f64 {
        let grows = |k: f64| self.growth(k) > 1.0 + ROUNDING;
        let mut good = from_n_per_mm.max(1.0e-6);
        if grows(good) {
            return good;
        }
        while !grows(good * SCAN) {
            good *= SCAN;
            if good > MOST_STIFFNESS_N_PER_MM {
                return f64::INFINITY;
            }
        }
        let mut bad = good * SCAN;
        while bad / good > 1.0 + 1.0e-10 {
            let middle = libm::sqrt(good * bad);
            if grows(middle) {
                bad = middle;
            } else {
                good = middle;
            }
        }
        good
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plant(mass_kg: f64, b: f64, k: f64) -> Plant {
        Plant {
            mass_kg,
            damping_n_s_per_mm: b,
            stiffness_n_per_mm: k,
            push_n: 0.0,
            coulomb_n: 0.0,
        }
    }

    #[test]
    fn half_a_newton_per_millimetre_needs_a_quarter_of_a_newton_second_per_metre() {
        // METHOD 7.
        let b = passive_damping_n_s_per_mm(0.5, 1e-3, 0.0, 0.0);
        assert!((b - 0.25e-3).abs() < 1e-18);
        assert!((passive_stiffness_n_per_mm(b, 1e-3, 0.0, 0.0) - 0.5).abs() < 1e-12);
        // A tick of delay takes three times the damping; damping of the wall counts against it whatever its sign.
        assert!((passive_damping_n_s_per_mm(0.5, 1e-3, 1e-3, -1e-3) - 1.75e-3).abs() < 1e-15);
        assert_eq!(passive_stiffness_n_per_mm(1e-3, 1e-3, 0.0, 2e-3), 0.0);
        // 0.03 mm steps and 0.04 N of friction: 2.67 N/mm, where damping alone would allow 10.
        let k = passive_quantised_n_per_mm(5e-3, 1e-3, 0.04, 0.03);
        assert!((k - 0.08 / 0.03).abs() < 1e-12);
        assert!((passive_quantised_n_per_mm(5e-3, 1e-3, 0.04, 0.0) - 10.0).abs() < 1e-12);
    }

    /// Colgate & Schenkel 1997, their general condition: the least damping of the device, N·s/mm, is the largest over ω
    /// of T/2 · Re{(1 − e^(−jωT)) H(e^(jωT))} / (1 − cos ωT). Here H = (k + B (1 − z⁻¹)/T) z⁻ᵈ.
    fn general(k: f64, wall_b: f64, t: f64, d: i32) -> f64 {
        let d = f64::from(d);
        let mut most = f64::NEG_INFINITY;
        for i in 1..=20_000 {
            let w = std::f64::consts::PI * f64::from(i) / 20_000.0;
            // (1 − e^(−jw)) = a + jb, H = (c + je) e^(−jwd).
            let (a, b) = (1.0 - libm::cos(w), libm::sin(w));
            let (c, e) = (k + wall_b * a / t, wall_b * b / t);
            let (re, im) = (a * c - b * e, a * e + b * c);
            let real = re * libm::cos(w * d) + im * libm::sin(w * d);
            most = most.max(t / 2.0 * real / a);
        }
        most
    }

    #[test]
    fn the_passive_line_is_the_worst_frequency_of_the_general_condition() {
        for (k, wall_b, d) in [
            (0.5, 0.0, 0),
            (3.0, 0.0, 1),
            (3.0, 0.0, 3),
            (2.0, 1e-3, 0),
            (2.0, -1e-3, 0),
        ] {
            let line = passive_damping_n_s_per_mm(k, 1e-3, 1e-3 * f64::from(d), wall_b);
            let worst = general(k, wall_b, 1e-3, d);
            assert!(
                (worst / line - 1.0).abs() < 1e-5,
                "{k} {wall_b} {d}: {worst} {line}"
            );
        }
    }

    /// The stability limit of a mass and damper under a sampled spring by Jury's test on the closed form of the held force:
    /// the smaller of the one where two eigenvalues leave the circle as a pair and the one where one leaves at −1.
    fn jury(mass_kg: f64, b: f64, t: f64) -> f64 {
        let a = b / (mass_kg / 1000.0);
        let e = libm::exp(-a * t);
        let slow = t / b + libm::expm1(-a * t) / (a * b);
        let quick = libm::expm1(-a * t).powi(2) / (a * b);
        let pair = (1.0 - e) / (quick - slow * e);
        let single = 2.0 * (1.0 + e) / (slow * (1.0 + e) - quick);
        match (pair > 0.0, single > 0.0) {
            (true, true) => pair.min(single),
            (true, false) => pair,
            _ => single,
        }
    }

    #[test]
    fn a_mass_and_damper_under_a_sampled_spring_leave_stability_where_jury_says() {
        for (mass_kg, b, t) in [
            (0.075, 2e-3, 1e-3),
            (0.075, 0.05, 1e-3),
            (0.02, 0.2, 1e-3),
            (0.5, 1e-3, 1e-2),
            (1e-3, 0.5, 1e-3),
        ] {
            let k = LinearLoop::new(&plant(mass_kg, b, 0.0), t, 0.0)
                .stable_stiffness_n_per_mm(0.5 * b / t);
            let wanted = jury(mass_kg, b, t);
            assert!(
                (k / wanted - 1.0).abs() < 1e-6,
                "{mass_kg} {b} {t}: {k}, {wanted}"
            );
            assert!(k >= passive_stiffness_n_per_mm(b, t, 0.0, 0.0) * (1.0 - 1e-9));
        }
    }

    #[test]
    fn without_damping_no_sampled_spring_is_stable_and_a_heavy_mass_has_the_passive_limit() {
        let linear = LinearLoop::new(&plant(0.1, 0.0, 0.0), 1e-3, 0.0);
        assert!(linear.growth(0.1) > 1.0);
        for delay in [0.0, 0.3, 1.0, 2.5] {
            let linear = LinearLoop::new(&plant(100.0, 1e-3, 0.0), 1e-3, delay);
            let passive = passive_stiffness_n_per_mm(1e-3, 1e-3, delay * 1e-3, 0.0);
            let k = linear.stable_stiffness_n_per_mm(0.9 * passive);
            assert!((k / passive - 1.0).abs() < 1e-3, "{delay}: {k}, {passive}");
        }
    }

    #[test]
    fn a_delay_between_ticks_lies_between_theirs() {
        let of = |delay: f64| {
            LinearLoop::new(&plant(0.1, 5e-3, 0.3), 1e-3, delay).stable_stiffness_n_per_mm(0.01)
        };
        let limits: Vec<f64> = [0.0, 0.5, 1.0, 1.5, 2.0].into_iter().map(of).collect();
        assert!(limits.windows(2).all(|w| w[1] < w[0]), "{limits:?}");
        // Almost a whole tick and a whole one are the same loop.
        assert!((of(0.999_999_9) / of(1.0) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn the_matrix_repeats_what_the_plant_does() {
        let p = plant(0.1, 5e-3, 0.3);
        let (t, k) = (1e-3, 4.0);
        let linear = LinearLoop::new(&p, t, 1.4);
        let a = linear.matrix(k);
        let mut x = nalgebra::DVector::from_vec(vec![1.0, -30.0, 0.9, 0.8]);
        let mut state = crate::lab::stability::plant::State {
            z_mm: 1.0,
            v_mm_s: -30.0,
        };
        let mut read = [1.0, 0.9, 0.8];
        for _ in 0..20 {
            state = p.advance(&p.stretch(0.4 * t), state, -k * read[2]);
            state = p.advance(&p.stretch(0.6 * t), state, -k * read[1]);
            read = [state.z_mm, read[0], read[1]];
            x = &a * x;
            assert!((x[0] - state.z_mm).abs() < 1e-10 && (x[1] - state.v_mm_s).abs() < 1e-7);
        }
    }
}
