//! A hand that holds a device: a mass with friction on a spring, pushed about by a held force.
//!
//! One coordinate, outward from the skin, mm; forces in N, positive outward. The hand holds the device rigidly, so that
//! masses, dampings and stiffnesses add:
//! ```text
//! m z″ + b z′ + f sign z′ = force − k_h (z − aim) + push
//! ```
//! Between two changes of the force the motion is solved exactly: by the matrix exponential while it slides one way, and
//! from turning point to turning point where Coulomb friction takes part.

use nalgebra::{Matrix3, Vector3};

/// A hand as felt at the tip that it holds: a mass, a damper and a spring to where the hand wants to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// Mass that moves with the tip, kg.
    pub mass_kg: f64,
    /// Damping, N·s/mm.
    pub damping_n_s_per_mm: f64,
    /// Stiffness, N/mm.
    pub stiffness_n_per_mm: f64,
}

/// Lowest and highest of [`Hand`]'s numbers: kg, N·s/mm, N/mm.
type Range = [f64; 2];

/// Ranges that hands are drawn from, rounded outward: from an index finger by itself (Hajian & Howe 1997: grams, a few
/// N·s/m, 0.2 N/mm and more, rising with force) to a hand on a stylus with its wrist (Kuchenbecker, Park & Niemeyer 2003;
/// Speich, Shao & Goldfarb 2005: 0.1 kg and more, several N·s/m, up to 1 N/mm). What lies between is drawn evenly in
/// the logarithm; the publications give no joint distribution, so the three numbers are drawn apart.
const MASS_KG: Range = [0.005, 0.2];
const DAMPING_N_S_PER_MM: Range = [0.001, 0.01];
const STIFFNESS_N_PER_MM: Range = [0.1, 1.0];

impl Hand {
    /// No hand at all: the device by itself.
    pub const NONE: Self = Self {
        mass_kg: 0.0,
        damping_n_s_per_mm: 0.0,
        stiffness_n_per_mm: 0.0,
    };

    /// The middle of the ranges, in the logarithm.
    pub fn middle() -> Self {
        Self::at([0.5; 3])
    }

    /// Number `i` of the population that belongs to `seed`: the same for the same two numbers.
    pub fn drawn(seed: u64, i: u64) -> Self {
        Self::at([0, 1, 2].map(|n| share(seed, 3 * i + n)))
    }

    /// The hand at these places, 0 … 1, of the ranges.
    fn at(shares: [f64; 3]) -> Self {
        let between = |[low, high]: Range, share: f64| low * libm::pow(high / low, share);
        Self {
            mass_kg: between(MASS_KG, shares[0]),
            damping_n_s_per_mm: between(DAMPING_N_S_PER_MM, shares[1]),
            stiffness_n_per_mm: between(STIFFNESS_N_PER_MM, shares[2]),
        }
    }
}

