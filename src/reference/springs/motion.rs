//! Steps in time of a lattice with friction proportional to speed: explicit (symplectic Euler) and implicit (Euler, one
//! Newton step; Baraff and Witkin 1998).

use super::lattice::Lattice;
use super::rest::{Systems, left_over};
use crate::geom::Vec3;
use crate::reference::fem::linear::SolveError;

/// N per kg mm/s²: forces are N, masses kg, lengths mm.
const MM_PER_S2: f64 = 1000.0;

/// A lattice that moves.
pub struct Motion<'a> {
    lattice: &'a Lattice,
    /// Where the points are, mm.
    pub at_mm: Vec<Vec3>,
    /// How fast they are, mm/s.
    pub velocity_mm_s: Vec<Vec3>,
    /// Friction over mass, 1/s.
    pub damping_per_s: f64,
    systems: Systems,
    scratch: Vec<Vec3>,
}

impl<'a> Motion<'a> {
    /// At rest.
    pub fn new(lattice: &'a Lattice, damping_per_s: f64) -> Self {
        Self {
            lattice,
            at_mm: lattice.rest_mm.clone(),
            velocity_mm_s: vec![Vec3::ZERO; lattice.rest_mm.len()],
            damping_per_s,
            systems: Systems::new(lattice),
            scratch: Vec::new(),
        }
    }

    /// An explicit step: stable below [`explicit_limit_s`]. A step that is not positive and finite does nothing.
    pub fn step_explicit(&mut self, forces_n: &[(usize, Vec3)], dt_s: f64) {
        if !(dt_s > 0.0 && dt_s.is_finite()) {
            return;
        }
        let left = left_over(self.lattice, &self.at_mm, forces_n, &mut self.scratch);
        let kept = 1.0 / (1.0 + self.damping_per_s * dt_s);
        let points = self.at_mm.iter_mut().zip(&mut self.velocity_mm_s);
        for ((at, v), (force, mass)) in points.zip(left.iter().zip(&self.lattice.mass_kg)) {
            if *mass > 0.0 {
                *v = (*v + *force * (MM_PER_S2 * dt_s / mass)) * kept;
                *at += *v * dt_s;
            }
        }
    }

    /// An implicit step: stable at any length, but the longer the more it damps. One that is not positive and finite, or so
    /// short that mass over its square is no number, does nothing.
    ///
    /// # Errors
    /// A matrix that cannot be factored.
    pub fn step_implicit(
        &mut self,
        forces_n: &[(usize, Vec3)],
        dt_s: f64,
    ) -> Result<(), SolveError> {
        // (M/dt² + D/dt + K) Δx = f + M v / dt.
        let inertia = (1.0 + self.damping_per_s * dt_s) / (dt_s * dt_s);
        if !(dt_s > 0.0 && dt_s.is_finite() && inertia.is_finite()) {
            return Ok(());
        }
        let mut right = left_over(self.lattice, &self.at_mm, forces_n, &mut self.scratch);
        for ((r, v), (mass, free)) in right
            .iter_mut()
            .zip(&self.velocity_mm_s)
            .zip(self.lattice.mass_kg.iter().zip(&self.lattice.free))
        {
            *r += *v * *free * (mass / MM_PER_S2 / dt_s);
        }
        let change = self
            .systems
            .solve(self.lattice, &self.at_mm, inertia, &right)?;
        for ((at, v), c) in self
            .at_mm
            .iter_mut()
            .zip(&mut self.velocity_mm_s)
            .zip(change)
        {
            *at += c;
            *v = c / dt_s;
        }
        Ok(())
    }

    /// Energy of motion and springs, N mm.
    pub fn energy_n_mm(&self) -> f64 {
        let moving = |(v, m): (&Vec3, &f64)| 0.5 * m / MM_PER_S2 * v.length_squared();
        let kinetic: f64 = self
            .velocity_mm_s
            .iter()
            .zip(&self.lattice.mass_kg)
            .map(moving)
            .sum();
        kinetic + self.lattice.energy_n_mm(&self.at_mm)
    }
}

/// Most powers taken in search of the stiffest mode.
const MOST_POWERS: usize = 20_000;

