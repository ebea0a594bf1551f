//! Position-based dynamics with compliance (Macklin, Müller and Chentanez 2016): the lattice's springs as constraints,
//! solved one after the other.

use super::lattice::Lattice;
use crate::geom::Vec3;

/// A lattice that moves by projection.
pub struct Xpbd<'a> {
    lattice: &'a Lattice,
    /// Where the points are, mm.
    pub at_mm: Vec<Vec3>,
    /// How fast they are, mm/s.
    pub velocity_mm_s: Vec<Vec3>,
    /// Friction over mass, 1/s.
    pub damping_per_s: f64,
    before_mm: Vec<Vec3>,
    /// Per spring.
    multipliers: Vec<f64>,
}

impl<'a> Xpbd<'a> {
    /// At rest.
    pub fn new(lattice: &'a Lattice, damping_per_s: f64) -> Self {
        Self {
            lattice,
            at_mm: lattice.rest_mm.clone(),
            velocity_mm_s: vec![Vec3::ZERO; lattice.rest_mm.len()],
            damping_per_s,
            before_mm: Vec::new(),
            multipliers: Vec::new(),
        }
    }

    /// One step in time with `iterations` sweeps over the springs. Stable at any step; too few sweeps make it too soft. A
    /// step that is not positive and finite, or so short that its square is nothing, does nothing.
    pub fn step(&mut self, forces_n: &[(usize, Vec3)], dt_s: f64, iterations: usize) {
        if !(dt_s > 0.0 && dt_s.is_finite() && dt_s * dt_s > 0.0) {
            return;
        }
        let lattice = self.lattice;
        let kept = 1.0 / (1.0 + self.damping_per_s * dt_s);
        self.before_mm.clone_from(&self.at_mm);
        // Friction takes of the speed before forces and springs add to it, or it would weaken the forces alone.
        self.velocity_mm_s.iter_mut().for_each(|v| *v *= kept);
        for (node, force) in forces_n {
            let mass = lattice.mass_kg.get(*node).copied().unwrap_or(0.0);
            if mass > 0.0 {
                self.velocity_mm_s[*node] += *force * (1000.0 * dt_s / mass);
            }
        }
        for ((at, v), free) in self
            .at_mm
            .iter_mut()
            .zip(&self.velocity_mm_s)
            .zip(&lattice.free)
        {
            *at += *v * *free * dt_s;
        }
        self.multipliers.clear();
        self.multipliers.resize(lattice.springs.len(), 0.0);
        for _ in 0..iterations {
            self.sweep(dt_s);
        }
        for ((at, before), v) in self
            .at_mm
            .iter()
            .zip(&self.before_mm)
            .zip(&mut self.velocity_mm_s)
        {
            *v = (*at - *before) / dt_s;
        }
    }

    fn sweep(&mut self, dt_s: f64) {
        let lattice = self.lattice;
        for (s, multiplier) in lattice.springs.iter().zip(&mut self.multipliers) {
            let [a, b] = s.ends.map(|n| n as usize);
            let along = self.at_mm[b] - self.at_mm[a];
            let length = along.length();
            if length <= 0.0 {
                continue;
            }
            let d = along / length;
            // Inverse masses along what is free, in mm/s² per N.
            let give = |n: usize| {
                let m = lattice.mass_kg[n];
                if m > 0.0 {
                    lattice.free[n] * (1000.0 / m)
                } else {
                    Vec3::ZERO
                }
            };
            let (ga, gb) = (give(a), give(b));
            let weight = (d * d).dot(ga + gb);
            if weight <= 0.0 {
                continue;
            }
            let compliance = 1.0 / (s.stiffness_n_per_mm * dt_s * dt_s);
            let change =
                -((length - s.length_mm) + compliance * *multiplier) / (weight + compliance);
            *multiplier += change;
            self.at_mm[a] -= ga * d * change;
            self.at_mm[b] += gb * d * change;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::rest::tests::{SIDES, press, quarter};
    use super::super::{Lattice, rest};
    use super::*;
    use crate::reference::Elastic;

    /// It rests where the springs rest, in the limit of many sweeps.
    #[test]
    fn many_sweeps_end_where_the_springs_rest() {
        let slab = quarter(3);
        let lattice = Lattice::new(&slab, Elastic::MUSCLE, SIDES).unwrap();
        let load = press(&slab, 1.0);
        let exact = rest::rest(&lattice, &load).unwrap().displacements_mm[0];
        let mut games = Xpbd::new(&lattice, 60.0);
        for _ in 0..3000 {
            games.step(&load, 2.0e-4, 4);
        }
        let found = games.at_mm[0] - lattice.rest_mm[0];
        assert!(
            (found - exact).length() < 0.01 * exact.length(),
            "{found} against {exact}"
        );
    }

    #[test]
    fn what_is_held_stays_and_everything_is_finite_at_any_step() {
        let slab = quarter(3);
        let lattice = Lattice::new(&slab, Elastic::MUSCLE, SIDES).unwrap();
        let load = press(&slab, 500.0);
        let mut games = Xpbd::new(&lattice, 5.0);
        for dt_s in [1e-5, 1e-3, 0.1, 1.0] {
            (0..20).for_each(|_| games.step(&load, dt_s, 3));
            for ((at, rest), free) in games.at_mm.iter().zip(&lattice.rest_mm).zip(&lattice.free) {
                assert!(at.is_finite());
                assert_eq!((*at - *rest) * (Vec3::ONE - *free), Vec3::ZERO);
            }
        }
    }
}