/// Number `n` of the stream that belongs to `seed`, 0 … 1 (SplitMix64, Steele et al. 2014).
fn share(seed: u64, n: u64) -> f64 {
    let mut x = seed.wrapping_add((n + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// What moves: hand and device together, and what pushes them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    /// Mass, kg; above 0.
    pub mass_kg: f64,
    /// Viscous damping, N·s/mm, ≥ 0.
    pub damping_n_s_per_mm: f64,
    /// Stiffness of the hand, N/mm, ≥ 0.
    pub stiffness_n_per_mm: f64,
    /// Force besides that of the wall: the pull of the hand at z = 0, N; negative pushes into the skin.
    pub push_n: f64,
    /// Coulomb friction of the device, N, ≥ 0, the same at rest as in motion.
    pub coulomb_n: f64,
}

/// Where it is and how fast it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Height above the skin, mm.
    pub z_mm: f64,
    /// Velocity, mm/s.
    pub v_mm_s: f64,
}

/// Turning points within one stretch that are followed; beyond them what is left of it is spent at rest. Each takes half a
/// swing, and a stretch is a tick at most.
const MOST_TURNS: usize = 10_000;

impl Plant {
    /// Mass in the unit that goes with N, mm and s.
    fn mass(&self) -> f64 {
        self.mass_kg / 1000.0
    }

    /// How the state and a held force lead to the state after `dt_s`, Coulomb friction left out.
    pub fn stretch(&self, dt_s: f64) -> Stretch {
        let m = self.mass();
        let (k, b) = (self.stiffness_n_per_mm / m, self.damping_n_s_per_mm / m);
        let rates = Matrix3::new(0.0, 1.0, 0.0, -k, -b, 1.0 / m, 0.0, 0.0, 0.0);
        Stretch {
            matrix: (rates * dt_s).exp(),
            dt_s,
        }
    }

    /// The state after `stretch` under a held `force_n` of the wall.
    pub fn advance(&self, stretch: &Stretch, state: State, force_n: f64) -> State {
        if self.coulomb_n > 0.0 {
            self.rub(stretch.dt_s, state, force_n)
        } else {
            stretch.apply(state, force_n + self.push_n)
        }
    }

    /// As [`Plant::advance`] with Coulomb friction: it slides one way until it stops, then sticks or turns.
    fn rub(&self, dt_s: f64, mut state: State, force_n: f64) -> State {
        let mut left_s = dt_s;
        for _ in 0..MOST_TURNS {
            if state.v_mm_s == 0.0 {
                let pull = force_n + self.push_n - self.stiffness_n_per_mm * state.z_mm;
                if pull.abs() <= self.coulomb_n {
                    return state;
                }
                state = self.slide(&mut left_s, state, force_n, pull);
            } else {
                state = self.slide(&mut left_s, state, force_n, state.v_mm_s);
            }
            if left_s <= 0.0 {
                return state;
            }
        }
        State {
            v_mm_s: 0.0,
            ..state
        }
    }

    /// Slides the way that `sense` points until it stops or the time is over.
    fn slide(&self, left_s: &mut f64, state: State, force_n: f64, sense: f64) -> State {
        let held_n = force_n + self.push_n - self.coulomb_n.copysign(sense);
        match self.stop_after(state, held_n).filter(|t| *t < *left_s) {
            Some(stop_s) => {
                *left_s -= stop_s;
                State {
                    v_mm_s: 0.0,
                    ..self.stretch(stop_s).apply(state, held_n)
                }
            }
            None => {
                let to = self.stretch(*left_s).apply(state, held_n);
                *left_s = 0.0;
                to
            }
        }
    }

    /// When the velocity is next 0 under a held force, s after now; none when it never is. Closed form: the velocity is a
    /// damped sine, a difference of two exponentials, or what lies between.
    fn stop_after(&self, state: State, held_n: f64) -> Option<f64> {
        let m = self.mass();
        let (k, b) = (self.stiffness_n_per_mm, self.damping_n_s_per_mm);
        let v = state.v_mm_s;
        let decay = b / (2.0 * m);
        // v(t) e^(decay t) starts at v with this slope.
        let slope = (held_n - b * v - k * state.z_mm) / m + decay * v;
        let squared = decay * decay - k / m;
        if squared < 0.0 {
            let omega = libm::sqrt(-squared);
            let half_turn = std::f64::consts::PI;
            let phase = match libm::atan2(-v, slope / omega) {
                _ if v == 0.0 => half_turn,
                phase if phase > 0.0 => phase,
                phase => phase + half_turn,
            };
            Some(phase / omega)
        } else if v == 0.0 {
            None
        } else if squared > 0.0 {
            let beta = libm::sqrt(squared);
            let tangent = -v * beta / slope;
            (tangent > 0.0 && tangent < 1.0).then(|| libm::atanh(tangent) / beta)
        } else {
            let t = -v / slope;
            (t > 0.0).then_some(t)
        }
    }
}

/// What a stretch of time does to a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    matrix: Matrix3<f64>,
    dt_s: f64,
}