/// The longest stable explicit step, s: 2/ω of the stiffest mode, by power iteration from below (so too long, by a part in a
/// million).
pub fn explicit_limit_s(lattice: &Lattice) -> f64 {
    let n = lattice.rest_mm.len();
    // Every point its own way: no mode is left out.
    let mut x: Vec<Vec3> = (0..n)
        .map(|i| {
            let i = i as f64;
            Vec3::new(
                libm::sin(12.9 * i + 1.0),
                libm::sin(78.2 * i + 2.0),
                libm::sin(37.7 * i + 3.0),
            )
        })
        .zip(&lattice.free)
        .map(|(x, free)| x * *free)
        .collect();
    let mut omega_sq = 0.0;
    let mut settled = 0;
    for _ in 0..MOST_POWERS {
        let mut force = vec![Vec3::ZERO; n];
        for s in lattice.springs.iter().filter(|s| s.length_mm > 0.0) {
            let [a, b] = s.ends.map(|n| n as usize);
            let d = (lattice.rest_mm[b] - lattice.rest_mm[a]) / s.length_mm;
            let pull = d * (s.stiffness_n_per_mm * d.dot(x[b] - x[a]));
            force[a] += pull;
            force[b] -= pull;
        }
        // Rayleigh's quotient: off by the square of what the vector is.
        let (mut stretched, mut moved, mut largest) = (0.0, 0.0, 0.0_f64);
        for ((x, f), (m, free)) in x
            .iter_mut()
            .zip(force)
            .zip(lattice.mass_kg.iter().zip(&lattice.free))
        {
            stretched -= x.dot(f);
            moved += m / MM_PER_S2 * x.length_squared();
            *x = if *m > 0.0 {
                -f * *free * (MM_PER_S2 / m)
            } else {
                Vec3::ZERO
            };
            largest = largest.max(x.abs().max_element());
        }
        if largest <= 0.0 {
            return f64::INFINITY;
        }
        let now = stretched / moved;
        settled = if (now - omega_sq).abs() <= 1.0e-10 * now {
            settled + 1
        } else {
            0
        };
        omega_sq = now;
        if settled >= 10 {
            break;
        }
        x.iter_mut().for_each(|x| *x /= largest);
    }
    2.0 / libm::sqrt(omega_sq)
}

#[cfg(test)]
mod tests {
    use super::super::rest::tests::{SIDES, press, quarter};
    use super::super::{Lattice, Spring};
    use super::*;
    use crate::reference::Elastic;

    fn one_spring() -> Lattice {
        Lattice {
            rest_mm: vec![Vec3::ZERO, Vec3::X * 10.0],
            free: vec![Vec3::ZERO, Vec3::X],
            mass_kg: vec![0.0, 0.002],
            springs: vec![Spring {
                ends: [0, 1],
                length_mm: 10.0,
                stiffness_n_per_mm: 0.5,
            }],
        }
    }

    /// k = 500 N/m, m = 2 g: ω = 500/s, and the explicit limit 2/ω = 4 ms.
    #[test]
    fn the_limit_of_one_spring_is_two_over_omega() {
        let lattice = one_spring();
        assert!((explicit_limit_s(&lattice) - 0.004).abs() < 1e-12);
        for (share, stays) in [(0.99, true), (1.01, false)] {
            let mut motion = Motion::new(&lattice, 0.0);
            motion.at_mm[1].x += 0.1;
            for _ in 0..4000 {
                motion.step_explicit(&[], 0.004 * share);
            }
            let off = (motion.at_mm[1].x - 10.0).abs();
            assert_eq!(off < 2.0, stays, "{share}: {off}");
        }
    }

    #[test]
    fn a_swing_has_its_period() {
        let lattice = one_spring();
        let mut motion = Motion::new(&lattice, 0.0);
        motion.at_mm[1].x += 0.1;
        let period = 2.0 * std::f64::consts::PI / 500.0;
        for _ in 0..10_000 {
            motion.step_explicit(&[], period / 10_000.0);
        }
        assert!((motion.at_mm[1].x - 10.1).abs() < 1e-4);
    }

    /// Both kinds of steps end where the lattice rests, the implicit one at steps far beyond the explicit limit.
    #[test]
    fn both_come_to_rest_at_rest() {
        let slab = quarter(3);
        let lattice = Lattice::new(&slab, Elastic::MUSCLE, SIDES).unwrap();
        let load = press(&slab, 1.0);
        let rest = super::super::rest::rest(&lattice, &load)
            .unwrap()
            .displacements_mm[0];
        let limit = explicit_limit_s(&lattice);
        let mut explicit = Motion::new(&lattice, 60.0);
        for _ in 0..4000 {
            explicit.step_explicit(&load, 0.9 * limit);
        }
        let off = (explicit.at_mm[0] - lattice.rest_mm[0] - rest).length();
        assert!(off < 1e-3 * rest.length(), "explicit {off}");
        let mut implicit = Motion::new(&lattice, 60.0);
        for _ in 0..80 {
            implicit.step_implicit(&load, 20.0 * limit).unwrap();
        }
        let off = (implicit.at_mm[0] - lattice.rest_mm[0] - rest).length();
        assert!(off < 1e-3 * rest.length(), "implicit {off}");
    }

    #[test]
    fn beyond_its_limit_the_explicit_step_makes_energy() {
        let slab = quarter(3);
        let lattice = Lattice::new(&slab, Elastic::MUSCLE, SIDES).unwrap();
        let limit = explicit_limit_s(&lattice);
        let energy_after = |share: f64| {
            let mut motion = Motion::new(&lattice, 0.0);
            for (v, free) in motion.velocity_mm_s.iter_mut().zip(&lattice.free).take(40) {
                *v = Vec3::new(0.3, -0.2, 0.1) * *free;
            }
            let before = motion.energy_n_mm();
            (0..120).for_each(|_| motion.step_explicit(&[], limit * share));
            motion.energy_n_mm() / before
        };
        assert!(energy_after(0.9) < 10.0, "{}", energy_after(0.9));
        assert!(energy_after(1.1) > 100.0, "{}", energy_after(1.1));
    }
}