impl Stretch {
    /// The state after it under a held force, N.
    fn apply(&self, state: State, held_n: f64) -> State {
        let to = self.matrix * Vector3::new(state.z_mm, state.v_mm_s, held_n);
        State {
            z_mm: to.x,
            v_mm_s: to.y,
        }
    }

    /// What it makes of position (mm), velocity (mm/s) and held force (N): the rows are position and velocity.
    pub fn rows(&self) -> [[f64; 3]; 2] {
        [0, 1].map(|i| [0, 1, 2].map(|j| self.matrix[(i, j)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLANT: Plant = Plant {
        mass_kg: 0.1,
        damping_n_s_per_mm: 0.002,
        stiffness_n_per_mm: 0.3,
        push_n: -1.0,
        coulomb_n: 0.0,
    };

    fn run(plant: &Plant, state: State, force_n: f64, dt_s: f64) -> State {
        plant.advance(&plant.stretch(dt_s), state, force_n)
    }

    /// The same motion by a great many small steps of the midpoint rule.
    fn by_small_steps(plant: &Plant, mut s: State, force_n: f64, dt_s: f64) -> State {
        let n = 400_000;
        let h = dt_s / f64::from(n);
        let m = plant.mass_kg / 1000.0;
        let rate = |s: State| {
            let drive = force_n + plant.push_n - plant.stiffness_n_per_mm * s.z_mm;
            let rub = if s.v_mm_s == 0.0 {
                drive.clamp(-plant.coulomb_n, plant.coulomb_n)
            } else {
                plant.coulomb_n.copysign(s.v_mm_s)
            };
            (drive - plant.damping_n_s_per_mm * s.v_mm_s - rub) / m
        };
        for _ in 0..n {
            let half = State {
                z_mm: s.z_mm + 0.5 * h * s.v_mm_s,
                v_mm_s: s.v_mm_s + 0.5 * h * rate(s),
            };
            let v = s.v_mm_s + h * rate(half);
            // A change of sign within a step: it stopped; the next step sees whether it sticks.
            let stops = plant.coulomb_n > 0.0 && v * s.v_mm_s < 0.0;
            s = State {
                z_mm: s.z_mm + h * half.v_mm_s,
                v_mm_s: if stops { 0.0 } else { v },
            };
        }
        s
    }

    #[test]
    fn a_held_force_moves_a_free_mass_along_a_parabola() {
        let free = Plant {
            damping_n_s_per_mm: 0.0,
            stiffness_n_per_mm: 0.0,
            push_n: 0.0,
            ..PLANT
        };
        let from = State {
            z_mm: 3.0,
            v_mm_s: -20.0,
        };
        let to = run(&free, from, 2.0, 0.01);
        // 2 N on 0.1 kg: 20 m/s².
        let a = 20_000.0;
        assert!((to.z_mm - (3.0 - 0.2 + 0.5 * a * 1e-4)).abs() < 1e-12);
        assert!((to.v_mm_s - (-20.0 + a * 0.01)).abs() < 1e-10);
    }

    #[test]
    fn a_damped_swing_is_the_one_of_the_closed_form() {
        let (m, b, k) = (0.1e-3, 0.002, 0.3);
        let (decay, omega) = (
            b / (2.0 * m),
            (k / m - libm::pow(b / (2.0 * m), 2.0)).sqrt(),
        );
        let at = |t: f64| {
            2.0 * libm::exp(-decay * t)
                * (libm::cos(omega * t) + decay / omega * libm::sin(omega * t))
        };
        let rest = -1.0 / k;
        let to = run(
            &PLANT,
            State {
                z_mm: rest + 2.0,
                v_mm_s: 0.0,
            },
            0.0,
            0.07,
        );
        assert!((to.z_mm - rest - at(0.07)).abs() < 1e-12, "{to:?}");
    }

    #[test]
    fn two_stretches_are_one_of_their_sum() {
        let from = State {
            z_mm: 1.0,
            v_mm_s: 50.0,
        };
        for coulomb_n in [0.0, 0.4] {
            let plant = Plant { coulomb_n, ..PLANT };
            let once = run(&plant, from, 0.7, 0.05);
            let twice = run(&plant, run(&plant, from, 0.7, 0.013), 0.7, 0.037);
            assert!((once.z_mm - twice.z_mm).abs() < 1e-11);
            assert!((once.v_mm_s - twice.v_mm_s).abs() < 1e-9);
        }
    }

    #[test]
    fn coulomb_friction_is_that_of_a_great_many_small_steps() {
        // Swinging, overdamped, free of a spring and without damping.
        let plants = [
            Plant {
                coulomb_n: 0.2,
                ..PLANT
            },
            Plant {
                coulomb_n: 0.2,
                damping_n_s_per_mm: 0.05,
                ..PLANT
            },
            Plant {
                coulomb_n: 0.2,
                stiffness_n_per_mm: 0.0,
                ..PLANT
            },
            Plant {
                coulomb_n: 1.3,
                stiffness_n_per_mm: 0.0,
                damping_n_s_per_mm: 0.0,
                ..PLANT
            },
        ];
        for plant in plants {
            for v_mm_s in [-80.0, 0.0, 120.0] {
                let from = State { z_mm: 2.0, v_mm_s };
                let (exact, small) = (
                    run(&plant, from, 0.3, 0.08),
                    by_small_steps(&plant, from, 0.3, 0.08),
                );
                assert!(
                    (exact.z_mm - small.z_mm).abs() < 2e-4,
                    "{plant:?} {exact:?} {small:?}"
                );
                assert!(
                    (exact.v_mm_s - small.v_mm_s).abs() < 2e-2,
                    "{plant:?} {exact:?} {small:?}"
                );
            }
        }
    }

    #[test]
    fn it_sticks_where_friction_holds_and_loses_the_energy_that_friction_takes() {
        let plant = Plant {
            coulomb_n: 0.2,
            damping_n_s_per_mm: 0.0,
            stiffness_n_per_mm: 0.0,
            push_n: 0.0,
            ..PLANT
        };
        // ½ m v² = f s.
        let v = 100.0;
        let to = run(
            &plant,
            State {
                z_mm: 0.0,
                v_mm_s: v,
            },
            0.0,
            1.0,
        );
        assert_eq!(to.v_mm_s, 0.0);
        assert!((to.z_mm - 0.5 * 0.1e-3 * v * v / 0.2).abs() < 1e-12);
        assert_eq!(run(&plant, to, 0.19, 1.0), to);
        assert!(run(&plant, to, 0.21, 0.01).v_mm_s > 0.0);
    }

    #[test]
    fn the_population_is_the_same_for_a_seed_and_within_its_ranges() {
        let mut masses = Vec::new();
        for i in 0..200 {
            let hand = Hand::drawn(7, i);
            assert_eq!(hand, Hand::drawn(7, i));
            assert_ne!(hand, Hand::drawn(8, i));
            let within = |x: f64, [low, high]: Range| (low..=high).contains(&x);
            assert!(within(hand.mass_kg, MASS_KG));
            assert!(within(hand.damping_n_s_per_mm, DAMPING_N_S_PER_MM));
            assert!(within(hand.stiffness_n_per_mm, STIFFNESS_N_PER_MM));
            masses.push(hand.mass_kg);
        }
        masses.sort_by(f64::total_cmp);
        let middle = Hand::middle().mass_kg;
        assert!((masses[100] / middle - 1.0).abs() < 0.35, "{}", masses[100]);
        assert!(masses[0] < 0.006 && masses[199] > 0.17);
    }
}
